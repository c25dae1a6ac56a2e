//! `samara plan --grid`: plans on a grid of release states, for flight computers that cannot solve.

use clap::Args;

use super::answer::{Answer, BadInput as _, Failure};
use super::args::whole;
use super::progress::ProgressLine;
use super::results::OutputFolder;
use super::system::{self, Stopwatch};
use super::terminal::{print, print_err};
use samara::config::{Mission, UnplannedError, decode_plan_grid, encode_plan_grid, write_plan_grid_csv};
use samara::host::Threads;
use samara::plan::grid::{AXES, GridAxes, PlanGrid, check_size, solve_grid_point};
use samara::plan::{Plan, SolverOptions, Status};
use samara::study::plan_grid::report::{GridJudgement, PlanGridReport, grid_state_words};
use samara::study::plan_grid::{GridJudge, JudgedRelease, grid_ranges};
use samara::units::RAD_PER_DEG;

/// Files of a grid: those of an earlier one go where there is none.
pub const FILES: [&str; 3] = ["plan_grid.csv", "plan_grid.bin", "plan_grid.json"];
/// Points on the axes unless it is said otherwise.
const SHAPE: &str = "2x2x7x17";
/// An axis that spans less has one point unless it is said otherwise, in SI: 0.1 m/s, 1 deg, 1 deg/s.
const NARROW: [f64; AXES] = [0.1, 0.1, RAD_PER_DEG, RAD_PER_DEG];
/// Names of the axes on the command line, and SI units in one of theirs.
const RANGES: [(&str, f64); AXES] =
    [("v_north", 1.0), ("v_down", 1.0), ("pitch", RAD_PER_DEG), ("pitch_rate", RAD_PER_DEG)];
/// Points that did not converge and are named one by one.
const NAMED: usize = 5;

/// What can be typed for a grid of plans.
#[derive(Args, Debug)]
#[command(next_help_heading = "Grid of plans")]
pub struct GridArgs {
    /// Plan on a grid of release states: plan_grid.csv, plan_grid.bin.
    ///
    /// So many points of velocity north and down, pitch and pitch rate at t = 0; 2x2x7x17 unless
    /// given, and one point where next to nothing varies.
    #[arg(
        long,
        value_name = "NxNxNxN",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = SHAPE,
        value_parser = shape,
        conflicts_with = "time_limit"
    )]
    pub grid: Option<Shape>,
    /// Ranges of the grid's axes, such as pitch=-10:10 [m/s, deg, deg/s].
    ///
    /// v_north, v_down, pitch, pitch_rate, commas between; the others hold what `monte_carlo` draws.
    #[arg(long, value_name = "RANGES", value_parser = ranges, requires = "grid")]
    pub grid_range: Option<Ranges>,
    /// Fresh releases that the grid's loss is measured by; 0 for none.
    #[arg(long, value_name = "N", default_value_t = 300, value_parser = whole::<u32>(0..=1_000_000), requires = "grid")]
    pub grid_check: u32,
    /// Threads of the grid; the results do not depend on it.
    #[arg(long, value_name = "N", value_parser = whole::<u16>(1..=256), requires = "grid")]
    pub threads: Option<u16>,
}

/// Points of each axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shape(pub [usize; AXES]);

fn shape(text: &str) -> Result<Shape, String> {
    let points = |part: &str| part.parse().ok().filter(|n| (1..=64).contains(n));
    let numbers: Option<Vec<usize>> = text.split('x').map(points).collect();
    let numbers = numbers.and_then(|numbers| numbers.try_into().ok());
    numbers
        .map(Shape)
        .ok_or_else(|| format!("four numbers of points from 1 to 64 are expected, such as {SHAPE}"))
}

/// Ranges in SI of those axes that one was given for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ranges(pub [Option<[f64; 2]>; AXES]);

fn ranges(text: &str) -> Result<Ranges, String> {
    let mut ranges = [None; AXES];
    for part in text.split(',') {
        let refused = || {
            let names = RANGES.map(|(name, _)| name).join(", ");
            format!("ranges such as pitch=-10:10 of {names} are expected, none twice, found `{part}`")
        };
        let (name, ends) = part.split_once('=').ok_or_else(refused)?;
        let axis = RANGES.iter().position(|(known, _)| *known == name.trim()).ok_or_else(refused)?;
        let (low, high) = ends.split_once(':').ok_or_else(refused)?;
        let [low, high] = [low, high].map(|end| end.trim().parse::<f64>().ok());
        // No release comes near: as bounded as numbers in files.
        let bounded = |x: &f64| x.abs() <= 1000.0;
        let (Some(low), Some(high)) = (low.filter(bounded), high.filter(bounded)) else {
            return Err(refused());
        };
        if low > high || ranges[axis].is_some() {
            return Err(refused());
        }
        ranges[axis] = Some([low, high].map(|end| end * RANGES[axis].1));
    }
    Ok(Ranges(ranges))
}

