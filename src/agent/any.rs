//! Every learner behind one type: a plain value, dispatched without a pointer.

use super::{
    ActorCritic, Agent, AgentKind, AgentParams, DynaQ, DynaQPlus, Experience, FeatureKind, MbieEb,
    Planner, PolicyIteration, ProtoValueFeatures, Psrl, QLearning, RandomAgent, ReplayActorCritic,
    Sarsa, Situation, Tabular, Ucbvi, UpdateInfo,
};
use crate::env::Action;
use crate::graph::StateId;
use serde::{Deserialize, Serialize};

/// A learner of any kind. Written down with serde and read back, it continues exactly where it was.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[allow(missing_docs)] // one variant per learner, documented there
#[allow(clippy::large_enum_variant)] // there is one agent per run
#[non_exhaustive]
pub enum AnyAgent {
    TabularActorCritic(ActorCritic<Tabular>),
    PvfActorCritic(ActorCritic<ProtoValueFeatures>),
    QLearning(QLearning),
    Sarsa(Sarsa),
    DynaQ(DynaQ),
    Planner(Planner),
    PolicyIteration(PolicyIteration),
    Random(RandomAgent),
    DynaQPlus(DynaQPlus),
    MbieEb(MbieEb),
    Ucbvi(Ucbvi),
    Psrl(Psrl),
    ReplayActorCritic(ReplayActorCritic),
}

impl AnyAgent {
    /// The agent that `params` describe, over `num_actions` actions, learning from r + `mix` · F and drawing from the
    /// agent's stream of `seed`. `params` are taken to be valid ([`AgentParams::validate`]).
    ///
    /// # Panics
    /// If there are no actions.
    pub fn new(params: &AgentParams, num_actions: usize, mix: f64, seed: u64) -> Self {
        match params.kind {
            AgentKind::ActorCritic => Self::actor_critic(params, num_actions, mix, seed),
            AgentKind::QLearning => {
                AnyAgent::QLearning(QLearning::new(params.q_learning(), num_actions, mix, seed))
            }
            AgentKind::Sarsa => AnyAgent::Sarsa(Sarsa::new(params.sarsa(), num_actions, mix, seed)),
            AgentKind::DynaQ => {
                AnyAgent::DynaQ(DynaQ::new(params.dyna_q(), num_actions, mix, seed))
            }
            AgentKind::DynaQPlus => {
                AnyAgent::DynaQPlus(DynaQPlus::new(params.dyna_q_plus(), num_actions, seed))
            }
            AgentKind::Planner => {
                AnyAgent::Planner(Planner::new(params.planner(), num_actions, seed))
            }
            AgentKind::PolicyIteration => {
                let params = params.policy_iteration();
                AnyAgent::PolicyIteration(PolicyIteration::new(params, num_actions, mix, seed))
            }
            AgentKind::MbieEb => AnyAgent::MbieEb(MbieEb::new(params.mbie_eb(), num_actions, seed)),
            AgentKind::Ucbvi => AnyAgent::Ucbvi(Ucbvi::new(params.ucbvi(), num_actions, seed)),
            AgentKind::Psrl => AnyAgent::Psrl(Psrl::new(params.psrl(), num_actions, seed)),
            AgentKind::ReplayActorCritic => {
                let params = params.replay_actor_critic();
                AnyAgent::ReplayActorCritic(ReplayActorCritic::new(params, num_actions, mix, seed))
            }
            AgentKind::Random => AnyAgent::Random(RandomAgent::new(num_actions, seed)),
        }
    }

    fn actor_critic(params: &AgentParams, num_actions: usize, mix: f64, seed: u64) -> Self {
        let own = params.actor_critic();
        match params.features {
            FeatureKind::Tabular => {
                let features = Tabular::new(num_actions);
                AnyAgent::TabularActorCritic(ActorCritic::new(
                    own,
                    features,
                    num_actions,
                    mix,
                    seed,
                ))
            }
            FeatureKind::Pvf | FeatureKind::Deepwalk => {
                let features = ProtoValueFeatures::new(num_actions);
                AnyAgent::PvfActorCritic(ActorCritic::new(own, features, num_actions, mix, seed))
            }
        }
    }
}

/// [`AnyAgent::new`] under the name that says what it does.
///
/// # Panics
/// If there are no actions.
pub fn build_agent(params: &AgentParams, num_actions: usize, mix: f64, seed: u64) -> AnyAgent {
    AnyAgent::new(params, num_actions, mix, seed)
}

/// Calls the same on whichever agent it is.
macro_rules! each {
    ($any:expr, $agent:ident => $call:expr) => {
        match $any {
            AnyAgent::TabularActorCritic($agent) => $call,
            AnyAgent::PvfActorCritic($agent) => $call,
            AnyAgent::QLearning($agent) => $call,
            AnyAgent::Sarsa($agent) => $call,
            AnyAgent::DynaQ($agent) => $call,
            AnyAgent::Planner($agent) => $call,
            AnyAgent::PolicyIteration($agent) => $call,
            AnyAgent::Random($agent) => $call,
            AnyAgent::DynaQPlus($agent) => $call,
            AnyAgent::MbieEb($agent) => $call,
            AnyAgent::Ucbvi($agent) => $call,
            AnyAgent::Psrl($agent) => $call,
            AnyAgent::ReplayActorCritic($agent) => $call,
        }
    };
}

impl Agent for AnyAgent {
    #[inline]
    fn select_action(&mut self, situation: Situation<'_>) -> Action {
        each!(self, agent => agent.select_action(situation))
    }

    #[inline]
    fn update(&mut self, experience: &Experience<'_>) -> UpdateInfo {
        each!(self, agent => agent.update(experience))
    }

    fn set_features(&mut self, features: faer::MatRef<'_, f64>) {
        each!(self, agent => agent.set_features(features));
    }

    fn set_potential(&mut self, potential: &[f64]) {
        each!(self, agent => agent.set_potential(potential));
    }

    fn greedy_action(&self, state: StateId, advice: &[f64]) -> Option<Action> {
        each!(self, agent => agent.greedy_action(state, advice))
    }
}
