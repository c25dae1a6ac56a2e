//! The mission file that a design of plan and gains makes.

use std::path::Path;

use serde_json::{Map, Value};

use super::mission::Mission;
use super::shipped;
use samara_core::design::Design;
use samara_core::plan::InputReference;
use samara_core::tune::is_same_number;
use samara_core::units::DEG_PER_RAD;

/// Why a mission with a design cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum DesignError {
    /// The mission file is no JSON object with a plan.
    #[error("{0} is no JSON object with `plan`")]
    NoPlan(String),
}

/// Added to the name of a mission whose plan and gains were designed.
const DESIGNED: &str = "_design";
/// Longest name of a mission [letters].
const NAME_MOST: usize = 64;

/// The name of the mission that a design of the mission `name` makes: its results have a folder of their own.
fn designed_name(name: &str) -> String {
    let kept: String = name.chars().take(NAME_MOST - DESIGNED.len()).collect();
    kept + DESIGNED
}

/// The mission's file with a design in place of its plan's settings and its gains, under the name
/// `<mission>_design`: everything else stays as it is written there. `gains` is the path of the gains' file;
/// `relative` makes paths of the mission's other files hold for the folder that the text is written to.
///
/// # Errors
/// [`DesignError`] when the text is not that of a mission.
pub fn designed_mission_json(
    mission: &Mission,
    design: &Design,
    gains: &str,
    relative: impl Fn(&Path) -> String,
) -> Result<String, DesignError> {
    let no_plan = || DesignError::NoPlan(mission.file.display().to_string());
    let mut json: Value = serde_json::from_str(mission.inputs.mission_text()).map_err(|_| no_plan())?;
    let moved = |value: &mut Value| {
        if let Value::String(path) = value {
            let resolved = shipped::resolve(&mission.file, path);
            *path = if shipped::is_built_in(&resolved) {
                resolved.display().to_string()
            } else {
                relative(&resolved)
            };
        }
    };
    let paths = ["/vehicle", "/px4_params", "/wind/turbulence/noise"];
    paths.into_iter().for_each(|path| json.pointer_mut(path).into_iter().for_each(moved));
    let whole = json.as_object_mut().ok_or_else(no_plan)?;
    // The schema stands elsewhere, and the design is done.
    whole.shift_remove("$schema");
    whole.insert("name".to_owned(), designed_name(&mission.name).into());
    whole.insert("gains".to_owned(), gains.into());
    let mut problem = mission.plan_problem();
    design.plan.apply(&mut problem, &mission.limits.safety);
    let control = whole.get_mut("control").and_then(Value::as_object_mut).ok_or_else(no_plan)?;
    let (own, limits) = (&mission.control, &design.limits);
    if design.feed_forward != own.feed_forward {
        control.insert("feed_forward".to_owned(), design.feed_forward.into());
    }
    if limits.tilt_from != own.limits.tilt_from {
        control.insert("tilt_from".to_owned(), limits.tilt_from.name().into());
    }
    for (key, limit, own) in [
        ("tilt_limit_deg", limits.tilt_rad, own.limits.tilt_rad),
        ("rate_command_limit_deg_s", limits.rate_command_rad_s, own.limits.rate_command_rad_s),
    ] {
        if !is_same_number(limit, own) {
            control.insert(key.to_owned(), (limit * DEG_PER_RAD).into());
        }
    }
    let planned = whole.get_mut("plan").and_then(Value::as_object_mut).ok_or_else(no_plan)?;
    let reference = match problem.input_reference {
        InputReference::Zero => "zero",
        InputReference::Trim => "trim",
    };
    planned.insert("nodes".to_owned(), problem.nodes.into());
    planned.insert("cost_state".to_owned(), problem.cost_state.to_vec().into());
    planned.insert("cost_input_per_n2".to_owned(), problem.cost_input.into());
    planned.insert("cost_input_reference".to_owned(), reference.into());
    let demands = &problem.demands;
    if let Some(last) = demands.cost_final {
        planned.insert("final_cost_state".to_owned(), last.to_vec().into());
    }
    let peak = demands.peak.map(|peak| Value::from(peak.weight));
    insert_or_remove(planned, ["peak", "weight"], peak);
    let motion =
        [("pitch_deg", demands.motion.pitch_rad), ("pitch_rate_deg_s", demands.motion.pitch_rate_rad_s)];
    for (key, bound) in motion {
        insert_or_remove(planned, ["motion", key], bound.map(|bound| Value::from(bound * DEG_PER_RAD)));
    }
    Ok(as_missions_are_written(&json, 0) + "\n")
}

/// The path from a folder to a file, with `/`; both are there.
pub fn relative(folder: &Path, file: &Path) -> String {
    let (Ok(folder), Ok(target)) = (folder.canonicalize(), file.canonicalize()) else {
        return file.display().to_string();
    };
    let shared = folder.components().zip(target.components()).take_while(|(a, b)| a == b).count();
    let up = folder.components().skip(shared).map(|_| "..".to_owned());
    let down = target.components().skip(shared).map(|part| part.as_os_str().to_string_lossy().into_owned());
    up.chain(down).collect::<Vec<_>>().join("/")
}

