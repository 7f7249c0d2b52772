//! The folder of a run, and the rules about folders that exist.
//!
//! ```text
//! runs/four_rooms/2026-11-21T22-05-00Z/
//!   run.json        who ran what when, and how it ended
//!   scenario.toml   the scenario as it was given
//!   resolved.toml   the same with every default and every --set
//!   summary.json    the results; all clock readings stand in its object `timing`
//!   report.html     all of it to look at
//!   .eigentrail.lock   while a program writes there
//!   seed-0000/      episodes.csv refreshes.csv timings.csv events.jsonl potential.npy eigenvectors.npy
//!                   states.csv graph.csv policy.csv snapshots.json events.out.tfevents.0.eigentrail
//! ```

use super::belongings::{Extent, clear};
use super::error::ArchiveError;
use super::folder_kind::{FolderKind, is_comparison, is_run};
use super::lock::{FolderLock, LOCK_FILE};
use super::names::{self, seed_folder_name};
use crate::disk::{self, is_temporary};
use crate::scenario::Loaded;
use crate::time_stamp;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Choice of what to do with a folder that exists.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Existing {
    /// Refuse it.
    #[default]
    Refuse,
    /// Go on in it.
    Resume,
    /// Replace what a run has written there.
    Replace,
}

/// Existing, writable folder of a run or a comparison, with the right to write to it.
#[derive(Clone, Debug)]
pub struct RunFolder {
    path: PathBuf,
    resumed: bool,
    _lock: Arc<FolderLock>,
}

impl RunFolder {
    /// Opens `out`, or `runs/NAME/TIME` if none is given (with [`Existing::Resume`]: the newest of those). Where
    /// there is nothing to resume or to replace, a new run begins.
    ///
    /// # Errors
    /// If it exists and may not be used, if somebody else writes to it, or if it cannot be written to.
    pub fn open(
        out: Option<&Path>,
        loaded: &Loaded,
        existing: Existing,
    ) -> Result<Self, ArchiveError> {
        Self::open_kind(FolderKind::Run, out, loaded, existing)
    }

