//! Writing tables as Apache Parquet (feature `parquet`).

use crate::error::AblateError;
use crate::table::{Column, Table};
use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use std::path::Path;
use std::sync::Arc;

impl Table {
    /// Encodes the table as Apache Parquet: uncompressed, one row group.
    ///
    /// # Errors
    /// [`AblateError::Folder`] naming `path` if it cannot be encoded.
    pub fn to_parquet(&self, path: impl AsRef<Path>) -> Result<Vec<u8>, AblateError> {
        self.to_parquet_at(path.as_ref())
    }

    /// One instance, whatever the path is given as.
    fn to_parquet_at(&self, path: &Path) -> Result<Vec<u8>, AblateError> {
        self.encode().map_err(|e| AblateError::folder(path, format!("no Parquet: {e}")))
    }

    fn encode(&self) -> Result<Vec<u8>, ParquetError> {
        let fields = self.columns.iter().map(|(name, column)| {
            let (physical, logical, repetition) = match column {
                Column::Text(_) => {
                    (Physical::BYTE_ARRAY, Some(LogicalType::String), Repetition::OPTIONAL)
                }
                Column::Integer(_) => (Physical::INT64, None, Repetition::REQUIRED),
                Column::Number(_) => (Physical::DOUBLE, None, Repetition::OPTIONAL),
            };
            Type::primitive_type_builder(name, physical)
                .with_logical_type(logical)
                .with_repetition(repetition)
                .build()
                .map(Arc::new)
        });
        let fields = fields.collect::<Result<Vec<_>, _>>()?;
        let schema = Arc::new(Type::group_type_builder("results").with_fields(fields).build()?);
        let properties = Arc::new(WriterProperties::builder().build());
        let mut bytes = Vec::new();
        let mut writer = SerializedFileWriter::new(&mut bytes, schema, properties)?;
        let mut group = writer.next_row_group()?;
        for (_, column) in &self.columns {
            let mut to = group
                .next_column()?
                .ok_or_else(|| ParquetError::General("more columns than the schema has".into()))?;
            match column {
                Column::Text(v) => {
                    let values: Vec<ByteArray> =
                        v.iter().flatten().map(|t| ByteArray::from(t.as_str())).collect();
                    to.typed::<ByteArrayType>().write_batch(&values, Some(&levels(v)), None)?;
                }
                Column::Integer(v) => {
                    to.typed::<Int64Type>().write_batch(v, None, None)?;
                }
                Column::Number(v) => {
                    let values: Vec<f64> = v.iter().flatten().copied().collect();
                    to.typed::<DoubleType>().write_batch(&values, Some(&levels(v)), None)?;
                }
            }
            to.close()?;
        }
        group.close()?;
        writer.close()?;
        Ok(bytes)
    }
}

/// Parquet's definition levels: 1 for a value, 0 for a missing one.
fn levels<T>(values: &[Option<T>]) -> Vec<i16> {
    values.iter().map(|v| i16::from(v.is_some())).collect()
}
