//! Real PX4 as the autopilot: started from its build folder, given its parameters, flown and stopped;
//! simulator, parachute and streamer are in this process, PX4 in its own.
//!
//! | file | holds |
//! |---|---|
//! | `build_folder` | a build folder of PX4: what is in it, which model and mixer suit a vehicle |
//! | `beginning` | what its start-up script is told of the vehicle, and how |
//! | `work_dir` | PX4's working directory: made anew, of our own making only |
//! | `process` | the process: started in its working directory, watched, stopped with all its children |
//! | `process_group` | the group of processes that ends with this program, whatever ends it |
//! | `lock` | whether an instance is running already, and what holds it |
//! | `idle` | whether PX4 has done what there was to do |
//! | `cpu` | PX4 on one processor, the simulator on others |
//! | `watched` | PX4 as the simulator watches it: gone, or silent for too long |
//! | [`upload`] | the parameters that PX4 is given |

mod beginning;
mod build_folder;
mod cpu;
mod idle;
#[cfg(unix)]
mod lock;
#[cfg_attr(not(unix), path = "process_elsewhere.rs")]
mod process;
#[cfg(unix)]
mod process_group;
pub mod upload;
mod watched;
#[cfg(unix)]
mod work_dir;

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::contract::{Flown, Pilot, PilotOption, PilotedDrop};
use crate::cli::answer::{BadInput as _, Failure};
use crate::cli::args::ChoiceArgs;
use crate::cli::mission::mission_for_px4;
use crate::cli::reporter::Reporter;
use crate::cli::results::OutputFolder;
use crate::cli::system::{Stopwatch, block_on};
use crate::cli::terminal::print_remarks;
use beginning::Beginning;
use build_folder::BuildFolder;
pub use cpu::Cpu;
use cpu::Pinned;
use process::Px4Process;
use samara::config::{Mission, check_for_px4};
use samara::control::px4::Version;
use samara::link::shell::{Ports, run_hosted_drop, system_of_instance};
use samara::link::streamer::{Clock, Procedure, SolvedBy, Uploads};
use samara::link::{Link, parties};
use samara::params::px4_required::estimators_window;
use samara::params::{Against, ParameterFile};
use samara::report::FlownBy;
use samara::report::params::given_parameters;
use samara::trajectory::Trajectory;
use upload::{Preparation, preparation};
pub use watched::Patience;
use watched::WatchedPx4;

/// The options of a drop that PX4 has.
pub const OPTIONS: &[PilotOption] = &[
    PilotOption::Speed,
    PilotOption::Cpu,
    PilotOption::Patience,
    PilotOption::Px4sOwnGains,
    PilotOption::Replan,
];

/// PX4's working directory in the folder of the results.
const WORK: &str = "px4";
/// PX4's log, beside the other files of the flight.
const LOG: &str = "flight.ulg";

/// What can be set of PX4's flights besides its parameters.
#[derive(Clone, Copy, Debug)]
pub struct Px4Settings {
    /// The processors that PX4 and the simulator run on.
    pub cpu: Cpu,
    /// How long PX4 may keep the simulator waiting.
    pub patience: Patience,
}

/// PX4, from a build folder.
pub struct Px4 {
    build: BuildFolder,
    /// Parameters in place of the mission's gains.
    parameters: Option<ParameterFile>,
    settings: Px4Settings,
}

impl Px4 {
    /// The PX4 of a build folder with its parameters, and the mission for it.
    pub fn new(
        build: &Path,
        mission: &Path,
        choice: &ChoiceArgs,
        settings: Px4Settings,
    ) -> Result<(Self, Mission), Failure> {
        let build = BuildFolder::open(build).bad_input()?;
        let flown = build.version().ok().map(|version| Against::flown(version.number));
        let (mut mission, parameters) = mission_for_px4(mission, choice, flown)?;
        mission.note_choice("autopilot", "px4");
        Ok((Self { build, parameters, settings }, mission))
    }

    /// What PX4 needs for the flight, without starting it: its mixer, and what it is given.
    fn prepare(
        &self,
        mission: &Mission,
        trajectory: &Trajectory,
    ) -> Result<(Option<&'static str>, Preparation), Failure> {
        check_for_px4(mission).bad_input()?;
        let mixer = self.build.mixer(&mission.vehicle_name, &mission.vehicle).bad_input()?;
        let mut prepared = preparation(mission, trajectory, self.parameters.as_ref(), mixer.is_some())?;
        if mixer.is_none() {
            prepared.upload.parameters.extend(BuildFolder::outputs(mission.vehicle.rotors.len()));
        }
        Ok((mixer, prepared))
    }
}

