//! What is compared: each arm is a name for a few settings, laid over the scenario as `--set` would.
//!
//! So an arm has no code of its own, and whatever the scenario says about other keys holds for all of them alike: a
//! step size that it gives is shared, one that it leaves out takes the default of the arm's learner.

use super::error::RunnerError;
use crate::error::Error;
use crate::scenario::{Choices, Loaded, Scenario};
use std::path::Path;

/// The arm that all others are measured against.
pub const BASELINE: &str = "sparse";

/// A name for a few settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuiltInArm {
    /// Its name.
    pub name: &'static str,
    /// What it is, in one line.
    pub about: &'static str,
    /// `section.key=value`.
    pub settings: &'static [&'static str],
}

/// An arm laid over a scenario.
#[derive(Clone, Debug, PartialEq)]
pub struct Arm {
    /// Its name.
    pub name: String,
    /// `section.key=value`, laid over the file and over `--set`.
    pub settings: Vec<String>,
    /// What came out, complete and checked.
    pub scenario: Scenario,
}

const fn arm(
    name: &'static str,
    about: &'static str,
    settings: &'static [&'static str],
) -> BuiltInArm {
    BuiltInArm {
        name,
        about,
        settings,
    }
}

/// An actor-critic with this potential and this exploration.
macro_rules! actor_critic {
    ($potential:literal, $exploration:literal $(, $more:literal)*) => {
        &[
            "agent.kind=actor-critic",
            concat!("shaping.potential=", $potential),
            concat!("exploration.kind=", $exploration),
            $($more),*
        ]
    };
}

/// A learner without potential and without exploration beyond its own.
macro_rules! alone {
    ($kind:literal) => {
        &[
            concat!("agent.kind=", $kind),
            "shaping.potential=none",
            "exploration.kind=none",
        ]
    };
}

/// Every built-in arm. The report's step sizes are those of its section 4.3.
pub const BUILT_IN_ARMS: &[BuiltInArm] = &[
    arm(
        "sparse",
        "the actor-critic alone: no potential, no exploration",
        actor_critic!("none", "none"),
    ),
    arm(
        "count-bonus",
        "the actor-critic with β/√N added to its reward",
        actor_critic!("none", "count-bonus"),
    ),
    arm(
        "report",
        "the raw class probability and Algorithm 1, as the report prints them",
        actor_critic!(
            "report",
            "none",
            "shaping.scale=raw",
            "agent.update=algorithm-1",
            "agent.actor_learning_rate=0.005",
            "agent.critic_learning_rate=0.01",
            "agent.bootstrap=sampled"
        ),
    ),
    arm(
        "report-alg2",
        "the same with Algorithm 2",
        actor_critic!(
            "report",
            "none",
            "shaping.scale=raw",
            "agent.update=algorithm-2",
            "agent.actor_learning_rate=0.01",
            "agent.critic_learning_rate=0.005",
            "agent.bootstrap=sampled"
        ),
    ),
    arm(
        "gcn",
        "the default: the network's diffusion as potential, frontier exploration",
        actor_critic!("gcn", "frontier"),
    ),
    arm(
        "gcn-shaping-only",
        "the same potential without exploration",
        actor_critic!("gcn", "none"),
    ),
    arm(
        "heat",
        "a diffusion without a network, frontier exploration",
        actor_critic!("heat", "frontier"),
    ),
    arm(
        "hops",
        "hop distance on the visited graph, frontier exploration",
        actor_critic!("hops", "frontier"),
    ),
    arm(
        "oracle",
        "distance on the true map, frontier exploration",
        actor_critic!("oracle", "frontier"),
    ),
    arm(
        "frontier-only",
        "frontier exploration without a potential",
        actor_critic!("none", "frontier"),
    ),
    arm("q-learning", "Q-learning alone", alone!("q-learning")),
    arm("sarsa", "SARSA alone", alone!("sarsa")),
    arm(
        "dyna-q",
        "Dyna-Q with prioritised sweeping, alone",
        alone!("dyna-q"),
    ),
    arm(
        "planner",
        "R-max on the learnt model, alone",
        alone!("planner"),
    ),
    arm(
        "policy-iteration",
        "policy iteration on the learnt model with the network's shaped reward",
        &[
            "agent.kind=policy-iteration",
            "shaping.potential=gcn",
            "exploration.kind=none",
        ],
    ),
];

