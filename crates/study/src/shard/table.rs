//! Rows as Parquet columns, in row groups, uncompressed: Parquet's own types, read by anything that reads
//! Parquet.

use std::fs::File;
use std::io::Write as _;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use parquet::basic::{LogicalType, Repetition, Type as PhysicalType};
use parquet::column::reader::{ColumnReaderImpl, get_typed_column_reader};
use parquet::column::writer::ColumnWriter;
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader as _, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::seal::{SEAL, UNSEALED, is_sealed, seal};
use super::{ShardError, ShardHead};
use samara_report::json::VERSION;

/// Keys of the metadata, beside the seal: what the part belongs to, its statistics, and three for whoever
/// looks at the file.
const HEAD: &str = "samara.shard";
const SUMMARY: &str = "samara.summary";
const PLAIN: [&str; 3] = ["samara.version", "samara.seed", "samara.input_hash"];

/// Values of a column.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Text; `None` is null.
    Text(Vec<Option<String>>),
    /// Whole numbers.
    Whole(Vec<i64>),
    /// Numbers; `None` is null.
    Number(Vec<Option<f64>>),
}

impl Values {
    /// The number of rows.
    fn len(&self) -> usize {
        match self {
            Self::Text(values) => values.len(),
            Self::Whole(values) => values.len(),
            Self::Number(values) => values.len(),
        }
    }
}

/// Rows by columns, all of the same length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Name and values of each column.
    pub columns: Vec<(String, Values)>,
}

impl Table {
    /// The column of a name.
    ///
    /// # Errors
    /// [`ShardError::NotAShard`] where there is none.
    pub fn column(&self, name: &str) -> Result<&Values, ShardError> {
        let column = self.columns.iter().find(|column| column.0 == name);
        column.map(|(_, values)| values).ok_or(ShardError::NotAShard(name.into()))
    }

    /// The whole numbers of a column.
    ///
    /// # Errors
    /// [`ShardError::NotAShard`] where there are none.
    pub fn wholes(&self, name: &str) -> Result<&[i64], ShardError> {
        match self.column(name)? {
            Values::Whole(values) => Ok(values),
            _ => Err(ShardError::NotAShard(name.into())),
        }
    }

    /// The texts of a column.
    ///
    /// # Errors
    /// [`ShardError::NotAShard`] where there are none.
    pub fn texts(&self, name: &str) -> Result<&[Option<String>], ShardError> {
        match self.column(name)? {
            Values::Text(values) => Ok(values),
            _ => Err(ShardError::NotAShard(name.into())),
        }
    }

    /// The number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |(_, values)| values.len())
    }
}

fn schema(columns: &Table) -> Result<Type, ParquetError> {
    let field = |(name, values): &(String, Values)| {
        let (physical, logical, repetition) = match values {
            Values::Text(_) => (PhysicalType::BYTE_ARRAY, Some(LogicalType::String), Repetition::OPTIONAL),
            Values::Whole(_) => (PhysicalType::INT64, None, Repetition::REQUIRED),
            Values::Number(_) => (PhysicalType::DOUBLE, None, Repetition::OPTIONAL),
        };
        let field = Type::primitive_type_builder(name, physical)
            .with_repetition(repetition)
            .with_logical_type(logical);
        field.build().map(Arc::new)
    };
    let fields = columns.columns.iter().map(field).collect::<Result<Vec<_>, _>>()?;
    Type::group_type_builder("trials").with_fields(fields).build()
}

/// Values that are there, and for each row whether one is.
fn present<T, V>(values: &[Option<T>], of: impl Fn(&T) -> V) -> (Vec<V>, Vec<i16>) {
    (values.iter().flatten().map(of).collect(), values.iter().map(|x| i16::from(x.is_some())).collect())
}

/// A part's file while it is written: one that can be read again, to be sealed.
pub struct ShardWriter {
    file: SerializedFileWriter<File>,
}

