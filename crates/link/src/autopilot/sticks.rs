//! The pilot's sticks as they are heard: which source counts, whether they are lost, whether they are moved.
//!
//! As PX4's `manual_control` module has it (v1.14.0, ManualControlSelector.cpp and ManualControl.cpp): one
//! source counts at a time. It keeps its place for as long as it goes on being heard; when it has been silent
//! for COM_RC_LOSS_T the next that is heard takes it. COM_RC_IN_MODE says who may. Sticks are **moved** when
//! one of them has been turning faster than COM_RC_STICK_OV a second, filtered over 0.1 s.

use super::FlightMode;
use crate::time::seconds;
use crate::units::US_PER_S;

/// Time constant of the filter on the sticks' speeds, PX4's MovingDiff [s].
const MOVEMENT_TAU_S: f64 = 0.1;
/// COM_RC_OVERRIDE's bits.
const OVERRIDES_AUTO: u8 = 1;
const OVERRIDES_OFFBOARD: u8 = 2;
/// COM_RCL_EXCEPT's bits.
const EXCEPT_MISSION: u8 = 1;
const EXCEPT_HOLD: u8 = 2;
const EXCEPT_OFFBOARD: u8 = 4;

/// The positions of a pilot's sticks, each -1..1 and 0 in the middle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sticks {
    /// Forward.
    pub pitch: f64,
    /// To the right.
    pub roll: f64,
    /// Up.
    pub throttle: f64,
    /// Clockwise, seen from above.
    pub yaw: f64,
}

/// Whoever sends sticks, by a number that no other has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StickSource(pub u64);

/// Whose sticks are taken: COM_RC_IN_MODE. There is no radio receiver here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StickInput {
    /// 0: a radio receiver's alone, so nobody's.
    Radio = 0,
    /// 1: those that come by MAVLink.
    Joystick = 1,
    /// 2: the receiver's or those by MAVLink, whichever are heard.
    Any = 2,
    /// 3: those of the source that was heard first, until the autopilot starts again.
    KeepFirst = 3,
    /// 4: nobody's; their loss is no loss.
    Disabled = 4,
}

impl StickInput {
    const ALL: [Self; 5] = [Self::Radio, Self::Joystick, Self::Any, Self::KeepFirst, Self::Disabled];

    /// The choice with PX4's number.
    pub fn from_number(number: f64) -> Option<Self> {
        Self::ALL.into_iter().find(|input| f64::from(*input as u8) == number)
    }
}

/// What is done with sticks, under PX4's parameter names and with PX4's defaults, except that no radio
/// receiver is waited for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StickSettings {
    /// COM_RC_IN_MODE.
    pub input: StickInput,
    /// COM_RC_LOSS_T: silence after which sticks are lost [s].
    pub timeout_s: f64,
    /// COM_RC_OVERRIDE: bit 0, moved sticks take over from automatic modes; bit 1, from OFFBOARD.
    pub overrides: u8,
    /// COM_RC_STICK_OV: speed of a stick that takes over, in percent of its half range a second.
    pub moved_percent: f64,
    /// COM_RCL_EXCEPT: bit 0, their loss means nothing in a mission; bit 1, in HOLD and TAKEOFF; bit 2, in
    /// OFFBOARD.
    pub loss_exceptions: u8,
}

impl StickSettings {
    /// PX4 v1.14's defaults, but for COM_RC_IN_MODE (PX4: 3).
    pub const DEFAULT: Self = Self {
        input: StickInput::Joystick,
        timeout_s: 0.5,
        overrides: OVERRIDES_AUTO,
        moved_percent: 30.0,
        loss_exceptions: 0,
    };

    /// Whether moved sticks take over from a mode.
    pub fn override_mode(&self, mode: FlightMode) -> bool {
        (mode.is_auto() && self.overrides & OVERRIDES_AUTO != 0)
            || (mode == FlightMode::Offboard && self.overrides & OVERRIDES_OFFBOARD != 0)
    }

