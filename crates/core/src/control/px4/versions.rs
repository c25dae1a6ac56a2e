//! PX4's versions: what a drop meets that differs between them, as one table.
//!
//! A row was read in the sources of the tag that it names and holds until the next row's version. The version
//! that flies is known by AUTOPILOT_VERSION; what is between two versions, or says nothing, is known by the
//! parameters that it has ([`Version::known_by`]).

use std::fmt;
use std::str::FromStr;

use super::law::Law;

/// The first two numbers of a version: `v1.14`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Number {
    /// The first.
    pub major: u8,
    /// The second.
    pub minor: u8,
}

/// A text is no number of a version.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a version of PX4 is expected, as v1.16 or 1.16.0")]
pub struct NotAVersion;

/// Reads `v1.16`, `1.16` or `1.16.0`.
impl FromStr for Number {
    type Err = NotAVersion;

    fn from_str(text: &str) -> Result<Self, NotAVersion> {
        let mut numbers = text.strip_prefix('v').unwrap_or(text).split('.').map(str::parse);
        match (numbers.next(), numbers.next(), numbers.next(), numbers.next()) {
            (Some(Ok(major)), Some(Ok(minor)), None | Some(Ok(_)), None) => Ok(Self { major, minor }),
            _ => Err(NotAVersion),
        }
    }
}

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "v{}.{}", self.major, self.minor)
    }
}

/// Where the rotors' geometry is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Allocation {
    /// In files of mixers, chosen by the start script.
    MixerFiles,
    /// In the parameters CA_*.
    Parameters,
}

/// How SYS_STATUS tells that the checks before arming pass (bit PREARM_CHECK).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChecksReport {
    /// In all three fields: present, enabled, healthy.
    AllFields,
    /// In the field of what is healthy alone, and for the mode that it is in.
    HealthOnly,
}

/// How a refusal to arm is explained.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusals {
    /// By STATUSTEXT.
    Texts,
    /// By EVENT, whose texts are in metadata that PX4 serves.
    Events,
}

/// How a PX4 in simulation is told parameters that it reads once, at its start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ToldBy {
    /// By `px4-rc.params`, a script that its start-up script runs.
    Script,
    /// By variables of its environment, `PX4_PARAM_NAME=VALUE`.
    Environment,
}

impl ToldBy {
    /// The script that a start-up script runs.
    pub const SCRIPT: &str = "px4-rc.params";
    /// The beginning of the names of the variables that a start-up script takes for parameters.
    pub const VARIABLE: &str = "PX4_PARAM_";

    /// How a PX4 with this start-up script (`init.d-posix/rcS`) is told.
    pub fn of(startup: &str) -> Self {
        let (script, variable) = (startup.contains(Self::SCRIPT), startup.contains(Self::VARIABLE));
        if variable && !script { Self::Environment } else { Self::Script }
    }
}

/// A version of PX4, as far as a drop depends on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Version {
    /// The first version that is so.
    pub number: Number,
    /// The tag whose sources were read.
    pub read: &'static str,
    /// A parameter that this version has and the one before has not.
    pub known_by: Option<&'static str>,
    /// Where the rotors' geometry is.
    pub allocation: Allocation,
    /// How it is told parameters at its start.
    pub told_by: ToldBy,
    /// How the checks before arming are told.
    pub checks: ChecksReport,
    /// How a refusal to arm is explained.
    pub refusals: Refusals,
    /// Longest time on PX4's clock from the first velocity setpoint in OFFBOARD to velocity control [s]:
    /// the commander takes the kind of setpoint over when it publishes its state.
    pub velocity_control_after_s: f64,
    /// Age of a satellite fix that its simulation takes for granted (EKF2_GPS_DELAY) [s].
    pub satellite_delay_s: f64,
    /// Whether it was armed within 15 s in still air, under a canopy that moves and before a release that
    /// does not wait (`x500_no_wire`); as flown, four drops each of v1.14.3, v1.16.0 and v1.18.0-beta1. In
    /// the mission's own air v1.18.0-beta1 alone was, in four drops of four, v1.16.0 in none.
    pub is_armed_in_motion: bool,
    /// Whether a throw launch (COM_THROW_EN) may be asked of it.
    pub throw_launch: bool,
    /// The control law, where it has been read in the sources.
    pub law: Option<Law>,
}

const fn number(minor: u8) -> Number {
    Number { major: 1, minor }
}

/// The commander publishes its state at 2 Hz, or when it changes, to which another kind of setpoint does not
/// count (`Commander.cpp`, "publish states .. at 2 Hz or immediately when changed").
const TWO_HZ_S: f64 = 0.5;

const V1_12: Version = Version {
    number: number(12),
    read: "v1.12.0",
    known_by: None,
    allocation: Allocation::MixerFiles,
    told_by: ToldBy::Script,
    checks: ChecksReport::AllFields,
    refusals: Refusals::Texts,
    velocity_control_after_s: super::timing::SWITCH_S,
    satellite_delay_s: 0.11,
    is_armed_in_motion: true,
    throw_launch: false,
    law: Some(Law::V1_12),
};
const V1_13: Version =
    Version { number: number(13), read: "v1.13.3", known_by: Some("COM_PARACHUTE"), law: None, ..V1_12 };
