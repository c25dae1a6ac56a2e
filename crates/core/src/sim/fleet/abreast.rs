//! Eight vehicles of a fleet side by side.

use super::super::drop::DropSimulation;
use super::super::drop::abreast::Abreast;
use super::super::integrator::Craft;
use super::super::limits::{SafetyLimits, shares};
use super::state::FleetState;
use crate::frames::pitch_and_bank;
use crate::model::{MAX_ROTORS, PerRotor};
use crate::real::Real as _;
use crate::simd::lanes::{LANES, Lanes};
use crate::simd::{Kernel, vectorised};

/// Fewer vehicles than this are stepped one by one: eight side by side take as long as so many.
const LEAST: usize = 3;

/// Eight vehicles, some of which may stand in for none.
#[derive(Debug)]
pub(super) struct Eight {
    abreast: Abreast,
    count: usize,
    throttle: [Lanes; MAX_ROTORS],
}

impl Eight {
    /// Eight vehicles or fewer side by side; given back where they may not be so.
    pub(super) fn of(mut vehicles: Vec<DropSimulation>) -> Result<Self, Vec<DropSimulation>> {
        let count = vehicles.len();
        if count < LEAST {
            return Err(vehicles);
        }
        // Lanes that are left over fly the first vehicle, which nobody looks at.
        while vehicles.len() < LANES {
            vehicles.push(vehicles[0].clone());
        }
        match Abreast::of(vehicles) {
            Ok(abreast) => {
                let throttle = [abreast.zero(); MAX_ROTORS];
                Ok(Self { abreast, count, throttle })
            }
            Err(mut vehicles) => {
                vehicles.truncate(count);
                Err(vehicles)
            }
        }
    }

    /// Advances by `dt_s` [s] under the next throttles, none where there are no more.
    pub(super) fn step<'a>(&mut self, throttle: &mut impl Iterator<Item = &'a PerRotor>, dt_s: f64) {
        for (i, given) in (0..self.count).map(|i| (i, throttle.next())) {
            for (rotor, number) in self.throttle.iter_mut().enumerate() {
                number.as_array_mut()[i] = given.map_or(0.0, |given| given[rotor]);
            }
        }
        self.abreast.step_unseen(&self.throttle, dt_s);
    }

    /// Shows each vehicle as it is by these limits.
    pub(super) fn look(&self, limits: &SafetyLimits, show: &mut impl FnMut(&FleetState)) {
        let turned_over = self.abreast.turned_over();
        let j_state = vectorised(Cost { craft: self.abreast.craft(), turned_over, limits });
        let bus_v = self.abreast.bus_v();
        for (i, j_state) in j_state.into_iter().enumerate().take(self.count) {
            let bus_v = bus_v.map(|bus_v| bus_v.as_array()[i]);
            show(&FleetState { state: self.abreast.state(i), j_state, bus_v });
        }
    }
}

/// J_state of vehicles, infinite where it is no number.
struct Cost<'a> {
    craft: &'a Craft<Lanes>,
    turned_over: [bool; LANES],
    limits: &'a SafetyLimits,
}

impl Kernel for Cost<'_> {
    type Output = [f64; LANES];

    #[inline(always)]
    fn run(self) -> [f64; LANES] {
        let Self { craft: Craft { motion, .. }, turned_over, limits } = self;
        let zero = motion.v_ned.x.of(0.0);
        let infinite = zero.of(f64::INFINITY);
        let mut over = zero;
        for (over, turned_over) in over.as_array_mut().iter_mut().zip(turned_over) {
            *over = if turned_over { 1.0 } else { 0.0 };
        }
        let (pitch_rad, roll_rad) = pitch_and_bank(motion.q_ned_from_body);
        let over = zero.less(over);
        let parts = shares(motion.v_ned.norm(), [pitch_rad, roll_rad], motion.omega_body, over, limits);
        let (mut most, mut none) = (zero, zero.less(zero));
        for share in parts {
            none = none | !share.less(infinite);
            most = share.at_least(most);
        }
        *Lanes::select(none, infinite, most).as_array()
    }
}
