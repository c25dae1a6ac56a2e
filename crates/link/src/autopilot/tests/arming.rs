//! Arming and disarming, and what is left without a state or after a new start.

use super::*;

#[test]
fn regress_arming_is_checked_unless_forced() {
    let mut bench = Bench::new();
    assert_eq!(bench.autopilot.arm(0, false), Err(ArmingRefusal::NoState));
    bench.measurement.q_ned_from_body = quaternion_from_euler(1.2, 0.0, 0.0);
    bench.step();
    assert_eq!(bench.autopilot.arm(bench.now_us, false), Err(ArmingRefusal::Tilted));
    assert_eq!(bench.said().len(), 2);
    assert_eq!(bench.autopilot.arm(bench.now_us, true), Ok(()));
    assert_eq!(bench.said(), ["armed (forced)"]);
}

#[test]
fn regress_disarming_in_flight_needs_force_and_stops_the_motors() {
    let mut bench = Bench::engaged(level(0.0));
    bench.step();
    assert_eq!(bench.autopilot.disarm(false), Ok(()), "no thrust yet");
    bench.autopilot.arm(bench.now_us, false).unwrap();
    bench.offer(velocity(0.0, YawSetpoint::Keep));
    assert_ne!(bench.step(), OFF);
    bench.said();
    assert_eq!(bench.autopilot.disarm(false), Err(DisarmingRefusal::Flying));
    assert_eq!(bench.said(), ["Disarming denied: flying (force with 21196)"]);
    assert_eq!(bench.autopilot.disarm(true), Ok(()));
    assert_eq!(bench.step(), OFF);
    assert_eq!(bench.autopilot.disarm(false), Ok(()), "twice is nothing");
    assert_eq!(bench.said(), ["disarmed in flight (forced)"]);
}

#[test]
fn regress_without_a_state_the_last_commands_stay() {
    let mut bench = Bench::engaged(velocity(0.0, YawSetpoint::Keep));
    let last = bench.step();
    assert_eq!(bench.autopilot.coast(bench.now_us + STEP_US), last);
    bench.autopilot.disarm(true).unwrap();
    assert_eq!(bench.autopilot.coast(bench.now_us + 2 * STEP_US), OFF);
}

#[test]
fn regress_a_simulator_that_starts_over_finds_it_disarmed() {
    let mut bench = Bench::engaged(velocity(0.0, YawSetpoint::Keep));
    bench.run(0.5);
    bench.autopilot.restart();
    bench.now_us = 0;
    assert_eq!(bench.step(), OFF);
    assert!(!bench.autopilot.is_armed());
    assert_eq!(bench.integrals().acceleration_sp_ned, Vector3::zeros());
    assert_eq!(bench.said().last().map(String::as_str), Some("simulated time started over: disarmed"));
}

/// Each refusal is said in words that the table of noes knows, and has a cause and a command there. The
/// matches make whoever adds one look here.
#[test]
fn every_refusal_has_a_hint() {
    use crate::autopilot::arming::{ArmingRefusal as A, DisarmingRefusal as D};
    use crate::autopilot::estimator::NotAligned as N;
    use crate::autopilot::modes::{FlightMode, ModeRefusal as M};
    use crate::autopilot::setpoint::SetpointRefusal as S;
    use samara_core::hints::No;

    const fn arming(of: A) -> No {
        match of {
            A::NotAligned(N::NoInertial) => No::WaitsForInertial,
            A::NotAligned(N::NoMagnetometer) => No::WaitsForField,
            A::NotAligned(N::NoBarometer) => No::WaitsForPressure,
            A::NotAligned(N::NoSatellites) => No::WaitsForFix,
            A::NotAligned(N::NotCarried) => No::NothingCarries,
            A::NotAligned(N::Starting) => No::EstimatorStarts,
            A::NotAligned(N::Tilt) => No::TiltUncertain,
            A::NotAligned(N::Heading) => No::HeadingUncertain,
            A::NotAligned(N::Velocity) => No::VelocityUncertain,
            A::NotAligned(N::NoFix) => No::NoFixBelieved,
            A::NoState => No::NoState,
            A::StaleState => No::StaleState,
            A::Tilted => No::TiltedToArm,
            A::NoSticks => No::NoSticks,
            A::HighThrottle => No::HighThrottle,
            A::ThrottleAboveCenter => No::ThrottleAboveCenter,
            A::NoSetpoint => No::NoOffboardSignal,
            A::NoMission => No::NoMission,
            A::Terminated => No::Terminated,
        }
    }
    const fn mode(of: M) -> No {
        match of {
            M::NotFlown(_) => No::ModeNotFlown,
            M::NoSetpoint { .. } => No::NoSetpoint,
            M::NoPosition(_) => No::NoPosition,
            M::NoSticks(_) => No::NoSticks,
            M::NoMission => No::NoMission,
            M::Terminated(_) => No::Terminated,
        }
    }
    const fn setpoint(of: S) -> No {
        match of {
            S::NotFinite => No::SetpointNotFinite,
            S::QuaternionLength => No::SetpointQuaternion,
            S::ThrustRange => No::SetpointThrust,
            S::NoHeading => No::SetpointHeading,
        }
    }
    const fn disarming(of: D) -> No {
        match of {
            D::Flying => No::Flying,
        }
    }
    let aligned = [N::NoInertial, N::NoMagnetometer, N::NoBarometer, N::NoSatellites, N::NotCarried];
    let later = [N::Starting, N::Tilt, N::Heading, N::Velocity, N::NoFix];
    let arming_refusals = [A::NoState, A::StaleState, A::Tilted, A::NoSticks, A::HighThrottle];
    let more = [A::ThrottleAboveCenter, A::NoSetpoint, A::NoMission, A::Terminated];
    let armings = aligned.into_iter().chain(later).map(A::NotAligned).chain(arming_refusals).chain(more);
    let of = FlightMode::Offboard;
    let modes = [M::NotFlown(of), M::NoSetpoint { timeout_us: 1 }, M::NoPosition(of), M::NoSticks(of)];
    let modes = modes.into_iter().chain([M::NoMission, M::Terminated(of)]);
    let setpoints = [S::NotFinite, S::QuaternionLength, S::ThrustRange, S::NoHeading];
    let said = armings.map(|of| (of.to_string(), arming(of)));
    let said = said.chain(modes.map(|of| (of.to_string(), mode(of))));
    let said = said.chain(setpoints.map(|of| (of.to_string(), setpoint(of))));
    for (words, no) in said.chain([(D::Flying.to_string(), disarming(D::Flying))]) {
        assert_eq!(No::of_words(&words), Some(no), "{words}");
    }
}
