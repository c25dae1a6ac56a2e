//! Which manoeuvres, and how many rounds of each, for wanted errors. Each is flown once by itself; what it
//! tells of every parameter adds up, round by round, and so does what that scatters.

use super::flight::{Rehearsal, Seen};
use super::{Kind, Sizes, Step, length_s};
use crate::identify::{IdentifyError, Information, PARAMETERS, Parameter, Settings};

/// Shortest flight that a manoeuvre is tried by [s].
const TRIED_S: f64 = 36.0;
/// Sizes at first, unless bounds are narrower.
const FIRST: Sizes = Sizes {
    tilt_rad: 0.35,
    yaw_rad: 0.5,
    thrust: 0.25,
    speed_m_s: 8.0,
    acceleration_m_s2: 4.0,
    climb_m_s: 1.5,
};
/// Share of bounds up to which manoeuvres are asked for, and go.
const ASKED: f64 = 0.6;
const GONE: f64 = 0.9;
/// By how much a manoeuvre that goes beyond its bounds is made smaller, and how often.
const SMALLER: f64 = 0.8;
const TRIES: usize = 8;
/// What a round is to gain per second, as a sum of logarithms of errors.
const LEAST_GAIN: f64 = 1e-4;
/// What errors count for beyond those that are wanted, over those above them; and of what is not told at all.
const BEYOND: f64 = 0.01;
const MOST: f64 = 100.0;
/// So often a recipe is revised by what came out, and by so much goals are below what is wanted.
const REVISED: usize = 3;
const ROOM: f64 = 0.8;
/// Shortest recipe: what is identified needs twenty seconds that are flown without a gap [s].
const LEAST_S: f64 = 30.0;

/// What flights are to stay within.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Tilt [rad].
    pub tilt_rad: f64,
    /// Speed [m/s].
    pub speed_m_s: f64,
    /// Height lost [m].
    pub below_m: f64,
    /// Energy at the rotors' shafts [J]; infinite without a battery.
    pub energy_j: f64,
    /// Length [s].
    pub length_s: f64,
}

/// Largest standard errors that are wanted, in the order of [`Parameter::ALL`] and in each one's own terms.
pub type Wanted = [f64; PARAMETERS];

/// Errors that are wanted unless others are: shares, [s] and [m].
pub const USUAL: Wanted = [0.01, 0.05, 0.02, 0.02, 0.05, 0.1, 0.1, 0.05, 0.05, 0.002, 0.003, 0.003];

/// A manoeuvre that was tried.
#[derive(Clone, Debug)]
pub struct Trial {
    /// Which.
    pub kind: Kind,
    /// How large.
    pub sizes: Sizes,
    /// Length of a round [s].
    pub round_s: f64,
    /// How far its flight went.
    pub seen: Seen,
    /// Energy of a round at the rotors' shafts [J].
    pub round_j: f64,
    /// What a round tells.
    information: Information,
}

/// So many rounds of each manoeuvre.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recipe {
    /// Rounds of each trial.
    pub rounds: Vec<usize>,
    /// Length of all [s].
    pub length_s: f64,
}

impl Rehearsal {
    /// Gravity and air of the site, for what looks at its logs.
    pub fn settings(&self) -> Settings {
        Settings { gravity_m_s2: self.site.gravity_m_s2, density_kg_m3: self.site.density_kg_m3 }
    }

    /// Sizes of a manoeuvre that bounds have room for, in the air of a seed.
    pub fn sizes(&self, kind: Kind, bounds: &Bounds, seed: u64) -> Sizes {
        let tilt_rad = ASKED * bounds.tilt_rad;
        let mut sizes = Sizes {
            tilt_rad: FIRST.tilt_rad.min(tilt_rad),
            acceleration_m_s2: FIRST.acceleration_m_s2.min(self.site.gravity_m_s2 * tilt_rad),
            speed_m_s: FIRST.speed_m_s.min(ASKED * bounds.speed_m_s),
            ..FIRST
        };
        for _ in 0..TRIES {
            let seen = self.fly(&kind.round(&sizes), seed).seen;
            let is_within = seen.tilt_rad <= GONE * bounds.tilt_rad
                && seen.speed_m_s <= GONE * bounds.speed_m_s
                && seen.below_m <= GONE * bounds.below_m;
            if is_within {
                break;
            }
            sizes = sizes.scaled(SMALLER);
        }
        sizes
    }

    /// Tries a manoeuvre, as large as bounds have room for.
    ///
    /// # Errors
    /// [`IdentifyError`] where its log says nothing.
    pub fn trial(&self, kind: Kind, bounds: &Bounds, seed: u64) -> Result<Trial, IdentifyError> {
        let sizes = self.sizes(kind, bounds, seed);
        let round = kind.round(&sizes);
        let round_s = length_s(&round);
        let rounds = (TRIED_S / round_s).ceil();
        let flown = self.fly(&round.repeat(rounds as usize), seed);
        let information =
            Information::of(&flown.log, &self.vehicle, &self.settings(), self.vehicle.latency_s)?;
        let information = information.and(1.0 / rounds, None);
        Ok(Trial {
            kind,
            sizes,
            round_s,
            seen: flown.seen,
            round_j: flown.seen.energy_j / rounds,
            information,
        })
    }

