//! `samara completions` and `samara man`: what a shell and `man` want to know of the command line.

use std::path::PathBuf;

use clap::{Args, Command};
use clap_complete::Shell;

use super::answer::{Answer, Failure};
use super::results::OutputFolder;
use super::terminal::print;

/// `samara completions`.
#[derive(Args, Debug)]
pub struct CompletionsArgs {
    /// The shell.
    #[arg(value_enum)]
    pub shell: Shell,
}

/// `samara man`.
#[derive(Args, Debug)]
pub struct ManArgs {
    /// Folder to write to.
    #[arg(long, value_name = "DIR", default_value = "man")]
    pub out: PathBuf,
}

/// Prints the completions of `command` for a shell.
pub fn completions(args: &CompletionsArgs, mut command: Command) -> Result<Answer, Failure> {
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut command, "samara", &mut text);
    print(&String::from_utf8_lossy(&text))?;
    Ok(Answer::Yes)
}

/// Writes a page for `command` and one for each of its verbs, in section 1.
pub fn man(args: &ManArgs, command: Command) -> Result<Answer, Failure> {
    let folder = OutputFolder::plain(&args.out)?;
    for (name, page) in pages(command) {
        let path = folder.write_text(&format!("{name}.1"), &page)?;
        print(&format!("{}\n", path.display()))?;
    }
    Ok(Answer::Yes)
}

/// The pages of the command and of its verbs, each with its name: `samara-params-export`.
fn pages(mut command: Command) -> Vec<(String, String)> {
    // Names the verbs after the commands that they belong to.
    command.build();
    let mut pages = Vec::new();
    collect(&command, &mut pages);
    pages
}

fn collect(command: &Command, pages: &mut Vec<(String, String)>) {
    let name = command.get_display_name().unwrap_or_else(|| command.get_name()).to_owned();
    let mut text = Vec::new();
    // Into memory: this does not fail.
    let _ = clap_mangen::Man::new(command.clone()).title(name.clone()).render(&mut text);
    pages.push((name, String::from_utf8_lossy(&text).into_owned()));
    // Verbs that the short help leaves out have pages, too.
    let verbs = command.get_subcommands().filter(|verb| verb.get_name() != "help");
    verbs.for_each(|verb| collect(verb, pages));
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory as _;

    use super::pages;
    use crate::cli::verbs::Cli;

    /// Every verb has a page that is found under its name and gives it.
    #[test]
    fn every_verb_has_a_page() {
        let pages = pages(Cli::command());
        let names: Vec<&str> = pages.iter().map(|(name, _)| name.as_str()).collect();
        for expected in ["samara", "samara-drop", "samara-params-export", "samara-completions"] {
            assert!(names.contains(&expected), "{names:?}");
        }
        for (name, page) in &pages {
            assert!(page.contains(&format!(".TH {name} 1")), "{name}: {page}");
        }
    }
}
