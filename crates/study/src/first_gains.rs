//! The first gains of a drafted mission: several sets by rules for the vehicle's own lag, each of them flown
//! in what the controller does not know of, the best one taken.

use std::ops::ControlFlow;

use super::controller::controller_with;
pub use super::designing::LEAST_MODULUS;
use super::designing::{first_judge, own_design};
use super::tuning::{beside_the_rule, rules};
use samara_core::assess::outcome::{J_TPF, OutcomeSummary, STEADY_AFTER};
use samara_core::assess::{self, Course, Verdict, VerdictBuilder};
use samara_core::control::Gains;
use samara_core::control::px4::timing::IMU_PERIOD_S;
use samara_core::design::{Design, DesignJudge, LOOPS};
use samara_core::model::Vehicle;
use samara_core::sim::{FlightPlan, PlantKind, Reference, fly};
use samara_core::trajectory::Trajectory;
use samara_core::tune::Longitudinal;
use samara_core::tune::gain_judge::Setting;
use samara_core::tune::gain_space::{INTEGRAL_OF_VELOCITY, PACE, gains_of};
use samara_core::tune::near_hover::near_hover;
use samara_mission::Mission;

/// Random drops that each set of gains flies, with everything unknown, in light turbulence.
pub const RANDOM_DROPS: usize = 32;

/// A set of gains and the flights that it was chosen by.
#[derive(Clone, Debug)]
pub struct FlownGains {
    /// The gains.
    pub gains: Gains,
    /// Where they come from, in words.
    pub about: String,
    /// Verdict of the mission's drop with them, flown without a wire.
    pub verdict: Verdict,
    /// How many of [`RANDOM_DROPS`] were not safe.
    pub unsafe_drops: usize,
    /// Whether a gain is outside the range about the rule for the vehicle ([`beside_the_rule`]).
    pub beside_the_rule: bool,
    /// How many of them were steady only after the plan's end, or never.
    pub late_drops: usize,
    /// What those drops came to.
    pub random: OutcomeSummary,
    /// Least distance of a loop's response from -1, and least delay that makes a loop unstable [s].
    pub margins: (f64, f64),
    /// Name of the loop that is so near, and of the state that it is so near at.
    pub nearest: (&'static str, &'static str),
    /// What stops gains whose loops keep [`LEAST_MODULUS`], where these do not.
    pub stopped_by: Option<StoppedBy>,
}

/// Why a draft has no gains whose loops keep [`LEAST_MODULUS`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StoppedBy {
    /// Gains that keep it leave more drops unsafe: so many of [`RANDOM_DROPS`] of the best of them.
    UnsafeDrops(usize),
    /// No gains that fly the mission's drop keep it.
    NoSet,
}

impl FlownGains {
    /// Greatest J_TPF of the random drops, and the mean of their times to steady flight [s].
    pub fn worst_and_steady(&self) -> (f64, f64) {
        (self.random.of(&J_TPF).max(), self.random.of(&STEADY_AFTER).mean())
    }

    /// Order among sets, the best first: of the fewest unsafe drops; of those that keep a modulus of a half;
    /// of those in the range about the rule; of the fewest drops that are late; of the least worst J_TPF
    /// above [`COMMANDED`], as finely as the draws tell; soonest steady.
    fn rank(&self) -> ((usize, bool, bool, usize), f64, f64) {
        let (worst, steady_s) = self.worst_and_steady();
        let near = self.margins.0 < LEAST_MODULUS;
        let counted = (self.unsafe_drops, near, self.beside_the_rule, self.late_drops);
        (counted, (TOLD * worst.max(COMMANDED)).round(), steady_s)
    }
}

/// Steps of J_TPF that so few drops tell apart, to 1.
const TOLD: f64 = 50.0;
/// J_TPF that tells nothing more: a draft's commands are limited to so much of what is judged, and where they
/// are used, the vehicle is steadier for it.
const COMMANDED: f64 = 0.6;
/// Paces of the rule that are flown, as shares of its own.
const SHARES: [f64; 4] = [1.0, 0.7, 0.5, 0.3];
/// Horizontal velocity loops that are flown at each pace: the gain in the rule's, and the integral over the
/// square of the gain. A slow vehicle's rule bears more, and in wind needs it: up to nearly the attitude's
/// gain. With a quarter, the loop of both has one double root.
const NORTH: [(f64, f64); 4] = [(1.0, INTEGRAL_OF_VELOCITY), (1.75, 0.25), (2.5, 0.25), (3.4, 0.25)];

/// The gains by the rule for a vehicle's lag about a speed, in air of a density [kg/m^3]: what a draft has
/// before anything was flown.
pub fn guessed_gains(vehicle: &Vehicle, density_kg_m3: f64) -> Gains {
    let [about_a_speed, _] = gains_of(vehicle, density_kg_m3, IMU_PERIOD_S);
    Gains::longitudinal(about_a_speed)
}

