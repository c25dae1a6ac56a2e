//! Parameters against the cascade that flies by them.

use super::table::table;
use super::*;
use crate::autopilot::Autopilot;
use crate::control::{Airframe, ControlLimits, ControlSettings, Gains};
use crate::model::VehicleOptions;
use crate::params::ParameterFile;
use crate::test_vehicles::{quadrotor, site};
use crate::units::RAD_PER_DEG;
use proptest::prelude::*;

fn bench() -> (Parameters, Autopilot) {
    let vehicle = quadrotor([0.9, 1.1], [250.0, 300.0, 400.0], [0.0; 3], VehicleOptions::default());
    let (gains, limits) = (Gains::near_hover(), ControlLimits::default());
    let subject = Subject {
        vehicle: &vehicle,
        environment: &site(),
        gains: &gains,
        limits: &limits,
        speed_m_s: 8.0,
        tilt_from: None,
        pack: None,
    };
    let airframe = Airframe::new(&vehicle, &site()).unwrap();
    let autopilot = Autopilot::new(ControlSettings { airframe, gains, limits });
    (Parameters::of(&subject, 3).unwrap(), autopilot)
}

fn real(x: f64) -> Value {
    Value::Real(x as f32)
}

#[test]
fn closed_form_indices_are_places_in_name_order() {
    let (parameters, _) = bench();
    assert!(parameters.iter().is_sorted_by(|a, b| a.name < b.name));
    for (i, entry) in parameters.iter().enumerate() {
        assert_eq!((parameters.index_of(&entry.name), parameters.at(i)), (Some(i), Some(entry)));
    }
    let per_rotor = table().filter(|d| d.name.contains('#')).count();
    assert_eq!(parameters.len(), table().count() + 3 * per_rotor);
    assert_eq!(parameters.get("MAV_SYS_ID"), Some(Value::Int(3)));
}

#[test]
fn closed_form_gains_in_effect_are_those_of_the_parameters_and_no_other_changes() {
    let (mut parameters, mut autopilot) = bench();
    let before = autopilot.control_settings().gains;
    let p = parameters.number("MC_PITCHRATE_P").unwrap();
    let k = parameters.number("MC_PITCHRATE_K").unwrap();
    let changed = parameters.set("MC_PITCHRATE_K", real(2.0 * k), &mut autopilot).unwrap();
    let names: Vec<&str> = changed.iter().map(|i| parameters.at(*i).unwrap().name.as_str()).collect();
    assert_eq!(names, ["MC_PITCHRATE_K", "MC_ROLLRATE_P", "MC_ROLLRATE_I"]);
    let after = autopilot.control_settings().gains;
    assert!((after.k_pq / before.k_pq - 2.0).abs() < 1e-6 && (after.k_iq / before.k_iq - 2.0).abs() < 1e-6);
    assert_eq!(Gains { k_pq: before.k_pq, k_iq: before.k_iq, ..after }, before);
    parameters.set("MC_PITCHRATE_P", real(p / 2.0), &mut autopilot).unwrap();
    assert!((autopilot.control_settings().gains.k_pq / before.k_pq - 1.0).abs() < 1e-6);
    parameters.set("MPC_TILTMAX_AIR", real(25.0), &mut autopilot).unwrap();
    assert_eq!(autopilot.control_settings().limits.tilt_rad, 25.0 * RAD_PER_DEG);
    parameters.set("COM_OF_LOSS_T", real(2.5), &mut autopilot).unwrap();
    assert_eq!(autopilot.settings.setpoint_timeout_us, 2_500_000);
}

#[test]
fn closed_form_hover_thrust_scales_the_mass() {
    let (mut parameters, mut autopilot) = bench();
    let mass = autopilot.control_settings().airframe.mass_kg;
    let hover = parameters.number("MPC_THR_HOVER").unwrap();
    parameters.set("MPC_THR_HOVER", real(1.1 * hover), &mut autopilot).unwrap();
    assert!((autopilot.control_settings().airframe.mass_kg / mass - 1.1).abs() < 1e-6);
}

