//! What the numbers of a mission amount to: derived quantities in groups, and what is odd about them.

use std::sync::Arc;

use nalgebra::Vector3;
use samara_core::control::Airframe;
use samara_core::frames::{LEVEL, pitch};
use samara_core::hints::No;
use samara_core::model::rigid_body::BodyState;
use samara_core::model::rotor_start::BeforeStart;
use samara_core::model::wind::LEAST_CONVECTION_M_S;
use samara_core::model::{Rotor, RotorLimits, RotorStart, trim};
use samara_core::sim::rotor_start::start_in_steady_flow;
use samara_core::sim::{ElectricBattery, StateCost};
use samara_core::tune::{ReleaseCase, unknowns};
use samara_core::uncertain::JointNormal;
use samara_core::units::DEG_PER_RAD;

use super::mission::Mission;
use super::odd::Odd;

const C_PER_AH: f64 = 3600.0;

/// Derived quantities of a mission.
#[derive(Clone, Debug, PartialEq)]
pub struct Derived {
    /// Groups of quantities, in the order in which they are read.
    pub groups: Vec<DerivedGroup>,
    /// Sentences about what is odd, each with its key: [`Mission::contradictions`] and what is found here. A
    /// mission without any is fine.
    pub odd: Vec<Odd>,
}

/// Quantities that belong together.
#[derive(Clone, Debug, PartialEq)]
pub struct DerivedGroup {
    /// Name: "rotors", "release", ..
    pub name: &'static str,
    /// The quantities.
    pub rows: Vec<DerivedRow>,
}

/// A quantity.
#[derive(Clone, Debug, PartialEq)]
pub struct DerivedRow {
    /// Key in JSON, which ends in the unit.
    pub key: &'static str,
    /// Name for the reader.
    pub label: &'static str,
    /// Unit; empty where there is none.
    pub unit: &'static str,
    /// The value, or its components; empty where it is not known.
    pub values: Vec<f64>,
    /// Remark; empty where there is none.
    pub note: String,
}

fn row(
    key: &'static str,
    label: &'static str,
    unit: &'static str,
    values: &[f64],
    note: String,
) -> DerivedRow {
    DerivedRow { key, label, unit, values: values.to_vec(), note }
}

/// The derived quantities of a mission.
pub fn derived(mission: &Mission) -> Derived {
    let rotors = RotorLimits::of(&mission.vehicle, mission.site.environment.density_kg_m3);
    let mut odd = mission.contradictions();
    if let Err(e) = Airframe::new(&mission.vehicle, &mission.site.environment) {
        odd.push(Odd::new(No::CannotControl, format!("vehicle: the cascade cannot control it: {e}")));
    }
    let mut groups = vec![of_the_vehicle(mission), of_the_rotors(mission, &rotors)];
    if let Some(battery) = &mission.electric {
        groups.push(of_the_battery(mission, battery, &mut odd));
    }
    if mission.site.environment.wind_ned_m_s != Vector3::zeros() || !mission.site.wind.is_steady() {
        groups.push(of_the_wind(mission));
    }
    groups.extend(of_the_vortex_ring(mission));
    groups.push(of_the_sensors(mission));
    groups.push(of_what_is_uncertain(mission));
    if !mission.release.standing {
        groups.push(of_the_release(mission));
        if let Some(start) = &mission.vehicle.start {
            groups.push(of_the_start(mission, start, &mut odd));
        }
    }
    groups.push(of_the_target(mission, &rotors, &mut odd));
    if !mission.release.standing {
        groups.push(of_the_plan(mission, &rotors, &mut odd));
        groups.push(of_the_studies(mission));
    }
    Derived { groups, odd }
}

