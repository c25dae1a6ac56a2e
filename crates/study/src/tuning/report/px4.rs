//! Gains for PX4: what was found, beside PX4's defaults, for the terminal, for the parameter file and as
//! JSON.

use crate::range_ends::{RangeEndsObject, range_ends_words};
use samara_core::control::px4::{Law, Parameters};
use samara_core::params::Purpose;
use samara_core::tune::RangeEnds;
use samara_core::tune::px4::space::names;
use samara_core::tune::px4::{MEASURED, Measures};
use samara_mission::Mission;
use samara_report::document::{Document, Grid, Passage};
use samara_report::json::{Head, object, text};

/// What costs are measured by, unless it cannot be.
pub const PX4S_DEFAULTS: &str = "PX4's defaults";

/// A search's result.
#[derive(Clone, Debug)]
pub struct Px4Gains {
    /// Name of the gains.
    pub name: String,
    /// The law that they were found on.
    pub law: Law,
    /// What the parameters are for.
    pub purpose: Purpose,
    /// PX4's defaults on the unseen drops.
    pub defaults: Measures,
    /// What costs were measured by: [`PX4S_DEFAULTS`], unless these do not come through the drops within the
    /// limits.
    pub measured_by: &'static str,
    /// The parameters found on the unseen drops.
    pub found: Measures,
    /// All parameters that the model of PX4's controller reads.
    pub parameters: Parameters,
    /// Those of the numbers searched that stand at an end of their range.
    pub range_ends: RangeEnds,
    /// Why all these drops were flown on the truth, and not on PX4's estimate, where they were.
    pub truth: Option<String>,
    /// Latency of all these drops, on the site's clock [s].
    pub latency_s: f64,
    /// Drops that candidates were judged by.
    pub drops: u64,
    /// Unseen drops.
    pub unseen: u64,
    /// Candidates judged.
    pub evaluations: usize,
    /// Whether the search was stopped.
    pub stopped: bool,
}

/// A measure: name, unit, decimals, value.
type Measure = (&'static str, &'static str, usize, f64);

/// The measures of some drops.
fn measures(of: &Measures) -> impl Iterator<Item = Measure> {
    let measured = MEASURED.into_iter().zip(of.measured);
    let measured = measured.map(|(quantity, x)| (quantity.words, quantity.unit, quantity.decimals, x));
    measured.chain([("velocity error, RMS", "m/s", 4, of.velocity_rms_m_s)])
}

/// Shares of the drops.
fn shares(of: &Measures) -> [Measure; 2] {
    [("not safe", "%", 1, 100.0 * of.unsafe_share), ("steady at the end", "%", 1, 100.0 * of.steady_share)]
}

impl Px4Gains {
    /// The remark on the measure of costs, if it is not the usual one.
    fn other_measure(&self) -> Option<String> {
        let by = self.measured_by;
        (by != PX4S_DEFAULTS)
            .then(|| format!("candidates were measured by {by}: {PX4S_DEFAULTS} fly not every drop safely"))
    }

    /// What of PX4 the model has flown.
    fn modelled(&self) -> &'static str {
        if self.truth.is_none() { "control law and estimator" } else { "control law" }
    }

    /// What the search did not choose but took from the mission's receiver, or that it knew nothing of it.
    fn of_the_receiver(&self) -> String {
        let noise = self.parameters.gps_v_noise;
        let taken = || format!("EKF2_GPS_V_NOISE {noise}: the noise of the mission's receiver");
        self.truth.clone().unwrap_or_else(taken)
    }

    /// The remarks in the header of the parameter file.
    pub fn remarks(&self) -> Vec<String> {
        let listed = |m: &Measures| {
            let values = measures(m).map(|(name, unit, digits, x)| {
                let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
                format!("{name} {x:.digits$}{unit}")
            });
            values.collect::<Vec<_>>().join(", ")
        };
        let measured_by = self.other_measure();
        let found = vec![
            format!(
                "found on the model of PX4 {}'s {} with {:.1} ms of latency, {} drops; means of {} others: {}",
                self.law.since,
                self.modelled(),
                1e3 * self.latency_s,
                self.drops,
                self.unseen,
                listed(&self.found)
            ),
            format!("PX4's defaults on the same: {}", listed(&self.defaults)),
        ];
        let more = measured_by.into_iter().chain([self.of_the_receiver()]);
        found.into_iter().chain(more).chain(range_ends_words(&self.range_ends)).collect()
    }
}

