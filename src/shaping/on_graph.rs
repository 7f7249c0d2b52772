//! φ on a bare undirected graph: no world, no transitions, every step costs 1.

use super::build::build_site_model;
use super::site::Site;
use super::successors::Successors;
use super::terrain::Terrain;
use super::{PotentialFit, PotentialKind, ShapingError, ShapingParams};
use crate::gcn::GcnParams;
use crate::graph::{StateId, SymmetricCsr};
use faer::MatRef;

/// φ of every node of `adjacency` for an agent that wants to reach one of `goals`. Edge weights are conductances of
/// the diffusion; distances count hops. `features` (n′ × k, see
/// [`ProtoValueFunctions`](crate::spectral::ProtoValueFunctions)) serve `gcn` and `report`; the others ignore them, and
/// `Mat::zeros(0, 0)` will do.
///
/// `report` needs a state that is not rewarding beside the goals, where an agent would take its start state: the node
/// farthest from the goals stands in.
///
/// # Errors
/// [`ShapingError::NoGoal`], [`GoalRange`](ShapingError::GoalRange), [`KindNeedsWorld`](ShapingError::KindNeedsWorld) for `oracle` and `none`,
/// [`Parameter`](ShapingError::Parameter), or a failed fit.
///
/// # Panics
/// If `adjacency` has fewer rows than `features`.
pub fn potential_on_graph(
    adjacency: &SymmetricCsr,
    goals: &[StateId],
    kind: PotentialKind,
    features: MatRef<'_, f64>,
    shaping: &ShapingParams,
    gcn: &GcnParams,
    seed: u64,
) -> Result<PotentialFit, ShapingError> {
    shaping.validate()?;
    gcn.validate()?;
    let goals = checked_goals(goals, adjacency.num_nodes())?;
    let mut model =
        build_site_model(kind, shaping, gcn, seed).ok_or(ShapingError::KindNeedsWorld { kind })?;
    let terrain = Terrain::uniform(&Successors::undirected(adjacency), &goals);
    let labels = labels(&terrain);
    model.fit_site(&Site {
        terrain: &terrain,
        adjacency,
        features,
        labels: &labels,
    })
}

/// Ascending, without duplicates.
fn checked_goals(goals: &[StateId], nodes: usize) -> Result<Vec<StateId>, ShapingError> {
    if goals.is_empty() {
        return Err(ShapingError::NoGoal);
    }
    if let Some(goal) = goals.iter().find(|g| g.index() >= nodes) {
        return Err(ShapingError::GoalRange {
            goal: goal.index(),
            nodes,
        });
    }
    let mut goals = goals.to_vec();
    goals.sort_unstable();
    goals.dedup();
    Ok(goals)
}

/// Goals are rewarding; the farthest node, if there is one, is not.
fn labels(terrain: &Terrain) -> Vec<(StateId, usize)> {
    let (goals, others) = terrain.chain.order().split_at(terrain.chain.num_goals());
    let rewarding = goals.iter().map(|&g| (StateId(g), 1));
    rewarding
        .chain(others.last().map(|&s| (StateId(s), 0)))
        .collect()
}
