//! A mission: `mission/*.json`, read and checked with the vehicle and the gains that it names.
//!
//! | file | holds |
//! |---|---|
//! | `site`, `wind`, `release`, `plan`, `limits` | sections, each with its JSON, its checks and its meaning |
//! | `vortex_ring`, `control`, `study`, `battery`, `equipment`, `faults`, `px4` | sections, likewise |
//! | `design`, `replan` | how plan and gains are designed together, how plans are renewed, likewise |
//! | `effects` | the effects that it names beside the plain drop, and the mission without them |
//! | `made` | what is made of a mission: simulation, plan, study, drops |
//! | `inputs` | the hash of the files and of what was chosen beside them |
//! | `choices` | gains, parameters, cases, seeds and trajectories in place of the mission's own |
//! | `release_case` | the swing that brings a drop to one of the cases |
//! | `contradictions` | numbers that the vehicle contradicts |
//! | `study_identity` | whether the mission is the paper's study |

use std::path::{Path, PathBuf};
use std::sync::Arc;

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::Deserialize;

use crate::error::ConfigError;
use crate::estimated::{Estimated, estimated_keys};
use crate::number::{Count, Exactly, Name, SpanS, Within};
use crate::overrides::{Overrides, put_all};
use crate::shipped::{MISSIONS, is_built_in, names_in};
use crate::source::{InputHash, Source};
use crate::uncertain::{UncertainJson, uncertainty};
use crate::vehicle_file::{KnownRotor, vehicle_of};
use samara_core::design::DesignSettings;
use samara_core::model::{RotorLimits, Vehicle};
use samara_core::sim::{Battery, ElectricBattery, SensorSettings};
use samara_core::uncertain::{Deviations, Uncertainty};

mod battery;
mod choices;
mod contradictions;
mod control;
mod design;
mod drawn;
mod effects;
mod equipment;
mod faults;
mod inputs;
mod limits;
mod made;
mod plan;
mod px4;
mod release;
mod release_case;
mod replan;
mod site;
mod study;
mod study_identity;
mod vortex_ring;
mod wind;

pub use control::Control;
pub use effects::Effect;
pub use faults::{Faults, UnfitFault};
pub use inputs::Inputs;
pub use made::UnplannedError;
pub use plan::{PlanInitial, PlanSettings};
pub use px4::{Px4, Px4Clock};
pub use release::Release;
pub use release_case::CaseError;
pub use replan::{Replan, UnfitReplan};
pub use samara_core::assess::Limits;
pub use site::Site;
pub use study::{MonteCarlo, Study};

