//! What is odd about a mission, a sentence each, with its key.

use crate::checking::{Checked, CheckedPlan, Room, SlowLoop};
use crate::tuning::PAPERS_MOST_PER_S;
use samara_core::design::{LOOPS, LoopPlace, TARGET, WorstLoop};
use samara_core::hints::No;
use samara_core::math::with_digits;
use samara_core::tune::SearchedNumber;
use samara_mission::{Mission, Odd};
use samara_report::columns::short;
use samara_report::json::status_name;

/// What is odd about a mission; a mission without any is fine.
pub fn odd(mission: &Mission, checked: &Checked) -> Vec<Odd> {
    let mut odd = checked.derived.odd.clone();
    odd.extend(of_the_plan(&checked.plan).map(|text| Odd::new(No::PlanFails, text)));
    let room = checked.room.as_ref().and_then(|room| of_the_ground(mission, checked, room));
    odd.extend(room.map(|text| Odd::new(No::RoomBelow, text)));
    odd.extend(of_the_loops(mission, checked));
    odd.extend(checked.slow.iter().map(|slow| Odd::new(No::SlowLoop, of_a_slow_loop(mission, slow))));
    odd.extend(of_the_rule(mission, checked));
    odd
}

fn of_the_plan(plan: &CheckedPlan) -> Option<String> {
    match plan {
        CheckedPlan::Solved(plan) if plan.diagnosis.is_some() => Some(format!(
            "plan: the solve ends as {}; `samara plan` says more",
            status_name(plan.status).replace('_', " ")
        )),
        CheckedPlan::Unposed(unposed) => Some(format!("plan: {unposed}: {}", unposed.source)),
        CheckedPlan::Solved(_) | CheckedPlan::None | CheckedPlan::Long => None,
    }
}

fn of_the_ground(mission: &Mission, checked: &Checked, room: &Room) -> Option<String> {
    if room.is_enough() {
        return None;
    }
    let needed = match (room.needed_m, checked.plan.trajectory()) {
        (Some(needed_m), Some(_)) => format!("fall and plan lose {} m", short(needed_m, 3)),
        (Some(needed_m), None) => {
            format!("the fall and what the greatest lift takes to end it lose {} m", short(needed_m, 3))
        }
        (None, _) => "the rotors end no fall".to_owned(),
    };
    let altitude_m = mission.site.environment.anchor.altitude_m;
    Some(format!(
        "site.ground_altitude_m {}: the release is {} m above the ground, and {needed}",
        short(altitude_m - room.height_m, 6),
        short(room.height_m, 4)
    ))
}

/// The loops that do not keep what they must, by the one that is nearest to instability.
fn of_the_loops(mission: &Mission, checked: &Checked) -> Option<Odd> {
    let least = &checked.least;
    let lacking: Vec<&WorstLoop> = checked.loops.iter().filter(|of| !of.keeps(least)).collect();
    let gains = &mission.control.gains_name;
    if let Some(words) = unstable_words(&lacking) {
        return Some(Odd::new(No::LoopsUnstable, format!("gains {gains}: {words}")));
    }
    let by_modulus = lacking.iter().min_by(|a, b| a.modulus.0.total_cmp(&b.modulus.0))?;
    let others = match lacking.len() - 1 {
        0 => String::new(),
        1 => "; another loop keeps less than it should".to_owned(),
        n => format!("; {n} other loops keep less than they should"),
    };
    let (modulus, at) = by_modulus.modulus;
    let of_modulus = least.modulus.filter(|least| modulus < *least).map(|least| {
        let name = loop_name(by_modulus.index);
        format!("{name} loop: modulus {modulus:.2} at the {}, {least} expected", place_words(&at))
    });
    let delays = lacking.iter().filter_map(|of| Some((of.index, of.delay_s?)));
    let by_delay = delays.min_by(|(_, (a, _)), (_, (b, _))| a.total_cmp(b));
    let of_delay = least.delay_s.zip(by_delay).filter(|(least_s, (_, (delay_s, _)))| delay_s < least_s);
    let of_delay = of_delay.map(|(least_s, (index, (delay_s, at)))| {
        format!(
            "{} loop: unstable by a delay of {:.1} ms at the {}, {:.0} ms expected",
            loop_name(index),
            1e3 * delay_s,
            place_words(&at),
            1e3 * least_s
        )
    });
    let said: Vec<String> = of_modulus.into_iter().chain(of_delay).collect();
    Some(Odd::new(No::LoopsLackMargin, format!("gains {gains}: {}{others}", said.join("; "))))
}

