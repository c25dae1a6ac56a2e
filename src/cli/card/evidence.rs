//! The evidence of folders of results: every run that has a manifest, and results that no manifest lists.
//! Each piece is accepted or refused with the reason; nothing is passed over but runs that a card does not
//! read.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use anyhow::Context as _;

use super::args::CardArgs;
use super::inputs::Present;
use crate::cli::answer::{BadInput as _, Failure};
use crate::cli::results::sha256_of;
use crate::cli::terminal::print_err;
use samara::config::bounded::text_at_most;
use samara::config::relative;
use samara::report::json::VERSION;
use samara::report::shell::command_line;
use samara::study::card::Evidence;
use samara::study::card::command::command;
use samara::study::card::finding::Finding;
use samara::study::card::manifest::{Kind, MANIFEST, RunManifest};

/// Largest file that is read [bytes]; an envelope of all pairs and 64 rays has less than a tenth of it.
const LARGEST: u64 = 64 << 20;

/// The manifest of a design.
const DESIGN_MANIFEST: &str = "design_manifest.json";

/// The evidence of the folders that were named, or of where verbs put results; `card`: the card's folder.
pub fn of_folders(args: &CardArgs, present: &Present<'_>, card: &Path) -> Result<Vec<Evidence>, Failure> {
    let usual = Path::new("out").join(&present.mission().name);
    let named = !args.evidence.is_empty();
    let folders = if named { args.evidence.clone() } else { vec![usual] };
    let (mut found, mut seen) = (Vec::new(), BTreeSet::new());
    for folder in &folders {
        if !folder.is_dir() && !named {
            continue;
        }
        let place = fs::canonicalize(folder)
            .with_context(|| format!("--evidence {}: a folder of results is expected", folder.display()))
            .bad_input()?;
        if seen.insert(place) {
            let place = EvidenceFolder { args, present, folder, card };
            found.extend(place.evidence()?);
        }
    }
    // Where a design was written that has made the mission, what it found lies beside it, among the evidence
    // of the mission that it began from.
    let beside = present.mission().file.parent().filter(|beside| beside.join(DESIGN_MANIFEST).is_file());
    if let Some(folder) = beside.filter(|_| !named)
        && fs::canonicalize(folder).is_ok_and(|place| seen.insert(place))
    {
        let of_design = EvidenceFolder { args, present, folder, card }.evidence()?;
        found.extend(of_design.into_iter().filter(|evidence| evidence.kind == Kind::Design));
    }
    found.sort_by_key(|evidence| evidence.kind);
    Ok(found)
}

/// A folder of results.
struct EvidenceFolder<'a> {
    args: &'a CardArgs,
    present: &'a Present<'a>,
    folder: &'a Path,
    /// The folder that the card goes to.
    card: &'a Path,
}

