//! What the verbs with sockets share: the runtime, Ctrl-C, and an observer that tells and records.

use std::future::Future;
use std::pin::Pin;

use anyhow::Context;

use super::args::{LinkArgs, NetArgs, SpeedArg};
use super::narrative::Narrator;
use super::outcome::{BadInput, Failure};
use super::output::{LateFile, OutputFolder};
use crate::config::Mission;
use crate::link::shell::{Notice, Observer, Ports, Speed, Wiring};
use crate::link::signing::Key;
use crate::link::{Link, TimeUs, Tlog};

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

/// The key that frames are signed with, if there is one.
///
/// # Errors
/// [`Failure::BadInput`] when its file cannot be read or holds none.
pub fn key_of(net: &NetArgs) -> Result<Option<Key>, Failure> {
    let Some(path) = &net.sign_key else { return Ok(None) };
    let context = || format!("{}: no key to sign with", path.display());
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

/// A `.tlog` in a result folder, written as frames come.
pub type TlogFile = Tlog<LateFile>;

/// A `.tlog` of a mission; the file is made with the first frame.
pub fn tlog(folder: &OutputFolder, name: &str, mission: &Mission) -> TlogFile {
    Tlog::new(folder.late(name), mission.epoch_unix_us)
}

/// Tells notices, records frames.
pub struct Reporter<'a> {
    narrator: Narrator,
    mission: &'a Mission,
    hil: Option<TlogFile>,
    vehicle: Option<TlogFile>,
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
        Self { narrator, mission, hil, vehicle, failed: None }
    }

    /// Closes the logs.
    ///
    /// # Errors
    /// [`Failure::BadInput`] when something could not be written, now or before.
    pub fn finish(self) -> Result<(), Failure> {
        if let Some(error) = self.failed {
            return Err(anyhow::Error::from(error).context("cannot write the .tlog")).bad_input();
        }
        for tlog in [self.hil, self.vehicle].into_iter().flatten() {
            tlog.finish().context("cannot write the .tlog").bad_input()?;
        }
        Ok(())
    }
}

impl Observer for Reporter<'_> {
    fn notice(&mut self, notice: Notice) {
        let told = match &notice {
            Notice::Simulator(event) => self.narrator.simulator(event, self.mission),
            Notice::Streamer(event) => self.narrator.streamer(event),
            // Not worth a word unless something was wrong.
            Notice::Counts { faults, .. } if !faults.any() => Ok(()),
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
}
