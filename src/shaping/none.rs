//! φ = 0: the reward as it is.

use super::{PotentialFit, PotentialInputs, PotentialModel, ShapingError};

/// The `none` potential.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoPotential;

impl PotentialModel for NoPotential {
    fn fit(&mut self, inputs: &PotentialInputs<'_>) -> Result<PotentialFit, ShapingError> {
        Ok(PotentialFit::flat(inputs.adjacency.num_nodes()))
    }
}
