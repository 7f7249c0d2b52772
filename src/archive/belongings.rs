//! Files that a run or a comparison leaves in its folder, by name: the rest belongs to somebody else.

use super::folder_kind::FolderKind;
use super::names::{self, seed_folder_name};
use super::shard::is_shard;
use crate::disk::{self, is_temporary};
use std::fs;
use std::io;
use std::path::Path;

/// A folder of ours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Level {
    Run,
    Comparison,
    /// `arms` or `tuning` in a comparison.
    Arms,
    Arm,
    Seed,
    Sweep,
    /// `points` in a sweep.
    Points,
    Point,
}

impl Level {
    /// Whether we write a file of this name. Those that every run replaces before anything else stay: without them the
    /// folder would not be known as ours, should the program be killed just then.
    fn has_file(self, name: &str) -> bool {
        match self {
            Level::Run => [names::RESOLVED, names::SUMMARY, names::PAGE].contains(&name),
            Level::Comparison => [
                names::COMPARISON,
                names::TRIALS,
                names::TIMINGS,
                names::PAGE,
            ]
            .contains(&name),
            Level::Sweep => [
                names::SUMMARY,
                names::SWEEP_TRIALS,
                names::SWEEP_ERRORS,
                names::TIMINGS,
            ]
            .contains(&name),
            Level::Arms | Level::Points => false,
            Level::Point => name == names::RESOLVED || is_shard(name),
            Level::Arm => {
                name == names::RESOLVED || name.strip_suffix(".json").is_some_and(is_seed)
            }
            Level::Seed => names::SEED_FILES.contains(&name),
        }
    }

    /// What a folder of this name in it is, if it is ours.
    fn folder(self, name: &str) -> Option<Level> {
        match self {
            Level::Run | Level::Arm if is_seed(name) => Some(Level::Seed),
            Level::Comparison if [names::ARMS_FOLDER, names::TUNING_FOLDER].contains(&name) => {
                Some(Level::Arms)
            }
            Level::Arms => Some(Level::Arm),
            Level::Sweep if name == names::POINTS_FOLDER => Some(Level::Points),
            Level::Points => Some(Level::Point),
            _ => None,
        }
    }
}

/// `seed-0007`
fn is_seed(name: &str) -> bool {
    let number = name.strip_prefix("seed-").and_then(|n| n.parse().ok());
    number.is_some_and(|seed| name == seed_folder_name(seed))
}

/// How much is to go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Extent {
    /// Temporary files that a kill has left.
    Leftovers,
    /// Everything that a run, a comparison or a sweep writes.
    Everything,
}

/// Removes what is ours from a folder. What is not stays, with the folders around it; links go, not what they lead to.
pub(super) fn clear(folder: &Path, kind: FolderKind, extent: Extent) -> io::Result<()> {
    let level = match kind {
        FolderKind::Run => Level::Run,
        FolderKind::Comparison => Level::Comparison,
        FolderKind::Sweep => Level::Sweep,
    };
    clear_level(folder, level, extent)
}

fn clear_level(folder: &Path, level: Level, extent: Extent) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let (name, path) = (entry.file_name(), entry.path());
        let Some(name) = name.to_str() else { continue };
        let inner = level.folder(name);
        if entry.file_type()?.is_dir() {
            if let Some(inner) = inner {
                clear_level(&path, inner, extent)?;
                if extent == Extent::Everything {
                    remove_empty(&path)?;
                }
            }
        } else if is_temporary(name)
            || extent == Extent::Everything && (level.has_file(name) || is_link(&entry, inner))
        {
            disk::remove_file(&path)?;
        }
    }
    Ok(())
}

/// Whether a link stands where a run would make a folder, and would write behind it.
fn is_link(entry: &fs::DirEntry, inner: Option<Level>) -> bool {
    inner.is_some() && entry.file_type().is_ok_and(|kind| kind.is_symlink())
}

