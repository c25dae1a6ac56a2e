//! The checkpoint of a search: what it was told so far. A search is its settings, its seed and the costs that it was told, so this is
//! all there is to keep.

use std::path::Path;

use serde::Deserialize;

use super::ConfigError;
use super::source::Source;
use crate::tune::Evaluation;

/// Everything that a search depends on: names and values, in an order.
pub type SearchIdentity = [(&'static str, String)];

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CheckpointJson {
    /// Everything that the search depends on.
    search: serde_json::Map<String, serde_json::Value>,
    /// `[rms, j_tpf, unrest]` of each candidate; null where a flight diverged.
    evaluations: Vec<Option<[f64; 3]>>,
}

/// Reads a checkpoint of this search.
///
/// # Errors
/// [`ConfigError`] when the file cannot be read, is no checkpoint or belongs to another search; then it names what differs.
pub fn load_checkpoint(path: &Path, search: &SearchIdentity) -> Result<Vec<Evaluation>, ConfigError> {
    let source = Source::read(path, "checkpoint", None)?;
    let json: CheckpointJson = source.parse()?;
    let found = |name: &str| match json.search.get(name) {
        Some(serde_json::Value::String(text)) => text.clone(),
        Some(other) => other.to_string(),
        None => "nothing".to_owned(),
    };
    let mut differences: Vec<String> = search
        .iter()
        .filter(|(name, wanted)| found(name) != *wanted)
        .map(|(name, wanted)| format!("{name} was {}, is {wanted}", found(name)))
        .collect();
    let unknown = json.search.keys().filter(|key| !search.iter().any(|(name, _)| name == key));
    differences.extend(unknown.map(|key| format!("{key} was {}, is unknown", found(key))));
    if !differences.is_empty() {
        let message = format!("the checkpoint is of another search: {}", differences.join("; "));
        return Err(source.refuse("search", message));
    }
    let evaluation = |numbers: Option<[f64; 3]>| {
        numbers.map_or(Evaluation::DIVERGED, |[rms, j_tpf, unrest]| Evaluation { rms, j_tpf, unrest })
    };
    Ok(json.evaluations.into_iter().map(evaluation).collect())
}

/// The text of a checkpoint, as [`load_checkpoint`] reads it back to the last bit.
pub fn checkpoint_json(search: &SearchIdentity, evaluations: impl Iterator<Item = Evaluation>) -> String {
    let row = |e: Evaluation| match e.is_finite() {
        true => format!("    [{:?}, {:?}, {:?}]", e.rms, e.j_tpf, e.unrest),
        false => "    null".to_owned(),
    };
    let rows: Vec<String> = evaluations.map(row).collect();
    let quoted = |text: &str| serde_json::Value::from(text).to_string();
    let fields: Vec<String> =
        search.iter().map(|(name, value)| format!("    {}: {}", quoted(name), quoted(value))).collect();
    format!(
        "{{\n  \"search\": {{\n{}\n  }},\n  \"evaluations\": [\n{}\n  ]\n}}\n",
        fields.join(",\n"),
        rows.join(",\n")
    )
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
        let mut search = [("seed", "1".to_owned()), ("start", "a \"b\"".to_owned())];
        std::fs::write(&path, checkpoint_json(&search, told.into_iter())).unwrap();
        assert_eq!(load_checkpoint(&path, &search).unwrap(), told);
        search[1].1 = "c".to_owned();
        let refused = load_checkpoint(&path, &search).unwrap_err().to_string();
        assert!(
            refused.contains("checkpoint.json:2:")
                && refused.ends_with("the checkpoint is of another search: start was a \"b\", is c"),
            "{refused}"
        );
        let fewer = load_checkpoint(&path, &search[..1]).unwrap_err().to_string();
        assert!(fewer.ends_with("start was a \"b\", is unknown"), "{fewer}");
        std::fs::write(&path, "{\"search\": {}, \"evaluations\": [[1, 2]]}").unwrap();
        assert!(load_checkpoint(&path, &[]).is_err());
    }
}
