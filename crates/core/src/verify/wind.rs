//! Wind: the drift of a body that has only drag, and Dryden's filters by their response to unit noise.
//!
//! The response to each random number alone adds up, in squares, to the variance, and, times the response at
//! the beginning, to the autocorrelation: so the statistics of the filters are found exactly, not by draws.

use std::sync::Arc;

use nalgebra::Vector3;

use super::motion::level;
use super::{Check, CheckGroup};
use crate::math;
use crate::model::wind::{Draw, Gust, GustLength, GustShape, Turbulence, TurbulenceScale, Wind};
use crate::model::{BodyAero, Environment, MAX_ROTORS, ModelError, Vehicle};
use crate::sim::{DropSimulation, PlantKind};

/// Drag area of the body [m^2].
const DRAG_AREA_M2: f64 = 2.0;
/// Wind that sets in [m/s], NED.
const SETS_IN_NED_M_S: [f64; 3] = [3.0, -4.0, 1.0];

/// A body at rest in hardly any gravity when a wind W sets in: its speed through the air falls as
/// `W/(1 + k W t)`, `k = rho A/(2 m)`.
///
/// # Errors
/// [`ModelError`] when the body is impossible.
pub fn drift(vehicle: &Vehicle, environment: &Environment) -> Result<CheckGroup, ModelError> {
    let turn = [-180.0f64, -90.0, 0.0, 90.0, 180.0].map(f64::to_radians);
    let aero = BodyAero::new(DRAG_AREA_M2, 1.0, &turn, &[1.0; 5], &[0.0; 5], &[0.0; 5])?;
    let body = Vehicle { aero: aero.with_side_area(DRAG_AREA_M2)?, ..vehicle.clone() };
    let site = Environment { gravity_m_s2: 1e-12, wind_ned_m_s: Vector3::zeros(), ..environment.clone() };
    let gust = Gust {
        shape: GustShape::Step,
        start_s: 0.0,
        length: GustLength::Time(f64::INFINITY),
        peak_ned_m_s: SETS_IN_NED_M_S,
    };
    let course = Wind { gusts: vec![gust], ..Wind::default() }.course(&site, 0);
    let k = 0.5 * site.density_kg_m3 * DRAG_AREA_M2 / body.mass.mass_kg;
    let start = level(Vector3::zeros(), Vector3::zeros());
    let mut sim = DropSimulation::at_t0(Arc::new(body), site, start, PlantKind::Ideal).in_wind(course);
    for _ in 0..2000 {
        sim.step(&[0.0; MAX_ROTORS], 0.01);
    }
    let wind = Vector3::from(SETS_IN_NED_M_S);
    let exact = wind * (1.0 - 1.0 / (1.0 + k * wind.norm() * 20.0));
    let found = sim.state().body.v_ned;
    let check = |what: &str, i: usize| {
        Check::new(format!("speed {what} after 20 s"), "m/s", found[i], exact[i], 1e-9)
    };
    Ok(CheckGroup {
        title: "Body with drag alone in a wind that sets in",
        source: "u_dot = -k u^2 through the air: u = W/(1 + k W t), k = rho A/(2 m), along the wind",
        checks: vec![check("north", 0), check("east", 1), check("down", 2)],
    })
}

/// Mean wind [m/s], scales [m] and standard deviations [m/s] of the turbulence.
const MEAN_M_S: f64 = 6.0;
const SCALE_M: [f64; 3] = [50.0, 40.0, 20.0];
const SIGMA_M_S: [f64; 3] = [1.5, 1.0, 0.5];
/// Steps and their length [s].
const STEPS: usize = 60;
const DT_S: f64 = 0.05;

/// Turbulence along, across and down at the first and at the last step, under one row of given noise.
fn response(environment: &Environment, row: usize, column: usize) -> Option<[[f64; 3]; 2]> {
    let mut noise = vec![Draw::default(); row + 1];
    noise[row][column] = 1.0;
    let turbulence = Turbulence {
        sigma_m_s: SIGMA_M_S,
        scale: TurbulenceScale::Fixed(SCALE_M),
        seed: 0,
        follows_mission: false,
        noise: Some(noise.into()),
    };
    let wind_ned_m_s = Vector3::new(MEAN_M_S, 0.0, 0.0);
    let site = Environment { wind_ned_m_s, ..environment.clone() };
    let mut course = Wind { turbulence: Some(turbulence), ..Wind::default() }.course(&site, 0)?;
    let mut at = |k: usize| {
        let [[n], [e], [d]] = course.step(&[k as f64 * DT_S], DT_S, &[0.0], &[[0.0]; 3]);
        [n - MEAN_M_S, e, d]
    };
    let first = at(0);
    let last = (1..=STEPS).map(&mut at).last()?;
    Some([first, last])
}

/// Variance and autocorrelation of Dryden's turbulence past a vehicle that stands in a mean wind.
pub fn turbulence(environment: &Environment) -> CheckGroup {
    let (mut variance, mut product) = ([0.0; 3], [0.0; 3]);
    for row in 0..=STEPS {
        for column in 0..5 {
            let [first, last] = response(environment, row, column).unwrap_or([[f64::NAN; 3]; 2]);
            for i in 0..3 {
                variance[i] += last[i] * last[i] / (SIGMA_M_S[i] * SIGMA_M_S[i]);
                product[i] += first[i] * last[i] / (SIGMA_M_S[i] * SIGMA_M_S[i]);
            }
        }
    }
    let x = SCALE_M.map(|scale_m| MEAN_M_S * DT_S * STEPS as f64 / scale_m);
    let names = ["along", "across", "vertical"];
    let correlation = |i: usize| math::exp(-x[i]) * if i == 0 { 1.0 } else { 1.0 - 0.5 * x[i] };
    let of_variance = |i: usize| Check::new(format!("variance {}", names[i]), "", variance[i], 1.0, 1e-12);
    let of_product = |i: usize| {
        Check::new(format!("autocorrelation {} after 3 s", names[i]), "", product[i], correlation(i), 1e-12)
    };
    CheckGroup {
        title: "Dryden's turbulence, over its variance",
        source: "spectra of MIL-F-8785C, 3.7.2.2: 1; exp(-x), exp(-x) (1 - x/2), x = V t/L",
        checks: (0..3).map(of_variance).chain((0..3).map(of_product)).collect(),
    }
}

/// Shapes of the discrete gusts at a quarter, the middle and the end of their lengths.
pub fn gusts() -> CheckGroup {
    let share = |shape: GustShape, x: f64| {
        let gust = Gust { shape, start_s: 0.0, length: GustLength::Time(1.0), peak_ned_m_s: [0.0, 0.0, 1.0] };
        gust.at(x, 0.0)[2]
    };
    let (codes, rise) = (GustShape::OneMinusCosine, GustShape::Rise);
    let shapes =
        [("there and back", codes, [0.5, 1.0, 0.0]), ("rise", rise, [0.5 - 0.125f64.sqrt(), 0.5, 1.0])];
    let mut checks = Vec::new();
    for (name, shape, shares) in shapes {
        let series = [0.25, 0.5, 1.0].into_iter().zip(shares).map(|(x, exact)| (share(shape, x), exact));
        checks.push(Check::worst(format!("{name}: share of the peak"), "", series, 1e-15));
    }
    CheckGroup {
        title: "1-cosine gusts",
        source: "14 CFR 25.341: (1 - cos(pi s/H))/2 up to 2 H; MIL-F-8785C, 3.7.1.3: (1 - cos(pi x/d_m))/2, then 1",
        checks,
    }
}
