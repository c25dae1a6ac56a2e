//! What a search of gains came to: for the terminal, as JSON, as tables.

use serde::Serialize;

use super::json::{VERSION, text as json_text};
use crate::config::{Mission, Stamp};
use crate::tune::near_hover::{ADJUSTMENTS, NearHover, Ultimate};
use crate::tune::search::Tried;
use crate::tune::{Evaluation, Longitudinal, Objective, Search};

/// Table 4's gains, as files name them.
const KEYS: [&str; 7] = [
    "k_pq_per_s",
    "k_iq_per_s2",
    "k_ptheta_per_s",
    "k_pvz_per_s",
    "k_ivz_per_s2",
    "k_pvx_per_s",
    "k_ivx_per_s2",
];

/// J_TPF at which a limit is reached.
const LIMIT: f64 = 1.0;

/// Gains that were tried on the tuning's flights and on flights that it never saw.
#[derive(Clone, Debug, PartialEq)]
pub struct Contender {
    /// Name of the gains.
    pub name: String,
    /// The gains.
    pub k: Longitudinal,
    /// Worst tracking RMS of the mission's cases; infinite when a flight of the tuning diverged.
    pub rms: f64,
    /// J_TPF of the tuning's flights: worst, mean.
    pub tuning: [f64; 2],
    /// Number of the unseen flights.
    pub trials: usize,
    /// Their J_TPF: mean, standard deviation (n - 1), worst.
    pub unseen: [f64; 3],
    /// Share of them that stayed within every limit.
    pub p_safe: f64,
}

impl Contender {
    /// From the flights of the tuning and the unseen ones.
    pub fn new(name: String, k: Longitudinal, tuning: &[Evaluation], unseen: &[Evaluation]) -> Self {
        let worst = tuning.iter().copied().fold(Evaluation::PERFECT, Evaluation::worse);
        let n = unseen.len() as f64;
        let j: Vec<f64> = unseen.iter().map(|e| e.j_tpf).collect();
        let mean = j.iter().sum::<f64>() / n;
        let squares: f64 = j.iter().map(|x| (x - mean) * (x - mean)).sum();
        Self {
            name,
            k,
            rms: worst.rms,
            tuning: [worst.j_tpf, tuning.iter().map(|e| e.j_tpf).sum::<f64>() / tuning.len() as f64],
            trials: unseen.len(),
            unseen: [mean, (squares / (n - 1.0).max(1.0)).sqrt(), j.iter().copied().fold(0.0, f64::max)],
            p_safe: j.iter().filter(|x| **x <= LIMIT).count() as f64 / n,
        }
    }
}

/// A search and its result.
#[derive(Clone, Debug)]
pub struct TuneRun {
    /// Name of the method.
    pub method: String,
    /// Name of the objective.
    pub objective: String,
    /// Name of the plant.
    pub model: String,
    /// Whether the flights were varied.
    pub robust: bool,
    /// Name of the gains that the search began at; "none" for a swarm of its own.
    pub start: String,
    /// Amplitudes of the swing in the tuning's flights, in standard deviations.
    pub swing: Vec<f64>,
    /// The objective, with its bounds.
    pub bounds: Objective,
    /// The gains found.
    pub gains: Tried,
    /// Flights that a candidate is judged by.
    pub flights: usize,
    /// Evaluations that were made now, not read from a checkpoint.
    pub fresh_evaluations: usize,
    /// Whether Ctrl-C ended it.
    pub stopped: bool,
    /// Wall time [s].
    pub wall_s: f64,
    /// The gains found, last, and others.
    pub contenders: Vec<Contender>,
}

impl TuneRun {
    fn cost(&self) -> f64 {
        self.bounds.cost(&self.gains.evaluation)
    }
}

/// Where the gains come from, for their file.
pub fn about(mission: &Mission, search: &Search, run: &TuneRun) -> String {
    let e = run.gains.evaluation;
    let bound = match run.bounds {
        Objective::Safety { rms_bound } => format!(" (tracking RMS at most {rms_bound:.4})"),
        Objective::Rms | Objective::JTpf => String::new(),
    };
    format!(
        "samara {VERSION} tune: mission {}, objective {}{bound}, {} plant{}, swing {:?}, method {} from {}, seed {}, {} evaluations of \
         {} flights; worst tracking RMS {:.4}, worst J_TPF {:.4}. Inputs sha256 {}. The yaw gains are the mission's.",
        mission.name,
        run.objective,
        run.model,
        if run.robust { " with variations" } else { "" },
        run.swing,
        run.method,
        run.start,
        mission.seed,
        search.tried().len(),
        run.flights,
        e.rms,
        e.j_tpf,
        mission.hash_without_gains(),
    )
}

