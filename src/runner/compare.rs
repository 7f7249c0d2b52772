//! Arms × seeds of one scenario, side by side.
//!
//! ```text
//! runs/four-rooms/2026-11-21T22-05-00Z-compare/
//!   arms.json       what is compared: arms with their settings, seeds, the command line
//!   scenario.toml   the scenario as it was given
//!   arms/gcn/       resolved.toml, and seed-1000.json as soon as that seed has ended
//!   tuning/…        the same for the step sizes tried for the sparse arm
//!   arms/gcn/seed-1000/   graph, policy and snapshots of the first seed
//!   compare.json    the numbers; what a clock said stands in `timing`
//!   compare.csv     a row for each arm and seed, without a clock;  timings.csv  the same with one
//!   report.html     all of it to look at
//! ```
//!
//! A trial that has ended is never run again in the same folder, as long as its arm's resolved scenario is the same:
//! each file carries a hash of it. So an interrupted comparison goes on where it was, and arms and seeds can be added.

use super::arms::{Arm, BASELINE, lay_arm, lay_settings};
use super::crew::do_all;
use super::error::RunnerError;
use super::files::{write_atomically, write_json};
use super::folder::{Existing, FolderKind, RunFolder, seed_folder_name};
use super::summarise::{regret_interval, summarise, timing};
use super::trial::{TrialOutcome, run_trial};
use super::tuning::{StepSizes, tuning_folder, tuning_seeds, tuning_trials};
use crate::error::Error;
use crate::report::{Comparison, Course, TrialResult, TrialTiming, Tuning, TuningEntry};
use crate::scenario::Loaded;
use serde::{Deserialize, Serialize};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// What to compare, and where to write it.
#[derive(Clone, Debug)]
pub struct CompareRequest {
    /// The scenario file, for messages and relative paths.
    pub path: PathBuf,
    /// Assignments laid over every arm; an arm's own settings win.
    pub sets: Vec<String>,
    /// Master seeds, without duplicates; at least one.
    pub seeds: Vec<u64>,
    /// Names of arms, without duplicates; at least one.
    pub arms: Vec<String>,
    /// Whether to compare with a sparse arm tuned for the world, too.
    pub tuned: bool,
    /// The folder; `runs/NAME/TIME-compare` if none is given.
    pub out: Option<PathBuf>,
    /// What to do if it exists.
    pub existing: Existing,
    /// The command line, for `arms.json`.
    pub arguments: Vec<String>,
}

/// Who watches a comparison, and may stop it.
#[derive(Clone, Copy)]
pub struct CompareWatch<'a> {
    /// Set from anywhere: trials under way are given up after their episode, no new ones begin.
    pub stop: &'a AtomicBool,
    /// Told of each trial as it ends: the arm's name and what came of it.
    pub on_trial: &'a (dyn Fn(&str, &Trial) + Sync),
}

/// One seed of one arm.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trial {
    /// Hash of the arm's resolved scenario and the program's version.
    pub hash: String,
    /// What came of it.
    pub result: TrialResult,
    /// How it went.
    pub course: Course,
    /// What the clock said.
    pub timing: TrialTiming,
}

/// What came of a comparison.
#[derive(Clone, Debug)]
pub struct CompareReport {
    /// Its numbers; none if it was stopped before every trial had ended.
    pub comparison: Option<Comparison>,
    /// Its folder.
    pub folder: PathBuf,
}

impl CompareRequest {
    /// How many trials it takes, those that a folder holds already included.
    pub fn num_trials(&self) -> usize {
        let extra = usize::from(!self.arms.iter().any(|arm| arm == BASELINE));
        let tuned = usize::from(self.tuned);
        (self.arms.len() + extra + tuned) * self.seeds.len() + tuned * tuning_trials()
    }
}

