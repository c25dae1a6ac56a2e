//! A run's folder as it is looked at: what it holds, and its trials flown again by `samara assess --only`.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use anyhow::Context as _;
use serde::Deserialize;

use crate::cli::answer::{BadInput as _, Failure};
use crate::cli::args::parsed;
use crate::cli::assess::{self, AssessArgs};
use crate::cli::list::runs;
use crate::cli::terminal::held;
use samara::config::bounded::text_at_most;
use samara::config::{load_mission, mission_path};
use samara::study::card::command::{choice_words, sets};
use samara::study::card::manifest::{MANIFEST, RunManifest};
use samara::view::run::{CampaignTold, Run, RunTold, TrialTold};

/// Larger files are not shown [bytes].
const LARGEST: u64 = 256 << 20;
/// Trials of a campaign that are named.
const WORST: usize = 12;

/// A run's folder.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    /// The mission, where it is not found by the name that the run has for it.
    mission: Option<PathBuf>,
    told: RunTold,
    /// The manifest of each campaign.
    manifests: Vec<RunManifest>,
    /// Where trials are flown, one at a time.
    place: Mutex<PathBuf>,
}

/// What is read of the results of campaigns.
#[derive(Deserialize)]
struct Results {
    campaigns: Vec<Campaign>,
}

#[derive(Deserialize)]
struct Campaign {
    label: String,
    file: String,
    trials: u64,
    unsafe_trials: u64,
}

impl Folder {
    /// Reads a run's folder.
    pub fn read(path: &Path, mission: Option<PathBuf>) -> Result<Self, Failure> {
        let found = runs::in_folder(path)?;
        if found.is_empty() {
            let text =
                format!("{}: a run's folder is expected, there is no *{MANIFEST} in it", path.display());
            return Err(Failure::input(text));
        }
        let verdict =
            |run: &runs::Run| run.verdict.map_or(String::new(), |found| format!(": {}", found.words()));
        let lines = found
            .iter()
            .map(|run| format!("{} of {}{}, {}", run.verb, run.mission, verdict(run), run.written));
        let mut told =
            RunTold { folder: path.display().to_string(), lines: lines.collect(), ..RunTold::default() };
        told.pages = names_in(path, ".html")?;
        told.pages.sort_by_key(|name| {
            (FIRST.iter().position(|first| name.starts_with(first)).unwrap_or(FIRST.len()), name.clone())
        });
        let mut manifests = Vec::new();
        for name in names_in(path, MANIFEST)? {
            let Some(manifest) = read::<RunManifest>(&path.join(&name)) else { continue };
            let results = path.join(format!("{}.json", manifest.verb));
            let campaigns = read::<Results>(&results).map_or(Vec::new(), |results| results.campaigns);
            for campaign in campaigns {
                told.campaigns.push(told_of(path, campaign)?);
                manifests.push(manifest.clone());
            }
        }
        let place = std::env::temp_dir().join(format!("samara-view-{}", std::process::id()));
        Ok(Self { path: path.to_owned(), mission, told, manifests, place: Mutex::new(place) })
    }
}

/// What a page begins with that is looked at first.
const FIRST: [&str; 5] = ["card", "drop.", "assess", "drops_", "cases"];

/// Names of a folder's files that end so, in order.
fn names_in(folder: &Path, ending: &str) -> Result<Vec<String>, Failure> {
    let entries = fs::read_dir(folder).with_context(|| folder.display().to_string()).bad_input()?;
    let names = entries.flatten().filter_map(|entry| entry.file_name().into_string().ok());
    let mut names: Vec<String> = names.filter(|name| name.ends_with(ending)).collect();
    names.sort();
    Ok(names)
}

fn read<T: for<'de> Deserialize<'de>>(path: &Path) -> Option<T> {
    serde_json::from_str(&text_at_most(path, LARGEST).ok()?).ok()
}

/// A campaign with the worst lines of its table: those without a J_TPF, then those never steady, then by it.
fn told_of(folder: &Path, campaign: Campaign) -> Result<CampaignTold, Failure> {
    let Campaign { label, file, trials, unsafe_trials } = campaign;
    let text = text_at_most(&folder.join(&file), LARGEST).unwrap_or_default();
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let heads: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let column = |name: &str| heads.iter().position(|head| *head == name);
    let [trial, j_tpf, steady] = ["trial", "j_tpf", "steady_after_s"].map(column);
    let mut worst: Vec<TrialTold> = lines
        .filter_map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            let number = |at: Option<usize>| cells.get(at?)?.parse::<f64>().ok();
            let trial = cells.get(trial?)?.parse().ok()?;
            Some(TrialTold { trial, j_tpf: number(j_tpf), steady_after_s: number(steady) })
        })
        .collect();
    let badness = |told: &TrialTold| {
        let j_tpf = told.j_tpf.unwrap_or(f64::INFINITY);
        (j_tpf >= 1.0, told.steady_after_s.is_none(), j_tpf)
    };
    worst.sort_by(|a, b| {
        let ((a_over, a_never, a_j), (b_over, b_never, b_j)) = (badness(a), badness(b));
        (b_over, b_never).cmp(&(a_over, a_never)).then(b_j.total_cmp(&a_j)).then(a.trial.cmp(&b.trial))
    });
    worst.truncate(WORST);
    let name = file.trim_end_matches(".csv").to_owned();
    Ok(CampaignTold { name, label, trials, unsafe_trials, worst })
}

