//! Lanes do not see each other, both compilations give the same bits, and what is not planar is refused.

use std::ops::ControlFlow;

use nalgebra::Vector3;
use proptest::prelude::*;

use super::engine::fly_portably;
use super::groups::{self, MOST_GROUPS};
use super::{Flight, LANES, Model, NotPlanar, Observer, Release, SetpointTable, State, Variation, fly};
use crate::control::test_vehicles::{lander, quadrotor, ring, site};
use crate::control::{ControlError, ControlLimits, Gains};
use crate::frames::quaternion_from_euler;
use crate::math;
use crate::model::blade_tests;
use crate::model::rigid_body::BodyState;
use crate::model::wind::{Gust, GustLength, GustShape, RingFluctuation, Turbulence, TurbulenceScale, Wind};
use crate::model::{EscDc, Motor, RotationSense, Rotor, RotorTable, Vehicle, VehicleOptions};
use crate::sim::{FlightPlan, PlantKind, Reference};

/// The bits of every number of every lane at every step.
#[derive(Default)]
struct Bits(Vec<[[u64; 7]; LANES]>);

impl Observer for Bits {
    fn observe(&mut self, _step: usize, s: &State) -> ControlFlow<()> {
        let [front, rear, ..] = s.rotor_speed;
        let lane = |i| [s.v_n[i], s.v_d[i], s.q0[i], s.q2[i], s.rate[i], front[i], rear[i]].map(f64::to_bits);
        self.0.push(std::array::from_fn(lane));
        ControlFlow::Continue(())
    }
}

/// A lander with table rotors on uneven grids, direct-current motors and hubs above the centre of mass.
fn with_tables() -> Vehicle {
    let mut vehicle = lander(true);
    let (omega, airspeed, angle) = ([0.0, 60.0, 100.0, 140.0], [0.0, 2.0, 7.0], [-1.6, -0.3, 0.4, 1.6]);
    let mut cells = Vec::new();
    for w in omega {
        for v in airspeed {
            for a in angle {
                let thrust: f64 = 0.024 * w * w * (1.0 - 0.02 * v * a) + v * v * a;
                cells.push([thrust, 0.1 * thrust]);
            }
        }
    }
    vehicle.rotor = Rotor::Table(RotorTable::new(&omega, &airspeed, &angle, cells, 5.0).unwrap());
    vehicle.motor = Motor::EscDc(EscDc {
        omega_max_rad_s: 133.0,
        torque_constant_nm_a: 0.9,
        back_emf_constant_v_s_rad: 0.9,
        resistance_ohm: 0.2,
        voltage_max_v: 140.0,
        current_max_a: 30.0,
        current_min_a: 0.0,
        esc_gain_v_s_rad: 2.0,
        rotor_inertia_kg_m2: 0.09,
    });
    for rotor in &mut vehicle.rotors {
        rotor.position_body_m.z = if rotor.position_body_m.x > 0.0 { -0.3 } else { -0.1 };
    }
    vehicle
}

/// The lander of [`with_tables`] with blades.
fn with_blades() -> Vehicle {
    Vehicle { rotor: Rotor::BladeElement(blade_tests::LANDER.clone()), ..with_tables() }
}

/// A gust and turbulence, for flights that meet them.
fn model(vehicle: &Vehicle, kind: PlantKind) -> Model {
    let gust = Gust {
        shape: GustShape::OneMinusCosine,
        start_s: 0.3,
        length: GustLength::Distance(2.0),
        peak_ned_m_s: [3.0, 0.0, -1.0],
    };
    let turbulence = Turbulence {
        sigma_m_s: [0.5; 3],
        scale: TurbulenceScale::Fixed([20.0, 20.0, 10.0]),
        seed: 5,
        follows_mission: true,
        noise: None,
    };
    let ring = RingFluctuation {
        rms_share: 0.3,
        frequency_hz: 1.0,
        seed: 5,
        follows_mission: true,
        mirrored: false,
    };
    let wind = Wind { gusts: vec![gust], turbulence: Some(turbulence), ring: Some(ring), ..Wind::default() };
    Model::new(vehicle, &site(), &ControlLimits::default(), kind).unwrap().in_wind(&wind)
}

fn plan(duration_s: f64) -> FlightPlan<'static> {
    FlightPlan::new(Reference::Step(Vector3::new(4.0, 0.0, 4.0)), 0.01, duration_s)
}

