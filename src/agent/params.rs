//! The `[agent]` table of a scenario: one flat table for every kind of learner.
//!
//! Keys that the chosen kind does not use are ignored, so that one scenario can be run with several kinds side by
//! side. A key left out takes the default of its kind; [`AgentParams::resolved`] writes those in.

use super::checks::{MOST_WORK, check_gamma};
use super::choices::{AgentKind, Bootstrap, FeatureKind, Untried, UpdateRule};
use super::{
    ActorCriticParams, DynaQParams, DynaQPlusParams, EpisodePlanParams, MbieEbParams,
    PlannerParams, PolicyIterationParams, PsrlParams, QLearningParams, ReplayActorCriticParams,
    SarsaParams, UcbviParams,
};
use crate::parameter::ParameterError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The agent of a scenario.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default, rename_all = "snake_case")]
pub struct AgentParams {
    /// Which learner.
    pub kind: AgentKind,
    /// actor-critic: which signal moves the actor.
    pub update: UpdateRule,
    /// actor-critic: what it is linear in.
    pub features: FeatureKind,
    /// Discount factor γ in 0..=1; the only one, shaping uses it too.
    pub gamma: f64,
    /// actor-critic: step size of the policy. Default 0.1; algorithm-1 0.005, algorithm-2 0.01 (section 4.3).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(example = 0.1)]
    pub actor_learning_rate: Option<f64>,
    /// Step size of action values, in (0, 1]. Default: actor-critic 0.7 (algorithm-1 0.01, algorithm-2 0.005),
    /// q-learning, dyna-q and dyna-q-plus 1, sarsa 0.5.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(example = 0.7)]
    pub critic_learning_rate: Option<f64>,
    /// actor-critic: preferences stay within ± this.
    pub preference_clip: f64,
    /// actor-critic and sarsa: how the value of s′ is estimated. Default: actor-critic sampled, sarsa expected.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(example = Bootstrap::Expected)]
    pub bootstrap: Option<Bootstrap>,
    /// q-learning, sarsa, dyna-q, dyna-q-plus, policy-iteration: chance of a random action. Default: sarsa and
    /// policy-iteration 0.05, else 0 (the initial value is what explores).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(example = 0.05)]
    pub epsilon: Option<f64>,
    /// q-learning, sarsa, dyna-q, dyna-q-plus, policy-iteration: what an untried action is worth. 0 is optimistic where
    /// steps cost.
    pub initial_value: f64,
    /// dyna-q, dyna-q-plus and replay-actor-critic: backups from the model after each step, the step's own included but for
    /// dyna-q-plus; 1 to 1 000 000. Default: replay-actor-critic 3, else 50.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(example = 3)]
    pub planning_steps: Option<usize>,
    /// dyna-q-plus: κ of the bonus κ√τ for what was not tried for τ steps, in units of reward, 0 to 1e6.
    pub time_bonus: f64,
    /// planner: tries after which an action counts as known; 1 to 1 000 000.
    pub known_after: u32,
    /// planner and replay-actor-critic: what leads to unknown actions. Default: planner
    /// optimistic, replay-actor-critic advised, but optimistic where the exploration is not frontier.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(example = Untried::Advised)]
    pub untried: Option<Untried>,
    /// planner, mbie-eb, ucbvi, psrl: return expected of an unknown action. Default: from the largest reward seen so far.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(example = 99.0)]
    pub optimistic_value: Option<f64>,
    /// planner: at most so many backups (1 to 1 000 000) after one step; what is left waits for the next.
    pub max_backups: usize,
    /// mbie-eb, ucbvi, psrl: steps to plan ahead, 1 to 1 000 000. Default: the step limit of the world's episodes.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(example = 100)]
    pub horizon: Option<usize>,
    /// mbie-eb: β of the bonus β/√n, in ranges of returns seen, a step of the horizon. ucbvi: the bonus, in shares of the theory's
    /// that the horizon divides. replay-actor-critic: β of the same, in largest rewards seen, a step of the longest episode. 0 to 1e6. Default: mbie-eb 1, ucbvi 0.0125,
    /// replay-actor-critic 0.6.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(example = 1.0)]
    pub bonus: Option<f64>,
    /// psrl: tries of an action that the prior is worth, which says that it leads somewhere unknown; above 0, at most 1e6.
    pub prior_tries: f64,
    /// psrl: deviation of single rewards that is reckoned with, in ranges of returns seen, a step of the horizon; 0 to 1e6.
    pub reward_deviation: f64,
    /// policy-iteration: plan after so many steps, besides the end of each episode; 0 = only there.
    pub plan_every: u64,
    /// policy-iteration: sweeps of one evaluation; 1 to 1 000 000.
    pub evaluation_sweeps: usize,
}

