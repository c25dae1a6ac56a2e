//! Numbers of a mission that its vehicle contradicts: they are no mistake of form, so that the mission loads,
//! but whoever wrote them should know.

use super::plan::PlanSettings;
use super::release::Release;
use crate::odd::Odd;
use nalgebra::Vector3;
use samara_core::assess::Limits;
use samara_core::frames::{LEVEL, Quaternion};
use samara_core::hints::No;
use samara_core::math;
use samara_core::model::rigid_body::BodyState;
use samara_core::model::{Atmosphere, Environment, Interference, Planet, RotorLimits, SAME_AXIS, Vehicle};
use samara_core::plan::PlanState;
use samara_core::sim::StateCost;
use samara_core::sim::two_bodies::SWING_GROWTH_MAX;

/// A number may pass what the rotors can do by this part: data sheets are rounded.
const ROUNDING: f64 = 0.01;
/// Motions that differ by no more than this part are the same.
const SAME_MOTION: f64 = 0.02;
/// Least ratio of the rotors' thrust to the weight at which a vehicle can be steered with room to spare.
const THRUST_TO_WEIGHT: f64 = 1.2;
/// Least height between two discs, as a part of their radius, at which one passes above the other.
const APART_IN_HEIGHT: f64 = 0.05;
/// Radius of the propellers over the arm, where a vehicle file gives none.
const RADIUS_PER_ARM: f64 = 0.5;
/// Least radius of gyration, as a part of how far the rotors reach: a four-hundredth of the mass at their
/// ends gives it, and motors weigh more.
const LEAST_GYRATION: f64 = 0.05;
/// Part of a world's density at an altitude by which that of a site may differ: weather stays well within.
const OTHER_AIR: f64 = 0.15;

/// The moment of inertia that no body of the vehicle's mass and size has, if one is such: its radius of
/// gyration is beyond the reach of the rotors, or next to nothing. `radius_m` is that of the propellers [m],
/// where it is known.
pub(super) fn of_inertia(vehicle: &Vehicle, radius_m: Option<f64>) -> Option<Odd> {
    let arm_m = vehicle.rotors.iter().map(|rotor| rotor.position_body_m.norm()).fold(0.0, f64::max);
    let reach_m = arm_m + radius_m.unwrap_or(RADIUS_PER_ARM * arm_m);
    let sane_m = LEAST_GYRATION * reach_m..=reach_m;
    let moments = vehicle.mass.inertia_kg_m2.diagonal();
    let gyration_m = moments.map(|moment| (moment / vehicle.mass.mass_kg).sqrt());
    let off = gyration_m.iter().filter(|k| !sane_m.contains(k)).copied();
    // The one that is farthest off, either way.
    let beyond = |k: f64| (k / reach_m).max(sane_m.start() / k);
    let worst_m = off.reduce(|a, b| if beyond(b) > beyond(a) { b } else { a })?;
    let axis = gyration_m.iter().position(|k| *k == worst_m)?;
    let expected = match worst_m > reach_m {
        true => format!("at most {reach_m:.3} m are expected, all mass at their ends"),
        false => format!("at least {:.3} m are expected, some of the mass at their ends", sane_m.start()),
    };
    Some(Odd::new(
        No::Inertia,
        format!(
            "vehicle: inertia_kg_m2 {} about {} is a radius of gyration of {} m, and the rotors reach {reach_m:.3} m from the \
         centre: {expected}",
            math::with_digits(moments[axis], 4),
            ["x", "y", "z"][axis],
            math::with_digits(worst_m, 3)
        ),
    ))
}

/// A density that is given as a number and is not that of the altitude, on Earth or Titan, as the gravity has
/// it. That of Mars changes with the seasons.
pub(super) fn of_air_of_another_altitude(environment: &Environment) -> Option<Odd> {
    let Environment { gravity_m_s2, density_kg_m3, atmosphere, .. } = *environment;
    let altitude_m = environment.anchor.altitude_m;
    let planet = Planet::of_gravity(gravity_m_s2, altitude_m).filter(|planet| *planet != Planet::Mars)?;
    let usual = planet.density_kg_m3(altitude_m).ok().filter(|_| atmosphere == Atmosphere::Constant)?;
    let off = density_kg_m3 / usual - 1.0;
    (off.abs() > OTHER_AIR).then(|| {
        Odd::new(No::OtherAir, format!(
            "site.density_kg_m3 {density_kg_m3}: at {altitude_m} m it is {usual:.3} kg/m^3 by {}; here it is {:.0} % {}, and no \
             `site.atmosphere` is named",
            planet.source(),
            100.0 * off.abs(),
            if off > 0.0 { "more" } else { "less" }
        ))
    })
}

