//! The range of rewards seen so far, and what an episode could pay by it.
//!
//! The theory of optimism knows from the start that rewards lie in [0, 1]. An agent that is told nothing goes by what it has
//! seen, and supposes that what pays may pay four times as much elsewhere: or else it would settle for the first thing that pays
//! again and again. As long as all it has seen is 0, it hopes for an end that pays 1.

use crate::env::StepStatus;
use serde::{Deserialize, Serialize};

/// Hoped for at an end, while no reward but 0 has been seen.
const HOPE: f64 = 1.0;

/// By how much the largest reward of the world may exceed the largest one seen, if that pays at all.
const MORE: f64 = 4.0;

/// More than `reward`, if it pays.
fn hoped(reward: f64) -> f64 {
    reward.max(MORE * reward)
}

/// Extremes of the rewards seen, and the smallest return of an episode.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct RewardRange {
    smallest: f64,
    /// Of all steps; of those that did not end the task.
    largest: Option<f64>,
    largest_on_the_way: Option<f64>,
    /// Return of the episode so far; of the worst one.
    so_far: f64,
    worst_return: f64,
}

impl RewardRange {
    /// Takes a reward in.
    pub fn note(&mut self, reward: f64, status: StepStatus) {
        let larger = |than: Option<f64>| Some(than.map_or(reward, |than| than.max(reward)));
        self.smallest = self.smallest.min(reward);
        self.largest = larger(self.largest);
        if status != StepStatus::Terminated {
            self.largest_on_the_way = larger(self.largest_on_the_way);
        }
        self.so_far += reward;
        if status.is_last() {
            self.worst_return = self.worst_return.min(self.so_far);
            self.so_far = 0.0;
        }
    }

    /// How far the return of an episode may be from another's, a step of `steps`: from the worst one seen, or 0, to the best there
    /// could be, and at least from one extreme of the rewards to the other. Above 0.
    pub fn per_step(&self, steps: usize, gamma: f64) -> f64 {
        let span = self.best_return(steps, gamma, 0.0) - self.worst_return;
        span.max(self.width()) / steps as f64
    }

    /// How far apart the extremes of all rewards and 0 are; above 0.
    fn width(&self) -> f64 {
        match self.largest.unwrap_or(0.0).max(0.0) - self.smallest {
            0.0 => HOPE,
            width => width,
        }
    }

    /// The largest return of at most `steps` ≥ 1 steps, by four times the rewards seen that pay, each of them `bonus` larger: the
    /// largest on the way for as long as it gains anything, and the largest of all at last.
    pub fn best_return(&self, steps: usize, gamma: f64, bonus: f64) -> f64 {
        let last = match self.largest {
            None | Some(0.0) if self.smallest == 0.0 => HOPE,
            largest => hoped(largest.unwrap_or(0.0)),
        };
        let last = last + bonus;
        let on_the_way = hoped(self.largest_on_the_way.unwrap_or(0.0)) + bonus;
        if on_the_way <= 0.0 || steps <= 1 {
            return last;
        }
        let before = (steps - 1) as f64;
        let (sum, discount) = match gamma {
            1.0 => (before, 1.0),
            _ => {
                let discount = libm::pow(gamma, before);
                ((1.0 - discount) / (1.0 - gamma), discount)
            }
        };
        (on_the_way * sum + discount * last).max(last)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use StepStatus::{Running, Terminated};

    fn of(rewards: &[(f64, StepStatus)]) -> RewardRange {
        let mut range = RewardRange::default();
        rewards
            .iter()
            .for_each(|&(r, status)| range.note(r, status));
        range
    }

    #[test]
    fn steps_that_cost_are_best_ended_and_steps_that_pay_repeated() {
        let nothing = of(&[]);
        assert_eq!(
            (nothing.width(), nothing.best_return(9, 1.0, 0.0)),
            (1.0, 1.0)
        );
        let free = of(&[(0.0, Running), (0.0, Terminated)]);
        assert_eq!((free.width(), free.best_return(9, 1.0, 0.0)), (1.0, 1.0));
        let grid = of(&[(-1.0, Running)]);
        assert_eq!((grid.width(), grid.best_return(9, 1.0, 0.0)), (1.0, -1.0));
        let with_goal = of(&[(-1.0, Running), (0.0, Terminated)]);
        assert_eq!(with_goal.best_return(9, 1.0, 0.0), 0.0);
        let river = of(&[(5.0, Running), (0.0, Running)]);
        assert_eq!(
            (river.width(), river.best_return(20, 1.0, 0.0)),
            (5.0, 400.0)
        );
        let both = of(&[(2.0, Running), (-4.0, Running), (30.0, Terminated)]);
        assert_eq!(
            (both.width(), both.best_return(3, 1.0, 0.0)),
            (34.0, 16.0 + 120.0)
        );
        // Ending at once is better than 8.5 + 8.5 / 2 + 120.5 / 4.
        assert_eq!(both.best_return(3, 0.5, 0.5), 120.5);
        assert_eq!(river.best_return(3, 0.5, 1.0), 21.0 + 10.5 + 5.25);
    }

    #[test]
    fn returns_reach_down_to_the_worst_episode() {
        let steps = [(-1.0, Running), (-1.0, Running), (-1.0, Terminated)];
        assert_eq!(of(&steps[..2]).per_step(8, 1.0), 1.0 / 8.0);
        assert_eq!(of(&steps).per_step(8, 1.0), 2.0 / 8.0);
        let more = [&steps[..], &[(0.0, Terminated)]].concat();
        assert_eq!(of(&more).per_step(8, 1.0), 3.0 / 8.0);
    }
}
