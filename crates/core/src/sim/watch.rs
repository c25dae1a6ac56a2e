//! A flight that is to be flown, and what watches flights.

use std::ops::ControlFlow;

#[cfg(target_arch = "x86_64")]
pub use super::drop::abreast::Samples;
use super::drop::{DropSimulation, Phase};
use super::flight::FlightPlan;
use super::record::Sample;
use crate::control::Controller;

/// How many flights fly side by side.
pub const ABREAST: usize = 8;

/// A flight that is to be flown.
#[derive(Clone, Debug)]
pub struct Flight<'a> {
    /// The drop.
    pub simulation: DropSimulation,
    /// What flies it.
    pub controller: Box<dyn Controller>,
    /// How it is flown.
    pub plan: FlightPlan<'a>,
}

/// What watches flights.
pub trait Watch {
    /// Takes the next sample of a flight, by its number from 0; it may break that flight off.
    fn take(&mut self, flight: usize, sample: &Sample) -> ControlFlow<()>;

    /// Whether it looks at samples in a phase: those in which it does not are not made.
    fn looks_at(&self, _phase: Phase) -> bool {
        true
    }

    /// Takes the next samples of so many flights side by side, from a number on, those that it has broken off
    /// among them; whether it does: if not, it is given them one by one, as it is the last samples of each
    /// flight.
    #[cfg(target_arch = "x86_64")]
    fn take_abreast(&mut self, _first: usize, _count: usize, _samples: &Samples<'_>) -> bool {
        false
    }
}

impl<F: FnMut(usize, &Sample) -> ControlFlow<()>> Watch for F {
    fn take(&mut self, flight: usize, sample: &Sample) -> ControlFlow<()> {
        self(flight, sample)
    }
}
