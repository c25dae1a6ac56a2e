//! A drop out of a flight log, held against what a mission predicts: the mission's controller flown from the
//! log's state when the rotors came free, and a campaign that was flown before.

use std::ops::ControlFlow;
use std::sync::Arc;

use samara_core::assess::logged_drop::{LoggedDrop, NoDrop};
use samara_core::assess::outcome::COUNTED;
use samara_core::assess::safety::judge;
use samara_core::assess::{Course, Objection, Quantity, Verdict, VerdictBuilder};
use samara_core::control::ControlError;
use samara_core::control::px4::timing::{IMU_PERIOD_S, SETPOINT_PERIOD_S};
use samara_core::frames::pitch_and_bank;
use samara_core::logged_flight::LoggedFlight;
use samara_core::sim::{DropSimulation, FlightPlan, PlantKind, Reference, Sample, fly};
use samara_core::trajectory::Trajectory;
use samara_core::units::DEG_PER_RAD;
use samara_mission::Mission;
use samara_report::columns::fixed;
use samara_report::document::{Grid, Passage};
use samara_report::json::{finite, result_objects};
use samara_report::{DropRun, ShownDrop, drop_page_beside};

use super::channels::{Channel, ChannelObject};
use super::paths::FlownPath;
use super::seconds::{Seconds, SecondsObject, seconds};
use super::sides::sides;
use crate::controller::{KeepsHeading, controller};
use crate::fidelity::lines::CampaignLines;

/// A value beyond so many of a campaign's, on one side, is no usual one.
const UNUSUAL: f64 = 0.025;
/// Rates at which a log has attitude and velocity [Hz] are no lower for peaks to be those of the flight.
const OFTEN_HZ: f64 = 40.0;

/// A drop of a log, and what was to be expected of it.
#[derive(Clone, Debug, PartialEq)]
pub struct LoggedPair {
    /// The drop of the log.
    pub drop: LoggedDrop,
    /// The samples of the prediction: the log's to the end of the fall, then the mission's flight.
    pub predicted: Vec<Sample>,
    /// What the flight came to, and the prediction.
    pub verdicts: [Verdict; 2],
    /// Why they were not safe.
    pub objections: [Vec<Objection>; 2],
    /// How far the prediction is from the flight, from t = 0 to the end of the shorter of them.
    pub channels: Vec<Channel>,
    /// Predictions of a second, by commands and by setpoints; each, or what the log lacks.
    pub seconds: [Result<Seconds, &'static str>; 2],
    /// Where the flight is among a campaign's.
    pub places: Vec<Place>,
    /// The campaign in the words of its file.
    pub campaign: Option<String>,
}

/// Why a log is not held against a mission.
#[derive(Debug, thiserror::Error)]
pub enum Unpredicted {
    /// The log has no drop that is judged.
    #[error(transparent)]
    NoDrop(#[from] NoDrop),
    /// The mission's vehicle cannot be controlled.
    #[error(transparent)]
    Control(#[from] ControlError),
}

/// Where a flight is among the trials of a campaign, by one quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// The quantity.
    pub quantity: Quantity,
    /// The flight's value.
    pub value: f64,
    /// Trials that have a value.
    pub trials: usize,
    /// Share of them that lie below, with half of those that are equal.
    pub quantile: f64,
    /// Conformal p-value: were the flight one more trial, so rarely at most would a trial be as far out, on
    /// either side.
    pub p_value: f64,
}

impl Place {
    /// Where a value is among a campaign's; `None` without any.
    fn of(quantity: Quantity, value: f64, campaign: &[f64]) -> Option<Self> {
        let trials = campaign.len();
        let below = campaign.iter().filter(|x| **x < value).count() as f64;
        let above = campaign.iter().filter(|x| **x > value).count() as f64;
        let (all, equal) = (trials as f64, trials as f64 - below - above);
        let rarer = (equal + below.min(above) + 1.0) / (all + 1.0);
        let (quantile, p_value) = ((below + 0.5 * equal) / all, (2.0 * rarer).min(1.0));
        (trials > 0).then_some(Self { quantity, value, trials, quantile, p_value })
    }

