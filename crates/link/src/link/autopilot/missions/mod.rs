//! Missions, fences and rally points: uploaded, kept, given back, cleared. Missions are flown
//! ([`crate::autopilot::mission_flight`]), fences are watched ([`crate::autopilot::fence`]).
//!
//! As PX4 v1.14 does it: the vehicle asks for item after item, with MISSION_REQUEST first, with the other
//! message after an answer of UNSUPPORTED or with the other kind of item, and asks again after 250 ms; a
//! peer that has been silent for 5 s has given up; a second peer that wants to upload meanwhile gets an
//! error; a plan takes the place of the old one only once it is whole. Better than PX4: a peer that answers
//! neither way is asked in the other after two tries; several peers may download at once, each what stood
//! there when it began; a peer that starts its upload again is not refused for being busy with itself; an
//! upload whose next item has not come for a second, or that has lasted for ten, gives way to another peer.
//! Times are the vehicle's.

mod reports;
#[cfg(test)]
mod tests;
mod wire;

use std::collections::VecDeque;
use std::sync::Arc;

use mavlink::dialects::common::{MavMissionResult as MissionResult, MavMissionType};

use crate::autopilot::fence::Fence;
use crate::autopilot::missions::{Item, Kind, Plan, areas_of};
use crate::autopilot::{Event, Severity};
use crate::model::Environment;
use crate::time::TimeUs;
pub(super) use reports::Reports;
pub(super) use wire::{Answer, Request};

use super::outbox::Peer;

/// An item that has not come is asked for again after this [us].
const RETRY_US: TimeUs = 250_000;
/// So often an item is asked for in one way before the other is tried.
const TRIES: u32 = 2;
/// A peer that has said nothing for this long has given up [us].
const TIMEOUT_US: TimeUs = 5_000_000;
/// An upload without the item that is due for so long, or that has lasted so long, gives way to another peer
/// [us].
const STANDSTILL_US: TimeUs = 1_000_000;
const LONGEST_US: TimeUs = 10_000_000;
/// Most peers that download at once; the one that was silent longest makes room.
const MOST_DOWNLOADS: usize = 8;
const ALL: u8 = MavMissionType::MAV_MISSION_TYPE_ALL as u8;

/// A plan on its way in.
#[derive(Clone, Debug)]
struct Upload {
    peer: Peer,
    kind: Kind,
    count: usize,
    items: Vec<Item>,
    /// Whether it is asked for with MISSION_REQUEST_INT.
    int: bool,
    /// How often the item that is due was asked for.
    asked: u32,
    asked_us: TimeUs,
    heard_us: TimeUs,
    /// When its peer began to upload, though it may have begun anew since; when an item came last.
    since_us: TimeUs,
    advanced_us: TimeUs,
}

/// A plan on its way out, as it was when that began.
#[derive(Clone, Debug)]
struct Download {
    peer: Peer,
    kind: Kind,
    plan: Plan,
    heard_us: TimeUs,
}

/// The plans, and those that are on their way.
#[derive(Clone, Debug, Default)]
pub(super) struct Missions {
    plans: [Plan; 3],
    /// The current item of the mission.
    current: u16,
    /// The mission is new; the item that it says to begin with, if any.
    new_mission: Option<Option<u16>>,
    /// The item that a peer wants to be the current one.
    wanted: Option<u16>,
    fence_is_new: bool,
    upload: Option<Upload>,
    downloads: Vec<Download>,
    /// The upload that was completed last, whose acknowledgement may be lost.
    completed: Option<(Peer, Kind)>,
    answers: VecDeque<Answer>,
    said: VecDeque<Event>,
}

impl Missions {
    /// The plan of a kind.
    pub(super) fn plan(&self, kind: Kind) -> &Plan {
        &self.plans[kind as usize]
    }

    /// The mission's items and the item that it says to begin with, if it was uploaded or cleared since the
    /// last call.
    pub(super) fn take_new_mission(&mut self) -> Option<(Arc<Vec<Item>>, Option<u16>)> {
        let start = self.new_mission.take()?;
        Some((self.plan(Kind::Mission).items.clone(), start))
    }

    /// The item that a peer wants to be the mission's current one, if one was asked for since the last call.
    pub(super) fn take_wanted_item(&mut self) -> Option<u16> {
        self.wanted.take()
    }

    /// Notes the current item of the mission that is flown.
    pub(super) fn note_current(&mut self, seq: u16) {
        self.current = seq;
    }

    /// The areas of the fence in the local frame, if it was uploaded or cleared since the last call.
    pub(super) fn take_new_fence(&mut self, environment: &Environment) -> Option<Fence> {
        let is_new = std::mem::take(&mut self.fence_is_new);
        is_new.then(|| self.plan(Kind::Fence).fence(environment))
    }

    /// The next message to send.
    pub(super) fn poll_answer(&mut self) -> Option<Answer> {
        self.answers.pop_front()
    }

    /// The next thing to say.
    pub(super) fn poll_event(&mut self) -> Option<Event> {
        self.said.pop_front()
    }

