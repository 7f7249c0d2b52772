//! State ↔ number, on top of the transition graph.
//!
//! States are kept in the order in which they were first seen, so that `state(id(s)) = s` and new states append. The
//! hash function has a fixed seed: nothing observable depends on hashes, and equal runs do equal work.

use super::{GraphError, StateId, TransitionGraph};
use crate::env::Action;
use foldhash::fast::FixedState;
use indexmap::IndexSet;
use serde::{Deserialize, Serialize, Serializer};
use std::hash::Hash;

/// The graph of visited states of type `S`.
#[derive(Clone, Debug, Deserialize)]
#[serde(
    try_from = "Saved<S>",
    bound(deserialize = "S: Eq + Hash + Deserialize<'de>")
)]
pub struct StateGraph<S> {
    /// State number i stands at place i.
    states: IndexSet<S, FixedState>,
    transitions: TransitionGraph,
}

impl<S: Clone + Eq + Hash> StateGraph<S> {
    /// No states yet.
    ///
    /// # Panics
    /// Unless 1 ≤ `num_actions` ≤ 65 536.
    pub fn new(num_actions: usize) -> Self {
        Self {
            states: IndexSet::default(),
            transitions: TransitionGraph::new(num_actions),
        }
    }

    /// The number of `state`, and whether it is new. Amortised O(1); clones `state` only if it is new.
    ///
    /// # Panics
    /// If there are 2³² − 1 states already.
    pub fn intern(&mut self, state: &S) -> (StateId, bool) {
        match self.id(state) {
            Some(id) => (id, false),
            None => {
                self.states.insert(state.clone());
                (self.transitions.add_state(), true)
            }
        }
    }

    /// The same for a state that `action` has led to from `from`: as often as not the one that it led to the last time, which is recognised without
    /// hashing.
    ///
    /// # Panics
    /// If `from` or the action does not exist, or there are 2³² − 1 states already.
    #[inline]
    pub fn intern_next(&mut self, from: StateId, action: Action, state: &S) -> (StateId, bool) {
        match self.transitions.latest_outcome(from, action) {
            Some(latest) if self.states[latest.index()] == *state => (latest, false),
            _ => self.intern(state),
        }
    }

    /// The number of `state`, if it was seen. O(1).
    pub fn id(&self, state: &S) -> Option<StateId> {
        self.states
            .get_index_of(state)
            .map(|index| StateId(index as u32))
    }

    /// The state with number `id`. O(1).
    ///
    /// # Panics
    /// If there is none.
    pub fn state(&self, id: StateId) -> &S {
        &self.states[id.index()]
    }

    /// All states in order of discovery.
    pub fn states(&self) -> impl ExactSizeIterator<Item = &S> {
        self.states.iter()
    }

    /// Number of states n.
    pub fn num_states(&self) -> usize {
        self.states.len()
    }

    /// What was tried and what came of it.
    pub fn transitions(&self) -> &TransitionGraph {
        &self.transitions
    }

    /// Records one transition; see [`TransitionGraph::record`].
    ///
    /// # Panics
    /// If a state or the action does not exist.
    pub fn record(
        &mut self,
        from: StateId,
        action: Action,
        reward: f64,
        to: StateId,
        terminal: bool,
    ) -> bool {
        self.transitions.record(from, action, reward, to, terminal)
    }

    /// Forgets that episodes ended in `state` ([`TransitionGraph::forget_end`]).
    ///
    /// # Panics
    /// If the state does not exist.
    pub fn forget_end(&mut self, state: StateId, reward: f64) {
        self.transitions.forget_end(state, reward);
    }

    /// Checks that states and numbers agree, and the transitions with themselves; meant for tests.
    ///
    /// # Panics
    /// If they do not.
    #[doc(hidden)]
    pub fn assert_consistent(&self) {
        assert_eq!(self.states.len(), self.transitions.num_states());
        for (index, state) in self.states.iter().enumerate() {
            assert_eq!(self.id(state), Some(StateId(index as u32)));
        }
        self.transitions.assert_consistent();
    }
}

/// What is written down, borrowed.
#[derive(Serialize)]
struct SavedRef<'a, S> {
    states: Vec<&'a S>,
    transitions: &'a TransitionGraph,
}

impl<S: Serialize> Serialize for StateGraph<S> {
    fn serialize<Z: Serializer>(&self, serializer: Z) -> Result<Z::Ok, Z::Error> {
        SavedRef {
            states: self.states.iter().collect(),
            transitions: &self.transitions,
        }
        .serialize(serializer)
    }
}

/// What is read back.
#[derive(Deserialize)]
struct Saved<S> {
    states: Vec<S>,
    transitions: TransitionGraph,
}

impl<S: Eq + Hash> TryFrom<Saved<S>> for StateGraph<S> {
    type Error = GraphError;

    fn try_from(saved: Saved<S>) -> Result<Self, GraphError> {
        let states: IndexSet<S, FixedState> = saved.states.into_iter().collect();
        let (expected, found) = (saved.transitions.num_states(), states.len());
        if expected == found {
            Ok(Self {
                states,
                transitions: saved.transitions,
            })
        } else {
            Err(GraphError::Damaged {
                what: "different states",
                expected,
                found,
            })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_follow_the_order_of_discovery() {
        let mut graph = StateGraph::new(1);
        for (word, number, is_new) in [
            ("c", 0, true),
            ("a", 1, true),
            ("c", 0, false),
            ("b", 2, true),
        ] {
            assert_eq!(graph.intern(&word), (StateId(number), is_new));
            graph.assert_consistent();
        }
        assert_eq!(graph.states().copied().collect::<Vec<_>>(), ["c", "a", "b"]);
        assert_eq!((graph.id(&"d"), graph.state(StateId(1))), (None, &"a"));
    }

    #[test]
    fn what_an_action_has_led_to_is_found_like_anything_else() {
        let mut graph = StateGraph::new(1);
        let (home, action) = (graph.intern(&"home").0, Action(0));
        for (word, expected) in [
            ("a", (1, true)),
            ("a", (1, false)),
            ("b", (2, true)),
            ("a", (1, false)),
            ("home", (0, false)),
        ] {
            let (state, is_new) = graph.intern_next(home, action, &word);
            assert_eq!((state.0, is_new), expected, "{word}");
            graph.record(home, action, 0.0, state, false);
            let latest = graph.transitions().latest_outcome(home, action);
            assert_eq!(latest, Some(state));
            graph.assert_consistent();
        }
        assert_eq!(graph.transitions().latest_outcome(StateId(1), action), None);
    }

    #[test]
    fn saved_and_loaded_is_the_same() {
        let mut graph = StateGraph::new(2);
        let ids = ["a", "b", "c"].map(|word| graph.intern(&word.to_string()).0);
        for (from, action, to, terminal) in [
            (0, 0, 1, false),
            (0, 0, 2, true),
            (0, 0, 1, false),
            (1, 1, 1, false),
        ] {
            graph.record(ids[from], Action(action), 0.1, ids[to], terminal);
        }
        let text = serde_json::to_string(&graph).unwrap();
        let loaded: StateGraph<String> = serde_json::from_str(&text).unwrap();
        loaded.assert_consistent();
        assert_eq!(serde_json::to_string(&loaded).unwrap(), text);
        let error = serde_json::from_str::<StateGraph<String>>(&text.replace("\"c\"", "\"a\""))
            .unwrap_err();
        assert!(
            error.to_string().contains("2 different states, expected 3"),
            "{error}"
        );
    }
}
