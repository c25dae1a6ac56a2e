//! A battery with a voltage in flight: its charge falls by the current of the bus, `q_dot = -I_bus/C`.
//!
//! What the motors get at a charge is [`Pack`]'s to say; without charge they get nothing. The bus is solved
//! at each stage of the integration, the charge is held in a step: it falls by some 1e-5 in one.

use std::sync::Arc;

use crate::model::supply::{BusState, Pack};

/// A battery with a voltage, on a bus with all speed controllers.
#[derive(Clone, Debug, PartialEq)]
pub struct ElectricBattery {
    pack: Arc<Pack>,
    capacity_c: f64,
    left_c: f64,
    consumed_c: f64,
    consumed_j: f64,
    near_v: f64,
}

impl ElectricBattery {
    /// A pack that gives this energy [J] from full to empty without load, with a share of its charge left,
    /// 0..1.
    pub fn new(pack: Pack, energy_j: f64, share_left: f64) -> Self {
        let capacity_c = pack.capacity_c(energy_j);
        let left_c = capacity_c * share_left.clamp(0.0, 1.0);
        let near_v = pack.open_circuit_v(left_c / capacity_c);
        Self { pack: Arc::new(pack), capacity_c, left_c, consumed_c: 0.0, consumed_j: 0.0, near_v }
    }

    /// The pack.
    pub fn pack(&self) -> &Pack {
        &self.pack
    }

    /// Charge when full [C].
    pub fn capacity_c(&self) -> f64 {
        self.capacity_c
    }

    /// Share of the charge that is left, 0..1.
    pub fn charge(&self) -> f64 {
        self.left_c / self.capacity_c
    }

    /// Voltage without load [V]; none without charge.
    pub fn open_v(&self) -> f64 {
        let charge = self.charge();
        if charge > 0.0 { self.pack.open_circuit_v(charge) } else { 0.0 }
    }

    /// Charge that has been taken [C].
    pub fn consumed_c(&self) -> f64 {
        self.consumed_c
    }

    /// Energy that the bus has taken [J]: without what became heat in the battery.
    pub fn consumed_j(&self) -> f64 {
        self.consumed_j
    }

    /// The bus without load.
    pub fn at_rest(&self) -> BusState {
        BusState { bus_v: self.open_v(), charge: self.charge(), ..BusState::default() }
    }

    /// Bus voltage that the last step ended with, from which the next one's is searched [V].
    pub(super) fn near_v(&self) -> f64 {
        self.near_v
    }

    /// Current of the pack at that voltage [A]: the voltage that it has lost over the resistance; none of a
    /// pack without resistance.
    pub(super) fn near_a(&self) -> f64 {
        let resistance_ohm = self.pack.limits().resistance_ohm;
        if resistance_ohm > 0.0 { ((self.open_v() - self.near_v) / resistance_ohm).max(0.0) } else { 0.0 }
    }

    /// Takes a charge [C] and the energy [J] with it, at a bus voltage [V].
    pub(super) fn take(&mut self, charge_c: f64, energy_j: f64, bus_v: f64) {
        self.near_v = bus_v;
        if charge_c.is_finite() && energy_j.is_finite() {
            self.left_c = (self.left_c - charge_c).max(0.0);
            self.consumed_c += charge_c;
            self.consumed_j += energy_j;
        }
    }
}
