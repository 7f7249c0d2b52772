//! Whole runs: what is learnt, and that it repeats.

use super::world::{Numbering, Outcome, World, play};
use eigentrail::agent::{
    Agent, AgentKind, AgentParams, AnyAgent, Bootstrap, Experience, QLearning, QLearningParams,
    Situation, Untried, UpdateRule,
};
use eigentrail::env::{Action, StepStatus};
use eigentrail::graph::StateId;
use eigentrail::seeds::{Stream, stream};
use rand::RngExt;

const KINDS: [AgentKind; 12] = [
    AgentKind::ActorCritic,
    AgentKind::ReplayActorCritic,
    AgentKind::QLearning,
    AgentKind::Sarsa,
    AgentKind::DynaQ,
    AgentKind::DynaQPlus,
    AgentKind::Planner,
    AgentKind::PolicyIteration,
    AgentKind::MbieEb,
    AgentKind::Ucbvi,
    AgentKind::Psrl,
    AgentKind::Random,
];

fn agent(params: &AgentParams, world: &World, seed: u64) -> AnyAgent {
    params.validate().unwrap();
    AnyAgent::new(params, world.outcomes[0].len(), 1.0, seed)
}

/// Follows the greedy policy from the start; the number of steps to a goal, if it gets there.
fn greedy_path(world: &World, agent: &AnyAgent, numbering: &mut Numbering) -> Option<usize> {
    let mut at = world.start;
    for step in 0..=world.num_states() {
        if world.goals.contains(&at) {
            return Some(step);
        }
        let action = agent.greedy_action(numbering.id(at), &vec![0.0; world.outcomes[at].len()])?;
        at = world.outcomes[at][action.index()][0].next;
    }
    None
}

/// Every learner ends on a shortest path of the 5×5 grid and of a chain that throws back to its start; what it still
/// loses to chance is at most a tenth.
#[test]
fn every_learner_reaches_the_optimum_of_a_grid_and_a_chain() {
    for world in [World::grid(5, 5, 0.0, 1), World::chain(6, 1)] {
        let optimal = world.optimal_steps();
        for kind in KINDS.into_iter().filter(|&kind| kind != AgentKind::Random) {
            for bootstrap in [Bootstrap::Sampled, Bootstrap::Expected] {
                let params = AgentParams {
                    kind,
                    bootstrap: Some(bootstrap),
                    untried: Some(Untried::Optimistic), // nobody advises it
                    ..AgentParams::default()
                };
                for seed in 0..3 {
                    let (mut world, mut numbering) = (world.clone(), Numbering::default());
                    let mut agent = agent(&params, &world, seed);
                    let log = play(&mut world, &mut agent, &mut numbering, 600);
                    let name = format!("{kind:?} {bootstrap:?} seed {seed}");
                    assert_eq!(
                        greedy_path(&world, &agent, &mut numbering),
                        Some(optimal as usize),
                        "{name}"
                    );
                    // The chain throws back to its start: a slip of chance costs up to its whole length.
                    let allowance = if world.goals == [5] { 1.25 } else { 1.1 };
                    let ratio = log.final_mean(100) / optimal;
                    assert!(ratio <= allowance, "{name}: {ratio} of optimal");
                }
            }
        }
    }
}

/// The paper's own algorithms learn slowly with the paper's own step sizes, but they do learn.
#[test]
fn printed_algorithms_improve_on_chance() {
    let world = World::grid(5, 5, 0.0, 1);
    let final_mean = |params: AgentParams| {
        let mut agent = agent(&params, &world, 1);
        play(
            &mut world.clone(),
            &mut agent,
            &mut Numbering::default(),
            2000,
        )
        .final_mean(400)
    };
    let by_chance = final_mean(AgentParams {
        kind: AgentKind::Random,
        ..AgentParams::default()
    });
    for update in [UpdateRule::Algorithm1, UpdateRule::Algorithm2] {
        let learnt = final_mean(AgentParams {
            update,
            ..AgentParams::default()
        });
        assert!(
            learnt < 0.8 * by_chance,
            "{update:?}: {learnt} against {by_chance} by chance"
        );
    }
}

/// A random deterministic world in which each action leads anywhere and costs anything.
fn random_world(states: usize, actions: usize, seed: u64) -> World {
    let mut rng = stream(seed, Stream::Layout);
    let mut outcome = || Outcome {
        probability: 1.0,
        next: rng.random_range(0..states),
        reward: rng.random_range(-2.0..1.0),
    };
    let outcomes = (0..states)
        .map(|_| (0..actions).map(|_| vec![outcome()]).collect())
        .collect();
    World::new(outcomes, vec![states - 1], seed)
}

