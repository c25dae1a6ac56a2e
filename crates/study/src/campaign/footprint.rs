//! The footprint of a campaign: where each vehicle was when its plan ended, seen from the point of release,
//! as GeoJSON (RFC 7946, <https://www.rfc-editor.org/rfc/rfc7946>) and as KML 2.2
//! (<https://www.ogc.org/standard/kml/>), for maps.
//!
//! Latitudes and longitudes are on the sphere that the mission's local frame is laid on
//! ([`GeoPoint`]).

use std::fmt::Write as _;

use super::{CampaignReport, NamedCampaign, TrialRecord};
use samara_core::assess::outcome::J_TPF;
use samara_core::model::environment::GeoPoint;
use samara_report::html::escape;
use samara_report::json::{object, text};

/// Decimals of degrees: a hundredth of a millimetre on Earth.
const DECIMALS: usize = 10;

/// The trials that have a place, with it.
fn places<'a>(
    report: &'a CampaignReport<'_>,
    campaign: &'a NamedCampaign,
) -> impl Iterator<Item = (&'a TrialRecord, GeoPoint)> {
    let anchor = report.mission.site.environment.anchor;
    let placed =
        campaign.summary.shown.iter().filter(|t| t.outcome.way_ned_m().iter().all(|x| x.is_finite()));
    placed.map(move |t| (t, anchor.moved(&t.outcome.way_ned_m())))
}

fn rounded(x: f64) -> f64 {
    format!("{x:.DECIMALS$}").parse().unwrap_or(x)
}

/// The footprint as a GeoJSON feature collection: a point per trial, and the point of release.
pub fn geojson(report: &CampaignReport<'_>) -> String {
    let anchor = report.mission.site.environment.anchor;
    let point = |p: &GeoPoint| {
        let coordinates = [rounded(p.longitude_deg), rounded(p.latitude_deg), rounded(p.altitude_m)];
        object! { r#type: "Point", coordinates: coordinates }
    };
    let mut features = vec![serde_json::json!({
        "type": "Feature",
        "geometry": serde_json::json!(point(&anchor)),
        "properties": { "name": "release", "mission": report.mission.name },
    })];
    for campaign in &report.campaigns {
        features.extend(places(report, campaign).map(|(t, place)| {
            serde_json::json!({
                "type": "Feature",
                "geometry": serde_json::json!(point(&place)),
                "properties": {
                    "campaign": campaign.name,
                    "trial": t.trial,
                    "j_tpf": J_TPF.of(&t.outcome),
                    "north_m": t.outcome.way_north_m,
                    "east_m": t.outcome.way_east_m,
                    "altitude_lost_m": t.outcome.altitude_lost_m,
                    "failure": t.failure,
                },
            })
        }));
    }
    text(&object! { r#type: "FeatureCollection", features: features })
}

/// The footprint as KML: a folder per campaign, a placemark per trial, and the point of release.
pub fn kml(report: &CampaignReport<'_>) -> String {
    let anchor = report.mission.site.environment.anchor;
    let name = escape(&report.mission.name);
    let mut kml = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<kml xmlns=\"http://www.opengis.net/kml/2.2\">\n<Document>\n<name>{name}</name>\n"
    );
    for (id, color) in [("passed", "ffb27200"), ("failed", "ff2e1fc0"), ("release", "ff222222")] {
        let _ = writeln!(
            kml,
            "<Style id=\"{id}\"><IconStyle><color>{color}</color><scale>0.6</scale></IconStyle></Style>"
        );
    }
    placemark(&mut kml, "release", "release", "", &anchor);
    for campaign in &report.campaigns {
        let _ = writeln!(kml, "<Folder><name>{}</name>", escape(&campaign.label));
        for (t, place) in places(report, campaign) {
            let (style, words) = match &t.failure {
                None => ("passed", format!("J_TPF {:.3}", t.outcome.j_tpf)),
                Some(failure) => ("failed", failure.clone()),
            };
            placemark(&mut kml, &format!("trial {}", t.trial), style, &words, &place);
        }
        kml += "</Folder>\n";
    }
    kml + "</Document>\n</kml>\n"
}

fn placemark(kml: &mut String, name: &str, style: &str, words: &str, at: &GeoPoint) {
    // Writing to a String cannot fail.
    let _ = writeln!(
        kml,
        "<Placemark><name>{}</name><description>{}</description><styleUrl>#{style}</styleUrl>\
         <Point><altitudeMode>absolute</altitudeMode><coordinates>{:.DECIMALS$},{:.DECIMALS$},{:.3}</coordinates></Point></Placemark>",
        escape(name),
        escape(words),
        at.longitude_deg,
        at.latitude_deg,
        at.altitude_m,
    );
}
