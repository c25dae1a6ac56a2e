//! What earlier runs have left in a folder of results: their manifests, and the place where what is not to be
//! lost is set aside, `earlier/<verb>-<beginning of its manifest's SHA-256>`.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::written::{sha256_of, sha256_of_file};
use samara::config::bounded::text_at_most;

/// Folder of what was set aside, within a folder of results.
pub const EARLIER: &str = "earlier";
/// Ending of a manifest's name.
pub const MANIFEST: &str = "_manifest.json";
/// Digits of a hash in a name.
const DIGITS: usize = 12;
/// Larger manifests are none [bytes]: a file for each of a hundred thousand trials has less.
const LARGEST: u64 = 64 << 20;
/// Files up to this size are copied, larger ones linked [bytes]: what is edited in place stays as it was
/// where it is small enough to be edited.
const COPIED_MOST: u64 = 1 << 20;

/// What is read of a manifest.
#[derive(Clone, Debug, Deserialize)]
struct Manifest {
    verb: String,
    mission: String,
    gains: String,
    input_hash: String,
    choices: BTreeMap<String, String>,
    files: BTreeMap<String, String>,
}

/// A run that has left a manifest.
#[derive(Clone, Debug)]
pub struct EarlierRun {
    read: Manifest,
    /// The manifest's name.
    pub manifest: String,
    /// SHA-256 of the manifest, hexadecimal.
    pub sha256: String,
}

impl EarlierRun {
    /// The runs that have left a manifest in a folder, by the names of the manifests.
    pub fn all(folder: &Path) -> Vec<Self> {
        let entries = fs::read_dir(folder).into_iter().flatten();
        let names: BTreeSet<String> =
            entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok()).collect();
        let manifests = names.into_iter().filter(|name| name.ends_with(MANIFEST));
        manifests.filter_map(|name| Self::read(folder, name)).collect()
    }

    /// The run of a manifest; `None` for what is none.
    fn read(folder: &Path, manifest: String) -> Option<Self> {
        let text = text_at_most(&folder.join(&manifest), LARGEST).ok()?;
        let mut read: Manifest = serde_json::from_str(&text).ok()?;
        // A manifest is of its own folder: `../x` names nothing in it.
        read.files.retain(|name, _| is_a_name(name));
        is_a_name(&read.verb).then(|| Self { read, manifest, sha256: sha256_of(&text) })
    }

    /// The verb of the manifest.
    pub fn verb(&self) -> &str {
        &self.read.verb
    }

    /// The hash of the inputs.
    pub fn input_hash(&self) -> &str {
        &self.read.input_hash
    }

    /// The files that the run has written, by their names.
    pub fn files(&self) -> impl Iterator<Item = &str> {
        self.read.files.keys().map(String::as_str)
    }

    /// Whether the run has written a file of this name with this hash.
    pub fn has_written(&self, name: &str, sha256: &str) -> bool {
        self.read.files.get(name).is_some_and(|written| written == sha256)
            || (name == self.manifest && sha256 == self.sha256)
    }

    /// Whether its results are a campaign, a search, a card or what else takes more than a flight: they are
    /// never removed.
    pub fn is_kept(&self) -> bool {
        !["plan", "drop", "cases", "sim", "autopilot", "replay", "assess_only"].contains(&self.verb())
    }

    /// Whether a run of `verb` takes its place: one of the same verb does, and a plan gives way to any.
    pub fn gives_way_to(&self, verb: &str) -> bool {
        !self.is_kept() && (self.verb() == verb || self.verb() == "plan")
    }

    /// The run, in words.
    pub fn name(&self) -> String {
        let Manifest { verb, mission, gains, choices, .. } = &self.read;
        let choices = choices.iter().map(|(name, value)| format!(", {name} {value}"));
        let choices: String = choices.collect();
        format!("`samara {}` of {mission} with gains {gains}{choices}", command_of(verb))
    }

    /// The files of it that lie in a folder as it has written them, its manifest last.
    pub fn as_written(&self, folder: &Path) -> Vec<&str> {
        let mut files: Vec<&str> = self.files().filter(|name| self.is_as_written(folder, name)).collect();
        files.push(&self.manifest);
        files
    }

    /// Whether a file lies in a folder as the run has written it.
    pub fn is_as_written(&self, folder: &Path, name: &str) -> bool {
        let path = folder.join(name);
        fs::symlink_metadata(&path).is_ok_and(|there| there.is_file())
            && sha256_of_file(&path).is_ok_and(|sha256| self.has_written(name, &sha256))
    }

    /// Where it is set aside.
    pub fn place(&self, folder: &Path) -> PathBuf {
        place(folder, self.verb(), &self.sha256)
    }

    /// Sets its files aside as they lie there, and leaves them where they are; whether that was not done
    /// before. The manifest comes last: where it is, the rest is.
    pub fn set_aside(&self, folder: &Path) -> io::Result<bool> {
        let place = self.place(folder);
        if fs::symlink_metadata(place.join(&self.manifest)).is_ok() {
            return Ok(false);
        }
        make(folder, &place)?;
        for name in self.as_written(folder) {
            duplicate(&folder.join(name), &place.join(name))?;
        }
        Ok(true)
    }
}

