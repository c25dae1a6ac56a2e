//! What the frames of a flight tell whoever looks on: the vehicle's mode and motion, and what it was sent
//! last.
//!
//! A party of the link need not know all this, and who looks on need not be a party: every frame that has
//! come or gone is shown to a [`Seen`] once, in the order in which that happened. Units are the site's, also
//! where the wire is scaled for a PX4.

use mavlink::MessageData as _;
use mavlink::dialects::common::*;
use nalgebra::Vector3;

use super::autopilot::AUTOPILOT_COMPONENT;
use super::decoder::Decoder;
use super::frame::{Frame, Header};
use super::froude::{Froude, T_RELEASE};
use super::parachute::PARACHUTE_COMPONENT;
use super::statustext::TextReader;
use crate::autopilot::modes::FlightMode;
use crate::frames::quaternion_from_euler;
use crate::model::rigid_body::BodyState;
use crate::time::{TimeUs, seconds};

/// What comes more often than this is read as often: nobody reads numbers faster.
const READ_EVERY_US: TimeUs = 100_000;

/// What is told of a vehicle on its link; each is told anew by the next frame of its kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Told {
    Vehicle,
    Setpoint,
    Throttles,
    Command,
    Answer,
    Text,
}

/// The names of what is told, in the order of [`Told`].
const NAMES: [&str; 6] =
    ["vehicle", "last setpoint", "last throttles", "last command", "last answer", "last text"];

impl Told {
    /// What a message tells; `None`: nothing of this kind.
    fn by(message_id: u32) -> Option<Self> {
        match message_id {
            HEARTBEAT_DATA::ID => Some(Self::Vehicle),
            SET_POSITION_TARGET_LOCAL_NED_DATA::ID | SET_ATTITUDE_TARGET_DATA::ID => Some(Self::Setpoint),
            HIL_ACTUATOR_CONTROLS_DATA::ID => Some(Self::Throttles),
            COMMAND_LONG_DATA::ID | COMMAND_INT_DATA::ID => Some(Self::Command),
            COMMAND_ACK_DATA::ID => Some(Self::Answer),
            STATUSTEXT_DATA::ID => Some(Self::Text),
            _ => None,
        }
    }

    /// Whether it comes so often that not every one is read.
    fn streams(self) -> bool {
        matches!(self, Self::Setpoint | Self::Throttles)
    }
}

/// What the frames of a flight have told so far.
#[derive(Debug)]
pub struct Seen {
    system_id: u8,
    rotors: usize,
    froude: Option<Froude>,
    decoder: Decoder,
    texts: TextReader,
    told: [Option<(TimeUs, String)>; NAMES.len()],
    /// Whether a HEARTBEAT has named the vehicle's mode. On the link of a simulator PX4 sends none that does.
    mode_is_named: bool,
    attitude: Option<ATTITUDE_DATA>,
    body: Option<BodyState>,
    released_at: Option<TimeUs>,
}

impl Seen {
    /// Nothing seen yet of the vehicle of a system with that many rotors; `froude`: the scale of the wire.
    pub fn new(system_id: u8, rotors: usize, froude: Option<Froude>) -> Self {
        Self {
            system_id,
            rotors,
            froude,
            decoder: Decoder::new(),
            texts: TextReader::default(),
            told: Default::default(),
            mode_is_named: false,
            attitude: None,
            body: None,
            released_at: None,
        }
    }

    /// Takes a frame that has come or gone at a simulated time.
    pub fn take(&mut self, now: TimeUs, bytes: &[u8]) {
        let Some(header) = Header::read(bytes) else { return };
        let told = Told::by(header.message_id);
        let is_motion = matches!(
            header.message_id,
            ATTITUDE_DATA::ID | LOCAL_POSITION_NED_DATA::ID | NAMED_VALUE_INT_DATA::ID
        );
        let is_due = told.is_some_and(|told| {
            let last = self.told[told as usize].as_ref();
            !told.streams() || last.is_none_or(|(at, _)| now.abs_diff(*at) >= READ_EVERY_US)
        });
        if !is_motion && !is_due {
            return;
        }
        let mut decoder = std::mem::take(&mut self.decoder);
        decoder.datagram(bytes, |frame| match told {
            Some(told) => {
                if let Some(words) = self.words(&frame) {
                    self.told[told as usize] = Some((now, words));
                    self.mode_is_named |= told == Told::Vehicle;
                }
                if let (Some(MavMessage::HIL_ACTUATOR_CONTROLS(m)), false) =
                    (frame.known(), self.mode_is_named)
                {
                    self.told[Told::Vehicle as usize] = Some((now, armed_words(m.mode).to_owned()));
                }
            }
            None => self.take_motion(&frame),
        });
        self.decoder = decoder;
    }

