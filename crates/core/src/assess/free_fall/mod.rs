//! How well a fall is found from the accelerometer alone: releases that must be found, soon, and hours of
//! descent in turbulence in which nothing may be.
//!
//! | file | holds |
//! |---|---|
//! | here | the flights, and the detector on their readings |
//! | [`rules`] | other rules and settings beside it, on the same readings |
//!
//! Both are flown by the simulation of whole drops, vehicle and canopy two bodies under one riser, with the
//! accelerometer's errors; there is no second, simpler model whose likeness would have to be shown. A trial
//! has its own swing, tumble, wind, eddies and errors of the accelerometer, so that it depends on its number
//! alone.

use std::sync::Arc;

use nalgebra::Vector3;

pub mod rules;

use rules::{RULES, Rules};

use crate::control::px4::timing::{IMU_PERIOD_S, IMU_PERIOD_US, TELEMETRY_PERIOD_US};
use crate::control::{FreeFallDetector, FreeFallSettings};
use crate::frames::rotate_body_from_ned;
use crate::model::parachute::{Pendulum, TipOff};
use crate::model::wind::{Turbulence, Wind};
use crate::model::{Environment, MAX_ROTORS, Parachute, Vehicle};
use crate::random::{Purpose, Stream};
use crate::sim::sensors::Sensors;
use crate::sim::{DropSimulation, SensorSettings, Start};
use crate::time::{TimeUs, microseconds, seconds};
use crate::units::RAD_PER_DEG;

/// Time under the canopy before the release [s]: bodies that begin in a steady descent have come to move with
/// the eddies by then.
const HANG_S: f64 = 10.0;
/// Time before a descent counts [s].
const SETTLE_S: f64 = 30.0;
/// The last part of a hang, that the autopilot reads [s].
const READ_S: f64 = 1.0;
/// Length of a descent [s].
pub const DESCENT_S: f64 = 3600.0;

/// Circumstances of releases and descents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FallCircumstances {
    /// Largest amplitude of the swing, drawn evenly up to it [rad].
    pub swing_rad: f64,
    /// Largest rate that the release gives, about any axis, drawn evenly up to it [rad/s].
    pub tumble_rad_s: f64,
    /// Largest mean wind, from anywhere level, drawn evenly up to it [m/s].
    pub wind_m_s: f64,
    /// Standard deviation of the turbulence, each axis [m/s].
    pub turbulence_m_s: f64,
    /// Scale of the turbulence [m].
    pub scale_m: f64,
}

impl Default for FallCircumstances {
    /// Swings to 15 deg, tumbling to 360 deg/s, wind to 10 m/s, turbulence of 1 m/s, scale 100 m.
    fn default() -> Self {
        Self {
            swing_rad: 15.0 * RAD_PER_DEG,
            tumble_rad_s: 360.0 * RAD_PER_DEG,
            wind_m_s: 10.0,
            turbulence_m_s: 1.0,
            scale_m: 100.0,
        }
    }
}

/// Releases and descents of a vehicle under a canopy, and the detector that is judged on them.
#[derive(Clone, Debug)]
pub struct FreeFallStudy {
    /// The vehicle.
    pub vehicle: Arc<Vehicle>,
    /// The site.
    pub environment: Environment,
    /// Canopy, riser, pendulum and delay.
    pub parachute: Parachute,
    /// Errors of the accelerometer.
    pub sensors: SensorSettings,
    /// The detector.
    pub settings: FreeFallSettings,
    /// What the air carries of a vehicle that has just been released [m/s^2].
    pub fall_m_s2: f64,
    /// Circumstances.
    pub circumstances: FallCircumstances,
    /// Seed of everything random.
    pub seed: u64,
}

/// What was drawn for a release, and when it was found.
#[derive(Clone, Debug, PartialEq)]
pub struct ReleaseTrial {
    /// Number of the trial.
    pub trial: u64,
    /// Amplitude of the swing [rad].
    pub swing_rad: f64,
    /// Rate that the release gave [rad/s].
    pub tumble_rad_s: f64,
    /// Mean wind [m/s].
    pub wind_m_s: f64,
    /// What readings at the autopilot's rate made of it.
    pub autopilot: FoundRelease,
    /// What readings at [`TELEMETRY_PERIOD_US`] made of it.
    pub companion: FoundRelease,
    /// For each of the [rules](rules::Rule::all) the time from the release until it found the fall at the
    /// autopilot's rate [s]; infinite where it did not by t = 0, or before the release.
    pub rules_s: Vec<f32>,
}

