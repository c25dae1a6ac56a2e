//! A run of the program as one looks at its folder: its pages, and the worst of its trials, flown again.

use std::fmt::Debug;

use serde::Serialize;

/// A run that is looked at. What it says and flies is its caller's affair: files are read there.
pub trait Run: Debug + Send + Sync {
    /// What is in the folder.
    fn told(&self) -> &RunTold;

    /// The text of one of its pages, by its name among [`RunTold::pages`]; `None`: it is gone.
    fn page(&self, name: &str) -> Option<String>;

    /// Flies a trial of one of its campaigns again and gives the flight's page.
    ///
    /// # Errors
    /// In words, why it cannot be flown.
    fn trial(&self, campaign: &str, trial: u64) -> Result<String, String>;
}

/// What is in a run's folder.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct RunTold {
    /// The folder.
    pub folder: String,
    /// Mission, verb and verdict of each of its runs, a line each.
    pub lines: Vec<String>,
    /// Names of its pages, the first to look at first.
    pub pages: Vec<String>,
    /// Campaigns in the folder.
    pub campaigns: Vec<CampaignTold>,
}

/// A campaign of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct CampaignTold {
    /// Name, which is that of its table without the ending.
    pub name: String,
    /// What was flown, in words.
    pub label: String,
    /// Number of trials.
    pub trials: u64,
    /// How many of them were not safe.
    pub unsafe_trials: u64,
    /// Those that came closest to a limit, or passed one, the worst first.
    pub worst: Vec<TrialTold>,
}

/// A trial of a campaign.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct TrialTold {
    /// Number of the trial.
    pub trial: u64,
    /// J_TPF; `None` where it has none.
    pub j_tpf: Option<f64>,
    /// Time to steady flight [s]; `None`: never.
    pub steady_after_s: Option<f64>,
}
