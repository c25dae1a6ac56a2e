//! `samara assess --autopilot`: a campaign of whole drops, by any of the autopilots, several side by side.

use std::collections::BTreeMap;
use std::fs;
use std::io::Write as _;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc;

use anyhow::Context as _;

use super::args::AssessArgs;
use super::command::Command;
use super::own::write_page;
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::args::AutopilotArg;
use crate::cli::conclusion::Conclusion;
use crate::cli::mission::print_origin;
use crate::cli::narrator::Narrator;
use crate::cli::pilot::{Flight, Flown, Pilot, pilot_and_mission};
use crate::cli::planning::{Planned, plan_mission, write_plan};
use crate::cli::results::{OutputFolder, gone};
use crate::cli::terminal::{print, print_err};
use samara::assess::repeats::{RepeatSpread, RepeatedFlight, repeat_position};
use samara::assess::{DropMeasure, DropOutcome, RandomDrop, plan_j_tpf, tracking};
use samara::config::Mission;
use samara::link::shell::ports::MAX_INSTANCE;
use samara::link::shell::{Speed, Wiring};
use samara::plan::Status;
use samara::report::campaign::{CampaignReport, CampaignSummary, NamedCampaign, TrialJudge, TrialRecord};
use samara::report::drops::{DropTally, DropTrial, drops_json, drops_text, header, row};
use samara::report::repeats::{repeats_header, repeats_json, repeats_row, repeats_text};
use samara::report::{DropRun, FlownBy, plan_json, plan_text};

/// Drops by PX4 flown side by side unless it is said otherwise: each is a PX4 and a simulator that wait for
/// each other.
const SIDE_BY_SIDE: u16 = 2;

/// What every trial shares.
struct Campaign<'a> {
    args: &'a AssessArgs,
    pilot: Box<dyn Pilot>,
    mission: Mission,
    planned: Planned,
    folder: &'a Path,
}

/// Flies the campaign, or one trial of it.
pub fn run(args: &AssessArgs, autopilot: &AutopilotArg, stop: &AtomicBool) -> Result<Answer, Failure> {
    let (pilot, mission) = pilot_and_mission(&args.pilot(autopilot))?;
    print_origin(&args.mission, &mission)?;
    let folder = OutputFolder::create(args.mission.out.as_deref(), &mission.name)?;
    let timed = plan_mission(&mission, false)?;
    write_plan(&folder, &mission, &timed.plan)?;
    if timed.plan.status != Status::Converged {
        print_err(&format!("no plan to fly: {}", plan_text(&timed.plan, &mission.limits.safety, None)));
        if args.mission.json {
            print(&plan_json(&mission, &timed.plan, Some(timed.solve_ms)))?;
        }
        return Ok(Answer::No);
    }
    let trajectory = timed.plan.trajectory.clone();
    let planned = Planned { trajectory, source: "planned", solve_ms: None, plan: Some(timed.plan) };
    pilot.check(&mission, &planned.trajectory, args.instance)?;
    let campaign = Campaign { args, pilot, mission, planned, folder: folder.path() };
    match (args.only, args.repeat) {
        (Some(trial), Some(times)) => campaign.repeat(trial, times, &folder, stop),
        (Some(trial), None) => campaign.only(trial, stop),
        (None, _) => {
            let mut places = 0..campaign.workers();
            places.try_for_each(|place| campaign.pilot.check_instance(campaign.instance(place)))?;
            campaign.fly_all(&folder, stop)
        }
    }
}

