//! Exports, checks and differences of PX4 parameter files, for the terminal and as JSON, and the text of the
//! file itself.

use std::collections::BTreeMap;

use serde::{Serialize, Serializer};

use super::json::{Head, VERSION, object, text};
use samara_core::params::file::write;
use samara_core::params::{
    Against, Check, Class, Difference, Export, Finding, ParameterFile, Purpose, Value,
};
use samara_mission::Mission;

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

/// The parameter file of all that an autopilot was given for a drop: equal parameters for a mission and gains
/// are equal bytes, whatever the seed.
pub fn given_parameters(mission: &Mission, export: &Export) -> String {
    let origin = [format!(
        "Mission: {}; airframe: {}; gains: {}",
        mission.name, mission.vehicle_name, mission.control.gains_name
    )];
    write(&format!("samara {VERSION}"), &export.notes(&origin), &export.parameters)
}

/// Findings and remarks as text, a line each, indented.
fn lines<'a>(findings: impl Iterator<Item = &'a Finding>, remarks: &[String]) -> String {
    findings.map(Finding::text).chain(remarks.iter().cloned()).map(|line| format!("  {line}\n")).collect()
}

fn purpose_words(purpose: Option<Purpose>) -> String {
    purpose.map_or("does not say what it is for".to_owned(), |p| format!("for {} ({})", p.name(), p.words()))
}

/// What a file says that it is for.
fn said_of(file: &ParameterFile) -> String {
    match (file.purpose(), file.is_of_px4()) {
        (None, true) => "of PX4, by its own words".to_owned(),
        (purpose, _) => purpose_words(purpose),
    }
}

/// An export with its findings and remarks, as text for the terminal.
pub fn export_text(export: &Export) -> String {
    let against = match export.purpose {
        Purpose::Samara => String::new(),
        Purpose::Px4 | Purpose::Px4Froude => format!(", by {}", export.check.against),
    };
    let head =
        format!("{} parameters {}{against}\n", export.parameters.len(), purpose_words(Some(export.purpose)));
    head + &lines(export.check.findings.iter(), &export.remarks)
}

/// A way to fly a mission with a parameter file.
#[derive(Clone, Debug, PartialEq)]
pub struct Way {
    /// The autopilot, as `--autopilot` names it, or PX4 with its versions.
    pub by: String,
    /// Why it is refused; `None`: it is not.
    pub refusal: Option<String>,
}

impl Way {
    /// The way and the answer, as a line.
    fn text(&self) -> String {
        match &self.refusal {
            None => format!("flown by {}: yes", self.by),
            Some(why) => format!("flown by {}: no, {why}", self.by),
        }
    }
}

/// A checked file as text: findings, ways to fly with it, then the findings' count. `refusal`: why the file
/// must not be used there.
pub fn check_text(
    name: &str,
    file: &ParameterFile,
    check: &Check,
    ways: &[Way],
    refusal: Option<&str>,
) -> String {
    let mut out = format!("{name}: {} parameters, {}\n", file.len(), said_of(file));
    out += &lines(check.findings.iter(), file.remarks());
    for way in ways {
        out += &format!("  {}\n", way.text());
    }
    if let Some(refusal) = refusal {
        out += &format!("  does not belong there: {refusal}\n");
    }
    let outside = match (check.count(Class::Outside), check.purpose) {
        (n, Some(Purpose::Samara)) if n > 0 => {
            format!("{n} outside PX4's range (which does not bind samara's autopilot)")
        }
        (n, _) => format!("{n} outside PX4's range"),
    };
    let misspelt = match check.count(Class::Misspelt) {
        0 => String::new(),
        n => format!(", {n} misspelt"),
    };
    out += &format!(
        "{}: {} checked by {}, {outside}, {} outside and needed, {} of the wrong type{misspelt}, {} that it does not have\n",
        if check.passes() && refusal.is_none() { "ok" } else { "NOT OK" },
        check.known,
        check.against,
        check.count(Class::Needed),
        check.count(Class::WrongType),
        check.unknown,
    );
    out
}

