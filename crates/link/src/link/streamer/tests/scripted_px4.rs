//! A streamer with a procedure and the PX4 that it waits for, scripted.

use std::collections::BTreeMap;

use mavlink::dialects::common::*;

use super::scripted_vehicle::{Answers, ScriptedVehicle, texts};
use super::*;
use crate::control::px4::Version;
use crate::control::px4::versions::VERSIONS;
use crate::link::wire::param_value;
use crate::params::Value;
use crate::params::px4_required::{RULES, TILT_AIR};
use crate::time::TimeUs;

/// Bits of ESTIMATOR_STATUS.flags.
pub(super) const ALIGNED: u16 = 7;
pub(super) const PREARM_CHECK: u32 = 0x1000_0000;
pub(super) const S: TimeUs = 1_000_000;
/// For a tilt limit of 45 deg: 45 deg/(0.2 rad/s) + 0.25 s.
pub(super) const HELD: &str = "left in HOLD for 4.18 s: PX4's tilt limit comes up there";

/// What the vehicle does when a parameter that it has is written in the type that it has there; in another
/// one it refuses it as a mismatch.
#[derive(Clone, Copy, Debug)]
pub(super) enum Writing {
    /// Takes the value.
    Takes,
    /// Keeps its own, and echoes that.
    Keeps,
    /// Refuses it.
    Refuses(MavParamError),
}

/// A streamer with a procedure and a vehicle with fit parameters. Estimator and checks are reported only as
/// sent here.
pub(super) struct ScriptedPx4 {
    pub(super) script: ScriptedVehicle,
    pub(super) answered: usize,
    /// Flags of ESTIMATOR_STATUS, sent every 0.1 s.
    pub(super) estimator: Option<u16>,
    /// Present, enabled and healthy sensors of SYS_STATUS, sent every 0.1 s.
    pub(super) sensors: Option<[u32; 3]>,
    /// MPC_TILTMAX_LND and MPC_TILTMAX_AIR [deg], if it has them.
    pub(super) tilt_deg: Option<[f32; 2]>,
    /// COM_DISARM_LAND [s].
    pub(super) disarm_after_landing_s: f32,
    /// The version of PX4 whose parameters it has.
    pub(super) px4: &'static Version,
    /// Parameters that it has whatever its version, and how they are written; all others are taken.
    pub(super) on_board: BTreeMap<&'static str, (Value, Writing)>,
    /// Names that it does not have, and says so by PARAM_ERROR.
    pub(super) lacks: Vec<&'static str>,
    /// Names that it says nothing about.
    pub(super) silent: Vec<&'static str>,
}

impl ScriptedPx4 {
    pub(super) fn new(estimator: Option<u16>, sensors: Option<[u32; 3]>, answers: Answers) -> Self {
        Self::with(estimator, sensors, answers, |_| ())
    }

    pub(super) fn with(
        estimator: Option<u16>,
        sensors: Option<[u32; 3]>,
        answers: Answers,
        change: impl FnOnce(&mut StreamerConfig),
    ) -> Self {
        let script = ScriptedVehicle::new(answers, |c| {
            c.procedure = Some(Procedure::default());
            c.hang_s = 60.0;
            change(c);
        });
        Self {
            script,
            answered: 0,
            estimator,
            sensors,
            tilt_deg: Some([45.0; 2]),
            disarm_after_landing_s: -1.0,
            px4: Version::OLDEST,
            on_board: BTreeMap::new(),
            lacks: Vec::new(),
            silent: Vec::new(),
        }
    }

    fn echo(&mut self, name: &str, value: Value) {
        let (param_value, param_type) = param_value(value);
        let value = PARAM_VALUE_DATA { param_id: name.into(), param_value, param_type, ..Default::default() };
        self.script.vehicle_says(&MavMessage::PARAM_VALUE(value));
    }

    pub(super) fn refuse(&mut self, name: &str, error: MavParamError, to: (u8, u8)) {
        let (target_system, target_component) = to;
        let param_id = name.into();
        let data = PARAM_ERROR_DATA { target_system, target_component, param_id, error, param_index: -1 };
        self.script.vehicle_says(&MavMessage::PARAM_ERROR(data));
    }

    /// As `mavlink_parameters.cpp` after v1.17 does it.
    fn write(&mut self, m: &PARAM_SET_DATA) {
        let name = m.param_id.to_str().unwrap();
        let written = match m.param_type {
            MavParamType::MAV_PARAM_TYPE_INT32 => Value::Int(m.param_value.to_bits() as i32),
            _ => Value::Real(m.param_value),
        };
        let Some((value, writing)) = self.on_board.get_mut(name) else { return self.echo(name, written) };
        let mismatch = MavParamError::MAV_PARAM_ERROR_TYPE_MISMATCH;
        let refusal = match writing {
            _ if value.mavlink_type() != written.mavlink_type() => Some(mismatch),
            Writing::Refuses(error) => Some(*error),
            Writing::Keeps => None,
            Writing::Takes => {
                *value = written;
                None
            }
        };
        let value = *value;
        match refusal {
            Some(error) => self.refuse(name, error, (STREAMER_SYSTEM, STREAMER_COMPONENT)),
            None => self.echo(name, value),
        }
    }

