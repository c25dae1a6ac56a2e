//! Files read back: round trips, and where a file does not belong.

use proptest::prelude::*;

use super::export::{SCALE_PARAMETER, TILT_PARAMETER, export};
use super::file::write;
use super::*;
use crate::control::px4::Law;
use crate::control::test_vehicles::{lander, site};
use crate::control::{ControlLimits, Gains, ThrustCurve, TiltFrom};
use crate::model::supply::{Pack, PackLimits, Throttle};
use crate::model::{Environment, Vehicle};
use crate::units::STANDARD_GRAVITY_M_S2;

fn at(gravity_m_s2: f64) -> Environment {
    Environment { gravity_m_s2, ..site() }
}

/// The file that samara writes, read back with other gains as its ground.
fn round_trip(gains: &Gains, purpose: Purpose, environment: &Environment) -> Result<Import, ParamsError> {
    let (vehicle, limits) = (lander(true), ControlLimits::default());
    let subject = Subject {
        vehicle: &vehicle,
        environment,
        gains,
        limits: &limits,
        speed_m_s: 12.0,
        tilt_from: None,
        pack: None,
    };
    let written = export(&subject, purpose).unwrap();
    let file = ParameterFile::parse(&write("x", &written.notes(&[]), &written.parameters)).unwrap();
    assert_eq!(file.purpose(), Some(purpose));
    let other = ControlLimits { tilt_rad: 0.1, rate_integral_rad_s2: 1.0, ..limits };
    import(&file, &Subject { gains: &Gains::near_hover(), limits: &other, ..subject })
}

fn all(import: &Import) -> [f64; 13] {
    let (g, l) = (&import.gains, &import.limits);
    let [a, b, c, d, e, f, h] = g.as_longitudinal();
    [
        a,
        b,
        c,
        d,
        e,
        f,
        h,
        g.k_ppsi,
        g.k_pr,
        l.tilt_rad,
        l.rate_command_rad_s,
        l.yaw_rate_command_rad_s,
        l.rate_integral_rad_s2,
    ]
}

proptest! {
    /// Exported gains come back to the rounding of single precision, for every purpose where it belongs.
    #[test]
    fn prop_what_is_exported_is_imported(k in prop::array::uniform9(1e-4f64..5.0), which in 0usize..4) {
        let [a, b, c, d, e, f, g, k_ppsi, k_pr] = k;
        let gains = Gains { k_ppsi, k_pr, ..Gains::longitudinal([a, b, c, d, e, f, g]) };
        let gravity = if which == 3 { 1.35 } else { STANDARD_GRAVITY_M_S2 };
        let purpose = Purpose::ALL[which % 3];
        let back = round_trip(&gains, purpose, &at(gravity)).unwrap();
        prop_assert!(back.remarks.is_empty(), "{:?}", back.remarks);
        let expected = Import { gains, limits: ControlLimits::default(), remarks: Vec::new() };
        for (found, expected) in all(&back).into_iter().zip(all(&expected)) {
            // A product of two rounded numbers.
            prop_assert!((found / expected - 1.0).abs() < 1.3e-7, "{found} {expected}");
        }
    }
}

#[test]
fn a_file_is_refused_where_it_does_not_belong() {
    let gains = Gains::paper_pso();
    for purpose in [Purpose::Px4, Purpose::Px4Froude] {
        let error = round_trip(&gains, purpose, &at(1.35)).unwrap_err().to_string();
        assert!(error.contains(purpose.name()) && error.contains("1.35"), "{error}");
    }
    let (vehicle, limits, titan, earth) =
        (lander(true), ControlLimits::default(), at(1.35), at(STANDARD_GRAVITY_M_S2));
    let on = |environment| Subject {
        vehicle: &vehicle,
        environment,
        gains: &gains,
        limits: &limits,
        speed_m_s: 12.0,
        tilt_from: None,
        pack: None,
    };
    let refused = |text: &str, environment, expected: &str| {
        let error = import(&ParameterFile::parse(text).unwrap(), &on(environment)).unwrap_err().to_string();
        assert!(error.contains(expected), "{text}: {error}");
    };
    let gain = "1\t1\tMC_PITCH_P\t4\t9";
    refused(gain, &titan, "does not say what it is for");
    refused(&format!("# For: samara\n# Gravity: 1.35 m/s^2\n{gain}"), &earth, "gravity of 1.35");
    refused(&format!("# For: samara\n# Gravity: Titan\n{gain}"), &titan, "positive number");
    let row =
        |name: &str, value: &str, kind: u8| format!("# For: samara\n{gain}\n1\t1\t{name}\t{value}\t{kind}");
    refused(&row("CA_ROTOR_COUNT", "6", 6), &titan, "CA_ROTOR_COUNT is 6");
    refused(&row("CA_ROTOR1_PX", "0.95", 9), &titan, "CA_ROTOR1_PX is 0.95");
    refused(&row("MPC_THR_HOVER", "0.5", 9), &titan, "MPC_THR_HOVER is 0.5");
    refused(&row("MPC_XY_VEL_P_ACC", "-1", 9), &titan, "k_pvx must be finite and at least zero");
    refused(&row("MPC_TILTMAX_AIR", "95", 9), &titan, "quarter turn");
    refused("# For: samara\n1\t1\tSYS_AUTOSTART\t4001\t6", &titan, "none of the gains");
}

