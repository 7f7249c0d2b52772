//! Steps that may still go into looking for something better than what was found.
//!
//! ```text
//! S(t) ≤ trip + σ min(t, √(K t)),     K = max(t₁, n, 256)
//! ```
//!
//! t steps after the first thing worth having was found, which took t₁ steps, in a world of which n states are known. The share σ of the
//! steps at first, as many as it took to find the first one or to see what is known; then less and less, as √t: what is found late is
//! had for a shorter time, and what was not found in S steps is likely to take as many again. The search never ends, so nothing is
//! missed for ever, and its share of the steps goes to 0, so nothing found is lost to it.

use serde::{Deserialize, Serialize};

/// K where little is known and the first thing was found at once.
const LEAST_SCALE: u64 = 256;

/// Counts of steps.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct SearchBudget {
    /// t₁, t, S.
    before: u64,
    since: u64,
    spent: u64,
}

impl SearchBudget {
    /// Counts a step: before or after something worth having was `found`, and whether it was one of the search. O(1).
    #[inline]
    pub fn count(&mut self, found: bool, searching: bool) {
        if found {
            self.since += 1;
            self.spent += u64::from(searching);
        } else {
            self.before += 1;
        }
    }

    /// k(t): tries of everything that are worth it by now, 2 √(t / K) where something was found, at least 1. What n tries did not show has a
    /// chance of 1 / (n + 1) at most to show at the next one: less and less, like the share of the steps that the search may have.
    pub fn rounds(&self, states: usize) -> u32 {
        let rounds = 2.0 * (self.since as f64 / self.scale(states)).sqrt();
        rounds.max(1.0) as u32
    }

    /// K.
    fn scale(&self, states: usize) -> f64 {
        self.before.max(states as u64).max(LEAST_SCALE) as f64
    }

    /// Steps left of `trip` and the share σ, in a world of which `states` are known. Negative if more were spent.
    pub fn left(&self, trip: f64, share: f64, states: usize) -> f64 {
        let since = self.since as f64;
        trip + share * since.min((self.scale(states) * since).sqrt()) - self.spent as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_at_first_then_the_root() {
        let mut budget = SearchBudget::default();
        (0..1000).for_each(|_| budget.count(false, true));
        assert_eq!(budget.left(30.0, 0.5, 10), 30.0, "nothing was found yet");
        (0..100).for_each(|i| budget.count(true, i < 70));
        assert_eq!(budget.left(30.0, 0.5, 10), 30.0 + 50.0 - 70.0);
        (0..900).for_each(|_| budget.count(true, false));
        assert_eq!(budget.left(0.0, 0.5, 10), 500.0 - 70.0);
        (0..3000).for_each(|_| budget.count(true, false));
        assert_eq!(
            budget.left(0.0, 0.5, 10),
            1000.0 - 70.0,
            "√(1000 · 4000) = 2000"
        );
        assert_eq!(budget.left(0.0, 0.5, 4000), 2000.0 - 70.0, "a larger world");
    }
}