    /// Whether so few trials are as far out.
    pub fn is_unusual(&self) -> bool {
        self.p_value < 2.0 * UNUSUAL
    }
}

impl LoggedPair {
    /// A log's drop beside the mission's controller along its plan from the same state; `campaign`: drops of
    /// the mission that were flown before.
    ///
    /// # Errors
    /// [`Unpredicted`]: the log has no drop, or the vehicle cannot be controlled.
    pub fn new(
        log: &LoggedFlight,
        mission: &Mission,
        plan: &Trajectory,
        campaign: Option<&CampaignLines>,
    ) -> Result<Self, Unpredicted> {
        let gravity_m_s2 = mission.site.environment.gravity_m_s2;
        let drop = LoggedDrop::of(log, gravity_m_s2, mission.release.parachute.delay_s)?;
        let predicted = predicted(&drop, mission, plan)?;
        let verdict = |samples: &[Sample]| {
            let mut builder =
                VerdictBuilder::judging(mission.limits, mission.target_v_ned).to_plans_end(plan.end_s());
            samples.iter().for_each(|sample| builder.observe(sample));
            builder.finish()
        };
        let (Some(flight), Some(expected)) = (verdict(&drop.samples), verdict(&predicted)) else {
            return Err(NoDrop::EndsInTheFall.into());
        };
        let verdicts = [flight, expected];
        let objections = verdicts.each_ref().map(|verdict| judge(Some(verdict), &Course::WHOLE));
        let channels = channels(&drop.samples, &predicted);
        let place = |quantity: &Quantity| {
            let value = quantity.of(&verdicts[0].outcome).filter(|x| x.is_finite())?;
            let values: Vec<f64> = campaign?.values(quantity)?.values().filter_map(|x| *x).collect();
            Place::of(*quantity, value, &values)
        };
        let places = COUNTED.iter().filter_map(place).collect();
        let campaign = campaign.map(|lines| format!("{}, {} trials", lines.flown, lines.trials.len()));
        let seconds = seconds(log, &drop, mission)?;
        Ok(Self { drop, predicted, verdicts, objections, channels, seconds, places, campaign })
    }

    /// The paths of the flight and of the prediction.
    pub fn paths(&self) -> [FlownPath; 2] {
        [&self.drop.samples, &self.predicted].map(|samples| FlownPath::of(samples))
    }

    /// `drop.html` of the prediction, with the flight as its ghost; `log`: how that was named.
    pub fn page(&self, log: &str, mission: &Mission, plan: &Trajectory) -> String {
        let run = DropRun { course: Course::WHOLE, ..DropRun::default() };
        let shown = |i: usize, title, gains| ShownDrop {
            mission,
            title,
            gains,
            samples: [&self.drop.samples, &self.predicted][i],
            plan: (i == 1).then_some(plan),
            verdict: Some(&self.verdicts[i]),
            run: &run,
        };
        let title = format!("{} from the state of {log}", mission.name);
        drop_page_beside(&shown(1, &title, &mission.control.gains_name), &shown(0, log, ""))
    }

    /// What is said of them.
    pub fn passages(&self) -> Vec<Passage> {
        let words = |i: usize, who: &str| {
            let j_tpf = fixed(self.verdicts[i].outcome.j_tpf, 3);
            let why: Vec<String> = self.objections[i].iter().map(ToString::to_string).collect();
            match &why[..] {
                [] => format!("{who}: safe, J_TPF {j_tpf}"),
                why => format!("{who}: NOT safe: {}; J_TPF {j_tpf}", why.join("; ")),
            }
        };
        let released = format!("the log's drop, released at {:.2} s", self.drop.released_s);
        let from = "the mission's controller from the log's state at t = 0";
        let mut passages = Vec::from(sides([words(0, &released), words(1, from)]));
        let mut grid = Grid::new("What both came to", ["", "A", "B", "B - A"]);
        for quantity in COUNTED.iter().filter(|quantity| !quantity.of_drops_alone) {
            let values = self.verdicts.each_ref().map(|verdict| quantity.of(&verdict.outcome));
            let number =
                |x: Option<f64>| x.map_or(quantity.without.to_owned(), |x| fixed(x, quantity.decimals));
            let difference = values[0].zip(values[1]).map(|(a, b)| b - a);
            let cells = [number(values[0]), number(values[1])];
            let difference = difference.map_or("-".to_owned(), |x| fixed(x, quantity.decimals));
            let [a, b] = cells;
            grid.row(&quantity.head(), [a, b, difference]);
        }
        passages.push(Passage::Table(grid));
        let title = "The prediction less the flight, from t = 0 on";
        passages.push(Passage::Table(Channel::grid(title, &self.channels)));
        passages.extend(self.seconds.iter().flatten().flat_map(Seconds::passages));
        if let Some(campaign) = &self.campaign {
            let mut grid =
                Grid::new(&format!("The flight among {campaign}"), ["", "A", "quantile", "p-value"]);
            for place in &self.places {
                let value = fixed(place.value, place.quantity.decimals);
                grid.row(&place.quantity.head(), [value, fixed(place.quantile, 3), fixed(place.p_value, 3)]);
            }
            passages.push(Passage::Table(grid));
            passages.push(Passage::Said(self.among()));
        }
        passages.extend(self.remarks().into_iter().map(Passage::Remark));
        passages
    }

