//! PX4's description of its parameters, by version: type, default and range, from PX4's own metadata; unit,
//! decimals and meaning in samara's words, of those that it has to do with.
//!
//! | file | holds |
//! |---|---|
//! | `px4_parameters.csv` | a line for each interval of versions in which a parameter is the same |
//! | `about.csv` | unit, decimals, meaning; a `#` in a name stands for a rotor's number |
//! | `renamed.csv` | names that versions have given up, with what took their place, by hand |
//!
//! All are sorted by name, and searched where they stand: nothing is loaded. `scripts/px4_parameters` makes
//! the first from checkouts of PX4.

use std::str::Lines;

use super::file::Value;
use crate::control::px4::versions::Number;

const INTERVALS: &str = include_str!("px4_parameters.csv");
const ABOUT: &str = include_str!("about.csv");
const RENAMED: &str = include_str!("renamed.csv");

/// Type of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// 32-bit integer.
    Int,
    /// Single precision.
    Float,
}

impl Kind {
    /// The type of a value.
    pub fn of(value: Value) -> Self {
        match value {
            Value::Int(_) => Self::Int,
            Value::Real(_) => Self::Float,
        }
    }

    /// The type in MAVLink's words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Int => "type 6 (INT32)",
            Self::Float => "type 9 (REAL32)",
        }
    }

    /// Zero in this type.
    pub fn zero(self) -> Value {
        match self {
            Self::Int => Value::Int(0),
            Self::Float => Value::Real(0.0),
        }
    }
}

/// One parameter, as some versions have it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Name of the parameter.
    pub name: &'static str,
    /// Type of the value.
    pub kind: Kind,
    /// Value unless it is set.
    pub default: f32,
    /// Unit as PX4 writes it; empty for none, or where it is not known.
    pub unit: &'static str,
    /// Least value; `None`: unlimited.
    pub min: Option<f32>,
    /// Greatest value; `None`: unlimited.
    pub max: Option<f32>,
    /// Number of decimals that a ground station shows.
    pub decimals: Option<usize>,
    /// The first version that has it so.
    pub first: Number,
    /// The last version that has it so.
    pub last: Number,
    /// Description in a few words; may be empty.
    pub description: &'static str,
}

impl Parameter {
    /// Whether a value lies in the stated range, ends included.
    pub fn contains(&self, value: f64) -> bool {
        self.min.is_none_or(|min| f64::from(min) <= value)
            && self.max.is_none_or(|max| value <= f64::from(max))
    }

    /// The range in words: `0.01 to 0.6`, `at least 0`.
    pub fn range(&self) -> String {
        match (self.min, self.max) {
            (Some(min), Some(max)) => format!("{min} to {max}"),
            (Some(min), None) => format!("at least {min}"),
            (None, Some(max)) => format!("at most {max}"),
            (None, None) => "any".to_owned(),
        }
    }
}

/// PX4's parameters by name, of one of its versions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Metadata {
    version: Number,
}

impl Metadata {
    /// The oldest version that is known.
    pub const OLDEST: Number = Number { major: 1, minor: 12 };
    /// The newest version that is known.
    pub const NEWEST: Number = Number { major: 1, minor: 18 };

    /// The parameters of a version; of one that is not known, those of the nearest that is.
    pub fn of(version: Number) -> Self {
        Self { version: version.clamp(Self::OLDEST, Self::NEWEST) }
    }

    /// The parameters of the newest version.
    pub fn newest() -> Self {
        Self::of(Self::NEWEST)
    }

    /// The versions that are known, oldest first.
    pub fn versions() -> impl Iterator<Item = Number> {
        let Number { major, minor } = Self::OLDEST;
        (minor..=Self::NEWEST.minor).map(move |minor| Number { major, minor })
    }

    /// The version.
    pub fn version(self) -> Number {
        self.version
    }

    /// The parameter of that name; `None` where the version has none.
    pub fn get(self, name: &str) -> Option<Parameter> {
        of_all_versions(name).find(|p| p.first <= self.version && self.version <= p.last)
    }

    /// The parameter of that name, as the version has it or the nearest that does; `None` where none does.
    pub fn nearest(self, name: &str) -> Option<Parameter> {
        let away = |p: &Parameter| {
            let [from, to, at] = [p.first, p.last, self.version].map(|number| i16::from(number.minor));
            (from - at).max(at - to).max(0)
        };
        of_all_versions(name).min_by_key(away)
    }

    /// Whether any version has the parameter in a type.
    pub fn is_ever(name: &str, kind: Kind) -> bool {
        of_all_versions(name).any(|p| p.kind == kind)
    }