    /// Whether the loss of sticks means nothing in a mode.
    pub fn excepts(&self, mode: FlightMode) -> bool {
        let bit = match mode {
            FlightMode::AutoMission => EXCEPT_MISSION,
            FlightMode::AutoLoiter | FlightMode::AutoTakeoff => EXCEPT_HOLD,
            FlightMode::Offboard => EXCEPT_OFFBOARD,
            _ => 0,
        };
        self.loss_exceptions & bit != 0
    }
}

/// The source that counts, with what it said last.
#[derive(Clone, Copy, Debug)]
struct Chosen {
    source: StickSource,
    at_us: u64,
    sticks: Sticks,
}

/// How fast a stick moves.
#[derive(Clone, Copy, Debug, Default)]
struct Movement {
    last: Option<f64>,
    per_s: f64,
}

impl Movement {
    fn update(&mut self, position: f64, dt_s: f64) {
        let Some(last) = self.last.replace(position).filter(|_| dt_s > 0.0) else { return };
        let alpha = dt_s / (MOVEMENT_TAU_S + dt_s);
        self.per_s += alpha * ((position - last) / dt_s - self.per_s);
    }
}

/// What becomes of sticks that were heard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Taken {
    /// They do not count: another source does, or none may.
    Ignored,
    /// They count, and are at rest.
    Resting,
    /// They count, and are being moved.
    Moving,
}

/// Sticks as they are heard from several sources, of which one counts.
#[derive(Clone, Copy, Debug, Default)]
pub struct StickReceiver {
    chosen: Option<Chosen>,
    first: Option<StickSource>,
    movements: [Movement; 4],
}

impl StickReceiver {
    /// Takes the sticks of a source.
    pub fn take(
        &mut self,
        now_us: u64,
        source: StickSource,
        sticks: Sticks,
        settings: &StickSettings,
    ) -> Taken {
        if !self.may_send(source, settings.input) {
            return Taken::Ignored;
        }
        let before = self.chosen.filter(|chosen| is_fresh(chosen, now_us, settings));
        if before.is_some_and(|chosen| chosen.source != source) {
            return Taken::Ignored;
        }
        match before {
            Some(chosen) => {
                let dt_s = seconds(now_us.saturating_sub(chosen.at_us));
                for (movement, position) in self.movements.iter_mut().zip(sticks.positions()) {
                    movement.update(position, dt_s);
                }
            }
            None => {
                self.movements = sticks.positions().map(|at| Movement { last: Some(at), per_s: 0.0 });
            }
        }
        self.first.get_or_insert(source);
        self.chosen = Some(Chosen { source, at_us: now_us, sticks });
        let fast = settings.moved_percent / 100.0;
        if self.movements.iter().any(|m| m.per_s.abs() > fast) { Taken::Moving } else { Taken::Resting }
    }

    /// The sticks that count at `now_us`; `None`: they are lost.
    pub fn at(&self, now_us: u64, settings: &StickSettings) -> Option<Sticks> {
        let chosen = self.chosen.filter(|chosen| is_fresh(chosen, now_us, settings))?;
        self.may_send(chosen.source, settings.input).then_some(chosen.sticks)
    }

    fn may_send(&self, source: StickSource, input: StickInput) -> bool {
        match input {
            StickInput::Joystick | StickInput::Any => true,
            StickInput::KeepFirst => self.first.is_none_or(|first| first == source),
            StickInput::Radio | StickInput::Disabled => false,
        }
    }
}

fn is_fresh(chosen: &Chosen, now_us: u64, settings: &StickSettings) -> bool {
    // One from the future is from before simulated time began.
    now_us.checked_sub(chosen.at_us).is_some_and(|age_us| (age_us as f64) < settings.timeout_s * US_PER_S)
}

