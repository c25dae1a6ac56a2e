//! How plan and gains of the mission are designed together.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::error::ConfigError;
use crate::number::{Count, Exactly, NonNegative, Positive, SpanS, TiltDeg, Within};
use crate::source::Source;
use samara_core::design::{
    DesignBounds, DesignObjective, DesignSettings, LeastMargins, LightTurbulence, Range,
};
use samara_core::units::RAD_PER_DEG;

use super::control::TiltFromJson;
use super::plan::InputReferenceJson;

/// How `samara design` searches plan and gains together. What is left out has a default; drops, plans and
/// campaigns do not read it.
#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct DesignJson {
    /// Remarks for the reader.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// Number of the random flights that is to be small; "quantile" when left out.
    objective: Option<ObjectiveJson>,
    /// Share of the random flights that the objective "quantile" does not let exceed its number, from 0.5 to
    /// 1; 0.99 when left out.
    quantile: Option<Within<1>>,
    /// Random flights that judge each design; 200 when left out.
    draws: Option<Count<1, 100_000>>,
    /// Whether mass, inertia, air loads, density, steady wind and delays are unknown in them; true when left
    /// out.
    unknowns: Option<bool>,
    /// Turbulence in them where wind.turbulence has none; 0.5 m/s with a scale of 100 m when left out.
    turbulence: Option<LightTurbulenceJson>,
    /// Time that a flight goes on after the plan's end [s]; as long as the plan when left out.
    settle_s: Option<SpanS>,
    /// Bounds that a design keeps, beside coming to rest.
    #[serde(default)]
    bounds: BoundsJson,
    /// Ranges that are searched.
    #[serde(default)]
    search: SearchJson,
}

/// Number of the random flights that is to be small.
#[derive(Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum ObjectiveJson {
    /// A quantile of J_TPF.
    Quantile,
    /// The greatest J_TPF.
    Worst,
}

/// Turbulence in Dryden's form, alike in all directions.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct LightTurbulenceJson {
    /// Standard deviation of each component of the air's velocity [m/s]; 0: none.
    sigma_m_s: NonNegative<100>,
    /// Scale length of the eddies [m].
    scale_m: Positive<100_000>,
}

/// Bounds on a design's flights from the release cases in still air, and on its plan.
#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct BoundsJson {
    /// Time after t = 0 by which each is steady [s]; the plan's end when left out.
    steady_after_s: Option<Positive<900>>,
    /// Way down from the release to the plan's end [m].
    altitude_lost_m: Option<Positive<100_000>>,
    /// Angle between the body's up axis and the vertical [deg].
    tilt_deg: Option<Positive<180>>,
    /// Energy that the plan takes of the rotors' shafts [J].
    energy_j: Option<Positive<1_000_000_000>>,
    /// Distance of each loop's response from -1, at least: at the release, at the plan's peak and at the
    /// target, also with motors and thrusts that are off; 0.5 when left out.
    modulus: Option<Positive<1>>,
    /// Delay that takes a loop to the limit of stability, at least [s], at the same; 0.02, or a control
    /// period and twice control.latency_s, when left out.
    delay_margin_s: Option<NonNegative<10>>,
}

