//! The dynamics of the shipped missions' vehicles over eight numbers and over dual ones: the same source.

use std::ops::ControlFlow;
use std::sync::Arc;

use proptest::prelude::*;
use proptest::strategy::ValueTree as _;
use samara::config::Mission;
use samara::control::{ControlOutput, Controller, Measurement, Setpoint, ThrustCurve, TiltFrom};
use samara::frames::{Quaternion, normalized};
use samara::link::{HilConfig, HilSession, StreamerConfig, StreamerSession};
use samara::model::drives::{Motors, OnBus};
use samara::model::environment::Ambient;
use samara::model::factors::Factors;
use samara::model::parachute::Hook;
use samara::model::rigid_body::{Motion, MotionRate};
use samara::model::supply::Bus;
use samara::model::vehicle::FlightRate;
use samara::model::{MAX_ROTORS, PerRotor, Vehicle};
use samara::plan::SolverOptions;
use samara::real::{Dual, Real};
use samara::sim::{
    DropRunConfig, DropSimulation, Flight, FlightPlan, Ground, Reference, ReleaseTrigger, Sample, fly,
    fly_many,
};
use samara::study::controller::{KeepsHeading, controller};
use samara::study::effects::{EffectFlights, EffectsOn};
use samara::trajectory::Trajectory;
use samara::vector::V3;

use crate::lockstep::bench;

/// Missions whose vehicles and batteries differ in what their rates are made of: rotors by table and by
/// blades, motors of both kinds, coaxial pairs, a body with a side force, batteries.
const MISSIONS: [&str; 6] =
    ["titan_paper", "titan_drop", "x500_ground", "x500_drop", "octo_drop", "dragonfly_drop"];

/// A vehicle's state with commands, air and battery: attitude, velocity, body rates, rotor speeds, throttles,
/// gravity, density, wind, voltage without load, deviations of thrusts, factors on what is known.
const NUMBERS: usize = 4 + 3 + 3 + 8 + 8 + 2 + 3 + 1 + 8 + 8;

/// What a flight's numbers make of the vehicle, the bus with it.
fn derived<S: Real>(mission: &Mission, x: [S; NUMBERS]) -> Vec<S> {
    let vehicle: &Vehicle = &mission.vehicle;
    let kind = x[0];
    let mut left = x.into_iter();
    let mut next = || left.next().unwrap();
    let q_ned_from_body: Quaternion<S> = std::array::from_fn(|_| next());
    let v_ned = V3::new(next(), next(), next());
    let omega_body = V3::new(next(), next(), next());
    let speed: [S; MAX_ROTORS] = std::array::from_fn(|_| next());
    let throttle: [S; MAX_ROTORS] = std::array::from_fn(|_| next());
    let (gravity_m_s2, density_kg_m3) = (next(), next());
    let ambient = Ambient { gravity_m_s2, density_kg_m3, wind_ned_m_s: V3::new(next(), next(), next()) };
    let open_v = next();
    let deviations: [S; MAX_ROTORS] = std::array::from_fn(|_| next());
    let factors = Factors::from_array(std::array::from_fn(|_| next()));
    let around = (&ambient, Some(&factors));

    let motion = Motion { q_ned_from_body, v_ned, omega_body };
    let law = vehicle.motor.law();
    let (count, throttle, speed) = (vehicle.rotors.len(), &throttle, &speed);
    let motors = Motors { law: &law, count, conditions: None, throttle, speed };
    let mut rate = FlightRate::nothing(kind);
    let mut bus: Option<Bus<S>> = None;
    if let Some(battery) = &mission.electric {
        let mut near_v = open_v;
        let pack = battery.pack();
        let drives = OnBus { motors, pack, open_v, near_v: &mut near_v, bus: &mut bus };
        vehicle.derive(around, &motion, speed, &mut Some(deviations), drives, &mut rate);
    } else {
        vehicle.derive(around, &motion, speed, &mut Some(deviations), motors, &mut rate);
    }
    let MotionRate { q_dot, v_dot_ned: v, omega_dot_body: w } = rate.motion;
    let mut all = vec![v.x, v.y, v.z, w.x, w.y, w.z, rate.weight_n];
    all.extend(q_dot);
    for part in [
        rate.rotor_force_body,
        rate.aero_force_body,
        rate.rotor_moment_body,
        rate.aero_moment_body,
        rate.reaction_moment_body,
        rate.gyro_moment_body,
    ] {
        all.extend([part.x, part.y, part.z]);
    }
    all.extend(rate.rotor_acceleration);
    all.extend(rate.thrust_n);
    all.extend(rate.torque_nm);
    if let Some(bus) = bus {
        all.extend([bus.bus_v, bus.pack_a]);
        all.extend(bus.esc_a);
    }
    all
}

