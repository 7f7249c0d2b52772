//! Your own world and your own agent, with the pipeline in between: transitions in, shaped rewards out.
//!
//! The world is a corridor of 40 rooms with a chute from each back to the first; the agent is Q-learning in a dozen lines.
//! Run it with `cargo run --release --example custom_environment`.

use eigentrail::engine::{PipelineParams, ShapingPipeline};
use eigentrail::env::{Action, Step, StepStatus};
use eigentrail::exploration::{ExplorationKind, ExplorationParams};
use std::collections::HashMap;
use std::error::Error;

const LAST: u32 = 39;

/// Action 0 goes on, action 1 goes back, action 2 takes the chute to room 0.
fn step(room: u32, action: Action) -> Step<u32> {
    let state = match action.0 {
        0 => room + 1,
        1 => room.saturating_sub(1),
        _ => 0,
    };
    let status = match state {
        LAST => StepStatus::Terminated,
        _ => StepStatus::Running,
    };
    Step {
        state,
        reward: -1.0,
        status,
    }
}

/// Steps of each episode of a greedy Q-learner, with or without the shaped reward.
fn learn(shaped: bool, episodes: usize) -> Result<Vec<u32>, Box<dyn Error>> {
    let params = PipelineParams {
        gamma: 1.0,
        exploration: ExplorationParams {
            kind: ExplorationKind::None,
            ..Default::default()
        },
        ..Default::default()
    };
    let mut pipeline = ShapingPipeline::new(&params, 3, None, 0)?;
    let mut q: HashMap<(u32, u16), f64> = HashMap::new();
    let mut lengths = Vec::new();
    for _ in 0..episodes {
        let (mut room, mut length) = (0, 0);
        pipeline.begin_episode(&room);
        loop {
            let value =
                |q: &HashMap<_, _>, room, action| q.get(&(room, action)).copied().unwrap_or(0.0);
            let best = |q: &HashMap<_, _>, room| {
                let actions = (0..3).rev().map(|action| (value(q, room, action), action));
                actions.fold((f64::MIN, 0), |a, b| if b.0 >= a.0 { b } else { a })
            };
            let action = best(&q, room).1;
            let step = step(room, Action(action));
            let seen = pipeline.observe(Action(action), &step)?;

            let reward = step.reward + if shaped { seen.shaping } else { 0.0 };
            let ahead = match step.status {
                StepStatus::Terminated => 0.0,
                _ => best(&q, step.state).0,
            };
            let old = value(&q, room, action);
            q.insert((room, action), old + 0.5 * (reward + ahead - old));

            room = step.state;
            length += 1;
            if step.status.is_last() {
                break;
            }
        }
        lengths.push(length);
    }
    Ok(lengths)
}

fn main() -> Result<(), Box<dyn Error>> {
    for (name, shaped) in [("plain", false), ("shaped", true)] {
        let lengths = learn(shaped, 200)?;
        let total: u32 = lengths.iter().sum();
        println!(
            "{name:>6}: first episode {:>5} steps, last {:>3}, all {total:>6}",
            lengths[0], lengths[199]
        );
    }
    Ok(())
}