impl Sticks {
    fn positions(&self) -> [f64; 4] {
        [self.pitch, self.roll, self.throttle, self.yaw]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GROUND: StickSource = StickSource(1);
    const COMPANION: StickSource = StickSource(2);

    fn forward(pitch: f64) -> Sticks {
        Sticks { pitch, ..Sticks::default() }
    }

    fn with(input: StickInput) -> StickSettings {
        StickSettings { input, ..StickSettings::DEFAULT }
    }

    /// PX4's ManualControlSelectorTest.cpp: the first that is heard counts until it times out, then the next.
    #[test]
    fn reference_one_source_counts_until_it_is_silent() {
        let settings = StickSettings::DEFAULT;
        let mut heard = StickReceiver::default();
        assert_eq!(heard.at(0, &settings), None);
        assert_eq!(heard.take(0, GROUND, forward(0.1), &settings), Taken::Resting);
        assert_eq!(heard.take(100_000, COMPANION, forward(0.2), &settings), Taken::Ignored);
        assert_eq!(heard.at(499_999, &settings), Some(forward(0.1)));
        assert_eq!(heard.at(500_000, &settings), None, "COM_RC_LOSS_T");
        assert_eq!(heard.take(500_000, COMPANION, forward(0.2), &settings), Taken::Resting);
        assert_eq!(heard.take(600_000, GROUND, forward(0.3), &settings), Taken::Ignored);
        assert_eq!(heard.at(600_000, &settings), Some(forward(0.2)));
        assert_eq!(heard.at(499_999, &settings), None, "a clock that has started over");
    }

    /// The values of COM_RC_IN_MODE: who may send, and that the first is kept.
    #[test]
    fn reference_the_input_mode_says_who_may_send() {
        for input in StickInput::ALL {
            let settings = with(input);
            let mut heard = StickReceiver::default();
            let taken = heard.take(0, GROUND, forward(0.1), &settings) != Taken::Ignored;
            assert_eq!(taken, !matches!(input, StickInput::Radio | StickInput::Disabled), "{input:?}");
            let next = heard.take(9_000_000, COMPANION, forward(0.2), &settings) != Taken::Ignored;
            assert_eq!(next, matches!(input, StickInput::Joystick | StickInput::Any), "{input:?}");
            assert_eq!(StickInput::from_number(f64::from(input as u8)), Some(input));
        }
        assert_eq!((StickInput::from_number(5.0), StickInput::from_number(0.5)), (None, None));
    }

    /// At a steady speed v the filter's answer after n samples is v (1 - (tau/(tau + dt))^n): at 25 Hz,
    /// 1 - (0.1/0.14)^n, which passes 0.3/s with the third sample at 0.5/s, and never at 0.29/s.
    #[test]
    fn closed_form_sticks_are_moved_when_they_turn_faster_than_the_threshold() {
        let settings = StickSettings::DEFAULT;
        let first_moving = |speed_per_s: f64| {
            let mut heard = StickReceiver::default();
            (0..25u32).find(|&i| {
                let at = u64::from(i) * 40_000;
                heard.take(at, GROUND, forward(speed_per_s * seconds(at)), &settings) == Taken::Moving
            })
        };
        assert_eq!((first_moving(0.5), first_moving(-0.5), first_moving(0.29)), (Some(3), Some(3), None));
        // A jump between two sources, or after a silence, is no movement.
        let mut heard = StickReceiver::default();
        heard.take(0, GROUND, forward(-1.0), &settings);
        assert_eq!(heard.take(600_000, GROUND, forward(1.0), &settings), Taken::Resting);
    }

    #[test]
    fn reference_overrides_and_exceptions_are_px4s_bits() {
        let overrides = |overrides| StickSettings { overrides, ..StickSettings::DEFAULT };
        assert!(overrides(1).override_mode(FlightMode::AutoLoiter));
        assert!(!overrides(1).override_mode(FlightMode::Offboard));
        assert!(overrides(2).override_mode(FlightMode::Offboard));
        assert!(!overrides(2).override_mode(FlightMode::AutoLand));
        assert!(!overrides(3).override_mode(FlightMode::Altctl));
        let excepts = |bits| {
            let settings = StickSettings { loss_exceptions: bits, ..StickSettings::DEFAULT };
            FlightMode::all().filter(move |mode| settings.excepts(*mode)).collect::<Vec<_>>()
        };
        assert_eq!(excepts(1), [FlightMode::AutoMission]);
        assert_eq!(excepts(2), [FlightMode::AutoTakeoff, FlightMode::AutoLoiter]);
        assert_eq!(excepts(4), [FlightMode::Offboard]);
        assert_eq!(excepts(0), []);
    }
}