impl ShardWriter {
    /// Begins a file of rows with the columns of a table.
    ///
    /// # Errors
    /// [`ShardError`] when it cannot be written.
    pub fn new(out: File, columns: &Table) -> Result<Self, ShardError> {
        let properties = WriterProperties::builder()
            .set_created_by(format!("samara {VERSION}"))
            .set_dictionary_enabled(false)
            .build();
        let mut file = SerializedFileWriter::new(out, Arc::new(schema(columns)?), Arc::new(properties))?;
        // A file that was begun has bytes.
        file.flush().map_err(ParquetError::from)?;
        Ok(Self { file })
    }

    /// Writes rows as a row group; none are nothing.
    ///
    /// # Errors
    /// [`ShardError`] when they cannot be written.
    pub fn write(&mut self, rows: &Table) -> Result<(), ShardError> {
        if rows.rows() == 0 {
            return Ok(());
        }
        let mut group = self.file.next_row_group()?;
        for (_, values) in &rows.columns {
            let mut writer = group
                .next_column()?
                .ok_or(ShardError::NotAShard("as many columns as at the beginning".into()))?;
            match (writer.untyped(), values) {
                (ColumnWriter::ByteArrayColumnWriter(writer), Values::Text(values)) => {
                    let (values, levels) = present(values, |text| ByteArray::from(text.as_bytes().to_vec()));
                    writer.write_batch(&values, Some(&levels), None)?;
                }
                (ColumnWriter::Int64ColumnWriter(writer), Values::Whole(values)) => {
                    writer.write_batch(values, None, None)?;
                }
                (ColumnWriter::DoubleColumnWriter(writer), Values::Number(values)) => {
                    let (values, levels) = present(values, |x| *x);
                    writer.write_batch(&values, Some(&levels), None)?;
                }
                _ => return Err(ShardError::NotAShard("columns of the types of the beginning".into())),
            }
            writer.close()?;
        }
        group.close()?;
        Ok(())
    }

    /// Ends the file and seals it: what it belongs to and its statistics go to its metadata.
    ///
    /// # Errors
    /// [`ShardError`] when they cannot be written.
    pub fn finish(mut self, head: &ShardHead, summary: &impl Serialize) -> Result<File, ShardError> {
        let asked = &head.asked;
        let plain = [asked.version.clone(), asked.seed.to_string(), asked.input_hash.clone()];
        let texts = [
            (HEAD, serde_json::to_string(head)?),
            (SUMMARY, serde_json::to_string(summary)?),
            (SEAL, UNSEALED.to_owned()),
        ];
        for (key, text) in PLAIN.into_iter().zip(plain).chain(texts) {
            self.file.append_key_value_metadata(KeyValue::new(key.to_owned(), text));
        }
        let mut out = self.file.into_inner()?;
        out.flush().and_then(|()| seal(&mut out)).map_err(ParquetError::from)?;
        Ok(out)
    }
}

/// A part's file.
pub struct ShardReader {
    file: SerializedFileReader<File>,
    head: ShardHead,
}

impl ShardReader {
    /// The part in a file whose every byte is as it was written, which is looked at.
    ///
    /// # Errors
    /// [`ShardError`] where one is not, or where it is no part of a campaign.
    pub fn checked(mut file: File) -> Result<Self, ShardError> {
        if !is_sealed(&mut file).map_err(ParquetError::from)? {
            return Err(ShardError::Damaged);
        }
        Self::new(file)
    }

    /// The part in a file that was [checked](Self::checked) before.
    ///
    /// # Errors
    /// [`ShardError`] where it is no part of a campaign.
    pub fn new(file: File) -> Result<Self, ShardError> {
        let file = undamaged(ShardError::Damaged, || Ok(SerializedFileReader::new(file)?))?;
        let head: ShardHead = serde_json::from_str(metadata(&file, HEAD)?)?;
        if head.first > head.end || head.end > head.settings()?.trials {
            return Err(ShardError::NotAShard("trials of the campaign".into()));
        }
        Ok(Self { file, head })
    }

