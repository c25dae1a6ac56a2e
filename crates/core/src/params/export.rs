//! samara's gains, limits and vehicle as PX4 parameters.
//!
//! The velocity and attitude loops are acceleration-normalised in PX4 as here; only the gravity that they
//! assume may differ ([`Purpose`]). The rate loop's `tau = K (P e + I-term - D dw/dt)` is in normalised
//! torque, so a gain of `k` [1/s] is `K P = k J/G` with the unit G of [`NormalisedUnits`], axis by axis; a P
//! outside PX4's range is moved to K, which changes nothing. The integral's limit is in normalised torque,
//! after K. samara's cascade has no derivative terms and no yaw rate integral, and PX4's defaults for those
//! are not zero, so they are written as zero.

use std::collections::BTreeMap;

use super::against::Against;
use super::check::overall_gain;
use super::file::{ParameterFile, Value};
use super::metadata::Metadata;
use super::normalised::{Mixing, NormalisedUnits, THRUST_COEFFICIENT};
use super::purpose::{Factors, GRAVITY_KEY, Purpose};
use super::{Check, Class, ParamsError, check};
use crate::control::px4::timing::ALIGNS_G0;
use crate::control::px4::versions::Number;
use crate::control::px4::{Law, is_quad_x};
use crate::control::{Airframe, ControlLimits, Gains, ThrustCurve, TiltFrom};
use crate::model::supply::Pack;
use crate::model::{Environment, Vehicle};
use crate::units::{DEG_PER_RAD, STANDARD_GRAVITY_M_S2};

/// A vehicle with its site, gains and limits.
#[derive(Clone, Copy, Debug)]
pub struct Subject<'a> {
    /// The vehicle, whose rotors and inertia give the units.
    pub vehicle: &'a Vehicle,
    /// Gravity and density of the air at the site.
    pub environment: &'a Environment,
    /// Gains of samara's cascade.
    pub gains: &'a Gains,
    /// Limits of the cascade.
    pub limits: &'a ControlLimits,
    /// Greatest speed of any velocity setpoint [m/s]: the safe speed.
    pub speed_m_s: f64,
    /// What the cascade's tilt is asked to come from; `None`: nothing is said of it.
    pub tilt_from: Option<TiltFrom>,
    /// The battery that the motors are on, where there is one.
    pub pack: Option<&'a Pack>,
}

impl Subject<'_> {
    /// PX4's units of the vehicle with the given mixing, under the thrust curve of the limits.
    ///
    /// # Errors
    /// [`ParamsError::NoUnit`] when the rotors cannot make roll, pitch or thrust; [`ParamsError::Control`]
    /// when they cannot be controlled.
    pub fn units(&self, mixing: Mixing) -> Result<NormalisedUnits, ParamsError> {
        let units = NormalisedUnits::mixed(self.vehicle, self.environment.density_kg_m3, mixing)?;
        let curve = self.limits.thrust_curve;
        if curve == ThrustCurve::Quadratic {
            return Ok(units);
        }
        let mixer = Airframe::new(self.vehicle, self.environment)?.with_thrust_curve(curve).mixer;
        let ratio = mixer.thrust_limit_n() / mixer.static_thrust_n();
        Ok(NormalisedUnits {
            roll_nm: units.roll_nm * ratio,
            pitch_nm: units.pitch_nm * ratio,
            yaw_nm: units.yaw_nm.map(|yaw_nm| yaw_nm * ratio),
            thrust_n: units.thrust_n * ratio,
        })
    }
}

/// Parameters for a purpose, with their check.
#[derive(Clone, Debug, PartialEq)]
pub struct Export {
    /// Purpose of the parameters.
    pub purpose: Purpose,
    /// Gravity of the site [m/s^2].
    pub gravity_m_s2: f64,
    /// Parameters by name.
    pub parameters: BTreeMap<String, Value>,
    /// Result of the check against PX4's ranges.
    pub check: Check,
    /// Remarks beyond the check.
    pub remarks: Vec<String>,
}

/// Exports a vehicle with its gains.
///
/// # Errors
/// [`ParamsError::Control`] when a gain or limit is out of range or the rotors cannot be controlled,
/// [`ParamsError::NoUnit`] when PX4's mixer finds no unit for them, [`ParamsError::NoCounterpart`] when the
/// subject asks for what a PX4 that mixes so does not have.
pub fn export(subject: &Subject, purpose: Purpose) -> Result<Export, ParamsError> {
    export_for_mixing(subject, purpose, Mixing::default())
}

