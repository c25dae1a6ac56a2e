//! Drops along one plan and along plans that are renewed: table, JSON and rows of [`crate::replan::report`].

use std::ops::Range;

use crate::effects::JudgedDrop;
use crate::effects::report::{
    ComparedObject, change, compared, compared_figure, failed, flown, number, numbered, outcomes, p99,
    summary,
};
use crate::replan::{ReplanDrop, ReplanRow};
use samara_core::assess::outcome::{ALTITUDE_LOST, COMPARED, J_TPF, STEADY_AFTER};
use samara_mission::Mission;
use samara_report::document::{Document, Figure, Grid, Passage};
use samara_report::figure::FigureError;
use samara_report::json::{Head, result_objects, text};
use samara_report::rows::Columns;

/// A campaign of drops flown alike.
#[derive(Clone, Debug)]
pub struct ReplanCampaign {
    /// How they were flown.
    pub row: ReplanRow,
    /// The trials, in their order.
    pub drops: Vec<ReplanDrop>,
}

/// Campaigns along one plan and along renewed ones.
#[derive(Clone, Debug)]
pub struct ReplanReport<'a> {
    /// The mission.
    pub mission: &'a Mission,
    /// The autopilot that flew them over the wire; `None`: the cascade without one.
    pub autopilot: Option<&'static str>,
    /// Which trials each campaign has.
    pub trials: Range<u64>,
    /// The campaigns, in the order of [`ReplanRow::campaigns`]: differences are from the first.
    pub campaigns: Vec<ReplanCampaign>,
}

impl ReplanCampaign {
    fn flown(&self) -> Vec<JudgedDrop> {
        self.drops.iter().map(|drop| drop.drop).collect()
    }

    fn sum(&self, of: fn(&ReplanDrop) -> usize) -> usize {
        self.drops.iter().map(of).sum()
    }

    /// Share of the trials whose J_TPF is below that of the same trial of another campaign [%].
    fn better_percent(&self, other: &Self) -> f64 {
        let pairs = self.drops.iter().zip(&other.drops);
        let better = pairs.filter(|(a, b)| a.drop.outcome.j_tpf < b.drop.outcome.j_tpf).count();
        100.0 * better as f64 / self.drops.len().max(1) as f64
    }
}

/// The columns of `replan.csv`.
pub(crate) fn columns<'a>() -> Columns<(u64, &'a ReplanCampaign, &'a ReplanDrop)> {
    Columns::<(u64, &ReplanCampaign, &ReplanDrop)>::none()
        .whole("trial", "number of the trial", |(trial, ..)| *trial)
        .word("replan", "`once`, `once_fed_forward`, `release` or a rate such as `2_hz`", |(_, of, _)| {
            Some(of.row.name())
        })
        .word("gains", "name of the gains", |(_, of, _)| Some(of.row.gains_name.clone()))
        .quantities(&COMPARED, |(.., flown)| Some(&flown.drop.outcome))
        .flag("safe", "1: steady at the end and within every limit", |(.., flown)| flown.drop.safe)
        .whole("renewed", "plans that were renewed", |(.., flown)| flown.renewed as u64)
        .whole("kept", "attempts after which the plan was kept", |(.., flown)| flown.kept as u64)
        .whole("iterations", "the solver's, of all attempts", |(.., flown)| flown.iterations as u64)
}

