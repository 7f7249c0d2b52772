//! The files of one seed: rows as they happen, arrays at the end.
//!
//! | file | a row or entry for each |
//! |---|---|
//! | `episodes.csv` | episode |
//! | `refreshes.csv` | refresh of the spectrum, of the potential, or of both |
//! | `timings.csv` | the same and each episode, with seconds; the only one of these files that knows a clock |
//! | `states.csv` | state: its number and its place or name |
//! | `potential.npy` | state: φ |
//! | `eigenvectors.npy` | state of the last refresh × eigenvector: orthonormal columns, eigenvalues ascending |

use super::error::RunnerError;
use super::files::{Table, read_npy, write_atomically, write_npy};
use crate::engine::{EpisodeRecord, RefreshRecord};
use crate::env::StepStatus;
use faer::MatRef;
use serde::Serialize;
use std::io::Write;
use std::path::{Path, PathBuf};

/// The open tables of one seed.
#[derive(Debug)]
pub struct SeedRecords {
    folder: PathBuf,
    episodes: Table,
    refreshes: Table,
    timings: Table,
}

#[derive(Serialize)]
struct EpisodeRow {
    episode: u64,
    step: u64,
    length: u64,
    #[serde(rename = "return")]
    plain_return: f64,
    shaped_return: f64,
    status: &'static str,
    regret: f64,
    nodes: usize,
    edges: usize,
}

#[derive(Serialize)]
struct RefreshRow {
    step: u64,
    nodes: usize,
    edges: usize,
    pairs: Option<usize>,
    converged: Option<usize>,
    cold_start: Option<bool>,
    applications: Option<usize>,
    solves: Option<usize>,
    max_relative_residual: Option<f64>,
    largest_eigenvalue: Option<f64>,
    fitted: bool,
    fit_epochs: Option<usize>,
    initial_loss: Option<f64>,
    loss: Option<f64>,
}

#[derive(Serialize)]
struct TimingRow {
    what: &'static str,
    step: u64,
    seconds: f64,
}

impl SeedRecords {
    /// Creates the folder and begins its tables anew.
    pub fn create(folder: &Path) -> Result<Self, RunnerError> {
        std::fs::create_dir_all(folder).map_err(RunnerError::write(folder))?;
        let table = |name: &str| {
            let path = folder.join(name);
            Table::create(&path).map_err(RunnerError::write(&path))
        };
        Ok(Self {
            folder: folder.to_owned(),
            episodes: table("episodes.csv")?,
            refreshes: table("refreshes.csv")?,
            timings: table("timings.csv")?,
        })
    }

    /// An episode has ended; `regret` is that of the run so far.
    pub fn episode(
        &mut self,
        record: &EpisodeRecord,
        regret: f64,
        seconds: f64,
    ) -> Result<(), RunnerError> {
        let row = EpisodeRow {
            episode: record.episode,
            step: record.step,
            length: record.length,
            plain_return: record.plain_return,
            shaped_return: record.shaped_return,
            status: status_name(record.status),
            regret,
            nodes: record.nodes,
            edges: record.edges,
        };
        push(&mut self.episodes, &row)?;
        self.timing("episode", record.step, seconds)
    }

    /// The spectrum, the potential, or both were brought up to date.
    pub fn refresh(&mut self, record: &RefreshRecord) -> Result<(), RunnerError> {
        let spectrum = record.spectrum.as_ref();
        let convergence = spectrum.map(|s| &s.convergence);
        let fit = record.fit.as_ref().and_then(|f| f.fit.as_ref());
        let row = RefreshRow {
            step: record.step,
            nodes: record.nodes,
            edges: record.edges,
            pairs: spectrum.map(|s| s.eigenvalues.len()),
            converged: convergence.map(|c| c.converged),
            cold_start: spectrum.map(|s| s.cold_start),
            applications: convergence.map(|c| c.applications),
            solves: convergence.map(|c| c.solves),
            max_relative_residual: convergence.map(|c| c.max_relative_residual),
            largest_eigenvalue: spectrum.and_then(|s| s.eigenvalues.last().copied()),
            fitted: record.fit.is_some(),
            fit_epochs: fit.map(|f| f.epochs),
            initial_loss: fit.map(|f| f.initial_loss),
            loss: fit.map(|f| f.loss),
        };
        push(&mut self.refreshes, &row)?;
        if spectrum.is_some() {
            self.timing("spectrum_refresh", record.step, record.spectrum_seconds)?;
        }
        if record.fit.is_some() {
            self.timing("gcn_fit", record.step, record.fit_seconds)?;
        }
        Ok(())
    }

