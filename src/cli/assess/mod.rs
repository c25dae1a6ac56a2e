//! `samara assess`: the paper's safety study - release cases, campaigns, tables, figures, one page.

mod campaign;
mod drops;
mod figures;
mod only;

use std::io::Write as _;

use anyhow::anyhow;
use clap::Args;

use super::args::{AutopilotArg, ChoiceArgs, MissionArgs, PatienceArgs, StateArgs, whole};
use super::belongs;
use super::clock::Stopwatch;
use super::interrupt;
use super::mission::chosen_mission;
use super::narrative::Narrator;
use super::outcome::{Answer, BadInput, Failure};
use super::output::{OutputFolder, print};
use super::plan::{plan_mission, write_plan};
use super::pool::pool;
use campaign::{Bench, Campaign};
use samara::assess::{Command, Controller, SafetyStudy, Summary, plan_j_tpf, tracking};
use samara::config::Mission;
use samara::control::{Airframe, Gains};
use samara::plan::{Plan, Status};
use samara::report::plan_text;
use samara::report::study::{Assessed, Assessment, CaseResult, OURS, page, records, tables};

/// The help of `samara assess`.
pub const ASSESS_HELP: &str = "\
Flies the paper's section V for four controllers - near-hover with the target as a step, near-hover and the paper's PSO gains on the
optimal trajectory, and `ours`, the gains of the mission or --gains, on it too: the release cases of Table 5, and a Monte Carlo
campaign each over the same random releases (40)-(44). Flights are at 100 Hz, on the plant with actuators, from t = 0 of the study.

Writes to the folder of --out: assess.html (everything on one page), assess.txt, assess.json, table4.csv, table5.csv,
campaigns.csv, campaign_<name>.csv (every trial: what was drawn, what came of it), fig07..fig16 (.svg: the paper's figures 7 to 14
and two of ours), trajectory.csv, plan.json, plan.svg. The same command writes the same bytes on any number of threads.

A campaign may be stopped (Ctrl-C) and continued with --resume, also to more --trials; its files are those of one that was not stopped.

