//! Many flights, each as [`super::flight`] flies it, to the bit: eight side by side where they may be.
//!
//! Side by side fly drops of one vehicle at one site without faults ([`super::drop::abreast`]), along equal
//! steps, by controllers that are cascades ([`as_cascade`]); under other controllers the vehicles
//! move side by side, and each controller is asked by itself, but for shared ones ([`is_shared`]). All others
//! fly one after the other. What
//! watches them may look at eight at once.
//!
//! [`as_cascade`]: crate::control::Controller::as_cascade
//! [`is_shared`]: crate::control::Controller::is_shared

use super::flight::fly;
use super::watch::{ABREAST, Flight, Watch};

#[cfg(target_arch = "x86_64")]
mod abreast;

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
