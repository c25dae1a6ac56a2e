//! What was seen of a run, by somebody who sees everything.

use samara::autopilot::FlightMode;
use samara::link::{AutopilotSession, HilSession, StreamerSession};
use samara::report::{FlownDrop, judge_drop};
use samara::sim::{DropEvent, Phase};

use super::FLIGHT;

/// Most lines of a run's story: a flood is not retold.
const MOST_TOLD: usize = 400;

/// What a run came to, and what was seen on the way.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Both came to an end by themselves.
    pub ended: bool,
    /// Exit 0 of the simulator and of the streamer, if there was one that met our vehicle.
    pub simulator_yes: bool,
    pub streamer_yes: bool,
    /// The last flight was released; while the autopilot was not armed.
    pub released: bool,
    pub unarmed: bool,
    /// Number of the simulator's flight: one more whenever its process or its autopilot's connection is new.
    flight: usize,
    /// The flight of the moment at which the streamer met its vehicle, or began anew with it.
    streamers_flight: usize,
    /// The last flight that was released, and the last that was while the autopilot was not armed.
    last_released: Option<usize>,
    last_unarmed: Option<usize>,
    /// The parachute was commanded by the streamer while the autopilot's last HEARTBEAT was not armed.
    pub blind_releases: usize,
    /// Longest time that the autopilot was out of OFFBOARD or disarmed between t = 0 and the plan's end,
    /// simulated [s].
    pub left_s: f64,
    left_since: Option<u64>,
    /// Difference of the last velocity from the target [m/s]; how far the log goes [s].
    pub last_error_m_s: f64,
    pub logged_s: f64,
    /// A failsafe after the release.
    pub failsafe: bool,
    /// Events in the flight's record, reports of the simulator and of the streamer, most peers of a hub, most
    /// TCP connections.
    pub recorded: usize,
    pub reports: [usize; 2],
    pub most_served: usize,
    pub most_connections: usize,
    /// Flights that the autopilot's log has begun.
    pub flights_logged: usize,
    /// Most datagrams that a party has sent in one turn.
    pub most_sent: usize,
    /// Frames of strangers that a session has been given, and frames that have gone to strangers.
    pub strangers_heard: usize,
    pub strangers_told: usize,
    /// A party has told somebody that the clocks differ.
    pub other_clock: bool,
    /// The other vehicle was armed after the streamer had met ours.
    pub other_armed: bool,
    /// Wishes of the operator: asked, granted.
    pub wishes: [usize; 2],
    /// Why the streamer gave up.
    pub gave_up: Option<String>,
    /// Longest silence of the vehicle to an operator who speaks, wall time [s].
    pub unserved_s: f64,
    pub story: Vec<String>,
    /// A report that would act on a terminal.
    pub acting: Option<String>,
}

impl Outcome {
    /// The truth of the drop at this moment.
    pub fn look(&mut self, simulator: &HilSession, autopilot: &AutopilotSession) {
        let run = simulator.run();
        let (t_us, simulation) = (run.now(), run.simulation());
        let powered_s = simulation.powered_from_s().map(|from| t_us as f64 * 1e-6 - from);
        let plan_s = FLIGHT.plan.end_s();
        let in_plan = simulation.phase() == Phase::Powered && powered_s.is_some_and(|t| t < plan_s);
        let autopilot = autopilot.autopilot();
        let flies = autopilot.is_armed() && autopilot.mode() == FlightMode::Offboard;
        if in_plan && !flies {
            let since = *self.left_since.get_or_insert(t_us);
            self.left_s = self.left_s.max(t_us.saturating_sub(since) as f64 * 1e-6);
        } else {
            self.left_since = None;
        }
    }

    /// A flight that is over, or is about to start over.
    pub fn note_flight(&mut self, simulator: &HilSession) {
        let events = &simulator.run().record().events;
        if events.iter().any(|e| matches!(e.event, DropEvent::Released { .. })) {
            self.last_released = Some(self.flight);
        }
        if events.iter().any(|e| e.event == DropEvent::ReleasedUnarmed) {
            self.last_unarmed = Some(self.flight);
        }
        self.flight += 1;
    }

    /// The streamer has met its vehicle, or begins anew with it, in the flight of this moment.
    pub fn note_streamers_beginning(&mut self) {
        self.streamers_flight = self.flight;
    }

    /// The streamer's flight, or a later one, was released.
    pub fn streamers_released(&self) -> bool {
        self.last_released.is_some_and(|flight| flight >= self.streamers_flight)
    }

    /// The streamer's flight, or a later one, was released while the autopilot was not armed.
    pub fn streamers_unarmed(&self) -> bool {
        self.last_unarmed.is_some_and(|flight| flight >= self.streamers_flight)
    }

    /// The vehicle has said nothing to the operator for so long [us].
    pub fn note_unserved(&mut self, silent_us: u64) {
        self.unserved_s = self.unserved_s.max(silent_us as f64 * 1e-6);
    }

    pub fn tell(&mut self, now: u64, what: &str) {
        if what.contains(char::is_control) {
            self.acting.get_or_insert_with(|| what.to_owned());
        }
        if self.story.len() < MOST_TOLD {
            self.story.push(format!("{:10.6} {what}", now as f64 * 1e-6));
        }
    }

    /// How both have ended.
    pub fn conclude(&mut self, simulator: &HilSession, streamer: &StreamerSession) {
        self.note_flight(simulator);
        let mission = &FLIGHT.mission;
        let (record, log) = (simulator.run().record(), simulator.run().log());
        let flown = FlownDrop { log, record, plan: None, by: None, trouble: None };
        let (verdict, run) = judge_drop(mission, &flown);
        self.simulator_yes = run.is_safe(verdict.as_ref());
        self.gave_up = streamer.failure().map(str::to_owned);
        self.streamer_yes = streamer.has_succeeded();
        self.released = record.events.iter().any(|e| matches!(e.event, DropEvent::Released { .. }));
        self.unarmed = record.events.iter().any(|e| e.event == DropEvent::ReleasedUnarmed);
        self.failsafe = record.failsafe;
        self.recorded = record.events.len();
        if let Some(last) = log.last() {
            self.logged_s = last.t_s;
            self.last_error_m_s = (last.state.body.v_ned - mission.target_v_ned).norm();
        }
    }
}
