//! `samara verify`.

use std::path::Path;

use anyhow::Context;
use clap::Args;

use super::answer::{Answer, BadInput as _, Failure};
use super::terminal::print;
use samara::config::{Mission, load_mission};
use samara::report::{verify_json, verify_text};
use samara::verify::{Group, verify};

/// The help of `samara verify`.
pub const VERIFY_HELP: &str = "\
Holds the code that flies and plans against what is known from elsewhere: NASA's check cases 2, 3 and 4 for six-degree-of-freedom
simulations (NASA/TM-2015-218675) and closed forms - free fall, precession, terminal velocity, pendulum, momentum theory of the
rotor, trim, motors, orders of convergence. Each error stands beside its bar. The vehicles are those of mission/titan_drop.json
(the lander) and mission/x500_drop.json (the quadrotor). Nothing is written.

JSON (--json): version, count, failed, checks (group, what, unit, computed, exact, error, bar, holds, source). Of a series the
value with the largest error is told. All numbers of a check are in its unit.

Exit code 1 when an error exceeds its bar.

Examples:
  samara verify
  samara verify --json > verify.json";

/// `samara verify`.
#[derive(Args, Debug)]
pub struct VerifyArgs {
    /// Print one JSON object on stdout instead of a table.
    #[arg(long)]
    pub json: bool,
}

/// Makes every check.
pub fn run(args: &VerifyArgs) -> Result<Answer, Failure> {
    let (lander, quadrotor) = (shipped("mission/titan_drop.json")?, shipped("mission/x500_drop.json")?);
    let groups = verify(&lander.plan_problem(), &quadrotor.plan_problem()).bad_input()?;
    print(&if args.json { verify_json(&groups) } else { verify_text(&groups) })?;
    Ok(Answer::from(groups.iter().all(Group::holds)))
}

fn shipped(path: &str) -> Result<Mission, Failure> {
    load_mission(Path::new(path))
        .context("the vehicles that are checked are the project's own: run this in its folder")
        .bad_input()
}