/// Exports a vehicle with its gains for a PX4 of a law.
///
/// # Errors
/// As [`export`].
pub fn export_for_law(subject: &Subject, purpose: Purpose, law: &Law) -> Result<Export, ParamsError> {
    if purpose != Purpose::Samara {
        has_tilt_of(subject, law.may_couple_accelerations)?;
    }
    export_for(subject, purpose, Mixing::of(law), Against::of_law(law))
}

/// Exports a vehicle with its gains for a version of PX4.
///
/// # Errors
/// As [`export`].
pub fn export_for_version(subject: &Subject, purpose: Purpose, px4: Number) -> Result<Export, ParamsError> {
    let against = Against::asked(px4);
    if purpose != Purpose::Samara {
        has_tilt_of(subject, against.metadata.get(TILT_PARAMETER).is_some())?;
    }
    Ok(export_for(subject, purpose, Mixing::of_version(px4), against)?.for_version(against))
}

/// Exports a vehicle with its gains for a PX4 that mixes in the given way.
///
/// # Errors
/// As [`export`].
pub fn export_for_mixing(subject: &Subject, purpose: Purpose, mixing: Mixing) -> Result<Export, ParamsError> {
    export_for(subject, purpose, mixing, Against::newest())
}

fn export_for(
    subject: &Subject,
    purpose: Purpose,
    mixing: Mixing,
    against: Against,
) -> Result<Export, ParamsError> {
    subject.gains.validate()?;
    subject.limits.validate()?;
    Airframe::new(subject.vehicle, subject.environment)?;
    let gravity = subject.environment.gravity_m_s2;
    let mut rows =
        Rows { factors: purpose.factors(gravity), parameters: BTreeMap::new(), remarks: Vec::new() };
    let units = subject.units(mixing)?;
    rows.velocity_and_attitude(subject);
    rows.rates(subject, &units, against.metadata);
    rows.vehicle(subject, &units);
    if purpose != Purpose::Samara && mixing == Mixing::QuadX {
        has_tilt_of(subject, false)?;
    }
    rows.battery_and_tilt(subject, purpose);
    if purpose != Purpose::Samara {
        // PX4's tilt limit starts here and comes to MPC_TILTMAX_AIR by 0.2 rad/s only; a drop is in the air
        // at once.
        rows.real("MPC_TILTMAX_LND", subject.limits.tilt_rad * DEG_PER_RAD);
    }
    let Rows { parameters, mut remarks, .. } = rows;
    if purpose != Purpose::Samara && mixing == Mixing::Allocated {
        remarks.extend(for_quad_x(subject, &units)?);
    }
    if purpose == Purpose::Px4 && !ALIGNS_G0.contains(&(gravity / STANDARD_GRAVITY_M_S2)) {
        remarks.push(format!(
            "PX4's estimator aligns between 0.8 and 1.2 g0 only; under {gravity} m/s^2 it needs its state from outside, or px4-froude"
        ));
    }
    Ok(Export::checked(against, purpose, gravity, parameters, remarks))
}

/// Refuses a tilt that a PX4 without MPC_ACC_DECOUPLE does not have: it divides by gravity (v1.12.0's
/// `PositionControl.cpp`:179, v1.14.3's :207); v1.15.0 has the parameter (:209). `may_couple`: whether it is
/// there.
///
/// # Errors
/// [`ParamsError::NoCounterpart`].
pub(super) fn has_tilt_of(subject: &Subject, may_couple: bool) -> Result<(), ParamsError> {
    if subject.tilt_from == Some(TiltFrom::Thrust) && !may_couple {
        return Err(ParamsError::NoCounterpart {
            key: "control.tilt_from",
            found: TiltFrom::Thrust.name(),
            expected: TiltFrom::Gravity.name(),
            parameter: TILT_PARAMETER,
            since: "v1.15",
        });
    }
    Ok(())
}

