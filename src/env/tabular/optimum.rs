//! The best episode under a step limit: v_0 = 0, v_{k+1}(s) = max_a Σ P (R + v_k(s′)), and the steps that go with it.
//!
//! v_H is the largest expected return of an episode that is truncated after H steps; among actions of equal return the
//! one with fewer expected steps counts. Two ways to the same number: where every action has one outcome and all steps cost
//! the same, the best is a shortest path, found by breadth-first search; elsewhere H backward steps, or fewer, as soon as
//! nothing changes any more.

use super::TabularMdp;
use crate::env::Starts;
use serde::{Deserialize, Serialize};

/// Two returns this close, relative to their size, tie. Far above rounding, far below any difference that matters.
const TIE: f64 = 1e-12;
/// A value that changes by no more than this, relative to the largest, has settled.
const SETTLED: f64 = 1e-13;

/// Return and length of an episode of the best policy, in expectation over starts and chance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Optimum {
    /// Sum of rewards, undiscounted: R* of eq. 15 of the source paper.
    pub expected_return: f64,
    /// Number of steps; where all steps cost 1 and nothing is random, the shortest path.
    pub expected_steps: f64,
}

/// What lies ahead of a state under the best policy: return and steps, and the chance that the episode ends before its limit.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Ahead {
    worth: f64,
    steps: f64,
    ends: f64,
}

impl Ahead {
    /// Of a state where episodes end.
    const END: Ahead = Ahead {
        worth: 0.0,
        steps: 0.0,
        ends: 1.0,
    };
    /// With no step left.
    const CUT_OFF: Ahead = Ahead {
        worth: 0.0,
        steps: 0.0,
        ends: 0.0,
    };
}

/// The rewards of a world in which the best is a shortest path.
struct StepCost {
    step: f64,
    last: f64,
}

impl TabularMdp {
    /// The optimum over episodes that begin in one of `starts` and are truncated after `max_steps`.
    ///
    /// O(outcomes) if the world is deterministic and steps cost the same; otherwise O(outcomes × backward steps), of which
    /// there are about as many as the longest way takes, and at most `max_steps`.
    ///
    /// # Panics
    /// If `starts` is empty or names something that is no state, or `max_steps` is 0.
    pub fn optimum(&self, starts: impl Into<Starts>, max_steps: usize) -> Optimum {
        self.optimum_and_end(starts, max_steps).0
    }

    /// The optimum, and the chance that an episode of the policy that earns it ends before its limit. Of policies that are
    /// equal in return and steps, one that ends counts.
    pub(super) fn optimum_and_end(
        &self,
        starts: impl Into<Starts>,
        max_steps: usize,
    ) -> (Optimum, f64) {
        let starts = starts.into();
        assert!(!starts.places().is_empty(), "an episode begins somewhere");
        assert!(max_steps > 0, "an episode has at least one step");
        let best = match self.step_cost() {
            Some(cost) => self.shortest_paths(&cost, max_steps),
            None => self.backward_induction(starts.places(), max_steps),
        };
        let mean = |part: fn(&Ahead) -> f64| starts.mean(|&start| part(&best[start]));
        let optimum = Optimum {
            expected_return: mean(|best| best.worth),
            expected_steps: mean(|best| best.steps),
        };
        (optimum, mean(|best| best.ends))
    }

    /// The largest chance that any policy has to end an episode before its limit: the optimal return if only ends paid, and
    /// each of them 1.
    pub(super) fn best_chance_of_an_end(&self, starts: impl Into<Starts>, max_steps: usize) -> f64 {
        let mut ends_pay = self.clone();
        for outcome in &mut ends_pay.outcomes {
            outcome.reward = f64::from(u8::from(self.terminal[outcome.next as usize]));
        }
        ends_pay.optimal_return(starts, max_steps)
    }

    /// The return of [`optimum`](Self::optimum).
    ///
    /// # Panics
    /// As [`optimum`](Self::optimum).
    pub fn optimal_return(&self, starts: impl Into<Starts>, max_steps: usize) -> f64 {
        self.optimum(starts, max_steps).expected_return
    }

    /// The steps of [`optimum`](Self::optimum).
    ///
    /// # Panics
    /// As [`optimum`](Self::optimum).
    pub fn optimal_steps(&self, starts: impl Into<Starts>, max_steps: usize) -> f64 {
        self.optimum(starts, max_steps).expected_steps
    }

    /// The one cost of a step and the one reward of the last, if the world is so simple that shortest paths are best.
    fn step_cost(&self) -> Option<StepCost> {
        if self
            .outcomes
            .iter()
            .any(|outcome| outcome.probability != 1.0)
        {
            return None;
        }
        let mut step = None;
        let mut last = None;
        for outcome in &self.outcomes {
            let known = if self.terminal[outcome.next as usize] {
                &mut last
            } else {
                &mut step
            };
            if *known.get_or_insert(outcome.reward) != outcome.reward {
                return None;
            }
        }
        let (step, last) = (step?, last?);
        // Ending must not be worse than going on, or waiting for the clock could beat the shortest path.
        (step < 0.0 && last >= step).then_some(StepCost { step, last })
    }

