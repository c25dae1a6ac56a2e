//! The dynamics of the shipped missions' vehicles over eight numbers and over dual ones: the same source.

use proptest::prelude::*;
use proptest::strategy::ValueTree as _;
use samara::config::Mission;
use samara::frames::{Quaternion, normalized};
use samara::model::drives::{Motors, OnBus};
use samara::model::environment::Ambient;
use samara::model::rigid_body::{Motion, MotionRate};
use samara::model::supply::Bus;
use samara::model::vehicle::FlightRate;
use samara::model::{MAX_ROTORS, Vehicle};
use samara::real::{Dual, Real};
use samara::vector::V3;

/// Missions whose vehicles and batteries differ in what their rates are made of: rotors by table and by
/// blades, motors of both kinds, coaxial pairs, a body with a side force, batteries.
const MISSIONS: [&str; 6] =
    ["titan_drop", "titan_real_air", "x500_drop", "x500_real_air", "octo_drop", "balloon_drop"];

/// A vehicle's state with commands, air and battery: attitude, velocity, body rates, rotor speeds, throttles,
/// gravity, density, wind, voltage without load, deviations of thrusts.
const NUMBERS: usize = 4 + 3 + 3 + 8 + 8 + 2 + 3 + 1 + 8;

/// What a flight's numbers make of the vehicle, the bus with it.
fn derived<S: Real>(mission: &Mission, x: [S; NUMBERS]) -> Vec<S> {
    let vehicle: &Vehicle = &mission.vehicle;
    let kind = x[0];
    let mut left = x.into_iter();
    let mut next = || left.next().unwrap();
    let q_ned_from_body: Quaternion<S> = std::array::from_fn(|_| next());
    let v_ned = V3::new(next(), next(), next());
    let omega_body = V3::new(next(), next(), next());
    let speed: [S; MAX_ROTORS] = std::array::from_fn(|_| next());
    let throttle: [S; MAX_ROTORS] = std::array::from_fn(|_| next());
    let (gravity_m_s2, density_kg_m3) = (next(), next());
    let ambient = Ambient { gravity_m_s2, density_kg_m3, wind_ned_m_s: V3::new(next(), next(), next()) };
    let open_v = next();
    let deviations: [S; MAX_ROTORS] = std::array::from_fn(|_| next());

    let motion = Motion { q_ned_from_body, v_ned, omega_body };
    let law = vehicle.motor.law();
    let (count, throttle, speed) = (vehicle.rotors.len(), &throttle, &speed);
    let motors = Motors { law: &law, count, conditions: None, throttle, speed };
    let mut rate = FlightRate::nothing(kind);
    let mut bus: Option<Bus<S>> = None;
    if let Some(battery) = &mission.electric {
        let mut near_v = open_v;
        let pack = battery.pack();
        let drives = OnBus { motors, pack, open_v, near_v: &mut near_v, bus: &mut bus };
        vehicle.derive(&ambient, &motion, speed, Some(&deviations), drives, &mut rate);
    } else {
        vehicle.derive(&ambient, &motion, speed, Some(&deviations), motors, &mut rate);
    }
    let MotionRate { q_dot, v_dot_ned: v, omega_dot_body: w } = rate.motion;
    let mut all = vec![v.x, v.y, v.z, w.x, w.y, w.z, rate.weight_n];
    all.extend(q_dot);
    for part in [
        rate.rotor_force_body,
        rate.aero_force_body,
        rate.rotor_moment_body,
        rate.aero_moment_body,
        rate.reaction_moment_body,
        rate.gyro_moment_body,
    ] {
        all.extend([part.x, part.y, part.z]);
    }
    all.extend(rate.rotor_acceleration);
    all.extend(rate.thrust_n);
    all.extend(rate.torque_nm);
    if let Some(bus) = bus {
        all.extend([bus.bus_v, bus.pack_a]);
        all.extend(bus.esc_a);
    }
    all
}

