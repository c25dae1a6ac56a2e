//! Speeds of the rotors through a whole flight, run from its commands, with their slopes by lag and delay.

use super::course::Course;
use super::parameter::{PARAMETERS, Parameter};
use crate::frames::Turn;
use crate::model::motor::MotorLaw;
use crate::model::rotor::HubMotion;
use crate::model::{MAX_ROTORS, Motor, Vehicle};
use crate::real::{Dual, Real};
use crate::vector::V3;

/// Along lag up, lag down, delay, torque of the air.
pub(super) const SLOPES: usize = 4;
/// The parameters of the slopes.
pub(super) const SLOPED: [Parameter; SLOPES] =
    [Parameter::LagUp, Parameter::LagDown, Parameter::Delay, Parameter::Torque];
/// A number with slopes by what the rotors' speeds hang on.
pub(super) type Slope = Dual<f64, SLOPES>;
/// Pieces of a step, at most: beyond it commands come more often than a rotor follows.
const MOST_PIECES: usize = 64;

/// Speeds [rad/s] and accelerations [rad/s^2] of the rotors.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spin {
    pub(super) speed: [Slope; MAX_ROTORS],
    pub(super) acceleration: [Slope; MAX_ROTORS],
}

/// The rotors at each instant of a course, and their means over the step behind it: commands come within a
/// step, so that what a rotor does in its middle is not what it does to the body.
pub(super) fn spins(vehicle: &Vehicle, course: &Course, deviations: &[f64; PARAMETERS]) -> Vec<[Spin; 2]> {
    let of = |slope: usize| Dual::variable(deviations[SLOPED[slope] as usize], slope);
    let exp = |x: Slope| {
        let value = crate::math::exp(x.value);
        Dual { value, slope: x.slope.map(|slope| value * slope) }
    };
    let delay_s = of(2);
    let mut lag = [exp(of(0)), exp(of(1))];
    if !Parameter::LagDown.is_of(vehicle) {
        lag[1] = lag[0];
    }
    let mut train = Train {
        vehicle,
        law: vehicle.motor.law(),
        count: vehicle.rotors.len().min(MAX_ROTORS),
        longest_s: vehicle.longest_step_s(),
        lag,
        torque: exp(of(3)),
        speed: [Dual::constant(0.0); MAX_ROTORS],
        turned: [Dual::constant(0.0); MAX_ROTORS],
        air: None,
    };
    let mut spins = Vec::with_capacity(course.instants.len());
    let mut arrived = 0;
    let mut throttle = course.commands.first().map_or([0.0; MAX_ROTORS], |(_, row)| *row);
    for (i, omega) in train.speed.iter_mut().enumerate().take(train.count) {
        *omega = Dual::constant(throttle[i].clamp(0.0, 1.0) * vehicle.motor.omega_max_rad_s());
    }
    for instant in &course.instants {
        train.air = instant.near.map(|(q, v)| {
            let v_air_body = Turn::of(q).to_body(V3::new(v[0], v[1], v[2]));
            let [p, q, r] = instant.rates_body_rad_s.map(|x| if x.is_finite() { x } else { 0.0 });
            (v_air_body, V3::new(p, q, r), instant.density_kg_m3)
        });
        let here = train.spin(&throttle);
        train.turned = [Dual::constant(0.0); MAX_ROTORS];
        let to_s = instant.t_s + instant.step_s;
        let mut now = Dual::constant(instant.t_s);
        for _ in 0..MOST_PIECES {
            let Some((sent_s, row)) = course.commands.get(arrived) else { break };
            let comes = delay_s + *sent_s;
            if comes.value >= to_s {
                break;
            }
            if comes.value > now.value {
                train.turn(&throttle, comes - now);
                now = comes;
            }
            throttle = *row;
            arrived += 1;
        }
        train.turn(&throttle, -now + to_s);
        spins.push([here, if instant.step_s > 0.0 { train.mean(&here, instant.step_s) } else { here }]);
    }
    spins
}

