//! What is seen of flights side by side: [`Watched`] of eight at once.

use nalgebra::Vector3;

use super::steady::MeanVelocity;
use super::watched::{Seen, Sight, Watched};
use crate::model::rigid_body::{BodyState, Motion};
use crate::real::Real as _;
use crate::sim::limits::SafetyLimits;
use crate::sim::watch::Samples;
use crate::simd::lanes::Lanes;
use crate::simd::{Kernel, vectorised};
use crate::vector::V3;

/// What has been seen of flights side by side.
#[derive(Debug)]
pub(super) struct Beside {
    first: usize,
    count: usize,
    watched: Watched<Lanes>,
    /// Of each flight, where steady flight is told by the mean of its velocity.
    means: Vec<Option<MeanVelocity>>,
    /// Positions, NED [m], and motions at the last sample.
    last: Option<(V3<Lanes>, Motion<Lanes>)>,
    /// Positions at the last sample whose were to be kept, NED [m].
    kept_p_ned: Option<V3<Lanes>>,
}

/// How samples are looked at: the same for all flights.
#[derive(Clone, Copy, Debug)]
pub(super) struct Look<'a> {
    pub(super) limits: &'a SafetyLimits,
    /// Velocity that is to be reached, NED [m/s], and within how much of it is steady [m/s].
    pub(super) v_cmd_ned: Vector3<f64>,
    pub(super) within_m_s: f64,
    /// Time by which steadiness is counted [s], where it is.
    pub(super) steady_at_s: Option<f64>,
    /// The plan's velocity, NED [m/s], while there is one.
    pub(super) plan_v_ned: Option<Vector3<f64>>,
    /// Whether the position is kept.
    pub(super) keeps_place: bool,
}

impl Beside {
    /// Flights from a number on, of which so much has been seen; numbers are of the given one's kind.
    pub(super) fn begin<'a>(
        first: usize,
        seen: impl ExactSizeIterator<Item = &'a Seen>,
        kind: Lanes,
    ) -> Self {
        let (mut watched, count) = (vectorised(Nothing(kind)), seen.len());
        let mut means = Vec::with_capacity(count);
        for (i, one) in seen.enumerate() {
            set(&mut watched, i, &one.watched);
            means.push(one.mean.clone());
        }
        Self { first, count, watched, means, last: None, kept_p_ned: None }
    }

    /// Whether it is of so many flights from a number on.
    pub(super) fn is_of(&self, first: usize, count: usize) -> bool {
        (self.first, self.count) == (first, count)
    }

    /// The numbers of the flights.
    pub(super) fn flights(&self) -> std::ops::Range<usize> {
        self.first..self.first + self.count
    }

    /// Sees the next samples.
    pub(super) fn see(&mut self, samples: &Samples<'_>, look: &Look<'_>) {
        vectorised(See { watched: &mut self.watched, samples, look });
        for (i, mean) in self.means.iter_mut().enumerate() {
            if let Some(mean) = mean {
                mean.observe(look.steady_at_s, &vector(&samples.craft.motion.v_ned, i));
            }
        }
        if look.keeps_place {
            self.kept_p_ned = Some(samples.craft.p_ned);
        }
        self.last = Some((samples.craft.p_ned, samples.craft.motion));
    }

    /// What has been seen of a flight, by its place among them.
    pub(super) fn seen(&self, i: usize) -> Seen {
        let (all, of) = (&self.watched, |number: Lanes| number.as_array()[i]);
        let watched = Watched {
            cost: all.cost.map(of),
            infinite: all.infinite.lane(i),
            speed_m_s: of(all.speed_m_s),
            peaks: all.peaks.map(of),
            tilt_rad: of(all.tilt_rad),
            a_down_m_s2: of(all.a_down_m_s2),
            canopy_m: of(all.canopy_m),
            steady_from_s: of(all.steady_from_s),
            distance2: of(all.distance2),
        };
        Seen { watched, mean: self.means[i].clone() }
    }

    /// Position of a flight at the last sample whose was to be kept, NED [m].
    pub(super) fn kept_p_ned(&self, i: usize) -> Option<Vector3<f64>> {
        self.kept_p_ned.as_ref().map(|p_ned| vector(p_ned, i))
    }

    /// State of a flight at the last sample.
    pub(super) fn last(&self, i: usize) -> Option<BodyState> {
        self.last.as_ref().map(|(p_ned, motion)| body(p_ned, motion, i))
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
    look: &'a Look<'a>,
}

#[expect(clippy::manual_map, reason = "a closure cannot be forced to be inlined")]
impl Kernel for See<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { watched, samples, look } = self;
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
            steady_at_s: look.steady_at_s,
            plan_v_ned: match look.plan_v_ned {
                Some(plan_v_ned) => Some(V3::constant(zero, &plan_v_ned)),
                None => None,
            },
        };
        watched.see(&now, look.limits, V3::constant(zero, &look.v_cmd_ned), look.within_m_s);
    }
}

fn vector(vector: &V3<Lanes>, i: usize) -> Vector3<f64> {
    Vector3::new(vector.x.as_array()[i], vector.y.as_array()[i], vector.z.as_array()[i])
}

/// State of a body, by its place among those side by side.
pub(super) fn body(p_ned: &V3<Lanes>, motion: &Motion<Lanes>, i: usize) -> BodyState {
    BodyState {
        p_ned: vector(p_ned, i),
        q_ned_from_body: motion.q_ned_from_body.map(|q| q.as_array()[i]),
        v_ned: vector(&motion.v_ned, i),
        omega_body: vector(&motion.omega_body, i),
    }
}

fn set(all: &mut Watched<Lanes>, i: usize, one: &Watched<f64>) {
    let numbers = all.cost.iter_mut().chain(&mut all.peaks).zip(one.cost.iter().chain(&one.peaks));
    numbers.for_each(|(number, now)| number.as_array_mut()[i] = *now);
    for (number, now) in [
        (&mut all.speed_m_s, one.speed_m_s),
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
