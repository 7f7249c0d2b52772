//! One writer for a folder.
//!
//! The file `.eigentrail.lock` is there while a program writes to the folder, and locked. The lock goes with the program,
//! however that ends; a file that stays behind without one means nothing.

use crate::disk::{self, DiskFile};
use std::fs::TryLockError;
use std::io;
use std::path::{Path, PathBuf};
use tracing::warn;

/// The file.
pub(super) const LOCK_FILE: &str = ".eigentrail.lock";

/// The right to write to a folder; dropping it gives it up.
#[derive(Debug)]
pub struct FolderLock {
    path: PathBuf,
    _file: DiskFile,
}

impl FolderLock {
    /// Takes it; none if another has it. On a file system without locks it is taken with a warning.
    ///
    /// # Errors
    /// If the file cannot be made.
    pub fn take(folder: &Path) -> io::Result<Option<Self>> {
        let path = folder.join(LOCK_FILE);
        loop {
            let file = DiskFile::open_or_create(&path)?;
            match file.try_lock() {
                // Else whoever had it has just removed it.
                Ok(()) if !is_at(&file, &path) => continue,
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => return Ok(None),
                Err(TryLockError::Error(error)) => {
                    let path = path.display();
                    warn!("{path}: cannot be locked ({error}): let no second run write here");
                }
            }
            return Ok(Some(Self { path, _file: file }));
        }
    }
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        let _ = disk::remove_file(&self.path); // without a lock it means nothing
    }
}

/// Whether the open file is the one at `path`.
#[cfg(unix)]
fn is_at(file: &DiskFile, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let place = |m: std::fs::Metadata| (m.dev(), m.ino());
    let (open, there) = (
        file.metadata().map(place),
        std::fs::metadata(path).map(place),
    );
    matches!((open, there), (Ok(open), Ok(there)) if open == there)
}

/// Elsewhere an open file cannot be removed.
#[cfg(not(unix))]
fn is_at(_: &DiskFile, _: &Path) -> bool {
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn one_at_a_time() {
        let folder = tempfile::tempdir().unwrap();
        let first = FolderLock::take(folder.path()).unwrap();
        assert!(first.is_some());
        assert!(FolderLock::take(folder.path()).unwrap().is_none());
        drop(first);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
        fs::write(folder.path().join(LOCK_FILE), "").unwrap(); // left by a kill
        assert!(FolderLock::take(folder.path()).unwrap().is_some());
    }

    #[test]
    fn never_two_holders_however_fast_they_change() {
        use std::sync::atomic::{AtomicUsize, Ordering};
        let folder = tempfile::tempdir().unwrap();
        let (holders, turns) = (AtomicUsize::new(0), AtomicUsize::new(0));
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    while turns.load(Ordering::SeqCst) < 2000 {
                        if let Some(lock) = FolderLock::take(folder.path()).unwrap() {
                            assert_eq!(holders.fetch_add(1, Ordering::SeqCst), 0);
                            turns.fetch_add(1, Ordering::SeqCst);
                            holders.fetch_sub(1, Ordering::SeqCst);
                            drop(lock);
                        }
                    }
                });
            }
        });
    }
}
