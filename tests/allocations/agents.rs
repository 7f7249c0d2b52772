//! Steps among known states allocate nothing.

use eigentrail::agent::{
    Agent, AgentKind, AgentParams, AnyAgent, Bootstrap, Experience, FeatureKind, Situation,
};
use eigentrail::env::StepStatus;
use eigentrail::graph::StateId;
use eigentrail_testing::allocations::allocations as so_far;

/// Goes round ten states `steps` times; how many allocations that took.
fn allocations(agent: &mut AnyAgent, steps: u32) -> u64 {
    let advice = [0.0, 0.1, 0.2];
    let before = so_far();
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
    so_far() - before
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
