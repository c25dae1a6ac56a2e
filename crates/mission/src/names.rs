//! Files by name: which mission or which gains a plain name means, and what to say when it means none.

use std::path::{Path, PathBuf};

use super::error::ConfigError;
use super::shipped::{GAINS, MISSIONS, VEHICLES, built_in, inside, is_built_in, names_in};

/// The file of a mission: `name_or_path` itself when it is a path (it has a `/` or ends in `.json`);
/// otherwise `mission/NAME.json` of the current directory where there is one, else the built-in mission of
/// that name, whose path begins with `built-in:`.
///
/// # Errors
/// [`ConfigError::Unknown`] when no mission has the name.
pub fn mission_path(name_or_path: &Path) -> Result<PathBuf, ConfigError> {
    let Some(name) = plain_name(name_or_path) else { return Ok(name_or_path.to_owned()) };
    find(name, "mission file", Path::new(MISSIONS), MISSIONS)
}

/// The file of a vehicle, as [`mission_path`] finds a mission, in `params/vehicles`.
///
/// # Errors
/// [`ConfigError::Unknown`] when no vehicle has the name.
pub fn vehicle_path(name_or_path: &Path) -> Result<PathBuf, ConfigError> {
    let Some(name) = plain_name(name_or_path) else { return Ok(name_or_path.to_owned()) };
    find(name, "vehicle file", Path::new(VEHICLES), VEHICLES)
}

/// The file of gains: `name_or_path` itself when it is a path; otherwise `NAME.json` of `directory`, where
/// there is one, else the built-in gains of that name.
///
/// # Errors
/// [`ConfigError::Unknown`] when no gains have the name.
pub fn gains_path(name_or_path: &str, directory: &Path) -> Result<PathBuf, ConfigError> {
    let Some(name) = plain_name(Path::new(name_or_path)) else { return Ok(name_or_path.into()) };
    find(name, "gains file", directory, GAINS)
}

/// The text when it is a name: without a directory and without `.json`.
pub fn plain_name(name_or_path: &Path) -> Option<&str> {
    let text = name_or_path.to_str()?;
    let is_path = name_or_path.components().count() > 1
        || name_or_path.is_absolute()
        || text.contains('/')
        || text.ends_with(".json");
    (!is_path).then_some(text)
}

fn find(
    name: &str,
    role: &'static str,
    directory: &Path,
    shipped: &'static str,
) -> Result<PathBuf, ConfigError> {
    let here = directory.join(format!("{name}.json"));
    if !is_built_in(&here) && here.is_file() {
        return Ok(here);
    }
    if names_in(shipped).any(|known| known == name) {
        return Ok(built_in(shipped, name));
    }
    let mut known: Vec<String> = names_in(shipped).map(str::to_owned).collect();
    known.extend(names_of(directory));
    known.sort();
    known.dedup();
    let near = nearest(name, known.iter().map(String::as_str)).map(str::to_owned);
    let is_here = Path::new(name).exists();
    let is_here_as_json = Path::new(&format!("{name}.json")).exists();
    Err(ConfigError::Unknown {
        role,
        name: name.to_owned(),
        tried: here,
        near,
        known,
        is_here,
        is_here_as_json,
    })
}

/// The names of the JSON files of a directory, on disk or built in, in order; none if it cannot be read.
pub(super) fn names_of(directory: &Path) -> Vec<String> {
    if let Some(folder) = inside(directory) {
        return names_in(folder).map(str::to_owned).collect();
    }
    let Ok(entries) = std::fs::read_dir(directory) else { return Vec::new() };
    let paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
    let json = paths.filter(|path| path.extension().is_some_and(|e| e == "json"));
    let mut names: Vec<String> =
        json.filter_map(|path| Some(path.file_stem()?.to_str()?.to_owned())).collect();
    names.sort();
    names
}

/// The known word that was probably meant: the nearest by letters put in, left out, changed or swapped, where
/// that is at most a third of them, or the one that goes on where the word ends (`mass`, `mass_kg`). Case,
/// `-` and `_` do not count.
pub(super) fn nearest<'a>(word: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let plain = |word: &str| -> Vec<char> { word.to_lowercase().replace('-', "_").chars().collect() };
    let word = plain(word);
    let most = (word.len() / 3).max(1);
    known
        .map(|candidate| {
            let letters = plain(candidate);
            // A key without its unit.
            let begins = letters.starts_with(&word) && letters.get(word.len()) == Some(&'_');
            (if begins && word.len() > 2 { 1 } else { distance(&word, &letters) }, candidate)
        })
        .filter(|(distance, _)| *distance <= most)
        .min()
        .map(|(_, candidate)| candidate)
}

/// Damerau and Levenshtein's distance (optimal string alignment) of two words.
fn distance(a: &[char], b: &[char]) -> usize {
    let mut rows = vec![(0..=b.len()).collect::<Vec<usize>>()];
    for i in 1..=a.len() {
        let mut row = vec![i];
        for j in 1..=b.len() {
            let changed = usize::from(a[i - 1] != b[j - 1]);
            let mut least = (rows[i - 1][j] + 1).min(row[j - 1] + 1).min(rows[i - 1][j - 1] + changed);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                least = least.min(rows[i - 2][j - 2] + 1);
            }
            row.push(least);
        }
        rows.push(row);
    }
    rows[a.len()][b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_distances() {
        let of = |a: &str, b: &str| distance(&a.chars().collect::<Vec<_>>(), &b.chars().collect::<Vec<_>>());
        assert_eq!(
            [of("", "abc"), of("kitten", "sitting"), of("ab", "ba"), of("same", "same")],
            [3, 3, 1, 0]
        );
        let known = || ["near_hover", "ours", "paper_pso"].into_iter();
        assert_eq!(nearest("near-hover", known()), Some("near_hover"));
        assert_eq!(nearest("OURS", known()), Some("ours"));
        assert_eq!(nearest("papr_pso", known()), Some("paper_pso"));
        assert_eq!(nearest("zzz", known()), None);
        assert_eq!(nearest("gravity", ["density_kg_m3", "gravity_m_s2"].into_iter()), Some("gravity_m_s2"));
        assert_eq!(nearest("", known()), None);
    }

    #[test]
    fn names_and_paths_are_told_apart() {
        for path in ["./titan_drop", "titan_drop.json", "a/b", "/titan_drop"] {
            assert_eq!(mission_path(Path::new(path)).unwrap(), Path::new(path));
        }
        assert_eq!(plain_name(Path::new("titan_drop")), Some("titan_drop"));
    }
}
