//! The modes that are flown with sticks: taken up, flown, lost; sticks that take over.

use super::*;
use crate::autopilot::estimator::{Estimator, EstimatorSettings};

const CENTRED: Sticks = Sticks { pitch: 0.0, roll: 0.0, throttle: 0.0, yaw: 0.0 };
const LOW: Sticks = Sticks { throttle: -1.0, ..CENTRED };
const CLIMB: Sticks = Sticks { throttle: 0.5, ..CENTRED };
const FORWARD: Sticks = Sticks { pitch: 1.0, ..CENTRED };
const PILOT: StickSource = StickSource(1);

impl Bench {
    /// Sticks at 25 Hz, the vehicle a point mass under the cascade's wanted acceleration; the last throttles.
    fn pilot(&mut self, sticks: Sticks, seconds: f64) -> PerRotor {
        let dt = STEP_US as f64 * 1e-6;
        let mut throttle = OFF;
        for step in 0..(seconds / dt).round() as usize {
            if step % 10 == 0 {
                self.autopilot.take_sticks(self.now_us, PILOT, sticks);
            }
            throttle = self.step();
            let out = self.autopilot.output();
            if out.collective_n > 0.0 {
                self.measurement.v_ned += out.acceleration_sp_ned * dt;
                self.p_ned += self.measurement.v_ned * dt;
            }
        }
        throttle
    }

    /// In the air in a mode, 50 m above home.
    fn piloted(mode: FlightMode) -> Self {
        let mut bench = Self::engaged(velocity(0.0, YawSetpoint::Keep));
        bench.autopilot.set_home(Vector3::zeros());
        bench.p_ned.z = -50.0;
        bench.step();
        bench.pilot(CENTRED, 0.1);
        bench.autopilot.request_mode(bench.now_us, mode).unwrap();
        bench.said();
        bench
    }

    fn set(&mut self, name: &str, value: f64) {
        assert!(self.autopilot.settings.set(name, value), "{name}");
    }
}

/// PX4 v1.14's UserModeIntention::change and Commander::arm: a mode with sticks may be chosen without them
/// while disarmed, not armed in, and not entered armed.
#[test]
fn regress_modes_with_sticks_are_refused_without_them() {
    for mode in [FlightMode::Posctl, FlightMode::Altctl, FlightMode::Stabilized, FlightMode::Manual] {
        let mut bench = Bench::new();
        bench.step();
        bench.autopilot.request_mode(bench.now_us, mode).unwrap();
        assert_eq!(bench.autopilot.arm(bench.now_us, false), Err(ArmingRefusal::NoSticks));
        bench.autopilot.request_mode(bench.now_us, FlightMode::AutoLoiter).unwrap();
        bench.autopilot.arm(bench.now_us, false).unwrap();
        let refused = bench.autopilot.request_mode(bench.now_us, mode);
        assert_eq!(refused, Err(ModeRefusal::NoSticks(mode)));
        assert_eq!(bench.autopilot.mode(), FlightMode::AutoLoiter);
        bench.autopilot.take_sticks(bench.now_us, PILOT, CENTRED);
        assert!(bench.autopilot.request_mode(bench.now_us, mode).is_ok());
    }
}

/// PX4's Commander::arm: the throttle stick not above 0.2 where it is a climb rate, below -0.8 where it is
/// the thrust; a forced arming skips that.
#[test]
fn regress_arming_looks_at_the_throttle_stick() {
    for (mode, throttle, wanted) in [
        (FlightMode::Posctl, 0.2, Ok(())),
        (FlightMode::Posctl, 0.21, Err(ArmingRefusal::ThrottleAboveCenter)),
        (FlightMode::Altctl, 0.21, Err(ArmingRefusal::ThrottleAboveCenter)),
        (FlightMode::Stabilized, -0.81, Ok(())),
        (FlightMode::Stabilized, -0.8, Err(ArmingRefusal::HighThrottle)),
        (FlightMode::AutoLoiter, 1.0, Ok(())),
    ] {
        let mut bench = Bench::new();
        bench.step();
        bench.autopilot.request_mode(bench.now_us, mode).unwrap();
        bench.autopilot.take_sticks(bench.now_us, PILOT, Sticks { throttle, ..CENTRED });
        assert_eq!(bench.autopilot.arm(bench.now_us, false), wanted, "{mode:?} {throttle}");
        assert!(bench.autopilot.arm(bench.now_us, true).is_ok());
    }
}

