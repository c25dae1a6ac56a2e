//! Verdict, numbers and circumstances of a drop in words, as HTML.

use super::data;
use crate::columns::{fixed, short};
use crate::html::{Html, el};
use crate::json::VERSION;
use crate::shown_drop::ShownDrop;
use crate::verdict::verdict_lines;
use samara_core::assess::judge;
use samara_core::units::DEG_PER_RAD;

/// The verdict as a sentence or two, and the class of its mark.
pub(super) struct Words {
    pub(super) text: Html,
    pub(super) class: &'static str,
}

/// A name in files as words: `pitch_rate`.
fn spaced(name: &str) -> String {
    name.replace('_', " ")
}

pub(super) fn verdict(drop: &ShownDrop<'_>) -> Words {
    let run = drop.run;
    let Some(verdict) = drop.verdict else {
        let reason = run.reason(None).unwrap_or_else(|| "the vehicle was never released".to_owned());
        return Words { text: Html::text(&format!("No verdict: {reason}.")), class: "open" };
    };
    let share = fixed(100.0 * verdict.outcome.j_tpf, 0);
    let used = format!("at most {share} % of a safety limit is used, that of {}", spaced(verdict.decided_by));
    let why = judge::words(&run.objections(Some(verdict)));
    let mut text = match &why {
        None => format!("Safe: {used}."),
        Some(why) => format!("Not safe: {why}."),
    };
    if let Some(t_s) = verdict.outcome.steady_after_s {
        text += &format!(" Steady {} s after the rotors were freed.", fixed(t_s, 2));
    }
    if let Some(hint) = &run.hint {
        text += &format!(" {}.", hint.sentence());
    }
    Words { text: Html::text(&text), class: if why.is_none() { "" } else { "no" } }
}

/// The numbers that matter most, each with its limit.
pub(super) fn numbers(drop: &ShownDrop<'_>) -> Html {
    let Some(v) = drop.verdict else { return Html::default() };
    let (limits, outcome, run) = (&v.limits.safety, &v.outcome, drop.run);
    let mut html = Html::default();
    let mut add = |name: &str, value: String, rest: String, passed: bool| {
        let value = Html::text(&value) + el("small").text(&rest);
        let value = el("dd").class(if passed { "no" } else { "" }).of(value);
        html += el("div").of(el("dt").rich(name) + value);
    };
    let passed = |name: &str| v.limits_passed.contains(&name);
    let of = |limit: f64, unit: &str| format!(" of {}{unit}", short(limit, 2));
    let below = v.limits.j_tpf_below;
    add("J_TPF", fixed(outcome.j_tpf, 3), of(below, ""), !(outcome.j_tpf < below));
    add("peak speed", fixed(outcome.peak_speed_m_s, 2), of(limits.speed_m_s, " m/s"), passed("speed"));
    let pitch_limit = of(limits.pitch_rad * DEG_PER_RAD, " deg");
    let pitch = signed(v.peaks.pitch_rad * DEG_PER_RAD, 1);
    add("peak pitch", pitch, pitch_limit.clone(), passed("pitch"));
    let roll = signed(v.peaks.roll_rad * DEG_PER_RAD, 1);
    if roll != "0.0" {
        add("peak roll", roll, pitch_limit, passed("roll"));
    }
    add("altitude lost", fixed(outcome.altitude_lost_m, 1), " m".to_owned(), passed("altitude_lost"));
    if let Some(speed) = outcome.impact_speed_m_s {
        let class =
            passed("impact") || passed("impact_tilt") || v.on_the_ground.is_some() && !run.course.may_land;
        add("impact", fixed(speed, 2), " m/s".to_owned(), class);
    }
    html
}

fn signed(x: f64, digits: usize) -> String {
    fixed(x, digits).replace('-', "\u{2212}")
}

/// What flew, under which circumstances.
pub(super) fn facts(drop: &ShownDrop<'_>) -> Html {
    let mission = drop.mission;
    let target = mission.target_v_ned.as_slice().iter().map(|v| signed(*v, 1)).collect::<Vec<_>>();
    Html::text(&format!(
        "Mission {}. {} Target velocity {} m/s north, east, down.",
        mission.name,
        drop.circumstances(),
        target.join(" ")
    ))
}

/// The verdict's table.
pub(super) fn table(drop: &ShownDrop<'_>) -> Html {
    let Some(verdict) = drop.verdict else { return el("div").of(Html::default()) };
    let missed = drop.run.misses_steady_flight(verdict);
    let row = |[quantity, value, unit, limit, mark]: [String; 5]| {
        let class = if mark.contains("EXCEEDED") || mark.contains("NOT") { "no" } else { "" };
        let cells = el("th").rich(&quantity)
            + el("td").text(&value.replace('-', "\u{2212}"))
            + el("td").text(&unit)
            + el("td").text(&limit.replace("+-", "\u{b1}"))
            + el("td").class(class).text(&mark);
        el("tr").of(cells).line()
    };
    let lines = verdict_lines(verdict, &drop.mission.limits, missed);
    let head = ["", "value", "", "limit", ""].map(|head| el("th").text(head));
    let table = el("caption").text("The verdict").line()
        + el("thead").of(el("tr").of(head.into_iter().sum())).line()
        + el("tbody").around(lines.into_iter().map(row).sum());
    el("div").class("wide").of(el("table").around(table))
}

/// Where the numbers come from; `rows` of the flight log are on the page.
pub(super) fn origin(drop: &ShownDrop<'_>, rows: usize) -> Html {
    let ShownDrop { mission, samples, run, .. } = *drop;
    let mut facts = vec![
        ("program", format!("samara {VERSION}")),
        ("inputs, SHA-256", mission.inputs.hash.clone()),
        ("seed", mission.seed.to_string()),
    ];
    facts.extend(run.plan_j_tpf.map(|j| ("plan", format!("J_TPF {}", fixed(j, 4)))));
    let all = if rows == samples.len() { "all" } else { "evenly chosen" };
    facts.push((
        "numbers",
        format!("{rows} of {} rows of the log, {all}; {}", samples.len(), data::PRECISION),
    ));
    facts.iter().map(|(name, value)| el("dt").text(name) + el("dd").text(value)).sum()
}
