//! What the agent has learnt about the ends of its episodes: goals and labels.

use crate::graph::StateId;
use crate::shaping::Goal;

/// Running sums of one terminal state.
#[derive(Clone, Copy, Debug)]
struct Ending {
    state: StateId,
    reward_sum: f64,
    count: u32,
}

/// Goals seen, labels of the trajectories (section 4.1 of the source report), and the typical cost of a step.
#[derive(Clone, Debug, Default)]
pub struct GoalBook {
    endings: Vec<Ending>,
    goals: Vec<Goal>,
    labels: Vec<(StateId, usize)>,
    is_labelled: Vec<bool>,
    step_rewards: f64,
    steps: u64,
}

impl GoalBook {
    /// Counts the reward of a step that ended nothing.
    pub fn count_step(&mut self, reward: f64) {
        self.step_rewards += reward;
        self.steps += 1;
    }

    /// Counts a termination in `state`; true if this is a goal not seen before. O(goals).
    pub fn count_ending(&mut self, state: StateId, reward: f64) -> bool {
        if let Some(ending) = self.endings.iter_mut().find(|ending| ending.state == state) {
            ending.reward_sum += reward;
            ending.count += 1;
            return false;
        }
        self.endings.push(Ending {
            state,
            reward_sum: reward,
            count: 1,
        });
        true
    }

    /// Labels the two ends of a trajectory: the start as not rewarding, the end as rewarding if it is a goal.
    /// A state keeps the first label it got, except that a goal is always rewarding.
    pub fn label_trajectory(&mut self, start: StateId, end: StateId, at_goal: bool) {
        self.label(start, 0);
        self.label(end, usize::from(at_goal));
    }

    fn label(&mut self, state: StateId, class: usize) {
        if state.index() >= self.is_labelled.len() {
            self.is_labelled.resize(state.index() + 1, false);
        }
        if !std::mem::replace(&mut self.is_labelled[state.index()], true) {
            self.labels.push((state, class));
        } else if class == 1
            && let Some(label) = self.labels.iter_mut().find(|label| label.0 == state)
        {
            label.1 = 1;
        }
    }

    /// Whether no goal has been seen.
    pub fn is_empty(&self) -> bool {
        self.endings.is_empty()
    }

    /// The goals with their mean rewards, in the order of their discovery.
    pub fn goals(&mut self) -> &[Goal] {
        self.goals.clear();
        self.goals.extend(self.endings.iter().map(|ending| Goal {
            state: ending.state,
            reward: ending.reward_sum / f64::from(ending.count),
        }));
        &self.goals
    }

    /// The goals' states, in the order of their discovery.
    pub fn states(&self) -> impl Iterator<Item = StateId> + '_ {
        self.endings.iter().map(|ending| ending.state)
    }

    /// Labelled states, class 1 = rewarding.
    pub fn labels(&self) -> &[(StateId, usize)] {
        &self.labels
    }

    /// Forgets a goal that turned out to be none any more.
    pub fn forget(&mut self, state: StateId) -> bool {
        let before = self.endings.len();
        self.endings.retain(|ending| ending.state != state);
        if let Some(label) = self.labels.iter_mut().find(|label| label.0 == state) {
            label.1 = 0;
        }
        self.endings.len() < before
    }

    /// Mean cost −r of a step, at least 0.
    pub fn step_cost(&self) -> f64 {
        if self.steps == 0 {
            0.0
        } else {
            (-self.step_rewards / self.steps as f64).max(0.0)
        }
    }

    /// By how many steps each goal is worse than the best one: (state, ⌈(r* − r) ÷ step cost⌉).
    pub fn handicaps(&mut self) -> Vec<(StateId, u32)> {
        /// Where steps cost nothing, a goal of less reward is never worth it while the best one is in reach.
        const HOPELESS: f64 = 1e6;
        let step_cost = self.step_cost();
        let goals = self.goals();
        let best = goals
            .iter()
            .map(|goal| goal.reward)
            .fold(f64::NEG_INFINITY, f64::max);
        goals
            .iter()
            .map(|goal| {
                let loss = best - goal.reward;
                let steps = if loss == 0.0 {
                    0.0
                } else {
                    (loss / step_cost).min(HOPELESS)
                };
                (goal.state, steps.ceil() as u32)
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn goals_carry_mean_rewards_and_handicaps_count_steps() {
        let mut book = GoalBook::default();
        book.count_step(-2.0);
        assert!(book.count_ending(StateId(3), 10.0));
        assert!(!book.count_ending(StateId(3), 20.0));
        assert!(book.count_ending(StateId(5), 10.0));
        assert_eq!(book.goals()[0].reward, 15.0);
        assert_eq!(book.handicaps(), [(StateId(3), 0), (StateId(5), 3)]);
    }

    #[test]
    fn a_goal_overrides_an_earlier_label_and_can_be_forgotten() {
        let mut book = GoalBook::default();
        book.label_trajectory(StateId(0), StateId(4), false);
        book.label_trajectory(StateId(0), StateId(4), true);
        assert_eq!(book.labels(), [(StateId(0), 0), (StateId(4), 1)]);
        book.count_ending(StateId(4), 0.0);
        assert!(book.forget(StateId(4)));
        assert!(book.is_empty());
        assert_eq!(book.labels(), [(StateId(0), 0), (StateId(4), 0)]);
    }
}
