//! What each effect of a mission does to its drops: tables, JSON and rows of [`crate::effects::report`].

use std::ops::Range;

use crate::distributions::distributions;
use crate::effects::{EffectsOn, JudgedDrop};
use samara_core::assess::outcome::{COMPARED, J_TPF};
use samara_core::assess::{Outcome, Quantity, Summary};
use samara_mission::{Effect, Mission};
use samara_report::document::{Document, Figure, Grid, Passage};
use samara_report::figure::FigureError;
use samara_report::json::{Head, finite, result_objects, text};
use samara_report::rows::Columns;

/// A campaign with some of the effects.
#[derive(Clone, Debug)]
pub struct EffectCampaign {
    /// Which effects are at work.
    pub on: EffectsOn,
    /// The trials, in their order.
    pub drops: Vec<JudgedDrop>,
}

/// Campaigns with and without the effects of a mission.
#[derive(Clone, Debug)]
pub struct EffectReport<'a> {
    /// The mission with all its effects.
    pub mission: &'a Mission,
    /// Effects that it names.
    pub effects: Vec<Effect>,
    /// Which trials each campaign has.
    pub trials: Range<u64>,
    /// The campaigns, in the order of [`EffectsOn::campaigns`].
    pub campaigns: Vec<EffectCampaign>,
}

impl EffectCampaign {
    fn failed(&self) -> usize {
        failed(&self.drops)
    }

    fn summary(&self, quantity: &Quantity) -> Summary {
        summary(&self.drops, quantity)
    }

    fn p99(&self, quantity: &Quantity) -> f64 {
        p99(&self.drops, quantity)
    }

    fn change_from(&self, other: &Self, quantity: &Quantity) -> Summary {
        change(&self.drops, &other.drops, quantity)
    }
}

/// How many were not safe.
pub(crate) fn failed(drops: &[JudgedDrop]) -> usize {
    drops.iter().filter(|drop| !drop.safe).count()
}

/// A quantity of those that have it.
pub(crate) fn summary(drops: &[JudgedDrop], quantity: &Quantity) -> Summary {
    let mut summary = Summary::default();
    drops.iter().filter_map(|drop| quantity.of(&drop.outcome)).for_each(|x| summary.push(x));
    summary
}

/// The least value that 99 % of the trials which have one do not exceed; NaN where none has.
pub(crate) fn p99(drops: &[JudgedDrop], quantity: &Quantity) -> f64 {
    let mut values: Vec<f64> = drops.iter().filter_map(|drop| quantity.of(&drop.outcome)).collect();
    values.sort_by(f64::total_cmp);
    let place = (values.len() * 99).div_ceil(100);
    place.checked_sub(1).and_then(|i| values.get(i)).copied().unwrap_or(f64::NAN)
}

/// Differences of a campaign from another one, of the trials that have the quantity in both.
pub(crate) fn change(drops: &[JudgedDrop], from: &[JudgedDrop], quantity: &Quantity) -> Summary {
    let mut summary = Summary::default();
    let of = |drop: &JudgedDrop| quantity.of(&drop.outcome);
    let pairs = drops.iter().zip(from);
    pairs.filter_map(|(a, b)| Some(of(a)? - of(b)?)).for_each(|x| summary.push(x));
    summary
}

/// What drops came to.
pub(crate) fn outcomes(drops: &[JudgedDrop]) -> Vec<Outcome> {
    drops.iter().map(|drop| drop.outcome).collect()
}

/// The figure of what campaigns are compared by.
pub(crate) fn compared_figure(
    mission: &Mission,
    file: &str,
    campaigns: &[(String, Vec<Outcome>)],
) -> Result<Option<Figure>, FigureError> {
    let remark = "Share of the drops at or below a value.";
    distributions((mission, &mission.limits), (file, remark), &COMPARED.each_ref(), campaigns)
}

pub(crate) fn number(x: f64, decimals: usize) -> String {
    if x.is_finite() { format!("{x:.decimals$}") } else { "-".to_owned() }
}

/// Drops with their numbers and the campaign that they are of.
pub(crate) fn numbered<'a, C, D>(
    of: &'a C,
    trials: &Range<u64>,
    drops: &'a [D],
) -> impl Iterator<Item = (u64, &'a C, &'a D)> {
    trials.clone().zip(drops).map(move |(trial, drop)| (trial, of, drop))
}

