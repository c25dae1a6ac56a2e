//! Results of finding the fall from the accelerometer alone: a table for the terminal, CSV, JSON.

use std::borrow::Borrow;

use samara_core::assess::free_fall::rules::{Rule, TIMES_S};
use samara_core::assess::free_fall::{DESCENT_S, Descent, FoundRelease, FreeFallStudy, ReleaseTrial};
use samara_core::assess::{Share, rate_bound};
use samara_core::units::DEG_PER_RAD;
use samara_mission::Mission;
use samara_report::columns::fixed;
use samara_report::document::{Document, Grid, Passage};
use samara_report::json::{Head, finite, result_objects, text};
use samara_report::rows::Columns;

/// Seconds of an hour.
const S_PER_H: f64 = 3600.0;

/// Releases and descents of a mission.
#[derive(Clone, Debug)]
pub struct FreeFallReport<'a> {
    /// The mission.
    pub mission: &'a Mission,
    /// What was flown.
    pub study: FreeFallStudy,
    /// The releases, in their order.
    pub releases: Vec<ReleaseTrial>,
    /// The descents, in their order.
    pub descents: Vec<Descent>,
}

/// What the readings at a rate made of all releases.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FoundBy {
    missed: u64,
    /// Upper end of Clopper and Pearson's interval of the share that is missed.
    missed_share_high: f64,
    early: u64,
    median_s: f64,
    p99_s: f64,
    worst_s: f64,
    /// Median of how much later than the release the fall is said to have begun [s].
    dated_median_s: f64,
    dated_least_s: f64,
    dated_most_s: f64,
}

/// A rule's place among the others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OperatingPoint {
    /// The rule.
    pub rule: Rule,
    /// Releases that it missed.
    pub missed: u64,
    /// Median time from the release until it found the fall [s]; infinite where it missed half.
    pub median_s: f64,
    /// Falls that it found in descents under a taut riser, each hour.
    pub alarms_per_h: f64,
    /// Upper bound of that rate, 95 %.
    pub alarms_per_h_high: f64,
    /// Falls that it found in descents with a slack riser.
    pub slack_alarms: u64,
}

/// The value below which a share of sorted values lies.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let last = sorted.len().checked_sub(1);
    last.map_or(f64::NAN, |last| sorted[((last as f64 * share).round() as usize).min(last)])
}

fn sorted(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values
}

impl FoundBy {
    fn of<'a>(found: impl Iterator<Item = &'a FoundRelease> + Clone) -> Self {
        let mut missed = Share::default();
        found.clone().for_each(|found| missed.push(found.is_missed()));
        let after = sorted(found.clone().map(|found| found.after_s.unwrap_or(f64::INFINITY)));
        let dated = sorted(found.clone().filter_map(|found| found.dated_late_s));
        Self {
            missed: missed.trials() - missed.misses(),
            missed_share_high: missed.interval().1,
            early: found.filter(|found| found.is_early()).count() as u64,
            median_s: quantile(&after, 0.5),
            p99_s: quantile(&after, 0.99),
            worst_s: quantile(&after, 1.0),
            dated_median_s: quantile(&dated, 0.5),
            dated_least_s: quantile(&dated, 0.0),
            dated_most_s: quantile(&dated, 1.0),
        }
    }
}

