//! One seed of a scenario: the loop over episodes, its records, its numbers.

use super::build::{build_engine, move_goals};
use super::error::RunnerError;
use super::graph_files::write_graph_files;
use super::phases::{Phases, Worlds, Yardstick};
use super::records::SeedRecords;
use super::snapshots::Snapshots;
use crate::agent::AnyAgent;
use crate::engine::{Engine, EpisodeRecord};
use crate::env::Model;
use crate::error::Error;
use crate::graph::StateId;
use crate::report::{SeedResult, SeedTiming, final_mean_steps};
use crate::scenario::Scenario;
use crate::shaping::Potential;
use crate::telemetry::{self, EventLog};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use tracing::{info, info_span, trace_span};

/// How often the event file is brought up to date.
const FLUSH_EVERY: Duration = Duration::from_secs(2);

/// Who watches a run, and may stop it.
pub struct Watch<'a> {
    /// Keeps the event files.
    pub events: &'a EventLog,
    /// Set from anywhere: the run ends after the episode under way.
    pub stop: &'a AtomicBool,
    /// Told of each episode as it ends.
    pub on_episode: &'a mut dyn FnMut(&EpisodeRecord),
}

/// What one seed came to.
#[derive(Clone, Debug)]
pub struct SeedOutcome {
    /// Its results.
    pub result: SeedResult,
    /// What the clock said.
    pub timing: SeedTiming,
    /// Steps of each episode.
    pub steps_per_episode: Vec<u32>,
}

/// Runs `seed` of a scenario and writes its folder.
///
/// # Errors
/// If a file cannot be written, or a part of the pipeline fails; what was done until then is on disk.
pub fn run_seed(
    scenario: &Scenario,
    seed: u64,
    folder: &Path,
    watch: &mut Watch<'_>,
) -> Result<SeedOutcome, Error> {
    match Worlds::of(scenario, seed) {
        Worlds::Grid(worlds) => {
            let layout = worlds.first.layout().clone();
            run_in(scenario, worlds, seed, folder, watch, "row,col", |cell| {
                let (row, col) = layout.position(*cell);
                format!("{row},{col}")
            })
        }
        Worlds::Listed(worlds, names) => {
            run_in(scenario, worlds, seed, folder, watch, "name", |state| {
                csv_field(&names[state.index()])
            })
        }
    }
}

fn run_in<E>(
    scenario: &Scenario,
    mut worlds: Phases<E>,
    seed: u64,
    folder: &Path,
    watch: &mut Watch<'_>,
    columns: &str,
    label: impl Fn(&E::State) -> String,
) -> Result<SeedOutcome, Error>
where
    E: Model + Clone + Send + 'static,
    E::State: Send,
{
    let begun = Instant::now();
    let mut tally = Tally::new(worlds.yardstick());
    let mut records = SeedRecords::create(folder)?;
    let events_path = folder.join("events.jsonl");
    let events = watch.events.open(&events_path);
    let events = events.map_err(RunnerError::write(&events_path))?;
    let mut engine = build_engine(scenario, worlds.first.clone(), seed);
    let mut snapshots = Snapshots::default();

    let span = info_span!(
        telemetry::RUN,
        scenario = scenario.name,
        seed,
        log = events.number()
    );
    let played = span.in_scope(|| {
        play(
            &mut engine,
            scenario,
            &mut worlds,
            &mut tally,
            &mut records,
            &mut snapshots,
            watch,
            || events.flush().map_err(RunnerError::write(&events_path)),
        )
    });
    drop(span); // its line is the last one of the event file
    // Whatever went wrong, the rows so far belong on disk; the first error is the one to tell.
    let flushed = records.flush();
    let logged = events.flush().map_err(RunnerError::write(&events_path));
    played?;
    flushed?;
    logged?;

    let graph = engine.pipeline().graph();
    let states = || (0..graph.transitions().num_states()).map(|s| StateId(s as u32));
    let table = engine.pipeline().potential();
    let potential: Vec<f64> = states().map(|state| table.value(state)).collect();
    let pairs = engine.pipeline().spectrum().eigenpairs();
    let vectors = pairs.map(|pairs| pairs.vectors.as_ref());
    let labels = states().map(|state| label(graph.state(state)));
    records.finish(&potential, vectors, columns, labels)?;
    snapshots.finish(engine.steps(), engine.pipeline(), folder)?;
    write_graph_files(folder, graph.transitions(), engine.agent())?;
    Ok(tally.outcome(scenario, seed, &engine, begun.elapsed()))
}