/// The differences of two files as text, a line each; `against`: the versions of PX4 that describe the first
/// and the second.
pub fn diff_text(
    names: [&str; 2],
    files: [&ParameterFile; 2],
    against: [Against; 2],
    differences: &[Difference],
) -> String {
    let mut out = String::new();
    if files[0].purpose() != files[1].purpose() {
        for (name, file) in names.iter().zip(files) {
            out += &format!("{name}: {}\n", said_of(file));
        }
    }
    match against {
        [a, b] if a == b => out += &format!("by {a}\n"),
        [a, b] => out += &format!("{}: by {a}\n{}: by {b}\n", names[0], names[1]),
    }
    let counted: Vec<&Difference> = differences.iter().filter(|d| !d.rounding).collect();
    for d in &counted {
        let show = |v: Option<Value>| v.map_or("-".to_owned(), |v| v.to_string());
        let component = if d.component == 1 { String::new() } else { format!("{}:", d.component) };
        let known = against.map(|against| against.metadata.get(&d.name));
        let about = match known[1].or(known[0]).map(|p| (p.unit, p.description)) {
            Some(("", about)) => about.to_owned(),
            Some((unit, about)) => format!("[{unit}] {about}"),
            None => String::new(),
        };
        // What only one of two versions has differs for that reason.
        let lacking = known[0].is_some() != known[1].is_some();
        let lacks = against[usize::from(known[0].is_some())].metadata.version();
        let about = if lacking { format!("{about} (not in {lacks})") } else { about };
        let line = format!(
            "{:18} {:>14} {:>14}  {}",
            format!("{component}{}", d.name),
            show(d.a),
            show(d.b),
            about.trim_start()
        );
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

/// A parameter's value as a number.
struct Number(Value);

impl Serialize for Number {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0 {
            Value::Int(i) => serializer.serialize_i32(i),
            Value::Real(x) => serializer.serialize_f32(x),
        }
    }
}

fn finding_objects(check: &Check) -> Vec<impl Serialize> {
    let findings = check.findings.iter().map(|f| {
        object! {
            name: &f.name,
            value: Number(f.value),
            class: f.class.name(),
            range: &f.range,
            unit: f.unit,
            text: f.text(),
        }
    });
    findings.collect()
}

/// The object of `samara params export --json`.
pub fn export_json(mission: &Mission, file: &str, export: &Export) -> String {
    let parameters = export.parameters.iter().map(|(name, value)| (name, Number(*value)));
    text(&object! {
        #[serde(flatten)] head: Head::of(mission),
        gains: &mission.control.gains_name,
        file: file,
        r#for: export.purpose.name(),
        px4: export.check.against.metadata.version().to_string(),
        gravity_m_s2: export.gravity_m_s2,
        parameters: parameters.collect::<BTreeMap<_, _>>(),
        findings: finding_objects(&export.check),
        remarks: &export.remarks,
    })
}

/// The object of `samara params check --json`.
pub fn check_json(
    name: &str,
    file: &ParameterFile,
    check: &Check,
    ways: &[Way],
    refusal: Option<&str>,
) -> String {
    let ways = ways.iter().map(|way| {
        object! { by: &way.by, flies: way.refusal.is_none(), refusal: way.refusal.as_deref() }
    });
    text(&object! {
        file: name,
        r#for: file.purpose().map(Purpose::name),
        ok: check.passes() && refusal.is_none(),
        px4: check.against.metadata.version().to_string(),
        px4_named_by: check.against.by.name(),
        parameters: file.len(),
        checked: check.known,
        not_in_table: check.unknown,
        flown_by: ways.collect::<Vec<_>>(),
        does_not_belong: refusal,
        findings: finding_objects(check),
        remarks: file.remarks(),
    })
}

/// The object of `samara params diff --json`.
pub fn diff_json(
    names: [&str; 2],
    files: [&ParameterFile; 2],
    against: [Against; 2],
    differences: &[Difference],
) -> String {
    let objects = |rounding: bool| -> Vec<_> {
        let of = differences.iter().filter(|d| d.rounding == rounding);
        of.map(|d| {
            object! { component: d.component, name: &d.name, a: d.a.map(Number), b: d.b.map(Number) }
        })
        .collect()
    };
    let [for_a, for_b] = files.map(|f| f.purpose().map(Purpose::name));
    let counted = objects(false);
    text(&object! {
        a: names[0],
        b: names[1],
        for_a: for_a,
        for_b: for_b,
        px4_a: against[0].metadata.version().to_string(),
        px4_b: against[1].metadata.version().to_string(),
        same: counted.is_empty(),
        differences: counted,
        rounding: objects(true),
    })
}
