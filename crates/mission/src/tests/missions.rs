//! The shipped missions and gains, and the state that a plan starts from.

use nalgebra::Vector3;

use super::spoil::{TITAN, copy, shipped, shipped_files, titan};
use super::*;
use crate::Effect;
use crate::shipped::{MISSIONS, names_in};
use samara_core::control::{ControlLimits, Gains};
use samara_core::model::parachute::Hook;
use samara_core::model::{Motor, RotorLimits};
use samara_core::plan::InputReference;
use samara_core::sim::{ReleaseTrigger, Start};
use samara_core::units::RAD_PER_DEG;

/// What is odd, a line each.
fn said(mission: &Mission) -> String {
    mission.contradictions().iter().map(|odd| format!("{odd}\n")).collect()
}

/// Every shipped file goes through its loader; a directory that gains a file of another kind fails here.
#[test]
fn every_shipped_file_loads() {
    for file in shipped_files() {
        let path = shipped(&file);
        let stem = path.file_stem().unwrap().to_str().unwrap().to_owned();
        let name = match file.split('/').nth(file.split('/').count() - 2).unwrap() {
            "mission" => load_mission(&path).unwrap().name,
            "gains" => load_gains(&path).unwrap().name,
            _ if file.ends_with(".csv") => continue,
            _ => load_vehicle(&path).unwrap().name,
        };
        assert_eq!(name, stem, "a file is named after what it holds");
        let json: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
        let (first, schema) = json.as_object().unwrap().iter().next().unwrap();
        assert_eq!(first, "$schema", "{file}");
        let schema = path.with_file_name(schema.as_str().unwrap());
        assert!(schema.is_file(), "{file}: {} is not there", schema.display());
    }
}

#[test]
fn paper_titan_mission_holds_tables_1_and_2_and_31() {
    let m = load_mission(&shipped(TITAN)).unwrap();
    assert_eq!((m.limits.safety.speed_m_s, m.limits.safety.vertical_acceleration_m_s2), (12.0, 3.0));
    assert_eq!(
        (m.limits.safety.pitch_rad, m.limits.safety.pitch_rate_rad_s),
        (45.0 * RAD_PER_DEG, 90.0 * RAD_PER_DEG)
    );
    assert_eq!(
        (m.plan.thrust_max_n, m.plan.thrust_slew_n_s, m.plan.horizon_s, m.plan.nodes),
        (300.0, 60.0, 30.0, 38)
    );
    assert_eq!(m.plan.x_ss, Some([1.0, 0.0, -0.0026, 0.0, 4.0, 0.0, 4.0, 0.0, 0.0, 0.0]));
    assert_eq!(m.plan.cost_state, [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 10.0, 10.0, 10.0]);
    assert_eq!((m.plan.cost_input, m.plan.cost_input_reference), (1e-5, InputReference::Zero));
    assert_eq!(m.target_v_ned, Vector3::new(4.0, 0.0, 4.0));
    assert_eq!(m.release.parachute.v0_m_s(m.site.environment.gravity_m_s2), 3.675);
    assert_eq!((m.release.start, m.release.hang_s, m.duration_s), (Start::Release, 10.0, 45.0));
    assert_eq!(m.release.trigger, ReleaseTrigger::Command);
    assert_eq!(m.control.limits, ControlLimits::default());
    assert_eq!((m.study.monte_carlo.trials, m.study.monte_carlo.length_m), (100, 0.34));
}

#[test]
fn paper_titan_tuning_cases_are_table_3() {
    let m = load_mission(&shipped(TITAN)).unwrap();
    let table_3 = [
        (0.0, 3.67, 0.0, 0.0),
        (0.32, 3.67, 0.0, 18.8),
        (0.26, 3.64, 5.5, 15.2),
        (0.10, 3.65, 8.9, 5.8),
        (-0.10, 3.69, 8.9, -5.8),
        (-0.26, 3.70, 5.5, -15.2),
        (-0.32, 3.67, 0.0, -18.8),
    ];
    assert_eq!(m.study.cases.len(), table_3.len());
    for (i, (case, (vn, vd, pitch, rate))) in m.study.cases.iter().zip(table_3).enumerate() {
        assert_eq!(case.name, format!("case_{i}"));
        assert_eq!(case.v_ned, Vector3::new(vn, 0.0, vd));
        assert_eq!((case.pitch_rad, case.pitch_rate_rad_s), (pitch * RAD_PER_DEG, rate * RAD_PER_DEG));
    }
}

#[test]
fn paper_gains_are_table_4() {
    let load = |name: &str| load_gains(&shipped(&format!("params/gains/{name}.json"))).unwrap().gains;
    assert_eq!(load("near_hover"), Gains::near_hover());
    assert_eq!(load("paper_pso"), Gains::paper_pso());
}

