//! `samara stream`: the offboard streamer behind its socket. Yes is a plan that was streamed to its end.

use super::args::StreamArgs;
use super::mission::mission_with_a_drop;
use super::narrative::Narrator;
use super::net::{Reporter, block_on, key_of, ports_of, system_of};
use super::outcome::{Answer, BadInput, Failure};
use super::plan::plan_mission;
use super::px4::upload::circumstances;
use super::sessions::{self, StreamerChoice};
use crate::link::shell::run_streamer;
use crate::link::streamer::{Procedure, StreamerState};
use crate::plan::Status;
use crate::report::plan_text;

/// `samara stream`.
pub fn run(args: &StreamArgs) -> Result<Answer, Failure> {
    let mut mission = mission_with_a_drop(&args.mission, &args.choice)?;
    let ports = ports_of(&args.net)?;
    let key = key_of(&args.net)?;
    let narrator = Narrator::alone(false);
    let trajectory = match &args.trajectory {
        Some(path) => mission.use_trajectory(path).bad_input()?.trajectory,
        None => {
            let timed = plan_mission(&mission, args.planning.verbose)?;
            let text = plan_text(&timed.plan, &mission.limits, None);
            narrator.say(&format!("planned in {:.1} ms: {text}", timed.solve_ms))?;
            if timed.plan.status != Status::Converged {
                return Ok(Answer::No);
            }
            timed.plan.trajectory
        }
    };
    let choice = StreamerChoice {
        procedure: Some(Procedure {
            circumstances: circumstances(&mission, &trajectory),
            ..Procedure::default()
        }),
        feed_forward: args.feed_forward,
        froude: sessions::froude(&mission),
        ..StreamerChoice::default()
    };
    let session = sessions::streamer(&mission, trajectory, system_of(&args.net)?, choice);
    let mut reporter = Reporter::new(narrator, &mission, None, None);
    let session = block_on(|stop| run_streamer(session, &ports, key, &mut reporter, stop))?.bad_input()?;
    reporter.finish()?;
    Ok(match session.state() {
        StreamerState::Target | StreamerState::Done => Answer::Yes,
        // It has said why.
        StreamerState::Failed => Answer::No,
        _ => {
            narrator.say("stopped before the plan was at its end\n")?;
            Answer::No
        }
    })
}