impl Default for AgentParams {
    fn default() -> Self {
        let (actor_critic, planner) = (ActorCriticParams::default(), PlannerParams::default());
        let (policy_iteration, psrl) = (PolicyIterationParams::default(), PsrlParams::default());
        AgentParams {
            kind: AgentKind::default(),
            update: UpdateRule::default(),
            features: FeatureKind::default(),
            gamma: actor_critic.gamma,
            actor_learning_rate: None,
            critic_learning_rate: None,
            preference_clip: actor_critic.preference_clip,
            bootstrap: None,
            epsilon: None,
            initial_value: QLearningParams::default().initial_value,
            planning_steps: None,
            time_bonus: DynaQPlusParams::default().time_bonus,
            known_after: planner.known_after,
            untried: None,
            optimistic_value: None,
            max_backups: planner.max_backups,
            horizon: None,
            bonus: None,
            prior_tries: psrl.prior_tries,
            reward_deviation: psrl.reward_deviation,
            plan_every: policy_iteration.plan_every,
            evaluation_sweeps: policy_iteration.evaluation_sweeps,
        }
    }
}

impl AgentParams {
    /// Checks every key that the chosen kind uses.
    ///
    /// # Errors
    /// The first key that breaks its rule.
    pub fn validate(&self) -> Result<(), ParameterError> {
        match self.kind {
            AgentKind::ActorCritic => self.actor_critic().validate(),
            AgentKind::QLearning => self.q_learning().validate(),
            AgentKind::Sarsa => self.sarsa().validate(),
            AgentKind::DynaQ => self.dyna_q().validate(),
            AgentKind::DynaQPlus => self.dyna_q_plus().validate(),
            AgentKind::Planner => self.planner().validate(),
            AgentKind::PolicyIteration => self.policy_iteration().validate(),
            AgentKind::MbieEb => self.mbie_eb().validate(),
            AgentKind::Ucbvi => self.ucbvi().validate(),
            AgentKind::Psrl => self.psrl().validate(),
            AgentKind::ReplayActorCritic => self.replay_actor_critic().validate(),
            AgentKind::Random => check_gamma(self.gamma),
        }
    }

