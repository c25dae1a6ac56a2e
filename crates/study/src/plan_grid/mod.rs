//! The release states that a mission's grid of plans spans, and what interpolated plans cost: flights from
//! fresh releases along plans of the grid and along solved ones.

pub mod report;

use std::ops::ControlFlow;

use crate::controller::along_plan;
use samara_core::assess::{GridFlight, MISREAD_RATE_RAD_S, RandomRelease, StudyEntry};
use samara_core::control::ControlError;
use samara_core::model::rigid_body::BodyState;
use samara_core::plan::grid::{AXES, GridPlace, GridState, PlanGrid, grid_state};
use samara_core::plan::{Guess, PlanProblem, PlanState, SolverOptions, Status, plan};
use samara_core::random::Trials;
use samara_core::sim::nominal_state_at_t0;
use samara_core::trajectory::Trajectory;
use samara_mission::{Mission, UnplannedError};

/// Draws that the ranges of the axes hold.
const SPANNED: u64 = 1000;
/// What is added to a range at each end, as a share of it.
const MARGIN: f64 = 0.05;

/// The smallest box that holds the states at t = 0 of 1000 releases drawn as `monte_carlo` says, the
/// state that the plan begins in and that of the nominal drop, with a margin of 5 % at each end: low and
/// high of each axis of a plan grid, in SI.
pub fn grid_ranges(mission: &Mission) -> [[f64; 2]; AXES] {
    let releases = mission.releases();
    let drawn = (Trials::GridSpan.first()..)
        .take(SPANNED as usize)
        .map(|k| grid_state(&releases.draw(mission.seed, k).state));
    let dropped = nominal_state_at_t0(
        mission.vehicle.clone(),
        mission.site.environment.clone(),
        mission.release.parachute,
        mission.release.start,
    );
    let [q0, q1, q2, q3, v_north, v_east, v_down, p, q, r] = mission.plan_initial_state();
    let planned = BodyState {
        q_ned_from_body: [q0, q1, q2, q3],
        v_ned: nalgebra::Vector3::new(v_north, v_east, v_down),
        omega_body: nalgebra::Vector3::new(p, q, r),
        ..dropped
    };
    let nominal = [grid_state(&dropped), grid_state(&planned)];
    let mut ranges = [[f64::INFINITY, f64::NEG_INFINITY]; AXES];
    for state in nominal.into_iter().chain(drawn) {
        for ([low, high], value) in ranges.iter_mut().zip(state) {
            (*low, *high) = (low.min(value), high.max(value));
        }
    }
    ranges.map(|[low, high]| {
        let margin = MARGIN * (high - low);
        [low - margin, high + margin]
    })
}

/// Flights of the mission's own cascade from fresh releases along four plans each: solved for the release,
/// interpolated for it, solved for a pitch rate that is off, and the nominal one.
#[derive(Clone, Debug)]
pub struct GridJudge<'a> {
    mission: &'a Mission,
    problem: PlanProblem<'a>,
    options: SolverOptions,
    nominal: &'a Trajectory,
    entry: StudyEntry,
}

/// What came of a fresh release.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JudgedRelease {
    /// Release state in the plane of the manoeuvre.
    pub state: GridState,
    /// Where it lies in the grid.
    pub place: GridPlace,
    /// J_TPF of its flights; `None` where a solve for it did not converge.
    pub flight: Option<GridFlight>,
}

impl<'a> GridJudge<'a> {
    /// A judge whose solves have these options.
    ///
    /// # Errors
    /// [`ControlError`] for a vehicle that cannot be controlled.
    pub fn new(
        mission: &'a Mission,
        nominal: &'a Trajectory,
        options: SolverOptions,
    ) -> Result<Self, ControlError> {
        let entry = along_plan(mission, "plan_grid")?;
        Ok(Self { mission, problem: mission.plan_problem(), options, nominal, entry })
    }

    /// Flies from the fresh release of this number. What is solved for it begins in its whole state, with
    /// whatever the tip-off left of roll and yaw; the grid knows the plane alone.
    ///
    /// # Errors
    /// [`UnplannedError`] for a problem that cannot be posed.
    pub fn judge(&self, grid: &PlanGrid, number: u64) -> Result<JudgedRelease, UnplannedError> {
        let release = self.mission.releases().draw(self.mission.seed, Trials::GridJudged.first() + number);
        let state = grid_state(&release.state);
        let interpolated = grid.at(&state);
        let mut misread = release.state;
        misread.omega_body.y += MISREAD_RATE_RAD_S;
        let solved = self.solved(&release.state)?.zip(self.solved(&misread)?);
        let flight = solved.map(|(solved, misread)| GridFlight {
            solved: self.j_tpf(&solved, &release),
            interpolated: self.j_tpf(&interpolated.trajectory, &release),
            misread: self.j_tpf(&misread, &release),
            nominal: self.j_tpf(self.nominal, &release),
        });
        Ok(JudgedRelease { state, place: interpolated.place, flight })
    }

