//! The flight, the plan and what is known about them, as the page's script takes them.

use serde::Serialize;

use super::channel::Channel;
use crate::json::{VERSION, object};
use crate::marks::{Times, marks};
use crate::plan_motion::{place_at, plan_motion};
use crate::shown_drop::ShownDrop;
use samara_core::assess::StateCost;
use samara_core::model::RotationSense;
use samara_core::model::rigid_body::BodyState;
use samara_core::model::supply::BusState;
use samara_core::sim::{Phase, Sample};
use samara_core::units::DEG_PER_RAD;

/// More rows than this of a log are thinned, evenly: pages have bounds.
const ROWS_MAX: usize = 20_000;
/// Steps of time [s], position [m], velocity [m/s], attitude, body rates [rad/s] and J_state.
const TIME_S: f64 = 1e-6;
const POSITION_M: f64 = 1e-4;
const VELOCITY_M_S: f64 = 1e-4;
const ATTITUDE: f64 = 1e-6;
const RATE_RAD_S: f64 = 1e-5;
const COST: f64 = 1e-5;

/// The precision of the numbers, in words.
pub(super) const PRECISION: &str = "time to 1 us, position to 0.1 mm, velocity to 0.1 mm/s, attitude to 1e-6, \
                                    body rates to 1e-5 rad/s, thrusts and rotor speeds to a ten thousandth";

/// Columns of one motion.
#[derive(Serialize)]
struct Motion {
    count: usize,
    channels: Vec<Channel>,
}

/// The rows of a log that the page has: all, or every second, third, .., with those that begin a phase, and
/// the last.
pub(super) fn rows(samples: &[Sample]) -> Vec<&Sample> {
    let stride = samples.len().div_ceil(ROWS_MAX).max(1);
    let begins = |i: usize| i > 0 && samples[i].phase != samples[i - 1].phase;
    let kept = |i: usize| i.is_multiple_of(stride) || i + 1 == samples.len() || begins(i);
    samples.iter().enumerate().filter(|(i, _)| kept(*i)).map(|(_, sample)| sample).collect()
}

/// The page's data as JSON without `<`, which no block of a page ends in.
pub(super) fn object(drop: &ShownDrop<'_>) -> String {
    let ShownDrop { mission, verdict, .. } = *drop;
    let (times, limits) = (Times::of(drop), &mission.limits.safety);
    let environment = &mission.site.environment;
    let pack_limit_a = mission.electric.as_ref().map(|battery| battery.pack().limits().current_max_a);
    let pack_limit_a = pack_limit_a.filter(|limit_a| limit_a.is_finite());
    let rotors = mission.vehicle.rotors.iter().map(|rotor| {
        object! {
            position_body_m: <[f64; 3]>::from(rotor.position_body_m),
            axis_body: <[f64; 3]>::from(rotor.axis_body),
            spin: match rotor.spin { RotationSense::Cw => "cw", RotationSense::Ccw => "ccw" },
        }
    });
    let object = object! {
        format: 1,
        version: VERSION,
        mission: &mission.name,
        vehicle: &mission.vehicle_name,
        gains: drop.gains,
        seed: mission.seed,
        input_hash: &mission.inputs.hash,
        target_v_ned_m_s: <[f64; 3]>::from(mission.target_v_ned),
        wind_ned_m_s: <[f64; 3]>::from(environment.wind_ned_m_s),
        standing: mission.release.standing,
        ground_down_m: mission.site.ground.map(|ground| ground.down_m),
        canopy_length_m: mission.release.parachute.line_m(),
        limits: object! {
            speed_m_s: limits.speed_m_s,
            pitch_deg: limits.pitch_rad * DEG_PER_RAD,
            pitch_rate_deg_s: limits.pitch_rate_rad_s * DEG_PER_RAD,
            thrust_n: mission.plan.thrust_max_n,
            rotor_rad_s: mission.vehicle.motor.omega_max_rad_s(),
            #[serde(flatten)] pack: pack_limit_a.map(|limit_a| object! { pack_current_a: limit_a }),
        },
        rotors: rotors.collect::<Vec<_>>(),
        verdict: verdict.map(|v| object! { j_tpf: v.outcome.j_tpf, decided_by: v.decided_by }),
        times: object! { released_s: times.released_s, free_s: times.free_s, steady_s: times.steady_s },
        marks: marks(drop, &times),
        flight: flight(drop),
        plan: planned(drop, &times),
    };
    // Structs of strings, numbers and lists of them always serialise.
    serde_json::to_string(&object).unwrap_or_default().replace('<', "\\u003c")
}

