//! Any undirected graph in and out, as a [Matrix Market](https://math.nist.gov/MatrixMarket/formats.html) file.
//!
//! ```text
//! %%MatrixMarket matrix coordinate real symmetric
//! % anything
//! 3 3 2            rows, columns, entries that follow
//! 2 1 1.0          row, column, weight; from 1
//! 3 2 0.5
//! ```
//!
//! **Row i is the i-th node in order of discovery.** The rules for reading:
//!
//! - `coordinate`, `pattern` (weights 1), `real` or `integer`, `symmetric` or `general`; upper and lower case are equal.
//! - Square, at least one node. No entries at all, isolated nodes, several components and self-loops are legal.
//! - Weights are finite and not negative. **Entries with weight 0 are dropped**: other programs store them for entries
//!   they removed, and the matrix is the same without.
//! - **No entry twice**, since programs disagree whether they add up. In a `symmetric` file either triangle may be
//!   used, but (i, j) and (j, i) together are a repetition.
//! - A `general` matrix must equal its transpose exactly.
//! - Lines that are blank or begin with `%` may stand anywhere after the first line.
//!
//! A broken rule is a [`MatrixMarketError`] that names file, line and rule.
//!
//! **How.** nalgebra-sparse parses the entries. It takes a whole text, tells no positions and panics on integers
//! beyond 64 bits, so it is given blocks of lines under a header of our own: blocks run in parallel, memory for its
//! parse tree stays small, and a block that fails is read again line by line to find the one that is wrong.

mod assemble;
mod entries;
mod error;
mod header;

pub use error::{MatrixMarketError, MatrixMarketFault};

use super::Adjacency;
use crate::disk::write_atomically;
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// Reads the graph in the file at `path`. O(n + nnz log(nnz / n)); bytes that are not UTF-8 are legal in comments.
///
/// # Errors
/// The first broken rule of the [module](self), or why the file cannot be read.
pub fn load(path: impl AsRef<Path>) -> Result<Adjacency, MatrixMarketError> {
    let path = path.as_ref();
    let text = std::fs::read(path).map_err(|error| MatrixMarketFault::Read(error).nowhere());
    text.and_then(|bytes| parse(&String::from_utf8_lossy(&bytes)))
        .map_err(|error| error.in_file(path))
}

/// Reads the graph in `text`.
///
/// # Errors
/// The first broken rule of the [module](self).
pub fn parse(text: &str) -> Result<Adjacency, MatrixMarketError> {
    let (header, lines) = header::read(text)?;
    let entries = entries::read(&header, &lines)?;
    assemble::adjacency(&header, &lines, &entries)
}

/// Writes `graph` as `coordinate pattern symmetric` if all weights are 1, else as `coordinate real symmetric`, lower
/// triangle row by row. Weights are written with as many digits as they need: reading gives the same graph to the bit.
///
/// # Errors
/// Those of `out`.
pub fn write(out: impl Write, graph: &Adjacency) -> io::Result<()> {
    let mut out = BufWriter::new(out);
    let nodes = || 0..graph.num_nodes() as u32;
    let is_pattern = nodes().all(|row| graph.weights(row).iter().all(|&weight| weight == 1.0));
    let field = if is_pattern { "pattern" } else { "real" };
    writeln!(out, "%%MatrixMarket matrix coordinate {field} symmetric")?;
    writeln!(out, "{n} {n} {}", graph.num_edges(), n = graph.num_nodes())?;
    for row in nodes() {
        for (&column, weight) in graph.neighbors(row).iter().zip(graph.weights(row)) {
            match (column <= row, is_pattern) {
                (true, true) => writeln!(out, "{} {}", row + 1, column + 1)?,
                (true, false) => writeln!(out, "{} {} {weight}", row + 1, column + 1)?,
                (false, _) => break,
            }
        }
    }
    out.flush()
}

/// As [`write`](fn@write), to the file at `path`: under a temporary name first, so that it is whole or not there.
///
/// # Errors
/// Why the file cannot be written.
pub fn save(path: impl AsRef<Path>, graph: &Adjacency) -> io::Result<()> {
    write_atomically(path.as_ref(), |file| write(file, graph))
}
