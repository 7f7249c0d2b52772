//! The potential φ and the shaped reward.
//!
//! ```text
//! R′ = R + F,    F_t = γ φ_{t+1}(s_{t+1}) − φ_t(s_t)                      (eq. 3 and 4 of the source paper)
//! ```
//!
//! φ_t(s_t) is the value that was used when s_t was *entered*, not the present one, because φ changes while the
//! agent learns. Along an episode s_0 … s_T the discounted sum of F then telescopes,
//!
//! ```text
//! Σ_t γ^t F_t = γ^T φ_T(s_T) − φ_0(s_0),
//! ```
//!
//! whatever happened to φ in between. Shaping leaves the set of optimal policies as it is when this sum does not
//! depend on what the agent did, and that asks for two things:
//!
//! - φ = 0 after **termination**: otherwise the agent is paid γ^T φ(s_T) for *where* the episode ended;
//! - the true φ after **truncation**: the episode would have gone on, so the state keeps its potential just as it
//!   keeps its value.
//!
//! φ(s_0) is the same for every policy and drops out. Since φ is 0 on termination, a potential whose value at the
//! goal is far from 0 makes the last step a cliff; [`ShortestPathProblem::potential`] therefore shifts φ to 0 at the
//! goal, and puts it on the scale of the return, which is what decides how much shaping helps.
//!
//! The potentials, all behind [`AnyPotential`]:
//!
//! | kind | φ |
//! |---|---|
//! | [`gcn`](LearnedTemperaturePotential) | the soft value of the learnt model at temperatures that a GCN sets from the returns of the agent; no false maxima for any weights |
//! | [`report`](ClassProbabilityPotential) | the GCN's probability of the rewarding class (eq. 5) |
//! | [`heat`](HeatPotential) | the soft value of the learnt model at a fixed temperature: the control without learning |
//! | [`dr`](DefaultRepresentationPotential) | λ ln z of the default representation |
//! | [`sr`](SuccessorPotential) | expected discounted visits of the goal: a column of the successor representation |
//! | [`hops`](HopsPotential) | the value of the learnt model's optimal policy, at temperature 0 |
//! | [`oracle`](OraclePotential) | distance on the true map, which no agent has: the upper yardstick |
//! | [`negated-oracle`](NegatedOraclePotential) | the opposite of the oracle's: hostile |
//! | [`random`](RandomPotential) | a number drawn for each state |
//! | [`file`](GivenPotential) | as the user gives it |
//! | `none` | 0 |
//!
//! References: A. Y. Ng, D. Harada, S. Russell, *Policy invariance under reward transformations*, ICML 1999 ·
//! S. Devlin, D. Kudenko, *Dynamic potential-based reward shaping*, AAMAS 2012 · M. Grześ, *Reward shaping in
//! episodic reinforcement learning*, AAMAS 2017 · E. Todorov, *Linearly-solvable Markov decision problems*,
//! NIPS 2006 · P. Piray, N. D. Daw, *Linear reinforcement learning in planning, grid fields, and cognitive control*,
//! Nature Communications 12:4942, 2021 · P. Dayan, *Improving generalization for temporal difference learning: the successor
//! representation*, Neural Computation 1993 · M. Klissarov, D. Precup, *Reward propagation using graph convolutional networks*,
//! NeurIPS 2020.

mod absorbing_chain;
mod any;
mod class_probability;
mod cost_to_go;
mod decision_process;
mod default_representation;
mod false_maxima;
mod features;
mod fit_context;
#[cfg(test)]
mod fixtures;
mod given;
mod heat;
mod hops;
mod label_setting;
mod learned_temperature;
mod learnt_model;
mod linearly_solvable;
mod negated_oracle;
mod network;
mod on_graph;
mod oracle;
mod params;
mod potential;
mod random;
mod return_context;
mod shaper;
mod shortest_path;
mod soft_bellman;
mod successor;
mod told;
mod transition_matrix;

