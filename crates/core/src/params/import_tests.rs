//! Files read back: round trips, and where a file does not belong.

use proptest::prelude::*;

use super::file::write;
use super::*;
use crate::control::test_vehicles::{lander, site};
use crate::control::{ControlLimits, Gains};
use crate::model::Environment;
use crate::units::STANDARD_GRAVITY_M_S2;

fn at(gravity_m_s2: f64) -> Environment {
    Environment { gravity_m_s2, ..site() }
}

/// The file that samara writes, read back with other gains as its ground.
fn round_trip(gains: &Gains, purpose: Purpose, environment: &Environment) -> Result<Import, ParamsError> {
    let (vehicle, limits) = (lander(true), ControlLimits::default());
    let subject = Subject { vehicle: &vehicle, environment, gains, limits: &limits, speed_m_s: 12.0 };
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

#[test]
fn what_the_file_leaves_out_stays_and_what_cannot_be_followed_is_reported() {
    let (vehicle, gains, limits, earth) =
        (lander(true), Gains::paper_pso(), ControlLimits::default(), at(STANDARD_GRAVITY_M_S2));
    let subject =
        Subject { vehicle: &vehicle, environment: &earth, gains: &gains, limits: &limits, speed_m_s: 12.0 };
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