/// Compares arms over seeds. All arms see the same worlds: a seed draws slips, starts and the agent's choices from
/// streams of their own. Results do not depend on the number of threads.
///
/// # Errors
/// If an arm does not exist or does not go with the scenario, the folder cannot be used, or a trial fails; trials
/// that have ended by then are on disk.
///
/// # Panics
/// If there are no arms or no seeds.
pub fn compare(
    loaded: &Loaded,
    request: &CompareRequest,
    watch: CompareWatch<'_>,
) -> Result<CompareReport, Error> {
    assert!(!request.seeds.is_empty() && !request.arms.is_empty());
    let lay = |name: &String| lay_arm(name, &request.path, loaded, &request.sets);
    let arms: Vec<Arm> = request.arms.iter().map(lay).collect::<Result<_, _>>()?;
    let sparse = lay(&BASELINE.to_owned())?;
    let name = &loaded.scenario.name;
    let kind = FolderKind::Comparison;
    let folder = RunFolder::open_kind(kind, request.out.as_deref(), name, request.existing)?;
    let field = Field {
        loaded,
        request,
        watch,
        folder: folder.path(),
    };
    field.begin(&arms)?;
    let comparison = field.run(arms, sparse)?;
    if let Some((comparison, trials)) = &comparison {
        field.write(comparison, trials)?;
    }
    Ok(CompareReport {
        comparison: comparison.map(|(comparison, _)| comparison),
        folder: folder.path().to_owned(),
    })
}

/// A comparison under way.
struct Field<'a> {
    loaded: &'a Loaded,
    request: &'a CompareRequest,
    watch: CompareWatch<'a>,
    folder: &'a Path,
}

/// Trials of each arm, in the order of the seeds.
type ByArm = Vec<(String, Vec<Trial>)>;

