//! What the vortex ring does beside the mean that blades and momentum theory give.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::error::ConfigError;
use crate::number::{Count, Positive};
use crate::source::Source;
use samara_core::model::wind::RingFluctuation;
use samara_core::model::{Rotor, Vehicle};

/// Fluctuation of the thrust of rotors in the vortex ring, inside Johnson's stability boundary. Plans and the
/// ideal plant do not have it.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct VortexRingJson {
    /// Where the numbers come from.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// Standard deviation of each rotor's thrust well inside the ring, over its mean; measured were 0.1 to
    /// 0.3.
    thrust_rms_share: Positive<1>,
    /// Corner frequency of the spectrum [Hz]. A choice, since nothing measured was found: 0.1 to 0.3 of
    /// v_h/(2 R), the induced velocity of hover over the diameter.
    frequency_hz: Positive<1000>,
    /// Seed of the random numbers; the mission's when left out. Each trial of a campaign and each rotor has
    /// its own draw.
    #[schemars(with = "Option<u64>")]
    seed: Option<Count<0, { u64::MAX }>>,
}

/// The fluctuation of a mission's vehicle.
pub(super) fn fluctuation(
    source: &Source,
    json: Option<&VortexRingJson>,
    vehicle: &Vehicle,
    mission_seed: u64,
) -> Result<Option<RingFluctuation>, ConfigError> {
    let Some(json) = json else { return Ok(None) };
    if !matches!(vehicle.rotor, Rotor::BladeElement(_)) {
        let message = "expected a vehicle whose blades are known (rotor.blade_element), since other rotors' vortex ring is not \
                       known, found one whose are not";
        return Err(source.refuse("vortex_ring", message.to_owned()));
    }
    Ok(Some(RingFluctuation {
        rms_share: json.thrust_rms_share.get(),
        frequency_hz: json.frequency_hz.get(),
        seed: json.seed.as_ref().map_or(mission_seed, |seed| seed.get() as u64),
        follows_mission: json.seed.is_none(),
        mirrored: false,
    }))
}
