//! Observers of a run that belong to the program: its log of events and its progress.

use super::progress::Progress;
use eigentrail::archive::{ArchiveError, names};
use eigentrail::runner::{Episode, RunObserver, RunStart, RunState};
use eigentrail::telemetry::{EventLog, SeedLog};
use std::cell::RefCell;
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
    /// Begins the file anew; what happens in the present span goes there.
    pub fn create(events: &EventLog, start: &RunStart<'_>) -> Result<Self, ArchiveError> {
        let path = start.folder.join(names::EVENTS);
        let log = events.open(&path).map_err(write_error(&path))?;
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
}

fn write_error(path: &std::path::Path) -> impl FnOnce(io::Error) -> ArchiveError + '_ {
    |source| ArchiveError::Write {
        path: path.to_owned(),
        source,
    }
}

/// Progress of a run, episode by episode.
pub struct EpisodeProgress<'a>(pub &'a RefCell<Progress>);

impl RunObserver for EpisodeProgress<'_> {
    fn episode_ended(
        &mut self,
        episode: &Episode<'_>,
        _: &dyn RunState,
    ) -> Result<(), ArchiveError> {
        let record = episode.record;
        let detail = || format!("{} steps, {} states", record.step, record.nodes);
        self.0.borrow_mut().reach(record.episode + 1, detail);
        Ok(())
    }
}
