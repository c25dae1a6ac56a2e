//! Rules for lines and words, read off the sources: how wide a line may be, and doc comments that stand
//! alone.

use std::fs;
use std::path::{Path, PathBuf};

use super::{all_sources, sources};

/// Columns of a line, `rustfmt.toml`'s `max_width`, which rustfmt does not apply to comments.
const WIDTH: usize = 110;

/// How no doc comment may begin: hover shows it alone, without what such words point to.
const POINTS_ELSEWHERE: &[&str] = &["Its", "The same", "Who", "What it"];

fn files() -> Vec<PathBuf> {
    let tests = ["tests", "python/src"].iter().flat_map(|folder| sources(Path::new(folder)));
    all_sources().into_iter().chain(tests).collect()
}

/// For each line whether a string literal stands on it, in part or whole.
fn lines_with_strings(text: &str) -> Vec<bool> {
    let mut marks = vec![false];
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let (length, is_string) = match c {
            '/' if rest.starts_with("//") => (rest.find('\n').unwrap_or(rest.len()), false),
            'r' if rest.starts_with("r#\"") => (rest.find("\"#").map_or(rest.len(), |end| end + 2), true),
            '\'' if rest.starts_with("'\"'") => (3, false),
            '\'' if rest.starts_with("'\\\"'") => (4, false),
            '"' => (string_length(rest), true),
            _ => (c.len_utf8(), false),
        };
        let (piece, after) = rest.split_at(length);
        for c in piece.chars() {
            if c == '\n' {
                marks.push(false);
            }
            *marks.last_mut().unwrap() |= is_string;
        }
        rest = after;
    }
    marks
}

/// Bytes of the string literal at the beginning of `text`, both quotes counted.
fn string_length(text: &str) -> usize {
    let mut escaped = false;
    for (i, c) in text.char_indices().skip(1) {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            '"' => return i + 1,
            _ => {}
        }
    }
    text.len()
}

fn faults_of_width(text: &str) -> Vec<usize> {
    let marks = lines_with_strings(text);
    let wide = |(i, line): (usize, &str)| (!marks[i] && line.chars().count() > WIDTH).then_some(i + 1);
    text.lines().enumerate().filter_map(wide).collect()
}

/// The text of a line's doc comment, `//!` or `///`.
fn doc(line: &str) -> Option<&str> {
    let line = line.trim_start();
    line.strip_prefix("///").or_else(|| line.strip_prefix("//!"))
}

fn faults_of_words(text: &str) -> Vec<usize> {
    let lines: Vec<&str> = text.lines().collect();
    let begins = |i: usize| i == 0 || doc(lines[i - 1]).is_none();
    let points_elsewhere = |words: &str| {
        POINTS_ELSEWHERE.iter().any(|start| {
            words
                .trim_start()
                .strip_prefix(start)
                .is_some_and(|rest| !rest.starts_with(char::is_alphanumeric))
        })
    };
    (0..lines.len())
        .filter(|&i| begins(i) && doc(lines[i]).is_some_and(points_elsewhere))
        .map(|i| i + 1)
        .collect()
}

fn assert_none(what: &str, faults_of: fn(&str) -> Vec<usize>) {
    let places: Vec<String> = files()
        .iter()
        .flat_map(|file| {
            let faults = faults_of(&fs::read_to_string(file).unwrap());
            faults.into_iter().map(|line| format!("{}:{line}", file.display()))
        })
        .collect();
    assert!(places.is_empty(), "{what}:\n{}", places.join("\n"));
}

#[test]
fn no_line_is_wider_than_110_columns_but_string_literals() {
    assert_none("wider than 110 columns", faults_of_width);
}

#[test]
fn no_doc_comment_begins_with_what_stands_elsewhere() {
    assert_none("begins with one of Its, The same, Who, What it", faults_of_words);
}

/// Both rules find what breaks them, and nothing else.
#[test]
fn the_rules_can_be_broken() {
    let wide = "x".repeat(WIDTH + 1);
    let text = format!("// {wide}\nlet a = \"{wide}\";\nlet b = r#\"\n{wide}\n\"#;\nlet {wide} = '\"';\n");
    assert_eq!(faults_of_width(&text), [1, 6]);
    let text = "/// Its mass.\na\n/// Mass.\n/// Its unit is kg.\nb\n//! Who.\nc\n/// Whole.\n";
    assert_eq!(faults_of_words(text), [1, 6]);
    assert_eq!(faults_of_words("x\n    /// What it is.\n"), [2]);
}