/// Sticks that are there before any mode was chosen bring POSCTL, later ones do not.
#[test]
fn regress_the_first_sticks_bring_posctl() {
    let mut bench = Bench::new();
    bench.step();
    bench.autopilot.take_sticks(bench.now_us, PILOT, CENTRED);
    assert_eq!(bench.autopilot.mode(), FlightMode::Posctl);
    bench.autopilot.request_mode(bench.now_us, FlightMode::AutoLoiter).unwrap();
    bench.pilot(CENTRED, 1.0);
    assert_eq!(bench.autopilot.mode(), FlightMode::AutoLoiter);
}

/// On the ground the motors stand until the throttle stick is above 65 %; landed they stand again, and two
/// seconds later the vehicle is disarmed.
#[test]
fn closed_form_posctl_takes_off_and_lands_by_the_throttle_stick() {
    let mut bench = Bench::new();
    bench.step();
    bench.autopilot.set_home(Vector3::zeros());
    bench.pilot(CENTRED, 0.1);
    bench.autopilot.arm(bench.now_us, false).unwrap();
    assert_eq!(bench.pilot(Sticks { throttle: 0.3, ..CENTRED }, 2.0), OFF);
    bench.pilot(CLIMB, 12.0);
    // (0.5 - 0.1)/0.9 = 4/9 of the stick is 0.4 (4/9) + 0.6 (4/9)^3 of 3 m/s.
    let x: f64 = 4.0 / 9.0;
    let climb = -3.0 * (0.4 * x + 0.6 * x * x * x);
    let target = |bench: &Bench| bench.autopilot.velocity_target().unwrap().v_ned.z;
    assert!((target(&bench) - climb).abs() < 1e-12, "{}", target(&bench));
    assert!((bench.measurement.v_ned.z - climb).abs() < 0.1, "{}", bench.measurement.v_ned);
    assert!(bench.autopilot.is_in_air());
    bench.pilot(CENTRED, 60.0);
    assert!(bench.measurement.v_ned.norm() < 0.01);
    bench.pilot(LOW, 30.0);
    assert_eq!(target(&bench), 0.7, "MPC_LAND_SPEED near home");
    // The ground.
    bench.said();
    for _ in 0..40 {
        bench.measurement.v_ned = Vector3::zeros();
        bench.pilot(LOW, 0.04);
    }
    assert!(!bench.autopilot.is_in_air());
    assert_eq!(bench.autopilot.output().throttle, OFF);
    bench.pilot(LOW, 2.0);
    assert!(!bench.autopilot.is_armed());
    assert_eq!(bench.said(), ["Landing detected", "Disarmed by landing", "disarmed"]);
}

/// At full stick 10 m/s along the nose, north; let go it stops, keeps its place, and comes back when pushed.
#[test]
fn closed_form_posctl_flies_forward_and_holds_its_place() {
    let mut bench = Bench::piloted(FlightMode::Posctl);
    bench.pilot(FORWARD, 20.0);
    assert!(
        (bench.measurement.v_ned - Vector3::new(10.0, 0.0, 0.0)).norm() < 0.2,
        "{}",
        bench.measurement.v_ned
    );
    bench.pilot(CENTRED, 60.0);
    let place = bench.autopilot.velocity_target().unwrap().p_ned.map(|p| p.unwrap());
    assert!((bench.p_ned - Vector3::from(place)).norm() < 0.3 && (place[2] + 50.0).abs() < 0.2);
    bench.p_ned.y += 2.0;
    bench.pilot(CENTRED, 0.004);
    let k = bench.autopilot.settings.position.k_pxy;
    assert!((bench.autopilot.velocity_target().unwrap().v_ned.y + 2.0 * k).abs() < 0.06);
}

/// In ALTCTL a stick is an acceleration, within MPC_TILTMAX_AIR; let go, the vehicle flies on at its speed.
#[test]
fn closed_form_altctl_holds_the_height_and_not_the_place() {
    let mut bench = Bench::piloted(FlightMode::Altctl);
    bench.set("MPC_MAN_TILT_MAX", 20.0);
    bench.pilot(FORWARD, 2.0);
    let gravity = bench.autopilot.control_settings().airframe.gravity_m_s2;
    let wanted = 2.0 * gravity * crate::math::tan(20.0 * crate::units::RAD_PER_DEG);
    assert!((bench.measurement.v_ned.x - wanted).abs() < 0.05 * wanted, "{}", bench.measurement.v_ned.x);
    let coasting = bench.measurement.v_ned;
    bench.pilot(CENTRED, 5.0);
    assert!((bench.measurement.v_ned - coasting).norm() < 0.05, "{} {coasting}", bench.measurement.v_ned);
    assert!((bench.p_ned.z + 50.0).abs() < 0.1);
}

