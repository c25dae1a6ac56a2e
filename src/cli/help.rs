//! What is done to the command line as a whole: the long helps are flowed to the terminal's width (in the
//! sources their paragraphs are broken where the source is), and a value may be negative, so that the option
//! itself says what it expects.

use clap::Command;

/// The command, its options and those of its verbs taking `-5` for a value, not for an option that there is
/// not.
pub fn with_negative_values(command: Command) -> Command {
    let values = |arg: &clap::Arg| !arg.is_positional() && arg.get_action().takes_values();
    command
        .mut_args(|arg| if values(&arg) { arg.allow_negative_numbers(true) } else { arg })
        .mut_subcommands(with_negative_values)
}

/// The command with its own and its verbs' long helps flowed.
pub fn flowed(command: Command) -> Command {
    let command = match command.get_after_long_help().map(ToString::to_string) {
        Some(text) => command.after_long_help(joined(&text)),
        None => command,
    };
    command.mut_subcommands(flowed)
}

/// Each paragraph in one line. Blank lines part paragraphs; indented lines (examples) and those before them
/// stay.
fn joined(text: &str) -> String {
    let mut out = String::new();
    let mut before = "";
    for line in text.lines() {
        let goes_on =
            !before.is_empty() && !line.is_empty() && !line.starts_with(' ') && !before.starts_with(' ');
        if !out.is_empty() {
            out.push(if goes_on { ' ' } else { '\n' });
        }
        out += line;
        before = line;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_paragraphs_flow_and_examples_stay() {
        let text = "One\ntwo.\n\nThree\nfour.\n\nExamples:\n  a\n  b";
        assert_eq!(joined(text), "One two.\n\nThree four.\n\nExamples:\n  a\n  b");
    }

    /// Each verb keeps its examples, line by line.
    #[test]
    fn every_verb_s_help_flows() {
        use clap::CommandFactory;
        let command = flowed(crate::cli::verbs::Cli::command());
        for verb in command.get_subcommands() {
            let text = verb.get_after_long_help().map(ToString::to_string).unwrap_or_default();
            assert!(
                text.contains("Examples:\n  samara ") || verb.has_subcommands(),
                "{}: {text}",
                verb.get_name()
            );
        }
    }

    /// What `-h` prints fits a terminal: 40 lines of 100 columns, for each verb and verb of a verb.
    #[test]
    fn the_short_help_fits_a_terminal() {
        use clap::CommandFactory;
        fn look(mut command: Command, name: &str) {
            let text = command.render_help().to_string();
            let widest = text.lines().map(|line| line.chars().count()).max().unwrap_or(0);
            let lines = text.lines().count();
            assert!(lines <= 40 && widest <= 100, "{name}: {lines} lines, {widest} columns\n{text}");
            for verb in command.get_subcommands().cloned() {
                let name = format!("{name} {}", verb.get_name());
                look(verb, &name);
            }
        }
        look(flowed(crate::cli::verbs::Cli::command()), "samara");
    }
}