fn of_the_vehicle(mission: &Mission) -> DerivedGroup {
    let (vehicle, site) = (&mission.vehicle, &mission.site.environment);
    let weight_n = vehicle.mass.mass_kg * site.gravity_m_s2;
    let arms = vehicle.rotors.iter().map(|r| r.position_body_m.xy().norm());
    let disc_loading = mission
        .rotor_radius_m
        .map(|radius| weight_n / (vehicle.rotors.len() as f64 * std::f64::consts::PI * radius * radius));
    let unknown = || "not known: the vehicle file gives no rotor radius_m".to_owned();
    let inertia = vehicle.mass.inertia_kg_m2.diagonal();
    let gyration_m = inertia.map(|moment| (moment / vehicle.mass.mass_kg).sqrt());
    let rows = vec![
        row("mass_kg", "mass", "kg", &[vehicle.mass.mass_kg], String::new()),
        row("inertia_kg_m2", "inertia about x, y, z", "kg m^2", inertia.as_slice(), String::new()),
        row("gyration_m", "radius of gyration about them", "m", gyration_m.as_slice(), String::new()),
        row("rotors", "rotors", "", &[vehicle.rotors.len() as f64], String::new()),
        row("arm_m", "farthest rotor from the centre", "m", &[arms.fold(0.0, f64::max)], String::new()),
        row("gravity_m_s2", "gravity", "m/s^2", &[site.gravity_m_s2], String::new()),
        row("density_kg_m3", "density of the air", "kg/m^3", &[site.density_kg_m3], String::new()),
        row("weight_n", "weight at the site", "N", &[weight_n], String::new()),
        row(
            "disc_loading_n_m2",
            "disc loading at the site",
            "N/m^2",
            disc_loading.as_slice(),
            disc_loading.map_or_else(unknown, |_| String::new()),
        ),
    ];
    DerivedGroup { name: "vehicle", rows }
}

fn of_the_rotors(mission: &Mission, rotors: &RotorLimits) -> DerivedGroup {
    let (vehicle, site) = (&mission.vehicle, &mission.site.environment);
    let density = site.density_kg_m3;
    let weight_n = vehicle.mass.mass_kg * site.gravity_m_s2;
    let lift_n = RotorLimits::lift_n(vehicle, density);
    let throttle = vehicle.hover_throttle(site.gravity_m_s2, density);
    // A rotor alone, and the lower ones of coaxial pairs.
    let mut shares: Vec<f64> = Vec::new();
    for share in vehicle.rotors.iter().map(|rotor| rotor.interference.thrust) {
        if !shares.contains(&share) {
            shares.push(share);
        }
    }
    let alone_n = throttle * throttle * vehicle.static_thrust_n(density);
    let hover_n: Vec<f64> = shares.iter().map(|share| share * alone_n).collect();
    let [of_pairs, of_the_lower, of_all] = match shares.len() {
        1 => [""; 3],
        _ => ["upper, lower", "of a pair the lower", "all rotors, the lower ones with what the upper leave"],
    };
    let rows = vec![
        row("thrust_max_n", "greatest thrust of a rotor", "N", &[rotors.thrust_n], of_the_lower.to_owned()),
        row("thrust_to_weight", "thrust to weight", "", &[lift_n / weight_n], of_all.to_owned()),
        row("hover_thrust_n", "thrust of a rotor in hover", "N", &hover_n, of_pairs.to_owned()),
        row("hover_throttle", "throttle in hover", "", &[throttle], "1 is full".to_owned()),
        row("thrust_slew_n_s", "rate of change of thrust", "N/s", &[rotors.thrust_slew_n_s], String::new()),
        row(
            "thrust_time_s",
            "time for 90 % of the thrust",
            "s",
            &[0.9 * rotors.thrust_n / rotors.thrust_slew_n_s],
            "from rest or to none, the slower".to_owned(),
        ),
    ];
    DerivedGroup { name: "rotors", rows }
}

