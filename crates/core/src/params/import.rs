//! PX4 parameters as samara's gains and limits: the inverse of [`mod@crate::params::export`].
//!
//! A file is taken only where its numbers mean the same to samara's autopilot: written for samara under the
//! site's gravity, or - for PX4 or of unknown origin - under standard gravity, where all purposes agree. Its
//! rotors and its hover thrust, if it names them, must be the vehicle's. Values that the file does not hold
//! stay as they were.

use super::compatibility::written_for;
use super::export::{
    CURVE_PARAMETER, GAINS, LIMITS, SCALE_PARAMETER, TILT_PARAMETER, WITHOUT_COUNTERPART, curve_factor,
    hover_thrust, rotor_columns,
};
use super::file::{ParameterFile, Value};
use super::normalised::{Mixing, NormalisedUnits};
use super::purpose::{Factors, Purpose};
use super::{ParamsError, Subject};
use crate::control::{ControlLimits, Gains, ThrustCurve, TiltFrom};
use crate::model::Vehicle;
use crate::model::supply::{Pack, Throttle};
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
/// Rotors' axes whose components differ by more than this are another vehicle's.
const SAME_DIRECTION: f64 = 0.01;
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
    let purpose = written_for(file, gravity, Purpose::Samara)?;
    let number = |name: &str| file.get(name).map(Value::as_f64);
    let (curve, bent) = curve_of(number(CURVE_PARAMETER), subject.limits.thrust_curve);
    let subject = &Subject { limits: &ControlLimits { thrust_curve: curve, ..*subject.limits }, ..*subject };
    let units = subject.units(Mixing::Allocated)?;
    same_vehicle(file, subject, &units)?;
    let scale = Scale::new(&units, subject.vehicle, purpose.factors(gravity));
    let outer = GAINS.iter().map(|(names, ..)| names[0]);
    let names: Vec<&str> = outer.chain(scale.rate_gains().map(|(_, name, ..)| name)).collect();
    let missing: Vec<&str> = names.iter().copied().filter(|name| number(name).is_none()).collect();
    if missing.len() == names.len() {
        return Err(ParamsError::NoGains);
    }
    let (gains, mut limits) = adopt(&scale, &number, (subject.gains, subject.limits))?;
    let mut remarks = of_roll(&number, &gains, &scale);
    if !missing.is_empty() {
        remarks.push(format!("not in the file, left as they were: {}", missing.join(", ")));
    }
    let ignored: Vec<&str> =
        WITHOUT_COUNTERPART.into_iter().filter(|name| number(name).is_some_and(|x| x != 0.0)).collect();
    if !ignored.is_empty() {
        remarks.push(format!("not in samara's law, ignored: {}", ignored.join(", ")));
    }
    if let Some(decouples) = number(TILT_PARAMETER) {
        limits.tilt_from = if decouples == 0.0 { TiltFrom::Thrust } else { TiltFrom::Gravity };
    }
    if let Some(scales) = number(SCALE_PARAMETER) {
        let pack = subject.pack.map(Pack::limits).filter(|pack| pack.throttle == Throttle::Duty);
        limits.nominal_v = pack.filter(|_| scales != 0.0).map(|pack| pack.nominal_v);
        if scales != 0.0 && pack.is_none() {
            remarks.push(format!(
                "{SCALE_PARAMETER} is {scales}; the mission has no battery whose motors' throttle is a duty cycle, so nothing is scaled"
            ));
        }
    }
    remarks.extend(bent);
    Ok(Import { gains, limits, remarks })
}

/// The thrust curve of a file's [`CURVE_PARAMETER`], and a remark where samara has none such: then, as where
/// the file says nothing, the mission's own.
fn curve_of(factor: Option<f64>, own: ThrustCurve) -> (ThrustCurve, Option<String>) {
    let Some(factor) = factor else { return (own, None) };
    let same = |curve: &ThrustCurve| curve_factor(*curve) == factor;
    match [ThrustCurve::Quadratic, ThrustCurve::Linear].into_iter().find(same) {
        Some(curve) => (curve, None),
        None => {
            let curve = own.name();
            let remark = format!(
                "{CURVE_PARAMETER} is {factor}; samara's thrust is quadratic in the command, 1, or linear, 0: it is flown {curve}"
            );
            (own, Some(remark))
        }
    }
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
    let (mut gains, mut limits, f) = (*gains, *limits, &scale.factors);
    let take = |to: &mut f64, name: &str, factor: f64| *to = number(name).map_or(*to, |x| x * factor);
    for (names, gain, factor) in GAINS {
        take(gain(&mut gains), names[0], 1.0 / factor(f));
    }
    for (k_name, name, gain, factor) in scale.rate_gains() {
        // PX4's K is 1 where it is not set.
        take(gain(&mut gains), name, number(k_name).unwrap_or(1.0) * factor);
    }
    for (names, limit, factor) in LIMITS {
        take(limit(&mut limits), names[0], RAD_PER_DEG / factor(f));
    }
    take(&mut limits.rate_integral_rad_s2, "MC_PR_INT_LIM", scale.pitch);
    gains.validate()?;
    limits.validate()?;
    Ok((gains, limits))
}

