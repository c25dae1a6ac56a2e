//! Logs made by hand from the description of the format, whole and broken.

use super::*;

/// A log in the making.
struct Log(Vec<u8>);

impl Log {
    fn new() -> Self {
        let mut bytes = MAGIC.to_vec();
        bytes.push(1);
        bytes.extend(1000_u64.to_le_bytes());
        let mut log = Self(bytes);
        log.put(b'B', &[0; 40]);
        log.put(b'F', b"pose:uint64_t timestamp;float[2] q;esc[2] esc;int8_t level;uint8_t[3] _padding0;");
        log.put(b'F', b"esc:uint16_t rpm;bool on;uint8_t[1] _padding0;");
        log.put(b'I', b"\x10char[5] sys_nameshort");
        log
    }

    fn put(&mut self, kind: u8, body: &[u8]) {
        self.0.extend((body.len() as u16).to_le_bytes());
        self.0.push(kind);
        self.0.extend(body);
    }

    fn parameter(&mut self, name: &str, value: [u8; 4]) {
        let key = [&[name.len() as u8][..], name.as_bytes(), &value].concat();
        self.put(b'P', &key);
    }

    fn subscribed(mut self) -> Self {
        self.put(b'A', b"\x00\x07\x00pose");
        self
    }

    /// A row, without the padding at its end.
    fn row(&mut self, time_us: u64, q: [f32; 2], rpm: [u16; 2], level: i8) {
        let mut body = 7_u16.to_le_bytes().to_vec();
        body.extend(time_us.to_le_bytes());
        q.iter().for_each(|x| body.extend(x.to_le_bytes()));
        rpm.iter().for_each(|n| body.extend([n.to_le_bytes()[0], n.to_le_bytes()[1], 1, 0]));
        body.extend(level.to_le_bytes());
        self.put(b'D', &body);
    }

    /// So many rows.
    fn rows(mut self, times: Range<u64>) -> Self {
        times.for_each(|i| self.row(2000 + 100 * i, [i as f32, -0.5], [i as u16, 9], -3));
        self
    }
}

fn column(log: &Ulog<'_>, name: &str) -> Vec<f64> {
    log.values(log.topic("pose").unwrap(), name).unwrap().collect()
}

/// The format's own description, by hand: nested messages, arrays, padding left out at the end.
#[test]
fn closed_form_rows_are_read_as_their_format_says() {
    let mut log = Log::new();
    log.parameter("int32_t SYS_ID", 7_i32.to_le_bytes());
    let mut log = log.subscribed().rows(0..3);
    log.parameter("float MPC_P", 0.5_f32.to_le_bytes());
    log.put(b'O', &40_u16.to_le_bytes());
    log.put(b'L', &[&b"4"[..], &2500_u64.to_le_bytes(), b"low battery"].concat());
    let read = Ulog::read(&log.0).unwrap();
    assert_eq!((read.start_us, read.rows(), read.lost.len()), (1000, 3, 0));
    assert_eq!(read.text("sys_name"), Some("short"));
    assert_eq!(read.parameters["SYS_ID"], Parameter::Int(7));
    assert_eq!(read.changed, [(2200, "MPC_P".to_owned(), Parameter::Real(0.5))]);
    assert_eq!(read.dropouts, [(2200, 40)]);
    assert_eq!(read.texts, [Text { time_us: 2500, level: 4, text: "low battery".to_owned() }]);
    assert_eq!(read.times_us(read.topic("pose").unwrap()), [2000, 2100, 2200]);
    assert_eq!(column(&read, "q[0]"), [0.0, 1.0, 2.0]);
    assert_eq!(column(&read, "esc[0].rpm"), [0.0, 1.0, 2.0]);
    assert_eq!(column(&read, "esc[1].on"), [1.0; 3]);
    assert_eq!(column(&read, "level"), [-3.0; 3]);
    let topic = read.topic("pose").unwrap();
    assert!(read.values(topic, "_padding0[0]").is_none() && read.values(topic, "q").is_none());
}

/// A row of a subscription that is not there, letters, and a length that leads beyond the next message: what
/// follows is read, and what is lost is told to the byte.
#[test]
fn what_is_wrong_is_passed_over_to_the_byte() {
    for wrong in [&b"\x05\x00D\x63\x00abc"[..], b"no message", b"\x40\x00D\x07\x00", &[0xFF; 300]] {
        let mut log = Log::new().subscribed().rows(0..5);
        let at = log.0.len();
        log.0.extend(wrong);
        let log = log.rows(5..10);
        let read = Ulog::read(&log.0).unwrap();
        assert_eq!(read.rows(), 10, "{wrong:?}");
        assert_eq!(read.lost.first(), Some(&(at..at + wrong.len())));
        assert_eq!(read.lost.len(), 1);
    }
}

/// What is cut off at any place is read up to its last whole message.
#[test]
fn a_log_that_is_cut_off_is_read_to_its_last_whole_row() {
    let log = Log::new().subscribed().rows(0..4).0;
    let row = (log.len() - Log::new().subscribed().0.len()) / 4;
    for cut in log.len() - row..log.len() {
        let read = Ulog::read(&log[..cut]).unwrap();
        assert_eq!(read.rows(), 3);
        let lost: usize = read.lost.iter().map(|part| part.len()).sum();
        assert_eq!(lost, cut - (log.len() - row));
    }
}

/// Appended data begin where the flags say, though a message before them was cut off.
#[test]
fn what_was_appended_is_read() {
    let mut log = Log::new().subscribed().rows(0..3);
    log.0.truncate(log.0.len() - 5);
    let at = log.0.len() as u64;
    let flags = HEADER + 3;
    log.0[flags + 8] = 1;
    log.0[flags + 16..flags + 24].copy_from_slice(&at.to_le_bytes());
    let log = log.rows(3..4);
    let read = Ulog::read(&log.0).unwrap();
    assert_eq!(column(&read, "q[0]"), [0.0, 1.0, 3.0]);
    let mut later = log.0;
    later[flags + 9] = 4;
    assert_eq!(Ulog::read(&later).unwrap_err(), UlogError::Later { flag: 4, byte: 1 });
}

/// What is no log is refused with its first bytes.
#[test]
fn what_is_no_log_is_refused() {
    for (bytes, found) in [(&b""[..], "nothing"), (b"PK\x03\x04", r"PK\x03\x04"), (&MAGIC, r"ULog\x01\x125")]
    {
        let said = Ulog::read(bytes).unwrap_err().to_string();
        assert!(said.contains(found), "{said}");
    }
}

/// Formats that go around in a circle, deeper than any, or larger than a message: no topic, and no end of
/// memory.
#[test]
fn formats_that_cannot_be_are_no_topics() {
    let mut log = Log::new();
    log.put(b'F', b"a:b[60000] x;");
    log.put(b'F', b"b:a[60000] x;");
    log.put(b'F', b"huge:double[60000] x;");
    log.put(b'F', b"empty:;");
    for (id, name) in [(1, "a"), (2, "huge"), (3, "unknown"), (4, "empty")] {
        log.put(b'A', &[&[0, id, 0], name.as_bytes()].concat());
        log.put(b'D', &[id, 0, 1, 2, 3]);
    }
    let log = log.subscribed().rows(0..3);
    let read = Ulog::read(&log.0).unwrap();
    assert_eq!(read.topics().map(|topic| topic.name.as_str()).collect::<Vec<_>>(), ["pose"]);
}