/// The battery at the start: in rest, in hover, and with all rotors at full throttle in still air.
fn of_the_battery(mission: &Mission, battery: &ElectricBattery, odd: &mut Vec<Odd>) -> DerivedGroup {
    let (vehicle, site) = (&mission.vehicle, &mission.site.environment);
    let (pack, charge, n) = (battery.pack(), battery.charge(), vehicle.rotors.len() as f64);
    let limits = pack.limits();
    let throttle = vehicle.hover_throttle(site.gravity_m_s2, site.density_kg_m3);
    // Power, voltage and current of the bus with all rotors at a part of their speed at full throttle.
    let at = |share: f64| {
        let omega_rad_s = share * vehicle.motor.omega_max_rad_s();
        let torque_nm = vehicle.rotor.static_load(omega_rad_s, site.density_kg_m3).torque_nm;
        let of_rotors = vehicle.rotors.iter().map(|rotor| {
            pack.steady_power_w(&vehicle.motor, omega_rad_s, rotor.interference.torque * torque_nm)
        });
        let power_w: f64 = of_rotors.sum();
        (power_w, pack.bus_v_under(power_w, charge).map(|bus_v| (bus_v, power_w / bus_v)))
    };
    let capacity_ah = battery.capacity_c() / C_PER_AH;
    let mut rows = vec![
        row("capacity_ah", "charge of the full pack", "A h", &[capacity_ah], String::new()),
        row("open_circuit_v", "voltage without load", "V", &[battery.at_rest().bus_v], String::new()),
    ];
    let named = [
        (["hover_power_w", "hover_bus_v", "hover_current_a"], ["hover", "power in hover"], throttle),
        (["full_power_w", "full_bus_v", "full_current_a"], ["full throttle", "power at full throttle"], 1.0),
    ];
    for ([power_key, voltage_key, current_key], [name, label], share) in named {
        let (power_w, bus) = at(share);
        let Some((bus_v, current_a)) = bus else {
            odd.push(Odd::new(
                No::BatteryTooWeak,
                format!("battery.electric: {name} takes {power_w:.0} W, more than the battery can give"),
            ));
            continue;
        };
        let margin = (limits.current_max_a / current_a).min(limits.esc_current_max_a * n / current_a);
        if margin < 1.0 {
            odd.push(Odd::new(No::BatteryTooWeak, format!(
                "battery.electric: {name} in still air takes {current_a:.1} A, and the limits of pack and speed controllers \
                 leave {:.1} A",
                margin * current_a
            )));
        }
        let lasts = format!("lasts {:.1} min", 60.0 * charge * capacity_ah / current_a);
        rows.extend([
            row(power_key, label, "W", &[power_w], "rotors alone, in still air".to_owned()),
            row(voltage_key, "its bus voltage", "V", &[bus_v], String::new()),
            row(current_key, "its current of the pack", "A", &[current_a], lasts),
        ]);
    }
    DerivedGroup { name: "battery", rows }
}

/// The wind where the vehicle is released.
fn of_the_wind(mission: &Mission) -> DerivedGroup {
    let (site, wind) = (&mission.site.environment, &mission.site.wind);
    let mean = site.wind_ned_m_s;
    let mut rows = vec![row("wind_ned_m_s", "mean wind, NED", "m/s", mean.as_slice(), String::new())];
    if !wind.gusts.is_empty() {
        rows.push(row("gusts", "gusts", "", &[wind.gusts.len() as f64], String::new()));
    }
    if let Some(turbulence) = &wind.turbulence {
        let scale_m = turbulence.scale.at_height_m(site.anchor.altitude_m - wind.ground_altitude_m);
        let through_m_s = (mission.target_v_ned - mean).norm().max(LEAST_CONVECTION_M_S);
        let passing_s = scale_m.map(|length_m| length_m / through_m_s);
        let axes = || "along the mean wind, across it, down".to_owned();
        let (sigma, at_target) = (&turbulence.sigma_m_s, "at the target's speed through the air".to_owned());
        rows.extend([
            row("turbulence_m_s", "standard deviation of turbulence", "m/s", sigma, axes()),
            row("eddies_m", "scale of its eddies", "m", &scale_m, axes()),
            row("eddies_s", "time in which they pass", "s", &passing_s, at_target),
        ]);
    }
    DerivedGroup { name: "wind at the release", rows }
}

