//! A drop of a log flown again by the log's commands to the rotors, from its state when they came free, as
//! far as that goes: nothing brings such a flight back once it is off.

use samara_core::assess::logged_drop::{LoggedDrop, NoDrop};
use samara_core::assess::{Course, VerdictBuilder};
use samara_core::frames::{conjugate, product, rotation_vector};
use samara_core::logged_flight::LoggedFlight;
use samara_core::sim::{PlantState, Sample};
use samara_core::units::DEG_PER_RAD;
use samara_mission::Mission;
use samara_report::json::{Head, object, text};
use samara_report::{DropRun, ShownDrop, drop_page_beside};

use super::seconds::{by_commands, fly};

/// A flight that is further off its log than this has left it [m/s, deg].
const OFF_M_S: f64 = 1.0;
const OFF_DEG: f64 = 10.0;
/// What a replay would want of a log, whether it is there, and what stands in its place.
type Wanted = (&'static str, fn(&LoggedFlight) -> bool, &'static str);
const WANTED: [Wanted; 5] = [
    ("wind", |_| false, "the mission's mean wind"),
    ("speeds of the rotors", |log| log.rotor_speeds_rad_s.is_some(), "run from its commands, from rest"),
    ("the battery's voltage", |log| log.battery.is_some(), "the mission's battery"),
    ("density of the air", |log| log.density_kg_m3.is_some(), "the site's"),
    ("position", |log| log.position_ned_m.is_some(), "summed from its velocity"),
];

/// A drop of a log that was flown again.
#[derive(Clone, Debug, PartialEq)]
pub struct ReplayedLog {
    /// The drop of the log.
    pub drop: LoggedDrop,
    /// The samples: the log's to the end of the fall, then those that were flown.
    pub flown: Vec<Sample>,
    /// How long it stays near the log from t = 0 on [s], and how long there is of the log.
    pub near_s: [f64; 2],
    /// What the log lacks, with what stands in its place.
    pub lacks: Vec<String>,
}

impl ReplayedLog {
    /// A log's drop, flown again by a mission's vehicle.
    ///
    /// # Errors
    /// [`NoDrop`] where the log has no drop, or no commands in it.
    pub fn new(log: &LoggedFlight, mission: &Mission) -> Result<Self, NoDrop> {
        let gravity_m_s2 = mission.site.environment.gravity_m_s2;
        let drop = LoggedDrop::of(log, gravity_m_s2, mission.release.parachute.delay_s)?;
        let motors = log.motors.as_ref().ok_or(NoDrop::Lacks("commands to the rotors"))?;
        let first = drop.at_t0().ok_or(NoDrop::EndsInTheFall)?;
        let rest = |sample: &Sample| PlantState::rotors_at_rest(sample.state.body);
        let fall = drop.samples.iter().take_while(|sample| sample.t_s <= first.t_s);
        let mut flown: Vec<Sample> = fall.map(|sample| Sample { state: rest(sample), ..*sample }).collect();
        let (mut left_s, mut begins) = (None, 0);
        fly(&drop, mission, f64::INFINITY, &mut by_commands(motors), &mut |begin, flight, predicted| {
            begins += usize::from(begin.0);
            // Behind a gap in the commands it would begin anew.
            if begins > 1 {
                return;
            }
            let [a, b] = [flight, predicted].map(|sample| &sample.state.body);
            let turned = rotation_vector(product(conjugate(a.q_ned_from_body), b.q_ned_from_body));
            let is_off = (a.v_ned - b.v_ned).norm() > OFF_M_S || turned.norm() * DEG_PER_RAD > OFF_DEG;
            if is_off && left_s.is_none() {
                left_s = Some(flight.t_s - first.t_s);
            }
            flown.push(*predicted);
        });
        let last_s = |samples: &[Sample]| samples.last().map_or(0.0, |sample| sample.t_s - first.t_s);
        let near_s = [left_s.unwrap_or_else(|| last_s(&flown)), last_s(&drop.samples)];
        let lacks = WANTED.iter().filter(|(_, is_there, _)| !is_there(log));
        let lacks = lacks.map(|(what, _, instead)| format!("{what} ({instead})")).collect();
        if begins == 0 {
            return Err(NoDrop::Lacks("commands to the rotors in its drop"));
        }
        Ok(Self { flown, near_s, lacks, drop })
    }

    /// How far it went, in words.
    pub fn text(&self) -> String {
        let [near_s, all_s] = self.near_s;
        format!(
            "flown again by the log's commands to the rotors from its state at t = 0, without a controller: within {OFF_M_S} m/s \
             and {OFF_DEG} deg of the log for {near_s:.2} s of {all_s:.2} s\nthe log lacks: {}\n",
            self.lacks.join(", ")
        )
    }

    /// The object of `--json`.
    pub fn json(&self, mission: &Mission) -> String {
        text(&object! {
            #[serde(flatten)] head: Head::of(mission),
            released_s: self.drop.released_s,
            near_s: self.near_s[0],
            powered_s: self.near_s[1],
            lacks: &self.lacks,
        })
    }

    /// `drop.html` of what was flown, with the flight as its ghost; `log`: how that was named.
    pub fn page(&self, log: &str, mission: &Mission) -> String {
        let run = DropRun { course: Course::WHOLE, ..DropRun::default() };
        let verdict = |samples: &[Sample]| {
            let mut builder = VerdictBuilder::judging(mission.limits, mission.target_v_ned);
            samples.iter().for_each(|sample| builder.observe(sample));
            builder.finish()
        };
        let verdicts = [&self.drop.samples, &self.flown].map(|samples| verdict(samples));
        let title = format!("{log} flown again");
        let shown = |i: usize, title, samples| ShownDrop {
            mission,
            title,
            gains: "",
            samples,
            plan: None,
            verdict: verdicts[i].as_ref(),
            run: &run,
        };
        drop_page_beside(&shown(1, &title, &self.flown), &shown(0, log, &self.drop.samples))
    }
}
