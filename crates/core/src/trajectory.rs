//! A planned trajectory: the type that planner and controller share; it depends on neither.
//!
//! Nodes hold state, thrusts and acceleration. Between nodes the velocity is the cubic Hermite polynomial
//! through node values with slopes `f(x_k, u_k)` (the same polynomial whose midpoint the Hermite-Simpson
//! defect uses, (36)), the thrusts run linearly. Before the first node and after the last one the end value
//! is held.

use nalgebra::Vector3;

use crate::frames::{Quaternion, quaternion_rate};
use crate::model::{MAX_ROTORS, PerRotor};

/// A node of a trajectory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// Time from the start of powered flight [s].
    pub t_s: f64,
    /// Attitude, body to NED, scalar first.
    pub q_ned_from_body: Quaternion,
    /// Velocity, NED [m/s].
    pub v_ned: Vector3<f64>,
    /// Body rates [rad/s].
    pub omega_body: Vector3<f64>,
    /// Thrust of each rotor [N].
    pub thrust_n: PerRotor,
    /// Acceleration, NED [m/s^2]: the slope of the velocity.
    pub a_ned: Vector3<f64>,
}

impl Node {
    /// A node that is level, turns nowhere and has no thrust, at a velocity that does not change.
    pub fn level(t_s: f64, v_ned: Vector3<f64>) -> Self {
        Self {
            t_s,
            q_ned_from_body: crate::frames::LEVEL,
            v_ned,
            omega_body: Vector3::zeros(),
            thrust_n: [0.0; MAX_ROTORS],
            a_ned: Vector3::zeros(),
        }
    }
}

/// Nodes in order of time, with interpolation between them.
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory {
    nodes: Vec<Node>,
    n_rotors: usize,
}

/// Why nodes do not make a trajectory.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TrajectoryError {
    /// Fewer than two nodes.
    #[error("a trajectory needs at least 2 nodes, found {0}")]
    TooShort(usize),
    /// A number that is not finite.
    #[error("node {node}: {what} is not finite")]
    NotFinite {
        /// Index of the node, from 0.
        node: usize,
        /// Name of the quantity.
        what: &'static str,
    },
    /// Time that does not increase.
    #[error("node {node}: time must increase, but {t_s} s follows {previous_s} s")]
    TimeBackwards {
        /// Index of the node, from 0.
        node: usize,
        /// Time of that node [s].
        t_s: f64,
        /// Time of the node before [s].
        previous_s: f64,
    },
}