/// The grid that is asked for of a mission; `None` where none is.
pub fn axes_of(args: &GridArgs, mission: &Mission) -> Result<Option<GridAxes>, Failure> {
    let Some(Shape(shape)) = args.grid else { return Ok(None) };
    let refused = |message: &str| Err(Failure::input(format!("{}: {message}", mission.file.display())));
    if mission.release.standing {
        return refused("--grid is about drops, and this mission begins on the ground");
    }
    if mission.plan.demands.horizon.is_some() {
        return refused(
            "--grid: plans of a free horizon (plan.free_horizon) have nodes at times of their own",
        );
    }
    mission.faults.check_from_t0().bad_input()?;
    let mut spanned = grid_ranges(mission);
    for (range, given) in spanned.iter_mut().zip(args.grid_range.unwrap_or(Ranges([None; AXES])).0) {
        *range = given.unwrap_or(*range);
    }
    let is_default = self::shape(SHAPE) == Ok(Shape(shape));
    let shape = std::array::from_fn(|axis| {
        let spans = spanned[axis][1] - spanned[axis][0];
        // Where nothing varies one point says all.
        if spans == 0.0 || is_default && spans < NARROW[axis] { 1 } else { shape[axis] }
    });
    let axes = GridAxes::even(&spanned, shape).bad_input()?;
    check_size(axes.count(), mission.plan.nodes).bad_input()?;
    Ok(Some(axes))
}

/// Solves the grid beside the nominal plan, writes it and measures what interpolating costs.
pub fn run(
    args: &GridArgs,
    json: bool,
    axes: GridAxes,
    (mission, nominal): (&Mission, &Plan),
    options: &SolverOptions,
    folder: &OutputFolder,
) -> Result<Answer, Failure> {
    let threads = system::threads(args.threads)?;
    let watch = Stopwatch::start();
    let plans = solved(&threads, &axes, (mission, nominal), options)?;
    let solve_s = 1e-3 * watch.ms();
    let failed: Vec<usize> =
        (0..plans.len()).filter(|point| plans[*point].status != Status::Converged).collect();
    if !failed.is_empty() {
        return unsolved(&failed, &plans, &axes, json, mission, folder);
    }
    let grid = PlanGrid::new(axes, plans.into_iter().map(|plan| plan.trajectory).collect()).bad_input()?;
    let bytes = encode_plan_grid(&grid, mission).bad_input()?;
    folder.write("plan_grid.csv", |out| write_plan_grid_csv(out, &grid, &mission.stamp()))?;
    folder.write("plan_grid.bin", |out| std::io::Write::write_all(out, &bytes))?;
    // What is flown is what a flight computer reads.
    let grid = decode_plan_grid(&bytes).bad_input()?.grid;
    let watch = Stopwatch::start();
    let judged = judged(&threads, &grid, (mission, nominal), options, args.grid_check)?;
    let flight_s = 1e-3 * watch.ms();
    let report = PlanGridReport {
        mission,
        axes: grid.axes(),
        nodes: nominal.trajectory.nodes().len(),
        bytes: bytes.len(),
        judged: judged.as_deref().map(GridJudgement::of),
    };
    folder.write_text("plan_grid.json", &report.json(None))?;
    let points = grid.axes().shape().map(|n| n.to_string()).join("x");
    let ends = |axis: &Vec<f64>| format!("{:?}:{:?}", axis[0], axis[axis.len() - 1]);
    let ranges: Vec<String> = grid.axes().points().iter().map(ends).collect();
    let circumstances =
        [("grid", points), ("grid_ranges_si", ranges.join(",")), ("grid_check", args.grid_check.to_string())];
    folder.write_manifest("plan_grid", mission, &circumstances)?;
    let seconds = Some([solve_s, flight_s]);
    let document = report.document(seconds);
    let verdict = document.verdict.as_ref().map_or(String::new(), |(_, sentence)| format!("\n{sentence}\n"));
    folder.print_result(json, || report.json(seconds), || format!("\n{}{verdict}\n", document.text()))?;
    Ok(Answer::from(report.is_good()))
}