/// Remarks on gains that a PX4 which mixes by a file needs otherwise, axis by axis: its mixer ignores
/// distances.
fn for_quad_x(subject: &Subject, allocated: &NormalisedUnits) -> Result<Vec<String>, ParamsError> {
    if let Err(reason) = is_quad_x(subject.vehicle) {
        return Ok(vec![format!(
            "for PX4 v1.14 and newer, which takes the rotors from CA_*; v1.12 mixes by files, and of those samara knows quad_x: {reason}"
        )]);
    }
    let by_file = subject.units(Mixing::QuadX)?;
    let axes = [
        ("ROLL", "RR", allocated.roll_nm / by_file.roll_nm),
        ("PITCH", "PR", allocated.pitch_nm / by_file.pitch_nm),
    ];
    let differs = axes.into_iter().filter(|(.., ratio)| (ratio - 1.0).abs() > 1e-6);
    Ok(differs
        .map(|(axis, short, ratio)| {
            format!(
                "MC_{axis}RATE_* are for a PX4 that allocates by CA_* (v1.14 and newer); for one that mixes by the file quad_x (v1.12) \
                 MC_{axis}RATE_K and MC_{short}_INT_LIM must be {ratio:.6} times these"
            )
        })
        .collect())
}

impl Export {
    /// Parameters for a purpose under a gravity [m/s^2], checked against the ranges of a version of PX4.
    pub(super) fn checked(
        against: Against,
        purpose: Purpose,
        gravity_m_s2: f64,
        parameters: BTreeMap<String, Value>,
        remarks: Vec<String>,
    ) -> Self {
        let rows = parameters.iter().map(|(name, value)| (name.as_str(), *value));
        let check = check(against, Some(purpose), rows);
        Self { purpose, gravity_m_s2, parameters, check, remarks }
    }

    /// This export with other parameters, checked anew.
    #[must_use]
    pub fn with(self, parameters: BTreeMap<String, Value>) -> Self {
        Self::checked(self.check.against, self.purpose, self.gravity_m_s2, parameters, self.remarks)
    }

    /// Of this export what a version of PX4 has, in its types. samara's own autopilot keeps all of it.
    #[must_use]
    pub fn for_version(mut self, against: Against) -> Self {
        let of_version = |(name, value): (String, Value)| {
            let kind = against.metadata.get(&name)?.kind;
            Some((name, value.in_type_of(kind.zero()).unwrap_or(value)))
        };
        let mut parameters = std::mem::take(&mut self.parameters);
        if self.purpose != Purpose::Samara {
            parameters = parameters.into_iter().filter_map(of_version).collect();
        }
        self.check.against = against;
        self.with(parameters)
    }

    /// Lines of the header: the file's purpose, gravity and origin (`origin`: lines of `Key: value`).
    pub fn notes(&self, origin: &[String]) -> Vec<String> {
        let against = self.check.against;
        let version =
            against.named.map(|_| format!("{}: {}", ParameterFile::PX4, against.metadata.version()));
        let mut notes = vec![
            format!("{}: {}", Purpose::KEY, self.purpose.name()),
            self.purpose.words().to_owned(),
            format!("{}: {} m/s^2", GRAVITY_KEY, self.gravity_m_s2),
        ];
        notes.extend(version.filter(|_| self.purpose != Purpose::Samara));
        if self.purpose == Purpose::Px4Froude {
            let k = self.purpose.factors(self.gravity_m_s2).k;
            notes.push(format!(
                "k = {k:.6}; dt_px4 = dt/k, v_px4 = k v, a_px4 = k^2 a; motor commands as they are"
            ));
        }
        notes.extend_from_slice(origin);
        // What goes by two names in PX4's versions is given by both.
        let findings = self.check.findings.iter().filter(|f| f.class != Class::OtherVersion);
        notes.extend(findings.map(|f| format!("Note: {}", f.text())));
        notes.extend(self.remarks.iter().map(|r| format!("Note: {r}")));
        notes
    }
}

