//! Seeds of a scenario into a run folder.

use super::build::warn_of_file;
use super::checkpoints::Checkpoints;
use super::error::RunnerError;
use super::estimate::require_memory;
use super::observer::{Observers, RunStart};
use super::optimal_returns::OptimalReturns;
use super::parallel_map::parallel_map;
use super::seed_writer::SeedWriter;
use super::trial;
use crate::archive::{
    ArchiveError, Checkpoint, Existing, RunFolder, RunInfo, RunStatus, SeedResult, SeedTiming,
    Summary, checkpoint,
};
use crate::scenario::Loaded;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use tracing::{field, info, info_span};

/// Request for a run: what to run, and where to write it.
#[derive(Clone, Debug)]
pub struct RunRequest {
    /// Master seeds, each once.
    pub seeds: Vec<u64>,
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
    /// Set from anywhere: the run ends, and the episodes under way are given up.
    pub stop: &'a AtomicBool,
    /// Makes the observers of each seed that is run, beside those that write its files. It is called within the span
    /// `run`, whose field `log` is theirs to record, on the thread that the seed is run on.
    pub observers: &'a MakeObservers<'a>,
}

/// Maker of the observers of a seed.
pub type MakeObservers<'a> =
    dyn Fn(&RunStart<'_>) -> Result<Observers<'a>, ArchiveError> + Sync + 'a;

/// Results of one seed.
#[derive(Clone, Debug)]
pub struct SeedOutcome {
    /// Its results.
    pub result: SeedResult,
    /// What the clock said.
    pub timing: SeedTiming,
    /// Steps of each episode; empty if the seed had been finished before.
    pub steps_per_episode: Vec<u32>,
    /// Whether it had been finished before and was not run again.
    pub was_finished: bool,
}

/// Results of a run, and its folder.
#[derive(Clone, Debug)]
pub struct RunOutcome {
    /// By seed in the order of the request, but for those that an interruption came before.
    pub seeds: Vec<SeedOutcome>,
    /// Whether every seed was run to its end.
    pub finished: bool,
    /// The run folder; nobody else writes there while this is kept.
    pub folder: RunFolder,
}

/// Runs seeds of a scenario into a run folder: one on all threads, several side by side. That changes no result.
///
/// With [`Existing::Resume`] a seed that is finished in the folder is not run again; one that is not goes on from its newest
/// checkpoint, or begins anew if there is none.
///
/// # Errors
/// If the folder cannot be used, a file cannot be written, the run fails, or an observer does. What other seeds came to
/// is in the summary all the same.
pub fn run(
    loaded: &Loaded,
    request: &RunRequest,
    watch: Watch<'_>,
) -> Result<RunOutcome, RunnerError> {
    let scenario = &loaded.scenario;
    let at_once = request.seeds.len().min(rayon::current_num_threads());
    require_memory(scenario, loaded.worlds.first(), at_once)?;
    warn_of_file(&loaded.worlds, [scenario]);
    let folder = RunFolder::open(request.out.as_deref(), loaded, request.existing)?;
    let begun = folder.has_begun();
    let summary = folder.summary(scenario)?;
    // Killed in its last moments, it has something left to do though every result is there.
    if folder.is_noted_as_finished()
        && let Some(seeds) = all_finished(&summary, &request.seeds)
    {
        return Ok(RunOutcome {
            seeds,
            finished: true,
            folder,
        });
    }
    let mut info = RunInfo::begun(scenario, &request.seeds, request.arguments.clone());
    folder.write_info(&mut info)?; // first: it makes the folder known as ours
    if !begun {
        folder.write_scenario(&loaded.text, scenario)?;
    }
    let summary = Mutex::new(summary);
    let ran = run_missing(loaded, request, watch, &folder, &summary);
    let finished = ran.as_ref().is_ok_and(|seeds| {
        seeds.len() == request.seeds.len() && seeds.iter().all(|seed| seed.result.finished)
    });
    info.end(match &ran {
        Ok(_) if finished => RunStatus::Finished,
        Ok(_) => RunStatus::Interrupted,
        Err(_) => RunStatus::Failed,
    });
    let noted = folder.write_info(&mut info);
    let seeds = ran?;
    noted?;
    Ok(RunOutcome {
        seeds,
        finished,
        folder,
    })
}

/// What is known of a seed that had been finished before.
fn finished_before(summary: &Summary, seed: u64) -> Option<SeedOutcome> {
    let (result, timing) = summary.finished(seed)?;
    Some(SeedOutcome {
        result: result.clone(),
        timing: *timing,
        steps_per_episode: Vec::new(),
        was_finished: true,
    })
}

fn all_finished(summary: &Summary, seeds: &[u64]) -> Option<Vec<SeedOutcome>> {
    let before = seeds.iter().map(|&seed| finished_before(summary, seed));
    before.collect()
}

/// Runs the seeds that are not finished, each of which goes into the summary as soon as it is.
fn run_missing(
    loaded: &Loaded,
    request: &RunRequest,
    watch: Watch<'_>,
    folder: &RunFolder,
    summary: &Mutex<Summary>,
) -> Result<Vec<SeedOutcome>, RunnerError> {
    let summary = || summary.lock().unwrap_or_else(PoisonError::into_inner);
    let one = |&seed: &u64| -> Result<SeedOutcome, RunnerError> {
        let seed_folder = folder.seed(seed);
        if let Some(before) = finished_before(&summary(), seed) {
            checkpoint::remove(&seed_folder)?; // a kill may have come before they were removed
            return Ok(before);
        }
        let outcome = run_seed(loaded, seed, &seed_folder, folder.is_resumed(), watch)?;
        let mut summary = summary();
        summary.put(outcome.result.clone(), outcome.timing);
        folder.write_summary(&summary)?;
        if outcome.result.finished {
            checkpoint::remove(&seed_folder)?; // only now: until its result is on the disk, a seed has not ended
        }
        Ok(outcome)
    };
    if let [seed] = request.seeds.as_slice() {
        return Ok(vec![one(seed)?]);
    }
    let several = parallel_map(&request.seeds, |seed| {
        match watch.stop.load(Ordering::Relaxed) {
            true => Ok(None),
            false => one(seed).map(Some),
        }
    })?;
    Ok(several.into_iter().flatten().collect())
}

/// Runs `seed` of a scenario and writes its folder. With `resume` it goes on from the newest checkpoint there that can be gone on
/// from, if there is one.
///
/// # Errors
/// If a file cannot be written, a part of the pipeline fails, or an observer does; what was done until then is on disk.
pub fn run_seed(
    loaded: &Loaded,
    seed: u64,
    folder: &Path,
    resume: bool,
    watch: Watch<'_>,
) -> Result<SeedOutcome, RunnerError> {
    let scenario = &loaded.scenario;
    let mut checkpoints = Checkpoints::new(scenario, seed, folder);
    let load = |checkpoint: &Checkpoint| {
        let trial = trial::resume(scenario, &loaded.worlds, seed, &checkpoint.run)?;
        let writer = SeedWriter::go_on(folder, checkpoint).map_err(|error| error.to_string())?;
        Ok((trial, writer))
    };
    let gone_on = match resume {
        true => checkpoints.go_on(load),
        false => None,
    };
    let (resumed, (mut trial, writer)) = match gone_on {
        Some((checkpoint, loaded)) => (Some(checkpoint), loaded),
        None => {
            let optimal = OptimalReturns::of(&loaded.worlds, seed);
            let trial = trial::begin(scenario, &loaded.worlds, optimal, seed)?;
            let writer = SeedWriter::create(folder)?;
            checkpoints.remove()?;
            (None, (trial, writer))
        }
    };
    let start = RunStart {
        scenario,
        seed,
        folder,
        resumed: resumed.as_ref(),
    };
    let mut observers: Observers<'_> = vec![Box::new(writer)];
    let span = info_span!("run", scenario = scenario.name, seed, log = field::Empty);
    let played = span.in_scope(|| {
        observers.extend((watch.observers)(&start)?);
        if let Some(Checkpoint {
            steps, episodes, ..
        }) = &resumed
        {
            info!(name: "resumed", seed, steps, episodes, "resumed");
        }
        trial::play(
            &mut *trial,
            watch.stop,
            &mut observers,
            Some(&mut checkpoints),
        )
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
        was_finished: false,
    })
}

/// Brings what every observer has noted to the disk, whatever goes wrong with another one; the first error of any.
fn flush(observers: &mut Observers<'_>) -> Result<(), ArchiveError> {
    let flushed = observers.iter_mut().map(|observer| observer.flush());
    flushed.fold(Ok(()), Result::and)
}
