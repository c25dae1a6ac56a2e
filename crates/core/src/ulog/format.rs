//! What the rows of a topic hold: fields of numbers, arrays of them, and messages within messages.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;

/// Messages within messages go no deeper.
const DEEPEST: usize = 8;
/// A row has no more bytes: a message's length is of 16 bits, and its first three are the subscription's.
const LONGEST: usize = u16::MAX as usize;

/// A value of what a log says of itself.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A text.
    Text(String),
    /// A whole number.
    Whole(i128),
    /// A real number.
    Real(f64),
}

/// Type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// `int8_t`.
    I8,
    /// `uint8_t`.
    U8,
    /// `int16_t`.
    I16,
    /// `uint16_t`.
    U16,
    /// `int32_t`.
    I32,
    /// `uint32_t`.
    U32,
    /// `int64_t`.
    I64,
    /// `uint64_t`.
    U64,
    /// `float`.
    F32,
    /// `double`.
    F64,
    /// `bool`.
    Bool,
    /// `char`.
    Char,
}

macro_rules! read_as {
    ($type:ty, $bytes:expr) => {
        $bytes.first_chunk().copied().map(<$type>::from_le_bytes)
    };
}

impl Kind {
    /// The type of this name.
    pub(super) fn of(name: &str) -> Option<Self> {
        Some(match name {
            "int8_t" => Self::I8,
            "uint8_t" => Self::U8,
            "int16_t" => Self::I16,
            "uint16_t" => Self::U16,
            "int32_t" => Self::I32,
            "uint32_t" => Self::U32,
            "int64_t" => Self::I64,
            "uint64_t" => Self::U64,
            "float" => Self::F32,
            "double" => Self::F64,
            "bool" => Self::Bool,
            "char" => Self::Char,
            _ => return None,
        })
    }

    /// Bytes of a number.
    const fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 | Self::Bool | Self::Char => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// The number that bytes begin with.
    pub(super) fn read(self, bytes: &[u8]) -> Option<Value> {
        Some(match self {
            Self::I8 => Value::Whole(read_as!(i8, bytes)?.into()),
            Self::U8 | Self::Bool | Self::Char => Value::Whole(read_as!(u8, bytes)?.into()),
            Self::I16 => Value::Whole(read_as!(i16, bytes)?.into()),
            Self::U16 => Value::Whole(read_as!(u16, bytes)?.into()),
            Self::I32 => Value::Whole(read_as!(i32, bytes)?.into()),
            Self::U32 => Value::Whole(read_as!(u32, bytes)?.into()),
            Self::I64 => Value::Whole(read_as!(i64, bytes)?.into()),
            Self::U64 => Value::Whole(read_as!(u64, bytes)?.into()),
            Self::F32 => Value::Real(read_as!(f32, bytes)?.into()),
            Self::F64 => Value::Real(read_as!(f64, bytes)?),
        })
    }
}

/// A format as the file defines it: its fields' types, as they are written, and names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Format(Vec<Field>);

#[derive(Clone, Debug, PartialEq, Eq)]
struct Field {
    kind: String,
    name: String,
    /// Of an array; `None`: no array.
    length: Option<usize>,
}

impl Format {
    /// Reads `vehicle_attitude:uint64_t timestamp;float[4] q;`: name and format.
    pub(super) fn parse(text: &str) -> Option<(String, Self)> {
        let (name, fields) = text.split_once(':')?;
        let field = |field: &str| {
            let (kind, name) = field.split_once(' ')?;
            let (kind, length) = match kind.split_once('[') {
                None => (kind, None),
                Some((kind, length)) => {
                    let length = length.strip_suffix(']')?.parse().ok()?;
                    (kind, Some(length).filter(|length| (1..=LONGEST).contains(length)).map(Some)?)
                }
            };
            Some(Field { kind: kind.to_owned(), name: name.to_owned(), length })
        };
        let fields: Option<Vec<Field>> = fields.split_terminator(';').map(field).collect();
        Some((name.to_owned(), Self(fields?)))
    }
}

/// A number of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Column {
    /// Type of the number.
    pub kind: Kind,
    /// Where it is in the row.
    at: usize,
}

impl Column {
    /// The number of a row, whose bytes these begin with; NaN where they are too few.
    pub(super) fn value(self, row: &[u8]) -> f64 {
        match row.get(self.at..).and_then(|bytes| self.kind.read(bytes)) {
            Some(Value::Real(x)) => x,
            Some(Value::Whole(n)) => n as f64,
            Some(Value::Text(_)) | None => f64::NAN,
        }
    }

    /// The time of a row [us]; 0 where it is none.
    pub(super) fn time(self, row: &[u8]) -> u64 {
        match row.get(self.at..).and_then(|bytes| self.kind.read(bytes)) {
            Some(Value::Whole(time)) => u64::try_from(time).unwrap_or_default(),
            _ => 0,
        }
    }
}

/// The columns of a topic's rows.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    /// By name, in the order of the alphabet.
    pub(super) columns: BTreeMap<String, Column>,
    /// Bytes that a message of such a row may have: padding at its end is left out by PX4.
    pub(super) sizes: RangeInclusive<usize>,
}

impl Layout {
    /// The layout of a message of this name; `None` where its format is not there, or too large for a
    /// message.
    pub(super) fn of(name: &str, formats: &BTreeMap<String, Format>) -> Option<Self> {
        let mut columns = BTreeMap::new();
        let end = lay_out(formats.get(name)?, formats, ("", 0, 0), &mut columns)?;
        let padding = formats.get(name)?.0.last().filter(|field| is_padding(field));
        let padding = padding.map_or(0, |field| field.length.unwrap_or(1));
        // Behind the number of the subscription.
        Some(Self { columns, sizes: end.checked_sub(padding)? + 2..=end + 2 })
    }

    pub(super) fn column(&self, name: &str) -> Option<Column> {
        self.columns.get(name).copied()
    }
}

fn is_padding(field: &Field) -> bool {
    field.name.starts_with("_padding")
}

/// Lays fields out from a place on, under names that begin so; the place behind them.
fn lay_out(
    format: &Format,
    formats: &BTreeMap<String, Format>,
    (prefix, begin, depth): (&str, usize, usize),
    columns: &mut BTreeMap<String, Column>,
) -> Option<usize> {
    let mut at = begin;
    for field in &format.0 {
        for place in 0..field.length.unwrap_or(1) {
            let name = match field.length {
                None => format!("{prefix}{}", field.name),
                Some(_) => format!("{prefix}{}[{place}]", field.name),
            };
            at = match Kind::of(&field.kind) {
                Some(kind) => {
                    if !is_padding(field) {
                        columns.insert(name, Column { kind, at });
                    }
                    at + kind.size()
                }
                None if depth < DEEPEST => {
                    let inner = formats.get(&field.kind)?;
                    lay_out(inner, formats, (&format!("{name}."), at, depth + 1), columns)?
                }
                None => return None,
            };
            if at > LONGEST {
                return None;
            }
        }
    }
    Some(at)
}
