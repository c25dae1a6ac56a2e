//! A study in shards: `samara study KIND --shard I/N` flies a part of the jobs at hand, anywhere, any number
//! of times; `samara merge` puts all parts together, or says which are missing of the round at hand.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use super::args::now_spelt;
use super::asked::{Flown, PlanOf, StudyOf};
use super::hosted::{Hosted, Ran};
use super::merge::{Merge, typed};
use super::noted;
use super::parts_folder::{ASKED, FOLDER, PartsFolder};
use super::results;
use crate::cli::answer::{Answer, Failure};
use crate::cli::args::PageArgs;
use crate::cli::aside::Aside;
use crate::cli::narrator::Narrator;
use crate::cli::planning::plan_mission;
use crate::cli::results::{OutputFolder, place_of};
use crate::cli::terminal::{print, print_err};
use samara::config::Mission;
use samara::host::shards::{Ended, Shards};
use samara::plan::Status;
use samara::study::asked::{Asked, sha256_hex};
use samara::study::cut::{Cut, ranges};
use samara::study::kind::{Flies, Study, differences};
use samara::study::kinds::kind;

/// The study that was asked for, to be put together.
fn study_of(asked: &Asked, merge: &Merge) -> Result<StudyOf, String> {
    let kind = kind(&asked.study)?;
    let values = asked.values(kind.about().settings)?;
    let (args, wire) = typed(asked, merge)?;
    let wire = Some(wire).filter(|wire| wire.autopilot.is_some());
    Ok(StudyOf { kind, args, values, only: None, keep: false, page: PageArgs::NONE, wire })
}

/// What is asked, for whoever puts the parts together.
fn asked_of(study: &StudyOf, mission: &Mission, head: &str) -> Asked {
    let (about, args) = (study.kind.about(), (&study.args, study.wire.as_ref()));
    let asked = noted::asked((about.name, about.settings), &study.values, args, mission);
    Asked { head: head.to_owned(), ..asked }
}

