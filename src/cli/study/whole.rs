//! A study flown by one process from its beginning to its end.

use std::sync::atomic::AtomicBool;

use super::asked::StudyOf;
use super::hosted::{self, Hosted};
use super::results;
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::narrator::Narrator;
use crate::cli::results::OutputFolder;
use samara::study::kind::Given;

/// Flies the study, writes and reports it; or one of its flights again.
pub fn run(study: &StudyOf, stop: &AtomicBool) -> Result<Answer, Failure> {
    let (about, args) = (study.kind.about(), &study.args);
    let narrator = Narrator::alone(args.mission.json);
    let flown = study.flown(&narrator)?;
    let mission = &flown.mission;
    let verb = if study.only.is_some() { "assess_only" } else { about.manifest };
    let folder = OutputFolder::create(verb, args.mission.out.as_deref(), &mission.name)?;
    if args.resume {
        folder.resume([hosted::rows_of(about.name)]);
    }
    let Some(planned) = study.planned(mission, &folder, &narrator)? else { return Ok(Answer::No) };
    if let Some(name) = &study.only {
        let own = study.own_mission()?;
        let given = Given { mission, own: own.as_ref(), plan: planned.plan() };
        let results = study.kind.alone(given, &study.values, name).bad_input()?;
        return results::report_alone(study, (mission, &folder), name, &results);
    }
    study.begin(&flown, planned.plan(), (Some(folder.path()), stop), |begun, threads| {
        let hosted = Hosted::new(study, (mission, &folder), (threads, stop), begun)?;
        match hosted.run(begun)? {
            None => hosted.stopped(&narrator),
            Some(found) => {
                results::write(&folder, (mission, &about, &study.values), &found, &study.page)?;
                hosted.finish()?;
                results::report(study, (mission, &folder), &found)
            }
        }
    })
}