    /// Brings every row to its file.
    pub fn flush(&mut self) -> Result<(), RunnerError> {
        for table in [&mut self.episodes, &mut self.refreshes, &mut self.timings] {
            table
                .flush()
                .map_err(|source| write_error(table.path(), source))?;
        }
        Ok(())
    }

    /// Writes what is known at the end: `labels` are the states' places or names, below the columns `columns`.
    pub fn finish(
        &mut self,
        potential: &[f64],
        eigenvectors: Option<MatRef<'_, f64>>,
        columns: &str,
        labels: impl Iterator<Item = String>,
    ) -> Result<(), RunnerError> {
        self.flush()?;
        let path = self.folder.join("states.csv");
        write_atomically(&path, |file| {
            writeln!(file, "state,{columns}")?;
            for (state, label) in labels.enumerate() {
                writeln!(file, "{state},{label}")?;
            }
            Ok(())
        })
        .map_err(RunnerError::write(&path))?;
        let path = self.folder.join("potential.npy");
        write_npy(&path, &[potential.len()], potential.iter().copied())
            .map_err(RunnerError::write(&path))?;
        match eigenvectors {
            Some(vectors) => write_matrix(&self.folder.join("eigenvectors.npy"), vectors),
            None => Ok(()),
        }
    }

    fn timing(&mut self, what: &'static str, step: u64, seconds: f64) -> Result<(), RunnerError> {
        let row = TimingRow {
            what,
            step,
            seconds,
        };
        push(&mut self.timings, &row)
    }
}

/// Writes a matrix as an array of its shape.
pub fn write_matrix(path: &Path, matrix: MatRef<'_, f64>) -> Result<(), RunnerError> {
    let (rows, columns) = matrix.shape();
    let entries = (0..rows * columns).map(|i| matrix[(i / columns, i % columns)]);
    write_npy(path, &[rows, columns], entries).map_err(RunnerError::write(path))
}

/// Writes `states.csv`: the number of each state and the fields of its label, a place (two of them) or a name.
pub fn write_labels(
    folder: &Path,
    labels: impl Iterator<Item = Vec<String>>,
) -> Result<(), RunnerError> {
    let path = folder.join("states.csv");
    write_atomically(&path, |file| {
        let mut table = csv::Writer::from_writer(file);
        for (state, mut fields) in labels.enumerate() {
            if state == 0 {
                let places = ["state", "row", "col"];
                let named = ["state", "name"];
                let header = if fields.len() == 2 {
                    &places[..]
                } else {
                    &named
                };
                table.write_record(header)?;
            }
            fields.insert(0, state.to_string());
            table.write_record(fields)?;
        }
        table.flush()
    })
    .map_err(RunnerError::write(&path))
}

fn push(table: &mut Table, row: &impl Serialize) -> Result<(), RunnerError> {
    table
        .push(row)
        .map_err(|source| write_error(table.path(), source))
}

fn write_error(path: &Path, source: std::io::Error) -> RunnerError {
    RunnerError::Write {
        path: path.to_owned(),
        source,
    }
}

pub(super) fn status_name(status: StepStatus) -> &'static str {
    match status {
        StepStatus::Running => "running",
        StepStatus::Terminated => "terminated",
        StepStatus::Truncated => "truncated",
    }
}

/// φ of every state of a finished seed, with the state's place (`row,col`) or name.
///
/// # Errors
/// If the folder does not hold a finished seed.
pub fn read_potential(folder: &Path) -> Result<Vec<(String, f64)>, RunnerError> {
    let damaged = |path: &Path, message: String| RunnerError::Damaged {
        path: path.to_owned(),
        message,
    };
    let values_path = folder.join("potential.npy");
    let (_, values) = read_npy(&values_path).map_err(|e| damaged(&values_path, e.to_string()))?;
    let path = folder.join("states.csv");
    let mut reader = csv::Reader::from_path(&path).map_err(|e| damaged(&path, e.to_string()))?;
    let mut labels = Vec::with_capacity(values.len());
    for row in reader.records() {
        let row = row.map_err(|e| damaged(&path, e.to_string()))?;
        labels.push(row.iter().skip(1).collect::<Vec<_>>().join(","));
    }
    if labels.len() < values.len() {
        let message = format!("{} states, but {} potentials", labels.len(), values.len());
        return Err(damaged(&path, message));
    }
    Ok(labels.into_iter().zip(values).collect())
}
