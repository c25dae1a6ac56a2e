//! What the automatic modes and failsafes fly by, under PX4's parameter names and with PX4's defaults, except
//! the loss of setpoints, which leads to HOLD here, and the gains of the position loop, which follow the
//! loops inside ([`PositionGains::beside`]).

use super::manual::ManualSettings;
use super::modes::FlightMode;
use super::sticks::{StickInput, StickSettings};
use crate::control::{Gains, PositionGains, VelocityLimits};

/// How long a setpoint lives unless COM_OF_LOSS_T says otherwise: PX4's default, 1 s [us].
pub const SETPOINT_TIMEOUT_US: u64 = 1_000_000;

/// CBRK_FLIGHTTERM with this value keeps the failure detector from stopping the motors.
const NO_TERMINATION: f64 = 121_212.0;

/// The settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// MPC_XY_P, MPC_Z_P.
    pub position: PositionGains,
    /// MPC_XY_VEL_MAX, MPC_Z_VEL_MAX_UP, MPC_Z_VEL_MAX_DN: what the position loop may ask for in OFFBOARD.
    pub greatest: VelocityLimits,
    /// MPC_XY_CRUISE, MPC_Z_V_AUTO_UP, MPC_Z_V_AUTO_DN: what it may ask for in the automatic modes.
    pub automatic: VelocityLimits,
    /// MIS_TAKEOFF_ALT: height above home of a takeoff [m].
    pub takeoff_height_m: f64,
    /// MPC_TKO_SPEED [m/s].
    pub takeoff_speed_m_s: f64,
    /// MPC_LAND_SPEED [m/s].
    pub land_speed_m_s: f64,
    /// What missions go by.
    pub mission: MissionSettings,
    /// COM_DISARM_LAND: time from landing to disarming [s]; `None` never.
    pub disarm_after_landing_s: Option<f64>,
    /// RTL_RETURN_ALT: height above home of the way back [m].
    pub return_height_m: f64,
    /// RTL_DESCEND_ALT: height above home at which it waits before it lands [m].
    pub descend_height_m: f64,
    /// RTL_LAND_DELAY [s]; `None` for ever.
    pub land_delay_s: Option<f64>,
    /// COM_OF_LOSS_T: how long a setpoint lives in OFFBOARD [us].
    pub setpoint_timeout_us: u64,
    /// COM_OBL_RC_ACT: what follows from a loss of setpoints.
    pub setpoint_loss: Action,
    /// NAV_DLL_ACT: what follows from silence of all ground stations.
    pub data_link_loss: Action,
    /// COM_DL_LOSS_T [s].
    pub data_link_timeout_s: f64,
    /// GF_ACTION: what follows from leaving the fence.
    pub fence: Action,
    /// GF_MAX_HOR_DIST [m]; 0 is no fence.
    pub fence_radius_m: f64,
    /// GF_MAX_VER_DIST [m]; 0 is no fence.
    pub fence_height_m: f64,
    /// COM_LOW_BAT_ACT: what follows from a battery that is critical, and from one that is about to be empty.
    pub battery: BatteryPolicy,
    /// BAT_LOW_THR: share of the charge below which there is a warning.
    pub battery_low: f64,
    /// BAT_CRIT_THR.
    pub battery_critical: f64,
    /// BAT_EMERGEN_THR.
    pub battery_emergency: f64,
    /// When estimates, attitude and motors count as failed, and what follows.
    pub health: HealthSettings,
    /// Whose sticks count, when they are lost, and what they take over from.
    pub sticks: StickSettings,
    /// NAV_RCL_ACT: what follows from their loss.
    pub stick_loss: Action,
    /// What sticks mean.
    pub manual: ManualSettings,
    /// SYS_FAILURE_EN: whether failures may be injected by command.
    pub injects_failures: bool,
}

