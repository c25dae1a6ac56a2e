//! The checkpoint of a search: what it was told so far. A search is its seed and the costs that it was told, so this is all there
//! is to keep.

use std::path::Path;

use serde::Deserialize;

use super::ConfigError;
use super::source::Source;
use crate::tune::Evaluation;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CheckpointJson {
    /// Everything that the search depends on.
    search: String,
    /// `[rms, j_tpf, unrest]` of each candidate; null where a flight diverged.
    evaluations: Vec<Option<[f64; 3]>>,
}

/// Reads a checkpoint of the search described by `search`.
///
/// # Errors
/// [`ConfigError`] when the file cannot be read, is no checkpoint or belongs to another search.
pub fn load_checkpoint(path: &Path, search: &str) -> Result<Vec<Evaluation>, ConfigError> {
    let source = Source::read(path, "checkpoint", None)?;
    let json: CheckpointJson = source.parse()?;
    if json.search != search {
        let message =
            format!("expected a checkpoint of this search ({search}), found one of another: {}", json.search);
        return Err(source.refuse("search", message));
    }
    let evaluation = |numbers: Option<[f64; 3]>| {
        numbers.map_or(Evaluation::DIVERGED, |[rms, j_tpf, unrest]| Evaluation { rms, j_tpf, unrest })
    };
    Ok(json.evaluations.into_iter().map(evaluation).collect())
}

/// The text of a checkpoint, as [`load_checkpoint`] reads it back to the last bit.
pub fn checkpoint_json(search: &str, evaluations: impl Iterator<Item = Evaluation>) -> String {
    let row = |e: Evaluation| match e.is_finite() {
        true => format!("    [{:?}, {:?}, {:?}]", e.rms, e.j_tpf, e.unrest),
        false => "    null".to_owned(),
    };
    let rows: Vec<String> = evaluations.map(row).collect();
    let search = serde_json::Value::from(search).to_string();
    format!("{{\n  \"search\": {search},\n  \"evaluations\": [\n{}\n  ]\n}}\n", rows.join(",\n"))
}

#[cfg(test)]
#[expect(clippy::disallowed_methods, reason = "a test that writes files")]
mod tests {
    use super::*;

    #[test]
    fn prop_a_checkpoint_is_read_back_to_the_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("checkpoint.json");
        let some = Evaluation { rms: 0.1 + 0.2, j_tpf: 5e-324, unrest: 0.0 };
        let told = [some, Evaluation::DIVERGED, Evaluation { rms: 1.0 / 3.0, ..some }];
        std::fs::write(&path, checkpoint_json("a \"b\"", told.into_iter())).unwrap();
        assert_eq!(load_checkpoint(&path, "a \"b\"").unwrap(), told);
        let refused = load_checkpoint(&path, "c").unwrap_err().to_string();
        assert!(
            refused.contains("checkpoint.json:2:13: search: expected a checkpoint of this search (c)"),
            "{refused}"
        );
        std::fs::write(&path, "{\"search\": \"c\", \"evaluations\": [[1, 2]]}").unwrap();
        assert!(load_checkpoint(&path, "c").is_err());
    }
}
