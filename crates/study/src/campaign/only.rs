//! One trial alone: its random numbers and its outcome with each controller.

use super::campaign_csv::drawn;
use crate::paper::label;
use samara_core::assess::{Outcome, RandomRelease, StudyEntry};
use samara_mission::Mission;
use samara_report::document::Grid;
use samara_report::json::{Head, object, text};
use samara_report::outcome::OutcomeObject;

/// A controller, the outcome of the trial with it, and its line of the campaign's CSV file.
pub type Flown<'a> = (&'a StudyEntry, Outcome, String);

/// The trial as text.
pub fn only_text(mission: &Mission, release: &RandomRelease, flown: &[Flown<'_>]) -> String {
    let [theta_0_deg, phi_deg, north_m_s, down_m_s, pitch_deg, rate_deg_s] = drawn(release);
    let mut out = format!(
        "trial {} of {}, seed {}: theta_0 {theta_0_deg:.3} deg, phi {phi_deg:.2} deg\n\
         at t = 0: velocity {north_m_s:.4} north, {down_m_s:.4} down m/s, pitch {pitch_deg:.3} deg, \
         pitch rate {rate_deg_s:.3} deg/s\n\n",
        release.trial, mission.name, mission.seed,
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
    let [theta_0_deg, phi_deg, _, _, pitch_deg, rate_deg_s] = drawn(release);
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
        #[serde(flatten)] head: Head::of(mission),
        trial: release.trial,
        theta_0_deg: theta_0_deg,
        phi_deg: phi_deg,
        v_ned_m_s: <[f64; 3]>::from(release.state.v_ned),
        pitch_deg: pitch_deg,
        pitch_rate_deg_s: rate_deg_s,
        flights: flights.collect::<Vec<_>>(),
    })
}
