//! Plan and gains by one search, as a study: generations of designs, then the best of them on flights that
//! the search did not have, then what was chosen beside the mission's own on fresh flights.

use std::path::Path;

use samara_core::design::{
    CONDITIONS, Design, DesignJudge, DesignSearch, DesignSearchSettings, Finalist, FreshFlight, FreshPilot,
    FreshResults, PORTION, TriedDesign, finalist_numbers,
};
use samara_core::plan::Plan;
use samara_mission::{
    Mission, MissionText, designed_mission_json, gains_json, load_mission, mission_path, parse_mission,
    relative, write_trajectory_csv,
};
use samara_report::document::Figure;
use samara_report::{bode_figure, plan_figure, plan_json};

use super::report::{DesignRun, about, convergence_csv, document, figure, front_csv, json};
use super::{JudgedDesign, OWN, design_judge, design_search, is_more_than_from_t0, own_design};
use crate::jobs::{Jobs, Stage, Stopped};
use crate::kind::{About, Flies, Given, Kind, Refused, Results, Slow, Study, Unfinished};
use crate::searching;
use crate::settings;
use crate::settings::{Maybe, Several, Values, maybe, plain_name, positive_in, several, whole};

/// Help of the verb.
pub const HELP: &str = include_str!("help.txt");
/// The mission that is written.
const MISSION: &str = "design_mission.json";
/// Gains of the mission that is written.
const GAINS: &str = "design_gains.json";

settings! {
    /// How a design is searched, and tried.
    pub DesignAsked {
        /// Most designs that are planned and flown; 0 only judges the mission's own.
        budget("N"): usize = "800", whole(0..=10_000_000);
        /// End the search after so many seconds of wall time.
        ///
        /// Not repeatable: how far a search comes depends on the machine.
        time_limit("S"): Maybe<f64> = "default", maybe(positive_in("s"));
        /// Another mission to judge beside it, with its own gains or others: `titan_paper,ours`.
        ///
        /// On as many fresh flights, its own vehicle and releases in this mission's turbulence; may be
        /// repeated.
        against("MISSION[,GAINS]..."): Several<String, ' '> = "", several(any);
        /// Designs that are judged once more, on flights that the search did not have.
        finalists("N"): usize = "8", whole(1..=1000);
        /// Fresh flights in each condition that the design is tried on afterwards.
        unseen("N"): u64 = "10000", whole(1..=10_000_000);
        /// Name of the gains found.
        name("NAME"): String = "design", plain_name;
    }
}

#[expect(clippy::unnecessary_wraps, reason = "what reads a value may refuse it")]
fn any(text: &str) -> Result<String, String> {
    Ok(text.to_owned())
}

/// Plan and gains of a mission by one search, beside the mission's own.
pub struct Designs;

impl Kind for Designs {
    fn about(&self) -> About {
        About {
            name: "design",
            manifest: "design",
            title: "Search plan and gains together, robust in the air that there is",
            help: HELP,
            unit: "designs",
            flies: Flies::WithoutAPlan,
            settings: DesignAsked::TABLE,
            judges: Ok("the design keeps all bounds and is better than the mission's own"),
            alone: Err("a design is judged by all its flights: `samara drop` flies what was found"),
            refuses: &[],
        }
    }

    fn suits(&self, _: &Mission) -> Result<(), Refused> {
        Ok(())
    }

    fn remarks(&self, mission: &Mission) -> Vec<String> {
        let odd = mission.contradictions().into_iter();
        let mut remarks: Vec<String> = odd.map(|odd| odd.text).collect();
        if !mission.faults.list.is_empty() {
            remarks.push(
                "faults: designs are searched and judged without them; `samara assess` flies motor faults"
                    .to_owned(),
            );
        }
        if is_more_than_from_t0(mission) {
            remarks.push(
                "designs are judged by whole drops, with all that the mission names; the release cases, which bounds are \
                 kept in, begin at t = 0, in still air"
                    .to_owned(),
            );
        } else {
            remarks.extend(mission.battery_remark().map(str::to_owned));
            remarks.extend(mission.t0_remarks());
        }
        if mission.px4.params.is_some() {
            remarks
                .push("px4_params: a design is samara's cascade's; a PX4 keeps the file's gains".to_owned());
        }
        remarks.into_iter().map(|remark| format!("{}: {remark}", mission.name)).collect()
    }

