//! What has been read of a file, and the values of its texts.

use super::remarks::Remarks;
use crate::control::px4::Parameters;
use crate::params::ParamsError;
use crate::params::file::{AUTOPILOT_COMPONENT, Entry, ParameterFile, Value};
use crate::params::metadata::{Kind, Metadata};
use crate::params::px4_required::RULES;

/// More rows are refused: PX4 has less than 3000 parameters, and a file may have those of some components.
pub(super) const MOST_ROWS: usize = 16_384;

const FINITE: &str = "a finite number in single precision (type 9)";

/// What has been read of a file.
#[derive(Default)]
pub(super) struct Reader {
    pub(super) file: ParameterFile,
    pub(super) remarks: Remarks,
    pub(super) rows: usize,
}

/// Which of two values of one parameter stands.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Repeated {
    /// Two values contradict one another.
    Refused,
    /// The later one replaces the other.
    LastStands,
}

impl Reader {
    /// Takes a parameter of the autopilot's.
    pub(super) fn take(
        &mut self,
        line: usize,
        name: &str,
        value: Value,
        repeated: Repeated,
    ) -> Result<(), ParamsError> {
        self.take_of(AUTOPILOT_COMPONENT, line, name, value, repeated)
    }

    pub(super) fn take_of(
        &mut self,
        component: u8,
        line: usize,
        name: &str,
        value: Value,
        repeated: Repeated,
    ) -> Result<(), ParamsError> {
        self.rows += 1;
        if self.rows > MOST_ROWS {
            return Err(ParamsError::TooMany { line, most: MOST_ROWS });
        }
        let Some(before) = self.file.put(component, name, Entry { value, line }) else { return Ok(()) };
        if before.value == value {
            self.remarks.note(line, "a parameter that stands above with the same value");
        } else if repeated == Repeated::LastStands || component != AUTOPILOT_COMPONENT {
            self.remarks.note(line, "a parameter that stands above with another value: this one stands");
        } else {
            return Err(ParamsError::Twice { line, name: name.to_owned(), first: before.line });
        }
        Ok(())
    }

    /// The value of a text in PX4's type of the parameter; where no version has that, in the type that the
    /// text looks like. `None`: passed over, as there is no number and nobody needs one.
    pub(super) fn number(
        &mut self,
        line: usize,
        name: &str,
        text: &str,
    ) -> Result<Option<Value>, ParamsError> {
        let is_real = match Metadata::newest().nearest(name).map(|known| known.kind) {
            Some(kind) => kind == Kind::Float,
            None => whole(text).is_none() || text.contains(['.', 'e', 'E']),
        };
        if is_real { self.real(line, name, text) } else { integer(line, text).map(Some) }
    }

    /// The value of a real number. `None`: passed over, as it is not finite and nobody needs it.
    pub(super) fn real(&mut self, line: usize, name: &str, text: &str) -> Result<Option<Value>, ParamsError> {
        let number = text.parse::<f32>().map_err(|_| refused(line, "value", FINITE, text))?;
        self.finite(line, name, number)
    }

    /// A real number as a value. `None`: passed over, as it is not finite and nobody needs it.
    pub(super) fn finite(
        &mut self,
        line: usize,
        name: &str,
        number: f32,
    ) -> Result<Option<Value>, ParamsError> {
        if number.is_finite() {
            return Ok(Some(Value::Real(number)));
        }
        if matters(name) {
            return Err(refused(line, "value", FINITE, &number.to_string()));
        }
        self.remarks.note(line, "no finite number: passed over");
        Ok(None)
    }
}

/// Whether a drop depends on a parameter.
fn matters(name: &str) -> bool {
    Parameters::NAMES.contains(&name)
        || RULES.iter().any(|rule| rule.name == name)
        || name.starts_with("CA_ROTOR")
}

pub(super) fn integer(line: usize, text: &str) -> Result<Value, ParamsError> {
    let expected = "a 32-bit whole number (type 6)";
    whole(text).map(Value::Int).ok_or_else(|| refused(line, "value", expected, text))
}

/// A whole number, also when written as `4.0` or `4e3`.
fn whole(text: &str) -> Option<i32> {
    text.parse::<i32>().ok().or_else(|| {
        let x = text.parse::<f64>().ok()?;
        let fits = x.fract() == 0.0 && (f64::from(i32::MIN)..=f64::from(i32::MAX)).contains(&x);
        fits.then_some(x as i32)
    })
}

/// Whether a text may be the name of a parameter.
pub(super) fn is_name(text: &str) -> bool {
    let fits = text.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_');
    fits && (1..=16).contains(&text.len()) && !text.as_bytes()[0].is_ascii_digit()
}

pub(super) fn refused(line: usize, column: &'static str, expected: &'static str, found: &str) -> ParamsError {
    ParamsError::Field { line, column, expected, found: shortened(found) }
}

pub(super) fn shortened(text: &str) -> String {
    let mut short: String = text.chars().take(40).collect();
    if short.len() < text.len() {
        short.push_str("...");
    }
    short
}
