//! Unknowns of a controller, where a mission does not say what is uncertain: how far mass, air, wind and
//! delays may be off, one at a time in a robust tuning, all at once and at random in the flights that gains
//! are tried on afterwards.

use crate::frames::{product, quaternion_from_euler};
use crate::model::rigid_body::BodyState;
use crate::random::Trials;
use crate::sim::planar::Variation;
use crate::uncertain::{Distribution, UncertainQuantity, Uncertainty};
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

/// Each release with one thing off at a time, to either end of what is uncertain, under a gravity [m/s^2]; in
/// gusts and turbulence, where there are any (`windy`), each release and draw in air of its own.
pub fn one_at_a_time(
    releases: &[BodyState],
    uncertain: &Uncertainty,
    gravity_m_s2: f64,
    windy: bool,
) -> Vec<(BodyState, Variation)> {
    let draws = if windy { AIR_DRAWS } else { 0 };
    let ends = uncertain.ends();
    (0u64..)
        .zip(releases)
        .flat_map(|(k, release)| {
            let blown = (0..draws).map(|draw| {
                let air = Some(Trials::SearchAir.first() + k * AIR_DRAWS + draw);
                (*release, Variation { air, ..Variation::NONE })
            });
            let off = ends.iter().map(|off| {
                let mut release = *release;
                release.v_ned.z += gravity_m_s2 * off.release_delay_s();
                (release, off.variation())
            });
            off.chain(blown).collect::<Vec<_>>()
        })
        .collect()
}

/// The release with another pitch.
fn pitched(release: &BodyState, by_rad: f64) -> BodyState {
    let turn = quaternion_from_euler(0.0, by_rad, 0.0);
    BodyState { q_ned_from_body: product(turn, release.q_ned_from_body), ..*release }
}

/// What a controller does not know of where a mission does not say: every quantity uniform between its ends,
/// the wind's by a target speed [m/s].
pub fn usual(target_m_s: f64) -> Uncertainty {
    let either_way = |most: f64| Distribution::Uniform([-most, most]);
    [
        (UncertainQuantity::Mass, either_way(MASS)),
        (UncertainQuantity::Inertia, either_way(INERTIA)),
        (UncertainQuantity::Drag, either_way(AERO)),
        (UncertainQuantity::PitchingMoment, either_way(AERO)),
        (UncertainQuantity::Density, either_way(DENSITY)),
        (UncertainQuantity::Wind, either_way(WIND * target_m_s)),
        (UncertainQuantity::Latency, Distribution::Uniform([0.0, LATENCY_S])),
        (UncertainQuantity::ReleaseDelay, either_way(DELAY_S)),
        (UncertainQuantity::Thrust, either_way(THRUST)),
        (UncertainQuantity::MotorLag, either_way(MOTOR_LAG)),
    ]
    .into_iter()
    .fold(Uncertainty::none(), |all, (quantity, distribution)| all.with(quantity, distribution))
}
