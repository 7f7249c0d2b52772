//! Steps among known states allocate nothing.

use eigentrail::agent::{
    Agent, AgentKind, AgentParams, AnyAgent, Bootstrap, Experience, FeatureKind, Situation,
};
use eigentrail::env::StepStatus;
use eigentrail::graph::StateId;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

/// The system's allocator, counting what the present thread asks for.
struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

// SAFETY: hands everything on to the system's allocator; the counter is a plain cell of the thread.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.with(|count| count.set(count.get() + 1));
        // SAFETY: as the caller vouches.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as the caller vouches.
        unsafe { System.dealloc(pointer, layout) }
    }
}

/// Goes round ten states `steps` times; how many allocations that took.
fn allocations(agent: &mut AnyAgent, steps: u32) -> u64 {
    let advice = [0.0, 0.1, 0.2];
    let before = ALLOCATIONS.get();
    for step in 0..steps {
        let state = StateId(step % 10);
        let action = agent.select_action(Situation {
            state,
            advice: &advice,
        });
        let next = Situation {
            state: StateId((step + 1) % 10),
            advice: &advice,
        };
        let status = if step % 25 == 24 {
            StepStatus::Terminated
        } else {
            StepStatus::Running
        };
        agent.update(&Experience {
            state,
            action,
            reward: -1.0,
            shaping: 0.5,
            next,
            status,
        });
    }
    ALLOCATIONS.get() - before
}

#[test]
fn steps_among_known_states_allocate_nothing() {
    use AgentKind::{ActorCritic, QLearning, Random, Sarsa};
    use Bootstrap::{Expected, Sampled};
    use FeatureKind::{Pvf, Tabular};
    for (kind, features, bootstrap) in [
        (ActorCritic, Tabular, Sampled),
        (ActorCritic, Tabular, Expected),
        (ActorCritic, Pvf, Sampled),
        (ActorCritic, Pvf, Expected),
        (QLearning, Tabular, Sampled),
        (Sarsa, Tabular, Sampled),
        (Sarsa, Tabular, Expected),
        (Random, Tabular, Sampled),
    ] {
        let params = AgentParams {
            kind,
            features,
            bootstrap: Some(bootstrap),
            ..AgentParams::default()
        };
        let mut agent = AnyAgent::new(&params, 3, 1.0, 0);
        let made = allocations(&mut agent, 10);
        assert!(
            made > 0 || kind == Random,
            "{kind:?}: tables are made of something"
        );
        agent.set_features(faer::Mat::from_fn(8, 4, |i, j| (i * j) as f64 + 1.0).as_ref());
        assert_eq!(
            allocations(&mut agent, 1000),
            0,
            "{kind:?} {features:?} {bootstrap:?}"
        );
    }
}
