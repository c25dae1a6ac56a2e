//! The observer of a run with a wire: it reports what happens, to the terminal and to the page of a flight
//! that is looked at, and records what is sent.

use anyhow::Context as _;

use super::answer::{BadInput as _, Failure};
use super::live::Live;
use super::narrator::Narrator;
use super::recording::{FlightLogs, Recording};
use super::results::OutputFolder;
use samara::config::Mission;
use samara::hints::No;
use samara::link::shell::{Notice, Observer};
use samara::link::{Link, LogEntry, StreamerEvent, TimeUs, Timed};
use samara::report::hint::Hint;
use samara::sim::Sample;

/// Reports notices, records frames and the autopilot's flights. A terminal that is gone is no reason to stop
/// flying, nor is a full disk.
pub struct Reporter<'a> {
    narrator: &'a Narrator,
    mission: &'a Mission,
    recordings: Vec<Recording>,
    flights: Option<FlightLogs>,
    failed: Option<std::io::Error>,
    parameters: Option<OutputFolder>,
    /// Refusals of the autopilot whose hint has been given.
    hinted: Vec<No>,
    live: Option<&'a Live>,
}

impl<'a> Reporter<'a> {
    /// A reporter that writes nothing.
    pub fn new(narrator: &'a Narrator, mission: &'a Mission) -> Self {
        Self {
            narrator,
            mission,
            recordings: Vec::new(),
            flights: None,
            failed: None,
            parameters: None,
            hinted: Vec::new(),
            live: None,
        }
    }

    /// Tells a page, too.
    pub fn shown(self, live: Option<&'a Live>) -> Self {
        Self { live, ..self }
    }

    /// Records links to the folder; the parachute's frames go with [`Link::Api`].
    pub fn recording(self, folder: &OutputFolder, links: &[Link]) -> Self {
        let recordings = links.iter().map(|link| Recording::new(folder, *link, self.mission)).collect();
        Self { recordings, ..self }
    }

    /// For a run that holds the autopilot too: its flight logs go to the folder, and its parameters when a
    /// ground station asks for that.
    pub fn with_autopilot(self, folder: &OutputFolder) -> Self {
        let flights = FlightLogs::new(folder, &self.mission.vehicle_name);
        Self { parameters: Some(folder.clone()), flights: Some(flights), ..self }
    }

    /// Says once what mostly causes a refusal of the autopilot, where that is known.
    fn hint(&mut self, refusal: &Notice) {
        if let Some(no) = No::of_words(&refusal.to_string()).filter(|no| !self.hinted.contains(no)) {
            self.hinted.push(no);
            self.narrator.say(&Hint::of(no, self.mission).lines());
        }
    }

    /// Closes the logs; the error of a file that could not be written, now or before.
    pub fn finish(self) -> Result<(), Failure> {
        if let Some(error) = self.failed {
            return Err(anyhow::Error::from(error).context("cannot write the .tlog or .ulg")).bad_input();
        }
        for recording in self.recordings {
            recording.finish().context("cannot write the .tlog").bad_input()?;
        }
        if let Some(flights) = self.flights {
            flights.finish().context("cannot write the .ulg").bad_input()?;
        }
        Ok(())
    }
}

/// The file that a ground station's PREFLIGHT_STORAGE has written.
const PARAMETERS: &str = "vehicle.params";

/// `MAV_SEVERITY_WARNING`: what is less severe refuses nothing.
const WARNING: u8 = 4;

impl Observer for Reporter<'_> {
    fn keep_parameters(&mut self, text: &str) {
        let Some(folder) = &self.parameters else { return };
        match folder.write_text(PARAMETERS, text) {
            Ok(path) => self.narrator.say(&format!("parameters kept in {}\n", path.display())),
            Err(failure) => self.narrator.say(&format!("parameters NOT kept: {}\n", failure.text())),
        }
    }

    fn flown(&mut self, log: &[Sample]) {
        if let Some(live) = self.live {
            live.flown(log);
        }
    }

    fn notice(&mut self, notice: Notice) {
        let weight = match &notice {
            Notice::Simulator(event) => self.narrator.simulator(event, self.mission),
            Notice::Streamer(event) => self.narrator.streamer(event),
            other => self.narrator.socket(other),
        };
        if let Some(live) = self.live {
            live.notice(&notice, weight);
        }
        match &notice {
            Notice::Streamer(Timed {
                event: StreamerEvent::Refused { .. } | StreamerEvent::Lost { .. } | StreamerEvent::Failed(_),
                ..
            })
            | Notice::Autopilot { severity: ..=WARNING, .. } => self.hint(&notice),
            _ => {}
        }
    }

    fn frame(&mut self, now: TimeUs, link: Link, bytes: &[u8]) {
        if let Some(live) = self.live {
            live.frame(now, bytes);
        }
        let Some(i) = self.recordings.iter().position(|recording| recording.records(link)) else { return };
        match self.recordings[i].write(now, bytes) {
            Ok(None) => {}
            Ok(Some(name)) => {
                self.narrator.say(&format!("simulated time has started over: recording to {name}\n"));
            }
            Err(error) => {
                self.recordings.remove(i);
                self.failed.get_or_insert(error);
            }
        }
    }

    fn log(&mut self, entry: LogEntry) {
        if let Some(Err(error)) = self.flights.as_mut().map(|flights| flights.write(&entry)) {
            self.flights = None;
            self.failed.get_or_insert(error);
        }
    }
}
