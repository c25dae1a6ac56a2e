//! A mission as it is flown (AUTO.MISSION), item after item, as PX4 v1.14's navigator does it (mission.cpp,
//! mission_block.cpp).
//!
//! | file | holds |
//! |---|---|
//! | here | which item is the current one, when it is done, where the vehicle goes |
//! | [`task`] | what an item asks for |
//! | [`feasibility`] | whether a mission can be flown |
//!
//! The mission is kept while another mode flies, and goes on with the item at which it was: that one begins
//! anew. Disarming puts it back to its first item. Places are flown to in a straight line as by
//! [`super::navigator`], at MPC_XY_CRUISE or DO_CHANGE_SPEED's speed; the nose turns to where it goes
//! (MPC_YAW_MODE 0) unless the item says a heading. What stands climbs straight up before it goes to its
//! first place, to the height of that place and at least by MIS_TAKEOFF_ALT.
//!
//! A place is reached within the item's radius, or NAV_ACC_RAD, and 0.8 m of its height, with the nose within
//! MIS_YAW_ERR of the heading that the item says; then the time of the item begins. Commands are done at
//! once, but for a release, which waits for its acknowledgement, MIS_PD_TO at the most. Until the first place
//! the motors of a vehicle that has not flown yet stand still, so that a mission can begin under a canopy
//! with the release. (PX4 also cuts the corners of places without a time to stay.)

pub mod feasibility;
pub mod task;

use std::sync::Arc;

use nalgebra::{Vector2, Vector3};

use self::feasibility::Surroundings;
use self::task::{Step, Task};
use super::YawSetpoint;
use super::event::{EventQueue, Severity};
use super::missions::Item;
use super::navigator::{Guidance, HEIGHT_REACHED_M, Situation, Stop, descent};
use crate::control::VelocityLimits;
use crate::frames::wrap_pi;
use crate::math;
use crate::units::{RAD_PER_DEG, US_PER_S};

/// Jumps that are followed for the next item to fly; beyond them they lead in a circle.
const MOST_JUMPS: usize = 10;

/// How far a mission is, by `MISSION_STATE`'s numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Progress {
    /// Not begun since the vehicle was armed, or since it came.
    #[default]
    NotStarted,
    /// Begun and not at its end.
    Begun,
    /// All items are done.
    Complete,
}

/// What contact the vehicle has with what carries it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Contact {
    /// It stands on something, or hangs still.
    pub landed: bool,
    /// Whether motors have carried the vehicle since it was armed.
    pub flown: bool,
}

/// What a step asks of the autopilot beyond flying.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Turn {
    /// The mission is at its end in the air: HOLD at this place, NED [m], or where the vehicle is.
    Hold(Option<Vector3<f64>>),
    /// RETURN.
    Return,
}

/// A part of an item.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// Straight up, before the way to the place.
    Climb,
    /// On the way to the place over which it lands.
    Approach,
    /// The item itself.
    Item,
}

/// Where to fly, as the last item with a place has left it.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Target {
    /// Nowhere: the motors stand still.
    Nowhere,
    /// To a stop, and there.
    Stop(Stop),
    /// To a position, NED [m], with a heading [rad] or with the nose ahead.
    Place { p_ned: Vector3<f64>, yaw_rad: Option<f64> },
    /// Straight up to a position, NED [m].
    Up { p_ned: Vector3<f64> },
    /// Down over a place.
    Down { ne: Vector2<f64> },
}

/// See the head of this file.
#[derive(Clone, Debug)]
pub struct MissionFlight {
    steps: Arc<Vec<Step>>,
    /// Whether it can be flown; `None`: not checked yet.
    feasible: Option<bool>,
    /// Number of the current item; behind the last at the end.
    current: usize,
    /// How often each jump was made.
    jumped: Vec<u16>,
    reached: Option<u16>,
    progress: Progress,
    /// It has flown since the vehicle was armed.
    flown: bool,
    /// The current item is still to be begun.
    fresh: bool,
    /// The current item is done and does not go on by itself.
    stays: bool,
    stage: Stage,
    target: Target,
    /// What stands, or comes from a mode that keeps no place, climbs before it goes to a place.
    climbs: bool,
    /// DO_CHANGE_SPEED's [m/s].
    speed_m_s: Option<f64>,
    /// When the current item's place was reached, or the item begun that has none [us].
    since_us: Option<u64>,
    turned: bool,
    /// A command for others to obey.
    issued: Option<Item>,
    release_acknowledged: bool,
}