const V1_14: Version = Version {
    number: number(14),
    read: "v1.14.3",
    known_by: Some("COM_SPOOLUP_TIME"),
    allocation: Allocation::Parameters,
    checks: ChecksReport::HealthOnly,
    refusals: Refusals::Events,
    velocity_control_after_s: TWO_HZ_S,
    is_armed_in_motion: false,
    law: Some(Law::V1_14),
    ..V1_13
};
const V1_15: Version = Version {
    number: number(15),
    read: "v1.15.4",
    known_by: Some("COM_THROW_EN"),
    satellite_delay_s: 0.01,
    is_armed_in_motion: true,
    throw_launch: true,
    law: None,
    ..V1_14
};
const V1_16: Version = Version {
    number: number(16),
    read: "v1.16.0",
    known_by: Some("COM_MODE_ARM_CHK"),
    told_by: ToldBy::Environment,
    law: Some(Law::V1_16),
    ..V1_15
};
const V1_17: Version =
    Version { number: number(17), read: "v1.17.0-beta1", known_by: Some("EKF2_GPS_MODE"), ..V1_16 };
const V1_18: Version = Version {
    number: number(18),
    read: "v1.18.0-beta1",
    known_by: Some("MC_REF_W_N"),
    law: Some(Law::V1_18),
    ..V1_17
};

/// All versions that are known, oldest first: each is the one before but for what it names.
pub const VERSIONS: [Version; 7] = [V1_12, V1_13, V1_14, V1_15, V1_16, V1_17, V1_18];

/// A text is not the number of a version whose law the model has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a version of PX4 is expected whose law the model has: {}", known().join(", "))]
pub struct NotModelled;

/// Versions that the model has.
fn known() -> Vec<String> {
    VERSIONS
        .iter()
        .filter(|version| version.law.is_some())
        .map(|version| version.number.to_string())
        .collect()
}

impl Version {
    /// The oldest version that is known: what is older is taken for it.
    pub const OLDEST: &'static Self = &VERSIONS[0];

    /// The version that a vehicle with that number flies: the newest of the table that is not newer, or the
    /// oldest of the table.
    pub fn of(number: Number) -> &'static Self {
        VERSIONS.iter().rev().find(|version| version.number <= number).unwrap_or(Self::OLDEST)
    }

    /// The newest version of the table one of whose parameters `has`; the oldest, where none is there.
    pub fn by_parameters(has: impl Fn(&str) -> bool) -> &'static Self {
        VERSIONS.iter().rev().find(|version| version.known_by.is_some_and(&has)).unwrap_or(Self::OLDEST)
    }

    /// The law of a version: `1.16`, `v1.16` or `v1.16.0`.
    ///
    /// # Errors
    /// [`NotModelled`] for a version whose law the model has not, and for what is no number of a version.
    pub fn law_of(text: &str) -> Result<Law, NotModelled> {
        let number: Number = text.parse().map_err(|_| NotModelled)?;
        Some(Self::of(number))
            .filter(|version| version.number == number)
            .and_then(|version| version.law)
            .ok_or(NotModelled)
    }

    /// Names of the parameters by which versions are known.
    pub fn probes() -> impl Iterator<Item = &'static str> {
        VERSIONS.iter().filter_map(|version| version.known_by)
    }

    /// Whether velocity setpoints that begin with the plan would be late.
    pub fn takes_velocity_late(&self) -> bool {
        self.velocity_control_after_s > super::timing::SWITCH_S
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_means_the_newest_row_that_is_not_newer() {
        let of = |major, minor| Version::of(Number { major, minor }).read;
        assert_eq!(
            [of(1, 16), of(1, 13), of(1, 11), of(1, 30), of(2, 0)],
            ["v1.16.0", "v1.13.3", "v1.12.0", "v1.18.0-beta1", "v1.18.0-beta1"]
        );
        assert!(VERSIONS.windows(2).all(|pair| pair[0].number < pair[1].number));
    }

    /// The lines of `ROMFS/px4fmu_common/init.d-posix/rcS` of v1.15.4 and of v1.16.0.
    #[test]
    fn reference_a_start_up_script_shows_how_it_is_told_parameters() {
        let (old, new) =
            (". px4-rc.params\n", "\"PX4_PARAM_\"*) param set \"${name#PX4_PARAM_}\" \"$value\" ;;\n");
        assert_eq!([old, new, ""].map(ToldBy::of), [ToldBy::Script, ToldBy::Environment, ToldBy::Script]);
    }

    #[test]
    fn parameters_tell_the_newest_version_that_has_one() {
        let by = |names: &[&str]| Version::by_parameters(|name| names.contains(&name)).read;
        assert_eq!(by(&[]), "v1.12.0");
        assert_eq!(by(&["COM_PARACHUTE"]), "v1.13.3");
        assert_eq!(by(&["COM_PARACHUTE", "COM_SPOOLUP_TIME", "COM_THROW_EN"]), "v1.15.4");
        assert!(VERSIONS[1..].iter().all(|version| version.known_by.is_some()), "each can be told");
    }

    #[test]
    fn a_law_is_known_by_its_versions_number() {
        assert_eq!(Version::law_of("1.12"), Ok(Law::V1_12));
        assert_eq!(Version::law_of("v1.14"), Ok(Law::V1_14));
        assert_eq!(Version::law_of("v1.16.0"), Ok(Law::V1_16));
        assert_eq!(Version::law_of("1.17"), Ok(Law::V1_16), "nothing differs in what the model has");
        assert_eq!(Version::law_of("1.18"), Ok(Law::V1_18));
        for text in ["", "1", "1.13", "1.11", "1.30", "one", "1.16.0.0", "1.16x"] {
            assert_eq!(Version::law_of(text), Err(NotModelled), "{text}");
        }
        let mut laws: Vec<Law> = VERSIONS.iter().filter_map(|version| version.law).collect();
        laws.dedup();
        assert_eq!(laws, Law::ALL);
        let words = "a version of PX4 is expected whose law the model has: v1.12, v1.14, v1.16, v1.17, v1.18";
        assert_eq!(NotModelled.to_string(), words);
    }
}
