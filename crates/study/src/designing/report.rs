//! The result of a search of designs, as a document, as JSON and as CSV.

use std::collections::BTreeMap;

use serde_json::{Map, Value};

use crate::designing::{JudgedDesign, OWN};
use crate::range_ends::{RangeEndsObject, range_ends_words, wall};
use crate::tuning::report::records::stamp;
use crate::tuning::report::{GainsObject, Standing, gains_grid};
use samara_core::assess::outcome::{J_TPF, STEADY_AFTER};
use samara_core::assess::{ChosenAmong, LEAST_DIFFERENCE};
use samara_core::control::{ControlLimits, Gains};
use samara_core::design::{
    CONDITIONS, Design, DesignJudge, DesignObjective, DesignSearch, DesignSearchSettings, DesignSpace,
    Finalist, FreshResults, Generation, Judgement, LOOPS, LoopsAt, Margins, TriedDesign, Unknown,
    WEIGHT_GROUPS, best_finalist,
};
use samara_core::hints::No;
use samara_core::plan::InputReference;
use samara_core::tune::RangeEnds;
use samara_core::units::DEG_PER_RAD;
use samara_mission::Mission;
use samara_report::columns::short;
use samara_report::document::{Document, Grid, Passage};
use samara_report::figure::{Distribution, FigureError, distribution_figure, j_tpf};
use samara_report::json::{VERSION, finite, result_objects, text as json_text};
use samara_report::rows::{Columns, Shared};

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
    /// Wall time, where it is told [s].
    pub wall_s: Option<f64>,
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
            wall_s: None,
        })
    }

    /// Chooses the best of the finalists, and whether there are any.
    pub fn choose(&mut self, finalists: Vec<Finalist>, judge: &DesignJudge<'_>) -> bool {
        self.finalists = finalists;
        let (_, bounds) = judge.objective();
        let best = best_finalist(&self.finalists, judge);
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

    /// The noes of the answer.
    pub fn noes(&self) -> Vec<No> {
        let judged = match (self.own_and_chosen(), self.allowed) {
            (None, _) => Some(No::NothingJudged),
            (_, false) => Some(No::BreaksABound),
            (_, true) => (self.standing() == Standing::NotBetter).then_some(No::NotBetter),
        };
        judged.into_iter().chain(wall(&self.range_ends())).collect()
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

/// The cascade's limits as a line of a table.
fn limit_cells(design: &Design) -> Vec<String> {
    let ControlLimits { tilt_from, tilt_rad, rate_command_rad_s, .. } = design.limits;
    let in_deg = [tilt_rad, rate_command_rad_s].map(|x| short(x * DEG_PER_RAD, 4));
    std::iter::once(tilt_from.name().to_owned()).chain(in_deg).collect()
}

fn number(x: f64) -> String {
    if x.is_finite() { format!("{x:.4}") } else { "-".to_owned() }
}

/// What is said of the search, the design and its fresh flights.
pub fn document(mission: &Mission, search: &DesignSearch, run: &DesignRun) -> Document {
    let last = search.history().last();
    let (unplanned, flights) = last.map_or((0, 0.0), |g| (g.unplanned, g.flights));
    let judgement = &run.chosen.judgement;
    let done = format!(
        "{}: {} of J_TPF made small over {} numbers and choices: {} designs, {flights:.0} of {} flights each{} ({unplanned} \
         without a plan){}\n\
         on the search's flights: {} {}, mean {}, worst {}, {:.0} over a limit; release cases steady after {:.1} s, {:.1} m lost, tilt {:.1} \
         deg, {:.0} J of the plan; loops {:.2} from instability, by a delay {:.0} ms{}",
        mission.name,
        run.objective.name(),
        search.settings().space.searched(),
        search.tried().len(),
        run.flights,
        run.wall_s.map_or_else(String::new, |wall_s| format!(", in {wall_s:.1} s")),
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
        1e3 * judgement.delay_s,
        if run.allowed { "" } else { ": A BOUND DOES NOT HOLD" },
    );
    let heads = [
        "plan", "attitude", "v_horiz", "v_down", "rates", "final", "input", "ref", "nodes", "peak", "pitch",
        "deg/s", "ahead",
    ];
    let mut plans = Grid::new("Plan", heads);
    let mut limits = Grid::new("Commands", ["commands", "tilt from", "tilt [deg]", "rate [deg/s]"]);
    let own = (OWN.to_owned(), search.settings().own);
    let shown = [own, (run.name.clone(), run.chosen.design)];
    for (name, design) in &shown {
        plans.row(name, plan_cells(design));
        limits.row(name, limit_cells(design));
    }
    let factors = "(factors on the mission's own weights; reference of the input; weight of the peak and bounds, - for none; feed-forward)";
    let sets: Vec<_> = shown.iter().map(|(name, design)| (name.as_str(), design.gains)).collect();
    let mut passages = vec![
        Passage::Table(plans),
        Passage::Remark(factors.to_owned()),
        Passage::Table(gains_grid(&sets)),
        Passage::Table(limits),
        Passage::Table(loops(run)),
        Passage::Remark("(gain: factors to the limit of stability; delay beyond the control period's own; each loop broken while the others are closed)".to_owned()),
    ];
    passages.extend(finalists(run).map(Passage::Table));
    if let Some(grid) = fresh(run) {
        passages.push(Passage::Table(grid));
        let steady = "(turbulence comes on top of the unknowns; steady: the latest of those that are steady at the end)";
        passages.push(Passage::Remark(steady.to_owned()));
    }
    passages.extend(range_ends_words(&run.range_ends()).map(Passage::Said));
    Document::of_one(format!("Design of {}", mission.name), done, passages)
}

fn loops(run: &DesignRun) -> Grid {
    let heads = ["loop", "at", "stable", "gain up", "gain down", "phase deg", "delay ms", "rad/s", "modulus"];
    let mut grid = Grid::new("Margins of the loops", heads);
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
            grid.row(name, cells);
        }
    }
    grid
}

