//! Planner, Dyna-Q and policy iteration: what knowing the model buys.

use super::world::{Numbering, Outcome, World, play};
use eigentrail::agent::{
    Agent, AgentKind, AgentParams, AnyAgent, Planner, PlannerParams, PolicyIteration,
    PolicyIterationParams, Untried,
};
use eigentrail::env::Action;

fn of_kind(kind: AgentKind, seed: u64) -> AnyAgent {
    AnyAgent::new(
        &AgentParams {
            kind,
            untried: Some(Untried::Optimistic), // nobody advises it
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
        AgentKind::ReplayActorCritic,
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

fn sure(next: usize, reward: f64) -> Vec<Outcome> {
    vec![Outcome {
        probability: 1.0,
        next,
        reward,
    }]
}

/// At most two budgets a step in the mean, of 200 or 8 a state, and one plan from the floor.
fn assert_bounded(planner: &Planner, states: usize, steps: usize) {
    let allowed = 2 * steps * 200.max(8 * states) + PlannerParams::default().max_backups;
    assert!(
        planner.backups() <= allowed as u64,
        "{} backups in {steps} steps",
        planner.backups()
    );
}

/// 0 may stay for +1 or walk over 1 to the goal 2 for −2: thirty steps of an episode are best spent staying.
#[test]
fn a_loop_that_pays_is_gone_round_at_a_few_backups_a_step() {
    let mut outcomes = vec![vec![sure(0, 1.0), sure(1, -1.0)]];
    outcomes.extend([vec![sure(2, -1.0), sure(1, -1.0)], vec![sure(2, 0.0); 2]]);
    for seed in 0..5 {
        let mut world = World::new(outcomes.clone(), vec![2], seed);
        let mut planner = Planner::new(PlannerParams::default(), 2, seed);
        let log = play(&mut world, &mut planner, &mut Numbering::default(), 20);
        let last = &log.actions[log.actions.len() - 30..];
        assert_eq!(last, [Action(0); 30], "seed {seed}");
        assert!(
            planner.backups() < 5 * log.total_steps() as u64,
            "{}",
            planner.backups()
        );
    }
}

/// A loop at the start that pays .5, and one behind a step of −1 that pays 1. In 50 steps: 25 against 48.
#[test]
fn of_two_loops_the_better_one_is_sought_once_both_are_known() {
    let mut outcomes = vec![vec![sure(0, 0.5), sure(1, -1.0)]];
    outcomes.extend([vec![sure(1, 1.0), sure(0, -1.0)], vec![sure(2, 0.0); 2]]);
    outcomes.extend([vec![sure(2, 0.0); 2], vec![sure(2, 0.0); 2]]);
    let mut world = World::new(outcomes, vec![2], 0);
    let params = PlannerParams {
        optimistic_value: Some(1000.0),
        ..PlannerParams::default()
    };
    let mut planner = Planner::new(params, 2, 0);
    let log = play(&mut world, &mut planner, &mut Numbering::default(), 20);
    let last = &log.actions[log.actions.len() - 50..];
    assert_eq!(last[0], Action(1));
    assert_eq!(last[1..], [Action(0); 49]);
    assert_bounded(&planner, 5, log.total_steps());
}

/// FrozenLake (Gymnasium, 4 × 4, slippery): all steps are free, holes and the goal end the episode, the goal pays 1.
fn frozen_lake(seed: u64) -> World {
    const MAP: &[u8; 16] = b"SFFFFHFHFFFHHFFG";
    let next = |cell: usize, way: usize| match way {
        0 if !cell.is_multiple_of(4) => cell - 1,
        1 if cell < 12 => cell + 4,
        2 if cell % 4 < 3 => cell + 1,
        3 if cell >= 4 => cell - 4,
        _ => cell,
    };
    let outcome = |cell, way: usize| Outcome {
        probability: 1.0 / 3.0,
        next: next(cell, way % 4),
        reward: f64::from(u8::from(next(cell, way % 4) == 15 && cell != 15)),
    };
    let of_action = |cell, action: usize| (3..6).map(|turn| outcome(cell, action + turn)).collect();
    let of_cell = |cell| (0..4).map(|action| of_action(cell, action)).collect();
    let ends = (0..16).filter(|&cell| b"HG".contains(&MAP[cell])).collect();
    let mut world = World::new((0..16).map(of_cell).collect(), ends, seed);
    world.max_steps = 100;
    world
}

/// Expected return of an episode of 100 steps; `None`: of the best policy.
fn hundred_steps(world: &World, policy: Option<&dyn Fn(usize) -> usize>) -> f64 {
    let mut values = vec![0.0; world.num_states()];
    for _ in 0..100 {
        let later = values.clone();
        let worth = |s: usize, a: usize| -> f64 {
            let outcomes = world.outcomes[s][a].iter();
            outcomes
                .map(|o| o.probability * (o.reward + later[o.next]))
                .sum()
        };
        for s in (0..world.num_states()).filter(|s| !world.goals.contains(s)) {
            values[s] = match policy {
                Some(policy) => worth(s, policy(s)),
                None => (0..4)
                    .map(|a| worth(s, a))
                    .fold(f64::NEG_INFINITY, f64::max),
            };
        }
    }
    values[world.start]
}

#[test]
fn free_loops_under_slip_neither_hold_the_plan_up_nor_keep_the_planner_busy() {
    let mut shares: Vec<f64> = (0..5)
        .map(|seed| {
            let mut world = frozen_lake(seed);
            let best = hundred_steps(&world, None);
            assert!((best - 0.744).abs() < 5e-4, "{best}");
            let params = PlannerParams {
                known_after: 20,
                ..PlannerParams::default()
            };
            let mut planner = Planner::new(params, 4, seed);
            let mut numbering = Numbering::default();
            let log = play(&mut world, &mut planner, &mut numbering, 500);
            assert_bounded(&planner, 16, log.total_steps());
            let greedy = |state: usize| {
                let id = numbering.clone().id(state);
                let action = planner.greedy_action(id, &[0.0; 4]);
                action.map_or(0, Action::index)
            };
            hundred_steps(&world, Some(&greedy)) / best
        })
        .collect();
    shares.sort_by(f64::total_cmp);
    assert!(shares[2] > 0.95, "{shares:?} of the best return");
    assert!(shares[0] > 0.8, "{shares:?} of the best return");
}

/// A ring of thirty free steps with two ways out: a gamble worth .25 and a sure .5. Who wins the gamble first believes it to be
/// worth 1, all round the ring; when it turns out to be worth less, the ring must not hold the belief up.
#[test]
fn a_belief_is_given_up_all_round_a_free_ring() {
    let ring = |s: usize| vec![sure((s + 1) % 30, 0.0), sure(s, 0.0)];
    let mut outcomes: Vec<_> = (0..30).map(ring).collect();
    let gamble = |probability, reward| Outcome {
        probability,
        next: 30,
        reward,
    };
    outcomes[3][1] = vec![gamble(0.25, 1.0), gamble(0.75, 0.0)];
    outcomes[20][1] = sure(31, 0.5);
    outcomes.extend([vec![sure(30, 0.0); 2], vec![sure(31, 0.0); 2]]);
    for seed in 0..8 {
        let mut world = World::new(outcomes.clone(), vec![30, 31], seed);
        let params = PlannerParams {
            optimistic_value: Some(1.0),
            ..PlannerParams::default()
        };
        let mut planner = Planner::new(params, 2, seed);
        let mut numbering = Numbering::default();
        let log = play(&mut world, &mut planner, &mut numbering, 300);
        assert_bounded(&planner, 32, log.total_steps());
        let value = planner.value(numbering.id(0)).unwrap();
        assert!((value - 0.5).abs() < 1e-3, "seed {seed}: {value}");
        // Twenty steps round the ring and one out.
        assert_eq!(log.final_mean(20), 21.0, "seed {seed}");
    }
}
