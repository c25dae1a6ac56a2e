//! A drop flown by PX4: simulator, parachute and streamer in this process, PX4 in its own.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::cpu::{Cpu, Pinned};
use super::guest::{Patience, Watched};
use super::process::Px4Process;
use super::upload::{Preparation, preparation};
use super::{BuildFolder, Px4Error};
use crate::cli::clock::Stopwatch;
use crate::cli::drop::Flown;
use crate::cli::narrative::Narrator;
use crate::cli::net::{Reporter, block_on};
use crate::cli::outcome::{BadInput, Failure};
use crate::cli::output::OutputFolder;
use crate::cli::sessions;
use samara::config::{Mission, Px4Clock};
use samara::control::px4::timing::ALIGNS_G0;
use samara::link::shell::{Ports, Speed, run_hosted_drop, system_of_instance};
use samara::link::streamer::{Clock, Procedure};
use samara::params::ParameterFile;
use samara::report::FlownBy;
use samara::trajectory::Trajectory;
use samara::units::STANDARD_GRAVITY_M_S2;

/// PX4's working directory in the folder of the results.
const WORK: &str = "px4";
/// PX4's log, beside the other files of the flight.
pub const LOG: &str = "flight.ulg";

/// A drop to be flown by PX4.
#[derive(Clone, Copy, Debug)]
pub struct Px4Drop<'a> {
    /// Where PX4 is.
    pub build: &'a BuildFolder,
    /// Its number.
    pub instance: u16,
    /// Where it and the simulator run.
    pub cpu: Cpu,
    /// How fast simulated time shall run.
    pub speed: Speed,
    /// Parameters to be given to it, in place of the mission's gains.
    pub parameters: Option<&'a ParameterFile>,
    /// Whether the plan's acceleration is sent with its velocity.
    pub feed_forward: bool,
    /// How long it may keep us waiting.
    pub patience: Patience,
}

/// Flies it, to the end or until PX4 is gone or refuses; both are told.
///
/// # Errors
/// [`Failure::BadInput`] when PX4 cannot be started, does not suit the mission, or a port or file cannot be had.
pub fn fly(
    drop: &Px4Drop<'_>,
    mission: &Mission,
    trajectory: &Trajectory,
    folder: &OutputFolder,
    narrator: &Narrator,
) -> Result<Flown, Failure> {
    let (mixer, preparation) = prepare(drop.build, mission, trajectory, drop.parameters)?;
    let Preparation { envelope, upload, .. } = preparation;
    let procedure = Procedure { envelope, upload: upload.parameters };
    let ports = Ports::of_instance(drop.instance).bad_input()?;
    let system = system_of_instance(drop.instance).bad_input()?;
    let froude = sessions::froude(mission);
    let streamer = sessions::StreamerChoice {
        clock: Clock::Caller,
        procedure: Some(procedure),
        feed_forward: drop.feed_forward,
        froude,
    };
    let sessions = (
        sessions::simulator(mission, system, froude),
        sessions::streamer(mission, trajectory.clone(), system, streamer),
    );
    // What PX4 says to ground stations goes by its own sockets.
    folder.remove(&["vehicle.tlog"])?;
    let mut reporter = Reporter::new(*narrator, mission).recording(folder, &["hil", "companion"]);
    let watch = Stopwatch::start();
    // What the thread starts runs where the thread does.
    let pinned = Pinned::pin(drop.cpu, drop.instance).bad_input()?;
    let start = || -> Result<Watched, anyhow::Error> {
        let px4 = Px4Process::start(drop.build, drop.instance, mixer, &folder.path().join(WORK))?;
        pinned.step_aside()?;
        // A terminal that is gone is no reason not to fly.
        _ = narrator.say(&format!("PX4 started in {}\n", px4.work().display()));
        Ok(Watched::new(px4, drop.patience, ports.simulator))
    };
    let (flown, Watched { mut px4, .. }) =
        block_on(|stop| run_hosted_drop(sessions, &ports, drop.speed, start, &mut reporter, stop))?
            .bad_input()?;
    let wall_ms = watch.ms();
    px4.stop();
    std::mem::drop(pinned);
    reporter.finish()?;
    if let Some(gone) = &flown.gone {
        narrator.warn(&format!("{gone}\n"))?;
    } else if let Some(failure) = flown.streamer.failure() {
        narrator.aside(&format!("gave up: {failure}\n"));
    }
    if flown.unfenced > 0 {
        let n = flown.unfenced;
        narrator.warn(&format!(
            "{n} times PX4 did not answer a TIMESYNC within 1 s: setpoints may have been late\n"
        ))?;
    }
    keep_log(px4.work(), folder)?;
    let simulated_s = flown.simulator.sim().time_s();
    let record = flown.simulator.record().clone();
    Ok(Flown {
        by: FlownBy { name: "px4", version: flown.streamer.vehicle_version().map(|v| v.to_string()) },
        trouble: flown.gone.or_else(|| flown.streamer.failure().map(str::to_owned)),
        log: flown.simulator.into_log(),
        record,
        real_time_factor: 1e3 * simulated_s / wall_ms,
    })
}

