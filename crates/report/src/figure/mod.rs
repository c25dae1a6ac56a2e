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
//! | `flight_path`, `heading`, `glyph` | the path as in the paper's figure 7, with small vehicles |
//! | `rotors` | which rotors share a line |
//! | `bode` | gain and phase of loops over the frequency |
//! | `convergence` | the cost of a search over its evaluations |
//! | `distribution` | the share of a campaign's trials below each value, beside the limit |
//! | `envelope` | the safe-release envelope, a panel for each two quantities |
//! | `fidelity` | the same trials flown two ways, one over the other |
//! | `free_fall` | operating curves of rules that find a fall |
//! | `identified` | measured and predicted channels of a flight |
//! | `rare` | the probability of reaching a cost, down to a rare one |
//! | `sobol` | what decides a drop, a bar for each quantity |
//! | `time_panels` | velocities, pitch, thrusts, J_state over time |
//! | `study`, `study_paths`, `study_campaigns` | the paper's figures 7 to 14 |

pub mod axis;
mod bode;
pub mod canvas;
pub mod color;
mod distribution;
mod flight_path;
mod glyph;
mod heading;
mod identified;
pub mod label;
mod polyline;
mod rotors;
mod sheet;
mod study;
mod study_campaigns;
mod study_paths;
mod time_panels;
mod track;

pub use bode::bode_figure;
pub use canvas::FigureError;
pub use distribution::{Distribution, distribution_figure};
pub use identified::identified_figure;

use nalgebra::Vector3;

use axis::{SMALL, number, short};
use canvas::{Anchor, Font, Pen, Point, sub, text_width};
use color::INK;
use flight_path::color_bar;
use sheet::Sheet;
use track::Track;

pub use study::{StudyStyle, TrialPoint};
pub use study_campaigns::{costs_figure, velocities_figure};
pub use study_paths::{PathGroup, paths_figure};

use crate::shown_drop::{ShownDrop, air_words};
use samara_core::assess::Verdict;
use samara_core::trajectory::Trajectory;
use samara_mission::Mission;

/// Width of a sheet [px].
pub const WIDTH_PX: u32 = 960;
const HEIGHT_PX: u32 = 760;
/// Corners of the flight path's panel.
const PATH_CORNERS: (Point, Point) = ((56.0, 112.0), (446.0, 712.0));
/// Corners of the column of panels over time.
const COLUMN_CORNERS: (Point, Point) = ((514.0, 112.0), (940.0, 712.0));

/// Part of the time from t = 0 to steady flight by which figures go on.
const AFTER_STEADY: f64 = 0.2;

/// Draws a drop: the flight path, and the motion over time against the plan that was flown, to shortly after
/// it becomes steady.
///
/// # Errors
/// [`FigureError`] when no sample is finite or the backend fails.
pub fn drop_figure(drop: &ShownDrop<'_>) -> Result<String, FigureError> {
    let ShownDrop { mission, verdict, .. } = *drop;
    let whole = Track::of_flight(mission, drop.samples);
    let end_s = shown_until_s(&whole, verdict);
    let start = whole.at(0.0).map_or(Vector3::zeros(), |i| Vector3::new(i.north_m, i.east_m, i.down_m));
    let track = whole.until(end_s);
    // Without a release the plan has no place in time.
    let plan = drop.plan.filter(|_| track.since_free);
    let plan = plan.map(|plan| Track::of_plan(mission, plan, start).until(end_s));
    let mut sheet = Sheet::new(mission, &track, plan.as_ref());
    sheet.plan_end_s = plan.as_ref().and(drop.plan).map(Trajectory::end_s);
    sheet.headline = drop.title.to_owned();
    sheet.circumstances = drop.circumstances();
    match track.release_s {
        Some(t_s) if t_s < 0.0 => {
            sheet.event(t_s, "released", false);
            sheet.event(0.0, "rotors free, t = 0", false);
        }
        Some(t_s) => sheet.event(t_s, "t = 0", false),
        None => sheet.headline += ": not released",
    }
    if let Some(verdict) = verdict {
        sheet.peak(verdict.outcome.j_tpf);
        // The cause: what else there is stands in the verdict.
        if let Some(cause) = drop.run.objections(Some(verdict)).first() {
            sheet.headline += &format!(", not safe: {cause}");
        }
        if let Some(t_s) = verdict.outcome.steady_after_s {
            sheet.event(t_s, &format!("steady from {} s", number(t_s, 1)), false);
            sheet.headline += &format!(", steady after {} s", number(t_s, 1));
        }
        sheet.headline += &format!(", {} m of altitude lost", number(verdict.outcome.altitude_lost_m, 0));
    }
    draw(&sheet)
}

