//! A search as text for the terminal.

use super::TuneRun;
use crate::assess::tracking::OUT_OF_PLANE;
use crate::config::Mission;
use crate::tune::Search;

/// The search, its effort and result, and the comparison of gains.
pub fn text(mission: &Mission, search: &Search, run: &TuneRun) -> String {
    let e = run.gains.evaluation;
    let diverged = search.history().last().map_or(0, |p| p.diverged);
    let out = format!(
        "{}: {} by {}, {} plant: {} evaluations of {} flights in {:.1} s ({} diverged){}\n\
         commanded every {:.3} ms;{} \
         cost {:.4}: worst tracking RMS {:.4}, worst J_TPF {:.4}{}\n\n",
        mission.name,
        run.objective,
        run.method,
        run.model,
        search.tried().len(),
        run.flights,
        run.wall_s,
        diverged,
        if run.stopped { ", stopped" } else { "" },
        1e3 * run.control_period_s,
        if mission.site.environment.wind_ned_m_s.y == 0.0 { "" } else { OUT_OF_PLANE },
        run.cost(),
        e.rms,
        e.j_tpf,
        if run.bounds.allows(&e) { "" } else { ": THE BOUNDS DO NOT HOLD" },
    );
    out + &run.contest.as_ref().map_or_else(
        || "stopped: not tried on unseen flights; --resume goes on\n".to_owned(),
        super::Contest::text,
    )
}
