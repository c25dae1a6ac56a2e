//! Whom the streamer believes, and whether the drop was streamed as it was meant to be.
//!
//! **The vehicle that was met first.** Everybody may send to the streamer's port in the vehicle's name: a
//! second simulator of the same system, or a stranger. While it waits for a vehicle, the autopilot is the
//! peer whose HEARTBEAT came last, the parachute the peer that spoke last for it; once clock and HEARTBEAT of
//! one peer have been heard both stay who they are. The parachute's answers may also come through the
//! autopilot, which is a router to it. What the streamer sends goes to them and to its instance's own ports:
//! another vehicle that speaks to it is commanded nothing.
//!
//! **The clock does not jump by one frame's word.** A jump of more than a second counts once a second frame
//! goes on from it: after an outage, or with a vehicle that has been started anew.
//!
//! **A drop that was streamed to its end is a success only if** the vehicle was released on our command, or,
//! where something else releases it, was reported released or found falling; and was armed in OFFBOARD by
//! every HEARTBEAT from the release to the first one after the plan's end, which were no more than 3 s apart;
//! was found armed before the release, whenever that became known; and the parachute has not said otherwise.

use crate::link::parachute::PARACHUTE_COMPONENT;
use crate::link::peer::{PeerId, Recipient};
use crate::params::file::AUTOPILOT_COMPONENT;
use crate::time::TimeUs;

/// A greater jump of the clock than this [us] is none that messages make that overtake each other, or that
/// are lost now and then.
pub(super) const CLOCK_JUMP_US: TimeUs = 1_000_000;

/// The vehicle that was met.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Met {
    autopilot: Option<PeerId>,
    parachute: Option<PeerId>,
    /// A time that one frame has claimed.
    claimed: Option<TimeUs>,
}

impl Met {
    /// Whether a frame of the vehicle's `component` that came by `peer` is believed; `waits`: no vehicle has
    /// been met so far.
    pub(super) fn believes(&mut self, waits: bool, component: u8, peer: PeerId, is_heartbeat: bool) -> bool {
        match component {
            AUTOPILOT_COMPONENT => {
                if waits && is_heartbeat {
                    self.autopilot = Some(peer);
                }
                self.autopilot == Some(peer)
            }
            PARACHUTE_COMPONENT => {
                let by_router = self.autopilot == Some(peer);
                if self.parachute.is_none() || waits && !by_router {
                    self.parachute = Some(peer);
                }
                by_router || self.parachute == Some(peer)
            }
            _ => self.autopilot == Some(peer),
        }
    }

    /// Whom the streamer speaks to: everybody, until an autopilot has been met.
    pub(super) fn spoken_to(&self) -> Recipient {
        match (self.autopilot, self.parachute) {
            (Some(autopilot), parachute) => Recipient::KeptAnd([autopilot, parachute.unwrap_or(autopilot)]),
            (None, _) => Recipient::All,
        }
    }

    /// Whether a vehicle's clock that was at `before` is believed to be at `now`.
    pub(super) fn believes_clock(&mut self, before: TimeUs, now: TimeUs) -> bool {
        let goes_on = |from: TimeUs| from < now && now <= from + CLOCK_JUMP_US;
        let is_jump = now.abs_diff(before) > CLOCK_JUMP_US;
        let believed = !is_jump || self.claimed.is_some_and(goes_on);
        self.claimed = (!believed).then_some(now);
        believed
    }
}

/// A vehicle that has not been heard for longer [us] may have done anything: two HEARTBEATs may be lost.
const UNSEEN_US: TimeUs = 3_000_000;

/// What has to be known of a drop for it to be a success.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Conduct {
    /// The parachute has acknowledged our command, or has reported the release after it.
    pub(super) obeyed: bool,
    /// The parachute has reported the release, or the fall was found.
    pub(super) told: bool,
    /// When a HEARTBEAT has shown the vehicle last, from the release on.
    seen_at: Option<TimeUs>,
    /// It was unseen for too long.
    unseen: bool,
    /// It was seen other than armed in OFFBOARD, or the parachute has said so of the release.
    pub(super) strayed: bool,
    /// The first HEARTBEAT after the plan's end has come.
    is_judged: bool,
}

