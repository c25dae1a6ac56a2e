//! The mission on board: loaded, checked, started, flown, and what follows where it ends.

use nalgebra::Vector3;

use super::flight::StepState;
use super::mission_flight::feasibility::{Surroundings, check};
use super::mission_flight::task::steps;
use super::mission_flight::{Contact, MissionFlight, Turn};
use super::missions::Item;
use super::navigator::Situation;
use super::{Autopilot, FlightMode, ModeRefusal, Navigator, Severity};
use crate::model::Environment;

/// Slower than this, what has not flown yet stands, or hangs still [m/s]; PX4's landing detector has it.
const STILL_M_S: f64 = 0.3;

impl Autopilot {
    /// The mission on board.
    pub fn mission(&self) -> &MissionFlight {
        &self.mission
    }

    /// Takes a mission, with places on the local frame of a site; `start` makes an item the current one.
    /// Whether it can be flown is checked at once, or as soon as position and home are known, and what is
    /// wrong is said. A mission that is being flown goes on by the new items, or with HOLD where they are not
    /// flown.
    pub fn load_mission(&mut self, items: &[Item], start: Option<u16>, environment: &Environment) {
        self.mission.load(steps(items, environment), start);
        if self.mission.awaits_check() && !(self.state.is_some() && self.home_ned.is_some()) {
            self.say(Severity::Info, "Not yet ready for mission, no position lock.");
        }
        self.check_mission();
        if self.mode == FlightMode::AutoMission && self.armed && !self.mission.is_feasible() {
            self.say(Severity::Critical, "No valid mission available, loitering");
            self.enter(FlightMode::AutoLoiter, Navigator::default());
        }
    }

    /// Makes another mission item the current one; false when there is no such item.
    pub fn set_mission_item(&mut self, seq: u16) -> bool {
        self.mission.set_current(seq)
    }

    /// A command of the mission's current item for whoever is to obey it: DO_GRIPPER, DO_SET_HOME.
    pub fn take_mission_command(&mut self) -> Option<Item> {
        self.mission.take_command()
    }

    /// The release that a mission item has asked for was acknowledged.
    pub fn acknowledge_mission_release(&mut self) {
        self.mission.acknowledge_release();
    }

    /// Checks a mission that has not been checked, once position and home are known.
    pub(super) fn check_mission(&mut self) {
        let (Some(home_ned), Some((_, measurement)), true) =
            (self.home_ned, self.state, self.mission.awaits_check())
        else {
            return;
        };
        let around = Surroundings {
            home_ned,
            p_ned: self.p_ned,
            landed: self.has_landed(&measurement.v_ned),
            fence: &self.fence,
            settings: &self.settings,
        };
        let checked = check(self.mission.steps(), &around);
        self.mission.note_feasible(checked.is_ok());
        match checked {
            Ok(below_home) => {
                for number in below_home {
                    self.say(Severity::Warning, format!("Warning: Waypoint {number} below home"));
                }
            }
            Err(reason) => self.say(Severity::Critical, reason.to_string()),
        }
    }

    /// Whether there is a mission that can be flown.
    ///
    /// # Errors
    /// [`ModeRefusal::NoMission`].
    pub(super) fn check_has_mission(&self) -> Result<(), ModeRefusal> {
        if self.mission.is_feasible() { Ok(()) } else { Err(ModeRefusal::NoMission) }
    }

    /// Flies the mission, and changes to the mode that follows it.
    pub(super) fn fly_mission(&mut self, situation: &Situation<'_>, state: &StepState<'_>) {
        let contact = Contact { landed: self.has_landed(&situation.v_ned), flown: self.flying };
        let (guidance, turn) = self.mission.step(situation, contact);
        while let Some(event) = self.mission.take_event() {
            self.events.say(event);
        }
        match guidance {
            Some(guidance) => self.loops.follow(state, &guidance, situation.settings),
            None => self.loops.switch_off(),
        }
        match turn {
            Some(Turn::Hold(place)) => {
                let hold = place.map(|p_ned| Navigator::hold_at(p_ned, super::YawSetpoint::Keep));
                self.change_mode(FlightMode::AutoLoiter, hold.unwrap_or_default());
            }
            Some(Turn::Return) => {
                self.change_mode(FlightMode::AutoRtl, Navigator::begin(FlightMode::AutoRtl));
            }
            None => {}
        }
    }

    /// Enters a mode that the mission leads to, and says so.
    fn change_mode(&mut self, mode: FlightMode, navigator: Navigator) {
        self.say(Severity::Info, format!("mode {}", mode.name()));
        self.enter(mode, navigator);
    }

    /// Whether it stands, or hangs still, with this velocity, NED [m/s].
    fn has_landed(&self, v_ned: &Vector3<f64>) -> bool {
        if self.flying { self.land_detector.is_landed() } else { v_ned.norm() < STILL_M_S }
    }
}