/// A drop: what falls, where, how it is released, where it shall fly to, and how that is planned, judged and
/// tuned. Paths are relative to this file. NED: north, east, down.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct MissionJson {
    /// JSON schema of the file, for editors; samara does not read it.
    #[serde(rename = "$schema")]
    _schema: Option<String>,
    /// Description of the mission, for the reader.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// Keys of this file whose numbers are estimated or guessed, neither measured nor required, as paths
    /// (`limits`, `parachute.descent_m_s`); a section's key stands for all that is in it. None: `[]`. A
    /// release card asks for their acceptance, also where this key is left out, since nobody knows then.
    estimated: Option<Vec<String>>,
    /// Name of the mission; results go to `out/NAME/`.
    name: Name,
    /// Vehicle file.
    vehicle: String,
    /// Gains file.
    gains: String,
    /// Seed of everything random.
    #[schemars(with = "u64")]
    seed: Count<0, { u64::MAX }>,
    /// Time of the simulation's start for stamps in logs [us since 1970-01-01 UTC].
    epoch_unix_us: Count<0, 4_102_444_800_000_000>,
    /// How long the simulation runs, from the start of the hang [s].
    duration_s: SpanS,
    /// Steady velocity to reach, v_cmd, NED [m/s].
    target_v_ned_m_s: Exactly<Within<1000>, 3>,
    /// Gravity, air and place.
    site: site::SiteJson,
    /// Wind by altitude, gusts and turbulence, in addition to site.wind_ned_m_s.
    #[serde(default)]
    wind: wind::WindJson,
    /// Fluctuation of rotors' thrusts in the vortex ring; without it they have their means.
    vortex_ring: Option<vortex_ring::VortexRingJson>,
    /// Descent and swing before the release, and the delay after it.
    parachute: release::ParachuteJson,
    /// When and how the vehicle is cut loose.
    release: release::ReleaseJson,
    /// The optimal control problem, (25)-(32).
    plan: plan::PlanJson,
    /// Safety limits, Table 1.
    limits: limits::LimitsJson,
    /// Limits of the cascade.
    control: control::ControlJson,
    /// Releases that the gains are tuned on.
    #[serde(default)]
    tuning: study::TuningJson,
    /// Random releases, (40)-(44).
    monte_carlo: study::MonteCarloJson,
    /// How far numbers of the vehicle, its air and its delays may be off: drawn in every campaign, study and
    /// search. A quantity that is named here has the vehicle's word for it overridden. Left out here and in
    /// the vehicle: campaigns fly what is known, and searches the program's usual ranges.
    uncertain: Option<UncertainJson>,
    /// How plan and gains are designed together.
    design: Option<design::DesignJson>,
    /// How plans are renewed during a drop, where that is asked for (`--replan`).
    replan: Option<replan::ReplanJson>,
    /// The battery; without it the vehicle flies for ever.
    battery: Option<battery::BatteryJson>,
    /// Errors of the sensors; without it they are ideal.
    sensors: Option<equipment::SensorsJson>,
    /// What fails, and when; without it nothing does.
    #[serde(default)]
    faults: faults::FaultsJson,
    /// How a PX4 that flies this mission is connected; "real" when left out.
    px4_clock: Option<Px4Clock>,
    /// Parameter file that PX4 flies this mission with; without it, or where gains are chosen, the gains in
    /// PX4's terms.
    px4_params: Option<String>,
}

/// A drop, ready to be planned and flown.
#[derive(Clone, Debug)]
pub struct Mission {
    /// Name; results go to `out/NAME/`.
    pub name: String,
    /// File of the mission; of a built-in one the path begins with `built-in:`.
    pub file: PathBuf,
    /// Name of the vehicle.
    pub vehicle_name: String,
    /// File of the vehicle.
    pub vehicle_file: PathBuf,
    /// The vehicle.
    pub vehicle: Arc<Vehicle>,
    /// Radius of its rotors [m], where the vehicle file gives one.
    pub rotor_radius_m: Option<f64>,
    /// Steady velocity to reach, v_cmd, NED [m/s].
    pub target_v_ned: Vector3<f64>,
    /// Length of the simulation, from the start of the hang [s].
    pub duration_s: f64,
    /// Time of the simulation's start [us since 1970-01-01 UTC].
    pub epoch_unix_us: u64,
    /// Seed of everything random.
    pub seed: u64,
    /// Gravity, air, place and ground.
    pub site: Site,
    /// Parachute, hang and release.
    pub release: Release,
    /// The optimal control problem.
    pub plan: PlanSettings,
    /// Limits that a flight is judged by.
    pub limits: Limits,
    /// Gains and limits of the cascade.
    pub control: Control,
    /// Cases that gains are tuned on, and random releases.
    pub study: Study,
    /// How plan and gains are designed together.
    pub design: DesignSettings,
    /// How plans are renewed, where that is asked for.
    pub replan: Replan,
    /// Errors of the sensors.
    pub sensors: SensorSettings,
    /// Whether the mission says what its satellite receiver is like.
    pub has_receiver: bool,
    /// The battery as a store of energy, if it matters and has no voltage.
    pub battery: Option<Battery>,
    /// The battery that the motors run on in drops, if it has a voltage.
    pub electric: Option<ElectricBattery>,
    /// What fails.
    pub faults: Faults,
    /// How a PX4 flies the mission.
    pub px4: Px4,
    /// Which numbers of the mission and of its vehicle are estimated.
    pub estimated: Estimated,
    /// How far what is known of the vehicle, its air and its delays may be off; `None`: nobody says.
    pub uncertain: Option<Arc<Uncertainty>>,
    /// How far it is off in the drop that is flown ([`Self::with_drop`]); not at all in the mission's own.
    pub off: Deviations,
    /// Hash of the files, and choices beside them.
    pub inputs: Inputs,
}

