//! The columns of a flight log: one list for `flight.csv`, its arrays and the messages of `drop.mcap`.

use nalgebra::Vector3;

use super::rows::Columns;
use samara_core::assess::StateCost;
use samara_core::model::rigid_body::BodyState;
use samara_core::model::{DiskState, ForceBalance, MAX_ROTORS, PerRotor, Rotor};
use samara_core::sim::Sample;
use samara_mission::Mission;

/// A quantity of each rotor: the columns' name and unit, what it is, and the values.
type PerRotorColumns = (&'static str, &'static str, &'static str, fn(&Sample) -> &PerRotor);
const PER_ROTOR: [PerRotorColumns; 4] = [
    ("throttle", "", "command to each rotor, 0 to 1", |s| &s.throttle),
    ("rotor_speed", "_rad_s", "speed of each rotor; negative: backwards", |s| &s.state.rotor_speed),
    ("thrust", "_n", "thrust of each rotor", |s| &s.balance.thrust_n),
    ("torque", "_nm", "torque of each rotor", |s| &s.balance.torque_nm),
];

/// A vector of the balance of forces and moments: the columns' name, letters of the axes and unit, what it
/// is, and the vector.
type VectorColumns =
    (&'static str, [char; 3], &'static str, &'static str, fn(&ForceBalance) -> &Vector3<f64>);
const BODY: [char; 3] = ['x', 'y', 'z'];
const NED: [char; 3] = ['n', 'e', 'd'];
const FORCE: &str = "forces: rotors and body in body axes, gravity and canopy in NED";
const MOMENT: &str = "moments in body axes";
const GROUND: &str = "force (NED) and moment (body axes) of the ground, where the mission has one";
/// The last two are of a mission with ground.
const BALANCE: [VectorColumns; 10] = [
    ("rotor_f", BODY, "_n", FORCE, |b| &b.rotor_force_body),
    ("aero_f", BODY, "_n", FORCE, |b| &b.aero_force_body),
    ("gravity_f", NED, "_n", FORCE, |b| &b.gravity_force_ned),
    ("canopy_f", NED, "_n", FORCE, |b| &b.canopy_force_ned),
    ("rotor_m", BODY, "_nm", MOMENT, |b| &b.rotor_moment_body),
    ("aero_m", BODY, "_nm", MOMENT, |b| &b.aero_moment_body),
    ("reaction_m", BODY, "_nm", MOMENT, |b| &b.reaction_moment_body),
    ("gyro_m", BODY, "_nm", MOMENT, |b| &b.gyro_moment_body),
    ("ground_f", NED, "_n", GROUND, |b| &b.ground_force_ned),
    ("ground_m", BODY, "_nm", GROUND, |b| &b.ground_moment_body),
];

/// Behind some columns those of a body's state.
pub(super) fn with_body<R>(
    columns: Columns<R>,
    of: impl Fn(&R) -> &BodyState + Copy + 'static,
) -> Columns<R> {
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
pub(super) fn flight_columns(mission: &Mission, ground: bool) -> Columns<Sample> {
    const TIME: &str = "time since the simulation began; since the rotors were freed, empty before";
    const SETPOINT: &str = "velocity setpoint, empty before the first";
    const CANOPY: &str = "position and velocity of the canopy, where it is a [body of its own](parachute.md)";
    const RISER: &str = "tension of the riser, and its moment on the vehicle in body axes";
    const DISK: &str = "velocity of each hub along the thrust and across it, over the induced one of hover";
    const BUS: &str = "bus, pack and each speed controller, where the [battery has a voltage](battery.md)";
    let n = mission.vehicle.rotors.len().min(MAX_ROTORS);
    let limits = mission.limits.safety;
    let mut columns = Columns::<Sample>::none()
        .number("t_s", TIME, |s| s.t_s)
        .number("t_powered_s", TIME, |s| s.t_powered_s)
        .choice("phase", "phase of the drop", &["hanging", "falling", "powered"], |s| s.phase as usize);
    columns = with_body(columns, |s| &s.state.body)
        .numbers(["an_m_s2", "ae_m_s2", "ad_m_s2"], "acceleration", |s, i| s.a_ned[i])
        .numbers(["vn_sp_m_s", "ve_sp_m_s", "vd_sp_m_s"], SETPOINT, |s, i| Some(s.v_sp_ned?[i]))
        .number("j_state", "J_state: the share of the limit that is used", move |s| {
            StateCost::of_sample(s, &limits).max()
        });
    for (name, unit, about, values) in PER_ROTOR {
        let names = (1..=n).map(|i| format!("{name}_{i}{unit}"));
        columns = columns.numbers(names, about, move |s, i| values(s)[i]);
    }
    for (name, axes, unit, about, vector) in BALANCE.into_iter().take(if ground { 10 } else { 8 }) {
        let names = axes.map(|axis| format!("{name}{axis}{unit}"));
        columns = columns.numbers(names, about, move |s, i| vector(&s.balance)[i]);
    }
    if !mission.site.wind.is_steady() {
        let names = NED.map(|axis| format!("wind_{axis}_m_s"));
        columns = columns.numbers(names, "velocity of the air, where the wind changes", |s, i| s.wind_ned[i]);
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
            let thrust_n = s.balance.thrust_n[k / 2];
            let disk = DiskState::of(&vehicle, k / 2, &site, &s.state.body, &s.wind_ned, thrust_n)?;
            Some([disk.climb, disk.in_plane][k % 2])
        });
    }
    if mission.vehicle.start.is_some() {
        let about = "0 braked, 1 free, 2 trying, 3 waiting, 4 running, 5 given up ([start](rotor_start.md))";
        let names = (1..=n).map(|i| format!("esc_{i}"));
        columns = columns.numbers(names, about, |s, i| Some(s.esc.as_ref()?[i].number()));
    }
    if mission.electric.is_some() {
        columns = columns
            .number("bus_v", BUS, |s| Some(s.bus.as_ref()?.bus_v))
            .number("pack_current_a", BUS, |s| Some(s.bus.as_ref()?.pack_a))
            .number("charge_percent", BUS, |s| Some(100.0 * s.bus.as_ref()?.charge))
            .numbers((1..=n).map(|i| format!("rotor{i}_current_a")), BUS, |s, i| {
                Some(s.bus.as_ref()?.esc_a[i])
            });
    }
    columns
}
