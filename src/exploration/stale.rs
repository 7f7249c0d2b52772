//! States that may have changed behind the agent's back: those not entered since a goal was lost.

use crate::graph::StateId;
use serde::{Deserialize, Serialize};

/// A set of states that shrinks as they are entered. Memory and [`mark_all`](Self::mark_all) O(n), the rest O(1).
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct StaleStates {
    is_stale: Vec<bool>,
    left: usize,
}

impl StaleStates {
    /// Every state of `0..num_states` is stale from now on.
    pub fn mark_all(&mut self, num_states: usize) {
        self.is_stale.clear();
        self.is_stale.resize(num_states, true);
        self.left = num_states;
    }

    /// No state is stale any more.
    pub fn clear(&mut self) {
        self.is_stale.clear();
        self.left = 0;
    }

    /// `state` has just been entered, or an episode began there.
    pub fn enter(&mut self, state: StateId) {
        if self.contains(state) {
            self.is_stale[state.index()] = false;
            self.left -= 1;
        }
    }

    /// Whether `state` was known when a goal was lost and was not entered since.
    pub fn contains(&self, state: StateId) -> bool {
        self.is_stale.get(state.index()).is_some_and(|stale| *stale)
    }

    /// Whether no state is stale.
    pub fn is_empty(&self) -> bool {
        self.left == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_are_stale_until_they_are_entered() {
        let mut stale = StaleStates::default();
        assert!(stale.is_empty() && !stale.contains(StateId(0)));
        stale.mark_all(2);
        stale.enter(StateId(1));
        stale.enter(StateId(1));
        stale.enter(StateId(7));
        assert!(stale.contains(StateId(0)) && !stale.contains(StateId(1)));
        assert!(!stale.contains(StateId(7)), "a new state has been seen");
        stale.enter(StateId(0));
        assert!(stale.is_empty());
        stale.mark_all(3);
        stale.clear();
        assert!(stale.is_empty() && !stale.contains(StateId(2)));
    }
}
