//! The directed multigraph of tried transitions: the maximum-likelihood model of the world.
//!
//! A directed multigraph with one edge per (s, a, s′) that was seen, on which stand N(s, a, s′) and Σ r. It is the
//! maximum-likelihood model of the world,
//!
//! ```text
//! P̂(s′ | s, a) = N(s, a, s′) / N(s, a),        r̂(s, a) = Σ_s′ Σ r / N(s, a),
//! ```
//!
//! and its undirected shadow, without directions, actions and bumps, is the [`Adjacency`] that the spectra are taken
//! of. Between any two calls:
//!
//! 1. N(s, a) = Σ_s′ N(s, a, s′) (all counters stop at 2³² − 1, and a transition's reward sum stops with its counter);
//! 2. {s, s′} is an edge of the adjacency, of weight 1, if and only if s ≠ s′ and some (s, a, s′) or (s′, a, s) was seen;
//! 3. `untried_actions(s)` is the number of actions with N(s, a) = 0.
//!
//! **Cost.** A step first looks at what (s, a) led to the last time: in a deterministic world that is always right, and
//! `record` touches two cache lines. Otherwise it walks the out-edges of s. Only an unseen (s, a, s′) allocates
//! (amortised) and looks at the adjacency.

mod invariants;
mod outcomes;
mod saved;

pub use outcomes::ObservedOutcome;

use super::{Adjacency, StateId};
use crate::env::Action;
use petgraph::graph::{DiGraph, EdgeIndex, NodeIndex};
use petgraph::visit::EdgeRef;
use saved::Saved;
use serde::{Deserialize, Serialize};

/// Statistics on an edge s → s′ of [`TransitionGraph::digraph`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TransitionStats {
    /// The action that was taken; parallel edges differ in it.
    pub action: Action,
    /// How often, at least 1.
    pub count: u32,
    /// Sum of the rewards over those times.
    pub reward_sum: f64,
    /// Whether the episode terminated on arrival (ever).
    pub terminal: bool,
}

/// N(s, a), and the edge that (s, a) took the last time.
#[derive(Clone, Copy, Debug)]
struct Attempts {
    tries: u32,
    latest: EdgeIndex,
}

impl Attempts {
    fn none() -> Self {
        Self {
            tries: 0,
            latest: EdgeIndex::end(),
        }
    }
}

/// The tried transitions of a world with `num_actions` actions; see the [module](self).
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(try_from = "Saved", into = "Saved")]
pub struct TransitionGraph {
    num_actions: usize,
    digraph: DiGraph<(), TransitionStats>,
    /// One for each (s, a), at s · num_actions + a.
    attempts: Vec<Attempts>,
    /// One for each state.
    untried: Vec<u32>,
    adjacency: Adjacency,
}

impl TransitionGraph {
    /// No states yet.
    ///
    /// # Panics
    /// Unless 1 ≤ `num_actions` ≤ 65 536, the numbers an [`Action`] has.
    pub fn new(num_actions: usize) -> Self {
        assert!(
            (1..=1 << 16).contains(&num_actions),
            "{num_actions} actions"
        );
        Self {
            num_actions,
            digraph: DiGraph::new(),
            attempts: Vec::new(),
            untried: Vec::new(),
            adjacency: Adjacency::new(),
        }
    }

    /// Number of actions, the same in every state.
    pub fn num_actions(&self) -> usize {
        self.num_actions
    }

    /// Number of states n.
    pub fn num_states(&self) -> usize {
        self.untried.len()
    }

    /// Adds a state of which nothing has been tried. Amortised O(number of actions).
    ///
    /// # Panics
    /// If there are 2³² − 1 states already.
    pub fn add_state(&mut self) -> StateId {
        let id = self.adjacency.add_node();
        self.digraph.add_node(());
        self.attempts
            .resize(self.attempts.len() + self.num_actions, Attempts::none());
        self.untried.push(self.num_actions as u32);
        StateId(id)
    }

