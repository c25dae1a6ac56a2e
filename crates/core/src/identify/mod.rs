//! A vehicle out of flight logs: how far it is off what was known, with honest standard errors, and what the
//! logs do not tell, with the reason.
//!
//! | file | holds |
//! |---|---|
//! | this one | what is asked and what comes out: fits, what is refused, what is held out |
//! | `asked` | what is asked, and why there is no answer |
//! | `found` | what was found |
//! | [`parameter`](Parameter) | the parameters, and what a deviation does to a vehicle |
//! | `course` | a flight on a grid of instants, and its stretches |
//! | `rotors` | speeds of the rotors, run from commands through the whole flight |
//! | `motion` | a stretch of a second, flown by the vehicle's own model |
//! | `fit` | output error: Gauss-Newton steps over all stretches, covariance by clusters of them |
//! | [`information`](Information) | what a flight of a known vehicle would tell |
//! | `hover` | thrust over mass of hovers alone, for logs that are too slow for more |
//! | `refusal` | what a log does not tell, and why |
//!
//! Mass is what was known: thrust, inertia and drag are seen over mass alone.

mod asked;
mod course;
mod fit;
mod found;
mod hover;
mod information;
mod motion;
mod parameter;
mod refusal;
mod rotors;
#[cfg(test)]
pub(crate) mod tests;

use nalgebra::DMatrix;

pub use asked::{IdentifyError, Settings};
pub use course::CHANNELS;
pub use found::{Found, Identified, Predicted, Shown};
pub use information::Information;
pub use parameter::{PARAMETERS, Parameter};

use crate::logged_flight::LoggedFlight;
use crate::model::Vehicle;
use course::{Course, MEASURED};
use fit::{Fit, Part, Residuals};
use found::reach;

/// Lengths of stretches [s]: short ones at first, which a vehicle that is far off can follow.
const SHORT_S: f64 = 0.25;
const LONG_S: f64 = 1.0;
/// Delay from which it is searched [s]: that of a usual computer and its bus.
const FIRST_DELAY_S: f64 = 0.008;
/// Fewer stretches than this many tell no more than hovers do: there is nothing to be held out, and errors
/// by leaving some out mean nothing.
const FEWEST: usize = 20;
/// So often a vehicle is fitted anew from what was found, at most, and how far what stays may move, as a
/// share of the largest error with which it is told: weights and gusts of one far off may leave it off.
const AGAIN: usize = 3;
const STAYS: f64 = 0.05;
/// So often what cannot be told is held, and the rest fitted again.
const REFITS: usize = 3;

/// Finds out what logs tell of a vehicle.
///
/// # Errors
/// [`IdentifyError`] with the place of the log where one has not what is needed.
pub fn identify(
    flights: &[LoggedFlight],
    vehicle: &Vehicle,
    settings: &Settings,
) -> Result<Identified, (usize, IdentifyError)> {
    let course = |(i, flight)| Course::of(flight, vehicle, settings).map_err(|e| (i, e));
    let courses = flights.iter().enumerate().map(course).collect::<Result<Vec<_>, _>>()?;
    if let Some(why) = courses.iter().find_map(refusal::too_slow) {
        return Ok(hover::identify(&courses, vehicle, settings, &why));
    }
    let parts = |length_s: f64, which: fn(usize) -> bool| -> Vec<Part<'_>> {
        let part = |course| {
            let stretches: Vec<(usize, usize)> = Course::stretches(course, length_s);
            let stretches = stretches.into_iter().enumerate().filter(|(i, _)| which(*i)).map(|(_, s)| s);
            Part { course, gravity_m_s2: settings.gravity_m_s2, stretches: stretches.collect() }
        };
        courses.iter().map(part).collect()
    };
    let (short, long) = (parts(SHORT_S, |i| i % 2 == 0), parts(LONG_S, |_| true));
    let stretches: usize = long.iter().map(|part| part.stretches.len()).sum();
    if stretches == 0 && courses.iter().all(|course| course.hovers.is_empty()) {
        return Err((0, IdentifyError::NotFlown));
    }
    if stretches < FEWEST {
        let why = format!("{stretches} seconds of flight were found without gaps, and {FEWEST} are needed");
        return Ok(hover::identify(&courses, vehicle, settings, &why));
    }
    let mut begin = [0.0; PARAMETERS];
    begin[Parameter::Delay as usize] = FIRST_DELAY_S;
    let mut near = Fit::new(vehicle, &short, begin);
    let mut refused = refusal::unmoved(flights);
    if courses.iter().any(|course| !course.has_velocity) {
        refused.retain(|(one, _)| !matches!(one, Parameter::DragAlong | Parameter::DragAcross));
        let why = || "a log has no attitude and velocity".to_owned();
        refused.extend([Parameter::DragAlong, Parameter::DragAcross].map(|one| (one, why())));
    }
    refused.retain(|(one, _)| one.is_of(vehicle));
    refused.iter().for_each(|(parameter, _)| near.hold(*parameter));
    near.run(1, 6);
    let mut fit = Fit::new(vehicle, &long, [0.0; PARAMETERS]).from(&near.state);
    refused.iter().for_each(|(parameter, _)| fit.hold(*parameter));
    fit.run(2, 5);
    let mut steps = near.steps;
    for _ in 0..AGAIN {
        let before = fit.state.deviations;
        steps += fit.steps;
        fit = Fit::new(vehicle, &long, before);
        refused.iter().for_each(|(parameter, _)| fit.hold(*parameter));
        fit.run(2, 5);
        let moved = |p: &Parameter| (fit.state.deviations[*p as usize] - before[*p as usize]).abs();
        if Parameter::ALL.iter().all(|p| moved(p) <= STAYS * p.largest_error()) {
            break;
        }
    }
    // What is held out: the second half of every four stretches.
    let (used, unused) = (parts(LONG_S, |i| i % 4 < 2), parts(LONG_S, |i| i % 4 >= 2));
    let (mut covariance, mut freedom) = fit.covariance();
    let mut half = Fit::new(vehicle, &used, [0.0; PARAMETERS]).from(&fit.state);
    let mut rest = Fit::new(vehicle, &unused, [0.0; PARAMETERS]);
    for refit in 0..=REFITS {
        Parameter::ALL.into_iter().filter(|p| !fit.is_free(*p)).for_each(|p| half.hold(p));
        half.run(0, 3);
        rest = Fit::new(vehicle, &unused, [0.0; PARAMETERS]).from(&half.state);
        rest.predict(half.state.deviations);
        let untold = refusal::untold(&fit, &covariance, &predicted(&rest, &unused), refit == REFITS);
        if untold.is_empty() {
            break;
        }
        for (parameter, why) in untold {
            fit.hold(parameter);
            refused.push((parameter, why));
        }
        fit.run(0, 5);
        (covariance, freedom) = fit.covariance();
    }
    steps += fit.steps + half.steps;
    let stretches = stretches - fit.lost();
    Ok(told(&fit, (&rest, &unused), (covariance, freedom), refused, (stretches, steps), vehicle))
}

