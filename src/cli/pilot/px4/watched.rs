//! PX4 as the simulator watches it: gone when its process has ended, and taken to be when it does not come or
//! does not answer.

use std::time::Duration;

use super::process::Px4Process;
use crate::cli::system::Stopwatch;
use samara::link::shell::Guest;
use samara::link::{Pace, TimeUs};

/// How long PX4 may keep the simulator waiting, in wall time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patience {
    /// The longest wait for PX4's connection, and for an answer where `answers` says so.
    pub limit: Duration,
    /// Whether an answer is given up too: where nobody looks on. Whoever does may have stopped PX4 in a
    /// debugger.
    pub answers: bool,
}

/// A running PX4 as the simulator watches it.
#[derive(Debug)]
pub(super) struct WatchedPx4 {
    pub(super) px4: Px4Process,
    patience: Patience,
    /// The TCP port that PX4 should connect to.
    port: u16,
    /// What the simulator was seen waiting for, at which simulated time.
    seen: Option<(TimeUs, Pace)>,
    since: Stopwatch,
}

impl WatchedPx4 {
    pub(super) fn new(px4: Px4Process, patience: Patience, port: u16) -> Self {
        Self { px4, patience, port, seen: None, since: Stopwatch::start() }
    }
}

impl Guest for WatchedPx4 {
    fn gone(&mut self, now: TimeUs, pace: Pace) -> Option<String> {
        if let Some(ended) = self.px4.ended() {
            return Some(ended);
        }
        if self.seen != Some((now, pace)) {
            self.seen = Some((now, pace));
            self.since = Stopwatch::start();
        }
        let missing = match pace {
            Pace::NoPeer => format!("its connection to the simulator (TCP {})", self.port),
            Pace::AwaitingControls if self.patience.answers => {
                "HIL_ACTUATOR_CONTROLS, its answer to HIL_SENSOR,".to_owned()
            }
            _ => return None,
        };
        let limit_s = self.patience.limit.as_secs_f64();
        (self.since.ms() >= 1e3 * limit_s).then(|| {
            let words = self.px4.last_words();
            format!("PX4 runs, but {missing} has not come within {limit_s} s; {words}")
        })
    }

    fn is_idle(&mut self) -> bool {
        self.px4.is_idle()
    }
}
