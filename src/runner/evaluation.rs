//! Exact evaluation of a policy that was learnt: what it earns in the true world, not what it happened to earn.
//!
//! The greedy policy takes the likeliest action in every state that the agent knows ([`Agent::greedy_action`]), and the first
//! one where it knows nothing, for there all are equal and the first of equals counts. An episode of it has the expected return
//! [`TabularMdp::policy_return`](crate::env::TabularMdp::policy_return).

use crate::agent::Agent;
use crate::engine::Engine;
use crate::env::{Action, Model};
use crate::graph::StateId;

/// Windows of a continuing task before the one that counts: where it began no longer matters then.
const WINDOWS: usize = 10;

/// Expected returns of an episode of the greedy policy; none if the agent prefers no action in any state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct GreedyReturns {
    /// With the advice of φ, as the agent acts once nothing is left to search.
    pub advised: Option<f64>,
    /// By what the agent has learnt alone.
    pub unadvised: Option<f64>,
}

impl GreedyReturns {
    /// Those of the agent of `engine` in its present world. O(states × actions), and an episode's worth of steps in all the
    /// states that the policies may come to.
    pub(super) fn of<E: Model, A: Agent>(engine: &Engine<E, A>) -> Self {
        let world = engine.env();
        let mdp = world.to_mdp();
        let (starts, max_steps) = (world.start_states(), world.max_steps());
        let earned = |policy: Vec<Action>| match world.optimal_gain() {
            None => mdp.policy_return(&starts, max_steps, &policy),
            Some(_) => {
                let until = |windows| mdp.policy_return(&starts, windows * max_steps, &policy);
                until(WINDOWS + 1) - until(WINDOWS)
            }
        };
        let look_ahead = engine.pipeline().look_ahead();
        let no_advice = vec![0.0; look_ahead.len()];
        let policy = |advice: &[f64]| greedy_policy(engine, mdp.num_states(), advice);
        Self {
            advised: policy(&look_ahead).map(earned),
            unadvised: policy(&no_advice).map(earned),
        }
    }
}

/// The greedy action in each of the `states` of the true world under `advice`, one row of numbers a known state; none if there
/// is no state in which the agent prefers any.
fn greedy_policy<E: Model, A: Agent>(
    engine: &Engine<E, A>,
    states: usize,
    advice: &[f64],
) -> Option<Vec<Action>> {
    let (world, graph) = (engine.env(), engine.pipeline().graph());
    let mut policy = vec![Action(0); states];
    let mut prefers = false;
    let rows = advice.chunks_exact(world.num_actions());
    for (state, advice) in (0..graph.num_states() as u32).map(StateId).zip(rows) {
        if let Some(action) = engine.agent().greedy_action(state, advice) {
            policy[world.mdp_index(graph.state(state))] = action;
            prefers = true;
        }
    }
    prefers.then_some(policy)
}