/// What follows is what an export of the new gains says.
#[test]
fn closed_form_roll_follows_pitch() {
    let (mut parameters, mut autopilot) = bench();
    for (name, by) in
        [("MC_PITCHRATE_P", 1.3), ("MC_PITCHRATE_I", 0.7), ("MC_PITCH_P", 1.2), ("MC_PR_INT_LIM", 0.5)]
    {
        let value = real(by * parameters.number(name).unwrap());
        parameters.set(name, value, &mut autopilot).unwrap();
    }
    let vehicle = quadrotor([0.9, 1.1], [250.0, 300.0, 400.0], [0.0; 3], VehicleOptions::default());
    let ControlSettings { gains, limits, .. } = autopilot.control_settings();
    let subject = Subject {
        vehicle: &vehicle,
        environment: &site(),
        gains,
        limits,
        speed_m_s: 8.0,
        tilt_from: None,
        pack: None,
    };
    let exported = export(&subject, Purpose::Samara).unwrap().parameters;
    let product = |get: &dyn Fn(&str) -> f64, term: &str| get("MC_ROLLRATE_K") * get(term);
    let of_export = |name: &str| exported[name].as_f64();
    let of_parameters = |name: &str| parameters.number(name).unwrap();
    for term in ["MC_ROLLRATE_P", "MC_ROLLRATE_I"] {
        let ratio = product(&of_parameters, term) / product(&of_export, term);
        assert!((ratio - 1.0).abs() < 1e-6, "{term}");
    }
    for name in ["MC_ROLL_P", "MC_RR_INT_LIM"] {
        assert!((of_parameters(name) / of_export(name) - 1.0).abs() < 1e-6, "{name}");
    }
}

#[test]
fn regress_what_cannot_be_is_refused_in_words_and_changes_nothing() {
    let (mut parameters, mut autopilot) = bench();
    let before = (parameters.clone(), autopilot.control_settings().gains);
    for (name, value, words) in [
        ("NO_SUCH", real(1.0), "unknown parameter NO_SUCH"),
        ("MC_PITCH_P", Value::Int(4), "MC_PITCH_P refused: type 9 (REAL32) expected"),
        ("COM_DL_LOSS_T", real(20.0), "COM_DL_LOSS_T refused: type 6 (INT32) expected"),
        ("MC_PITCH_P", real(f64::NAN), "MC_PITCH_P refused: NaN where 0 to 100 is expected"),
        ("MC_PITCH_P", real(-1.0), "MC_PITCH_P refused: -1 where 0 to 100 is expected"),
        ("NAV_DLL_ACT", Value::Int(7), "NAV_DLL_ACT refused: 7 where 0 to 6 is expected"),
        ("MC_ROLL_P", real(4.0), "MC_ROLL_P refused: follows MC_PITCH_P: roll flies pitch's gains"),
        ("MAV_SYS_ID", Value::Int(9), "MAV_SYS_ID refused: read-only: from --instance"),
        ("CA_ROTOR2_PX", real(9.0), "CA_ROTOR2_PX refused: read-only: from the mission's vehicle"),
    ] {
        let refusal = parameters.set(name, value, &mut autopilot).unwrap_err();
        assert_eq!(refusal.to_string(), words);
    }
    let zero = parameters.set("MC_PR_INT_LIM", real(0.0), &mut autopilot).unwrap_err();
    assert!(zero.to_string().starts_with("MC_PR_INT_LIM refused: 0 where"), "{zero}");
    assert_eq!((parameters, autopilot.control_settings().gains), before);
}

#[test]
fn regress_a_value_in_effect_is_taken_even_where_it_cannot_be_changed() {
    let (mut parameters, mut autopilot) = bench();
    for entry in parameters.clone().iter() {
        assert!(parameters.set(&entry.name, entry.value, &mut autopilot).is_ok(), "{}", entry.name);
    }
}