/// The numbers of a flight by as many between 0 and 1.
fn numbers(mission: &Mission, unit: [f64; NUMBERS]) -> [f64; NUMBERS] {
    let mut left = unit.into_iter();
    let mut next = |low: f64, high: f64| low + (high - low) * left.next().unwrap();
    let mut x = Vec::new();
    x.extend(normalized(std::array::from_fn(|_| next(-1.0, 1.0))));
    x.extend((0..3).map(|_| next(-12.0, 12.0)));
    x.extend((0..3).map(|_| next(-3.0, 3.0)));
    let fastest = mission.vehicle.motor.omega_max_rad_s();
    x.extend((0..MAX_ROTORS).map(|_| next(-0.05, 1.05) * fastest).map(|speed| speed.max(0.0)));
    x.extend((0..MAX_ROTORS).map(|_| next(0.0, 1.0)));
    let site = &mission.site.environment;
    x.extend([next(0.9, 1.1) * site.gravity_m_s2, next(0.5, 1.5) * site.density_kg_m3]);
    x.extend((0..3).map(|_| next(-8.0, 8.0)));
    let full_v = mission.electric.as_ref().map_or(1.0, |battery| battery.pack().open_circuit_v(1.0));
    // One flight in ten has an empty battery.
    let share = next(0.55, 1.05);
    x.push(if share < 0.6 { 0.0 } else { share * full_v });
    x.extend((0..MAX_ROTORS).map(|_| next(-0.3, 0.3)));
    x.extend((0..8).map(|_| next(0.8, 1.2)));
    x.try_into().unwrap()
}

fn missions() -> Vec<Mission> {
    MISSIONS.map(|name| Mission::shipped(name).unwrap()).into()
}

fn flights() -> impl Strategy<Value = Vec<Vec<f64>>> {
    prop::collection::vec(prop::collection::vec(0.0f64..1.0, NUMBERS), 8)
}

/// Eight flights side by side have the bits of eight flights one by one, in each number of their derivatives.
#[cfg(target_arch = "x86_64")]
#[test]
fn prop_eight_flights_have_the_bits_of_single_ones() {
    use samara::simd::lanes::{Avx2, Lanes};

    let Some(proof) = Avx2::found() else { return };
    for mission in missions() {
        let mut runner = proptest::test_runner::TestRunner::deterministic();
        let tried = runner.run(&flights(), |units| {
            let each: Vec<_> =
                units.into_iter().map(|unit| numbers(&mission, unit.try_into().unwrap())).collect();
            let beside =
                std::array::from_fn(|k| Lanes::new(proof, std::array::from_fn(|lane| each[lane][k])));
            let beside = derived(&mission, beside);
            for (lane, flight) in each.into_iter().enumerate() {
                for (k, (found, wanted)) in beside.iter().zip(derived(&mission, flight)).enumerate() {
                    let found = found.to_array()[lane];
                    prop_assert_eq!(
                        found.to_bits(),
                        wanted.to_bits(),
                        "{} {}: {} {}",
                        lane,
                        k,
                        found,
                        wanted
                    );
                }
            }
            Ok(())
        });
        tried.unwrap_or_else(|why| panic!("{}: {why}", mission.name));
    }
}