impl ReplanReport<'_> {
    /// How the drops of each campaign are distributed.
    ///
    /// # Errors
    /// [`FigureError`] when the backend fails.
    pub fn figure(&self) -> Result<Option<Figure>, FigureError> {
        let of = |campaign: &ReplanCampaign| (campaign.row.words(), outcomes(&campaign.flown()));
        let campaigns: Vec<_> = self.campaigns.iter().map(of).collect();
        compared_figure(self.mission, "replan.svg", &campaigns)
    }

    /// The table.
    pub fn document(&self) -> Document {
        let mission = self.mission;
        let settings = &mission.replan.settings;
        let mut grid = Grid::new(
            "Plans renewed during the drop, the same drops in each row",
            [
                "",
                "gains",
                "J_TPF",
                "change",
                "+-",
                "better in",
                "p99",
                "worst",
                &STEADY_AFTER.head(),
                &ALTITUDE_LOST.head(),
                "failed",
                "renewed",
                "kept",
            ],
        );
        let base = self.campaigns.first();
        for (i, campaign) in self.campaigns.iter().enumerate() {
            let (flown, cost) = (campaign.flown(), &J_TPF);
            let from = base.filter(|_| i > 0);
            let changed = from.map(|base| change(&flown, &base.flown(), cost));
            let (mean, half) = changed.map_or((f64::NAN, f64::NAN), |change| {
                let (low, high) = change.mean_interval();
                (change.mean(), 0.5 * (high - low))
            });
            let signed = if mean.is_finite() { format!("{mean:+.4}") } else { "-".to_owned() };
            let better =
                from.map_or("-".to_owned(), |base| format!("{:.0} %", campaign.better_percent(base)));
            grid.row(
                &campaign.row.words(),
                [
                    campaign.row.gains_name.clone(),
                    number(summary(&flown, cost).mean(), 4),
                    signed,
                    number(half, 4),
                    better,
                    number(p99(&flown, cost), 4),
                    number(summary(&flown, cost).max(), 4),
                    number(summary(&flown, &STEADY_AFTER).mean(), STEADY_AFTER.decimals),
                    number(summary(&flown, &ALTITUDE_LOST).mean(), ALTITUDE_LOST.decimals),
                    failed(&flown).to_string(),
                    campaign.sum(|drop| drop.renewed).to_string(),
                    campaign.sum(|drop| drop.kept).to_string(),
                ],
            );
        }
        let done = format!(
            "{}: {} for each row{}, seed {}; a renewed plan takes effect {} s after its measurement, at most {} iterations",
            mission.name,
            flown(&self.trials),
            self.autopilot.map_or(String::new(), |name| format!(" by {name}")),
            mission.seed,
            settings.latency_s,
            settings.iterations,
        );
        let note = "change is of the mean from the first row, trial by trial; +- the half width of its 95 % interval; \
             better in: the share of the drops whose J_TPF is below the first row's.";
        let parts = vec![Passage::Table(grid), Passage::Said(note.to_owned())];
        Document::of_one(format!("Plans renewed in the fall: {}", mission.name), done, parts)
    }

    /// The object of `--json` and of `replan.json`.
    pub fn json(&self) -> String {
        text(&ReplanObject::of(self))
    }

    /// Every drop, a row each: `replan.csv`.
    pub fn csv(&self) -> String {
        let Mission { name, .. } = self.mission;
        let comment = self.mission.stamp().csv_comment();
        let above = format!("{comment}# drops of {name} along one plan and along renewed ones\n");
        columns().csv(&above, self.campaigns.iter().flat_map(|of| numbered(of, &self.trials, &of.drops)))
    }
}

result_objects! {
    /// Drops along one plan and along plans that are renewed, as `replan.json` holds them.
    ReplanObject(of: &ReplanReport<'_>) [
        let settings = &of.mission.replan.settings;
        let first = |i: usize| of.campaigns.first().filter(|_| i > 0);
        let campaigns = of.campaigns.iter().enumerate();
    ] {
        /// What was flown.
        #[serde(flatten)] head: Head = Head::of(of.mission),
        /// Name of the autopilot of whole drops; absent where flights begin at t = 0.
        autopilot unless "Option::is_none": Option<String> = of.autopilot.map(ToString::to_string),
        /// Time from a measurement until the renewed plan takes effect [s].
        latency_s: f64 = settings.latency_s,
        /// Most iterations of a solve.
        iterations: usize = settings.iterations,
        /// The campaigns; changes are counted from the first.
        campaigns: Vec<ReplanCampaignObject>
            = campaigns.map(|(i, campaign)| ReplanCampaignObject::of(campaign, first(i))).collect(),
    }

    /// Drops with one way to renew the plan.
    ReplanCampaignObject(campaign: &ReplanCampaign, base: Option<&ReplanCampaign>) [
        let (flown, from) = (campaign.flown(), base.map(ReplanCampaign::flown));
    ] {
        /// Name of the campaign.
        name: String = campaign.row.name(),
        /// When the plan is renewed; null: never.
        replan: Option<String> = campaign.row.cadence.map(|cadence| cadence.to_string()),
        /// Whether the plan's accelerations are fed forward.
        feed_forward: bool = campaign.row.feed_forward,
        /// Name of the gains.
        gains: String = campaign.row.gains_name.clone(),
        /// Number of drops.
        trials: usize = campaign.drops.len(),
        /// Number of drops that were not safe.
        failed: usize = failed(&flown),
        /// Share of the drops whose J_TPF is below that of the first campaign [%]; null of that one.
        better_percent: Option<f64> = base.map(|base| campaign.better_percent(base)),
        /// Number of plans that were renewed.
        renewed: usize = campaign.sum(|drop| drop.renewed),
        /// Number of plans that were to be renewed and were kept.
        kept: usize = campaign.sum(|drop| drop.kept),
        /// Number of iterations of all solves.
        solver_iterations: usize = campaign.sum(|drop| drop.iterations),
        /// The quantities, each with its change.
        measures: Vec<ComparedObject> = compared(&flown, from.as_deref()),
    }
}
