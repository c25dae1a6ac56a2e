//! The objects that `--json` prints: one object, stable keys that end in their
//! units.
//!
//! What is not finite (the J_TPF of a flight that diverged) is `null`. Wall-clock numbers stand only in
//! objects that are given them; files are not.

use std::collections::BTreeMap;

use serde::Serialize;

use super::outcome::OutcomeObject;
use samara_core::assess::judge::words;
use samara_core::assess::{Course, Objection, Outcome, PowerUse, Verdict, judge};
use samara_core::control::Fall;
use samara_core::plan::Status;
use samara_core::replan::ReplanRecord;
use samara_core::time::seconds;
use samara_mission::Mission;

/// Version of samara.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// A JSON object, each key once beside its value, in the order of the file. Attributes are serde's; so a key
/// that may be left out is `#[serde(flatten)] _: value.map(|value| object! { key: value })`.
macro_rules! object {
    ($($(#[$attribute:meta])* $key:ident: $value:expr),* $(,)?) => {{
        // The type of each value is a parameter with the key's name, so that none has to be written.
        #[allow(non_camel_case_types)]
        let object = {
            #[derive(serde::Serialize)]
            struct Object<$($key),*> {
                $($(#[$attribute])* $key: $key),*
            }
            Object { $($key: $value),* }
        };
        object
    }};
}
pub(super) use object;

/// The keys that an object of a mission's results begins with.
pub(super) fn head(mission: &Mission) -> impl Serialize {
    let input_hash = &mission.inputs.hash;
    object! { mission: &mission.name, version: VERSION, seed: mission.seed, input_hash: input_hash }
}

/// Where a trajectory that was flown comes from.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FlownTrajectory {
    /// "planned" or "file".
    pub source: &'static str,
    /// SHA-256 of the trajectory.csv among the results, hexadecimal.
    pub sha256: String,
}

/// The autopilot that flew a drop.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FlownBy {
    /// "reference", "reference_ekf" (on its own estimator), "px4" or "px4-model".
    pub name: &'static str,
    /// Version and git hash, as PX4 reports them; the version whose law the model has, where that is not
    /// v1.12.
    pub version: Option<String>,
}

impl FlownBy {
    /// For a title; nothing for the reference autopilot.
    pub fn words(&self) -> Option<String> {
        match (self.name, &self.version) {
            ("px4", Some(version)) => Some(format!("PX4 {version}")),
            ("px4", None) => Some("PX4".to_owned()),
            ("px4-model", Some(version)) => Some(format!("the model of PX4 {version}'s control law")),
            ("px4-model", None) => Some("the model of PX4's control law".to_owned()),
            _ => None,
        }
    }
}

/// Something that happened in a drop.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DropEvent {
    /// Simulated time [s].
    pub t_s: f64,
    /// What happened, in words.
    pub text: String,
    /// Whether something was not as it should be: in `drop.mcap` only.
    #[serde(skip)]
    pub warning: bool,
}

/// A fault that a drop had.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FlownFault {
    /// Name, as missions have it.
    pub name: &'static str,
    /// What failed, in words.
    pub text: String,
    /// Beginning, since the simulation began [s].
    pub from_s: f64,
    /// End, likewise [s]; `None`: it stayed.
    pub until_s: Option<f64>,
    /// "mission" or "command".
    pub by: &'static str,
}

/// How a rotor of a drop was started.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FlownStart {
    /// Number of the rotor, from 1.
    pub rotor: usize,
    /// Speed when its controller was first commanded to drive it [rad/s]; negative: backwards.
    pub from_rad_s: f64,
    /// Tries until it was caught, or until the end.
    pub tries: u32,
    /// When it was first caught, since the simulation began [s]; `None`: never.
    pub caught_at_s: Option<f64>,
    /// Whether its controller drove it at the end.
    pub running: bool,
}

/// What somebody commanded the armed autopilot to do, otherwise than by setpoints.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FlownCommand {
    /// When, since the simulation began [s].
    pub t_s: f64,
    /// What, and by whom.
    pub text: String,
}

/// An attempt to renew the plan of a drop. Times are since the rotors were freed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FlownReplan {
    /// When the state was measured that the plan was to be made of [s].
    pub seen_s: f64,
    /// When the plan took effect, or was to [s].
    pub takes_effect_s: f64,
    /// Whether it did.
    pub renewed: bool,
    /// Why the plan was kept, where it was.
    pub reason: Option<String>,
    /// Iterations of the solve.
    pub iterations: usize,
}

