//! Exact return of an episode of a given policy under a step limit.
//!
//! ```text
//! d_0 = the starts,   d_{t+1}(s′) = Σ_s d_t(s) P(s′ | s, π(s)) for every s′ at which nothing ends
//! R^π = Σ_{t < H} Σ_s d_t(s) Σ_{s′} P(s′ | s, π(s)) R(s, π(s), s′)
//! ```
//!
//! Forward, and over the states that can be reached in t steps only: a policy that knows its way in a world without chance is
//! at one place at a time, however large the world.

use super::TabularMdp;
use crate::env::{Action, Starts};

/// Episodes as rare as this are left out: below what the sums of probabilities are exact to.
const NEGLIGIBLE: f64 = 1e-14;

/// Chances of being somewhere, and the list of the places where they are not 0.
struct Occupancy {
    chance: Vec<f64>,
    places: Vec<usize>,
}

impl Occupancy {
    fn nowhere(states: usize) -> Self {
        Self {
            chance: vec![0.0; states],
            places: Vec::new(),
        }
    }

    /// What underflows is nowhere: a place with no chance would be listed once more for each way that leads there.
    fn add(&mut self, state: usize, chance: f64) {
        if chance < f64::MIN_POSITIVE {
            return;
        }
        if self.chance[state] == 0.0 {
            self.places.push(state);
        }
        self.chance[state] += chance;
    }

    /// Empties it, and hands out what was in it.
    fn drain(&mut self) -> impl Iterator<Item = (usize, f64)> {
        let chance = &mut self.chance;
        self.places
            .drain(..)
            .map(|state| (state, std::mem::take(&mut chance[state])))
    }

    fn total(&self) -> f64 {
        self.places.iter().map(|&state| self.chance[state]).sum()
    }
}

