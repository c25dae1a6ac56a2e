//! The campaigns: trials flown on all threads, written as they come, in order, and continued where a file of
//! them ends.
//!
//! Nothing but the statistics and the first [`SHOWN`] trials is kept, so a campaign of any length takes the
//! same memory.

use std::io::{BufRead as _, Write as _};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context, anyhow};

use crate::cli::answer::{BadInput as _, Failure};
use crate::cli::estimate::warn_in_space;
use crate::cli::narrator::Narrator;
use crate::cli::progress::ProgressLine;
use crate::cli::results::OutputFolder;
#[cfg(feature = "shards")]
use samara::assess::BlockError;
use samara::assess::{
    Limits, Outcome, RandomRelease, ReleaseDistribution, ReleaseTrends, SafetyStudy, Selection, StudyEntry,
    Summary, Tally, paper,
};
use samara::config::Mission;
use samara::host::kept::KeptRows;
use samara::host::{Host, Threads};
use samara::sim::ABREAST;
use samara::study::campaign::campaign_csv::{file_name, header, parse_row, write_row};
use samara::study::campaign::exact::{MeasurePasses, MeasureValues};
use samara::study::campaign::{CampaignSummary, Keep, SHOWN, TrialRecord};
use samara::study::jobs::{Jobs, Round, Stop};

/// Trials between two writes to the disk.
const BLOCK: u64 = 128;
/// Trials that a thread takes at a time.
const PORTION: u64 = 8;

/// What the trials of all campaigns share, and what flies them on all threads.
pub struct TrialRunner<'a> {
    pub mission: &'a Mission,
    /// The vehicle, the site and the plan.
    pub study: SafetyStudy,
    /// The distribution that releases are drawn from.
    pub distribution: ReleaseDistribution,
    /// Trials of each campaign.
    pub trials: u64,
    /// What makes a trial fail.
    pub limits: Limits,
    /// The trials whose lines are kept.
    pub keep: Keep,
    pub folder: &'a OutputFolder,
    /// The threads that trials are spread over.
    pub threads: Threads,
    /// Raised by Ctrl-C.
    pub stop: &'a AtomicBool,
}

impl TrialRunner<'_> {
    /// The release of a trial.
    pub fn draw(&self, trial: u64) -> RandomRelease {
        self.distribution.draw(self.mission.seed, trial)
    }

    /// Whether the numbers of all trials are sorted, for their quantiles.
    fn sorts(&self) -> bool {
        self.keep == Keep::All && self.trials <= Keep::ALL_MOST
    }

    /// Does something for each of `items` on all threads; the results are in the items' order.
    pub fn in_order<T: Sync, R: Send>(&self, items: &[T], f: impl Fn(&T) -> R + Send + Sync) -> Vec<R> {
        self.threads.each(items, f)
    }

    /// Warns how long `count` flights take where they are flown in six degrees of freedom.
    pub fn warn_of(&self, entry: &StudyEntry, count: u64) {
        let some: Vec<_> = (0..ABREAST as u64).map(|trial| self.draw(trial)).collect();
        let reason = self.study.one_at_a_time(entry, &some[..1]);
        if let Some(reason) = reason.filter(|_| count > 0) {
            let threads = self.threads.count();
            warn_in_space(&reason, (count, ABREAST), threads, || self.study.fly_releases(entry, &some));
        }
    }

    /// Flies trials on all threads; each goes to `take` in their order. Whether it came to the end; an error
    /// of `take` ends it.
    pub fn fly(
        &self,
        entry: &StudyEntry,
        trials: Range<u64>,
        progress: &ProgressLine,
        mut take: impl FnMut(RandomRelease, Outcome) -> Result<(), Failure>,
    ) -> Result<bool, Failure> {
        let failed = AtomicBool::new(false);
        let is_stopped = || self.stop.load(Ordering::Relaxed) || failed.load(Ordering::Relaxed);
        let mut host = Host::new(&self.threads, &is_stopped, progress, KeptRows::nowhere());
        let jobs: &mut dyn Jobs = &mut host;
        let (study, releases, seed) = (&self.study, &self.distribution, self.mission.seed);
        let fly = |some: Range<u64>, stop: Stop<'_>| {
            let drawn: Vec<_> = some.map(|k| releases.draw(seed, trials.start + k)).collect();
            (!stop()).then(|| study.fly_releases(entry, &drawn))
        };
        let (mut next, mut taken) = (trials.start, Ok(()));
        let flown = jobs.fold(entry.name, Round::of(trials.end - next, PORTION), &fly, |outcome| {
            if taken.is_ok() {
                taken = take(self.draw(next), outcome);
                failed.store(taken.is_err(), Ordering::Relaxed);
            }
            next += 1;
        });
        taken.map(|()| flown.is_ok())
    }
}

