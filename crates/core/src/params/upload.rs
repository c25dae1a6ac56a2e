//! The parameters that PX4 gets before a drop: what a drop requires, the exported gains, and a file.
//!
//! Values that the drop requires ([`super::px4_required`]) come first; a file may change one only to another
//! that meets the requirement. All other parameters of the file are taken (gains, limits, filters), except
//! those that describe one vehicle's sensors, wiring and number.

use std::collections::BTreeMap;

use super::px4_required::{DropEnvelope, TILT_AIR, TILT_LND, TILT_SHUT, broken, wanted};
use super::{ParameterFile, Value};
use crate::control::px4::Parameters;

/// Prefixes of parameters that belong to one vehicle alone: calibration, sensors, thermal corrections; its
/// number, links and start-up; serial ports, CAN; the remote control; its log, its flights.
const OF_ONE_VEHICLE: [&str; 12] = [
    "CAL_",
    "SENS_",
    "TC_",
    "MAV_",
    "SYS_",
    "SER_",
    "UAVCAN_",
    "RC_",
    "SDLOG_",
    "SIM_",
    "COM_FLIGHT_",
    "LND_FLIGHT_",
];
/// Most names in a remark; the others are counted.
const NAMES_SHOWN: usize = 4;

/// Parameters to be sent to PX4, and remarks on those that are not.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Upload {
    /// Parameters to be sent, by name.
    pub parameters: BTreeMap<String, Value>,
    /// Parameters of a file that are not sent, and why.
    pub remarks: Vec<String>,
}

impl Upload {
    /// Merges the parameters that the drop requires, `exported` (gains, limits, vehicle) and a file.
    pub fn new(
        envelope: &DropEnvelope,
        exported: impl IntoIterator<Item = (String, Value)>,
        given: Option<&ParameterFile>,
    ) -> Self {
        let mut made = Self { parameters: exported.into_iter().collect(), remarks: Vec::new() };
        for (name, value) in wanted(envelope) {
            let will_do = |has: &Value| broken(name, has.as_f64(), envelope).is_none();
            if !made.parameters.get(name).is_some_and(will_do) {
                made.parameters.insert(name.to_owned(), value);
            }
        }
        if let Some(file) = given {
            made.take(file, envelope);
            made.remark_on_tilt();
        }
        made
    }

    /// Remarks on a tilt limit that is lower at the beginning of a flight than later. Where a parameter is
    /// not sent, PX4 has its default.
    fn remark_on_tilt(&mut self) {
        let defaults = Parameters::default();
        let of = |name: &str| {
            self.parameters.get(name).map(|v| v.as_f64()).or_else(|| defaults.get(name)).unwrap_or_default()
        };
        let (before, in_flight) = (of(TILT_LND), of(TILT_AIR));
        if before < in_flight {
            self.remarks.push(format!("{TILT_LND} = {before}: {TILT_SHUT}"));
        }
    }

    fn take(&mut self, file: &ParameterFile, envelope: &DropEnvelope) {
        let mut foreign = Vec::new();
        for (name, entry) in file.own() {
            if OF_ONE_VEHICLE.iter().any(|beginning| name.starts_with(beginning)) {
                foreign.push(name);
                continue;
            }
            let value = entry.value;
            match (broken(name, value.as_f64(), envelope), self.parameters.get(name)) {
                (Some(rule), Some(stands)) => self.remarks.push(format!(
                    "{name} = {value} is not sent, {stands} stands: with the file's, {}",
                    rule.otherwise
                )),
                _ => _ = self.parameters.insert(name.to_owned(), value),
            }
        }
        if !foreign.is_empty() {
            let more = foreign.len().saturating_sub(NAMES_SHOWN);
            let names = foreign[..foreign.len() - more].join(", ");
            let more = if more > 0 { format!(" and {more} more") } else { String::new() };
            self.remarks.push(format!(
                "{names}{more}: not sent, they are of one vehicle's sensors, wiring and number"
            ));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By PX4's defaults, 12 and 45 deg, and by what a file has of the two.
    #[test]
    fn a_tilt_limit_that_begins_below_its_end_is_warned_of() {
        let remarks = |text: &str| {
            let file = ParameterFile::parse(text).unwrap();
            Upload::new(&DropEnvelope::default(), [], Some(&file)).remarks
        };
        for (rows, warned) in [
            ("", true),
            ("1\t1\tMPC_TILTMAX_LND\t45\t9\n", false),
            ("1\t1\tMPC_TILTMAX_AIR\t12\t9\n", false),
            ("1\t1\tMPC_TILTMAX_AIR\t30\t9\n1\t1\tMPC_TILTMAX_LND\t20\t9\n", true),
        ] {
            assert_eq!(remarks(rows).iter().any(|r| r.contains(TILT_SHUT)), warned, "{rows}");
        }
        assert!(Upload::new(&DropEnvelope::default(), [], None).remarks.is_empty());
    }

    /// A dump of a whole PX4 v1.12, in small: with its defaults a drop would fail.
    const DUMP: &str = "1\t1\tCAL_ACC0_ID\t1310988\t6\n1\t1\tCOM_DISARM_PRFLT\t10\t9\n1\t1\tEKF2_GPS_CHECK\t245\t6\n\
                        1\t1\tMAV_SYS_ID\t1\t6\n1\t1\tMC_PITCH_P\t6.5\t9\n1\t1\tMPC_XY_VEL_MAX\t20\t9\n\
                        1\t1\tMPC_THR_MAX\t0.5\t9\n1\t51\tMC_ROLL_P\t9\t9\n";

    #[test]
    fn the_drops_own_parameters_stand_and_another_vehicles_are_not_sent() {
        let of = DropEnvelope {
            fastest_descent_m_s: 9.1,
            fastest_horizontal_m_s: 2.0,
            hover_thrust: Some(0.59),
            satellite_delay_s: Some(0.11),
        };
        let file = ParameterFile::parse(DUMP).unwrap();
        let gains = [("MC_PITCH_P".to_owned(), Value::Real(4.0)), ("MC_ROLL_P".to_owned(), Value::Real(4.0))];
        let upload = Upload::new(&of, gains, Some(&file));
        let has = |name: &str| upload.parameters.get(name).copied();
        for (name, value) in wanted(&of) {
            let expected = if name == "MPC_XY_VEL_MAX" { Value::Real(20.0) } else { value };
            assert_eq!(has(name), Some(expected), "{name}");
        }
        assert_eq!(has("MC_PITCH_P"), Some(Value::Real(6.5)));
        assert_eq!(has("MC_ROLL_P"), Some(Value::Real(4.0)), "the file's is of another component");
        assert_eq!((has("CAL_ACC0_ID"), has("MAV_SYS_ID")), (None, None));
        // Only looked at: what the file says is sent, and found wanting once it is there.
        assert_eq!(has("MPC_THR_MAX"), Some(Value::Real(0.5)));
        let said = upload.remarks.join("\n");
        for words in [
            "COM_DISARM_PRFLT = 10 is not sent, -1 stands",
            "EKF2_GPS_CHECK = 245",
            "CAL_ACC0_ID, MAV_SYS_ID: not sent",
        ] {
            assert!(said.contains(words), "{words} in {said}");
        }
    }
}
