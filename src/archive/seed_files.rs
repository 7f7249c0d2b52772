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

use super::error::ArchiveError;
use super::files::{Table, read_npy, write_npy};
use super::names;
use super::rows::{EpisodeRow, RefreshRow};
use crate::disk::{self, write_atomically};
use faer::MatRef;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Open tables of a seed.
#[derive(Debug)]
pub struct SeedTables {
    episodes: Table,
    refreshes: Table,
    timings: Table,
}

/// Bytes of a seed's tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TableLengths {
    episodes: u64,
    refreshes: u64,
    timings: u64,
}

#[derive(Serialize)]
struct TimingRow {
    what: &'static str,
    step: u64,
    seconds: f64,
}

impl SeedTables {
    /// Creates the folder and begins its tables anew.
    ///
    /// # Errors
    /// If that is impossible.
    pub fn create(folder: &Path) -> Result<Self, ArchiveError> {
        disk::create_subfolder(folder).map_err(ArchiveError::write(folder))?;
        let table = |name: &str| {
            let path = folder.join(name);
            Table::create(&path).map_err(ArchiveError::write(&path))
        };
        Ok(Self {
            episodes: table(names::EPISODES)?,
            refreshes: table(names::REFRESHES)?,
            timings: table(names::TIMINGS)?,
        })
    }

    /// Goes on with tables that had these lengths.
    ///
    /// # Errors
    /// If one is missing or shorter, or cannot be written to.
    pub fn go_on(folder: &Path, lengths: TableLengths) -> Result<Self, ArchiveError> {
        let table = |name: &str, length: u64| {
            let path = folder.join(name);
            Table::go_on(&path, length).map_err(ArchiveError::write(&path))
        };
        Ok(Self {
            episodes: table(names::EPISODES, lengths.episodes)?,
            refreshes: table(names::REFRESHES, lengths.refreshes)?,
            timings: table(names::TIMINGS, lengths.timings)?,
        })
    }

    /// Brings every row to the disk.
    ///
    /// # Errors
    /// If that is impossible.
    pub fn sync(&mut self) -> Result<TableLengths, ArchiveError> {
        let sync = |table: &mut Table| {
            let length = table.sync();
            length.map_err(ArchiveError::write(table.path()))
        };
        Ok(TableLengths {
            episodes: sync(&mut self.episodes)?,
            refreshes: sync(&mut self.refreshes)?,
            timings: sync(&mut self.timings)?,
        })
    }

    /// Appends an episode, which took so many seconds.
    ///
    /// # Errors
    /// If rows cannot be written.
    pub fn episode(&mut self, row: &EpisodeRow, seconds: f64) -> Result<(), ArchiveError> {
        push(&mut self.episodes, row)?;
        self.timing("episode", row.step, seconds)
    }

    /// Appends a refresh; `spectrum_seconds` and `fit_seconds` are those of what was done.
    ///
    /// # Errors
    /// If rows cannot be written.
    pub fn refresh(
        &mut self,
        row: &RefreshRow,
        spectrum_seconds: Option<f64>,
        fit_seconds: Option<f64>,
    ) -> Result<(), ArchiveError> {
        push(&mut self.refreshes, row)?;
        for (what, seconds) in [
            ("spectrum_refresh", spectrum_seconds),
            ("gcn_fit", fit_seconds),
        ] {
            if let Some(seconds) = seconds {
                self.timing(what, row.step, seconds)?;
            }
        }
        Ok(())
    }

    /// Brings every row to its file.
    ///
    /// # Errors
    /// If that is impossible.
    pub fn flush(&mut self) -> Result<(), ArchiveError> {
        for table in [&mut self.episodes, &mut self.refreshes, &mut self.timings] {
            let flushed = table.flush();
            flushed.map_err(ArchiveError::write(table.path()))?;
        }
        Ok(())
    }

    fn timing(&mut self, what: &'static str, step: u64, seconds: f64) -> Result<(), ArchiveError> {
        let row = TimingRow {
            what,
            step,
            seconds,
        };
        push(&mut self.timings, &row)
    }
}