/// How thrusts fluctuate in the vortex ring, where they do.
fn of_the_vortex_ring(mission: &Mission) -> Option<DerivedGroup> {
    let ring = mission.site.wind.ring?;
    let (vehicle, site) = (&mission.vehicle, &mission.site.environment);
    let mut rows = vec![
        row(
            "thrust_rms_share",
            "standard deviation of a thrust, over its mean",
            "",
            &[ring.rms_share],
            String::new(),
        ),
        row("frequency_hz", "corner frequency", "Hz", &[ring.frequency_hz], String::new()),
    ];
    if let Rotor::BladeElement(table) = &vehicle.rotor {
        let radius_m = table.radius_m();
        let area_m2 = std::f64::consts::PI * radius_m * radius_m * vehicle.rotors.len() as f64;
        let v_h_m_s =
            (0.5 * vehicle.mass.mass_kg * site.gravity_m_s2 / (site.density_kg_m3 * area_m2)).sqrt();
        let relative = ring.frequency_hz * 2.0 * radius_m / v_h_m_s;
        rows.push(row("frequency_2r_per_v_h", "the same, over v_h/(2 R)", "", &[relative], String::new()));
    }
    Some(DerivedGroup { name: "fluctuation in the vortex ring", rows })
}

/// The greatest readings of the inertial sensors; greater ones wrap in PX4, whose simulator hands them on as
/// 16 bits of a range (SimulatorMavlink.cpp, PX4 #23469).
fn of_the_sensors(mission: &Mission) -> DerivedGroup {
    let sensors = &mission.sensors;
    let ranged = |key, label, unit, range: Option<f64>, most: &str| {
        let note = match range {
            Some(_) => String::new(),
            None => format!("no range: readings beyond {most} are sent, and wrap in PX4"),
        };
        row(key, label, unit, range.as_slice(), note)
    };
    let rows = vec![
        ranged(
            "accelerometer_range_m_s2",
            "greatest reading, accelerometer",
            "m/s^2",
            sensors.accelerometer.range,
            "16 g",
        ),
        ranged(
            "gyroscope_range_rad_s",
            "greatest reading, gyroscope",
            "rad/s",
            sensors.gyroscope.range,
            "2000 deg/s",
        ),
    ];
    DerivedGroup { name: "sensors", rows }
}

/// What may be off what is known, and how far: as mission and vehicle say, or what searches take where
/// neither says anything.
fn of_what_is_uncertain(mission: &Mission) -> DerivedGroup {
    let usual = || Arc::new(unknowns::usual(mission.target_v_ned.norm()));
    let (name, uncertain) = match &mission.uncertain {
        Some(uncertain) => ("uncertain, drawn in all that is random", uncertain.clone()),
        None => ("uncertain, in searches alone: no file says", usual()),
    };
    let rows = uncertain.quantities().into_iter().filter_map(|quantity| {
        let distribution = uncertain.of(quantity)?;
        let (mean, sigma) = distribution.mean_and_sigma();
        let mut remark = distribution.words();
        for other in uncertain.joint_of(quantity).map_or(&[][..], JointNormal::quantities) {
            let joint = uncertain.joint_of(quantity).and_then(|joint| joint.correlation(quantity, *other));
            if let Some(correlation) = joint.filter(|_| *other != quantity) {
                remark += &format!(", correlation {correlation:.2} with {}", other.key());
            }
        }
        let unit = if quantity.is_share() { "of it" } else { quantity.unit() };
        Some(row(quantity.key(), quantity.words(), unit, &[mean, sigma], remark))
    });
    DerivedGroup { name, rows: rows.collect() }
}

/// The state that a plan starts from.
fn start(mission: &Mission) -> BodyState {
    let x = mission.plan_initial_state();
    BodyState {
        p_ned: Vector3::zeros(),
        q_ned_from_body: [x[0], x[1], x[2], x[3]],
        v_ned: Vector3::new(x[4], x[5], x[6]),
        omega_body: Vector3::new(x[7], x[8], x[9]),
    }
}

