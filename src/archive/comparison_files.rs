//! Files of a comparison: what was compared, the numbers, and a row for each trial.

use super::comparison::{Comparison, TrialResult};
use super::error::ArchiveError;
use super::files::{write_csv, write_json, write_text};
use super::names;
use super::result_columns::ResultColumns;
use super::trial_record::TrialRecord;
use crate::disk::create_subfolder;
use crate::scenario::BASELINE;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Trials of each arm, by its name and in the order of the seeds.
pub type TrialsByArm = Vec<(String, Vec<TrialRecord>)>;

/// Contents of `arms.json`: what is compared, and who asked for it when.
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

/// Writes what is compared, and the scenario as it was given.
///
/// # Errors
/// If a file cannot be written.
pub fn begin_comparison(
    folder: &Path,
    compared: &Compared,
    scenario: &str,
) -> Result<(), ArchiveError> {
    let path = folder.join(names::ARMS);
    write_json(&path, compared).map_err(ArchiveError::write(&path))?;
    let path = folder.join(names::SCENARIO);
    write_text(&path, scenario).map_err(ArchiveError::write(&path))
}

/// Makes the folder of an arm, with its resolved scenario.
///
/// # Errors
/// If that is impossible.
pub fn begin_arm(folder: &Path, resolved: &str) -> Result<(), ArchiveError> {
    for folder in [folder.parent(), Some(folder)].into_iter().flatten() {
        create_subfolder(folder).map_err(ArchiveError::write(folder))?;
    }
    let path = folder.join(names::RESOLVED);
    write_text(&path, resolved).map_err(ArchiveError::write(&path))
}

/// Writes the numbers and the tables behind them.
///
/// # Errors
/// If a file cannot be written.
pub fn write_comparison(
    folder: &Path,
    comparison: &Comparison,
    trials: &TrialsByArm,
) -> Result<(), ArchiveError> {
    let path = folder.join(names::COMPARISON);
    write_json(&path, comparison).map_err(ArchiveError::write(&path))?;
    let sparse = trials.iter().find(|(arm, _)| arm == BASELINE);
    let sparse = sparse.map_or(&[][..], |(_, trials)| trials);
    let rows = trials.iter().flat_map(|(arm, trials)| {
        trials
            .iter()
            .zip(sparse)
            .map(|(trial, sparse)| Row::new(arm, &trial.result, &sparse.result))
    });
    let path = folder.join(names::TRIALS);
    write_csv(&path, rows).map_err(ArchiveError::write(&path))?;
    let times = trials.iter().flat_map(|(arm, trials)| {
        trials.iter().map(|trial| {
            let seed = trial.result.seed;
            (TimingRow { arm, seed }, trial.timing)
        })
    });
    let path = folder.join(names::TIMINGS);
    write_csv(&path, times).map_err(ArchiveError::write(&path))
}

/// Row of `compare.csv`, before what came of the trial.
#[derive(Serialize)]
struct Row<'a> {
    arm: &'a str,
    seed: u64,
    episodes: usize,
    steps: u64,
    regret: f64,
    ratio_to_sparse: Option<f64>,
}

impl<'a> Row<'a> {
    fn new(arm: &'a str, result: &TrialResult, sparse: &TrialResult) -> (Self, ResultColumns) {
        let head = Self {
            arm,
            seed: result.seed,
            episodes: result.episodes,
            steps: result.steps,
            regret: result.regret,
            ratio_to_sparse: result.regret_ratio(sparse),
        };
        (head, result.into())
    }
}

/// Row of `timings.csv`, before what the clock said.
#[derive(Serialize)]
struct TimingRow<'a> {
    arm: &'a str,
    seed: u64,
}