/// The finalists on flights that the search did not have; `None` where there are none.
fn finalists(run: &DesignRun) -> Option<Grid> {
    let among = ChosenAmong::new(run.finalists.len() as u64);
    let trials = run.finalists.first()?.results.of_quantity(&J_TPF).count();
    let title = format!(
        "Finalists on {trials} flights that the search did not have; bounds at 95 % with the correction for choosing among {}",
        among.count()
    );
    let heads = ["finalist", "searched", "mean", "p99", "at most", "worst", "unsafe <"];
    let mut grid = Grid::new(&title, heads);
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
        grid.row(&name, cells);
    }
    Some(grid)
}

/// The designs on fresh flights; `None` where none were flown.
fn fresh(run: &DesignRun) -> Option<Grid> {
    let first = run.judged.first()?;
    let trials = first.fresh.first().map_or(0, |results| results.of_quantity(&J_TPF).count());
    let title = format!("On {trials} fresh flights each, which chose nothing; bounds at 95 %");
    let heads = [
        "design", "air", "mean", "p99", "at most", "worst", "unsafe", "at most", "unsteady", "end m/s",
        "steady s",
    ];
    let mut grid = Grid::new(&title, heads);
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
            grid.row(&judged.name, cells);
        }
    }
    Some(grid)
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