fn of_the_release(mission: &Mission) -> DerivedGroup {
    let (release, random) = (&mission.release, &mission.study.monte_carlo);
    let begin = start(mission);
    let cost = StateCost::of(&begin, &mission.limits.safety);
    let deg = |rad: f64| rad * DEG_PER_RAD;
    let widest = 3.0 * random.amplitude_sigma_rad;
    let rate = random.omega_rad_s * widest;
    let fastest = mission.terminal_speed_m_s();
    let three_sigma = || "three standard deviations".to_owned();
    let mut rows = vec![
        row(
            "descent_m_s",
            "descent under the canopy",
            "m/s",
            &[release.parachute.descent_m_s],
            String::new(),
        ),
        row("delay_s", "fall before the rotors start", "s", &[release.parachute.delay_s], String::new()),
        row(
            "terminal_speed_m_s",
            "terminal speed of the fall",
            "m/s",
            fastest.as_slice(),
            fastest.map_or_else(|| "none below 1000 m/s".to_owned(), |_| "level, rotors stopped".to_owned()),
        ),
        row("start_v_ned_m_s", "velocity at t = 0, NED", "m/s", begin.v_ned.as_slice(), String::new()),
        row("start_pitch_deg", "pitch at t = 0", "deg", &[deg(pitch(begin.q_ned_from_body))], String::new()),
        row(
            "start_pitch_rate_deg_s",
            "pitch rate at t = 0",
            "deg/s",
            &[deg(begin.omega_body.y)],
            String::new(),
        ),
        row(
            "start_j_state",
            "share of the limits used at t = 0",
            "",
            &[cost.max()],
            format!("decided by {}", cost.decided_by()),
        ),
        row("swing_deg", "widest random swing", "deg", &[deg(widest)], three_sigma()),
        row("swing_rate_deg_s", "its pitch rate", "deg/s", &[deg(rate)], three_sigma()),
        row("swing_speed_m_s", "its speed sideways", "m/s", &[rate * random.length_m], three_sigma()),
    ];
    if let Some(suspension) = &release.parachute.suspension {
        let two = mission.linearised_parachute();
        let in_drops = || "in whole drops".to_owned();
        rows.extend([
            row("canopy_descent_m_s", "descent of vehicle and canopy", "m/s", &[two.descent_m_s], in_drops()),
            row(
                "canopy_swing_rad_s",
                "swing below the riser",
                "rad/s",
                &[two.pendulum.omega_rad_s],
                in_drops(),
            ),
            row(
                "apparent_mass_kg",
                "apparent mass of the canopy",
                "kg",
                &[suspension.canopy.apparent_mass_kg],
                in_drops(),
            ),
        ]);
    }
    DerivedGroup { name: "release", rows }
}

/// A number in three digits.
fn short(x: f64) -> f64 {
    format!("{x:.2e}").parse().unwrap_or(x)
}

/// Longest start that is tried [s].
const LONGEST_START_S: f64 = 60.0;

