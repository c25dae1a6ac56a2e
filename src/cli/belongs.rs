//! Options of a drop that not every autopilot has. What is asked for and would not be done is refused, never passed over: who asks for
//! signed frames and gets unsigned ones should know.

use super::args::AutopilotArg;
use super::outcome::{BadInput, Failure};

/// An option, the autopilots that have it, and why the others have not.
struct Belongs {
    option: &'static str,
    to: &'static [&'static str],
    why: &'static str,
}

const REFERENCE: &str = "reference";
const PX4: &str = "px4=DIR";
const MODEL: &str = "px4-model";

const TABLE: [Belongs; 8] = [
    Belongs { option: ESTIMATOR, to: &[REFERENCE], why: "PX4 has an estimator of its own" },
    Belongs {
        option: LINK,
        to: &[REFERENCE],
        why: "PX4's links are its own, and the model flies without a wire",
    },
    Belongs { option: SIGN_KEY, to: &[REFERENCE], why: "PX4's frames go unsigned, and the model sends none" },
    Belongs {
        option: SPEED,
        to: &[REFERENCE, PX4],
        why: "the model flies without a wire, as fast as it goes",
    },
    Belongs { option: CPU, to: &[PX4], why: "no other runs in a process beside the simulator" },
    Belongs { option: PATIENCE, to: &[PX4], why: "no other is waited for" },
    Belongs {
        option: FEED_FORWARD,
        to: &[PX4, MODEL],
        why: "the reference autopilot is sent velocities alone",
    },
    Belongs { option: PX4_DEFAULT, to: &[PX4, MODEL], why: "they are PX4's own" },
];

/// `--estimator ekf`.
pub const ESTIMATOR: &str = "--estimator";
/// `--link`.
pub const LINK: &str = "--link";
/// `--sign-key`.
pub const SIGN_KEY: &str = "--sign-key";
/// `--speed`, where it is no `max`.
pub const SPEED: &str = "--speed";
/// `--cpu`, where it is not `auto`.
pub const CPU: &str = "--cpu";
/// `--patience`, where it is not the default.
pub const PATIENCE: &str = "--patience";
/// `--feed-forward`.
pub const FEED_FORWARD: &str = "--feed-forward";
/// `--gains px4_default`.
pub const PX4_DEFAULT: &str = "--gains px4_default";

/// Refuses the first option of the table that is asked for and that the autopilot has not got. `asked` gives for each option of the
/// verb whether it is.
///
/// # Errors
/// [`Failure::BadInput`] with the autopilots that have it.
pub fn check(autopilot: &AutopilotArg, asked: &[(&'static str, bool)]) -> Result<(), Failure> {
    let flies = match autopilot {
        AutopilotArg::Reference => REFERENCE,
        AutopilotArg::Px4(_) => PX4,
        AutopilotArg::Px4Model => MODEL,
    };
    let asked = |option: &str| asked.iter().any(|(name, is)| *name == option && *is);
    match TABLE.iter().find(|row| asked(row.option) && !row.to.contains(&flies)) {
        None => Ok(()),
        Some(Belongs { option, to, why }) => {
            let to = to.join(" or ");
            Err(anyhow::anyhow!("{option}: --autopilot {to} is expected with it; {why}")).bad_input()
        }
    }
}
