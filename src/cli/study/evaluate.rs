//! `samara evaluate`: the old spelling of a shard of a search, by the file that says what was asked.

use std::path::PathBuf;

use clap::Args;

use super::shards;
use crate::cli::answer::{Answer, Failure};
use crate::cli::args::{ParentArgs, whole};
use crate::cli::system::interrupt_flag;
use samara::study::cut::Cut;

/// `samara evaluate`.
#[derive(Args, Debug)]
pub struct EvaluateArgs {
    /// What a search asks about: the file shards/study.json in its folder.
    #[arg(value_name = "STUDY")]
    pub asked: PathBuf,
    /// Judge part I of N alone, I from 0 to N-1 [default: 0/1].
    #[arg(long, value_name = "I/N", value_parser = str::parse::<Cut>)]
    pub shard: Option<Cut>,
    /// Folder below which shards/ gets the rows [default: that of STUDY].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Threads [default: one for each core]. The result does not depend on it.
    #[arg(long, value_name = "N", value_parser = whole::<u16>(1..=256))]
    pub threads: Option<u16>,
    /// Only say whether the search would be the same here: exit code 0, or 2 with what differs.
    #[arg(long)]
    pub check: bool,
    /// Whose end is this process's end.
    #[command(flatten)]
    pub parent: ParentArgs,
}

/// Flies the part of what is asked.
pub fn run(args: &EvaluateArgs) -> Result<Answer, Failure> {
    let stop = interrupt_flag()?;
    args.parent.watch(&stop)?;
    let cut = (!args.check).then(|| args.shard.unwrap_or(Cut::WHOLE));
    shards::evaluate((&args.asked, args.out.as_deref()), cut, (args.threads, &stop))
}