/// The closest rotors whose discs of this radius [m] meet, where some do: two in nearly one plane whose hubs
/// are less than a diameter apart, as an arm or a propeller in another unit makes them.
pub(super) fn of_rotors_that_meet(vehicle: &Vehicle, radius_m: f64) -> Option<Odd> {
    let rotors = &vehicle.rotors;
    let pairs = (0..rotors.len()).flat_map(|i| (i + 1..rotors.len()).map(move |k| (i, k)));
    let in_one_plane = pairs.filter_map(|(i, k)| {
        let apart_m = rotors[k].position_body_m - rotors[i].position_body_m;
        let height_m = apart_m.dot(&rotors[i].axis_body).abs();
        (height_m < APART_IN_HEIGHT * radius_m).then_some((apart_m.norm(), i + 1, k + 1))
    });
    let (apart_m, i, k) = in_one_plane.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let diameter_m = 2.0 * radius_m;
    let words = Odd::new(
        No::RotorsMeet,
        format!(
            "vehicle: the propellers of rotors {i} and {k} meet: {apart_m:.3} m from hub to hub, diameter {diameter_m:.3} m"
        ),
    );
    (apart_m < diameter_m).then_some(words)
}

/// The first rotor that stands in another's wake and has no factor for it: its hub lies within half of this
/// radius [m], where it is known, of the axis of one above it.
pub(super) fn of_a_wake_without_a_factor(vehicle: &Vehicle, radius_m: Option<f64>) -> Option<Odd> {
    let near_m = radius_m.map_or(SAME_AXIS, |radius_m| (0.5 * radius_m).max(SAME_AXIS));
    let rotors = &vehicle.rotors;
    let pairs = (0..rotors.len()).flat_map(|below| (0..rotors.len()).map(move |above| (below, above)));
    let mut in_a_wake = pairs.filter(|(below, above)| {
        let beside_m = rotors[*below].beside_the_axis_above_m(&rotors[*above]);
        rotors[*below].interference == Interference::NONE && beside_m.is_some_and(|m| m <= near_m)
    });
    let (below, above) = in_a_wake.next()?;
    Some(Odd::new(
        No::Wake,
        format!(
            "vehicle: rotor {} stands in the wake of rotor {} and makes what it makes alone: `coaxial` gives the factors of \
         thrust and torque, for rotors on one axis",
            below + 1,
            above + 1
        ),
    ))
}

/// What is odd, each with the key, the number and what the vehicle makes of it; `start` is the state that the
/// plan starts from, `descent_m_s` the speed under the canopy [m/s].
pub(super) fn of(
    vehicle: &Vehicle,
    environment: &Environment,
    plan: &PlanSettings,
    limits: &Limits,
    descent_m_s: f64,
    start: &PlanState,
) -> Vec<Odd> {
    let (density, gravity) = (environment.density_kg_m3, environment.gravity_m_s2);
    let rotors = RotorLimits::of(vehicle, density);
    let mut odd = Vec::new();
    let (thrust, slew) = (plan.thrust_max_n, plan.thrust_slew_n_s);
    if thrust > (1.0 + ROUNDING) * rotors.thrust_n {
        odd.push(Odd::new(No::PlanThrust, format!(
            "plan.thrust_max_n {thrust} N: a rotor makes {:.2} N at full throttle in air of {density} kg/m^3",
            rotors.thrust_n
        )));
    }
    if slew.is_finite() && slew > (1.0 + ROUNDING) * rotors.thrust_slew_n_s {
        odd.push(Odd::new(
            No::PlanSlew,
            format!(
                "plan.thrust_slew_n_s {slew} N/s: a rotor's thrust comes and goes at {:.1} N/s in the mean",
                rotors.thrust_slew_n_s
            ),
        ));
    }
    let ratio = RotorLimits::lift_n(vehicle, density) / (vehicle.mass.mass_kg * gravity);
    if ratio < THRUST_TO_WEIGHT {
        odd.push(Odd::new(No::ThrustToWeight, format!(
            "site: the rotors lift {ratio:.2} of the weight in air of {density} kg/m^3; from {THRUST_TO_WEIGHT} on there \
             is room to steer"
        )));
    }
    if let Some(terminal) =
        terminal_speed_m_s(vehicle, environment).filter(|terminal| descent_m_s > *terminal)
    {
        odd.push(Odd::new(No::Descent, format!(
            "parachute.descent_m_s {descent_m_s} m/s: without its parachute the vehicle falls at {terminal:.1} m/s at most"
        )));
    }
    let q: Quaternion = [start[0], start[1], start[2], start[3]];
    let at_t0 = BodyState {
        p_ned: Vector3::zeros(),
        q_ned_from_body: q,
        v_ned: Vector3::new(start[4], start[5], start[6]),
        omega_body: Vector3::new(start[7], start[8], start[9]),
    };
    let cost = StateCost::of(&at_t0, &limits.safety);
    if cost.max() > 1.0 {
        odd.push(Odd::new(
            No::ReleasePassesLimits,
            format!(
                "limits: passed by the release already: J_state is {:.2} at t = 0 ({:.1} m/s)",
                cost.max(),
                at_t0.v_ned.norm()
            ),
        ));
    }
    if limits.steady_within_m_s > 0.5 * limits.safety.speed_m_s {
        odd.push(Odd::new(
            No::SteadyWide,
            format!(
                "limits.steady_within_m_s {} m/s: more than half of limits.speed_m_s",
                limits.steady_within_m_s
            ),
        ));
    }
    if let Some(over_s) = limits.steady_mean_over_s.filter(|over_s| *over_s > plan.horizon_s) {
        odd.push(Odd::new(
            No::SteadyLong,
            format!("limits.steady_mean_over_s {over_s} s: longer than plan.horizon_s, {} s", plan.horizon_s),
        ));
    }
    odd
}

