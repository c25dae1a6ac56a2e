//! The drops that PX4's gains are judged by: seeded swings under the canopy, the fall, the plan, the target velocity.

use std::ops::ControlFlow;
use std::sync::Arc;

use nalgebra::Vector3;

use super::Measures;
use crate::assess::{ReleaseDistribution, SafetyLimits, VerdictBuilder};
use crate::control::px4::{Law, Parameters};
use crate::frames::dcm_body_from_ned;
use crate::model::{Environment, Parachute, Vehicle};
use crate::sim::px4_flight::{IMU_PERIOD_S, fly_px4};
use crate::sim::{DropSimulation, FlightPlan, Phase, Reference, Sample, Start};
use crate::trajectory::Trajectory;
use crate::units::STANDARD_GRAVITY_M_S2;

/// Time under the canopy before the release: the law's filters come to rest [s].
const HANG_S: f64 = 0.5;
/// Faster than this [m/s] a flight is lost.
const LOST_M_S: f64 = 60.0;
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
    /// How long a flight goes on after the plan's end [s].
    pub settle_s: f64,
    /// How the vehicle comes from the release to t = 0.
    pub start: Start,
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
        let mut tracking = Tracking::default();
        let end_s = self.plan.end_s();
        let flown = fly_px4(&mut sim, &mut law, &plan, similarity, &mut |sample| {
            verdict.observe(sample);
            tracking.observe(sample, end_s);
            observe(sample);
            let lost = !(sample.state.body.v_ned.norm() <= LOST_M_S);
            if lost { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        match (flown, verdict.finish()) {
            (ControlFlow::Continue(()), Some(verdict)) => {
                Measures::of(&verdict, tracking.rms_m_s(), tracking.peak_tilt_rad, self.flight_s())
            }
            _ => Measures::LOST,
        }
    }
}

/// Velocity error and tilt of a flight.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tracking {
    sum_of_squares: f64,
    samples: u32,
    peak_tilt_rad: f64,
}

impl Tracking {
    /// Takes a sample; the velocity counts up to the plan's end [s].
    pub fn observe(&mut self, sample: &Sample, end_s: f64) {
        if sample.phase == Phase::Hanging {
            return;
        }
        let tilt = dcm_body_from_ned(sample.state.body.q_ned_from_body)[(2, 2)].clamp(-1.0, 1.0).acos();
        self.peak_tilt_rad = self.peak_tilt_rad.max(tilt);
        if let (Some(t), Some(v_sp)) = (sample.t_powered_s, sample.v_sp_ned)
            && t <= end_s
        {
            self.sum_of_squares += (sample.state.body.v_ned - v_sp).norm_squared();
            self.samples += 1;
        }
    }

    /// RMS of the velocity's distance from its setpoint [m/s].
    pub fn rms_m_s(&self) -> f64 {
        (self.sum_of_squares / f64::from(self.samples.max(1))).sqrt()
    }
}

/// Drops to judge by.
#[derive(Clone, Debug)]
pub struct Px4Bench<'a> {
    drops: Vec<(Px4Setting<'a>, Parachute)>,
    reference: Measures,
    base: Parameters,
}

impl<'a> Px4Bench<'a> {
    /// The first `count` releases of a seed. Of every four drops three are of the vehicle as it is known, one of a vehicle that
    /// is not quite: mass, then inertia, a tenth more. What is not searched is `base`'s, whose own flights are the reference.
    pub fn new(
        setting: &Px4Setting<'a>,
        releases: &ReleaseDistribution,
        seed: u64,
        count: usize,
        base: Parameters,
    ) -> Self {
        let drops = (0..count)
            .map(|trial| {
                let drawn = releases.draw(seed, trial as u64);
                let mut parachute = releases.parachute;
                parachute.pendulum.amplitude_rad = drawn.amplitude_rad;
                parachute.pendulum.phase_rad = drawn.phase_rad;
                (varied(setting, trial), parachute)
            })
            .collect();
        let mut made = Self { drops, reference: Measures::LOST, base };
        made.reference = Measures::mean(&made.fly(&made.base.clone()));
        made
    }

    /// Flies every drop.
    pub fn fly(&self, parameters: &Parameters) -> Vec<Measures> {
        self.drops.iter().map(|(setting, from)| setting.fly(parameters, *from, &mut |_| ())).collect()
    }

    /// What the base's flights came to.
    pub fn reference(&self) -> &Measures {
        &self.reference
    }

    /// The parameters that are not searched.
    pub fn base(&self) -> &Parameters {
        &self.base
    }

    /// How many drops there are.
    pub fn drops(&self) -> usize {
        self.drops.len()
    }
}

fn varied<'a>(setting: &Px4Setting<'a>, trial: usize) -> Px4Setting<'a> {
    let mut setting = setting.clone();
    let vehicle = Arc::make_mut(&mut setting.vehicle);
    match trial % 8 {
        3 => vehicle.mass.mass_kg *= 1.1,
        7 => {
            vehicle.mass.inertia_kg_m2 *= 1.1;
            vehicle.mass.inertia_inverse /= 1.1;
        }
        _ => (),
    }
    setting
}
