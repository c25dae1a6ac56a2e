//! The result of a search of designs, as text, JSON and CSV.

use serde::Serialize;

use super::columns::{columns, short};
use super::figure::{Distribution, FigureError, distribution_figure, j_tpf};
use super::json::{VERSION, object, text as json_text};
use super::range_ends::{range_ends_json, range_ends_words};
use super::rows::{Columns, Shared};
use super::tune::records::stamp;
use super::tune::{Standing, gains_table, named};
use samara_core::assess::outcome::{J_TPF, STEADY_AFTER};
use samara_core::assess::{ChosenAmong, LEAST_DIFFERENCE};
use samara_core::control::Gains;
use samara_core::design::{
    CONDITIONS, Design, DesignJudge, DesignObjective, DesignSearch, DesignSearchSettings, DesignSpace,
    Finalist, FreshResults, Generation, Judgement, LOOPS, LoopsAt, Margins, TriedDesign, Unknown,
    WEIGHT_GROUPS, best_finalist,
};
use samara_core::plan::InputReference;
use samara_core::tune::RangeEnds;
use samara_core::units::DEG_PER_RAD;
use samara_mission::Mission;
use samara_study::designing::{JudgedDesign, OWN};

/// A search of designs and its result.
#[derive(Clone, Debug)]
pub struct DesignRun {
    /// Name of the gains found.
    pub name: String,
    /// What was made small.
    pub objective: DesignObjective,
    /// Flights that judged each design.
    pub flights: usize,
    /// The design that was chosen: the mission's own, where what was found is the same.
    pub chosen: TriedDesign,
    /// The mission's own design.
    pub own: Design,
    /// Space of the search.
    space: DesignSpace,
    /// Whether it keeps every bound on the search's flights.
    pub allowed: bool,
    /// The finalists, best of the search first; none when the search was interrupted.
    pub finalists: Vec<Finalist>,
    /// The mission's own design, where it has a plan, and the chosen one, where it is another; none when
    /// interrupted.
    pub judged: Vec<JudgedDesign>,
    /// Other missions' designs.
    pub others: Vec<JudgedDesign>,
    /// The loops of the chosen design at the release, the plan's peak and the target.
    pub loops: Vec<LoopsAt>,
    /// Whether the search was stopped before its budget was used up.
    pub stopped: bool,
    /// Wall time [s].
    pub wall_s: f64,
}

/// What was found with the mission's own design in its place, where they are the same but for what arithmetic
/// leaves.
fn or_own(found: TriedDesign, own: &Design) -> TriedDesign {
    let design = if found.design.is_same_as(own) { *own } else { found.design };
    TriedDesign { design, ..found }
}

/// Quantile that is shown.
const SHOWN: f64 = 0.99;

impl DesignRun {
    /// The best design of a search so far, not judged on any other flights; `None` when not one has a plan.
    pub fn of(name: &str, judge: &DesignJudge<'_>, search: &DesignSearch) -> Option<Self> {
        let (objective, bounds) = judge.objective();
        let DesignSearchSettings { own, space, .. } = search.settings();
        let best = or_own(search.best()?, own);
        Some(Self {
            name: name.to_owned(),
            objective,
            flights: judge.count(),
            chosen: best,
            own: *own,
            space: space.clone(),
            allowed: best.judgement.is_allowed(&bounds),
            finalists: Vec::new(),
            judged: Vec::new(),
            others: Vec::new(),
            loops: Vec::new(),
            stopped: false,
            wall_s: 0.0,
        })
    }

    /// Chooses the best of the finalists, and whether there are any.
    pub fn choose(&mut self, finalists: Vec<Finalist>, judge: &DesignJudge<'_>) -> bool {
        self.finalists = finalists;
        let (objective, bounds) = judge.objective();
        let best = best_finalist(&self.finalists, objective, &bounds);
        if let Some(chosen) = best {
            self.chosen = or_own(chosen, &self.own);
            self.allowed = chosen.judgement.is_allowed(&bounds);
        }
        best.is_some()
    }