/// The start of the rotors in the flow at t = 0.
fn of_the_start(mission: &Mission, rotor_start: &RotorStart, odd: &mut Vec<Odd>) -> DerivedGroup {
    let (vehicle, site) = (&mission.vehicle, &mission.site.environment);
    let begin = start(mission);
    let descent_m_s = mission.linearised_parachute().descent_m_s;
    let v_ned = site.drift_ned_m_s() + Vector3::new(0.0, 0.0, descent_m_s);
    let hanging =
        BodyState { v_ned, q_ned_from_body: LEVEL, omega_body: Vector3::zeros(), p_ned: Vector3::zeros() };
    let settled = |body: &BodyState, i: usize, from: f64| match rotor_start.before {
        BeforeStart::Free => vehicle.settled_speed_rad_s(&site.ambient(), body, i, from),
        BeforeStart::Braked => 0.0,
    };
    let count = vehicle.rotors.len();
    let in_descent: Vec<f64> = (0..count).map(|i| settled(&hanging, i, 0.0)).collect();
    let at_t0: Vec<f64> = (0..count).map(|i| settled(&begin, i, in_descent[i])).collect();
    let sign = || "backwards is negative".to_owned();
    let mut rows = Vec::new();
    if rotor_start.before == BeforeStart::Free {
        rows.push(row("free_descent_rad_s", "free rotors, in the descent", "rad/s", &in_descent, sign()));
        let there = || "where they would settle".to_owned();
        rows.push(row("free_t0_rad_s", "in the flow at t = 0", "rad/s", &at_t0, there()));
    }
    if let Some(esc) = &rotor_start.esc {
        let air = |i: usize| move |omega: f64| vehicle.air_torque_nm(&site.ambient(), &begin, i, omega);
        let needed = |i: usize| rotor_start.torques_needed_nm([at_t0[i], esc.catch_speed_rad_s], air(i));
        let most = (0..count).map(needed).fold([0.0f64; 2], |a, b| [a[0].max(b[0]), a[1].max(b[1])]);
        let longest_s = (f64::from(esc.tries) * (esc.try_s + esc.wait_s)).min(LONGEST_START_S);
        let tried =
            |i: usize| start_in_steady_flow(*rotor_start, &vehicle.motor, at_t0[i], longest_s, air(i)).0;
        let starts: Vec<_> = (0..count).map(tried).collect();
        let caught_s = starts.iter().map(|s| s.and_then(|s| s.caught_at_s)).collect::<Option<Vec<_>>>();
        let slowest_s = caught_s.map(|all| all.into_iter().fold(0.0, f64::max));
        let tries = starts.iter().flatten().map(|s| s.tries).max().unwrap_or(0);
        let of = |torque_nm: f64| format!("{torque_nm} are given");
        let [brake_nm, start_nm] = most;
        rows.extend([
            row("brake_torque_nm", "torque to brake a rotor", "N m", &[brake_nm], of(esc.brake_torque_nm)),
            row("start_torque_nm", "torque to start a rotor", "N m", &[start_nm], of(esc.start_torque_nm)),
            row(
                "caught_after_s",
                "caught after",
                "s",
                slowest_s.as_slice(),
                "in a flow that stays".to_owned(),
            ),
            row("tries", "tries", "", &[f64::from(tries)], format!("{} are given", esc.tries)),
        ]);
        if slowest_s.is_none() {
            odd.push(Odd::new(No::RotorStarts, format!(
                "rotor_start.esc: a rotor does not catch in the flow at t = 0 in {} tries, {} s; braking takes {} N m of {}, starting {} \
                 N m of {}",
                tries,
                short(longest_s),
                short(brake_nm),
                esc.brake_torque_nm,
                short(start_nm),
                esc.start_torque_nm
            )));
        }
    }
    DerivedGroup { name: "start of the rotors", rows }
}

fn of_the_target(mission: &Mission, rotors: &RotorLimits, odd: &mut Vec<Odd>) -> DerivedGroup {
    let mut rows = vec![row(
        "target_v_ned_m_s",
        "target velocity, NED",
        "m/s",
        mission.target_v_ned.as_slice(),
        String::new(),
    )];
    match trim(&mission.vehicle, &mission.site.environment, mission.target_v_ned, 0.0) {
        Err(e) => odd.push(Odd::new(No::TargetNeedsThrust, format!("target_v_ned_m_s: {e}"))),
        Ok(trim) => {
            let thrust_n = &trim.thrust_n[..mission.vehicle.rotors.len()];
            let most = thrust_n.iter().copied().fold(f64::MIN, f64::max);
            if most > mission.plan.thrust_max_n {
                odd.push(Odd::new(
                    No::TargetNeedsThrust,
                    format!(
                        "plan.thrust_max_n {} N: steady flight at the target needs {most:.2} N of a rotor",
                        mission.plan.thrust_max_n
                    ),
                ));
            }
            if thrust_n.iter().any(|thrust| *thrust < 0.0) {
                odd.push(Odd::new(
                    No::TargetNeedsThrust,
                    "target_v_ned_m_s: steady flight there needs a thrust below zero".to_owned(),
                ));
            }
            let off = |angle_rad: f64| [angle_rad * DEG_PER_RAD];
            rows.extend([
                row("trim_pitch_deg", "pitch", "deg", &off(trim.pitch_rad), String::new()),
                row("trim_roll_deg", "roll", "deg", &off(trim.roll_rad), String::new()),
                row("trim_thrust_n", "thrust of each rotor", "N", thrust_n, String::new()),
                row(
                    "trim_thrust_share",
                    "largest share of a rotor's thrust",
                    "",
                    &[most / rotors.thrust_n],
                    String::new(),
                ),
            ]);
        }
    }
    DerivedGroup { name: "steady flight at the target", rows }
}