/// What each row of a table has flown: `300 drops`, or `drop 17` alone.
pub(crate) fn flown(trials: &Range<u64>) -> String {
    match trials.end - trials.start {
        1 => format!("drop {}", trials.start),
        n => format!("{n} drops"),
    }
}

/// The columns of `effects.csv`.
pub(crate) fn columns<'a>() -> Columns<(u64, &'a EffectCampaign, &'a JudgedDrop)> {
    Columns::<(u64, &EffectCampaign, &JudgedDrop)>::none()
        .whole("trial", "number of the trial", |(trial, ..)| *trial)
        .word("effects", "which are at work: `none`, `all`, one alone, or `without_` one", |(_, of, _)| {
            Some(of.on.name())
        })
        .quantities(&COMPARED, |(.., drop)| Some(&drop.outcome))
        .flag("safe", "1: steady at the end and within every limit", |(.., drop)| drop.safe)
}

impl EffectReport<'_> {
    fn campaign(&self, on: EffectsOn) -> Option<&EffectCampaign> {
        self.campaigns.iter().find(|campaign| campaign.on == on)
    }

    /// The campaign that another one's changes are counted from.
    fn base_of(&self, on: EffectsOn) -> Option<&EffectCampaign> {
        match on {
            EffectsOn::Plain => None,
            EffectsOn::Alone(effect) if let Some(needed) = effect.needs() => {
                self.campaign(EffectsOn::Alone(needed))
            }
            EffectsOn::Alone(_) | EffectsOn::All => self.campaign(EffectsOn::Plain),
            EffectsOn::Without(_) => self.campaign(EffectsOn::All),
        }
    }

    /// How the drops with none of the effects, and those with all, are distributed.
    ///
    /// # Errors
    /// [`FigureError`] when the backend fails.
    pub fn figure(&self) -> Result<Option<Figure>, FigureError> {
        let shown = [EffectsOn::Plain, EffectsOn::All].into_iter().filter_map(|on| self.campaign(on));
        let campaigns: Vec<_> = shown.map(|of| (of.on.name(), outcomes(&of.drops))).collect();
        compared_figure(self.mission, "effects.svg", &campaigns)
    }

    /// What each effect does alone, and what its absence does where all others are.
    pub fn document(&self) -> Document {
        let Mission { name, control, seed, .. } = self.mission;
        let (trials, gains) = (flown(&self.trials), &control.gains_name);
        let done = format!("{name}: {trials} for each row, gains {gains}, seed {seed}");
        let width = self.effects.iter().map(|effect| effect.name().len()).max().unwrap_or(0);
        let line = |effect: &Effect| {
            format!("\n  {:width$}  {}; left out: {}", effect.name(), effect.key(), effect.instead())
        };
        let effects = "Effects".to_owned() + &self.effects.iter().map(line).collect::<String>();
        let alone =
            self.table("Each alone: change of the mean from none of them", &[EffectsOn::Plain], |on| {
                matches!(on, EffectsOn::Alone(_) | EffectsOn::All)
            });
        let mut parts = vec![Passage::Said(effects), Passage::Table(alone)];
        if self.effects.len() > 1 {
            let title = "Each left out: change of the mean from all of them";
            let without = |on| matches!(on, EffectsOn::Without(_));
            parts.push(Passage::Table(self.table(title, &[EffectsOn::All], without)));
        }
        let note = "+- is the 95 % interval of a mean change, trial by trial; p99 and worst are of J_TPF.";
        parts.push(Passage::Said(note.to_owned()));
        Document::of_one(format!("What each effect does: {name}"), done, parts)
    }

    fn table(&self, title: &str, base: &[EffectsOn], shown: impl Fn(EffectsOn) -> bool) -> Grid {
        let names = COMPARED.map(|quantity| quantity.head());
        let [cost, others @ ..] = names.each_ref().map(String::as_str);
        let head = ["", cost, "+-", "p99", "worst"].into_iter().chain(others).chain(["failed"]);
        let mut grid = Grid::new(title, head);
        let bases = self.campaigns.iter().filter(|campaign| base.contains(&campaign.on));
        let rows = self.campaigns.iter().filter(|campaign| shown(campaign.on));
        for campaign in bases.chain(rows) {
            let from = self.base_of(campaign.on).filter(|_| !base.contains(&campaign.on));
            let mean = |quantity: &Quantity| match from {
                None => number(campaign.summary(quantity).mean(), quantity.decimals),
                Some(base) => {
                    let mean = campaign.change_from(base, quantity).mean();
                    if mean.is_finite() { format!("{mean:+.*}", quantity.decimals) } else { "-".to_owned() }
                }
            };
            let half = from.map_or(f64::NAN, |base| {
                let (low, high) = campaign.change_from(base, &J_TPF).mean_interval();
                0.5 * (high - low)
            });
            let [cost, others @ ..] = &COMPARED;
            let beside = match campaign.on {
                EffectsOn::Alone(effect) => {
                    effect.needs().map_or(String::new(), |n| format!(", with {}", n.name()))
                }
                _ => String::new(),
            };
            grid.row(
                &format!("{}{beside}", campaign.on.name().replace('_', " ")),
                std::iter::once(mean(cost))
                    .chain(
                        [half, campaign.p99(cost), campaign.summary(cost).max()]
                            .map(|x| number(x, cost.decimals)),
                    )
                    .chain(others.iter().map(mean))
                    .chain([campaign.failed().to_string()]),
            );
        }
        grid
    }

    /// The object of `--json` and of `effects.json`.
    pub fn json(&self) -> String {
        text(&EffectsObject::of(self))
    }

    /// Every drop, a row each: `effects.csv`.
    pub fn csv(&self) -> String {
        let Mission { name, control, .. } = self.mission;
        let (stamp, gains) = (self.mission.stamp().csv_comment(), &control.gains_name);
        let above = format!("{stamp}# drops of {name} with and without its effects, gains {gains}\n");
        columns().csv(&above, self.campaigns.iter().flat_map(|of| numbered(of, &self.trials, &of.drops)))
    }
}

