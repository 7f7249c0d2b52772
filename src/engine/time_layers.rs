//! Layers of time: whether every state is met at one time of the episode only, as in a layered MDP.
//!
//! In a world like that (the deep sea; a game of so many moves) an episode takes as long whatever is done, and an end is no goal for
//! having come early. It is believed once a few episodes have ended, and until one state is met at two times: a bump or a step back is enough.

use crate::graph::StateId;
use serde::{Deserialize, Serialize};

/// Ends of episodes before the hypothesis is believed: who walks straight to a goal has met no state twice.
const MIN_ENDS: u32 = 4;
/// No time.
const NEVER: u32 = u32::MAX;

/// The time of each state, while that is one. Memory O(n), none once the hypothesis is refuted.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TimeLayers {
    times: Vec<u32>,
    hold: bool,
    ends: u32,
}

impl TimeLayers {
    /// Nothing was met yet.
    pub fn new() -> Self {
        Self {
            times: Vec::new(),
            hold: true,
            ends: 0,
        }
    }

    /// Whether it is believed that no state is met at two times.
    pub fn believed(&self) -> bool {
        self.hold && self.ends >= MIN_ENDS
    }

    /// Takes note that `state` was met after so many steps of an episode; true if that refutes what was believed. Amortised O(1).
    #[inline]
    pub fn meet(&mut self, state: StateId, time: u32) -> bool {
        let believed = self.believed();
        self.hold && !self.fits(state, time) && believed
    }

    /// Takes note that an episode ended by itself; true if the hypothesis is believed from now on.
    pub fn end_episode(&mut self) -> bool {
        self.ends = self.ends.saturating_add(1);
        self.hold && self.ends == MIN_ENDS
    }

    fn fits(&mut self, state: StateId, time: u32) -> bool {
        if self.times.len() <= state.index() {
            self.times.resize(state.index() + 1, NEVER);
        }
        let known = &mut self.times[state.index()];
        if *known == NEVER {
            *known = time;
        }
        self.hold = *known == time;
        if !self.hold {
            self.times = Vec::new();
        }
        self.hold
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_state_at_two_times_refutes_it_for_good() {
        let mut layers = TimeLayers::new();
        for end in 1..=MIN_ENDS {
            for (state, time) in [(0, 0), (1, 1), (2, 2), (0, 0), (3, 1), (2, 2)] {
                assert!(!layers.meet(StateId(state), time));
            }
            assert!(!layers.believed());
            assert_eq!(layers.end_episode(), end == MIN_ENDS);
        }
        assert!(layers.believed());
        assert!(layers.meet(StateId(2), 1), "met after 2 steps before");
        assert!(!layers.believed());
        assert!(!layers.meet(StateId(2), 2), "it is refuted already");
        assert!(!layers.end_episode() && !layers.believed());
    }

    #[test]
    fn what_is_refuted_early_is_never_believed() {
        let mut layers = TimeLayers::new();
        layers.meet(StateId(0), 0);
        assert!(!layers.meet(StateId(0), 1), "nobody believed it");
        assert!((0..10).all(|_| !layers.end_episode() && !layers.believed()));
    }
}
