//! Errors of a Matrix Market file: the place, and the rule that it breaks.

use std::fmt;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// A Matrix Market file that cannot be used: `file:line: rule`.
#[derive(Debug, Error)]
pub struct MatrixMarketError {
    /// The file, if it was one.
    pub path: Option<PathBuf>,
    /// The line, from 1, if there is one to blame.
    pub line: Option<usize>,
    /// The rule that is broken.
    #[source]
    pub fault: MatrixMarketFault,
}

impl fmt::Display for MatrixMarketError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.path {
            Some(path) => write!(f, "{}", path.display())?,
            None => write!(f, "Matrix Market text")?,
        }
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        write!(f, ": {}", self.fault)
    }
}

impl MatrixMarketError {
    pub(super) fn in_file(self, path: &Path) -> Self {
        Self {
            path: Some(path.to_owned()),
            ..self
        }
    }
}

/// The rules; rows and columns count from 1, as in the file.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum MatrixMarketFault {
    /// The file can be read.
    #[error("cannot be read: {0}")]
    Read(std::io::Error),
    /// The first line is a header.
    #[error(
        "the first line must be `%%MatrixMarket matrix coordinate pattern|real|integer symmetric|general`, it is `{found}`"
    )]
    Header {
        /// The line, shortened.
        found: String,
    },
    /// The kind of matrix is one that a graph can have.
    #[error("`{found}` matrices are not supported: use {supported}")]
    Unsupported {
        /// The word in the header.
        found: String,
        /// What could stand in its place.
        supported: &'static str,
    },
    /// Three integers come first.
    #[error("expected `rows columns entries`, found `{found}`")]
    Size {
        /// The line, shortened.
        found: String,
    },
    /// An adjacency is square.
    #[error("an adjacency must be square, this one is {rows} × {columns}")]
    NotSquare {
        /// Number of rows.
        rows: u64,
        /// Number of columns.
        columns: u64,
    },
    /// A graph has nodes.
    #[error("the graph has no nodes")]
    NoNodes,
    /// The graph fits.
    #[error("{nodes} nodes are more than this machine or a 32-bit node number can hold")]
    TooLarge {
        /// Number of nodes.
        nodes: u64,
    },
    /// Entries can be numbered.
    #[error("{promised} entries are more than the 2³² − 1 that can be numbered")]
    TooManyEntries {
        /// How many the file promises.
        promised: u64,
    },
    /// There are as many entries as promised.
    #[error("line {size_line} promises {promised} entries, there are {found}")]
    EntryCount {
        /// Where the promise stands.
        size_line: usize,
        /// What it says.
        promised: u64,
        /// How many there are.
        found: u64,
    },
    /// An entry has the form that the header tells.
    #[error("expected {expected}, found `{found}`")]
    Entry {
        /// The form.
        expected: &'static str,
        /// The line, shortened.
        found: String,
    },
    /// Indices are from 1 to n.
    #[error("entry ({row}, {column}) is outside of 1 ‥ {nodes}")]
    IndexOutOfRange {
        /// Its row, as it is written.
        row: String,
        /// Its column, as it is written.
        column: String,
        /// Number of nodes n.
        nodes: usize,
    },
    /// Weights are finite and not negative.
    #[error(
        "the weight of entry ({row}, {column}) must be finite and not negative, it is {weight}"
    )]
    Weight {
        /// Row of the entry.
        row: usize,
        /// Column of the entry.
        column: usize,
        /// Its weight.
        weight: f64,
    },
    /// No entry comes twice.
    #[error("entry ({row}, {column}) was given before, on line {first_line}")]
    Repeated {
        /// Row of the repetition.
        row: usize,
        /// Column of the repetition.
        column: usize,
        /// Where it stands first, itself or (in a symmetric matrix) its mirror image.
        first_line: usize,
    },
    /// A `general` matrix equals its transpose.
    #[error(
        "not symmetric: entry ({row}, {column}) is {weight}, entry ({column}, {row}) is {mirrored}"
    )]
    Asymmetric {
        /// Row of the first offending entry, row by row.
        row: usize,
        /// Its column.
        column: usize,
        /// Its weight.
        weight: f64,
        /// The weight of its mirror image, 0 if that is absent.
        mirrored: f64,
    },
    /// Row sums are finite.
    #[error("the weights in row {row} sum to infinity")]
    DegreeOverflow {
        /// The row.
        row: usize,
    },
}

impl MatrixMarketFault {
    pub(super) fn on_line(self, line: usize) -> MatrixMarketError {
        MatrixMarketError {
            path: None,
            line: Some(line),
            fault: self,
        }
    }

    pub(super) fn nowhere(self) -> MatrixMarketError {
        MatrixMarketError {
            path: None,
            line: None,
            fault: self,
        }
    }
}

/// A line for a message: not more of it than fits there.
pub(super) fn shorten(text: &str) -> String {
    const MOST: usize = 60;
    match text.char_indices().nth(MOST) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}
