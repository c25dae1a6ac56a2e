//! Exports, checks and differences of PX4 parameter files, for the terminal and as JSON, and the text of the
//! file itself.

use serde::Serialize;

use super::json::{VERSION, text};
use crate::config::Mission;
use crate::params::file::write;
use crate::params::{Check, Class, Difference, Export, Finding, Metadata, ParameterFile, Purpose, Value};

/// The parameter file of an export.
pub fn params_file(mission: &Mission, export: &Export) -> String {
    let origin = [
        format!(
            "Mission: {}; airframe: {}; gains: {}",
            mission.name, mission.vehicle_name, mission.control.gains_name
        ),
        format!("Seed: {}", mission.seed),
        format!("Inputs: {}", mission.inputs.hash),
    ];
    write(&format!("samara {VERSION}"), &export.notes(&origin), &export.parameters)
}

/// Findings and remarks as text, a line each, indented.
fn lines<'a>(findings: impl Iterator<Item = &'a Finding>, remarks: &[String]) -> String {
    findings.map(Finding::text).chain(remarks.iter().cloned()).map(|line| format!("  {line}\n")).collect()
}

fn purpose_words(purpose: Option<Purpose>) -> String {
    purpose.map_or("does not say what it is for".to_owned(), |p| format!("for {} ({})", p.name(), p.words()))
}

/// An export with its findings and remarks, as text for the terminal.
pub fn export_text(export: &Export) -> String {
    let head = format!("{} parameters {}\n", export.parameters.len(), purpose_words(Some(export.purpose)));
    head + &lines(export.check.findings.iter(), &export.remarks)
}

/// A checked file as text: findings, then their count. `refusal`: why the file must not be used there.
pub fn check_text(name: &str, file: &ParameterFile, check: &Check, refusal: Option<&str>) -> String {
    let mut out = format!("{name}: {} parameters, {}\n", file.len(), purpose_words(file.purpose()));
    out += &lines(check.findings.iter(), file.remarks());
    if let Some(refusal) = refusal {
        out += &format!("  does not belong there: {refusal}\n");
    }
    let outside = match (check.count(Class::Outside), check.purpose) {
        (n, Some(Purpose::Samara)) if n > 0 => {
            format!("{n} outside PX4's range (which does not bind samara's autopilot)")
        }
        (n, _) => format!("{n} outside PX4's range"),
    };
    out += &format!(
        "{}: {} checked, {outside}, {} outside and needed, {} of the wrong type, {} not in the table\n",
        if check.passes() && refusal.is_none() { "ok" } else { "NOT OK" },
        check.known,
        check.count(Class::Needed),
        check.count(Class::WrongType),
        check.unknown,
    );
    out
}

/// The differences of two files as text, a line each.
pub fn diff_text(names: [&str; 2], files: [&ParameterFile; 2], differences: &[Difference]) -> String {
    let metadata = Metadata::px4();
    let mut out = String::new();
    if files[0].purpose() != files[1].purpose() {
        for (name, file) in names.iter().zip(files) {
            out += &format!("{name}: {}\n", purpose_words(file.purpose()));
        }
    }
    let counted: Vec<&Difference> = differences.iter().filter(|d| !d.rounding).collect();
    for d in &counted {
        let show = |v: Option<Value>| v.map_or("-".to_owned(), |v| v.to_string());
        let component = if d.component == 1 { String::new() } else { format!("{}:", d.component) };
        let known = metadata.get(&d.name);
        let about = match known.map(|p| (p.unit, p.description)) {
            Some(("", about)) => about.to_owned(),
            Some((unit, about)) => format!("[{unit}] {about}"),
            None => String::new(),
        };
        let line =
            format!("{:18} {:>14} {:>14}  {about}", format!("{component}{}", d.name), show(d.a), show(d.b));
        out += &format!("{}\n", line.trim_end());
    }
    let rounded = differences.len() - counted.len();
    out += &match (counted.len(), rounded) {
        (0, 0) => "no difference\n".to_owned(),
        (n, 0) => format!("{n} differ\n"),
        (n, r) => format!("{n} differ; {r} more only beyond the sixth digit\n"),
    };
    out
}

