//! The columns of a flight log: names with units, and a sample's values in the same order.
//!
//! One list for `flight.csv` and for the messages of `drop.mcap`.

use std::sync::Arc;

use nalgebra::Vector3;

use samara_core::assess::{SafetyLimits, StateCost};
use samara_core::model::{DiskState, Environment, ForceBalance, MAX_ROTORS, PerRotor, Rotor, Vehicle};
use samara_core::sim::{Phase, Sample};
use samara_mission::Mission;

const STATE: &str = "t_s,t_powered_s,phase,north_m,east_m,down_m,q0,q1,q2,q3,vn_m_s,ve_m_s,vd_m_s,p_rad_s,q_rad_s,r_rad_s,\
                     an_m_s2,ae_m_s2,ad_m_s2,vn_sp_m_s,ve_sp_m_s,vd_sp_m_s,j_state";
/// A quantity of each rotor: the columns' name and unit, and the values.
type PerRotorColumns = (&'static str, &'static str, fn(&Sample) -> &PerRotor);
const PER_ROTOR: [PerRotorColumns; 4] = [
    ("throttle", "", |s| &s.throttle),
    ("rotor_speed", "_rad_s", |s| &s.state.rotor_speed),
    ("thrust", "_n", |s| &s.balance.thrust_n),
    ("torque", "_nm", |s| &s.balance.torque_nm),
];

/// A vector of the balance of forces and moments: the columns' name, letters of the axes and unit, and the
/// vector.
type VectorColumns = (&'static str, [char; 3], &'static str, fn(&ForceBalance) -> &Vector3<f64>);
const BODY: [char; 3] = ['x', 'y', 'z'];
const NED: [char; 3] = ['n', 'e', 'd'];
const BALANCE: [VectorColumns; 8] = [
    ("rotor_f", BODY, "_n", |b| &b.rotor_force_body),
    ("aero_f", BODY, "_n", |b| &b.aero_force_body),
    ("gravity_f", NED, "_n", |b| &b.gravity_force_ned),
    ("canopy_f", NED, "_n", |b| &b.canopy_force_ned),
    ("rotor_m", BODY, "_nm", |b| &b.rotor_moment_body),
    ("aero_m", BODY, "_nm", |b| &b.aero_moment_body),
    ("reaction_m", BODY, "_nm", |b| &b.reaction_moment_body),
    ("gyro_m", BODY, "_nm", |b| &b.gyro_moment_body),
];
/// Further vectors of a mission with ground.
const GROUND: [VectorColumns; 2] =
    [("ground_f", NED, "_n", |b| &b.ground_force_ned), ("ground_m", BODY, "_nm", |b| &b.ground_moment_body)];

/// Columns of a canopy that is a body of its own.
const CANOPY: [&str; 10] = [
    "canopy_north_m",
    "canopy_east_m",
    "canopy_down_m",
    "canopy_vn_m_s",
    "canopy_ve_m_s",
    "canopy_vd_m_s",
    "riser_tension_n",
    "canopy_mx_nm",
    "canopy_my_nm",
    "canopy_mz_nm",
];

/// Columns of the bus, before the current of each rotor's speed controller.
const BUS: [&str; 3] = ["bus_v", "pack_current_a", "charge_percent"];

fn vectors(ground: bool) -> impl Iterator<Item = &'static VectorColumns> {
    BALANCE.iter().chain(GROUND.iter().filter(move |_| ground))
}

/// A value of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Field {
    /// A number, in the unit of the column's name.
    Number(f64),
    /// The phase of the drop.
    Word(&'static str),
    /// No value: the plan's time before the release, the setpoint while there is none.
    Empty,
}

/// The columns of a mission's flight.
#[derive(Clone, Debug)]
pub(super) struct FlightColumns {
    n_rotors: usize,
    /// Give J_state its scale.
    limits: SafetyLimits,
    ground: bool,
    /// Whether there are those of a wind that changes.
    wind: bool,
    /// Whether there are those of a canopy that is a body of its own.
    canopy: bool,
    /// Vehicle and site where the rotors' blades are known.
    disks: Option<(Arc<Vehicle>, Environment)>,
    /// Whether there are those of the rotors' start.
    start: bool,
    /// Whether there are those of the bus of a battery with a voltage.
    bus: bool,
}

