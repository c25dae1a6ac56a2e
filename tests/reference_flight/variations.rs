//! The batch engine's states, step by step, against the code for flight in space with a vehicle and a site
//! that are varied in the same way: Titan and the X500, with blades and without, also with other rotors,
//! random gains and releases, gusts and latency.

use std::ops::ControlFlow;
use std::sync::{Arc, LazyLock};

use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;
use samara::config::load_vehicle;
use samara::control::{
    Airframe, Cascade, ControlLimits, Controller, Gains, Measurement, Setpoint, ThrustCurve, TiltFrom,
};
use samara::frames::quaternion_from_euler;
use samara::model::rigid_body::{BodyState, MassProperties};
use samara::model::wind::{Gust, GustLength, GustShape, RingFluctuation, Turbulence, TurbulenceScale, Wind};
use samara::model::{Environment, Interference, RotationSense, Rotor, RotorMount, Vehicle};
use samara::sim::planar::{Flight, LANES, Model, Observer, Release, SetpointTable, State, Variation, fly};
use samara::sim::{DropSimulation, FlightPlan, PlantKind, Reference};

use super::data::{TITAN, site};

/// The quadrotor of version 0.1, whose rotors know no flow.
static X500: LazyLock<Arc<Vehicle>> = LazyLock::new(|| vehicle("tests/data/v0.1/params/vehicles/x500.json"));

/// That quadrotor with rotors that drag across their axes.
static X500_DRAG: LazyLock<Arc<Vehicle>> = LazyLock::new(|| {
    let mut vehicle = Vehicle::clone(&X500);
    let Rotor::Quadratic { drag_n_s2_per_rad_m, .. } = &mut vehicle.rotor else { panic!() };
    *drag_n_s2_per_rad_m = 2e-4;
    Arc::new(vehicle)
});

/// The quadrotor with blades.
static X500_BLADES: LazyLock<Arc<Vehicle>> = LazyLock::new(|| vehicle("params/vehicles/x500.json"));

/// The lander with blades.
static BLADES: LazyLock<Arc<Vehicle>> = LazyLock::new(|| vehicle("params/vehicles/titan_bemt.json"));

fn vehicle(path: &str) -> Arc<Vehicle> {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    Arc::new(load_vehicle(&path).unwrap().vehicle)
}

const PERIOD_S: f64 = 0.01;

/// `[v_N, v_D, q0, q2, Q, front, rear]` of one lane at each control step.
struct Record {
    lane: usize,
    rows: Vec<[f64; 7]>,
}

impl Observer for Record {
    fn observe(&mut self, _step: usize, s: &State) -> ControlFlow<()> {
        let i = self.lane;
        let [front, rear, ..] = s.rotor_speed;
        self.rows.push([s.v_n[i], s.v_d[i], s.q0[i], s.q2[i], s.rate[i], front[i], rear[i]]);
        ControlFlow::Continue(())
    }
}

/// Rotors in place of a quadrotor's four, as wide as those: `(x, y, z)` of the right half in shares of the
/// half-spans, with the sense of rotation; mirror images turn the other way.
fn with_rotors(vehicle: &Vehicle, right: &[([f64; 3], RotationSense)]) -> Vehicle {
    let mut vehicle = vehicle.clone();
    let span = vehicle.rotors[0].position_body_m;
    let mount = |[x, y, z]: [f64; 3], spin| RotorMount {
        position_body_m: Vector3::new(x * span.x.abs(), y * span.y.abs(), z * span.x.abs()),
        axis_body: -Vector3::z(),
        spin,
        interference: Interference::NONE,
    };
    let other = |spin| if spin == RotationSense::Cw { RotationSense::Ccw } else { RotationSense::Cw };
    vehicle.rotors = right
        .iter()
        .flat_map(|&([x, y, z], spin)| [mount([x, y, z], spin), mount([x, -y, z], other(spin))])
        .collect();
    vehicle
}

