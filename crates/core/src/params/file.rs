//! Parameters as a file holds them, whatever its format ([`super::reading`]), and QGroundControl's format
//! written.

use std::collections::BTreeMap;

use super::purpose::Purpose;
use crate::control::px4::versions::Number;

/// A whole number stands for a real one that is no further from it than by this share.
const NEAREST: f64 = 0.01;

/// A parameter's value in one of PX4's two types.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// 32-bit integer, MAVLink type 6.
    Int(i32),
    /// Single precision, MAVLink type 9.
    Real(f32),
}

impl Value {
    /// The value as a double, exactly.
    pub fn as_f64(self) -> f64 {
        match self {
            Self::Int(i) => f64::from(i),
            Self::Real(x) => f64::from(x),
        }
    }

    /// The value in the type of another one; `None` where that type has not got it. A real number goes as the
    /// nearest whole one where that is less than a hundredth of it away: a time of 112.4 ms is one of 112.
    #[must_use]
    pub fn in_type_of(self, other: Self) -> Option<Self> {
        match (self, other) {
            (Self::Int(i), Self::Real(_)) => {
                let x = i as f32;
                (f64::from(x) == f64::from(i)).then_some(Self::Real(x))
            }
            (Self::Real(x), Self::Int(_)) => {
                let i = f64::from(x).round();
                let is_near = (i - f64::from(x)).abs() <= NEAREST * f64::from(x).abs();
                let fits = (f64::from(i32::MIN)..=f64::from(i32::MAX)).contains(&i);
                (is_near && fits).then_some(Self::Int(i as i32))
            }
            _ => Some(self),
        }
    }

    /// MAVLink's number of the type: 6 for integers, 9 for single precision.
    pub fn mavlink_type(self) -> u8 {
        match self {
            Self::Int(_) => 6,
            Self::Real(_) => 9,
        }
    }
}

/// Writes the shortest text that gives the value again.
impl std::fmt::Display for Value {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Self::Int(i) => i.fmt(f),
            Self::Real(x) => x.fmt(f),
        }
    }
}

/// The autopilot's own component; others (a gimbal, a radio) keep parameters under the same names.
pub const AUTOPILOT_COMPONENT: u8 = 1;

/// A parameter as a file holds it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// Value of the parameter.
    pub value: Value,
    /// Line of the file, from 1; of a flight log's, its number there.
    pub line: usize,
}

/// The parameters of a file, what it says of itself, and remarks.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ParameterFile {
    entries: BTreeMap<(u8, String), Entry>,
    header: BTreeMap<String, String>,
    purpose: Option<Purpose>,
    remarks: Vec<String>,
    scripts: Vec<(usize, String)>,
}

impl ParameterFile {
    /// Key of the version of PX4 that an exported file is for.
    pub const PX4: &str = "PX4";

    /// A component's parameter, in place of what stands under its name; that, where it stands there.
    pub(super) fn put(&mut self, component: u8, name: &str, entry: Entry) -> Option<Entry> {
        self.entries.insert((component, name.to_owned()), entry)
    }

    /// Takes what the file says of itself; what it has said before stands.
    pub(super) fn say(&mut self, key: &str, value: &str) {
        self.header.entry(key.to_owned()).or_insert_with(|| value.to_owned());
    }

    /// Takes the purpose that the file states.
    pub(super) fn say_purpose(&mut self, purpose: Purpose) {
        self.purpose = Some(purpose);
    }

    /// Takes remarks on the file.
    pub(super) fn remark(&mut self, remarks: impl IntoIterator<Item = String>) {
        self.remarks.extend(remarks);
    }

    /// Takes a script that the file runs on a line, from 1.
    pub(super) fn run(&mut self, line: usize, script: &str) {
        self.scripts.push((line, script.to_owned()));
    }

    /// Scripts that a script runs, each with its line, from 1: the words behind `.` or `source`. They are not
    /// read.
    pub fn scripts(&self) -> &[(usize, String)] {
        &self.scripts
    }

    /// The purpose that the header states; `None` when it states none.
    pub fn purpose(&self) -> Option<Purpose> {
        self.purpose
    }

    /// The header's value of a key, as in `# Key: value`.
    pub fn header(&self, key: &str) -> Option<&str> {
        self.header.get(key).map(String::as_str)
    }

    /// The version of PX4 that the file names, as QGroundControl (`# Version: 1.16.0`) or samara (`# PX4:
    /// v1.16`) does; `None` where it names none.
    pub fn version(&self) -> Option<Number> {
        let text = self.header(Self::PX4).or_else(|| self.header("Version"))?.trim_start_matches('v');
        let end = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
        text[..end].parse().ok()
    }

    /// Whether the file says that it is of PX4.
    pub fn is_of_px4(&self) -> bool {
        self.header("Stack").is_some_and(|stack| stack.starts_with("PX4"))
    }

    /// Oddities that are no reason to refuse the file.
    pub fn remarks(&self) -> &[String] {
        &self.remarks
    }

    /// The autopilot's parameter of that name.
    pub fn get(&self, name: &str) -> Option<Value> {
        self.entry(AUTOPILOT_COMPONENT, name).map(|e| e.value)
    }

    /// A component's parameter of that name.
    pub fn entry(&self, component: u8, name: &str) -> Option<&Entry> {
        self.entries.get(&(component, name.to_owned()))
    }

    /// All parameters as component, name and entry, by component, then name.
    pub fn entries(&self) -> impl Iterator<Item = (u8, &str, &Entry)> {
        self.entries.iter().map(|((component, name), entry)| (*component, name.as_str(), entry))
    }

    /// The autopilot's own parameters as name and entry, by name.
    pub fn own(&self) -> impl Iterator<Item = (&str, &Entry)> {
        let own = |(component, name, entry)| (component == AUTOPILOT_COMPONENT).then_some((name, entry));
        self.entries().filter_map(own)
    }

    /// Number of parameters.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Whether the file holds no parameter.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }
}

/// Text of a file for vehicle 1: QGroundControl's header with `notes` in it, then the autopilot's parameters
/// by name.
pub fn write(version: &str, notes: &[String], parameters: &BTreeMap<String, Value>) -> String {
    let mut text = format!(
        "# Onboard parameters for Vehicle 1\n#\n# Stack: PX4 Pro\n# Vehicle: Multi-Rotor\n# Version: {version}\n\
         # Git Revision: none\n#\n"
    );
    for note in notes {
        text += &format!("# {note}\n");
    }
    if !notes.is_empty() {
        text += "#\n";
    }
    text += "# Vehicle-Id Component-Id Name Value Type\n";
    for (name, value) in parameters {
        let number = match value {
            Value::Int(i) => i.to_string(),
            // Adding 0 turns -0 into 0.
            Value::Real(x) => format!("{:.18}", f64::from(*x) + 0.0),
        };
        text += &format!("1\t{AUTOPILOT_COMPONENT}\t{name}\t{number}\t{}\n", value.mavlink_type());
    }
    text
}
