//! The flight of a drop by the reference autopilot, over the wire in memory: as fast as it goes, or at a
//! speed to watch.

use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use super::contract::{Flown, Pilot, PilotOption, PilotedDrop};
use crate::cli::answer::{BadInput as _, Failure};
use crate::cli::args::{ChoiceArgs, EstimatorChoice, StateArgs};
use crate::cli::mission::{mission_with_a_drop, note_estimator};
use crate::cli::reporter::Reporter;
use crate::cli::system::{Stopwatch, block_on, interrupt_flag};
use crate::cli::terminal::print_remarks;
use samara::config::Mission;
use samara::link::parties::{self, StreamerChoice};
use samara::link::shell::{Notice, Observer, Ports, Speed, run_watched_drop, system_of_instance};
use samara::link::streamer::SolvedBy;
use samara::link::{AutopilotSession, Link, Lockstep};
use samara::report::FlownBy;
use samara::trajectory::Trajectory;

/// The options of a drop that the reference autopilot has.
pub const OPTIONS: &[PilotOption] = &[
    PilotOption::Estimator,
    PilotOption::Link,
    PilotOption::SignKey,
    PilotOption::Speed,
    PilotOption::Replan,
];

/// samara's own autopilot.
#[derive(Default)]
pub struct Reference {
    /// A parameter file that it loads besides the mission's gains.
    parameters: Option<PathBuf>,
    estimator: EstimatorChoice,
}

impl Reference {
    /// The autopilot with what is chosen of it, and the mission for it.
    pub fn new(path: &Path, choice: &ChoiceArgs, state: &StateArgs) -> Result<(Self, Mission), Failure> {
        let mut mission = mission_with_a_drop(path, choice)?;
        note_estimator(&mut mission, state);
        Ok((Self { parameters: choice.params.clone(), estimator: state.estimator }, mission))
    }

    fn on_estimator(&self) -> bool {
        self.estimator == EstimatorChoice::Ekf
    }
}

impl Pilot for Reference {
    fn name(&self) -> &'static str {
        match self.estimator {
            EstimatorChoice::Truth => "reference",
            EstimatorChoice::Ekf => "reference_ekf",
        }
    }

    fn introduction(&self) -> &'static str {
        match self.estimator {
            EstimatorChoice::Truth => "",
            EstimatorChoice::Ekf => ", on its own estimator",
        }
    }

    fn check(&self, mission: &Mission, _: &Trajectory, instance: u16) -> Result<(), Failure> {
        if !self.on_estimator() {
            print_remarks(&mission.name, &mission.faults.remarks_on_truth());
        }
        let Some(path) = &self.parameters else { return Ok(()) };
        let system = system_of_instance(instance).bad_input()?;
        let (_, remarks) =
            parties::autopilot(mission, Some(path), self.on_estimator(), system).bad_input()?;
        print_remarks(path.display(), &remarks);
        Ok(())
    }

    /// Flies the drop; at a speed to watch the ground links are open.
    fn fly(&self, flight: &PilotedDrop<'_>) -> Result<Flown, Failure> {
        let PilotedDrop { mission, folder, narrator, wiring, .. } = *flight;
        let system = system_of_instance(flight.instance).bad_input()?;
        let ports = Ports::of_instance(flight.instance).bad_input()?;
        let (autopilot, _) =
            parties::autopilot(mission, self.parameters.as_deref(), self.on_estimator(), system)
                .bad_input()?;
        // Simulated time stands still while the session solves.
        let replan = flight.replan.map(|setup| (setup.clone(), SolvedBy::Session));
        let choice = StreamerChoice { replan, ..StreamerChoice::default() };
        let mut wire = Lockstep::new(
            parties::simulator(mission, system, None, None),
            autopilot,
            parties::streamer(mission, flight.trajectory.clone(), system, choice),
        );
        let mut reporter = Reporter::new(narrator, mission)
            .recording(folder, &[Link::Simulator, Link::GroundStation, Link::Api])
            .with_autopilot(folder)
            .shown(flight.live);
        let watch = Stopwatch::start();
        narrator.hanging(mission);
        match flight.speed {
            Speed::Max => {
                let by_ctrl_c;
                let stop = match flight.stop {
                    Some(stop) => stop,
                    None => {
                        by_ctrl_c = interrupt_flag()?;
                        &by_ctrl_c
                    }
                };
                while wire
                    .step(&mut |now, link, bytes| reporter.frame(now, link, bytes))
                    .map_err(anyhow::Error::from)?
                {
                    report_events(&mut wire, &mut reporter);
                    if stop.load(Ordering::Relaxed) {
                        wire.stop(&mut |now, sent| reporter.frame(now, sent.link, &sent.bytes));
                        break;
                    }
                }
                report_events(&mut wire, &mut reporter);
            }
            speed => {
                let observer = &mut reporter;
                wire = block_on(|stop| run_watched_drop(wire, &ports, wiring, speed, observer, stop))?
                    .bad_input()?;
            }
        }
        let flown_s = wire.simulator.run().simulation().time_s();
        reporter.finish()?;
        Ok(Flown {
            record: wire.simulator.run().record().clone(),
            real_time_factor: Some(1e3 * flown_s / watch.ms()),
            by: Some(FlownBy { name: self.name(), version: None }),
            // Of a single flight, verdict and events report all that there is.
            trouble: flight.stop.and(wire.streamer.failure()).map(str::to_owned),
            replans: wire.streamer.replans().to_vec(),
            fall: wire.streamer.fall(),
            log: wire.simulator.into_run().into_log(),
        })
    }
}

fn report_events(wire: &mut Lockstep<AutopilotSession>, reporter: &mut Reporter<'_>) {
    while let Some(event) = wire.simulator.poll_event() {
        reporter.notice(Notice::Simulator(event));
    }
    while let Some(event) = wire.streamer.poll_event() {
        reporter.notice(Notice::Streamer(event));
    }
    while let Some(entry) = wire.autopilot.poll_log() {
        reporter.log(entry);
    }
}
