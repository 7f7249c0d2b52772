//! The rules that parameters of learners obey.

use crate::env::LARGEST_RETURN;
use crate::parameter::{ParameterError, Section};

pub(crate) const AGENT: Section = Section("agent");

/// The rules of every learner that keeps a table of action values and is ε-greedy on it.
pub(crate) fn check_action_values(
    gamma: f64,
    epsilon: f64,
    initial_value: f64,
) -> Result<(), ParameterError> {
    check_gamma(gamma)?;
    check_epsilon(epsilon)?;
    check_return("initial_value", initial_value)
}

pub(crate) fn check_gamma(gamma: f64) -> Result<(), ParameterError> {
    let holds = (0.0..=1.0).contains(&gamma);
    AGENT.number("gamma", gamma, holds, "within 0 and 1")
}

pub(crate) fn check_rate(rate: f64) -> Result<(), ParameterError> {
    let holds = rate > 0.0 && rate <= 1.0;
    AGENT.number("critic_learning_rate", rate, holds, "above 0 and at most 1")
}

fn check_epsilon(epsilon: f64) -> Result<(), ParameterError> {
    let holds = (0.0..=1.0).contains(&epsilon);
    AGENT.number("epsilon", epsilon, holds, "within 0 and 1")
}

/// What can be a return, or something that is weighed against one.
pub(crate) fn check_return(key: &'static str, value: f64) -> Result<(), ParameterError> {
    let holds = value.abs() <= LARGEST_RETURN;
    AGENT.number(key, value, holds, "a number of at most 1e27 in size")
}

/// More work than this after a step would take for ever.
pub(crate) const MOST_WORK: usize = 1_000_000;

/// A count of work that is done after a step.
pub(crate) fn check_count(key: &'static str, value: usize) -> Result<(), ParameterError> {
    AGENT.count(key, value, 1..=MOST_WORK)
}

/// A bonus, in units of its own: at least 0.
pub(crate) fn check_bonus(key: &'static str, value: f64) -> Result<(), ParameterError> {
    let holds = (0.0..=1e6).contains(&value);
    AGENT.number(key, value, holds, "within 0 and 1e6")
}
