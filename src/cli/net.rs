//! What the verbs with sockets share: the runtime, Ctrl-C, and an observer that tells and records.

use std::future::Future;
use std::pin::Pin;

use anyhow::Context;

use super::args::{NetArgs, SpeedArg};
use super::narrative::Narrator;
use super::outcome::{BadInput, Failure};
use super::output::{LateFile, OutputFolder};
use crate::config::Mission;
use crate::link::shell::{Notice, Observer, Ports, Speed};
use crate::link::{FlightLog, Link, LogEntry, TimeUs, Tlog};

/// MAVLink system of the vehicle of an instance, as PX4 counts: instance 0 is system 1.
pub fn system_of(net: &NetArgs) -> u8 {
    u8::try_from(net.instance.saturating_add(1)).unwrap_or(u8::MAX)
}

/// The ports of the instance.
///
/// # Errors
/// [`Failure::BadInput`] when there is no such instance.
pub fn ports_of(net: &NetArgs) -> Result<Ports, Failure> {
    Ports::of_instance(net.instance).bad_input()
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

/// A `.tlog` in a result folder, written as frames come.
pub type TlogFile = Tlog<LateFile>;

/// A `.tlog` of a mission; the file is made with the first frame.
pub fn tlog(folder: &OutputFolder, name: &str, mission: &Mission) -> TlogFile {
    Tlog::new(folder.late(name), mission.epoch_unix_us)
}

/// A log of the autopilot's, `flight.ulg` for the first flight, `flight_2.ulg` for the next one.
type FlightLogFile = FlightLog<LateFile>;

/// Where the autopilot's flight logs go.
struct FlightLogs {
    folder: OutputFolder,
    begun: usize,
    current: Option<FlightLogFile>,
}

impl FlightLogs {
    fn write(&mut self, vehicle_name: &str, entry: &LogEntry) -> std::io::Result<()> {
        if let LogEntry::Begin(at, parameters) = entry {
            if let Some(log) = self.current.take() {
                log.finish()?;
            }
            self.begun += 1;
            let name =
                if self.begun == 1 { "flight.ulg".to_owned() } else { format!("flight_{}.ulg", self.begun) };
            self.current = Some(FlightLog::new(self.folder.late(&name), *at, vehicle_name, parameters)?);
        }
        self.current.as_mut().map_or(Ok(()), |log| log.write(entry))
    }
}

/// Tells notices, records frames and the autopilot's flight.
pub struct Reporter<'a> {
    narrator: Narrator,
    mission: &'a Mission,
    hil: Option<TlogFile>,
    vehicle: Option<TlogFile>,
    flights: Option<FlightLogs>,
    failed: Option<std::io::Error>,
}

impl<'a> Reporter<'a> {
    /// A reporter with the logs that it shall write: simulator's link, and all others.
    pub fn new(
        narrator: Narrator,
        mission: &'a Mission,
        hil: Option<TlogFile>,
        vehicle: Option<TlogFile>,
    ) -> Self {
        Self { narrator, mission, hil, vehicle, flights: None, failed: None }
    }

    /// Writes the autopilot's flight logs too.
    pub fn with_flight_logs(mut self, folder: &OutputFolder) -> Self {
        self.flights = Some(FlightLogs { folder: folder.clone(), begun: 0, current: None });
        self
    }

    /// Closes the logs.
    ///
    /// # Errors
    /// [`Failure::BadInput`] when something could not be written, now or before.
    pub fn finish(self) -> Result<(), Failure> {
        if let Some(error) = self.failed {
            return Err(anyhow::Error::from(error).context("cannot write the .tlog or .ulg")).bad_input();
        }
        for tlog in [self.hil, self.vehicle].into_iter().flatten() {
            tlog.finish().context("cannot write the .tlog").bad_input()?;
        }
        if let Some(log) = self.flights.and_then(|flights| flights.current) {
            log.finish().context("cannot write the .ulg").bad_input()?;
        }
        Ok(())
    }
}

impl Observer for Reporter<'_> {
    fn notice(&mut self, notice: Notice) {
        let told = match &notice {
            Notice::Simulator(event) => self.narrator.simulator(event, self.mission),
            Notice::Streamer(event) => self.narrator.streamer(event),
            other => self.narrator.say(&format!("{other}\n")),
        };
        // A terminal that is gone is no reason to stop flying.
        let _ = told;
    }

    fn frame(&mut self, now: TimeUs, link: Link, bytes: &[u8]) {
        let tlog = if link == Link::Simulator { &mut self.hil } else { &mut self.vehicle };
        if let Some(Err(error)) = tlog.as_mut().map(|tlog| tlog.write(now, bytes)) {
            *tlog = None;
            self.failed.get_or_insert(error);
        }
    }

    fn log(&mut self, entry: LogEntry) {
        let name = &self.mission.vehicle_name;
        if let Some(Err(error)) = self.flights.as_mut().map(|flights| flights.write(name, &entry)) {
            self.flights = None;
            self.failed.get_or_insert(error);
        }
    }
}
