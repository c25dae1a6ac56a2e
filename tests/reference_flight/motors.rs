//! Motors of any speed: the integration follows them, in space and in the batch engine, and what a flight
//! comes to has a limit as they get faster.

use std::sync::Arc;

use nalgebra::Vector3;
use samara::assess::{Outcome, RandomRelease, SafetyStudy, StudyEntry, StudyReference};
use samara::config::load_mission;
use samara::control::{Airframe, Cascade};
use samara::model::{Motor, Vehicle};
use samara::plan::{Guess, SolverOptions, plan};
use samara::tune::ReleaseCase;
use samara::uncertain::Deviations;
use samara::units::RAD_PER_DEG;

/// A mission's study with another motor, the flights of its cases with the mission's gains on the plan.
struct Cases {
    study: SafetyStudy,
    entry: StudyEntry,
    releases: Vec<RandomRelease>,
}

impl Cases {
    fn of(mission: &str) -> Self {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(mission);
        let m = load_mission(&path).unwrap();
        let options = SolverOptions::default();
        let plan = plan(&m.plan_problem(), &Guess::StraightLine, &options, &mut |_| {
            std::ops::ControlFlow::Continue(())
        });
        let release = |(i, case): (usize, &ReleaseCase)| RandomRelease {
            trial: i as u64,
            amplitude_rad: 0.0,
            phase_rad: 0.0,
            state: case.state(),
            off: Deviations::default(),
        };
        let airframe = Airframe::new(&m.vehicle, &m.site.environment).unwrap();
        Self {
            study: SafetyStudy { settle_s: 0.0, ..m.safety_study(&plan.unwrap().trajectory) },
            entry: StudyEntry {
                name: "ours",
                gains_name: m.control.gains_name.clone(),
                controller: Box::new(Cascade::new(airframe, m.control.gains, m.control.limits)),
                reference: StudyReference::Optimal,
            },
            releases: m.study.cases.iter().enumerate().map(release).collect(),
        }
    }

    fn with(&mut self, change: impl FnOnce(&mut Vehicle)) {
        change(Arc::make_mut(&mut self.study.scenario.vehicle));
    }

    /// Side by side, after a look that they are what flights in space are.
    fn fly(&self) -> Vec<Outcome> {
        let outcomes = self.study.fly_releases(&self.entry, &self.releases);
        for (outcome, release) in outcomes.iter().zip(&self.releases) {
            let alone = self.study.outcome(&self.entry, &release.state);
            let off = (outcome.final_v_ned() - alone.final_v_ned()).norm();
            // The way: by the trapezoid rule over the control steps there, integrated here.
            let (way, tilt) = (
                (outcome.way_ned_m() - alone.way_ned_m()).norm(),
                (outcome.peak_tilt_deg - alone.peak_tilt_deg) * RAD_PER_DEG,
            );
            assert!(
                (outcome.j_tpf - alone.j_tpf).abs() < 1e-9 && off < 1e-9 && way < 2e-3 && tilt.abs() < 1e-7,
                "{outcome:?}, in space {alone:?}"
            );
            assert_eq!(outcome.steady_after_s, alone.steady_after_s);
        }
        outcomes
    }
}

fn faster_first_order(vehicle: &mut Vehicle, up_s: f64, down_s: f64) {
    let Motor::FirstOrder { tau_up_s, tau_down_s, .. } = &mut vehicle.motor else { unreachable!() };
    (*tau_up_s, *tau_down_s) = (up_s, down_s);
}

/// Titan's constants make 0.2 x 0.09/(0.9 x 2.9) s; the x500's shortest is 12.5 ms. Both fly 10 ms, and Titan
/// PX4's 10.8 ms, in one step.
#[test]
fn closed_form_the_shipped_vehicles_take_one_step() {
    let (titan, x500) = (Cases::of("mission/titan_paper.json"), Cases::of("tests/calm_x500.json"));
    let tau_s = 0.2 * 0.09 / (0.9 * 2.9);
    assert!((titan.study.scenario.vehicle.motor.fastest_rate_per_s() * tau_s - 1.0).abs() < 1e-12);
    assert!((titan.study.scenario.vehicle.longest_step_s() / (1.6 * tau_s) - 1.0).abs() < 1e-12);
    assert!((x500.study.scenario.vehicle.longest_step_s() / (1.6 * 0.0125) - 1.0).abs() < 1e-12);
    assert!(titan.study.scenario.vehicle.longest_step_s() > 0.0108);
}

/// As the time constants go to zero, J_TPF and the speed at the end go to those of rotors that follow at
/// once: halving them halves what is left. At 10 ms a step the x500 with 2 and 4 ms was lost.
#[test]
fn prop_j_tpf_converges_as_motors_get_faster() {
    let mut x500 = Cases::of("tests/calm_x500.json");
    let mut at = |tau_s: f64| {
        x500.with(|v| faster_first_order(v, tau_s, 2.0 * tau_s));
        x500.fly()
    };
    let limit = at(0.0002);
    for tau_s in [0.004, 0.002, 0.001, 0.0005] {
        for (outcome, limit) in at(tau_s).iter().zip(&limit) {
            let off = (outcome.j_tpf - limit.j_tpf).abs();
            assert!(off < 2.0 * tau_s, "tau {tau_s}: J_TPF {}, limit {}", outcome.j_tpf, limit.j_tpf);
            let v_off = (outcome.final_v_ned() - limit.final_v_ned()).norm();
            assert!(v_off < 20.0 * tau_s, "tau {tau_s}: off by {v_off} m/s at the end");
        }
    }
}

/// Titan with ever lighter rotors: at 0.001 kg m^2 they were taken to stand still, and it fell.
#[test]
fn prop_j_tpf_converges_as_rotors_get_lighter() {
    let mut titan = Cases::of("mission/titan_paper.json");
    titan.releases.truncate(3);
    let mut at = |inertia: f64| {
        titan.with(|v| {
            let Motor::EscDc(motor) = &mut v.motor else { unreachable!() };
            motor.rotor_inertia_kg_m2 = inertia;
        });
        titan.fly()
    };
    let limit = at(0.002);
    for inertia in [0.04, 0.02, 0.01] {
        for (outcome, limit) in at(inertia).iter().zip(&limit) {
            let off = (outcome.j_tpf - limit.j_tpf).abs();
            assert!(off < inertia, "{inertia} kg m^2: J_TPF {}, limit {}", outcome.j_tpf, limit.j_tpf);
        }
    }
    assert!(limit.iter().all(|o| (o.final_v_ned() - Vector3::new(4.0, 0.0, 4.0)).norm() < 1.0), "{limit:?}");
}

/// To the mission's end, beyond the plan: each of the shipped designs is steady then, and the way is that to
/// the plan's end. [`Cases::fly`] holds both paths against each other.
#[test]
fn prop_the_way_and_the_time_to_steady_flight_are_the_same_in_the_plane() {
    for mission in ["mission/titan_paper.json", "tests/calm_x500.json"] {
        let mut cases = Cases::of(mission);
        cases.releases.truncate(4);
        let to_the_plans_end = cases.fly();
        cases.study.settle_s = 12.0;
        for (long, short) in cases.fly().iter().zip(&to_the_plans_end) {
            assert!(long.steady_after_s.is_some(), "{mission}: {long:?}");
            assert!((long.way_ned_m() - short.way_ned_m()).norm() < 1e-9, "{mission}: {long:?}, {short:?}");
            assert!(
                long.way_ned_m().z > 5.0 && long.peak_tilt_deg * RAD_PER_DEG < 0.6,
                "{mission}: {long:?}"
            );
        }
    }
}
