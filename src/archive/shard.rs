//! Shards of a sweep: some seeds of one point in one file, from whichever process computed them.
//!
//! ```text
//! points/9a3c5d7e01f2b468/seed-0007.json         one seed
//! points/9a3c5d7e01f2b468/seeds-0008-0011.json   seeds that follow each other
//! ```
//!
//! The folder is named by the hash of what is run, the file by its seeds: whoever computes the same again writes the same
//! results to the same place, and nothing that is found there needs to be trusted or asked about.

use super::comparison::LearningCurve;
use super::error::ArchiveError;
use super::files::{read_json, write_compact_json};
use super::names::seed_folder_name;
use super::trial_record::{TrialRecord, fnv1a};
use crate::disk;
use serde::{Deserialize, Serialize};
use std::fs;
use std::path::Path;

/// Trials of one point, all with its hash.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Shard {
    /// Ascending by seed; at least one.
    pub trials: Vec<TrialRecord>,
}

impl Shard {
    /// Those of a point; none if there are no trials.
    pub fn of(mut trials: Vec<TrialRecord>) -> Option<Self> {
        trials.sort_by_key(|trial| trial.result.seed);
        (!trials.is_empty()).then_some(Self { trials })
    }

    /// Writes it into the folder of its point, which is made if it is not there.
    ///
    /// # Errors
    /// If that is impossible.
    pub fn write(&self, folder: &Path) -> Result<(), ArchiveError> {
        disk::create_subfolder(folder).map_err(ArchiveError::write(folder))?;
        let path = folder.join(self.file_name());
        write_compact_json(&path, self).map_err(ArchiveError::write(&path))
    }

    fn file_name(&self) -> String {
        let seeds: Vec<u64> = self.trials.iter().map(|trial| trial.result.seed).collect();
        let (first, last) = (seeds[0], seeds[seeds.len() - 1]);
        let gaps = seeds
            .windows(2)
            .any(|pair| pair[0].checked_add(1) != Some(pair[1]));
        match (seeds.len(), gaps) {
            (1, _) => format!("{}.json", seed_folder_name(first)),
            (_, false) => format!("seeds-{first:04}-{last:04}.json"),
            // Another choice of seeds between the same two is another shard.
            (_, true) => {
                let all = fnv1a(seeds.iter().flat_map(|seed| seed.to_le_bytes()));
                format!("seeds-{first:04}-{last:04}-{all:016x}.json")
            }
        }
    }
}

/// Whether a shard may have this name.
pub(super) fn is_shard(name: &str) -> bool {
    let Some(name) = name.strip_suffix(".json") else {
        return false;
    };
    let numbers = name
        .strip_prefix("seed-")
        .or_else(|| name.strip_prefix("seeds-"));
    numbers.is_some_and(|numbers| {
        let is_number =
            |part: &str| !part.is_empty() && part.chars().all(|c| c.is_ascii_hexdigit());
        numbers.split('-').all(is_number)
    })
}

/// The whole trials with this hash in the folder of a point, without their curves, of which a summary makes no use. What is
/// damaged or has another hash is passed over: it is run anew.
pub fn read_shards(folder: &Path, hash: &str) -> Vec<TrialRecord> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let paths = entries.map(|entry| entry.path());
    let mut shards: Vec<_> = paths
        .filter(|path| {
            path.file_name()
                .and_then(|name| name.to_str())
                .is_some_and(is_shard)
        })
        .collect();
    shards.sort();
    let trials = shards.iter().flat_map(|path| {
        let shard = read_json::<Shard>(path);
        shard.map_or_else(|_| Vec::new(), |shard| shard.trials)
    });
    let whole = trials.filter(|trial| trial.hash == hash && trial.check().is_ok());
    whole
        .map(|trial| TrialRecord {
            curve: LearningCurve::default(),
            ..trial
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::archive::{TrialResult, TrialTiming};

    fn trial(seed: u64) -> TrialRecord {
        let result: TrialResult = serde_json::from_value(serde_json::json!({
            "seed": seed, "episodes": 2, "steps": 9, "regret": 0.1, "optimal_steps": 3.0, "final_mean_steps": 4.5,
            "optimal_return": -3.0, "final_return": -4.5, "final_ratio": 1.5, "first_goal_step": null,
            "within_1_5x": null, "within_1_1x": null, "nodes": 4, "edges": 3, "spectrum_refreshes": 0, "gcn_fits": 0,
            "spurious_maxima": null
        }))
        .unwrap();
        TrialRecord {
            hash: "h".to_owned(),
            result,
            curve: LearningCurve {
                episodes: vec![2],
                length: vec![4.5],
                regret: vec![0.1],
            },
            timing: TrialTiming::default(),
        }
    }

    fn shard(seeds: &[u64]) -> Shard {
        Shard::of(seeds.iter().copied().map(trial).collect()).unwrap()
    }

    #[test]
    fn names_tell_shards_apart() {
        assert_eq!(shard(&[7]).file_name(), "seed-0007.json");
        assert_eq!(shard(&[9, 8, 10]).file_name(), "seeds-0008-0010.json");
        let (one, other) = (shard(&[1, 3, 9]).file_name(), shard(&[1, 4, 9]).file_name());
        assert!(one.starts_with("seeds-0001-0009-") && one != other);
        for name in [&*one, "seed-0007.json", "seeds-0008-0010.json"] {
            assert!(is_shard(name), "{name}");
        }
        for name in ["seed-0007", "seed-.json", "seed-x.json", "notes.json"] {
            assert!(!is_shard(name), "{name}");
        }
    }

    #[test]
    fn what_is_damaged_or_of_another_program_is_run_anew() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("point");
        shard(&[1, 2]).write(&path).unwrap();
        shard(&[5]).write(&path).unwrap();
        let seeds = |hash: &str| -> Vec<u64> {
            let trials = read_shards(&path, hash);
            trials.iter().map(|trial| trial.result.seed).collect()
        };
        assert_eq!(seeds("h"), [5, 1, 2]);
        assert!(seeds("other").is_empty());
        fs::write(path.join("seed-0005.json"), "[").unwrap();
        let mut short = shard(&[6]);
        short.trials[0].curve.length.clear();
        short.write(&path).unwrap();
        assert_eq!(seeds("h"), [1, 2]);
        assert!(read_shards(&folder.path().join("none"), "h").is_empty());
    }
}
