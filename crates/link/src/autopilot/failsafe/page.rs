//! The failsafes as a table: part of `docs/px4_differences.md`.

use super::super::settings::{
    Action, BatteryPolicy, DATA_LINK_LOSS, FENCE, MOTOR_FAILURE, SETPOINT_LOSS, STICK_LOSS, Settings,
};
use super::{Condition, Ends};
use crate::autopilot::FlightMode;
use crate::control::Gains;

/// What is watched, the parameters that it hangs on, the condition of which the actions are, and these with
/// their numbers where a parameter chooses.
type Row = (&'static str, &'static str, Condition, Vec<(Option<i32>, Action)>);

fn rows() -> Vec<Row> {
    use Condition::{
        Attitude, AttitudeAtTakeoff, BatteryCritical, BatteryEmergency, BatteryLow, DataLinkLost,
        FenceDistance, Motor, NoAttitude, NoPosition, SetpointsLost, SticksLost,
    };
    let chosen = |codes: &[(i32, Action)]| codes.iter().map(|&(code, action)| (Some(code), action)).collect();
    let always = |actions: &[Action]| actions.iter().map(|&action| (None, action)).collect();
    let by_battery = |condition: Condition| {
        let policies =
            [BatteryPolicy::Warn, BatteryPolicy::Return, BatteryPolicy::Land, BatteryPolicy::ReturnThenLand];
        let action = |battery: BatteryPolicy| {
            let settings = Settings { battery, ..Settings::beside(&Gains::near_hover()) };
            (Some(battery as i32), condition.action(&settings, FlightMode::default()))
        };
        policies.into_iter().map(action).collect()
    };
    let tilt = "FD_FAIL_R, FD_FAIL_P, FD_FAIL_R_TTRI, FD_FAIL_P_TTRI";
    vec![
        ("setpoints lost", "COM_OF_LOSS_T, COM_OBL_RC_ACT", SetpointsLost, chosen(&SETPOINT_LOSS)),
        ("ground stations silent", "COM_DL_LOSS_T, NAV_DLL_ACT", DataLinkLost, chosen(&DATA_LINK_LOSS)),
        (
            "[sticks](#sticks) lost",
            "COM_RC_LOSS_T, COM_RCL_EXCEPT, NAV_RCL_ACT",
            SticksLost,
            chosen(&STICK_LOSS),
        ),
        (
            "beyond GF_MAX_HOR_DIST or GF_MAX_VER_DIST from home, or an uploaded fence",
            "GF_ACTION",
            FenceDistance,
            chosen(&FENCE),
        ),
        ("battery low", "BAT_LOW_THR", BatteryLow, always(&[Action::Warn])),
        ("battery critical", "BAT_CRIT_THR, COM_LOW_BAT_ACT", BatteryCritical, by_battery(BatteryCritical)),
        (
            "battery about to be empty",
            "BAT_EMERGEN_THR, COM_LOW_BAT_ACT",
            BatteryEmergency,
            by_battery(BatteryEmergency),
        ),
        (
            "no position or velocity that the mode needs",
            "COM_POS_FS_EPH, COM_VEL_FS_EVH, 2.5 times as much once valid",
            NoPosition,
            always(&[Action::Altitude, Action::Return, Action::Descend]),
        ),
        ("no attitude, accelerometer or gyro for 1 s", "", NoAttitude, always(&[Action::Terminate])),
        (
            "roll or pitch beyond limits, within COM_LKDOWN_TKO of arming",
            tilt,
            AttitudeAtTakeoff,
            always(&[Action::Disarm]),
        ),
        (
            "roll or pitch beyond limits, later",
            "the same, CBRK_FLIGHTTERM",
            Attitude,
            always(&[Action::Warn, Action::Terminate]),
        ),
        ("a motor that has failed", "FD_ACT_EN, COM_ACT_FAIL_ACT", Motor, chosen(&MOTOR_FAILURE)),
    ]
}

/// The table, in Markdown: an action stands in the column of what ends it, the usual one in bold.
pub fn table() -> String {
    let usual = Settings::beside(&Gains::near_hover());
    let row = |(what, parameters, condition, actions): Row| {
        let ending = |ends: Ends| {
            let some = actions.iter().filter(|(_, action)| condition.ends(*action) == ends);
            let word = |(code, action): &(Option<i32>, Action)| {
                let (name, is_usual) =
                    (action.name(), *action == condition.action(&usual, FlightMode::default()));
                match code {
                    Some(code) if is_usual => format!("{code} **{name}**"),
                    Some(code) => format!("{code} {name}"),
                    None => name.to_owned(),
                }
            };
            some.map(word).collect::<Vec<_>>().join(", ")
        };
        let [with, chosen, never] = [Ends::WithItsCause, Ends::ModeChosen, Ends::Never].map(ending);
        format!("| {what} | {parameters} | {with} | {chosen} | {never} |\n")
    };
    let head = "| what | parameters | until its cause is over | until a mode is chosen, its cause over | for good |\n\
                |---|---|---|---|---|\n";
    std::iter::once(head.to_owned()).chain(rows().into_iter().map(row)).collect()
}