impl Run for Folder {
    fn told(&self) -> &RunTold {
        &self.told
    }

    fn page(&self, name: &str) -> Option<String> {
        text_at_most(&self.path.join(name), LARGEST).ok()
    }

    fn trial(&self, campaign: &str, trial: u64) -> Result<String, String> {
        let at = self.told.campaigns.iter().position(|known| known.name == campaign);
        let manifest = at.and_then(|at| self.manifests.get(at)).ok_or("there is no such campaign")?;
        let place = self.place.lock().map_err(|_| "an earlier flight has failed".to_owned())?;
        let found =
            self.fly_again(manifest, trial, &place).and_then(|()| page_of(&place, campaign, manifest));
        // What was flown is on the page; what is left is no result that anybody asked for.
        let _ = fs::remove_dir_all(&*place);
        found
    }
}

impl Folder {
    /// Flies a trial of the campaign of a manifest into a folder.
    fn fly_again(&self, manifest: &RunManifest, trial: u64, place: &Path) -> Result<(), String> {
        let by = |of: &BTreeMap<String, String>| of.get("autopilot").is_some_and(|by| by == "px4");
        if by(&manifest.choices) || by(&manifest.circumstances) {
            let mission = &manifest.mission;
            return Err(format!("PX4 flew it: samara assess {mission} --autopilot px4=DIR --only {trial}"));
        }
        let words = self.words(manifest, trial, place)?;
        let args = parsed::<AssessArgs>(&words).map_err(|failure| failure.text())?;
        let (answer, _) = held(|| assess::run(args));
        answer.map(|_| ()).map_err(|failure| failure.text())
    }

    /// What is typed after `samara` to fly a trial again.
    fn words(&self, manifest: &RunManifest, trial: u64, place: &Path) -> Result<Vec<String>, String> {
        let mission = self.mission.as_deref().unwrap_or_else(|| Path::new(&manifest.mission));
        let path = mission_path(mission).map_err(|error| format!("{error}; --mission names it"))?;
        let own = load_mission(&path).map_err(|error| error.to_string())?.control.gains_name;
        let mut words = vec!["assess".to_owned(), mission.display().to_string()];
        words.extend(sets(&manifest.choices).flat_map(|set| ["--set".to_owned(), set]));
        words.extend(choice_words(manifest, &self.path));
        let mut add = |option: &str, value: &str| words.extend([option.to_owned(), value.to_owned()]);
        if manifest.gains != own {
            add("--gains", &manifest.gains);
        }
        // The reference autopilot is a circumstance, any other one a choice.
        let autopilot = manifest.circumstances.get("autopilot");
        if let Some(autopilot) = autopilot.filter(|_| !manifest.choices.contains_key("autopilot")) {
            add("--autopilot", autopilot);
        }
        add("--only", &trial.to_string());
        add("--out", &place.display().to_string());
        Ok(words)
    }
}

/// The page of what was flown into a folder, if it is a trial of that campaign.
fn page_of(place: &Path, campaign: &str, manifest: &RunManifest) -> Result<String, String> {
    let flown = [place.to_owned()].into_iter().chain(folders_in(place));
    for folder in flown {
        let names = names_in(&folder, MANIFEST).map_err(|failure| failure.text())?;
        let Some(now) = names.first().and_then(|name| read::<RunManifest>(&folder.join(name))) else {
            continue;
        };
        if now.input_hash != manifest.input_hash {
            return Err(format!(
                "{}: the mission of this name is not the one that was flown: what it names has changed since",
                manifest.mission
            ));
        }
        let pages = names_in(&folder, ".html").map_err(|failure| failure.text())?;
        // One for each campaign of flights from t = 0: campaign_optimal is trial_16_optimal.
        let of_campaign = campaign.strip_prefix("campaign_").map(|name| format!("_{name}.html"));
        let page = pages.iter().find(|name| of_campaign.as_ref().is_none_or(|ending| name.ends_with(ending)));
        if let Some(text) = page.and_then(|name| text_at_most(&folder.join(name), LARGEST).ok()) {
            return Ok(text);
        }
    }
    Err("the flight has left no page".to_owned())
}

fn folders_in(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries.map(|entry| entry.path()).filter(|path| path.is_dir()).collect()
}