impl Field<'_> {
    /// Runs everything; none if it was stopped.
    fn run(&self, arms: Vec<Arm>, sparse: Arm) -> Result<Option<(Comparison, ByArm)>, Error> {
        let seeds = &self.request.seeds;
        let tuned = match self.request.tuned {
            true => match self.tune(&sparse)? {
                Some(tuned) => Some(tuned),
                None => return Ok(None),
            },
            false => None,
        };
        // The sparse arm takes longest, so it goes first.
        let mut all: Vec<&Arm> = vec![&sparse];
        all.extend(tuned.as_ref().map(|tuned| &tuned.arm));
        all.extend(arms.iter().filter(|arm| arm.name != BASELINE));
        let Some(trials) = self.trials(&self.folder.join("arms"), &all, seeds)? else {
            return Ok(None);
        };
        let of = |name: &str| {
            let found = trials.iter().find(|(arm, _)| arm == name);
            found.map(|(_, trials)| trials.as_slice())
        };
        let sparse_trials = of(BASELINE).expect("the sparse arm was run");
        let tuned_trials = tuned.as_ref().and_then(|tuned| of(&tuned.arm.name));
        let summary = |arm: &Arm| {
            let trials = of(&arm.name).expect("every arm was run");
            summarise(&arm.name, trials, sparse_trials, tuned_trials)
        };
        let clock = |arm: &Arm| timing(&arm.name, of(&arm.name).expect("every arm was run"));
        let comparison = Comparison {
            scenario: self.loaded.scenario.name.clone(),
            seeds: seeds.clone(),
            arms: arms.iter().map(summary).collect(),
            episodes: self.loaded.scenario.run.episodes,
            optimal_steps: sparse_trials[0].result.optimal_steps,
            sparse_regret: regret_interval(sparse_trials),
            tuning: tuned.zip(tuned_trials).map(|(tuned, trials)| Tuning {
                seeds: tuned.seeds,
                tried: tuned.tried,
                chosen: tuned.chosen,
                regret: regret_interval(trials),
            }),
            timing: arms.iter().map(clock).collect(),
        };
        Ok(Some((comparison, trials)))
    }

    /// Tries the grid of step sizes; none if stopped.
    fn tune(&self, sparse: &Arm) -> Result<Option<Tuned>, Error> {
        let seeds = tuning_seeds(&self.request.seeds);
        let sizes: Vec<StepSizes> = StepSizes::grid().collect();
        let lay = |sizes: &StepSizes| {
            let settings = sparse.settings.iter().cloned().chain(sizes.settings());
            let (path, sets) = (&self.request.path, &self.request.sets);
            lay_settings(
                &sizes.arm_name(),
                settings.collect(),
                path,
                self.loaded,
                sets,
            )
        };
        let arms: Vec<Arm> = sizes.iter().map(lay).collect::<Result<_, _>>()?;
        let all: Vec<&Arm> = arms.iter().collect();
        let Some(trials) = self.trials(&tuning_folder(self.folder), &all, &seeds)? else {
            return Ok(None);
        };
        let tried: Vec<TuningEntry> = sizes
            .iter()
            .zip(&trials)
            .map(|(sizes, (_, trials))| sizes.entry(trials))
            .collect();
        let best = (0..tried.len())
            .min_by(|&a, &b| tried[a].regret_iqm.total_cmp(&tried[b].regret_iqm))
            .expect("the grid is not empty");
        Ok(Some(Tuned {
            arm: arms[best].clone(),
            chosen: tried[best],
            tried,
            seeds,
        }))
    }

    /// Arms × seeds below `folder`, those found there not run again; none if stopped.
    fn trials(&self, folder: &Path, arms: &[&Arm], seeds: &[u64]) -> Result<Option<ByArm>, Error> {
        let hashes = arms
            .iter()
            .map(|arm| begin_arm(&folder.join(&arm.name), arm))
            .collect::<Result<Vec<String>, _>>()?;
        let jobs: Vec<(usize, u64)> = (0..arms.len())
            .flat_map(|arm| seeds.iter().map(move |&seed| (arm, seed)))
            .collect();
        let done = do_all(&jobs, |&(arm, seed)| {
            let (arm, hash) = (arms[arm], &hashes[arm]);
            self.trial(&folder.join(&arm.name), arm, hash, seed)
        })?;
        let Some(done) = done.into_iter().collect::<Option<Vec<Trial>>>() else {
            return Ok(None);
        };
        let by_arm = arms.iter().zip(done.chunks(seeds.len()));
        let named = by_arm.map(|(arm, trials)| (arm.name.clone(), trials.to_vec()));
        Ok(Some(named.collect()))
    }

    fn trial(
        &self,
        folder: &Path,
        arm: &Arm,
        hash: &str,
        seed: u64,
    ) -> Result<Option<Trial>, Error> {
        let path = folder.join(seed_folder_name(seed) + ".json");
        if let Some(trial) = finished(&path, hash) {
            (self.watch.on_trial)(&arm.name, &trial);
            return Ok(Some(trial));
        }
        let first = seed == self.request.seeds[0];
        let keep = first.then(|| folder.join(seed_folder_name(seed)));
        let outcome = run_trial(&arm.scenario, seed, keep.as_deref(), self.watch.stop)?;
        let Some(TrialOutcome {
            result,
            course,
            timing,
        }) = outcome
        else {
            return Ok(None);
        };
        let trial = Trial {
            hash: hash.to_owned(),
            result,
            course,
            timing,
        };
        write_json(&path, &trial).map_err(RunnerError::write(&path))?;
        (self.watch.on_trial)(&arm.name, &trial);
        Ok(Some(trial))
    }

    /// Writes what is compared.
    fn begin(&self, arms: &[Arm]) -> Result<(), RunnerError> {
        let path = self.folder.join("arms.json");
        let about = Compared {
            program: concat!("eigentrail ", env!("CARGO_PKG_VERSION")).to_owned(),
            scenario: self.loaded.scenario.name.clone(),
            arguments: self.request.arguments.clone(),
            seeds: self.request.seeds.clone(),
            tuned: self.request.tuned,
            arms: arms
                .iter()
                .map(|arm| (arm.name.clone(), arm.settings.clone()))
                .collect(),
            started: jiff::Timestamp::now().to_string(),
        };
        write_json(&path, &about).map_err(RunnerError::write(&path))?;
        write_text(&self.folder.join("scenario.toml"), &self.loaded.text)
    }

    /// Writes the numbers and the tables behind them.
    fn write(&self, comparison: &Comparison, trials: &ByArm) -> Result<(), RunnerError> {
        let path = self.folder.join("compare.json");
        write_json(&path, comparison).map_err(RunnerError::write(&path))?;
        let sparse = trials.iter().find(|(arm, _)| arm == BASELINE);
        let sparse = sparse.map_or(&[][..], |(_, trials)| trials);
        let rows = trials.iter().flat_map(|(arm, trials)| {
            trials
                .iter()
                .zip(sparse)
                .map(|(trial, sparse)| Row::new(arm, &trial.result, &sparse.result))
        });
        write_csv(&self.folder.join("compare.csv"), rows)?;
        let times = trials.iter().flat_map(|(arm, trials)| {
            trials
                .iter()
                .map(|trial| TimingRow::new(arm, trial.result.seed, &trial.timing))
        });
        write_csv(&self.folder.join("timings.csv"), times)
    }
}

/// The tuned sparse arm.
struct Tuned {
    arm: Arm,
    chosen: TuningEntry,
    tried: Vec<TuningEntry>,
    seeds: Vec<u64>,
}

