//! `samara stream`: the offboard streamer behind its socket. Yes is a plan that was streamed to its end.

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;

use super::answer::{Answer, BadInput as _, Failure};
use super::args::{ChoiceArgs, DEFAULT_MISSION, NetArgs, PlanningArgs};
use super::live::{Known, Live, LiveArgs};
use super::mission::{mission_for_px4, mission_with_a_drop, origin, use_replan};
use super::narrator::Narrator;
use super::pilot::px4::upload::{envelope, of_any};
use super::planning::plan_and_say;
use super::reporter::Reporter;
use super::system::block_on;
use super::terminal::print_remarks;
use samara::link::parties::{self, StreamerChoice};
use samara::link::shell::run_streamer;
use samara::link::streamer::{Procedure, SolvedBy};
use samara::plan::Status;
use samara::replan::{Cadence, ReplanSetup};

/// `samara stream`.
#[derive(Args, Debug)]
pub struct StreamArgs {
    /// The mission: a file, or a name - of a file in ./mission, or of a mission that samara brings along.
    #[arg(value_name = "NAME|FILE", default_value = DEFAULT_MISSION)]
    pub mission: PathBuf,
    /// What the mission leaves to choose.
    #[command(flatten)]
    pub choice: ChoiceArgs,
    /// Ports.
    #[command(flatten)]
    pub net: NetArgs,
    /// Stream this trajectory instead of planning one.
    #[arg(long, value_name = "FILE")]
    pub trajectory: Option<PathBuf>,
    /// How much to show of the planning.
    #[command(flatten)]
    pub planning: PlanningArgs,
    /// Renew the plan during the drop: at the `release`, or from it on at a rate [Hz].
    ///
    /// From the vehicle's telemetry, with the plan's acceleration fed forward. A solve that is not over when
    /// its plan is to take effect, by the vehicle's clock, is late, and the plan is kept.
    #[arg(long, value_name = "release|HZ", conflicts_with = "trajectory")]
    pub replan: Option<Cadence>,
    /// Send the plan's acceleration with its velocity.
    #[arg(long)]
    pub feed_forward: bool,
    /// Give a PX4 that is up already what a drop needs, before anything else.
    ///
    /// What `samara drop` would give it: what every drop requires, the vehicle's hover thrust, thrust curve
    /// and (v1.14 and later) rotors, and the gains - those of the mission's `px4_params`, of --params or
    /// --gains.
    /// Each must be echoed. PX4 keeps them.
    #[arg(long)]
    pub upload: bool,
    /// The page while it flies.
    #[command(flatten)]
    pub live: LiveArgs,
}

/// Streams a plan from the release to its end, and then the target velocity.
pub fn run(args: &StreamArgs) -> Result<Answer, Failure> {
    let (mut mission, parameters) = match args.upload {
        true => mission_for_px4(&args.mission, &args.choice, None)?,
        false => (mission_with_a_drop(&args.mission, &args.choice)?, None),
    };
    mission.control.feed_forward |= args.feed_forward;
    if let Some(cadence) = args.replan {
        use_replan(&mut mission, cadence, &args.choice, true)?;
        if parties::froude(&mission).is_some() {
            let why = "--replan: a vehicle on the site's own clock is expected with it (px4_clock: real)";
            return Err(Failure::input(why.to_owned()));
        }
    }
    let (ports, sign) = (args.net.ports()?, args.net.sign()?);
    let narrator = Narrator::alone(false);
    narrator.say(&origin(&args.mission, &mission));
    let mut plan = None;
    let trajectory = match &args.trajectory {
        Some(path) => mission.use_trajectory(path, None).bad_input()?.trajectory,
        None => {
            let timed = plan_and_say(&mission, args.planning.verbose, &narrator)?;
            if timed.plan.status != Status::Converged {
                return Ok(Answer::No);
            }
            let trajectory = timed.plan.trajectory.clone();
            plan = Some(timed.plan);
            trajectory
        }
    };
    let replan = args.replan.zip(plan).map(|(cadence, plan)| {
        let (source, settings) = (Arc::new(mission.clone()), mission.replan.settings);
        (ReplanSetup { source, plan, cadence, settings }, SolvedBy::Host)
    });
    let procedure = match args.upload {
        true => {
            let (procedure, remarks) = of_any(&mission, &trajectory, parameters.as_ref())?;
            print_remarks(&mission.control.gains_name, &remarks);
            procedure
        }
        false => Procedure {
            envelope: envelope(&mission, &trajectory),
            canopy_moves: mission.release.parachute.suspension.is_some(),
            ..Procedure::default()
        },
    };
    let choice = StreamerChoice {
        procedure: Some(procedure),
        replan,
        froude: parties::froude(&mission),
        ..StreamerChoice::default()
    };
    let system = args.net.system()?;
    let vehicle = (system, parties::froude(&mission));
    let live = Live::open(&args.live, (&mission, Some(&trajectory)), Known::Told, vehicle)?;
    let session = parties::streamer(&mission, trajectory, system, choice);
    let mut reporter = Reporter::new(&narrator, &mission).shown(Some(&live));
    let session =
        block_on(|stop| run_streamer(session, &ports, sign.as_ref(), &mut reporter, stop))?.bad_input()?;
    reporter.finish()?;
    // Why it has failed, the streamer has reported.
    let shortcoming = match session.shortcoming() {
        _ if !session.is_plan_over() && !session.is_over() => {
            Some("stopped before the plan was at its end".to_owned())
        }
        Some(why) if session.is_plan_over() => Some(format!("no drop by the plan: {why}")),
        _ => None,
    };
    if let Some(why) = &shortcoming {
        narrator.say(&format!("{why}\n"));
    }
    let streamed = if session.has_succeeded() { "the plan was streamed to its end" } else { "given up" };
    live.over(shortcoming.as_deref().unwrap_or(streamed));
    narrator.check()?;
    Ok(Answer::from(session.has_succeeded()))
}
