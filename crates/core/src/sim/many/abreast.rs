//! Eight flights side by side: who flies them, and what is asked of them.

use std::ops::ControlFlow;

use nalgebra::Vector3;

use super::super::drop::abreast::Abreast;
use super::super::flight::measured;
use super::super::integrator::Craft;
use super::super::watch::{ABREAST, Flight, Watch};
use crate::control::AsCascade;
use crate::control::loops::{Cascades, finite};
use crate::control::velocity::VelocitySetpoint;
use crate::frames::yaw;
use crate::model::{MAX_ROTORS, PerRotor};
use crate::real::Real as _;
use crate::simd::lanes::{LANES, Lanes};
use crate::simd::{Kernel, vectorised};
use crate::vector::V3;

const _: () = assert!(LANES == ABREAST);

/// Fewer flights than this are flown one by one: eight side by side take as long as so many.
const LEAST: usize = 3;

/// Velocity [m/s] and fed-forward acceleration [m/s^2], NED, that are asked for.
type Velocity = Option<(Vector3<f64>, Vector3<f64>)>;

/// What is asked of eight flights.
#[derive(Clone, Debug)]
enum Asked {
    /// One thing of all.
    All(Velocity),
    /// Something of its own of each.
    Each(Box<[Velocity; LANES]>),
}

impl Asked {
    /// What is asked of one flight (from 0).
    fn of(&self, i: usize) -> Velocity {
        match self {
            Self::All(velocity) => *velocity,
            Self::Each(velocities) => velocities[i],
        }
    }

    /// The velocity that is asked of one flight, NED [m/s].
    fn v_ned(&self, i: usize) -> Option<Vector3<f64>> {
        self.of(i).map(|(v_ned, _)| v_ned)
    }
}

/// Eight flights side by side.
struct Group<'a> {
    flights: Vec<Flight<'a>>,
    abreast: Abreast,
    pilots: Pilots,
    /// Whether the same is asked of all at all times.
    is_along_one: bool,
    /// Commands as they were given.
    throttle: [Lanes; MAX_ROTORS],
}

/// What flies the vehicles.
enum Pilots {
    /// Cascades side by side.
    Cascades(Box<Heading>),
    /// Each flight's controller.
    Each,
}

/// Cascades with the headings that they hold.
struct Heading {
    cascades: Cascades<Lanes>,
    /// Headings [rad], and whose are known.
    yaw_rad: Lanes,
    known: [bool; LANES],
    /// The last setpoint that was finite.
    setpoint: Option<VelocitySetpoint<Lanes>>,
    /// What was asked of all when that was made.
    asked: Velocity,
}

/// Flies a group of flights, the first of the number `begin`; gives them back where it does not.
pub(super) fn fly<'a>(mut flights: Vec<Flight<'a>>, begin: usize, watch: &mut impl Watch) -> Vec<Flight<'a>> {
    let count = flights.len();
    let in_step = |flight: &Flight<'_>| (flight.plan.control_period_s, flight.plan.steps());
    let alone =
        |flight: &Flight<'_>| flight.controller.is_shared() || in_step(flight) != in_step(&flights[0]);
    if count < LEAST || flights.iter().any(alone) {
        return flights;
    }
    // Lanes that are left over fly the first flight, which nobody looks at.
    while flights.len() < LANES {
        flights.push(flights[0].clone());
    }
    let drops = flights.iter().map(|flight| flight.simulation.clone()).collect();
    let Ok(abreast) = Abreast::of(drops) else {
        flights.truncate(count);
        return flights;
    };
    flights.iter_mut().for_each(|flight| flight.controller.reset());
    let (period_s, steps) = in_step(&flights[0]);
    let mut group = Group {
        pilots: Pilots::of(&flights, abreast.zero()),
        is_along_one: flights.iter().all(|flight| flight.plan.asks_as(&flights[0].plan)),
        throttle: [abreast.zero(); MAX_ROTORS],
        flights,
        abreast,
    };
    let mut goes_on: [bool; LANES] = std::array::from_fn(|i| i < count);
    for _ in 0..steps {
        let asked = group.asked();
        group.command(&asked, period_s);
        let unseen = group.abreast.common().is_some_and(|(_, _, phase)| !watch.looks_at(phase));
        if unseen {
            group.abreast.step_unseen(&group.throttle, period_s);
            continue;
        }
        let before = group.abreast.before();
        group.abreast.step(&group.throttle, period_s);
        let samples = group.abreast.samples(&before);
        if samples.is_some_and(|samples| watch.take_abreast(begin, count, &samples)) {
            continue;
        }
        for (i, goes_on) in goes_on.iter_mut().enumerate().filter(|(_, goes_on)| **goes_on) {
            let sample = group.abreast.sample(&before, i, &group.commands(i), asked.v_ned(i));
            *goes_on = watch.take(begin + i, &sample).is_continue();
        }
        if !goes_on.contains(&true) {
            return Vec::new();
        }
    }
    let asked = group.asked();
    for (i, _) in goes_on.into_iter().enumerate().filter(|(_, goes_on)| *goes_on) {
        let commands = group.commands(i);
        let sample = group.abreast.drops()[i].sample(&commands, asked.v_ned(i));
        let _: ControlFlow<()> = watch.take(begin + i, &sample);
    }
    Vec::new()
}