/// The plans of all grid points, in their order, each solved by itself.
fn solved(
    threads: &Threads,
    axes: &GridAxes,
    (mission, nominal): (&Mission, &Plan),
    options: &SolverOptions,
) -> Result<Vec<Plan>, Failure> {
    let problem = mission.plan_problem();
    let progress = ProgressLine::new("plan", "grid points", axes.count() as u64);
    let solve = |point: usize| {
        let plan = solve_grid_point((&problem, nominal), &axes.state(point), options);
        progress.inc(1);
        plan.map_err(|source| mission.unplanned(source))
    };
    let plans: Result<Vec<Plan>, UnplannedError> =
        threads.each(&(0..axes.count()).collect::<Vec<_>>(), |point| solve(*point)).into_iter().collect();
    progress.finish();
    plans.bad_input()
}

/// Flights from so many fresh releases; `None` of none.
fn judged(
    threads: &Threads,
    grid: &PlanGrid,
    (mission, nominal): (&Mission, &Plan),
    options: &SolverOptions,
    releases: u32,
) -> Result<Option<Vec<JudgedRelease>>, Failure> {
    if releases == 0 {
        return Ok(None);
    }
    let judge = GridJudge::new(mission, &nominal.trajectory, *options).bad_input()?;
    let progress = ProgressLine::new("plan", "fresh releases", u64::from(releases));
    let fly = |number: u32| {
        let judged = judge.judge(grid, u64::from(number));
        progress.inc(1);
        judged
    };
    let judged: Result<Vec<JudgedRelease>, UnplannedError> =
        threads.each(&(0..releases).collect::<Vec<_>>(), |release| fly(*release)).into_iter().collect();
    progress.finish();
    judged.bad_input().map(Some)
}

/// Names the grid points without a plan: a grid is whole, or there is none.
fn unsolved(
    failed: &[usize],
    plans: &[Plan],
    axes: &GridAxes,
    json: bool,
    mission: &Mission,
    folder: &OutputFolder,
) -> Result<Answer, Failure> {
    folder.remove_leftovers(&FILES)?;
    let reason = |point: usize| {
        let diagnosis = plans[point].diagnosis.as_deref().unwrap_or("no plan");
        format!("grid point {point}, {}: {diagnosis}", grid_state_words(&axes.state(point)))
    };
    folder.write_manifest("plan", mission, &[])?;
    let named: Vec<String> = failed.iter().take(NAMED).map(|point| reason(*point)).collect();
    let (count, all) = (failed.len(), axes.count());
    let rest = if count > NAMED { format!("\n{} more", count - NAMED) } else { String::new() };
    print_err(&format!(
        "samara: no grid: {count} of {all} grid points have no plan; a narrower --grid-range leaves them out\n{}{rest}\n",
        named.join("\n")
    ));
    if json {
        let unsolved = failed.iter().map(|point| axes.state(*point)).collect::<Vec<_>>();
        let object = serde_json::json!({ "mission": mission.name, "plans": all, "unsolved": unsolved });
        print(&format!("{object:#}\n"))?;
    }
    Ok(Answer::No)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_shapes_and_ranges() {
        assert_eq!(shape("2x1x64x9"), Ok(Shape([2, 1, 64, 9])));
        for wrong in ["", "3", "2x2x2", "2x2x2x2x2", "0x1x1x1", "65x1x1x1", "2x2x-1x2", "axbxcxd"] {
            assert!(shape(wrong).is_err(), "{wrong}");
        }
        let Ranges([north, down, pitch, rate]) = ranges("pitch=-180:90,v_down=3:3").unwrap();
        assert_eq!((north, down, rate), (None, Some([3.0, 3.0]), None));
        assert_eq!(pitch, Some([-std::f64::consts::PI, std::f64::consts::FRAC_PI_2]));
        for wrong in [
            "",
            "pitch",
            "pitch=1",
            "yaw=1:2",
            "pitch=2:1",
            "pitch=NaN:1",
            "v_down=0:1e9",
            "pitch=1:2,pitch=1:2",
        ] {
            assert!(ranges(wrong).is_err(), "{wrong}");
        }
    }
}
