//! Particle swarm by the rules of MATLAB's `particleswarm`, which the paper used (IV.C).
//!
//! For particle i with position x, velocity v and best position p so far:
//!
//! ```text
//! S = N random others ;  g = the best position that any of S has found
//! v = W v + y1 u1 (p - x) + y2 u2 (g - x),  u1, u2 uniform in (0,1), component by component ;  x = x + v
//! x outside a bound: x = the bound, and v = 0 where it points out
//! best improved: c = max(c - 1, 0), N = N_min;  otherwise: c = c + 1, N = min(N + N_min, all)
//! then W = 2 W if c < 2, W = W/2 if c > 5, kept in the range of inertia
//! ```
//!
//! N_min = max(2, a quarter of the swarm). It has converged when the best cost has fallen by no more than
//! 1e-6 over the stall iterations: as a fraction of it where it is above 1, absolute below. Rules as
//! documented (whether W changes without an improvement is left open there; without it a swarm that begins
//! with W = 1.1 stalls) in "Particle Swarm Optimization Algorithm", Global Optimization Toolbox; random
//! numbers are our own, so that runs of MATLAB are not repeated digit by digit.

use super::{Optimiser, usable};
use crate::random::{Purpose, Stream};

/// Settings; the defaults are MATLAB's for seven variables.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SwarmSettings {
    /// Number of particles.
    pub particles: usize,
    /// Range of the inertia W.
    pub inertia: (f64, f64),
    /// Weights y1 of the particle's own best, y2 of its neighbours'.
    pub weights: (f64, f64),
    /// Least share of the swarm in a neighbourhood.
    pub neighbours: f64,
    /// Iterations over which the best cost must fall.
    pub stall_iterations: usize,
    /// By more than this: a fraction of the cost where it is above 1, absolute below.
    pub tolerance: f64,
}

impl Default for SwarmSettings {
    fn default() -> Self {
        Self {
            particles: 70,
            inertia: (0.1, 1.1),
            weights: (1.49, 1.49),
            neighbours: 0.25,
            stall_iterations: 20,
            tolerance: 1e-6,
        }
    }
}

/// A swarm.
#[derive(Clone, Debug)]
pub struct ParticleSwarm<const N: usize> {
    settings: SwarmSettings,
    bounds: [(f64, f64); N],
    streams: Vec<Stream>,
    x: Vec<[f64; N]>,
    v: Vec<[f64; N]>,
    own_best: Vec<([f64; N], f64)>,
    inertia: f64,
    neighbours: usize,
    stalled: usize,
    /// Best cost after each iteration.
    history: Vec<f64>,
}

impl<const N: usize> ParticleSwarm<N> {
    /// A swarm at random within the bounds (lower, upper), velocities within plus and minus their width; at
    /// least 3 particles.
    pub fn new(bounds: [(f64, f64); N], settings: SwarmSettings, seed: u64) -> Self {
        let settings = SwarmSettings { particles: settings.particles.max(3), ..settings };
        let mut streams: Vec<Stream> =
            (0..settings.particles as u64).map(|i| Stream::new(seed, Purpose::Swarm, i)).collect();
        let x: Vec<[f64; N]> =
            streams.iter_mut().map(|s| bounds.map(|(low, high)| s.between(low, high))).collect();
        let v =
            streams.iter_mut().map(|s| bounds.map(|(low, high)| s.between(low - high, high - low))).collect();
        Self {
            settings,
            bounds,
            own_best: x.iter().map(|x| (*x, f64::INFINITY)).collect(),
            streams,
            x,
            v,
            inertia: settings.inertia.1,
            neighbours: least_neighbours(&settings),
            stalled: 0,
            history: Vec::new(),
        }
    }

    /// Puts one particle at a given place, within the bounds; before the first costs.
    pub fn place(&mut self, particle: usize, at: [f64; N]) {
        let at: [f64; N] = std::array::from_fn(|k| at[k].clamp(self.bounds[k].0, self.bounds[k].1));
        self.x[particle] = at;
        self.own_best[particle].0 = at;
    }

    /// Takes the costs into the bests; whether the best of all has improved.
    fn remember(&mut self, costs: &[f64]) -> bool {
        for ((best, x), cost) in self.own_best.iter_mut().zip(&self.x).zip(costs) {
            if usable(*cost) < best.1 {
                *best = (*x, *cost);
            }
        }
        let best = self.own_best.iter().map(|b| b.1).fold(f64::INFINITY, f64::min);
        let improved = self.history.last().is_some_and(|before| best < *before);
        self.history.push(best);
        improved
    }

    fn adapt(&mut self, improved: bool) {
        let least = least_neighbours(&self.settings);
        if improved {
            self.stalled = self.stalled.saturating_sub(1);
            self.neighbours = least;
        } else {
            self.stalled += 1;
            self.neighbours = (self.neighbours + least).min(self.settings.particles - 1);
        }
        if self.stalled < 2 {
            self.inertia *= 2.0;
        } else if self.stalled > 5 {
            self.inertia *= 0.5;
        }
        self.inertia = self.inertia.clamp(self.settings.inertia.0, self.settings.inertia.1);
    }

    fn fly(&mut self) {
        let (y1, y2) = self.settings.weights;
        for i in 0..self.x.len() {
            let g = self.best_neighbour(i);
            let (stream, p) = (&mut self.streams[i], self.own_best[i].0);
            for k in 0..N {
                let (u1, u2) = (stream.uniform(), stream.uniform());
                let x = self.x[i][k];
                let v = self.inertia * self.v[i][k] + y1 * u1 * (p[k] - x) + y2 * u2 * (g[k] - x);
                let (low, high) = self.bounds[k];
                let moved = x + v;
                let points_out = (moved < low && v < 0.0) || (moved > high && v > 0.0);
                self.v[i][k] = if points_out { 0.0 } else { v };
                self.x[i][k] = moved.clamp(low, high);
            }
        }
    }

    /// Best position that a random choice of the others has found (the first `neighbours` of a shuffle).
    fn best_neighbour(&mut self, i: usize) -> [f64; N] {
        let mut others: Vec<usize> = (0..self.x.len()).filter(|j| *j != i).collect();
        let mut best = (self.own_best[i].0, f64::INFINITY);
        for k in 0..self.neighbours.min(others.len()) {
            let pick = k + self.streams[i].below(others.len() - k);
            others.swap(k, pick);
            let found = self.own_best[others[k]];
            if k == 0 || found.1 < best.1 {
                best = found;
            }
        }
        best.0
    }
}

fn least_neighbours(settings: &SwarmSettings) -> usize {
    ((settings.particles as f64 * settings.neighbours) as usize).max(2)
}

impl<const N: usize> Optimiser<N> for ParticleSwarm<N> {
    fn candidates(&self) -> &[[f64; N]] {
        &self.x
    }

    fn update(&mut self, costs: &[f64]) {
        let first = self.history.is_empty();
        let improved = self.remember(costs);
        if !first {
            self.adapt(improved);
        }
        self.fly();
    }

    /// Cost of the particle's own best: a particle remembers nothing that is no better.
    fn to_beat(&self, candidate: usize) -> f64 {
        self.own_best.get(candidate).map_or(f64::INFINITY, |best| best.1)
    }

    fn has_converged(&self) -> bool {
        let stall = self.settings.stall_iterations;
        let Some(before) = self.history.len().checked_sub(stall + 1) else { return false };
        let (then, now) = (self.history[before], self.history[self.history.len() - 1]);
        now.is_finite() && then - now <= self.settings.tolerance * now.abs().max(1.0)
    }
}
