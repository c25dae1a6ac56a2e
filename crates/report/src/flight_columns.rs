//! The columns of a flight log: one list for `flight.csv`, its arrays and the messages of `drop.mcap`.

use super::rows::{Arrays, Columns, Shared};
use samara_core::assess::StateCost;
use samara_core::model::environment::Ambient;
use samara_core::model::rigid_body::BodyState;
use samara_core::model::{DiskState, MAX_ROTORS, PerRotor, Rotor};
use samara_core::sim::Sample;
use samara_core::trajectory::Trajectory;
use samara_mission::Mission;

/// The column of the phase: a word, in arrays its number.
const PHASE: &str = "phase";

/// Behind some columns those of a body's state.
fn with_body<R>(columns: Columns<R>, of: impl Fn(&R) -> &BodyState + Copy + Shared) -> Columns<R> {
    const PLACE: &str = "position from the nominal point of release";
    columns
        .numbers(["north_m", "east_m", "down_m"], PLACE, move |row, i| of(row).p_ned[i])
        .numbers(["q0", "q1", "q2", "q3"], "attitude, body to NED, scalar first", move |row, i| {
            of(row).q_ned_from_body[i]
        })
        .numbers(["vn_m_s", "ve_m_s", "vd_m_s"], "velocity", move |row, i| of(row).v_ned[i])
        .numbers(["p_rad_s", "q_rad_s", "r_rad_s"], "body rates", move |row, i| of(row).omega_body[i])
}

/// The columns of a mission's flight; `ground`: whether there are those of the forces of the ground.
pub fn flight_columns(mission: &Mission, ground: bool) -> Columns<Sample> {
    let n = mission.vehicle.rotors.len().min(MAX_ROTORS);
    const TIME: &str = "time since the simulation began; since the rotors were freed, empty before";
    const SETPOINT: &str = "velocity setpoint, empty before the first";
    const FORCE: &str = "forces: rotors and body in body axes, gravity and canopy in NED";
    const MOMENT: &str = "moments in body axes";
    const GROUND: &str = "force (NED) and moment (body axes) of the ground, where the mission has one";
    const CANOPY: &str = "position and velocity of the canopy, where it is a [body of its own](parachute.md)";
    const RISER: &str = "tension of the riser, and its moment on the vehicle in body axes";
    const DISK: &str = "velocity of each hub along the thrust and across it, over the induced one of hover";
    const BUS: &str = "bus, pack and each speed controller, where the [battery has a voltage](battery.md)";
    const PHASES: [&str; 3] = ["hanging", "falling", "powered"];
    let rotors = |name: &str, unit: &str| (1..=n).map(|i| format!("{name}{i}{unit}")).collect::<Vec<_>>();
    let body = |name: &str, unit: &str| ["x", "y", "z"].map(|axis| format!("{name}{axis}{unit}"));
    let ned = |name: &str, unit: &str| ["n", "e", "d"].map(|axis| format!("{name}{axis}{unit}"));
    let limits = mission.limits.safety;
    let mut columns = Columns::<Sample>::none()
        .number("t_s", TIME, |s| s.t_s)
        .number("t_powered_s", TIME, |s| s.t_powered_s)
        .word(PHASE, "`hanging`, `falling` or `powered`", |s| Some(PHASES[s.phase as usize].to_owned()));
    columns = with_body(columns, |s| &s.state.body)
        .numbers(["an_m_s2", "ae_m_s2", "ad_m_s2"], "acceleration", |s, i| s.a_ned[i])
        .numbers(["vn_sp_m_s", "ve_sp_m_s", "vd_sp_m_s"], SETPOINT, |s, i| Some(s.v_sp_ned?[i]))
        .number("j_state", "J_state: the share of the limit that is used", move |s| {
            StateCost::of_sample(s, &limits).max()
        })
        .numbers(rotors("throttle_", ""), "command to each rotor, 0 to 1", |s, i| s.throttle[i])
        .numbers(rotors("rotor_speed_", "_rad_s"), "speed of each rotor; negative: backwards", |s, i| {
            s.state.rotor_speed[i]
        })
        .numbers(rotors("thrust_", "_n"), "thrust of each rotor", |s, i| s.balance.thrust_n[i])
        .numbers(rotors("torque_", "_nm"), "torque of each rotor", |s, i| s.balance.torque_nm[i])
        .numbers(body("rotor_f", "_n"), FORCE, |s, i| s.balance.rotor_force_body[i])
        .numbers(body("aero_f", "_n"), FORCE, |s, i| s.balance.aero_force_body[i])
        .numbers(ned("gravity_f", "_n"), FORCE, |s, i| s.balance.gravity_force_ned[i])
        .numbers(ned("canopy_f", "_n"), FORCE, |s, i| s.balance.canopy_force_ned[i])
        .numbers(body("rotor_m", "_nm"), MOMENT, |s, i| s.balance.rotor_moment_body[i])
        .numbers(body("aero_m", "_nm"), MOMENT, |s, i| s.balance.aero_moment_body[i])
        .numbers(body("reaction_m", "_nm"), MOMENT, |s, i| s.balance.reaction_moment_body[i])
        .numbers(body("gyro_m", "_nm"), MOMENT, |s, i| s.balance.gyro_moment_body[i]);
    if ground {
        columns = columns
            .numbers(ned("ground_f", "_n"), GROUND, |s, i| s.balance.ground_force_ned[i])
            .numbers(body("ground_m", "_nm"), GROUND, |s, i| s.balance.ground_moment_body[i]);
    }
    if !mission.site.wind.is_steady() {
        columns = columns
            .numbers(ned("wind_", "_m_s"), "velocity of the air, where it changes", |s, i| s.wind_ned[i]);
    }
    if mission.release.parachute.suspension.is_some() && !mission.release.standing {
        columns = columns
            .numbers(["canopy_north_m", "canopy_east_m", "canopy_down_m"], CANOPY, |s, i| {
                Some(s.canopy.as_ref()?.state.p_ned[i])
            })
            .numbers(["canopy_vn_m_s", "canopy_ve_m_s", "canopy_vd_m_s"], CANOPY, |s, i| {
                Some(s.canopy.as_ref()?.state.v_ned[i])
            })
            .number("riser_tension_n", RISER, |s| Some(s.canopy.as_ref()?.tension_n))
            .numbers(["canopy_mx_nm", "canopy_my_nm", "canopy_mz_nm"], RISER, |s, i| {
                s.canopy.as_ref().map(|_| s.balance.canopy_moment_body[i])
            });
    }
    if matches!(mission.vehicle.rotor, Rotor::BladeElement(_)) {
        let of_rotor = |i| [format!("rotor{i}_vc_over_vh"), format!("rotor{i}_mu_over_vh")];
        let (vehicle, site) = (mission.vehicle.clone(), mission.site.environment.clone());
        columns = columns.numbers((1..=n).flat_map(of_rotor), DISK, move |s, k| {
            let body = &s.state.body;
            let there = Ambient { wind_ned_m_s: s.wind_ned.into(), ..site.ambient_at(&body.p_ned) };
            let disk = DiskState::of_each(&vehicle, &there, &body.motion(), &s.balance.thrust_n)?[k / 2];
            disk.pulls.then_some([disk.climb, disk.in_plane][k % 2])
        });
    }
    if mission.vehicle.start.is_some() {
        let about =
            "0 braked, 1 free, 2 trying, 3 waiting, 4 running, 5 given up ([start](rotors.md#free-rotors))";
        columns = columns.numbers(rotors("esc_", ""), about, |s, i| Some(s.esc.as_ref()?[i].number()));
    }
    if mission.electric.is_some() {
        columns = columns
            .number("bus_v", BUS, |s| Some(s.bus.as_ref()?.bus_v))
            .number("pack_current_a", BUS, |s| Some(s.bus.as_ref()?.pack_a))
            .number("charge_percent", BUS, |s| Some(100.0 * s.bus.as_ref()?.charge))
            .numbers(rotors("rotor", "_current_a"), BUS, |s, i| Some(s.bus.as_ref()?.esc_a[i]));
    }
    columns
}