/// Puts a value into an object of the plan, or takes it away; an object that holds nothing goes with it.
fn insert_or_remove(planned: &mut Map<String, Value>, [section, key]: [&str; 2], value: Option<Value>) {
    let Some(value) = value else {
        if let Some(object) = planned.get_mut(section).and_then(Value::as_object_mut) {
            object.shift_remove(key);
            if section == "peak" || object.is_empty() {
                planned.shift_remove(section);
            }
        }
        return;
    };
    let object = planned.entry(section).or_insert_with(|| Value::Object(Map::new()));
    if let Some(object) = object.as_object_mut() {
        object.insert(key.to_owned(), value);
    }
}

/// Widest object that stands on one line.
const LINE: usize = 100;

/// JSON as missions are written: objects line by line, unless they are short and hold no others.
fn as_missions_are_written(value: &Value, depth: usize) -> String {
    let nested = |value: &Value| value.is_object() || value.is_array();
    let (inner, outer) = ("  ".repeat(depth + 1), "  ".repeat(depth));
    let lines = |entries: Vec<String>, [open, close]: [char; 2]| {
        let entries: Vec<String> = entries.iter().map(|entry| format!("{inner}{entry}")).collect();
        format!("{open}\n{}\n{outer}{close}", entries.join(",\n"))
    };
    match value {
        Value::Array(items) => {
            let written: Vec<String> =
                items.iter().map(|item| as_missions_are_written(item, depth + 1)).collect();
            if items.iter().any(nested) {
                lines(written, ['[', ']'])
            } else {
                format!("[{}]", written.join(", "))
            }
        }
        Value::Object(members) => {
            let written: Vec<String> = members
                .iter()
                .map(|(key, member)| {
                    format!("{}: {}", Value::from(key.as_str()), as_missions_are_written(member, depth + 1))
                })
                .collect();
            let line = format!("{{ {} }}", written.join(", "));
            let is_short = depth > 0 && line.len() <= LINE && !members.values().any(Value::is_object);
            if is_short && !line.contains('\n') { line } else { lines(written, ['{', '}']) }
        }
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{MissionText, parse_mission};
    use samara_core::control::TiltFrom;
    use samara_core::design::PlanDesign;

    /// The longest name that a mission may have makes one that a mission may have.
    #[test]
    fn closed_form_a_designed_missions_name_is_one_of_a_missions() {
        assert_eq!(designed_name("x500_drop"), "x500_drop_design");
        assert_eq!(designed_name(&"a".repeat(64)), "a".repeat(57) + "_design");
    }

    /// Everything but name, plan and gains stays as it was; the text is a mission, whose plan is the
    /// design's.
    #[test]
    fn a_designed_mission_is_read_and_keeps_the_rest() {
        let mission = Mission::shipped("titan_paper").unwrap();
        let of = |mission: &Mission| Design {
            plan: PlanDesign::of(&mission.plan_problem()),
            gains: mission.control.gains.as_longitudinal(),
            feed_forward: mission.control.feed_forward,
            limits: mission.control.limits,
        };
        let mut design = of(&mission);
        let plan = &mut design.plan;
        plan.weights[2] = 10.0;
        plan.input_reference = InputReference::Trim;
        plan.nodes = 75;
        plan.peak_weight = 20.0;
        plan.pitch_rad = Some(0.3);
        design.feed_forward = true;
        (design.limits.tilt_rad, design.limits.tilt_from) = (0.3, TiltFrom::Gravity);
        let gains = "built-in:params/gains/safety.json";
        let whole = |path: &Path| path.display().to_string();
        let text = designed_mission_json(&mission, &design, gains, whole).unwrap();
        let file = Path::new("elsewhere/design_mission.json");
        let read = parse_mission(&MissionText { mission: &text, file, vehicle: None, gains: None }).unwrap();
        assert_eq!(read.name, "titan_paper_design");
        assert_eq!(read.plan.cost_state, [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 10.0, 10.0, 10.0, 10.0]);
        assert_eq!((read.plan.nodes, read.plan.cost_input_reference), (75, InputReference::Trim));
        assert!(
            (read.plan.demands.motion.pitch_rad.unwrap() - 0.3).abs() < 1e-15 && read.control.feed_forward
        );
        assert_eq!(of(&read).plan.peak_weight, 20.0);
        let limits = read.control.limits;
        assert!((limits.tilt_rad - 0.3).abs() < 1e-15 && limits.tilt_from == TiltFrom::Gravity);
        assert_eq!(limits.rate_command_rad_s, mission.control.limits.rate_command_rad_s);
        assert_eq!((read.control.gains_name.as_str(), read.vehicle_name), ("safety", mission.vehicle_name));
        assert_eq!((read.study.cases, read.duration_s), (mission.study.cases, mission.duration_s));
        assert!(text.contains("    \"cost_state\": [1.0, 1.0,"), "{text}");
    }
}