JSON (--json): mission, vehicle, version, seed, input_hash, command, gains, trials, bound, safe, confidence, plan_objective,
plan_j_tpf, paper_plan_j_tpf, table4 (gains by name), table5 (per controller: name, gains, command, worst_j_tpf, cases: case, j_tpf,
tracking_rms, paper_j_tpf), campaigns (name, gains, command, trials, mean, mean_low, mean_high, std, min, max, p_safe, p_safe_low,
p_safe_high, unsafe_trials, paper_mean, paper_std, paper_min, paper_max), findings (claim, paper, here, bar, reproduced, why),
flights_per_s. *_low and *_high are 95 % intervals (Student's t, Clopper-Pearson). What is the paper's is there for its own mission only.

With --autopilot: seeded drops, from the hang to the end, by samara's autopilot, by PX4 or by the model of its control law. Each has the swing and the wind of the mission's
monte_carlo and noise of its own; the plan is the nominal one. Several fly side by side (--threads; PX4s as instances from --instance on). What would be wrong for each of them (a mission that
does not suit, a port in use) is looked for before the first: exit code 2. Writes
drops_<autopilot>_<gains>.csv, a line for each as it is over, and the folder trial_<K> with all files of one that failed, or of --only's.
A drop fails when a limit is passed, a failsafe flies, steady flight is not reached, or the autopilot dies or refuses.
JSON: mission, version, seed, input_hash, autopilot, gains, trials, failed (trial, failure), measures (name, count, mean, std, min, max).

Exit code 1 when a drop failed, a trial of `ours` reaches the bound, the plan did not converge, or the campaigns were stopped.

Examples:
  samara assess
  samara assess --gains near_hover --trials 1000 --seed 7
  samara assess --trials 100000 --out out/long      (Ctrl-C; then the same with --resume)
  samara assess --only 41                           (one trial again, with its flight log and figure)
  samara assess mission/x500_drop.json --autopilot px4=../PX4-Autopilot/build/px4_sitl_default --trials 50
  samara assess mission/x500_drop.json --autopilot reference --only 7
  samara assess mission/x500_drop.json --json";

/// `samara assess`.
#[derive(Args, Debug)]
pub struct AssessArgs {
    /// Mission, folder, output form.
    #[command(flatten)]
    pub mission: MissionArgs,
    /// What the mission leaves to choose.
    #[command(flatten)]
    pub choice: ChoiceArgs,
    /// Trials of each campaign, instead of the mission's.
    #[arg(long, value_name = "N", value_parser = whole::<u64>(2..=1_000_000_000))]
    pub trials: Option<u64>,
    /// J_TPF that a safe trial stays below.
    #[arg(long, value_name = "B", default_value_t = 1.0, value_parser = super::args::positive)]
    pub bound: f64,
    /// Continue the campaigns whose files are in the folder; they must be of the same inputs and seed.
    #[arg(long)]
    pub resume: bool,
    /// Fly trial K of each campaign alone: prints what was drawn and what came of it, writes flight logs and figures.
    #[arg(long, value_name = "K", value_parser = whole::<u64>(0..=u64::MAX), conflicts_with_all = ["trials", "resume"])]
    pub only: Option<u64>,
    /// Fly whole drops, from the canopy to the end, instead of the study: by samara's own autopilot, by PX4 from its build folder, or by
    /// the model of PX4's control law.
    #[arg(long, value_name = "reference|px4=DIR|px4-model", value_parser = super::args::autopilot, conflicts_with_all = ["bound", "resume"])]
    pub autopilot: Option<AutopilotArg>,
    /// What the autopilot flies by, with --autopilot.
    #[command(flatten)]
    pub state: StateArgs,
    /// Send the plan's acceleration with its velocity, to PX4.
    #[arg(long, requires = "autopilot")]
    pub feed_forward: bool,
    /// With --autopilot: number of the first vehicle; those flown side by side have the next ones.
    #[arg(long, value_name = "0..9", default_value_t = 0, value_parser = super::net::instance, requires = "autopilot")]
    pub instance: u16,
    /// How long PX4 may keep a flight waiting.
    #[command(flatten)]
    pub patience: PatienceArgs,
    /// Threads to fly on [default: one for each core; 2 for drops by PX4, and there no more than instances are left]; the results
    /// are the same.
    #[arg(long, value_name = "N", value_parser = whole::<u16>(1..=1024))]
    pub threads: Option<u16>,
}

impl AssessArgs {
    /// Options that not every autopilot has, and whether each is asked for.
    fn asked(&self) -> [(&'static str, bool); 4] {
        [
            (belongs::ESTIMATOR, self.state.asked()),
            (belongs::PATIENCE, self.patience.asked()),
            (belongs::FEED_FORWARD, self.feed_forward),
            (belongs::PX4_DEFAULT, self.choice.px4s_own_gains()),
        ]
    }
}

/// `samara assess`.
pub fn run(args: &AssessArgs) -> Result<Answer, Failure> {
    let stop = interrupt::flag()?;
    if let Some(autopilot) = &args.autopilot {
        return drops::run(args, autopilot, &stop);
    }
    // The study has no autopilot on a wire.
    if let Some((option, _)) = args.asked().into_iter().find(|(_, asked)| *asked) {
        return Err(anyhow!("{option}: --autopilot is expected with it")).bad_input();
    }
    let mission = chosen_mission(&args.mission.mission, &args.choice)?;
    if mission.study.cases.is_empty() {
        let file = args.mission.mission.display();
        return Err(anyhow!("{file}: tuning.cases is empty; the release cases of Table 5 are expected"))
            .bad_input();
    }
    let narrator = Narrator::alone(args.mission.json);
    let folder = OutputFolder::create(args.mission.out.as_deref(), &mission.name)?;
    let Some(plan) = planned(args, &mission, &folder, &narrator)? else { return Ok(Answer::No) };
    let study = study_of(&mission, &plan)?;
    let bench = Bench {
        study: &study,
        distribution: mission.releases(),
        seed: mission.seed,
        pool: pool(args.threads.map(usize::from))?,
        stop: &stop,
    };
    let controllers = controllers_of(&mission);
    if let Some(trial) = args.only {
        return only::run(args, &mission, &bench, &controllers, trial, &folder);
    }
    let trials = args.trials.unwrap_or(mission.study.monte_carlo.trials as u64);
    let watch = Stopwatch::start();
    let Some(campaigns) =
        campaign::run_all(args, &mission, &bench, &controllers, trials, &folder, &narrator)?
    else {
        return Ok(Answer::No);
    };
    let flown: u64 = campaigns.iter().map(|c| c.flown_now).sum();
    let flights_per_s = 1e3 * flown as f64 / watch.ms();
    let difference = campaign::paired_difference(&mission, &bench, &folder, [&campaigns[1], &campaigns[2]])?;
    let assessment = Assessment {
        pso_less_near_hover: difference,
        ..assessment(args, &mission, &plan, &bench, &campaigns, trials)
    };
    write(&assessment, &bench, &campaigns, &folder)?;
    folder.write_manifest(
        "assess",
        &mission,
        &[("trials", trials.to_string()), ("bound", args.bound.to_string())],
    )?;
    if args.mission.json {
        print(&records::assess_json(&assessment, (flown > 0).then_some(flights_per_s)))?;
    } else {
        print(&tables::assess_text(&assessment))?;
        print(&format!(
            "{flown} campaign flights, {flights_per_s:.0} a second; results in {0}, start with {0}/assess.html\n",
            folder.path().display()
        ))?;
    }
    Ok(if assessment.safe() { Answer::Yes } else { Answer::No })
}

/// The plan that is flown; `None` when there is none.
fn planned(
    args: &AssessArgs,
    mission: &Mission,
    folder: &OutputFolder,
    narrator: &Narrator,
) -> Result<Option<Plan>, Failure> {
    let timed = plan_mission(mission, false)?;
    write_plan(folder, mission, &timed.plan)?;
    if timed.plan.status == Status::Converged {
        return Ok(Some(timed.plan));
    }
    narrator.say(&format!(
        "no optimal trajectory to assess: {}",
        plan_text(&timed.plan, &mission.limits.safety, None)
    ))?;
    if args.mission.json {
        print(&samara::report::plan_json(mission, &timed.plan, Some(timed.solve_ms)))?;
    }
    Ok(None)
}

fn study_of(mission: &Mission, plan: &Plan) -> Result<SafetyStudy, Failure> {
    Ok(SafetyStudy {
        vehicle: mission.vehicle.clone(),
        environment: mission.site.environment.clone(),
        airframe: Airframe::new(&mission.vehicle, &mission.site.environment).bad_input()?,
        control_limits: mission.control.limits,
        limits: mission.limits.safety,
        target_v_ned: mission.target_v_ned,
        plan: plan.trajectory.clone(),
    })
}

fn controllers_of(mission: &Mission) -> [Controller; 4] {
    let of = |name, gains_name: &str, gains, command| Controller {
        name,
        gains_name: gains_name.to_owned(),
        gains,
        command,
    };
    [
        of("near_hover_step", "near_hover", Gains::near_hover(), Command::Step),
        of("near_hover_optimal", "near_hover", Gains::near_hover(), Command::Optimal),
        of("paper_pso_optimal", "paper_pso", Gains::paper_pso(), Command::Optimal),
        of(OURS, &mission.control.gains_name, mission.control.gains, Command::Optimal),
    ]
}

/// Flies the release cases and puts the study together.
fn assessment<'a>(
    args: &AssessArgs,
    mission: &'a Mission,
    plan: &Plan,
    bench: &Bench<'_>,
    campaigns: &[Campaign; 4],
    trials: u64,
) -> Assessment<'a> {
    let cases = |controller: &Controller| {
        bench.in_order(&mission.study.cases, |case| {
            let start = case.state();
            CaseResult {
                case: case.name.clone(),
                j_tpf: bench.study.outcome(controller, &start).j_tpf,
                tracking_rms: bench.study.tracking_rms(controller, &start),
            }
        })
    };
    Assessment {
        mission,
        command: command_line(args, mission, trials),
        plan_j_tpf: plan_j_tpf(&plan.trajectory, &mission.limits.safety),
        plan_objective: plan.objective,
        bound: args.bound,
        trials,
        is_the_papers: mission.is_the_papers_study(),
        pso_less_near_hover: Summary::default(),
        tracking_period_s: tracking::control_period_s(&plan.trajectory),
        assessed: campaigns.each_ref().map(|c| Assessed {
            controller: c.controller.clone(),
            cases: cases(&c.controller),
            tally: c.tally,
        }),
    }
}

