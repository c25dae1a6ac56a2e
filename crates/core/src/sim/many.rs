//! Many flights, each as [`super::flight`] flies it, to the bit: eight side by side where they may be.
//!
//! Side by side fly drops of one vehicle at one site without faults ([`super::drop::abreast`]), along equal
//! steps, by controllers that are cascades ([`Controller::as_cascade`]); under other controllers the vehicles
//! move side by side, and each controller is asked by itself. All others fly one after the other. What
//! watches them may look at eight at once.

use std::ops::ControlFlow;

#[cfg(target_arch = "x86_64")]
pub use super::drop::abreast::Samples;
use super::drop::{DropSimulation, Phase};
use super::flight::{FlightPlan, fly};
use super::record::Sample;
use crate::control::Controller;

#[cfg(target_arch = "x86_64")]
mod abreast;

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

/// Flies all flights.
pub fn fly_many(flights: Vec<Flight<'_>>, watch: &mut impl Watch) {
    let mut left = flights.into_iter();
    let mut begin = 0;
    while left.len() > 0 {
        let group: Vec<Flight<'_>> = left.by_ref().take(ABREAST).collect();
        let count = group.len();
        #[cfg(target_arch = "x86_64")]
        let group = abreast::fly(group, begin, watch);
        for (i, mut flight) in group.into_iter().enumerate() {
            let Flight { simulation, controller, plan } = &mut flight;
            let _ = fly(simulation, &mut **controller, plan, &mut |sample| watch.take(begin + i, sample));
        }
        begin += count;
    }
}
