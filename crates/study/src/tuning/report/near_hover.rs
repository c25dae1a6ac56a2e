//! The experiments of Ziegler and Nichols and the gains computed from them.

use std::collections::BTreeMap;

use super::contest::Contest;
use super::records::{best, contenders, own, standing};
use super::{GainsObject, NAMES};
use samara_core::tune::near_hover::{ADJUSTMENTS, NearHover};
use samara_mission::Mission;
use samara_report::document::{Document, Grid, Passage};
use samara_report::json::{VERSION, object, text as json_text};

/// Origin of near-hover gains, for their file.
pub fn about(mission: &Mission) -> String {
    format!(
        "samara {VERSION} tune: mission {}, Ziegler and Nichols on the loops near hover, actuators modelled, then {}. Inputs sha256 {}. \
         The yaw gains are the mission's.",
        mission.name,
        ADJUSTMENTS.join("; "),
        mission.hash_without_gains(),
    )
}

/// What is said of the experiments, the gains and their reasons.
pub fn document(mission: &Mission, found: &NearHover, contest: &Contest) -> Document {
    let done = format!("{}: Ziegler and Nichols near hover, actuators modelled", mission.name);
    let mut loops = Grid::new("Experiments", ["loop", "ultimate gain", "period"]);
    for l in &found.loops {
        loops.row(l.name, [format!("{:.4} 1/s", l.gain_per_s), format!("{:.3} s", l.period_s)]);
    }
    let rules = "The rules, P 0.5 K_u; PI 0.45 K_u and 0.54 K_u/T_u, are for loops that stand alone near hover. Adjusted by hand for a cascade \
                 that begins far from it:";
    let mut adjusted = Grid::new("Adjusted", ["gain", "by the rules", "times", "adjusted"]);
    for ((name, rule), gain) in NAMES.iter().zip(found.by_the_rules).zip(found.adjusted) {
        adjusted.row(name, [format!("{rule:.4}"), format!("{:.3}", gain / rule), format!("{gain:.4}")]);
    }
    let mut passages = vec![Passage::Table(loops), Passage::Said(rules.to_owned()), Passage::Table(adjusted)];
    passages.extend(ADJUSTMENTS.iter().map(|step| Passage::Remark(format!("- {step}"))));
    passages.extend(contest.passages());
    Document::of_one(format!("Gains for {}", mission.name), done, passages)
}

/// The object of `samara tune --method near-hover --json`.
pub fn json(mission: &Mission, found: &NearHover, contest: &Contest, wall_s: Option<f64>) -> String {
    let loops = found.loops.iter().map(|l| {
        object! {
            name: l.name,
            relay: l.relay,
            amplitude: l.amplitude,
            ultimate_gain_per_s: l.gain_per_s,
            ultimate_period_s: l.period_s,
        }
    });
    json_text(&object! {
        mission: &mission.name,
        version: VERSION,
        input_hash: mission.hash_without_gains(),
        method: "near-hover",
        loops: loops.collect::<Vec<_>>(),
        by_the_rules: GainsObject::from(found.by_the_rules),
        adjustments: ADJUSTMENTS,
        gains: GainsObject::from(found.adjusted),
        #[serde(flatten)] timed: wall_s.map(|wall_s| ("wall_s", wall_s)).into_iter().collect::<BTreeMap<_, _>>(),
        contenders: contenders(Some(contest)),
        best: best(Some(contest)),
        own: own(Some(contest)),
        standing: standing(Some(contest)),
    })
}
