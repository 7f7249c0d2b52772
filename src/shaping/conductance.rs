//! The default potential: a GCN that sets the local cost of a diffusion.
//!
//! ```text
//! z = T̂ relu(T̂ X W0 + b0) w1 + b1                                one number per state (eq. 5 without its softmax)
//! q_i = τ c_i e^{clip(z_i, ±1.5)}                                  c_i: observed step cost in typical steps, τ = 0.7
//! u_i = e^{−q_i} Σ_j P_ij u_j,   φ ∝ ln u                          a linearly solvable MDP, see `diffusion`
//! loss = mean_{i ∈ Y} (a v_i / d_i − 1)² + (λ / |E|) zᵀ L z        v = −ln u, d = cost-to-go on the visited graph
//! ```
//!
//! A network whose *output* is the potential leaves false maxima between its labels. Here whatever it puts out, φ comes
//! from a diffusion with positive costs, and the maximum principle forbids false maxima: the network can only decide
//! how fast φ falls where. Output layer and bias start at 0, so an untrained network is the plain diffusion.
//!
//! Labels cost no further experience: Y are random states (256) that reach a goal, and d is known from the visited
//! graph. Only the shape of v counts, since φ is scaled afterwards, so a is the best factor for the v at hand; at its
//! optimum the derivative through a vanishes. The gradient through the fixed point is one solve with
//! the transposed [controlled walk].
//!
//! Between two epochs q moves little: a Newton step of a few sweeps from the previous v, and a few from the previous λ,
//! are enough. The final v is solved anew to
//! full tolerance, from the z with the lowest loss seen.
//!
//! [controlled walk]: super::controlled_walk

use super::diffusion::Diffusion;
use super::features::extended_features;
use super::heat::{FINAL_TOL, GroundedSolution};
use super::network::Network;
use super::site::{Site, SiteModel};
use super::terrain::Terrain;
use super::{PotentialFit, ShapingError, ShapingParams};
use crate::gcn::{
    Adam, FitReport, Gcn, GcnError, GcnParameters, GcnParams, GcnWorkspace, Propagation, Smoothness,
};
use crate::seeds::{Stream, stream};
use faer::MatRef;
use serde::{Deserialize, Serialize};

/// Sweeps of v and of λ in an epoch. A sweep leaves about a tenth of the error at usual costs, and each epoch moves
/// the solution by a few per cent.
const SWEEPS_PER_EPOCH: usize = 4;

/// Sweeps of λ before the first epoch, when there is none to start from.
const FIRST_SWEEPS: usize = 40;

/// Relative change at which the solve for λ stops early.
const ADJOINT_TOL: f64 = 1e-4;

/// Nodes × epochs of one fit, so that a fit on 10⁶ nodes takes 30 epochs instead of 150: a bound in work, not in
/// seconds, because equal runs must give equal results.
const NODE_EPOCHS: usize = 30_000_000;

/// The `gcn` potential. Weights and moments stay from fit to fit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ConductancePotential {
    shaping: ShapingParams,
    gcn: GcnParams,
    seed: u64,
    /// Fits so far: each draws its labels from its own stretch of the random stream.
    fits: u64,
    network: Option<Network>,
}

