//! The edge of what is safe along a ray, by flights: outwards in looks, then bisection, then all flights,
//! then flights that no search has seen.
//!
//! A look flies few draws, a verification all of them; a draw that was unsafe once goes to the front, so that
//! points which are not safe are found out by their first flights. The draws of a search are the same at each
//! point and along each ray: what differs from point to point is the release, not the luck. Fresh ones differ
//! from edge to edge.

use crate::math;
use crate::random::Trials;

/// Probability that a confirmed edge is about.
pub const PROBABILITY: f64 = 0.99;
/// Confidence in an edge, of each by itself.
pub const CONFIDENCE: f64 = 0.95;

/// Draws that no search has seen begin here; a ray has `1 << 32` of them, a limit `1 << 28`, a try `1 << 24`.
const FRESH: u64 = Trials::EnvelopeFresh.first() - Trials::Envelope.first();

/// The search was broken off: it has no result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("stopped before the envelope was complete")]
pub struct Stopped;

/// Flights along a ray, each by the number of its draw.
pub trait RayFlights {
    /// One of the draws whose flight does not stay below the limit at a share of the ray; `None` when all do.
    ///
    /// # Errors
    /// [`Stopped`] when the search is to end.
    fn one_unsafe(&mut self, share: f64, limit: f64, draws: &[u64]) -> Result<Option<u64>, Stopped>;
}

/// The least number of flights that are all safe so rarely - with a probability of at most `1 - confidence` -
/// if each is safe with `probability`: the least n with `probability^n <= 1 - confidence`.
pub fn flights_for(probability: f64, confidence: f64) -> usize {
    (math::ln(1.0 - confidence) / math::ln(probability)).ceil().max(1.0) as usize
}

/// How an edge is searched.
#[derive(Clone, Debug, PartialEq)]
pub struct EdgeSearch {
    /// Flights that a point must survive.
    pub flights: usize,
    /// Points along the ray that are looked at.
    pub looks: usize,
    /// Flights of a look.
    pub look_flights: usize,
    /// How close the last safe and the first unsafe point are at the end, as a share of the latter.
    pub resolution: f64,
    /// Shares of the edge at which it is tried again on fresh releases, one after the other until one holds.
    pub tries: Vec<f64>,
}

impl Default for EdgeSearch {
    fn default() -> Self {
        Self {
            flights: flights_for(PROBABILITY, CONFIDENCE),
            looks: 16,
            look_flights: 16,
            resolution: 1.0 / 128.0,
            tries: vec![1.0, 0.95, 0.9, 0.8, 0.6],
        }
    }
}

/// The edge of a limit along a ray, as shares of the ray.
#[derive(Clone, Debug, PartialEq)]
pub struct Edge {
    /// J_state that safe flights stay below.
    pub limit: f64,
    /// The last point at which all flights of the search were safe.
    pub safe: f64,
    /// The first point beyond it at which one was not; `None`: the ray is safe to its end.
    pub beyond: Option<f64>,
    /// Points that were tried on fresh releases, in order; all but the last had an unsafe flight.
    pub tried: Vec<f64>,
    /// Whether every fresh flight of the last point was safe.
    pub holds: bool,
}

impl Edge {
    /// The farthest point that held on fresh releases; `None` when none did.
    pub fn confirmed(&self) -> Option<f64> {
        self.tried.last().copied().filter(|_| self.holds)
    }
}

impl EdgeSearch {
    /// Fresh flights of each try: so many that, the tries taken together (Bonferroni), a point where a flight
    /// is safe with less than [`PROBABILITY`] is confirmed in at most `1 - CONFIDENCE` of the edges.
    pub fn fresh_flights(&self) -> usize {
        flights_for(PROBABILITY, 1.0 - (1.0 - CONFIDENCE) / self.tries.len().max(1) as f64)
    }

    /// Whether the beginning of a ray is safe: all flights of the search there stay below the limit.
    ///
    /// # Errors
    /// [`Stopped`] as the flights.
    pub fn begins_safe(&self, limit: f64, flights: &mut impl RayFlights) -> Result<bool, Stopped> {
        Ok(flights.one_unsafe(0.0, limit, &self.draws())?.is_none())
    }

