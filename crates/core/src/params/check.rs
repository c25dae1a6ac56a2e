//! Parameters against PX4's types and ranges.

use super::against::{Against, NamedBy};
use super::file::Value;
use super::metadata::{Kind, Metadata, Parameter};
use super::purpose::Purpose;

/// Kind of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// The value is outside the stated range, but a drop needs it and PX4 takes it.
    Needed,
    /// The value is outside the stated range.
    Outside,
    /// An integer where PX4 has a float, or the other way round: PX4 does not load it.
    WrongType,
    /// Other versions have the parameter, or have it so, not this one: PX4 passes over it.
    OtherVersion,
    /// No version has the parameter, but one whose name is nearly the same.
    Misspelt,
}

impl Class {
    /// Name of the class in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Needed => "needed",
            Self::Outside => "outside",
            Self::WrongType => "wrong_type",
            Self::OtherVersion => "other_version",
            Self::Misspelt => "misspelt",
        }
    }
}

/// A remark on a parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Name of the parameter.
    pub name: String,
    /// Value of the parameter.
    pub value: Value,
    /// Kind of the finding.
    pub class: Class,
    /// Range stated by PX4, in words; empty for what the version does not have.
    pub range: String,
    /// Unit stated by PX4; empty for none.
    pub unit: &'static str,
    /// Reason, or what to do about it.
    pub advice: String,
}

impl Finding {
    /// The finding in words, with name, value and range.
    pub fn text(&self) -> String {
        let unit = if self.unit.is_empty() { String::new() } else { format!(" {}", self.unit) };
        let (name, value, range) = (&self.name, self.value, &self.range);
        let advice = if self.advice.is_empty() { String::new() } else { format!("; {}", self.advice) };
        match self.class {
            Class::Needed => format!("{name} = {value}{unit} is needed, PX4's range is {range}{advice}"),
            Class::Outside => format!("{name} = {value}{unit} is outside PX4's range, {range}{advice}"),
            Class::WrongType => format!("{name} = {value} has the wrong type{advice}"),
            Class::OtherVersion => format!("{name} is {}", self.advice),
            Class::Misspelt => format!("{name} is in no version of PX4{advice}"),
        }
    }
}

/// The result of a check.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// The version of PX4 that was held against.
    pub against: Against,
    /// Purpose that the file states; `None` when it states none.
    pub purpose: Option<Purpose>,
    /// Number of parameters that the version has.
    pub known: usize,
    /// Number of parameters that the version does not have, and that are so not checked.
    pub unknown: usize,
    /// Findings in the parameters' order.
    pub findings: Vec<Finding>,
}

impl Check {
    /// Whether the file may be loaded for its purpose: something of it was checked, types are right, no name
    /// is misspelt, and no value is outside its range unless a drop needs it. PX4's ranges do not bind
    /// samara's autopilot.
    pub fn passes(&self) -> bool {
        let fails = |f: &Finding| match f.class {
            Class::WrongType | Class::Misspelt => true,
            Class::Outside => self.purpose != Some(Purpose::Samara),
            Class::Needed | Class::OtherVersion => false,
        };
        self.known > 0 && !self.findings.iter().any(fails)
    }

    /// Number of findings of a class.
    pub fn count(&self, class: Class) -> usize {
        self.findings.iter().filter(|f| f.class == class).count()
    }
}

/// Values that a drop needs and PX4 takes (it clips to them or multiplies with them as they are) though they
/// are outside the stated range: name, whether the value may be so, reason.
type Need = (&'static str, fn(&Parameter, f64) -> bool, &'static str);
const NEEDED: [Need; 3] = [
    ("MPC_Z_VEL_MAX_DN", above, "PX4 clips the descent setpoint to it and takes it as it is"),
    ("MPC_XY_VEL_MAX", above, "PX4 clips horizontal velocity setpoints to it and takes it as it is"),
    ("MPC_XY_VEL_D_ACC", zero, "the law that the gains are for has no derivative term"),
];

fn above(parameter: &Parameter, value: f64) -> bool {
    parameter.max.is_some_and(|max| value > f64::from(max))
}

fn zero(_: &Parameter, value: f64) -> bool {
    value == 0.0
}

