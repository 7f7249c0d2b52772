//! Median with its exact interval between two order statistics.
//!
//! ```text
//! P(x_(k) ≤ median ≤ x_(n+1−k)) ≥ 1 − 2 P(B < k),   B ~ Binomial(n, ½),
//! ```
//!
//! whatever the values are distributed like, for values that are drawn independently. k is the largest one for which that is at
//! least what is asked for. Of fewer than 6 values no two enclose the median with 95 %: the interval is then all of them, and
//! says how sure it is.
//!
//! Source: W. R. Thompson, *On confidence ranges for the median and other expectation distributions for populations of unknown
//! distribution form*, Ann. Math. Statist. 7 (1936).

use super::robust::median;

/// A median between two values of its sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MedianBetween {
    /// The median of the sample.
    pub median: f64,
    /// x_(k).
    pub low: f64,
    /// x_(n+1−k).
    pub high: f64,
    /// The least chance that they enclose the median of what the sample was drawn from.
    pub confidence: f64,
}

impl MedianBetween {
    /// The median of `sample`, between the closest two of its values that enclose it with a chance of at least `confidence`, or
    /// between its smallest and its largest if none do; nothing for none. Infinite values are values. O(n log n).
    ///
    /// # Panics
    /// If `confidence` is not in 0..1.
    pub fn of(sample: &[f64], confidence: f64) -> Option<Self> {
        assert!((0.0..1.0).contains(&confidence), "sure to {confidence}");
        let mut sorted = sample.to_vec();
        sorted.sort_unstable_by(f64::total_cmp);
        let last = sorted.len().checked_sub(1)?;
        let (k, confidence) = rank(sorted.len(), confidence);
        Some(Self {
            median: median(&sorted),
            low: sorted[k - 1],
            high: sorted[last + 1 - k],
            confidence,
        })
    }
}

/// The largest k with 1 − 2 P(B < k) ≥ `confidence`, at least 1, and what it is for that k.
fn rank(n: usize, confidence: f64) -> (usize, f64) {
    let chances = half_binomial(n);
    let sure = |k: usize| 1.0 - 2.0 * chances[..k].iter().sum::<f64>();
    let most = n.div_ceil(2);
    let k = (2..=most).take_while(|&k| sure(k) >= confidence).last();
    let k = k.unwrap_or(1);
    (k, sure(k).max(0.0))
}

/// P(B = 0), P(B = 1), … P(B = ⌊n/2⌋), from the middle outwards so that nothing vanishes before its time.
fn half_binomial(n: usize) -> Vec<f64> {
    let middle = n / 2;
    let mut weights = vec![0.0; n + 1];
    weights[middle] = 1.0;
    for i in (0..middle).rev() {
        weights[i] = weights[i + 1] * (i + 1) as f64 / (n - i) as f64;
    }
    for i in middle + 1..=n {
        weights[i] = weights[i - 1] * (n + 1 - i) as f64 / i as f64;
    }
    let total: f64 = weights.iter().sum();
    weights.truncate(middle + 1);
    weights.iter().map(|weight| weight / total).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Ranks and confidences as tables of the sign test print them.
    #[test]
    fn known_ranks() {
        let sure = |n: usize, k: usize, expected: f64| {
            let (found, confidence) = rank(n, 0.95);
            assert_eq!(found, k, "of {n}");
            assert!((confidence - expected).abs() < 1e-4, "{n}: {confidence}");
        };
        sure(1, 1, 0.0);
        sure(5, 1, 0.9375); // not enough
        sure(6, 1, 0.96875);
        sure(10, 2, 0.97852);
        sure(20, 6, 0.95861);
        sure(30, 10, 0.95723);
        sure(100, 40, 0.96480);
    }

    /// Pascal's triangle by whole numbers.
    #[test]
    fn chances_are_binomial_coefficients() {
        let mut row = vec![1_u64];
        for n in 0..=40_usize {
            let total = (row.iter().sum::<u64>()) as f64;
            for (i, chance) in half_binomial(n).iter().enumerate() {
                let expected = row[i] as f64 / total;
                assert!((chance - expected).abs() <= 1e-14, "{n} {i}");
            }
            let mut below = vec![1; n + 2];
            for i in 1..=n {
                below[i] = row[i - 1] + row[i];
            }
            row = below;
        }
        assert!(half_binomial(100_000).iter().all(|p| p.is_finite()));
    }

    #[test]
    fn never_is_a_value_and_nothing_has_no_median() {
        let sample = [3.0, f64::INFINITY, 1.0, 2.0, f64::INFINITY, 0.0];
        let all = MedianBetween::of(&sample, 0.95).unwrap();
        assert_eq!((all.median, all.low, all.high), (2.5, 0.0, f64::INFINITY));
        assert_eq!(MedianBetween::of(&[], 0.95), None);
    }

    proptest! {
        /// Of all 2ⁿ ways in which n values may lie about the true median, the share in which the interval misses it.
        #[test]
        fn it_misses_no_more_often_than_it_says(n in 1..13_usize, percent in 50..99_u32) {
            let confidence = f64::from(percent) / 100.0;
            let (mut hits, mut said) = (0, 0.0);
            for below in 0..1_u32 << n {
                let side = |i: usize| if below >> i & 1 == 1 { -1.0 } else { 1.0 };
                let sample: Vec<f64> = (0..n).map(|i| side(i) * (i + 1) as f64).collect();
                let found = MedianBetween::of(&sample, confidence).unwrap();
                hits += u32::from(found.low <= 0.0 && 0.0 <= found.high);
                said = found.confidence;
                prop_assert!(found.low <= found.median && found.median <= found.high);
            }
            let share = f64::from(hits) / f64::from(1_u32 << n);
            prop_assert!((share - said).abs() < 1e-12, "{} {}", share, said);
            let enough = said >= confidence || n < 13 && 1.0 - 0.5_f64.powi(n as i32 - 1) < confidence;
            prop_assert!(enough, "{} of {}", said, confidence);
        }
    }
}
