//! The architecture's rules, read off the sources: floors, purity of the core, one place for sockets.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use module_tree::{Tree, circles};

#[path = "architecture/budgets.rs"]
mod budgets;
mod module_tree;
#[path = "architecture/physics.rs"]
mod physics;
#[path = "architecture/prose.rs"]
mod prose;

/// The floors, lowest first; modules on one floor do not know each other.
const FLOORS: &[&[&str]] = &[
    &["math", "real"],
    &["checksum", "hints", "kalman", "printable", "random", "simd", "ulog", "units", "vector"],
    &["frames", "time"],
    &["logged_flight", "model"],
    &["identify", "trajectory"],
    &["control", "plan"],
    &["sim"],
    &["manoeuvre", "uncertain"],
    &["assess", "replan", "verify"],
    &["tune"],
    &["design", "params"],
    &["config"],
    &["report"],
    &["study"],
    &["host"],
    &["view"],
    &["autopilot"],
    &["link"],
    &["cli"],
];

fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found: Vec<PathBuf> = fs::read_dir(folder)
        .unwrap()
        .flat_map(|entry| {
            let path = entry.unwrap().path();
            if path.is_dir() { sources(&path) } else { vec![path] }
        })
        .filter(|p| p.extension().is_some_and(|e| e == "rs"))
        .collect();
    found.sort();
    found
}

/// The folders of sources: the program's and the library's, and each crate's.
fn roots() -> Vec<PathBuf> {
    let crates = fs::read_dir("crates").unwrap().map(|entry| entry.unwrap().path().join("src"));
    let mut roots: Vec<PathBuf> = crates.chain([PathBuf::from("src")]).collect();
    roots.sort();
    roots
}

fn all_sources() -> Vec<PathBuf> {
    roots().iter().flat_map(|root| sources(root)).collect()
}

/// The crates that are one floor each: whom they import the compiler keeps. Folder and module of the library.
const WALLED: [(&str, &str); 5] = [
    ("crates/mission", "config"),
    ("crates/study", "study"),
    ("crates/host", "host"),
    ("crates/report", "report"),
    ("crates/view", "view"),
];

/// The top-level module that a file belongs to.
fn module_of(path: &Path) -> String {
    if let Some((_, module)) = WALLED.iter().find(|(folder, _)| path.starts_with(folder)) {
        return (*module).to_owned();
    }
    let mut after = path.components().skip_while(|c| c.as_os_str() != "src").skip(1);
    after.next().unwrap().as_os_str().to_str().unwrap().trim_end_matches(".rs").to_owned()
}

fn floor_of(module: &str) -> usize {
    FLOORS.iter().position(|floor| floor.contains(&module)).unwrap_or_else(|| {
        panic!("module `{module}` stands on no floor: add it to FLOORS and ARCHITECTURE.md")
    })
}

/// Top-level modules that a source names as `crate::module`, outside comments.
fn imports(text: &str) -> Vec<String> {
    let code: String = text
        .lines()
        .map(|line| line.split("//").next().unwrap_or_default())
        .flat_map(|line| [line, "\n"])
        .collect();
    code.split("crate::")
        .skip(1)
        .flat_map(|rest| {
            // `crate::{a::X, b}` and `crate::a::X`.
            let names: Vec<&str> = match rest.strip_prefix('{') {
                Some(list) => list.split('}').next().unwrap_or_default().split(',').collect(),
                None => vec![rest],
            };
            names.into_iter().map(|name| {
                name.trim().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>()
            })
        })
        .filter(|name| !name.is_empty())
        .collect()
}

#[test]
fn a_module_imports_only_what_stands_below_it() {
    let mut faults = Vec::new();
    for path in all_sources() {
        let module = module_of(&path);
        let walled = WALLED.iter().any(|(folder, _)| path.starts_with(folder));
        if walled || module == "lib" || module == "main" {
            continue;
        }
        for import in imports(&fs::read_to_string(&path).unwrap()) {
            // Vehicles and sites that tests of several crates share.
            if import.starts_with("test_") {
                continue;
            }
            if import != module && floor_of(&import) >= floor_of(&module) {
                faults.push(format!("{}: `{module}` imports `{import}`", path.display()));
            }
        }
    }
    assert!(faults.is_empty(), "imports that go up a floor:\n{}", faults.join("\n"));
}

/// No clock, socket or printing below the shells, and no thread but in the host of studies.
#[test]
fn the_core_is_pure() {
    let mut faults = Vec::new();
    for path in all_sources() {
        let module = module_of(&path);
        let shells = ["crates/link/src/link/shell", "crates/view/src/server"];
        let shell =
            ["cli", "main"].contains(&module.as_str()) || shells.iter().any(|at| path.starts_with(at));
        if shell {
            continue;
        }
        let text = fs::read_to_string(&path).unwrap();
        let allowed = if module == "host" { "std::thread" } else { "" };
        for word in [
            "std::net",
            "tokio::",
            "std::thread",
            "SystemTime",
            "Instant::now",
            "println!",
            "thread_local!",
            "static mut",
        ] {
            if word == allowed {
                continue;
            }
            for (i, line) in text.lines().enumerate() {
                let code = line.split("//").next().unwrap_or_default();
                if code.contains(word)
                    && !path.ends_with("tests.rs")
                    && !text[..text.find(line).unwrap_or(0)].contains("mod tests")
                {
                    faults.push(format!("{}:{}: {word}", path.display(), i + 1));
                }
            }
        }
    }
    assert!(faults.is_empty(), "not pure:\n{}", faults.join("\n"));
}