result_objects! {
    /// Drops with and without each effect that the mission names, as `effects.json` holds them.
    EffectsObject(of: &EffectReport<'_>) {
        /// What was flown.
        #[serde(flatten)] head: Head = Head::of(of.mission),
        /// Name of the gains.
        gains: String = of.mission.control.gains_name.clone(),
        /// The effects that the mission names.
        effects: Vec<EffectObject> = of.effects.iter().map(|effect| EffectObject::of(*effect)).collect(),
        /// The campaigns, each with some of the effects.
        campaigns: Vec<EffectCampaignObject>
            = of.campaigns.iter().map(|campaign| EffectCampaignObject::of(of, campaign)).collect(),
    }

    /// An effect.
    EffectObject(effect: Effect) {
        /// Name of the effect.
        name: String = effect.name().to_owned(),
        /// Key that names it in a mission or its vehicle.
        key: String = effect.key().to_owned(),
        /// What there is where it is left out, in words.
        left_out: String = effect.instead().to_owned(),
    }

    /// Drops with some of the effects.
    EffectCampaignObject(of: &EffectReport<'_>, campaign: &EffectCampaign) [
        let base = of.base_of(campaign.on);
    ] {
        /// Name of the campaign.
        name: String = campaign.on.name(),
        /// Names of the effects that it has.
        effects: Vec<String>
            = campaign.on.kept(&of.effects).into_iter().map(|effect| effect.name().to_owned()).collect(),
        /// Name of the campaign that changes are counted from; null: none are.
        changed_from: Option<String> = base.map(|base| base.on.name()),
        /// Number of drops.
        trials: usize = campaign.drops.len(),
        /// Number of drops that were not safe.
        failed: usize = campaign.failed(),
        /// The quantities, each with its change.
        measures: Vec<ComparedObject> = compared(&campaign.drops, base.map(|base| base.drops.as_slice())),
    }

    /// A quantity of some drops.
    ComparedObject(drops: &[JudgedDrop], from: Option<&[JudgedDrop]>, quantity: &Quantity) [
        let s = summary(drops, quantity);
    ] {
        /// Name of the quantity; it ends in its unit.
        name: String = quantity.key.to_owned(),
        /// Number of drops that have it.
        count: u64 = s.count(),
        /// Mean of the drops that have it.
        mean: Option<f64> = finite(s.mean()),
        /// Value that 99 % of those do not exceed.
        p99: Option<f64> = finite(p99(drops, quantity)),
        /// Least value.
        min: Option<f64> = finite(s.min()),
        /// Greatest value.
        max: Option<f64> = finite(s.max()),
        /// The change from the same drops flown otherwise; null where they are not compared.
        change: Option<ChangeObject> = from.map(|from| ChangeObject::of(&change(drops, from, quantity))),
    }

    /// How a quantity differs from that of the same drops flown otherwise, drop by drop.
    ChangeObject(change: &Summary) {
        /// Number of drops that have the quantity both ways.
        count: u64 = change.count(),
        /// Mean difference.
        mean: Option<f64> = finite(change.mean()),
        /// Lower end of the interval of the mean difference.
        mean_low: Option<f64> = finite(change.mean_interval().0),
        /// Upper end of that interval.
        mean_high: Option<f64> = finite(change.mean_interval().1),
    }
}