/// The numbers of a flight by as many between 0 and 1.
fn numbers(mission: &Mission, unit: [f64; NUMBERS]) -> [f64; NUMBERS] {
    let mut left = unit.into_iter();
    let mut next = |low: f64, high: f64| low + (high - low) * left.next().unwrap();
    let mut x = Vec::new();
    x.extend(normalized(std::array::from_fn(|_| next(-1.0, 1.0))));
    x.extend((0..3).map(|_| next(-12.0, 12.0)));
    x.extend((0..3).map(|_| next(-3.0, 3.0)));
    let fastest = mission.vehicle.motor.omega_max_rad_s();
    x.extend((0..MAX_ROTORS).map(|_| next(-0.05, 1.05) * fastest).map(|speed| speed.max(0.0)));
    x.extend((0..MAX_ROTORS).map(|_| next(0.0, 1.0)));
    let site = &mission.site.environment;
    x.extend([next(0.9, 1.1) * site.gravity_m_s2, next(0.5, 1.5) * site.density_kg_m3]);
    x.extend((0..3).map(|_| next(-8.0, 8.0)));
    let full_v = mission.electric.as_ref().map_or(1.0, |battery| battery.pack().open_circuit_v(1.0));
    // One flight in ten has an empty battery.
    let share = next(0.55, 1.05);
    x.push(if share < 0.6 { 0.0 } else { share * full_v });
    x.extend((0..MAX_ROTORS).map(|_| next(-0.3, 0.3)));
    x.try_into().unwrap()
}

fn missions() -> Vec<Mission> {
    MISSIONS.map(|name| Mission::shipped(name).unwrap()).into()
}

fn flights() -> impl Strategy<Value = Vec<Vec<f64>>> {
    prop::collection::vec(prop::collection::vec(0.0f64..1.0, NUMBERS), 8)
}

/// Eight flights side by side have the bits of eight flights one by one, in each number of their derivatives.
#[cfg(target_arch = "x86_64")]
#[test]
fn prop_eight_flights_have_the_bits_of_single_ones() {
    use samara::simd::lanes::{Avx2, Lanes};

    let Some(proof) = Avx2::found() else { return };
    for mission in missions() {
        let mut runner = proptest::test_runner::TestRunner::deterministic();
        let tried = runner.run(&flights(), |units| {
            let each: Vec<_> =
                units.into_iter().map(|unit| numbers(&mission, unit.try_into().unwrap())).collect();
            let beside =
                std::array::from_fn(|k| Lanes::new(proof, std::array::from_fn(|lane| each[lane][k])));
            let beside = derived(&mission, beside);
            for (lane, flight) in each.into_iter().enumerate() {
                for (k, (found, wanted)) in beside.iter().zip(derived(&mission, flight)).enumerate() {
                    let found = found.to_array()[lane];
                    prop_assert_eq!(
                        found.to_bits(),
                        wanted.to_bits(),
                        "{} {}: {} {}",
                        lane,
                        k,
                        found,
                        wanted
                    );
                }
            }
            Ok(())
        });
        tried.unwrap_or_else(|why| panic!("{}: {why}", mission.name));
    }
}

/// Dual numbers have the value's bits, and slopes that are those of small differences, but where a difference
/// goes across an edge of a table or a limit: of nearly all.
#[test]
fn prop_dual_numbers_are_the_slopes_of_the_same_source() {
    const STEP: f64 = 1e-6;
    for mission in missions() {
        let mut runner = proptest::test_runner::TestRunner::deterministic();
        let (mut all, mut off) = (0, 0);
        for _ in 0..8 {
            let unit = prop::collection::vec(0.0f64..1.0, NUMBERS).new_tree(&mut runner).unwrap().current();
            let x = numbers(&mission, unit.try_into().unwrap());
            let value = derived(&mission, x);
            for k in 0..NUMBERS {
                let slope = |i| if i == k { 1.0 } else { 0.0 };
                let duals = std::array::from_fn(|i| Dual { value: x[i], slope: [slope(i)] });
                let moved = |by: f64| {
                    let mut moved = x;
                    moved[k] += by * (1.0 + x[k].abs());
                    derived(&mission, moved)
                };
                let (above, below) = (moved(STEP), moved(-STEP));
                for (i, dual) in derived(&mission, duals).into_iter().enumerate() {
                    assert_eq!(dual.value.to_bits(), value[i].to_bits(), "{}", mission.name);
                    let difference = (above[i] - below[i]) / (2.0 * STEP * (1.0 + x[k].abs()));
                    let size = 1.0 + difference.abs() + dual.value.abs();
                    all += 1;
                    off += usize::from(!((dual.slope[0] - difference).abs() <= 1e-4 * size));
                }
            }
        }
        assert!(off * 200 < all, "{}: {off} of {all}", mission.name);
    }
}
