//! When the autopilot acts on its own: setpoints, ground stations, sticks, fence, battery, and its own
//! health. Actions, when each ends, and who may lead out of one are PX4 v1.14's (`failsafe/failsafe.cpp`,
//! `failsafe/framework.cpp`), chosen by PX4's parameters ([`Settings`]) and taken at once, as with
//! COM_FAIL_ACT_T 0.
//!
//! A failsafe flies in place of the mode that the crew has chosen and does not forget it: where the action
//! ends, that mode flies again. Of several the severest acts. A crew that chooses a mode while one acts has
//! that mode, and the failsafe is a warning as long as its cause lasts; the next that arises acts again.
//! Only what flies is watched, so that an armed vehicle under its canopy or on the ground is left alone; but
//! for setpoints, without which OFFBOARD is not flown anywhere.

pub mod page;

use nalgebra::Vector3;

use super::FlightMode;
use super::settings::{Action, BatteryPolicy, Settings};

/// What is watched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Condition {
    /// No setpoint for OFFBOARD for too long.
    SetpointsLost,
    /// No ground station for too long.
    DataLinkLost,
    /// No sticks for too long.
    SticksLost,
    /// Too far from home.
    FenceDistance,
    /// Too high above home.
    FenceHeight,
    /// Outside all areas to stay in.
    FenceLeft,
    /// Inside an area to keep out of.
    FenceEntered,
    /// Battery low.
    BatteryLow,
    /// Battery critical.
    BatteryCritical,
    /// Battery about to be empty.
    BatteryEmergency,
    /// No position or velocity that is good enough for the mode.
    NoPosition,
    /// No attitude.
    NoAttitude,
    /// Tilted too far for too long, soon after arming.
    AttitudeAtTakeoff,
    /// Tilted too far for too long.
    Attitude,
    /// A motor has failed.
    Motor,
}

/// When an action ends: PX4's `ClearCondition`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ends {
    /// With its cause.
    WithItsCause,
    /// When a mode is chosen, or the vehicle disarmed, after its cause is over.
    ModeChosen,
    /// With a new start of the autopilot.
    Never,
}

impl Condition {
    /// All conditions in the order of their declaration, with words for the crew.
    const ALL: [(Self, &'static str); 15] = [
        (Self::SetpointsLost, "OFFBOARD lost"),
        (Self::DataLinkLost, "Connection to ground station lost"),
        (Self::SticksLost, "Manual control lost"),
        (Self::FenceDistance, "Geofence: maximum distance exceeded"),
        (Self::FenceHeight, "Geofence: maximum height exceeded"),
        (Self::FenceLeft, "Geofence: outside the area to stay in"),
        (Self::FenceEntered, "Geofence: inside an area to keep out of"),
        (Self::BatteryLow, "Low battery level"),
        (Self::BatteryCritical, "Critical battery level"),
        (Self::BatteryEmergency, "Dangerous battery level"),
        (Self::NoPosition, "No valid position estimate"),
        (Self::NoAttitude, "No valid attitude estimate"),
        (Self::AttitudeAtTakeoff, "Attitude failure detected soon after arming"),
        (Self::Attitude, "Attitude failure detected"),
        (Self::Motor, "Motor failure detected"),
    ];

    /// Words for the crew.
    pub fn text(self) -> &'static str {
        Self::ALL[self as usize].1
    }

    /// What the settings want done about it in a mode.
    pub fn action(self, settings: &Settings, mode: FlightMode) -> Action {
        match self {
            Self::SetpointsLost => settings.setpoint_loss,
            Self::DataLinkLost => settings.data_link_loss,
            Self::SticksLost => settings.stick_loss,
            Self::FenceDistance | Self::FenceHeight | Self::FenceLeft | Self::FenceEntered => settings.fence,
            Self::BatteryLow => Action::Warn,
            Self::BatteryCritical => match settings.battery {
                BatteryPolicy::Warn => Action::Warn,
                BatteryPolicy::Return | BatteryPolicy::ReturnThenLand => Action::Return,
                BatteryPolicy::Land => Action::Land,
            },
            Self::BatteryEmergency => match settings.battery {
                BatteryPolicy::Warn => Action::Warn,
                BatteryPolicy::Return => Action::Return,
                BatteryPolicy::Land | BatteryPolicy::ReturnThenLand => Action::Land,
            },
            // COM_POSCTL_NAVL 0.
            Self::NoPosition if mode == FlightMode::Posctl => Action::Altitude,
            // What can be flown of what is severer is seen to where the action is chosen.
            Self::NoPosition | Self::NoAttitude => Action::Return,
            Self::AttitudeAtTakeoff => Action::Disarm,
            Self::Attitude => settings.health.attitude_failure(),
            Self::Motor => settings.health.motor_failure,
        }
    }