/// The episodes.
#[allow(clippy::too_many_arguments, reason = "the parts of one run")]
fn play<E>(
    engine: &mut Engine<E, AnyAgent>,
    scenario: &Scenario,
    worlds: &mut Phases<E>,
    tally: &mut Tally,
    records: &mut SeedRecords,
    snapshots: &mut Snapshots,
    watch: &mut Watch<'_>,
    flush_events: impl Fn() -> Result<(), RunnerError>,
) -> Result<(), Error>
where
    E: Model + Clone + Send + 'static,
    E::State: Send,
{
    let mut flushed = Instant::now();
    let episodes = scenario.run.episodes;
    while tally.lengths.len() < episodes && !watch.stop.load(Ordering::Relaxed) {
        if let Some(world) = worlds.take_moved(tally.lengths.len()) {
            info!(name: "goals_moved", episode = tally.lengths.len(), step = engine.steps(), "goals_moved");
            move_goals(scenario, engine, world);
        }
        let begun = Instant::now();
        let mut written = Ok(());
        let span = trace_span!(telemetry::EPISODE, episode = tally.lengths.len());
        let _in_episode = span.enter();
        let record = engine.run_episode(|refresh, pipeline| {
            snapshots.refreshed(refresh.step, pipeline);
            tally.spectrum_refreshes += usize::from(refresh.spectrum.is_some());
            let fit = refresh.fit.as_ref().and_then(|fit| fit.fit.as_ref());
            tally.gcn_fits += usize::from(fit.is_some());
            if written.is_ok() {
                written = records.refresh(refresh);
            }
        })?;
        written?;
        tally.count(&record);
        records.episode(&record, tally.regret(), begun.elapsed().as_secs_f64())?;
        (watch.on_episode)(&record);
        if flushed.elapsed() >= FLUSH_EVERY {
            flushed = Instant::now();
            flush_events()?;
        }
    }
    Ok(())
}

/// The sums over episodes.
struct Tally {
    yardstick: Yardstick,
    lengths: Vec<u32>,
    returns: f64,
    spectrum_refreshes: usize,
    gcn_fits: usize,
}

impl Tally {
    fn new(yardstick: Yardstick) -> Self {
        Self {
            yardstick,
            lengths: Vec::new(),
            returns: 0.0,
            spectrum_refreshes: 0,
            gcn_fits: 0,
        }
    }

    fn count(&mut self, record: &EpisodeRecord) {
        self.lengths
            .push(u32::try_from(record.length).unwrap_or(u32::MAX));
        self.returns += record.plain_return;
    }

    /// ρ(T) = Σ R* − Σ R_t (eq. 15).
    fn regret(&self) -> f64 {
        self.yardstick.expected_return(self.lengths.len()) - self.returns
    }

    fn outcome<E: Model>(
        self,
        scenario: &Scenario,
        seed: u64,
        engine: &Engine<E, AnyAgent>,
        elapsed: Duration,
    ) -> SeedOutcome {
        let graph = engine.pipeline().transitions();
        let wall_seconds = elapsed.as_secs_f64();
        let episodes = self.lengths.len();
        let result = SeedResult {
            seed,
            finished: episodes == scenario.run.episodes,
            episodes,
            steps: engine.steps(),
            regret: self.regret(),
            optimal_steps: self.yardstick.last(episodes).expected_steps,
            final_mean_steps: final_mean_steps(self.yardstick.since_move(&self.lengths)),
            goals_moved_after: self.yardstick.moved_after(episodes),
            first_goal_step: engine.first_goal_step(),
            nodes: graph.num_states(),
            edges: graph.adjacency().num_edges(),
            spectrum_refreshes: self.spectrum_refreshes,
            gcn_fits: self.gcn_fits,
        };
        let timing = SeedTiming {
            seed,
            wall_seconds,
            steps_per_second: result.steps as f64 / wall_seconds,
        };
        SeedOutcome {
            result,
            timing,
            steps_per_episode: self.lengths,
        }
    }
}

/// A name as a field of a CSV line, quoted if it must be.
fn csv_field(name: &str) -> String {
    if name.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", name.replace('"', "\"\""))
    } else {
        name.to_owned()
    }
}
