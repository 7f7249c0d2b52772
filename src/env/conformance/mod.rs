//! The contract of [`Environment`] as a test kit: one call checks a world, yours or ours.
//!
//! ```
//! use eigentrail::env::conformance::{Expectations, check_environment};
//! use eigentrail::env::{Environment, GridWorld, GridWorldParams, Landmark, Layout};
//! use eigentrail::seeds::{Stream, stream};
//!
//! let layout = Layout::open(4, 4)?.with_start(Landmark::TopLeft)?.with_goal(Landmark::BottomRight, None)?;
//! let params = GridWorldParams { slip: 0.1, ..GridWorldParams::default() };
//! let make = |seed| {
//!     GridWorld::new(layout.clone(), params.clone(), stream(seed, Stream::Environment)).expect("the layout is valid")
//! };
//! let coverage = check_environment(make, &Expectations { max_steps: Some(160), random: true })?;
//! assert!(coverage.terminations > 0 && coverage.truncations > 0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The kit plays seeded random episodes and episodes of one repeated action. It can only report what it has seen: look
//! at the [`Coverage`] it returns. Episodes are left after 20 000 steps, so longer limits are not seen. Steps that must
//! panic are caught, but the panic hook still prints their messages.

mod contract;
mod episodes;
mod model;

pub use model::check_model;

use super::Environment;
use std::fmt;

/// Facts that the maker of a world knows about it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Expectations {
    /// After how many steps its episodes are truncated; `None` if they never are.
    pub max_steps: Option<usize>,
    /// Whether different seeds must lead to different episodes.
    pub random: bool,
}

/// What the kit has seen, so that a test can insist that it saw enough.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Coverage {
    /// Episodes begun.
    pub episodes: usize,
    /// Steps taken.
    pub steps: usize,
    /// Episodes that ended because the task was over.
    pub terminations: usize,
    /// Episodes that the clock ended.
    pub truncations: usize,
    /// Different states met.
    pub states: usize,
}

/// A broken rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Rule {
    /// There is at least one action, and their number never changes.
    ActionsAreFixed,
    /// `step` before the first `reset` panics.
    StepBeforeResetPanics,
    /// `step` after the end of an episode panics.
    StepAfterEndPanics,
    /// An action number beyond the last panics.
    UnknownActionPanics,
    /// `reset` and legal steps do not panic.
    LegalCallsDoNotPanic,
    /// Rewards are finite.
    RewardsAreFinite,
    /// Two copies with one seed answer alike.
    SameSeedSameAnswers,
    /// Worlds with randomness answer differently to different seeds.
    SeedsDiffer,
    /// Episodes are truncated at the step limit and not before.
    TruncatedExactlyAtLimit,
    /// `reset` in the middle of an episode begins a new one, with the whole step limit.
    ResetBeginsAnew,
    /// Episodes begin in one of the model's starts, which are not terminal.
    StartsAreStarts,
    /// Every transition has positive probability in the model, and its reward.
    TransitionsAreInTheModel,
    /// An episode is terminated exactly when it enters a terminal state, also on the last step.
    TerminatedExactlyAtTerminalStates,
    /// The model has as many actions as the world.
    ModelHasTheSameShape,
}

impl fmt::Display for Rule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Rule::ActionsAreFixed => "there is at least one action, and their number never changes",
            Rule::StepBeforeResetPanics => "step before the first reset panics",
            Rule::StepAfterEndPanics => "step after the end of an episode panics",
            Rule::UnknownActionPanics => "an action number beyond the last panics",
            Rule::LegalCallsDoNotPanic => "reset and legal steps do not panic",
            Rule::RewardsAreFinite => "rewards are finite",
            Rule::SameSeedSameAnswers => "two copies with one seed answer alike",
            Rule::SeedsDiffer => "different seeds lead to different episodes",
            Rule::TruncatedExactlyAtLimit => {
                "episodes are truncated at the step limit and not before"
            }
            Rule::ResetBeginsAnew => "reset begins a new episode with the whole step limit",
            Rule::StartsAreStarts => {
                "episodes begin in one of the model's starts, which are not terminal"
            }
            Rule::TransitionsAreInTheModel => {
                "every transition is possible in the model and earns its reward"
            }
            Rule::TerminatedExactlyAtTerminalStates => {
                "an episode is terminated exactly on entering a terminal state"
            }
            Rule::ModelHasTheSameShape => "model and world have the same number of actions",
        })
    }
}

/// One broken rule and what was seen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Violation {
    /// The rule.
    pub rule: Rule,
    /// Where it was broken first.
    pub seen: String,
}

/// The broken rules, each once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Violations(pub Vec<Violation>);

impl Violations {
    /// Whether `rule` is among them.
    pub fn contains(&self, rule: Rule) -> bool {
        self.0.iter().any(|violation| violation.rule == rule)
    }

    /// Notes the first time a rule is broken.
    fn note(&mut self, rule: Rule, seen: impl Into<String>) {
        if !self.contains(rule) {
            self.0.push(Violation {
                rule,
                seen: seen.into(),
            });
        }
    }
}

impl fmt::Display for Violations {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, Violation { rule, seen }) in self.0.iter().enumerate() {
            write!(f, "{}{rule} ({seen})", if i == 0 { "" } else { "\n" })?;
        }
        Ok(())
    }
}

impl std::error::Error for Violations {}

/// Checks the contract of [`Environment`]. `make(seed)` builds a fresh world; it is called a few dozen times.
///
/// # Errors
/// Every rule that was seen broken.
pub fn check_environment<E: Environment>(
    make: impl Fn(u64) -> E,
    expectations: &Expectations,
) -> Result<Coverage, Violations> {
    let mut violations = Violations(Vec::new());
    let coverage = contract::check(&make, expectations, &mut violations);
    if violations.0.is_empty() {
        Ok(coverage)
    } else {
        Err(violations)
    }
}

#[cfg(test)]
mod tests;
