//! All trials of a campaign of whole drops: flown side by side, written as they come, in order.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::Write as _;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc;

use anyhow::Context as _;

use super::kept::{KeptDrops, Over};
use super::{Campaign, remove_folder};
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::assess::command::Command;
use crate::cli::assess::own::write_page;
use crate::cli::conclusion::Conclusion;
use crate::cli::narrator::Narrator;
use crate::cli::results::OutputFolder;
use crate::cli::terminal::{print, print_err};
use samara::assess::{plan_j_tpf, tracking};
use samara::report::campaign::{CampaignReport, CampaignSummary, NamedCampaign, TrialJudge, TrialRecord};
use samara::report::drops::{DropTally, DropTrial, drops_json, drops_text, header, row};

impl Campaign<'_> {
    /// Flies what is missing of the campaign, writes and reports it.
    pub(super) fn fly_all(&self, folder: &OutputFolder, stop: &AtomicBool) -> Result<Answer, Failure> {
        let trials = self.args.trials.unwrap_or(self.mission.study.monte_carlo.trials as u64);
        let workers = self.workers();
        let (mut kept, there) = KeptDrops::open(self, folder, self.args.resume)?;
        kept.refuse_beyond(trials, &there)?;
        let done: BTreeSet<u64> = there.keys().copied().collect();
        let csv = format!("{}.csv", self.name());
        let mut file = folder.continued(&csv, 0)?;
        let mut write = |text: &str| file.write_all(text.as_bytes()).context(csv.clone()).bad_input();
        write(&header(&self.mission, self.pilot.name()))?;
        let (next, mut tally) = (AtomicU64::new(0), DropTally::default());
        let mut summary = CampaignSummary::default();
        let (over, comes) = mpsc::channel();
        let written = std::thread::scope(|scope| {
            for place in 0..workers {
                let (over, next, done) = (over.clone(), &next, &done);
                scope.spawn(move || {
                    while !stop.load(Ordering::Relaxed) {
                        let trial = next.fetch_add(1, Ordering::Relaxed);
                        if done.contains(&trial) {
                            continue;
                        }
                        // Nobody listens any more when a file could not be written.
                        if trial >= trials || over.send(self.trial(trial, place, stop)).is_err() {
                            break;
                        }
                    }
                });
            }
            drop(over);
            // Lines are in order, whichever trial is over first.
            let (mut early, mut wanted) = (there, 0);
            let mut take_those_in_order = |early: &mut BTreeMap<u64, DropTrial>| {
                while let Some(trial) = early.remove(&wanted) {
                    write(&row(&self.mission, &trial))?;
                    tally.push(&trial);
                    summary.push(&TrialRecord::of_drop(&trial));
                    if !done.contains(&wanted) {
                        Self::report(&trial, trials);
                    }
                    wanted += 1;
                }
                Ok::<(), Failure>(())
            };
            take_those_in_order(&mut early)?;
            for over in comes.into_iter().flatten() {
                if over.flown {
                    kept.keep(self, &over)?;
                }
                early.insert(over.trial.drawn.trial, over.trial);
                take_those_in_order(&mut early)?;
            }
            Ok::<(), Failure>(())
        });
        written?;
        let mut circumstances =
            vec![("trials", trials.to_string()), ("autopilot", self.pilot.name().to_owned())];
        circumstances.extend(kept.version().map(|version| ("autopilot_version", version.to_owned())));
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
            print_err(&format!(
                "stopped after {} of {trials} drops; the same command with --resume continues\n",
                kept.count()
            ));
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
                o.j_tpf.unwrap_or(f64::NAN),
                o.steady_after_s.unwrap_or(f64::NAN)
            ),
            (None, None) => "nothing".to_owned(),
        };
        print_err(&format!("trial {number} of {trials}: {text}\n"));
    }

    /// Flies a trial at one of the places; `None` when it was stopped. Whatever goes wrong is the trial's
    /// failure. The files of one that failed are kept.
    fn trial(&self, number: u64, place: u16, stop: &AtomicBool) -> Option<Over> {
        let drawn = self.mission.draw_drop(number);
        let failed = |why: &Failure| DropTrial { drawn, outcome: None, failure: Some(why.text()) };
        let scratch = self.folder.join(format!("place_{place}"));
        // The files of the trial that was flown here before are not this one's.
        let emptied = if scratch.is_dir() { remove_folder(&scratch) } else { Ok(()) };
        let made = emptied.and_then(|()| OutputFolder::create(Some(&scratch), &self.mission.name));
        let folder = match made {
            Ok(folder) => folder,
            Err(why) => return Some(Over { trial: failed(&why), flown: false, version: None }),
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
        let by = flown.as_ref().ok().and_then(|flown| flown.by.clone());
        Some(Over { trial, flown: flown.is_ok(), version: by.and_then(|by| by.version) })
    }

    /// Keeps the files of a trial that failed.
    fn keep(&self, trial: u64, folder: &OutputFolder) -> Result<(), Failure> {
        let kept = self.folder.join(format!("trial_{trial}"));
        remove_folder(&kept)?;
        fs::rename(folder.path(), &kept)
            .with_context(|| format!("cannot keep the files in {}", kept.display()))
            .bad_input()
    }
}
