//! Statistics of the ends of episodes: goals, labels, and the typical cost of a step.

use crate::graph::StateId;
use crate::shaping::Goal;
use foldhash::fast::FixedState;
use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

/// An end that costs more than so many steps is none to seek while a better one may exist.
const DEAR: f64 = 3.0;

/// Running sums of one terminal state.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct Ending {
    reward_sum: f64,
    count: u32,
}

/// An end of episodes that is none any more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LostEnd {
    /// It was a goal.
    Goal,
    /// It was none.
    Other,
}

/// Goals seen, labels of the trajectories (section 4.1 of the source paper), and the typical cost of a step.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct GoalStatistics {
    /// Whether an end is a goal only if it pays.
    only_paying: bool,
    /// Of the goals, in the order of discovery.
    endings: IndexMap<StateId, Ending, FixedState>,
    /// The same with mean rewards.
    goals: Vec<Goal>,
    /// Of ends that pay too little to be goals.
    shunned: IndexMap<StateId, Ending, FixedState>,
    /// By state: whether episodes end there, as goals or otherwise.
    ends: Vec<bool>,
    /// The least and the most that a step that ended nothing has paid.
    pay: Option<(f64, f64)>,
    /// The most that an end has paid once, since the last goal was lost.
    best_end: Option<f64>,
    labels: Vec<(StateId, usize)>,
    /// By state: its place in `labels`.
    label_places: Vec<Option<u32>>,
    step_rewards: f64,
    steps: u64,
}

impl Ending {
    /// Counts one more; the mean of all.
    fn count(&mut self, reward: f64) -> f64 {
        self.reward_sum += reward;
        self.count += 1;
        self.reward_sum / f64::from(self.count)
    }
}

impl GoalStatistics {
    /// Nothing counted yet, of a world where an end is a goal only if it pays more than a step, or steps cost and it costs no more
    /// than three of them: to go on is worth more than other ends, and a better one may exist.
    pub fn of_paying_ends() -> Self {
        Self {
            only_paying: true,
            ..Self::default()
        }
    }

    /// Counts the reward of a step that ended nothing. O(1).
    #[inline]
    pub fn count_step(&mut self, reward: f64) {
        self.step_rewards += reward;
        self.steps += 1;
        let (least, most) = self.pay.unwrap_or((reward, reward));
        self.pay = Some((least.min(reward), most.max(reward)));
    }

    /// The most that a step that ended nothing has paid; 0 before the first one.
    fn most_pay(&self) -> f64 {
        self.pay.map_or(0.0, |(_, most)| most)
    }

    /// Whether anything was seen that pays, as far as is known: an end that paid more than nothing, or steps that end nothing and pay
    /// differently, some of them more than nothing.
    pub fn something_pays(&self) -> bool {
        let steps_pay = self
            .pay
            .is_some_and(|(least, most)| most > 0.0 && most > least);
        steps_pay || self.best_end.is_some_and(|best| best > 0.0)
    }

    /// Whether a termination that pays `reward` on average is one to seek. Where no time can be saved, it has to pay more than steps do.
    fn is_goal(&self, reward: f64, time_counts: bool) -> bool {
        let step = self.ordinary_reward();
        match time_counts {
            _ if !self.only_paying => true,
            true => reward > step || (step < 0.0 && reward >= DEAR * step),
            false => reward > self.most_pay().max(0.0),
        }
    }

    /// Time counts, or does not after all: says anew which ends are goals, and whether any was none or is none any more. O(ends).
    pub fn reconsider(&mut self, time_counts: bool) -> bool {
        let before = std::mem::take(&mut self.goals);
        let ends = std::mem::take(&mut self.endings);
        let others = std::mem::take(&mut self.shunned);
        for (state, ending) in ends.into_iter().chain(others) {
            self.add_ending(state, ending, time_counts);
        }
        self.goals != before
    }

    /// A goal, if it is one; true if so.
    fn add_ending(&mut self, state: StateId, ending: Ending, time_counts: bool) -> bool {
        let reward = ending.reward_sum / f64::from(ending.count);
        let is_goal = self.is_goal(reward, time_counts);
        if is_goal {
            self.endings.insert(state, ending);
            self.goals.push(Goal { state, reward });
        } else {
            self.shunned.insert(state, ending);
        }
        is_goal
    }

    /// Counts a termination in `state`; true if this is a goal not seen before. `time_counts` unless every episode takes as long. O(1).
    pub fn count_ending(&mut self, state: StateId, reward: f64, time_counts: bool) -> bool {
        if self.ends.len() <= state.index() {
            self.ends.resize(state.index() + 1, false);
        }
        self.ends[state.index()] = true;
        self.best_end = Some(self.best_end.map_or(reward, |best| best.max(reward)));
        if let Some((place, _, ending)) = self.endings.get_full_mut(&state) {
            self.goals[place].reward = ending.count(reward);
            return false;
        }
        let mut ending = self.shunned.swap_remove(&state).unwrap_or_default();
        ending.count(reward);
        self.add_ending(state, ending, time_counts)
    }

