//! The file of one trial of a comparison, `seed-0007.json` in the folder of its arm.

use super::comparison::{LearningCurve, TrialResult, TrialTiming};
use super::error::ArchiveError;
use super::files::{read_json, write_json};
use crate::scenario::Scenario;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Record of one seed of one arm.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrialRecord {
    /// Hash of the arm's resolved scenario and the program's version.
    pub hash: String,
    /// Its results.
    pub result: TrialResult,
    /// How it went.
    #[serde(rename = "course")]
    pub curve: LearningCurve,
    /// What the clock said.
    pub timing: TrialTiming,
}

impl TrialRecord {
    /// Reads it.
    ///
    /// # Errors
    /// If there is none, or it is damaged.
    pub fn read(path: &Path) -> Result<Self, ArchiveError> {
        let trial: Self =
            read_json(path).map_err(|e| ArchiveError::damaged(path, e.to_string()))?;
        let checked = trial.check();
        checked.map_err(|rule| ArchiveError::damaged(path, rule))?;
        Ok(trial)
    }

    /// Reads it if there is a whole one with this hash.
    pub fn finished(path: &Path, hash: &str) -> Option<Self> {
        Self::read(path).ok().filter(|trial| trial.hash == hash)
    }

    /// Writes it.
    ///
    /// # Errors
    /// If that is impossible.
    pub fn write(&self, path: &Path) -> Result<(), ArchiveError> {
        write_json(path, self).map_err(ArchiveError::write(path))
    }

    /// Whether its curve has three numbers for each block of episodes, the last of which ends with the last one; else
    /// the field that was cut short.
    pub(super) fn check(&self) -> Result<(), String> {
        let curve = &self.curve;
        let blocks = curve.episodes.len();
        for (field, values) in [("length", &curve.length), ("regret", &curve.regret)] {
            if values.len() != blocks {
                return Err(format!(
                    "`course.{field}` has {} entries and `course.episodes` {blocks}: the file is damaged",
                    values.len()
                ));
            }
        }
        let last = curve.episodes.last().copied().unwrap_or(0);
        if last == self.result.episodes {
            return Ok(());
        }
        Err(format!(
            "`course.episodes` ends with episode {last} of {}: the file is damaged",
            self.result.episodes
        ))
    }
}

/// FNV-1a of the program's version and a resolved scenario (Fowler, Noll & Vo), in hexadecimal digits: the same on
/// every machine and with every compiler.
pub fn scenario_hash(resolved: &str) -> String {
    format!("{:016x}", fnv1a(versioned(resolved)))
}

/// The same of a scenario and of what stands in the files that it names, wherever they are: all that a result depends on beside
/// its seed.
///
/// # Errors
/// If a file cannot be read.
pub fn content_hash(scenario: &Scenario) -> Result<String, ArchiveError> {
    let read = |path: &PathBuf| {
        std::fs::read(path).map_err(|error| ArchiveError::damaged(path, error.to_string()))
    };
    let files = [&scenario.env.file, &scenario.shaping.file];
    let files: Vec<Vec<u8>> = files
        .into_iter()
        .flatten()
        .map(read)
        .collect::<Result<_, _>>()?;
    let mut scenario = scenario.clone();
    (scenario.env.file, scenario.shaping.file) = (None, None);
    let resolved = scenario.to_toml();
    let bytes = versioned(&resolved).chain(files.into_iter().flatten());
    Ok(format!("{:016x}", fnv1a(bytes)))
}

fn versioned(resolved: &str) -> impl Iterator<Item = u8> + '_ {
    env!("CARGO_PKG_VERSION").bytes().chain(resolved.bytes())
}

/// FNV-1a.
pub(super) fn fnv1a(bytes: impl IntoIterator<Item = u8>) -> u64 {
    let bytes = bytes.into_iter();
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}
