//! Figures 10, 12 and 14: J_TPF of each trial by pitch and pitch rate at the release. On the left pitch rate
//! over pitch, the cost as colour; on the right the cost against each. The origin is the nominal release.

use super::axis::{Axis, Panel};
use super::canvas::FigureError;
use super::canvas::{Anchor, Pen, Stroke, sub};
use super::color::{INK, SOFT_INK};
use super::flight_path::color_bar;
use super::study::{AXIS, StudyStyle, TrialPoint, limit, with_margin};
use crate::units::DEG_PER_RAD;

const HEIGHT_PX: u32 = 560;
const TOP_PX: f64 = 112.0;
const BOTTOM_PX: f64 = 506.0;
const MAP_PX: (f64, f64) = (62.0, 466.0);
const SIDE_PX: (f64, f64) = (540.0, 944.0);
const GAP_PX: f64 = 66.0;
const PITCH: &str = "pitch at release [deg]";
const RATE: &str = "pitch rate at release [deg/s]";
const RADIUS_PX: f64 = 3.2;

/// Draws the trials of a campaign.
///
/// # Errors
/// [`FigureError`] when the backend fails.
pub fn costs_figure(
    style: &StudyStyle,
    title: &str,
    trials: &[TrialPoint],
    flown: u64,
) -> Result<String, FigureError> {
    let shown = match trials.len() as u64 {
        n if n < flown => format!("The first {n} of {flown} trials"),
        n => format!("{n} trials"),
    };
    let remark = format!("{shown}, each a point; the origin is the nominal release.");
    let [pitch, rate] = style.release.map(|r| with_margin((r.0 * DEG_PER_RAD, r.1 * DEG_PER_RAD), 0.05));
    style.sheet(HEIGHT_PX, title, &remark, |pen| {
        color_bar(pen, &style.j_tpf, "TPF", (SIDE_PX.1, 40.0));
        map(pen, style, trials, pitch, rate);
        against(pen, style, trials, 0, (PITCH, pitch, |t| t.pitch_rad));
        against(pen, style, trials, 1, (RATE, rate, |t| t.pitch_rate_rad_s));
    })
}

/// Draws pitch rate over pitch, the cost as colour.
fn map(pen: &mut Pen<'_>, style: &StudyStyle, trials: &[TrialPoint], pitch: (f64, f64), rate: (f64, f64)) {
    let map = Panel {
        x: Axis { low: pitch.0, high: pitch.1, low_px: MAP_PX.0, high_px: MAP_PX.1 },
        y: Axis { low: rate.0, high: rate.1, low_px: BOTTOM_PX, high_px: TOP_PX },
    };
    names(pen, &map, PITCH, RATE);
    map.grid(pen, 6, 6, true);
    for (from, to) in
        [(map.px(0.0, rate.0), map.px(0.0, rate.1)), (map.px(pitch.0, 0.0), map.px(pitch.1, 0.0))]
    {
        pen.line(&[from, to], Stroke::solid(SOFT_INK, 0.8));
    }
    for t in trials {
        let at = map.px(t.pitch_rad * DEG_PER_RAD, t.pitch_rate_rad_s * DEG_PER_RAD);
        pen.disc(at, RADIUS_PX + 1.3, INK);
        pen.disc(at, RADIUS_PX + 0.6, style.j_tpf.color(t.j_tpf));
    }
}

/// Name, range [deg] and value [rad] of a quantity.
type Quantity = (&'static str, (f64, f64), fn(&TrialPoint) -> f64);

/// Draws the cost against one quantity.
fn against(pen: &mut Pen<'_>, style: &StudyStyle, trials: &[TrialPoint], row: u8, (name, x, of): Quantity) {
    let height = 0.5 * (BOTTOM_PX - TOP_PX - GAP_PX);
    let top = TOP_PX + f64::from(row) * (height + GAP_PX);
    let panel = side_panel(style, x, top, height);
    names(pen, &panel, name, &sub("J", "TPF"));
    panel.grid(pen, 6, 4, true);
    if style.j_tpf_range.1 > 0.95 {
        limit(pen, panel.px(x.0, 1.0), panel.px(x.1, 1.0));
    }
    for t in trials.iter().filter(|t| t.j_tpf.is_finite()) {
        let at = panel.px(of(t) * DEG_PER_RAD, t.j_tpf);
        pen.disc(at, RADIUS_PX + 0.6, INK);
        pen.disc(at, RADIUS_PX, style.j_tpf.color(t.j_tpf));
    }
}

fn side_panel(style: &StudyStyle, x: (f64, f64), top: f64, height: f64) -> Panel {
    let j = with_margin(style.j_tpf_range, 0.08);
    Panel {
        x: Axis { low: x.0, high: x.1, low_px: SIDE_PX.0, high_px: SIDE_PX.1 },
        y: Axis { low: j.0, high: j.1, low_px: top + height, high_px: top },
    }
}

fn names(pen: &mut Pen<'_>, panel: &Panel, x: &str, y: &str) {
    let ((x0, y0), (x1, y1)) = panel.corners();
    pen.text(y, (x0 - 44.0, y0 - 12.0), Anchor::Start, AXIS);
    pen.text(x, (0.5 * (x0 + x1), y1 + 34.0), Anchor::Middle, AXIS);
}
