//! Rotors before their motors drive them, and how a speed controller without sensors starts a motor.
//!
//! A rotor that nobody drives turns under the air's torque less the friction of its shaft,
//!
//! ```text
//! J omega_dot = Q_start - Q_air(omega, flow) - Q_f sign(omega)
//! ```
//!
//! with `Q_start = 0`; at rest friction holds it up to `Q_f`. Speeds have a sign: backwards is negative. In
//! flow from below a blade at rest is a plate across the flow; what pushes on it stands square to its chord,
//! and blades of positive pitch are driven backwards, trailing edges first, until the flow along their chords
//! drives them no more: a windmill. The other steady state, forwards, is the autorotation of a helicopter; a
//! rotor comes to it only from speed. Forces of blades at any angle are
//! [`super::blade_element`]'s, at speeds of either sign.
//!
//! A **speed controller** reads the rotor's place from the voltage that it induces, which a slow motor does
//! not: from the catch speed on, forwards, it drives the motor as its model has it. Below it turns the field
//! blindly, with a bounded torque; backwards the torque brakes. A try that has not come to the catch speed in
//! its time is given up, and after a wait there is another one, up to a number of tries. What is commanded
//! slower than the catch speed is off: no current.
//!
//! Sources: AM32 (`Src/main.c`) gives up a try after 22.5 ms without a zero crossing of the voltage, and
//! starting after 10 or 100 of them, until the command is zero; VESC (B. Vedder, vedder.se, 2014) follows a
//! motor that coasts, and joins at its speed. That the torque of a try is one constant number is a choice; so
//! is a friction that does not depend on speed.

use super::{ModelError, check, check_positive};

/// How rotors are before t = 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BeforeStart {
    /// Held at rest.
    Braked,
    /// Turning as the air drives them.
    Free,
}

/// Rotors before their motors drive them, and their start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotorStart {
    /// How rotors are before t = 0.
    pub before: BeforeStart,
    /// Friction of the shaft Q_f, cogging with it [N m]; of a motor that its controller drives it is in the
    /// motor's model.
    pub friction_nm: f64,
    /// How the speed controllers start; `None`: at once, at any speed.
    pub esc: Option<EscStart>,
}

/// How a speed controller starts a motor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EscStart {
    /// Torque of a try, forwards, on a rotor at rest or turning forwards [N m].
    pub start_torque_nm: f64,
    /// Torque of a try, forwards, on a rotor that turns backwards [N m].
    pub brake_torque_nm: f64,
    /// Speed from which the motor is driven as its model has it [rad/s].
    pub catch_speed_rad_s: f64,
    /// Time of a try [s].
    pub try_s: f64,
    /// Tries, after which the controller waits for its command to go.
    pub tries: u32,
    /// Time between tries [s].
    pub wait_s: f64,
}

/// What turns a rotor besides the air.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drive {
    /// Nothing: it is held at its speed.
    Held,
    /// Nothing: it is free.
    Free,
    /// The torque of a try.
    Try,
    /// The motor, as the motor's model has it.
    Motor,
}

impl RotorStart {
    /// Checked numbers.
    ///
    /// # Errors
    /// [`ModelError::OutOfRange`] for a friction below zero, a torque, a speed or a time of a try that is not
    /// positive, no tries or a wait below zero.
    pub fn new(before: BeforeStart, friction_nm: f64, esc: Option<EscStart>) -> Result<Self, ModelError> {
        let not_negative =
            |what, value: f64| check(value.is_finite() && value >= 0.0, what, "zero or more", value);
        not_negative("the rotor's friction", friction_nm)?;
        if let Some(esc) = &esc {
            check_positive("the torque of a try", esc.start_torque_nm)?;
            check_positive("the torque that brakes a rotor", esc.brake_torque_nm)?;
            check_positive("the catch speed", esc.catch_speed_rad_s)?;
            check_positive("the time of a try", esc.try_s)?;
            check(esc.tries > 0, "the number of tries", "positive", f64::from(esc.tries))?;
            not_negative("the wait between tries", esc.wait_s)?;
        }
        Ok(Self { before, friction_nm, esc })
    }

    /// Torque of a try at a speed [rad/s], forwards [N m].
    pub fn try_torque_nm(&self, omega_rad_s: f64) -> f64 {
        match &self.esc {
            Some(esc) if omega_rad_s < 0.0 => esc.brake_torque_nm,
            Some(esc) => esc.start_torque_nm,
            None => 0.0,
        }
    }

    /// What is left of a torque [N m], forwards, that pulls at a rotor turning at a speed [rad/s]: less the
    /// friction, nothing where that holds it.
    pub fn net_torque_nm(&self, torque_nm: f64, omega_rad_s: f64) -> f64 {
        if omega_rad_s > 0.0 {
            torque_nm - self.friction_nm
        } else if omega_rad_s < 0.0 {
            torque_nm + self.friction_nm
        } else if torque_nm.abs() <= self.friction_nm {
            0.0
        } else {
            torque_nm - self.friction_nm.copysign(torque_nm)
        }
    }

