//! Adam with bias correction (Kingma & Ba, "Adam: A Method for Stochastic Optimization", ICLR 2015, Algorithm 1).
//!
//! ```text
//! m ← β1 m + (1 − β1) g      v ← β2 v + (1 − β2) g²
//! θ ← θ − α / (1 − β1ᵗ) · m / (√(v / (1 − β2ᵗ)) + ε)
//! ```

use super::{Gcn, GcnError, GcnGradient, GcnParameters};
use serde::{Deserialize, Serialize};

/// Decay of the mean of gradients; the paper's and PyTorch's default.
const BETA1: f64 = 0.9;
/// Decay of the mean of squared gradients; the paper's and PyTorch's default.
const BETA2: f64 = 0.999;
/// Keeps the division finite; the paper's and PyTorch's default.
const EPSILON: f64 = 1e-8;

/// The optimiser of one network, with its state: a plain value that a checkpoint can hold.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Adam {
    /// α, above 0. May be changed between steps.
    pub learning_rate: f64,
    /// t, steps taken.
    steps: u64,
    /// m, the running mean of gradients.
    first_moment: GcnParameters,
    /// v, the running mean of their squares.
    second_moment: GcnParameters,
}

impl Adam {
    /// An optimiser for networks of the shape of `gcn`; β1 = 0.9, β2 = 0.999, ε = 1e-8.
    pub fn new(gcn: &Gcn, learning_rate: f64) -> Self {
        let zeros = gcn.parameters().zeros_like();
        Self {
            learning_rate,
            steps: 0,
            first_moment: zeros.clone(),
            second_moment: zeros,
        }
    }

    /// Steps taken so far.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// One step against `gradient`.
    ///
    /// # Panics
    /// If the gradient, the network and the moments differ in shape (see [`Adam::check`]).
    pub fn step(&mut self, gcn: &mut Gcn, gradient: &GcnGradient) {
        self.check(gcn).expect("moments of the network's shape");
        assert!(
            gradient.same_shape(gcn.parameters()),
            "gradient of another shape"
        );
        self.steps += 1;
        let rate = self.learning_rate / (1.0 - libm::pow(BETA1, self.steps as f64));
        let root = (1.0 - libm::pow(BETA2, self.steps as f64)).sqrt();
        let moments = self
            .first_moment
            .slices_mut()
            .flatten()
            .zip(self.second_moment.slices_mut().flatten());
        let parameters = gcn.parameters_mut().slices_mut().flatten();
        for ((theta, g), (m, v)) in parameters.zip(gradient.slices().flatten()).zip(moments) {
            *m += (1.0 - BETA1) * (g - *m);
            *v = BETA2 * *v + (1.0 - BETA2) * g * g;
            *theta -= rate * *m / (v.sqrt() / root + EPSILON);
        }
    }

    /// Appends zero moments for new input features; goes with [`Gcn::grow_inputs`].
    ///
    /// # Panics
    /// If `features` is smaller than at present.
    pub fn grow_inputs(&mut self, features: usize) {
        self.first_moment.hidden.grow_inputs(features);
        self.second_moment.hidden.grow_inputs(features);
    }

    /// Whether the state belongs to a network of the shape of `gcn`: to be asked after reading both from a file.
    ///
    /// # Errors
    /// [`GcnError::OptimizerShape`] if not.
    pub fn check(&self, gcn: &Gcn) -> Result<(), GcnError> {
        let fits =
            |moment: &GcnParameters| moment.same_shape(gcn.parameters()) && moment.check().is_ok();
        if fits(&self.first_moment) && fits(&self.second_moment) {
            return Ok(());
        }
        Err(GcnError::OptimizerShape {
            moments: self.first_moment.count(),
            parameters: gcn.parameters().count(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seeds::{Stream, stream};

    fn network() -> Gcn {
        Gcn::new(2, 3, 1, true, &mut stream(1, Stream::Gcn))
    }

    /// At t = 1 the corrections cancel the decays: each parameter moves by α sign(g).
    #[test]
    fn the_first_step_has_the_length_of_the_learning_rate() {
        let mut gcn = network();
        let before = gcn.clone();
        let mut gradient = gcn.parameters().zeros_like();
        for (i, g) in gradient.slices_mut().flatten().enumerate() {
            *g = if i % 2 == 0 { 1e3 } else { -1e-3 };
        }
        Adam::new(&gcn, 0.25).step(&mut gcn, &gradient);
        let after = gcn.parameters().slices().flatten();
        for (i, (after, before)) in after
            .zip(before.parameters().slices().flatten())
            .enumerate()
        {
            let expected = if i % 2 == 0 { -0.25 } else { 0.25 };
            assert!((after - before - expected).abs() < 1e-5, "parameter {i}");
        }
    }

    #[test]
    fn the_state_survives_json() {
        let mut gcn = network();
        let mut adam = Adam::new(&gcn, 0.01);
        let gradient = gcn.parameters().clone();
        adam.step(&mut gcn, &gradient);
        let json = serde_json::to_string(&adam).unwrap();
        let back: Adam = serde_json::from_str(&json).unwrap();
        assert_eq!((back.steps(), back.check(&gcn)), (1, Ok(())));
        // Without its feature `float_roundtrip` serde_json may miss the last bit.
        let moments = adam.first_moment.slices().flatten();
        for (a, b) in moments.zip(back.first_moment.slices().flatten()) {
            assert!((a - b).abs() <= f64::EPSILON * a.abs());
        }
    }

    #[test]
    fn state_of_another_network_is_refused() {
        let other = Gcn::new(3, 3, 1, true, &mut stream(1, Stream::Gcn));
        let error = Adam::new(&other, 0.01).check(&network()).unwrap_err();
        assert!(matches!(
            error,
            GcnError::OptimizerShape {
                moments: 16,
                parameters: 13
            }
        ));
    }
}
