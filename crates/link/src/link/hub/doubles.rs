//! Frames that come by two ways: straight from their sender, and through a router that passes them on as they
//! are.

use std::collections::VecDeque;

/// The other way may take this long [us].
const MEMORY_US: u64 = 1_000_000;
/// Most frames that are remembered.
const MOST: usize = 256;

/// A frame, and by whom it came when.
#[derive(Clone, Debug)]
struct Heard<P> {
    at: u64,
    from: P,
    bytes: Vec<u8>,
}

/// What was heard of late, and by which peer `P`.
#[derive(Clone, Debug)]
pub(super) struct Doubles<P> {
    heard: VecDeque<Heard<P>>,
}

impl<P: PartialEq> Doubles<P> {
    /// Nothing was heard yet.
    pub(super) fn new() -> Self {
        Self { heard: VecDeque::new() }
    }

    /// Whether the same bytes have come by another peer. What a peer says twice it wants to say twice.
    pub(super) fn holds(&mut self, now: u64, from: P, bytes: &[u8]) -> bool {
        while self.heard.front().is_some_and(|h| now.saturating_sub(h.at) > MEMORY_US) {
            self.heard.pop_front();
        }
        self.heard.iter().any(|h| h.from != from && h.bytes == bytes)
    }

    /// Remembers a frame.
    pub(super) fn note(&mut self, now: u64, from: P, bytes: &[u8]) {
        if self.heard.len() == MOST {
            self.heard.pop_front();
        }
        self.heard.push_back(Heard { at: now, from, bytes: bytes.to_vec() });
    }
}