impl Campaign<'_> {
    fn name(&self) -> String {
        let gains = self.mission.control.gains_name.trim_end_matches(".params");
        format!("drops_{}_{gains}", self.pilot.name())
    }

    /// Flies one trial, reported as `samara drop` reports it, all files kept.
    fn only(&self, trial: u64, stop: &AtomicBool) -> Result<Answer, Failure> {
        let drawn = self.mission.draw_drop(trial);
        let path = self.folder.join(format!("trial_{trial}"));
        remove_folder(&path)?;
        let folder = OutputFolder::create(Some(&path), &self.mission.name)?;
        let narrator = Narrator::together(self.args.mission.json);
        let mission = self.mission.with_drop(&drawn);
        let flown = self.fly(&mission, self.args.instance, &folder, &narrator, stop)?;
        let conclusion = Conclusion::new(&mission, Some(&self.planned), &flown).with_page(&self.args.page);
        let trial = self.judge(&drawn, &conclusion, &flown);
        self.write(&drawn, conclusion, &folder, &narrator)?;
        let mut tally = DropTally::default();
        tally.push(&trial);
        print(&if self.args.mission.json {
            drops_json(&self.mission, self.pilot.name(), &tally)
        } else {
            let outcome = trial.failure.as_ref().map_or("ok".to_owned(), |why| format!("FAILED: {why}"));
            format!("trial {} of the campaign: {outcome}\n", drawn.trial)
        })?;
        Ok(Answer::from(!tally.any_failed()))
    }

    /// Flies one trial so many times, one after the other, and reports how far the flights lie apart.
    fn repeat(
        &self,
        trial: u64,
        times: u64,
        folder: &OutputFolder,
        stop: &AtomicBool,
    ) -> Result<Answer, Failure> {
        self.pilot.check_instance(self.args.instance)?;
        let name = format!("repeats_{}_trial_{trial}", self.pilot.name());
        let csv = format!("{name}.csv");
        let mut file = folder.continued(&csv, 0)?;
        let mut write = |text: &str| file.write_all(text.as_bytes()).context(csv.clone()).bad_input();
        write(&repeats_header(&self.mission, self.pilot.name(), trial))?;
        let (drawn, scratch) = (self.mission.draw_drop(trial), self.folder.join("place_0"));
        let mission = self.mission.with_drop(&drawn);
        let (mut flights, mut failed, mut flown_times) = (Vec::new(), 0, 0);
        for number in 1..=times {
            remove_folder(&scratch)?;
            let place = OutputFolder::create(Some(&scratch), &self.mission.name)?;
            let flown = self.fly(&mission, self.args.instance, &place, &Narrator::of_trial(trial), stop);
            if stop.load(Ordering::Relaxed) {
                break;
            }
            flown_times = number;
            let (flight, failure) = match &flown {
                Ok(flown) => {
                    let conclusion = Conclusion::new(&mission, Some(&self.planned), flown);
                    let judged = self.judge(&drawn, &conclusion, flown);
                    let flight = judged.outcome.map(|o| RepeatedFlight {
                        j_tpf: o.verdict.j_tpf,
                        steady_after_s: o.verdict.steady_after_s,
                        position_ned_m: repeat_position(&flown.log),
                    });
                    (flight, judged.failure)
                }
                Err(why) => (None, Some(why.text())),
            };
            failed += u64::from(failure.is_some());
            write(&repeats_row(number, flight.as_ref(), failure.as_deref()))?;
            let words = match (&failure, &flight) {
                (Some(failure), _) => format!("FAILED: {failure}"),
                (None, Some(flight)) => format!("J_TPF {:.4}", flight.j_tpf),
                (None, None) => "nothing".to_owned(),
            };
            print_err(&format!("flight {number} of {times}: {words}\n"));
            flights.extend(flight);
        }
        let spread = RepeatSpread::of(&flights);
        let circumstances = [("trial", trial.to_string()), ("flights", flown_times.to_string())];
        folder.write_manifest(&name, &self.mission, &circumstances)?;
        print(&if self.args.mission.json {
            repeats_json(&self.mission, self.pilot.name(), trial, failed, &spread)
        } else {
            let table = repeats_text(&self.mission, self.pilot.name(), trial, &spread);
            let place = folder.path().join(&csv);
            format!("{table}{failed} of {flown_times} flights failed; lines in {}\n", place.display())
        })?;
        if flown_times < times {
            print_err(&format!("stopped after {flown_times} of {times} flights\n"));
        }
        remove_folder(&scratch)?;
        Ok(Answer::from(flown_times == times && failed == 0))
    }

    /// Writes all files of a flight, as `samara drop` leaves them, and reports what there is to report.
    fn write(
        &self,
        drawn: &RandomDrop,
        mut conclusion: Conclusion<'_>,
        folder: &OutputFolder,
        narrator: &Narrator,
    ) -> Result<(), Failure> {
        self.planned.write_to(folder, conclusion.mission)?;
        conclusion.write("drop", &[("trial", drawn.trial.to_string())], folder)?;
        conclusion.report(narrator, folder)
    }

    fn fly_all(&self, folder: &OutputFolder, stop: &AtomicBool) -> Result<Answer, Failure> {
        let trials = self.args.trials.unwrap_or(self.mission.study.monte_carlo.trials as u64);
        let workers = self.workers();
        let csv = format!("{}.csv", self.name());
        let mut file = folder.continued(&csv, 0)?;
        let mut write = |text: &str| file.write_all(text.as_bytes()).context(csv.clone()).bad_input();
        write(&header(&self.mission, self.pilot.name()))?;
        let (next, mut tally, mut by) = (AtomicU64::new(0), DropTally::default(), None);
        let mut summary = CampaignSummary::default();
        let (done, comes) = mpsc::channel();
        let written = std::thread::scope(|scope| {
            for place in 0..workers {
                let (done, next) = (done.clone(), &next);
                scope.spawn(move || {
                    while !stop.load(Ordering::Relaxed) {
                        let trial = next.fetch_add(1, Ordering::Relaxed);
                        // Nobody listens any more when a file could not be written.
                        if trial >= trials || done.send(self.trial(trial, place, stop)).is_err() {
                            break;
                        }
                    }
                });
            }
            drop(done);
            // Lines are in order, whichever trial is over first.
            let (mut early, mut wanted) = (BTreeMap::new(), 0);
            for trial in comes {
                let Some((trial, flown_by)) = trial else { continue };
                if flown_by.is_some() {
                    by = flown_by;
                }
                early.insert(trial.drawn.trial, trial);
                while let Some(trial) = early.remove(&wanted) {
                    write(&row(&self.mission, &trial))?;
                    tally.push(&trial);
                    summary.push(&TrialRecord::of_drop(&trial));
                    wanted += 1;
                    Self::report(&trial, trials);
                }
            }
            Ok::<(), Failure>(())
        });
        written?;
        let mut circumstances =
            vec![("trials", trials.to_string()), ("autopilot", self.pilot.name().to_owned())];
        circumstances.extend(by.and_then(|by| by.version).map(|version| ("autopilot_version", version)));
        let page = format!("{}.html", self.name());
        if tally.flown() > 0 {
            self.write_page(folder, trials, summary, &csv)?;
        }
        folder.write_manifest(&self.name(), &self.mission, &circumstances)?;
        print(&if self.args.mission.json {
            drops_json(&self.mission, self.pilot.name(), &tally)
        } else {
            let place = folder.path().join(&csv);
            let table = drops_text(&self.mission, self.pilot.name(), &tally);
            let page = folder.path().join(&page);
            let (flown, failed) = (tally.flown(), tally.failed());
            let verdict = match failed {
                0 => format!("safe in all {flown} drops"),
                _ => format!("NOT safe: {failed} of {flown} drops failed"),
            };
            format!("{table}\nlines in {}, start with {}\n{verdict}\n", place.display(), page.display())
        })?;
        let complete = tally.flown() == trials;
        if !complete {
            print_err(&format!("stopped after {} of {trials} drops\n", tally.flown()));
        }
        // Last: a folder that cannot be removed takes no result away.
        for place in 0..workers {
            remove_folder(&self.folder.join(format!("place_{place}")))?;
        }
        Ok(Answer::from(complete && !tally.any_failed()))
    }

    /// Writes the page of the campaign.
    fn write_page(
        &self,
        folder: &OutputFolder,
        trials: u64,
        summary: CampaignSummary,
        csv: &str,
    ) -> Result<(), Failure> {
        let (mission, name) = (&self.mission, self.name());
        let mut command = Command::of(self.args, mission);
        if let Some(autopilot) = &self.args.autopilot {
            command = command.by(autopilot);
        }
        let by = self.pilot.name();
        let report = CampaignReport {
            mission,
            flown_by: format!("{by}, whole drops from the hang to the end, with wind and sensor noise drawn"),
            command: command.with_trials(trials),
            alone: command.alone(),
            judge: TrialJudge::of(mission, 1.0),
            plan_j_tpf: plan_j_tpf(&self.planned.trajectory, &mission.limits.safety),
            campaigns: vec![NamedCampaign {
                name: name.clone(),
                label: format!("{}, flown by {by}", mission.control.gains_name),
                summary,
                file: csv.to_owned(),
            }],
            cases: Vec::new(),
            tracking_period_s: tracking::control_period_s(&self.planned.trajectory),
        };
        let prefix = format!("{name}_");
        write_page(folder, &report, [&name, &prefix], [], &[csv.to_owned()])
    }

    fn report(trial: &DropTrial, trials: u64) {
        let number = trial.drawn.trial;
        let text = match (&trial.failure, &trial.outcome) {
            (Some(failure), _) => format!("FAILED: {failure}"),
            (None, Some(o)) => format!(
                "J_TPF {:.4}, steady after {:.2} s",
                o.verdict.j_tpf,
                o.verdict.steady_after_s.unwrap_or(f64::NAN)
            ),
            (None, None) => "nothing".to_owned(),
        };
        print_err(&format!("trial {number} of {trials}: {text}\n"));
    }

    /// The number of drops that are flown side by side; each PX4 needs the ports of an instance.
    fn workers(&self) -> u16 {
        if self.pilot.takes_ports() {
            self.args.threads.unwrap_or(SIDE_BY_SIDE).min(MAX_INSTANCE + 1 - self.args.instance)
        } else {
            self.args.threads.unwrap_or_else(cores)
        }
    }

    /// The number of the vehicle that is flown at one of the places.
    fn instance(&self, place: u16) -> u16 {
        self.args.instance + if self.pilot.takes_ports() { place } else { 0 }
    }

    /// Flies a trial at one of the places; `None` when it was stopped. Whatever goes wrong is the trial's
    /// failure. The files of one that failed are kept.
    fn trial(&self, number: u64, place: u16, stop: &AtomicBool) -> Option<(DropTrial, Option<FlownBy>)> {
        let drawn = self.mission.draw_drop(number);
        let failed = |why: &Failure| DropTrial { drawn, outcome: None, failure: Some(why.text()) };
        let scratch = self.folder.join(format!("place_{place}"));
        // The files of the trial that was flown here before are not this one's.
        let emptied = if scratch.is_dir() { remove_folder(&scratch) } else { Ok(()) };
        let made = emptied.and_then(|()| OutputFolder::create(Some(&scratch), &self.mission.name));
        let folder = match made {
            Ok(folder) => folder,
            Err(why) => return Some((failed(&why), None)),
        };
        let (mission, narrator) = (self.mission.with_drop(&drawn), Narrator::of_trial(number));
        let flown = self.fly(&mission, self.instance(place), &folder, &narrator, stop);
        if stop.load(Ordering::Relaxed) {
            return None;
        }
        let (mut trial, conclusion) = match &flown {
            Ok(flown) => {
                let conclusion =
                    Conclusion::new(&mission, Some(&self.planned), flown).with_page(&self.args.page);
                (self.judge(&drawn, &conclusion, flown), Some(conclusion))
            }
            Err(why) => (failed(why), None),
        };
        if let Some(failure) = &mut trial.failure {
            let written =
                conclusion.map_or(Ok(()), |conclusion| self.write(&drawn, conclusion, &folder, &narrator));
            if let Err(why) = written.and_then(|()| self.keep(number, &folder)) {
                *failure = format!("{failure}; {}", why.text());
            }
        }
        Some((trial, flown.ok().and_then(|flown| flown.by)))
    }

    /// Keeps the files of a trial that failed.
    fn keep(&self, trial: u64, folder: &OutputFolder) -> Result<(), Failure> {
        let kept = self.folder.join(format!("trial_{trial}"));
        remove_folder(&kept)?;
        fs::rename(folder.path(), &kept)
            .with_context(|| format!("cannot keep the files in {}", kept.display()))
            .bad_input()
    }

    fn fly(
        &self,
        mission: &Mission,
        instance: u16,
        folder: &OutputFolder,
        narrator: &Narrator,
        stop: &AtomicBool,
    ) -> Result<Flown, Failure> {
        self.pilot.fly(&Flight {
            mission,
            trajectory: &self.planned.trajectory,
            replan: None,
            folder,
            narrator,
            instance,
            speed: Speed::Max,
            wiring: &Wiring::default(),
            stop: Some(stop),
        })
    }

    /// Measures a flight and says why it counts as failed, if it does.
    fn judge(&self, drawn: &RandomDrop, conclusion: &Conclusion<'_>, flown: &Flown) -> DropTrial {
        let mission = conclusion.mission;
        let measure = DropMeasure {
            limits: mission.limits.safety,
            target_v_ned: mission.target_v_ned,
            steady_within_m_s: mission.limits.steady_within_m_s,
            flight_limits: mission.limits.flight,
            separation_m: mission.limits.separation_m,
            plan: &self.planned.trajectory,
        };
        let outcome = measure.of(&flown.log);
        let failure = match (&outcome, &flown.trouble) {
            (None, None) => Some("never released".to_owned()),
            (None, Some(trouble)) => Some(format!("never released: {trouble}")),
            (Some(_), Some(trouble)) => Some(trouble.clone()),
            (Some(o), None) => failure_of(o, &conclusion.run),
        };
        DropTrial { drawn: *drawn, outcome, failure }
    }
}

/// Why a drop that came to its end counts as failed, if it does.
fn failure_of(outcome: &DropOutcome, run: &DropRun) -> Option<String> {
    let DropOutcome { verdict, .. } = outcome;
    if !verdict.limits_passed.is_empty() {
        return Some(format!("limits passed: {}", verdict.limits_passed.join(", ")));
    }
    let reasons = [
        (run.released_unarmed, "released while the autopilot was not armed"),
        (run.failsafe, "a failsafe flew"),
        (!run.completed, "stopped before the mission's end"),
        (run.plan_cut, "the mission's duration_s ended before the plan"),
        (verdict.steady_after_s.is_none(), "never steady"),
    ];
    reasons.into_iter().find(|(holds, _)| *holds).map(|(_, reason)| reason.to_owned())
}

/// The number of processors.
fn cores() -> u16 {
    std::thread::available_parallelism().map_or(1, |n| u16::try_from(n.get()).unwrap_or(u16::MAX))
}

/// Removes a folder with all that it holds, if it is there.
pub fn remove_folder(path: &Path) -> Result<(), Failure> {
    gone(fs::remove_dir_all(path)).with_context(|| format!("cannot remove {}", path.display())).bad_input()
}
