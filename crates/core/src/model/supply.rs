//! The electric supply of the motors: a battery whose voltage falls with its charge and with the current, and
//! what it and the speed controllers leave to each motor.
//!
//! Quasi-static: at each instant the bus voltage is the one at which battery and motors agree,
//!
//! ```text
//! V_bus = E(charge) - R_b I_bus        I_bus = sum_i P_i/(eta V_bus)
//! ```
//!
//! with P_i the electric power of motor i and eta the efficiency of the speed controllers; of the two
//! voltages at which a constant power is met, it is the higher one. A DC motor takes `(K_e omega + R I) I` at
//! the current I that its speed controller gives it, its voltage at most the bus'. A motor of first order has
//! no current of its own: what its rotor takes at the shaft, `(Q + J omega_dot) omega`, over its efficiency,
//! is its power, and its speed at full throttle goes with the bus voltage over the nominal one
//! ([`Throttle`]).
//!
//! Currents are limited at each speed controller, and in sum at the pack; what is above the pack's limit is
//! taken by one ceiling on the current of all speed controllers. Beyond `E/(2 R_b)` a battery gives less
//! power the more current it gives: that is the pack's limit at the latest. A battery without charge gives
//! nothing: its motors are without current. Left out: inductance, recovery (a braking motor gives nothing
//! back), and what time and temperature do to the resistance.

use super::motor::{EscDcLaw, FirstOrderLaw, Motor, MotorCondition, MotorLaw, forwards};
use super::{MAX_ROTORS, ModelError, PerRotor, check, check_positive};
use crate::real::{Mask as _, Real};

/// Part of the voltage without load to which battery and motors agree.
const AGREEMENT: f64 = 1e-13;
/// The search for it takes two or three steps.
const STEPS_AT_MOST: u32 = 100;
/// From so many steps on every other one halves the bounds.
const SECANTS: u32 = 8;
/// A current that comes this close to a limit, as a part of it, is held by it.
const AT_LIMIT: f64 = 1e-9;

/// A battery as the bus sees it.
#[derive(Clone, Debug, PartialEq)]
pub struct Pack {
    open_circuit: Vec<(f64, f64)>,
    limits: PackLimits,
}

/// Resistance, limits and efficiencies of a [`Pack`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PackLimits {
    /// Internal resistance R_b with that of the wires [ohm].
    pub resistance_ohm: f64,
    /// Most current of the pack [A]; infinite: no limit.
    pub current_max_a: f64,
    /// Most current that a speed controller takes from the bus [A]; infinite: no limit.
    pub esc_current_max_a: f64,
    /// Share of a speed controller's electric power that reaches the motor.
    pub esc_efficiency: f64,
    /// Shaft over electric power of a motor of first order.
    pub motor_efficiency: f64,
    /// Bus voltage at which a motor of first order has its speed at full throttle [V].
    pub nominal_v: f64,
    /// Meaning of the throttle of a motor of first order.
    pub throttle: Throttle,
}

/// Meaning of the throttle of a motor of first order whose bus voltage is not the nominal one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Throttle {
    /// A speed, which the speed controller holds as long as the voltage allows it; never above the one at
    /// full throttle on a stiff supply.
    #[default]
    Speed,
    /// A part of the bus voltage (a duty cycle): the speed goes with the voltage at any throttle, on a full
    /// battery beyond the one at full throttle on a stiff supply.
    Duty,
}

/// What the supply leaves to each motor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Supply<S = f64> {
    /// Bus voltage [V].
    pub bus_v: S,
    /// Most electric power of a motor [W].
    pub motor_power_max_w: S,
    /// Bus voltage over the nominal one.
    pub voltage_share: S,
    /// Shaft over electric power of a motor of first order.
    pub motor_efficiency: f64,
    /// Meaning of the throttle of a motor of first order.
    pub throttle: Throttle,
}

/// The bus at an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BusState {
    /// Voltage [V].
    pub bus_v: f64,
    /// Current of the pack [A].
    pub pack_a: f64,
    /// Current of each speed controller [A].
    pub esc_a: PerRotor,
    /// Charge that is left, as a share of the full one.
    pub charge: f64,
    /// Limits that hold a motor back.
    pub held_by: HeldBy,
}

/// Limits of a supply that hold a motor back.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HeldBy {
    /// The bus voltage: a motor is commanded beyond it.
    pub voltage: bool,
    /// The current of a speed controller.
    pub esc_current: bool,
    /// The current of the pack.
    pub pack_current: bool,
}