/// Ground stations take a default outside its range for an error; whatever a vehicle brings, its range has
/// it.
#[test]
fn regress_every_default_lies_in_its_range() {
    for gains in [Gains::near_hover(), Gains { k_pvz: 40.0, k_ppsi: 0.01, ..Gains::near_hover() }] {
        let vehicle = quadrotor([0.9, 1.1], [250.0, 300.0, 400.0], [0.0; 3], VehicleOptions::default());
        let limits = ControlLimits { tilt_rad: 0.01, ..ControlLimits::default() };
        for speed_m_s in [0.1, 8.0, 60.0] {
            let subject = Subject {
                vehicle: &vehicle,
                environment: &site(),
                gains: &gains,
                limits: &limits,
                speed_m_s,
                tilt_from: None,
                pack: None,
            };
            for entry in Parameters::of(&subject, 3).unwrap().iter() {
                assert!(entry.known.contains(entry.start.as_f64()), "{entry:?}");
                assert!(entry.known.min.is_none_or(|min| min <= entry.known.max.unwrap_or(min)), "{entry:?}");
            }
        }
    }
}

/// The checksum by another way: byte by byte over a table, as zlib has it, started from and ended with zero.
#[test]
fn reference_hash_over_names_and_values_in_order() {
    let (parameters, _) = bench();
    let table: Vec<u32> = (0..256u32)
        .map(|n| (0..8).fold(n, |c, _| if c % 2 == 1 { 0xEDB8_8320 ^ (c / 2) } else { c / 2 }))
        .collect();
    let mut crc = 0u32;
    for (name, value) in parameters.values() {
        let bits = match value {
            Value::Int(i) => i as u32,
            Value::Real(x) => x.to_bits(),
        };
        for byte in name.bytes().chain((0..4).map(|i| (bits >> (8 * i)) as u8)) {
            crc = table[((crc ^ u32::from(byte)) & 0xFF) as usize] ^ (crc >> 8);
        }
    }
    assert_eq!(parameters.hash(), crc);
}

#[test]
fn regress_a_file_is_loaded_and_what_is_unknown_is_reported() {
    let (mut parameters, mut autopilot) = bench();
    let text = "1\t1\tCOM_OF_LOSS_T\t3\t9\n1\t1\tMC_PITCH_P\t9\t9\n1\t1\tNAV_DLL_ACT\t7\t6\n\
                1\t1\tRTL_RETURN_ALT\t40\t9\n1\t1\tUAVCAN_ENABLE\t1\t6\n1\t42\tNO\t1\t6\n";
    let remarks = parameters.load(&ParameterFile::parse(text).unwrap(), &mut autopilot);
    assert_eq!(
        remarks,
        [
            "line 3: NAV_DLL_ACT refused: 7 where 0 to 6 is expected",
            "not parameters of samara's autopilot, ignored: UAVCAN_ENABLE"
        ]
    );
    assert_eq!(
        (autopilot.settings.setpoint_timeout_us, parameters.get("RTL_RETURN_ALT")),
        (3_000_000, Some(real(40.0)))
    );
    assert_eq!(autopilot.control_settings().gains, Gains { k_ptheta: 9.0, ..Gains::near_hover() });
    parameters.set("RTL_RETURN_ALT", real(50.0), &mut autopilot).unwrap();
    parameters.set("MC_PITCH_P", real(2.0), &mut autopilot).unwrap();
    assert_eq!(parameters.reset(&mut autopilot).len(), 3, "MC_PITCH_P, MC_ROLL_P, RTL_RETURN_ALT");
    assert_eq!(parameters.get("RTL_RETURN_ALT"), Some(real(40.0)));
    assert_eq!(autopilot.control_settings().gains.k_ptheta, 9.0);
}

