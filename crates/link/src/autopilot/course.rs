//! The mode that flies, and where it leads: to where an automatic mode goes, by the mission on board, or to
//! what sticks ask for.

use super::event::{EventQueue, Severity};
use super::flight::StepState;
use super::manual::{Circumstances, ManualFlight, ManualSetpoint};
use super::mission_flight::{Contact, MissionFlight, Turn};
use super::modes::FlightMode;
use super::navigator::{Guidance, Navigator, Situation};
use super::setpoint::YawSetpoint;
use super::settings::Settings;
use super::sticks::Sticks;
use crate::control::ControlSettings;
use crate::frames::yaw;

/// How a mode is entered.
#[derive(Clone, Debug)]
pub(super) enum Entry {
    /// The crew has chosen it.
    Chosen(FlightMode, Navigator),
    /// A failsafe flies it in place of the crew's, which is kept.
    Diverted(FlightMode, Navigator),
    /// The crew's mode again, which a failsafe has flown in place of.
    Resumed,
}

/// The mode with what it is about.
#[derive(Clone, Debug, Default)]
pub(super) struct Course {
    mode: FlightMode,
    /// The mode that the crew has chosen, and where it leads, while a failsafe flies in its place.
    kept: Option<(FlightMode, Navigator)>,
    /// A mode has been chosen since the start.
    chosen: bool,
    navigator: Navigator,
    manual: ManualFlight,
    mission: MissionFlight,
}

impl Course {
    pub fn mode(&self) -> FlightMode {
        self.mode
    }

    /// The mode that the crew has chosen.
    pub fn intended(&self) -> FlightMode {
        self.kept.as_ref().map_or(self.mode, |(mode, _)| *mode)
    }

    /// Whether a failsafe flies in place of the crew's mode.
    pub fn is_diverted(&self) -> bool {
        self.kept.is_some()
    }

    /// Whether a mode has been chosen since the start.
    pub fn is_chosen(&self) -> bool {
        self.chosen
    }

    /// The mission on board.
    pub fn mission(&self) -> &MissionFlight {
        &self.mission
    }

    /// The mission on board, to be changed.
    pub fn mission_mut(&mut self) -> &mut MissionFlight {
        &mut self.mission
    }

    /// Whether it leads to the ground.
    pub fn is_landing(&self) -> bool {
        match self.mode {
            FlightMode::AutoLand | FlightMode::AutoRtl => self.navigator.is_landing(),
            FlightMode::AutoMission => self.mission.is_landing(),
            _ => false,
        }
    }

    /// Whether it leads straight up.
    pub fn is_taking_off(&self) -> bool {
        match self.mode {
            FlightMode::AutoTakeoff => true,
            FlightMode::AutoMission => self.mission.is_climbing(),
            _ => false,
        }
    }

    /// Changes the horizontal speed of the automatic mode, until the next one [m/s]; `None` is MPC_XY_CRUISE.
    pub fn set_speed(&mut self, speed_m_s: Option<f64>) {
        match self.mode {
            FlightMode::AutoMission => self.mission.set_speed(speed_m_s),
            _ => self.navigator.set_speed(speed_m_s),
        }
    }

    /// Enters a mode, or begins it anew.
    pub fn enter(&mut self, entry: Entry) {
        let kept = self.kept.take();
        match (entry, kept) {
            (Entry::Chosen(mode, navigator), _) => self.begin(mode, navigator),
            (Entry::Diverted(mode, navigator), kept) => {
                let kept = kept.unwrap_or((self.mode, self.navigator));
                self.begin(mode, navigator);
                self.kept = Some(kept);
            }
            // HOLD where the vehicle is, any other as it was chosen.
            (Entry::Resumed, Some((FlightMode::AutoLoiter, _))) => {
                self.begin(FlightMode::AutoLoiter, Navigator::default());
            }
            (Entry::Resumed, Some((mode, navigator))) => self.begin(mode, navigator),
            (Entry::Resumed, None) => {}
        }
    }

