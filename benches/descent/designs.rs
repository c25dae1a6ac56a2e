//! What gradients would gain a search of designs: descent along them against the evolution strategy, on the
//! same designs' problem and from the same starts.
//!
//! ```sh
//! cargo run --release --example descent -- titan_drop 800   # a mission; the designs that each may judge
//! ```
//!
//! The descent is BFGS within the ranges, projected. Its gradient is made of differences, one design for each
//! number that is searched. It is counted twice: as that many designs, and as one, as if it came for nothing
//! beside the design itself - which is less than any derivative of the flights costs. Choices stay those of
//! the best start. Flights are the search's own; each design flies all of them.
#![expect(clippy::print_stdout, reason = "it is the result")]

use std::process::ExitCode;

use samara::config::Mission;
use samara::design::space::{DIMENSIONS, Place};
use samara::design::{DesignJudge, DesignSearch, DesignSpace};
use samara::host::Threads;
use samara::study::designing::{design_judge, design_search};
use samara::tune::CandidateSearch as _;

/// Step of the differences, as a share of a number's range.
const STEP: f64 = 1e-4;
/// Longest step of the descent along any number, as a share of its range: the strategy's first spread twice.
const REACH: f64 = 0.16;
/// The descent ends where no step of a line search gains this much.
const GAIN: f64 = 1e-6;

fn main() -> ExitCode {
    let mut words = std::env::args().skip(1);
    let name = words.next().unwrap_or_else(|| "titan_drop".to_owned());
    let budget = words.next().and_then(|n| n.parse().ok()).unwrap_or(800);
    let mission = match samara::config::load_mission(std::path::Path::new(&name)).or(Mission::shipped(&name))
    {
        Ok(mission) => mission,
        Err(error) => {
            println!("{error}");
            return ExitCode::from(2);
        }
    };
    let threads = match Threads::new(None) {
        Ok(threads) => threads,
        Err(error) => {
            println!("{error}");
            return ExitCode::FAILURE;
        }
    };
    let judge = design_judge(&mission);
    let settings = design_search(&mission, budget);
    let mut search = DesignSearch::new(settings.clone());
    let mut strategy = Vec::new();
    while let Some(designs) = search.candidates() {
        // No ceiling: who gives up early flies less, but that is not what is compared.
        let judged: Vec<_> = threads.each(designs, |design| judge.judge(design, f64::INFINITY));
        search.update(&judged);
        strategy.extend(search.best().map(|best| (search.tried().len(), best.cost)));
    }
    let starts = settings.space.starts(&settings.own);
    let problem =
        Descended { judge: &judge, space: &settings.space, threads: &threads, choice: [0.0; DIMENSIONS] };
    let cost = |place: &Place| problem.cost(place);
    let places: Vec<Place> = starts.iter().map(|design| settings.space.place(design)).collect();
    let costs: Vec<f64> = threads.each(&places, cost);
    let Some((best, least)) = places.iter().zip(costs).min_by(|a, b| a.1.total_cmp(&b.1)) else {
        return ExitCode::FAILURE;
    };
    let descended = Descended { choice: *best, ..problem }.from(best, least, budget);
    println!("{name}: least cost after so many designs, {} flights each", judge.count());
    println!("designs  strategy  descent by differences  descent, gradients for nothing");
    let reached = |curve: &[(usize, f64)], n: usize| {
        curve.iter().filter(|(used, _)| *used <= n).map(|(_, cost)| *cost).fold(f64::INFINITY, f64::min)
    };
    let by_differences: Vec<(usize, f64)> =
        descended.iter().map(|d| (d.differences + starts.len(), d.cost)).collect();
    let for_nothing: Vec<(usize, f64)> = descended.iter().map(|d| (d.bare + starts.len(), d.cost)).collect();
    let mut n = 25;
    while n <= budget {
        println!(
            "{n:7}  {:8.4}  {:22.4}  {:30.4}",
            reached(&strategy, n),
            reached(&by_differences, n),
            reached(&for_nothing, n)
        );
        n *= 2;
    }
    ExitCode::SUCCESS
}

/// A state of the descent.
struct Reached {
    /// Designs judged, those of differences among them.
    differences: usize,
    /// Designs judged, were gradients for nothing.
    bare: usize,
    cost: f64,
}

