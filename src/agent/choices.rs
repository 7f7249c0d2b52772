//! Choices that the `[agent]` table of a scenario offers by name.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Kind of learner.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum AgentKind {
    /// Action-value actor-critic with a softmax policy.
    ActorCritic,
    /// Actor-critic that replays what it has seen, shaped by the potential as it stands.
    #[default]
    ReplayActorCritic,
    /// Q-learning.
    QLearning,
    /// SARSA or expected SARSA.
    Sarsa,
    /// Dyna-Q with prioritised sweeping.
    DynaQ,
    /// Dyna-Q+: plans with a bonus for what was not tried for long.
    DynaQPlus,
    /// R-max: plans on the learnt model, optimistic about untried actions.
    Planner,
    /// Policy iteration on the learnt model with the shaped reward.
    PolicyIteration,
    /// MBIE-EB: plans each episode on the learnt model with β/√n added to its rewards.
    MbieEb,
    /// UCBVI: the same with a confidence bound of Hoeffding's kind.
    Ucbvi,
    /// Posterior sampling: plans each episode on a model drawn from what the world may be.
    Psrl,
    /// Every action equally likely.
    Random,
}

/// Signal that moves the actor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum UpdateRule {
    /// The advantage Q(s, a) − Σ_b π(b|s) Q(s, b).
    #[default]
    Advantage,
    /// The TD error δ: the source paper's Algorithm 1.
    #[serde(rename = "algorithm-1")]
    Algorithm1,
    /// The action value Q(s, a): the source paper's Algorithm 2.
    #[serde(rename = "algorithm-2")]
    Algorithm2,
}

/// Features that actor and critic are linear in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FeatureKind {
    /// One number per (state, action).
    #[default]
    Tabular,
    /// Proto-value functions, stacked per action (eq. 13).
    Pvf,
    /// Skip-gram vectors over random walks, stacked per action.
    Deepwalk,
}

/// Estimate of the value of s′.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Bootstrap {
    /// Q(s′, a′) of the action a′ that is drawn now and taken next (SARSA; as the paper prints it).
    Sampled,
    /// Σ_b π(b|s′) Q(s′, b) (expected SARSA).
    Expected,
}

/// Guide of an agent that plans to actions that it does not know.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Untried {
    /// Optimism: they may be worth the optimistic value (R-max), or what values begin with.
    #[default]
    Optimistic,
    /// The advice of the exploration, which comes before any plan; plans themselves lead along known ways only.
    Advised,
}
