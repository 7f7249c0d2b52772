//! A grid × seeds of one scenario, on this machine or in shards on many.
//!
//! ```text
//! runs/four_rooms/sweep-5f0c1d2e3a4b6978/
//!   sweep.json      what is swept: keys and values, seeds, the hash of each point, the command line
//!   scenario.toml   the scenario as it was given
//!   points/9a3c…/   a folder a point, named by its hash: resolved.toml, and shards of seeds as soon as they have ended
//!   summary.json    the numbers, without a clock
//!   sweep.csv       a row for each point and seed;  timings.csv  what a clock said
//! ```
//!
//! The hash is of everything a result depends on beside its seed, so that what is found under it need not be run again, by whomever
//! it was made. [`SweepPlan`] is what is to be done, [`ShardTask`] a point as another process is told of it, [`OpenSweep`] the
//! folder that shards come together in. [`sweep`] does all of it here.

mod plan;
mod shard_task;
mod summarise;

pub use plan::{SweepPlan, SweepRequest};
pub use shard_task::ShardTask;

use super::error::RunnerError;
use super::parallel_map::parallel_map;
use crate::archive::{ArchiveError, LearningCurve};
use crate::archive::{
    Existing, FolderKind, RunFolder, Shard, Sweep, Swept, SweptPoint, TrialRecord, TrialsByPoint,
    begin_point, begin_sweep, names, read_shards, sweep_rows, unwrite_sweep, write_sweep,
};
use crate::time_stamp;
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use summarise::summarise;

/// Observer of a sweep, and the flag that stops it.
#[derive(Clone, Copy)]
pub struct SweepWatch<'a> {
    /// Set from anywhere: trials under way are given up, no new ones begin.
    pub stop: &'a AtomicBool,
    /// Told of each trial as it ends.
    pub on_trial: &'a (dyn Fn(&TrialRecord) + Sync),
}

/// What came of a sweep, and its folder.
#[derive(Clone, Debug)]
pub struct SweepOutcome {
    /// Its numbers, and the text of `sweep.csv`; none if it was stopped before every trial had ended.
    pub sweep: Option<(Sweep, String)>,
    /// Its folder; nobody else writes there while this is kept.
    pub folder: RunFolder,
}

/// Runs what is not finished of a sweep, as many trials at a time as there are threads. Results do not depend on how many, nor on
/// how often it was stopped and gone on with.
///
/// # Errors
/// If the folder cannot be used, or a trial fails; trials that have ended by then are on disk.
pub fn sweep(
    plan: &Arc<SweepPlan>,
    out: Option<&Path>,
    existing: Existing,
    watch: SweepWatch<'_>,
) -> Result<SweepOutcome, RunnerError> {
    plan.require_memory(rayon::current_num_threads())?;
    let open = OpenSweep::open(plan, out, existing)?;
    for trial in open.lock().values() {
        (watch.on_trial)(trial);
    }
    let jobs = open.unfinished().into_iter();
    let jobs: Vec<(usize, u64)> = jobs
        .flat_map(|(point, seeds)| seeds.into_iter().map(move |seed| (point, seed)))
        .collect();
    parallel_map(&jobs, |&(point, seed)| {
        if watch.stop.load(Ordering::Relaxed) {
            return Ok(()); // before the optimum is worked out, which may take its time
        }
        if let Some(trial) = plan.points[point].trial(seed, watch.stop)? {
            open.put(Shard {
                trials: vec![trial.clone()],
            })?;
            (watch.on_trial)(&trial);
        }
        Ok::<_, RunnerError>(())
    })?;
    let sweep = open.finish()?;
    Ok(SweepOutcome {
        sweep,
        folder: open.folder,
    })
}

/// The folder of a sweep with what is finished in it. Shards are put into it from many threads.
#[derive(Debug)]
pub struct OpenSweep {
    plan: Arc<SweepPlan>,
    folder: RunFolder,
    /// By hash and seed, without curves.
    finished: Mutex<HashMap<(String, u64), TrialRecord>>,
}