    /// What has taken the place of an old name in the version; `None` where nothing has.
    pub fn successor(self, name: &str) -> Option<&'static str> {
        let to = lines_of(RENAMED, name).next()?.split(',').nth(1)?;
        self.get(to).is_some().then_some(to)
    }

    /// Whether only versions before the oldest that is known had the name.
    pub fn is_older(name: &str) -> bool {
        lines_of(RENAMED, name).next().is_some() && of_all_versions(name).next().is_none()
    }

    /// The name that was probably meant by one that no version has: it differs in capitals or in one letter,
    /// which is wrong, missing, too much or in its neighbour's place.
    pub fn meant(self, name: &str) -> Option<&'static str> {
        let typed = name.to_ascii_uppercase();
        let of = |fits: &dyn Fn(&str) -> bool| {
            let names = body(INTERVALS).lines().filter_map(|line| line.split(',').next());
            names.filter(|known| fits(known)).find(|known| self.get(known).is_some())
        };
        of(&|known| known == typed)
            .or_else(|| of(&|known| is_one_letter_off(typed.as_bytes(), known.as_bytes())))
    }

    /// All parameters in the order of their names.
    pub fn iter(self) -> impl Iterator<Item = Parameter> {
        let all = body(INTERVALS).lines().filter_map(interval);
        all.filter(move |p| p.first <= self.version && self.version <= p.last)
    }
}

/// A parameter in all versions that have it, oldest first; of a rotor's by `#`, as the first rotor's.
fn of_all_versions(name: &str) -> impl Iterator<Item = Parameter> + use<> {
    lines_of(INTERVALS, &name.replace('#', "0")).filter_map(interval)
}

