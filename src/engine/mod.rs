//! The loop of environment, pipeline and agent.
//!
//! | type | is |
//! |---|---|
//! | [`WorldModel`] | what is known of the world: graph, features, potential, goals |
//! | [`Walker`] | where one explorer stands on it; several may share one model |
//! | [`ShapingPipeline`] | a model with one walker: transitions in, shaped rewards out, without the loop |
//! | [`Engine`] | the loop: one environment, one pipeline, one agent |
//! | [`ScheduleParams`] | when spectrum and potential are brought up to date |
//! | [`EpisodeRecord`], [`RefreshRecord`] | what happened, as rows |
//!
//! All of them but the parameters and rows are plain values that serde writes and reads, random streams included: an
//! engine that was written down in the middle of an episode and read back goes on as if nothing had happened.

mod error;
pub mod events;
mod goal_statistics;
mod params;
mod pipeline;
mod record;
mod returns;
mod schedule;
mod time_layers;
mod walker;
mod world_model;

pub use error::PipelineError;
pub use params::PipelineParams;
pub use pipeline::ShapingPipeline;
pub use record::{EpisodeRecord, RefreshRecord};
pub use schedule::ScheduleParams;
pub use walker::{Observed, Walker};
pub use world_model::WorldModel;

use crate::agent::{Agent, Experience, Situation};
use crate::env::{Environment, StepStatus};
use crate::graph::StateId;
use serde::{Deserialize, Serialize};
use std::hash::Hash;

/// One environment, one pipeline, one agent.
///
/// It can be written down and read back at any time, even in the middle of an episode; only the hook of
/// [`with_discovery_hook`](Self::with_discovery_hook) has to be given again.
#[derive(Serialize, Deserialize)]
#[serde(bound(
    serialize = "E: Serialize, E::State: Serialize, A: Serialize",
    deserialize = "E: Deserialize<'de>, E::State: Clone + Eq + Hash + Deserialize<'de>, A: Deserialize<'de>"
))]
pub struct Engine<E: Environment, A> {
    env: E,
    pipeline: ShapingPipeline<E::State>,
    agent: A,
    episode: u64,
    step: u64,
    first_goal_step: Option<u64>,
    /// The episode under way.
    under_way: Option<EpisodeRecord>,
    /// Called for every state when it is discovered.
    #[serde(skip)]
    on_discovery: Option<DiscoveryHook<E::State>>,
}

/// Gives the number that the potential is [told](crate::shaping::AnyPotential::tell) about a state.
pub type DiscoveryHook<S> = Box<dyn Fn(&S) -> f64 + Send>;

impl<E: Environment, A: Agent> Engine<E, A> {
    /// Joins the three, which must agree on the number of actions: else the first step is an error.
    pub fn new(env: E, pipeline: ShapingPipeline<E::State>, agent: A) -> Self {
        Self {
            env,
            pipeline,
            agent,
            episode: 0,
            step: 0,
            first_goal_step: None,
            under_way: None,
            on_discovery: None,
        }
    }

    /// Tells the potential a number about every state as it is discovered.
    pub fn with_discovery_hook(mut self, hook: DiscoveryHook<E::State>) -> Self {
        self.on_discovery = Some(hook);
        self
    }

    /// The same between two episodes, after the goals have moved: states that are known already are told about again. O(n).
    pub fn set_discovery_hook(&mut self, hook: DiscoveryHook<E::State>) {
        self.on_discovery = Some(hook);
        for state in 0..self.pipeline.transitions().num_states() {
            self.tell(StateId(state as u32));
        }
    }

    /// Runs to the end of the episode under way, or of a new one if there is none. `on_refresh` is handed every refresh as
    /// it happens, and the pipeline as it is after it.
    ///
    /// # Errors
    /// As [`step`](Self::step).
    pub fn run_episode(
        &mut self,
        mut on_refresh: impl FnMut(&RefreshRecord, &ShapingPipeline<E::State>),
    ) -> Result<EpisodeRecord, PipelineError> {
        loop {
            if let Some(record) = self.step(&mut on_refresh)? {
                return Ok(record);
            }
        }
    }

    /// As [`run_episode`](Self::run_episode), but left before the first step at which `pause` says so, which is handed the number of
    /// steps taken so far: none then, and the episode stays under way.
    ///
    /// # Errors
    /// As [`step`](Self::step).
    pub fn run_episode_until(
        &mut self,
        mut pause: impl FnMut(u64) -> bool,
        mut on_refresh: impl FnMut(&RefreshRecord, &ShapingPipeline<E::State>),
    ) -> Result<Option<EpisodeRecord>, PipelineError> {
        while !pause(self.step) {
            if let Some(record) = self.step(&mut on_refresh)? {
                return Ok(Some(record));
            }
        }
        Ok(None)
    }

