//! Errors on the way from a transition to a shaped reward.

use crate::features::FeatureError;
use crate::shaping::ShapingError;

/// Error of a pipeline, of a walker on a world model, or of the loop around them.
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
    /// A step was told of an action that the world does not have.
    #[error("step {step}: action {action} of a world whose actions are 0..{num_actions}")]
    Action {
        /// Environment step.
        step: u64,
        /// The action's number.
        action: u16,
        /// How many there are.
        num_actions: usize,
    },
    /// The environment has another number of actions than the pipeline was made for.
    #[error(
        "the environment has {actual} actions and the pipeline was made for {expected}: make both of one environment"
    )]
    NumActions {
        /// Of the pipeline.
        expected: usize,
        /// Of the environment.
        actual: usize,
    },
    /// A step was told of while no episode was under way.
    #[error("step {step}: no episode is under way; call begin_episode after each reset")]
    NoEpisode {
        /// Environment step.
        step: u64,
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