/// Checks parameters against the types and ranges of a version of PX4; names in ascending order give findings
/// in that order.
pub fn check<'a>(
    against: Against,
    purpose: Option<Purpose>,
    parameters: impl Iterator<Item = (&'a str, Value)>,
) -> Check {
    let metadata = against.metadata;
    let mut result = Check { against, purpose, known: 0, unknown: 0, findings: Vec::new() };
    for (name, value) in parameters {
        let known = metadata.get(name);
        *if known.is_some() { &mut result.known } else { &mut result.unknown } += 1;
        let found = match &known {
            Some(known) => judge(against, known, name, value),
            None => of_another_version(metadata, name).or_else(|| misspelt(metadata, name)),
        };
        result.findings.extend(found.map(|(class, advice)| Finding {
            name: name.to_owned(),
            value,
            class,
            range: known.map_or(String::new(), |p| p.range()),
            unit: known.map_or("", |p| p.unit),
            advice,
        }));
    }
    result
}

/// A parameter of other versions: which those are, and what has its place in this one.
fn of_another_version(metadata: Metadata, name: &str) -> Option<(Class, String)> {
    let has_it = match metadata.nearest(name) {
        Some(p) if p.last < metadata.version() => format!("not there; {} was the last that had it", p.last),
        Some(p) => format!("not there; {} is the first that has it", p.first),
        None if Metadata::is_older(name) => {
            format!("not there; only versions before {} had it", Metadata::OLDEST)
        }
        None => return None,
    };
    let instead = metadata.successor(name);
    let instead = instead.map(|new| format!("; {new} has its place, whose numbers may mean something else"));
    Some((Class::OtherVersion, has_it + &instead.unwrap_or_default()))
}

fn misspelt(metadata: Metadata, name: &str) -> Option<(Class, String)> {
    metadata.meant(name).map(|meant| (Class::Misspelt, format!("did you mean {meant}?")))
}

fn judge(against: Against, known: &Parameter, name: &str, value: Value) -> Option<(Class, String)> {
    let (metadata, number, kind) = (against.metadata, value.as_f64(), Kind::of(value));
    if kind != known.kind {
        let expected = format!("{} is expected", known.kind.words());
        // A file that names no version may be of one that has it so.
        let may_be = against.by == NamedBy::Nothing && Metadata::is_ever(name, kind);
        return Some(match may_be {
            true => (Class::OtherVersion, format!("of {} in other versions; {expected}", kind.words())),
            false => (Class::WrongType, expected),
        });
    }
    if known.contains(number) {
        return None;
    }
    if let Some((_, _, reason)) = NEEDED.iter().find(|(n, allowed, _)| *n == name && allowed(known, number)) {
        return Some((Class::Needed, (*reason).to_owned()));
    }
    Some((Class::Outside, advice(metadata, known, name, number)))
}

/// Advice on a value outside its range: to move a part of a rate loop's P to K, else the end of the range.
fn advice(metadata: Metadata, known: &Parameter, name: &str, value: f64) -> String {
    let Some(rate_loop) = name.strip_suffix("RATE_P") else {
        let end = if above(known, value) { known.max } else { known.min };
        return end.map_or(String::new(), |end| {
            format!("a ground station warns of it; the nearest within is {end}")
        });
    };
    let k_name = format!("{rate_loop}RATE_K");
    match overall_gain(metadata, &k_name, name, value) {
        Some(k) => {
            format!("the same law: {k_name} times {k}, P, I and D divided by it ({name} = {:.4})", value / k)
        }
        None => format!("no {k_name} in its range brings it in"),
    }
}

