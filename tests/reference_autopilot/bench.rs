//! An autopilot session with a simulator, a ground station and a companion on its links, all in one hand.

use std::path::Path;
use std::sync::{Arc, LazyLock};

use mavlink::dialects::common::*;
use nalgebra::Vector3;
use samara::autopilot::estimator::EstimatorSettings;
use samara::autopilot::parameters::Parameters;
use samara::config::load_vehicle;
use samara::control::{Airframe, Cascade, ControlLimits, Gains};
use samara::link::{
    AutopilotSession, AutopilotSetup, CommandAck, Decoder, Encoder, Frame, Link, Session as _,
};
use samara::model::environment::GeoPoint;
use samara::model::{Environment, Vehicle};
use samara::params::Subject;

use super::parameters::set;
use crate::command_long::command_long;

pub const STEP_US: u64 = 4_000;
/// The vehicle's system id; not 1, so that a session that takes every system for its own fails.
pub const VEHICLE: u8 = 7;
/// System and component of the peers.
pub const GROUND: (u8, u8) = (255, 190);
pub const COMPANION: (u8, u8) = (245, 191);

pub static TITAN: LazyLock<Arc<Vehicle>> = LazyLock::new(|| {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("params/vehicles/titan.json");
    Arc::new(load_vehicle(&path).unwrap().vehicle)
});

pub fn site() -> Environment {
    let anchor = GeoPoint { latitude_deg: 12.5, longitude_deg: -34.25, altitude_m: 1500.0 };
    Environment::new(1.35, 5.4, Vector3::zeros(), anchor).unwrap()
}

/// The gains that the drop flies with by default.
fn gains() -> Gains {
    Gains::longitudinal([2.6706, 0.6256, 0.6468, 3.5727, 0.6910, 0.8169, 0.00124])
}

pub fn cascade() -> Cascade {
    Cascade::new(Airframe::new(&TITAN, &site()).unwrap(), gains(), ControlLimits::default())
}

fn parameters() -> Parameters {
    let limits = ControlLimits::default();
    let subject = Subject {
        vehicle: &TITAN,
        environment: &site(),
        gains: &gains(),
        limits: &limits,
        speed_m_s: 5.0,
        tilt_from: None,
        pack: None,
    };
    Parameters::of(&subject, VEHICLE).unwrap()
}

/// A frame that the session sent, and by which link.
pub type Sent = (Link, Frame);

pub struct Bench {
    pub session: AutopilotSession,
    pub now: u64,
    /// What the simulator says of the vehicle.
    pub state: ODOMETRY_DATA,
    peers: [(Link, Encoder); 3],
}

impl Bench {
    /// Before the first HIL_SENSOR, on the truth.
    pub fn new() -> Self {
        Self::on(None)
    }

    /// Before the first HIL_SENSOR, on an estimator or the truth.
    pub fn on(estimator: Option<EstimatorSettings>) -> Self {
        let session = AutopilotSession::new(AutopilotSetup {
            system_id: VEHICLE,
            control: cascade().settings().clone(),
            controller: None,
            environment: site(),
            estimator,
            rotors: 4,
            epoch_unix_us: 1_600_000_000_000_000,
            parameters: parameters(),
            keeps_parameters: true,
        });
        let state = ODOMETRY_DATA {
            q: [1.0, 0.0, 0.0, 0.0],
            frame_id: MavFrame::MAV_FRAME_LOCAL_NED,
            child_frame_id: MavFrame::MAV_FRAME_BODY_FRD,
            ..Default::default()
        };
        let peers = [
            (Link::Simulator, Encoder::new(VEHICLE, 200)),
            (Link::GroundStation, Encoder::new(GROUND.0, GROUND.1)),
            (Link::Api, Encoder::new(COMPANION.0, COMPANION.1)),
        ];
        Self { session, now: 0, state, peers }
    }

    /// With a state and time running.
    pub fn running() -> Self {
        let mut bench = Self::new();
        bench.step();
        // SYS_FAILURE_EN, so that every command reaches who obeys it.
        bench.send(Link::Api, &set("SYS_FAILURE_EN", f32::from_bits(1), MavParamType::MAV_PARAM_TYPE_INT32));
        bench.drain();
        bench
    }

