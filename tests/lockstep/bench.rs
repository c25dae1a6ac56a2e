//! The Titan mission on the wire in memory.

use std::path::Path;
use std::sync::LazyLock;

use nalgebra::Vector3;
use samara::autopilot::estimator::EstimatorSettings;
use samara::autopilot::parameters::Parameters;
use samara::config::{Mission, load_mission};
use samara::control::{Airframe, Cascade, ControlSettings};
use samara::link::{
    AutopilotSession, AutopilotSetup, HilConfig, HilSession, Link, Lockstep, StreamerConfig, StreamerEvent,
    StreamerSession, TimeUs, Timed,
};
use samara::model::Parachute;
use samara::sim::{DropRunConfig, DropSimulation, FlightRecord, ReleaseTrigger, Sample, Start};
use samara::trajectory::{Node, Trajectory};
use serde_json::Value;

static MISSION: LazyLock<Mission> = LazyLock::new(|| {
    load_mission(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/reference_drop.json")).unwrap()
});

pub fn mission() -> &'static Mission {
    &MISSION
}

pub fn cascade() -> Cascade {
    let m = mission();
    Cascade::new(Airframe::new(&m.vehicle, &m.site.environment).unwrap(), m.control.gains, m.control.limits)
}

pub fn simulation() -> DropSimulation {
    simulation_of(mission().release.parachute, mission().release.start)
}

pub fn simulation_of(parachute: Parachute, start: Start) -> DropSimulation {
    let m = mission();
    DropSimulation::new(m.vehicle.clone(), m.site.environment.clone(), parachute, m.release.hang_s, start)
}

/// The velocities of the reference's optimal plan.
pub fn plan() -> Trajectory {
    let numbers: Value = serde_json::from_str(include_str!("../data/reference_flights.json")).unwrap();
    let table = &numbers["flight_reference"];
    let dt = table["dt_s"].as_f64().unwrap();
    let number = |row: &Value, i: usize| row[i].as_f64().unwrap();
    let node = |(k, r): (usize, &Value)| Node {
        t_s: k as f64 * dt,
        q_ned_from_body: samara::frames::LEVEL,
        v_ned: Vector3::new(number(r, 0), 0.0, number(r, 1)),
        omega_body: Vector3::zeros(),
        thrust_n: [0.0; 8],
        a_ned: Vector3::new(number(r, 2), 0.0, number(r, 3)),
    };
    let rows = table["vn_vd_dvn_dvd"].as_array().unwrap();
    Trajectory::new(rows.iter().enumerate().map(node).collect(), 4).unwrap()
}

pub struct Flown {
    pub log: Vec<Sample>,
    pub events: Vec<Timed<StreamerEvent>>,
    pub record: FlightRecord,
}

pub fn simulator() -> HilSession {
    simulator_of(simulation(), ReleaseTrigger::Command)
}

pub fn simulator_of(sim: DropSimulation, trigger: ReleaseTrigger) -> HilSession {
    let limits = Some(mission().limits.safety);
    let run = DropRunConfig { trigger, limits, ..DropRunConfig::default() };
    let config = HilConfig { seed: mission().seed, run, ..HilConfig::default() };
    HilSession::new(sim, config)
}

pub fn autopilot() -> AutopilotSession {
    autopilot_of(mission(), None)
}

/// A mission's autopilot, on the truth or on an estimator.
pub fn autopilot_of(m: &Mission, estimator: Option<EstimatorSettings>) -> AutopilotSession {
    let airframe = Airframe::new(&m.vehicle, &m.site.environment).unwrap();
    AutopilotSession::new(AutopilotSetup {
        system_id: 1,
        control: ControlSettings { airframe, gains: m.control.gains, limits: m.control.limits },
        controller: None,
        environment: m.site.environment.clone(),
        estimator,
        rotors: m.vehicle.rotors.len(),
        epoch_unix_us: m.epoch_unix_us,
        parameters: Parameters::of(&m.parameter_subject(), 1).unwrap(),
        keeps_parameters: false,
    })
}

pub fn streamer() -> StreamerSession {
    streamer_that(true)
}

/// One that commands the release, or that waits for whatever triggers it.
pub fn streamer_that(commands_release: bool) -> StreamerSession {
    let m = mission();
    let config = StreamerConfig {
        hang_s: m.release.hang_s,
        delay_s: m.release.parachute.delay_s,
        target_v_ned: m.target_v_ned,
        commands_release,
        ..StreamerConfig::default()
    };
    StreamerSession::new(config, plan())
}

/// Flies the whole mission; every frame goes by `tap`.
pub fn drop_on_the_wire(tap: impl FnMut(TimeUs, Link, &[u8])) -> Flown {
    fly(simulator(), streamer(), tap)
}

pub fn fly(simulator: HilSession, streamer: StreamerSession, tap: impl FnMut(TimeUs, Link, &[u8])) -> Flown {
    fly_by(autopilot(), simulator, streamer, tap)
}

/// Flies the whole mission by an autopilot; every frame goes by `tap`.
pub fn fly_by(
    autopilot: AutopilotSession,
    simulator: HilSession,
    streamer: StreamerSession,
    mut tap: impl FnMut(TimeUs, Link, &[u8]),
) -> Flown {
    let mut wire = Lockstep::new(simulator, autopilot, streamer);
    wire.run(&mut tap).unwrap();
    assert_eq!(wire.faults().dropped(), 0);
    let events = std::iter::from_fn(|| wire.streamer.poll_event()).collect();
    let record = wire.simulator.run().record().clone();
    Flown { log: wire.simulator.into_run().into_log(), events, record }
}
