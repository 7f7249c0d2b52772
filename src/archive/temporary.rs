//! Files and folders that must not outlive the program, however it ends.
//!
//! Those of this process are known by name: a program that is told to end at once removes them first. What a kill leaves
//! behind is known by its name, too ([`is_temporary`]).

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use tempfile::{NamedTempFile, TempDir};

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
pub(super) fn is_temporary(name: &str) -> bool {
    name.starts_with(PREFIX) && name.ends_with(SUFFIX)
}

/// Removes every temporary file and folder of this process, and lets no thread make another: for programs that end now.
pub fn remove_temporaries() {
    let all = present();
    for path in all.iter() {
        if fs::remove_file(path).is_err() {
            let gone = |_: &usize| fs::remove_dir_all(path).is_ok() || !path.exists();
            (0..ATTEMPTS).find(gone);
        }
    }
    std::mem::forget(all);
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
pub(super) struct Temporary {
    file: NamedTempFile,
    _known: Known,
}

impl Temporary {
    /// With the permissions that `File::create` gives; by default only its owner could read it.
    pub fn create(folder: &Path) -> io::Result<Self> {
        let mut builder = builder();
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            builder.permissions(fs::Permissions::from_mode(0o666)); // the umask still applies
        }
        let mut all = present();
        let file = builder.tempfile_in(folder).map_err(plain)?;
        let known = Known::add(&mut all, file.path());
        Ok(Self {
            file,
            _known: known,
        })
    }

    pub fn file(&mut self) -> &mut File {
        self.file.as_file_mut()
    }

    /// Gives it its final name.
    pub fn persist(self, path: &Path) -> io::Result<()> {
        self.file.persist(path)?;
        Ok(())
    }
}

/// A folder, where the system keeps such, that goes with everything in it.
#[derive(Debug)]
pub struct TemporaryFolder {
    folder: TempDir,
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
