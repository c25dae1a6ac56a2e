//! The wind beside the steady one: by altitude, gusts, turbulence.

use std::sync::Arc;

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::Deserialize;

use crate::error::ConfigError;
use crate::number::{Count, Exactly, NonNegative, Positive, Within};
use crate::source::{InputHash, Source};
use crate::table;
use samara_core::model::wind::{
    Draw, Gust, GustLength, GustShape, Turbulence, TurbulenceScale, Wind, WindProfile,
};

/// Wind in addition to site.wind_ned_m_s. Plans take the mean wind at site.altitude_m; drops and campaigns
/// fly in all of it.
#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct WindJson {
    /// Where the numbers come from.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// Mean wind by altitude, in addition to site.wind_ned_m_s: linear between the entries, the outermost
    /// ones beyond them. Altitudes increase.
    #[serde(default)]
    #[schemars(length(max = 1000))]
    by_altitude: Vec<WindAtJson>,
    /// Discrete gusts, in addition to the mean wind and to each other.
    #[serde(default)]
    #[schemars(length(max = 100))]
    gusts: Vec<GustJson>,
    /// Continuous turbulence.
    turbulence: Option<TurbulenceJson>,
}

/// Mean wind at an altitude.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct WindAtJson {
    /// Altitude above mean sea level [m].
    altitude_m: Within<100_000>,
    /// Velocity of the air over ground, NED [m/s].
    wind_ned_m_s: Exactly<Within<200>, 3>,
}

/// A discrete gust. Its length is a time or a distance.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct GustJson {
    /// Remarks for the reader.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// Velocity along the gust.
    shape: GustShapeJson,
    /// Beginning, from the nominal t = 0, when the rotors are freed; negative: before [s].
    start_s: Within<100_000>,
    /// Time that it lasts; of the shape rise, that it rises [s].
    length_s: Option<Positive<100_000>>,
    /// Instead of length_s: distance that the vehicle flies through the air meanwhile [m].
    length_m: Option<Positive<100_000>>,
    /// Largest velocity of the air, NED [m/s].
    peak_ned_m_s: Exactly<Within<200>, 3>,
}

/// Velocity along a gust.
#[derive(Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum GustShapeJson {
    /// At its peak from beginning to end.
    Step,
    /// From zero to the peak and back, (1 - cos)/2 over its length: EASA CS-25.341.
    OneMinusCosine,
    /// From zero to the peak, half a cosine wave over its length, and at the peak from there on:
    /// MIL-F-8785C.
    Rise,
}

/// Continuous turbulence.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct TurbulenceJson {
    /// Where the numbers come from.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// Form of the spectra.
    #[serde(rename = "form")]
    _form: FormJson,
    /// Standard deviations of the air's velocity along the mean wind at site.altitude_m (north, where there
    /// is none), across it and vertically [m/s].
    sigma_m_s: Exactly<NonNegative<100>, 3>,
    /// Scale lengths of the eddies along the mean wind, across it and vertically [m], or a rule by height.
    scale_m: ScaleJson,
    /// Seed of the random numbers; the mission's when left out. Each trial of a campaign has its own draw.
    #[schemars(with = "Option<u64>")]
    seed: Option<Count<0, { u64::MAX }>>,
    /// CSV file of the random numbers, relative to this file, instead of drawn ones, the same in each trial:
    /// columns n_u, n_v1, n_v2, n_w1, n_w2 of mean 0 and variance 1; the first row begins the filters, each
    /// further one is a step of the simulation (4 ms in drops, 10 ms in flights from t = 0).
    noise: Option<String>,
}

/// Form of the spectra of turbulence.
#[derive(Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum FormJson {
    /// Dryden's, MIL-F-8785C.
    Dryden,
}

/// Scale lengths of turbulence.
#[derive(Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "three positive lengths [m] at most 100000, \"low_altitude\" or \"free_atmosphere\" are expected"
)]
enum ScaleJson {
    /// Lengths [m].
    Lengths(Exactly<Positive<100_000>, 3>),
    /// The rule.
    Rule(RuleJson),
}

/// Scale lengths by height.
#[derive(Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum RuleJson {
    /// By height above site.ground_altitude_m, MIL-F-8785C 3.7.3.1.
    LowAltitude,
    /// 533.4 m, all three, MIL-F-8785C 3.7.2.3.
    FreeAtmosphere,
}

const COLUMNS: [&str; 5] = ["n_u", "n_v1", "n_v2", "n_w1", "n_w2"];