/// The bus at an instant, as it is solved.
#[derive(Clone, Copy, Debug)]
pub struct Bus<S: Real> {
    /// Voltage [V].
    pub bus_v: S,
    /// Current of the pack [A].
    pub pack_a: S,
    /// Current of each speed controller [A].
    pub esc_a: [S; MAX_ROTORS],
    /// Where the bus voltage holds a motor back.
    pub held_by_voltage: S::Mask,
    /// Where the current of a speed controller does.
    pub held_by_esc_current: S::Mask,
    /// Where the current of the pack does.
    pub held_by_pack_current: S::Mask,
}

impl Bus<f64> {
    /// The bus of a battery at a share of its charge.
    pub fn at_charge(&self, charge: f64) -> BusState {
        let Self { bus_v, pack_a, esc_a, .. } = *self;
        let held_by = HeldBy {
            voltage: self.held_by_voltage,
            esc_current: self.held_by_esc_current,
            pack_current: self.held_by_pack_current,
        };
        BusState { bus_v, pack_a, esc_a, charge, held_by }
    }
}

/// Condition, command, speed and load of one motor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotorState<S = f64> {
    /// What a fault has made of it.
    pub condition: MotorCondition,
    /// Throttle command, 0..1.
    pub throttle: S,
    /// Speed [rad/s].
    pub omega_rad_s: S,
    /// Torque of the air that brakes it [N m].
    pub torque_nm: S,
}

impl Pack {
    /// A battery of these voltages without load [V] by the share of its charge that is left, 0..1.
    ///
    /// # Errors
    /// [`ModelError`] when there is no voltage, one is not positive, the charges do not increase or the
    /// voltages fall with them, the resistance is negative, a limit is not positive or an efficiency is not
    /// above 0 and at most 1.
    pub fn new(open_circuit: Vec<(f64, f64)>, limits: PackLimits) -> Result<Self, ModelError> {
        let rises = |w: &[(f64, f64)]| w[0].0 < w[1].0 && w[0].1 <= w[1].1;
        if open_circuit.is_empty() || !open_circuit.windows(2).all(rises) {
            let message = "a battery needs at least one voltage, charges that increase and voltages that do \
                           not fall with them";
            return Err(ModelError::Table(message.to_owned()));
        }
        for (charge, volt) in &open_circuit {
            check((0.0..=1.0).contains(charge), "charge", "in 0 to 1", *charge)?;
            check_positive("voltage without load", *volt)?;
        }
        let PackLimits { resistance_ohm, current_max_a, esc_current_max_a, nominal_v, .. } = limits;
        let possible = resistance_ohm.is_finite() && resistance_ohm >= 0.0;
        check(possible, "internal resistance", "at least zero", resistance_ohm)?;
        check(current_max_a > 0.0, "current of the pack", "positive", current_max_a)?;
        check(esc_current_max_a > 0.0, "current of a speed controller", "positive", esc_current_max_a)?;
        check_positive("nominal voltage", nominal_v)?;
        for efficiency in [limits.esc_efficiency, limits.motor_efficiency] {
            check(efficiency > 0.0 && efficiency <= 1.0, "efficiency", "above 0, at most 1", efficiency)?;
        }
        Ok(Self { open_circuit, limits })
    }

    /// Resistance, limits and efficiencies.
    pub fn limits(&self) -> &PackLimits {
        &self.limits
    }

    /// Voltage without load at a share of the charge [V]: linear, held beyond the ends.
    pub fn open_circuit_v(&self, charge: f64) -> f64 {
        let table = &self.open_circuit;
        let above = table.partition_point(|(c, _)| *c <= charge);
        match (above.checked_sub(1).and_then(|i| table.get(i)), table.get(above)) {
            (Some((c0, v0)), Some((c1, v1))) => v0 + (v1 - v0) * ((charge - c0) / (c1 - c0)),
            (Some((_, v)), None) | (None, Some((_, v))) => *v,
            (None, None) => 0.0,
        }
    }

    /// The battery's charge when full [C] if it gives this energy [J] from full to empty without load: the
    /// energy over the mean of the voltage.
    pub fn capacity_c(&self, energy_j: f64) -> f64 {
        let table = &self.open_circuit;
        let between = table.windows(2).map(|w| 0.5 * (w[0].1 + w[1].1) * (w[1].0 - w[0].0));
        let (first, last) = (table.first().copied().unwrap_or_default(), table.last().copied());
        let (last_charge, last_v) = last.unwrap_or_default();
        let mean_v = first.0 * first.1 + between.sum::<f64>() + (1.0 - last_charge) * last_v;
        energy_j / mean_v
    }

