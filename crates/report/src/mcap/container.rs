//! The MCAP container, <https://mcap.dev/spec>: records in chunks without compression, then a summary by
//! which readers find each record without reading the file.
//!
//! Only what a writer needs. Each number is little-endian, a text or a list bears its length in bytes before
//! it. Every checksum of the format is there: of a chunk, of an attachment, of the data and of the summary.

use std::collections::BTreeMap;
use std::io::{self, Write};

const MAGIC: [u8; 8] = [0x89, b'M', b'C', b'A', b'P', b'0', b'\r', b'\n'];
/// A chunk is written once it is longer [bytes].
const CHUNK: usize = 1 << 20;

/// Kinds of records.
#[derive(Clone, Copy)]
#[repr(u8)]
enum Op {
    Header = 0x01,
    Footer = 0x02,
    Schema = 0x03,
    Channel = 0x04,
    Message = 0x05,
    Chunk = 0x06,
    MessageIndex = 0x07,
    ChunkIndex = 0x08,
    Attachment = 0x09,
    AttachmentIndex = 0x0A,
    Statistics = 0x0B,
    Metadata = 0x0C,
    MetadataIndex = 0x0D,
    SummaryOffset = 0x0E,
    DataEnd = 0x0F,
}

/// Fields of a record, in bytes.
#[derive(Debug, Default)]
struct Fields(Vec<u8>);

impl Fields {
    fn u16(mut self, x: u16) -> Self {
        self.0.extend(x.to_le_bytes());
        self
    }

    fn u32(mut self, x: u32) -> Self {
        self.0.extend(x.to_le_bytes());
        self
    }

    fn u64(mut self, x: u64) -> Self {
        self.0.extend(x.to_le_bytes());
        self
    }

    /// Bytes, or items one after another, with their length in 32 bits before them.
    fn bytes(self, bytes: &[u8]) -> Self {
        let mut fields = self.u32(bytes.len() as u32);
        fields.0.extend(bytes);
        fields
    }

    fn text(self, text: &str) -> Self {
        self.bytes(text.as_bytes())
    }

    /// Bytes with their length in 64 bits before them.
    fn long(self, bytes: &[u8]) -> Self {
        let mut fields = self.u64(bytes.len() as u64);
        fields.0.extend(bytes);
        fields
    }

    fn texts(self, pairs: &[(&str, String)]) -> Self {
        let map = pairs.iter().fold(Self::default(), |map, (key, value)| map.text(key).text(value));
        self.bytes(&map.0)
    }

    /// A number for each channel.
    fn per_channel(self, numbers: &BTreeMap<u16, u64>) -> Self {
        let map = numbers.iter().fold(Self::default(), |map, (channel, n)| map.u16(*channel).u64(*n));
        self.bytes(&map.0)
    }
}

/// A record: kind, length and fields.
fn record(op: Op, fields: &Fields) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(fields.0.len() + 9);
    bytes.push(op as u8);
    bytes.extend((fields.0.len() as u64).to_le_bytes());
    bytes.extend(&fields.0);
    bytes
}

/// A channel: what its messages are about and how they are written.
#[derive(Clone, Copy, Debug)]
pub(super) struct Channel<'a> {
    /// Name.
    pub topic: &'a str,
    /// Name of the messages' type.
    pub schema: &'a str,
    /// The type, as a FileDescriptorSet of Protocol Buffers.
    pub descriptors: &'a [u8],
}

/// Writes an MCAP file of protobuf messages.
#[derive(Debug)]
pub(super) struct McapWriter<W: Write> {
    out: W,
    /// Bytes that were written.
    at: u64,
    /// Checksum of them.
    crc: Crc32,
    chunk: Vec<u8>,
    /// First and last time [ns] of the chunk's messages.
    times: Option<(u64, u64)>,
    /// Time [ns] and place of the chunk's messages, for each channel.
    index: BTreeMap<u16, Vec<(u64, u64)>>,
    /// Names and records of the schemas.
    schemas: Vec<(String, Vec<u8>)>,
    /// Records for the summary.
    channels: Vec<u8>,
    chunks: Vec<u8>,
    attachments: Vec<u8>,
    metadata: Vec<u8>,
    /// How many there are of them.
    counts: Counts,
}