#[test]
fn reference_x500_mission() {
    let m = load_mission(&shipped("mission/x500_drop.json")).unwrap();
    assert!((m.release.parachute.v0_m_s(m.site.environment.gravity_m_s2) - 9.903325).abs() < 1e-14);
    assert!((m.plan.cost_input - 1e-5 * (300.0f64 / 8.54858).powi(2)).abs() < 1e-16);
    assert_eq!((m.plan.x_ss, m.target_v_ned), (None, Vector3::new(2.0, 0.0, 1.0)));
    assert_eq!(m.vehicle_name, "x500");
    // Hangs still for 8 of 15 s; at the release the descent is complete: 1 - tanh(7 g/5) = 2e-12.
    assert_eq!(m.release.parachute.hook, Some(Hook { lets_go_before_s: 7.0 }));
    let (released, _) = m.release.parachute.hanging(0.0, &m.site.environment);
    assert!((released.v_ned.z - 5.0).abs() < 1e-10 && released.v_ned.z < 5.0);
    let (held, a_ned) = m.release.parachute.hanging(-7.5, &m.site.environment);
    assert_eq!((held.v_ned, a_ned), (Vector3::zeros(), Vector3::zeros()));
    // In the mean over 2 s, since the air is never still.
    assert_eq!((m.limits.steady_within_m_s, m.limits.steady_mean_over_s), (0.3, Some(2.0)));
    let case_1 = &m.study.cases[1];
    let swing = 9.4 * RAD_PER_DEG * 3.1316;
    assert!((case_1.v_ned.x - swing).abs() < 5e-3 && (case_1.pitch_rate_rad_s - swing).abs() < 1e-3);
}

#[test]
fn the_plan_starts_from_the_paper_s_state_or_from_the_release_adrift_with_the_wind() {
    let m = load_mission(&shipped(TITAN)).unwrap();
    assert_eq!(m.plan.initial, PlanInitial::Paper);
    assert_eq!(m.plan_initial_state(), [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 3.675, 0.0, 0.0, 0.0]);
    let windy = |from: &str| titan(from, "\"wind_ned_m_s\": [6, -2, 0]").loaded.unwrap();
    let state = windy("\"wind_ned_m_s\": [0, 0, 0]").plan_initial_state();
    assert_eq!(state, [1.0, 0.0, 0.0, 0.0, 6.0, -2.0, 3.675, 0.0, 0.0, 0.0]);
    // An independent implementation: 3.661 m/s on Titan after the fall through the air.
    let release = titan("\"initial\": \"paper\"", "\"initial\": \"release\"").loaded.unwrap();
    assert!((release.plan_initial_state()[6] - 3.661).abs() < 5e-4, "{:?}", release.plan_initial_state());
    let x500 = load_mission(&shipped("mission/x500_drop.json")).unwrap();
    let x500 = x500.with_effects(&[Effect::RotorInflow]);
    assert_eq!(x500.plan.initial, PlanInitial::Release);
    let down = x500.plan_initial_state()[6];
    // Closed form, quadratic drag of the flat body and of four rotors at rest, 0.0694501 rho pi R^2 V^2 each
    // by the table's last row: v_t tanh(artanh(5/v_t) + g t_d/v_t) with v_t = 16.1 m/s, instead of 9.9.
    assert!((down - 8.932595496).abs() < 1e-9, "{down}");
    let left_out = titan("\"initial\": \"paper\",", "").loaded.unwrap();
    assert_eq!(left_out.plan.initial, PlanInitial::Paper);
}

#[test]
fn written_gains_read_back_to_the_last_bit() {
    let dir = copy();
    let path = dir.path().join("mine.json");
    let gains =
        Gains::longitudinal([1.0 / 3.0, 1e-20, 0.1 + 0.2, 5.0, 0.0, 1e6 - 1e-10, 2.2250738585072014e-308]);
    std::fs::write(&path, gains_json("mine", "a \"quoted\" \n about", &gains)).unwrap();
    assert_eq!(load_gains(&path).unwrap(), GainsFile { name: "mine".into(), gains });
}

