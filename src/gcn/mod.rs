//! The graph convolutional network, Φ(X) = softmax(T̂ ReLU(T̂ X W0) W1) (eq. 5). (interface sketch)

use crate::graph::Csr;
use faer::{Mat, MatRef};

/// T̂ = D̃^-1/2 (A + I) D̃^-1/2.
#[derive(Clone, Debug)]
pub struct Propagation {}

#[derive(Clone, Debug)]
pub struct GcnParams {
    /// Hidden units (report: 16).
    pub hidden_dim: usize,
    /// Adam's step size (report: 0.01).
    pub learning_rate: f64,
    /// Epochs of a fit (report: 40).
    pub epochs: usize,
    /// λ of the smoothness loss λ φᵀLφ, divided by the number of edges.
    pub smoothness: f64,
}

/// Two layers, optional biases.
#[derive(Clone, Debug)]
pub struct Gcn {}

/// The same shapes as the parameters of [`Gcn`].
#[derive(Clone, Debug)]
pub struct GcnGradient {}

/// Activations kept between forward and backward; reused from call to call.
#[derive(Clone, Debug, Default)]
pub struct GcnWorkspace {}

#[derive(Clone, Debug)]
pub struct Adam {}

#[derive(Clone, Debug, PartialEq)]
pub struct FitReport {
    pub epochs: usize,
    pub initial_loss: f64,
    pub loss: f64,
}

#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GcnError {
    #[error("the loss became {loss} in epoch {epoch}: lower gcn.learning_rate")]
    Diverged { epoch: usize, loss: f64 },
}

#[allow(unused_variables)]
impl Propagation {
    pub fn new(adjacency: &Csr) -> Self {
        todo!()
    }
    /// T̂ X, n × f.
    pub fn apply(&self, x: MatRef<'_, f64>) -> Mat<f64> {
        todo!()
    }
}

#[allow(unused_variables)]
impl Gcn {
    /// Glorot-uniform weights as PyTorch's common GCN code, zero biases if `biases`.
    pub fn new(
        features: usize,
        hidden: usize,
        outputs: usize,
        biases: bool,
        rng: &mut rand_chacha::ChaCha8Rng,
    ) -> Self {
        todo!()
    }
    /// Sets the last layer to 0, so that the output starts at 0 for every node.
    pub fn zero_output_layer(&mut self) {
        todo!()
    }
    /// Linear output z = T̂ relu(T̂X W0 + b0) W1 + b1, n × outputs. `tx` is T̂X: it does not change within a fit.
    pub fn forward<'w>(
        &self,
        propagation: &Propagation,
        tx: MatRef<'_, f64>,
        workspace: &'w mut GcnWorkspace,
    ) -> MatRef<'w, f64> {
        todo!()
    }
    /// Gradient of a loss with dloss/dz = `output_gradient` (n × outputs), after `forward` on the same workspace.
    pub fn backward(
        &self,
        propagation: &Propagation,
        tx: MatRef<'_, f64>,
        workspace: &mut GcnWorkspace,
        output_gradient: MatRef<'_, f64>,
    ) -> GcnGradient {
        todo!()
    }
}

#[allow(unused_variables)]
impl Adam {
    pub fn new(gcn: &Gcn, learning_rate: f64) -> Self {
        todo!()
    }
    pub fn step(&mut self, gcn: &mut Gcn, gradient: &GcnGradient) {
        todo!()
    }
}

/// Cross-entropy on `labels` (node, class) + smoothness of the class probabilities; continues from the present weights.
/// Returns class probabilities n × classes.
#[allow(unused_variables)]
pub fn fit_classifier(
    gcn: &mut Gcn,
    adam: &mut Adam,
    propagation: &Propagation,
    laplacian: &Csr,
    features: MatRef<'_, f64>,
    labels: &[(u32, usize)],
    params: &GcnParams,
) -> Result<(Mat<f64>, FitReport), GcnError> {
    todo!()
}
