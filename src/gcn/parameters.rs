//! The parameters of the two layers as one plain value: weights, gradients and Adam's moments alike.

use super::{GcnError, GraphConv};
use serde::{Deserialize, Serialize};

/// W0, b0, W1, b1. What a checkpoint stores and what is carried from one graph to another.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GcnParameters {
    /// W0 (features × hidden units) and b0.
    pub hidden: GraphConv,
    /// W1 (hidden units × outputs) and b1.
    pub output: GraphConv,
}

/// ∂loss/∂parameters: one number for each parameter, in the same places.
pub type GcnGradient = GcnParameters;

impl GcnParameters {
    /// The same shape, all zero.
    pub fn zeros_like(&self) -> Self {
        Self {
            hidden: self.hidden.zeros_like(),
            output: self.output.zeros_like(),
        }
    }

    /// Every number, in the order W0, b0, W1, b1.
    pub fn slices(&self) -> impl Iterator<Item = &[f64]> {
        self.hidden.slices().chain(self.output.slices())
    }

    /// Mutable twin of [`GcnParameters::slices`].
    pub fn slices_mut(&mut self) -> impl Iterator<Item = &mut [f64]> {
        self.hidden.slices_mut().chain(self.output.slices_mut())
    }

    /// Number of parameters.
    pub fn count(&self) -> usize {
        self.slices().map(<[f64]>::len).sum()
    }

    /// Whether no number is NaN or infinite.
    pub fn is_finite(&self) -> bool {
        self.slices().flatten().all(|value| value.is_finite())
    }

    /// Whether the layers fit together and their lengths agree with their shapes.
    ///
    /// # Errors
    /// [`GcnError::LayerShape`] or [`GcnError::LayerMismatch`].
    pub fn check(&self) -> Result<(), GcnError> {
        self.hidden.check("hidden")?;
        self.output.check("output")?;
        if self.hidden.outputs != self.output.inputs {
            return Err(GcnError::LayerMismatch {
                hidden: self.hidden.outputs,
                inputs: self.output.inputs,
            });
        }
        Ok(())
    }

    /// Whether `other` has the same shape.
    pub fn same_shape(&self, other: &Self) -> bool {
        self.hidden.same_shape(&other.hidden) && self.output.same_shape(&other.output)
    }

    pub(super) fn fill(&mut self, value: f64) {
        self.slices_mut().for_each(|slice| slice.fill(value));
    }

    pub(super) fn accumulate(&mut self, other: &Self) {
        self.hidden.accumulate(&other.hidden);
        self.output.accumulate(&other.output);
    }
}