/// Whether torque and thrust are scaled by the battery's voltage.
pub(super) const SCALE_PARAMETER: &str = "MC_BAT_SCALE_EN";
/// Whether the tilt is set against gravity (1) or the thrust wanted upwards (0).
pub(super) const TILT_PARAMETER: &str = "MPC_ACC_DECOUPLE";
/// The part of a motor's thrust that goes by the square of its command; the rest is linear.
pub(super) const CURVE_PARAMETER: &str = "THR_MDL_FAC";
/// Parameters that say how the cascade works, not how fast: read with the gains of a file.
pub const OF_THE_CASCADE: [&str; 2] = [SCALE_PARAMETER, TILT_PARAMETER];
/// The square's part in a thrust curve ([`CURVE_PARAMETER`]).
pub(super) fn curve_factor(curve: ThrustCurve) -> f64 {
    match curve {
        ThrustCurve::Quadratic => 1.0,
        ThrustCurve::Linear => 0.0,
    }
}

/// Voltage of a full cell [V] by which cells are counted.
const FULL_CELL_V: f64 = 4.2;
/// Part of it by which a battery's cells may differ from it.
const SAME_CELL: f64 = 0.03;

/// Number of cells in series of a full battery's voltage [V]; `None` when no number PX4 takes fits.
fn cells(full_v: f64) -> Option<i32> {
    let count = (full_v / FULL_CELL_V).round();
    let fits = (1.0..=16.0).contains(&count) && (full_v / count / FULL_CELL_V - 1.0).abs() <= SAME_CELL;
    fits.then_some(count as i32)
}

/// Terms of PX4's controller that samara's cascade does not have; exported as zero.
pub(super) const WITHOUT_COUNTERPART: [&str; 9] = [
    "MC_PITCHRATE_D",
    "MC_PITCHRATE_FF",
    "MC_ROLLRATE_D",
    "MC_ROLLRATE_FF",
    "MC_YAWRATE_D",
    "MC_YAWRATE_FF",
    "MC_YAWRATE_I",
    "MPC_XY_VEL_D_ACC",
    "MPC_Z_VEL_D_ACC",
];

/// PX4's names for a number of the cascade: written under each, read from the first (pitch's; samara's roll
/// uses pitch's gains). Where the number stands in `T`; the purpose's factor on it.
type Row<T> = (&'static [&'static str], fn(&mut T) -> &mut f64, fn(&Factors) -> f64);

/// Gains of the velocity and attitude loops.
pub(super) const GAINS: [Row<Gains>; 6] = [
    (&["MPC_XY_VEL_P_ACC"], |k| &mut k.k_pvx, |f| f.acceleration_per_velocity),
    (&["MPC_XY_VEL_I_ACC"], |k| &mut k.k_ivx, |f| f.acceleration_per_distance),
    (&["MPC_Z_VEL_P_ACC"], |k| &mut k.k_pvz, |f| f.acceleration_per_velocity),
    (&["MPC_Z_VEL_I_ACC"], |k| &mut k.k_ivz, |f| f.acceleration_per_distance),
    (&["MC_PITCH_P", "MC_ROLL_P"], |k| &mut k.k_ptheta, |f| f.k),
    (&["MC_YAW_P"], |k| &mut k.k_ppsi, |f| f.k),
];

/// Limits of angles and rates, which PX4 has in degrees.
pub(super) const LIMITS: [Row<ControlLimits>; 3] = [
    (&["MPC_TILTMAX_AIR"], |l| &mut l.tilt_rad, |_| 1.0),
    (&["MC_PITCHRATE_MAX", "MC_ROLLRATE_MAX"], |l| &mut l.rate_command_rad_s, |f| f.k),
    (&["MC_YAWRATE_MAX"], |l| &mut l.yaw_rate_command_rad_s, |f| f.k),
];

struct Rows {
    factors: Factors,
    parameters: BTreeMap<String, Value>,
    remarks: Vec<String>,
}

impl Rows {
    fn real(&mut self, name: &str, x: f64) {
        self.parameters.insert(name.to_owned(), Value::Real(x as f32));
    }

    fn int(&mut self, name: &str, i: i32) {
        self.parameters.insert(name.to_owned(), Value::Int(i));
    }

    fn velocity_and_attitude(&mut self, subject: &Subject) {
        let (f, mut gains, mut limits) = (self.factors, *subject.gains, *subject.limits);
        for (names, gain, factor) in GAINS {
            names.iter().for_each(|name| self.real(name, *gain(&mut gains) * factor(&f)));
        }
        for (names, limit, factor) in LIMITS {
            names.iter().for_each(|name| self.real(name, *limit(&mut limits) * DEG_PER_RAD * factor(&f)));
        }
        // PX4 clips velocity setpoints; no setpoint of a safe plan is faster than the safe speed.
        self.real("MPC_Z_VEL_MAX_DN", subject.speed_m_s * f.k);
        self.real("MPC_XY_VEL_MAX", subject.speed_m_s * f.k);
        for name in WITHOUT_COUNTERPART {
            self.real(name, 0.0);
        }
    }