    /// Nothing else: the budget only ends a search.
    fn hangs_on(&self, _: &Mission, _: &Values) -> Result<Vec<(&'static str, String)>, Refused> {
        Ok(Vec::new())
    }

    fn flies_only(&self) -> Option<&'static str> {
        Some("it searches the gains of the cascade")
    }

    fn begin<'a>(&self, given: Given<'a>, values: &Values) -> Result<Box<dyn Study + 'a>, Refused> {
        let asked = DesignAsked::of(values).map_err(Refused)?;
        Ok(Box::new(Designing::new(given.mission, given.folder, asked)?))
    }
}

/// A search of a design that was begun.
#[derive(Debug)]
pub struct Designing<'a> {
    mission: &'a Mission,
    folder: Option<&'a Path>,
    judge: DesignJudge<'a>,
    settings: DesignSearchSettings,
    /// The missions to judge beside it, each with its name.
    others: Vec<(String, Mission)>,
    asked: DesignAsked,
}

/// What was found.
#[derive(Debug)]
pub struct Designed {
    /// The search.
    pub search: DesignSearch,
    /// What came of it.
    pub run: DesignRun,
    /// Whether search or flights were interrupted.
    pub interrupted: bool,
    /// What there is to remark.
    pub remarks: Vec<String>,
}

impl<'a> Designing<'a> {
    /// Begins a search for a mission whose results name files from `folder`.
    ///
    /// # Errors
    /// [`Refused`] where another mission, or its gains, cannot be read.
    pub fn new(mission: &'a Mission, folder: Option<&'a Path>, asked: DesignAsked) -> Result<Self, Refused> {
        let others = asked.against.0.iter().map(|named| other(named, mission));
        let others = others.collect::<Result<_, Refused>>()?;
        let (judge, settings) = (design_judge(mission), design_search(mission, asked.budget));
        Ok(Self { mission, folder, judge, settings, others, asked })
    }

    /// Searches, and tries what was found.
    ///
    /// # Errors
    /// [`Unfinished`] where nothing was found, or nothing is wanted of a search that was stopped.
    pub fn found(&self, jobs: &mut dyn Jobs) -> Result<Designed, Unfinished> {
        let mut search = DesignSearch::new(self.settings.clone());
        let mut interrupted = false;
        let stopped = match self.search(jobs, &mut search) {
            Ended::Whole => false,
            Ended::TimeIsUp => true,
            Ended::Stopped if jobs.wants_so_far() => {
                interrupted = true;
                true
            }
            Ended::Stopped => return Err(Unfinished::Stopped),
        };
        let Some(mut run) = DesignRun::of(&self.asked.name, &self.judge, &search) else {
            let why = if stopped {
                "stopped before any design was judged"
            } else {
                "not one of the designs to begin at has a plan that converges: `samara plan` says why the mission's own has none"
            };
            return Err(Unfinished::Nothing { of: "design", why: why.to_owned() });
        };
        run.stopped = stopped;
        let mut remarks = Vec::new();
        if !interrupted {
            interrupted = self.try_found(jobs, &search, (&mut run, &mut remarks)).is_err();
            if interrupted && !jobs.wants_so_far() {
                return Err(Unfinished::Stopped);
            }
        }
        run.loops = self.judge.loops(&run.chosen.design).unwrap_or_default();
        Ok(Designed { search, run, interrupted, remarks })
    }