/// The overall gain K that brings `P = p/K` of a rate loop into its range: 1 when it is there, else the power
/// of two nearest to 1 (which costs no digit), else an end of K's own range; `None` when nothing helps.
pub(super) fn overall_gain(metadata: Metadata, k_name: &str, p_name: &str, p: f64) -> Option<f64> {
    let (of_p, of_k) = (metadata.get(p_name)?, metadata.get(k_name)?);
    let fits = |k: f64| of_k.contains(k) && of_p.contains(f64::from((p / k) as f32));
    let powers = (1..=8).flat_map(|n| [2f64.powi(n), 2f64.powi(-n)]);
    let ends = [of_k.max, of_k.min].into_iter().flatten().map(f64::from);
    std::iter::once(1.0).chain(powers).chain(ends).find(|k| fits(*k))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::px4::versions::Number;

    fn findings(purpose: Option<Purpose>, rows: &[(&str, Value)]) -> Check {
        check(Against::newest(), purpose, rows.iter().copied())
    }

    #[test]
    fn the_classes() {
        use Value::{Int, Real};
        let result = findings(
            None,
            &[
                ("MC_PITCHRATE_P", Real(0.707)),
                ("MC_PITCH_P", Int(4)),
                ("MC_PR_INT_LIM", Real(30.0)),
                ("MC_ROLLRATE_P", Real(0.5)),
                ("MPC_SPOOLUP_TIME", Real(1.0)),
                ("MPC_XY_VEL_D_ACC", Real(0.0)),
                ("MPC_Z_VEL_MAX_DN", Real(5.0)),
                ("MPC_Z_VEL_MAX_UP", Real(9.0)),
                ("SYS_AUTOSTART", Real(4001.0)),
                ("UAVCAN_ENABLE", Int(0)),
            ],
        );
        let classes: Vec<(&str, Class)> =
            result.findings.iter().map(|f| (f.name.as_str(), f.class)).collect();
        assert_eq!(
            classes,
            [
                ("MC_PITCHRATE_P", Class::Outside),
                ("MC_PITCH_P", Class::WrongType),
                ("MPC_SPOOLUP_TIME", Class::OtherVersion),
                ("MPC_XY_VEL_D_ACC", Class::Needed),
                ("MPC_Z_VEL_MAX_DN", Class::Needed),
                ("MPC_Z_VEL_MAX_UP", Class::Outside),
                ("SYS_AUTOSTART", Class::WrongType),
            ]
        );
        assert_eq!((result.known, result.unknown), (9, 1));
        let text = result.findings[0].text();
        assert!(text.contains("0.01 to 0.6") && text.contains("MC_PITCHRATE_K times 2"), "{text}");
        assert!(text.contains("MC_PITCHRATE_P = 0.3535"), "{text}");
        assert!(
            result.findings[5].text().ends_with("the nearest within is 8"),
            "{}",
            result.findings[5].text()
        );
        let low = findings(None, &[("MPC_Z_VEL_I_ACC", Real(0.005))]).findings[0].text();
        assert!(low.ends_with("the nearest within is 0.2"), "{low}");
        let hopeless = findings(None, &[("MC_YAWRATE_P", Real(11.0))]).findings[0].text();
        assert!(hopeless.contains("no MC_YAWRATE_K"), "{hopeless}");
    }

    /// RC1_REV was a real number up to v1.17 and is a whole one since: wrong where the version is named.
    #[test]
    fn a_type_is_wrong_by_a_version_that_is_named() {
        let number = |minor| Number { major: 1, minor };
        let of = |against| {
            let check = check(against, None, [("RC1_REV", Value::Real(1.0))].into_iter());
            (check.passes(), check.findings.first().map(Finding::text))
        };
        assert_eq!(of(Against::asked(number(17))), (true, None));
        let wrong = "RC1_REV = 1 has the wrong type; type 6 (INT32) is expected".to_owned();
        assert_eq!(of(Against::flown(number(18))), (false, Some(wrong)));
        let other = "RC1_REV is of type 9 (REAL32) in other versions; type 6 (INT32) is expected".to_owned();
        assert_eq!(of(Against::newest()), (true, Some(other)));
    }

    #[test]
    fn needed_values_pass_and_others_do_not() {
        let passes = |purpose, name, x| findings(purpose, &[(name, Value::Real(x))]).passes();
        assert!(passes(None, "MPC_Z_VEL_MAX_DN", 5.0));
        assert!(!passes(None, "MPC_Z_VEL_MAX_DN", 0.1), "too small is not needed");
        assert!(!passes(None, "MPC_Z_VEL_MAX_UP", 9.0));
        assert!(!passes(Some(Purpose::Px4), "MPC_XY_VEL_P_ACC", 0.8));
        assert!(passes(Some(Purpose::Samara), "MPC_XY_VEL_P_ACC", 0.8));
    }
}
