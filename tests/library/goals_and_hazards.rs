//! Goals that each seed draws, and ends that are no goals.

use crate::env_worlds::grid_world;
use eigentrail::engine::{PipelineParams, ShapingPipeline};
use eigentrail::env::conformance::check_model;
use eigentrail::env::{
    Action, Cell, Direction, EnvError, Environment, GridWorldParams, Landmark, Layout, Model,
    RewardScheme, Step, StepStatus,
};
use eigentrail::graph::StateId;
use eigentrail::scenario::{Scenario, World};
use eigentrail::seeds::{Stream, stream};
use eigentrail::shaping::Potential;
use std::collections::BTreeMap;
use std::path::Path;

fn ascii(map: &str) -> Layout {
    Layout::from_ascii(map, &BTreeMap::new()).unwrap()
}

fn params() -> GridWorldParams {
    GridWorldParams::default()
}

/// The worlds of a scenario, by seed.
fn world(name: &str, seed: u64) -> World {
    let loaded = Scenario::load(Path::new(name), &[]).unwrap();
    loaded.worlds.first_for(seed)
}

fn map(world: &World) -> &Layout {
    match world {
        World::Grid(world) => world.layout(),
        World::Listed(..) => panic!("no map"),
    }
}

fn drawn(layout: &Layout, random_start: bool, seed: u64) -> Cell {
    let rng = &mut stream(seed, Stream::Goals);
    let layout = layout.clone().with_random_goal(random_start, rng).unwrap();
    assert_eq!(layout.goals.len(), 1);
    layout.goals[0].cell
}

#[test]
fn random_goals_are_uniform_over_what_can_be_reached() {
    // Neither the start, nor the hazard in the gap of the wall, nor what is behind it.
    let layout = ascii("S..#.\n...#.\n.....")
        .with_hazard([2, 3], 0.0)
        .unwrap();
    let (draws, mut counts) = (8000, BTreeMap::new());
    for seed in 0..draws {
        *counts.entry(drawn(&layout, false, seed).0).or_insert(0_u32) += 1;
    }
    let places: Vec<u32> = counts.keys().copied().collect();
    assert_eq!(places, [1, 2, 5, 6, 7, 10, 11, 12]);
    let expected = draws as f64 / 8.0;
    let chi_square: f64 = counts
        .values()
        .map(|&n| (f64::from(n) - expected).powi(2) / expected)
        .sum();
    assert!(chi_square < 24.322, "{chi_square}"); // 0.999 quantile with 7 degrees of freedom
}

#[test]
fn with_random_starts_a_goal_is_wherever_one_can_enter() {
    // The arrow at 0 can be entered like any cell, and be left to the right only; 4 stands alone.
    let layout = ascii(">..#.");
    let places: std::collections::BTreeSet<u32> =
        (0..200).map(|seed| drawn(&layout, true, seed).0).collect();
    assert_eq!(places.into_iter().collect::<Vec<_>>(), [0, 1, 2]);
    let alone = ascii("S#.").with_random_goal(false, &mut stream(0, Stream::Goals));
    assert_eq!(alone, Err(EnvError::NoPlaceForGoal));
}

#[test]
fn each_seed_has_a_goal_of_its_own_and_keeps_it() {
    for name in [
        "four_rooms_random_goals",
        "u_trap_random_goals",
        "open_15x15_random_goals",
    ] {
        let loaded = Scenario::load(Path::new(name), &[]).unwrap();
        assert!(loaded.worlds.differ_by_seed());
        let mut goals = std::collections::BTreeSet::new();
        for seed in 0..20 {
            let world = loaded.worlds.first_for(seed);
            let layout = map(&world);
            assert_eq!(layout.goals.len(), 1);
            let goal = layout.goals[0].cell;
            // Found again by whoever reads the scenario later.
            let later = loaded.scenario.world_in(seed, 0).unwrap();
            assert_eq!(map(&later), layout, "{name} {seed}");
            let moves = layout.distances_from(layout.start.unwrap())[goal.index()];
            let optimum = world.optimum();
            assert_eq!(optimum.expected_steps, f64::from(moves.unwrap()));
            assert_eq!(optimum.expected_return, -optimum.expected_steps);
            goals.insert(goal);
        }
        assert!(goals.len() > 12, "{name}: {goals:?}");
    }
    let fixed = Scenario::load(Path::new("four_rooms"), &[]).unwrap();
    assert!(!fixed.worlds.differ_by_seed());
    assert_eq!(
        map(&fixed.worlds.first_for(1)),
        map(&fixed.worlds.first_for(2))
    );
}

