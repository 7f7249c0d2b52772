//! One graph convolution, Y = T̂ X W + b.
//!
//! T̂(XW) = (T̂X)W, so a layer keeps only what acts on rows: X W (inputs → outputs) and b. The model puts T̂
//! on whichever side has fewer columns, and adds b after it (T̂1 ≠ 1). With G = ∂loss/∂Y and P = T̂G:
//!
//! ```text
//! ∂W = Xᵀ P    ∂b = column sums of G    ∂X = P Wᵀ
//! ```

use super::GcnError;
use super::dense::multiply;
use super::rows::{view, view_mut};
use faer::{Accum, MatMut, MatRef};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Weight and optional bias of a layer: a plain value. Gradients and Adam's moments have the same form.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GraphConv {
    /// Columns of X, rows of W.
    pub inputs: usize,
    /// Columns of Y and of W.
    pub outputs: usize,
    /// W, inputs × outputs, row by row.
    pub weight: Vec<f64>,
    /// b, one entry per output.
    pub bias: Option<Vec<f64>>,
}

impl GraphConv {
    /// W uniform in ±√(6 / (inputs + outputs)) (Glorot & Bengio 2010, as Kipf & Welling), b = 0 if `bias`.
    pub fn glorot(inputs: usize, outputs: usize, bias: bool, rng: &mut ChaCha8Rng) -> Self {
        let limit = (6.0 / (inputs + outputs) as f64).sqrt();
        Self {
            inputs,
            outputs,
            weight: (0..inputs * outputs)
                .map(|_| rng.random_range(-limit..limit))
                .collect(),
            bias: bias.then(|| vec![0.0; outputs]),
        }
    }

    /// A layer of the same shape, all zero.
    pub fn zeros_like(&self) -> Self {
        let mut zeros = self.clone();
        zeros.fill(0.0);
        zeros
    }

    /// W as an inputs × outputs matrix.
    pub fn weight(&self) -> MatRef<'_, f64> {
        MatRef::from_row_major_slice(&self.weight, self.inputs, self.outputs)
    }

    /// Every number of the layer: W, then b.
    pub fn slices(&self) -> impl Iterator<Item = &[f64]> {
        [Some(self.weight.as_slice()), self.bias.as_deref()]
            .into_iter()
            .flatten()
    }

    /// Mutable twin of [`GraphConv::slices`].
    pub fn slices_mut(&mut self) -> impl Iterator<Item = &mut [f64]> {
        [Some(self.weight.as_mut_slice()), self.bias.as_deref_mut()]
            .into_iter()
            .flatten()
    }

    /// Sets W and b to `value`.
    pub(super) fn fill(&mut self, value: f64) {
        self.slices_mut().for_each(|slice| slice.fill(value));
    }

    /// Appends zero rows to W: the layer's output is unchanged whatever the new inputs hold.
    ///
    /// # Panics
    /// If `inputs` is smaller than at present.
    pub fn grow_inputs(&mut self, inputs: usize) {
        assert!(
            inputs >= self.inputs,
            "a layer of {} inputs cannot shrink to {inputs}",
            self.inputs
        );
        self.inputs = inputs;
        self.weight.resize(inputs * self.outputs, 0.0);
    }

    /// Whether the lengths agree with the shape and the layer has an output.
    pub(super) fn check(&self, layer: &'static str) -> Result<(), GcnError> {
        let bias = self.bias.as_ref().map_or(self.outputs, Vec::len);
        let weight = self.inputs.checked_mul(self.outputs);
        if self.outputs == 0 || bias != self.outputs || weight != Some(self.weight.len()) {
            return Err(GcnError::LayerShape {
                layer,
                inputs: self.inputs,
                outputs: self.outputs,
                weights: self.weight.len(),
                biases: bias,
            });
        }
        Ok(())
    }

    /// Whether `other` has the same shape.
    pub(super) fn same_shape(&self, other: &Self) -> bool {
        let shape = |layer: &Self| (layer.inputs, layer.outputs, layer.bias.is_some());
        shape(self) == shape(other)
    }

    /// `y` ← X W for the rows of `x`; `y` row-major.
    pub(super) fn project(&self, x: MatRef<'_, f64>, y: &mut [f64]) {
        let y = view_mut(y, self.outputs);
        multiply(y, Accum::Replace, x, self.weight());
    }

    /// `y` += b on every row.
    pub(super) fn add_bias(&self, y: &mut [f64]) {
        if let Some(bias) = &self.bias {
            for row in y.chunks_exact_mut(self.outputs) {
                add(row, bias);
            }
        }
    }

    /// `x` ← P Wᵀ for the row-major rows `p`.
    pub(super) fn pull_back(&self, p: &[f64], x: &mut [f64]) {
        let (p, x) = (view(p, self.outputs), view_mut(x, self.inputs));
        multiply(x, Accum::Replace, p, self.weight().transpose());
    }

    /// On a gradient: ∂W += Xᵀ P for the rows of `x` and the row-major rows `p`.
    pub(super) fn accumulate_weight(&mut self, x: MatRef<'_, f64>, p: &[f64]) {
        let p = view(p, self.outputs);
        let weight = MatMut::from_row_major_slice_mut(&mut self.weight, self.inputs, self.outputs);
        multiply(weight, Accum::Add, x.transpose(), p);
    }

    /// On a gradient: ∂b += column sums of the row-major rows `g`, if the layer has a bias.
    pub(super) fn accumulate_bias(&mut self, g: &[f64]) {
        if let Some(bias) = &mut self.bias {
            for row in g.chunks_exact(self.outputs) {
                add(bias, row);
            }
        }
    }

    /// Adds another layer of the same shape, entry by entry.
    pub(super) fn accumulate(&mut self, other: &Self) {
        for (target, source) in self.slices_mut().zip(other.slices()) {
            add(target, source);
        }
    }
}

fn add(target: &mut [f64], source: &[f64]) {
    for (target, source) in target.iter_mut().zip(source) {
        *target += source;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seeds::{Stream, stream};

    #[test]
    fn glorot_weights_fill_their_interval_and_repeat() {
        let draw = |seed| GraphConv::glorot(40, 20, true, &mut stream(seed, Stream::Gcn));
        let layer = draw(3);
        let limit = 0.1f64.sqrt(); // 6 / (40 + 20)
        let largest = layer.weight.iter().fold(0.0f64, |m, w| m.max(w.abs()));
        assert!(largest < limit && largest > 0.95 * limit);
        let mean = layer.weight.iter().sum::<f64>() / 800.0;
        // Standard error: limit / √3 / √800 = 0.0065.
        assert!(mean.abs() < 0.03, "mean {mean}");
        assert_eq!(layer.bias, Some(vec![0.0; 20]));
        assert_eq!(layer, draw(3));
        assert_ne!(layer, draw(4));
    }

    #[test]
    fn shapes_that_disagree_are_refused() {
        let good = GraphConv::glorot(3, 2, true, &mut stream(0, Stream::Gcn));
        assert!(good.check("hidden").is_ok());
        let short = GraphConv {
            weight: vec![0.0; 5],
            ..good.clone()
        };
        let empty = GraphConv {
            outputs: 0,
            weight: vec![],
            bias: None,
            ..good.clone()
        };
        let bias = GraphConv {
            bias: Some(vec![0.0; 3]),
            ..good
        };
        for bad in [short, empty, bias] {
            let error = bad.check("hidden").unwrap_err();
            assert!(matches!(error, GcnError::LayerShape { .. }), "{error}");
        }
    }
}
