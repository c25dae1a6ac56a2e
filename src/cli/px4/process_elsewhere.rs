//! PX4's process where there is none: its simulation runs under Linux and macOS.

use std::convert::Infallible;
use std::path::Path;

use super::{BuildFolder, Px4Error};
use crate::link::shell::Guest;

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
}

impl Guest for Px4Process {
    fn gone(&mut self) -> Option<String> {
        match self.0 {}
    }
}
