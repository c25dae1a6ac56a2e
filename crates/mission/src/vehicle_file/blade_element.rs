//! The blades of a vehicle file, and the table of their coefficients beside it.

use std::fmt::Write as _;
use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Deserialize;

use crate::coefficient_csv;
use crate::error::ConfigError;
use crate::number::{AngleDeg, Count, Exactly, NonNegative, Positive, Within};
use crate::source::{InputHash, Source, sha256};
use samara_core::model::{Airfoil, BladeStation, Blades, CoefficientTable};
use samara_core::units::RAD_PER_DEG;

/// Known blades by blade elements and momentum theory, with the vortex ring and the windmill brake; the
/// coefficients stand in a CSV file, which `samara rotor` makes of the other keys.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct BladeElementJson {
    /// Where the blades come from.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// CSV file of the coefficients, relative to this file.
    file: String,
    /// Radius [m].
    radius_m: Positive<100>,
    /// Number of blades.
    blades: Count<1, 16>,
    /// Stations along a blade, increasing from the root cut-out to the tip, as shares of the radius; pitch
    /// and chord are linear between them.
    #[schemars(length(min = 2, max = 100))]
    radius_share: Vec<NonNegative<1>>,
    /// Chord over the radius at each station.
    #[schemars(length(min = 2, max = 100))]
    chord_share: Vec<NonNegative<2>>,
    /// Pitch of the chord against the rotor's plane at each station [deg].
    #[schemars(length(min = 2, max = 100))]
    pitch_deg: Vec<AngleDeg>,
    /// Share of the radius inside which the blades lift (tip loss); 0.97 when left out.
    tip_loss: Option<Positive<1>>,
    /// Profile of the blades.
    profile: ProfileJson,
}

/// Lift and drag of a blade's profile: a straight line of lift up to the stall, a flat plate beyond it.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct ProfileJson {
    /// Where the profile comes from.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// Slope of the lift coefficient [1/rad].
    lift_slope_per_rad: Positive<10>,
    /// Angle of attack without lift [deg]; negative for a cambered profile.
    zero_lift_deg: AngleDeg,
    /// Lift coefficients of the stall, lowest (negative) and highest.
    stall_lift: Exactly<Within<10>, 2>,
    /// Least drag coefficient.
    drag_min: Positive<1>,
    /// Lift coefficient of the least drag.
    lift_at_drag_min: Within<10>,
    /// Rise of the drag coefficient with the square of the lift coefficient.
    drag_rise: NonNegative<10>,
    /// Drag coefficient across the flow, over the least.
    drag_across: Positive<10>,
}

const TIP_LOSS: f64 = 0.97;
/// Stations of a blade at the most.
const MOST_STATIONS: usize = 100;

impl BladeElementJson {
    pub(super) fn radius_m(&self) -> f64 {
        self.radius_m.get()
    }

