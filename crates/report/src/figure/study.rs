//! The common style of the safety study's figures: one scale of colours and one range of velocities for all
//! of them, so that a colour or a length means the same in each.

use super::axis::{Axis, Panel, SMALL, range};
use super::canvas::FigureError;
use super::canvas::{self, Anchor, Font, Pen};
use super::color::INK;
use samara_core::assess::TraceInstant;
use samara_mission::Mission;

/// Font of the names of axes and panels.
pub(super) const AXIS: Font = Font { size: 13.0, color: INK, bold: false };
const WIDTH_PX: u32 = 960;
/// Left edges of the two columns of panels, and their width [px].
pub(super) const LEFT_PX: [f64; 2] = [62.0, 540.0];
pub(super) const PANEL_PX: f64 = 404.0;
const TITLE: Font = Font { size: 18.0, color: INK, bold: true };

/// A trial in a figure of costs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrialPoint {
    /// Pitch at t = 0 [rad].
    pub pitch_rad: f64,
    /// Pitch rate at t = 0 [rad/s].
    pub pitch_rate_rad_s: f64,
    /// J_TPF of the trial, (51).
    pub j_tpf: f64,
}

/// Scales that all figures of a study share.
#[derive(Clone, Debug, PartialEq)]
pub struct StudyStyle {
    origin: String,
    pub(super) target_v_ned: [f64; 3],
    /// End of the flights [s].
    pub(super) end_s: f64,
    /// Lowest and highest J_TPF of the trials.
    pub(super) j_tpf_range: (f64, f64),
    /// Ranges of north, down, body x and body z velocity [m/s].
    pub(super) velocities: [(f64, f64); 4],
    /// Ranges of pitch [rad] and pitch rate [rad/s] at t = 0.
    pub(super) release: [(f64, f64); 2],
}

impl StudyStyle {
    /// The scales that show all of these flights and trials.
    ///
    /// # Errors
    /// [`FigureError::Empty`] when nothing is finite.
    pub fn of<'a>(
        mission: &Mission,
        flights: impl Iterator<Item = &'a [TraceInstant]> + Clone,
        trials: impl Iterator<Item = &'a TrialPoint> + Clone,
    ) -> Result<Self, FigureError> {
        let instants = || flights.clone().flatten();
        let over = |of: fn(&TraceInstant) -> f64| range(instants().map(of)).ok_or(FigureError::Empty);
        let among = |of: fn(&TrialPoint) -> f64| range(trials.clone().map(of)).ok_or(FigureError::Empty);
        Ok(Self {
            origin: mission.stamp().csv_comment(),
            target_v_ned: mission.target_v_ned.into(),
            end_s: mission.plan.horizon_s,
            j_tpf_range: among(|t| t.j_tpf)?,
            velocities: [
                over(|i| i.v_ned.x)?,
                over(|i| i.v_ned.z)?,
                over(|i| i.v_body.x)?,
                over(|i| i.v_body.z)?,
            ],
            release: [among(|t| t.pitch_rad)?, among(|t| t.pitch_rate_rad_s)?],
        })
    }

    /// A sheet with a title and a remark below it.
    pub(super) fn sheet(
        &self,
        height_px: u32,
        title: &str,
        remark: &str,
        draw: impl FnOnce(&mut Pen<'_>),
    ) -> Result<String, FigureError> {
        canvas::sheet((WIDTH_PX, height_px), (title, &self.origin), |pen| {
            pen.text(title, (16.0, 26.0), Anchor::Left, TITLE);
            pen.text(remark, (16.0, 51.0), Anchor::Left, SMALL);
            draw(pen);
        })
    }
}

/// Draws a grid with its numbers and writes the names of the axes, that of the upright one `above` the panel
/// [px].
pub(super) fn grid(pen: &mut Pen<'_>, panel: &Panel, [x, y]: [&str; 2], rows: usize, above: f64) {
    let ((x0, y0), (x1, y1)) = panel.corners();
    pen.text(y, (x0 - 44.0, y0 - above), Anchor::Left, AXIS);
    pen.text(x, (0.5 * (x0 + x1), y1 + 34.0), Anchor::Center, AXIS);
    panel.grid(pen, 6, rows, true);
}

/// The scale of a column of panels.
pub(super) fn column(range: (f64, f64), column: usize) -> Axis {
    Axis::new(range, (LEFT_PX[column], LEFT_PX[column] + PANEL_PX))
}

/// A range with a little air around it.
pub(super) fn with_margin((low, high): (f64, f64), fraction: f64) -> (f64, f64) {
    let margin = (fraction * (high - low)).max(1e-6);
    (low - margin, high + margin)
}