    /// The same with the defaults of its kind written in, as far as the kind uses them.
    ///
    /// To try another kind on the same table, change the table as it was before: its unset keys then take the
    /// defaults of the new kind.
    pub fn resolved(&self) -> AgentParams {
        let mut resolved = self.clone();
        match self.kind {
            AgentKind::ActorCritic => {
                let p = self.actor_critic();
                resolved.actor_learning_rate = Some(p.actor_learning_rate);
                resolved.critic_learning_rate = Some(p.critic_learning_rate);
                resolved.bootstrap = Some(p.bootstrap);
            }
            AgentKind::QLearning => {
                let p = self.q_learning();
                (resolved.critic_learning_rate, resolved.epsilon) =
                    (Some(p.learning_rate), Some(p.epsilon));
            }
            AgentKind::Sarsa => {
                let p = self.sarsa();
                (resolved.critic_learning_rate, resolved.epsilon) =
                    (Some(p.learning_rate), Some(p.epsilon));
                resolved.bootstrap = Some(p.bootstrap);
            }
            AgentKind::DynaQ => {
                let p = self.dyna_q();
                (resolved.critic_learning_rate, resolved.epsilon) =
                    (Some(p.learning_rate), Some(p.epsilon));
                resolved.planning_steps = Some(p.planning_steps);
            }
            AgentKind::DynaQPlus => {
                let p = self.dyna_q_plus();
                (resolved.critic_learning_rate, resolved.epsilon) =
                    (Some(p.learning_rate), Some(p.epsilon));
                resolved.planning_steps = Some(p.planning_steps);
            }
            AgentKind::PolicyIteration => resolved.epsilon = Some(self.policy_iteration().epsilon),
            AgentKind::MbieEb => resolved.bonus = Some(self.mbie_eb().bonus),
            AgentKind::Ucbvi => resolved.bonus = Some(self.ucbvi().bonus),
            AgentKind::Planner => resolved.untried = Some(self.planner().untried),
            AgentKind::ReplayActorCritic => {
                let p = self.replay_actor_critic();
                (resolved.planning_steps, resolved.untried) =
                    (Some(p.planning_steps), Some(p.untried));
                resolved.bonus = Some(p.bonus);
            }
            AgentKind::Psrl | AgentKind::Random => {}
        }
        resolved
    }

    /// The same for episodes of at most `max_steps`: they are the horizon of plans, if the table gives none.
    pub fn with_step_limit(&self, max_steps: usize) -> AgentParams {
        let mut params = self.clone();
        params.horizon = params.horizon.or(Some(max_steps.min(MOST_WORK)));
        params
    }

    /// What an actor-critic takes from the table.
    pub fn actor_critic(&self) -> ActorCriticParams {
        let d = ActorCriticParams::of(self.update);
        ActorCriticParams {
            update: self.update,
            gamma: self.gamma,
            actor_learning_rate: self.actor_learning_rate.unwrap_or(d.actor_learning_rate),
            critic_learning_rate: self.critic_learning_rate.unwrap_or(d.critic_learning_rate),
            preference_clip: self.preference_clip,
            bootstrap: self.bootstrap.unwrap_or(d.bootstrap),
        }
    }

    /// What Q-learning takes from the table.
    pub fn q_learning(&self) -> QLearningParams {
        let d = QLearningParams::default();
        QLearningParams {
            gamma: self.gamma,
            learning_rate: self.critic_learning_rate.unwrap_or(d.learning_rate),
            epsilon: self.epsilon.unwrap_or(d.epsilon),
            initial_value: self.initial_value,
        }
    }

    /// What SARSA takes from the table.
    pub fn sarsa(&self) -> SarsaParams {
        let d = SarsaParams::default();
        SarsaParams {
            gamma: self.gamma,
            learning_rate: self.critic_learning_rate.unwrap_or(d.learning_rate),
            epsilon: self.epsilon.unwrap_or(d.epsilon),
            initial_value: self.initial_value,
            bootstrap: self.bootstrap.unwrap_or(d.bootstrap),
        }
    }

    /// What Dyna-Q takes from the table.
    pub fn dyna_q(&self) -> DynaQParams {
        let d = DynaQParams::default();
        DynaQParams {
            gamma: self.gamma,
            learning_rate: self.critic_learning_rate.unwrap_or(d.learning_rate),
            epsilon: self.epsilon.unwrap_or(d.epsilon),
            initial_value: self.initial_value,
            planning_steps: self.planning_steps.unwrap_or(d.planning_steps),
        }
    }

    /// What Dyna-Q+ takes from the table.
    pub fn dyna_q_plus(&self) -> DynaQPlusParams {
        let d = DynaQPlusParams::default();
        DynaQPlusParams {
            gamma: self.gamma,
            learning_rate: self.critic_learning_rate.unwrap_or(d.learning_rate),
            epsilon: self.epsilon.unwrap_or(d.epsilon),
            initial_value: self.initial_value,
            planning_steps: self.planning_steps.unwrap_or(d.planning_steps),
            time_bonus: self.time_bonus,
        }
    }

