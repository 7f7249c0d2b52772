//! Limits of rewards, so that all that is made of them stays a number that can be written and read back.
//!
//! ```text
//! |r| ≤ 10²⁷ / T,   T = min(run.episodes × max_steps, 2⁶⁴) steps of a run;     r = 0 or |r| ≥ 10⁻³⁰
//! ```
//!
//! Returns, regrets and R* over a run are then at most 10²⁷ in size, and their squares, their ratios and the sums over seeds
//! far below the largest `f64`. A potential is at most `scale_factor` ≤ 10⁶ times the costliest way, which leaves snapshots
//! room in `f32`. Next to a reward of less than 10⁻³⁰ others would count as infinite.

use super::env::{EnvParams, GoalList};
use super::error::BrokenRule;
use super::layout::STATES;
use crate::env::{EdgeList, LARGEST_RETURN, RewardScheme, SMALLEST_REWARD};

/// Steps are counted in 64 bits.
const MOST_STEPS: f64 = u64::MAX as f64;

/// How long a run may take.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    /// Episodes of the run.
    pub episodes: usize,
    /// The longest episode.
    pub max_steps: usize,
}

impl Extent {
    fn steps(self) -> f64 {
        (self.episodes as f64 * self.max_steps as f64).min(MOST_STEPS)
    }

    /// The rule that a reward breaks, if it does.
    fn broken_by(self, reward: f64) -> Option<String> {
        let (size, steps) = (reward.abs(), self.steps());
        let most = LARGEST_RETURN / steps;
        if size > most {
            Some(format!(
                "too large: a run of {} episodes of up to {} steps could add it up beyond {LARGEST_RETURN:e}; \
                 rewards may be at most {:.1e} in size here",
                self.episodes,
                self.max_steps,
                two_digits_below(most)
            ))
        } else if size > 0.0 && size < SMALLEST_REWARD {
            Some(format!(
                "too small: a reward is 0 or at least {SMALLEST_REWARD:e} in size"
            ))
        } else {
            None
        }
    }
}

/// The rule with the other keys that say how long a run may take.
fn beside_extent(broken: BrokenRule) -> BrokenRule {
    broken
        .beside(&["run.episodes", "env.max_steps"])
        .beside(&STATES)
}

/// Rounded down to two digits, so that what a message allows is allowed.
fn two_digits_below(positive: f64) -> f64 {
    let unit = 10_f64.powi(libm::log10(positive).floor() as i32 - 1);
    (positive / unit).floor() * unit
}

impl EnvParams {
    /// Whether the rewards that the scenario itself gives are numbers at all, before a world is made of them.
    pub(super) fn check_rewards(&self, goals: GoalList) -> Result<(), BrokenRule> {
        let is_number = |reward: f64| reward.abs() <= LARGEST_RETURN;
        match self.rewards_by_key(goals).find(|&(_, r)| !is_number(r)) {
            None => Ok(()),
            Some((key, reward)) => {
                let message = format!(
                    "{key} = {reward:e}: rewards must be finite numbers of at most {LARGEST_RETURN:e} in size"
                );
                Err(BrokenRule::new(key, message))
            }
        }
    }

    /// Whether the rewards of the scenario, and of its edge list if it has one, are of a size that can be added up.
    pub(super) fn check_reward_sizes(
        &self,
        goals: GoalList,
        list: Option<&EdgeList>,
        extent: Extent,
    ) -> Result<(), BrokenRule> {
        for (key, reward) in self.rewards_by_key(goals) {
            if let Some(rule) = extent.broken_by(reward) {
                let message = format!("{key} = {reward:e}: {rule}");
                return Err(beside_extent(BrokenRule::new(key, message)));
            }
        }
        let Some(list) = list else {
            return Ok(());
        };
        for (line, reward) in list.extreme_rewards() {
            if let Some(rule) = extent.broken_by(reward) {
                let file = list.file();
                let message = format!("{file}, line {line}, column reward: {reward:e} is {rule}");
                return Err(beside_extent(BrokenRule::new("env.file", message)));
            }
        }
        Ok(())
    }

