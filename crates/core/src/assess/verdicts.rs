//! Verdicts on flights that are flown many at once: each the same as [`VerdictBuilder`] makes of the flight
//! alone, whose peaks are looked for eight side by side where they fly so.

use std::ops::ControlFlow;

use super::safety::{Verdict, VerdictBuilder};
use crate::sim::{Phase, Sample, Watch};

/// Verdicts on flights, by their number from 0.
#[derive(Debug)]
pub struct Verdicts {
    builders: Vec<VerdictBuilder>,
    #[cfg(target_arch = "x86_64")]
    group: Option<Box<abreast::Group>>,
}

impl Verdicts {
    /// Verdicts by these builders, which have not seen anything.
    pub fn by(builders: Vec<VerdictBuilder>) -> Self {
        Self {
            builders,
            #[cfg(target_arch = "x86_64")]
            group: None,
        }
    }

    /// The verdicts; `None` where nothing was observed from the release on.
    pub fn finish(mut self) -> Vec<Option<Verdict>> {
        self.leave();
        self.builders.into_iter().map(VerdictBuilder::finish).collect()
    }

    /// Tells each builder what has been seen side by side.
    fn leave(&mut self) {
        #[cfg(target_arch = "x86_64")]
        if let Some(group) = self.group.take() {
            group.tell(&mut self.builders);
        }
    }
}

impl Watch for Verdicts {
    fn take(&mut self, flight: usize, sample: &Sample) -> ControlFlow<()> {
        self.leave();
        self.builders[flight].observe(sample);
        ControlFlow::Continue(())
    }

    fn looks_at(&self, phase: Phase) -> bool {
        phase != Phase::Hanging
    }

    #[cfg(target_arch = "x86_64")]
    fn take_abreast(&mut self, first: usize, count: usize, samples: &crate::sim::watch::Samples<'_>) -> bool {
        if self.group.as_ref().is_none_or(|group| !group.is_of(first, count)) {
            self.leave();
            self.group = abreast::Group::begin(&self.builders, first, count, samples).map(Box::new);
        }
        let sees = self.group.as_mut().is_some_and(|group| group.see(&mut self.builders, samples));
        if !sees {
            self.leave();
        }
        sees
    }
}

#[cfg(target_arch = "x86_64")]
mod abreast {
    use super::super::beside::{Beside, Look, body};
    use super::super::safety::VerdictBuilder;
    use crate::sim::Phase;
    use crate::sim::watch::Samples;

    /// What has been seen of flights side by side.
    #[derive(Debug)]
    pub struct Group {
        beside: Beside,
        /// Time of powered flight of the last sample [s].
        last_powered_s: Option<f64>,
        /// How many samples were in the plan's time.
        in_plan: u32,
    }

    impl Group {
        /// Flights that have been seen so far by these builders; `None` where they judge by something else
        /// than peaks, or not alike.
        pub fn begin(
            builders: &[VerdictBuilder],
            first: usize,
            count: usize,
            samples: &Samples<'_>,
        ) -> Option<Self> {
            let all = builders.get(first..first + count)?;
            if !all.iter().all(|builder| builder.watches_as(&all[0])) {
                return None;
            }
            let seen = all.iter().map(|builder| &builder.seen);
            Some(Self {
                beside: Beside::begin(first, seen, samples.a_ned.x),
                last_powered_s: None,
                in_plan: 0,
            })
        }

        /// Whether it is of so many flights from a number on.
        pub fn is_of(&self, first: usize, count: usize) -> bool {
            self.beside.is_of(first, count)
        }

        /// Sees the next samples; whether it does: what touches the ground is looked at one by one.
        pub fn see(&mut self, builders: &mut [VerdictBuilder], samples: &Samples<'_>) -> bool {
            let Some(all) = builders.get_mut(self.beside.flights()) else { return false };
            let touches = samples.ground_down_n.as_array().iter().any(|force| *force < 0.0);
            if touches || all.iter().any(VerdictBuilder::is_at_the_ground) {
                return false;
            }
            for (i, builder) in all.iter_mut().enumerate() {
                if builder.is_to_begin(samples.phase) {
                    let body = body(&samples.craft.p_ned, &samples.craft.motion, i);
                    builder.begin(samples.t_s, samples.phase, &body);
                }
            }
            let (builder, t_powered_s) = (&all[0], samples.t_powered_s);
            let look = Look {
                limits: &builder.limits().safety,
                v_cmd_ned: builder.v_cmd_ned(),
                within_m_s: builder.limits().steady_within_m_s,
                steady_at_s: t_powered_s.filter(|_| samples.phase == Phase::Powered),
                plan_v_ned: builder.plan_v_ned(t_powered_s),
                keeps_place: builder.is_up_to_plans_end(t_powered_s),
            };
            self.beside.see(samples, &look);
            self.in_plan += u32::from(look.plan_v_ned.is_some());
            self.last_powered_s = t_powered_s.or(self.last_powered_s);
            true
        }

        /// Tells the builders what has been seen.
        pub fn tell(&self, builders: &mut [VerdictBuilder]) {
            let beside = &self.beside;
            for (i, builder) in builders[beside.flights()].iter_mut().enumerate() {
                builder.seen = beside.seen(i);
                builder.in_plan += self.in_plan;
                builder.plan_end_p_ned = beside.kept_p_ned(i).unwrap_or(builder.plan_end_p_ned);
                builder.last = beside.last(i).or(builder.last);
                builder.last_powered_s = self.last_powered_s.unwrap_or(builder.last_powered_s);
            }
        }
    }
}
