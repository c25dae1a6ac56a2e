//! Estimate of how long flights take that are flown one at a time in six degrees of freedom: one is flown and
//! timed.

use std::fmt::Display;

use super::system::Stopwatch;
use super::terminal::print_err;

/// Reports on stderr why flights are not flown side by side, and about how long `count` times `one` takes on
/// `threads` threads.
pub fn warn_one_at_a_time<T>(reason: &dyn Display, count: u64, threads: usize, one: impl FnOnce() -> T) {
    let watch = Stopwatch::start();
    std::hint::black_box(one());
    let seconds = 1e-3 * watch.ms() * count as f64 / threads as f64;
    let length = words(seconds);
    print_err(&format!(
        "samara: {reason}: flown one at a time in six degrees of freedom, which takes about {length}\n"
    ));
}

/// A length of time in words.
pub fn words(seconds: f64) -> String {
    match seconds {
        s if s < 100.0 => format!("{:.0} s", s.max(1.0)),
        s if s < 6000.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.0} h", s / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::words;

    #[test]
    fn closed_form_a_length_of_time_has_a_fitting_unit() {
        assert_eq!(
            [0.2, 99.0, 150.0, 5400.0, 36000.0].map(words),
            ["1 s", "99 s", "2 min", "90 min", "10 h"]
        );
    }
}
