//! What cuts the vehicle loose, and how that is told.

use mavlink::dialects::common::MavSeverity;

use super::super::microseconds;
use super::{ReleaseCause, SimulatorEvent, SimulatorSession};
use crate::sim::{Phase, ReleaseTrigger};

impl SimulatorSession {
    /// Looks whether the mission's trigger has come.
    pub(super) fn check_triggers(&mut self) {
        if self.sim.phase() != Phase::Hanging && self.sim.on_ground() {
            self.tell_release(ReleaseCause::Ground);
        }
        match self.config.trigger {
            ReleaseTrigger::Command => {}
            // The simulation itself has cut at the time set; it remains to be told.
            ReleaseTrigger::Time if self.sim.phase() != Phase::Hanging => {
                self.tell_release(ReleaseCause::Time);
            }
            ReleaseTrigger::Time => {}
            ReleaseTrigger::Altitude(altitude_m) => {
                let point = self.sim.environment().geo_point(&self.sim.state().body.p_ned);
                if point.altitude_m <= altitude_m {
                    self.release(ReleaseCause::Altitude);
                }
            }
            ReleaseTrigger::ArmedOffboard => {
                if self.peer.armed && self.peer.offboard {
                    self.release(ReleaseCause::ArmedOffboard);
                }
            }
        }
    }

    /// Cuts the vehicle loose now.
    pub fn release(&mut self, cause: ReleaseCause) {
        if self.sim.phase() == Phase::Hanging {
            self.sim.release();
            self.tell_release(cause);
            self.tell_phase();
        }
    }

    fn tell_release(&mut self, cause: ReleaseCause) {
        if let (Phase::Hanging, Some(t_s)) = (self.phase_told, self.sim.release_time_s()) {
            let at = microseconds(t_s);
            self.phase_told = Phase::Falling;
            self.parachute.note_release(self.now, at, cause.text());
            self.tell(SimulatorEvent::Released { at, cause });
            if !self.peer.armed {
                self.parachute.say(MavSeverity::MAV_SEVERITY_WARNING, SimulatorEvent::NOT_ARMED);
                self.tell(SimulatorEvent::ReleasedUnarmed { at });
            }
        }
    }

    /// Tells that the rotors are free, when they have become so.
    pub(super) fn tell_phase(&mut self) {
        if let (Phase::Falling, Phase::Powered) = (self.phase_told, self.sim.phase()) {
            self.phase_told = Phase::Powered;
            let at = self.sim.powered_from_s().map_or(self.now, microseconds);
            self.tell(SimulatorEvent::RotorsFree { at });
        }
    }

    /// Tells that the vehicle has come to the ground, sinking at `v_down_m_s` the step before.
    pub(super) fn tell_touch(&mut self, v_down_m_s: f64) {
        let touching = self.sim.on_ground();
        if touching && !self.touching {
            self.tell(SimulatorEvent::TouchedGround { at: self.now, speed_m_s: v_down_m_s.max(0.0) });
        }
        self.touching = touching;
    }

    /// The autopilot has been armed: if the release waits for its mode and it does not tell any, nothing will come of that.
    pub(super) fn check_mode_is_told(&mut self) {
        let waits =
            self.config.trigger == ReleaseTrigger::ArmedOffboard && self.sim.phase() == Phase::Hanging;
        if waits && !self.peer.mode_told {
            let event = SimulatorEvent::ModeUntold { at: self.now };
            self.parachute.say(MavSeverity::MAV_SEVERITY_WARNING, SimulatorEvent::MODE_UNTOLD);
            self.tell(event);
        }
    }
}