/// Reads a mission, its vehicle and its gains. The path is of the disk, or a built-in mission's
/// (`built-in:mission/titan_drop.json`); [`mission_path`](crate::mission_path) makes one of a name.
///
/// # Errors
/// [`ConfigError`] with the place in the file that is refused.
pub fn load_mission(path: &Path) -> Result<Mission, ConfigError> {
    load_with(path, &Overrides::default())
}

/// Reads a mission with other values of keys of its file, of its vehicle's and of its gains'.
pub(super) fn load_with(path: &Path, overrides: &Overrides) -> Result<Mission, ConfigError> {
    let mut source = Source::read(path, "mission file", None).map_err(|e| naming_the_built_in(e, path))?;
    put_all(&mut source, &overrides.mission)?;
    mission_of(&source, None, None, overrides, None)
}

/// The text of a mission file, of the disk or built in.
///
/// # Errors
/// [`ConfigError::Read`] when it cannot be read.
pub fn mission_text(path: &Path) -> Result<String, ConfigError> {
    let source = Source::read(path, "mission file", None).map_err(|e| naming_the_built_in(e, path))?;
    Ok(source.text)
}

/// A mission that is on no disk: the text of its file, and those of its vehicle and its gains where they are
/// on no disk either.
#[derive(Clone, Copy, Debug)]
pub struct MissionText<'a> {
    /// The text of the mission file.
    pub mission: &'a str,
    /// The path that the mission is read under: messages name it, and other files are relative to it.
    pub file: &'a Path,
    /// The text of the vehicle file, in place of the file that the mission names.
    pub vehicle: Option<&'a str>,
    /// The text of the gains file, in place of the file that the mission names.
    pub gains: Option<&'a str>,
}

/// Reads a mission of a text, as [`load_mission`] reads that of a file.
///
/// # Errors
/// [`ConfigError`] with the place in the text or in the file that is refused.
pub fn parse_mission(text: &MissionText<'_>) -> Result<Mission, ConfigError> {
    read_mission(text, None)
}

/// Reads a mission of a text; where the rotor is `known`, its table is not in the hash of the inputs.
pub(super) fn read_mission(
    text: &MissionText<'_>,
    known: Option<&mut KnownRotor>,
) -> Result<Mission, ConfigError> {
    let source = Source::of_text(text.mission, text.file);
    mission_of(&source, text.vehicle, text.gains, &Overrides::default(), known)
}

