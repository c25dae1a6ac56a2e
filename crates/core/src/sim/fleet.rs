//! Vehicles that are stepped together, each under throttles that whoever calls gives: eight side by side
//! where they may be ([`super::many`]), with the bits of each by itself.

use super::drop::DropSimulation;
use super::limits::{SafetyLimits, StateCost};
#[cfg(target_arch = "x86_64")]
use super::watch::ABREAST;
use crate::model::PerRotor;

pub use self::state::FleetState;

#[cfg(target_arch = "x86_64")]
mod abreast;
mod state;

/// Vehicles that are stepped together.
#[derive(Debug)]
pub struct Fleet {
    groups: Vec<Group>,
}

/// Vehicles one after the other in the order of the fleet.
#[derive(Debug)]
enum Group {
    /// Eight side by side.
    #[cfg(target_arch = "x86_64")]
    Abreast(Box<abreast::Eight>),
    /// Each by itself.
    Alone(Vec<DropSimulation>),
}

impl Fleet {
    /// The vehicles as they are.
    pub fn new(vehicles: Vec<DropSimulation>) -> Self {
        let mut left = vehicles.into_iter();
        let mut groups = Vec::new();
        #[cfg(target_arch = "x86_64")]
        while left.len() > 0 {
            groups.push(match abreast::Eight::of(left.by_ref().take(ABREAST).collect()) {
                Ok(eight) => Group::Abreast(Box::new(eight)),
                Err(vehicles) => Group::Alone(vehicles),
            });
        }
        #[cfg(not(target_arch = "x86_64"))]
        groups.push(Group::Alone(left.by_ref().collect()));
        Self { groups }
    }

    /// Advances each vehicle by `dt_s` [s], as [`DropSimulation::step`] does, under its throttles: those of
    /// the vehicles in their order, none for a vehicle without.
    pub fn step(&mut self, throttle: &[PerRotor], dt_s: f64) {
        let mut throttle = throttle.iter();
        for group in &mut self.groups {
            match group {
                #[cfg(target_arch = "x86_64")]
                Group::Abreast(eight) => eight.step(&mut throttle, dt_s),
                Group::Alone(vehicles) => {
                    for vehicle in vehicles {
                        vehicle.step(throttle.next().unwrap_or(&PerRotor::default()), dt_s);
                    }
                }
            }
        }
    }

    /// Shows each vehicle, from number 0 on, as it is by these limits.
    pub fn look(&self, limits: &SafetyLimits, show: &mut impl FnMut(usize, &FleetState)) {
        let mut number = 0;
        let mut show = |state: &FleetState| {
            show(number, state);
            number += 1;
        };
        for group in &self.groups {
            match group {
                #[cfg(target_arch = "x86_64")]
                Group::Abreast(eight) => eight.look(limits, &mut show),
                Group::Alone(vehicles) => vehicles.iter().for_each(|vehicle| {
                    let state = *vehicle.state();
                    let cost = StateCost::of(&state.body, limits);
                    let over = vehicle.has_turned_over();
                    let cost = if over { cost.turned_over(limits) } else { cost };
                    let bus_v = vehicle.battery().map(|battery| battery.near_v());
                    show(&FleetState { state, j_state: cost.max(), bus_v });
                }),
            }
        }
    }
}
