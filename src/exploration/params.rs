//! Parameters of the exploration.

use crate::env::LARGEST_RETURN;
use crate::parameter::{ParameterError, Section};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Kind of exploration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ExplorationKind {
    /// The nearest state with untried actions, as advice to the policy.
    #[default]
    Frontier,
    /// β/√N added to the reward.
    CountBonus,
    /// The policy's own randomness.
    None,
}

/// Aim of the search once a goal has been reached.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Optimism {
    /// Shorter paths to the goals seen: an untried action is tried if the best that it could lead to beats the best path known.
    SeenGoals,
    /// The same by what may be earned: an end is a goal only if it pays, and where actions slip the best path known is worth what it may be
    /// expected to cost, falls included.
    #[default]
    ExpectedReturn,
    /// Also goals not seen yet: an untried action might lead straight to one (R-max, Brafman & Tennenholtz 2002).
    AnyGoal,
    /// Nothing: the agent settles for the first path.
    None,
}

/// Order in which untried actions are looked at while no goal is known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SearchOrder {
    /// Those first that lead to a place where nothing is known, as far as can be told from what actions do elsewhere; a bump marks the place as a wall
    /// from all sides. Then those that lead to a known place with another heading, then all others.
    #[default]
    ByPlace,
    /// The nearest one that does not just undo a step.
    ByAction,
}

/// Parameters of the exploration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ExplorationParams {
    /// What guides the search.
    pub kind: ExplorationKind,
    /// Logits added to the action on the way to the frontier.
    pub frontier_advice: f64,
    /// Logits added for a rise of the potential worth one step, once a goal has been reached; with 0 all that is advised then is
    /// what the search for something better has planned.
    pub potential_advice: f64,
    /// What is looked for once a goal has been reached.
    pub optimism: Optimism,
    /// What is tried first while no goal is known.
    pub order: SearchOrder,
    /// The most that an end of an episode can pay, if that is known: no other goals are looked for that could not be worth it.
    #[schemars(example = 1.0)]
    pub reward_bound: Option<f64>,
    /// With `seen-goals` and `expected-return`: the share of the steps after the first goal that may still go into looking for other goals, in 0..1.
    pub search_share: f64,
    /// The same once something has paid more than nothing (a reward above 0): there may be more, however far it is. The share of the first steps only, as many as it took to
    /// find the first thing that pays, or to see what is known; it goes down as 1 / √t then.
    pub reward_search_share: f64,
    /// β of the count bonus, in units of reward.
    pub bonus: f64,
}

impl Default for ExplorationParams {
    fn default() -> Self {
        Self {
            kind: ExplorationKind::Frontier,
            frontier_advice: 24.0,
            potential_advice: 0.0,
            optimism: Optimism::ExpectedReturn,
            order: SearchOrder::ByPlace,
            reward_bound: None,
            search_share: 0.005,
            reward_search_share: 0.8,
            bonus: 1.0,
        }
    }
}

impl ExplorationParams {
    /// Checks every rule.
    ///
    /// # Errors
    /// The first key that breaks its rule.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let non_negative = "at least 0 and below 1e27";
        let share = "at least 0 and below 1";
        let checks = [
            (
                "frontier_advice",
                self.frontier_advice,
                LARGEST_RETURN,
                non_negative,
            ),
            (
                "potential_advice",
                self.potential_advice,
                LARGEST_RETURN,
                non_negative,
            ),
            ("bonus", self.bonus, LARGEST_RETURN, non_negative),
            ("search_share", self.search_share, 1.0, share),
            ("reward_search_share", self.reward_search_share, 1.0, share),
        ];
        for (key, value, limit, rule) in checks {
            let holds = (0.0..limit).contains(&value);
            Section("exploration").number(key, value, holds, rule)?;
        }
        let bound = self.reward_bound.unwrap_or(0.0);
        let holds = bound.abs() < LARGEST_RETURN;
        Section("exploration").number("reward_bound", bound, holds, "between -1e27 and 1e27")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_valid_and_broken_rules_name_their_key() {
        ExplorationParams::default()
            .validate()
            .expect("defaults are valid");
        let broken = ExplorationParams {
            search_share: 1.0,
            ..Default::default()
        };
        assert_eq!(
            broken.validate().expect_err("1 is too much").key,
            "search_share"
        );
        let broken = ExplorationParams {
            bonus: f64::NAN,
            ..Default::default()
        };
        assert_eq!(broken.validate().expect_err("NaN is no bonus").key, "bonus");
        let broken = ExplorationParams {
            reward_bound: Some(f64::INFINITY),
            ..Default::default()
        };
        assert_eq!(
            broken.validate().expect_err("no bound at all").key,
            "reward_bound"
        );
    }
}
