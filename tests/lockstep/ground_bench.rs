//! The x500 with the simulator and the autopilot on the wire in memory, and a ground station in one's hand.

use std::path::Path;
use std::sync::LazyLock;

use mavlink::dialects::common::*;
use nalgebra::Vector3;
use samara::autopilot::estimator::EstimatorSettings;
use samara::autopilot::parameters::Parameters;
use samara::config::{Mission, load_mission};
use samara::control::{Airframe, ControlLimits, ControlSettings, Gains};
use samara::link::{
    AutopilotSession, AutopilotSetup, Decoder, Encoder, HilConfig, HilSession, Link, Session as _, Timed,
};
use samara::model::rigid_body::BodyState;
use samara::params::{Subject, Value};
use samara::sim::{
    Battery, DropEvent, DropRunConfig, DropSimulation, ElectricBattery, Ground, SensorSettings,
};

use crate::command_long::command_long;

pub static MISSION: LazyLock<Mission> = LazyLock::new(|| {
    load_mission(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/calm_x500.json")).unwrap()
});

/// Gains for a vehicle of 2 kg that turns quickly.
pub const GAINS: Gains = Gains {
    k_pq: 18.0,
    k_iq: 10.0,
    k_ptheta: 6.0,
    k_pvz: 4.0,
    k_ivz: 1.0,
    k_pvx: 2.0,
    k_ivx: 0.3,
    k_ppsi: 2.0,
    k_pr: 4.0,
};

/// The ground, below the local origin.
pub const GROUND: Ground = Ground { down_m: 120.0 };

pub struct Wire {
    pub simulator: HilSession,
    pub autopilot: AutopilotSession,
    station: Encoder,
    /// Everything said on the ground station's link.
    pub texts: Vec<String>,
    /// HEARTBEAT, EXTENDED_SYS_STATE and SYS_STATUS of the vehicle, the latest.
    pub heartbeat: HEARTBEAT_DATA,
    pub landed: MavLandedState,
    pub sys_status: SYS_STATUS_DATA,
    /// Landed states in the order of their coming.
    pub landed_states: Vec<MavLandedState>,
    acks: Vec<u8>,
    pub station_beats: bool,
    next_beat: u64,
}

fn wire(sim: DropSimulation, battery: Option<Battery>) -> Wire {
    wire_on(sim, battery, (MISSION.sensors, 1), None)
}

/// On the truth, or on the estimator with these sensors, whose errors are drawn by a seed.
fn wire_on(
    sim: DropSimulation,
    battery: Option<Battery>,
    (sensors, seed): (SensorSettings, u64),
    estimator: Option<EstimatorSettings>,
) -> Wire {
    let m = &*MISSION;
    let config = HilConfig {
        run: DropRunConfig { duration_us: 600_000_000, battery, ..DropRunConfig::default() },
        sensors,
        seed,
        allow_faults: true,
        ..HilConfig::default()
    };
    let mut simulator = HilSession::new(sim, config);
    simulator.peer_connected();
    let subject = Subject {
        vehicle: &m.vehicle,
        environment: &m.site.environment,
        gains: &GAINS,
        limits: &ControlLimits::default(),
        speed_m_s: 12.0,
        tilt_from: None,
        pack: None,
    };
    let airframe = Airframe::new(&m.vehicle, &m.site.environment).unwrap();
    let autopilot = AutopilotSession::new(AutopilotSetup {
        system_id: 1,
        control: ControlSettings { airframe, gains: GAINS, limits: ControlLimits::default() },
        controller: None,
        environment: m.site.environment.clone(),
        estimator,
        rotors: 4,
        epoch_unix_us: m.epoch_unix_us,
        parameters: Parameters::of(&subject, 1).unwrap(),
        keeps_parameters: false,
    });
    let mut wire = Wire {
        simulator,
        autopilot,
        station: Encoder::new(255, 190),
        texts: Vec::new(),
        heartbeat: HEARTBEAT_DATA::default(),
        landed: MavLandedState::MAV_LANDED_STATE_UNDEFINED,
        sys_status: SYS_STATUS_DATA::default(),
        landed_states: Vec::new(),
        acks: Vec::new(),
        station_beats: true,
        next_beat: 0,
    };
    wire.fly(1.0);
    wire
}

impl Wire {
    /// Standing.
    pub fn on_ground(battery: Option<Battery>) -> Self {
        let m = &*MISSION;
        wire(DropSimulation::standing(m.vehicle.clone(), m.site.environment.clone(), GROUND), battery)
    }

    /// Standing, its motors on a battery with a voltage.
    pub fn on_ground_on(battery: ElectricBattery) -> Self {
        let m = &*MISSION;
        let sim = DropSimulation::standing(m.vehicle.clone(), m.site.environment.clone(), GROUND);
        wire(sim.on_battery(Some(battery)), None)
    }

    /// Standing, on the estimator.
    pub fn on_ground_on_estimator() -> Self {
        Self::sensing(MISSION.sensors, 1)
    }

    /// Standing, on the estimator with these sensors, whose errors are drawn by a seed.
    pub fn sensing(sensors: SensorSettings, seed: u64) -> Self {
        let m = &*MISSION;
        let site = &m.site.environment;
        let estimator = EstimatorSettings {
            gps_delay_us: sensors.satellite.delay_us,
            ..EstimatorSettings::at_site(site.gravity_m_s2, sensors.magnetometer.field_at(site))
        };
        let sim = DropSimulation::standing(m.vehicle.clone(), site.clone(), GROUND);
        wire_on(sim, None, (sensors, seed), Some(estimator))
    }

    /// Under its canopy, `height_m` above the ground and sinking.
    pub fn hanging(height_m: f64) -> Self {
        let m = &*MISSION;
        let mut parachute = m.release.parachute;
        parachute.delay_s = 0.2;
        let ground = Ground { down_m: height_m };
        let sim = DropSimulation::new(
            m.vehicle.clone(),
            m.site.environment.clone(),
            parachute,
            0.0,
            m.release.start,
        );
        wire(sim.above(ground), None)
    }

    /// Standing, armed, taken off to `height_m` and holding there.
    pub fn hovering(height_m: f32, battery: Option<Battery>) -> Self {
        Self::on_ground(battery).taken_off(height_m)
    }

    /// Standing until the estimator is aligned, then as [`Self::hovering`].
    pub fn hovering_on_estimator(height_m: f32) -> Self {
        let mut wire = Self::on_ground_on_estimator();
        wire.fly(10.0);
        wire.taken_off(height_m)
    }

    /// Armed, taken off to `height_m` and holding there.
    pub fn taken_off(mut self, height_m: f32) -> Self {
        self.set_real("MIS_TAKEOFF_ALT", height_m);
        assert_eq!(self.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, &[1.0]), 0);
        assert_eq!(self.command(MavCmd::MAV_CMD_NAV_TAKEOFF, &[]), 0);
        self.fly_until(60.0, |wire| wire.mode() == [4, 3]);
        self.fly(3.0);
        self
    }

    pub fn body(&self) -> &BodyState {
        &self.simulator.run().simulation().state().body
    }

    /// Height above the ground.
    pub fn height_m(&self) -> f64 {
        self.simulator.run().simulation().ground().unwrap().down_m - self.body().p_ned.z
    }

    /// Main and sub mode.
    pub fn mode(&self) -> [u8; 2] {
        let [_, _, main, sub] = self.autopilot.autopilot().mode().custom_mode().to_le_bytes();
        [main, sub]
    }

    pub fn is_armed(&self) -> bool {
        self.autopilot.autopilot().is_armed()
    }

    pub fn now_s(&self) -> f64 {
        self.simulator.run().simulation().time_s()
    }

    pub fn fly(&mut self, seconds: f64) {
        for _ in 0..(seconds * 250.0).round() as usize {
            self.step();
        }
    }

    /// Flies until something is so; panics when it is not within `limit_s`.
    pub fn fly_until(&mut self, limit_s: f64, done: impl Fn(&Self) -> bool) {
        let end = self.now_s() + limit_s;
        while !done(self) {
            let (p, v) = (self.body().p_ned, self.body().v_ned);
            assert!(self.now_s() < end, "not so after {limit_s} s: {p} {v} {:?}", self.texts);
            self.step();
        }
    }

    /// Speed of descent at which the vehicle first came to the ground [m/s].
    pub fn touch_speed_m_s(&self) -> f64 {
        let speed = |e: &Timed<DropEvent>| match e.event {
            DropEvent::TouchedGround { speed_m_s } => Some(speed_m_s),
            _ => None,
        };
        self.simulator.run().record().events.iter().find_map(speed).unwrap()
    }

    pub fn step(&mut self) {
        if self.station_beats && self.simulator.now() >= self.next_beat {
            self.next_beat += 1_000_000;
            let heartbeat = HEARTBEAT_DATA { mavtype: MavType::MAV_TYPE_GCS, ..HEARTBEAT_DATA::default() };
            self.send(&MavMessage::HEARTBEAT(heartbeat));
        }
        let Some(now) = self.simulator.next_wake() else { panic!("{:?}", self.simulator.pace()) };
        self.simulator.handle_time(now);
        self.pump();
    }

    fn pump(&mut self) {
        for _ in 0..8 {
            while let Some(sent) = self.simulator.poll_output() {
                if sent.link == Link::Simulator {
                    Decoder::new()
                        .datagram(&sent.bytes, |f| self.autopilot.handle_input(Link::Simulator, &f));
                }
            }
            while let Some(sent) = self.autopilot.poll_output() {
                match sent.link {
                    Link::Simulator => {
                        Decoder::new()
                            .datagram(&sent.bytes, |f| self.simulator.handle_input(Link::Simulator, &f));
                    }
                    Link::GroundStation => Decoder::new().datagram(&sent.bytes, |f| {
                        self.acks.extend(f.command_ack().map(|ack| ack.result));
                        if let Some(message) = f.known() {
                            Self::hear(
                                message,
                                &mut self.texts,
                                &mut self.heartbeat,
                                &mut self.landed_states,
                                &mut self.sys_status,
                            );
                        }
                    }),
                    _ => {}
                }
            }
        }
        self.landed = self.landed_states.last().copied().unwrap_or(self.landed);
    }

    fn hear(
        message: &MavMessage,
        texts: &mut Vec<String>,
        heartbeat: &mut HEARTBEAT_DATA,
        landed_states: &mut Vec<MavLandedState>,
        sys_status: &mut SYS_STATUS_DATA,
    ) {
        match message {
            MavMessage::STATUSTEXT(m) => texts.push(m.text.to_str().unwrap().to_owned()),
            MavMessage::HEARTBEAT(m) => *heartbeat = m.clone(),
            MavMessage::SYS_STATUS(m) => *sys_status = m.clone(),
            MavMessage::EXTENDED_SYS_STATE(m) if landed_states.last() != Some(&m.landed_state) => {
                landed_states.push(m.landed_state);
            }
            _ => {}
        }
    }

    /// From the ground station.
    pub fn send(&mut self, message: &MavMessage) {
        let bytes = self.station.encode(message);
        Decoder::new().datagram(&bytes, |f| self.autopilot.handle_input(Link::GroundStation, &f));
        self.pump();
    }

    /// A COMMAND_LONG; the result. Parameters left out are NaN.
    pub fn command(&mut self, command: MavCmd, params: &[f32]) -> u8 {
        self.acks.clear();
        self.send(&command_long(1, command, params));
        assert_eq!(self.acks.len(), 1, "{:?}", self.acks);
        self.acks[0]
    }

    pub fn set_real(&mut self, name: &str, value: f32) {
        self.set(name, Value::Real(value));
    }

    pub fn set_int(&mut self, name: &str, value: i32) {
        self.set(name, Value::Int(value));
    }

    fn set(&mut self, name: &str, value: Value) {
        let (param_value, param_type) = match value {
            Value::Real(x) => (x, MavParamType::MAV_PARAM_TYPE_REAL32),
            Value::Int(x) => (f32::from_bits(x as u32), MavParamType::MAV_PARAM_TYPE_INT32),
        };
        self.send(&MavMessage::PARAM_SET(PARAM_SET_DATA {
            param_value,
            target_system: 1,
            target_component: 1,
            param_id: name.into(),
            param_type,
        }));
        assert_eq!(self.autopilot.parameters().get(name), Some(value), "{:?}", self.texts);
    }

    /// MAV_CMD_INJECT_FAILURE to the autopilot, of all instances of a unit; accepted.
    pub fn inject(&mut self, unit: FailureUnit, kind: FailureType) {
        self.set_int("SYS_FAILURE_EN", 1);
        assert_eq!(
            self.command(MavCmd::MAV_CMD_INJECT_FAILURE, &[unit as u32 as f32, kind as u32 as f32, 0.0]),
            0
        );
    }

    /// A velocity or position setpoint.
    pub fn setpoint(&mut self, p: [f32; 3], v: [f32; 3], type_mask: u16) {
        self.send(&MavMessage::SET_POSITION_TARGET_LOCAL_NED(SET_POSITION_TARGET_LOCAL_NED_DATA {
            x: p[0],
            y: p[1],
            z: p[2],
            vx: v[0],
            vy: v[1],
            vz: v[2],
            type_mask: PositionTargetTypemask::from_bits_retain(type_mask),
            target_system: 1,
            target_component: 1,
            coordinate_frame: MavFrame::MAV_FRAME_LOCAL_NED,
            ..Default::default()
        }));
    }

    pub fn said(&self, text: &str) -> bool {
        self.texts.concat().contains(text)
    }

    pub fn level_distance_m(&self, to: Vector3<f64>) -> f64 {
        (self.body().p_ned - to).xy().norm()
    }
}