/// When estimates, attitude and motors count as failed, and what follows, with the defaults of PX4 v1.14.3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HealthSettings {
    /// COM_POS_FS_EPH: greatest error of the horizontal position [m].
    pub position_error_m: f64,
    /// COM_VEL_FS_EVH: greatest error of the velocity [m/s].
    pub velocity_error_m_s: f64,
    /// FD_FAIL_R: a greater roll is a failure [deg]; 0 is none.
    pub roll_deg: f64,
    /// FD_FAIL_R_TTRI: how long it must last [s].
    pub roll_s: f64,
    /// FD_FAIL_P: a greater pitch is a failure [deg]; 0 is none.
    pub pitch_deg: f64,
    /// FD_FAIL_P_TTRI: how long it must last [s].
    pub pitch_s: f64,
    /// COM_LKDOWN_TKO: so soon after arming a failure of the attitude disarms [s]; 0 and less is never.
    pub lockdown_s: f64,
    /// CBRK_FLIGHTTERM: 121212 keeps a failure of the attitude from stopping the motors.
    pub termination_breaker: f64,
    /// FD_ACT_EN: not 0 looks after the motors.
    pub watches_motors: f64,
    /// COM_ACT_FAIL_ACT: what follows from a motor's failure.
    pub motor_failure: Action,
}

impl HealthSettings {
    /// PX4's defaults.
    pub const DEFAULT: Self = Self {
        position_error_m: 5.0,
        velocity_error_m_s: 1.0,
        roll_deg: 60.0,
        roll_s: 0.3,
        pitch_deg: 60.0,
        pitch_s: 0.3,
        lockdown_s: 3.0,
        termination_breaker: NO_TERMINATION,
        watches_motors: 1.0,
        motor_failure: Action::Warn,
    };

    /// What follows from a failure of the attitude, but soon after arming.
    pub fn attitude_failure(&self) -> Action {
        if self.termination_breaker == NO_TERMINATION { Action::Warn } else { Action::Terminate }
    }
}

/// What missions go by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MissionSettings {
    /// NAV_ACC_RAD: a place is reached within this [m]. PX4's default for multirotors (rc.mc_defaults).
    pub reached_within_m: f64,
    /// NAV_LOITER_RAD: how far from a place NAV_LOITER_TO_ALT is over it, beyond NAV_ACC_RAD [m].
    pub loiter_radius_m: f64,
    /// MIS_YAW_ERR: a heading is reached within this [deg].
    pub yaw_within_deg: f64,
    /// MIS_PD_TO: how long the acknowledgement of a release is waited for [s].
    pub release_timeout_s: f64,
    /// MIS_DIST_1WP: greatest horizontal distance to the first place [m]; 0 and less is any.
    pub first_place_within_m: f64,
    /// MIS_TKO_LAND_REQ: what a mission must have.
    pub requirement: Requirement,
    /// COM_TAKEOFF_ACT: whether a mission, if there is a valid one, follows a TAKEOFF; otherwise HOLD.
    pub follows_takeoff: bool,
}

/// MIS_TKO_LAND_REQ: what a mission must have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Requirement {
    /// 0: nothing.
    Nothing,
    /// 1: a takeoff.
    Takeoff,
    /// 2: a landing.
    Landing,
    /// 3: both.
    Both,
    /// 4: both or neither.
    BothOrNeither,
}

impl Requirement {
    fn from_code(code: f64) -> Option<Self> {
        [Self::Nothing, Self::Takeoff, Self::Landing, Self::Both, Self::BothOrNeither]
            .into_iter()
            .find(|requirement| f64::from(*requirement as i32) == code)
    }
}

/// What a failsafe does, from mild to severe.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Action {
    /// Nothing.
    #[default]
    Nothing,
    /// Says so.
    Warn,
    /// POSCTL.
    Position,
    /// ALTCTL.
    Altitude,
    /// STABILIZED.
    Stabilized,
    /// HOLD.
    Hold,
    /// RETURN.
    Return,
    /// LAND.
    Land,
    /// LAND without a position: it sinks level, wherever the wind takes it.
    Descend,
    /// Stops the motors, as a crew does that disarms.
    Disarm,
    /// Stops the motors for good.
    Terminate,
}

