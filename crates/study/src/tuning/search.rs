//! The cascade's gains as a study: a search, or Ziegler and Nichols on the vehicle's own loops instead; then
//! what was found beside others, on flights that no tuning saw.

use std::path::Path;

use samara_core::assess::tracking::control_period_s;
use samara_core::control::{ControlError, Gains};
use samara_core::hints::No;
use samara_core::params::{Purpose, export};
use samara_core::sim::PlantKind;
use samara_core::trajectory::Trajectory;
use samara_core::tune::gain_judge::Setting;
use samara_core::tune::near_hover::{NearHover, near_hover};
use samara_core::tune::{GainJudge, Longitudinal, Method, Objective, Search, SearchSettings};
use samara_mission::{ConfigError, Mission, gains_json};
use samara_report::document::Figure;
use samara_report::params::params_file;

use super::report::{Standing, TuneRun, about, near_hover as near_hover_report, records};
use super::unseen::contest;
use super::{
    DRAWS, METHODS, MODELS, NoBoundError, OBJECTIVES, Tuning, TuningMethod, TuningObjective,
    convergence_figure,
};
use crate::jobs::{Jobs, Stopped};
use crate::kind::{About, Flies, Given, Kind, Refused, Results, Slow, Study, Unfinished};
use crate::range_ends::{range_ends_words, wall};
use crate::searching;
use crate::settings;
use crate::settings::{
    Maybe, Several, Values, Word, maybe, one_of, plain_name, positive, several, switch, whole,
};

/// Help of the verb.
pub const HELP: &str = include_str!("help.txt");
/// What is written of the gains.
const GAINS: &str = "gains.json";

settings! {
    /// How gains are searched, and tried.
    pub TuneAsked {
        /// How to search: pso-cma, pso, cma-es, or near-hover, which searches nothing.
        method("METHOD"): Word<Option<TuningMethod>> = "pso-cma", method;
        /// What to make small: safety, rms, j-tpf or pareto.
        ///
        /// safety: the worst J_TPF with a bound on tracking; rms: the worst tracking RMS; j-tpf: the worst
        /// J_TPF; pareto: J_TPF at several bounds on tracking.
        objective("OBJECTIVE"): Word<TuningObjective> = "safety", one_of(&OBJECTIVES);
        /// The actuators of the flights: ideal or actuator.
        ///
        /// ideal: thrusts that follow at once, as in the paper's tuning; actuator: speed controllers, motors
        /// and rotors.
        model("MODEL"): Word<PlantKind> = "actuator", one_of(&MODELS);
        /// Largest worst tracking RMS [default: the mission's own gains'].
        ///
        /// For `safety` and `pareto`: on the tuning's flights.
        rms_bound("X"): Maybe<f64> = "default", maybe(positive);
        /// J_TPF that it costs to break a bound by as much again.
        ///
        /// For `safety` and `pareto`.
        penalty("X"): f64 = "2", positive, rare;
        /// Amplitudes of the swing, in standard deviations.
        ///
        /// For `safety` and `pareto`; twelve phases each.
        swing("A,B,.."): Several<f64, ','> = "0.8,1.6,2.4,3.2", several(positive), rare;
        /// Judge J_TPF also with a vehicle and air that are not known.
        ///
        /// Mass, inertia, drag, density, wind, delay and measurements that the controller does not know of,
        /// the air that the mission names, and releases a degree beside.
        robust(""): bool = "false", switch;
        /// Random flights with everything off at once that judge each candidate of --robust [default: 200].
        draws("N"): Maybe<usize> = "default", maybe(whole(0..=100_000));
        /// Gains to begin at: a name or a file.
        ///
        /// [default: the mission's own for cma-es, none for swarms]
        start("NAME|FILE"): Maybe<String> = "default", maybe(any);
        /// Candidates of an iteration [default: swarm 70, cma-es 16].
        particles("N"): Maybe<usize> = "default", maybe(whole(4..=10_000));
        /// Most iterations (for each of pareto's bounds).
        iterations("N"): usize = "200", whole(1..=100_000);
        /// Stop a swarm after so many iterations without a better cost.
        stall("N"): usize = "20", whole(1..=100_000), rare;
        /// Random releases that the result is tried on afterwards.
        unseen("N"): u64 = "1000", whole(1..=1_000_000);
        /// Name of the gains found.
        name("NAME"): String = "tuned", plain_name;
    }
}

