//! The judge: whether a flight was safe, and if not, why not.
//!
//! Whatever says "safe" or "NOT safe" of a flight - terminal, page, figure, campaign, effects, renewed plans,
//! design, draft, card, JUnit, Python - goes by the [`Objection`]s that are stated here, and shows their
//! words. A flight is safe when there is none.
//!
//! A new limit is a field of [`Limits`] and the limit of a quantity in [`QUANTITIES`], which all that judges
//! or lists limits goes through; `Limits::judged_apart` does not compile without a look at the new field, nor
//! does what forgets a new kind of [`Objection`].

use std::fmt;

use super::limits::{Limits, SteadyWithin};
use super::outcome::{LimitNames, Outcome, QUANTITIES};
use crate::hints::No;
use crate::sim::limits::{NOT_FINITE, StateCost};

/// Why a flight was not safe, as far as its numbers tell it.
fn of_numbers(flown: &Flown<'_>, must_become_steady: bool) -> Vec<Objection> {
    let (j_tpf_below, must_be_steady) = flown.limits.judged_apart();
    let mut all = Vec::new();
    for quantity in &QUANTITIES {
        let Some(names) = quantity.judged else { continue };
        let Some((value, allowed)) = quantity.of(flown.outcome).zip((quantity.limit)(flown.limits)) else {
            continue;
        };
        if if names.is_least { value < allowed } else { value > allowed } {
            all.push(Objection::Passed { names, unit: quantity.unit, value, allowed });
        }
    }
    let j_tpf = flown.outcome.j_tpf;
    if j_tpf == f64::INFINITY || j_tpf.is_nan() {
        all.insert(0, Objection::NotFinite);
    } else if j_tpf >= j_tpf_below {
        // The parts are over 1 where J_TPF is; by another bound nobody can name the one.
        let parts = flown.cost.map_or(Vec::new(), |cost| {
            let over = cost.parts().into_iter().filter(|(_, share)| *share >= j_tpf_below);
            over.map(|(name, _)| name).collect()
        });
        all.insert(0, Objection::JTpf { j_tpf, below: j_tpf_below, parts });
    }
    if must_be_steady && must_become_steady && flown.outcome.steady_after_s.is_none() {
        all.push(Objection::NeverSteady { within: flown.limits.steady_within() });
    }
    all
}

/// A flight as it is judged.
pub(super) struct Flown<'a> {
    pub(super) outcome: &'a Outcome,
    pub(super) limits: &'a Limits,
    /// The parts of J_state, each at its peak, where they are known.
    pub(super) cost: Option<StateCost>,
    /// Whether it ended before the plan did that it was to fly.
    pub(super) plan_cut: bool,
    /// A touch before the plan's end.
    pub(super) on_the_ground: Option<OnTheGround>,
}

/// Why a flight was not safe.
#[derive(Clone, Debug, PartialEq)]
pub enum Objection {
    /// There was no drop: the vehicle was not released, for this reason where it is known.
    NeverReleased {
        /// Whether the flight went on to the mission's end.
        completed: bool,
        /// Why the autopilot did not fly to the end.
        trouble: Option<String>,
    },
    /// Released while the autopilot was not armed.
    ReleasedUnarmed,
    /// No rotor was commanded to turn from the release to the end.
    MotorsNeverStarted,
    /// It came to the ground before the plan's end, and neither LAND nor RETURN had been commanded.
    OnTheGround(OnTheGround),
    /// A failsafe of the autopilot flew part of it.
    Failsafe,
    /// The autopilot left or refused before the flight's end.
    Trouble(String),
    /// A state was no number.
    NotFinite,
    /// J_TPF, (51), was not below what is asked for.
    JTpf {
        /// J_TPF.
        j_tpf: f64,
        /// The bound that it had to stay below.
        below: f64,
        /// Names of the parts of J_state that were not below it, where they are known.
        parts: Vec<&'static str>,
    },
    /// A limit beside those of J_state was passed.
    Passed {
        /// Names of the limit.
        names: LimitNames,
        /// Unit of both values.
        unit: &'static str,
        /// The value.
        value: f64,
        /// The largest value that is allowed, or the least.
        allowed: f64,
    },
    /// It was stopped before the mission's end, for this reason where it is known.
    Stopped(Option<String>),
    /// The mission ended before the plan did.
    PlanCut,
    /// It was not steady at the end.
    NeverSteady {
        /// What is steady.
        within: SteadyWithin,
    },
}

