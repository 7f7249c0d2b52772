//! The loss as a function of the network's output z, with its gradient.
//!
//! ```text
//! τ_i = T r̄ e^{clip(z_i)},   V: the soft Bellman equation,   loss = misfit(V) + (λ / |E|) zᵀ L z
//! (I − Wᵀ) μ = ∂misfit/∂V,   ∂loss/∂z_i = −μ_i τ_i KL(π_i‖w_i) + 2 λ/|E| (L z)_i           inside the clip
//! ```
//!
//! The rows of the process are arranged for the first z. Neither V nor μ starts over from epoch to epoch: each is followed by a few sweeps, and solved to full tolerance at both ends.

use super::misfit::Misfit;
use crate::exponential::exp;
use crate::gcn::{GcnError, Smoothness};
use crate::graph::StateId;
use crate::shaping::ShapingParams;
use crate::shaping::learnt_model::LearntModel;
use crate::shaping::return_context::ReturnContext;
use crate::shaping::soft_bellman::{SoftBellman, SolveStatistics};
use faer::MatRef;

/// Sweeps of V in an epoch.
const SWEEPS_PER_EPOCH: usize = 4;

/// Relative change at which the solve for μ stops early.
const ADJOINT_TOL: f64 = 1e-4;

/// The loss on one model: what stays the same from epoch to epoch, and the iterates that do not start over.
pub(super) struct Objective<'a> {
    model: &'a LearntModel,
    shaping: &'a ShapingParams,
    smoothness: Smoothness<'a>,
    misfit: Misfit,
    solver: SoftBellman<'a>,
    /// By state.
    z: Vec<f64>,
    /// By position, as the rest but `z_gradient` and the z of `best`.
    tau: Vec<f64>,
    v: Vec<f64>,
    statistics: SolveStatistics,
    v_gradient: Vec<f64>,
    /// μ.
    mu: Vec<f64>,
    /// By state.
    z_gradient: Vec<f64>,
    best: Best,
    /// V is not solved to full tolerance.
    has_moved: bool,
}

/// The lowest loss so far, with z (by state) and v (by position) there.
#[derive(Default)]
struct Best {
    loss: f64,
    z: Vec<f64>,
    v: Vec<f64>,
}

/// What is left of an objective: z and V by state.
pub(super) struct Finished {
    pub z: Vec<f64>,
    pub values: Vec<f64>,
    pub statistics: SolveStatistics,
}

/// `model`, arranged for sweeps at the temperatures that belong to z (n × 1).
pub(super) fn settled_for(
    model: &LearntModel,
    shaping: &ShapingParams,
    z: MatRef<'_, f64>,
) -> LearntModel {
    let mut tau = vec![0.0; model.process.len()];
    write_temperatures(model, shaping, z, &mut tau);
    model.settled_at(&tau)
}

/// Positions, ascending, and returns there.
fn positions_of(labels: &[(StateId, f64)], model: &LearntModel) -> Vec<(usize, f64)> {
    let mut positions = vec![usize::MAX; model.process.num_states()];
    for (p, &state) in model.process.order().iter().enumerate() {
        positions[state as usize] = p;
    }
    let labels = labels.iter().map(|&(s, g)| (positions[s.index()], g));
    let mut labels: Vec<_> = labels.filter(|&(p, _)| p != usize::MAX).collect();
    labels.sort_unstable_by_key(|&(position, _)| position);
    labels
}

/// τ by position.
fn write_temperatures(
    model: &LearntModel,
    shaping: &ShapingParams,
    z: MatRef<'_, f64>,
    tau: &mut [f64],
) {
    let clip = shaping.log_temperature_clip;
    let unit = shaping.temperature * model.step_reward;
    for (tau, &state) in tau.iter_mut().zip(model.process.order()) {
        *tau = unit * exp(z[(state as usize, 0)].clamp(-clip, clip));
    }
}

impl<'a> Objective<'a> {
    /// `labels`: states, and returns there; those where episodes end count for nothing.
    pub fn new(
        context: &ReturnContext<'a>,
        shaping: &'a ShapingParams,
        labels: &[(StateId, f64)],
    ) -> Self {
        let model = context.model;
        let by_position = vec![0.0; model.process.len()];
        let by_state = vec![0.0; context.adjacency.num_nodes()];
        Self {
            model,
            shaping,
            smoothness: Smoothness::new(context.adjacency),
            misfit: Misfit::new(positions_of(labels, model), model.step_reward),
            solver: SoftBellman::new(&model.process),
            z: by_state.clone(),
            tau: by_position.clone(),
            v: Vec::new(),
            statistics: SolveStatistics::default(),
            v_gradient: by_position.clone(),
            mu: by_position,
            z_gradient: by_state,
            best: Best::default(),
            has_moved: false,
        }
    }

