//! The tree of modules, read off the sources: which files `mod` declarations reach, and which file imports
//! from which.
//!
//! It reads text, not Rust: macros that make imports are not seen.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// A module: the file that holds it, and what it says of others.
struct Module {
    file: PathBuf,
    /// Modules of tests are reached, but their imports do not count.
    for_tests: bool,
    children: BTreeSet<String>,
    /// Names that a `use` brings into the module, each with the path that it stands for.
    imported: BTreeMap<String, Segments>,
    /// Those of them that the module only hands on (`pub use`).
    handed_on: BTreeSet<String>,
    /// Every other path that the code names.
    named: BTreeSet<Segments>,
}

/// A path such as `crate::model::Vehicle`, piece by piece.
type Segments = Vec<String>;

/// The library's modules by their path from the root; the program's stand under `main`, those of the crates
/// under `samara_NAME`, the integration tests' under `tests`.
pub struct Tree(BTreeMap<Segments, Module>);

impl Tree {
    /// Reads `src/lib.rs`, `src/main.rs`, `tests/main.rs`, `tests/network/main.rs`, the `lib.rs` of each
    /// crate, and every file that they reach.
    pub fn read() -> Self {
        let mut tree = Self(BTreeMap::new());
        tree.add(Vec::new(), Path::new("src/lib.rs"), false);
        for folder in fs::read_dir("crates").unwrap().map(|entry| entry.unwrap().path()) {
            let name = format!("samara_{}", folder.file_name().unwrap().to_str().unwrap());
            tree.add(vec![name], &folder.join("src/lib.rs"), false);
        }
        tree.add(vec!["main".to_owned()], Path::new("src/main.rs"), false);
        tree.add(vec!["tests".to_owned()], Path::new("tests/main.rs"), true);
        tree.add(vec!["network".to_owned()], Path::new("tests/network/main.rs"), true);
        tree
    }

    fn add(&mut self, at: Segments, file: &Path, for_tests: bool) {
        let text = without_inline_tests(&code_of(&fs::read_to_string(file).unwrap()));
        let folder = match file.file_name().unwrap().to_str().unwrap() {
            "lib.rs" | "main.rs" | "mod.rs" => file.parent().unwrap().to_owned(),
            _ => file.with_extension(""),
        };
        let declared = declarations(&text);
        let (imported, handed_on) = imports(&text);
        let module = Module {
            file: file.to_owned(),
            for_tests,
            children: declared.iter().map(|d| d.name.clone()).collect(),
            imported,
            handed_on,
            named: named_paths(&text),
        };
        self.0.insert(at.clone(), module);
        for child in declared {
            let mut inside = at.clone();
            inside.push(child.name.clone());
            let places = child
                .paths
                .iter()
                .map(|p| file.parent().unwrap().join(p))
                .chain([folder.join(format!("{}.rs", child.name)), folder.join(&child.name).join("mod.rs")]);
            for (i, place) in places.filter(|p| p.exists()).enumerate() {
                let mut key = inside.clone();
                // A module with a second file for another system.
                key.last_mut().unwrap().push_str(&"'".repeat(i));
                self.add(key, &place, for_tests || child.for_tests);
            }
        }
    }

    /// Whether the program or a crate stands under this name.
    fn is_root(&self, name: &str) -> bool {
        (name == "main" || name.starts_with("samara_")) && self.0.contains_key(&[name.to_owned()][..])
    }

    /// The files of all modules.
    pub fn files(&self) -> BTreeSet<&Path> {
        self.0.values().map(|module| module.file.as_path()).collect()
    }

    /// The module that a path leads to from inside module `at`, following what other modules hand on; `None`:
    /// out of the crate.
    fn target(&self, at: &[String], path: &[String], depth: usize) -> Option<Segments> {
        let module = self.0.get(at)?;
        let (first, mut rest) = path.split_first()?;
        let mut here: Segments = match first.as_str() {
            "crate" => at.first().filter(|top| self.is_root(top)).cloned().into_iter().collect(),
            "samara" => Vec::new(),
            of_a_crate if of_a_crate.starts_with("samara_") && self.is_root(of_a_crate) => {
                vec![first.clone()]
            }
            "self" => at.to_owned(),
            "super" => at[..at.len().checked_sub(1)?].to_owned(),
            child if module.children.contains(child) => [at, &[child.to_owned()]].concat(),
            name if depth < 8 => match module.imported.get(name) {
                Some(import) if import.first() != Some(first) || import.len() > 1 => {
                    let whole: Segments = import.iter().chain(rest).cloned().collect();
                    return self.target(at, &whole, depth + 1);
                }
                _ => return None,
            },
            _ => return None,
        };
        while let Some((segment, after)) = rest.split_first() {
            let module = self.0.get(&here)?;
            if segment == "super" {
                here.pop()?;
            } else if module.children.contains(segment) {
                here.push(segment.clone());
            } else if let Some(import) = module.imported.get(segment).filter(|_| depth < 8) {
                let whole: Segments = import.iter().chain(after).cloned().collect();
                return self.target(&here, &whole, depth + 1).or(Some(here));
            } else {
                break;
            }
            rest = after;
        }
        Some(here)
    }

