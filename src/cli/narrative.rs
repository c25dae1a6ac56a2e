//! What a drop tells while it happens, in its order, with simulated times.

use super::outcome::Failure;
use super::output::{print, tell};
use samara::assess::Verdict;
use samara::config::Mission;
use samara::link::{SimulatorEvent, StreamerEvent, seconds};

/// Where a narrator's words go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Voice {
    Stdout,
    Stderr,
    /// Nowhere, but waits and troubles on stderr: who waits for others must not be mute.
    Quiet,
}

/// Tells, or is silent.
#[derive(Clone, Copy, Debug)]
pub struct Narrator {
    voice: Voice,
    /// Whether one process holds all parties, so that what one of them tells the others need not.
    together: bool,
    /// The campaign's trial that it tells of.
    trial: Option<u64>,
}

impl Narrator {
    /// For all parties in one process: on stdout; when that belongs to a JSON object, waits and troubles alone, on stderr.
    pub fn together(json: bool) -> Self {
        let voice = if json { Voice::Quiet } else { Voice::Stdout };
        Self { voice, together: true, trial: None }
    }

    /// For one of many flights: waits and troubles, on stderr.
    pub fn of_trial(trial: u64) -> Self {
        Self { voice: Voice::Quiet, together: true, trial: Some(trial) }
    }

    /// For one party in a process of its own: on stdout, or on stderr when that belongs to a JSON object.
    pub fn alone(json: bool) -> Self {
        Self { voice: if json { Voice::Stderr } else { Voice::Stdout }, together: false, trial: None }
    }

    /// Says it.
    pub fn say(&self, text: &str) -> Result<(), Failure> {
        match self.voice {
            Voice::Stdout => print(text),
            Voice::Stderr => {
                tell(text);
                Ok(())
            }
            Voice::Quiet => Ok(()),
        }
    }

    /// Says what is wrong or waited for, also where the rest is kept quiet.
    pub fn warn(&self, text: &str) -> Result<(), Failure> {
        self.aside(text);
        self.say(text)
    }

    /// Says on stderr what has been said, where that was kept quiet.
    pub fn aside(&self, text: &str) {
        if self.voice == Voice::Quiet {
            let of = self.trial.map_or(String::new(), |trial| format!("trial {trial}: "));
            tell(&format!("{of}{text}"));
        }
    }

    fn at(&self, t_s: f64, text: &str) -> Result<(), Failure> {
        self.say(&format!("{t_s:8.3} s  {text}\n"))
    }

    /// The start of the hang.
    pub fn hanging(&self, mission: &Mission) -> Result<(), Failure> {
        let descent = format!("under the parachute, {} m/s down", mission.release.parachute.descent_m_s);
        match mission.release.parachute.hook {
            None => self.at(0.0, &format!("hanging {descent}")),
            Some(hook) => {
                let lets_go_s = mission.release.hang_s - hook.lets_go_before_s;
                self.at(0.0, &format!("hanging still on a hook; let go at {lets_go_s} s {descent}"))
            }
        }
    }

    /// An event of the simulator.
    pub fn simulator(&self, event: &SimulatorEvent, mission: &Mission) -> Result<(), Failure> {
        match event {
            SimulatorEvent::RotorsFree { at } => self.at(
                seconds(*at),
                &format!(
                    "rotors free after {} s of fall, the plan begins",
                    mission.release.parachute.delay_s
                ),
            ),
            // The shell has told.
            SimulatorEvent::Connected { again: false } => Ok(()),
            // Told by the streamer or in the verdict, or of no interest in lockstep.
            SimulatorEvent::Connected { .. }
            | SimulatorEvent::Lockstep { .. }
            | SimulatorEvent::Armed { .. }
            | SimulatorEvent::Finished { .. }
                if self.together =>
            {
                Ok(())
            }
            SimulatorEvent::Waiting { .. }
            | SimulatorEvent::GoingOnWithout { .. }
            | SimulatorEvent::PeerLeft { .. }
            | SimulatorEvent::ModeUntold { .. } => self.warn(&format!("{event}\n")),
            other => self.say(&format!("{other}\n")),
        }
    }

    /// An event of the streamer.
    pub fn streamer(&self, event: &StreamerEvent) -> Result<(), Failure> {
        match event {
            // The simulator has told, or an acknowledgement has.
            StreamerEvent::ReleaseAsked { .. }
            | StreamerEvent::Tracking { .. }
            | StreamerEvent::Released { told: true, .. }
            | StreamerEvent::Text { severity: 5.., .. }
            | StreamerEvent::Done { .. }
                if self.together =>
            {
                Ok(())
            }
            // Repeats what an acknowledgement has said.
            StreamerEvent::Text { severity: 6.., .. } => Ok(()),
            StreamerEvent::Waiting { .. }
            | StreamerEvent::NotAligned { .. }
            | StreamerEvent::EstimateLost { .. }
            | StreamerEvent::NotHeld { .. }
            | StreamerEvent::Late { .. }
            | StreamerEvent::Trap { .. }
            | StreamerEvent::Refused { .. }
            | StreamerEvent::Unanswered { .. }
            | StreamerEvent::Lost { .. } => self.warn(&format!("{event}\n")),
            other => self.say(&format!("{other}\n")),
        }
    }

    /// When steady flight was reached: what is known at the end only, and no line of the timeline.
    /// `powered_from_s` is the time at which the rotors were freed.
    pub fn steady(
        &self,
        verdict: &Verdict,
        mission: &Mission,
        powered_from_s: Option<f64>,
    ) -> Result<(), Failure> {
        let v = mission.target_v_ned;
        let (target, within_m_s) =
            (format!("[{} {} {}] m/s", v.x, v.y, v.z), mission.limits.steady_within_m_s);
        let within =
            if within_m_s != 0.01 * v.norm() { format!("{within_m_s} m/s") } else { "1 %".to_owned() };
        match verdict.steady_after_s {
            Some(t) => {
                let since = powered_from_s.unwrap_or(0.0);
                let at_s = since + t;
                self.say(&format!(
                    "steady after {t:.2} s, from {at_s:.3} s to the end: within {within} of {target}\n"
                ))
            }
            None if verdict.impact_speed_m_s.is_some() => {
                self.say(&format!("on the ground, and not steady within {within} of {target} before\n"))
            }
            None => self.say(&format!("never steady within {within} of {target}\n")),
        }
    }
}
