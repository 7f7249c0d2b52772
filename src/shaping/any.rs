//! Every potential behind one type: a plain value, dispatched without a pointer.

use super::class_probability::ClassProbabilityPotential;
use super::default_representation::DefaultRepresentationPotential;
use super::fit_context::{FitContext, GraphPotential};
use super::given::GivenPotential;
use super::heat::HeatPotential;
use super::hops::HopsPotential;
use super::learned_temperature::LearnedTemperaturePotential;
use super::learnt_model::LearntModel;
use super::negated_oracle::NegatedOraclePotential;
use super::oracle::OraclePotential;
use super::random::RandomPotential;
use super::return_context::{ReturnContext, ReturnPotential};
use super::shortest_path::ShortestPathProblem;
use super::successor::SuccessorPotential;
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
    LearnedTemperature(LearnedTemperaturePotential),
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
    /// `dr`.
    DefaultRepresentation(DefaultRepresentationPotential),
    /// `sr`.
    Successor(SuccessorPotential),
    /// `negated-oracle`.
    NegatedOracle(NegatedOraclePotential),
    /// `random`.
    Random(RandomPotential),
    /// `file`.
    Given(GivenPotential),
}

impl AnyPotential {
    /// The potential that `shaping.potential` names, with untrained weights drawn from `seed` where it has any. The
    /// parameters are taken to be valid ([`ShapingParams::validate`], [`GcnParams::validate`]).
    pub fn new(shaping: &ShapingParams, gcn: &GcnParams, seed: u64) -> Self {
        let (scale, scale_factor) = (shaping.scale, shaping.scale_factor);
        match shaping.potential {
            PotentialKind::Gcn => {
                let (shaping, gcn) = (shaping.clone(), gcn.clone());
                Self::LearnedTemperature(LearnedTemperaturePotential::new(shaping, gcn, seed))
            }
            PotentialKind::Report => {
                let potential =
                    ClassProbabilityPotential::new(gcn.clone(), scale, scale_factor, seed);
                Self::ClassProbability(potential)
            }
            PotentialKind::Heat => Self::Heat(HeatPotential {
                kept: shaping.heat_kept,
                scale_factor,
            }),
            PotentialKind::Dr => Self::DefaultRepresentation(DefaultRepresentationPotential {
                temperature: shaping.temperature,
                scale,
                scale_factor,
            }),
            PotentialKind::Sr => Self::Successor(SuccessorPotential {
                scale,
                scale_factor,
            }),
            PotentialKind::Hops => Self::Hops(HopsPotential { scale_factor }),
            PotentialKind::Oracle => Self::Oracle(OraclePotential::new(scale_factor)),
            PotentialKind::NegatedOracle => {
                Self::NegatedOracle(NegatedOraclePotential::new(scale_factor))
            }
            PotentialKind::Random => Self::Random(RandomPotential::new(scale_factor, seed)),
            PotentialKind::File => Self::Given(GivenPotential::default()),
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
        let ends = inputs.all_ends();
        let mut fit = self.fit_anywhere(inputs, &ends)?;
        let at_ends = fit.values.iter_mut().zip(&ends).filter(|(_, end)| **end);
        at_ends.for_each(|(phi, _)| *phi = 0.0);
        Ok(fit)
    }

    /// φ, but for the ends of episodes.
    fn fit_anywhere(
        &mut self,
        inputs: &PotentialInputs<'_>,
        ends: &[bool],
    ) -> Result<PotentialFit, ShapingError> {
        match self {
            Self::Oracle(oracle) => return oracle.fit(inputs),
            Self::NegatedOracle(negated) => return negated.fit(inputs),
            Self::Given(given) => return given.fit(inputs),
            _ => {}
        }
        let goal_known = !inputs.goals.is_empty();
        if let Some(potential) = self.of_returns() {
            let model = LearntModel::observed(inputs.graph, ends, goal_known, inputs.gamma)?;
            return potential.fit_to_returns(&ReturnContext {
                model: &model,
                adjacency: inputs.adjacency,
                features: inputs.features,
                returns: inputs.returns,
            });
        }
        match self.of_goals() {
            Some(potential) if goal_known => {
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

    /// Tells a number about a state: to the oracle and its opposite its true distance to the goal (in typical steps), to `file`
    /// its φ (in units of return). Other kinds do not listen. One that is not finite says that there is none.
    ///
    /// # Panics
    /// If a distance is negative.
    pub fn tell(&mut self, state: StateId, number: f64) {
        match self {
            Self::Oracle(oracle) => oracle.set_true_distance(state, number),
            Self::NegatedOracle(negated) => negated.set_true_distance(state, number),
            Self::Given(given) => given.set_value(state, number),
            _ => {}
        }
    }

    /// Whether it is made of returns, which need no goal.
    pub fn is_made_of_returns(&self) -> bool {
        matches!(
            self,
            Self::LearnedTemperature(_) | Self::Heat(_) | Self::Hops(_)
        )
    }

    /// The kinds made of returns; `None` for the others.
    pub(super) fn of_returns(&mut self) -> Option<&mut dyn ReturnPotential> {
        match self {
            Self::LearnedTemperature(potential) => Some(potential),
            Self::Heat(potential) => Some(potential),
            Self::Hops(potential) => Some(potential),
            _ => None,
        }
    }

    /// The kinds made of ways to goals; `None` for the others.
    pub(super) fn of_goals(&mut self) -> Option<&mut dyn GraphPotential> {
        match self {
            Self::ClassProbability(potential) => Some(potential),
            Self::DefaultRepresentation(potential) => Some(potential),
            Self::Successor(potential) => Some(potential),
            Self::Random(potential) => Some(potential),
            _ => None,
        }
    }
}

/// [`AnyPotential::new`] under the name that says what it does.
pub fn build_potential(shaping: &ShapingParams, gcn: &GcnParams, seed: u64) -> AnyPotential {
    AnyPotential::new(shaping, gcn, seed)
}
