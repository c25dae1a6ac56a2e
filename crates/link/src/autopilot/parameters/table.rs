//! The declaration: every parameter that the autopilot has, and what it is to it. Type, unit, default, range,
//! decimals and description are PX4's (`params::metadata`) unless a row says otherwise; a `#` stands
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
            Self::Controller | Self::Hover | Self::SetpointLife | Self::Setting | Self::AtBeginning(_)
        )
    }
}

/// A row of the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Declaration {
    /// PX4's name; `#` for a rotor's number.
    pub name: &'static str,
    /// The role of the parameter in the autopilot.
    pub role: Role,
    /// Least and greatest value where PX4's do not fit.
    pub range: Option<(f32, f32)>,
}

/// Whether the estimator is flown on; PX4 has its EKF2 under that name.
pub(super) const ESTIMATOR: &str = "EKF2_EN";
/// How old a satellite fix is when it comes [ms].
pub(super) const GPS_DELAY: &str = "EKF2_GPS_DELAY";

/// Every parameter, by name: a line of `table.csv` each, with its role, what the role is of (a value, a
/// leader), and the least and greatest value where PX4's do not fit. Gains of a vehicle that is no PX4
/// quadrotor lie outside PX4's ranges: any that is not negative is taken, and a slip of some decimals is not.
pub fn table() -> impl Iterator<Item = Declaration> {
    include_str!("table.csv").lines().skip(1).filter_map(declaration)
}

fn declaration(line: &'static str) -> Option<Declaration> {
    let fields: Vec<&'static str> = line.split(',').collect();
    let [name, role, of, least, most] = fields[..] else { return None };
    let value = || of.parse().map(Value::Int).or_else(|_| of.parse().map(Value::Real)).ok();
    let role = match role {
        "controller" => Role::Controller,
        "follows" => Role::Follows(of),
        "hover" => Role::Hover,
        "setpoint_life" => Role::SetpointLife,
        "setting" => Role::Setting,
        "vehicle" => Role::Vehicle,
        "fact" => Role::Fact(value()?),
        "system_id" => Role::SystemId,
        "estimator" => Role::Estimator,
        "at_beginning" => Role::AtBeginning(value()?),
        _ => return None,
    };
    Some(Declaration { name, role, range: least.parse().ok().zip(most.parse().ok()) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::Value;
    use crate::params::metadata::Kind;

    #[test]
    fn closed_form_every_row_is_known_to_px4_and_of_its_type() {
        let metadata = crate::autopilot::parameters::metadata();
        let table: Vec<Declaration> = table().collect();
        assert_eq!(table.len() + 1, include_str!("table.csv").lines().count(), "a line that is no row");
        assert!(table.is_sorted_by(|a, b| a.name < b.name));
        for declared in &table {
            let known = metadata.nearest(declared.name).unwrap_or_else(|| panic!("{}", declared.name));
            assert!(declared.name.len() <= 16);
            if let Role::Fact(value) | Role::AtBeginning(value) = declared.role {
                assert_eq!(matches!(value, Value::Int(_)), known.kind == Kind::Int, "{}", declared.name);
            }
            if let Role::Follows(leader) = declared.role {
                assert!(table.iter().any(|d| d.name == leader && d.role == Role::Controller));
            }
        }
    }
}
