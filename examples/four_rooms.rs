//! The whole loop through the library: four rooms, from the first step to a policy that goes straight to the goal.
//!
//! Run it with `cargo run --release --example four_rooms`.

use eigentrail::agent::{AgentParams, build_agent};
use eigentrail::engine::{Engine, PipelineParams, ShapingPipeline};
use eigentrail::env::{Doors, Environment, GridWorld, GridWorldParams, Landmark, Layout, Model};
use eigentrail::report::{Charset, draw_values};
use eigentrail::seeds::{Stream, stream};
use eigentrail::shaping::Potential;
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let seed = 0;
    let layout = Layout::rooms(
        2,
        2,
        [5, 5],
        Doors::Center,
        &mut stream(seed, Stream::Layout),
    )?
    .with_start(Landmark::TopLeft)?
    .with_goal(Landmark::BottomRight, None)?;
    let rng = stream(seed, Stream::Environment);
    let world = GridWorld::new(layout.clone(), GridWorldParams::default(), rng)?;
    let optimum = world.optimum();

    let own = AgentParams::default();
    let agent = build_agent(&own, world.num_actions(), 1.0, seed);
    let params = PipelineParams {
        gamma: own.gamma,
        ..Default::default()
    };
    let pipeline = ShapingPipeline::new(&params, world.num_actions(), None, seed)?;
    let mut engine = Engine::new(world, pipeline, agent);

    let mut regret = 0.0;
    for episode in 0..200 {
        let record = engine.run_episode(|_, _| ())?;
        regret += optimum.expected_return - record.plain_return;
        if episode < 5 || episode % 50 == 49 {
            println!(
                "episode {episode:>3}: {:>4} steps, {:>3} states known, regret {regret:>5.0}",
                record.length, record.nodes
            );
        }
    }
    println!(
        "the shortest way takes {} steps; φ:",
        optimum.expected_steps
    );
    let pipeline = engine.pipeline();
    let phi = |cell| Some(pipeline.potential().value(pipeline.graph().id(&cell)?));
    print!("{}", draw_values(&layout, phi, Charset::Blocks));
    Ok(())
}