fn method(text: &str) -> Result<Word<Option<TuningMethod>>, String> {
    let [a, b, c] = METHODS.map(|(word, means)| (word, Some(means)));
    one_of(&[a, b, c, ("near-hover", None)])(text)
}

#[expect(clippy::unnecessary_wraps, reason = "what reads a value may refuse it")]
fn any(text: &str) -> Result<String, String> {
    Ok(text.to_owned())
}

impl TuneAsked {
    /// The tuning that is asked for.
    pub fn tuning(&self) -> Tuning {
        let usual = Tuning::default();
        let Word { word, means } = self.method;
        Tuning {
            method: means.map_or(usual.method, |means| Word { word, means }),
            objective: self.objective,
            plant: self.model,
            rms_bound: self.rms_bound.0,
            penalty: self.penalty,
            swing: self.swing.0.clone(),
            robust: self.robust.then(|| self.draws.0.unwrap_or(DRAWS)),
            start: self.start.0.clone(),
            candidates: self.particles.0,
            iterations: self.iterations,
            stall_iterations: self.stall,
        }
    }
}

/// The gains of a mission's cascade, by search.
pub struct Tune;

/// Settings that only end a search, or come behind it.
const BEHIND: [&str; 3] = ["iterations", "unseen", "name"];

impl Kind for Tune {
    fn about(&self) -> About {
        About {
            name: "tune",
            manifest: "tune",
            title: "Search the gains of the cascade",
            help: HELP,
            unit: "candidates",
            flies: Flies::FromT0,
            settings: TuneAsked::TABLE,
            judges: Ok("the gains hold the bounds and are better than the mission's own"),
            alone: Err("gains are judged by all their flights: `samara drop --gains` flies what was found"),
            refuses: &[],
        }
    }

    fn suits(&self, _: &Mission) -> Result<(), Refused> {
        Ok(())
    }

    fn remarks(&self, mission: &Mission) -> Vec<String> {
        left_out(mission).into_iter().chain(mission.t0_remarks()).collect()
    }

    fn hangs_on(&self, mission: &Mission, values: &Values) -> Result<Vec<(&'static str, String)>, Refused> {
        let asked = TuneAsked::of(values).map_err(Refused)?;
        // A front begins each bound at the end of the one before.
        let is_front = asked.objective.means == TuningObjective::Pareto;
        let mut settings = values.in_order(TuneAsked::TABLE);
        settings.retain(|(name, _)| !BEHIND.contains(name) || (is_front && *name == "iterations"));
        if let Some(start) = &asked.start.0 {
            let mut other = mission.clone();
            other.use_gains(start).map_err(|error| Refused(format!("--start: {error}")))?;
            settings.push(("begun", format!("{:?}", other.control.gains.as_longitudinal())));
        }
        Ok(settings)
    }

    fn flies_only(&self) -> Option<&'static str> {
        Some("it searches the gains of the cascade")
    }

    fn begin<'a>(&self, given: Given<'a>, values: &Values) -> Result<Box<dyn Study + 'a>, Refused> {
        let asked = TuneAsked::of(values).map_err(Refused)?;
        if asked.draws.0.is_some() && !asked.robust {
            return Err(Refused("--draws: --robust is expected with it".to_owned()));
        }
        let (mission, plan) = (given.mission, &given.plan()?.trajectory);
        let of = (mission, plan, given.folder);
        if asked.method.means.is_some() {
            let tuned = Tuned::new(of, asked.tuning(), (&asked.name, asked.unseen));
            return Ok(Box::new(tuned.map_err(refused)?));
        }
        let tuning = asked.tuning();
        let found = near_hover(&tuning.setting(mission, plan)).map_err(Refused::by)?;
        let judge = tuning.judge(mission, plan).map_err(Refused::by)?;
        let real = real(&tuning, of).map_err(Refused::by)?;
        Ok(Box::new(ByRule { of, found, tuning, judge, real, asked }))
    }
}