/// For the terminal.
pub fn text(mission: &Mission, search: &Search, run: &TuneRun) -> String {
    let e = run.gains.evaluation;
    let diverged = search.history().last().map_or(0, |p| p.diverged);
    let out = format!(
        "{}: {} by {}, {} plant: {} evaluations of {} flights in {:.1} s ({} diverged){}\n\
         cost {:.4}: worst tracking RMS {:.4}, worst J_TPF {:.4}{}\n\n",
        mission.name,
        run.objective,
        run.method,
        run.model,
        search.tried().len(),
        run.flights,
        run.wall_s,
        diverged,
        if run.stopped { ", stopped" } else { "" },
        run.cost(),
        e.rms,
        e.j_tpf,
        if run.bounds.allows(&e) { "" } else { ": THE BOUNDS DO NOT HOLD" },
    );
    out + &contest(&run.contenders)
}

/// Gains, and how they do on the flights of the tuning and on unseen ones.
fn contest(contenders: &[Contender]) -> String {
    let mut out = gains_table(&contenders.iter().map(|c| (c.name.as_str(), c.k)).collect::<Vec<_>>());
    out += &format!(
        "\n{:<14} {:>8} {:>17} {:>26} {:>7}\n{:<14} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>7}\n",
        "",
        "tracking",
        "J_TPF, tuning",
        format!("J_TPF, {} unseen flights", contenders.first().map_or(0, |c| c.trials)),
        "within",
        "gains",
        "RMS",
        "worst",
        "mean",
        "worst",
        "mean",
        "std",
        "limits",
    );
    for c in contenders {
        out += &format!(
            "{:<14} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>6.1}%\n",
            c.name,
            fixed(c.rms),
            fixed(c.tuning[0]),
            fixed(c.tuning[1]),
            fixed(c.unseen[2]),
            fixed(c.unseen[0]),
            fixed(c.unseen[1]),
            100.0 * c.p_safe,
        );
    }
    if let Some(best) = contenders.iter().min_by(|a, b| a.unseen[2].total_cmp(&b.unseen[2])) {
        out += &format!("\nlowest worst J_TPF on the unseen flights: {}\n", best.name);
    }
    out
}

/// Gains side by side, one set a row.
fn gains_table(sets: &[(&str, Longitudinal)]) -> String {
    let mut out = format!("{:<14}", "gains");
    for key in ["K_pq", "K_iq", "K_ptheta", "K_pvz", "K_ivz", "K_pvx", "K_ivx"] {
        out += &format!(" {key:>8}");
    }
    for (name, k) in sets {
        out += &format!("\n{name:<14}");
        for x in k {
            out += &format!(" {x:>8.4}");
        }
    }
    out + "\n"
}

fn fixed(x: f64) -> String {
    if x.is_finite() { format!("{x:.4}") } else { "lost".to_owned() }
}

/// Gains by name.
fn named(k: &Longitudinal) -> serde_json::Value {
    KEYS.iter()
        .zip(k)
        .map(|(key, x)| ((*key).to_owned(), serde_json::Value::from(*x)))
        .collect::<serde_json::Map<_, _>>()
        .into()
}

#[derive(Serialize)]
struct ContenderObject<'a> {
    name: &'a str,
    gains: serde_json::Value,
    rms: f64,
    tuning_j_tpf_worst: f64,
    tuning_j_tpf_mean: f64,
    unseen_trials: usize,
    unseen_j_tpf_mean: f64,
    unseen_j_tpf_std: f64,
    unseen_j_tpf_worst: f64,
    unseen_p_safe: f64,
}

#[derive(Serialize)]
struct TuneObject<'a> {
    mission: &'a str,
    version: &'static str,
    seed: u64,
    input_hash: String,
    method: &'a str,
    objective: &'a str,
    model: &'a str,
    robust: bool,
    gains: serde_json::Value,
    cost: f64,
    rms: f64,
    j_tpf: f64,
    allowed: bool,
    evaluations: usize,
    diverged: usize,
    iterations: usize,
    flights_per_evaluation: usize,
    stopped: bool,
    wall_s: f64,
    evaluations_per_s: f64,
    contenders: Vec<ContenderObject<'a>>,
}

fn contender(c: &Contender) -> ContenderObject<'_> {
    ContenderObject {
        name: &c.name,
        gains: named(&c.k),
        rms: c.rms,
        tuning_j_tpf_worst: c.tuning[0],
        tuning_j_tpf_mean: c.tuning[1],
        unseen_trials: c.trials,
        unseen_j_tpf_mean: c.unseen[0],
        unseen_j_tpf_std: c.unseen[1],
        unseen_j_tpf_worst: c.unseen[2],
        unseen_p_safe: c.p_safe,
    }
}