/// A touch of the ground before the plan's end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OnTheGround {
    /// Time from the release to the touch [s].
    pub after_s: f64,
    /// Way down from the release to the ground [m].
    pub height_m: f64,
    /// Whether the rotors had been freed.
    pub rotors_free: bool,
    /// Way down from the release that the plan needs at the most [m], and whether it pulls out: ends level or
    /// climbing. `None` where there is no plan, or the touch came before the rotors were freed.
    pub needed: Option<(f64, bool)>,
}

impl Objection {
    /// What kind of a no it is.
    pub fn no(&self) -> No {
        match self {
            Self::NeverReleased { .. } => No::NeverReleased,
            Self::ReleasedUnarmed => No::ReleasedUnarmed,
            Self::MotorsNeverStarted => No::MotorsNeverStarted,
            Self::OnTheGround(_) => No::OnTheGround,
            Self::Failsafe => No::Failsafe,
            Self::Trouble(_) => No::Trouble,
            Self::NotFinite => No::NotFinite,
            Self::JTpf { parts, .. } => match parts.first() {
                Some(&"speed") => No::Speed,
                Some(&"pitch") => No::Pitch,
                Some(&"pitch_rate") => No::PitchRate,
                Some(&"roll") => No::Roll,
                Some(&"roll_rate") => No::RollRate,
                _ => No::JTpf,
            },
            Self::Passed { names, .. } => names.no,
            Self::Stopped(_) => No::Stopped,
            Self::PlanCut => No::PlanCut,
            Self::NeverSteady { .. } => No::NeverSteady,
        }
    }

    /// Names of the limits that were passed, as files have them: of a part of J_state "speed", "pitch",
    /// "pitch_rate", "roll", "roll_rate"; [`LimitNames::passed`]; [`NOT_FINITE`]. None for what is no limit.
    pub fn limits_passed(&self) -> Vec<&'static str> {
        match self {
            Self::NotFinite => vec![NOT_FINITE],
            Self::JTpf { parts, .. } => parts.clone(),
            Self::Passed { names, .. } => vec![names.passed],
            Self::NeverReleased { .. }
            | Self::ReleasedUnarmed
            | Self::MotorsNeverStarted
            | Self::OnTheGround(_)
            | Self::Failsafe
            | Self::Trouble(_)
            | Self::Stopped(_)
            | Self::PlanCut
            | Self::NeverSteady { .. } => Vec::new(),
        }
    }

    /// Whether it is about how the flight went, not about a limit.
    pub fn is_of_the_course(&self) -> bool {
        !matches!(self, Self::NotFinite | Self::JTpf { .. } | Self::Passed { .. })
    }
}

impl fmt::Display for Objection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let with = |f: &mut fmt::Formatter<'_>, text: &str, more: &Option<String>| match more {
            Some(more) => write!(f, "{text}: {more}"),
            None => f.write_str(text),
        };
        match self {
            Self::NeverReleased { completed: true, trouble } => {
                with(f, "the vehicle was never released", trouble)
            }
            Self::NeverReleased { completed: false, trouble } => {
                with(f, "stopped before the release", trouble)
            }
            Self::ReleasedUnarmed => f.write_str("released while the autopilot was not armed"),
            Self::MotorsNeverStarted => f.write_str("the motors were never started"),
            Self::OnTheGround(OnTheGround { after_s, height_m, rotors_free, needed }) => {
                write!(f, "on the ground after {after_s:.1} s")?;
                match needed {
                    Some((needed_m, pulls_out)) if needed_m > height_m => {
                        let what = if *pulls_out { "pull-out" } else { "plan" };
                        write!(
                            f,
                            ": the {what} needs {:.0} m, there were {:.0}",
                            needed_m.ceil(),
                            height_m.floor()
                        )
                    }
                    _ if *rotors_free => f.write_str(", before the plan's end"),
                    _ => f.write_str(", before the rotors were freed"),
                }
            }
            Self::Failsafe => f.write_str("a failsafe flew"),
            Self::Trouble(trouble) => f.write_str(trouble),
            Self::NotFinite => f.write_str(NOT_FINITE),
            Self::JTpf { j_tpf, below, parts } => {
                write!(f, "J_TPF {j_tpf:.3}, not below {below}")?;
                if parts.is_empty() {
                    return Ok(());
                }
                write!(f, ": {}", parts.join(", ").replace('_', " "))
            }
            Self::Passed { names, unit, value, allowed } => {
                // The limit with two decimals, or as many as were given; the value with two, or as tell
                // it apart.
                let (what, allowed) = (names.words, (allowed * 1e6).round() / 1e6);
                let (two, given) = (format!("{allowed:.2}"), format!("{allowed}"));
                let limit = if two.len() >= given.len() { two } else { given };
                let shown = |digits: usize| format!("{value:.digits$}");
                let digits_of = |text: &str| text.trim_end_matches('0').to_owned();
                let apart = (2..12).map(shown).find(|x| digits_of(x) != digits_of(&limit));
                let (value, allowed) = (apart.unwrap_or_else(|| shown(2)), limit);
                write!(f, "{what} {value} {unit}, limit {allowed}")
            }
            Self::Stopped(trouble) => with(f, "stopped before the mission's end", trouble),
            Self::PlanCut => f.write_str("the mission's duration_s ended before the plan"),
            Self::NeverSteady { within } => write!(f, "never steady within {}", within.of("the target")),
        }
    }
}

