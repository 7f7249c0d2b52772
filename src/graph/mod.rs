//! The graph of visited states, growing while the agent explores.
//!
//! A state gets its number when it is first seen (0, 1, 2, …), is never renumbered and never removed, so growth only
//! appends. Three layers, each usable without the one above it:
//!
//! | type | is | knows |
//! |---|---|---|
//! | [`StateGraph<S>`] | state ↔ [`StateId`] | what a state looks like |
//! | [`TransitionGraph`] | the directed multigraph of tried transitions | actions, counts, rewards |
//! | [`Adjacency`] | the symmetric weights w(i, j) = w(j, i) > 0 | nothing but numbers |
//!
//! The spectral part sees only the last one, as a compact [`SymmetricCsr`], whose type says what it guarantees. A step (s, a) → s′ with s ≠ s′ becomes the
//! undirected edge {s, s′} of weight 1, whichever way it was taken; a bump (s = s′) is counted as a transition but is
//! no edge. Several components, isolated nodes and self-loops are legal everywhere.
//!
//! ```
//! use eigentrail::{env::Action, graph::StateGraph};
//!
//! let mut graph = StateGraph::new(2);
//! let (home, _) = graph.intern(&"home");
//! let (shop, is_new) = graph.intern(&"shop");
//! assert!(is_new);
//! assert!(graph.record(home, Action(0), -1.0, shop, false));
//! assert_eq!(graph.transitions().likely_successor(home, Action(0)), Some(shop));
//! assert_eq!(graph.transitions().adjacency().degree(0), 1.0);
//! ```

pub mod adjacency;
pub mod connectivity;
pub mod dot;
mod error;
mod export;
pub mod graphml;
#[cfg(feature = "matrix-market")]
pub mod matrix_market;
mod slack_rows;
mod state_graph;
pub mod transition_graph;

pub use adjacency::Adjacency;
pub use connectivity::{HopSearch, Links};
pub use eigentrail_spectra::SymmetricCsr;
pub use error::GraphError;
pub use export::GraphAttributes;
#[cfg(feature = "matrix-market")]
pub use matrix_market::MatrixMarketError;
pub use state_graph::StateGraph;
pub use transition_graph::{ObservedOutcome, TransitionGraph, TransitionStats};

use serde::{Deserialize, Serialize};

/// The number of a state in order of discovery, from 0. Never renumbered, never removed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct StateId(pub u32);

impl StateId {
    /// The state as an array index.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}
