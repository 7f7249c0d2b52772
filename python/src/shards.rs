//! A sweep in shards: its folder, which one process keeps, and the seeds of a point, which any process may run.

use crate::calls::unlocked;
use crate::errors::raised;
use crate::experiments::{Place, json, sweep_request};
use crate::watched::watched;
use eigentrail::archive::{Existing, Shard};
use eigentrail::error::Error;
use eigentrail::runner::{OpenSweep, ShardTask, SweepPlan, SweepWatch};
use pyo3::exceptions::{PyIndexError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use serde::de::DeserializeOwned;
use std::path::PathBuf;
use std::sync::Arc;

/// The folder of a sweep, which nobody else writes to while this is there.
#[pyclass(module = "eigentrail._eigentrail")]
pub struct SweepFolder {
    open: OpenSweep,
    plan: Arc<SweepPlan>,
    /// Goes after the folder in it.
    _place: Place,
}

#[pymethods]
impl SweepFolder {
    #[new]
    #[allow(clippy::too_many_arguments)] // the options of the command
    fn new(
        py: Python<'_>,
        path: PathBuf,
        sets: Vec<String>,
        grid: Vec<(String, Vec<String>)>,
        arms: Vec<String>,
        seeds: Vec<u64>,
        out: Option<PathBuf>,
        arguments: Vec<String>,
    ) -> PyResult<Self> {
        let place = Place::of(out)?;
        let request = sweep_request(path, sets, grid, arms, seeds, arguments);
        let opened = unlocked(py, || {
            let plan = Arc::new(SweepPlan::of(request)?);
            let open = OpenSweep::open(&plan, Some(&place.path()), Existing::Resume)?;
            Ok::<_, Error>((open, plan))
        })?;
        let (open, plan) = opened.map_err(raised)?;
        Ok(Self {
            open,
            plan,
            _place: place,
        })
    }

    /// Whether an earlier sweep has begun in the folder.
    #[getter]
    fn was_begun(&self) -> bool {
        self.open.was_begun()
    }

    #[getter]
    fn num_trials(&self) -> usize {
        self.plan.num_trials()
    }

    #[getter]
    fn num_finished(&self) -> usize {
        self.open.num_finished()
    }

    /// Seeds that are not finished, by point.
    fn unfinished(&self) -> Vec<(usize, Vec<u64>)> {
        self.open.unfinished()
    }

    /// A point as another process is told of it, and its hash.
    fn task(&self, point: usize) -> PyResult<(String, String)> {
        if point >= self.plan.num_points() {
            return Err(PyIndexError::new_err("there is no such point"));
        }
        let task = self.plan.task(point);
        Ok((json(&task)?, task.hash))
    }

    /// Keeps a shard.
    fn put(&self, py: Python<'_>, shard: &str) -> PyResult<()> {
        let shard: Shard = parsed("shard", shard)?;
        unlocked(py, || self.open.put(shard))?.map_err(raised)
    }

    /// Writes the numbers: the document and the text of `sweep.csv`; none if something is not finished.
    fn finish(&self, py: Python<'_>) -> PyResult<Option<(String, String)>> {
        match unlocked(py, || self.open.finish())?.map_err(raised)? {
            Some((sweep, rows)) => Ok(Some((json(&sweep)?, rows))),
            None => Ok(None),
        }
    }
}

/// Runs seeds of a point: the shard.
#[pyfunction]
pub fn run_shard(
    py: Python<'_>,
    task: &str,
    seeds: Vec<u64>,
    threads: Option<usize>,
) -> PyResult<String> {
    let task: ShardTask = parsed("task", task)?;
    let ran = watched(py, threads, None, |seen| {
        let watch = SweepWatch {
            stop: &seen.stop,
            on_trial: &|_| seen.advance(),
        };
        task.run(&seeds, watch)
    })?;
    match ran.map_err(raised)? {
        Some(shard) => json(&shard),
        None => Err(PyRuntimeError::new_err("stopped before its end")),
    }
}

fn parsed<T: DeserializeOwned>(what: &str, json: &str) -> PyResult<T> {
    serde_json::from_str(json).map_err(|error| PyValueError::new_err(format!("{what}: {error}")))
}