fn of_the_plan(mission: &Mission, rotors: &RotorLimits, odd: &mut Vec<Odd>) -> DerivedGroup {
    let plan = &mission.plan;
    let begins_s = mission.release.hang_s + mission.release.parachute.delay_s;
    let left_s = mission.duration_s - begins_s - plan.horizon_s;
    if left_s < 0.0 {
        odd.push(Odd::new(No::DurationShort, format!(
            "duration_s {} s: the plan goes on to {:.1} s (release.hang_s, parachute.delay_s and plan.horizon_s)",
            mission.duration_s,
            begins_s + plan.horizon_s
        )));
    }
    let of_the_rotors = |share: f64| format!("{:.0} % of what a rotor makes", 100.0 * share);
    let mut rows = vec![
        row(
            "plan_thrust_max_n",
            "greatest thrust of a rotor",
            "N",
            &[plan.thrust_max_n],
            of_the_rotors(plan.thrust_max_n / rotors.thrust_n),
        ),
        row(
            "plan_thrust_slew_n_s",
            "greatest rate of change",
            "N/s",
            &[plan.thrust_slew_n_s],
            of_the_rotors(plan.thrust_slew_n_s / rotors.thrust_slew_n_s),
        ),
        row("plan_begins_s", "begins", "s", &[begins_s], "from the start of the mission".to_owned()),
        row("plan_ends_s", "ends", "s", &[begins_s + plan.horizon_s], String::new()),
        row(
            "interval_s",
            "interval of its nodes",
            "s",
            &[plan.horizon_s / (plan.nodes - 1) as f64],
            String::new(),
        ),
        row("left_s", "time left after it", "s", &[left_s], String::new()),
    ];
    if plan.thrust_slew_n_s.is_infinite() {
        // The rotors' acceleration bounds it instead (plan.rotor_acceleration_rad_s2).
        rows.retain(|row| row.key != "plan_thrust_slew_n_s");
    }
    DerivedGroup { name: "plan", rows }
}

fn of_the_studies(mission: &Mission) -> DerivedGroup {
    let study = &mission.study;
    let cost = |case: &ReleaseCase| StateCost::of(&case.state(), &mission.limits.safety).max();
    let worst = study.cases.iter().map(|case| (cost(case), case.name.as_str()));
    let worst = worst.reduce(|worst, case| if case.0 > worst.0 { case } else { worst });
    let cases = study.cases.len() as f64;
    let needed =
        if study.cases.is_empty() { "`tune` and `assess` want some".to_owned() } else { String::new() };
    let mut rows = vec![row("cases", "tuning cases", "", &[cases], needed)];
    if let Some((j_state, name)) = worst {
        let key = "worst_case_j_state";
        rows.push(row(
            key,
            "share of the limits used at t = 0",
            "",
            &[j_state],
            format!("the worst: {name}"),
        ));
    }
    rows.push(row("trials", "trials of a campaign", "", &[study.monte_carlo.trials as f64], String::new()));
    DerivedGroup { name: "studies", rows }
}
