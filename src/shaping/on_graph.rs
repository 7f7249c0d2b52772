//! φ on a bare undirected graph: no world, no transitions, every step costs 1.

use super::any::AnyPotential;
use super::fit_context::FitContext;
use super::learnt_model::LearntModel;
use super::return_context::ReturnContext;
use super::shortest_path::ShortestPathProblem;
use super::transition_matrix::TransitionMatrix;
use super::{PotentialFit, PotentialKind, ShapingError, ShapingParams};
use crate::gcn::GcnParams;
use crate::graph::{StateId, SymmetricCsr};
use faer::MatRef;

/// φ of every node of `adjacency` for an agent that wants to reach one of `goals`. Edge weights are relative
/// probabilities of moves; distances count hops. `features` (n′ × k, see
/// [`ProtoValueFunctions`](crate::spectral::ProtoValueFunctions)) serve `gcn` and `report`; the others ignore them, and
/// `Mat::zeros(0, 0)` will do.
///
/// `report` needs a state that is not rewarding beside the goals, where an agent would take its start state: the node
/// farthest from the goals stands in.
///
/// # Errors
/// [`ShapingError::NoGoal`], [`GoalRange`](ShapingError::GoalRange), [`KindNeedsWorld`](ShapingError::KindNeedsWorld) for kinds that are told about states, and `none`,
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
    let shaping = ShapingParams {
        potential: kind,
        ..shaping.clone()
    };
    let mut potential = AnyPotential::new(&shaping, gcn, seed);
    if let Some(potential) = potential.of_returns() {
        let model = LearntModel::uniform(adjacency, &goals);
        // Nobody has been here whose returns could be labels.
        let returns = model.optimal_returns();
        return potential.fit_to_returns(&ReturnContext {
            model: &model,
            adjacency,
            features,
            returns: &returns,
        });
    }
    let potential = potential
        .of_goals()
        .ok_or(ShapingError::KindNeedsWorld { kind })?;
    let problem = ShortestPathProblem::uniform(&TransitionMatrix::undirected(adjacency), &goals);
    let labels = labels(&problem);
    potential.fit_in(&FitContext {
        problem: &problem,
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
fn labels(problem: &ShortestPathProblem) -> Vec<(StateId, usize)> {
    let (goals, others) = problem.chain.order().split_at(problem.chain.num_goals());
    let rewarding = goals.iter().map(|&g| (StateId(g), 1));
    rewarding
        .chain(others.last().map(|&s| (StateId(s), 0)))
        .collect()
}