/// Titan or the X500 with rotors of another layout: the quadrotor itself, one that is longer ahead, a hexa X,
/// an octo X, four coaxial pairs, and two rotors ahead, one behind, without reaction torques.
fn laid_out(vehicle: &Vehicle, layout: usize) -> Vehicle {
    use RotationSense::{Ccw, Cw};
    match layout {
        0 => vehicle.clone(),
        1 => with_rotors(vehicle, &[([1.1, 1.0, 0.0], Ccw), ([-0.9, 1.0, 0.1], Cw)]),
        2 => with_rotors(vehicle, &[([0.0, 1.4, 0.1], Cw), ([1.2, 0.7, 0.0], Ccw), ([-1.2, 0.7, 0.0], Ccw)]),
        3 => with_rotors(
            vehicle,
            &[
                ([1.3, 0.5, 0.0], Cw),
                ([0.5, 1.3, -0.1], Ccw),
                ([-0.6, 1.3, 0.0], Cw),
                ([-1.2, 0.5, 0.1], Ccw),
            ],
        ),
        4 => {
            let mut coaxial = with_rotors(
                vehicle,
                &[
                    ([1.0, 1.0, -0.2], Ccw),
                    ([1.0, 1.0, 0.2], Cw),
                    ([-1.0, 1.0, -0.2], Cw),
                    ([-1.0, 1.0, 0.2], Ccw),
                ],
            );
            for lower in coaxial.rotors.iter_mut().filter(|r| r.position_body_m.z > 0.0) {
                lower.interference = Interference { thrust: 0.6, torque: 0.8 };
            }
            coaxial
        }
        _ => {
            let mut three = with_rotors(vehicle, &[([0.6, 1.0, 0.0], Ccw), ([-1.2, 0.0, 0.0], Cw)]);
            three.rotors.pop();
            (three.options.reaction_torque, three.options.rotor_momentum) = (false, false);
            // Less weight on fewer rotors.
            let inertia = Matrix3::from(three.mass.inertia_kg_m2) * 0.75;
            three.mass = MassProperties::new(three.mass.mass_kg * 0.75, inertia).unwrap();
            three
        }
    }
}

fn earth() -> Environment {
    Environment { gravity_m_s2: 9.80665, density_kg_m3: 1.225, ..site() }
}

/// The vehicle and site that a variation makes of the nominal ones.
fn varied(vehicle: &Vehicle, site: &Environment, v: &Variation) -> (Vehicle, Environment) {
    let (mut vehicle, mut site) = (vehicle.clone(), site.clone());
    let inertia = Matrix3::from(vehicle.mass.inertia_kg_m2) * v.inertia;
    vehicle.mass = MassProperties::new(vehicle.mass.mass_kg * v.mass, inertia).unwrap();
    vehicle.aero = vehicle.aero.scaled(v.aero);
    vehicle.motor = vehicle.motor.with_lag(v.motor_lag);
    vehicle.rotors.iter_mut().for_each(|rotor| rotor.interference.thrust *= v.thrust);
    vehicle.latency_s += v.latency_s;
    site.density_kg_m3 *= v.density;
    site.wind_ned_m_s += Vector3::new(v.wind_m_s[0], 0.0, v.wind_m_s[1]);
    (vehicle, site)
}

