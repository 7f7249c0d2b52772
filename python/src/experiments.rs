//! Scenarios from Python: runs, comparisons and sweeps, whose results are the documents that the program prints.

use crate::errors::raised;
use crate::watched::{Watched, watched};
use eigentrail::archive::files::TemporaryFolder;
use eigentrail::archive::{ArchiveError, Existing, RunLine, RunLines};
use eigentrail::error::Error;
use eigentrail::runner::{
    self, CompareRequest, CompareWatch, Episode, Observers, RunObserver, RunRequest, RunStart,
    RunState, SweepPlan, SweepRequest, SweepWatch, Watch,
};
use eigentrail::scenario::{Axis, Scenario};
use pyo3::exceptions::{PyOSError, PyRuntimeError};
use pyo3::prelude::*;
use serde::Serialize;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// A folder that the caller named, or one that goes with what was written there.
pub enum Place {
    Named(PathBuf),
    Temporary(TemporaryFolder),
}

impl Place {
    pub fn of(out: Option<PathBuf>) -> PyResult<Self> {
        match out {
            Some(path) => Ok(Self::Named(path)),
            None => Ok(Self::Temporary(
                TemporaryFolder::create().map_err(|error| PyOSError::new_err(error.to_string()))?,
            )),
        }
    }

    pub fn path(&self) -> PathBuf {
        match self {
            Self::Named(path) => path.clone(),
            Self::Temporary(folder) => folder.path().join("out"),
        }
    }
}

/// Seeds of a scenario, in the form of `run --seed` (`alone`) or of `run --seeds`.
#[pyfunction]
#[allow(clippy::too_many_arguments)] // the options of the command
pub fn run(
    py: Python<'_>,
    path: PathBuf,
    sets: Vec<String>,
    seeds: Vec<u64>,
    alone: bool,
    out: Option<PathBuf>,
    arguments: Vec<String>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<String> {
    let place = Place::of(out)?;
    let document = watched(py, threads, progress.as_ref(), |seen| {
        let loaded = Scenario::load(&path, &sets)?;
        let seeds = match seeds.is_empty() {
            true => vec![loaded.scenario.run.seed],
            false => seeds,
        };
        let episodes = loaded.scenario.run.episodes * seeds.len();
        seen.total.store(episodes, Ordering::Relaxed);
        let request = RunRequest {
            seeds,
            out: Some(place.path()),
            existing: Existing::Resume,
            arguments,
        };
        let observers = |_: &RunStart<'_>| -> Result<Observers<'_>, ArchiveError> {
            Ok(vec![Box::new(EpisodeCounter(seen))])
        };
        let watch = Watch {
            stop: &seen.stop,
            observers: &observers,
        };
        let ran = runner::run(&loaded, &request, watch)?;
        let name = &loaded.scenario.name;
        let results = ran.seeds.iter().map(|seed| (&seed.result, &seed.timing));
        Ok::<_, Error>(match ran.seeds.as_slice() {
            [one] if alone => json(&RunLine::new(name, &one.result, &one.timing)),
            _ => json(&RunLines::new(name, results)),
        })
    })?;
    document.map_err(raised)?
}

/// Arms of a scenario over seeds.
#[pyfunction]
#[allow(clippy::too_many_arguments)] // the options of the command
pub fn compare(
    py: Python<'_>,
    path: PathBuf,
    sets: Vec<String>,
    arms: Vec<String>,
    seeds: Vec<u64>,
    tuned: bool,
    out: Option<PathBuf>,
    arguments: Vec<String>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<String> {
    let place = Place::of(out)?;
    let comparison = watched(py, threads, progress.as_ref(), |seen| {
        let loaded = Scenario::load(&path, &sets)?;
        let request = CompareRequest {
            path,
            sets,
            seeds,
            arms,
            tuned,
            out: Some(place.path()),
            existing: Existing::Resume,
            arguments,
        };
        seen.total.store(request.num_trials(), Ordering::Relaxed);
        let watch = CompareWatch {
            stop: &seen.stop,
            on_trial: &|_, _| seen.advance(),
        };
        Ok::<_, Error>(runner::compare(&loaded, &request, watch)?.comparison)
    })?;
    json(&comparison.map_err(raised)?.ok_or_else(stopped)?)
}

/// A grid × seeds of a scenario: the document, and the text of `sweep.csv`.
#[pyfunction]
#[allow(clippy::too_many_arguments)] // the options of the command
pub fn sweep(
    py: Python<'_>,
    path: PathBuf,
    sets: Vec<String>,
    grid: Vec<(String, Vec<String>)>,
    arms: Vec<String>,
    seeds: Vec<u64>,
    out: Option<PathBuf>,
    arguments: Vec<String>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(String, String)> {
    let place = Place::of(out)?;
    let request = sweep_request(path, sets, grid, arms, seeds, arguments);
    let swept = watched(py, threads, progress.as_ref(), |seen| {
        let plan = Arc::new(SweepPlan::of(request)?);
        seen.total.store(plan.num_trials(), Ordering::Relaxed);
        let watch = SweepWatch {
            stop: &seen.stop,
            on_trial: &|_| seen.advance(),
        };
        Ok::<_, Error>(runner::sweep(&plan, Some(&place.path()), Existing::Resume, watch)?.sweep)
    })?;
    let (sweep, rows) = swept.map_err(raised)?.ok_or_else(stopped)?;
    Ok((json(&sweep)?, rows))
}

pub fn sweep_request(
    path: PathBuf,
    sets: Vec<String>,
    grid: Vec<(String, Vec<String>)>,
    arms: Vec<String>,
    seeds: Vec<u64>,
    arguments: Vec<String>,
) -> SweepRequest {
    let axes = grid.into_iter().map(|(key, values)| Axis { key, values });
    SweepRequest {
        path,
        sets,
        axes: axes.collect(),
        arms,
        seeds,
        arguments,
    }
}

pub fn json(document: &impl Serialize) -> PyResult<String> {
    serde_json::to_string(document).map_err(|error| PyRuntimeError::new_err(error.to_string()))
}

/// Only who asks for it to stop sees it stopped, and that is raised instead.
fn stopped() -> PyErr {
    PyRuntimeError::new_err("stopped before its end")
}

/// Observer that counts episodes.
struct EpisodeCounter<'a>(&'a Watched);

impl RunObserver for EpisodeCounter<'_> {
    fn episode_ended(&mut self, _: &Episode<'_>, _: &dyn RunState) -> Result<(), ArchiveError> {
        self.0.advance();
        Ok(())
    }
}