    /// Which file names something of which other, tests left out.
    pub fn arrows(&self) -> BTreeMap<&Path, BTreeSet<&Path>> {
        let mut arrows: BTreeMap<&Path, BTreeSet<&Path>> = BTreeMap::new();
        for (at, module) in self.0.iter().filter(|(_, m)| !m.for_tests) {
            let used =
                module.imported.iter().filter(|(name, _)| !module.handed_on.contains(*name)).map(|(_, p)| p);
            for path in used.chain(&module.named) {
                if let Some(target) = self.target(at, path, 0)
                    && let Some(other) = self.0.get(&target)
                    && other.file != module.file
                {
                    arrows.entry(&module.file).or_default().insert(&other.file);
                }
            }
        }
        arrows
    }
}

struct Declaration {
    name: String,
    for_tests: bool,
    /// Of `#[path = ".."]`.
    paths: Vec<String>,
}

/// The text without comments and without what stands in string literals (paths of files, `".rs"`, excepted);
/// lines stay.
fn code_of(text: &str) -> String {
    let mut code = String::new();
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let skipped = match c {
            '/' if rest.starts_with("//") => rest.find('\n').unwrap_or(rest.len()),
            'r' if rest.starts_with("r#\"") => rest.find("\"#").map_or(rest.len(), |end| end + 2),
            '\'' if rest.starts_with("'\"'") => 3,
            '\'' if rest.starts_with("'\\\"'") => 4,
            '"' => string_length(rest),
            _ => 0,
        };
        let (literal, after) = rest.split_at(skipped.max(c.len_utf8()));
        if skipped == 0 || literal.ends_with(".rs\"") {
            code.push_str(literal);
        } else {
            code.extend(literal.chars().filter(|&c| c == '\n'));
        }
        rest = after;
    }
    code
}

/// Bytes of the string literal that `text` begins with.
fn string_length(text: &str) -> usize {
    let mut escaped = false;
    for (i, c) in text.char_indices().skip(1) {
        match c {
            '"' if !escaped => return i + 1,
            _ => escaped = c == '\\' && !escaped,
        }
    }
    text.len()
}

/// Cuts `#[cfg(test)] mod tests { .. }` out.
fn without_inline_tests(code: &str) -> String {
    let mut kept = String::new();
    let mut lines = code.lines().peekable();
    let mut pending: Vec<&str> = Vec::new();
    while let Some(line) = lines.next() {
        if line.starts_with("#[cfg(test)]") || (!pending.is_empty() && line.starts_with("#[")) {
            pending.push(line);
        } else if !pending.is_empty() && line.starts_with("mod ") && line.ends_with('{') {
            pending.clear();
            for inside in lines.by_ref() {
                if inside == "}" {
                    break;
                }
            }
        } else {
            for held in pending.drain(..) {
                kept.push_str(held);
                kept.push('\n');
            }
            kept.push_str(line);
            kept.push('\n');
        }
    }
    kept
}

fn declarations(code: &str) -> Vec<Declaration> {
    let mut found = Vec::new();
    let mut attributes = String::new();
    for line in code.lines().map(str::trim) {
        if line.starts_with("#[") || (!attributes.is_empty() && !attributes.ends_with(']')) {
            attributes.push_str(line);
            continue;
        }
        let bare =
            ["pub ", "pub(crate) ", "pub(super) "].iter().find_map(|v| line.strip_prefix(v)).unwrap_or(line);
        if let Some(name) = bare.strip_prefix("mod ").and_then(|rest| rest.strip_suffix(';')) {
            let paths = attributes
                .split("path = \"")
                .skip(1)
                .map(|p| p.split('"').next().unwrap().to_owned())
                .collect();
            let for_tests = attributes.contains("cfg(test)") || attributes.contains("cfg(all(test");
            found.push(Declaration { name: name.to_owned(), for_tests, paths });
        }
        attributes.clear();
    }
    found
}

