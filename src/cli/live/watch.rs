//! What the page of a flight is told while it flies.

use serde_json::{Value, json};

use crate::cli::narrator::Weight;
use samara::config::Mission;
use samara::link::hil::HilEvent;
use samara::link::seen::Seen;
use samara::link::shell::{LineNotice, Notice};
use samara::link::{Froude, StreamerEvent, TimeUs, Timed, seconds};
use samara::report::replay::live::{SimulatedRows, ToldRows, about};
use samara::sim::Sample;
use samara::trajectory::Trajectory;
use samara::view::live::Source;

/// An instant of the flight is told so often, in simulated time: some 30 a second, eight steps of the
/// simulator each.
const ROW_EVERY_US: TimeUs = 32_000;
/// What is known on the link is told so often, in simulated time.
const STATE_EVERY_US: TimeUs = 100_000;

/// What is known of a flight while it flies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Known {
    /// All, as its simulator is here.
    Simulated,
    /// What the vehicle's telemetry says.
    Told,
}

/// A flight, and what was told of it.
pub struct Watch {
    source: Source,
    mission: Mission,
    /// What the page is told of a flight that begins.
    about: Value,
    /// Rows of the flight's log, where it is simulated here.
    rows: Option<SimulatedRows>,
    /// How many of the log were looked at.
    looked_at: usize,
    /// The instant that was told last.
    told: Option<Sample>,
    told_at: TimeUs,
    seen: Seen,
    vehicle: (u8, Option<Froude>),
    released_at: Option<TimeUs>,
    /// What has happened on the link last.
    link: String,
    now: TimeUs,
    state_at: TimeUs,
}

impl Watch {
    /// Nothing told yet of a mission's flight, by a plan, where there is one, of the vehicle of a system and
    /// on a wire of a scale.
    pub fn new(
        mut source: Source,
        (mission, plan): (&Mission, Option<&Trajectory>),
        known: Known,
        vehicle: (u8, Option<Froude>),
    ) -> Self {
        let rows = (known == Known::Simulated).then(|| SimulatedRows::new(mission));
        let columns = rows.as_ref().map_or_else(ToldRows::names, SimulatedRows::names);
        // Structs of strings, numbers and lists of them always serialise.
        let about = serde_json::to_value(about(mission, plan, &columns)).unwrap_or_default();
        source.flight(about.clone());
        Self {
            source,
            about,
            rows,
            looked_at: 0,
            told: None,
            told_at: 0,
            seen: seen(vehicle, mission),
            vehicle,
            released_at: None,
            link: "nobody is heard yet".to_owned(),
            now: 0,
            state_at: 0,
            mission: mission.clone(),
        }
    }

    /// Simulated time has begun anew, and the flight with it.
    fn restart(&mut self) {
        self.source.flight(self.about.clone());
        self.seen = seen(self.vehicle, &self.mission);
        (self.looked_at, self.told, self.told_at, self.released_at) = (0, None, 0, None);
        (self.now, self.state_at) = (0, 0);
    }

    /// Something happened: the page lists what the terminal is told, and has a flight's own events on its
    /// time line.
    pub fn notice(&mut self, notice: &Notice, weight: Weight) {
        let (at, text, is_mark) = match notice {
            Notice::Simulator(Timed { at, event }) => {
                (Some(*at), event.to_string(), matches!(event, HilEvent::Drop(_)))
            }
            Notice::Streamer(Timed { at, event }) => {
                self.released_at = released_at(event).or(self.released_at);
                // The simulator tells of them, where it is here.
                (Some(*at), event.to_string(), self.rows.is_none() && is_mark(event))
            }
            Notice::Autopilot { at, text, .. } => (Some(*at), text.clone(), false),
            other => (None, other.to_string(), false),
        };
        if is_of_the_link(notice) {
            self.link.clone_from(&text);
        }
        let (is_listed, warning) = (weight != Weight::Silent, weight == Weight::Warned);
        if is_listed || is_mark {
            let t_s = at.map(seconds);
            let event = json!({
                "t_s": t_s, "text": text, "listed": is_listed, "mark": is_mark, "warning": warning,
            });
            self.source.event(event);
        }
        self.tell_state();
    }

