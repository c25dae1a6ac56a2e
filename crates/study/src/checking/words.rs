//! What `samara check` says of a mission: its derived quantities and its loops, as tables and as JSON.

use std::fmt::Write as _;

use serde_json::{Map, Value, json};

use crate::checking::odd::{loop_name, odd};
use crate::checking::{Checked, CheckedPlan, LATENCY_MOST_S, NODES_MOST, Room};
use samara_core::design::{LOOPS, LoopPlace, WorstLoop};
use samara_mission::{DerivedRow, Mission, Odd};
use samara_report::hint::Hint;
use samara_report::json::VERSION;

/// The quantities as a table in groups, the loops, and what is odd, each with its hint.
pub fn checked_text(mission: &Mission, checked: &Checked) -> String {
    let mut text =
        format!("{}: vehicle {}, gains {}\n", mission.name, mission.vehicle_name, mission.control.gains_name);
    for group in &checked.derived.groups {
        grouped(&mut text, group.name, &group.rows);
    }
    if let Some(room) = &checked.room {
        grouped(&mut text, GROUND, &ground_rows(checked, room));
    }
    loops(&mut text, mission, checked);
    // Writing to a String cannot fail.
    match odd(mission, checked).as_slice() {
        [] => text += "\nnothing odd\n",
        odd => {
            text += "\nodd\n";
            for Odd { no, text: sentence } in odd {
                let hint = Hint::of(*no, mission);
                let _ = writeln!(text, "  {sentence}\n    cause: {}\n    {}", hint.cause, hint.command);
            }
        }
    }
    text
}

fn grouped(text: &mut String, name: &str, rows: &[DerivedRow]) {
    let _ = writeln!(text, "\n{name}");
    for row in rows {
        let value = match row.values.as_slice() {
            [] => "-".to_owned(),
            values => values.iter().map(|x| digits(*x)).collect::<Vec<_>>().join("  "),
        };
        let line = format!("  {:34} {value:>12} {:7} {}", row.label, row.unit, row.note);
        let _ = writeln!(text, "{}", line.trim_end());
    }
}

/// Name of the group about the ground.
const GROUND: &str = "ground below the release";

fn ground_rows(checked: &Checked, room: &Room) -> [DerivedRow; 2] {
    let needed = match checked.plan.trajectory() {
        Some(_) => "fall and plan",
        None => "the fall, and what the greatest lift takes to end it",
    };
    let row = |key, label, values: &[f64], note: &str| DerivedRow {
        key,
        label,
        unit: "m",
        values: values.to_vec(),
        note: note.to_owned(),
    };
    [
        row("height_m", "height of the release above it", &[room.height_m], ""),
        row("height_needed_m", "height that is lost", room.needed_m.as_slice(), needed),
    ]
}

/// The loops, a line each, with the least that they keep to instability and where that is.
fn loops(text: &mut String, mission: &Mission, checked: &Checked) {
    let latency_s = mission.vehicle.latency_s;
    if latency_s > LATENCY_MOST_S {
        let _ = writeln!(
            text,
            "\nloops\n  not looked at: control.latency_s is {latency_s} s, and more than {LATENCY_MOST_S} s take long; \
             `samara design --budget 0` has them"
        );
    }
    if checked.loops.is_empty() {
        return;
    }
    let bounds = [
        checked.least.modulus.map(|least| format!("at least {least} from -1 (modulus)")),
        checked.least.delay_s.map(|least_s| format!("{:.0} ms of delay to instability", 1e3 * least_s)),
    ];
    let bounds: Vec<String> = bounds.into_iter().flatten().collect();
    let _ = writeln!(text, "\nloops{}{}", if bounds.is_empty() { "" } else { ": " }, bounds.join(", "));
    let _ = writeln!(text, "  {}", states_words(checked));
    for of in &checked.loops {
        let (modulus, at) = match of.unstable {
            Some(at) => ("unstable".to_owned(), at),
            None => (format!("{:.2}", of.modulus.0), of.modulus.1),
        };
        let (delay, late_at) = match of.delay_s.filter(|_| of.unstable.is_none()) {
            Some((delay_s, at)) => (format!("{:.0} ms", 1e3 * delay_s), short_place(&at)),
            None => Default::default(),
        };
        let verdict = if of.keeps(&checked.least) { "ok" } else { "NO" };
        let (name, at) = (loop_name(of.index), short_place(&at));
        let _ = writeln!(text, "  {name:14} {modulus:>8}  {at:28} {delay:>8}  {late_at:28} {verdict}");
    }
}