/// The time up to which a flight is shown [s]: to steady flight, a fifth on, and past what decides J_TPF.
fn shown_until_s(track: &Track, verdict: Option<&Verdict>) -> f64 {
    let Some(steady_s) = verdict.and_then(|v| v.outcome.steady_after_s) else { return f64::INFINITY };
    let riskiest_s = track.riskiest().map_or(0.0, |i| i.t_s);
    (steady_s.max(riskiest_s) * (1.0 + AFTER_STEADY)).max(1.0)
}

/// Draws a plan: its path, from where it begins, and its motion over time.
///
/// # Errors
/// [`FigureError`] when the backend fails.
pub fn plan_figure(mission: &Mission, plan: &Trajectory) -> Result<String, FigureError> {
    let track = Track::of_plan(mission, plan, Vector3::zeros());
    let mut sheet = Sheet::new(mission, &track, None);
    sheet.headline = format!("{}, the plan", mission.name);
    let wind = air_words(&mission.site);
    sheet.circumstances = format!("Vehicle {}, {wind}.", mission.vehicle_name);
    sheet.event(0.0, "rotors free, t = 0", false);
    sheet.peak(mission.integrated(plan).j_tpf);
    draw(&sheet)
}

/// "J_TPF" as titles of figures have it, the subscript set low.
pub fn j_tpf() -> String {
    sub("J", "TPF")
}

fn draw(sheet: &Sheet<'_>) -> Result<String, FigureError> {
    if !sheet.track.instants.iter().any(|i| i.north_m.is_finite() && i.down_m.is_finite()) {
        return Err(FigureError::Empty);
    }
    let origin = sheet.mission.stamp().csv_comment();
    canvas::sheet((WIDTH_PX, HEIGHT_PX), (&sheet.headline, &origin), |pen| {
        heading(pen, sheet);
        flight_path::draw(pen, sheet, PATH_CORNERS);
        color_bar(pen, "state", (PATH_CORNERS.1.0, 78.0));
        time_panels::draw(pen, sheet, COLUMN_CORNERS);
    })
}

/// Headline, circumstances and what is seen; a long line is set smaller.
fn heading(pen: &mut Pen<'_>, sheet: &Sheet<'_>) {
    let mut line = |text: &str, y: f64, font: Font| {
        let share = (f64::from(WIDTH_PX) - 24.0) / text_width(text, font.size);
        pen.text(text, (16.0, y), Anchor::Left, Font { size: font.size * share.min(1.0), ..font });
    };
    line(&sheet.headline, 24.0, Font { size: 19.0, color: INK, bold: true });
    line(&sheet.circumstances, 47.0, SMALL);
    let j_state = sub("J", "state");
    let quantities = if sheet.track.rolls() {
        "speed, pitch, roll, pitch rate or roll rate"
    } else {
        "speed, pitch or pitch rate"
    };
    let end_s = sheet.track.span_s().map_or(0.0, |span| span.1);
    let remark = format!(
        "Flight path coloured by {j_state}, marks every {} s. {j_state} is the largest share of a safety limit: {quantities}.",
        short(flight_path::mark_interval_s(end_s)),
    );
    line(&remark, 64.0, SMALL);
}