    /// What is known: its name, since when, simulated time [s], and what it is.
    pub fn told(&self) -> impl Iterator<Item = (&'static str, f64, &str)> {
        NAMES.into_iter().zip(&self.told).filter_map(|(name, told)| {
            let (at, words) = told.as_ref()?;
            Some((name, seconds(*at), words.as_str()))
        })
    }

    /// The vehicle's motion by its telemetry, where it is newer than at the last call: position from where
    /// the vehicle has its origin.
    pub fn take_body(&mut self) -> Option<BodyState> {
        self.body.take()
    }

    /// When the vehicle was cut loose, by what the parachute has said.
    pub fn released_at(&self) -> Option<TimeUs> {
        self.released_at
    }

    /// How much faster the clock on the wire is.
    fn k(&self) -> f64 {
        self.froude.map_or(1.0, Froude::k)
    }

    fn is_vehicle(&self, frame: &Frame) -> bool {
        (frame.system_id, frame.component_id) == (self.system_id, AUTOPILOT_COMPONENT)
    }

    /// What a frame tells, in words; `None`: nothing that is ours to tell.
    fn words(&mut self, frame: &Frame) -> Option<String> {
        let to = |(_, component): (u8, u8)| match component {
            PARACHUTE_COMPONENT => " to the parachute",
            _ => "",
        };
        match (frame.known(), frame.command(), frame.command_ack()) {
            (Some(MavMessage::HEARTBEAT(m)), ..) => {
                let mode = match FlightMode::from_custom_mode(m.custom_mode) {
                    Some(mode) => mode.name().to_owned(),
                    None => format!("mode {}", m.custom_mode),
                };
                let failsafe = m.system_status == MavState::MAV_STATE_CRITICAL
                    || m.system_status == MavState::MAV_STATE_EMERGENCY;
                let (armed, failsafe) = (armed_words(m.base_mode), if failsafe { ", failsafe" } else { "" });
                let names_mode = self.is_vehicle(frame) && m.custom_mode != 0;
                names_mode.then(|| format!("{armed}, {mode}{failsafe}"))
            }
            (Some(MavMessage::SET_POSITION_TARGET_LOCAL_NED(m)), ..) => {
                let ignores = |flag| m.type_mask.contains(flag);
                if ignores(PositionTargetTypemask::POSITION_TARGET_TYPEMASK_VX_IGNORE) {
                    return Some("position".to_owned());
                }
                // To what is shown of them: -0.00 is 0.00.
                let shown = |v: f32| (100.0 * f64::from(v) / self.k()).round() / 100.0 + 0.0;
                let [n, e, d] = [m.vx, m.vy, m.vz].map(shown);
                Some(format!("velocity {n:.2} {e:.2} {d:.2} m/s"))
            }
            (Some(MavMessage::SET_ATTITUDE_TARGET(m)), ..) => {
                Some(format!("attitude, thrust {:.0} %", 100.0 * m.thrust))
            }
            (Some(MavMessage::HIL_ACTUATOR_CONTROLS(m)), ..) => {
                let percent = m.controls.iter().take(self.rotors).map(|c| format!("{:.0}", 100.0 * c));
                Some(format!("{} %", percent.collect::<Vec<_>>().join(" ")))
            }
            (Some(MavMessage::STATUSTEXT(m)), ..) => {
                let texts = self.texts.take((frame.system_id, frame.component_id), m);
                texts.last().cloned()
            }
            (Some(MavMessage::COMMAND_LONG(m)), ..) => {
                Some(format!("{}{}", plain(&m.command, "MAV_CMD_"), to(frame.target())))
            }
            (_, Some(command), _) => Some(format!("command {}{}", command.command, to(frame.target()))),
            (Some(MavMessage::COMMAND_ACK(m)), ..) => {
                let (command, result) = (plain(&m.command, "MAV_CMD_"), plain(&m.result, "MAV_RESULT_"));
                Some(format!("{command}: {result}"))
            }
            (_, _, Some(ack)) => Some(format!("command {}: result {}", ack.command, ack.result)),
            _ => None,
        }
    }

