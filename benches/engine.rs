//! The whole loop: `cargo bench --bench engine`. Throughput is environment steps a second.
//!
//! - `off`: no potential, no exploration: environment, graph and agent.
//! - `frozen`: φ and advice stand, nothing is refreshed: what a step costs once the world is known.
//! - `live`: the first episodes of a run, with every refresh and fit that the schedule asks for.
//!
//! `off` and `frozen` time episodes of an engine that has run for a while; `live` begins anew each time.

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use eigentrail::agent::{AgentParams, AnyAgent, build_agent};
use eigentrail::engine::{Engine, PipelineParams, ScheduleParams, ShapingPipeline};
use eigentrail::env::{Doors, GridWorld, GridWorldParams, Landmark, Layout};
use eigentrail::exploration::{ExplorationKind, ExplorationParams, Optimism};
use eigentrail::seeds::{Stream, stream};
use eigentrail::shaping::{PotentialKind, ShapingParams};
use std::hint::black_box;
use std::time::{Duration, Instant};

/// Episodes of a `live` run.
const EPISODES: usize = 10;

fn worlds() -> [(&'static str, Layout); 2] {
    let open = Layout::open(15, 15);
    // 50 × 50 cells: 10 × 10 rooms.
    let rooms = Layout::rooms(
        10,
        10,
        [4, 4],
        Doors::Center,
        &mut stream(0, Stream::Layout),
    );
    [("open_15x15", open), ("rooms_50x50", rooms)].map(|(name, layout)| {
        let layout = layout
            .and_then(|map| map.with_start(Landmark::TopLeft))
            .and_then(|map| map.with_goal(Landmark::BottomRight, None));
        (name, layout.expect("the map is fine"))
    })
}

fn engine(
    layout: &Layout,
    potential: PotentialKind,
    exploration: ExplorationParams,
    schedule: ScheduleParams,
) -> Engine<GridWorld, AnyAgent> {
    let rng = stream(0, Stream::Environment);
    let world = GridWorld::new(layout.clone(), GridWorldParams::default(), rng);
    let params = PipelineParams {
        shaping: ShapingParams {
            potential,
            ..Default::default()
        },
        exploration,
        schedule,
        gamma: 1.0,
        ..Default::default()
    };
    Engine::new(
        world.expect("the map is fine"),
        ShapingPipeline::new(&params, 4, None, 0).expect("the parameters are valid"),
        build_agent(&AgentParams::default(), 4, 1.0, 0),
    )
}

fn run(engine: &mut Engine<GridWorld, AnyAgent>, episodes: usize) -> u64 {
    let before = engine.steps();
    for _ in 0..episodes {
        black_box(engine.run_episode(|_, _| ()).expect("rewards are finite"));
    }
    engine.steps() - before
}

fn off() -> ExplorationParams {
    ExplorationParams {
        kind: ExplorationKind::None,
        ..Default::default()
    }
}

/// Looks for nothing once it knows a goal: the graph stays as it is.
fn settled() -> ExplorationParams {
    ExplorationParams {
        optimism: Optimism::None,
        ..Default::default()
    }
}

/// One fit at the first goal, and hardly another one: a softmax policy goes on trying what was never tried.
fn fit_once() -> ScheduleParams {
    ScheduleParams {
        growth: 1.0,
        refit_share: 1e6,
        ..Default::default()
    }
}

fn steps(criterion: &mut Criterion) {
    for (name, layout) in worlds() {
        let mut group = criterion.benchmark_group(name);
        group.sample_size(10);
        group.throughput(Throughput::Elements(1));
        for (what, potential, exploration) in [
            ("off", PotentialKind::None, off()),
            ("frozen", PotentialKind::Gcn, settled()),
        ] {
            let mut engine = engine(&layout, potential, exploration, fit_once());
            run(&mut engine, 100);
            group.bench_function(what, |bench| {
                // Whole episodes, as many as make up the steps asked for; the time is scaled to those.
                bench.iter_custom(|wanted| {
                    let begun = Instant::now();
                    let mut done = 0;
                    while done < wanted {
                        done += run(&mut engine, 1);
                    }
                    let share = wanted as f64 / done as f64;
                    Duration::from_secs_f64(begun.elapsed().as_secs_f64() * share)
                });
            });
        }
        let live = || {
            let potential = PotentialKind::Gcn;
            engine(&layout, potential, Default::default(), Default::default())
        };
        group.throughput(Throughput::Elements(run(&mut live(), EPISODES)));
        group.bench_function("live", |bench| {
            bench.iter_batched(
                live,
                |mut engine| run(&mut engine, EPISODES),
                BatchSize::LargeInput,
            );
        });
        group.finish();
    }
}

criterion_group!(benches, steps);
criterion_main!(benches);