/// The columns of `flight.csv` as arrays: the name, which ends in the unit, and a value for each sample, the
/// bits that the file's text reads back to. What is empty in the file is not a number; the phase, a word in
/// the file, is 0 (hanging), 1 (falling) or 2 (powered).
pub fn flight_arrays(mission: &Mission, log: &[Sample]) -> Arrays {
    let mut arrays = flight_columns(mission, mission.site.ground.is_some()).arrays(log);
    arrays.insert(2, (PHASE.into(), log.iter().map(|sample| f64::from(sample.phase as u8)).collect()));
    // -0 is 0 in the file, too.
    arrays.iter_mut().flat_map(|(_, values)| values).for_each(|x| *x += 0.0);
    arrays
}

/// An instant of a plan.
pub(super) struct PlanRow {
    pub(super) t_s: f64,
    pub(super) t_powered_s: f64,
    pub(super) body: BodyState,
    pub(super) thrust_n: PerRotor,
}

impl PlanRow {
    /// An instant of a plan's motion that begins at `free_s` [s].
    pub(super) fn of(plan: &Trajectory, free_s: f64, (t_powered_s, body): (f64, BodyState)) -> Self {
        Self { t_s: free_s + t_powered_s, t_powered_s, body, thrust_n: plan.thrust_n(t_powered_s) }
    }
}

/// The columns of a plan's motion, those of a flight that it has.
pub(super) fn plan_columns(mission: &Mission) -> Columns<PlanRow> {
    let limits = mission.limits.safety;
    let thrusts = (1..=mission.vehicle.rotors.len()).map(|i| format!("thrust_{i}_n"));
    let times = Columns::<PlanRow>::none().number("t_s", "", |row| row.t_s);
    with_body(times.number("t_powered_s", "", |row| row.t_powered_s), |row| &row.body)
        .number("j_state", "", move |row| StateCost::of(&row.body, &limits).max())
        .numbers(thrusts, "", |row, i| row.thrust_n[i])
}
