//! The drops that PX4's gains are judged by: seeded swings under the canopy, the fall, the plan, the target
//! velocity.

use std::ops::{ControlFlow, Range};
use std::sync::Arc;

use nalgebra::Vector3;

use super::Measures;
use super::measures::Tracking;
use crate::assess::Scenario;
use crate::assess::{ReleaseDistribution, VerdictBuilder};
use crate::control::WithVelocityError;
use crate::control::px4::estimator::Receiver;
use crate::control::px4::{Law, Parameters, Px4Controller, output};
use crate::model::Parachute;
use crate::sim::{DropSimulation, FlightPlan, Px4Senses, Reference, SensorSettings, Start, fly_sensing};
use crate::trajectory::Trajectory;
use crate::uncertain::Deviations;

/// Time under the canopy before the release, on PX4's clock [s]: its outputs have come up, its filters are at
/// rest.
const HANG_PX4_S: f64 = output::FULL_AUTHORITY_S + 0.05;
/// Faster than this [m/s] a flight is lost.
const LOST_M_S: f64 = 60.0;
/// Error of PX4's estimated descent, as a part of the distance that counts as steady. On the x500 that
/// is 0.05 m/s; 0.03 to 0.06 were seen.
const ESTIMATE_OFF: f64 = 1.0 / 3.0;

/// Least time by which the commands of a PX4 that flies are late beyond its control period, on its clock [s]:
/// 5.6 ms of the gyroscope's filter (IMU_GYRO_CUTOFF 40 Hz, two poles), 2.5 ms for a pulse at 400 Hz and up
/// to 2 ms of its length, and what the speed controllers' own filters and PX4's queues take. The model of
/// the law has the gyroscope's filter besides, so that what is judged so is on the safe side.
pub const LATENCY_S: f64 = 0.015;

/// The latency [s], on the site's clock, by which drops for PX4's gains are judged: a vehicle's own, or
/// [`LATENCY_S`] on a clock that runs `similarity` times slower, whichever is more.
pub fn latency_s(vehicle_s: f64, similarity: f64) -> f64 {
    vehicle_s.max(LATENCY_S * similarity)
}

/// Vehicle, site, plan and limits of the drops that PX4's gains are judged by.
#[derive(Clone, Debug)]
pub struct Px4Setting<'a> {
    /// Vehicle, site, air, target and limits.
    pub scenario: Scenario,
    /// The law of PX4's version.
    pub law: Law,
    /// Number of the flight whose turbulence is met.
    pub air: u64,
    /// Froude's k: how much slower PX4's clock runs than the site's.
    pub similarity: f64,
    /// The plan to follow.
    pub plan: &'a Trajectory,
    /// Whether its acceleration is sent with its velocity.
    pub feed_forward: bool,
    /// How long a flight goes on after the plan's end [s].
    pub settle_s: f64,
    /// How the vehicle comes from the release to t = 0.
    pub start: Start,
    /// What PX4's estimator goes by; `None`: it is given the truth, but for `v_error_ned`.
    pub sensing: Option<Sensing>,
    /// Error of PX4's estimate of its velocity, NED [m/s].
    pub v_error_ned: Vector3<f64>,
}

/// Sensors that PX4's estimator goes by, and how long it does before the release.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensing {
    /// The sensors.
    pub sensors: SensorSettings,
    /// Seed of their errors.
    pub seed: u64,
    /// What PX4 is told of the receiver.
    pub receiver: Receiver,
    /// Time under the canopy or on the hook before the release, the site's [s].
    pub hang_s: f64,
}

