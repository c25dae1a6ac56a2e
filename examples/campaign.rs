//! A campaign in a loop: how the worst J_TPF of random releases grows with the swing under the canopy.
//!
//! ```sh
//! cargo run --release --example campaign
//! ```
#![expect(clippy::print_stdout, reason = "an example shows what came out")]

use std::ops::ControlFlow;

use samara::assess::{RandomRelease, StudyEntry, StudyReference, Tally};
use samara::config::load_mission;
use samara::control::{Airframe, Cascade};
use samara::plan::{Guess, SolverOptions, plan};

/// Flies `trials` random releases for each swing [deg, 1 sigma], and prints a row for each.
pub fn campaign(trials: u64, swings_deg: &[f64]) -> Result<Vec<Tally>, Box<dyn std::error::Error>> {
    let mission = load_mission("mission/titan_drop.json".as_ref())?;
    let plan = plan(&mission.plan_problem(), &Guess::StraightLine, &SolverOptions::default(), &mut |_| {
        ControlFlow::Continue(())
    })?;
    let airframe = Airframe::new(&mission.vehicle, &mission.site.environment)?;
    let study = mission.safety_study(&plan.trajectory);
    let entry = StudyEntry {
        name: "ours",
        gains_name: mission.control.gains_name.clone(),
        controller: Box::new(Cascade::new(airframe, mission.control.gains, mission.control.limits)),
        reference: StudyReference::Optimal,
    };
    println!("swing (1 sigma)   mean J_TPF    worst   safe of {trials}");
    let mut rows = Vec::new();
    for sigma_deg in swings_deg {
        let mut releases = mission.releases();
        releases.amplitude_sigma_rad = sigma_deg.to_radians();
        let drawn: Vec<RandomRelease> = (0..trials).map(|k| releases.draw(mission.seed, k)).collect();
        let mut tally = Tally::default();
        for outcome in study.fly_releases(&entry, &drawn) {
            tally.push(outcome.j_tpf, 1.0);
        }
        let j = &tally.j_tpf;
        let safe = trials - tally.safe.misses();
        println!("{sigma_deg:11.0} deg {:12.4} {:8.4} {safe:6}", j.mean(), j.max());
        rows.push(tally);
    }
    Ok(rows)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    campaign(400, &[1.0, 3.0, 6.0, 9.0])?;
    Ok(())
}
