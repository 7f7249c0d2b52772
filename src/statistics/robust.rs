//! Statistics of a handful of runs, robust to the odd one that fell off a cliff.
//!
//! ```text
//! IQM(x)      = mean of x without its ⌊n/4⌋ smallest and ⌊n/4⌋ largest values
//! [low, high] = 2.5 % and 97.5 % quantile of the statistic over resamples of x with replacement
//! P(X better) = mean over all pairs (x, y) of  1 if x < y,  ½ if x = y,  0 if x > y        (less is better)
//! ```
//!
//! The last one is the Mann–Whitney U statistic ÷ (n m). Where runs belong to several tasks, each task is resampled
//! by itself (a stratified bootstrap), since the spread between tasks is no uncertainty.
//!
//! Sources: R. Agarwal, M. Schwarzer, P. S. Castro, A. Courville, M. G. Bellemare, *Deep reinforcement learning at the
//! edge of the statistical precipice*, NeurIPS 2021 · B. Efron, *Bootstrap methods: another look at the jackknife*,
//! Ann. Statist. 7 (1979) · H. B. Mann, D. R. Whitney, *On a test of whether one of two random variables is
//! stochastically larger than the other*, Ann. Math. Statist. 18 (1947). Quantiles interpolate linearly between order
//! statistics (type 7 of R. J. Hyndman, Y. Fan, *Sample quantiles in statistical packages*, 1996).

use crate::seeds::{Stream, stream};
use rand::RngExt;
use serde::{Deserialize, Serialize};

/// A statistic with the ends of its 95 % bootstrap interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    /// The statistic of the sample itself.
    pub value: f64,
    /// 2.5 % quantile over resamples.
    pub low: f64,
    /// 97.5 % quantile over resamples.
    pub high: f64,
}

/// Mean of the middle half: without the ⌊n/4⌋ smallest and largest values (`scipy.stats.trim_mean(x, 0.25)`). NaN for
/// none. O(n log n).
pub fn interquartile_mean(sample: &[f64]) -> f64 {
    let sorted = sorted(sample);
    let cut = sorted.len() / 4;
    mean(&sorted[cut..sorted.len() - cut])
}

/// The middle value, or the mean of the two; NaN for none. Infinite values are values: the median of 1, 2, ∞ is 2.
pub fn median(sample: &[f64]) -> f64 {
    quantile(&sorted(sample), 0.5)
}

/// The `p` quantile of an ascending sample, linear between order statistics; NaN for none.
///
/// # Panics
/// If `p` is not in 0..=1.
pub fn quantile(sorted: &[f64], p: f64) -> f64 {
    assert!((0.0..=1.0).contains(&p), "the quantile of {p}");
    let Some(last) = sorted.len().checked_sub(1) else {
        return f64::NAN;
    };
    let at = p * last as f64;
    let (below, above) = (sorted[at.floor() as usize], sorted[at.ceil() as usize]);
    let share = at - at.floor();
    // Equal ends need no mixing, and ∞ − ∞ would be NaN.
    if below == above || share == 0.0 {
        below
    } else {
        below + share * (above - below)
    }
}

/// The chance that a run of `ours` has less than a run of `theirs`, ties counting half; NaN if one is empty. O(n m).
pub fn probability_of_improvement(ours: &[f64], theirs: &[f64]) -> f64 {
    let wins = |x: &f64| -> f64 {
        let against = |y: &f64| match x.partial_cmp(y) {
            Some(std::cmp::Ordering::Less) => 1.0,
            Some(std::cmp::Ordering::Equal) => 0.5,
            _ => 0.0,
        };
        theirs.iter().map(against).sum()
    };
    ours.iter().map(wins).sum::<f64>() / (ours.len() * theirs.len()) as f64
}

/// Number and seed of resamples. Equal values give equal intervals, whoever calls when.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bootstrap {
    /// Number of resamples; at least 1.
    pub resamples: usize,
    /// Master seed.
    pub seed: u64,
}

impl Default for Bootstrap {
    /// 5 000 resamples: the ends are then known to about a fiftieth of the interval's width.
    fn default() -> Self {
        Self {
            resamples: 5_000,
            seed: 0,
        }
    }
}

impl Bootstrap {
    /// Percentile interval of a statistic of one sample. O(resamples × cost of the statistic).
    pub fn interval(&self, sample: &[f64], statistic: impl Fn(&[f64]) -> f64) -> Interval {
        self.stratified(&[sample], |strata| statistic(&strata[0]))
    }

    /// Percentile interval of a statistic of several samples, each resampled by itself to its own size.
    pub fn stratified(
        &self,
        strata: &[&[f64]],
        statistic: impl Fn(&[Vec<f64>]) -> f64,
    ) -> Interval {
        let mut rng = stream(self.seed, Stream::Bootstrap);
        let mut drawn: Vec<Vec<f64>> = strata.iter().map(|s| s.to_vec()).collect();
        let value = statistic(&drawn);
        let mut values: Vec<f64> = (0..self.resamples)
            .map(|_| {
                for (into, from) in drawn.iter_mut().zip(strata) {
                    into.iter_mut()
                        .for_each(|x| *x = from[rng.random_range(0..from.len())]);
                }
                statistic(&drawn)
            })
            .collect();
        values.sort_unstable_by(f64::total_cmp);
        Interval {
            value,
            low: quantile(&values, 0.025),
            high: quantile(&values, 0.975),
        }
    }
}

