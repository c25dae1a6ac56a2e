//! How a mission's gains are tuned.
//!
//! | file | holds |
//! |---|---|
//! | this one | the flights that judge gains, what is made small, and how it is searched |
//! | [`search`] | the study: a search of gains, or Ziegler and Nichols |
//! | [`unseen`] | the gains found beside others, on flights that no tuning saw |
//! | [`px4`] | the study for PX4: a search of its own parameters |
//! | `figure` | the figure of a search |
//! | [`report`] | tables, JSON, rows |

mod figure;
pub mod px4;
pub mod report;
pub mod search;
pub mod unseen;

pub use figure::convergence_figure;

use crate::settings::Word;
use crate::uncertain::uncertain_or_usual;
use samara_core::control::px4::timing::IMU_PERIOD_S;
use samara_core::control::{ControlError, Gains};
use samara_core::sim::PlantKind;
use samara_core::trajectory::Trajectory;
use samara_core::tune::cma_es::{CmaSettings, Scale};
use samara_core::tune::gain_judge::Setting;
use samara_core::tune::gain_space::gains_of;
use samara_core::tune::objective::PENALTY;
use samara_core::tune::range_ends::NEAR_AN_END;
use samara_core::tune::release_cases::{AMPLITUDES, swing_releases};
use samara_core::tune::swarm::SwarmSettings;
use samara_core::tune::{
    GainJudge, GainSpace, Longitudinal, Method, Objective, ReleaseCase, SearchSettings, SearchedNumber,
};
use samara_mission::{ConfigError, Mission};

/// Random flights with everything off at once, where it is not said how many.
pub const DRAWS: usize = 200;

/// Bounds on the RMS along the front, as multiples of the bound; the last one is the bound itself.
const FRONT: [f64; 5] = [1.5, 1.25, 0.85, 0.92, 1.0];
/// Iterations after which a swarm leaves the rest to the strategy: it finds the valley in these and takes
/// hundreds to come down it.
const SWARM_ITERATIONS: usize = 15;
/// The strategy that takes over from the swarm. By the root, integral gains near zero can still grow.
const POLISH: CmaSettings = CmaSettings { samples: 16, sigma: 0.1, scale: Scale::Root, tolerance: 1e-5 };

/// The gains of a mission's vehicle by the rule for its lag, under the reference autopilot: about a speed of
/// the rotors, and from their rest.
pub fn rules(mission: &Mission) -> [Longitudinal; 2] {
    gains_of(&mission.vehicle, mission.site.environment.density_kg_m3, IMU_PERIOD_S)
}

/// Where a mission's gains are searched: in the range that it names, or around the rule for its vehicle and
/// its own gains.
pub fn gain_space(mission: &Mission) -> GainSpace {
    match mission.study.gain_range {
        Some((least, most)) => GainSpace::of_all(least, most),
        None => GainSpace::around(&rules(mission)).holding(&mission.control.gains.as_longitudinal()),
    }
}

/// Greatest gain of the space Y of (46) [1/s], in which the first gains of all vehicles were searched.
pub const PAPERS_MOST_PER_S: f64 = 5.0;
/// The rule for a vehicle is far above that end from this multiple of it on.
const FAR_ABOVE: f64 = 1.5;
/// Places of the proportional gains.
const PROPORTIONAL: [usize; 4] = [0, 2, 3, 5];
/// Places of the attitude's and the horizontal velocity's gain.
const ATTITUDE: usize = 2;
const HORIZONTAL: usize = 5;

/// Gains of a mission beside the rule for its vehicle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BesideTheRule {
    /// Those outside the range about the rule by more than [`NEAR_AN_END`], with that range where the others
    /// are what they are. An integral may be as small as it likes, and the gain of the horizontal velocity as
    /// great as the attitude's.
    pub outside: Vec<SearchedNumber>,
    /// Those at the end of the paper's range of gains, [`PAPERS_MOST_PER_S`], while the rule is far above it:
    /// each with the least and the greatest gain of the rule.
    pub at_papers_end: Vec<SearchedNumber>,
}

/// Gains beside the rule for a mission's vehicle; nothing where the mission names a range for them.
pub fn beside_the_rule(mission: &Mission, gains: &Gains) -> BesideTheRule {
    if mission.study.gain_range.is_some() {
        return BesideTheRule::default();
    }
    let (gains, rules) = (gains.as_longitudinal(), rules(mission));
    let mut searched = GainSpace::around(&rules).searched(&gains);
    // Drafts fly horizontal loops up to the attitude's, whose margins are looked at apart.
    searched[HORIZONTAL].most = searched[HORIZONTAL].most.max(gains[ATTITUDE]);
    let is_outside = |k: usize| {
        let SearchedNumber { value, least, most, .. } = searched[k];
        let beyond = 1.0 + NEAR_AN_END;
        value > beyond * most || (beyond * value < least && PROPORTIONAL.contains(&k))
    };
    let outside = (0..gains.len()).filter(|k| is_outside(*k)).map(|k| searched[k].clone()).collect();
    let at_end = |k: &usize| {
        let [least, most] = rule_of(&rules, *k);
        let value = gains[*k];
        let near = (value / PAPERS_MOST_PER_S - 1.0).abs() <= NEAR_AN_END;
        let name = searched[*k].name.clone();
        (near && least > FAR_ABOVE * PAPERS_MOST_PER_S).then_some(SearchedNumber { name, value, least, most })
    };
    BesideTheRule { outside, at_papers_end: PROPORTIONAL.iter().filter_map(at_end).collect() }
}

