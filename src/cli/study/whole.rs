//! A study flown by one process from its beginning to its end.

use std::sync::atomic::AtomicBool;

use super::asked::StudyOf;
use super::hosted::{self, Hosted};
use super::results;
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::narrator::Narrator;
use crate::cli::results::OutputFolder;
use samara::config::Mission;
use samara::study::kind::{Given, Study};

/// Flies the study, writes and reports it; or one of its flights again.
pub fn run(study: &StudyOf, stop: &AtomicBool) -> Result<Answer, Failure> {
    let (about, args) = (study.kind.about(), &study.args);
    if let (Some(_), Err(why)) = (&study.only, about.alone) {
        return Err(Failure::input(format!("--only: {why}")));
    }
    let narrator = Narrator::alone(args.mission.json);
    let mission = study.mission(&narrator)?;
    let verb = if study.only.is_some() { "assess_only" } else { about.manifest };
    let folder = OutputFolder::create(verb, args.mission.out.as_deref(), &mission.name)?;
    if args.resume {
        folder.resume([hosted::rows_of(about.name)]);
    }
    let Some(planned) = study.planned(&mission, &folder, &narrator)? else { return Ok(Answer::No) };
    if let Some(name) = &study.only {
        let own = study.own_mission()?;
        let given = Given { mission: &mission, own: own.as_ref(), plan: planned.plan() };
        let results = study.kind.alone(given, &study.values, name).bad_input()?;
        return results::report_alone(study, (&mission, &folder), name, &results);
    }
    study.begin(&mission, planned.plan(), |begun| {
        fly((study, begun), (&mission, &folder), (args.threads, stop), &narrator)
    })
}

/// Flies a study that was begun, writes and reports it.
pub fn fly(
    (study, begun): (&StudyOf, &dyn Study),
    (mission, folder): (&Mission, &OutputFolder),
    (threads, stop): (Option<u16>, &AtomicBool),
    narrator: &Narrator,
) -> Result<Answer, Failure> {
    let hosted = Hosted::new(study, (mission, folder), (threads, stop), begun)?;
    match hosted.run(begun)? {
        None => hosted.stopped(narrator),
        Some(found) => {
            results::write(folder, (mission, &study.kind.about(), &study.values), &found, &study.page)?;
            hosted.finish()?;
            results::report(study, (mission, folder), &found)
        }
    }
}