    /// The same for a folder of any kind.
    ///
    /// # Errors
    /// As [`RunFolder::open`].
    pub fn open_kind(
        kind: FolderKind,
        out: Option<&Path>,
        loaded: &Loaded,
        existing: Existing,
    ) -> Result<Self, ArchiveError> {
        let all = folder_of_runs(Path::new("runs"), &loaded.scenario.name);
        let earlier = || match existing {
            Existing::Resume => newest(kind, &all),
            _ => None,
        };
        let path = match out.map(Path::to_owned).or_else(earlier) {
            Some(path) if existing == Existing::Refuse => create(path)?,
            Some(path) => adopt(kind, path, &loaded.text)?,
            None => create_unused(&all, &(time_stamp::for_file_name() + kind.suffix()))?,
        };
        let lock = FolderLock::take(&path).map_err(not_writable(&path))?;
        let Some(lock) = lock else {
            return Err(ArchiveError::FolderInUse { path });
        };
        let extent = match existing {
            Existing::Replace if kind.is_ours_at(&path) => Extent::Everything,
            _ => Extent::Leftovers,
        };
        clear(&path, kind, extent).map_err(not_writable(&path))?;
        Ok(Self {
            resumed: existing == Existing::Resume && kind.is_at(&path),
            path,
            _lock: Arc::new(lock),
        })
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

/// Where the runs of a scenario lie: `runs/NAME`, or with `-2`, `-3` … behind it while that is a run itself, which
/// `--out runs/NAME` has put there: no run lies within another one.
fn folder_of_runs(runs: &Path, name: &str) -> PathBuf {
    let numbered = (2..).map(|number| runs.join(format!("{name}-{number}")));
    let mut paths = [runs.join(name)].into_iter().chain(numbered);
    let found = paths.find(|path| !is_run(path) && !is_comparison(path));
    found.expect("there is always another number")
}

fn not_writable(path: &Path) -> impl Fn(io::Error) -> ArchiveError {
    move |source| ArchiveError::OutputNotWritable {
        path: path.to_owned(),
        source,
    }
}

/// Makes a folder that was not there, whoever else tries the same.
fn create(path: PathBuf) -> Result<PathBuf, ArchiveError> {
    let path: PathBuf = path.components().collect(); // `new/.` cannot be made, `new` can
    if path.symlink_metadata().is_ok() {
        return Err(ArchiveError::OutputExists { path });
    }
    if let Some(parent) = path.parent() {
        disk::create_folders(parent).map_err(not_writable(&path))?;
    }
    match disk::create_folder(&path) {
        Ok(()) => Ok(path),
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
            Err(ArchiveError::OutputExists { path })
        }
        Err(error) => Err(not_writable(&path)(error)),
    }
}

/// Makes `parent/stamp`, or with `-2`, `-3` … behind it while that exists: two runs may begin in one second.
fn create_unused(parent: &Path, stamp: &str) -> Result<PathBuf, ArchiveError> {
    let numbered = (2..).map(|number| format!("{stamp}-{number}"));
    for name in [stamp.to_owned()].into_iter().chain(numbered) {
        match create(parent.join(name)) {
            Err(ArchiveError::OutputExists { .. }) => {}
            made => return made,
        }
    }
    unreachable!("there is always another number")
}

/// The folder, made if it is not there; a run of ours may go on in it or begin anew.
fn adopt(kind: FolderKind, path: PathBuf, text: &str) -> Result<PathBuf, ArchiveError> {
    let is_new = path.symlink_metadata().is_err();
    if !is_new && !kind.is_ours_at(&path) && !holds_only_a_start(&path, text) {
        let marker = kind.marker();
        return Err(ArchiveError::NotARunFolder { path, marker });
    }
    disk::create_folders(&path).map_err(not_writable(&path))?;
    Ok(path)
}

/// Whether it is a folder with nothing in it but what a run writes before it is known as one: it was killed just then.
/// A lone scenario counts if it is the present one, whose `text` will be written there again; else it is somebody's own.
fn holds_only_a_start(path: &Path, text: &str) -> bool {
    let Ok(entries) = fs::read_dir(path) else {
        return false;
    };
    let is_ours = |name: &str| match name {
        LOCK_FILE => true,
        names::RESOLVED => path.join(names::SCENARIO).is_file(),
        names::SCENARIO => {
            path.join(names::RESOLVED).is_file()
                || fs::read(path.join(name)).is_ok_and(|there| there == text.as_bytes())
        }
        _ => is_temporary(name),
    };
    entries
        .flatten()
        .all(|entry| entry.file_name().to_str().is_some_and(is_ours))
}

/// What was begun last below `all`: names sort by time.
fn newest(kind: FolderKind, all: &Path) -> Option<PathBuf> {
    let entries = fs::read_dir(all).into_iter().flatten().flatten();
    entries
        .map(|entry| entry.path())
        .filter(|path| kind.is_at(path))
        .max()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::Scenario;

    const TEXT: &str = "name = \"x\"\n";

    fn open(path: &Path, existing: Existing) -> Result<RunFolder, ArchiveError> {
        let loaded = Scenario::parse(Path::new("x.toml"), TEXT.to_owned(), &[]);
        RunFolder::open(Some(path), &loaded.unwrap(), existing)
    }

    #[test]
    fn an_existing_run_needs_a_word() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run");
        assert!(!open(&path, Existing::Resume).unwrap().is_resumed());
        fs::write(path.join("run.json"), r#"{"program": "eigentrail 0.1.0"}"#).unwrap();
        assert!(matches!(
            open(&path, Existing::Refuse),
            Err(ArchiveError::OutputExists { .. })
        ));
        assert!(open(&path, Existing::Resume).unwrap().is_resumed());
        fs::write(path.join("summary.json"), "{}").unwrap();
        assert!(!open(&path, Existing::Replace).unwrap().is_resumed());
        assert!(!path.join("summary.json").exists());
    }

    #[test]
    fn force_spares_what_is_no_run() {
        let theirs = [
            ("thesis.tex", "years of work"),
            ("run.json", "{}"),
            ("run.json", r#"{"program": "another"}"#),
            ("scenario.toml", "name = \"another\"\n"),
            ("resolved.toml", TEXT),
        ];
        for (name, text) in theirs {
            for existing in [Existing::Replace, Existing::Resume] {
                let folder = tempfile::tempdir().unwrap();
                fs::write(folder.path().join(name), text).unwrap();
                assert!(matches!(
                    open(folder.path(), existing),
                    Err(ArchiveError::NotARunFolder { .. })
                ));
                let left = fs::read_to_string(folder.path().join(name));
                assert_eq!(left.unwrap(), text);
                assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
            }
        }
    }

    #[test]
    fn what_a_kill_left_at_the_start_is_no_obstacle() {
        let starts: [&[&str]; 5] = [
            &[],
            &[LOCK_FILE],
            &[LOCK_FILE, ".eigentrail-Ab12Cd.tmp"],
            &["scenario.toml"],
            &["scenario.toml", "resolved.toml", ".eigentrail-Ab12Cd.tmp"],
        ];
        for names in starts {
            for existing in [Existing::Replace, Existing::Resume] {
                let folder = tempfile::tempdir().unwrap();
                for name in names {
                    fs::write(folder.path().join(name), TEXT).unwrap();
                }
                let opened = open(folder.path(), existing).unwrap();
                assert!(!opened.is_resumed(), "{names:?}");
                drop(opened);
                let left = fs::read_dir(folder.path()).unwrap().flatten();
                let mut left = left.map(|entry| entry.file_name());
                assert!(left.all(|name| name.to_str().unwrap().ends_with(".toml")));
            }
        }
    }

    #[test]
    fn a_folder_has_one_writer() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run");
        let first = open(&path, Existing::Refuse).unwrap();
        for existing in [Existing::Resume, Existing::Replace] {
            let error = open(&path, existing).unwrap_err();
            assert!(matches!(error, ArchiveError::FolderInUse { .. }));
            assert!(error.is_bad_input());
        }
        drop(first);
        assert!(open(&path, Existing::Resume).is_ok());
    }

    #[test]
    fn a_path_below_a_file_cannot_be_written() {
        let file = tempfile::NamedTempFile::new().unwrap();
        for existing in [Existing::Refuse, Existing::Resume, Existing::Replace] {
            let error = open(&file.path().join("run"), existing).unwrap_err();
            assert!(matches!(error, ArchiveError::OutputNotWritable { .. }));
            assert!(error.is_bad_input());
        }
    }

    #[test]
    fn no_run_lies_within_another_one() {
        let folder = tempfile::tempdir().unwrap();
        let runs = folder.path();
        assert_eq!(folder_of_runs(runs, "x"), runs.join("x"));
        for (name, marker) in [("x", "run.json"), ("x-2", FolderKind::Comparison.marker())] {
            fs::create_dir(runs.join(name)).unwrap();
            fs::write(runs.join(name).join(marker), "{}").unwrap();
        }
        assert_eq!(folder_of_runs(runs, "x"), runs.join("x-3"));
    }

    #[test]
    fn runs_of_one_second_get_folders_of_their_own() {
        let folder = tempfile::tempdir().unwrap();
        let parent = folder.path().join("runs");
        let mut made: Vec<PathBuf> = std::thread::scope(|scope| {
            let create = || create_unused(&parent, "t").unwrap();
            let threads: Vec<_> = (0..8).map(|_| scope.spawn(create)).collect();
            threads.into_iter().map(|t| t.join().unwrap()).collect()
        });
        made.sort();
        made.dedup();
        assert_eq!(made.len(), 8);
        assert_eq!(made[..2], [parent.join("t"), parent.join("t-2")]);
    }
}
