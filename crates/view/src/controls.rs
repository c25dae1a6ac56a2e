//! The keys that matter most, and what is known of every key: values, units and ranges from the files and
//! their schemas.

use serde::Serialize;
use serde_json::{Map, Value};

use super::campaign::DROPS_MOST;
use super::viewed::{Refused, Viewed};
use samara_core::math;
use samara_mission::{Mission, SettableKey, is_of_vehicle, settable_keys};
use samara_report::json::object;

/// Where a control begins and ends, within what the schema allows.
#[derive(Clone, Copy, Debug)]
enum Span {
    /// From one number to another.
    Of(f64, f64),
    /// From one multiple of the mission's own value to another.
    Times(f64, f64),
}
use Span::{Of, Times};

/// A key that has a control of its own.
struct Control {
    group: &'static str,
    label: &'static str,
    key: &'static str,
    span: Span,
    /// What the absence of the key means; without a meaning there is no control then.
    absent: Option<&'static str>,
}

/// The controls, in the order of the page: label, key and span of each, and behind `or` what the absence of
/// the key means.
macro_rules! controls {
    ($($group:literal { $($label:literal $key:literal $span:expr $(, or $absent:literal)?;)* })*) => {
        &[$($(Control {
            group: $group, label: $label, key: $key, span: $span, absent: [$(Some($absent),)? None][0],
        }),*),*]
    };
}

const CONTROLS: &[Control] = controls! {
    "Release" {
        "Altitude" "site.altitude_m" Of(0.0, 5000.0);
        "Ground" "site.ground_altitude_m" Of(0.0, 5000.0), or "no ground";
        "Descent" "parachute.descent_m_s" Times(0.5, 2.0);
        "Swing" "parachute.pendulum.amplitude_deg" Of(0.0, 30.0);
        "Phase of the swing" "parachute.pendulum.phase_deg" Of(0.0, 360.0);
        "Delay of the rotors" "parachute.delay_s" Of(0.0, 5.0);
    }
    "Air" {
        "Wind to the north" "site.wind_ned_m_s[0]" Of(-15.0, 15.0);
        "Wind to the east" "site.wind_ned_m_s[1]" Of(-15.0, 15.0);
        "Turbulence, level" "wind.turbulence.sigma_m_s[0]" Of(0.0, 4.0);
        "Turbulence, vertical" "wind.turbulence.sigma_m_s[2]" Of(0.0, 4.0);
    }
    "Vehicle" {
        "Mass" "mass_kg" Times(0.5, 2.0);
        "Greatest rotor speed" "motor.first_order.omega_max_rad_s" Times(0.5, 2.0);
        "Greatest rotor speed" "motor.esc_dc.omega_max_rad_s" Times(0.5, 2.0);
        "Greatest thrust, planned" "plan.thrust_max_n" Times(0.5, 2.0);
        "Battery" "battery.charge_percent" Of(0.0, 100.0);
    }
    "Target and limits" {
        "Target to the north" "target_v_ned_m_s[0]" Of(-10.0, 10.0);
        "Target downwards" "target_v_ned_m_s[2]" Of(-5.0, 10.0);
        "Tilt, commanded" "control.tilt_limit_deg" Of(1.0, 89.0);
        "Pitch, judged" "limits.pitch_deg" Of(5.0, 180.0);
        "Speed, judged" "limits.speed_m_s" Times(0.25, 4.0);
    }
    "Gains" {
        "Rate" "gains.k_pq_per_s" Times(0.0, 4.0);
        "Rate, integral" "gains.k_iq_per_s2" Times(0.0, 4.0);
        "Attitude" "gains.k_ptheta_per_s" Times(0.0, 4.0);
        "Vertical velocity" "gains.k_pvz_per_s" Times(0.0, 4.0);
        "Vertical velocity, integral" "gains.k_ivz_per_s2" Times(0.0, 4.0);
        "Level velocity" "gains.k_pvx_per_s" Times(0.0, 4.0);
        "Level velocity, integral" "gains.k_ivx_per_s2" Times(0.0, 4.0);
    }
};

/// Steps of a control, about.
const STEPS: f64 = 200.0;

