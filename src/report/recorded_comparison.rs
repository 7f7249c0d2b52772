//! A comparison's folder read back.

use super::comparison::Comparison;
use super::recorded::{RecordedSeed, damaged};
use crate::runner::files::read_json;
use crate::runner::{Compared, RunnerError, Trial, seed_folder_name};
use crate::scenario::Scenario;
use std::fs;
use std::path::Path;

/// A comparison that has ended.
#[derive(Clone, Debug)]
pub struct RecordedComparison {
    /// Its numbers.
    pub numbers: Comparison,
    /// What was compared.
    pub about: Compared,
    /// Its arms, in the order of [`Comparison::arms`].
    pub arms: Vec<RecordedArm>,
}

/// One arm.
#[derive(Clone, Debug)]
pub struct RecordedArm {
    /// Its name.
    pub name: String,
    /// Its scenario, complete.
    pub scenario: Scenario,
    /// The text of it.
    pub resolved: String,
    /// In the order of the seeds.
    pub trials: Vec<Trial>,
    /// What the first seed saw; without episodes and refreshes.
    pub first: Option<RecordedSeed>,
}

impl RecordedComparison {
    /// Reads the folder of a comparison.
    ///
    /// # Errors
    /// If it is none, has not ended, or a file does not say what it should.
    pub fn read(folder: &Path) -> Result<Self, RunnerError> {
        let path = folder.join("compare.json");
        if !path.is_file() {
            return Err(damaged(folder, "this comparison has not ended yet"));
        }
        let numbers: Comparison = read_json(&path).map_err(|e| damaged(&path, &e.to_string()))?;
        let path = folder.join("arms.json");
        let about = read_json(&path).map_err(|e| damaged(&path, &e.to_string()))?;
        let arms = (numbers.arms.iter())
            .map(|arm| RecordedArm::read(&folder.join("arms"), &arm.name, &numbers.seeds))
            .collect::<Result<_, _>>()?;
        Ok(Self {
            numbers,
            about,
            arms,
        })
    }
}

impl RecordedArm {
    fn read(arms: &Path, name: &str, seeds: &[u64]) -> Result<Self, RunnerError> {
        let folder = arms.join(name);
        let path = folder.join("resolved.toml");
        let resolved = fs::read_to_string(&path).map_err(|e| damaged(&path, &e.to_string()))?;
        let scenario = toml::from_str(&resolved).map_err(|e| damaged(&path, e.message()))?;
        let trial = |&seed: &u64| {
            let path = folder.join(seed_folder_name(seed) + ".json");
            read_json(&path).map_err(|e| damaged(&path, &e.to_string()))
        };
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
            scenario,
            resolved,
            trials,
            first,
        })
    }
}