    /// A frame has come or gone.
    pub fn frame(&mut self, now: TimeUs, bytes: &[u8]) {
        if self.rows.is_none() && now < self.now {
            self.restart();
        }
        self.seen.take(now, bytes);
        self.now = now;
        if self.rows.is_none() {
            self.told_by_telemetry(now);
        }
        if now.abs_diff(self.state_at) >= STATE_EVERY_US {
            self.tell_state();
        }
    }

    fn told_by_telemetry(&mut self, now: TimeUs) {
        let is_due = self.told_at == 0 || now >= self.told_at + ROW_EVERY_US;
        let Some(body) = self.seen.take_body().filter(|_| is_due) else { return };
        self.told_at = now;
        let released_at = self.released_at.or(self.seen.released_at());
        self.source.row(&ToldRows::row(&self.mission, seconds(now), released_at.map(seconds), &body));
    }

    /// The log of a flight that is simulated is this by now: of what is new, the instants that begin a phase
    /// are told, and of the others one now and then.
    pub fn flown(&mut self, log: &[Sample]) {
        if log.len() < self.looked_at {
            self.restart();
        }
        let Some(rows) = &self.rows else { return };
        for sample in log.get(self.looked_at..).unwrap_or_default() {
            let is_due = self.told.as_ref().is_none_or(|told| {
                told.phase != sample.phase || sample.t_s - told.t_s >= seconds(ROW_EVERY_US) - 1e-9
            });
            if is_due {
                self.source.row(&rows.row(sample));
                self.told = Some(*sample);
            }
        }
        self.looked_at = log.len();
    }

    /// Tells what is known on the link: names, words and since when.
    fn tell_state(&mut self) {
        self.state_at = self.now;
        let link = [json!(["link", self.link, null])];
        let told = self.seen.told().map(|(name, at_s, words)| json!([name, words, at_s]));
        let state = link.into_iter().chain(told).collect();
        self.source.state(state);
    }

    /// The flight is over, with this.
    pub fn end(mut self, end: Value) {
        self.tell_state();
        self.source.end(end);
    }
}

fn seen((system_id, froude): (u8, Option<Froude>), mission: &Mission) -> Seen {
    Seen::new(system_id, mission.vehicle.rotors.len(), froude)
}

/// Whether a notice is about who is there.
fn is_of_the_link(notice: &Notice) -> bool {
    match notice {
        Notice::Connected(..)
        | Notice::Disconnected(..)
        | Notice::Unattended(_)
        | Notice::NobodyThere(..)
        | Notice::Heard(..)
        | Notice::Line(_, LineNotice::Open | LineNotice::Heard | LineNotice::Lost(_)) => true,
        Notice::Simulator(Timed { event, .. }) => matches!(
            event,
            HilEvent::Connected { .. }
                | HilEvent::Lockstep
                | HilEvent::RealTime
                | HilEvent::Waiting { .. }
                | HilEvent::CompanionHeard
                | HilEvent::CompanionStreams
                | HilEvent::CompanionSilent(_)
                | HilEvent::PeerLeft
        ),
        Notice::Streamer(Timed { event, .. }) => matches!(
            event,
            StreamerEvent::VehicleHeard(_) | StreamerEvent::VehicleRestarted | StreamerEvent::Waiting { .. }
        ),
        _ => false,
    }
}

/// Whether an event of the streamer has a place on the time line.
fn is_mark(event: &StreamerEvent) -> bool {
    matches!(
        event,
        StreamerEvent::Offboard
            | StreamerEvent::Armed
            | StreamerEvent::Released { .. }
            | StreamerEvent::Falls(_)
            | StreamerEvent::Tracking
            | StreamerEvent::Target
            | StreamerEvent::Lost { .. }
            | StreamerEvent::Failed(_)
    )
}

/// When the vehicle was cut loose, if an event of the streamer says so.
fn released_at(event: &StreamerEvent) -> Option<TimeUs> {
    match event {
        StreamerEvent::Released { released_at, .. } => Some(*released_at),
        StreamerEvent::Falls(fall) => Some(fall.began_at),
        _ => None,
    }
}
