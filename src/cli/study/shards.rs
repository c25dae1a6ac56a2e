//! A study in shards: `samara study KIND --shard I/N` flies a part of the jobs at hand, anywhere, any number
//! of times; `samara merge` puts all parts together, or says which are missing of the round at hand.

use std::fs;
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use anyhow::Context as _;

use super::asked::{PlanOf, StudyOf};
use super::hosted::Hosted;
use super::merge::{Merge, typed};
use super::noted;
use super::results;
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::args::PageArgs;
use crate::cli::aside::Aside;
use crate::cli::narrator::Narrator;
use crate::cli::planning::plan_mission;
use crate::cli::results::{OutputFolder, place_of};
use crate::cli::terminal::{print, print_err};
use samara::config::Mission;
use samara::host::shards::{Ended, ShardFiles, Shards};
use samara::plan::Status;
use samara::report::json::VERSION;
use samara::study::asked::{Asked, sha256_hex};
use samara::study::cut::ranges;
use samara::study::kind::Flies;
use samara::study::kinds::kind;

/// Folder of the parts within a study's.
const FOLDER: &str = "shards";
/// What a study in shards was asked, beside its parts.
const ASKED: &str = "study.json";

/// The study that was asked for, to be put together.
fn study_of(asked: &Asked, merge: &Merge) -> Result<StudyOf, String> {
    let kind = kind(&asked.study)?;
    let values = asked.values(kind.about().settings)?;
    let (args, wire) = typed(asked, merge)?;
    let wire = Some(wire).filter(|wire| wire.autopilot.is_some());
    Ok(StudyOf { kind, args, values, only: None, keep: false, page: PageArgs::NONE, wire })
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

/// Flies a part of the jobs at hand, or says which study it would be of.
pub fn run(study: &StudyOf, stop: &AtomicBool) -> Result<Answer, Failure> {
    let (about, args) = (study.kind.about(), &study.args);
    let narrator = Narrator::alone(true);
    let flown = study.flown(&narrator)?;
    let mission = &flown.mission;
    let head = about.head(mission, &study.values);
    let id = sha256_hex(&head);
    let asked =
        noted::asked((about.name, about.settings), &study.values, (args, study.wire.as_ref()), mission);
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
    let Some(planned) = planned(study, mission)? else { return Ok(Answer::No) };
    // Where drops over a wire keep their files while they fly.
    let aside = flown.pilot.as_ref().map(|_| Aside::begin(&folder.0.join("drops"))).transpose()?;
    let scratch = aside.as_ref().map(Aside::scratch);
    let ended = study.begin(&flown, planned.plan(), (scratch, stop), |of, threads| {
        let hosted = Hosted::new(study, (mission, &out), (threads, stop), of)?;
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
pub fn merge(merge: &Merge, only_missing: bool) -> Result<Answer, Failure> {
    let (dir, json) = (&merge.dir, merge.json);
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
    let expected = &asked.input_hash;
    let study = study_of(&asked, merge).map_err(|e| Failure::input(format!("{}: {e}", place())))?;
    let about = study.kind.about();
    let narrator = Narrator::alone(json || only_missing);
    let flown = study.flown(&narrator)?;
    let mission = &flown.mission;
    if mission.inputs.hash != *expected {
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
        true => planned(&study, mission)?,
        false => study.planned(mission, &out, &narrator)?,
    };
    let Some(planned) = planned else { return Ok(Answer::No) };
    let head = about.head(mission, &study.values);
    let stop = AtomicBool::new(false);
    study.begin(&flown, planned.plan(), (None, &stop), |of, threads| {
        let hosted = Hosted::new(&study, (mission, &out), (threads, &stop), of)?;
        match hosted.run_in_shards(of, Shards::new(&folder, &head, None))? {
            Ok(_) if only_missing => said(json, &serde_json::json!({ "missing": "" }), "").map(|()| Answer::Yes),
            Ok(found) => {
                results::write(&out, (mission, &about, &study.values), &found, &study.page)?;
                hosted.write_manifest()?;
                results::report(&study, (mission, &out), &found)
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