    /// Labels the two ends of a trajectory: the start as not rewarding, the end as rewarding if it is a goal.
    /// A state keeps the first label it got, except that a goal is always rewarding.
    pub fn label_trajectory(&mut self, start: StateId, end: StateId, at_goal: bool) {
        self.label(start, 0);
        self.label(end, usize::from(at_goal));
    }

    fn label(&mut self, state: StateId, class: usize) {
        if state.index() >= self.label_places.len() {
            self.label_places.resize(state.index() + 1, None);
        }
        match self.label_places[state.index()] {
            None => {
                self.label_places[state.index()] = Some(self.labels.len() as u32);
                self.labels.push((state, class));
            }
            Some(place) if class == 1 => self.labels[place as usize].1 = 1,
            Some(_) => {}
        }
    }

    /// Whether no goal is known.
    pub fn is_empty(&self) -> bool {
        self.goals.is_empty()
    }

    /// The goals with their mean rewards, in the order of their discovery.
    pub fn goals(&self) -> &[Goal] {
        &self.goals
    }

    /// Labelled states, class 1 = rewarding.
    pub fn labels(&self) -> &[(StateId, usize)] {
        &self.labels
    }

    /// By state: whether episodes end there, as goals or otherwise; shorter if the last ones are none.
    pub fn ends(&self) -> &[bool] {
        &self.ends
    }

    /// Whether anything was seen that a return could be made of: an end, or a step that paid.
    pub fn returns_differ(&self) -> bool {
        self.most_pay() > 0.0 || !self.endings.is_empty() || !self.shunned.is_empty()
    }

    /// Forgets the end at `state`, because an episode went on there. O(1), or O(goals) if it was a goal.
    #[inline]
    pub fn forget(&mut self, state: StateId) -> Option<LostEnd> {
        match self.ends.get(state.index()) {
            Some(true) => Some(self.forget_end(state)),
            _ => None,
        }
    }

    #[cold]
    fn forget_end(&mut self, state: StateId) -> LostEnd {
        self.ends[state.index()] = false;
        let Some((place, _, _)) = self.endings.shift_remove_full(&state) else {
            self.shunned.swap_remove(&state);
            return LostEnd::Other;
        };
        self.goals.remove(place);
        if self.goals.is_empty() {
            self.best_end = None;
        }
        if let Some(&Some(label)) = self.label_places.get(state.index()) {
            self.labels[label as usize].1 = 0;
        }
        LostEnd::Goal
    }

    /// Whether `state` is a goal. O(1).
    pub fn contains(&self, state: StateId) -> bool {
        self.endings.contains_key(&state)
    }

    /// What the best goal pays on average; −∞ without goals.
    pub fn best_reward(&self) -> f64 {
        let rewards = self.goals.iter().map(|goal| goal.reward);
        rewards.fold(f64::NEG_INFINITY, f64::max)
    }

    /// Whether some goal pays more than nothing.
    pub fn pays(&self) -> bool {
        self.goals.iter().any(|goal| goal.reward > 0.0)
    }

    /// Mean reward of the steps that ended nothing; 0 before the first one.
    pub fn ordinary_reward(&self) -> f64 {
        match self.steps {
            0 => 0.0,
            steps => self.step_rewards / steps as f64,
        }
    }

    /// Mean cost −r of the steps that ended nothing, at least 0; 0 before the first one.
    pub fn step_cost(&self) -> f64 {
        (-self.ordinary_reward()).max(0.0)
    }

    /// By how many steps each goal is worse than the best one: (state, ⌈(r* − r) ÷ step cost⌉).
    ///
    /// Where steps cost nothing that is 10⁶ for every goal of less reward.
    pub fn handicaps(&self) -> Vec<(StateId, u32)> {
        /// Where steps cost nothing, a goal of less reward is never worth it while the best one is in reach.
        const HOPELESS: f64 = 1e6;
        let step_cost = self.step_cost();
        let best = self.best_reward();
        self.goals
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
        let mut goals = GoalStatistics::default();
        goals.count_step(-2.0);
        assert!(goals.count_ending(StateId(3), 10.0, true));
        assert!(!goals.count_ending(StateId(3), 20.0, true));
        assert!(goals.count_ending(StateId(5), 10.0, true));
        assert_eq!(goals.goals()[0].reward, 15.0);
        assert!(goals.pays());
        assert_eq!(goals.handicaps(), [(StateId(3), 0), (StateId(5), 3)]);
    }