impl ConductancePotential {
    /// A potential with untrained weights drawn from `seed`. Of `gcn` it uses hidden units and learning rate.
    pub fn new(shaping: ShapingParams, gcn: GcnParams, seed: u64) -> Self {
        Self {
            shaping,
            gcn,
            seed,
            fits: 0,
            network: None,
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
        Ok(self)
    }

    fn untrained(&self, features: usize) -> Gcn {
        let mut rng = stream(self.seed, Stream::Gcn);
        let mut gcn = Gcn::new(features, self.gcn.hidden_dim, 1, true, &mut rng);
        gcn.zero_output_layer();
        gcn
    }

    /// Up to `num_labels` different positions past the goals.
    fn draw_labels(&self, terrain: &Terrain) -> Vec<usize> {
        let goals = terrain.chain.num_goals();
        let candidates = terrain.chain.len() - goals;
        let mut rng = stream(self.seed, Stream::Gcn);
        rng.set_word_pos(u128::from(self.fits + 1) << 32);
        let amount = self.shaping.num_labels.min(candidates);
        let mut drawn = rand::seq::index::sample(&mut rng, candidates, amount).into_vec();
        drawn.sort_unstable();
        drawn.iter().map(|i| i + goals).collect()
    }

    fn epochs(&self, is_new: bool, nodes: usize) -> usize {
        let asked = if is_new {
            self.shaping.cold_epochs
        } else {
            self.shaping.warm_epochs
        };
        asked.min((NODE_EPOCHS / nodes.max(1)).max(1))
    }
}

impl SiteModel for ConductancePotential {
    fn fit_site(&mut self, site: &Site<'_>) -> Result<PotentialFit, ShapingError> {
        let features = extended_features(site.features, site.adjacency);
        let propagation = Propagation::new(site.adjacency);
        let tx = propagation.apply(features.as_ref());
        let untrained = self.untrained(features.ncols());
        let labels = self.draw_labels(site.terrain);
        let rate = self.gcn.learning_rate;
        let (network, is_new) =
            Network::prepare(&mut self.network, features.ncols(), rate, || untrained);
        let before = network.clone();
        let mut training = Training::new(site, &self.shaping, labels);
        let epochs = self.epochs(is_new, site.adjacency.rows());
        let network = self.network.as_mut().expect("prepared above");
        let outcome = training.run(network, &propagation, tx.as_ref(), epochs);
        self.fits += 1;
        match outcome {
            Ok(report) => training.finish(report),
            Err(error) => {
                *network = before;
                Err(error)
            }
        }
    }
}

/// One fit: what stays the same from epoch to epoch, and the iterates that do not start over.
struct Training<'a> {
    terrain: &'a Terrain,
    shaping: &'a ShapingParams,
    smoothness: Smoothness<'a>,
    /// Y, as positions.
    labels: Vec<usize>,
    diffusion: Diffusion<'a>,
    /// By position.
    q: Vec<f64>,
    v: Vec<f64>,
    v_gradient: Vec<f64>,
    /// λ, kept from epoch to epoch.
    q_gradient: Vec<f64>,
    /// dloss/dz by state, n × 1.
    z_gradient: Vec<f64>,
    sweeps: usize,
    /// The lowest loss so far, and q there.
    best: (f64, Vec<f64>),
}

impl<'a> Training<'a> {
    fn new(site: &Site<'a>, shaping: &'a ShapingParams, labels: Vec<usize>) -> Self {
        let terrain = site.terrain;
        let positions = terrain.chain.len();
        let mut diffusion = Diffusion::new(&terrain.chain);
        let q: Vec<f64> = terrain
            .costs
            .iter()
            .map(|c| shaping.temperature * c)
            .collect();
        let plain = GroundedSolution::new(terrain, &mut diffusion, &q);
        Self {
            terrain,
            shaping,
            smoothness: Smoothness::new(site.adjacency),
            labels,
            diffusion,
            q_gradient: vec![0.0; positions],
            best: (f64::INFINITY, q.clone()),
            q,
            v: plain.v,
            v_gradient: vec![0.0; positions],
            z_gradient: vec![0.0; site.adjacency.rows()],
            sweeps: plain.report.sweeps,
        }
    }

    fn run(
        &mut self,
        network: &mut Network,
        propagation: &Propagation,
        tx: MatRef<'_, f64>,
        epochs: usize,
    ) -> Result<FitReport, ShapingError> {
        let mut workspace = GcnWorkspace::default();
        let z = network.gcn.forward(propagation, tx, &mut workspace);
        let initial_loss = self.evaluate(z, 0)?;
        let mut report = FitReport {
            epochs,
            initial_loss,
            loss: initial_loss,
        };
        let mut gradient = network.gcn.parameters().zeros_like();
        for epoch in 1..=epochs {
            let output =
                MatRef::from_column_major_slice(&self.z_gradient, self.z_gradient.len(), 1);
            network
                .gcn
                .backward_into(propagation, tx, &mut workspace, output, &mut gradient);
            network.adam.step(&mut network.gcn, &gradient);
            let z = network.gcn.forward(propagation, tx, &mut workspace);
            report.loss = self.evaluate(z, epoch)?;
        }
        report.loss = report.loss.min(self.best.0);
        Ok(report)
    }

    /// The loss at z (n × 1), its gradient in `z_gradient`, and q and v that belong to it.
    fn evaluate(&mut self, z: MatRef<'_, f64>, epoch: usize) -> Result<f64, GcnError> {
        let z: Vec<f64> = (0..z.nrows()).map(|i| z[(i, 0)]).collect();
        self.set_costs(&z);
        if epoch == 0 {
            let report = self.diffusion.solve(&self.q, &mut self.v, FINAL_TOL);
            self.sweeps += report.sweeps;
        } else {
            self.diffusion
                .follow(&self.q, &mut self.v, SWEEPS_PER_EPOCH);
            self.sweeps += SWEEPS_PER_EPOCH;
        }
        let fit = self.fit_loss();
        let smoothness = self.smoothness.evaluate(&z, 1, &mut self.z_gradient);
        let weight = self.shaping.cost_smoothness;
        self.z_gradient.iter_mut().for_each(|g| *g *= weight);
        self.add_fit_gradient(
            &z,
            if epoch == 0 {
                FIRST_SWEEPS
            } else {
                SWEEPS_PER_EPOCH
            },
        );
        let loss = fit + weight * smoothness;
        if !loss.is_finite() {
            return Err(GcnError::Diverged { epoch, loss });
        }
        if loss < self.best.0 {
            self.best.0 = loss;
            self.best.1.copy_from_slice(&self.q);
        }
        Ok(loss)
    }

