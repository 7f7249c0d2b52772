//! Misfit between V and the returns that the agent has had, at a sample of states.
//!
//! ```text
//! misfit = mean_{i ∈ Y} x_i²,   x_i = (V_i − G_i) / (|G_i| + r̄)
//! ∂misfit/∂V_i = 2 x_i / ((|G_i| + r̄) |Y|)
//! ```
//!
//! r̄, the cost of a typical step, keeps states next to an end from counting beyond measure.

/// Y with its returns.
#[derive(Clone, Debug)]
pub(super) struct Misfit {
    /// (position, G, |G| + r̄).
    labels: Vec<(usize, f64, f64)>,
}

impl Misfit {
    /// `labels`: positions, and returns there.
    pub fn new(labels: Vec<(usize, f64)>, step_reward: f64) -> Self {
        let labels = labels.into_iter();
        Self {
            labels: labels.map(|(i, g)| (i, g, g.abs() + step_reward)).collect(),
        }
    }

    /// The misfit of `v` (by position); `gradient` (by position) becomes its derivative. 0 without labels.
    pub fn evaluate(&self, v: &[f64], gradient: &mut [f64]) -> f64 {
        gradient.fill(0.0);
        let count = self.labels.len().max(1) as f64;
        let mut total = 0.0;
        for &(i, label, scale) in &self.labels {
            let error = (v[i] - label) / scale;
            total += error * error;
            gradient[i] = 2.0 * error / scale / count;
        }
        total / count
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivative_agrees_with_finite_differences() {
        let labels = (0..6).map(|i| (2 * i, 1.3 * i as f64 - 4.0)).collect();
        let misfit = Misfit::new(labels, 0.5);
        let v: Vec<f64> = (0..12).map(|i| 2.0 + (i as f64 * 1.7).sin()).collect();
        let mut gradient = vec![7.0; 12];
        assert!(misfit.evaluate(&v, &mut gradient) > 0.1);
        for i in 0..12 {
            let shifted = |step: f64| {
                let mut v = v.clone();
                v[i] += step;
                misfit.evaluate(&v, &mut [0.0; 12])
            };
            let expected = (shifted(1e-6) - shifted(-1e-6)) / 2e-6;
            assert!((gradient[i] - expected).abs() < 1e-9, "{i}");
        }
    }

    #[test]
    fn without_labels_there_is_nothing_to_learn() {
        let mut gradient = [1.0; 3];
        assert_eq!(
            Misfit::new(vec![], 1.0).evaluate(&[1.0; 3], &mut gradient),
            0.0
        );
        assert_eq!(gradient, [0.0; 3]);
    }
}
