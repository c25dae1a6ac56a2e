//! Whether the motors are armed, whether they may turn, and whether they carry the vehicle.

use nalgebra::Vector3;

use super::event::{EventQueue, Severity};
use super::land_detector::{LandDetector, Look};
use super::mission_flight::Contact;

/// Slower than this, what has not flown yet stands, or hangs still [m/s]; PX4's landing detector has it.
const STILL_M_S: f64 = 0.3;

/// The motors, since they were armed.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Motors {
    /// When they were armed [us]; `None`: they are not.
    armed_at_us: Option<u64>,
    /// A mode that lifts off has been in effect since arming: every mode flies.
    engaged: bool,
    /// Thrust has been commanded since arming.
    flying: bool,
    land_detector: LandDetector,
}

impl Motors {
    pub fn is_armed(&self) -> bool {
        self.armed_at_us.is_some()
    }

    /// When they were armed [us], if they carry the vehicle.
    pub fn in_air_armed_at_us(&self) -> Option<u64> {
        self.armed_at_us.filter(|_| self.is_in_air())
    }

    /// Whether every mode flies.
    pub fn are_engaged(&self) -> bool {
        self.engaged
    }

    /// Whether thrust has been commanded since arming.
    pub fn are_flying(&self) -> bool {
        self.flying
    }

    /// Whether they carry the vehicle, which does not stand.
    pub fn is_in_air(&self) -> bool {
        self.flying && !self.is_landed()
    }

    /// Whether the vehicle stands after a flight.
    pub fn is_landed(&self) -> bool {
        self.land_detector.is_landed()
    }

    /// How long it has stood at `now_us` [us], after a flight.
    pub fn landed_for_us(&self, now_us: u64) -> Option<u64> {
        self.land_detector.landed_for_us(now_us)
    }

    /// What carries the vehicle, with this velocity, NED [m/s].
    pub fn contact(&self, v_ned: &Vector3<f64>) -> Contact {
        let landed = if self.flying { self.is_landed() } else { v_ned.norm() < STILL_M_S };
        Contact { landed, flown: self.flying }
    }

    /// Arms, in a mode that lifts off or in one that waits.
    pub fn arm(&mut self, now_us: u64, lifts_off: bool) {
        *self = Self { armed_at_us: Some(now_us), engaged: lifts_off, ..Self::default() };
    }

    /// Disarms.
    pub fn disarm(&mut self) {
        *self = Self::default();
    }

    /// A mode that lifts off has been entered: armed motors turn from now on.
    pub fn engage(&mut self) {
        self.engaged |= self.is_armed();
    }

    /// Whether the vehicle flies in a mode that waits on the ground for the stick that asks for a takeoff.
    pub fn take_off(&mut self, wanted: bool) -> bool {
        self.engaged |= wanted;
        wanted || (self.engaged && !self.is_landed())
    }

    /// Whether they are armed and stand still.
    pub fn stand_still(&self) -> bool {
        self.is_armed() && !self.engaged
    }

    /// Starts armed motors that stand still while the vehicle falls: whatever is ordered then is ordered of
    /// one that flies.
    pub fn catch(&mut self, falls: bool, events: &mut EventQueue) {
        if falls && self.stand_still() {
            self.engaged = true;
            events.say(Severity::Warning, "Motors started in the fall");
        }
    }

    /// Takes what a step of armed motors commands, and whether the vehicle has landed by it. Thrust counts
    /// as a flight where it is meant to lift: in a mode in which the throttle stick is the thrust, more than
    /// the landing detector takes for unloaded.
    pub fn look(&mut self, now_us: u64, look: &Look<'_>, events: &mut EventQueue) {
        self.flying |= look.output.collective_n > 0.0 && !(look.idle_n > 0.0 && look.is_unloaded());
        if !self.flying {
            return;
        }
        let landed = self.is_landed();
        self.land_detector.look(now_us, look);
        if self.is_landed() && !landed {
            events.say(Severity::Info, "Landing detected");
        }
    }
}
