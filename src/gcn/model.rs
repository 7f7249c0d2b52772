//! Two graph convolutions with a ReLU between them: Z = T̂ relu(T̂X W0 + b0) W1 + b1 (source paper, eq. 5,
//! before its softmax, which belongs to the [loss](super::ClassifierLoss)).
//!
//! With G = ∂loss/∂Z, P = T̂G and H = relu(S), S = T̂X W0 + b0:
//!
//! ```text
//! ∂W1 = Hᵀ P    ∂b1 = Σ_i G_i    ∂S = (P W1ᵀ) ⊙ [S > 0]    ∂W0 = (T̂X)ᵀ ∂S    ∂b0 = Σ_i ∂S_i
//! ```
//!
//! T̂X does not change within a fit, so the caller computes it once; inside, T̂ meets only blocks as wide as
//! the output. Everything between two products with T̂ runs block by block of rows, while they are in cache.

use super::rows::{BLOCK_ROWS, pack, rows_per_lane, view};
use super::workspace::Lane;
use super::{GcnError, GcnGradient, GcnParameters, GcnWorkspace, GraphConv, Propagation};
use faer::MatRef;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// A graph convolutional network of two layers. Its parameters always fit together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "GcnParameters", into = "GcnParameters")]
pub struct Gcn {
    parameters: GcnParameters,
}

impl From<Gcn> for GcnParameters {
    fn from(gcn: Gcn) -> Self {
        gcn.parameters
    }
}

impl TryFrom<GcnParameters> for Gcn {
    type Error = GcnError;

    fn try_from(parameters: GcnParameters) -> Result<Self, GcnError> {
        Self::from_parameters(parameters)
    }
}

impl Gcn {
    /// Glorot-uniform weights (Kipf & Welling 2017), zero biases if `biases`.
    ///
    /// # Panics
    /// If `hidden` or `outputs` is 0.
    pub fn new(
        features: usize,
        hidden: usize,
        outputs: usize,
        biases: bool,
        rng: &mut ChaCha8Rng,
    ) -> Self {
        assert!(hidden > 0, "a network needs a hidden unit");
        assert!(outputs > 0, "a network needs an output");
        Self {
            parameters: GcnParameters {
                hidden: GraphConv::glorot(features, hidden, biases, rng),
                output: GraphConv::glorot(hidden, outputs, biases, rng),
            },
        }
    }

    /// The network with the given parameters, as read from a checkpoint or trained on another graph.
    ///
    /// # Errors
    /// If the layers do not fit together ([`GcnParameters::check`]). Values are not looked at: a NaN is
    /// reported by the next fit.
    pub fn from_parameters(parameters: GcnParameters) -> Result<Self, GcnError> {
        parameters.check()?;
        Ok(Self { parameters })
    }

    /// The present parameters.
    pub fn parameters(&self) -> &GcnParameters {
        &self.parameters
    }

    /// For an optimiser: values may change, shapes may not.
    pub(super) fn parameters_mut(&mut self) -> &mut GcnParameters {
        &mut self.parameters
    }

    /// Columns that X must have.
    pub fn num_features(&self) -> usize {
        self.parameters.hidden.inputs
    }

    /// Hidden units.
    pub fn hidden_dim(&self) -> usize {
        self.parameters.hidden.outputs
    }

    /// Columns of Z.
    pub fn num_outputs(&self) -> usize {
        self.parameters.output.outputs
    }

    /// Sets the last layer to 0, so that the output starts at 0 for every node.
    pub fn zero_output_layer(&mut self) {
        self.parameters.output.fill(0.0);
    }

    /// Widens X to `features` columns, by zero rows of W0: the output stays as it is, and the new rows learn
    /// from the next epoch on. For graphs that had fewer nodes than features were asked for. Call
    /// [`Adam::grow_inputs`](super::Adam::grow_inputs) with it.
    ///
    /// # Panics
    /// If `features` is smaller than at present.
    pub fn grow_inputs(&mut self, features: usize) {
        self.parameters.hidden.grow_inputs(features);
    }