    /// Power that a motor takes from the bus in steady rotation at a speed [rad/s] against a torque [N m],
    /// with what its speed controller loses [W].
    pub fn steady_power_w(&self, motor: &Motor, omega_rad_s: f64, torque_nm: f64) -> f64 {
        let motor_w = match motor {
            Motor::EscDc(m) => {
                let current_a = torque_nm / m.torque_constant_nm_a;
                (m.back_emf_constant_v_s_rad * omega_rad_s + m.resistance_ohm * current_a) * current_a
            }
            Motor::FirstOrder { .. } => torque_nm * omega_rad_s / self.limits.motor_efficiency,
        };
        motor_w / self.limits.esc_efficiency
    }

    /// Bus voltage under a constant power [W] at a share of the charge [V], limits of currents aside: the
    /// greater root of `V^2 - E V + R P = 0`; `None` when the battery cannot give the power.
    pub fn bus_v_under(&self, power_w: f64, charge: f64) -> Option<f64> {
        let open_v = self.open_circuit_v(charge);
        let square = open_v * open_v - 4.0 * self.limits.resistance_ohm * power_w;
        (square >= 0.0).then(|| 0.5 * (open_v + square.sqrt()))
    }

    /// What motors in these states get of a battery with this voltage without load [V], and what they take;
    /// no voltage: nothing. The search for the bus voltage begins at `near_v` [V], which changes no more of
    /// its outcome than what battery and motors may disagree by: a part 1e-13 of the voltage without load.
    #[inline(always)]
    pub fn supply<S: Real>(
        &self,
        open_v: S,
        law: &MotorLaw,
        motors: &[MotorState<S>],
        near_v: S,
    ) -> (Supply<S>, Bus<S>) {
        let zero = open_v.of(0.0);
        let charged = zero.less(open_v);
        let none = charged & !charged;
        let mut bus = Bus {
            bus_v: zero,
            pack_a: zero,
            esc_a: [zero; MAX_ROTORS],
            held_by_voltage: none,
            held_by_esc_current: none,
            held_by_pack_current: none,
        };
        if !charged.any() {
            return (self.left_of(zero, zero), bus);
        }
        let resistance_ohm = open_v.of(self.limits.resistance_ohm);
        let most_a = open_v.of(self.limits.current_max_a).at_most(open_v * 0.5 / resistance_ohm);
        let takers = Takers::of(law, motors, zero, 1.0 / self.limits.motor_efficiency);
        let mut search = BusSearch::new(open_v, near_v, !charged);
        let supply = loop {
            let supply = self.at(search.bus_v, most_a, &takers, &mut bus);
            let drop_v = resistance_ohm * bus.pack_a;
            if search.ends(search.bus_v + drop_v - open_v, drop_v) {
                break supply;
            }
        };
        let limit_a = zero.of(self.limits.esc_current_max_a * (1.0 - AT_LIMIT));
        for (state, current_a) in motors.iter().zip(bus.esc_a) {
            bus.held_by_voltage = bus.held_by_voltage | supply.is_held_by_voltage(law, state);
            bus.held_by_esc_current = bus.held_by_esc_current | !current_a.less(limit_a);
        }
        if charged.all() {
            return (supply, bus);
        }
        bus.bus_v = S::select(charged, bus.bus_v, zero);
        bus.pack_a = S::select(charged, bus.pack_a, zero);
        for current in &mut bus.esc_a {
            *current = S::select(charged, *current, zero);
        }
        bus.held_by_voltage = bus.held_by_voltage & charged;
        bus.held_by_esc_current = bus.held_by_esc_current & charged;
        bus.held_by_pack_current = bus.held_by_pack_current & charged;
        let nothing = self.left_of(zero, zero);
        let supply = Supply {
            bus_v: bus.bus_v,
            motor_power_max_w: S::select(charged, supply.motor_power_max_w, nothing.motor_power_max_w),
            voltage_share: S::select(charged, supply.voltage_share, nothing.voltage_share),
            ..supply
        };
        (supply, bus)
    }

