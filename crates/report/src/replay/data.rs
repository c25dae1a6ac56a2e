//! The flight, the plan and what is known about them, as the page's script takes them.

use nalgebra::Vector3;
use serde::Serialize;

use super::channel::Channel;
use crate::flight_columns::{PlanRow, flight_columns, plan_columns};
use crate::json::{VERSION, object};
use crate::marks::{Times, marks};
use crate::plan_motion::{place_at, plan_motion};
use crate::rows::Columns;
use crate::shown_drop::ShownDrop;
use samara_core::model::RotationSense;
use samara_core::sim::Sample;
use samara_core::trajectory::Trajectory;
use samara_core::units::DEG_PER_RAD;
use samara_mission::Mission;

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
pub(super) struct Motion {
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

/// What is shown of a flight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shown {
    /// All that is known.
    All,
    /// The motion alone, not what acted on it.
    Motion,
}

/// What is known of a flight by its mission alone.
pub(super) fn about(mission: &Mission, gains: &str) -> impl Serialize {
    let limits = &mission.limits.safety;
    let environment = &mission.site.environment;
    let parachute = &mission.release.parachute;
    let pack_limit_a = mission.electric.as_ref().map(|battery| battery.pack().limits().current_max_a);
    let pack_limit_a = pack_limit_a.filter(|limit_a| limit_a.is_finite());
    let rotors = mission.vehicle.rotors.iter().map(|rotor| {
        object! {
            position_body_m: <[f64; 3]>::from(rotor.position_body_m),
            axis_body: <[f64; 3]>::from(rotor.axis_body),
            spin: match rotor.spin { RotationSense::Cw => "cw", RotationSense::Ccw => "ccw" },
        }
    });
    object! {
        format: 1,
        version: VERSION,
        mission: mission.name.clone(),
        vehicle: mission.vehicle_name.clone(),
        gains: gains.to_owned(),
        seed: mission.seed,
        input_hash: mission.inputs.hash.clone(),
        target_v_ned_m_s: <[f64; 3]>::from(mission.target_v_ned),
        wind_ned_m_s: <[f64; 3]>::from(environment.wind_ned_m_s),
        standing: mission.release.standing,
        ground_down_m: mission.site.ground.map(|ground| ground.down_m),
        canopy_length_m: parachute.line_m(),
        // What neither climbs nor sinks under its load.
        balloon: parachute.descent_m_s == 0.0 && parachute.suspension.is_none(),
        limits: object! {
            speed_m_s: limits.speed_m_s,
            pitch_deg: limits.pitch_rad * DEG_PER_RAD,
            pitch_rate_deg_s: limits.pitch_rate_rad_s * DEG_PER_RAD,
            thrust_n: mission.plan.thrust_max_n,
            rotor_rad_s: mission.vehicle.motor.omega_max_rad_s(),
            #[serde(flatten)] pack: pack_limit_a.map(|limit_a| object! { pack_current_a: limit_a }),
        },
        rotors: rotors.collect::<Vec<_>>(),
    }
}

/// The page's data as JSON without `<`, which no block of a page ends in.
pub(super) fn object(drop: &ShownDrop<'_>, shown: Shown) -> String {
    let ShownDrop { mission, verdict, .. } = *drop;
    let times = Times::of(drop);
    let object = object! {
        #[serde(flatten)] about: about(mission, drop.gains),
        verdict: verdict.map(|v| object! { j_tpf: v.outcome.j_tpf, decided_by: v.decided_by }),
        times: object! { released_s: times.released_s, free_s: times.free_s, steady_s: times.steady_s },
        marks: marks(drop, &times),
        flight: flight(drop, shown),
        plan: planned(drop, &times),
    };
    // Structs of strings, numbers and lists of them always serialise.
    serde_json::to_string(&object).unwrap_or_default().replace('<', "\\u003c")
}

