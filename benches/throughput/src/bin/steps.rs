//! Steps a second of eigentrail's engine against rurel's tabular Q-learning, side by side in one run.
//!
//! `cargo run --release --locked --bin steps [-- STEPS [ROUNDS]]` in this folder; medians of the rounds, which take turns. rurel walks the open grid of
//! 21 × 21 at random, as its own example does, here from a corner to the opposite one at −1 a step.

use eigentrail::agent::{AgentKind, AgentParams, AnyAgent, build_agent};
use eigentrail::engine::{Engine, PipelineParams, ScheduleParams, ShapingPipeline};
use eigentrail::env::{Doors, GridWorld, GridWorldParams, Landmark, Layout};
use eigentrail::exploration::{ExplorationKind, ExplorationParams, Optimism};
use eigentrail::seeds::{Stream, stream};
use eigentrail::shaping::{PotentialKind, ShapingParams};
use rurel::AgentTrainer;
use rurel::mdp::{Agent, State};
use rurel::strategy::explore::RandomExploration;
use rurel::strategy::learn::QLearning;
use rurel::strategy::terminate::FixedIterations;
use std::time::Instant;

/// Width and height of the open grid.
const SIDE: i32 = 21;
/// Steps that no row counts: the world is found, tables have grown.
const WARM_UP: u64 = 200_000;

#[derive(Clone, PartialEq, Eq, Hash)]
struct Cell {
    x: i32,
    y: i32,
}

#[derive(Clone, PartialEq, Eq, Hash)]
struct Move {
    dx: i32,
    dy: i32,
}

impl State for Cell {
    type A = Move;

    fn reward(&self) -> f64 {
        if self.is_goal() { 0.0 } else { -1.0 }
    }

    fn actions(&self) -> Vec<Move> {
        let moves = [(0, -1), (0, 1), (-1, 0), (1, 0)];
        moves.map(|(dx, dy)| Move { dx, dy }).to_vec()
    }
}

impl Cell {
    fn is_goal(&self) -> bool {
        (self.x, self.y) == (SIDE - 1, SIDE - 1)
    }
}

struct Rurel {
    cell: Cell,
}

impl Agent<Cell> for Rurel {
    fn current_state(&self) -> &Cell {
        &self.cell
    }

    fn take_action(&mut self, action: &Move) {
        if self.cell.is_goal() {
            self.cell = Cell { x: 0, y: 0 };
        }
        self.cell.x = (self.cell.x + action.dx).clamp(0, SIDE - 1);
        self.cell.y = (self.cell.y + action.dy).clamp(0, SIDE - 1);
    }
}

/// Steps a second of rurel, its table filled before.
fn rurel(steps: u64) -> f64 {
    let mut trainer = AgentTrainer::new();
    let mut agent = Rurel {
        cell: Cell { x: 0, y: 0 },
    };
    let mut train = |steps: u64| {
        trainer.train(
            &mut agent,
            &QLearning::new(0.2, 0.99, 0.0),
            &mut FixedIterations::new(u32::try_from(steps).expect("fewer than 2^32 steps")),
            &RandomExploration::new(),
        );
    };
    train(WARM_UP);
    timed(steps, || {
        train(steps);
        steps
    })
}

fn timed(steps: u64, run: impl FnOnce() -> u64) -> f64 {
    let begun = Instant::now();
    let done = run();
    assert!(done >= steps);
    done as f64 / begun.elapsed().as_secs_f64()
}

/// The four worlds, from a corner to the opposite one.
#[derive(Clone, Copy)]
enum World {
    Open,
    FourRooms,
    Rooms,
}

impl World {
    fn name(self) -> &'static str {
        match self {
            World::Open => "open_21x21",
            World::FourRooms => "four_rooms",
            World::Rooms => "rooms_50x50",
        }
    }

    fn layout(self) -> Layout {
        let mut rng = stream(0, Stream::Layout);
        let map = match self {
            World::Open => Layout::open(SIDE as usize, SIDE as usize),
            World::FourRooms => Layout::rooms(2, 2, [5, 5], Doors::Center, &mut rng),
            World::Rooms => Layout::rooms(10, 10, [4, 4], Doors::Center, &mut rng),
        };
        map.and_then(|map| map.with_start(Landmark::TopLeft))
            .and_then(|map| map.with_goal(Landmark::BottomRight, None))
            .expect("the map is fine")
    }
}

/// What the engine is run with.
#[derive(Clone, Copy)]
enum Arm {
    /// Q-learning that walks at random, like rurel's; no φ.
    QLearning,
    /// One-step actor-critic, no φ.
    Sparse,
    /// The same, shaped by a φ and advice that stand.
    Frozen,
    /// The same, shaped and advised from the first step, with every refresh and fit.
    Live,
}