/// What PX4 needs for the flight, without starting it: its mixer, and what it is given.
///
/// # Errors
/// [`Failure::BadInput`] when PX4 does not suit the mission, its vehicle or its gains.
pub fn prepare(
    build: &BuildFolder,
    mission: &Mission,
    trajectory: &Trajectory,
    parameters: Option<&ParameterFile>,
) -> Result<(Option<&'static str>, Preparation), Failure> {
    suits(mission).bad_input()?;
    let mixer = build.mixer(&mission.vehicle_name, &mission.vehicle).bad_input()?;
    Ok((mixer, preparation(mission, trajectory, parameters, mixer.is_some())?))
}

/// Whether PX4 of that number can be started, and its simulator have its ports, now.
///
/// # Errors
/// [`Failure::BadInput`] with who or what is in the way.
pub fn look(instance: u16) -> Result<(), Failure> {
    #[cfg(unix)]
    super::lock::look(instance).bad_input()?;
    Ports::of_instance(instance).and_then(|ports| ports.look()).bad_input()
}

/// Whether PX4 can fly there at all.
///
/// # Errors
/// [`Px4Error`] with what PX4 cannot do with, and what to do.
pub fn suits(mission: &Mission) -> Result<(), Px4Error> {
    let gravity_m_s2 = mission.site.environment.gravity_m_s2;
    let scaled = mission.px4.clock == Px4Clock::Froude;
    if !scaled && !ALIGNS_G0.contains(&(gravity_m_s2 / STANDARD_GRAVITY_M_S2)) {
        return Err(Px4Error::Gravity { gravity_m_s2 });
    }
    if mission.sensors.barometer.noise_hpa == 0.0 {
        return Err(Px4Error::Barometer);
    }
    Ok(())
}

/// Copies PX4's newest log to the results.
fn keep_log(work: &Path, folder: &OutputFolder) -> Result<(), Failure> {
    let Some(log) = newest(&work.join("log"), "ulg") else { return folder.remove(&[LOG]) };
    folder
        .write(LOG, |out| {
            #[expect(clippy::disallowed_methods, reason = "the log of the process that was started here")]
            let mut file = fs::File::open(&log)?;
            io::copy(&mut file, out).map(|_| ())
        })
        .map(|_| ())
}

/// The last file by name with an extension in a folder or those in it: PX4 names them by date and time.
fn newest(folder: &Path, extension: &str) -> Option<PathBuf> {
    let entries = fs::read_dir(folder).ok()?.filter_map(|entry| Some(entry.ok()?.path()));
    entries
        .filter_map(|path| match path.is_dir() {
            true => newest(&path, extension),
            false => path.extension().is_some_and(|e| e == extension).then_some(path),
        })
        .max()
}
