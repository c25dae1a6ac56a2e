//! Searches gains for plans that are renewed: `cargo run --release --example replan_gains -- titan_drop 1 400
//! titan`, with the mission, the cadence, the number of candidates and the gains to begin at.
//!
//! A candidate flies 12 drops of the mission with the plan renewed at the rate, and four along one plan, by
//! which it flies on where nothing is renewed. Its cost is half of the mean of J_TPF and half of that of the
//! two worst of the first, 0.3 times the mean of the second, 0.3 times the share of each that is never steady,
//! and 0.002 for each second until steady flight. The drops are of numbers from a million on: campaigns from 0
//! on are of fresh ones. Where a candidate is better than all before, its cost and its gains are printed.
#![expect(clippy::print_stdout, reason = "a program of its own")]

use std::error::Error;
use std::ops::ControlFlow;
use std::sync::Arc;

use samara::config::{Mission, gains_json};
use samara::control::Gains;
use samara::plan::{Plan, SolverOptions};
use samara::replan::Cadence;
use samara::study::replan::{ReplanDrop, ReplanFlights, ReplanRow};
use samara::tune::Optimiser;
use samara::tune::cma_es::{CmaEs, CmaSettings, Scale};

/// Drops of a candidate with renewed plans, and along one plan.
const DROPS: [u64; 2] = [12, 4];
/// Number of the first drop.
const FROM: u64 = 1_000_000;
/// Time until steady flight of a drop that never is [s].
const NEVER_S: f64 = 40.0;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let mut next = |usual: &str| arguments.next().unwrap_or_else(|| usual.to_owned());
    let (name, cadence, candidates) = (next("titan_drop"), next("1").parse()?, next("400").parse::<usize>()?);
    let mut mission = Mission::shipped(&name)?;
    mission.use_gains(&next("titan"))?;
    let mission = Arc::new(mission);
    let plan = mission.solve(&SolverOptions::default(), &mut |_| ControlFlow::Continue(()))?;
    search(&mission, &plan, cadence, candidates)
}

fn search(
    mission: &Arc<Mission>,
    plan: &Plan,
    cadence: Cadence,
    candidates: usize,
) -> Result<(), Box<dyn Error>> {
    let own = mission.control.gains;
    let settings = CmaSettings { samples: 8, sigma: 0.1, scale: Scale::Logarithmic, tolerance: 1e-4 };
    let mut strategy = CmaEs::new(RANGES, own.as_longitudinal(), settings, 1);
    let (mut best, mut count) = (f64::INFINITY, 0);
    while count < candidates && !strategy.has_converged() {
        let mut costs = Vec::new();
        for candidate in strategy.candidates() {
            let gains = Gains { k_ppsi: own.k_ppsi, k_pr: own.k_pr, ..Gains::longitudinal(*candidate) };
            let cost = cost(mission, plan, cadence, &gains)?;
            count += 1;
            if cost < best {
                best = cost;
                println!("candidate {count}: {cost:.4}\n{}", gains_json("found", "", &gains));
            }
            costs.push(cost);
        }
        strategy.update(&costs);
    }
    Ok(())
}

/// Ranges that are searched: k_pq, k_iq, k_ptheta, k_pvz, k_ivz, k_pvx, k_ivx.
const RANGES: [(f64, f64); 7] =
    [(0.3, 12.0), (1e-4, 3.0), (0.2, 8.0), (0.2, 8.0), (1e-4, 2.0), (0.2, 5.0), (1e-4, 1.0)];

fn cost(mission: &Arc<Mission>, plan: &Plan, cadence: Cadence, gains: &Gains) -> Result<f64, Box<dyn Error>> {
    let flown =
        |cadence: Option<Cadence>, count: u64, every: u64| -> Result<Vec<ReplanDrop>, Box<dyn Error>> {
            let row = ReplanRow {
                as_without: false,
                cadence,
                feed_forward: true,
                gains_name: String::new(),
                gains: *gains,
            };
            let flights = ReplanFlights::new(mission, plan, &row)?;
            let fly = |first: u64| {
                let flights = &flights;
                move || (first..count).step_by(2).map(|k| flights.fly(FROM + every * k)).collect::<Vec<_>>()
            };
            Ok(std::thread::scope(|scope| {
                let other = scope.spawn(fly(1));
                let mut drops = fly(0)();
                drops.extend(other.join().unwrap_or_default());
                drops
            }))
        };
    let mean = |drops: &[ReplanDrop], of: fn(&ReplanDrop) -> f64| {
        drops.iter().map(of).sum::<f64>() / drops.len().max(1) as f64
    };
    let (renewed, once) = (flown(Some(cadence), DROPS[0], 1)?, flown(None, DROPS[1], 3)?);
    let mut sorted: Vec<f64> = renewed.iter().map(j_tpf).collect();
    sorted.sort_by(f64::total_cmp);
    let worst = sorted.iter().rev().take(2).sum::<f64>() / 2.0;
    let unsteady = |drop: &ReplanDrop| f64::from(u8::from(drop.drop.outcome.steady_after_s.is_none()));
    let late_s = |drop: &ReplanDrop| drop.drop.outcome.steady_after_s.unwrap_or(NEVER_S);
    Ok(0.5 * mean(&renewed, j_tpf)
        + 0.5 * worst
        + 0.3 * mean(&once, j_tpf)
        + 0.3 * (mean(&renewed, unsteady) + mean(&once, unsteady))
        + 0.002 * mean(&renewed, late_s))
}

/// J_TPF, at most 10.
fn j_tpf(drop: &ReplanDrop) -> f64 {
    // What is no number is lost, too.
    if drop.drop.outcome.j_tpf < 10.0 { drop.drop.outcome.j_tpf } else { 10.0 }
}
