//! What is inside a mission, alone: the loops of its cascade, its rotor, its wind, its sensors.
//!
//! Numbers go in as lists of equal length and come out as columns.

use std::ops::ControlFlow;

use nalgebra::Vector3;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use samara::design::{LOOPS, LoopsAt};
use samara::model::rigid_body::BodyState;
use samara::model::rotor::{HubMotion, RotorLoad};
use samara::plan::{SolverOptions, Status};
use samara::sim::sensors::Sensors;
use samara::study::designing::own_loops_at;
use samara::vector::V3;

use crate::arrays::columns;
use crate::fault::{Fault, OrGiven as _};
use crate::given::Given;
use crate::work::work;

/// Microseconds in a second.
const US_PER_S: f64 = 1e6;

/// A vector of a track, from its three columns.
fn at(columns: &[Vec<f64>; 3], i: usize) -> Vector3<f64> {
    let of = |column: &Vec<f64>| column.get(i).copied().unwrap_or_default();
    columns.each_ref().map(of).into()
}

/// The loops of a mission's gains: of each state and loop a dictionary with names, matrices and margins.
#[pyfunction]
pub fn loops(py: Python<'_>, given: Given) -> PyResult<Vec<Bound<'_, PyDict>>> {
    let found = work(py, move |stop| {
        let mission = given.mission()?;
        let mut go_on =
            |_: &_| if stop.raised() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
        let plan = match mission.release.standing {
            true => None,
            false => Some(mission.solve(&SolverOptions::default(), &mut go_on).or_given()?),
        };
        let plan = plan.filter(|plan| plan.status == Status::Converged);
        Ok(own_loops_at(&mission, plan.as_ref().map(|plan| &plan.trajectory)))
    })?;
    let mut all = Vec::new();
    for LoopsAt { name: state, loops } in &found {
        for ((name, broken_at), (linear, margins)) in LOOPS.iter().zip(loops) {
            let dict = PyDict::new(py);
            dict.set_item("state", *state)?;
            dict.set_item("name", *name)?;
            dict.set_item("broken_at", *broken_at)?;
            // Rows one after the other, as NumPy has them; nalgebra's are columns.
            let matrices = [
                ("a", linear.a.transpose().as_slice().to_vec()),
                ("b", linear.b.as_slice().to_vec()),
                ("c", linear.c.as_slice().to_vec()),
            ];
            dict.set_item("matrices", columns(py, &matrices)?)?;
            dict.set_item("period_s", linear.period_s)?;
            dict.set_item("stable", margins.stable)?;
            dict.set_item("gain_up", margins.gain_up)?;
            dict.set_item("gain_down", margins.gain_down)?;
            dict.set_item("phase_deg", margins.phase_deg)?;
            dict.set_item("delay_s", margins.delay_s)?;
            dict.set_item("crossover_rad_s", margins.crossover_rad_s)?;
            dict.set_item("modulus", margins.modulus)?;
            all.push(dict);
        }
    }
    Ok(all)
}

/// Thrust [N], torque [N m] and force in the disk's plane [N] of a mission's rotor at speeds [rad/s], climbs
/// and speeds in the disk's plane [m/s], at a density [kg/m^3]: that of the site unless another is given.
#[pyfunction]
#[pyo3(signature = (given, omega_rad_s, climb_m_s, in_plane_m_s, density_kg_m3=None))]
pub fn rotor(
    py: Python<'_>,
    given: Given,
    omega_rad_s: Vec<f64>,
    climb_m_s: Vec<f64>,
    in_plane_m_s: Vec<f64>,
    density_kg_m3: Option<f64>,
) -> PyResult<Bound<'_, PyDict>> {
    let mission = given.mission().map_err(|fault| fault.raised(py))?;
    let density = density_kg_m3.unwrap_or(mission.site.environment.density_kg_m3);
    let (forward, up) = (Vector3::x(), -Vector3::z());
    let load = |((omega, climb), in_plane): ((&f64, &f64), &f64)| {
        let hub = HubMotion::of(V3::constant(0.0, &(up * *climb + forward * *in_plane)), &up);
        mission.vehicle.rotor.load_at_hub(*omega, &hub, density)
    };
    let loads: Vec<RotorLoad> = omega_rad_s.iter().zip(&climb_m_s).zip(&in_plane_m_s).map(load).collect();
    let of = |number: fn(&RotorLoad) -> f64| loads.iter().map(number).collect::<Vec<_>>();
    let found = [
        ("thrust_n", of(|load| load.thrust_n)),
        ("torque_nm", of(|load| load.torque_nm)),
        ("in_plane_n", of(|load| load.in_plane_n)),
    ];
    columns(py, &found)
}