fn sorted(sample: &[f64]) -> Vec<f64> {
    let mut sorted = sample.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    sorted
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// By hand.
    #[test]
    fn fixed_vectors() {
        assert_eq!(interquartile_mean(&[5.0]), 5.0);
        assert_eq!(interquartile_mean(&[1.0, 2.0, 9.0]), 4.0);
        assert_eq!(interquartile_mean(&[100.0, 1.0, 3.0, 2.0]), 2.5);
        // ⌊10/4⌋ = 2 from each end leaves 3, 4, 5, 6, 7, 8.
        let ten = [9.0, 1.0, 8.0, 2.0, 7.0, 3.0, 6.0, 4.0, 5.0, 1000.0];
        assert_eq!(interquartile_mean(&ten), 5.5);
        assert!(interquartile_mean(&[]).is_nan());
        assert_eq!(median(&[4.0, 1.0, 3.0, 2.0]), 2.5);
        assert_eq!(median(&[3.0, f64::INFINITY, 1.0]), 3.0);
        assert_eq!(
            median(&[f64::INFINITY, f64::INFINITY, 1.0, f64::INFINITY]),
            f64::INFINITY
        );
        // p = .1 lies at 0.4 between the first two, p = .3 at 1.2, p = .975 at 3.9.
        let powers = [1.0, 2.0, 4.0, 8.0, 16.0];
        for (p, expected) in [(0.1, 1.4), (0.3, 2.4), (0.975, 15.2)] {
            assert!((quantile(&powers, p) - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn improvement_counts_pairs() {
        let (ours, theirs) = ([1.0, 2.0, 3.0], [3.0, 4.0, 1.5]);
        // 1 beats all three; 2 beats 3 and 4; 3 ties with 3 and beats 4: 3 + 2 + 1.5 of 9.
        assert_eq!(probability_of_improvement(&ours, &theirs), 6.5 / 9.0);
        assert_eq!(probability_of_improvement(&theirs, &ours), 2.5 / 9.0);
        assert_eq!(probability_of_improvement(&[1.0], &[2.0, 3.0]), 1.0);
    }

    /// The mean of n resampled values has the variance σ²/n, whatever the sample: the interval of the mean must be
    /// about 2 · 1.96 · σ/√n wide.
    #[test]
    fn the_interval_of_a_mean_is_as_wide_as_theory_says() {
        let sample: Vec<f64> = (0..400).map(|i| f64::from(i % 20)).collect();
        let interval = Bootstrap::default().interval(&sample, mean);
        let deviation = ((20.0 * 20.0 - 1.0) / 12.0_f64).sqrt(); // of 0 … 19, each equally often
        let width = 2.0 * 1.96 * deviation / 20.0;
        assert_eq!(interval.value, 9.5);
        let found = interval.high - interval.low;
        assert!(
            (found / width - 1.0).abs() < 0.05,
            "{found} against {width}"
        );
    }

    #[test]
    fn strata_are_resampled_by_themselves() {
        // Far apart from each other, constant within: nothing is uncertain.
        let strata: [&[f64]; 2] = [&[1.0; 5], &[1000.0; 7]];
        let pooled = |s: &[Vec<f64>]| mean(&s.concat());
        let interval = Bootstrap::default().stratified(&strata, pooled);
        assert_eq!(interval.low, interval.high);
        assert_eq!(interval.value, (5.0 + 7000.0) / 12.0);
        let together = Bootstrap::default().interval(&strata.concat(), mean);
        assert!(together.high - together.low > 100.0);
    }

    #[test]
    fn intervals_repeat() {
        let sample = [3.0, 1.0, 4.0, 1.0, 5.0, 9.0, 2.0, 6.0];
        let interval = |seed| {
            Bootstrap {
                seed,
                ..Bootstrap::default()
            }
            .interval(&sample, median)
        };
        assert_eq!(interval(1), interval(1));
    }

    proptest! {
        #[test]
        fn the_interval_holds_the_statistic_and_shrinks(
            sample in prop::collection::vec(-100.0_f64..100.0, 6..20),
        ) {
            let bootstrap = Bootstrap { resamples: 2000, seed: 3 };
            let few = bootstrap.interval(&sample, mean);
            prop_assert!(few.low <= few.value && few.value <= few.high, "{few:?}");
            let many = bootstrap.interval(&sample.repeat(9), mean);
            let ratio = (many.high - many.low) / (few.high - few.low);
            // Nine times the sample: a third of the width, up to the noise of 2 000 resamples.
            prop_assert!((0.25..0.42).contains(&ratio), "{ratio}");
        }

        #[test]
        fn improvement_is_antisymmetric_and_fair(
            ours in prop::collection::vec(-5_i8..5, 1..12),
            theirs in prop::collection::vec(-5_i8..5, 1..12),
        ) {
            let real = |v: &[i8]| v.iter().map(|&x| f64::from(x)).collect::<Vec<_>>();
            let (x, y) = (real(&ours), real(&theirs));
            let sum = probability_of_improvement(&x, &y) + probability_of_improvement(&y, &x);
            prop_assert!((sum - 1.0).abs() < 1e-12);
            prop_assert!((probability_of_improvement(&x, &x) - 0.5).abs() < 1e-12);
        }

        #[test]
        fn trimming_stays_within_the_sample(sample in prop::collection::vec(-1e6_f64..1e6, 1..40)) {
            let ordered = sorted(&sample);
            let iqm = interquartile_mean(&sample);
            let slack = 1e-9 * ordered[ordered.len() - 1].abs().max(ordered[0].abs());
            prop_assert!(iqm >= ordered[0] - slack && iqm <= ordered[ordered.len() - 1] + slack);
        }
    }
}
