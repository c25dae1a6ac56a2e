//! Parameters of the model of PX4's controller ([`crate::control::px4`]), from gains or a file and back.

use super::export::{curve_factor, export_for_law, hover_thrust};
use super::px4_required::{DropEnvelope, estimators_window};
use super::{Against, Export, Mixing, ParameterFile, ParamsError, Purpose, Subject, Value};
use crate::control::px4::estimator::Receiver;
use crate::control::px4::versions::ToldBy;
use crate::control::px4::{Law, Parameters, Window};
use crate::sim::sensors::Satellite;
use crate::time::seconds;

/// The parameters with which a PX4 of a law flies a subject: PX4's defaults, the vehicle's hover thrust and
/// thrust curve, velocities up to the subject's speed, and the file's parameters, or without a file the
/// subject's gains and limits in PX4's terms.
///
/// # Errors
/// [`ParamsError`] when the gains cannot be put in PX4's terms, PX4's mixer finds no unit for the rotors or
/// the law has no counterpart of what the subject asks for.
pub fn px4_model_parameters(
    subject: &Subject,
    purpose: Purpose,
    law: &Law,
    given: Option<&ParameterFile>,
) -> Result<Parameters, ParamsError> {
    let units = subject.units(Mixing::of(law))?;
    let fastest = subject.speed_m_s * purpose.factors(subject.environment.gravity_m_s2).k;
    let mut made = Parameters {
        thr_hover: f64::from(hover_thrust(subject.vehicle, subject.environment, &units) as f32),
        thr_mdl_fac: curve_factor(subject.limits.thrust_curve),
        xy_vel_max: fastest,
        z_vel_max_dn: fastest,
        ..law.defaults()
    };
    // Names that the model does not have are passed over.
    let mut take = |name: &str, value: Value| drop(made.set(name, value.as_f64()));
    match given {
        Some(file) => file.own().for_each(|(name, entry)| take(name, entry.value)),
        None => export_for_law(subject, purpose, law)?
            .parameters
            .iter()
            .for_each(|(name, value)| take(name, *value)),
    }
    Ok(made)
}

/// Least noise of a receiver's velocity that PX4 is to believe in [m/s].
const LEAST_SPEED_NOISE_M_S: f64 = 0.1;

/// What a PX4 of a law is told of a satellite receiver before a drop, where its clock runs slower than the
/// site's by `similarity`, Froude's k; `None`: the law's estimator is not modelled.
pub fn px4_receiver(satellite: &Satellite, law: &Law, similarity: f64) -> Option<Receiver> {
    let delay_s = seconds(satellite.delay_us) / similarity;
    let of = DropEnvelope { satellite_delay_s: Some(delay_s), ..DropEnvelope::default() };
    let longest_ms = |by| estimators_window(&of, by).iter().map(|(_, ms)| *ms).fold(0.0, f64::max);
    let told_ms = (1e3 * delay_s).round();
    let window_ms = match law.window? {
        Window::OldestSensor => longest_ms(ToldBy::Script),
        Window::DelayMax => longest_ms(ToldBy::Environment),
    };
    let [horizontal_m, vertical_m] = satellite.reported_accuracy_m();
    let us = |ms: f64| (1e3 * ms).round() as u64;
    let (told_delay_us, window_us) = (us(told_ms), us(window_ms));
    Some(Receiver { horizontal_m, vertical_m, told_delay_us, window_us })
}

/// Noise of a receiver's velocity that PX4 is to believe in (EKF2_GPS_V_NOISE) [m/s]: the receiver's own, but
/// no less than receivers claim of themselves at their best, since theirs is not white.
pub fn believed_speed_noise_m_s(satellite: &Satellite) -> f64 {
    satellite.speed_noise_m_s.max(LEAST_SPEED_NOISE_M_S)
}

/// Content of a parameter file with every parameter that a law reads, so that a flight does not depend on an
/// airframe's own defaults; the battery's only where anything is scaled by it.
pub fn px4_model_export(
    parameters: &Parameters,
    law: &Law,
    purpose: Purpose,
    gravity_m_s2: f64,
    remarks: Vec<String>,
) -> Export {
    let row = |name: &&str| Some(((*name).to_owned(), Value::Real(parameters.get(name)? as f32)));
    let rows = Parameters::NAMES
        .iter()
        .filter(|name| law.reads(name) && !parameters.is_idle(name))
        .filter_map(row)
        .collect();
    let against = Against::of_law(law);
    Export::checked(against, purpose, gravity_m_s2, rows, remarks).for_version(against)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::test_vehicles::{quadrotor, site};
    use crate::control::{ControlLimits, Gains};
    use crate::model::VehicleOptions;

    /// Property: what is written is what is read; without a file the gains are the export's; PX4's defaults
    /// stay where nothing is said.
    #[test]
    fn prop_parameters_survive_a_file() {
        let vehicle = quadrotor([0.95; 2], [890.0; 3], [0.0; 3], VehicleOptions::default());
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
        let (purpose, law) = (Purpose::Px4Froude, &Law::V1_12);
        let ours = px4_model_parameters(&subject, purpose, law, None).unwrap();
        let exported = crate::params::export_for_mixing(&subject, purpose, Mixing::QuadX).unwrap().parameters;
        assert_eq!(ours.pitch_p, exported["MC_PITCH_P"].as_f64());
        // The model's mixer is `quad_x`, which knows no distances: with arms of 0.5 m ahead and 1 m aside a
        // unit of roll is twice one of pitch.
        let wide = quadrotor([0.5, 1.0], [890.0; 3], [0.0; 3], VehicleOptions::default());
        let of_wide =
            px4_model_parameters(&Subject { vehicle: &wide, ..subject }, purpose, law, None).unwrap();
        let torque_per_rate = |k: f64, p: f64| k * p;
        let roll = torque_per_rate(of_wide.rollrate_k, of_wide.rollrate_p);
        let pitch = torque_per_rate(of_wide.pitchrate_k, of_wide.pitchrate_p);
        assert!((pitch / roll - 2.0).abs() < 1e-6, "{pitch} {roll}");
        assert_eq!(ours.thr_hover, exported["MPC_THR_HOVER"].as_f64());
        assert_eq!(ours.gyro_cutoff_hz, 40.0);
        let written = px4_model_export(&ours, &Law::V1_16, purpose, site.gravity_m_s2, Vec::new());
        let text = super::super::file::write("test", &written.notes(&[]), &written.parameters);
        let file = ParameterFile::parse(&text).unwrap();
        assert_eq!(file.purpose(), Some(purpose));
        let read = px4_model_parameters(&subject, purpose, law, Some(&file)).unwrap();
        for name in Parameters::NAMES {
            assert_eq!(read.get(name).unwrap() as f32, ours.get(name).unwrap() as f32, "{name}");
        }
    }
}