/// The object of `samara tune --json`.
pub fn json(mission: &Mission, search: &Search, run: &TuneRun) -> String {
    let e = run.gains.evaluation;
    json_text(&TuneObject {
        mission: &mission.name,
        version: VERSION,
        seed: mission.seed,
        input_hash: mission.hash_without_gains(),
        method: &run.method,
        objective: &run.objective,
        model: &run.model,
        robust: run.robust,
        gains: named(&run.gains.k),
        cost: run.cost(),
        rms: e.rms,
        j_tpf: e.j_tpf,
        allowed: run.bounds.allows(&e),
        evaluations: search.tried().len(),
        diverged: search.history().last().map_or(0, |p| p.diverged),
        iterations: search.history().len(),
        flights_per_evaluation: run.flights,
        stopped: run.stopped,
        wall_s: run.wall_s,
        evaluations_per_s: run.fresh_evaluations as f64 / run.wall_s,
        contenders: run.contenders.iter().map(contender).collect(),
    })
}

fn stamp(mission: &Mission) -> String {
    Stamp { seed: mission.seed, input_hash: mission.hash_without_gains() }.csv_comment()
}

/// A number, empty when it is not finite.
fn cell(x: f64) -> String {
    if x.is_finite() { format!("{x:?}") } else { String::new() }
}

/// The search, iteration by iteration.
pub fn convergence_csv(mission: &Mission, search: &Search) -> String {
    let mut out = stamp(mission) + "iteration,objective,evaluations,diverged,median_cost,cost,rms,j_tpf\n";
    for (i, p) in search.history().iter().enumerate() {
        let costs = [p.median_cost, p.cost, p.best.rms, p.best.j_tpf].map(cell).join(",");
        out += &format!("{i},{},{},{},{costs}\n", p.objective, p.evaluations, p.diverged);
    }
    out
}

/// What nothing that was tried beats in both tracking and safety.
pub fn front_csv(mission: &Mission, search: &Search) -> String {
    let mut out = stamp(mission) + "rms,j_tpf," + &KEYS.join(",") + "\n";
    for t in search.front() {
        let numbers: Vec<String> =
            [t.evaluation.rms, t.evaluation.j_tpf].iter().chain(&t.k).map(|x| format!("{x:?}")).collect();
        out += &(numbers.join(",") + "\n");
    }
    out
}

/// Where near-hover gains come from, for their file.
pub fn near_hover_about(mission: &Mission) -> String {
    format!(
        "samara {VERSION} tune: mission {}, Ziegler and Nichols on the loops near hover, actuators modelled, then {}. Inputs sha256 {}. \
         The yaw gains are the mission's.",
        mission.name,
        ADJUSTMENTS.join("; "),
        mission.hash_without_gains(),
    )
}

/// The experiments and their gains, for the terminal.
pub fn near_hover_text(mission: &Mission, found: &NearHover, contenders: &[Contender]) -> String {
    let mut out = format!("{}: Ziegler and Nichols near hover, actuators modelled\n\n", mission.name);
    out += &format!("{:<20} {:>14} {:>14}\n", "loop", "ultimate gain", "period");
    for l in &found.loops {
        out += &format!("{:<20} {:>10.4} 1/s {:>12.3} s\n", l.name, l.gain_per_s, l.period_s);
    }
    out += "\nby the rules: P 0.5 K_u; PI 0.45 K_u and 0.54 K_u/T_u. Then, by hand:\n";
    for step in ADJUSTMENTS {
        out += &format!("- {step}\n");
    }
    out += &("\n".to_owned()
        + &gains_table(&[("by the rules", found.by_the_rules), ("adjusted", found.adjusted)]));
    out + "\n" + &contest(contenders)
}

#[derive(Serialize)]
struct LoopObject {
    name: &'static str,
    relay: f64,
    amplitude: f64,
    ultimate_gain_per_s: f64,
    ultimate_period_s: f64,
}

#[derive(Serialize)]
struct NearHoverObject<'a> {
    mission: &'a str,
    version: &'static str,
    input_hash: String,
    method: &'static str,
    loops: Vec<LoopObject>,
    by_the_rules: serde_json::Value,
    gains: serde_json::Value,
    wall_s: f64,
    contenders: Vec<ContenderObject<'a>>,
}

/// The object of `samara tune --method near-hover --json`.
pub fn near_hover_json(
    mission: &Mission,
    found: &NearHover,
    contenders: &[Contender],
    wall_s: f64,
) -> String {
    let row = |l: &Ultimate| LoopObject {
        name: l.name,
        relay: l.relay,
        amplitude: l.amplitude,
        ultimate_gain_per_s: l.gain_per_s,
        ultimate_period_s: l.period_s,
    };
    json_text(&NearHoverObject {
        mission: &mission.name,
        version: VERSION,
        input_hash: mission.hash_without_gains(),
        method: "near-hover",
        loops: found.loops.iter().map(row).collect(),
        by_the_rules: named(&found.by_the_rules),
        gains: named(&found.adjusted),
        wall_s,
        contenders: contenders.iter().map(contender).collect(),
    })
}