/// The command that makes the study again, its choices spelt out; where its results go and on how many threads is not of it.
fn command_line(args: &AssessArgs, mission: &Mission, trials: u64) -> String {
    let mut command = format!("samara assess {}", args.mission.mission.display());
    if let Some(gains) = &args.choice.gains {
        command += &format!(" --gains {gains}");
    }
    if let Some(params) = &args.choice.params {
        command += &format!(" --params {}", params.display());
    }
    command += &format!(" --seed {} --trials {trials}", mission.seed);
    if args.bound != 1.0 {
        command += &format!(" --bound {}", args.bound);
    }
    command
}

fn write(
    assessment: &Assessment<'_>,
    bench: &Bench<'_>,
    campaigns: &[Campaign; 4],
    folder: &OutputFolder,
) -> Result<(), Failure> {
    let drawn = figures::draw(assessment, bench, campaigns)?;
    let files = [
        ("assess.txt", tables::assess_text(assessment)),
        ("assess.json", records::assess_json(assessment, None)),
        ("table4.csv", records::table_4_csv(assessment)),
        ("table5.csv", records::table_5_csv(assessment)),
        ("campaigns.csv", records::campaigns_csv(assessment)),
        ("assess.html", page::page(assessment, &drawn)),
    ];
    for (name, text) in &files {
        folder.write(name, |out| out.write_all(text.as_bytes()))?;
    }
    for figure in &drawn {
        folder.write(&figure.file, |out| out.write_all(figure.svg.as_bytes()))?;
    }
    Ok(())
}
