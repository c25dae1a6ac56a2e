//! What differs in the control law between versions of PX4. Everything else of the law is in all of them.

use super::Parameters;
use super::timing::SWITCH_S;

/// How a thrust becomes a pulse, which is of whole microseconds up to v1.17.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rounding {
    /// What is beyond a microsecond is cut off.
    Down,
    /// The nearest one.
    Nearest,
    /// None: the pulse is a number of single precision.
    Exact,
}

/// How PX4 comes from what a power module measures to the voltage of a cell without load, by which it scales
/// torque and thrust (MC_BAT_SCALE_EN).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellVoltage {
    /// The filtered voltage, raised by BAT1_R_INTERNAL times the filtered current, or where that is negative
    /// by BAT1_V_LOAD_DROP times the filtered throttle; between BAT1_V_EMPTY and BAT1_V_CHARGED.
    RaisedByFilteredThrottle,
    /// As before, but the throttle counts unfiltered, and in place of no current too.
    RaisedByThrottle,
    /// Voltage raised by BAT1_R_INTERNAL times the current, then filtered.
    RaisedThenFiltered,
}

/// How far PX4's estimator looks back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Window {
    /// As the oldest sensor's readings are, which a drop sets for it (EKF2_AVEL_DELAY).
    OldestSensor,
    /// By a parameter of its own (EKF2_DELAY_MAX).
    DelayMax,
}

/// The control law of a version, in what differs from the others'.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law {
    /// The first version that has it.
    pub since: &'static str,
    /// Time from t = 0 to velocity control [s]. Where that takes long, velocities are asked for before.
    pub velocity_control_after_s: f64,
    /// Period of the estimator's output and of the velocity loop in lockstep [s].
    pub velocity_period_s: f64,
    /// Attitude and velocity are estimated for the IMU sample before.
    pub estimates_the_sample_before: bool,
    /// Vertical thrust leaves room for horizontal thrust (MPC_THR_XY_MARG).
    pub leaves_horizontal_room: bool,
    /// The horizontal integral tracks what was met only where that is less than what was wanted.
    pub tracks_only_what_is_short: bool,
    /// MPC_ACC_DECOUPLE is there: at 0 the vertical acceleration counts in the tilt.
    pub may_couple_accelerations: bool,
    /// The angular acceleration's filter is of the first order, not the second.
    pub smooths_acceleration_once: bool,
    /// Yaw torque passes a filter (MC_YAW_TQ_CUTOFF).
    pub filters_yaw_torque: bool,
    /// The attitude setpoint passes a reference model (MC_REF_W_N); its rates may be fed forward (MC_REF_FF).
    pub follows_a_reference: bool,
    /// Rotors are given their thrusts by allocation from their geometry (CA_*), not by a mixer file.
    pub allocates: bool,
    /// The simulated outputs rest and come up slowly after arming.
    pub ramps_up: bool,
    /// How pulses are rounded.
    pub rounding: Rounding,
    /// How the voltage of a cell without load is estimated.
    pub cell_voltage: CellVoltage,
    /// How far the estimator looks back; `None`: it is not modelled.
    pub window: Option<Window>,
}

impl Law {
    /// The law of v1.12.0.
    pub const V1_12: Self = Self {
        since: "v1.12",
        velocity_control_after_s: SWITCH_S,
        velocity_period_s: 0.01,
        estimates_the_sample_before: false,
        leaves_horizontal_room: false,
        tracks_only_what_is_short: false,
        may_couple_accelerations: false,
        smooths_acceleration_once: false,
        filters_yaw_torque: false,
        follows_a_reference: false,
        allocates: false,
        ramps_up: true,
        rounding: Rounding::Down,
        cell_voltage: CellVoltage::RaisedByFilteredThrottle,
        window: None,
    };
    /// The law of v1.14.3.
    pub const V1_14: Self = Self {
        since: "v1.14",
        velocity_control_after_s: 0.0,
        velocity_period_s: 0.008,
        leaves_horizontal_room: true,
        tracks_only_what_is_short: true,
        smooths_acceleration_once: true,
        allocates: true,
        ramps_up: false,
        cell_voltage: CellVoltage::RaisedByThrottle,
        window: Some(Window::OldestSensor),
        ..Self::V1_12
    };
    /// The law of v1.16.0 and v1.17.0-beta1.
    pub const V1_16: Self = Self {
        since: "v1.16",
        estimates_the_sample_before: true,
        may_couple_accelerations: true,
        filters_yaw_torque: true,
        rounding: Rounding::Nearest,
        cell_voltage: CellVoltage::RaisedThenFiltered,
        window: Some(Window::DelayMax),
        ..Self::V1_14
    };
    /// The law of v1.18.0-beta1.
    pub const V1_18: Self =
        Self { since: "v1.18", follows_a_reference: true, rounding: Rounding::Exact, ..Self::V1_16 };

    /// All that the model has, the oldest first.
    pub const ALL: [Self; 4] = [Self::V1_12, Self::V1_14, Self::V1_16, Self::V1_18];

    /// Whether the law reads a parameter of the model's.
    pub fn reads(&self, name: &str) -> bool {
        match name {
            "MPC_THR_XY_MARG" => self.leaves_horizontal_room,
            "MPC_ACC_DECOUPLE" => self.may_couple_accelerations,
            "MC_YAW_TQ_CUTOFF" => self.filters_yaw_torque,
            "MC_REF_W_N" | "MC_REF_FF" | "MC_REF_FF_MAX" => self.follows_a_reference,
            _ if name.starts_with("EKF2_") => self.window.is_some(),
            "BAT1_V_EMPTY" | "BAT1_V_LOAD_DROP" => self.cell_voltage != CellVoltage::RaisedThenFiltered,
            _ => true,
        }
    }

    /// PX4's defaults: v1.12's, but for the battery's, which later versions have changed
    /// (`lib/battery/module.yaml`).
    pub fn defaults(&self) -> Parameters {
        let (bat_v_empty, bat_v_load_drop, bat_r_internal_ohm) = match self.cell_voltage {
            CellVoltage::RaisedByFilteredThrottle => return Parameters::default(),
            CellVoltage::RaisedByThrottle => (3.6, 0.1, 0.005),
            CellVoltage::RaisedThenFiltered => (3.6, 0.1, -1.0),
        };
        Parameters { bat_v_empty, bat_v_load_drop, bat_r_internal_ohm, ..Parameters::default() }
    }
}
