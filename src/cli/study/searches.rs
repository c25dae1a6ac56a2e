//! The searches as verbs of their own, `samara design` and `samara tune`: studies that others may judge step
//! by step (`--ask`, `samara evaluate`).

use clap::error::ErrorKind;
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};

use super::asked::StudyOf;
use super::options::option;
use super::verb::{study_of, with_options};
use crate::cli::answer::{Answer, Failure};
use crate::cli::system::interrupt_flag;
use samara::study::designing::search::Designs;
use samara::study::kind::Kind;
use samara::study::settings::Setting;
use samara::study::tuning::px4::TunePx4;
use samara::study::tuning::search::Tune;

/// A search that was typed.
pub struct Search {
    study: StudyOf,
    /// Whether others judge its candidates.
    ask: bool,
}

/// Runs a search, or as far as others have judged it.
pub fn run(search: &Search) -> Result<Answer, Failure> {
    let stop = interrupt_flag()?;
    search.study.args.parent.watch(&stop)?;
    #[cfg(feature = "shards")]
    if search.ask {
        return super::shards::ask(&search.study, &stop);
    }
    super::fly(&search.study, &stop)
}

/// A search's verb: the kind's options, and the old ones.
fn verb_of(kind: &dyn Kind, command: Command) -> Command {
    let ask = Arg::new("ask")
        .long("ask")
        .action(ArgAction::SetTrue)
        .requires("out")
        .hide(cfg!(not(feature = "shards")))
        .hide_short_help(true)
        .help("Have others judge, step by step: exit code 4 while any are left; now: --shard I/N, samara merge")
        .long_help(
            "Have others judge (`samara evaluate`), step by step: exit code 4 while any are left\n\n\
             Goes on from the rows that have come and ends; once all are there, it ends as it does otherwise. \
             `--shard I/N` and `samara merge` do the same.",
        );
    with_options(kind, command).arg(ask)
}

impl Search {
    fn of(kind: &'static dyn Kind, matches: &ArgMatches) -> Result<Self, clap::Error> {
        Ok(Self { study: study_of(kind, matches)?, ask: matches.get_flag("ask") })
    }
}

/// The verb of a search.
macro_rules! verb {
    ($(#[$about:meta])* $name:ident, $command:expr, $read:expr) => {
        $(#[$about])*
        pub struct $name(pub Search);

        impl std::fmt::Debug for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(self.0.study.kind.about().name)
            }
        }

        impl Args for $name {
            fn augment_args(command: Command) -> Command {
                ($command)(command)
            }

            fn augment_args_for_update(command: Command) -> Command {
                Self::augment_args(command)
            }
        }

        impl FromArgMatches for $name {
            fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
                ($read)(matches).map(Self)
            }

            fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
                *self = Self::from_arg_matches(matches)?;
                Ok(())
            }
        }
    };
}

verb!(
    /// `samara design`.
    DesignArgs,
    |command| {
        let limit = |arg: Arg| arg.conflicts_with("ask");
        verb_of(&Designs, command)
            .mut_arg("time_limit", limit)
            .mut_arg("gains", |arg| arg.visible_alias("start"))
    },
    |matches| Search::of(&Designs, matches)
);

verb!(
    /// `samara tune`.
    TuneArgs,
    |command| {
        let whose = Arg::new(WHOSE)
            .long(WHOSE)
            .value_name("WHOSE")
            .value_parser(["samara", PX4])
            .default_value("samara")
            .help("Whose gains: samara's cascade's, or PX4's own parameters")
            .long_help(
                "Whose gains: samara's cascade's, or PX4's own parameters\n\n\
                 PX4's are searched on the model of PX4's control law.",
            );
        let versions = TunePx4.about().settings.iter().filter(|setting| !is_of_both(setting));
        verb_of(&Tune, command).arg(whose).args(versions.map(option))
    },
    tune_of
);

/// Whose gains are searched.
const WHOSE: &str = "for";
/// PX4's.
const PX4: &str = "px4";

/// Whether both searches of gains have a setting.
fn is_of_both(setting: &Setting) -> bool {
    let has = |kind: &dyn Kind| kind.about().settings.iter().any(|of| of.name == setting.name);
    has(&Tune) && has(&TunePx4)
}

fn tune_of(matches: &ArgMatches) -> Result<Search, clap::Error> {
    let refused = |why: String| clap::Error::raw(ErrorKind::ArgumentConflict, why + "\n");
    let for_px4 = matches.get_one::<String>(WHOSE).is_some_and(|whose| whose == PX4);
    let typed = |setting: &&Setting| {
        let source = matches.value_source(setting.name);
        !is_of_both(setting) && source == Some(clap::parser::ValueSource::CommandLine)
    };
    let spelt = |setting: &Setting| format!("--{}", setting.name.replace('_', "-"));
    if !for_px4 {
        if let Some(setting) = TunePx4.about().settings.iter().find(typed) {
            return Err(refused(format!("{}: --for px4 is expected with it", spelt(setting))));
        }
        let search = Search::of(&Tune, matches)?;
        if search.ask && search.study.values.text("method") == "near-hover" {
            let why = "--ask has no meaning with --method near-hover: it searches nothing";
            return Err(refused(why.to_owned()));
        }
        return Ok(search);
    }
    // PX4's parameters are searched by the strategy alone.
    let is_its_own = |setting: &&Setting| {
        let text = matches.get_raw(setting.name).and_then(|mut texts| texts.next());
        setting.name == "method" && text.is_some_and(|text| text == "cma-es" || text == "pso-cma")
    };
    match Tune.about().settings.iter().filter(typed).find(|setting| !is_its_own(setting)) {
        Some(setting) => Err(refused(format!("{} has no meaning with --for px4", spelt(setting)))),
        None => Search::of(&TunePx4, matches),
    }
}