/// A table without its head.
fn body(table: &'static str) -> &'static str {
    table.split_once('\n').map_or("", |(_, body)| body)
}

/// The lines of a sorted table that begin with a name, in their order.
fn lines_of(table: &'static str, name: &str) -> Lines<'static> {
    let table = body(table);
    let key = |line: &str| line.split(',').next().unwrap_or_default().cmp(name);
    let (mut low, mut high) = (0, table.len());
    while low < high {
        let middle = low + (high - low) / 2;
        let start = table[..middle].rfind('\n').map_or(0, |end| end + 1);
        let line = table[start..].lines().next().unwrap_or_default();
        if key(line).is_lt() {
            low = start + line.len() + 1;
        } else {
            high = start;
        }
    }
    let rest = table.get(low..).unwrap_or_default();
    let own = rest.lines().take_while(|line| key(line).is_eq()).map(|line| line.len() + 1).sum();
    rest.get(..own).unwrap_or(rest).lines()
}

fn interval(line: &'static str) -> Option<Parameter> {
    let optional =
        |text: &'static str| if text.is_empty() { Some(None) } else { text.parse().ok().map(Some) };
    let fields: Vec<&'static str> = line.split(',').collect();
    let &[name, kind, default, min, max, first, last] = fields.as_slice() else { return None };
    let (unit, decimals, description) = about(name).unwrap_or_default();
    Some(Parameter {
        name,
        kind: match kind {
            "INT32" => Kind::Int,
            "FLOAT" => Kind::Float,
            _ => return None,
        },
        default: default.parse().ok()?,
        unit,
        min: optional(min)?,
        max: optional(max)?,
        decimals,
        first: first.parse().ok()?,
        last: last.parse().ok()?,
        description,
    })
}

/// Unit, decimals and description of a parameter.
fn about(name: &str) -> Option<(&'static str, Option<usize>, &'static str)> {
    let digits = |c: char| c.is_ascii_digit();
    let of_any_rotor = || {
        let (before, after) = name.split_once(digits)?;
        lines_of(ABOUT, &format!("{before}#{}", after.trim_start_matches(digits))).next()
    };
    let line = lines_of(ABOUT, name).next().or_else(of_any_rotor)?;
    let mut fields = line.splitn(4, ',').skip(1);
    Some((fields.next()?, fields.next()?.parse().ok(), fields.next()?))
}

/// Whether one word becomes the other by one letter. Digits tell parameters from one another: a name that
/// differs in one is another one's.
fn is_one_letter_off(a: &[u8], b: &[u8]) -> bool {
    if a.len().abs_diff(b.len()) > 1 || a == b {
        return false;
    }
    let same = a.iter().zip(b).take_while(|(x, y)| x == y).count();
    let (a, b) = (&a[same..], &b[same..]);
    let swapped = matches!((a, b), ([x, y, rest @ ..], [v, w, tail @ ..]) if (x, y, rest) == (w, v, tail));
    let (longer, shorter) = if a.len() < b.len() { (b, a) } else { (a, b) };
    let other = match longer.len() - shorter.len() {
        0 => longer[1..] == shorter[1..] && !shorter[0].is_ascii_digit(),
        _ => longer[1..] == *shorter,
    };
    (other || swapped) && !longer[0].is_ascii_digit()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::px4::Parameters;
    use crate::params::{Against, check};
    use crate::tune::px4::space::{names, parameters, widest};

    fn v(minor: u8) -> Metadata {
        Metadata::of(Number { major: 1, minor })
    }

    fn all() -> impl Iterator<Item = Metadata> {
        Metadata::versions().map(Metadata::of)
    }

    /// The default of each parameter lies in its range, in each version.
    #[test]
    fn prop_px4s_defaults_pass_in_their_version() {
        for metadata in all() {
            let number = metadata.version();
            let rows = metadata.iter().map(|p| match p.kind {
                Kind::Int => (p.name, Value::Int(p.default as i32)),
                Kind::Float => (p.name, Value::Real(p.default)),
            });
            let check = check(Against::asked(number), None, rows);
            assert_eq!(check.findings, [], "{number}");
            assert_eq!((check.known, check.unknown), (metadata.iter().count(), 0));
            assert!(check.known > 1500, "{number}: {}", check.known);
        }
    }

    /// All lines are understood; a name's intervals are in order and do not meet.
    #[test]
    fn every_line_of_the_tables_is_understood() {
        let intervals: Vec<Parameter> = body(INTERVALS).lines().filter_map(interval).collect();
        assert_eq!(intervals.len(), INTERVALS.lines().count() - 1);
        let in_order = |a: &Parameter, b: &Parameter| a.name < b.name || a.name == b.name && a.last < b.first;
        assert!(intervals.is_sorted_by(in_order) && INTERVALS.is_ascii());
        for p in &intervals {
            assert!(Metadata::OLDEST <= p.first && p.first <= p.last && p.last <= Metadata::NEWEST, "{p:?}");
        }
        for table in [ABOUT, RENAMED] {
            assert!(
                table.is_ascii() && body(table).lines().is_sorted_by(|a, b| a.split(',').lt(b.split(',')))
            );
        }
        for line in body(ABOUT).lines() {
            let name = line.split(',').next().unwrap();
            let p = v(18).nearest(name).unwrap_or_else(|| panic!("{name}"));
            assert_eq!(p.description, line.splitn(4, ',').nth(3).unwrap());
        }
        for line in body(RENAMED).lines() {
            let (from, to) = line.split_once(',').unwrap();
            let (is_gone, is_there) =
                (|m: Metadata| m.get(from).is_none(), |m: Metadata| m.successor(from) == Some(to));
            assert!(all().any(|m| is_gone(m) && (to.is_empty() || is_there(m))), "{line}");
        }
    }

    /// Each parameter is found by its name in each version, which is what going through all lines says.
    #[test]
    fn prop_a_parameter_is_found_by_its_name() {
        for metadata in all() {
            for p in metadata.iter() {
                assert_eq!(metadata.get(p.name), Some(p));
            }
        }
    }

    /// PX4's sources at v1.12.3, v1.14.4, v1.16.0, v1.17.0-beta1 and v1.18.0-beta1.
    #[test]
    fn reference_what_versions_say_differently() {
        for (name, minor, value, allowed) in [
            ("EKF2_GPS_CHECK", 12, 511.0, true),
            ("EKF2_GPS_CHECK", 12, 1023.0, false),
            ("EKF2_GPS_CHECK", 16, 1023.0, true),
            ("EKF2_GPS_CHECK", 17, 2047.0, true),
            ("COM_FLTMODE1", 14, 100.0, false),
            ("COM_FLTMODE1", 16, 100.0, true),
            ("MIS_TKO_LAND_REQ", 14, 5.0, false),
            ("MIS_TKO_LAND_REQ", 16, 5.0, true),
            ("COM_RC_OVERRIDE", 12, 7.0, true),
            ("COM_RC_OVERRIDE", 16, 7.0, false),
            ("COM_OBL_RC_ACT", 12, -1.0, true),
            ("COM_OBL_RC_ACT", 16, -1.0, false),
            ("MIS_DIST_1WP", 16, 100_000.0, true),
            ("MIS_DIST_1WP", 14, 100_000.0, false),
            ("NAV_LOITER_RAD", 17, -80.0, true),
            ("NAV_LOITER_RAD", 16, -80.0, false),
            ("EKF2_BCOEF_X", 14, 200.0, true),
            ("EKF2_BCOEF_X", 12, 200.0, false),
            ("MPC_MAN_TILT_MAX", 14, 90.0, true),
            ("MPC_MAN_TILT_MAX", 16, 90.0, false),
            ("MPC_THR_MIN", 14, 1.0, true),
            ("MPC_THR_MIN", 16, 1.0, false),
            ("MC_YAWRATE_K", 16, 0.0, true),
        ] {
            assert_eq!(v(minor).get(name).unwrap().contains(value), allowed, "{name} {value} v1.{minor}");
        }
        assert_eq!(v(16).get("EKF2_GPS_CHECK").unwrap().default, 1023.0);
        assert_eq!(v(18).get("SENS_GPS0_DELAY").unwrap().kind, Kind::Int);
        assert_eq!(v(17).get("EKF2_GPS_DELAY").unwrap().kind, Kind::Float);
        assert_eq!((v(17).get("SENS_GPS0_DELAY"), v(18).get("EKF2_GPS_DELAY")), (None, None));
        for (name, lasts) in [("COM_OBL_ACT", 13), ("EKF2_AID_MASK", 14), ("MPC_HOLD_DZ", 16)] {
            assert!(v(lasts).get(name).is_some() && v(lasts + 1).get(name).is_none(), "{name}");
        }
    }

    /// The ends of what a search for PX4's gains takes are in the range of every version.
    #[test]
    fn reference_what_is_searched_is_in_the_range_of_every_version() {
        let bounds = widest(89.0);
        for ends in [bounds.map(|(least, _)| least), bounds.map(|(_, most)| most)] {
            let made = parameters(&Parameters::default(), &ends);
            for name in names() {
                let value = f64::from(made.get(name).unwrap() as f32);
                assert!(all().all(|m| m.get(name).unwrap().contains(value)), "{name} = {value}");
            }
        }
    }

    #[test]
    fn reference_rows() {
        let p = v(18).get("MC_PITCHRATE_P").unwrap();
        assert_eq!(
            (p.kind, p.default, p.min, p.max, p.decimals),
            (Kind::Float, 0.15, Some(0.01), Some(0.6), Some(3))
        );
        assert_eq!(p.range(), "0.01 to 0.6");
        assert!(p.contains(f64::from(0.6f32)) && !p.contains(0.61) && !p.contains(f64::NAN));
        assert_eq!(v(18).get("MC_PR_INT_LIM").unwrap().range(), "at least 0");
        for rotor in ["CA_ROTOR0_KM", "CA_ROTOR11_KM", "CA_ROTOR#_KM"] {
            let p = v(18).get(rotor).unwrap();
            assert_eq!((p.max, p.unit), (Some(1.0), "m"));
        }
        for unknown in ["CA_ROTOR12_KM", "CA_ROTOR00_KM", "CA_ROTOR_KM", "", "CA_ROTOR999999_KM", "#", "name"]
        {
            assert_eq!(v(18).get(unknown), None, "{unknown}");
        }
    }

    #[test]
    fn a_version_that_is_not_known_is_the_nearest() {
        let number = |major, minor| Metadata::of(Number { major, minor }).version().to_string();
        assert_eq!([number(1, 10), number(1, 15), number(2, 0)], ["v1.12", "v1.15", "v1.18"]);
        let nearest = |minor, name: &str| v(minor).nearest(name).map(|p| (p.first.minor, p.last.minor));
        assert_eq!(nearest(18, "MPC_HOLD_DZ"), Some((12, 16)));
        assert_eq!(nearest(12, "SENS_GPS0_DELAY"), Some((18, 18)));
        assert_eq!(nearest(12, "NOT_THERE"), None);
        let ever = |name| [Kind::Int, Kind::Float].map(|kind| Metadata::is_ever(name, kind));
        assert_eq!((ever("RC1_REV"), ever("SENS_GPS0_DELAY")), ([true; 2], [true, false]));
    }

    /// One letter by hand; another digit is another parameter.
    #[test]
    fn closed_form_what_was_probably_meant() {
        for (typed, meant) in [
            ("mpc_xy_vel_p_acc", Some("MPC_XY_VEL_P_ACC")),
            ("MPC_XY_VEL_P_AC", Some("MPC_XY_VEL_P_ACC")),
            ("MPC_XY_VELL_P_ACC", Some("MPC_XY_VEL_P_ACC")),
            ("MPC_XY_VEL_PACC", Some("MPC_XY_VEL_P_ACC")),
            ("MC_PTICH_P", Some("MC_PITCH_P")),
            ("MC_RITCH_P", Some("MC_PITCH_P")),
            ("CAL_ACC9_ID", None),
            ("CA_ROTOR12_PX", None),
            ("BAT_N_CELLS", None),
            ("FOO_BAR", None),
            ("", None),
        ] {
            assert_eq!(v(18).meant(typed), meant, "{typed}");
        }
    }
}