/// Dual numbers have the value's bits, and slopes that are those of small differences, but where a difference
/// goes across an edge of a table or a limit: of nearly all.
#[test]
fn prop_dual_numbers_are_the_slopes_of_the_same_source() {
    const STEP: f64 = 1e-6;
    for mission in missions() {
        let mut runner = proptest::test_runner::TestRunner::deterministic();
        let (mut all, mut off) = (0, 0);
        for _ in 0..8 {
            let unit = prop::collection::vec(0.0f64..1.0, NUMBERS).new_tree(&mut runner).unwrap().current();
            let x = numbers(&mission, unit.try_into().unwrap());
            let value = derived(&mission, x);
            for k in 0..NUMBERS {
                let slope = |i| if i == k { 1.0 } else { 0.0 };
                let duals = std::array::from_fn(|i| Dual { value: x[i], slope: [slope(i)] });
                let moved = |by: f64| {
                    let mut moved = x;
                    moved[k] += by * (1.0 + x[k].abs());
                    derived(&mission, moved)
                };
                let (above, below) = (moved(STEP), moved(-STEP));
                for (i, dual) in derived(&mission, duals).into_iter().enumerate() {
                    assert_eq!(dual.value.to_bits(), value[i].to_bits(), "{}", mission.name);
                    let difference = (above[i] - below[i]) / (2.0 * STEP * (1.0 + x[k].abs()));
                    let size = 1.0 + difference.abs() + dual.value.abs();
                    all += 1;
                    off += usize::from(!((dual.slope[0] - difference).abs() <= 1e-4 * size));
                }
            }
        }
        assert!(off * 200 < all, "{}: {off} of {all}", mission.name);
    }
}

/// Missions whose drops are flown without a wire, and how far their motions are alike: by a prescribed canopy
/// and a body of its own, on the ground, with a battery, in wind, under rotors that are started.
const DROPS: [&str; 9] = [
    "titan_paper",
    "titan_drop",
    "titan_no_wire",
    "x500_drop",
    "x500_ground",
    "octo_drop",
    "hexa_drop",
    "balloon_drop",
    "dragonfly_drop",
];

/// Flights of a mission's first drops as it is, of a length [s], and the plan that they fly along.
fn drops<'a>(mission: &Mission, plan: &'a Trajectory, count: u64, duration_s: f64) -> Vec<Flight<'a>> {
    let reference = Reference::Plan {
        trajectory: plan,
        then_v_ned: Some(mission.target_v_ned),
        feed_forward: mission.control.feed_forward,
    };
    let plan = FlightPlan {
        setpoint_period_s: Some(0.02),
        yaw_sp_rad: None,
        ..FlightPlan::new(reference, 0.004, duration_s)
    };
    let controller = Box::new(KeepsHeading::new(controller(mission).unwrap()));
    let flight = |trial| {
        let simulation = mission.with_drop(&mission.draw_drop(trial)).released_simulation();
        Flight { simulation, controller: controller.clone(), plan }
    };
    (0..count).map(flight).collect()
}

/// Flies five drops of a mission side by side, and the last two of them alone: each of their samples is the
/// same in every number. Both last to so long after the rotors are freed at the nominal time [s].
fn are_those_of_each_alone(mission: &Mission, past_s: f64) {
    are_those_of_each_alone_of(mission, past_s, |_, simulation| simulation);
}

