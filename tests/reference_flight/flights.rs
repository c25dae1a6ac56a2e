//! Closed-loop flights on the actuator plant: state, rotor speeds and integrals second by second, and J_TPF.

use std::ops::ControlFlow;

use nalgebra::Vector3;
use samara::assess::{Verdict, VerdictBuilder};
use samara::control::{Controller as _, Gains, Measurement, Setpoint};
use samara::frames::pitch;
use samara::model::Parachute;
use samara::model::parachute::Pendulum;
use samara::model::rigid_body::BodyState;
use samara::sim::{DropSimulation, FlightPlan, Phase, PlantKind, Reference, Start, fly};
use samara::trajectory::Trajectory;
use samara::units::RAD_PER_DEG;

use super::data::{
    NUMBERS, TABLE_3, TITAN, cascade, flight_reference, gains, limits, numbers, rows, site, target_ned,
};

/// Gains and reference of a flight by the reference's name for it.
fn controller<'a>(name: &str, plan: &'a Trajectory) -> (Gains, Reference<'a>) {
    let gains = gains(if name.starts_with("PSO") { "paper_pso" } else { "near_hover" });
    if name.contains("step") {
        (gains, Reference::Step(target_ned()))
    } else {
        (gains, Reference::Plan { trajectory: plan, then_v_ned: None, feed_forward: false })
    }
}

fn at_t0(case: usize) -> DropSimulation {
    DropSimulation::at_t0(TITAN.clone(), site(), TABLE_3[case].state(), PlantKind::Actuator)
}

/// Largest difference of a flight from the reference's rows, column by column.
fn differences(name: &str, case: usize, wanted: &[Vec<f64>]) -> [f64; 9] {
    let plan = flight_reference();
    let (gains, reference) = controller(name, &plan);
    let (mut sim, mut cascade) = (at_t0(case), cascade(gains));
    let mut worst = [0.0f64; 9];
    for step in 0..=3000 {
        let s = *sim.state();
        if step % 100 == 0 {
            let (v, i) = (cascade.velocity_integral_ned(), cascade.rate_integral());
            let found = [
                s.body.v_ned.x,
                s.body.v_ned.z,
                pitch(s.body.q_ned_from_body),
                s.body.omega_body.y,
                s.rotor_speed[0],
                s.rotor_speed[1],
                v.x,
                v.z,
                i[1],
            ];
            for (k, w) in worst.iter_mut().enumerate() {
                *w = w.max((found[k] - wanted[step / 100][k + 1]).abs());
            }
            let b = &s.body;
            let lateral = b.v_ned.y.abs() + b.omega_body.x.abs() + b.omega_body.z.abs();
            assert!(lateral < 1e-15, "left the plane by {lateral:e}");
        }
        let (v_ned, a_ff_ned) = reference.at(step as f64 * 0.01);
        let setpoint = Setpoint::Velocity { v_ned, a_ff_ned, yaw_rad: Some(0.0) };
        let out = cascade.step(&Measurement::from(&s.body), &setpoint, 0.01);
        sim.step(&out.throttle, 0.01);
    }
    worst
}

/// Velocities to 1e-9 m/s, pitch to 1e-9 rad. What remains is how Runge-Kutta of fourth order treats an angle
/// and a quaternion: it falls with the fifth power of the step (see the peaks at 4 ms below).
#[test]
fn reference_flights_second_by_second() {
    let bars = [1e-9, 1e-9, 1e-9, 5e-9, 1e-6, 1e-6, 1e-10, 1e-9, 1e-11];
    for name in ["NHstep", "NHopt", "PSOopt"] {
        for case in [0, 3] {
            let wanted = rows(&NUMBERS["flights_1hz"][format!("{name}_case{case}")]);
            assert_eq!(wanted.len(), 31);
            let worst = differences(name, case, &wanted);
            for (column, (w, bar)) in worst.iter().zip(bars).enumerate() {
                assert!(*w < bar, "{name} case {case} column {}: {w:.2e} against {bar:.0e}", column + 1);
            }
        }
    }
}

#[test]
fn paper_table_4_is_the_same_in_the_files() {
    assert_eq!(gains("near_hover"), Gains::near_hover());
    assert_eq!(gains("paper_pso"), Gains::paper_pso());
}

fn judged(name: &str, case: usize, dt: f64) -> Verdict {
    let plan = flight_reference();
    let (gains, reference) = controller(name, &plan);
    let flight = FlightPlan::new(reference, dt, 30.0);
    let mut builder = VerdictBuilder::new(limits(), target_ned());
    let _ = fly(&mut at_t0(case), &mut cascade(gains), &flight, &mut |s| {
        builder.observe(s);
        ControlFlow::Continue(())
    });
    builder.finish().unwrap()
}