    /// Nobody is waited for any more: the vehicle's time has started over.
    pub(super) fn restart(&mut self) {
        (self.upload, self.completed) = (None, None);
        self.downloads.clear();
    }

    /// Another mission item is to be the current one; false when there is no such item.
    pub(super) fn set_current(&mut self, seq: u16) -> bool {
        let known = seq < self.plan(Kind::Mission).count();
        if known {
            self.wanted = Some(seq);
        } else {
            self.say(Severity::Error, format!("there is no mission item {seq}"));
        }
        known
    }

    /// Takes a request of a peer.
    pub(super) fn handle(&mut self, now: TimeUs, peer: Peer, request: Request) {
        match request {
            Request::List { kind } => self.list(now, peer, kind),
            Request::Item { kind, seq, int } => self.give(now, peer, kind, seq, int),
            Request::Count { kind, count } => self.begin(now, peer, kind, usize::from(count)),
            Request::Upload { kind, seq, int, item } => self.take(now, peer, kind, seq, int, item),
            Request::Ack { kind, result } => self.acknowledged(now, peer, kind, result),
            Request::Clear { kind } => self.clear(now, peer, kind),
            Request::SetCurrent { seq } => {
                self.set_current(seq);
            }
            Request::Partial { kind } => self.ack(peer, kind, MissionResult::MAV_MISSION_UNSUPPORTED, 0),
        }
    }

    /// Asks again for what has not come, and gives up on who has gone.
    pub(super) fn handle_time(&mut self, now: TimeUs) {
        self.downloads.retain(|d| now.saturating_sub(d.heard_us) <= TIMEOUT_US);
        let Some(upload) = &mut self.upload else { return };
        if now.saturating_sub(upload.heard_us) > TIMEOUT_US {
            let text = format!("{} upload timed out, the old one stays", upload.kind.name());
            self.upload = None;
            self.say(Severity::Critical, text);
        } else if now.saturating_sub(upload.asked_us) > RETRY_US {
            upload.int ^= upload.asked.is_multiple_of(TRIES);
            self.ask(now);
        }
    }

    fn list(&mut self, now: TimeUs, peer: Peer, number: u8) {
        let Some(kind) = Kind::from_number(number) else {
            return self.ack(peer, number, MissionResult::MAV_MISSION_UNSUPPORTED, 0);
        };
        let plan = self.plan(kind).clone();
        self.answers.push_back(Answer::count(peer, number, plan.count(), plan.opaque_id));
        self.downloads.retain(|d| d.peer != peer);
        if self.downloads.len() == MOST_DOWNLOADS {
            self.downloads.remove(0);
        }
        self.downloads.push(Download { peer, kind, plan, heard_us: now });
    }

    fn give(&mut self, now: TimeUs, peer: Peer, number: u8, seq: u16, int: bool) {
        let Some(kind) = Kind::from_number(number) else {
            return self.ack(peer, number, MissionResult::MAV_MISSION_UNSUPPORTED, 0);
        };
        let own = self.downloads.iter_mut().find(|d| d.peer == peer && d.kind == kind);
        let plan = match own {
            Some(download) => {
                download.heard_us = now;
                &download.plan
            }
            None => self.plan(kind),
        };
        match plan.items.get(usize::from(seq)) {
            Some(item) => {
                let current = kind == Kind::Mission && seq == self.current;
                self.answers.push_back(Answer::item(peer, number, seq, int, item, current));
            }
            None => self.ack(peer, number, MissionResult::MAV_MISSION_INVALID_SEQUENCE, 0),
        }
    }

    fn begin(&mut self, now: TimeUs, peer: Peer, number: u8, count: usize) {
        let Some(kind) = Kind::from_number(number) else {
            return self.ack(peer, number, MissionResult::MAV_MISSION_UNSUPPORTED, 0);
        };
        if self.is_busy_with_another_than(peer, now) {
            self.say(Severity::Error, "upload refused: another one is under way");
            return self.ack(peer, number, MissionResult::MAV_MISSION_ERROR, 0);
        }
        let before = self.upload.take().filter(|upload| upload.peer == peer);
        self.completed = None;
        if count > kind.capacity() {
            let (name, most) = (kind.name(), kind.capacity());
            self.say(Severity::Error, format!("{name} refused: at most {most} items"));
            return self.ack(peer, number, MissionResult::MAV_MISSION_NO_SPACE, 0);
        }
        if count == 0 {
            self.replace(kind, Vec::new());
            return self.ack(peer, number, MissionResult::MAV_MISSION_ACCEPTED, 0);
        }
        let items = Vec::with_capacity(count);
        // Who begins again and again does not get more time by it.
        let since_us = before.as_ref().map_or(now, |upload| upload.since_us);
        let advanced_us = before.map_or(now, |upload| upload.advanced_us);
        let (int, asked, asked_us, heard_us) = (false, 0, now, now);
        self.upload =
            Some(Upload { peer, kind, count, items, int, asked, asked_us, heard_us, since_us, advanced_us });
        self.ask(now);
    }

    fn is_busy_with_another_than(&self, peer: Peer, now: TimeUs) -> bool {
        self.upload.as_ref().is_some_and(|upload| {
            let advances = now.saturating_sub(upload.advanced_us) <= STANDSTILL_US;
            upload.peer != peer && advances && now.saturating_sub(upload.since_us) <= LONGEST_US
        })
    }

