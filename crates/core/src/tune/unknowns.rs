//! Unknowns of a controller: how far mass, air, wind and delays may be off, one at a time in a
//! robust tuning, all at once and at random in the flights that gains are tried on afterwards.

use crate::assess::coordinates::UnknownRanges;
use crate::model::rigid_body::BodyState;
use crate::sim::planar::Variation;

use crate::frames::{product, quaternion_from_euler};
use crate::random::{Purpose, Stream, Trials};
use crate::units::RAD_PER_DEG;

/// Mass, either way, as a fraction.
pub const MASS: f64 = 0.05;
/// Moments of inertia, either way, as a fraction.
pub const INERTIA: f64 = 0.2;
/// Drag and pitching moment, either way, as a fraction.
pub const AERO: f64 = 0.2;
/// Density of the air, either way, as a fraction.
pub const DENSITY: f64 = 0.1;
/// Thrust of the rotors, either way, as a fraction.
pub const THRUST: f64 = 0.1;
/// Time constants of the motors, either way, as a fraction.
pub const MOTOR_LAG: f64 = 0.3;
/// Latency in addition to the mission's, at most [s].
pub const LATENCY_S: f64 = 0.01;
/// Wind from ahead or behind, from t = 0 on, as a fraction of the target speed.
pub const WIND: f64 = 0.25;
/// Release delay, longer or shorter [s].
pub const DELAY_S: f64 = 0.1;
/// Pitch at t = 0, either way [rad].
pub const PITCH_RAD: f64 = RAD_PER_DEG;
/// Draws of the air that each release is flown in, where the air changes.
pub const AIR_DRAWS: u64 = 4;

/// Each release with its pitch off, to either end: what finds gains that fly a release well and lose that
/// beside it.
pub fn tipped(releases: &[BodyState]) -> Vec<(BodyState, Variation)> {
    let tipped = |release| [-PITCH_RAD, PITCH_RAD].map(|by| (pitched(release, by), Variation::NONE));
    releases.iter().flat_map(tipped).collect()
}

/// Each release with one thing off at a time, to either end; with the most latency; in gusts and
/// turbulence, where there are any (`windy`), each release and draw in air of its own.
pub fn one_at_a_time(
    releases: &[BodyState],
    gravity_m_s2: f64,
    target_m_s: f64,
    windy: bool,
) -> Vec<(BodyState, Variation)> {
    let none = Variation::NONE;
    let wind = WIND * target_m_s;
    let two = |of: fn(f64) -> Variation, by: f64| [of(1.0 - by), of(1.0 + by)];
    let mut variations = vec![
        Variation { wind_m_s: [wind, 0.0], ..none },
        Variation { wind_m_s: [-wind, 0.0], ..none },
        Variation { latency_s: LATENCY_S, ..none },
    ];
    variations.extend(two(|x| Variation { mass: x, ..Variation::NONE }, MASS));
    variations.extend(two(|x| Variation { inertia: x, ..Variation::NONE }, INERTIA));
    variations.extend(two(|x| Variation { aero: [x, 1.0, 1.0], ..Variation::NONE }, AERO));
    variations.extend(two(|x| Variation { aero: [1.0, 1.0, x], ..Variation::NONE }, AERO));
    variations.extend(two(|x| Variation { density: x, ..Variation::NONE }, DENSITY));
    variations.extend(two(|x| Variation { thrust: x, ..Variation::NONE }, THRUST));
    variations.extend(two(|x| Variation { motor_lag: x, ..Variation::NONE }, MOTOR_LAG));
    let fall_m_s = DELAY_S * gravity_m_s2;
    let draws = if windy { AIR_DRAWS } else { 0 };
    (0u64..)
        .zip(releases)
        .flat_map(|(k, release)| {
            let blown = (0..draws).map(|draw| {
                (*release, Variation { air: Some(Trials::SearchAir.first() + k * AIR_DRAWS + draw), ..none })
            });
            let later = [-fall_m_s, fall_m_s].map(|more| {
                let mut release = *release;
                release.v_ned.z += more;
                (release, none)
            });
            let each = variations.iter().map(|v| (*release, *v));
            each.chain(later).chain(blown).collect::<Vec<_>>()
        })
        .collect()
}

