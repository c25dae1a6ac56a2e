//! SVG figures, all in one style: white paper, units on every axis, lines named where they run, viridis for
//! J_state, red for limits. The same data give the same bytes.
//!
//! | file | holds |
//! |---|---|
//! | `canvas`, `polyline` | the sheet: lines, shapes, text; `canvas` alone uses plotters |
//! | `color` | the map of J_state, the palette |
//! | `axis` | scales, ticks, grids |
//! | `label` | room for labels |
//! | `track`, `sheet` | the motion of a flight or a plan; what a figure of it shows |
//! | `flight_path`, `glyph` | the path as in the paper's figure 7, with small vehicles |
//! | `convergence` | the cost of a search over its evaluations |
//! | `distribution` | the share of a campaign's trials below each value, beside the limit |
//! | `time_panels` | velocities, pitch, thrusts, J_state over time |
//! | `study`, `study_paths`, `study_campaigns` | the paper's figures 7 to 14 |

mod axis;
mod canvas;
mod color;
mod convergence;
mod distribution;
mod flight_path;
mod glyph;
mod label;
mod polyline;
mod sheet;
mod study;
mod study_campaigns;
mod study_paths;
mod time_panels;
mod track;

pub use canvas::FigureError;
pub use convergence::convergence_figure;
pub use distribution::{Distribution, distribution_figure};

use axis::{SMALL, number};
use canvas::{Anchor, Font, Pen, Point, sub};
use color::INK;
use flight_path::color_bar;
use sheet::Sheet;
use track::Track;

pub use study::{StudyStyle, TrialPoint};
pub use study_campaigns::{costs_figure, velocities_figure};
pub use study_paths::{PathGroup, paths_figure};

use crate::assess::{Verdict, plan_j_tpf};
use crate::config::Mission;
use crate::sim::Sample;
use crate::trajectory::Trajectory;

const WIDTH_PX: u32 = 960;
const HEIGHT_PX: u32 = 760;
/// Corners of the flight path's panel.
const PATH_CORNERS: (Point, Point) = ((56.0, 112.0), (446.0, 712.0));
/// Corners of the column of panels over time.
const COLUMN_CORNERS: (Point, Point) = ((514.0, 112.0), (940.0, 712.0));

/// Draws a drop: the flight path, and the motion over time against the plan that was flown. `verdict` is
/// `None` for a flight that was not released; `by` names the autopilot in the subtitle, `None` for the
/// reference autopilot.
///
/// # Errors
/// [`FigureError`] when no sample is finite or the backend fails.
pub fn drop_figure(
    mission: &Mission,
    samples: &[Sample],
    plan: Option<&Trajectory>,
    verdict: Option<&Verdict>,
    by: Option<&str>,
) -> Result<String, FigureError> {
    let track = Track::of_flight(mission, samples);
    let start = track.at(0.0).map_or((0.0, 0.0), |i| (i.north_m, i.down_m));
    // Without a release the plan has no place in time.
    let plan = plan.filter(|_| track.since_free).map(|plan| Track::of_plan(mission, plan, start));
    let mut sheet = Sheet::new(mission, &track, plan.as_ref());
    match track.release_s {
        Some(t_s) if t_s < 0.0 => {
            sheet.event(t_s, "released", false);
            sheet.event(0.0, "rotors free, t = 0", false);
        }
        Some(t_s) => sheet.event(t_s, "t = 0", false),
        None => sheet.headline += ": not released",
    }
    if let Some(verdict) = verdict {
        sheet.peak(verdict.j_tpf);
        if !(verdict.j_tpf <= 1.0) {
            sheet.headline += ", over the limit";
        }
        match verdict.steady_after_s {
            Some(t_s) => {
                sheet.event(t_s, &format!("steady from {} s", number(t_s, 1)), false);
                sheet.headline += &format!(", steady after {} s", number(t_s, 1));
            }
            None => sheet.headline += ", not steady",
        }
        sheet.headline += &format!(", {} m of altitude lost", number(verdict.altitude_lost_m, 0));
    }
    draw(&sheet, by)
}

/// Draws a plan: its path, from where it begins, and its motion over time.
///
/// # Errors
/// [`FigureError`] when the backend fails.
pub fn plan_figure(mission: &Mission, plan: &Trajectory) -> Result<String, FigureError> {
    let track = Track::of_plan(mission, plan, (0.0, 0.0));
    let mut sheet = Sheet::new(mission, &track, None);
    sheet.headline += ", the plan";
    sheet.event(0.0, "rotors free, t = 0", false);
    sheet.peak(plan_j_tpf(plan, &mission.limits.safety));
    draw(&sheet, None)
}

/// "J_TPF" as titles of figures have it, the subscript set low.
pub fn j_tpf() -> String {
    sub("J", "TPF")
}

fn draw(sheet: &Sheet<'_>, by: Option<&str>) -> Result<String, FigureError> {
    if !sheet.track.instants.iter().any(|i| i.north_m.is_finite() && i.down_m.is_finite()) {
        return Err(FigureError::Empty);
    }
    let origin = sheet.mission.stamp().csv_comment();
    canvas::sheet((WIDTH_PX, HEIGHT_PX), (&sheet.headline, &origin), |pen| {
        heading(pen, &sheet.headline, by, sheet.track.rolls());
        flight_path::draw(pen, sheet, PATH_CORNERS);
        color_bar(pen, &sheet.scale, "state", (PATH_CORNERS.1.0, 78.0));
        time_panels::draw(pen, sheet, COLUMN_CORNERS);
    })
}

fn heading(pen: &mut Pen<'_>, headline: &str, by: Option<&str>, rolls: bool) {
    pen.text(headline, (16.0, 28.0), Anchor::Left, Font { size: 19.0, color: INK, bold: true });
    let j_state = sub("J", "state");
    // The colour bar says the same of the path, where there is no room.
    let opening =
        by.map_or(format!("Flight path coloured by {j_state}, m"), |by| format!("Flown by {by}. M"));
    let quantities =
        if rolls { "speed, pitch, roll, pitch rate or roll rate" } else { "speed, pitch or pitch rate" };
    let remark = format!(
        "{opening}arks every {} s. {j_state} is the largest share of a safety limit: {quantities}.",
        flight_path::MARK_INTERVAL_S,
    );
    pen.text(&remark, (16.0, 54.0), Anchor::Left, SMALL);
}
