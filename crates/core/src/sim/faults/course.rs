//! The faults of a flight in time.
//!
//! A fault is in force from the first end of a simulation step at or after its beginning, and likewise over
//! at its end: steps are not split. A unit has one fault at a time; one that begins ends the one before it.

use nalgebra::Vector3;

use super::{Fault, FaultKind, FaultOrder, FaultUnit, MotorFault, Sensor, SensorFault};
use crate::math;
use crate::model::{MAX_ROTORS, MotorCondition, PerRotor};

/// A time closer than this to another [s] is that other.
const TOLERANCE_S: f64 = 1e-9;
/// Most faults that are ordered in one flight: a flood of orders shall not fill the memory.
pub const MOST_ORDERS: usize = 1000;

/// A fault that has been in force, in times since the simulation began.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaultSpan {
    /// What failed.
    pub kind: FaultKind,
    /// Beginning [s].
    pub from_s: f64,
    /// End [s]; `None`: it has not ended.
    pub until_s: Option<f64>,
    /// Whether it was ordered in flight.
    pub ordered: bool,
}

/// Beginning or end of a fault.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaultChange {
    /// Time since the simulation began [s].
    pub at_s: f64,
    /// What fails.
    pub kind: FaultKind,
    /// Whether it begins; else it ends.
    pub begins: bool,
}

/// A fault that is in force.
#[derive(Clone, Copy, Debug)]
struct Active {
    kind: FaultKind,
    since_s: f64,
    until_s: Option<f64>,
    /// Place of its span.
    span: usize,
    /// Whether its rotor turned when it began.
    turned: bool,
}

/// The faults of a flight: those to come, those in force, those that have been.
#[derive(Clone, Debug, Default)]
pub struct FaultCourse {
    /// Those to come, in times since the simulation began, the next one first.
    due: Vec<Fault>,
    next: usize,
    active: Vec<Active>,
    spans: Vec<FaultSpan>,
    changes: Vec<FaultChange>,
    orders: usize,
    /// Conditions of the motors; `None`: all are sound.
    motors: Option<[MotorCondition; MAX_ROTORS]>,
    /// Commands as motors that follow late have them.
    lagging: PerRotor,
}

impl FaultCourse {
    /// Faults whose times count from `t0_s` [s] since the simulation began.
    pub fn new(faults: &[Fault], t0_s: f64) -> Self {
        let shifted = |fault: &Fault| Fault {
            at_s: t0_s + fault.at_s,
            until_s: fault.until_s.map(|until_s| t0_s + until_s),
            ..*fault
        };
        let mut due: Vec<Fault> = faults.iter().map(shifted).collect();
        due.sort_by(|a, b| a.at_s.total_cmp(&b.at_s));
        Self { due, ..Self::default() }
    }

    /// Faults that have begun, in order of time.
    pub fn spans(&self) -> &[FaultSpan] {
        &self.spans
    }

    /// Beginnings and ends so far, in order of time.
    pub fn changes(&self) -> &[FaultChange] {
        &self.changes
    }

    /// Conditions of the motors now; `None`: all are sound.
    pub fn motors(&self) -> Option<[MotorCondition; MAX_ROTORS]> {
        self.motors
    }

    /// Whether nothing is heard of the companion that streams setpoints.
    pub fn mutes_setpoints(&self) -> bool {
        self.of(FaultUnit::Setpoints).is_some()
    }

    /// Whether the parachute's component sends no HEARTBEAT.
    pub fn silences_parachute(&self) -> bool {
        self.of(FaultUnit::ParachuteHeartbeat).is_some()
    }

    /// Where a leg of the bridle is fixed that does not come free, from the centre of mass, body axes [m].
    pub fn hung_up_at(&self) -> Option<Vector3<f64>> {
        match self.of(FaultUnit::Riser)?.kind {
            FaultKind::RiserHungUp { attachment_body_m } => Some(attachment_body_m),
            _ => None,
        }
    }