#[derive(Clone, Debug, Default)]
struct Counts {
    chunks: u32,
    attachments: u32,
    metadata: u32,
    messages: BTreeMap<u16, u64>,
    /// First and last time [ns].
    times: Option<(u64, u64)>,
}

/// A span of time with `t` in it.
fn widened(times: Option<(u64, u64)>, t: u64) -> Option<(u64, u64)> {
    Some(times.map_or((t, t), |(first, last)| (first.min(t), last.max(t))))
}

impl<W: Write> McapWriter<W> {
    /// Begins a file; `library`: the program that writes it. `out` should be buffered.
    pub(super) fn new(out: W, library: &str) -> io::Result<Self> {
        let mut writer = Self {
            out,
            at: 0,
            crc: Crc32::default(),
            chunk: Vec::with_capacity(CHUNK + CHUNK / 8),
            times: None,
            index: BTreeMap::new(),
            schemas: Vec::new(),
            channels: Vec::new(),
            chunks: Vec::new(),
            attachments: Vec::new(),
            metadata: Vec::new(),
            counts: Counts::default(),
        };
        writer.put(&MAGIC)?;
        writer.put(&record(Op::Header, &Fields::default().text("").text(library)))?;
        Ok(writer)
    }

    fn put(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.out.write_all(bytes)?;
        self.crc.update(bytes);
        self.at += bytes.len() as u64;
        Ok(())
    }

    /// Adds a channel and returns its number.
    pub(super) fn channel(&mut self, channel: &Channel<'_>) -> u16 {
        let id = self.counts.messages.len() as u16 + 1;
        self.counts.messages.insert(id, 0);
        let known = self.schemas.iter().position(|(name, _)| name == channel.schema);
        let schema_id = known.unwrap_or(self.schemas.len()) as u16 + 1;
        // Schema and channel stand before the channel's messages, in their chunk or an earlier one.
        if known.is_none() {
            let fields = Fields::default().u16(schema_id).text(channel.schema).text("protobuf");
            let schema = record(Op::Schema, &fields.bytes(channel.descriptors));
            self.chunk.extend(&schema);
            self.schemas.push((channel.schema.to_owned(), schema));
        }
        let fields = Fields::default().u16(id).u16(schema_id).text(channel.topic).text("protobuf");
        let fields = record(Op::Channel, &fields.texts(&[]));
        self.chunk.extend(&fields);
        self.channels.extend(fields);
        id
    }

    /// Adds a message of a channel at a time [ns since 1970-01-01 UTC].
    pub(super) fn message(&mut self, channel: u16, time_ns: u64, data: &[u8]) -> io::Result<()> {
        let sequence = self.counts.messages.entry(channel).or_default();
        let fields = Fields::default().u16(channel).u32(*sequence as u32).u64(time_ns).u64(time_ns);
        *sequence += 1;
        self.index.entry(channel).or_default().push((time_ns, self.chunk.len() as u64));
        self.chunk.push(Op::Message as u8);
        self.chunk.extend(((fields.0.len() + data.len()) as u64).to_le_bytes());
        self.chunk.extend(fields.0);
        self.chunk.extend(data);
        self.times = widened(self.times, time_ns);
        self.counts.times = widened(self.counts.times, time_ns);
        if self.chunk.len() > CHUNK { self.end_chunk() } else { Ok(()) }
    }