    fn take_motion(&mut self, frame: &Frame) {
        if let Some(MavMessage::NAMED_VALUE_INT(m)) = frame.known() {
            let released_ms = u64::try_from(m.value).ok().filter(|_| m.name.to_str() == Ok(T_RELEASE));
            let on_wire_us = released_ms.map(|ms| ms * 1000);
            let at_us = on_wire_us.map(|us| self.froude.map_or(us, |froude| froude.site_us(us)));
            self.released_at = at_us.or(self.released_at);
            return;
        }
        if !self.is_vehicle(frame) {
            return;
        }
        match (frame.known(), &self.attitude) {
            (Some(MavMessage::ATTITUDE(m)), _) => self.attitude = Some(m.clone()),
            (Some(MavMessage::LOCAL_POSITION_NED(m)), Some(a)) => {
                let vector = |xyz: [f32; 3], scale: f64| Vector3::from(xyz.map(|x| f64::from(x) / scale));
                let [roll, pitch, yaw] = [a.roll, a.pitch, a.yaw].map(f64::from);
                let body = BodyState {
                    p_ned: vector([m.x, m.y, m.z], 1.0),
                    q_ned_from_body: quaternion_from_euler(roll, pitch, yaw),
                    v_ned: vector([m.vx, m.vy, m.vz], self.k()),
                    omega_body: vector([a.rollspeed, a.pitchspeed, a.yawspeed], self.k()),
                };
                let numbers = [body.p_ned, body.v_ned, body.omega_body];
                let is_finite = numbers.iter().all(|v| v.iter().all(|x| x.is_finite()))
                    && body.q_ned_from_body.as_slice().iter().all(|x| x.is_finite());
                self.body = is_finite.then_some(body);
            }
            _ => {}
        }
    }
}

fn armed_words(mode: MavModeFlag) -> &'static str {
    if mode.contains(MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED) { "armed" } else { "disarmed" }
}

