//! What can be named: missions, vehicles and gains of the folder that one is in, and those that the program
//! brings along.

use std::path::{Path, PathBuf};

use serde_json::Value;

use super::error::ConfigError;
use super::gains_file::{GainsFile, load_gains};
use super::mission::{Mission, load_mission};
use super::names::{mission_path, names_of, plain_name, vehicle_path};
use super::shipped::{GAINS, MISSIONS, VEHICLES, built_in, names_in};
use super::source::Source;
use super::vehicle_file::{VehicleFile, load_vehicle};

/// A file that can be named.
#[derive(Debug)]
pub struct Listed<T> {
    /// The word that means it to every verb: a name, or a path where no name does.
    pub name: String,
    /// The file; of a built-in one the path begins with `built-in:`.
    pub path: PathBuf,
    /// The first sentence of what the file says of itself.
    pub about: Option<String>,
    /// The file as it was read, or why it is refused.
    pub read: Result<T, ConfigError>,
}

/// Missions, in the order of their names: those of `./mission`, and those built in that no file of that
/// folder stands before.
pub fn listed_missions() -> Vec<Listed<Mission>> {
    listed(MISSIONS, mission_path, load_mission)
}

/// Vehicles likewise, of `./params/vehicles` and built in.
pub fn listed_vehicles() -> Vec<Listed<VehicleFile>> {
    listed(VEHICLES, vehicle_path, load_vehicle)
}

/// Gains, those built in by their names; then those of `./params/gains` that are not the same text, by their
/// paths: a name means them only to a mission whose own gains lie there.
pub fn listed_gains() -> Vec<Listed<GainsFile>> {
    let of_program = names_in(GAINS).map(|name| (name.to_owned(), built_in(GAINS, name)));
    let text = |path: &Path| Source::read(path, "gains file", None).ok().map(|source| source.text);
    let of_folder = names_of(Path::new(GAINS)).into_iter().filter_map(|name| {
        let path = in_folder(GAINS, &name);
        let is_built_in = names_in(GAINS).any(|known| known == name)
            && text(&path).is_some_and(|own| Some(own) == text(&built_in(GAINS, &name)));
        (path.is_file() && !is_built_in).then(|| (path.display().to_string(), path))
    });
    of_program.chain(of_folder).map(|(name, path)| one(name, path, load_gains)).collect()
}

fn listed<T>(
    folder: &str,
    path_of: fn(&Path) -> Result<PathBuf, ConfigError>,
    load: fn(&Path) -> Result<T, ConfigError>,
) -> Vec<Listed<T>> {
    let mut names: Vec<String> = names_in(folder).map(str::to_owned).collect();
    names.extend(names_of(Path::new(folder)));
    names.sort();
    names.dedup();
    let found = names.into_iter().filter_map(|name| {
        let is_a_word = !name.starts_with('-') && plain_name(Path::new(&name)).is_some();
        if is_a_word {
            // A folder that is named like a file is none.
            return path_of(Path::new(&name)).ok().map(|path| (name, path));
        }
        let path = in_folder(folder, &name);
        path.is_file().then(|| (path.display().to_string(), path))
    });
    found.map(|(name, path)| one(name, path, load)).collect()
}

fn in_folder(folder: &str, name: &str) -> PathBuf {
    Path::new(folder).join(format!("{name}.json"))
}

fn one<T>(name: String, path: PathBuf, load: fn(&Path) -> Result<T, ConfigError>) -> Listed<T> {
    Listed { about: about(&path), read: load(&path), name, path }
}

/// The first sentence under the key `about`.
fn about(path: &Path) -> Option<String> {
    let source = Source::read(path, "file", None).ok()?;
    let json: Value = serde_json::from_str(&source.text).ok()?;
    let text = json.get("about")?.as_str()?;
    Some(text.split_once(". ").map_or(text, |(first, _)| first).trim_end_matches('.').to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every file that is listed is read, under its name as under its path, and says what it is.
    #[test]
    fn what_is_listed_is_read() {
        let missions = listed_missions();
        assert_eq!(missions.len(), names_in(MISSIONS).count());
        for mission in missions {
            assert_eq!(mission_path(Path::new(&mission.name)).unwrap(), mission.path);
            assert_eq!(mission.read.unwrap().file, mission.path);
            let about = mission.about.unwrap();
            assert!(!about.is_empty() && !about.contains(". "), "{about}");
        }
        let vehicles = listed_vehicles();
        assert_eq!(vehicles.len(), names_in(VEHICLES).count());
        assert!(vehicles.iter().all(|vehicle| vehicle.read.is_ok() && vehicle.about.is_some()));
        let gains = listed_gains();
        assert_eq!(gains.len(), names_in(GAINS).count());
        assert!(gains.iter().all(|gains| gains.read.as_ref().unwrap().name == gains.name));
    }
}
