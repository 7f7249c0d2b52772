//! The buffers of a forward and a backward pass, reused from call to call.

use super::rows::{BLOCK_ROWS, num_lanes};
use super::{GcnGradient, GcnParameters};

/// Activations kept between [`Gcn::forward`](super::Gcn::forward) and [`Gcn::backward`](super::Gcn::backward).
///
/// Buffers grow with the largest graph seen and are then reused: no allocation in a steady state.
/// All blocks are row-major; n nodes, h hidden units, c outputs.
#[derive(Clone, Debug, Default)]
pub struct GcnWorkspace {
    /// H = relu(T̂X W0 + b0), n × h.
    pub(super) hidden: Vec<f64>,
    /// H W1, n × c.
    pub(super) projected: Vec<f64>,
    /// Z, n × c.
    pub(super) logits: Vec<f64>,
    /// G = ∂loss/∂Z, n × c, where it was handed over with other strides.
    pub(super) output_gradient: Vec<f64>,
    /// T̂ G, n × c.
    pub(super) propagated_gradient: Vec<f64>,
    /// One per lane of rows.
    pub(super) lanes: Vec<Lane>,
    /// n of the last forward pass.
    pub(super) num_nodes: usize,
}

/// Buffers of one lane of rows, so that lanes may run side by side and be added in order.
#[derive(Clone, Debug)]
pub(super) struct Lane {
    /// ∂loss/∂(T̂X W0 + b0) of one block of rows.
    pub(super) block: Vec<f64>,
    /// The lane's share of the gradient.
    pub(super) gradient: GcnGradient,
}

impl GcnWorkspace {
    /// Makes room for `num_nodes` rows; contents are left undefined.
    pub(super) fn reserve_forward(&mut self, num_nodes: usize, parameters: &GcnParameters) {
        let (hidden, outputs) = (parameters.hidden.outputs, parameters.output.outputs);
        self.num_nodes = num_nodes;
        self.hidden.resize(num_nodes * hidden, 0.0);
        self.projected.resize(num_nodes * outputs, 0.0);
        self.logits.resize(num_nodes * outputs, 0.0);
    }

    /// Makes room for the gradients of the last forward pass, zeroed.
    pub(super) fn reserve_backward(&mut self, parameters: &GcnParameters) {
        let (hidden, outputs) = (parameters.hidden.outputs, parameters.output.outputs);
        self.propagated_gradient
            .resize(self.num_nodes * outputs, 0.0);
        self.lanes.truncate(num_lanes(self.num_nodes));
        if self
            .lanes
            .first()
            .is_some_and(|lane| !lane.gradient.same_shape(parameters))
        {
            self.lanes.clear();
        }
        self.lanes.resize_with(num_lanes(self.num_nodes), || Lane {
            block: vec![0.0; BLOCK_ROWS * hidden],
            gradient: parameters.zeros_like(),
        });
        for lane in &mut self.lanes {
            lane.gradient.fill(0.0);
        }
    }
}
