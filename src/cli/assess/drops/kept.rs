//! A file for each drop of a campaign that is over, `<campaign>/trial_<K>.json`: written aside and renamed,
//! so that whatever ends a campaign loses no drop, and the next one goes on from them.

use std::collections::BTreeMap;
use std::fs;

use anyhow::Context as _;

use super::DropCampaign;
use crate::cli::answer::{BadInput as _, Failure};
use crate::cli::results::OutputFolder;
use samara::config::bounded::text_at_most;
use samara::study::drops::{DropTrial, TrialFile};

/// Larger files are not of a trial [bytes].
const TRIAL_MOST: u64 = 1 << 20;

/// A trial that is over.
pub struct Over {
    pub trial: DropTrial,
    /// Whether it was flown: one that could not even begin is flown when the campaign goes on.
    pub flown: bool,
    /// The version that the autopilot reports.
    pub version: Option<String>,
}

/// The drops of a campaign that have a file.
pub struct KeptDrops {
    folder: OutputFolder,
    /// The version of the autopilot, and the trial that it is known from.
    version: Option<(String, u64)>,
    count: u64,
}

impl KeptDrops {
    /// The drops that an earlier run has left, where the campaign goes on (`resume`); else those are removed.
    pub fn open(
        campaign: &DropCampaign<'_>,
        results: &OutputFolder,
        resume: bool,
    ) -> Result<(Self, BTreeMap<u64, DropTrial>), Failure> {
        let path = results.path().join(campaign.name());
        if resume && !path.is_dir() {
            return Err(Failure::input(format!(
                "{}: no campaign to go on with; the folder of one that was stopped is expected (--out), or the same \
                 command without --resume",
                path.display()
            )));
        }
        if !resume {
            results.clear_folder(&campaign.name())?;
        }
        let folder = results.part(&campaign.name(), campaign.name())?;
        let (mut kept, mut there) = (Self { folder, version: None, count: 0 }, BTreeMap::new());
        for trial in kept.numbers()? {
            let (trial, version) = kept.read(campaign, trial)?;
            kept.note(&trial, version)?;
            there.insert(trial.drawn.trial, trial);
        }
        Ok((kept, there))
    }

    /// Refuses a campaign of fewer trials than are there.
    pub fn refuse_beyond(&self, trials: u64, there: &BTreeMap<u64, DropTrial>) -> Result<(), Failure> {
        match there.last_key_value().filter(|(last, _)| **last >= trials) {
            None => Ok(()),
            Some((last, _)) => Err(Failure::input(format!(
                "{}: there are more than {trials} trials; ask for as many with --trials",
                self.folder.path().join(name_of(*last)).display()
            ))),
        }
    }

    /// Writes the file of a trial that was flown.
    pub fn keep(&mut self, campaign: &DropCampaign<'_>, over: &Over) -> Result<(), Failure> {
        let file =
            TrialFile::new(&campaign.mission, campaign.pilot.name(), over.version.as_deref(), &over.trial);
        self.note(&over.trial, over.version.clone())?;
        self.folder.write_text(&name_of(over.trial.drawn.trial), &file.to_json()).map(|_| ())
    }

    /// The version of the autopilot that flew them, where it reports one.
    pub fn version(&self) -> Option<&str> {
        self.version.as_ref().map(|(version, _)| version.as_str())
    }

    /// How many there are.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Counts a trial; one campaign is flown by one version.
    fn note(&mut self, trial: &DropTrial, version: Option<String>) -> Result<(), Failure> {
        let number = trial.drawn.trial;
        self.count += 1;
        match (&self.version, version) {
            (Some((known, first)), Some(version)) if *known != version => Err(Failure::input(format!(
                "{}: trial {number} was flown by {version}, trial {first} by {known}: the version that has flown the others \
                 is expected, or a campaign of its own (--out)",
                self.folder.path().display()
            ))),
            (None, Some(version)) => {
                self.version = Some((version, number));
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// Numbers of the trials that have a file, in order.
    fn numbers(&self) -> Result<Vec<u64>, Failure> {
        let path = self.folder.path();
        let entries = fs::read_dir(path)
            .and_then(Iterator::collect::<Result<Vec<_>, _>>)
            .with_context(|| format!("cannot read {}", path.display()))
            .bad_input()?;
        let names = entries.iter().filter_map(|entry| entry.file_name().into_string().ok());
        let number = |name: String| {
            let number = name.strip_prefix("trial_")?.strip_suffix(".json")?.parse().ok()?;
            (name == name_of(number)).then_some(number)
        };
        let mut numbers: Vec<u64> = names.filter_map(number).collect();
        numbers.sort_unstable();
        Ok(numbers)
    }

    fn read(&self, campaign: &DropCampaign<'_>, trial: u64) -> Result<(DropTrial, Option<String>), Failure> {
        let path = self.folder.path().join(name_of(trial));
        let text = text_at_most(&path, TRIAL_MOST);
        let text = text.with_context(|| format!("cannot read {}", path.display())).bad_input()?;
        let file = TrialFile::parse(&text, &campaign.mission, campaign.pilot.name(), trial)
            .with_context(|| format!("{}: cannot be resumed", path.display()))
            .bad_input()?;
        let version = file.autopilot_version.clone();
        Ok((file.into_trial(&campaign.mission), version))
    }
}

fn name_of(trial: u64) -> String {
    format!("trial_{trial}.json")
}