/// Channels of every motion, with their steps, named as the columns of `flight.csv`.
const MOTION: [(f64, &[&str]); 6] = [
    (TIME_S, &["t_s"]),
    (POSITION_M, &["north_m", "east_m", "down_m"]),
    (ATTITUDE, &["q0", "q1", "q2", "q3"]),
    (VELOCITY_M_S, &["vn_m_s", "ve_m_s", "vd_m_s"]),
    (RATE_RAD_S, &["p_rad_s", "q_rad_s", "r_rad_s"]),
    (COST, &["j_state"]),
];
/// Channels of a flight that has them.
const AROUND: [(f64, &[&str]); 2] = [
    (VELOCITY_M_S, &["wind_n_m_s", "wind_e_m_s", "wind_d_m_s"]),
    (POSITION_M, &["canopy_north_m", "canopy_east_m", "canopy_down_m"]),
];

/// Further channels of a flight that has them.
const AT_LAST: [&str; 3] = ["riser_tension_n", "bus_v", "pack_current_a"];

/// Columns in steps as channels, those that have values.
fn stepped<R>(columns: &Columns<R>, rows: &[&R], steps: &[(f64, &[&str])]) -> Vec<Channel> {
    let each = steps.iter().flat_map(|(step, names)| names.iter().map(move |name| (step, name)));
    let channel = |(step, name): (&f64, &&str)| {
        Some(Channel::new(name, *step, columns.values(name, rows)?.into_iter()))
    };
    each.filter_map(channel).collect()
}

/// A column as a channel, where it has values.
fn scaled<R>(columns: &Columns<R>, rows: &[&R], name: &str) -> Option<Channel> {
    Some(Channel::scaled(name, columns.values(name, rows)?.into_iter()))
}

fn flight(drop: &ShownDrop<'_>, shown: Shown) -> Motion {
    let (rows, columns) = (rows(drop.samples), flight_columns(drop.mission, false));
    let scaled = |name: String| scaled(&columns, &rows, &name);
    let mut channels = stepped(&columns, &rows, &MOTION);
    channels.push(Channel::new("phase", 1.0, rows.iter().map(|s| f64::from(s.phase as u8))));
    if shown == Shown::Motion {
        return Motion { count: rows.len(), channels };
    }
    let of_rotor = |i| [format!("thrust_{i}_n"), format!("rotor_speed_{i}_rad_s")];
    channels.extend((1..=drop.mission.vehicle.rotors.len()).flat_map(of_rotor).filter_map(scaled));
    channels.extend(stepped(&columns, &rows, &AROUND));
    channels.extend(AT_LAST.map(str::to_owned).into_iter().filter_map(scaled));
    Motion { count: rows.len(), channels }
}

/// The plan, from where the flight was when the rotors were freed, and its time since then; none without a
/// release.
fn planned(drop: &ShownDrop<'_>, times: &Times) -> Option<Motion> {
    let (plan, free_s) = (drop.plan?, times.free_s?);
    Some(plan_from(drop.mission, plan, place_at(drop.samples, free_s)))
}

/// A plan that begins at a place, NED [m], and its time since then.
pub(super) fn plan_from(mission: &Mission, plan: &Trajectory, start_ned: Vector3<f64>) -> Motion {
    let motion = plan_motion(plan, start_ned);
    let rows: Vec<PlanRow> = motion.into_iter().map(|instant| PlanRow::of(plan, 0.0, instant)).collect();
    let (rows, columns) = (rows.iter().collect::<Vec<_>>(), plan_columns(mission));
    let mut channels = stepped(&columns, &rows, &MOTION);
    let thrusts = (1..=plan.n_rotors()).map(|i| format!("thrust_{i}_n"));
    channels.extend(thrusts.filter_map(|name| scaled(&columns, &rows, &name)));
    Motion { count: rows.len(), channels }
}

/// Whether a page shows a column of a flight log.
pub(super) fn is_shown(column: &str) -> bool {
    let among = |all: &[(f64, &[&str])]| all.iter().any(|(_, names)| names.contains(&column));
    let of_rotor =
        |begin: &str, end: &str| column.strip_prefix(begin).is_some_and(|rest| rest.ends_with(end));
    among(&MOTION)
        || among(&AROUND)
        || AT_LAST.contains(&column)
        || column == "phase"
        || of_rotor("thrust_", "_n")
        || of_rotor("rotor_speed_", "_rad_s")
}