/// Where something is set aside.
fn place(folder: &Path, what: &str, sha256: &str) -> PathBuf {
    folder.join(EARLIER).join(format!("{what}-{}", &sha256[..DIGITS.min(sha256.len())]))
}

/// Makes a place for what is set aside; a link that leads elsewhere is refused.
fn make(folder: &Path, place: &Path) -> io::Result<()> {
    let leads_on = |path: &Path| fs::symlink_metadata(path).is_ok_and(|there| there.is_symlink());
    if let Some(path) = [&folder.join(EARLIER), place].into_iter().find(|path| leads_on(path)) {
        let (path, target) = (path.display(), fs::read_link(path).unwrap_or_default());
        return Err(io::Error::other(format!("{path} is a link to {}", target.display())));
    }
    fs::create_dir_all(place)
}

/// Moves a file or a folder of a run's that no manifest lists to a place that is named after it and its hash.
pub fn move_aside(folder: &Path, name: &str) -> io::Result<PathBuf> {
    let from = folder.join(name);
    let sha256 = digest(&from)?;
    // What lies in a place may have been edited there: then there is another.
    let mut what = "unlisted".to_owned();
    let mut to = place(folder, &what, &sha256).join(name);
    for n in 2.. {
        let lies = fs::symlink_metadata(&to).is_ok().then(|| digest(&to)).transpose()?;
        if lies.is_none_or(|lies| lies == sha256) {
            break;
        }
        what = format!("unlisted_{n}");
        to = place(folder, &what, &sha256).join(name);
    }
    make(folder, &place(folder, &what, &sha256))?;
    if fs::symlink_metadata(&to).is_ok() {
        // The same bytes lie there already.
        let is_folder = fs::symlink_metadata(&from)?.is_dir();
        if is_folder {
            fs::remove_dir_all(&from)?
        } else {
            fs::remove_file(&from)?
        }
        return Ok(to);
    }
    fs::rename(&from, &to)?;
    Ok(to)
}

/// The hash of a file, or of all that is in a folder.
fn digest(path: &Path) -> io::Result<String> {
    let there = fs::symlink_metadata(path)?;
    if there.is_file() {
        return sha256_of_file(path);
    }
    if !there.is_dir() {
        return Ok(sha256_of(&format!("{:?}", fs::read_link(path).ok())));
    }
    let mut entries = fs::read_dir(path)?.collect::<io::Result<Vec<_>>>()?;
    entries.sort_by_key(fs::DirEntry::file_name);
    let mut text = String::new();
    for entry in entries {
        text += &format!("{:?} {}\n", entry.file_name(), digest(&entry.path())?);
    }
    Ok(sha256_of(&text))
}

/// A second file of the same bytes, which a run that replaces the first one leaves alone.
fn duplicate(from: &Path, to: &Path) -> io::Result<()> {
    if fs::symlink_metadata(to).is_ok() {
        // Left by a run that was killed while it set this aside.
        fs::remove_file(to)?;
    }
    if fs::metadata(from)?.len() > COPIED_MOST && fs::hard_link(from, to).is_ok() {
        return Ok(());
    }
    fs::copy(from, to).map(|_| ())
}

/// Whether a text is the name of a file, without a folder.
pub fn is_a_name(text: &str) -> bool {
    Path::new(text).file_name().is_some_and(|name| name == text)
}

/// The command that writes the manifest of a verb.
fn command_of(verb: &str) -> String {
    let option = match verb {
        "cases" => "drop --cases",
        "plan_grid" => "plan --grid",
        "assess_only" => "assess --only",
        "assess_rare" => "study rare",
        "assess_sobol" => "study sobol",
        "assess_envelope" => "study envelope",
        "effects" => "study effects",
        "free_fall" => "study free-fall",
        "replan" => "study replan",
        _ => {
            let by = |prefix: &str| Some(verb.strip_prefix(prefix)?.split('_').next()?.to_owned());
            return match (by("drops_"), by("repeats_")) {
                (Some(autopilot), _) => format!("assess --autopilot {autopilot}"),
                (_, Some(autopilot)) => format!("assess --repeat --autopilot {autopilot}"),
                _ => verb.to_owned(),
            };
        }
    };
    option.to_owned()
}

#[cfg(test)]
#[expect(clippy::disallowed_methods, reason = "a test that makes files")]
mod tests {
    use super::*;

