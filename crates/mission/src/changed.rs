//! A mission with other values of its keys, in files of its own.

use std::path::Path;

use super::designing::relative;
use super::error::ConfigError;
use super::mission::{Mission, MissionText, parse_mission};
use super::overrides::Override;
use super::set_keys::{Of, place};
use super::shipped::is_built_in;
use super::source::Source;

/// Keys of a mission that name other files.
const FILES: [&str; 5] = ["vehicle", "gains", "px4_params", "replan.gains", "wind.turbulence.noise"];
/// Keys of a vehicle that name a table.
const TABLES: [&str; 2] = ["rotor.blade_element.file", "rotor.table.file"];

/// The files of a mission in which these keys were set, under the name `name`, for a folder: names and texts
/// of the mission's, and of the vehicle's and the gains' where they differ from those that it named. All
/// stands in them as it was written, but for what was set, names, and paths where the mission is of another
/// folder.
///
/// # Errors
/// [`ConfigError`] of a text that is no mission under that name.
pub fn changed_mission_files(
    mission: &Mission,
    set: &[Override],
    name: &str,
    folder: &Path,
) -> Result<Vec<(String, String)>, ConfigError> {
    let texts = mission.input_texts(&mission.control.gains_name)?;
    let text = |of: &str| texts.iter().find(|(known, _)| known == of).map_or("", |(_, text)| text);
    let is_set = |of: Of| set.iter().any(|set| place(set).is_ok_and(|(file, _)| file == of));
    let mut whole = Source::of_text(text("mission.json"), &mission.file);
    put(&mut whole, "name", name)?;
    if is_built_in(&mission.file) || mission.file.parent() != Some(folder) {
        FILES.into_iter().try_for_each(|key| moved(&mut whole, key, folder))?;
    }
    let mut files = Vec::new();
    for (of, key, file) in
        [(Of::Vehicle, "vehicle", &mission.vehicle_file), (Of::Gains, "gains", &mission.inputs.gains_file)]
    {
        if !is_set(of) {
            continue;
        }
        let own = format!("{name}_{key}");
        let mut source = Source::of_text(text(&format!("{key}.json")), file);
        put(&mut source, "name", &own)?;
        TABLES.into_iter().try_for_each(|key| moved(&mut source, key, folder))?;
        put(&mut whole, key, &format!("{own}.json"))?;
        files.push((format!("{own}.json"), source.text));
    }
    files.insert(0, (format!("{name}.json"), whole.text));
    let text = |key: &str| files.iter().find(|(file, _)| *file == format!("{name}_{key}.json"));
    let [vehicle, gains] = ["vehicle", "gains"].map(|key| text(key).map(|(_, text)| text.as_str()));
    let file = &folder.join(format!("{name}.json"));
    parse_mission(&MissionText { mission: &files[0].1, file, vehicle, gains })?;
    Ok(files)
}

fn put(source: &mut Source, key: &str, value: &str) -> Result<(), ConfigError> {
    source.put(key, &value.into(), key).map_err(|why| source.refuse(key, why))
}

/// Has a key that names a file name it from another folder, where it does name one.
fn moved(source: &mut Source, key: &str, folder: &Path) -> Result<(), ConfigError> {
    let Some(path) = source.value(key).and_then(|value| Some(source.resolve(value.as_str()?))) else {
        return Ok(());
    };
    let path = if is_built_in(&path) { path.display().to_string() } else { relative(folder, &path) };
    put(source, key, &path)
}
