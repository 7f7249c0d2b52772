//! Proto-value functions as features: eq. 13 of the source paper with x(s) = the state's row of the eigenvectors.
//!
//! Three things keep such features usable while the graph is still growing.
//!
//! **Scale.** Eigenvectors come at any scale (unit columns, or times √n). The matrix is divided by the root mean
//! square of its row norms, so that ‖x(s)‖² is 1 on average and a step size means what it means for a table: with
//! k = n orthonormal columns every row has norm 1, rows are orthogonal, and learning is *exactly* tabular. A row longer
//! than 1 has its step divided by ‖x(s)‖² (normalised LMS), or else a critic step of 0.7 would overshoot there.
//!
//! **States that the basis does not reach yet** share one further feature that is 1 for all of them and 0 for the rest:
//! what is learnt at the rim does not disturb what is known.
//!
//! **A basis that moves.** When a new matrix arrives, the weights are fitted to what the functions said before:
//!
//! W_new = argmin Σ_s ω_s ‖x_new(s)ᵀ W − f_old(s, ·)‖² = (Xᵀ Ω X)⁻¹ Xᵀ Ω F_old,
//!
//! ω_s = 1 where the old basis reached and 1e-6 where only the shared feature spoke. So old predictions on old states are
//! kept as well as the new basis can (if it spans them: exactly, or to about 1e-6 where new states pull the other way);
//! the rest settles the directions that they leave open.

use super::features::LinearFeatures;
use super::greedy::action;
use super::policy::clamp;
use crate::env::Action;
use crate::graph::StateId;
use faer::linalg::matmul::matmul;
use faer::prelude::Solve;
use faer::{Accum, Mat, MatRef, Par, Side};
use serde::{Deserialize, Serialize};

/// ω of states for which only the shared feature spoke: enough to settle what the others leave open, no more.
const RIM_WEIGHT: f64 = 1e-6;
/// Ridge relative to the mean diagonal of XᵀΩX: picks the smallest weights where the rows leave some open.
const RIDGE: f64 = 1e-13;

/// State features from a matrix, with one shared feature for states beyond its rows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ProtoValueFeatures {
    num_actions: usize,
    /// k, without the shared feature.
    num_features: usize,
    /// n × k, row-major, mean squared row norm 1.
    rows: Vec<f64>,
    /// min(1, 1/‖x(s)‖²) for each row.
    step_scale: Vec<f64>,
}

impl ProtoValueFeatures {
    /// No features yet: every state has the shared one.
    ///
    /// # Panics
    /// If there are no actions.
    pub fn new(num_actions: usize) -> Self {
        assert!(num_actions > 0, "an agent needs at least one action");
        ProtoValueFeatures {
            num_actions,
            num_features: 0,
            rows: Vec::new(),
            step_scale: Vec::new(),
        }
    }

    /// Number of states that have features of their own.
    pub fn num_states(&self) -> usize {
        self.step_scale.len()
    }

    /// x(s), or `None` where the state has only the shared feature.
    #[inline]
    fn row(&self, state: StateId) -> Option<&[f64]> {
        let s = state.index();
        (s < self.num_states()).then(|| &self.rows[s * self.num_features..][..self.num_features])
    }

    /// The weights of feature j: one per action. The shared feature is number `num_features`.
    #[inline]
    fn feature_weights<'a>(&self, weights: &'a [f64], j: usize) -> &'a [f64] {
        &weights[j * self.num_actions..][..self.num_actions]
    }

    /// Takes over `features`, scaled; row-major for the sake of one pass per state.
    fn assign(&mut self, features: MatRef<'_, f64>) {
        let (n, k) = (features.nrows(), features.ncols());
        let scale = 1.0 / (features.squared_norm_l2() / n as f64).sqrt();
        self.num_features = k;
        self.rows.clear();
        self.step_scale.clear();
        for s in 0..n {
            self.rows.extend((0..k).map(|j| features[(s, j)] * scale));
            let norm: f64 = self.rows[s * k..].iter().map(|x| x * x).sum();
            self.step_scale.push(1.0 / norm.max(1.0));
        }
    }

    /// f_old(s, ·) of every function side by side, n × (2 · actions), rows times √ω.
    fn old_predictions(&self, functions: &[&mut Vec<f64>; 2], n: usize) -> Mat<f64> {
        let width = self.num_actions;
        let mut predictions = Mat::zeros(n, 2 * width);
        let mut buffer = vec![0.0; width];
        for s in 0..n {
            let weight = self.row_weight(s);
            for (f, weights) in functions.iter().enumerate() {
                let values = self.values(weights, StateId(s as u32), &mut buffer);
                for (a, value) in values.iter().enumerate() {
                    predictions[(s, f * width + a)] = weight * value;
                }
            }
        }
        predictions
    }

    /// √ω_s.
    fn row_weight(&self, s: usize) -> f64 {
        if s < self.num_states() {
            1.0
        } else {
            RIM_WEIGHT.sqrt()
        }
    }
}

