//! All trials of a campaign of whole drops: flown side by side, written as they come, in order.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::Write as _;
use std::ops::Range;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc;

use anyhow::Context as _;

use super::DropCampaign;
use super::kept::{KeptDrops, Over};
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::assess::command::{alone, command};
use crate::cli::assess::own::write_page;
use crate::cli::conclusion::Conclusion;
use crate::cli::narrator::Narrator;
use crate::cli::results::OutputFolder;
use crate::cli::results::remove_folder;
use crate::cli::terminal::{print, print_err};
use samara::assess::tracking;
use samara::study::campaign::exact::MeasureValues;
use samara::study::campaign::settings::CampaignSettings;
use samara::study::campaign::{CampaignReport, CampaignSummary, Keep, NamedCampaign, TrialRecord, json};
use samara::study::drops::{DropTally, DropTrial, document, drops_json, header, row};

/// Where the files of flights go.
pub struct Files<'a> {
    /// Folder of those that are being flown.
    pub scratch: &'a Path,
    /// Folder in which those of trials that failed are kept.
    pub kept: Option<&'a Path>,
}

impl DropCampaign<'_> {
    /// Flies what is missing of the campaign, writes and reports it.
    pub(super) fn fly_all(&self, folder: &OutputFolder, stop: &AtomicBool) -> Result<Answer, Failure> {
        let (CampaignSettings { trials, keep, .. }, _) = self.of.settings(&self.mission)?;
        let (mut kept, there) = KeptDrops::open(self, folder, self.of.args.resume)?;
        kept.refuse_beyond(trials, &there)?;
        let done: BTreeSet<u64> = there.keys().copied().collect();
        let csv = self.csv();
        let mut file = (keep != Keep::Summary).then(|| folder.continued(&csv, 0)).transpose()?;
        let mut write = |text: &str| match &mut file {
            Some(file) => file.write_all(text.as_bytes()).context(csv.clone()).bad_input(),
            None => Ok(()),
        };
        write(&header(&self.mission, self.pilot.name()))?;
        let (mut tally, mut summary) = (DropTally::default(), CampaignSummary::default());
        let (mut early, mut wanted, mut values) = (there, 0, MeasureValues::default());
        // Lines are in order, whichever trial is over first.
        let mut take_those_in_order = |early: &mut BTreeMap<u64, DropTrial>| {
            while let Some(trial) = early.remove(&wanted) {
                if keep.keeps(trial.failure.is_some()) {
                    write(&row(&self.mission, &trial))?;
                }
                let record = TrialRecord::of_drop(&trial);
                tally.push(&trial);
                summary.push(&record);
                if keep == Keep::All {
                    values.push(&record);
                }
                if !done.contains(&wanted) {
                    Self::report(&trial, trials);
                }
                wanted += 1;
            }
            Ok::<(), Failure>(())
        };
        take_those_in_order(&mut early)?;
        let files = Files { scratch: self.folder, kept: Some(self.folder) };
        self.fly_trials(0..trials, &done, &files, stop, |over| {
            if over.flown {
                kept.keep(self, &over)?;
            }
            early.insert(over.trial.drawn.trial, over.trial);
            take_those_in_order(&mut early)
        })?;
        summary.exact = (keep == Keep::All).then(|| values.quantiles());
        self.finish(folder, kept.version(), keep, (&tally, summary))?;
        let complete = tally.flown() == trials;
        if !complete {
            print_err(&format!(
                "stopped after {} of {trials} drops; the same command with --resume continues\n",
                kept.count()
            ));
        }
        // Last: a folder that cannot be removed takes no result away.
        for place in 0..self.workers() {
            remove_folder(&self.folder.join(format!("place_{place}")))?;
        }
        Ok(Answer::from(complete && !tally.any_failed()))
    }

    /// Flies those of the trials that are not done, side by side; each is taken as it is over, in any order.
    pub fn fly_trials(
        &self,
        trials: Range<u64>,
        done: &BTreeSet<u64>,
        files: &Files<'_>,
        stop: &AtomicBool,
        mut take: impl FnMut(Over) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let next = AtomicU64::new(trials.start);
        let (over, comes) = mpsc::channel();
        std::thread::scope(|scope| {
            for place in 0..self.workers() {
                let (over, next) = (over.clone(), &next);
                scope.spawn(move || {
                    while !stop.load(Ordering::Relaxed) {
                        let trial = next.fetch_add(1, Ordering::Relaxed);
                        if done.contains(&trial) {
                            continue;
                        }
                        // Nobody listens any more when a file could not be written.
                        if trial >= trials.end || over.send(self.trial(trial, place, files, stop)).is_err() {
                            break;
                        }
                    }
                });
            }
            drop(over);
            comes.into_iter().flatten().try_for_each(&mut take)
        })
    }

    /// Writes table, page and manifest of drops that are over, and reports them; the file of their lines,
    /// where any are kept, is there.
    pub fn finish(
        &self,
        folder: &OutputFolder,
        version: Option<&str>,
        keep: Keep,
        (tally, summary): (&DropTally, CampaignSummary),
    ) -> Result<(), Failure> {
        let csv = (keep != Keep::Summary).then(|| self.csv());
        let mut circumstances = self.of.circumstances(&self.mission)?;
        circumstances.push(("autopilot", self.pilot.name().to_owned()));
        circumstances.extend(version.map(|version| ("autopilot_version", version.to_owned())));
        if let Some(text) = self.pilot.parameters(&self.mission, &self.planned.trajectory)? {
            folder.write_text(&format!("{}.params", self.name()), &text)?;
        }
        let page = format!("{}.html", self.name());
        if tally.flown() > 0 {
            self.write_page(folder, summary, csv.clone())?;
        }
        folder.write_manifest(&self.name(), &self.mission, &circumstances)?;
        print(&if self.of.args.mission.json {
            drops_json(&self.mission, self.pilot.name(), tally)
        } else {
            let table = document(&self.mission, self.pilot.name(), tally).text();
            let lines = csv
                .map_or_else(String::new, |csv| format!("lines in {}, ", folder.path().join(csv).display()));
            let page = folder.path().join(&page);
            let (flown, failed) = (tally.flown(), tally.failed());
            let verdict = match failed {
                0 => format!("safe in all {flown} drops"),
                _ => format!("NOT safe: {failed} of {flown} drops failed"),
            };
            format!("{table}\n{lines}start with {}\n{verdict}\n", page.display())
        })
    }

    /// Name of the file of lines.
    pub fn csv(&self) -> String {
        format!("{}.csv", self.name())
    }

    /// Writes the page of the campaign and the object of its numbers.
    fn write_page(
        &self,
        folder: &OutputFolder,
        summary: CampaignSummary,
        csv: Option<String>,
    ) -> Result<(), Failure> {
        let (mission, name) = (&self.mission, self.name());
        let by = self.pilot.name();
        let report = CampaignReport {
            mission,
            flown_by: format!("{by}, whole drops from the hang to the end, with wind and sensor noise drawn"),
            command: command(self.of, mission)?,
            alone: Some(alone(self.of, mission)?),
            limits: mission.limits,
            plan_j_tpf: mission.integrated(&self.planned.trajectory).j_tpf,
            campaigns: vec![NamedCampaign {
                name: name.clone(),
                label: format!("{}, flown by {by}", mission.control.gains_name),
                summary,
                file: csv.clone(),
            }],
            cases: Vec::new(),
            tracking_period_s: tracking::control_period_s(&self.planned.trajectory),
        };
        let json = format!("{name}.json");
        folder.write_text(&json, &json::json(&report, None))?;
        let prefix = format!("{name}_");
        let files: Vec<String> = csv.into_iter().chain([json]).collect();
        write_page(folder, &report, [&name, &prefix], [], &files)
    }

    fn report(trial: &DropTrial, trials: u64) {
        let number = trial.drawn.trial;
        let text = match (&trial.failure, &trial.outcome) {
            (Some(failure), _) => format!("FAILED: {failure}"),
            (None, Some(o)) => {
                format!("J_TPF {:.4}, steady after {:.2} s", o.j_tpf, o.steady_after_s.unwrap_or(f64::NAN))
            }
            (None, None) => "nothing".to_owned(),
        };
        print_err(&format!("trial {number} of {trials}: {text}\n"));
    }

    /// Flies a trial at one of the places; `None` when it was stopped. Whatever goes wrong is the trial's
    /// failure. The files of one that failed are kept where there is a folder for them.
    fn trial(&self, number: u64, place: u16, files: &Files<'_>, stop: &AtomicBool) -> Option<Over> {
        let drawn = self.mission.draw_drop(number);
        let failed = |why: &Failure| DropTrial { failure: Some(why.text()), ..DropTrial::drawn(drawn) };
        let scratch = files.scratch.join(format!("place_{place}"));
        // The files of the trial that was flown here before are not this one's.
        let emptied = if scratch.is_dir() { remove_folder(&scratch) } else { Ok(()) };
        let made = emptied.and_then(|()| OutputFolder::plain(&scratch));
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
                    Conclusion::new(&mission, Some(&self.planned), flown).with_page(&self.of.page);
                (self.judge(&drawn, &conclusion), Some(conclusion))
            }
            Err(why) => (failed(why), None),
        };
        if let (Some(failure), Some(kept)) = (&mut trial.failure, files.kept) {
            let written =
                conclusion.map_or(Ok(()), |conclusion| self.write(&drawn, conclusion, &folder, &narrator));
            if let Err(why) = written.and_then(|()| keep_files(kept, number, &folder)) {
                *failure = format!("{failure}; {}", why.text());
            }
        }
        let by = flown.as_ref().ok().and_then(|flown| flown.by.clone());
        Some(Over { trial, flown: flown.is_ok(), version: by.and_then(|by| by.version) })
    }
}

/// Keeps the files of a trial that failed.
fn keep_files(place: &Path, trial: u64, folder: &OutputFolder) -> Result<(), Failure> {
    let kept = place.join(format!("trial_{trial}"));
    remove_folder(&kept)?;
    fs::rename(folder.path(), &kept)
        .with_context(|| format!("cannot keep the files in {}", kept.display()))
        .bad_input()
}