    /// Armed in OFFBOARD under "level, no thrust".
    pub fn engaged() -> Self {
        let mut bench = Self::running();
        bench.send(Link::Api, &level_no_thrust());
        let offboard = command(MavCmd::MAV_CMD_DO_SET_MODE, &[1.0, 6.0]);
        let arm = command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, &[1.0]);
        for wanted in [offboard, arm] {
            assert_eq!(acks(&bench.send(Link::Api, &wanted))[0].result, 0);
        }
        bench
    }

    pub fn drain(&mut self) -> Vec<Sent> {
        let mut sent = Vec::new();
        while let Some(transmit) = self.session.poll_output() {
            sent.push((transmit.link, decode(&transmit.bytes)));
        }
        sent
    }

    /// A frame given by its bytes; the answers.
    pub fn send_bytes(&mut self, link: Link, bytes: &[u8]) -> Vec<Sent> {
        let mut frames = Vec::new();
        Decoder::new().datagram(bytes, |frame| frames.push(frame));
        for frame in &frames {
            self.session.handle_input(link, frame);
        }
        self.drain()
    }

    pub fn encoder(&mut self, link: Link) -> &mut Encoder {
        &mut self.peers.iter_mut().find(|(l, _)| *l == link).unwrap().1
    }

    /// A message of the link's peer; the answers.
    pub fn send(&mut self, link: Link, message: &MavMessage) -> Vec<Sent> {
        let bytes = self.encoder(link).encode(message);
        self.send_bytes(link, &bytes)
    }

    /// One step of the simulator: ODOMETRY, then HIL_SENSOR.
    pub fn step(&mut self) -> Vec<Sent> {
        self.now += STEP_US;
        self.state.time_usec = self.now;
        let odometry = MavMessage::ODOMETRY(self.state.clone());
        let mut sent = self.wait();
        sent.extend(self.send(Link::Simulator, &odometry));
        sent.extend(self.sensor());
        sent
    }

    /// Time alone.
    pub fn wait(&mut self) -> Vec<Sent> {
        self.session.handle_time(self.now);
        self.drain()
    }

    /// A HIL_SENSOR alone.
    pub fn sensor(&mut self) -> Vec<Sent> {
        let sensor = HIL_SENSOR_DATA { time_usec: self.now, zacc: -1.35, ..Default::default() };
        self.send(Link::Simulator, &MavMessage::HIL_SENSOR(sensor))
    }

    pub fn run(&mut self, seconds: f64) -> Vec<Sent> {
        (0..(seconds * 250.0).round() as usize).flat_map(|_| self.step()).collect()
    }
}

pub fn decode(bytes: &[u8]) -> Frame {
    let mut frames = Vec::new();
    Decoder::new().datagram(bytes, |frame| frames.push(frame));
    assert_eq!(frames.len(), 1, "one sound frame per transmission");
    frames.remove(0)
}

/// A COMMAND_LONG to the vehicle; parameters left out are NaN, as ground stations send them.
pub fn command(command: MavCmd, params: &[f32]) -> MavMessage {
    command_long(VEHICLE, command, params)
}

pub fn level_no_thrust() -> MavMessage {
    MavMessage::SET_ATTITUDE_TARGET(SET_ATTITUDE_TARGET_DATA {
        q: [1.0, 0.0, 0.0, 0.0],
        type_mask: AttitudeTargetTypemask::from_bits_retain(7),
        target_system: VEHICLE,
        target_component: 1,
        ..Default::default()
    })
}

pub fn velocity(v: [f32; 3], type_mask: u16) -> SET_POSITION_TARGET_LOCAL_NED_DATA {
    SET_POSITION_TARGET_LOCAL_NED_DATA {
        vx: v[0],
        vy: v[1],
        vz: v[2],
        type_mask: PositionTargetTypemask::from_bits_retain(type_mask),
        target_system: VEHICLE,
        target_component: 1,
        coordinate_frame: MavFrame::MAV_FRAME_LOCAL_NED,
        ..Default::default()
    }
}

pub fn acks(sent: &[Sent]) -> Vec<CommandAck> {
    sent.iter().filter_map(|(_, frame)| frame.command_ack()).collect()
}

/// STATUSTEXT on one link.
pub fn texts(sent: &[Sent], link: Link) -> Vec<String> {
    sent.iter()
        .filter(|(l, _)| *l == link)
        .filter_map(|(_, frame)| match frame.known() {
            Some(MavMessage::STATUSTEXT(m)) => Some(m.text.to_str().unwrap().to_owned()),
            _ => None,
        })
        .collect()
}

/// The message with this number on a link, the last of them.
pub fn last(sent: &[Sent], link: Link, message_id: u32) -> Option<MavMessage> {
    sent.iter()
        .rfind(|(l, frame)| *l == link && frame.message_id == message_id)
        .and_then(|(_, frame)| frame.known().cloned())
}

pub fn actuators(sent: &[Sent]) -> HIL_ACTUATOR_CONTROLS_DATA {
    match last(sent, Link::Simulator, 93) {
        Some(MavMessage::HIL_ACTUATOR_CONTROLS(m)) => m,
        other => panic!("no HIL_ACTUATOR_CONTROLS but {other:?}"),
    }
}
