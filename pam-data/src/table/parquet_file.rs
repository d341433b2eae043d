//! Columns of Apache Parquet files (feature `parquet`).

use super::arrays::ArrayTable;
use crate::error::DataError;
use crate::rig_file::FileLayout;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use std::path::Path;

/// Reads the columns of numbers; a missing value is NaN. Time stamps are seconds since 1970. Text, lists and nested
/// columns are passed over.
pub(super) fn read(path: &Path, _: Vec<u8>, _: &FileLayout) -> Result<ArrayTable, DataError> {
    let fail =
        |e: &dyn std::fmt::Display| DataError::file(path, format!("not a sound Parquet file: {e}"));
    let file = crate::read_limit::open(path)?;
    let reader = SerializedFileReader::new(file).map_err(|e| fail(&e))?;
    let mut arrays: Vec<(String, Vec<f64>)> = Vec::new();
    for row in reader.get_row_iter(None).map_err(|e| fail(&e))? {
        let row = row.map_err(|e| fail(&e))?;
        if arrays.is_empty() {
            arrays = row.get_column_iter().map(|(name, _)| (name.clone(), Vec::new())).collect();
        }
        for ((_, values), (_, field)) in arrays.iter_mut().zip(row.get_column_iter()) {
            values.push(number(field));
        }
    }
    arrays.retain(|(_, values)| values.iter().any(|v| !v.is_nan()));
    if arrays.is_empty() {
        return Err(DataError::file(path, "the file holds no columns of numbers"));
    }
    Ok(ArrayTable::new(path, arrays))
}

fn number(field: &Field) -> f64 {
    match field {
        Field::Bool(v) => f64::from(u8::from(*v)),
        Field::Byte(v) => f64::from(*v),
        Field::Short(v) => f64::from(*v),
        Field::Int(v) => f64::from(*v),
        Field::Long(v) => *v as f64,
        Field::UByte(v) => f64::from(*v),
        Field::UShort(v) => f64::from(*v),
        Field::UInt(v) => f64::from(*v),
        Field::ULong(v) => *v as f64,
        Field::Float(v) => f64::from(*v),
        Field::Double(v) => *v,
        Field::TimeMillis(v) => f64::from(*v) * 1e-3,
        Field::TimeMicros(v) => *v as f64 * 1e-6,
        Field::TimestampMillis(v) => *v as f64 * 1e-3,
        Field::TimestampMicros(v) => *v as f64 * 1e-6,
        _ => f64::NAN,
    }
}
