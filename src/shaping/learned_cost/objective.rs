//! The loss as a function of the network's output z, and its gradient.
//!
//! ```text
//! loss(z) = misfit(v(q(z))) + (λ / |E|) zᵀ L z
//! ∂loss/∂z_i = q_i [|z_i| < clip] μ_i + (2 λ / |E|) (L z)_i,     (I − Wᵀ) μ = ∂misfit/∂v
//! ```
//!
//! The gradient through the fixed point is one solve with the transposed [controlled walk]. Between two epochs q moves
//! little: a Newton step of a few sweeps from the previous v, and a few sweeps from the previous μ, are enough. The
//! final v is solved to full tolerance.
//!
//! [controlled walk]: crate::shaping::controlled_walk

use super::misfit::Misfit;
use crate::gcn::{GcnError, Smoothness};
use crate::shaping::ShapingParams;
use crate::shaping::fit_context::FitContext;
use crate::shaping::grounded::{GroundedSolution, Guess};
use crate::shaping::linearly_solvable::LinearlySolvableMdp;
use crate::shaping::shortest_path::ShortestPathProblem;
use faer::MatRef;

/// Sweeps of v in an epoch. A sweep leaves about a tenth of the error at usual costs, and each epoch moves the solution
/// by a few per cent.
const SWEEPS_PER_EPOCH: usize = 4;

/// Relative change at which the solve for μ stops early.
const ADJOINT_TOL: f64 = 1e-4;

/// The loss on one graph: what stays the same from epoch to epoch, and the iterates that do not start over.
pub(super) struct Objective<'a> {
    problem: &'a ShortestPathProblem,
    shaping: &'a ShapingParams,
    smoothness: Smoothness<'a>,
    misfit: Misfit,
    mdp: LinearlySolvableMdp<'a>,
    guess: Option<Guess>,
    /// By state.
    z: Vec<f64>,
    /// By position, as the rest but `z_gradient` and the z of `best`.
    q: Vec<f64>,
    solution: GroundedSolution,
    v_gradient: Vec<f64>,
    /// μ, kept from epoch to epoch.
    q_gradient: Vec<f64>,
    /// By state.
    z_gradient: Vec<f64>,
    /// The lowest loss so far, and z there.
    best: (f64, Vec<f64>),
    /// v is not solved to full tolerance.
    has_moved: bool,
}

impl<'a> Objective<'a> {
    /// `labels` are positions past the goals.
    pub fn new(
        context: &FitContext<'a>,
        shaping: &'a ShapingParams,
        labels: Vec<usize>,
        guess: Option<Guess>,
    ) -> Self {
        let problem = context.problem;
        let by_position = vec![0.0; problem.chain.len()];
        let by_state = vec![0.0; context.adjacency.num_nodes()];
        Self {
            problem,
            shaping,
            smoothness: Smoothness::new(context.adjacency),
            misfit: Misfit::new(labels, &problem.distances),
            mdp: LinearlySolvableMdp::new(&problem.chain),
            guess,
            z: by_state.clone(),
            q: by_position.clone(),
            solution: GroundedSolution::default(),
            v_gradient: by_position.clone(),
            q_gradient: by_position,
            z_gradient: by_state.clone(),
            best: (f64::INFINITY, by_state),
            has_moved: false,
        }
    }

    /// The loss at a first z (n × 1), v solved to full tolerance. What was seen before is only a guess for v.
    ///
    /// # Errors
    /// If the loss is not finite.
    pub fn begin(&mut self, z: MatRef<'_, f64>) -> Result<f64, GcnError> {
        self.best.0 = f64::INFINITY;
        self.set_costs(z);
        self.solve();
        self.loss(0)
    }

    /// The loss at the z of epoch `epoch`, a little away from the last one.
    ///
    /// # Errors
    /// If the loss is not finite.
    pub fn follow(&mut self, z: MatRef<'_, f64>, epoch: usize) -> Result<f64, GcnError> {
        self.set_costs(z);
        self.has_moved = true;
        let v = &mut self.solution.v;
        self.mdp.follow(&self.q, v, SWEEPS_PER_EPOCH);
        self.solution.statistics.sweeps += SWEEPS_PER_EPOCH;
        self.loss(epoch)
    }

