//! Checkpoints of a seed: all that a run needs to go on, in the middle of an episode.
//!
//! A seed has two, the newest and the one before, so that a write that is torn leaves one that is whole. A checkpoint is on the
//! disk, and its name too, before anything that came after it is relied on; rows of tables are on the disk before it is.

use super::container::{Kind, pack, unpack};
use super::error::ArchiveError;
use super::names;
use crate::disk::{self, write_atomically};
use serde::{Deserialize, Serialize};
use serde_bytes::ByteBuf;
use std::collections::BTreeMap;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

pub(crate) const KIND: Kind = Kind {
    letters: b"CKPT",
    version: 2,
};

/// Moment of a seed's run, written down.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Checkpoint {
    /// Program and version.
    pub program: String,
    /// The scenario with every default, as TOML.
    pub scenario: String,
    /// Master seed.
    pub seed: u64,
    /// Environment steps taken.
    pub steps: u64,
    /// Episodes that have ended.
    pub episodes: usize,
    /// States known.
    pub states: usize,
    /// The run itself.
    pub run: ByteBuf,
    /// What its observers go on from, by their names.
    pub observers: BTreeMap<String, ByteBuf>,
}

impl Checkpoint {
    /// Reads a checkpoint.
    ///
    /// # Errors
    /// If there is none, or if it is none or damaged, with the reason.
    pub fn read(path: &Path) -> Result<Self, ArchiveError> {
        let bytes =
            fs::read(path).map_err(|error| ArchiveError::damaged(path, error.to_string()))?;
        Self::of_bytes(&bytes).map_err(|reason| ArchiveError::damaged(path, reason))
    }

    pub(crate) fn of_bytes(bytes: &[u8]) -> Result<Self, String> {
        unpack(KIND, bytes)
    }

    /// What another program may have put behind a right checksum.
    #[cfg(any(test, fuzzing))]
    pub(crate) fn of_payload(payload: &[u8]) -> Result<Self, String> {
        Self::of_bytes(&super::container::framed(KIND, payload))
    }

    /// Makes it the newest one in the folder of its seed; the one that was the newest becomes the one before.
    ///
    /// # Errors
    /// If it cannot be written. The older ones are still there then.
    pub fn write(&self, folder: &Path) -> Result<(), ArchiveError> {
        let [newest, before] = paths(folder);
        let bytes = pack(KIND, self);
        let bytes =
            bytes.map_err(|reason| ArchiveError::write(&newest)(io::Error::other(reason)))?;
        let renamed = match disk::rename(&newest, &before) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
            other => other,
        };
        renamed.map_err(ArchiveError::write(&before))?;
        let written = write_atomically(&newest, |file| file.write_all(&bytes));
        written.map_err(ArchiveError::write(&newest))?;
        disk::sync_folder(folder).map_err(ArchiveError::write(folder))
    }
}

/// A resolved scenario without the keys that say when checkpoints are taken: no result depends on them.
pub fn without_intervals(resolved: &str) -> String {
    let lines = resolved.split_inclusive('\n');
    lines
        .filter(|line| !line.starts_with("checkpoint_every_"))
        .collect()
}

/// Where the checkpoints of a seed lie, the newest first.
pub fn paths(folder: &Path) -> [PathBuf; 2] {
    [names::CHECKPOINT, names::CHECKPOINT_BEFORE].map(|name| folder.join(name))
}

/// Makes a checkpoint of a seed its newest one, in the place of a newer one that is no good.
///
/// # Errors
/// If it cannot be renamed.
pub fn make_newest(path: &Path) -> Result<(), ArchiveError> {
    let newest = path.with_file_name(names::CHECKPOINT);
    disk::rename(path, &newest).map_err(ArchiveError::write(&newest))
}

/// Removes the checkpoints of a seed, which has ended or begins anew.
///
/// # Errors
/// If one is there and cannot be removed.
pub fn remove(folder: &Path) -> Result<(), ArchiveError> {
    for path in paths(folder) {
        match disk::remove_file(&path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            removed => removed.map_err(ArchiveError::write(&path))?,
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checkpoint(steps: u64) -> Checkpoint {
        Checkpoint {
            program: "eigentrail".to_owned(),
            scenario: "name = \"x\"\n".to_owned(),
            seed: 7,
            steps,
            episodes: 2,
            states: 11,
            run: ByteBuf::from([1, 2, 3]),
            observers: BTreeMap::from([("tables".to_owned(), ByteBuf::from([9]))]),
        }
    }

    #[test]
    fn two_are_kept() {
        let folder = tempfile::tempdir().unwrap();
        let [newest, before] = paths(folder.path());
        for steps in 1..4 {
            checkpoint(steps).write(folder.path()).unwrap();
            assert_eq!(Checkpoint::read(&newest).unwrap(), checkpoint(steps));
            if steps > 1 {
                assert_eq!(Checkpoint::read(&before).unwrap(), checkpoint(steps - 1));
            }
        }
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
        // The newest is torn: the one before stays there until the next one is whole.
        fs::write(&newest, "torn").unwrap();
        make_newest(&before).unwrap();
        checkpoint(4).write(folder.path()).unwrap();
        assert_eq!(Checkpoint::read(&newest).unwrap(), checkpoint(4));
        assert_eq!(Checkpoint::read(&before).unwrap(), checkpoint(2));
        make_newest(&newest).unwrap();
        assert_eq!(Checkpoint::read(&newest).unwrap(), checkpoint(4));
        remove(folder.path()).unwrap();
        remove(folder.path()).unwrap();
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
        assert!(Checkpoint::read(&newest).is_err());
    }
}
