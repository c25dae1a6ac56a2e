//! A drop that is over, judged: the verdict, what else there is to say of the run, and whether it was safe.

use super::columns::fixed;
use super::json::{DropEvent, DropRun, FlownBy, FlownCommand, FlownFault, FlownStart, FlownTrajectory};
use super::plan::plan_shortfall;
use samara_core::assess::judge::words;
use samara_core::assess::safety::STEP_AT_MOST_S;
use samara_core::assess::{Course, Objection, Verdict, VerdictBuilder};
use samara_core::sim::faults::FaultSpan;
use samara_core::sim::{EscState, FlightRecord, PARAMETER, RotorStarted, Sample};
use samara_core::time::{Timed, seconds};
use samara_core::trajectory::Trajectory;
use samara_mission::{Mission, TrajectoryFile};

/// A drop that is over.
#[derive(Clone, Copy, Debug)]
pub struct FlownDrop<'a> {
    /// The flight log.
    pub log: &'a [Sample],
    /// Events of the flight, and whether a failsafe flew part of it.
    pub record: &'a FlightRecord,
    /// The plan that was to be flown, where it is known.
    pub plan: Option<&'a Trajectory>,
    /// The autopilot, where it is known.
    pub by: Option<&'a FlownBy>,
    /// Why the autopilot did not fly to the end, if it left or refused.
    pub trouble: Option<&'a str>,
}

/// Judges a drop: the verdict, if the vehicle was released, and what `drop.json` holds besides.
pub fn judge_drop(mission: &Mission, flown: &FlownDrop<'_>) -> (Option<Verdict>, DropRun) {
    let plan_end_s = match flown.plan {
        Some(plan) => plan.end_s(),
        None if mission.release.standing => f64::INFINITY,
        None => mission.plan.horizon_s,
    };
    let builder = match flown.plan {
        Some(plan) => verdict_builder(mission).along(plan),
        None => verdict_builder(mission).to_plans_end(plan_end_s),
    };
    let verdict = verdict(mission, flown.log, builder);
    let last = flown.log.last();
    let ended_at_s = last.map_or(0.0, |sample| sample.t_s);
    // Without a plan, where the flight goes is the script's affair once it has come to the ground.
    let landed = verdict.as_ref().is_some_and(|v| v.outcome.impact_speed_m_s.is_some());
    let event = |e: &Timed<samara_core::sim::DropEvent>| DropEvent {
        t_s: seconds(e.at),
        text: e.event.to_string(),
        warning: e.event.is_warning(),
    };
    let is = |wanted: samara_core::sim::DropEvent| flown.record.events.iter().any(|e| e.event == wanted);
    let course = Course {
        completed: mission.duration_s <= ended_at_s + STEP_AT_MOST_S,
        released_unarmed: is(samara_core::sim::DropEvent::ReleasedUnarmed),
        // What begins on the ground may stay there.
        motors_never_started: flown.record.motors_stood && !mission.release.standing,
        may_land: flown.plan.is_none() || mission.release.standing || flown.record.landing,
        must_be_steady: !flown.record.landing
            && (flown.plan.is_some() || !(mission.release.standing || landed)),
        failsafe: flown.record.failsafe,
        trouble: flown.trouble.map(str::to_owned),
    };
    let integrated = flown.plan.map(|plan| mission.integrated(plan));
    let run = DropRun {
        course,
        ended_at_s,
        autopilot: flown.by.cloned(),
        events: flown.record.events.iter().map(event).collect(),
        faults: flown.record.faults.iter().map(FlownFault::from).collect(),
        commanded: flown.record.commanded.iter().map(FlownCommand::from).collect(),
        rotor_starts: flown.record.starts.iter().map(FlownStart::from).collect(),
        plan_j_tpf: integrated.map(|plan| plan.j_tpf),
        plan_shortfall: integrated.and_then(|plan| plan_shortfall(mission, &plan)),
        ..DropRun::default()
    };
    (verdict, run)
}

/// What judges a flight of a mission.
pub(super) fn verdict_builder(mission: &Mission) -> VerdictBuilder {
    VerdictBuilder::judging(mission.limits, mission.target_v_ned)
}

/// The verdict on a flight; `None` when the vehicle was never released.
fn verdict(mission: &Mission, log: &[Sample], builder: VerdictBuilder) -> Option<Verdict> {
    let mut verdict = builder
        .watching_rotors(&mission.vehicle, &mission.site.environment)
        .watching_battery(mission.electric.as_ref().map(|battery| battery.pack().limits()));
    log.iter().for_each(|sample| verdict.observe(sample));
    verdict.finish()
}

impl DropRun {
    /// Whether the drop was safe: judged, within the limits, to the end and steady there, by the plan alone.
    pub fn is_safe(&self, verdict: Option<&Verdict>) -> bool {
        self.objections(verdict).is_empty()
    }

