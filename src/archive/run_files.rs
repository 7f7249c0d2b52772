//! Files of a run folder around its seeds: who ran what, the scenario, the results.

use super::checkpoint::without_intervals;
use super::error::ArchiveError;
use super::files::{read_json, write_json, write_text};
use super::folder::RunFolder;
use super::names;
use super::summary::Summary;
use crate::scenario::Scenario;
use crate::time_stamp;
use serde::{Deserialize, Serialize};
use std::fs;
use std::path::{Path, PathBuf};

/// Contents of `run.json`: who ran what when, and how it ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunInfo {
    /// Program and version.
    pub program: String,
    /// Name of the scenario.
    pub scenario: String,
    /// The command line.
    pub arguments: Vec<String>,
    /// Master seeds that were ever run in this folder, ascending.
    pub seeds: Vec<u64>,
    /// How it ended, if it did.
    pub status: RunStatus,
    /// When it began.
    pub started: String,
    /// When it ended.
    pub ended: Option<String>,
}

/// State of a run as its folder tells it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RunStatus {
    /// It goes on, or was killed.
    Running,
    /// Every episode was run.
    Finished,
    /// It was told to stop.
    Interrupted,
    /// It ended with an error.
    Failed,
}

impl RunInfo {
    /// A run that begins now.
    pub fn begun(scenario: &Scenario, seeds: &[u64], arguments: Vec<String>) -> Self {
        Self {
            program: concat!("eigentrail ", env!("CARGO_PKG_VERSION")).to_owned(),
            scenario: scenario.name.clone(),
            arguments,
            seeds: seeds.to_vec(),
            status: RunStatus::Running,
            started: time_stamp::now(),
            ended: None,
        }
    }

    /// Notes how it ended, now.
    pub fn end(&mut self, status: RunStatus) {
        self.ended = Some(time_stamp::now());
        self.status = status;
    }
}

impl RunFolder {
    /// Whether the folder holds a run that goes on. One that was killed before its scenario was written begins anew.
    pub fn has_begun(&self) -> bool {
        let has = |name: &str| self.file(name).exists();
        self.is_resumed() && (has(names::RESOLVED) || has(names::SUMMARY))
    }

    /// Whether the run in the folder ended, and got to say so.
    pub fn is_noted_as_finished(&self) -> bool {
        let info = read_json::<RunInfo>(&self.file(names::RUN));
        self.is_resumed() && info.is_ok_and(|info| info.status == RunStatus::Finished)
    }

    /// The summary in the folder, if `scenario` is the one that began the run; a new one if there is none yet.
    ///
    /// # Errors
    /// If the scenarios differ, or a file cannot be read.
    pub fn summary(&self, scenario: &Scenario) -> Result<Summary, ArchiveError> {
        if self.has_begun() {
            self.require_same(scenario)?;
            let path = self.file(names::SUMMARY);
            if path.exists() {
                return read_json(&path).map_err(|e| ArchiveError::damaged(&path, e.to_string()));
            }
        }
        Ok(Summary {
            scenario: scenario.name.clone(),
            ..Summary::default()
        })
    }

    fn require_same(&self, scenario: &Scenario) -> Result<(), ArchiveError> {
        let now = without_intervals(&scenario.to_toml());
        let path = self.file(names::RESOLVED);
        let read = fs::read_to_string(&path);
        let before = read.map_err(|error| ArchiveError::damaged(&path, error.to_string()))?;
        let before = without_intervals(&before);
        match before == now {
            true => Ok(()),
            false => Err(mismatch(path, &before, &now)),
        }
    }

    /// Writes the results.
    ///
    /// # Errors
    /// If that is impossible.
    pub fn write_summary(&self, summary: &Summary) -> Result<(), ArchiveError> {
        let path = self.file(names::SUMMARY);
        write_json(&path, summary).map_err(ArchiveError::write(&path))
    }

    /// Writes the scenario as it was given, and then the one with every default.
    ///
    /// # Errors
    /// If that is impossible.
    pub fn write_scenario(&self, given: &str, scenario: &Scenario) -> Result<(), ArchiveError> {
        let write =
            |path: &Path, text: &str| write_text(path, text).map_err(ArchiveError::write(path));
        write(&self.file(names::SCENARIO), given)?;
        write(&self.file(names::RESOLVED), &scenario.to_toml())
    }

    /// Writes who runs what. Seeds that the folder knows already stay in the list.
    ///
    /// # Errors
    /// If that is impossible.
    pub fn write_info(&self, info: &mut RunInfo) -> Result<(), ArchiveError> {
        let path = self.file(names::RUN);
        if self.is_resumed()
            && let Ok(before) = read_json::<RunInfo>(&path)
        {
            info.seeds.extend(before.seeds);
            info.seeds.sort_unstable();
            info.seeds.dedup();
        }
        write_json(&path, info).map_err(ArchiveError::write(&path))
    }
}

/// Names the first line that differs.
fn mismatch(path: PathBuf, before: &str, now: &str) -> ArchiveError {
    let mut old = before.lines();
    let line = now.lines().find(|&line| old.next() != Some(line));
    ArchiveError::ResumeMismatch {
        path,
        line: line.or(old.next()).unwrap_or_default().to_owned(),
    }
}
