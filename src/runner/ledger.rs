//! Everything that is written about one seed, while it runs and at its end.

use super::board::Board;
use super::error::RunnerError;
use super::follow::Feed;
use super::graph_files::write_graph_files;
use super::places::Places;
use super::records::SeedRecords;
use super::run::{Outlets, Tally};
use super::snapshots::Snapshots;
use crate::agent::AnyAgent;
use crate::engine::{Engine, EpisodeRecord, RefreshRecord, ShapingPipeline};
use crate::env::{Environment, Model};
use crate::graph::StateId;
use crate::scenario::Scenario;
use crate::shaping::Potential;
use crate::telemetry::{EventLog, SeedLog};
use std::hash::Hash;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// How often the event file is brought up to date.
const FLUSH_EVERY: Duration = Duration::from_secs(2);

/// The open files of one seed.
pub(super) struct Ledger<'a, S> {
    folder: PathBuf,
    places: &'a Places<S>,
    records: SeedRecords,
    snapshots: Snapshots,
    log: SeedLog,
    log_path: PathBuf,
    flushed: Instant,
    board: Option<Board>,
    feed: Option<Feed<'a>>,
}

impl<'a, S: Clone + Eq + Hash> Ledger<'a, S> {
    /// Creates the folder and begins its files anew.
    pub fn create(
        scenario: &Scenario,
        seed: u64,
        folder: &Path,
        places: &'a Places<S>,
        events: &EventLog,
        outlets: Outlets<'a>,
    ) -> Result<Self, RunnerError> {
        let records = SeedRecords::create(folder)?;
        let log_path = folder.join("events.jsonl");
        let log = events
            .open(&log_path)
            .map_err(RunnerError::write(&log_path))?;
        let board = match outlets.tensorboard {
            true => Some(Board::create(folder, seed, &scenario.to_toml())?),
            false => None,
        };
        Ok(Self {
            folder: folder.to_owned(),
            places,
            records,
            snapshots: Snapshots::default(),
            log,
            log_path,
            flushed: Instant::now(),
            board,
            feed: outlets.follower.map(Feed::new),
        })
    }

    /// The number of the log of events, for the span of the run.
    pub fn log_number(&self) -> u64 {
        self.log.number()
    }

    /// The spectrum, the potential, or both were brought up to date.
    pub fn refreshed(
        &mut self,
        refresh: &RefreshRecord,
        pipeline: &ShapingPipeline<S>,
    ) -> Result<(), RunnerError> {
        self.snapshots.refreshed(refresh.step, pipeline);
        if let Some(board) = &mut self.board {
            board.refreshed(refresh, pipeline, self.places)?;
        }
        if let Some(feed) = &mut self.feed {
            feed.refreshed(refresh);
        }
        self.records.refresh(refresh)
    }

    /// An episode has ended; `regret` is that of the run so far.
    pub fn episode(
        &mut self,
        record: &EpisodeRecord,
        regret: f64,
        seconds: f64,
    ) -> Result<(), RunnerError> {
        if let Some(board) = &mut self.board {
            board.episode(record, regret)?;
        }
        if let Some(feed) = &mut self.feed {
            feed.episode(record, regret);
        }
        self.records.episode(record, regret, seconds)?;
        if self.flushed.elapsed() >= FLUSH_EVERY {
            self.flushed = Instant::now();
            self.flush_log()?;
        }
        Ok(())
    }

    /// Whether somebody who follows the run wants to be told.
    pub fn is_due(&self) -> bool {
        self.feed.as_ref().is_some_and(Feed::is_due)
    }

    /// Tells whoever follows the run how things stand.
    pub fn tell<E: Model<State = S>>(&mut self, tally: &Tally, engine: &Engine<E, AnyAgent>) {
        if let Some(feed) = &mut self.feed {
            let (result, timing) = tally.result(engine);
            feed.tell(result, timing, engine, &self.snapshots, self.places);
        }
    }

    /// Brings every row to its file, whatever goes wrong with another one; the first error is the one to tell.
    pub fn flush(&mut self) -> Result<(), RunnerError> {
        let records = self.records.flush();
        let log = self.flush_log();
        let board = self.board.as_mut().map_or(Ok(()), Board::flush);
        records.and(log).and(board)
    }

    /// Writes what is known at the end.
    pub fn close<E>(mut self, engine: &Engine<E, AnyAgent>) -> Result<(), RunnerError>
    where
        E: Environment<State = S>,
    {
        let pipeline = engine.pipeline();
        let graph = pipeline.graph();
        let states = || (0..graph.transitions().num_states()).map(|s| StateId(s as u32));
        let table = pipeline.potential();
        let potential: Vec<f64> = states().map(|state| table.value(state)).collect();
        let pairs = pipeline.spectrum().eigenpairs();
        let vectors = pairs.map(|pairs| pairs.vectors.as_ref());
        let labels = states().map(|state| (self.places.label)(graph.state(state)));
        self.records
            .finish(&potential, vectors, self.places.columns, labels)?;
        if let Some(board) = self.board {
            board.finish(engine.steps(), pipeline, self.places)?;
        }
        self.snapshots
            .finish(engine.steps(), pipeline, &self.folder)?;
        let advice = pipeline.look_ahead();
        write_graph_files(&self.folder, graph.transitions(), engine.agent(), &advice)
    }

    fn flush_log(&self) -> Result<(), RunnerError> {
        let flushed = self.log.flush();
        flushed.map_err(RunnerError::write(&self.log_path))
    }
}
