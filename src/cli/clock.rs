//! The wall clock, for durations that are shown and never stored, and to wait for processes.
#![expect(clippy::disallowed_types, clippy::disallowed_methods, reason = "the command line's clock")]

use std::time::{Duration, Instant};

/// Time since a moment.
#[derive(Clone, Copy, Debug)]
pub struct Stopwatch(Instant);

impl Stopwatch {
    /// Starts now.
    pub fn start() -> Self {
        Self(Instant::now())
    }

    /// Milliseconds since the start.
    pub fn ms(&self) -> f64 {
        self.0.elapsed().as_secs_f64() * 1e3
    }
}

/// Waits: for a process to end.
pub fn pause(length: Duration) {
    std::thread::sleep(length);
}
