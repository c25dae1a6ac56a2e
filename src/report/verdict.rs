//! The verdict on a drop and the outcome of a plan, as text for the terminal.

use super::json::status_name;
use crate::assess::{SafetyLimits, Verdict, plan_j_tpf};
use crate::plan::Plan;
use crate::units::DEG_PER_RAD;

/// A line of the table: quantity, value and unit, limit, mark.
struct Line {
    quantity: &'static str,
    value: String,
    unit: &'static str,
    limit: String,
    mark: String,
}

/// The verdict as an aligned table: quantity, value, limit, and whether the limit held; J_TPF with the
/// quantity that decides it, and steady flight marked if it was to be reached and was not. Ends with a line's
/// end.
pub fn verdict_text(verdict: &Verdict, limits: &SafetyLimits, misses_steady_flight: bool) -> String {
    let passed = |name: &str| verdict.limits_passed.contains(&name);
    let judged = |quantity, name, value: f64, digits, unit, limit: String| Line {
        quantity,
        value: fixed(value, digits),
        unit,
        limit,
        mark: if passed(name) { "EXCEEDED" } else { "ok" }.to_owned(),
    };
    let stated = |quantity, value: String, unit| Line {
        quantity,
        value,
        unit,
        limit: String::new(),
        mark: String::new(),
    };
    let speed = short(limits.speed_m_s);
    let pitch = format!("+-{}", short(limits.pitch_rad * DEG_PER_RAD));
    let rate = format!("+-{}", short(limits.pitch_rate_rad_s * DEG_PER_RAD));
    let acceleration = format!("+-{}", short(limits.vertical_acceleration_m_s2));
    let steady = verdict.steady_after_s.map_or("never".to_owned(), |t| fixed(t, 2));
    let v = verdict.final_v_ned;
    let velocity = format!("{} {} {}", fixed(v.x, 2), fixed(v.y, 2), fixed(v.z, 2));
    let mut j_tpf = judged("J_TPF", "", verdict.j_tpf, 4, "", "1".to_owned());
    if verdict.limits_passed.iter().any(|&name| name != "impact") || !(verdict.j_tpf <= 1.0) {
        j_tpf.mark = "EXCEEDED".to_owned();
    }
    j_tpf.mark += &format!(", decided by {}", verdict.decided_by.replace('_', " "));
    let (theta, q) = (verdict.peak_pitch_rad * DEG_PER_RAD, verdict.peak_pitch_rate_rad_s * DEG_PER_RAD);
    let (phi, p) = (verdict.peak_roll_rad * DEG_PER_RAD, verdict.peak_roll_rate_rad_s * DEG_PER_RAD);
    let mut lines = vec![
        j_tpf,
        judged("peak speed", "speed", verdict.peak_speed_m_s, 2, "m/s", speed),
        judged("peak pitch", "pitch", theta, 2, "deg", pitch.clone()),
        judged("peak pitch rate", "pitch_rate", q, 2, "deg/s", rate.clone()),
    ];
    // A flight in the plane has no roll to tell of.
    if fixed(phi, 2) != "0.00" || fixed(p, 2) != "0.00" {
        lines.push(judged("peak roll", "roll", phi, 2, "deg", pitch));
        lines.push(judged("peak roll rate", "roll_rate", p, 2, "deg/s", rate));
    }
    lines.extend([
        Line {
            mark: "not judged".to_owned(),
            ..judged(
                "peak vertical acceleration",
                "",
                verdict.peak_vertical_acceleration_m_s2,
                2,
                "m/s^2",
                acceleration,
            )
        },
        stated("altitude lost", fixed(verdict.altitude_lost_m, 1), "m"),
        Line {
            mark: if misses_steady_flight { "NOT STEADY" } else { "" }.to_owned(),
            ..stated("steady after", steady, if verdict.steady_after_s.is_some() { "s" } else { "" })
        },
        stated("final velocity, NED", velocity, "m/s"),
    ]);
    if let Some(speed) = verdict.impact_speed_m_s {
        lines.push(judged("speed of impact", "impact", speed, 2, "m/s", String::new()));
    }
    table(&lines)
}

fn table(lines: &[Line]) -> String {
    let width = |of: fn(&Line) -> usize| lines.iter().map(of).max().unwrap_or(0);
    let (quantity, unit) = (width(|l| l.quantity.len()), width(|l| l.unit.len()));
    let (value, limit) = (width(|l| l.value.len()), width(|l| l.limit.len()).max("limit".len()));
    let mut text = format!("{:quantity$}  {:>value$} {:unit$}  {:>limit$}\n", "", "value", "", "limit");
    for l in lines {
        let row = format!(
            "{:quantity$}  {:>value$} {:unit$}  {:>limit$}  {}",
            l.quantity, l.value, l.unit, l.limit, l.mark
        );
        text += row.trim_end();
        text.push('\n');
    }
    text
}

/// A plan in one line: how the solve ended, its cost, its safety, the work. `solve_ms` is the caller's.
pub fn plan_text(plan: &Plan, limits: &SafetyLimits, solve_ms: Option<f64>) -> String {
    let within = solve_ms.map_or(String::new(), |ms| format!(" in {ms:.1} ms"));
    let mut text = format!(
        "{}{within}, {} iterations: objective {:.6}, J_TPF {:.4}, {} nodes over {} s\n",
        status_name(plan.status).replace('_', " "),
        plan.counts.iterations,
        plan.objective,
        plan_j_tpf(&plan.trajectory, limits),
        plan.trajectory.nodes().len(),
        short(plan.trajectory.end_s()),
    );
    if let Some(diagnosis) = &plan.diagnosis {
        text += diagnosis;
        text.push('\n');
    }
    text
}

/// With that many decimals; no "-0.00".
fn fixed(x: f64, digits: usize) -> String {
    let text = format!("{x:.digits$}");
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| c == '0' || c == '.') => rest.to_owned(),
        _ => text,
    }
}

/// A given number as it was given: up to six decimals (degrees come back from radians), none that are zero.
fn short(x: f64) -> String {
    let text = fixed(x, 6);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}
