//! PX4's process where there is none: its simulation runs under Linux and macOS.

use std::convert::Infallible;
use std::path::Path;

use super::{BuildFolder, Px4Error};

/// Never there.
#[derive(Debug)]
pub struct Px4Process(Infallible);

impl Px4Process {
    /// Refuses.
    ///
    /// # Errors
    /// [`Px4Error::NotHere`].
    pub fn start(_: &BuildFolder, _: u16, _: Option<&str>, _: &Path) -> Result<Self, Px4Error> {
        Err(Px4Error::NotHere)
    }

    /// Its working directory.
    pub fn work(&self) -> &Path {
        match self.0 {}
    }

    /// Ends it.
    pub fn stop(&mut self) {
        match self.0 {}
    }

    /// The end of what it has said.
    pub fn last_words(&self) -> String {
        match self.0 {}
    }

    /// How it has ended.
    pub fn ended(&mut self) -> Option<String> {
        match self.0 {}
    }
}