impl Default for MissionFlight {
    fn default() -> Self {
        Self {
            steps: Arc::default(),
            feasible: None,
            current: 0,
            jumped: Vec::new(),
            reached: None,
            progress: Progress::NotStarted,
            flown: false,
            fresh: true,
            stays: false,
            stage: Stage::Item,
            target: Target::Nowhere,
            climbs: true,
            speed_m_s: None,
            since_us: None,
            turned: false,
            issued: None,
            release_acknowledged: false,
        }
    }
}

impl MissionFlight {
    /// Number of items.
    pub fn len(&self) -> usize {
        self.steps.len()
    }

    /// Whether there is no item.
    pub fn is_empty(&self) -> bool {
        self.steps.is_empty()
    }

    /// The items and what they ask for.
    pub fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// Number of the current item; at the end that of the last.
    pub fn current(&self) -> u16 {
        // No mission has more items than an u16 counts.
        self.current.min(self.len().saturating_sub(1)) as u16
    }

    /// Number of the item that was reached last since the mission came.
    pub fn reached(&self) -> Option<u16> {
        self.reached
    }

    /// How far it is.
    pub fn progress(&self) -> Progress {
        self.progress
    }

    /// Whether it can be flown.
    pub fn is_feasible(&self) -> bool {
        self.feasible == Some(true)
    }

    /// Whether it is still to be checked.
    pub fn awaits_check(&self) -> bool {
        self.feasible.is_none() && !self.is_empty()
    }

    /// Checks a mission that has not been checked, and says what is wrong with it.
    pub(super) fn check(&mut self, around: &Surroundings<'_>, events: &mut EventQueue) {
        if !self.awaits_check() {
            return;
        }
        let checked = feasibility::check(&self.steps, around);
        self.feasible = Some(checked.is_ok());
        match checked {
            Ok(below_home) => {
                for number in below_home {
                    events.say(Severity::Warning, format!("Warning: Waypoint {number} below home"));
                }
            }
            Err(reason) => events.say(Severity::Critical, reason.to_string()),
        }
    }

    /// Whether it takes the vehicle to the ground at present.
    pub fn is_landing(&self) -> bool {
        matches!(self.target, Target::Down { .. })
    }

    /// Whether it takes the vehicle straight up at present.
    pub fn is_climbing(&self) -> bool {
        matches!(self.target, Target::Up { .. })
    }

    /// Puts other items in the place of those that were there. As in PX4 the number of the current item stays
    /// where there is such an item, unless `start` says another; it begins anew.
    pub(super) fn load(&mut self, steps: Vec<Step>, start: Option<u16>) {
        let current = start.map_or(self.current, usize::from);
        let current = if current < steps.len() { current } else { 0 };
        self.jumped = vec![0; steps.len()];
        (self.steps, self.feasible) = (Arc::new(steps), None);
        (self.reached, self.progress) = (None, Progress::NotStarted);
        self.go_to(current);
    }

    /// Makes another item the current one; false when there is no such item.
    pub fn set_current(&mut self, seq: u16) -> bool {
        let known = usize::from(seq) < self.len();
        if known {
            if self.progress == Progress::Complete {
                self.progress = Progress::NotStarted;
            }
            self.reached = None;
            self.go_to(usize::from(seq));
        }
        known
    }

    /// Begins, or goes on with the current item. `from_hold`: the vehicle comes from HOLD, which has kept a
    /// place; from any other mode it climbs before it goes to a place above it.
    pub(super) fn begin(&mut self, from_hold: bool) {
        self.climbs |= !from_hold;
        (self.target, self.speed_m_s) = (Target::Nowhere, None);
        self.go_to(self.current);
    }

    /// Time has started over: back to the first item, and to be checked anew.
    pub(super) fn restart(&mut self) {
        self.flown = true;
        self.disarmed();
        (self.feasible, self.reached, self.progress) = (None, None, Progress::NotStarted);
    }

    /// The vehicle was disarmed: back to the first item, if it has flown.
    pub(super) fn disarmed(&mut self) {
        if !std::mem::take(&mut self.flown) {
            return;
        }
        if self.progress == Progress::Begun {
            self.progress = Progress::NotStarted;
        }
        self.jumped.fill(0);
        (self.target, self.speed_m_s, self.climbs) = (Target::Nowhere, None, true);
        self.go_to(0);
    }

