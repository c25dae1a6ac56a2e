//! PX4 parameters as samara's gains and limits: the inverse of [`crate::params::export`].
//!
//! A file is taken only where its numbers mean the same to samara's autopilot: written for samara under the
//! site's gravity, or - for PX4 or of unknown origin - under standard gravity, where all purposes agree. Its
//! rotors and its hover thrust, if it names them, must be the vehicle's. Values that the file does not hold
//! stay as they were.

use super::compatibility::to_samara;
use super::export::{WITHOUT_COUNTERPART, hover_thrust, rotor_columns};
use super::file::{ParameterFile, Value};
use super::normalised::NormalisedUnits;
use super::purpose::Factors;
use super::{ParamsError, Subject};
use crate::control::{ControlLimits, Gains};
use crate::model::Vehicle;
use crate::units::RAD_PER_DEG;

/// Gains and limits read from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Import {
    /// Gains of samara's cascade.
    pub gains: Gains,
    /// Limits of samara's cascade.
    pub limits: ControlLimits,
    /// Parameters that the file leaves out, or that samara's cascade cannot follow.
    pub remarks: Vec<String>,
}

/// Hover thrusts that differ by more than this part are another vehicle's.
const SAME_HOVER: f64 = 0.02;
/// Rotor positions that differ by more than this part of the arm are another vehicle's.
const SAME_PLACE: f64 = 0.01;
/// Roll and pitch gains that differ by more than this part differ beyond the rounding to single precision.
const SAME_GAIN: f64 = 1e-5;

/// Gains and limits of a file for the subject, whose own stand in for what the file leaves out.
///
/// # Errors
/// [`ParamsError::DoesNotBelong`] when the file is for another autopilot, gravity or vehicle,
/// [`ParamsError::NoGains`] when there is nothing to take, [`ParamsError::Control`] when a gain or limit is
/// out of range.
pub fn import(file: &ParameterFile, subject: &Subject) -> Result<Import, ParamsError> {
    let gravity = subject.environment.gravity_m_s2;
    let purpose = to_samara(file, gravity)?;
    let units = NormalisedUnits::of(subject.vehicle, subject.environment.density_kg_m3)?;
    same_vehicle(file, subject, &units)?;
    let scale = Scale::new(&units, subject.vehicle, purpose.factors(gravity));
    let number = |name: &str| file.get(name).map(Value::as_f64);
    let mut reader = Reader { number: &number, missing: Vec::new(), taken: 0, remarks: Vec::new() };
    let gains = reader.gains(&scale, subject.gains);
    if reader.taken == 0 {
        return Err(ParamsError::NoGains);
    }
    let limits = reader.limits(&scale, subject.limits);
    gains.validate()?;
    limits.validate()?;
    reader.compare_roll(&gains, &scale);
    Ok(Import { gains, limits, remarks: reader.finish() })
}

/// The given gains and limits, with those replaced that `number` has under PX4's names; the others stay as
/// they are, to the bit. For K of a rate loop to count, its P and I must be there as well.
///
/// # Errors
/// [`ParamsError::Control`] when a gain or limit is out of range.
pub fn adopt(
    scale: &Scale,
    number: &dyn Fn(&str) -> Option<f64>,
    (gains, limits): (&Gains, &ControlLimits),
) -> Result<(Gains, ControlLimits), ParamsError> {
    let mut reader = Reader { number, missing: Vec::new(), taken: 0, remarks: Vec::new() };
    let (gains, limits) = (reader.gains(scale, gains), reader.limits(scale, limits));
    gains.validate()?;
    limits.validate()?;
    Ok((gains, limits))
}

fn same_vehicle(file: &ParameterFile, subject: &Subject, units: &NormalisedUnits) -> Result<(), ParamsError> {
    let refuse = |name: &str, found: f64, expected: f64| {
        Err(ParamsError::DoesNotBelong(format!(
            "it is for another vehicle: {name} is {}, the mission's vehicle has {}",
            found as f32, expected as f32
        )))
    };
    let vehicle = subject.vehicle;
    let n = vehicle.rotors.len();
    if let Some(count) = file.get("CA_ROTOR_COUNT").map(Value::as_f64).filter(|c| *c != n as f64) {
        return refuse("CA_ROTOR_COUNT", count, n as f64);
    }
    let arm = arm_m(vehicle);
    for (i, rotor) in vehicle.rotors.iter().enumerate() {
        for (axis, position, direction) in rotor_columns(rotor) {
            for (name, expected, scale) in [
                (format!("CA_ROTOR{i}_P{axis}"), position, arm),
                (format!("CA_ROTOR{i}_A{axis}"), direction, 1.0),
            ] {
                let found = file.get(&name).map(Value::as_f64);
                if let Some(found) = found.filter(|x| !((x - expected).abs() <= SAME_PLACE * scale)) {
                    return refuse(&name, found, expected);
                }
            }
        }
    }
    let hover = hover_thrust(vehicle, subject.environment, units);
    match file.get("MPC_THR_HOVER").map(Value::as_f64) {
        Some(found) if !((found / hover - 1.0).abs() <= SAME_HOVER) => refuse("MPC_THR_HOVER", found, hover),
        _ => Ok(()),
    }
}

fn arm_m(vehicle: &Vehicle) -> f64 {
    vehicle.rotors.iter().map(|r| r.position_body_m.norm()).fold(0.0, f64::max)
}

/// Factors from PX4's normalised numbers to a vehicle's physical ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    factors: Factors,
    /// Angular roll acceleration per normalised torque [1/s^2].
    pub roll: f64,
    /// Angular pitch acceleration per normalised torque [1/s^2].
    pub pitch: f64,
    /// Angular yaw acceleration per normalised torque [1/s^2]; `None` when the rotors have no torque.
    pub yaw: Option<f64>,
}

