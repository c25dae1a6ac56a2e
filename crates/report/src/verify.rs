//! The checks of `samara verify`: a table for the terminal, 100 columns wide at most, and an object for
//! `--json`.

use super::json::{VERSION, finite, result_objects, text};
use samara_core::math;
use samara_core::verify::{Check, CheckGroup};

fn all(groups: &[CheckGroup]) -> impl Iterator<Item = (&CheckGroup, &Check)> {
    groups.iter().flat_map(|group| group.checks.iter().map(move |check| (group, check)))
}

fn failed(groups: &[CheckGroup]) -> usize {
    all(groups).filter(|(_, check)| !check.holds()).count()
}

result_objects! {
    /// The checks of the simulator, as `samara verify --json` prints them.
    VerifyObject(groups: &[CheckGroup]) {
        /// Version of samara.
        version: String = VERSION.to_owned(),
        /// Number of checks.
        count: usize = all(groups).count(),
        /// Number of checks whose error is above its bar.
        failed: usize = failed(groups),
        /// The checks.
        checks: Vec<CheckObject> = all(groups).map(|(group, check)| CheckObject::of(group, check)).collect(),
    }

    /// A check; values that are not numbers are null.
    CheckObject(group: &CheckGroup, check: &Check) {
        /// Title of the group.
        group: String = group.title.to_owned(),
        /// The quantity that is checked.
        what: String = check.what.clone(),
        /// Unit of the numbers; empty of a bare number.
        unit: String = check.unit.to_owned(),
        /// Computed value; of a series the one with the largest error.
        computed: Option<f64> = finite(check.computed),
        /// Exact value beside it.
        exact: Option<f64> = finite(check.exact),
        /// The largest deviation, not below zero.
        error: Option<f64> = finite(check.error),
        /// The largest deviation that passes.
        bar: f64 = check.bar,
        /// Whether it passes.
        holds: bool = check.holds(),
        /// Source of the exact value.
        source: String = group.source.to_owned(),
    }
}

/// The object of `samara verify --json`.
pub fn verify_json(groups: &[CheckGroup]) -> String {
    text(&VerifyObject::of(groups))
}

/// The checks as a table, group by group, with their sources and a summary. Ends with a line end.
pub fn verify_text(groups: &[CheckGroup]) -> String {
    let name = |check: &Check| match check.unit {
        "" => check.what.clone(),
        unit => format!("{} [{unit}]", check.what),
    };
    let wide = all(groups).map(|(_, check)| name(check).len()).max().unwrap_or(0);
    let mut table =
        format!("  {:wide$} {:>14} {:>14} {:>8} {:>6}\n", "", "computed", "exact", "error", "bar");
    for group in groups {
        table += &format!("{}\n  {}\n", group.title, group.source);
        for check in &group.checks {
            table += &format!(
                "  {:wide$} {:>14} {:>14} {:>8} {:>6}  {}\n",
                name(check),
                significant(check.computed),
                significant(check.exact),
                if check.error == 0.0 { "0".to_owned() } else { format!("{:.1e}", check.error) },
                format!("{:.0e}", check.bar),
                if check.holds() { "ok" } else { "FAILED" }
            );
        }
    }
    let (count, failed) = (all(groups).count(), failed(groups));
    table += &match failed {
        0 => format!("{count} checks, every error within its bar\n"),
        _ => format!("{failed} of {count} checks FAILED\n"),
    };
    table
}

/// Nine significant digits, as far as they fit.
fn significant(x: f64) -> String {
    if x == 0.0 {
        return "0".to_owned();
    }
    let magnitude = math::log10(x.abs()).floor();
    if !(-4.0..9.0).contains(&magnitude) {
        return format!("{x:.3e}");
    }
    // In range: -4 to 8.
    format!("{x:.*}", (8 - magnitude as i32).max(0) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_numbers_have_nine_digits() {
        let numbers = [12.618_390_775_7, -177.786_288_441, 0.001_437_059_590_86, 3e-12, 0.0, f64::NAN];
        let text: Vec<String> = numbers.map(significant).into();
        assert_eq!(text, ["12.6183908", "-177.786288", "0.00143705959", "3.000e-12", "0", "NaN"]);
    }

    #[test]
    fn a_check_that_fails_is_reported() {
        let checks = vec![Check::new("x", "m", 1.0, 2.0, 0.5), Check::new("y", "", f64::NAN, 2.0, 0.5)];
        let groups = [CheckGroup { title: "Group", source: "Source", checks }];
        let table = verify_text(&groups);
        assert!(table.contains("x [m]") && table.ends_with("2 of 2 checks FAILED\n"), "{table}");
        let object = verify_json(&groups);
        assert!(object.contains("\"failed\": 2") && object.contains("\"computed\": null"), "{object}");
    }
}
