//! From transitions to shaped rewards in one object, without a loop: one walker on a world model.
//!
//! For those who bring their own agent: call [`ShapingPipeline::begin_episode`] after each reset and
//! [`ShapingPipeline::observe`] after each step, and learn from `reward + observed.shaping`. Several explorers that
//! share what they find take a [`WorldModel`] and a [`Walker`] each.

use super::error::PipelineError;
use super::params::PipelineParams;
use super::walker::{Observed, Walker};
use super::world_model::WorldModel;
use crate::env::{Action, Step};
use crate::features::FeatureSource;
use crate::graph::{StateGraph, StateId, TransitionGraph};
use crate::parameter::ParameterError;
use crate::shaping::{Goal, PotentialTable};
use crate::spectral::ProtoValueFunctions;
use faer::MatRef;
use serde::{Deserialize, Serialize};
use std::hash::Hash;

/// World model and one walker on it, over any hashable state. Memory O(states + transitions + n k).
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(bound(
    serialize = "S: Serialize",
    deserialize = "S: Clone + Eq + Hash + Deserialize<'de>"
))]
pub struct ShapingPipeline<S> {
    world: WorldModel<S>,
    walker: Walker,
}

impl<S: Clone + Eq + Hash> ShapingPipeline<S> {
    /// An empty graph, a flat potential; see [`WorldModel::new`].
    ///
    /// # Errors
    /// As [`WorldModel::new`].
    pub fn new(
        params: &PipelineParams,
        num_actions: usize,
        agent_features: Option<FeatureSource>,
        seed: u64,
    ) -> Result<Self, ParameterError> {
        let world = WorldModel::new(params, num_actions, agent_features, seed)?;
        let walker = Walker::new(&world, 0);
        Ok(Self { world, walker })
    }

    /// Begins an episode in `start`, returns its number; see [`Walker::begin_episode`].
    pub fn begin_episode(&mut self, start: &S) -> StateId {
        self.walker.begin_episode(&mut self.world, start)
    }

    /// Takes in one step from the present state and returns what it was worth; see [`Walker::observe`].
    ///
    /// # Errors
    /// As [`Walker::observe`].
    pub fn observe(&mut self, action: Action, step: &Step<S>) -> Result<Observed, PipelineError> {
        self.walker.observe(&mut self.world, action, step)
    }

    /// What is known of the world.
    pub fn world(&self) -> &WorldModel<S> {
        &self.world
    }

    /// The same, to [tell](WorldModel::tell) it about states, or for further walkers.
    pub fn world_mut(&mut self) -> &mut WorldModel<S> {
        &mut self.world
    }

    /// Where its walker stands.
    pub fn walker(&self) -> &Walker {
        &self.walker
    }

    /// Advice for the present state; see [`Walker::advice`].
    pub fn advice(&self) -> &[f64] {
        self.walker.advice()
    }

    /// The graph discovered so far.
    pub fn graph(&self) -> &StateGraph<S> {
        self.world.graph()
    }

    /// The tried transitions of [`Self::graph`], for numerical code.
    pub fn transitions(&self) -> &TransitionGraph {
        self.world.transitions()
    }

    /// The potential as it stands.
    pub fn potential(&self) -> &PotentialTable {
        self.world.potential()
    }

    /// The proto-value functions; without eigenpairs if nobody uses them.
    pub fn spectrum(&self) -> &ProtoValueFunctions {
        self.world.spectrum()
    }

    /// Goals seen so far and not lost since; see [`WorldModel::goals`].
    pub fn goals(&self) -> &[Goal] {
        self.world.goals()
    }

    /// What φ as it stands advises in every state; see [`WorldModel::look_ahead`].
    pub fn look_ahead(&self) -> Vec<f64> {
        self.world.look_ahead()
    }

    /// Where φ as it stands would hold up an agent that climbs it; see [`WorldModel::spurious_maxima`].
    pub fn spurious_maxima(&self) -> Vec<StateId> {
        self.world.spurious_maxima()
    }

    /// The features that the agent is linear in; see [`WorldModel::agent_features`].
    pub fn agent_features(&self) -> Option<MatRef<'_, f64>> {
        self.world.agent_features()
    }
}