/// A state, and how far the vehicle is off there.
fn short_place(at: &LoopPlace) -> String {
    let LoopPlace { state, off } = at;
    let off = [("motor lag", off.motor_lag), ("thrust", off.thrust)];
    let off = off.into_iter().filter(|(_, factor)| *factor != 1.0);
    off.fold((*state).to_owned(), |words, (name, factor)| format!("{words}, {name} x {factor}"))
}

/// Where the loops were looked at, in words.
fn states_words(checked: &Checked) -> String {
    let near = "of the vehicle as it is known, with other motor lags and with other thrusts";
    match &checked.plan {
        CheckedPlan::None => format!("in steady flight at the target, {near}"),
        CheckedPlan::Long => format!(
            "at the release and the target, {near}; not at the plan's peak: a plan of more than {NODES_MOST} nodes is not \
             solved here"
        ),
        plan if plan.trajectory().is_none() => {
            format!("at the release and the target, {near}; not at the plan's peak: there is no plan")
        }
        _ => format!("at the release, the plan's peak and the target, {near}"),
    }
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

/// The quantities as a JSON object: `mission`, `version`, .., an object for each group, `loops`, `odd`, and
/// `hints`, one for each of the odd.
pub fn checked_json(mission: &Mission, checked: &Checked) -> String {
    let mut object = Map::from_iter([
        ("mission".to_owned(), json!(mission.name)),
        ("version".to_owned(), json!(VERSION)),
        ("input_hash".to_owned(), json!(mission.inputs.hash)),
        ("vehicle_name".to_owned(), json!(mission.vehicle_name)),
        ("gains".to_owned(), json!(mission.control.gains_name)),
    ]);
    let ground = checked.room.as_ref().map(|room| ground_rows(checked, room));
    let groups = checked.derived.groups.iter().map(|group| (group.name, group.rows.as_slice()));
    for (name, rows) in groups.chain(ground.as_ref().map(|rows| (GROUND, rows.as_slice()))) {
        let rows = rows.iter().map(|row| {
            let value = match row.values.as_slice() {
                [] => Value::Null,
                [one] => json!(one),
                several => json!(several),
            };
            (row.key.to_owned(), value)
        });
        object.insert(name.replace(' ', "_"), Value::Object(rows.collect()));
    }
    let loops: Vec<Value> = checked.loops.iter().map(|of| loop_json(checked, of)).collect();
    object.insert(
        "loops".to_owned(),
        json!({
            "at_plans_peak": checked.plan.trajectory().is_some(),
            "modulus_least": checked.least.modulus,
            "delay_least_s": checked.least.delay_s,
            "each": loops,
        }),
    );
    let found = odd(mission, checked);
    let sentences: Vec<&str> = found.iter().map(|odd| odd.text.as_str()).collect();
    object.insert("odd".to_owned(), json!(sentences));
    let hints: Vec<Hint> = found.iter().map(|odd| Hint::of(odd.no, mission)).collect();
    object.insert("hints".to_owned(), json!(hints));
    format!("{:#}\n", Value::Object(object))
}

fn loop_json(checked: &Checked, of: &WorstLoop) -> Value {
    let place = |LoopPlace { state, off }: LoopPlace| {
        let (motor_lag, thrust) = (off.motor_lag, off.thrust);
        json!({ "state": state, "motor_lag_factor": motor_lag, "thrust_factor": thrust })
    };
    let (name, broken_at) = LOOPS.get(of.index).copied().unwrap_or_default();
    json!({
        "loop": name,
        "broken_at": broken_at,
        "stable": of.unstable.is_none(),
        "unstable_at": of.unstable.map(place),
        "modulus": of.modulus.0,
        "modulus_at": place(of.modulus.1),
        "delay_s": of.delay_s.map(|(delay_s, _)| delay_s),
        "delay_at": of.delay_s.map(|(_, at)| place(at)),
        "crossover_rad_s": of.crossover_rad_s,
        "ok": of.keeps(&checked.least),
    })
}