/// Least and greatest of the rules for a gain.
fn rule_of([a, b]: &[Longitudinal; 2], k: usize) -> [f64; 2] {
    [a[k].min(b[k]), a[k].max(b[k])]
}

/// The least and the greatest of each gain, between which PX4's are searched: the range that the mission
/// names, or what lies around the rules for its vehicle, each gain with the others as in the rule.
pub fn gain_ends(mission: &Mission) -> [Longitudinal; 2] {
    let rules = rules(mission);
    let space = match mission.study.gain_range {
        Some((least, most)) => GainSpace::of_all(least, most),
        None => GainSpace::around(&rules),
    };
    let [about_a_speed, from_rest] = rules.map(|rule| space.searched(&rule));
    let least = std::array::from_fn(|k| about_a_speed[k].least.min(from_rest[k].least));
    [least, std::array::from_fn(|k| about_a_speed[k].most.max(from_rest[k].most))]
}

/// How to search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TuningMethod {
    /// Particle swarm, then evolution strategy.
    SwarmThenCmaEs,
    /// Particle swarm.
    Swarm,
    /// Evolution strategy.
    CmaEs,
}

/// What to make small.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TuningObjective {
    /// Worst J_TPF with a bound on tracking.
    Safety,
    /// Worst tracking RMS, (45).
    Rms,
    /// Worst J_TPF, (51).
    JTpf,
    /// J_TPF at several bounds on tracking.
    Pareto,
}

/// The words for ways to search.
pub const METHODS: [(&str, TuningMethod); 3] = [
    ("pso-cma", TuningMethod::SwarmThenCmaEs),
    ("pso", TuningMethod::Swarm),
    ("cma-es", TuningMethod::CmaEs),
];

/// The words for what to make small.
pub const OBJECTIVES: [(&str, TuningObjective); 4] = [
    ("safety", TuningObjective::Safety),
    ("rms", TuningObjective::Rms),
    ("j-tpf", TuningObjective::JTpf),
    ("pareto", TuningObjective::Pareto),
];

/// The words for the actuators of the flights.
pub const MODELS: [(&str, PlantKind); 2] = [("ideal", PlantKind::Ideal), ("actuator", PlantKind::Actuator)];

/// A tuning, as it is asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Tuning {
    /// How to search.
    pub method: Word<TuningMethod>,
    /// What to make small.
    pub objective: Word<TuningObjective>,
    /// The actuators of the flights.
    pub plant: Word<PlantKind>,
    /// Largest worst tracking RMS, (45); `None`: what the mission's own gains reach.
    pub rms_bound: Option<f64>,
    /// J_TPF that it costs to break a bound by as much again.
    pub penalty: f64,
    /// Amplitudes of the swing, in standard deviations.
    pub swing: Vec<f64>,
    /// Whether J_TPF is judged also with a vehicle and air that are not known, and then by how many random
    /// flights with everything off at once, beside those with one thing off at a time.
    pub robust: Option<usize>,
    /// Gains to begin at, a name or a file; `None`: the mission's own, and for swarms those of the rule,
    /// unless the mission names a range of the gains: then none for swarms.
    pub start: Option<String>,
    /// Candidates of an iteration; `None`: the method's usual number.
    pub candidates: Option<usize>,
    /// Most iterations for each bound.
    pub iterations: usize,
    /// Iterations after which a swarm that finds nothing better stops.
    pub stall_iterations: usize,
}

impl Default for Tuning {
    fn default() -> Self {
        Self {
            method: Word { word: METHODS[0].0, means: METHODS[0].1 },
            objective: Word { word: OBJECTIVES[0].0, means: OBJECTIVES[0].1 },
            plant: Word { word: MODELS[1].0, means: MODELS[1].1 },
            rms_bound: None,
            penalty: PENALTY,
            swing: AMPLITUDES.to_vec(),
            robust: None,
            start: None,
            candidates: None,
            iterations: 200,
            stall_iterations: 20,
        }
    }
}

/// The mission's own gains give no bound on tracking, because they lose a flight.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the mission's own gains, {gains_name}, lose a flight, so they give no bound on tracking{flight}")]
pub struct NoBoundError {
    /// Name of the gains.
    pub gains_name: String,
    /// The flight in words, behind a colon, where it is known.
    pub flight: String,
}

