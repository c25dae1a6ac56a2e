//! The drops that PX4's gains are judged by: seeded swings under the canopy, the fall, the plan, the target velocity.

use std::ops::{ControlFlow, Range};
use std::sync::Arc;

use nalgebra::Vector3;

use super::Measures;
use super::measures::Tracking;
use crate::assess::{ReleaseDistribution, SafetyLimits, VerdictBuilder};
use crate::control::px4::{Law, Parameters};
use crate::model::{Environment, Parachute, Vehicle};
use crate::sim::px4_flight::{IMU_PERIOD_S, fly_px4};
use crate::sim::{DropSimulation, FlightPlan, Reference, Sample, Start};
use crate::trajectory::Trajectory;
use crate::units::STANDARD_GRAVITY_M_S2;

/// Time under the canopy before the release: the law's filters come to rest [s].
const HANG_S: f64 = 0.5;
/// Faster than this [m/s] a flight is lost.
const LOST_M_S: f64 = 60.0;
/// What PX4's estimated descent is off by, as a part of the distance that counts as steady. On the x500 that is 0.05 m/s; 0.03 to
/// 0.06 were seen.
const ESTIMATE_OFF: f64 = 1.0 / 3.0;
/// Period of a streamer's setpoints [s].
pub const SETPOINT_PERIOD_S: f64 = 0.02;

/// What the drops are flown with.
#[derive(Clone, Debug)]
pub struct Px4Setting<'a> {
    /// The vehicle.
    pub vehicle: Arc<Vehicle>,
    /// The site.
    pub environment: Environment,
    /// Limits that J_state is measured by.
    pub safety: SafetyLimits,
    /// The plan to follow.
    pub plan: &'a Trajectory,
    /// Velocity after the plan's end, NED [m/s].
    pub target_v_ned: Vector3<f64>,
    /// Steady so near to it [m/s].
    pub steady_within_m_s: f64,
    /// How long a flight goes on after the plan's end [s].
    pub settle_s: f64,
    /// How the vehicle comes from the release to t = 0.
    pub start: Start,
    /// What PX4's estimate of its velocity is off by, NED [m/s].
    pub v_error_ned: Vector3<f64>,
}

impl Px4Setting<'_> {
    /// Froude's k = sqrt(g0/g): how much slower PX4's clock runs than the site's.
    pub fn similarity(&self) -> f64 {
        (STANDARD_GRAVITY_M_S2 / self.environment.gravity_m_s2).sqrt()
    }

    /// Length of the powered flight [s].
    pub fn flight_s(&self) -> f64 {
        self.plan.end_s() + self.settle_s
    }

    /// Flies a drop from a swing and judges it; `observe` sees every sample.
    pub fn fly(
        &self,
        parameters: &Parameters,
        parachute: Parachute,
        observe: &mut impl FnMut(&Sample),
    ) -> Measures {
        let similarity = self.similarity();
        let mut sim = DropSimulation::new(
            self.vehicle.clone(),
            self.environment.clone(),
            parachute,
            HANG_S,
            self.start,
        );
        sim.schedule_release(HANG_S);
        let plan = FlightPlan {
            reference: Reference::Plan {
                trajectory: self.plan,
                then_v_ned: Some(self.target_v_ned),
                feed_forward: false,
            },
            yaw_sp_rad: 0.0,
            control_period_s: IMU_PERIOD_S * similarity,
            setpoint_period_s: Some(SETPOINT_PERIOD_S * similarity),
            duration_s: HANG_S + parachute.delay_s + self.flight_s(),
        };
        let mut law = Law::new(parameters.clone(), similarity);
        let mut verdict = VerdictBuilder::new(self.safety, self.target_v_ned);
        let mut tracking = Tracking::new(self.target_v_ned, self.steady_within_m_s, self.plan.end_s());
        let flown = fly_px4(&mut sim, &mut law, &plan, self.v_error_ned, &mut |sample| {
            verdict.observe(sample);
            tracking.observe(sample);
            observe(sample);
            let lost = !(sample.state.body.v_ned.norm() <= LOST_M_S);
            if lost { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        match (flown, verdict.finish()) {
            (ControlFlow::Continue(()), Some(verdict)) => Measures::of(&verdict, &tracking, self.flight_s()),
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
        self.setting.fly(parameters, self.parachute, &mut |_| ())
    }
}

/// Drops to judge by.
#[derive(Clone, Debug)]
pub struct Px4Bench<'a> {
    drops: Vec<Px4Drop<'a>>,
    reference: Measures,
}

impl<'a> Px4Bench<'a> {
    /// Random drops of a seed, by their numbers, as campaigns draw them: swing, and wind on top of the site's, of deviation
    /// `wind_sigma_m_s` north and east. Every other drop is flown as it is known; the others with a mass or an inertia that is a tenth more,
    /// or with an estimated descent that is off by [`ESTIMATE_OFF`] either way. The flights of `reference` are what others are measured by.
    pub fn new(
        setting: &Px4Setting<'a>,
        releases: &ReleaseDistribution,
        wind_sigma_m_s: f64,
        seed: u64,
        trials: Range<u64>,
        reference: &Parameters,
    ) -> Self {
        let drops = trials
            .map(|trial| {
                let drawn = releases.draw_drop(seed, trial, wind_sigma_m_s);
                let mut parachute = releases.parachute;
                parachute.pendulum.amplitude_rad = drawn.amplitude_rad;
                parachute.pendulum.phase_rad = drawn.phase_rad;
                let mut setting = varied(setting, trial);
                setting.environment.wind_ned_m_s += drawn.wind_ned_m_s;
                Px4Drop { setting, parachute }
            })
            .collect();
        let mut made = Self { drops, reference: Measures::LOST };
        made.reference = Measures::mean(&made.fly(reference));
        made
    }

    /// Flies every drop.
    pub fn fly(&self, parameters: &Parameters) -> Vec<Measures> {
        self.drops.iter().map(|drop| drop.fly(parameters)).collect()
    }

    /// What parameters cost, [`Measures::cost`].
    pub fn cost(&self, parameters: &Parameters) -> f64 {
        Measures::mean(&self.fly(parameters)).cost(&self.reference)
    }

    /// What the reference's flights came to.
    pub fn reference(&self) -> &Measures {
        &self.reference
    }

    /// The drops.
    pub fn drops(&self) -> &[Px4Drop<'a>] {
        &self.drops
    }
}

fn varied<'a>(setting: &Px4Setting<'a>, trial: u64) -> Px4Setting<'a> {
    let mut setting = setting.clone();
    let off_m_s = ESTIMATE_OFF * setting.steady_within_m_s;
    let vehicle = Arc::make_mut(&mut setting.vehicle);
    match trial % 8 {
        1 => setting.v_error_ned.z += off_m_s,
        5 => setting.v_error_ned.z -= off_m_s,
        3 => vehicle.mass.mass_kg *= 1.1,
        7 => {
            vehicle.mass.inertia_kg_m2 *= 1.1;
            vehicle.mass.inertia_inverse /= 1.1;
        }
        _ => (),
    }
    setting
}
