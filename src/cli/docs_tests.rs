//! The documentation beside the program: links lead somewhere, commands parse, the tutorial's files load.
#![expect(clippy::disallowed_methods, reason = "tests that read pages and write a mission")]

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use clap::error::ErrorKind;
use clap::{ArgMatches, Command, CommandFactory};
use samara::config::plain_name;
use samara::config::shipped::{MISSIONS, names_in};

use super::help::with_negative_values;

/// Pages outside `docs/`.
const ROOT_PAGES: [&str; 5] =
    ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md", "SECURITY.md"];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// All pages, with their text; paths are relative to the repository.
fn pages() -> Vec<(PathBuf, String)> {
    let mut paths: Vec<PathBuf> = ROOT_PAGES.iter().map(PathBuf::from).collect();
    let mut docs: Vec<PathBuf> = fs::read_dir(root().join("docs"))
        .unwrap()
        .map(|entry| Path::new("docs").join(entry.unwrap().file_name()))
        .filter(|path| path.extension().is_some_and(|e| e == "md"))
        .collect();
    docs.sort();
    paths.extend(docs);
    paths.into_iter().map(|path| (path.clone(), fs::read_to_string(root().join(&path)).unwrap())).collect()
}

/// Lines of a page with whether they stand in a fence, and in which language's; the fences themselves left
/// out.
fn lines(page: &str) -> impl Iterator<Item = (Option<&str>, &str)> {
    let mut fence = None;
    page.lines().filter_map(move |line| match line.trim_start().strip_prefix("```") {
        Some(language) => {
            fence = if fence.is_some() { None } else { Some(language.trim()) };
            None
        }
        None => Some((fence, line)),
    })
}

/// What stands between `open` and `close`, each time.
fn between<'a>(text: &'a str, open: &'a str, close: &'a str) -> impl Iterator<Item = &'a str> {
    text.split(open).skip(1).filter_map(move |rest| rest.split_once(close)).map(|(inside, _)| inside)
}

/// Anchors of a page as hosting platforms and mdBook make them from headings.
fn anchors(page: &str) -> BTreeSet<String> {
    let heading = |line: &str| {
        let kept = line.trim_start_matches('#').trim().to_lowercase();
        kept.chars()
            .filter(|c| c.is_alphanumeric() || " -_".contains(*c))
            .map(|c| if c == ' ' { '-' } else { c })
            .collect::<String>()
    };
    lines(page)
        .filter(|(fence, line)| fence.is_none() && line.starts_with('#'))
        .map(|(_, l)| heading(l))
        .collect()
}

/// A command of a line of shell: redirections, pipes and comments cut off. None where the line runs another
/// program.
fn samara_words(line: &str) -> Option<Vec<&str>> {
    let line = line.split(" #").next()?.split(" > ").next()?.split(" | ").next()?.trim();
    let words: Vec<&str> = line.split_whitespace().map(|word| word.trim_matches('\'')).collect();
    let program = words.first()?;
    (*program == "samara" || program.ends_with("/samara")).then_some(words)
}

/// The missions that a parsed command names by a name alone.
fn missions(command: &Command, matches: &ArgMatches) -> Vec<PathBuf> {
    if let Some((verb, matches)) = matches.subcommand() {
        return command.find_subcommand(verb).map_or(Vec::new(), |command| missions(command, matches));
    }
    let mission = command.get_arguments().find(|arg| arg.get_id() == "mission");
    let path = mission.and_then(|_| matches.get_one::<PathBuf>("mission"));
    path.into_iter().filter(|path| plain_name(path).is_some()).cloned().collect()
}

/// Names of the vehicles and missions that the commands of a page make: `samara new mission NAME`.
fn made_by(page: &str) -> Vec<String> {
    let words = lines(page).filter_map(|(_, line)| samara_words(line));
    let new = words.filter(|words| words.get(1) == Some(&"new"));
    new.filter_map(|words| words.get(3).map(|name| (*name).to_owned())).collect()
}

