//! How far numbers may be off, as a vehicle or a mission says it: the key `uncertain`.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::Deserialize;

use super::error::ConfigError;
use super::number::{Exactly, NonNegative, Within};
use super::source::Source;
use samara_core::uncertain::{Distribution, JointNormal, UncertainQuantity, Uncertainty};

/// How far quantities may be off what the files say, each with a distribution of its deviation: a share of
/// the vehicle's number (0.05: 5 % more), or in the unit of its key. What is left out is known.
#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct UncertainJson {
    /// Where the numbers come from.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// Mass, as a share.
    mass: Option<DistributionJson>,
    /// Moments of inertia, all alike, as a share.
    inertia: Option<DistributionJson>,
    /// Drag and side force of the body, as a share.
    drag: Option<DistributionJson>,
    /// Pitching moment of the air on the body, as a share.
    pitching_moment: Option<DistributionJson>,
    /// Density of the air, as a share; a mission's alone.
    density: Option<DistributionJson>,
    /// Steady wind to the north in addition to the site's [m/s]; a mission's alone.
    wind_north_m_s: Option<DistributionJson>,
    /// Latency from a command to the motors in addition to control.latency_s [s]; not negative.
    latency_s: Option<DistributionJson>,
    /// Delay between the release and the start of the rotors in addition to parachute.delay_s [s]; a
    /// mission's alone.
    release_delay_s: Option<DistributionJson>,
    /// Thrusts of the rotors, all alike and with their torques as they are, as a share.
    thrust: Option<DistributionJson>,
    /// Time constants of the motors, as a share.
    motor_lag: Option<DistributionJson>,
    /// Quantities that are normal together, in place of distributions of their own.
    #[serde(default)]
    together: Vec<TogetherJson>,
}

/// Distribution of a deviation.
#[derive(Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum DistributionJson {
    /// Uniform between the least and the greatest.
    Uniform(Exactly<Within<1000>, 2>),
    /// Normal.
    Normal(NormalJson),
    /// Normal, and never outside a range.
    TruncatedNormal(TruncatedNormalJson),
    /// Rows of a probability and the deviation that is not exceeded with it: probabilities ascend from 0 to
    /// 1, deviations do not descend; uniform between two rows.
    Table(Vec<Exactly<Within<1000>, 2>>),
}

/// A normal distribution.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct NormalJson {
    /// Mean; 0 when left out.
    mean: Option<Within<1000>>,
    /// Standard deviation.
    sigma: NonNegative<1000>,
}

/// A normal distribution of which only a range is drawn.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct TruncatedNormalJson {
    /// Mean before it is cut; 0 when left out.
    mean: Option<Within<1000>>,
    /// Standard deviation before it is cut.
    sigma: NonNegative<1000>,
    /// The least and the greatest that is drawn.
    range: Exactly<Within<1000>, 2>,
}

/// Quantities that are normal together.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct TogetherJson {
    /// Keys of the quantities.
    quantities: Vec<String>,
    /// Their means; 0 when left out.
    mean: Option<Vec<Within<1000>>>,
    /// Their covariance, row by row: symmetric and positive definite.
    covariance: Vec<Vec<Within<1_000_000>>>,
}

impl DistributionJson {
    fn distribution(&self) -> Distribution {
        let mean = |mean: &Option<Within<1000>>| mean.map_or(0.0, Within::get);
        match self {
            Self::Uniform(range) => Distribution::Uniform(range.get()),
            Self::Normal(normal) => {
                Distribution::Normal { mean: mean(&normal.mean), sigma: normal.sigma.get() }
            }
            Self::TruncatedNormal(cut) => Distribution::TruncatedNormal {
                mean: mean(&cut.mean),
                sigma: cut.sigma.get(),
                range: cut.range.get(),
            },
            Self::Table(rows) => Distribution::Table(rows.iter().map(|row| row.get()).collect()),
        }
    }
}

impl UncertainJson {
    fn of(&self, quantity: UncertainQuantity) -> Option<&DistributionJson> {
        let given = match quantity {
            UncertainQuantity::Mass => &self.mass,
            UncertainQuantity::Inertia => &self.inertia,
            UncertainQuantity::Drag => &self.drag,
            UncertainQuantity::PitchingMoment => &self.pitching_moment,
            UncertainQuantity::Density => &self.density,
            UncertainQuantity::Wind => &self.wind_north_m_s,
            UncertainQuantity::Latency => &self.latency_s,
            UncertainQuantity::ReleaseDelay => &self.release_delay_s,
            UncertainQuantity::Thrust => &self.thrust,
            UncertainQuantity::MotorLag => &self.motor_lag,
        };
        given.as_ref()
    }

