//! Whether a mission is the paper's study: a hash of the numbers that the study's flights depend on, each
//! under a name.
//!
//! Names in the code are not of it, nor is what the study does not fly: names, gains, the seed, the number of
//! trials, sensors, hang and wire. A plan that starts from the release ([`PlanInitial::Release`]) is never
//! the paper's, so the swing that it starts with is left out too.

use std::fmt::{Debug, Write};

use super::{Mission, PlanInitial, PlanSettings};
use crate::source::sha256;
use samara_core::assess::paper::STUDY_SHA256;
use samara_core::control::{ThrustCurve, TiltFrom};

use samara_core::model::{EscDc, Interference, Motor, RotationSense, Rotor, Vehicle};
use samara_core::plan::{Demands, InputReference};

/// Beginnings of the lines that say how the paper's control law is read, where that is not the first reading.
const OF_THE_READING: [&str; 2] = ["control.tilt_from=", "control.thrust_curve="];

impl Mission {
    /// The numbers of vehicle, site, plan, limits, cases and distribution of releases as they are in memory:
    /// `name=value`, a line each, in a fixed order. A value has all the digits that read back to the same
    /// bits.
    pub fn study_numbers(&self) -> String {
        let mut text = Numbers(String::new());
        text.vehicle(&self.vehicle);
        let site = &self.site.environment;
        text.put("site.gravity_m_s2", site.gravity_m_s2);
        text.put("site.density_kg_m3", site.density_kg_m3);
        text.list("site.wind_ned_m_s", &site.wind_ned_m_s);
        text.list("target_v_ned_m_s", &self.target_v_ned);
        text.plan(&self.plan);
        let (safety, cascade) = (&self.limits.safety, &self.control.limits);
        text.put("limits.speed_m_s", safety.speed_m_s);
        text.put("limits.pitch_rad", safety.pitch_rad);
        text.put("limits.pitch_rate_rad_s", safety.pitch_rate_rad_s);
        text.put("limits.vertical_acceleration_m_s2", safety.vertical_acceleration_m_s2);
        text.put("control.tilt_limit_rad", cascade.tilt_rad);
        text.put("control.rate_command_limit_rad_s", cascade.rate_command_rad_s);
        text.put("control.yaw_rate_command_limit_rad_s", cascade.yaw_rate_command_rad_s);
        text.put("control.rate_integral_limit_rad_s2", cascade.rate_integral_rad_s2);
        if cascade.tilt_from != TiltFrom::Thrust {
            text.put("control.tilt_from", cascade.tilt_from.name());
        }
        if cascade.thrust_curve != ThrustCurve::Quadratic {
            text.put("control.thrust_curve", cascade.thrust_curve.name());
        }
        if let Some(nominal_v) = cascade.nominal_v {
            text.put("control.nominal_v", nominal_v);
        }
        if self.vehicle.latency_s != 0.0 {
            text.put("control.latency_s", self.vehicle.latency_s);
        }
        if self.control.feed_forward {
            text.put("control.feed_forward", true);
        }
        let (parachute, random) = (&self.release.parachute, &self.study.monte_carlo);
        text.put("parachute.descent_m_s", parachute.descent_m_s);
        text.put("parachute.delay_s", parachute.delay_s);
        if let Some(hook) = parachute.hook {
            text.put("parachute.hook.lets_go_before_s", hook.lets_go_before_s);
        }
        for (name, given) in
            [("release.tip_off", &parachute.tip_off), ("monte_carlo.tip_off", &random.tip_off_sigma)]
        {
            if !given.is_none() {
                text.list(&format!("{name}.omega_body"), &given.omega_body);
                text.list(&format!("{name}.v_body"), &given.v_body);
            }
        }
        text.put("monte_carlo.amplitude_sigma_rad", random.amplitude_sigma_rad);
        text.put("monte_carlo.omega_rad_s", random.omega_rad_s);
        text.put("monte_carlo.length_m", random.length_m);
        if let Some(uncertain) = &self.uncertain {
            text.put("uncertain", uncertain);
        }
        for (i, case) in self.study.cases.iter().enumerate() {
            text.list(&format!("cases[{i}].v_ned_m_s"), &case.v_ned);
            text.put(&format!("cases[{i}].pitch_rad"), case.pitch_rad);
            text.put(&format!("cases[{i}].pitch_rate_rad_s"), case.pitch_rate_rad_s);
        }
        if let Some(ring) = &self.site.wind.ring {
            text.put("vortex_ring.rms_share", ring.rms_share);
            text.put("vortex_ring.frequency_hz", ring.frequency_hz);
        }
        for (i, fault) in self.faults.list.iter().enumerate() {
            text.put(&format!("faults[{i}]"), fault);
        }
        text.0
    }