/// Flies drops whose simulations are made of the mission's by the number of the trial, as above.
fn are_those_of_each_alone_of(
    mission: &Mission,
    past_s: f64,
    varied: impl Fn(u64, DropSimulation) -> DropSimulation,
) {
    let (release, name) = (&mission.release, &mission.name);
    let plan = mission.solve(&SolverOptions::default(), &mut |_| ControlFlow::Continue(())).unwrap();
    let duration_s = release.hang_s + release.parachute.delay_s + past_s;
    let mut flights = drops(mission, &plan.trajectory, 5, duration_s);
    for (trial, flight) in (0..).zip(&mut flights) {
        flight.simulation = varied(trial, flight.simulation.clone());
    }
    let mut alone: Vec<Vec<Sample>> = Vec::new();
    for flight in flights.iter().skip(3) {
        let (mut samples, mut flight) = (Vec::new(), flight.clone());
        let _ = fly(&mut flight.simulation, &mut *flight.controller, &flight.plan, &mut |sample| {
            samples.push(*sample);
            ControlFlow::Continue(())
        });
        alone.push(samples);
    }
    let mut next = [0usize; 5];
    fly_many(flights, &mut |i: usize, sample: &Sample| {
        if let Some(wanted) = i.checked_sub(3).map(|k| &alone[k][next[i]]) {
            assert_eq!(format!("{sample:?}"), format!("{wanted:?}"), "{name} {i}");
        }
        next[i] += 1;
        ControlFlow::Continue(())
    });
    assert_eq!(next[3..], [alone[0].len(), alone[1].len()], "{name}");
}

/// Drops side by side are those of each alone: hang, release, fall, powered flight.
#[test]
fn prop_drops_side_by_side_are_those_of_each_alone() {
    for name in DROPS {
        // The ground of the one that has one is met on the way down.
        are_those_of_each_alone(
            &Mission::shipped(name).unwrap(),
            if name == "x500_ground" { 30.0 } else { 1.0 },
        );
    }
}

/// So are those whose commands come late, whose cascade tilts from gravity and knows the voltage, with either
/// thrust curve.
#[test]
fn prop_drops_with_latency_and_a_known_voltage_are_those_of_each_alone() {
    let mut mission = Mission::shipped("x500_drop").unwrap();
    mission.vehicle = Arc::new(Vehicle { latency_s: 0.007, ..(*mission.vehicle).clone() });
    let limits = &mut mission.control.limits;
    (limits.tilt_from, limits.nominal_v) = (TiltFrom::Gravity, Some(14.8));
    are_those_of_each_alone(&mission, 1.0);
    mission.control.limits.thrust_curve = ThrustCurve::Linear;
    are_those_of_each_alone(&mission, 1.0);
}

/// So are those of vehicles that each are off by factors of their own, with latencies of their own.
#[test]
fn prop_varied_drops_are_those_of_each_alone() {
    for name in ["x500_drop", "titan_drop"] {
        let mission = Mission::shipped(name).unwrap();
        let varied = |trial: u64, simulation: DropSimulation| {
            let factors = Factors::from_array(std::array::from_fn(|k| {
                0.8 + 0.05 * ((trial * 7 + 3 * k as u64) % 9) as f64
            }));
            // One of them is as it is known.
            simulation.varied((trial != 4).then_some(factors), 0.003 * (trial % 4) as f64)
        };
        are_those_of_each_alone_of(&mission, 1.0, varied);
    }
}

/// So are drops that come to the ground under their canopies, which is when each is cut loose, at times of
/// their own.
#[test]
fn prop_drops_that_come_loose_one_by_one_are_those_of_each_alone() {
    let mut mission = Mission::shipped("x500_drop").unwrap();
    mission.site.ground = Some(Ground { down_m: -4.0 });
    are_those_of_each_alone(&mission, 2.0);
}

/// A property: each of their samples is, to the bit, that of the drop flown alone where canopies take over
/// from a hook.
#[test]
fn prop_drops_from_a_hook_are_those_of_each_alone() {
    let mut mission = Mission::shipped("x500_drop").unwrap();
    mission.release.parachute = mission.release.parachute.on_hook(Hook { lets_go_before_s: 7.0 });
    are_those_of_each_alone(&mission, 1.0);
}

