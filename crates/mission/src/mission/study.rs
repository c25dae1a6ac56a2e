//! The study: releases that gains are tuned on, and random releases.

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::Deserialize;

use crate::error::ConfigError;
use crate::number::{AngleDeg, Count, Exactly, Name, NonNegative, Positive, Within};
use crate::source::Source;
use samara_core::assess::ReleaseDistribution;
use samara_core::model::parachute::{Pendulum, TipOff};
use samara_core::model::{Environment, Parachute};
use samara_core::tune::ReleaseCase;
use samara_core::tune::release_cases::cases_of_swing;
use samara_core::units::RAD_PER_DEG;

/// Releases that the gains are tuned on.
#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct TuningJson {
    /// Where the cases come from.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// Releases by name; Table 3 for the paper's mission. Left out or empty: one without a swing and, as in
    /// that table, a swing of three standard deviations of monte_carlo at the phases 0, 36 .. 180 deg.
    #[serde(default)]
    cases: Vec<CaseJson>,
    /// Least and greatest value of each gain that is searched, the space Y of (46); around a rule for the
    /// vehicle's lag when left out.
    gains: Option<Exactly<Positive<1_000_000>, 2>>,
}

/// A state at t = 0, rotors at rest.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct CaseJson {
    /// Name of the case.
    name: Name,
    /// Velocity, NED [m/s].
    v_ned_m_s: Exactly<Within<1000>, 3>,
    /// Pitch [deg].
    pitch_deg: AngleDeg,
    /// Pitch rate [deg/s].
    pitch_rate_deg_s: Within<100_000>,
}

/// Random releases: amplitude theta_0 normal about 0, phase uniform over the turn.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct MonteCarloJson {
    /// Where the distribution comes from.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// Releases in a campaign.
    trials: Count<2, 1_000_000>,
    /// Standard deviation of the amplitude [deg].
    amplitude_sigma_deg: NonNegative<180>,
    /// Frequency of the swing [rad/s].
    omega_rad_s: NonNegative<100>,
    /// Length of the pendulum [m].
    length_m: NonNegative<1000>,
    /// Standard deviation of the wind in north and in east, about the site's, in campaigns of whole drops
    /// [m/s]; 0 when left out.
    wind_sigma_m_s: Option<NonNegative<100>>,
    /// What the cut gives the vehicle, in addition to release.tip_off; nothing when left out.
    tip_off: Option<TipOffSigmaJson>,
}

/// Random rates and velocities that the cut gives the vehicle, normal about 0. In flights from t = 0 they are
/// added to the state at t = 0.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct TipOffSigmaJson {
    /// Where the numbers come from.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// Standard deviations of the rates, body axes: roll, pitch, yaw [deg/s]; 0 when left out.
    rate_sigma_deg_s: Option<Exactly<NonNegative<10_000>, 3>>,
    /// Standard deviations of the velocity, body axes [m/s]; 0 when left out.
    velocity_sigma_m_s: Option<Exactly<NonNegative<100>, 3>>,
}

/// The releases that gains are tuned on and that a safety study draws.
#[derive(Clone, Debug)]
pub struct Study {
    /// Releases that the gains are tuned on, Table 3, at least one; each has a name of its own.
    pub cases: Vec<ReleaseCase>,
    /// Range of every gain that is searched, the space Y of (46); `None`: around a rule for the vehicle's
    /// lag.
    pub gain_range: Option<(f64, f64)>,
    /// Random releases.
    pub monte_carlo: MonteCarlo,
}

/// Random releases, (40)-(44): the swing's amplitude is normal about 0, its phase uniform over the turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MonteCarlo {
    /// Releases in a campaign.
    pub trials: usize,
    /// Standard deviation of the amplitude theta_0 [rad].
    pub amplitude_sigma_rad: f64,
    /// Frequency of the swing [rad/s].
    pub omega_rad_s: f64,
    /// Length r of the pendulum [m].
    pub length_m: f64,
    /// Standard deviation of the wind in north and in east, in campaigns of whole drops [m/s].
    pub wind_sigma_m_s: f64,
    /// Standard deviations of what the cut gives the vehicle.
    pub tip_off_sigma: TipOff,
}