    /// What a file says, which may speak of these quantities.
    pub(super) fn uncertainty(
        &self,
        source: &Source,
        may_name: fn(UncertainQuantity) -> bool,
    ) -> Result<Uncertainty, ConfigError> {
        let allowed = |place: &str, quantity: UncertainQuantity| {
            if may_name(quantity) {
                return Ok(());
            }
            let found = quantity.key();
            let message =
                format!("expected a quantity of the vehicle, found `{found}`, which is a mission's");
            Err(source.refuse(place, message))
        };
        let mut all = Uncertainty::none();
        for quantity in UncertainQuantity::ALL {
            let Some(json) = self.of(quantity) else { continue };
            let place = format!("uncertain.{}", quantity.key());
            allowed(&place, quantity)?;
            let checked = json.distribution().checked();
            let distribution = checked.map_err(|e| source.refuse(&place, e.to_string()))?;
            check_support(source, &place, quantity, &distribution)?;
            all = all.with(quantity, distribution);
        }
        for (i, json) in self.together.iter().enumerate() {
            let place = format!("uncertain.together[{i}]");
            let joint = json.joint(source, &place)?;
            for quantity in joint.quantities() {
                allowed(&place, *quantity)?;
                if all.of(*quantity).is_some() {
                    let message =
                        format!("expected one word on each quantity, found two on `{}`", quantity.key());
                    return Err(source.refuse(&place, message));
                }
                if let Some(alone) = joint.marginal(*quantity) {
                    check_support(source, &place, *quantity, &alone)?;
                }
            }
            all = all.with_together(joint);
        }
        Ok(all)
    }
}

impl TogetherJson {
    fn joint(&self, source: &Source, place: &str) -> Result<JointNormal, ConfigError> {
        let quantity = |(k, key): (usize, &String)| {
            UncertainQuantity::from_key(key).ok_or_else(|| {
                let known = UncertainQuantity::ALL.map(UncertainQuantity::key).join(", ");
                source.refuse(
                    &format!("{place}.quantities[{k}]"),
                    format!("expected one of {known}, found `{key}`"),
                )
            })
        };
        let quantities = self.quantities.iter().enumerate().map(quantity).collect::<Result<Vec<_>, _>>()?;
        let numbers = |all: &Vec<Within<1000>>| all.iter().map(|x| x.get()).collect();
        let mean = self.mean.as_ref().map_or_else(|| vec![0.0; quantities.len()], numbers);
        let rows: Vec<Vec<f64>> =
            self.covariance.iter().map(|row| row.iter().map(|x| x.get()).collect()).collect();
        JointNormal::new(quantities, mean, &rows).map_err(|e| source.refuse(place, e.to_string()))
    }
}

/// Nothing is drawn that makes no sense: of what has no end a range is asked for.
fn check_support(
    source: &Source,
    place: &str,
    quantity: UncertainQuantity,
    distribution: &Distribution,
) -> Result<(), ConfigError> {
    let ([least, _], allowed) = (distribution.support(), quantity.least());
    if least >= allowed {
        return Ok(());
    }
    let unit = if quantity.is_share() { " (a share of what is known)" } else { " s" };
    let mut message = format!("expected deviations of at least {allowed}{unit}, found down to {least:.3}");
    if matches!(distribution, Distribution::Normal { .. }) {
        message += ", at 8.6 standard deviations; a `truncated_normal` with a range has an end";
    }
    Err(source.refuse(place, message))
}

/// What a mission and its vehicle call uncertain: the vehicle's, overridden by the mission's. `None` where
/// neither has the key.
pub(super) fn uncertainty(
    source: &Source,
    json: Option<&UncertainJson>,
    of_vehicle: Option<Uncertainty>,
) -> Result<Option<Arc<Uncertainty>>, ConfigError> {
    let of_mission = json.map(|json| json.uncertainty(source, |_| true)).transpose()?;
    Ok(match (of_vehicle, of_mission) {
        (None, None) => None,
        (Some(one), None) | (None, Some(one)) => Some(Arc::new(one)),
        (Some(vehicle), Some(mission)) => Some(Arc::new(vehicle.overridden_by(&mission))),
    })
}
