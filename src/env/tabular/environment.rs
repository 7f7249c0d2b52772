//! Acting in a finite MDP: the next state is drawn from P.

use super::reward_noise::RewardNoise;
use super::{NoGain, Optimum, TabularMdp};
use crate::env::clock::EpisodeClock;
use crate::env::{Action, EnvError, Environment, Model, Starts, Step};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// The number of a state of a [`TabularMdp`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct MdpState(pub u32);

impl MdpState {
    /// The state as an array index.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// A life that no reset begins anew.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Life {
    /// What the best policy earns a step.
    gain: f64,
    has_begun: bool,
}

/// An episodic world over a [`TabularMdp`]. Copies share the MDP.
///
/// Actions with one outcome draw no random number, nor do resets with one start, nor rewards without noise.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct TabularEnvironment {
    mdp: Arc<TabularMdp>,
    starts: Starts<MdpState>,
    noise: RewardNoise,
    /// Of a task without ends.
    life: Option<Life>,
    clock: EpisodeClock,
    rng: ChaCha8Rng,
    state: MdpState,
}

impl TabularEnvironment {
    /// Episodes begin in one of `starts` and are truncated after `max_steps`.
    ///
    /// # Errors
    /// [`EnvError::BadStart`] if there is none, or one is terminal or no state; [`EnvError::NoSteps`].
    pub fn new(
        mdp: impl Into<Arc<TabularMdp>>,
        starts: impl Into<Starts>,
        max_steps: usize,
        rng: ChaCha8Rng,
    ) -> Result<Self, EnvError> {
        let (mdp, starts) = (mdp.into(), starts.into());
        let states = mdp.num_states();
        if max_steps == 0 {
            return Err(EnvError::NoSteps);
        }
        if starts.places().is_empty() {
            return Err(EnvError::BadStart {
                start: "nothing".to_owned(),
                states,
            });
        }
        if let Some(start) = starts
            .places()
            .iter()
            .find(|&&start| start >= states || mdp.is_terminal(start))
        {
            return Err(EnvError::BadStart {
                start: format!("state {start}"),
                states,
            });
        }
        let starts = starts.map(|&start| MdpState(start as u32));
        let state = starts.places()[0];
        Ok(TabularEnvironment {
            mdp,
            starts,
            noise: RewardNoise::default(),
            life: None,
            clock: EpisodeClock::new(max_steps),
            rng,
            state,
        })
    }

    /// Adds a normal number of mean 0 to the reward of each step; `deviations[s]` is its standard deviation for steps
    /// from s, 0 for none. The MDP keeps the means.
    ///
    /// # Panics
    /// If there is not one finite number of at least 0 for each state.
    pub fn with_reward_noise(mut self, deviations: &[f64]) -> Self {
        assert_eq!(
            deviations.len(),
            self.mdp.num_states(),
            "one deviation per state"
        );
        self.noise = RewardNoise::new(deviations);
        self
    }

    /// The same world as a continuing task: only the first reset draws a start, each further one hands back the state where
    /// the walker stands, so that an "episode" is a window of `max_steps` steps of one unbroken life. The best is then the
    /// optimal gain: [`Model::optimum`] is g* times `max_steps`, and what a run falls short of it is its average-reward
    /// regret. A window that begins well may earn more. Costs as much as [`TabularMdp::optimal_gain`].
    ///
    /// # Errors
    /// [`EnvError::ContinuingEnd`], [`EnvError::NoWayBack`], [`EnvError::GainUnsettled`]; `name` says how a state is called.
    pub fn continuing(mut self, name: impl Fn(usize) -> String) -> Result<Self, EnvError> {
        let gain = self.mdp.optimal_gain(&self.start_states());
        let gain = gain.map_err(|no_gain| match no_gain {
            NoGain::End(end) => EnvError::ContinuingEnd { end: name(end) },
            NoGain::NoWay(from, to) => EnvError::NoWayBack {
                from: name(from),
                to: name(to),
            },
            NoGain::Unsettled(lower, upper) => EnvError::GainUnsettled { lower, upper },
        })?;
        self.life = Some(Life {
            gain,
            has_begun: false,
        });
        Ok(self)
    }

    /// The standard deviation of what a step from `state` pays, beside that of where it leads.
    pub fn reward_deviation(&self, state: MdpState) -> f64 {
        self.noise.deviation(state.index())
    }

    /// Draws outcomes, rewards and starts from `rng` from now on.
    pub fn reseed(&mut self, rng: ChaCha8Rng) {
        self.rng = rng;
    }

    /// The MDP behind it.
    pub fn mdp(&self) -> &TabularMdp {
        &self.mdp
    }
}

impl Environment for TabularEnvironment {
    type State = MdpState;

    fn num_actions(&self) -> usize {
        self.mdp.num_actions()
    }

    fn reset(&mut self) -> MdpState {
        self.clock.begin();
        let goes_on = self.life.is_some_and(|life| life.has_begun);
        if !goes_on {
            self.state = self.starts.draw(&mut self.rng);
        }
        if let Some(life) = &mut self.life {
            life.has_begun = true;
        }
        self.state
    }

