//! The folder of a run, and the rules about folders that exist.
//!
//! ```text
//! runs/four-rooms/2026-11-21T22-05-00Z/
//!   run.json        who ran what when, and how it ended
//!   scenario.toml   the scenario as it was given
//!   resolved.toml   the same with every default and every --set
//!   summary.json    the results; all clock readings stand in its object `timing`
//!   report.html     all of it to look at
//!   seed-0000/      episodes.csv refreshes.csv timings.csv events.jsonl potential.npy eigenvectors.npy
//!                   states.csv graph.csv policy.csv snapshots.json events.out.tfevents.0.eigentrail
//! ```

use super::error::RunnerError;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// What to do with a folder that exists.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Existing {
    /// Refuse it.
    #[default]
    Refuse,
    /// Go on in it.
    Resume,
    /// Replace it.
    Replace,
}

/// What a folder holds, told by the file that is written to it first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FolderKind {
    /// Seeds of one scenario.
    #[default]
    Run,
    /// Arms × seeds of one scenario, in `runs/NAME/TIME-compare`.
    Comparison,
}

impl FolderKind {
    /// The file that tells.
    pub fn marker(self) -> &'static str {
        match self {
            FolderKind::Run => "run.json",
            FolderKind::Comparison => "arms.json",
        }
    }

    fn suffix(self) -> &'static str {
        match self {
            FolderKind::Run => "",
            FolderKind::Comparison => "-compare",
        }
    }

    /// Whether such a thing was written to `path`.
    fn is_at(self, path: &Path) -> bool {
        path.join(self.marker()).is_file()
    }
}

/// An existing, writable run folder.
#[derive(Clone, Debug)]
pub struct RunFolder {
    path: PathBuf,
    resumed: bool,
}

impl RunFolder {
    /// Opens `out`, or `runs/NAME/TIME` if none is given (with [`Existing::Resume`]: the newest of those). Where
    /// there is nothing to resume or to replace, a new run begins.
    ///
    /// # Errors
    /// If it exists and may not be used, or cannot be written to.
    pub fn open(out: Option<&Path>, name: &str, existing: Existing) -> Result<Self, RunnerError> {
        Self::open_kind(FolderKind::Run, out, name, existing)
    }

    /// The same for a folder of any kind.
    ///
    /// # Errors
    /// As [`RunFolder::open`].
    pub fn open_kind(
        kind: FolderKind,
        out: Option<&Path>,
        name: &str,
        existing: Existing,
    ) -> Result<Self, RunnerError> {
        let all = Path::new("runs").join(name);
        let path = match out {
            Some(path) => path.to_owned(),
            None => match existing {
                Existing::Resume => newest(kind, &all),
                _ => None,
            }
            .unwrap_or_else(|| unused(&all, &(time_stamp() + kind.suffix()))),
        };
        match existing {
            Existing::Refuse if path.symlink_metadata().is_ok() => {
                return Err(RunnerError::OutputExists { path });
            }
            Existing::Refuse => {}
            _ if kind.is_at(&path) || is_free(&path) => {}
            _ => {
                let marker = kind.marker();
                return Err(RunnerError::NotARunFolder { path, marker });
            }
        }
        if existing == Existing::Replace && kind.is_at(&path) {
            remove(&path)?;
        }
        let resumed = kind.is_at(&path);
        try_out(&path).map_err(|source| RunnerError::OutputNotWritable {
            path: path.clone(),
            source,
        })?;
        Ok(Self { path, resumed })
    }

    /// The folder itself.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether it held a run before.
    pub fn is_resumed(&self) -> bool {
        self.resumed
    }

    /// A file of the run.
    pub fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// The folder of a seed.
    pub fn seed(&self, seed: u64) -> PathBuf {
        self.path.join(seed_folder_name(seed))
    }
}

/// `seed-0007`.
pub fn seed_folder_name(seed: u64) -> String {
    format!("seed-{seed:04}")
}

/// Whether a run was written to `path`.
pub fn is_run(path: &Path) -> bool {
    FolderKind::Run.is_at(path)
}

/// Whether `path` holds a comparison, or began to.
pub fn is_comparison(path: &Path) -> bool {
    FolderKind::Comparison.is_at(path)
}

/// The present second in UTC, fit for a folder name.
fn time_stamp() -> String {
    jiff::Timestamp::now()
        .strftime("%Y-%m-%dT%H-%M-%SZ")
        .to_string()
}

/// `parent/stamp`, or with `-2`, `-3` … behind it while that exists: two runs may begin in one second.
fn unused(parent: &Path, stamp: &str) -> PathBuf {
    let mut path = parent.join(stamp);
    let mut number = 2;
    while path.exists() {
        path = parent.join(format!("{stamp}-{number}"));
        number += 1;
    }
    path
}

/// What was begun last below `all`: names sort by time.
fn newest(kind: FolderKind, all: &Path) -> Option<PathBuf> {
    let entries = fs::read_dir(all).into_iter().flatten().flatten();
    entries
        .map(|entry| entry.path())
        .filter(|path| kind.is_at(path))
        .max()
}

/// Nothing there, or an empty folder.
fn is_free(path: &Path) -> bool {
    match fs::read_dir(path) {
        Ok(mut entries) => entries.next().is_none(),
        Err(_) => path.symlink_metadata().is_err(),
    }
}

fn remove(path: &Path) -> Result<(), RunnerError> {
    fs::remove_dir_all(path).map_err(|source| RunnerError::OutputNotWritable {
        path: path.to_owned(),
        source,
    })
}

/// Creates the folder and, for a moment, a file in it.
fn try_out(path: &Path) -> io::Result<()> {
    fs::create_dir_all(path)?;
    tempfile::tempfile_in(path).map(drop)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn open(path: &Path, existing: Existing) -> Result<RunFolder, RunnerError> {
        RunFolder::open(Some(path), "x", existing)
    }

    #[test]
    fn an_existing_run_needs_a_word() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run");
        assert!(!open(&path, Existing::Resume).unwrap().is_resumed());
        fs::write(path.join("run.json"), "{}").unwrap();
        assert!(matches!(
            open(&path, Existing::Refuse),
            Err(RunnerError::OutputExists { .. })
        ));
        assert!(open(&path, Existing::Resume).unwrap().is_resumed());
        assert!(!open(&path, Existing::Replace).unwrap().is_resumed());
        assert!(!is_run(&path));
    }

    #[test]
    fn force_spares_what_is_no_run() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("thesis.tex"), "years of work").unwrap();
        assert!(matches!(
            open(folder.path(), Existing::Replace),
            Err(RunnerError::NotARunFolder { .. })
        ));
        assert!(folder.path().join("thesis.tex").exists());
    }

    #[test]
    fn a_path_below_a_file_cannot_be_written() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let error = open(&file.path().join("run"), Existing::Refuse).unwrap_err();
        assert!(matches!(error, RunnerError::OutputNotWritable { .. }));
        assert!(error.is_bad_input());
    }

    #[test]
    fn runs_of_one_second_get_folders_of_their_own() {
        let folder = tempfile::tempdir().unwrap();
        let first = unused(folder.path(), "t");
        fs::create_dir(&first).unwrap();
        assert_eq!(unused(folder.path(), "t"), folder.path().join("t-2"));
    }
}
