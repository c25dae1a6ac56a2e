//! QGroundControl's parameter file.
//!
//! A `#` header, then rows `vehicle id <tab> component id <tab> name <tab> value <tab> type`, sorted by name;
//! type 6 is a 32-bit integer, 9 single precision. QGroundControl writes a float as the double that equals
//! it, with 18 decimals. The reader takes any origin: LF or CRLF, any vehicle id, `%g` values, no header.
//! Header lines `# Key: value` are kept: [`crate::params::purpose`] says which ones samara writes.

use std::collections::BTreeMap;

use super::ParamsError;
use super::purpose::Purpose;

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
    /// Line of the file, from 1.
    pub line: usize,
}

/// The parameters, header and remarks of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ParameterFile {
    entries: BTreeMap<(u8, String), Entry>,
    header: BTreeMap<String, String>,
    purpose: Option<Purpose>,
    remarks: Vec<String>,
}

impl ParameterFile {
    /// Parses a file's text.
    ///
    /// # Errors
    /// [`ParamsError`] with the line that is wrong.
    pub fn parse(text: &str) -> Result<Self, ParamsError> {
        let mut file = Self::default();
        let (mut vehicles, mut spaced) = (BTreeMap::<u8, usize>::new(), None);
        for (i, line) in text.strip_prefix('\u{feff}').unwrap_or(text).lines().enumerate() {
            let (number, line) = (i + 1, line.trim());
            if let Some(comment) = line.strip_prefix('#') {
                file.take_comment(number, comment.trim())?;
            } else if !line.is_empty() {
                let (vehicle, (component, name), value) = row(number, line)?;
                vehicles.entry(vehicle).or_insert(number);
                if line.matches('\t').count() != 4 {
                    spaced.get_or_insert(number);
                }
                let entry = Entry { value, line: number };
                if let Some(first) = file.entries.insert((component, name.to_owned()), entry) {
                    return Err(ParamsError::Twice {
                        line: number,
                        name: name.to_owned(),
                        first: first.line,
                    });
                }
            }
        }
        file.remark_on(&vehicles, spaced);
        Ok(file)
    }

    fn take_comment(&mut self, line: usize, comment: &str) -> Result<(), ParamsError> {
        // Comments after the first row are ignored.
        let Some((key, value)) = comment.split_once(':').filter(|_| self.entries.is_empty()) else {
            return Ok(());
        };
        let (key, value) = (key.trim(), value.trim());
        if key == Purpose::KEY {
            let unknown = || ParamsError::UnknownPurpose { line, found: shortened(value) };
            self.purpose = Some(Purpose::from_name(value).ok_or_else(unknown)?);
        }
        self.header.entry(key.to_owned()).or_insert_with(|| value.to_owned());
        Ok(())
    }

    fn remark_on(&mut self, vehicles: &BTreeMap<u8, usize>, spaced: Option<usize>) {
        for (id, line) in vehicles.iter().filter(|(id, _)| **id != 1) {
            self.remarks
                .push(format!("line {line}: vehicle id {id}; QGroundControl loads it into any vehicle"));
        }
        if let Some(line) = spaced {
            self.remarks.push(format!(
                "line {line}: columns are not separated by single tabs; QGroundControl skips such a row"
            ));
        }
        let components = self.entries.keys().map(|(component, _)| *component);
        let mut others: Vec<String> =
            components.filter(|c| *c != AUTOPILOT_COMPONENT).map(|c| c.to_string()).collect();
        others.dedup();
        if !others.is_empty() {
            self.remarks
                .push(format!("parameters of component {} are not the autopilot's", others.join(", ")));
        }
    }

    /// The purpose that the header states; `None` when it states none.
    pub fn purpose(&self) -> Option<Purpose> {
        self.purpose
    }

    /// The header's value of a key, as in `# Key: value`.
    pub fn header(&self, key: &str) -> Option<&str> {
        self.header.get(key).map(String::as_str)
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

/// A row's vehicle id, component id with name, and value.
fn row(line: usize, text: &str) -> Result<(u8, (u8, &str), Value), ParamsError> {
    let columns: Vec<&str> = text.split_whitespace().collect();
    let &[vehicle, component, name, value, kind] = columns.as_slice() else {
        return Err(ParamsError::Columns { line, found: columns.len() });
    };
    let refuse = |column, expected, found: &str| ParamsError::Field {
        line,
        column,
        expected,
        found: shortened(found),
    };
    let id = |column, text: &str| {
        text.parse::<u8>().map_err(|_| refuse(column, "a whole number from 0 to 255", text))
    };
    let named = name.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_') && name.len() <= 16;
    if !named {
        return Err(refuse("name", "at most 16 letters, digits and `_`", name));
    }
    let value = match kind {
        "6" => {
            Value::Int(whole(value).ok_or_else(|| refuse("value", "a 32-bit whole number (type 6)", value))?)
        }
        "9" => match value.parse::<f32>() {
            Ok(x) if x.is_finite() => Value::Real(x),
            _ => return Err(refuse("value", "a finite number in single precision (type 9)", value)),
        },
        _ => return Err(refuse("type", "6 (32-bit integer) or 9 (single precision)", kind)),
    };
    Ok((id("vehicle id", vehicle)?, (id("component id", component)?, name), value))
}

/// A whole number, also when written as `4.0` or `4e3`.
fn whole(text: &str) -> Option<i32> {
    text.parse::<i32>().ok().or_else(|| {
        let x = text.parse::<f64>().ok()?;
        let fits = x.fract() == 0.0 && (f64::from(i32::MIN)..=f64::from(i32::MAX)).contains(&x);
        fits.then_some(x as i32)
    })
}

fn shortened(text: &str) -> String {
    let mut short: String = text.chars().take(40).collect();
    if short.len() < text.len() {
        short.push_str("...");
    }
    short
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