    /// The speed [rad/s] that a rotor which nobody drives comes to from another one [rad/s], by the torque of
    /// the air at a speed [N m], which brakes a rotor that turns forwards. `scale_rad_s` is what the search
    /// steps by; a hundred times as far it ends.
    pub fn settled_rad_s(&self, from_rad_s: f64, scale_rad_s: f64, air_nm: impl Fn(f64) -> f64) -> f64 {
        const STEPS_EACH: f64 = 20.0;
        const SCALES: f64 = 100.0;
        let net = |omega: f64| self.net_torque_nm(-air_nm(omega), omega);
        let first = net(from_rad_s);
        if first == 0.0 || !(scale_rad_s > 0.0) || !first.is_finite() {
            return from_rad_s;
        }
        let step = (scale_rad_s / STEPS_EACH).copysign(first);
        let mut low = from_rad_s;
        for _ in 0..(STEPS_EACH * SCALES) as u32 {
            let crosses_rest = low * (low + step) < 0.0;
            let mut high = if crosses_rest { 0.0 } else { low + step };
            if net(high) * first > 0.0 {
                low = high;
                continue;
            }
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if net(middle) * first > 0.0 { low = middle } else { high = middle }
            }
            return high;
        }
        low
    }

    /// The greatest torques [N m] that it takes to bring a rotor from a speed, backwards, to rest, and from
    /// rest to a speed, forwards [rad/s], by the torque of the air at a speed [N m].
    pub fn torques_needed_nm(
        &self,
        [from_rad_s, to_rad_s]: [f64; 2],
        air_nm: impl Fn(f64) -> f64,
    ) -> [f64; 2] {
        const STEPS: u32 = 100;
        let most = |end_rad_s: f64, friction_nm: f64| {
            let at = |k: u32| air_nm(end_rad_s * f64::from(k) / f64::from(STEPS)) + friction_nm;
            (1..=STEPS).map(at).fold(at(0), f64::max)
        };
        let brake_nm = if from_rad_s < 0.0 { most(from_rad_s, -self.friction_nm).max(0.0) } else { 0.0 };
        [brake_nm, most(to_rad_s, self.friction_nm).max(0.0)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::blade_tests::lander;
    use crate::model::coefficient_table::CoefficientTable;
    use crate::random::{Purpose, Stream};

    fn free(friction_nm: f64) -> RotorStart {
        RotorStart::new(BeforeStart::Free, friction_nm, None).unwrap()
    }

    /// Under `Q = k (omega + w)` less a friction a rotor comes to `-w + Q_f/k`, from above and from below, or
    /// to rest, where friction holds it.
    #[test]
    fn closed_form_the_speed_that_a_rotor_comes_to() {
        let settled = |from: f64, friction_nm: f64| {
            free(friction_nm).settled_rad_s(from, 7.0, |omega| 0.1 * (omega + 20.0))
        };
        assert!((settled(0.0, 0.0) + 20.0).abs() < 1e-9);
        assert!((settled(0.0, 0.5) + 15.0).abs() < 1e-9);
        assert!((settled(-100.0, 0.5) + 15.0).abs() < 1e-9);
        assert_eq!(settled(0.0, 2.0), 0.0, "held at rest to the rounding");
        assert_eq!(settled(0.0, 2.5), 0.0);
        assert_eq!(settled(30.0, 2.5), 0.0, "it runs down");
        assert_eq!(settled(-18.0, 2.5), 0.0, "friction slows it down, the air does not hold it");
        assert_eq!(free(0.0).settled_rad_s(3.0, 0.0, |omega| omega), 3.0, "no flow, no scale");
    }

    /// Friction holds, then takes its part, against either sense.
    #[test]
    fn closed_form_friction() {
        let start = free(2.0);
        assert_eq!([1.9, 2.0, -2.0].map(|torque| start.net_torque_nm(torque, 0.0)), [0.0; 3]);
        assert_eq!([3.0, -3.0].map(|torque| start.net_torque_nm(torque, 0.0)), [1.0, -1.0]);
        assert_eq!([4.0, -4.0].map(|omega| start.net_torque_nm(5.0, omega)), [3.0, 7.0]);
    }

    /// The torque that a start takes is that of the air and of friction, largest on the way.
    #[test]
    fn closed_form_the_torque_that_a_start_takes() {
        let esc = EscStart {
            start_torque_nm: 1.0,
            brake_torque_nm: 2.0,
            catch_speed_rad_s: 10.0,
            try_s: 1.0,
            tries: 1,
            wait_s: 0.0,
        };
        let start = RotorStart::new(BeforeStart::Free, 0.25, Some(esc)).unwrap();
        let needed = start.torques_needed_nm([-20.0, 10.0], |omega| 1.5 + 0.05 * omega);
        assert!((needed[0] - 1.25).abs() < 1e-12 && (needed[1] - 2.25).abs() < 1e-12, "{needed:?}");
        assert_eq!([-1.0, 0.0, 1.0].map(|omega| start.try_torque_nm(omega)), [2.0, 1.0, 1.0]);
        let from_rest = start.torques_needed_nm([0.0, 10.0], |omega| omega * (10.0 - omega));
        assert_eq!(from_rest[0], 0.0);
        assert!((from_rest[1] - 25.25).abs() < 1e-12, "{from_rest:?}");
    }

    /// The lander's rotor in its descent: from rest backwards to a windmill without torque; from speed
    /// forwards to the autorotation, which the rotor does not reach from rest. Both are stable.
    #[test]
    fn closed_form_free_rotors_need_no_torque() {
        let blades = lander();
        for descent_m_s in [3.0, 3.675, 6.0] {
            let air_nm = |omega: f64| blades.load(omega, -descent_m_s, 0.0, 5.4).torque_nm;
            let scale = descent_m_s / 0.65;
            let [backwards, forwards] = [0.0, 40.0].map(|from| free(0.0).settled_rad_s(from, scale, air_nm));
            for omega in [backwards, forwards] {
                assert!(air_nm(omega).abs() < 1e-6, "{omega}: {}", air_nm(omega));
                assert!(air_nm(omega - 0.5) < 0.0 && air_nm(omega + 0.5) > 0.0, "{omega} is not stable");
            }
            let shares = [backwards, forwards].map(|omega| omega / scale);
            assert!((-6.1..-5.5).contains(&shares[0]) && (5.0..5.6).contains(&shares[1]), "{shares:?}");
            assert!(air_nm(0.0) > 0.0, "a blade at rest is driven backwards");
        }
    }

    /// The table of a rotor that turns backwards against direct solutions at random speeds and flows:
    /// relative to the thrust or torque, at least to a tenth of hover's at that `(Omega R)^2 + V^2`.
    #[test]
    fn reference_the_table_backwards_is_within_two_percent_of_the_theory() {
        let blades = lander();
        let none = vec![[0.0; 3]; CoefficientTable::grid().count()];
        let table = CoefficientTable::new(0.65, none).unwrap().with_backwards(&blades);
        let hover = blades.hover();
        let mut stream = Stream::new(7, Purpose::Dice, 0);
        let mut errors = [Vec::new(), Vec::new(), Vec::new()];
        for _ in 0..1500 {
            let omega = -60.0 * stream.uniform();
            let v = 8.0 * stream.uniform();
            let climb = v * (2.0 * stream.uniform() - 1.0);
            let in_plane = (v * v - climb * climb).max(0.0).sqrt();
            let direct = blades.load(omega, climb, in_plane, 5.4);
            let flown = table.load(omega, climb, in_plane, 5.4);
            let tip = 0.65 * omega;
            let scale = 0.1 * 5.4 * std::f64::consts::PI * 0.65 * 0.65 * (tip * tip + v * v);
            let thrust = direct.thrust_n.abs().max(scale * hover.thrust);
            let torque = direct.torque_nm.abs().max(scale * 0.65 * hover.torque);
            errors[0].push((flown.thrust_n - direct.thrust_n).abs() / thrust);
            errors[1].push((flown.torque_nm - direct.torque_nm).abs() / torque);
            errors[2].push((flown.in_plane_n - direct.in_plane_n).abs() / thrust);
        }
        let p95 = errors.map(|mut e| {
            e.sort_by(f64::total_cmp);
            e[e.len() * 95 / 100]
        });
        println!("backwards: p95 {p95:?}");
        assert!(p95[0] < 0.02 && p95[1] < 0.02 && p95[2] < 0.005, "{p95:?}");
    }

    #[test]
    fn numbers_without_meaning_are_refused() {
        let esc = EscStart {
            start_torque_nm: 1.0,
            brake_torque_nm: 1.0,
            catch_speed_rad_s: 1.0,
            try_s: 1.0,
            tries: 1,
            wait_s: 0.0,
        };
        let build = |friction_nm, esc| RotorStart::new(BeforeStart::Free, friction_nm, Some(esc));
        assert!(build(0.0, esc).is_ok());
        assert!(build(-1.0, esc).is_err() && build(f64::NAN, esc).is_err());
        for bad in [
            EscStart { start_torque_nm: 0.0, ..esc },
            EscStart { brake_torque_nm: f64::INFINITY, ..esc },
            EscStart { catch_speed_rad_s: -1.0, ..esc },
            EscStart { try_s: 0.0, ..esc },
            EscStart { tries: 0, ..esc },
            EscStart { wait_s: -1.0, ..esc },
        ] {
            assert!(build(0.0, bad).is_err(), "{bad:?}");
        }
    }
}