/// First-order motors on rotors whose thrust in still air grows with the square of the speed, as it does with
/// blades that know neither Reynolds nor Mach number: both limits by hand. 90 % of the thrust is sqrt(0.9) of
/// the speed.
#[test]
fn closed_form_what_the_rotors_of_the_x500_can_do() {
    let m = load_mission(&shipped("mission/x500_drop.json")).unwrap();
    let Motor::FirstOrder { omega_max_rad_s, tau_up_s, tau_down_s, .. } = m.vehicle.motor else { panic!() };
    // At a tenth of the greatest speed.
    let k =
        m.vehicle.rotor.static_load(0.1 * omega_max_rad_s, 1.0).thrust_n / (0.1 * omega_max_rad_s).powi(2);
    for density in [1.225, 0.909] {
        let limits = RotorLimits::of(&m.vehicle, density);
        let thrust_n = k * omega_max_rad_s.powi(2) * density;
        assert!((limits.thrust_n / thrust_n - 1.0).abs() < 1e-12, "{limits:?}");
        let (rise_s, fall_s) = (
            tau_up_s * -samara_core::math::ln(1.0 - 0.9f64.sqrt()),
            tau_down_s * -samara_core::math::ln(0.1f64.sqrt()),
        );
        let slew = 0.9 * thrust_n / rise_s.max(fall_s);
        assert!((limits.thrust_slew_n_s / slew - 1.0).abs() < 1e-3, "{limits:?}, by hand {slew}");
    }
}

/// The lander's motors hold a speed below that commanded: there the motor's torque is the air's.
#[test]
fn prop_the_lander_s_greatest_thrust_is_held() {
    let m = load_mission(&shipped(TITAN)).unwrap();
    let limits = RotorLimits::of(&m.vehicle, m.site.environment.density_kg_m3);
    let at = |omega: f64| m.vehicle.rotor.static_load(omega, m.site.environment.density_kg_m3);
    let speed =
        (0..).map(|i| 0.001 * f64::from(i)).find(|omega| at(*omega).thrust_n >= limits.thrust_n).unwrap();
    let rate = m.vehicle.motor.law().acceleration(1.0, speed, at(speed).torque_nm);
    let before = m.vehicle.motor.law().acceleration(1.0, speed - 1.0, at(speed - 1.0).torque_nm);
    assert!(
        rate.abs() < 0.01 * before.abs(),
        "{limits:?}: {rate} rad/s^2, {before} a radian per second below"
    );
}

/// Thrust and slew that the mission leaves out are the rotors'.
#[test]
fn limits_that_are_left_out_are_those_of_the_rotors() {
    let m = titan("\"thrust_max_n\": 300.0,\n    \"thrust_slew_n_s\": 60.0,", "").loaded.unwrap();
    let limits = RotorLimits::of(&m.vehicle, m.site.environment.density_kg_m3);
    assert_eq!((m.plan.thrust_max_n, m.plan.thrust_slew_n_s), (limits.thrust_n, limits.thrust_slew_n_s));
}

/// What the shipped missions ask is what their vehicles can do; what is beyond is reported with the key and
/// the vehicle's own number.
#[test]
fn numbers_that_the_vehicle_contradicts_are_reported() {
    for path in names_in(MISSIONS) {
        let m = load_mission(&shipped(&format!("{MISSIONS}/{path}.json"))).unwrap();
        assert_eq!(m.contradictions(), [], "{path}");
    }
    let inertia = |m: &mut Mission, factor: f64| {
        let mut vehicle = (*m.vehicle).clone();
        vehicle.mass.inertia_kg_m2 *= factor;
        m.vehicle = vehicle.into();
    };
    let odd = |change: &dyn Fn(&mut Mission)| {
        let mut m = load_mission(&shipped("mission/x500_drop.json")).unwrap();
        change(&mut m);
        said(&m)
    };
    for (words, change) in [
        (
            "plan.thrust_max_n 16 N: a rotor makes 8.55 N",
            &(|m: &mut Mission| m.plan.thrust_max_n = 16.0) as &dyn Fn(&mut Mission),
        ),
        ("plan.thrust_slew_n_s 100000 N/s", &|m| m.plan.thrust_slew_n_s = 1e5),
        ("of the weight in air of 0.2 kg/m^3", &|m| m.site.environment.density_kg_m3 = 0.2),
        ("without its parachute the vehicle falls at", &|m| m.release.parachute.descent_m_s = 90.0),
        ("limits: passed by the release already", &|m| m.limits.safety.speed_m_s = 5.0),
        // The diameter where the radius belongs: hubs of neighbours are 0.348 m apart.
        ("rotors 1 and 3 meet: 0.348 m from hub to hub, diameter 0.508 m", &|m| {
            m.rotor_radius_m = Some(0.254);
        }),
        // 1.225 over the standard's 0.7364 at 5000 m (Table I), Huygens' 5.144 at 1000 m.
        ("site.density_kg_m3 1.225: at 5000 m it is 0.736 kg/m^3", &|m| {
            m.site.environment.anchor.altitude_m = 5000.0;
        }),
        ("at 1000 m it is 5.144 kg/m^3 by Huygens' descent", &|m| {
            let environment = &mut m.site.environment;
            (environment.gravity_m_s2, environment.density_kg_m3) = (1.352, 1.225);
            environment.anchor.altitude_m = 1000.0;
        }),
        // Radius of gyration sqrt(43.9/2.064) and sqrt(2.36e-5/2.064); arm 0.246 and propeller 0.127 m.
        ("about z is a radius of gyration of 4.61 m, and the rotors reach 0.373 m", &|m| inertia(m, 1e3)),
        ("about x is a radius of gyration of 0.00338 m, and the rotors reach 0.373 m", &|m| inertia(m, 1e-3)),
    ] {
        let found = odd(change);
        assert!(found.contains(words), "{words}: {found}");
    }
}

