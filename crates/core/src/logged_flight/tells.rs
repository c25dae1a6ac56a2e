//! What a log can tell of its vehicle, and why it cannot: by the rates of what it has, and by what was flown.
//!
//! A log whose rates cannot show a rotor's lag gives inertia and lag that are wrong with small errors of
//! their own, so that rates come first: at 50 Hz a lag of 30 ms lies within a sample or two.

use super::phases::{Doing, Phase};
use super::{LoggedFlight, Series};

/// Lag and delay part at this rate [Hz].
const LAG_HZ: f64 = 100.0;
/// Forces are held against commands at this rate [Hz].
const FORCE_HZ: f64 = 20.0;
/// A hover's throttle takes so long a hover [s].
const HOVER_S: f64 = 5.0;
/// Drag takes such a speed [m/s].
const DRAG_M_S: f64 = 3.0;
/// Rates about an axis that move less within such a time show no torque [rad/s, s], as a standard deviation:
/// ten times the noise of usual gyroscopes. The lag of rotors takes more.
const TURNED_RAD_S: f64 = 0.01;
const TURNED_FOR_LAG_RAD_S: f64 = 0.05;
const TURNED_WITHIN_S: f64 = 1.0;
/// A day: no flight is as long, and a file with such times is looked through no further.
const MOST_SECONDS: f64 = 86_400.0;
/// Thrust that moves by less shows no curve, as a share of its mean.
const THRUST_SHARE: f64 = 0.1;

/// What a log may tell of a vehicle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Throttle at the hover.
    HoverThrottle,
    /// Thrust over mass by throttle.
    ThrustCurve,
    /// Lag of the rotors and delay of commands.
    Lag,
    /// Moment of inertia of roll.
    InertiaX,
    /// Moment of inertia of pitch.
    InertiaY,
    /// Moment of inertia of yaw, and the rotors' torque.
    InertiaZ,
    /// Drag in still air.
    Drag,
    /// Mass, which no log tells.
    Mass,
}

impl Quantity {
    /// The quantity for a reader.
    pub fn words(self) -> &'static str {
        match self {
            Self::HoverThrottle => "throttle at the hover (thrust over mass)",
            Self::ThrustCurve => "curve of the thrust over mass",
            Self::Lag => "lag of the rotors, delay of commands",
            Self::InertiaX => "inertia of roll over thrust",
            Self::InertiaY => "inertia of pitch over thrust",
            Self::InertiaZ => "inertia of yaw and torque over thrust",
            Self::Drag => "drag over mass, in still air",
            Self::Mass => "mass",
        }
    }
}

/// What a log tells of a quantity.
#[derive(Clone, Debug, PartialEq)]
pub struct Tells {
    /// The quantity.
    pub quantity: Quantity,
    /// Why not, each reason by itself; none where it can.
    pub lacks: Vec<String>,
}

/// What a log of such phases tells.
pub fn tells(record: &LoggedFlight, phases: &[Phase]) -> Vec<Tells> {
    let hover_s = |doing| phases.iter().filter(|p| p.doing == doing).map(Phase::length_s).fold(0.0, f64::max);
    let longest_s = hover_s(Doing::Hovering);
    let motors = |hz| lack("commands to the rotors", record.motors.as_ref(), hz);
    let force = |hz| lack("specific force", record.force_body_m_s2.as_ref(), hz);
    let rates = |hz| lack("angular rates", record.rates_body_rad_s.as_ref(), hz);
    let velocity = || lack("velocity", record.velocity_ned_m_s.as_ref(), 1.0);
    let hover = || {
        (longest_s < HOVER_S)
            .then(|| format!("the longest hover is of {longest_s:.1} s, and {HOVER_S} s are needed"))
    };
    let speed = || {
        let speed = airborne(record.velocity_ned_m_s.as_ref(), phases)
            .map(|[north, east, _]| (north * north + east * east).sqrt())
            .fold(0.0, f64::max);
        (speed < DRAG_M_S).then(|| format!("it flew up to {speed:.1} m/s, and {DRAG_M_S} m/s are needed"))
    };
    let turned = |axis: usize| {
        let rates = record.rates_body_rad_s.as_ref();
        let within = |(from_s, to_s): (f64, f64)| {
            let rates = rates.map_or(&[][..], |rates| rates.between(from_s, to_s));
            beyond_noise(rates.iter().filter_map(|w| w.get(axis).copied()))
        };
        seconds(phases, record.end_s()).map(within).fold(f64::NAN, f64::max)
    };
    let turned = [0, 1, 2].map(turned);
    let still = |name: &str, deviation: f64, least: f64| {
        (!(deviation >= least)).then(|| {
            format!(
                "rates of {name} moved by {:.3} rad/s within a second, and {least} rad/s are needed",
                zero_if_none(deviation)
            )
        })
    };
    let still_about = |axis: usize, name: &str| still(name, turned[axis], TURNED_RAD_S);
    let still_for_lag = || still("roll and pitch", turned[0].max(turned[1]), TURNED_FOR_LAG_RAD_S);
    let pushed = || {
        let force: Vec<f64> =
            airborne(record.force_body_m_s2.as_ref(), phases).map(|[.., down]| -down).collect();
        let mean = force.iter().sum::<f64>() / force.len().max(1) as f64;
        let share = deviation(force.iter().copied()) / mean;
        (!(share >= THRUST_SHARE)).then(|| {
            format!(
                "the thrust moved by {:.0} % of its mean, and {:.0} % are needed",
                100.0 * zero_if_none(share),
                100.0 * THRUST_SHARE
            )
        })
    };
    let row = |quantity, lacks: Vec<Option<String>>| Tells {
        quantity,
        lacks: lacks.into_iter().flatten().collect(),
    };
    vec![
        row(Quantity::HoverThrottle, vec![motors(1.0), force(1.0), hover()]),
        row(Quantity::ThrustCurve, vec![motors(LAG_HZ), force(FORCE_HZ), pushed()]),
        row(Quantity::Lag, vec![motors(LAG_HZ), rates(LAG_HZ), still_for_lag()]),
        row(Quantity::InertiaX, vec![motors(LAG_HZ), rates(LAG_HZ), still_about(0, "roll")]),
        row(Quantity::InertiaY, vec![motors(LAG_HZ), rates(LAG_HZ), still_about(1, "pitch")]),
        row(Quantity::InertiaZ, vec![motors(LAG_HZ), rates(LAG_HZ), still_about(2, "yaw")]),
        row(Quantity::Drag, vec![force(FORCE_HZ), velocity(), speed()]),
        row(
            Quantity::Mass,
            vec![Some(
                "no flight tells it: thrust and inertia are seen over mass alone, so weigh it".to_owned(),
            )],
        ),
    ]
}