    /// What the planner takes from the table.
    pub fn planner(&self) -> PlannerParams {
        PlannerParams {
            gamma: self.gamma,
            known_after: self.known_after,
            untried: self.untried.unwrap_or(PlannerParams::default().untried),
            optimistic_value: self.optimistic_value,
            max_backups: self.max_backups,
        }
    }

    /// What planners for an episode ahead take from the table.
    fn episode_plan(&self) -> EpisodePlanParams {
        let d = EpisodePlanParams::default();
        EpisodePlanParams {
            gamma: self.gamma,
            horizon: self.horizon.unwrap_or(d.horizon),
            optimistic_value: self.optimistic_value,
        }
    }

    /// What MBIE-EB takes from the table.
    pub fn mbie_eb(&self) -> MbieEbParams {
        MbieEbParams {
            plan: self.episode_plan(),
            bonus: self.bonus.unwrap_or(MbieEbParams::default().bonus),
        }
    }

    /// What UCBVI takes from the table.
    pub fn ucbvi(&self) -> UcbviParams {
        UcbviParams {
            plan: self.episode_plan(),
            bonus: self.bonus.unwrap_or(UcbviParams::default().bonus),
        }
    }

    /// What posterior sampling takes from the table.
    pub fn psrl(&self) -> PsrlParams {
        PsrlParams {
            plan: self.episode_plan(),
            prior_tries: self.prior_tries,
            reward_deviation: self.reward_deviation,
        }
    }

    /// What the actor-critic with replay takes from the table.
    pub fn replay_actor_critic(&self) -> ReplayActorCriticParams {
        let d = ReplayActorCriticParams::default();
        ReplayActorCriticParams {
            gamma: self.gamma,
            planning_steps: self.planning_steps.unwrap_or(d.planning_steps),
            untried: self.untried.unwrap_or(d.untried),
            bonus: self.bonus.unwrap_or(d.bonus),
        }
    }

