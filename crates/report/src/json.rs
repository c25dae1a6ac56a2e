//! The objects that `--json` prints: one object, stable keys that end in their
//! units.
//!
//! What is not finite (the J_TPF of a flight that diverged) is `null`. Wall-clock numbers stand only in
//! objects that are given them; files are not.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::hint::Hint;
use super::outcome::OutcomeObject;
use samara_core::assess::judge::words;
use samara_core::assess::{Course, Objection, Outcome, PowerUse, Summary, Verdict, judge};
use samara_core::control::Fall;
use samara_core::plan::Status;
use samara_core::replan::ReplanRecord;
use samara_core::time::seconds;
use samara_mission::Mission;

/// Version of samara.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// A JSON object, each key once beside its value, in the order of the file. Attributes are serde's. It is
/// for what is printed and never read; what is read is a [`result_objects!`].
#[macro_export]
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
pub use object;

/// Objects of results as types, written and read alike: each key once, with its sentence, which is its
/// description in the schema, its type and, behind `=`, its value. Behind a type's name stands what its `of`
/// makes it of, and in brackets what that does first; behind `unless`, of which values a key is left out.
#[macro_export]
macro_rules! result_objects {
    ($(
        $(#[$about:meta])*
        $name:ident($($given:ident: $made_of:ty),* $(,)?) $([$($first:tt)*])? {
            $($(#[$attribute:meta])* $key:ident $(unless $absent:literal)?: $type:ty = $value:expr),* $(,)?
        }
    )*) => {$(
        $(#[$about])*
        #[derive(Clone, Debug, Default, PartialEq)]
        #[derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
        pub struct $name {
            $($(#[$attribute])* $(#[serde(default, skip_serializing_if = $absent)])? pub $key: $type),*
        }

        impl $name {
            /// Makes the object.
            pub fn of($($given: $made_of),*) -> Self {
                $($($first)*)?
                Self { $($key: $value),* }
            }
        }
    )*};
}
pub use result_objects;

result_objects! {
    /// What was flown: the keys that an object of a mission's results begins with.
    Head(mission: &Mission) {
        /// Name of the mission.
        mission: String = mission.name.clone(),
        /// Version of samara that made the result.
        version: String = VERSION.to_owned(),
        /// Seed of everything random.
        seed: u64 = mission.seed,
        /// SHA-256 of all inputs, files and options, hexadecimal.
        input_hash: String = mission.inputs.hash.clone(),
    }

    /// What was assessed: the keys that `assess.json` begins with.
    AssessHead(m: &Mission, command: &str) {
        /// Name of the mission.
        mission: String = m.name.clone(),
        /// Name of the vehicle.
        vehicle: String = m.vehicle_name.clone(),
        /// Version of samara that made the result.
        version: String = VERSION.to_owned(),
        /// Seed of everything random.
        seed: u64 = m.seed,
        /// SHA-256 of all inputs, files and options, hexadecimal.
        input_hash: String = m.inputs.hash.clone(),
        /// The command that makes it again.
        command: String = command.to_owned(),
        /// Name of the gains.
        gains: String = m.control.gains_name.clone(),
    }

    /// Statistics of a quantity.
    SummaryObject(name: &str, s: &Summary) {
        /// Name of the quantity; it ends in its unit.
        name: String = name.to_owned(),
        /// Number of values.
        count: u64 = s.count(),
        /// Mean of the values.
        mean: Option<f64> = finite(s.mean()),
        /// Standard deviation of the values.
        std: Option<f64> = finite(s.std()),
        /// Least value.
        min: Option<f64> = finite(s.min()),
        /// Greatest value.
        max: Option<f64> = finite(s.max()),
    }
}

/// A number where it is finite: JSON has no others.
pub fn finite(x: f64) -> Option<f64> {
    Some(x).filter(|x| x.is_finite())
}

/// A number, where it is finite; else null in JSON, and as it is in a table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Number(#[schemars(with = "Option<f64>")] pub f64);

impl<'de> Deserialize<'de> for Number {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(Self(Option::deserialize(deserializer)?.unwrap_or(f64::NAN)))
    }
}

/// Where a trajectory that was flown comes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FlownTrajectory {
    /// "planned" or "file".
    pub source: String,
    /// SHA-256 of the trajectory.csv among the results, hexadecimal.
    pub sha256: String,
}

/// The autopilot that flew a drop.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FlownBy {
    /// "reference", "reference_ekf" (on its own estimator), "px4" or "px4-model"; "own" and "own_ekf": the
    /// reference autopilot with a controller of the user's.
    pub name: &'static str,
    /// Version and git hash, as PX4 reports them; the version whose law the model has, where that is not
    /// v1.12; the name of the user's controller.
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
            ("own" | "own_ekf", Some(controller)) => Some(format!("the controller {controller}")),
            _ => None,
        }
    }
}

/// Something that happened in a drop.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FlownFault {
    /// Name, as missions have it.
    pub name: String,
    /// What failed, in words.
    pub text: String,
    /// Beginning, since the simulation began [s].
    pub from_s: f64,
    /// End, likewise [s]; `None`: it stayed.
    pub until_s: Option<f64>,
    /// "mission" or "command".
    pub by: String,
}

