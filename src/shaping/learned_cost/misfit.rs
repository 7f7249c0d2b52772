//! Misfit between v and the shape of the cost-to-go, at a sample of states.
//!
//! ```text
//! misfit = mean_{i ∈ Y} (a v_i / d_i − 1)²,   a = Σ x_i / Σ x_i²,  x_i = v_i / d_i
//! ∂misfit/∂v_i = 2 a (a x_i − 1) / (d_i |Y|)
//! ```
//!
//! Only the shape of v counts, since φ is scaled afterwards, so a is the best factor for the v at hand; at its optimum
//! the derivative through a vanishes.

/// Y with its cost-to-go.
#[derive(Clone, Debug)]
pub(super) struct Misfit {
    /// (position, d > 0).
    labels: Vec<(usize, f64)>,
}

impl Misfit {
    /// `positions` are those of states past the goals, `distances` by position.
    pub fn new(positions: Vec<usize>, distances: &[f64]) -> Self {
        let labels = positions.into_iter().map(|i| (i, distances[i])).collect();
        Self { labels }
    }

    /// The misfit of `v` (by position); `gradient` (by position) becomes its derivative. 0 without labels.
    pub fn evaluate(&self, v: &[f64], gradient: &mut [f64]) -> f64 {
        gradient.fill(0.0);
        if self.labels.is_empty() {
            return 0.0;
        }
        let ratios = self.labels.iter().map(|&(i, d)| v[i] / d);
        let (sum, squares) = ratios.fold((0.0, 0.0), |(s, q), x| (s + x, q + x * x));
        let factor = sum / squares;
        let count = self.labels.len() as f64;
        let mut total = 0.0;
        for &(i, d) in &self.labels {
            let error = factor * v[i] / d - 1.0;
            total += error * error;
            gradient[i] = 2.0 * error * factor / d / count;
        }
        total / count
    }
}