    /// Asks for the item that is due.
    fn ask(&mut self, now: TimeUs) {
        let Some(upload) = &mut self.upload else { return };
        (upload.asked, upload.asked_us) = (upload.asked + 1, now);
        let seq = upload.items.len() as u16;
        self.answers.push_back(Answer::request(upload.peer, upload.kind as u8, seq, upload.int));
    }

    fn take(&mut self, now: TimeUs, peer: Peer, number: u8, seq: u16, int: bool, item: Item) {
        let Some(upload) = self.upload.as_mut().filter(|upload| upload.peer == peer) else {
            return self.take_late(peer, number, seq);
        };
        upload.heard_us = now;
        if upload.kind as u8 != number {
            return self.ack(peer, number, MissionResult::MAV_MISSION_ERROR, 0);
        }
        if usize::from(seq) != upload.items.len() {
            // The right one is asked for again in time.
            return;
        }
        (upload.int, upload.asked, upload.advanced_us) = (int, 0, now);
        if let Err(result) = item.check(upload.kind) {
            let text = format!("{} refused: item {seq} (command {})", upload.kind.name(), item.command);
            self.upload = None;
            self.say(Severity::Error, text);
            return self.ack(peer, number, result.into(), 0);
        }
        upload.items.push(item);
        if upload.items.len() < upload.count {
            return self.ask(now);
        }
        let (kind, items) = (upload.kind, std::mem::take(&mut upload.items));
        if let (Kind::Fence, Err(seq)) = (kind, areas_of(&items)) {
            self.upload = None;
            self.say(
                Severity::Error,
                format!("fence refused: the polygon of item {seq} has too few corners"),
            );
            return self.ack(peer, number, MissionResult::MAV_MISSION_INVALID_PARAM1, 0);
        }
        (self.upload, self.completed) = (None, Some((peer, kind)));
        self.replace(kind, items);
        self.ack(peer, number, MissionResult::MAV_MISSION_ACCEPTED, self.plan(kind).opaque_id);
    }

    /// An item that nobody waits for: the last one of a completed upload, whose acknowledgement was lost, is
    /// acknowledged again.
    fn take_late(&mut self, peer: Peer, number: u8, seq: u16) {
        let again = self.completed.filter(|&(by, kind)| {
            by == peer && kind as u8 == number && self.plan(kind).count() == seq.wrapping_add(1)
        });
        match again {
            Some((_, kind)) => {
                self.ack(peer, number, MissionResult::MAV_MISSION_ACCEPTED, self.plan(kind).opaque_id);
            }
            None => self.ack(peer, number, MissionResult::MAV_MISSION_ERROR, 0),
        }
    }

    fn acknowledged(&mut self, now: TimeUs, peer: Peer, number: u8, result: u8) {
        self.downloads.retain(|d| !(d.peer == peer && d.kind as u8 == number));
        let Some(upload) = self.upload.as_mut().filter(|u| u.peer == peer && u.kind as u8 == number) else {
            return;
        };
        if result == MissionResult::MAV_MISSION_OPERATION_CANCELLED as u8 {
            self.upload = None;
        } else if result == MissionResult::MAV_MISSION_UNSUPPORTED as u8 {
            (upload.int, upload.asked, upload.heard_us) = (!upload.int, 0, now);
            self.ask(now);
        }
    }

    fn clear(&mut self, now: TimeUs, peer: Peer, number: u8) {
        let kinds = match Kind::from_number(number) {
            Some(kind) => vec![kind],
            None if number == ALL => Kind::ALL.to_vec(),
            None => return self.ack(peer, number, MissionResult::MAV_MISSION_UNSUPPORTED, 0),
        };
        if self.is_busy_with_another_than(peer, now) {
            self.say(Severity::Error, "clearing refused: an upload is under way");
            return self.ack(peer, number, MissionResult::MAV_MISSION_ERROR, 0);
        }
        (self.upload, self.completed) = (None, None);
        for kind in kinds {
            self.replace(kind, Vec::new());
        }
        self.ack(peer, number, MissionResult::MAV_MISSION_ACCEPTED, 0);
    }

    fn replace(&mut self, kind: Kind, items: Vec<Item>) {
        if kind == Kind::Mission {
            let start = items.iter().rposition(|item| item.current == 1);
            (self.new_mission, self.wanted) = (Some(start.map(|start| start as u16)), None);
        }
        let plan = Plan::new(items);
        self.fence_is_new |= kind == Kind::Fence;
        for remark in plan.remarks(kind) {
            self.say(Severity::Warning, remark);
        }
        self.plans[kind as usize] = plan;
    }

    fn ack(&mut self, peer: Peer, kind: u8, result: MissionResult, opaque_id: u32) {
        self.answers.push_back(Answer::ack(peer, kind, result, opaque_id));
    }

    fn say(&mut self, severity: Severity, text: impl Into<std::borrow::Cow<'static, str>>) {
        self.said.push_back(Event::new(severity, text));
    }
}