    /// Whether this is the study that stands for the paper's, in any reading of its control law
    /// ([`TiltFrom`], [`ThrustCurve`]): then what the paper prints may stand beside it.
    pub fn is_the_papers_study(&self) -> bool {
        let numbers = self.study_numbers();
        let is_common = |line: &&str| !OF_THE_READING.iter().any(|name| line.starts_with(name));
        let common: String = numbers.split_inclusive('\n').filter(is_common).collect();
        sha256(&common) == STUDY_SHA256
    }
}

/// Puts all fields of a struct; a test sees to the names, which are not to change with the code.
macro_rules! put_fields {
    ($text:ident, $section:literal, $type:ident $value:ident: $($field:ident)*) => {{
        let $type { $($field),* } = $value;
        $($text.put(concat!($section, ".", stringify!($field)), $field);)*
    }};
}

/// Lines of `name=value`.
struct Numbers(String);

impl Numbers {
    fn put(&mut self, name: &str, value: impl Debug) {
        // Writing to a string does not fail. `{:?}` of a number is the shortest text that reads back to the
        // same bits.
        let _ = writeln!(self.0, "{name}={value:?}");
    }

    fn list<'a>(&mut self, name: &str, values: impl IntoIterator<Item = &'a f64>) {
        for (i, value) in values.into_iter().enumerate() {
            self.put(&format!("{name}[{i}]"), value);
        }
    }

    fn word(&mut self, name: &str, word: &str) {
        let _ = writeln!(self.0, "{name}={word}");
    }

    fn vehicle(&mut self, vehicle: &Vehicle) {
        let inertia = &vehicle.mass.inertia_kg_m2;
        self.put("vehicle.mass_kg", vehicle.mass.mass_kg);
        for (entry, at) in
            [("xx", (0, 0)), ("yy", (1, 1)), ("zz", (2, 2)), ("xy", (0, 1)), ("xz", (0, 2)), ("yz", (1, 2))]
        {
            self.put(&format!("vehicle.inertia_kg_m2.{entry}"), inertia[at]);
        }
        for (i, mount) in vehicle.rotors.iter().enumerate() {
            self.list(&format!("vehicle.rotors[{i}].position_body_m"), &mount.position_body_m);
            self.list(&format!("vehicle.rotors[{i}].axis_body"), &mount.axis_body);
            let sense = match mount.spin {
                RotationSense::Cw => "cw",
                RotationSense::Ccw => "ccw",
            };
            self.word(&format!("vehicle.rotors[{i}].spin_from_above"), sense);
            if mount.interference != Interference::NONE {
                let Interference { thrust, torque } = mount.interference;
                self.put(&format!("vehicle.rotors[{i}].interference.thrust"), thrust);
                self.put(&format!("vehicle.rotors[{i}].interference.torque"), torque);
            }
        }
        self.put("vehicle.effects.reaction_torque", vehicle.options.reaction_torque);
        self.put("vehicle.effects.rotor_momentum", vehicle.options.rotor_momentum);
        let aero = &vehicle.aero;
        self.put("vehicle.body_aero.reference_area_m2", aero.area_m2());
        self.put("vehicle.body_aero.reference_span_m", aero.span_m());
        if let Some(area_m2) = aero.side_area_m2() {
            self.put("vehicle.body_aero.side_drag_area_m2", area_m2);
        }
        let [c_drag, c_lift, c_pitch] = aero.coefficients();
        self.list("vehicle.body_aero.alpha_rad", c_drag.knots());
        // The value at each knot but the last, which is the first a turn later.
        for (name, spline) in [("c_drag", c_drag), ("c_lift", c_lift), ("c_pitch", c_pitch)] {
            self.list(&format!("vehicle.body_aero.{name}"), spline.pieces().iter().map(|[value, ..]| value));
        }
        self.rotor(&vehicle.rotor);
        self.motor(&vehicle.motor);
    }

    fn rotor(&mut self, rotor: &Rotor) {
        match rotor {
            Rotor::BladeElement(table) => {
                self.put("vehicle.rotor.blade_element.radius_m", table.radius_m());
                for (k, name) in ["c_thrust", "c_in_plane", "c_torque"].into_iter().enumerate() {
                    let name = format!("vehicle.rotor.blade_element.{name}");
                    self.list(&name, table.cells().iter().map(|cell| &cell[k]));
                }
            }
            Rotor::Table(table) => {
                let [omega, airspeed, angle] = table.knots();
                self.put("vehicle.rotor.table.density_kg_m3", table.density_kg_m3());
                self.list("vehicle.rotor.table.omega_rad_s", omega);
                self.list("vehicle.rotor.table.airspeed_m_s", airspeed);
                self.list("vehicle.rotor.table.angle_rad", angle);
                self.list("vehicle.rotor.table.thrust_n", table.cells().iter().map(|[thrust, _]| thrust));
                self.list("vehicle.rotor.table.torque_nm", table.cells().iter().map(|[_, torque]| torque));
            }
            Rotor::Quadratic {
                thrust_n_per_rad2_s2,
                torque_per_thrust_m,
                drag_n_s2_per_rad_m,
                density_kg_m3,
            } => {
                self.put("vehicle.rotor.quadratic.thrust_n_per_rad2_s2", thrust_n_per_rad2_s2);
                self.put("vehicle.rotor.quadratic.torque_per_thrust_m", torque_per_thrust_m);
                if *drag_n_s2_per_rad_m > 0.0 {
                    self.put("vehicle.rotor.quadratic.drag_n_s2_per_rad_m", drag_n_s2_per_rad_m);
                }
                self.put("vehicle.rotor.quadratic.density_kg_m3", density_kg_m3);
            }
        }
    }

    fn motor(&mut self, motor: &Motor) {
        match motor {
            Motor::EscDc(motor) => put_fields!(self, "vehicle.motor.esc_dc", EscDc motor: omega_max_rad_s
                torque_constant_nm_a back_emf_constant_v_s_rad resistance_ohm voltage_max_v current_max_a
                current_min_a esc_gain_v_s_rad rotor_inertia_kg_m2),
            Motor::FirstOrder { omega_max_rad_s, tau_up_s, tau_down_s, rotor_inertia_kg_m2 } => {
                self.put("vehicle.motor.first_order.omega_max_rad_s", omega_max_rad_s);
                self.put("vehicle.motor.first_order.tau_up_s", tau_up_s);
                self.put("vehicle.motor.first_order.tau_down_s", tau_down_s);
                self.put("vehicle.motor.first_order.rotor_inertia_kg_m2", rotor_inertia_kg_m2);
            }
        }
    }

    fn plan(&mut self, plan: &PlanSettings) {
        self.put("plan.horizon_s", plan.horizon_s);
        let initial = match plan.initial {
            PlanInitial::Paper => "paper",
            PlanInitial::Release => "release",
        };
        self.word("plan.initial", initial);
        self.put("plan.nodes", plan.nodes);
        self.put("plan.thrust_max_n", plan.thrust_max_n);
        self.put("plan.thrust_slew_n_s", plan.thrust_slew_n_s);
        self.list("plan.cost_state", &plan.cost_state);
        self.put("plan.cost_input_per_n2", plan.cost_input);
        let reference = match plan.cost_input_reference {
            InputReference::Zero => "zero",
            InputReference::Trim => "trim",
        };
        self.word("plan.cost_input_reference", reference);
        if let Some(tolerance) = plan.terminal_tolerance_m_s {
            self.put("plan.terminal_tolerance_m_s", tolerance);
        }
        match &plan.x_ss {
            Some(x_ss) => self.list("plan.x_ss", x_ss),
            None => self.word("plan.x_ss", "trim"),
        }
        if plan.demands != Demands::default() {
            self.put("plan.demands", plan.demands);
        }
    }
}
