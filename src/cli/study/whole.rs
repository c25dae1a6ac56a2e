//! A study flown by one process from its beginning to its end.

use std::sync::atomic::AtomicBool;

use super::asked::StudyOf;
use super::hosted::{self, Hosted, Ran};
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
    let out = OutputFolder::create(verb, args.mission.out.as_deref(), &mission.name)?;
    if args.resume {
        out.resume([hosted::rows_of(about.name)]);
    }
    let Some(planned) = study.planned(mission, &out, &narrator)? else { return Ok(Answer::No) };
    if let Some(name) = &study.only {
        let own = study.own_mission()?;
        let (own, folder) = (own.as_ref(), Some(out.path()));
        let given = Given { mission, own, plan: planned.plan(), folder };
        let results = study.kind.alone(given, &study.values, name).bad_input()?;
        return results::report_alone(study, (mission, &out), name, &results);
    }
    study.begin((&flown, out.path()), planned.plan(), (Some(out.path()), stop), |begun, threads| {
        let hosted = Hosted::new(study, (mission, &out), (threads, stop), begun)?;
        hosted.warn(begun);
        match hosted.run(begun)? {
            Ran::Stopped => hosted.stopped(&narrator),
            Ran::Nothing { of, why } => results::nothing(study, mission, (of, &why)),
            Ran::Found { found, first_stage } => {
                results::write(&out, (mission, &about, &study.values), &found, &study.page)?;
                hosted.finish(&found, first_stage)?;
                results::report(study, (mission, &out), &found)
            }
        }
    })
}
