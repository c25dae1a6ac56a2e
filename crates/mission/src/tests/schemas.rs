//! The schemas: current, with ranges, and a unit in the name of every number.

use super::schema::schemas;
use super::spoil::shipped;

#[test]
fn regress_schemas_are_current_and_show_the_ranges() {
    for (name, text) in schemas() {
        let path = shipped("params/schema").join(name);
        let committed = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(committed == text, "{name} is stale: run `samara schema`");
        assert!(
            !text.contains("\"additionalProperties\": true")
                && text.contains("\"additionalProperties\": false")
        );
    }
    for (name, text) in schemas() {
        let schema: serde_json::Value = serde_json::from_str(&text).unwrap();
        let title = name.strip_suffix(".schema.json").unwrap();
        assert_eq!(schema["$id"], format!("urn:samara:schema:{title}"));
        assert!(schema["properties"]["$schema"].is_object() && schema["additionalProperties"] == false);
    }
    let [_, (_, vehicle), _] = schemas();
    let vehicle: serde_json::Value = serde_json::from_str(&vehicle).unwrap();
    assert_eq!(vehicle["properties"]["mass_kg"]["exclusiveMinimum"], 0);
    assert_eq!(vehicle["properties"]["mass_kg"]["maximum"], 100_000);
    assert_eq!(vehicle["properties"]["inertia_kg_m2"]["maxItems"], 3);
}

/// Every number's key ends in its unit, or the number has none.
#[test]
fn every_number_in_a_schema_names_its_unit() {
    const UNITS: &[&str] = &[
        "_kg",
        "_m",
        "_m2",
        "_kg_m2",
        "_deg",
        "_deg_s",
        "_rad_s",
        "_s",
        "_m_s",
        "_m_s2",
        "_n",
        "_n_s",
        "_per_n2",
        "_kg_m3",
        "_per_s",
        "_per_s2",
        "_n_per_rad2_s2",
        "_nm",
        "_nm_a",
        "_v_s_rad",
        "_ohm",
        "_v",
        "_a",
        "_us",
        "_rad_s2",
        "_m_s3",
        "_gauss_s",
        "_hpa_s",
        // Without a unit.
        "rotor",
        "factor",
        "scale",
        "_factor",
        "efficiency",
        "nodes",
        "trials",
        "seed",
        "cost_state",
        "axis_body",
        "q_ned_from_body",
        "_wh",
        "_percent",
        "c_drag",
        "c_lift",
        "c_pitch",
        "thrust_m",
        "_hz",
        "_per_rad",
        "_share",
        "blades",
        "tries",
        "tip_loss",
        "stall_lift",
        "drag_min",
        "drag_rise",
        "drag_across",
        "_gauss",
        "_hpa",
        "_j",
        "weight",
        "peak_weights",
        "share",
        "quantile",
        "modulus",
        "draws",
        "iterations",
        "gains",
        // Of a deviation, whose key has the unit.
        "uniform",
        "mean",
        "sigma",
        "range",
        "table",
        "covariance",
    ];
    fn is_number(schema: &serde_json::Value) -> bool {
        let is = |kind: &serde_json::Value| kind == "number" || kind == "integer";
        let kind = &schema["type"];
        is(kind)
            || kind.as_array().is_some_and(|k| k.iter().any(is))
            || schema.get("items").is_some_and(is_number)
    }
    fn walk(schema: &serde_json::Value, seen: &mut usize) {
        if let Some(properties) = schema["properties"].as_object() {
            for (key, value) in properties {
                if is_number(value) {
                    *seen += 1;
                    assert!(UNITS.iter().any(|unit| key.ends_with(unit)), "{key}");
                }
            }
        }
        for child in schema
            .as_object()
            .into_iter()
            .flat_map(|o| o.values())
            .chain(schema.as_array().into_iter().flatten())
        {
            walk(child, seen);
        }
    }
    let mut seen = 0;
    for (_, text) in schemas() {
        walk(&serde_json::from_str(&text).unwrap(), &mut seen);
    }
    assert!(seen > 60, "{seen}");
}