    /// ∂loss/∂z (n × 1) at the last z, from `sweeps` sweeps.
    pub fn gradient(&mut self, sweeps: usize) -> MatRef<'_, f64> {
        let walk = self.mdp.walk_mut();
        walk.solve_transposed(&self.v_gradient, &mut self.q_gradient, ADJOINT_TOL, sweeps);
        let order = self.problem.chain.order();
        let places = order.iter().zip(&self.q).zip(&self.q_gradient);
        for ((&state, q), mu) in places {
            // ∂q/∂z = q inside the clip, 0 outside.
            if self.z[state as usize].abs() < self.shaping.log_cost_clip {
                self.z_gradient[state as usize] += mu * q;
            }
        }
        MatRef::from_column_major_slice(&self.z_gradient, self.z_gradient.len(), 1)
    }

    /// z with the lowest loss, by state, and the v that belongs to it, to full tolerance.
    pub fn finish(mut self) -> (Vec<f64>, GroundedSolution) {
        if self.has_moved {
            let best = std::mem::take(&mut self.best.1);
            self.set_costs(MatRef::from_column_major_slice(&best, best.len(), 1));
            self.solve();
        }
        (self.z, self.solution)
    }

    /// Solves for the present costs, from what is known of v so far.
    fn solve(&mut self) {
        let before = std::mem::take(&mut self.solution);
        let guess = self.guess.take().or_else(|| before.guess());
        let (problem, mdp) = (self.problem, &mut self.mdp);
        self.solution = GroundedSolution::new(problem, mdp, &self.q, guess);
        self.solution.statistics.sweeps += before.statistics.sweeps;
        self.solution.statistics.steps += before.statistics.steps;
        self.has_moved = false;
    }

    /// q_i = τ c_i e^{clip(z_i)}.
    fn set_costs(&mut self, z: MatRef<'_, f64>) {
        self.z.clear();
        self.z.extend((0..z.nrows()).map(|i| z[(i, 0)]));
        let (tau, clip) = (self.shaping.temperature, self.shaping.log_cost_clip);
        let places = self.problem.chain.order().iter().zip(&self.problem.costs);
        for (q, (&state, cost)) in self.q.iter_mut().zip(places) {
            *q = tau * cost * libm::exp(self.z[state as usize].clamp(-clip, clip));
        }
    }

    /// The loss for the present z and v; its share of smoothness is left in `z_gradient`, that of v in `v_gradient`.
    fn loss(&mut self, epoch: usize) -> Result<f64, GcnError> {
        let weight = self.shaping.cost_smoothness;
        let misfit = self.misfit.evaluate(&self.solution.v, &mut self.v_gradient);
        let roughness = self.smoothness.evaluate(&self.z, 1, &mut self.z_gradient);
        self.z_gradient.iter_mut().for_each(|g| *g *= weight);
        let loss = misfit + weight * roughness;
        if !loss.is_finite() {
            return Err(GcnError::Diverged { epoch, loss });
        }
        if loss < self.best.0 {
            self.best.0 = loss;
            self.best.1.copy_from_slice(&self.z);
        }
        Ok(loss)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::StateId;
    use crate::shaping::fixtures::on_grid;
    use crate::shaping::spurious_maxima;
    use faer::Mat;

    /// The whole gradient with respect to z, against central differences.
    #[test]
    fn gradient_agrees_with_finite_differences() {
        on_grid(3, |context| {
            let shaping = ShapingParams::default();
            let labels: Vec<usize> = (1..context.problem.chain.len()).step_by(3).collect();
            let mut objective = Objective::new(context, &shaping, labels, None);
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

    /// Whatever the network puts out, inside the clip and far beyond it.
    #[test]
    fn wild_outputs_leave_no_false_maximum() {
        on_grid(8, |context| {
            let shaping = ShapingParams::default();
            for frequency in [0.3, 2.1, 11.7] {
                let mut objective = Objective::new(context, &shaping, vec![], None);
                let z = Mat::from_fn(72, 1, |i, _| 9.0 * (i as f64 * frequency).sin());
                objective.begin(z.as_ref()).unwrap();
                let (_, solution) = objective.finish();
                assert!(solution.statistics.converged);
                let values = context.problem.potential(&solution.v, 1.0);
                assert_eq!(
                    spurious_maxima(&values, context.adjacency, &[StateId(0)]),
                    vec![]
                );
            }
        });
    }
}
