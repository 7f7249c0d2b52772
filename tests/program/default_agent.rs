//! The default agent, from outside: what φ leads to may cost time, and not the best policy.

use crate::program::Program;
use serde_json::Value;

fn compared(world: &str, settings: &[&str], arms: &str) -> Vec<Value> {
    let program = Program::new();
    let mut command = vec!["compare", world, "--seeds", "0..4", "--arms", arms];
    command.extend(["--no-report", "--json", "-q"]);
    settings.iter().for_each(|s| command.extend(["--set", s]));
    let printed: Value = serde_json::from_str(&program.prints(&command)).unwrap();
    printed["arms"].as_array().unwrap().clone()
}

/// Paths are those of value iteration on the true map, exactly, with the potential of a run, with none, with the opposite of the right
/// one and with one drawn at random.
#[test]
fn every_potential_ends_on_the_best_policy() {
    let settings = ["env.goals=random", "run.episodes=150"];
    let arms = "sparse,gcn,frontier-only,negated-oracle,random-potential";
    for arm in &compared("four_rooms", &settings, arms)[1..] {
        assert_eq!(arm["failures"], 0.0, "{}", arm["name"]);
        // There is no advice beside the search.
        assert_eq!(arm["failures_unadvised"], 0.0, "{}", arm["name"]);
    }
}

/// With one backup a step, what was found at the far end comes home by φ at once, and step by step without it.
#[test]
fn the_shaped_reward_brings_news_home() {
    let settings = [
        "run.episodes=60",
        "arms.frugal.base=gcn",
        "arms.frugal.agent.planning_steps=1",
        "arms.unshaped.base=frontier-only",
        "arms.unshaped.agent.planning_steps=1",
    ];
    let arms = compared("four_rooms", &settings, "sparse,frugal,unshaped");
    let regret = |arm: usize| arms[arm]["regret"]["iqm"].as_f64().unwrap();
    assert!(
        3.0 * regret(1) < regret(2),
        "{} with φ, {} without",
        regret(1),
        regret(2)
    );
}

/// Lava, a cliff, and short ways that are bad ways: three of ten steps on a bridge of four fall.
#[test]
fn ends_that_cost_and_ways_that_fall_are_avoided() {
    for world in [
        "lava_gap_7",
        "dist_shift_1",
        "holes",
        "cliff_walking",
        "bridge_pit",
        "bridge_swamp",
        "bridge_back",
    ] {
        let arms = compared(world, &[], "sparse,gcn");
        assert_eq!(arms[1]["failures"], 0.0, "{world}");
        let ratio = arms[1]["ratio_to_sparse"]["median"].as_f64().unwrap();
        assert!(ratio < 0.5, "{world}: {ratio} of the regret of sparse");
    }
}
