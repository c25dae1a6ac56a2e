//! One trial alone: its random numbers and its outcome with each controller.

use super::grid::Grid;
use super::label;
use crate::assess::{Outcome, RandomRelease, StudyEntry};
use crate::config::Mission;
use crate::frames::pitch;
use crate::report::json::{head, object, text};
use crate::report::outcome::OutcomeObject;
use crate::units::DEG_PER_RAD;

/// A controller, the outcome of the trial with it, and its line of the campaign's CSV file.
pub type Flown<'a> = (&'a StudyEntry, Outcome, String);

/// The trial as text.
pub fn only_text(mission: &Mission, release: &RandomRelease, flown: &[Flown<'_>]) -> String {
    let state = &release.state;
    let mut out = format!(
        "trial {} of {}, seed {}: theta_0 {:.3} deg, phi {:.2} deg\n\
         at t = 0: velocity {:.4} north, {:.4} down m/s, pitch {:.3} deg, pitch rate {:.3} deg/s\n\n",
        release.trial,
        mission.name,
        mission.seed,
        release.amplitude_rad * DEG_PER_RAD,
        release.phase_rad * DEG_PER_RAD,
        state.v_ned.x,
        state.v_ned.z,
        pitch(state.q_ned_from_body) * DEG_PER_RAD,
        state.omega_body.y * DEG_PER_RAD,
    );
    let head = [
        "controller",
        "J_TPF",
        "speed [m/s]",
        "pitch [deg]",
        "pitch rate [deg/s]",
        "north, down at the end [m/s]",
    ];
    let mut grid = Grid::new("Peaks", head);
    for (controller, o, _) in flown {
        grid.row(
            &label(controller),
            [
                format!("{:.6}", o.j_tpf),
                format!("{:.3}", o.peak_speed_m_s),
                format!("{:.2}", o.peak_pitch_deg),
                format!("{:.2}", o.peak_pitch_rate_deg_s),
                format!("{:.3}, {:.3}", o.vn_end_m_s, o.vd_end_m_s),
            ],
        );
    }
    out += &grid.text();
    out += "\nlines of the campaigns' files:\n";
    for (controller, _, row) in flown {
        out += &format!("{}: {row}", controller.name);
    }
    out.push('\n');
    out
}

/// The trial as one JSON object.
pub fn only_json(mission: &Mission, release: &RandomRelease, flown: &[Flown<'_>]) -> String {
    let state = &release.state;
    let flights = flown.iter().map(|(c, o, row)| {
        object! {
            name: c.name,
            gains: &c.gains_name,
            #[serde(flatten)] outcome: OutcomeObject(*o),
            final_v_ned_m_s: <[f64; 3]>::from(o.final_v_ned()),
            csv_row: row.trim_end(),
        }
    });
    text(&object! {
        #[serde(flatten)] head: head(mission),
        trial: release.trial,
        theta_0_deg: release.amplitude_rad * DEG_PER_RAD,
        phi_deg: release.phase_rad * DEG_PER_RAD,
        v_ned_m_s: <[f64; 3]>::from(state.v_ned),
        pitch_deg: pitch(state.q_ned_from_body) * DEG_PER_RAD,
        pitch_rate_deg_s: state.omega_body.y * DEG_PER_RAD,
        flights: flights.collect::<Vec<_>>(),
    })
}
