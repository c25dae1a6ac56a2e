//! What a log does not tell of a vehicle, and why.

use nalgebra::DMatrix;

use super::course::{CHANNELS, Course};
use super::fit::Fit;
use super::found::Predicted;
use super::parameter::Parameter;
use crate::logged_flight::LoggedFlight;
use crate::logged_flight::phases::phases;
use crate::logged_flight::tells::{Quantity, tells};

/// Lag and delay of rotors part at this rate [Hz].
const LEAST_HZ: f64 = 100.0;
/// Clocks of a log are not exact.
const NEARLY: f64 = 0.9;
/// Share of what rates and forces did that is to be predicted.
const LEAST_PREDICTED: f64 = 0.5;
/// Forces that were predicted worse than by their mean were predicted wrongly; that of the thrust, which
/// hovers tell whatever gusts do, where it is off by more than this share of the weight, too.
const WRONG: f64 = -0.1;
const WRONG_OF_WEIGHT: f64 = 0.03;
/// A velocity that is so far off within a second [m/s], and so many times its noise, is of another vehicle.
const DRIFT_M_S: f64 = 0.15;
const DRIFT_OVER_NOISE: f64 = 5.0;
/// Parameters that move together more than that are not told apart.
const TOGETHER: f64 = 0.98;
/// Gusts that take the drag along [m/s].
const GUSTS_M_S: f64 = 0.15;

/// Why a log is too slow for anything but the thrust of a hover.
pub(super) fn too_slow(course: &Course) -> Option<String> {
    let [motors_hz, rates_hz] = course.rates_hz;
    let slow = [("commands to the rotors", motors_hz), ("angular rates", rates_hz)]
        .into_iter()
        .find(|(_, hz)| !(*hz >= NEARLY * LEAST_HZ))?;
    let (what, hz) = slow;
    Some(format!("{what} were logged at {hz:.0} Hz, and the rotors' lag shows at {LEAST_HZ:.0} Hz or more"))
}

/// Parameters that none of the flights can tell by what was flown, with the reason: too little moved.
pub(super) fn unmoved(flights: &[LoggedFlight]) -> Vec<(Parameter, String)> {
    let told: Vec<_> = flights.iter().map(|flight| tells(flight, &phases(flight))).collect();
    let lack = |parameter: &Parameter| {
        let quantity = match parameter {
            Parameter::Torque | Parameter::InertiaZ => Quantity::InertiaZ,
            Parameter::InertiaX => Quantity::InertiaX,
            Parameter::InertiaY => Quantity::InertiaY,
            Parameter::DragAlong | Parameter::DragAcross => Quantity::Drag,
            Parameter::LagUp | Parameter::LagDown | Parameter::Delay => Quantity::Lag,
            Parameter::Thrust | Parameter::CentreX | Parameter::CentreY => return None,
        };
        let rows = told.iter().flatten().filter(|row| row.quantity == quantity);
        let lacks: Option<Vec<&String>> = rows.map(|row| row.lacks.first()).collect();
        Some((*parameter, (*lacks?.first()?).clone()))
    };
    Parameter::ALL.iter().filter_map(lack).collect()
}

/// Parameters that are looked for and not told, with the reason: `all`, or the worse half of them.
pub(super) fn untold(
    fit: &Fit<'_>,
    covariance: &DMatrix<f64>,
    predicted: &[Predicted],
    all: bool,
) -> Vec<(Parameter, String)> {
    let error = |parameter: Parameter| covariance[(parameter as usize, parameter as usize)].sqrt();
    let free = || Parameter::ALL.into_iter().filter(|parameter| fit.is_free(*parameter));
    let is_unsure = |parameter: Parameter| !(error(parameter) <= parameter.largest_error());
    let mut untold = Vec::new();
    for parameter in free() {
        let why = misfit(parameter, predicted, fit.gravity_m_s2());
        let why = why.or_else(|| is_unsure(parameter).then(|| unsure(fit, covariance, parameter)));
        untold.extend(why.map(|why| (parameter, why)));
    }
    // Of what hangs on the wildest, some is told once that is held.
    if untold.len() > 1 && !all {
        let excess = |parameter: Parameter| error(parameter) / parameter.largest_error();
        untold.sort_by(|a, b| excess(b.0).total_cmp(&excess(a.0)));
        untold.truncate(untold.len().div_ceil(2));
    }
    untold
}

