//! JSON schemas of results, made from the types that write them and that the card reads.

use crate::campaign::json::AssessObject;
use crate::card::json::CardObject;
use crate::card::manifest::RunManifest;
use crate::compare::CompareObject;
use crate::designing::report::DesignObject;
use crate::effects::report::EffectsObject;
use crate::envelope::report::EnvelopeObject;
use crate::fidelity::FidelityObject;
use crate::free_fall::report::FreeFallObject;
use crate::paper::records::StudyObject;
use crate::plan_grid::report::PlanGridObject;
use crate::rare::report::{RareFailureObject, RareObject};
use crate::replan::report::ReplanObject;
use crate::sobol::report::SobolObject;
use crate::tuning::report::records::TuneObject;
use samara_mission::schema::text;
use samara_report::identified::IdentifyObject;
use samara_report::json::{CasesObject, DropObject};
use samara_report::logged_flight::LogObject;
use samara_report::manoeuvre::ManoeuvreObject;
use samara_report::plan::PlanObject;
use samara_report::verify::VerifyObject;

type Text = fn(&str) -> String;

/// Name of each kind of result, and what makes its schema.
const RESULTS: [(&str, Text); 23] = [
    ("drop", text::<DropObject>),
    ("cases", text::<CasesObject>),
    ("plan", text::<PlanObject>),
    ("assess", text::<AssessObject>),
    ("assess_paper", text::<StudyObject>),
    ("envelope", text::<EnvelopeObject>),
    ("rare", text::<RareObject>),
    ("rare_failure", text::<RareFailureObject>),
    ("design", text::<DesignObject>),
    ("tune", text::<TuneObject>),
    ("effects", text::<EffectsObject>),
    ("replan", text::<ReplanObject>),
    ("sobol", text::<SobolObject>),
    ("fidelity", text::<FidelityObject>),
    ("free_fall", text::<FreeFallObject>),
    ("plan_grid", text::<PlanGridObject>),
    ("compare", text::<CompareObject>),
    ("identify", text::<IdentifyObject>),
    ("manoeuvre", text::<ManoeuvreObject>),
    ("log", text::<LogObject>),
    ("card", text::<CardObject>),
    ("manifest", text::<RunManifest>),
    ("verify", text::<VerifyObject>),
];

/// Path below `params/schema/` and text of each result's schema.
pub fn schemas() -> Vec<(String, String)> {
    let schema = |(name, of): (&str, Text)| (format!("results/{name}.schema.json"), of(name));
    RESULTS.map(schema).into()
}

#[cfg(test)]
#[expect(clippy::disallowed_methods, reason = "a test that reads schemas and snapshots")]
mod tests {
    use std::path::Path;

    use serde::Serialize;
    use serde::de::DeserializeOwned;
    use serde_json::Value;

    use super::{AssessObject, CardObject, DropObject, PlanObject, RunManifest, schemas};
    use samara_report::json::text;

    fn root() -> &'static Path {
        Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
    }

    /// Sentences of keys that have none.
    fn unsaid(schema: &Value, of: &str, found: &mut Vec<String>) {
        for (key, value) in schema["properties"].as_object().into_iter().flatten() {
            if value["description"].as_str().is_none_or(|said| !said.ends_with(['.', ']'])) {
                found.push(format!("{of} {key}"));
            }
        }
        for (name, value) in schema["$defs"].as_object().into_iter().flatten() {
            unsaid(value, name, found);
        }
    }

    /// The schemas that are committed are those of the types, every key has its sentence, and the folder has
    /// no others.
    #[test]
    fn regress_schemas_of_results_are_current() {
        let folder = root().join("params/schema");
        let mut unsaid_keys = Vec::new();
        for (name, text) in schemas() {
            unsaid(&serde_json::from_str(&text).unwrap(), &name, &mut unsaid_keys);
            let committed = std::fs::read_to_string(folder.join(&name)).unwrap_or_default();
            assert!(committed == text, "{name} is stale: run `samara schema`");
        }
        assert_eq!(unsaid_keys, Vec::<String>::new());
        let files = std::fs::read_dir(folder.join("results")).unwrap();
        assert_eq!(files.count(), schemas().len());
    }

    /// A result that was last looked at is read as its type and written as it was.
    fn is_of<T: Serialize + DeserializeOwned>(name: &str) {
        let snapshot = root().join(format!("tests/snapshots/{name}.snap"));
        let snapshot = std::fs::read_to_string(snapshot).unwrap();
        let written = snapshot.splitn(3, "---\n").last().unwrap();
        let read: T = serde_json::from_str(written).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(text(&read), written, "{name}");
    }

    #[test]
    fn results_are_of_their_types() {
        is_of::<DropObject>("drop_json");
        is_of::<DropObject>("drop_titan_air_json");
        is_of::<PlanObject>("plan_json");
        is_of::<AssessObject>("assess_json");
        is_of::<CardObject>("card_json");
        is_of::<RunManifest>("drop_manifest");
    }
}
