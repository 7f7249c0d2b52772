//! The built-in agent on a world model of its own, driven from outside.

use crate::calls::unlocked;
use crate::errors::raised;
use crate::parameters;
use crate::seen::{self, Key, Seen};
use eigentrail::agent::{Agent, AgentKind, AnyAgent, Experience, FeatureKind, Situation};
use eigentrail::features::FeatureSource;
use eigentrail::{Observed, PipelineError, ShapingPipeline, Step};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

/// Pipeline and agent, as the engine's loop joins them.
#[pyclass(module = "eigentrail._eigentrail")]
pub struct Learner {
    pipeline: ShapingPipeline<Key>,
    agent: AnyAgent,
    /// The action chosen last.
    chosen: Option<eigentrail::Action>,
}

impl Learner {
    fn take_in(
        &mut self,
        action: eigentrail::Action,
        step: &Step<Key>,
    ) -> Result<Observed, PipelineError> {
        let state = self.pipeline.walker().state();
        let seen = self.pipeline.observe(action, step)?;
        seen::log(self.pipeline.world(), &seen);
        if seen
            .refresh
            .as_ref()
            .is_some_and(|refresh| refresh.has_features())
            && let Some(features) = self.pipeline.agent_features()
        {
            self.agent.set_features(features);
        }
        let learnt = self.agent.update(&Experience {
            state,
            action,
            reward: step.reward + seen.bonus,
            shaping: seen.shaping,
            next: Situation {
                state: seen.state,
                advice: self.pipeline.advice(),
            },
            status: step.status,
        });
        if seen
            .refresh
            .as_ref()
            .is_some_and(|refresh| refresh.fit.is_some())
        {
            self.agent.set_potential(self.pipeline.potential().values());
        }
        match learnt.td_error.is_finite() {
            true => Ok(seen),
            false => Err(PipelineError::Diverged {
                step: self.pipeline.world().steps(),
            }),
        }
    }
}

#[pymethods]
impl Learner {
    #[new]
    fn new(
        num_actions: usize,
        gamma: f64,
        seed: u64,
        step_limit: Option<usize>,
        params: &str,
        agent: &str,
    ) -> PyResult<Self> {
        let pipeline_params = parameters::pipeline(params, gamma)?;
        let mut agent = parameters::agent(agent, gamma)?;
        if let Some(limit) = step_limit {
            agent = agent.with_step_limit(limit);
        }
        agent.validate().map_err(raised)?;
        let features = match (agent.kind, agent.features) {
            (AgentKind::ActorCritic, FeatureKind::Pvf) => Some(FeatureSource::Pvf),
            (AgentKind::ActorCritic, FeatureKind::Deepwalk) => Some(FeatureSource::Deepwalk),
            _ => None,
        };
        let pipeline = ShapingPipeline::new(&pipeline_params, num_actions, features, seed);
        Ok(Self {
            pipeline: pipeline.map_err(raised)?,
            agent: AnyAgent::new(&agent, num_actions, pipeline_params.shaping.mix, seed),
            chosen: None,
        })
    }

    fn begin_episode(&mut self, py: Python<'_>, key: &[u8]) -> PyResult<u32> {
        let pipeline = &mut self.pipeline;
        Ok(unlocked(py, || pipeline.begin_episode(&key.to_vec()))?.0)
    }

    /// The action that it takes next.
    fn act(&mut self, py: Python<'_>) -> PyResult<u16> {
        let (agent, pipeline) = (&mut self.agent, &self.pipeline);
        let action = unlocked(py, || {
            agent.select_action(Situation {
                state: pipeline.walker().state(),
                advice: pipeline.advice(),
            })
        })?;
        self.chosen = Some(action);
        Ok(action.0)
    }

    /// Learns from what came of the action chosen last.
    fn learn(
        &mut self,
        py: Python<'_>,
        key: &[u8],
        reward: f64,
        terminated: bool,
        truncated: bool,
    ) -> PyResult<Seen> {
        let Some(action) = self.chosen.take() else {
            return Err(PyRuntimeError::new_err(
                "no action was chosen; call act before learn",
            ));
        };
        let step = seen::step(key, reward, terminated, truncated);
        let seen = unlocked(py, || self.take_in(action, &step))?.map_err(raised)?;
        Ok(seen::told(self.pipeline.world(), &seen, step.status))
    }

    /// The likeliest action in a state, under what φ advises there; none where it knows nothing.
    fn greedy(&self, key: &[u8]) -> Option<u16> {
        let state = self.pipeline.graph().id(&key.to_vec())?;
        let mut advice = vec![0.0; self.pipeline.transitions().num_actions()];
        self.pipeline.world().look_ahead_from(state, &mut advice);
        Some(self.agent.greedy_action(state, &advice)?.0)
    }

    #[getter]
    fn num_nodes(&self) -> usize {
        self.pipeline.graph().num_states()
    }
}
