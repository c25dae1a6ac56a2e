//! One trial of a campaign of whole drops: with all its files, or again and again.

use std::io::Write as _;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context as _;

use super::{DropCampaign, repeats_name};
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::conclusion::Conclusion;
use crate::cli::narrator::Narrator;
use crate::cli::results::OutputFolder;
use crate::cli::results::remove_folder;
use crate::cli::terminal::{print, print_err};
use samara::assess::repeats::{RepeatSpread, RepeatedFlight, repeat_position};
use samara::study::drops::repeats::{document, repeats_header, repeats_json, repeats_row};
use samara::study::drops::{DropTally, drops_json};

impl DropCampaign<'_> {
    /// Flies one trial, reported as `samara drop` reports it, all files kept.
    pub(super) fn only(
        &self,
        trial: u64,
        results: &OutputFolder,
        stop: &AtomicBool,
    ) -> Result<Answer, Failure> {
        let drawn = self.mission.draw_drop(trial);
        let folder = results.part("drop", format!("trial_{trial}"))?;
        let narrator = Narrator::together(self.of.args.mission.json);
        let mission = self.mission.with_drop(&drawn);
        let flown = self.fly(&mission, self.of.wire.instance, &folder, &narrator, stop)?;
        let conclusion = Conclusion::new(&mission, Some(&self.planned), &flown).with_page(&self.of.page);
        let trial = self.judge(&drawn, &conclusion);
        self.write(&drawn, conclusion, &folder, &narrator)?;
        let mut tally = DropTally::default();
        tally.push(&trial);
        print(&if self.of.args.mission.json {
            drops_json(&self.mission, self.pilot.name(), &tally)
        } else {
            let outcome = trial.failure.as_ref().map_or("ok".to_owned(), |why| format!("FAILED: {why}"));
            format!("trial {} of the campaign: {outcome}\n", drawn.trial)
        })?;
        Ok(Answer::from(!tally.any_failed()))
    }

    /// Flies one trial so many times, one after the other, and reports how far the flights lie apart.
    pub(super) fn repeat(
        &self,
        trial: u64,
        times: u64,
        folder: &OutputFolder,
        stop: &AtomicBool,
    ) -> Result<Answer, Failure> {
        self.pilot.check_instance(self.of.wire.instance)?;
        let name = repeats_name(self.pilot.as_ref(), trial);
        let csv = format!("{name}.csv");
        let mut file = folder.continued(&csv, 0)?;
        let mut write = |text: &str| file.write_all(text.as_bytes()).context(csv.clone()).bad_input();
        write(&repeats_header(&self.mission, self.pilot.name(), trial))?;
        let (drawn, scratch) = (self.mission.draw_drop(trial), self.folder.join("place_0"));
        let mission = self.mission.with_drop(&drawn);
        let (mut flights, mut failed, mut flown_times) = (Vec::new(), 0, 0);
        for number in 1..=times {
            remove_folder(&scratch)?;
            let place = OutputFolder::plain(&scratch)?;
            let flown = self.fly(&mission, self.of.wire.instance, &place, &Narrator::of_trial(trial), stop);
            if stop.load(Ordering::Relaxed) {
                break;
            }
            flown_times = number;
            let (flight, failure) = match &flown {
                Ok(flown) => {
                    let conclusion = Conclusion::new(&mission, Some(&self.planned), flown);
                    let judged = self.judge(&drawn, &conclusion);
                    let position_ned_m = repeat_position(&flown.log);
                    let flight = judged.outcome.map(|outcome| RepeatedFlight { outcome, position_ned_m });
                    (flight, judged.failure)
                }
                Err(why) => (None, Some(why.text())),
            };
            failed += u64::from(failure.is_some());
            write(&repeats_row(number, flight.as_ref(), failure.as_deref()))?;
            let words = match (&failure, &flight) {
                (Some(failure), _) => format!("FAILED: {failure}"),
                (None, Some(flight)) => format!("J_TPF {:.4}", flight.outcome.j_tpf),
                (None, None) => "nothing".to_owned(),
            };
            print_err(&format!("flight {number} of {times}: {words}\n"));
            flights.extend(flight);
        }
        let spread = RepeatSpread::of(&flights);
        let circumstances = [("trial", trial.to_string()), ("flights", flown_times.to_string())];
        folder.write_manifest(&name, &self.mission, &circumstances)?;
        print(&if self.of.args.mission.json {
            repeats_json(&self.mission, self.pilot.name(), trial, failed, &spread)
        } else {
            let table = document(&self.mission, self.pilot.name(), trial, &spread).text();
            let place = folder.path().join(&csv);
            format!("{table}{failed} of {flown_times} flights failed; lines in {}\n", place.display())
        })?;
        if flown_times < times {
            print_err(&format!("stopped after {flown_times} of {times} flights\n"));
        }
        remove_folder(&scratch)?;
        Ok(Answer::from(flown_times == times && failed == 0))
    }
}