impl Arm {
    fn name(self) -> &'static str {
        match self {
            Arm::QLearning => "Q-learning, at random",
            Arm::Sparse => "actor-critic, sparse",
            Arm::Frozen => "actor-critic, φ frozen",
            Arm::Live => "actor-critic, live",
        }
    }

    fn agent(self) -> AgentParams {
        match self {
            Arm::QLearning => AgentParams {
                kind: AgentKind::QLearning,
                critic_learning_rate: Some(0.2),
                gamma: 0.99,
                epsilon: Some(1.0),
                ..Default::default()
            },
            Arm::Sparse | Arm::Frozen | Arm::Live => AgentParams {
                kind: AgentKind::ActorCritic,
                ..Default::default()
            },
        }
    }

    fn engine(self, world: World) -> Engine<GridWorld, AnyAgent> {
        let shaped = matches!(self, Arm::Frozen | Arm::Live);
        let exploration = match self {
            Arm::Live => ExplorationParams::default(),
            Arm::Frozen => ExplorationParams {
                optimism: Optimism::None,
                ..Default::default()
            },
            _ => ExplorationParams {
                kind: ExplorationKind::None,
                ..Default::default()
            },
        };
        let schedule = match self {
            Arm::Frozen => ScheduleParams {
                growth: 1.0,
                refit_share: 1e6,
                ..Default::default()
            },
            _ => ScheduleParams::default(),
        };
        let params = PipelineParams {
            shaping: ShapingParams {
                potential: match shaped {
                    true => PotentialKind::Gcn,
                    false => PotentialKind::None,
                },
                ..Default::default()
            },
            exploration,
            schedule,
            gamma: 1.0,
            ..Default::default()
        };
        let rng = stream(0, Stream::Environment);
        let grid = GridWorld::new(world.layout(), GridWorldParams::default(), rng);
        Engine::new(
            grid.expect("the map is fine"),
            ShapingPipeline::new(&params, 4, None, 0).expect("the parameters are valid"),
            build_agent(&self.agent(), 4, 1.0, 0),
        )
    }

    /// Steps a second.
    fn rate(self, world: World, steps: u64) -> f64 {
        let mut engine = self.engine(world);
        let run = |engine: &mut Engine<_, _>, steps: u64| {
            let end = engine.steps() + steps;
            while engine.steps() < end {
                engine.run_episode(|_, _| ()).expect("rewards are finite");
            }
        };
        if !matches!(self, Arm::Live) {
            run(&mut engine, WARM_UP);
        }
        let before = engine.steps();
        timed(steps, || {
            run(&mut engine, steps);
            engine.steps() - before
        })
    }
}

fn median(mut of: Vec<f64>) -> f64 {
    of.sort_by(f64::total_cmp);
    of[of.len() / 2]
}

fn main() {
    let mut numbers = std::env::args().skip(1);
    let mut number = |usual: u64| {
        numbers.next().map_or(usual, |text| {
            text.parse().expect("numbers of steps and of rounds")
        })
    };
    let (steps, rounds) = (number(10_000_000), number(5));
    let rows: Vec<(World, Arm)> = [World::Open, World::FourRooms, World::Rooms]
        .into_iter()
        .flat_map(|world| {
            [Arm::QLearning, Arm::Sparse, Arm::Frozen, Arm::Live].map(|arm| (world, arm))
        })
        .collect();
    let mut peer = Vec::new();
    let mut ours = vec![Vec::new(); rows.len()];
    for _ in 0..rounds {
        peer.push(rurel(steps));
        for (&(world, arm), rates) in rows.iter().zip(&mut ours) {
            rates.push(arm.rate(world, steps));
        }
    }
    let peer = median(peer);
    println!(
        "{steps} steps, medians of {rounds}; rurel, open_21x21: {:.2} M steps/s\n",
        peer / 1e6
    );
    println!("| world | learner | M steps/s (least to most) | ÷ rurel |\n|---|---|---|---|");
    for ((world, arm), rates) in rows.into_iter().zip(ours) {
        let (least, most) = (
            rates.iter().copied().fold(f64::INFINITY, f64::min),
            rates.iter().copied().fold(0.0, f64::max),
        );
        let rate = median(rates);
        println!(
            "| {} | {} | {:.2} ({:.2} to {:.2}) | {:.2} |",
            world.name(),
            arm.name(),
            rate / 1e6,
            least / 1e6,
            most / 1e6,
            rate / peer
        );
    }
}
