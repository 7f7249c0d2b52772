//! A step among known states, without a refresh, allocates nothing: neither the pipeline nor the agent.

use crate::env_worlds::grid_world;
use eigentrail::agent::{Agent, AgentParams, Experience, Situation, build_agent};
use eigentrail::engine::{PipelineParams, ScheduleParams, ShapingPipeline};
use eigentrail::env::{Environment, GridWorldParams, Landmark, Layout, StepStatus};
use eigentrail::exploration::{ExplorationKind, ExplorationParams};
use eigentrail_testing::allocations::allocations;

/// Allocations of the steps that met nothing new, how many such steps there were, and allocations of the others.
fn count(kind: ExplorationKind, episodes: usize) -> (u64, u64, u64) {
    let layout = Layout::open(9, 9)
        .and_then(|map| map.with_start(Landmark::TopLeft))
        .and_then(|map| map.with_goal(Landmark::BottomRight, None))
        .unwrap();
    let mut world = grid_world(&layout, &GridWorldParams::default(), 0);
    let params = PipelineParams {
        exploration: ExplorationParams {
            kind,
            ..Default::default()
        },
        schedule: ScheduleParams::default(),
        gamma: 1.0,
        ..Default::default()
    };
    let mut pipeline = ShapingPipeline::new(&params, 4, None, 0).unwrap();
    let mut agent = build_agent(&AgentParams::default(), 4, 1.0, 0);
    let (mut steady, mut steps, mut other) = (0, 0, 0);
    for episode in 0..episodes {
        let mut state = pipeline.begin_episode(&world.reset());
        loop {
            let known = pipeline.transitions().num_transitions();
            let before = allocations();
            let action = agent.select_action(Situation {
                state,
                advice: pipeline.advice(),
            });
            let step = world.step(action);
            let seen = pipeline.observe(action, &step).unwrap();
            agent.update(&Experience {
                state,
                action,
                reward: step.reward,
                shaping: seen.shaping,
                next: Situation {
                    state: seen.state,
                    advice: pipeline.advice(),
                },
                status: step.status,
            });
            let made = allocations() - before;
            let is_steady =
                seen.refresh.is_none() && pipeline.transitions().num_transitions() == known;
            if is_steady && episode >= episodes / 2 {
                steady += made;
                steps += 1;
            } else {
                other += made;
            }
            state = seen.state;
            if step.status != StepStatus::Running {
                break;
            }
        }
    }
    (steady, steps, other)
}

#[test]
fn steady_steps_allocate_nothing() {
    for kind in [
        ExplorationKind::None,
        ExplorationKind::CountBonus,
        ExplorationKind::Frontier,
    ] {
        let (steady, steps, other) = count(kind, 60);
        assert!(other > 100, "{kind:?}: refreshes and growth do allocate");
        assert!(steps > 200, "{kind:?}: {steps} steady steps");
        assert_eq!(steady, 0, "{kind:?}: allocations in {steps} steady steps");
    }
}