/// Why what a parameter moves was not predicted, if it was not.
fn misfit(parameter: Parameter, predicted: &[Predicted], gravity_m_s2: f64) -> Option<String> {
    let (channels, least): (&[usize], f64) = match parameter {
        Parameter::InertiaX | Parameter::CentreY => (&[3], LEAST_PREDICTED),
        Parameter::InertiaY | Parameter::CentreX => (&[4], LEAST_PREDICTED),
        Parameter::InertiaZ | Parameter::Torque => (&[5], LEAST_PREDICTED),
        Parameter::LagUp | Parameter::LagDown | Parameter::Delay => (&[3, 4], LEAST_PREDICTED),
        // Noise alone leaves nothing to be predicted; less than nothing is wrong.
        Parameter::DragAlong => (&[0], WRONG),
        Parameter::DragAcross => (&[1, 2], WRONG),
        Parameter::Thrust => (&[2], WRONG),
    };
    let of = |channel: &usize| predicted.iter().find(|one| one.channel == *channel);
    let least_m_s2 = if parameter == Parameter::Thrust { WRONG_OF_WEIGHT * gravity_m_s2 } else { 0.0 };
    let is_bad = |one: &&Predicted| one.r_squared < least && one.rms > least_m_s2;
    let bad = channels.iter().filter_map(of).find(is_bad);
    if let Some(one) = bad {
        let (name, unit) = CHANNELS[one.channel];
        if least == WRONG {
            return Some(format!(
                "the {name} was predicted worse than by its mean where it was not used, {:.2} {unit} off: gusts, \
                 or another vehicle",
                one.rms
            ));
        }
        let share = 100.0 * one.r_squared.max(0.0);
        return Some(format!(
            "{share:.0} % of what the {name} did where it was not used was predicted, and {:.0} % are needed: it \
             hardly moved, or moved otherwise than such a vehicle does",
            100.0 * LEAST_PREDICTED
        ));
    }
    let drifts =
        |one: &&Predicted| one.channel >= 9 && one.rms > DRIFT_M_S && one.over_noise > DRIFT_OVER_NOISE;
    let drift = predicted.iter().find(drifts).filter(|_| least == WRONG)?;
    let (name, _) = CHANNELS[drift.channel];
    Some(format!("{name} is {:.1} m/s off where it was not used, within a second", drift.rms))
}

fn unsure(fit: &Fit<'_>, covariance: &DMatrix<f64>, parameter: Parameter) -> String {
    let i = parameter as usize;
    let correlation = |other: &Parameter| {
        let j = *other as usize;
        (covariance[(i, j)] / (covariance[(i, i)] * covariance[(j, j)]).sqrt()).abs()
    };
    let others = Parameter::ALL.into_iter().filter(|other| *other != parameter && fit.is_free(*other));
    let twin = others.max_by(|a, b| correlation(a).total_cmp(&correlation(b)));
    let error = covariance[(i, i)].sqrt();
    let unit = |x: f64| parameter.error_words(x);
    let known =
        format!("its standard error is {}, and {} is needed", unit(error), unit(parameter.largest_error()));
    let gusts = fit.state.wind_sigma_m_s[0].max(fit.state.wind_sigma_m_s[1]);
    let is_drag = matches!(parameter, Parameter::DragAlong | Parameter::DragAcross);
    match twin.filter(|twin| correlation(twin) > TOGETHER) {
        Some(twin) => format!("not told from {}: {known}", twin.words()),
        None if is_drag && gusts > GUSTS_M_S => format!("gusts of {gusts:.1} m/s: {known}"),
        None => format!("too little was flown that moves it: {known}"),
    }
}