impl Group<'_> {
    /// What is asked of each flight now.
    fn asked(&mut self) -> Asked {
        if self.is_along_one
            && let Some((_, t_powered_s, phase)) = self.abreast.common()
        {
            return Asked::All(self.flights[0].plan.velocity_at(t_powered_s, phase));
        }
        let drops = self.abreast.drops();
        Asked::Each(Box::new(std::array::from_fn(|i| {
            self.flights[i].plan.velocity_at(drops[i].time_powered_s(), drops[i].phase())
        })))
    }

    /// The commands of one flight (from 0).
    fn commands(&self, i: usize) -> PerRotor {
        std::array::from_fn(|rotor| self.throttle[rotor].as_array()[i])
    }

    /// Commands the motors for a control period [s].
    fn command(&mut self, asked: &Asked, period_s: f64) {
        match &mut self.pilots {
            Pilots::Cascades(heading) => {
                let bus_v = self.abreast.bus_v();
                heading.steer((self.abreast.craft(), bus_v), &self.flights, asked, period_s);
                self.throttle = *heading.cascades.throttle();
            }
            Pilots::Each => {
                let drops = self.abreast.drops();
                for (i, flight) in self.flights.iter_mut().enumerate() {
                    let asked = flight.plan.asked(asked.of(i));
                    let measured = measured(&drops[i]);
                    let commands = flight.controller.step(&measured, &asked, period_s).throttle;
                    for (throttle, now) in self.throttle.iter_mut().zip(commands) {
                        throttle.as_array_mut()[i] = now;
                    }
                }
            }
        }
    }
}

impl Pilots {
    /// Those of flights whose controllers have been reset.
    fn of(flights: &[Flight<'_>], zero: Lanes) -> Self {
        let cascade_of = |flight: &Flight<'_>| {
            let AsCascade { settings, keeps_heading } = flight.controller.as_cascade()?;
            let headed = keeps_heading || flight.plan.yaw_sp_rad.is_some();
            headed.then(|| settings.clone())
        };
        let first = flights.first().and_then(cascade_of);
        match first {
            Some(settings) if flights.iter().all(|f| cascade_of(f).as_ref() == Some(&settings)) => {
                let (cascades, known) = (Cascades::new(settings, zero), [false; LANES]);
                let (setpoint, asked) = (None, None);
                Self::Cascades(Box::new(Heading { cascades, yaw_rad: zero, known, setpoint, asked }))
            }
            _ => Self::Each,
        }
    }
}

impl Heading {
    /// Steers vehicles to velocities for a control period [s], each at its heading: that which its plan asks
    /// for, or that at which it was first asked for a velocity.
    fn steer(
        &mut self,
        (craft, bus_v): (&Craft<Lanes>, Option<Lanes>),
        flights: &[Flight<'_>],
        asked: &Asked,
        period_s: f64,
    ) {
        let mut are_asked = [1.0; LANES];
        let setpoint = match (asked, &self.setpoint) {
            (Asked::All(all), Some(setpoint)) if *all == self.asked && all.is_some() => *setpoint,
            _ => self.take(craft, flights, asked, &mut are_asked),
        };
        let (cascades, yaw_rad) = (&mut self.cascades, self.yaw_rad);
        vectorised(Steer {
            cascades,
            craft,
            bus_v,
            setpoint: &setpoint,
            yaw_rad,
            asked: &are_asked,
            period_s,
        });
    }

    /// Takes what is asked, and of whom something is.
    fn take(
        &mut self,
        craft: &Craft<Lanes>,
        flights: &[Flight<'_>],
        asked: &Asked,
        are_asked: &mut [f64; LANES],
    ) -> VelocitySetpoint<Lanes> {
        let (mut v_ned, mut a_ff_ned) = match &self.setpoint {
            Some(setpoint) => (setpoint.v_ned, V3::zero(self.yaw_rad)),
            // With no finite setpoint yet: the velocity that there is.
            None => (craft.motion.v_ned, V3::zero(self.yaw_rad)),
        };
        for (i, is_asked) in are_asked.iter_mut().enumerate() {
            let Some((v, a)) = asked.of(i) else {
                *is_asked = 0.0;
                continue;
            };
            if !std::mem::replace(&mut self.known[i], true) {
                let now = craft.motion.q_ned_from_body.map(|q| q.as_array()[i]);
                let yaw_rad = flights[i].plan.yaw_sp_rad.unwrap_or_else(|| yaw(now));
                self.yaw_rad.as_array_mut()[i] = if finite(&[yaw_rad]) { yaw_rad } else { 0.0 };
            }
            for (vector, now) in [(&mut v_ned, v), (&mut a_ff_ned, a)] {
                if finite(now.as_slice()) {
                    vector.x.as_array_mut()[i] = now.x;
                    vector.y.as_array_mut()[i] = now.y;
                    vector.z.as_array_mut()[i] = now.z;
                }
            }
        }
        let setpoint = VelocitySetpoint { v_ned, a_ff_ned };
        if !are_asked.contains(&0.0) {
            self.setpoint = Some(setpoint);
            self.asked = if let Asked::All(all) = asked { *all } else { None };
        }
        setpoint
    }
}

/// A step of cascades.
struct Steer<'a> {
    cascades: &'a mut Cascades<Lanes>,
    craft: &'a Craft<Lanes>,
    bus_v: Option<Lanes>,
    setpoint: &'a VelocitySetpoint<Lanes>,
    yaw_rad: Lanes,
    asked: &'a [f64; LANES],
    period_s: f64,
}

impl Kernel for Steer<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { cascades, craft, bus_v, setpoint, yaw_rad, asked, period_s } = self;
        let mut number = yaw_rad;
        *number.as_array_mut() = *asked;
        let asked = number.of(0.5).less(number);
        cascades.step(asked, (&craft.motion, bus_v), setpoint, yaw_rad, period_s);
    }
}