/// What comes of whole drops, with each of a mission's effects alone, without each, with all and with none,
/// is the same for those that are flown side by side.
#[test]
fn prop_outcomes_side_by_side_are_those_of_each_alone() {
    for name in ["titan_drop", "x500_drop", "balloon_drop"] {
        let mission = Mission::shipped(name).unwrap();
        let plan = mission.solve(&SolverOptions::default(), &mut |_| ControlFlow::Continue(())).unwrap();
        for on in EffectsOn::campaigns(&mission.effects()) {
            let kept = on.kept(&mission.effects());
            let flights = EffectFlights::new(&mission, &kept, &plan.trajectory).unwrap();
            let beside = flights.fly_all(0..3);
            assert_eq!(beside[2], flights.fly(2), "{name} {}", on.name());
        }
    }
}

/// What an autopilot commanded, once more.
#[derive(Clone, Debug)]
struct Recorded {
    commands: Vec<PerRotor>,
    next: usize,
}

impl Controller for Recorded {
    fn reset(&mut self) {
        self.next = 0;
    }

    fn step(&mut self, _: &Measurement, _: &Setpoint, _: f64) -> ControlOutput {
        let commands = self.commands[self.next];
        self.next += 1;
        ControlOutput::from_throttles(commands, 1.0)
    }
}

/// A drop of a mission over the wire, to a second after the rotors are freed, and the mission.
fn on_the_wire(mission: &Mission, plan: &Trajectory, trial: u64) -> (Mission, Vec<Sample>) {
    let mission = mission.with_drop(&mission.draw_drop(trial));
    let (hang_s, delay_s) = (mission.release.hang_s, mission.release.parachute.delay_s);
    let duration_us = ((hang_s + delay_s + 1.0) * 250.0).ceil() as u64 * 4000;
    let run = DropRunConfig { trigger: ReleaseTrigger::Time, duration_us, ..DropRunConfig::default() };
    let simulator =
        HilSession::new(mission.simulation(), HilConfig { seed: mission.seed, run, ..HilConfig::default() });
    let config = StreamerConfig {
        hang_s,
        delay_s,
        target_v_ned: mission.target_v_ned,
        commands_release: false,
        ..StreamerConfig::default()
    };
    let streamer = StreamerSession::new(config, plan.clone());
    let flown = bench::fly_by(bench::autopilot_of(&mission, None), simulator, streamer, |_, _, _| {});
    (mission, flown.log)
}

/// The commands of drops over the wire, flown side by side, give their truth in every number:
/// `SAMARA_RECORDED_DROPS` drops of each mission, two unless it is said otherwise.
#[test]
fn prop_recorded_drops_side_by_side_are_those_on_the_wire() {
    let count = std::env::var("SAMARA_RECORDED_DROPS").map_or(2, |count| count.parse().unwrap());
    for name in DROPS.into_iter().filter(|name| *name != "dragonfly_drop") {
        let mission = Mission::shipped(name).unwrap();
        let plan = mission.solve(&SolverOptions::default(), &mut |_| ControlFlow::Continue(())).unwrap();
        for begin in (0..count).step_by(8) {
            let recorded: Vec<_> = (begin..count.min(begin + 8))
                .map(|trial| on_the_wire(&mission, &plan.trajectory, trial))
                .collect();
            // Two are filled up to as many as fly side by side.
            let of = |i: usize| &recorded[i % recorded.len()];
            let flight = |i: usize| {
                let (mission, log) = of(i);
                let commands: Vec<_> = log.iter().map(|sample| sample.throttle).collect();
                let duration_s = 0.004 * (log.len() - 1) as f64;
                let plan = FlightPlan::new(Reference::Step(mission.target_v_ned), 0.004, duration_s);
                let controller = Box::new(Recorded { commands, next: 0 });
                Flight { simulation: mission.released_simulation(), controller, plan }
            };
            let mut next = [0; 8];
            fly_many((0..8).map(flight).collect(), &mut |i: usize, found: &Sample| {
                let wanted = Sample { v_sp_ned: found.v_sp_ned, ..of(i).1[next[i]] };
                assert_eq!(format!("{found:?}"), format!("{wanted:?}"), "{name} {i}");
                next[i] += 1;
                ControlFlow::Continue(())
            });
            assert!((0..8).all(|i| next[i] == of(i).1.len()), "{name}");
        }
    }
}
