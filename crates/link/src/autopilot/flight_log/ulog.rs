//! The ULog container, as PX4 writes it: header, definitions (formats, information, parameters,
//! subscriptions), data.
//!
//! Layout: <https://docs.px4.io/main/en/dev_log/ulog_file_format>. All numbers are little-endian. A message
//! is its length (u16, without these three bytes), its type (one letter) and its body. What a topic's rows
//! hold is given by one function that names and writes the fields in one go ([`Row`]), so that format and
//! data cannot differ.

use std::io::{self, Write};

/// A kind of row: its name in PX4's terms, how often it is written, and its fields after the time stamp.
pub struct Topic<R> {
    /// Name of the topic, as tools look for it.
    pub name: &'static str,
    /// Least time between two rows [us]; 0 writes each.
    pub period_us: u64,
    /// Names and writes the fields.
    pub fields: fn(&R, &mut Row),
}

/// A value of an information or parameter message.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scalar<'a> {
    /// A text; information only.
    Text(&'a str),
    /// A 32-bit integer.
    Int(i32),
    /// A 32-bit integer without a sign.
    Count(u32),
    /// A single-precision number.
    Float(f32),
}

/// One row in the making, or, for the format, only its fields' names.
#[derive(Debug, Default)]
pub struct Row {
    bytes: Vec<u8>,
    format: Option<String>,
}

macro_rules! scalar_field {
    ($name:ident, $type:ty, $ulog:literal) => {
        /// A field of this type.
        pub fn $name(&mut self, name: &str, value: $type) {
            self.declare(name, $ulog, None);
            self.bytes.extend_from_slice(&value.to_le_bytes());
        }
    };
}

impl Row {
    scalar_field!(u8, u8, "uint8_t");
    scalar_field!(u16, u16, "uint16_t");
    scalar_field!(u32, u32, "uint32_t");
    scalar_field!(u64, u64, "uint64_t");
    scalar_field!(f64, f64, "double");

    /// A truth value.
    pub fn bool(&mut self, name: &str, value: bool) {
        self.declare(name, "bool", None);
        self.bytes.push(u8::from(value));
    }

    /// A single-precision number.
    pub fn f32(&mut self, name: &str, value: f64) {
        self.declare(name, "float", None);
        self.bytes.extend_from_slice(&(value as f32).to_le_bytes());
    }

    /// An array of single-precision numbers.
    pub fn f32s(&mut self, name: &str, values: &[f64]) {
        self.declare(name, "float", Some(values.len()));
        for &value in values {
            self.bytes.extend_from_slice(&(value as f32).to_le_bytes());
        }
    }

    fn declare(&mut self, name: &str, kind: &str, length: Option<usize>) {
        if let Some(format) = &mut self.format {
            *format += &match length {
                Some(n) => format!("{kind}[{n}] {name};"),
                None => format!("{kind} {name};"),
            };
        }
    }
}

/// Writes a ULog to anything that takes bytes; give it a buffered writer.
#[derive(Debug)]
pub struct Ulog<W: Write> {
    out: W,
    /// Time of the last row of each topic [us].
    last: Vec<Option<u64>>,
    row: Row,
}

impl<W: Write> Ulog<W> {
    /// Begins a log at `start_us` since the vehicle's boot: header and definitions. `any` is any record;
    /// only the fields' names and lengths are taken from it.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn new<R>(
        out: W,
        start_us: u64,
        information: &[(&str, Scalar<'_>)],
        parameters: &[(String, Scalar<'_>)],
        topics: &[Topic<R>],
        any: &R,
    ) -> io::Result<Self> {
        let mut log = Self { out, last: vec![None; topics.len()], row: Row::default() };
        log.out.write_all(b"ULog\x01\x12\x35\x01")?;
        log.out.write_all(&start_us.to_le_bytes())?;
        // Flags: nothing incompatible, nothing appended.
        log.message(b'B', &[0; 40])?;
        for topic in topics {
            let mut row = Row { bytes: Vec::new(), format: Some(String::new()) };
            (topic.fields)(any, &mut row);
            let fields = row.format.unwrap_or_default();
            log.message(b'F', format!("{}:uint64_t timestamp;{fields}", topic.name).as_bytes())?;
        }
        for (key, value) in information {
            log.key_value(b'I', key, *value)?;
        }
        for (name, value) in parameters {
            log.key_value(b'P', name, *value)?;
        }
        for (id, topic) in topics.iter().enumerate() {
            let [low, high] = (id as u16).to_le_bytes();
            let body: Vec<u8> = [0, low, high].into_iter().chain(topic.name.bytes()).collect();
            log.message(b'A', &body)?;
        }
        Ok(log)
    }

    /// Writes a record's row of each topic that is due at `now_us`.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn write<R>(&mut self, now_us: u64, topics: &[Topic<R>], record: &R) -> io::Result<()> {
        for (id, topic) in topics.iter().enumerate() {
            if self.last[id].is_some_and(|last| now_us.saturating_sub(last) < topic.period_us) {
                continue;
            }
            self.last[id] = Some(now_us);
            let mut row = std::mem::take(&mut self.row);
            row.bytes.clear();
            row.bytes.extend_from_slice(&(id as u16).to_le_bytes());
            row.u64("timestamp", now_us);
            (topic.fields)(record, &mut row);
            let written = self.message(b'D', &row.bytes);
            self.row = row;
            written?;
        }
        Ok(())
    }

    /// Writes a text; `level` is syslog's, 0 emergency to 7 debug.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn text(&mut self, now_us: u64, level: u8, text: &str) -> io::Result<()> {
        let mut body = vec![b'0' + level.min(7)];
        body.extend_from_slice(&now_us.to_le_bytes());
        body.extend_from_slice(text.as_bytes());
        self.message(b'L', &body)
    }

    /// Writes a parameter that has changed.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn parameter(&mut self, name: &str, value: Scalar<'_>) -> io::Result<()> {
        self.key_value(b'P', name, value)
    }