/// A subject at 12 m/s, on a stiff supply, that does not say what its tilt comes from.
fn subject<'a>(
    vehicle: &'a Vehicle,
    environment: &'a Environment,
    gains: &'a Gains,
    limits: &'a ControlLimits,
) -> Subject<'a> {
    Subject { vehicle, environment, gains, limits, speed_m_s: 12.0, tilt_from: None, pack: None }
}

/// PX4's own 4019_x500_v2 has arms of 1; all that counts to its allocation are ratios and signs.
#[test]
fn rotors_are_told_by_ratios_and_signs() {
    let (vehicle, gains, limits, earth) =
        (lander(true), Gains::paper_pso(), ControlLimits::default(), at(STANDARD_GRAVITY_M_S2));
    let subject = subject(&vehicle, &earth, &gains, &limits);
    let rotors: Vec<(f64, f64)> =
        vehicle.rotors.iter().map(|r| (r.position_body_m.x, r.position_body_m.y)).collect();
    let of = |change: &dyn Fn(usize, f64, f64) -> (f64, f64)| {
        let mut text = "1\t1\tMC_PITCH_P\t4\t9\n".to_owned();
        for (i, (x, y)) in rotors.iter().enumerate() {
            let (x, y) = change(i, *x, *y);
            text += &format!("1\t1\tCA_ROTOR{i}_PX\t{x}\t9\n1\t1\tCA_ROTOR{i}_PY\t{y}\t9\n");
        }
        import(&ParameterFile::parse(&text).unwrap(), &subject)
    };
    for scale in [1.0, 1.0 / rotors[0].0, 0.3] {
        assert!(of(&|_, x, y| (scale * x, scale * y)).is_ok(), "{scale}");
    }
    let refused = |change: &dyn Fn(usize, f64, f64) -> (f64, f64), words: &str| {
        let error = of(change).unwrap_err().to_string();
        assert!(error.contains("another vehicle") && error.contains(words), "{error}");
    };
    refused(&|_, x, y| (x, 2.0 * y), "CA_ROTOR");
    refused(&|i, x, y| (if i == 2 { 1.2 * x } else { x }, y), "CA_ROTOR2_PX");
    refused(&|_, x, y| (-x, -y), "CA_ROTOR");
    let spin = |value: f64| {
        let text = format!("1\t1\tMC_PITCH_P\t4\t9\n1\t1\tCA_ROTOR0_KM\t{value}\t9\n");
        import(&ParameterFile::parse(&text).unwrap(), &subject).is_ok()
    };
    assert_eq!([spin(0.05), spin(-0.05)].iter().filter(|ok| **ok).count(), 1, "one way to turn");
}

#[test]
fn what_the_file_leaves_out_stays_and_what_cannot_be_followed_is_reported() {
    let (vehicle, gains, limits, earth) =
        (lander(true), Gains::paper_pso(), ControlLimits::default(), at(STANDARD_GRAVITY_M_S2));
    let subject = subject(&vehicle, &earth, &gains, &limits);
    let text = "1\t1\tMC_PITCH_P\t4\t9\n1\t1\tMC_ROLL_P\t5\t9\n1\t1\tMC_PITCHRATE_D\t0.003\t9\n\
                1\t1\tTHR_MDL_FAC\t0.3\t9\n";
    let read = import(&ParameterFile::parse(text).unwrap(), &subject).unwrap();
    assert_eq!(read.gains, Gains { k_ptheta: 4.0, ..gains });
    assert_eq!(read.limits, limits);
    let remarks = read.remarks.join("; ");
    for expected in ["MC_ROLL_P means 5", "MPC_Z_VEL_I_ACC", "ignored: MC_PITCHRATE_D", "THR_MDL_FAC is 0.3"]
    {
        assert!(remarks.contains(expected), "{expected} not in {remarks}");
    }
}