    fn written(folder: &Path, verb: &str, files: &[(&str, &str)]) -> EarlierRun {
        let mut listed = BTreeMap::new();
        for (name, text) in files {
            if is_a_name(name) {
                fs::write(folder.join(name), text).unwrap();
            }
            listed.insert(*name, sha256_of(text));
        }
        let object = serde_json::json!({
            "verb": verb, "mission": "m", "gains": "g", "input_hash": "h", "choices": {}, "files": listed,
        });
        fs::write(folder.join(format!("{verb}{MANIFEST}")), object.to_string()).unwrap();
        EarlierRun::all(folder).into_iter().find(|run| run.verb() == verb).unwrap()
    }

    /// A manifest that names `../x`, an absolute path or a file in a folder names none of its own.
    #[test]
    fn a_manifest_names_files_of_its_own_folder_alone() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("out");
        fs::create_dir(&folder).unwrap();
        fs::write(place.path().join("x"), "precious").unwrap();
        let absolute = place.path().join("x").display().to_string();
        let run = written(
            &folder,
            "drop",
            &[("a", "1"), ("../x", "precious"), (&absolute, "precious"), ("b/c", ""), ("..", "")],
        );
        assert_eq!(run.files().collect::<Vec<_>>(), ["a"]);
        fs::write(folder.join("tune_manifest.json"), r#"{"verb": "../tune"}"#).unwrap();
        assert_eq!(EarlierRun::all(&folder).len(), 1);
    }

    /// What is set aside is the run as it was written, to the byte and the manifest; what was edited is not
    /// the run's any more.
    #[test]
    fn a_run_is_set_aside_whole_and_once() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path();
        let run = written(folder, "tune", &[("gains.json", "{}"), ("front.csv", "1"), ("gone.csv", "")]);
        fs::write(folder.join("front.csv"), "edited").unwrap();
        fs::remove_file(folder.join("gone.csv")).unwrap();
        assert!(run.set_aside(folder).unwrap() && !run.set_aside(folder).unwrap());
        let aside = run.place(folder);
        assert!(aside.ends_with(format!("earlier/tune-{}", &run.sha256[..12])));
        let names: BTreeSet<_> = fs::read_dir(&aside).unwrap().map(|e| e.unwrap().file_name()).collect();
        assert_eq!(names.into_iter().collect::<Vec<_>>(), ["gains.json", "tune_manifest.json"]);
        fs::write(folder.join("gains.json"), "edited").unwrap();
        assert_eq!(fs::read_to_string(aside.join("gains.json")).unwrap(), "{}");
        assert_eq!(EarlierRun::all(&aside)[0].sha256, run.sha256);
    }

    /// Moved twice, the same file lies there once; another one of the same name beside it.
    #[test]
    fn what_no_manifest_lists_is_moved_and_never_overwritten() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path();
        let moved = |text: &str| {
            fs::write(folder.join("plan.json"), text).unwrap();
            move_aside(folder, "plan.json").unwrap()
        };
        let (mine, again, other) = (moved("mine"), moved("mine"), moved("other"));
        fs::write(&other, "edited").unwrap();
        let anew = moved("other");
        assert_eq!((fs::read_to_string(&anew).unwrap().as_str(), anew == other), ("other", false));
        fs::write(&other, "other").unwrap();
        assert!(mine == again && mine != other && !folder.join("plan.json").exists());
        assert_eq!(fs::read_to_string(mine).unwrap(), "mine");
        assert_eq!(fs::read_to_string(other).unwrap(), "other");
    }

    /// A link in the way is not followed.
    #[test]
    #[cfg(unix)]
    fn nothing_is_set_aside_through_a_link() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("out");
        fs::create_dir_all(place.path().join("elsewhere")).unwrap();
        fs::create_dir(&folder).unwrap();
        let run = written(&folder, "tune", &[("gains.json", "{}")]);
        std::os::unix::fs::symlink("../elsewhere", folder.join(EARLIER)).unwrap();
        let refused = run.set_aside(&folder).unwrap_err().to_string();
        assert!(refused.contains("is a link to ../elsewhere"), "{refused}");
        assert!(move_aside(&folder, "gains.json").is_err() && folder.join("gains.json").exists());
        assert_eq!(fs::read_dir(place.path().join("elsewhere")).unwrap().count(), 0);
    }

    /// The commands are of the program's verbs.
    #[test]
    fn a_run_is_named_by_its_command() {
        let command = |verb: &str| command_of(verb);
        assert_eq!(command("drops_px4-model_quad7_drop_gains"), "assess --autopilot px4-model");
        assert_eq!(command("repeats_px4_trial_3"), "assess --repeat --autopilot px4");
        assert_eq!((command("assess_rare").as_str(), command("drop").as_str()), ("study rare", "drop"));
    }
}
