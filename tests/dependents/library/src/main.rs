//! What a user of the library with a world and an agent of their own writes.

use eigentrail::engine::{PipelineParams, ShapingPipeline};
use eigentrail::env::{Action, Step, StepStatus};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut pipeline = ShapingPipeline::new(&PipelineParams::default(), 1, None, 0)?;
    pipeline.begin_episode(&0);
    let step = |state, status| Step {
        state,
        reward: -1.0,
        status,
    };
    let first = pipeline.observe(Action(0), &step(1, StepStatus::Running))?;
    let last = pipeline.observe(Action(0), &step(2, StepStatus::Terminated))?;
    println!("{} then {}", first.shaping, last.shaping);
    Ok(())
}