    /// The gains that were chosen, with the mission's own yaw gains.
    pub fn gains(&self, mission: &Mission) -> Gains {
        let yaw = &mission.control.gains;
        Gains { k_ppsi: yaw.k_ppsi, k_pr: yaw.k_pr, ..Gains::longitudinal(self.chosen.design.gains) }
    }

    /// The number that decides, on the fresh flights with everything unknown and turbulence.
    fn number(&self, judged: &JudgedDesign) -> f64 {
        let Some(results) = judged.fresh.last() else { return f64::NAN };
        match self.objective {
            DesignObjective::Quantile(p) => results.quantile(p),
            DesignObjective::Worst => results.of_quantity(&J_TPF).max(),
        }
    }

    /// The mission's own design on fresh flights, where it has a plan, and the chosen one.
    fn own_and_chosen(&self) -> Option<(Option<&JudgedDesign>, &JudgedDesign)> {
        let chosen = self.judged.iter().find(|judged| judged.name == self.name);
        match (chosen, self.judged.first()) {
            (Some(chosen), Some(first)) => Some(((first.name != self.name).then_some(first), chosen)),
            // The mission's own is the one that was chosen.
            (None, Some(own)) => Some((Some(own), own)),
            _ => None,
        }
    }

    /// Whether the design keeps all bounds and is better than the mission's own on fresh flights.
    pub fn is_better(&self) -> bool {
        self.standing() == Standing::Better
    }

    /// How the design stands beside the mission's own: better where it keeps all bounds and, on fresh flights
    /// with everything unknown and turbulence, is so by a margin ([`FreshResults::is_better_than`]), or where
    /// the mission's own has no plan.
    pub fn standing(&self) -> Standing {
        if self.chosen.design == self.own {
            return Standing::Same;
        }
        let better = self.own_and_chosen().is_some_and(|(own, chosen)| {
            own.is_none_or(|own| match (chosen.fresh.last(), own.fresh.last()) {
                (Some(chosen), Some(own)) => chosen.is_better_than(own, self.objective),
                _ => false,
            })
        });
        if self.allowed && better { Standing::Better } else { Standing::NotBetter }
    }

    /// Which numbers of the design stand at an end of their range.
    pub fn range_ends(&self) -> RangeEnds {
        self.space.range_ends(&self.chosen.design)
    }

    /// The answer in a sentence.
    pub fn verdict(&self) -> String {
        let Some((own, chosen)) = self.own_and_chosen() else {
            return "stopped: not judged on fresh flights; --resume goes on".to_owned();
        };
        let (number, what) = (self.number(chosen), self.objective.name());
        let Some(own) = own else {
            return format!(
                "{} has a {what} of {number:.4} in turbulence; the mission's own plan is none",
                chosen.name
            );
        };
        if std::ptr::eq(own, chosen) {
            let bounds = if self.allowed { "keeps every bound" } else { "breaks a bound or passes a limit" };
            return format!(
                "the mission's own design stands, nothing changes: {what} of J_TPF in turbulence {number:.4}; it {bounds} in the \
                 search's flights"
            );
        }
        let against = format!("{what} of J_TPF in turbulence {number:.4} against {:.4}", self.number(own));
        match (self.allowed, self.is_better()) {
            (false, _) => {
                format!(
                    "{} breaks a bound or passes a limit in the search's flights ({against})",
                    chosen.name
                )
            }
            (true, true) => format!("{} is better than {} ({against})", chosen.name, own.name),
            (true, false) if self.number(chosen) < self.number(own) => format!(
                "{} is not better than {} ({against}: less than {} % apart, or no more than chance): keep it",
                chosen.name,
                own.name,
                100.0 * LEAST_DIFFERENCE
            ),
            (true, false) => {
                format!("{} is not better than {} ({against}): keep it", chosen.name, own.name)
            }
        }
    }
}

fn reference(reference: InputReference) -> &'static str {
    match reference {
        InputReference::Zero => "zero",
        InputReference::Trim => "trim",
    }
}

