//! A potential towards goals on any graph, without a world.

use super::error::RunnerError;
use crate::gcn::GcnParams;
use crate::graph::{StateId, SymmetricCsr};
use crate::shaping::{PotentialKind, ShapingParams, potential_on_graph, spurious_maxima};
use crate::spectral::{ProtoValueFunctions, SpectralParams};
use faer::Mat;
use std::time::Instant;

/// Potential of every node, and how good it is to climb.
#[derive(Clone, Debug)]
pub struct PotentialOfGraph {
    /// φ by node; 0 at the goals.
    pub values: Vec<f64>,
    /// Non-goal nodes, reachable from a goal, none of whose neighbours has a larger φ.
    pub spurious_maxima: Vec<StateId>,
    /// Wall seconds, eigenvectors included.
    pub seconds: f64,
}

/// The potential of `kind` towards `goals`, with default parameters. Features are the lowest eigenvectors of the
/// graph, for the kinds that use them.
///
/// # Errors
/// If there is no goal or one is out of range, a weight is not finite and positive, or a fit fails.
pub fn potential_of_graph(
    adjacency: &SymmetricCsr,
    goals: &[StateId],
    kind: PotentialKind,
    seed: u64,
) -> Result<PotentialOfGraph, RunnerError> {
    let begun = Instant::now();
    let learnt = matches!(kind, PotentialKind::Gcn | PotentialKind::Report);
    let mut functions = ProtoValueFunctions::new(SpectralParams::default(), seed);
    if learnt {
        functions.refresh(adjacency)?;
    }
    let none = Mat::zeros(0, 0);
    let features = functions.features().unwrap_or(none.as_ref());
    let shaping = ShapingParams {
        potential: kind,
        ..ShapingParams::default()
    };
    let gcn = GcnParams::default();
    let fit = potential_on_graph(adjacency, goals, kind, features, &shaping, &gcn, seed)?;
    Ok(PotentialOfGraph {
        spurious_maxima: spurious_maxima(&fit.values, adjacency, goals),
        values: fit.values,
        seconds: begun.elapsed().as_secs_f64(),
    })
}
