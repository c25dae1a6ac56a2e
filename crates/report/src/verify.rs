//! The checks of `samara verify`: a table for the terminal, 100 columns wide at most, and an object for
//! `--json`.

use super::json::{VERSION, object, text};
use samara_core::math;
use samara_core::verify::{Check, CheckGroup};

fn all(groups: &[CheckGroup]) -> impl Iterator<Item = (&CheckGroup, &Check)> {
    groups.iter().flat_map(|group| group.checks.iter().map(move |check| (group, check)))
}

fn failed(groups: &[CheckGroup]) -> usize {
    all(groups).filter(|(_, check)| !check.holds()).count()
}

/// The object of `samara verify --json`. Values that are not numbers are `null`.
pub fn verify_json(groups: &[CheckGroup]) -> String {
    let finite = |x: f64| x.is_finite().then_some(x);
    let checks = all(groups).map(|(group, check)| {
        object! {
            group: group.title,
            what: &check.what,
            unit: check.unit,
            computed: finite(check.computed),
            exact: finite(check.exact),
            error: finite(check.error),
            bar: check.bar,
            holds: check.holds(),
            source: group.source,
        }
    });
    let checks: Vec<_> = checks.collect();
    text(&object! { version: VERSION, count: checks.len(), failed: failed(groups), checks: checks })
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