    fn end_chunk(&mut self) -> io::Result<()> {
        let (first, last) = self.times.take().unwrap_or_default();
        let (begin, size) = (self.at, self.chunk.len() as u64);
        let mut crc = Crc32::default();
        crc.update(&self.chunk);
        let fields = Fields::default().u64(first).u64(last).u64(size).u32(crc.value()).text("");
        let chunk = record(Op::Chunk, &fields.long(&self.chunk));
        self.chunk.clear();
        self.put(&chunk)?;
        let indexed_from = self.at;
        let mut offsets = BTreeMap::new();
        for (channel, entries) in std::mem::take(&mut self.index) {
            offsets.insert(channel, self.at);
            let list =
                entries.iter().fold(Fields::default(), |list, (time, place)| list.u64(*time).u64(*place));
            self.put(&record(Op::MessageIndex, &Fields::default().u16(channel).bytes(&list.0)))?;
        }
        let fields = Fields::default().u64(first).u64(last).u64(begin).u64(indexed_from - begin);
        let fields = fields.per_channel(&offsets).u64(self.at - indexed_from).text("").u64(size).u64(size);
        self.chunks.extend(record(Op::ChunkIndex, &fields));
        self.counts.chunks += 1;
        Ok(())
    }

    /// Attaches a file.
    pub(super) fn attach(
        &mut self,
        name: &str,
        media_type: &str,
        time_ns: u64,
        data: &[u8],
    ) -> io::Result<()> {
        let fields = Fields::default().u64(time_ns).u64(time_ns).text(name).text(media_type).long(data);
        let mut crc = Crc32::default();
        crc.update(&fields.0);
        let (begin, attachment) = (self.at, record(Op::Attachment, &fields.u32(crc.value())));
        let index = Fields::default().u64(begin).u64(attachment.len() as u64).u64(time_ns).u64(time_ns);
        let index = index.u64(data.len() as u64).text(name).text(media_type);
        self.attachments.extend(record(Op::AttachmentIndex, &index));
        self.counts.attachments += 1;
        self.put(&attachment)
    }

    /// Adds what is known of the whole file, by name.
    pub(super) fn metadata(&mut self, name: &str, pairs: &[(&str, String)]) -> io::Result<()> {
        let (begin, bytes) = (self.at, record(Op::Metadata, &Fields::default().text(name).texts(pairs)));
        let index = Fields::default().u64(begin).u64(bytes.len() as u64).text(name);
        self.metadata.extend(record(Op::MetadataIndex, &index));
        self.counts.metadata += 1;
        self.put(&bytes)
    }

    /// Ends the file with its summary and returns the output, flushed.
    pub(super) fn finish(mut self) -> io::Result<W> {
        if !self.chunk.is_empty() {
            self.end_chunk()?;
        }
        let data = self.crc.value();
        self.put(&record(Op::DataEnd, &Fields::default().u32(data)))?;
        self.crc = Crc32::default();
        let summary = self.at;
        let Counts { chunks, attachments, metadata, messages, times } = &self.counts;
        let (first, last) = times.unwrap_or_default();
        let (schemas, channels) = (self.schemas.len() as u16, messages.len() as u32);
        let statistics = Fields::default().u64(messages.values().sum()).u16(schemas).u32(channels);
        let statistics = statistics.u32(*attachments).u32(*metadata).u32(*chunks).u64(first).u64(last);
        let groups = [
            (Op::Schema, self.schemas.iter().flat_map(|(_, schema)| schema.clone()).collect()),
            (Op::Channel, std::mem::take(&mut self.channels)),
            (Op::Statistics, record(Op::Statistics, &statistics.per_channel(messages))),
            (Op::ChunkIndex, std::mem::take(&mut self.chunks)),
            (Op::AttachmentIndex, std::mem::take(&mut self.attachments)),
            (Op::MetadataIndex, std::mem::take(&mut self.metadata)),
        ];
        let mut offsets = Vec::new();
        for (op, group) in groups {
            let mut fields = Fields(vec![op as u8]).u64(self.at);
            fields = fields.u64(group.len() as u64);
            if !group.is_empty() {
                offsets.extend(record(Op::SummaryOffset, &fields));
            }
            self.put(&group)?;
        }
        let offsets_from = self.at;
        self.put(&offsets)?;
        // The summary's checksum covers the footer up to the checksum itself.
        let footer = Fields::default().u64(summary).u64(offsets_from);
        let mut head = vec![Op::Footer as u8];
        head.extend((footer.0.len() as u64 + 4).to_le_bytes());
        head.extend(footer.0);
        self.put(&head)?;
        let crc = self.crc.value();
        self.put(&crc.to_le_bytes())?;
        self.put(&MAGIC)?;
        self.out.flush()?;
        Ok(self.out)
    }
}

