//! Budgets that keep rooms and objects small, read off the sources. A budget is raised only where the reason
//! stands in ARCHITECTURE.md.

use std::collections::BTreeMap;
use std::fs;

use super::{all_sources, module_of};

/// Most methods of a type, over all its `impl` blocks in a crate.
const METHODS_MOST: usize = 45;

/// The type that a line `impl .. {` is about.
fn implemented(line: &str) -> Option<&str> {
    let rest = line.strip_prefix("impl")?.strip_suffix('{')?;
    let rest = match rest.strip_prefix('<') {
        Some(generic) => generic.split_once("> ").map(|(_, after)| after)?,
        None => rest.trim_start(),
    };
    let of = rest.split_once(" for ").map_or(rest, |(_, of)| of);
    of.split(|c: char| !(c.is_alphanumeric() || c == '_')).next().filter(|name| !name.is_empty())
}

/// Whether a line of an `impl` block begins a method.
fn is_method(line: &str) -> bool {
    let Some(code) = line.strip_prefix("    ").filter(|code| !code.starts_with(' ')) else { return false };
    code.split('(').next().is_some_and(|head| head.starts_with("fn ") || head.contains(" fn "))
        || code.starts_with("pub(") && code.contains(" fn ")
}

#[test]
fn no_type_has_more_methods_than_a_reader_can_hold() {
    let mut counts: BTreeMap<(String, String), usize> = BTreeMap::new();
    for path in all_sources() {
        let krate = path.components().take_while(|c| c.as_os_str() != "src").collect::<std::path::PathBuf>();
        let mut of = None;
        for line in fs::read_to_string(&path).unwrap().lines() {
            match line {
                "}" => of = None,
                _ if line.starts_with("impl") => of = implemented(line).map(str::to_owned),
                _ => {}
            }
            if let Some(of) = of.as_ref().filter(|_| is_method(line)) {
                *counts.entry((krate.display().to_string(), of.clone())).or_default() += 1;
            }
        }
    }
    assert!(counts.values().any(|&n| n > 30), "the count is broken");
    let large: Vec<_> = counts.iter().filter(|(_, n)| **n > METHODS_MOST).collect();
    assert!(large.is_empty(), "more than {METHODS_MOST} methods: {large:?}");
}

/// Random numbers are drawn by streams of the register alone: no other place knows the generator.
#[test]
fn random_numbers_come_from_the_register() {
    let naming: Vec<_> = all_sources()
        .into_iter()
        .filter(|path| fs::read_to_string(path).unwrap().contains("chacha20"))
        .map(|path| path.display().to_string())
        .collect();
    assert!(naming.len() == 1 && naming[0].ends_with("core/src/random/mod.rs"), "{naming:?}");
}

/// What reports results and what reads missions flies nothing and makes no controller: `study` does.
#[test]
fn nothing_flies_above_or_below_the_studies() {
    let mut faults = Vec::new();
    for path in all_sources() {
        if !["config", "report"].contains(&module_of(&path).as_str()) {
            continue;
        }
        let text = fs::read_to_string(&path).unwrap();
        let code = text.split("\n#[cfg(test)]").next().unwrap_or_default();
        for (i, line) in code.lines().enumerate().filter(|(_, line)| !line.trim_start().starts_with("//")) {
            for word in [" fly(", "(fly(", "sim::fly", "Cascade::new", ".step(", "Px4Controller::new"] {
                if line.contains(word) {
                    faults.push(format!("{}:{}: {word}", path.display(), i + 1));
                }
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// HTML is written by `report/html.rs` alone, where what comes in as text is escaped.
#[test]
fn markup_is_written_in_one_place() {
    let mut faults = Vec::new();
    for path in super::sources(std::path::Path::new("src")) {
        let name = path.to_string_lossy().replace('\\', "/");
        // Figures are SVG; footprint and junit are XML; tests look for what was written.
        let others = ["html.rs", "/figure/", "footprint.rs", "junit.rs", "tests.rs"];
        if others.iter().any(|other| name.contains(other)) {
            continue;
        }
        let text = fs::read_to_string(&path).unwrap();
        let code = text.split("\n#[cfg(test)]").next().unwrap_or_default();
        let closes = |line: &str| line.split("</").skip(1).any(|rest| rest.starts_with(char::is_alphabetic));
        let lines = code.lines().enumerate().filter(|(_, line)| !line.trim_start().starts_with("//"));
        faults.extend(lines.filter(|(_, line)| closes(line)).map(|(i, _)| format!("{name}:{}", i + 1)));
    }
    assert!(faults.is_empty(), "markup by hand:\n{}", faults.join("\n"));
}