#[derive(Serialize)]
#[serde(untagged)]
enum Number {
    Int(i32),
    Real(f32),
}

fn number(value: Value) -> Number {
    match value {
        Value::Int(i) => Number::Int(i),
        Value::Real(x) => Number::Real(x),
    }
}

#[derive(Serialize)]
struct FindingObject<'a> {
    name: &'a str,
    value: Number,
    class: &'static str,
    range: &'a str,
    unit: &'static str,
    text: String,
}

fn finding_objects(check: &Check) -> Vec<FindingObject<'_>> {
    let object = |f: &'_ Finding| (f.class.name(), f.unit, f.text());
    check
        .findings
        .iter()
        .map(|f| {
            let (class, unit, text) = object(f);
            FindingObject { name: &f.name, value: number(f.value), class, range: &f.range, unit, text }
        })
        .collect()
}

#[derive(Serialize)]
struct ExportObject<'a> {
    mission: &'a str,
    version: &'static str,
    seed: u64,
    input_hash: &'a str,
    gains: &'a str,
    file: &'a str,
    #[serde(rename = "for")]
    purpose: &'static str,
    gravity_m_s2: f64,
    parameters: std::collections::BTreeMap<&'a str, Number>,
    findings: Vec<FindingObject<'a>>,
    remarks: &'a [String],
}

/// The object of `samara params export --json`.
pub fn export_json(mission: &Mission, file: &str, export: &Export) -> String {
    text(&ExportObject {
        mission: &mission.name,
        version: VERSION,
        seed: mission.seed,
        input_hash: &mission.inputs.hash,
        gains: &mission.control.gains_name,
        file,
        purpose: export.purpose.name(),
        gravity_m_s2: export.gravity_m_s2,
        parameters: export.parameters.iter().map(|(name, value)| (name.as_str(), number(*value))).collect(),
        findings: finding_objects(&export.check),
        remarks: &export.remarks,
    })
}

#[derive(Serialize)]
struct CheckObject<'a> {
    file: &'a str,
    #[serde(rename = "for")]
    purpose: Option<&'static str>,
    ok: bool,
    parameters: usize,
    checked: usize,
    not_in_table: usize,
    does_not_belong: Option<&'a str>,
    findings: Vec<FindingObject<'a>>,
    remarks: &'a [String],
}

/// The object of `samara params check --json`.
pub fn check_json(name: &str, file: &ParameterFile, check: &Check, refusal: Option<&str>) -> String {
    text(&CheckObject {
        file: name,
        purpose: file.purpose().map(Purpose::name),
        ok: check.passes() && refusal.is_none(),
        parameters: file.len(),
        checked: check.known,
        not_in_table: check.unknown,
        does_not_belong: refusal,
        findings: finding_objects(check),
        remarks: file.remarks(),
    })
}

#[derive(Serialize)]
struct DifferenceObject<'a> {
    component: u8,
    name: &'a str,
    a: Option<Number>,
    b: Option<Number>,
}

#[derive(Serialize)]
struct DiffObject<'a> {
    a: &'a str,
    b: &'a str,
    for_a: Option<&'static str>,
    for_b: Option<&'static str>,
    same: bool,
    differences: Vec<DifferenceObject<'a>>,
    rounding: Vec<DifferenceObject<'a>>,
}

/// The object of `samara params diff --json`.
pub fn diff_json(names: [&str; 2], files: [&ParameterFile; 2], differences: &[Difference]) -> String {
    let objects = |rounding: bool| -> Vec<DifferenceObject> {
        differences
            .iter()
            .filter(|d| d.rounding == rounding)
            .map(|d| DifferenceObject {
                component: d.component,
                name: &d.name,
                a: d.a.map(number),
                b: d.b.map(number),
            })
            .collect()
    };
    let [for_a, for_b] = files.map(|f| f.purpose().map(Purpose::name));
    let counted = objects(false);
    text(&DiffObject {
        a: names[0],
        b: names[1],
        for_a,
        for_b,
        same: counted.is_empty(),
        differences: counted,
        rounding: objects(true),
    })
}
