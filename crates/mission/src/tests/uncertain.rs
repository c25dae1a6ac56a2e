//! The key `uncertain` of missions and vehicles.

use samara_core::uncertain::{Distribution, UncertainQuantity};

use super::spoil::{Spoilt, spoil, titan};
use super::{ConfigError, Mission, load_vehicle};

const MISSION: &str = "\"uncertain\": {
    \"mass\": { \"normal\": { \"sigma\": 0.01 } },
    \"latency_s\": { \"uniform\": [0, 0.01] },
    \"together\": [{ \"quantities\": [\"thrust\", \"drag\"], \"covariance\": [[1e-4, 0], [0, 4e-4]] }]
  },
  \"seed\": 1,";

fn of_mission(text: &str) -> Spoilt<Mission> {
    titan("\"seed\": 1,", text)
}

/// What is named is drawn, trial by trial the same; what a drop draws is what flies, read back from its
/// simulation; the mission's own drop is as the files have it.
#[test]
fn what_is_uncertain_is_drawn_and_flown() {
    let mission = of_mission(MISSION).loaded.unwrap();
    let uncertain = mission.uncertain.clone().unwrap();
    let named = [UncertainQuantity::Mass, UncertainQuantity::Drag, UncertainQuantity::Latency];
    assert_eq!(uncertain.quantities(), [&named[..], &[UncertainQuantity::Thrust]].concat());
    assert_eq!(uncertain.of(named[0]), Some(Distribution::Normal { mean: 0.0, sigma: 0.01 }));
    assert_eq!(mission.simulation().variation().0, None);
    let drop = mission.draw_drop(7);
    assert_eq!(drop, mission.draw_drop(7));
    assert_ne!(drop.off, mission.draw_drop(8).off);
    let flown = mission.with_drop(&drop);
    let (factors, latency_s) = flown.released_simulation().variation();
    let (factors, off) = (factors.unwrap(), drop.off);
    assert_eq!(factors.mass, 1.0 + off.of(UncertainQuantity::Mass));
    assert_eq!(factors.thrust, 1.0 + off.of(UncertainQuantity::Thrust));
    assert_eq!((factors.inertia, factors.density), (1.0, 1.0));
    assert!((latency_s - mission.vehicle.latency_s - off.of(UncertainQuantity::Latency)).abs() < 1e-15);
    assert_eq!(mission.releases().draw(mission.seed, 7).off, off, "flights from t = 0 draw the same");
    assert!(mission.effects().contains(&crate::Effect::Uncertain));
    assert!(mission.with_effects(&[]).draw_drop(7).off.is_none());
}

/// The swing, the wind and the noise of a drop do not know whether anything is uncertain.
#[test]
fn what_is_uncertain_changes_no_other_draw() {
    let (with, without) = (of_mission(MISSION).loaded.unwrap(), Mission::shipped("titan_paper").unwrap());
    let (a, b) = (with.draw_drop(3), without.draw_drop(3));
    assert_eq!((a.amplitude_rad, a.wind_ned_m_s, a.seed), (b.amplitude_rad, b.wind_ned_m_s, b.seed));
    assert!(without.uncertain.is_none() && b.off.is_none());
}

#[track_caller]
fn refused<T>(spoilt: Spoilt<T>, place: &str, says: &str) {
    match spoilt.loaded.err() {
        Some(ConfigError::Content { json_path, message, .. }) => {
            assert_eq!(json_path, place, "{message}");
            assert!(message.contains(says), "{message}");
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn what_makes_no_sense_is_refused_where_it_stands() {
    let refused_in_mission = |inside: &str, place: &str, says: &str| {
        refused(of_mission(&format!("\"uncertain\": {{ {inside} }}, \"seed\": 1,")), place, says);
    };
    refused_in_mission(
        "\"mass\": { \"normal\": { \"sigma\": 0.2 } }",
        "uncertain.mass",
        "a `truncated_normal`",
    );
    refused_in_mission("\"mass\": { \"uniform\": [0.1, -0.1] }", "uncertain.mass", "the least number first");
    refused_in_mission(
        "\"latency_s\": { \"uniform\": [-0.01, 0.01] }",
        "uncertain.latency_s",
        "at least 0 s",
    );
    refused_in_mission("\"drag\": { \"table\": [[0, 0], [0.9, 1]] }", "uncertain.drag", "from 0 to 1");
    let pair = |inside: &str| format!("\"together\": [{{ {inside} }}]");
    refused_in_mission(
        &pair("\"quantities\": [\"mass\", \"weight\"], \"covariance\": [[1, 0], [0, 1]]"),
        "uncertain.together[0].quantities[1]",
        "found `weight`",
    );
    refused_in_mission(
        &pair("\"quantities\": [\"mass\", \"drag\"], \"covariance\": [[1e-4, 2e-4], [2e-4, 1e-4]]"),
        "uncertain.together[0]",
        "positive definite",
    );
    let twice = "\"drag\": { \"uniform\": [-0.1, 0.1] }, ".to_owned()
        + &pair("\"quantities\": [\"mass\", \"drag\"], \"covariance\": [[1e-4, 0], [0, 1e-4]]");
    refused_in_mission(&twice, "uncertain.together[0]", "found two on `drag`");
    let wind = "\"uncertain\": { \"wind_north_m_s\": { \"uniform\": [0, 1] } }, \"mass_kg\"";
    let file = "params/vehicles/x500.json";
    refused(spoil(load_vehicle, file, file, "\"mass_kg\"", wind), "uncertain.wind_north_m_s", "a mission's");
}