/// The middle of the stick carries the weight, full stick tilts by MPC_MAN_TILT_MAX; on the ground at idle
/// nothing counts as flying, so that nothing lands and disarms.
#[test]
fn closed_form_stabilized_is_tilt_and_thrust() {
    let mut bench = Bench::new();
    bench.step();
    bench.autopilot.request_mode(bench.now_us, FlightMode::Stabilized).unwrap();
    bench.autopilot.take_sticks(bench.now_us, PILOT, LOW);
    bench.autopilot.arm(bench.now_us, false).unwrap();
    for _ in 0..200 {
        bench.measurement.v_ned = Vector3::zeros();
        bench.pilot(LOW, 0.04);
    }
    let airframe = bench.autopilot.control_settings().airframe.clone();
    assert!((bench.autopilot.output().collective_n / airframe.lift_max_n - 0.08).abs() < 1e-12);
    assert!(bench.autopilot.is_armed() && !bench.autopilot.is_in_air());
    bench.measurement.v_ned = Vector3::zeros();
    bench.pilot(FORWARD, 0.04);
    let out = *bench.autopilot.output();
    assert!((out.collective_n - airframe.weight_n()).abs() < 1e-9 * airframe.weight_n());
    let pitched = crate::frames::pitch(out.q_sp);
    assert!((pitched + 35.0 * crate::units::RAD_PER_DEG).abs() < 1e-9, "{pitched}");
    assert!(bench.autopilot.is_in_air());
}

/// COM_RC_LOSS_T after the last of them sticks are lost, and NAV_RCL_ACT follows; regained they are said to
/// be, and but for RETURN POSCTL flies again.
#[test]
fn regress_the_loss_of_sticks_is_acted_upon() {
    for (action, mode) in
        [(1.0, FlightMode::AutoLoiter), (2.0, FlightMode::AutoRtl), (3.0, FlightMode::AutoLand)]
    {
        let mut bench = Bench::piloted(FlightMode::Posctl);
        bench.set("NAV_RCL_ACT", action);
        bench.pilot(CENTRED, 0.04);
        bench.run(0.45);
        assert_eq!(bench.autopilot.mode(), FlightMode::Posctl);
        bench.run(0.02);
        assert_eq!(bench.autopilot.mode(), mode);
        assert!(bench.autopilot.in_failsafe());
        let said = bench.said();
        assert_eq!((said.len(), said[0].as_str()), (2, "Manual control lost"), "{said:?}");
        let refused = bench.autopilot.request_mode(bench.now_us, FlightMode::Posctl);
        assert_eq!(refused, Err(ModeRefusal::NoSticks(FlightMode::Posctl)));
        bench.said();
        // It moves: what stands has landed, and stays.
        bench.measurement.v_ned.z = 0.5;
        bench.run(1.004);
        bench.pilot(CENTRED, 0.04);
        assert!(bench.said().contains(&"Manual control regained after 1.0 s".into()));
        let stays = mode == FlightMode::AutoRtl;
        assert_eq!(bench.autopilot.mode(), if stays { mode } else { FlightMode::Posctl });
    }
}

/// Whose sticks were never there, or were lost at arming, is not missed (PX4's
/// `_manual_control_lost_at_arming`); COM_RCL_EXCEPT makes exceptions of modes, COM_RC_IN_MODE 4 of all but
/// those with sticks.
#[test]
fn regress_sticks_are_missed_where_px4_misses_them() {
    let mut bench = Bench::engaged(velocity(0.0, YawSetpoint::Keep));
    bench.run(0.5);
    bench.autopilot.request_mode(bench.now_us, FlightMode::AutoLoiter).unwrap();
    bench.run(2.0);
    assert_eq!(bench.autopilot.mode(), FlightMode::AutoLoiter, "there never were any");

    let after_loss = |except: f64, input: f64, mode: FlightMode| {
        let mut bench = Bench::piloted(FlightMode::AutoLoiter);
        bench.set("COM_RCL_EXCEPT", except);
        bench.offer(velocity(0.0, YawSetpoint::Keep));
        bench.autopilot.request_mode(bench.now_us, mode).unwrap();
        bench.set("COM_RC_IN_MODE", input);
        for _ in 0..10 {
            bench.offer(velocity(0.0, YawSetpoint::Keep));
            bench.run(0.1);
        }
        bench.autopilot.mode()
    };
    let (hold, offboard, home) = (FlightMode::AutoLoiter, FlightMode::Offboard, FlightMode::AutoRtl);
    for (except, input, mode, then) in [
        (0.0, 1.0, hold, home),
        (2.0, 1.0, hold, hold),
        (2.0, 1.0, offboard, home),
        (4.0, 1.0, offboard, offboard),
        (0.0, 4.0, hold, hold),
        (7.0, 4.0, FlightMode::Altctl, home),
    ] {
        assert_eq!(after_loss(except, input, mode), then, "{except} {input} {mode:?}");
    }
}

