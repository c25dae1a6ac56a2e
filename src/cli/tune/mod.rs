//! `samara tune`: gains by search, beside those that there are.
//!
//! | file | holds |
//! |---|---|
//! | `args` | what can be typed |
//! | `cascade` | the search of the cascade's gains |
//! | `near_hover` | Ziegler and Nichols on the vehicle's own loops, instead of a search |
//! | `px4` | `--for px4`: the search of PX4's parameters |
//! | `settings` | the flights that judge gains, and how they are searched |
//! | `contest` | the gains found beside others, on unseen flights |
//! | `results` | the files of a tuning, or why there are none |

mod args;
mod cascade;
mod contest;
mod near_hover;
mod px4;
mod results;
mod settings;

use super::answer::{Answer, Failure};
use super::mission::{open_mission, print_origin};
use super::planning::plan_mission;
use super::system::threads;
use super::terminal::{print_err, print_remarks};
pub use args::TuneArgs;
use args::{ForArg, MethodArg};
use results::report_nothing;
use samara::plan::Status;

/// Searches gains for samara's cascade or for PX4.
pub fn run(args: &TuneArgs) -> Result<Answer, Failure> {
    let mut mission = open_mission(&args.mission.mission, &args.set)?;
    print_origin(&args.mission, &mission)?;
    if !mission.faults.list.is_empty() {
        let remark = "faults: gains are searched and judged without them; `samara assess` flies motor faults";
        print_remarks(&mission.name, &[remark.to_owned()]);
    }
    if let Some(remark) = mission.battery_remark() {
        print_remarks(&mission.name, &[remark.to_owned()]);
    }
    if let Some(seed) = args.seed {
        mission.use_seed(seed);
    }
    let for_px4 = args.target == ForArg::Px4;
    if for_px4 {
        px4::refuse_unsuitable(args, &mission)?;
    }
    if !for_px4 && args.px4_version.is_some() {
        return Err(Failure::input("--px4-version: --for px4 is expected with it".to_owned()));
    }
    if args.method == MethodArg::NearHover && args.search.ask {
        return Err(Failure::input(
            "--ask has no meaning with --method near-hover: it searches nothing".to_owned(),
        ));
    }
    if !for_px4 {
        mission.t0_remarks().iter().for_each(|remark| print_err(&format!("samara: {remark}\n")));
    }
    let timed = plan_mission(&mission, false)?;
    if timed.plan.status != Status::Converged {
        let diagnosis = timed.plan.diagnosis.as_deref().unwrap_or("not converged");
        return report_nothing(args, &mission.name, &format!("no plan to tune on: {diagnosis}"));
    }
    let plan = timed.plan.trajectory;
    let threads = threads(args.threads)?;
    match args.method {
        _ if for_px4 => px4::run(args, &mission, &plan, &threads),
        MethodArg::NearHover => near_hover::run(args, &mission, &plan, &threads),
        MethodArg::PsoCma | MethodArg::Pso | MethodArg::CmaEs => {
            cascade::run(args, &mission, &plan, &threads)
        }
    }
}