    /// Records one transition; true if {from, to} is a new undirected edge. Self-transitions (bumps) are counted
    /// in the digraph but are no edge of the adjacency.
    ///
    /// O(1) if (from, action) led to `to` the last time too, else O(out-degree of `from`); allocates only for a
    /// (from, action, to) that was never seen.
    ///
    /// A reward that is NaN is stored as it is, and makes the means it enters NaN.
    ///
    /// # Panics
    /// If a state or the action does not exist.
    #[inline]
    pub fn record(
        &mut self,
        from: StateId,
        action: Action,
        reward: f64,
        to: StateId,
        terminal: bool,
    ) -> bool {
        let slot = self.slot(from, action);
        let latest = self.attempts[slot].latest;
        self.attempts[slot].tries = self.attempts[slot].tries.saturating_add(1);
        // An edge of (from, action) can differ from the one sought only in its target.
        let known = match self.digraph.edge_endpoints(latest) {
            Some((_, target)) if target == node(to) => Some(latest),
            Some(_) => self.find(from, action, to),
            None => None,
        };
        match known {
            Some(edge) => {
                self.attempts[slot].latest = edge;
                self.digraph[edge].add(reward, terminal);
                false
            }
            None => self.record_first(
                slot,
                from,
                TransitionStats {
                    action,
                    count: 1,
                    reward_sum: reward,
                    terminal,
                },
                to,
            ),
        }
    }

    /// The rare half of [`Self::record`]: (from, action, to) was never seen.
    #[cold]
    fn record_first(
        &mut self,
        slot: usize,
        from: StateId,
        stats: TransitionStats,
        to: StateId,
    ) -> bool {
        assert!(
            to.index() < self.num_states(),
            "state {} of {}",
            to.0,
            self.num_states()
        );
        if self.attempts[slot].latest == EdgeIndex::end() {
            self.untried[from.index()] -= 1;
        }
        self.attempts[slot].latest = self.digraph.add_edge(node(from), node(to), stats);
        from != to && self.adjacency.add_edge(from.0, to.0, 1.0)
    }

    /// N(s, a): how often (state, action) was tried. O(1).
    ///
    /// # Panics
    /// If the state or the action does not exist.
    pub fn tries(&self, state: StateId, action: Action) -> u32 {
        self.attempts[self.slot(state, action)].tries
    }

    /// Where (state, action) led the last time; `None` if it was never tried. O(1).
    ///
    /// # Panics
    /// If the state or the action does not exist.
    #[inline]
    pub fn latest_outcome(&self, state: StateId, action: Action) -> Option<StateId> {
        let latest = self.attempts[self.slot(state, action)].latest;
        let (_, next) = self.digraph.edge_endpoints(latest)?;
        Some(state_of(next))
    }

    /// Number of actions of `state` never tried. O(1).
    ///
    /// # Panics
    /// If the state does not exist.
    pub fn untried_actions(&self, state: StateId) -> usize {
        self.untried[state.index()] as usize
    }

    /// The undirected graph, weights 1.
    pub fn adjacency(&self) -> &Adjacency {
        &self.adjacency
    }

    /// The directed multigraph itself, for petgraph's algorithms; node i is state i.
    pub fn digraph(&self) -> &DiGraph<(), TransitionStats> {
        &self.digraph
    }

    /// Number of different (s, a, s′) seen.
    pub fn num_transitions(&self) -> usize {
        self.digraph.edge_count()
    }

    fn slot(&self, state: StateId, action: Action) -> usize {
        assert!(
            action.index() < self.num_actions,
            "action {} of {}",
            action.0,
            self.num_actions
        );
        state.index() * self.num_actions + action.index()
    }

    fn find(&self, from: StateId, action: Action, to: StateId) -> Option<EdgeIndex> {
        self.digraph
            .edges(node(from))
            .find(|edge| edge.target() == node(to) && edge.weight().action == action)
            .map(|edge| edge.id())
    }
}

impl TransitionStats {
    fn add(&mut self, reward: f64, terminal: bool) {
        if self.count < u32::MAX {
            self.count += 1;
            self.reward_sum += reward;
        }
        self.terminal |= terminal;
    }
}

fn node(state: StateId) -> NodeIndex {
    NodeIndex::from(state.0)
}

fn state_of(node: NodeIndex) -> StateId {
    StateId(node.index() as u32)
}
