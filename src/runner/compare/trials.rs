//! Arms × seeds: each pair is run once and its numbers kept in a file of its own.

use super::Field;
use crate::error::Error;
use crate::report::{Course, TrialResult, TrialTiming};
use crate::runner::crew::do_all;
use crate::runner::error::RunnerError;
use crate::runner::files::{write_json, write_text};
use crate::runner::folder::seed_folder_name;
use crate::runner::trial::{TrialOutcome, run_trial};
use crate::scenario::Arm;
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::sync::atomic::Ordering;

/// One seed of one arm.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trial {
    /// Hash of the arm's resolved scenario and the program's version.
    pub hash: String,
    /// What came of it.
    pub result: TrialResult,
    /// How it went.
    pub course: Course,
    /// What the clock said.
    pub timing: TrialTiming,
}

impl Trial {
    /// Checks that its course has three numbers for each block of episodes, the last of which ends with the last one.
    ///
    /// # Errors
    /// The field that was cut short.
    pub fn check(&self) -> Result<(), String> {
        let course = &self.course;
        let blocks = course.episodes.len();
        for (field, values) in [("length", &course.length), ("regret", &course.regret)] {
            if values.len() != blocks {
                return Err(format!(
                    "`course.{field}` has {} entries and `course.episodes` {blocks}: the file is damaged",
                    values.len()
                ));
            }
        }
        let last = course.episodes.last().copied().unwrap_or(0);
        if last == self.result.episodes {
            return Ok(());
        }
        Err(format!(
            "`course.episodes` ends with episode {last} of {}: the file is damaged",
            self.result.episodes
        ))
    }
}

/// Trials of each arm, in the order of the seeds.
pub(super) type ByArm = Vec<(String, Vec<Trial>)>;

impl Field<'_> {
    /// Arms × seeds below `folder`, those found there not run again; none if stopped.
    pub(super) fn trials(
        &self,
        folder: &Path,
        arms: &[&Arm],
        seeds: &[u64],
    ) -> Result<Option<ByArm>, Error> {
        let hashes = arms
            .iter()
            .map(|arm| begin_arm(&folder.join(&arm.name), arm))
            .collect::<Result<Vec<String>, _>>()?;
        let jobs: Vec<(usize, u64)> = (0..arms.len())
            .flat_map(|arm| seeds.iter().map(move |&seed| (arm, seed)))
            .collect();
        let done = do_all(&jobs, |&(arm, seed)| {
            let (arm, hash) = (arms[arm], &hashes[arm]);
            self.trial(&folder.join(&arm.name), arm, hash, seed)
        })?;
        let Some(done) = done.into_iter().collect::<Option<Vec<Trial>>>() else {
            return Ok(None);
        };
        let by_arm = arms.iter().zip(done.chunks(seeds.len()));
        let named = by_arm.map(|(arm, trials)| (arm.name.clone(), trials.to_vec()));
        Ok(Some(named.collect()))
    }

    fn trial(
        &self,
        folder: &Path,
        arm: &Arm,
        hash: &str,
        seed: u64,
    ) -> Result<Option<Trial>, Error> {
        let path = folder.join(seed_folder_name(seed) + ".json");
        if let Some(trial) = finished(&path, hash) {
            (self.watch.on_trial)(&arm.name, &trial);
            return Ok(Some(trial));
        }
        if self.watch.stop.load(Ordering::Relaxed) {
            return Ok(None); // before the world is made, which may take its time
        }
        let first = seed == self.request.seeds[0];
        let keep = first.then(|| folder.join(seed_folder_name(seed)));
        let outcome = run_trial(&arm.scenario, seed, keep.as_deref(), self.watch.stop)?;
        let Some(TrialOutcome {
            result,
            course,
            timing,
        }) = outcome
        else {
            return Ok(None);
        };
        let trial = Trial {
            hash: hash.to_owned(),
            result,
            course,
            timing,
        };
        write_json(&path, &trial).map_err(RunnerError::write(&path))?;
        (self.watch.on_trial)(&arm.name, &trial);
        Ok(Some(trial))
    }
}

/// The folder of an arm with its resolved scenario; returns the hash that its trials carry.
fn begin_arm(folder: &Path, arm: &Arm) -> Result<String, RunnerError> {
    std::fs::create_dir_all(folder).map_err(RunnerError::write(folder))?;
    let resolved = arm.scenario.to_toml();
    let path = folder.join("resolved.toml");
    write_text(&path, &resolved).map_err(RunnerError::write(&path))?;
    Ok(hash(&resolved))
}

/// A finished trial of the same scenario. A file that cannot be read, or does not have all of it, is run again.
fn finished(path: &Path, hash: &str) -> Option<Trial> {
    let text = std::fs::read_to_string(path).ok()?;
    let trial: Trial = serde_json::from_str(&text).ok()?;
    (trial.hash == hash && trial.check().is_ok()).then_some(trial)
}

/// FNV-1a of the program's version and a resolved scenario (Fowler, Noll & Vo), in hexadecimal digits: the same on
/// every machine and with every compiler.
fn hash(resolved: &str) -> String {
    let version = env!("CARGO_PKG_VERSION").bytes();
    let hash = version
        .chain(resolved.bytes())
        .fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        });
    format!("{hash:016x}")
}
