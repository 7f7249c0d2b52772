//! One point of a sweep as another process, on another machine, is told of it.

use super::SweepWatch;
use super::plan::PlannedPoint;
use crate::archive::Shard;
use crate::runner::error::RunnerError;
use crate::runner::parallel_map::parallel_map;
use crate::scenario::GridPoint;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::sync::atomic::Ordering;

/// A point with all that it takes to run it but the files that the scenario names.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ShardTask {
    /// The scenario file, for messages and relative files; it is not read.
    pub path: PathBuf,
    /// Its text.
    pub text: String,
    /// Assignments laid over it.
    pub sets: Vec<String>,
    /// The point.
    pub point: GridPoint,
    /// Its hash where the sweep was planned.
    pub hash: String,
}

impl ShardTask {
    /// Runs seeds of the point, as many at a time as there are threads; none if it was stopped before the last one ended.
    ///
    /// # Errors
    /// If the point has another hash here, because the program or a file is another one, or a trial fails.
    pub fn run(&self, seeds: &[u64], watch: SweepWatch<'_>) -> Result<Option<Shard>, RunnerError> {
        let loaded = self.point.load(&self.path, &self.text, &self.sets)?;
        let point = PlannedPoint::alone(self.point.clone(), loaded, &self.path, &self.sets)?;
        if point.hash != self.hash {
            return Err(RunnerError::StrangeShard {
                hash: self.hash.clone(),
            });
        }
        point.require_memory(rayon::current_num_threads().min(seeds.len()))?;
        let trials = parallel_map(seeds, |&seed| {
            if watch.stop.load(Ordering::Relaxed) {
                return Ok(None);
            }
            let trial = point.trial(seed, watch.stop)?;
            if let Some(trial) = &trial {
                (watch.on_trial)(trial);
            }
            Ok::<_, RunnerError>(trial)
        })?;
        let trials: Option<Vec<_>> = trials.into_iter().collect();
        Ok(trials.and_then(Shard::of))
    }
}
