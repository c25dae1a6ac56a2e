//! The convergence of a search: the best cost and the median of each iteration over the evaluations, on a
//! logarithmic scale, since a flight that breaks a bound or tumbles costs ten times as much as a good one.

use crate::tuning::report::TuneRun;
use samara_core::math;
use samara_core::tune::search::SearchProgress;
use samara_core::tune::{Objective, Search};
use samara_mission::{Mission, Stamp};
use samara_report::figure::WIDTH_PX;
use samara_report::figure::axis::{Axis, Panel, SMALL, TITLE, number, range};
use samara_report::figure::canvas::FigureError;
use samara_report::figure::canvas::{self, Anchor, Font, Pen, Point, Stroke, sub, text_width};
use samara_report::figure::color::{FIRST, GRID, INK, LIMIT, SECOND};
use samara_report::figure::label::{LabelPlace, Room};

const HEIGHT_PX: u32 = 420;
const CORNERS: (Point, Point) = ((70.0, 92.0), (936.0, 360.0));

/// Draws a search. An iteration with an infinite median, most of its candidates lost, leaves a gap in that
/// curve.
///
/// # Errors
/// [`FigureError`] when no cost is finite or the backend fails.
pub fn convergence_figure(mission: &Mission, search: &Search, run: &TuneRun) -> Result<String, FigureError> {
    let history = search.history();
    let least = range(history.iter().map(|p| p.cost)).ok_or(FigureError::Empty)?.0;
    let tallest = range(history.iter().flat_map(|p| [p.cost, p.median_cost])).map_or(least, |r| r.1);
    let ((x0, y0), (x1, y1)) = CORNERS;
    let last = history.last().map_or(1, |p| p.evaluations) as f64;
    let least = least.max(f64::MIN_POSITIVE);
    let decades = math::log10((tallest / least).max(1.1));
    // The logarithm of the cost is drawn straight.
    let (low, high) = (math::log10(least) - 0.06 * decades, math::log10(least) + 1.04 * decades);
    let panel = Panel { x: Axis::new((0.0, last), (x0, x1)), y: Axis::new((low, high), (y1, y0)) };
    let curve = |of: fn(&SearchProgress) -> f64| -> Vec<Point> {
        history.iter().map(|p| panel.px(p.evaluations as f64, math::log10(of(p).max(least)))).collect()
    };
    let (best, median) = (curve(|p| p.cost), curve(|p| p.median_cost));
    let headline = format!(
        "{}: {} by {}, cost {} after {} evaluations",
        mission.name,
        run.objective,
        run.method,
        number(run.bounds.cost(&run.gains.evaluation), 4),
        search.tried().len()
    );
    let stamp = Stamp { seed: mission.seed, input_hash: mission.hash_without_gains() };
    canvas::sheet((WIDTH_PX, HEIGHT_PX), (&headline, &stamp.csv_comment()), |pen| {
        pen.text(&headline, (16.0, 28.0), Anchor::Left, Font { size: 19.0, color: INK, bold: true });
        pen.text(&meaning_of_cost(run), (16.0, 54.0), Anchor::Left, SMALL);
        panel.grid(pen, 8, 0, true);
        for (cost, text) in logarithmic_ticks(math::powf(10f64, low), math::powf(10f64, high)) {
            let y = panel.y.px(math::log10(cost));
            pen.line(&[(x0, y), (x1, y)], Stroke::solid(GRID, 1.0));
            pen.text(&text, (x0 - 7.0, y), Anchor::Right, SMALL);
        }
        pen.text("cost (log)", (x0, y0 - 14.0), Anchor::Center, TITLE);
        pen.text("evaluations", (0.5 * (x0 + x1), y1 + 38.0), Anchor::Center, TITLE);
        // A front's bounds change on the way.
        for pair in history.windows(2).filter(|w| w[0].objective != w[1].objective) {
            let x = panel.x.px(pair[0].evaluations as f64);
            pen.line(&[(x, y0), (x, y1)], Stroke::dashed(LIMIT, 1.0, 3.0, 3.0));
        }
        let mut room = Room::new(CORNERS);
        room.line(pen, &median, Stroke::solid(SECOND, 1.2));
        room.line(pen, &best, Stroke::solid(FIRST, 2.2));
        let title = |color| Font { color, bold: true, ..TITLE };
        name_curve(pen, &median, ("median of the iteration", title(SECOND)), &mut room);
        name_curve(pen, &best, ("best so far", title(FIRST)), &mut room);
    })
}

/// The line below the headline: what the cost of the figure is.
fn meaning_of_cost(run: &TuneRun) -> String {
    let e = run.gains.evaluation;
    let j_tpf = sub("J", "TPF");
    match run.bounds {
        Objective::Rms => "The cost is the worst tracking RMS (46).".to_owned(),
        Objective::JTpf => format!("The cost is the worst {j_tpf} of {} flights.", run.flights),
        Objective::Safety { rms_bound, .. } => format!(
            "The cost is the worst {j_tpf} of {} flights, and more where the tracking RMS passes {} or a flight does not come to rest. \
             Found: {j_tpf} {}, RMS {}.",
            run.flights,
            number(rms_bound, 3),
            number(e.j_tpf, 4),
            number(e.rms, 4)
        ),
    }
}

/// Writes a curve's name beside it, where there is room.
fn name_curve(pen: &mut Pen<'_>, curve: &[Point], (name, font): (&str, Font), room: &mut Room) {
    let (w, n) = (text_width(name, font.size) + 4.0, curve.len());
    let stations = (1..16).map(|k| curve[k * (n - 1) / 16]);
    let places = stations
        .flat_map(|(x, y)| [-12.0, 12.0, -26.0].map(|dy| LabelPlace::around((x + 0.5 * w, y + dy), w, 14.0)));
    room.write(pen, (name, font), places);
}

/// Round numbers for a logarithmic scale: 1, 2 and 5 times powers of ten over more than a decade, evenly
/// spaced ones over less.
fn logarithmic_ticks(low: f64, high: f64) -> Vec<(f64, String)> {
    if high / low < 8.0 {
        return Axis::new((low, high), (0.0, 1.0)).ticks(6);
    }
    let (first, last) = (math::log10(low).floor() as i32, math::log10(high).ceil() as i32);
    let many = last - first > 4;
    (first..=last)
        .flat_map(|power| {
            let steps: &[f64] = if many { &[1.0] } else { &[1.0, 2.0, 5.0] };
            let decimals = (-power).max(0) as usize;
            steps.iter().map(move |m| (m * 10f64.powi(power), decimals))
        })
        .filter(|(x, _)| (low..=high).contains(x))
        .map(|(x, decimals)| (x, number(x, decimals)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_of_a_logarithmic_scale_are_round() {
        let texts =
            |low, high| -> Vec<String> { logarithmic_ticks(low, high).into_iter().map(|t| t.1).collect() };
        assert_eq!(texts(0.5, 12.0), ["0.5", "1", "2", "5", "10"]);
        assert_eq!(texts(0.56, 0.7), ["0.60", "0.65", "0.70"]);
        assert_eq!(texts(0.05, 3e5), ["0.1", "1", "10", "100", "1000", "10000", "100000"]);
    }
}
