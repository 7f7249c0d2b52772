//! The default potential: a GCN that sets the temperatures of a soft Bellman equation.
//!
//! ```text
//! z = T̂ relu(T̂ X W0 + b0) w1 + b1                                one number per state (eq. 5 without its softmax)
//! τ_i = T r̄ e^{clip(z_i, ±1.5)}                                    T: typical steps;  r̄: what a typical step costs
//! V_i = τ_i ln mean_c e^{Q(i, c) / τ_i},   φ = factor · V          see `soft_bellman`, `learnt_model`
//! loss = mean_{i ∈ Y} ((V_i − G_i) / (|G_i| + r̄))² + (λ / |E|) zᵀ L z
//! ```
//!
//! **The labels are returns of the agent's own experience**: G_i is what it was paid from its last visit of i in an episode to the end, averaged over its
//! latest episodes. The network learns how nearly optimal the agent acts where: it lowers the temperature where returns are those of the
//! optimal policy of the learnt model, and raises it where the agent still loses its way.
//!
//! A network whose *output* is the potential leaves false maxima between its labels. Here whatever it puts out, V lies between the mean and the best of
//! what the choices are worth on the learnt model, and the maximum principle forbids false maxima: the network can only decide
//! how fast φ falls where. Output layer and bias start at 0, so an untrained network leaves `heat` at temperature T.
//!
//! **Each fit solves, few fits train.** The solve brings every state up to date; the network is not even asked while neither it nor its features have changed. Epochs
//! are taken only while the loss is above `fit_tolerance`, and of a network that has been trained before only if its loss has grown by half since: more epochs on
//! much the same labels bring nothing. Training ends when ten epochs have lowered the loss by less than a twentieth.

mod misfit;
mod objective;
mod training;
mod warm_start;

use super::features::extended_features;
use super::network::Network;
use super::return_context::{ReturnContext, ReturnPotential};
use super::{PotentialFit, ShapingError, ShapingParams};
use crate::gcn::{
    Adam, FitStatistics, Gcn, GcnError, GcnParameters, GcnParams, GcnWorkspace, Propagation,
};
use crate::graph::StateId;
use crate::seeds::{Stream, stream};
use objective::{Finished, Objective, settled_for};
use serde::{Deserialize, Serialize};
use training::{Effort, Inputs, train};
use warm_start::WarmStart;

/// Nodes × epochs of one fit, so that a fit on 10⁵ nodes takes 30 epochs instead of 150: a bound in work, not in
/// seconds, because equal runs must give equal results.
const NODE_EPOCHS: usize = 3_000_000;

/// A trained network is trained again when its loss is this many times what training left.
const RELAPSE: f64 = 1.5;

/// The `gcn` potential. Weights, moments and the network's last output stay from fit to fit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LearnedTemperaturePotential {
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

impl LearnedTemperaturePotential {
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

    /// Up to `num_labels` of the returns.
    fn draw_labels(&self, returns: &[(StateId, f64)]) -> Vec<(StateId, f64)> {
        let mut rng = stream(self.seed, Stream::Gcn);
        rng.set_word_pos(u128::from(self.fits + 1) << 32);
        let amount = self.shaping.num_labels.min(returns.len());
        let drawn = rand::seq::index::sample(&mut rng, returns.len(), amount);
        drawn.into_iter().map(|i| returns[i]).collect()
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

impl ReturnPotential for LearnedTemperaturePotential {
    fn fit_to_returns(
        &mut self,
        context: &ReturnContext<'_>,
    ) -> Result<PotentialFit, ShapingError> {
        let unchanged = self.solve_only(context)?;
        let earlier = self.last.take().filter(|_| unchanged.is_some());
        let (statistics, solution) = match unchanged {
            Some(solved) => solved,
            None => self.ask_and_train(context)?,
        };
        self.fits += 1;
        let factor = self.shaping.scale_factor;
        let phi = solution.values.iter().map(|v| factor * v).collect();
        let checked = PotentialFit::checked(phi)?;
        self.last = Some(WarmStart::new(context, solution.z, earlier.as_ref()));
        Ok(PotentialFit {
            fit: Some(statistics),
            solve: Some(solution.statistics),
            ..checked
        })
    }
}

impl LearnedTemperaturePotential {
    /// V at the output that the network had last; none if it must be asked again or is worth training.
    fn solve_only(
        &self,
        context: &ReturnContext<'_>,
    ) -> Result<Option<(FitStatistics, Finished)>, ShapingError> {
        let last = self.last.as_ref();
        let Some(z) = last.and_then(|last| last.output(context.adjacency, context.features)) else {
            return Ok(None);
        };
        let model = settled_for(context.model, &self.shaping, z.as_ref());
        let context = ReturnContext {
            model: &model,
            ..*context
        };
        let labels = self.draw_labels(context.returns);
        let mut objective = Objective::new(&context, &self.shaping, &labels);
        let loss = objective.begin(z.as_ref())?;
        let statistics = FitStatistics {
            epochs: 0,
            initial_loss: loss,
            loss,
        };
        let effort = effort(&self.shaping, self.learnt, context.adjacency.num_nodes());
        Ok((loss <= effort.begin_above).then(|| (statistics, objective.finish())))
    }

    /// Asks the network on its present features, and trains it if that is worth it.
    fn ask_and_train(
        &mut self,
        context: &ReturnContext<'_>,
    ) -> Result<(FitStatistics, Finished), ShapingError> {
        let features = extended_features(context.features, context.adjacency);
        let propagation = Propagation::new(context.adjacency);
        let tx = propagation.apply(features.as_ref());
        let untrained = self.untrained(features.ncols());
        drop(features);
        let inputs = Inputs {
            propagation: &propagation,
            tx: tx.as_ref(),
        };
        // Not the potential's own, which the objective would borrow for as long as the network is trained.
        let shaping = self.shaping.clone();
        let labels = self.draw_labels(context.returns);
        let rate = self.gcn.learning_rate;
        let (network, is_new) = Network::prepare(&mut self.network, untrained, rate);
        if is_new {
            self.learnt = None;
        }
        let effort = effort(&shaping, self.learnt, context.adjacency.num_nodes());
        let mut workspace = GcnWorkspace::default();
        let z = network
            .gcn
            .forward(&propagation, tx.as_ref(), &mut workspace)
            .to_owned();
        let model = settled_for(context.model, &shaping, z.as_ref());
        let context = ReturnContext {
            model: &model,
            ..*context
        };
        let mut objective = Objective::new(&context, &shaping, &labels);
        let initial_loss = objective.begin(z.as_ref())?;
        let before = network.clone();
        let outcome = train(
            network,
            inputs,
            &mut workspace,
            &mut objective,
            initial_loss,
            effort,
        );
        match &outcome {
            Ok(statistics) if statistics.epochs > 0 => self.learnt = Some(statistics.loss),
            Ok(_) => {}
            Err(_) => *network = before,
        }
        Ok((outcome?, objective.finish()))
    }
}

#[cfg(test)]
mod tests;
