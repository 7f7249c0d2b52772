//! The rules that parameters of learners obey, and the error that names the one that is broken.

use crate::brief::brief;
use crate::env::LARGEST_RETURN;

/// What can be wrong with an agent's parameters.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AgentError {
    /// A number outside its range.
    #[error("agent.{key} is {}, but must be {rule}", brief(*.value))]
    OutOfRange {
        /// The key in the `[agent]` table.
        key: &'static str,
        /// What stands there.
        value: f64,
        /// The rule it breaks.
        rule: &'static str,
    },
}

/// `Ok` if `holds`.
pub(crate) fn check(
    key: &'static str,
    value: f64,
    holds: bool,
    rule: &'static str,
) -> Result<(), AgentError> {
    if holds {
        Ok(())
    } else {
        Err(AgentError::OutOfRange { key, value, rule })
    }
}

/// The rules of every learner that keeps a table of action values and is ε-greedy on it.
pub(crate) fn check_action_values(
    gamma: f64,
    epsilon: f64,
    initial_value: f64,
) -> Result<(), AgentError> {
    check_gamma(gamma)?;
    check_epsilon(epsilon)?;
    check_return("initial_value", initial_value)
}

pub(crate) fn check_gamma(gamma: f64) -> Result<(), AgentError> {
    check(
        "gamma",
        gamma,
        (0.0..=1.0).contains(&gamma),
        "within 0 and 1",
    )
}

pub(crate) fn check_rate(rate: f64) -> Result<(), AgentError> {
    check(
        "critic_learning_rate",
        rate,
        rate > 0.0 && rate <= 1.0,
        "above 0 and at most 1",
    )
}

fn check_epsilon(epsilon: f64) -> Result<(), AgentError> {
    check(
        "epsilon",
        epsilon,
        (0.0..=1.0).contains(&epsilon),
        "within 0 and 1",
    )
}

/// What can be a return, or something that is weighed against one.
pub(crate) fn check_return(key: &'static str, value: f64) -> Result<(), AgentError> {
    let rule = "a number of at most 1e27 in size";
    check(key, value, value.abs() <= LARGEST_RETURN, rule)
}

/// A count of work that is done after a step: more than a million would take for ever.
pub(crate) fn check_count(key: &'static str, value: usize) -> Result<(), AgentError> {
    let holds = (1..=1_000_000).contains(&value);
    check(key, value as f64, holds, "1 to 1000000")
}
