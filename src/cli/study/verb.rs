//! The kinds of studies as verbs of the command line, each by its own table.

use clap::error::ErrorKind;
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};

use super::args::{StudyArgs, WireArgs};
use super::asked::StudyOf;
use super::options::{options, values};
use crate::cli::args::PageArgs;
use samara::study::feature::Feature;
use samara::study::kind::Kind;
use samara::study::kinds::{KINDS, kind};

/// The study whose drops an autopilot may fly.
const BY_AUTOPILOTS: &str = "replan";

/// `samara study`.
pub struct StudyVerbArgs {
    /// What is asked.
    pub study: StudyOf,
}

impl std::fmt::Debug for StudyVerbArgs {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "study {}", self.study.kind.about().name)
    }
}

impl Args for StudyVerbArgs {
    fn augment_args(command: Command) -> Command {
        command.subcommand_required(true).arg_required_else_help(true).subcommands(KINDS.map(verb_of))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

/// A kind as a verb.
fn verb_of(kind: &dyn Kind) -> Command {
    let about = kind.about();
    let verb = with_options(kind, Command::new(about.name.replace('_', "-")));
    verb.about(about.title).long_about(about.title).after_long_help(about.help)
}

/// A command with the options of a kind.
pub fn with_options(kind: &dyn Kind, command: Command) -> Command {
    let about = kind.about();
    let mut verb = command.args(options(about.settings));
    // Where there is none, the program says why.
    let only = Arg::new("only")
        .long("only")
        .value_name(about.alone.unwrap_or("NAME"))
        .help("Fly one flight of the study again, by what names it")
        .conflicts_with("resume")
        .hide(about.alone.is_err());
    let keep = Arg::new("keep")
        .long("keep")
        .action(ArgAction::SetTrue)
        .help("Keep the rows, from which --resume makes the results again")
        .hide_short_help(true)
        .hide(about.refusal(Feature::Keep).is_some());
    verb = verb.args([only, keep]);
    if about.alone.is_ok() {
        verb = PageArgs::augment_args(verb);
    }
    if about.name == BY_AUTOPILOTS {
        verb = WireArgs::augment_args(verb).mut_arg("autopilot", |wire| wire.conflicts_with("only"));
    }
    let verb = StudyArgs::augment_args(verb);
    // A clock is a whole run's: shards are flown by many.
    match about.settings.iter().find(|setting| setting.name == "time_limit") {
        Some(setting) if cfg!(feature = "shards") => {
            verb.mut_arg("shard", |shard| shard.conflicts_with(setting.name))
        }
        _ => verb,
    }
}

/// The study of a kind that was typed.
pub fn study_of(kind: &'static dyn Kind, typed: &ArgMatches) -> Result<StudyOf, clap::Error> {
    let about = kind.about();
    let alone = about.alone.is_ok();
    Ok(StudyOf {
        kind,
        args: StudyArgs::from_arg_matches(typed)?,
        values: values(about.settings, typed)?,
        only: typed.get_one::<String>("only").cloned(),
        keep: typed.get_flag("keep"),
        page: if alone { PageArgs::from_arg_matches(typed)? } else { PageArgs::NONE },
        wire: (about.name == BY_AUTOPILOTS).then(|| WireArgs::from_arg_matches(typed)).transpose()?,
    })
}

impl FromArgMatches for StudyVerbArgs {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        // The parser demands a kind.
        let (name, typed) = matches.subcommand().unwrap_or(("", matches));
        let kind = kind(name).map_err(|e| clap::Error::raw(ErrorKind::InvalidSubcommand, e))?;
        Ok(Self { study: study_of(kind, typed)? })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}
