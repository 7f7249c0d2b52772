//! Errors in data from outside: parameters, checkpoints, floating point.

use crate::parameter::ParameterError;

/// Errors of this module. Wrong shapes between arguments of one call panic instead.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GcnError {
    /// A parameter is out of range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// A fit was asked to start from numbers that are no numbers.
    #[error("the GCN's {what} hold a NaN or an infinite value before the first epoch")]
    NotFinite {
        /// Which of the inputs.
        what: &'static str,
    },
    /// The loss or the weights stopped being finite.
    #[error("the GCN diverged in epoch {epoch}: the loss is {loss}; lower gcn.learning_rate")]
    Diverged {
        /// Steps taken; 0 is before the first one.
        epoch: usize,
        /// The loss after them.
        loss: f64,
    },
    /// A stored layer's lengths disagree with its shape.
    #[error(
        "the {layer} layer claims {inputs} inputs and {outputs} outputs but has {weights} weights and {biases} biases"
    )]
    LayerShape {
        /// `hidden` or `output`.
        layer: &'static str,
        /// Inputs by its own account.
        inputs: usize,
        /// Outputs by its own account; 0 is not allowed.
        outputs: usize,
        /// Length of W.
        weights: usize,
        /// Length of b.
        biases: usize,
    },
    /// Two stored layers do not fit together.
    #[error("the hidden layer has {hidden} outputs, the output layer takes {inputs} inputs")]
    LayerMismatch {
        /// Outputs of the first layer.
        hidden: usize,
        /// Inputs of the second one.
        inputs: usize,
    },
    /// A network with the wrong number of outputs for its purpose.
    #[error("the network has {found} outputs where {expected} is needed")]
    Outputs {
        /// Outputs that its purpose asks for.
        expected: usize,
        /// Outputs it has.
        found: usize,
    },
    /// A stored optimiser belongs to another network.
    #[error(
        "the optimiser's state has {moments} numbers in the shape of another network of {parameters} parameters"
    )]
    OptimizerShape {
        /// Numbers in the optimiser's first moment.
        moments: usize,
        /// Parameters of the network.
        parameters: usize,
    },
}
