//! The kinds of studies as verbs of the command line, each by its own table.

use clap::error::ErrorKind;
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};

use super::args::{StudyArgs, WireArgs};
use super::asked::StudyOf;
use crate::cli::args::PageArgs;
use crate::cli::fidelity::FidelityArgs;
use samara::study::kind::Kind;
use samara::study::kinds::{KINDS, kind};
use samara::study::settings::{Setting, Values};

/// The study whose drops an autopilot may fly.
const BY_AUTOPILOTS: &str = "replan";

/// The study that flies nothing.
const FIDELITY: &str = "fidelity";

/// `samara study`.
pub struct StudyVerbArgs {
    /// What is asked.
    pub kind: Typed,
}

/// What was asked.
pub enum Typed {
    /// A study of flights.
    Study(Box<StudyOf>),
    /// Campaigns of several runs, held against each other.
    Fidelity(Box<FidelityArgs>),
}

impl std::fmt::Debug for StudyVerbArgs {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let name = match &self.kind {
            Typed::Study(study) => study.kind.about().name,
            Typed::Fidelity(_) => FIDELITY,
        };
        write!(f, "study {name}")
    }
}

impl Args for StudyVerbArgs {
    fn augment_args(command: Command) -> Command {
        let about = "What campaigns of the same trials, flown in several ways, say together: samara fidelity";
        let fidelity = FidelityArgs::augment_args(Command::new(FIDELITY))
            .about(about)
            .long_about(about)
            .after_long_help(include_str!("../help/fidelity.txt"));
        command
            .subcommand_required(true)
            .arg_required_else_help(true)
            .subcommands(KINDS.map(verb_of))
            .subcommand(fidelity)
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

/// A kind as a verb.
fn verb_of(kind: &dyn Kind) -> Command {
    let about = kind.about();
    let name = about.name.replace('_', "-");
    let mut verb = Command::new(name).args(about.settings.iter().map(option));
    // Where there is none, the program says why.
    let only = Arg::new("only")
        .long("only")
        .value_name(about.alone.unwrap_or("NAME"))
        .help("Fly one flight of the study again, by what names it")
        .conflicts_with("resume")
        .hide(about.alone.is_err());
    verb = verb.arg(only);
    if about.alone.is_ok() {
        verb = PageArgs::augment_args(verb);
    }
    if about.name == BY_AUTOPILOTS {
        verb = WireArgs::augment_args(verb);
    }
    StudyArgs::augment_args(verb).about(about.title).long_about(about.title).after_long_help(about.help)
}

/// A setting as an option.
fn option(setting: &'static Setting) -> Arg {
    let about: String = setting.about.lines().map(|line| line.trim_start().to_owned() + "\n").collect();
    let (first, more) = about.split_once("\n\n").unwrap_or((&about, ""));
    let flowed = |text: &str| text.trim().replace('\n', " ");
    let short = flowed(first).trim_end_matches('.').to_owned();
    let long = if more.is_empty() { short.clone() } else { format!("{short}\n\n{}", flowed(more)) };
    let arg = Arg::new(setting.name).long(setting.name.replace('_', "-")).help(short).long_help(long);
    if setting.value.is_empty() {
        return arg.action(ArgAction::SetTrue);
    }
    arg.value_name(setting.value).default_value(setting.usual).value_parser(setting.read)
}

impl FromArgMatches for StudyVerbArgs {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        // The parser demands a kind.
        let (name, typed) = matches.subcommand().unwrap_or(("", matches));
        if name == FIDELITY {
            return FidelityArgs::from_arg_matches(typed)
                .map(|args| Self { kind: Typed::Fidelity(Box::new(args)) });
        }
        let kind = kind(name).map_err(|e| clap::Error::raw(ErrorKind::InvalidSubcommand, e))?;
        let about = kind.about();
        let mut values = Values::usual(about.settings);
        for setting in about.settings {
            let text = match setting.value {
                "" => typed.get_flag(setting.name).to_string(),
                _ => typed.get_one::<String>(setting.name).cloned().unwrap_or_default(),
            };
            let put = values.put(about.settings, setting.name, &text);
            put.map_err(|e| clap::Error::raw(ErrorKind::ValueValidation, e))?;
        }
        let alone = about.alone.is_ok();
        let study = StudyOf {
            kind,
            args: StudyArgs::from_arg_matches(typed)?,
            values,
            only: typed.get_one::<String>("only").cloned(),
            page: if alone { PageArgs::from_arg_matches(typed)? } else { PageArgs::NONE },
            wire: (about.name == BY_AUTOPILOTS).then(|| WireArgs::from_arg_matches(typed)).transpose()?,
        };
        Ok(Self { kind: Typed::Study(Box::new(study)) })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}