/// Why a command does not parse, or which mission or file of the repository that it names is not there.
fn wrong_with(words: &[&str], made: &[String]) -> Option<String> {
    let command = with_negative_values(super::Cli::command());
    let known = |name: &PathBuf| {
        names_in(MISSIONS).any(|known| Path::new(known) == name)
            || made.iter().any(|made| Path::new(made) == name)
    };
    match command.clone().try_get_matches_from(words) {
        Ok(matches) => {
            if let Some(name) = missions(&command, &matches).iter().find(|name| !known(name)) {
                return Some(format!("no mission {}", name.display()));
            }
        }
        Err(e) if matches!(e.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) => {}
        Err(e) => return Some(e.to_string()),
    }
    let kept = |word: &&&str| {
        let folders = ["mission/", "params/"];
        folders.iter().any(|folder| word.starts_with(folder)) && !root().join(word).exists()
    };
    words.iter().find(kept).map(|word| format!("{word} is not there"))
}

#[test]
fn commands_of_the_pages_parse() {
    let mut count = 0;
    for (path, page) in pages() {
        let made = made_by(&page);
        // A command may go on behind a backslash.
        for (fence, line) in lines(&page.replace("\\\n", " ")) {
            let Some(words) = fence.filter(|f| *f == "sh").and_then(|_| samara_words(line)) else { continue };
            count += 1;
            if let Some(why) = wrong_with(&words, &made) {
                panic!("{}: {line}\n{why}", path.display());
            }
        }
    }
    assert!(count > 50, "{count} commands found");
}

/// A command in a sentence may have placeholders and dots: its verb and its options exist.
#[test]
fn options_named_in_sentences_exist() {
    let cli = super::Cli::command();
    let mut count = 0;
    for (path, page) in pages() {
        let prose: String =
            lines(&page).filter(|(fence, _)| fence.is_none()).map(|(_, l)| l.to_owned() + " ").collect();
        for code in between(&prose, "`samara ", "`") {
            let mut command: &Command = &cli;
            for word in code.split([' ', '=', ',']) {
                if let Some(option) = word.strip_prefix("--").filter(|o| !o.is_empty()) {
                    count += 1;
                    let known = ["help", "version"].contains(&option)
                        || command.get_arguments().any(|arg| arg.get_long() == Some(option));
                    assert!(known, "{}: `samara {code}`: no --{option}", path.display());
                } else if let Some(verb) = command.find_subcommand(word) {
                    command = verb;
                }
            }
            let verb = code.split_whitespace().next().unwrap_or_default();
            let named = verb.starts_with('-') || verb.chars().all(|c| c.is_uppercase());
            assert!(
                named || verb.split('|').all(|v| cli.find_subcommand(v.trim_end_matches(',')).is_some()),
                "{}: `samara {code}`",
                path.display()
            );
        }
    }
    assert!(count > 20, "{count} options found");
}

#[test]
fn examples_of_the_help_parse() {
    fn examples(command: &Command, found: &mut Vec<String>) {
        let help = command.get_after_long_help().map(ToString::to_string).unwrap_or_default();
        found.extend(help.lines().filter_map(|l| l.strip_prefix("  ")).map(str::to_owned));
        command.get_subcommands().for_each(|c| examples(c, found));
    }
    let mut found = Vec::new();
    examples(&super::Cli::command(), &mut found);
    let commands: Vec<_> =
        found.iter().map(|line| line.split(" (").next().unwrap()).filter_map(samara_words).collect();
    assert!(commands.len() > 40, "{}", commands.len());
    for words in commands {
        if let Some(why) = wrong_with(&words, &[]) {
            panic!("{words:?}\n{why}");
        }
    }
}

