//! Checkpoints of a trial under way: when one is due, what is in it, and which one to go on from.
//!
//! Taking one changes nothing of the run: a run with checkpoints, or one that went on from any of them, leaves the same results to
//! the last byte as one without.

use super::error::RunnerError;
use super::observer::Observers;
use super::trial::Trial;
use crate::archive::checkpoint::{self, without_intervals};
use crate::archive::{ArchiveError, Checkpoint};
use crate::disk;
use crate::scenario::Scenario;
use serde_bytes::ByteBuf;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use tracing::{debug, warn};

/// Steps between two looks at the clock.
const STEPS_PER_LOOK: u64 = 256;

/// Keeper of the checkpoints of one trial.
pub(super) struct Checkpoints<'a> {
    folder: PathBuf,
    scenario: &'a Scenario,
    seed: u64,
    every_steps: Option<u64>,
    every: Option<Duration>,
    /// When the last one was taken: the steps, and the time.
    steps: u64,
    taken: Instant,
}

impl<'a> Checkpoints<'a> {
    /// The keeper of those of `seed`, which lie in `folder`.
    pub fn new(scenario: &'a Scenario, seed: u64, folder: &Path) -> Self {
        let (run, minutes) = (&scenario.run, scenario.run.checkpoint_every_minutes);
        Self {
            folder: folder.to_owned(),
            scenario,
            seed,
            every_steps: Some(run.checkpoint_every_steps).filter(|&steps| steps > 0),
            every: (minutes > 0.0).then(|| Duration::from_secs_f64(60.0 * minutes)),
            steps: 0,
            taken: Instant::now(),
        }
    }

    /// Whether one is to be taken after so many steps.
    #[inline]
    pub fn is_due(&self, steps: u64) -> bool {
        self.every_steps
            .is_some_and(|every| steps - self.steps >= every)
            || steps.is_multiple_of(STEPS_PER_LOOK)
                && self
                    .every
                    .is_some_and(|every| self.taken.elapsed() >= every)
    }

    /// Takes one. If it cannot be written the run goes on, and the older ones are still there; what observers have to bring to the
    /// disk must get there.
    ///
    /// # Errors
    /// What an observer could not write.
    pub fn take(
        &mut self,
        trial: &dyn Trial,
        observers: &mut Observers<'_>,
    ) -> Result<(), RunnerError> {
        (self.steps, self.taken) = (trial.steps(), Instant::now());
        let mut saved = BTreeMap::new();
        for observer in observers {
            if let Some((name, state)) = observer.save()? {
                saved.insert(name.to_owned(), ByteBuf::from(state));
            }
        }
        let written = trial.written().and_then(|run| {
            let checkpoint = Checkpoint {
                program: concat!("eigentrail ", env!("CARGO_PKG_VERSION")).to_owned(),
                scenario: self.scenario.to_toml(),
                seed: self.seed,
                steps: trial.steps(),
                episodes: trial.sums().lengths().len(),
                states: trial.knowledge().graph.num_states(),
                run: ByteBuf::from(run),
                observers: saved,
            };
            let made = disk::create_subfolder(&self.folder);
            made.map_err(|error| error.to_string())?;
            checkpoint
                .write(&self.folder)
                .map_err(|error| error.to_string())
        });
        let (steps, seconds) = (self.steps, self.taken.elapsed().as_secs_f64());
        match written {
            Ok(()) => debug!(name: "checkpoint", steps, seconds, "checkpoint"),
            Err(error) => {
                warn!("no checkpoint at step {steps}: {error}; the run goes on without it")
            }
        }
        Ok(())
    }

    /// What `load` makes of the newest checkpoint from which it can make something. Why others are passed over is said.
    pub fn go_on<T>(
        &mut self,
        load: impl Fn(&Checkpoint) -> Result<T, String>,
    ) -> Option<(Checkpoint, T)> {
        let (path, checkpoint, loaded) =
            self.usable()
                .find_map(|(path, checkpoint)| match load(&checkpoint) {
                    Ok(loaded) => Some((path, checkpoint, loaded)),
                    Err(reason) => {
                        pass_over(&format!("{}: {reason}", path.display()));
                        None
                    }
                })?;
        // What was passed over must not become the one before when the next is taken, in the place of this one.
        if let Err(error) = checkpoint::make_newest(&path) {
            warn!("{error}");
        }
        self.steps = checkpoint.steps;
        Some((checkpoint, loaded))
    }

    /// Those that are there and belong to this trial, the newest first, read when they are asked for. Why another one is passed
    /// over is said.
    fn usable(&self) -> impl Iterator<Item = (PathBuf, Checkpoint)> + '_ {
        let there = checkpoint::paths(&self.folder)
            .into_iter()
            .filter(|path| path.exists());
        there.filter_map(|path| match self.read(&path) {
            Ok(checkpoint) => Some((path, checkpoint)),
            Err(error) => {
                pass_over(&error);
                None
            }
        })
    }

    fn read(&self, path: &Path) -> Result<Checkpoint, ArchiveError> {
        let checkpoint = Checkpoint::read(path)?;
        let mismatch = |what: String| Err(ArchiveError::damaged(path, what));
        if checkpoint.seed != self.seed {
            return mismatch(format!("it is of seed {}", checkpoint.seed));
        }
        let there = without_intervals(&checkpoint.scenario);
        let here = without_intervals(&self.scenario.to_toml());
        let mut pairs = there.lines().zip(here.lines());
        match pairs.find(|(there, here)| there != here) {
            Some((there, here)) => mismatch(format!(
                "its scenario has `{there}` where this one has `{here}`"
            )),
            None if there != here => mismatch("its scenario differs".to_owned()),
            None => Ok(checkpoint),
        }
    }

    /// Removes them: the trial has ended, or begins anew.
    ///
    /// # Errors
    /// If one cannot be removed.
    pub fn remove(&self) -> Result<(), ArchiveError> {
        checkpoint::remove(&self.folder)
    }
}

/// Says why a checkpoint is not gone on from.
fn pass_over(reason: &impl std::fmt::Display) {
    warn!(
        "{reason}; this checkpoint is passed over, the one before it is tried, and without any the seed begins anew"
    );
}