    /// Has designs judged until the search is over, or its time is.
    fn search(&self, jobs: &mut dyn Jobs, search: &mut DesignSearch) -> Ended {
        let clock = jobs.clock();
        let in_time = || match (self.asked.time_limit.0, &clock) {
            (Some(limit_s), Some(clock)) => clock() < limit_s,
            _ => true,
        };
        let judge = |search: &DesignSearch, _: usize, design: &Design| {
            in_time().then(|| self.judge.judge(design, search.ceiling()))
        };
        match searching::search(jobs, search, how, judge) {
            Ok(()) => Ended::Whole,
            Err(Stopped) if in_time() => Ended::Stopped,
            Err(Stopped) => Ended::TimeIsUp,
        }
    }

    /// Chooses the best of the finalists and tries it on fresh flights, beside the mission's own and others.
    fn try_found(
        &self,
        jobs: &mut dyn Jobs,
        search: &DesignSearch,
        (run, remarks): (&mut DesignRun, &mut Vec<String>),
    ) -> Result<(), Stopped> {
        let unseen = self.asked.unseen;
        let finalists = search.finalists(self.asked.finalists);
        let numbers = finalist_numbers(unseen);
        let judged = self.others.len() as u64 + 2;
        let others = self.others.iter().map(|(_, other)| format!(",\"{}\"", other.inputs.hash));
        jobs.stage(&Stage {
            unit: "flights",
            jobs: finalists.len() as u64 * (numbers.end - numbers.start)
                + judged * CONDITIONS.len() as u64 * unseen,
            hangs_on: &format!(
                "{{\"designs\":{},\"finalists\":{},\"unseen\":{unseen},\"against\":[\"\"{}]}}",
                search.tried().len(),
                finalists.len(),
                others.collect::<String>()
            ),
        })?;
        run.choose(self.judge_finalists(jobs, &finalists)?, &self.judge);
        let own = own_design(self.mission);
        let chosen =
            (run.chosen.design != own).then_some((run.name.as_str(), &self.judge, run.chosen.design));
        let judges: Vec<DesignJudge<'_>> = self.others.iter().map(|(_, other)| design_judge(other)).collect();
        let others = self.others.iter().zip(&judges);
        let others = others.map(|((name, other), judge)| (name.as_str(), judge, own_design(other)));
        let designs: Vec<_> = std::iter::once((OWN, &self.judge, own)).chain(chosen).chain(others).collect();
        let here = designs.len() - self.others.len();
        for (place, judged) in self.judge_fresh(jobs, &designs)?.into_iter().enumerate() {
            match judged {
                Some(judged) if place < here => run.judged.push(judged),
                Some(judged) => run.others.push(judged),
                // The mission's own plan may be none.
                None if place < here => {}
                None => remarks.push(format!(
                    "--against {}: its plan does not converge; it is left out",
                    designs[place].0
                )),
            }
        }
        Ok(())
    }

    /// The finalists, each on the same flights with everything unknown and turbulence; none where one has no
    /// plan.
    fn judge_finalists(
        &self,
        jobs: &mut dyn Jobs,
        finalists: &[TriedDesign],
    ) -> Result<Vec<Finalist>, Stopped> {
        let flights = self.judge.flights();
        let plans: Option<Vec<Plan>> = finalists.iter().map(|of| self.judge.plan(&of.design.plan)).collect();
        let plans = plans.unwrap_or_default();
        let pilots = finalists.iter().zip(&plans);
        let pilots = pilots.map(|(of, plan)| FreshPilot::new(flights, &of.design, &plan.trajectory));
        let Ok(pilots) = pilots.collect::<Result<Vec<_>, _>>() else { return Ok(Vec::new()) };
        let numbers = finalist_numbers(self.asked.unseen);
        let (_, unknown) = CONDITIONS[CONDITIONS.len() - 1];
        let mut results = vec![FreshResults::default(); pilots.len()];
        jobs.fold_sets(
            "finalists",
            (pilots.len(), numbers.end - numbers.start),
            PORTION,
            &|of, some, stop| {
                let some = numbers.start + some.start..numbers.start + some.end;
                pilots.get(of).filter(|_| !stop()).map(|pilot| pilot.fly(some, unknown))
            },
            |of, flight: FreshFlight| results[of].push(&flight),
        )?;
        let judged = finalists.iter().zip(results);
        Ok(judged.map(|(tried, results)| Finalist { tried: *tried, results: results.whole() }).collect())
    }