impl Pilot for Px4 {
    fn name(&self) -> &'static str {
        "px4"
    }

    fn introduction(&self) -> &'static str {
        ", flown by PX4"
    }

    fn check(&self, mission: &Mission, trajectory: &Trajectory, _: u16) -> Result<(), Failure> {
        let (_, preparation) = self.prepare(mission, trajectory)?;
        print_remarks(&mission.control.gains_name, &preparation.upload.remarks);
        Ok(())
    }

    fn parameters(&self, mission: &Mission, trajectory: &Trajectory) -> Result<Option<String>, Failure> {
        let (_, preparation) = self.prepare(mission, trajectory)?;
        Ok(Some(given_parameters(mission, &preparation.into_export(self.parameters.is_some()))))
    }

    fn takes_ports(&self) -> bool {
        true
    }

    fn check_instance(&self, instance: u16) -> Result<(), Failure> {
        look(instance)?;
        Ports::of_instance(instance).and_then(|ports| ports.look()).bad_input()
    }

    /// Flies the drop to the end, or until PX4 is gone or refuses; both are reported.
    fn fly(&self, flight: &PilotedDrop<'_>) -> Result<Flown, Failure> {
        let PilotedDrop { mission, trajectory, folder, narrator, instance, speed, .. } = *flight;
        let Px4Settings { cpu, patience } = self.settings;
        let (mixer, preparation) = self.prepare(mission, trajectory)?;
        let Preparation { envelope, upload, .. } = preparation;
        let by = self.build.told_by().bad_input()?;
        // A PX4 that mixes by a file has the window that it needs.
        let at_start = if mixer.is_some() { Vec::new() } else { estimators_window(&envelope, by) };
        let procedure = Some(Procedure {
            envelope,
            canopy_moves: mission.release.parachute.suspension.is_some(),
            uploads: Uploads::of_one(upload.parameters),
            event_texts: self.build.event_texts(),
        });
        let beginning = Beginning { mixer, parameters: at_start, by };
        let ports = Ports::of_instance(instance).bad_input()?;
        let system = system_of_instance(instance).bad_input()?;
        let froude = parties::froude(mission);
        let replan = flight.replan.map(|setup| (setup.clone(), SolvedBy::Session));
        let streamer = parties::StreamerChoice { clock: Clock::Caller, procedure, froude, replan };
        let sessions = (
            parties::simulator(mission, system, froude, None),
            parties::streamer(mission, trajectory.clone(), system, streamer),
        );
        // What PX4 says to ground stations goes by its own sockets.
        let mut reporter = Reporter::new(narrator, mission)
            .recording(folder, &[Link::Simulator, Link::Api])
            .shown(flight.live);
        let watch = Stopwatch::start();
        // What the thread starts runs where the thread does.
        let pinned = Pinned::pin(cpu, instance).bad_input()?;
        let start = || -> Result<WatchedPx4, anyhow::Error> {
            let px4 = Px4Process::start(&self.build, instance, &beginning, &folder.path().join(WORK))?;
            pinned.step_aside()?;
            narrator.say(&format!("PX4 started in {}\n", px4.work().display()));
            Ok(WatchedPx4::new(px4, patience, ports.simulator))
        };
        let (flown, WatchedPx4 { mut px4, .. }) =
            block_on(|stop| run_hosted_drop(sessions, &ports, speed, start, &mut reporter, stop))?
                .bad_input()?;
        let wall_ms = watch.ms();
        px4.stop();
        drop(pinned);
        reporter.finish()?;
        if let Some(gone) = &flown.gone {
            narrator.warn(&format!("{gone}\n"));
        } else if let Some(failure) = flown.streamer.failure() {
            narrator.aside(&format!("gave up: {failure}\n"));
        }
        if flown.unfenced > 0 {
            let n = flown.unfenced;
            narrator.warn(&format!(
                "{n} times PX4 did not answer a TIMESYNC within 1 s: setpoints may have been late\n"
            ));
        }
        keep_log(px4.work(), folder)?;
        let simulated_s = flown.simulator.run().simulation().time_s();
        let version = flown.streamer.vehicle_version().map(|v| v.to_string());
        Ok(Flown {
            replans: flown.streamer.replans().to_vec(),
            fall: flown.streamer.fall(),
            by: Some(FlownBy { name: self.name(), version }),
            trouble: flown.gone.or_else(|| flown.streamer.failure().map(str::to_owned)),
            record: flown.simulator.run().record().clone(),
            log: flown.simulator.into_run().into_log(),
            real_time_factor: Some(1e3 * simulated_s / wall_ms),
        })
    }
}

/// The program of a build folder, and the version of PX4 that it is.
pub fn found(build: &Path) -> Result<(PathBuf, &'static Version), Failure> {
    let build = BuildFolder::open(build).bad_input()?;
    Ok((build.program(), build.version().bad_input()?))
}

/// Refuses where a PX4 of this number runs already.
pub fn look(instance: u16) -> Result<(), Failure> {
    #[cfg(unix)]
    lock::look(instance).bad_input()?;
    #[cfg(not(unix))]
    let _ = instance;
    Ok(())
}

/// Copies PX4's newest log to the results.
fn keep_log(work: &Path, folder: &OutputFolder) -> Result<(), Failure> {
    let Some(log) = newest(&work.join("log"), "ulg") else { return Ok(()) };
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
