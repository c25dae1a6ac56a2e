//! The declaration: every parameter that the autopilot has, and what it is to it. Type, unit, default, range,
//! decimals and description are PX4's (`params/px4/parameters.csv`) unless a row says otherwise; a `#` stands
//! for a rotor's number.

use crate::params::Value;

/// What a parameter is to the autopilot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Role {
    /// A gain or limit of the cascade: in effect at the next control step.
    Controller,
    /// A gain or limit of roll, which flies pitch's: it follows the parameter of that name.
    Follows(&'static str),
    /// The collective that carries the weight: scales the mass that the controller believes in.
    Hover,
    /// How long a setpoint lives in OFFBOARD.
    SetpointLife,
    /// What the automatic modes and failsafes go by: in effect at the next control step.
    Setting,
    /// Kept and shown, and nothing flies by it yet.
    Kept(Value),
    /// What the mission's vehicle says: it cannot be changed here.
    Vehicle,
    /// A fact about this autopilot: it cannot be changed.
    Fact(Value),
    /// MAVLink's system id: it cannot be changed here.
    SystemId,
    /// Whether the estimator is flown on, or the simulator's truth: it cannot be changed here.
    Estimator,
    /// What the estimator goes by: in effect when it begins.
    AtBeginning(Value),
}

impl Role {
    /// The role in a few words.
    pub fn words(self) -> String {
        match self {
            Self::Controller => "acts at the next control step".to_owned(),
            Self::Follows(leader) => format!("follows {leader}: roll flies pitch's gains"),
            Self::Hover => {
                "acts at the next control step: the mass that the controller believes in".to_owned()
            }
            Self::SetpointLife => "acts at once".to_owned(),
            Self::Setting => "acts at the next control step".to_owned(),
            Self::Kept(_) => "kept; nothing flies by it".to_owned(),
            Self::Vehicle => "read-only: from the mission's vehicle".to_owned(),
            Self::Fact(_) => "read-only".to_owned(),
            Self::SystemId => "read-only: from --instance".to_owned(),
            Self::Estimator => "read-only: from --estimator".to_owned(),
            Self::AtBeginning(_) => {
                "acts when the estimator begins: at the start, or when the simulator starts over".to_owned()
            }
        }
    }

    /// Whether a ground station may change it.
    pub fn is_settable(self) -> bool {
        matches!(
            self,
            Self::Controller
                | Self::Hover
                | Self::SetpointLife
                | Self::Setting
                | Self::Kept(_)
                | Self::AtBeginning(_)
        )
    }
}

/// One row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Declaration {
    /// PX4's name; `#` for a rotor's number.
    pub name: &'static str,
    /// The role of the parameter in the autopilot.
    pub role: Role,
    /// Least and greatest value where PX4's do not fit.
    pub range: Option<(f32, f32)>,
}

const fn row(name: &'static str, role: Role) -> Declaration {
    Declaration { name, role, range: None }
}

const fn within(name: &'static str, role: Role, least: f32, most: f32) -> Declaration {
    Declaration { name, role, range: Some((least, most)) }
}

const fn kept(name: &'static str, value: f32) -> Declaration {
    row(name, Role::Kept(Value::Real(value)))
}

const fn setting(name: &'static str) -> Declaration {
    row(name, Role::Setting)
}

const fn fact(name: &'static str, value: i32) -> Declaration {
    row(name, Role::Fact(Value::Int(value)))
}

const fn absent(name: &'static str) -> Declaration {
    row(name, Role::Fact(Value::Real(0.0)))
}

/// Gains of a vehicle that is no PX4 quadrotor lie outside PX4's ranges: any that is not negative is taken,
/// and a slip of some decimals is not.
const MOST_GAIN: f32 = 100.0;

const fn gain(name: &'static str) -> Declaration {
    within(name, Role::Controller, 0.0, MOST_GAIN)
}

const fn follows(name: &'static str, leader: &'static str) -> Declaration {
    within(name, Role::Follows(leader), 0.0, MOST_GAIN)
}

/// Least rate limit [deg/s] that still lets the vehicle turn.
const LEAST_RATE: f32 = 1.0;

/// Whether the estimator is flown on; PX4 has its EKF2 under that name.
pub(super) const ESTIMATOR: &str = "EKF2_EN";
/// How old a satellite fix is when it comes [ms].
pub(super) const GPS_DELAY: &str = "EKF2_GPS_DELAY";

