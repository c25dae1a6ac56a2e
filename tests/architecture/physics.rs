//! docs/physics.md is in step with the sources: what a row says of a file stands in that file, and no file of
//! the physics is missing.

use std::fs;
use std::path::Path;

use super::sources;

/// Text with runs of white space, and what begins a line of documentation, as one space, in lower case.
fn flat(text: &str) -> String {
    let marks = text.replace("//!", " ").replace("///", " ");
    marks.split_whitespace().collect::<Vec<_>>().join(" ").to_lowercase()
}

/// Rows of the page: what a term's source is, and its file.
fn rows(page: &str) -> Vec<(&str, &str)> {
    let row = |line| {
        let cells: Vec<&str> = str::split(line, '|').map(str::trim).collect();
        let [.., source, file, ""] = cells[..] else { return None };
        Some((source, file.strip_prefix('`')?.strip_suffix('`')?))
    };
    page.lines().filter_map(row).collect()
}

#[test]
fn the_page_of_the_physics_names_every_equation_where_it_is() {
    let page = fs::read_to_string("docs/physics.md").unwrap();
    let rows = rows(&page);
    assert!(rows.len() > 40, "{} rows", rows.len());
    let mut wrong = Vec::new();
    for (source, file) in &rows {
        let Ok(text) = fs::read_to_string(file) else {
            wrong.push(format!("{file} is not there"));
            continue;
        };
        let text = flat(&text);
        for word in source.split(", ").filter(|word| !text.contains(&flat(word))) {
            wrong.push(format!("{file} says nothing of {word}"));
        }
    }
    for folder in ["crates/core/src/model", "crates/core/src/sim/sensors"] {
        for path in sources(Path::new(folder)) {
            let name = path.to_string_lossy().replace('\\', "/");
            let plumbing = ["/mod.rs", "/tests.rs", "_tests.rs"].iter().any(|end| name.ends_with(end));
            if !plumbing && !page.contains(&format!("`{name}`")) {
                wrong.push(format!("docs/physics.md does not name {name}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