    /// What is left to a motor at a bus voltage and a ceiling of its speed controller's current.
    #[inline(always)]
    fn left_of<S: Real>(&self, bus_v: S, ceiling_a: S) -> Supply<S> {
        let PackLimits { esc_efficiency, motor_efficiency, nominal_v, throttle, .. } = self.limits;
        Supply {
            bus_v,
            motor_power_max_w: ceiling_a * bus_v * esc_efficiency,
            voltage_share: bus_v / bus_v.of(nominal_v),
            motor_efficiency,
            throttle,
        }
    }

    /// Supply at a voltage, the pack's current at most `most_a`; the bus is told its currents.
    #[inline(always)]
    fn at<S: Real>(&self, bus_v: S, most_a: S, takers: &Takers<'_, S>, bus: &mut Bus<S>) -> Supply<S> {
        let limits = &self.limits;
        let esc_max_a = bus_v.of(limits.esc_current_max_a);
        let supply = self.left_of(bus_v, esc_max_a);
        let per_watt = bus_v.of(1.0) / (bus_v * limits.esc_efficiency);
        bus.bus_v = bus_v;
        bus.pack_a = bus_v.of(0.0);
        for (i, current) in bus.esc_a.iter_mut().enumerate().take(takers.motors.len()) {
            *current = takers.power_w(i, &supply) * per_watt;
            bus.pack_a += *current;
        }
        let beyond = most_a.less(bus.pack_a);
        bus.held_by_pack_current = beyond;
        if !beyond.any() {
            return supply;
        }
        let ceiling_a = ceiling(&bus.esc_a, takers.motors.len(), most_a);
        for current in &mut bus.esc_a {
            *current = S::select(beyond, current.at_most(ceiling_a), *current);
        }
        bus.pack_a = S::select(beyond, most_a, bus.pack_a);
        self.left_of(bus_v, S::select(beyond, ceiling_a, esc_max_a))
    }
}

/// The search for the voltage at which battery and motors agree: secants, inside bounds that narrow. Below
/// half the voltage without load is no solution, above all of it neither, and the excess of the voltage over
/// the battery's, `V + R I(V) - E`, rises in between.
struct BusSearch<S: Real> {
    bus_v: S,
    open_v: S,
    low_v: S,
    high_v: S,
    /// Voltage that was tried before, and its excess.
    before: [S; 2],
    /// Where it has ended.
    over: S::Mask,
    steps: u32,
}

impl<S: Real> BusSearch<S> {
    #[inline(always)]
    fn new(open_v: S, near_v: S, over: S::Mask) -> Self {
        let (low_v, high_v) = (open_v * 0.5, open_v);
        let bus_v = near_v.at_least(low_v).at_most(high_v);
        Self { bus_v, open_v, low_v, high_v, before: [bus_v; 2], over, steps: 0 }
    }

    /// Whether the voltage has been found everywhere, by its excess [V] and the drop across the battery's
    /// resistance [V]; where not, it is changed.
    #[inline(always)]
    fn ends(&mut self, excess_v: S, drop_v: S) -> bool {
        let close_v = self.open_v * AGREEMENT;
        self.steps += 1;
        self.over = self.over | !close_v.less(excess_v.abs()) | !close_v.less(self.high_v - self.low_v);
        if self.over.all() || self.steps >= STEPS_AT_MOST {
            return true;
        }
        let below = excess_v.less(excess_v.of(0.0));
        self.low_v = S::select(below, self.bus_v, self.low_v);
        self.high_v = S::select(below, self.high_v, self.bus_v);
        if self.steps == 1 {
            // Motors that take a constant power take a current that falls with the voltage.
            let rise = excess_v.of(1.0) - drop_v / self.bus_v;
            self.before = [self.bus_v - 1.0, excess_v - rise];
        }
        let [from_v, before_v] = self.before;
        let next_v = self.bus_v - excess_v * (self.bus_v - from_v) / (excess_v - before_v);
        self.before = [self.bus_v, excess_v];
        let next_v = next_v.at_least(self.low_v).at_most(self.high_v);
        // A secant that goes nowhere, or has not ended in time: the middle.
        let middle_v = (self.low_v + self.high_v) * 0.5;
        let moves = next_v.less(self.bus_v) | self.bus_v.less(next_v);
        let late = self.steps >= SECANTS && self.steps.is_multiple_of(2);
        let next_v = if late { middle_v } else { S::select(moves, next_v, middle_v) };
        self.bus_v = S::select(self.over, self.bus_v, next_v);
        false
    }
}

