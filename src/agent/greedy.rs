//! ε-greedy choice over values and advice, ties broken uniformly.
//!
//! π(a|s) = (1 − ε) · 1[a best] / (number of best) + ε / (number of actions)
//! (Sutton & Barto 2018, section 2.2), where a is best if Q(s, a) + advice(a) is the largest: look-ahead advice as
//! Wiewiora, Cottrell & Elkan (2003) define it for greedy learners.

use crate::env::Action;
use rand::{Rng, RngExt};

/// The largest of values + advice, and how many actions reach it.
///
/// # Panics
/// If the slices differ in length.
fn best(values: &[f64], advice: &[f64]) -> (f64, usize) {
    assert_eq!(
        values.len(),
        advice.len(),
        "one number of advice per action"
    );
    let mut best = f64::NEG_INFINITY;
    let mut ties = 0;
    for (&value, &advice) in values.iter().zip(advice) {
        let total = value + advice;
        if total > best {
            (best, ties) = (total, 1);
        } else if total == best {
            ties += 1;
        }
    }
    (best, ties)
}

/// Chooses ε-greedily. Draws one number for ε (if ε > 0) and one for the action (unless one action is best alone).
pub(crate) fn choose(values: &[f64], advice: &[f64], epsilon: f64, rng: &mut impl Rng) -> Action {
    let any = |rng: &mut _| action(RngExt::random_range(rng, 0..values.len()));
    if epsilon > 0.0 && rng.random::<f64>() < epsilon {
        return any(rng);
    }
    let (best, ties) = best(values, advice);
    if ties == 0 {
        return any(rng); // nothing compares: every value is NaN
    }
    let mut skip = if ties == 1 {
        0
    } else {
        rng.random_range(0..ties)
    };
    for (i, (&value, &advice)) in values.iter().zip(advice).enumerate() {
        if value + advice == best {
            if skip == 0 {
                return action(i);
            }
            skip -= 1;
        }
    }
    unreachable!("`ties` counts the actions that reach `best`")
}

/// Σ_a π(a|s) values(a) under the ε-greedy policy for `values` and `advice`.
pub(crate) fn expectation(values: &[f64], advice: &[f64], epsilon: f64) -> f64 {
    let (best, ties) = best(values, advice);
    let (mut of_best, mut of_all) = (0.0, 0.0);
    for (&value, &advice) in values.iter().zip(advice) {
        of_all += value;
        if value + advice == best {
            of_best += value;
        }
    }
    (1.0 - epsilon) * of_best / ties.max(1) as f64 + epsilon * of_all / values.len() as f64
}

/// values + advice.
///
/// # Panics
/// If they differ in length.
pub(crate) fn advised(values: &[f64], advice: &[f64]) -> Vec<f64> {
    assert_eq!(
        values.len(),
        advice.len(),
        "one number of advice per action"
    );
    values.iter().zip(advice).map(|(v, a)| v + a).collect()
}

/// The first of the largest values.
pub(crate) fn first_best(values: &[f64]) -> Option<Action> {
    let (best, ties) = values
        .iter()
        .fold((f64::NEG_INFINITY, 0), |(best, ties), &v| {
            if v > best { (v, 1) } else { (best, ties) }
        });
    (ties > 0).then(|| {
        action(
            values
                .iter()
                .position(|&v| v == best)
                .expect("best is one of them"),
        )
    })
}

/// The action with this index.
///
/// # Panics
/// If there are more actions than an [`Action`] can number.
#[inline]
pub(crate) fn action(index: usize) -> Action {
    Action(u16::try_from(index).expect("actions are numbered by u16"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seeds::{Stream, stream};

    const NO_ADVICE: [f64; 4] = [0.0; 4];

    const DRAWS: u32 = 40_000;

    fn frequencies(values: &[f64; 4], advice: &[f64; 4], epsilon: f64) -> [f64; 4] {
        let mut rng = stream(3, Stream::Agent);
        let mut counts = [0u32; 4];
        for _ in 0..DRAWS {
            counts[choose(values, advice, epsilon, &mut rng).index()] += 1;
        }
        counts.map(|count| f64::from(count) / f64::from(DRAWS))
    }

    /// Five standard deviations of a frequency over 40 000 draws: 5 · √(0.25 / 40 000).
    const SPREAD: f64 = 0.0125;

    #[test]
    fn ties_are_broken_uniformly_and_the_rest_gets_its_share_of_epsilon() {
        let observed = frequencies(&[1.0, 7.0, 7.0, 2.0], &NO_ADVICE, 0.2);
        for (observed, expected) in observed.iter().zip([0.05, 0.45, 0.45, 0.05]) {
            assert!(
                (observed - expected).abs() < SPREAD,
                "{observed} against {expected}"
            );
        }
    }

    #[test]
    fn advice_decides_what_is_best_but_not_what_it_is_worth() {
        let (values, advice) = ([1.0, 7.0, 7.0, 2.0], [0.0, 0.0, 0.0, 9.0]);
        assert_eq!(frequencies(&values, &advice, 0.0), [0.0, 0.0, 0.0, 1.0]);
        assert_eq!(expectation(&values, &advice, 0.0), 2.0);
    }

    #[test]
    fn expectation_weighs_by_the_policy() {
        // .45 · 7 + .45 · 7 + .05 · 1 + .05 · 2
        assert!((expectation(&[1.0, 7.0, 7.0, 2.0], &NO_ADVICE, 0.2) - 6.45).abs() < 1e-14);
    }

    #[test]
    fn numbers_that_do_not_compare_are_no_panic() {
        let action = choose(
            &[f64::NAN; 4],
            &NO_ADVICE,
            0.0,
            &mut stream(1, Stream::Agent),
        );
        assert!(action.index() < 4);
        assert_eq!(first_best(&[f64::NAN; 2]), None);
        assert_eq!(first_best(&[f64::NAN, 1.0, 1.0]), Some(Action(1)));
    }
}
