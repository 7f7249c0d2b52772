//! UCBVI-CH: value iteration on upper confidence bounds of Chernoff and Hoeffding's kind (Azar, Osband & Munos 2017,
//! Algorithms 2 and 3).
//!
//! Q(s, a) = min(B, r̂(s, a) + Σ_s′ P̂(s′|s, a) V(s′) + c · 7 R L √(1 / n(s, a))),    L = ln(5 S A T / δ)
//!
//! with n(s, a) tries so far, T steps so far, δ = 0.05, and B, the paper's H, the best return that may be hoped for in the steps
//! that are left. S, the number of states, is that of the states known so far, and R the range of rewards as it is known
//! so far ([`episode_planner`](super::episode_planner)). With c = H, the horizon, the bound holds with certainty 1 − δ, and
//! nothing is learnt before millions of steps; so c, `bonus`, is small.

use super::checks::check_bonus;
use super::episode_planner::{Belief, EpisodePlanParams, EpisodePlanner, Outlook, as_seen, tries};
use super::horizon_plan::Believed;
use super::model::Outcome;
use crate::parameter::ParameterError;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// δ: chance that a bound does not hold.
const DOUBT: f64 = 0.05;

/// The learner.
pub type Ucbvi = EpisodePlanner<UcbviParams>;

/// Parameters of [`Ucbvi`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct UcbviParams {
    /// How it plans.
    pub plan: EpisodePlanParams,
    /// c: the bonus in H-ths of the theory's; at least 0.
    pub bonus: f64,
}

impl Default for UcbviParams {
    fn default() -> Self {
        UcbviParams {
            plan: EpisodePlanParams::default(),
            bonus: 0.0125,
        }
    }
}

impl UcbviParams {
    /// Checks the ranges.
    ///
    /// # Errors
    /// The first parameter out of its range.
    pub fn validate(&self) -> Result<(), ParameterError> {
        self.plan.validate()?;
        check_bonus("bonus", self.bonus)
    }
}

impl Belief for UcbviParams {
    const CLIPS: bool = true;

    fn plan(&self) -> &EpisodePlanParams {
        &self.plan
    }

    fn hope(&self, _outlook: &Outlook) -> f64 {
        0.0
    }

    fn believe(
        &self,
        outcomes: &[Outcome],
        outlook: &Outlook,
        _rng: &mut ChaCha8Rng,
        next: &mut Vec<(u32, f64)>,
    ) -> Believed {
        let tries = tries(outcomes);
        if tries == 0 {
            return Believed {
                reward: 0.0,
                unknown: 1.0,
            };
        }
        let pairs_and_steps = outlook.pairs as f64 * outlook.steps.max(1) as f64;
        let log = libm::log(5.0 * pairs_and_steps / DOUBT);
        let scale = 7.0 * outlook.range * log;
        Believed {
            reward: as_seen(outcomes, next) + self.bonus * scale / f64::from(tries).sqrt(),
            unknown: 0.0,
        }
    }
}
