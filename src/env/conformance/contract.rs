//! The rules that hold for any environment.

use super::episodes::{Episode, Panicked, SEEDS, caught, play, play_all};
use super::{Coverage, Expectations, Rule, Violations};
use crate::env::{Action, Environment, StepStatus};
use std::collections::HashSet;
use std::fmt::Debug;
use std::hash::Hash;

/// The seed of the checks that need only one.
const SEED: u64 = SEEDS.start;

/// Checks every rule of the contract and returns what was seen.
pub(super) fn check<E: Environment>(
    make: &impl Fn(u64) -> E,
    expectations: &Expectations,
    violations: &mut Violations,
) -> Coverage {
    if make(SEED).num_actions() == 0 {
        violations.note(Rule::ActionsAreFixed, "num_actions() = 0");
        return Coverage::default();
    }
    check_misuse(make, expectations, violations);
    let played: Result<Vec<_>, Panicked> = SEEDS
        .map(|seed| episodes_of_twins(make, seed, expectations, violations))
        .collect();
    match played {
        Ok(by_seed) => {
            check_seeds_differ(&by_seed, expectations, violations);
            by_seed
                .iter()
                .for_each(|episodes| check_clock(episodes, expectations, violations));
            let episodes: Vec<_> = by_seed.into_iter().flatten().collect();
            episodes
                .iter()
                .for_each(|episode| check_rewards(episode, violations));
            coverage(&episodes)
        }
        Err(Panicked(message)) => {
            violations.note(Rule::LegalCallsDoNotPanic, message);
            Coverage::default()
        }
    }
}

/// Calls that must panic.
fn check_misuse<E: Environment>(
    make: &impl Fn(u64) -> E,
    expectations: &Expectations,
    violations: &mut Violations,
) {
    let mut fresh = make(SEED);
    if caught(|| fresh.step(Action(0))).is_ok() {
        violations.note(Rule::StepBeforeResetPanics, "a fresh world answered a step");
    }
    let mut begun = make(SEED);
    let beyond = begun.num_actions();
    if let (Ok(beyond), Ok(_)) = (u16::try_from(beyond), caught(|| begun.reset()))
        && caught(|| begun.step(Action(beyond))).is_ok()
    {
        violations.note(
            Rule::UnknownActionPanics,
            format!("action {beyond} of {beyond} was answered"),
        );
    }
    let limit = expectations.max_steps.unwrap_or(usize::MAX).min(100_000);
    for repeated in (0..begun.num_actions().min(8) as u16).map(Action) {
        let mut ended = make(SEED);
        let Ok(episode) = play(&mut ended, limit, |_| repeated) else {
            continue;
        };
        if episode.status().is_last() && caught(|| ended.step(repeated)).is_ok() {
            let seen = format!(
                "a step was answered after the episode was {:?}",
                episode.status()
            );
            violations.note(Rule::StepAfterEndPanics, seen);
        }
    }
}

/// Plays the same episodes on two copies and compares.
fn episodes_of_twins<E: Environment>(
    make: &impl Fn(u64) -> E,
    seed: u64,
    expectations: &Expectations,
    violations: &mut Violations,
) -> Result<Vec<Episode<E::State>>, Panicked> {
    let (mut one, mut other) = (make(seed), make(seed));
    let actions = one.num_actions();
    let episodes = play_all(&mut one, expectations.max_steps)?;
    if one.num_actions() != actions {
        violations.note(
            Rule::ActionsAreFixed,
            format!("{actions}, later {}", one.num_actions()),
        );
    }
    let again = play_all(&mut other, expectations.max_steps)?;
    if let Some(i) = (0..episodes.len()).find(|&i| !same(&episodes[i], &again[i])) {
        violations.note(
            Rule::SameSeedSameAnswers,
            format!("seed {seed}, episode {i}"),
        );
    }
    Ok(episodes)
}

/// Equality to the bit, so that a NaN equals itself and is reported as what it is.
fn same<S: PartialEq>(one: &Episode<S>, other: &Episode<S>) -> bool {
    one.start == other.start
        && one.steps.len() == other.steps.len()
        && one.steps.iter().zip(&other.steps).all(|((_, a), (_, b))| {
            a.state == b.state && a.reward.to_bits() == b.reward.to_bits() && a.status == b.status
        })
}

fn check_seeds_differ<S: PartialEq>(
    by_seed: &[Vec<Episode<S>>],
    expectations: &Expectations,
    violations: &mut Violations,
) {
    let all_alike = by_seed
        .iter()
        .all(|episodes| episodes.iter().zip(&by_seed[0]).all(|(a, b)| same(a, b)));
    if expectations.random && all_alike {
        violations.note(
            Rule::SeedsDiffer,
            format!("seeds {SEEDS:?} gave the same episodes"),
        );
    }
}

fn check_rewards<S: Debug>(episode: &Episode<S>, violations: &mut Violations) {
    if let Some((action, step)) = episode
        .steps
        .iter()
        .find(|(_, step)| !step.reward.is_finite())
    {
        let seen = format!(
            "{} for action {} into {:?}",
            step.reward, action.0, step.state
        );
        violations.note(Rule::RewardsAreFinite, seen);
    }
}

/// The clock, over episodes that one world played one after the other.
fn check_clock<S>(
    episodes: &[Episode<S>],
    expectations: &Expectations,
    violations: &mut Violations,
) {
    let limit = expectations
        .max_steps
        .map_or("no limit".to_owned(), |limit| format!("limit {limit}"));
    let mut left_in_the_middle = false;
    for episode in episodes {
        let length = episode.steps.len();
        if episode.status() == StepStatus::Truncated
            && expectations.max_steps.is_none_or(|limit| length < limit)
        {
            // If only the episode before was cut short, its steps may have been counted on.
            let rule = if left_in_the_middle {
                Rule::ResetBeginsAnew
            } else {
                Rule::TruncatedExactlyAtLimit
            };
            violations.note(rule, format!("truncated after {length} steps, {limit}"));
        }
        let at_limit = expectations
            .max_steps
            .and_then(|limit| episode.steps.get(limit.saturating_sub(1)));
        if at_limit.is_some_and(|(_, step)| step.status == StepStatus::Running) {
            violations.note(
                Rule::TruncatedExactlyAtLimit,
                format!("still running at its {limit}"),
            );
        }
        left_in_the_middle = episode.status() == StepStatus::Running;
    }
}

fn coverage<S: Eq + Hash>(episodes: &[Episode<S>]) -> Coverage {
    let ended = |status| {
        episodes
            .iter()
            .filter(|episode| episode.status() == status)
            .count()
    };
    let met = episodes.iter().flat_map(|episode| {
        std::iter::once(&episode.start).chain(episode.steps.iter().map(|(_, step)| &step.state))
    });
    Coverage {
        episodes: episodes.len(),
        steps: episodes.iter().map(|episode| episode.steps.len()).sum(),
        terminations: ended(StepStatus::Terminated),
        truncations: ended(StepStatus::Truncated),
        states: met.collect::<HashSet<_>>().len(),
    }
}