/// The ceiling under which the first `n` currents add up to `most_a`, which they exceed: an equal share of
/// what those leave that take less.
#[inline(always)]
fn ceiling<S: Real>(currents: &[S; MAX_ROTORS], n: usize, most_a: S) -> S {
    let (zero, one) = (most_a.of(0.0), most_a.of(1.0));
    let mut share_a = zero;
    for _ in 0..n {
        let (mut left_a, mut above) = (most_a, zero);
        for current in currents.iter().take(n) {
            let less = current.less(share_a);
            left_a -= S::select(less, *current, zero);
            above += S::select(less, zero, one);
        }
        share_a = left_a / above;
    }
    share_a
}

/// Motors on a bus.
struct Takers<'a, S> {
    law: &'a MotorLaw,
    motors: &'a [MotorState<S>],
    /// What of each motor's current does not depend on the voltage: [`MotorLaw::of_state`].
    steady: [S; MAX_ROTORS],
    per_motor_efficiency: f64,
}

impl<'a, S: Real> Takers<'a, S> {
    #[inline(always)]
    fn of(law: &'a MotorLaw, motors: &'a [MotorState<S>], zero: S, per_motor_efficiency: f64) -> Self {
        let mut steady = [zero; MAX_ROTORS];
        for (of_motor, state) in steady.iter_mut().zip(motors) {
            *of_motor = law.of_state(state);
        }
        Self { law, motors, steady, per_motor_efficiency }
    }

    /// Electric power that motor `i` (from 0) takes [W]; none when it brakes, and none without current.
    #[inline(always)]
    fn power_w(&self, i: usize, supply: &Supply<S>) -> S {
        let state = &self.motors[i];
        let omega = state.omega_rad_s;
        if state.condition != MotorCondition::Sound {
            return omega.of(0.0);
        }
        let power_w = match self.law {
            MotorLaw::EscDc(law) => {
                let current = supply.dc_current_a(law, self.steady[i], omega);
                let emf_v = omega * law.motor.back_emf_constant_v_s_rad;
                (emf_v + current * law.motor.resistance_ohm) * current
            }
            MotorLaw::FirstOrder(law) => {
                let rate = forwards(omega, supply.first_order_acceleration(law, self.steady[i], state));
                let torque_nm = state.torque_nm + rate * law.rotor_inertia_kg_m2;
                torque_nm * omega * self.per_motor_efficiency
            }
        };
        power_w.at_least(omega.of(0.0))
    }
}

impl MotorLaw {
    /// What of a motor's current in a state does not depend on the voltage of its bus: of a DC motor the
    /// voltage that its speed controller asks for [V]; of one of first order `1/(J omega)` [s/(N m)], zero
    /// where its power does not bound its acceleration.
    #[inline(always)]
    fn of_state<S: Real>(&self, state: &MotorState<S>) -> S {
        let omega = state.omega_rad_s;
        match self {
            Self::EscDc(law) => law.asked_v(state.throttle, omega),
            Self::FirstOrder(law) => {
                let zero = omega.of(0.0);
                S::select(zero.less(omega), omega.of(law.per_inertia) / omega, zero)
            }
        }
    }
}

impl<S: Real> Supply<S> {
    /// Current of a DC motor [A]: what its speed controller, that asks for a voltage [V], gives it at the bus
    /// voltage, at most that of the power left to it.
    #[inline(always)]
    fn dc_current_a(&self, law: &EscDcLaw, asked_v: S, omega: S) -> S {
        let m = &law.motor;
        let most_v = omega.of(m.voltage_max_v).at_most(self.bus_v);
        let voltage = asked_v.at_least(omega.of(0.0)).at_most(most_v);
        let current = law.current_a(voltage, omega);
        // The current of a power P: R I^2 + K_e omega I = P.
        let emf_v = omega * m.back_emf_constant_v_s_rad;
        let root = (emf_v * emf_v + self.motor_power_max_w * (4.0 * m.resistance_ohm)).sqrt();
        current.at_most((root - emf_v) * (0.5 * law.per_ohm))
    }

    /// Acceleration of a motor of first order [rad/s^2], by its [`MotorLaw::of_state`].
    #[inline(always)]
    fn first_order_acceleration(&self, law: &FirstOrderLaw, per_j_omega: S, state: &MotorState<S>) -> S {
        let rate = law.acceleration_to(self.speed_share(state.throttle), state.omega_rad_s);
        let most =
            self.motor_power_max_w * self.motor_efficiency * per_j_omega - state.torque_nm * law.per_inertia;
        S::select(rate.of(0.0).less(per_j_omega), rate.at_most(most), rate)
    }