    /// Until `state` is reached; the time of that.
    pub(super) fn until(&mut self, state: StreamerState) -> TimeUs {
        while self.script.streamer.state() != state {
            assert!(self.script.now < 100 * S, "never {state:?}: {:#?}", texts(&self.script.events));
            self.step();
        }
        self.script.now
    }

    pub(super) fn run(&mut self, span: TimeUs) {
        let until = self.script.now + span;
        while self.script.now < until {
            self.step();
        }
    }

    pub(super) fn step(&mut self) {
        if self.script.now.is_multiple_of(100_000) {
            self.report();
        }
        self.script.run(self.script.now + 4_000);
        while let Some((_, frame)) = self.script.sent.get(self.answered) {
            self.answered += 1;
            if let Some(MavMessage::PARAM_SET(m)) = frame.known() {
                let m = m.clone();
                self.write(&m);
                continue;
            }
            if let Some(MavMessage::PARAM_REQUEST_READ(m)) = frame.known() {
                let (param_id, name) = (m.param_id, m.param_id.to_str().unwrap());
                if self.silent.contains(&name) {
                    continue;
                }
                if self.lacks.contains(&name) {
                    let name = name.to_owned();
                    let error = MavParamError::MAV_PARAM_ERROR_DOES_NOT_EXIST;
                    self.refuse(&name, error, (STREAMER_SYSTEM, STREAMER_COMPONENT));
                    continue;
                }
                if let Some((value, _)) = self.on_board.get(name) {
                    let (name, value) = (name.to_owned(), *value);
                    self.echo(&name, value);
                    continue;
                }
                let probed = VERSIONS.iter().find(|version| version.known_by == Some(name));
                if probed.is_some_and(|version| version.number > self.px4.number) {
                    let text = format!("[pm] unknown param: {name}");
                    let text = STATUSTEXT_DATA { text: text.as_str().into(), ..Default::default() };
                    self.script.vehicle_says(&MavMessage::STATUSTEXT(text));
                    continue;
                }
                let rule = RULES.iter().find(|rule| rule.name == name);
                let wanted = rule.map(|rule| (rule.wanted)(&Default::default()));
                let (param_value, param_type) = match wanted {
                    _ if name == "COM_DISARM_LAND" => {
                        (self.disarm_after_landing_s, MavParamType::MAV_PARAM_TYPE_REAL32)
                    }
                    None => {
                        let of = usize::from(name == TILT_AIR);
                        let Some(tilt_deg) = self.tilt_deg else { continue };
                        (tilt_deg[of], MavParamType::MAV_PARAM_TYPE_REAL32)
                    }
                    Some(Some(Value::Int(i))) => {
                        (f32::from_bits(i as u32), MavParamType::MAV_PARAM_TYPE_INT32)
                    }
                    Some(Some(Value::Real(x))) => (x, MavParamType::MAV_PARAM_TYPE_REAL32),
                    Some(None) => (1.0, MavParamType::MAV_PARAM_TYPE_REAL32),
                };
                let value = PARAM_VALUE_DATA { param_id, param_value, param_type, ..Default::default() };
                self.script.vehicle_says(&MavMessage::PARAM_VALUE(value));
            }
        }
    }

    fn report(&mut self) {
        if let Some(flags) = self.estimator {
            let flags = EstimatorStatusFlags::from_bits_retain(flags);
            let status = ESTIMATOR_STATUS_DATA { flags, ..Default::default() };
            self.script.vehicle_says(&MavMessage::ESTIMATOR_STATUS(status));
        }
        if let Some(sensors) = self.sensors {
            let [present, enabled, health] = sensors.map(MavSysStatusSensor::from_bits_retain);
            self.script.vehicle_says(&MavMessage::SYS_STATUS(SYS_STATUS_DATA {
                onboard_control_sensors_present: present,
                onboard_control_sensors_enabled: enabled,
                onboard_control_sensors_health: health,
                ..Default::default()
            }));
        }
    }

    /// What was reported since the last call, without the simulated times.
    pub(super) fn reports(&mut self) -> Vec<String> {
        let reports = texts(&std::mem::take(&mut self.script.events));
        reports.iter().map(|text| text.split_once(" s  ").unwrap().1.to_owned()).collect()
    }

    /// How often arming has been asked for.
    pub(super) fn armings(&self) -> usize {
        self.script.sent.iter().filter_map(|(_, f)| f.command()).filter(|c| c.command == 400).count()
    }
}

pub(super) const PASS: Option<[u32; 3]> = Some([PREARM_CHECK; 3]);
pub(super) const FAIL: Option<[u32; 3]> = Some([PREARM_CHECK, PREARM_CHECK, 0]);