/// The result of a fit.
fn told(
    fit: &Fit<'_>,
    (rest, unused): (&Fit<'_>, &[Part<'_>]),
    (covariance, freedom): (DMatrix<f64>, [f64; PARAMETERS]),
    mut refused: Vec<(Parameter, String)>,
    (stretches, steps): (usize, usize),
    vehicle: &Vehicle,
) -> Identified {
    let free: Vec<Parameter> =
        Parameter::ALL.into_iter().filter(|parameter| fit.is_free(*parameter)).collect();
    let found = free.iter().map(|parameter| {
        let i = *parameter as usize;
        Found {
            parameter: *parameter,
            deviation: fit.state.deviations[i],
            error: covariance[(i, i)].sqrt(),
            reach: reach(freedom[i]),
        }
    });
    for parameter in Parameter::ALL {
        let is_told = free.contains(&parameter) || refused.iter().any(|(one, _)| *one == parameter);
        if parameter.is_of(vehicle) && !is_told {
            refused.push((parameter, "held".to_owned()));
        }
    }
    refused.sort_by_key(|(parameter, _)| *parameter);
    Identified {
        found: found.collect(),
        refused,
        covariance: DMatrix::from_fn(free.len(), free.len(), |i, j| {
            covariance[(free[i] as usize, free[j] as usize)]
        }),
        predicted: predicted(rest, unused),
        shown: shown(rest, unused),
        looked_at_s: stretches as f64 * LONG_S,
        stretches,
        steps,
        gusts_m_s: fit.state.wind_sigma_m_s,
        remarks: Vec::new(),
    }
}

/// How channels were predicted.
fn predicted(rest: &Fit<'_>, unused: &[Part<'_>]) -> Vec<Predicted> {
    let residuals = rest.residuals();
    let ranges = unused.iter().flat_map(|part| part.stretches.iter().map(|range| (part.course, *range)));
    let measured: Vec<Residuals> = ranges
        .map(|(course, (from, to))| course.instants[from..=to].iter().map(motion::measured).collect())
        .collect();
    let of = |channel: usize| {
        let column = |rows: &Residuals| -> Vec<f64> {
            rows.iter().map(|row| row[channel]).filter(|x| x.is_finite()).collect()
        };
        let errors = residuals.iter().map(column);
        let (mut square, mut count, mut moved, mut noise, mut noises) = (0.0, 0.0, 0.0, 0.0, 0.0);
        let seen = measured.iter().map(column);
        for (errors, seen) in errors.clone().zip(seen).filter(|(errors, _)| !errors.is_empty()) {
            let mean = seen.iter().sum::<f64>() / seen.len().max(1) as f64;
            square += errors.iter().map(|x| x * x).sum::<f64>();
            count += errors.len() as f64;
            // Forces are held against their mean, what is integrated against what it was at first.
            let from = if channel < 3 { mean } else { seen.first().copied().unwrap_or(0.0) };
            moved += seen.iter().map(|x| (x - from) * (x - from)).sum::<f64>();
            for three in seen.windows(3) {
                let bend = three[0] - 2.0 * three[1] + three[2];
                noise += bend * bend / 6.0;
                noises += 1.0;
            }
        }
        let noise = (noise / f64::max(noises, 1.0)).sqrt().max(fit::LEAST_SIGMA[channel]);
        let rms = (square / count).sqrt();
        Predicted {
            channel,
            rms,
            r_squared: if moved > 0.0 { 1.0 - square / moved } else { f64::NAN },
            together: fit::together(errors),
            over_noise: rms / noise,
        }
    };
    (0..MEASURED).map(of).collect()
}

/// Instants of the first flight that were predicted.
fn shown(rest: &Fit<'_>, unused: &[Part<'_>]) -> Vec<Shown> {
    let Some(part) = unused.first() else { return Vec::new() };
    let residuals = rest.residuals();
    let mut shown = Vec::new();
    for ((from, to), rows) in part.stretches.iter().zip(&residuals) {
        for (instant, errors) in part.course.instants[*from..=*to].iter().zip(rows) {
            let measured = motion::measured(instant);
            let predicted = std::array::from_fn(|i| measured[i] - errors[i]);
            shown.push(Shown { t_s: instant.t_s, measured, predicted });
        }
    }
    shown
}
