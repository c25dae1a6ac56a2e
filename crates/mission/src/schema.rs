//! JSON schemas of the mission, vehicle and gains files, made from the structs that read them, so that an
//! editor can complete and check. What they cannot say (relations between numbers, the tables' contents) the
//! loader checks.

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde_json::{Map, Value};

use super::gains_file::GainsJson;
use super::mission::MissionJson;
use super::vehicle_file::VehicleJson;

/// File name under `params/schema/` and text of each schema.
pub fn schemas() -> [(&'static str, String); 3] {
    [
        ("mission.schema.json", text::<MissionJson>("mission")),
        ("vehicle.schema.json", text::<VehicleJson>("vehicle")),
        ("gains.schema.json", text::<GainsJson>("gains")),
    ]
}

/// Text of the schema of what is read from, or written to, files of this title.
pub fn text<T: JsonSchema>(title: &str) -> String {
    let generated = SchemaSettings::draft2020_12().into_generator().into_root_schema_for::<T>();
    let mut schema = Map::from_iter([
        ("$schema".to_owned(), Value::Null),
        ("$id".to_owned(), format!("urn:samara:schema:{title}").into()),
        ("title".to_owned(), title.into()),
    ]);
    for key in ["$schema", "description"] {
        schema.insert(key.to_owned(), generated.get(key).cloned().unwrap_or_default());
    }
    for (key, value) in generated.as_object().into_iter().flatten() {
        schema.entry(key).or_insert_with(|| value.clone());
    }
    // The lines of a doc comment end where the code is wide enough.
    format!("{:#}\n", Value::Object(schema)).replace("\\n", " ")
}
