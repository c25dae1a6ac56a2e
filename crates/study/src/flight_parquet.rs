//! A flight's table in Parquet: columns under the names of `flight.csv`, as pandas, Polars and DuckDB write
//! them, plain or by Snappy.

use std::collections::BTreeMap;

use bytes::Bytes;
use parquet::basic::Type as PhysicalType;
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::{BoolType, DataType, DoubleType, FloatType, Int32Type, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader as _, SerializedFileReader};
use samara_core::logged_flight::LoggedFlight;
use samara_core::logged_flight::columns::{KNOWN, flight};

use crate::shard::undamaged;

/// Columns of a table, at most.
const MOST_COLUMNS: usize = 1000;
/// Numbers of a table, at most.
const MOST_NUMBERS: usize = 50_000_000;

/// Why a file is no flight's table.
#[derive(Debug, thiserror::Error)]
pub enum FlightParquetError {
    /// The file is none of Parquet, or not whole.
    #[error("it is damaged: a whole Parquet file is expected")]
    Damaged,
    /// The library's own words.
    #[error(transparent)]
    Parquet(#[from] ParquetError),
    /// It has no times.
    #[error("expected a column `t_s` of times, and others of: {KNOWN}")]
    NoTimes,
    /// It is too large.
    #[error(
        "expected at most {MOST_COLUMNS} columns and {MOST_NUMBERS} numbers, found {rows} rows of {columns} columns"
    )]
    TooLarge {
        /// Rows.
        rows: usize,
        /// Columns.
        columns: usize,
    },
}

/// The flight of a table. Columns that are no plain numbers are left out; what is null is not a number.
///
/// # Errors
/// [`FlightParquetError`] where it is no such table.
pub fn read_flight_parquet(bytes: Vec<u8>) -> Result<LoggedFlight, FlightParquetError> {
    let columns =
        undamaged(FlightParquetError::Damaged, || numbers(&SerializedFileReader::new(Bytes::from(bytes))?))?;
    flight(|name| columns.get(name).map(Vec::as_slice)).ok_or(FlightParquetError::NoTimes)
}

/// All columns of numbers, by name.
fn numbers(file: &SerializedFileReader<Bytes>) -> Result<BTreeMap<String, Vec<f64>>, FlightParquetError> {
    let about = file.metadata().file_metadata();
    let described = about.schema_descr();
    let (rows, columns) = (usize::try_from(about.num_rows()).unwrap_or(usize::MAX), described.num_columns());
    if columns > MOST_COLUMNS || rows.saturating_mul(columns) > MOST_NUMBERS {
        return Err(FlightParquetError::TooLarge { rows, columns });
    }
    let mut found = BTreeMap::new();
    for (place, column) in described.columns().iter().enumerate() {
        let is_plain = column.path().parts().len() == 1 && column.max_rep_level() == 0;
        if !is_plain || !is_number(column.physical_type()) {
            continue;
        }
        let mut numbers = Vec::new();
        for group in 0..file.num_row_groups() {
            let group = file.get_row_group(group)?;
            let rows = usize::try_from(group.metadata().num_rows()).unwrap_or_default();
            let rows = rows.min(MOST_NUMBERS - numbers.len());
            let is_optional = column.max_def_level() > 0;
            numbers.extend(match group.get_column_reader(place)? {
                ColumnReader::DoubleColumnReader(mut reader) => {
                    read::<DoubleType>(&mut reader, rows, is_optional, |x| x)?
                }
                ColumnReader::FloatColumnReader(mut reader) => {
                    read::<FloatType>(&mut reader, rows, is_optional, f64::from)?
                }
                ColumnReader::Int32ColumnReader(mut reader) => {
                    read::<Int32Type>(&mut reader, rows, is_optional, f64::from)?
                }
                ColumnReader::Int64ColumnReader(mut reader) => {
                    read::<Int64Type>(&mut reader, rows, is_optional, |x| x as f64)?
                }
                ColumnReader::BoolColumnReader(mut reader) => {
                    read::<BoolType>(&mut reader, rows, is_optional, |x| f64::from(u8::from(x)))?
                }
                _ => Vec::new(),
            });
        }
        found.insert(column.name().to_owned(), numbers);
    }
    Ok(found)
}

fn is_number(kind: PhysicalType) -> bool {
    use PhysicalType::{BOOLEAN, DOUBLE, FLOAT, INT32, INT64};
    matches!(kind, BOOLEAN | DOUBLE | FLOAT | INT32 | INT64)
}