impl OpenSweep {
    /// Opens `out`, or `runs/NAME/sweep-HASH` if none is given, and reads what is there; with [`Existing::Replace`] it begins anew.
    ///
    /// # Errors
    /// If the folder cannot be used.
    pub fn open(
        plan: &Arc<SweepPlan>,
        out: Option<&Path>,
        existing: Existing,
    ) -> Result<Self, RunnerError> {
        let path = out.map_or_else(|| plan.default_folder(), PathBuf::from);
        let folder = RunFolder::open_kind(FolderKind::Sweep, Some(&path), plan.first(), existing)?;
        begin_sweep(folder.path(), &plan.swept(), &plan.first().text)?;
        let mut finished = HashMap::new();
        for point in plan.distinct() {
            let point = &plan.points[point];
            let below = point_folder(&folder, &point.hash);
            begin_point(&below, &point.scenario.to_toml())?;
            for trial in read_shards(&below, &point.hash) {
                if plan.seeds.contains(&trial.result.seed) {
                    finished.insert((point.hash.clone(), trial.result.seed), trial);
                }
            }
        }
        let open = Self {
            plan: Arc::clone(plan),
            folder,
            finished: Mutex::new(finished),
        };
        if !open.unfinished().is_empty() {
            unwrite_sweep(open.folder.path())?;
        }
        Ok(open)
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Whether a sweep had begun there before.
    pub fn was_begun(&self) -> bool {
        self.folder.is_resumed()
    }

    /// How many trials are finished; equal points share theirs.
    pub fn num_finished(&self) -> usize {
        self.lock().len()
    }

    /// The seeds that are not finished, by point; of points that are the same one, the first.
    pub fn unfinished(&self) -> Vec<(usize, Vec<u64>)> {
        let finished = self.lock();
        let missing = self.plan.distinct().into_iter().map(|point| {
            let hash = &self.plan.points[point].hash;
            let seeds = self.plan.seeds.iter().copied();
            let seeds = seeds.filter(|&seed| !finished.contains_key(&(hash.clone(), seed)));
            (point, seeds.collect::<Vec<u64>>())
        });
        missing.filter(|(_, seeds)| !seeds.is_empty()).collect()
    }

    /// Keeps a shard, wherever it was computed. One that is known is written again, to the same place.
    ///
    /// # Errors
    /// If it is none of this sweep, or cannot be written.
    pub fn put(&self, shard: Shard) -> Result<(), RunnerError> {
        let hashes: HashSet<&str> = self.plan.points.iter().map(|point| &*point.hash).collect();
        let strange = shard.trials.iter().find(|trial| {
            let seed = trial.result.seed;
            trial.hash != shard.trials[0].hash
                || !hashes.contains(&*trial.hash)
                || !self.plan.seeds.contains(&seed)
        });
        if let Some(TrialRecord { hash, .. }) = strange {
            let hash = hash.clone();
            return Err(RunnerError::StrangeShard { hash });
        }
        let Some(first) = shard.trials.first() else {
            return Ok(());
        };
        shard.write(&point_folder(&self.folder, &first.hash))?;
        let mut finished = self.lock();
        for trial in shard.trials {
            let curve = LearningCurve::default();
            let place = (trial.hash.clone(), trial.result.seed);
            finished.insert(place, TrialRecord { curve, ..trial });
        }
        Ok(())
    }

    /// Writes the numbers, and returns them with the text of `sweep.csv`; none if something is not finished.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn finish(&self) -> Result<Option<(Sweep, String)>, RunnerError> {
        let finished = self.lock();
        let of_point = |point: &plan::PlannedPoint| -> Option<Vec<TrialRecord>> {
            let of_seed = |&seed: &u64| finished.get(&(point.hash.clone(), seed)).cloned();
            self.plan.seeds.iter().map(of_seed).collect()
        };
        let trials: Option<TrialsByPoint> = self.plan.points.iter().map(of_point).collect();
        let Some(trials) = trials else {
            return Ok(None);
        };
        let points = self.plan.points.iter().zip(&trials);
        let sweep = Sweep {
            scenario: self.plan.name().to_owned(),
            seeds: self.plan.seeds.clone(),
            grid: self.plan.axes.clone(),
            points: points
                .map(|(point, trials)| summarise(point, trials))
                .collect(),
        };
        write_sweep(self.path(), &sweep, &trials)?;
        let path = self.folder.file(names::SWEEP_TRIALS);
        let rows = sweep_rows(&sweep, &trials).map_err(ArchiveError::write(&path))?;
        Ok(Some((sweep, String::from_utf8_lossy(&rows).into_owned())))
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, HashMap<(String, u64), TrialRecord>> {
        self.finished.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn point_folder(folder: &RunFolder, hash: &str) -> PathBuf {
    folder.file(names::POINTS_FOLDER).join(hash)
}

impl SweepPlan {
    /// What `sweep.json` says.
    fn swept(&self) -> Swept {
        let points = self.points.iter().map(|point| SweptPoint {
            hash: point.hash.clone(),
            point: point.point.clone(),
        });
        Swept {
            program: concat!("eigentrail ", env!("CARGO_PKG_VERSION")).to_owned(),
            scenario: self.name().to_owned(),
            arguments: self.arguments.clone(),
            seeds: self.seeds.clone(),
            grid: self.axes.clone(),
            points: points.collect(),
            started: time_stamp::now(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(grid: &[&str], seeds: &[u64]) -> (Arc<SweepPlan>, tempfile::TempDir) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.toml");
        let text = "[env]\nrows = 4\ncols = 4\n[run]\nepisodes = 30\n";
        std::fs::write(&path, text).unwrap();
        let request = SweepRequest {
            path,
            axes: grid.iter().map(|axis| axis.parse().unwrap()).collect(),
            seeds: seeds.to_vec(),
            ..SweepRequest::default()
        };
        (Arc::new(SweepPlan::of(request).unwrap()), folder)
    }

    static GO_ON: AtomicBool = AtomicBool::new(false);

    fn quiet() -> SweepWatch<'static> {
        SweepWatch {
            stop: &GO_ON,
            on_trial: &|_| {},
        }
    }

    /// Shards computed elsewhere, in chunks of any size and twice, come to the same bytes as a sweep on one machine.
    #[test]
    fn shards_from_elsewhere_come_to_the_same_bytes() {
        let (plan, folder) = plan(&["agent.gamma=0.9,1"], &[0, 1, 2, 5]);
        let here = sweep(
            &plan,
            Some(&folder.path().join("a")),
            Existing::Resume,
            quiet(),
        )
        .unwrap();
        let path = folder.path().join("b");
        let open = OpenSweep::open(&plan, Some(&path), Existing::Resume).unwrap();
        assert!(open.finish().unwrap().is_none());
        for chunk in [&[0, 1][..], &[2, 5], &[1, 2]] {
            for point in 0..2 {
                let told = serde_json::to_string(&plan.task(point)).unwrap();
                let task: ShardTask = serde_json::from_str(&told).unwrap();
                let shard = task.run(chunk, quiet()).unwrap().unwrap();
                open.put(shard).unwrap();
            }
        }
        assert!(open.unfinished().is_empty());
        assert!(open.finish().unwrap().is_some());
        for name in ["summary.json", "sweep.csv"] {
            let read = |folder: &Path| std::fs::read(folder.join(name)).unwrap();
            assert_eq!(read(here.folder.path()), read(&path), "{name}");
        }
        drop(open);
        // What is finished is not run again, and another choice of seeds needs only what is new.
        let (more, _folder) = self::plan(&["agent.gamma=1,0.5"], &[5, 0]);
        let open = OpenSweep::open(&more, Some(&path), Existing::Resume).unwrap();
        assert_eq!(open.unfinished(), [(1, vec![5, 0])]);
        assert!(!path.join("summary.json").exists());
    }

    #[test]
    fn a_shard_of_another_sweep_is_refused() {
        let (plan, folder) = plan(&["agent.gamma=1"], &[0]);
        let (other, _folder) = self::plan(&["agent.gamma=0.9"], &[0]);
        let out = folder.path().join("o");
        let open = OpenSweep::open(&plan, Some(&out), Existing::Resume).unwrap();
        let shard = other.task(0).run(&[0], quiet()).unwrap().unwrap();
        let error = open.put(shard).unwrap_err();
        assert!(matches!(error, RunnerError::StrangeShard { .. }), "{error}");
        let mut task = plan.task(0);
        task.hash = "0".to_owned();
        let error = task.run(&[0], quiet()).unwrap_err();
        assert!(matches!(error, RunnerError::StrangeShard { .. }), "{error}");
    }

    #[test]
    fn points_that_are_the_same_one_are_run_once() {
        let (plan, folder) = plan(&["agent.gamma=1,1.0"], &[3]);
        let counted = std::sync::atomic::AtomicUsize::new(0);
        let count = |_: &TrialRecord| {
            counted.fetch_add(1, Ordering::Relaxed);
        };
        let watch = SweepWatch {
            on_trial: &count,
            ..quiet()
        };
        let out = folder.path().join("o");
        let swept = sweep(&plan, Some(&out), Existing::Resume, watch).unwrap();
        let (swept, rows) = swept.sweep.unwrap();
        assert_eq!((swept.points.len(), rows.lines().count()), (2, 3));
        assert_eq!(plan.num_trials(), 1);
        assert_eq!(counted.into_inner(), 1);
    }
}