/// When a release was found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FoundRelease {
    /// Time from the release until the fall was found [s], negative before; `None`: not by t = 0.
    pub after_s: Option<f64>,
    /// How much later than the release the fall is said to have begun [s].
    pub dated_late_s: Option<f64>,
}

impl FoundRelease {
    /// Whether the release was missed: not found by t = 0.
    pub fn is_missed(&self) -> bool {
        self.after_s.is_none()
    }

    /// Whether a fall was found that had not begun.
    pub fn is_early(&self) -> bool {
        self.after_s.is_some_and(|after_s| after_s < 0.0)
    }
}

/// What came of a descent without a release.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Descent {
    /// Number of the descent.
    pub trial: u64,
    /// Falls that were found while the riser pulled from the fall's beginning on.
    pub alarms: u64,
    /// Falls that were found while the riser was slack, at least for a part: the vehicle did fall.
    pub slack_alarms: u64,
    /// Spells in which the riser was slack.
    pub slack_spells: u64,
    /// How long it was slack [s].
    pub slack_s: f64,
    /// Least specific force [m/s^2].
    pub least_m_s2: f64,
    /// Falls that each of the [rules](rules::Rule::all) found: riser taut, riser slack.
    pub rules: Vec<[u64; 2]>,
}

/// A vehicle under its canopy, and its accelerometer.
struct Flight {
    sim: DropSimulation,
    sensors: Sensors,
    at: TimeUs,
    /// How long after a reading of a companion the release comes [s].
    between_readings_s: f64,
}

impl Flight {
    /// Reads now and flies on for a period: when it was read, the reading, and whether the riser was slack.
    fn read(&mut self, period_us: TimeUs) -> (TimeUs, Vector3<f64>, bool) {
        let (at, q_ned_from_body) = (self.at, self.sim.state().body.q_ned_from_body);
        let loads = self.sim.step(&[0.0; MAX_ROTORS], seconds(period_us));
        self.at += period_us;
        let force_ned = loads.a_ned - self.sim.environment().gravity_ned();
        let reading = self.sensors.accelerometer(rotate_body_from_ned(q_ned_from_body, force_ned), at);
        (at, reading, loads.balance.canopy_force_ned == Vector3::zeros())
    }
}

impl FreeFallStudy {
    /// A flight under the canopy, and what was drawn for it.
    fn flight(&self, trial: u64) -> (Flight, ReleaseTrial) {
        let FallCircumstances { swing_rad, tumble_rad_s, wind_m_s, turbulence_m_s, scale_m } =
            self.circumstances;
        let mut draw = Stream::new(self.seed, Purpose::FreeFall, trial);
        let swing_rad = draw.between(0.0, swing_rad);
        let phase_rad = draw.between(0.0, std::f64::consts::TAU);
        let (size, axis) = (draw.between(0.0, tumble_rad_s), draw.normals::<3>());
        let wind_m_s = draw.between(0.0, wind_m_s);
        let (sin, cos) = crate::math::sin_cos(draw.between(0.0, std::f64::consts::TAU));
        let seeds = [draw.bits(), draw.bits()];
        let between_readings_s = draw.between(0.0, seconds(TELEMETRY_PERIOD_US));
        let tip_off = TipOff { omega_body: axis.normalize() * size, v_body: Vector3::zeros() };
        let pendulum = Pendulum { amplitude_rad: swing_rad, phase_rad, ..self.parachute.pendulum };
        let parachute = Parachute { pendulum, tip_off, ..self.parachute };
        let environment = Environment {
            wind_ned_m_s: Vector3::new(cos, sin, 0.0) * wind_m_s,
            ..self.environment.clone().uniform()
        };
        let turbulence = Some(Turbulence::isotropic(turbulence_m_s, scale_m, seeds[0]));
        let wind = Wind { turbulence, ..Wind::default() };
        let course = wind.course(&environment, trial);
        let sensors = Sensors::new(&environment, self.sensors, seeds[1], IMU_PERIOD_US);
        let sim = DropSimulation::new(self.vehicle.clone(), environment, parachute, HANG_S, Start::Release);
        let drawn = ReleaseTrial {
            trial,
            swing_rad,
            tumble_rad_s: size,
            wind_m_s,
            autopilot: FoundRelease::default(),
            companion: FoundRelease::default(),
            rules_s: vec![f32::INFINITY; RULES],
        };
        (Flight { sim: sim.in_wind(course), sensors, at: 0, between_readings_s }, drawn)
    }

