//! Files and folders that must not outlive the program, however it ends, and the files that come of them whole.
//!
//! Those of this process are known by name: a program that is told to end at once removes them first. What a kill leaves
//! behind is known by its name, too ([`is_temporary`]).

use super::{DiskFile, remove_file, remove_folder_all, rename};
use std::collections::BTreeSet;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

const PREFIX: &str = ".eigentrail-";
const SUFFIX: &str = ".tmp";
/// How often a folder is tried to be removed in which other threads may still make files.
const ATTEMPTS: usize = 1000;

static PRESENT: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// A change of the set and of the disk is one step for whoever has this.
fn present() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    PRESENT.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Whether a file of this name was meant to be renamed or removed soon.
pub(crate) fn is_temporary(name: &str) -> bool {
    name.starts_with(PREFIX) && name.ends_with(SUFFIX)
}

/// Removes every temporary file and folder of this process, and lets no thread make another: for programs that end now.
pub fn remove_temporaries() {
    let all = present();
    for path in all.iter() {
        if remove_file(path).is_err() {
            let gone = |_: &usize| remove_folder_all(path).is_ok() || !path.exists();
            (0..ATTEMPTS).find(gone);
        }
    }
    std::mem::forget(all);
}

/// Replaces `path` by what `fill` writes, or leaves it as it was. What is there and no plain file, such as a pipe or
/// `/dev/stdout`, is written to as it is.
pub fn write_atomically(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<&mut DiskFile>) -> io::Result<()>,
) -> io::Result<()> {
    if is_special(path) {
        return write_through(&mut DiskFile::create(path)?, fill);
    }
    let mut file = Temporary::create(folder_of(path))?;
    write_through(&mut file.file, fill)?;
    file.file.sync()?;
    file.persist(path)
}

fn write_through(
    file: &mut DiskFile,
    fill: impl FnOnce(&mut BufWriter<&mut DiskFile>) -> io::Result<()>,
) -> io::Result<()> {
    let mut writer = BufWriter::new(file);
    fill(&mut writer)?;
    writer.flush()
}

/// Finds out whether [`write_atomically`] may succeed at `path`.
///
/// # Errors
/// Why it will not.
pub fn try_out(path: &Path) -> io::Result<()> {
    match is_special(path) {
        true => Ok(()),
        false => tempfile::tempfile_in(folder_of(path)).map(drop),
    }
}

/// Whether something is there that cannot be replaced by a file.
fn is_special(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|there| !there.is_file() && !there.is_dir())
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

fn builder() -> tempfile::Builder<'static, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX).suffix(SUFFIX);
    builder
}

/// A name in the set; it is forgotten after what it names is gone.
#[derive(Debug)]
struct Known(PathBuf);

impl Known {
    fn add(all: &mut BTreeSet<PathBuf>, path: &Path) -> Self {
        all.insert(path.to_owned());
        Self(path.to_owned())
    }
}

impl Drop for Known {
    fn drop(&mut self) {
        present().remove(&self.0);
    }
}

/// A file that takes its final name when it is whole, or goes.
struct Temporary {
    file: DiskFile,
    /// None when it has its final name.
    path: Option<PathBuf>,
    _known: Known,
}

impl Temporary {
    fn create(folder: &Path) -> io::Result<Self> {
        let mut all = present();
        let made = builder()
            .make_in(folder, DiskFile::create_new)
            .map_err(plain)?;
        let (file, path) = made.keep().map_err(|error| error.error)?;
        let known = Known::add(&mut all, &path);
        Ok(Self {
            file,
            path: Some(path),
            _known: known,
        })
    }

    /// Gives it its final name.
    fn persist(mut self, path: &Path) -> io::Result<()> {
        if let Some(from) = &self.path {
            rename(from, path)?;
        }
        self.path = None;
        Ok(())
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if let Some(path) = &self.path {
            let _ = remove_file(path); // what cannot be removed is known by its name
        }
    }
}

/// A folder, where the system keeps such, that goes with everything in it.
#[derive(Debug)]
pub struct TemporaryFolder {
    folder: tempfile::TempDir,
    _known: Known,
}

impl TemporaryFolder {
    /// Makes one.
    ///
    /// # Errors
    /// Why that is impossible.
    pub fn create() -> io::Result<Self> {
        let mut all = present();
        let folder = builder().tempdir().map_err(plain)?;
        let known = Known::add(&mut all, folder.path());
        Ok(Self {
            folder,
            _known: known,
        })
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }
}

/// tempfile adds " at path" and a name that says nothing to whoever named another file.
fn plain(error: io::Error) -> io::Error {
    let text = error.to_string();
    let cause = text
        .rsplit_once(" at path ")
        .map_or(&*text, |(cause, _)| cause);
    io::Error::new(error.kind(), cause)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_the_old_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.txt");
        std::fs::write(&path, "old").unwrap();
        let result = write_atomically(&path, |file| {
            file.write_all(b"new, but")?;
            Err(io::Error::other("the disk is full"))
        });
        assert!(result.is_err());
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
