//! The default potential: a GCN that sets the step costs of a linearly solvable MDP.
//!
//! ```text
//! z = T̂ relu(T̂ X W0 + b0) w1 + b1                                one number per state (eq. 5 without its softmax)
//! q_i = τ c_i e^{clip(z_i, ±1.5)}                                  c_i: observed step cost in typical steps, τ = 0.7
//! u_i = e^{−q_i} Σ_j P_ij u_j,   φ ∝ ln u                          see `linearly_solvable`
//! loss = mean_{i ∈ Y} (a v_i / d_i − 1)² + (λ / |E|) zᵀ L z        v = −ln u, d = cost-to-go on the visited graph
//! ```
//!
//! A network whose *output* is the potential leaves false maxima between its labels. Here whatever it puts out, φ comes
//! from such a process with positive costs, and the maximum principle forbids false maxima: the network can only decide
//! how fast φ falls where. Output layer and bias start at 0, so an untrained network leaves the fixed costs of `heat`.
//!
//! Labels cost no further experience: Y are random states (256) that reach a goal, and d is known from the visited
//! graph.
//!
//! **Each fit solves, few fits train.** The solve begins at the last solution and brings every state up to date; the
//! network is not even asked while neither it nor its features have changed. Epochs
//! are taken only while the loss is above `fit_tolerance`, 2e-4 or 1.4 per cent of the cost-to-go, and of a network that has been trained before only if its loss has grown by half since: more epochs on
//! much the same graph bring nothing.

mod misfit;
mod objective;
mod training;
mod warm_start;

use super::features::extended_features;
use super::fit_context::{FitContext, GraphPotential};
use super::network::Network;
use super::shortest_path::ShortestPathProblem;
use super::{PotentialFit, ShapingError, ShapingParams};
use crate::gcn::{Adam, FitStatistics, Gcn, GcnError, GcnParameters, GcnParams, Propagation};
use crate::seeds::{Stream, stream};
use objective::Objective;
use serde::{Deserialize, Serialize};
use training::{Effort, Inputs, train};
use warm_start::WarmStart;

/// Nodes × epochs of one fit, so that a fit on 10⁵ nodes takes 30 epochs instead of 150: a bound in work, not in
/// seconds, because equal runs must give equal results.
const NODE_EPOCHS: usize = 3_000_000;

/// A trained network is trained again when its loss is this many times what training left.
const RELAPSE: f64 = 1.5;

/// The `gcn` potential. Weights, moments and the last solution stay from fit to fit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LearnedCostPotential {
    shaping: ShapingParams,
    gcn: GcnParams,
    seed: u64,
    /// Fits so far: each draws its labels from its own stretch of the random stream.
    fits: u64,
    network: Option<Network>,
    /// The loss that training has left; 0 for weights from elsewhere, `None` before any training.
    learnt: Option<f64>,
    last: Option<WarmStart>,
}

impl LearnedCostPotential {
    /// A potential with untrained weights drawn from `seed`. Of `gcn` it uses hidden units and learning rate.
    pub fn new(shaping: ShapingParams, gcn: GcnParams, seed: u64) -> Self {
        Self {
            shaping,
            gcn,
            seed,
            fits: 0,
            network: None,
            learnt: None,
            last: None,
        }
    }

    /// The weights fitted so far; `None` before the first fit. A plain value, to be stored or carried to another graph.
    pub fn parameters(&self) -> Option<&GcnParameters> {
        self.network
            .as_ref()
            .map(|network| network.gcn.parameters())
    }

    /// The same potential, continuing from weights that were fitted elsewhere: its next fit is a warm one
    /// (`warm_epochs`, 0 to use them as they are). They are of use only with features that mean the same here: an
    /// eigenvector of another graph has its own sign and order. With fewer columns of features than the weights were
    /// fitted to, the next fit begins anew.
    ///
    /// # Errors
    /// If the layers do not fit together, the network has more than one output, or a weight is not finite.
    pub fn with_parameters(mut self, parameters: GcnParameters) -> Result<Self, GcnError> {
        let gcn = Gcn::from_parameters(parameters)?;
        if gcn.num_outputs() != 1 {
            return Err(GcnError::Outputs {
                expected: 1,
                found: gcn.num_outputs(),
            });
        }
        if !gcn.parameters().is_finite() {
            return Err(GcnError::NotFinite { what: "weights" });
        }
        let adam = Adam::new(&gcn, self.gcn.learning_rate);
        self.network = Some(Network { gcn, adam });
        self.learnt = Some(0.0);
        Ok(self)
    }

    fn untrained(&self, features: usize) -> Gcn {
        let mut rng = stream(self.seed, Stream::Gcn);
        let mut gcn = Gcn::new(features, self.gcn.hidden_dim, 1, true, &mut rng);
        gcn.zero_output_layer();
        gcn
    }