impl Action {
    /// The mode that it leads to.
    pub fn mode(self) -> Option<FlightMode> {
        match self {
            Self::Position => Some(FlightMode::Posctl),
            Self::Altitude => Some(FlightMode::Altctl),
            Self::Stabilized => Some(FlightMode::Stabilized),
            Self::Hold => Some(FlightMode::AutoLoiter),
            Self::Return => Some(FlightMode::AutoRtl),
            // PX4 shows its Descend as LAND, too (px4_custom_mode.h, v1.14.3).
            Self::Land | Self::Descend => Some(FlightMode::AutoLand),
            Self::Nothing | Self::Warn | Self::Disarm | Self::Terminate => None,
        }
    }

    /// Name of the action, as crews know it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Nothing => "no action",
            Self::Warn => "warning",
            Self::Position => "POSCTL",
            Self::Altitude => "ALTCTL",
            Self::Stabilized => "STABILIZED",
            Self::Hold => "HOLD",
            Self::Return => "RETURN",
            Self::Land => "LAND",
            Self::Descend => "DESCEND",
            Self::Disarm => "DISARM",
            Self::Terminate => "TERMINATE",
        }
    }
}

/// COM_LOW_BAT_ACT.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BatteryPolicy {
    /// 0: warnings only.
    Warn,
    /// 1: return when critical.
    Return,
    /// 2: land when critical.
    Land,
    /// 3: return when critical, land when about to be empty.
    ReturnThenLand,
}

impl Settings {
    /// Whether distances from home are fenced: a limit, and something that follows from passing it.
    pub fn has_fence(&self) -> bool {
        self.fence != Action::Nothing && (self.fence_radius_m > 0.0 || self.fence_height_m > 0.0)
    }

    /// The defaults beside the gains of a cascade.
    pub fn beside(gains: &Gains) -> Self {
        Self {
            position: PositionGains::beside(gains),
            greatest: VelocityLimits { level_m_s: 12.0, up_m_s: 3.0, down_m_s: 1.5 },
            automatic: VelocityLimits { level_m_s: 5.0, up_m_s: 3.0, down_m_s: 1.5 },
            takeoff_height_m: 2.5,
            takeoff_speed_m_s: 1.5,
            land_speed_m_s: 0.7,
            mission: MissionSettings {
                reached_within_m: 2.0,
                loiter_radius_m: 80.0,
                yaw_within_deg: 12.0,
                release_timeout_s: 5.0,
                first_place_within_m: 900.0,
                requirement: Requirement::Nothing,
                follows_takeoff: false,
            },
            disarm_after_landing_s: Some(2.0),
            return_height_m: 60.0,
            descend_height_m: 30.0,
            land_delay_s: Some(0.0),
            setpoint_timeout_us: SETPOINT_TIMEOUT_US,
            setpoint_loss: Action::Hold,
            data_link_loss: Action::Nothing,
            data_link_timeout_s: 10.0,
            fence: Action::Hold,
            fence_radius_m: 0.0,
            fence_height_m: 0.0,
            battery: BatteryPolicy::Warn,
            battery_low: 0.15,
            battery_critical: 0.07,
            battery_emergency: 0.05,
            health: HealthSettings::DEFAULT,
            sticks: StickSettings::DEFAULT,
            stick_loss: Action::Return,
            manual: ManualSettings::DEFAULT,
            injects_failures: false,
        }
    }