impl LinearFeatures for ProtoValueFeatures {
    const GENERALISES: bool = true;

    fn grow_to(&self, weights: &mut Vec<f64>, _state: StateId) {
        let end = (self.num_features + 1) * self.num_actions;
        if end > weights.len() {
            weights.resize(end, 0.0);
        }
    }

    fn values<'a>(&self, weights: &'a [f64], state: StateId, buffer: &'a mut [f64]) -> &'a [f64] {
        let Some(row) = self.row(state) else {
            return self.feature_weights(weights, self.num_features);
        };
        buffer.fill(0.0);
        for (j, &x) in row.iter().enumerate() {
            for (value, &w) in buffer.iter_mut().zip(self.feature_weights(weights, j)) {
                *value += x * w;
            }
        }
        buffer
    }

    fn value(&self, weights: &[f64], state: StateId, action: Action) -> f64 {
        let a = action.index();
        match self.row(state) {
            Some(row) => (0..)
                .zip(row)
                .map(|(j, &x)| x * self.feature_weights(weights, j)[a])
                .sum(),
            None => self.feature_weights(weights, self.num_features)[a],
        }
    }

    fn step(&self, weights: &mut [f64], state: StateId, action: Action, change: f64) {
        let (a, width) = (action.index(), self.num_actions);
        assert!(a < width, "action out of range");
        match self.row(state) {
            Some(row) => {
                let change = change * self.step_scale[state.index()];
                row.iter()
                    .enumerate()
                    .for_each(|(j, &x)| weights[j * width + a] += change * x);
            }
            None => weights[self.num_features * width + a] += change,
        }
    }

    fn step_within(
        &self,
        weights: &mut [f64],
        state: StateId,
        bound: f64,
        change: impl Fn(usize) -> f64,
    ) {
        for a in 0..self.num_actions {
            let value = self.value(weights, state, action(a));
            let target = clamp(value + change(a), bound);
            self.step(weights, state, action(a), target - value);
        }
    }

    /// Keeps the old basis if `features` is empty, all 0, or holds a number that is not finite.
    /// O(n k (k + actions)) time, O(n k) memory for a moment.
    fn set_features(&mut self, features: MatRef<'_, f64>, functions: [&mut Vec<f64>; 2]) {
        let norm = features.squared_norm_l2();
        if !norm.is_finite() || norm == 0.0 {
            return;
        }
        let (n, k, width) = (features.nrows(), features.ncols(), self.num_actions);
        for weights in functions.iter() {
            debug_assert!(weights.is_empty() || weights.len() == (self.num_features + 1) * width);
        }
        let mut functions = functions;
        functions
            .iter_mut()
            .for_each(|weights| self.grow_to(weights, StateId(0)));
        let predictions = self.old_predictions(&functions, n);
        let row_weights: Vec<f64> = (0..n).map(|s| self.row_weight(s)).collect();
        let shared = self.num_features * width;
        self.assign(features);
        let weighted = Mat::from_fn(n, k, |s, j| row_weights[s] * self.rows[s * k + j]);
        let Some(fitted) = least_squares(weighted.as_ref(), predictions.as_ref()) else {
            // Cannot happen for a finite matrix and finite weights; should weights have diverged, begin anew.
            functions
                .iter_mut()
                .for_each(|w| **w = vec![0.0; (k + 1) * width]);
            return;
        };
        for (f, weights) in functions.iter_mut().enumerate() {
            let rim = weights[shared..].to_vec();
            weights.clear();
            for j in 0..k {
                weights.extend((0..width).map(|a| fitted[(j, f * width + a)]));
            }
            weights.extend(rim);
        }
    }

    fn knows(&self, weights: &[f64], _state: StateId) -> bool {
        !weights.is_empty()
    }
}

/// argmin_W ‖X W − F‖² by normal equations with a tiny ridge; `None` if numbers are not finite.
///
/// Eigenvectors are orthonormal but for the few rows that are new, so XᵀX is well conditioned where it matters.
fn least_squares(x: MatRef<'_, f64>, f: MatRef<'_, f64>) -> Option<Mat<f64>> {
    let k = x.ncols();
    let mut gram = Mat::zeros(k, k);
    let mut right = Mat::zeros(k, f.ncols());
    // One thread: the order of summation, and so the last bit, must not depend on the machine.
    matmul(&mut gram, Accum::Replace, x.transpose(), x, 1.0, Par::Seq);
    matmul(&mut right, Accum::Replace, x.transpose(), f, 1.0, Par::Seq);
    let ridge = RIDGE * (0..k).map(|j| gram[(j, j)]).sum::<f64>() / k as f64;
    (0..k).for_each(|j| gram[(j, j)] += ridge);
    let factor = gram.llt(Side::Lower).ok()?;
    let solution = factor.solve(&right);
    solution.squared_norm_l2().is_finite().then_some(solution)
}