    /// When an action that it has led to ends.
    pub fn ends(self, action: Action) -> Ends {
        use Action::{Hold, Land, Return, Terminate};
        match (self, action) {
            (_, Terminate) => Ends::Never,
            (Self::DataLinkLost | Self::SticksLost, Return)
            | (
                Self::FenceDistance | Self::FenceHeight | Self::FenceLeft | Self::FenceEntered,
                Hold | Return,
            )
            | (Self::Motor, Land | Return) => Ends::ModeChosen,
            _ => Ends::WithItsCause,
        }
    }

    /// Whether it is the lack of what the mode needs, so that another mode may be flown on: moved sticks lead
    /// out of what it has led to, as out of the others only the choice of a mode does.
    fn is_of_the_mode(self) -> bool {
        matches!(self, Self::SetpointsLost | Self::NoPosition | Self::NoAttitude)
    }

    fn holds(self, settings: &Settings, seen: &Seen) -> bool {
        let beyond = |distance_m: f64, limit_m: f64| limit_m > 0.0 && distance_m > limit_m;
        let below = |threshold: f64| seen.charge.is_some_and(|charge| charge < threshold);
        match self {
            Self::SetpointsLost => seen.lacks_setpoint,
            Self::DataLinkLost => {
                seen.silence_s > settings.data_link_timeout_s && seen.mode != FlightMode::AutoLand
            }
            Self::SticksLost => seen.sticks_lost,
            Self::FenceDistance => beyond(seen.from_home_ned_m.xy().norm(), settings.fence_radius_m),
            Self::FenceHeight => beyond(-seen.from_home_ned_m.z, settings.fence_height_m),
            Self::FenceLeft => seen.left_fence,
            Self::FenceEntered => seen.entered_fence,
            Self::BatteryLow => below(settings.battery_low),
            Self::BatteryCritical => below(settings.battery_critical),
            Self::BatteryEmergency => below(settings.battery_emergency),
            Self::NoPosition => seen.lacks_position,
            Self::NoAttitude => seen.lacks_attitude,
            Self::AttitudeAtTakeoff => seen.tilted && seen.armed_for_s < settings.health.lockdown_s,
            Self::Attitude => seen.tilted && seen.armed_for_s >= settings.health.lockdown_s,
            Self::Motor => seen.motor_failed,
        }
    }
}

/// What there is to judge by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// The mode that the crew has chosen.
    pub mode: FlightMode,
    /// Whether it flies and does not stand: otherwise only setpoints are watched.
    pub in_air: bool,
    /// Whether the mode is OFFBOARD without a setpoint that is young enough.
    pub lacks_setpoint: bool,
    /// Time since a ground station was heard, or since arming if that is less [s].
    pub silence_s: f64,
    /// Whether there were sticks, there are none, and that matters in the mode.
    pub sticks_lost: bool,
    /// Position from home, NED [m].
    pub from_home_ned_m: Vector3<f64>,
    /// Whether it is outside all areas to stay in.
    pub left_fence: bool,
    /// Whether it is in an area to keep out of.
    pub entered_fence: bool,
    /// Share of the battery's charge, 0..1; `None` without a battery that reports it.
    pub charge: Option<f64>,
    /// Whether the mode needs a position or a velocity that is not valid.
    pub lacks_position: bool,
    /// Whether there is a position that modes which need one can be flown by.
    pub knows_position: bool,
    /// Whether no attitude has come for too long.
    pub lacks_attitude: bool,
    /// Whether it has been tilted too far for too long.
    pub tilted: bool,
    /// Whether a motor has failed.
    pub motor_failed: bool,
    /// Time since arming [s].
    pub armed_for_s: f64,
}