    /// The value of a parameter in PX4's terms; `None` when no setting has that name.
    pub fn get(&self, name: &str) -> Option<f64> {
        let code = |codes: &[(i32, Action)], action: Action| {
            codes.iter().find(|(_, a)| *a == action).map_or(0.0, |(code, _)| f64::from(*code))
        };
        Some(match name {
            "COM_OBL_RC_ACT" => code(&SETPOINT_LOSS, self.setpoint_loss),
            "NAV_DLL_ACT" => code(&DATA_LINK_LOSS, self.data_link_loss),
            "GF_ACTION" => code(&FENCE, self.fence),
            "NAV_RCL_ACT" => code(&STICK_LOSS, self.stick_loss),
            "COM_RC_IN_MODE" => f64::from(self.sticks.input as u8),
            "COM_RC_OVERRIDE" => f64::from(self.sticks.overrides),
            "COM_RCL_EXCEPT" => f64::from(self.sticks.loss_exceptions),
            "MPC_THR_CURVE" => f64::from(self.manual.linear_thrust),
            "COM_LOW_BAT_ACT" => f64::from(self.battery as i32),
            "COM_ACT_FAIL_ACT" => code(&MOTOR_FAILURE, self.health.motor_failure),
            "COM_TAKEOFF_ACT" => f64::from(u8::from(self.mission.follows_takeoff)),
            "MIS_TKO_LAND_REQ" => f64::from(self.mission.requirement as i32),
            "SYS_FAILURE_EN" => f64::from(u8::from(self.injects_failures)),
            "COM_DISARM_LAND" => self.disarm_after_landing_s.unwrap_or(-1.0),
            "RTL_LAND_DELAY" => self.land_delay_s.unwrap_or(-1.0),
            // number() gives a place to write to: read it from a copy.
            _ => *self.clone().number(name)?,
        })
    }

    /// Changes a setting to the value of a parameter, in PX4's terms; false when no setting has that name or
    /// that value.
    pub fn set(&mut self, name: &str, value: f64) -> bool {
        let action = |codes: &[(i32, Action)]| {
            codes.iter().find(|(code, _)| f64::from(*code) == value).map(|(_, action)| *action)
        };
        let taken = match name {
            "COM_OBL_RC_ACT" => action(&SETPOINT_LOSS).map(|a| self.setpoint_loss = a),
            "NAV_DLL_ACT" => action(&DATA_LINK_LOSS).map(|a| self.data_link_loss = a),
            "GF_ACTION" => action(&FENCE).map(|a| self.fence = a),
            "NAV_RCL_ACT" => action(&STICK_LOSS).map(|a| self.stick_loss = a),
            "COM_RC_IN_MODE" => StickInput::from_number(value).map(|input| self.sticks.input = input),
            "COM_RC_OVERRIDE" => bits(value, 2).map(|bits| self.sticks.overrides = bits),
            "COM_RCL_EXCEPT" => bits(value, 3).map(|bits| self.sticks.loss_exceptions = bits),
            "MPC_THR_CURVE" => bits(value, 1).map(|curve| self.manual.linear_thrust = curve == 1),
            "COM_LOW_BAT_ACT" => battery_policy(value).map(|p| self.battery = p),
            "COM_ACT_FAIL_ACT" => action(&MOTOR_FAILURE).map(|a| self.health.motor_failure = a),
            "COM_TAKEOFF_ACT" => {
                [0.0, 1.0].contains(&value).then(|| self.mission.follows_takeoff = value == 1.0)
            }
            "MIS_TKO_LAND_REQ" => Requirement::from_code(value).map(|r| self.mission.requirement = r),
            "SYS_FAILURE_EN" => bits(value, 1).map(|bits| self.injects_failures = bits == 1),
            "COM_DISARM_LAND" => {
                self.disarm_after_landing_s = (value > 0.0).then_some(value);
                Some(())
            }
            "RTL_LAND_DELAY" => {
                self.land_delay_s = (value >= 0.0).then_some(value);
                Some(())
            }
            _ => self.number(name).map(|number| *number = value),
        };
        taken.is_some()
    }

