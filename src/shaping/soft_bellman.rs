//! The soft Bellman equation of a decision process, and its solver.
//!
//! ```text
//! V_i = τ_i ln Σ_c w_c e^{Q(i, c) / τ_i},   Q(i, c) = r_c + Σ_j P_cj V_j          max_c Q(i, c) at τ_i = 0
//! ```
//!
//! V_i lies between the mean of the choices and the best of them: it is what the best policy returns that pays τ_i for each nat by
//! which it departs from the prior w (Todorov 2006; Ziebart 2010). At τ = 0 it is the return-to-go of the optimal policy. Where
//! every choice has one outcome this is a linearly solvable process in e^{V/τ}.
//!
//! **Maximum principle**: V_i ≤ max_c Q(i, c) for *every* τ, so that in each state there is a choice with r + E V(s′) ≥ V(s): an agent
//! that looks one step ahead is never held up. A V whose residual is below what a step costs keeps this property.
//!
//! # How it is solved
//! By Newton's method, which here is policy iteration: with the policy π of V, the walk W that it takes and the residual r,
//!
//! ```text
//! π_c = w_c e^{(Q_c − V_i) / τ_i},   W_ij = Σ_c π_c P_cj,   r = V̂ − V,   (I − W) δ = r,   V ← V + δ
//! ```
//!
//! with V̂ the right side of the equation. That side is convex in V, so with exact steps V rises monotonically from the second iterate on,
//! wherever it began. The same matrix serves gradients: ∂V_i/∂τ_i at fixed Q is −KL(π‖w), and (I − Wᵀ) μ = ∂loss/∂V carries it back.
//!
//! # The sweep
//! Gauss–Seidel along the positions resolves all ways that only approach the ends; each step away from them must wait for the
//! next sweep. In a long corridor with a tenth of the steps leading away, news from the end would travel 14 steps a
//! sweep. What is nearly right in the old iterate is not x_j of a far neighbour but the difference x_j − x_i, so the
//! part t_i of row i's far weight is carried along with x_i:
//!
//! ```text
//! I − W = M − N,   M = diag(1 − t) − W_near,   N = W_far − diag(t)
//! M x_new = N x_old + b   forwards, nearest first;      Mᵀ x_new = Nᵀ x_old + b   backwards, farthest first
//! ```
//!
//! On a path the error then falls by a / (1 − a) a sweep, a the far weight, however long the path. Where a is large that
//! overshoots, so t ≤ 0.4; should the iteration grow or stall nevertheless, t is
//! halved, down to plain Gauss–Seidel, a regular splitting of an M-matrix, which converges.

use super::decision_process::DecisionProcess;
use crate::exponential::{exp, exp_of_four};
use serde::{Deserialize, Serialize};
use std::array::from_fn;
use std::ops::Range;

/// Relative change of δ at which a Newton step is good enough, and the sweeps it may take for that.
const STEP_TOL: f64 = 0.03;
const SWEEPS_PER_STEP: usize = 40;
/// The largest part of a row's far weight that is carried along: a / (1 − a) is 1 at ½.
const CARRY: f64 = 0.4;
/// A long Newton step that leaves more than this of the residual did not solve its system; the first ones may, for V̂ is not linear.
const STALL: f64 = 0.5;
const FREE_STEPS: usize = 4;
/// A residual below this share of the largest value is rounding.
const ROUNDING: f64 = 8.0 * f64::EPSILON;
/// A change this much larger than the smallest one seen means that the iteration grows.
const GROWTH: f64 = 4.0;

/// Cost and accuracy of a solve. Not converging is a result, not an error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SolveStatistics {
    /// Newton steps.
    pub steps: usize,
    /// Sweeps over all states, in all steps together.
    pub sweeps: usize,
    /// max_i |V̂_i − V_i|, in units of return.
    pub residual: f64,
    /// Whether the residual reached the tolerance.
    pub converged: bool,
}

impl SolveStatistics {
    /// The same, reached at the cost of `earlier` attempts, too.
    pub(super) fn after(self, earlier: Self) -> Self {
        Self {
            steps: self.steps + earlier.steps,
            sweeps: self.sweeps + earlier.sweeps,
            ..self
        }
    }
}

/// A process with its solver: the policy and walk that belong to the present V, and buffers. Vectors are by position.
#[derive(Clone, Debug)]
pub struct SoftBellman<'p> {
    process: &'p DecisionProcess,
    /// W, by entry of the process.
    weights: Vec<f64>,
    /// Σ_far W_ij.
    far_weight: Vec<f64>,
    /// V̂.
    backed_up: Vec<f64>,
    /// KL(π‖w), in nats; 0 where τ = 0.
    divergence: Vec<f64>,
    residual: Vec<f64>,
    step: Vec<f64>,
    carry: f64,
    /// b and what has flowed in so far, of the transposed sweep.
    inflow: Vec<f64>,
    /// Q, then π, of the choices of one state.
    choices: Vec<f64>,
}

