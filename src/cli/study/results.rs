//! What is written and printed of a study.

use super::asked::StudyOf;
use super::noted;
use crate::cli::alone_flight::write_flight;
use crate::cli::answer::{Answer, Failure};
use crate::cli::args::PageArgs;
use crate::cli::results::OutputFolder;
use crate::cli::terminal::{print, print_err};
use samara::config::Mission;
use samara::report::hint::Hint;
use samara::study::kind::{About, Results};
use samara::study::settings::Values;

/// Writes the results of a study of this name.
pub fn write(
    folder: &OutputFolder,
    (mission, about, values): (&Mission, &About, &Values),
    results: &Results,
    page: &PageArgs,
) -> Result<(), Failure> {
    let name = about.name;
    folder.write_text(&format!("{name}.txt"), &results.text())?;
    folder.write_text(&format!("{name}.json"), &results.json)?;
    for (name, text) in &results.files {
        folder.write_text(name, text)?;
    }
    for figure in &results.figures {
        folder.write_text(&figure.file, &figure.svg)?;
    }
    folder.write_text(&format!("{name}.html"), &results.page(about, mission, values))?;
    if let Some(junit) = results.junit(about, mission) {
        folder.write_text(&format!("{name}_junit.xml"), &junit)?;
    }
    results.flights.iter().try_for_each(|flight| write_flight(folder, mission, flight, page))?;
    let absent: Vec<&str> = results.absent.iter().map(String::as_str).collect();
    folder.remove_leftovers(&absent)
}

/// Reports a study whose results are written.
pub fn report(
    of: &StudyOf,
    (mission, folder): (&Mission, &OutputFolder),
    results: &Results,
) -> Result<Answer, Failure> {
    results.remarks.iter().for_each(|remark| print_err(&format!("samara: {remark}\n")));
    let (document, json) = match &results.timed {
        Some((document, json)) => (document, json),
        None => (&results.document, &results.json),
    };
    let sentence = results.sentence.as_ref().map_or_else(String::new, |sentence| format!("{sentence}\n"));
    let place = folder.path();
    let again = results.again.as_ref().map_or_else(String::new, |file| {
        let about = of.kind.about();
        let mut asked = noted::asked((about.name, about.settings), &of.values, (&of.args, None), mission);
        asked.mission = of.args.mission.named(mission);
        let only = ["--only".to_owned(), place.join(file).display().to_string()];
        format!("again: {}\n", asked.command(&["study", &about.name.replace('_', "-")], only))
    });
    // A search that has found something better says which numbers stand at a wall, and nothing is mended.
    let noes = results.noes.iter().filter(|_| !results.holds);
    let hints: String = noes.map(|no| Hint::of(*no, mission).lines()).collect();
    let text = || format!("\n{}\n{again}results in {}\n{sentence}{hints}", document.text(), place.display());
    print(&if of.args.mission.json { json.clone() } else { text() })?;
    Ok(Answer::from(results.holds))
}

/// Reports why nothing was found.
pub fn nothing(of: &StudyOf, mission: &Mission, (what, why): (&str, &str)) -> Result<Answer, Failure> {
    print_err(&format!("samara: {why}\n"));
    if of.args.mission.json {
        let object = serde_json::json!({ "mission": mission.name, what: null, "reason": why });
        print(&format!("{object:#}\n"))?;
    }
    Ok(Answer::No)
}

/// Writes and reports one flight of a study that was flown again.
pub fn report_alone(
    of: &StudyOf,
    (mission, folder): (&Mission, &OutputFolder),
    name: &str,
    results: &Results,
) -> Result<Answer, Failure> {
    for (name, text) in &results.files {
        folder.write_text(name, text)?;
    }
    results.flights.iter().try_for_each(|flight| write_flight(folder, mission, flight, &of.page))?;
    folder.write_manifest("assess_only", mission, &[("only", name.to_owned())])?;
    let text = || format!("{}\n", results.document.text().trim_end());
    folder.print_result(of.args.mission.json, || results.json.clone(), text)?;
    Ok(Answer::from(results.holds))
}
