//! The commands that make evidence again, from what its run says of itself.

use std::collections::BTreeMap;
use std::path::Path;

use super::finding::Finding;
use super::manifest::{Kind, RunManifest};
use samara_report::shell::command_line;

/// Choices of manifests and the options that make them, in the order in which verbs note them: the hash of
/// the inputs follows that order.
pub const CHOICES: [(&str, &str); 13] = [
    ("seed", "--seed"),
    ("release case", "--case"),
    ("autopilot", "--autopilot"),
    ("estimator", "--estimator"),
    ("feed forward", "--feed-forward"),
    ("replan", "--replan"),
    ("trajectory sha256", "--trajectory"),
    ("nodes", "--nodes"),
    ("input cost", "--input-cost"),
    ("terminal tolerance", "--terminal-tolerance"),
    ("tolerance", "--tolerance"),
    ("max iterations", "--max-iterations"),
    ("time limit", "--time-limit"),
];

/// Before the key of a choice that is another value of a key: `set limits.pitch_deg`.
const SET: &str = "set ";

/// The choices that are other values of the mission's or the vehicle's keys, `KEY=VALUE`, in the order of the
/// keys.
pub fn sets(choices: &BTreeMap<String, String>) -> impl Iterator<Item = String> + '_ {
    choices.iter().filter_map(|(name, value)| Some(format!("{}={value}", name.strip_prefix(SET)?)))
}

/// The options that make a run's choices beside values of keys and gains; `folder` is where its files are.
pub fn choice_words(run: &RunManifest, folder: &Path) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    for (choice, option) in CHOICES {
        let Some(value) = run.choices.get(choice) else { continue };
        words.extend(match choice {
            "feed forward" => vec![option.to_owned()],
            "replan" => vec![format!("{option}={value}")],
            // A run keeps a copy of what it was given.
            "trajectory sha256" => {
                vec![option.to_owned(), folder.join("trajectory.csv").display().to_string()]
            }
            // Where its build folder is does not decide the flight.
            "autopilot" if value == "px4" => vec![option.to_owned(), "px4=DIR".to_owned()],
            _ => vec![option.to_owned(), value.clone()],
        });
    }
    words
}

/// The command that makes a run again, quoted for a shell: `mission` and `options` are how mission and gains
/// were named, `folder` is where its files are. `None` for searches, whose options are the circumstances of
/// their manifest.
pub fn command(
    kind: Kind,
    run: &RunManifest,
    found: Option<&Finding>,
    folder: &Path,
    (mission, options): (&str, &[String]),
) -> Option<String> {
    let verb = match kind {
        Kind::Plan => "plan",
        Kind::Drop | Kind::Cases => "drop",
        Kind::Envelope => "study envelope",
        Kind::Rare => "study rare",
        // A campaign says it itself.
        Kind::Campaign | Kind::DropCampaign => {
            let Some(Finding::Campaign(campaign)) = found else { return None };
            return Some(campaign.head.command.clone());
        }
        Kind::Tune | Kind::Design => return None,
    };
    let mut words: Vec<String> =
        std::iter::once("samara").chain(verb.split(' ')).map(str::to_owned).collect();
    words.push(mission.to_owned());
    words.extend(sets(&run.choices).flat_map(|set| ["--set".to_owned(), set]));
    // A plan has no gains.
    if kind != Kind::Plan {
        words.extend_from_slice(options);
    }
    words.extend(choice_words(run, folder));
    if kind == Kind::Cases {
        words.push("--cases".to_owned());
    }
    if let Some(Finding::Rare(rare)) = found {
        words.extend([
            "--least".to_owned(),
            rare.least.to_string(),
            "--bound".to_owned(),
            rare.bound.to_string(),
        ]);
        words.extend(["--per-level".to_owned(), rare.per_level.to_string()]);
        words.extend(rare.unknowns.then(|| "--unknowns".to_owned()));
    }
    let asked = |name: &str| run.circumstances.get(name).cloned();
    if kind == Kind::Envelope {
        words.extend(asked("envelope").into_iter().flat_map(|pairs| ["--pairs".to_owned(), pairs]));
        words.extend(asked("rays").into_iter().flat_map(|rays| ["--rays".to_owned(), rays]));
    }
    Some(command_line(words))
}
