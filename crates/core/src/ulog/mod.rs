//! PX4's flight logs (ULog), read.
//!
//! Layout: <https://docs.px4.io/main/en/dev_log/ulog_file_format>. A log that was cut off, or in which bytes
//! are wrong, is read as far as it goes, and says which bytes were passed over ([`Ulog::lost`]). Rows stay
//! where they are in the file and are read when they are asked for: what is kept beside the file is a place
//! for each row.
//!
//! | file | holds |
//! |---|---|
//! | this one | a log: what it says of itself, its topics |
//! | `format` | what the rows of a topic hold |
//! | `walk` | message by message through the file, past what is wrong in it |

mod format;
mod walk;

#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::ops::Range;

pub use format::Value;
use format::{Format, Kind, Layout};
use walk::{Message, Walk};

/// The first bytes of each log; a byte with the version of the format follows, and the time of its start.
pub const MAGIC: [u8; 7] = [b'U', b'L', b'o', b'g', 0x01, 0x12, 0x35];
const HEADER: usize = 16;
/// Bytes of the flags: eight that may be unknown, eight that may not, and three places in the file.
const FLAGS: usize = 40;

/// Bytes are no log.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum UlogError {
    /// It does not begin as one.
    #[error("no ULog: it begins with {found}, and `ULog` and its version are expected")]
    Magic {
        /// The first bytes, as they are shown.
        found: String,
    },
    /// It has flags of a later format, which say that it cannot be read by this one.
    #[error("a ULog of a later format: incompatible flag {flag:#04x} in byte {byte} of its flags")]
    Later {
        /// The flag.
        flag: u8,
        /// In which of the eight bytes, from 0.
        byte: usize,
    },
}

/// A parameter's value, in one of PX4's two types.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Parameter {
    /// 32-bit integer.
    Int(i32),
    /// Single precision.
    Real(f32),
}

/// A text of the vehicle's.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Text {
    /// Time since the vehicle's start [us].
    pub time_us: u64,
    /// Severity, 0 (emergency) to 7 (debug).
    pub level: u8,
    /// The text.
    pub text: String,
}

/// A topic: an instance of a uORB message with its rows.
#[derive(Clone, Debug)]
pub struct Topic {
    /// Name of the message.
    pub name: String,
    /// Number of the instance, from 0.
    pub instance: u8,
    layout: Layout,
    /// Where each row's fields begin in the file.
    rows: Vec<usize>,
}

/// A log.
#[derive(Clone, Debug)]
pub struct Ulog<'a> {
    bytes: &'a [u8],
    /// Time of its start since the vehicle's [us].
    pub start_us: u64,
    /// Facts that the log states: `sys_name`, `ver_hw`, `ver_sw_release`, ..
    pub information: BTreeMap<String, Value>,
    /// Parameters as they were at its start.
    pub parameters: BTreeMap<String, Parameter>,
    /// Parameters that were changed later: time of the row before [us], name, value.
    pub changed: Vec<(u64, String, Parameter)>,
    /// Texts of the vehicle's, in the file's order.
    pub texts: Vec<Text>,
    /// Rows that PX4 could not write in time: time of the row before [us], and for how long [ms].
    pub dropouts: Vec<(u64, u16)>,
    /// Bytes of the file that are no messages.
    pub lost: Vec<Range<usize>>,
    topics: Vec<Topic>,
}

impl<'a> Ulog<'a> {
    /// Whether bytes begin as a log.
    pub fn is_one(bytes: &[u8]) -> bool {
        bytes.starts_with(&MAGIC)
    }

    /// Reads a log.
    ///
    /// # Errors
    /// [`UlogError`] for what is none.
    pub fn read(bytes: &'a [u8]) -> Result<Self, UlogError> {
        let start = bytes.get(8..HEADER).and_then(|time| time.try_into().ok());
        let (true, Some(start)) = (Self::is_one(bytes), start) else {
            let found = bytes.get(..bytes.len().min(8)).unwrap_or_default().escape_ascii().to_string();
            return Err(UlogError::Magic { found: if found.is_empty() { "nothing".into() } else { found } });
        };
        let mut reading = Reading {
            log: Self {
                bytes,
                start_us: u64::from_le_bytes(start),
                information: BTreeMap::new(),
                parameters: BTreeMap::new(),
                changed: Vec::new(),
                texts: Vec::new(),
                dropouts: Vec::new(),
                lost: Vec::new(),
                topics: Vec::new(),
            },
            formats: BTreeMap::new(),
            subscribed: BTreeMap::new(),
            newest_us: u64::from_le_bytes(start),
            has_data: false,
        };
        let mut begin = HEADER;
        for end in appended(bytes)?.into_iter().chain([bytes.len()]) {
            let mut walk = Walk::new(bytes, begin..end);
            while let Some(message) = walk.next(&|id, size| reading.fits(id, size)) {
                reading.take(&message);
            }
            reading.log.lost.extend(walk.lost);
            begin = end;
        }
        Ok(reading.log)
    }