/// Ranges of a search: least and greatest. Equal numbers are not searched.
#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct SearchJson {
    /// Factor on plan.cost_state of q0 to q3; 0.01 to 100 when left out.
    attitude_weight: Option<Exactly<Positive<1_000_000>, 2>>,
    /// Factor on plan.cost_state of vn and ve; not searched when left out: the others are measured by it.
    horizontal_weight: Option<Exactly<Positive<1_000_000>, 2>>,
    /// Factor on plan.cost_state of vd; 0.01 to 100 when left out.
    vertical_weight: Option<Exactly<Positive<1_000_000>, 2>>,
    /// Factor on plan.cost_state of p, q and r; 0.01 to 100 when left out.
    rate_weight: Option<Exactly<Positive<1_000_000>, 2>>,
    /// Factor on the weights of the final state, on top of the others; not searched when left out.
    final_weight: Option<Exactly<Positive<1_000_000>, 2>>,
    /// Factor on plan.cost_input_per_n2; 0.01 to 100 when left out.
    input_weight: Option<Exactly<Positive<1_000_000>, 2>>,
    /// Values of plan.cost_input_reference to choose among; both when left out.
    #[schemars(length(min = 1, max = 2))]
    input_references: Option<Vec<InputReferenceJson>>,
    /// Values of plan.nodes to choose among; the mission's own, and with each interval halved, when left out.
    #[schemars(length(min = 1, max = 16))]
    nodes: Option<Vec<Count<3, 10_000>>>,
    /// Values of plan.peak.weight to choose among, 0 for none; the mission's own when left out.
    #[schemars(length(min = 1, max = 16))]
    peak_weights: Option<Vec<NonNegative<1_000_000_000>>>,
    /// Values of plan.motion.pitch_deg to choose among, null for no bound; the mission's own when left out.
    #[schemars(length(min = 1, max = 16))]
    pitch_deg: Option<Vec<Option<Positive<180>>>>,
    /// Values of plan.motion.pitch_rate_deg_s to choose among, null for no bound; the mission's own when left
    /// out.
    #[schemars(length(min = 1, max = 16))]
    pitch_rate_deg_s: Option<Vec<Option<Positive<10_000>>>>,
    /// Values of control.feed_forward to choose among; both when left out.
    #[schemars(length(min = 1, max = 2))]
    feed_forward: Option<Vec<bool>>,
    /// Values of control.tilt_from to choose among; both when left out.
    #[schemars(length(min = 1, max = 2))]
    tilt_from: Option<Vec<TiltFromJson>>,
    /// control.tilt_limit_deg; from a fifth to four fifths of limits.pitch_deg, or up to the mission's own,
    /// when left out.
    tilt_limit_deg: Option<Exactly<TiltDeg, 2>>,
    /// control.rate_command_limit_deg_s; from a fifth to four fifths of limits.pitch_rate_deg_s, or up to the
    /// mission's own, when left out.
    rate_command_limit_deg_s: Option<Exactly<Positive<100_000>, 2>>,
    /// Each of the seven longitudinal gains; around the rule for the vehicle's lag when left out.
    gains: Option<Exactly<NonNegative<1_000_000>, 2>>,
}