impl From<&ReplanRecord> for FlownReplan {
    fn from(record: &ReplanRecord) -> Self {
        Self {
            seen_s: record.seen_s,
            takes_effect_s: record.takes_effect_s,
            renewed: record.kept.is_none(),
            reason: record.kept.as_ref().map(ToString::to_string),
            iterations: record.iterations,
        }
    }
}

/// What a drop's object holds besides the verdict.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DropRun {
    /// What was flown, where that is known.
    pub trajectory: Option<FlownTrajectory>,
    /// Time of the last sample [s].
    pub ended_at_s: f64,
    /// How it went, for the judge.
    pub course: Course,
    /// The autopilot, where it is known.
    pub autopilot: Option<FlownBy>,
    /// What happened, in order of time.
    pub events: Vec<DropEvent>,
    /// J_TPF of the plan that was flown.
    pub plan_j_tpf: Option<f64>,
    /// What its nodes do not tell of the flight, in words, where there are too few.
    pub plan_shortfall: Option<String>,
    /// Time that planning took [ms].
    pub plan_solve_ms: Option<f64>,
    /// Simulated time over wall-clock time.
    pub real_time_factor: Option<f64>,
    /// Faults that it had, in order of their beginnings.
    pub faults: Vec<FlownFault>,
    /// What others commanded the armed autopilot to do otherwise than by setpoints, in order of time.
    pub commanded: Vec<FlownCommand>,
    /// How its rotors were started, where that is modelled.
    pub rotor_starts: Vec<FlownStart>,
    /// Attempts to renew the plan, in order of time.
    pub replans: Vec<FlownReplan>,
    /// The fall by which the release was found, where nothing else reported it.
    pub free_fall: Option<FlownFall>,
}

/// The fall by which a release was found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FlownFall {
    /// When it began, since the simulation began [s].
    pub began_s: f64,
    /// When it was found [s].
    pub found_s: f64,
}

impl DropRun {
    /// Notes that the release was found by a fall.
    pub fn note_fall(&mut self, fall: Fall) {
        let (began_s, found_s) = (seconds(fall.began_at), seconds(fall.found_at));
        let text = format!("falls since {began_s:.3} s, found by the accelerometer");
        let at = self.events.partition_point(|event| event.t_s <= found_s);
        self.events.insert(at, DropEvent { t_s: found_s, text, warning: false });
        self.free_fall = Some(FlownFall { began_s, found_s });
    }

    /// Why the drop was not safe, the cause first; empty where it was.
    pub fn objections(&self, verdict: Option<&Verdict>) -> Vec<Objection> {
        judge(verdict, &self.course)
    }

    /// Why there is no verdict, or none of the whole manoeuvre, or why that was no transition to steady
    /// flight, in words: the objections that are about no limit.
    pub fn reason(&self, verdict: Option<&Verdict>) -> Option<String> {
        let of_the_course: Vec<Objection> =
            self.objections(verdict).into_iter().filter(Objection::is_of_the_course).collect();
        words(&of_the_course)
    }

    /// Whether a flight to the end should have become steady and did not.
    pub fn misses_steady_flight(&self, verdict: &Verdict) -> bool {
        let missed = |objection: &Objection| matches!(objection, Objection::NeverSteady { .. });
        self.objections(Some(verdict)).iter().any(missed)
    }
}

