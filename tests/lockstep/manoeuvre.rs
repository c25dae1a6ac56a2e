//! Manoeuvres flown by the reference autopilot on its estimator, logged in PX4's format and identified: the
//! errors that were promised come out.

use mavlink::dialects::common::*;
use nalgebra::Vector3;
use samara::control::{Airframe, Cascade, ControlLimits, PositionGains};
use samara::frames::quaternion_from_euler;
use samara::identify::{Identified, Parameter, identify};
use samara::link::{FlightLog, LogEntry};
use samara::logged_flight::LoggedFlight;
use samara::manoeuvre::{Ask, Bounds, Kind, Recipe, Rehearsal, Step, Trial, USUAL};
use samara::model::wind::Wind;
use samara::sim::SensorSettings;
use samara::sim::sensors::Triad;
use samara::ulog::Ulog;

use super::ground_bench::{GAINS, MISSION, Wire};

const OFFBOARD: [f32; 2] = [1.0, 6.0];
/// A setpoint each 20 ms.
const STEPS: usize = 5;
const BOUNDS: Bounds =
    Bounds { tilt_rad: 0.6, speed_m_s: 12.0, below_m: 10.0, energy_j: f64::INFINITY, length_s: 120.0 };

fn rehearsal() -> Rehearsal {
    let (m, limits) = (&*MISSION, ControlLimits::default());
    let airframe = Airframe::new(&m.vehicle, &m.site.environment).unwrap();
    Rehearsal {
        vehicle: m.vehicle.clone(),
        site: m.site.environment.clone(),
        wind: Wind::default(),
        controller: Box::new(Cascade::new(airframe, GAINS, limits)),
        position: PositionGains::beside(&GAINS),
        sensors: sensors(),
    }
}

/// Flies steps in OFFBOARD, and gives the flight as its log has it; a seed draws the sensors' errors.
fn flown(steps: &[Step], seed: u64) -> LoggedFlight {
    let mut wire = Wire::sensing(sensors(), seed);
    wire.fly(10.0);
    let mut wire = wire.taken_off(20.0);
    let place = wire.body().p_ned.map(|x| x as f32);
    let (m, mut log) = (&*MISSION, None);
    let site = &m.site.environment;
    let hover = m.vehicle.mass.mass_kg * site.gravity_m_s2 / m.vehicle.static_lift_n(site.density_kg_m3);
    let mut write = |wire: &mut Wire| {
        while let Some(entry) = wire.autopilot.poll_log() {
            if let LogEntry::Begin(at, parameters) = &entry {
                log = Some(FlightLog::new(Vec::new(), *at, "x500", parameters).unwrap());
            }
            log.as_mut().unwrap().write(&entry).unwrap();
        }
    };
    let first = [Step { length_s: 1.0, ask: Ask::Hold }];
    let mut smooth = Vector3::zeros();
    for (i, step) in first.iter().chain(steps).enumerate() {
        if !matches!(step.ask, Ask::Velocity(..)) {
            smooth = Vector3::zeros();
        }
        for _ in 0..(step.length_s / 0.02).round() as usize {
            match step.ask {
                Ask::Hold => wire.setpoint(place.into(), [0.0; 3], 0x9F8),
                Ask::Velocity(v, most_m_s2) => {
                    let more: Vector3<f64> = Vector3::from(v) - smooth;
                    smooth += more * (0.02 * most_m_s2 / more.norm().max(0.02 * most_m_s2));
                    wire.setpoint([0.0; 3], smooth.map(|x| x as f32).into(), 0x9C7);
                }
                Ask::Attitude([roll, pitch, yaw], thrust) => {
                    wire.send(&MavMessage::SET_ATTITUDE_TARGET(SET_ATTITUDE_TARGET_DATA {
                        q: quaternion_from_euler(roll, pitch, yaw).map(|x| x as f32),
                        thrust: (thrust * hover) as f32,
                        type_mask: AttitudeTargetTypemask::from_bits_retain(7),
                        target_system: 1,
                        target_component: 1,
                        ..Default::default()
                    }));
                }
            }
            for _ in 0..STEPS {
                wire.step();
            }
            write(&mut wire);
        }
        if i == 0 {
            assert_eq!(wire.command(MavCmd::MAV_CMD_DO_SET_MODE, &OFFBOARD), 0, "{:?}", wire.texts);
        }
    }
    assert_eq!(wire.mode()[0], 6, "{:?}", wire.texts);
    let bytes = log.unwrap().finish().unwrap();
    LoggedFlight::of_ulog(&Ulog::read(&bytes).unwrap())
}

/// Usual sensors on a vehicle that shakes.
fn sensors() -> SensorSettings {
    let shaken = |triad: Triad, noise_density: f64| Triad { noise_density, ..triad };
    let SensorSettings { accelerometer, gyroscope, .. } = MISSION.sensors;
    SensorSettings {
        accelerometer: shaken(accelerometer, 0.02),
        gyroscope: shaken(gyroscope, 0.001),
        ..MISSION.sensors
    }
}

/// Flights of the recipe, each identified by itself.
const FLIGHTS: u64 = 6;

/// The recipe of the usual wanted errors is flown and identified: the standard errors are those that were
/// promised within a factor of two, and nothing is further off than is wanted. The standard error of one
/// flight comes from a few clusters that tell a number and scatters by half: it is taken over all flights.
#[test]
#[ignore = "long flights"]
fn closed_form_the_reference_autopilot_keeps_what_was_promised() {
    let flies = rehearsal();
    let trials: Vec<Trial> = Kind::ALL.iter().map(|kind| flies.trial(*kind, &BOUNDS, 1).unwrap()).collect();
    // Of as many rehearsals as the program has.
    let fly = |steps: &[Step]| (2..6).map(|seed| flies.expected(steps, seed)).collect::<Result<Vec<_>, _>>();
    let (recipe, expected) = Recipe::flown(&trials, &USUAL, &BOUNDS, fly).unwrap();
    println!("{recipe:?}");
    let steps = recipe.steps(&trials);
    let identified = |seed| identify(&[flown(&steps, seed)], &MISSION.vehicle, &flies.settings()).unwrap();
    let flights: Vec<_> = (1..=FLIGHTS).map(identified).collect();
    let mut missed = Vec::new();
    for parameter in Parameter::ALL {
        let (i, known) = (parameter as usize, [0.0, MISSION.vehicle.latency_s]);
        let of = |found: &Identified| {
            let one = found.of(parameter).unwrap_or_else(|| panic!("{:?}", found.refused));
            [one.deviation - known[usize::from(parameter == Parameter::Delay)], one.error]
        };
        let found: Vec<[f64; 2]> = flights.iter().map(of).collect();
        let rms =
            |which: usize| (found.iter().map(|x| x[which] * x[which]).sum::<f64>() / FLIGHTS as f64).sqrt();
        let most = found.iter().map(|[off, _]| off.abs()).fold(0.0, f64::max);
        let line = format!(
            "{} off {:.5}, at most {most:.5}, error {:.5} expected {:.5}",
            parameter.key(),
            rms(0),
            rms(1),
            expected[i]
        );
        println!("{line}");
        if !((0.5..=2.0).contains(&(rms(1) / expected[i])) && most < USUAL[i]) {
            missed.push(line);
        }
    }
    assert!(missed.is_empty(), "{missed:#?}");
}
