//! The effects that a mission and its vehicle name beside the plain drop, and the mission without them.
//!
//! The plain drop is the one that plans are made for: rotors whose thrust knows no inflow, a prescribed
//! canopy, a steady wind. What else pushes on the vehicle is named by a key, and may be left out again to see
//! what it does.

use std::sync::Arc;

use super::Mission;
use samara_core::model::parachute::TipOff;
use samara_core::model::{Rotor, Vehicle};
use samara_core::sim::FaultKind;

/// Something beside the plain drop that a mission or its vehicle names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// Wind that differs from trial to trial.
    RandomWind,
    /// Mean wind that changes with the altitude.
    WindByAltitude,
    /// Discrete gusts.
    Gusts,
    /// Continuous turbulence.
    Turbulence,
    /// Thrusts that fluctuate in the vortex ring.
    RingFluctuation,
    /// A canopy that is a body of its own.
    Canopy,
    /// What the cut gives the vehicle.
    TipOff,
    /// Rotors whose thrust and torque depend on the flow through them.
    RotorInflow,
    /// Rotors that are free before t = 0 or have to be started; wants their inflow.
    RotorStart,
    /// A battery with a voltage.
    Battery,
    /// What fails.
    Faults,
    /// Numbers that are off what the files say.
    Uncertain,
}

impl Effect {
    /// Every effect, in the order in which they are reported.
    pub const ALL: [Self; 12] = [
        Self::RandomWind,
        Self::WindByAltitude,
        Self::Gusts,
        Self::Turbulence,
        Self::RingFluctuation,
        Self::Canopy,
        Self::TipOff,
        Self::RotorInflow,
        Self::RotorStart,
        Self::Battery,
        Self::Faults,
        Self::Uncertain,
    ];