    fn shortest_paths(&self, cost: &StepCost, max_steps: usize) -> Vec<Ahead> {
        let best = |distance: Option<u32>| match distance {
            Some(0) => Ahead::END,
            Some(steps) if steps as usize <= max_steps => Ahead {
                worth: cost.step * f64::from(steps - 1) + cost.last,
                steps: f64::from(steps),
                ends: 1.0,
            },
            _ => Ahead {
                worth: cost.step * max_steps as f64,
                steps: max_steps as f64,
                ends: 0.0,
            },
        };
        self.distances_to_terminal().into_iter().map(best).collect()
    }

    /// v_H and its steps for every state that can be reached from `starts`; zeros for the others.
    fn backward_induction(&self, starts: &[usize], max_steps: usize) -> Vec<Ahead> {
        let reached = self.reachable_from(starts);
        let states: Vec<_> = (0..self.num_states())
            .filter(|&s| reached[s] && !self.terminal[s])
            .collect();
        let dead_ends = self.dead_ends_only_lose();
        let at_the_limit = |&ends: &bool| if ends { Ahead::END } else { Ahead::CUT_OFF };
        let mut now: Vec<Ahead> = self.terminal.iter().map(at_the_limit).collect();
        let mut next = now.clone();
        for _ in 0..max_steps {
            let mut settled = true;
            let mut largest = 1.0_f64;
            for &state in &states {
                next[state] = self.best_action(&now, state);
                largest = largest.max(next[state].worth.abs()).max(next[state].steps);
            }
            for &state in &states {
                let gain = next[state].worth - now[state].worth;
                let longer = (next[state].steps - now[state].steps).abs();
                let still = gain.abs().max(longer) <= SETTLED * largest;
                settled &= still || (dead_ends[state] && gain <= 0.0);
            }
            std::mem::swap(&mut now, &mut next);
            if settled {
                break;
            }
        }
        now
    }

    /// States that no longer matter once all others have settled: no way leads out of them to an end, and all their steps
    /// cost something, so that what they are worth only ever falls and a policy that avoids them goes on avoiding them.
    fn dead_ends_only_lose(&self) -> Vec<bool> {
        let ends = self.distances_to_terminal();
        let is_lost = |state: usize| ends[state].is_none();
        let loses = |state: usize| {
            self.outcomes_of_state(state)
                .iter()
                .all(|outcome| outcome.reward <= 0.0)
        };
        let all_lose = (0..self.num_states()).all(|state| !is_lost(state) || loses(state));
        (0..self.num_states())
            .map(|state| all_lose && is_lost(state))
            .collect()
    }