    /// The edges of limits, the lowest first, along the ray of this number, whose beginning is safe by each
    /// of them.
    ///
    /// # Errors
    /// [`Stopped`] as the flights.
    pub fn edges(
        &self,
        ray: u64,
        limits: &[f64],
        flights: &mut impl RayFlights,
    ) -> Result<Vec<Edge>, Stopped> {
        let mut draws = self.draws();
        let (mut edges, mut from) = (Vec::new(), 0.0);
        for (number, &limit) in (0..).zip(limits) {
            let (safe, beyond) = self.edge(from, limit, &mut draws, flights)?;
            // Below a lower limit is below a higher one.
            from = safe;
            let mut edge = Edge { limit, safe, beyond, tried: Vec::new(), holds: false };
            self.try_fresh(ray << 32 | number << 28, &mut edge, flights)?;
            edges.push(edge);
        }
        Ok(edges)
    }

    fn draws(&self) -> Vec<u64> {
        (0..self.flights as u64).collect()
    }

    /// The last safe and the first unsafe point beyond `from`, which is safe.
    fn edge(
        &self,
        from: f64,
        limit: f64,
        draws: &mut [u64],
        flights: &mut impl RayFlights,
    ) -> Result<(f64, Option<f64>), Stopped> {
        let looks = self.looks.max(1);
        let mut is_safe = |at: f64, count: usize| {
            let unsafe_draw = flights.one_unsafe(at, limit, &draws[..count.min(draws.len())])?;
            if let Some(place) = unsafe_draw.and_then(|found| draws.iter().position(|draw| *draw == found)) {
                draws[..=place].rotate_right(1);
            }
            Ok::<_, Stopped>(unsafe_draw.is_none())
        };
        let (mut low, mut high) = (from, None);
        for at in (1..=looks).map(|look| look as f64 / looks as f64).filter(|at| *at > from) {
            if !is_safe(at, self.look_flights)? {
                high = Some(at);
                break;
            }
            low = at;
        }
        loop {
            if let Some(unsafe_at) = &mut high {
                while *unsafe_at - low > self.resolution * unsafe_at.max(self.resolution) {
                    let middle = 0.5 * (low + *unsafe_at);
                    if is_safe(middle, self.look_flights)? {
                        low = middle;
                    } else {
                        *unsafe_at = middle;
                    }
                }
            }
            if low <= from || is_safe(low, usize::MAX)? {
                return Ok((low.max(from), high));
            }
            // A draw that no look has flown is unsafe there: back, in growing steps, to where it is not.
            let mut unsafe_at = low;
            let mut step = self.resolution * low.max(self.resolution);
            loop {
                low = (unsafe_at - step).max(from);
                if low <= from || is_safe(low, self.look_flights)? {
                    break;
                }
                (unsafe_at, step) = (low, 2.0 * step);
            }
            high = Some(unsafe_at);
        }
    }

