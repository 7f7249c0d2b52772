//! Every action equally likely: the floor that a learner must leave behind.

use super::greedy::action;
use super::{Agent, Experience, Situation, UpdateInfo};
use crate::env::Action;
use crate::seeds::{Stream, stream};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Chooses uniformly, learns nothing, and heeds no advice.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RandomAgent {
    num_actions: usize,
    rng: ChaCha8Rng,
}

impl RandomAgent {
    /// An agent over `num_actions` actions, drawing from the agent's stream of `seed`.
    ///
    /// # Panics
    /// If there are no actions.
    pub fn new(num_actions: usize, seed: u64) -> Self {
        assert!(num_actions > 0, "an agent needs at least one action");
        RandomAgent {
            num_actions,
            rng: stream(seed, Stream::Agent),
        }
    }
}

impl Agent for RandomAgent {
    fn select_action(&mut self, _situation: Situation<'_>) -> Action {
        action(self.rng.random_range(0..self.num_actions))
    }

    fn update(&mut self, _experience: &Experience<'_>) -> UpdateInfo {
        UpdateInfo::default()
    }
}