fn flight() -> impl Strategy<Value = Flight> {
    let numbers = prop::array::uniform12(0.0f64..1.0);
    (numbers, prop::bool::ANY, prop::bool::ANY).prop_map(|(x, late, gusty)| Flight {
        gains: Gains::longitudinal([5.0 * x[0], x[1], 2.0 * x[2], 5.0 * x[3], x[4], 3.0 * x[5], 0.1 * x[6]]),
        release: Release {
            v_north_m_s: 4.0 * x[7] - 2.0,
            v_down_m_s: 6.0 * x[8],
            pitch_rad: 6.0 * x[9] - 3.0,
            pitch_rate_rad_s: 4.0 * x[10] - 2.0,
        },
        variation: Variation {
            mass: 0.5 + x[11],
            density: 1.5 - x[11],
            thrust: if late { 1.5 - x[11] } else { 1.0 },
            motor_lag: if late { 0.5 + x[10] } else { 1.0 },
            latency_s: if late { 0.03 * x[11] } else { 0.0 },
            air: gusty.then_some((1e6 * x[11]) as u64),
            ..Variation::NONE
        },
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn prop_a_flight_has_the_same_bits_in_every_lane_beside_any_neighbours_on_any_processor(
        flights in prop::array::uniform8(flight()), turn in 1..LANES, rotors in 0..3,
        ideal in prop::bool::ANY, broken in 0..LANES,
    ) {
        let kind = if ideal { PlantKind::Ideal } else { PlantKind::Actuator };
        let vehicle = match rotors {
            0 => lander(true),
            1 => with_tables(),
            _ => with_blades(),
        };
        let model = model(&vehicle, kind);
        let setpoints = SetpointTable::new(&plan(1.5)).unwrap();
        let (mut wide, mut narrow, mut turned) = (Bits::default(), Bits::default(), Bits::default());
        fly(&model, &setpoints, &flights, &mut wide);
        fly_portably(&model, &setpoints, &flights, &mut narrow);
        prop_assert!(wide.0 == narrow.0);
        let mut others = flights;
        others.rotate_left(turn);
        others[broken].release.v_down_m_s = f64::NAN;
        others[broken].variation.mass = 0.0;
        fly(&model, &setpoints, &others, &mut turned);
        for (a, b) in wide.0.iter().zip(&turned.0) {
            for lane in (0..LANES).filter(|lane| *lane != broken) {
                prop_assert!(b[lane] == a[(lane + turn) % LANES]);
            }
        }
    }
}

fn refusal(change: impl FnOnce(&mut Vehicle)) -> NotPlanar {
    let mut vehicle = lander(true);
    change(&mut vehicle);
    Model::new(&vehicle, &site(), &ControlLimits::default(), PlantKind::Ideal).unwrap_err()
}

#[test]
fn vehicles_that_are_not_symmetric_are_refused() {
    assert_eq!(refusal(|v| v.rotors.truncate(3)), NotPlanar::RotorPlacement { rotor: 2 });
    assert_eq!(
        refusal(|v| v.rotors[1].axis_body = Vector3::new(0.0, 0.6, -0.8)),
        NotPlanar::RotorAxis { rotor: 2 }
    );
    assert_eq!(refusal(|v| v.rotors[0].position_body_m.y += 0.1), NotPlanar::RotorPlacement { rotor: 1 });
    assert_eq!(
        refusal(|v| v.rotors[0].spin = RotationSense::Cw),
        NotPlanar::PairRotation { first: 1, second: 3 }
    );
    let middle = refusal(|v| v.rotors[1].position_body_m.y = 0.0);
    assert_eq!(middle, NotPlanar::LoneRotation { rotor: 2 });
    let level = refusal(|v| v.rotors.iter_mut().for_each(|r| r.position_body_m.x = 0.3));
    assert_eq!(level, NotPlanar::Control(ControlError::NotSteerable { axis: "pitch" }));
    let coupled = refusal(|v| {
        (v.mass.inertia_kg_m2[(0, 1)], v.mass.inertia_kg_m2[(1, 0)]) = (5.0, 5.0);
    });
    assert_eq!(coupled, NotPlanar::Inertia);
    // The spins do not matter where neither torque nor momentum is modelled.
    let mut quiet = lander(false);
    quiet.rotors[0].spin = RotationSense::Cw;
    assert!(Model::new(&quiet, &site(), &ControlLimits::default(), PlantKind::Ideal).is_ok());
    // Six places fore and aft.
    quiet.rotors = ring(8, [1.0, 1.2], 0.0).rotors;
    quiet.rotors[6].position_body_m.x = 0.2;
    quiet.rotors[2].position_body_m.x = 0.2;
    quiet.rotors.swap_remove(4);
    assert_eq!(groups::groups(&quiet).map(|g| g.len()), Ok(4));
    for (i, rotor) in quiet.rotors.iter_mut().enumerate() {
        rotor.position_body_m = Vector3::new(i as f64 - 2.0, 0.0, 0.0);
    }
    assert_eq!(groups::groups(&quiet), Err(NotPlanar::Groups { found: 7, most: 4 }));
    let mut side = site();
    side.wind_ned_m_s.y = 1.0;
    let found = Model::new(&lander(false), &side, &ControlLimits::default(), PlantKind::Ideal).unwrap_err();
    assert_eq!(found.to_string(), "the wind leaves the vertical plane to the north");
}

#[test]
fn plans_and_releases_that_leave_the_plane_are_refused() {
    let sideways = |what| Err::<SetpointTable, _>(NotPlanar::Sideways { what });
    assert_eq!(
        SetpointTable::new(&FlightPlan { yaw_sp_rad: Some(0.1), ..plan(1.0) }),
        sideways("the heading")
    );
    let east = Reference::Step(Vector3::new(0.0, 1.0, 0.0));
    assert_eq!(SetpointTable::new(&FlightPlan { reference: east, ..plan(1.0) }), sideways("the reference"));
    for (period, duration) in [(0.0, 1.0), (f64::NAN, 1.0), (-0.01, 1.0), (0.01, 1e9), (0.01, f64::INFINITY)]
    {
        let refused = SetpointTable::new(&FlightPlan { control_period_s: period, ..plan(duration) });
        assert!(matches!(refused, Err(NotPlanar::OutOfRange { .. })), "{period} {duration}");
    }
    assert_eq!(SetpointTable::new(&plan(f64::NAN)).map(|c| c.steps()), Ok(0));
    let body = |roll: f64| BodyState {
        p_ned: Vector3::zeros(),
        q_ned_from_body: quaternion_from_euler(roll, 0.2, 0.0),
        v_ned: Vector3::new(0.1, 0.0, 3.0),
        omega_body: Vector3::new(0.0, 0.3, 0.0),
    };
    assert!(Release::of(&body(0.1)).is_err());
    let release = Release::of(&body(0.0)).unwrap();
    assert!((release.pitch_rad - 0.2).abs() < 1e-15 && release.pitch_rate_rad_s == 0.3);
}

/// In a vacuum with idle rotors: a parabola, and steady rotation through the vertical and beyond.
#[test]
fn closed_form_free_fall() {
    struct End(State, usize);
    impl Observer for End {
        fn observe(&mut self, step: usize, state: &State) -> ControlFlow<()> {
            (self.0, self.1) = (*state, step);
            ControlFlow::Continue(())
        }
    }
    let vehicle = quadrotor([0.95, 1.1], [620.0, 890.0, 1160.0], [0.0; 3], VehicleOptions::default());
    let down = Reference::Step(Vector3::new(0.0, 0.0, 900.0));
    let setpoints = SetpointTable::new(&FlightPlan { reference: down, ..plan(3.0) }).unwrap();
    let still = Flight {
        gains: Gains::longitudinal([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]),
        release: Release { v_north_m_s: 0.7, v_down_m_s: 3.0, pitch_rad: 0.1, pitch_rate_rad_s: 1.2 },
        variation: Variation::NONE,
    };
    for kind in [PlantKind::Ideal, PlantKind::Actuator] {
        let nothing = State {
            v_n: [0.0; LANES],
            v_d: [0.0; LANES],
            q0: [0.0; LANES],
            q2: [0.0; LANES],
            rate: [0.0; LANES],
            rotor_speed: [[0.0; LANES]; MOST_GROUPS],
        };
        let mut end = End(nothing, 0);
        fly(&model(&vehicle, kind), &setpoints, &[still; LANES], &mut end);
        let s = end.0;
        assert_eq!(end.1, 300);
        assert!((s.v_n[3] - 0.7).abs() < 1e-12 && (s.v_d[3] - 3.0 - 1.35 * 3.0).abs() < 1e-11);
        assert!((2.0 * math::atan2(s.q2[3], s.q0[3]) - 3.7).abs() < 1e-9 && s.rate[3] == 1.2);
    }
}
