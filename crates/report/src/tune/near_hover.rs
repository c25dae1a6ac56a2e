//! The experiments of Ziegler and Nichols and the gains computed from them.

use super::contest::Contest;
use super::records::{best, contenders, own, standing};
use super::{GainsObject, NAMES};
use crate::columns::columns;
use crate::json::{VERSION, object, text as json_text};
use samara_core::tune::near_hover::{ADJUSTMENTS, NearHover};
use samara_mission::Mission;

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

/// The experiments, the gains and their reasons, as text for the terminal.
pub fn text(mission: &Mission, found: &NearHover, contest: &Contest) -> String {
    let mut out = format!("{}: Ziegler and Nichols near hover, actuators modelled\n\n", mission.name);
    out += &columns(&[20, 14, 14], ["loop", "ultimate gain", "period"]);
    for l in &found.loops {
        let (gain, period) = (format!("{:.4} 1/s", l.gain_per_s), format!("{:.3} s", l.period_s));
        out += &columns(&[20, 14, 14], [l.name, &gain, &period]);
    }
    out += "\nThe rules, P 0.5 K_u; PI 0.45 K_u and 0.54 K_u/T_u, are for loops that stand alone near hover. Adjusted by hand for a cascade that \
            begins far from it:\n\n";
    out += &format!("{:<14} {:>12} {:>9} {:>12}\n", "gain", "by the rules", "times", "adjusted");
    for ((name, rule), adjusted) in NAMES.iter().zip(found.by_the_rules).zip(found.adjusted) {
        out +=
            &format!("{name:<14} {rule:>12.4} {:>9} {adjusted:>12.4}\n", format!("{:.3}", adjusted / rule));
    }
    out += "\n";
    for step in ADJUSTMENTS {
        out += &format!("- {step}\n");
    }
    out + "\n" + &contest.text()
}

/// The object of `samara tune --method near-hover --json`.
pub fn json(mission: &Mission, found: &NearHover, contest: &Contest, wall_s: f64) -> String {
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
        wall_s: wall_s,
        contenders: contenders(Some(contest)),
        best: best(Some(contest)),
        own: own(Some(contest)),
        standing: standing(Some(contest)),
    })
}
