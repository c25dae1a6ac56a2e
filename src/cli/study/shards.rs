//! A study in shards: `samara study KIND --shard I/N` flies a part of the jobs at hand, anywhere, any number
//! of times; `samara merge` puts all parts together, or says which are missing of the round at hand.

use std::fs;
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use anyhow::Context as _;
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use super::args::{PartArgs, StudyArgs};
use super::asked::{PlanOf, StudyOf};
use super::hosted::Hosted;
use super::results;
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::args::{ChoiceArgs, MissionArgs, PageArgs, ParentArgs, SetArgs};
use crate::cli::aside::Aside;
use crate::cli::narrator::Narrator;
use crate::cli::planning::plan_mission;
use crate::cli::results::{OutputFolder, place_of};
use crate::cli::terminal::{print, print_err};
use samara::config::Mission;
use samara::host::shards::{Ended, ShardFiles, Shards};
use samara::plan::Status;
use samara::report::json::VERSION;
use samara::study::cut::ranges;
use samara::study::kind::Flies;
use samara::study::kinds::kind;
use samara::study::settings::Values;

/// Folder of the parts within a study's.
const FOLDER: &str = "shards";
/// What a study in shards was asked, beside its parts.
const ASKED: &str = "study.json";

/// A study in shards as it was asked, for whoever puts it together.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
struct Asked {
    /// Name of the kind.
    study: String,
    /// Version of samara that flies it.
    version: String,
    /// The mission, as it was typed.
    mission: PathBuf,
    /// SHA-256 of all inputs, hexadecimal.
    input_hash: String,
    gains: Option<String>,
    params: Option<PathBuf>,
    seed: u64,
    case: Option<String>,
    /// Other values of keys, as `--set` takes them.
    set: Vec<String>,
    /// Names and texts of the settings.
    settings: Vec<(String, String)>,
}

impl Asked {
    fn of(study: &StudyOf, mission: &Mission) -> Self {
        let ChoiceArgs { gains, params, case, set, .. } = &study.args.choice;
        let settings = study.values.in_order(study.kind.about().settings);
        Self {
            study: study.kind.about().name.to_owned(),
            version: VERSION.to_owned(),
            mission: study.args.mission.mission.clone(),
            input_hash: mission.inputs.hash.clone(),
            gains: gains.clone(),
            params: params.clone(),
            seed: mission.seed,
            case: case.clone(),
            set: set.set.iter().map(ToString::to_string).collect(),
            settings: settings.into_iter().map(|(name, text)| (name.to_owned(), text)).collect(),
        }
    }

    /// The study that was asked for, in a folder.
    fn study(self, folder: &Path, mission: Option<&Path>, json: bool) -> Result<StudyOf, String> {
        let kind = kind(&self.study)?;
        let table = kind.about().settings;
        let mut values = Values::usual(table);
        for (name, text) in &self.settings {
            values.put(table, name, text).map_err(|e| format!("settings.{name}: {e}"))?;
        }
        let set = self.set.iter().map(|text| text.parse()).collect::<Result<_, String>>();
        let choice = ChoiceArgs {
            gains: self.gains,
            params: self.params,
            seed: Some(self.seed),
            set: SetArgs { set: set.map_err(|e| format!("set: {e}"))? },
            case: self.case,
        };
        let mission = mission.map_or(self.mission, Path::to_owned);
        let args = StudyArgs {
            mission: MissionArgs { mission, out: Some(folder.to_owned()), json },
            resume: false,
            part: PartArgs::default(),
            threads: None,
            parent: ParentArgs::default(),
            choice,
        };
        Ok(StudyOf { kind, args, values, only: None, page: PageArgs::NONE, wire: None })
    }
}

/// The folder of the parts.
struct Folder(PathBuf);

impl Folder {
    fn made(out: &Path) -> Result<Self, Failure> {
        let folder = out.join(FOLDER);
        let made = fs::create_dir_all(&folder);
        made.with_context(|| format!("cannot make the folder {}", folder.display())).bad_input()?;
        let made = Self(folder);
        let names = made.names().with_context(|| made.0.display().to_string()).bad_input()?;
        match names.iter().find(|name| name.ends_with(".parquet")) {
            None => Ok(made),
            Some(name) => Err(Failure::input(format!(
                "{}: a shard of a campaign lies there; another folder (--out) is expected",
                made.0.join(name).display()
            ))),
        }
    }

