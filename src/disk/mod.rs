//! Everything that this library changes on the disk.
//!
//! Files and folders are made, written, renamed and removed here and nowhere else (`clippy.toml` sees to it), so that tests can let
//! each of these operations fail, or be the last one of a program that is killed. Whoever only reads has no need of this.

#![allow(
    clippy::disallowed_methods,
    reason = "they are called here so that they are called nowhere else"
)]

#[cfg(test)]
pub(crate) mod faults;
mod temporary;

pub(crate) use temporary::is_temporary;
pub use temporary::{TemporaryFolder, remove_temporaries, try_out, write_atomically};

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::Path;

/// Kind of change.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) enum Operation {
    Create,
    Open,
    /// What else writes need not be told.
    #[cfg(test)]
    Write,
    SetLength,
    Sync,
    Rename,
    Remove,
    MakeFolder,
    SyncFolder,
}

/// Nothing happens but in tests.
#[cfg(not(test))]
mod faults {
    use super::{Operation, Path, io};

    #[inline(always)]
    pub fn before(_: Operation, _: &Path) -> io::Result<()> {
        Ok(())
    }

    #[inline(always)]
    pub fn before_write(_: &Path, length: usize) -> io::Result<usize> {
        Ok(length)
    }
}

/// Open file that is written to.
#[derive(Debug)]
pub struct DiskFile {
    file: File,
    #[cfg(test)]
    path: std::path::PathBuf,
}

impl DiskFile {
    /// An empty one, whatever was there.
    pub(crate) fn create(path: &Path) -> io::Result<Self> {
        faults::before(Operation::Create, path)?;
        Ok(Self::of(File::create(path)?, path))
    }

    /// An empty one where none was.
    pub(crate) fn create_new(path: &Path) -> io::Result<Self> {
        faults::before(Operation::Create, path)?;
        Ok(Self::of(File::create_new(path)?, path))
    }

    /// One that is there.
    pub(crate) fn open(path: &Path) -> io::Result<Self> {
        faults::before(Operation::Open, path)?;
        Ok(Self::of(File::options().write(true).open(path)?, path))
    }

    /// One that is there, or else an empty one.
    pub(crate) fn open_or_create(path: &Path) -> io::Result<Self> {
        faults::before(Operation::Create, path)?;
        let mut options = OpenOptions::new();
        let file = options
            .write(true)
            .create(true)
            .truncate(false)
            .open(path)?;
        Ok(Self::of(file, path))
    }

    fn of(file: File, _path: &Path) -> Self {
        Self {
            file,
            #[cfg(test)]
            path: _path.to_owned(),
        }
    }

    #[cfg(test)]
    fn path(&self) -> &Path {
        &self.path
    }

    #[cfg(not(test))]
    fn path(&self) -> &'static Path {
        Path::new("")
    }

    /// Bytes in it.
    pub(crate) fn length(&self) -> io::Result<u64> {
        Ok(self.file.metadata()?.len())
    }

    /// Cuts it off, or fills it up with zeros; what is written next goes behind its end.
    pub(crate) fn set_length(&mut self, length: u64) -> io::Result<()> {
        faults::before(Operation::SetLength, self.path())?;
        self.file.set_len(length)?;
        self.file.seek(SeekFrom::End(0))?;
        Ok(())
    }

    /// Waits until its bytes are on the disk.
    pub(crate) fn sync(&mut self) -> io::Result<()> {
        faults::before(Operation::Sync, self.path())?;
        self.file.sync_data()
    }

    /// Locks it for this program, until it is closed.
    pub(crate) fn try_lock(&self) -> Result<(), TryLockError> {
        self.file.try_lock()
    }

    /// What the system knows of it.
    #[cfg(unix)]
    pub(crate) fn metadata(&self) -> io::Result<fs::Metadata> {
        self.file.metadata()
    }
}

impl Write for DiskFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let length = faults::before_write(self.path(), bytes.len())?;
        self.file.write(&bytes[..length])
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Seek for DiskFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file.seek(to)
    }
}

/// Makes a folder that was not there.
pub(crate) fn create_folder(path: &Path) -> io::Result<()> {
    faults::before(Operation::MakeFolder, path)?;
    fs::create_dir(path)
}

/// Makes a folder in one that is there, unless it is there itself. A run whose folder somebody has removed is to notice it: what
/// it made anew would lack what it wrote before.
pub(crate) fn create_subfolder(path: &Path) -> io::Result<()> {
    match path.is_dir() {
        true => Ok(()),
        false => create_folder(path),
    }
}

/// Makes a folder and those around it, unless they are there.
pub fn create_folders(path: &Path) -> io::Result<()> {
    if path.is_dir() {
        return Ok(());
    }
    faults::before(Operation::MakeFolder, path)?;
    fs::create_dir_all(path)
}

/// Gives a file another name, in the place of what had it.
pub(crate) fn rename(from: &Path, to: &Path) -> io::Result<()> {
    faults::before(Operation::Rename, to)?;
    fs::rename(from, to)?;
    #[cfg(test)]
    faults::renamed(from, to);
    Ok(())
}

/// Removes a file.
pub(crate) fn remove_file(path: &Path) -> io::Result<()> {
    faults::before(Operation::Remove, path)?;
    fs::remove_file(path)
}

/// Removes an empty folder.
pub(crate) fn remove_folder(path: &Path) -> io::Result<()> {
    faults::before(Operation::Remove, path)?;
    fs::remove_dir(path)
}

/// Removes a folder with all that is in it.
pub(crate) fn remove_folder_all(path: &Path) -> io::Result<()> {
    faults::before(Operation::Remove, path)?;
    fs::remove_dir_all(path)
}

/// Waits until the names in a folder are on the disk.
pub(crate) fn sync_folder(path: &Path) -> io::Result<()> {
    faults::before(Operation::SyncFolder, path)?;
    #[cfg(unix)]
    File::open(path)?.sync_all()?;
    Ok(())
}
