//! One seed of a scenario into a run folder.

use super::build::warn_of_file;
use super::error::RunnerError;
use super::estimate::require_memory;
use super::observer::{Observers, RunStart};
use super::optimal_returns::OptimalReturns;
use super::seed_writer::SeedWriter;
use super::trial;
use crate::archive::{
    ArchiveError, Existing, RunFolder, RunInfo, RunStatus, SeedResult, SeedTiming,
};
use crate::scenario::Loaded;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use tracing::{field, info_span};

/// Request for a run: what to run, and where to write it.
#[derive(Clone, Debug)]
pub struct RunRequest {
    /// Master seed.
    pub seed: u64,
    /// The run folder; `runs/NAME/TIME` if none is given.
    pub out: Option<PathBuf>,
    /// What to do if it exists.
    pub existing: Existing,
    /// The command line, for `run.json`.
    pub arguments: Vec<String>,
}

/// Observers of a run, and the flag that stops it.
#[derive(Clone, Copy)]
pub struct Watch<'a> {
    /// Set from anywhere: the run ends, and the episode under way is given up.
    pub stop: &'a AtomicBool,
    /// Makes the observers of each seed that is run, beside those that write its files. It is called within the span
    /// `run`, whose field `log` is theirs to record.
    pub observers: &'a MakeObservers<'a>,
}

/// Maker of the observers of a seed.
pub type MakeObservers<'a> = dyn Fn(&RunStart<'_>) -> Result<Observers<'a>, ArchiveError> + 'a;

/// Results of one seed.
#[derive(Clone, Debug)]
pub struct SeedOutcome {
    /// Its results.
    pub result: SeedResult,
    /// What the clock said.
    pub timing: SeedTiming,
    /// Steps of each episode; empty if the seed had been finished before.
    pub steps_per_episode: Vec<u32>,
}

/// Results of a run, and its folder.
#[derive(Clone, Debug)]
pub struct RunOutcome {
    /// The seed's numbers.
    pub outcome: SeedOutcome,
    /// The run folder; nobody else writes there while this is kept.
    pub folder: RunFolder,
    /// Whether the seed had been finished before and was not run again.
    pub was_finished: bool,
}

/// Runs one seed of a scenario into a run folder.
///
/// With [`Existing::Resume`] a seed that is finished in the folder is not run again; one that is not, begins anew.
///
/// # Errors
/// If the folder cannot be used, a file cannot be written, the run fails, or an observer does.
pub fn run(
    loaded: &Loaded,
    request: &RunRequest,
    watch: Watch<'_>,
) -> Result<RunOutcome, RunnerError> {
    let scenario = &loaded.scenario;
    require_memory(scenario, loaded.worlds.first(), 1)?;
    warn_of_file(&loaded.worlds, [scenario]);
    let folder = RunFolder::open(request.out.as_deref(), loaded, request.existing)?;
    let begun = folder.has_begun();
    let mut summary = folder.summary(scenario)?;
    if let Some((result, timing)) = summary.finished(request.seed) {
        let outcome = SeedOutcome {
            result: result.clone(),
            timing: *timing,
            steps_per_episode: Vec::new(),
        };
        return Ok(RunOutcome {
            outcome,
            folder,
            was_finished: true,
        });
    }
    let mut info = RunInfo::begun(scenario, request.seed, request.arguments.clone());
    folder.write_info(&mut info)?; // first: it makes the folder known as ours
    if !begun {
        folder.write_scenario(&loaded.text, scenario)?;
    }
    let ran = run_seed(loaded, request.seed, &folder.seed(request.seed), watch);
    info.end(match &ran {
        Ok(outcome) if outcome.result.finished => RunStatus::Finished,
        Ok(_) => RunStatus::Interrupted,
        Err(_) => RunStatus::Failed,
    });
    let noted = folder.write_info(&mut info);
    let outcome = ran?;
    noted?;
    summary.put(outcome.result.clone(), outcome.timing);
    folder.write_summary(&summary)?;
    Ok(RunOutcome {
        outcome,
        folder,
        was_finished: false,
    })
}

/// Runs `seed` of a scenario and writes its folder.
///
/// # Errors
/// If a file cannot be written, a part of the pipeline fails, or an observer does; what was done until then is on disk.
pub fn run_seed(
    loaded: &Loaded,
    seed: u64,
    folder: &Path,
    watch: Watch<'_>,
) -> Result<SeedOutcome, RunnerError> {
    let (scenario, worlds) = (&loaded.scenario, &loaded.worlds);
    let optimal = OptimalReturns::of(worlds, seed);
    let mut trial = trial::begin(scenario, worlds, optimal, seed)?;
    let mut observers: Observers<'_> = vec![Box::new(SeedWriter::create(folder)?)];
    let start = RunStart {
        scenario,
        seed,
        folder,
    };
    let span = info_span!("run", scenario = scenario.name, seed, log = field::Empty);
    let played = span.in_scope(|| {
        observers.extend((watch.observers)(&start)?);
        trial::play(&mut *trial, watch.stop, &mut observers)
    });
    drop(span); // its line is the last one of the log
    // Whatever went wrong, the rows so far belong on disk; the first error is the one to tell.
    let flushed = flush(&mut observers);
    played?;
    flushed?;
    for observer in &mut observers {
        observer.ended(trial.as_ref())?;
    }
    Ok(SeedOutcome {
        result: trial.result(),
        timing: trial.timing(),
        steps_per_episode: trial.sums().lengths().to_vec(),
    })
}

/// Brings what every observer has noted to the disk, whatever goes wrong with another one; the first error of any.
fn flush(observers: &mut Observers<'_>) -> Result<(), ArchiveError> {
    let flushed = observers.iter_mut().map(|observer| observer.flush());
    flushed.fold(Ok(()), Result::and)
}
