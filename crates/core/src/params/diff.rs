//! Two parameter files against each other.

use super::file::{Entry, ParameterFile, Value};

/// A parameter that differs between two files.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// MAVLink component that the parameter belongs to.
    pub component: u8,
    /// Name of the parameter.
    pub name: String,
    /// Value in the first file; `None`: not there.
    pub a: Option<Value>,
    /// Value in the second file; `None`: not there.
    pub b: Option<Value>,
    /// Whether the values agree in the six digits that some programs write; such a row is not counted as a
    /// difference.
    pub rounding: bool,
}

/// Largest relative difference between a number and its six digits.
const SIX_DIGITS: f64 = 5.0e-6;

/// The parameters that differ, by component and name.
pub fn diff(a: &ParameterFile, b: &ParameterFile) -> Vec<Difference> {
    let mut all: Vec<(u8, &str)> = a.entries().chain(b.entries()).map(|(c, name, _)| (c, name)).collect();
    all.sort_unstable();
    all.dedup();
    let of = |file: &ParameterFile, component: u8, name: &str| {
        file.entry(component, name).map(|entry: &Entry| entry.value)
    };
    all.into_iter()
        .filter_map(|(component, name)| {
            let (a, b) = (of(a, component, name), of(b, component, name));
            (a != b).then(|| Difference { component, name: name.to_owned(), a, b, rounding: rounding(a, b) })
        })
        .collect()
}

fn rounding(a: Option<Value>, b: Option<Value>) -> bool {
    match (a, b) {
        (Some(Value::Real(a)), Some(Value::Real(b))) => {
            let (a, b) = (f64::from(a), f64::from(b));
            (a - b).abs() <= SIX_DIGITS * a.abs().max(b.abs())
        }
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_differs_is_listed() {
        let parse = |text: &str| ParameterFile::parse(text).unwrap();
        let a =
            parse("1\t1\tA\t1\t9\n1\t1\tB\t0.123456789\t9\n1\t1\tC\t4\t6\n1\t1\tD\t1\t6\n1\t1\tE\t0\t9\n");
        let b = parse(
            "7\t1\tA\t1.0\t9\r\n7\t1\tB\t0.123457\t9\r\n7\t1\tC\t4\t9\r\n7\t1\tF\t1\t6\r\n7\t1\tE\t-0\t9\n",
        );
        let found = diff(&a, &b);
        let names: Vec<(&str, bool)> = found.iter().map(|d| (d.name.as_str(), d.rounding)).collect();
        assert_eq!(names, [("B", true), ("C", false), ("D", false), ("F", false)]);
        assert_eq!((found[2].b, found[3].a), (None, None));
        assert!(diff(&a, &a).is_empty());
    }
}