impl Seen {
    /// The action, or the next severer one that can be flown.
    fn possible(&self, wanted: Action) -> Action {
        use Action::{Altitude, Descend, Hold, Land, Position, Return, Stabilized, Terminate};
        let by_place = |action| matches!(action, Position | Hold | Return | Land);
        let can = |action| {
            action == Terminate || !(self.lacks_attitude || (by_place(action) && !self.knows_position))
        };
        let flown = [Position, Altitude, Stabilized, Hold, Return, Land, Descend, Terminate];
        let found = flown.into_iter().skip_while(|action| *action != wanted).find(|action| can(*action));
        found.unwrap_or(wanted)
    }
}

/// What the crew has done since the last look.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Crew {
    /// It has chosen a mode.
    pub chose_a_mode: bool,
    /// It has moved sticks that may take over.
    pub moved_sticks: bool,
}

/// What a look comes to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Decision {
    /// What has arisen since the last look and wants at least a warning.
    pub arisen: Vec<Condition>,
    /// What is to be done from now on; up to [`Action::Warn`] the mode flies.
    pub action: Action,
    /// Whether moved sticks take over, with POSCTL.
    pub sticks_take_over: bool,
}

/// An action that is due.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Due {
    action: Action,
    ends: Ends,
}

/// Which conditions hold, what is due for them, and what is done.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Watch {
    holds: [bool; Condition::ALL.len()],
    due: [Option<Due>; Condition::ALL.len()],
    action: Action,
    /// The crew flies although something severer than a warning is due.
    taken_over: bool,
}

impl Watch {
    /// Takes a look: what has arisen, and what is to be done.
    pub fn look(&mut self, settings: &Settings, seen: &Seen, crew: Crew) -> Decision {
        if crew.chose_a_mode || self.taken_over {
            self.end(Ends::ModeChosen);
        }
        let mut arisen = Vec::new();
        for (i, (condition, _)) in Condition::ALL.into_iter().enumerate() {
            // What has landed keeps what it has landed by.
            if !seen.in_air && condition != Condition::SetpointsLost {
                continue;
            }
            let (before, wanted) = (self.holds[i], condition.action(settings, seen.mode));
            self.holds[i] = condition.holds(settings, seen);
            if !self.holds[i] || wanted == Action::Nothing {
                self.due[i] = self.due[i].filter(|due| due.ends != Ends::WithItsCause);
                continue;
            }
            let is_new = self.due[i].is_none();
            let ends = self.due[i].map_or_else(|| condition.ends(wanted), |due| due.ends);
            self.due[i] = Some(Due { action: wanted, ends });
            self.taken_over &= !(is_new && wanted >= Action::Hold);
            if is_new || !before {
                arisen.push(condition);
            }
        }
        let (action, sticks_take_over) = self.decide(seen, crew);
        self.action = action;
        Decision { arisen, action, sticks_take_over }
    }

    /// What is to be done, and whether moved sticks take over.
    fn decide(&mut self, seen: &Seen, crew: Crew) -> (Action, bool) {
        let due =
            || Condition::ALL.into_iter().zip(self.due).filter_map(|((c, _), due)| Some((c, due?.action)));
        let severest = due().map(|(_, action)| action).max().unwrap_or_default();
        let by_sticks = crew.moved_sticks && due().all(|(condition, _)| condition.is_of_the_mode());
        // Who chooses a mode in the very step in which something arises has not yet heard of it.
        let by_mode = crew.chose_a_mode && self.action == seen.possible(severest);
        let yields = (Action::Hold..=Action::Descend).contains(&severest);
        if yields && (self.taken_over || by_mode || by_sticks) {
            let sticks_take_over = by_sticks && !self.taken_over && !by_mode;
            self.taken_over = true;
            let fallback = match sticks_take_over {
                true if seen.knows_position => Action::Nothing,
                true => Action::Altitude,
                false => due()
                    .filter(|(c, _)| c.is_of_the_mode())
                    .map(|(_, action)| action)
                    .max()
                    .unwrap_or_default(),
            };
            return (seen.possible(fallback).max(Action::Warn), sticks_take_over);
        }
        self.taken_over = false;
        // What lands already does not fly home.
        let lands = seen.mode == FlightMode::AutoLand && severest == Action::Return && !seen.lacks_position;
        (if lands { Action::Warn } else { seen.possible(severest) }, false)
    }