    /// Takes one step; the first one of an episode resets the environment. The record of the episode if this was its
    /// last step.
    ///
    /// # Errors
    /// As [`Walker::observe`]; [`PipelineError::Diverged`] at the end of an episode whose TD errors were no numbers any
    /// more. The episode is then abandoned, and the next step begins a new one. [`PipelineError::NumActions`] if the environment has
    /// others than the pipeline was made for.
    ///
    /// # Panics
    /// If the environment does. Of that step nothing is known then, and whoever catches the panic may go on with the episode.
    pub fn step(
        &mut self,
        on_refresh: impl FnMut(&RefreshRecord, &ShapingPipeline<E::State>),
    ) -> Result<Option<EpisodeRecord>, PipelineError> {
        if self.under_way.is_none() {
            self.begin_episode()?;
        }
        let status = match self.step_on(on_refresh) {
            Ok(status) => status,
            Err(error) => {
                self.under_way = None;
                return Err(error);
            }
        };
        match self.under_way.take_if(|_| status.is_last()) {
            Some(record) if !record.td_squares.is_finite() => {
                Err(PipelineError::Diverged { step: self.step })
            }
            Some(record) => Ok(Some(self.end_record(record, status))),
            None => Ok(None),
        }
    }

    /// One step of the episode under way.
    #[inline]
    fn step_on(
        &mut self,
        mut on_refresh: impl FnMut(&RefreshRecord, &ShapingPipeline<E::State>),
    ) -> Result<StepStatus, PipelineError> {
        let state = self.pipeline.walker().state();
        let action = self.agent.select_action(Situation {
            state,
            advice: self.pipeline.advice(),
        });
        let step = self.env.step(action);
        self.step += 1;
        let seen = self.pipeline.observe(action, &step)?;
        self.note(&seen);
        if let Some(refresh) = &seen.refresh {
            self.take_up(refresh);
            on_refresh(refresh, &self.pipeline);
        }
        let reward = step.reward + seen.bonus;
        let learnt = self.agent.update(&Experience {
            state,
            action,
            reward,
            shaping: seen.shaping,
            next: Situation {
                state: seen.state,
                advice: self.pipeline.advice(),
            },
            status: step.status,
        });
        if seen.refresh.is_some_and(|refresh| refresh.fit.is_some()) {
            // After the step, so that the agent knows what was fitted: the end that it may have led to, and the state.
            self.agent.set_potential(self.pipeline.potential().values());
        }
        if let Some(record) = &mut self.under_way {
            record.length += 1;
            record.td_squares += learnt.td_error * learnt.td_error;
            record.plain_return += step.reward;
            record.shaped_return += reward + seen.shaping;
        }
        Ok(step.status)
    }

    fn begin_episode(&mut self) -> Result<(), PipelineError> {
        let expected = self.pipeline.transitions().num_actions();
        let actual = self.env.num_actions();
        if actual != expected {
            return Err(PipelineError::NumActions { expected, actual });
        }
        let start = self.env.reset();
        let state = self.pipeline.begin_episode(&start);
        self.tell(state);
        self.under_way = Some(self.begin_record());
        Ok(())
    }

    /// Logs what is rare.
    fn note(&mut self, seen: &Observed) {
        if seen.new_state {
            self.tell(seen.state);
        }
        if seen.first_goal {
            self.first_goal_step.get_or_insert(self.step);
        }
        events::observed(seen, self.step, self.pipeline.transitions().num_states());
    }

    /// Environment steps taken so far.
    pub fn steps(&self) -> u64 {
        self.step
    }

    /// The step, counted from 1, at which a goal was entered first; `None` before that.
    pub fn first_goal_step(&self) -> Option<u64> {
        self.first_goal_step
    }

    /// The pipeline: graph, spectrum, potential.
    pub fn pipeline(&self) -> &ShapingPipeline<E::State> {
        &self.pipeline
    }

    /// The agent.
    pub fn agent(&self) -> &A {
        &self.agent
    }

    /// The environment.
    pub fn env(&self) -> &E {
        &self.env
    }

    /// The environment, to change the task between two episodes. A goal that moves is noticed when the agent comes by
    /// where it was.
    pub fn env_mut(&mut self) -> &mut E {
        &mut self.env
    }

    fn tell(&mut self, state: StateId) {
        if let Some(hook) = &self.on_discovery {
            let number = hook(self.pipeline.graph().state(state));
            self.pipeline.world_mut().tell(state, number);
        }
    }

    /// Logs a refresh and hands new features and a new φ to the agent.
    fn take_up(&mut self, refresh: &RefreshRecord) {
        events::refreshed(refresh);
        if refresh.has_features()
            && let Some(features) = self.pipeline.agent_features()
        {
            self.agent.set_features(features);
        }
    }

    fn begin_record(&self) -> EpisodeRecord {
        EpisodeRecord {
            episode: self.episode,
            step: self.step,
            length: 0,
            plain_return: 0.0,
            shaped_return: 0.0,
            td_squares: 0.0,
            status: StepStatus::Running,
            nodes: 0,
            edges: 0,
        }
    }

    fn end_record(&mut self, mut record: EpisodeRecord, status: StepStatus) -> EpisodeRecord {
        let graph = self.pipeline.transitions();
        record.step = self.step;
        record.status = status;
        record.nodes = graph.num_states();
        record.edges = graph.adjacency().num_edges();
        self.episode += 1;
        record
    }
}