/// What is said of the gains, beside PX4's defaults.
pub fn document(mission: &Mission, gains: &Px4Gains) -> Document {
    let done = format!(
        "samara tune: {}, gains {} for {}: {} candidates judged by {} drops on the model of PX4 {}'s {} with {:.1} ms of latency{}",
        mission.name,
        gains.name,
        gains.purpose.name(),
        gains.evaluations,
        gains.drops,
        gains.law.since,
        gains.modelled(),
        1e3 * gains.latency_s,
        if gains.stopped { ", stopped" } else { "" }
    );
    let mut parameters = Grid::new("Parameters", ["parameter", "default", "found"]);
    let defaults = Parameters::default();
    for name in names() {
        let value = |p: &Parameters| p.get(name).map_or_else(String::new, |x| format!("{x:.4}"));
        parameters.row(name, [value(&defaults), value(&gains.parameters)]);
    }
    let unseen = format!("{} unseen drops", gains.unseen);
    let mut drops = Grid::new(&unseen, ["mean of", "default", "found", "ratio"]);
    let all = |of: &Measures| measures(of).chain(shares(of)).collect::<Vec<_>>();
    for ((name, unit, digits, d), (.., f)) in all(&gains.defaults).into_iter().zip(all(&gains.found)) {
        let ratio = if unit == "%" { String::new() } else { format!("{:.3}", f / d) };
        let name = if unit.is_empty() { name.to_owned() } else { format!("{name} [{unit}]") };
        drops.row(&name, [format!("{d:.digits$}"), format!("{f:.digits$}"), ratio]);
    }
    let verdict = if gains.found.beats(&gains.defaults) { "better than" } else { "NOT better than" };
    let verdict = format!(
        "{verdict} PX4's defaults: J_TPF no worse, every drop safe, two of the other four a tenth better"
    );
    let mut passages = vec![Passage::Table(parameters), Passage::Table(drops), Passage::Said(verdict)];
    let remarks = gains.other_measure().into_iter().chain([gains.of_the_receiver()]);
    let remarks = remarks.chain(range_ends_words(&gains.range_ends));
    passages.extend(remarks.map(Passage::Remark));
    Document::of_one(format!("Gains of PX4 for {}", mission.name), done, passages)
}

/// The object of `--json`.
pub fn gains_json(mission: &Mission, gains: &Px4Gains) -> String {
    let measured = |m: &Measures| {
        let keyed = MEASURED.iter().zip(m.measured).map(|(quantity, x)| (quantity.key.to_owned(), x.into()));
        object! {
            #[serde(flatten)] quantities: keyed.collect::<serde_json::Map<_, _>>(),
            velocity_rms_m_s: m.velocity_rms_m_s,
            unsafe_share: m.unsafe_share,
            steady_share: m.steady_share,
        }
    };
    let parameters = names().filter_map(|name| Some((name.to_owned(), gains.parameters.get(name)?.into())));
    text(&object! {
        #[serde(flatten)] head: Head::of(mission),
        r#for: gains.purpose.name(),
        name: &gains.name,
        gains: parameters.collect::<serde_json::Map<_, _>>(),
        at_range_ends: RangeEndsObject::of(&gains.range_ends),
        evaluations: gains.evaluations,
        drops_per_evaluation: gains.drops,
        latency_s: gains.latency_s,
        unseen_drops: gains.unseen,
        defaults: measured(&gains.defaults),
        measured_by: gains.measured_by,
        found: measured(&gains.found),
        better: gains.found.beats(&gains.defaults),
        stopped: gains.stopped,
    })
}
