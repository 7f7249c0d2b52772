//! The transitions as plain values, checked when they are read back.

use super::{TransitionGraph, TransitionStats, state_of};
use crate::env::Action;
use crate::graph::{GraphError, StateId};
use petgraph::visit::EdgeRef;
use serde::{Deserialize, Serialize};

/// What is written down: the transitions in the order in which they were first seen. Everything else follows from them.
#[derive(Serialize, Deserialize)]
pub(super) struct Saved {
    num_actions: usize,
    num_states: usize,
    /// (from, action, to, count, reward sum, terminal)
    transitions: Vec<(u32, u16, u32, u32, f64, bool)>,
}

impl From<TransitionGraph> for Saved {
    fn from(graph: TransitionGraph) -> Self {
        let transitions = graph.digraph.edge_references().map(|edge| {
            let (from, to, seen) = (
                state_of(edge.source()).0,
                state_of(edge.target()).0,
                edge.weight(),
            );
            (
                from,
                seen.action.0,
                to,
                seen.count,
                seen.reward_sum,
                seen.terminal,
            )
        });
        Saved {
            num_actions: graph.num_actions,
            num_states: graph.num_states(),
            transitions: transitions.collect(),
        }
    }
}

impl TryFrom<Saved> for TransitionGraph {
    type Error = GraphError;

    fn try_from(saved: Saved) -> Result<Self, GraphError> {
        let transitions = saved.transitions.into_iter();
        let transitions = transitions.map(|(from, action, to, count, reward_sum, terminal)| {
            let stats = TransitionStats {
                action: Action(action),
                count,
                reward_sum,
                terminal,
            };
            (StateId(from), stats, StateId(to))
        });
        TransitionGraph::from_transitions(saved.num_actions, saved.num_states, transitions)
    }
}

impl TransitionGraph {
    /// The graph of so many states and actions in which these transitions were seen, each listed once, in the order in
    /// which they were first seen. O(transitions · out-degree).
    ///
    /// # Errors
    /// If a number is out of range, or a transition was taken 0 times or is listed twice.
    pub fn from_transitions(
        num_actions: usize,
        num_states: usize,
        transitions: impl IntoIterator<Item = (StateId, TransitionStats, StateId)>,
    ) -> Result<Self, GraphError> {
        if !(1..=1 << 16).contains(&num_actions) {
            return Err(GraphError::Damaged {
                what: "actions",
                expected: 1,
                found: num_actions,
            });
        }
        let mut graph = TransitionGraph::new(num_actions);
        (0..num_states).for_each(|_| {
            graph.add_state();
        });
        for (from, stats, to) in transitions {
            if let Some(node) = [from, to].iter().find(|node| node.index() >= num_states) {
                return Err(GraphError::NodeOutOfRange {
                    node: node.0,
                    nodes: num_states,
                });
            }
            if stats.action.index() >= num_actions {
                return Err(GraphError::ActionOutOfRange {
                    action: stats.action.0,
                    num_actions,
                });
            }
            graph.restore(from, stats, to)?;
        }
        Ok(graph)
    }

    /// Puts back one saved transition.
    fn restore(
        &mut self,
        from: StateId,
        stats: TransitionStats,
        to: StateId,
    ) -> Result<(), GraphError> {
        if stats.count == 0 || self.find(from, stats.action, to).is_some() {
            return Err(GraphError::BadTransition {
                from: from.0,
                to: to.0,
            });
        }
        let slot = self.slot(from, stats.action);
        self.attempts[slot].tries = self.attempts[slot].tries.saturating_add(stats.count);
        self.record_first(slot, from, stats, to);
        Ok(())
    }
}
