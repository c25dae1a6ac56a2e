//! The oldest compiler that Cargo.toml promises is the one that the dependencies need.
#![cfg(feature = "files")]

use std::process::Command;

/// A version's parts, so that 1.100 is more than 1.89.
fn parts(version: &str) -> Vec<u32> {
    let mut parts: Vec<u32> = version.split('.').map(|part| part.parse().unwrap()).collect();
    parts.resize(3, 0);
    parts
}

fn cargo(args: &[&str]) -> String {
    let output = Command::new(env!("CARGO")).args(args).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn rust_version_is_the_highest_of_the_dependencies() {
    let about = cargo(&["--version", "--verbose"]);
    let host = about.lines().find_map(|line| line.strip_prefix("host: ")).unwrap();
    // Not offline: the packages of `python/`, which `cargo build` never asks for, may not be here yet.
    let metadata = cargo(&["metadata", "--format-version=1", "--locked", "--filter-platform", host]);
    let metadata: serde_json::Value = serde_json::from_str(&metadata).unwrap();
    let packages = metadata["packages"].as_array().unwrap();
    let needed = packages
        .iter()
        .filter(|package| !["samara", "samara-tpf"].contains(&package["name"].as_str().unwrap()))
        .filter_map(|package| Some((parts(package["rust_version"].as_str()?), &package["name"])))
        .max_by(|a, b| a.0.cmp(&b.0))
        .unwrap();
    assert_eq!(parts(env!("CARGO_PKG_RUST_VERSION")), needed.0, "{} needs it", needed.1);
}
