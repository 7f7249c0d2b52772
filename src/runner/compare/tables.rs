//! What a comparison leaves on disk: what was compared, the numbers, and a row for each trial.

use super::Field;
use super::summarise::regret_ratio;
use super::trials::ByArm;
use crate::report::{Comparison, TrialResult, TrialTiming};
use crate::runner::error::RunnerError;
use crate::runner::files::{write_csv, write_json, write_text};
use crate::scenario::{Arm, BASELINE};
use serde::{Deserialize, Serialize};

impl Field<'_> {
    /// Writes what is compared.
    pub(super) fn begin(&self, arms: &[Arm]) -> Result<(), RunnerError> {
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
            started: crate::time_stamp::now(),
        };
        write_json(&path, &about).map_err(RunnerError::write(&path))?;
        let path = self.folder.join("scenario.toml");
        write_text(&path, &self.loaded.text).map_err(RunnerError::write(&path))
    }

    /// Writes the numbers and the tables behind them.
    pub(super) fn write(&self, comparison: &Comparison, trials: &ByArm) -> Result<(), RunnerError> {
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
        let path = self.folder.join("compare.csv");
        write_csv(&path, rows).map_err(RunnerError::write(&path))?;
        let times = trials.iter().flat_map(|(arm, trials)| {
            trials
                .iter()
                .map(|trial| TimingRow::new(arm, trial.result.seed, &trial.timing))
        });
        let path = self.folder.join("timings.csv");
        write_csv(&path, times).map_err(RunnerError::write(&path))
    }
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
    optimal_return: f64,
    final_return: f64,
    final_ratio: f64,
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
            ratio_to_sparse: regret_ratio(result, sparse),
            optimal_steps: result.optimal_steps,
            final_mean_steps: result.final_mean_steps,
            optimal_return: result.optimal_return,
            final_return: result.final_return,
            final_ratio: result.final_ratio,
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