    /// Z = T̂ relu(T̂X W0 + b0) W1 + b1, n × outputs, linear. `tx` is T̂X, n × features, of any strides.
    /// O(n · features · hidden + nnz · outputs); allocates only when the workspace has to grow.
    ///
    /// # Panics
    /// If `tx` has not n rows and [`Gcn::num_features`] columns.
    pub fn forward<'w>(
        &self,
        propagation: &Propagation,
        tx: MatRef<'_, f64>,
        workspace: &'w mut GcnWorkspace,
    ) -> MatRef<'w, f64> {
        self.assert_shape(propagation, tx);
        let output = &self.parameters.output;
        workspace.reserve_forward(tx.nrows(), &self.parameters);
        self.project(tx, &mut workspace.hidden, &mut workspace.projected);
        propagation.apply_rows(&workspace.projected, output.outputs, &mut workspace.logits);
        output.add_bias(&mut workspace.logits);
        view(&workspace.logits, output.outputs)
    }

    /// H and H W1 of every row.
    fn project(&self, tx: MatRef<'_, f64>, hidden: &mut [f64], projected: &mut [f64]) {
        let rows = rows_per_lane(tx.nrows());
        if tx.nrows() <= rows {
            return self.project_lane(tx, hidden, projected);
        }
        hidden
            .par_chunks_mut(rows * self.hidden_dim())
            .zip(projected.par_chunks_mut(rows * self.num_outputs()))
            .enumerate()
            .for_each(|(lane, (hidden, projected))| {
                self.project_lane(lane_rows(tx, lane, rows), hidden, projected);
            });
    }

    fn project_lane(&self, tx: MatRef<'_, f64>, hidden: &mut [f64], projected: &mut [f64]) {
        let GcnParameters {
            hidden: first,
            output: second,
        } = &self.parameters;
        let blocks = hidden
            .chunks_mut(BLOCK_ROWS * first.outputs)
            .zip(projected.chunks_mut(BLOCK_ROWS * second.outputs));
        for (block, (hidden, projected)) in blocks.enumerate() {
            first.project(lane_rows(tx, block, BLOCK_ROWS), hidden);
            first.add_bias(hidden);
            relu(hidden);
            second.project(view(hidden, first.outputs), projected);
        }
    }

    /// Gradient of a loss with ∂loss/∂Z = `output_gradient` (n × outputs), after [`Gcn::forward`] with the same
    /// network, `tx` and workspace. The derivative of the ReLU at 0 is taken as 0, as PyTorch does. May be
    /// called several times after one forward pass. Same cost as two forward passes.
    ///
    /// # Panics
    /// If shapes differ from those of the forward pass.
    pub fn backward(
        &self,
        propagation: &Propagation,
        tx: MatRef<'_, f64>,
        workspace: &mut GcnWorkspace,
        output_gradient: MatRef<'_, f64>,
    ) -> GcnGradient {
        let mut gradient = self.parameters.zeros_like();
        self.backward_into(propagation, tx, workspace, output_gradient, &mut gradient);
        gradient
    }

    /// [`Gcn::backward`] into a gradient that exists already: allocates nothing in a steady state.
    ///
    /// # Panics
    /// If shapes differ from those of the forward pass.
    pub fn backward_into(
        &self,
        propagation: &Propagation,
        tx: MatRef<'_, f64>,
        workspace: &mut GcnWorkspace,
        output_gradient: MatRef<'_, f64>,
        gradient: &mut GcnGradient,
    ) {
        let shape = (tx.nrows(), self.num_outputs());
        assert_eq!(output_gradient.shape(), shape, "output gradient");
        let mut packed = std::mem::take(&mut workspace.output_gradient);
        packed.resize(shape.0 * shape.1, 0.0);
        pack(output_gradient, &mut packed);
        self.backward_packed(propagation, tx, workspace, &packed, gradient);
        workspace.output_gradient = packed;
    }

    /// [`Gcn::backward_into`] for ∂loss/∂Z that is row-major already.
    pub(super) fn backward_packed(
        &self,
        propagation: &Propagation,
        tx: MatRef<'_, f64>,
        workspace: &mut GcnWorkspace,
        packed: &[f64],
        gradient: &mut GcnGradient,
    ) {
        self.assert_shape(propagation, tx);
        assert_eq!(workspace.num_nodes, tx.nrows(), "no forward pass yet");
        assert!(gradient.same_shape(&self.parameters), "gradient's shape");

        workspace.reserve_backward(&self.parameters);
        let GcnWorkspace {
            hidden,
            propagated_gradient: propagated,
            lanes,
            ..
        } = workspace;
        propagation.apply_rows(packed, self.num_outputs(), propagated);
        self.pull_back(tx, hidden, propagated, lanes);

        gradient.fill(0.0);
        for lane in lanes {
            gradient.accumulate(&lane.gradient);
        }
        gradient.output.accumulate_bias(packed);
    }

    /// ∂W0, ∂b0 and ∂W1 of each lane of rows.
    fn pull_back(&self, tx: MatRef<'_, f64>, hidden: &[f64], p: &[f64], lanes: &mut [Lane]) {
        let rows = rows_per_lane(tx.nrows());
        if let [lane] = lanes {
            return self.pull_back_lane(tx, hidden, p, lane);
        }
        lanes
            .par_iter_mut()
            .zip(hidden.par_chunks(rows * self.hidden_dim()))
            .zip(p.par_chunks(rows * self.num_outputs()))
            .enumerate()
            .for_each(|(index, ((lane, hidden), p))| {
                self.pull_back_lane(lane_rows(tx, index, rows), hidden, p, lane);
            });
    }

    fn pull_back_lane(&self, tx: MatRef<'_, f64>, hidden: &[f64], p: &[f64], lane: &mut Lane) {
        let width = self.hidden_dim();
        let blocks = hidden
            .chunks(BLOCK_ROWS * width)
            .zip(p.chunks(BLOCK_ROWS * self.num_outputs()));
        for (block, (hidden, p)) in blocks.enumerate() {
            let input_gradient = &mut lane.block[..hidden.len()];
            let gradient = &mut lane.gradient;
            gradient.output.accumulate_weight(view(hidden, width), p);
            self.parameters.output.pull_back(p, input_gradient);
            mask(input_gradient, hidden);
            let tx = lane_rows(tx, block, BLOCK_ROWS);
            gradient.hidden.accumulate_weight(tx, input_gradient);
            gradient.hidden.accumulate_bias(input_gradient);
        }
    }

    fn assert_shape(&self, propagation: &Propagation, tx: MatRef<'_, f64>) {
        let expected = (propagation.num_nodes(), self.num_features());
        assert_eq!(tx.shape(), expected, "shape of T̂X");
    }
}

/// The `index`-th group of `rows` rows; the last one may be shorter.
fn lane_rows(x: MatRef<'_, f64>, index: usize, rows: usize) -> MatRef<'_, f64> {
    let first = index * rows;
    x.subrows(first, rows.min(x.nrows() - first))
}

/// Keeps NaN (`f64::max` would hide it).
fn relu(values: &mut [f64]) {
    for value in values {
        *value = if *value < 0.0 { 0.0 } else { *value };
    }
}

/// Zero where the unit was silent.
fn mask(gradient: &mut [f64], hidden: &[f64]) {
    for (gradient, &hidden) in gradient.iter_mut().zip(hidden) {
        *gradient = if hidden > 0.0 { *gradient } else { 0.0 };
    }
}