/// Removes a folder, unless there is something in it.
fn remove_empty(folder: &Path) -> io::Result<()> {
    match disk::remove_folder(folder) {
        Err(error) if error.kind() != io::ErrorKind::DirectoryNotEmpty => Err(error),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Files of the folder and below it, sorted; links are files.
    fn files(folder: &Path) -> Vec<String> {
        fn walk(folder: &Path, root: &Path, found: &mut Vec<String>) {
            for entry in fs::read_dir(folder).unwrap().map(Result::unwrap) {
                match entry.file_type().unwrap().is_dir() {
                    true => walk(&entry.path(), root, found),
                    false => {
                        let path = entry.path();
                        let name = path.strip_prefix(root).unwrap();
                        found.push(name.to_str().unwrap().to_owned());
                    }
                }
            }
        }
        let mut found = Vec::new();
        walk(folder, folder, &mut found);
        found.sort();
        found
    }

    fn folder_with(files: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for file in files {
            let path = folder.path().join(file);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, "x").unwrap();
        }
        folder
    }

    #[test]
    fn others_keep_what_is_theirs() {
        let theirs = [
            "notes.txt",
            "seed-0000/mine.txt",
            "seed-12/episodes.csv",
            "seed-00012/episodes.csv",
            "seeds/episodes.csv",
            ".tmp-of-mine",
            "arms/x/resolved.toml",
        ];
        let ours = [
            "summary.json",
            "report.html",
            "resolved.toml",
            ".eigentrail-a1B2c3.tmp",
            "seed-0000/episodes.csv",
            "seed-0000/.eigentrail-a1B2c3.tmp",
            "seed-0000/events.out.tfevents.0.eigentrail",
            "seed-18446744073709551615/potential.npy",
        ];
        let folder = folder_with(&[&theirs[..], &ours[..]].concat());
        let path = folder.path();
        clear(path, FolderKind::Run, Extent::Leftovers).unwrap();
        assert_eq!(files(path).len(), theirs.len() + ours.len() - 2);
        clear(path, FolderKind::Run, Extent::Everything).unwrap();
        let mut left = theirs.map(str::to_owned);
        left.sort();
        assert_eq!(files(path), left);
        assert!(!path.join("seed-18446744073709551615").exists());
    }

    #[test]
    fn comparisons_have_arms() {
        let theirs = [
            "arms/gcn/plot.py",
            "arms/list.txt",
            "run.json",
            "summary.json",
        ];
        let ours = [
            "compare.json",
            "arms/gcn/resolved.toml",
            "arms/gcn/seed-0001.json",
            "arms/heat/seed-0000/graph.csv",
            "tuning/sparse-critic-0.4-actor-0.1/seed-1000000.json",
        ];
        let folder = folder_with(&[&theirs[..], &ours[..]].concat());
        let path = folder.path();
        clear(path, FolderKind::Comparison, Extent::Everything).unwrap();
        assert_eq!(files(path), theirs);
        assert!(!path.join("tuning").exists());
    }

    #[test]
    fn sweeps_have_points() {
        let theirs = ["compare.json", "points/9a/plot.py"];
        let ours = [
            "summary.json",
            "sweep.csv",
            "errors.json",
            "timings.csv",
            "points/9a/resolved.toml",
            "points/9a/seed-0001.json",
            "points/7b/seeds-0002-0003.json",
        ];
        let folder = folder_with(&[&theirs[..], &ours[..]].concat());
        let path = folder.path();
        clear(path, FolderKind::Sweep, Extent::Everything).unwrap();
        assert_eq!(files(path), theirs);
        assert!(!path.join("points/7b").exists());
    }

    #[cfg(unix)]
    #[test]
    fn nothing_behind_a_link_is_touched() {
        use std::os::unix::fs::symlink;
        let elsewhere = folder_with(&["episodes.csv", ".eigentrail-a1B2c3.tmp"]);
        let folder = folder_with(&["seed-0001/graph.csv"]);
        let path = folder.path();
        symlink(elsewhere.path(), path.join("seed-0000")).unwrap();
        symlink(elsewhere.path(), path.join("data")).unwrap();
        let target = elsewhere.path().join("episodes.csv");
        symlink(target, path.join("seed-0001/episodes.csv")).unwrap();
        clear(path, FolderKind::Run, Extent::Leftovers).unwrap();
        clear(path, FolderKind::Run, Extent::Everything).unwrap();
        assert_eq!(files(path), ["data"]);
        assert_eq!(files(elsewhere.path()).len(), 2);
    }
}
