//! Every derivative of the planner against differences and dual numbers, and the defects by a second path.

use nalgebra::{SVector, Vector3};
use proptest::prelude::*;
use samara::model::rigid_body::{BodyRate, BodyState};
use samara::model::{Environment, Vehicle, trim};
use samara::plan::dynamics::{Dynamics, VehicleDynamics};
use samara::plan::problem::Nodes;
use samara::plan::vehicle::transcribe;

use super::problems::{titan, titan_problem, x500};

type X = SVector<f64, 10>;
type U = SVector<f64, 4>;

fn body_state(x: &X) -> BodyState {
    BodyState {
        p_ned: Vector3::zeros(),
        q_ned_from_body: [x[0], x[1], x[2], x[3]],
        v_ned: Vector3::new(x[4], x[5], x[6]),
        omega_body: Vector3::new(x[7], x[8], x[9]),
    }
}

fn as_vector(r: &BodyRate) -> X {
    let (q, v, w) = (r.q_dot, r.v_dot_ned, r.omega_dot_body);
    X::from([q[0], q[1], q[2], q[3], v.x, v.y, v.z, w.x, w.y, w.z])
}

fn flying(vehicle: &Vehicle, environment: &Environment, x: &X, u: &U) -> X {
    as_vector(&vehicle.thrust_derivative(environment, &body_state(x), u.as_slice()))
}

prop_compose! {
    /// States anywhere: attitude not of unit length, any direction of flow, sideways too.
    fn anywhere()(
        q in prop::array::uniform4(-1.0f64..1.0), v in prop::array::uniform3(-9.0f64..9.0),
        w in prop::array::uniform3(-1.0f64..1.0), u in prop::array::uniform4(0.0f64..300.0),
    ) -> (X, U) {
        (X::from([q[0] + 1.5, q[1], q[2], q[3], v[0], v[1], v[2], w[0], w[1], w[2]]), U::from(u))
    }
}

