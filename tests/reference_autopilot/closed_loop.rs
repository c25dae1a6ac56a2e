//! The vehicle flies on HIL messages alone: hang, OFFBOARD, arm, release, velocity setpoints at 50 Hz, steady
//! state; and flies as the same controller does without frames.

use std::ops::ControlFlow;
use std::sync::Arc;

use mavlink::dialects::common::*;
use nalgebra::Vector3;
use samara::assess::{SafetyLimits, VerdictBuilder};
use samara::link::Link;
use samara::model::Parachute;
use samara::model::parachute::Pendulum;
use samara::sim::{DropSimulation, FlightPlan, Phase, Reference, Start, fly};

use super::bench::{Bench, TITAN, actuators, cascade, command, level_no_thrust, site, velocity};

const HANG_S: f64 = 2.0;
const DURATION_S: f64 = 35.0;
const TARGET: Vector3<f64> = Vector3::new(4.0, 0.0, 4.0);

pub fn under_the_canopy() -> DropSimulation {
    let pendulum = Pendulum { amplitude_rad: 0.1, phase_rad: 0.7, omega_rad_s: 2.0, length_m: 1.0 };
    let parachute = Parachute::new(3.0, 0.5, pendulum).unwrap();
    DropSimulation::new(Arc::clone(&TITAN), site(), parachute, HANG_S, Start::Release)
}

fn verdict_builder() -> VerdictBuilder {
    let limits = SafetyLimits {
        speed_m_s: 12.0,
        pitch_rad: 45f64.to_radians(),
        pitch_rate_rad_s: 90f64.to_radians(),
        vertical_acceleration_m_s2: 3.0,
    };
    VerdictBuilder::new(limits, TARGET)
}

/// The simulator's part of a step: the state, as ODOMETRY with NED velocities.
pub fn observe(bench: &mut Bench, sim: &DropSimulation) {
    let body = &sim.state().body;
    let (p, v, w) =
        (body.p_ned.map(|x| x as f32), body.v_ned.map(|x| x as f32), body.omega_body.map(|x| x as f32));
    bench.state = ODOMETRY_DATA {
        x: p.x,
        y: p.y,
        z: p.z,
        q: body.q_ned_from_body.map(|c| c as f32),
        vx: v.x,
        vy: v.y,
        vz: v.z,
        rollspeed: w.x,
        pitchspeed: w.y,
        yawspeed: w.z,
        frame_id: MavFrame::MAV_FRAME_LOCAL_NED,
        child_frame_id: MavFrame::MAV_FRAME_LOCAL_NED,
        ..Default::default()
    };
}

#[test]
fn closed_form_a_drop_over_hil_messages_is_the_drop_without_them() {
    let mut sim = under_the_canopy();
    let mut bench = Bench::new();
    let mut judge = verdict_builder();
    for step in 0..(DURATION_S * 250.0) as u64 {
        observe(&mut bench, &sim);
        // The companion, at 50 Hz, on the simulated clock.
        if step % 5 == 0 {
            let setpoint = match sim.phase() {
                Phase::Powered => {
                    MavMessage::SET_POSITION_TARGET_LOCAL_NED(velocity([4.0, 0.0, 4.0], 0x0DC7))
                }
                _ => level_no_thrust(),
            };
            bench.send(Link::Api, &setpoint);
        }
        match step {
            100 => {
                bench.send(Link::Api, &command(MavCmd::MAV_CMD_DO_SET_MODE, &[1.0, 6.0]));
                bench.send(Link::Api, &command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, &[1.0]));
                assert!(bench.session.autopilot().is_armed());
            }
            500 => sim.release(),
            _ => {}
        }
        let controls = actuators(&bench.step()).controls;
        let throttle = std::array::from_fn(|i| f64::from(controls[i]));
        if sim.phase() != Phase::Powered {
            assert_eq!(throttle, [0.0; 8]);
        }
        judge.observe(&sim.sample(&throttle, None));
        sim.step(&throttle, 0.004);
    }
    let over_wire = judge.finish().unwrap();

    let mut sim = under_the_canopy();
    let mut judge = verdict_builder();
    sim.schedule_release(HANG_S);
    let plan = FlightPlan::new(Reference::Step(TARGET), 0.004, DURATION_S);
    let outcome = fly(&mut sim, &mut cascade(), &plan, &mut |sample| {
        judge.observe(sample);
        ControlFlow::Continue(())
    });
    assert_eq!(outcome, ControlFlow::Continue(()));
    let without = judge.finish().unwrap();

    assert!(
        (over_wire.outcome.j_tpf - without.outcome.j_tpf).abs() < 1e-5 * without.outcome.j_tpf,
        "{} {}",
        over_wire.outcome.j_tpf,
        without.outcome.j_tpf
    );
    assert!((over_wire.outcome.final_v_ned() - TARGET).norm() < 0.04, "{}", over_wire.outcome.final_v_ned());
    assert!((over_wire.outcome.final_v_ned() - without.outcome.final_v_ned()).norm() < 1e-4);
    assert_eq!(over_wire.limits_passed, without.limits_passed);
    assert!(over_wire.outcome.steady_after_s.is_some());
}