    fn rates(&mut self, subject: &Subject, units: &NormalisedUnits, metadata: Metadata) {
        let inertia = &subject.vehicle.mass.inertia_kg_m2;
        if (0..3).any(|i| (0..3).any(|j| i != j && inertia[(i, j)].abs() > 1e-6 * inertia[(i, i)])) {
            self.remarks.push("products of inertia are left out: PX4's rate loops know none".to_owned());
        }
        let (f, gains, limits) = (self.factors, subject.gains, subject.limits);
        for (axis, j, g, k_p, limit) in [
            ("PITCH", inertia[(1, 1)], Some(units.pitch_nm), gains.k_pq, Some("MC_PR_INT_LIM")),
            ("ROLL", inertia[(0, 0)], Some(units.roll_nm), gains.k_pq, Some("MC_RR_INT_LIM")),
            ("YAW", inertia[(2, 2)], units.yaw_nm, gains.k_pr, None),
        ] {
            let Some(g) = g else {
                self.remarks.push(format!("MC_{axis}RATE_* is left out: the rotors have no torque"));
                continue;
            };
            let name = |term: &str| format!("MC_{axis}RATE_{term}");
            let p = k_p * j / g * f.torque_per_rate();
            let k = overall_gain(metadata, &name("K"), &name("P"), p).unwrap_or(1.0);
            self.real(&name("K"), k);
            self.real(&name("P"), p / k);
            if let Some(limit) = limit {
                self.real(&name("I"), gains.k_iq * j / g / k);
                self.real(limit, limits.rate_integral_rad_s2 * j / g);
            }
        }
    }

    /// What is said of the tilt, and where the motors are on a battery, whether its voltage counts. PX4
    /// counts it from a full cell on: it gets the cells.
    fn battery_and_tilt(&mut self, subject: &Subject, purpose: Purpose) {
        if let Some(from) = subject.tilt_from {
            self.int(TILT_PARAMETER, (from == TiltFrom::Gravity).into());
            if purpose != Purpose::Samara && from == TiltFrom::Thrust {
                self.remarks.push(format!(
                    "{TILT_PARAMETER} 0 is control.tilt_from: thrust; PX4 has it from v1.15 on, earlier ones set the tilt against gravity"
                ));
            }
        }
        let Some(pack) = subject.pack else { return };
        let (scales, full_v) = (subject.limits.nominal_v.is_some(), pack.open_circuit_v(1.0));
        self.int(SCALE_PARAMETER, scales.into());
        if !scales || purpose == Purpose::Samara {
            return;
        }
        let Some(count) = cells(full_v) else {
            self.remarks.push(format!(
                "{SCALE_PARAMETER} is 1 (control.battery_scaling), but {full_v} V of a full battery is no number of cells of {FULL_CELL_V} V: \
                 set BAT1_N_CELLS, BAT1_V_CHARGED, BAT1_V_EMPTY and BAT1_R_INTERNAL, or PX4 scales nothing"
            ));
            return;
        };
        let of_a_cell = |of_the_pack: f64| of_the_pack / f64::from(count);
        self.int("BAT1_N_CELLS", count);
        self.real("BAT1_V_CHARGED", of_a_cell(full_v));
        self.real("BAT1_V_EMPTY", of_a_cell(pack.open_circuit_v(0.0)));
        self.real("BAT1_R_INTERNAL", of_a_cell(pack.limits().resistance_ohm));
        self.remarks.push(format!(
            "{SCALE_PARAMETER} is control.battery_scaling; BAT1_N_CELLS, BAT1_V_CHARGED, BAT1_V_EMPTY and BAT1_R_INTERNAL are battery.electric: \
             open_circuit full and empty, internal_resistance_ohm, over {count} cells of {FULL_CELL_V} V"
        ));
        let nominal_v = pack.limits().nominal_v;
        self.remarks.push(format!(
            "PX4 scales from a full battery on, samara from {nominal_v} V (battery.electric.motor.nominal_v): at {nominal_v} V without load \
             PX4's thrust and torque are {:.3} times those of the gains",
            (full_v / nominal_v).clamp(1.0, 1.3)
        ));
    }

