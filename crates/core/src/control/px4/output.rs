//! Motor thrusts to what HIL_ACTUATOR_CONTROLS carries: thrust curve (`MultirotorMixer::mix`), ramp after
//! arming (`output_limit_calc`), pulse widths, in whole microseconds up to v1.17
//! (`Simulator::actuator_controls_from_outputs`).

use super::Parameters;
use super::law::{Law, Rounding};

/// After arming the outputs stay at rest so long [s].
const REST_S: f64 = 0.05;
/// Then they come up within this time [s].
const RAMP_S: f64 = 0.5;

/// So long after arming they have their full range [s].
pub const FULL_AUTHORITY_S: f64 = REST_S + RAMP_S;

/// Pulse widths of the simulated outputs [us]: at rest when disarmed, least, greatest.
const DISARMED_US: f64 = 900.0;
const LEAST_US: f64 = 1000.0;
const GREATEST_US: f64 = 2000.0;

/// Motor commands, -1..1, for thrusts.
pub fn signals<const N: usize>(p: &Parameters, thrust: [f64; N]) -> [f64; N] {
    thrust.map(|t| (2.0 * curve(p.thr_mdl_fac, t) - 1.0).clamp(-1.0, 1.0))
}

/// What the simulator is sent for motor commands, 0..1, so long after arming [s].
pub fn commands<const N: usize>(law: &Law, signals: [f64; N], since_armed_s: f64) -> [f64; N] {
    signals.map(|signal| command(law, signal, since_armed_s))
}

/// The command whose thrust is `f u^2 + (1 - f) u`.
fn curve(f: f64, thrust: f64) -> f64 {
    if f > 0.0 {
        let half = (1.0 - f) / (2.0 * f);
        (half * half + thrust.max(0.0) / f).sqrt() - half
    } else {
        thrust
    }
}

fn command(law: &Law, signal: f64, since_armed_s: f64) -> f64 {
    let progress = if law.ramps_up { (since_armed_s - REST_S) / RAMP_S } else { 1.0 };
    if progress <= 0.0 {
        return 0.0;
    }
    let least = DISARMED_US + (LEAST_US - DISARMED_US) * progress.min(1.0);
    let pulse_us = 0.5 * (signal * (GREATEST_US - least) + GREATEST_US + least);
    let pulse_us = match law.rounding {
        Rounding::Down => pulse_us.floor(),
        Rounding::Nearest => pulse_us.round(),
        Rounding::Exact => pulse_us,
    };
    ((pulse_us - LEAST_US) / (GREATEST_US - LEAST_US)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::px4::mixer;

    /// Closed form: with THR_MDL_FAC 1 the command is the root of the thrust, in steps of 0.001 from below.
    #[test]
    fn closed_form_commands() {
        let p = Parameters { thr_mdl_fac: 1.0, ..Parameters::default() };
        let signals = signals(&p, [0.25, 0.5, 1.1, -0.1]);
        let saturation = mixer::saturation(&signals);
        assert_eq!(commands(&Law::V1_12, signals, 10.0), [0.5, 0.707, 1.0, 0.0]);
        assert_eq!(commands(&Law::V1_16, signals.map(|s| s + 0.0012), 0.0), [0.501, 0.708, 1.0, 0.001]);
        let exact = commands(&Law::V1_18, signals, 0.0)[1];
        assert!((exact - 0.5f64.sqrt()).abs() < 1e-12, "{exact}");
        assert_eq!(saturation.positive, [true, true, true], "the fourth motor stands: {saturation:?}");
        let u = curve(0.4, 0.3);
        assert!((0.4 * u * u + 0.6 * u - 0.3).abs() < 1e-12);
    }

    /// The ramp as its source has it: at rest for 50 ms, then the lower end comes up from 900 to 1000 us in
    /// half a second.
    #[test]
    fn the_outputs_come_up_after_arming() {
        let command = |signal, since_armed_s| command(&Law::V1_12, signal, since_armed_s);
        assert_eq!(command(1.0, 0.04), 0.0);
        assert_eq!(command(1.0, 0.06), 1.0);
        assert_eq!(command(0.0, 0.3), 0.475);
        assert_eq!(command(0.0, 0.55), 0.5);
    }
}
