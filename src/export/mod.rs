//! Exports of a run for other programs: tables as CSV, Parquet or NumPy arrays, the graph as GraphML, DOT or Matrix Market.
//!
//! Four tables over all seeds that have ended, each with the column `seed` in front:
//!
//! | table | a row for each | columns |
//! |---|---|---|
//! | `episodes` | episode | those of `episodes.csv` |
//! | `refreshes` | refresh of the spectrum or of the potential | those of `refreshes.csv` |
//! | `states` | state | number, `row` and `col` or `name`, `potential`, `visits`, `greedy`, `greedy_name` |
//! | `transitions` | (state, action, next state) that was seen | `from`, `action`, `to`, `count`, `reward_sum`, `terminal`, `action_name` |
//!
//! CSV and Parquet make a folder of four files, `npz` one file with an array for each column (`episodes/length`) and the
//! eigenvectors of each seed (`eigenvectors/seed-0000`). GraphML, DOT and Matrix Market hold one graph, so they want one seed.

mod arrays;
mod error;
mod graph;
#[cfg(feature = "parquet")]
mod parquet;
mod source;
mod table;

pub use error::ExportError;
pub use graph::write_graph;
pub use source::{Source, SourceSeed};
pub use table::{Column, Table};

use crate::disk::{self, write_atomically};
use std::path::{Path, PathBuf};

/// Format of an export.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// A folder of CSV files.
    Csv,
    /// A folder of Parquet files.
    Parquet,
    /// One file of NumPy arrays.
    Npz,
    /// The graph, for Gephi, yEd, networkx and igraph.
    GraphMl,
    /// The graph, for Graphviz.
    Dot,
    /// The undirected graph in order of discovery, for [`matrix_market`](crate::graph::matrix_market).
    MatrixMarket,
}

impl Format {
    /// Whether it is of one graph, as one text.
    pub fn is_graph(self) -> bool {
        matches!(self, Format::GraphMl | Format::Dot | Format::MatrixMarket)
    }

    /// Whether this program was built with it.
    pub fn is_built(self) -> bool {
        self != Format::Parquet || cfg!(feature = "parquet")
    }
}

/// Writes what `source` holds to `out`, a folder for tables and a file for everything else, and returns the files
/// written. What exists is left alone unless `replace`; files that are not ours stay in the folder.
///
/// # Errors
/// If `out` exists, cannot be written, or a file of the run does not say what it should; if the format is not built
/// in; if a graph is asked for of several seeds.
pub fn export(
    source: &Source,
    format: Format,
    out: &Path,
    replace: bool,
) -> Result<Vec<PathBuf>, ExportError> {
    if !format.is_built() {
        return Err(ExportError::NoParquet);
    }
    if !replace && out.symlink_metadata().is_ok() {
        return Err(ExportError::Exists {
            path: out.to_owned(),
        });
    }
    match format {
        Format::Csv | Format::Parquet => tables(source, format, out),
        Format::Npz => {
            let tables = source.tables()?;
            let vectors = source.eigenvectors()?;
            write_atomically(out, |file| arrays::write_npz(file, &tables, &vectors))
                .map_err(ExportError::write(out))?;
            Ok(vec![out.to_owned()])
        }
        Format::GraphMl | Format::Dot | Format::MatrixMarket => {
            let seed = source.only_seed()?;
            let graph = seed.graph()?;
            write_atomically(out, |file| write_graph(file, &graph, format))
                .map_err(ExportError::write(out))?;
            Ok(vec![out.to_owned()])
        }
    }
}

/// One file for each table.
fn tables(source: &Source, format: Format, out: &Path) -> Result<Vec<PathBuf>, ExportError> {
    let tables = source.tables()?;
    disk::create_folders(out).map_err(ExportError::write(out))?;
    let files = tables.iter().map(|table| {
        let path = out.join(format!("{}.{}", table.name, extension(format)));
        write_atomically(&path, |file| match format {
            #[cfg(feature = "parquet")]
            Format::Parquet => parquet::write_parquet(file, table),
            _ => table.write_csv(file),
        })
        .map_err(ExportError::write(&path))?;
        Ok(path)
    });
    files.collect()
}

fn extension(format: Format) -> &'static str {
    match format {
        Format::Csv => "csv",
        Format::Parquet => "parquet",
        Format::Npz => "npz",
        Format::GraphMl => "graphml",
        Format::Dot => "dot",
        Format::MatrixMarket => "mtx",
    }
}