    /// Ends the actions of a kind whose causes are over.
    fn end(&mut self, ends: Ends) {
        for (due, holds) in self.due.iter_mut().zip(self.holds) {
            *due = due.filter(|due| holds || due.ends != ends);
        }
    }

    /// What is done since the last look.
    pub fn action(&self) -> Action {
        self.action
    }

    /// Whether the vehicle was outside the fence at the last look.
    pub fn fence_is_breached(&self) -> bool {
        use Condition::{FenceDistance, FenceEntered, FenceHeight, FenceLeft};
        [FenceDistance, FenceHeight, FenceLeft, FenceEntered].into_iter().any(|c| self.holds[c as usize])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::Gains;

    const CALM: Seen = Seen {
        mode: FlightMode::Offboard,
        in_air: true,
        lacks_setpoint: false,
        silence_s: 0.0,
        sticks_lost: false,
        from_home_ned_m: Vector3::new(0.0, 0.0, 0.0),
        left_fence: false,
        entered_fence: false,
        charge: None,
        lacks_position: false,
        knows_position: true,
        lacks_attitude: false,
        tilted: false,
        motor_failed: false,
        armed_for_s: 60.0,
    };
    const CHOSE: Crew = Crew { chose_a_mode: true, moved_sticks: false };
    const MOVED: Crew = Crew { chose_a_mode: false, moved_sticks: true };

    fn settings(set: &[(&str, f64)]) -> Settings {
        let mut settings = Settings::beside(&Gains::near_hover());
        for (name, value) in set {
            assert!(settings.set(name, *value), "{name}");
        }
        settings
    }

    fn fenced() -> Settings {
        settings(&[("GF_MAX_HOR_DIST", 50.0), ("GF_MAX_VER_DIST", 20.0), ("COM_LOW_BAT_ACT", 3.0)])
    }

    /// What is done from look to look, as the crew does nothing.
    fn done(settings: &Settings, looks: &[Seen]) -> Vec<Action> {
        let mut watch = Watch::default();
        looks.iter().map(|seen| watch.look(settings, seen, Crew::default()).action).collect()
    }

    #[test]
    fn the_table_is_in_the_order_of_declaration() {
        assert!(Condition::ALL.iter().enumerate().all(|(i, (condition, _))| *condition as usize == i));
    }

    #[test]
    fn closed_form_each_threshold_is_met_from_above_and_said_once() {
        let settings = settings(&[
            ("GF_MAX_HOR_DIST", 50.0),
            ("GF_MAX_VER_DIST", 20.0),
            ("GF_ACTION", 1.0),
            ("NAV_DLL_ACT", 3.0),
        ]);
        let mut watch = Watch::default();
        let mut arisen = |seen: Seen| watch.look(&settings, &seen, Crew::default()).arisen;
        let at = |x: f64, y: f64, z: f64| Seen { from_home_ned_m: Vector3::new(x, y, z), ..CALM };
        assert_eq!(arisen(at(30.0, 40.0, -20.0)), []);
        assert_eq!(arisen(at(30.0, 40.1, -20.0)), [Condition::FenceDistance]);
        assert_eq!(arisen(at(30.0, 40.1, -20.1)), [Condition::FenceHeight]);
        assert_eq!(arisen(at(30.0, 40.1, -20.1)), []);
        assert_eq!(arisen(CALM), []);
        assert_eq!(arisen(at(0.0, 99.0, 99.0)), [Condition::FenceDistance], "again, since it was over");
        assert_eq!(arisen(Seen { left_fence: true, ..CALM }), [Condition::FenceLeft]);
        assert_eq!(arisen(Seen { entered_fence: true, ..CALM }), [Condition::FenceEntered]);
        assert_eq!(arisen(Seen { silence_s: 10.0, ..CALM }), []);
        assert_eq!(arisen(Seen { silence_s: 10.1, ..CALM }), [Condition::DataLinkLost]);
        assert_eq!(arisen(Seen { sticks_lost: true, ..CALM }), [Condition::SticksLost]);
        let charge = |charge| Seen { charge: Some(charge), ..CALM };
        assert_eq!(arisen(charge(0.15)), []);
        assert_eq!(arisen(charge(0.14)), [Condition::BatteryLow]);
        assert_eq!(arisen(charge(0.01)), [Condition::BatteryCritical, Condition::BatteryEmergency]);
    }

    /// failsafe.cpp, framework.cpp of PX4 v1.14.3.
    #[test]
    fn reference_what_follows_from_ill_health_is_px4s() {
        let act = |set: &[(&str, f64)], seen: Seen| done(&settings(set), &[seen])[0];
        let tilted = |armed_for_s| Seen { tilted: true, armed_for_s, ..CALM };
        assert_eq!(act(&[], tilted(2.9)), Action::Disarm);
        assert_eq!(act(&[], tilted(3.0)), Action::Warn);
        let free = [("CBRK_FLIGHTTERM", 0.0), ("COM_LKDOWN_TKO", -1.0)];
        assert_eq!(act(&free, tilted(0.0)), Action::Terminate);
        let lost = Seen { lacks_position: true, knows_position: false, ..CALM };
        assert_eq!(act(&[], lost), Action::Descend);
        assert_eq!(act(&[], Seen { mode: FlightMode::Posctl, ..lost }), Action::Altitude);
        let velocity_lost = Seen { knows_position: true, ..lost };
        assert_eq!(act(&[], velocity_lost), Action::Return, "the first mode that can be flown");
        assert_eq!(act(&[], Seen { lacks_attitude: true, ..CALM }), Action::Terminate);
        let codes = [Action::Warn, Action::Hold, Action::Land, Action::Return, Action::Terminate];
        for (code, action) in codes.into_iter().enumerate() {
            let failed = Seen { motor_failed: true, ..CALM };
            assert_eq!(act(&[("COM_ACT_FAIL_ACT", code as f64)], failed), action);
        }
    }

    #[test]
    fn reference_battery_actions_are_px4s() {
        let act = |code: f64| {
            let settings = settings(&[("COM_LOW_BAT_ACT", code)]);
            [0.14, 0.06, 0.04].map(|charge| done(&settings, &[Seen { charge: Some(charge), ..CALM }])[0])
        };
        assert_eq!(act(0.0), [Action::Warn; 3]);
        assert_eq!(act(1.0), [Action::Warn, Action::Return, Action::Return]);
        assert_eq!(act(2.0), [Action::Warn, Action::Land, Action::Land]);
        assert_eq!(act(3.0), [Action::Warn, Action::Return, Action::Land]);
    }

    /// By hand from `ActionOptions` in failsafe.cpp of PX4 v1.14.3: what is left once the cause is over, and
    /// what of it once a mode was chosen after that.
    #[test]
    fn reference_each_action_ends_as_px4s_does() {
        let silent = Seen { silence_s: 99.0, ..CALM };
        let far = Seen { from_home_ned_m: Vector3::new(99.0, 0.0, 0.0), ..CALM };
        let no_sticks = Seen { sticks_lost: true, ..CALM };
        let no_setpoint = Seen { lacks_setpoint: true, ..CALM };
        let motor = Seen { motor_failed: true, ..CALM };
        use Action::{Hold, Land, Nothing, Return, Terminate, Warn};
        for (name, code, seen, action, after) in [
            ("COM_OBL_RC_ACT", 3.0, no_setpoint, Return, Nothing),
            ("COM_OBL_RC_ACT", 4.0, no_setpoint, Land, Nothing),
            ("COM_OBL_RC_ACT", 5.0, no_setpoint, Hold, Nothing),
            ("COM_OBL_RC_ACT", 0.0, no_setpoint, Action::Position, Nothing),
            ("NAV_DLL_ACT", 1.0, silent, Hold, Nothing),
            ("NAV_DLL_ACT", 2.0, silent, Return, Return),
            ("NAV_DLL_ACT", 3.0, silent, Land, Nothing),
            ("NAV_DLL_ACT", 5.0, silent, Terminate, Terminate),
            ("NAV_RCL_ACT", 1.0, no_sticks, Hold, Nothing),
            ("NAV_RCL_ACT", 2.0, no_sticks, Return, Return),
            ("NAV_RCL_ACT", 3.0, no_sticks, Land, Nothing),
            ("GF_ACTION", 1.0, far, Warn, Nothing),
            ("GF_ACTION", 2.0, far, Hold, Hold),
            ("GF_ACTION", 3.0, far, Return, Return),
            ("GF_ACTION", 4.0, far, Terminate, Terminate),
            ("GF_ACTION", 5.0, far, Land, Nothing),
            ("COM_ACT_FAIL_ACT", 1.0, motor, Hold, Nothing),
            ("COM_ACT_FAIL_ACT", 2.0, motor, Land, Land),
            ("COM_ACT_FAIL_ACT", 3.0, motor, Return, Return),
        ] {
            let settings = settings(&[(name, code), ("GF_MAX_HOR_DIST", 50.0)]);
            let mut watch = Watch::default();
            let mut look = |seen: &Seen, crew| watch.look(&settings, seen, crew).action;
            assert_eq!(look(&seen, Crew::default()), action, "{name} {code}");
            assert_eq!(look(&CALM, Crew::default()), after, "{name} {code}: over");
            let chosen = if after == Terminate { Terminate } else { Nothing };
            assert_eq!(look(&CALM, CHOSE), chosen, "{name} {code}: a mode chosen");
        }
        // What has landed stays landed: on the ground nothing is over.
        let settings = settings(&[("NAV_DLL_ACT", 3.0)]);
        assert_eq!(done(&settings, &[silent, Seen { in_air: false, ..CALM }]), [Land, Land]);
    }

    /// framework.cpp of PX4 v1.14.3, `getSelectedAction`: a mode that is chosen while a failsafe flies is
    /// flown, and the failsafe a warning, until the next arises.
    #[test]
    fn reference_a_crew_that_chooses_a_mode_has_it() {
        let settings = fenced();
        let far = Seen { from_home_ned_m: Vector3::new(99.0, 0.0, 0.0), ..CALM };
        let mut watch = Watch::default();
        let mut look = |seen: &Seen, crew| watch.look(&settings, seen, crew).action;
        assert_eq!(look(&far, CHOSE), Action::Hold, "chosen before anybody heard of it");
        assert_eq!(look(&far, MOVED), Action::Hold, "no sticks lead back out of a fence");
        assert_eq!(look(&far, CHOSE), Action::Warn);
        assert_eq!(look(&far, Crew::default()), Action::Warn);
        let empty = Seen { charge: Some(0.01), ..far };
        assert_eq!(look(&empty, Crew::default()), Action::Land);
        assert_eq!(look(&empty, CHOSE), Action::Warn);
        // A step after its cause the fence's Hold ends, too: a mode was chosen.
        assert_eq!(
            [look(&CALM, Crew::default()), look(&CALM, Crew::default())],
            [Action::Warn, Action::Nothing]
        );
    }

    /// framework.cpp again, of moved sticks: they lead out of what the mode lacks
    /// (`UserTakeoverAllowed::Always`).
    #[test]
    fn reference_sticks_lead_out_of_a_lost_offboard() {
        let settings = fenced();
        let lost = Seen { lacks_setpoint: true, ..CALM };
        let mut watch = Watch::default();
        assert_eq!(watch.look(&settings, &lost, Crew::default()).action, Action::Hold);
        let decision = watch.look(&settings, &lost, MOVED);
        assert_eq!((decision.action, decision.sticks_take_over), (Action::Warn, true));
        let mut watch = Watch::default();
        let blind = Seen { lacks_position: true, knows_position: false, ..lost };
        assert_eq!(watch.look(&settings, &blind, Crew::default()).action, Action::Descend);
        let decision = watch.look(&settings, &blind, MOVED);
        assert_eq!((decision.action, decision.sticks_take_over), (Action::Altitude, true));
    }

    /// A vehicle that lands already does not fly home.
    #[test]
    fn reference_a_landing_goes_on() {
        let landing = Seen { mode: FlightMode::AutoLand, ..CALM };
        let settings = settings(&[("COM_LOW_BAT_ACT", 1.0), ("NAV_DLL_ACT", 1.0)]);
        let low = Seen { charge: Some(0.01), silence_s: 99.0, ..landing };
        assert_eq!(done(&settings, &[low]), [Action::Warn]);
    }
}
