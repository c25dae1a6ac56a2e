//! A program without the feature `view` shows no flight while it flies.

use clap::Args;

use super::answer::Failure;
use super::narrator::Weight;
use samara::config::Mission;
use samara::link::shell::Notice;
use samara::link::{Froude, TimeUs};
use samara::report::ShownDrop;
use samara::sim::Sample;
use samara::trajectory::Trajectory;

/// Nothing that could be typed.
#[derive(Args, Clone, Debug, Default)]
pub struct LiveArgs {}

impl LiveArgs {
    /// Never.
    pub fn asked(&self) -> bool {
        false
    }
}

/// What is known of a flight while it flies.
pub enum Known {
    Simulated,
    Told,
}

/// A flight that nobody looks at.
pub struct Live;

impl Live {
    /// Opens nothing.
    pub fn open(
        _: &LiveArgs,
        _: (&Mission, Option<&Trajectory>),
        _: Known,
        _: (u8, Option<Froude>),
    ) -> Result<Self, Failure> {
        Ok(Self)
    }

    pub fn notice(&self, _: &Notice, _: Weight) {}

    pub fn frame(&self, _: TimeUs, _: &[u8]) {}

    pub fn flown(&self, _: &[Sample]) {}

    pub fn judged(&self, _: &ShownDrop<'_>, _: bool) {}

    pub fn over(&self, _: &str) {}
}
