//! What the vehicle shows and says of itself: heartbeat, estimator, checks, version, texts.

use std::collections::VecDeque;
use std::fmt;

use mavlink::MessageData as _;
use mavlink::dialects::common::*;
use nalgebra::Vector3;

use crate::autopilot::FlightMode;
use crate::control::px4::Version;
use crate::control::px4::versions::{ChecksReport, Number};
use crate::link::frame::Frame;
use crate::link::px4_events::{EVENT, Event, HealthReport};
use crate::time::TimeUs;

/// How many of the vehicle's texts are remembered.
const TEXTS: usize = 8;
/// Bits of ESTIMATOR_STATUS.flags that velocity setpoints need.
const NEEDED: [(u16, &str); 3] = [(1, "attitude"), (2, "horizontal velocity"), (4, "vertical velocity")];
const PREARM_CHECK: u32 = MavSysStatusSensor::MAV_SYS_STATUS_PREARM_CHECK.bits();
/// `FIRMWARE_VERSION_TYPE_OFFICIAL`: a version, and nothing on the way to one.
const OFFICIAL: u8 = 255;

/// The vehicle by its latest messages.
#[derive(Clone, Debug, Default)]
pub(super) struct VehicleView {
    pub heartbeat_heard: bool,
    /// Time of the latest heartbeat.
    pub shown_at: TimeUs,
    pub armed: bool,
    /// Since when it has been heard to be armed [us]; of no meaning while it is not.
    pub armed_since: TimeUs,
    pub offboard: bool,
    /// In a mode that controls altitude or position, where PX4's tilt limit moves.
    pub controls: bool,
    /// Flags of ESTIMATOR_STATUS.
    pub estimator: Option<u16>,
    /// `MAV_LANDED_STATE` of EXTENDED_SYS_STATE.
    pub landed_state: Option<u8>,
    /// Sensors that are present, enabled and healthy, by SYS_STATUS.
    pub sensors: Option<[u32; 3]>,
    /// Velocity, NED [m/s], by LOCAL_POSITION_NED, and when it had it.
    pub velocity_ned: Option<(TimeUs, Vector3<f64>)>,
    /// Latest events, by EVENT.
    pub health: HealthReport,
    pub version: Option<AutopilotVersion>,
    /// Whether it is samara's own autopilot.
    pub is_samara: bool,
    texts: VecDeque<(TimeUs, String)>,
}

impl VehicleView {
    /// Takes a message about the vehicle's condition; any other is left alone. It is read by its bytes: flags
    /// that the crate does not know would hide those it knows.
    pub(super) fn take_status(&mut self, frame: &Frame) {
        let p = frame.payload();
        match frame.message_id {
            SYS_STATUS_DATA::ID => self.sensors = Some([p.u32(0), p.u32(4), p.u32(8)]),
            AUTOPILOT_VERSION_DATA::ID => {
                self.version = Some(AutopilotVersion { software: p.u32(16), git: p.u32(40) });
                let build = [p.u32(36).to_le_bytes(), p.u32(40).to_le_bytes()].concat();
                self.is_samara = build == AutopilotVersion::SAMARAS_BUILD;
            }
            EVENT => self.health.take(Event::of(&p)),
            ESTIMATOR_STATUS_DATA::ID => self.estimator = Some(p.u16(40)),
            EXTENDED_SYS_STATE_DATA::ID => self.landed_state = Some(p.u8(1)),
            _ => {}
        }
    }