#[test]
fn a_hazard_ends_an_episode_and_pays_on_top_of_the_step() {
    let layout = ascii("S..G").with_hazard([0, 1], -50.0).unwrap();
    let open = ascii("S..G\n....").with_hazard([0, 1], -50.0).unwrap();
    assert!(matches!(
        eigentrail::env::GridWorld::new(layout, params(), stream(0, Stream::Environment)),
        Err(EnvError::GoalUnreachable { .. })
    ));
    assert_eq!(open.to_string(), "SX.G\n....");
    let mut world = grid_world(&open, &params(), 0);
    world.reset();
    let step = world.step(Direction::Right.action());
    assert_eq!(
        (step.state, step.reward, step.status),
        (Cell(1), -51.0, StepStatus::Terminated)
    );
    let optimum = world.optimum();
    assert_eq!(
        (optimum.expected_steps, optimum.expected_return),
        (5.0, -5.0)
    );
    // Where it is cheap, the hazard is the better end.
    let cheap = ascii("S..G\n....").with_hazard([0, 1], -2.0).unwrap();
    let optimum = grid_world(&cheap, &params(), 0).optimum();
    assert_eq!(
        (optimum.expected_steps, optimum.expected_return),
        (1.0, -3.0)
    );
    // Distances are to goals and around hazards, and the farthest place is no hazard.
    assert_eq!(open.distances_to_goals()[0], Some(5));
    assert_eq!(open.distances_to_goals()[1], None);
    let row = ascii("S...").with_hazard([0, 3], 0.0).unwrap();
    assert_eq!(row.locate(Landmark::Farthest.into()), Ok(Cell(2)));
}

#[test]
fn worlds_with_hazards_are_what_their_models_say() {
    let layout = ascii("S...\n.>..\n..#.\n...G");
    let layout = layout.with_hazard([0, 2], -7.0).unwrap();
    let layout = layout.with_hazard([3, 1], 3.0).unwrap();
    for (slip, random_start) in [(0.0, false), (0.3, false), (0.2, true)] {
        let params = GridWorldParams {
            slip,
            random_start,
            rewards: RewardScheme::GoalBonus,
            ..params()
        };
        let random = slip > 0.0 || random_start;
        let coverage = check_model(|seed| grid_world(&layout, &params, seed), random)
            .unwrap_or_else(|broken| panic!("slip {slip}:\n{broken}"));
        assert!(coverage.terminations > 0);
        let world = grid_world(&layout, &params, 0);
        let hazards = [Cell(2), Cell(13)];
        assert!(world.starts().iter().all(|start| !hazards.contains(start)));
    }
}

#[test]
fn shipped_worlds_with_hazards_have_the_optimum_counted_by_hand() {
    for (name, steps, earned, limit) in [
        ("lava_gap_7", 8.0, 1.0, 196),
        ("dist_shift_1", 10.0, 1.0, 252),
        ("dist_shift_2", 8.0, 1.0, 252),
        ("holes", 14.0, -14.0, 640),
    ] {
        let world = world(name, 0);
        let optimum = world.optimum();
        assert_eq!(
            (optimum.expected_steps, optimum.expected_return),
            (steps, earned),
            "{name}"
        );
        assert_eq!(world.max_steps(), limit, "{name}");
    }
}

#[test]
fn what_cannot_be_is_told_with_its_place() {
    let refused = |text: &str| {
        let parsed = Scenario::parse(Path::new("x.toml"), text.to_owned(), &[]);
        parsed
            .err()
            .map_or(String::new(), |error| error.to_string())
    };
    for (text, told) in [
        (
            "goals = \"rnadom\"",
            "expected \"random\" or a list of goals",
        ),
        (
            "hazards = [{ at = \"top-left\", reward = 0 }]",
            "the hazard [0, 0] is the start, too",
        ),
        (
            "hazards = [{ at = \"bottom-right\", reward = 0 }]",
            "the hazard [14, 14] is a goal, too",
        ),
        (
            "hazards = [{ at = [1, 1], reward = 0 }, { at = [1, 1], reward = 1 }]",
            "the hazard [1, 1] is given twice",
        ),
        (
            "hazards = [{ at = [1, 1], reward = 1e99 }]",
            "env.hazards[0].reward = 1e99: ",
        ),
        (
            "rows = 1\ncols = 1\ngoals = \"random\"",
            "no place for a random goal",
        ),
        (
            "kind = \"taxi\"\ngoals = \"random\"",
            "env.goals means nothing",
        ),
        (
            "kind = \"edge-list\"\nfile = \"x.csv\"\ngoals = \"random\"",
            "env.goals = \"random\" is for maps",
        ),
    ] {
        let message = refused(&format!("[env]\n{text}\n"));
        assert!(message.contains(told), "{text}: {message}");
    }
}

/// The agent alone decides; nothing but the potential is looked at.
#[test]
fn a_hazard_that_is_none_any_more_leaves_no_potential_behind() {
    let mut pipeline = ShapingPipeline::new(&PipelineParams::default(), 2, None, 0).unwrap();
    let walk = |pipeline: &mut ShapingPipeline<u32>, last: StepStatus| {
        pipeline.begin_episode(&0);
        for state in 1..=4 {
            let (reward, status) = match state {
                4 => (-100.0, last),
                _ => (-1.0, StepStatus::Running),
            };
            let step = Step {
                state,
                reward,
                status,
            };
            pipeline.observe(Action(0), &step).unwrap();
        }
    };
    walk(&mut pipeline, StepStatus::Terminated);
    let near = pipeline.potential().value(StateId(3));
    assert!(
        near < pipeline.potential().value(StateId(0)),
        "{near}: it repels"
    );
    walk(&mut pipeline, StepStatus::Running);
    let values = pipeline.potential().values();
    assert!(values.iter().all(|&phi| phi == 0.0), "{values:?}");
}
