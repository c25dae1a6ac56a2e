//! Any order of events and orders.

use proptest::prelude::*;

use super::*;

/// What may happen to an autopilot between two steps.
fn happen(bench: &mut Bench, what: u8, x: f64) {
    let now = bench.now_us;
    let mode = FlightMode::all().nth(usize::from(what / 20) % 12).unwrap();
    let autopilot = &mut bench.autopilot;
    match what % 20 {
        0 => drop(autopilot.arm(now, x > 0.0)),
        1 => drop(autopilot.disarm(x > 0.0)),
        2 => drop(autopilot.take_off_to(now, x)),
        3 => drop(autopilot.reposition(now, Vector3::new(x, -x, x), YawSetpoint::Angle(x))),
        4 => autopilot.set_speed((x > 0.0).then_some(x)),
        5 => autopilot.set_home(Vector3::new(x, x, x)),
        6 => autopilot.guard.set_charge(x.abs() / 100.0),
        7 => autopilot.hear_ground_station(now),
        16 | 17 => {
            let at = |k: f64| crate::math::sin(k * x);
            let sticks = Sticks { pitch: at(1.0), roll: at(2.0), throttle: at(3.0), yaw: at(4.0) };
            autopilot.take_sticks(now, StickSource(u64::from(what / 90)), sticks);
        }
        8 => drop(autopilot.settings.set("GF_ACTION", x.abs().rem_euclid(6.0).floor())),
        9 => drop(autopilot.settings.set("GF_MAX_HOR_DIST", x.abs())),
        10 => bench.p_ned = Vector3::new(x, 0.0, -x),
        11 => bench.measurement.v_ned = Vector3::new(0.0, x / 10.0, x / 20.0),
        12 => {
            let p = [Some(x), Some(-x), Some(x)];
            let frame = VelocityFrame::Ned;
            let place =
                OffboardSetpoint::Place { frame, p, v: [None; 3], a: [None; 3], yaw: YawSetpoint::Rate(x) };
            let _ = autopilot.offer_setpoint(now, place);
        }
        18 => autopilot.load_mission(&missions::some_items(x), None, &missions::site()),
        19 => drop(autopilot.mission_mut().set_current(what.into())),
        _ => drop(autopilot.request_mode(now, mode)),
    }
}

proptest! {
    /// Whatever happens, throttles are throttles, and a disarmed vehicle has none.
    #[test]
    fn prop_any_order_of_orders_gives_throttles(
        orders in prop::collection::vec((any::<u8>(), -200.0f64..200.0, 1usize..400), 1..40),
    ) {
        let mut bench = Bench::new();
        for (what, x, steps) in orders {
            happen(&mut bench, what, x);
            for _ in 0..steps {
                let throttle = bench.step();
                prop_assert!(throttle.iter().all(|u| (0.0..=1.0).contains(u)), "{throttle:?}");
                prop_assert!(bench.autopilot.is_armed() || throttle == OFF);
            }
        }
    }
}
