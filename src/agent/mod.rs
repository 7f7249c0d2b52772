//! The learners. They see state numbers, rewards and advice, never a graph network. (interface sketch)

use crate::env::{Action, StepStatus};
use crate::graph::StateId;

/// Where the agent stands, and what exploration advises there.
#[derive(Clone, Copy, Debug)]
pub struct Situation<'a> {
    pub state: StateId,
    /// One number per action, added to the policy's logits (look-ahead advice); all 0 when there is none.
    pub advice: &'a [f64],
}

/// One step as the agent learns from it.
#[derive(Clone, Copy, Debug)]
pub struct Experience<'a> {
    pub state: StateId,
    pub action: Action,
    /// Plain reward of the environment.
    pub reward: f64,
    /// Shaping F to add to it (0 without shaping).
    pub shaping: f64,
    pub next: Situation<'a>,
    pub status: StepStatus,
}

/// What an update did, for the log.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct UpdateInfo {
    pub td_error: f64,
}

/// A learner.
pub trait Agent {
    /// Chooses an action; grows its tables when it meets a state number beyond them.
    fn select_action(&mut self, situation: Situation<'_>) -> Action;
    /// Learns from one step. Called once after each step, before the next `select_action`.
    fn update(&mut self, experience: &Experience<'_>) -> UpdateInfo;
    /// Linear features of every known state, n × k row-major, after a spectrum refresh; agents that use tables ignore it.
    fn set_features(&mut self, _features: faer::MatRef<'_, f64>) {}
}
