//! What a step pays beyond R(s, a, s′): σ(s) z, with z a standard normal number drawn anew for each step from s.
//!
//! Its mean is 0, so that R stays the mean of what is paid, and values, gains and optima of the MDP are those of the world.

use crate::seeds::standard_normal;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// σ of every state, or of none: then no step is noisy.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub(super) struct RewardNoise(Arc<[f64]>);

impl RewardNoise {
    /// The noise with these standard deviations.
    ///
    /// # Panics
    /// If one is negative, infinite or no number.
    pub(super) fn new(deviations: &[f64]) -> Self {
        for (state, &deviation) in deviations.iter().enumerate() {
            assert!(
                deviation.is_finite() && deviation >= 0.0,
                "the deviation of state {state} is {deviation}"
            );
        }
        Self(deviations.into())
    }

    /// σ(s).
    pub(super) fn deviation(&self, state: usize) -> f64 {
        self.0.get(state).copied().unwrap_or(0.0)
    }

    /// `reward` and what a step from `state` pays beyond it. Draws nothing where σ is 0.
    #[inline]
    pub(super) fn on(&self, reward: f64, state: usize, rng: &mut ChaCha8Rng) -> f64 {
        match self.deviation(state) {
            0.0 => reward,
            deviation => reward + deviation * standard_normal(rng),
        }
    }
}
