//! Predictions of a second each, begun anew all along a drop of a log from the state that the log has: by
//! its commands to the rotors, which tests the model of the vehicle alone, and by its velocity setpoints
//! through the mission's controller.
//!
//! Rotors and battery are in no log: they turn and drain on from one second to the next. What builds up in
//! the controller does so by the log's states. An acceleration that was fed forward is in no log either, and
//! none is here.

use std::sync::Arc;

use nalgebra::Vector3;

use samara_core::assess::logged_drop::LoggedDrop;
use samara_core::assess::statistics::Summary;
use samara_core::control::px4::timing::IMU_PERIOD_S;
use samara_core::control::{ControlError, Controller, Measurement, Setpoint};
use samara_core::frames::{conjugate, product, rotate_body_from_ned, rotation_vector};
use samara_core::logged_flight::{LoggedFlight, MOST_ROTORS, Series};
use samara_core::model::{MAX_ROTORS, PerRotor};
use samara_core::sim::{DropSimulation, Phase, PlantKind, Sample, measured};
use samara_core::units::DEG_PER_RAD;
use samara_mission::Mission;
use samara_report::document::Passage;
use samara_report::json::result_objects;

use super::channels::{Channel, ChannelObject};
use crate::controller::{KeepsHeading, controller};

/// Length of a prediction [s].
const LENGTH_S: f64 = 1.0;
/// Commands and setpoints that are older say nothing [s]; longer gaps between states end a prediction.
const OLD_S: f64 = 0.5;
/// Shortest control period, as a share of PX4's: what is longer is cut into equal ones.
const PERIOD_S: f64 = IMU_PERIOD_S * 1.01;

/// Predictions of a second each.
#[derive(Clone, Debug, PartialEq)]
pub struct Seconds {
    /// What they were flown by, in words.
    pub by: &'static str,
    /// Number of them.
    pub count: usize,
    /// How far they are from the flight; of what is integrated, the change since the second began.
    pub channels: Vec<Channel>,
    /// Channels in which the mean error of a second is off to one side by more than sensors are, as its 95 %
    /// interval has it.
    pub off: Vec<&'static str>,
}

/// What is held against each other, and how far off to one side a sensor alone may be, or an estimate.
const CHANNELS: [(&str, f64); 12] = [
    ("specific force x [m/s^2]", 0.1),
    ("specific force y [m/s^2]", 0.1),
    ("specific force z [m/s^2]", 0.1),
    ("roll rate [deg/s]", 1.0),
    ("pitch rate [deg/s]", 1.0),
    ("yaw rate [deg/s]", 1.0),
    ("turn about x [deg]", 0.5),
    ("turn about y [deg]", 0.5),
    ("turn about z [deg]", 0.5),
    ("velocity north [m/s]", 0.05),
    ("velocity east [m/s]", 0.05),
    ("velocity down [m/s]", 0.05),
];
/// The flight's and the prediction's values of all channels at an instant.
type Pair = [[f64; 2]; CHANNELS.len()];

/// What flies a prediction: from the state of the log at a time, and what is simulated, to throttles. It is
/// told where one begins; `None`: the log does not have it.
pub(super) type Pilot<'a> = dyn FnMut(&Sample, &DropSimulation, Begins) -> Option<PerRotor> + 'a;
/// Whether a prediction begins, and how long the throttles are held [s].
type Begins = (bool, f64);

