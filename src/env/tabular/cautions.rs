//! Cautions about an episodic task that is other than it seems: the best policy does not seek its goals, or cannot reach them in time.
//!
//! All are statements about the best policies of the world under its step limit, found by the same backward induction as
//! the optimum, by breadth-first search, and by the best gain of its loops.

use super::{Optimum, TabularMdp};
use crate::env::Starts;
use std::fmt;

/// A chance of ending below this, or below this share of what is possible, is worth a word.
const HALF: f64 = 0.5;
/// A chance of ending below this is none.
const NONE: f64 = 1e-9;
/// Goals beyond the limit that are named one by one.
const MAX_NAMED: usize = 5;

/// A property that whoever wrote the world may not have meant; the message says what it is and what to do.
#[derive(Clone, Debug, PartialEq)]
pub enum Caution {
    /// No start has a way to any end that is short enough.
    NoGoalWithinLimit {
        /// Fewest steps from a start to an end.
        steps: u32,
        /// Limit of an episode.
        max_steps: usize,
    },
    /// No start has a way to this end that is short enough, while others are near enough.
    GoalBeyondLimit {
        /// The end's state.
        goal: usize,
        /// Fewest steps to it from a start.
        steps: u32,
        /// Limit of an episode.
        max_steps: usize,
    },
    /// However hard it tries, a policy ends few episodes within the limit.
    SeldomWithinLimit {
        /// Largest chance of an end.
        possible: f64,
        /// Limit of an episode.
        max_steps: usize,
    },
    /// The best policy stays away from the ends.
    StayingAwayIsBest {
        /// Its chance of an end.
        ends: f64,
        /// Largest chance of an end.
        possible: f64,
        /// What it earns and how long it takes.
        optimum: Optimum,
    },
    /// A loop earns something on average: the longer an episode, the better.
    PaysForEver {
        /// Mean reward of a step.
        gain: f64,
        /// Limit of an episode.
        max_steps: usize,
    },
}

impl TabularMdp {
    /// What deserves a word about episodes that begin in one of `starts` and are truncated after `max_steps`. Costs as much
    /// as [`optimum`](Self::optimum), or twice that where few episodes of the best policy end.
    ///
    /// # Panics
    /// As [`optimum`](Self::optimum).
    pub fn cautions(&self, starts: impl Into<Starts>, max_steps: usize) -> Vec<Caution> {
        let starts = starts.into();
        let mut cautions = self.beyond_limit(starts.places(), max_steps);
        let none_in_time = matches!(cautions[..], [Caution::NoGoalWithinLimit { .. }]);
        let (optimum, ends) = self.optimum_and_end(&starts, max_steps);
        if ends < HALF && !none_in_time {
            let possible = self.best_chance_of_an_end(&starts, max_steps);
            if possible < HALF {
                cautions.push(Caution::SeldomWithinLimit {
                    possible,
                    max_steps,
                });
            }
            if ends < HALF * possible {
                cautions.push(Caution::StayingAwayIsBest {
                    ends,
                    possible,
                    optimum,
                });
            }
        }
        if let Some(gain) = self.best_gain(starts.places()) {
            cautions.push(Caution::PaysForEver { gain, max_steps });
        }
        cautions
    }

    /// Ends whose nearest start is too far from them; those that no start leads to have no distance.
    fn beyond_limit(&self, starts: &[usize], max_steps: usize) -> Vec<Caution> {
        let distances = self.distances_from(starts);
        let ends = (0..self.num_states()).filter(|&state| self.terminal[state]);
        let ends: Vec<(usize, u32)> = ends
            .filter_map(|state| Some((state, distances[state]?)))
            .collect();
        let Some(nearest) = ends.iter().map(|&(_, steps)| steps).min() else {
            return Vec::new();
        };
        if nearest as usize > max_steps {
            return vec![Caution::NoGoalWithinLimit {
                steps: nearest,
                max_steps,
            }];
        }
        let beyond = ends.into_iter().filter(|&(_, s)| s as usize > max_steps);
        let named = beyond.take(MAX_NAMED);
        named
            .map(|(goal, steps)| Caution::GoalBeyondLimit {
                goal,
                steps,
                max_steps,
            })
            .collect()
    }
}

impl Caution {
    /// The message; `name` says how a state is called.
    pub fn message(&self, name: impl Fn(usize) -> String) -> String {
        match *self {
            Caution::NoGoalWithinLimit { steps, max_steps } => format!(
                "no goal can be reached within the limit of an episode: the nearest is {steps} steps away, max_steps is \
                 {max_steps}; raise max_steps"
            ),
            Caution::GoalBeyondLimit {
                goal,
                steps,
                max_steps,
            } => format!(
                "the goal {} cannot be reached within the limit of an episode: it is {steps} steps away, max_steps is \
                 {max_steps}; raise max_steps, or do without the goal",
                name(goal)
            ),
            Caution::SeldomWithinLimit {
                possible,
                max_steps,
            } => format!(
                "few episodes can reach a goal within their limit: {} at best, max_steps is {max_steps}; raise max_steps",
                Percent(possible)
            ),
            Caution::StayingAwayIsBest { ends, optimum, .. } if ends < NONE => format!(
                "never reaching a goal is best: the best return, {}, is that of staying away until the episode is cut off; \
                 let goals pay more, or steps less",
                Rounded(optimum.expected_return)
            ),
            Caution::StayingAwayIsBest {
                ends,
                possible,
                optimum,
            } => format!(
                "staying away from the goals is best: the policy of the best return, {}, reaches one in {} of its episodes, \
                 where {} are possible; let goals pay more, or steps less",
                Rounded(optimum.expected_return),
                Percent(ends),
                Percent(possible)
            ),
            Caution::PaysForEver { gain, max_steps } => format!(
                "a loop pays for ever, {} a step on average: only the limit of {max_steps} steps bounds the best return, and \
                 an agent may go round the loop instead of seeking a goal",
                Rounded(gain)
            ),
        }
    }
}