    /// Part of the speed at full throttle that a motor of first order goes for.
    #[inline(always)]
    fn speed_share(&self, throttle: S) -> S {
        match self.throttle {
            Throttle::Speed => throttle.at_most(self.voltage_share),
            Throttle::Duty => throttle * self.voltage_share,
        }
    }

    /// Whether a motor is commanded beyond the bus voltage, and not beyond its own; of one whose throttle is
    /// a duty cycle, whether that is full and gives less than the speed of full throttle.
    #[inline(always)]
    fn is_held_by_voltage(&self, law: &MotorLaw, state: &MotorState<S>) -> S::Mask {
        let (throttle, bus_v) = (state.throttle, self.bus_v);
        let held = match law {
            MotorLaw::EscDc(law) => {
                let asked_v = law.asked_v(throttle, state.omega_rad_s);
                bus_v.less(bus_v.of(law.motor.voltage_max_v)) & bus_v.less(asked_v)
            }
            MotorLaw::FirstOrder(_) => match self.throttle {
                Throttle::Speed => self.voltage_share.less(throttle),
                Throttle::Duty => {
                    let full = bus_v.of(1.0);
                    !throttle.less(full) & self.voltage_share.less(full)
                }
            },
        };
        if state.condition == MotorCondition::Sound { held } else { held & !held }
    }

    /// Angular acceleration of a rotor [rad/s^2] as [`MotorLaw::acceleration_in`] has it, with what the
    /// supply leaves to the motor. A motor of first order needs a rotor with inertia for a limit of its power
    /// to act.
    #[inline(always)]
    pub fn acceleration(&self, law: &MotorLaw, state: &MotorState<S>) -> S {
        let (omega, torque_nm) = (state.omega_rad_s, state.torque_nm);
        if state.condition != MotorCondition::Sound {
            return law.acceleration_in(state.condition, state.throttle, omega, torque_nm);
        }
        let steady = law.of_state(state);
        let rate = match law {
            MotorLaw::EscDc(law) => law.acceleration_at(self.dc_current_a(law, steady, omega), torque_nm),
            MotorLaw::FirstOrder(law) => self.first_order_acceleration(law, steady, state),
        };
        let supplied = omega.of(0.0).less(self.bus_v);
        if supplied.all() {
            return forwards(omega, rate);
        }
        let off = law.acceleration_in(MotorCondition::Unpowered, state.throttle, omega, torque_nm);
        S::select(supplied, forwards(omega, rate), off)
    }
}

#[cfg(test)]
mod tests {
    use super::super::EscDc;
    use super::*;
    use proptest::prelude::*;

    fn limits() -> PackLimits {
        PackLimits {
            resistance_ohm: 0.05,
            current_max_a: f64::INFINITY,
            esc_current_max_a: f64::INFINITY,
            esc_efficiency: 0.95,
            motor_efficiency: 0.8,
            nominal_v: 14.8,
            throttle: Throttle::Speed,
        }
    }

    fn pack(limits: PackLimits) -> Pack {
        Pack::new(vec![(0.0, 13.2), (0.5, 15.0), (1.0, 16.8)], limits).unwrap()
    }

    fn first_order() -> Motor {
        Motor::FirstOrder {
            omega_max_rad_s: 900.0,
            tau_up_s: 0.05,
            tau_down_s: 0.08,
            rotor_inertia_kg_m2: 5e-5,
        }
    }

    fn dc() -> Motor {
        Motor::EscDc(EscDc {
            omega_max_rad_s: 900.0,
            torque_constant_nm_a: 0.012,
            back_emf_constant_v_s_rad: 0.012,
            resistance_ohm: 0.1,
            voltage_max_v: 16.0,
            current_max_a: 40.0,
            current_min_a: 0.0,
            esc_gain_v_s_rad: 0.1,
            rotor_inertia_kg_m2: 5e-5,
        })
    }

    fn supplied(pack: &Pack, charge: f64, motor: &Motor, states: &[MotorState]) -> (Supply, BusState) {
        let open_v = if charge > 0.0 { pack.open_circuit_v(charge) } else { 0.0 };
        let (supply, bus) = pack.supply(open_v, &motor.law(), states, open_v);
        (supply, bus.at_charge(charge))
    }