impl FreeFallReport<'_> {
    fn hours(&self) -> f64 {
        self.descents.len() as f64 * DESCENT_S / S_PER_H
    }

    fn sum(&self, of: fn(&Descent) -> u64) -> u64 {
        self.descents.iter().map(of).sum()
    }

    fn slack_s(&self) -> f64 {
        self.descents.iter().map(|descent| descent.slack_s).sum()
    }

    fn least_share(&self) -> f64 {
        let least = self.descents.iter().fold(f64::INFINITY, |least, descent| least.min(descent.least_m_s2));
        least / self.study.environment.gravity_m_s2
    }

    fn found(&self) -> [(&'static str, FoundBy); 2] {
        [
            ("autopilot, 250 Hz", FoundBy::of(self.releases.iter().map(|trial| &trial.autopilot))),
            ("companion, 62.5 Hz", FoundBy::of(self.releases.iter().map(|trial| &trial.companion))),
        ]
    }

    /// Whether every release was found, none before it was, and nothing else while the riser was taut.
    pub fn holds(&self) -> bool {
        self.found().iter().all(|(_, found)| found.missed == 0 && found.early == 0)
            && self.sum(|descent| descent.alarms) == 0
    }

    /// Every rule's place, in the order of [`Rule::all`].
    pub fn operating_points(&self) -> Vec<OperatingPoint> {
        let hours = self.hours();
        let at = |(k, rule): (usize, Rule)| {
            let after = sorted(self.releases.iter().map(|trial| f64::from(trial.rules_s[k])));
            let alarms = |slack: usize| -> u64 { self.descents.iter().map(|d| d.rules[k][slack]).sum() };
            OperatingPoint {
                rule,
                missed: after.iter().filter(|after_s| after_s.is_infinite()).count() as u64,
                median_s: quantile(&after, 0.5),
                alarms_per_h: alarms(0) as f64 / hours,
                alarms_per_h_high: rate_bound(alarms(0), hours),
                slack_alarms: alarms(1),
            }
        };
        Rule::all().enumerate().map(at).collect()
    }

    /// The tables.
    pub fn document(&self) -> Document {
        let Self { mission, study, .. } = self;
        let (g, circumstances) = (study.environment.gravity_m_s2, &study.circumstances);
        let done = format!(
            "{}: releases found by the fall, seed {}; level {:.3} g, {:.4} m/s of lack, where the air carries {:.3} g after the release\n\
             swing to {:.0} deg, tumbling to {:.0} deg/s, wind to {:.0} m/s, turbulence of {} m/s at a scale of {} m",
            mission.name,
            mission.seed,
            study.settings.level_m_s2 / g,
            study.settings.lack_m_s,
            study.fall_m_s2 / g,
            circumstances.swing_rad * DEG_PER_RAD,
            circumstances.tumble_rad_s * DEG_PER_RAD,
            circumstances.wind_m_s,
            circumstances.turbulence_m_s,
            circumstances.scale_m,
        );
        let head = [
            "",
            "missed",
            "share below",
            "early",
            "median [ms]",
            "p99 [ms]",
            "worst [ms]",
            "dated late [ms]",
        ];
        let mut grid = Grid::new(&format!("{} releases", self.releases.len()), head);
        let ms = |s: f64| if s.is_finite() { fixed(1e3 * s, 0) } else { "-".to_owned() };
        for (name, found) in self.found() {
            grid.row(
                name,
                [
                    found.missed.to_string(),
                    format!("{:.1e}", found.missed_share_high),
                    found.early.to_string(),
                    ms(found.median_s),
                    ms(found.p99_s),
                    ms(found.worst_s),
                    format!(
                        "{} ({} to {})",
                        ms(found.dated_median_s),
                        ms(found.dated_least_s),
                        ms(found.dated_most_s)
                    ),
                ],
            );
        }
        let (alarms, hours) = (self.sum(|descent| descent.alarms), self.hours());
        let descents = format!(
            "{hours:.0} h of descent without a release: {alarms} false alarms under a taut riser, below {:.2e} an hour (95 %);\n\
             {} alarms with the riser slack; it was slack {} times, {:.2} s together; least specific force {:.3} g",
            rate_bound(alarms, hours),
            self.sum(|descent| descent.slack_alarms),
            self.sum(|descent| descent.slack_spells),
            self.slack_s(),
            self.least_share(),
        );
        let note = "lack: the lack is summed; hold: below the level all the time, as PX4 has it; median from the release [ms], \
                then false alarms an hour under a taut riser, then releases missed.";
        let rules = [Passage::Table(self.rules_grid()), Passage::Remark(note.to_owned())];
        let parts = [Passage::Table(grid), Passage::Said(descents)].into_iter().chain(rules).collect();
        Document::of_one(format!("Releases found by the fall: {}", mission.name), done, parts)
    }

    fn rules_grid(&self) -> Grid {
        let head = std::iter::once("rule, level".to_owned())
            .chain(TIMES_S.iter().map(|time_s| format!("{:.0} ms", 1e3 * time_s)));
        let mut grid = Grid::new("Rules and settings beside each other", head);
        for points in self.operating_points().chunks(TIMES_S.len()) {
            let Some(OperatingPoint { rule, .. }) = points.first() else { continue };
            let cell = |point: &OperatingPoint| {
                let median = if point.median_s.is_finite() {
                    format!("{:.0}", 1e3 * point.median_s)
                } else {
                    "-".to_owned()
                };
                format!("{median} {:.2e} {}", point.alarms_per_h, point.missed)
            };
            grid.row(&format!("{} {}", rule.kind.name(), rule.level), points.iter().map(cell));
        }
        grid
    }

    /// The object of `--json` and of `free_fall.json`.
    pub fn json(&self) -> String {
        text(&FreeFallObject::of(self))
    }

    fn csv<R>(
        &self,
        what: &str,
        columns: &Columns<R>,
        rows: impl IntoIterator<Item = impl Borrow<R>>,
    ) -> String {
        let comment = self.mission.stamp().csv_comment();
        columns.csv(&format!("{comment}# {what} of {}\n", self.mission.name), rows)
    }

    /// Every release, a row each: `free_fall_releases.csv`.
    pub fn releases_csv(&self) -> String {
        self.csv("releases", &release_columns(), &self.releases)
    }

    /// Every hour of descent, a row each: `free_fall_descents.csv`.
    pub fn descents_csv(&self) -> String {
        self.csv("descents", &descent_columns(), &self.descents)
    }

    /// Every rule, a row each: `free_fall_rules.csv`.
    pub fn rules_csv(&self) -> String {
        self.csv("rules", &rule_columns(), self.operating_points())
    }
}