/// The design as a line of a table: factors on the mission's weights, reference, nodes, what else is asked
/// for.
fn plan_cells(design: &Design) -> Vec<String> {
    let plan = &design.plan;
    let mut cells: Vec<String> = plan.weights.iter().map(|x| short(*x, 4)).collect();
    cells.push(short(plan.final_weight, 4));
    cells.push(short(plan.input_weight, 4));
    cells.push(reference(plan.input_reference).to_owned());
    cells.push(plan.nodes.to_string());
    cells.push(if plan.peak_weight > 0.0 { short(plan.peak_weight, 4) } else { "-".to_owned() });
    let in_deg = |x: Option<f64>| x.map_or_else(|| "-".to_owned(), |x| short(x * DEG_PER_RAD, 4));
    cells.extend([plan.pitch_rad, plan.pitch_rate_rad_s].map(in_deg));
    cells.push(if design.feed_forward { "yes" } else { "no" }.to_owned());
    cells
}

fn number(x: f64) -> String {
    if x.is_finite() { format!("{x:.4}") } else { "-".to_owned() }
}

/// The search, the design and its fresh flights for the terminal.
pub fn text(mission: &Mission, search: &DesignSearch, run: &DesignRun) -> String {
    let last = search.history().last();
    let (unplanned, flights) = last.map_or((0, 0.0), |g| (g.unplanned, g.flights));
    let judgement = &run.chosen.judgement;
    let mut out = format!(
        "{}: {} of J_TPF made small over {} numbers and choices: {} designs, {flights:.0} of {} flights each, in {:.1} s ({unplanned} \
         without a plan){}\n\
         on the search's flights: {} {}, mean {}, worst {}, {:.0} over a limit; release cases steady after {:.1} s, {:.1} m lost, tilt {:.1} \
         deg, {:.0} J of the plan; loops at the target {:.2} from instability{}\n\n",
        mission.name,
        run.objective.name(),
        search.settings().space.searched(),
        search.tried().len(),
        run.flights,
        run.wall_s,
        if run.stopped { ", stopped" } else { "" },
        run.objective.name(),
        number(judgement.j_tpf),
        number(judgement.mean),
        number(judgement.worst),
        judgement.over_limit,
        judgement.most[0],
        judgement.most[1],
        judgement.most[2],
        judgement.energy_j,
        judgement.modulus,
        if run.allowed { "" } else { ": A BOUND DOES NOT HOLD" },
    );
    const PLAN: [usize; 13] = [14, 9, 8, 8, 8, 8, 8, 6, 6, 6, 6, 7, 6];
    let heads = [
        "plan", "attitude", "v_horiz", "v_down", "rates", "final", "input", "ref", "nodes", "peak", "pitch",
        "deg/s", "ahead",
    ];
    out += &columns(&PLAN, heads);
    let own = (OWN.to_owned(), search.settings().own);
    let shown = [own, (run.name.clone(), run.chosen.design)];
    for (name, design) in &shown {
        out += &columns(&PLAN, std::iter::once(name.clone()).chain(plan_cells(design)));
    }
    out += "(factors on the mission's own weights; reference of the input; weight of the peak and bounds, - for none; feed-forward)\n\n";
    let sets: Vec<_> = shown.iter().map(|(name, design)| (name.as_str(), design.gains)).collect();
    out += &gains_table(&sets);
    let ends = range_ends_words(&run.range_ends()).map_or_else(String::new, |words| words + "\n");
    out + "\n" + &loops_text(run) + &finalists_text(run) + &fresh_text(run) + &ends
}

fn loops_text(run: &DesignRun) -> String {
    const WIDTHS: [usize; 9] = [15, 12, 8, 9, 9, 9, 9, 9, 8];
    let heads = ["loop", "at", "stable", "gain up", "gain down", "phase deg", "delay ms", "rad/s", "modulus"];
    let mut out = columns(&WIDTHS, heads);
    for (i, (name, _)) in LOOPS.iter().enumerate() {
        for at in &run.loops {
            let Some((_, margins)) = at.loops.get(i) else { continue };
            let or_any = |x: Option<f64>, digits: usize| {
                x.map_or_else(|| "any".to_owned(), |x| format!("{x:.digits$}"))
            };
            let cells = [
                at.name.to_owned(),
                if margins.stable { "yes" } else { "NO" }.to_owned(),
                or_any(margins.gain_up, 2),
                or_any(margins.gain_down, 3),
                or_any(margins.phase_deg, 1),
                or_any(margins.delay_s.map(|s| 1e3 * s), 0),
                or_any(margins.crossover_rad_s, 2),
                format!("{:.3}", margins.modulus),
            ];
            out += &columns(&WIDTHS, std::iter::once((*name).to_owned()).chain(cells));
        }
    }
    out + "(gain: factors to the limit of stability; delay beyond the control period's own; each loop broken while the others are closed)\n\n"
}

