//! MBIE-EB: model-based interval estimation with exploration bonus (Strehl & Littman 2008).
//!
//! Q(s, a) = r̂(s, a) + β R / √n(s, a) + γ Σ_s′ P̂(s′|s, a) max_b Q(s′, b)
//!
//! with n(s, a) tries so far and R the range of rewards as it is known so far
//! ([`episode_planner`](super::episode_planner)). What was never tried is worth the best return that may be hoped for, were every
//! reward β R larger, so that no bonus is worth more than the unknown. With β = 0
//! this is certainty equivalence with optimism about the untried alone: R-max that knows an action after one try.

use super::checks::check_bonus;
use super::episode_planner::{Belief, EpisodePlanParams, EpisodePlanner, Outlook, as_seen, tries};
use super::horizon_plan::Believed;
use super::model::Outcome;
use crate::parameter::ParameterError;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// The learner.
pub type MbieEb = EpisodePlanner<MbieEbParams>;

/// Parameters of [`MbieEb`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MbieEbParams {
    /// How it plans.
    pub plan: EpisodePlanParams,
    /// β, in ranges of rewards; at least 0.
    pub bonus: f64,
}

impl Default for MbieEbParams {
    fn default() -> Self {
        MbieEbParams {
            plan: EpisodePlanParams::default(),
            bonus: 1.0,
        }
    }
}

impl MbieEbParams {
    /// Checks the ranges.
    ///
    /// # Errors
    /// The first parameter out of its range.
    pub fn validate(&self) -> Result<(), ParameterError> {
        self.plan.validate()?;
        check_bonus("bonus", self.bonus)
    }
}

impl Belief for MbieEbParams {
    const CLIPS: bool = false;

    fn plan(&self) -> &EpisodePlanParams {
        &self.plan
    }

    fn hope(&self, outlook: &Outlook) -> f64 {
        self.bonus * outlook.range
    }

    fn believe(
        &self,
        outcomes: &[Outcome],
        outlook: &Outlook,
        _rng: &mut ChaCha8Rng,
        next: &mut Vec<(u32, f64)>,
    ) -> Believed {
        match tries(outcomes) {
            0 => Believed {
                reward: 0.0,
                unknown: 1.0,
            },
            tries => Believed {
                reward: as_seen(outcomes, next) + self.hope(outlook) / f64::from(tries).sqrt(),
                unknown: 0.0,
            },
        }
    }
}
