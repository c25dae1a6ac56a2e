//! Passes as a plan for QGroundControl: fast legs from place to place, nose north.

use nalgebra::Vector3;
use samara_core::manoeuvre::Kind;
use serde_json::{Value, json};

use super::ManoeuvreReport;

/// Height of passes above home [m].
const HEIGHT_M: f64 = 20.0;
/// Length of a leg, as a time at its speed [s]: from standing to standing it takes about twice as long.
const LEG_S: f64 = 5.0;
/// MAVLink's commands and the frame of heights above home.
const WAYPOINT: u16 = 16;
const TAKEOFF: u16 = 22;
const CHANGE_SPEED: u16 = 178;
const RELATIVE: u8 = 3;
const MISSION: u8 = 2;

impl ManoeuvreReport<'_> {
    /// The plan of the passes, where there are any.
    pub fn plan(&self) -> Option<String> {
        let (rounds, trial) =
            self.rounds().find(|(rounds, trial)| trial.kind == Kind::Passes && *rounds > 0)?;
        let speed = trial.sizes.speed_m_s;
        let home = self.site.anchor;
        let place = |command: u16, ne: [f64; 2]| {
            let at = self.site.geo_point(&Vector3::new(ne[0], ne[1], 0.0));
            json!([command, RELATIVE, [0, 0, 0, 0, at.latitude_deg, at.longitude_deg, HEIGHT_M]])
        };
        let mut items =
            vec![place(TAKEOFF, [0.0; 2]), json!([CHANGE_SPEED, MISSION, [1, speed, -1, 0, 0, 0, 0]])];
        let leg_m = LEG_S * speed;
        for _ in 0..rounds {
            let legs = [[leg_m, 0.0], [0.0, 0.0], [0.0, leg_m], [0.0, 0.0]];
            items.extend(legs.map(|ne| place(WAYPOINT, ne)));
        }
        let item = |(number, item): (usize, &Value)| {
            json!({
                "type": "SimpleItem", "autoContinue": true, "doJumpId": number + 1,
                "AMSLAltAboveTerrain": null, "Altitude": HEIGHT_M, "AltitudeMode": 1,
                "command": item[0], "frame": item[1], "params": item[2],
            })
        };
        let items: Vec<Value> = items.iter().enumerate().map(item).collect();
        let plan = json!({
            "fileType": "Plan", "version": 1, "groundStation": "QGroundControl",
            "geoFence": { "version": 2, "circles": [], "polygons": [] },
            "rallyPoints": { "version": 2, "points": [] },
            "mission": {
                "version": 2, "firmwareType": 12, "vehicleType": 2,
                "cruiseSpeed": speed, "hoverSpeed": speed,
                "plannedHomePosition": [home.latitude_deg, home.longitude_deg, home.altitude_m],
                "items": items,
            },
        });
        Some(serde_json::to_string_pretty(&plan).unwrap_or_default() + "\n")
    }
}
