//! What `samara check` says of a mission: its derived quantities, as a table and as JSON.

use std::fmt::Write as _;

use serde_json::{Map, Value, json};

use super::json::VERSION;
use samara_mission::{Derived, Mission};

/// The quantities as a table in groups, and what is odd.
pub fn derived_text(mission: &Mission, derived: &Derived) -> String {
    let mut text =
        format!("{}: vehicle {}, gains {}\n", mission.name, mission.vehicle_name, mission.control.gains_name);
    // Writing to a String cannot fail.
    for group in &derived.groups {
        let _ = writeln!(text, "\n{}", group.name);
        for row in &group.rows {
            let value = match row.values.as_slice() {
                [] => "-".to_owned(),
                values => values.iter().map(|x| digits(*x)).collect::<Vec<_>>().join("  "),
            };
            let line = format!("  {:34} {value:>12} {:7} {}", row.label, row.unit, row.note);
            let _ = writeln!(text, "{}", line.trim_end());
        }
    }
    match derived.odd.as_slice() {
        [] => text += "\nnothing odd\n",
        odd => {
            text += "\nodd\n";
            for sentence in odd {
                let _ = writeln!(text, "  {sentence}");
            }
        }
    }
    text
}

/// A number with four significant digits, without an exponent where it is of everyday size.
fn digits(x: f64) -> String {
    // What is left of a difference of equal numbers is nothing.
    let x = if x.abs() < 1e-9 { 0.0 } else { x };
    let size = x.abs();
    if size < 1e7 && x.fract() == 0.0 {
        return format!("{}", x + 0.0);
    }
    match size {
        s if !(1e-4..1e7).contains(&s) => format!("{x:.3e}"),
        s if s >= 1000.0 => format!("{x:.0}"),
        s if s >= 100.0 => format!("{x:.1}"),
        s if s >= 10.0 => format!("{x:.2}"),
        s if s >= 0.1 => format!("{x:.3}"),
        _ => format!("{x:.5}"),
    }
}

/// The quantities as a JSON object: `mission`, `version`, .., an object for each group, `odd`.
pub fn derived_json(mission: &Mission, derived: &Derived) -> String {
    let mut object = Map::from_iter([
        ("mission".to_owned(), json!(mission.name)),
        ("version".to_owned(), json!(VERSION)),
        ("input_hash".to_owned(), json!(mission.inputs.hash)),
        ("vehicle_name".to_owned(), json!(mission.vehicle_name)),
        ("gains".to_owned(), json!(mission.control.gains_name)),
    ]);
    for group in &derived.groups {
        let rows = group.rows.iter().map(|row| {
            let value = match row.values.as_slice() {
                [] => Value::Null,
                [one] => json!(one),
                several => json!(several),
            };
            (row.key.to_owned(), value)
        });
        object.insert(group.name.replace(' ', "_"), Value::Object(rows.collect()));
    }
    object.insert("odd".to_owned(), json!(derived.odd));
    format!("{:#}\n", Value::Object(object))
}
