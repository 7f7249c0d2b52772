//! Behaviour of an actor-critic at one state: the policy there, the advice in it, the action drawn from it.

use super::Situation;
use super::policy::softmax;
use serde::{Deserialize, Serialize};

/// The policy at one state, as it was last computed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Behaviour {
    /// The number of the state; `None` before the first step of an episode.
    pub state: Option<u32>,
    pub advice: Vec<f64>,
    pub probabilities: Vec<f64>,
    /// The action already drawn for this state.
    pub drawn: Option<u16>,
    /// Whether θ moved since `probabilities` were computed.
    pub stale: bool,
}

impl Behaviour {
    pub fn new(num_actions: usize) -> Self {
        let zeros = vec![0.0; num_actions];
        Behaviour {
            state: None,
            advice: zeros.clone(),
            probabilities: zeros,
            drawn: None,
            stale: true,
        }
    }

    /// Moves to `situation`, with everything about it still to be computed.
    pub fn enter(&mut self, situation: Situation<'_>) {
        self.state = Some(situation.state.0);
        self.advice.copy_from_slice(situation.advice);
        self.drawn = None;
        self.stale = true;
    }

    /// Whether it describes `situation`, advice included.
    pub fn describes(&self, situation: Situation<'_>) -> bool {
        self.state == Some(situation.state.0) && self.advice == situation.advice
    }

    /// Computes the policy from the preferences for this state.
    #[inline]
    pub fn compute(&mut self, preferences: &[f64], clip: f64) {
        softmax(preferences, &self.advice, clip, &mut self.probabilities);
        self.stale = false;
    }
}