impl Px4Setting<'_> {
    /// Time under the canopy before the release, the site's [s].
    pub fn hang_s(&self) -> f64 {
        let least_s = HANG_PX4_S * self.similarity;
        self.sensing.map_or(least_s, |sensing| sensing.hang_s.max(least_s))
    }

    /// Length of the powered flight [s].
    pub fn flight_s(&self) -> f64 {
        self.plan.end_s() + self.settle_s
    }

    /// Flies a drop from a swing and judges it.
    pub fn fly(&self, parameters: &Parameters, parachute: Parachute) -> Measures {
        let (similarity, hang_s) = (self.similarity, self.hang_s());
        let (vehicle, environment) = (self.scenario.vehicle.clone(), self.scenario.environment.clone());
        let course = self.scenario.wind.course(&environment, self.air);
        let mut sim = DropSimulation::new(vehicle, environment, parachute, hang_s, self.start)
            .in_wind(course)
            .on_battery(self.scenario.battery.clone());
        sim.schedule_release(hang_s);
        let reference = Reference::Plan {
            trajectory: self.plan,
            then_v_ned: Some(self.scenario.target_v_ned),
            feed_forward: self.feed_forward,
        };
        let duration_s = hang_s + parachute.delay_s + self.flight_s();
        let plan = FlightPlan::under_px4(reference, &self.law, similarity, duration_s);
        let thrust_limit_n = self.scenario.vehicle.static_thrust_n(self.scenario.environment.density_kg_m3);
        let controller = Px4Controller::new(parameters.clone(), similarity, thrust_limit_n).with_law(
            self.law,
            &self.scenario.vehicle,
            self.scenario.environment.density_kg_m3,
        );
        let mut controller =
            WithVelocityError { controller: Box::new(controller), v_error_ned: self.v_error_ned };
        let senses = self.sensing.map(|Sensing { sensors, seed, receiver, .. }| {
            let sensors = (&self.scenario.environment, sensors, seed);
            Px4Senses::new(sensors, (parameters, &self.law, &receiver), similarity)
        });
        let mut verdict =
            VerdictBuilder::judging(self.scenario.limits, self.scenario.target_v_ned).along(self.plan);
        let mut tracking = Tracking::new(self.plan.end_s());
        let flown = fly_sensing(&mut sim, &mut controller, &plan, senses, &mut |sample| {
            verdict.observe(sample);
            tracking.observe(sample);
            let lost = !(sample.state.body.v_ned.norm() <= LOST_M_S);
            if lost { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        match (flown, verdict.finish()) {
            (ControlFlow::Continue(()), Some(verdict)) => {
                Measures::of(&verdict, tracking.rms_m_s(), self.flight_s())
            }
            _ => Measures::LOST,
        }
    }
}

/// A drop to judge by.
#[derive(Clone, Debug)]
pub struct Px4Drop<'a> {
    setting: Px4Setting<'a>,
    parachute: Parachute,
}

impl Px4Drop<'_> {
    /// Flies it.
    pub fn fly(&self, parameters: &Parameters) -> Measures {
        self.setting.fly(parameters, self.parachute)
    }
}

/// Random drops of a seed, by their numbers, as campaigns draw them: swing, turbulence, and wind on top of
/// the site's, of deviation `wind_sigma_m_s` north and east. What is uncertain of the vehicle is drawn; where
/// nobody says, every other drop is flown as it is known, the others with a mass or an inertia that is a
/// tenth more, or, without an estimator, with a descent that is off by `ESTIMATE_OFF` either way.
pub fn drops<'a>(
    setting: &Px4Setting<'a>,
    releases: &ReleaseDistribution,
    wind_sigma_m_s: f64,
    seed: u64,
    trials: Range<u64>,
) -> Vec<Px4Drop<'a>> {
    let drop = |trial| {
        let drawn = releases.draw_drop(seed, trial, wind_sigma_m_s);
        let mut parachute = releases.parachute;
        parachute.pendulum.amplitude_rad = drawn.amplitude_rad;
        parachute.pendulum.phase_rad = drawn.phase_rad;
        parachute.tip_off = parachute.tip_off.with(&drawn.tip_off);
        let mut setting = match releases.uncertain {
            Some(_) => off(setting, &drawn.off),
            None => varied(setting, trial),
        };
        parachute.delay_s = (parachute.delay_s + drawn.off.release_delay_s()).max(0.0);
        setting.scenario.environment.wind_ned_m_s += drawn.wind_ned_m_s;
        setting.air = trial + 1;
        if let Some(sensing) = &mut setting.sensing {
            sensing.seed = drawn.seed;
        }
        Px4Drop { setting, parachute }
    };
    trials.map(drop).collect()
}