    /// What policy iteration takes from the table.
    pub fn policy_iteration(&self) -> PolicyIterationParams {
        let d = PolicyIterationParams::default();
        PolicyIterationParams {
            gamma: self.gamma,
            epsilon: self.epsilon.unwrap_or(d.epsilon),
            initial_value: self.initial_value,
            plan_every: self.plan_every,
            evaluation_sweeps: self.evaluation_sweeps,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<AgentParams, toml::de::Error> {
        toml::from_str(text)
    }

    #[test]
    fn an_empty_table_is_the_default_and_every_kind_parses() {
        assert_eq!(parse("").unwrap(), AgentParams::default());
        for kind in [
            "actor-critic",
            "replay-actor-critic",
            "q-learning",
            "sarsa",
            "dyna-q",
            "dyna-q-plus",
            "planner",
            "policy-iteration",
            "mbie-eb",
            "ucbvi",
            "psrl",
            "random",
        ] {
            let params = parse(&format!("kind = {kind:?}")).unwrap();
            assert_eq!(params.validate(), Ok(()), "{kind}");
            assert!(toml::to_string(&params).unwrap().contains(kind));
        }
        for update in ["advantage", "algorithm-1", "algorithm-2"] {
            assert_eq!(
                parse(&format!("update = {update:?}")).unwrap().validate(),
                Ok(()),
                "{update}"
            );
        }
    }

    #[test]
    fn misspelt_keys_are_refused() {
        assert!(parse("gama = 0.9").unwrap_err().message().contains("gama"));
        assert!(parse("kind = \"actor_critic\"").is_err());
    }

    #[test]
    fn broken_rules_are_named_with_their_key() {
        for (text, key) in [
            ("gamma = 1.5", "gamma"),
            ("gamma = nan", "gamma"),
            (
                "kind = \"actor-critic\"\nactor_learning_rate = 0",
                "actor_learning_rate",
            ),
            (
                "kind = \"actor-critic\"\ncritic_learning_rate = 1.2",
                "critic_learning_rate",
            ),
            (
                "kind = \"actor-critic\"\npreference_clip = inf",
                "preference_clip",
            ),
            ("kind = \"sarsa\"\nepsilon = -0.1", "epsilon"),
            (
                "kind = \"q-learning\"\ninitial_value = nan",
                "initial_value",
            ),
            ("kind = \"dyna-q\"\nplanning_steps = 0", "planning_steps"),
            ("kind = \"planner\"\nknown_after = 0", "known_after"),
            (
                "kind = \"dyna-q\"\nplanning_steps = 1000001",
                "planning_steps",
            ),
            (
                "kind = \"planner\"\nmax_backups = 4294967296",
                "max_backups",
            ),
            (
                "kind = \"planner\"\noptimistic_value = inf",
                "optimistic_value",
            ),
            (
                "kind = \"policy-iteration\"\nevaluation_sweeps = 0",
                "evaluation_sweeps",
            ),
            ("kind = \"dyna-q-plus\"\ntime_bonus = -1", "time_bonus"),
            ("kind = \"mbie-eb\"\nhorizon = 0", "horizon"),
            ("kind = \"mbie-eb\"\nbonus = nan", "bonus"),
            ("kind = \"ucbvi\"\nbonus = 1e7", "bonus"),
            ("kind = \"replay-actor-critic\"\nbonus = -1", "bonus"),
            (
                "kind = \"replay-actor-critic\"\nplanning_steps = 0",
                "planning_steps",
            ),
            ("kind = \"psrl\"\nprior_tries = 0", "prior_tries"),
            (
                "kind = \"psrl\"\nreward_deviation = inf",
                "reward_deviation",
            ),
        ] {
            let error = parse(text).unwrap().validate().unwrap_err();
            assert_eq!((error.section, error.key), ("agent", key), "{text}");
        }
    }

    #[test]
    fn resolving_writes_in_the_defaults_of_the_kind_and_changes_nothing() {
        for text in [
            "",
            "kind = \"actor-critic\"\nupdate = \"algorithm-1\"",
            "kind = \"sarsa\"",
            "kind = \"dyna-q\"\nepsilon = 0.3",
        ] {
            let params = parse(text).unwrap();
            let resolved = params.resolved();
            assert_eq!(resolved, resolved.resolved());
            if params.kind == AgentKind::ReplayActorCritic {
                assert_eq!(resolved.planning_steps, Some(3), "{text}");
                assert_eq!(resolved.untried, Some(Untried::Advised), "{text}");
                assert_eq!(resolved.replay_actor_critic(), params.replay_actor_critic());
                continue;
            }
            assert!(resolved.critic_learning_rate.is_some(), "{text}");
            match params.kind {
                AgentKind::Sarsa => assert_eq!(resolved.sarsa(), params.sarsa()),
                AgentKind::DynaQ => assert_eq!(resolved.dyna_q(), params.dyna_q()),
                _ => assert_eq!(resolved.actor_critic(), params.actor_critic()),
            }
        }
    }

    /// Algorithm 1: α moves the critic, β the actor; Algorithm 2: the other way round (section 4.3: α .01, β .005).
    #[test]
    fn printed_algorithms_take_the_printed_step_sizes() {
        let rates =
            |p: ActorCriticParams| (p.critic_learning_rate, p.actor_learning_rate, p.bootstrap);
        assert_eq!(
            rates(ActorCriticParams::of(UpdateRule::Algorithm1)),
            (0.01, 0.005, Bootstrap::Sampled)
        );
        assert_eq!(
            rates(ActorCriticParams::of(UpdateRule::Algorithm2)),
            (0.005, 0.01, Bootstrap::Sampled)
        );
    }
}
