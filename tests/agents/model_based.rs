//! Planner, Dyna-Q and policy iteration: what knowing the model buys.

use crate::world::{Numbering, Outcome, World, play};
use eigentrail::agent::{
    Agent, AgentKind, AgentParams, AnyAgent, Planner, PlannerParams, PolicyIteration,
    PolicyIterationParams,
};
use eigentrail::env::Action;

fn of_kind(kind: AgentKind, seed: u64) -> AnyAgent {
    AnyAgent::new(
        &AgentParams {
            kind,
            ..AgentParams::default()
        },
        4,
        1.0,
        seed,
    )
}

#[test]
fn the_planner_follows_a_shortest_path_and_stops_exploring_when_nothing_can_be_better() {
    for seed in 0..5 {
        let mut world = World::grid(8, 8, 0.0, seed);
        let mut planner = of_kind(AgentKind::Planner, seed);
        let log = play(&mut world, &mut planner, &mut Numbering::default(), 120);
        assert_eq!(log.final_mean(20), 14.0, "seed {seed}");
        // No more than every (state, action) tried once, with the ways between them.
        let wasted = log.total_steps() - 14 * 120;
        assert!(
            wasted < 4 * 64 * 3,
            "seed {seed}: {wasted} steps beyond the optimum"
        );
    }
}

/// A long way is found first; the short cut is an untried action at the start of which nothing is known.
fn short_cut_world(seed: u64) -> World {
    let certain = |next| {
        vec![Outcome {
            probability: 1.0,
            next,
            reward: -1.0,
        }]
    };
    // 0 → 1 → … → 7 → goal 8 by action 0; action 1 stays in place, but from 1 it leads to 9, and from 9 to the goal.
    let mut outcomes: Vec<_> = (0..10).map(|s| vec![certain(s + 1), certain(s)]).collect();
    outcomes[1][1] = certain(9);
    outcomes[9] = vec![certain(9), certain(8)];
    World::new(outcomes, vec![8], seed)
}

#[test]
fn the_planner_looks_for_something_better_after_the_first_goal() {
    for seed in 0..10 {
        let mut world = short_cut_world(seed);
        let mut planner = Planner::new(PlannerParams::default(), 2, seed);
        let log = play(&mut world, &mut planner, &mut Numbering::default(), 12);
        assert_eq!(log.final_mean(3), 3.0, "seed {seed}: {:?}", log.lengths);
    }
}

#[test]
fn the_planner_values_are_those_of_value_iteration() {
    let mut world = World::grid(6, 5, 0.0, 0);
    let (mut planner, mut numbering) = (
        Planner::new(PlannerParams::default(), 4, 0),
        Numbering::default(),
    );
    play(&mut world, &mut planner, &mut numbering, 200);
    let optimal = -planner.value(numbering.id(world.start)).unwrap();
    // 1e-6 a step is the planner's own cost of a step
    assert!((optimal - world.optimal_steps()).abs() < 1e-4, "{optimal}");
}

/// Under slip, with the probabilities it has seen, close to what value iteration reaches on the true ones.
#[test]
fn the_planner_plans_under_slip() {
    let world = World::grid(6, 6, 0.3, 0);
    let optimal = world.optimal_steps();
    let mut ratios: Vec<f64> = (0..9)
        .map(|seed| {
            let mut world = World::grid(6, 6, 0.3, seed);
            let params = PlannerParams {
                known_after: 5,
                ..PlannerParams::default()
            };
            let log = play(
                &mut world,
                &mut Planner::new(params, 4, seed),
                &mut Numbering::default(),
                600,
            );
            log.final_mean(300) / optimal
        })
        .collect();
    ratios.sort_by(f64::total_cmp);
    assert!(ratios[4] < 1.08, "median {} of optimal", ratios[4]);
    assert!(ratios[8] < 1.25, "worst {} of optimal", ratios[8]);
}

/// A one-way door into rooms without a goal: values there sink to the floor and no further, and the planner comes to
/// avoid the door.
#[test]
fn the_planner_survives_a_trap() {
    let certain = |next| {
        vec![Outcome {
            probability: 1.0,
            next,
            reward: -1.0,
        }]
    };
    // 0 –1→ trap {1, 2, 3}; 0 –0→ 4 –0→ 5 –0→ goal 6
    let trap = |s: usize| vec![certain(1 + s % 3), certain(1 + (s + 1) % 3)];
    let mut outcomes = vec![vec![certain(4), certain(1)], trap(1), trap(2), trap(3)];
    outcomes.extend([
        vec![certain(5), certain(4)],
        vec![certain(6), certain(5)],
        vec![certain(6), certain(6)],
    ]);
    let mut world = World::new(outcomes, vec![6], 0);
    let mut planner = Planner::new(PlannerParams::default(), 2, 0);
    let mut numbering = Numbering::default();
    let log = play(&mut world, &mut planner, &mut numbering, 30);
    assert_eq!(log.final_mean(10), 3.0);
    assert!(
        planner
            .value(numbering.id(2))
            .is_none_or(|value| value > -1000.0)
    );
}

#[test]
fn a_goal_that_moved_is_forgotten() {
    for kind in [
        AgentKind::Planner,
        AgentKind::DynaQ,
        AgentKind::PolicyIteration,
    ] {
        let mut world = World::grid(5, 5, 0.0, 0);
        let (mut agent, mut numbering) = (of_kind(kind, 0), Numbering::default());
        play(&mut world, &mut agent, &mut numbering, 60);
        world.goals = vec![20]; // the other corner of the left side
        let log = play(&mut world, &mut agent, &mut numbering, 200);
        let mean = log.final_mean(50);
        assert!(mean < 1.2 * 4.0, "{kind:?}: {mean} steps, 4 are enough");
    }
}

#[test]
fn replaying_the_model_saves_steps() {
    for seed in 0..5 {
        let steps = |kind| {
            let mut world = World::grid(9, 9, 0.0, seed);
            play(
                &mut world,
                &mut of_kind(kind, seed),
                &mut Numbering::default(),
                100,
            )
            .total_steps()
                - 1600
        };
        let (q_learning, dyna_q) = (steps(AgentKind::QLearning), steps(AgentKind::DynaQ));
        assert!(
            3 * dyna_q < q_learning,
            "seed {seed}: {dyna_q} against {q_learning} steps beyond the optimum"
        );
    }
}

/// Policy iteration on the learnt model of a slippery grid finds the optimal values once all was tried often enough.
#[test]
fn policy_iteration_learns_the_values_under_slip() {
    let mut world = World::grid(4, 4, 0.2, 2);
    let params = PolicyIterationParams {
        epsilon: 0.3,
        ..PolicyIterationParams::default()
    };
    let (mut agent, mut numbering) = (
        PolicyIteration::new(params, 4, 1.0, 2),
        Numbering::default(),
    );
    play(&mut world, &mut agent, &mut numbering, 4000);
    let learnt = -agent.value(numbering.id(world.start)).unwrap();
    let optimal = world.optimal_steps();
    assert!(
        (learnt / optimal - 1.0).abs() < 0.03,
        "{learnt} instead of {optimal}"
    );
    assert_ne!(
        agent.greedy_action(numbering.id(world.start), &[0.0; 4]),
        Some(Action(0)),
        "up, against the wall"
    );
}