impl EvidenceFolder<'_> {
    fn evidence(&self) -> Result<Vec<Evidence>, Failure> {
        let folder = self.folder;
        let entries = fs::read_dir(folder)
            .and_then(|entries| {
                entries.map(|entry| Ok(entry?.file_name())).collect::<Result<BTreeSet<_>, _>>()
            })
            .with_context(|| format!("--evidence {}: a folder of results is expected", folder.display()))
            .bad_input()?;
        let names: Vec<String> = entries.into_iter().filter_map(|name| name.into_string().ok()).collect();
        let (mut found, mut listed) = (Vec::new(), BTreeSet::new());
        for (name, verb) in names.iter().filter_map(|name| Some((name, name.strip_suffix(MANIFEST)?))) {
            let file = read(&folder.join(name));
            let run = file.as_ref().map_err(Clone::clone).and_then(|file| {
                serde_json::from_str::<RunManifest>(&file.text)
                    .map_err(|error| format!("it is no manifest as a verb writes it: {error}"))
            });
            // Results of a run that a card does not read have manifests, too.
            listed.extend(run.iter().flat_map(|run| run.files.keys().cloned()));
            let Some(kind) = Kind::of_verb(verb) else { continue };
            found.push(match run {
                Ok(run) => self.of_run(kind, run),
                Err(why) => self.piece(kind, name, &file, None, Err(why)),
            });
        }
        for name in names.iter().filter(|name| !listed.contains(*name)) {
            if let Some(kind) = Kind::of_file(name) {
                let why = "no manifest in the folder lists it, so nothing says what it is of";
                found.push(self.piece(kind, name, &read(&folder.join(name)), None, Err(why.to_owned())));
            }
        }
        if found.is_empty() {
            self.say_where_it_is(&names);
        }
        Ok(found)
    }

    /// Says which folders within have results of runs, where this one has none.
    fn say_where_it_is(&self, names: &[String]) {
        let has_evidence = |folder: &Path| {
            let entries = fs::read_dir(folder).into_iter().flatten().filter_map(Result::ok);
            let kind = |name: &str| Kind::of_verb(name.strip_suffix(MANIFEST)?);
            entries.map(|entry| entry.file_name()).any(|name| kind(&name.to_string_lossy()).is_some())
        };
        let within = names.iter().map(|name| self.folder.join(name)).filter(|path| has_evidence(path));
        let options = within.flat_map(|path| ["--evidence".to_owned(), path.display().to_string()]);
        let options: Vec<String> = options.collect();
        if !options.is_empty() {
            print_err(&format!(
                "samara: {}: no result is in it, and folders within are not looked at unless they are named: {}\n",
                self.folder.display(),
                command_line(options)
            ));
        }
    }

    /// The evidence of a run.
    fn of_run(&self, kind: Kind, run: RunManifest) -> Evidence {
        // A drop whose plan was not found has written why, and nothing else.
        let unplanned = kind == Kind::Drop && !run.files.contains_key(&kind.file(&run.verb));
        let kind = if unplanned { Kind::Plan } else { kind };
        let name = kind.file(&run.verb);
        let file = read(&self.folder.join(&name));
        let found = self.found(kind, &run, &name, &file);
        self.piece(kind, &name, &file, Some(run), found)
    }

    /// What a run's file says, or why it is refused.
    fn found(
        &self,
        kind: Kind,
        run: &RunManifest,
        name: &str,
        file: &Result<ResultFile, String>,
    ) -> Result<Finding, String> {
        let mission = self.present.mission();
        if run.version != VERSION {
            return Err(format!("it is by version {} of samara, this is {VERSION}", run.version));
        }
        let Some(listed) = run.files.get(name) else {
            return Err(format!("its run did not come to its end: the manifest has no {name}"));
        };
        if kind != Kind::Design && run.mission != mission.name {
            return Err(format!("it is of the mission {}, not of {}", run.mission, mission.name));
        }
        let file = file.as_ref().map_err(Clone::clone)?;
        if file.sha256 != *listed {
            return Err("it is not as its run wrote it: the SHA-256 in the manifest is another".to_owned());
        }
        let found = Finding::parse(kind, run, &file.text)?;
        self.check_inputs(run, &found, &file.text)?;
        Ok(found)
    }

    /// Refuses what is not of the mission's present inputs.
    fn check_inputs(&self, run: &RunManifest, found: &Finding, text: &str) -> Result<(), String> {
        let mission = self.present.mission();
        match found {
            Finding::Tune(_) => {
                let mut tuned = mission.clone();
                let file = self.folder.join(Kind::Tune.file(&run.verb));
                tuned.use_gains_text(text, &file).map_err(|error| error.to_string())?;
                if tuned.control.gains != mission.control.gains || run.vehicle != mission.vehicle_name {
                    return Err(format!(
                        "it found other gains than {}, which the card is of: --gains {} makes a card of them",
                        mission.control.gains_name,
                        file.display()
                    ));
                }
                Ok(())
            }
            Finding::Design(design) => {
                let designed = run.circumstances.get("designed_input_hash");
                let is_this = designed == Some(&mission.inputs.hash);
                if !is_this && !design.is_own(&mission.hash_without_gains()) {
                    let file = self.folder.join("design_mission.json");
                    return Err(format!(
                        "it is another design than the mission's: a card of {} has it",
                        file.display()
                    ));
                }
                Ok(())
            }
            _ => {
                let expected = self.present.hash_with(&run.choices)?;
                if run.input_hash == expected {
                    return Ok(());
                }
                let gains = &mission.control.gains_name;
                let begin = |hash: &str| hash.chars().take(16).collect::<String>();
                let hashes = format!("{} there, {} now", begin(&run.input_hash), begin(&expected));
                let by_px4 = run.choices.contains_key("autopilot");
                Err(if run.gains != *gains && !by_px4 {
                    format!(
                        "it was flown with gains {}, the card is of {gains} (hash of the inputs {hashes})",
                        run.gains
                    )
                } else {
                    format!("the inputs have changed since (hash {hashes})")
                })
            }
        }
    }

    fn piece(
        &self,
        kind: Kind,
        name: &str,
        file: &Result<ResultFile, String>,
        run: Option<RunManifest>,
        found: Result<Finding, String>,
    ) -> Evidence {
        let path = self.folder.join(name);
        let mission = self.args.mission_word(self.present.mission());
        let again = |run: &RunManifest| {
            command(kind, run, found.as_ref().ok(), self.folder, (&mission, &self.args.gains_options()))
        };
        Evidence {
            kind,
            file: path.display().to_string(),
            link: relative(self.card, &path),
            sha256: file.as_ref().ok().map(|file| file.sha256.clone()),
            command: run.as_ref().and_then(again),
            run,
            found,
        }
    }
}

/// A file of results, read once: what is judged is what its hash is of.
struct ResultFile {
    text: String,
    /// SHA-256, hexadecimal.
    sha256: String,
}

/// A file of results, or why it cannot be read.
fn read(path: &Path) -> Result<ResultFile, String> {
    let cannot = |error: std::io::Error| match error.kind() {
        std::io::ErrorKind::NotFound => "it is gone".to_owned(),
        std::io::ErrorKind::InvalidInput | std::io::ErrorKind::FileTooLarge => {
            format!("it is no file of results: {error}")
        }
        _ => format!("it cannot be read: {error}"),
    };
    let text = text_at_most(path, LARGEST).map_err(cannot)?;
    Ok(ResultFile { sha256: sha256_of(&text), text })
}

#[cfg(test)]
#[expect(clippy::disallowed_methods, reason = "a test that makes files")]
mod tests {
    use super::*;

    /// What is no file of results is refused before it is read: a pipe that nobody writes to, a device, more
    /// than the bound.
    #[test]
    #[cfg(unix)]
    fn what_is_no_file_of_results_is_not_read() {
        let place = tempfile::tempdir().unwrap();
        let at = |name: &str| place.path().join(name);
        fs::write(at("good"), "abc").unwrap();
        assert_eq!(read(&at("good")).map(|file| file.text).as_deref(), Ok("abc"));
        assert!(std::process::Command::new("mkfifo").arg(at("pipe")).status().unwrap().success());
        std::os::unix::fs::symlink("/dev/zero", at("zeros")).unwrap();
        fs::File::create(at("large")).unwrap().set_len(LARGEST + 1).unwrap();
        for name in ["pipe", "zeros", "large"] {
            let why = read(&at(name)).map(|file| file.text.len()).unwrap_err();
            assert!(why.starts_with("it is no file of results"), "{name}: {why}");
        }
        assert_eq!(read(&at("gone")).map(|file| file.text.len()), Err("it is gone".to_owned()));
    }
}
