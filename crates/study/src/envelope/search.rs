//! The edges of a mission's safe-release envelope, ray by ray: along single quantities first, then along
//! directions that their edges spread.

use crate::envelope::{ENVELOPE_LIMITS, MissionEnvelope};
use crate::jobs::{Jobs, Round, Stop, Stopped};
use samara_core::assess::envelope::{Edge, EdgeSearch, EnvelopeAxis, Fan, Ray, Reaches, reaches_of};

/// Directions along one quantity alone.
const QUARTERS: usize = 4;

/// A fan whose edges were searched.
#[derive(Clone, Debug, PartialEq)]
pub struct SearchedFan {
    /// The fan.
    pub fan: Fan,
    /// By which of [`ENVELOPE_LIMITS`] the nominal release is safe.
    pub nominal: [bool; 2],
    /// For each ray the edges of those limits.
    pub edges: Vec<Vec<Edge>>,
}

/// Pairs of quantities, in so many directions each, whose edges are to be searched.
#[derive(Clone, Copy, Debug)]
pub struct EnvelopeSearch<'a> {
    /// The mission's releases and flights.
    pub envelope: &'a MissionEnvelope,
    /// How an edge is searched.
    pub search: &'a EdgeSearch,
    /// The pairs.
    pub pairs: &'a [[EnvelopeAxis; 2]],
    /// Directions of each pair.
    pub turns: usize,
}

impl EnvelopeSearch<'_> {
    /// The rays as they would be without any edge known, each once: as many as there are in the end.
    pub fn rays(&self) -> Vec<Ray> {
        let mut rays: Vec<Ray> = Vec::new();
        for (_, ray) in
            self.fans(&reaches_of(self.envelope.ranges()), self.turns).iter().flat_map(|fan| &fan.rays)
        {
            if !rays.contains(ray) {
                rays.push(*ray);
            }
        }
        rays
    }

    /// Searches the edges of every fan.
    ///
    /// # Errors
    /// [`Stopped`] when the study is to end.
    pub fn run(&self, jobs: &mut dyn Jobs) -> Result<Vec<SearchedFan>, Stopped> {
        let mut searched = Searched { of: self, nominal: Vec::new(), rays: Vec::new(), edges: Vec::new() };
        searched.search(jobs, &self.fans(&reaches_of(self.envelope.ranges()), QUARTERS))?;
        let fans = self.fans(&searched.reaches(), self.turns);
        searched.search(jobs, &fans)?;
        let fans = fans.into_iter().map(|fan| SearchedFan {
            nominal: fan.rays.first().map_or([false; 2], |(_, ray)| searched.nominal_of(ray)),
            edges: fan.rays.iter().map(|(_, ray)| searched.edges_of(ray)).collect(),
            fan,
        });
        Ok(fans.collect())
    }

    fn fans(&self, reaches: &Reaches, turns: usize) -> Vec<Fan> {
        self.pairs.iter().map(|axes| Fan::new(*axes, self.envelope.ranges(), reaches, turns)).collect()
    }
}

/// Rays that were searched, with their edges.
struct Searched<'a> {
    of: &'a EnvelopeSearch<'a>,
    /// By which limits the nominal release is safe: in the mission's own turbulence, or in the point's.
    nominal: Vec<(bool, [bool; 2])>,
    rays: Vec<Ray>,
    edges: Vec<Vec<Edge>>,
}

impl Searched<'_> {
    fn nominal_of(&self, ray: &Ray) -> [bool; 2] {
        let found = self.nominal.iter().find(|(of, _)| *of == ray.from.sets_turbulence);
        found.map_or([false; 2], |(_, safe)| *safe)
    }

    fn edges_of(&self, ray: &Ray) -> Vec<Edge> {
        let place = self.rays.iter().position(|known| known == ray);
        place.and_then(|place| self.edges.get(place)).cloned().unwrap_or_default()
    }

    /// Searches the rays of fans that were not searched yet. A ray along one quantity is that of several
    /// fans.
    fn search(&mut self, jobs: &mut dyn Jobs, fans: &[Fan]) -> Result<(), Stopped> {
        let EnvelopeSearch { envelope, search, .. } = *self.of;
        let first = self.rays.len();
        for (_, ray) in fans.iter().flat_map(|fan| &fan.rays) {
            let of = ray.from.sets_turbulence;
            if self.nominal.iter().all(|(known, _)| *known != of) {
                let nominal = jobs.fly("the nominal release", Round::of(1, 1), &|_, stop| {
                    envelope.nominal(search, ray, stop).ok().map(|safe| vec![safe])
                })?;
                self.nominal.extend(nominal.into_iter().map(|safe| (of, safe)));
            }
            if !self.rays.contains(ray) {
                self.rays.push(*ray);
            }
        }
        let new = self.rays.get(first..).unwrap_or_default();
        let along = |number: u64, stop: Stop<'_>| {
            let ray = new.get(number as usize)?;
            let limits = ENVELOPE_LIMITS.into_iter().zip(self.nominal_of(ray)).filter(|(_, safe)| *safe);
            let limits: Vec<f64> = limits.map(|(limit, _)| limit).collect();
            envelope.edges(search, (first as u64 + number, ray), &limits, stop).ok()
        };
        let round = Round::of(new.len() as u64, 1);
        let edges =
            jobs.fly("rays", round, &|some, stop| some.map(|number| along(number, stop)).collect())?;
        self.edges.extend(edges);
        Ok(())
    }

    /// How far each quantity goes by itself, as far as the rays that were searched show it.
    fn reaches(&self) -> Reaches {
        let mut reaches = reaches_of(self.of.envelope.ranges());
        for (ray, edges) in self.rays.iter().zip(&self.edges) {
            let Some(edge) = edges.last().filter(|edge| edge.safe > 0.0) else { continue };
            let moved =
                EnvelopeAxis::ALL.into_iter().filter(|axis| ray.to.value(*axis) != ray.from.value(*axis));
            let moved: Vec<EnvelopeAxis> = moved.collect();
            if let [axis] = moved[..] {
                let way = ray.at(edge.safe).value(axis) - ray.from.value(axis);
                reaches[axis as usize][usize::from(way > 0.0)] = way.abs();
            }
        }
        reaches
    }
}