/// Flies the mission's drop and random ones with gains by the rule for the vehicle's lag at several paces,
/// and by the rules of Ziegler and Nichols ([`near_hover`], IV.D), and returns the best of the sets with
/// which the mission's own drop is safe. `None` when there is none.
pub fn gains_that_fly(mission: &Mission, plan: &Trajectory) -> Option<FlownGains> {
    let [about_a_speed, from_rest] = rules(mission);
    let mut lags = vec![("about a speed", about_a_speed)];
    // A motor of first order is as late from rest.
    if from_rest[0] < 0.9 * about_a_speed[0] {
        lags.push(("from rest", from_rest));
    }
    let by_rule = lags.into_iter().flat_map(|(when, rule)| {
        SHARES.into_iter().flat_map(move |share| NORTH.map(|north| (share, north))).map(
            move |(share, (faster, integral))| {
                let pace = share * PACE;
                let about = format!(
                    "by the rule for the rotors' lag {when}, at a pace of {pace:.2}, horizontally {faster} of it"
                );
                let mut k = slowed(&rule, share);
                k[5] *= faster;
                k[6] = integral * k[5] * k[5];
                (k, about)
            },
        )
    });
    let setting = Setting {
        scenario: mission.scenario(),
        control_limits: mission.control.limits,
        plant: PlantKind::Actuator,
        yaw: mission.control.gains,
        plan,
        feed_forward: mission.control.feed_forward,
        settle_s: 0.0,
    };
    let relays = near_hover(&setting).ok().map(|found| {
        let mut k = found.adjusted;
        for (integral, gain) in [(4, 3), (6, 5)] {
            k[integral] = INTEGRAL_OF_VELOCITY * k[gain] * k[gain];
        }
        (k, "Ziegler and Nichols' rules on the vehicle's own loops (IV.D), integrals by the rule".to_owned())
    });
    let sets: Vec<(Longitudinal, String)> = by_rule.chain(relays).collect();
    let judge = first_judge(mission, RANDOM_DROPS);
    let own = own_design(mission);
    let keeps = |(k, _): &(Longitudinal, String)| {
        judge.least_margins(plan, &Design { gains: *k, ..own }).0 >= LEAST_MODULUS
    };
    let (keeping, others): (Vec<_>, Vec<_>) = sets.into_iter().partition(keeps);
    let best_of = |sets: Vec<(Longitudinal, String)>| {
        let flown = sets.into_iter().filter_map(|(k, about)| flown_by(&judge, (mission, plan), (&k, about)));
        flown.reduce(better)
    };
    let kept = best_of(keeping);
    if kept.as_ref().is_some_and(|set| set.unsafe_drops == 0) {
        return kept;
    }
    let unsafe_of_kept = kept.as_ref().map(|set| set.unsafe_drops);
    let best = kept.into_iter().chain(best_of(others)).reduce(better)?;
    let stopped_by = (best.margins.0 < LEAST_MODULUS)
        .then(|| unsafe_of_kept.map_or(StoppedBy::NoSet, StoppedBy::UnsafeDrops));
    Some(FlownGains { stopped_by, ..best })
}

/// The better of two sets, the first of equal ones.
fn better(best: FlownGains, next: FlownGains) -> FlownGains {
    let (a, b) = (best.rank(), next.rank());
    let later = a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.total_cmp(&b.2));
    if later.is_gt() { next } else { best }
}

/// Gains of a rule at a part of its pace.
fn slowed(rule: &Longitudinal, share: f64) -> Longitudinal {
    let [pq, iq, ptheta, pvz, ivz, pvx, ivx] = *rule;
    let square = share * share;
    [share * pq, square * iq, share * ptheta, share * pvz, square * ivz, share * pvx, square * ivx]
}

/// A set of gains in the mission's drop and in the judge's; `None` where the mission's drop is not safe.
fn flown_by(
    judge: &DesignJudge<'_>,
    (mission, plan): (&Mission, &Trajectory),
    (k, about): (&Longitudinal, String),
) -> Option<FlownGains> {
    let Gains { k_ppsi, k_pr, .. } = mission.control.gains;
    let gains = Gains { k_ppsi, k_pr, ..Gains::longitudinal(*k) };
    let verdict = flown(mission, plan, gains)?;
    if !assess::judge(Some(&verdict), &Course::WHOLE).is_empty() {
        return None;
    }
    let design = Design { gains: *k, ..own_design(mission) };
    let drops = judge.fly_drops(0..RANDOM_DROPS, &design, plan);
    let mut random = OutcomeSummary::default();
    drops.iter().for_each(|drop| random.push(&drop.outcome));
    let unsafe_drops = drops.iter().filter(|drop| !drop.objections.is_empty()).count();
    let in_time = |after_s: Option<f64>| after_s.is_some_and(|after_s| after_s <= mission.plan.horizon_s);
    let late_drops = drops.iter().filter(|drop| !in_time(drop.outcome.steady_after_s)).count();
    let margins = judge.least_margins(plan, &design);
    let loops = judge.worst_loops(&judge.operating_points(Some(plan)), &design);
    let nearest = loops.iter().min_by(|a, b| a.modulus.0.total_cmp(&b.modulus.0));
    let nearest = nearest.map_or(("", ""), |of| (LOOPS[of.index].0, of.modulus.1.state));
    Some(FlownGains {
        gains,
        about,
        verdict,
        unsafe_drops,
        beside_the_rule: !beside_the_rule(mission, &gains).outside.is_empty(),
        late_drops,
        random,
        margins,
        nearest,
        stopped_by: None,
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
        &FlightPlan::new(reference, IMU_PERIOD_S, mission.duration_s),
        &mut |sample| {
            verdict.observe(sample);
            ControlFlow::Continue(())
        },
    );
    verdict.finish()
}
