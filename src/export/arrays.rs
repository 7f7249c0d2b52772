//! Tables as NumPy arrays in one file, as `numpy.load` reads it: a zip archive of `.npy` files.
//!
//! Arrays have no missing values: a column of whole numbers or flags that lacks some becomes one of numbers with NaN.

use super::table::{Column, Table};
use npyz::{AutoSerialize, DType, TypeStr, WriteOptions, WriterBuilder};
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
        let dtype = f64::default_dtype();
        archive.array(&name, &matrix.shape, dtype, &matrix.entries)?;
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
                Some(values) => self.array(name, &shape, i64::default_dtype(), &values),
                None => self.numbers(name, values.iter().map(|v| v.map(|v| v as f64))),
            },
            Column::Flags(values) => match whole(values) {
                Some(values) => self.array(name, &shape, bool::default_dtype(), &values),
                None => self.numbers(
                    name,
                    values.iter().map(|v| v.map(|v| f64::from(u8::from(v)))),
                ),
            },
            Column::Numbers(values) => self.numbers(name, values.iter().copied()),
            Column::Texts(values) => self.array(name, &shape, text_type(values), values),
        }
    }

    fn numbers(&mut self, name: &str, values: impl Iterator<Item = Option<f64>>) -> io::Result<()> {
        let values: Vec<f64> = values.map(|value| value.unwrap_or(f64::NAN)).collect();
        self.array(name, &[values.len()], f64::default_dtype(), &values)
    }

    /// The entries are stored as they are: `numpy.load` then maps or copies them at the speed of the disk. A fixed date
    /// makes equal runs equal files.
    fn array<T: npyz::Serialize>(
        &mut self,
        name: &str,
        shape: &[usize],
        dtype: DType,
        values: &[T],
    ) -> io::Result<()> {
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .last_modified_time(zip::DateTime::default())
            .large_file(size_of_val(values) > 1 << 30);
        self.0.start_file(format!("{name}.npy"), options)?;
        let shape: Vec<u64> = shape.iter().map(|&n| n as u64).collect();
        let mut array = WriteOptions::<T>::new()
            .dtype(dtype)
            .shape(&shape)
            .writer(&mut self.0)
            .begin_nd()?;
        for value in values {
            array.push(value)?;
        }
        array.finish()
    }
}

/// The values, if none is missing.
fn whole<T: Copy>(values: &[Option<T>]) -> Option<Vec<T>> {
    values.iter().copied().collect()
}

/// Unicode of the longest text's length.
fn text_type(values: &[String]) -> DType {
    let longest = values.iter().map(|text| text.chars().count()).max();
    let longest = longest.unwrap_or(0).max(1);
    let name: Result<TypeStr, _> = format!("<U{longest}").parse();
    DType::Plain(name.expect("a length makes a type"))
}
