//! φ and the first eigenvectors at moments of a run, as `snapshots.json`.

use super::error::ArchiveError;
use super::files::{read_json, write_compact_json};
use super::names;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Frame of a run: what was known at one moment.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    /// Environment steps taken before it.
    pub step: u64,
    /// States known.
    pub nodes: usize,
    /// Undirected edges known.
    pub edges: usize,
    /// φ by state number, to four digits.
    pub potential: Vec<f32>,
    /// The lowest eigenvalues, ascending; empty before the first spectrum.
    pub eigenvalues: Vec<f64>,
    /// The second to fifth eigenvector by state number, scaled by √n, to four digits, each with the sign that agrees
    /// best with the frame before; may be shorter than `potential` by the states found since the last spectrum.
    pub vectors: Vec<Vec<f32>>,
}

/// Writes the frames of a seed into its `folder`.
///
/// # Errors
/// If the file cannot be written.
pub fn write_snapshots(folder: &Path, frames: &Vec<Snapshot>) -> Result<(), ArchiveError> {
    let path = folder.join(names::SNAPSHOTS);
    write_compact_json(&path, frames).map_err(ArchiveError::write(&path))
}

/// The frames that a seed has left in its folder.
///
/// # Errors
/// If there is no such file, or it does not hold frames.
pub fn read_snapshots(folder: &Path) -> Result<Vec<Snapshot>, ArchiveError> {
    let path = folder.join(names::SNAPSHOTS);
    read_json(&path).map_err(|error| ArchiveError::damaged(&path, error.to_string()))
}