/// What the two bodies of a parachute do otherwise than its kinematic keys say, which flights from t = 0 go
/// by: each with the key, the number and the motion.
pub(super) fn of_two_bodies(
    vehicle: &Vehicle,
    environment: &Environment,
    release: &Release,
    amplitude_rad: f64,
) -> Vec<Odd> {
    let parachute = &release.parachute;
    let Some(suspension) = &parachute.suspension else { return Vec::new() };
    let Ok(descent) = suspension.steady_descent(vehicle, environment) else { return Vec::new() };
    let mode = suspension.small_swings(&vehicle.mass, environment, &descent).swing();
    let apart = |a: f64, b: f64| (a - b).abs() > SAME_MOTION * b.abs();
    let mut odd = Vec::new();
    if apart(parachute.descent_m_s, descent.speed_m_s) {
        odd.push(Odd::new(
            No::TwoBodies,
            format!(
                "parachute.descent_m_s {} m/s: vehicle and canopy sink at {:.3} m/s",
                parachute.descent_m_s, descent.speed_m_s
            ),
        ));
    }
    let swings = amplitude_rad != 0.0 || parachute.pendulum.amplitude_rad != 0.0;
    let left = math::exp(mode.rate.re * release.hang_s) * SWING_GROWTH_MAX;
    if swings && left < 1.0 - SAME_MOTION {
        odd.push(Odd::new(No::TwoBodies, format!(
            "release.hang_s {} s: the canopy's drag leaves {:.0} % of the swing at the release, which begins {SWING_GROWTH_MAX} \
             times as large",
            release.hang_s,
            100.0 * left
        )));
    }
    odd
}

/// Speed of the vehicle's level fall with its rotors at rest [m/s]; `None` when it is above 1000 m/s.
pub(super) fn terminal_speed_m_s(vehicle: &Vehicle, environment: &Environment) -> Option<f64> {
    const FASTEST_M_S: f64 = 1000.0;
    let calm = Environment { wind_ned_m_s: Vector3::zeros(), ..environment.clone() };
    let weight_n = vehicle.mass.mass_kg * environment.gravity_m_s2;
    let falls_on = |speed_m_s: f64| {
        let state = BodyState {
            p_ned: Vector3::zeros(),
            q_ned_from_body: LEVEL,
            v_ned: Vector3::new(0.0, 0.0, speed_m_s),
            omega_body: Vector3::zeros(),
        };
        -vehicle.aero_load(&calm, &state).force_body.z < weight_n
    };
    let (mut low, mut high) = (0.0, FASTEST_M_S);
    if falls_on(high) {
        return None;
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if falls_on(middle) { low = middle } else { high = middle }
    }
    Some(low)
}