pub use absorbing_chain::AbsorbingChain;
pub use any::{AnyPotential, build_potential};
pub use class_probability::ClassProbabilityPotential;
pub use decision_process::DecisionProcess;
pub use default_representation::DefaultRepresentationPotential;
pub use false_maxima::false_maxima;
pub use fit_context::{FitContext, GraphPotential};
pub use given::GivenPotential;
pub use heat::HeatPotential;
pub use hops::HopsPotential;
pub use learned_temperature::LearnedTemperaturePotential;
pub use learnt_model::LearntModel;
pub use negated_oracle::NegatedOraclePotential;
pub use on_graph::potential_on_graph;
pub use oracle::OraclePotential;
pub use params::{PotentialKind, ScaleMode, ShapingParams};
pub use potential::{PotentialTable, spurious_maxima};
pub use random::RandomPotential;
pub use return_context::{ReturnContext, ReturnPotential};
pub use shaper::RewardShaper;
pub use shortest_path::ShortestPathProblem;
pub use soft_bellman::{SoftBellman, SolveStatistics};
pub use successor::SuccessorPotential;
pub use transition_matrix::TransitionMatrix;

use crate::graph::{StateId, SymmetricCsr, TransitionGraph};
use crate::parameter::ParameterError;
use faer::MatRef;
use serde::{Deserialize, Serialize};

/// A function of states that shapes the reward.
pub trait Potential {
    /// φ(state), in units of return; finite; 0 where episodes end.
    fn value(&self, state: StateId) -> f64;
}

/// A goal that the agent has seen: entering it ended an episode.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Goal {
    /// The state that was entered.
    pub state: StateId,
    /// Mean reward on entering it.
    pub reward: f64,
}

/// The data a potential is fitted on: everything discovered so far, nothing else.
#[derive(Clone, Copy)]
pub struct PotentialInputs<'a> {
    /// Actions tried and their outcomes.
    pub graph: &'a TransitionGraph,
    /// Compact copy of `graph.adjacency()`, taken once per refresh: as many rows as the graph has states.
    pub adjacency: &'a SymmetricCsr,
    /// The goals seen so far, without duplicates: ends worth seeking.
    pub goals: &'a [Goal],
    /// By state: whether episodes end there, as goals or otherwise. Shorter if the last ones are none; goals are ends in any case.
    pub ends: &'a [bool],
    /// Returns that the agent has had, at most one a state, ascending.
    pub returns: &'a [(StateId, f64)],
    /// γ.
    pub gamma: f64,
    /// (state, 1 if it ended a trajectory as a rewarding state else 0), section 4.1 of the paper.
    pub labels: &'a [(StateId, usize)],
    /// Proto-value functions, n × k, scaled by √n, aligned; may have fewer rows than the graph has states.
    pub features: MatRef<'a, f64>,
}

impl PotentialInputs<'_> {
    /// By state: whether it is an end.
    fn all_ends(&self) -> Vec<bool> {
        let mut ends = self.ends.to_vec();
        ends.resize(self.graph.num_states(), false);
        self.goals
            .iter()
            .for_each(|goal| ends[goal.state.index()] = true);
        ends
    }
}

/// φ of every state known when it was fitted.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PotentialFit {
    /// φ by state number, finite.
    pub values: Vec<f64>,
    /// Epochs and losses of the GCN's training; `None` for potentials without learning.
    pub fit: Option<crate::gcn::FitStatistics>,
    /// Cost and accuracy of the solve of the Bellman equation; `None` for potentials without one.
    pub solve: Option<SolveStatistics>,
}

/// Reasons why there is no potential.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ShapingError {
    /// The GCN could not be fitted.
    #[error(transparent)]
    Gcn(#[from] crate::gcn::GcnError),
    /// φ came out as NaN or infinite.
    #[error("the potential of state {state} is {value}")]
    NotFinite {
        /// State number.
        state: usize,
        /// The value it has.
        value: f64,
    },
    /// A reward that is NaN or infinite.
    #[error("the mean reward seen at state {state} is {value}: rewards must be finite")]
    Reward {
        /// State number.
        state: usize,
        /// Its mean reward.
        value: f64,
    },
    /// A goal that is no node of the graph.
    #[error("goal {goal} is not a node of a graph of {nodes} nodes (numbered from 0)")]
    GoalRange {
        /// The goal as given.
        goal: usize,
        /// Number of nodes.
        nodes: usize,
    },
    /// A potential was asked for without a goal.
    #[error("a potential needs at least one goal")]
    NoGoal,
    /// A kind that needs what a bare graph cannot give.
    #[error(
        "potential kind `{kind}` needs more than a graph: choose gcn, report, heat, dr, sr, hops or random"
    )]
    KindNeedsWorld {
        /// The kind that was asked for.
        kind: PotentialKind,
    },
    /// A parameter outside its range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
}
