//! The conclusion of a flight, judged, written and reported: one for `samara drop`, `samara sim` and a
//! campaign's drops.

use anyhow::Context as _;

use super::answer::{Answer, BadInput as _, Failure};
use super::args::PageArgs;
use super::live::Live;
use super::narrator::Narrator;
use super::pilot::Flown;
use super::planning::Planned;
use super::results::OutputFolder;
use samara::assess::Verdict;
use samara::config::Mission;
use samara::report::{
    Attachment, DropRun, FlightCsv, FlownDrop, FlownReplan, FlownTrajectory, ShownDrop, drop_figure,
    drop_json, drop_mcap, drop_page, judge_drop, verdict_text,
};
use samara::study::hinted;

/// The parameters that PX4, or the model of it, was given for a drop.
pub const GIVEN_PARAMETERS: &str = "px4.params";

/// The files that the flight of a drop may leave; a drop removes those that it has not written.
pub const FLIGHT_FILES: [&str; 10] = [
    GIVEN_PARAMETERS,
    "flight.csv",
    "drop.json",
    "drop.svg",
    "drop.html",
    "drop.mcap",
    "hil.tlog",
    "vehicle.tlog",
    "companion.tlog",
    "flight.ulg",
];

/// A flight that is over, judged.
pub struct Conclusion<'a> {
    pub mission: &'a Mission,
    planned: Option<&'a Planned>,
    flown: &'a Flown,
    /// The verdict, if the vehicle was released.
    pub verdict: Option<Verdict>,
    /// What `drop.json` holds besides the verdict.
    pub run: DropRun,
    /// Whether `drop.html` is written.
    page: bool,
    /// Whether `drop.mcap` is written.
    mcap: bool,
}

impl<'a> Conclusion<'a> {
    /// Judges a flight; `planned`: what was to be flown, where that is known.
    pub fn new(mission: &'a Mission, planned: Option<&'a Planned>, flown: &'a Flown) -> Self {
        let (verdict, mut run) = judge_drop(
            mission,
            &FlownDrop {
                log: &flown.log,
                record: &flown.record,
                plan: planned.map(|planned| &planned.trajectory),
                by: flown.by.as_ref(),
                trouble: flown.trouble.as_deref(),
            },
        );
        if let Some(fall) = flown.fall {
            run.note_fall(fall);
        }
        run.replans = flown.replans.iter().map(FlownReplan::from).collect();
        run.hint = hinted::of_drop(mission, verdict.as_ref(), &run);
        Self { mission, planned, flown, verdict, run, page: true, mcap: false }
    }

    /// This conclusion with `drop.html` and `drop.mcap` or without them.
    pub fn with_page(self, args: &PageArgs) -> Self {
        Self { page: !args.no_html, mcap: args.mcap, ..self }
    }

    /// Writes the files of the flight, `drop.json` and the manifest of `verb`, whose circumstances are no
    /// inputs. Without a plan a flight that never began leaves the files of an earlier run alone.
    pub fn write(
        &mut self,
        verb: &str,
        circumstances: &[(&str, String)],
        folder: &OutputFolder,
    ) -> Result<(), Failure> {
        let flew = !self.flown.log.is_empty();
        if flew {
            self.write_flight(folder)?;
        } else if self.planned.is_none() {
            return Ok(());
        }
        if let Some(planned) = self.planned {
            let sha256 = folder.sha256("trajectory.csv")?;
            self.run.trajectory = Some(FlownTrajectory { source: planned.source.to_owned(), sha256 });
        }
        let object = self.file_json();
        folder.write_text("drop.json", &object)?;
        if flew && self.mcap {
            let ground = self.mission.site.ground.is_some();
            write_mcap(folder, "drop.mcap", &self.shown(), ground, Some(object))?;
        }
        if self.planned.is_some() {
            folder.remove_leftovers(&FLIGHT_FILES)?;
        }
        let version = self.flown.by.as_ref().and_then(|by| by.version.clone());
        let mut circumstances = circumstances.to_vec();
        circumstances.extend(version.map(|version| ("autopilot_version", version)));
        folder.write_manifest(verb, self.mission, &circumstances)
    }

    /// Writes `flight.csv`, `drop.svg` and `drop.html`.
    fn write_flight(&self, folder: &OutputFolder) -> Result<(), Failure> {
        let Self { mission, flown: Flown { log, .. }, .. } = self;
        folder.write("flight.csv", |out| {
            let mut csv = FlightCsv::new(out, mission, mission.site.ground.is_some())?;
            log.iter().try_for_each(|sample| csv.write(sample))?;
            csv.finish().map(|_| ())
        })?;
        let shown = self.shown();
        let figure = drop_figure(&shown).context("the figure of the drop")?;
        folder.write_text("drop.svg", &figure)?;
        if self.page {
            folder.write_text("drop.html", &drop_page(&shown))?;
        }
        Ok(())
    }

