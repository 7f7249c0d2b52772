//! Softmax over preferences and advice.
//!
//! π(a|s) = exp(l_a) / Σ_b exp(l_b), with logits l_a = clip(h(s, a), ±c) + advice_a  (eq. 7 of the source paper with
//! the soft-max of Sutton & Barto 2018, eq. 13.2).
//!
//! ∂ log π(a|s) / ∂ h(s, b) = 1[a = b] − π(b|s)  (Sutton & Barto, exercise 13.3), the advice being part of π.
//!
//! The clip bounds how sure the policy can get: with c = 3 and four actions no action falls below 1/1200 where
//! there is no advice. Without it a policy that settled on the lesser of two goals hardly ever finds the greater
//! one, nor a goal that moved.

use super::table::largest;
use crate::exponential::{exp, exp_of_four};
use rand::{Rng, RngExt};
use std::array::from_fn;

/// Writes π(·|s) into `probabilities`.
///
/// Subtracts the largest logit first, so that no finite logits overflow. O(actions), no allocation.
///
/// # Panics
/// If the three slices differ in length.
#[inline]
pub fn softmax(preferences: &[f64], advice: &[f64], clip: f64, probabilities: &mut [f64]) {
    assert_eq!(
        preferences.len(),
        probabilities.len(),
        "one preference per action"
    );
    assert_eq!(
        advice.len(),
        probabilities.len(),
        "one number of advice per action"
    );
    if let (Ok(preferences), Ok(advice), Ok(probabilities)) = (
        preferences.try_into(),
        advice.try_into(),
        probabilities.try_into(),
    ) {
        return softmax_of_four(preferences, advice, clip, probabilities);
    }
    let logits = preferences.iter().zip(advice);
    for (p, (&preference, &advice)) in probabilities.iter_mut().zip(logits) {
        *p = clamp(preference, clip) + advice;
    }
    let largest = largest(probabilities);
    probabilities
        .iter_mut()
        .for_each(|p| *p = exp(*p - largest));
    let scale = 1.0 / probabilities.iter().sum::<f64>();
    probabilities.iter_mut().for_each(|p| *p *= scale);
}

/// The same for as many actions as grids have, in registers.
#[inline]
fn softmax_of_four(
    preferences: &[f64; 4],
    advice: &[f64; 4],
    clip: f64,
    probabilities: &mut [f64; 4],
) {
    let logits: [f64; 4] = from_fn(|a| clamp(preferences[a], clip) + advice[a]);
    let largest = largest(&logits);
    let mut weights: [f64; 4] = from_fn(|a| logits[a] - largest);
    exp_of_four(&mut weights);
    let scale = 1.0 / weights.iter().sum::<f64>();
    *probabilities = from_fn(|a| weights[a] * scale);
}

/// `preference` moved into ±`clip`; NaN stays NaN.
#[inline]
pub(crate) fn clamp(preference: f64, clip: f64) -> f64 {
    let preference = if preference > clip { clip } else { preference };
    if preference < -clip {
        -clip
    } else {
        preference
    }
}

/// The action that `uniform` in [0, 1) falls on when the unit interval is cut into pieces of the given lengths.
///
/// Where rounding leaves the pieces short of 1, the rest belongs to the last action that has a chance at all.
#[inline]
pub fn action_at(probabilities: &[f64], uniform: f64) -> usize {
    let (mut action, mut last_possible) = (0, 0);
    let mut end = 0.0;
    for (a, &p) in probabilities.iter().enumerate() {
        end += p;
        action += usize::from(uniform >= end); // no branch: it would be mispredicted every other time
        last_possible = if p > 0.0 { a } else { last_possible };
    }
    action.min(last_possible)
}

/// Draws an action from one uniform number.
#[inline]
pub fn sample(probabilities: &[f64], rng: &mut impl Rng) -> usize {
    action_at(probabilities, rng.random::<f64>())
}

/// Entropy −Σ p ln p in nats, 0..=ln(actions).
pub fn entropy(probabilities: &[f64]) -> f64 {
    -probabilities
        .iter()
        .filter(|&&p| p > 0.0)
        .map(|&p| p * libm::log(p))
        .sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const NO_CLIP: f64 = 1e300;

    #[test]
    fn equal_logits_give_equal_chances_and_full_entropy() {
        let mut p = [0.0; 4];
        softmax(&[1.0, 2.0, 0.0, 1.5], &[1.0, 0.0, 2.0, 0.5], 3.0, &mut p);
        p.iter().for_each(|&p| assert!((p - 0.25).abs() < 1e-15));
        assert!((entropy(&p) - 4f64.ln()).abs() < 1e-14);
    }

    #[test]
    fn huge_logits_do_not_overflow() {
        let mut p = [0.0; 2];
        softmax(&[1e300, -1e300], &[0.0, 0.0], NO_CLIP, &mut p);
        assert_eq!(p, [1.0, 0.0]);
        assert_eq!(entropy(&p), 0.0);
    }

    #[test]
    fn preferences_are_clipped_and_advice_is_not() {
        let mut p = [0.0; 2];
        softmax(&[50.0, -50.0], &[0.0, 10.0], 3.0, &mut p);
        // logits 3 and −3 + 10
        assert!((p[1] - 1.0 / (1.0 + (-4f64).exp())).abs() < 1e-15);
    }

    #[test]
    fn pieces_of_the_unit_interval_belong_to_their_action() {
        let p = [0.25, 0.0, 0.5, 0.25];
        let expected = [
            (0.0, 0),
            (0.2499, 0),
            (0.25, 2),
            (0.7499, 2),
            (0.75, 3),
            (0.999_999, 3),
        ];
        for (uniform, action) in expected {
            assert_eq!(action_at(&p, uniform), action, "at {uniform}");
        }
        // rounding: pieces that fall short of 1 never yield an impossible action
        assert_eq!(action_at(&[0.5, 0.499_999, 0.0], 0.999_999_9), 1);
    }

    proptest! {
        #[test]
        fn probabilities_are_a_distribution_that_a_common_shift_leaves_alone(
            h in prop::collection::vec(-20.0..20.0f64, 1..6), shift in -5.0..5.0f64,
        ) {
            let (mut p, mut q) = (vec![0.0; h.len()], vec![0.0; h.len()]);
            softmax(&h, &vec![0.0; h.len()], NO_CLIP, &mut p);
            softmax(&h, &vec![shift; h.len()], NO_CLIP, &mut q);
            prop_assert!((p.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            for (a, b) in p.iter().zip(&q) {
                prop_assert!((a - b).abs() < 1e-12);
            }
        }

        /// ∂ log π(a) / ∂ h_b = 1[a = b] − π(b), advice included, against central differences.
        #[test]
        fn gradient_of_log_policy_matches_finite_differences(
            h in prop::collection::vec(-2.5..2.5f64, 4), advice in prop::collection::vec(-3.0..3.0f64, 4),
            a in 0..4usize, b in 0..4usize,
        ) {
            let step = 1e-5;
            let log_policy = |change: f64| {
                let (mut moved, mut p) = (h.clone(), vec![0.0; 4]);
                moved[b] += change;
                softmax(&moved, &advice, 3.0, &mut p);
                p[a].ln()
            };
            let numeric = (log_policy(step) - log_policy(-step)) / (2.0 * step);
            let mut p = vec![0.0; 4];
            softmax(&h, &advice, 3.0, &mut p);
            let exact = f64::from(u8::from(a == b)) - p[b];
            prop_assert!((numeric - exact).abs() < 1e-8, "{numeric} against {exact}");
        }
    }
}