/// Turns Q into π ∝ w e^{β (Q − best)}. Returns Σ w e^{β (Q − best)} and Σ π β (Q − best).
fn weigh(choices: &mut [f64], prior: &[f64], best: f64, beta: f64) -> (f64, f64) {
    let (mut total, mut mean) = (0.0, 0.0);
    for (q, w) in choices.iter_mut().zip(prior) {
        let above = (*q - best) * beta;
        *q = w * exp(above);
        total += *q;
        mean += share(*q, above);
    }
    let scale = 1.0 / total;
    choices.iter_mut().for_each(|pi| *pi *= scale);
    (total, mean * scale)
}

/// The same for as many choices as grids have, in registers: most of what a fit does.
#[inline]
fn weigh_four(choices: &mut [f64; 4], prior: &[f64; 4], best: f64, beta: f64) -> (f64, f64) {
    let above: [f64; 4] = from_fn(|c| (choices[c] - best) * beta);
    let mut weights = above;
    exp_of_four(&mut weights);
    let weights: [f64; 4] = from_fn(|c| prior[c] * weights[c]);
    let total: f64 = weights.iter().sum();
    let mean: f64 = (0..4).map(|c| share(weights[c], above[c])).sum();
    let scale = 1.0 / total;
    *choices = from_fn(|c| weights[c] * scale);
    (total, mean * scale)
}

/// weight · above, 0 where a choice is worth −∞.
#[inline]
fn share(weight: f64, above: f64) -> f64 {
    if weight > 0.0 { weight * above } else { 0.0 }
}

fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

impl<'p> SoftBellman<'p> {
    /// The equation on `process`, nothing solved yet.
    pub fn new(process: &'p DecisionProcess) -> Self {
        let zeros = vec![0.0; process.len()];
        Self {
            process,
            weights: vec![0.0; process.nnz()],
            far_weight: zeros.clone(),
            backed_up: zeros.clone(),
            divergence: zeros.clone(),
            residual: zeros.clone(),
            step: zeros,
            carry: CARRY,
            inflow: Vec::new(),
            choices: Vec::new(),
        }
    }

    /// KL(π‖w) at the V with which the last call ended, or of [`SoftBellman::follow`] began: −∂V̂_i/∂τ_i.
    pub fn divergence(&self) -> &[f64] {
        &self.divergence
    }

    /// V for temperatures `tau` ≥ 0, from nothing, to a residual of `tol`.
    ///
    /// # Panics
    /// If `tau` has not one entry per position.
    pub fn solve_cold(&mut self, tau: &[f64], tol: f64) -> (Vec<f64>, SolveStatistics) {
        let unknown = vec![f64::NAN; self.process.len()];
        let mut v = self.first_guess(tau, &unknown);
        let statistics = self.solve(tau, &mut v, tol);
        (v, statistics)
    }

    /// V from a guess, as left by a solve at other temperatures: NaN where there is none. If that leads nowhere, from nothing.
    ///
    /// # Panics
    /// If `tau` or `guess` has not one entry per position.
    pub fn solve_near(
        &mut self,
        guess: &[f64],
        tau: &[f64],
        tol: f64,
    ) -> (Vec<f64>, SolveStatistics) {
        let mut v = self.first_guess(tau, guess);
        let near = self.solve(tau, &mut v, tol);
        if near.converged {
            return (v, near);
        }
        let (v, cold) = self.solve_cold(tau, tol);
        (v, cold.after(near))
    }

    /// One pass along the positions: each takes its guess, or else what its choices are worth that lead nearer only.
    fn first_guess(&mut self, tau: &[f64], guess: &[f64]) -> Vec<f64> {
        let n = self.process.len();
        assert_eq!((tau.len(), guess.len()), (n, n), "one entry per position");
        let mut v = Vec::with_capacity(n);
        for i in 0..n {
            let value = match guess[i].is_finite() {
                true => guess[i],
                false => self.worth_of_nearer(i, tau[i], &v),
            };
            v.push(value);
        }
        v
    }

    /// V̂_i over the choices all of whose outcomes are nearer; without one, the best that a choice may lead to; without that, what the mean
    /// choice pays for ever.
    fn worth_of_nearer(&mut self, i: usize, tau: f64, v: &[f64]) -> f64 {
        let process = self.process;
        self.write_worths(i, |j| v.get(j).copied().unwrap_or(f64::NEG_INFINITY));
        if self.choices.iter().any(|q| q.is_finite()) {
            return self.soft_maximum(i, tau);
        }
        let near = process.near_range(i);
        let leads_to = near.map(|e| {
            let (choice, column) = (process.owners()[e], process.columns()[e]);
            process.reward(choice as usize) + v[column as usize]
        });
        let best = leads_to.fold(f64::NEG_INFINITY, f64::max);
        match best.is_finite() {
            true => best,
            false => process.worth_for_ever(i),
        }
    }