    /// The topics that have rows, in the order of their subscription.
    pub fn topics(&self) -> impl Iterator<Item = &Topic> {
        self.topics.iter().filter(|topic| !topic.rows.is_empty())
    }

    /// The first instance of a topic that has rows.
    pub fn topic(&self, name: &str) -> Option<&Topic> {
        self.topics().find(|topic| topic.name == name)
    }

    /// Messages of data.
    pub fn rows(&self) -> usize {
        self.topics.iter().map(|topic| topic.rows.len()).sum()
    }

    /// A fact that the log states by a name, where that is a text.
    pub fn text(&self, name: &str) -> Option<&str> {
        match self.information.get(name)? {
            Value::Text(text) => Some(text),
            _ => None,
        }
    }

    /// Version of the autopilot's software: major, minor, patch, kind of release, a byte each.
    pub fn release(&self) -> Option<[u8; 4]> {
        match self.information.get("ver_sw_release")? {
            Value::Whole(number) => u32::try_from(*number).ok().map(u32::to_be_bytes),
            _ => None,
        }
    }

    /// The values of a topic's column, in the file's order; none where it has no such column. Times are
    /// `timestamp`, in microseconds; elements of arrays `q[0]`, fields of inner messages `esc[0].esc_rpm`.
    pub fn values<'t>(
        &self,
        topic: &'t Topic,
        column: &str,
    ) -> Option<impl Iterator<Item = f64> + use<'a, 't>> {
        let column = topic.layout.column(column)?;
        let bytes = self.bytes;
        Some(topic.rows.iter().map(move |row| column.value(bytes.get(*row..).unwrap_or_default())))
    }

    /// How many bytes of the file are no messages.
    pub fn lost_bytes(&self) -> usize {
        self.lost.iter().map(|part| part.len()).sum()
    }

    /// Times of a topic's rows since the vehicle's start [us].
    pub fn times_us(&self, topic: &Topic) -> Vec<u64> {
        let times = topic.layout.column("timestamp").map(|column| {
            let time = |row: &usize| column.time(self.bytes.get(*row..).unwrap_or_default());
            topic.rows.iter().map(time).collect()
        });
        times.unwrap_or_default()
    }
}

impl Topic {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether it has no rows.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Names of its columns, in the file's order.
    pub fn columns(&self) -> impl Iterator<Item = &str> {
        self.layout.columns.keys().map(String::as_str)
    }
}

/// Where parts begin that were appended to a log, whatever is cut off before them, by its flags, which are
/// its first message.
fn appended(bytes: &[u8]) -> Result<Vec<usize>, UlogError> {
    /// Data were appended.
    const APPENDED: u8 = 1;
    let Some([_, _, b'B', flags @ ..]) = bytes.get(HEADER..).filter(|rest| rest.len() >= 3 + FLAGS) else {
        return Ok(Vec::new());
    };
    for (byte, flags) in flags.iter().skip(8).take(8).enumerate() {
        let unknown = flags & !if byte == 0 { APPENDED } else { 0 };
        if unknown != 0 {
            return Err(UlogError::Later { flag: unknown, byte });
        }
    }
    let offsets = flags.get(16..FLAGS).unwrap_or_default().chunks_exact(8);
    let offsets = offsets.filter_map(|offset| {
        let offset = usize::try_from(u64::from_le_bytes(offset.try_into().ok()?)).ok()?;
        (HEADER..bytes.len()).contains(&offset).then_some(offset)
    });
    let mut offsets: Vec<usize> = offsets.collect();
    offsets.sort_unstable();
    Ok(offsets)
}