/// Names that `use` brings in, with their paths, and which of them are handed on.
fn imports(code: &str) -> (BTreeMap<String, Segments>, BTreeSet<String>) {
    let (mut imported, mut handed_on) = (BTreeMap::new(), BTreeSet::new());
    for (visibility, tree) in uses(code) {
        for path in spread(&tree) {
            let (path, name) = match path.split_once(" as ") {
                Some((path, alias)) => (path.to_owned(), alias.trim().to_owned()),
                None => (path.clone(), path.rsplit("::").next().unwrap().to_owned()),
            };
            let mut segments: Segments = path.split("::").map(|s| s.trim().to_owned()).collect();
            let name = if name == "self" { segments[segments.len() - 2].clone() } else { name };
            if segments.last().is_some_and(|last| last == "self") {
                segments.pop();
            }
            if visibility {
                handed_on.insert(name.clone());
            }
            imported.insert(name, segments);
        }
    }
    (imported, handed_on)
}

/// Every `use` of the code: whether others see it, and what stands behind it.
fn uses(code: &str) -> Vec<(bool, String)> {
    let mut found = Vec::new();
    let mut rest = code;
    while let Some(at) = rest.find("use ") {
        let before = rest[..at].rsplit('\n').next().unwrap();
        let statement = &rest[at + 4..];
        let end = statement.find(';').unwrap_or(statement.len());
        let begins =
            before.trim().is_empty() || before.trim().starts_with("pub") && before.ends_with([' ', ')']);
        if begins {
            found.push((before.contains("pub"), statement[..end].replace('\n', " ")));
        }
        rest = if begins { &statement[end..] } else { statement };
    }
    found
}

/// `a::{b, c::{d}}` as `a::b`, `a::c::d`.
fn spread(tree: &str) -> Vec<String> {
    let tree = tree.trim();
    let Some(open) = tree.find('{') else {
        return if tree.is_empty() { Vec::new() } else { vec![tree.to_owned()] };
    };
    let inner = &tree[open + 1..tree.rfind('}').unwrap_or(tree.len())];
    let (mut parts, mut depth, mut start) = (Vec::new(), 0, 0);
    for (i, c) in inner.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(&inner[start..i]);
                start = i + 1;
            }
            _ => {}
        }
    }
    parts.push(&inner[start..]);
    parts.into_iter().flat_map(spread).map(|rest| format!("{}{rest}", &tree[..open])).collect()
}

/// Paths of two or more segments that the code names outside of `use`.
fn named_paths(code: &str) -> BTreeSet<Segments> {
    let mut found = BTreeSet::new();
    let without_uses: String = code.split(';').filter(|s| !is_use(s)).collect::<Vec<_>>().join(";");
    for word in without_uses.split(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':')) {
        let segments: Segments =
            word.split("::").filter(|s| !s.is_empty()).map(|s| s.trim_end_matches(':').to_owned()).collect();
        if segments.len() > 1 && !word.starts_with("::") {
            found.insert(segments);
        }
    }
    found
}

fn is_use(statement: &str) -> bool {
    let bare = statement.trim_start();
    let bare = bare.lines().rev().find(|l| {
        let l = l.trim_start();
        l.starts_with("use ") || (l.starts_with("pub") && l.contains(" use "))
    });
    bare.is_some()
}

/// Sets of files of which each reaches each other by imports.
pub fn circles<'a>(arrows: &BTreeMap<&'a Path, BTreeSet<&'a Path>>) -> Vec<BTreeSet<&'a Path>> {
    let reach = |from: &'a Path| {
        let (mut seen, mut open) = (BTreeSet::new(), vec![from]);
        while let Some(file) = open.pop() {
            for &next in arrows.get(file).into_iter().flatten() {
                if seen.insert(next) {
                    open.push(next);
                }
            }
        }
        seen
    };
    let reached: BTreeMap<&Path, BTreeSet<&Path>> = arrows.keys().map(|&file| (file, reach(file))).collect();
    let mut found: BTreeSet<BTreeSet<&Path>> = BTreeSet::new();
    for (&file, others) in &reached {
        if others.contains(file) {
            let back = |other: &&Path| reached.get(*other).is_some_and(|r| r.contains(file));
            found.insert(others.iter().copied().filter(back).collect());
        }
    }
    found.into_iter().collect()
}