/// The release with another pitch.
fn pitched(release: &BodyState, by_rad: f64) -> BodyState {
    let turn = quaternion_from_euler(0.0, by_rad, 0.0);
    BodyState { q_ned_from_body: product(turn, release.q_ned_from_body), ..*release }
}

/// A release with unknowns of its own, every one uniform between its ends, in air of its own. Trial `k` draws
/// from stream `k` of the seed, whichever are flown beside it.
pub fn varied(
    release: &BodyState,
    seed: u64,
    k: u64,
    gravity_m_s2: f64,
    target_m_s: f64,
) -> (BodyState, Variation) {
    let mut stream = Stream::new(seed, Purpose::Unknowns, k);
    let mut off = |by: f64| stream.between(-by, by);
    let mut variation = Variation {
        mass: 1.0 + off(MASS),
        inertia: 1.0 + off(INERTIA),
        aero: [1.0 + off(AERO), 1.0, 1.0 + off(AERO)],
        density: 1.0 + off(DENSITY),
        wind_m_s: [target_m_s * off(WIND), 0.0],
        latency_s: 0.5 * LATENCY_S * (1.0 + off(1.0)),
        air: Some(k + 1),
        ..Variation::NONE
    };
    let mut release = *release;
    release.v_ned.z += gravity_m_s2 * off(DELAY_S);
    (variation.thrust, variation.motor_lag) = (1.0 + off(THRUST), 1.0 + off(MOTOR_LAG));
    (release, variation)
}

/// The ranges that [`varied`] draws from, for a target speed [m/s].
pub fn ranges(gravity_m_s2: f64, target_m_s: f64) -> UnknownRanges {
    UnknownRanges {
        mass: MASS,
        inertia: INERTIA,
        aero: AERO,
        density: DENSITY,
        thrust: THRUST,
        motor_lag: MOTOR_LAG,
        latency_s: LATENCY_S,
        wind_m_s: target_m_s * WIND,
        fall_m_s: gravity_m_s2 * DELAY_S,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::LEVEL;
    use nalgebra::Vector3;

    /// Uniform numbers: none beyond its end, means in the middle within four standard errors.
    #[test]
    fn closed_form_ends_and_means_of_the_unknowns() {
        let n = 4000;
        let still = BodyState {
            p_ned: Vector3::zeros(),
            q_ned_from_body: LEVEL,
            v_ned: Vector3::zeros(),
            omega_body: Vector3::zeros(),
        };
        let drawn: Vec<_> = (0..n as u64).map(|k| varied(&still, 3, k, 2.0, 8.0)).collect();
        let numbers = |(s, v): &(BodyState, Variation)| {
            let [drag, lift, moment] = v.aero;
            assert_eq!((lift, v.wind_m_s[1]), (1.0, 0.0));
            [
                (v.mass - 1.0) / MASS,
                (v.inertia - 1.0) / INERTIA,
                (drag - 1.0) / AERO,
                (moment - 1.0) / AERO,
                (v.density - 1.0) / DENSITY,
                v.wind_m_s[0] / (8.0 * WIND),
                s.v_ned.z / (2.0 * DELAY_S),
                2.0 * v.latency_s / LATENCY_S - 1.0,
                (v.thrust - 1.0) / THRUST,
                (v.motor_lag - 1.0) / MOTOR_LAG,
            ]
        };
        let mut sums = [0.0; 10];
        for row in drawn.iter().map(numbers) {
            for (sum, x) in sums.iter_mut().zip(row) {
                assert!(x.abs() <= 1.0 + 1e-12, "{row:?}");
                *sum += x;
            }
        }
        // The standard error of a uniform number between -1 and 1 is 1/sqrt(3 n).
        for mean in sums.map(|s| s / n as f64) {
            assert!(mean.abs() < 4.0 / (3.0 * n as f64).sqrt(), "{sums:?}");
        }
        assert_eq!(drawn[17], varied(&still, 3, 17, 2.0, 8.0));
    }
}
