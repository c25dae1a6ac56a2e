//! A mission as one looks at it and turns its knobs: changed, planned and flown anew at once, with campaigns
//! of whole drops and its files written on demand; a flight as one looks on while it flies; and the server
//! that a browser on this machine asks.
//!
//! | file | holds |
//! |---|---|
//! | [`viewed`] | the mission that is open, and its keys with other values |
//! | [`controls`] | the keys that matter most, and what is known of every key |
//! | [`flown`] | other values in, plan, flight and verdict out |
//! | [`campaign`] | whole drops of a changed mission, batch after batch |
//! | [`live`] | a flight while it flies: what it hands over, and what those get who look on |
//! | [`run`] | a run's folder: its pages, its worst trials flown again |
//! | [`written`] | a changed mission in files of its own |
//! | [`server`] | who may ask, what can be asked, and the sockets |
//!
//! All but [`server`] are plain functions of their arguments: they open no socket and look at no clock. What
//! is overtaken by something newer is stopped by [`Stop`].

pub mod campaign;
pub mod controls;
pub mod flown;
pub mod live;
pub mod run;
pub mod server;
pub mod viewed;
pub mod written;

pub use samara_study::jobs::Stop;

#[cfg(test)]
#[expect(clippy::disallowed_methods, reason = "tests read and write files")]
mod tests;