    /// Whether the flight is among what was predicted, in a sentence.
    fn among(&self) -> String {
        let unusual: Vec<&str> =
            self.places.iter().filter(|place| place.is_unusual()).map(|place| place.quantity.words).collect();
        match &unusual[..] {
            [] => "The flight is within what the campaign predicts, by every quantity at 95 %.".to_owned(),
            words => format!(
                "The flight is NOT within what the campaign predicts at 95 %, by {}: fewer than 1 trial in 20 is as far out.",
                words.join(", ")
            ),
        }
    }

    /// What the log does not tell, a sentence each.
    fn remarks(&self) -> Vec<String> {
        let [rates_hz, attitude_hz, velocity_hz] = self.drop.rates_hz;
        let seldom = [("rates", rates_hz), ("attitude", attitude_hz), ("velocity", velocity_hz)];
        let seldom = seldom.into_iter().filter(|(_, hz)| *hz < OFTEN_HZ).map(|(name, hz)| {
            format!("the log has {name} at {hz:.0} Hz: a peak between two values is not seen (SDLOG_PROFILE logs more)")
        });
        let more = (self.drop.falls > 1).then(|| {
            format!("the log has {} falls that it flies out of: the first is the drop", self.drop.falls)
        });
        let states = "A is by the autopilot's estimates, not by the truth; wind, and speeds of the rotors at \
                      t = 0, are not known of it: B has the mission's wind and rotors at rest";
        let lacks = self.seconds.iter().filter_map(|seconds| seconds.as_ref().err());
        let lacks = lacks.map(|what| format!("the log has no {what}: no second is predicted by them"));
        seldom.chain(more).chain(lacks).chain([states.to_owned()]).collect()
    }
}

/// The log's samples to the end of its fall, and the mission's flight from there for as long.
fn predicted(drop: &LoggedDrop, mission: &Mission, plan: &Trajectory) -> Result<Vec<Sample>, ControlError> {
    let Some(start) = drop.at_t0() else { return Ok(drop.samples.clone()) };
    let end_s = drop.samples.last().map_or(start.t_s, |last| last.t_s);
    let (vehicle, environment) = (Arc::clone(&mission.vehicle), mission.site.environment.clone());
    let mut simulation = DropSimulation::at_t0(vehicle, environment, start.state.body, PlantKind::Actuator)
        .on_battery(mission.electric.clone());
    let reference = Reference::Plan {
        trajectory: plan,
        then_v_ned: Some(mission.target_v_ned),
        feed_forward: mission.control.feed_forward,
    };
    let flight = FlightPlan {
        setpoint_period_s: Some(SETPOINT_PERIOD_S),
        yaw_sp_rad: None,
        ..FlightPlan::new(reference, IMU_PERIOD_S, end_s - start.t_s)
    };
    let mut controller = KeepsHeading::new(controller(mission)?);
    let mut samples: Vec<Sample> =
        drop.samples.iter().take_while(|sample| sample.t_s < start.t_s).copied().collect();
    let (from_s, powered_s) = (start.t_s, start.t_powered_s.unwrap_or(0.0));
    let _ = fly(&mut simulation, &mut controller, &flight, &mut |sample| {
        let t_powered_s = sample.t_powered_s.map(|t_s| t_s + powered_s);
        samples.push(Sample { t_s: sample.t_s + from_s, t_powered_s, ..*sample });
        ControlFlow::Continue(())
    });
    Ok(samples)
}

/// A quantity of a sample, with its name.
type Reading = (&'static str, fn(&Sample) -> f64);
/// Those that are held against each other.
const CHANNELS: [Reading; 8] = [
    ("velocity north [m/s]", |sample| sample.state.body.v_ned.x),
    ("velocity east [m/s]", |sample| sample.state.body.v_ned.y),
    ("velocity down [m/s]", |sample| sample.state.body.v_ned.z),
    ("pitch [deg]", |sample| pitch_and_bank(sample.state.body.q_ned_from_body).0 * DEG_PER_RAD),
    ("roll [deg]", |sample| pitch_and_bank(sample.state.body.q_ned_from_body).1 * DEG_PER_RAD),
    ("roll rate [deg/s]", |sample| sample.state.body.omega_body.x * DEG_PER_RAD),
    ("pitch rate [deg/s]", |sample| sample.state.body.omega_body.y * DEG_PER_RAD),
    ("yaw rate [deg/s]", |sample| sample.state.body.omega_body.z * DEG_PER_RAD),
];

/// How far a prediction is from a flight, at the flight's times.
fn channels(flight: &[Sample], predicted: &[Sample]) -> Vec<Channel> {
    let newest = |t_s: f64| {
        let behind = predicted.partition_point(|sample| sample.t_s <= t_s + 0.5 * IMU_PERIOD_S);
        predicted.get(behind.checked_sub(1)?)
    };
    let powered = flight.iter().filter(|sample| sample.t_powered_s.is_some_and(|t_s| t_s >= 0.0));
    let pairs: Vec<(&Sample, &Sample)> =
        powered.filter_map(|sample| Some((sample, newest(sample.t_s)?))).collect();
    let of = |(name, value): &Reading| {
        Channel::of(name, pairs.iter().map(|(flight, predicted)| [value(flight), value(predicted)]))
    };
    CHANNELS.iter().map(of).collect()
}

result_objects! {
    /// A drop of a log, and what was to be expected of it.
    LoggedPairObject(pair: &LoggedPair) [let [a, b] = &pair.verdicts;] {
        /// Time of the release since the log's start [s].
        released_s: f64 = pair.drop.released_s,
        /// Number of falls that it flies out of; the drop is the first.
        falls: usize = pair.drop.falls,
        /// Whether the flight was safe, by the mission's limits.
        safe: bool = pair.objections[0].is_empty(),
        /// Why not, in words, the cause first; empty where it was.
        objections: Vec<String> = pair.objections[0].iter().map(ToString::to_string).collect(),
        /// Why the prediction was not safe; empty where it was.
        predicted_objections: Vec<String> = pair.objections[1].iter().map(ToString::to_string).collect(),
        /// What both came to: A is the flight, B the prediction.
        quantities: Vec<LoggedValueObject> = COUNTED.iter().map(|quantity| {
            LoggedValueObject::of(&(*quantity, quantity.of(&a.outcome), quantity.of(&b.outcome)))
        }).collect(),
        /// How far the prediction is from the flight.
        channels: Vec<ChannelObject> = pair.channels.iter().map(ChannelObject::of).collect(),
        /// Predictions of a second by the log's commands to the rotors; null where it has none.
        by_commands: Option<SecondsObject> = pair.seconds[0].as_ref().ok().map(SecondsObject::of),
        /// Predictions of a second by the log's velocity setpoints; null where it has none.
        by_setpoints: Option<SecondsObject> = pair.seconds[1].as_ref().ok().map(SecondsObject::of),
        /// Where the flight is among the campaign's trials; empty without one.
        places: Vec<PlaceObject> = pair.places.iter().map(PlaceObject::of).collect(),
    }

    /// A quantity of a flight and of its prediction.
    LoggedValueObject(of: &(Quantity, Option<f64>, Option<f64>)) {
        /// Name of the quantity; it ends in its unit.
        name: String = of.0.key.to_owned(),
        /// The flight's; null where it has none.
        flight: Option<f64> = of.1.and_then(finite),
        /// The prediction's; null where it has none.
        predicted: Option<f64> = of.2.and_then(finite),
    }

    /// Where a flight is among the trials of a campaign.
    PlaceObject(place: &Place) {
        /// Name of the quantity; it ends in its unit.
        name: String = place.quantity.key.to_owned(),
        /// The flight's value.
        value: f64 = place.value,
        /// Trials that have a value.
        trials: usize = place.trials,
        /// Share of them that lie below, with half of those that are equal.
        quantile: f64 = place.quantile,
        /// Conformal p-value, two-sided.
        p_value: f64 = place.p_value,
    }
}