    /// The loss at a first z (n × 1), V solved to full tolerance.
    ///
    /// # Errors
    /// If the loss is not finite.
    pub fn begin(&mut self, z: MatRef<'_, f64>) -> Result<f64, GcnError> {
        self.best.loss = f64::INFINITY;
        self.set_temperatures(z);
        self.solve();
        self.loss(0)
    }

    /// The loss at the z of epoch `epoch`, a little away from the last one.
    ///
    /// # Errors
    /// If the loss is not finite.
    pub fn follow(&mut self, z: MatRef<'_, f64>, epoch: usize) -> Result<f64, GcnError> {
        self.set_temperatures(z);
        self.has_moved = true;
        self.solver.follow(&self.tau, &mut self.v, SWEEPS_PER_EPOCH);
        self.statistics.sweeps += SWEEPS_PER_EPOCH;
        self.loss(epoch)
    }

    /// ∂loss/∂z (n × 1) at the last z, from `sweeps` sweeps.
    pub fn gradient(&mut self, sweeps: usize) -> MatRef<'_, f64> {
        let (b, mu) = (&self.v_gradient, &mut self.mu);
        self.solver.solve_transposed(b, mu, ADJOINT_TOL, sweeps);
        let order = self.model.process.order().iter();
        let places = order
            .zip(&self.tau)
            .zip(self.solver.divergence())
            .zip(&self.mu);
        for (((&state, tau), divergence), mu) in places {
            // ∂τ/∂z = τ inside the clip, 0 outside.
            if self.z[state as usize].abs() < self.shaping.log_temperature_clip {
                self.z_gradient[state as usize] -= mu * tau * divergence;
            }
        }
        MatRef::from_column_major_slice(&self.z_gradient, self.z_gradient.len(), 1)
    }

    /// z with the lowest loss, and the V that belongs to it, to full tolerance.
    pub fn finish(mut self) -> Finished {
        if self.has_moved {
            let Best { z, v, .. } = std::mem::take(&mut self.best);
            self.set_temperatures(MatRef::from_column_major_slice(&z, z.len(), 1));
            self.v = v;
            self.solve();
        }
        Finished {
            z: self.z,
            values: self.model.process.scatter(&self.v),
            statistics: self.statistics,
        }
    }

    /// Solves for the present temperatures, from what was followed if there is anything.
    fn solve(&mut self) {
        let (followed, tol) = (std::mem::take(&mut self.v), self.model.tolerance());
        let (v, statistics) = match followed.is_empty() {
            true => self.solver.solve_cold(&self.tau, tol),
            false => self.solver.solve_near(&followed, &self.tau, tol),
        };
        self.v = v;
        self.statistics = statistics.after(self.statistics);
        self.has_moved = false;
    }

    fn set_temperatures(&mut self, z: MatRef<'_, f64>) {
        self.z.clear();
        self.z.extend((0..z.nrows()).map(|i| z[(i, 0)]));
        write_temperatures(self.model, self.shaping, z, &mut self.tau);
    }

    /// The loss for the present z and V; its share of smoothness is left in `z_gradient`, that of V in `v_gradient`.
    fn loss(&mut self, epoch: usize) -> Result<f64, GcnError> {
        let weight = self.shaping.smoothness;
        let misfit = self.misfit.evaluate(&self.v, &mut self.v_gradient);
        let roughness = self.smoothness.evaluate(&self.z, 1, &mut self.z_gradient);
        self.z_gradient.iter_mut().for_each(|g| *g *= weight);
        let loss = misfit + weight * roughness;
        if !loss.is_finite() {
            return Err(GcnError::Diverged { epoch, loss });
        }
        if loss < self.best.loss {
            self.best.loss = loss;
            self.best.z.clone_from(&self.z);
            self.best.v.clone_from(&self.v);
        }
        Ok(loss)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shaping::fixtures::on_grid;
    use crate::shaping::spurious_maxima;
    use faer::Mat;

    /// The whole gradient with respect to z, against central differences.
    #[test]
    fn gradient_agrees_with_finite_differences() {
        on_grid(3, |context| {
            let shaping = ShapingParams::default();
            // Returns of an agent that loses its way here and there.
            let process = &context.model.process;
            let values = context.returns.iter().map(|&(state, g)| (state.0, g));
            let values: std::collections::BTreeMap<u32, f64> = values.collect();
            let lost = |p: usize| 1.0 + 0.7 * (p % 4) as f64;
            let labels: Vec<(StateId, f64)> = (0..process.num_reached())
                .step_by(3)
                .map(|p| (process.order()[p], lost(p)))
                .map(|(state, lost)| (StateId(state), lost * values[&state]))
                .collect();
            let mut objective = Objective::new(context, &shaping, &labels);
            let zero = Mat::zeros(72, 1);
            objective.begin(zero.as_ref()).unwrap();
            // Some entries lie beyond the clip of 1.5.
            let z: Vec<f64> = (0..72).map(|i| 1.7 * (i as f64 * 0.9).sin()).collect();
            let mut settled = |z: &[f64]| {
                let column = MatRef::from_column_major_slice(z, z.len(), 1);
                let (mut loss, mut gradient) = (0.0, Vec::new());
                for _ in 0..40 {
                    loss = objective.follow(column, 1).unwrap();
                    let column = objective.gradient(4);
                    gradient = (0..72).map(|i| column[(i, 0)]).collect();
                }
                (loss, gradient)
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
    fn a_label_where_episodes_end_tells_nothing() {
        on_grid(1, |context| {
            let labels = [(StateId(1), -1.5), (StateId(0), 5.0), (StateId(2), -2.5)];
            let order = context.model.process.order();
            let found: Vec<_> = positions_of(&labels, context.model)
                .into_iter()
                .map(|(position, g)| (order[position], g))
                .collect();
            assert_eq!(found.len(), 2);
            assert!(found.contains(&(1, -1.5)) && found.contains(&(2, -2.5)));
        });
    }

    /// Whatever the network puts out, inside the clip and far beyond it.
    #[test]
    fn wild_outputs_leave_no_false_maximum() {
        on_grid(8, |context| {
            let shaping = ShapingParams::default();
            let process = &context.model.process;
            for frequency in [0.3, 2.1, 11.7] {
                let mut objective = Objective::new(context, &shaping, &[]);
                let z = Mat::from_fn(72, 1, |i, _| 9.0 * (i as f64 * frequency).sin());
                objective.begin(z.as_ref()).unwrap();
                let clip = shaping.log_temperature_clip;
                let (low, high) = (0.5 * (-clip).exp(), 0.5 * clip.exp());
                for (tau, &state) in objective.tau.iter().zip(process.order()) {
                    let wild = 0.5 * z[(state as usize, 0)].exp();
                    assert!((tau / wild.clamp(low, high) - 1.0).abs() < 1e-12);
                }
                let solution = objective.finish();
                assert!(solution.statistics.converged);
                let phi = solution.values;
                assert_eq!(
                    spurious_maxima(&phi, context.adjacency, &[StateId(0)]),
                    vec![]
                );
            }
        });
    }

    /// What is handed back is the best that was seen, solved to the end.
    #[test]
    fn the_lowest_loss_is_kept() {
        on_grid(3, |context| {
            let shaping = ShapingParams::default();
            let places = context.model.process.order()[..60].iter().zip(0..);
            let labels: Vec<_> = places
                .map(|(&state, p)| (StateId(state), -3.0 - f64::from(p)))
                .collect();
            let mut objective = Objective::new(context, &shaping, &labels);
            let z = |size: f64| Mat::from_fn(72, 1, |i, _| size * (i as f64 * 0.2).cos());
            let losses = [0.3, 0.1, 0.6].map(|size| (size, objective.follow_or_begin(&z(size))));
            let best = losses.iter().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap().0;
            let solution = objective.finish();
            assert!(solution.statistics.converged);
            let mut alone = Objective::new(context, &shaping, &[]);
            alone.begin(z(best).as_ref()).unwrap();
            let alone = alone.finish();
            assert_eq!(solution.z, alone.z);
            for (a, b) in solution.values.iter().zip(&alone.values) {
                assert!((a - b).abs() < 1e-3, "{a} against {b}");
            }
        });
    }

    impl Objective<'_> {
        fn follow_or_begin(&mut self, z: &Mat<f64>) -> f64 {
            match self.v.is_empty() {
                true => self.begin(z.as_ref()).unwrap(),
                false => self.follow(z.as_ref(), 1).unwrap(),
            }
        }
    }
}