/// Moved sticks bring POSCTL from automatic modes, from OFFBOARD only where COM_RC_OVERRIDE says so, and not
/// while a failsafe flies: then a mode has to be chosen.
#[test]
fn regress_moved_sticks_take_over() {
    let moved = |bench: &mut Bench| {
        for i in 0..10 {
            bench.pilot(Sticks { roll: f64::from(i) / 10.0, ..CENTRED }, 0.04);
        }
        bench.autopilot.mode()
    };
    for (overrides, mode, then) in [
        (1.0, FlightMode::AutoLoiter, FlightMode::Posctl),
        (1.0, FlightMode::AutoLand, FlightMode::Posctl),
        (1.0, FlightMode::Altctl, FlightMode::Altctl),
        (0.0, FlightMode::AutoRtl, FlightMode::AutoRtl),
        (1.0, FlightMode::Offboard, FlightMode::Offboard),
        (2.0, FlightMode::Offboard, FlightMode::Posctl),
    ] {
        let mut bench = Bench::piloted(FlightMode::AutoLoiter);
        bench.set("COM_RC_OVERRIDE", overrides);
        bench.offer(velocity(0.0, YawSetpoint::Keep));
        bench.autopilot.request_mode(bench.now_us, mode).unwrap();
        bench.pilot(CENTRED, 0.2);
        assert_eq!(bench.autopilot.mode(), mode, "at rest");
        bench.said();
        assert_eq!(moved(&mut bench), then, "{overrides} {mode:?}");
        let said = bench.said().contains(&"Pilot took over using sticks".to_owned());
        assert_eq!(said, mode != then);
    }
    let mut bench = Bench::piloted(FlightMode::AutoLoiter);
    bench.set("GF_MAX_HOR_DIST", 10.0);
    bench.set("GF_ACTION", 3.0);
    bench.p_ned.x = 30.0;
    bench.pilot(CENTRED, 0.1);
    assert_eq!(moved(&mut bench), FlightMode::AutoRtl, "a failsafe");
    bench.autopilot.request_mode(bench.now_us, FlightMode::Posctl).unwrap();
    assert_eq!(bench.autopilot.mode(), FlightMode::Posctl);
}

/// A terminated vehicle listens to no sticks.
#[test]
fn regress_termination_ends_the_sticks() {
    let mut bench = Bench::piloted(FlightMode::Stabilized);
    bench.set("GF_MAX_HOR_DIST", 10.0);
    bench.set("GF_ACTION", 4.0);
    bench.p_ned.x = 30.0;
    assert_eq!(bench.pilot(CLIMB, 0.2), OFF);
    assert!(bench.autopilot.guard.is_terminated());
    assert_eq!(bench.pilot(FORWARD, 2.0), OFF);
    assert_eq!(bench.autopilot.mode(), FlightMode::Manual);
}

/// PX4 v1.14.3's `checkModeFallback` with COM_POSCTL_NAVL 0: without a position POSCTL becomes ALTCTL, and is
/// refused while that lasts.
#[test]
fn reference_posctl_falls_back_to_altctl_without_a_position() {
    let mut bench = Bench::piloted(FlightMode::Posctl);
    let blind = Estimator::new(EstimatorSettings::at_site(9.81, Vector3::x()));
    bench.autopilot.watch_estimator(bench.now_us, &blind);
    bench.pilot(CENTRED, 0.1);
    assert_eq!(bench.autopilot.mode(), FlightMode::Altctl);
    assert!(bench.autopilot.in_failsafe());
    assert_eq!(bench.said(), ["No valid position estimate", "Failsafe: ALTCTL"]);
    let refused = bench.autopilot.request_mode(bench.now_us, FlightMode::Posctl);
    assert_eq!(refused, Err(ModeRefusal::NoPosition(FlightMode::Posctl)));
}