    /// The fault of a sensor that is in force, and since when [s].
    pub fn of_sensor(&self, sensor: Sensor) -> Option<(SensorFault, f64)> {
        let active = self.of(FaultUnit::Sensor(sensor))?;
        match active.kind {
            FaultKind::Sensor { fault, .. } => Some((fault, active.since_s)),
            _ => None,
        }
    }

    fn of(&self, unit: FaultUnit) -> Option<&Active> {
        self.active.iter().find(|active| active.kind.unit() == unit)
    }

    /// When a parachute that is asked to let go at `asked_s` does so, as far as is known now, in times since
    /// the simulation began [s]; `None`: never.
    pub fn lets_go_at(&self, asked_s: f64) -> Option<f64> {
        let (mut at_s, mut late) = (asked_s, false);
        // Each turn goes past a fault.
        for _ in 0..=self.spans.len() + self.due.len() + 1 {
            match self.of_parachute_at(at_s) {
                Some((FaultKind::ParachuteHolds, until_s)) => at_s = until_s?,
                Some((FaultKind::LateRelease { delay_s }, _)) if !late => {
                    at_s += delay_s;
                    late = true;
                }
                _ => return Some(at_s),
            }
        }
        None
    }

    /// The parachute's fault at a time, past or to come, and its end.
    fn of_parachute_at(&self, t_s: f64) -> Option<(FaultKind, Option<f64>)> {
        let planned = |place: usize| self.active.iter().find(|a| a.span == place).and_then(|a| a.until_s);
        let begun = self.spans.iter().enumerate().map(|(place, span)| {
            let FaultSpan { kind, from_s, until_s, .. } = *span;
            (kind, from_s, until_s.or_else(|| planned(place)))
        });
        let coming = self.due[self.next..].iter().map(|fault| (fault.kind, fault.at_s, fault.until_s));
        let of_parachute = begun.chain(coming).filter(|(kind, ..)| kind.unit() == FaultUnit::Parachute);
        // One that begins ends the one before it.
        let mut found = None;
        for (kind, from_s, until_s) in of_parachute {
            if from_s <= t_s + TOLERANCE_S {
                found = Some((kind, until_s));
            } else {
                let end_s = |until_s: Option<f64>| until_s.map_or(from_s, |until_s| until_s.min(from_s));
                found = found.map(|(kind, until_s)| (kind, Some(end_s(until_s))));
                break;
            }
        }
        found.filter(|(_, until_s)| !until_s.is_some_and(|until_s| until_s <= t_s + TOLERANCE_S))
    }

    /// Goes on to `now_s` [s] since the simulation began, with the rotors at these speeds [rad/s].
    pub fn advance(&mut self, now_s: f64, rotor_speed: &PerRotor) {
        let over = |until_s: f64| until_s <= now_s + TOLERANCE_S;
        let before = self.changes.len();
        while let Some(i) = self.active.iter().position(|active| active.until_s.is_some_and(over)) {
            self.end(i, now_s);
        }
        while let Some(fault) = self.due.get(self.next).copied().filter(|f| f.at_s <= now_s + TOLERANCE_S) {
            self.next += 1;
            if !fault.until_s.is_some_and(over) {
                self.begin(fault.kind, now_s, fault.until_s, false, rotor_speed);
            }
        }
        if self.changes.len() > before {
            self.set_motors();
        }
    }

    /// Takes an order that is given at `now_s` [s] since the simulation began; whether it is obeyed, which it
    /// is not after [`MOST_ORDERS`] others.
    pub fn order(&mut self, order: FaultOrder, now_s: f64, rotor_speed: &PerRotor) -> bool {
        let unit = match &order {
            FaultOrder::Begin(kind) => kind.unit(),
            FaultOrder::End(unit) => *unit,
        };
        let there = self.active.iter().position(|active| active.kind.unit() == unit);
        match (order, there) {
            (FaultOrder::End(_), None) => return true,
            (FaultOrder::Begin(kind), Some(i))
                if self.active[i].kind == kind && self.active[i].until_s.is_none() =>
            {
                return true;
            }
            _ => {}
        }
        if self.orders >= MOST_ORDERS {
            return false;
        }
        self.orders += 1;
        match (order, there) {
            (FaultOrder::Begin(kind), _) => self.begin(kind, now_s, None, true, rotor_speed),
            (FaultOrder::End(_), Some(i)) => self.end(i, now_s),
            (FaultOrder::End(_), None) => {}
        }
        self.set_motors();
        true
    }