    fn steady(omega_rad_s: f64) -> MotorState {
        MotorState {
            throttle: omega_rad_s / 900.0,
            omega_rad_s,
            torque_nm: 1.4e-7 * omega_rad_s * omega_rad_s,
            ..MotorState::default()
        }
    }

    #[test]
    fn closed_form_voltage_without_load() {
        let pack = pack(limits());
        for (charge, volt) in [(0.0, 13.2), (0.25, 14.1), (0.5, 15.0), (0.75, 15.9), (1.0, 16.8), (2.0, 16.8)]
        {
            assert!((pack.open_circuit_v(charge) - volt).abs() < 1e-12, "{charge}");
        }
    }

    /// Four steady motors of first order take `P = 4 Q omega/(eta_m eta)`: the bus is at the greater root of
    /// `V^2 - E V + R P = 0`.
    #[test]
    fn closed_form_constant_power_on_an_internal_resistance() {
        let state = steady(600.0);
        let (supply, currents) = supplied(&pack(limits()), 1.0, &first_order(), &[state; 4]);
        let power_w = 4.0 * state.torque_nm * 600.0 / (0.8 * 0.95);
        let wanted = 0.5 * (16.8 + (16.8f64 * 16.8 - 4.0 * 0.05 * power_w).sqrt());
        let pack_alone = pack(limits());
        let each_w = pack_alone.steady_power_w(&first_order(), 600.0, state.torque_nm);
        assert!((pack_alone.bus_v_under(4.0 * each_w, 1.0).unwrap() - wanted).abs() < 1e-12);
        assert_eq!(pack_alone.bus_v_under(16.8 * 16.8 / 0.2 + 1e-6, 1.0), None);
        assert!((supply.bus_v - wanted).abs() < 1e-9, "{} {wanted}", supply.bus_v);
        assert!((currents.pack_a - power_w / wanted).abs() < 1e-9);
        assert!((currents.esc_a[2] - 0.25 * currents.pack_a).abs() < 1e-9 && currents.esc_a[4] == 0.0);
    }

    /// Without limits and resistance a motor accelerates as it does without a battery, to the bit.
    #[test]
    fn a_stiff_battery_changes_nothing() {
        let stiff = PackLimits { resistance_ohm: 0.0, ..limits() };
        for motor in [first_order(), dc()] {
            for (throttle, omega_rad_s) in [(0.0, 0.0), (1.0, 0.0), (0.7, 300.0), (0.2, 600.0), (1.0, 890.0)]
            {
                let torque_nm = 1e-7 * omega_rad_s * omega_rad_s;
                let state = MotorState { throttle, omega_rad_s, torque_nm, ..MotorState::default() };
                let (supply, _) = supplied(&pack(stiff), 1.0, &motor, &[state; 4]);
                let alone = motor.law().acceleration(throttle, omega_rad_s, state.torque_nm);
                assert_eq!(supply.acceleration(&motor.law(), &state), alone, "{motor:?} {state:?}");
            }
        }
    }

    /// Volts at 100 % held up to there, 15 V in the mean of 13.2, 15 and 16.8 V: 15 W h are 1 A h.
    #[test]
    fn closed_form_charge_of_an_energy() {
        assert!((pack(limits()).capacity_c(15.0 * 3600.0) - 3600.0).abs() < 1e-9);
        let one = Pack::new(vec![(0.3, 12.0)], limits()).unwrap();
        assert!((one.capacity_c(12.0) - 1.0).abs() < 1e-12);
    }

    /// Full throttle at 11.1 of the nominal 14.8 V: three quarters of the speed, and at half throttle as well
    /// if the throttle is a duty cycle.
    #[test]
    fn closed_form_the_speed_goes_with_the_voltage() {
        for (throttle, wanted) in [(Throttle::Speed, [675.0, 450.0]), (Throttle::Duty, [675.0, 337.5])] {
            let limits = PackLimits { resistance_ohm: 0.0, throttle, ..limits() };
            let pack = Pack::new(vec![(0.0, 11.1)], limits).unwrap();
            for (throttle, wanted) in [1.0, 0.5].into_iter().zip(wanted) {
                let state = MotorState { throttle, ..MotorState::default() };
                let (supply, bus) = supplied(&pack, 1.0, &first_order(), &[state]);
                let omega_c = 0.05 * supply.acceleration(&first_order().law(), &state);
                assert!((omega_c - wanted).abs() < 1e-9, "{omega_c}");
                assert_eq!(bus.held_by.voltage, wanted == 675.0);
            }
        }
    }

