//! Knowledge of a world, whoever found it out: graph, features, potential, goals, and what actions do.
//!
//! **Goals may move.** A state where an episode terminated, and with [`Optimism::ExpectedReturn`] one that pays, is believed to be a goal until an
//! episode goes on there.
//! Then it is forgotten: φ is fitted anew on the goals that are left, or is 0 again when there are none, and the search
//! for a first goal begins anew. A world whose episodes terminate in a state only now and then is not what this is
//! for: each visit would refit φ.
//!
//! **Before the first end, or step that paid,** φ is flat and there is no fit; a potential that is not made of returns waits for the first goal. Features follow the growing graph all the same, each refresh
//! from the one before: the first fit finds them ready, and whoever watches sees the graph unfold.

mod learning;
mod refresh;

use super::goal_statistics::GoalStatistics;
use super::params::PipelineParams;
use super::returns::ReturnStatistics;
use super::schedule::RefreshSchedule;
use super::time_layers::TimeLayers;
use crate::exploration::{CountBonus, ExplorationKind, ExplorationModel, Explorer, Optimism};
use crate::features::{FeatureSet, FeatureSource};
use crate::graph::{StateGraph, StateId, TransitionGraph};
use crate::parameter::ParameterError;
use crate::seeds::{self, Stream};
use crate::shaping::{
    AnyPotential, Goal, PotentialKind, PotentialTable, build_potential, false_maxima,
};
use crate::spectral::ProtoValueFunctions;
use faer::MatRef;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use std::hash::Hash;

/// Knowledge of a world over any hashable state, shared by the [walkers](super::Walker) in it. Memory O(states + transitions + n k).
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(bound(
    serialize = "S: Serialize",
    deserialize = "S: Clone + Eq + Hash + Deserialize<'de>"
))]
pub struct WorldModel<S> {
    graph: StateGraph<S>,
    features: FeatureSet,
    gcn_features: FeatureSource,
    agent_features: Option<FeatureSource>,
    model: AnyPotential,
    table: PotentialTable,
    exploration: Option<ExplorationModel>,
    bonus: Option<CountBonus>,
    schedule: RefreshSchedule,
    goals: GoalStatistics,
    layers: TimeLayers,
    /// For a potential that learns from them.
    returns: Option<ReturnStatistics>,
    /// Rise of φ that one step towards a goal is worth on average.
    unit: f64,
    step: u64,
    pairs_tried: u64,
    gamma: f64,
    seed: u64,
}

impl<S: Clone + Eq + Hash> WorldModel<S> {
    /// An empty graph, a flat potential.
    ///
    /// Features are kept up to date if the potential uses them, or the agent, which is linear in `agent_features`.
    /// `seed` is the master seed of the run; every part draws from its own stream.
    ///
    /// # Errors
    /// The first parameter that breaks its rule ([`PipelineParams::validate`]), or `num_actions` outside 1..=65 536.
    pub fn new(
        params: &PipelineParams,
        num_actions: usize,
        agent_features: Option<FeatureSource>,
        seed: u64,
    ) -> Result<Self, ParameterError> {
        params.validate()?;
        require_actions(num_actions)?;
        let exploration = &params.exploration;
        let learnt = matches!(
            params.shaping.potential,
            PotentialKind::Gcn | PotentialKind::Report
        );
        let gcn_features = params.gcn.features;
        let for_gcn = learnt.then_some(gcn_features);
        let used: Vec<_> = for_gcn.into_iter().chain(agent_features).collect();
        Ok(Self {
            graph: StateGraph::new(num_actions),
            features: FeatureSet::new(&used, &params.spectral, &params.deepwalk, seed),
            gcn_features,
            agent_features,
            model: build_potential(&params.shaping, &params.gcn, seed),
            table: PotentialTable::new(),
            exploration: (exploration.kind == ExplorationKind::Frontier)
                .then(|| ExplorationModel::new(exploration.clone(), num_actions)),
            bonus: (exploration.kind == ExplorationKind::CountBonus)
                .then(|| CountBonus::new(exploration.bonus)),
            schedule: RefreshSchedule::new(params.schedule.clone()),
            goals: match exploration.optimism {
                Optimism::ExpectedReturn => GoalStatistics::of_paying_ends(),
                _ => GoalStatistics::default(),
            },
            layers: TimeLayers::new(),
            returns: (params.shaping.potential == PotentialKind::Gcn)
                .then(ReturnStatistics::default),
            unit: 1.0,
            step: 0,
            pairs_tried: 0,
            gamma: params.gamma,
            seed,
        })
    }