    /// q_i = τ c_i e^{clip(z_i)}.
    fn set_costs(&mut self, z: &[f64]) {
        let (tau, clip) = (self.shaping.temperature, self.shaping.log_cost_clip);
        let places = self.terrain.chain.order().iter().zip(&self.terrain.costs);
        for (q, (&state, cost)) in self.q.iter_mut().zip(places) {
            *q = tau * cost * z[state as usize].clamp(-clip, clip).exp();
        }
    }

    /// mean (a v/d − 1)² with the best a, and its gradient with respect to v.
    fn fit_loss(&mut self) -> f64 {
        self.v_gradient.fill(0.0);
        if self.labels.is_empty() {
            return 0.0;
        }
        let ratio = |&i: &usize| self.v[i] / self.terrain.distances[i];
        let (sum, squares) = self
            .labels
            .iter()
            .map(ratio)
            .fold((0.0, 0.0), |(s, q), x| (s + x, q + x * x));
        let factor = sum / squares;
        let count = self.labels.len() as f64;
        let mut loss = 0.0;
        for &i in &self.labels {
            let error = factor * self.v[i] / self.terrain.distances[i] - 1.0;
            loss += error * error / count;
            self.v_gradient[i] = 2.0 * error * factor / self.terrain.distances[i] / count;
        }
        loss
    }

    /// Adds dq/dz · dloss/dq; dq/dz = q inside the clip, 0 outside.
    fn add_fit_gradient(&mut self, z: &[f64], sweeps: usize) {
        self.diffusion.walk_mut().solve_transposed(
            &self.v_gradient,
            &mut self.q_gradient,
            ADJOINT_TOL,
            sweeps,
        );
        let places = self
            .terrain
            .chain
            .order()
            .iter()
            .zip(&self.q)
            .zip(&self.q_gradient);
        for ((&state, q), lambda) in places {
            if z[state as usize].abs() < self.shaping.log_cost_clip {
                self.z_gradient[state as usize] += lambda * q;
            }
        }
    }

