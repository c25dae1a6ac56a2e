//! Froude's similarity in closed form: an autopilot that lives in the image of a site - gravity and thrust
//! times k^2, gains in 1/s times k, in 1/s^2 times k^2 - and speaks over the scaled wire flies what the
//! site's own autopilot flies without it.

use samara::autopilot::parameters::Parameters;
use samara::control::{Airframe, ControlLimits, ControlSettings, Gains};
use samara::link::{
    AutopilotSession, AutopilotSetup, Decoder, Froude, HilConfig, HilSession, Link, Lockstep, StreamerConfig,
    StreamerSession, TimeUs,
};
use samara::model::Environment;
use samara::params::Subject;
use samara::sim::{DropRunConfig, DropSimulation, Phase, Sample};

use super::bench::{mission, plan};

/// The image of a site in which accelerations are `k^2` times as large: dynamic pressure and thrust grow with
/// the density.
fn image(site: &Environment, k: f64) -> Environment {
    Environment {
        gravity_m_s2: site.gravity_m_s2 * k * k,
        density_kg_m3: site.density_kg_m3 * k * k,
        ..site.clone()
    }
}

fn autopilot(site: &Environment, k: f64) -> AutopilotSession {
    let m = mission();
    let (g, l) = (&m.control.gains, &m.control.limits);
    let gains = Gains {
        k_pq: g.k_pq * k,
        k_iq: g.k_iq * k * k,
        k_ptheta: g.k_ptheta * k,
        k_pvz: g.k_pvz * k,
        k_ivz: g.k_ivz * k * k,
        k_pvx: g.k_pvx * k,
        k_ivx: g.k_ivx * k * k,
        k_ppsi: g.k_ppsi * k,
        k_pr: g.k_pr * k,
    };
    let limits = ControlLimits {
        tilt_rad: l.tilt_rad,
        rate_command_rad_s: l.rate_command_rad_s * k,
        yaw_rate_command_rad_s: l.yaw_rate_command_rad_s * k,
        rate_integral_rad_s2: l.rate_integral_rad_s2 * k * k,
        ..*l
    };
    let environment = image(site, k);
    let subject = Subject {
        vehicle: &m.vehicle,
        environment: &environment,
        gains: &gains,
        limits: &limits,
        speed_m_s: m.limits.safety.speed_m_s * k,
        tilt_from: None,
        pack: None,
    };
    AutopilotSession::new(AutopilotSetup {
        system_id: 1,
        control: ControlSettings {
            airframe: Airframe::new(&m.vehicle, &environment).unwrap(),
            gains,
            limits,
        },
        controller: None,
        parameters: Parameters::of(&subject, 1).unwrap(),
        environment,
        estimator: None,
        rotors: m.vehicle.rotors.len(),
        epoch_unix_us: m.epoch_unix_us,
        keeps_parameters: false,
    })
}

/// Flies the plan at a site with steps of `step_us`, over a wire that is scaled or not.
fn fly(
    site: &Environment,
    step_us: TimeUs,
    froude: Option<Froude>,
    tap: &mut impl FnMut(TimeUs, Link, &[u8]),
) -> Vec<Sample> {
    let m = mission();
    let sim = DropSimulation::new(
        m.vehicle.clone(),
        site.clone(),
        m.release.parachute,
        m.release.hang_s,
        m.release.start,
    );
    let run = DropRunConfig { step_us, ..DropRunConfig::default() };
    let simulator = HilConfig { run, froude, seed: m.seed, ..HilConfig::default() };
    let streamer = StreamerConfig {
        froude,
        hang_s: m.release.hang_s,
        delay_s: m.release.parachute.delay_s,
        target_v_ned: m.target_v_ned,
        setpoint_period_us: 5 * step_us,
        lead_us: step_us,
        ..StreamerConfig::default()
    };
    let autopilot = autopilot(site, froude.map_or(1.0, Froude::k));
    let mut wire =
        Lockstep::new(HilSession::new(sim, simulator), autopilot, StreamerSession::new(streamer, plan()));
    wire.run(tap).unwrap();
    assert_eq!(wire.faults().dropped(), 0);
    wire.simulator.into_run().into_log()
}

#[test]
fn closed_form_the_image_flies_what_the_site_flies() {
    // Steps of whole milliseconds, so that time stamps in milliseconds are exact on both sides.
    for step_us in [9_000, 10_000, 11_000, 12_000] {
        let k = step_us as f64 / 4_000.0;
        let gravity_m_s2 = samara::units::STANDARD_GRAVITY_M_S2 / (k * k);
        let site = Environment { gravity_m_s2, ..mission().site.environment.clone() };
        let froude = Froude::under(gravity_m_s2);
        assert_eq!(froude.step_us(), step_us);
        let own = fly(&site, step_us, None, &mut |_, _, _| {});
        let image = fly(&site, step_us, Some(froude), &mut |_, _, _| {});
        assert_eq!(own.len(), image.len());
        let mut worst: f64 = 0.0;
        for (a, b) in own.iter().zip(&image) {
            assert_eq!((a.t_s, a.phase), (b.t_s, b.phase));
            worst = worst.max((a.state.body.v_ned - b.state.body.v_ned).norm());
        }
        // Single precision on both wires.
        assert!(worst < 1e-5, "{step_us}: {worst}");
        let moved = own.last().unwrap().state.body.v_ned - own[0].state.body.v_ned;
        assert!(moved.norm() > 1.0 && own.iter().any(|s| s.phase == Phase::Powered), "nothing was flown");
    }
}

/// Titan's own gravity: the wire has PX4's clock and PX4's gravity.
#[test]
fn closed_form_the_wire_is_px4s() {
    let site = &mission().site.environment;
    let froude = Froude::under(site.gravity_m_s2);
    let mut decoder = Decoder::new();
    let (mut steps, mut weights) = (Vec::new(), Vec::new());
    fly(site, froude.step_us(), Some(froude), &mut |now, link, bytes| {
        decoder.datagram(bytes, |frame| {
            if link == Link::Simulator && frame.message_id == 107 {
                steps.push(frame.payload().u64(0));
                // Before the release.
                if now < 9_000_000 {
                    weights.push(frame.payload().f32(16));
                }
            }
        });
    });
    assert!(steps.iter().enumerate().all(|(i, t)| *t == 4_000 * (i as TimeUs + 1)));
    // g0, but for k being rounded to the microsecond.
    assert!(weights.iter().all(|w| (w + 9.80665).abs() < 3e-4), "{:?}", weights.first());
    assert!(weights.len() > 800);
}