/// The columns of `free_fall_releases.csv`.
pub(crate) fn release_columns() -> Columns<ReleaseTrial> {
    let micro = |x: Option<f64>| x.map(|x| (1e6 * x).round() / 1e6);
    Columns::<ReleaseTrial>::none()
        .whole("trial", "number of the trial", |row| row.trial)
        .number("swing_deg", "amplitude of the swing", |row| row.swing_rad * DEG_PER_RAD)
        .number("tumble_deg_s", "rate that the release gave", |row| row.tumble_rad_s * DEG_PER_RAD)
        .number("wind_m_s", "mean wind", |row| row.wind_m_s)
        .number("autopilot_after_s", AFTER, move |row| micro(row.autopilot.after_s))
        .number("autopilot_dated_late_s", DATED, move |row| micro(row.autopilot.dated_late_s))
        .number("companion_after_s", AFTER, move |row| micro(row.companion.after_s))
        .number("companion_dated_late_s", DATED, move |row| micro(row.companion.dated_late_s))
}
const AFTER: &str = "when it was found after the release, at that rate of readings; empty: missed";
const DATED: &str = "how much later than the release the fall is said to have begun; empty: missed";

/// The columns of `free_fall_descents.csv`.
pub(crate) fn descent_columns() -> Columns<Descent> {
    Columns::<Descent>::none()
        .whole("hour", "number of the descent", |row| row.trial)
        .whole("alarms", "falls that were found under a taut riser", |row| row.alarms)
        .whole("slack_alarms", "falls that were found while the riser was slack", |row| row.slack_alarms)
        .whole("slack_spells", "how often the riser was slack", |row| row.slack_spells)
        .word("slack_s", "for how long", |row| Some(format!("{:.3}", row.slack_s)))
        .number("least_m_s2", "least specific force", |row| row.least_m_s2)
}

