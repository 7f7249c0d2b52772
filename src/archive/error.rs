//! Errors of a run's folder and its files.

use std::path::{Path, PathBuf};

/// Reason why a folder or a file of a run or a comparison cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ArchiveError {
    /// The run folder has something in it already.
    #[error(
        "{path}: the output folder exists; --resume goes on in it, --force replaces it, --out names another",
        path = path.display()
    )]
    OutputExists {
        /// The folder.
        path: PathBuf,
    },
    /// What is to be resumed or replaced is no run, so touching it might destroy something else.
    #[error(
        "{path}: not a run folder (it has no {marker} of this program), so it is left alone; name another with --out",
        path = path.display()
    )]
    NotARunFolder {
        /// The folder.
        path: PathBuf,
        /// The file that it would have.
        marker: &'static str,
    },
    /// Another program writes there at this moment.
    #[error(
        "{path}: another run is writing to this folder; wait for its end before you go on in it, or name another with --out",
        path = path.display()
    )]
    FolderInUse {
        /// The folder.
        path: PathBuf,
    },
    /// The run folder cannot be written to.
    #[error("{path}: cannot write to the output folder: {source}", path = path.display())]
    OutputNotWritable {
        /// The folder.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// The run folder was made by another scenario.
    #[error(
        "{path}: cannot resume: the scenario differs from the one that began this run, first in the line `{line}`",
        path = path.display()
    )]
    ResumeMismatch {
        /// The resolved scenario in the run folder.
        path: PathBuf,
        /// The first line of the present scenario that is not the same there.
        line: String,
    },
    /// A file of the run folder does not say what it should.
    #[error("{path}: {message}", path = path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        message: String,
    },
    /// Writing failed during the run.
    #[error("{path}: cannot write: {source}", path = path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
}

impl ArchiveError {
    /// Writing to `path` failed: for `map_err`.
    pub(crate) fn write(path: &Path) -> impl FnOnce(std::io::Error) -> Self + '_ {
        |source| Self::Write {
            path: path.to_owned(),
            source,
        }
    }

    /// A file does not say what it should.
    pub(crate) fn damaged(path: &Path, message: impl Into<String>) -> Self {
        Self::Damaged {
            path: path.to_owned(),
            message: message.into(),
        }
    }

    /// Whether the caller asked for something that cannot be, as opposed to something failing on the way.
    pub fn is_bad_input(&self) -> bool {
        !matches!(self, Self::Write { .. })
    }
}
