//! What was uncertain in each trial of a campaign, as CSV.

use std::fmt::Write as _;

use samara_mission::Mission;

/// The file of a campaign's trials from the first one: how far each uncertain quantity is off in each. `None`
/// where the mission calls nothing uncertain.
pub fn uncertain_csv(mission: &Mission, trials: u64) -> Option<String> {
    let quantities = mission.uncertain.as_ref()?.quantities();
    let names = quantities.iter().map(|quantity| quantity.key()).collect::<Vec<_>>();
    let mut text = format!("{}trial,{}\n", mission.stamp().csv_comment(), names.join(","));
    for trial in 0..trials {
        let off = mission.draw_drop(trial).off;
        let numbers = quantities.iter().map(|quantity| off.of(*quantity).to_string());
        let numbers: Vec<String> = numbers.collect();
        let _ = writeln!(text, "{trial},{}", numbers.join(","));
    }
    Some(text)
}