/// A share in percent.
struct Percent(f64);

impl fmt::Display for Percent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} %", Rounded(100.0 * self.0))
    }
}

/// A number to four significant digits.
struct Rounded(f64);

impl fmt::Display for Rounded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = format!("{:.3e}", self.0);
        match text.parse::<f64>() {
            Ok(rounded) => write!(f, "{rounded}"),
            Err(_) => f.write_str(&text),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::Outcome;

    fn sure(next: u32, reward: f64) -> Vec<Outcome> {
        vec![Outcome {
            next,
            probability: 1.0,
            reward,
        }]
    }

    /// Three steps to an end that pays `last`, each other step `step`; the other action stays.
    fn corridor(step: f64, last: f64) -> TabularMdp {
        let way = [
            vec![sure(1, step), sure(0, step)],
            vec![sure(2, step), sure(1, step)],
            vec![sure(3, last), sure(2, step)],
            vec![],
        ];
        TabularMdp::new(&way, vec![false, false, false, true]).unwrap()
    }

    #[test]
    fn a_goal_that_is_worth_its_way_is_no_reason_for_a_word() {
        assert_eq!(corridor(-1.0, -1.0).cautions(&[0], 3), []);
        assert_eq!(corridor(-1.0, -1.0).cautions(&[0, 1, 2], 30), []);
        // −2 and then −20 is better than thirty steps.
        assert_eq!(corridor(-1.0, -20.0).cautions(&[0], 30), []);
        assert_eq!(corridor(0.0, 0.0).cautions(&[0], 30), []);
    }

    #[test]
    fn a_goal_that_costs_more_than_waiting_is_not_worth_it() {
        let optimum = Optimum {
            expected_return: -30.0,
            expected_steps: 30.0,
        };
        let expected = Caution::StayingAwayIsBest {
            ends: 0.0,
            possible: 1.0,
            optimum,
        };
        let cautions = corridor(-1.0, -51.0).cautions(&[0], 30);
        assert_eq!(cautions, [expected]);
        let message = cautions[0].message(|state| state.to_string());
        assert!(message.contains("the best return, -30,"), "{message}");
        let free = corridor(0.0, -1.0).cautions(&[0], 30);
        assert!(matches!(free[..], [Caution::StayingAwayIsBest { .. }]));
    }

    #[test]
    fn a_limit_is_measured_by_the_shortest_way() {
        let expected = Caution::NoGoalWithinLimit {
            steps: 3,
            max_steps: 2,
        };
        assert_eq!(corridor(-1.0, -1.0).cautions(&[0], 2), [expected]);
        // A goal at hand, and one three steps behind the other way.
        let two = [
            vec![sure(4, -1.0), sure(1, -1.0)],
            vec![sure(2, -1.0), sure(1, -1.0)],
            vec![sure(3, 9.0), sure(2, -1.0)],
            vec![],
            vec![],
        ];
        let mdp = TabularMdp::new(&two, vec![false, false, false, true, true]).unwrap();
        let expected = Caution::GoalBeyondLimit {
            goal: 3,
            steps: 3,
            max_steps: 2,
        };
        assert_eq!(mdp.cautions(&[0], 2), [expected]);
        assert_eq!(mdp.cautions(&[0], 3), []);
    }

    /// A chance of .1 a step: 1 − .9^4 = .3439 within four steps.
    #[test]
    fn a_limit_that_luck_seldom_meets_is_named_with_the_chance() {
        let mut again = sure(0, -1.0);
        again[0].probability = 0.9;
        let mut end = sure(1, -1.0);
        end[0].probability = 0.1;
        let tries = vec![[again, end].concat()];
        let mdp = TabularMdp::new(&[tries, vec![]], vec![false, true]).unwrap();
        let cautions = mdp.cautions(&[0], 4);
        let [Caution::SeldomWithinLimit { possible, .. }] = cautions[..] else {
            panic!("{cautions:?}");
        };
        assert!((possible - 0.3439).abs() < 1e-12);
        assert!(
            cautions[0]
                .message(|_| String::new())
                .contains("34.39 % at best")
        );
        assert_eq!(mdp.cautions(&[0], 40), []);
    }

    #[test]
    fn a_loop_that_pays_is_named_whether_or_not_the_goal_is_sought() {
        let world = |goal: f64| {
            let actions = [vec![sure(0, 2.0), sure(1, goal)], vec![]];
            TabularMdp::new(&actions, vec![false, true]).unwrap()
        };
        let pays = |cautions: &[Caution]| {
            cautions.iter().any(
                |c| matches!(c, Caution::PaysForEver { gain, .. } if (gain - 2.0).abs() < 1e-5),
            )
        };
        let seeks = world(100.0).cautions(&[0], 10);
        assert!(pays(&seeks) && seeks.len() == 1, "{seeks:?}");
        let stays = world(0.0).cautions(&[0], 10);
        assert!(pays(&stays) && stays.len() == 2, "{stays:?}");
    }
}
