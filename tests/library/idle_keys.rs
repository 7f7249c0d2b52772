//! Keys of which a scenario's author is told that they have no effect: they have none.

use eigentrail::runner::{self, Watch};
use eigentrail::scenario::{Loaded, Scenario, shipped};
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::atomic::AtomicBool;

const WORLD: &str =
    "[env]\nrows = 4\ncols = 4\nslip = 0.1\n[run]\nepisodes = 6\n[agent]\nhorizon = 20\n";

/// A value for each key that may have no effect, which is not its default.
const VALUES: [&str; 42] = [
    "agent.update=\"algorithm-2\"",
    "agent.features=\"pvf\"",
    "agent.actor_learning_rate=0.5",
    "agent.preference_clip=1.5",
    "agent.critic_learning_rate=0.2",
    "agent.bootstrap=\"expected\"",
    "agent.epsilon=0.5",
    "agent.initial_value=-7.0",
    "agent.planning_steps=1",
    "agent.time_bonus=0.5",
    "agent.known_after=4",
    "agent.max_backups=1",
    "agent.untried=\"optimistic\"",
    "agent.optimistic_value=3.0",
    "agent.horizon=5",
    "agent.bonus=4.0",
    "agent.prior_tries=9.0",
    "agent.reward_deviation=2.0",
    "agent.plan_every=3",
    "agent.evaluation_sweeps=1",
    "shaping.temperature=9.0",
    "shaping.log_temperature_clip=0.25",
    "shaping.num_labels=1",
    "shaping.cold_epochs=1",
    "shaping.warm_epochs=1",
    "shaping.fit_tolerance=0.5",
    "shaping.smoothness=3.0",
    "shaping.heat_kept=0.2",
    "shaping.scale=\"raw\"",
    "shaping.scale_factor=3.0",
    "shaping.mix=0.25",
    "gcn.features=\"constant\"",
    "gcn.hidden_dim=2",
    "gcn.learning_rate=0.5",
    "gcn.epochs=1",
    "gcn.smoothness=2.0",
    "exploration.bonus=3.0",
    "exploration.frontier_advice=1.0",
    "exploration.order=\"by-action\"",
    "deepwalk.dimensions=3",
    "deepwalk.window=2",
    "deepwalk.learning_rate=0.2",
];

/// Values of the keys that decide which others are read.
const CHOICES: [&[&str]; 3] = [
    &[
        "agent.kind=actor-critic",
        "agent.kind=replay-actor-critic",
        "agent.kind=q-learning",
        "agent.kind=sarsa",
        "agent.kind=dyna-q",
        "agent.kind=dyna-q-plus",
        "agent.kind=planner",
        "agent.kind=policy-iteration",
        "agent.kind=mbie-eb",
        "agent.kind=ucbvi",
        "agent.kind=psrl",
        "agent.kind=random",
    ],
    &[
        "shaping.potential=gcn",
        "shaping.potential=report",
        "shaping.potential=heat",
        "shaping.potential=dr",
        "shaping.potential=hops",
        "shaping.potential=oracle",
        "shaping.potential=none",
    ],
    &[
        "exploration.kind=frontier",
        "exploration.kind=count-bonus",
        "exploration.kind=none",
    ],
];

fn load(sets: &[&str]) -> Option<Loaded> {
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    Scenario::parse(Path::new("x.toml"), WORLD.to_owned(), &sets).ok()
}

/// What a run leaves of its episodes.
fn played(loaded: &Loaded) -> String {
    let folder = tempfile::tempdir().unwrap();
    let watch = Watch {
        stop: &AtomicBool::new(false),
        observers: &|_| Ok(Vec::new()),
    };
    runner::run_seed(loaded, 3, folder.path(), false, watch).unwrap();
    std::fs::read_to_string(folder.path().join("episodes.csv")).unwrap()
}

fn key(set: &str) -> &str {
    set.split('=').next().unwrap()
}

#[test]
fn what_is_said_to_have_no_effect_has_none() {
    let (mut said, mut unsaid) = (BTreeSet::new(), BTreeSet::new());
    for choice in CHOICES.into_iter().flatten() {
        let without = played(&load(&[choice]).unwrap());
        for value in VALUES {
            // Some values do not go with some choices, which is told as a mistake.
            let Some(loaded) = load(&[choice, value]) else {
                continue;
            };
            let is_said = loaded
                .cautions
                .iter()
                .any(|caution| caution.contains(key(value)));
            match is_said {
                true => said.insert(key(value)),
                false => unsaid.insert(key(value)),
            };
            if is_said {
                assert_eq!(
                    played(&loaded),
                    without,
                    "{value} has an effect with {choice}"
                );
            }
        }
    }
    let all: BTreeSet<&str> = VALUES.into_iter().map(key).collect();
    assert_eq!(said, all, "each has none with some choice");
    let without_deepwalk: BTreeSet<&str> = all
        .into_iter()
        .filter(|key| !key.starts_with("deepwalk"))
        .collect();
    assert_eq!(unsaid, without_deepwalk, "and may have one with another");
}

#[test]
fn a_caution_names_the_place_and_the_choice() {
    let text = "[env]\nrows = 3\n[agent]\nepsilon = 0.1\nkind = \"random\"\n";
    let sets = ["gcn.epochs=3".to_owned()];
    let loaded = Scenario::parse(Path::new("x.toml"), text.to_owned(), &sets).unwrap();
    assert_eq!(
        loaded.cautions,
        [
            "x.toml:4:1: agent.epsilon has no effect with agent.kind = \"random\"",
            "--set gcn.epochs=3: gcn.epochs has no effect with shaping.potential = \"gcn\"",
        ]
    );
}

/// An arm may read what the scenario itself does not.
#[test]
fn nothing_is_said_where_there_are_arms() {
    let text = "[agent]\nepsilon = 0.1\n[arms.q]\nbase = \"q-learning\"\n";
    let loaded = Scenario::parse(Path::new("x.toml"), text.to_owned(), &[]).unwrap();
    assert!(loaded.cautions.is_empty(), "{:?}", loaded.cautions);
}

#[test]
fn no_shipped_scenario_says_what_has_no_effect() {
    for file in shipped() {
        let loaded = Scenario::load(Path::new(file.name), &[]).unwrap();
        assert!(
            loaded.cautions.is_empty(),
            "{}: {:?}",
            file.name,
            loaded.cautions
        );
    }
}