/// The flight in space: nominal control law, varied vehicle and site.
fn in_space(
    nominal: (&Vehicle, &Environment),
    wind: &Wind,
    flight: &Flight,
    plan: &FlightPlan<'_>,
    (limits, kind): (&ControlLimits, PlantKind),
) -> Vec<[f64; 7]> {
    let (vehicle, site) = varied(nominal.0, nominal.1, &flight.variation);
    let airframe = Airframe::new(nominal.0, nominal.1).unwrap();
    let cascade = Cascade::new(airframe, flight.gains, *limits);
    let mut controller = cascade;
    let r = &flight.release;
    let body = BodyState {
        p_ned: Vector3::zeros(),
        q_ned_from_body: quaternion_from_euler(0.0, r.pitch_rad, 0.0),
        v_ned: Vector3::new(r.v_north_m_s, 0.0, r.v_down_m_s),
        omega_body: Vector3::new(0.0, r.pitch_rate_rad_s, 0.0),
    };
    let wind = wind.uniform(&site).in_plane();
    let course = flight.variation.air.and_then(|number| wind.course(&site, number));
    let mut sim = DropSimulation::at_t0(Arc::new(vehicle), site, body, kind).in_wind(course);
    let mut rows = Vec::new();
    for step in 0..=plan.steps() {
        let s = *sim.state();
        let (b, w) = (&s.body, &s.rotor_speed);
        rows.push([
            b.v_ned.x,
            b.v_ned.z,
            b.q_ned_from_body[0],
            b.q_ned_from_body[2],
            b.omega_body.y,
            w[0],
            w[1],
        ]);
        let t_s = step as f64 * plan.control_period_s;
        let (v_sp, a_ff) = plan.setpoint_at(t_s);
        let setpoint = Setpoint::Velocity { v_ned: v_sp, a_ff_ned: a_ff, yaw_rad: Some(0.0) };
        let throttle = controller.step(&Measurement::from(b), &setpoint, plan.control_period_s).throttle;
        sim.step(&throttle, plan.control_period_s);
    }
    rows
}

/// Largest difference in velocity, attitude and rate of a flight that is flown in a lane among strangers, and
/// what the flight in space makes of another last digit of the release: without thrust, with a late
/// command, the loop on the ideal plant may chatter, and then it makes a million times more of it within
/// a second.
fn difference(
    vehicle: &Vehicle,
    (site, wind): (&Environment, &Wind),
    lane: usize,
    flight: &Flight,
    target: [f64; 2],
    (limits, kind): (&ControlLimits, PlantKind),
) -> (f64, f64) {
    // One step of integration a period, where the motors' time constants are others.
    let period_s = if flight.variation.motor_lag == 1.0 { PERIOD_S } else { 0.2 * PERIOD_S };
    let plan = FlightPlan::new(Reference::Step(Vector3::new(target[0], 0.0, target[1])), period_s, 4.0);
    let model = Model::new(vehicle, site, limits, kind).unwrap().in_wind(wind);
    let mut stranger = *flight;
    stranger.release.v_north_m_s = 50.0;
    let mut lanes = [stranger; LANES];
    lanes[lane] = *flight;
    let mut record = Record { lane, rows: Vec::new() };
    fly(&model, &SetpointTable::new(&plan).unwrap(), &lanes, &mut record);
    let wanted = in_space((vehicle, site), wind, flight, &plan, (limits, kind));
    assert_eq!(record.rows.len(), wanted.len());
    let apart = |a: &[f64; 7], b: &[f64; 7]| (0..5).map(|k| (a[k] - b[k]).abs()).fold(0.0, f64::max);
    let furthest = |rows: &[[f64; 7]]| rows.iter().zip(&wanted).map(|(a, b)| apart(a, b)).fold(0.0, f64::max);
    let mut other = *flight;
    other.release.v_down_m_s += 1e-14;
    other.release.pitch_rate_rad_s += 1e-14;
    (furthest(&record.rows), furthest(&in_space((vehicle, site), wind, &other, &plan, (limits, kind))))
}