    /// Changes the horizontal speed until the mission begins again [m/s]; `None` is the settings'.
    pub(super) fn set_speed(&mut self, speed_m_s: Option<f64>) {
        self.speed_m_s = speed_m_s;
    }

    /// A command of the current item, for whoever is to obey it.
    pub fn take_command(&mut self) -> Option<Item> {
        self.issued.take()
    }

    /// The release that the current item has asked for was acknowledged.
    pub fn acknowledge_release(&mut self) {
        self.release_acknowledged = true;
    }

    fn go_to(&mut self, item: usize) {
        (self.current, self.fresh, self.stays, self.stage) = (item, true, false, Stage::Item);
    }

    /// The next step: where to fly, `None` with the motors off; and whether another mode is to fly instead.
    /// On the ground in a landing there is nothing to carry any more.
    pub(super) fn step(
        &mut self,
        s: &Situation<'_>,
        contact: Contact,
        events: &mut EventQueue,
    ) -> (Option<Guidance>, Option<Turn>) {
        self.flown = true;
        let mut turn = None;
        if std::mem::take(&mut self.fresh) {
            turn = self.begin_item(s, contact, events);
        } else if !self.stays && self.is_done(s, contact) {
            turn = self.go_on(s, contact, events);
        }
        let stands = contact.landed && self.is_landing();
        (self.guidance(s).filter(|_| !stands), turn)
    }

    /// The current item, or the stage of it, is done.
    fn go_on(&mut self, s: &Situation<'_>, contact: Contact, events: &mut EventQueue) -> Option<Turn> {
        if self.stage != Stage::Item {
            return self.begin_stage(s, contact, self.stage);
        }
        self.reached = Some(self.current());
        if self.steps.get(self.current).is_some_and(|step| step.item.autocontinue == 0) {
            self.stays = true;
            return None;
        }
        self.current += 1;
        self.begin_item(s, contact, events)
    }

    /// Begins the current item, or the one that jumps lead to.
    fn begin_item(&mut self, s: &Situation<'_>, contact: Contact, events: &mut EventQueue) -> Option<Turn> {
        self.follow_jumps(events);
        let Some(step) = self.steps.get(self.current).copied() else { return self.end(contact, events) };
        if std::mem::replace(&mut self.progress, Progress::Begun) != Progress::Begun {
            events.say(Severity::Info, "Executing Mission");
        }
        match step.task {
            Task::Return => {
                self.begin_stage(s, contact, Stage::Item);
                return Some(Turn::Return);
            }
            Task::Speed(speed_m_s) => self.speed_m_s = speed_m_s,
            Task::Gripper | Task::SetHome => {
                self.issued = Some(step.item);
                self.release_acknowledged = false;
            }
            _ => {}
        }
        if let Some(to) = self.climb_before(&step.task, s, contact) {
            let height_m = s.home_ned.z - to.z;
            events.say(Severity::Info, format!("Takeoff to {height_m:.1} meters above home"));
            (self.stage, self.target, self.since_us) = (Stage::Climb, Target::Up { p_ned: to }, None);
            return None;
        }
        self.begin_stage(s, contact, Stage::Climb)
    }

    /// Goes on behind a stage of the current item.
    fn begin_stage(&mut self, s: &Situation<'_>, contact: Contact, done: Stage) -> Option<Turn> {
        let step = *self.steps.get(self.current)?;
        (self.stage, self.since_us, self.turned) = (Stage::Item, None, false);
        let home_down_m = s.home_ned.z;
        let place = |p_ned, yaw_rad| Target::Place { p_ned, yaw_rad };
        self.target = match step.task {
            Task::Land { ne } => {
                let near = (ne - s.p_ned.xy()).norm() <= s.settings.mission.reached_within_m;
                if done == Stage::Climb && !near {
                    // At the height at which it is: a landing's own height does not count.
                    let down_m = self.target.down_m().unwrap_or(s.p_ned.z);
                    self.stage = Stage::Approach;
                    place(Vector3::new(ne.x, ne.y, down_m), None)
                } else {
                    self.climbs = true;
                    Target::Down { ne }
                }
            }
            Task::TakeOff { to } => place(to.ned(home_down_m), None),
            Task::Waypoint { at, yaw_rad, .. } | Task::Loiter { at, yaw_rad, .. } => {
                place(at.ned(home_down_m), yaw_rad)
            }
            Task::LoiterToHeight { at, .. } => place(Vector3::new(at.ne.x, at.ne.y, s.p_ned.z), None),
            _ if self.target == Target::Nowhere && contact.flown && !contact.landed => {
                Target::Stop(Stop::BRAKING)
            }
            _ => self.target,
        };
        if step.task.ne().is_none() {
            self.since_us = Some(s.now_us);
        }
        None
    }

