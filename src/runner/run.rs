//! One seed of a scenario: the loop over episodes, its records, its numbers.

use super::build::build_engine;
use super::ledger::Ledger;
use super::places::Places;
use crate::agent::AnyAgent;
use crate::engine::{Engine, EpisodeRecord};
use crate::env::{MdpState, Model, Optimum};
use crate::error::Error;
use crate::report::{SeedResult, SeedTiming, final_mean_steps};
use crate::scenario::{Scenario, World};
use crate::telemetry::{self, EventLog};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use tracing::{info_span, trace_span};

/// Who watches a run, and may stop it.
pub struct Watch<'a> {
    /// Keeps the event files.
    pub events: &'a EventLog,
    /// Set from anywhere: the run ends after the episode under way.
    pub stop: &'a AtomicBool,
    /// Told of each episode as it ends.
    pub on_episode: &'a mut dyn FnMut(&EpisodeRecord),
    /// Where else the run is shown.
    pub outlets: Outlets,
}

/// Where a run is shown beside its result files.
#[derive(Clone, Copy, Debug, Default)]
pub struct Outlets {
    /// In an event file for TensorBoard.
    pub tensorboard: bool,
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
    let world = scenario.world(seed);
    match world.expect("the scenario was checked when it was loaded") {
        World::Grid(world) => {
            let places = Places::on_map(world.layout());
            run_in(scenario, world, seed, folder, watch, &places)
        }
        World::Listed(world, names) => {
            let places = Places::named(names, |state: &MdpState| state.index());
            run_in(scenario, world, seed, folder, watch, &places)
        }
    }
}

fn run_in<E>(
    scenario: &Scenario,
    world: E,
    seed: u64,
    folder: &Path,
    watch: &mut Watch<'_>,
    places: &Places<E::State>,
) -> Result<SeedOutcome, Error>
where
    E: Model + Clone + Send + 'static,
    E::State: Send,
{
    let begun = Instant::now();
    let mut tally = Tally::new(world.optimum());
    let mut ledger = Ledger::create(scenario, seed, folder, places, watch.events, watch.outlets)?;
    let mut engine = build_engine(scenario, world, seed);
    let span = info_span!(
        telemetry::RUN,
        scenario = scenario.name,
        seed,
        log = ledger.log_number()
    );
    let episodes = scenario.run.episodes;
    let played = span.in_scope(|| play(&mut engine, episodes, &mut tally, &mut ledger, watch));
    drop(span); // its line is the last one of the event file
    // Whatever went wrong, the rows so far belong on disk; the first error is the one to tell.
    let flushed = ledger.flush();
    played?;
    flushed?;
    ledger.close(&engine)?;
    Ok(tally.outcome(scenario, seed, &engine, begun.elapsed()))
}

/// The episodes.
fn play<E: Model>(
    engine: &mut Engine<E, AnyAgent>,
    episodes: usize,
    tally: &mut Tally,
    ledger: &mut Ledger<'_, E::State>,
    watch: &mut Watch<'_>,
) -> Result<(), Error> {
    while tally.lengths.len() < episodes && !watch.stop.load(Ordering::Relaxed) {
        let begun = Instant::now();
        let mut written = Ok(());
        let span = trace_span!(telemetry::EPISODE, episode = tally.lengths.len());
        let _in_episode = span.enter();
        let record = engine.run_episode(|refresh, pipeline| {
            tally.spectrum_refreshes += usize::from(refresh.spectrum.is_some());
            let fit = refresh.fit.as_ref().and_then(|fit| fit.fit.as_ref());
            tally.gcn_fits += usize::from(fit.is_some());
            if written.is_ok() {
                written = ledger.refreshed(refresh, pipeline);
            }
        })?;
        written?;
        tally.count(&record);
        ledger.episode(&record, tally.regret(), begun.elapsed().as_secs_f64())?;
        (watch.on_episode)(&record);
    }
    Ok(())
}

/// The sums over episodes.
struct Tally {
    optimum: Optimum,
    lengths: Vec<u32>,
    returns: f64,
    spectrum_refreshes: usize,
    gcn_fits: usize,
}

impl Tally {
    fn new(optimum: Optimum) -> Self {
        Self {
            optimum,
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

    /// ρ(T) = T R* − Σ R_t (eq. 15).
    fn regret(&self) -> f64 {
        self.lengths.len() as f64 * self.optimum.expected_return - self.returns
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
        let result = SeedResult {
            seed,
            finished: self.lengths.len() == scenario.run.episodes,
            episodes: self.lengths.len(),
            steps: engine.steps(),
            regret: self.regret(),
            optimal_steps: self.optimum.expected_steps,
            final_mean_steps: final_mean_steps(&self.lengths),
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