/// A battery of six cells, full at 25.2 V, of 24 mOhm.
fn six_cells(throttle: Throttle) -> Pack {
    let limits = PackLimits {
        resistance_ohm: 0.024,
        current_max_a: f64::INFINITY,
        esc_current_max_a: f64::INFINITY,
        esc_efficiency: 0.95,
        motor_efficiency: 0.8,
        nominal_v: 22.2,
        throttle,
    };
    Pack::new(vec![(0.0, 19.8), (1.0, 25.2)], limits).unwrap()
}

/// What a mission says of tilt and battery comes back; of neither nothing is written.
#[test]
fn tilt_and_battery_survive_a_file() {
    let (vehicle, gains, earth) = (lander(true), Gains::paper_pso(), at(STANDARD_GRAVITY_M_S2));
    let pack = six_cells(Throttle::Duty);
    for purpose in Purpose::ALL {
        for (tilt_from, nominal_v) in [(TiltFrom::Gravity, Some(22.2)), (TiltFrom::Thrust, None)] {
            let limits = ControlLimits { tilt_from, nominal_v, ..ControlLimits::default() };
            let subject = Subject {
                vehicle: &vehicle,
                environment: &earth,
                gains: &gains,
                limits: &limits,
                speed_m_s: 12.0,
                tilt_from: Some(tilt_from),
                pack: Some(&pack),
            };
            let written = export(&subject, purpose).unwrap();
            let row = |name: &str| written.parameters.get(name).map(|value| value.as_f64());
            let scales = nominal_v.is_some();
            assert_eq!(row("MC_BAT_SCALE_EN"), Some(f64::from(u8::from(scales))));
            assert_eq!(row("MPC_ACC_DECOUPLE"), Some(f64::from(u8::from(tilt_from == TiltFrom::Gravity))));
            let cell = ["BAT1_N_CELLS", "BAT1_V_CHARGED", "BAT1_V_EMPTY", "BAT1_R_INTERNAL"].map(row);
            if scales && purpose != Purpose::Samara {
                let wanted = [6.0, 4.2, 3.3, 0.004].map(|x| Some(f64::from(x as f32)));
                assert_eq!(cell, wanted);
                let origin = written.remarks.join("\n");
                assert!(origin.contains("BAT1_R_INTERNAL are battery.electric"), "{origin}");
                assert!(origin.contains("at 22.2 V without load PX4's thrust and torque are 1.135 times"));
            } else {
                assert_eq!(cell, [None; 4]);
            }
            let found = written.check.findings.iter().map(|finding| &finding.name);
            let ours = ["BAT", SCALE_PARAMETER, TILT_PARAMETER];
            assert_eq!(found.filter(|name| ours.iter().any(|x| name.contains(x))).count(), 0);
            let text = write("x", &written.notes(&[]), &written.parameters);
            let file = ParameterFile::parse(&text).unwrap();
            let other = match tilt_from {
                TiltFrom::Gravity => ControlLimits::default(),
                TiltFrom::Thrust => {
                    ControlLimits { tilt_from: TiltFrom::Gravity, nominal_v: Some(1.0), ..limits }
                }
            };
            let back = import(&file, &Subject { limits: &other, ..subject }).unwrap();
            assert_eq!((back.limits.tilt_from, back.limits.nominal_v), (tilt_from, nominal_v));
            assert!(back.remarks.is_empty(), "{:?}", back.remarks);
            let steady = six_cells(Throttle::Speed);
            let there = import(&file, &Subject { pack: Some(&steady), ..subject }).unwrap();
            assert_eq!((there.limits.nominal_v, there.remarks.len()), (None, usize::from(scales)));
            let silent = Subject { tilt_from: None, pack: None, ..subject };
            let names = export(&silent, purpose).unwrap().parameters;
            let ours = [SCALE_PARAMETER, TILT_PARAMETER, "BAT1_N_CELLS"];
            assert!(ours.iter().all(|name| !names.contains_key(*name)));
        }
    }
}