/// The pages of the book link to each other only, so that the book has no dead link; ARCHITECTURE.md, which
/// is shown in it, links nowhere.
#[test]
fn links_lead_somewhere() {
    let pages = pages();
    let mut count = 0;
    for (path, page) in &pages {
        let prose: String =
            lines(page).filter(|(fence, _)| fence.is_none()).map(|(_, l)| l.to_owned() + "\n").collect();
        for link in between(&prose, "](", ")") {
            if link.contains("://") {
                continue;
            }
            count += 1;
            let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
            let target = if file.is_empty() { path.clone() } else { path.parent().unwrap().join(file) };
            assert!(root().join(&target).exists(), "{}: {link} leads nowhere", path.display());
            let leads_out = file.contains("..") || (path.ends_with("ARCHITECTURE.md") && !file.is_empty());
            let in_the_book = path.starts_with("docs") || path.ends_with("ARCHITECTURE.md");
            assert!(!(in_the_book && leads_out), "{}: {link} leads out of the book", path.display());
            if !anchor.is_empty() {
                let text = fs::read_to_string(root().join(&target)).unwrap();
                assert!(anchors(&text).contains(anchor), "{}: {link}: no such heading", path.display());
            }
        }
    }
    assert!(count > 80, "{count} links found");
}

/// Files and folders named in backticks, but for those that the page's commands make; a Rust file also as it
/// is below `src` of its crate.
#[test]
fn files_named_in_the_pages_exist() {
    const FOLDERS: [&str; 10] = [
        "src/",
        "crates/",
        "tests/",
        "scripts/",
        "benches/",
        "examples/",
        "params/",
        "mission/",
        "docs/",
        "fuzz/",
    ];
    const SOURCES: [&str; 4] = ["", "src", "crates/core/src", "crates/link/src"];
    // `report/shard/mod.rs` is `crates/report/src/shard/mod.rs`.
    let in_crate = |code: &str| {
        let path = code.split_once('/').map(|(krate, rest)| format!("crates/{krate}/src/{rest}"));
        path.is_some_and(|path| root().join(path).exists())
    };
    let mut count = 0;
    for (path, page) in pages() {
        let made = made_by(&page);
        for code in page.split('`').skip(1).step_by(2) {
            let named = code.ends_with(".rs") || FOLDERS.iter().any(|folder| code.starts_with(folder));
            let pattern = code.contains([' ', '*', '<', '{', '\n', ':', '$'])
                || code.contains("NAME")
                || made.iter().any(|name| code.contains(name.as_str()));
            if named && !pattern {
                count += 1;
                let found =
                    in_crate(code) || SOURCES.iter().any(|folder| root().join(folder).join(code).exists());
                assert!(found, "{}: `{code}` is not there", path.display());
            }
        }
    }
    assert!(count > 100, "{count} files found");
}

#[test]
fn the_table_of_contents_has_every_page() {
    let contents = fs::read_to_string(root().join("docs/SUMMARY.md")).unwrap();
    for (path, _) in pages().iter().filter(|(path, _)| path.starts_with("docs")) {
        let name = path.file_name().unwrap().to_str().unwrap();
        assert!(name == "SUMMARY.md" || contents.contains(&format!("({name})")), "{name}");
    }
}

/// Rows of tables and what a command says cannot be wrapped; everything else can.
#[test]
fn no_line_of_prose_is_wider_than_110_columns() {
    for (path, page) in pages() {
        let mut made = false;
        for (i, line) in page.lines().enumerate() {
            made = line.starts_with("<!-- results:") || made && line != "<!-- end -->";
            assert!(
                made || line.starts_with('|') || line.chars().count() <= 110,
                "{}:{}: {} columns",
                path.display(),
                i + 1,
                line.chars().count()
            );
        }
    }
}

/// Pages that are written by hand, without the table of contents, what programs write into them and what
/// stands in fences.
#[test]
fn the_pages_of_docs_have_at_most_42_520_words() {
    let words = |page: &str| {
        let mut made = false;
        let counted = lines(page).filter(|(fence, line)| {
            let mark = line.starts_with("<!-- ");
            made = mark && *line != "<!-- end -->" || made && !mark;
            !made && !mark && fence.is_none()
        });
        counted.map(|(_, line)| line.split_whitespace().count()).sum::<usize>()
    };
    let by_hand = |path: &Path| {
        let made = ["docs/SUMMARY.md", "docs/mission_keys.md", "docs/parameters.md", "docs/what_now.md"];
        path.starts_with("docs") && !made.iter().any(|page| Path::new(page) == path)
    };
    let all: usize = pages().iter().filter(|(path, _)| by_hand(path)).map(|(_, page)| words(page)).sum();
    assert!(all <= 42_520, "{all} words");
}