/// A file that has P of a rate loop and no K means a K of 1; what it leaves out keeps its gain.
#[test]
fn closed_form_a_rate_loop_is_parted_as_in_the_file() {
    let (mut parameters, mut autopilot) = bench();
    parameters.set("MC_PITCHRATE_K", real(4.0), &mut autopilot).unwrap();
    let before = autopilot.control_settings().gains;
    let p = 2.0 * 4.0 * parameters.number("MC_PITCHRATE_P").unwrap();
    let file = ParameterFile::parse(&format!("1\t1\tMC_PITCHRATE_P\t{p}\t9\n")).unwrap();
    assert_eq!(parameters.load(&file, &mut autopilot), Vec::<String>::new());
    let after = autopilot.control_settings().gains;
    assert!((after.k_pq / before.k_pq - 2.0).abs() < 1e-6, "{after:?}");
    assert!((after.k_iq / before.k_iq - 1.0).abs() < 1e-6, "{after:?}");
    assert_eq!(parameters.number("MC_PITCHRATE_K"), Some(1.0));
}

/// A file exported for the mission, imported by it and loaded: the gains of the import to the bit, and the
/// file's digits.
#[test]
fn closed_form_the_gains_of_a_file_are_those_that_the_mission_took_from_it() {
    let (from, _) = bench();
    let rows: String = from
        .values()
        .iter()
        .map(|(name, value)| format!("1\t1\t{name}\t{value}\t{}\n", value.mavlink_type()))
        .collect();
    let text = format!("# For: samara\n{}", rows.replace("MC_PITCHRATE_P\t", "MC_PITCHRATE_P\t1"));
    let file = ParameterFile::parse(&text).unwrap();
    let vehicle = quadrotor([0.9, 1.1], [250.0, 300.0, 400.0], [0.0; 3], VehicleOptions::default());
    let (gains, limits) = (Gains::near_hover(), ControlLimits::default());
    let subject = Subject {
        vehicle: &vehicle,
        environment: &site(),
        gains: &gains,
        limits: &limits,
        speed_m_s: 8.0,
        tilt_from: None,
        pack: None,
    };
    let imported = crate::params::import(&file, &subject).unwrap();
    let subject = Subject { gains: &imported.gains, limits: &imported.limits, ..subject };
    let airframe = Airframe::new(&vehicle, &site()).unwrap();
    let (gains, limits) = (imported.gains, imported.limits);
    let mut autopilot = Autopilot::new(ControlSettings { airframe, gains, limits });
    let mut parameters = Parameters::of(&subject, 3).unwrap();
    assert_eq!(parameters.load(&file, &mut autopilot), Vec::<String>::new());
    let in_effect = autopilot.control_settings();
    assert_eq!((in_effect.gains, in_effect.limits), (imported.gains, imported.limits));
    for (_, name, entry) in file.entries().filter(|(_, name, _)| !name.starts_with("MC_ROLLRATE")) {
        assert_eq!(parameters.get(name), Some(entry.value), "{name}");
    }
}

proptest! {
    #[test]
    fn prop_no_value_gets_past_its_range(
        index in 0usize..table().count(), bits in any::<u32>(), real in any::<bool>(),
    ) {
        let (mut parameters, mut autopilot) = bench();
        let value = if real { Value::Real(f32::from_bits(bits)) } else { Value::Int(bits as i32) };
        let name = parameters.at(index).unwrap().name.clone();
        let before = parameters.clone();
        match parameters.set(&name, value, &mut autopilot) {
            Ok(_) => {
                let entry = parameters.at(index).unwrap();
                prop_assert!(entry.role.is_settable() || entry.value == before.at(index).unwrap().value);
                prop_assert!(entry.known.contains(entry.value.as_f64()) || entry.value == entry.start);
            }
            Err(_) => prop_assert_eq!(&parameters, &before),
        }
        prop_assert!(autopilot.control_settings().gains.validate().is_ok());
        prop_assert!(autopilot.control_settings().limits.validate().is_ok());
    }
}
