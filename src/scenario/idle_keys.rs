//! Keys that are written and have no effect, because another key has chosen what does not read them.

use super::Scenario;
use super::document::Document;
use crate::agent::AgentKind::*;
use crate::agent::FeatureKind;
use crate::exploration::ExplorationKind;
use crate::features::FeatureSource;
use crate::shaping::PotentialKind;

/// Keys of one kind, the key that decides whether they are read, and whether they are.
struct Rule {
    keys: &'static [&'static str],
    decided_by: &'static str,
    is_read: fn(&Scenario) -> bool,
}

/// Keys of one section that some learners read.
macro_rules! of_learners {
    ([$($key:literal),*], $learners:pat) => {
        Rule {
            keys: &[$($key),*],
            decided_by: "agent.kind",
            is_read: |scenario| matches!(scenario.agent.kind, $learners),
        }
    };
}

/// Keys that some potentials read.
macro_rules! of_potentials {
    ([$($key:literal),*], $potentials:pat) => {
        Rule {
            keys: &[$($key),*],
            decided_by: "shaping.potential",
            is_read: |scenario| matches!(scenario.shaping.potential, $potentials),
        }
    };
}

const RULES: [Rule; 22] = [
    of_learners!(
        [
            "agent.update",
            "agent.features",
            "agent.actor_learning_rate",
            "agent.preference_clip"
        ],
        ActorCritic
    ),
    of_learners!(
        ["agent.critic_learning_rate"],
        ActorCritic | QLearning | Sarsa | DynaQ | DynaQPlus
    ),
    of_learners!(["agent.bootstrap"], ActorCritic | Sarsa),
    of_learners!(
        ["agent.epsilon", "agent.initial_value"],
        QLearning | Sarsa | DynaQ | DynaQPlus | PolicyIteration
    ),
    of_learners!(
        ["agent.planning_steps"],
        DynaQ | DynaQPlus | ReplayActorCritic
    ),
    of_learners!(["agent.time_bonus"], DynaQPlus),
    of_learners!(["agent.known_after", "agent.max_backups"], Planner),
    of_learners!(["agent.untried"], Planner | ReplayActorCritic),
    of_learners!(["agent.optimistic_value"], Planner | MbieEb | Ucbvi | Psrl),
    of_learners!(["agent.horizon"], MbieEb | Ucbvi | Psrl),
    of_learners!(["agent.bonus"], MbieEb | Ucbvi | ReplayActorCritic),
    of_learners!(["agent.prior_tries", "agent.reward_deviation"], Psrl),
    of_learners!(
        ["agent.plan_every", "agent.evaluation_sweeps"],
        PolicyIteration
    ),
    of_potentials!(
        ["shaping.temperature"],
        PotentialKind::Gcn | PotentialKind::Dr
    ),
    of_potentials!(
        [
            "shaping.log_temperature_clip",
            "shaping.num_labels",
            "shaping.cold_epochs",
            "shaping.warm_epochs",
            "shaping.fit_tolerance",
            "shaping.smoothness"
        ],
        PotentialKind::Gcn
    ),
    of_potentials!(["shaping.heat_kept"], PotentialKind::Heat),
    of_potentials!(
        ["gcn.features", "gcn.hidden_dim", "gcn.learning_rate"],
        PotentialKind::Gcn | PotentialKind::Report
    ),
    of_potentials!(["gcn.epochs", "gcn.smoothness"], PotentialKind::Report),
    Rule {
        keys: &["shaping.scale", "shaping.scale_factor", "shaping.mix"],
        decided_by: "shaping.potential",
        is_read: |scenario| scenario.shaping.potential != PotentialKind::None,
    },
    Rule {
        keys: &["exploration.bonus"],
        decided_by: "exploration.kind",
        is_read: |scenario| scenario.exploration.kind == ExplorationKind::CountBonus,
    },
    Rule {
        keys: &["exploration.frontier_advice", "exploration.order"],
        decided_by: "exploration.kind",
        is_read: |scenario| scenario.exploration.kind == ExplorationKind::Frontier,
    },
    Rule {
        keys: &[
            "deepwalk.dimensions",
            "deepwalk.walks_per_node",
            "deepwalk.walk_length",
            "deepwalk.window",
            "deepwalk.negatives",
            "deepwalk.learning_rate",
        ],
        decided_by: "gcn.features",
        is_read: |scenario| {
            scenario.gcn.features == FeatureSource::Deepwalk
                || scenario.agent.features == FeatureKind::Deepwalk
        },
    },
];

/// What is to be said of the keys of `document` that have no effect in the `scenario` that came out of it.
pub(super) fn cautions(scenario: &Scenario, document: &Document) -> Vec<String> {
    let settings = scenario.settings();
    let written = document.written().into_iter();
    written
        .filter_map(|(key, place)| {
            let rule = RULES
                .iter()
                .find(|rule| rule.keys.contains(&key.as_str()))?;
            let choice = settings.get(rule.decided_by)?;
            let caution = format!(
                "{place}: {key} has no effect with {} = {choice}",
                rule.decided_by
            );
            (!(rule.is_read)(scenario)).then_some(caution)
        })
        .collect()
}