    fn number(&mut self, name: &str) -> Option<&mut f64> {
        Some(match name {
            "MPC_XY_P" => &mut self.position.k_pxy,
            "MPC_Z_P" => &mut self.position.k_pz,
            "MPC_XY_VEL_MAX" => &mut self.greatest.level_m_s,
            "MPC_Z_VEL_MAX_UP" => &mut self.greatest.up_m_s,
            "MPC_Z_VEL_MAX_DN" => &mut self.greatest.down_m_s,
            "MPC_XY_CRUISE" => &mut self.automatic.level_m_s,
            "MPC_Z_V_AUTO_UP" => &mut self.automatic.up_m_s,
            "MPC_Z_V_AUTO_DN" => &mut self.automatic.down_m_s,
            "MIS_TAKEOFF_ALT" => &mut self.takeoff_height_m,
            "MPC_TKO_SPEED" => &mut self.takeoff_speed_m_s,
            "MPC_LAND_SPEED" => &mut self.land_speed_m_s,
            "NAV_ACC_RAD" => &mut self.mission.reached_within_m,
            "NAV_LOITER_RAD" => &mut self.mission.loiter_radius_m,
            "MIS_YAW_ERR" => &mut self.mission.yaw_within_deg,
            "MIS_PD_TO" => &mut self.mission.release_timeout_s,
            "MIS_DIST_1WP" => &mut self.mission.first_place_within_m,
            "RTL_RETURN_ALT" => &mut self.return_height_m,
            "RTL_DESCEND_ALT" => &mut self.descend_height_m,
            "COM_DL_LOSS_T" => &mut self.data_link_timeout_s,
            "GF_MAX_HOR_DIST" => &mut self.fence_radius_m,
            "GF_MAX_VER_DIST" => &mut self.fence_height_m,
            "BAT_LOW_THR" => &mut self.battery_low,
            "BAT_CRIT_THR" => &mut self.battery_critical,
            "BAT_EMERGEN_THR" => &mut self.battery_emergency,
            "COM_POS_FS_EPH" => &mut self.health.position_error_m,
            "COM_VEL_FS_EVH" => &mut self.health.velocity_error_m_s,
            "FD_FAIL_R" => &mut self.health.roll_deg,
            "FD_FAIL_R_TTRI" => &mut self.health.roll_s,
            "FD_FAIL_P" => &mut self.health.pitch_deg,
            "FD_FAIL_P_TTRI" => &mut self.health.pitch_s,
            "COM_LKDOWN_TKO" => &mut self.health.lockdown_s,
            "CBRK_FLIGHTTERM" => &mut self.health.termination_breaker,
            "FD_ACT_EN" => &mut self.health.watches_motors,
            "COM_RC_LOSS_T" => &mut self.sticks.timeout_s,
            "COM_RC_STICK_OV" => &mut self.sticks.moved_percent,
            "MPC_VEL_MANUAL" => &mut self.manual.speed_m_s,
            "MPC_VEL_MAN_SIDE" => &mut self.manual.side_speed_m_s,
            "MPC_VEL_MAN_BACK" => &mut self.manual.back_speed_m_s,
            "MPC_MAN_TILT_MAX" => &mut self.manual.tilt_deg,
            "MC_MAN_TILT_TAU" => &mut self.manual.tilt_tau_s,
            "MPC_MAN_Y_MAX" => &mut self.manual.yaw_rate_deg_s,
            "MPC_MAN_Y_TAU" => &mut self.manual.yaw_tau_s,
            "MPC_HOLD_DZ" => &mut self.manual.dead_zone,
            "MPC_HOLD_MAX_XY" => &mut self.manual.hold_speed_m_s,
            "MPC_HOLD_MAX_Z" => &mut self.manual.hold_climb_m_s,
            "MPC_XY_MAN_EXPO" => &mut self.manual.level_expo,
            "MPC_Z_MAN_EXPO" => &mut self.manual.climb_expo,
            "MPC_YAW_EXPO" => &mut self.manual.yaw_expo,
            "MPC_LAND_ALT1" => &mut self.manual.slow_below_m,
            "MPC_LAND_ALT2" => &mut self.manual.slowest_below_m,
            "MPC_MANTHR_MIN" => &mut self.manual.least_thrust,
            "MPC_THR_MAX" => &mut self.manual.most_thrust,
            _ => return None,
        })
    }
}