/// A campaign that is done.
pub struct FlownCampaign {
    /// The controller that is judged, and what it follows.
    pub entry: StudyEntry,
    /// The statistics of J_TPF of the trials whose lines are kept, or were flown here.
    pub tally: Tally,
    /// All that the page of a mission's own campaigns shows.
    pub summary: CampaignSummary,
    /// The first [`SHOWN`] trials.
    pub shown: Vec<(RandomRelease, Outcome)>,
    /// Trials that were flown now, not read.
    pub flown_now: u64,
    /// The numbers of all trials, where they are few enough to be sorted.
    values: MeasureValues,
}

impl FlownCampaign {
    /// A campaign of no trials yet.
    pub fn new(entry: StudyEntry) -> Self {
        let (tally, summary) = (Tally::default(), CampaignSummary::default());
        Self { entry, tally, summary, shown: Vec::new(), flown_now: 0, values: MeasureValues::default() }
    }

    /// Takes the next trial; whether its line is kept.
    fn take(&mut self, release: RandomRelease, outcome: Outcome, runner: &TrialRunner<'_>) -> bool {
        let (limits, keep) = (&runner.limits, runner.keep);
        let record = TrialRecord::of_flight(release.trial, &outcome, limits);
        self.tally.push(outcome.j_tpf, limits.j_tpf_below);
        self.summary.push(&record);
        if runner.sorts() {
            self.values.push(&record);
        }
        if self.shown.len() < SHOWN {
            self.shown.push((release, outcome));
        }
        keep.keeps(record.failure.is_some())
    }

    /// Takes what is known of trials that were flown elsewhere: their statistics, and the first of them.
    #[cfg(feature = "shards")]
    pub fn append(
        &mut self,
        part: &CampaignSummary,
        shown: impl IntoIterator<Item = (RandomRelease, Outcome)>,
    ) -> Result<(), BlockError> {
        self.shown.extend(shown);
        self.summary.append(part)
    }

    /// Takes the numbers of a trial that was flown elsewhere and whose line is kept; its line.
    #[cfg(feature = "shards")]
    pub fn line(&mut self, release: &RandomRelease, outcome: &Outcome, runner: &TrialRunner<'_>) -> String {
        self.tally.push(outcome.j_tpf, runner.limits.j_tpf_below);
        if runner.sorts() {
            self.values.push(&TrialRecord::of_flight(release.trial, outcome, &runner.limits));
        }
        let mut text = String::new();
        write_row(&mut text, release, outcome);
        text
    }

    /// Finds the exact quantiles, where every trial is kept.
    pub fn find_quantiles(&mut self, runner: &TrialRunner<'_>) -> Result<(), Failure> {
        let values = std::mem::take(&mut self.values);
        let summary = &self.summary;
        let exact = if runner.sorts() {
            values.quantiles()
        } else if runner.keep == Keep::All {
            let mut passes = MeasurePasses::new(summary.flown());
            for _ in 0..Selection::PASSES {
                let mut lines = self.lines(runner)?;
                for trial in 0..summary.end() {
                    let (release, outcome) = next_line(&mut lines, runner, trial)?;
                    passes.push(&TrialRecord::of_flight(release.trial, &outcome, &runner.limits));
                }
                passes.end_pass();
            }
            passes.quantiles()
        } else {
            return Ok(());
        };
        self.summary.exact = Some(exact);
        Ok(())
    }

