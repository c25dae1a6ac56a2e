//! What a drop asks of its battery: least voltage, greatest currents, and how long a limit held the motors
//! back.

use crate::model::supply::{HeldBy, PackLimits};
use crate::sim::Sample;

/// A quantity at its extreme, and when that was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extreme {
    /// The quantity, in the unit of its name.
    pub value: f64,
    /// Time since the rotors were freed [s].
    pub at_s: f64,
}

/// What a drop asked of its battery, from the release to the end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PowerUse {
    /// Least bus voltage [V].
    pub bus_least_v: Extreme,
    /// Greatest current of the pack [A].
    pub pack_most_a: Extreme,
    /// Greatest current of a speed controller [A].
    pub esc_most_a: Extreme,
    /// The rotor of that speed controller, from 1.
    pub esc_most_rotor: usize,
    /// Most current of the pack [A]; infinite: no limit.
    pub pack_limit_a: f64,
    /// Most current of a speed controller [A]; infinite: no limit.
    pub esc_limit_a: f64,
    /// Time that the bus voltage held a motor back [s].
    pub voltage_held_s: f64,
    /// Time that a speed controller's current did [s].
    pub esc_held_s: f64,
    /// Time that the pack's current did [s].
    pub pack_held_s: f64,
    /// Charge at the end, as a share of the full one.
    pub charge_left: f64,
    /// When it was empty, since the rotors were freed [s].
    pub empty_at_s: Option<f64>,
    /// Time of the sample before, since the rotors were freed [s], and what held a motor back then.
    before: Option<(f64, HeldBy)>,
}

impl PowerUse {
    /// Of a battery with these limits, before the first sample.
    pub(super) fn of(limits: &PackLimits) -> Self {
        let none = |value| Extreme { value, at_s: 0.0 };
        Self {
            bus_least_v: none(f64::INFINITY),
            pack_most_a: none(f64::NEG_INFINITY),
            esc_most_a: none(f64::NEG_INFINITY),
            esc_most_rotor: 1,
            pack_limit_a: limits.current_max_a,
            esc_limit_a: limits.esc_current_max_a,
            voltage_held_s: 0.0,
            esc_held_s: 0.0,
            pack_held_s: 0.0,
            charge_left: f64::NAN,
            empty_at_s: None,
            before: None,
        }
    }

    /// Takes the next sample from the release on.
    pub(super) fn observe(&mut self, sample: &Sample) {
        let (Some(bus), Some(t_s)) = (&sample.bus, sample.t_powered_s) else { return };
        if let Some((before_s, held_by)) = self.before {
            for (held, total_s) in [
                (held_by.voltage, &mut self.voltage_held_s),
                (held_by.esc_current, &mut self.esc_held_s),
                (held_by.pack_current, &mut self.pack_held_s),
            ] {
                if held {
                    *total_s += t_s - before_s;
                }
            }
        }
        let now = |value| Extreme { value, at_s: t_s };
        if bus.bus_v < self.bus_least_v.value {
            self.bus_least_v = now(bus.bus_v);
        }
        if bus.pack_a > self.pack_most_a.value {
            self.pack_most_a = now(bus.pack_a);
        }
        for (i, current_a) in bus.esc_a.iter().enumerate() {
            if *current_a > self.esc_most_a.value {
                self.esc_most_a = now(*current_a);
                self.esc_most_rotor = i + 1;
            }
        }
        self.charge_left = bus.charge;
        if bus.charge <= 0.0 {
            self.empty_at_s.get_or_insert(t_s);
        }
        self.before = Some((t_s, bus.held_by));
    }

    /// Least of limit over greatest current, of pack and speed controllers; infinite without a limit.
    pub fn current_margin(&self) -> f64 {
        let pack = self.pack_limit_a / self.pack_most_a.value.max(0.0);
        pack.min(self.esc_limit_a / self.esc_most_a.value.max(0.0))
    }
}