/// The columns of `free_fall_rules.csv`.
pub(crate) fn rule_columns() -> Columns<OperatingPoint> {
    const ALARMS: &str = "false alarms an hour under a taut riser, and the upper bound of 95 %";
    let median = |row: &OperatingPoint| row.median_s.is_finite().then(|| format!("{:.4}", row.median_s));
    Columns::<OperatingPoint>::none()
        .word("rule", "`lack` or `hold`", |row| Some(row.rule.kind.name().to_owned()))
        .number("level_share", "level, over gravity", |row| row.rule.level)
        .number("time_s", "how long", |row| row.rule.time_s)
        .whole("missed", "releases that it missed", |row| row.missed)
        .word("median_s", "median time from the release to the find; empty: half are missed", median)
        .number("alarms_per_h", ALARMS, |row| row.alarms_per_h)
        .number("alarms_per_h_high", ALARMS, |row| row.alarms_per_h_high)
        .whole("slack_alarms", "falls that it found while the riser was slack", |row| row.slack_alarms)
}

result_objects! {
    /// How the release is found by the fall alone, as `free_fall.json` holds it.
    FreeFallObject(of: &FreeFallReport<'_>) [
        let (study, circumstances) = (&of.study, &of.study.circumstances);
        let (alarms, hours) = (of.sum(|descent| descent.alarms), of.hours());
        let [(_, autopilot), (_, companion)] = of.found();
    ] {
        /// What was flown.
        #[serde(flatten)] head: Head = Head::of(of.mission),
        /// Specific force below which a fall is lacking some [m/s^2].
        level_m_s2: f64 = study.settings.level_m_s2,
        /// Lack at which a fall is found [m/s].
        lack_m_s: f64 = study.settings.lack_m_s,
        /// Acceleration of the fall [m/s^2].
        fall_m_s2: f64 = study.fall_m_s2,
        /// Swing under the canopy, one standard deviation [deg].
        swing_deg: f64 = circumstances.swing_rad * DEG_PER_RAD,
        /// Tumble after the release, one standard deviation [deg/s].
        tumble_deg_s: f64 = circumstances.tumble_rad_s * DEG_PER_RAD,
        /// Wind, one standard deviation [m/s].
        wind_m_s: f64 = circumstances.wind_m_s,
        /// Turbulence, one standard deviation [m/s].
        turbulence_m_s: f64 = circumstances.turbulence_m_s,
        /// Scale of the turbulence [m].
        scale_m: f64 = circumstances.scale_m,
        /// Number of releases.
        releases: usize = of.releases.len(),
        /// What the autopilot found, from every sample.
        autopilot: FoundObject = FoundObject::of(&autopilot),
        /// What the companion found, from the messages that it gets.
        companion: FoundObject = FoundObject::of(&companion),
        /// Hours of descent without a release.
        hours: f64 = hours,
        /// Number of falls that were found in them.
        alarms: u64 = alarms,
        /// Upper bound of their rate [1/h].
        alarms_per_h_high: f64 = rate_bound(alarms, hours),
        /// Number of falls that were found while the riser was slack.
        slack_alarms: u64 = of.sum(|descent| descent.slack_alarms),
        /// Number of times that the riser was slack.
        slack_spells: u64 = of.sum(|descent| descent.slack_spells),
        /// Time that the riser was slack [s].
        slack_s: f64 = of.slack_s(),
        /// Least specific force under a taut riser, as a share of the weight's.
        least_share: Option<f64> = finite(of.least_share()),
        /// Whether the settings hold: every fall is found, and none without one.
        holds: bool = of.holds(),
    }

    /// What was found of the releases. Times are since the release.
    FoundObject(by: &FoundBy) {
        /// Number of releases that were missed.
        missed: u64 = by.missed,
        /// Upper bound of the share that is missed.
        missed_share_high: f64 = by.missed_share_high,
        /// Number of falls that were found before the release.
        early: u64 = by.early,
        /// Median time until the fall was found [s].
        median_s: Option<f64> = finite(by.median_s),
        /// Time within which 99 % were found [s].
        p99_s: Option<f64> = finite(by.p99_s),
        /// Longest time until it was found [s]; null where one was missed.
        worst_s: Option<f64> = finite(by.worst_s),
        /// Median by which the fall is dated after the release [s].
        dated_late_median_s: Option<f64> = finite(by.dated_median_s),
        /// Least of those [s]; negative: before.
        dated_late_least_s: Option<f64> = finite(by.dated_least_s),
        /// Greatest of those [s].
        dated_late_most_s: Option<f64> = finite(by.dated_most_s),
    }
}
