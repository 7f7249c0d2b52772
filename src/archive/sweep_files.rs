//! Files of a sweep: what is swept, the numbers, and a row for each trial.

use super::error::ArchiveError;
use super::files::{write_atomically, write_csv, write_json, write_text};
use super::names;
use super::result_columns::ResultColumns;
use super::sweep::{PointSummary, Sweep, Swept};
use super::trial_record::TrialRecord;
use crate::disk;
use serde::Serialize;
use std::io::{self, Write};
use std::path::Path;

/// Trials of each point, in the order of the points and of the seeds.
pub type TrialsByPoint = Vec<Vec<TrialRecord>>;

/// Writes what is swept, and the scenario as it was given.
///
/// # Errors
/// If a file cannot be written.
pub fn begin_sweep(folder: &Path, swept: &Swept, scenario: &str) -> Result<(), ArchiveError> {
    let path = folder.join(names::SWEEP);
    write_json(&path, swept).map_err(ArchiveError::write(&path))?;
    let path = folder.join(names::SCENARIO);
    write_text(&path, scenario).map_err(ArchiveError::write(&path))
}

/// Makes the folder of a point, with its resolved scenario.
///
/// # Errors
/// If that is impossible.
pub fn begin_point(folder: &Path, resolved: &str) -> Result<(), ArchiveError> {
    super::comparison_files::begin_arm(folder, resolved)
}

/// Removes the numbers of an earlier sweep of the folder, which are not those of one that is under way.
///
/// # Errors
/// If that is impossible.
pub fn unwrite_sweep(folder: &Path) -> Result<(), ArchiveError> {
    for name in [names::SUMMARY, names::SWEEP_TRIALS, names::TIMINGS] {
        let path = folder.join(name);
        match disk::remove_file(&path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                return Err(ArchiveError::write(&path)(error));
            }
            _ => {}
        }
    }
    Ok(())
}

/// Writes the numbers and the tables behind them.
///
/// # Errors
/// If a file cannot be written.
pub fn write_sweep(
    folder: &Path,
    sweep: &Sweep,
    trials: &TrialsByPoint,
) -> Result<(), ArchiveError> {
    let path = folder.join(names::SUMMARY);
    write_json(&path, sweep).map_err(ArchiveError::write(&path))?;
    let path = folder.join(names::SWEEP_TRIALS);
    let rows = sweep_rows(sweep, trials);
    rows.and_then(|rows| write_atomically(&path, |file| file.write_all(&rows)))
        .map_err(ArchiveError::write(&path))?;
    let path = folder.join(names::TIMINGS);
    let points = sweep.points.iter().zip(trials);
    let times = points.flat_map(|(point, trials)| {
        trials.iter().map(|trial| {
            let (point, seed) = (point.hash.as_str(), trial.result.seed);
            (TimingRow { point, seed }, trial.timing)
        })
    });
    write_csv(&path, times).map_err(ArchiveError::write(&path))
}

/// The text of `sweep.csv`: a column for each key of the grid, and for the arms if there are any, before what came of the trial.
///
/// # Errors
/// None but what the format itself does not allow.
pub fn sweep_rows(sweep: &Sweep, trials: &TrialsByPoint) -> io::Result<Vec<u8>> {
    let has_arms = sweep.points.iter().any(|point| point.arm.is_some());
    let keys = sweep.grid.iter().map(|axis| axis.key.as_str());
    let keys: Vec<&str> = has_arms.then_some("arm").into_iter().chain(keys).collect();
    let mut table = csv::WriterBuilder::new()
        .has_headers(false)
        .from_writer(Vec::new());
    let mut has_header = false;
    for (point, trials) in sweep.points.iter().zip(trials) {
        let place = cells(point);
        for trial in trials {
            let row = Row::new(trial);
            if !has_header {
                has_header = true;
                let names = header(&row)?;
                table.write_record(keys.iter().copied().chain(&names))?;
            }
            table.serialize((&place, row))?;
        }
    }
    table.into_inner().map_err(|error| error.into_error())
}

/// What stands below the keys of a point: texts without quotes, the rest as JSON.
fn cells(point: &PointSummary) -> Vec<String> {
    let values = point.settings.iter().map(|setting| match &setting.value {
        serde_json::Value::String(text) => text.clone(),
        value => value.to_string(),
    });
    point.arm.iter().cloned().chain(values).collect()
}

/// The names of a row's columns.
fn header(row: &impl Serialize) -> io::Result<csv::StringRecord> {
    let mut table = csv::Writer::from_writer(Vec::new());
    table.serialize(row)?;
    let text = table.into_inner().map_err(|error| error.into_error())?;
    Ok(csv::Reader::from_reader(text.as_slice()).headers()?.clone())
}

/// What came of a trial of `sweep.csv`, before the columns that all tables share.
#[derive(Serialize)]
struct Row {
    seed: u64,
    episodes: usize,
    steps: u64,
    regret: f64,
}

impl Row {
    fn new(trial: &TrialRecord) -> (Self, ResultColumns) {
        let result = &trial.result;
        let head = Self {
            seed: result.seed,
            episodes: result.episodes,
            steps: result.steps,
            regret: result.regret,
        };
        (head, result.into())
    }
}

/// Row of `timings.csv`, before what the clock said.
#[derive(Serialize)]
struct TimingRow<'a> {
    point: &'a str,
    seed: u64,
}