/// Flights are spread over threads by the host of studies alone: rayon is its own.
#[test]
fn rayon_is_the_host_s_alone() {
    let names = ["Cargo.toml", "python/Cargo.toml"].map(PathBuf::from);
    let crates = fs::read_dir("crates").unwrap().map(|entry| entry.unwrap().path().join("Cargo.toml"));
    let uses = |path: &PathBuf| {
        fs::read_to_string(path).unwrap().lines().any(|line| line.starts_with("rayon = { workspace"))
    };
    let found: Vec<PathBuf> = names.into_iter().chain(crates).filter(uses).collect();
    assert_eq!(found, [PathBuf::from("crates/host/Cargo.toml")]);
}

/// Code that is `unsafe` stands in the module of registers only.
#[test]
fn unsafe_code_stands_in_one_place() {
    let with_unsafe: Vec<PathBuf> = all_sources()
        .into_iter()
        .filter(|path| {
            let text = fs::read_to_string(path).unwrap();
            text.lines().any(|line| line.split("//").next().unwrap_or_default().contains("unsafe {"))
        })
        .collect();
    let places = ["crates/core/src/simd.rs", "crates/core/src/simd/lanes.rs"].map(Path::new);
    assert!(with_unsafe.iter().all(|p| places.contains(&p.as_path())), "{with_unsafe:?}");
}

/// An error that has a source does not tell it in its own text: whoever prints the chain would print it
/// twice.
#[test]
fn no_error_shows_its_source_twice() {
    let mut faults = Vec::new();
    for path in all_sources() {
        let source = fs::read_to_string(&path).unwrap();
        for variant in source.split("#[error(").skip(1) {
            let Some((text, rest)) = variant.split_once(")]\n") else { continue };
            let body = rest.split("\n    /// ").next().unwrap_or_default();
            let has_source = ["#[from]", "#[source]", " source:"].iter().any(|mark| body.contains(mark));
            let told = ["{0", "{source", "{error"].iter().any(|field| text.contains(field));
            if has_source && told {
                faults.push(format!("{}: {text}", path.display()));
            }
        }
    }
    assert!(faults.is_empty(), "told twice:\n{}", faults.join("\n"));
}

/// Each module stands in ARCHITECTURE.md's map.
#[test]
fn the_map_names_every_module() {
    let map = fs::read_to_string("ARCHITECTURE.md").unwrap();
    for module in FLOORS.iter().flat_map(|floor| floor.iter()) {
        let is_there =
            |root: &PathBuf| root.join(module).exists() || root.join(format!("{module}.rs")).exists();
        let walled = WALLED.iter().any(|(folder, name)| name == module && Path::new(folder).exists());
        assert!(walled || roots().iter().any(is_there), "`{module}` is gone");
        assert!(map.contains(&format!("`{module}")), "ARCHITECTURE.md does not mention `{module}`");
    }
}

/// The table of where to start reading is short, and what it names is there.
#[test]
fn where_to_start_reading_fits_a_screen_and_is_there() {
    let page = fs::read_to_string("ARCHITECTURE.md").unwrap();
    let table = page.split("## ").find(|part| part.starts_with("Where to start")).unwrap();
    let rows: Vec<&str> = table.lines().filter(|line| line.starts_with("| ")).skip(1).collect();
    assert!((1..=15).contains(&rows.len()), "{} rows", rows.len());
    for row in rows {
        for name in row.split('`').skip(1).step_by(2).filter(|name| name.contains('/')) {
            // `report/shard/mod.rs` is `crates/report/src/shard/mod.rs`.
            let in_crate = name.split_once('/').map(|(krate, rest)| format!("crates/{krate}/src/{rest}"));
            let is_there = Path::new(name).exists()
                || in_crate.is_some_and(|path| Path::new(&path).exists())
                || roots().iter().any(|root| root.join(name).exists());
            assert!(is_there, "{name} is gone");
        }
    }
}

/// A file that no `mod` declares is never compiled, and nobody sees that.
#[test]
fn every_source_file_is_compiled() {
    let tree = Tree::read();
    let reached = tree.files();
    let orphans: BTreeSet<PathBuf> = all_sources()
        .into_iter()
        .chain(sources(Path::new("tests")))
        .filter(|path| !reached.contains(path.as_path()))
        .collect();
    assert!(orphans.is_empty(), "reached from neither lib.rs nor a main.rs, so never compiled: {orphans:#?}");
}

/// Files that import from each other cannot be read one after the other.
#[test]
fn no_files_import_each_other_in_a_circle() {
    let tree = Tree::read();
    let arrows = tree.arrows();
    let circles = circles(&arrows);
    let mut told = String::new();
    for circle in &circles {
        told.push_str("circle:\n");
        for file in circle {
            let to: Vec<_> = arrows[file].iter().filter(|other| circle.contains(*other)).collect();
            told.push_str(&format!("  {} imports from {to:?}\n", file.display()));
        }
    }
    assert!(circles.is_empty(), "{} circles:\n{told}", circles.len());
}
