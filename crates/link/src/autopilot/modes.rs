//! Flight modes by PX4's numbers: `custom_mode = main << 16 | sub << 24`.
//!
//! All of PX4's modes are known by name, so that a refusal can say what was asked. Flown are **OFFBOARD**
//! (setpoints from a companion), the automatic modes HOLD, TAKEOFF, LAND and RETURN ([`super::navigator`]),
//! and missions ([`super::mission_flight`]), and with sticks POSCTL, ALTCTL, STABILIZED and MANUAL
//! ([`super::manual`]). HOLD is where the vehicle wakes up.

use crate::units::US_PER_S;

/// One of PX4's flight modes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum FlightMode {
    /// Sticks to attitude: to a multirotor the same as STABILIZED. Flown.
    Manual,
    /// Altitude held, sticks to attitude: flown.
    Altctl,
    /// Sticks to velocity: flown.
    Posctl,
    /// Waiting on the ground.
    AutoReady,
    /// Automatic takeoff: flown.
    AutoTakeoff,
    /// Hold: flown.
    #[default]
    AutoLoiter,
    /// A mission, item after item: flown.
    AutoMission,
    /// Return to launch: flown.
    AutoRtl,
    /// Automatic landing: flown.
    AutoLand,
    /// Sticks to body rates.
    Acro,
    /// Setpoints from a companion: flown.
    Offboard,
    /// Sticks to attitude, stabilised: flown.
    Stabilized,
}

/// Every mode with its main number, its sub-mode number and its name.
const MODES: [(FlightMode, u8, u8, &str); 12] = [
    (FlightMode::Manual, 1, 0, "MANUAL"),
    (FlightMode::Altctl, 2, 0, "ALTCTL"),
    (FlightMode::Posctl, 3, 0, "POSCTL"),
    (FlightMode::AutoReady, 4, 1, "AUTO.READY"),
    (FlightMode::AutoTakeoff, 4, 2, "AUTO.TAKEOFF"),
    (FlightMode::AutoLoiter, 4, 3, "HOLD"),
    (FlightMode::AutoMission, 4, 4, "AUTO.MISSION"),
    (FlightMode::AutoRtl, 4, 5, "AUTO.RTL"),
    (FlightMode::AutoLand, 4, 6, "AUTO.LAND"),
    (FlightMode::Acro, 5, 0, "ACRO"),
    (FlightMode::Offboard, 6, 0, "OFFBOARD"),
    (FlightMode::Stabilized, 7, 0, "STABILIZED"),
];

impl FlightMode {
    /// All modes, in PX4's order.
    pub fn all() -> impl Iterator<Item = Self> {
        MODES.into_iter().map(|(mode, ..)| mode)
    }

    fn row(self) -> (Self, u8, u8, &'static str) {
        // `MODES` lists the variants in the order of their declaration (a test sees to it).
        MODES[self as usize]
    }

    /// PX4's main mode number.
    pub fn main_number(self) -> u8 {
        self.row().1
    }

    /// PX4's sub-mode number; 0 outside AUTO.
    pub fn sub_number(self) -> u8 {
        self.row().2
    }

    /// The name ground stations know it by.
    pub fn name(self) -> &'static str {
        self.row().3
    }

    /// HEARTBEAT's `custom_mode`.
    pub fn custom_mode(self) -> u32 {
        u32::from(self.main_number()) << 16 | u32::from(self.sub_number()) << 24
    }

    /// The mode with these numbers. The sub-mode counts in AUTO only, as in PX4.
    pub fn from_numbers(main: u8, sub: u8) -> Option<Self> {
        MODES.iter().find(|&&(_, m, s, _)| m == main && (m != 4 || s == sub)).map(|&(mode, ..)| mode)
    }

    /// The mode of a `custom_mode`; `None` when no mode has it or bits outside the two numbers are set.
    pub fn from_custom_mode(custom_mode: u32) -> Option<Self> {
        let [low, middle, main, sub] = custom_mode.to_le_bytes();
        if low != 0 || middle != 0 { None } else { Self::from_numbers(main, sub) }
    }

    /// Whether arming in it, or entering it armed, sets the motors going.
    pub fn lifts_off(self) -> bool {
        matches!(self, Self::Offboard | Self::AutoTakeoff | Self::AutoMission)
            || (self.takes_sticks() && !self.holds_height())
    }

    /// Whether it is an automatic mode.
    pub fn is_auto(self) -> bool {
        self.main_number() == Self::AutoLoiter.main_number()
    }

    /// Whether it is flown with sticks.
    pub fn takes_sticks(self) -> bool {
        matches!(self, Self::Posctl | Self::Altctl | Self::Stabilized | Self::Manual)
    }

    /// Whether, of those flown with sticks, it holds the height while the throttle stick is in the middle.
    pub fn holds_height(self) -> bool {
        matches!(self, Self::Posctl | Self::Altctl)
    }

    /// Whether this autopilot flies it.
    pub fn is_flown(self) -> bool {
        let automatic = matches!(self, Self::AutoLoiter | Self::AutoTakeoff | Self::AutoLand | Self::AutoRtl);
        automatic || matches!(self, Self::Offboard | Self::AutoMission) || self.takes_sticks()
    }
}

/// Why a mode is not entered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ModeRefusal {
    /// This autopilot does not fly the mode.
    #[error("{} is not flown here", .0.name())]
    NotFlown(FlightMode),
    /// OFFBOARD without a setpoint that is young enough.
    #[error("OFFBOARD refused: no setpoint in the last {} s", *timeout_us as f64 / US_PER_S)]
    NoSetpoint {
        /// How young it has to be [us].
        timeout_us: u64,
    },
    /// It flies and there is no position or velocity that the mode could go by.
    #[error("{} refused: no valid position estimate", .0.name())]
    NoPosition(FlightMode),
    /// A mode that is flown with sticks, and there are none.
    #[error("{} refused: no manual control input", .0.name())]
    NoSticks(FlightMode),
    /// AUTO.MISSION without a mission that can be flown.
    #[error("AUTO.MISSION refused: no valid mission")]
    NoMission,
    /// A failsafe has stopped the motors for good.
    #[error("{} refused: flight terminated, start the autopilot again", .0.name())]
    Terminated(FlightMode),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regress_modes_carry_px4_numbers() {
        assert_eq!(FlightMode::Offboard.custom_mode(), 0x0006_0000);
        assert_eq!(FlightMode::AutoLoiter.custom_mode(), 0x0304_0000);
        assert_eq!(FlightMode::AutoLand.custom_mode(), 0x0604_0000);
        assert_eq!(FlightMode::Stabilized.custom_mode(), 0x0007_0000);
    }

    #[test]
    fn closed_form_numbers_and_modes_map_one_to_one() {
        for mode in FlightMode::all() {
            assert_eq!(mode.row().0, mode, "the table's order is the declaration's");
            assert_eq!(FlightMode::from_custom_mode(mode.custom_mode()), Some(mode));
            assert_eq!(FlightMode::from_numbers(mode.main_number(), mode.sub_number()), Some(mode));
        }
        for (main, sub) in [(0, 0), (8, 0), (4, 0), (4, 7), (255, 255)] {
            assert_eq!(FlightMode::from_numbers(main, sub), None);
        }
        assert_eq!(FlightMode::from_custom_mode(1), None);
    }
}
