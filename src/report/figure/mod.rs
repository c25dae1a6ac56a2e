//! SVG figures, all in one style: white paper, units on every axis, lines named where they run, viridis for
//! J_state, red for limits. The same data give the same bytes.
//!
//! | file | holds |
//! |---|---|
//! | `canvas`, `polyline` | the sheet: lines, shapes, text; `canvas` alone uses plotters |
//! | `color` | the map of J_state, the palette |
//! | `axis` | scales, ticks, grids |
//! | `label`, `panel_names` | room for labels; names of lines and limits |
//! | `track` | the motion of a flight or a plan |
//! | `flight_path`, `glyph` | the path as in the paper's figure 7, with small vehicles |
//! | `convergence` | the cost of a search over its evaluations |
//! | `time_panels` | velocities, pitch, thrusts, J_state over time |
//! | `study`, `study_paths`, `study_velocities`, `study_costs` | the paper's figures 7 to 14 |

mod axis;
mod canvas;
mod color;
mod convergence;
mod flight_path;
mod glyph;
mod label;
mod panel_names;
mod polyline;
mod study;
mod study_costs;
mod study_paths;
mod study_velocities;
mod time_panels;
mod track;

pub use canvas::FigureError;
pub use convergence::convergence_figure;

use axis::{SMALL, number};
use canvas::{Anchor, Canvas, Font, Pen, sub};
use color::{ColorScale, INK};
use flight_path::{Event, FlightPath, color_bar};
use time_panels::TimePanels;
use track::Track;

pub use study::{StudyStyle, TrialPoint};
pub use study_costs::costs_figure;
pub use study_paths::{PathGroup, paths_figure};
pub use study_velocities::velocities_figure;

use crate::assess::{Verdict, plan_j_tpf};
use crate::config::Mission;
use crate::sim::Sample;
use crate::trajectory::Trajectory;

const WIDTH_PX: u32 = 960;
const HEIGHT_PX: u32 = 760;
/// Corners of the flight path's panel.
const PATH_CORNERS: ((f64, f64), (f64, f64)) = ((56.0, 112.0), (446.0, 712.0));
const COLUMN_CORNERS: ((f64, f64), (f64, f64)) = ((514.0, 112.0), (940.0, 712.0));

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
    let (vehicle, limits) = (&mission.vehicle, &mission.limits.safety);
    let track = Track::of_flight(samples, vehicle, limits);
    let start = track.at(0.0).map_or((0.0, 0.0), |i| (i.north_m, i.down_m));
    // Without a release the plan has no place in time.
    let plan = plan.filter(|_| track.since_free).map(|plan| Track::of_plan(plan, start, vehicle, limits));
    let mut sheet = Sheet::new(mission, &track, plan.as_ref());
    sheet.by = by.map(str::to_owned);
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
    sheet.draw()
}

/// Draws a plan: its path, from where it begins, and its motion over time.
///
/// # Errors
/// [`FigureError`] when the backend fails.
pub fn plan_figure(mission: &Mission, plan: &Trajectory) -> Result<String, FigureError> {
    let track = Track::of_plan(plan, (0.0, 0.0), &mission.vehicle, &mission.limits.safety);
    let mut sheet = Sheet::new(mission, &track, None);
    sheet.headline += ", the plan";
    sheet.event(0.0, "rotors free, t = 0", false);
    sheet.peak(plan_j_tpf(plan, &mission.limits.safety));
    sheet.draw()
}

/// "J_TPF" as titles of figures have it, the subscript set low.
pub fn j_tpf() -> String {
    sub("J", "TPF")
}

/// A figure in the making.
struct Sheet<'a> {
    mission: &'a Mission,
    track: &'a Track,
    plan: Option<&'a Track>,
    headline: String,
    by: Option<String>,
    events: Vec<Event>,
    j_tpf: Option<f64>,
}

impl<'a> Sheet<'a> {
    fn new(mission: &'a Mission, track: &'a Track, plan: Option<&'a Track>) -> Self {
        let headline = mission.name.clone();
        Self { mission, track, plan, headline, by: None, events: Vec::new(), j_tpf: None }
    }

    fn event(&mut self, t_s: f64, text: &str, strong: bool) {
        self.events.push(Event { t_s, text: text.to_owned(), strong });
    }

    /// Writes J_TPF and marks its place.
    fn peak(&mut self, j_tpf: f64) {
        self.headline += &format!(": {} {j_tpf:.3}", sub("J", "TPF"));
        self.j_tpf = Some(j_tpf);
        if let Some(worst) = self.track.riskiest() {
            let decided_by = worst.decided_by.replace('_', " ");
            self.event(worst.t_s, &format!("highest {} {j_tpf:.3}: {decided_by}", sub("J", "state")), true);
        }
    }

    fn draw(self) -> Result<String, FigureError> {
        let Self { mission, track, plan, .. } = self;
        if !track.instants.iter().any(|i| i.north_m.is_finite() && i.down_m.is_finite()) {
            return Err(FigureError::Empty);
        }
        let from_s = track.release_s.unwrap_or(f64::NEG_INFINITY);
        let colored = track.instants.iter().filter(|i| i.t_s >= from_s);
        let scale = ColorScale::around(colored.map(|i| i.j_state));
        let parachute = track.release_s.map_or(!track.since_free, |t| t < 0.0);
        let path = FlightPath { track, plan, scale, events: self.events, parachute };
        let panels = TimePanels {
            track,
            plan,
            target_v_ned: mission.target_v_ned,
            limits: &mission.limits.safety,
            thrust_max_n: mission.plan.thrust_max_n,
            scale,
            j_tpf: self.j_tpf,
        };
        let stamp = mission.stamp();
        let about = stamp.csv_comment().replace("# ", "");
        let (headline, by) = (self.headline, self.by);
        Canvas::new((WIDTH_PX, HEIGHT_PX)).finish((&headline, about.trim_end()), |pen| {
            heading(pen, &headline, by.as_deref(), track.rolls());
            path.draw(pen, PATH_CORNERS.0, PATH_CORNERS.1);
            color_bar(pen, &scale, "state", (PATH_CORNERS.1.0, 78.0));
            panels.draw(pen, COLUMN_CORNERS.0, COLUMN_CORNERS.1);
        })
    }
}

fn heading(pen: &mut Pen<'_>, headline: &str, by: Option<&str>, rolls: bool) {
    pen.text(headline, (16.0, 28.0), Anchor::Start, Font { size: 19.0, color: INK, bold: true });
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
    pen.text(&remark, (16.0, 54.0), Anchor::Start, SMALL);
}