/// The object of `samara drop --json`. Peaks are magnitudes. Without a verdict (the vehicle was never
/// released) the verdict's keys are `null`.
pub fn drop_json(mission: &Mission, verdict: Option<&Verdict>, run: &DropRun) -> String {
    let outcome = OutcomeObject(verdict.map_or_else(Outcome::lost, |v| v.outcome));
    let objections = run.objections(verdict);
    text(&object! {
        #[serde(flatten)] head: head(mission),
        gains: &mission.control.gains_name,
        autopilot: run.autopilot.as_ref().map(|by| by.name),
        autopilot_version: run.autopilot.as_ref().and_then(|by| by.version.as_deref()),
        trajectory: run.trajectory.as_ref(),
        completed: run.course.is_to_the_end() && !verdict.is_some_and(|v| v.plan_cut),
        ended_at_s: run.ended_at_s,
        reason: run.reason(verdict),
        safe: objections.is_empty(),
        objections: objections.iter().map(ToString::to_string).collect::<Vec<_>>(),
        #[serde(flatten)] outcome: outcome,
        decided_by: verdict.map(|v| v.decided_by),
        peak_vertical_acceleration_m_s2: verdict.map(|v| v.peak_vertical_acceleration_m_s2.abs()),
        final_v_ned_m_s: verdict.map(|v| <[f64; 3]>::from(v.outcome.final_v_ned())),
        limits_passed: verdict.map(|v| v.limits_passed.as_slice()),
        failsafe: run.course.failsafe,
        events: &run.events,
        #[serde(flatten)] commanded: (!run.commanded.is_empty())
            .then(|| object! { commanded: &run.commanded }),
        #[serde(flatten)] ring: verdict.filter(|v| !v.vortex_ring_s.is_empty())
            .map(|v| object! { vortex_ring_s: &v.vortex_ring_s }),
        #[serde(flatten)] power: verdict.and_then(|v| v.power.as_ref()).map(|power| object! {
            power: power_json(power),
        }),
        #[serde(flatten)] canopy: verdict.filter(|v| v.outcome.canopy_distance_m.is_some())
            .map(|v| object! { recontact: v.recontact() }),
        plan_j_tpf: run.plan_j_tpf,
        #[serde(flatten)] shortfall: run.plan_shortfall.as_ref()
            .map(|words| object! { plan_shortfall: words }),
        #[serde(flatten)] solve: run.plan_solve_ms.map(|ms| object! { plan_solve_ms: ms }),
        #[serde(flatten)] pace: run.real_time_factor.map(|factor| object! { real_time_factor: factor }),
        #[serde(flatten)] faults: (!run.faults.is_empty()).then(|| object! { faults: &run.faults }),
        #[serde(flatten)] starts: (!run.rotor_starts.is_empty())
            .then(|| object! { rotor_starts: &run.rotor_starts }),
        #[serde(flatten)] free_fall: run.free_fall.map(|fall| object! { free_fall: fall }),
        #[serde(flatten)] replans: (!run.replans.is_empty()).then(|| object! { replans: &run.replans }),
    })
}

/// What a drop asked of its battery; times are since the rotors were freed.
fn power_json(power: &PowerUse) -> impl Serialize {
    let finite = |x: f64| Some(x).filter(|x| x.is_finite());
    object! {
        bus_least_v: finite(power.bus_least_v.value),
        bus_least_at_s: power.bus_least_v.at_s,
        pack_current_most_a: finite(power.pack_most_a.value),
        pack_current_most_at_s: power.pack_most_a.at_s,
        pack_current_limit_a: finite(power.pack_limit_a),
        esc_current_most_a: finite(power.esc_most_a.value),
        esc_current_most_at_s: power.esc_most_a.at_s,
        esc_current_most_rotor: power.esc_most_rotor,
        esc_current_limit_a: finite(power.esc_limit_a),
        current_margin: finite(power.current_margin()),
        held_by_voltage_s: power.voltage_held_s,
        held_by_esc_current_s: power.esc_held_s,
        held_by_pack_current_s: power.pack_held_s,
        charge_left_percent: finite(100.0 * power.charge_left),
        empty_at_s: power.empty_at_s,
    }
}

/// The object of `<verb>_manifest.json`: what a run of `verb` had for input, what was chosen beside the
/// files, circumstances that are no inputs (the vehicle's number, the speed of a watched run: they show in
/// the .tlog files only), and the SHA-256 of each file that it wrote, by name.
pub fn manifest_json(
    mission: &Mission,
    verb: &str,
    circumstances: &[(&str, String)],
    files: &BTreeMap<String, String>,
) -> String {
    let choices = mission.inputs.choices.iter().map(|(name, value)| (name, value));
    let circumstances = circumstances.iter().map(|(name, value)| (name, value));
    text(&object! {
        verb: verb,
        version: VERSION,
        mission: &mission.name,
        vehicle: &mission.vehicle_name,
        gains: &mission.control.gains_name,
        seed: mission.seed,
        input_hash: &mission.inputs.hash,
        choices: choices.collect::<BTreeMap<_, _>>(),
        circumstances: circumstances.collect::<BTreeMap<_, _>>(),
        files: files,
    })
}

/// The name of a status in files and on the terminal.
pub fn status_name(status: Status) -> &'static str {
    match status {
        Status::Converged => "converged",
        Status::IterationLimit => "iteration_limit",
        Status::Stopped => "stopped",
        Status::Infeasible => "infeasible",
        Status::Stalled => "stalled",
        Status::Diverged => "diverged",
    }
}

/// One object, a key per line, and a line's end.
pub(super) fn text(object: &impl Serialize) -> String {
    // Structs of strings, numbers and lists of them always serialise.
    serde_json::to_string_pretty(object).map(|t| t + "\n").unwrap_or_default()
}