    /// Every reward that the scenario gives, with its key.
    fn rewards_by_key(&self, list: GoalList) -> impl Iterator<Item = (String, f64)> {
        let scheme = match self.reward {
            RewardScheme::Explicit { step, goal } => {
                vec![("env.reward.step", step), ("env.reward.goal", goal)]
            }
            RewardScheme::StepCost | RewardScheme::GoalBonus => Vec::new(), // 1 and 99
        };
        let scheme = scheme
            .into_iter()
            .map(|(key, reward)| (key.to_owned(), reward));
        let goals = list.of(self).into_iter().flatten().enumerate();
        let goals = goals.filter_map(move |(i, goal)| {
            Some((format!("{}[{i}].reward", list.key()), goal.reward?))
        });
        let digits = self.rewards.iter().flatten();
        let digits = digits.map(|(digit, &reward)| (format!("env.rewards.{digit}"), reward));
        let hazards = self.hazards.iter().flatten().enumerate();
        let hazards =
            hazards.map(|(i, hazard)| (format!("env.hazards[{i}].reward"), hazard.reward));
        scheme.chain(goals).chain(digits).chain(hazards)
    }
}

#[cfg(test)]
mod tests {
    use crate::scenario::Scenario;
    use std::path::Path;

    fn refused(text: &str) -> String {
        let parsed = Scenario::parse(Path::new("x.toml"), text.to_owned(), &[]);
        parsed
            .err()
            .map_or(String::new(), |error| error.to_string())
    }

    #[test]
    fn the_limit_is_that_of_the_whole_run() {
        // 4 × 4 cells: 160 steps an episode, 500 episodes: 80 000 steps, 10²⁷ / 80 000 = 1.25e22.
        let text = |reward: &str| {
            format!(
                "[env]\nrows = 4\ncols = 4\ngoals = [{{ at = \"bottom-right\", reward = {reward} }}]\n"
            )
        };
        assert_eq!(refused(&text("1.2e22")), "");
        assert_eq!(
            refused(&text("-1.3e22")),
            "x.toml:4:42: env.goals[0].reward = -1.3e22: too large: a run of 500 episodes of up to 160 steps could add it \
             up beyond 1e27; rewards may be at most 1.2e22 in size here"
        );
        assert_eq!(
            refused(&text("1e-31")),
            "x.toml:4:42: env.goals[0].reward = 1e-31: too small: a reward is 0 or at least 1e-30 in size"
        );
        let one = text("1.3e22") + "max_steps = 16\n";
        assert_eq!(refused(&one), "");
    }

    #[test]
    fn no_run_is_too_long_for_the_usual_rewards() {
        let most = 1_000_000_000; // the limit of both
        for reward in ["\"step-cost\"", "\"goal-bonus\""] {
            let text =
                format!("[env]\nreward = {reward}\nmax_steps = {most}\n[run]\nepisodes = {most}\n");
            assert_eq!(refused(&text), "");
        }
    }

    #[test]
    fn every_reward_is_named_by_its_key() {
        let map = "[env]\nkind = \"ascii\"\nmap = \"1.S.G\"\n";
        for (more, place) in [
            (
                "rewards = { 1 = 1e300 }",
                "x.toml:4:17: env.rewards.1 = 1e300",
            ),
            (
                "rewards = { 1 = 1 }\nreward = { step = -1e300, goal = 0 }",
                "x.toml:5:19: env.reward.step = -1e300",
            ),
            (
                "rewards = { 1 = 1 }\nreward = { step = -1, goal = -1.7e308 }",
                "x.toml:5:30: env.reward.goal = -1.7e308",
            ),
            (
                "rewards = { 1 = 1 }\nreward = { step = -1, goal = nan }",
                "x.toml:5:30: env.reward.goal = NaN: rewards must be finite",
            ),
            (
                "rewards = { 1 = 1, 7 = inf }",
                "x.toml:4:24: env.rewards.7 = inf: rewards must be finite",
            ),
            (
                "rewards = { 1 = 1 }\nmoved_goals = [{ at = [0, 1], reward = 1e300 }]",
                "x.toml:5:40: env.moved_goals[0].reward = 1e300",
            ),
        ] {
            let message = refused(&format!("{map}{more}\n"));
            assert!(message.starts_with(place), "{more}: {message}");
        }
    }
}
