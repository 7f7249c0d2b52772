//! What was tried and what came of it: petgraph digraph of transitions with counts, and the undirected adjacency. (interface sketch)

use super::{Adjacency, StateId};
use crate::env::Action;

/// One tried (state, action) → next, with how often and with what reward.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    pub action: Action,
    pub next: StateId,
    pub count: u32,
    pub reward_sum: f64,
    /// Whether the episode terminated on arrival (ever).
    pub terminal: bool,
}

#[derive(Clone, Debug)]
pub struct TransitionGraph {}

#[allow(unused_variables)]
impl TransitionGraph {
    pub fn new(num_actions: usize) -> Self {
        todo!()
    }
    pub fn num_actions(&self) -> usize {
        todo!()
    }
    pub fn num_states(&self) -> usize {
        todo!()
    }
    pub fn add_state(&mut self) -> StateId {
        todo!()
    }
    /// Records one transition; true if {from, to} is a new undirected edge. Self-transitions (bumps) are counted
    /// in the digraph but are no edge of the adjacency.
    pub fn record(
        &mut self,
        from: StateId,
        action: Action,
        reward: f64,
        to: StateId,
        terminal: bool,
    ) -> bool {
        todo!()
    }
    /// Outcomes seen from `state`, most recent edge first; O(out-degree), no allocation.
    pub fn outcomes(&self, state: StateId) -> impl Iterator<Item = Outcome> + '_ {
        std::iter::empty()
    }
    /// How often (state, action) was tried.
    pub fn tries(&self, state: StateId, action: Action) -> u32 {
        todo!()
    }
    /// Number of actions of `state` never tried.
    pub fn untried_actions(&self, state: StateId) -> usize {
        todo!()
    }
    pub fn adjacency(&self) -> &Adjacency {
        todo!()
    }
    /// States from which `state` was entered (directed predecessors, without duplicates is not promised).
    pub fn predecessors(&self, state: StateId) -> impl Iterator<Item = StateId> + '_ {
        std::iter::empty()
    }
}