fn push(table: &mut Table, row: &impl Serialize) -> Result<(), ArchiveError> {
    let pushed = table.push(row);
    pushed.map_err(ArchiveError::write(table.path()))
}

/// Writes `potential.npy`: φ by state number.
///
/// # Errors
/// If it cannot be written.
pub fn write_potential(folder: &Path, potential: &[f64]) -> Result<(), ArchiveError> {
    let path = folder.join(names::POTENTIAL);
    write_npy(&path, &[potential.len()], potential.iter().copied())
        .map_err(ArchiveError::write(&path))
}

/// Writes a matrix as an array of its shape.
///
/// # Errors
/// If it cannot be written.
pub fn write_matrix(path: &Path, matrix: MatRef<'_, f64>) -> Result<(), ArchiveError> {
    let (rows, columns) = matrix.shape();
    let entries = (0..rows * columns).map(|i| matrix[(i / columns, i % columns)]);
    write_npy(path, &[rows, columns], entries).map_err(ArchiveError::write(path))
}

/// Writes `states.csv`: the number of each state and its label below `columns`.
///
/// # Errors
/// If it cannot be written.
pub fn write_states(
    folder: &Path,
    columns: &[&str],
    labels: impl Iterator<Item = Vec<String>>,
) -> Result<(), ArchiveError> {
    let path = folder.join(names::STATES);
    write_atomically(&path, |file| {
        let mut table = csv::Writer::from_writer(file);
        table.write_record([&["state"], columns].concat())?;
        for (state, mut fields) in labels.enumerate() {
            fields.insert(0, state.to_string());
            table.write_record(fields)?;
        }
        table.flush()
    })
    .map_err(ArchiveError::write(&path))
}

/// The label of each state in `states.csv`: its place (`row,col`) or name.
///
/// # Errors
/// If there is no such table.
pub fn read_labels(folder: &Path) -> Result<Vec<String>, ArchiveError> {
    let path = folder.join(names::STATES);
    let mut reader =
        csv::Reader::from_path(&path).map_err(|e| ArchiveError::damaged(&path, e.to_string()))?;
    let labels = reader.records().map(|row| {
        let row = row.map_err(|e| ArchiveError::damaged(&path, e.to_string()))?;
        Ok(row.iter().skip(1).collect::<Vec<_>>().join(","))
    });
    labels.collect()
}

/// φ of every state of a finished seed, with the state's place (`row,col`) or name.
///
/// # Errors
/// If the folder does not hold a finished seed.
pub fn read_potential(folder: &Path) -> Result<Vec<(String, f64)>, ArchiveError> {
    let path = folder.join(names::POTENTIAL);
    let read = read_npy(&path);
    let (_, values) = read.map_err(|e| ArchiveError::damaged(&path, e.to_string()))?;
    let labels = read_labels(folder)?;
    if labels.len() < values.len() {
        let message = format!("{} states, but {} potentials", labels.len(), values.len());
        return Err(ArchiveError::damaged(&folder.join(names::STATES), message));
    }
    Ok(labels.into_iter().zip(values).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_quoted_where_they_must_be() {
        let folder = tempfile::tempdir().unwrap();
        let names = ["hall", "hall, \"old\""].map(str::to_owned);
        let labels = names.iter().map(|name| vec![name.clone()]);
        write_states(folder.path(), &["name"], labels).unwrap();
        let text = std::fs::read_to_string(folder.path().join("states.csv")).unwrap();
        assert_eq!(text, "state,name\n0,hall\n1,\"hall, \"\"old\"\"\"\n");
        assert_eq!(read_labels(folder.path()).unwrap(), names);
    }

    #[test]
    fn a_run_without_states_has_a_header() {
        let folder = tempfile::tempdir().unwrap();
        write_states(folder.path(), &["row", "col"], std::iter::empty()).unwrap();
        let text = std::fs::read_to_string(folder.path().join("states.csv")).unwrap();
        assert_eq!(text, "state,row,col\n");
        assert!(read_labels(folder.path()).unwrap().is_empty());
    }
}