    pub(super) fn blades(&self, source: &Source) -> Result<Blades, ConfigError> {
        let refuse =
            |key: &str, message: String| Err(source.refuse(&format!("rotor.blade_element.{key}"), message));
        let n = self.radius_share.len();
        if !(2..=MOST_STATIONS).contains(&n) {
            return refuse("radius_share", format!("expected 2 to {MOST_STATIONS} stations, found {n}"));
        }
        for (key, found) in [("chord_share", self.chord_share.len()), ("pitch_deg", self.pitch_deg.len())] {
            if found != n {
                return refuse(key, format!("expected {n} entries, one per radius_share, found {found}"));
            }
        }
        let radii: Vec<f64> = self.radius_share.iter().map(|r| r.get()).collect();
        if let Some(i) = radii.windows(2).position(|w| w[1] <= w[0]) {
            let message = format!("the shares must increase, but {} follows {}", radii[i + 1], radii[i]);
            return refuse(&format!("radius_share[{}]", i + 1), message);
        }
        let [low, high] = self.profile.stall_lift.get();
        if !(low < 0.0 && high > 0.0) {
            let message = format!("expected a negative and a positive number, found {low} and {high}");
            return refuse("profile.stall_lift", message);
        }
        let stations: Vec<BladeStation> = radii
            .iter()
            .zip(&self.chord_share)
            .zip(&self.pitch_deg)
            .map(|((&radius_share, chord), pitch)| BladeStation {
                radius_share,
                chord_share: chord.get(),
                pitch_rad: pitch.get() * RAD_PER_DEG,
            })
            .collect();
        let profile = Airfoil {
            lift_slope: self.profile.lift_slope_per_rad.get(),
            zero_lift_rad: self.profile.zero_lift_deg.get() * RAD_PER_DEG,
            stall_lift: [low, high],
            drag_min: self.profile.drag_min.get(),
            lift_at_drag_min: self.profile.lift_at_drag_min.get(),
            drag_rise: self.profile.drag_rise.get(),
            drag_across: self.profile.drag_across.get(),
        };
        let count = u32::try_from(self.blades.get()).unwrap_or(u32::MAX);
        let tip_loss = self.tip_loss.map_or(TIP_LOSS, Positive::get);
        Blades::new(self.radius_m(), count, &stations, profile, tip_loss)
            .map_err(|e| source.refuse("rotor.blade_element", e.to_string()))
    }

    /// The blades and the file of their coefficients.
    pub(super) fn file(&self, source: &Source) -> Result<BladeFile, ConfigError> {
        let path = source.resolve(&self.file);
        Ok(BladeFile { blades: self.blades(source)?, path, sha256: self.sha256() })
    }

    /// SHA-256 of every number that the coefficients depend on.
    fn sha256(&self) -> String {
        let profile = &self.profile;
        let mut text = format!("blades {}\n", self.blades.get());
        let mut put = |name: &str, values: &[f64]| {
            // Writing to a String cannot fail.
            let _ = writeln!(text, "{name} {values:?}");
        };
        put("radius_share", &self.radius_share.iter().map(|x| x.get()).collect::<Vec<_>>());
        put("chord_share", &self.chord_share.iter().map(|x| x.get()).collect::<Vec<_>>());
        put("pitch_deg", &self.pitch_deg.iter().map(|x| x.get()).collect::<Vec<_>>());
        put("tip_loss", &[self.tip_loss.map_or(TIP_LOSS, Positive::get)]);
        put("lift_slope_per_rad", &[profile.lift_slope_per_rad.get()]);
        put("zero_lift_deg", &[profile.zero_lift_deg.get()]);
        put("stall_lift", &profile.stall_lift.get());
        put("drag_min", &[profile.drag_min.get()]);
        put("lift_at_drag_min", &[profile.lift_at_drag_min.get()]);
        put("drag_rise", &[profile.drag_rise.get()]);
        put("drag_across", &[profile.drag_across.get()]);
        sha256(&text)
    }
}

/// The coefficients of a vehicle's blades, from the file that holds them; its bytes go into `hash`.
pub(super) fn build_coefficients(
    source: &Source,
    json: &BladeElementJson,
    hash: &mut InputHash,
) -> Result<CoefficientTable, ConfigError> {
    json.blades(source)?;
    let file = Source::read(&source.resolve(&json.file), "table of rotor coefficients", Some(&source.file))?;
    let vehicle = source.file.display().to_string();
    let table = coefficient_csv::parse(&file, json.radius_m(), &json.sha256(), &vehicle)?;
    hash.absorb_named("rotor coefficients", &file);
    Ok(table)
}

/// The blades of a vehicle file, and the file of their coefficients.
#[derive(Clone, Debug)]
pub struct BladeFile {
    /// The blades.
    pub blades: Blades,
    /// Path of the file of coefficients that the vehicle names.
    pub path: PathBuf,
    sha256: String,
}

impl BladeFile {
    /// Text of the file of coefficients: a solution of blade elements and momentum theory at each of its
    /// points.
    pub fn table_text(&self) -> String {
        coefficient_csv::write(&self.blades, &self.sha256)
    }
}
