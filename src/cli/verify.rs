//! `samara verify`.

use std::path::Path;

use anyhow::Context;
use clap::Args;

use super::answer::{Answer, BadInput as _, Failure};
use super::terminal::print;
use samara::config::{Mission, load_mission};
use samara::report::{verify_json, verify_text};
use samara::verify::{Group, verify};

/// `samara verify`.
#[derive(Args, Debug)]
pub struct VerifyArgs {
    /// Print one JSON object on stdout instead of a table.
    #[arg(long)]
    pub json: bool,
}

/// Makes every check.
pub fn run(args: &VerifyArgs) -> Result<Answer, Failure> {
    let (lander, quadrotor) = (shipped("mission/titan_paper.json")?, shipped("mission/x500_drop.json")?);
    let groups = verify(&lander.plan_problem(), &quadrotor.plan_problem()).bad_input()?;
    print(&if args.json { verify_json(&groups) } else { verify_text(&groups) })?;
    Ok(Answer::from(groups.iter().all(Group::holds)))
}

fn shipped(path: &str) -> Result<Mission, Failure> {
    load_mission(Path::new(path))
        .context("the vehicles that are checked are the project's own: run this in its folder")
        .bad_input()
}