    /// The lines of the trials in the campaign's file.
    fn lines(
        &self,
        runner: &TrialRunner<'_>,
    ) -> Result<impl Iterator<Item = std::io::Result<String>>, Failure> {
        let name = file_name(&self.entry);
        let head = header(runner.mission, &self.entry).lines().count();
        let file = runner.folder.open(&name)?.ok_or_else(|| anyhow!("{name} is gone")).bad_input()?;
        Ok(file.lines().skip(head))
    }

    /// Flies what is missing and appends it to the campaign's file; whether it came to the end.
    fn run(&mut self, kept: u64, runner: &TrialRunner<'_>, progress: &ProgressLine) -> Result<bool, Failure> {
        let name = file_name(&self.entry);
        let mut file =
            (runner.keep != Keep::Summary).then(|| runner.folder.continued(&name, kept)).transpose()?;
        let (entry, first) = (self.entry.clone(), self.summary.end());
        progress.skip(first);
        let mut text = String::new();
        let mut write = |text: &mut String| -> Result<(), Failure> {
            if let Some(file) = &mut file {
                file.write_all(text.as_bytes())
                    .with_context(|| format!("cannot write {}", runner.folder.path().join(&name).display()))
                    .bad_input()?;
            }
            text.clear();
            Ok(())
        };
        let whole = runner.fly(&entry, first..runner.trials, progress, |release, outcome| {
            if self.take(release, outcome, runner) {
                write_row(&mut text, &release, &outcome);
            }
            self.flown_now += 1;
            if release.trial % BLOCK == BLOCK - 1 { write(&mut text) } else { Ok(()) }
        })?;
        write(&mut text)?;
        Ok(whole)
    }

    /// Reads the trials of a file that a run has left; how many bytes of it are whole: 0 when there is none,
    /// or not even its head.
    fn read(&mut self, head: &str, runner: &TrialRunner<'_>) -> Result<u64, Failure> {
        let name = file_name(&self.entry);
        let path = runner.folder.path().join(&name);
        let place = |line: u64| format!("{}:{line}", path.display());
        let Some(mut file) = runner.folder.open(&name)? else { return Ok(0) };
        let (mut kept, mut number, mut line) = (0, 0, String::new());
        let mut head_lines = head.split_inclusive('\n');
        loop {
            line.clear();
            number += 1;
            file.read_line(&mut line).with_context(|| place(number)).bad_input()?;
            // The end, or a line that was being written when the run ended.
            if !line.ends_with('\n') {
                let whole_head = number > head.lines().count() as u64;
                return Ok(if whole_head { kept } else { 0 });
            }
            match head_lines.next() {
                Some(wanted) if wanted == line => {}
                Some(wanted) => {
                    return Err(Failure::input(format!(
                        "{}: this campaign is of other inputs; expected {:?}, found {:?}: start it anew without --resume, \
                         or in another folder with --out",
                        place(number),
                        wanted.trim_end(),
                        line.trim_end()
                    )));
                }
                None if self.summary.end() == runner.trials => {
                    return Err(Failure::input(format!(
                        "{}: there are more than {} trials in this file; ask for as many with --trials",
                        place(number),
                        runner.trials
                    )));
                }
                None => {
                    let release = runner.draw(self.summary.end());
                    let outcome =
                        parse_row(line.trim_end(), &release).with_context(|| place(number)).bad_input()?;
                    self.take(release, outcome, runner);
                }
            }
            kept += line.len() as u64;
        }
    }
}

