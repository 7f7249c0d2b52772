//! A comparison's folder read back.

use super::comparison::Comparison;
use super::recorded::{RecordedSeed, damaged, resolved_scenario};
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
        whole(&numbers).map_err(|rule| damaged(&path, &rule))?;
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
    fn read(arms: &Path, name: &str, seeds: &[u64]) -> Result<Self, RunnerError> {
        let folder = arms.join(name);
        let path = folder.join("resolved.toml");
        let resolved = fs::read_to_string(&path).map_err(|e| damaged(&path, &e.to_string()))?;
        let scenario = resolved_scenario(&resolved).map_err(|rule| damaged(&path, &rule))?;
        let trial = |&seed: &u64| {
            let path = folder.join(seed_folder_name(seed) + ".json");
            let trial: Trial = read_json(&path).map_err(|e| damaged(&path, &e.to_string()))?;
            trial.check().map_err(|rule| damaged(&path, &rule))?;
            Ok(trial)
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