result_objects! {
    /// A search of plan and gains together, as `design.json` holds it: what was searched, what was
    /// chosen, and how it was judged.
    DesignObject(mission: &Mission, search: &DesignSearch, run: &DesignRun) [
        let settings = search.settings();
        let last = search.history().last();
        let in_airs = |of: &JudgedDesign| {
            let airs = CONDITIONS.iter().zip(&of.fresh);
            airs.map(|((air, _), results)| FreshObject::of(&of.name, air, results)).collect::<Vec<_>>()
        };
        let of_loops = |at: &LoopsAt| {
            let loops = LOOPS.iter().zip(&at.loops);
            loops.map(|(of, (_, margins))| MarginObject::of(*of, at.name, margins)).collect::<Vec<_>>()
        };
    ] {
        /// Name of the mission.
        mission: String = mission.name.clone(),
        /// Version of samara that made the result.
        version: String = VERSION.to_owned(),
        /// Seed of everything random.
        seed: u64 = mission.seed,
        /// SHA-256 of all inputs but for the gains, hexadecimal.
        input_hash: String = mission.hash_without_gains().to_owned(),
        /// What was made small.
        objective: String = run.objective.name().to_owned(),
        /// How many numbers and choices were searched.
        searched: usize = settings.space.searched(),
        /// Number of flights that judge a design.
        flights_per_design: usize = run.flights,
        /// Number of designs that were tried.
        designs: usize = search.tried().len(),
        /// Number of designs that have no plan.
        unplanned: usize = last.map_or(0, |g| g.unplanned),
        /// Number of flights that the search flew.
        flights: f64 = last.map_or(0.0, |g| g.flights),
        /// Whether the search was stopped before its budget was used up.
        stopped: bool = run.stopped,
        /// Name of the gains that were found.
        name: String = run.name.clone(),
        /// The mission's own design.
        own: DesignNumbers = DesignNumbers::of(mission, &settings.own),
        /// The design that was chosen.
        design: DesignNumbers = DesignNumbers::of(mission, &run.chosen.design),
        /// The chosen design on the flights of the search.
        judgement: JudgementObject = JudgementObject::of(&run.chosen.judgement),
        /// Whether the design keeps every bound on the flights of the search.
        allowed: bool = run.allowed,
        /// Margins of each loop of the chosen design at each state.
        margins: Vec<MarginObject> = run.loops.iter().flat_map(of_loops).collect(),
        /// The finalists, best of the search first.
        finalists: Vec<FinalistObject> = run.finalists.iter().map(|of| {
            FinalistObject::of(mission, of, ChosenAmong::new(run.finalists.len() as u64))
        }).collect(),
        /// Results on fresh flights, which chose nothing: designs in each air.
        fresh: Vec<FreshObject> = run.judged.iter().chain(&run.others).flat_map(in_airs).collect(),
        /// Whether the design keeps all bounds and is better than the mission's own on fresh flights.
        better: bool = run.is_better(),
        /// How the design stands beside the mission's own: `better`, `same` or `not_better`.
        standing: String = run.standing().word().to_owned(),
        /// Numbers at an end of their range; absent in results of older versions.
        at_range_ends: Option<RangeEndsObject> = Some(RangeEndsObject::of(&run.range_ends())),
        /// Wall time of the search [s]; on the terminal only.
        wall_s unless "Option::is_none": Option<f64> = run.wall_s,
    }

    /// A design: the settings of a plan and the gains that fly it.
    DesignNumbers(mission: &Mission, design: &Design) [
        let plan = &design.plan;
        let mut problem = mission.plan_problem();
        plan.apply(&mut problem, &mission.limits.safety);
        let groups = WEIGHT_GROUPS.iter().zip(plan.weights);
    ] {
        /// Factors on the mission's weights of the state, by group.
        #[schemars(with = "BTreeMap<String, f64>")]
        weight_factors: Map<String, Value>
            = groups.map(|((name, _), x)| ((*name).to_owned(), x.into())).collect(),
        /// Factor on the mission's weight of the final state.
        final_weight_factor: f64 = plan.final_weight,
        /// Factor on the mission's weight of the input.
        input_weight_factor: f64 = plan.input_weight,
        /// Weights of the state, as a mission has them.
        cost_state: Vec<f64> = problem.cost_state.to_vec(),
        /// Weight of the input [1/N^2].
        cost_input_per_n2: f64 = problem.cost_input,
        /// The thrusts from which the input is counted: `zero` or `trim`.
        cost_input_reference: String = reference(plan.input_reference).to_owned(),
        /// Number of nodes.
        nodes: usize = plan.nodes,
        /// Weight of the peak; 0: none.
        peak_weight: f64 = plan.peak_weight,
        /// Bound on the plan's pitch [deg]; null: none.
        pitch_deg: Option<f64> = plan.pitch_rad.map(|x| x * DEG_PER_RAD),
        /// Bound on the plan's pitch rate [deg/s]; null: none.
        pitch_rate_deg_s: Option<f64> = plan.pitch_rate_rad_s.map(|x| x * DEG_PER_RAD),
        /// Whether the plan's accelerations are fed forward.
        feed_forward: bool = design.feed_forward,
        /// What the tilt comes from: `gravity` or `thrust`.
        tilt_from: String = design.limits.tilt_from.name().to_owned(),
        /// Largest commanded tilt [deg].
        tilt_limit_deg: f64 = design.limits.tilt_rad * DEG_PER_RAD,
        /// Largest commanded roll and pitch rate [deg/s].
        rate_command_limit_deg_s: f64 = design.limits.rate_command_rad_s * DEG_PER_RAD,
        /// The gains.
        gains: GainsObject = design.gains.into(),
    }

    /// A design on the flights of its search.
    JudgementObject(judgement: &Judgement) [let most = judgement.most.map(finite);] {
        /// The number that decides, of the drawn flights.
        j_tpf: Option<f64> = finite(judgement.j_tpf),
        /// Mean J_TPF of the drawn flights.
        j_tpf_mean: Option<f64> = finite(judgement.mean),
        /// Greatest J_TPF of all flights.
        j_tpf_worst: Option<f64> = finite(judgement.worst),
        /// Number of flights that passed a limit or were lost.
        over_limit_flights: Option<f64> = finite(judgement.over_limit),
        /// Worst distance of a release case from rest at the target.
        unrest: Option<f64> = finite(judgement.unrest),
        /// Longest time from t = 0 to steady flight of a release case [s].
        steady_after_s: Option<f64> = most[0],
        /// Most altitude lost by a release case [m].
        altitude_lost_m: Option<f64> = most[1],
        /// Largest tilt of a release case [deg].
        tilt_deg: Option<f64> = most[2],
        /// Energy that the plan takes of the rotors' shafts [J].
        energy_j: Option<f64> = finite(judgement.energy_j),
        /// Least distance of a loop's response from -1 at the release, at the plan's peak and at the target,
        /// also with motors and thrusts that are off; negative where a loop is unstable.
        modulus: Option<f64> = finite(judgement.modulus),
        /// Least delay that takes a loop to the limit of stability [s], at the same; at most 10.
        delay_margin_s: Option<f64> = finite(judgement.delay_s),
        /// Number of flights that were flown.
        flights: Option<f64> = finite(judgement.flights),
    }

    /// Margins of a loop at a state, broken while the others are closed; null: any is stable.
    MarginObject(of: (&str, &str), at: &str, margins: &Margins) {
        /// Name of the loop.
        r#loop: String = of.0.to_owned(),
        /// Where the loop is broken.
        broken_at: String = of.1.to_owned(),
        /// Name of the state.
        state: String = at.to_owned(),
        /// Whether the loop is stable.
        stable: bool = margins.stable,
        /// Factor on the gain at which it is no longer, above one.
        gain_up: Option<f64> = margins.gain_up,
        /// Factor on the gain at which it is no longer, below one.
        gain_down: Option<f64> = margins.gain_down,
        /// Phase margin [deg].
        phase_deg: Option<f64> = margins.phase_deg,
        /// Delay margin beyond the control period's own [s].
        delay_s: Option<f64> = margins.delay_s,
        /// Frequency at which the gain crosses one [rad/s].
        crossover_rad_s: Option<f64> = margins.crossover_rad_s,
        /// Least distance of the loop's response from instability.
        modulus: f64 = margins.modulus,
    }

    /// A finalist of the search, on flights that the search did not have.
    FinalistObject(mission: &Mission, of: &Finalist, among: ChosenAmong) {
        /// The design.
        design: DesignNumbers = DesignNumbers::of(mission, &of.tried.design),
        /// The design on the flights of the search.
        searched: JudgementObject = JudgementObject::of(&of.tried.judgement),
        /// Results on the flights that chose among the finalists.
        results: FreshNumbers = FreshNumbers::of(&of.results, among),
    }

    /// A design on fresh flights in one air.
    FreshObject(name: &str, air: &str, results: &FreshResults) {
        /// Name of the design.
        design: String = name.to_owned(),
        /// Name of the air.
        air: String = air.to_owned(),
        /// The results.
        results: FreshNumbers = FreshNumbers::of(results, ChosenAmong::ONE),
    }

    /// Numbers of fresh flights.
    FreshNumbers(results: &FreshResults, among: ChosenAmong) [
        let (j_tpf, steady) = (results.of_quantity(&J_TPF), results.of_quantity(&STEADY_AFTER));
    ] {
        /// Number of flights.
        flights: u64 = j_tpf.count(),
        /// Mean J_TPF.
        j_tpf_mean: Option<f64> = finite(j_tpf.mean()),
        /// J_TPF that 99 % of the flights do not exceed.
        j_tpf_p99: Option<f64> = finite(results.quantile(SHOWN)),
        /// J_TPF that 99 % of all flights do not exceed, at most; null: too few flights tell.
        j_tpf_p99_at_most: Option<f64> = results.quantile_at_most(SHOWN, among).and_then(finite),
        /// Greatest J_TPF.
        j_tpf_worst: Option<f64> = finite(j_tpf.max()),
        /// Number of flights that passed a limit of J_state.
        over_limit_flights: u64 = results.over_limit,
        /// Number of flights that were not safe.
        unsafe_flights: u64 = results.safe.misses(),
        /// Number of flights that were lost.
        lost_flights: u64 = results.lost,
        /// Probability that a flight is not safe, at most.
        p_unsafe_at_most: f64 = results.unsafe_at_most(among),
        /// Confidence of what is at most.
        confidence: f64 = samara_core::assess::CONFIDENCE,
        /// How many designs there were to choose among by these flights.
        chosen_among: u64 = among.count(),
        /// Largest distance from the target velocity at the end [m/s].
        end_error_m_s_max: Option<f64> = finite(results.end_error_m_s.max()),
        /// Number of flights that become steady.
        steady_flights: u64 = steady.count(),
        /// Latest time from t = 0 to steady flight of those that become steady [s].
        steady_after_s_max: Option<f64> = finite(steady.max()),
    }
}

