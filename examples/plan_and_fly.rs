//! Plans a mission, flies the plan without a wire, and prints the verdict.
//!
//! ```sh
//! cargo run --release --example plan_and_fly [MISSION]
//! ```
#![expect(clippy::print_stdout, reason = "an example shows what came out")]

use std::ops::ControlFlow;

use samara::assess::{Verdict, VerdictBuilder};
use samara::config::load_mission;
use samara::control::{Airframe, Cascade};
use samara::plan::{Guess, SolverOptions, plan};
use samara::report::{plan_text, verdict_text};
use samara::sim::{FlightPlan, Reference, fly};

/// Plans and flies the mission of a file.
pub fn plan_and_fly(path: &str) -> Result<Verdict, Box<dyn std::error::Error>> {
    let mission = load_mission(path.as_ref())?;

    // The optimal trajectory from the release to the target velocity.
    let plan = plan(&mission.plan_problem(), &Guess::StraightLine, &SolverOptions::default(), &mut |_| {
        ControlFlow::Continue(())
    })?;
    println!("{}", plan_text(&mission, &plan, None));

    // The paper's cascade follows it, from the canopy to the end of the mission, at 250 Hz.
    let airframe = Airframe::new(&mission.vehicle, &mission.site.environment)?;
    let mut cascade = Cascade::new(airframe, mission.control.gains, mission.control.limits);
    let reference = Reference::Plan {
        trajectory: &plan.trajectory,
        then_v_ned: Some(mission.target_v_ned),
        feed_forward: mission.control.feed_forward,
    };
    let mut sim = mission.simulation();
    sim.schedule_release(mission.release.hang_s);
    let mut verdict = VerdictBuilder::judging(mission.limits, mission.target_v_ned).along(&plan.trajectory);
    let _ =
        fly(&mut sim, &mut cascade, &FlightPlan::new(reference, 0.004, mission.duration_s), &mut |sample| {
            verdict.observe(sample);
            ControlFlow::Continue(())
        });
    let verdict = verdict.finish().ok_or("the vehicle was never released")?;
    println!("{}", verdict_text(&verdict, &mission.limits, verdict.outcome.steady_after_s.is_none()));
    Ok(verdict)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1);
    plan_and_fly(path.as_deref().unwrap_or("mission/titan_drop.json"))?;
    Ok(())
}