/// What flights of a tuning leave out of a mission.
pub(super) fn left_out(mission: &Mission) -> Vec<String> {
    let faults = "faults: gains are searched and judged without them; `samara assess` flies motor faults";
    let faults = (!mission.faults.list.is_empty()).then_some(faults);
    let remarks = faults.into_iter().chain(mission.battery_remark());
    remarks.map(|remark| format!("{}: {remark}", mission.name)).collect()
}

/// Mission, plan, and the folder that results go to.
type Of<'a> = (&'a Mission, &'a Trajectory, Option<&'a Path>);

/// Why a search of gains was not begun.
#[derive(Debug, thiserror::Error)]
pub enum NotBegun {
    /// The vehicle cannot be controlled.
    #[error(transparent)]
    Control(#[from] ControlError),
    /// There is no bound on tracking.
    #[error(transparent)]
    NoBound(#[from] NoBoundError),
    /// The gains to begin at cannot be read.
    #[error(transparent)]
    Start(#[from] ConfigError),
}

/// What to ask for where a search was not begun.
fn refused(why: NotBegun) -> Refused {
    match why {
        NotBegun::NoBound(why) => Refused(format!(
            "{why}. Expected: --rms-bound X, other gains in the mission, or --objective rms first"
        )),
        other => Refused::by(other),
    }
}

/// A search of gains that was begun.
#[derive(Debug)]
pub struct Tuned<'a> {
    of: Of<'a>,
    tuning: Tuning,
    judge: GainJudge<'a>,
    /// The judge of what was found.
    real: GainJudge<'a>,
    settings: SearchSettings,
    objective: Objective,
    name: String,
    unseen: u64,
}

impl<'a> Tuned<'a> {
    /// Begins a search for a mission along its plan; what it finds gets this name, and is tried on so many
    /// unseen flights.
    ///
    /// # Errors
    /// [`NotBegun`] where there is no bound on tracking, or the gains to begin at cannot be read.
    pub fn new(of: Of<'a>, tuning: Tuning, (name, unseen): (&str, u64)) -> Result<Self, NotBegun> {
        let (mission, plan, _) = of;
        let (judge, real) = (tuning.judge(mission, plan)?, real(&tuning, of)?);
        let objectives = tuning.objectives(mission, &judge)?;
        let settings = tuning.search(mission, objectives)?;
        let objective = settings.objectives[settings.objectives.len() - 1];
        Ok(Self { of, tuning, judge, real, settings, objective, name: name.to_owned(), unseen })
    }

    /// Searches: the search, and the gains that it found, not tried on any other flights.
    ///
    /// # Errors
    /// [`Unfinished`] where nothing was found, or nothing is wanted of a search that was stopped.
    pub fn found(&self, jobs: &mut dyn Jobs) -> Result<(Search, TuneRun), Unfinished> {
        let (mission, plan, _) = self.of;
        let mut search = Search::new(self.settings.clone());
        let cost = |search: &Search, place: usize, k: &Longitudinal| {
            let (objective, to_beat) = search.to_beat(place)?;
            Some(self.judge.evaluate_below(k, &objective, to_beat))
        };
        let stopped = searching::search(jobs, &mut search, how, cost).is_err();
        if stopped && !jobs.wants_so_far() {
            return Err(Unfinished::Stopped);
        }
        let Some(best) = search.best(&self.objective).filter(|best| best.evaluation.is_finite()) else {
            let why = search.is_lost().then(|| self.lost(&search)).flatten();
            let why = why.unwrap_or_else(|| no_gains(stopped).to_owned());
            return Err(Unfinished::Nothing { of: "gains", why });
        };
        let run = TuneRun {
            method: self.tuning.method.to_string(),
            objective: self.tuning.objective.to_string(),
            model: self.tuning.plant.to_string(),
            robust: self.tuning.robust.is_some(),
            start: self.tuning.start_name(mission),
            swing: self.tuning.swing.clone(),
            bounds: self.objective,
            gains: best,
            range_ends: search.range_ends(&best.k),
            flights: self.judge.flights(),
            control_period_s: control_period_s(plan),
            fresh_evaluations: jobs.flown(),
            stopped,
            wall_s: None,
            contest: None,
        };
        Ok((search, run))
    }

    /// Why the search ended at its first candidates: the flight that its first one loses.
    fn lost(&self, search: &Search) -> Option<String> {
        let first = search.tried().first()?;
        let flight = self.judge.first_lost(&first.k)?;
        let (n, k) = (search.tried().len(), first.k.map(|x| format!("{x:.3}")).join(" "));
        Some(format!(
            "each of the first {n} candidates loses a flight. With the first (k = {k}), {flight}. Expected: a start \
             that flies (--start GAINS), more candidates (--particles), or a plan that can be flown"
        ))
    }
}

/// Why a search has no gains.
pub(super) fn no_gains(stopped: bool) -> &'static str {
    if stopped {
        "stopped before any gains were judged"
    } else {
        "no gains were found that fly every release"
    }
}

/// How well a search goes.
fn how(search: &Search) -> String {
    search.history().last().map_or_else(String::new, |p| {
        format!("best cost {:.4} (RMS {:.4}, J_TPF {:.4})", p.cost, p.best.rms, p.best.j_tpf)
    })
}

/// The judge of a tuning's release cases with real actuators, whatever the tuning has.
fn real<'a>(tuning: &Tuning, (mission, plan, _): Of<'a>) -> Result<GainJudge<'a>, ControlError> {
    let setting = Setting { plant: PlantKind::Actuator, ..tuning.setting(mission, plan) };
    Ok(GainJudge::new(setting)?.with_cases(&mission.study.cases))
}

