//! The graph of visited states, growing while the agent explores.

pub mod adjacency;
pub mod state_graph;
pub mod transition_graph;

pub use adjacency::{Adjacency, Csr};
pub use state_graph::StateGraph;
pub use transition_graph::{Outcome, TransitionGraph};

/// The number of a state in order of discovery, from 0. Never renumbered, never removed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct StateId(pub u32);

impl StateId {
    /// The state as an array index.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}