fn margins_json((name, cut): (&str, &str), at: &str, margins: &Margins) -> impl Serialize {
    object! {
        r#loop: name,
        broken_at: cut,
        state: at,
        stable: margins.stable,
        gain_up: margins.gain_up,
        gain_down: margins.gain_down,
        phase_deg: margins.phase_deg,
        delay_s: margins.delay_s,
        crossover_rad_s: margins.crossover_rad_s,
        modulus: margins.modulus,
    }
}

fn finalists_text(run: &DesignRun) -> String {
    if run.finalists.is_empty() {
        return String::new();
    }
    const WIDTHS: [usize; 7] = [14, 9, 9, 9, 9, 9, 10];
    let among = ChosenAmong::new(run.finalists.len() as u64);
    let trials = run.finalists[0].results.of_quantity(&J_TPF).count();
    let mut out = format!(
        "finalists on {trials} flights that the search did not have; bounds at 95 % with the correction for choosing among {}\n",
        among.count()
    );
    out += &columns(&WIDTHS, ["finalist", "searched", "mean", "p99", "at most", "worst", "unsafe <"]);
    for (i, finalist) in run.finalists.iter().enumerate() {
        let results = &finalist.results;
        let chosen = finalist.tried == run.chosen;
        let name = format!("{}{}", i + 1, if chosen { " (chosen)" } else { "" });
        let cells = [
            number(finalist.tried.judgement.j_tpf),
            number(results.of_quantity(&J_TPF).mean()),
            number(results.quantile(SHOWN)),
            number(results.quantile_at_most(SHOWN, among).unwrap_or(f64::NAN)),
            number(results.of_quantity(&J_TPF).max()),
            format!("{:.1e}", results.unsafe_at_most(among)),
        ];
        out += &columns(&WIDTHS, std::iter::once(name).chain(cells));
    }
    out + "\n"
}

fn fresh_text(run: &DesignRun) -> String {
    let Some(first) = run.judged.first() else { return String::new() };
    let name = run.judged.iter().chain(&run.others).map(|judged| judged.name.len()).max().unwrap_or(0);
    let widths = [name.max(13) + 1, 11, 8, 8, 8, 8, 7, 9, 9, 9, 9];
    let trials = first.fresh.first().map_or(0, |results| results.of_quantity(&J_TPF).count());
    let mut out = format!("on {trials} fresh flights each, which chose nothing; bounds at 95 %\n");
    let heads = [
        "design", "air", "mean", "p99", "at most", "worst", "unsafe", "at most", "unsteady", "end m/s",
        "steady s",
    ];
    out += &columns(&widths, heads);
    for judged in run.judged.iter().chain(&run.others) {
        for ((air, _), results) in CONDITIONS.iter().zip(&judged.fresh) {
            let cells = [
                (*air).to_owned(),
                number(results.of_quantity(&J_TPF).mean()),
                number(results.quantile(SHOWN)),
                number(results.quantile_at_most(SHOWN, ChosenAmong::ONE).unwrap_or(f64::NAN)),
                number(results.of_quantity(&J_TPF).max()),
                results.safe.misses().to_string(),
                format!("{:.1e}", results.unsafe_at_most(ChosenAmong::ONE)),
                (results.of_quantity(&J_TPF).count() - results.of_quantity(&STEADY_AFTER).count())
                    .to_string(),
                number(results.end_error_m_s.max()),
                format!("{:.1}", results.of_quantity(&STEADY_AFTER).max()),
            ];
            out += &columns(&widths, std::iter::once(judged.name.clone()).chain(cells));
        }
    }
    out + "(turbulence comes on top of the unknowns; steady: the latest of those that are steady at the end)\n\n"
}