impl Study {
    pub(super) fn from_json(
        source: &Source,
        tuning: &TuningJson,
        monte_carlo: &MonteCarloJson,
        parachute: Parachute,
        site: &Environment,
    ) -> Result<Self, ConfigError> {
        check_names(source, &tuning.cases)?;
        let case = |case: &CaseJson| ReleaseCase {
            name: case.name.0.clone(),
            v_ned: case.v_ned_m_s.get().into(),
            pitch_rad: case.pitch_deg.get() * RAD_PER_DEG,
            pitch_rate_rad_s: case.pitch_rate_deg_s.get() * RAD_PER_DEG,
        };
        let monte_carlo = MonteCarlo {
            trials: monte_carlo.trials.get(),
            amplitude_sigma_rad: monte_carlo.amplitude_sigma_deg.get() * RAD_PER_DEG,
            omega_rad_s: monte_carlo.omega_rad_s.get(),
            length_m: monte_carlo.length_m.get(),
            wind_sigma_m_s: monte_carlo.wind_sigma_m_s.map_or(0.0, NonNegative::get),
            tip_off_sigma: monte_carlo.tip_off.as_ref().map_or_else(TipOff::default, tip_off_sigma),
        };
        let gain_range = match tuning.gains.as_ref().map(|two| two.0.map(Positive::get)) {
            Some([least, most]) if least > most => {
                let message = format!("expected the least number first, found {least} before {most}");
                return Err(source.refuse("tuning.gains", message));
            }
            two => two.map(|[least, most]| (least, most)),
        };
        let mut cases: Vec<ReleaseCase> = tuning.cases.iter().map(case).collect();
        if cases.is_empty() {
            cases = cases_of_swing(&monte_carlo.releases(parachute, site));
        }
        Ok(Self { cases, gain_range, monte_carlo })
    }
}

fn tip_off_sigma(json: &TipOffSigmaJson) -> TipOff {
    let three = |x: &Exactly<_, 3>| Vector3::from(x.0.map(NonNegative::get));
    let rate_deg_s = json.rate_sigma_deg_s.as_ref().map_or_else(Vector3::zeros, three);
    let three = |x: &Exactly<_, 3>| Vector3::from(x.0.map(NonNegative::get));
    let v_body = json.velocity_sigma_m_s.as_ref().map_or_else(Vector3::zeros, three);
    TipOff { omega_body: rate_deg_s * RAD_PER_DEG, v_body }
}

/// A case is chosen by its name, and names the folder of its drop.
fn check_names(source: &Source, cases: &[CaseJson]) -> Result<(), ConfigError> {
    for (i, case) in cases.iter().enumerate() {
        let name = &case.name.0;
        if let Some(first) = cases[..i].iter().position(|c| c.name.0 == *name) {
            let message = format!("expected a name of its own, `{name}` is that of tuning.cases[{first}]");
            return Err(source.refuse(&format!("tuning.cases[{i}].name"), message));
        }
    }
    Ok(())
}

impl MonteCarlo {
    /// The pendulum of the random releases with this amplitude and phase [rad].
    pub(super) fn pendulum(&self, amplitude_rad: f64, phase_rad: f64) -> Pendulum {
        Pendulum { amplitude_rad, phase_rad, omega_rad_s: self.omega_rad_s, length_m: self.length_m }
    }

    /// The distribution of releases under a canopy at a site.
    pub(super) fn releases(&self, parachute: Parachute, site: &Environment) -> ReleaseDistribution {
        ReleaseDistribution {
            parachute: Parachute { pendulum: self.pendulum(0.0, 0.0), ..parachute },
            gravity_m_s2: site.gravity_m_s2,
            drift_ned_m_s: site.drift_ned_m_s(),
            amplitude_sigma_rad: self.amplitude_sigma_rad,
            tip_off_sigma: self.tip_off_sigma,
            uncertain: None,
        }
    }
}