impl Scale {
    /// The scale of a vehicle with its normalised units, for a purpose's factors.
    pub fn new(units: &NormalisedUnits, vehicle: &Vehicle, factors: Factors) -> Self {
        let inertia = &vehicle.mass.inertia_kg_m2;
        Self {
            factors,
            roll: units.roll_nm / inertia[(0, 0)],
            pitch: units.pitch_nm / inertia[(1, 1)],
            yaw: units.yaw_nm.map(|yaw_nm| yaw_nm / inertia[(2, 2)]),
        }
    }
}

struct Reader<'a> {
    number: &'a dyn Fn(&str) -> Option<f64>,
    missing: Vec<String>,
    taken: usize,
    remarks: Vec<String>,
}

impl Reader<'_> {
    fn number(&self, name: &str) -> Option<f64> {
        (self.number)(name)
    }

    fn gains(&mut self, scale: &Scale, old: &Gains) -> Gains {
        let f = &scale.factors;
        let mut gains = Gains {
            k_pvx: self.gain("MPC_XY_VEL_P_ACC", 1.0 / f.acceleration_per_velocity, old.k_pvx),
            k_ivx: self.gain("MPC_XY_VEL_I_ACC", 1.0 / f.acceleration_per_distance, old.k_ivx),
            k_pvz: self.gain("MPC_Z_VEL_P_ACC", 1.0 / f.acceleration_per_velocity, old.k_pvz),
            k_ivz: self.gain("MPC_Z_VEL_I_ACC", 1.0 / f.acceleration_per_distance, old.k_ivz),
            k_ptheta: self.gain("MC_PITCH_P", 1.0 / f.rate_per_angle, old.k_ptheta),
            k_ppsi: self.gain("MC_YAW_P", 1.0 / f.rate_per_angle, old.k_ppsi),
            k_pq: self.rate_gain("PITCH", 'P', scale.pitch / f.torque_per_rate, old.k_pq),
            k_iq: self.rate_gain("PITCH", 'I', scale.pitch / f.torque_per_angle, old.k_iq),
            k_pr: old.k_pr,
        };
        if let Some(yaw) = scale.yaw {
            gains.k_pr = self.rate_gain("YAW", 'P', yaw / f.torque_per_rate, old.k_pr);
        }
        gains
    }

    fn limits(&mut self, scale: &Scale, old: &ControlLimits) -> ControlLimits {
        let rate = RAD_PER_DEG / scale.factors.rate;
        ControlLimits {
            tilt_rad: self.limit("MPC_TILTMAX_AIR", RAD_PER_DEG, old.tilt_rad),
            rate_command_rad_s: self.limit("MC_PITCHRATE_MAX", rate, old.rate_command_rad_s),
            yaw_rate_command_rad_s: self.limit("MC_YAWRATE_MAX", rate, old.yaw_rate_command_rad_s),
            rate_integral_rad_s2: self.limit("MC_PR_INT_LIM", scale.pitch, old.rate_integral_rad_s2),
        }
    }

    fn gain(&mut self, name: &str, factor: f64, otherwise: f64) -> f64 {
        match self.number(name) {
            Some(x) => {
                self.taken += 1;
                x * factor
            }
            None => {
                self.missing.push(name.to_owned());
                otherwise
            }
        }
    }

    /// Product of K and a term of a rate loop; PX4's K is 1 where it is not set.
    fn rate_gain(&mut self, axis: &str, term: char, factor: f64, otherwise: f64) -> f64 {
        let k = self.number(&format!("MC_{axis}RATE_K")).unwrap_or(1.0);
        self.gain(&format!("MC_{axis}RATE_{term}"), k * factor, otherwise)
    }

    fn limit(&mut self, name: &str, factor: f64, otherwise: f64) -> f64 {
        self.number(name).map_or(otherwise, |x| x * factor)
    }

    /// Remarks on roll gains that differ from pitch's, which samara's roll loops use.
    fn compare_roll(&mut self, gains: &Gains, scale: &Scale) {
        let f = &scale.factors;
        let (rate_factor, angle_factor) = (scale.roll / f.torque_per_rate, 1.0 / f.rate_per_angle);
        let k = self.number("MC_ROLLRATE_K").unwrap_or(1.0);
        for (name, factor, pitch) in
            [("MC_ROLLRATE_P", k * rate_factor, gains.k_pq), ("MC_ROLL_P", angle_factor, gains.k_ptheta)]
        {
            if let Some(roll) = self.number(name).map(|x| x * factor)
                && !((roll - pitch).abs() <= SAME_GAIN * pitch.abs())
            {
                self.remarks.push(format!(
                    "{name} means {roll:.6} 1/s; samara's roll loops have pitch's gain, {pitch:.6} 1/s"
                ));
            }
        }
    }

    fn finish(mut self) -> Vec<String> {
        if !self.missing.is_empty() {
            self.remarks.push(format!("not in the file, left as they were: {}", self.missing.join(", ")));
        }
        let ignored: Vec<&str> = WITHOUT_COUNTERPART
            .into_iter()
            .filter(|name| self.number(name).is_some_and(|x| x != 0.0))
            .collect();
        if !ignored.is_empty() {
            self.remarks.push(format!("not in samara's law, ignored: {}", ignored.join(", ")));
        }
        if let Some(f) = self.number("THR_MDL_FAC").filter(|f| *f != 1.0) {
            self.remarks.push(format!("THR_MDL_FAC is {f}; samara's thrust is quadratic in the command, 1"));
        }
        self.remarks
    }
}