impl Control {
    /// The control of a mission; `None` where the key is not there and that means nothing.
    fn shown(&self, texts: &Texts) -> Option<impl Serialize + use<>> {
        let value = texts.value(self.key).and_then(Value::as_f64);
        if value.is_none() && self.absent.is_none() {
            return None;
        }
        let known = known(self.key)?;
        let own = value.unwrap_or(0.0);
        let (from, to) = match self.span {
            Of(from, to) => (from, to),
            // Of nothing there is no multiple.
            Times(from, to) if own == 0.0 => (from, to),
            Times(from, to) => (from * own, to * own),
        };
        let (from, to) = (from.min(own), to.max(own));
        let minimum = known.minimum.map_or(from, |least| from.max(least));
        let maximum = known.maximum.map_or(to, |most| to.min(most));
        Some(object! {
            key: self.key,
            label: self.label,
            unit: known.unit.as_deref(),
            group: self.group,
            minimum: minimum,
            maximum: maximum,
            step: round((maximum - minimum) / STEPS),
            value: value,
            absent: self.absent,
        })
    }
}

/// The nearest smaller one of 1, 2 and 5 times a power of ten.
fn round(step: f64) -> f64 {
    if !(step > 0.0) {
        return 1.0;
    }
    let exponent = (math::ln(step) / std::f64::consts::LN_10 + 1e-9).floor() as i32;
    // A decimal fraction as it is written.
    let power = |digit: u8| format!("{digit}e{exponent}").parse().unwrap_or(step);
    [5, 2, 1].into_iter().map(power).find(|power| *power <= step * (1.0 + 1e-9)).unwrap_or(step)
}

/// The key of this path, or the list that a path like `target_v_ned_m_s[0]` is in.
fn known(path: &str) -> Option<&'static SettableKey> {
    let of = |path: &str| settable_keys().find(|key| key.path == path);
    of(path).or_else(|| of(path.strip_suffix(']')?.rsplit_once('[')?.0))
}

/// The files of a mission as JSON.
struct Texts {
    mission: Value,
    vehicle: Value,
    gains: Value,
}

impl Texts {
    fn of(mission: &Mission) -> Result<Self, Refused> {
        let texts = mission.input_texts(&mission.control.gains_name)?;
        let of = |name: &str| {
            let text = texts.iter().find(|(known, _)| known == name).map_or("", |(_, text)| text);
            serde_json::from_str(text).unwrap_or_default()
        };
        Ok(Self { mission: of("mission.json"), vehicle: of("vehicle.json"), gains: of("gains.json") })
    }

    /// The value at a key as `--set` takes it.
    fn value(&self, key: &str) -> Option<&Value> {
        let given = format!("{key}=0").parse().ok()?;
        let (file, path) = match key.strip_prefix("gains.") {
            Some(path) => (&self.gains, path),
            None if is_of_vehicle(&given).ok()? => (&self.vehicle, key),
            None => (&self.mission, key),
        };
        file.pointer(&format!("/{}", path.replace(']', "").replace(['.', '['], "/")))
    }
}

/// Longest value that is shown [letters]: others are tables.
const SHOWN_MOST: usize = 200;

/// Keys for the reader of a file.
const REMARKS: [&str; 4] = ["$schema", "about", "estimated", "origins"];

/// A key, for the search.
fn key_shown(key: &SettableKey, texts: &Texts) -> Option<impl Serialize + use<>> {
    let last = key.path.rsplit('.').next().unwrap_or_default();
    if REMARKS.contains(&last) {
        return None;
    }
    let short = |value: &&Value| !value.is_object() && value.to_string().len() <= SHOWN_MOST;
    Some(object! {
        key: key.path.clone(),
        description: key.description.clone(),
        unit: key.unit.clone(),
        kind: key.kind,
        value: texts.value(&key.path).filter(short).cloned(),
        minimum: key.minimum,
        maximum: key.maximum,
        choices: key.choices.clone(),
    })
}

/// What the page is told of a mission as it was opened: its controls, its keys, its limits.
///
/// # Errors
/// [`Refused`] where its gains cannot be read any more.
pub fn mission_shown(viewed: &Viewed, mission: &Mission) -> Result<String, Refused> {
    let texts = Texts::of(mission)?;
    let drops = object! { drops: DROPS_MOST, j_limit: mission.limits.j_tpf_below, seed: mission.seed };
    let set = viewed.set.iter().map(|set| (set.key().to_owned(), set.value().into()));
    let set: Map<String, Value> = set.collect();
    let shown = object! {
        name: &mission.name,
        path: mission.file.display().to_string(),
        vehicle: &mission.vehicle_name,
        gains: &mission.control.gains_name,
        set: set,
        controls: CONTROLS.iter().filter_map(|control| control.shown(&texts)).collect::<Vec<_>>(),
        keys: settable_keys().filter_map(|key| key_shown(key, &texts)).collect::<Vec<_>>(),
        limits: &texts.mission["limits"],
        campaign: drops,
    };
    Ok(serde_json::to_string(&shown).unwrap_or_default())
}