/// The quantities of some drops, and how each differs from that of the same drops flown otherwise.
pub(crate) fn compared(drops: &[JudgedDrop], from: Option<&[JudgedDrop]>) -> Vec<ComparedObject> {
    COMPARED.iter().map(|quantity| ComparedObject::of(drops, from, quantity)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use samara_core::sim::{Fault, FaultKind};

    /// By hand: what needs another effect stands with it, is counted from it, and goes with it.
    #[test]
    fn an_effect_stands_with_the_one_that_it_needs() {
        let effects = [Effect::Gusts, Effect::RotorInflow, Effect::RotorStart];
        let kept = |on: EffectsOn| on.kept(&effects);
        assert_eq!(kept(EffectsOn::Alone(Effect::RotorStart)), [Effect::RotorInflow, Effect::RotorStart]);
        assert_eq!(kept(EffectsOn::Alone(Effect::Gusts)), [Effect::Gusts]);
        assert_eq!(kept(EffectsOn::Without(Effect::RotorInflow)), [Effect::Gusts]);
        assert_eq!(kept(EffectsOn::Without(Effect::RotorStart)), [Effect::Gusts, Effect::RotorInflow]);
        assert_eq!(EffectsOn::campaigns(&effects).len(), 8);
        assert_eq!(EffectsOn::campaigns(&effects[..1]), [EffectsOn::Plain, EffectsOn::All]);
        let mission = Mission::shipped("titan_drop").unwrap();
        let campaigns = EffectsOn::campaigns(&effects)
            .into_iter()
            .map(|on| EffectCampaign { on, drops: Vec::new() })
            .collect();
        let report = EffectReport { mission: &mission, effects: effects.to_vec(), trials: 0..0, campaigns };
        let base = |on| report.base_of(on).map(|campaign| campaign.on);
        assert_eq!(base(EffectsOn::Alone(Effect::RotorStart)), Some(EffectsOn::Alone(Effect::RotorInflow)));
        assert_eq!(base(EffectsOn::Alone(Effect::Gusts)), Some(EffectsOn::Plain));
        assert_eq!(base(EffectsOn::Without(Effect::Gusts)), Some(EffectsOn::All));
    }

    /// A leg of the bridle hangs up under the canopy that it is of, and not where that is left out.
    #[test]
    fn a_riser_hangs_up_under_its_canopy_alone() {
        let mut mission = Mission::shipped("titan_drop").unwrap();
        let kind = FaultKind::RiserHungUp { attachment_body_m: nalgebra::Vector3::new(0.6, 0.0, -0.5) };
        mission.faults.list = vec![Fault { kind, at_s: -1.0, until_s: None }];
        assert_eq!(mission.with_effects(&mission.effects()).faults.list.len(), 1);
        let alone = mission.with_effects(&[Effect::Faults]);
        assert!(alone.faults.list.is_empty() && alone.release.parachute.suspension.is_none());
        mission.faults.list.push(Fault { kind: FaultKind::SetpointLoss, at_s: 1.0, until_s: None });
        assert_eq!(mission.with_effects(&[Effect::Faults]).faults.list.len(), 1);
    }

    /// A mission with all of its effects is itself, and without any of them it has none.
    #[test]
    fn prop_effects_can_be_left_out_and_kept() {
        for name in ["titan_drop", "x500_drop"] {
            let mission = Mission::shipped(name).unwrap();
            let effects = mission.effects();
            assert!(effects.len() >= 8, "{effects:?}");
            assert_eq!(mission.with_effects(&effects).effects(), effects);
            assert_eq!(mission.with_effects(&[]).effects(), []);
            for effect in &effects {
                let alone = mission.with_effects(&EffectsOn::Alone(*effect).kept(&effects)).effects();
                assert!(alone.contains(effect), "{effect:?}: {alone:?}");
            }
        }
    }
}