/// How a rotor of a drop was started.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FlownCommand {
    /// When, since the simulation began [s].
    pub t_s: f64,
    /// What, and by whom.
    pub text: String,
}

/// An attempt to renew the plan of a drop. Times are since the rotors were freed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
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
    /// What mostly causes it that the drop was not safe, where it was not.
    pub hint: Option<Hint>,
}

/// The fall by which a release was found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
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

result_objects! {
    /// A drop that was flown and judged, as `drop.json` holds it and `samara drop --json` prints it. Peaks
    /// are magnitudes. Where the vehicle was never released the verdict's keys are null.
    DropObject(mission: &Mission, verdict: Option<&Verdict>, run: &DropRun) [
        let objections = run.objections(verdict);
    ] {
        /// What was flown.
        #[serde(flatten)] head: Head = Head::of(mission),
        /// Name of the gains.
        gains: String = mission.control.gains_name.clone(),
        /// The autopilot: `reference`, `reference_ekf`, `px4` or `px4-model`; null where it is not known.
        autopilot: Option<String> = run.autopilot.as_ref().map(|by| by.name.to_owned()),
        /// PX4's version, as it reports it; of `px4-model` the version whose law was asked for; or null.
        autopilot_version: Option<String> = run.autopilot.as_ref().and_then(|by| by.version.clone()),
        /// Where the trajectory comes from that was flown; null where none is known.
        trajectory: Option<FlownTrajectory> = run.trajectory.clone(),
        /// Whether the drop went to the end of mission and plan, with an autopilot that neither left nor
        /// refused.
        completed: bool = run.course.is_to_the_end() && !verdict.is_some_and(|v| v.plan_cut),
        /// When it ended, since the simulation began [s].
        ended_at_s: f64 = run.ended_at_s,
        /// Those of the objections that are about no limit, in one line; or null.
        reason: Option<String> = run.reason(verdict),
        /// Whether the drop was safe.
        safe: bool = objections.is_empty(),
        /// Why it was not safe, in words, the cause first; empty where it was.
        objections: Vec<String> = objections.iter().map(ToString::to_string).collect(),
        /// What causes the first of them, and the command for it; absent where it was safe, or nobody looked.
        hint unless "Option::is_none": Option<Hint> = run.hint.clone(),
        /// What the flight came to, a key for each quantity.
        #[serde(flatten)] outcome: OutcomeObject
            = OutcomeObject(verdict.map_or_else(Outcome::lost, |v| v.outcome)),
        /// The quantity that J_TPF is the share of.
        decided_by: Option<String> = verdict.map(|v| v.decided_by.to_owned()),
        /// Largest vertical acceleration, either way [m/s^2]; reported, not judged.
        peak_vertical_acceleration_m_s2: Option<f64>
            = verdict.and_then(|v| finite(v.peak_vertical_acceleration_m_s2.abs())),
        /// Velocity at the end, NED [m/s].
        final_v_ned_m_s: Option<[Option<f64>; 3]>
            = verdict.map(|v| <[f64; 3]>::from(v.outcome.final_v_ned()).map(finite)),
        /// Names of the limits that were passed.
        limits_passed: Option<Vec<String>>
            = verdict.map(|v| v.limits_passed.iter().map(|&name| name.to_owned()).collect()),
        /// Whether a failsafe flew part of the manoeuvre.
        failsafe: bool = run.course.failsafe,
        /// What happened, in order of time.
        events: Vec<DropEvent> = run.events.clone(),
        /// What others commanded the armed autopilot to do otherwise than by setpoints; absent where nobody
        /// did.
        commanded unless "Vec::is_empty": Vec<FlownCommand> = run.commanded.clone(),
        /// Time of powered flight that each rotor is in the vortex ring [s]; absent where its blades are not
        /// known.
        vortex_ring_s unless "Vec::is_empty": Vec<f64>
            = verdict.map(|v| v.vortex_ring_s.clone()).unwrap_or_default(),
        /// What the drop asked of its battery; absent where that has no voltage.
        power unless "Option::is_none": Option<PowerObject>
            = verdict.and_then(|v| v.power.as_ref()).map(PowerObject::of),
        /// Whether the canopy came closer than `limits.separation_m`; absent where it is no body of its own.
        recontact unless "Option::is_none": Option<bool>
            = verdict.filter(|v| v.outcome.canopy_distance_m.is_some()).map(Verdict::recontact),
        /// J_TPF of the plan, integrated from node to node; null where none was flown.
        plan_j_tpf: Option<f64> = run.plan_j_tpf.and_then(finite),
        /// What the plan's nodes do not tell of the flight, in words; absent where they tell enough.
        plan_shortfall unless "Option::is_none": Option<String> = run.plan_shortfall.clone(),
        /// Wall time that planning took [ms]; on the terminal only.
        plan_solve_ms unless "Option::is_none": Option<f64> = run.plan_solve_ms,
        /// Simulated time over wall time; on the terminal only.
        real_time_factor unless "Option::is_none": Option<f64> = run.real_time_factor,
        /// Faults that the drop had, in order of their beginnings; absent where there were none.
        faults unless "Vec::is_empty": Vec<FlownFault> = run.faults.clone(),
        /// How the rotors were started; absent where that is not modelled, or none was commanded.
        rotor_starts unless "Vec::is_empty": Vec<FlownStart> = run.rotor_starts.clone(),
        /// The fall by which the release was found; absent where it was not found so.
        free_fall unless "Option::is_none": Option<FlownFall> = run.free_fall,
        /// Attempts to renew the plan, in order of time; absent where there were none.
        replans unless "Vec::is_empty": Vec<FlownReplan> = run.replans.clone(),
    }

    /// What a drop asked of its battery. Times are since the rotors were freed.
    PowerObject(power: &PowerUse) {
        /// Least voltage of the bus [V].
        bus_least_v: Option<f64> = finite(power.bus_least_v.value),
        /// When that was [s].
        bus_least_at_s: f64 = power.bus_least_v.at_s,
        /// Greatest current of the pack [A].
        pack_current_most_a: Option<f64> = finite(power.pack_most_a.value),
        /// When that was [s].
        pack_current_most_at_s: f64 = power.pack_most_a.at_s,
        /// Most current of the pack [A]; null: no limit.
        pack_current_limit_a: Option<f64> = finite(power.pack_limit_a),
        /// Greatest current of a speed controller [A].
        esc_current_most_a: Option<f64> = finite(power.esc_most_a.value),
        /// When that was [s].
        esc_current_most_at_s: f64 = power.esc_most_a.at_s,
        /// Number of that speed controller's rotor, from 1.
        esc_current_most_rotor: usize = power.esc_most_rotor,
        /// Most current of a speed controller [A]; null: no limit.
        esc_current_limit_a: Option<f64> = finite(power.esc_limit_a),
        /// Least of limit over current; null: no limit.
        current_margin: Option<f64> = finite(power.current_margin()),
        /// How long the voltage of the bus held a motor back [s].
        held_by_voltage_s: f64 = power.voltage_held_s,
        /// How long a speed controller's limit of current held a motor back [s].
        held_by_esc_current_s: f64 = power.esc_held_s,
        /// How long the pack's limit of current held a motor back [s].
        held_by_pack_current_s: f64 = power.pack_held_s,
        /// Charge at the end [%].
        charge_left_percent: Option<f64> = finite(100.0 * power.charge_left),
        /// When the battery was empty [s]; null: never.
        empty_at_s: Option<f64> = power.empty_at_s,
    }
}