/// The loops that are unstable, by the places where they are; `None` where none is.
fn unstable_words(loops: &[&WorstLoop]) -> Option<String> {
    let mut places: Vec<(LoopPlace, Vec<&str>)> = Vec::new();
    for (at, name) in loops.iter().filter_map(|of| Some((of.unstable?, loop_name(of.index)))) {
        match places.iter_mut().find(|(place, _)| *place == at) {
            Some((_, names)) => names.push(name),
            None => places.push((at, vec![name])),
        }
    }
    let words = places.iter().map(|(at, names)| {
        let (noun, verb) = if names.len() == 1 { ("loop", "is") } else { ("loops", "are") };
        let still = if at.state == TARGET { "" } else { ", as if it flew on there" };
        format!("the {noun} of {} {verb} unstable at the {}{still}", names.join(", "), place_words(at))
    });
    words.reduce(|all, next| format!("{all}; {next}"))
}

fn of_a_slow_loop(mission: &Mission, slow: &SlowLoop) -> String {
    let settles = if slow.settles_s.is_finite() {
        let crossover = with_digits(slow.crossover_rad_s, 2);
        format!(
            "crosses 1 at {crossover} rad/s, so that a difference falls to a twentieth in {:.0} s",
            slow.settles_s
        )
    } else {
        "its gain is nowhere 1, so that a difference stays".to_owned()
    };
    format!(
        "gains {}: {} loop: {settles}, and from t = 0 on the mission has {:.1} s",
        mission.control.gains_name,
        loop_name(slow.index),
        slow.left_s
    )
}

/// Gains outside the range about the rule for the vehicle, and those that lean on the paper's range.
fn of_the_rule(mission: &Mission, checked: &Checked) -> Vec<Odd> {
    let name = &mission.control.gains_name;
    let joined = |numbers: &[SearchedNumber], words: &dyn Fn(&SearchedNumber) -> String| {
        numbers.iter().map(words).collect::<Vec<_>>().join(", ")
    };
    let gains = &checked.gains;
    let outside = (!gains.outside.is_empty()).then(|| {
        let words = |n: &SearchedNumber| {
            let SearchedNumber { name, value, least, most } = n;
            let [value, least, most] = [value, least, most].map(|x| with_digits(*x, 3));
            // An integral may be as small as it likes.
            let from = if name.starts_with("k_i") { String::new() } else { format!("from {least} ") };
            format!("{name} {value} ({from}to {most})")
        };
        format!(
            "gains {name}: outside the range about the rule for the vehicle: {}",
            joined(&gains.outside, &words)
        )
    });
    let leaning = (!gains.at_papers_end.is_empty()).then(|| {
        let words = |n: &SearchedNumber| {
            let SearchedNumber { name, value, least, most } = n;
            let rule = if most > least { format!("{least:.1} to {most:.1}") } else { format!("{least:.1}") };
            format!("{name} {value:.2} (by the rule for the vehicle {rule})")
        };
        format!(
            "gains {name}: lean on the old search box, whose end is {PAPERS_MOST_PER_S} 1/s: {}",
            joined(&gains.at_papers_end, &words)
        )
    });
    let outside = outside.map(|text| Odd::new(No::GainsOutsideTheRule, text));
    outside.into_iter().chain(leaning.map(|text| Odd::new(No::GainsLean, text))).collect()
}

/// Name of a loop by its place.
pub(super) fn loop_name(index: usize) -> &'static str {
    LOOPS.get(index).map_or("", |(name, _)| name)
}

/// A state and the vehicle there, in words that follow "at the".
fn place_words(at: &LoopPlace) -> String {
    let LoopPlace { state, off } = at;
    let mut words = (*state).to_owned();
    if off.motor_lag != 1.0 {
        words += &format!(" with motors {} times as slow", off.motor_lag);
    }
    if off.thrust != 1.0 {
        words += &format!(" with {} of the thrust", off.thrust);
    }
    words
}
