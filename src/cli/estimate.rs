//! Estimate of how long flights take that are flown in six degrees of freedom: some are flown and timed.

use std::fmt::Display;

use super::system::Stopwatch;
use super::terminal::print_err;

/// Reports on stderr why flights are not flown in the vertical plane, and about how long `count` of them take
/// on `threads` threads, of which `some` flies `tried`.
pub fn warn_in_space<T>(
    reason: &dyn Display,
    (count, tried): (u64, usize),
    threads: usize,
    some: impl FnOnce() -> T,
) {
    let watch = Stopwatch::start();
    std::hint::black_box(some());
    let seconds = 1e-3 * watch.ms() * count as f64 / (tried * threads) as f64;
    let length = words(seconds);
    print_err(&format!("samara: {reason}: flown in six degrees of freedom, which takes about {length}\n"));
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
