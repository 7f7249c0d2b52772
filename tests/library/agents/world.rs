//! A finite world small enough to solve, and the loop that lets an agent loose in it.

use eigentrail::agent::{Agent, Experience, Situation};
use eigentrail::env::{Action, Environment, Step, StepStatus};
use eigentrail::graph::StateId;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::collections::HashMap;

/// One way a (state, action) can end.
#[derive(Clone, Copy)]
pub struct Outcome {
    pub probability: f64,
    pub next: usize,
    pub reward: f64,
}

/// Any finite MDP: `outcomes[state][action]`, goals that end the episode, one start state, a step limit.
#[derive(Clone)]
pub struct World {
    pub outcomes: Vec<Vec<Vec<Outcome>>>,
    pub goals: Vec<usize>,
    pub start: usize,
    pub max_steps: usize,
    rng: ChaCha8Rng,
    at: usize,
    steps: usize,
}

impl World {
    pub fn new(outcomes: Vec<Vec<Vec<Outcome>>>, goals: Vec<usize>, seed: u64) -> Self {
        let max_steps = 10 * outcomes.len();
        let rng = eigentrail::seeds::stream(seed, eigentrail::seeds::Stream::Environment);
        World {
            outcomes,
            goals,
            start: 0,
            max_steps,
            rng,
            at: 0,
            steps: 0,
        }
    }

    /// A grid with four actions and bumping in place, −1 a step, from corner to corner. With probability `slip` the
    /// move goes in a random direction.
    pub fn grid(rows: usize, cols: usize, slip: f64, seed: u64) -> Self {
        let next = |cell: usize, action: usize| {
            let (row, col) = (cell / cols, cell % cols);
            match action {
                0 if row > 0 => cell - cols,
                1 if col + 1 < cols => cell + 1,
                2 if row + 1 < rows => cell + cols,
                3 if col > 0 => cell - 1,
                _ => cell,
            }
        };
        let outcome = |cell, action, way| Outcome {
            probability: slip / 4.0 + if way == action { 1.0 - slip } else { 0.0 },
            next: next(cell, way),
            reward: -1.0,
        };
        let of_action = |cell, action| {
            (0..4)
                .map(|way| outcome(cell, action, way))
                .filter(|o| o.probability > 0.0)
                .collect()
        };
        let outcomes = (0..rows * cols)
            .map(|cell| (0..4).map(|action| of_action(cell, action)).collect())
            .collect();
        World::new(outcomes, vec![rows * cols - 1], seed)
    }

    /// `length` states in a row; action 0 goes back to the start, action 1 one on; −1 a step.
    pub fn chain(length: usize, seed: u64) -> Self {
        let certain = |next| {
            vec![Outcome {
                probability: 1.0,
                next,
                reward: -1.0,
            }]
        };
        let outcomes = (0..length)
            .map(|s| vec![certain(0), certain((s + 1).min(length - 1))])
            .collect();
        World::new(outcomes, vec![length - 1], seed)
    }

    pub fn num_states(&self) -> usize {
        self.outcomes.len()
    }

    /// Optimal Q by value iteration, to 1e-12.
    pub fn optimal_values(&self, gamma: f64) -> Vec<Vec<f64>> {
        let mut q: Vec<Vec<f64>> = self
            .outcomes
            .iter()
            .map(|actions| vec![0.0; actions.len()])
            .collect();
        loop {
            let mut change = 0f64;
            for s in (0..self.num_states()).filter(|s| !self.goals.contains(s)) {
                for a in 0..q[s].len() {
                    let best = |next: usize| {
                        if self.goals.contains(&next) {
                            0.0
                        } else {
                            max(&q[next])
                        }
                    };
                    let value = self.outcomes[s][a]
                        .iter()
                        .map(|o| o.probability * (o.reward + gamma * best(o.next)))
                        .sum();
                    change = change.max(f64::abs(q[s][a] - value));
                    q[s][a] = value;
                }
            }
            if change < 1e-12 {
                return q;
            }
        }
    }

    /// Optimal (expected) number of steps from the start where each costs 1.
    pub fn optimal_steps(&self) -> f64 {
        -max(&self.optimal_values(1.0)[self.start])
    }
}

pub fn max(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

impl Environment for World {
    type State = usize;

    fn num_actions(&self) -> usize {
        self.outcomes[0].len()
    }

    fn reset(&mut self) -> usize {
        (self.at, self.steps) = (self.start, 0);
        self.at
    }

    fn step(&mut self, action: Action) -> Step<usize> {
        let outcomes = &self.outcomes[self.at][action.index()];
        let outcome = match outcomes.len() {
            1 => outcomes[0],
            _ => {
                let mut left = self.rng.random::<f64>();
                *outcomes
                    .iter()
                    .find(|o| {
                        left -= o.probability;
                        left < 0.0
                    })
                    .unwrap_or(&outcomes[0])
            }
        };
        (self.at, self.steps) = (outcome.next, self.steps + 1);
        let status = if self.goals.contains(&self.at) {
            StepStatus::Terminated
        } else if self.steps >= self.max_steps {
            StepStatus::Truncated
        } else {
            StepStatus::Running
        };
        Step {
            state: self.at,
            reward: outcome.reward,
            status,
        }
    }
}

/// Numbers states in order of discovery, as the engine does.
#[derive(Clone, Default)]
pub struct Numbering(HashMap<usize, u32>);

impl Numbering {
    pub fn id(&mut self, state: usize) -> StateId {
        let next = self.0.len() as u32;
        StateId(*self.0.entry(state).or_insert(next))
    }
}

/// What came of the steps: per episode its length, and the actions taken in order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Log {
    pub lengths: Vec<usize>,
    pub actions: Vec<Action>,
}

impl Log {
    pub fn total_steps(&self) -> usize {
        self.lengths.iter().sum()
    }

    /// Mean length of the last `count` episodes.
    pub fn final_mean(&self, count: usize) -> f64 {
        let last = &self.lengths[self.lengths.len() - count..];
        last.iter().sum::<usize>() as f64 / count as f64
    }
}

/// Plays `episodes` without shaping and advice.
pub fn play(
    world: &mut World,
    agent: &mut impl Agent,
    numbering: &mut Numbering,
    episodes: usize,
) -> Log {
    let advice = vec![0.0; world.num_actions()];
    let mut log = Log::default();
    for _ in 0..episodes {
        let mut state = numbering.id(world.reset());
        for length in 1.. {
            let action = agent.select_action(Situation {
                state,
                advice: &advice,
            });
            let step = world.step(action);
            let next = Situation {
                state: numbering.id(step.state),
                advice: &advice,
            };
            agent.update(&Experience {
                state,
                action,
                reward: step.reward,
                shaping: 0.0,
                next,
                status: step.status,
            });
            log.actions.push(action);
            state = next.state;
            if step.status.is_last() {
                log.lengths.push(length);
                break;
            }
        }
    }
    log
}
