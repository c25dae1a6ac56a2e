//! PX4 on a board, on a serial line: hardware in the loop, in real time. Simulator, parachute and streamer
//! are in this process; others reach the board through it.

use std::path::Path;

use super::contract::{Flown, Pilot, PilotOption, PilotedDrop};
use super::px4::upload::{of_any, whole};
use crate::cli::answer::{BadInput as _, Failure};
use crate::cli::args::ChoiceArgs;
use crate::cli::mission::mission_for_px4;
use crate::cli::narrator::Narrator;
use crate::cli::reporter::Reporter;
use crate::cli::system::block_on;
use crate::cli::terminal::print_remarks;
use samara::config::{Mission, check_for_px4};
use samara::link::hil::Stamps;
use samara::link::shell::{Attendance, Ports, SerialUrl, Speed, run_board, system_of_instance};
use samara::link::streamer::Clock;
use samara::link::{Link, TimeUs, parties};
use samara::params::ParameterFile;
use samara::report::FlownBy;
use samara::report::params::given_parameters;
use samara::trajectory::Trajectory;

/// The options of a drop that a board has.
pub const OPTIONS: &[PilotOption] = &[PilotOption::Speed, PilotOption::Px4sOwnGains];

/// A board on its line.
pub struct Board {
    line: SerialUrl,
    /// Parameters in place of the mission's gains.
    parameters: Option<ParameterFile>,
}

impl Board {
    /// The board on a line with its parameters, and the mission for it.
    pub fn new(line: &SerialUrl, path: &Path, choice: &ChoiceArgs) -> Result<(Self, Mission), Failure> {
        line.sensor_period_us().bad_input()?;
        let (mut mission, parameters) = mission_for_px4(path, choice, None)?;
        if mission.release.free_fall.is_some() {
            return Err(Failure::input(format!(
                "{}: release.free_fall is found by the board's clock, which a drop with --serial does not go by: `samara sim --serial` \
                 and `samara stream --upload` fly it",
                mission.file.display()
            )));
        }
        mission.note_choice("autopilot", "px4 on a board");
        Ok((Self { line: line.clone(), parameters }, mission))
    }
}

/// Refuses a line that is too slow, and another pace than the board's.
pub fn check_line(line: &SerialUrl, speed: Speed) -> Result<(), Failure> {
    line.sensor_period_us().bad_input()?;
    match speed == Speed::Factor(1.0) {
        true => Ok(()),
        false => {
            Err(Failure::input("--speed: 1 is expected with --serial: a board lives in real time".to_owned()))
        }
    }
}

/// Simulated seconds per second of the board's clock.
pub fn real_time(mission: &Mission) -> f64 {
    parties::froude(mission).map_or(1.0, |froude| froude.k())
}

/// The period of HIL_SENSOR on a line, which is said [us].
pub fn sensor_period_us(line: &SerialUrl, narrator: &Narrator) -> Result<TimeUs, Failure> {
    let period_us = line.sensor_period_us().bad_input()?;
    let (rate_hz, usual) = (1_000_000 / period_us, 1_000_000 / SerialUrl::SENSOR_PERIOD_US);
    let less =
        if rate_hz < usual { format!(", not at {usual}: the line carries no more") } else { String::new() };
    narrator.say(&format!("{line}: HIL_SENSOR at {rate_hz} Hz{less}\n"));
    Ok(period_us)
}

impl Pilot for Board {
    fn name(&self) -> &'static str {
        "px4"
    }

    fn introduction(&self) -> &'static str {
        ", flown by PX4 on a board: PROPELLERS OFF"
    }

    fn check(&self, mission: &Mission, trajectory: &Trajectory, _: u16) -> Result<(), Failure> {
        let (_, remarks) = of_any(mission, trajectory, self.parameters.as_ref())?;
        print_remarks(&mission.control.gains_name, &remarks);
        Ok(())
    }

    fn parameters(&self, mission: &Mission, trajectory: &Trajectory) -> Result<Option<String>, Failure> {
        check_for_px4(mission).bad_input()?;
        Ok(Some(given_parameters(mission, &whole(mission, trajectory, self.parameters.as_ref(), false)?)))
    }

    fn takes_ports(&self) -> bool {
        true
    }

    /// Flies the drop to the end, or until the board refuses.
    fn fly(&self, flight: &PilotedDrop<'_>) -> Result<Flown, Failure> {
        let PilotedDrop { mission, trajectory, folder, narrator, instance, speed, .. } = *flight;
        if speed != Speed::Max {
            check_line(&self.line, speed)?;
        }
        let ports = Ports::of_instance(instance).bad_input()?;
        let system = system_of_instance(instance).bad_input()?;
        let (procedure, _) = of_any(mission, trajectory, self.parameters.as_ref())?;
        let streamer = parties::StreamerChoice {
            clock: Clock::Caller,
            procedure: Some(procedure),
            froude: parties::froude(mission),
            replan: None,
        };
        let period_us = sensor_period_us(&self.line, narrator)?;
        let sessions = (
            parties::simulator_in_real_time(mission, system, period_us, Stamps::Simulated),
            Some(parties::streamer(mission, trajectory.clone(), system, streamer)),
        );
        let pace = (real_time(mission), Attendance::default());
        let mut reporter = Reporter::new(narrator, mission)
            .recording(folder, &[Link::Simulator, Link::Api])
            .shown(flight.live);
        let (simulator, streamer) =
            block_on(|stop| run_board(sessions, &ports, &self.line, pace, &mut reporter, stop))?
                .bad_input()?;
        reporter.finish()?;
        let failure = streamer.as_ref().and_then(|s| s.failure().map(str::to_owned));
        if let Some(failure) = &failure {
            narrator.aside(&format!("gave up: {failure}\n"));
        }
        let version = streamer.as_ref().and_then(|s| s.vehicle_version()).map(|v| v.to_string());
        let record = simulator.run().record().clone();
        Ok(Flown {
            by: Some(FlownBy { name: self.name(), version }),
            trouble: failure,
            ..Flown::of_simulator(simulator.into_run().into_log(), record)
        })
    }
}
