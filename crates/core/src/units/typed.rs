//! Numbers as people type them, with a unit behind them: `7in`, `0.65kg`, `160mm`, `5kt`.

use super::{M_PER_FT, RAD_PER_DEG, STANDARD_GRAVITY_M_S2, ZERO_DEG_C_K};

/// A unit: what it measures, by the word of the first unit that does, its size in that unit, and the value of
/// that unit at its zero.
struct Unit {
    word: &'static str,
    measures: &'static str,
    size: f64,
    zero: f64,
}

const fn unit(word: &'static str, measures: &'static str, size: f64) -> Unit {
    Unit { word, measures, size, zero: 0.0 }
}

/// Kilograms per pound.
const KG_PER_LB: f64 = 0.453_592_37;

/// Every unit that may be typed. Sources: NIST SP 811, appendix B.8 (inch, foot, pound, knot, ..).
const UNITS: [Unit; 66] = [
    unit("m", "m", 1.0),
    unit("mm", "m", 1e-3),
    unit("cm", "m", 1e-2),
    unit("km", "m", 1e3),
    unit("in", "m", 0.0254),
    unit("ft", "m", M_PER_FT),
    unit("kg", "kg", 1.0),
    unit("g", "kg", 1e-3),
    unit("lb", "kg", KG_PER_LB),
    unit("oz", "kg", KG_PER_LB / 16.0),
    unit("s", "s", 1.0),
    unit("ms", "s", 1e-3),
    unit("us", "s", 1e-6),
    unit("min", "s", 60.0),
    unit("h", "s", 3600.0),
    unit("rad", "rad", 1.0),
    unit("deg", "rad", RAD_PER_DEG),
    unit("m/s", "m/s", 1.0),
    unit("km/h", "m/s", 1.0 / 3.6),
    unit("kt", "m/s", 1852.0 / 3600.0),
    unit("mph", "m/s", 0.447_04),
    unit("ft/s", "m/s", M_PER_FT),
    unit("rad/s", "rad/s", 1.0),
    unit("deg/s", "rad/s", RAD_PER_DEG),
    unit("rpm", "rad/s", std::f64::consts::TAU / 60.0),
    unit("m/s2", "m/s2", 1.0),
    unit("g", "m/s2", STANDARD_GRAVITY_M_S2),
    unit("N", "N", 1.0),
    unit("kN", "N", 1e3),
    unit("gf", "N", 1e-3 * STANDARD_GRAVITY_M_S2),
    unit("kgf", "N", STANDARD_GRAVITY_M_S2),
    unit("lbf", "N", KG_PER_LB * STANDARD_GRAVITY_M_S2),
    unit("N/s", "N/s", 1.0),
    unit("Nm", "Nm", 1.0),
    unit("N/m", "N/m", 1.0),
    unit("Ns/m", "Ns/m", 1.0),
    unit("kgm2", "kgm2", 1.0),
    unit("gcm2", "kgm2", 1e-7),
    unit("kg/m3", "kg/m3", 1.0),
    unit("m2", "m2", 1.0),
    unit("cm2", "m2", 1e-4),
    unit("mm2", "m2", 1e-6),
    unit("Pa", "Pa", 1.0),
    unit("hPa", "Pa", 1e2),
    unit("mbar", "Pa", 1e2),
    unit("kPa", "Pa", 1e3),
    unit("K", "K", 1.0),
    Unit { word: "C", measures: "K", size: 1.0, zero: ZERO_DEG_C_K },
    unit("A", "A", 1.0),
    unit("mA", "A", 1e-3),
    unit("V", "V", 1.0),
    unit("mV", "V", 1e-3),
    unit("ohm", "ohm", 1.0),
    unit("mohm", "ohm", 1e-3),
    unit("J", "J", 1.0),
    unit("kJ", "J", 1e3),
    unit("Wh", "J", 3600.0),
    unit("W", "W", 1.0),
    unit("kW", "W", 1e3),
    unit("Ah", "Ah", 1.0),
    unit("mAh", "Ah", 1e-3),
    unit("Hz", "Hz", 1.0),
    unit("kHz", "Hz", 1e3),
    unit("gauss", "gauss", 1.0),
    unit("mgauss", "gauss", 1e-3),
    unit("%", "%", 1.0),
];

/// Ends of keys and the unit that each means, longer ends first; none: of a unit that nobody types.
const ENDS: [(&str, &str); 46] = [
    ("_n_per_rad2_s2", ""),
    ("_gauss_s", ""),
    ("_sqrt_hz", ""),
    ("_sqrt_s", ""),
    ("_v_s_rad", ""),
    ("_per_rad", ""),
    ("_rad_s2", ""),
    ("_per_n2", ""),
    ("_per_s2", ""),
    ("_hpa_s", ""),
    ("_per_s", ""),
    ("_m_s3", ""),
    ("_rad_m", ""),
    ("_nm_a", ""),
    ("_percent", "%"),
    ("_n_s_m", "Ns/m"),
    ("_kg_m2", "kgm2"),
    ("_kg_m3", "kg/m3"),
    ("_deg_s", "deg/s"),
    ("_rad_s", "rad/s"),
    ("_m_s2", "m/s2"),
    ("_gauss", "gauss"),
    ("_m_s", "m/s"),
    ("_n_s", "N/s"),
    ("_n_m", "N/m"),
    ("_ohm", "ohm"),
    ("_hpa", "hPa"),
    ("_deg", "deg"),
    ("_rad", "rad"),
    ("_kg", "kg"),
    ("_m2", "m2"),
    ("_nm", "Nm"),
    ("_ah", "Ah"),
    ("_wh", "Wh"),
    ("_hz", "Hz"),
    ("_ms", "ms"),
    ("_us", "us"),
    ("_m", "m"),
    ("_s", "s"),
    ("_n", "N"),
    ("_v", "V"),
    ("_a", "A"),
    ("_w", "W"),
    ("_k", "K"),
    ("_j", "J"),
    ("_c", "C"),
];