    fn begin(
        &mut self,
        kind: FaultKind,
        now_s: f64,
        until_s: Option<f64>,
        ordered: bool,
        rotor_speed: &PerRotor,
    ) {
        if let Some(i) = self.active.iter().position(|active| active.kind.unit() == kind.unit()) {
            self.end(i, now_s);
        }
        let turned = match kind {
            FaultKind::Motor { rotor, .. } => {
                rotor_speed.get(rotor.wrapping_sub(1)).is_some_and(|w| *w > 0.0)
            }
            _ => false,
        };
        self.active.push(Active { kind, since_s: now_s, until_s, span: self.spans.len(), turned });
        self.spans.push(FaultSpan { kind, from_s: now_s, until_s: None, ordered });
        self.changes.push(FaultChange { at_s: now_s, kind, begins: true });
    }

    fn end(&mut self, i: usize, now_s: f64) {
        let Active { kind, span, .. } = self.active.remove(i);
        self.spans[span].until_s = Some(now_s);
        self.changes.push(FaultChange { at_s: now_s, kind, begins: false });
    }

    /// Works out the conditions of the motors.
    fn set_motors(&mut self) {
        let mut motors = [MotorCondition::Sound; MAX_ROTORS];
        for active in &self.active {
            if let FaultKind::Motor { rotor, fault } = active.kind
                && let Some(motor) = motors.get_mut(rotor.wrapping_sub(1))
            {
                *motor = match fault {
                    MotorFault::Off => MotorCondition::Unpowered,
                    MotorFault::Stuck => MotorCondition::Held,
                    MotorFault::NoStart if !active.turned => MotorCondition::Unpowered,
                    MotorFault::NoStart | MotorFault::Slow { .. } | MotorFault::Weak { .. } => {
                        MotorCondition::Sound
                    }
                };
            }
        }
        self.motors = motors.iter().any(|motor| *motor != MotorCondition::Sound).then_some(motors);
    }

    /// The commands that come to the motors of those that are given, 0..1, now.
    pub fn commands(&self, throttle: &PerRotor) -> PerRotor {
        let mut commands = *throttle;
        for active in &self.active {
            if let FaultKind::Motor { rotor, fault } = active.kind
                && let Some(command) = commands.get_mut(rotor.wrapping_sub(1))
            {
                match fault {
                    MotorFault::Weak { factor } => *command *= factor,
                    MotorFault::Slow { .. } => *command = self.lagging[rotor - 1],
                    MotorFault::Off | MotorFault::Stuck | MotorFault::NoStart => {}
                }
            }
        }
        commands
    }

    /// The commands that come to the motors in a step of `dt_s` [s] of those that are given, 0..1: a late
    /// motor's goes towards the given one by `1 - exp(-dt/lag)` of the difference, held within the step.
    pub fn step_commands(&mut self, throttle: &PerRotor, dt_s: f64) -> PerRotor {
        for (i, lagging) in self.lagging.iter_mut().enumerate() {
            let slow = self.active.iter().find_map(|active| match active.kind {
                FaultKind::Motor { rotor, fault: MotorFault::Slow { lag_s } } if rotor == i + 1 => {
                    Some(lag_s)
                }
                _ => None,
            });
            // Before the fault the command is followed at once.
            let share = slow.map_or(1.0, |lag_s| 1.0 - math::exp(-dt_s / lag_s));
            *lagging += share * (throttle[i] - *lagging);
        }
        self.commands(throttle)
    }
}