/// The rotors on their way.
struct Train<'v> {
    vehicle: &'v Vehicle,
    law: MotorLaw,
    count: usize,
    longest_s: f64,
    lag: [Slope; 2],
    torque: Slope,
    speed: [Slope; MAX_ROTORS],
    /// Angles by which they have turned in this step [rad].
    turned: [Slope; MAX_ROTORS],
    /// Velocity through the air and rates, body axes [m/s, rad/s], and density [kg/m^3].
    air: Option<(V3<f64>, V3<f64>, f64)>,
}

impl Train<'_> {
    fn spin(&self, throttle: &[f64; MAX_ROTORS]) -> Spin {
        let mut acceleration = [Dual::constant(0.0); MAX_ROTORS];
        for (i, rate) in acceleration.iter_mut().enumerate().take(self.count) {
            *rate = self.acceleration(i, throttle[i], self.speed[i]);
        }
        Spin { speed: self.speed, acceleration }
    }

    /// Means over a step [s] that began so.
    fn mean(&self, before: &Spin, step_s: f64) -> Spin {
        Spin {
            speed: self.turned.map(|turned| turned * (1.0 / step_s)),
            acceleration: std::array::from_fn(|i| (self.speed[i] - before.speed[i]) * (1.0 / step_s)),
        }
    }

    fn acceleration(&self, rotor: usize, throttle: f64, omega: Slope) -> Slope {
        let torque = match (&self.vehicle.motor, self.air) {
            (Motor::EscDc(_), Some((v_air_body, omega_body, density))) => {
                let mount = &self.vehicle.rotors[rotor];
                let hub = HubMotion::of(mount.hub_body_m_s(v_air_body, omega_body), &mount.axis_body);
                let hub = HubMotion {
                    climb_m_s: Dual::constant(hub.climb_m_s),
                    in_disk_body_m_s: V3::zero(omega),
                    in_plane_m_s: Dual::constant(hub.in_plane_m_s),
                };
                let load = self.vehicle.rotor.load_at_hub(omega, &hub, Dual::constant(density));
                load.torque_nm * mount.interference.torque * self.torque
            }
            _ => Dual::constant(0.0),
        };
        let throttle = if throttle.is_finite() { throttle.clamp(0.0, 1.0) } else { 0.0 };
        let rate = self.law.acceleration(Dual::constant(throttle), omega, torque);
        let [up, down] = self.lag;
        rate / Slope::select(rate.less(omega.of(0.0)), down, up)
    }

    /// Lets the rotors turn for a time [s] under a command.
    fn turn(&mut self, throttle: &[f64; MAX_ROTORS], time_s: Slope) {
        if !(time_s.value > 0.0) {
            return;
        }
        let shortest = self.lag[0].value.min(self.lag[1].value);
        let steps = (time_s.value / (0.5 * self.longest_s * shortest)).ceil().clamp(1.0, 64.0);
        let h = time_s * (1.0 / steps);
        for (i, throttle) in throttle.iter().enumerate().take(self.count) {
            let (mut omega, mut turned) = (self.speed[i], Dual::constant(0.0));
            for _ in 0..steps as usize {
                let k1 = self.acceleration(i, *throttle, omega);
                let k2 = self.acceleration(i, *throttle, omega + h * k1 * 0.5);
                let k3 = self.acceleration(i, *throttle, omega + h * k2 * 0.5);
                let k4 = self.acceleration(i, *throttle, omega + h * k3);
                let next = omega + h * (k1 + (k2 + k3) * 2.0 + k4) * (1.0 / 6.0);
                turned += h * (omega + next) * 0.5 + h * h * (k1 - k4) * (1.0 / 12.0);
                omega = next;
            }
            (self.speed[i], self.turned[i]) = (omega, self.turned[i] + turned);
        }
    }
}
