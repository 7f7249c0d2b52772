//! What a sweep has to run: every point of the grid, read and checked before the first one begins.

use super::shard_task::ShardTask;
use crate::archive::{TrialRecord, content_hash, scenario_hash};
use crate::runner::build::warn_of_file;
use crate::runner::compare::trials::record;
use crate::runner::compare::unknown_arms;
use crate::runner::error::RunnerError;
use crate::runner::estimate;
use crate::runner::optimal_returns::KnownOptima;
use crate::runner::trial;
use crate::scenario::{Axis, GridPoint, Loaded, Scenario, Worlds, grid};
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Request for a sweep.
#[derive(Clone, Debug, Default)]
pub struct SweepRequest {
    /// The scenario file, or the name of one that comes with the program.
    pub path: PathBuf,
    /// Assignments laid over every point; the grid wins over them.
    pub sets: Vec<String>,
    /// Keys and their values.
    pub axes: Vec<Axis>,
    /// Arms laid over every point, without duplicates; the scenario as it stands, if there are none.
    pub arms: Vec<String>,
    /// Master seeds, without duplicates; at least one.
    pub seeds: Vec<u64>,
    /// The command line, for `sweep.json`.
    pub arguments: Vec<String>,
}

/// A sweep that can be run.
#[derive(Debug)]
pub struct SweepPlan {
    pub(super) axes: Vec<Axis>,
    pub(super) seeds: Vec<u64>,
    pub(super) arguments: Vec<String>,
    pub(super) points: Vec<PlannedPoint>,
    path: PathBuf,
    sets: Vec<String>,
    first: Loaded,
}

/// One point, complete and checked.
#[derive(Debug)]
pub(super) struct PlannedPoint {
    pub point: GridPoint,
    pub scenario: Scenario,
    pub hash: String,
    worlds: Arc<SharedWorlds>,
}

/// Worlds that several points have in common, and their optima, each worked out by the first trial that needs it.
#[derive(Debug)]
struct SharedWorlds {
    worlds: Worlds,
    optimal: KnownOptima,
}

impl SweepPlan {
    /// Reads the scenario and lays every point over it.
    ///
    /// # Errors
    /// If there is no such scenario, the grid is none, an arm does not exist, or a point is no scenario.
    ///
    /// # Panics
    /// If there are no seeds.
    pub fn of(request: SweepRequest) -> Result<Self, RunnerError> {
        assert!(!request.seeds.is_empty());
        let text = Scenario::read(&request.path)?;
        let mut shared = HashMap::new();
        let mut first = None;
        let mut points = Vec::new();
        for point in grid(&request.arms, &request.axes)? {
            let loaded = point.load(&request.path, &text, &request.sets)?;
            if first.is_none() {
                first = Some(loaded.clone());
            }
            let laid = PlannedPoint::of(point, loaded, &request.path, &request.sets, &mut shared)?;
            points.push(laid);
        }
        Ok(Self {
            axes: request.axes,
            seeds: request.seeds,
            arguments: request.arguments,
            points,
            path: request.path,
            sets: request.sets,
            first: first.expect("a grid has a point"),
        })
    }

    /// Name of the scenario.
    pub fn name(&self) -> &str {
        &self.first.scenario.name
    }

    /// How many trials it takes; points that are the same one share theirs.
    pub fn num_trials(&self) -> usize {
        self.distinct().len() * self.seeds.len()
    }

    /// How many points there are.
    pub fn num_points(&self) -> usize {
        self.points.len()
    }

    /// A point as another process is told of it.
    ///
    /// # Panics
    /// If there is no such point.
    pub fn task(&self, point: usize) -> ShardTask {
        let planned = &self.points[point];
        ShardTask {
            path: self.path.clone(),
            text: self.first.text.clone(),
            sets: self.sets.clone(),
            point: planned.point.clone(),
            hash: planned.hash.clone(),
        }
    }

    /// Refuses a sweep whose trials, `at_once` of them side by side, cannot fit into this machine.
    pub(super) fn require_memory(&self, at_once: usize) -> Result<(), RunnerError> {
        let at_once = at_once.min(self.num_trials());
        let mut points = self.points.iter();
        points.try_for_each(|point| point.require_memory(at_once))
    }

    /// The scenario of the first point, which names the sweep.
    pub(super) fn first(&self) -> &Loaded {
        &self.first
    }

    /// Where equal points are swept by default, whatever the seeds: so the same command finds its folder again.
    pub(super) fn default_folder(&self) -> PathBuf {
        let hashes: Vec<&str> = self.points.iter().map(|point| &*point.hash).collect();
        let name = format!("sweep-{}", scenario_hash(&hashes.concat()));
        Path::new("runs").join(self.name()).join(name)
    }

    /// The first of all points that are the same one.
    pub(super) fn distinct(&self) -> Vec<usize> {
        let mut seen = HashSet::new();
        let points = self.points.iter().enumerate();
        points
            .filter(|(_, point)| seen.insert(&point.hash))
            .map(|(i, _)| i)
            .collect()
    }
}

impl PlannedPoint {
    fn of(
        point: GridPoint,
        loaded: Loaded,
        path: &Path,
        sets: &[String],
        shared: &mut HashMap<String, Arc<SharedWorlds>>,
    ) -> Result<Self, RunnerError> {
        let mut scenario = match &point.arm {
            None => loaded.scenario.clone(),
            Some(name) => {
                let laid = point.lay_arm(name, &loaded, path, sets)?;
                let laid = laid.ok_or_else(|| unknown_arms([name.as_str()], &loaded.scenario))?;
                laid.scenario
            }
        };
        scenario.arms.clear(); // what others there are has no part in a result
        let worlds = shared
            .entry(worlds_key(&loaded.scenario))
            .or_insert_with(|| {
                warn_of_file(&loaded.worlds, [&scenario]);
                Arc::new(SharedWorlds {
                    worlds: loaded.worlds,
                    optimal: KnownOptima::default(),
                })
            });
        Ok(Self {
            hash: content_hash(&scenario)?,
            point,
            worlds: Arc::clone(worlds),
            scenario,
        })
    }

    /// The point by itself.
    pub fn alone(
        point: GridPoint,
        loaded: Loaded,
        path: &Path,
        sets: &[String],
    ) -> Result<Self, RunnerError> {
        Self::of(point, loaded, path, sets, &mut HashMap::new())
    }

    pub fn require_memory(&self, at_once: usize) -> Result<(), RunnerError> {
        estimate::require_memory(&self.scenario, self.worlds.worlds.first(), at_once)
    }

    /// Runs one seed; none if `stop` was set before it ended.
    pub fn trial(&self, seed: u64, stop: &AtomicBool) -> Result<Option<TrialRecord>, RunnerError> {
        let SharedWorlds { worlds, optimal } = &*self.worlds;
        let optimal = optimal.of(worlds, seed);
        let mut trial = trial::begin(&self.scenario, worlds, optimal, seed)?;
        record(&mut *trial, &self.hash, None, stop, None)
    }
}

/// Whatever worlds are made of, so that points with the same can share them: a large one is kept once.
fn worlds_key(scenario: &Scenario) -> String {
    let only_worlds = Scenario {
        name: String::new(),
        env: scenario.env.clone(),
        run: scenario.run.clone(),
        arms: scenario.arms.clone(),
        ..Scenario::default()
    };
    format!("{}{:?}", only_worlds.to_toml(), scenario.shaping.file)
}
