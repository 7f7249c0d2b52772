//! One seed of a scenario: the loop over episodes, its records, its numbers.

use super::build::{build_engine, move_goals};
use super::follow::Follower;
use super::ledger::Ledger;
use super::phases::{Phases, Worlds, Yardstick};
use super::places::Places;
use crate::agent::AnyAgent;
use crate::engine::{Engine, EpisodeRecord};
use crate::env::{MdpState, Model};
use crate::error::Error;
use crate::report::{SeedResult, SeedTiming, final_mean_return, final_mean_steps};
use crate::scenario::Scenario;
use crate::telemetry::{self, EventLog};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;
use tracing::{info, info_span, trace_span};

/// Who watches a run, and may stop it.
pub struct Watch<'a> {
    /// Keeps the event files.
    pub events: &'a EventLog,
    /// Set from anywhere: the run ends, and the episode under way is given up.
    pub stop: &'a AtomicBool,
    /// Told of each episode as it ends.
    pub on_episode: &'a mut dyn FnMut(&EpisodeRecord),
    /// Where else the run is shown.
    pub outlets: Outlets<'a>,
}

/// Where a run is shown beside its result files.
#[derive(Clone, Copy, Default)]
pub struct Outlets<'a> {
    /// In an event file for TensorBoard.
    pub tensorboard: bool,
    /// To whom follows it while it goes on.
    pub follower: Option<&'a dyn Follower>,
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
            let places = Places::on_map(worlds.first.layout());
            run_in(scenario, worlds, seed, folder, watch, &places)
        }
        Worlds::Listed(worlds, names) => {
            let places = Places::named(names, |state: &MdpState| state.index());
            run_in(scenario, worlds, seed, folder, watch, &places)
        }
    }
}

fn run_in<E>(
    scenario: &Scenario,
    mut worlds: Phases<E>,
    seed: u64,
    folder: &Path,
    watch: &mut Watch<'_>,
    places: &Places<E::State>,
) -> Result<SeedOutcome, Error>
where
    E: Model + Clone + Send + 'static,
    E::State: Send,
{
    let mut tally = Tally::new(scenario, seed, worlds.yardstick());
    let mut ledger = Ledger::create(scenario, seed, folder, places, watch.events, watch.outlets)?;
    let mut engine = build_engine(scenario, worlds.first.clone(), seed)?;
    let span = info_span!(
        telemetry::RUN,
        scenario = scenario.name,
        seed,
        log = ledger.log_number()
    );
    let played = span.in_scope(|| {
        play(
            &mut engine,
            scenario,
            &mut worlds,
            &mut tally,
            &mut ledger,
            watch,
        )
    });
    drop(span); // its line is the last one of the event file
    // Whatever went wrong, the rows so far belong on disk; the first error is the one to tell.
    let flushed = ledger.flush();
    played?;
    flushed?;
    ledger.tell(&tally, &engine);
    ledger.close(&engine)?;
    Ok(tally.outcome(&engine))
}

/// The episodes.
fn play<E>(
    engine: &mut Engine<E, AnyAgent>,
    scenario: &Scenario,
    worlds: &mut Phases<E>,
    tally: &mut Tally,
    ledger: &mut Ledger<'_, E::State>,
    watch: &mut Watch<'_>,
) -> Result<(), Error>
where
    E: Model + Clone + Send + 'static,
    E::State: Send,
{
    while !tally.is_complete() && !watch.stop.load(Ordering::Relaxed) {
        if let Some(world) = worlds.take_moved(tally.lengths.len()) {
            info!(name: "goals_moved", episode = tally.lengths.len(), step = engine.steps(), "goals_moved");
            move_goals(scenario, engine, world);
        }
        let begun = Instant::now();
        let mut written = Ok(());
        let span = trace_span!(telemetry::EPISODE, episode = tally.lengths.len());
        let _in_episode = span.enter();
        let record = engine.run_episode_unless(watch.stop, |refresh, pipeline| {
            tally.spectrum_refreshes += usize::from(refresh.spectrum.is_some());
            let fit = refresh.fit.as_ref().and_then(|fit| fit.fit.as_ref());
            tally.gcn_fits += usize::from(fit.is_some());
            if written.is_ok() {
                written = ledger.refreshed(refresh, pipeline);
            }
        })?;
        written?;
        let Some(record) = record else { break };
        tally.count(&record);
        ledger.episode(&record, tally.regret(), begun.elapsed().as_secs_f64())?;
        if ledger.is_due() {
            ledger.tell(tally, engine);
        }
        (watch.on_episode)(&record);
    }
    Ok(())
}

/// The sums over episodes.
pub(super) struct Tally {
    seed: u64,
    /// As many as there are to be.
    episodes: usize,
    begun: Instant,
    yardstick: Yardstick,
    lengths: Vec<u32>,
    returns: Vec<f64>,
    /// Σ of them.
    total: f64,
    spectrum_refreshes: usize,
    gcn_fits: usize,
}

impl Tally {
    fn new(scenario: &Scenario, seed: u64, yardstick: Yardstick) -> Self {
        Self {
            seed,
            episodes: scenario.run.episodes,
            begun: Instant::now(),
            yardstick,
            lengths: Vec::new(),
            returns: Vec::new(),
            total: 0.0,
            spectrum_refreshes: 0,
            gcn_fits: 0,
        }
    }

    fn is_complete(&self) -> bool {
        self.lengths.len() >= self.episodes
    }

    fn count(&mut self, record: &EpisodeRecord) {
        self.lengths
            .push(u32::try_from(record.length).unwrap_or(u32::MAX));
        self.returns.push(record.plain_return);
        self.total += record.plain_return;
    }

    /// ρ(T) = Σ R* − Σ R_t (eq. 15).
    fn regret(&self) -> f64 {
        self.yardstick.expected_return(self.lengths.len()) - self.total
    }

    /// What it comes to so far.
    pub(super) fn result<E: Model>(
        &self,
        engine: &Engine<E, AnyAgent>,
    ) -> (SeedResult, SeedTiming) {
        let graph = engine.pipeline().transitions();
        let wall_seconds = self.begun.elapsed().as_secs_f64();
        let episodes = self.lengths.len();
        let best = self.yardstick.last(episodes).optimum;
        let result = SeedResult {
            seed: self.seed,
            finished: self.is_complete(),
            episodes,
            steps: engine.steps(),
            regret: self.regret(),
            optimal_steps: best.expected_steps,
            final_mean_steps: final_mean_steps(self.yardstick.since_move(&self.lengths)),
            optimal_return: Some(best.expected_return),
            final_return: Some(final_mean_return(self.yardstick.since_move(&self.returns))),
            goals_moved_after: self.yardstick.moved_after(episodes),
            first_goal_step: engine.first_goal_step(),
            nodes: graph.num_states(),
            edges: graph.adjacency().num_edges(),
            spectrum_refreshes: self.spectrum_refreshes,
            gcn_fits: self.gcn_fits,
        };
        let timing = SeedTiming {
            seed: self.seed,
            wall_seconds,
            steps_per_second: result.steps as f64 / wall_seconds.max(1e-9),
        };
        (result, timing)
    }

    fn outcome<E: Model>(self, engine: &Engine<E, AnyAgent>) -> SeedOutcome {
        let (result, timing) = self.result(engine);
        SeedOutcome {
            result,
            timing,
            steps_per_episode: self.lengths,
        }
    }
}
