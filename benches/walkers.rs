//! Eight explorers on one model of the world against eight with a model each: `cargo bench --bench walkers`.
//!
//! Each explorer has its own copy of the world and its own learner, and all take turns, until one of them enters the
//! goal. Counted are the environment steps of all together, and the bytes that model and learners then hold. The world
//! is `rooms_50x50` of the scenarios: nine rooms of 16 × 16 with doors at random places. The same seeds for each row.

use eigentrail::agent::{Agent, AgentParams, AnyAgent, Experience, Situation, build_agent};
use eigentrail::engine::{PipelineParams, Walker, WorldModel};
use eigentrail::env::{Cell, Doors, Environment, GridWorld, Landmark, Layout};
use eigentrail::seeds::{Stream, stream};
use eigentrail_testing::allocations::{Counting, held_bytes};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

const SEEDS: u64 = 20;
const EXPLORERS: u32 = 8;

fn layout() -> Layout {
    Layout::rooms(
        3,
        3,
        [16, 16],
        Doors::Random,
        &mut stream(0, Stream::Layout),
    )
    .and_then(|map| map.with_start(Landmark::TopLeft))
    .and_then(|map| map.with_goal(Landmark::BottomRight, None))
    .expect("the map is fine")
}

/// One explorer: its world, its place, its learner.
struct Explorer {
    env: GridWorld,
    walker: Walker,
    agent: AnyAgent,
}

impl Explorer {
    fn new(layout: &Layout, world: &WorldModel<Cell>, number: u32, seed: u64) -> Self {
        let own_seed = seed * u64::from(EXPLORERS) + u64::from(number);
        let rng = stream(own_seed, Stream::Environment);
        let env = GridWorld::new(layout.clone(), Default::default(), rng);
        Self {
            env: env.expect("the map is fine"),
            walker: Walker::new(world, number),
            agent: build_agent(&AgentParams::default(), 4, 1.0, own_seed),
        }
    }

    /// One step; whether it entered the goal.
    fn step(&mut self, world: &mut WorldModel<Cell>) -> bool {
        if !self.walker.is_in_episode() {
            let start = self.env.reset();
            self.walker.begin_episode(world, &start);
        }
        let state = self.walker.state();
        let advice = self.walker.advice();
        let action = self.agent.select_action(Situation { state, advice });
        let step = self.env.step(action);
        let seen = self.walker.observe(world, action, &step);
        let seen = seen.expect("rewards are finite");
        self.agent.update(&Experience {
            state,
            action,
            reward: step.reward,
            shaping: seen.shaping,
            next: Situation {
                state: seen.state,
                advice: self.walker.advice(),
            },
            status: step.status,
        });
        seen.first_goal
    }
}

/// Steps until the first goal of any of `explorers` that share `models`, and bytes held then.
fn first_goal(layout: &Layout, explorers: u32, models: u32, seed: u64) -> (u64, isize) {
    let before = held_bytes();
    let params = PipelineParams::default();
    let mut worlds: Vec<WorldModel<Cell>> = (0..u64::from(models))
        .map(|m| WorldModel::new(&params, 4, None, seed * u64::from(models) + m))
        .collect::<Result<_, _>>()
        .expect("the parameters are valid");
    let place = |i: u32| (i % models) as usize;
    let mut all: Vec<Explorer> = (0..explorers)
        .map(|i| {
            Explorer::new(
                layout,
                &worlds[place(i)],
                i / models,
                seed * 8 + u64::from(i % models),
            )
        })
        .collect();
    for steps in 1.. {
        let i = ((steps - 1) % u64::from(explorers)) as u32;
        if all[i as usize].step(&mut worlds[place(i)]) {
            return (steps, held_bytes() - before);
        }
    }
    unreachable!("the steps are counted without end")
}

/// The middle one, the first and the last of sorted values.
fn spread(mut values: Vec<u64>) -> (u64, u64, u64) {
    values.sort_unstable();
    (
        values[values.len() / 2],
        values[0],
        values[values.len() - 1],
    )
}

fn main() {
    let layout = layout();
    println!(
        "{SEEDS} seeds; environment steps of all explorers until one enters the goal: median (least to most)"
    );
    for (name, explorers, models) in [
        ("one explorer", 1, 1),
        ("eight on one model", EXPLORERS, 1),
        ("eight on eight models", EXPLORERS, EXPLORERS),
    ] {
        let runs: Vec<_> = (0..SEEDS)
            .map(|seed| first_goal(&layout, explorers, models, seed))
            .collect();
        let (steps, least, most) = spread(runs.iter().map(|run| run.0).collect());
        let (bytes, ..) = spread(runs.iter().map(|run| run.1 as u64).collect());
        println!(
            "{name:>22}: {steps:6} ({least} to {most}), {:6.2} MB held",
            bytes as f64 / 1e6
        );
    }
}
