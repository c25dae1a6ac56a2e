//! The checkpoint of a search: its settings, its seed and the evaluations so far, which determine how it goes
//! on.

use core::fmt::Debug;
use std::path::Path;

use serde::de::{DeserializeOwned, IgnoredAny};
use serde::{Deserialize, Serialize};

use super::error::ConfigError;
use super::source::Source;
use samara_core::design::Judgement;
use samara_core::tune::Evaluation;

/// Everything that a search depends on: names and values, in an order.
pub type SearchIdentity = [(&'static str, String)];

/// Evaluation of a candidate in a search: numbers, or a flight that was lost.
pub trait Evaluated: Sized {
    /// The numbers as they stand in the file.
    type Numbers: DeserializeOwned + Debug;

    /// The numbers; `None` where a flight was lost.
    fn numbers(&self) -> Option<Self::Numbers>;

    /// Back from what stands in the file.
    fn of(numbers: Option<Self::Numbers>) -> Self;
}

/// The evaluation of gains: `[rms, j_tpf, unrest]`.
impl Evaluated for Evaluation {
    type Numbers = [f64; 3];

    fn numbers(&self) -> Option<[f64; 3]> {
        self.is_finite().then_some([self.rms, self.j_tpf, self.unrest])
    }

    fn of(numbers: Option<[f64; 3]>) -> Self {
        numbers.map_or(Self::DIVERGED, |[rms, j_tpf, unrest]| Self { rms, j_tpf, unrest })
    }
}

/// The judgement on a design: `[j_tpf, mean, steady_share, worst, unsafe, unrest, steady_after_s,
/// altitude_lost_m, tilt_deg, energy_j, modulus, delay_s, flights]`.
impl Evaluated for Judgement {
    type Numbers = [f64; 13];

    fn numbers(&self) -> Option<[f64; 13]> {
        let [steady_after_s, altitude_lost_m, tilt_deg] = self.most;
        self.is_planned().then_some([
            self.j_tpf,
            self.mean,
            self.steady_share,
            self.worst,
            self.over_limit,
            self.unrest,
            steady_after_s,
            altitude_lost_m,
            tilt_deg,
            self.energy_j,
            self.modulus,
            self.delay_s,
            self.flights,
        ])
    }

    fn of(numbers: Option<[f64; 13]>) -> Self {
        let Some(numbers) = numbers else { return Self::UNPLANNED };
        let [j_tpf, mean, steady_share, worst, over_limit, unrest, steady_after_s, rest @ ..] = numbers;
        let [altitude_lost_m, tilt_deg, energy_j, modulus, delay_s, flights] = rest;
        Self {
            j_tpf,
            mean,
            steady_share,
            worst,
            over_limit,
            unrest,
            most: [steady_after_s, altitude_lost_m, tilt_deg],
            energy_j,
            modulus,
            delay_s,
            flights,
        }
    }
}

/// A cost; what is not finite is that of a lost flight.
impl Evaluated for f64 {
    type Numbers = Self;

    fn numbers(&self) -> Option<Self> {
        self.is_finite().then_some(*self)
    }

    fn of(numbers: Option<Self>) -> Self {
        numbers.unwrap_or(Self::INFINITY)
    }
}

/// What a search asks others for, beside its checkpoint: to judge the candidates that follow from it.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Asked {
    /// The command line that began the search, from the verb on.
    pub arguments: Vec<String>,
    /// The folder that its paths are relative to.
    pub folder: String,
    /// Number of candidates to be judged.
    pub candidates: usize,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CheckpointJson<E> {
    /// Everything that the search depends on.
    search: serde_json::Map<String, serde_json::Value>,
    /// What is asked for, in a file for others.
    #[serde(default)]
    asked: Option<Asked>,
    /// Evaluation of each candidate; null where a flight was lost.
    evaluations: E,
}

/// Reads a checkpoint of this search.
///
/// # Errors
/// [`ConfigError`] when the file cannot be read, is no checkpoint or belongs to another search; then it names
/// what differs.
pub fn load_checkpoint<T: Evaluated>(path: &Path, search: &SearchIdentity) -> Result<Vec<T>, ConfigError> {
    let source = Source::read(path, "checkpoint", None)?;
    // Whose it is comes first: another search's evaluations may be of another form.
    let whose: CheckpointJson<IgnoredAny> = source.parse()?;
    let found = |name: &str| match whose.search.get(name) {
        Some(serde_json::Value::String(text)) => text.clone(),
        Some(other) => other.to_string(),
        None => "nothing".to_owned(),
    };
    let mut differences: Vec<String> = search
        .iter()
        .filter(|(name, wanted)| found(name) != *wanted)
        .map(|(name, wanted)| format!("{name} was {}, is {wanted}", found(name)))
        .collect();
    let unknown = whose.search.keys().filter(|key| !search.iter().any(|(name, _)| name == key));
    differences.extend(unknown.map(|key| format!("{key} was {}, is unknown", found(key))));
    if !differences.is_empty() {
        let message = format!(
            "what was judged is of another search (--out takes another folder): {}",
            differences.join("; ")
        );
        return Err(source.refuse("search", message));
    }
    let json: CheckpointJson<Vec<Option<T::Numbers>>> = source.parse()?;
    Ok(json.evaluations.into_iter().map(T::of).collect())
}

/// Reads what a search asks others for.
///
/// # Errors
/// [`ConfigError`] when the file cannot be read or asks for nothing.
pub fn load_asked(path: &Path) -> Result<Asked, ConfigError> {
    let source = Source::read(path, "candidates file", None)?;
    let json: CheckpointJson<IgnoredAny> = source.parse()?;
    let expected =
        "`asked` is expected: candidates.json as `samara design --ask` or `samara tune --ask` writes it";
    json.asked.ok_or_else(|| source.refuse("", expected.to_owned()))
}

/// The text of a checkpoint, as [`load_checkpoint`] reads it back to the last bit.
pub fn checkpoint_json<T: Evaluated>(search: &SearchIdentity, evaluations: &[T]) -> String {
    text(search, None, evaluations)
}

/// The text of a checkpoint with what is asked of others, as [`load_asked`] and [`load_checkpoint`] read it
/// back.
pub fn candidates_json<T: Evaluated>(search: &SearchIdentity, asked: &Asked, evaluations: &[T]) -> String {
    text(search, Some(asked), evaluations)
}

fn text<T: Evaluated>(search: &SearchIdentity, asked: Option<&Asked>, evaluations: &[T]) -> String {
    let row = |t: &T| t.numbers().map_or("    null".to_owned(), |numbers| format!("    {numbers:?}"));
    let rows: Vec<String> = evaluations.iter().map(row).collect();
    let quoted = |text: &str| serde_json::Value::from(text).to_string();
    let fields: Vec<String> =
        search.iter().map(|(name, value)| format!("    {}: {}", quoted(name), quoted(value))).collect();
    let asked =
        asked.map_or_else(String::new, |asked| format!("  \"asked\": {},\n", serde_json::json!(asked)));
    format!(
        "{{\n  \"search\": {{\n{}\n  }},\n{asked}  \"evaluations\": [\n{}\n  ]\n}}\n",
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
        let evaluations = [some, Evaluation::DIVERGED, Evaluation { rms: 1.0 / 3.0, ..some }];
        let mut search = [("seed", "1".to_owned()), ("start", "a \"b\"".to_owned())];
        std::fs::write(&path, checkpoint_json(&search, &evaluations)).unwrap();
        assert_eq!(load_checkpoint::<Evaluation>(&path, &search).unwrap(), evaluations);
        search[1].1 = "c".to_owned();
        let refused = load_checkpoint::<Evaluation>(&path, &search).unwrap_err().to_string();
        assert!(
            refused.contains("checkpoint.json:2:")
                && refused.ends_with("what was judged is of another search (--out takes another folder): start was a \"b\", is c"),
            "{refused}"
        );
        let fewer = load_checkpoint::<Evaluation>(&path, &search[..1]).unwrap_err().to_string();
        assert!(fewer.ends_with("start was a \"b\", is unknown"), "{fewer}");
    }

    #[test]
    fn prop_costs_are_read_back_to_the_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("checkpoint.json");
        let search = [("seed", "1".to_owned())];
        std::fs::write(&path, checkpoint_json(&search, &[0.1 + 0.2, f64::INFINITY, 1e300, 5e-324])).unwrap();
        let evaluations: Vec<f64> = load_checkpoint(&path, &search).unwrap();
        assert_eq!(evaluations, [0.1 + 0.2, f64::INFINITY, 1e300, 5e-324]);
    }

    #[test]
    fn prop_what_is_asked_is_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("candidates.json");
        let search = [("seed", "1".to_owned())];
        let arguments = ["design", "a b/m.json", "--name", "x\"y"].map(str::to_owned).to_vec();
        let asked = Asked { arguments, folder: "/c d".to_owned(), candidates: 3 };
        std::fs::write(&path, candidates_json(&search, &asked, &[0.1 + 0.2])).unwrap();
        assert_eq!(load_asked(&path).unwrap(), asked);
        assert_eq!(load_checkpoint::<f64>(&path, &search).unwrap(), [0.1 + 0.2]);
        std::fs::write(&path, checkpoint_json(&search, &[1.0])).unwrap();
        assert!(load_asked(&path).unwrap_err().to_string().contains("`samara design --ask`"));
    }

    /// The place of a wrong number is reported; whose the checkpoint is comes before the form of its numbers.
    #[test]
    fn evaluations_of_another_form_are_refused_with_their_place() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("checkpoint.json");
        std::fs::write(&path, "{\"search\": {},\n \"evaluations\": [[1, 2, 3],\n [1, 2]]}").unwrap();
        let short = load_checkpoint::<Evaluation>(&path, &[]).unwrap_err().to_string();
        assert!(short.contains("checkpoint.json:3:2") && short.contains("evaluations[1]"), "{short}");
        let costs = load_checkpoint::<f64>(&path, &[]).unwrap_err().to_string();
        assert!(costs.contains("checkpoint.json:2:18") && costs.contains("evaluations[0]"), "{costs}");
        let other = load_checkpoint::<f64>(&path, &[("for", "px4".to_owned())]).unwrap_err().to_string();
        assert!(
            other.ends_with(
                "what was judged is of another search (--out takes another folder): for was nothing, is px4"
            ),
            "{other}"
        );
    }
}