/// An atmosphere has gravity and density: they are either in the file or in it.
#[test]
fn an_atmosphere_takes_the_place_of_gravity_and_density() {
    let both = titan("\"gravity_m_s2\": 1.35,", "\"gravity_m_s2\": 1.35, \"atmosphere\": \"titan\",");
    let message = both.loaded.unwrap_err().to_string();
    assert!(message.contains("site.gravity_m_s2: expected to be left out"), "{message}");
    let neither = titan("\"gravity_m_s2\": 1.35,", "");
    let message = neither.loaded.unwrap_err().to_string();
    assert!(message.contains("site.gravity_m_s2: expected a number, or an atmosphere"), "{message}");
    let mission = titan("\"gravity_m_s2\": 1.35,\n    \"density_kg_m3\": 5.4,", "\"atmosphere\": \"titan\",");
    let environment = mission.loaded.unwrap().site.environment;
    assert_eq!(environment.density_kg_m3, 5.144, "at 1000 m");
    assert_eq!(environment.atmosphere, samara_core::model::Atmosphere::Titan);
}

/// A canopy and its riser: the apparent mass is that of a hemisphere of Titan's air, the plan starts from the
/// swing of the two bodies, the drop has a canopy, a trial its tip-off; what differs from the keys of the
/// prescribed hang is reported.
#[test]
fn a_canopy_is_a_body_of_its_own() {
    let canopy = |mass_kg: &str| {
        format!(
            "\"delay_s\": 0.5, \"canopy\": {{ \"mass_kg\": {mass_kg}, \"drag_area_m2\": 43.9, \"apparent_mass_factor\": 1.0 }}, \
             \"riser\": {{ \"length_m\": 10, \"stiffness_n_m\": 10000, \"damping_n_s_m\": 300, \
             \"attachment_body_m\": [0, 0, -1] }},"
        )
    };
    let load = |mass_kg: &str| titan("\"delay_s\": 0.5,", &canopy(mass_kg)).loaded.unwrap();
    let m = load("20");
    let suspension = m.release.parachute.suspension.unwrap();
    assert!((suspension.canopy.apparent_mass_kg - 248.3).abs() < 0.1, "{suspension:?}");
    let simulation = m.simulation();
    assert_eq!(simulation.canopy().map(|two| two.suspension), Some(suspension));
    assert!((simulation.state().body.v_ned.z - 3.0127).abs() < 1e-3);
    let two = m.linearised_parachute();
    assert!((two.pendulum.omega_rad_s - 1.151).abs() < 1e-3 && two.suspension.is_none(), "{two:?}");
    assert_eq!(two.pendulum.amplitude_rad, m.release.parachute.pendulum.amplitude_rad);
    assert!(m.t0_remarks()[0].contains("descent 3.01 m/s, swing 1.15 rad/s"));
    assert_eq!(m.contradictions(), []);
    let mut long = load("200");
    long.release.hang_s = 300.0;
    let odd = said(&long);
    assert!(odd.contains("parachute.descent_m_s 3 m/s: vehicle and canopy sink at 3.33"), "{odd}");
    assert!(odd.contains("release.hang_s 300 s: the canopy's drag leaves "), "{odd}");
    assert_eq!(
        titan("\"delay_s\": 0.5,", "\"delay_s\": 0.5,").loaded.unwrap().t0_remarks(),
        Vec::<String>::new()
    );

    let tip_off = "\"monte_carlo\": { \"tip_off\": { \"rate_sigma_deg_s\": [0, 10, 0] },";
    let m = titan("\"monte_carlo\": {", tip_off).loaded.unwrap();
    assert!(!m.is_the_papers_study());
    let drawn = m.draw_drop(4);
    assert!(drawn.tip_off.omega_body.y != 0.0 && drawn.tip_off.v_body == Vector3::zeros());
    assert_eq!(m.with_drop(&drawn).release.parachute.tip_off, drawn.tip_off);
}
