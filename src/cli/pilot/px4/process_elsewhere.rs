//! PX4's process where there is none: its simulation runs under Linux and macOS.

use std::convert::Infallible;
use std::path::Path;

use anyhow::{Result, bail};

use super::beginning::Beginning;
use super::build_folder::BuildFolder;

/// A process that is never there.
#[derive(Debug)]
pub struct Px4Process(Infallible);

impl Px4Process {
    /// Refuses to start PX4.
    pub fn start(_: &BuildFolder, _: u16, _: &Beginning, _: &Path) -> Result<Self> {
        bail!("PX4's simulation runs under Linux and macOS; here only --autopilot reference flies")
    }

    /// PX4's working directory.
    pub fn work(&self) -> &Path {
        match self.0 {}
    }

    /// Whether PX4 has done all that there was to do.
    pub fn is_idle(&self) -> bool {
        match self.0 {}
    }

    /// Ends PX4.
    pub fn stop(&mut self) {
        match self.0 {}
    }

    /// The end of PX4's console.
    pub fn last_words(&self) -> String {
        match self.0 {}
    }

    /// How PX4 has ended.
    pub fn ended(&mut self) -> Option<String> {
        match self.0 {}
    }
}
