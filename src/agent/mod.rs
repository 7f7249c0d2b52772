//! The learners. They see state numbers, rewards and advice, never a graph network.
//!
//! Every learner is told about a step (s, a, r, s′) with three numbers kept apart:
//!
//! - the **plain reward** r of the environment;
//! - the **shaping** F(s, s′) = γφ(s′) − φ(s) (eq. 4 of the source paper, "Sparse Reward Propagation for Deep
//!   Reinforcement Learning"), added as R′ = r + m·F (eq. 3) with the blend m of [`AnyAgent::new`];
//! - **advice**, one number per action, that bends what the agent *does* and is never part of what it learns
//!   (look-ahead advice, Wiewiora, Cottrell & Elkan 2003).
//!
//! | learner | file | value of an action | advice | shaping |
//! |---|---|---|---|---|
//! | [`ActorCritic`] | `actor_critic` | Q_w by temporal differences, policy π_θ beside it | on the logits | yes |
//! | [`ReplayActorCritic`] | `replay_actor_critic` | V by prioritised sweeping over the learnt model, with F of the present φ | on the logits | yes |
//! | [`QLearning`] | `q_learning` | Q by off-policy differences | on Q, when choosing | yes |
//! | [`Sarsa`] | `sarsa` | Q by on-policy differences | on Q, when choosing | yes |
//! | [`DynaQ`] | `dyna_q` | Q by prioritised sweeping over the learnt model | on Q, when choosing | yes |
//! | [`DynaQPlus`] | `dyna_q_plus` | Q by sampled backups from the latest seen, with a bonus for what was not tried for long | no | no |
//! | [`Planner`] | `planner` | V of the learnt model, optimistic about untried actions (R-max) or led to them by advice | if told so: first of all | no |
//! | [`PolicyIteration`] | `policy_iteration` | V of policies on the learnt model | on Q, when choosing | yes |
//! | [`MbieEb`] | `mbie_eb` | Q of the learnt model with β/√n on its rewards | no | no |
//! | [`Ucbvi`] | `ucbvi` | Q of the learnt model with upper confidence bounds | no | no |
//! | [`Psrl`] | `psrl` | Q of a model drawn from the posterior | no | no |
//! | [`RandomAgent`] | `random` | none | no | no |
//!
//! The three before the last plan for an episode ahead, and differ in what they believe: see [`EpisodePlanner`].
//!
//! An episode that **terminated** is worth 0 from there on; one that was **truncated** is cut off, and its last
//! state keeps the value it has.
//!
//! All learners are plain values (`Clone`, `serde`), their random streams included: written down and read back,
//! they go on as if nothing had happened.

mod actor_critic;
mod any;
mod behaviour;
mod checks;
mod choices;
mod draws;
mod dyna_q;
mod dyna_q_plus;
mod episode_planner;
mod features;
mod greedy;
mod horizon_plan;
mod mbie_eb;
mod model;
mod params;
mod planner;
pub mod policy;
mod policy_iteration;
mod psrl;
mod pvf;
mod q_learning;
mod random;
mod replay_actor_critic;
mod reward_range;
mod sarsa;
mod small_mdp;
mod sweep;
mod table;
mod ucbvi;

pub use actor_critic::{ActorCritic, ActorCriticParams};
pub use any::{AnyAgent, build_agent};
pub(crate) use checks::check_gamma;
pub use choices::{AgentKind, Bootstrap, FeatureKind, Untried, UpdateRule};
pub use dyna_q::{DynaQ, DynaQParams};
pub use dyna_q_plus::{DynaQPlus, DynaQPlusParams};
pub use episode_planner::{Belief, EpisodePlanParams, EpisodePlanner, Outlook};
pub use features::{LinearFeatures, Tabular};
pub use horizon_plan::Believed;
pub use mbie_eb::{MbieEb, MbieEbParams};
pub use model::Outcome;
pub use params::AgentParams;
pub use planner::{Planner, PlannerParams};
pub use policy_iteration::{PolicyIteration, PolicyIterationParams};
pub use psrl::{Psrl, PsrlParams};
pub use pvf::ProtoValueFeatures;
pub use q_learning::{QLearning, QLearningParams};
pub use random::RandomAgent;
pub use replay_actor_critic::{ReplayActorCritic, ReplayActorCriticParams};
pub use sarsa::{Sarsa, SarsaParams};
pub use ucbvi::{Ucbvi, UcbviParams};

use crate::env::{Action, StepStatus};
use crate::graph::StateId;

/// State where the agent stands, and the advice of the exploration there.
#[derive(Clone, Copy, Debug)]
pub struct Situation<'a> {
    /// The number of the state; at most one beyond those seen so far is the rule, any is accepted.
    pub state: StateId,
    /// One number per action, in units of the policy's logits; all 0 when there is no advice.
    pub advice: &'a [f64],
}

/// One step as the agent learns from it.
#[derive(Clone, Copy, Debug)]
pub struct Experience<'a> {
    /// The state s in which the agent acted.
    pub state: StateId,
    /// The action a it took there.
    pub action: Action,
    /// Plain reward r of the environment.
    pub reward: f64,
    /// Shaping F to add to it (0 without shaping).
    pub shaping: f64,
    /// The state s′ that was reached, and the advice there.
    pub next: Situation<'a>,
    /// How the episode stands after the step.
    pub status: StepStatus,
}

impl Experience<'_> {
    /// R′ = r + m·F (eq. 3): the reward to learn from under the blend `mix` = m in 0..=1.
    ///
    /// Klissarov & Precup (2020) keep two critics, Q^Φ for r + F and Q for r, and act on m·Q^Φ + (1 − m)·Q. Both
    /// are updated linearly in the reward, along the same path, from the same start; so their blend is at every
    /// moment the one critic that learns from r + m·F, and this crate stores just that one. Blending errors or
    /// blending rewards is the same thing.
    pub fn shaped_reward(&self, mix: f64) -> f64 {
        self.reward + mix * self.shaping
    }

    /// 1 where what follows s′ counts, 0 after the end of the task.
    pub(crate) fn continuation(&self) -> f64 {
        match self.status {
            StepStatus::Terminated => 0.0,
            StepStatus::Running | StepStatus::Truncated => 1.0,
        }
    }
}

/// Facts of an update, for the log.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct UpdateInfo {
    /// The TD error δ, or for planning agents the change of the value of s; 0 for agents that do not learn.
    pub td_error: f64,
}

/// A learner.
pub trait Agent {
    /// Chooses an action; grows its tables when it meets a state number beyond them.
    ///
    /// # Panics
    /// If `situation.advice` does not have one number per action.
    fn select_action(&mut self, situation: Situation<'_>) -> Action;

    /// Learns from one step. Called once after each step, before the next `select_action`.
    ///
    /// # Panics
    /// If the action is out of range, or the advice does not have one number per action.
    fn update(&mut self, experience: &Experience<'_>) -> UpdateInfo;

    /// Linear features of every known state, n × k, after a spectrum refresh; agents that use tables ignore it.
    fn set_features(&mut self, _features: faer::MatRef<'_, f64>) {}

    /// φ of every known state, after a fit; agents that keep no transitions to shape anew ignore it.
    fn set_potential(&mut self, _potential: &[f64]) {}

    /// The likeliest action at `state` under this advice (the first of equals); `None` where it has no opinion. For
    /// maps and arrows, not for acting.
    ///
    /// # Panics
    /// If `advice` does not have one number per action, and the agent heeds advice.
    fn greedy_action(&self, _state: StateId, _advice: &[f64]) -> Option<Action> {
        None
    }
}