    /// Notes what is asked, or refuses what is not what was.
    fn note(&self, asked: &Asked) -> Result<(), Failure> {
        let path = self.0.join(ASKED);
        let text = serde_json::to_string_pretty(asked).context("what is asked")? + "\n";
        match self.read(ASKED).with_context(|| path.display().to_string()).bad_input()? {
            Some(found) if found == text => Ok(()),
            Some(_) => Err(Failure::input(format!(
                "{}: another study is flown in this folder; another one (--out) is expected",
                path.display()
            ))),
            None => self.write(ASKED, &text).with_context(|| path.display().to_string()).bad_input(),
        }
    }
}

impl ShardFiles for Folder {
    fn names(&self) -> io::Result<Vec<String>> {
        let entries = fs::read_dir(&self.0)?.collect::<io::Result<Vec<_>>>()?;
        Ok(entries.into_iter().filter_map(|entry| entry.file_name().into_string().ok()).collect())
    }

    fn read(&self, name: &str) -> io::Result<Option<String>> {
        let mut bytes = Vec::new();
        match fs::File::options().read(true).open(self.0.join(name)) {
            Ok(mut file) => file.read_to_end(&mut bytes)?,
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(e) => return Err(e),
        };
        // What is no text is damaged.
        Ok(Some(String::from_utf8_lossy(&bytes).into_owned()))
    }

    fn write(&self, name: &str, text: &str) -> io::Result<()> {
        let mut aside = Aside::new(&self.0.join(name))?;
        let mut file = aside.taken()?;
        io::Write::write_all(&mut file, text.as_bytes())?;
        file.sync_all()?;
        aside.rename()
    }
}

/// Whether a folder holds shards of a study.
pub fn is_study(dir: &Path) -> bool {
    dir.join(FOLDER).join(ASKED).exists()
}

