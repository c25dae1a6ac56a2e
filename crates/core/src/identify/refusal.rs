//! What a log does not tell of a vehicle, and why.

use nalgebra::DMatrix;

use super::Predicted;
use super::course::Course;
use super::fit::Fit;
use super::parameter::Parameter;

/// Lag and delay of rotors part at this rate [Hz].
const LEAST_HZ: f64 = 100.0;
/// Clocks of a log are not exact.
const NEARLY: f64 = 0.9;
/// Share of what rates and forces did that is to be predicted.
const LEAST_PREDICTED: f64 = 0.5;
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
        let channel = match parameter {
            Parameter::Thrust => 2,
            Parameter::InertiaX => 3,
            Parameter::InertiaY => 4,
            Parameter::InertiaZ | Parameter::Torque => 5,
            _ => usize::MAX,
        };
        let of_channel = predicted.iter().find(|one| one.channel == channel);
        let unpredicted = of_channel.filter(|one| channel > 2 && !(one.r_squared >= LEAST_PREDICTED));
        if let Some(one) = unpredicted {
            let (name, _) = super::CHANNELS[channel];
            let share = 100.0 * one.r_squared.max(0.0);
            let why = format!(
                "{share:.0} % of the {name} that was not used was predicted, and {:.0} % are needed: it hardly \
                 moved, or moved otherwise than such a vehicle does",
                100.0 * LEAST_PREDICTED
            );
            untold.push((parameter, why));
        } else if is_unsure(parameter) {
            untold.push((parameter, unsure(fit, covariance, parameter)));
        }
    }
    // Of what hangs on the wildest, some is told once that is held.
    if untold.len() > 1 && !all {
        let excess = |parameter: Parameter| error(parameter) / parameter.largest_error();
        untold.sort_by(|a, b| excess(b.0).total_cmp(&excess(a.0)));
        untold.truncate(untold.len().div_ceil(2));
    }
    untold
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
    let unit = |x: f64| match parameter {
        Parameter::Delay => format!("{:.1} ms", 1e3 * x),
        Parameter::CentreX | Parameter::CentreY => format!("{:.0} mm", 1e3 * x),
        _ => format!("{:.0} %", 100.0 * x),
    };
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
