//! The last time stamps of a party's signed frames, as they survive its restart: without them what was
//! recorded within the last minute could be played again to a party that has just started.
//!
//! ```text
//! latest 37000000000000
//! forgotten 0
//! heard 3 255 190 37000000000000
//! ```
//!
//! `latest` is the latest stamp that was used or believed (a minute ahead of our clock at most), `forgotten`
//! that of the senders that are remembered no more, and each `heard` that of one sender: its link, system and
//! component first. Stamps count 10 us since 2015.

/// The last stamp there is: they have 48 bits.
pub(super) const LAST_STAMP: u64 = (1 << 48) - 1;
/// Most senders whose last time stamps are remembered; of more, the one that was heard longest ago goes.
pub(super) const MAX_STREAMS: usize = 256;
/// How far the stamps that are kept run ahead of those that were heard: ten seconds. They are renewed only
/// when they are reached, and who ends without warning starts on the safe side.
pub(super) const AHEAD: u64 = 1_000_000;

/// A text that holds no time stamps.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "line {line}: `{text}`: expected `latest STAMP`, `forgotten STAMP` or `heard LINK SYSTEM COMPONENT STAMP`"
)]
pub struct StampsError {
    line: usize,
    text: String,
}

/// One sender on one of its links.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stream {
    pub(super) link_id: u8,
    pub(super) system_id: u8,
    pub(super) component_id: u8,
    pub(super) newest: u64,
}

/// See the head of this file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Stamps {
    /// The latest time stamp used or believed.
    pub(super) latest: u64,
    /// The latest stamp of a sender that is remembered no more: nothing up to it counts of who is new.
    pub(super) forgotten: u64,
    pub(super) streams: Vec<Stream>,
}

impl Stamps {
    /// Reads what [`Self::to_text`] wrote.
    ///
    /// # Errors
    /// [`StampsError`] with the line that holds something else.
    pub fn parse(text: &str) -> Result<Self, StampsError> {
        let mut stamps = Self::default();
        for (i, line) in text.lines().enumerate() {
            let error = || StampsError { line: i + 1, text: line.chars().take(80).collect() };
            stamps.take(line).ok_or_else(error)?;
        }
        Ok(stamps)
    }

    fn take(&mut self, line: &str) -> Option<()> {
        let stamp = |s: &str| s.parse().ok().filter(|stamp| *stamp <= LAST_STAMP);
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["latest", at] => self.latest = stamp(at)?,
            ["forgotten", at] => self.forgotten = stamp(at)?,
            ["heard", link, system, component, at] if self.streams.len() < MAX_STREAMS => {
                let (link_id, system_id) = (link.parse().ok()?, system.parse().ok()?);
                let (component_id, newest) = (component.parse().ok()?, stamp(at)?);
                self.streams.push(Stream { link_id, system_id, component_id, newest });
            }
            _ => return None,
        }
        Some(())
    }

    /// As lines of text.
    pub fn to_text(&self) -> String {
        let heard =
            |s: &Stream| format!("heard {} {} {} {}\n", s.link_id, s.system_id, s.component_id, s.newest);
        let heard: String = self.streams.iter().map(heard).collect();
        format!("latest {}\nforgotten {}\n{heard}", self.latest, self.forgotten)
    }

    /// The latest of them.
    pub(super) fn last(&self) -> u64 {
        self.streams.iter().map(|s| s.newest).fold(self.latest.max(self.forgotten), u64::max)
    }

    /// With the senders' stamps ahead of what was heard.
    pub(super) fn ahead(&self) -> Self {
        let ahead = |s: &Stream| Stream { newest: (s.newest + AHEAD).min(LAST_STAMP), ..*s };
        Self { streams: self.streams.iter().map(ahead).collect(), ..*self }
    }

    /// Whether each sender's stamps end before those that are kept do.
    pub(super) fn is_within(&self, kept: &Self) -> bool {
        self.forgotten <= kept.forgotten && self.streams.iter().all(|s| kept.holds(s))
    }

    fn holds(&self, stream: &Stream) -> bool {
        let sender = |s: &Stream| (s.link_id, s.system_id, s.component_id);
        self.streams.iter().any(|s| sender(s) == sender(stream) && s.newest >= stream.newest)
    }
}
