//! Curves over seeds with their 95 % intervals: means x̄ ± t₀.₉₇₅(n − 1) · s / √n, or interquartile means with
//! bootstrap intervals ([`statistics`](crate::statistics)).

use crate::statistics::{Bootstrap, interquartile_mean};
use rayon::prelude::*;
use serde::Serialize;

/// A curve with its band; the band has no width where there is one seed.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Band {
    /// Means, or interquartile means.
    pub middle: Vec<f64>,
    /// Lower ends.
    pub low: Vec<f64>,
    /// Upper ends.
    pub high: Vec<f64>,
}

/// Resamples behind each point of a robust band: its ends are then known to about a twentieth of its width.
const RESAMPLES: usize = 1000;

/// Two-sided 95 % quantiles of Student's t for 1 to 30 degrees of freedom; 1.96 beyond.
const T: [f64; 30] = [
    12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160,
    2.145, 2.131, 2.120, 2.110, 2.101, 2.093, 2.086, 2.080, 2.074, 2.069, 2.064, 2.060, 2.056,
    2.052, 2.048, 2.045, 2.042,
];

/// Mean and interval of one number per seed.
///
/// # Panics
/// If there are no values.
pub fn interval(values: &[f64]) -> (f64, f64, f64) {
    let n = values.len();
    assert!(n > 0, "a mean of nothing");
    let mean = values.iter().sum::<f64>() / n as f64;
    if n == 1 {
        return (mean, mean, mean);
    }
    let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    let error = (squares / (n - 1) as f64 / n as f64).sqrt();
    let half = error * T.get(n - 2).copied().unwrap_or(1.96);
    (mean, mean - half, mean + half)
}

impl Band {
    /// The band over seeds of the curve `value(seed, i)`, i < `len`.
    pub fn over(seeds: usize, len: usize, value: impl Fn(usize, usize) -> f64) -> Self {
        let mut band = Self::default();
        for i in 0..len {
            let values: Vec<f64> = (0..seeds).map(|seed| value(seed, i)).collect();
            let (mean, low, high) = interval(&values);
            band.middle.push(mean);
            band.low.push(low);
            band.high.push(high);
        }
        band
    }

    /// The same with interquartile means and bootstrap intervals, which the odd seed that went astray does not move.
    /// Does not depend on the number of threads. O(`len` × `seeds` log `seeds`), times a thousand.
    ///
    /// # Panics
    /// If `seeds` is 0 and `len` is not.
    pub fn robust(seeds: usize, len: usize, value: impl Fn(usize, usize) -> f64 + Sync) -> Self {
        let bootstrap = Bootstrap {
            resamples: RESAMPLES,
            ..Bootstrap::default()
        };
        let points = (0..len).into_par_iter().map(|i| {
            let values: Vec<f64> = (0..seeds).map(|seed| value(seed, i)).collect();
            let of = bootstrap.interval(&values, interquartile_mean);
            (of.value, (of.low, of.high))
        });
        let (middle, (low, high)) = points.unzip();
        Self { middle, low, high }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_outlier_does_not_move_a_robust_band() {
        let value = |seed: usize, i: usize| if seed == 7 { 1e9 } else { (seed + i) as f64 };
        let band = Band::robust(8, 2, value);
        // ⌊8/4⌋ = 2 from each end of 0 … 6, 10⁹ leaves 2, 3, 4, 5.
        assert_eq!(band.middle, [3.5, 4.5]);
        assert!(band.low[0] < 3.5 && 3.5 < band.high[0]);
    }

    #[test]
    fn the_interval_is_that_of_the_textbook() {
        // s² = 2.5, n = 5: 3 ± 2.776 · √0.5
        let (mean, low, high) = interval(&[1.0, 2.0, 3.0, 4.0, 5.0]);
        assert_eq!(mean, 3.0);
        assert!((high - 4.963).abs() < 1e-3 && (low - 1.037).abs() < 1e-3);
        assert_eq!(interval(&[7.0]), (7.0, 7.0, 7.0));
    }
}