/// The figure of the fresh flights, `design.svg`: the distributions of their J_TPF.
///
/// # Errors
/// [`FigureError`] when nothing was judged on fresh flights, or the backend fails.
pub fn figure(mission: &Mission, run: &DesignRun) -> Result<String, FigureError> {
    let title = format!("{}: J_TPF of fresh flights", mission.name);
    let remark = "Share of the flights that stay at or below a value. Unknowns: mass, inertia, air loads, density, wind, delays; turbulence on \
                  top of them.";
    distribution_figure(&stamp(mission), &title, remark, &distributions(mission, run))
}

/// The distributions of J_TPF of the fresh flights, a panel for each condition; the mission's own design goes
/// by the mission's name.
fn distributions(mission: &Mission, run: &DesignRun) -> Vec<Distribution> {
    let panel = |(i, (air, _)): (usize, &(&str, Unknown))| Distribution {
        name: format!("{}, {}", j_tpf(), air.replace('_', " ")),
        limit: Some(mission.limits.j_tpf_below),
        controllers: run
            .judged
            .iter()
            .chain(&run.others)
            .filter_map(|judged| {
                let ascending = judged.fresh.get(i)?.ascending();
                let name = if judged.name == OWN { &mission.name } else { &judged.name };
                Some((name.clone(), thinned(ascending), SHOWN_FLIGHTS.min(ascending.len())))
            })
            .collect(),
    };
    CONDITIONS.iter().enumerate().map(panel).collect()
}

/// Flights of a distribution that a figure draws.
const SHOWN_FLIGHTS: usize = 400;

/// Some of the values, evenly spread over their ranks, the least and the greatest among them.
fn thinned(ascending: &[f64]) -> Vec<f64> {
    let n = ascending.len();
    if n <= SHOWN_FLIGHTS {
        return ascending.to_vec();
    }
    (0..SHOWN_FLIGHTS).map(|i| ascending[i * (n - 1) / (SHOWN_FLIGHTS - 1)]).collect()
}

fn design_json(mission: &Mission, design: &Design) -> impl Serialize {
    let plan = &design.plan;
    let mut problem = mission.plan_problem();
    plan.apply(&mut problem, &mission.limits.safety);
    let factors: serde_json::Map<_, _> = WEIGHT_GROUPS
        .iter()
        .zip(plan.weights)
        .map(|((name, _), x)| ((*name).to_owned(), serde_json::Value::from(x)))
        .collect();
    object! {
        weight_factors: factors,
        final_weight_factor: plan.final_weight,
        input_weight_factor: plan.input_weight,
        cost_state: problem.cost_state,
        cost_input_per_n2: problem.cost_input,
        cost_input_reference: reference(plan.input_reference),
        nodes: plan.nodes,
        peak_weight: plan.peak_weight,
        pitch_deg: plan.pitch_rad.map(|x| x * DEG_PER_RAD),
        pitch_rate_deg_s: plan.pitch_rate_rad_s.map(|x| x * DEG_PER_RAD),
        feed_forward: design.feed_forward,
        gains: named(&design.gains),
    }
}

fn judgement_json(judgement: &Judgement) -> impl Serialize {
    let [steady_after_s, altitude_lost_m, tilt_deg] = judgement.most;
    object! {
        j_tpf: judgement.j_tpf,
        j_tpf_mean: judgement.mean,
        j_tpf_worst: judgement.worst,
        over_limit_flights: judgement.over_limit,
        unrest: judgement.unrest,
        steady_after_s: steady_after_s,
        altitude_lost_m: altitude_lost_m,
        tilt_deg: tilt_deg,
        energy_j: judgement.energy_j,
        modulus: judgement.modulus,
        flights: judgement.flights,
    }
}