    /// The discount in F.
    pub fn gamma(&self) -> f64 {
        self.gamma
    }

    /// Environment steps observed so far, of all walkers together.
    pub fn steps(&self) -> u64 {
        self.step
    }

    /// The graph discovered so far.
    pub fn graph(&self) -> &StateGraph<S> {
        &self.graph
    }

    /// The tried transitions of [`Self::graph`], for numerical code.
    pub fn transitions(&self) -> &TransitionGraph {
        self.graph.transitions()
    }

    /// The proto-value functions; without eigenpairs if nobody uses them.
    pub fn spectrum(&self) -> &ProtoValueFunctions {
        self.features.spectrum()
    }

    /// The features that the agent is linear in, as of the last refresh; `None` for an agent without.
    pub fn agent_features(&self) -> Option<MatRef<'_, f64>> {
        self.features.get(self.agent_features?)
    }

    /// The potential as it stands.
    pub fn potential(&self) -> &PotentialTable {
        &self.table
    }

    /// Goals seen so far and not lost since, with their mean rewards, in the order of discovery.
    pub fn goals(&self) -> &[Goal] {
        self.goals.goals()
    }

    /// Tells the potential a number about a state; see [`AnyPotential::tell`].
    ///
    /// # Panics
    /// If it is a negative distance.
    pub fn tell(&mut self, state: StateId, number: f64) {
        self.model.tell(state, number);
    }

    /// Where the potential as it stands would hold up an agent that follows it: states from which a goal can be reached
    /// over the moves seen, none of whose moves leads to a larger φ, or where an agent that looks one step ahead stays. None before the first goal. O((n + transitions) log n).
    pub fn spurious_maxima(&self) -> Vec<StateId> {
        let (graph, goals) = (self.graph.transitions(), &self.goals);
        false_maxima(graph, goals.goals(), goals.ends(), &self.table, self.gamma)
    }

    /// What φ as it stands advises in `state`, in logits, one per action: the expected rise of φ along each, plans of
    /// walkers left out. All 0 without the `frontier` exploration, and before the first goal. O(degree · actions).
    ///
    /// # Panics
    /// If `state` is not in the graph, or `advice` is shorter than the actions are many.
    pub fn look_ahead_from(&self, state: StateId, advice: &mut [f64]) {
        advice.fill(0.0);
        if let Some(exploration) = &self.exploration {
            exploration.look_ahead(
                self.graph.transitions(),
                state,
                &self.table,
                self.unit,
                advice,
            );
        }
    }

    /// The same for every state: n × actions, row-major. O(transitions · actions).
    pub fn look_ahead(&self) -> Vec<f64> {
        let graph = self.graph.transitions();
        let mut advice = vec![0.0; graph.num_states() * graph.num_actions()];
        for (s, row) in advice.chunks_exact_mut(graph.num_actions()).enumerate() {
            self.look_ahead_from(StateId(s as u32), row);
        }
        advice
    }

    /// The generator of the explorer with this number.
    pub(super) fn exploration_stream(&self, number: u32) -> ChaCha8Rng {
        seeds::substream(self.seed, Stream::Exploration, number)
    }

    /// What explorers share, and the graph that it is about; none without the `frontier` exploration.
    pub(super) fn exploration(&mut self) -> Option<(&mut ExplorationModel, &TransitionGraph)> {
        let graph = self.graph.transitions();
        Some((self.exploration.as_mut()?, graph))
    }

    /// Advice of `explorer` for `state`; all 0 without the `frontier` exploration.
    pub(super) fn advise(&mut self, explorer: &mut Explorer, state: StateId, advice: &mut [f64]) {
        if let Some(exploration) = &mut self.exploration {
            let graph = self.graph.transitions();
            explorer.advise(exploration, graph, state, &self.table, self.unit, advice);
        }
    }

    /// Reward for novelty under `count-bonus`, else 0.
    pub(super) fn count_bonus(&mut self, state: StateId) -> f64 {
        self.bonus.as_mut().map_or(0.0, |bonus| bonus.visit(state))
    }
}

/// Actions are numbers of 16 bits.
fn require_actions(num_actions: usize) -> Result<(), ParameterError> {
    match num_actions {
        1..=65_536 => Ok(()),
        _ => Err(ParameterError {
            section: "env",
            key: "num_actions",
            value: num_actions.to_string(),
            rule: "from 1 to 65536".into(),
        }),
    }
}