impl Tuning {
    /// The vehicle, the site and the plan that gains are judged on.
    pub fn setting<'a>(&self, mission: &Mission, plan: &'a Trajectory) -> Setting<'a> {
        Setting {
            scenario: mission.scenario(),
            control_limits: mission.control.limits,
            plant: self.plant.means,
            yaw: mission.control.gains,
            plan,
            feed_forward: mission.control.feed_forward,
            settle_s: mission.settle_s(plan),
        }
    }

    /// The flights that judge candidates of the search.
    ///
    /// # Errors
    /// [`ControlError`] for a vehicle that cannot be controlled.
    pub fn judge<'a>(&self, mission: &Mission, plan: &'a Trajectory) -> Result<GainJudge<'a>, ControlError> {
        let cases = &mission.study.cases;
        let judge = GainJudge::new(self.setting(mission, plan))?.with_cases(cases);
        let swings = match self.objective.means {
            TuningObjective::Safety | TuningObjective::Pareto => {
                swing_releases(&mission.releases(), &self.swing)
            }
            TuningObjective::Rms | TuningObjective::JTpf => Vec::new(),
        };
        let judge = judge.with_states(&swings);
        let Some(draws) = self.robust else { return Ok(judge) };
        let states: Vec<_> = cases.iter().map(ReleaseCase::state).collect();
        let uncertain = uncertain_or_usual(mission);
        let judge = judge.with_variations(cases, &uncertain).with_tipped(&states).with_tipped(&swings);
        Ok(judge.with_draws(&mission.releases().with_uncertain(Some(uncertain)), mission.seed, draws))
    }

    /// The objectives of the search; the gains found are the best under the last.
    ///
    /// # Errors
    /// [`NoBoundError`] when a bound is needed and neither given nor reached by the mission's own gains.
    pub fn objectives(
        &self,
        mission: &Mission,
        judge: &GainJudge<'_>,
    ) -> Result<Vec<Objective>, NoBoundError> {
        let penalty = self.penalty;
        let bound = || {
            let bound = self.rms_bound(mission, judge);
            if bound.is_finite() {
                return Ok(bound);
            }
            let lost = judge.first_lost(&mission.control.gains.as_longitudinal());
            Err(NoBoundError {
                gains_name: mission.control.gains_name.clone(),
                flight: lost.map_or_else(String::new, |flight| format!(": {flight}")),
            })
        };
        Ok(match self.objective.means {
            TuningObjective::Rms => vec![Objective::Rms],
            TuningObjective::JTpf => vec![Objective::JTpf],
            TuningObjective::Safety => vec![Objective::Safety { rms_bound: bound()?, penalty }],
            TuningObjective::Pareto => {
                let bound = bound()?;
                FRONT.iter().map(|share| Objective::Safety { rms_bound: share * bound, penalty }).collect()
            }
        })
    }

    /// The bound on the tracking RMS: the one asked for, or what the mission's own gains reach on these
    /// flights; infinite when those lose one.
    pub fn rms_bound(&self, mission: &Mission, judge: &GainJudge<'_>) -> f64 {
        self.rms_bound.unwrap_or_else(|| judge.evaluate(&mission.control.gains.as_longitudinal()).rms)
    }

    /// The settings of the search.
    ///
    /// # Errors
    /// [`ConfigError`] when the gains to begin at cannot be read.
    pub fn search(
        &self,
        mission: &Mission,
        objectives: Vec<Objective>,
    ) -> Result<SearchSettings, ConfigError> {
        let candidates = |default: usize| self.candidates.unwrap_or(default);
        let (swarm, cma) = (SwarmSettings::default(), CmaSettings::default());
        let swarm = SwarmSettings {
            particles: candidates(swarm.particles),
            stall_iterations: self.stall_iterations,
            ..swarm
        };
        let own = || mission.control.gains.as_longitudinal();
        let starts = match (&self.start, self.method.means) {
            (Some(name), _) => {
                let mut other = mission.clone();
                other.use_gains(name)?;
                vec![other.control.gains.as_longitudinal()]
            }
            (None, TuningMethod::CmaEs) => vec![own()],
            // The paper's search begins anywhere.
            (None, _) if mission.study.gain_range.is_some() => Vec::new(),
            (None, _) => [vec![own()], rules(mission).to_vec()].concat(),
        };
        let mut space = gain_space(mission);
        if mission.study.gain_range.is_none() {
            space = starts.iter().fold(space, GainSpace::holding);
        }
        Ok(SearchSettings {
            method: match self.method.means {
                TuningMethod::CmaEs => Method::CmaEs(CmaSettings { samples: candidates(cma.samples), ..cma }),
                TuningMethod::Swarm => Method::Swarm(swarm),
                TuningMethod::SwarmThenCmaEs => {
                    Method::SwarmThenCmaEs { swarm, swarm_iterations: SWARM_ITERATIONS, polish: POLISH }
                }
            },
            objectives,
            iterations: self.iterations,
            space,
            starts,
            seed: mission.seed,
        })
    }

    /// The name of the gains that the search begins at.
    pub fn start_name(&self, mission: &Mission) -> String {
        match (&self.start, self.method.means) {
            (Some(name), _) => name.clone(),
            (None, TuningMethod::CmaEs) => mission.control.gains_name.clone(),
            (None, TuningMethod::SwarmThenCmaEs | TuningMethod::Swarm) => {
                let alone = mission.study.gain_range.is_some();
                if alone { "none".to_owned() } else { format!("{}, the rule", mission.control.gains_name) }
            }
        }
    }
}