fn results_json(results: &FreshResults, among: ChosenAmong) -> impl Serialize {
    object! {
        flights: results.of_quantity(&J_TPF).count(),
        j_tpf_mean: results.of_quantity(&J_TPF).mean(),
        j_tpf_p99: results.quantile(SHOWN),
        j_tpf_p99_at_most: results.quantile_at_most(SHOWN, among),
        j_tpf_worst: results.of_quantity(&J_TPF).max(),
        over_limit_flights: results.over_limit,
        unsafe_flights: results.safe.misses(),
        lost_flights: results.lost,
        p_unsafe_at_most: results.unsafe_at_most(among),
        confidence: samara_core::assess::CONFIDENCE,
        chosen_among: among.count(),
        end_error_m_s_max: results.end_error_m_s.max(),
        steady_flights: results.of_quantity(&STEADY_AFTER).count(),
        steady_after_s_max: results.of_quantity(&STEADY_AFTER).max(),
    }
}

/// The object of `design.json`: what was searched, what was chosen, and how it was judged. With the wall time
/// it is that of `samara design --json`.
pub fn json(mission: &Mission, search: &DesignSearch, run: &DesignRun, wall_s: Option<f64>) -> String {
    let settings = search.settings();
    let among = ChosenAmong::new(run.finalists.len() as u64);
    let finalists: Vec<_> = run
        .finalists
        .iter()
        .map(|finalist| {
            object! {
                design: design_json(mission, &finalist.tried.design),
                searched: judgement_json(&finalist.tried.judgement),
                results: results_json(&finalist.results, among),
            }
        })
        .collect();
    let judged: Vec<_> = run
        .judged
        .iter()
        .chain(&run.others)
        .flat_map(|judged| {
            CONDITIONS.iter().zip(&judged.fresh).map(move |(air, results)| (judged, air.0, results))
        })
        .map(|(judged, air, results)| {
            object! { design: &judged.name, air: air, results: results_json(results, ChosenAmong::ONE) }
        })
        .collect();
    let margins: Vec<_> = run
        .loops
        .iter()
        .flat_map(|at| LOOPS.iter().zip(&at.loops).map(move |(of, (_, margins))| (*of, at.name, margins)))
        .map(|(of, at, margins)| margins_json(of, at, margins))
        .collect();
    let last = search.history().last();
    json_text(&object! {
        mission: &mission.name,
        version: VERSION,
        seed: mission.seed,
        input_hash: mission.hash_without_gains(),
        objective: run.objective.name(),
        searched: settings.space.searched(),
        flights_per_design: run.flights,
        designs: search.tried().len(),
        unplanned: last.map_or(0, |g| g.unplanned),
        flights: last.map_or(0.0, |g| g.flights),
        stopped: run.stopped,
        name: &run.name,
        own: design_json(mission, &settings.own),
        design: design_json(mission, &run.chosen.design),
        judgement: judgement_json(&run.chosen.judgement),
        allowed: run.allowed,
        margins: margins,
        finalists: finalists,
        fresh: judged,
        better: run.is_better(),
        standing: run.standing().word(),
        at_range_ends: range_ends_json(&run.range_ends()),
        #[serde(flatten)]
        time: wall_s.map(|wall_s| object! { wall_s: wall_s }),
    })
}

/// Origin of the gains, for their file.
pub fn about(mission: &Mission, search: &DesignSearch, run: &DesignRun) -> String {
    format!(
        "samara {VERSION} design: mission {}, {} of J_TPF over {} flights, seed {}, {} designs; the plan that they belong to is that of \
         design_mission.json. Inputs sha256 {}. The yaw gains are the mission's.",
        mission.name,
        run.objective.name(),
        run.flights,
        mission.seed,
        search.tried().len(),
        mission.hash_without_gains(),
    )
}

