//! An autopilot of your own on the wire: a client of the simulator's TCP port that flies the drop in place
//! of PX4. It cuts the vehicle loose, brakes the fall and holds a velocity, with thirty lines of control.
//!
//! ```sh
//! samara sim mission/x500_drop.json --speed max &
//! cargo run --release --example own_autopilot
//! ```
//!
//! An autopilot in another language does the same: any MAVLink library, the messages below.

use std::io::{ErrorKind, Read as _, Write as _};
use std::net::{TcpStream, ToSocketAddrs, UdpSocket};

use mavlink::dialects::common::{
    COMMAND_LONG_DATA, HIL_ACTUATOR_CONTROLS_DATA, HIL_STATE_QUATERNION_DATA, MavCmd, MavMessage, MavModeFlag,
};
use nalgebra::Vector3;
use samara::control::{Airframe, ControlOutput, Measurement};
use samara::frames::{rotate_body_from_ned, yaw};
use samara::link::{Decoder, Encoder};
use samara::model::PerRotor;

type Failure = Box<dyn std::error::Error>;

/// Throttles that bring the vehicle to a velocity: an acceleration for the error of the velocity, an
/// attitude whose thrust makes it, a moment for the error of the attitude. The heading is held at north.
pub fn throttles(airframe: &Airframe, now: &Measurement, v_sp_ned: Vector3<f64>) -> PerRotor {
    // More firmly up and down: rotors give more than they are asked for in a descent, less in a climb.
    const PER_S: [f64; 3] = [2.0, 2.0, 5.0];
    const PER_S2: f64 = 80.0;
    const RATE_PER_S: f64 = 16.0;
    let acceleration = Vector3::from(PER_S).component_mul(&(v_sp_ned - now.v_ned));
    let gravity = Vector3::z() * airframe.gravity_m_s2;
    // Specific force of the rotors; never downward, and no further from the vertical than 45 deg.
    let mut force = acceleration - gravity;
    force.z = force.z.min(-0.2 * airframe.gravity_m_s2);
    let level = force.xy().norm();
    if level > -force.z {
        force.x *= -force.z / level;
        force.y *= -force.z / level;
    }
    let wanted = rotate_body_from_ned(now.q_ned_from_body, force);
    // How far the body's up axis, -z, is from the force, about x and y; and the heading, more gently.
    let up = wanted.normalize();
    let turn = Vector3::new(up.y, -up.x, -0.1 * yaw(now.q_ned_from_body));
    let moment = airframe.inertia_kg_m2 * (PER_S2 * turn - RATE_PER_S * now.omega_body);
    let lift_n = airframe.mass_kg * (-wanted.z).max(0.0);
    let thrust_n = airframe.mixer.thrusts(lift_n, &moment);
    ControlOutput::from_thrusts(thrust_n, airframe.mixer.thrust_limit_n()).throttle
}

/// The truth as the simulator sends it, in SI units.
fn measurement(m: &HIL_STATE_QUATERNION_DATA) -> Measurement {
    Measurement {
        q_ned_from_body: m.attitude_quaternion.map(f64::from),
        v_ned: Vector3::new(m.vx, m.vy, m.vz).map(|cm_s| f64::from(cm_s) / 100.0),
        omega_body: Vector3::new(m.rollspeed, m.pitchspeed, m.yawspeed).map(f64::from),
        bus_v: None,
        pack_a: None,
    }
}

/// Flies until the simulator ends: each HIL_SENSOR is answered with HIL_ACTUATOR_CONTROLS of its time, which
/// keeps the lockstep. At `release_us` of simulated time the parachute, behind a UDP port of its own, gets
/// the command to let go. Returns the number of answers.
pub fn fly(
    system_id: u8,
    simulator: impl ToSocketAddrs,
    parachute: impl ToSocketAddrs,
    airframe: &Airframe,
    v_sp_ned: Vector3<f64>,
    release_us: u64,
) -> Result<u64, Failure> {
    let mut simulator = TcpStream::connect(simulator)?;
    simulator.set_nodelay(true)?;
    let companion = UdpSocket::bind("127.0.0.1:0")?;
    companion.connect(parachute)?;
    let (mut decoder, mut encoder) = (Decoder::new(), Encoder::new(system_id, 1));
    let (mut state, mut answers, mut released) = (None, 0, false);
    let mut bytes = [0; 4096];
    loop {
        let length = match simulator.read(&mut bytes) {
            Ok(0) => return Ok(answers),
            Err(error) if error.kind() == ErrorKind::ConnectionReset => return Ok(answers),
            read => read?,
        };
        decoder.push(&bytes[..length]);
        while let Some(frame) = decoder.next_frame() {
            match frame.known() {
                Some(MavMessage::HIL_STATE_QUATERNION(m)) => state = Some(measurement(m)),
                Some(MavMessage::HIL_SENSOR(m)) => {
                    if !released && m.time_usec >= release_us {
                        released = true;
                        // Component 161 is the parachute; param2 = 0 lets go.
                        let release = COMMAND_LONG_DATA {
                            command: MavCmd::MAV_CMD_DO_GRIPPER,
                            target_system: system_id,
                            target_component: 161,
                            ..COMMAND_LONG_DATA::default()
                        };
                        companion.send(&encoder.encode(&MavMessage::COMMAND_LONG(release)))?;
                    }
                    let mut answer = HIL_ACTUATOR_CONTROLS_DATA {
                        time_usec: m.time_usec,
                        mode: MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED,
                        ..HIL_ACTUATOR_CONTROLS_DATA::default()
                    };
                    if let Some(now) = &state {
                        let throttles = throttles(airframe, now, v_sp_ned);
                        for (control, throttle) in answer.controls.iter_mut().zip(throttles) {
                            *control = throttle as f32;
                        }
                    }
                    if simulator
                        .write_all(&encoder.encode(&MavMessage::HIL_ACTUATOR_CONTROLS(answer)))
                        .is_err()
                    {
                        return Ok(answers);
                    }
                    answers += 1;
                }
                _ => {}
            }
        }
    }
}

fn main() -> Result<(), Failure> {
    let mission = samara::config::load_mission("mission/x500_drop.json".as_ref())?;
    let airframe = Airframe::new(&mission.vehicle, &mission.site.environment)?;
    fly(1, "127.0.0.1:4560", "127.0.0.1:14600", &airframe, mission.target_v_ned, 15_000_000)?;
    Ok(())
}