    /// Tries an edge on fresh releases, and points within it until one holds.
    fn try_fresh(&self, numbers: u64, edge: &mut Edge, flights: &mut impl RayFlights) -> Result<(), Stopped> {
        for (number, share) in (0..).zip(&self.tries) {
            let at = share * edge.safe;
            if edge.tried.last() == Some(&at) {
                break;
            }
            let first = FRESH + (numbers | number << 24);
            let draws: Vec<u64> = (first..).take(self.fresh_flights()).collect();
            edge.tried.push(at);
            edge.holds = flights.one_unsafe(at, edge.limit, &draws)?.is_none();
            if edge.holds {
                break;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Purpose, Stream};

    /// A plant whose envelope is known: a draw is safe up to `edge*limit` less what it adds, uniform from 0
    /// to `spread`; in a hole nothing is.
    struct Toy {
        edge: f64,
        spread: f64,
        hole: Option<[f64; 2]>,
        flown: usize,
        fresh: Vec<u64>,
    }

    impl Toy {
        fn adds(&self, draw: u64) -> f64 {
            Stream::new(5, Purpose::Dice, draw).between(0.0, self.spread)
        }
    }

    impl RayFlights for Toy {
        fn one_unsafe(&mut self, share: f64, limit: f64, draws: &[u64]) -> Result<Option<u64>, Stopped> {
            self.fresh.extend(draws.iter().filter(|draw| **draw >= FRESH));
            let in_hole = self.hole.is_some_and(|[from, to]| share > from && share < to);
            let found = draws.iter().find(|draw| in_hole || share + self.adds(**draw) > self.edge * limit);
            self.flown += found.map_or(draws.len(), |found| {
                draws.iter().position(|draw| draw == found).unwrap_or_default() + 1
            });
            Ok(found.copied())
        }
    }

    fn toy(edge: f64, spread: f64) -> Toy {
        Toy { edge, spread, hole: None, flown: 0, fresh: Vec::new() }
    }

    /// 299 flights: 0.99^299 = 0.0495 and 0.99^298 = 0.0500+. With five tries at a hundredth each, 459.
    #[test]
    fn closed_form_flights_for_99_percent() {
        assert_eq!((flights_for(0.99, 0.95), flights_for(0.5, 0.75), flights_for(0.99, 0.99)), (299, 2, 459));
        assert!(0.99f64.powi(299) <= 0.05 && 0.99f64.powi(298) > 0.05);
        let search = EdgeSearch::default();
        assert_eq!((search.flights, search.fresh_flights()), (299, 459));
    }

    /// The edge lies where the worst of the 299 draws says, within the resolution, for both limits; a draw
    /// fewer would not do, and few flights are flown for it.
    #[test]
    fn closed_form_edge_of_a_known_plant() {
        let search = EdgeSearch::default();
        for (edge, spread) in [(0.9, 0.3), (0.5, 0.02), (0.61, 0.2), (0.05, 0.01)] {
            let mut plant = toy(edge, spread);
            let worst = search.draws().iter().map(|draw| plant.adds(*draw)).fold(0.0, f64::max);
            for found in search.edges(3, &[0.7, 1.0], &mut plant).unwrap() {
                let wanted = (edge * found.limit - worst).max(0.0);
                let beyond = found.beyond.unwrap();
                assert!(found.safe <= wanted && wanted <= beyond, "{edge} {spread}: {found:?}, {wanted}");
                assert!(beyond - found.safe <= search.resolution * beyond, "{found:?}");
            }
            assert!(plant.flown < 2 * 299 + 2 * 5 * 459 + 1500, "{}", plant.flown);
        }
    }

    /// A confirmed point is safe with 99 % (here: adds less than what is left, a known share of the draws) in
    /// all but one in twenty edges; here in all of 60, and it is at most the edge.
    #[test]
    fn prop_confirmed_points_are_safe() {
        let search = EdgeSearch::default();
        let (mut confirmed, mut false_ones) = (0, 0);
        for ray in 0..60 {
            let mut plant = toy(0.5 + 0.005 * ray as f64, 0.3);
            let edges = search.edges(ray, &[1.0], &mut plant).unwrap();
            let Some(at) = edges[0].confirmed() else { continue };
            assert!(at <= edges[0].safe);
            confirmed += 1;
            let safe = ((plant.edge - at) / plant.spread).min(1.0);
            false_ones += usize::from(safe < PROBABILITY);
        }
        assert!(confirmed > 50 && false_ones <= 3, "{confirmed} {false_ones}");
    }

    /// No fresh draw is one of a search, or one of another edge or try.
    #[test]
    fn prop_fresh_draws_are_fresh() {
        let mut all = Vec::new();
        for ray in 0..4 {
            let mut plant = toy(0.5, 0.3);
            EdgeSearch::default().edges(ray, &[0.7, 1.0], &mut plant).unwrap();
            all.extend(plant.fresh);
        }
        let count = all.len();
        all.sort_unstable();
        all.dedup();
        assert!(count >= 4 * 2 * 459 && all.len() == count && all[0] >= FRESH);
    }

    /// A hole as wide as a step of the looks ends the envelope at its near side; a ray that is safe to its
    /// end says so; one that is safe at its beginning alone ends there.
    #[test]
    fn closed_form_holes_ends_and_beginnings() {
        let search = EdgeSearch::default();
        let mut plant = Toy { hole: Some([0.25, 0.32]), ..toy(9.0, 0.1) };
        let edges = search.edges(0, &[1.0], &mut plant).unwrap();
        assert!(edges[0].safe <= 0.25 && edges[0].beyond.unwrap() > 0.25, "{edges:?}");
        let edges = search.edges(0, &[0.7, 1.0], &mut toy(9.0, 0.1)).unwrap();
        assert!(
            edges.iter().all(|edge| (edge.safe, edge.beyond, edge.confirmed()) == (1.0, None, Some(1.0)))
        );
        let mut plant = toy(1e-6, 0.0);
        assert!(
            search.begins_safe(1.0, &mut plant).unwrap() && !search.begins_safe(-1.0, &mut plant).unwrap()
        );
        let edges = search.edges(0, &[1.0], &mut plant).unwrap();
        assert_eq!((edges[0].safe, edges[0].confirmed()), (0.0, Some(0.0)));
    }
}
