//! F_t = γ φ_{t+1}(s_{t+1}) − φ_t(s_t), with φ_t(s_t) remembered from the moment s_t was entered.
//!
//! Devlin & Kudenko (2012) show that this keeps the optimal policies while φ itself changes; Grześ (2017) that φ
//! must count as 0 after termination, and only then.

use crate::env::StepStatus;
use serde::{Deserialize, Serialize};

/// Turns r into r + γφ(s′) − φ(s). Holds two numbers; O(1) a step.
///
/// ```
/// use eigentrail::env::StepStatus;
/// use eigentrail::shaping::RewardShaper;
///
/// let mut shaper = RewardShaper::new(1.0);
/// shaper.begin_episode(-2.0);
/// assert_eq!(shaper.shape(-1.0, StepStatus::Running), 1.0);
/// // φ was re-fitted meanwhile: the next difference still starts from the −1 that was paid out.
/// assert_eq!(shaper.shape(-0.5, StepStatus::Terminated), 1.0);
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RewardShaper {
    gamma: f64,
    /// φ_t(s_t): the potential used on entering the present state.
    entered_with: f64,
}

impl RewardShaper {
    /// A shaper for discount `gamma`, which must be the agent's.
    ///
    /// # Panics
    /// If `gamma` is not in [0, 1].
    pub fn new(gamma: f64) -> Self {
        assert!((0.0..=1.0).contains(&gamma), "gamma is {gamma}");
        Self {
            gamma,
            entered_with: 0.0,
        }
    }

    /// Begins an episode in a state with this potential.
    pub fn begin_episode(&mut self, potential: f64) {
        self.entered_with = potential;
    }

    /// F for a step to a state whose potential is now `next_potential` (ignored on termination, where 0 counts).
    pub fn shape(&mut self, next_potential: f64, status: StepStatus) -> f64 {
        let next = match status {
            StepStatus::Terminated => 0.0,
            StepStatus::Running | StepStatus::Truncated => next_potential,
        };
        let shaping = self.gamma * next - self.entered_with;
        self.entered_with = next;
        shaping
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn termination_zeroes_next_potential() {
        let mut shaper = RewardShaper::new(0.9);
        shaper.begin_episode(-3.0);
        assert_eq!(shaper.shape(-100.0, StepStatus::Terminated), 3.0);
        assert_eq!(shaper.entered_with, 0.0);
    }

    #[test]
    fn truncation_keeps_next_potential() {
        let mut shaper = RewardShaper::new(0.5);
        shaper.begin_episode(-3.0);
        assert_eq!(shaper.shape(-4.0, StepStatus::Truncated), 1.0);
    }

    #[test]
    fn state_survives_serialisation() {
        let mut shaper = RewardShaper::new(0.99);
        shaper.begin_episode(-0.1);
        shaper.shape(-0.3, StepStatus::Running);
        let text = serde_json::to_string(&shaper).unwrap();
        assert_eq!(serde_json::from_str::<RewardShaper>(&text).unwrap(), shaper);
    }

    proptest! {
        /// Potentials that are multiples of 1/8 add without rounding, so at γ = 1 the sum must be exact: each
        /// number of the sequence may belong to another φ.
        #[test]
        fn sum_telescopes_exactly_while_the_potential_changes(
            eighths in prop::collection::vec(-4000_i32..=0, 2..200),
            terminated: bool,
        ) {
            let phi: Vec<f64> = eighths.iter().map(|&e| f64::from(e) / 8.0).collect();
            let (last, status) = if terminated {
                (0.0, StepStatus::Terminated)
            } else {
                (phi[phi.len() - 1], StepStatus::Truncated)
            };
            let mut shaper = RewardShaper::new(1.0);
            shaper.begin_episode(phi[0]);
            let mut sum = 0.0;
            for (t, &next) in phi.iter().enumerate().skip(1) {
                let is_last = t + 1 == phi.len();
                sum += shaper.shape(next, if is_last { status } else { StepStatus::Running });
            }
            prop_assert_eq!(sum, last - phi[0]);
        }

        #[test]
        fn discounted_sum_telescopes_to_rounding(
            phi in prop::collection::vec(-1e3_f64..0.0, 2..200),
            gamma in 0.0_f64..=1.0,
        ) {
            let mut shaper = RewardShaper::new(gamma);
            shaper.begin_episode(phi[0]);
            let (mut sum, mut discount) = (0.0, 1.0);
            for &next in &phi[1..] {
                sum += discount * shaper.shape(next, StepStatus::Running);
                discount *= gamma;
            }
            let expected = discount * phi[phi.len() - 1] - phi[0];
            // Each of the ≤ 200 terms is below 2e3, so rounding stays below 200 · 2e3 · 2⁻⁵² ≈ 1e-10.
            prop_assert!((sum - expected).abs() < 1e-9, "{} against {}", sum, expected);
        }
    }
}
