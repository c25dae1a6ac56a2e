//! How plans are renewed during a drop, where that is asked for.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::error::ConfigError;
use crate::gains_file::{GainsFile, gains_of};
use crate::number::{Count, SpanS};
use crate::source::{InputHash, Source};
use samara_core::plan::Demands;
use samara_core::replan::{Cadence, ReplanSettings};

/// How plans are renewed with `--replan`. What is left out has a default; without `--replan` nothing reads
/// it.
#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ReplanJson {
    /// Remarks for the reader.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// Time from a measurement until the plan made of it takes effect; 0.02 when left out [s].
    latency_s: Option<SpanS>,
    /// Most iterations of a solve; 50 when left out.
    iterations: Option<Count<1, 1000>>,
    /// Latest time after t = 0 at which a renewed plan takes effect; 0.4 of `plan.horizon_s` when left out
    /// [s].
    until_s: Option<SpanS>,
    /// Gains file that is flown with `--replan`, where no other gains are chosen; the mission's own gains
    /// when left out.
    gains: Option<String>,
}

/// How plans are renewed where that is asked for.
#[derive(Clone, Debug, Default)]
pub struct Replan {
    /// Latency and bound on the iterations.
    pub settings: ReplanSettings,
    /// Gains that are flown with renewed plans; `None`: the mission's own.
    pub gains: Option<GainsFile>,
}

/// Why the plan of a mission is not renewed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum UnfitReplan {
    /// The mission has no drop.
    #[error("--replan renews the plan of a drop, and this mission begins on the ground")]
    Standing,
    /// A demand on the plan that a renewed plan cannot keep.
    #[error("{key}: {why}")]
    Demand {
        /// Key of the demand.
        key: &'static str,
        /// Why not.
        why: &'static str,
    },
    /// The next measurement would come before the plan made of the last takes effect.
    #[error(
        "--replan {hz}: at most {most_hz} Hz is expected: a plan takes effect {latency_s} s after its measurement (replan.latency_s)"
    )]
    Rate {
        /// The rate that was asked for [Hz].
        hz: f64,
        /// The greatest rate [Hz].
        most_hz: f64,
        /// The latency [s].
        latency_s: f64,
    },
}

impl Replan {
    /// Whether a plan with these demands can be renewed at this cadence.
    pub(super) fn check(&self, cadence: Cadence, demands: &Demands) -> Result<(), UnfitReplan> {
        if demands.horizon.is_some() {
            let why = "with --replan the plan's end is expected to be given: renewed plans share it";
            return Err(UnfitReplan::Demand { key: "plan.free_horizon", why });
        }
        let Cadence::Hz(hz) = cadence else { return Ok(()) };
        if demands.motion.altitude_lost_m.is_some() {
            let why = "it counts from t = 0, and a plan that begins later does not know what was lost before: --replan \
                       release is expected with it";
            return Err(UnfitReplan::Demand { key: "plan.motion.altitude_lost_m", why });
        }
        let latency_s = self.settings.latency_s;
        if hz * latency_s > 1.0 + 1e-9 {
            return Err(UnfitReplan::Rate { hz, most_hz: 1.0 / latency_s, latency_s });
        }
        Ok(())
    }

    pub(super) fn from_json(
        source: &Source,
        json: &ReplanJson,
        hash: &mut InputHash,
    ) -> Result<Self, ConfigError> {
        let usual = ReplanSettings::default();
        let gains = json.gains.as_ref().map(|gains| {
            let path = source.resolve(gains);
            let file = Source::read(&path, "gains file of replan", Some(&source.file))?;
            hash.note("gains of renewed plans", &file);
            gains_of(&file, hash)
        });
        Ok(Self {
            settings: ReplanSettings {
                latency_s: json.latency_s.map_or(usual.latency_s, SpanS::get),
                iterations: json.iterations.map_or(usual.iterations, Count::get),
                until_s: json.until_s.map(SpanS::get),
            },
            gains: gains.transpose()?,
        })
    }
}
