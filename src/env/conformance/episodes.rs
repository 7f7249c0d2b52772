//! Playing the kit's episodes and writing down what happened.

use crate::env::{Action, Environment, Step, StepStatus};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Seeds of the random episodes.
pub(super) const SEEDS: std::ops::Range<u64> = 0..4;
/// Episodes of random actions per seed.
const RANDOM_EPISODES: usize = 6;
/// Steps after which an episode is left: worlds without a step limit may go on for ever.
const PATIENCE: usize = 20_000;

/// An episode as it was answered.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Episode<S> {
    pub start: S,
    pub steps: Vec<(Action, Step<S>)>,
}

impl<S> Episode<S> {
    /// How it stood after the last step.
    pub(super) fn status(&self) -> StepStatus {
        self.steps
            .last()
            .map_or(StepStatus::Running, |(_, step)| step.status)
    }
}

/// A call that panicked, with what it said.
pub(super) struct Panicked(pub String);

/// Runs `call` and catches its panic.
pub(super) fn caught<T>(call: impl FnOnce() -> T) -> Result<T, Panicked> {
    catch_unwind(AssertUnwindSafe(call)).map_err(|payload| {
        let text = payload.downcast_ref::<String>().cloned();
        let literal = || {
            payload
                .downcast_ref::<&str>()
                .map(|text| (*text).to_owned())
        };
        Panicked(text.or_else(literal).unwrap_or_default())
    })
}

/// Plays one episode to its end or for at most `limit` steps; `action(t)` is taken at step t.
pub(super) fn play<E: Environment>(
    world: &mut E,
    limit: usize,
    mut action: impl FnMut(usize) -> Action,
) -> Result<Episode<E::State>, Panicked> {
    let mut episode = Episode {
        start: caught(|| world.reset())?,
        steps: Vec::new(),
    };
    while episode.steps.len() < limit && !episode.status().is_last() {
        let action = action(episode.steps.len());
        let step = caught(|| world.step(action))?;
        episode.steps.push((action, step));
    }
    Ok(episode)
}

/// The kit's episodes on one world: random ones, some of them left in the middle, and one per action repeated.
///
/// `limit` is the step limit, if there is one. The actions depend on nothing but the number of actions.
pub(super) fn play_all<E: Environment>(
    world: &mut E,
    limit: Option<usize>,
) -> Result<Vec<Episode<E::State>>, Panicked> {
    let actions = world.num_actions().min(usize::from(u16::MAX)) as u16;
    // One step beyond the limit shows a limit that comes too late.
    let patience = limit.map_or(PATIENCE, |limit| limit.saturating_add(1).min(PATIENCE));
    let mut rng = ChaCha8Rng::seed_from_u64(u64::from(actions));
    let mut episodes = Vec::new();
    for i in 0..RANDOM_EPISODES {
        // Every other one is left after a few steps, so that the next reset comes in the middle.
        let stop = if i % 2 == 0 {
            3.min(patience)
        } else {
            patience
        };
        episodes.push(play(world, stop, |_| Action(rng.random_range(0..actions)))?);
    }
    for repeated in (0..actions).take(8) {
        episodes.push(play(world, patience, |_| Action(repeated))?);
    }
    Ok(episodes)
}
