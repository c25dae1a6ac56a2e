//! Verdict, numbers and circumstances of a drop in words, as HTML.

use super::data;
use crate::assess::judge;
use crate::report::columns::{fixed, short};
use crate::report::json::VERSION;
use crate::report::shown_drop::ShownDrop;
use crate::report::verdict::verdict_lines;
use crate::units::DEG_PER_RAD;

/// The verdict as a sentence or two, and the class of its mark.
pub(super) struct Words {
    pub(super) text: String,
    pub(super) class: &'static str,
}

/// Text as HTML.
pub(super) fn escape(text: &str) -> String {
    let mut html = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => html += "&amp;",
            '<' => html += "&lt;",
            '>' => html += "&gt;",
            '"' => html += "&quot;",
            '\'' => html += "&#39;",
            c => html.push(c),
        }
    }
    html
}

/// A name in files as words: `pitch_rate`.
fn spaced(name: &str) -> String {
    name.replace('_', " ")
}

pub(super) fn verdict(drop: &ShownDrop<'_>) -> Words {
    let run = drop.run;
    let Some(verdict) = drop.verdict else {
        let reason = run.reason(None).unwrap_or_else(|| "the vehicle was never released".to_owned());
        return Words { text: format!("No verdict: {}.", escape(&reason)), class: "open" };
    };
    let share = fixed(100.0 * verdict.outcome.j_tpf, 0);
    let used = format!("at most {share} % of a safety limit is used, that of {}", spaced(verdict.decided_by));
    let why = judge::words(&run.objections(Some(verdict)));
    let mut text = match &why {
        None => format!("Safe: {}.", escape(&used)),
        Some(why) => format!("Not safe: {}.", escape(why)),
    };
    if let Some(t_s) = verdict.outcome.steady_after_s {
        text += &format!(" Steady {} s after the rotors were freed.", fixed(t_s, 2));
    }
    Words { text, class: if why.is_none() { "" } else { "no" } }
}

/// The numbers that matter most, each with its limit.
pub(super) fn numbers(drop: &ShownDrop<'_>) -> String {
    let Some(v) = drop.verdict else { return String::new() };
    let (limits, outcome, run) = (&v.limits.safety, &v.outcome, drop.run);
    let mut html = String::new();
    let mut add = |name: &str, value: String, rest: String, passed: bool| {
        let class = if passed { " class=\"no\"" } else { "" };
        html += &format!("<div><dt>{name}</dt><dd{class}>{value}<small>{rest}</small></dd></div>");
    };
    let passed = |name: &str| v.limits_passed.contains(&name);
    let of = |limit: f64, unit: &str| format!(" of {}{unit}", short(limit, 2));
    let below = v.limits.j_tpf_below;
    add("J<sub>TPF</sub>", fixed(outcome.j_tpf, 3), of(below, ""), !(outcome.j_tpf < below));
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
pub(super) fn facts(drop: &ShownDrop<'_>) -> String {
    let mission = drop.mission;
    let target = mission.target_v_ned.as_slice().iter().map(|v| signed(*v, 1)).collect::<Vec<_>>();
    format!(
        "Mission {}. {} Target velocity {} m/s north, east, down.",
        escape(&mission.name),
        escape(&drop.circumstances()),
        target.join(" ")
    )
}

/// The verdict's table.
pub(super) fn table(drop: &ShownDrop<'_>) -> String {
    let Some(verdict) = drop.verdict else { return "<div></div>".to_owned() };
    let missed = drop.run.misses_steady_flight(verdict);
    let mut html =
        "<div class=\"wide\"><table>\n<caption>The verdict</caption>\n<thead><tr><th></th><th>value</th>\
                    <th></th><th>limit</th><th></th></tr></thead>\n<tbody>\n"
            .to_owned();
    for [quantity, value, unit, limit, mark] in verdict_lines(verdict, &drop.mission.limits, missed) {
        let class = if mark.contains("EXCEEDED") || mark.contains("NOT") { " class=\"no\"" } else { "" };
        let quantity = escape(&quantity).replace("J_TPF", "J<sub>TPF</sub>");
        html += &format!(
            "<tr><th>{quantity}</th><td>{}</td><td>{}</td><td>{}</td><td{class}>{}</td></tr>\n",
            escape(&value).replace('-', "\u{2212}"),
            escape(&unit),
            escape(&limit).replace("+-", "\u{b1}"),
            escape(&mark)
        );
    }
    html + "</tbody></table></div>"
}

/// Where the numbers come from; `rows` of the flight log are on the page.
pub(super) fn origin(drop: &ShownDrop<'_>, rows: usize) -> String {
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
    facts.iter().map(|(name, value)| format!("<dt>{name}</dt><dd>{}</dd>", escape(value))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_escaped() {
        assert_eq!(escape("</script>&\"'"), "&lt;/script&gt;&amp;&quot;&#39;");
    }
}
