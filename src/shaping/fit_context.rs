//! The data that potentials on a graph are fitted on: the same code serves an explored world and a bare graph.

use super::shortest_path::ShortestPathProblem;
use super::{PotentialFit, ShapingError};
use crate::graph::{StateId, SymmetricCsr};
use faer::MatRef;

/// A shortest-path problem, and what learnt potentials need beside it.
#[derive(Clone, Copy)]
pub struct FitContext<'a> {
    /// Moves, costs, goals.
    pub problem: &'a ShortestPathProblem,
    /// Symmetric adjacency, one row per state.
    pub adjacency: &'a SymmetricCsr,
    /// n′ × k features of the first n′ states.
    pub features: MatRef<'a, f64>,
    /// (state, 1 if rewarding else 0).
    pub labels: &'a [(StateId, usize)],
}

/// A potential that is made from a [`FitContext`] with at least one goal.
pub trait GraphPotential {
    /// φ of all states.
    ///
    /// # Errors
    /// If the fit diverged or its result is not finite.
    fn fit_in(&mut self, context: &FitContext<'_>) -> Result<PotentialFit, ShapingError>;
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