    fn vehicle(&mut self, subject: &Subject, units: &NormalisedUnits) {
        let (vehicle, environment) = (subject.vehicle, subject.environment);
        self.real("MPC_THR_HOVER", hover_thrust(vehicle, environment, units));
        self.real(CURVE_PARAMETER, curve_factor(subject.limits.thrust_curve));
        self.int("CA_AIRFRAME", 0);
        self.int("CA_ROTOR_COUNT", vehicle.rotors.len() as i32);
        for (i, rotor) in vehicle.rotors.iter().enumerate() {
            for (axis, position, direction) in rotor_columns(rotor) {
                self.real(&format!("CA_ROTOR{i}_P{axis}"), position);
                self.real(&format!("CA_ROTOR{i}_A{axis}"), direction);
            }
            let torque_per_thrust = vehicle.torque_per_thrust_of_m(i, environment.density_kg_m3);
            self.real(&format!("CA_ROTOR{i}_CT"), THRUST_COEFFICIENT * rotor.interference.thrust);
            self.real(&format!("CA_ROTOR{i}_KM"), rotor.spin.sign() * torque_per_thrust);
        }
    }
}

/// Axis letter, position [m] and direction of a rotor, body axes.
pub(super) fn rotor_columns(rotor: &crate::model::RotorMount) -> [(char, f64, f64); 3] {
    let (p, a) = (&rotor.position_body_m, &rotor.axis_body);
    [('X', p.x, a.x), ('Y', p.y, a.y), ('Z', p.z, a.z)]
}

