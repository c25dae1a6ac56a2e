//! Statements of section II and (31), which need no flight: the fall before the rotors start, and the steady
//! state at the target.

use super::finding::Finding;
use crate::paper::Assessment;
use samara_core::assess::paper;
use samara_core::model::trim::trim;
use samara_core::units::DEG_PER_RAD;

/// Largest distance of the trim's pitch from (31)'s [deg].
const PITCH_BAR_DEG: f64 = 0.01;

const WHY_NONE: &str = "The mission's gravity, or its vehicle's trim, is not the paper's.";

pub(super) fn findings(a: &Assessment<'_>) -> Vec<Finding> {
    let gravity_m_s2 = a.mission.site.environment.gravity_m_s2;
    let [half, one] = paper::FREE_FALLS;
    let way_m = |t: f64| 0.5 * gravity_m_s2 * t * t;
    let gain_m_s = |t: f64| gravity_m_s2 * t;
    vec![
        Finding::new(
            "after 0.5 s and 1 s of fall vehicle and aeroshell are this far apart",
            format!("{} and {} m", half.1, one.1),
            format!("{:.3} and {:.3} m, g t^2/2", way_m(half.0), way_m(one.0)),
            "the paper's digits, further ones cut off",
            cut_off(way_m(half.0), 2, half.1) && cut_off(way_m(one.0), 2, one.1),
            WHY_NONE,
        ),
        Finding::new(
            "the delay of 0.5 s, or 1 s, adds to the descent velocity",
            format!("{} and {} m/s", half.2, one.2),
            format!("{:.3} and {:.3} m/s, g t", gain_m_s(half.0), gain_m_s(one.0)),
            "the paper's digits, further ones cut off",
            cut_off(gain_m_s(half.0), 1, half.2) && cut_off(gain_m_s(one.0), 1, one.2),
            WHY_NONE,
        ),
        steady_state(a),
    ]
}

/// Whether a number with the digits behind so many decimals cut off is another.
fn cut_off(x: f64, decimals: i32, printed: f64) -> bool {
    let scale = 10f64.powi(decimals);
    (x * scale).floor() == (printed * scale).round()
}

fn steady_state(a: &Assessment<'_>) -> Finding {
    let mission = a.mission;
    let found = trim(&mission.vehicle, &mission.site.environment, mission.target_v_ned, 0.0);
    let here = found.map_or(f64::NAN, |trim| trim.pitch_rad * DEG_PER_RAD);
    let printed = paper::STEADY_PITCH_RAD * DEG_PER_RAD;
    Finding::new(
        "the steady pitch at the target velocity, (31)",
        format!("{printed:.3} deg (q_2 = -0.0026)"),
        format!("{here:.3} deg, solved"),
        "within 0.01 deg",
        (here - printed).abs() <= PITCH_BAR_DEG,
        WHY_NONE,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Titan's 1.35 m/s^2: 0.16875 m and 0.675 m, 0.675 m/s and 1.35 m/s.
    #[test]
    fn closed_form_the_falls_are_the_paper_s_with_digits_cut_off() {
        for (t, way_m, gain_m_s) in paper::FREE_FALLS {
            assert!(cut_off(0.5 * 1.35 * t * t, 2, way_m) && cut_off(1.35 * t, 1, gain_m_s), "{t}");
            assert!(!cut_off(0.5 * 1.62 * t * t, 2, way_m) && !cut_off(1.62 * t, 1, gain_m_s), "{t}");
        }
    }
}
