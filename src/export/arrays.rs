//! Tables as NumPy arrays in one file, as `numpy.load` reads it: a zip archive of `.npy` files.
//!
//! Arrays have no missing values: a column of whole numbers or flags that lacks some becomes one of numbers with NaN.

use super::table::{Column, Table};
use crate::npy;
use std::io::{self, Seek, Write};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// A matrix with its name.
pub(super) struct Matrix {
    pub name: String,
    pub shape: Vec<usize>,
    /// Row by row.
    pub entries: Vec<f64>,
}

/// Writes each column as `table/column` and each matrix as `eigenvectors/name`.
pub(super) fn write_npz(
    out: &mut (impl Write + Seek),
    tables: &[Table],
    matrices: &[Matrix],
) -> io::Result<()> {
    let mut archive = Archive(ZipWriter::new(out));
    for table in tables {
        for (name, column) in &table.columns {
            archive.column(&format!("{}/{name}", table.name), column)?;
        }
    }
    for matrix in matrices {
        let name = format!("eigenvectors/{}", matrix.name);
        archive.numbers(&name, &matrix.shape, &matrix.entries)?;
    }
    archive.0.finish()?;
    Ok(())
}

struct Archive<W: Write + Seek>(ZipWriter<W>);

impl<W: Write + Seek> Archive<W> {
    fn column(&mut self, name: &str, column: &Column) -> io::Result<()> {
        let shape = [column.len()];
        match column {
            Column::Integers(values) => match whole(values) {
                Some(values) => self.array(
                    name,
                    &shape,
                    ("<i8", 8),
                    values.iter().map(|v| v.to_le_bytes()),
                ),
                None => self.gappy(name, values.iter().map(|v| v.map(|v| v as f64))),
            },
            Column::Flags(values) => match whole(values) {
                Some(values) => self.array(
                    name,
                    &shape,
                    ("|b1", 1),
                    values.iter().map(|&v| [u8::from(v)]),
                ),
                None => self.gappy(
                    name,
                    values.iter().map(|v| v.map(|v| f64::from(u8::from(v)))),
                ),
            },
            Column::Numbers(values) => self.gappy(name, values.iter().copied()),
            Column::Texts(values) => {
                let longest = values.iter().map(|text| text.chars().count()).max();
                let longest = longest.unwrap_or(0).max(1);
                let entries = values.iter().map(|text| unicode(text, longest));
                self.array(
                    name,
                    &shape,
                    (&format!("<U{longest}"), 4 * longest),
                    entries,
                )
            }
        }
    }

    /// A column of numbers, NaN where there is none.
    fn gappy(&mut self, name: &str, values: impl Iterator<Item = Option<f64>>) -> io::Result<()> {
        let values: Vec<f64> = values.map(|value| value.unwrap_or(f64::NAN)).collect();
        self.numbers(name, &[values.len()], &values)
    }

    fn numbers(&mut self, name: &str, shape: &[usize], values: &[f64]) -> io::Result<()> {
        self.array(
            name,
            shape,
            (npy::F64, 8),
            values.iter().map(|v| v.to_le_bytes()),
        )
    }

    /// An array of a kind whose entries have `width` bytes. They are stored as they are: `numpy.load` then maps or copies them at the speed of the disk. A fixed date
    /// makes equal runs equal files.
    fn array<E: AsRef<[u8]>>(
        &mut self,
        name: &str,
        shape: &[usize],
        (kind, width): (&str, usize),
        mut entries: impl ExactSizeIterator<Item = E>,
    ) -> io::Result<()> {
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .last_modified_time(zip::DateTime::default())
            .large_file(entries.len().saturating_mul(width) > 1 << 30);
        self.0.start_file(format!("{name}.npy"), options)?;
        npy::write_header(&mut self.0, kind, shape)?;
        entries.try_for_each(|entry| self.0.write_all(entry.as_ref()))
    }
}

/// The values, if none is missing.
fn whole<T: Copy>(values: &[Option<T>]) -> Option<Vec<T>> {
    values.iter().copied().collect()
}

/// The characters of `text` as numbers of four bytes, with zeros behind them to make `length`.
fn unicode(text: &str, length: usize) -> Vec<u8> {
    let characters = text.chars().map(u32::from);
    let padded = characters.chain(std::iter::repeat(0)).take(length);
    padded.flat_map(u32::to_le_bytes).collect()
}