    /// One backward step in `state`: the largest return, and of equal ones the fewest steps.
    fn best_action(&self, later: &[Ahead], state: usize) -> Ahead {
        let mut best = Ahead {
            worth: f64::NEG_INFINITY,
            steps: f64::INFINITY,
            ends: 0.0,
        };
        for action in self.actions() {
            let mut this = Ahead {
                worth: 0.0,
                steps: 1.0,
                ends: 0.0,
            };
            for outcome in self.outcomes(state, action) {
                let then = &later[outcome.next as usize];
                this.worth += outcome.probability * (outcome.reward + then.worth);
                this.steps += outcome.probability * then.steps;
                this.ends += outcome.probability * then.ends;
            }
            let margin = TIE * this.worth.abs().max(1.0);
            let ties = (this.worth - best.worth).abs() <= margin;
            if (ties && this.steps < best.steps) || (!ties && this.worth > best.worth) {
                best = this;
            } else if ties && this.steps == best.steps {
                best.ends = best.ends.max(this.ends);
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::Outcome;

    fn to(next: u32, reward: f64) -> Vec<Outcome> {
        vec![Outcome {
            next,
            probability: 1.0,
            reward,
        }]
    }

    /// A corridor of `length` steps to the end: action 0 goes on, action 1 stays.
    fn corridor(length: u32, step: f64, last: f64) -> TabularMdp {
        let state = |s: u32| {
            vec![
                to(s + 1, if s + 1 == length { last } else { step }),
                to(s, step),
            ]
        };
        let transitions: Vec<_> = (0..=length).map(state).collect();
        // What stands in the last state's list is beyond the end; terminal states have no outcomes.
        let terminal = (0..=length).map(|s| s == length).collect();
        TabularMdp::new(&transitions, terminal).unwrap()
    }

    #[test]
    fn shortest_path_and_backward_induction_agree() {
        for max_steps in [1, 3, 4, 5, 40] {
            let mdp = corridor(4, -1.0, 99.0);
            let cost = mdp.step_cost().expect("a corridor has one step cost");
            let short = mdp.shortest_paths(&cost, max_steps);
            assert_eq!(
                short,
                mdp.backward_induction(&[0], max_steps),
                "max_steps {max_steps}"
            );
        }
    }

    #[test]
    fn an_end_that_hurts_is_avoided() {
        let best = corridor(2, -1.0, -50.0).optimum(&[0], 10);
        assert_eq!(
            best,
            Optimum {
                expected_return: -10.0,
                expected_steps: 10.0
            }
        );
    }

    #[test]
    fn equal_returns_take_the_fewest_steps() {
        let best = corridor(3, 0.0, 1.0).optimum(&[0], 30);
        assert_eq!(
            best,
            Optimum {
                expected_return: 1.0,
                expected_steps: 3.0
            }
        );
    }

    /// With p the chance of one try, 1 − (1 − p)^H; an end that hurts is left alone although it could be had.
    #[test]
    fn the_chance_of_an_end_is_that_of_the_best_policy() {
        assert_eq!(corridor(4, -1.0, 99.0).optimum_and_end(&[0], 3).1, 0.0);
        // With the last step to go it does not matter; the policy that ends counts.
        assert_eq!(corridor(4, -1.0, -1.0).optimum_and_end(&[0], 4).1, 1.0);
        let hurts = corridor(2, -1.0, -50.0);
        assert_eq!(hurts.optimum_and_end(&[0], 10).1, 0.0);
        assert_eq!(hurts.best_chance_of_an_end(&[0], 10), 1.0);
        assert_eq!(hurts.best_chance_of_an_end(&[0], 1), 0.0);
        let mut again = to(0, -1.0);
        again[0].probability = 0.75;
        let mut end = to(1, -1.0);
        end[0].probability = 0.25;
        let tries = vec![[again, end].concat()];
        let mdp = TabularMdp::new(&[tries, vec![]], vec![false, true]).unwrap();
        let expected = 1.0 - 0.75_f64.powi(7);
        assert!((mdp.optimum_and_end(&[0], 7).1 - expected).abs() < 1e-14);
        assert!((mdp.best_chance_of_an_end(&[0], 7) - expected).abs() < 1e-14);
    }

    #[test]
    fn two_starts_are_averaged() {
        assert_eq!(corridor(4, -1.0, -1.0).optimal_steps(&[0, 2], 40), 3.0);
        assert_eq!(corridor(4, -1.0, -1.0).optimal_return(&[0, 2], 40), -3.0);
    }

    #[test]
    fn weighted_starts_weigh_the_optima_of_single_ones() {
        let mdp = corridor(6, -1.0, 20.0);
        let weights = [(0, 0.5), (5, 3.0), (2, 1.5)];
        for max_steps in [3, 40] {
            let (mut earned, mut taken) = (0.0, 0.0);
            for (start, weight) in weights {
                let single = mdp.optimum(&[start], max_steps);
                earned += weight / 5.0 * single.expected_return;
                taken += weight / 5.0 * single.expected_steps;
            }
            let whole = mdp.optimum(Starts::weighted(weights), max_steps);
            assert!((whole.expected_return - earned).abs() < 1e-12, "{whole:?}");
            assert!((whole.expected_steps - taken).abs() < 1e-12, "{whole:?}");
        }
    }

    #[test]
    fn retries_are_cut_by_the_limit() {
        let p = 0.25;
        let again = Outcome {
            next: 0,
            probability: 1.0 - p,
            reward: -1.0,
        };
        let end = Outcome {
            next: 1,
            probability: p,
            reward: -1.0,
        };
        let mdp = TabularMdp::new(&[vec![vec![again, end]], vec![]], vec![false, true]).unwrap();
        for max_steps in [1, 2, 10, 1000] {
            let expected = (1.0 - (1.0 - p).powi(max_steps as i32)) / p;
            assert!((mdp.optimal_steps(&[0], max_steps) - expected).abs() < 1e-10);
            assert!((mdp.optimal_return(&[0], max_steps) + expected).abs() < 1e-10);
        }
    }

    #[test]
    fn a_dead_end_beside_the_way_does_not_keep_the_induction_going() {
        // 0 → end at −3, or into a dead end 2: waiting there is worse, however large the limit.
        let mdp = TabularMdp::new(
            &[
                vec![to(1, -3.0), to(2, -2.0)],
                vec![],
                vec![to(2, -1.0), to(2, -1.0)],
            ],
            vec![false, true, false],
        );
        let best = mdp.unwrap().optimum(&[0], usize::MAX);
        assert_eq!(
            best,
            Optimum {
                expected_return: -3.0,
                expected_steps: 1.0
            }
        );
    }
}