/// Objections in one line; `None` where there is none: the flight was safe.
pub fn words(objections: &[Objection]) -> Option<String> {
    let all: Vec<String> = objections.iter().map(ToString::to_string).collect();
    (!all.is_empty()).then(|| all.join("; "))
}

/// How a flight went, beside its numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Course {
    /// Whether it went on to the mission's end.
    pub completed: bool,
    /// Whether the vehicle was released while the autopilot was not armed.
    pub released_unarmed: bool,
    /// Whether no rotor was commanded to turn from the release to the end.
    pub motors_never_started: bool,
    /// Whether it may come to the ground before the plan's end: LAND or RETURN was commanded, it began on the
    /// ground, or a script flew it, whose plan nobody knows.
    pub may_land: bool,
    /// Whether steady flight at the target was to be reached.
    pub must_be_steady: bool,
    /// Whether a failsafe of the autopilot flew part of it.
    pub failsafe: bool,
    /// Why the autopilot did not fly to the end, if it left or refused.
    pub trouble: Option<String>,
}

impl Course {
    /// A flight along its plan to its end, without an autopilot that could do anything else.
    pub const WHOLE: Self = Self {
        completed: true,
        released_unarmed: false,
        motors_never_started: false,
        may_land: false,
        must_be_steady: true,
        failsafe: false,
        trouble: None,
    };

    /// Whether the mission was flown to its end.
    pub fn is_to_the_end(&self) -> bool {
        self.completed && self.trouble.is_none()
    }
}

/// Why a flight was not safe, the cause first; empty where it was. Without `flown` nothing was released.
pub(super) fn objections(flown: Option<Flown<'_>>, course: &Course) -> Vec<Objection> {
    let Course {
        completed,
        released_unarmed,
        motors_never_started,
        may_land,
        must_be_steady,
        failsafe,
        ref trouble,
    } = *course;
    let Some(flown) = flown else {
        return vec![Objection::NeverReleased { completed, trouble: trouble.clone() }];
    };
    let ground = flown.on_the_ground.filter(|_| !may_land);
    let motors_never_started = motors_never_started && completed;
    // What nobody flew is not steady either.
    let fell = released_unarmed || motors_never_started || ground.is_some();
    let must_be_steady = must_be_steady && course.is_to_the_end() && !flown.plan_cut && !fell;
    let mut all = Vec::new();
    let mut note = |holds: bool, objection: Objection| all.extend(holds.then_some(objection));
    note(released_unarmed, Objection::ReleasedUnarmed);
    note(motors_never_started, Objection::MotorsNeverStarted);
    all.extend(ground.map(Objection::OnTheGround));
    all.extend(failsafe.then_some(Objection::Failsafe));
    all.extend(trouble.clone().filter(|_| completed).map(Objection::Trouble));
    all.extend(of_numbers(&flown, must_be_steady));
    all.extend((!completed).then(|| Objection::Stopped(trouble.clone())));
    all.extend(flown.plan_cut.then_some(Objection::PlanCut));
    all
}