/// Behind some columns those of a design and its judgement.
fn with_design<R>(columns: Columns<R>, of: impl Fn(&R) -> &TriedDesign + Copy + Shared) -> Columns<R> {
    const MOST: [&str; 3] = ["steady_after_s", "altitude_lost_m", "tilt_deg"];
    const WEIGHTS: [&str; 4] = ["attitude_weight", "horizontal_weight", "vertical_weight", "rate_weight"];
    const FACTORS: &str = "factors on the mission's weights";
    let degrees = |bound: Option<f64>| bound.map(|x| x * DEG_PER_RAD);
    columns
        .number("j_tpf", "the number that decides, of the drawn flights", move |row| of(row).judgement.j_tpf)
        .number("j_tpf_mean", "mean of the drawn flights", move |row| of(row).judgement.mean)
        .number("j_tpf_worst", "greatest of all flights", move |row| of(row).judgement.worst)
        .number("over_limit_flights", "flights over a limit", move |row| of(row).judgement.over_limit)
        .number("unrest", "worst distance from rest at the target", move |row| of(row).judgement.unrest)
        .numbers(MOST, "greatest among the release cases", move |row, i| of(row).judgement.most[i])
        .number("energy_j", "energy that the plan takes of the shafts", move |row| of(row).judgement.energy_j)
        .number("modulus", "least distance of a loop from -1", move |row| of(row).judgement.modulus)
        .numbers(WEIGHTS, FACTORS, move |row, i| of(row).design.plan.weights[i])
        .number("final_weight", FACTORS, move |row| of(row).design.plan.final_weight)
        .number("input_weight", FACTORS, move |row| of(row).design.plan.input_weight)
        .word("input_reference", "thrust that costs nothing: `zero` or `trim`", move |row| {
            Some(reference(of(row).design.plan.input_reference).to_owned())
        })
        .whole("nodes", "number of nodes", move |row| of(row).design.plan.nodes as u64)
        .number("peak_weight", "cost of a peak of J_state of 1", move |row| of(row).design.plan.peak_weight)
        .number("pitch_deg", BOUNDS, move |row| degrees(of(row).design.plan.pitch_rad))
        .number("pitch_rate_deg_s", BOUNDS, move |row| degrees(of(row).design.plan.pitch_rate_rad_s))
        .flag("feed_forward", "1: the plan's rates are fed forward", move |row| of(row).design.feed_forward)
        .numbers(Gains::LONGITUDINAL_KEYS, "the gains", move |row, i| of(row).design.gains[i])
}
const BOUNDS: &str = "bounds on the plan; empty: none";

/// The columns of `design.csv`.
pub(crate) fn convergence_columns<'a>() -> Columns<(u64, &'a Generation)> {
    let columns = Columns::<(u64, &Generation)>::none()
        .whole("generation", "number of the generation", |(i, _)| *i)
        .whole("designs", "designs so far", |(_, of)| of.tried as u64)
        .whole("unplanned", "designs so far that had no plan", |(_, of)| of.unplanned as u64)
        .number("flights", "flights so far", |(_, of)| of.flights)
        .number("median_cost", "median cost of this generation", |(_, of)| of.median_cost)
        .number("cost", "least cost so far; what follows is of that design", |(_, of)| of.best.cost);
    with_design(columns, |(_, of)| &of.best)
}

/// The columns of `design_front.csv`.
pub(crate) fn front_columns<'a>() -> Columns<(&'a str, TriedDesign)> {
    let columns = Columns::<(&str, TriedDesign)>::none()
        .word("front", "the measure beside the cost", |(name, _)| Some((*name).to_owned()))
        .number("cost", "cost of the design", |(_, tried)| tried.cost);
    with_design(columns, |(_, tried)| tried)
}

/// The search as CSV, generation by generation.
pub fn convergence_csv(mission: &Mission, search: &DesignSearch) -> String {
    convergence_columns().csv(&stamp(mission), (0..).zip(search.history()))
}

/// Fronts of the search as CSV: designs that no other beats in both cost and another measure.
pub fn front_csv(mission: &Mission, search: &DesignSearch) -> String {
    const MEASURES: [(&str, fn(&Judgement) -> f64); 4] = [
        ("steady_after", |judgement| judgement.most[0]),
        ("altitude_lost", |judgement| judgement.most[1]),
        ("tilt", |judgement| judgement.most[2]),
        ("energy", |judgement| judgement.energy_j),
    ];
    let rows = MEASURES
        .into_iter()
        .flat_map(|(name, measure)| search.front(measure).into_iter().map(move |tried| (name, tried)));
    front_columns().csv(&stamp(mission), rows)
}