/// Remarks on roll gains that differ from pitch's, which samara's roll loops use.
fn of_roll(number: &dyn Fn(&str) -> Option<f64>, gains: &Gains, scale: &Scale) -> Vec<String> {
    let f = &scale.factors;
    let k = number("MC_ROLLRATE_K").unwrap_or(1.0);
    let mut remarks = Vec::new();
    for (name, factor, pitch) in [
        ("MC_ROLLRATE_P", k * (scale.roll / f.torque_per_rate()), gains.k_pq),
        ("MC_ROLL_P", 1.0 / f.k, gains.k_ptheta),
    ] {
        if let Some(roll) = number(name).map(|x| x * factor)
            && !((roll - pitch).abs() <= SAME_GAIN * pitch.abs())
        {
            remarks.push(format!(
                "{name} means {roll:.6} 1/s; samara's roll loops have pitch's gain, {pitch:.6} 1/s"
            ));
        }
    }
    remarks
}

fn same_vehicle(file: &ParameterFile, subject: &Subject, units: &NormalisedUnits) -> Result<(), ParamsError> {
    let vehicle = subject.vehicle;
    let n = vehicle.rotors.len();
    if let Some(count) = file.get("CA_ROTOR_COUNT").map(Value::as_f64).filter(|c| *c != n as f64) {
        return of_another_vehicle("CA_ROTOR_COUNT", count, n as f64);
    }
    same_geometry(file, vehicle, subject.environment.density_kg_m3)?;
    let hover = hover_thrust(vehicle, subject.environment, units);
    match file.get("MPC_THR_HOVER").map(Value::as_f64) {
        Some(found) if !((found / hover - 1.0).abs() <= SAME_HOVER) => {
            of_another_vehicle("MPC_THR_HOVER", found, hover)
        }
        _ => Ok(()),
    }
}

fn of_another_vehicle(name: &str, found: f64, expected: f64) -> Result<(), ParamsError> {
    Err(ParamsError::DoesNotBelong(format!(
        "it is for another vehicle: {name} is {}, the mission's vehicle has {}",
        found as f32, expected as f32
    )))
}

/// Refuses rotors that lie, point or turn otherwise. Of positions only ratios count: PX4's allocation
/// normalises them, and PX4's own airframes have arms of 1.
fn same_geometry(file: &ParameterFile, vehicle: &Vehicle, density_kg_m3: f64) -> Result<(), ParamsError> {
    let number = |name: &str| file.get(name).map(Value::as_f64);
    let mut places = Vec::new();
    for (i, rotor) in vehicle.rotors.iter().enumerate() {
        let upright = rotor.axis_body.x == 0.0 && rotor.axis_body.y == 0.0;
        for (axis, position, direction) in rotor_columns(rotor) {
            let name = format!("CA_ROTOR{i}_A{axis}");
            if let Some(found) = number(&name).filter(|x| !((x - direction).abs() <= SAME_DIRECTION)) {
                return of_another_vehicle(&name, found, direction);
            }
            // How high it is does not count for a rotor that pushes straight up.
            let name = format!("CA_ROTOR{i}_P{axis}");
            if let Some(found) = number(&name).filter(|_| !(upright && axis == 'Z')) {
                places.push((name, found, position));
            }
        }
        let name = format!("CA_ROTOR{i}_KM");
        let ratio = rotor.spin.sign() * vehicle.torque_per_thrust_of_m(i, density_kg_m3);
        if let Some(found) = number(&name).filter(|found| found * ratio < 0.0) {
            return of_another_vehicle(&name, found, ratio);
        }
    }
    // The ratio that fits all places best.
    let products =
        |of: fn(f64, f64) -> f64| places.iter().map(|(_, found, own)| of(*found, *own)).sum::<f64>();
    let fitted = products(|found, own| found * own) / products(|_, own| own * own);
    let scale = if fitted.is_finite() && fitted > 0.0 { fitted } else { 1.0 };
    let arm = vehicle.rotors.iter().map(|r| r.position_body_m.norm()).fold(0.0, f64::max);
    let off = |(_, found, own): &&(String, f64, f64)| (found / scale - own).abs();
    match places.iter().max_by(|a, b| off(a).total_cmp(&off(b))) {
        Some(worst @ (name, found, own)) if !(off(&worst) <= SAME_PLACE * arm) => {
            of_another_vehicle(name, *found, own * scale)
        }
        _ => Ok(()),
    }
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

    /// The rate loops' gains: PX4's names of the loop's K and of the term, the gain, the factor from PX4's
    /// product of both.
    fn rate_gains(&self) -> impl Iterator<Item = RateGain> {
        let torque_per_rate = self.factors.torque_per_rate();
        let pitch: [RateGain; 2] = [
            ("MC_PITCHRATE_K", "MC_PITCHRATE_P", |k| &mut k.k_pq, self.pitch / torque_per_rate),
            ("MC_PITCHRATE_K", "MC_PITCHRATE_I", |k| &mut k.k_iq, self.pitch),
        ];
        let yaw = |yaw: f64| -> RateGain {
            ("MC_YAWRATE_K", "MC_YAWRATE_P", |k| &mut k.k_pr, yaw / torque_per_rate)
        };
        pitch.into_iter().chain(self.yaw.map(yaw))
    }
}

type RateGain = (&'static str, &'static str, fn(&mut Gains) -> &mut f64, f64);
