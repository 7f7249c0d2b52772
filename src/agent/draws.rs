//! Draws from distributions, the same bits on every processor.

use rand::{Rng, RngExt};

/// Uniform in (0, 1).
fn positive_uniform(rng: &mut impl Rng) -> f64 {
    loop {
        let draw: f64 = rng.random();
        if draw > 0.0 {
            return draw;
        }
    }
}

/// From the normal distribution with mean 0 and variance 1, by the polar method (Marsaglia & Bray 1964).
pub(crate) fn normal(rng: &mut impl Rng) -> f64 {
    loop {
        let (x, y) = (
            2.0 * rng.random::<f64>() - 1.0,
            2.0 * rng.random::<f64>() - 1.0,
        );
        let square = x * x + y * y;
        if square > 0.0 && square < 1.0 {
            return x * (-2.0 * libm::log(square) / square).sqrt();
        }
    }
}

/// From the gamma distribution with this `shape` > 0 and scale 1 (Marsaglia & Tsang 2000). Where the shape is much less than
/// 1, most draws are too small to be told from 0.
pub(crate) fn gamma(shape: f64, rng: &mut impl Rng) -> f64 {
    if shape < 1.0 {
        // Γ(a) = Γ(a + 1) U^(1/a)
        let uniform = positive_uniform(rng);
        return gamma(shape + 1.0, rng) * libm::pow(uniform, 1.0 / shape);
    }
    let d = shape - 1.0 / 3.0;
    let c = 1.0 / (9.0 * d).sqrt();
    loop {
        let x = normal(rng);
        let root = 1.0 + c * x;
        if root <= 0.0 {
            continue;
        }
        let v = root * root * root;
        let bound = 0.5 * x * x + d - d * v + d * libm::log(v);
        if libm::log(positive_uniform(rng)) < bound {
            return d * v;
        }
    }
}

/// Writes a draw from the Dirichlet distribution with these parameters > 0, one of them at least 1, in their place.
pub(crate) fn dirichlet(parameters: &mut [f64], rng: &mut impl Rng) {
    for parameter in parameters.iter_mut() {
        *parameter = gamma(*parameter, rng);
    }
    let total: f64 = parameters.iter().sum();
    parameters.iter_mut().for_each(|share| *share /= total);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seeds::{Stream, stream};

    const DRAWS: usize = 40_000;

    fn mean_and_variance(draws: impl Iterator<Item = f64>) -> (f64, f64) {
        let draws: Vec<f64> = draws.take(DRAWS).collect();
        let mean = draws.iter().sum::<f64>() / DRAWS as f64;
        let squares = draws.iter().map(|draw| (draw - mean) * (draw - mean));
        (mean, squares.sum::<f64>() / DRAWS as f64)
    }

    /// A mean of 40 000 draws is off by less than five of its standard deviations; a variance, by less than a tenth.
    #[track_caller]
    fn assert_moments((mean, variance): (f64, f64), expected: (f64, f64)) {
        let spread = 5.0 * (expected.1 / DRAWS as f64).sqrt();
        assert!((mean - expected.0).abs() < spread, "mean {mean}");
        assert!((variance / expected.1 - 1.0).abs() < 0.1, "{variance}");
    }

    #[test]
    fn normal_and_gamma_draws_have_the_moments_of_the_textbook() {
        let mut rng = stream(1, Stream::Agent);
        let draws = std::iter::from_fn(|| Some(normal(&mut rng)));
        assert_moments(mean_and_variance(draws), (0.0, 1.0));
        for shape in [0.3, 1.0, 2.5, 40.0] {
            let draws = std::iter::from_fn(|| Some(gamma(shape, &mut rng)));
            assert_moments(mean_and_variance(draws), (shape, shape));
        }
    }

    /// With a₀ = Σ a: mean a_i / a₀ and variance a_i (a₀ − a_i) / (a₀² (a₀ + 1)).
    #[test]
    fn dirichlet_draws_have_the_moments_of_the_textbook() {
        let parameters = [3.0, 1.0, 0.5];
        let total: f64 = parameters.iter().sum();
        let mut rng = stream(2, Stream::Agent);
        let draws: Vec<[f64; 3]> = (0..DRAWS)
            .map(|_| {
                let mut draw = parameters;
                dirichlet(&mut draw, &mut rng);
                assert!((draw.iter().sum::<f64>() - 1.0).abs() < 1e-12);
                draw
            })
            .collect();
        for (i, a) in parameters.into_iter().enumerate() {
            let variance = a * (total - a) / (total * total * (total + 1.0));
            let found = mean_and_variance(draws.iter().map(|draw| draw[i]));
            assert_moments(found, (a / total, variance));
        }
    }

    /// P(X ≤ t) by the closed form of the gamma distribution of shape 1, 1 − exp(−t), and of shape 2, 1 − (1 + t) exp(−t).
    #[test]
    fn gamma_draws_have_the_shape_of_the_textbook() {
        let mut rng = stream(3, Stream::Agent);
        for t in [0.1, 0.7, 2.0, 5.0f64] {
            for (shape, expected) in [(1.0, 1.0 - (-t).exp()), (2.0, 1.0 - (1.0 + t) * (-t).exp())]
            {
                let below = (0..DRAWS).filter(|_| gamma(shape, &mut rng) <= t).count();
                let share = below as f64 / DRAWS as f64;
                assert!((share - expected).abs() < 0.0125, "{share} {expected}");
            }
        }
    }
}