    /// Up to `num_labels` different positions past the goals.
    fn draw_labels(&self, problem: &ShortestPathProblem) -> Vec<usize> {
        let goals = problem.chain.num_goals();
        let candidates = problem.chain.len() - goals;
        let mut rng = stream(self.seed, Stream::Gcn);
        rng.set_word_pos(u128::from(self.fits + 1) << 32);
        let amount = self.shaping.num_labels.min(candidates);
        let mut drawn = rand::seq::index::sample(&mut rng, candidates, amount).into_vec();
        drawn.sort_unstable();
        drawn.iter().map(|i| i + goals).collect()
    }
}

/// The epochs that a fit on `nodes` nodes may take, and when they are worth it, after training has left the loss `learnt`.
fn effort(shaping: &ShapingParams, learnt: Option<f64>, nodes: usize) -> Effort {
    let tolerance = shaping.fit_tolerance;
    let (epochs, relapse) = match learnt {
        None => (shaping.cold_epochs, 0.0),
        Some(learnt) => (shaping.warm_epochs, RELAPSE * learnt),
    };
    Effort {
        epochs: epochs.min((NODE_EPOCHS / nodes.max(1)).max(1)),
        begin_above: relapse.max(tolerance),
        end_at: tolerance,
    }
}

impl GraphPotential for LearnedCostPotential {
    fn fit_in(&mut self, context: &FitContext<'_>) -> Result<PotentialFit, ShapingError> {
        let labels = self.draw_labels(context.problem);
        let guess = self.last.as_ref().map(|last| last.guess(context.problem));
        // Not the potential's own, which the objective would borrow for as long as the network is trained.
        let shaping = self.shaping.clone();
        let mut objective = Objective::new(context, &shaping, labels, guess);
        self.fits += 1;
        let unchanged = self.solve_only(context, &mut objective)?;
        let earlier = self.last.take().filter(|_| unchanged.is_some());
        let statistics = match unchanged {
            Some(statistics) => statistics,
            None => self.ask_and_train(context, &mut objective)?,
        };
        let (output, solution) = objective.finish();
        let values = context.problem.potential(&solution.v, shaping.scale_factor);
        let checked = PotentialFit::checked(values)?;
        self.last = Some(WarmStart::new(context, output, &solution, earlier.as_ref()));
        Ok(PotentialFit {
            fit: Some(statistics),
            solve: Some(solution.statistics),
            ..checked
        })
    }
}

impl LearnedCostPotential {
    /// Brings v up to date with the output that the network had last; none if it must be asked again or is worth
    /// training.
    fn solve_only(
        &self,
        context: &FitContext<'_>,
        objective: &mut Objective<'_>,
    ) -> Result<Option<FitStatistics>, ShapingError> {
        let last = self.last.as_ref();
        let Some(z) = last.and_then(|last| last.output(context.adjacency, context.features)) else {
            return Ok(None);
        };
        let loss = objective.begin(z.as_ref())?;
        let statistics = FitStatistics {
            epochs: 0,
            initial_loss: loss,
            loss,
        };
        let effort = effort(&self.shaping, self.learnt, context.adjacency.num_nodes());
        Ok((loss <= effort.begin_above).then_some(statistics))
    }