/// SHA-256 of what a study is, hexadecimal.
fn id_of(head: &str) -> String {
    Sha256::digest(head.as_bytes()).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Flies a part of the jobs at hand, or says which study it would be of.
pub fn run(study: &StudyOf, stop: &AtomicBool) -> Result<Answer, Failure> {
    let (about, args) = (study.kind.about(), &study.args);
    let narrator = Narrator::alone(true);
    let mission = study.mission(&narrator)?;
    let head = about.head(&mission, &study.values);
    let (id, asked) = (id_of(&head), Asked::of(study, &mission));
    let Some(cut) = args.part.shard else {
        // Whoever asks in a folder has it noted there, for the merge.
        if let Some(out) = &args.mission.out {
            Folder::made(out)?.note(&asked)?;
        }
        let object = serde_json::json!({ "campaign": id, "mission": mission.name, "seed": mission.seed, "asked": asked });
        print(&format!("{object:#}\n"))?;
        return Ok(Answer::Yes);
    };
    if let Some(expected) = args.part.campaign.as_ref().filter(|expected| **expected != id) {
        return Err(Failure::input(format!(
            "study {expected} is expected, this is {id}: {}; `--describe` has the rest",
            head.trim_end()
        )));
    }
    let out = OutputFolder::plain(&place_of(args.mission.out.as_deref(), &mission.name))?;
    let folder = Folder::made(out.path())?;
    folder.note(&asked)?;
    let Some(planned) = planned(study, &mission)? else { return Ok(Answer::No) };
    let ended = study.begin(&mission, planned.plan(), |of| {
        let hosted = Hosted::new(study, (&mission, &out), (args.threads, stop), of)?;
        hosted.run_in_shards(of, Shards::new(&folder, &head, Some(cut)))
    })?;
    match ended {
        Ok(_) => {
            let text = format!(
                "shard {cut}: every shard of the study is there: samara merge {}\n",
                out.path().display()
            );
            let object = serde_json::json!({ "study": about.name, "whole": true });
            print(&if args.mission.json { format!("{object:#}\n") } else { text })?;
            Ok(Answer::Yes)
        }
        Err(Some(Ended::Part { after, first, jobs, file, flown })) => {
            let path = folder.0.join(file);
            let (path, how) = (path.display(), if flown { "flown" } else { "there already" });
            let object = serde_json::json!({
                "study": about.name, "whole": false, "shard": cut.part, "of": cut.of, "after": after,
                "first": first, "jobs": jobs, "file": path.to_string(), "flown": flown,
            });
            let text = format!(
                "shard {cut} after {after} rows, {jobs} {} from {first} on: {how}, {path}\n",
                about.unit
            );
            print(&if args.mission.json { format!("{object:#}\n") } else { text })?;
            Ok(Answer::Yes)
        }
        Err(_) => {
            print_err(&format!("shard {cut}: stopped, not written\n"));
            Ok(Answer::No)
        }
    }
}

/// The plan that a study flies along, written nowhere; `None`, and said, where there is none.
fn planned(study: &StudyOf, mission: &Mission) -> Result<Option<PlanOf>, Failure> {
    if study.kind.about().flies == Flies::WithoutAPlan {
        return Ok(Some(PlanOf(None)));
    }
    let timed = plan_mission(mission, false)?;
    if timed.plan.status != Status::Converged {
        print_err(&format!("samara: {}: no plan to fly\n", mission.name));
        return Ok(None);
    }
    Ok(Some(PlanOf(Some(timed))))
}

/// Puts the shards of a study together, or says which are missing of the round at hand.
pub fn merge(
    dir: &Path,
    (mission, threads): (Option<&Path>, Option<u16>),
    (only_missing, json): (bool, bool),
) -> Result<Answer, Failure> {
    let folder = Folder(dir.join(FOLDER));
    let path = folder.0.join(ASKED);
    let place = || path.display().to_string();
    let text = folder.read(ASKED).with_context(place).bad_input()?.unwrap_or_default();
    let asked: Asked = serde_json::from_str(&text).with_context(place).bad_input()?;
    if asked.version != VERSION {
        let found = &asked.version;
        return Err(Failure::input(format!(
            "{}: shards by samara {VERSION} are expected, found some by {found}",
            place()
        )));
    }
    let expected = asked.input_hash.clone();
    let mut study =
        asked.study(dir, mission, json).map_err(|e| Failure::input(format!("{}: {e}", place())))?;
    study.args.threads = threads;
    let about = study.kind.about();
    let narrator = Narrator::alone(json || only_missing);
    let mission = study.mission(&narrator)?;
    if mission.inputs.hash != expected {
        let (file, found) = (mission.file.display(), &mission.inputs.hash);
        return Err(Failure::input(format!(
            "{file}: hash of the inputs {expected} is expected, as in the shards, found {found}: the mission that was flown is \
             needed, from where it was flown or with --mission"
        )));
    }
    let out = match only_missing {
        true => OutputFolder::plain(dir)?,
        false => OutputFolder::merged(about.manifest, Some(dir), &mission.name)?,
    };
    let planned = match only_missing {
        true => planned(&study, &mission)?,
        false => study.planned(&mission, &out, &narrator)?,
    };
    let Some(planned) = planned else { return Ok(Answer::No) };
    let head = about.head(&mission, &study.values);
    let stop = AtomicBool::new(false);
    study.begin(&mission, planned.plan(), |of| {
        let hosted = Hosted::new(&study, (&mission, &out), (threads, &stop), of)?;
        match hosted.run_in_shards(of, Shards::new(&folder, &head, None))? {
            Ok(_) if only_missing => said(json, &serde_json::json!({ "missing": "" }), "").map(|()| Answer::Yes),
            Ok(found) => {
                results::write(&out, (&mission, &about, &study.values), &found, &study.page)?;
                hosted.write_manifest()?;
                results::report(&study, (&mission, &out), &found)
            }
            Err(Some(Ended::Missing { after, jobs, of, parts })) if only_missing => {
                if of.is_none() && !json {
                    return Err(none_yet(dir));
                }
                let missing = ranges(&parts);
                let object = serde_json::json!({ "missing": missing, "of": of, "after": after, "jobs": jobs });
                said(json, &object, &missing).map(|()| Answer::Yes)
            }
            Err(Some(Ended::Missing { after, of: Some(of), parts, .. })) => Err(Failure::input(format!(
                "{}: shards {} of {of} are missing after {after} rows; `samara merge {} --missing` prints what is left to fly",
                folder.0.display(),
                ranges(&parts),
                dir.display()
            ))),
            Err(_) => Err(none_yet(dir)),
        }
    })
}

fn none_yet(dir: &Path) -> Failure {
    Failure::input(format!("{}: no shard of the round at hand is there yet", dir.join(FOLDER).display()))
}

fn said(json: bool, object: &serde_json::Value, text: &str) -> Result<(), Failure> {
    print(&if json { format!("{object:#}\n") } else { format!("{text}\n") })
}