    /// Takes a heartbeat; what the vehicle is no longer.
    pub(super) fn take_heartbeat(&mut self, now: TimeUs, m: &HEARTBEAT_DATA) -> Vec<&'static str> {
        let (was_armed, was_offboard) = (self.armed, self.offboard);
        let [.., main, _] = m.custom_mode.to_le_bytes();
        self.heartbeat_heard = true;
        self.shown_at = now;
        self.note_armed(now, m.base_mode.contains(MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED));
        self.offboard = FlightMode::from_custom_mode(m.custom_mode) == Some(FlightMode::Offboard);
        self.controls =
            (FlightMode::Altctl.main_number()..=FlightMode::AutoLoiter.main_number()).contains(&main);
        let changes = [("armed", was_armed, self.armed), ("in OFFBOARD", was_offboard, self.offboard)];
        changes.into_iter().filter(|(_, was, is)| *was && !is).map(|(what, ..)| what).collect()
    }

    /// It has been met at `now`: a HEARTBEAT has no time of its own, and this may be the first that is known.
    pub(super) fn note_met(&mut self, now: TimeUs) {
        self.armed_since = now;
    }

    /// It has acknowledged OFFBOARD; what it told of its sensors was for another mode.
    pub(super) fn note_offboard(&mut self) {
        (self.offboard, self.sensors) = (true, None);
    }

    /// It is armed, or is not, by what has come at `now`.
    pub(super) fn note_armed(&mut self, now: TimeUs, armed: bool) {
        if armed && !self.armed {
            self.armed_since = now;
        }
        self.armed = armed;
    }

    /// Whether it is armed by what was heard last, and had been at a time [us]: what happened then may become
    /// known only after an arming that followed it.
    pub(super) fn was_armed_at(&self, time: TimeUs) -> bool {
        self.armed && self.armed_since <= time
    }

    /// Whether it was last heard, or has acknowledged, to be armed in OFFBOARD.
    pub(super) fn flies_offboard(&self) -> bool {
        self.armed && self.offboard
    }

    /// Remembers a text; the oldest makes room.
    pub(super) fn remember(&mut self, at: TimeUs, text: String) {
        self.texts.push_back((at, text));
        if self.texts.len() > TEXTS {
            self.texts.pop_front();
        }
    }

    /// The texts since `at`, oldest first.
    pub(super) fn said_since(&self, at: TimeUs) -> Vec<String> {
        self.texts.iter().filter(|(t, _)| *t >= at).map(|(_, text)| text.clone()).collect()
    }

    /// Whether the checks before arming pass, as a version of PX4 tells of them; `None` while it does not.
    pub(super) fn checks_pass(&self, report: ChecksReport) -> Option<bool> {
        let [present, enabled, healthy] = self.sensors?;
        let told = report == ChecksReport::HealthOnly || present & enabled & PREARM_CHECK != 0;
        told.then_some(healthy & PREARM_CHECK != 0)
    }

    /// What the estimator says that it has not got; empty while it says nothing.
    pub(super) fn lacking(&self) -> Vec<&'static str> {
        let flags = self.estimator.unwrap_or(u16::MAX);
        NEEDED.iter().filter(|(bit, _)| flags & bit == 0).map(|(_, name)| *name).collect()
    }
}

/// The vehicle's software, by AUTOPILOT_VERSION.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AutopilotVersion {
    /// `flight_sw_version`: major, minor, patch, kind of release, a byte each.
    pub software: u32,
    /// The last four bytes of `flight_custom_version`: the first eight digits of PX4's git hash.
    pub git: u32,
}

impl AutopilotVersion {
    /// The version of PX4 that it is, if it is one and not on the way to one.
    pub fn known(self) -> Option<&'static Version> {
        let [.., kind] = self.software.to_be_bytes();
        (kind == OFFICIAL).then(|| Version::of(self.number()))
    }

    /// First two numbers of the version.
    pub fn number(self) -> Number {
        let [major, minor, ..] = self.software.to_be_bytes();
        Number { major, minor }
    }

    /// `flight_custom_version` of samara's own autopilot, where PX4 has its git hash.
    pub const SAMARAS_BUILD: [u8; 8] = *b"samara\0\0";
}

/// As `git describe` would say it: `v1.12.0 2c8a3b1f`.
impl fmt::Display for AutopilotVersion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [major, minor, patch, kind] = self.software.to_be_bytes();
        // FIRMWARE_VERSION_TYPE.
        let kind = match kind {
            OFFICIAL => "",
            192..OFFICIAL => "-rc",
            128..192 => "-beta",
            64..128 => "-alpha",
            _ => "-dev",
        };
        write!(f, "v{major}.{minor}.{patch}{kind} {:08x}", self.git)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// PX4's `px4_firmware_version()` for the tags v1.12.0 and v1.14.0-beta1.
    #[test]
    fn versions_print_as_tags_do() {
        let printed = |software, git| AutopilotVersion { software, git }.to_string();
        assert_eq!(printed(0x010C_00FF, 0x0A1B_2C3D), "v1.12.0 0a1b2c3d");
        assert_eq!(printed(0x010E_0080, 0), "v1.14.0-beta 00000000");
        assert_eq!(printed(0x010D_0300, 1), "v1.13.3-dev 00000001");
    }
}