/// The settings of a mission's design.
pub(super) fn design(source: &Source, json: Option<&DesignJson>) -> Result<DesignSettings, ConfigError> {
    let usual = DesignSettings::default();
    let Some(json) = json else { return Ok(usual) };
    let refuse = |path: &str, message: String| source.refuse(&format!("design.{path}"), message);
    let quantile = json.quantile.map(Within::get);
    let objective = match (json.objective, quantile) {
        (Some(ObjectiveJson::Worst), None) => DesignObjective::Worst,
        (Some(ObjectiveJson::Worst), Some(_)) => {
            let message = "expected no quantile with the objective \"worst\", found one".to_owned();
            return Err(refuse("quantile", message));
        }
        (_, None) => usual.objective,
        (_, Some(p)) if (0.5..=1.0).contains(&p) => DesignObjective::Quantile(p),
        (_, Some(p)) => return Err(refuse("quantile", format!("expected 0.5 to 1, found {p}"))),
    };
    let ordered = |key: &str, [least, most]: [f64; 2]| {
        if least <= most {
            return Ok(Range { least, most });
        }
        let message = format!("expected the least number first, found {least} before {most}");
        Err(refuse(&format!("search.{key}"), message))
    };
    let factor = |key: &str, given: &Option<Exactly<Positive<1_000_000>, 2>>, usual: Range| {
        given.as_ref().map_or(Ok(usual), |two| ordered(key, two.0.map(Positive::get)))
    };
    let range = |key: &str, given: Option<[f64; 2]>| given.map(|two| ordered(key, two)).transpose();
    let in_radians = |Range { least, most }| Range { least: least * RAD_PER_DEG, most: most * RAD_PER_DEG };
    let search = &json.search;
    let [attitude, horizontal, vertical, rates] = usual.weights;
    Ok(DesignSettings {
        objective,
        draws: json.draws.map_or(usual.draws, Count::get),
        unknowns: json.unknowns.unwrap_or(usual.unknowns),
        turbulence: json.turbulence.as_ref().map_or(usual.turbulence, |json| LightTurbulence {
            sigma_m_s: json.sigma_m_s.get(),
            scale_m: json.scale_m.get(),
        }),
        settle_s: json.settle_s.map(SpanS::get),
        bounds: DesignBounds {
            most: [
                json.bounds.steady_after_s.map(Positive::get),
                json.bounds.altitude_lost_m.map(Positive::get),
                json.bounds.tilt_deg.map(|tilt| tilt.get()),
            ],
            energy_j: json.bounds.energy_j.map(Positive::get),
            margins: LeastMargins {
                modulus: json.bounds.modulus.map(Positive::get),
                delay_s: json.bounds.delay_margin_s.map(NonNegative::get),
            },
        },
        weights: [
            factor("attitude_weight", &search.attitude_weight, attitude)?,
            factor("horizontal_weight", &search.horizontal_weight, horizontal)?,
            factor("vertical_weight", &search.vertical_weight, vertical)?,
            factor("rate_weight", &search.rate_weight, rates)?,
        ],
        final_weight: factor("final_weight", &search.final_weight, usual.final_weight)?,
        input_weight: factor("input_weight", &search.input_weight, usual.input_weight)?,
        input_references: choices(source, "input_references", &search.input_references, |json| {
            (*json).into()
        })?
        .unwrap_or(usual.input_references),
        nodes: choices(source, "nodes", &search.nodes, |n| n.get())?.unwrap_or_default(),
        peak_weights: choices(source, "peak_weights", &search.peak_weights, |x| x.get())?.unwrap_or_default(),
        pitch_rad: choices(source, "pitch_deg", &search.pitch_deg, |x| {
            x.as_ref().map(|x| x.get() * RAD_PER_DEG)
        })?
        .unwrap_or_default(),
        pitch_rate_rad_s: choices(source, "pitch_rate_deg_s", &search.pitch_rate_deg_s, |x| {
            x.as_ref().map(|x| x.get() * RAD_PER_DEG)
        })?
        .unwrap_or_default(),
        feed_forward: choices(source, "feed_forward", &search.feed_forward, |ahead| *ahead)?
            .unwrap_or(usual.feed_forward),
        tilt_from: choices(source, "tilt_from", &search.tilt_from, |json| (*json).into())?
            .unwrap_or(usual.tilt_from),
        tilt_rad: range("tilt_limit_deg", search.tilt_limit_deg.as_ref().map(|two| two.0.map(TiltDeg::get)))?
            .map(in_radians),
        rate_command_rad_s: range(
            "rate_command_limit_deg_s",
            search.rate_command_limit_deg_s.as_ref().map(|two| two.0.map(Positive::get)),
        )?
        .map(in_radians),
        gains: range("gains", search.gains.as_ref().map(|two| two.0.map(NonNegative::get)))?,
    })
}

/// What is given to choose among, at least one; `None` when it is left out.
fn choices<J, T>(
    source: &Source,
    key: &str,
    given: &Option<Vec<J>>,
    of: impl Fn(&J) -> T,
) -> Result<Option<Vec<T>>, ConfigError> {
    match given {
        None => Ok(None),
        Some(given) if given.is_empty() => {
            let message = "expected at least one, found none".to_owned();
            Err(source.refuse(&format!("design.search.{key}"), message))
        }
        Some(given) => Ok(Some(given.iter().map(of).collect())),
    }
}
