//! `samara verify`.

use clap::Args;

use super::answer::{Answer, BadInput as _, Failure};
use super::terminal::print;
use samara::config::Mission;
use samara::report::{verify_json, verify_text};
use samara::verify::{CheckGroup, verify};

/// `samara verify`.
#[derive(Args, Debug)]
pub struct VerifyArgs {
    /// Print one JSON object on stdout instead of a table.
    #[arg(long)]
    pub json: bool,
}

/// Makes every check.
pub fn run(args: &VerifyArgs) -> Result<Answer, Failure> {
    let (lander, quadrotor) =
        (Mission::shipped("titan_paper").bad_input()?, Mission::shipped("x500_drop").bad_input()?);
    let groups = verify(&lander.plan_problem(), &quadrotor.plan_problem()).bad_input()?;
    print(&if args.json { verify_json(&groups) } else { verify_text(&groups) })?;
    Ok(Answer::from(groups.iter().all(CheckGroup::holds)))
}
