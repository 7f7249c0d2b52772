//! From transitions to shaped rewards: graph, spectrum, GCN, potential and shaper in one object, without a loop.
//!
//! For those who bring their own agent: call [`ShapingPipeline::begin_episode`] after each reset and
//! [`ShapingPipeline::observe`] after each step, and learn from `reward + observed.shaping`.
//!
//! **Goals may move.** A state where an episode terminated is believed to be a goal until an episode goes on there.
//! Then it is forgotten: φ is fitted anew on the goals that are left, or is 0 again when there are none, and the search
//! for a first goal begins anew. A world whose episodes terminate in a state only now and then is not what this is
//! for: each visit would refit φ.
//!
//! **Before the first goal** φ is flat and there is no fit. Features follow the growing graph all the same, each refresh
//! from the one before: the first fit finds them ready, and whoever watches sees the graph unfold.

mod bookkeeping;
mod params;
mod refresh;

pub use params::{Observed, PipelineError, PipelineParams};

use super::goals::GoalBook;
use super::schedule::RefreshSchedule;
use crate::env::{Action, Step, StepStatus};
use crate::exploration::{CountBonus, ExplorationKind, Explorer};
use crate::features::{FeatureSet, FeatureSource};
use crate::graph::{StateGraph, StateId, TransitionGraph};
use crate::seeds::{self, Stream};
use crate::shaping::{
    AbsorbingChain, AnyPotential, Potential, PotentialKind, PotentialTable, RewardShaper,
    TransitionMatrix, build_potential,
};
use crate::spectral::ProtoValueFunctions;
use faer::MatRef;
use std::hash::Hash;

/// What guides the agent beside the potential.
#[derive(Clone, Debug)]
enum Guide {
    None,
    Bonus(CountBonus),
    Frontier(Box<Explorer>),
}

/// The pipeline over any hashable state. Memory O(states + transitions + n k).
pub struct ShapingPipeline<S> {
    graph: StateGraph<S>,
    features: FeatureSet,
    gcn_features: FeatureSource,
    agent_features: Option<FeatureSource>,
    model: AnyPotential,
    table: PotentialTable,
    shaper: RewardShaper,
    guide: Guide,
    schedule: RefreshSchedule,
    book: GoalBook,
    /// Rise of φ that one step towards a goal is worth on average.
    unit: f64,
    step: u64,
    pairs_tried: u64,
    start: StateId,
    state: StateId,
    in_episode: bool,
    /// For `state`.
    advice: Vec<f64>,
}

impl<S: Clone + Eq + Hash> ShapingPipeline<S> {
    /// An empty graph, a flat potential.
    ///
    /// Features are kept up to date if the potential uses them, or the agent, which is linear in `agent_features`.
    /// `seed` is the master seed of the run; every part draws from its own stream. `params` are taken to be valid.
    ///
    /// # Panics
    /// Unless 1 ≤ `num_actions` ≤ 65 536 and `params.gamma` is in [0, 1].
    pub fn new(
        params: &PipelineParams,
        num_actions: usize,
        agent_features: Option<FeatureSource>,
        seed: u64,
    ) -> Self {
        let guide = match params.exploration.kind {
            ExplorationKind::None => Guide::None,
            ExplorationKind::CountBonus => Guide::Bonus(CountBonus::new(params.exploration.bonus)),
            ExplorationKind::Frontier => {
                let rng = seeds::stream(seed, Stream::Exploration);
                Guide::Frontier(Box::new(Explorer::new(
                    params.exploration.clone(),
                    num_actions,
                    rng,
                )))
            }
        };
        let learnt = matches!(
            params.shaping.potential,
            PotentialKind::Gcn | PotentialKind::Report
        );
        let gcn_features = params.gcn.features;
        let for_gcn = learnt.then_some(gcn_features);
        let used: Vec<_> = for_gcn.into_iter().chain(agent_features).collect();
        Self {
            graph: StateGraph::new(num_actions),
            features: FeatureSet::new(&used, &params.spectral, &params.deepwalk, seed),
            gcn_features,
            agent_features,
            model: build_potential(&params.shaping, &params.gcn, seed),
            table: PotentialTable::new(),
            shaper: RewardShaper::new(params.gamma),
            guide,
            schedule: RefreshSchedule::new(params.schedule.clone()),
            book: GoalBook::default(),
            unit: 1.0,
            step: 0,
            pairs_tried: 0,
            start: StateId(0),
            state: StateId(0),
            in_episode: false,
            advice: vec![0.0; num_actions],
        }
    }

    /// Begins an episode in `start`, returns its number. An episode under way is abandoned.
    ///
    /// O(1), but O(states + transitions) with the `frontier` exploration if the start is another one than last time.
    pub fn begin_episode(&mut self, start: &S) -> StateId {
        let (state, _) = self.graph.intern(start);
        self.start = state;
        self.state = state;
        self.in_episode = true;
        self.shaper.begin_episode(self.table.value(state));
        if let Guide::Frontier(explorer) = &mut self.guide {
            explorer.begin_episode(self.graph.transitions(), state);
        }
        self.update_advice();
        state
    }