/// The mission of a text, whose vehicle and gains are in files unless their texts are given.
fn mission_of(
    source: &Source,
    vehicle: Option<&str>,
    gains: Option<&str>,
    overrides: &Overrides,
    known: Option<&mut KnownRotor>,
) -> Result<Mission, ConfigError> {
    let json: MissionJson = source.parse()?;
    let mut hash = InputHash::default();
    hash.absorb("mission", &source.text);
    let named = |path: &str, role: &'static str, given: Option<&str>| {
        let path = source.resolve(path);
        given.map_or_else(
            || Source::read(&path, role, Some(&source.file)),
            |text| Ok(Source::of_text(text, &path)),
        )
    };
    let mut vehicle_source = named(&json.vehicle, "vehicle file", vehicle)?;
    put_all(&mut vehicle_source, &overrides.vehicle)?;
    let mut vehicle = vehicle_of(&vehicle_source, &mut hash, known)?;
    vehicle.vehicle.latency_s = json.control.latency_s();
    let (target_v_ned, epoch_unix_us) =
        (Vector3::from(json.target_v_ned_m_s.get()), json.epoch_unix_us.get() as u64);
    let seed = json.seed.get() as u64;
    let air = (&json.site, &json.wind);
    let mut site = Site::from_json(source, air, json.release.standing(), seed, &mut hash)?;
    site.wind.ring = vortex_ring::fluctuation(source, json.vortex_ring.as_ref(), &vehicle.vehicle, seed)?;
    let replan = json.replan.as_ref().map(|replan| Replan::from_json(source, replan, &mut hash));
    let replan = replan.transpose()?.unwrap_or_default();
    let texts = [source.text.clone(), vehicle_source.text.clone()];
    let mut gains_source = named(&json.gains, "gains file", gains)?;
    put_all(&mut gains_source, &overrides.gains)?;
    let (mut inputs, gains) = Inputs::of_files(&gains_source, &overrides.gains, texts, hash)?;
    inputs.type_mission(&source.file, &overrides.all);
    overrides.all.iter().for_each(|given| inputs.note(&format!("set {}", given.key()), given.value()));
    let release =
        Release::from_json(source, &json.release, &json.parachute, &vehicle.vehicle, &site.environment)?;
    release.check_duration(source, json.duration_s.get())?;
    let faults = Faults::from_json(
        source,
        &json.faults,
        &release,
        json.duration_s.get(),
        vehicle.vehicle.rotors.len(),
    )?;
    let (battery, electric) = battery::battery(source, json.battery.as_ref(), &vehicle.vehicle)?;
    let gravity_m_s2 = site.environment.gravity_m_s2;
    let rotor_limits = || RotorLimits::of(&vehicle.vehicle, site.environment.density_kg_m3);
    let limits = json.limits.limits(&target_v_ned);
    let plan = PlanSettings::from_json(
        source,
        &json.plan,
        &target_v_ned,
        &limits.safety,
        &vehicle.vehicle,
        rotor_limits,
    )?;
    let px4 = Px4::from_json(source, json.px4_clock, json.px4_params.as_deref(), gravity_m_s2)?;
    Ok(Mission {
        name: json.name.0,
        file: source.file.clone(),
        vehicle_name: vehicle.name,
        vehicle_file: vehicle_source.file,
        vehicle: Arc::new(vehicle.vehicle),
        rotor_radius_m: vehicle.rotor_radius_m,
        estimated: Estimated {
            vehicle: vehicle.estimated,
            origins: vehicle.origins,
            mission: estimated_keys(source, json.estimated.as_ref())?,
        },
        uncertain: uncertainty(source, json.uncertain.as_ref(), vehicle.uncertain)?,
        off: Deviations::default(),
        target_v_ned,
        duration_s: json.duration_s.get(),
        epoch_unix_us,
        seed,
        plan,
        limits,
        control: Control::from_json(&json.control, gains, electric.as_ref()),
        study: Study::from_json(
            source,
            &json.tuning,
            &json.monte_carlo,
            release.parachute,
            &site.environment,
        )?,
        design: design::design(source, json.design.as_ref())?,
        replan,
        has_receiver: json.sensors.as_ref().is_some_and(equipment::SensorsJson::has_receiver),
        sensors: equipment::sensors(
            source,
            json.sensors.as_ref(),
            &site.environment,
            epoch_unix_us,
            px4.clock,
        )?,
        battery,
        electric,
        faults,
        site,
        release,
        px4,
        inputs,
    })
}

/// An error about a file that cannot be read, with the built-in mission of that name, if there is one: a path
/// as the documentation prints it leads nowhere outside the project.
fn naming_the_built_in(error: ConfigError, path: &Path) -> ConfigError {
    let stem = path.file_stem().and_then(|stem| stem.to_str()).filter(|_| !is_built_in(path));
    let name = stem.filter(|stem| names_in(MISSIONS).any(|name| name == *stem));
    match (error, name) {
        (ConfigError::Read { role, path, named_in, reason }, Some(name)) => {
            let reason = format!("{reason}; the built-in mission of that name is `{name}`");
            ConfigError::Read { role, path, named_in, reason }
        }
        (error, _) => error,
    }
}