/// `gains.json` and `gains.params`.
fn gains_files(
    (mission, _, folder): Of<'_>,
    (name, about, k): (&str, &str, &Longitudinal),
) -> Result<Vec<(String, String)>, Unfinished> {
    let yaw = &mission.control.gains;
    let gains = Gains { k_ppsi: yaw.k_ppsi, k_pr: yaw.k_pr, ..Gains::longitudinal(*k) };
    let text = gains_json(name, about, &gains);
    let mut with_gains = mission.clone();
    let file = folder.unwrap_or(Path::new("")).join(GAINS);
    with_gains.use_gains_text(&text, &file).map_err(|error| Unfinished::File(error.to_string()))?;
    let parameters = export(&with_gains.parameter_subject(), Purpose::Samara);
    let parameters = parameters.map_err(|error| Unfinished::File(error.to_string()))?;
    let parameters = params_file(&with_gains, &parameters);
    Ok(vec![(GAINS.to_owned(), text), ("gains.params".to_owned(), parameters)])
}

impl Study for Tuned<'_> {
    fn jobs(&self) -> u64 {
        let search = Search::new(self.settings.clone());
        let (begins, objectives) = (searching::candidates(&search), self.settings.objectives.len() as u64);
        let most = match self.settings.method {
            Method::CmaEs(cma) => cma.samples,
            Method::Swarm(swarm) => swarm.particles,
            Method::SwarmThenCmaEs { swarm, polish, .. } => swarm.particles.max(polish.samples),
        };
        begins + objectives * most as u64 * self.settings.iterations as u64
    }

    fn remarks(&self) -> Vec<String> {
        let bound = self.objective.rms_bound().filter(|_| self.tuning.rms_bound.is_none());
        let own = &self.of.0.control.gains_name;
        let remark = |bound| {
            format!("tracking RMS of at most {bound:.4}, what {own} reaches on these flights (--rms-bound)")
        };
        bound.map(remark).into_iter().collect()
    }

    fn slow(&self) -> Option<Slow<'_>> {
        let reason = self.judge.one_at_a_time()?.to_string();
        let own = self.of.0.control.gains.as_longitudinal();
        let try_some = move || {
            std::hint::black_box(self.judge.evaluate(&own));
        };
        Some(Slow { reason, flights: self.jobs(), tried: 1, try_some: Box::new(try_some) })
    }

    fn run(&self, jobs: &mut dyn Jobs) -> Result<Results, Unfinished> {
        let (mission, ..) = self.of;
        let (search, mut run) = self.found(jobs)?;
        let best = run.gains;
        if !run.stopped {
            let (of, judges) = ((mission, &self.tuning, run.robust), (&self.judge, &self.real));
            match contest(jobs, of, judges, (&self.name, &best.k), self.unseen) {
                Ok(contest) => run.contest = Some(contest),
                Err(Stopped) if jobs.wants_so_far() => {}
                Err(Stopped) => return Err(Unfinished::Stopped),
            }
        }
        let mut files = gains_files(self.of, (&self.name, &about(mission, &search, &run), &best.k))?;
        files.push(("convergence.csv".to_owned(), records::convergence_csv(mission, &search)));
        files.push(("front.csv".to_owned(), records::front_csv(mission, &search)));
        let figures = vec![Figure {
            file: "convergence.svg".to_owned(),
            caption: "The search.".to_owned(),
            svg: convergence_figure(mission, &search, &run)?,
        }];
        let told =
            |run: &TuneRun| (records::document(mission, &search, run), records::json(mission, &search, run));
        let (document, json) = told(&run);
        run.wall_s = jobs.clock().map(|clock| clock());
        let better = run.contest.as_ref().is_some_and(|of| of.standing() != Standing::NotBetter);
        let allowed = self.objective.allows(&best.evaluation);
        let judged = match &run.contest {
            Some(contest) => contest.standing().no(allowed),
            None => Some(No::NothingJudged),
        };
        Ok(Results {
            document,
            json,
            files,
            figures,
            absent: vec!["near_hover.txt".to_owned()],
            holds: better && allowed && !run.stopped,
            noes: judged.into_iter().chain(wall(&run.range_ends)).collect(),
            sentence: run.contest.as_ref().map(|contest| contest.verdict()),
            timed: run.wall_s.map(|_| told(&run)),
            noted: range_ends_words(&run.range_ends)
                .map(|words| ("at_range_ends", words))
                .into_iter()
                .collect(),
            stopped: run.contest.is_none(),
            ..Results::default()
        })
    }
}

