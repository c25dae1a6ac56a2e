//! Runs whole drops in a seeded network and prints the seeds that break a property.
//!
//! ```sh
//! cargo run --release --example network -- --seeds 100000
//! cargo run --release --example network -- --seed 17
//! ```
#![expect(clippy::print_stdout, clippy::unwrap_used, reason = "a program of the tests")]

#[path = "../tests/network/mod.rs"]
mod network;

fn main() -> std::process::ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |i: usize| arguments.get(i).and_then(|text| text.parse::<u64>().ok());
    match (arguments.first().map(String::as_str), number(1)) {
        (Some("--seed"), Some(seed)) => one(seed),
        (Some("--seeds"), Some(seeds)) => many(number(2).unwrap_or(0), seeds),
        _ => {
            println!("expected --seed NUMBER, or --seeds HOW_MANY [FIRST]");
            std::process::ExitCode::from(2)
        }
    }
}

/// One run with its story.
fn one(seed: u64) -> std::process::ExitCode {
    let (trouble, mut seen, broken) = network::run(seed);
    for line in std::mem::take(&mut seen.story) {
        println!("{line}");
    }
    println!("seed {seed}: {:?} at speed {}, {:?}", trouble.kind, trouble.speed, trouble.trigger);
    println!("{seen:#?}");
    println!("broken: {broken:#?}");
    std::process::ExitCode::from(u8::from(!broken.is_empty()))
}

/// Many runs, those that fail, and how many there are of each kind.
fn many(first: u64, seeds: u64) -> std::process::ExitCode {
    let mut counts = network::KINDS.map(|kind| (kind, 0, 0, 0));
    let mut failed = false;
    for seed in first..first + seeds {
        let result = std::panic::catch_unwind(|| network::run(seed));
        let Ok((trouble, seen, broken)) = result else {
            println!("seed {seed}: a panic");
            failed = true;
            continue;
        };
        let count = counts.iter_mut().find(|c| c.0 == trouble.kind).unwrap();
        count.1 += 1;
        count.2 += u64::from(seen.simulator_yes);
        count.3 += u64::from(!broken.is_empty());
        if !broken.is_empty() {
            failed = true;
            println!("seed {seed} {:?}: {}", trouble.kind, broken.join("; "));
        }
    }
    for (kind, runs, good, failing) in counts {
        println!("{kind:?}: {runs} runs, {good} good drops, {failing} seeds fail");
    }
    std::process::ExitCode::from(u8::from(failed))
}