const POSITIONS: [&str; 3] = ["north_m", "east_m", "down_m"];
const ATTITUDES: [&str; 4] = ["q0", "q1", "q2", "q3"];
const VELOCITIES: [&str; 3] = ["vn_m_s", "ve_m_s", "vd_m_s"];
const CANOPY: [&str; 3] = ["canopy_north_m", "canopy_east_m", "canopy_down_m"];
const WINDS: [&str; 3] = ["wind_n_m_s", "wind_e_m_s", "wind_d_m_s"];
const RATES: [&str; 3] = ["p_rad_s", "q_rad_s", "r_rad_s"];

/// Columns of a motion, named as in `flight.csv`.
fn motion<T>(
    rows: &[T],
    time_s: impl Fn(&T) -> f64,
    body: impl Fn(&T) -> &BodyState,
    cost: impl Fn(&T) -> StateCost,
) -> Vec<Channel> {
    let mut channels = vec![Channel::new("t_s", TIME_S, rows.iter().map(time_s))];
    let mut add = |name: &str, step: f64, of: &dyn Fn(&BodyState) -> f64| {
        channels.push(Channel::new(name, step, rows.iter().map(|row| of(body(row)))));
    };
    for (i, name) in POSITIONS.iter().enumerate() {
        add(name, POSITION_M, &|body| body.p_ned[i]);
    }
    for (i, name) in ATTITUDES.iter().enumerate() {
        add(name, ATTITUDE, &|body| body.q_ned_from_body[i]);
    }
    for (i, name) in VELOCITIES.iter().enumerate() {
        add(name, VELOCITY_M_S, &|body| body.v_ned[i]);
    }
    for (i, name) in RATES.iter().enumerate() {
        add(name, RATE_RAD_S, &|body| body.omega_body[i]);
    }
    channels.push(Channel::new("j_state", COST, rows.iter().map(|row| cost(row).max())));
    channels
}

fn flight(drop: &ShownDrop<'_>) -> Motion {
    let rows = rows(drop.samples);
    let limits = &drop.mission.limits.safety;
    let cost = |s: &&Sample| StateCost::of_sample(s, limits);
    let mut channels = motion(&rows, |s| s.t_s, |s| &s.state.body, cost);
    let phase = |s: &&Sample| match s.phase {
        Phase::Hanging => 0.0,
        Phase::Falling => 1.0,
        Phase::Powered => 2.0,
    };
    channels.push(Channel::new("phase", 1.0, rows.iter().map(phase)));
    for i in 0..drop.mission.vehicle.rotors.len() {
        let thrust = rows.iter().map(|s| s.balance.thrust_n[i]);
        channels.push(Channel::scaled(&format!("thrust_{}_n", i + 1), thrust));
        let speed = rows.iter().map(|s| s.state.rotor_speed[i]);
        channels.push(Channel::scaled(&format!("rotor_speed_{}_rad_s", i + 1), speed));
    }
    if !drop.mission.site.wind.is_steady() {
        for (i, name) in WINDS.iter().enumerate() {
            channels.push(Channel::new(name, VELOCITY_M_S, rows.iter().map(|s| s.wind_ned[i])));
        }
    }
    if rows.iter().any(|s| s.canopy.is_some()) {
        let place = |s: &Sample, i: usize| s.canopy.map_or(f64::NAN, |canopy| canopy.state.p_ned[i]);
        for (i, name) in CANOPY.iter().enumerate() {
            channels.push(Channel::new(name, POSITION_M, rows.iter().map(|s| place(s, i))));
        }
        let tension = rows.iter().map(|s| s.canopy.map_or(f64::NAN, |canopy| canopy.tension_n));
        channels.push(Channel::scaled("riser_tension_n", tension));
    }
    if rows.iter().any(|s| s.bus.is_some()) {
        let of_bus = |of: fn(&BusState) -> f64| rows.iter().map(move |s| s.bus.as_ref().map_or(f64::NAN, of));
        channels.push(Channel::scaled("bus_v", of_bus(|bus| bus.bus_v)));
        channels.push(Channel::scaled("pack_current_a", of_bus(|bus| bus.pack_a)));
    }
    Motion { count: rows.len(), channels }
}

/// The plan, from where the flight was when the rotors were freed; none without a release.
fn planned(drop: &ShownDrop<'_>, times: &Times) -> Option<Motion> {
    let (plan, free_s) = (drop.plan?, times.free_s?);
    let rows = plan_motion(plan, place_at(drop.samples, free_s));
    let limits = &drop.mission.limits.safety;
    let mut channels = motion(&rows, |row| row.0, |row| &row.1, |row| StateCost::of(&row.1, limits));
    let thrusts: Vec<_> = rows.iter().map(|row| plan.thrust_n(row.0)).collect();
    for i in 0..plan.n_rotors() {
        let thrust = thrusts.iter().map(|t| t[i]);
        channels.push(Channel::scaled(&format!("thrust_{}_n", i + 1), thrust));
    }
    Some(Motion { count: rows.len(), channels })
}