    /// Takes in one step from the present state and returns what it was worth.
    ///
    /// O(1) among known states, plus the refreshes that the schedule asks for. Without them, and with no state or
    /// transition that is new, it allocates nothing; but where moves slip, the frontier exploration looks over all
    /// transitions each time that the steps have grown by a sixteenth.
    ///
    /// # Errors
    /// If the reward is not finite, and then nothing has changed; or if the spectrum or the potential cannot be computed.
    ///
    /// # Panics
    /// If no episode is under way, or if `action` is out of range.
    pub fn observe(&mut self, action: Action, step: &Step<S>) -> Result<Observed, PipelineError> {
        assert!(
            self.in_episode,
            "a step without an episode: call begin_episode first"
        );
        assert!(
            action.index() < self.advice.len(),
            "action {} of {}",
            action.0,
            self.advice.len()
        );
        if !step.reward.is_finite() {
            return Err(PipelineError::Reward {
                step: self.step,
                reward: step.reward,
            });
        }
        self.step += 1;
        let terminated = step.status == StepStatus::Terminated;
        let (next, new_state) = self.graph.intern(&step.state);
        self.record(action, step.reward, next, new_state, terminated);
        let first_goal = self.book.is_empty() && terminated;
        let lost_goal = !terminated && self.forget_goal(next);
        self.keep_book(next, step);
        let refresh = self.refresh_if_due(step.status.is_last())?;
        let shaping = self.shaper.shape(self.table.value(next), step.status);
        let bonus = match &mut self.guide {
            Guide::Bonus(bonus) => bonus.visit(next),
            _ => 0.0,
        };
        self.state = next;
        self.in_episode = !step.status.is_last();
        if terminated {
            self.advice.fill(0.0);
        } else {
            self.update_advice();
        }
        Ok(Observed {
            state: next,
            shaping,
            bonus,
            new_state,
            first_goal,
            lost_goal,
            refresh,
        })
    }

    /// Advice for the present state, one logit per action; all 0 without the `frontier` exploration, and after
    /// termination. After truncation it is that of the last state, whose value still counts.
    pub fn advice(&self) -> &[f64] {
        &self.advice
    }

    /// The graph discovered so far.
    pub fn graph(&self) -> &StateGraph<S> {
        &self.graph
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

    /// The tried transitions of [`Self::graph`], for numerical code.
    pub fn transitions(&self) -> &TransitionGraph {
        self.graph.transitions()
    }

    /// Goals seen so far and not lost since, with their mean rewards, in the order of discovery.
    pub fn goals(&self) -> &[crate::shaping::Goal] {
        self.book.goals()
    }

    /// Tells the oracle potential the true distance of a state, in typical steps. Other potentials do not listen.
    pub fn set_true_distance(&mut self, state: StateId, distance: f64) {
        self.model.set_true_distance(state, distance);
    }

    /// Where the potential as it stands would hold up an agent that climbs it: states from which a goal can be reached
    /// over the moves seen, none of whose moves leads to a larger φ. None before the first goal. O((n + transitions) log n).
    ///
    /// # Errors
    /// If an edge weight is not finite and positive.
    pub fn spurious_maxima(&self) -> Result<Vec<StateId>, PipelineError> {
        let graph = self.graph.transitions();
        let goals: Vec<u32> = self.book.states().map(|goal| goal.0).collect();
        let transitions = TransitionMatrix::observed(graph, &graph.adjacency().to_csr());
        let chain = AbsorbingChain::by_hops(&transitions, &goals);
        let states = 0..graph.num_states() as u32;
        let phi: Vec<f64> = states.map(|s| self.table.value(StateId(s))).collect();
        Ok(chain.spurious_maxima(&phi))
    }

    /// What φ as it stands advises everywhere, quests left out: n × actions, row-major, in logits. All 0 without
    /// exploration, and before the first goal. O(n · degree), and a copy of what the explorer knows.
    pub fn look_ahead(&self) -> Vec<f64> {
        let graph = self.graph.transitions();
        let mut advice = vec![0.0; graph.num_states() * graph.num_actions()];
        if let Guide::Frontier(explorer) = &self.guide {
            let mut explorer = explorer.clone();
            for (s, row) in advice.chunks_exact_mut(graph.num_actions()).enumerate() {
                explorer.look_ahead(graph, StateId(s as u32), &self.table, self.unit, row);
            }
        }
        advice
    }

    fn update_advice(&mut self) {
        if let Guide::Frontier(explorer) = &mut self.guide {
            explorer.advise(
                self.graph.transitions(),
                self.state,
                &self.table,
                self.unit,
                &mut self.advice,
            );
        }
    }
}
