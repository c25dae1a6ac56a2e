//! What a rotor and its motor can do in still air: the greatest thrust that they hold, and how fast thrust
//! comes and goes.

use super::rotor::RotorLoad;
use super::vehicle::{Interference, Vehicle};

/// Share of the greatest thrust that comes, or goes, in the time that the slew is taken over.
const STROKE: f64 = 0.9;
/// Step of the integration, as a share of the motor's shortest time constant.
const STEP: f64 = 0.02;
/// Most steps of the integration: 2000 of the motor's shortest time constants.
const STEPS: usize = 100_000;

/// What each of a vehicle's rotors can do in still air of a density; of a coaxial pair, what both can.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotorLimits {
    /// Thrust [N] at the speed that the motor holds at full throttle against the torque of the air.
    pub thrust_n: f64,
    /// Mean rate [N/s] at which 90 % of that thrust comes at full throttle from rest, or goes at no throttle,
    /// whichever is slower.
    pub thrust_slew_n_s: f64,
}

impl RotorLimits {
    /// The limits of the vehicle's rotors at a density of the air [kg/m^3].
    pub fn of(vehicle: &Vehicle, density_kg_m3: f64) -> Self {
        let mut kinds: Vec<Interference> = Vec::new();
        for rotor in &vehicle.rotors {
            if !kinds.contains(&rotor.interference) {
                kinds.push(rotor.interference);
            }
        }
        let all = kinds.iter().map(|kind| Self::under(vehicle, *kind, density_kg_m3));
        let weaker = |a: Self, b: Self| Self {
            thrust_n: a.thrust_n.min(b.thrust_n),
            thrust_slew_n_s: a.thrust_slew_n_s.min(b.thrust_slew_n_s),
        };
        all.reduce(weaker).unwrap_or(Self { thrust_n: 0.0, thrust_slew_n_s: 0.0 })
    }

    /// Lift of all rotors [N] at the speeds that their motors hold at full throttle, up where the body is
    /// level: of a coaxial pair that of both, each with what it makes.
    pub fn lift_n(vehicle: &Vehicle, density_kg_m3: f64) -> f64 {
        let mut known: Vec<(Interference, f64)> = Vec::new();
        let mut thrust_n = |kind: Interference| {
            let found = known.iter().find(|(of, _)| *of == kind).map(|(_, thrust_n)| *thrust_n);
            found.unwrap_or_else(|| {
                let thrust_n = Self::under(vehicle, kind, density_kg_m3).thrust_n;
                known.push((kind, thrust_n));
                thrust_n
            })
        };
        vehicle.rotors.iter().map(|rotor| -rotor.axis_body.z * thrust_n(rotor.interference)).sum()
    }

    /// The limits of a rotor with this interference.
    fn under(vehicle: &Vehicle, interference: Interference, density_kg_m3: f64) -> Self {
        let load = |omega: f64| {
            let alone = vehicle.rotor.static_load(omega, density_kg_m3);
            RotorLoad {
                thrust_n: interference.thrust * alone.thrust_n,
                torque_nm: interference.torque * alone.torque_nm,
                in_plane_n: 0.0,
            }
        };
        let law = vehicle.motor.law();
        let acceleration =
            |throttle: f64, omega: f64| law.acceleration(throttle, omega, load(omega).torque_nm);
        let omega_held = {
            let (mut low, mut high) = (0.0, vehicle.motor.omega_max_rad_s());
            if acceleration(1.0, high) >= 0.0 {
                low = high;
            }
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if acceleration(1.0, middle) >= 0.0 {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            low
        };
        let thrust_n = load(omega_held).thrust_n;
        let dt_s = STEP / vehicle.motor.fastest_rate_per_s();
        // Time until the thrust has passed a value: midpoint rule, the last step in part.
        let until = |throttle: f64, from_omega: f64, passed: &dyn Fn(f64) -> f64| {
            let (mut omega, mut t_s) = (from_omega, 0.0);
            for _ in 0..STEPS {
                let middle = omega + 0.5 * dt_s * acceleration(throttle, omega);
                let next = (omega + dt_s * acceleration(throttle, middle)).max(0.0);
                let (before, after) = (passed(load(omega).thrust_n), passed(load(next).thrust_n));
                if after >= 0.0 {
                    return t_s + dt_s * before / (before - after);
                }
                (omega, t_s) = (next, t_s + dt_s);
            }
            f64::INFINITY
        };
        let rise_s = until(1.0, 0.0, &|thrust| thrust - STROKE * thrust_n);
        let fall_s = until(0.0, omega_held, &|thrust| (1.0 - STROKE) * thrust_n - thrust);
        Self { thrust_n, thrust_slew_n_s: STROKE * thrust_n / rise_s.max(fall_s) }
    }
}
