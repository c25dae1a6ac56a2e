//! White noise of flights that is given instead of drawn, so that a search may choose it.
//!
//! A column is a sequence of independent normal numbers of mean 0 and variance 1. The first number of a
//! column begins a filter in its stationary distribution, each further one drives a step of the simulation;
//! beyond its end a column is zero.

use std::sync::Arc;

use crate::model::MAX_ROTORS;

/// The white noise of a flight.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FlightNoise {
    /// Columns of turbulence: one along the mean wind, two across it, two vertical.
    pub turbulence: [Arc<[f64]>; 5],
    /// A column for each rotor, of its fluctuation in the vortex ring.
    pub ring: [Arc<[f64]>; MAX_ROTORS],
}

/// The white noise of flights by their number, from 0; one whose number is not there has none.
#[derive(Clone, Debug, PartialEq)]
pub struct GivenNoise(pub Arc<[FlightNoise]>);

impl GivenNoise {
    fn flight(&self, number: u64) -> Option<&FlightNoise> {
        self.0.get(usize::try_from(number).ok()?)
    }

    /// Two columns of a flight's turbulence.
    pub(super) fn turbulence(&self, number: u64, places: [usize; 2]) -> [Arc<[f64]>; 2] {
        places
            .map(|place| self.flight(number).map(|noise| noise.turbulence[place].clone()).unwrap_or_default())
    }

    /// The column of a rotor in the vortex ring, twice.
    pub(super) fn ring(&self, number: u64, rotor: usize) -> [Arc<[f64]>; 2] {
        let column = self.flight(number).and_then(|noise| noise.ring.get(rotor)).cloned().unwrap_or_default();
        [column.clone(), column]
    }
}