/// The gains of Ziegler and Nichols.
struct ByRule<'a> {
    of: Of<'a>,
    found: NearHover,
    tuning: Tuning,
    judge: GainJudge<'a>,
    real: GainJudge<'a>,
    asked: TuneAsked,
}

impl Study for ByRule<'_> {
    fn jobs(&self) -> u64 {
        0
    }

    fn run(&self, jobs: &mut dyn Jobs) -> Result<Results, Unfinished> {
        let ((mission, ..), name, found) = (self.of, &self.asked.name, &self.found);
        let of = (mission, &self.tuning, self.asked.robust);
        let judges = (&self.judge, &self.real);
        let contest = contest(jobs, of, judges, (name, &found.adjusted), self.asked.unseen)?;
        let mut files = gains_files(self.of, (name, &near_hover_report::about(mission), &found.adjusted))?;
        let document = near_hover_report::document(mission, found, &contest);
        let told = format!("{}{}\n", document.text(), contest.verdict());
        files.push(("near_hover.txt".to_owned(), told));
        let wall_s = jobs.clock().map(|clock| clock());
        let json = |wall_s| near_hover_report::json(mission, found, &contest, wall_s);
        Ok(Results {
            json: json(None),
            timed: wall_s.map(|wall_s| (document.clone(), json(Some(wall_s)))),
            document,
            files,
            absent: ["convergence.csv", "convergence.svg", "front.csv"].map(str::to_owned).to_vec(),
            holds: contest.standing() != Standing::NotBetter,
            noes: contest.standing().no(true).into_iter().collect(),
            sentence: Some(contest.verdict()),
            ..Results::default()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is usual is written in the table of the settings, and in the tuning's own words.
    #[test]
    fn the_usual_settings_are_the_usual_tuning() {
        let asked = TuneAsked::of(&Values::usual(TuneAsked::TABLE)).unwrap();
        assert_eq!(asked.tuning(), Tuning::default());
    }
}
