//! What to say beside a no of a mission: what `samara check` finds that explains it, else what mostly does.

use samara_core::assess::Verdict;
use samara_core::hints::No;
use samara_core::plan::Plan;
use samara_mission::{Mission, Odd};
use samara_report::DropRun;
use samara_report::hint::Hint;

use crate::checking::{Checked, checked, odd};

/// Most findings that are named as a cause.
const NAMED: usize = 2;

/// The hint of a drop that was not safe; `None` of one that was.
pub fn of_drop(mission: &Mission, verdict: Option<&Verdict>, run: &DropRun) -> Option<Hint> {
    let objections = run.objections(verdict);
    let no = objections.first()?.no();
    Some(of_no(no, mission, || checked(mission)))
}

/// The hint of a plan that was not found; `None` of one that was.
pub fn of_plan(mission: &Mission, plan: &Plan) -> Option<Hint> {
    Some(of_no(plan.no?, mission, || checked(mission)))
}

/// The hint of a no of a mission, which is looked at where that may explain it.
pub fn of_no(no: No, mission: &Mission, look: impl FnOnce() -> Checked) -> Hint {
    let usual = Hint::of(no, mission);
    let explained_by = no.hint().explained_by;
    if explained_by.is_empty() {
        return usual;
    }
    let found = odd(mission, &look());
    let explaining = explained_by.iter().flat_map(|by| found.iter().filter(|odd| odd.no == *by));
    let explaining: Vec<&Odd> = explaining.take(NAMED).collect();
    let Some(first) = explaining.first() else { return usual };
    let cause: Vec<&str> = explaining.iter().map(|odd| odd.text.as_str()).collect();
    Hint { no: usual.no, cause: cause.join("; "), ..Hint::of(first.no, mission) }
}