    /// Goes to where DO_JUMPs at the current item lead.
    fn follow_jumps(&mut self, events: &mut EventQueue) {
        for _ in 0..MOST_JUMPS {
            let Some(Step { task: Task::Jump { to, times }, .. }) = self.steps.get(self.current).copied()
            else {
                if self.current > self.len() {
                    let text = format!(
                        "Mission item index out of bound, index: {}, max: {}.",
                        self.current,
                        self.len()
                    );
                    events.say(Severity::Critical, text);
                }
                return;
            };
            let made = self.jumped.get_mut(self.current);
            match made.filter(|made| **made < times) {
                Some(made) => {
                    *made += 1;
                    self.current = to;
                }
                None => {
                    events.say(Severity::Info, "DO JUMP repetitions completed.");
                    self.current += 1;
                }
            }
        }
        events.say(Severity::Critical, "DO JUMP is cycling, giving up.");
        self.current = self.len();
    }

    /// There is no further item.
    fn end(&mut self, contact: Contact, events: &mut EventQueue) -> Option<Turn> {
        self.current = self.len();
        let was_begun = std::mem::replace(&mut self.progress, Progress::Complete) == Progress::Begun;
        let (text, severity) = match (was_begun, contact.landed) {
            (true, true) => ("Mission finished, landed", Severity::Info),
            (true, false) => ("Mission finished, loitering", Severity::Info),
            (false, true) => ("No valid mission available, refusing takeoff", Severity::Critical),
            (false, false) => ("No valid mission available, loitering", Severity::Critical),
        };
        events.say(severity, text);
        let at = match self.target {
            Target::Place { p_ned, .. } | Target::Up { p_ned } => Some(p_ned),
            _ => None,
        };
        self.stays = true;
        // What has landed goes on landing, should it be in the air after all.
        (!contact.landed).then_some(Turn::Hold(at))
    }

    /// The position to climb to before the way to the place of a task, if it must be climbed.
    fn climb_before(&mut self, task: &Task, s: &Situation<'_>, contact: Contact) -> Option<Vector3<f64>> {
        let place = match task {
            Task::TakeOff { to: at } | Task::Waypoint { at, .. } | Task::Loiter { at, .. } => at,
            _ => return None,
        };
        // (PX4 climbs to MIS_TAKEOFF_ALT above home in the air too; home may be in mid-air here.)
        let least_m = if contact.landed { s.settings.takeoff_height_m } else { f64::NEG_INFINITY };
        let down_m = place.down_m(s.home_ned.z).min(s.p_ned.z - least_m);
        if contact.landed {
            self.climbs = true;
        } else if s.p_ned.z < down_m + HEIGHT_REACHED_M {
            self.climbs = false;
        } else if matches!(task, Task::TakeOff { .. }) {
            self.climbs = true;
        }
        std::mem::take(&mut self.climbs).then(|| Vector3::new(s.p_ned.x, s.p_ned.y, down_m))
    }

    /// Whether the stage of the current item is done.
    fn is_done(&mut self, s: &Situation<'_>, contact: Contact) -> bool {
        let Some(Step { task, .. }) = self.steps.get(self.current).copied() else { return false };
        let near_m = s.settings.mission.reached_within_m;
        let held = |since_us: Option<u64>, hold_s: f64| {
            since_us.is_some_and(|at| s.now_us.saturating_sub(at) as f64 >= hold_s * US_PER_S)
        };
        match (self.stage, task) {
            (Stage::Climb, _) => !contact.landed && self.has_climbed(s),
            (Stage::Approach, _) => self.arrives(s, contact, near_m, None),
            (_, Task::TakeOff { .. }) => self.arrives(s, contact, near_m, None),
            (_, Task::Waypoint { hold_s, radius_m, yaw_rad, .. }) => {
                self.arrives(s, contact, radius_m.unwrap_or(near_m), yaw_rad) && held(self.since_us, hold_s)
            }
            (_, Task::Loiter { hold_s, yaw_rad, .. }) => {
                let there = self.arrives(s, contact, near_m, yaw_rad);
                there && hold_s.is_some_and(|hold_s| held(self.since_us, hold_s))
            }
            (_, Task::LoiterToHeight { at, radius_m }) => {
                let over_m = near_m + radius_m.unwrap_or(s.settings.mission.loiter_radius_m);
                let there = self.arrives(s, contact, over_m, None);
                let p_ned = at.ned(s.home_ned.z);
                if there && self.target.down_m() != Some(p_ned.z) {
                    // Over the place: from here on its own height counts.
                    (self.target, self.since_us) = (Target::Place { p_ned, yaw_rad: None }, None);
                    return false;
                }
                there
            }
            (_, Task::Land { .. }) => contact.landed,
            (_, Task::Delay { hold_s }) => held(self.since_us, hold_s),
            (_, Task::Gripper) => {
                self.release_acknowledged || held(self.since_us, s.settings.mission.release_timeout_s)
            }
            (_, Task::Speed(_) | Task::SetHome | Task::Nothing) => true,
            (_, Task::Return | Task::Jump { .. } | Task::Unsupported) => false,
        }
    }

