//! What logs have told of a vehicle: a screen of text, a page, an object.

use samara_core::identify::{CHANNELS, Found, Identified, Parameter, Predicted};
use samara_core::model::{Motor, Vehicle};
use samara_core::printable::printable;

use crate::document::{Document, Figure, Grid, Passage, Section};
use crate::figure::identified_figure;
use crate::json::{VERSION, finite, result_objects, text};

/// What was identified, of which vehicle, from which logs.
pub struct IdentifyReport<'a> {
    /// Name of the vehicle that was known.
    pub base: &'a str,
    /// The vehicle that was known.
    pub vehicle: &'a Vehicle,
    /// Density for which thrusts are told [kg/m^3].
    pub density_kg_m3: f64,
    /// Names of the logs.
    pub logs: &'a [String],
    /// What they told.
    pub found: &'a Identified,
}

/// A number of a vehicle as it is shown: its unit, and what it was known to be.
struct Known {
    unit: &'static str,
    value: f64,
    /// Factor on a deviation that is none of a factor.
    scale: f64,
}

impl IdentifyReport<'_> {
    fn known(&self, parameter: Parameter) -> Known {
        let inertia = &self.vehicle.mass.inertia_kg_m2;
        let full = self.vehicle.rotor.static_load(self.vehicle.motor.omega_max_rad_s(), self.density_kg_m3);
        let taus_s = match self.vehicle.motor {
            Motor::FirstOrder { tau_up_s, tau_down_s, .. } => [tau_up_s, tau_down_s],
            Motor::EscDc(_) => [1.0 / self.vehicle.motor.fastest_rate_per_s(); 2],
        };
        let (unit, value, scale) = match parameter {
            Parameter::Thrust => ("N", full.thrust_n, 1.0),
            Parameter::Torque => ("N m", full.torque_nm, 1.0),
            Parameter::InertiaX => ("kg m^2", inertia.m11, 1.0),
            Parameter::InertiaY => ("kg m^2", inertia.m22, 1.0),
            Parameter::InertiaZ => ("kg m^2", inertia.m33, 1.0),
            Parameter::DragAlong | Parameter::DragAcross => ("of the base's", 1.0, 1.0),
            Parameter::LagUp => ("ms", 1e3 * taus_s[0], 1.0),
            Parameter::LagDown => ("ms", 1e3 * taus_s[1], 1.0),
            Parameter::Delay => ("ms", 0.0, 1e3),
            Parameter::CentreX | Parameter::CentreY => ("mm", 0.0, 1e3),
        };
        Known { unit, value, scale }
    }

    /// Value and ends of the interval in the unit of a number.
    fn numbers(&self, found: &Found) -> [f64; 3] {
        let known = self.known(found.parameter);
        let of = |x: f64| if found.parameter.is_factor() { x * known.value } else { x * known.scale };
        let [low, high] = found.interval();
        [of(found.value()), of(low), of(high)]
    }

    fn lead(&self) -> String {
        let logs: Vec<_> = self.logs.iter().map(|log| printable(log).into_owned()).collect();
        format!(
            "{} from {}: {} of {} numbers found, {:.0} s of flight looked at",
            printable(self.base),
            logs.join(", "),
            self.found.found.len(),
            self.found.found.len() + self.found.refused.len(),
            self.found.looked_at_s
        )
    }

    /// What there is to say: the vehicle, and how well it predicts.
    pub fn document(&self) -> Document {
        let title = format!("Identified: {}", printable(self.base));
        let mut told = vec![Passage::Table(self.table())];
        told.extend(self.reasons().into_iter().map(Passage::Remark));
        told.push(Passage::Remark(MASS.to_owned()));
        if self.found.of(Parameter::Delay).is_some() {
            told.push(Passage::Remark(DELAY.to_owned()));
        }
        told.extend(self.found.remarks.iter().cloned().map(Passage::Remark));
        let mut sections = vec![Section { id: "vehicle", title: "Vehicle", passages: told }];
        if !self.found.predicted.is_empty() {
            let mut passages = vec![Passage::Table(self.predictions())];
            if let Ok(svg) = identified_figure(&title, &self.found.shown) {
                let caption = "Measured (blue) and predicted (orange), a second at a time, in stretches that \
                               were not used for the vehicle that predicts.";
                let file = "identified.svg".to_owned();
                passages.push(Passage::Figure(Figure { file, caption: caption.to_owned(), svg }));
            }
            sections.push(Section { id: "prediction", title: "Prediction", passages });
        }
        Document {
            tab: title.clone(),
            title,
            lead: vec![Passage::Said(self.lead())],
            sections,
            ..Document::default()
        }
    }

    fn table(&self) -> Grid {
        let mut grid = Grid::new("What was found", ["", "unit", "base", "found", "95 % interval"]);
        for parameter in Parameter::ALL {
            let known = self.known(parameter);
            let base = short(known.value);
            if let Some(found) = self.found.of(parameter) {
                let [value, low, high] = self.numbers(found);
                let interval = format!("{} to {}", short(low), short(high));
                grid.row(parameter.words(), [known.unit.to_owned(), base, short(value), interval]);
            } else if self.found.refused.iter().any(|(one, _)| *one == parameter) {
                let not_told = [known.unit.to_owned(), base, "-".to_owned(), "not told".to_owned()];
                grid.row(parameter.words(), not_told);
            }
        }
        grid
    }

    /// Why a number is not told.
    fn reason(&self, parameter: Parameter) -> Option<String> {
        let of = self.found.refused.iter().find(|(one, _)| *one == parameter);
        of.map(|(_, why)| why.clone())
    }

    /// Why numbers are not told, those of one reason together.
    fn reasons(&self) -> Vec<String> {
        let mut reasons: Vec<(&str, Vec<&str>)> = Vec::new();
        for (parameter, why) in &self.found.refused {
            match reasons.iter_mut().find(|(reason, _)| reason == why) {
                Some((_, names)) => names.push(parameter.words()),
                None => reasons.push((why, vec![parameter.words()])),
            }
        }
        reasons.into_iter().map(|(why, names)| format!("Not told: {}: {why}.", names.join(", "))).collect()
    }

    fn predictions(&self) -> Grid {
        let head = ["", "rms error", "over the sensor's noise", "R^2", "errors in a row that say one"];
        let mut grid = Grid::new("How the other half of the flight is predicted", head);
        for one in &self.found.predicted {
            let (name, unit) = CHANNELS[one.channel];
            let r_squared =
                if one.r_squared.is_finite() { format!("{:.3}", one.r_squared) } else { "-".into() };
            let rms = format!("{} {unit}", short(one.rms));
            grid.row(
                name,
                [rms, format!("{:.1}", one.over_noise), r_squared, format!("{:.0}", one.together)],
            );
        }
        grid
    }

    /// The object of `--json`.
    pub fn json(&self) -> String {
        text(&IdentifyObject::of(self))
    }
}