    /// What the part belongs to.
    pub fn head(&self) -> &ShardHead {
        &self.head
    }

    /// The statistics.
    ///
    /// # Errors
    /// [`ShardError`] where they are of another kind of campaign.
    pub fn summary<T: DeserializeOwned>(&self) -> Result<T, ShardError> {
        Ok(serde_json::from_str(metadata(&self.file, SUMMARY)?)?)
    }

    /// The rows, a row group at a time, in their order.
    pub fn tables(&self) -> impl Iterator<Item = Result<Table, ShardError>> {
        (0..self.file.num_row_groups()).map(|group| undamaged(ShardError::Damaged, || self.table(group)))
    }

    fn table(&self, group: usize) -> Result<Table, ShardError> {
        let group = self.file.get_row_group(group)?;
        let rows = usize::try_from(group.metadata().num_rows()).unwrap_or_default();
        let fields = self.file.metadata().file_metadata().schema().get_fields();
        let column = |(place, field): (usize, &Arc<Type>)| {
            if !field.is_primitive() {
                return Err(ShardError::NotAShard("a plain column".into()));
            }
            let reader = group.get_column_reader(place)?;
            let values = match field.get_physical_type() {
                PhysicalType::BYTE_ARRAY => {
                    let texts = optional(&mut get_typed_column_reader::<ByteArrayType>(reader), rows)?;
                    let text =
                        |bytes: ByteArray| bytes.as_utf8().map(str::to_owned).map_err(ShardError::from);
                    let texts = texts.into_iter().map(|bytes| bytes.map(text).transpose());
                    Values::Text(texts.collect::<Result<_, _>>()?)
                }
                PhysicalType::DOUBLE => {
                    Values::Number(optional(&mut get_typed_column_reader::<DoubleType>(reader), rows)?)
                }
                PhysicalType::INT64 => {
                    let mut values = Vec::new();
                    let mut reader = get_typed_column_reader::<Int64Type>(reader);
                    reader.read_records(rows, None, None, &mut values)?;
                    Values::Whole(values)
                }
                _ => return Err(ShardError::NotAShard("text, whole numbers or numbers".into())),
            };
            if values.len() != rows {
                return Err(ShardError::NotAShard("columns of the same length".into()));
            }
            Ok((field.name().to_owned(), values))
        };
        Ok(Table { columns: fields.iter().enumerate().map(column).collect::<Result<_, _>>()? })
    }
}

/// What is read of a file; the reader panics at some files whose bytes are not those that were written.
pub(crate) fn undamaged<T, E>(damaged: E, read: impl FnOnce() -> Result<T, E>) -> Result<T, E> {
    catch_unwind(AssertUnwindSafe(read)).unwrap_or(Err(damaged))
}

fn metadata<'a>(file: &'a SerializedFileReader<File>, key: &'static str) -> Result<&'a str, ShardError> {
    let pairs = file.metadata().file_metadata().key_value_metadata();
    let pair = pairs.into_iter().flatten().find(|pair| pair.key == key);
    pair.and_then(|pair| pair.value.as_deref()).ok_or(ShardError::NotAShard(key.into()))
}

/// Values of an optional column, null where there is none.
fn optional<T: DataType>(
    reader: &mut ColumnReaderImpl<T>,
    rows: usize,
) -> Result<Vec<Option<T::T>>, ShardError> {
    let (mut levels, mut values) = (Vec::new(), Vec::new());
    reader.read_records(rows, Some(&mut levels), None, &mut values)?;
    let mut values = values.into_iter();
    let there =
        levels.into_iter().map(|level| if level == 0 { Ok(None) } else { values.next().map(Some).ok_or(()) });
    there.collect::<Result<_, ()>>().map_err(|()| ShardError::NotAShard("as many values as levels".into()))
}