/// A value of one of MAVLink's enums, without what all names of that enum begin with.
fn plain(value: &impl std::fmt::Debug, all: &str) -> String {
    let name = format!("{value:?}");
    name.strip_prefix(all).unwrap_or(&name).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::encoder::Encoder;

    const SYSTEM: u8 = 3;

    fn told(seen: &Seen) -> Vec<(&'static str, f64, String)> {
        seen.told().map(|(name, at_s, words)| (name, at_s, words.to_owned())).collect()
    }

    /// What each message says, by MAVLink's definitions; of others' HEARTBEATs nothing, and of what streams
    /// one in a tenth of a second.
    #[test]
    fn closed_form_what_frames_tell() {
        let mut seen = Seen::new(SYSTEM, 4, None);
        let mut vehicle = Encoder::new(SYSTEM, AUTOPILOT_COMPONENT);
        let mut script = Encoder::new(255, 190);
        let heartbeat = HEARTBEAT_DATA {
            base_mode: MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED,
            custom_mode: FlightMode::Offboard.custom_mode(),
            ..HEARTBEAT_DATA::default()
        };
        // PX4's on the link of a simulator: no mode, and armed by the controls alone.
        seen.take(500_000, &vehicle.encode(&MavMessage::HEARTBEAT(HEARTBEAT_DATA::default())));
        let mode = MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED;
        let motors = HIL_ACTUATOR_CONTROLS_DATA { mode, ..Default::default() };
        seen.take(600_000, &vehicle.encode(&MavMessage::HIL_ACTUATOR_CONTROLS(motors)));
        assert_eq!(told(&seen)[0], ("vehicle", 0.6, "armed".to_owned()));
        seen.take(1_000_000, &vehicle.encode(&MavMessage::HEARTBEAT(heartbeat.clone())));
        seen.take(1_500_000, &script.encode(&MavMessage::HEARTBEAT(HEARTBEAT_DATA::default())));
        let setpoint = |vx| {
            let (vy, vz) = (-0.001, -2.5);
            MavMessage::SET_POSITION_TARGET_LOCAL_NED(SET_POSITION_TARGET_LOCAL_NED_DATA {
                vx,
                vy,
                vz,
                type_mask: PositionTargetTypemask::POSITION_TARGET_TYPEMASK_X_IGNORE,
                ..Default::default()
            })
        };
        seen.take(2_000_000, &script.encode(&setpoint(3.0)));
        seen.take(2_050_000, &script.encode(&setpoint(4.0)));
        let mut controls = [0.0; 16];
        controls[..4].copy_from_slice(&[0.5, 0.25, 0.125, 1.0]);
        let motors = HIL_ACTUATOR_CONTROLS_DATA { controls, ..Default::default() };
        seen.take(2_060_000, &vehicle.encode(&MavMessage::HIL_ACTUATOR_CONTROLS(motors)));
        let release = COMMAND_LONG_DATA {
            command: MavCmd::MAV_CMD_DO_GRIPPER,
            target_system: SYSTEM,
            target_component: PARACHUTE_COMPONENT,
            ..COMMAND_LONG_DATA::default()
        };
        seen.take(2_070_000, &script.encode(&MavMessage::COMMAND_LONG(release)));
        let answer = COMMAND_ACK_DATA {
            command: MavCmd::MAV_CMD_DO_GRIPPER,
            result: MavResult::MAV_RESULT_DENIED,
            ..COMMAND_ACK_DATA::default()
        };
        seen.take(2_080_000, &vehicle.encode(&MavMessage::COMMAND_ACK(answer)));
        let expected = [
            ("vehicle", 1.0, "armed, OFFBOARD"),
            ("last setpoint", 2.0, "velocity 3.00 0.00 -2.50 m/s"),
            ("last throttles", 2.06, "50 25 12 100 %"),
            ("last command", 2.07, "DO_GRIPPER to the parachute"),
            ("last answer", 2.08, "DO_GRIPPER: DENIED"),
        ];
        assert_eq!(told(&seen), expected.map(|(name, at_s, words)| (name, at_s, words.to_owned())));
        let text = STATUSTEXT_DATA { text: "odd \x1b]0;name\x07".into(), ..STATUSTEXT_DATA::default() };
        seen.take(2_090_000, &vehicle.encode(&MavMessage::STATUSTEXT(text)));
        assert_eq!(told(&seen)[5].2, "odd \\x1b]0;name\\x07");
        let critical = HEARTBEAT_DATA { system_status: MavState::MAV_STATE_CRITICAL, ..heartbeat };
        seen.take(3_000_000, &vehicle.encode(&MavMessage::HEARTBEAT(critical)));
        assert_eq!(told(&seen)[0].2, "armed, OFFBOARD, failsafe");
        // Bytes that are no frames are nobody's.
        seen.take(4_000_000, &[0xFD, 9, 0, 0, 0, SYSTEM, 1, 0, 0, 0, 1]);
        seen.take(4_000_000, b"");
    }

    /// The motion is that of the messages, in the site's units where the wire is scaled for a PX4; what is
    /// not finite is none.
    #[test]
    fn closed_form_the_motion_that_is_told() {
        let froude = Froude::under(1.352);
        let k = froude.k();
        let mut vehicle = Encoder::new(SYSTEM, AUTOPILOT_COMPONENT);
        let mut parachute = Encoder::new(SYSTEM, PARACHUTE_COMPONENT);
        for (froude, k) in [(None, 1.0), (Some(froude), k)] {
            let mut seen = Seen::new(SYSTEM, 4, froude);
            let place = |x| {
                let (y, z, vx, vy, vz) = (2.0, -3.0, 4.0, 5.0, 6.0);
                LOCAL_POSITION_NED_DATA { x, y, z, vx, vy, vz, ..Default::default() }
            };
            seen.take(1, &vehicle.encode(&MavMessage::LOCAL_POSITION_NED(place(1.0))));
            assert_eq!(seen.take_body(), None, "no attitude yet");
            let yaw = std::f32::consts::FRAC_PI_2;
            let attitude = ATTITUDE_DATA { yaw, pitchspeed: 0.5, ..ATTITUDE_DATA::default() };
            seen.take(2, &vehicle.encode(&MavMessage::ATTITUDE(attitude)));
            seen.take(3, &vehicle.encode(&MavMessage::LOCAL_POSITION_NED(place(1.0))));
            let body = seen.take_body().unwrap();
            assert_eq!(body.p_ned, Vector3::new(1.0, 2.0, -3.0));
            assert_eq!(body.v_ned, Vector3::new(4.0, 5.0, 6.0) / k);
            assert_eq!(body.omega_body, Vector3::new(0.0, 0.5, 0.0) / k);
            let half = 0.5_f64.sqrt();
            let q = body.q_ned_from_body;
            assert!((q[0] - half).abs() < 1e-7 && (q[3] - half).abs() < 1e-7, "{q:?}");
            assert_eq!(seen.take_body(), None, "it was taken");
            seen.take(4, &vehicle.encode(&MavMessage::LOCAL_POSITION_NED(place(f32::NAN))));
            assert_eq!(seen.take_body(), None);
            assert_eq!(seen.released_at(), None);
            let told = NAMED_VALUE_INT_DATA { value: 15_000, name: T_RELEASE.into(), ..Default::default() };
            seen.take(5, &parachute.encode(&MavMessage::NAMED_VALUE_INT(told)));
            assert_eq!(
                seen.released_at().map(|at| (seconds(at) * 1e3).round()),
                Some((15_000.0 * k).round())
            );
        }
    }
}
