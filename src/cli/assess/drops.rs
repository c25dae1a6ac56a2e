//! `samara assess --autopilot`: a campaign of whole drops, by the reference autopilot or by PX4, several side by side.

use std::collections::BTreeMap;
use std::fs;
use std::io::Write as _;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc;

use anyhow::Context;

use super::AssessArgs;
use crate::cli::args::{AutopilotArg, LinkArgs, NetArgs, SpeedArg};
use crate::cli::belongs;
use crate::cli::drop::{
    Flown, Pilot, Planned, Wires, conclude, cuts_the_plan, fly_reference, tell_if_stopped, tell_remarks,
};
use crate::cli::narrative::Narrator;
use crate::cli::outcome::{Answer, BadInput, Failure};
use crate::cli::output::{OutputFolder, print, tell};
use crate::cli::plan::{plan_mission, write_plan};
use crate::cli::px4::flight::Px4Drop;
use crate::cli::px4::{self, Patience};
use samara::assess::{DropMeasure, RandomDrop};
use samara::config::Mission;
use samara::link::shell::Speed;
use samara::link::shell::ports::MAX_INSTANCE;
use samara::plan::Status;
use samara::report::FlownBy;
use samara::report::drops::{DropTally, DropTrial, drops_json, drops_text, header, row};
use samara::report::plan_text;

/// Drops by PX4 flown side by side unless it is said otherwise: each is a PX4 and a simulator that wait for each other.
const SIDE_BY_SIDE: u16 = 2;

/// What every trial shares.
struct Campaign<'a> {
    args: &'a AssessArgs,
    pilot: Pilot,
    mission: Mission,
    planned: Planned,
    folder: &'a std::path::Path,
}

/// Flies the campaign, or one trial of it.
///
/// # Errors
/// [`Failure::BadInput`] when PX4 is not there, the mission does not suit, or a file cannot be written.
pub fn run(args: &AssessArgs, autopilot: &AutopilotArg, stop: &AtomicBool) -> Result<Answer, Failure> {
    belongs::check(autopilot, &args.asked())?;
    let AssessArgs { choice, state, feed_forward, .. } = args;
    let (pilot, mission) = Pilot::of(autopilot, &args.mission.mission, choice, state, *feed_forward)?;
    let folder = OutputFolder::create(args.mission.out.as_deref(), &mission.name)?;
    let timed = plan_mission(&mission, false)?;
    write_plan(&folder, &mission, &timed.plan)?;
    if timed.plan.status != Status::Converged {
        tell(&format!("no plan to fly: {}", plan_text(&timed.plan, &mission.limits.safety, None)));
        return Ok(Answer::No);
    }
    let planned = Planned { trajectory: timed.plan.trajectory, source: "planned", solve_ms: None };
    tell_remarks(&mission, &pilot.check(&mission, &planned.trajectory)?);
    let campaign = Campaign { args, pilot, mission, planned, folder: folder.path() };
    match args.only {
        Some(trial) => campaign.only(trial, stop),
        None => {
            campaign.look_at_places()?;
            campaign.fly_all(&folder, stop)
        }
    }
}

