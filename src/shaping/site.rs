//! Potentials that see the world as a [`Terrain`]: the same code serves an explored world and a bare graph.

use super::terrain::Terrain;
use super::{PotentialFit, PotentialInputs, PotentialModel, ShapingError};
use crate::graph::{StateId, SymmetricCsr};
use faer::MatRef;

/// A terrain, and what learnt potentials need beside it.
#[derive(Clone, Copy)]
pub struct Site<'a> {
    /// Moves, costs, goals.
    pub terrain: &'a Terrain,
    /// Symmetric adjacency, one row per state.
    pub adjacency: &'a SymmetricCsr,
    /// n′ × k features of the first n′ states.
    pub features: MatRef<'a, f64>,
    /// (state, 1 if rewarding else 0).
    pub labels: &'a [(StateId, usize)],
}

/// A potential that is made from a [`Site`] with at least one goal. Every such potential is a [`PotentialModel`].
pub trait SiteModel: Send {
    /// φ of all states.
    ///
    /// # Errors
    /// If the fit diverged or its result is not finite.
    fn fit_site(&mut self, site: &Site<'_>) -> Result<PotentialFit, ShapingError>;
}

impl<M: SiteModel> PotentialModel for M {
    fn fit(&mut self, inputs: &PotentialInputs<'_>) -> Result<PotentialFit, ShapingError> {
        if inputs.goals.is_empty() {
            return Ok(PotentialFit::flat(inputs.adjacency.num_nodes()));
        }
        let terrain = Terrain::observed(inputs)?;
        self.fit_site(&Site {
            terrain: &terrain,
            adjacency: inputs.adjacency,
            features: inputs.features,
            labels: inputs.labels,
        })
    }
}

impl PotentialFit {
    /// φ = 0 for each of `n` states.
    pub fn flat(n: usize) -> Self {
        Self {
            values: vec![0.0; n],
            ..Self::default()
        }
    }

    /// A fit without learning, its values checked.
    pub(crate) fn checked(values: Vec<f64>) -> Result<Self, ShapingError> {
        super::potential::check_finite(&values)?;
        Ok(Self {
            values,
            ..Self::default()
        })
    }
}