/// A number that was typed with a unit that cannot be.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum UnitError {
    /// The text does not begin with a number, or with one that is not finite.
    #[error("a number is expected, alone or with a unit")]
    NoNumber,
    /// The unit measures something else, or nothing.
    #[error("`{0}` is no unit here; expected {1}")]
    Unit(String, String),
}

/// The unit that a key of a file is in, by the end of its name: "deg/s" of `pitch_deg_s`. `None`: of a number
/// without a unit, or of a unit that is typed nowhere.
pub fn unit_of(key: &str) -> Option<&'static str> {
    let found = ENDS.iter().find(|(end, _)| key.ends_with(end));
    found.map(|(_, unit)| *unit).filter(|unit| !unit.is_empty())
}

/// The number that a text means in a unit ("m", "deg/s"): one alone is in that unit already, and one with a
/// unit behind it is converted (`7in`, `0.65 kg`, `160mm`). Where the number has no unit, `""`, none may be
/// typed.
///
/// # Errors
/// [`UnitError`] of a text that is no number with a unit of this kind.
pub fn in_unit(text: &str, unit: &str) -> Result<f64, UnitError> {
    let text = text.trim();
    if let Ok(x) = text.parse::<f64>() {
        return if x.is_finite() { Ok(x) } else { Err(UnitError::NoNumber) };
    }
    let (x, word) = number_and_word(text).ok_or(UnitError::NoNumber)?;
    let own = UNITS.iter().find(|known| known.word == unit);
    let alike = || UNITS.iter().filter(|known| own.is_some_and(|own| own.measures == known.measures));
    let typed = alike().find(|known| known.word == word);
    let (Some(own), Some(typed)) = (own, typed) else {
        let known: Vec<&str> = alike().map(|known| known.word).collect();
        let expected = if known.is_empty() { "a number alone".to_owned() } else { known.join(", ") };
        return Err(UnitError::Unit(word.to_owned(), expected));
    };
    if typed.word == own.word {
        return Ok(x);
    }
    Ok((x * typed.size + typed.zero - own.zero) / own.size)
}

/// The number that a text begins with, and the word behind it.
fn number_and_word(text: &str) -> Option<(f64, &str)> {
    // `e` may be an exponent or begin a word: the longest beginning that is a number counts.
    let end = (1..text.len()).rev().filter(|end| text.is_char_boundary(*end)).find(|end| {
        text[..*end].ends_with(|c: char| c.is_ascii_digit() || c == '.')
            && text[..*end].parse::<f64>().is_ok()
    })?;
    Some((text[..end].parse().ok()?, text[end..].trim_start()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_typed_units() {
        for (text, unit, expected) in [
            ("7in", "m", 0.1778),
            ("0.65kg", "kg", 0.65),
            ("650 g", "kg", 0.65),
            ("160mm", "m", 0.16),
            ("5kt", "m/s", 5.0 * 1852.0 / 3600.0),
            ("36km/h", "m/s", 10.0),
            ("6000rpm", "rad/s", 6000.0 * std::f64::consts::TAU / 60.0),
            ("6rpm", "deg/s", 36.0),
            ("1e3mm", "m", 1.0),
            ("-40C", "K", 233.15),
            ("273.15K", "C", 0.0),
            ("20", "C", 20.0),
            ("2", "", 2.0),
            ("1013.25hPa", "hPa", 1013.25),
            ("90deg", "rad", std::f64::consts::FRAC_PI_2),
        ] {
            let found = in_unit(text, unit).unwrap();
            assert!((found - expected).abs() <= 1e-12 * expected.abs().max(1.0), "{text}: {found}");
        }
        assert_eq!(
            in_unit("7in", "kg").unwrap_err().to_string(),
            "`in` is no unit here; expected kg, g, lb, oz"
        );
        assert_eq!(
            in_unit("7in", "").unwrap_err().to_string(),
            "`in` is no unit here; expected a number alone"
        );
        for text in ["", "in", "nan", "infm", "x7", "--7m", "é"] {
            assert_eq!(in_unit(text, "m"), Err(UnitError::NoNumber), "{text}");
        }
    }

    #[test]
    fn units_of_keys_are_known_and_longer_ends_come_first() {
        for (key, unit) in [
            ("pitch_rate_deg_s", Some("deg/s")),
            ("mass_kg", Some("kg")),
            ("density_kg_m3", Some("kg/m3")),
            ("esc_gain_v_s_rad", None),
            ("walk_hpa_s", None),
            ("nodes", None),
            ("target_v_ned_m_s", Some("m/s")),
        ] {
            assert_eq!(unit_of(key), unit, "{key}");
        }
        for (i, (end, unit)) in ENDS.iter().enumerate() {
            assert!(unit.is_empty() || UNITS.iter().any(|known| known.word == *unit), "{unit}");
            assert!(ENDS[i + 1..].iter().all(|(later, _)| !later.ends_with(end)), "{end}");
        }
        for unit in &UNITS {
            let first = UNITS.iter().find(|known| known.word == unit.measures).unwrap();
            assert!(first.size == 1.0 && first.measures == unit.measures, "{}", unit.word);
        }
    }
}