/// Every parameter, by name.
pub const TABLE: &[Declaration] = &[
    fact("BAT1_SOURCE", -1),
    setting("BAT_CRIT_THR"),
    setting("BAT_EMERGEN_THR"),
    setting("BAT_LOW_THR"),
    fact("CAL_ACC0_ID", 1),
    fact("CAL_GYRO0_ID", 1),
    fact("CAL_MAG0_ID", 1),
    fact("CAL_MAG1_ID", 0),
    fact("CAL_MAG2_ID", 0),
    row("CA_AIRFRAME", Role::Vehicle),
    row("CA_ROTOR#_AX", Role::Vehicle),
    row("CA_ROTOR#_AY", Role::Vehicle),
    row("CA_ROTOR#_AZ", Role::Vehicle),
    row("CA_ROTOR#_CT", Role::Vehicle),
    row("CA_ROTOR#_KM", Role::Vehicle),
    row("CA_ROTOR#_PX", Role::Vehicle),
    row("CA_ROTOR#_PY", Role::Vehicle),
    row("CA_ROTOR#_PZ", Role::Vehicle),
    row("CA_ROTOR_COUNT", Role::Vehicle),
    setting("COM_DISARM_LAND"),
    setting("COM_DL_LOSS_T"),
    fact("COM_FLTMODE1", -1),
    fact("COM_FLTMODE2", -1),
    fact("COM_FLTMODE3", -1),
    fact("COM_FLTMODE4", -1),
    fact("COM_FLTMODE5", -1),
    fact("COM_FLTMODE6", -1),
    within("COM_LOW_BAT_ACT", Role::Setting, 0.0, 3.0),
    within("COM_OBL_RC_ACT", Role::Setting, 3.0, 5.0),
    within("COM_OF_LOSS_T", Role::SetpointLife, 0.1, 60.0),
    fact("COM_RC_IN_MODE", 1),
    kept("COM_RC_LOSS_T", 0.5),
    row(ESTIMATOR, Role::Estimator),
    within(GPS_DELAY, Role::AtBeginning(Value::Real(0.0)), 0.0, 1000.0),
    setting("GF_ACTION"),
    setting("GF_MAX_HOR_DIST"),
    setting("GF_MAX_VER_DIST"),
    fact("GF_SOURCE", 0),
    fact("MAV_COMP_ID", 1),
    row("MAV_SYS_ID", Role::SystemId),
    fact("MAV_TYPE", 2),
    absent("MC_PITCHRATE_D"),
    absent("MC_PITCHRATE_FF"),
    gain("MC_PITCHRATE_I"),
    within("MC_PITCHRATE_K", Role::Controller, 0.01, MOST_GAIN),
    within("MC_PITCHRATE_MAX", Role::Controller, LEAST_RATE, 1800.0),
    gain("MC_PITCHRATE_P"),
    gain("MC_PITCH_P"),
    gain("MC_PR_INT_LIM"),
    absent("MC_ROLLRATE_D"),
    absent("MC_ROLLRATE_FF"),
    follows("MC_ROLLRATE_I", "MC_PITCHRATE_I"),
    follows("MC_ROLLRATE_K", "MC_PITCHRATE_K"),
    follows("MC_ROLLRATE_MAX", "MC_PITCHRATE_MAX"),
    follows("MC_ROLLRATE_P", "MC_PITCHRATE_P"),
    follows("MC_ROLL_P", "MC_PITCH_P"),
    follows("MC_RR_INT_LIM", "MC_PR_INT_LIM"),
    absent("MC_YAWRATE_D"),
    absent("MC_YAWRATE_FF"),
    absent("MC_YAWRATE_I"),
    within("MC_YAWRATE_K", Role::Controller, 0.01, MOST_GAIN),
    within("MC_YAWRATE_MAX", Role::Controller, LEAST_RATE, 1800.0),
    gain("MC_YAWRATE_P"),
    gain("MC_YAW_P"),
    setting("MIS_TAKEOFF_ALT"),
    within("MPC_LAND_SPEED", Role::Setting, 0.6, 5.0),
    within("MPC_THR_HOVER", Role::Hover, 0.01, 1.0),
    within("MPC_TILTMAX_AIR", Role::Controller, 1.0, 89.0),
    setting("MPC_TKO_SPEED"),
    setting("MPC_XY_CRUISE"),
    setting("MPC_XY_P"),
    absent("MPC_XY_VEL_D_ACC"),
    gain("MPC_XY_VEL_I_ACC"),
    setting("MPC_XY_VEL_MAX"),
    gain("MPC_XY_VEL_P_ACC"),
    within("MPC_Z_P", Role::Setting, 0.0, 1.5),
    absent("MPC_Z_VEL_D_ACC"),
    gain("MPC_Z_VEL_I_ACC"),
    setting("MPC_Z_VEL_MAX_DN"),
    setting("MPC_Z_VEL_MAX_UP"),
    gain("MPC_Z_VEL_P_ACC"),
    setting("MPC_Z_V_AUTO_DN"),
    setting("MPC_Z_V_AUTO_UP"),
    within("NAV_DLL_ACT", Role::Setting, 0.0, 3.0),
    fact("NAV_RCL_ACT", 1),
    fact("RC_MAP_AUX1", 0),
    fact("RC_MAP_AUX2", 0),
    fact("RC_MAP_FLAPS", 0),
    fact("RC_MAP_PITCH", 0),
    fact("RC_MAP_ROLL", 0),
    fact("RC_MAP_THROTTLE", 0),
    fact("RC_MAP_YAW", 0),
    setting("RTL_DESCEND_ALT"),
    setting("RTL_LAND_DELAY"),
    setting("RTL_RETURN_ALT"),
    fact("SYS_AUTOCONFIG", 0),
    fact("SYS_AUTOSTART", 4001),
    row("THR_MDL_FAC", Role::Vehicle),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::metadata::Kind;
    use crate::params::{Metadata, Value};

    #[test]
    fn closed_form_every_row_is_known_to_px4_and_of_its_type() {
        let metadata = Metadata::px4();
        assert!(TABLE.is_sorted_by(|a, b| a.name < b.name));
        for declared in TABLE {
            let known = metadata.get(declared.name).unwrap_or_else(|| panic!("{}", declared.name));
            assert!(declared.name.len() <= 16);
            if let Role::Kept(value) | Role::Fact(value) | Role::AtBeginning(value) = declared.role {
                assert_eq!(matches!(value, Value::Int(_)), known.kind == Kind::Int, "{}", declared.name);
            }
            if let Role::Follows(leader) = declared.role {
                assert!(TABLE.iter().any(|d| d.name == leader && d.role == Role::Controller));
            }
        }
    }
}
