//! Drops on the autopilot's own estimator: how far the flight is from that on the truth, and whether the
//! filter knows its errors while its own estimate is flown by.

use std::ops::ControlFlow;
use std::path::Path;

use nalgebra::{SMatrix, SVector};
use samara::assess::{Verdict, VerdictBuilder};
use samara::autopilot::estimator::{Estimator, EstimatorSettings, Noise};
use samara::config::{Mission, load_mission};
use samara::frames::{conjugate, product, rotation_vector};
use samara::link::{
    AutopilotSession, HilConfig, HilSession, Lockstep, StreamerConfig, StreamerSession, microseconds,
};
use samara::model::rigid_body::BodyState;
use samara::plan::{Guess, SolverOptions, plan};
use samara::sim::sensors::{Barometer, Magnetometer, Satellite, Triad};
use samara::sim::{DropRunConfig, DropSimulation, SensorSettings};
use samara::trajectory::Trajectory;

use super::bench::autopilot_of;

/// A mission with its plan.
struct Drop {
    mission: Mission,
    plan: Trajectory,
}

impl Drop {
    fn of(name: &str) -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("mission").join(name);
        let mission = load_mission(&path).unwrap();
        let go_on = &mut |_: &_| ControlFlow::Continue(());
        let options = SolverOptions::default();
        let plan = plan(&mission.plan_problem(), &Guess::StraightLine, &options, go_on).unwrap();
        Self { plan: plan.trajectory, mission }
    }

    fn wire(&self, seed: u64, sensors: SensorSettings, on_estimator: bool) -> Lockstep<AutopilotSession> {
        let m = &self.mission;
        let (vehicle, site) = (m.vehicle.clone(), m.site.environment.clone());
        let config = HilConfig {
            run: DropRunConfig { duration_us: microseconds(m.duration_s), ..DropRunConfig::default() },
            sensors,
            seed,
            ..HilConfig::default()
        };
        let settings = EstimatorSettings {
            gps_delay_us: sensors.satellite.delay_us,
            ..EstimatorSettings::at_site(site.gravity_m_s2, sensors.magnetometer.field_at(&site))
        };
        let autopilot = autopilot_of(m, on_estimator.then_some(settings));
        let streamer = StreamerConfig {
            hang_s: m.release.hang_s,
            delay_s: m.release.parachute.delay_s,
            target_v_ned: m.target_v_ned,
            ..StreamerConfig::default()
        };
        let simulation =
            DropSimulation::new(vehicle, site, m.release.parachute, m.release.hang_s, m.release.start);
        Lockstep::new(
            HilSession::new(simulation, config),
            autopilot,
            StreamerSession::new(streamer, self.plan.clone()),
        )
    }

    fn verdict(&self, seed: u64, sensors: SensorSettings, on_estimator: bool) -> Verdict {
        let mut wire = self.wire(seed, sensors, on_estimator);
        wire.run(&mut |_, _, _| {}).unwrap();
        assert!(!wire.simulator.run().record().failsafe, "{:?}", wire.simulator.run().record());
        let mut verdict = VerdictBuilder::new(self.mission.limits.safety, self.mission.target_v_ned);
        wire.simulator.run().log().iter().for_each(|sample| verdict.observe(sample));
        verdict.finish().unwrap()
    }
}

/// Sensors that err as the filter thinks, one sigma for one sigma, with fixes that are 120 ms old.
fn as_the_filter_thinks() -> SensorSettings {
    let noise = Noise::TYPICAL;
    // PX4's atmosphere near its sea level: 0.12 hPa per metre, 0.107 at a kilometre.
    const HPA_PER_M: f64 = 0.11;
    let triad =
        |noise_density, walk, turn_on_bias| Triad { noise_density, walk, turn_on_bias, ..Triad::default() };
    SensorSettings {
        accelerometer: triad(noise.accelerometer, noise.accelerometer_walk, noise.accelerometer_bias),
        gyroscope: triad(noise.gyro, noise.gyro_walk, noise.gyro_bias),
        magnetometer: Magnetometer { noise_gauss: noise.magnetometer_gauss, ..Magnetometer::default() },
        barometer: Barometer {
            period_us: 0,
            noise_hpa: noise.baro_m * HPA_PER_M,
            drift_hpa_per_sqrt_s: noise.baro_walk * HPA_PER_M,
        },
        satellite: Satellite {
            // What the simulator's receiver claims at the least is then what it does.
            horizontal_noise_m: 0.9,
            vertical_noise_m: 1.2,
            speed_noise_m_s: noise.gps_speed_m_s,
            delay_us: 120_000,
            ..Satellite::default()
        },
    }
}

/// Position, velocity and attitude: what the truth of a drop holds.
const SEEN: usize = 9;

/// Normalised squared error of position, velocity and attitude, by their part of the covariance.
fn squared_error(estimator: &Estimator, truth: &BodyState) -> f64 {
    let filter = estimator.filter().unwrap();
    let state = &filter.state;
    let turn = rotation_vector(product(conjugate(state.q_ned_from_body), truth.q_ned_from_body));
    let parts = [truth.p_ned - state.p_ned, truth.v_ned - state.v_ned, turn];
    let e = SVector::<f64, SEEN>::from_fn(|i, _| parts[i / 3][i % 3]);
    let p = SMatrix::<f64, SEEN, SEEN>::from_fn(|i, j| filter.covariance.at(i, j));
    e.dot(&p.cholesky().unwrap().solve(&e))
}