    /// Without charge there is no current: a DC motor is braked by the air alone, and one of first order goes
    /// to rest by its time constant. A motor that a fault has taken from the bus takes nothing either.
    #[test]
    fn closed_form_without_charge_or_with_a_fault_a_motor_takes_nothing() {
        let state = MotorState { throttle: 1.0, ..steady(600.0) };
        for (motor, wanted) in [(first_order(), -600.0 / 0.08), (dc(), -state.torque_nm / 5e-5)] {
            let (supply, bus) = supplied(&pack(limits()), 0.0, &motor, &[state; 4]);
            assert_eq!(bus, BusState::default());
            assert!((supply.acceleration(&motor.law(), &state) / wanted - 1.0).abs() < 1e-12);
            let off = MotorState { condition: MotorCondition::Unpowered, ..state };
            let (supply, bus) = supplied(&pack(limits()), 1.0, &motor, &[state, off, state]);
            assert!(bus.esc_a[1] == 0.0 && bus.esc_a[0] == bus.esc_a[2] && bus.esc_a[0] > 0.0);
            assert!((supply.acceleration(&motor.law(), &off) / wanted - 1.0).abs() < 1e-12);
        }
    }

    /// A ceiling shared by all: 5, 10, 20 and 25 A under 40 A are 5, 10, 12.5 and 12.5 A.
    #[test]
    fn closed_form_the_pack_s_limit_is_one_ceiling() {
        let currents = [20.0, 5.0, 25.0, 10.0, 0.0, 0.0, 0.0, 0.0];
        assert_eq!(ceiling(&currents, 4, 40.0), 12.5);
        assert_eq!(ceiling(&currents, 4, 8.0), 2.0);
    }

    proptest! {
        /// Whatever is asked, no limit is passed, battery and motors agree on the voltage, and what the
        /// motors take is what they are left.
        #[test]
        fn prop_no_limit_is_passed(
            charge in 0.001f64..1.0, throttle in prop::array::uniform4(0.0f64..1.0),
            omega in prop::array::uniform4(0.0f64..950.0), is_dc: bool,
            pack_max in prop_oneof![Just(f64::INFINITY), 5.0f64..150.0],
            esc_max in prop_oneof![Just(f64::INFINITY), 1.0f64..40.0], resistance_ohm in 0.0f64..0.4,
            off in prop::option::of(0usize..4), duty: bool, begin in 0.4f64..1.1,
        ) {
            let limits = PackLimits {
                resistance_ohm,
                current_max_a: pack_max,
                esc_current_max_a: esc_max,
                ..limits()
            };
            let (pack, motor) = (pack(limits), if is_dc { dc() } else { first_order() });
            let states: [MotorState; 4] = std::array::from_fn(|i| MotorState {
                throttle: throttle[i],
                omega_rad_s: omega[i],
                torque_nm: 1.4e-7 * omega[i] * omega[i],
                condition: if off == Some(i) { MotorCondition::Unpowered } else { MotorCondition::Sound },
            });
            let law = motor.law();
            let open_v = pack.open_circuit_v(charge);
            let (supply, currents) = pack.supply(open_v, &law, &states, open_v);
            // Wherever the search begins, it ends there.
            let (elsewhere, _) = pack.supply(open_v, &law, &states, begin * open_v);
            prop_assert!((elsewhere.bus_v / supply.bus_v - 1.0).abs() < 1e-11, "{elsewhere:?} {supply:?}");
            prop_assert!(supply.bus_v >= 0.499 * open_v && supply.bus_v <= open_v);
            prop_assert!(currents.pack_a <= pack_max * (1.0 + 1e-9));
            let drop_v = open_v - supply.bus_v;
            prop_assert!((drop_v - resistance_ohm * currents.pack_a).abs() < 1e-6, "{drop_v} {currents:?}");
            for (state, current) in states.iter().zip(currents.esc_a) {
                prop_assert!(current <= esc_max * (1.0 + 1e-9));
                let takers = Takers::of(&law, std::slice::from_ref(state), 0.0, 1.0 / 0.8);
                let bus_w = takers.power_w(0, &supply) / 0.95;
                let off_w = bus_w - current * supply.bus_v;
                prop_assert!(off_w.abs() < 1e-6 * (1.0 + bus_w), "{bus_w} {current}");
            }
        }
    }
}