/// The wind [m/s] that a vehicle meets on a track of times since t = 0 [s], positions [m] and velocities over
/// ground [m/s], NED, with the turbulence of flight `number`.
#[pyfunction]
pub fn wind(
    py: Python<'_>,
    given: Given,
    t_s: Vec<f64>,
    p_ned: [Vec<f64>; 3],
    v_ned: [Vec<f64>; 3],
    number: u64,
) -> PyResult<Bound<'_, PyDict>> {
    let found = work(py, move |_| {
        let mission = given.mission()?;
        let environment = &mission.site.environment;
        let mut course = mission.site.wind.course(environment, number);
        let mut found: [Vec<f64>; 3] = Default::default();
        for (i, now_s) in t_s.iter().enumerate() {
            // The last step is as long as the one before.
            let last_s = || now_s - i.checked_sub(1).map_or(*now_s, |before| t_s[before]);
            let dt_s = t_s.get(i + 1).map_or_else(last_s, |next_s| next_s - now_s);
            let (p, v) = (at(&p_ned, i), at(&v_ned, i));
            let wind = match &mut course {
                Some(course) => {
                    course.step(&[*now_s], dt_s, &[p.z], &[[v.x], [v.y], [v.z]]).map(|[component]| component)
                }
                None => environment.wind_ned_m_s.into(),
            };
            found.iter_mut().zip(wind).for_each(|(column, component)| column.push(component));
        }
        Ok(found)
    })?;
    let [north, east, down] = found;
    columns(py, &[("north", north), ("east", east), ("down", down)])
}

/// What a mission's sensors read on a track of times [s], positions [m], velocities [m/s], attitudes, body
/// rates [rad/s] and specific forces [m/s^2]; each sensor at each time.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "a motion has as many columns")]
pub fn sensors(
    py: Python<'_>,
    given: Given,
    t_s: Vec<f64>,
    p_ned: [Vec<f64>; 3],
    v_ned: [Vec<f64>; 3],
    q_ned_from_body: [Vec<f64>; 4],
    omega_body: [Vec<f64>; 3],
    force_body: [Vec<f64>; 3],
    seed: Option<u64>,
) -> PyResult<Bound<'_, PyDict>> {
    let found = work(py, move |_| {
        let mission = given.mission()?;
        let us = |t_s: f64| (t_s * US_PER_S).round() as u64;
        let period_us = match t_s.as_slice() {
            [first, second, ..] => us(second - first),
            _ => return Err(Fault::in_words("at least two times are expected".to_owned())),
        };
        let environment = &mission.site.environment;
        let altitude_m = environment.anchor.altitude_m;
        let seed = seed.unwrap_or(mission.seed);
        let mut sensors = Sensors::new(environment, mission.sensors, seed, period_us);
        let mut found: [Vec<f64>; 16] = Default::default();
        for (i, now_s) in t_s.iter().enumerate() {
            let q = q_ned_from_body.each_ref().map(|column| column.get(i).copied().unwrap_or_default());
            let body = BodyState {
                p_ned: at(&p_ned, i),
                q_ned_from_body: q,
                v_ned: at(&v_ned, i),
                omega_body: at(&omega_body, i),
            };
            let t_us = us(*now_s);
            sensors.note(t_us, &body);
            let accelerometer = sensors.accelerometer(at(&force_body, i), t_us);
            let gyroscope = sensors.gyroscope(body.omega_body, t_us);
            let magnetometer = sensors.magnetometer(q);
            let pressure_hpa = sensors.barometer(altitude_m - body.p_ned.z, t_us);
            let fix = sensors.satellite(&body, t_us);
            let vectors = [accelerometer, gyroscope, magnetometer, fix.p_ned, fix.v_ned];
            let numbers = vectors.iter().flat_map(|v| v.iter().copied()).chain([pressure_hpa]);
            found.iter_mut().zip(numbers).for_each(|(column, number)| column.push(number));
        }
        Ok(found)
    })?;
    const NAMES: [&str; 16] = [
        "ax_m_s2",
        "ay_m_s2",
        "az_m_s2",
        "p_rad_s",
        "q_rad_s",
        "r_rad_s",
        "mx_gauss",
        "my_gauss",
        "mz_gauss",
        "gps_pn_m",
        "gps_pe_m",
        "gps_pd_m",
        "gps_vn_m_s",
        "gps_ve_m_s",
        "gps_vd_m_s",
        "pressure_hpa",
    ];
    let found: Vec<(&str, Vec<f64>)> = NAMES.into_iter().zip(found).collect();
    columns(py, &found)
}
