//! What a drop reports on the terminal while it happens, in its order, with simulated times.

use std::cell::RefCell;

use super::answer::Failure;
use super::terminal::{print, print_err};
use samara::assess::{SteadyWithin, Verdict};
use samara::config::Mission;
use samara::link::shell::{LineNotice, Notice};
use samara::link::{HilEvent, StreamerEvent, TimeUs, Timed};
use samara::replan::ReplanRecord;
use samara::sim::DropEvent;

/// Where a narrator's words go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Voice {
    Stdout,
    Stderr,
    /// Nowhere, but waits and troubles to stderr: who waits for others must not be mute.
    Quiet,
}

/// What a narrator makes of something that has happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weight {
    /// Not worth a word: somebody else says it.
    Silent,
    /// Something that one may want to know.
    Said,
    /// Something is wrong, or waited for.
    Warned,
}

/// Reports, or is silent. When stdout fails it falls silent and keeps the error, see [`Narrator::check`].
#[derive(Debug)]
pub struct Narrator {
    voice: Voice,
    /// Whether one process holds all parties, so that what one of them reports the others need not.
    together: bool,
    /// The number of the campaign's trial that it reports on.
    trial: Option<u64>,
    /// Texts of what the simulator has reported of the drop; of some of it the parachute sends a STATUSTEXT.
    reported: RefCell<Vec<String>>,
    failed: RefCell<Option<Failure>>,
    /// What is said before the next words, and not at all when there are none: an error needs no title.
    title: RefCell<String>,
}

impl Narrator {
    fn new(voice: Voice, together: bool, trial: Option<u64>) -> Self {
        Self {
            voice,
            together,
            trial,
            reported: RefCell::default(),
            failed: RefCell::new(None),
            title: RefCell::default(),
        }
    }

    /// For all parties in one process: on stdout; when that belongs to a JSON object, waits and troubles
    /// alone, on stderr.
    pub fn together(json: bool) -> Self {
        Self::new(if json { Voice::Quiet } else { Voice::Stdout }, true, None)
    }

    /// For one of many flights: waits and troubles, on stderr.
    pub fn of_trial(trial: u64) -> Self {
        Self::new(Voice::Quiet, true, Some(trial))
    }

    /// For one party in a process of its own: on stdout, or on stderr when that belongs to a JSON object.
    pub fn alone(json: bool) -> Self {
        Self::new(if json { Voice::Stderr } else { Voice::Stdout }, false, None)
    }

    /// Says it before whatever is said next.
    pub fn entitle(&self, text: &str) {
        *self.title.borrow_mut() += text;
    }

    /// Says it.
    pub fn say(&self, text: &str) {
        let text = &(self.title.take() + text);
        let mut failed = self.failed.borrow_mut();
        match self.voice {
            Voice::Stdout if failed.is_none() => *failed = print(text).err(),
            Voice::Stderr => print_err(text),
            Voice::Stdout | Voice::Quiet => {}
        }
    }

    /// Says something that has happened on the sockets.
    pub fn socket(&self, notice: &Notice) -> Weight {
        let weight = match notice {
            // Not worth a word unless something was wrong.
            Notice::Counts(_, faults) if !faults.any() => Weight::Silent,
            Notice::Line(_, LineNotice::Open | LineNotice::Heard) => Weight::Said,
            Notice::Disconnected(..) | Notice::TurnedAway(_) | Notice::Line(..) | Notice::NotInTime(_) => {
                Weight::Warned
            }
            _ => Weight::Said,
        };
        self.weigh(weight, &format!("{notice}\n"))
    }

    /// Says what is wrong or waited for, also where the rest is kept quiet.
    pub fn warn(&self, text: &str) {
        self.aside(text);
        self.say(text);
    }

    /// Says on stderr what has been said, where that was kept quiet.
    pub fn aside(&self, text: &str) {
        if self.voice == Voice::Quiet {
            let of = self.trial.map_or(String::new(), |trial| format!("trial {trial}: "));
            print_err(&format!("{of}{text}"));
        }
    }

    /// The first error of stdout since the last check. A flight goes on without a terminal; its verb then
    /// fails.
    pub fn check(&self) -> Result<(), Failure> {
        self.failed.take().map_or(Ok(()), Err)
    }

    /// Says it with the weight that it has.
    fn weigh(&self, weight: Weight, text: &str) -> Weight {
        match weight {
            Weight::Silent => {}
            Weight::Said => self.say(text),
            Weight::Warned => self.warn(text),
        }
        weight
    }

    fn at(&self, at: TimeUs, text: &str) {
        self.say(&format!("{}\n", Timed { at, event: text }));
    }