    fn begin(&mut self, mode: FlightMode, navigator: Navigator) {
        if mode != self.mode {
            self.manual = ManualFlight::default();
        }
        if mode == FlightMode::AutoMission {
            self.mission.begin(self.mode == FlightMode::AutoLoiter);
        }
        (self.mode, self.chosen) = (mode, true);
        self.navigator = navigator;
    }

    /// The vehicle was armed: what an automatic mode has seen before does not count.
    pub fn armed(&mut self) {
        if self.mode != FlightMode::AutoTakeoff {
            self.navigator = Navigator::begin(self.mode);
        }
        if self.mode == FlightMode::AutoMission {
            self.mission.begin(false);
        }
    }

    /// The vehicle was disarmed: the crew's mode begins anew.
    pub fn disarmed(&mut self) {
        self.enter(Entry::Resumed);
        self.navigator = Navigator::begin(self.mode);
        self.mission.disarmed();
    }

    /// Time has started over: HOLD, with the mission at its first item.
    pub fn restart(&mut self) {
        self.mission.restart();
        *self = Self { mission: std::mem::take(&mut self.mission), ..Self::default() };
    }

    /// Waits on the ground for sticks.
    pub fn wait(&mut self) {
        self.manual = ManualFlight::default();
    }

    /// The next step of a mode that is flown with sticks.
    pub fn follow_sticks(
        &mut self,
        sticks: &Sticks,
        home_down_m: f64,
        state: &StepState<'_>,
        ControlSettings { airframe, limits, .. }: &ControlSettings,
        settings: &Settings,
    ) -> ManualSetpoint {
        let circumstances = Circumstances {
            p_ned: state.p_ned,
            v_ned: state.measurement.v_ned,
            yaw_rad: yaw(state.measurement.q_ned_from_body),
            dt_s: state.dt_s,
            home_down_m,
            near_ground_m_s: [settings.land_speed_m_s, settings.takeoff_speed_m_s],
            limits: settings.greatest,
            yaw_rate_rad_s: limits.yaw_rate_command_rad_s,
            gravity_m_s2: airframe.gravity_m_s2,
            hover_thrust: airframe.weight_n() / airframe.lift_max_n,
            settings: &settings.manual,
        };
        self.manual.step(self.mode, sticks, &circumstances)
    }

    /// The next step of an automatic mode, `None` with the motors off; what follows a mode that is at its end
    /// is entered.
    pub fn guide(
        &mut self,
        situation: &Situation<'_>,
        contact: Contact,
        events: &mut EventQueue,
    ) -> Option<Guidance> {
        if self.mode == FlightMode::AutoMission {
            let (guidance, turn) = self.mission.step(situation, contact, events);
            if let Some(turn) = turn {
                self.follow_mission(turn, events);
            }
            return guidance;
        }
        let (guidance, arrived) = self.navigator.step(situation);
        if arrived && self.mode == FlightMode::AutoTakeoff {
            self.follow_takeoff(situation.settings.mission.follows_takeoff, events);
        }
        Some(guidance)
    }

    /// COM_TAKEOFF_ACT: a takeoff is followed by the mission, if there is one that can be flown, or by HOLD.
    fn follow_takeoff(&mut self, by_mission: bool, events: &mut EventQueue) {
        if by_mission && self.mission.is_feasible() {
            events.say(Severity::Info, "takeoff done: AUTO.MISSION");
            self.begin(FlightMode::AutoMission, Navigator::default());
        } else {
            self.mode = FlightMode::AutoLoiter;
            events.say(Severity::Info, "takeoff done: HOLD");
        }
    }

    /// Enters the mode that the mission leads to.
    fn follow_mission(&mut self, turn: Turn, events: &mut EventQueue) {
        let (mode, navigator) = match turn {
            Turn::Hold(None) => (FlightMode::AutoLoiter, Navigator::default()),
            Turn::Hold(Some(p_ned)) => (FlightMode::AutoLoiter, Navigator::hold_at(p_ned, YawSetpoint::Keep)),
            Turn::Return => (FlightMode::AutoRtl, Navigator::begin(FlightMode::AutoRtl)),
        };
        events.say(Severity::Info, format!("mode {}", mode.name()));
        self.begin(mode, navigator);
    }
}