impl Trajectory {
    /// Checks the nodes, whose thrusts are for `n_rotors` rotors.
    ///
    /// # Errors
    /// [`TrajectoryError`] for fewer than two nodes, a number that is not finite, or time that does not
    /// increase.
    pub fn new(nodes: Vec<Node>, n_rotors: usize) -> Result<Self, TrajectoryError> {
        if nodes.len() < 2 {
            return Err(TrajectoryError::TooShort(nodes.len()));
        }
        for (i, n) in nodes.iter().enumerate() {
            let finite = |v: &[f64]| v.iter().all(|x| x.is_finite());
            let checks: [(&'static str, bool); 6] = [
                ("time", n.t_s.is_finite()),
                ("attitude", finite(&n.q_ned_from_body)),
                ("velocity", finite(n.v_ned.as_slice())),
                ("body rate", finite(n.omega_body.as_slice())),
                ("thrust", finite(&n.thrust_n)),
                ("acceleration", finite(n.a_ned.as_slice())),
            ];
            if let Some((what, _)) = checks.iter().find(|(_, ok)| !ok) {
                return Err(TrajectoryError::NotFinite { node: i, what });
            }
            if i > 0 && n.t_s <= nodes[i - 1].t_s {
                return Err(TrajectoryError::TimeBackwards {
                    node: i,
                    t_s: n.t_s,
                    previous_s: nodes[i - 1].t_s,
                });
            }
        }
        Ok(Self { nodes, n_rotors })
    }

    /// The nodes in order of time.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// Number of rotors that the thrusts are for.
    pub fn n_rotors(&self) -> usize {
        self.n_rotors
    }

    /// The weighted sum of this trajectory and others with weights of their own, node by node, on this one's
    /// times. The others have nodes at those times, and all weights together are 1.
    pub(crate) fn weighted(&self, weight: f64, others: &[(&Self, f64)]) -> Self {
        let mut sum = self.clone();
        for (k, node) in sum.nodes.iter_mut().enumerate() {
            node.q_ned_from_body = node.q_ned_from_body.map(|x| weight * x);
            node.v_ned *= weight;
            node.omega_body *= weight;
            node.thrust_n = node.thrust_n.map(|x| weight * x);
            node.a_ned *= weight;
            for (other, weight) in others.iter().filter_map(|(other, w)| Some((other.nodes.get(k)?, *w))) {
                for (x, y) in node.q_ned_from_body.iter_mut().zip(other.q_ned_from_body) {
                    *x += weight * y;
                }
                for (x, y) in node.thrust_n.iter_mut().zip(other.thrust_n) {
                    *x += weight * y;
                }
                node.v_ned += other.v_ned * weight;
                node.omega_body += other.omega_body * weight;
                node.a_ned += other.a_ned * weight;
            }
        }
        sum
    }

    /// Time of the last node, t_f [s].
    pub fn end_s(&self) -> f64 {
        self.nodes[self.nodes.len() - 1].t_s
    }

    /// Left node, right node, length of their interval [s] and the fraction of it at `t_s`; `None` outside
    /// the nodes.
    fn locate(&self, t_s: f64) -> Option<(&Node, &Node, f64, f64)> {
        let i = self.nodes.partition_point(|n| n.t_s <= t_s);
        if i == 0 || i == self.nodes.len() {
            return None;
        }
        let (a, b) = (&self.nodes[i - 1], &self.nodes[i]);
        let h = b.t_s - a.t_s;
        Some((a, b, h, (t_s - a.t_s) / h))
    }

    fn end_node(&self, t_s: f64) -> &Node {
        if t_s < self.nodes[0].t_s { &self.nodes[0] } else { &self.nodes[self.nodes.len() - 1] }
    }

    /// Velocity, NED [m/s], at `t_s`: cubic Hermite; ends held.
    pub fn velocity_ned(&self, t_s: f64) -> Vector3<f64> {
        match self.locate(t_s) {
            Some((a, b, h, s)) => hermite(a.v_ned, a.a_ned, b.v_ned, b.a_ned, h, s),
            None => self.end_node(t_s).v_ned,
        }
    }

    /// Slope of [`Self::velocity_ned`], NED [m/s^2]; zero outside the nodes, where the velocity is held.
    pub fn acceleration_ned(&self, t_s: f64) -> Vector3<f64> {
        match self.locate(t_s) {
            Some((a, b, h, s)) => {
                (b.v_ned - a.v_ned) * (6.0 * s * (1.0 - s) / h)
                    + a.a_ned * ((1.0 - s) * (1.0 - 3.0 * s))
                    + b.a_ned * (s * (3.0 * s - 2.0))
            }
            None => Vector3::zeros(),
        }
    }

    /// Thrust of each rotor [N] at `t_s`: linear; ends held.
    pub fn thrust_n(&self, t_s: f64) -> PerRotor {
        match self.locate(t_s) {
            Some((a, b, _, s)) => {
                std::array::from_fn(|i| a.thrust_n[i] + s * (b.thrust_n[i] - a.thrust_n[i]))
            }
            None => self.end_node(t_s).thrust_n,
        }
    }

    /// Body rates [rad/s] at `t_s`: linear; ends held.
    pub fn body_rates(&self, t_s: f64) -> Vector3<f64> {
        match self.locate(t_s) {
            Some((a, b, _, s)) => a.omega_body + (b.omega_body - a.omega_body) * s,
            None => self.end_node(t_s).omega_body,
        }
    }

    /// Attitude at `t_s` by cubic Hermite with slopes (2), not normalised; ends held.
    pub fn attitude(&self, t_s: f64) -> Quaternion {
        let Some((a, b, h, s)) = self.locate(t_s) else { return self.end_node(t_s).q_ned_from_body };
        let vector = |q: Quaternion| nalgebra::Vector4::from(q);
        let (da, db) = (
            quaternion_rate(a.q_ned_from_body, a.omega_body.into()),
            quaternion_rate(b.q_ned_from_body, b.omega_body.into()),
        );
        hermite(vector(a.q_ned_from_body), vector(da), vector(b.q_ned_from_body), vector(db), h, s).into()
    }
}

/// Cubic Hermite polynomial at the fraction `s` of an interval `h`, values `a`, `b` and slopes `da`, `db` at
/// its ends.
fn hermite<const N: usize>(
    a: nalgebra::SVector<f64, N>,
    da: nalgebra::SVector<f64, N>,
    b: nalgebra::SVector<f64, N>,
    db: nalgebra::SVector<f64, N>,
    h: f64,
    s: f64,
) -> nalgebra::SVector<f64, N> {
    let r = 1.0 - s;
    a * (r * r * (1.0 + 2.0 * s)) + da * (h * s * r * r) + b * (s * s * (3.0 - 2.0 * s))
        - db * (h * s * s * r)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::LEVEL;

    fn cubic() -> Trajectory {
        let nodes = [0.0, 0.5, 2.0]
            .map(|t: f64| Node {
                t_s: t,
                q_ned_from_body: LEVEL,
                v_ned: Vector3::new(t.powi(3) - t, 2.0, -t * t),
                omega_body: Vector3::zeros(),
                thrust_n: [t; 8],
                a_ned: Vector3::new(3.0 * t * t - 1.0, 0.0, -2.0 * t),
            })
            .to_vec();
        Trajectory::new(nodes, 4).unwrap()
    }

    #[test]
    fn closed_form_hermite_reproduces_a_cubic_and_its_slope() {
        let trajectory = cubic();
        for t in [0.0f64, 0.1, 0.5, 0.77, 1.9] {
            let (v, a) = (trajectory.velocity_ned(t), trajectory.acceleration_ned(t));
            assert!((v - Vector3::new(t.powi(3) - t, 2.0, -t * t)).norm() < 1e-14);
            assert!((a - Vector3::new(3.0 * t * t - 1.0, 0.0, -2.0 * t)).norm() < 1e-14);
            assert!((trajectory.thrust_n(t)[2] - t).abs() < 1e-14);
        }
    }

    #[test]
    fn ends_are_held() {
        let trajectory = cubic();
        assert_eq!(trajectory.velocity_ned(9.0), trajectory.nodes()[2].v_ned);
        assert_eq!(trajectory.velocity_ned(-1.0), trajectory.nodes()[0].v_ned);
        assert_eq!(trajectory.acceleration_ned(9.0), Vector3::zeros());
    }

    #[test]
    fn nodes_that_make_no_trajectory_are_refused() {
        let mut nodes = cubic().nodes().to_vec();
        nodes[2].t_s = 0.5;
        assert!(matches!(
            Trajectory::new(nodes.clone(), 4),
            Err(TrajectoryError::TimeBackwards { node: 2, .. })
        ));
        nodes[2].t_s = 2.0;
        nodes[1].v_ned.x = f64::NAN;
        assert!(matches!(
            Trajectory::new(nodes, 4),
            Err(TrajectoryError::NotFinite { node: 1, what: "velocity" })
        ));
    }
}