impl FlightColumns {
    /// The columns of a mission's flight; `ground`: whether there are those of the forces of the ground.
    pub(super) fn of(mission: &Mission, ground: bool) -> Self {
        let n_rotors = mission.vehicle.rotors.len().min(MAX_ROTORS);
        let wind = !mission.site.wind.is_steady();
        let canopy = mission.release.parachute.suspension.is_some() && !mission.release.standing;
        let known = matches!(mission.vehicle.rotor, Rotor::BladeElement(_));
        let disks = known.then(|| (mission.vehicle.clone(), mission.site.environment.clone()));
        let start = mission.vehicle.start.is_some();
        let bus = mission.electric.is_some();
        Self { n_rotors, limits: mission.limits.safety, ground, wind, canopy, disks, start, bus }
    }

    /// Names of the columns, with units.
    pub(super) fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = STATE.split(',').map(str::to_owned).collect();
        for (name, unit, _) in PER_ROTOR {
            names.extend((1..=self.n_rotors).map(|i| format!("{name}_{i}{unit}")));
        }
        for (name, axes, unit, _) in vectors(self.ground) {
            names.extend(axes.iter().map(|axis| format!("{name}{axis}{unit}")));
        }
        if self.wind {
            names.extend(NED.iter().map(|axis| format!("wind_{axis}_m_s")));
        }
        if self.canopy {
            names.extend(CANOPY.map(str::to_owned));
        }
        if self.disks.is_some() {
            let of_rotor = |i| [format!("rotor{i}_vc_over_vh"), format!("rotor{i}_mu_over_vh")];
            names.extend((1..=self.n_rotors).flat_map(of_rotor));
        }
        if self.start {
            names.extend((1..=self.n_rotors).map(|i| format!("esc_{i}")));
        }
        if self.bus {
            names.extend(BUS.map(str::to_owned));
            names.extend((1..=self.n_rotors).map(|i| format!("rotor{i}_current_a")));
        }
        names
    }

    /// Gives `put` the value of each column.
    pub(super) fn row(&self, sample: &Sample, put: &mut impl FnMut(Field)) {
        let body = &sample.state.body;
        put(Field::Number(sample.t_s));
        put(sample.t_powered_s.map_or(Field::Empty, Field::Number));
        put(Field::Word(phase_name(sample.phase)));
        let mut numbers = |values: &[f64]| values.iter().for_each(|x| put(Field::Number(*x)));
        numbers(body.p_ned.as_slice());
        numbers(&body.q_ned_from_body);
        numbers(body.v_ned.as_slice());
        numbers(body.omega_body.as_slice());
        numbers(sample.a_ned.as_slice());
        match sample.v_sp_ned {
            Some(v) => v.iter().for_each(|x| put(Field::Number(*x))),
            None => (0..3).for_each(|_| put(Field::Empty)),
        }
        put(Field::Number(StateCost::of_sample(sample, &self.limits).max()));
        let mut numbers = |values: &[f64]| values.iter().for_each(|x| put(Field::Number(*x)));
        for (.., values) in PER_ROTOR {
            numbers(&values(sample)[..self.n_rotors]);
        }
        for (.., vector) in vectors(self.ground) {
            numbers(vector(&sample.balance).as_slice());
        }
        if self.wind {
            numbers(sample.wind_ned.as_slice());
        }
        if self.canopy {
            match &sample.canopy {
                Some(canopy) => {
                    numbers(canopy.state.p_ned.as_slice());
                    numbers(canopy.state.v_ned.as_slice());
                    numbers(&[canopy.tension_n]);
                    numbers(sample.balance.canopy_moment_body.as_slice());
                }
                None => CANOPY.iter().for_each(|_| put(Field::Empty)),
            }
        }
        if let Some((vehicle, site)) = &self.disks {
            for i in 0..self.n_rotors {
                let thrust_n = sample.balance.thrust_n[i];
                let disk = DiskState::of(vehicle, i, site, body, &sample.wind_ned, thrust_n);
                put(disk.map_or(Field::Empty, |disk| Field::Number(disk.climb)));
                put(disk.map_or(Field::Empty, |disk| Field::Number(disk.in_plane)));
            }
        }
        if self.start {
            for i in 0..self.n_rotors {
                put(sample.esc.map_or(Field::Empty, |esc| Field::Number(esc[i].number())));
            }
        }
        if self.bus {
            match &sample.bus {
                Some(bus) => {
                    let mut numbers = |values: &[f64]| values.iter().for_each(|x| put(Field::Number(*x)));
                    numbers(&[bus.bus_v, bus.pack_a, 100.0 * bus.charge]);
                    numbers(&bus.esc_a[..self.n_rotors]);
                }
                None => (0..BUS.len() + self.n_rotors).for_each(|_| put(Field::Empty)),
            }
        }
    }
}

fn phase_name(phase: Phase) -> &'static str {
    match phase {
        Phase::Hanging => "hanging",
        Phase::Falling => "falling",
        Phase::Powered => "powered",
    }
}
