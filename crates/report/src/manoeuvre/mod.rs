//! What to fly to find out what a vehicle is: a screen of text, a page, an object, and files to fly by.
//!
//! | file | holds |
//! |---|---|
//! | this one | what is recommended, and the errors to be expected |
//! | `script` | doublets, sweeps and climbs as a script that streams setpoints |
//! | `waypoints` | passes as a plan for QGroundControl |

mod script;
mod waypoints;

use samara_core::identify::{PARAMETERS, Parameter};
use samara_core::manoeuvre::{Bounds, Recipe, Trial, Wanted, missed};
use samara_core::model::Environment;
use samara_core::printable::printable;
use samara_core::units::DEG_PER_RAD;

use crate::document::{Document, Grid, Passage};
use crate::json::{VERSION, finite, result_objects, text};

/// PX4's parameters that log what is looked at, and what each does.
pub const LOGGING: [(&str, i32, &str); 2] = [
    ("SDLOG_PROFILE", 17, "commands to the motors, rates and accelerations at full rate, beside the usual"),
    ("SDLOG_MODE", 0, "a log from arming to disarming"),
];

/// What is recommended for a mission's vehicle.
pub struct ManoeuvreReport<'a> {
    /// Name of the mission.
    pub mission: &'a str,
    /// Name of the vehicle.
    pub vehicle: &'a str,
    /// Where it is flown.
    pub site: &'a Environment,
    /// What flights stay within.
    pub bounds: &'a Bounds,
    /// What was tried.
    pub trials: &'a [Trial],
    /// How many rounds of each.
    pub recipe: &'a Recipe,
    /// Standard errors to be expected.
    pub expected: &'a [f64; PARAMETERS],
    /// Those that are wanted.
    pub wanted: &'a Wanted,
}

impl ManoeuvreReport<'_> {
    /// Parameters whose expected errors are not those that are wanted.
    pub fn missed(&self) -> Vec<Parameter> {
        missed(self.expected, self.wanted)
    }

    fn rounds(&self) -> impl Iterator<Item = (usize, &Trial)> {
        self.recipe.rounds.iter().copied().zip(self.trials)
    }

    /// Errors of ordinary flight that lasts as long.
    fn ordinary(&self) -> [f64; PARAMETERS] {
        self.trials.first().map_or([f64::NAN; PARAMETERS], |trial| self.recipe.errors_alone(trial))
    }

    /// What there is to say.
    pub fn document(&self) -> Document {
        let mut flown = Grid::new("What to fly", ["", "rounds", "time", "tilt", "speed", "away", "lower"]);
        for (rounds, trial) in self.rounds() {
            let seen = &trial.seen;
            flown.row(
                trial.kind.words(),
                [
                    rounds.to_string(),
                    format!("{:.0} s", rounds as f64 * trial.round_s),
                    format!("{:.0} deg", seen.tilt_rad * DEG_PER_RAD),
                    format!("{:.1} m/s", seen.speed_m_s),
                    format!("{:.0} m", seen.away_m),
                    format!("{:.1} m", seen.below_m),
                ],
            );
        }
        let head = ["", "expected", "wanted", "ordinary flight as long"];
        let mut errors = Grid::new("Standard errors", head);
        let ordinary = self.ordinary();
        for parameter in Parameter::ALL {
            let i = parameter as usize;
            if !self.expected[i].is_nan() {
                let of = |x: f64| parameter.error_words(x);
                errors.row(parameter.words(), [of(self.expected[i]), of(self.wanted[i]), of(ordinary[i])]);
            }
        }
        let mut passages = vec![Passage::Table(flown), Passage::Table(errors)];
        let missed: Vec<&str> = self.missed().into_iter().map(Parameter::words).collect();
        if !missed.is_empty() {
            let why = "the longest flight within battery and bounds does not tell it so well in this air";
            passages.push(Passage::Remark(format!("Not reached: {}: {why}.", missed.join(", "))));
        }
        passages.push(Passage::Remark(AS_WELL_AS.to_owned()));
        passages
            .extend(LOGGING.map(|(name, value, why)| Passage::Remark(format!("Set {name} {value}: {why}."))));
        let lead = format!(
            "{} in the air of {}: {:.0} s of manoeuvres",
            printable(self.vehicle),
            printable(self.mission),
            self.recipe.length_s
        );
        let title = format!("What to fly: {}", printable(self.vehicle));
        Document::of_one(title, lead, passages)
    }

    /// The object of `--json`.
    pub fn json(&self) -> String {
        text(&ManoeuvreObject::of(self))
    }
}

const AS_WELL_AS: &str = "Errors are those of flights of this vehicle as it is known, with the mission's \
                          sensors and air: a real one vibrates more.";

/// A parameter of a report, with its place.
type Of<'a> = (&'a ManoeuvreReport<'a>, Parameter);

result_objects! {
    /// What to fly to identify a vehicle, as `samara identify --manoeuvre --json` prints it.
    ManoeuvreObject(of: &ManoeuvreReport<'_>) {
        /// Version of samara that made the result.
        version: String = VERSION.to_owned(),
        /// Name of the mission.
        mission: String = of.mission.to_owned(),
        /// Name of the vehicle.
        vehicle: String = of.vehicle.to_owned(),
        /// Length of all manoeuvres [s].
        length_s: f64 = of.recipe.length_s,
        /// Whether all errors are within those that are wanted.
        reached: bool = of.missed().is_empty(),
        /// The manoeuvres.
        manoeuvres: Vec<ManoeuvreKindObject> = of.rounds().map(|of| ManoeuvreKindObject::of(&of)).collect(),
        /// Numbers of the vehicle.
        numbers: Vec<ManoeuvreNumberObject> = numbers(of),
    }

    /// A manoeuvre.
    ManoeuvreKindObject(of: &(usize, &Trial)) {
        /// Name of the manoeuvre.
        name: String = of.1.kind.key().to_owned(),
        /// Rounds of it to fly.
        rounds: usize = of.0,
        /// Length of a round [s].
        round_s: f64 = of.1.round_s,
        /// Tilt that is asked for [deg].
        tilt_deg: f64 = of.1.sizes.tilt_rad * DEG_PER_RAD,
        /// Speed that is asked for [m/s].
        speed_m_s: f64 = of.1.sizes.speed_m_s,
        /// Largest tilt that was flown [deg].
        largest_tilt_deg: f64 = of.1.seen.tilt_rad * DEG_PER_RAD,
        /// Furthest from where it began, over ground [m].
        away_m: f64 = of.1.seen.away_m,
    }

    /// A number of the vehicle.
    ManoeuvreNumberObject(of: &Of<'_>) [
        let i = of.1 as usize;
    ] {
        /// Name of the number.
        name: String = of.1.key().to_owned(),
        /// Standard error to be expected: a share where the number is a factor's, otherwise [s] or [m].
        expected: Option<f64> = finite(of.0.expected[i]),
        /// Standard error that is wanted.
        wanted: Option<f64> = finite(of.0.wanted[i]),
        /// Standard error of hovers and climbs that last as long.
        ordinary: Option<f64> = finite(of.0.ordinary()[i]),
    }
}

fn numbers(of: &ManoeuvreReport<'_>) -> Vec<ManoeuvreNumberObject> {
    let has = |parameter: &Parameter| !of.expected[*parameter as usize].is_nan();
    Parameter::ALL.into_iter().filter(has).map(|one| ManoeuvreNumberObject::of(&(of, one))).collect()
}