/// Normalised squared errors at these times [s], averaged over seeds and as many swings.
fn consistency<const N: usize>(
    drop: &mut Drop,
    sensors: SensorSettings,
    seeds: u64,
    looks_s: [f64; N],
) -> [f64; N] {
    let mut sums = [0.0; N];
    for seed in 0..seeds {
        // A swing of 5.7 deg, over the phases.
        drop.mission.release.parachute.pendulum.amplitude_rad = 0.1;
        drop.mission.release.parachute.pendulum.phase_rad =
            std::f64::consts::TAU * seed as f64 / seeds as f64;
        let mut wire = drop.wire(seed, sensors, true);
        for (sum, look_s) in sums.iter_mut().zip(looks_s) {
            while wire.simulator.run().simulation().time_s() < look_s - 1e-6 {
                wire.step(&mut |_, _, _| {}).unwrap();
            }
            let estimator = wire.autopilot.estimator().unwrap();
            // The filter stands behind the present.
            let at_s = estimator.filter_us().unwrap() as f64 * 1e-6;
            let sim = wire.simulator.run().simulation();
            let past = wire.simulator.run().log().iter().rfind(|s| (s.t_s - at_s).abs() < 1e-4);
            let truth = past.map_or(&sim.state().body, |sample| &sample.state.body);
            assert!(past.is_some() || (sim.time_s() - at_s).abs() < 1e-4);
            *sum += squared_error(estimator, truth) / seeds as f64;
        }
        assert!(
            wire.autopilot.autopilot().is_armed(),
            "seed {seed}: {:?}",
            wire.autopilot.estimator().unwrap().accuracy()
        );
    }
    sums
}

/// Bounds of the mean of so many draws of chi-square with [`SEEN`] degrees of freedom, at 3.3 sigmas, by
/// Wilson and Hilferty's cube.
fn chi_square_bounds(seeds: u64) -> [f64; 2] {
    let freedom = (seeds as usize * SEEN) as f64;
    let c = 2.0 / (9.0 * freedom);
    [-3.3, 3.3].map(|z| freedom * (1.0 - c + z * f64::sqrt(c)).powi(3) / seeds as f64)
}

/// Hang, the fall, the rotors' start, pull-out, flight along the plan.
const LOOKS_S: [f64; 7] = [6.0, 9.9, 10.4, 10.8, 11.5, 13.0, 16.0];
const SEEDS: u64 = 48;

#[test]
fn closed_form_the_filter_knows_its_errors_while_it_is_flown_on() {
    let [least, most] = chi_square_bounds(SEEDS);
    for name in ["titan_drop.json", "x500_drop.json"] {
        let mut drop = Drop::of(name);
        let means = consistency(&mut drop, as_the_filter_thinks(), SEEDS, LOOKS_S);
        assert!(
            means.iter().all(|m| (least..most).contains(m)),
            "{name}: {means:.2?} not in {least:.2}..{most:.2}"
        );
    }
}

/// Better sensors than the filter thinks: it is more careful than it need be, and never too sure.
#[test]
fn closed_form_the_filter_is_never_too_sure_with_the_missions_sensors() {
    const SEEDS: u64 = 12;
    let [_, most] = chi_square_bounds(SEEDS);
    for name in ["titan_drop.json", "x500_drop.json"] {
        let mut drop = Drop::of(name);
        let sensors = drop.mission.sensors;
        let means = consistency(&mut drop, sensors, SEEDS, LOOKS_S);
        assert!(means.iter().all(|m| *m < most), "{name}: {means:.2?} not below {most:.2}");
    }
}

/// J_TPF on the estimator beside that on the truth. Bounds are above what seeds 1 to 10 made: with the
/// mission's ideal sensors 0.0005; with a small autopilot's on Titan 0.012, since the pitch is known to a
/// degree or two only (0.05 m/s^2 of bias are 2 deg of weight there) and the velocity to some cm/s; on Earth
/// 0.0002, since the peak is the speed of the fall, which nobody controls.
#[test]
fn regress_a_drop_on_the_estimator_is_the_drop_on_the_truth() {
    let [titan, x500] = ["titan_drop.json", "x500_drop.json"].map(Drop::of);
    let small_autopilot =
        SensorSettings { magnetometer: titan.mission.sensors.magnetometer, ..x500.mission.sensors };
    for (drop, sensors, within) in [
        (&titan, titan.mission.sensors, 0.002),
        (&titan, small_autopilot, 0.02),
        (&x500, x500.mission.sensors, 0.001),
    ] {
        let truth = drop.verdict(1, sensors, false);
        for seed in 1..=3 {
            let flown = drop.verdict(seed, sensors, true);
            assert!(
                (flown.outcome.j_tpf - truth.outcome.j_tpf).abs() < within,
                "{} {seed}: {} {}",
                drop.mission.name,
                flown.outcome.j_tpf,
                truth.outcome.j_tpf
            );
            assert!(flown.limits_passed.is_empty());
            let off = flown.outcome.final_v_ned() - truth.outcome.final_v_ned();
            assert!(off.norm() < 0.3, "{} {seed}: {off}", drop.mission.name);
        }
    }
}

/// The truth is flown to the bit as without sensors: what the filter would have read does not enter.
#[test]
fn regress_the_truth_is_flown_whatever_the_sensors_say() {
    let drop = Drop::of("titan_drop.json");
    let end = |sensors| {
        let mut wire = drop.wire(1, sensors, false);
        while wire.simulator.run().simulation().time_s() < 13.0 {
            wire.step(&mut |_, _, _| {}).unwrap();
        }
        assert!(wire.autopilot.estimator().is_none());
        wire.simulator.run().log().last().unwrap().state
    };
    assert_eq!(end(drop.mission.sensors), end(as_the_filter_thinks()));
}
