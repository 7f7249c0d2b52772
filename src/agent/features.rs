//! Features that the actor and the critic are linear in.
//!
//! f(s, a) = wᵀφ(s, a)  (eq. 13 of the source paper), with the state's features x(s) stacked per action: the block of
//! action a holds x(s), all others 0. So w is a matrix of one column per action, f(s, a) = x(s)ᵀ w_a, and
//! ∇_w f(s, a) is x(s) in column a.
//!
//! Two kinds stand behind [`LinearFeatures`]: [`Tabular`], where x(s) is the indicator of s and w_a(s) *is* f(s, a), so
//! that no product is ever taken; and [`ProtoValueFeatures`](super::ProtoValueFeatures), where x(s) are the
//! state's entries of the low eigenvectors.

use super::policy::clamp;
use crate::env::Action;
use crate::graph::StateId;
use serde::{Deserialize, Serialize};

/// The features of a linear function of (state, action). Weights are held by the caller, one `Vec` per function.
pub trait LinearFeatures {
    /// Whether a step at one state moves the function at other states too.
    const GENERALISES: bool;

    /// Prepares `weights` for `state`, new functions being 0. Amortised O(actions) a state.
    fn grow_to(&self, weights: &mut Vec<f64>, state: StateId);

    /// f(state, ·), one number per action: a view of `weights` or, computed, of `buffer`.
    ///
    /// # Panics
    /// If `weights` were not prepared for `state`, or `buffer` does not have one place per action.
    fn values<'a>(&self, weights: &'a [f64], state: StateId, buffer: &'a mut [f64]) -> &'a [f64];

    /// f(state, action) alone.
    ///
    /// # Panics
    /// As [`LinearFeatures::values`], and if `action` is out of range.
    fn value(&self, weights: &[f64], state: StateId, action: Action) -> f64;

    /// w ← w + `change` · ∇f(state, action), shortened where that would move f(state, action) by more than `change`.
    ///
    /// # Panics
    /// As [`LinearFeatures::value`].
    fn step(&self, weights: &mut [f64], state: StateId, action: Action, change: f64);

    /// Moves f(state, ·) by `change(action)` for every action as [`LinearFeatures::step`] does, but no further than to
    /// ±`bound`; what was beyond is brought back to it.
    ///
    /// # Panics
    /// As [`LinearFeatures::value`].
    fn step_within(
        &self,
        weights: &mut [f64],
        state: StateId,
        bound: f64,
        change: impl Fn(usize) -> f64,
    );

    /// A new matrix of state features, n × k; every function in `functions` is re-expressed in it.
    fn set_features(&mut self, _features: faer::MatRef<'_, f64>, _functions: [&mut Vec<f64>; 2]) {}

    /// Whether `state` has weights of its own already.
    fn knows(&self, weights: &[f64], state: StateId) -> bool;
}

/// One number per (state, action).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tabular {
    num_actions: usize,
}

impl Tabular {
    /// Tables of `num_actions` numbers a state.
    ///
    /// # Panics
    /// If there are no actions.
    pub fn new(num_actions: usize) -> Self {
        assert!(num_actions > 0, "an agent needs at least one action");
        Tabular { num_actions }
    }

    #[inline]
    fn place(&self, state: StateId, action: Action) -> usize {
        assert!(action.index() < self.num_actions, "action out of range");
        state.index() * self.num_actions + action.index()
    }
}

impl LinearFeatures for Tabular {
    const GENERALISES: bool = false;

    #[inline]
    fn grow_to(&self, weights: &mut Vec<f64>, state: StateId) {
        let end = (state.index() + 1) * self.num_actions;
        if end > weights.len() {
            weights.resize(end, 0.0);
        }
    }

    #[inline]
    fn values<'a>(&self, weights: &'a [f64], state: StateId, _buffer: &'a mut [f64]) -> &'a [f64] {
        &weights[state.index() * self.num_actions..][..self.num_actions]
    }

    #[inline]
    fn value(&self, weights: &[f64], state: StateId, action: Action) -> f64 {
        weights[self.place(state, action)]
    }

    #[inline]
    fn step(&self, weights: &mut [f64], state: StateId, action: Action, change: f64) {
        weights[self.place(state, action)] += change;
    }

    #[inline]
    fn step_within(
        &self,
        weights: &mut [f64],
        state: StateId,
        bound: f64,
        change: impl Fn(usize) -> f64,
    ) {
        let row = &mut weights[state.index() * self.num_actions..][..self.num_actions];
        row.iter_mut()
            .enumerate()
            .for_each(|(a, value)| *value = clamp(*value + change(a), bound));
    }

    fn knows(&self, weights: &[f64], state: StateId) -> bool {
        weights.len() > state.index() * self.num_actions
    }
}