/// So many values of a column as numbers; null is not a number.
fn read<T: DataType>(
    reader: &mut ColumnReaderImpl<T>,
    rows: usize,
    is_optional: bool,
    number: impl Fn(T::T) -> f64,
) -> Result<Vec<f64>, ParquetError> {
    let (mut levels, mut values) = (Vec::new(), Vec::new());
    reader.read_records(rows, is_optional.then_some(&mut levels), None, &mut values)?;
    let mut values = values.into_iter().map(number);
    if !is_optional {
        return Ok(values.collect());
    }
    let there = levels.into_iter().map(|level| if level == 0 { None } else { values.next() });
    Ok(there.map(|value| value.unwrap_or(f64::NAN)).collect())
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;
    use std::path::Path;
    use std::sync::Arc;

    use parquet::basic::{Compression, Repetition};
    use parquet::column::writer::ColumnWriter;
    use parquet::file::properties::WriterProperties;
    use parquet::file::writer::SerializedFileWriter;
    use parquet::schema::types::Type;
    use samara_mission::read_flight_table;

    use super::*;

    /// Velocities north, some of them null.
    const NORTH_M_S: [Option<f64>; 4] = [Some(1.5), None, Some(-2.0), Some(0.25)];
    const KINDS: [(&str, PhysicalType, Repetition); 6] = [
        ("t_s", PhysicalType::DOUBLE, Repetition::REQUIRED),
        ("vn_m_s", PhysicalType::DOUBLE, Repetition::OPTIONAL),
        ("ve_m_s", PhysicalType::FLOAT, Repetition::REQUIRED),
        ("vd_m_s", PhysicalType::INT32, Repetition::REQUIRED),
        ("armed", PhysicalType::BOOLEAN, Repetition::REQUIRED),
        ("phase", PhysicalType::BYTE_ARRAY, Repetition::REQUIRED),
    ];

    /// A table of four rows in two row groups, by the library's writer.
    fn written() -> Vec<u8> {
        let field = |(name, kind, repetition): &(&str, PhysicalType, Repetition)| {
            Arc::new(Type::primitive_type_builder(name, *kind).with_repetition(*repetition).build().unwrap())
        };
        let fields = KINDS.iter().map(field).collect();
        let schema = Arc::new(Type::group_type_builder("flight").with_fields(fields).build().unwrap());
        let properties = Arc::new(WriterProperties::builder().set_compression(Compression::SNAPPY).build());
        let mut file = Vec::new();
        let mut writer = SerializedFileWriter::new(&mut file, schema, properties).unwrap();
        for half in 0..2 {
            let rows = 2 * half..2 * half + 2;
            let mut group = writer.next_row_group().unwrap();
            while let Some(mut column) = group.next_column().unwrap() {
                match column.untyped() {
                    ColumnWriter::DoubleColumnWriter(out) => {
                        let (times, north) = ([0.0, 0.1, 0.2, 0.3], &NORTH_M_S[rows.clone()]);
                        let levels: Vec<i16> = north.iter().map(|v| i16::from(v.is_some())).collect();
                        let there: Vec<f64> = north.iter().copied().flatten().collect();
                        match out.get_descriptor().name() {
                            "t_s" => out.write_batch(&times[rows.clone()], None, None).unwrap(),
                            _ => out.write_batch(&there, Some(&levels), None).unwrap(),
                        };
                    }
                    ColumnWriter::FloatColumnWriter(out) => {
                        _ = out.write_batch(&[0.5; 2], None, None).unwrap()
                    }
                    ColumnWriter::Int32ColumnWriter(out) => {
                        _ = out.write_batch(&[3, -4], None, None).unwrap()
                    }
                    ColumnWriter::BoolColumnWriter(out) => {
                        _ = out.write_batch(&[true, false], None, None).unwrap();
                    }
                    ColumnWriter::ByteArrayColumnWriter(out) => {
                        _ = out.write_batch(&["hanging".into(), "falling".into()], None, None).unwrap();
                    }
                    _ => unreachable!(),
                }
                column.close().unwrap();
            }
            group.close().unwrap();
        }
        writer.close().unwrap();
        file
    }

    #[test]
    fn reference_a_table_is_the_flight_of_the_same_numbers_in_csv() {
        let mut text = "t_s,vn_m_s,ve_m_s,vd_m_s,armed,phase\n".to_owned();
        for (row, north) in NORTH_M_S.iter().enumerate() {
            let north = north.map(|v| v.to_string()).unwrap_or_default();
            let of_two = [("3", "1", "hanging"), ("-4", "0", "falling")][row % 2];
            let (down, armed, phase) = of_two;
            writeln!(text, "{},{north},0.5,{down},{armed},{phase}", [0.0, 0.1, 0.2, 0.3][row]).unwrap();
        }
        let of_csv = read_flight_table(&text, Path::new("flight.csv")).unwrap();
        let of_parquet = read_flight_parquet(written()).unwrap();
        assert_eq!(format!("{of_parquet:?}"), format!("{of_csv:?}"));
        assert!(of_parquet.velocity_ned_m_s.is_some() && of_parquet.armed.is_some());
    }

    /// A byte of the file is another one, or its end is missing: an answer, whatever it is.
    #[test]
    fn prop_a_damaged_file_is_an_answer() {
        let whole = written();
        for end in 0..whole.len() {
            assert!(read_flight_parquet(whole[..end].to_vec()).is_err(), "{end}");
        }
        for (at, flip) in (0..whole.len()).flat_map(|at| [(at, 1), (at, 0x80)]) {
            let mut bytes = whole.clone();
            bytes[at] ^= flip;
            let _ = read_flight_parquet(bytes);
        }
    }
}
