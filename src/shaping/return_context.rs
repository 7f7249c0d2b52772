//! The data that potentials made of returns are fitted on: the same code serves an explored world and a bare graph.

use super::learnt_model::LearntModel;
use super::{PotentialFit, ShapingError};
use crate::graph::{StateId, SymmetricCsr};
use faer::MatRef;

/// A model of the world, and what learnt potentials need beside it.
#[derive(Clone, Copy)]
pub struct ReturnContext<'a> {
    /// Choices, rewards, outcomes.
    pub model: &'a LearntModel,
    /// Symmetric adjacency, one row per state.
    pub adjacency: &'a SymmetricCsr,
    /// n′ × k features of the first n′ states.
    pub features: MatRef<'a, f64>,
    /// Returns that the agent has had, at most one a state, ascending.
    pub returns: &'a [(StateId, f64)],
}

/// A potential that is made from a [`ReturnContext`].
pub trait ReturnPotential {
    /// φ of all states.
    ///
    /// # Errors
    /// If the fit diverged or its result is not finite.
    fn fit_to_returns(&mut self, context: &ReturnContext<'_>)
    -> Result<PotentialFit, ShapingError>;
}