    /// The key of the mission or the vehicle that names it.
    pub fn key(self) -> &'static str {
        match self {
            Self::RandomWind => "monte_carlo.wind_sigma_m_s",
            Self::WindByAltitude => "wind.by_altitude",
            Self::Gusts => "wind.gusts",
            Self::Turbulence => "wind.turbulence",
            Self::RingFluctuation => "vortex_ring",
            Self::Canopy => "parachute.canopy",
            Self::TipOff => "release.tip_off, monte_carlo.tip_off",
            Self::RotorInflow => "rotor (vehicle)",
            Self::RotorStart => "rotor_start (vehicle)",
            Self::Battery => "battery.electric",
            Self::Faults => "faults",
            Self::Uncertain => "uncertain",
        }
    }

    /// A name in a word or two.
    pub fn name(self) -> &'static str {
        match self {
            Self::RandomWind => "random wind",
            Self::WindByAltitude => "wind by altitude",
            Self::Gusts => "gusts",
            Self::Turbulence => "turbulence",
            Self::RingFluctuation => "ring fluctuation",
            Self::Canopy => "canopy as a body",
            Self::TipOff => "tip-off",
            Self::RotorInflow => "rotor inflow",
            Self::RotorStart => "rotor start",
            Self::Battery => "battery",
            Self::Faults => "faults",
            Self::Uncertain => "what is uncertain",
        }
    }

    /// What stands in its place where it is left out.
    pub fn instead(self) -> &'static str {
        match self {
            Self::RandomWind => "the site's mean wind in each trial",
            Self::WindByAltitude => "the mean wind of the release's altitude everywhere",
            Self::Gusts | Self::Turbulence => "none",
            Self::RingFluctuation => "mean thrusts in the vortex ring",
            Self::Canopy => {
                "the prescribed canopy, (40)-(43), whose force ends at the release, no riser hung up"
            }
            Self::TipOff => "a clean cut",
            Self::RotorInflow => "thrust k omega^2 and its torque, k from full throttle in still air",
            Self::RotorStart => "rotors at rest until t = 0 that are driven at once",
            Self::Battery => "a stiff supply of the motors' own voltage and limits",
            Self::Faults => "none",
            Self::Uncertain => "vehicle, air and delays as the files have them",
        }
    }

    /// The effect without which this one does nothing.
    pub fn needs(self) -> Option<Self> {
        match self {
            Self::RingFluctuation | Self::RotorStart => Some(Self::RotorInflow),
            _ => None,
        }
    }

    fn is_in(self, mission: &Mission) -> bool {
        let (release, random) = (&mission.release, &mission.study.monte_carlo);
        match self {
            Self::RandomWind => random.wind_sigma_m_s > 0.0,
            Self::WindByAltitude => mission.site.wind.profile.is_some(),
            Self::Gusts => !mission.site.wind.gusts.is_empty(),
            Self::Turbulence => mission.site.wind.turbulence.is_some(),
            Self::RingFluctuation => mission.site.wind.ring.is_some(),
            Self::Canopy => release.parachute.suspension.is_some(),
            Self::TipOff => !release.parachute.tip_off.is_none() || !random.tip_off_sigma.is_none(),
            Self::RotorInflow => mission.vehicle.rotor.knows_inflow(),
            Self::RotorStart => mission.vehicle.start.is_some(),
            Self::Battery => mission.electric.is_some(),
            Self::Faults => !mission.faults.list.is_empty(),
            Self::Uncertain => mission.uncertain.as_ref().is_some_and(|uncertain| !uncertain.is_none()),
        }
    }

    fn leave_out(self, mission: &mut Mission) {
        match self {
            Self::RandomWind => mission.study.monte_carlo.wind_sigma_m_s = 0.0,
            Self::WindByAltitude => mission.site.wind.profile = None,
            Self::Gusts => mission.site.wind.gusts.clear(),
            Self::Turbulence => mission.site.wind.turbulence = None,
            Self::RingFluctuation => mission.site.wind.ring = None,
            Self::Canopy => {
                mission.release.parachute.suspension = None;
                // What hangs up is one leg of that canopy's bridle.
                mission.faults.list.retain(|fault| !matches!(fault.kind, FaultKind::RiserHungUp { .. }));
            }
            Self::TipOff => {
                mission.release.parachute.tip_off = TipOff::default();
                mission.study.monte_carlo.tip_off_sigma = TipOff::default();
            }
            Self::RotorInflow => {
                let density_kg_m3 = mission.site.environment.density_kg_m3;
                mission.vehicle = Arc::new(without_inflow(&mission.vehicle, density_kg_m3));
            }
            Self::RotorStart => Arc::make_mut(&mut mission.vehicle).start = None,
            Self::Battery => mission.electric = None,
            Self::Faults => mission.faults.list.clear(),
            Self::Uncertain => mission.uncertain = None,
        }
    }
}

/// The vehicle with rotors of the same thrust and torque at full throttle in still air, at any flow; without
/// a start, since the air does not turn such rotors.
fn without_inflow(vehicle: &Vehicle, density_kg_m3: f64) -> Vehicle {
    let omega_max = vehicle.motor.omega_max_rad_s();
    let rotor = Rotor::Quadratic {
        thrust_n_per_rad2_s2: vehicle.static_thrust_n(density_kg_m3) / (omega_max * omega_max),
        torque_per_thrust_m: vehicle.torque_per_thrust_m(density_kg_m3),
        drag_n_s2_per_rad_m: 0.0,
        density_kg_m3,
    };
    Vehicle { rotor, start: None, ..vehicle.clone() }
}

impl Mission {
    /// The effects that the mission and its vehicle name, in the order of [`Effect::ALL`].
    pub fn effects(&self) -> Vec<Effect> {
        Effect::ALL.into_iter().filter(|effect| effect.is_in(self)).collect()
    }

    /// The mission with these of its effects alone. Name, seed, plan settings and hash of the inputs stay.
    pub fn with_effects(&self, kept: &[Effect]) -> Self {
        let mut mission = self.clone();
        let left_out = Effect::ALL.into_iter().filter(|effect| !kept.contains(effect));
        left_out.for_each(|effect| effect.leave_out(&mut mission));
        mission
    }
}