    /// The plan from a state at t = 0, solved from a straight line; `None` where that does not converge.
    fn solved(&self, state: &BodyState) -> Result<Option<Trajectory>, UnplannedError> {
        let problem = PlanProblem { initial: plan_state(state), ..self.problem.clone() };
        let solved = plan(&problem, &Guess::StraightLine, &self.options, &mut |_| ControlFlow::Continue(()))
            .map_err(|source| self.mission.unplanned(source))?;
        Ok((solved.status == Status::Converged).then_some(solved.trajectory))
    }

    fn j_tpf(&self, plan: &Trajectory, release: &RandomRelease) -> f64 {
        let study = self.mission.safety_study(plan);
        let flown = study.fly_releases(&self.entry, std::slice::from_ref(release));
        flown.first().map_or(f64::NAN, |outcome| outcome.j_tpf)
    }
}

fn plan_state(body: &BodyState) -> PlanState {
    let ([q0, q1, q2, q3], v, w) = (body.q_ned_from_body, &body.v_ned, &body.omega_body);
    [q0, q1, q2, q3, v.x, v.y, v.z, w.x, w.y, w.z]
}

#[cfg(test)]
mod tests {
    use super::*;
    use samara_core::assess::GridLoss;
    use samara_core::frames::pitch;
    use samara_core::plan::grid::{GridAxes, solve_grid_point};
    use samara_mission::{decode_plan_grid, encode_plan_grid};

    fn solved(mission: &Mission, shape: [usize; AXES]) -> (Trajectory, PlanGrid) {
        let options = SolverOptions::default();
        let nominal = mission.solve(&options, &mut |_| ControlFlow::Continue(())).unwrap();
        let axes = GridAxes::even(&grid_ranges(mission), shape).unwrap();
        let problem = mission.plan_problem();
        let plans = (0..axes.count()).map(|number| {
            let plan = solve_grid_point((&problem, &nominal), &axes.state(number), &options).unwrap();
            assert_eq!(plan.status, Status::Converged);
            plan.trajectory
        });
        let plans = plans.collect();
        (nominal.trajectory, PlanGrid::new(axes, plans).unwrap())
    }

    /// By the definition of the box: the drop's own states and nearly all fresh draws lie within.
    #[test]
    fn prop_the_ranges_hold_the_releases() {
        for name in ["titan_drop", "x500_drop"] {
            let mission = Mission::shipped(name).unwrap();
            let ranges = grid_ranges(&mission);
            let within = |state: &GridState| {
                state.iter().zip(&ranges).all(|(x, [low, high])| (low..=high).contains(&x))
            };
            let [q0, q1, q2, q3, v_north, _, v_down, ..] = mission.plan_initial_state();
            assert!(within(&[v_north, v_down, pitch([q0, q1, q2, q3]), 0.0]), "{ranges:?}");
            let releases = mission.releases();
            let fresh = (0..500).filter(|k| {
                within(&grid_state(&releases.draw(mission.seed, Trials::GridJudged.first() + k).state))
            });
            assert!(fresh.count() > 490, "{ranges:?}");
        }
    }

    /// Flights along solved plans are the reference: those along the interpolated ones of a small grid lose
    /// less than the bar on Earth, also release by release, with what the binary keeps of the numbers.
    #[test]
    fn reference_a_grid_flies_as_solves_do() {
        let mission = Mission::shipped("x500_drop").unwrap();
        let (nominal, grid) = solved(&mission, [2, 2, 2, 2]);
        let written = encode_plan_grid(&grid, &mission).unwrap();
        let read = decode_plan_grid(&written).unwrap().grid;
        let judge = GridJudge::new(&mission, &nominal, SolverOptions::default()).unwrap();
        let judged: Vec<JudgedRelease> = (0..12).map(|k| judge.judge(&read, k).unwrap()).collect();
        let flights: Vec<GridFlight> = judged.iter().filter_map(|release| release.flight).collect();
        let loss = GridLoss::of(&flights);
        assert!(loss.releases == 12 && loss.is_small() && loss.by_release.max < 1e-3, "{loss:?}");
        assert!(loss.by_release.min > -1e-4 && loss.solved.max < loss.nominal.max + 0.01, "{loss:?}");
    }
}
