//! The verdict on a drop, as text for the terminal.

use super::columns::{fixed, short};
use samara_core::assess::outcome::{
    ALTITUDE_LOST, CANOPY_DISTANCE, IMPACT_SPEED, IMPACT_TILT, PEAK_TILT, STEADY_AFTER, STEADY_RMS,
};
use samara_core::assess::power::{Extreme, PowerUse};
use samara_core::assess::{Limits, Quantity, Verdict};
use samara_core::units::DEG_PER_RAD;

/// The verdict as an aligned table: quantity, value, limit, and whether the limit held; J_TPF with the
/// quantity that decides it, and steady flight marked if it was to be reached and was not. Ends with a line's
/// end.
pub fn verdict_text(verdict: &Verdict, limits: &Limits, misses_steady_flight: bool) -> String {
    table(&verdict_lines(verdict, limits, misses_steady_flight))
}

/// The verdict as lines of quantity, value, unit, limit and mark.
pub(super) fn verdict_lines(
    verdict: &Verdict,
    limits: &Limits,
    misses_steady_flight: bool,
) -> Vec<[String; 5]> {
    let (outcome, peaks, safety) = (&verdict.outcome, &verdict.peaks, &limits.safety);
    let line = |quantity: &str, value: String, unit: &str, limit: &str, mark: &str| {
        [quantity.to_owned(), value, unit.to_owned(), limit.to_owned(), mark.to_owned()]
    };
    let mark = |exceeded: bool| if exceeded { "EXCEEDED" } else { "ok" };
    let passed = |name: &str| mark(verdict.limits_passed.contains(&name));
    let either_way = |limit: f64| format!("+-{}", short(limit, 6));
    let speed = short(safety.speed_m_s, 6);
    let pitch = either_way(safety.pitch_rad * DEG_PER_RAD);
    let rate = either_way(safety.pitch_rate_rad_s * DEG_PER_RAD);
    let acceleration = either_way(safety.vertical_acceleration_m_s2);
    let exceeded = !(outcome.j_tpf < limits.j_tpf_below);
    let decided = format!("{}, decided by {}", mark(exceeded), verdict.decided_by.replace('_', " "));
    let theta = fixed(peaks.pitch_rad * DEG_PER_RAD, 2);
    let q = fixed(peaks.pitch_rate_rad_s * DEG_PER_RAD, 2);
    let phi = fixed(peaks.roll_rad * DEG_PER_RAD, 2);
    let p = fixed(peaks.roll_rate_rad_s * DEG_PER_RAD, 2);
    let mut lines = vec![
        line("J_TPF", fixed(outcome.j_tpf, 4), "", &short(limits.j_tpf_below, 6), &decided),
        line("peak speed", fixed(outcome.peak_speed_m_s, 2), "m/s", &speed, passed("speed")),
        line("peak pitch", theta, "deg", &pitch, passed("pitch")),
        line("peak pitch rate", q, "deg/s", &rate, passed("pitch_rate")),
    ];
    // A flight in the plane has no roll to report.
    if phi != "0.00" || p != "0.00" {
        lines.push(line("peak roll", phi, "deg", &pitch, passed("roll")));
        lines.push(line("peak roll rate", p, "deg/s", &rate, passed("roll_rate")));
    }
    let peak = fixed(verdict.peak_vertical_acceleration_m_s2, 2);
    lines.push(line("peak vertical acceleration", peak, "m/s^2", &acceleration, "not judged"));
    // A quantity beside its limit, where there is one.
    let judged = |quantity: &Quantity, value: String| {
        let limit = (quantity.limit)(limits).filter(|limit| limit.is_finite()).zip(quantity.judged);
        let (limit, mark) = limit.map_or((String::new(), ""), |(x, name)| (short(x, 6), passed(name.passed)));
        line(quantity.words, value, quantity.unit, &limit, mark)
    };
    if limits.tilt_rad.is_some() {
        lines.push(judged(&PEAK_TILT, fixed(outcome.peak_tilt_deg, 2)));
    }
    lines.push(judged(&ALTITUDE_LOST, fixed(outcome.altitude_lost_m, 1)));
    let steady = outcome.steady_after_s.map_or("never".to_owned(), |t_s| fixed(t_s, 2));
    let [quantity, value, unit, limit, mark] = judged(&STEADY_AFTER, steady);
    let unit = if outcome.steady_after_s.is_some() { unit } else { String::new() };
    let mark = if misses_steady_flight { "NOT STEADY".to_owned() } else { mark };
    lines.push([quantity, value, unit, limit, mark]);
    if let Some(rms) = outcome.steady_rms_m_s {
        lines.push(line(STEADY_RMS.words, fixed(rms, 2), STEADY_RMS.unit, "", "not judged"));
    }
    let velocity = outcome.final_v_ned().as_slice().iter().map(|v| fixed(*v, 2)).collect::<Vec<_>>();
    lines.push(line("final velocity, NED", velocity.join(" "), "m/s", "", ""));
    if let Some(longest) = verdict.vortex_ring_s.iter().copied().reduce(f64::max) {
        lines.push(line("longest in the vortex ring", fixed(longest, 2), "s", "", "not judged"));
    }
    if let Some(power) = &verdict.power {
        lines.extend(power_lines(power));
    }
    for quantity in [IMPACT_SPEED, IMPACT_TILT, CANOPY_DISTANCE] {
        lines.extend(quantity.of(outcome).map(|x| judged(&quantity, fixed(x, 2))));
    }
    lines
}