    fn shown(&self) -> ShownDrop<'_> {
        ShownDrop {
            mission: self.mission,
            title: &self.mission.name,
            gains: &self.mission.control.gains_name,
            samples: &self.flown.log,
            plan: self.planned.map(|planned| &planned.trajectory),
            verdict: self.verdict.as_ref(),
            run: &self.run,
        }
    }

    /// Shows those who look on what the flight came to.
    pub fn show(&self, live: &Live) {
        live.judged(&self.shown(), self.answer() == Answer::Yes);
    }

    /// Reports how the flight ended, the verdict and where the files are.
    pub fn report(&self, narrator: &Narrator, folder: &OutputFolder) -> Result<(), Failure> {
        let Self { mission, run, flown, .. } = self;
        let duration_s = mission.duration_s;
        if !run.course.completed {
            narrator.say(&format!(
                "stopped at {:.3} s of {duration_s} s: files and verdict are of what was flown\n",
                run.ended_at_s
            ));
        } else if self.verdict.as_ref().is_some_and(|v| v.plan_cut) {
            narrator.say(&format!(
                "the mission's duration_s, {duration_s} s, ended before the plan did: whether it becomes steady is not known\n"
            ));
        }
        match &self.verdict {
            Some(verdict) => {
                let last = flown.log.last();
                let powered_from_s = last.and_then(|sample| Some(sample.t_s - sample.t_powered_s?));
                narrator.steady(verdict, mission, powered_from_s);
                let text = verdict_text(verdict, &mission.limits, run.misses_steady_flight(verdict));
                narrator.say(&format!("\n{text}\nresults in {}\n", folder.path().display()));
                if let Some(factor) = flown.real_time_factor {
                    narrator.say(&format!("flown at {factor:.0} times real time\n"));
                }
            }
            None if run.course.completed => narrator.say(&format!(
                "the vehicle was never released within the mission's {duration_s} s: check the release trigger, hang_s and what the \
                 vehicle said above\n"
            )),
            None => narrator.say("the vehicle had not been released\n"),
        }
        if !run.replans.is_empty() {
            let renewed = run.replans.iter().filter(|replan| replan.renewed).count();
            let kept = run.replans.len() - renewed;
            narrator.say(&format!("plan renewed {renewed} times, kept {kept} times\n"));
        }
        if run.course.failsafe {
            narrator
                .say("a failsafe of the autopilot flew part of the manoeuvre: this is no drop by the plan\n");
        }
        if let Some(sentence) = run.sentence(self.verdict.as_ref()) {
            narrator.say(&format!("{sentence}\n"));
        } else {
            let words = [("faults", run.fault_words()), ("commanded", run.command_words())];
            for (name, words) in words.into_iter().filter_map(|(name, words)| Some((name, words?))) {
                narrator.say(&format!("{name}: {words}\n"));
            }
        }
        if let Some(hint) = &run.hint {
            narrator.say(&hint.lines());
        }
        narrator.check()
    }

    /// Yes: judged, within the limits, to the end and steady there, by the plan alone.
    pub fn answer(&self) -> Answer {
        Answer::from(self.run.is_safe(self.verdict.as_ref()))
    }

    /// The object of `drop.json`, which holds no durations.
    pub fn file_json(&self) -> String {
        drop_json(self.mission, self.verdict.as_ref(), &self.run)
    }

    /// The object of `--json`.
    pub fn json(&self) -> String {
        let plan_solve_ms = self.planned.and_then(|planned| planned.solve_ms);
        let real_time_factor = self.flown.real_time_factor;
        let run = DropRun { plan_solve_ms, real_time_factor, ..self.run.clone() };
        drop_json(self.mission, self.verdict.as_ref(), &run)
    }
}

/// Writes a flight for Foxglove, Rerun and PlotJuggler, with the files that it was made of and the object of
/// `drop.json`, where there is one; `ground`: whether it has the forces of the ground.
pub fn write_mcap(
    folder: &OutputFolder,
    name: &str,
    shown: &ShownDrop<'_>,
    ground: bool,
    drop_json: Option<String>,
) -> Result<(), Failure> {
    let results = drop_json.map(|text| ("drop.json".to_owned(), text));
    let attached = results.into_iter().chain(shown.mission.input_texts(shown.gains).bad_input()?);
    let attached: Vec<Attachment> = attached.map(|(name, text)| Attachment { name, text }).collect();
    folder.write(name, |out| drop_mcap(out, shown, ground, &attached).map(|_| ()))?;
    Ok(())
}