#[test]
fn the_readme_is_short() {
    let readme = fs::read(root().join("README.md")).unwrap();
    assert!(readme.len() <= 8192, "{} bytes", readme.len());
}

/// The tutorial's vehicle, gains and mission, as they are printed there, are read.
#[test]
fn the_tutorial_s_files_load() {
    let page = fs::read_to_string(root().join("docs/tutorial.md")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let names: Vec<&str> =
        between(&page, "Save this as `my/", "`").filter(|n| n.ends_with(".json")).collect();
    let files: Vec<&str> = between(&page, "```json\n", "```").collect();
    assert_eq!((names.len(), files.len()), (3, 3));
    for (name, file) in names.iter().zip(files) {
        fs::write(folder.path().join(name), file).unwrap();
    }
    let mission = samara::config::load_mission(&folder.path().join("kestrel_drop.json")).unwrap();
    assert_eq!(mission.name, "kestrel_drop");
}

/// The table of what a flight came to has each quantity, in the order of files.
#[test]
fn every_quantity_stands_in_the_page_of_files() {
    let page = fs::read_to_string(root().join("docs/files.md")).unwrap();
    let (_, table) = page.split_once("\n| quantity | what it is |\n").unwrap();
    let rows = table.lines().take_while(|line| line.starts_with('|'));
    let named: Vec<&str> = rows
        .filter_map(|row| row.split('|').nth(1))
        .flat_map(|cell| cell.split('`').skip(1).step_by(2))
        .collect();
    let keys = samara::assess::outcome::QUANTITIES.each_ref().map(|quantity| quantity.key);
    assert_eq!(named, keys);
}

/// The table of verbs has each of them.
#[test]
fn every_verb_stands_in_the_introduction() {
    let page = fs::read_to_string(root().join("docs/introduction.md")).unwrap();
    let rows = page.lines().filter_map(|line| line.strip_prefix("| `samara "));
    let named: BTreeSet<&str> =
        rows.flat_map(|row| row.split('`')).map(|name| name.trim_start_matches("samara ")).collect();
    for verb in super::Cli::command().get_subcommands().filter(|verb| !verb.is_hide_set()) {
        assert!(named.contains(verb.get_name()), "docs/introduction.md has no `{}`", verb.get_name());
    }
}

/// Where the lander's plan has its peak of speed: `docs/plan.md`, `docs/paper.md` and titan.json's origins
/// say so.
#[test]
fn regress_the_plan_s_peak_is_where_the_pages_say() {
    let mission = samara::config::load_mission(&root().join("mission/titan_paper.json")).unwrap();
    let options = samara::plan::SolverOptions::default();
    let solve = samara::plan::plan(
        &mission.plan_problem(),
        &samara::plan::Guess::StraightLine,
        &options,
        &mut |_| std::ops::ControlFlow::Continue(()),
    );
    let nodes = solve.unwrap().trajectory;
    let share = |i: usize| nodes.nodes()[i].v_ned.norm() / 12.0;
    let round = |x: f64, digits: i32| (x * 10f64.powi(digits)).round() / 10f64.powi(digits);
    // The first hump, while thrusts rise; then the peak.
    assert!(share(5) > share(4) && share(5) > share(6));
    assert_eq!((round(nodes.nodes()[5].t_s, 2), round(share(5), 4)), (4.05, 0.5417));
    let peak = &nodes.nodes()[14];
    assert!((0..nodes.nodes().len()).all(|i| share(i) <= share(14)));
    assert_eq!((round(peak.t_s, 2), round(share(14), 4)), (11.35, 0.5532));
    assert_eq!([peak.v_ned.x, peak.v_ned.z].map(|v| round(v, 2)), [3.75, 5.48]);
    assert!(peak.thrust_n[1] > 299.9 && nodes.nodes()[7].thrust_n[1] > 299.9, "long at the limit");
    for page in ["docs/plan.md", "docs/paper.md", "params/vehicles/titan.json"] {
        let text = fs::read_to_string(root().join(page)).unwrap();
        assert!(["0.5417", "11.35 s"].iter().all(|number| text.contains(number)), "{page}");
    }
}