/// Gusts of any shape, by time or by distance, turbulence in the plane, and a vortex ring that fluctuates.
fn wind() -> impl Strategy<Value = Wind> {
    let gust = (0..3usize, prop::bool::ANY, -1.0f64..3.0, 0.3f64..3.0, -4.0f64..4.0, -2.0f64..2.0).prop_map(
        |(shape, far, start_s, length, n, d)| Gust {
            shape: [GustShape::Step, GustShape::OneMinusCosine, GustShape::Rise][shape],
            start_s,
            length: if far { GustLength::Distance(4.0 * length) } else { GustLength::Time(length) },
            peak_ned_m_s: [n, 0.0, d],
        },
    );
    let turbulence = (0.0f64..1.0, 0.0f64..1.0, 1.0f64..100.0, 0u64..1000).prop_map(|(u, w, l, seed)| {
        let scale = TurbulenceScale::Fixed([l, l, 0.5 * l]);
        Turbulence { sigma_m_s: [u, 0.0, w], scale, seed, follows_mission: true, noise: None }
    });
    let ring = (0.0f64..0.3, 0.1f64..10.0, 0u64..1000).prop_map(|(rms_share, frequency_hz, seed)| {
        RingFluctuation { rms_share, frequency_hz, seed, follows_mission: true, mirrored: false }
    });
    (prop::collection::vec(gust, 0..3), prop::option::of(turbulence), prop::option::of(ring))
        .prop_map(|(gusts, turbulence, ring)| Wind { gusts, turbulence, ring, ..Wind::default() })
}

fn variation() -> impl Strategy<Value = Variation> {
    let aero = prop::array::uniform3(0.5f64..1.5);
    let wind = prop::array::uniform2(-2.0f64..2.0);
    let rotors = (0.8f64..1.2, prop_oneof![Just(1.0), 0.7f64..1.5], prop_oneof![Just(0.0), 0.0f64..0.03]);
    (0.8f64..1.2, 0.8f64..1.2, aero, 0.8f64..1.2, wind, prop::option::of(0u64..1000), rotors).prop_map(
        |(mass, inertia, aero, density, wind_m_s, air, (thrust, motor_lag, latency_s))| Variation {
            mass,
            inertia,
            aero,
            density,
            wind_m_s,
            air,
            thrust,
            motor_lag,
            latency_s,
        },
    )
}

