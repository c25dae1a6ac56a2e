//! `samara noes`.

use clap::Args;
use serde_json::{Value, json};

use super::answer::{Answer, Failure};
use super::terminal::print;
use samara::hints::{Hint, all, page};
use samara::report::json::VERSION;

/// `samara noes`.
#[derive(Args, Debug)]
pub struct NoesArgs {
    /// Print one JSON object on stdout instead of a page.
    #[arg(long)]
    pub json: bool,
}

/// Prints every no with what mostly causes it and the command for it: the page of the documentation.
pub fn run(args: &NoesArgs) -> Result<Answer, Failure> {
    let row = |hint: &Hint| {
        let Hint { name, said, cause, command, .. } = hint;
        let explained_by: Vec<&str> = hint.explained_by.iter().map(|no| no.hint().name).collect();
        json!({ "no": name, "said": said, "cause": cause, "command": command, "explained_by": explained_by })
    };
    print(&if args.json {
        let noes: Vec<Value> = all().map(row).collect();
        format!("{:#}\n", json!({ "version": VERSION, "noes": noes }))
    } else {
        page()
    })?;
    Ok(Answer::Yes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;
    use clap::error::ErrorKind;
    use samara::config::settable_keys;
    use samara::hints::Typed;

    /// The commands parse, for a mission of which a value was set and gains were chosen.
    #[test]
    fn every_command_is_one() {
        let words = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>();
        let typed = Typed {
            mission: words(&["x500_drop", "--set", "limits.pitch_deg=40"]),
            gains: words(&["--gains", "x500"]),
        };
        for hint in all() {
            let command = hint.command_for(&typed);
            let parsed = super::super::help::with_negative_values(crate::cli::verbs::Cli::command())
                .try_get_matches_from(&command);
            let refused = parsed.err().filter(|error| error.kind() != ErrorKind::DisplayHelp);
            assert!(refused.is_none(), "{}: {}", command.join(" "), refused.unwrap());
        }
    }

    /// Words in backticks with a point in them are keys of a mission, those of a command are options.
    #[test]
    fn every_key_is_one() {
        let keys: Vec<&str> = settable_keys().map(|key| key.path.as_str()).collect();
        for hint in all() {
            let words = hint.cause.split('`').skip(1).step_by(2);
            for key in words.filter(|word| word.contains('.')) {
                assert!(keys.contains(&key), "{}: `{key}`", hint.name);
            }
        }
    }
}