    #[test]
    fn a_goal_overrides_an_earlier_label_and_can_be_forgotten() {
        let mut goals = GoalStatistics::default();
        goals.label_trajectory(StateId(0), StateId(4), false);
        goals.label_trajectory(StateId(0), StateId(4), true);
        assert_eq!(goals.labels(), [(StateId(0), 0), (StateId(4), 1)]);
        goals.count_ending(StateId(4), 0.0, true);
        assert_eq!(goals.forget(StateId(4)), Some(LostEnd::Goal));
        assert_eq!(
            goals.forget(StateId(4)),
            None,
            "there is nothing left to forget"
        );
        assert!(goals.is_empty());
        assert_eq!(goals.labels(), [(StateId(0), 0), (StateId(4), 0)]);
    }

    #[test]
    fn forgetting_keeps_the_order_of_the_others_and_their_means() {
        let mut goals = GoalStatistics::default();
        for (state, reward) in [(7, 1.0), (2, 2.0), (9, 3.0)] {
            goals.count_ending(StateId(state), reward, true);
        }
        assert_eq!(goals.forget(StateId(0)), None);
        assert_eq!(goals.forget(StateId(2)), Some(LostEnd::Goal));
        assert!(!goals.count_ending(StateId(9), 5.0, true));
        let means: Vec<_> = goals
            .goals()
            .iter()
            .map(|g| (g.state.0, g.reward))
            .collect();
        assert_eq!(means, [(7, 1.0), (9, 4.0)]);
        assert!(
            goals.count_ending(StateId(2), 8.0, true),
            "found again, it is new"
        );
        assert_eq!(
            goals.goals()[2].reward,
            8.0,
            "what it paid once does not count"
        );
    }

    #[test]
    fn free_steps_make_a_lesser_goal_hopeless_and_costly_rewards_do_not() {
        let mut goals = GoalStatistics::default();
        assert_eq!(goals.step_cost(), 0.0);
        assert!(!goals.pays(), "nothing is known to pay");
        goals.count_step(0.5);
        assert_eq!(goals.step_cost(), 0.0, "steps that pay cost nothing");
        goals.count_ending(StateId(0), 1.0, true);
        goals.count_ending(StateId(1), 2.0, true);
        assert_eq!(
            goals.handicaps(),
            [(StateId(0), 1_000_000), (StateId(1), 0)]
        );
        goals.count_step(-1.5);
        assert_eq!(goals.step_cost(), 0.5);
        assert_eq!(goals.handicaps(), [(StateId(0), 2), (StateId(1), 0)]);
    }

    #[test]
    fn where_only_what_pays_is_a_goal_lava_is_none_and_a_fee_is_none_to_speak_of() {
        // Steps of −1: lava, a dear exit, one that costs what three steps do, one that pays.
        let mut goals = GoalStatistics::of_paying_ends();
        (0..10).for_each(|_| goals.count_step(-1.0));
        assert!(!goals.count_ending(StateId(1), -50.0, true));
        assert!(!goals.count_ending(StateId(2), -3.5, true));
        assert!(goals.is_empty() && !goals.contains(StateId(1)));
        assert!(
            goals.count_ending(StateId(3), -3.0, true) && goals.count_ending(StateId(4), 9.0, true)
        );
        assert_eq!(goals.best_reward(), 9.0);
        assert!(goals.contains(StateId(4)));
        assert!(goals.ends()[1] && goals.returns_differ());
        assert_eq!(goals.forget(StateId(1)), Some(LostEnd::Other));
        assert!(!goals.ends()[1]);
        // Free steps: a hole pays as little as they do.
        let mut goals = GoalStatistics::of_paying_ends();
        goals.count_step(0.0);
        assert!(!goals.count_ending(StateId(1), 0.0, true));
        assert!(goals.count_ending(StateId(2), 0.1, true));
        // Steps that pay 5: an end that pays 5 ends them.
        let mut goals = GoalStatistics::of_paying_ends();
        goals.count_step(5.0);
        assert!(
            !goals.count_ending(StateId(1), 5.0, true) && goals.count_ending(StateId(2), 6.0, true)
        );
    }

    #[test]
    fn an_end_becomes_a_goal_when_it_turns_out_to_pay() {
        let mut goals = GoalStatistics::of_paying_ends();
        assert!(
            !goals.count_ending(StateId(1), -1.0, true),
            "nothing to compare with"
        );
        goals.count_step(-1.0);
        assert!(goals.count_ending(StateId(1), -1.0, true));
        assert!(
            !goals.count_ending(StateId(1), -4.0, true),
            "it is one already"
        );
        assert_eq!(goals.goals()[0].reward, -2.0);
    }

    #[test]
    fn a_state_keeps_its_first_label_unless_it_turns_out_a_goal() {
        let mut goals = GoalStatistics::default();
        goals.label_trajectory(StateId(0), StateId(1), true);
        goals.label_trajectory(StateId(1), StateId(2), false);
        assert_eq!(
            goals.labels(),
            [(StateId(0), 0), (StateId(1), 1), (StateId(2), 0)]
        );
    }
}
