//! What a pipeline is told, and what it says of a step.

use crate::engine::record::RefreshRecord;
use crate::engine::schedule::ScheduleParams;
use crate::exploration::ExplorationParams;
use crate::features::{DeepWalkParams, FeatureError};
use crate::gcn::GcnParams;
use crate::graph::StateId;
use crate::shaping::{ShapingError, ShapingParams};
use crate::spectral::SpectralParams;

/// Parameters of every part of the pipeline.
#[derive(Clone, Debug)]
pub struct PipelineParams {
    /// Eigenpairs.
    pub spectral: SpectralParams,
    /// Random walks.
    pub deepwalk: DeepWalkParams,
    /// Network.
    pub gcn: GcnParams,
    /// Potential and scale.
    pub shaping: ShapingParams,
    /// Advice before and after the first goal.
    pub exploration: ExplorationParams,
    /// When to refresh and to fit.
    pub schedule: ScheduleParams,
    /// The discount that the agent learns with.
    pub gamma: f64,
}

impl Default for PipelineParams {
    /// The defaults of every part, and γ = 1 as in the source report.
    fn default() -> Self {
        Self {
            spectral: SpectralParams::default(),
            deepwalk: DeepWalkParams::default(),
            gcn: GcnParams::default(),
            shaping: ShapingParams::default(),
            exploration: ExplorationParams::default(),
            schedule: ScheduleParams::default(),
            gamma: 1.0,
        }
    }
}

/// Why the pipeline could not go on.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PipelineError {
    /// The features could not be refreshed.
    #[error("refreshing the features: {0}")]
    Features(#[from] FeatureError),
    /// The potential could not be fitted.
    #[error("fitting the potential: {0}")]
    Shaping(#[from] ShapingError),
    /// The environment answered with a reward that is no number.
    #[error("step {step}: the reward is {reward}; rewards must be finite")]
    Reward {
        /// Environment step.
        step: u64,
        /// What came.
        reward: f64,
    },
    /// What the learner thinks of states has grown beyond all numbers.
    #[error(
        "step {step}: the learner's values have diverged; lower agent.critic_learning_rate, or use agent.features = \"tabular\""
    )]
    Diverged {
        /// Environment step.
        step: u64,
    },
}

/// What one step meant.
#[derive(Clone, Debug)]
pub struct Observed {
    /// The number of the state that was reached.
    pub state: StateId,
    /// F = γ φ(s′) − φ(s), to be added to the reward; 0 without shaping.
    pub shaping: f64,
    /// Reward for novelty under `count-bonus`, else 0. Not potential-based.
    pub bonus: f64,
    /// The state was not known before.
    pub new_state: bool,
    /// A goal was entered while none was known: the first one, or the first after the last one was lost.
    pub first_goal: bool,
    /// The state was a goal until now, and the episode went on: the goal is forgotten.
    pub lost_goal: bool,
    /// The spectrum or the potential was brought up to date.
    pub refresh: Option<Box<RefreshRecord>>,
}
