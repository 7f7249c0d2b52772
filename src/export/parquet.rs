//! Tables as [Parquet](https://parquet.apache.org), which pandas, Polars, DuckDB and Spark read; one row group, Snappy.
//!
//! Written column by column with Parquet's own writer, without Arrow in between. A column is optional if and only if a
//! value is missing from it; definition level 1 then says that there is one.

use super::table::{Column, Table};
use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::Type;
use std::io::{self, Write};
use std::sync::Arc;

/// Writes one table.
pub(super) fn write_parquet(out: &mut (impl Write + Send), table: &Table) -> io::Result<()> {
    write(out, table).map_err(io::Error::other)
}

fn write(out: &mut (impl Write + Send), table: &Table) -> Result<(), ParquetError> {
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .build();
    let mut file = SerializedFileWriter::new(out, schema(table)?, Arc::new(properties))?;
    let mut rows = file.next_row_group()?;
    for (_, column) in &table.columns {
        let mut writer = rows
            .next_column()?
            .expect("the schema was made of these columns");
        match column {
            Column::Integers(values) => put::<Int64Type>(&mut writer, values),
            Column::Numbers(values) => put::<DoubleType>(&mut writer, values),
            Column::Flags(values) => put::<BoolType>(&mut writer, values),
            Column::Texts(values) => {
                let text = |text: &String| Some(ByteArray::from(text.as_str()));
                let values: Vec<_> = values.iter().map(text).collect();
                put::<ByteArrayType>(&mut writer, &values)
            }
        }?;
        writer.close()?;
    }
    rows.close()?;
    file.close()?;
    Ok(())
}

fn put<T: DataType>(
    writer: &mut SerializedColumnWriter<'_>,
    values: &[Option<T::T>],
) -> Result<(), ParquetError> {
    let present: Vec<T::T> = values.iter().flatten().cloned().collect();
    let levels: Vec<i16> = values.iter().map(|v| i16::from(v.is_some())).collect();
    let levels = (present.len() < values.len()).then_some(levels.as_slice());
    writer
        .typed::<T>()
        .write_batch(&present, levels, None)
        .map(drop)
}

fn schema(table: &Table) -> Result<Arc<Type>, ParquetError> {
    let fields = table.columns.iter().map(|(name, column)| {
        let (physical, text) = match column {
            Column::Integers(_) => (Physical::INT64, false),
            Column::Numbers(_) => (Physical::DOUBLE, false),
            Column::Flags(_) => (Physical::BOOLEAN, false),
            Column::Texts(_) => (Physical::BYTE_ARRAY, true),
        };
        let repetition = match lacks_some(column) {
            true => Repetition::OPTIONAL,
            false => Repetition::REQUIRED,
        };
        Type::primitive_type_builder(name, physical)
            .with_repetition(repetition)
            .with_logical_type(text.then_some(LogicalType::String))
            .build()
            .map(Arc::new)
    });
    let fields = fields.collect::<Result<Vec<_>, _>>()?;
    let schema = Type::group_type_builder(table.name).with_fields(fields);
    schema.build().map(Arc::new)
}

fn lacks_some(column: &Column) -> bool {
    match column {
        Column::Integers(values) => values.contains(&None),
        Column::Numbers(values) => values.iter().any(Option::is_none),
        Column::Flags(values) => values.contains(&None),
        Column::Texts(_) => false,
    }
}