    /// The faults that the drop had, in words: `rotor 2 off from 13.500 s, gyro stuck from 3.000 s to
    /// 4.000 s`; times are since the simulation began. `None`: it had none.
    pub fn fault_words(&self) -> Option<String> {
        let words = |fault: &FlownFault| {
            let until = fault.until_s.map_or(String::new(), |until_s| format!(" to {until_s:.3} s"));
            format!("{} from {:.3} s{until}", fault.text, fault.from_s)
        };
        let all: Vec<String> = self.faults.iter().map(words).collect();
        (!all.is_empty()).then(|| all.join(", "))
    }

    /// What others commanded while it was armed, in words: `mode HOLD by system 255, component 190 at 20.512
    /// s`; the first three, parameters last. `None`: nobody did.
    pub fn command_words(&self) -> Option<String> {
        const SHOWN: usize = 3;
        let words = |c: &FlownCommand| format!("{} at {:.3} s", c.text, c.t_s);
        let mut in_order: Vec<&FlownCommand> = self.commanded.iter().collect();
        in_order.sort_by_key(|c| c.text.starts_with(PARAMETER));
        let mut all: Vec<String> = in_order.into_iter().take(SHOWN).map(words).collect();
        if let Some(more) = self.commanded.len().checked_sub(SHOWN).filter(|more| *more > 0) {
            all.push(format!("and {more} more"));
        }
        (!all.is_empty()).then(|| all.join("; "))
    }

    /// The rotors that were commanded to turn and never were caught, in words: `rotor 3 did not catch (10
    /// tries, from -31.2 rad/s)`, `rotors 1, 2 did not catch`. `None`: there are none.
    pub fn start_words(&self) -> Option<String> {
        let missed: Vec<_> = self.rotor_starts.iter().filter(|start| start.caught_at_s.is_none()).collect();
        match missed[..] {
            [] => None,
            [FlownStart { rotor, tries, from_rad_s, .. }] => {
                let of = if *tries == 1 { "1 try".to_owned() } else { format!("{tries} tries") };
                Some(format!("rotor {rotor} did not catch ({of}, from {} rad/s)", fixed(*from_rad_s, 1)))
            }
            _ => {
                let numbers: Vec<String> = missed.iter().map(|start| start.rotor.to_string()).collect();
                Some(format!("rotors {} did not catch", numbers.join(", ")))
            }
        }
    }

    /// What was decided, in a sentence, with the faults that the drop had and the rotors that were not
    /// started; `None` where nothing was released.
    pub fn sentence(&self, verdict: Option<&Verdict>) -> Option<String> {
        let mut sentence = self.decided(verdict?);
        if let Some(faults) = self.fault_words() {
            sentence += &format!("; faults: {faults}");
        }
        if let Some(missed) = self.start_words() {
            sentence += &format!("; {missed}");
        }
        if let Some(commanded) = self.command_words() {
            sentence += &format!("; commanded: {commanded}");
        }
        Some(sentence)
    }

    fn decided(&self, verdict: &Verdict) -> String {
        let objections = self.objections(Some(verdict));
        let j_tpf = format!("J_TPF {:.3}", verdict.outcome.j_tpf);
        let Some(why) = words(&objections) else {
            let steady = verdict.outcome.steady_after_s;
            return format!(
                "safe: {j_tpf}{}",
                steady.map_or(String::new(), |t| format!(", steady after {t:.2} s"))
            );
        };
        let says_it =
            |objection: &Objection| matches!(objection, Objection::JTpf { .. } | Objection::NotFinite);
        if objections.iter().any(says_it) {
            format!("NOT safe: {why}")
        } else {
            format!("NOT safe: {why}; {j_tpf}")
        }
    }
}

impl From<&FaultSpan> for FlownFault {
    fn from(span: &FaultSpan) -> Self {
        Self {
            name: span.kind.name().to_owned(),
            text: span.kind.to_string(),
            from_s: span.from_s,
            until_s: span.until_s,
            by: if span.ordered { "command" } else { "mission" }.to_owned(),
        }
    }
}

impl From<&Timed<String>> for FlownCommand {
    fn from(command: &Timed<String>) -> Self {
        Self { t_s: seconds(command.at), text: command.event.clone() }
    }
}

impl From<&RotorStarted> for FlownStart {
    fn from(start: &RotorStarted) -> Self {
        let RotorStarted { rotor, from_rad_s, tries, caught_at_s, state } = *start;
        Self { rotor, from_rad_s, tries, caught_at_s, running: state == EscState::Running }
    }
}

impl FlownTrajectory {
    /// A plan of the mission, as its `trajectory.csv` holds it.
    pub fn planned(plan: &Trajectory, mission: &Mission) -> Self {
        let TrajectoryFile { sha256, .. } = TrajectoryFile::written(plan.clone(), &mission.stamp());
        Self { source: "planned".to_owned(), sha256 }
    }
}