/// CRC-32 as in zip and PNG (ISO-HDLC), by the table of Sarwate.
#[derive(Clone, Copy, Debug)]
struct Crc32(u32);

const CRC_TABLE: [u32; 256] = {
    let mut table = [0; 256];
    let mut byte = 0;
    while byte < 256 {
        let mut crc = byte as u32;
        let mut bit = 0;
        while bit < 8 {
            crc = if crc & 1 == 1 { (crc >> 1) ^ 0xEDB8_8320 } else { crc >> 1 };
            bit += 1;
        }
        table[byte] = crc;
        byte += 1;
    }
    table
};

impl Default for Crc32 {
    fn default() -> Self {
        Self(u32::MAX)
    }
}

impl Crc32 {
    fn update(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = CRC_TABLE[usize::from(self.0 as u8 ^ byte)] ^ (self.0 >> 8);
        }
    }

    fn value(self) -> u32 {
        !self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The check value of CRC-32/ISO-HDLC in the catalogue of Greg Cook.
    #[test]
    fn reference_the_checksum_of_the_nine_digits() {
        let mut crc = Crc32::default();
        crc.update(b"1234");
        crc.update(b"56789");
        assert_eq!(crc.value(), 0xCBF4_3926);
    }

    /// Record by record as the specification has the format, read without the writer's code.
    #[test]
    fn the_file_is_made_of_the_records_of_the_specification() {
        let mut writer = McapWriter::new(Vec::new(), "test").unwrap();
        let channel = Channel { topic: "/a", schema: "x.A", descriptors: &[1, 2] };
        let a = writer.channel(&channel);
        let b = writer.channel(&Channel { topic: "/b", ..channel });
        writer.message(a, 5, &[7; 3]).unwrap();
        writer.message(b, 9, &vec![8; CHUNK]).unwrap();
        writer.message(a, 11, &[]).unwrap();
        writer.attach("a.txt", "text/plain", 5, b"hello").unwrap();
        writer.metadata("about", &[("key", "value".to_owned())]).unwrap();
        let file = writer.finish().unwrap();

        let long = |at: usize| u64::from_le_bytes(file[at..at + 8].try_into().unwrap()) as usize;
        assert!(file.starts_with(&MAGIC) && file.ends_with(&MAGIC));
        let (mut at, mut ops, mut places) = (8, Vec::new(), Vec::new());
        while at < file.len() - 8 {
            ops.push(file[at]);
            places.push(at);
            at += 9 + long(at + 1);
        }
        assert_eq!(at, file.len() - 8);
        // Header; two chunks with the index of each channel in them; attachment, metadata, end of the data;
        // the summary and where its groups begin; footer.
        let data = [0x01, 0x06, 0x07, 0x07, 0x09, 0x0C, 0x06, 0x07, 0x0F];
        let summary = [3, 4, 4, 0x0B, 8, 8, 0x0A, 0x0D, 0x0E, 0x0E, 0x0E, 0x0E, 0x0E, 0x0E, 0x02];
        assert_eq!(ops, [data.as_slice(), &summary].concat());
        let footer = *places.last().unwrap();
        assert_eq!(long(footer + 9), places[data.len()]);
        assert_eq!(file[long(footer + 17)], 0x0E);
        // The second message lies where the first chunk's index says: after the head of the chunk's records.
        let records = places[1] + 9 + 8 + 8 + 8 + 4 + 4 + 8;
        let entry = places[3] + 9 + 2 + 4;
        assert_eq!((long(entry), file[records + long(entry + 8)]), (9, 0x05));
        assert_eq!(file[records + long(entry + 8) + 9], b as u8);
    }
}