    /// Writes Q(i, ·) into `self.choices`, with V_j = `value(j)`.
    fn write_worths(&mut self, i: usize, value: impl Fn(usize) -> f64) {
        let process = self.process;
        let choices = process.choices_of(i);
        self.choices.clear();
        self.choices
            .extend(choices.clone().map(|c| process.reward(c)));
        for e in process.range(i) {
            let c = process.owners()[e] as usize - choices.start;
            self.choices[c] += process.probabilities()[e] * value(process.columns()[e] as usize);
        }
    }

    /// V̂_i of the Q in `self.choices`, which become π.
    fn soft_maximum(&mut self, i: usize, tau: f64) -> f64 {
        let best = largest(&self.choices);
        if tau < f64::MIN_POSITIVE {
            // All the policy's weight on the first of the best.
            let place = self.choices.iter().position(|&q| q == best);
            self.choices.fill(0.0);
            if let Some(place) = place {
                self.choices[place] = 1.0;
            }
            self.divergence[i] = 0.0;
            return best;
        }
        let prior = self.process.priors_of(i);
        let (total, mean) = match (
            <&mut [f64; 4]>::try_from(&mut self.choices[..]),
            prior.try_into(),
        ) {
            (Ok(choices), Ok(prior)) => weigh_four(choices, prior, best, 1.0 / tau),
            _ => weigh(&mut self.choices, prior, best, 1.0 / tau),
        };
        let log_total = libm::log(total);
        self.divergence[i] = (mean - log_total).max(0.0);
        best + tau * log_total
    }

    /// Sets V̂, π and W to those of `v`. O(outcomes + choices).
    fn update(&mut self, tau: &[f64], v: &[f64]) {
        let process = self.process;
        for (i, &tau) in tau.iter().enumerate() {
            self.write_worths(i, |j| v[j]);
            self.backed_up[i] = self.soft_maximum(i, tau);
            let first = process.choices_of(i).start;
            let mut far = 0.0;
            for e in process.range(i) {
                let c = process.owners()[e] as usize - first;
                self.weights[e] = self.choices[c] * process.probabilities()[e];
                if process.columns()[e] as usize > i {
                    far += self.weights[e];
                }
            }
            self.far_weight[i] = far;
        }
    }

    /// Newton steps from `v` until the residual is ≤ `tol`, or rounding. Gives up after `max_sweeps`, or when v is no longer finite.
    ///
    /// # Panics
    /// If `tau` or `v` has not one entry per position.
    fn solve(&mut self, tau: &[f64], v: &mut [f64], tol: f64) -> SolveStatistics {
        let mut statistics = SolveStatistics::default();
        let (mut before, mut was_long) = (f64::INFINITY, false);
        loop {
            self.update(tau, v);
            statistics.residual = self.set_residual(v);
            let largest = v.iter().fold(0.0_f64, |largest, v| largest.max(v.abs()));
            statistics.converged = statistics.residual <= tol.max(ROUNDING * largest);
            let stalls = was_long && statistics.residual > STALL * before;
            if stalls && statistics.steps > FREE_STEPS {
                // The iteration grows too slowly to be seen within one step.
                self.carry *= 0.5;
            }
            let hopeless =
                !statistics.residual.is_finite() || statistics.sweeps >= self.max_sweeps();
            if statistics.converged || hopeless {
                return statistics;
            }
            before = statistics.residual;
            let sweeps = self.newton_step(v, SWEEPS_PER_STEP);
            was_long = 2 * sweeps > SWEEPS_PER_STEP;
            statistics.sweeps += sweeps;
            statistics.steps += 1;
        }
    }

    /// When `solve` gives up.
    fn max_sweeps(&self) -> usize {
        2000 + self.process.len() / 32
    }

    /// One Newton step of `sweeps` sweeps for temperatures that have changed since the last call, from the v it left. The walk is that of the v before
    /// the step: next to a solution the two are the same.
    ///
    /// # Panics
    /// If `tau` or `v` has not one entry per position.
    pub fn follow(&mut self, tau: &[f64], v: &mut [f64], sweeps: usize) {
        self.update(tau, v);
        self.set_residual(v);
        self.newton_step(v, sweeps);
    }