    /// Designs by their names and judges, each in each of [`CONDITIONS`], on as many flights as campaigns
    /// have that are numbered from 0; `None` for one that has no plan, or none that can be flown.
    fn judge_fresh(
        &self,
        jobs: &mut dyn Jobs,
        designs: &[(&str, &DesignJudge<'_>, Design)],
    ) -> Result<Vec<Option<JudgedDesign>>, Stopped> {
        let plans: Vec<Option<Plan>> =
            designs.iter().map(|(_, judge, design)| judge.plan(&design.plan)).collect();
        let pilots = designs.iter().zip(&plans).map(|((_, judge, design), plan)| {
            FreshPilot::new(judge.flights(), design, &plan.as_ref()?.trajectory).ok()
        });
        let pilots: Vec<Option<FreshPilot<'_>>> = pilots.collect();
        let there: Vec<&FreshPilot<'_>> = pilots.iter().flatten().collect();
        let mut results = vec![FreshResults::default(); there.len() * CONDITIONS.len()];
        jobs.fold_sets(
            "fresh flights",
            (results.len(), self.asked.unseen),
            PORTION,
            &|set, some, stop| {
                let (_, unknown) = CONDITIONS[set % CONDITIONS.len()];
                let pilot = there.get(set / CONDITIONS.len()).filter(|_| !stop())?;
                Some(pilot.fly(some, unknown))
            },
            |set, flight: FreshFlight| results[set].push(&flight),
        )?;
        let mut results = results.into_iter().map(FreshResults::whole);
        let judged = designs.iter().zip(&pilots).map(|((name, ..), pilot)| {
            pilot.as_ref()?;
            let fresh = results.by_ref().take(CONDITIONS.len()).collect();
            Some(JudgedDesign { name: (*name).to_owned(), fresh })
        });
        Ok(judged.collect())
    }

    /// The files of the chosen design: its mission and gains, its plan.
    fn write_chosen(&self, found: &Designed, results: &mut Results) -> Result<(), Unfinished> {
        let (run, chosen) = (&found.run, &found.run.chosen.design);
        let gains = gains_json(&run.name, &about(self.mission, &found.search, run), &run.gains(self.mission));
        let mission = self.designed_mission(chosen, GAINS)?;
        let file = self.folder.unwrap_or(Path::new("")).join(MISSION);
        let text = MissionText { mission: &mission, file: &file, vehicle: None, gains: Some(&gains) };
        let designed = parse_mission(&text).map_err(|error| Unfinished::File(error.to_string()))?;
        results.noted.push(("designed_input_hash", designed.inputs.hash.clone()));
        results.files.extend([(GAINS.to_owned(), gains), (MISSION.to_owned(), mission)]);
        if let Some(plan) = self.judge.plan(&chosen.plan) {
            let mut trajectory = Vec::new();
            let written = write_trajectory_csv(&mut trajectory, &plan.trajectory, &designed.stamp());
            written.map_err(|error| Unfinished::File(error.to_string()))?;
            let trajectory = String::from_utf8_lossy(&trajectory).into_owned();
            results.files.push(("trajectory.csv".to_owned(), trajectory));
            results.files.push(("plan.json".to_owned(), plan_json(&designed, &plan, None, None)));
            let svg = plan_figure(&designed, &plan.trajectory)?;
            results.figures.push(drawn("plan.svg", "The plan of the design.", svg));
        }
        Ok(())
    }

    /// The mission's file with a design; `gains` is what it calls the file of its gains.
    ///
    /// # Errors
    /// [`Unfinished::File`] where the mission's own text is none.
    pub fn designed_mission(&self, design: &Design, gains: &str) -> Result<String, Unfinished> {
        let named = |path: &Path| match self.folder {
            Some(folder) => relative(folder, path),
            None => std::path::absolute(path).unwrap_or_else(|_| path.to_owned()).display().to_string(),
        };
        designed_mission_json(self.mission, design, gains, named)
            .map_err(|error| Unfinished::File(error.to_string()))
    }
}

/// How a search ended.
enum Ended {
    Whole,
    TimeIsUp,
    Stopped,
}

/// A mission that is judged beside another one, in that one's turbulence, and its name.
fn other(named: &str, mission: &Mission) -> Result<(String, Mission), Refused> {
    let (path, gains) = named.split_once(',').map_or((named, None), |(path, gains)| (path, Some(gains)));
    let refused = |error: &dyn std::fmt::Display| Refused(format!("--against {named}: {error}"));
    let mut other = mission_path(Path::new(path))
        .and_then(|path| load_mission(&path))
        .map_err(|error| refused(&error))?;
    let mut name = other.name.clone();
    if let Some(gains) = gains {
        other.use_gains(gains).map_err(|error| refused(&error))?;
        name = format!("{name}, {}", other.control.gains_name);
    }
    other.design.turbulence = mission.design.turbulence;
    Ok((name, other))
}

/// How well a search goes.
fn how(search: &DesignSearch) -> String {
    search.best().map_or_else(String::new, |best| {
        let judgement = &best.judgement;
        format!("best cost {:.4} (J_TPF {:.4}, worst {:.4})", best.cost, judgement.j_tpf, judgement.worst)
    })
}

fn drawn(file: &str, caption: &str, svg: String) -> Figure {
    Figure { file: file.to_owned(), caption: caption.to_owned(), svg }
}

impl Study for Designing<'_> {
    fn jobs(&self) -> u64 {
        // The designs to begin at are all tried.
        let begins = searching::candidates(&DesignSearch::new(self.settings.clone()));
        begins.max(self.asked.budget as u64)
    }

    fn slow(&self) -> Option<Slow<'_>> {
        let own = &self.settings.own;
        let reason = self.judge.one_at_a_time(own)?.to_string();
        let try_some = move || {
            std::hint::black_box(self.judge.judge(own, f64::INFINITY));
        };
        Some(Slow { reason, flights: self.jobs(), tried: 1, try_some: Box::new(try_some) })
    }

