//! The rotors whose blades are known: the shipped tables against the theory, and that against what was
//! measured.
#![cfg(feature = "files")]

use std::path::PathBuf;

use samara::config::{BladeFile, blade_file};

fn shipped(name: &str) -> BladeFile {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(format!("params/vehicles/{name}.json"));
    blade_file(&path).unwrap()
}

const SHIPPED: [&str; 1] = ["titan_bemt"];

/// Each shipped table is what `samara rotor` writes.
#[test]
fn regress_the_shipped_tables_are_fresh() {
    for name in SHIPPED {
        let file = shipped(name);
        let found = std::fs::read_to_string(&file.path).unwrap();
        assert!(found == file.table_text(), "{name}: stale; run `samara rotor params/vehicles/{name}.json`");
    }
}