const MASS: &str = "No flight tells the mass: thrust, inertia and drag are seen over it, and stand for the \
                    mass that was given.";
const DELAY: &str = "The delay is no number of a vehicle: it belongs into a mission's `control.latency_s`.";

/// A number with four digits.
fn short(x: f64) -> String {
    let size = x.abs();
    let decimals = match size {
        _ if !(size > 0.0) => 0,
        _ if size >= 1000.0 => 0,
        _ if size >= 100.0 => 1,
        _ if size >= 10.0 => 2,
        _ if size >= 1.0 => 3,
        _ if size >= 0.1 => 4,
        _ if size >= 0.01 => 5,
        _ => 6,
    };
    format!("{x:.decimals$}")
}

/// A parameter of a report, with its place.
type Of<'a> = (&'a IdentifyReport<'a>, Parameter);

result_objects! {
    /// What logs have told of a vehicle, as `samara identify --json` prints it.
    IdentifyObject(of: &IdentifyReport<'_>) {
        /// Version of samara that made the result.
        version: String = VERSION.to_owned(),
        /// Name of the vehicle that was known.
        base: String = of.base.to_owned(),
        /// Names of the logs.
        logs: Vec<String> = of.logs.to_vec(),
        /// Mass that thrust, inertia and drag are for [kg].
        mass_kg: f64 = of.vehicle.mass.mass_kg,
        /// Flight that was looked at [s].
        looked_at_s: f64 = of.found.looked_at_s,
        /// Gusts from second to second, north, east, down, as standard deviations [m/s].
        gusts_m_s: Vec<f64> = of.found.gusts_m_s.to_vec(),
        /// Numbers of the vehicle.
        numbers: Vec<IdentifyNumberObject> = numbers(of),
        /// Channels of the half of the flight that was not used, as the vehicle of the other half predicts
        /// them a second at a time.
        predicted: Vec<IdentifyPredictedObject> =
            of.found.predicted.iter().map(IdentifyPredictedObject::of).collect(),
        /// Covariance of what was found, in the order of the numbers that were: of logarithms of factors,
        /// shares (drag), [s] and [m].
        covariance: Vec<Vec<f64>> = rows(of),
        /// What holds for the whole result.
        remarks: Vec<String> = of.found.remarks.clone(),
    }

    /// A number of the vehicle.
    IdentifyNumberObject(of: &Of<'_>) [
        let known = of.0.known(of.1);
        let found = of.0.found.of(of.1);
        let numbers = found.map(|found| of.0.numbers(found));
    ] {
        /// Name of the number.
        name: String = of.1.key().to_owned(),
        /// Unit of the number and of its interval.
        unit: String = known.unit.to_owned(),
        /// Number that was known.
        base: f64 = known.value,
        /// What was found; null: the logs do not tell it.
        found: Option<f64> = numbers.and_then(|[value, ..]| finite(value)),
        /// Ends of the interval that holds the truth in 95 % of cases.
        interval: Option<Vec<f64>> = numbers.map(|[_, low, high]| vec![low, high]),
        /// Standard error: as a share where the number is a factor's, otherwise [s] or [m].
        error: Option<f64> = found.and_then(|found| finite(found.error)),
        /// Why it is not told.
        refused: Option<String> = of.0.reason(of.1),
    }

    /// How a channel was predicted.
    IdentifyPredictedObject(of: &Predicted) {
        /// Name of the channel.
        name: String = CHANNELS[of.channel].0.to_owned(),
        /// Unit of its error.
        unit: String = CHANNELS[of.channel].1.to_owned(),
        /// Root mean square of measured less predicted.
        rms: Option<f64> = finite(of.rms),
        /// Over the sensor's own noise.
        over_noise: Option<f64> = finite(of.over_noise),
        /// Share of what it did that was predicted.
        r_squared: Option<f64> = finite(of.r_squared),
        /// How many errors in a row say no more than one: 1 of white ones.
        together: Option<f64> = finite(of.together),
    }
}

fn numbers(of: &IdentifyReport<'_>) -> Vec<IdentifyNumberObject> {
    let told = |parameter: &Parameter| {
        of.found.of(*parameter).is_some() || of.found.refused.iter().any(|(one, _)| one == parameter)
    };
    Parameter::ALL
        .into_iter()
        .filter(told)
        .map(|parameter| IdentifyNumberObject::of(&(of, parameter)))
        .collect()
}

fn rows(of: &IdentifyReport<'_>) -> Vec<Vec<f64>> {
    let n = of.found.covariance.nrows();
    (0..n).map(|i| (0..n).map(|j| of.found.covariance[(i, j)]).collect()).collect()
}
