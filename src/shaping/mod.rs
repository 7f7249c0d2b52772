//! The potential φ and the shaped reward r + γφ(s′) − φ(s). (interface sketch)

use crate::graph::{StateId, TransitionGraph};
use faer::MatRef;

/// A function of states that shapes the reward.
pub trait Potential {
    /// φ(state), in units of return; ≤ 0, and 0 at the (best) goal.
    fn value(&self, state: StateId) -> f64;
}

/// A goal that the agent has seen: entering it ended an episode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    pub state: StateId,
    /// Mean reward on entering it.
    pub reward: f64,
}

/// What a potential may be fitted on: everything discovered so far, nothing else.
pub struct PotentialInputs<'a> {
    pub graph: &'a TransitionGraph,
    /// Compact copy of `graph.adjacency()`, taken once per refresh.
    pub adjacency: &'a crate::graph::Csr,
    pub goals: &'a [Goal],
    /// (state, 1 if it ended a trajectory as a rewarding state else 0), section 4.1 of the report.
    pub labels: &'a [(StateId, usize)],
    /// Proto-value functions, n × k, scaled by √n, aligned; may have fewer rows than the graph has states.
    pub features: MatRef<'a, f64>,
}

/// φ of every state known when it was fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct PotentialFit {
    pub values: Vec<f64>,
    /// None for potentials without learning.
    pub fit: Option<crate::gcn::FitReport>,
}

#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ShapingError {
    #[error(transparent)]
    Gcn(#[from] crate::gcn::GcnError),
    #[error("the potential of state {state} is {value}")]
    NotFinite { state: usize, value: f64 },
}

/// One way to get φ: `gcn`, `report`, `heat`, `hops`, `oracle`, `none`.
pub trait PotentialModel {
    fn fit(&mut self, inputs: &PotentialInputs<'_>) -> Result<PotentialFit, ShapingError>;
}

/// Turns r into r + γφ(s′) − φ(s) with the φ(s) used on entering s (Devlin & Kudenko 2012).
#[derive(Clone, Debug)]
pub struct RewardShaper {}

#[allow(unused_variables)]
impl RewardShaper {
    pub fn new(gamma: f64) -> Self {
        todo!()
    }
    pub fn begin_episode(&mut self, potential: f64) {
        todo!()
    }
    /// F for a step to a state with potential `next_potential`.
    pub fn shape(&mut self, next_potential: f64, status: crate::env::StepStatus) -> f64 {
        todo!()
    }
}
