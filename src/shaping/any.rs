//! Every potential behind one type: a plain value, dispatched without a pointer.

use super::class_probability::ClassProbabilityPotential;
use super::fit_context::{FitContext, GraphPotential};
use super::heat::HeatPotential;
use super::hops::HopsPotential;
use super::learned_cost::LearnedCostPotential;
use super::oracle::OraclePotential;
use super::shortest_path::ShortestPathProblem;
use super::{PotentialFit, PotentialInputs, PotentialKind, ShapingError, ShapingParams};
use crate::gcn::GcnParams;
use crate::graph::StateId;
use serde::{Deserialize, Serialize};

/// A potential of any kind. Written down with serde and read back, it continues exactly where it was.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(clippy::large_enum_variant)] // there is one potential per run
#[non_exhaustive]
pub enum AnyPotential {
    /// `gcn`.
    LearnedCost(LearnedCostPotential),
    /// `report`.
    ClassProbability(ClassProbabilityPotential),
    /// `heat`.
    Heat(HeatPotential),
    /// `hops`.
    Hops(HopsPotential),
    /// `oracle`.
    Oracle(OraclePotential),
    /// `none`: φ = 0, the reward as it is.
    None,
}

impl AnyPotential {
    /// The potential that `shaping.potential` names, with untrained weights drawn from `seed` where it has any. The
    /// parameters are taken to be valid ([`ShapingParams::validate`], [`GcnParams::validate`]).
    pub fn new(shaping: &ShapingParams, gcn: &GcnParams, seed: u64) -> Self {
        let scale_factor = shaping.scale_factor;
        match shaping.potential {
            PotentialKind::Gcn => {
                let (shaping, gcn) = (shaping.clone(), gcn.clone());
                Self::LearnedCost(LearnedCostPotential::new(shaping, gcn, seed))
            }
            PotentialKind::Report => {
                let (gcn, scale) = (gcn.clone(), shaping.scale);
                let potential = ClassProbabilityPotential::new(gcn, scale, scale_factor, seed);
                Self::ClassProbability(potential)
            }
            PotentialKind::Heat => Self::Heat(HeatPotential {
                kept: shaping.heat_kept,
                scale_factor,
            }),
            PotentialKind::Hops => Self::Hops(HopsPotential { scale_factor }),
            PotentialKind::Oracle => Self::Oracle(OraclePotential::new(scale_factor)),
            PotentialKind::None => Self::None,
        }
    }

    /// φ of all states discovered so far. Learnt potentials continue from their present weights.
    ///
    /// # Errors
    /// If the fit diverged, or if rewards, features or results are not finite.
    ///
    /// # Panics
    /// If `inputs.adjacency` has not as many rows as `inputs.graph` has states, or a goal or label is out of range.
    pub fn fit(&mut self, inputs: &PotentialInputs<'_>) -> Result<PotentialFit, ShapingError> {
        if let Self::Oracle(oracle) = self {
            return oracle.fit(inputs);
        }
        match self.on_graph() {
            Some(potential) if !inputs.goals.is_empty() => {
                let problem = ShortestPathProblem::observed(inputs)?;
                potential.fit_in(&FitContext {
                    problem: &problem,
                    adjacency: inputs.adjacency,
                    features: inputs.features,
                    labels: inputs.labels,
                })
            }
            _ => Ok(PotentialFit::flat(inputs.adjacency.num_nodes())),
        }
    }

    /// Tells the true distance (in typical steps) from `state` to the goal. Only the oracle listens.
    ///
    /// # Panics
    /// If `distance` is negative.
    pub fn set_true_distance(&mut self, state: StateId, distance: f64) {
        if let Self::Oracle(oracle) = self {
            oracle.set_true_distance(state, distance);
        }
    }

    /// The kinds that need no world; `None` for the others.
    pub(super) fn on_graph(&mut self) -> Option<&mut dyn GraphPotential> {
        match self {
            Self::LearnedCost(potential) => Some(potential),
            Self::ClassProbability(potential) => Some(potential),
            Self::Heat(potential) => Some(potential),
            Self::Hops(potential) => Some(potential),
            Self::Oracle(_) | Self::None => None,
        }
    }
}

/// [`AnyPotential::new`] under the name that says what it does.
pub fn build_potential(shaping: &ShapingParams, gcn: &GcnParams, seed: u64) -> AnyPotential {
    AnyPotential::new(shaping, gcn, seed)
}