/// The predictions by commands and by setpoints; each, or what the log lacks.
///
/// # Errors
/// [`ControlError`] for a vehicle that cannot be controlled.
pub fn seconds(
    log: &LoggedFlight,
    drop: &LoggedDrop,
    mission: &Mission,
) -> Result<[Result<Seconds, &'static str>; 2], ControlError> {
    let commanded = log.motors.as_ref().ok_or("commands to the rotors").and_then(|motors| {
        let by = &mut by_commands(motors);
        Seconds::of("the log's commands to the rotors", drop, mission, by).ok_or("commands in the drop")
    });
    let mut along = KeepsHeading::new(controller(mission)?);
    let asked = log.velocity_sp_ned_m_s.as_ref().ok_or("velocity setpoints").and_then(|setpoints| {
        along.reset();
        let mut flown = along.clone();
        let mut by = |now: &Sample, simulation: &DropSimulation, (begins, dt_s): Begins| {
            // When between two rows of the log it changed, nobody knows.
            let v_ned = Vector3::from(setpoints.linear(now.t_s, OLD_S)?);
            let asked = Setpoint::Velocity { v_ned, a_ff_ned: Vector3::zeros(), yaw_rad: None };
            if begins {
                flown = along.clone();
            }
            let here = measured(simulation);
            let logged =
                Measurement { bus_v: here.bus_v, pack_a: here.pack_a, ..Measurement::from(&now.state.body) };
            along.step(&logged, &asked, dt_s);
            Some(flown.step(&here, &asked, dt_s).throttle)
        };
        let by_words = "the log's velocity setpoints, by the mission's controller";
        Seconds::of(by_words, drop, mission, &mut by).ok_or("velocity setpoints in the drop")
    });
    Ok([commanded, asked])
}

/// A pilot who gives the rotors what they were commanded.
pub(super) fn by_commands(
    motors: &Series<MOST_ROTORS>,
) -> impl FnMut(&Sample, &DropSimulation, Begins) -> Option<PerRotor> {
    |now, _, _| newest(motors, now.t_s).copied()
}

/// The newest value at a time [s], if it is one of numbers and not old.
fn newest<const N: usize>(series: &Series<N>, t_s: f64) -> Option<&[f64; N]> {
    let behind = series.t_s.partition_point(|t| *t <= t_s + 1e-6).checked_sub(1)?;
    let is_new = t_s - series.t_s.get(behind)? <= OLD_S;
    series.values.get(behind).filter(|row| is_new && row[0].is_finite())
}

impl Seconds {
    /// The predictions of a pilot; `None` where there is none.
    fn of(by: &'static str, drop: &LoggedDrop, mission: &Mission, pilot: &mut Pilot<'_>) -> Option<Self> {
        let gravity_m_s2 = mission.site.environment.gravity_m_s2;
        let mut seconds: Vec<Vec<Pair>> = Vec::new();
        fly(drop, mission, LENGTH_S, pilot, &mut |begin, flight, predicted| {
            let [flight, predicted] =
                [flight, predicted].map(|sample| readings(begin.1, sample, gravity_m_s2));
            let pair = std::array::from_fn(|i| [flight[i], predicted[i]]);
            match seconds.last_mut().filter(|_| !begin.0) {
                Some(second) => second.push(pair),
                None => seconds.push(vec![pair]),
            }
        });
        if seconds.is_empty() {
            return None;
        }
        let (mut channels, mut off) = (Vec::new(), Vec::new());
        for (i, (name, sensors)) in CHANNELS.into_iter().enumerate() {
            let channel = Channel::of(name, seconds.iter().flatten().map(move |pair| pair[i]));
            let mut biases = Summary::default();
            for second in &seconds {
                let errors = second.iter().map(|pair| pair[i][1] - pair[i][0]);
                biases.push(errors.sum::<f64>() / second.len() as f64);
            }
            let (low, high) = biases.mean_interval();
            if low > sensors || high < -sensors {
                off.push(name);
            }
            channels.push(channel);
        }
        Some(Self { by, count: seconds.len(), channels, off })
    }

    /// What is said of them.
    pub fn passages(&self) -> Vec<Passage> {
        let title = format!(
            "{} predictions of a second, each begun from the log's state, by {}",
            self.count, self.by
        );
        let said = match &self.off[..] {
            [] => "No channel is off to one side by more than sensors are.".to_owned(),
            off => format!(
                "Vehicle or air are NOT as the mission has them: the seconds are off to one side in {}.",
                off.join(", ")
            ),
        };
        vec![Passage::Table(Channel::grid(&title, &self.channels)), Passage::Said(said)]
    }
}

