//! Attributes of nodes and edges, which the graph writers share.

use super::{StateId, TransitionGraph, TransitionStats};
use crate::env::Action;

/// Attributes to write beside the numbers of states and actions; empty by default.
#[derive(Clone, Copy, Debug, Default)]
pub struct GraphAttributes<'a> {
    /// A name for each state, n of them.
    pub names: Option<&'a [String]>,
    /// The potential φ of each state, n values.
    pub potential: Option<&'a [f64]>,
    /// A name for each action.
    pub action_names: Option<&'a [String]>,
}

impl<'a> GraphAttributes<'a> {
    /// # Panics
    /// Unless there is one of each per state, and a name for each action.
    pub(super) fn check(&self, graph: &TransitionGraph) {
        let n = graph.num_states();
        assert!(
            self.names.is_none_or(|names| names.len() == n),
            "one name for each of {n} states"
        );
        assert!(
            self.potential.is_none_or(|phi| phi.len() == n),
            "one potential for each of {n} states"
        );
        let actions = graph.num_actions();
        assert!(
            self.action_names.is_none_or(|names| names.len() >= actions),
            "one name for each of {actions} actions"
        );
    }

    pub(super) fn name(&self, state: StateId) -> Option<&'a str> {
        self.names.map(|names| names[state.index()].as_str())
    }

    pub(super) fn action_name(&self, action: Action) -> Option<&'a str> {
        self.action_names
            .map(|names| names[action.index()].as_str())
    }

    pub(super) fn phi(&self, state: StateId) -> Option<f64> {
        self.potential.map(|phi| phi[state.index()])
    }
}

/// Mean reward of one transition.
pub(super) fn mean_reward(stats: &TransitionStats) -> f64 {
    stats.reward_sum / f64::from(stats.count)
}