fn flight() -> impl Strategy<Value = Flight> {
    let gains = [0.5..5.0f64, 0.0..0.6, 0.1..2.0, 0.2..5.0, 0.0..1.0, 0.2..3.0, 0.0..0.05];
    let release = (-1.5f64..1.5, 2.0f64..5.0, -0.5f64..0.5, -0.9f64..0.9).prop_map(
        |(v_north_m_s, v_down_m_s, pitch_rad, pitch_rate_rad_s)| Release {
            v_north_m_s,
            v_down_m_s,
            pitch_rad,
            pitch_rate_rad_s,
        },
    );
    (gains.prop_map(Gains::longitudinal), release, variation())
        .prop_map(|(gains, release, variation)| Flight { gains, release, variation })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// Any gains, release, variation and layout of the rotors, in any lane.
    #[test]
    fn prop_varied_flights_are_the_flights_in_space(
        flight in flight(), lane in 0..LANES, airframe in 0usize..5, ideal in prop::bool::ANY,
        layout in 0usize..6, target in prop::array::uniform2(-1.0f64..4.0), wind in wind(),
        latency_s in prop_oneof![Just(0.0), Just(PERIOD_S), 0.0f64..0.05], from_gravity in prop::bool::ANY,
        linear in prop::bool::ANY,
    ) {
        let vehicle = [&*X500, &*X500_DRAG, &*X500_BLADES, &*TITAN, &*BLADES][airframe];
        let site = if airframe < 3 { earth() } else { site() };
        let kind = if ideal { PlantKind::Ideal } else { PlantKind::Actuator };
        let vehicle = Vehicle { latency_s, ..laid_out(vehicle, layout) };
        let tilt_from = if from_gravity { TiltFrom::Gravity } else { TiltFrom::Thrust };
        let thrust_curve = if linear { ThrustCurve::Linear } else { ThrustCurve::Quadratic };
        let controlled = (&ControlLimits { tilt_from, thrust_curve, ..ControlLimits::default() }, kind);
        let (apart, amplified) = difference(&vehicle, (&site, &wind), lane, &flight, target, controlled);
        prop_assert!(apart < f64::max(1e-6, 10.0 * amplified), "{apart:e}, {amplified:e} of the last digit");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    /// A vehicle that is off by factors flies as one that is built so, on any layout of rotors.
    #[test]
    fn prop_factors_are_those_of_a_vehicle_built_so(
        v in variation(), airframe in 0usize..5, layout in 0usize..6,
        throttle in prop::array::uniform8(0.0f64..1.0),
        v_ned in prop::array::uniform3(-6.0f64..6.0), tilt in prop::array::uniform3(-1.0f64..1.0),
    ) {
        let vehicle = laid_out([&*X500, &*X500_DRAG, &*X500_BLADES, &*TITAN, &*BLADES][airframe], layout);
        let site = if airframe < 3 { earth() } else { site() };
        let [roll, pitch, yaw] = tilt;
        let body = BodyState {
            p_ned: Vector3::zeros(),
            q_ned_from_body: quaternion_from_euler(roll, pitch, yaw),
            v_ned: v_ned.into(),
            omega_body: Vector3::new(pitch, roll, yaw),
        };
        // One step of integration a period, whatever the motors' time constants.
        let period_s = 0.1 * PERIOD_S;
        let (built, blown) = v.applied(&vehicle, &site).unwrap();
        let mut built = DropSimulation::at_t0(built, blown, body, PlantKind::Actuator);
        let mut off = DropSimulation::at_t0(Arc::new(vehicle), v.blown(&site), body, PlantKind::Actuator)
            .varied(v.factors(), v.latency_s);
        for _ in 0..400 {
            built.step(&throttle, period_s);
            off.step(&throttle, period_s);
        }
        let (a, b) = (built.state(), off.state());
        prop_assert!((a.body.v_ned - b.body.v_ned).norm() < 1e-9, "{a:?} {b:?}");
        prop_assert!((a.body.omega_body - b.body.omega_body).norm() < 1e-8, "{a:?} {b:?}");
        prop_assert!((a.rotor_speed[0] - b.rotor_speed[0]).abs() < 1e-8 * (1.0 + a.rotor_speed[0]));
    }
}

/// A strong controller stops the lander's rotors in flight, first those in front, within a step: its stages
/// have speeds below zero, at which the load is that at rest in the plane and in space. They once had loads
/// of their own there, 1e-6 m/s apart after 4 s.
#[test]
fn regress_rotors_that_come_to_rest_within_a_step() {
    let gains = Gains::longitudinal([
        2.800389890579977,
        0.40185948353542106,
        1.4000132560650975,
        2.180590592118759,
        0.0,
        2.3392363390404594,
        0.0,
    ]);
    let release = Release {
        v_north_m_s: -1.3399379129599054,
        v_down_m_s: 3.8571156915430964,
        pitch_rad: 0.3711972792271881,
        pitch_rate_rad_s: 0.8856675680127848,
    };
    let variation = Variation {
        mass: 0.878704222756241,
        inertia: 0.9880550728754508,
        aero: [1.3152812884454543, 1.2699402937433864, 0.6238398474368645],
        density: 0.9602420773048317,
        wind_m_s: [0.5573892706612037, -0.25048722336724155],
        thrust: 1.0,
        motor_lag: 1.0,
        air: None,
        latency_s: PERIOD_S,
    };
    let flight = Flight { gains, release, variation };
    let vehicle = laid_out(&BLADES, 4);
    let (site, wind) = (site(), Wind::default());
    let plan = FlightPlan::new(Reference::Step(Vector3::zeros()), PERIOD_S, 4.0);
    let controlled = (&ControlLimits::default(), PlantKind::Actuator);
    let rows = in_space((&vehicle, &site), &wind, &flight, &plan, controlled);
    assert!(rows.windows(2).any(|w| w[0][5] > 0.0 && w[1][5] == 0.0), "no rotor stops");
    let (apart, _) = difference(&vehicle, (&site, &wind), 0, &flight, [0.0; 2], controlled);
    assert!(apart < 1e-10, "{apart:e}");
}