/// What a drop asked of its battery: extremes with their times, what held the motors back, what is left.
fn power_lines(power: &PowerUse) -> [[String; 5]; 4] {
    let limit = |a: f64| if a.is_finite() { short(a, 6) } else { String::new() };
    let held = |held_s: f64| match held_s {
        t if t > 0.0 => format!(", held the motors back for {} s", fixed(t, 2)),
        _ => String::new(),
    };
    let at = |extreme: &Extreme| format!("at {} s", fixed(extreme.at_s, 2));
    let (bus, pack, esc) = (&power.bus_least_v, &power.pack_most_a, &power.esc_most_a);
    let line = |quantity: &str, value: f64, unit: &str, limit: String, mark: String| {
        [quantity.to_owned(), fixed(value, 2), unit.to_owned(), limit, mark]
    };
    let of_esc = format!("{}, rotor {}{}", at(esc), power.esc_most_rotor, held(power.esc_held_s));
    let empty = power.empty_at_s.map_or(String::new(), |t_s| format!("EMPTY at {} s", fixed(t_s, 2)));
    [
        line("least bus voltage", bus.value, "V", String::new(), at(bus) + &held(power.voltage_held_s)),
        line(
            "most pack current",
            pack.value,
            "A",
            limit(power.pack_limit_a),
            at(pack) + &held(power.pack_held_s),
        ),
        line("most current of a motor", esc.value, "A", limit(power.esc_limit_a), of_esc),
        line("charge left", 100.0 * power.charge_left, "%", String::new(), empty),
    ]
}

/// Quantity, value, unit, limit and mark, a line each, below a head.
fn table(lines: &[[String; 5]]) -> String {
    let widths = [0, 1, 2, 3].map(|column| lines.iter().map(|l| l[column].len()).max().unwrap_or(0));
    let [quantity, value, unit, limit] = widths;
    let limit = limit.max("limit".len());
    let head = ["", "value", "", "limit", ""].map(str::to_owned);
    let row = |[name, number, its_unit, bound, mark]: &[String; 5]| {
        let row = format!("{name:quantity$}  {number:>value$} {its_unit:unit$}  {bound:>limit$}  {mark}");
        row.trim_end().to_owned() + "\n"
    };
    std::iter::once(&head).chain(lines).map(row).collect()
}
