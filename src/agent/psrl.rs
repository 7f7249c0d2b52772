//! PSRL: posterior sampling, of which the best plan for one world that may be is followed for an episode (Strens 2000; Osband,
//! Russo & Van Roy 2013).
//!
//! The transitions of (s, a) are a Dirichlet process (Ferguson 1973) with mass α, all of it on states that nobody has seen
//! as yet, for how many of them there are is not known: of what followed n₁, …, n_k times, and of something unknown,
//!
//! (p₁, …, p_k, u) ~ Dirichlet(n₁, …, n_k, α)
//!
//! so that an action that was never tried leads to the unknown for certain, and after n tries there does with chance
//! α / (n + α) in the mean. Mean rewards are normal, r(s, a) ~ N(Σ_i p_i r̂_i, (σ R)² / n), R being the range of rewards as it is
//! known so far ([`episode_planner`](super::episode_planner)): the posterior of a flat prior when single rewards deviate by σ R.

use super::checks::{AGENT, check_bonus};
use super::draws::{dirichlet, normal};
use super::episode_planner::{Belief, EpisodePlanParams, EpisodePlanner, Outlook, tries};
use super::horizon_plan::Believed;
use super::model::Outcome;
use crate::parameter::ParameterError;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// The learner.
pub type Psrl = EpisodePlanner<PsrlParams>;

/// Parameters of [`Psrl`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PsrlParams {
    /// How it plans.
    pub plan: EpisodePlanParams,
    /// α: tries that the prior is worth; above 0.
    pub prior_tries: f64,
    /// σ: deviation of single rewards, in ranges of rewards; at least 0.
    pub reward_deviation: f64,
}

impl Default for PsrlParams {
    fn default() -> Self {
        PsrlParams {
            plan: EpisodePlanParams::default(),
            prior_tries: 0.003,
            reward_deviation: 0.7,
        }
    }
}

impl PsrlParams {
    /// Checks the ranges.
    ///
    /// # Errors
    /// The first parameter out of its range.
    pub fn validate(&self) -> Result<(), ParameterError> {
        self.plan.validate()?;
        let (key, tries) = ("prior_tries", self.prior_tries);
        AGENT.number(
            key,
            tries,
            tries > 0.0 && tries <= 1e6,
            "above 0 and at most 1e6",
        )?;
        check_bonus("reward_deviation", self.reward_deviation)
    }
}

impl Belief for PsrlParams {
    const CLIPS: bool = false;

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
        rng: &mut ChaCha8Rng,
        next: &mut Vec<(u32, f64)>,
    ) -> Believed {
        let tries = tries(outcomes);
        if tries == 0 {
            return Believed {
                reward: 0.0,
                unknown: 1.0,
            };
        }
        let counts = outcomes.iter().map(|outcome| f64::from(outcome.count));
        let mut shares: Vec<f64> = counts.chain([self.prior_tries]).collect();
        dirichlet(&mut shares, rng);
        let drawn = || outcomes.iter().zip(&shares);
        let goes_on = drawn().filter(|(outcome, _)| !outcome.ends);
        next.extend(goes_on.map(|(outcome, &share)| (outcome.to.0, share)));
        let mean: f64 = drawn()
            .map(|(outcome, &share)| share * outcome.reward)
            .sum();
        let deviation = self.reward_deviation * outlook.range / f64::from(tries).sqrt();
        Believed {
            reward: mean + deviation * normal(rng),
            unknown: shares[outcomes.len()],
        }
    }
}
