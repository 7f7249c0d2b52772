//! Rewards of a step on a map.
//!
//! A step earns `step`; the one that enters a goal earns `step + bonus`, where the bonus is the goal's own number if it
//! has one ([`GoalCell::reward`](crate::env::layouts::GoalCell::reward)), else the scheme's. A step is counted where it
//! begins: under the paper's eq. 2 every step from a non-goal state costs 1, the one into the goal included, and
//! the goal itself pays nothing because the episode is over. So the return is −(number of steps).

use crate::env::EnvError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// c of eq. 1, which the paper leaves open: −1 keeps the shortest path optimal when γ = 1.
const GOAL_BONUS_STEP: f64 = -1.0;
/// The bonus of eq. 1.
const GOAL_BONUS: f64 = 100.0;

/// Rewards of a grid world: `"step-cost"`, `"goal-bonus"`, or `{ step = NUMBER, goal = NUMBER }`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(from = "Spec", into = "Spec")]
#[schemars(with = "Spec")]
pub enum RewardScheme {
    /// −1 a step, no bonus: eq. 2 of the source paper.
    #[default]
    StepCost,
    /// c = −1 a step, c + 100 on entering a goal: eq. 1.
    GoalBonus,
    /// Any numbers.
    Explicit {
        /// Reward of every step; must not be positive.
        step: f64,
        /// Added on entering a goal.
        goal: f64,
    },
}

impl RewardScheme {
    /// Reward of a step.
    pub fn step(self) -> f64 {
        match self {
            RewardScheme::StepCost => -1.0,
            RewardScheme::GoalBonus => GOAL_BONUS_STEP,
            RewardScheme::Explicit { step, .. } => step,
        }
    }

    /// Added to it on entering a goal that has no number of its own.
    pub fn goal(self) -> f64 {
        match self {
            RewardScheme::StepCost => 0.0,
            RewardScheme::GoalBonus => GOAL_BONUS,
            RewardScheme::Explicit { goal, .. } => goal,
        }
    }

    /// # Errors
    /// [`EnvError::RewardNotFinite`] or [`EnvError::StepRewardPositive`].
    pub fn validate(self) -> Result<(), EnvError> {
        require_finite("a step", self.step())?;
        require_finite("a goal", self.goal())?;
        if self.step() > 0.0 {
            return Err(EnvError::StepRewardPositive {
                reward: self.step(),
            });
        }
        Ok(())
    }
}

/// Refuses NaN and infinities.
pub(crate) fn require_finite(place: &str, reward: f64) -> Result<(), EnvError> {
    if reward.is_finite() {
        Ok(())
    } else {
        Err(EnvError::RewardNotFinite {
            place: place.to_owned(),
            reward,
        })
    }
}

/// How a scheme is written: a name or a table.
#[derive(Clone, Copy, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "rewards are \"step-cost\", \"goal-bonus\" or { step = NUMBER, goal = NUMBER }"
)]
#[schemars(rename = "RewardScheme")]
enum Spec {
    Named(Name),
    Numbers(Numbers),
}

#[derive(Clone, Copy, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum Name {
    StepCost,
    GoalBonus,
}

#[derive(Clone, Copy, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "RewardNumbers")]
struct Numbers {
    /// Reward of every step.
    step: f64,
    /// Added on entering a goal.
    goal: f64,
}

impl From<Spec> for RewardScheme {
    fn from(spec: Spec) -> Self {
        match spec {
            Spec::Named(Name::StepCost) => RewardScheme::StepCost,
            Spec::Named(Name::GoalBonus) => RewardScheme::GoalBonus,
            Spec::Numbers(Numbers { step, goal }) => RewardScheme::Explicit { step, goal },
        }
    }
}

impl From<RewardScheme> for Spec {
    fn from(scheme: RewardScheme) -> Self {
        match scheme {
            RewardScheme::StepCost => Spec::Named(Name::StepCost),
            RewardScheme::GoalBonus => Spec::Named(Name::GoalBonus),
            RewardScheme::Explicit { step, goal } => Spec::Numbers(Numbers { step, goal }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn schemes_survive_being_written() {
        let schemes = [
            ("\"step-cost\"", RewardScheme::StepCost),
            ("\"goal-bonus\"", RewardScheme::GoalBonus),
            (
                "{\"step\":-0.5,\"goal\":3.0}",
                RewardScheme::Explicit {
                    step: -0.5,
                    goal: 3.0,
                },
            ),
        ];
        for (text, scheme) in schemes {
            assert_eq!(serde_json::from_str::<RewardScheme>(text).unwrap(), scheme);
            assert_eq!(serde_json::to_string(&scheme).unwrap(), text);
        }
    }

    #[test]
    fn misspelt_schemes_are_told_what_is_right() {
        for text in ["\"step-costs\"", "{\"step\":-1,\"gaol\":3}"] {
            let message = serde_json::from_str::<RewardScheme>(text)
                .unwrap_err()
                .to_string();
            assert!(message.contains("\"goal-bonus\""), "{message}");
        }
    }

    #[test]
    fn useless_rewards_are_refused() {
        let check = |step, goal| RewardScheme::Explicit { step, goal }.validate();
        assert_eq!(check(0.0, 1.0), Ok(()));
        assert_eq!(
            check(0.1, 1.0),
            Err(EnvError::StepRewardPositive { reward: 0.1 })
        );
        assert!(matches!(
            check(f64::NAN, 1.0),
            Err(EnvError::RewardNotFinite { .. })
        ));
        assert!(matches!(
            check(-1.0, f64::INFINITY),
            Err(EnvError::RewardNotFinite { .. })
        ));
    }
}
