//! The first gains of a drafted mission: several sets, each of them flown, the best one taken.

use std::ops::ControlFlow;

use super::controller::controller_with;
use samara_core::assess::{Course, Verdict, VerdictBuilder, judge};
use samara_core::control::Gains;
use samara_core::model::{RotorLimits, Vehicle};
use samara_core::sim::{FlightPlan, PlantKind, Reference, fly};
use samara_core::trajectory::Trajectory;
use samara_core::tune::Longitudinal;
use samara_core::tune::gain_judge::Setting;
use samara_core::tune::near_hover::near_hover;
use samara_mission::Mission;

/// A set of gains and the flight that it was chosen by.
#[derive(Clone, Debug)]
pub struct FlownGains {
    /// The gains.
    pub gains: Gains,
    /// Where they come from, in words.
    pub about: String,
    /// Verdict of the mission's drop with them, flown without a wire.
    pub verdict: Verdict,
}

/// Control period of the flights [s]: the reference autopilot's.
const PERIOD_S: f64 = 0.004;
/// Shares of the guessed gains that are flown.
const SHARES: [f64; 4] = [1.0, 0.6, 0.35, 0.2];

/// Gains of which each loop is slower than the one inside it, and the innermost slower than the rotors: its
/// gain is a quarter of the rate at which thrust comes. `share` makes all of them slower.
pub fn guessed_gains(vehicle: &Vehicle, density_kg_m3: f64, share: f64) -> Gains {
    let rotors = RotorLimits::of(vehicle, density_kg_m3);
    // A third of the time for 90 % of the thrust is about a time constant.
    let lag_s = 0.3 * rotors.thrust_n / rotors.thrust_slew_n_s;
    let rate = share * (0.25 / lag_s).clamp(0.5, 10.0);
    let (attitude, down) = (0.4 * rate, 0.4 * rate);
    let north = 0.35 * attitude;
    Gains::longitudinal([rate, 0.1 * rate, attitude, down, 0.05 * down, north, 0.05 * north])
}

/// Flies the mission's drop with gains by the rules of Ziegler and Nichols ([`near_hover`], IV.D) and with
/// guessed ones of several speeds, and returns the set that is steady soonest of those that stay within the
/// limits. `None` when none does both.
pub fn gains_that_fly(mission: &Mission, plan: &Trajectory) -> Option<FlownGains> {
    let (vehicle, environment) = (&mission.vehicle, &mission.site.environment);
    let setting = Setting {
        scenario: mission.scenario(),
        control_limits: mission.control.limits,
        plant: PlantKind::Actuator,
        yaw: mission.control.gains,
        plan,
        feed_forward: mission.control.feed_forward,
        settle_s: 0.0,
    };
    let guessed = SHARES.map(|share| {
        let about = format!(
            "each loop slower than the one inside it, the innermost {share} of a quarter of the rate at which the rotors' thrust comes"
        );
        (guessed_gains(vehicle, environment.density_kg_m3, share), about)
    });
    let rules = near_hover(&setting).ok().map(|found| {
        let gains: Longitudinal = found.adjusted;
        (
            Gains::longitudinal(gains),
            "Ziegler and Nichols' rules on the vehicle's own loops (IV.D)".to_owned(),
        )
    });
    let flown = rules.into_iter().chain(guessed).filter_map(|(gains, about)| {
        let verdict = flown(mission, plan, gains)?;
        let safe = judge(Some(&verdict), &Course::WHOLE).is_empty();
        safe.then_some(FlownGains { gains, about, verdict })
    });
    flown.reduce(|best, next| {
        let after = |flown: &FlownGains| flown.verdict.outcome.steady_after_s.unwrap_or(f64::INFINITY);
        if after(&next) < after(&best) { next } else { best }
    })
}

/// The verdict on the mission's drop with these gains.
fn flown(mission: &Mission, plan: &Trajectory, gains: Gains) -> Option<Verdict> {
    let mut cascade = controller_with(mission, &gains).ok()?;
    let then_v_ned = Some(mission.target_v_ned);
    let feed_forward = mission.control.feed_forward;
    let reference = Reference::Plan { trajectory: plan, then_v_ned, feed_forward };
    let mut sim = mission.simulation();
    sim.schedule_release(mission.release.hang_s);
    let mut verdict = VerdictBuilder::judging(mission.limits, mission.target_v_ned).along(plan);
    let _ = fly(
        &mut sim,
        &mut cascade,
        &FlightPlan::new(reference, PERIOD_S, mission.duration_s),
        &mut |sample| {
            verdict.observe(sample);
            ControlFlow::Continue(())
        },
    );
    verdict.finish()
}