/// Normalised collective that carries the weight.
pub(super) fn hover_thrust(vehicle: &Vehicle, environment: &Environment, units: &NormalisedUnits) -> f64 {
    vehicle.mass.mass_kg * environment.gravity_m_s2 / units.thrust_n
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::test_vehicles::{THRUST_LIMIT_N, quadrotor, site};
    use crate::model::VehicleOptions;

    fn exported(arm_m: f64, j: f64, k_pq: f64, purpose: Purpose) -> BTreeMap<String, Value> {
        let vehicle = quadrotor([arm_m; 2], [j; 3], [0.0; 3], VehicleOptions::default());
        let gains = Gains { k_pq, ..Gains::near_hover() };
        let limits = ControlLimits::default();
        let subject = Subject {
            vehicle: &vehicle,
            environment: &site(),
            gains: &gains,
            limits: &limits,
            speed_m_s: 12.0,
            tilt_from: None,
            pack: None,
        };
        export(&subject, purpose).unwrap().parameters
    }

    fn number(parameters: &BTreeMap<String, Value>, name: &str) -> f64 {
        parameters[name].as_f64()
    }

    /// 1.5 kg class: J 0.02, arm 0.17678 m, T_max 7.355 N, K 15 1/s gives 0.0816. Inertia scales with thrust
    /// here.
    #[test]
    fn closed_form_the_rate_gain_of_a_small_quadrotor() {
        let rows = exported(0.17678, 0.02 * THRUST_LIMIT_N / 7.355, 15.0, Purpose::Samara);
        assert!((number(&rows, "MC_PITCHRATE_P") - 0.0816).abs() < 5e-5, "{rows:?}");
        assert_eq!((number(&rows, "MC_PITCHRATE_K"), rows["MC_ROLLRATE_P"]), (1.0, rows["MC_PITCHRATE_P"]));
    }

    /// T_max 300 N, arm 1 m, J 300, K 2: 0.707 is above the range and goes to K 2, P 0.354; P above 3 has no
    /// place.
    #[test]
    fn closed_form_a_large_rate_gain_goes_to_the_overall_gain() {
        let j = 300.0 * THRUST_LIMIT_N / 300.0;
        let rows = exported(1.0, j, 2.0, Purpose::Samara);
        assert_eq!(number(&rows, "MC_PITCHRATE_K"), 2.0);
        assert!((number(&rows, "MC_PITCHRATE_P") - 0.5 / 2f64.sqrt()).abs() < 1e-7);
        let i = number(&rows, "MC_PITCHRATE_I") * 2.0;
        assert!((i - 0.001 * 0.5 / 2f64.sqrt()).abs() < 1e-9);
        for (k_pq, k) in [(0.01, 0.25), (7.0, 5.0), (20.0, 1.0)] {
            assert_eq!(number(&exported(1.0, j, k_pq, Purpose::Samara), "MC_PITCHRATE_K"), k, "{k_pq}");
        }
    }

    /// With arms of 0.95 m ahead and 1.1 m aside the allocator's unit of roll is 0.95/1.1 of the mixer
    /// file's: the file's gain is smaller so.
    #[test]
    fn closed_form_roll_gains_are_for_one_kind_of_mixing_and_say_so() {
        let vehicle = quadrotor([0.95, 1.1], [300.0; 3], [0.0; 3], VehicleOptions::default());
        let (gains, limits, site) = (Gains::near_hover(), ControlLimits::default(), site());
        let subject = Subject {
            vehicle: &vehicle,
            environment: &site,
            gains: &gains,
            limits: &limits,
            speed_m_s: 12.0,
            tilt_from: None,
            pack: None,
        };
        let [allocated, by_file] = [Mixing::Allocated, Mixing::QuadX]
            .map(|mixing| export_for_mixing(&subject, Purpose::Px4Froude, mixing).unwrap());
        let torque = |e: &Export, axis: &str| {
            number(&e.parameters, &format!("MC_{axis}RATE_K"))
                * number(&e.parameters, &format!("MC_{axis}RATE_P"))
        };
        assert!((torque(&by_file, "ROLL") / torque(&allocated, "ROLL") - 0.95 / 1.1).abs() < 1e-6);
        assert!((torque(&by_file, "PITCH") / torque(&allocated, "PITCH") - 1.0).abs() < 1e-6);
        let [remark] = allocated.remarks.as_slice() else { panic!("{:?}", allocated.remarks) };
        assert!(remark.contains("MC_ROLLRATE_K and MC_RR_INT_LIM must be 0.863636 times"), "{remark}");
        assert!(by_file.remarks.is_empty());
    }

    #[test]
    fn closed_form_the_three_purposes() {
        let [samara, px4, froude] = Purpose::ALL.map(|p| exported(1.0, 300.0, 2.0, p));
        let k = (STANDARD_GRAVITY_M_S2 / 1.35).sqrt();
        assert!((k - 2.695).abs() < 5e-4);
        for (name, for_px4, for_froude) in [
            ("MPC_XY_VEL_P_ACC", k * k, k),
            ("MPC_XY_VEL_I_ACC", k * k, k * k),
            ("MPC_Z_VEL_P_ACC", k * k, k),
            ("MPC_Z_VEL_I_ACC", k * k, k * k),
            ("MC_PITCH_P", 1.0, k),
            ("MC_ROLL_P", 1.0, k),
            ("MC_YAW_P", 1.0, k),
            ("MC_PITCHRATE_I", 1.0, 1.0),
            ("MC_PR_INT_LIM", 1.0, 1.0),
            ("MC_PITCHRATE_MAX", 1.0, k),
            ("MPC_Z_VEL_MAX_DN", 1.0, k),
            ("MPC_TILTMAX_AIR", 1.0, 1.0),
            ("MPC_THR_HOVER", 1.0, 1.0),
            ("CA_ROTOR2_PX", 1.0, 1.0),
        ] {
            let one = number(&samara, name);
            assert!((number(&px4, name) / one - for_px4).abs() < 1e-6, "{name}");
            assert!((number(&froude, name) / one - for_froude).abs() < 1e-6, "{name}");
        }
        // Not a parameter of samara's autopilot.
        assert!(px4["MPC_TILTMAX_LND"] == px4["MPC_TILTMAX_AIR"] && !samara.contains_key("MPC_TILTMAX_LND"));
        let product = |rows| {
            number(rows, "MC_PITCHRATE_P") * number(rows, "MC_PITCHRATE_K")
                / number(&samara, "MC_PITCHRATE_P")
        };
        assert!((product(&froude) * k - 1.0).abs() < 1e-6 && (product(&px4) - 1.0).abs() < 1e-6);
    }
}
