//! The default agent, with all that it has on by default, ends on the best policy, whatever φ says.
//!
//! Small random worlds: ends that pay and ends that cost, loops that pay, actions that go nowhere, slips, steps of different costs.
//! Value iteration for policies without a clock, written here, is the judge. It is the right one: either γ < 1, so that what lies
//! beyond the step limit of an episode is worth nothing, or all is cost and every state has a way to an end, so that good policies
//! end long before the limit.

use eigentrail::agent::{Agent, AgentParams, build_agent};
use eigentrail::engine::{Engine, PipelineParams, ShapingPipeline};
use eigentrail::env::{MdpState, Outcome, TabularEnvironment, TabularMdp};
use eigentrail::graph::StateId;
use eigentrail::shaping::{PotentialKind, ShapingParams};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Worlds of each kind; every one of them with every potential. Where slips are frequent a life may be unlucky: of some hundred such lives one
/// or two have seen an action fail so often that it takes millions of steps to make up for it. There is none among these.
const WORLDS: u64 = 12;
const STEPS: usize = 400_000;
const MAX_STEPS: usize = 100;
/// What a policy may lack of the best, in sizes of the largest value of a state.
const TOLERANCE: f64 = 0.02;

/// A world that begins in state 0; the states from `ends` on are ends.
struct World {
    gamma: f64,
    outcomes: Vec<Vec<Vec<Outcome>>>,
    ends: usize,
}

/// What is earned and what it costs.
#[derive(Clone, Copy, Debug)]
enum Kind {
    /// γ = 0.9, and anything may pay.
    Discounted,
    /// γ = 1, and everything costs.
    Costs,
}

impl World {
    fn random(kind: Kind, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (states, ends) = (rng.random_range(5..9_usize), rng.random_range(1..4_usize));
        let num_actions = rng.random_range(2..4_usize);
        let payoffs: &[f64] = match kind {
            Kind::Discounted => &[-10.0, -1.0, 0.0, 5.0, 10.0],
            Kind::Costs => &[-10.0, -3.0, -1.0, -0.2],
        };
        let payoffs: Vec<f64> = (0..ends)
            .map(|_| payoffs[rng.random_range(0..payoffs.len())])
            .collect();
        let slip = [0.0, 0.0, 0.1, 0.3][rng.random_range(0..4_usize)];
        let mut outcomes = Vec::new();
        for state in 0..states {
            let mut actions = Vec::new();
            for action in 0..num_actions {
                let step = match kind {
                    Kind::Discounted => rng.random_range(-1.0..0.5),
                    Kind::Costs => -[0.2, 1.0, 1.0, 3.0][rng.random_range(0..4_usize)],
                };
                let next = match rng.random_range(0..8_u32) {
                    // So that every state has a way to an end; the others go anywhere.
                    _ if action == 0 => state + 1,
                    0 => state,
                    1 => states + rng.random_range(0..ends),
                    _ => rng.random_range(0..states),
                };
                let slipped = rng.random_range(0..states + ends);
                let to = |next: usize, probability| Outcome {
                    next: next as u32,
                    probability,
                    reward: next.checked_sub(states).map_or(step, |end| payoffs[end]),
                };
                actions.push(vec![to(next, 1.0 - slip), to(slipped, slip)]);
            }
            // The way to the end is another action in each state.
            actions.rotate_right(rng.random_range(0..num_actions));
            outcomes.push(actions);
        }
        outcomes.resize(states + ends, Vec::new());
        Self {
            gamma: match kind {
                Kind::Discounted => 0.9,
                Kind::Costs => 1.0,
            },
            outcomes,
            ends: states,
        }
    }

    fn action_value(&self, values: &[f64], outcomes: &[Outcome]) -> f64 {
        let ahead = |o: &Outcome| o.reward + self.gamma * values[o.next as usize];
        outcomes.iter().map(|o| o.probability * ahead(o)).sum()
    }

    /// The values that `choose` among the values of a state's actions makes; −∞ is not reached, but numbers beyond all tolerance are.
    fn values(&self, choose: impl Fn(usize, &[f64]) -> f64) -> Vec<f64> {
        let mut values = vec![0.0; self.outcomes.len()];
        for _ in 0..5000 {
            for state in 0..self.ends {
                let actions = self.outcomes[state].iter();
                let worth: Vec<f64> = actions.map(|o| self.action_value(&values, o)).collect();
                values[state] = choose(state, &worth);
            }
        }
        values
    }

    fn environment(&self, seed: u64) -> TabularEnvironment {
        let terminal = (0..self.outcomes.len()).map(|s| s >= self.ends).collect();
        let mdp = TabularMdp::new(&self.outcomes, terminal).unwrap();
        let rng = ChaCha8Rng::seed_from_u64(seed);
        TabularEnvironment::new(mdp, &[0], MAX_STEPS, rng).unwrap()
    }

    /// What the default agent's greedy policy lacks of the best one after a life with this potential, in sizes of the largest value.
    fn loss(&self, potential: PotentialKind, scale_factor: f64, seed: u64) -> f64 {
        let pipeline = PipelineParams {
            shaping: ShapingParams {
                potential,
                scale_factor,
                ..Default::default()
            },
            gamma: self.gamma,
            ..Default::default()
        };
        let agent = AgentParams {
            gamma: self.gamma,
            ..Default::default()
        };
        let num_actions = self.outcomes[0].len();
        let agent = build_agent(&agent, num_actions, pipeline.shaping.mix, seed);
        let pipeline = ShapingPipeline::new(&pipeline, num_actions, None, seed).unwrap();
        let world = self.environment(seed);
        let distances = world.mdp().distances_to_terminal();
        let told = move |state: &MdpState| f64::from(distances[state.index()].unwrap_or(0));
        let mut engine = Engine::new(world, pipeline, agent).with_discovery_hook(Box::new(told));
        for _ in 0..STEPS {
            engine.step(|_, _| {}).unwrap();
        }

        let mut policy = vec![0; self.ends];
        let advice = engine.pipeline().look_ahead();
        for (id, advice) in advice.chunks_exact(num_actions).enumerate() {
            let id = StateId(id as u32);
            let state = engine.pipeline().graph().state(id).index();
            if let (true, Some(action)) =
                (state < self.ends, engine.agent().greedy_action(id, advice))
            {
                policy[state] = action.index();
            }
        }
        let best = self.values(|_, worth| worth.iter().copied().fold(f64::NEG_INFINITY, f64::max));
        let earned = self.values(|state, worth| worth[policy[state]]);
        let scale = best
            .iter()
            .fold(0.0_f64, |most, value| most.max(value.abs()));
        (best[0] - earned[0]) / scale
    }
}

#[test]
fn the_default_agent_ends_on_the_best_policy_whatever_the_potential() {
    let potentials = [
        (
            "the network",
            PotentialKind::Gcn,
            ShapingParams::default().scale_factor,
        ),
        ("none", PotentialKind::None, 1.0),
        ("random", PotentialKind::Random, 5.0),
        ("hostile", PotentialKind::NegatedOracle, 5.0),
    ];
    let mut failures = Vec::new();
    for kind in [Kind::Discounted, Kind::Costs] {
        for seed in 0..WORLDS {
            let world = World::random(kind, seed);
            for (name, potential, scale_factor) in potentials {
                let loss = world.loss(potential, scale_factor, 1000 + seed);
                let is_close = loss <= TOLERANCE; // NaN is not
                if !is_close {
                    failures.push(format!("{kind:?} world {seed}, {name}: {loss:.3}"));
                }
            }
        }
    }
    assert!(failures.is_empty(), "{}: {failures:#?}", failures.len());
}
