//! `docs/own_vehicle.md`: the commands of the page, run one after the other as a reader would.
#![cfg(feature = "cli")]

use std::process::Command;

/// Each command answers yes; a search may also find nothing better, which the page says.
#[test]
fn the_commands_of_the_page_run() {
    let page = include_str!("../docs/own_vehicle.md");
    let commands: Vec<&str> = page.lines().filter(|line| line.starts_with("samara ")).collect();
    assert_eq!(commands.len(), 10, "{commands:?}");
    let folder = tempfile::tempdir().unwrap();
    let run = |line: &str, at: &std::path::Path| {
        let words = line.split(' ').skip(1);
        let output = Command::new(env!("CARGO_BIN_EXE_samara")).args(words).current_dir(at).output().unwrap();
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        let code = output.status.code();
        let good = code == Some(0) || (line.starts_with("samara tune") && code == Some(1));
        assert!(good, "{line}: {code:?}\n{text}{}", String::from_utf8_lossy(&output.stderr));
        text
    };
    run(commands[0], folder.path());
    let heron = folder.path().join("heron");
    let mut said = commands[1..].iter().map(|line| run(line, &heron));
    // The drop's verdict is its last line.
    let drop = said.nth(3).unwrap();
    assert!(drop.lines().last().unwrap().starts_with("safe: J_TPF "), "{drop}");
    let rest: Vec<String> = said.collect();
    assert!(rest[0].lines().last().unwrap().contains("safe in all 500 trials"), "{}", rest[0]);
    assert!(rest[1].lines().last().unwrap().starts_with("tuned is "), "{}", rest[1]);
    for file in ["out/heron_drop/drop.html", "out/heron_drop/assess.html", "out/tuned/gains.json"] {
        assert!(heron.join(file).exists(), "{file}");
    }
    // A rotor of PX4's control allocation for each of the six.
    let parameters = std::fs::read_to_string(heron.join("heron.params")).unwrap();
    for rotor in 0..6 {
        assert!(parameters.contains(&format!("CA_ROTOR{rotor}_PX")), "{rotor}");
    }
}
