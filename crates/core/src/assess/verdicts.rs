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
    fn take_abreast(&mut self, first: usize, count: usize, samples: &crate::sim::many::Samples<'_>) -> bool {
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
    use nalgebra::Vector3;

    use super::super::safety::VerdictBuilder;
    use super::super::watched::{Sight, Watched};
    use crate::model::rigid_body::{BodyState, Motion};
    use crate::real::Real as _;
    use crate::sim::Phase;
    use crate::sim::limits::SafetyLimits;
    use crate::sim::many::Samples;
    use crate::simd::lanes::{LANES, Lanes};
    use crate::simd::{Kernel, vectorised};
    use crate::vector::V3;

    /// What has been seen of flights side by side.
    #[derive(Debug)]
    pub struct Group {
        first: usize,
        count: usize,
        watched: Watched<Lanes>,
        /// Positions, NED [m], and motions at the last sample, and its time of powered flight [s].
        last: Option<(V3<Lanes>, Motion<Lanes>)>,
        last_powered_s: Option<f64>,
        /// Positions at the last sample up to the plan's end, NED [m].
        plan_end_p_ned: Option<V3<Lanes>>,
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
            let mut watched = vectorised(Nothing(samples.a_ned.x));
            for i in 0..LANES {
                set(&mut watched, i, &all[i.min(count - 1)].watched);
            }
            let (last, last_powered_s, plan_end_p_ned) = (None, None, None);
            Some(Self { first, count, watched, last, last_powered_s, plan_end_p_ned, in_plan: 0 })
        }

        /// Whether it is of so many flights from a number on.
        pub fn is_of(&self, first: usize, count: usize) -> bool {
            (self.first, self.count) == (first, count)
        }

        /// Sees the next samples; whether it does: what touches the ground is looked at one by one.
        pub fn see(&mut self, builders: &mut [VerdictBuilder], samples: &Samples<'_>) -> bool {
            let Some(all) = builders.get_mut(self.first..self.first + self.count) else { return false };
            let touches = samples.ground_down_n.as_array().iter().any(|force| *force < 0.0);
            if touches || all.iter().any(VerdictBuilder::is_at_the_ground) {
                return false;
            }
            let body_of = |i: usize| body(samples.craft.p_ned, &samples.craft.motion, i);
            for (i, builder) in all.iter_mut().enumerate() {
                if builder.is_to_begin(samples.phase) {
                    builder.begin(samples.t_s, samples.phase, &body_of(i));
                }
            }
            let builder = &all[0];
            let plan_v_ned = builder.plan_v_ned(samples.t_powered_s);
            let powered_s = samples.t_powered_s.filter(|_| samples.phase == Phase::Powered);
            vectorised(See {
                watched: &mut self.watched,
                samples,
                powered_s,
                plan_v_ned,
                limits: &builder.limits().safety,
                v_cmd_ned: builder.v_cmd_ned(),
                within_m_s: builder.limits().steady_within_m_s,
            });
            self.in_plan += u32::from(plan_v_ned.is_some());
            if builder.is_up_to_plans_end(samples.t_powered_s) {
                self.plan_end_p_ned = Some(samples.craft.p_ned);
            }
            self.last = Some((samples.craft.p_ned, samples.craft.motion));
            self.last_powered_s = samples.t_powered_s.or(self.last_powered_s);
            true
        }

        /// Tells the builders what has been seen.
        pub fn tell(&self, builders: &mut [VerdictBuilder]) {
            for (i, builder) in builders[self.first..].iter_mut().enumerate().take(self.count) {
                builder.watched = get(&self.watched, i);
                builder.in_plan += self.in_plan;
                if let Some(p_ned) = self.plan_end_p_ned {
                    builder.plan_end_p_ned = vector(&p_ned, i);
                }
                if let Some((p_ned, motion)) = &self.last {
                    builder.last = Some(body(*p_ned, motion, i));
                }
                builder.last_powered_s = self.last_powered_s.unwrap_or(builder.last_powered_s);
            }
        }
    }

    struct Nothing(Lanes);

    impl Kernel for Nothing {
        type Output = Watched<Lanes>;

        #[inline(always)]
        fn run(self) -> Watched<Lanes> {
            Watched::nothing(self.0)
        }
    }

    struct See<'a> {
        watched: &'a mut Watched<Lanes>,
        samples: &'a Samples<'a>,
        powered_s: Option<f64>,
        plan_v_ned: Option<Vector3<f64>>,
        limits: &'a SafetyLimits,
        v_cmd_ned: Vector3<f64>,
        within_m_s: f64,
    }

    impl Kernel for See<'_> {
        type Output = ();

        #[inline(always)]
        fn run(self) {
            let Self { watched, samples, powered_s, plan_v_ned, limits, v_cmd_ned, within_m_s } = self;
            let craft = samples.craft;
            let zero = craft.p_ned.x.of(0.0);
            let mut turned = zero;
            for (turned, over) in turned.as_array_mut().iter_mut().zip(samples.turned_over) {
                *turned = f64::from(u8::from(over));
            }
            let now = Sight {
                motion: &craft.motion,
                turned_over: zero.less(turned),
                over: zero.less(zero),
                a_down_m_s2: samples.a_ned.z,
                canopy_m: match samples.canopy_p_ned {
                    Some(canopy_p_ned) => Some((canopy_p_ned - craft.p_ned).norm()),
                    None => None,
                },
                powered_s,
                plan_v_ned: match plan_v_ned {
                    Some(plan_v_ned) => Some(V3::constant(zero, &plan_v_ned)),
                    None => None,
                },
            };
            watched.see(&now, limits, V3::constant(zero, &v_cmd_ned), within_m_s);
        }
    }

    fn vector(vector: &V3<Lanes>, i: usize) -> Vector3<f64> {
        Vector3::new(vector.x.as_array()[i], vector.y.as_array()[i], vector.z.as_array()[i])
    }

    fn body(p_ned: V3<Lanes>, motion: &Motion<Lanes>, i: usize) -> BodyState {
        BodyState {
            p_ned: vector(&p_ned, i),
            q_ned_from_body: motion.q_ned_from_body.map(|q| q.as_array()[i]),
            v_ned: vector(&motion.v_ned, i),
            omega_body: vector(&motion.omega_body, i),
        }
    }

    fn get(all: &Watched<Lanes>, i: usize) -> Watched<f64> {
        let of = |number: Lanes| number.as_array()[i];
        Watched {
            cost: all.cost.map(of),
            infinite: all.infinite.lane(i),
            peaks: all.peaks.map(of),
            tilt_rad: of(all.tilt_rad),
            a_down_m_s2: of(all.a_down_m_s2),
            canopy_m: of(all.canopy_m),
            steady_from_s: of(all.steady_from_s),
            distance2: of(all.distance2),
        }
    }

    fn set(all: &mut Watched<Lanes>, i: usize, one: &Watched<f64>) {
        let numbers = all.cost.iter_mut().chain(&mut all.peaks).zip(one.cost.iter().chain(&one.peaks));
        numbers.for_each(|(number, now)| number.as_array_mut()[i] = *now);
        for (number, now) in [
            (&mut all.tilt_rad, one.tilt_rad),
            (&mut all.a_down_m_s2, one.a_down_m_s2),
            (&mut all.canopy_m, one.canopy_m),
            (&mut all.steady_from_s, one.steady_from_s),
            (&mut all.distance2, one.distance2),
        ] {
            number.as_array_mut()[i] = now;
        }
        all.infinite.set_lane(i, one.infinite);
    }
}