    fn finish(mut self, fit: FitReport) -> Result<PotentialFit, ShapingError> {
        let solution = GroundedSolution::new(self.terrain, &mut self.diffusion, &self.best.1);
        let values = self
            .terrain
            .potential(&solution.v, self.shaping.scale_factor);
        let mut solve = solution.report;
        solve.sweeps += self.sweeps;
        let checked = PotentialFit::checked(values)?;
        Ok(PotentialFit {
            fit: Some(fit),
            solve: Some(solve),
            ..checked
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::StateId;
    use crate::shaping::fixtures::grid;
    use crate::shaping::spurious_maxima;
    use crate::shaping::successors::Successors;
    use faer::Mat;

    fn potential(params: ShapingParams) -> ConductancePotential {
        ConductancePotential::new(params, GcnParams::default(), 3)
    }

    /// Calls `check` with a site on a 9 × 8 grid with two walls, goal in a corner.
    fn on_grid(features: usize, check: impl FnOnce(&Site<'_>)) {
        let adjacency = grid(9, 8, &[17, 18, 19, 44, 45]);
        let terrain = Terrain::uniform(&Successors::undirected(&adjacency).unwrap(), &[StateId(0)]);
        let features = Mat::from_fn(72, features, |i, c| {
            ((i * (c + 2) * 37) % 29) as f64 / 14.0 - 1.0
        });
        let features = features.as_ref();
        check(&Site {
            terrain: &terrain,
            adjacency: &adjacency,
            features,
            labels: &[],
        });
    }

    /// The whole gradient with respect to z, against central differences.
    #[test]
    fn gradient_agrees_with_finite_differences() {
        on_grid(3, |site| {
            let shaping = ShapingParams::default();
            let labels: Vec<usize> = (1..site.terrain.chain.len()).step_by(3).collect();
            let mut training = Training::new(site, &shaping, labels);
            // Some entries lie beyond the clip of 1.5.
            let z: Vec<f64> = (0..72).map(|i| 1.7 * (i as f64 * 0.9).sin()).collect();
            let mut settled = |z: &[f64]| {
                let column = MatRef::from_column_major_slice(z, z.len(), 1);
                let mut loss = 0.0;
                (0..40).for_each(|_| loss = training.evaluate(column, 1).unwrap());
                (loss, training.z_gradient.clone())
            };
            let (_, gradient) = settled(&z);
            let largest = gradient.iter().fold(0.0_f64, |m, g| m.max(g.abs()));
            for i in (0..72).filter(|i| (z[*i].abs() - 1.5).abs() > 1e-3) {
                let mut shifted = |step: f64| {
                    let mut z = z.clone();
                    z[i] += step;
                    settled(&z).0
                };
                let expected = (shifted(1e-5) - shifted(-1e-5)) / 2e-5;
                let error = (gradient[i] - expected).abs() / largest;
                assert!(error < 1e-6, "z_{i}: {} against {expected}", gradient[i]);
            }
        });
    }

    #[test]
    fn training_lowers_the_loss_and_warm_fits_begin_where_it_ended() {
        on_grid(8, |site| {
            let mut model = potential(ShapingParams::default());
            let cold = model.fit_site(site).unwrap().fit.unwrap();
            assert_eq!(cold.epochs, 150);
            assert!(cold.loss < 0.9 * cold.initial_loss, "{cold:?}");
            let warm = model.fit_site(site).unwrap().fit.unwrap();
            assert_eq!(warm.epochs, 20);
            assert!(
                warm.initial_loss < 2.0 * cold.loss,
                "{warm:?} after {cold:?}"
            );
        });
    }

    /// Carried weights give the potential that they gave where they were fitted, without an epoch.
    #[test]
    fn weights_can_be_carried_over() {
        on_grid(4, |site| {
            let mut fitted = potential(ShapingParams::default());
            assert!(fitted.parameters().is_none());
            fitted.fit_site(site).unwrap();
            let as_they_are = ShapingParams {
                warm_epochs: 0,
                ..Default::default()
            };
            let weights = fitted.parameters().unwrap().clone();
            let carry = |weights| potential(as_they_are.clone()).with_parameters(weights);
            let carried = carry(weights.clone()).unwrap().fit_site(site).unwrap();
            fitted.shaping.warm_epochs = 0;
            assert_eq!(carried.values, fitted.fit_site(site).unwrap().values);

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
        on_grid(4, |site| {
            let no_epochs = ShapingParams {
                cold_epochs: 0,
                ..Default::default()
            };
            let kept = (-no_epochs.temperature).exp();
            let scale_factor = no_epochs.scale_factor;
            let untrained = potential(no_epochs).fit_site(site).unwrap().values;
            let mut heat = super::super::heat::HeatPotential { kept, scale_factor };
            let heat = heat.fit_site(site).unwrap().values;
            for (a, b) in untrained.iter().zip(&heat) {
                assert!((a - b).abs() < 1e-6, "{a} against {b}");
            }
        });
    }

    /// Whatever the network puts out, inside the clip and far beyond it.
    #[test]
    fn wild_outputs_leave_no_false_maximum() {
        on_grid(8, |site| {
            let shaping = ShapingParams::default();
            for frequency in [0.3, 2.1, 11.7] {
                let mut training = Training::new(site, &shaping, vec![]);
                let z: Vec<f64> = (0..72)
                    .map(|i| 9.0 * (i as f64 * frequency).sin())
                    .collect();
                training.set_costs(&z);
                training.best.1.copy_from_slice(&training.q);
                let report = FitReport {
                    epochs: 0,
                    initial_loss: 0.0,
                    loss: 0.0,
                };
                let fit = training.finish(report).unwrap();
                assert!(fit.solve.unwrap().converged);
                assert_eq!(
                    spurious_maxima(&fit.values, site.adjacency, &[StateId(0)]),
                    vec![]
                );
            }
        });
    }

    #[test]
    fn features_with_nan_are_an_error_and_leave_the_weights() {
        on_grid(4, |site| {
            let mut model = potential(ShapingParams::default());
            model.fit_site(site).unwrap();
            let before = model.network.clone();
            let nan = Mat::full(72, 4, f64::NAN);
            let error = model
                .fit_site(&Site {
                    features: nan.as_ref(),
                    ..*site
                })
                .unwrap_err();
            assert!(matches!(error, ShapingError::Gcn(_)), "{error}");
            assert_eq!(model.network, before);
            assert!(model.fit_site(site).is_ok());
        });
    }

    #[test]
    fn equal_seeds_give_equal_bits() {
        on_grid(4, |site| {
            let fit = || potential(ShapingParams::default()).fit_site(site).unwrap();
            assert_eq!(fit(), fit());
        });
    }
}