/// Flies a part of the jobs at hand, or says which study it would be of.
pub fn run(study: &StudyOf, stop: &AtomicBool) -> Result<Answer, Failure> {
    let args = &study.args;
    let narrator = Narrator::alone(true);
    let flown = study.flown(&narrator)?;
    let mission = &flown.mission;
    let head = study.head(mission)?;
    let (id, asked) = (sha256_hex(&head), asked_of(study, mission, &head));
    let Some(cut) = args.part.shard else {
        // Whoever asks in a folder has it noted there, for the merge.
        if let Some(out) = &args.mission.out {
            PartsFolder::made(out)?.note(&asked, &head)?;
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
    let folder = PartsFolder::made(out.path())?;
    folder.note(&asked, &head)?;
    fly((study, &flown), (&out, &folder), (&head, cut), stop)
}

/// Flies a part of the jobs at hand to a folder of parts.
fn fly(
    (study, flown): (&StudyOf, &Flown),
    (out, folder): (&OutputFolder, &PartsFolder),
    (head, cut): (&str, Cut),
    stop: &AtomicBool,
) -> Result<Answer, Failure> {
    let (about, json, mission) = (study.kind.about(), study.args.mission.json, &flown.mission);
    let Some(planned) = planned(study, mission)? else { return Ok(Answer::No) };
    // Where drops over a wire keep their files while they fly.
    let aside = flown.pilot.as_ref().map(|_| Aside::begin(&folder.path.join("drops"))).transpose()?;
    let scratch = aside.as_ref().map(Aside::scratch);
    let ended = study.begin((flown, out.path()), planned.plan(), (scratch, stop), |of, threads| {
        let hosted = Hosted::new(study, (mission, out), (threads, stop), of)?;
        hosted.run_in_shards(of, Shards::new(folder, head, Some(cut)))
    })?;
    match ended {
        Ok(_) => {
            let text = format!(
                "shard {cut}: every shard of the study is there: samara merge {}\n",
                out.path().display()
            );
            let object = serde_json::json!({ "study": about.name, "whole": true });
            print(&if json { format!("{object:#}\n") } else { text })?;
            Ok(Answer::Yes)
        }
        Err(Some(Ended::Part { after, first, jobs, file, flown })) => {
            let path = folder.path.join(file);
            let (path, how) = (path.display(), if flown { "flown" } else { "there already" });
            let object = serde_json::json!({
                "study": about.name, "whole": false, "shard": cut.part, "of": cut.of, "after": after,
                "first": first, "jobs": jobs, "file": path.to_string(), "flown": flown,
            });
            let text =
                format!("shard {cut} after {after} rows, {jobs} jobs from {first} on: {how}, {path}\n");
            print(&if json { format!("{object:#}\n") } else { text })?;
            Ok(Answer::Yes)
        }
        Err(_) => {
            print_err(&format!("shard {cut}: stopped, not written\n"));
            Ok(Answer::No)
        }
    }
}

/// Flies a part of what a search asks about in the file `asked`, to that one's folder or below `out`; without
/// a part it is only looked whether the search would be the same here.
pub fn evaluate(
    (path, out): (&Path, Option<&Path>),
    cut: Option<Cut>,
    (threads, stop): (Option<u16>, &AtomicBool),
) -> Result<Answer, Failure> {
    let shards = path.parent().unwrap_or(Path::new(""));
    let dir = shards.parent().unwrap_or(Path::new(""));
    let merge = Merge { dir: dir.to_owned(), mission: None, json: false, threads };
    let (study, flown) = asked_for(path, &merge, true)?;
    let head = study.head(&flown.mission)?;
    let Some(cut) = cut else {
        print("the search is the same here\n")?;
        return Ok(Answer::Yes);
    };
    now_spelt("evaluate STUDY --shard I/N", "samara design|tune .. --shard I/N --out DIR");
    let out = OutputFolder::plain(out.unwrap_or(dir))?;
    let folder = PartsFolder { besides: Some(shards.to_owned()), ..PartsFolder::made(out.path())? };
    fly((&study, &flown), (&out, &folder), (&head, cut), stop)
}

/// Has others fly a search, round by round: says what is to be flown, or puts all of it together.
pub fn ask(study: &StudyOf, stop: &AtomicBool) -> Result<Answer, Failure> {
    let narrator = Narrator::alone(study.args.mission.json);
    let flown = study.flown(&narrator)?;
    let mission = &flown.mission;
    let (head, about) = (study.head(mission)?, study.kind.about());
    let dir = place_of(study.args.mission.out.as_deref(), &mission.name);
    let folder = PartsFolder::made(&dir)?;
    folder.note(&asked_of(study, mission, &head), &head)?;
    let out = OutputFolder::create(about.manifest, Some(&dir), &mission.name)?;
    let Some(planned) = study.planned(mission, &out, &narrator)? else { return Ok(Answer::No) };
    study.begin((&flown, out.path()), planned.plan(), (None, stop), |of, threads| {
        match put_together((study, of), (mission, &out), (&folder, &head), (threads, stop))? {
            Together::Whole(answer) => Ok(answer),
            Together::Missing { jobs, .. } => {
                now_spelt("--ask", "--shard I/N, and samara merge DIR");
                let asked = folder.path.join(ASKED);
                print_err(&format!(
                    "samara: to be flown: {jobs} jobs, samara evaluate {}\n",
                    asked.display()
                ));
                Ok(Answer::Asks)
            }
        }
    })
}

/// A study whose shards are put together, as far as they are there.
enum Together {
    Whole(Answer),
    /// Parts are missing of the round that follows so many rows.
    Missing {
        after: u64,
        jobs: u64,
        of: Option<u64>,
        parts: Vec<u64>,
    },
}

/// Puts the shards of a study together that was begun; writes and reports it, where all are there.
fn put_together(
    (study, begun): (&StudyOf, &dyn Study),
    (mission, out): (&Mission, &OutputFolder),
    (folder, head): (&PartsFolder, &str),
    (threads, stop): (Option<u16>, &AtomicBool),
) -> Result<Together, Failure> {
    let hosted = Hosted::new(study, (mission, out), (threads, stop), begun)?;
    match hosted.run_in_shards(begun, Shards::new(folder, head, None))? {
        Ok(Ran::Found { found, first_stage }) => {
            results::write(out, (mission, &study.kind.about(), &study.values), &found, &study.page)?;
            hosted.finish(&found, first_stage)?;
            results::report(study, (mission, out), &found).map(Together::Whole)
        }
        Ok(Ran::Nothing { of, why }) => results::nothing(study, mission, (of, &why)).map(Together::Whole),
        Err(Some(Ended::Missing { after, jobs, of, parts, .. })) => {
            Ok(Together::Missing { after, jobs, of, parts })
        }
        Ok(Ran::Stopped) | Err(_) => Ok(Together::Whole(Answer::No)),
    }
}

/// The study that a file asks for, to be put together, and what it flies.
fn asked_for(path: &Path, merge: &Merge, quiet: bool) -> Result<(StudyOf, Flown), Failure> {
    let asked = PartsFolder::asked(path)?;
    let named = |e: String| Failure::input(format!("{}: {e}", path.display()));
    let study = study_of(&asked, merge).map_err(named)?;
    let flown = study.flown(&Narrator::alone(quiet))?;
    let (mission, expected) = (&flown.mission, &asked.input_hash);
    if mission.inputs.hash != *expected {
        let (file, found) = (mission.file.display(), &mission.inputs.hash);
        return Err(Failure::input(format!(
            "{file}: hash of the inputs {expected} is expected, as in the shards, found {found}: the mission that was flown is \
             needed, from where it was flown or with --mission"
        )));
    }
    let here = study.head(mission)?;
    if here != asked.head {
        return Err(named(differences(&asked.head, &here).unwrap_or_default()));
    }
    Ok((study, flown))
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
    let (dir, json) = (merge.dir.as_path(), merge.json);
    let folder = PartsFolder::of(dir);
    let (study, flown) = asked_for(&folder.path.join(ASKED), merge, json || only_missing)?;
    let mission = &flown.mission;
    let head = study.head(mission)?;
    let stop = AtomicBool::new(false);
    if only_missing {
        let Some(planned) = planned(&study, mission)? else { return Ok(Answer::No) };
        let out = OutputFolder::plain(dir)?;
        let ended = study.begin((&flown, dir), planned.plan(), (None, &stop), |of, threads| {
            let hosted = Hosted::new(&study, (mission, &out), (threads, &stop), of)?;
            hosted.run_in_shards(of, Shards::new(&folder, &head, None))
        })?;
        return match ended {
            Ok(_) => said(json, &serde_json::json!({ "missing": "" }), ""),
            Err(Some(Ended::Missing { of: None, .. })) if !json => Err(none_yet(dir)),
            Err(Some(Ended::Missing { after, jobs, stem, of, parts })) => {
                let missing = ranges(&parts);
                let object = serde_json::json!({
                    "missing": missing, "of": of, "after": after, "jobs": jobs, "round": stem,
                });
                said(json, &object, &missing)
            }
            Err(_) => Err(none_yet(dir)),
        };
    }
    let narrator = Narrator::alone(json);
    let out = OutputFolder::merged(study.kind.about().manifest, Some(dir), &mission.name)?;
    let Some(planned) = study.planned(mission, &out, &narrator)? else { return Ok(Answer::No) };
    study.begin((&flown, dir), planned.plan(), (None, &stop), |of, threads| {
        match put_together((&study, of), (mission, &out), (&folder, &head), (threads, &stop))? {
            Together::Whole(answer) => Ok(answer),
            Together::Missing { of: None, .. } => Err(none_yet(dir)),
            Together::Missing { after, of: Some(of), parts, .. } => Err(Failure::input(format!(
                "{}: shards {} of {of} are missing after {after} rows; `samara merge {} --missing` prints what is left to fly",
                folder.path.display(),
                ranges(&parts),
                dir.display()
            ))),
        }
    })
}

fn none_yet(dir: &Path) -> Failure {
    Failure::input(format!("{}: no shard of the round at hand is there yet", dir.join(FOLDER).display()))
}

fn said(json: bool, object: &serde_json::Value, text: &str) -> Result<Answer, Failure> {
    print(&if json { format!("{object:#}\n") } else { format!("{text}\n") })?;
    Ok(Answer::Yes)
}