/// Vehicles with wind, so that air and ground velocity differ; the x500 has reaction torques.
fn vehicles() -> Vec<(Vehicle, Environment)> {
    let mut all = vec![titan(), x500()];
    for (_, environment) in &mut all {
        environment.wind_ned_m_s = Vector3::new(0.7, -0.4, 0.2);
    }
    all
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// The planner's dynamics are the simulator's.
    #[test]
    fn prop_the_planner_flies_what_the_simulator_flies((x, u) in anywhere()) {
        for (vehicle, environment) in vehicles() {
            let dynamics = VehicleDynamics::<4>::new(&vehicle, &environment).unwrap();
            let (ours, theirs) = (dynamics.value(&x, &u), flying(&vehicle, &environment, &x, &u));
            prop_assert!((ours - theirs).amax() <= 1e-12 * (1.0 + theirs.amax()), "{ours} {theirs}");
            prop_assert!((dynamics.linearise(&x, &u).f - ours).amax() <= 1e-12 * (1.0 + theirs.amax()));
        }
    }

    #[test]
    fn prop_jacobians_match_central_differences((x, u) in anywhere()) {
        for (vehicle, environment) in vehicles() {
            let dynamics = VehicleDynamics::<4>::new(&vehicle, &environment).unwrap();
            let l = dynamics.linearise(&x, &u);
            let h = 1e-6;
            for j in 0..10 {
                let at = |s: f64| flying(&vehicle, &environment, &(x + X::ith(j, s * h)), &u);
                let difference = (at(1.0) - at(-1.0)) / (2.0 * h);
                let scale = 1.0 + difference.amax();
                prop_assert!((difference - l.a.column(j)).amax() < 1e-6 * scale, "state {j}: {difference} {}", l.a.column(j));
            }
            for j in 0..4 {
                let at = |d: f64| flying(&vehicle, &environment, &x, &(u + U::ith(j, d)));
                let difference = (at(1e-3) - at(-1e-3)) / 2e-3;
                prop_assert!((difference - l.b.column(j)).amax() < 1e-7 * (1.0 + difference.amax()), "input {j}");
            }
        }
    }

    /// The curvature is the derivative of the Jacobian.
    #[test]
    fn prop_curvature_matches_differences_of_the_jacobian(
        (x, u) in anywhere(), weights in prop::array::uniform10(-1.0f64..1.0),
    ) {
        let weights = X::from(weights);
        for (vehicle, environment) in vehicles() {
            let dynamics = VehicleDynamics::<4>::new(&vehicle, &environment).unwrap();
            let c = dynamics.curvature(&x, &u, &weights);
            let gradient = |x: &X, u: &U| {
                let l = dynamics.linearise(x, u);
                (l.a.tr_mul(&weights), l.b.tr_mul(&weights))
            };
            let scale = 1.0 + c.xx.amax();
            let h = 1e-6;
            for j in 0..10 {
                let (plus, minus) = (gradient(&(x + X::ith(j, h)), &u), gradient(&(x - X::ith(j, h)), &u));
                prop_assert!(((plus.0 - minus.0) / (2.0 * h) - c.xx.column(j)).amax() < 2e-6 * scale, "state {j}");
                prop_assert!(((plus.1 - minus.1) / (2.0 * h) - c.ux.column(j)).amax() < 2e-6 * scale, "input by state {j}");
            }
            for j in 0..4 {
                let (plus, minus) = (gradient(&x, &(u + U::ith(j, h))), gradient(&x, &(u - U::ith(j, h))));
                prop_assert!(((plus.1 - minus.1) / (2.0 * h) - c.uu.column(j)).amax() < 2e-6 * scale, "input {j}");
            }
        }
    }

    /// Defect Jacobians against differences of the defects.
    #[test]
    fn prop_defect_jacobians_match_central_differences((x0, u0) in anywhere(), (x1, u1) in anywhere()) {
        let (vehicle, environment) = titan();
        let problem = titan_problem(&vehicle, &environment, 38);
        let t = trim(&vehicle, &environment, problem.target_v_ned, 0.0).unwrap();
        let mut nlp = transcribe::<4>(&problem, &t.q_ned_from_body, &t.thrust_n).unwrap();
        nlp.intervals = 1;
        let nodes = Nodes { x: vec![x0, x1], u: vec![u0, u1] };
        let j = nlp.linearise(&nodes).0.defect_jacobian(0, nlp.dt_s);
        let h = 1e-6;
        for end in 0..2 {
            for i in 0..10 {
                let probe = |s: f64| {
                    let mut n = nodes.clone();
                    n.x[end][i] += s;
                    nlp.evaluate(&n).defects[0]
                };
                let difference = (probe(h) - probe(-h)) / (2.0 * h);
                let exact = if end == 0 { j.x_left.column(i) } else { j.x_right.column(i) };
                prop_assert!((difference - exact).amax() < 1e-5 * (1.0 + exact.amax()), "end {end} state {i}");
            }
            for i in 0..4 {
                let probe = |s: f64| {
                    let mut n = nodes.clone();
                    n.u[end][i] += s;
                    nlp.evaluate(&n).defects[0]
                };
                let difference = (probe(1e-3) - probe(-1e-3)) / 2e-3;
                let exact = if end == 0 { j.u_left.column(i) } else { j.u_right.column(i) };
                prop_assert!((difference - exact).amax() < 1e-6 * (1.0 + exact.amax()), "end {end} input {i}");
            }
        }
    }

    /// (33)-(37) by a second path: the cubic Hermite polynomial through both nodes, taken at its middle,
    /// Simpson's rule over its ends and middle, with the simulator's dynamics.
    #[test]
    fn prop_defects_re_derived_from_the_hermite_polynomial((x0, u0) in anywhere(), (x1, u1) in anywhere()) {
        let (vehicle, environment) = titan();
        let problem = titan_problem(&vehicle, &environment, 38);
        let t = trim(&vehicle, &environment, problem.target_v_ned, 0.0).unwrap();
        let mut nlp = transcribe::<4>(&problem, &t.q_ned_from_body, &t.thrust_n).unwrap();
        nlp.intervals = 1;
        let dt = nlp.dt_s;
        let f = |x: &X, u: &U| flying(&vehicle, &environment, x, u);
        let (f0, f1) = (f(&x0, &u0), f(&x1, &u1));
        // Coefficients of the cubic in s = t/dt.
        let (c2, c3) = ((x1 - x0) * 3.0 - (f0 * 2.0 + f1) * dt, (x0 - x1) * 2.0 + (f0 + f1) * dt);
        let middle = x0 + f0 * (dt * 0.5) + c2 * 0.25 + c3 * 0.125;
        let simpson = x0 + (f0 + f(&middle, &((u0 + u1) * 0.5)) * 4.0 + f1) * (dt / 6.0);
        let ours = nlp.evaluate(&Nodes { x: vec![x0, x1], u: vec![u0, u1] }).defects[0];
        prop_assert!((ours - (simpson - x1)).amax() < 1e-11 * (1.0 + ours.amax()), "{ours} {}", simpson - x1);
    }
}