/// The numbers of a design, its choices held.
struct Descended<'a> {
    judge: &'a DesignJudge<'a>,
    space: &'a DesignSpace,
    threads: &'a Threads,
    choice: Place,
}

impl Descended<'_> {
    fn cost(&self, place: &Place) -> f64 {
        let (_, bounds) = self.judge.objective();
        self.judge.judge(&self.space.design(place), f64::INFINITY).cost(&bounds)
    }

    /// Coordinates that change a design when they move a little: numbers that are searched, no choices.
    fn numbers(&self) -> Vec<usize> {
        let moved = |k: usize| {
            let mut place = self.choice;
            place[k] = inside(place[k] + STEP);
            self.space.design(&place) != self.space.design(&self.choice)
        };
        (0..DIMENSIONS).filter(|&k| moved(k)).collect()
    }

    fn gradient(&self, numbers: &[usize], place: &Place, cost: f64) -> Vec<f64> {
        let slope = |&k: &usize| {
            let step = if place[k] + STEP <= 1.0 { STEP } else { -STEP };
            let mut near = *place;
            near[k] += step;
            (self.cost(&near) - cost) / step
        };
        self.threads.each(numbers, slope)
    }

    fn from(&self, start: &Place, cost: f64, budget: usize) -> Vec<Reached> {
        let numbers = self.numbers();
        let n = numbers.len();
        let (mut place, mut cost) = (*start, cost);
        let (mut differences, mut bare) = (0, 0);
        let mut reached = vec![Reached { differences, bare, cost }];
        let mut slope = self.gradient(&numbers, &place, cost);
        let mut inverse = identity(n);
        let mut fresh = true;
        while bare < budget {
            differences += n;
            let mut way: Vec<f64> =
                (0..n).map(|r| -(0..n).map(|c| inverse[r][c] * slope[c]).sum::<f64>()).collect();
            if dot(&way, &slope) >= 0.0 {
                way = slope.iter().map(|g| -g).collect();
                inverse = identity(n);
            }
            let longest = way.iter().fold(0.0f64, |most, w| most.max(w.abs()));
            if !(longest > 0.0) {
                break;
            }
            // Full steps of Newton's, but none beyond the reach; then halves.
            let mut share = if fresh { REACH / longest } else { (REACH / longest).min(1.0) };
            let mut next = None;
            for _ in 0..10 {
                let mut to = place;
                numbers.iter().zip(&way).for_each(|(&k, w)| to[k] = inside(place[k] + share * w));
                let c = self.cost(&to);
                (differences, bare) = (differences + 1, bare + 1);
                if c < cost - GAIN {
                    next = Some((to, c));
                    break;
                }
                share *= 0.5;
            }
            let Some((to, c)) = next else {
                if fresh {
                    break;
                }
                (inverse, fresh) = (identity(n), true);
                continue;
            };
            let after = self.gradient(&numbers, &to, c);
            let step: Vec<f64> = numbers.iter().map(|&k| to[k] - place[k]).collect();
            let change: Vec<f64> = after.iter().zip(&slope).map(|(a, b)| a - b).collect();
            update(&mut inverse, &step, &change, fresh);
            (place, cost, slope, fresh) = (to, c, after, false);
            reached.push(Reached { differences, bare, cost });
        }
        reached
    }
}

fn inside(s: f64) -> f64 {
    s.clamp(0.0, 1.0)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn identity(n: usize) -> Vec<Vec<f64>> {
    (0..n).map(|r| (0..n).map(|c| f64::from(u8::from(r == c))).collect()).collect()
}

/// BFGS's update of the inverse of the Hessian; scaled first when it is fresh.
fn update(inverse: &mut [Vec<f64>], step: &[f64], change: &[f64], fresh: bool) {
    let n = step.len();
    let along = dot(step, change);
    if along <= 1e-12 {
        return;
    }
    if fresh {
        let scale = along / dot(change, change);
        for (r, row) in inverse.iter_mut().enumerate() {
            row.iter_mut().enumerate().for_each(|(c, h)| *h = if r == c { scale } else { 0.0 });
        }
    }
    let by: Vec<f64> = inverse.iter().map(|row| dot(row, change)).collect();
    let curve = (1.0 + dot(change, &by) / along) / along;
    for r in 0..n {
        for c in 0..n {
            inverse[r][c] += curve * step[r] * step[c] - (by[r] * step[c] + step[r] * by[c]) / along;
        }
    }
}