/// Takes a sample of a log and what was predicted of it: where the prediction began, whether these are the
/// first since, flight and prediction.
pub(super) type Observer<'a> = dyn FnMut((bool, &Sample), &Sample, &Sample) + 'a;

/// Predicts the powered part of a drop, anew from the log's state each `length_s` [s].
pub(super) fn fly(
    drop: &LoggedDrop,
    mission: &Mission,
    length_s: f64,
    pilot: &mut Pilot<'_>,
    observe: &mut Observer<'_>,
) {
    let Some(first) = drop.at_t0() else { return };
    let (vehicle, environment) = (Arc::clone(&mission.vehicle), mission.site.environment.clone());
    let mut simulation = DropSimulation::at_t0(vehicle, environment, first.state.body, PlantKind::Actuator)
        .on_battery(mission.electric.clone());
    let mut begun: Option<&Sample> = None;
    let powered = drop.samples.partition_point(|sample| sample.phase != Phase::Powered);
    for pair in drop.samples[powered..].windows(2) {
        let (now, next) = (&pair[0], &pair[1]);
        let (begins, step_s) = (begun.is_none(), next.t_s - now.t_s);
        let begin = *begun.get_or_insert(now);
        if begins {
            simulation.put(now.state.body);
        }
        let pieces = (step_s / PERIOD_S).ceil().clamp(1.0, OLD_S / IMU_PERIOD_S);
        let dt_s = step_s / pieces;
        let mut throttle = Some([0.0; MAX_ROTORS]);
        for piece in 0..pieces as usize {
            let at = Sample { t_s: now.t_s + piece as f64 * dt_s, ..*now };
            throttle = pilot(&at, &simulation, (begins && piece == 0, dt_s));
            simulation.step(&throttle.unwrap_or_default(), dt_s);
        }
        let (Some(throttle), true) = (throttle, step_s <= OLD_S) else {
            begun = None;
            continue;
        };
        let (t_s, t_powered_s) = (next.t_s, next.t_powered_s);
        let predicted = Sample { t_s, t_powered_s, ..simulation.sample(&throttle, None) };
        observe((begins, begin), next, &predicted);
        begun = begun.filter(|begin| next.t_s - begin.t_s < length_s - 1e-6);
    }
}

/// All channels of a sample, in a second that began with another one of the log.
fn readings(begin: &Sample, sample: &Sample, gravity_m_s2: f64) -> [f64; CHANNELS.len()] {
    let (from, to) = (&begin.state.body, &sample.state.body);
    let g_ned = Vector3::z() * gravity_m_s2;
    let force = rotate_body_from_ned(to.q_ned_from_body, sample.a_ned - g_ned);
    let rates = (to.omega_body - from.omega_body) * DEG_PER_RAD;
    let turn = product(conjugate(from.q_ned_from_body), to.q_ned_from_body);
    let turn = rotation_vector(turn) * DEG_PER_RAD;
    let velocity = to.v_ned - from.v_ned;
    let all = [force, rates, turn, velocity];
    std::array::from_fn(|i| all[i / 3][i % 3])
}

result_objects! {
    /// Predictions of a second each, begun anew all along a drop from the states of its log.
    SecondsObject(seconds: &Seconds) {
        /// What they were flown by.
        by: String = seconds.by.to_owned(),
        /// Number of them.
        count: usize = seconds.count,
        /// How far they are from the flight; of what is integrated, the change since the second began.
        channels: Vec<ChannelObject> = seconds.channels.iter().map(ChannelObject::of).collect(),
        /// Channels in which the mean error of a second is off to one side by more than sensors are, as its
        /// 95 % interval has it: vehicle or air are not the mission's.
        off: Vec<String> = seconds.off.iter().map(|name| (*name).to_owned()).collect(),
    }
}
