//! Acting in a finite MDP: the next state is drawn from P.

use super::TabularMdp;
use crate::env::clock::EpisodeClock;
use crate::env::{Action, EnvError, Environment, Model, Step, draw_start};
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

/// An episodic world over a [`TabularMdp`]. Copies share the MDP.
///
/// Actions with one outcome draw no random number, nor do resets with one start.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct TabularEnvironment {
    mdp: Arc<TabularMdp>,
    starts: Vec<MdpState>,
    clock: EpisodeClock,
    rng: ChaCha8Rng,
    state: MdpState,
}

impl TabularEnvironment {
    /// Episodes begin in one of `starts`, equally likely, and are truncated after `max_steps`.
    ///
    /// # Errors
    /// [`EnvError::BadStart`] if there is none, or one is terminal or no state; [`EnvError::NoSteps`].
    pub fn new(
        mdp: impl Into<Arc<TabularMdp>>,
        starts: &[usize],
        max_steps: usize,
        rng: ChaCha8Rng,
    ) -> Result<Self, EnvError> {
        let mdp = mdp.into();
        let states = mdp.num_states();
        if max_steps == 0 {
            return Err(EnvError::NoSteps);
        }
        if starts.is_empty() {
            return Err(EnvError::BadStart {
                start: "nothing".to_owned(),
                states,
            });
        }
        if let Some(start) = starts
            .iter()
            .find(|&&start| start >= states || mdp.is_terminal(start))
        {
            return Err(EnvError::BadStart {
                start: format!("state {start}"),
                states,
            });
        }
        let starts: Vec<_> = starts.iter().map(|&start| MdpState(start as u32)).collect();
        let state = starts[0];
        Ok(TabularEnvironment {
            mdp,
            starts,
            clock: EpisodeClock::new(max_steps),
            rng,
            state,
        })
    }

    /// Draws outcomes and starts from `rng` from now on.
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
        self.state = draw_start(&self.starts, &mut self.rng);
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
        self.state = MdpState(outcome.next);
        let status = self.clock.tick(self.mdp.is_terminal(self.state.index()));
        Step {
            state: self.state,
            reward: outcome.reward,
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

    fn start_states(&self) -> Vec<usize> {
        self.starts.iter().map(|start| start.index()).collect()
    }

    fn max_steps(&self) -> usize {
        self.clock.max_steps()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::Outcome;
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
}
