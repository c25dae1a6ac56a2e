//! What the verbs with sockets share: the runtime, Ctrl-C, and an observer that tells and records.

use std::future::Future;
use std::io::Write as _;
use std::pin::Pin;

use anyhow::Context;

use super::args::{LinkArgs, NetArgs, SpeedArg};
use super::narrative::Narrator;
use super::outcome::{BadInput, Failure};
use super::output::OutputFolder;
use super::recording::{FlightLogs, Recording};
use samara::config::Mission;
use samara::link::shell::ports::MAX_INSTANCE;
use samara::link::shell::{Notice, Observer, Ports, Speed, Wiring, system_of_instance};
use samara::link::signing::Key;
use samara::link::{Link, LogEntry, TimeUs};

/// An instance that has ports, from what was typed.
///
/// # Errors
/// What was expected, in words.
pub fn instance(text: &str) -> Result<u16, String> {
    let instance =
        text.parse::<u16>().map_err(|_| format!("a number from 0 to {MAX_INSTANCE} is expected"))?;
    Ports::of_instance(instance).map(|_| instance).map_err(|e| e.to_string())
}

/// MAVLink system of the vehicle of an instance.
///
/// # Errors
/// [`Failure::BadInput`] when there is no such instance.
pub fn system_of(net: &NetArgs) -> Result<u8, Failure> {
    system_of_instance(net.instance).bad_input()
}

/// The ports of the instance.
///
/// # Errors
/// [`Failure::BadInput`] when there is no such instance.
pub fn ports_of(net: &NetArgs) -> Result<Ports, Failure> {
    Ports::of_instance(net.instance).bad_input()
}

/// The key that frames are signed with, if there is one.
///
/// # Errors
/// [`Failure::BadInput`] when its file cannot be read or holds none.
pub fn key_of(net: &NetArgs) -> Result<Option<Key>, Failure> {
    let Some(path) = &net.sign_key else { return Ok(None) };
    let context = || format!("{}: no key to sign with", path.display());
    #[expect(clippy::disallowed_methods, reason = "the command line reads the key")]
    let text = std::fs::read_to_string(path).with_context(context).bad_input()?;
    Key::parse(&text).with_context(context).bad_input().map(Some)
}

/// Endpoints and key besides the instance's ports.
///
/// # Errors
/// As [`key_of`].
pub fn wiring_of(net: &NetArgs, link: &LinkArgs) -> Result<Wiring, Failure> {
    Ok(Wiring { urls: link.links.clone(), key: key_of(net)? })
}

/// The speed as the shell wants it.
pub fn speed_of(speed: SpeedArg) -> Speed {
    match speed {
        SpeedArg::Factor(factor) => Speed::Factor(factor),
        SpeedArg::Max => Speed::Max,
    }
}

/// Completes on Ctrl-C (or a termination signal, where there is one). From the call on, not only once it is awaited, these do
/// not kill the program any more.
#[cfg(unix)]
fn interrupted() -> std::io::Result<impl Future<Output = ()>> {
    use tokio::signal::unix::{SignalKind, signal};
    let (mut interrupt, mut terminate) = (signal(SignalKind::interrupt())?, signal(SignalKind::terminate())?);
    Ok(async move {
        tokio::select! {
            _ = interrupt.recv() => {}
            _ = terminate.recv() => {}
        }
    })
}

/// Completes on Ctrl-C.
#[cfg(windows)]
fn interrupted() -> std::io::Result<impl Future<Output = ()>> {
    let mut interrupt = tokio::signal::windows::ctrl_c()?;
    Ok(async move { _ = interrupt.recv().await })
}

/// Runs something with sockets to its end on a runtime of one thread; it is given the future that completes on Ctrl-C.
///
/// # Errors
/// [`Failure::Internal`] when the system gives no runtime.
pub fn block_on<F: Future>(
    run: impl FnOnce(Pin<Box<dyn Future<Output = ()>>>) -> F,
) -> Result<F::Output, Failure> {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .context("the runtime for sockets")?;
    runtime.block_on(async {
        let stop = interrupted().context("the signal of Ctrl-C")?;
        Ok(run(Box::pin(stop)).await)
    })
}

/// Tells notices, records frames and the autopilot's flights.
pub struct Reporter<'a> {
    narrator: Narrator,
    mission: &'a Mission,
    recordings: Vec<Recording>,
    flights: Option<FlightLogs>,
    failed: Option<std::io::Error>,
    parameters: Option<OutputFolder>,
}

impl<'a> Reporter<'a> {
    /// A reporter that writes nothing.
    pub fn new(narrator: Narrator, mission: &'a Mission) -> Self {
        Self { narrator, mission, recordings: Vec::new(), flights: None, failed: None, parameters: None }
    }

    /// Records links to the folder: some of [`TLOGS`](super::recording::TLOGS).
    pub fn recording(self, folder: &OutputFolder, stems: &[&'static str]) -> Self {
        let recordings = stems.iter().map(|stem| Recording::new(folder, stem, self.mission)).collect();
        Self { recordings, ..self }
    }

    /// For one who runs the autopilot too: its flight logs go to the folder, and its parameters when a ground station asks for
    /// that.
    pub fn with_autopilot(self, folder: &OutputFolder) -> Self {
        let flights = FlightLogs::new(folder, &self.mission.vehicle_name);
        Self { parameters: Some(folder.clone()), flights: Some(flights), ..self }
    }

    /// Closes the logs.
    ///
    /// # Errors
    /// [`Failure::BadInput`] when something could not be written, now or before.
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

/// The file in the results' folder that PREFLIGHT_STORAGE writes.
const PARAMETERS: &str = "vehicle.params";

impl Observer for Reporter<'_> {
    fn keep_parameters(&mut self, text: &str) {
        let Some(folder) = &self.parameters else { return };
        // A terminal that is gone is no reason to stop flying, nor is a full disk.
        let _ = match folder.write(PARAMETERS, |out| out.write_all(text.as_bytes())) {
            Ok(path) => self.narrator.say(&format!("parameters kept in {}\n", path.display())),
            Err(Failure::BadInput(error) | Failure::Internal(error)) => {
                self.narrator.say(&format!("parameters NOT kept: {error:#}\n"))
            }
        };
    }

    fn notice(&mut self, notice: Notice) {
        let told = match &notice {
            Notice::Simulator(event) => self.narrator.simulator(event, self.mission),
            Notice::Streamer(event) => self.narrator.streamer(event),
            // Not worth a word unless something was wrong.
            Notice::Counts { faults, .. } if !faults.any() => Ok(()),
            Notice::Disconnected { .. } | Notice::TurnedAway { .. } => {
                self.narrator.warn(&format!("{notice}\n"))
            }
            other => self.narrator.say(&format!("{other}\n")),
        };
        // A terminal that is gone is no reason to stop flying.
        let _ = told;
    }

    fn frame(&mut self, now: TimeUs, link: Link, bytes: &[u8]) {
        let Some(i) = self.recordings.iter().position(|recording| recording.records(link)) else { return };
        match self.recordings[i].write(now, bytes) {
            Ok(None) => {}
            Ok(Some(name)) => {
                _ = self.narrator.say(&format!("simulated time has started over: recording to {name}\n"));
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