/// Drops of the release cases, as `cases.json` holds them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CasesObject {
    /// A drop for each release case and autopilot.
    pub cases: Vec<CaseDrop>,
}

/// The drop of a release case.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CaseDrop {
    /// Name of the release case.
    pub case: String,
    /// Name of the autopilot.
    pub autopilot: String,
    /// The drop.
    pub drop: DropObject,
}

/// The object of `samara drop --json` and, without durations, of `drop.json`.
pub fn drop_json(mission: &Mission, verdict: Option<&Verdict>, run: &DropRun) -> String {
    text(&DropObject::of(mission, verdict, run))
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
pub fn text(object: &impl Serialize) -> String {
    // Structs of strings, numbers and lists of them always serialise.
    serde_json::to_string_pretty(object).map(|t| t + "\n").unwrap_or_default()
}
impl DropObject {
    /// Why it was not safe, if it was not, in the judge's words: `samara drop` answers by the same.
    pub fn fault(&self) -> Option<String> {
        (!self.safe).then(|| self.objections.join("; "))
    }

    /// The pilot, in words.
    pub fn pilot(&self) -> String {
        pilot_words(
            self.autopilot.as_deref().unwrap_or("an unknown autopilot"),
            self.autopilot_version.as_deref(),
        )
    }
}

/// An autopilot of results, in words.
pub fn pilot_words(name: &str, version: Option<&str>) -> String {
    let version = version.map_or_else(String::new, |version| format!(" {version}"));
    match name {
        "reference" => "the reference autopilot on the true state".to_owned(),
        "reference_ekf" => "the reference autopilot on its own estimator".to_owned(),
        "px4" => format!("PX4{version}"),
        "px4-model" => format!("the model of PX4{version}'s control law"),
        "own" => format!("the reference autopilot on the true state, with the controller{version}"),
        "own_ekf" => format!("the reference autopilot on its own estimator, with the controller{version}"),
        other => other.to_owned(),
    }
}