    fn step(&mut self, action: Action) -> Step<MdpState> {
        self.clock.assert_running();
        let outcomes = self.mdp.outcomes(self.state.index(), action);
        let outcome = match outcomes {
            [only] => only,
            several => {
                let mut left = self.rng.random::<f64>();
                let drawn = several.iter().find(|outcome| {
                    left -= outcome.probability;
                    left < 0.0
                });
                // The sum may fall short of 1 by rounding: the last outcome takes the rest.
                drawn
                    .or(several.last())
                    .expect("a non-terminal state has outcomes")
            }
        };
        let reward = self
            .noise
            .on(outcome.reward, self.state.index(), &mut self.rng);
        self.state = MdpState(outcome.next);
        let status = self.clock.tick(self.mdp.is_terminal(self.state.index()));
        Step {
            state: self.state,
            reward,
            status,
        }
    }
}

impl Model for TabularEnvironment {
    fn to_mdp(&self) -> TabularMdp {
        self.mdp.as_ref().clone()
    }

    fn mdp_index(&self, state: &MdpState) -> usize {
        assert!(
            state.index() < self.mdp.num_states(),
            "{state:?} of {}",
            self.mdp.num_states()
        );
        state.index()
    }

    fn start_distribution(&self) -> Starts {
        self.starts.map(|start| start.index())
    }

    fn max_steps(&self) -> usize {
        self.clock.max_steps()
    }

    fn optimum(&self) -> Optimum {
        let max_steps = self.clock.max_steps();
        match self.optimal_gain() {
            Some(gain) => Optimum {
                expected_return: gain * max_steps as f64,
                expected_steps: max_steps as f64,
            },
            None => self.mdp.optimum(self.start_distribution(), max_steps),
        }
    }

    fn optimal_gain(&self) -> Option<f64> {
        self.life.map(|life| life.gain)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::conformance::{Expectations, check_environment};
    use crate::env::{Outcome, StepStatus};
    use crate::seeds::{Stream, stream};

    #[test]
    fn impossible_starts_are_refused() {
        let to_end = vec![vec![Outcome {
            next: 1,
            probability: 1.0,
            reward: 0.0,
        }]];
        let mdp = Arc::new(TabularMdp::new(&[to_end, vec![]], vec![false, true]).unwrap());
        let build = |starts: &[usize], max_steps| {
            TabularEnvironment::new(
                mdp.clone(),
                starts,
                max_steps,
                stream(0, Stream::Environment),
            )
            .map(|_| ())
        };
        assert_eq!(build(&[0], 1), Ok(()));
        assert_eq!(build(&[0], 0), Err(EnvError::NoSteps));
        for bad in [&[][..], &[1], &[0, 2]] {
            assert!(matches!(
                build(bad, 1),
                Err(EnvError::BadStart { states: 2, .. })
            ));
        }
    }

    fn coin(left: u32, right: u32, pays: f64) -> Vec<Outcome> {
        let half = |next, reward| Outcome {
            next,
            probability: 0.5,
            reward,
        };
        vec![half(left, 0.0), half(right, pays)]
    }

    /// A ring of 7, a coin for each step on; the last pays 14, so that the best earns 14 · ½ / 7 a step.
    fn ring() -> TabularMdp {
        let state = |s: u32| vec![coin(s, (s + 1) % 7, if s == 6 { 14.0 } else { 0.0 })];
        TabularMdp::new(&(0..7).map(state).collect::<Vec<_>>(), vec![false; 7]).unwrap()
    }

    fn life(seed: u64, starts: &[usize]) -> TabularEnvironment {
        let rng = stream(seed, Stream::Environment);
        let world = TabularEnvironment::new(ring(), starts, 10, rng).unwrap();
        world.continuing(|state| state.to_string()).unwrap()
    }

    /// The same steps without resets, from the same numbers, are one long episode.
    #[test]
    fn windows_are_parts_of_one_life() {
        let mut windows = life(3, &[2, 5]);
        let rng = stream(3, Stream::Environment);
        let mut whole = TabularEnvironment::new(ring(), &[2, 5], usize::MAX, rng).unwrap();
        let mut stands = whole.reset();
        for window in 0..50 {
            assert_eq!(windows.reset(), stands);
            // One is left in the middle, and changes nothing.
            let steps = if window == 20 { 4 } else { 10 };
            for step in 1..=steps {
                let (part, other) = (windows.step(Action(0)), whole.step(Action(0)));
                assert_eq!((part.state, part.reward), (other.state, other.reward));
                assert_eq!(part.status == StepStatus::Truncated, step == 10);
                stands = part.state;
            }
        }
        let expectations = Expectations {
            max_steps: Some(10),
            random: true,
        };
        check_environment(|seed| life(seed, &[2, 5]), &expectations).unwrap();
    }

    /// The one policy there is earns the optimum in the long run: n windows within five standard errors, seen from their own
    /// spread, for windows of a ring hardly depend on each other.
    #[test]
    fn the_best_of_a_window_is_that_of_a_life() {
        let mut world = life(1, &[0]);
        let best = world.optimum();
        assert!((best.expected_return - 10.0).abs() < 1e-6);
        assert_eq!(best.expected_steps, 10.0);
        let windows = 20_000;
        let mut returns = Vec::new();
        for _ in 0..windows {
            world.reset();
            returns.push((0..10).map(|_| world.step(Action(0)).reward).sum::<f64>());
        }
        let mean = returns.iter().sum::<f64>() / f64::from(windows);
        let squares = returns.iter().map(|r| (r - mean).powi(2)).sum::<f64>();
        let error = squares.sqrt() / f64::from(windows);
        assert!(
            (mean - best.expected_return).abs() < 5.0 * error,
            "{mean}, {error}"
        );
        // From the start anew each time it would be less: state 6 is seven steps away.
        assert!(world.mdp().optimal_return(&[0], 10) < best.expected_return - 20.0 * error);
    }
}