    /// Says how the hang begins.
    pub fn hanging(&self, mission: &Mission) {
        let parachute = &mission.release.parachute;
        let descent = match parachute.suspension {
            None => format!("under the parachute, {} m/s down", parachute.descent_m_s),
            Some(suspension) => {
                let sinks_m_s = mission.linearised_parachute().descent_m_s;
                let riser_m = suspension.riser.length_m;
                format!("under the parachute, a riser of {riser_m} m, {sinks_m_s:.3} m/s down once steady")
            }
        };
        match mission.release.parachute.hook {
            None => self.at(0, &format!("hanging {descent}")),
            Some(hook) => {
                let lets_go_s = mission.release.hang_s - hook.lets_go_before_s;
                self.at(0, &format!("hanging still on a hook; let go at {lets_go_s} s {descent}"))
            }
        }
    }

    /// Says an event of the simulator.
    pub fn simulator(&self, event: &Timed<HilEvent>, mission: &Mission) -> Weight {
        if matches!(event.event, HilEvent::Drop(_)) {
            self.reported.borrow_mut().push(event.event.to_string());
        }
        let weight = match &event.event {
            HilEvent::Drop(DropEvent::RotorsFree) => {
                // Alone it does not know whether anybody flies one.
                let then = if self.together { "the plan begins" } else { "t = 0 of a plan" };
                let delay_s = mission.release.parachute.delay_s;
                self.at(event.at, &format!("rotors free after {delay_s} s of fall, {then}"));
                return Weight::Said;
            }
            connected @ HilEvent::Connected { again: true } if !self.together => {
                self.say(&format!("{connected}\n"));
                return Weight::Said;
            }
            // The shell has reported it.
            HilEvent::Connected { .. } => Weight::Silent,
            // Reported by the streamer or in the verdict, or of no interest in lockstep.
            HilEvent::Lockstep
            | HilEvent::RealTime
            | HilEvent::Drop(DropEvent::Armed { .. })
            | HilEvent::Finished
                if self.together =>
            {
                Weight::Silent
            }
            HilEvent::Board(checked) if !checked.is_fit() => Weight::Warned,
            HilEvent::Waiting { .. } | HilEvent::PeerLeft | HilEvent::Drop(DropEvent::ModeUnknown) => {
                Weight::Warned
            }
            _ => Weight::Said,
        };
        self.weigh(weight, &format!("{event}\n"))
    }

    /// Says an event of the streamer.
    pub fn streamer(&self, event: &Timed<StreamerEvent>) -> Weight {
        let weight = match &event.event {
            // The simulator has reported it, or an acknowledgement has.
            StreamerEvent::ReleaseAsked
            | StreamerEvent::Tracking
            | StreamerEvent::Released { reported: true, .. }
            | StreamerEvent::Text { severity: 5.., .. }
            | StreamerEvent::Replanned(ReplanRecord { kept: None, .. })
            | StreamerEvent::Done
                if self.together =>
            {
                Weight::Silent
            }
            StreamerEvent::Text { text, .. } if self.together && self.has_reported(text) => Weight::Silent,
            // Repeats what an acknowledgement has said.
            StreamerEvent::Text { severity: 6.., .. } => Weight::Silent,
            StreamerEvent::Waiting { .. }
            | StreamerEvent::NotAligned { .. }
            | StreamerEvent::EstimateLost { .. }
            | StreamerEvent::NotHeld
            | StreamerEvent::Late(_)
            | StreamerEvent::Trap { .. }
            | StreamerEvent::Refused { .. }
            | StreamerEvent::Unanswered { .. }
            | StreamerEvent::TooManyTexts
            | StreamerEvent::Lost { .. } => Weight::Warned,
            _ => Weight::Said,
        };
        self.weigh(weight, &format!("{event}\n"))
    }

    /// Whether the simulator has reported it, in these letters, small or capital.
    fn has_reported(&self, text: &str) -> bool {
        self.reported.borrow().iter().any(|reported| reported.eq_ignore_ascii_case(text))
    }

    /// Says when steady flight was reached: what is known at the end only, and no line of the timeline.
    /// `powered_from_s` is the time at which the rotors were freed.
    pub fn steady(&self, verdict: &Verdict, mission: &Mission, powered_from_s: Option<f64>) {
        let v = mission.target_v_ned;
        let target = format!("[{} {} {}] m/s", v.x, v.y, v.z);
        let within = match mission.limits.steady_within() {
            SteadyWithin { m_s, mean_over_s: None } if m_s == 0.01 * v.norm() => format!("1 % of {target}"),
            within => within.of(&target),
        };
        match verdict.outcome.steady_after_s {
            Some(t) => {
                let since = powered_from_s.unwrap_or(0.0);
                let at_s = since + t;
                let rms = verdict.outcome.steady_rms_m_s;
                let rms = rms.map_or(String::new(), |rms| format!(", {rms:.2} m/s RMS about it"));
                self.say(&format!(
                    "steady after {t:.2} s, from {at_s:.3} s to the end: within {within}{rms}\n"
                ))
            }
            None if verdict.outcome.impact_speed_m_s.is_some() => {
                self.say(&format!("on the ground, and not steady within {within} before\n"))
            }
            None => self.say(&format!("never steady within {within} (limits.steady_within_m_s)\n")),
        }
    }
}
