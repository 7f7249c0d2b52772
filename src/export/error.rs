//! Errors of an export.

use crate::archive::ArchiveError;
use crate::graph::GraphError;
use std::path::{Path, PathBuf};

/// Reason why nothing was exported.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// A file of the run could not be read.
    #[error(transparent)]
    Run(#[from] ArchiveError),
    /// The transitions of a run do not make a graph.
    #[error("{path}: {source}", path = path.display())]
    Graph {
        /// Their table.
        path: PathBuf,
        /// What is wrong.
        source: GraphError,
    },
    /// There is something where the export would go.
    #[error("{path}: exists; --force replaces it, -o names another", path = path.display())]
    Exists {
        /// The place.
        path: PathBuf,
    },
    /// A graph of several seeds was asked for.
    #[error(
        "{path}: has {seeds} seeds, and each has its own graph; name the folder of one, such as {first}",
        path = path.display(),
        first = first.display()
    )]
    ManySeeds {
        /// The run.
        path: PathBuf,
        /// How many there are.
        seeds: usize,
        /// One of them.
        first: PathBuf,
    },
    /// Parquet is not built in.
    #[error(
        "this eigentrail was built without Parquet; build it with `cargo install --locked --path . --features parquet`"
    )]
    NoParquet,
    /// Writing failed.
    #[error("{path}: cannot write: {source}", path = path.display())]
    Write {
        /// Where to.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
}

impl ExportError {
    /// Writing to `path` failed: for `map_err`.
    pub(super) fn write(path: &Path) -> impl FnOnce(std::io::Error) -> Self + '_ {
        |source| Self::Write {
            path: path.to_owned(),
            source,
        }
    }

    /// A file of the run does not say what it should.
    pub(super) fn damaged(path: &Path, message: impl Into<String>) -> Self {
        Self::Run(ArchiveError::Damaged {
            path: path.to_owned(),
            message: message.into(),
        })
    }

    /// Whether the caller asked for something that cannot be, as opposed to something failing on the way.
    pub fn is_bad_input(&self) -> bool {
        match self {
            Self::Run(error) => error.is_bad_input(),
            _ => true,
        }
    }
}
