//! The parameters that the controller reads, under PX4's names and with the defaults of v1.12 (which later
//! versions changed in places: see `docs/px4_model.md`). Angles are in degrees here, as in PX4.

/// A parameter's name is not one that the model of PX4's controller reads.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the model of PX4's control law does not read {0}")]
pub struct NotRead(pub String);

macro_rules! parameters {
    ($($(#[$doc:meta])* $field:ident $name:literal $default:literal)*) => {
        /// Parameters of the model of PX4's controller.
        #[derive(Clone, Debug, PartialEq)]
        pub struct Parameters {
            $($(#[$doc])* pub $field: f64,)*
        }

        impl Default for Parameters {
            fn default() -> Self {
                Self { $($field: $default,)* }
            }
        }

        impl Parameters {
            /// PX4's names.
            pub const NAMES: &'static [&'static str] = &[$($name),*];

            /// A value by PX4's name.
            pub fn get(&self, name: &str) -> Option<f64> {
                match name {
                    $($name => Some(self.$field),)*
                    _ => None,
                }
            }

            /// Whether a parameter is the battery's, and nothing is scaled by it.
            pub fn is_idle(&self, name: &str) -> bool {
                name.starts_with("BAT1_") && self.bat_scale_en == 0.0
            }

            /// Sets a value by PX4's name.
            ///
            /// # Errors
            /// [`NotRead`] for a name that the controller does not read.
            pub fn set(&mut self, name: &str, value: f64) -> Result<(), NotRead> {
                match name {
                    $($name => self.$field = value,)*
                    _ => return Err(NotRead(name.to_owned())),
                }
                Ok(())
            }
        }
    };
}

parameters! {
    /// Acceleration per horizontal velocity error [1/s].
    xy_vel_p "MPC_XY_VEL_P_ACC" 1.8
    /// Acceleration per integral of it [1/s^2].
    xy_vel_i "MPC_XY_VEL_I_ACC" 0.4
    /// Acceleration per measured acceleration [-].
    xy_vel_d "MPC_XY_VEL_D_ACC" 0.2
    /// As above, vertical [1/s].
    z_vel_p "MPC_Z_VEL_P_ACC" 4.0
    /// As above, vertical [1/s^2].
    z_vel_i "MPC_Z_VEL_I_ACC" 2.0
    /// As above, vertical [-].
    z_vel_d "MPC_Z_VEL_D_ACC" 0.0
    /// Cutoff of the velocity's derivative [Hz].
    veld_lp_hz "MPC_VELD_LP" 5.0
    /// Largest horizontal velocity setpoint [m/s].
    xy_vel_max "MPC_XY_VEL_MAX" 12.0
    /// Fastest climb [m/s].
    z_vel_max_up "MPC_Z_VEL_MAX_UP" 3.0
    /// Fastest descent [m/s].
    z_vel_max_dn "MPC_Z_VEL_MAX_DN" 1.0
    /// Thrust that carries the weight.
    thr_hover "MPC_THR_HOVER" 0.5
    /// Least thrust.
    thr_min "MPC_THR_MIN" 0.12
    /// Most thrust.
    thr_max "MPC_THR_MAX" 1.0
    /// Tilt limit [deg].
    tiltmax_air_deg "MPC_TILTMAX_AIR" 45.0
    /// Tilt limit before take-off [deg].
    tiltmax_lnd_deg "MPC_TILTMAX_LND" 12.0
    /// Body rate per angle [1/s].
    roll_p "MC_ROLL_P" 6.5
    /// Body rate per angle [1/s].
    pitch_p "MC_PITCH_P" 6.5
    /// Body rate per angle [1/s].
    yaw_p "MC_YAW_P" 2.8
    /// How much of a yaw error counts beside tilt, 0..1.
    yaw_weight "MC_YAW_WEIGHT" 0.4
    /// Largest commanded rate [deg/s].
    rollrate_max_deg_s "MC_ROLLRATE_MAX" 220.0
    /// Largest commanded rate [deg/s].
    pitchrate_max_deg_s "MC_PITCHRATE_MAX" 220.0
    /// Largest commanded rate [deg/s].
    yawrate_max_deg_s "MC_YAWRATE_MAX" 200.0
    /// Overall gain on P, I and D.
    rollrate_k "MC_ROLLRATE_K" 1.0
    /// Torque per rate error [s].
    rollrate_p "MC_ROLLRATE_P" 0.15
    /// Torque per integral of it [-].
    rollrate_i "MC_ROLLRATE_I" 0.2
    /// Torque per angular acceleration [s^2].
    rollrate_d "MC_ROLLRATE_D" 0.003
    /// Torque per commanded rate [s].
    rollrate_ff "MC_ROLLRATE_FF" 0.0
    /// Limit of the integral term.
    rr_int_lim "MC_RR_INT_LIM" 0.3
    /// Overall gain on P, I and D.
    pitchrate_k "MC_PITCHRATE_K" 1.0
    /// Torque per rate error [s].
    pitchrate_p "MC_PITCHRATE_P" 0.15
    /// Torque per integral of it [-].
    pitchrate_i "MC_PITCHRATE_I" 0.2
    /// Torque per angular acceleration [s^2].
    pitchrate_d "MC_PITCHRATE_D" 0.003
    /// Torque per commanded rate [s].
    pitchrate_ff "MC_PITCHRATE_FF" 0.0
    /// Limit of the integral term.
    pr_int_lim "MC_PR_INT_LIM" 0.3
    /// Overall gain on P, I and D.
    yawrate_k "MC_YAWRATE_K" 1.0
    /// Torque per rate error [s].
    yawrate_p "MC_YAWRATE_P" 0.2
    /// Torque per integral of it [-].
    yawrate_i "MC_YAWRATE_I" 0.1
    /// Torque per angular acceleration [s^2].
    yawrate_d "MC_YAWRATE_D" 0.0
    /// Torque per commanded rate [s].
    yawrate_ff "MC_YAWRATE_FF" 0.0
    /// Limit of the integral term.
    yr_int_lim "MC_YR_INT_LIM" 0.3
    /// Cutoff of the gyroscope's filter [Hz].
    gyro_cutoff_hz "IMU_GYRO_CUTOFF" 40.0
    /// Cutoff of the angular acceleration's filter [Hz].
    dgyro_cutoff_hz "IMU_DGYRO_CUTOFF" 30.0
    /// Thrust that the vertical leaves to the horizontal, from v1.14 on.
    thr_xy_marg "MPC_THR_XY_MARG" 0.3
    /// Whether the tilt is taken without the vertical acceleration (1), from v1.15 on.
    acc_decouple "MPC_ACC_DECOUPLE" 1.0
    /// Cutoff of the yaw torque's filter [Hz], from v1.16 on.
    yaw_tq_cutoff_hz "MC_YAW_TQ_CUTOFF" 2.0
    /// Natural frequency of the attitude setpoint's reference model [rad/s], from v1.18 on.
    ref_w_n_rad_s "MC_REF_W_N" 50.0
    /// How much of the reference model's rates is fed forward, 0..1.
    ref_ff "MC_REF_FF" 0.0
    /// Most of that on an axis [deg/s]; 0: no limit.
    ref_ff_max_deg_s "MC_REF_FF_MAX" 100.0
    /// Least noise that a satellite's velocity is believed to have [m/s].
    gps_v_noise "EKF2_GPS_V_NOISE" 0.3
    /// Least noise that a satellite's position is believed to have [m].
    gps_p_noise "EKF2_GPS_P_NOISE" 0.5
    /// Noise that the accelerometer is believed to have [m/s^2].
    acc_noise "EKF2_ACC_NOISE" 0.35
    /// Time constant by which the velocity put out follows the estimator's [s].
    tau_vel_s "EKF2_TAU_VEL" 0.25
    /// Time constant by which the height put out follows the estimator's [s].
    tau_pos_s "EKF2_TAU_POS" 0.25
    /// Whether torque and thrust are scaled by the battery's voltage (1).
    bat_scale_en "MC_BAT_SCALE_EN" 0.0
    /// Cells of the battery in series; 0: unknown, nothing is scaled.
    bat_n_cells "BAT1_N_CELLS" 0.0
    /// Voltage of a full cell [V].
    bat_v_charged "BAT1_V_CHARGED" 4.05
    /// Voltage of an empty cell [V].
    bat_v_empty "BAT1_V_EMPTY" 3.5
    /// Voltage that a cell loses at full throttle [V], up to v1.15.
    bat_v_load_drop "BAT1_V_LOAD_DROP" 0.3
    /// Resistance of a cell [ohm]; below 0: unknown.
    bat_r_internal_ohm "BAT1_R_INTERNAL" -1.0
    /// How quadratic a motor's thrust is in its command, 0..1.
    thr_mdl_fac "THR_MDL_FAC" 0.0
}
