//! Attributes of nodes and edges, which the graph writers share.

use super::{StateId, TransitionGraph, TransitionStats};

/// Attributes to write beside the number of each state; empty by default.
#[derive(Clone, Copy, Debug, Default)]
pub struct NodeAttributes<'a> {
    /// A name for each state, n of them.
    pub names: Option<&'a [String]>,
    /// The potential φ of each state, n values.
    pub potential: Option<&'a [f64]>,
}

impl<'a> NodeAttributes<'a> {
    /// # Panics
    /// Unless there is one of each per state.
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
    }

    pub(super) fn name(&self, state: StateId) -> Option<&'a str> {
        self.names.map(|names| names[state.index()].as_str())
    }

    pub(super) fn phi(&self, state: StateId) -> Option<f64> {
        self.potential.map(|phi| phi[state.index()])
    }
}

/// Mean reward of one transition.
pub(super) fn mean_reward(stats: &TransitionStats) -> f64 {
    stats.reward_sum / f64::from(stats.count)
}
