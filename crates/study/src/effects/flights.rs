//! Drops of a mission with and without its effects, from the same random numbers.
//!
//! Each drop is flown from the hang to the mission's end by the mission's own gains, without a wire: 250 Hz,
//! setpoints held at 50 Hz, on the true state. Four kinds of campaign stand beside each other: none of the
//! effects, each alone, all but each, and all. The trials of each have the same swings, winds and eddies, so
//! differences are taken trial by trial.

use std::ops::Range;

use crate::controller::{KeepsHeading, controller};
use crate::jobs::row_of;
use samara_core::assess::{Course, Outcome, Verdict, VerdictBuilder, Verdicts, judge};
use samara_core::control::ControlError;
use samara_core::control::px4::timing::{IMU_PERIOD_S, SETPOINT_PERIOD_S};
use samara_core::sim::{self, Flight, FlightPlan, Reference};
use samara_core::trajectory::Trajectory;
use samara_mission::{Effect, Mission};

/// Which effects are at work in a campaign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EffectsOn {
    /// None: the plain drop.
    Plain,
    /// One alone, with the one that it needs.
    Alone(Effect),
    /// All but one, and those that need it.
    Without(Effect),
    /// All that the mission names.
    All,
}

impl EffectsOn {
    /// The campaigns of a mission with these effects, in the order of the report. With a single effect it is
    /// alone where all are.
    pub fn campaigns(effects: &[Effect]) -> Vec<Self> {
        let each = if effects.len() > 1 { effects } else { &[] };
        let alone = each.iter().map(|effect| Self::Alone(*effect));
        let without = each.iter().map(|effect| Self::Without(*effect));
        [Self::Plain].into_iter().chain(alone).chain([Self::All]).chain(without).collect()
    }

    /// Those of `effects` that are at work: of one that needs another, both.
    pub fn kept(self, effects: &[Effect]) -> Vec<Effect> {
        let kept = |effect: &Effect| match self {
            Self::Plain => false,
            Self::Alone(one) => *effect == one || Some(*effect) == one.needs(),
            Self::Without(one) => *effect != one && effect.needs() != Some(one),
            Self::All => true,
        };
        effects.iter().copied().filter(kept).collect()
    }

    /// Name in files.
    pub fn name(self) -> String {
        let underscored = |effect: Effect| effect.name().replace([' ', '-'], "_");
        match self {
            Self::Plain => "none".to_owned(),
            Self::Alone(effect) => underscored(effect),
            Self::Without(effect) => format!("without_{}", underscored(effect)),
            Self::All => "all".to_owned(),
        }
    }
}

/// What came of a drop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JudgedDrop {
    /// The drop's numbers; none where nothing was released.
    pub outcome: Outcome,
    /// Whether it was steady at the end and within every limit.
    pub safe: bool,
}

row_of!(JudgedDrop { outcome, safe });

impl JudgedDrop {
    /// A drop along its plan to the end, by its verdict; `None`: nothing was released.
    pub fn of(verdict: Option<Verdict>) -> Self {
        let safe = judge(verdict.as_ref(), &Course::WHOLE).is_empty();
        Self { outcome: verdict.map_or_else(Outcome::lost, |verdict| verdict.outcome), safe }
    }
}

/// Flies drops of a mission with some of its effects by its own gains along a plan.
#[derive(Clone, Debug)]
pub struct EffectFlights<'a> {
    mission: Mission,
    plan: &'a Trajectory,
    controller: KeepsHeading,
}

impl<'a> EffectFlights<'a> {
    /// Drops of the mission with these of its effects alone.
    ///
    /// # Errors
    /// [`ControlError`] for a vehicle that cannot be controlled.
    pub fn new(mission: &Mission, kept: &[Effect], plan: &'a Trajectory) -> Result<Self, ControlError> {
        let controller = KeepsHeading::new(controller(mission)?);
        Ok(Self { mission: mission.with_effects(kept), plan, controller })
    }

    /// Flies a trial, a drop by the numbers that a campaign of whole drops draws.
    pub fn fly(&self, trial: u64) -> JudgedDrop {
        self.fly_all(trial..trial + 1).pop().unwrap_or_else(|| JudgedDrop::of(None))
    }

    /// Flies trials, side by side where they may be: each as [`Self::fly`] does.
    pub fn fly_all(&self, trials: Range<u64>) -> Vec<JudgedDrop> {
        self.verdicts(trials).into_iter().map(JudgedDrop::of).collect()
    }

    /// Verdicts on trials, as [`Self::fly_all`] flies them; `None` where nothing was released.
    pub fn verdicts(&self, trials: Range<u64>) -> Vec<Option<Verdict>> {
        let drop = |trial| self.flight(&self.mission.with_drop(&self.mission.draw_drop(trial)));
        let flights: Vec<Flight<'_>> = trials.map(drop).collect();
        let Mission { limits, target_v_ned, .. } = self.mission;
        let builder = VerdictBuilder::judging(limits, target_v_ned).along(self.plan);
        let mut verdicts = Verdicts::by(vec![builder; flights.len()]);
        sim::fly_many(flights, &mut verdicts);
        verdicts.finish()
    }

    /// The mission's own drop, of which nothing is drawn.
    pub fn nominal(&self) -> Flight<'_> {
        self.flight(&self.mission)
    }

    /// The drop of the mission with what was drawn for it.
    fn flight(&self, drawn: &Mission) -> Flight<'_> {
        let Mission { target_v_ned, duration_s, ref control, .. } = self.mission;
        let (trajectory, then_v_ned) = (self.plan, Some(target_v_ned));
        let reference = Reference::Plan { trajectory, then_v_ned, feed_forward: control.feed_forward };
        let plan = FlightPlan {
            setpoint_period_s: Some(SETPOINT_PERIOD_S),
            yaw_sp_rad: None,
            ..FlightPlan::new(reference, IMU_PERIOD_S, duration_s)
        };
        let controller = Box::new(self.controller.clone());
        Flight { simulation: drawn.released_simulation(), controller, plan }
    }
}
