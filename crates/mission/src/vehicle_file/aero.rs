//! The body's aerodynamics in a vehicle file.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::error::ConfigError;
use crate::number::{AngleDeg, Positive, Within};
use crate::source::Source;
use samara_core::model::BodyAero;
use samara_core::units::RAD_PER_DEG;

/// Either `drag_area_m2`, or coefficients over the angle of attack with their reference area and span; a
/// periodic cubic spline runs through the coefficients. Both may have `side_drag_area_m2` beside them.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct BodyAeroJson {
    /// Where the coefficients come from.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// Drag area at every angle of attack; without lift and moment. Stands instead of all other keys but
    /// side_drag_area_m2 [m^2].
    drag_area_m2: Option<Positive<10_000>>,
    /// Drag area of flow across the plane of symmetry, which gives a side force; where left out there is
    /// none, as in the paper [m^2].
    side_drag_area_m2: Option<Positive<10_000>>,
    /// Reference area S [m^2].
    reference_area_m2: Option<Positive<10_000>>,
    /// Reference span b [m].
    reference_span_m: Option<Positive<1000>>,
    /// Angles of attack, increasing from -180 to 180 [deg]; five do: -180, -90, 0, 90, 180.
    #[schemars(length(min = 4, max = 721))]
    alpha_deg: Option<Vec<AngleDeg>>,
    /// Drag coefficient at each angle, (13).
    c_drag: Option<Vec<Within<1000>>>,
    /// Lift coefficient at each angle, (14).
    c_lift: Option<Vec<Within<1000>>>,
    /// Pitching moment coefficient at each angle, (15).
    c_pitch: Option<Vec<Within<1000>>>,
}

/// Entries of a coefficient table: the spline's equations are solved as a full matrix of this size.
const MOST_ANGLES: usize = 721;
/// What stands for a coefficient table.
const FIVE_POINTS: &str = "from -180 to 180 deg; five points do: -180, -90, 0, 90, 180 with a coefficient each, or `drag_area_m2` alone";

/// The body's aerodynamics; none at all where the file has none.
pub(super) fn build_aero(source: &Source, json: Option<&BodyAeroJson>) -> Result<BodyAero, ConfigError> {
    let refuse = |path: &str, message: String| source.refuse(path, message);
    let of_area = |area_m2: f64, drag: f64| {
        let turn = [-180.0, -90.0, 0.0, 90.0, 180.0].map(|a: f64| a * RAD_PER_DEG);
        BodyAero::new(area_m2, 1.0, &turn, &[drag; 5], &[0.0; 5], &[0.0; 5])
            .map_err(|e| refuse("body_aero", e.to_string()))
    };
    let Some(json) = json else { return of_area(1.0, 0.0) };
    let with_side = |aero: BodyAero| match json.side_drag_area_m2 {
        None => Ok(aero),
        Some(area) => {
            aero.with_side_area(area.get()).map_err(|e| refuse("body_aero.side_drag_area_m2", e.to_string()))
        }
    };
    let others = [
        ("reference_area_m2", json.reference_area_m2.is_some()),
        ("reference_span_m", json.reference_span_m.is_some()),
        ("alpha_deg", json.alpha_deg.is_some()),
        ("c_drag", json.c_drag.is_some()),
        ("c_lift", json.c_lift.is_some()),
        ("c_pitch", json.c_pitch.is_some()),
    ];
    if let Some(area) = json.drag_area_m2 {
        return match others.iter().find(|(_, given)| *given) {
            None => with_side(of_area(area.get(), 1.0)?),
            Some((key, _)) => {
                let message =
                    format!("expected `drag_area_m2` alone, or none of it: `{key}` stands beside it");
                Err(refuse("body_aero.drag_area_m2", message))
            }
        };
    }
    let (Some(area), Some(span), Some(alpha), Some(c_drag), Some(c_lift), Some(c_pitch)) = (
        json.reference_area_m2,
        json.reference_span_m,
        &json.alpha_deg,
        &json.c_drag,
        &json.c_lift,
        &json.c_pitch,
    ) else {
        let missing = others.iter().find(|(_, given)| !given).map_or("", |(key, _)| key);
        return Err(refuse(
            "body_aero",
            format!(
                "missing field `{missing}`; expected `drag_area_m2` alone, or reference_area_m2, reference_span_m, alpha_deg, c_drag, c_lift and \
             c_pitch"
            ),
        ));
    };
    let alpha_deg: Vec<f64> = alpha.iter().map(|a| a.get()).collect();
    let n = alpha_deg.len();
    if n > MOST_ANGLES {
        let message = format!("expected at most {MOST_ANGLES} angles, one every half degree, found {n}");
        return Err(refuse("body_aero.alpha_deg", message));
    }
    if let Some(i) = alpha_deg.windows(2).position(|w| w[1] <= w[0]) {
        let message = format!("the angles must increase, but {} follows {}", alpha_deg[i + 1], alpha_deg[i]);
        return Err(refuse(&format!("body_aero.alpha_deg[{}]", i + 1), message));
    }
    if n < 4 {
        let message = format!("expected at least 4 angles {FIVE_POINTS}; found {n}");
        return Err(refuse("body_aero.alpha_deg", message));
    }
    let columns = [("c_drag", c_drag), ("c_lift", c_lift), ("c_pitch", c_pitch)];
    for (name, column) in columns {
        if column.len() != n {
            let message = format!("expected {n} entries, one per angle of alpha_deg, found {}", column.len());
            return Err(refuse(&format!("body_aero.{name}"), message));
        }
    }
    let alpha: Vec<f64> = alpha_deg.iter().map(|a| a * RAD_PER_DEG).collect();
    let [drag, lift, pitch] = columns.map(|(_, c)| c.iter().map(|x| x.get()).collect::<Vec<_>>());
    let aero = BodyAero::new(area.get(), span.get(), &alpha, &drag, &lift, &pitch);
    with_side(aero.map_err(|e| refuse("body_aero", e.to_string()))?)
}