/// Why a series does not do.
fn lack<const N: usize>(what: &str, series: Option<&Series<N>>, hz: f64) -> Option<String> {
    let Some(series) = series else { return Some(format!("it has no {what}")) };
    let rate = series.rate_hz();
    // Clocks of a log are not exact.
    (!(rate >= 0.9 * hz))
        .then(|| format!("{what} are of {:.0} Hz, and {hz:.0} Hz are needed", zero_if_none(rate)))
}

fn zero_if_none(x: f64) -> f64 {
    if x.is_finite() { x } else { 0.0 }
}

/// Times while the vehicle was in the air under power [s]; all of it where no phases are known, since what
/// was logged is then taken for a flight.
fn in_air(phases: &[Phase]) -> impl Iterator<Item = (f64, f64)> {
    let flown = |phase: &&Phase| matches!(phase.doing, Doing::Hovering | Doing::Manoeuvring);
    let whole = phases.is_empty().then_some((f64::NEG_INFINITY, f64::INFINITY));
    phases.iter().filter(flown).map(|phase| (phase.from_s, phase.to_s)).chain(whole)
}

/// The values of a series of those times.
fn airborne<'a, const N: usize>(
    series: Option<&'a Series<N>>,
    phases: &'a [Phase],
) -> impl Iterator<Item = &'a [f64; N]> {
    in_air(phases)
        .flat_map(move |(from_s, to_s)| series.map_or(&[][..], |series| series.between(from_s, to_s)))
}

/// Those times in seconds, each by its beginning and end [s], up to the end of the log [s].
fn seconds(phases: &[Phase], end_s: f64) -> impl Iterator<Item = (f64, f64)> {
    in_air(phases).flat_map(move |(from_s, to_s)| {
        let (from_s, to_s) = (from_s.max(0.0), to_s.min(end_s));
        let count = ((to_s - from_s) / TURNED_WITHIN_S).ceil().clamp(0.0, MOST_SECONDS) as usize;
        (0..count).map(move |i| {
            let from_s = from_s + i as f64 * TURNED_WITHIN_S;
            (from_s, to_s.min(from_s + TURNED_WITHIN_S))
        })
    })
}

/// Standard deviation beyond that of noise, which bends a series of values between neighbours; none where it
/// is no larger. NaN of nothing.
fn beyond_noise(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let whole = deviation(values.clone());
    let neighbours = values.clone().zip(values.clone().skip(1)).zip(values.skip(2));
    let bends = neighbours.map(|((a, b), c)| a - 2.0 * b + c);
    let noise = (deviation(bends) / 6.0_f64.sqrt()).max(0.0);
    let squared = whole * whole - noise * noise;
    if squared < noise * noise { 0.0 } else { squared.sqrt() }
}

/// Standard deviation; NaN of nothing.
fn deviation(values: impl Iterator<Item = f64>) -> f64 {
    let (mut count, mut mean, mut sum) = (0.0, 0.0, 0.0);
    for x in values.filter(|x| x.is_finite()) {
        count += 1.0;
        let off = x - mean;
        mean += off / count;
        sum += off * (x - mean);
    }
    if count > 0.0 { (sum / count).sqrt() } else { f64::NAN }
}