/// Drops from given swings, flown as they are known, each with errors of the sensors of its own.
pub fn drops_from<'a>(
    setting: &Px4Setting<'a>,
    parachutes: impl IntoIterator<Item = Parachute>,
) -> Vec<Px4Drop<'a>> {
    let drop = |(number, parachute)| {
        let mut setting = setting.clone();
        if let Some(sensing) = &mut setting.sensing {
            sensing.seed = sensing.seed.wrapping_add(number);
        }
        Px4Drop { setting, parachute }
    };
    (0..).zip(parachutes).map(drop).collect()
}

/// Name of the scales that costs are measured by where no reference comes through the drops.
pub const FIXED_SCALES: &str = "fixed scales";

/// Drops to judge by.
#[derive(Clone, Debug)]
pub struct Px4Judge<'a> {
    drops: Vec<Px4Drop<'a>>,
    /// Name of the flights that costs are measured by.
    pub measured_by: &'static str,
    /// Measures of the flights that costs are measured by.
    pub reference: Measures,
}

impl<'a> Px4Judge<'a> {
    /// Costs are measured by the flights of one of `references`, each with the name by which it is reported:
    /// the first whose drops are all safe; where there is none, the first that loses none; where all do,
    /// [`Measures::SCALES`].
    pub fn new(drops: Vec<Px4Drop<'a>>, references: &[(&'static str, &Parameters)]) -> Self {
        let scales = Self { drops, measured_by: FIXED_SCALES, reference: Measures::SCALES };
        let flown = |(name, parameters): &(&'static str, &Parameters)| (*name, scales.fly(parameters));
        let flown: Vec<(&str, Measures)> = references.iter().map(flown).collect();
        let safe = flown.iter().find(|(_, m)| !m.is_lost() && m.unsafe_share == 0.0);
        match safe.or_else(|| flown.iter().find(|(_, m)| !m.is_lost())) {
            Some((measured_by, reference)) => Self { measured_by, reference: *reference, ..scales },
            None => scales,
        }
    }

    /// Flies every drop: the means.
    pub fn fly(&self, parameters: &Parameters) -> Measures {
        let flown: Vec<Measures> = self.drops.iter().map(|drop| drop.fly(parameters)).collect();
        Measures::mean(&flown)
    }

    /// Cost of parameters, [`Measures::cost`].
    pub fn cost(&self, parameters: &Parameters) -> f64 {
        self.fly(parameters).cost(&self.reference)
    }

    /// How many drops there are.
    pub fn count(&self) -> usize {
        self.drops.len()
    }
}

/// The setting of a vehicle and of air that are off; as they are known where there is no such vehicle.
fn off<'a>(setting: &Px4Setting<'a>, off: &Deviations) -> Px4Setting<'a> {
    let mut setting = setting.clone();
    let Scenario { vehicle, environment, .. } = &mut setting.scenario;
    if let Some(flown) = off.variation().applied(vehicle, environment) {
        (*vehicle, *environment) = flown;
    }
    setting
}