    fn run(&self, jobs: &mut dyn Jobs) -> Result<Results, Unfinished> {
        let mut found = self.found(jobs)?;
        let mission = self.mission;
        let mut results = Results::default();
        self.write_chosen(&found, &mut results)?;
        let Designed { search, run, interrupted, .. } = &mut found;
        results.files.push(("design.csv".to_owned(), convergence_csv(mission, search)));
        results.files.push(("design_front.csv".to_owned(), front_csv(mission, search)));
        if !run.loops.is_empty() {
            let svg = bode_figure(mission, &run.name, &run.loops)?;
            results.figures.push(drawn("design_bode.svg", "The loops of the design.", svg));
        }
        if !run.judged.is_empty() {
            let svg = figure(mission, run)?;
            results.figures.push(drawn("design.svg", "J_TPF of fresh flights.", svg));
        }
        (results.document, results.json) = (document(mission, search, run), json(mission, search, run));
        run.wall_s = jobs.clock().map(|clock| clock());
        results.timed = run.wall_s.map(|_| (document(mission, search, run), json(mission, search, run)));
        let good = run.is_better() || (self.asked.budget == 0 && run.allowed);
        Ok(Results {
            holds: good && !*interrupted,
            stopped: *interrupted,
            sentence: Some(run.verdict()),
            noes: run.noes(),
            remarks: found.remarks,
            ..results
        })
    }
}
