//! Whether a parameter file may be used for an autopilot at a site: its header says for which autopilot and
//! gravity it was written.

use super::ParamsError;
use super::file::ParameterFile;
use super::purpose::{GRAVITY_KEY, Purpose};
use crate::model::environment::same_gravity;
use crate::units::STANDARD_GRAVITY_M_S2;

/// The purpose for which a file's numbers were written, if they may be used for the purpose `wanted` at a
/// site with that gravity [m/s^2]: by samara's autopilot, by PX4, or by PX4 where the wire is scaled.
///
/// # Errors
/// [`ParamsError::DoesNotBelong`] with the reason.
pub fn written_for(file: &ParameterFile, gravity_m_s2: f64, wanted: Purpose) -> Result<Purpose, ParamsError> {
    let same = |g: f64| same_gravity(g, gravity_m_s2);
    let standard = same(STANDARD_GRAVITY_M_S2);
    let refuse = |why: String| Err(ParamsError::DoesNotBelong(why));
    let again = format!("; write one for here with: samara params export MISSION --for {}", wanted.name());
    let (reader, own) = match wanted {
        Purpose::Samara => ("samara's autopilot", "samara's own"),
        Purpose::Px4 => ("PX4 as it is", "PX4's"),
        Purpose::Px4Froude => ("PX4 by Froude scaling", "for PX4 by Froude scaling"),
    };
    let stated_gravity = match file.header(GRAVITY_KEY) {
        None => None,
        Some(text) => match text.split_whitespace().next().and_then(|x| x.parse::<f64>().ok()) {
            Some(g) if g > 0.0 && g.is_finite() => Some(g),
            _ => return refuse(format!("its header's `{GRAVITY_KEY}:` must be a positive number of m/s^2")),
        },
    };
    if let Some(g) = stated_gravity.filter(|g| !same(*g)) {
        return refuse(format!(
            "it was written for a gravity of {g} m/s^2, the mission's is {gravity_m_s2} m/s^2{again}"
        ));
    }
    match file.purpose() {
        Some(purpose) if standard || purpose == wanted => Ok(purpose),
        Some(purpose) => refuse(format!(
            "it is for {} ({}), not for {reader} under {gravity_m_s2} m/s^2{again}",
            purpose.name(),
            purpose.words()
        )),
        None if standard => Ok(wanted),
        None => refuse(format!(
            "it does not say what it is for, and under {gravity_m_s2} m/s^2 that matters; if its gains are {own}, put the line `# {}: {}` at its \
             top",
            Purpose::KEY,
            wanted.name()
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TITAN: f64 = 1.35;

    fn file(header: &str) -> ParameterFile {
        ParameterFile::parse(&format!("{header}1\t1\tMC_PITCH_P\t4.0\t9\n")).unwrap()
    }

    /// Which purposes a file may be used for under Titan's gravity, and under the standard's.
    #[test]
    fn a_file_is_taken_for_what_its_header_says_and_nothing_else() {
        for of in Purpose::ALL {
            let text = format!("# For: {}\n# Gravity: 1.35 m/s^2\n", of.name());
            for wanted in Purpose::ALL {
                assert_eq!(
                    written_for(&file(&text), TITAN, wanted).is_ok(),
                    of == wanted,
                    "{of:?} for {wanted:?}"
                );
                assert!(written_for(&file(&text), STANDARD_GRAVITY_M_S2, wanted).is_err(), "another gravity");
                let anywhere = format!("# For: {}\n", of.name());
                assert_eq!(written_for(&file(&anywhere), STANDARD_GRAVITY_M_S2, wanted), Ok(of));
            }
        }
        for wanted in Purpose::ALL {
            assert!(written_for(&file(""), TITAN, wanted).is_err());
            assert_eq!(written_for(&file(""), STANDARD_GRAVITY_M_S2, wanted), Ok(wanted));
        }
    }

    #[test]
    fn a_refusal_says_what_was_wanted_and_how_to_get_it() {
        let said = |text: &str, wanted| written_for(&file(text), TITAN, wanted).unwrap_err().to_string();
        let text = said("# For: px4\n# Gravity: 1.35 m/s^2\n", Purpose::Px4Froude);
        assert!(text.contains("PX4 by Froude scaling") && text.contains("--for px4-froude"), "{text}");
        let text = said("", Purpose::Px4Froude);
        assert!(text.contains("`# For: px4-froude`"), "{text}");
    }
}