/// `arms.json`: what is compared, and who asked for it when.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Compared {
    /// Program and version.
    pub program: String,
    /// Name of the scenario.
    pub scenario: String,
    /// The command line.
    pub arguments: Vec<String>,
    /// Master seeds.
    pub seeds: Vec<u64>,
    /// Whether the sparse arm was tuned for the world.
    pub tuned: bool,
    /// Settings of each arm.
    pub arms: std::collections::BTreeMap<String, Vec<String>>,
    /// When it began.
    pub started: String,
}

/// A row of `compare.csv`.
#[derive(Serialize)]
struct Row<'a> {
    arm: &'a str,
    seed: u64,
    episodes: usize,
    steps: u64,
    regret: f64,
    ratio_to_sparse: Option<f64>,
    optimal_steps: f64,
    final_mean_steps: f64,
    first_goal_step: Option<u64>,
    episodes_to_1_5x: Option<u64>,
    steps_to_1_5x: Option<u64>,
    episodes_to_1_1x: Option<u64>,
    steps_to_1_1x: Option<u64>,
    nodes: usize,
    edges: usize,
    spectrum_refreshes: usize,
    gcn_fits: usize,
    spurious_maxima: Option<usize>,
}

impl<'a> Row<'a> {
    fn new(arm: &'a str, result: &TrialResult, sparse: &TrialResult) -> Self {
        Self {
            arm,
            seed: result.seed,
            episodes: result.episodes,
            steps: result.steps,
            regret: result.regret,
            ratio_to_sparse: (sparse.regret > 0.0).then(|| result.regret / sparse.regret),
            optimal_steps: result.optimal_steps,
            final_mean_steps: result.final_mean_steps,
            first_goal_step: result.first_goal_step,
            episodes_to_1_5x: result.within_1_5x.map(|a| a.episodes),
            steps_to_1_5x: result.within_1_5x.map(|a| a.steps),
            episodes_to_1_1x: result.within_1_1x.map(|a| a.episodes),
            steps_to_1_1x: result.within_1_1x.map(|a| a.steps),
            nodes: result.nodes,
            edges: result.edges,
            spectrum_refreshes: result.spectrum_refreshes,
            gcn_fits: result.gcn_fits,
            spurious_maxima: result.spurious_maxima,
        }
    }
}

/// A row of `timings.csv`.
#[derive(Serialize)]
struct TimingRow<'a> {
    arm: &'a str,
    seed: u64,
    wall_seconds: f64,
    spectrum_seconds: f64,
    fit_seconds: f64,
    rest_seconds: f64,
    steps_per_second: f64,
}

impl<'a> TimingRow<'a> {
    fn new(arm: &'a str, seed: u64, timing: &TrialTiming) -> Self {
        Self {
            arm,
            seed,
            wall_seconds: timing.wall_seconds,
            spectrum_seconds: timing.spectrum_seconds,
            fit_seconds: timing.fit_seconds,
            rest_seconds: timing.rest_seconds,
            steps_per_second: timing.steps_per_second,
        }
    }
}

/// The folder of an arm with its resolved scenario; returns the hash that its trials carry.
fn begin_arm(folder: &Path, arm: &Arm) -> Result<String, RunnerError> {
    std::fs::create_dir_all(folder).map_err(RunnerError::write(folder))?;
    let resolved = arm.scenario.to_toml();
    write_text(&folder.join("resolved.toml"), &resolved)?;
    Ok(hash(&resolved))
}

/// A finished trial of the same scenario. A file that cannot be read is run again.
fn finished(path: &Path, hash: &str) -> Option<Trial> {
    let text = std::fs::read_to_string(path).ok()?;
    let trial: Trial = serde_json::from_str(&text).ok()?;
    (trial.hash == hash).then_some(trial)
}

/// FNV-1a of the program's version and a resolved scenario (Fowler, Noll & Vo), in hexadecimal digits: the same on
/// every machine and with every compiler.
fn hash(resolved: &str) -> String {
    let version = env!("CARGO_PKG_VERSION").bytes();
    let hash = version
        .chain(resolved.bytes())
        .fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        });
    format!("{hash:016x}")
}

fn write_text(path: &Path, text: &str) -> Result<(), RunnerError> {
    write_atomically(path, |file| file.write_all(text.as_bytes())).map_err(RunnerError::write(path))
}

fn write_csv(path: &Path, rows: impl Iterator<Item = impl Serialize>) -> Result<(), RunnerError> {
    write_atomically(path, |file| {
        let mut table = csv::Writer::from_writer(file);
        for row in rows {
            table.serialize(row)?;
        }
        table.flush()
    })
    .map_err(RunnerError::write(path))
}