impl Campaign<'_> {
    fn autopilot(&self) -> &'static str {
        self.pilot.name(&self.args.state)
    }

    fn name(&self) -> String {
        let gains = self.mission.control.gains_name.trim_end_matches(".params");
        format!("drops_{}_{gains}", self.autopilot())
    }

    /// One trial, told as `samara drop` tells it, all files kept.
    fn only(&self, trial: u64, stop: &AtomicBool) -> Result<Answer, Failure> {
        let drawn = self.mission.draw_drop(trial);
        let folder = self.kept(trial)?;
        let narrator = Narrator::together(self.args.mission.json);
        let mission = self.mission.with_drop(&drawn);
        let (trial, flown) = self.fly(&drawn, &mission, self.args.instance, &folder, &narrator, stop)?;
        self.write(&trial, &mission, &flown, &folder, &narrator)?;
        let mut tally = DropTally::default();
        tally.push(&trial);
        if self.args.mission.json {
            print(&drops_json(&self.mission, self.autopilot(), &tally))?;
        } else {
            print(&format!("\n{}{}", header(&self.mission, self.autopilot()), row(&trial)))?;
        }
        Ok(if tally.any_failed() { Answer::No } else { Answer::Yes })
    }

    /// The folder of a trial whose files are kept, empty.
    fn kept(&self, trial: u64) -> Result<OutputFolder, Failure> {
        let path = self.folder.join(format!("trial_{trial}"));
        remove_folder(&path)?;
        OutputFolder::create(Some(&path), &self.mission.name)
    }

    /// All files of a flight, as `samara drop` leaves them; what there is to tell is told.
    fn write(
        &self,
        trial: &DropTrial,
        mission: &Mission,
        flown: &Flown,
        folder: &OutputFolder,
        narrator: &Narrator,
    ) -> Result<(), Failure> {
        self.planned.write_to(folder, mission)?;
        let circumstances = [("trial", trial.drawn.trial.to_string())];
        conclude(mission, &self.planned, flown, &circumstances, folder, narrator).map(|_| ())
    }

    fn fly_all(&self, folder: &OutputFolder, stop: &AtomicBool) -> Result<Answer, Failure> {
        let trials = self.args.trials.unwrap_or(self.mission.study.monte_carlo.trials as u64);
        let workers = self.workers();
        let csv = format!("{}.csv", self.name());
        let mut file = folder.continued(&csv, 0)?;
        let mut write = |text: &str| file.write_all(text.as_bytes()).context(csv.clone()).bad_input();
        write(&header(&self.mission, self.autopilot()))?;
        let (next, mut tally, mut by) = (AtomicU64::new(0), DropTally::default(), None);
        let (done, comes) = mpsc::channel();
        let told = std::thread::scope(|scope| {
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
                    write(&row(&trial))?;
                    tally.push(&trial);
                    wanted += 1;
                    self.tell(&trial, trials);
                }
            }
            Ok::<(), Failure>(())
        });
        told?;
        let mut circumstances =
            vec![("trials", trials.to_string()), ("autopilot", self.autopilot().to_owned())];
        circumstances.extend(by.and_then(|by| by.version).map(|version| ("autopilot_version", version)));
        folder.write_manifest(&self.name(), &self.mission, &circumstances)?;
        if self.args.mission.json {
            print(&drops_json(&self.mission, self.autopilot(), &tally))?;
        } else {
            let place = folder.path().join(&csv);
            print(&format!(
                "{}\nlines in {}\n",
                drops_text(&self.mission, self.autopilot(), &tally),
                place.display()
            ))?;
        }
        let complete = tally.flown() == trials;
        if !complete {
            tell(&format!("stopped after {} of {trials} drops\n", tally.flown()));
        }
        // Last: a folder that cannot be removed takes no result away.
        for place in 0..workers {
            remove_folder(&self.folder.join(format!("place_{place}")))?;
        }
        Ok(if complete && !tally.any_failed() { Answer::Yes } else { Answer::No })
    }

    fn tell(&self, trial: &DropTrial, trials: u64) {
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
        tell(&format!("trial {number} of {trials}: {text}\n"));
    }

    /// How many fly side by side; each PX4 needs the ports of an instance.
    fn workers(&self) -> u16 {
        match self.pilot {
            Pilot::Px4(..) => {
                self.args.threads.unwrap_or(SIDE_BY_SIDE).min(MAX_INSTANCE + 1 - self.args.instance)
            }
            Pilot::Reference(_) | Pilot::Px4Model(_) => self.args.threads.unwrap_or_else(cores),
        }
    }

    /// Whether each PX4 can have its number and ports: what is wrong with them is wrong for every trial.
    fn look_at_places(&self) -> Result<(), Failure> {
        let Pilot::Px4(..) = self.pilot else { return Ok(()) };
        (0..self.workers()).try_for_each(|place| px4::look(self.args.instance + place))
    }

    /// A trial at one of the places, unless it was stopped; whatever goes wrong is its failure. The files of one that failed are kept.
    fn trial(&self, number: u64, place: u16, stop: &AtomicBool) -> Option<(DropTrial, Option<FlownBy>)> {
        let drawn = self.mission.draw_drop(number);
        let failed = |why: Failure| DropTrial { drawn, outcome: None, failure: Some(why.text()) };
        let scratch = self.folder.join(format!("place_{place}"));
        let folder = match OutputFolder::create(Some(&scratch), &self.mission.name) {
            Ok(folder) => folder,
            Err(why) => return Some((failed(why), None)),
        };
        let (mission, narrator) = (self.mission.with_drop(&drawn), Narrator::of_trial(number));
        let instance = match self.pilot {
            Pilot::Px4(..) => self.args.instance + place,
            Pilot::Reference(_) | Pilot::Px4Model(_) => self.args.instance,
        };
        let flown = self.fly(&drawn, &mission, instance, &folder, &narrator, stop);
        if stop.load(Ordering::Relaxed) {
            return None;
        }
        let (mut trial, flown) = match flown {
            Ok((trial, flown)) => (trial, Some(flown)),
            Err(why) => (failed(why), None),
        };
        if trial.failure.is_some() {
            let written = flown
                .as_ref()
                .map_or(Ok(()), |flown| self.write(&trial, &mission, flown, &folder, &narrator));
            let kept = written.and_then(|()| self.keep(number, &folder));
            if let (Err(why), Some(failure)) = (kept, &mut trial.failure) {
                *failure = format!("{failure}; {}", why.text());
            }
        }
        Some((trial, flown.map(|flown| flown.by)))
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
        drawn: &RandomDrop,
        mission: &Mission,
        instance: u16,
        folder: &OutputFolder,
        narrator: &Narrator,
        stop: &AtomicBool,
    ) -> Result<(DropTrial, Flown), Failure> {
        let plan = &self.planned.trajectory;
        let flown = match &self.pilot {
            Pilot::Reference(choice) => {
                let net = NetArgs { instance, sign_key: None };
                let link = LinkArgs { links: Vec::new() };
                let (state, speed, stop) = (&self.args.state, SpeedArg::Max, Some(stop));
                let wires = Wires { choice, state, net: &net, link: &link, speed, stop };
                fly_reference(&wires, mission, plan, folder, narrator)?
            }
            Pilot::Px4(build, parameters) => {
                let drop = Px4Drop {
                    build,
                    instance,
                    cpu: px4::Cpu::Together,
                    speed: Speed::Max,
                    parameters: parameters.as_ref(),
                    feed_forward: self.args.feed_forward,
                    patience: Patience {
                        limit: self.args.patience.limit(),
                        answers: self.args.only.is_none(),
                    },
                };
                px4::fly(&drop, mission, plan, folder, narrator)?
            }
            Pilot::Px4Model(parameters) => {
                px4::model::fly(mission, plan, parameters.as_ref(), self.args.feed_forward)?
            }
        };
        let measure = DropMeasure {
            limits: mission.limits.safety,
            target_v_ned: mission.target_v_ned,
            steady_within_m_s: mission.limits.steady_within_m_s,
            plan,
        };
        let outcome = measure.of(&flown.log);
        let stopped = tell_if_stopped(&Narrator::together(true), mission, &flown.log)?;
        let failure = match (&outcome, &flown.trouble) {
            (None, None) => Some("never released".to_owned()),
            (None, Some(trouble)) => Some(format!("never released: {trouble}")),
            (Some(_), Some(trouble)) => Some(trouble.clone()),
            (Some(o), None) if !o.verdict.limits_passed.is_empty() => {
                Some(format!("limits passed: {}", o.verdict.limits_passed.join(", ")))
            }
            (Some(_), None) if flown.record.failsafe => Some("a failsafe flew".to_owned()),
            (Some(_), None) if stopped => Some("stopped before the mission's end".to_owned()),
            (Some(_), None) if cuts_the_plan(&flown.log, plan.end_s()) => {
                Some("the mission's duration_s ended before the plan".to_owned())
            }
            (Some(o), None) if o.verdict.steady_after_s.is_none() => Some("never steady".to_owned()),
            (Some(_), None) => None,
        };
        Ok((DropTrial { drawn: *drawn, outcome, failure }, flown))
    }
}

/// Processors that there are.
fn cores() -> u16 {
    std::thread::available_parallelism().map_or(1, |n| u16::try_from(n.get()).unwrap_or(u16::MAX))
}

/// Removes a folder with all that is in it, if it is there.
fn remove_folder(path: &std::path::Path) -> Result<(), Failure> {
    match fs::remove_dir_all(path) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => {
            Err(e).with_context(|| format!("cannot remove {}", path.display())).bad_input()
        }
        _ => Ok(()),
    }
}