#[test]
fn reference_j_tpf_of_all_cases_and_controllers() {
    for (suffix, dt) in [("dt0.01", 0.01), ("dt0.004", 0.004)] {
        for name in ["NHstep", "NHopt", "PSOopt"] {
            let table = &NUMBERS["flight_peaks"][format!("{name}_eval_{suffix}")];
            let column = |key: &str| numbers(&table[key]);
            let (j, speed) = (column("J_TPF"), column("Vmax"));
            let (pitch_min, pitch_max) = (column("pitch_min_deg"), column("pitch_max_deg"));
            let (rate_min, rate_max) = (column("Q_min_deg_s"), column("Q_max_deg_s"));
            for case in 0..7 {
                let v = judged(name, case, dt);
                let what = format!("{name} {suffix} case {case}");
                assert!(
                    (v.outcome.j_tpf - j[case]).abs() < 1e-9,
                    "{what}: J_TPF {:.2e}",
                    v.outcome.j_tpf - j[case]
                );
                let peak = |low: f64, high: f64| if low.abs() > high.abs() { low } else { high };
                for (found, wanted) in [
                    (v.outcome.peak_speed_m_s, speed[case]),
                    (v.peaks.pitch_rad, peak(pitch_min[case], pitch_max[case]) * RAD_PER_DEG),
                    (v.peaks.pitch_rate_rad_s, peak(rate_min[case], rate_max[case]) * RAD_PER_DEG),
                ] {
                    assert!((found - wanted).abs() < 2e-9, "{what}: {:.2e}", found - wanted);
                }
            }
        }
    }
}

fn safety_flight(start: BodyState, then_v_ned: Option<Vector3<f64>>, duration_s: f64) -> Verdict {
    safety_flight_at(start, then_v_ned, duration_s, 0.01, None)
}

fn safety_flight_at(
    start: BodyState,
    then_v_ned: Option<Vector3<f64>>,
    duration_s: f64,
    control_period_s: f64,
    setpoint_period_s: Option<f64>,
) -> Verdict {
    let plan = flight_reference();
    let flight = FlightPlan {
        setpoint_period_s,
        ..FlightPlan::new(
            Reference::Plan { trajectory: &plan, then_v_ned, feed_forward: false },
            control_period_s,
            duration_s,
        )
    };
    let mut sim = DropSimulation::at_t0(TITAN.clone(), site(), start, PlantKind::Actuator);
    let mut builder = VerdictBuilder::new(limits(), target_ned());
    let _ = fly(&mut sim, &mut cascade(gains("safety")), &flight, &mut |s| {
        builder.observe(s);
        ControlFlow::Continue(())
    });
    builder.finish().unwrap()
}

/// The gains tuned for safety: J_TPF of the seven cases to the digits given.
#[test]
fn reference_safety_gains_on_the_seven_cases() {
    let wanted = [0.555, 0.553, 0.553, 0.554, 0.553, 0.594, 0.587];
    for (case, w) in TABLE_3.iter().zip(wanted) {
        let v = safety_flight(case.state(), None, 30.0);
        assert!((v.outcome.j_tpf - w).abs() < 6e-4, "{} against {w}", v.outcome.j_tpf);
        assert!(v.limits_passed.is_empty());
    }
}

/// The nominal release, (44).
fn nominal() -> BodyState {
    let mut state = TABLE_3[0].state();
    state.v_ned.z = 3.675;
    state
}

/// The nominal release, the target velocity commanded after the plan's end: steady to 1 % at 31.24 s.
#[test]
fn reference_safety_gains_settle_when_the_target_follows_the_plan() {
    let v = safety_flight(nominal(), Some(target_ned()), 34.5);
    assert!((v.outcome.j_tpf - 0.5551).abs() < 6e-5, "{}", v.outcome.j_tpf);
    assert!((v.outcome.steady_after_s.unwrap() - 31.24).abs() < 0.011, "{:?}", v.outcome.steady_after_s);
    assert!((v.outcome.final_v_ned() - target_ned()).norm() < 0.01 * target_ned().norm());
    // Without it the plan's own sag at the end stays.
    assert_eq!(safety_flight(nominal(), None, 34.5).outcome.steady_after_s, None);
}

/// As a stream of messages flies it, 250 Hz with setpoints held at 50 Hz: J_TPF moves by a tenth of a
/// percent.
#[test]
fn reference_safety_gains_with_the_rates_of_the_wire() {
    let v = safety_flight_at(nominal(), Some(target_ned()), 34.5, 0.004, Some(0.02));
    assert!((v.outcome.j_tpf / 0.5551 - 1.0).abs() < 2e-3, "{}", v.outcome.j_tpf);
}

/// The drop from 3 m/s under the canopy: the air takes 14 mm/s off the 3.675 m/s of the fall in a vacuum.
#[test]
fn reference_speed_at_the_end_of_the_fall() {
    let still = Pendulum { amplitude_rad: 0.0, phase_rad: 0.0, omega_rad_s: 2.0, length_m: 0.34 };
    let parachute = Parachute::new(3.0, 0.5, still).unwrap();
    let mut sim = DropSimulation::new(TITAN.clone(), site(), parachute, 0.0, Start::Release);
    sim.release();
    while sim.phase() == Phase::Falling {
        sim.step(&[1.0; 8], 0.004);
    }
    let v = sim.state().body.v_ned;
    assert!((v.z - 3.661).abs() < 5e-4 && v.xy().norm() < 1e-12, "{v}");
    assert_eq!(sim.state().rotor_speed, [0.0; 8]);
}