/// The object of `design.json`; with the wall time, of `samara design --json`.
pub fn json(mission: &Mission, search: &DesignSearch, run: &DesignRun) -> String {
    json_text(&DesignObject::of(mission, search, run))
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
        .number("delay_margin_s", "least delay that makes a loop unstable", move |row| {
            of(row).judgement.delay_s
        })
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
        .word("tilt_from", "what the tilt comes from: `gravity` or `thrust`", move |row| {
            Some(of(row).design.limits.tilt_from.name().to_owned())
        })
        .number("tilt_limit_deg", COMMANDED, move |row| of(row).design.limits.tilt_rad * DEG_PER_RAD)
        .number("rate_command_limit_deg_s", COMMANDED, move |row| {
            of(row).design.limits.rate_command_rad_s * DEG_PER_RAD
        })
        .numbers(Gains::LONGITUDINAL_KEYS, "the gains", move |row, i| of(row).design.gains[i])
}
const BOUNDS: &str = "bounds on the plan; empty: none";
const COMMANDED: &str = "largest that is commanded";

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

/// Name of a measure of designs, and the measure.
type DesignMeasure = (&'static str, fn(&Judgement) -> f64);

/// Fronts of the search as CSV: designs that no other beats in both cost and another measure.
pub fn front_csv(mission: &Mission, search: &DesignSearch) -> String {
    const MEASURES: [DesignMeasure; 4] = [
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
