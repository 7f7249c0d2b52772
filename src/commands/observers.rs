//! Observers of a run that belong to the program: its log of events and its progress.

use super::progress::Progress;
use eigentrail::archive::{ArchiveError, Checkpoint, names};
use eigentrail::runner::{Episode, Refresh, RunObserver, RunStart, RunState, SavedObserver, save};
use eigentrail::telemetry::{EventLog, SeedLog};
use std::io;
use std::path::PathBuf;
use std::time::{Duration, Instant};
use tracing::Span;

/// How often the log of events is brought up to date.
const FLUSH_EVERY: Duration = Duration::from_secs(2);

/// Keeper of `events.jsonl` of one seed.
pub struct EventKeeper {
    log: SeedLog,
    path: PathBuf,
    flushed: Instant,
}

impl EventKeeper {
    /// Begins the file anew, or goes on with it as the seed does; what happens in the present span goes there.
    pub fn create(events: &EventLog, start: &RunStart<'_>) -> Result<Self, ArchiveError> {
        let path = start.folder.join(names::EVENTS);
        let log = match start.saved(NAME) {
            Some(length) => events.go_on(&path, length),
            None => events.open(&path),
        };
        let log = log.map_err(write_error(&path))?;
        Span::current().record("log", log.number());
        Ok(Self {
            log,
            path,
            flushed: Instant::now(),
        })
    }
}

impl RunObserver for EventKeeper {
    fn episode_ended(&mut self, _: &Episode<'_>, _: &dyn RunState) -> Result<(), ArchiveError> {
        if self.flushed.elapsed() < FLUSH_EVERY {
            return Ok(());
        }
        self.flushed = Instant::now();
        self.flush()
    }

    fn flush(&mut self) -> Result<(), ArchiveError> {
        self.log.flush().map_err(write_error(&self.path))
    }

    fn ended(&mut self, _: &dyn RunState) -> Result<(), ArchiveError> {
        self.log.sync().map_err(write_error(&self.path))?;
        Ok(())
    }

    fn save(&mut self) -> Result<Option<SavedObserver>, ArchiveError> {
        let length = self.log.sync().map_err(write_error(&self.path))?;
        Ok(save(NAME, &length))
    }
}

/// The keeper's name in checkpoints.
const NAME: &str = "events";

fn write_error(path: &std::path::Path) -> impl FnOnce(io::Error) -> ArchiveError + '_ {
    |source| ArchiveError::Write {
        path: path.to_owned(),
        source,
    }
}

/// Observer of one seed that moves the bar of a run.
pub struct EpisodeProgress<'a> {
    progress: &'a Progress,
    /// Steps that were told.
    steps: u64,
}

impl<'a> EpisodeProgress<'a> {
    /// One that has seen what the seed goes on from.
    pub fn new(progress: &'a Progress, start: &RunStart<'_>) -> Self {
        let mut seen = Self { progress, steps: 0 };
        if let Some(Checkpoint {
            steps, episodes, ..
        }) = start.resumed
        {
            seen.walked_to(*steps);
            progress.add(*episodes as u64);
        }
        seen
    }

    fn walked_to(&mut self, step: u64) {
        self.progress.add_steps(step - self.steps);
        self.steps = step;
    }
}

impl RunObserver for EpisodeProgress<'_> {
    /// The first episodes may be so long that nothing else tells that the run goes on.
    fn refreshed(&mut self, refresh: &Refresh<'_>) -> Result<(), ArchiveError> {
        self.walked_to(refresh.record.step);
        Ok(())
    }

    fn episode_ended(
        &mut self,
        episode: &Episode<'_>,
        _: &dyn RunState,
    ) -> Result<(), ArchiveError> {
        self.walked_to(episode.record.step);
        self.progress.add(1);
        Ok(())
    }
}