    /// Standard errors to be expected of steps that are flown once; a seed draws noise and turbulence.
    ///
    /// # Errors
    /// [`IdentifyError`] where a log says nothing.
    pub fn expected(&self, steps: &[Step], seed: u64) -> Result<[f64; PARAMETERS], IdentifyError> {
        let log = self.fly(steps, seed).log;
        Ok(Information::of(&log, &self.vehicle, &self.settings(), self.vehicle.latency_s)?.errors())
    }
}

impl Recipe {
    /// The recipe for wanted errors, and what is to be expected of it when it is flown as a whole: the root
    /// mean square over the rehearsals whose standard errors `fly` gives, since one alone scatters by half.
    /// What single trials promised too well of a number is made up for by more of what tells that one.
    ///
    /// # Errors
    /// Those of `fly`.
    pub fn flown<E>(
        trials: &[Trial],
        wanted: &Wanted,
        bounds: &Bounds,
        mut fly: impl FnMut(&[Step]) -> Result<Vec<[f64; PARAMETERS]>, E>,
    ) -> Result<(Self, [f64; PARAMETERS]), E> {
        let mut fly = |recipe: &Self| -> Result<[f64; PARAMETERS], E> {
            let each = fly(&recipe.steps(trials))?;
            let mean = |i: usize| each.iter().map(|one| one[i] * one[i]).sum::<f64>() / each.len() as f64;
            Ok(std::array::from_fn(|i| mean(i).sqrt()))
        };
        let (mut goal, mut recipe) = (*wanted, Self::of(trials, wanted, bounds));
        let mut expected = fly(&recipe)?;
        for _ in 0..REVISED {
            let added = recipe.errors(trials);
            for parameter in missed(&expected, wanted) {
                let i = parameter as usize;
                goal[i] *= (added[i] / expected[i] * wanted[i] / goal[i]).min(1.0) * ROOM;
            }
            let revised = Self::of(trials, &goal, bounds);
            if revised == recipe {
                break;
            }
            expected = fly(&revised)?;
            recipe = revised;
        }
        Ok((recipe, expected))
    }

    /// The rounds that bring the errors below those that are wanted soonest, within bounds; where they do
    /// not suffice, those that come nearest.
    pub fn of(trials: &[Trial], wanted: &Wanted, bounds: &Bounds) -> Self {
        let mut recipe = Self { rounds: vec![0; trials.len()], length_s: 0.0 };
        let (mut missing, mut score) = (f64::INFINITY, MOST);
        while missing > 0.0 || recipe.length_s < LEAST_S {
            let better = (0..trials.len()).filter_map(|i| {
                let mut more = recipe.clone();
                more.rounds[i] += 1;
                more.length_s += trials[i].round_s;
                let rounds = more.rounds.iter().zip(trials);
                let energy_j: f64 = rounds.map(|(rounds, trial)| *rounds as f64 * trial.round_j).sum();
                let is_within = more.length_s <= bounds.length_s && energy_j <= bounds.energy_j;
                is_within.then(|| {
                    let (left, all) = missing_of(&more.errors(trials), wanted);
                    let then = left + BEYOND * all;
                    ((score - then) / trials[i].round_s, left, then, more)
                })
            });
            let Some((gain, left, then, more)) = better.max_by(|a, b| a.0.total_cmp(&b.0)) else { break };
            if !(gain > LEAST_GAIN) && recipe.length_s >= LEAST_S {
                break;
            }
            (missing, score, recipe) = (left, then, more);
        }
        recipe
    }

    /// Standard errors to be expected, from what the trials told.
    pub fn errors(&self, trials: &[Trial]) -> [f64; PARAMETERS] {
        let flown = self.rounds.iter().zip(trials).filter(|(rounds, _)| **rounds > 0);
        let sum = flown.fold(None, |sum, (rounds, trial)| Some(trial.information.and(*rounds as f64, sum)));
        sum.map_or([f64::INFINITY; PARAMETERS], |information| information.errors())
    }

    /// Standard errors to be expected of one manoeuvre alone that is flown as long.
    pub fn errors_alone(&self, trial: &Trial) -> [f64; PARAMETERS] {
        trial.information.and(self.length_s / trial.round_s, None).errors()
    }

    /// All steps, manoeuvre by manoeuvre.
    pub fn steps(&self, trials: &[Trial]) -> Vec<Step> {
        let of = |(rounds, trial): (&usize, &Trial)| trial.kind.round(&trial.sizes).repeat(*rounds);
        self.rounds.iter().zip(trials).flat_map(of).collect()
    }
}

/// How far errors are above those that are wanted, as a sum of logarithms, and the sum of all, also of those
/// that are below; numbers that a vehicle has not are not missed.
fn missing_of(errors: &[f64; PARAMETERS], wanted: &Wanted) -> (f64, f64) {
    let over = errors.iter().zip(wanted).filter(|(error, _)| !error.is_nan());
    let over = over.map(|(error, wanted)| crate::math::ln(error / wanted).min(MOST));
    (over.clone().map(|x| x.max(0.0)).sum(), over.sum())
}

/// Parameters whose expected errors are above those that are wanted.
pub fn missed(errors: &[f64; PARAMETERS], wanted: &Wanted) -> Vec<Parameter> {
    let above = |parameter: &Parameter| errors[*parameter as usize] > wanted[*parameter as usize];
    Parameter::ALL.into_iter().filter(above).collect()
}
