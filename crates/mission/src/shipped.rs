//! The files that the program brings along: missions, vehicles with their tables, gains, and PX4 parameter
//! files. They are read by the same loaders as files on disk, under paths that
//! begin with [`BUILT_IN`] (`built-in:mission/titan_drop.json`); what they name is found among them.

use std::borrow::Cow;
use std::path::{Component, Path, PathBuf};

/// Beginning of the path of a file that the program brings along.
pub const BUILT_IN: &str = "built-in:";

/// A file that the program brings along.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShippedFile {
    /// Path in the project, with `/`: `mission/titan_drop.json`.
    pub path: &'static str,
    /// Content of the file.
    pub text: &'static str,
}

macro_rules! shipped {
    ($($path:literal)*) => {
        &[$(ShippedFile { path: $path, text: include_str!(concat!("../files/", $path)) }),*]
    };
}

/// Every file, in the order of the paths; the JSON schemas, which are made from the code, are
/// [`schemas`](super::schema::schemas). Once in a program, as no constant would be.
pub static SHIPPED: &[ShippedFile] = shipped! {
    "mission/balloon_drop.json"
    "mission/dragonfly_drop.json"
    "mission/hexa_drop.json"
    "mission/octo_drop.json"
    "mission/titan_drop.json"
    "mission/titan_no_wire.json"
    "mission/titan_paper.json"
    "mission/titan_paper_linear.json"
    "mission/titan_paper_second.json"
    "mission/titan_px4.json"
    "mission/x500_drop.json"
    "mission/x500_ground.json"
    "mission/x500_no_wire.json"
    "params/gains/dragonfly.json"
    "params/gains/hexa.json"
    "params/gains/hexa_drop.json"
    "params/gains/ideal_rms.json"
    "params/gains/near_hover.json"
    "params/gains/octo_drop.json"
    "params/gains/ours.json"
    "params/gains/paper_pso.json"
    "params/gains/safety.json"
    "params/gains/titan.json"
    "params/gains/x500.json"
    "params/gains/x500_hover.json"
    "params/px4/hexa_px4_tuned.params"
    "params/px4/octo_px4_tuned.params"
    "params/px4/titan_px4.params"
    "params/px4/titan_px4_froude.params"
    "params/px4/titan_px4_froude_tuned.params"
    "params/px4/titan_samara.params"
    "params/px4/x500_px4.params"
    "params/px4/x500_px4_tuned.params"
    "params/px4/x500_samara.params"
    "params/vehicles/dragonfly_notional.json"
    "params/vehicles/hexa_4kg5.json"
    "params/vehicles/octo_8kg.json"
    "params/vehicles/titan.json"
    "params/vehicles/titan_bemt.json"
    "params/vehicles/titan_bemt_rotor.csv"
    "params/vehicles/titan_rotor.csv"
    "params/vehicles/x500.json"
    "params/vehicles/x500_rotor.csv"
};

/// Folder of the missions, in a project and among what is shipped.
pub const MISSIONS: &str = "mission";
/// Folder of the gains.
pub const GAINS: &str = "params/gains";

/// Folder of the vehicles.
pub const VEHICLES: &str = "params/vehicles";

/// Names of the JSON files of a folder, in order.
pub fn names_in(folder: &str) -> impl Iterator<Item = &'static str> + '_ {
    SHIPPED.iter().filter_map(move |file| {
        let name = file.path.strip_prefix(folder)?.strip_prefix('/')?;
        name.strip_suffix(".json").filter(|name| !name.contains('/'))
    })
}

/// The path under which a file that the program brings along is read.
pub fn built_in(folder: &str, name: &str) -> PathBuf {
    format!("{BUILT_IN}{folder}/{name}.json").into()
}

/// Whether a path is that of a file that the program brings along.
pub fn is_built_in(path: &Path) -> bool {
    inside(path).is_some()
}

/// What stands in a path behind [`BUILT_IN`].
pub(super) fn inside(path: &Path) -> Option<&str> {
    path.to_str()?.strip_prefix(BUILT_IN)
}

/// The text of a built-in file, or why there is none; `None` for a path of the disk.
pub(super) fn read(path: &Path) -> Option<Result<&'static str, String>> {
    let name = inside(path)?;
    let found = SHIPPED.iter().find(|file| file.path == name);
    Some(found.map(|file| file.text).ok_or_else(|| "no such file is built in".to_owned()))
}

/// The path that `file` names by `path`, relative to the folder that `file` lies in.
pub(super) fn resolve(file: &Path, path: &str) -> PathBuf {
    if path.starts_with(BUILT_IN) {
        return path.into();
    }
    let beside = |file: &Path| file.parent().unwrap_or(Path::new("")).join(path);
    let Some(inside) = inside(file) else { return beside(file) };
    let joined = beside(Path::new(inside));
    if joined.is_absolute() {
        return joined;
    }
    let mut parts: Vec<Cow<'_, str>> = Vec::new();
    for part in joined.components() {
        match part {
            Component::ParentDir => drop(parts.pop()),
            Component::Normal(name) => parts.push(name.to_string_lossy()),
            _ => {}
        }
    }
    format!("{BUILT_IN}{}", parts.join("/")).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_paths_resolve_as_they_do_on_a_disk() {
        let mission = Path::new("built-in:mission/titan_drop.json");
        assert_eq!(
            resolve(mission, "../params/vehicles/titan.json"),
            Path::new("built-in:params/vehicles/titan.json")
        );
        assert_eq!(
            resolve(Path::new("built-in:params/vehicles/titan.json"), "titan_rotor.csv"),
            Path::new("built-in:params/vehicles/titan_rotor.csv")
        );
        assert_eq!(resolve(Path::new("a/b.json"), "../c.json"), Path::new("a/../c.json"));
        assert!(read(Path::new("mission/titan_drop.json")).is_none());
        assert!(read(Path::new("built-in:mission/none.json")).unwrap().is_err());
    }
}
