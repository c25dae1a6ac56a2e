//! What turns the rotors of a vehicle: motors on a stiff supply, motors on the bus of a battery.

use super::motor::MotorLaw;
use super::supply::{Bus, MotorState, Pack};
use super::{MAX_ROTORS, MotorCondition};
use crate::real::Real;

/// What turns the rotors of a vehicle.
pub trait Drives<S> {
    /// Angular acceleration of each rotor [rad/s^2] against the torques of the air [N m].
    fn accelerations(self, torque_nm: &[S; MAX_ROTORS]) -> [S; MAX_ROTORS];
}

/// Rotors that are held.
#[derive(Clone, Copy, Debug)]
pub struct Held;

impl<S: Real> Drives<S> for Held {
    #[inline(always)]
    fn accelerations(self, torque_nm: &[S; MAX_ROTORS]) -> [S; MAX_ROTORS] {
        [torque_nm[0].of(0.0); MAX_ROTORS]
    }
}

/// Motors under throttle commands on a stiff supply.
#[derive(Clone, Copy, Debug)]
pub struct Motors<'a, S> {
    /// Law of each motor.
    pub law: &'a MotorLaw,
    /// How many there are.
    pub count: usize,
    /// Their conditions; `None`: all are sound.
    pub conditions: Option<&'a [MotorCondition; MAX_ROTORS]>,
    /// Throttle commands, 0..1.
    pub throttle: &'a [S; MAX_ROTORS],
    /// Speeds [rad/s].
    pub speed: &'a [S; MAX_ROTORS],
}

impl<S: Real> Motors<'_, S> {
    #[inline(always)]
    fn condition(&self, i: usize) -> MotorCondition {
        match self.conditions {
            Some(conditions) => conditions[i],
            None => MotorCondition::Sound,
        }
    }
}

impl<S: Real> Drives<S> for Motors<'_, S> {
    #[inline(always)]
    fn accelerations(self, torque_nm: &[S; MAX_ROTORS]) -> [S; MAX_ROTORS] {
        let mut rates = [torque_nm[0].of(0.0); MAX_ROTORS];
        for (i, rate) in rates.iter_mut().enumerate().take(self.count) {
            let (throttle, omega) = (self.throttle[i], self.speed[i]);
            *rate = self.law.acceleration_in(self.condition(i), throttle, omega, torque_nm[i]);
        }
        rates
    }
}

/// Motors on the bus of a battery.
#[derive(Debug)]
pub struct OnBus<'a, S: Real> {
    /// The motors.
    pub motors: Motors<'a, S>,
    /// The battery.
    pub pack: &'a Pack,
    /// Voltage of the battery without load [V]; none without charge.
    pub open_v: S,
    /// Bus voltage from which it is searched [V]; that which was found, afterwards.
    pub near_v: &'a mut S,
    /// The bus that was found.
    pub bus: &'a mut Option<Bus<S>>,
}

impl<S: Real> Drives<S> for OnBus<'_, S> {
    #[inline(always)]
    fn accelerations(self, torque_nm: &[S; MAX_ROTORS]) -> [S; MAX_ROTORS] {
        let Motors { law, count, throttle, speed, .. } = self.motors;
        let zero = torque_nm[0].of(0.0);
        let rest = MotorState {
            condition: MotorCondition::Sound,
            throttle: zero,
            omega_rad_s: zero,
            torque_nm: zero,
        };
        let mut states = [rest; MAX_ROTORS];
        for (i, state) in states.iter_mut().enumerate().take(count) {
            *state = MotorState {
                condition: self.motors.condition(i),
                throttle: throttle[i],
                omega_rad_s: speed[i],
                torque_nm: torque_nm[i],
            };
        }
        let (supply, bus) = self.pack.supply(self.open_v, law, &states[..count], *self.near_v);
        *self.near_v = bus.bus_v;
        *self.bus = Some(bus);
        let mut rates = [zero; MAX_ROTORS];
        for (rate, state) in rates.iter_mut().zip(&states[..count]) {
            *rate = supply.acceleration(law, state);
        }
        rates
    }
}