    fn rules(&self) -> Rules {
        Rules::new(self.environment.gravity_m_s2, self.fall_m_s2)
    }

    /// Releases a vehicle and looks until t = 0 when it is found.
    pub fn release(&self, trial: u64) -> ReleaseTrial {
        let (mut flight, mut drawn) = self.flight(trial);
        // Between two readings.
        let released_s = HANG_S + flight.between_readings_s;
        let released_at = microseconds(released_s);
        let until = released_at + microseconds(self.parachute.delay_s);
        while seconds(flight.at) < HANG_S - READ_S {
            flight.read(TELEMETRY_PERIOD_US);
        }
        let mut detectors = [FreeFallDetector::new(self.settings); 2];
        let mut rules = self.rules();
        flight.sim.schedule_release(released_s);
        let late_s = |at: TimeUs| seconds(at) - released_s;
        while flight.at <= until {
            let (at, reading, slack) = flight.read(IMU_PERIOD_US);
            rules.take(reading.norm(), IMU_PERIOD_S, slack, |rule, _| {
                let after_s = &mut drawn.rules_s[rule];
                if at >= released_at && *after_s == f32::INFINITY {
                    *after_s = late_s(at) as f32;
                }
            });
            let found = [&mut drawn.autopilot, &mut drawn.companion];
            for (k, (detector, found)) in detectors.iter_mut().zip(found).enumerate() {
                if k == 1 && !at.is_multiple_of(TELEMETRY_PERIOD_US) {
                    continue;
                }
                if let Some(fall) = detector.take(at, &reading) {
                    *found = FoundRelease {
                        after_s: Some(late_s(fall.found_at)),
                        dated_late_s: Some(late_s(fall.began_at)),
                    };
                }
            }
        }
        drawn
    }

    /// Descends for [`DESCENT_S`] without a release.
    pub fn descend(&self, trial: u64) -> Descent {
        let (mut flight, _) = self.flight(trial);
        while seconds(flight.at) < SETTLE_S {
            flight.read(TELEMETRY_PERIOD_US);
        }
        let mut descent =
            Descent { trial, least_m_s2: f64::INFINITY, rules: vec![[0; 2]; RULES], ..Descent::default() };
        let mut detector = FreeFallDetector::new(self.settings);
        let mut rules = self.rules();
        let (mut was_slack, mut slack_until) = (false, None);
        for _ in 0..microseconds(DESCENT_S) / TELEMETRY_PERIOD_US {
            let (at, reading, slack) = flight.read(TELEMETRY_PERIOD_US);
            if slack {
                slack_until = Some(at);
                descent.slack_s += seconds(TELEMETRY_PERIOD_US);
                descent.slack_spells += u64::from(!was_slack);
            }
            was_slack = slack;
            let force_m_s2 = reading.norm();
            descent.least_m_s2 = descent.least_m_s2.min(force_m_s2);
            rules.take(force_m_s2, seconds(TELEMETRY_PERIOD_US), slack, |rule, slack| {
                descent.rules[rule][usize::from(slack)] += 1;
            });
            if let Some(fall) = detector.take(at, &reading) {
                // Slack at any reading since the fall began.
                if slack_until.is_some_and(|slack_at| slack_at > fall.began_at) {
                    descent.slack_alarms += 1;
                } else {
                    descent.alarms += 1;
                }
                detector = FreeFallDetector::new(self.settings);
            }
        }
        descent
    }
}
