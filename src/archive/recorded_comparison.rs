//! A comparison's folder read back.

use super::comparison::Comparison;
use super::comparison_files::Compared;
use super::error::ArchiveError;
use super::files::read_json;
use super::names::{self, seed_folder_name, trial_file_name};
use super::recorded::{RecordedSeed, resolved_scenario};
use super::trial_record::TrialRecord;
use crate::scenario::{ArmParams, Scenario};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// Numbers and arms of a comparison that has ended.
#[derive(Clone, Debug)]
pub struct RecordedComparison {
    /// Its numbers.
    pub numbers: Comparison,
    /// What was compared.
    pub about: Compared,
    /// Its arms, in the order of [`Comparison::arms`].
    pub arms: Vec<RecordedArm>,
}

/// Scenario and trials of one arm.
#[derive(Clone, Debug)]
pub struct RecordedArm {
    /// Its name.
    pub name: String,
    /// What it is, in one line, if the scenario says so.
    pub about: Option<String>,
    /// Its scenario, complete.
    pub scenario: Scenario,
    /// The text of it.
    pub resolved: String,
    /// In the order of the seeds.
    pub trials: Vec<TrialRecord>,
    /// What the first seed saw; without episodes and refreshes.
    pub first: Option<RecordedSeed>,
}

impl RecordedComparison {
    /// Reads the folder of a comparison.
    ///
    /// # Errors
    /// If it is none, has not ended, or a file does not say what it should.
    pub fn read(folder: &Path) -> Result<Self, ArchiveError> {
        let path = folder.join(names::COMPARISON);
        if !path.is_file() {
            return Err(ArchiveError::damaged(
                folder,
                "this comparison has not ended yet",
            ));
        }
        let numbers: Comparison =
            read_json(&path).map_err(|e| ArchiveError::damaged(&path, e.to_string()))?;
        whole(&numbers).map_err(|rule| ArchiveError::damaged(&path, rule))?;
        let path = folder.join(names::ARMS);
        let about = read_json(&path).map_err(|e| ArchiveError::damaged(&path, e.to_string()))?;
        let mut told = abouts(folder);
        let arms = (numbers.arms.iter())
            .map(|arm| {
                let about = told.remove(&arm.name);
                let folder = folder.join(names::ARMS_FOLDER);
                RecordedArm::read(&folder, &arm.name, about, &numbers.seeds)
            })
            .collect::<Result<_, _>>()?;
        Ok(Self {
            numbers,
            about,
            arms,
        })
    }
}

/// What the scenario says about arms of its own; nothing if it says nothing.
fn abouts(folder: &Path) -> BTreeMap<String, String> {
    #[derive(Default, Deserialize)]
    #[serde(default)]
    struct Told {
        arms: BTreeMap<String, ArmParams>,
    }
    let text = fs::read_to_string(folder.join(names::SCENARIO)).unwrap_or_default();
    let told: Told = toml::from_str(&text).unwrap_or_default();
    let arms = told.arms.into_iter();
    arms.filter_map(|(name, arm)| Some((name, arm.about?)))
        .collect()
}

/// A comparison has seeds and arms, and the clock's numbers of each arm.
fn whole(numbers: &Comparison) -> Result<(), String> {
    if numbers.seeds.is_empty() {
        return Err("`seeds` is empty".to_owned());
    }
    if numbers.arms.is_empty() {
        return Err("`arms` is empty".to_owned());
    }
    let arms = numbers.arms.iter().map(|arm| &arm.name);
    let timed = numbers.timing.iter().map(|arm| &arm.name);
    if arms.eq(timed) {
        return Ok(());
    }
    Err("`timing` does not have the arms of `arms` in their order".to_owned())
}

impl RecordedArm {
    fn read(
        arms: &Path,
        name: &str,
        about: Option<String>,
        seeds: &[u64],
    ) -> Result<Self, ArchiveError> {
        let folder = arms.join(name);
        let path = folder.join(names::RESOLVED);
        let resolved =
            fs::read_to_string(&path).map_err(|e| ArchiveError::damaged(&path, e.to_string()))?;
        let scenario =
            resolved_scenario(&resolved).map_err(|rule| ArchiveError::damaged(&path, rule))?;
        let trial = |&seed: &u64| TrialRecord::read(&folder.join(trial_file_name(seed)));
        let trials = seeds.iter().map(trial).collect::<Result<_, _>>()?;
        let first = seeds
            .first()
            .map(|&seed| (folder.join(seed_folder_name(seed)), seed));
        let first = match first {
            Some((path, seed)) if path.is_dir() => Some(RecordedSeed::read_sights(&path, seed)?),
            _ => None,
        };
        Ok(Self {
            name: name.to_owned(),
            about,
            scenario,
            resolved,
            trials,
            first,
        })
    }
}
