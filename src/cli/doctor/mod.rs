//! `samara doctor`: what there is to know of a machine on which something does not work.
//!
//! | file | holds |
//! |---|---|
//! | `look` | what is looked at: the program, ports, folders, PX4 |
//! | `python` | what Python has, asked of it |
//! | `finding` | what was found, and what to do |
//! | this one | text and JSON of all |

mod finding;
mod look;
mod python;

use std::path::PathBuf;

use clap::Args;
use serde_json::{Value, json};

use super::answer::{Answer, Failure};
use super::args::instance;
use super::terminal::print;
use finding::Finding;
use samara::printable::printable;
use samara::report::json::VERSION;

/// Variable of the environment that names a build folder of PX4.
const PX4: &str = "SAMARA_PX4";

/// `samara doctor`.
#[derive(Args, Debug)]
pub struct DoctorArgs {
    /// A build folder of PX4's simulation [default: that of SAMARA_PX4].
    #[arg(long, value_name = "DIR")]
    pub px4: Option<PathBuf>,
    /// Number of the vehicle whose ports are looked at.
    #[arg(long, value_name = "0..9", default_value_t = 0, value_parser = instance)]
    pub instance: u16,
    /// Print one JSON object on stdout instead of text.
    #[arg(long)]
    pub json: bool,
}

/// Looks, and says what to do. No is something needed that is not as it should be.
pub fn run(args: &DoctorArgs) -> Result<Answer, Failure> {
    let named = || std::env::var_os(PX4).filter(|folder| !folder.is_empty()).map(PathBuf::from);
    let px4 = args.px4.clone().or_else(named);
    let mut findings = look::program();
    findings.extend(look::ports(args.instance)?);
    findings.extend([look::out(), look::browser()]);
    findings.extend(python::python());
    findings.extend(look::px4(px4.as_deref(), args.instance));
    let ok = findings.iter().all(Finding::is_no_trouble);
    print(&if args.json {
        let checks: Vec<Value> = findings.iter().map(Finding::object).collect();
        format!("{:#}\n", json!({ "version": VERSION, "ok": ok, "checks": checks }))
    } else {
        text(&findings)
    })?;
    Ok(Answer::from(ok))
}

/// A line for each finding, and one below it where there is something to do.
fn text(findings: &[Finding]) -> String {
    let width = findings.iter().map(|finding| finding.of.chars().count()).max().unwrap_or(0);
    let line = |Finding { of, state, found, advice }: &Finding| {
        let line = format!("{:2}  {of:width$}  {}\n", state.word(), printable(found));
        let advice = advice.as_ref().map(|advice| format!("    {:width$}  {}\n", "", printable(advice)));
        line + &advice.unwrap_or_default()
    };
    findings.iter().map(line).collect()
}