/// A log that is being read.
struct Reading<'a> {
    log: Ulog<'a>,
    formats: BTreeMap<String, Format>,
    /// By number of the subscription, the place of its topic.
    subscribed: BTreeMap<u16, usize>,
    newest_us: u64,
    has_data: bool,
}

impl Reading<'_> {
    /// Whether rows of this subscription may have so many bytes.
    fn fits(&self, id: u16, size: usize) -> bool {
        let topic = self.subscribed.get(&id).and_then(|place| self.log.topics.get(*place));
        topic.is_some_and(|topic| topic.layout.sizes.contains(&size))
    }

    fn take(&mut self, message: &Message) {
        let bytes = self.log.bytes;
        let body = bytes.get(message.body.clone()).unwrap_or_default();
        match message.kind {
            b'F' => {
                let format = std::str::from_utf8(body).ok().and_then(Format::parse);
                self.formats.extend(format);
            }
            b'A' => self.subscribe(body),
            b'D' => self.take_row(message.body.start, body),
            b'I' => self.log.information.extend(information(body)),
            b'P' => self.take_parameter(body),
            b'L' => self.take_text(body, 9),
            // With a tag behind its level.
            b'C' => self.take_text(body, 11),
            b'O' => {
                let lasted = body.try_into().map(u16::from_le_bytes);
                self.log.dropouts.extend(lasted.map(|lasted_ms| (self.newest_us, lasted_ms)));
            }
            // Flags, several values of one name, defaults of parameters, ends of subscriptions, marks.
            _ => {}
        }
    }

    fn subscribe(&mut self, body: &[u8]) {
        let [instance, low, high, name @ ..] = body else { return };
        let Some(layout) = std::str::from_utf8(name).ok().and_then(|name| Layout::of(name, &self.formats))
        else {
            return;
        };
        self.subscribed.insert(u16::from_le_bytes([*low, *high]), self.log.topics.len());
        let name = String::from_utf8_lossy(name).into_owned();
        self.log.topics.push(Topic { name, instance: *instance, layout, rows: Vec::new() });
    }

    fn take_row(&mut self, at: usize, body: &[u8]) {
        let [low, high, fields @ ..] = body else { return };
        let place = self.subscribed.get(&u16::from_le_bytes([*low, *high]));
        let Some(topic) = place.and_then(|place| self.log.topics.get_mut(*place)) else { return };
        topic.rows.push(at + 2);
        if let Some(column) = topic.layout.column("timestamp") {
            self.newest_us = column.time(fields);
        }
        self.has_data = true;
    }

    fn take_parameter(&mut self, body: &[u8]) {
        let Some((kind, name, value)) = keyed(body) else { return };
        let Ok(value) = <[u8; 4]>::try_from(value) else { return };
        let value = match kind {
            "int32_t" => Parameter::Int(i32::from_le_bytes(value)),
            "float" => Parameter::Real(f32::from_le_bytes(value)),
            _ => return,
        };
        if self.has_data {
            self.log.changed.push((self.newest_us, name.to_owned(), value));
        } else {
            self.log.parameters.insert(name.to_owned(), value);
        }
    }

    fn take_text(&mut self, body: &[u8], head: usize) {
        let Some((head, text)) = body.split_at_checked(head) else { return };
        let time = head.last_chunk::<8>().copied().map_or(0, u64::from_le_bytes);
        let level = head.first().map_or(7, |level| level.wrapping_sub(b'0').min(7));
        let text = String::from_utf8_lossy(text).into_owned();
        self.log.texts.push(Text { time_us: time, level, text });
    }
}

/// Type, name and value of `char[5] sys_name` and its like, behind the length of that text.
fn keyed(body: &[u8]) -> Option<(&str, &str, &[u8])> {
    let (length, rest) = body.split_first()?;
    let (key, value) = rest.split_at_checked(usize::from(*length))?;
    let (kind, name) = std::str::from_utf8(key).ok()?.split_once(' ')?;
    Some((kind, name, value))
}

fn information(body: &[u8]) -> Option<(String, Value)> {
    let (kind, name, bytes) = keyed(body)?;
    let value = match kind.split_once('[') {
        Some(("char", _)) => Value::Text(String::from_utf8_lossy(bytes).trim_end_matches('\0').to_owned()),
        _ => Kind::of(kind)?.read(bytes)?,
    };
    Some((name.to_owned(), value))
}