    /// Asks the network on its present features, and trains it if that is worth it.
    fn ask_and_train(
        &mut self,
        context: &FitContext<'_>,
        objective: &mut Objective<'_>,
    ) -> Result<FitStatistics, ShapingError> {
        let features = extended_features(context.features, context.adjacency);
        let propagation = Propagation::new(context.adjacency);
        let tx = propagation.apply(features.as_ref());
        let inputs = Inputs {
            propagation: &propagation,
            tx: tx.as_ref(),
        };
        let untrained = self.untrained(features.ncols());
        let rate = self.gcn.learning_rate;
        let nodes = context.adjacency.num_nodes();
        let (network, is_new) = Network::prepare(&mut self.network, untrained, rate);
        if is_new {
            self.learnt = None;
        }
        let effort = effort(&self.shaping, self.learnt, nodes);
        let before = network.clone();
        let outcome = train(network, inputs, objective, effort);
        match &outcome {
            Ok(statistics) if statistics.epochs > 0 => self.learnt = Some(statistics.loss),
            Ok(_) => {}
            Err(_) => *network = before,
        }
        outcome
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shaping::fixtures::on_grid;
    use faer::Mat;

    fn potential(params: ShapingParams) -> LearnedCostPotential {
        LearnedCostPotential::new(params, GcnParams::default(), 3)
    }

    /// Every epoch there may be.
    fn to_the_end() -> ShapingParams {
        ShapingParams {
            fit_tolerance: 0.0,
            ..Default::default()
        }
    }

    #[test]
    fn training_lowers_the_loss_and_later_fits_leave_the_network_alone() {
        on_grid(8, |context| {
            let mut model = potential(to_the_end());
            let cold = model.fit_in(context).unwrap().fit.unwrap();
            assert_eq!(cold.epochs, 150);
            assert!(cold.loss < 0.9 * cold.initial_loss, "{cold:?}");
            let weights = model.parameters().cloned();
            let warm = model.fit_in(context).unwrap().fit.unwrap();
            assert_eq!(warm.epochs, 0);
            assert!(
                warm.initial_loss < RELAPSE * cold.loss,
                "{warm:?} after {cold:?}"
            );
            assert_eq!(model.parameters(), weights.as_ref());
        });
    }

    #[test]
    fn a_loss_that_has_grown_is_trained_away_again() {
        on_grid(8, |context| {
            let mut model = potential(to_the_end());
            model.fit_in(context).unwrap();
            model.learnt = model.learnt.map(|loss| loss / 2.0);
            let again = model.fit_in(context).unwrap().fit.unwrap();
            assert_eq!(again.epochs, 20);
        });
    }

    #[test]
    fn training_ends_at_the_tolerance_and_does_not_begin_below_it() {
        on_grid(8, |context| {
            let fit = |fit_tolerance| {
                let shaping = ShapingParams {
                    fit_tolerance,
                    ..Default::default()
                };
                potential(shaping).fit_in(context).unwrap().fit.unwrap()
            };
            let full = fit(0.0);
            let half = fit(0.5 * (full.initial_loss + full.loss));
            assert!(0 < half.epochs && half.epochs < 150, "{half:?}");
            assert!(full.loss < half.loss && half.loss < half.initial_loss);
            let none = fit(full.initial_loss);
            assert_eq!((none.epochs, none.loss), (0, full.initial_loss));
        });
    }

    /// The last output and the last solution only save time.
    #[test]
    fn what_is_remembered_does_not_show() {
        on_grid(8, |context| {
            let mut model = potential(to_the_end());
            model.fit_in(context).unwrap();
            let mut forgetful = model.clone();
            forgetful.last = None;
            let (warm, cold) = (
                model.fit_in(context).unwrap(),
                forgetful.fit_in(context).unwrap(),
            );
            assert!(warm.solve.unwrap().sweeps < cold.solve.unwrap().sweeps);
            for (a, b) in warm.values.iter().zip(&cold.values) {
                assert!((a - b).abs() < 1e-4, "{a} against {b}");
            }
        });
    }

    /// Carried weights give the potential that they gave where they were fitted, without an epoch.
    #[test]
    fn weights_can_be_carried_over() {
        on_grid(4, |context| {
            let mut fitted = potential(ShapingParams::default());
            assert!(fitted.parameters().is_none());
            fitted.fit_in(context).unwrap();
            let as_they_are = ShapingParams {
                warm_epochs: 0,
                ..Default::default()
            };
            let weights = fitted.parameters().unwrap().clone();
            let carry = |weights| potential(as_they_are.clone()).with_parameters(weights);
            let carried = carry(weights.clone()).unwrap().fit_in(context).unwrap();
            fitted.shaping.warm_epochs = 0;
            fitted.last = None;
            assert_eq!(carried.values, fitted.fit_in(context).unwrap().values);

            let mut rng = stream(0, Stream::Gcn);
            let two: GcnParameters = Gcn::new(4, 3, 2, true, &mut rng).into();
            assert!(matches!(
                carry(two),
                Err(GcnError::Outputs { found: 2, .. })
            ));
            let mut nan = weights;
            nan.slices_mut().next().unwrap()[0] = f64::NAN;
            assert!(matches!(carry(nan), Err(GcnError::NotFinite { .. })));
        });
    }

    #[test]
    fn untrained_it_is_the_plain_diffusion() {
        on_grid(4, |context| {
            let no_epochs = ShapingParams {
                cold_epochs: 0,
                ..Default::default()
            };
            let kept = (-no_epochs.temperature).exp();
            let scale_factor = no_epochs.scale_factor;
            let untrained = potential(no_epochs).fit_in(context).unwrap().values;
            let mut heat = super::super::heat::HeatPotential { kept, scale_factor };
            let heat = heat.fit_in(context).unwrap().values;
            for (a, b) in untrained.iter().zip(&heat) {
                assert!((a - b).abs() < 1e-5, "{a} against {b}");
            }
        });
    }

    #[test]
    fn features_with_nan_are_an_error_and_leave_the_weights() {
        on_grid(4, |context| {
            let mut model = potential(ShapingParams::default());
            model.fit_in(context).unwrap();
            let before = model.network.clone();
            let nan = Mat::full(72, 4, f64::NAN);
            let error = model
                .fit_in(&FitContext {
                    features: nan.as_ref(),
                    ..*context
                })
                .unwrap_err();
            assert!(matches!(error, ShapingError::Gcn(_)), "{error}");
            assert_eq!(model.network, before);
            assert!(model.fit_in(context).is_ok());
        });
    }

    #[test]
    fn equal_seeds_give_equal_bits() {
        on_grid(4, |context| {
            let fit = || potential(ShapingParams::default()).fit_in(context).unwrap();
            assert_eq!(fit(), fit());
        });
    }
}
