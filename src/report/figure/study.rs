//! The common style of the safety study's figures: one scale of colours and one range of velocities for all
//! of them, so that a colour or a length means the same in each.

use super::axis::{SMALL, range};
use super::canvas::FigureError;
use super::canvas::{Anchor, Canvas, Font, Pen, Point, Stroke};
use super::color::{ColorScale, INK, LIMIT};
use crate::assess::TraceInstant;
use crate::config::Mission;

/// Font of the names of axes and panels.
pub(super) const AXIS: Font = Font { size: 13.0, color: INK, bold: false };
/// Width of the figures [px].
pub(super) const WIDTH_PX: u32 = 960;
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
    pub(super) about: String,
    pub(super) target_v_ned: [f64; 3],
    /// End of the flights [s].
    pub(super) end_s: f64,
    pub(super) j_state: ColorScale,
    pub(super) j_tpf: ColorScale,
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
        let stamp = mission.stamp();
        Ok(Self {
            about: stamp.csv_comment().replace("# ", "").trim_end().to_owned(),
            target_v_ned: mission.target_v_ned.into(),
            end_s: mission.plan.horizon_s,
            j_state: ColorScale::around(instants().map(|i| i.j_state)),
            j_tpf: ColorScale::around(trials.clone().map(|t| t.j_tpf)),
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
        Canvas::new((WIDTH_PX, height_px)).finish((title, &self.about), |pen| {
            pen.text(title, (16.0, 26.0), Anchor::Start, TITLE);
            pen.text(remark, (16.0, 51.0), Anchor::Start, SMALL);
            draw(pen);
        })
    }
}

/// A range with a little air around it.
pub(super) fn with_margin((low, high): (f64, f64), fraction: f64) -> (f64, f64) {
    let margin = (fraction * (high - low)).max(1e-6);
    (low - margin, high + margin)
}

/// Draws a limit, a red line.
pub(super) fn limit(pen: &mut Pen<'_>, from: Point, to: Point) {
    pen.line(&[from, to], Stroke::dashed(LIMIT, 1.2, 8.0, 3.0));
}