impl Conduct {
    /// Takes what a HEARTBEAT shows at `now`, after the release, and whether that is after the plan's end.
    pub(super) fn take(&mut self, now: TimeUs, flies_offboard: bool, plan_is_over: bool) {
        if !self.is_judged {
            self.unseen |= self.seen_at.is_some_and(|at| now > at.saturating_add(UNSEEN_US));
            self.seen_at = Some(now);
            self.strayed |= !flies_offboard;
            self.is_judged = plan_is_over;
        }
    }

    /// The release has become known at `now`; `armed`: the vehicle was armed then by what had been heard.
    pub(super) fn note_release(&mut self, now: TimeUs, armed: bool) {
        self.strayed |= !armed;
        self.seen_at = Some(now);
    }

    /// What keeps a drop whose plan was streamed to its end, at `plan_end`, from being a success.
    pub(super) fn shortcoming(&self, commands_release: bool, plan_end: TimeUs) -> Option<&'static str> {
        let released = if commands_release { self.obeyed } else { self.told };
        let unseen = self.unseen || self.seen_at.is_none_or(|at| at.saturating_add(UNSEEN_US) < plan_end);
        match (released, self.strayed, unseen) {
            (false, ..) if commands_release => Some("no release on command was acknowledged"),
            (false, ..) => Some("no release was heard of"),
            (_, true, _) => Some("the vehicle was not armed in OFFBOARD from the release to the plan's end"),
            (.., true) => {
                Some("no HEARTBEAT showed the vehicle for 3 s between the release and the plan's end")
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: TimeUs = 1_000_000;

    /// Two frames that follow each other move the clock; one does not, nor do two that say the same.
    #[test]
    fn a_jump_of_the_clock_takes_two_frames() {
        let mut met = Met::default();
        assert!(met.believes_clock(5 * S, 5 * S + 4_000) && met.believes_clock(5 * S, 4 * S));
        for far in [0, 4_000_000 * S] {
            assert!(!met.believes_clock(5 * S, far) && !met.believes_clock(5 * S, far));
            assert!(met.believes_clock(5 * S, 5 * S + 4_000), "forgotten");
            assert!(!met.believes_clock(5 * S, far) && met.believes_clock(5 * S, far + 20_000));
        }
    }

    #[test]
    fn the_first_vehicle_is_kept_once_it_was_met() {
        let (ours, chute, other) = (PeerId(1), PeerId(2), PeerId(3));
        let mut met = Met::default();
        assert!(!met.believes(true, 1, other, false), "a clock without a HEARTBEAT");
        assert!(met.believes(true, 1, other, true) && met.believes(true, 1, ours, true));
        assert!(met.believes(true, 1, ours, false) && !met.believes(true, 1, other, false));
        assert!(met.believes(true, 161, chute, true));
        assert!(met.believes(false, 1, ours, true) && !met.believes(false, 1, other, true));
        assert!(met.believes(false, 161, chute, false) && met.believes(false, 161, ours, false));
        assert!(!met.believes(false, 161, other, false));
        assert_eq!(met.spoken_to(), Recipient::KeptAnd([ours, chute]));
    }

    #[test]
    fn a_success_is_released_as_asked_and_seen_in_offboard_to_the_plans_end() {
        let good = |conduct: &mut Conduct| {
            conduct.obeyed = true;
            conduct.note_release(5 * S, true);
            conduct.take(6 * S, true, false);
            conduct.take(8 * S, true, false);
        };
        let mut conduct = Conduct::default();
        good(&mut conduct);
        assert_eq!(conduct.shortcoming(true, 9 * S), None);
        assert_eq!(conduct.shortcoming(false, 9 * S), Some("no release was heard of"));
        assert!(conduct.shortcoming(true, 12 * S).is_some(), "unseen at the end");
        conduct.take(10 * S, true, true);
        conduct.take(11 * S, false, true);
        assert_eq!(conduct.shortcoming(true, 9 * S), None, "what comes after the first is another flight");
        for spoil in [
            |c: &mut Conduct| c.obeyed = false,
            |c: &mut Conduct| c.note_release(5 * S, false),
            |c: &mut Conduct| c.take(9 * S, false, false),
            |c: &mut Conduct| c.take(12 * S, true, false),
        ] {
            let mut conduct = Conduct::default();
            good(&mut conduct);
            spoil(&mut conduct);
            assert!(conduct.shortcoming(true, 9 * S).is_some());
        }
    }
}