    /// r; returns max |r|, or NaN if there is one.
    fn set_residual(&mut self, v: &[f64]) -> f64 {
        let mut largest = 0.0;
        for ((residual, backed_up), v) in self.residual.iter_mut().zip(&self.backed_up).zip(v) {
            *residual = backed_up - v;
            // Unlike f64::max this keeps a NaN.
            if residual.is_nan() || residual.abs() > largest {
                largest = residual.abs();
            }
        }
        largest
    }

    fn newton_step(&mut self, v: &mut [f64], max_sweeps: usize) -> usize {
        let (residual, mut step) = (
            std::mem::take(&mut self.residual),
            std::mem::take(&mut self.step),
        );
        step.fill(0.0);
        let sweeps = self.solve_linear(&residual, &mut step, STEP_TOL, max_sweeps);
        v.iter_mut().zip(&step).for_each(|(v, step)| *v += step);
        (self.residual, self.step) = (residual, step);
        sweeps
    }

    /// Improves `x` towards the solution of (I − W) x = b, until a sweep changes it by no more than
    /// `tol` times its largest entry, or for `max_sweeps`. Returns the number of sweeps. O(outcomes) each.
    ///
    /// # Panics
    /// If `b` or `x` has not one entry per position.
    fn solve_linear(&mut self, b: &[f64], x: &mut [f64], tol: f64, max_sweeps: usize) -> usize {
        self.iterate(b, x, tol, max_sweeps, Self::sweep)
    }

    /// The same for (I − Wᵀ) x = b.
    ///
    /// # Panics
    /// If `b` or `x` has not one entry per position.
    pub fn solve_transposed(
        &mut self,
        b: &[f64],
        x: &mut [f64],
        tol: f64,
        max_sweeps: usize,
    ) -> usize {
        self.iterate(b, x, tol, max_sweeps, Self::sweep_transposed)
    }

    fn iterate(
        &mut self,
        b: &[f64],
        x: &mut [f64],
        tol: f64,
        max_sweeps: usize,
        sweep: impl Fn(&mut Self, &[f64], &mut [f64]) -> Change,
    ) -> usize {
        let n = self.process.len();
        assert_eq!((b.len(), x.len()), (n, n), "one entry per position");
        let mut smallest = f64::INFINITY;
        for sweeps in 1..=max_sweeps {
            let change = sweep(self, b, x);
            if change.largest_step <= tol * change.largest_entry {
                return sweeps;
            }
            if change.largest_step > GROWTH * smallest {
                self.carry *= 0.5;
                smallest = f64::INFINITY;
            }
            smallest = smallest.min(change.largest_step);
        }
        max_sweeps
    }

    fn sweep(&mut self, b: &[f64], x: &mut [f64]) -> Change {
        let mut change = Change::default();
        for i in 0..x.len() {
            let range = self.process.range(i);
            let terms = self.process.columns()[range.clone()]
                .iter()
                .zip(&self.weights[range]);
            let sum: f64 = terms.map(|(&j, w)| w * x[j as usize]).sum();
            let carried = self.carried(i);
            let new = (b[i] + sum - carried * x[i]) / (1.0 - carried);
            change.note(x[i], new);
            x[i] = new;
        }
        change
    }

    fn sweep_transposed(&mut self, b: &[f64], x: &mut [f64]) -> Change {
        let mut inflow = std::mem::take(&mut self.inflow);
        inflow.clear();
        inflow.extend_from_slice(b);
        for (i, &amount) in x.iter().enumerate() {
            self.push(self.process.far_range(i), amount, &mut inflow);
        }
        let mut change = Change::default();
        for i in (0..x.len()).rev() {
            let carried = self.carried(i);
            let new = (inflow[i] - carried * x[i]) / (1.0 - carried);
            change.note(x[i], new);
            x[i] = new;
            self.push(self.process.near_range(i), new, &mut inflow);
        }
        self.inflow = inflow;
        change
    }

    /// Sends `amount` along the weights in `range`.
    fn push(&self, range: Range<usize>, amount: f64, inflow: &mut [f64]) {
        for (&j, w) in self.process.columns()[range.clone()]
            .iter()
            .zip(&self.weights[range])
        {
            inflow[j as usize] += w * amount;
        }
    }

    /// t_i.
    fn carried(&self, i: usize) -> f64 {
        self.far_weight[i].min(self.carry)
    }
}

/// The change of x in a sweep.
#[derive(Clone, Copy, Debug, Default)]
struct Change {
    largest_step: f64,
    largest_entry: f64,
}

impl Change {
    fn note(&mut self, old: f64, new: f64) {
        self.largest_step = self.largest_step.max((new - old).abs());
        self.largest_entry = self.largest_entry.max(new.abs());
    }
}

#[cfg(test)]
mod tests;