    /// Marks a gap of `missing_ms` in the data.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn dropout(&mut self, missing_ms: u16) -> io::Result<()> {
        self.message(b'O', &missing_ms.to_le_bytes())
    }

    /// The writer, flushed.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn finish(mut self) -> io::Result<W> {
        self.out.flush()?;
        Ok(self.out)
    }

    fn key_value(&mut self, letter: u8, key: &str, value: Scalar<'_>) -> io::Result<()> {
        let (kind, bytes) = match value {
            Scalar::Text(text) => (format!("char[{}]", text.len()), text.as_bytes().to_vec()),
            Scalar::Int(value) => ("int32_t".to_owned(), value.to_le_bytes().to_vec()),
            Scalar::Count(value) => ("uint32_t".to_owned(), value.to_le_bytes().to_vec()),
            Scalar::Float(value) => ("float".to_owned(), value.to_le_bytes().to_vec()),
        };
        let key = format!("{kind} {key}");
        let key = &key.as_bytes()[..key.len().min(usize::from(u8::MAX))];
        let mut body = vec![key.len() as u8];
        body.extend_from_slice(key);
        body.extend_from_slice(&bytes);
        self.message(letter, &body)
    }

    /// A body longer than a message can be is cut: texts are the only ones without a fixed length.
    fn message(&mut self, letter: u8, body: &[u8]) -> io::Result<()> {
        let body = &body[..body.len().min(usize::from(u16::MAX))];
        self.out.write_all(&(body.len() as u16).to_le_bytes())?;
        self.out.write_all(&[letter])?;
        self.out.write_all(body)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TOPICS: [Topic<f64>; 2] = [
        Topic {
            name: "a",
            period_us: 0,
            fields: |x, row| {
                row.f32s("q", &[*x, 2.0]);
                row.bool("ok", true);
            },
        },
        Topic { name: "slow", period_us: 10_000, fields: |x, row| row.f64("x", *x) },
    ];

    /// The layout of PX4's specification, byte by byte.
    #[test]
    fn reference_layout_of_header_definitions_and_data() {
        let information = [("sys_name", Scalar::Text("samara"))];
        let parameters = [("MC_PITCH_P".to_owned(), Scalar::Float(6.5))];
        let mut log = Ulog::new(Vec::new(), 7, &information, &parameters, &TOPICS, &0.0).unwrap();
        log.write(8_000, &TOPICS, &1.0).unwrap();
        log.write(12_000, &TOPICS, &1.5).unwrap();
        log.text(12_000, 6, "armed").unwrap();
        let bytes = log.finish().unwrap();
        let mut at = 16;
        assert_eq!(bytes[..16], *b"ULog\x01\x12\x35\x01\x07\0\0\0\0\0\0\0");
        let mut next = || {
            let length = usize::from(u16::from_le_bytes([bytes[at], bytes[at + 1]]));
            let message = (bytes[at + 2], &bytes[at + 3..at + 3 + length]);
            at += 3 + length;
            message
        };
        assert_eq!(next(), (b'B', &[0u8; 40][..]));
        assert_eq!(next(), (b'F', &b"a:uint64_t timestamp;float[2] q;bool ok;"[..]));
        assert_eq!(next(), (b'F', &b"slow:uint64_t timestamp;double x;"[..]));
        assert_eq!(next(), (b'I', &b"\x10char[6] sys_namesamara"[..]));
        assert_eq!(next(), (b'P', &b"\x10float MC_PITCH_P\0\0\xD0\x40"[..]));
        assert_eq!(next(), (b'A', &b"\0\0\0a"[..]));
        assert_eq!(next(), (b'A', &b"\0\x01\0slow"[..]));
        assert_eq!(next(), (b'D', &b"\0\0\x40\x1F\0\0\0\0\0\0\0\0\x80\x3F\0\0\0\x40\x01"[..]));
        assert_eq!(next(), (b'D', &b"\x01\0\x40\x1F\0\0\0\0\0\0\0\0\0\0\0\0\xF0\x3F"[..]));
        assert_eq!(next().0, b'D', "the slow topic is not due after 4 ms");
        assert_eq!(next(), (b'L', &b"6\xE0\x2E\0\0\0\0\0\0armed"[..]));
        assert_eq!(at, bytes.len());
    }
}