impl TabularMdp {
    /// The expected return of an episode of the deterministic `policy` that begins in one of `starts` and is
    /// truncated after `max_steps`; undiscounted. `policy[s]` is what it does in state s, of no matter where episodes end.
    ///
    /// O(steps × outcomes of the states that it may be in at a time), and at most `max_steps` steps.
    ///
    /// # Panics
    /// If `starts` is empty, or a start or an action does not exist, or `policy` has not one action a state.
    pub fn policy_return(
        &self,
        starts: impl Into<Starts>,
        max_steps: usize,
        policy: &[Action],
    ) -> f64 {
        let starts = starts.into();
        assert!(!starts.places().is_empty(), "an episode begins somewhere");
        assert_eq!(policy.len(), self.num_states(), "one action a state");
        let mut now = Occupancy::nowhere(self.num_states());
        let mut next = Occupancy::nowhere(self.num_states());
        for (&start, chance) in starts.chances() {
            if !self.terminal[start] {
                now.add(start, chance);
            }
        }
        let mut earned = 0.0;
        for _ in 0..max_steps {
            for (state, chance) in now.drain() {
                for outcome in self.outcomes(state, policy[state]) {
                    let chance = chance * outcome.probability;
                    earned += chance * outcome.reward;
                    if !self.terminal[outcome.next as usize] {
                        next.add(outcome.next as usize, chance);
                    }
                }
            }
            std::mem::swap(&mut now, &mut next);
            debug_assert!(now.places.len() <= self.num_states(), "a place once");
            if now.total() <= NEGLIGIBLE {
                break;
            }
        }
        earned
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::Outcome;
    use nalgebra::{DMatrix, DVector};
    use proptest::prelude::*;

    fn outcome(next: u32, probability: f64, reward: f64) -> Outcome {
        Outcome {
            next,
            probability,
            reward,
        }
    }

    #[test]
    fn tries_until_the_clock_stops_sum_as_a_geometric_series() {
        // Succeeds with chance p, at a cost of 1 a try: E[min(tries, H)] = (1 − (1 − p)^H) / p.
        let p = 0.2;
        let tries = vec![outcome(0, 1.0 - p, -1.0), outcome(1, p, -1.0)];
        let mdp = TabularMdp::new(&[vec![tries], vec![]], vec![false, true]).unwrap();
        for limit in [1, 2, 7, 1000] {
            let expected = -(1.0 - (1.0 - p).powi(limit)) / p;
            let found = mdp.policy_return(&[0], limit as usize, &[Action(0); 2]);
            assert!((found - expected).abs() < 1e-12, "{limit}: {found}");
        }
    }

    #[test]
    fn a_loop_earns_until_the_clock_stops_and_an_end_at_the_start_earns_nothing() {
        let around = [
            vec![vec![outcome(1, 1.0, 3.0)]],
            vec![vec![outcome(0, 1.0, -1.0)]],
            vec![],
        ];
        let mdp = TabularMdp::new(&around, vec![false, false, true]).unwrap();
        assert_eq!(mdp.policy_return(&[0], 5, &[Action(0); 3]), 7.0);
        assert_eq!(mdp.policy_return(&[0, 2], 5, &[Action(0); 3]), 3.5);
    }

    #[test]
    fn weighted_starts_weigh_the_returns_of_single_ones() {
        let chain = [
            vec![vec![outcome(1, 1.0, 3.0)]],
            vec![vec![outcome(2, 1.0, -1.0)]],
            vec![],
        ];
        let mdp = TabularMdp::new(&chain, vec![false, false, true]).unwrap();
        let starts = Starts::weighted([(0, 3.0), (1, 1.0)]);
        // 3/4 · 2 − 1/4 · 1.
        assert_eq!(mdp.policy_return(&starts, 9, &[Action(0); 3]), 1.25);
    }

    #[test]
    fn chances_that_underflow_do_not_multiply_places() {
        // All but a sliver stays; the sliver fans out again and again, and is below the smallest number at the fifth.
        let sliver = 1e-65;
        let stay = outcome(0, 1.0 - 4.0 * sliver, -1.0);
        let fan = (1..5).map(|to| outcome(to, sliver, -1.0));
        let mut states = vec![vec![
            std::iter::once(stay).chain(fan.clone()).collect::<Vec<_>>(),
        ]];
        states.extend((1..5).map(|_| {
            let back = outcome(5, 1.0 - 4.0 * sliver, -1.0);
            vec![std::iter::once(back).chain(fan.clone()).collect()]
        }));
        states.push(vec![]);
        let terminal = vec![false, false, false, false, false, true];
        let mdp = TabularMdp::new(&states, terminal).unwrap();
        assert_eq!(mdp.policy_return(&[0], 10, &[Action(0); 6]), -10.0);
    }

    fn small_world() -> impl Strategy<Value = (Vec<Vec<Vec<Outcome>>>, Vec<u16>)> {
        let row = (0..5_u32, 0..5_u32, 0.0..1.0_f64, -3.0..3.0_f64)
            .prop_map(|(a, b, p, r)| vec![outcome(a, p, r), outcome(b, 1.0 - p, -r)]);
        let state = prop::collection::vec(row, 2);
        let worlds = prop::collection::vec(state, 4).prop_map(|mut states| {
            states.push(vec![]);
            states
        });
        (worlds, prop::collection::vec(0..2_u16, 5))
    }

    proptest! {
        /// Backwards, with dense matrices: v_{k+1} = r_π + P_π v_k. And no policy earns more than the best.
        #[test]
        fn as_backward_evaluation((world, choices) in small_world(), limit in 1..40_usize) {
            let terminal = world.iter().map(Vec::is_empty).collect();
            let mdp = TabularMdp::new(&world, terminal).unwrap();
            let mut p = DMatrix::<f64>::zeros(5, 5);
            let mut r = DVector::<f64>::zeros(5);
            for state in 0..4 {
                for outcome in mdp.outcomes(state, Action(choices[state])) {
                    p[(state, outcome.next as usize)] += outcome.probability;
                    r[state] += outcome.probability * outcome.reward;
                }
            }
            let v = (0..limit).fold(DVector::zeros(5), |v, _| &r + &p * v);
            let policy: Vec<Action> = choices.into_iter().map(Action).collect();
            let found = mdp.policy_return(&[0, 1, 2], limit, &policy);
            let expected = (v[0] + v[1] + v[2]) / 3.0;
            prop_assert!((found - expected).abs() < 1e-9, "{} {}", found, expected);
            prop_assert!(found <= mdp.optimal_return(&[0, 1, 2], limit) + 1e-9);
        }
    }
}
