//! How far long work is, on stderr: a bar with the time left on a terminal, elsewhere a line every ten
//! seconds, so that a log of a long run shows that it goes on.

use std::io::IsTerminal as _;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use indicatif::{ProgressBar, ProgressStyle};

use super::estimate::words;
use super::system::Stopwatch;
use super::terminal::print_err;

/// Between two lines where there is no terminal [ms].
const LINE_EVERY_MS: f64 = 10_000.0;

/// Work of many pieces. Pieces may be done on any thread.
pub struct ProgressLine {
    /// What is done, for a line; `None` where there is a bar.
    lines: Option<Lines>,
    bar: ProgressBar,
}

struct Lines {
    what: String,
    unit: &'static str,
    clock: Stopwatch,
    done: AtomicU64,
    /// Pieces that were there from the start, which took no time.
    skipped: AtomicU64,
    whole: AtomicU64,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    message: String,
    last_line_ms: f64,
}

impl ProgressLine {
    /// Work of `whole` pieces, counted in `unit`s.
    pub fn new(what: &str, unit: &'static str, whole: u64) -> Self {
        if std::io::stderr().is_terminal() {
            let bar = ProgressBar::new(whole);
            let template = format!("{{bar:24}} {{pos}}/{{len}} {unit}, {{eta}} left  {{msg}}");
            if let Ok(style) = ProgressStyle::with_template(&template) {
                bar.set_style(style);
            }
            return Self { lines: None, bar };
        }
        let lines = Lines {
            what: what.to_owned(),
            unit,
            clock: Stopwatch::start(),
            done: AtomicU64::new(0),
            skipped: AtomicU64::new(0),
            whole: AtomicU64::new(whole),
            state: Mutex::default(),
        };
        Self { lines: Some(lines), bar: ProgressBar::hidden() }
    }

    /// Counts pieces that are there from an earlier run.
    pub fn skip(&self, pieces: u64) {
        match &self.lines {
            None => {
                self.bar.inc(pieces);
                self.bar.reset_eta();
            }
            Some(lines) => {
                lines.done.fetch_add(pieces, Ordering::Relaxed);
                lines.skipped.fetch_add(pieces, Ordering::Relaxed);
            }
        }
    }

    /// Counts pieces that were done now.
    pub fn inc(&self, pieces: u64) {
        match &self.lines {
            None => self.bar.inc(pieces),
            Some(lines) => {
                lines.done.fetch_add(pieces, Ordering::Relaxed);
                lines.report();
            }
        }
    }

    /// What is being done, or how well it goes.
    pub fn set_message(&self, message: &str) {
        match &self.lines {
            None => self.bar.set_message(message.to_owned()),
            Some(lines) => {
                if let Ok(mut state) = lines.state.lock() {
                    message.clone_into(&mut state.message);
                }
            }
        }
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

impl Lines {
    /// Prints a line where the last one is long enough ago.
    fn report(&self) {
        let now_ms = self.clock.ms();
        // Whoever holds it prints.
        let Ok(mut state) = self.state.try_lock() else { return };
        if now_ms - state.last_line_ms < LINE_EVERY_MS {
            return;
        }
        state.last_line_ms = now_ms;
        let [done, skipped, whole] =
            [&self.done, &self.skipped, &self.whole].map(|count| count.load(Ordering::Relaxed));
        let left = time_left_s(1e-3 * now_ms, done, skipped, whole);
        let Self { what, unit, .. } = self;
        let message = if state.message.is_empty() { String::new() } else { format!(", {}", state.message) };
        print_err(&format!("samara {what}: {done} of {whole} {unit}, about {} left{message}\n", words(left)));
    }
}

/// The time [s] that the rest of the pieces takes, if each takes as long as those done now.
fn time_left_s(elapsed_s: f64, done: u64, skipped: u64, whole: u64) -> f64 {
    let now = done.saturating_sub(skipped).max(1);
    elapsed_s * whole.saturating_sub(done) as f64 / now as f64
}

#[cfg(test)]
mod tests {
    use super::time_left_s;

    /// Ten of a hundred in 5 s: 45 s for the other ninety; half of them read from a file took no time.
    #[test]
    fn closed_form_time_left() {
        assert_eq!(time_left_s(5.0, 10, 0, 100), 45.0);
        assert_eq!(time_left_s(5.0, 60, 50, 100), 20.0);
        assert_eq!((time_left_s(5.0, 0, 0, 10), time_left_s(5.0, 12, 0, 10)), (50.0, 0.0));
    }
}