fn varied<'a>(setting: &Px4Setting<'a>, trial: u64) -> Px4Setting<'a> {
    let mut setting = setting.clone();
    let off_m_s = ESTIMATE_OFF * setting.scenario.limits.steady_within_m_s;
    let is_true = setting.sensing.is_none();
    let vehicle = Arc::make_mut(&mut setting.scenario.vehicle);
    match trial % 8 {
        1 if is_true => setting.v_error_ned.z += off_m_s,
        5 if is_true => setting.v_error_ned.z -= off_m_s,
        3 => vehicle.mass.mass_kg *= 1.1,
        7 => {
            vehicle.mass.inertia_kg_m2 *= 1.1;
            vehicle.mass.inertia_inverse /= 1.1;
        }
        _ => (),
    }
    setting
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assess::Limits;
    use crate::assess::SafetyLimits;
    use crate::control::test_vehicles::{
        ARM_M, GRAVITY_M_S2, J_YY, MASS_KG, THRUST_LIMIT_N, quadrotor, site,
    };
    use crate::model::VehicleOptions;
    use crate::model::parachute::{Pendulum, TipOff};
    use crate::model::wind::Wind;
    use crate::trajectory::Node;

    /// From 4 m/s down to the target in 2 s.
    fn plan(target_v_ned: Vector3<f64>) -> Trajectory {
        Trajectory::new(vec![Node::level(0.0, Vector3::z() * 4.0), Node::level(2.0, target_v_ned)], 4)
            .unwrap()
    }

    /// A heavy quadrotor on a moon without air, and a swing.
    fn setting(plan: &Trajectory) -> (Px4Setting<'_>, ReleaseDistribution) {
        let setting = Px4Setting {
            law: Law::V1_12,
            scenario: Scenario {
                vehicle: Arc::new(quadrotor([ARM_M; 2], [J_YY; 3], [0.0; 3], VehicleOptions::default())),
                environment: site(),
                wind: Wind::default(),
                battery: None,
                target_v_ned: Vector3::new(1.0, 0.0, 1.0),
                limits: Limits::of_j_state(
                    SafetyLimits {
                        speed_m_s: 12.0,
                        pitch_rad: 0.8,
                        pitch_rate_rad_s: 0.8,
                        vertical_acceleration_m_s2: 3.0,
                    },
                    0.1,
                ),
            },
            air: 0,
            similarity: (crate::units::STANDARD_GRAVITY_M_S2 / GRAVITY_M_S2).sqrt(),
            plan,
            feed_forward: false,
            settle_s: 60.0,
            start: Start::Release,
            sensing: None,
            v_error_ned: Vector3::zeros(),
        };
        let pendulum =
            Pendulum { amplitude_rad: 0.0, phase_rad: 0.0, omega_rad_s: GRAVITY_M_S2.sqrt(), length_m: 1.0 };
        let releases = ReleaseDistribution {
            parachute: Parachute::new(3.0, 0.5, pendulum).unwrap(),
            gravity_m_s2: GRAVITY_M_S2,
            drift_ned_m_s: Vector3::zeros(),
            amplitude_sigma_rad: 0.05,
            tip_off_sigma: TipOff::default(),
            uncertain: None,
        };
        (setting, releases)
    }

    fn flying() -> Parameters {
        Parameters {
            thr_hover: MASS_KG * GRAVITY_M_S2 / (4.0 * THRUST_LIMIT_N),
            thr_mdl_fac: 1.0,
            xy_vel_max: 40.0,
            z_vel_max_dn: 40.0,
            rollrate_k: 2.0,
            pitchrate_k: 2.0,
            ..Parameters::default()
        }
    }

    /// Where the first reference loses a drop another one counts, and so do costs: what flies costs less than
    /// what falls.
    #[test]
    fn regress_a_reference_that_is_lost_is_replaced() {
        let plan = plan(Vector3::new(1.0, 0.0, 1.0));
        let (setting, releases) = setting(&plan);
        let (flies, falls) = (flying(), Parameters { thr_max: 0.0, ..flying() });
        let judge = |references: &[(&'static str, &Parameters)]| {
            Px4Judge::new(drops(&setting, &releases, 0.0, 1, 0..2), references)
        };
        for (references, measured_by) in [
            (&[("flies", &flies), ("falls", &falls)][..], "flies"),
            (&[("falls", &falls), ("flies", &flies)], "flies"),
            (&[("falls", &falls)], FIXED_SCALES),
        ] {
            let judge = judge(references);
            assert_eq!(judge.measured_by, measured_by);
            assert!(!judge.reference.is_lost());
            assert!(judge.cost(&flies).is_finite());
            assert_eq!(judge.cost(&falls), f64::INFINITY);
        }
    }

    /// A PX4 on a slower clock has come up as far as one on the site's: it is armed so long before the rotors
    /// are free.
    #[test]
    fn regress_the_controller_is_past_its_ramp_whatever_the_clock() {
        let plan = plan(Vector3::z());
        let (setting, _) = setting(&plan);
        for similarity in [1.0, 2.695, 6.0] {
            let setting = Px4Setting { similarity, ..setting.clone() };
            assert!(setting.hang_s() / similarity > output::FULL_AUTHORITY_S);
        }
    }
}