/// The wind of a mission over ground at that altitude [m]; the bytes of a file of random numbers go into
/// `hash`.
pub(super) fn wind(
    source: &Source,
    json: &WindJson,
    ground_altitude_m: Option<f64>,
    mission_seed: u64,
    hash: &mut InputHash,
) -> Result<Wind, ConfigError> {
    let turbulence = json.turbulence.as_ref();
    Ok(Wind {
        profile: profile(source, &json.by_altitude)?,
        gusts: json
            .gusts
            .iter()
            .enumerate()
            .map(|(i, gust)| of_gust(source, i, gust))
            .collect::<Result<_, _>>()?,
        turbulence: turbulence
            .map(|json| of_turbulence(source, json, ground_altitude_m.is_some(), mission_seed, hash))
            .transpose()?,
        ground_altitude_m: ground_altitude_m.unwrap_or(0.0),
        ring: None,
        given: None,
    })
}

fn profile(source: &Source, entries: &[WindAtJson]) -> Result<Option<WindProfile>, ConfigError> {
    if entries.is_empty() {
        return Ok(None);
    }
    if let Some(i) = entries.windows(2).position(|e| e[1].altitude_m.get() <= e[0].altitude_m.get()) {
        let (low, next) = (entries[i].altitude_m.get(), entries[i + 1].altitude_m.get());
        let message = format!("the altitudes must increase, but {next} follows {low}");
        return Err(source.refuse(&format!("wind.by_altitude[{}].altitude_m", i + 1), message));
    }
    let entry = |e: &WindAtJson| (e.altitude_m.get(), Vector3::from(e.wind_ned_m_s.get()));
    let profile = WindProfile::new(entries.iter().map(entry).collect());
    profile.map(Some).map_err(|e| source.refuse("wind.by_altitude", e.to_string()))
}

fn of_gust(source: &Source, i: usize, json: &GustJson) -> Result<Gust, ConfigError> {
    let length = match (json.length_s.map(Positive::get), json.length_m.map(Positive::get)) {
        (Some(length_s), None) => GustLength::Time(length_s),
        (None, Some(length_m)) => GustLength::Distance(length_m),
        (given, _) => {
            let found = if given.is_some() { "both" } else { "neither" };
            let message = format!("expected one of `length_s` and `length_m`, found {found}");
            return Err(source.refuse(&format!("wind.gusts[{i}]"), message));
        }
    };
    let shape = match json.shape {
        GustShapeJson::Step => GustShape::Step,
        GustShapeJson::OneMinusCosine => GustShape::OneMinusCosine,
        GustShapeJson::Rise => GustShape::Rise,
    };
    Ok(Gust { shape, start_s: json.start_s.get(), length, peak_ned_m_s: json.peak_ned_m_s.get() })
}

fn of_turbulence(
    source: &Source,
    json: &TurbulenceJson,
    has_ground: bool,
    mission_seed: u64,
    hash: &mut InputHash,
) -> Result<Turbulence, ConfigError> {
    let scale = match &json.scale_m {
        ScaleJson::Lengths(lengths) => TurbulenceScale::Fixed(lengths.0.map(Positive::get)),
        ScaleJson::Rule(RuleJson::FreeAtmosphere) => TurbulenceScale::FreeAtmosphere,
        ScaleJson::Rule(RuleJson::LowAltitude) if has_ground => TurbulenceScale::LowAltitude,
        ScaleJson::Rule(RuleJson::LowAltitude) => {
            let message = "expected three lengths or \"free_atmosphere\" without a site.ground_altitude_m to measure the height \
                           from, found \"low_altitude\"";
            return Err(source.refuse("wind.turbulence.scale_m", message.to_owned()));
        }
    };
    let noise = json.noise.as_ref().map(|file| {
        let file = Source::read(&source.resolve(file), "table of random numbers", Some(&source.file))?;
        hash.absorb_named("turbulence noise", &file);
        noise(&file)
    });
    Ok(Turbulence {
        sigma_m_s: json.sigma_m_s.0.map(NonNegative::get),
        scale,
        seed: json.seed.map_or(mission_seed, |seed| seed.get() as u64),
        follows_mission: json.seed.is_none(),
        noise: noise.transpose()?,
    })
}

fn noise(source: &Source) -> Result<Arc<[Draw]>, ConfigError> {
    let mut lines = table::lines(source);
    let header = COLUMNS.join(",");
    let (line, found) = lines.next().unwrap_or((1, ""));
    if found != header {
        return Err(table::refuse(source, line, 1, format!("expected the header `{header}`")));
    }
    let draw = |(line, text): (usize, &str)| {
        let row = table::row(source, line, text, &COLUMNS)?;
        let numbers: Result<Draw, _> = row.values.try_into();
        numbers.map_err(|_| table::refuse(source, line, 1, "expected 5 numbers".to_owned()))
    };
    lines.map(draw).collect()
}