/// By hand: with a linear throttle a unit of thrust and torque is `delta_h` of that of the square root, the
/// line's thrust at full throttle over the static one. So the hover thrust is the throttle at hover, its
/// root, and the rate gains are as much larger; and a file says which it is of.
#[test]
fn closed_form_a_linear_throttle_is_thr_mdl_fac_0() {
    let (vehicle, gains) = (lander(true), Gains::paper_pso());
    for (purpose, environment) in
        [(Purpose::Samara, at(1.35)), (Purpose::Px4, at(STANDARD_GRAVITY_M_S2 / 6.0))]
    {
        let of = |thrust_curve| {
            let limits = ControlLimits { thrust_curve, ..ControlLimits::default() };
            let subject = Subject {
                vehicle: &vehicle,
                environment: &environment,
                gains: &gains,
                limits: &limits,
                speed_m_s: 12.0,
                tilt_from: None,
                pack: None,
            };
            let exported = export(&subject, purpose).unwrap();
            let (notes, written) = (exported.notes(&[]), exported.parameters);
            let other = ControlLimits { tilt_rad: 0.3, ..ControlLimits::default() };
            let file = ParameterFile::parse(&write("x", &notes, &written)).unwrap();
            let back =
                (purpose == Purpose::Samara).then(|| import(&file, &Subject { limits: &other, ..subject }));
            (written, back)
        };
        let ((root, _), (linear, back)) = (of(ThrustCurve::Quadratic), of(ThrustCurve::Linear));
        let number = |rows: &std::collections::BTreeMap<String, Value>, name: &str| rows[name].as_f64();
        assert_eq!([&root, &linear].map(|rows| number(rows, "THR_MDL_FAC")), [1.0, 0.0]);
        let hover = number(&root, "MPC_THR_HOVER").sqrt();
        assert!((number(&linear, "MPC_THR_HOVER") / hover - 1.0).abs() < 1e-6);
        for loop_of in ["MC_PITCHRATE", "MC_ROLLRATE", "MC_YAWRATE"] {
            let gain = |rows| number(rows, &format!("{loop_of}_K")) * number(rows, &format!("{loop_of}_P"));
            assert!((gain(&linear) / gain(&root) * hover - 1.0).abs() < 1e-6, "{loop_of}");
        }
        assert_eq!(linear["MPC_XY_VEL_P_ACC"], root["MPC_XY_VEL_P_ACC"]);
        if let Some(back) = back {
            let back = back.unwrap();
            assert_eq!(back.limits.thrust_curve, ThrustCurve::Linear);
            assert!((back.gains.k_pq / gains.k_pq - 1.0).abs() < 1e-6 && back.remarks.is_empty(), "{back:?}");
        }
    }
}

/// v1.15.0 is the first that has MPC_ACC_DECOUPLE (`PositionControl.cpp`:209); before it the tilt is set
/// against gravity (v1.14.3:207, v1.12.0:179).
#[test]
fn reference_a_tilt_from_thrust_is_refused_for_versions_that_have_none() {
    let (vehicle, gains, earth) = (lander(true), Gains::paper_pso(), at(STANDARD_GRAVITY_M_S2));
    let limits = ControlLimits::default();
    let of = |tilt_from| Subject {
        vehicle: &vehicle,
        environment: &earth,
        gains: &gains,
        limits: &limits,
        speed_m_s: 12.0,
        tilt_from,
        pack: None,
    };
    let (said, silent) = (of(Some(TiltFrom::Thrust)), of(None));
    for (law, has_it) in [(Law::V1_12, false), (Law::V1_14, false), (Law::V1_16, true)] {
        for subject in [&said, &silent, &of(Some(TiltFrom::Gravity))] {
            let refused = !has_it && subject.tilt_from == Some(TiltFrom::Thrust);
            assert_eq!(export_for_law(subject, Purpose::Px4, &law).is_err(), refused, "{}", law.since);
            let flown = px4_model_parameters(subject, Purpose::Px4, &law, None);
            assert_eq!(flown.is_err(), refused, "{}", law.since);
        }
        assert!(export_for_law(&said, Purpose::Samara, &law).is_ok());
        // A file's law is the file's.
        let file = ParameterFile::parse("1\t1\tMC_PITCH_P\t4\t9").unwrap();
        assert!(px4_model_parameters(&said, Purpose::Px4, &law, Some(&file)).is_ok());
    }
    let error = export_for_mixing(&said, Purpose::Px4, Mixing::QuadX).unwrap_err().to_string();
    assert_eq!(
        error,
        "control.tilt_from: thrust has no counterpart in PX4 before v1.15, where MPC_ACC_DECOUPLE came: `gravity` is expected, or \
         PX4 v1.15 or later"
    );
    let flown = px4_model_parameters(&said, Purpose::Px4, &Law::V1_16, None).unwrap();
    assert_eq!(flown.acc_decouple, 0.0);
}