/// Lays the arm `name` over a scenario: `loaded` is the file at `path` with the assignments `sets`.
///
/// # Errors
/// If there is no such arm, or it does not go with the scenario.
pub fn lay_arm(name: &str, path: &Path, loaded: &Loaded, sets: &[String]) -> Result<Arm, Error> {
    let Some(arm) = BUILT_IN_ARMS.iter().find(|arm| arm.name == name) else {
        let known = BUILT_IN_ARMS.iter().map(|arm| arm.name.to_owned());
        return Err(RunnerError::UnknownArm {
            name: name.to_owned(),
            right: Box::new(Choices::near(name, known.collect())),
        }
        .into());
    };
    let settings = arm.settings.iter().map(|&s| s.to_owned()).collect();
    lay_settings(name, settings, path, loaded, sets)
}

/// Lays settings over a scenario under a name of their own.
///
/// # Errors
/// If they do not go with the scenario.
pub fn lay_settings(
    name: &str,
    settings: Vec<String>,
    path: &Path,
    loaded: &Loaded,
    sets: &[String],
) -> Result<Arm, Error> {
    let all: Vec<String> = sets.iter().chain(&settings).cloned().collect();
    let scenario = Scenario::parse(path, loaded.text.clone(), &all)?.scenario;
    Ok(Arm {
        name: name.to_owned(),
        settings,
        scenario,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::agent::{AgentKind, UpdateRule};
    use crate::exploration::ExplorationKind;
    use crate::shaping::PotentialKind;

    fn lay(name: &str, text: &str) -> Result<Arm, Error> {
        let path = Path::new("x.toml");
        let loaded = Scenario::parse(path, text.to_owned(), &[]).unwrap();
        lay_arm(name, path, &loaded, &[])
    }

    #[test]
    fn every_arm_is_accepted_and_no_two_are_the_same() {
        let arms: Vec<Arm> = BUILT_IN_ARMS
            .iter()
            .map(|arm| lay(arm.name, "").unwrap())
            .collect();
        for (i, arm) in arms.iter().enumerate() {
            assert!(arms[..i].iter().all(|a| a.scenario != arm.scenario));
        }
    }

    #[test]
    fn gcn_is_the_default_scenario() {
        let plain = Scenario::parse(Path::new("x.toml"), String::new(), &[]);
        assert_eq!(lay("gcn", "").unwrap().scenario, plain.unwrap().scenario);
    }

    #[test]
    fn an_arm_decides_its_own_keys_and_no_others() {
        let text = "[agent]\nkind = \"sarsa\"\ngamma = 0.9\n[shaping]\nscale_factor = 3\n";
        let gcn = lay("gcn", text).unwrap().scenario;
        assert_eq!(gcn.agent.kind, AgentKind::ActorCritic);
        assert_eq!(gcn.agent.gamma, 0.9);
        assert_eq!(gcn.shaping.scale_factor, 3.0);
        let q = lay("q-learning", text).unwrap().scenario;
        assert_eq!(q.agent.kind, AgentKind::QLearning);
        assert_eq!(q.shaping.potential, PotentialKind::None);
        assert_eq!(q.exploration.kind, ExplorationKind::None);
        // Unset keys take the default of the arm's learner, not of the file's.
        assert_eq!(q.agent.q_learning().learning_rate, 1.0);
    }

    #[test]
    fn the_report_comes_with_its_own_step_sizes() {
        let text = "[agent]\nactor_learning_rate = 0.3\n";
        let agent = lay("report", text).unwrap().scenario.agent;
        assert_eq!(agent.update, UpdateRule::Algorithm1);
        assert_eq!(agent.actor_critic().actor_learning_rate, 0.005);
    }

    #[test]
    fn an_unknown_arm_is_corrected() {
        let error = lay("plannner", "").unwrap_err().to_string();
        assert_eq!(
            error,
            "--arms: there is no arm `plannner`; did you mean `planner`?"
        );
        assert!(lay("xyz", "").unwrap_err().to_string().contains("sparse"));
    }
}
