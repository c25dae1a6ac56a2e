//! When the autopilot acts on its own: setpoints, ground stations, sticks, fence, battery, and its own
//! health. What it does is one of PX4's actions, chosen by PX4's parameters ([`Settings`]).
//!
//! A condition acts when it arises, not while it lasts: whoever chooses another mode then has it. It can
//! arise again once it has been over. A failsafe never takes a vehicle that lands or returns to something
//! milder. Only what flies is watched, so that an armed vehicle under its canopy or on the ground is left
//! alone.

use nalgebra::Vector3;

use super::settings::{Action, BatteryPolicy, Settings};

/// What is watched, besides the setpoints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Condition {
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

impl Condition {
    /// All conditions in the order of their declaration, with words for the crew.
    const ALL: [(Self, &'static str); 14] = [
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

    /// What the settings want done about it.
    pub fn action(self, settings: &Settings) -> Action {
        match self {
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
            // Modes that need a position cannot take each other's place, and every mode needs an attitude:
            // PX4's FailsafeBase::getSelectedAction.
            Self::NoPosition => Action::Descend,
            Self::NoAttitude => Action::Terminate,
            Self::AttitudeAtTakeoff => Action::Disarm,
            Self::Attitude => settings.health.attitude_failure(),
            Self::Motor => settings.health.motor_failure,
        }
    }

    fn holds(self, settings: &Settings, seen: &Seen) -> bool {
        let beyond = |distance_m: f64, limit_m: f64| limit_m > 0.0 && distance_m > limit_m;
        let below = |threshold: f64| seen.charge.is_some_and(|charge| charge < threshold);
        match self {
            Self::DataLinkLost => seen.silence_s > settings.data_link_timeout_s,
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
    /// Whether no attitude has come for too long.
    pub lacks_attitude: bool,
    /// Whether it has been tilted too far for too long.
    pub tilted: bool,
    /// Whether a motor has failed.
    pub motor_failed: bool,
    /// Time since arming [s].
    pub armed_for_s: f64,
}

/// Which conditions hold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Watch {
    holds: [bool; Condition::ALL.len()],
}

impl Watch {
    /// Takes a look; the conditions that have arisen since the last one.
    pub fn look(&mut self, settings: &Settings, seen: &Seen) -> impl Iterator<Item = Condition> + use<> {
        let before = self.holds;
        self.holds = Condition::ALL.map(|(condition, _)| condition.holds(settings, seen));
        let now = self.holds;
        (0..now.len()).filter(move |&i| now[i] && !before[i]).map(|i| Condition::ALL[i].0)
    }

    /// Whether anything held at the last look of which the settings want at least a warning.
    pub fn has_concern(&self, settings: &Settings) -> bool {
        let wanted = |condition: Condition| condition.action(settings) != Action::Nothing;
        Condition::ALL.into_iter().zip(self.holds).any(|((condition, _), holds)| holds && wanted(condition))
    }

    /// Whether the vehicle was outside the fence at the last look.
    pub fn fence_is_breached(&self) -> bool {
        let fence = |condition| {
            use Condition::{FenceDistance, FenceEntered, FenceHeight, FenceLeft};
            matches!(condition, FenceDistance | FenceHeight | FenceLeft | FenceEntered)
        };
        Condition::ALL.into_iter().zip(self.holds).any(|((condition, _), holds)| holds && fence(condition))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::Gains;

    const CALM: Seen = Seen {
        silence_s: 0.0,
        sticks_lost: false,
        from_home_ned_m: Vector3::new(0.0, 0.0, 0.0),
        left_fence: false,
        entered_fence: false,
        charge: None,
        lacks_position: false,
        lacks_attitude: false,
        tilted: false,
        motor_failed: false,
        armed_for_s: 60.0,
    };

    fn settings() -> Settings {
        let mut settings = Settings::beside(&Gains::near_hover());
        for (name, value) in [("GF_MAX_HOR_DIST", 50.0), ("GF_MAX_VER_DIST", 20.0), ("COM_LOW_BAT_ACT", 3.0)]
        {
            assert!(settings.set(name, value));
        }
        settings
    }

    #[test]
    fn the_table_is_in_the_order_of_declaration() {
        assert!(Condition::ALL.iter().enumerate().all(|(i, (condition, _))| *condition as usize == i));
    }

    #[test]
    fn closed_form_each_threshold_is_met_from_above_and_said_once() {
        let settings = settings();
        let mut watch = Watch::default();
        let mut arisen = |seen: Seen| watch.look(&settings, &seen).collect::<Vec<_>>();
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
    fn closed_form_what_follows_from_ill_health_is_px4s() {
        let mut settings = settings();
        let arisen = |settings: &Settings, seen: Seen| {
            let mut watch = Watch::default();
            watch.look(settings, &seen).map(|c| (c, c.action(settings))).collect::<Vec<_>>()
        };
        let tilted = |armed_for_s| Seen { tilted: true, armed_for_s, ..CALM };
        assert_eq!(arisen(&settings, tilted(2.9)), [(Condition::AttitudeAtTakeoff, Action::Disarm)]);
        assert_eq!(arisen(&settings, tilted(3.0)), [(Condition::Attitude, Action::Warn)]);
        assert!(settings.set("CBRK_FLIGHTTERM", 0.0) && settings.set("COM_LKDOWN_TKO", -1.0));
        assert_eq!(arisen(&settings, tilted(0.0)), [(Condition::Attitude, Action::Terminate)]);
        let lost = Seen { lacks_position: true, ..CALM };
        assert_eq!(arisen(&settings, lost), [(Condition::NoPosition, Action::Descend)]);
        let lost = Seen { lacks_attitude: true, ..CALM };
        assert_eq!(arisen(&settings, lost), [(Condition::NoAttitude, Action::Terminate)]);
        let codes = [Action::Warn, Action::Hold, Action::Land, Action::Return, Action::Terminate];
        for (code, action) in codes.into_iter().enumerate() {
            assert!(settings.set("COM_ACT_FAIL_ACT", code as f64));
            let failed = Seen { motor_failed: true, ..CALM };
            assert_eq!(arisen(&settings, failed), [(Condition::Motor, action)]);
        }
    }

    #[test]
    fn closed_form_battery_actions_are_px4s() {
        let act = |code: f64| {
            let mut settings = settings();
            assert!(settings.set("COM_LOW_BAT_ACT", code));
            [Condition::BatteryLow, Condition::BatteryCritical, Condition::BatteryEmergency]
                .map(|condition| condition.action(&settings))
        };
        assert_eq!(act(0.0), [Action::Warn; 3]);
        assert_eq!(act(1.0), [Action::Warn, Action::Return, Action::Return]);
        assert_eq!(act(2.0), [Action::Warn, Action::Land, Action::Land]);
        assert_eq!(act(3.0), [Action::Warn, Action::Return, Action::Land]);
    }
}
