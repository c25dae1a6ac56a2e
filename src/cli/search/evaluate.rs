//! `samara evaluate`: judges candidates that `samara design --ask` or `samara tune --ask` asks about.

use std::path::{Path, PathBuf};

use anyhow::Context as _;
use clap::{Args, CommandFactory as _, FromArgMatches as _, Parser};

use super::{Part, SearchArgs};
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::args::{ParentArgs, whole};
use crate::cli::design::{self, DesignArgs};
use crate::cli::help::with_negative_values;
use crate::cli::tune::{self, TuneArgs};
use samara::config::load_asked;
use samara::study::cut::Cut;

/// `samara evaluate`.
#[derive(Args, Debug)]
pub struct EvaluateArgs {
    /// What a search asks about: the file candidates.json in its folder.
    #[arg(value_name = "CANDIDATES")]
    pub candidates: PathBuf,
    /// Judge part I of N alone, I from 0 to N-1 [default: 0/1].
    #[arg(long, value_name = "I/N", value_parser = str::parse::<Cut>)]
    pub shard: Option<Cut>,
    /// Folder below which judged/ gets the judgements [default: that of CANDIDATES].
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

/// The searches that ask.
#[derive(Debug, Parser)]
#[command(no_binary_name = true)]
enum Search {
    /// `samara design`.
    Design(DesignArgs),
    /// `samara tune`.
    Tune(TuneArgs),
}

/// Begins the search that asks as it was begun, up to these candidates, and judges those of the part.
pub fn run(args: &EvaluateArgs) -> Result<Answer, Failure> {
    let asked = load_asked(&args.candidates).bad_input()?;
    let whose = |message: String| Failure::input(format!("{}: {message}", args.candidates.display()));
    let search = with_negative_values(Search::command())
        .try_get_matches_from(asked.arguments)
        .and_then(|typed| Search::from_arg_matches(&typed))
        .map_err(|error| whose(format!("asked.arguments: {}", error.to_string().trim_end())))?;
    let absolute =
        |path: &Path| std::path::absolute(path).with_context(|| path.display().to_string()).bad_input();
    let candidates = absolute(&args.candidates)?;
    let beside = candidates.parent().map(Path::to_owned).unwrap_or_default();
    let out = args.out.as_deref().map_or(Ok(beside), absolute)?;
    let cut = args.shard.unwrap_or(Cut::WHOLE);
    let part = Part { candidates, asked: asked.candidates, cut, check: args.check };
    let how = SearchArgs { parent: args.parent.clone(), part: Some(part), ..SearchArgs::default() };
    // Where the search runs on another machine: names mean the built-in missions, as they do there.
    let folder = Path::new(&asked.folder);
    if folder.is_dir() {
        std::env::set_current_dir(folder).with_context(|| folder.display().to_string()).bad_input()?;
    }
    match search {
        Search::Design(mut search) => {
            (search.mission.out, search.search, search.threads) = (Some(out), how, args.threads);
            design::run(&search)
        }
        Search::Tune(mut search) => {
            (search.mission.out, search.search, search.threads) = (Some(out), how, args.threads);
            tune::run(&search)
        }
    }
}