/// With α = 1 and exploring starts, Q-learning in a deterministic world is value iteration in random order.
#[test]
fn q_learning_converges_to_value_iteration() {
    const GAMMA: f64 = 0.9;
    for seed in 0..20 {
        let world = random_world(7, 3, seed);
        let expected = world.optimal_values(GAMMA);
        let params = QLearningParams {
            gamma: GAMMA,
            ..QLearningParams::default()
        };
        let mut agent = QLearning::new(params, 3, 1.0, seed);
        let mut rng = stream(seed, Stream::Environment);
        for _ in 0..20_000 {
            let (s, a) = (rng.random_range(0..6usize), rng.random_range(0..3usize));
            let outcome = world.outcomes[s][a][0];
            let status = if world.goals.contains(&outcome.next) {
                StepStatus::Terminated
            } else {
                StepStatus::Running
            };
            agent.update(&Experience {
                state: StateId(s as u32),
                action: Action(a as u16),
                reward: outcome.reward,
                shaping: 0.0,
                next: Situation {
                    state: StateId(outcome.next as u32),
                    advice: &[0.0; 3],
                },
                status,
            });
        }
        for (s, row) in expected.iter().enumerate().take(6) {
            for (a, expected) in row.iter().enumerate() {
                let learnt = agent.action_value(StateId(s as u32), Action(a as u16));
                assert!(
                    (learnt - expected).abs() < 1e-9,
                    "seed {seed}, ({s}, {a}): {learnt} instead of {expected}"
                );
            }
        }
    }
}

#[test]
fn equal_seeds_act_equally_and_different_seeds_do_not() {
    for kind in KINDS {
        let params = AgentParams {
            kind,
            ..AgentParams::default()
        };
        let run = |seed| {
            let mut world = World::grid(5, 5, 0.2, 3);
            let mut agent = agent(&params, &world, seed);
            play(&mut world, &mut agent, &mut Numbering::default(), 20)
        };
        assert_eq!(run(1), run(1), "{kind:?}");
        assert_ne!(run(1).actions, run(2).actions, "{kind:?}");
    }
}

/// Written down in the middle of a run and read back, an agent goes on as the original does.
#[test]
fn a_written_agent_continues_where_it_was() {
    let variants = KINDS.map(|kind| AgentParams {
        kind,
        ..AgentParams::default()
    });
    let sampled = AgentParams {
        bootstrap: Some(Bootstrap::Sampled),
        ..AgentParams::default()
    };
    let features = AgentParams {
        features: eigentrail::agent::FeatureKind::Pvf,
        ..AgentParams::default()
    };
    for params in variants.into_iter().chain([sampled, features]) {
        let mut world = World::grid(5, 5, 0.2, 3);
        let mut numbering = Numbering::default();
        let mut agent = agent(&params, &world, 4);
        play(&mut world, &mut agent, &mut numbering, 7);
        let written = serde_json::to_value(&agent).unwrap();
        let mut read: AnyAgent = serde_json::from_value(written).unwrap();
        let rest = play(&mut world.clone(), &mut agent, &mut numbering.clone(), 7);
        assert_eq!(
            rest,
            play(&mut world, &mut read, &mut numbering, 7),
            "{:?}",
            params.kind
        );
    }
}

/// An agent may be handed states and actions it did not choose, and state numbers with gaps.
#[test]
fn foreign_steps_are_learnt_from() {
    for kind in KINDS {
        let params = AgentParams {
            kind,
            ..AgentParams::default()
        };
        let mut agent = AnyAgent::new(&params, 2, 1.0, 0);
        for _ in 0..50 {
            for (action, reward) in [(0, -1.0), (1, 2.0)] {
                agent.update(&Experience {
                    state: StateId(40),
                    action: Action(action),
                    reward,
                    shaping: 0.0,
                    next: Situation {
                        state: StateId(90),
                        advice: &[0.0; 2],
                    },
                    status: StepStatus::Terminated,
                });
            }
        }
        let expected = (kind != AgentKind::Random).then_some(Action(1));
        assert_eq!(
            agent.greedy_action(StateId(40), &[0.0; 2]),
            expected,
            "{kind:?}"
        );
        if kind != AgentKind::ActorCritic {
            assert_eq!(
                agent.greedy_action(StateId(4000), &[0.0; 2]),
                None,
                "{kind:?}"
            );
        }
    }
}

/// Advice leads the way and leaves no trace: the values stay what they are.
#[test]
fn advice_decides_between_actions_of_equal_worth() {
    for kind in [
        AgentKind::ActorCritic,
        AgentKind::ReplayActorCritic,
        AgentKind::QLearning,
        AgentKind::Sarsa,
        AgentKind::DynaQ,
        AgentKind::PolicyIteration,
    ] {
        let params = AgentParams {
            kind,
            epsilon: Some(0.0),
            ..AgentParams::default()
        };
        let mut agent = AnyAgent::new(&params, 3, 1.0, 0);
        let followed = (0..100u32)
            .filter(|&s| {
                agent.select_action(Situation {
                    state: StateId(s),
                    advice: &[0.0, 0.0, 9.0],
                }) == Action(2)
            })
            .count();
        assert!(followed >= 98, "{kind:?} followed {followed} of 100 times");
    }
}