/// PX4's numbers of the actions.
pub(super) const SETPOINT_LOSS: [(i32, Action); 8] = [
    (0, Action::Position),
    (1, Action::Altitude),
    (2, Action::Stabilized),
    (3, Action::Return),
    (4, Action::Land),
    (5, Action::Hold),
    (6, Action::Terminate),
    (7, Action::Disarm),
];
pub(super) const DATA_LINK_LOSS: [(i32, Action); 6] = [
    (0, Action::Nothing),
    (1, Action::Hold),
    (2, Action::Return),
    (3, Action::Land),
    (5, Action::Terminate),
    (6, Action::Disarm),
];
pub(super) const STICK_LOSS: [(i32, Action); 5] =
    [(1, Action::Hold), (2, Action::Return), (3, Action::Land), (5, Action::Terminate), (6, Action::Disarm)];
pub(super) const FENCE: [(i32, Action); 6] = [
    (0, Action::Nothing),
    (1, Action::Warn),
    (2, Action::Hold),
    (3, Action::Return),
    (4, Action::Terminate),
    (5, Action::Land),
];
pub(super) const MOTOR_FAILURE: [(i32, Action); 5] =
    [(0, Action::Warn), (1, Action::Hold), (2, Action::Land), (3, Action::Return), (4, Action::Terminate)];

/// A whole number of so many bits.
fn bits(value: f64, count: u32) -> Option<u8> {
    (0..1u8 << count).find(|bits| f64::from(*bits) == value)
}

fn battery_policy(value: f64) -> Option<BatteryPolicy> {
    [BatteryPolicy::Warn, BatteryPolicy::Return, BatteryPolicy::Land, BatteryPolicy::ReturnThenLand]
        .into_iter()
        .find(|policy| f64::from(*policy as i32) == value)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is set is what is read back; what is not a setting or has no such value changes nothing.
    #[test]
    fn closed_form_settings_are_read_back_in_px4s_terms() {
        let mut settings = Settings::beside(&Gains::near_hover());
        for (name, value) in [
            ("MPC_XY_P", 0.5),
            ("MPC_Z_VEL_MAX_DN", 1.0),
            ("MPC_XY_CRUISE", 7.0),
            ("COM_OBL_RC_ACT", 4.0),
            ("NAV_DLL_ACT", 2.0),
            ("GF_ACTION", 4.0),
            ("COM_LOW_BAT_ACT", 3.0),
            ("COM_DISARM_LAND", -1.0),
            ("RTL_LAND_DELAY", -1.0),
            ("RTL_LAND_DELAY", 0.0),
            ("MIS_TKO_LAND_REQ", 4.0),
            ("COM_TAKEOFF_ACT", 1.0),
            ("MIS_DIST_1WP", -1.0),
            ("BAT_EMERGEN_THR", 0.04),
            ("COM_ACT_FAIL_ACT", 2.0),
            ("CBRK_FLIGHTTERM", 0.0),
            ("FD_FAIL_P", 45.0),
            ("NAV_RCL_ACT", 1.0),
            ("COM_RC_IN_MODE", 3.0),
            ("COM_RC_OVERRIDE", 3.0),
            ("COM_RCL_EXCEPT", 7.0),
            ("COM_RC_LOSS_T", 1.5),
            ("MPC_THR_CURVE", 1.0),
            ("SYS_FAILURE_EN", 1.0),
            ("MPC_VEL_MAN_BACK", 2.0),
        ] {
            assert!(settings.set(name, value), "{name}");
            assert_eq!(settings.get(name), Some(value), "{name}");
        }
        let before = settings;
        for (name, value) in [
            ("COM_OBL_RC_ACT", 8.0),
            ("NAV_DLL_ACT", 4.0),
            ("NAV_RCL_ACT", 0.0),
            ("COM_RC_IN_MODE", 5.0),
            ("COM_RC_OVERRIDE", 4.0),
            ("COM_RCL_EXCEPT", 8.0),
            ("MPC_THR_CURVE", 2.0),
            ("GF_ACTION", 1.5),
            ("COM_TAKEOFF_ACT", 2.0),
            ("NONE", 1.0),
        ] {
            assert!(!settings.set(name, value));
        }
        assert_eq!((settings, settings.get("NONE")), (before, None));
    }
}