/// Runs the campaigns one after the other, or what is missing of them; `None` when Ctrl-C stopped them.
pub fn run_all<const N: usize>(
    runner: &TrialRunner<'_>,
    entries: &[StudyEntry; N],
    resume: bool,
    narrator: &Narrator,
) -> Result<Option<[FlownCampaign; N]>, Failure> {
    let TrialRunner { mission, folder, trials, .. } = *runner;
    let mut campaigns = entries.clone().map(FlownCampaign::new);
    if resume {
        if runner.keep != Keep::All {
            return Err(Failure::input(format!(
                "--resume: it goes on from the lines of all trials, which a campaign of more than {} keeps with `--keep all` \
                 alone; expected that, or shards (--shard)",
                Keep::ALL_MOST
            )));
        }
        let files = entries.iter().map(|entry| folder.open(&file_name(entry)));
        if files.collect::<Result<Vec<_>, _>>()?.iter().all(Option::is_none) {
            return Err(Failure::input(format!(
                "{}: no campaign to go on with; the folder of one that was stopped is expected (--out), or the same command without \
                 --resume",
                folder.path().display()
            )));
        }
    }
    if resume {
        folder.resume(entries.iter().map(file_name));
    }
    // All files first: what cannot be continued is refused before anything is flown, and none is left of
    // another run.
    let mut kept = [0; N];
    for (campaign, kept) in campaigns.iter_mut().zip(&mut kept) {
        let head = header(mission, &campaign.entry);
        *kept = if resume { campaign.read(&head, runner)? } else { 0 };
        if *kept == 0 && runner.keep != Keep::Summary {
            let name = file_name(&campaign.entry);
            folder.continued(&name, 0)?.write_all(head.as_bytes()).context(name).bad_input()?;
            *kept = head.len() as u64;
        }
    }
    let left: u64 = campaigns.iter().map(|campaign| trials - campaign.summary.end()).sum();
    if let Some(last) = entries.last() {
        runner.warn_of(last, left);
    }
    let progress = ProgressLine::new("assess", "flights", N as u64 * trials);
    for (campaign, kept) in campaigns.iter_mut().zip(kept) {
        if !campaign.run(kept, runner, &progress)? {
            progress.finish();
            narrator.say(&format!(
                "stopped after {} of {trials} trials of {}; the same command with --resume continues\n",
                campaign.summary.end(),
                campaign.entry.name
            ));
            narrator.check()?;
            return Ok(None);
        }
    }
    progress.finish();
    Ok(Some(campaigns))
}

/// J_TPF of `campaigns[1]` less that of `campaigns[0]`, release by release, read from their files.
pub fn paired_difference(
    runner: &TrialRunner<'_>,
    campaigns: [&FlownCampaign; 2],
) -> Result<Summary, Failure> {
    let mut difference = Summary::default();
    let (mut less, mut more) = (campaigns[0].lines(runner)?, campaigns[1].lines(runner)?);
    for trial in 0..campaigns[0].summary.end() {
        let (_, less) = next_line(&mut less, runner, trial)?;
        let (_, more) = next_line(&mut more, runner, trial)?;
        difference.push(more.j_tpf - less.j_tpf);
    }
    Ok(difference)
}

/// J_TPF of a campaign by the release, and its velocities at release and end, read from its file. Releases
/// are counted apart beyond the pitch of figure 10, and beyond the rate of a swing of that amplitude.
pub fn trends(runner: &TrialRunner<'_>, campaign: &FlownCampaign) -> Result<ReleaseTrends, Failure> {
    let omega_rad_s = runner.mission.study.monte_carlo.omega_rad_s;
    let beyond_rad = paper::FIGURE_10_PITCH_RAD;
    let mut trends = ReleaseTrends::new(beyond_rad, omega_rad_s * beyond_rad);
    let mut lines = campaign.lines(runner)?;
    for trial in 0..campaign.summary.end() {
        let (release, outcome) = next_line(&mut lines, runner, trial)?;
        trends.push(&release.state, &outcome);
    }
    Ok(trends)
}

/// The next line of a campaign's file, which is that of a trial.
fn next_line(
    lines: &mut impl Iterator<Item = std::io::Result<String>>,
    runner: &TrialRunner<'_>,
    trial: u64,
) -> Result<(RandomRelease, Outcome), Failure> {
    let release = runner.draw(trial);
    let line = lines.next().transpose().context("a campaign's file").bad_input()?.unwrap_or_default();
    let outcome = parse_row(&line, &release).context("a campaign's file").bad_input()?;
    Ok((release, outcome))
}
