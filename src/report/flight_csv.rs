//! The flight log as CSV: one row per sample - time, state, setpoint, commands, rotors, J_state and every
//! term of the balance of forces.
//!
//! Comment lines at the top hold version, seed and the hash of the inputs; the header row names each column
//! with its unit (attitude, throttle and J_state have none). A field is empty where it has no value: the
//! plan's time before the release, the setpoint while there is none. Numbers are the shortest that read back
//! to the same bits.
//!
//! The sums to check: `m a_ned = C^T (rotor + aero) + gravity + canopy + ground` and
//! `J omega_dot = rotor_m + aero_m + reaction_m + gyro_m + ground_m - omega x J omega`.

use std::fmt::Write as _;
use std::io::{self, Write};

use crate::assess::{SafetyLimits, StateCost};
use crate::config::Stamp;
use crate::model::MAX_ROTORS;
use crate::sim::{Phase, Sample};

const STATE: &str = "t_s,t_powered_s,phase,north_m,east_m,down_m,q0,q1,q2,q3,vn_m_s,ve_m_s,vd_m_s,p_rad_s,q_rad_s,r_rad_s,\
                     an_m_s2,ae_m_s2,ad_m_s2,vn_sp_m_s,ve_sp_m_s,vd_sp_m_s,j_state";
/// Name and unit of the columns that exist once per rotor.
const PER_ROTOR: [(&str, &str); 4] =
    [("throttle", ""), ("rotor_speed", "_rad_s"), ("thrust", "_n"), ("torque", "_nm")];
const BALANCE: &str = "rotor_fx_n,rotor_fy_n,rotor_fz_n,aero_fx_n,aero_fy_n,aero_fz_n,\
                       gravity_fn_n,gravity_fe_n,gravity_fd_n,canopy_fn_n,canopy_fe_n,canopy_fd_n,\
                       rotor_mx_nm,rotor_my_nm,rotor_mz_nm,aero_mx_nm,aero_my_nm,aero_mz_nm,\
                       reaction_mx_nm,reaction_my_nm,reaction_mz_nm,gyro_mx_nm,gyro_my_nm,gyro_mz_nm";

/// Columns of a mission with ground.
const GROUND: &str = ",ground_fn_n,ground_fe_n,ground_fd_n,ground_mx_nm,ground_my_nm,ground_mz_nm";

/// Writes a flight log, row by row.
#[derive(Debug)]
pub struct FlightCsv<W: Write> {
    out: W,
    n_rotors: usize,
    limits: SafetyLimits,
    /// Whether there are columns of the ground.
    ground: bool,
    row: String,
}

impl<W: Write> FlightCsv<W> {
    /// Begins the file: comment lines and header. `out` should be buffered; `limits` give J_state its scale.
    ///
    /// # Errors
    /// What `out` returns.
    pub fn new(out: W, n_rotors: usize, limits: SafetyLimits, stamp: &Stamp) -> io::Result<Self> {
        Self::begin(out, n_rotors, limits, stamp, false)
    }

    /// Begins the file like [`Self::new`], with columns of the forces of the ground.
    ///
    /// # Errors
    /// What `out` returns.
    pub fn with_ground(out: W, n_rotors: usize, limits: SafetyLimits, stamp: &Stamp) -> io::Result<Self> {
        Self::begin(out, n_rotors, limits, stamp, true)
    }

    fn begin(
        mut out: W,
        n_rotors: usize,
        limits: SafetyLimits,
        stamp: &Stamp,
        ground: bool,
    ) -> io::Result<Self> {
        let n_rotors = n_rotors.min(MAX_ROTORS);
        let mut header = format!("{}{STATE}", stamp.csv_comment());
        for (name, unit) in PER_ROTOR {
            for i in 1..=n_rotors {
                header += &format!(",{name}_{i}{unit}");
            }
        }
        let more = if ground { GROUND } else { "" };
        writeln!(out, "{header},{BALANCE}{more}")?;
        Ok(Self { out, n_rotors, limits, ground, row: String::with_capacity(2048) })
    }

    /// Writes a sample.
    ///
    /// # Errors
    /// What the output returns.
    pub fn write(&mut self, sample: &Sample) -> io::Result<()> {
        self.row.clear();
        self.write_state(sample);
        let n = self.n_rotors;
        let b = &sample.balance;
        for per_rotor in [&sample.throttle, &sample.state.rotor_speed, &b.thrust_n, &b.torque_nm] {
            self.numbers(&per_rotor[..n]);
        }
        for vector in [
            &b.rotor_force_body,
            &b.aero_force_body,
            &b.gravity_force_ned,
            &b.canopy_force_ned,
            &b.rotor_moment_body,
            &b.aero_moment_body,
            &b.reaction_moment_body,
            &b.gyro_moment_body,
        ] {
            self.numbers(vector.as_slice());
        }
        if self.ground {
            self.numbers(b.ground_force_ned.as_slice());
            self.numbers(b.ground_moment_body.as_slice());
        }
        self.row.pop();
        self.row.push('\n');
        self.out.write_all(self.row.as_bytes())
    }

    /// Ends the file and returns the output, flushed.
    ///
    /// # Errors
    /// What the output returns.
    pub fn finish(mut self) -> io::Result<W> {
        self.out.flush()?;
        Ok(self.out)
    }

    fn write_state(&mut self, sample: &Sample) {
        let body = &sample.state.body;
        self.number(sample.t_s);
        match sample.t_powered_s {
            Some(t) => self.number(t),
            None => self.row.push(','),
        }
        self.row.push_str(phase_name(sample.phase));
        self.row.push(',');
        self.numbers(body.p_ned.as_slice());
        self.numbers(&body.q_ned_from_body);
        self.numbers(body.v_ned.as_slice());
        self.numbers(body.omega_body.as_slice());
        self.numbers(sample.a_ned.as_slice());
        match sample.v_sp_ned {
            Some(v) => self.numbers(v.as_slice()),
            None => self.row.push_str(",,,"),
        }
        self.number(StateCost::of(body, &self.limits).max());
    }

    fn numbers(&mut self, values: &[f64]) {
        for &x in values {
            self.number(x);
        }
    }

    /// Appends a number and a comma.
    fn number(&mut self, x: f64) {
        if x == 0.0 {
            // Most fields of a flight in the plane. (-0 is written as 0.)
            self.row.push_str("0.0,");
        } else {
            // `{:?}` is the shortest text that reads back to the same number. Writing to a String cannot
            // fail.
            let _ = write!(self.row, "{x:?},");
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