    /// Whether a climb has come to its height; a low one to half of it, so that it leaves the ground.
    fn has_climbed(&self, s: &Situation<'_>) -> bool {
        let Target::Up { p_ned } = self.target else { return true };
        let height_m = s.home_ned.z - p_ned.z;
        let low = height_m > 0.0 && height_m < HEIGHT_REACHED_M;
        let within_m = if low { height_m / 2.0 } else { HEIGHT_REACHED_M };
        s.p_ned.z < p_ned.z + within_m
    }

    /// Whether it has been at its place, turned to the heading that is asked for; from when on is noted.
    fn arrives(&mut self, s: &Situation<'_>, contact: Contact, within_m: f64, yaw_rad: Option<f64>) -> bool {
        if let Target::Place { p_ned, .. } = self.target
            && self.since_us.is_none()
            && !contact.landed
        {
            let away = s.p_ned - p_ned;
            if away.xy().norm() <= within_m && away.z.abs() <= HEIGHT_REACHED_M {
                self.since_us = Some(s.now_us);
            }
        }
        let off_rad = yaw_rad.map_or(0.0, |yaw_rad| wrap_pi(yaw_rad - s.heading_rad).abs());
        self.turned |= self.since_us.is_some() && off_rad <= s.settings.mission.yaw_within_deg * RAD_PER_DEG;
        self.since_us.is_some() && self.turned
    }

    fn guidance(&mut self, s: &Situation<'_>) -> Option<Guidance> {
        let automatic = s.settings.automatic;
        let level_m_s = self.speed_m_s.unwrap_or(automatic.level_m_s).min(s.settings.greatest.level_m_s);
        let limits = VelocityLimits { level_m_s, ..automatic };
        let still = Guidance { p_ned: [None; 3], v_ned: Vector3::zeros(), limits, yaw: YawSetpoint::Keep };
        let to = |p: Vector3<f64>| [Some(p.x), Some(p.y), Some(p.z)];
        Some(match &mut self.target {
            Target::Nowhere => return None,
            Target::Stop(stop) => Guidance { p_ned: stop.place(s, false).map_or([None; 3], to), ..still },
            Target::Up { p_ned } => {
                let limits = VelocityLimits { up_m_s: s.settings.takeoff_speed_m_s, ..limits };
                Guidance { p_ned: to(*p_ned), limits, ..still }
            }
            Target::Place { p_ned, yaw_rad } => {
                let ahead = p_ned.xy() - s.p_ned.xy();
                // Near its place it does not turn any more.
                let far = ahead.norm() > s.settings.mission.reached_within_m;
                let yaw = match yaw_rad {
                    Some(yaw_rad) => YawSetpoint::Angle(*yaw_rad),
                    None if far => YawSetpoint::Angle(math::atan2(ahead.y, ahead.x)),
                    None => YawSetpoint::Keep,
                };
                Guidance { p_ned: to(*p_ned), yaw, ..still }
            }
            Target::Down { ne } => descent(still, Some(*ne), s),
        })
    }
}

impl Target {
    /// Position down [m] of a target that has one.
    fn down_m(&self) -> Option<f64> {
        match self {
            Self::Place { p_ned, .. } | Self::Up { p_ned } => Some(p_ned.z),
            Self::Nowhere | Self::Stop(_) | Self::Down { .. } => None,
        }
    }
}
