"""The nominal plan by CasADi and IPOPT at default settings, timed beside samara's own solver.

The NLP is built from the same mission and vehicle files: rigid body, body aerodynamics by periodic cubic splines, Hermite-Simpson
defects (33)-(37), trapezoidal cost (38)-(39), 38 nodes, thrust and rate bounds, the first node fixed, and starts from the same
straight line as `crates/core/src/plan/vehicle.rs`. Its functions are SX and built beforehand; what is timed is the call of the solver, in
CPU time of the process. Rotors without reaction torque, as the Titan vehicle has them.
"""

import json
import math
import os
import statistics
import subprocess
import sys
import time

import casadi as ca
import numpy as np

REPOSITORY = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
MISSION = os.path.join(REPOSITORY, "mission", "titan_paper.json")
OBJECTIVE = 229.184232163  # of an independent implementation, converged to 1e-12
ROUNDS = 9
SOLVES_PER_ROUND = 100


def read(path):
    with open(path, encoding="utf-8") as file:
        return json.load(file)


def periodic_spline(knots, values):
    """Coefficients per piece (c0 + c1 d + ..) of the C2 periodic cubic through equidistant or other knots."""
    m = len(knots) - 1
    h = np.diff(knots)
    secant = np.diff(values) / h
    system, right = np.zeros((m, m)), np.zeros(m)
    for i in range(m):
        before, after = (i - 1) % m, (i + 1) % m
        system[i, before] += 1 / h[before]
        system[i, i] += 2 * (1 / h[before] + 1 / h[i])
        system[i, after] += 1 / h[i]
        right[i] = 3 * (secant[before] / h[before] + secant[i] / h[i])
    slope = np.linalg.solve(system, right)
    following = np.roll(slope, -1)
    return np.array([values[:-1], slope, (3 * secant - 2 * slope - following) / h, (slope + following - 2 * secant) / h**2])


def spline_of(alpha, knots, values):
    """The spline as an SX expression: each coefficient is piecewise constant in alpha."""
    pieces = periodic_spline(np.array(knots), np.array(values))
    inner = knots[1:-1]
    c = [ca.pw_const(alpha, inner, row) for row in pieces]
    d = alpha - ca.pw_const(alpha, inner, knots[:-1])
    return c[0] + d * (c[1] + d * (c[2] + d * c[3]))


def dynamics(vehicle, site):
    """f(x, u) of (25): x = [q, v_ned, omega], u = thrust of each rotor."""
    if vehicle["effects"]["reaction_torque"]:
        sys.exit("this comparison leaves reaction torques out, and the vehicle has them")
    x, u = ca.SX.sym("x", 10), ca.SX.sym("u", len(vehicle["rotors"]))
    q, v, w = x[:4], x[4:7], x[7:]
    q0, q1, q2, q3 = ca.vertsplit(q)
    body_from_ned = ca.vertcat(
        ca.horzcat(q0**2 + q1**2 - q2**2 - q3**2, 2 * (q1 * q2 + q0 * q3), 2 * (q1 * q3 - q0 * q2)),
        ca.horzcat(2 * (q1 * q2 - q0 * q3), q0**2 - q1**2 + q2**2 - q3**2, 2 * (q2 * q3 + q0 * q1)),
        ca.horzcat(2 * (q1 * q3 + q0 * q2), 2 * (q2 * q3 - q0 * q1), q0**2 - q1**2 - q2**2 + q3**2),
    )
    air = ca.mtimes(body_from_ned, v - ca.DM(site["wind_ned_m_s"]))
    aero = vehicle["body_aero"]
    knots = [math.radians(a) for a in aero["alpha_deg"]]
    alpha = ca.atan2(air[2], air[0])
    cd, cl, cm = (spline_of(alpha, knots, aero[name]) for name in ("c_drag", "c_lift", "c_pitch"))
    qs = 0.5 * site["density_kg_m3"] * aero["reference_area_m2"] * ca.sumsqr(air)
    sin, cos = ca.sin(alpha), ca.cos(alpha)
    force = ca.vertcat(qs * (cl * sin - cd * cos), 0, -qs * (cd * sin + cl * cos))
    moment = ca.vertcat(0, qs * aero["reference_span_m"] * cm, 0)
    for i, rotor in enumerate(vehicle["rotors"]):
        thrust = ca.DM(rotor["axis_body"]) * u[i]
        force += thrust
        moment += ca.cross(ca.DM(rotor["position_body_m"]), thrust)
    inertia = ca.DM(vehicle["inertia_kg_m2"])
    q_dot = 0.5 * ca.vertcat(
        -q1 * w[0] - q2 * w[1] - q3 * w[2],
        q0 * w[0] - q3 * w[1] + q2 * w[2],
        q3 * w[0] + q0 * w[1] - q1 * w[2],
        -q2 * w[0] + q1 * w[1] + q0 * w[2],
    )
    v_dot = ca.mtimes(body_from_ned.T, force) / vehicle["mass_kg"] + ca.DM([0, 0, site["gravity_m_s2"]])
    w_dot = (moment - ca.cross(w, inertia * w)) / inertia
    return ca.Function("f", [x, u], [ca.vertcat(q_dot, v_dot, w_dot)])


def transcribe():
    """The NLP with the arguments of its solver."""
    mission = read(MISSION)
    vehicle = read(os.path.join(os.path.dirname(MISSION), mission["vehicle"]))
    site, plan, parachute = mission["site"], mission["plan"], mission["parachute"]
    f = dynamics(vehicle, site)
    nodes, rotors = plan["nodes"], len(vehicle["rotors"])
    dt = plan["horizon_s"] / (nodes - 1)
    reference = plan["x_ss"]
    x_ss = np.array(reference["q_ned_from_body"] + reference["v_ned_m_s"] + reference["omega_body_rad_s"])
    v0 = parachute["descent_m_s"] + site["gravity_m_s2"] * parachute["delay_s"]
    x_first = np.array([1, 0, 0, 0, 0, 0, v0, 0, 0, 0])
    weights, r = ca.DM(plan["cost_state"]), plan["cost_input_per_n2"]

    x = [ca.SX.sym(f"x{k}", 10) for k in range(nodes)]
    u = [ca.SX.sym(f"u{k}", rotors) for k in range(nodes)]
    rates = [f(x[k], u[k]) for k in range(nodes)]
    stage = [ca.dot(weights, (s - x_ss) ** 2) + r * ca.sumsqr(i) for s, i in zip(x, u)]
    cost = ca.dot(weights, (x[-1] - x_ss) ** 2)
    rows, low, high = [], [], []
    for k in range(nodes - 1):
        cost += dt / 2 * (stage[k] + stage[k + 1])
        middle = (x[k] + x[k + 1]) / 2 + dt / 8 * (rates[k] - rates[k + 1])
        rate = f(middle, (u[k] + u[k + 1]) / 2)
        rows.append(x[k] - x[k + 1] + dt / 6 * (rates[k] + 4 * rate + rates[k + 1]))
        low += [0] * 10
        high += [0] * 10
        rows.append(u[k + 1] - u[k])
        low += [-dt * plan["thrust_slew_n_s"]] * rotors
        high += [dt * plan["thrust_slew_n_s"]] * rotors
    hover = vehicle["mass_kg"] * site["gravity_m_s2"] / rotors
    guess, least, greatest = [], [], []
    for k in range(nodes):
        t = k * dt
        guess += list(x_first + (x_ss - x_first) * min(t / 8.0, 1.0))
        guess += [min(0.8 * hover, 0.6 * plan["thrust_slew_n_s"] * t)] * rotors
        least += list(x_first) + [0] * rotors if k == 0 else [-ca.inf] * 10 + [0] * rotors
        greatest += list(x_first) + [0] * rotors if k == 0 else [ca.inf] * 10 + [plan["thrust_max_n"]] * rotors
    variables = ca.vertcat(*(part for pair in zip(x, u) for part in pair))
    nlp = {"x": variables, "f": cost, "g": ca.vertcat(*rows)}
    return nlp, {"x0": guess, "lbx": least, "ubx": greatest, "lbg": low, "ubg": high}


def main():
    ours_program = sys.argv[1]
    nlp, arguments = transcribe()
    solvers = {"CasADi + IPOPT": ca.nlpsol("plan", "ipopt", nlp, {"print_time": False, "ipopt": {"print_level": 0, "sb": "yes"}})}
    times = {name: [] for name in [*solvers, "samara"]}
    iterations, objectives, in_functions = {}, {}, []
    # In turn, so that a busy moment of the machine meets all of them.
    for _ in range(ROUNDS):
        for name, solver in solvers.items():
            before = time.process_time()
            result = solver(**arguments)
            times[name].append(1e3 * (time.process_time() - before))
            stats = solver.stats()
            if not stats["success"]:
                sys.exit(f"{name}: {stats['return_status']}")
            in_functions.append(1e3 * sum(t for key, t in stats.items() if key.startswith("t_proc_nlp_")))
            iterations[name], objectives[name] = stats["iter_count"], float(result["f"])
        line = subprocess.run([ours_program, "cold", str(SOLVES_PER_ROUND)], check=True, capture_output=True).stdout
        ours = json.loads(line)
        times["samara"].append(ours["cpu_ms_mean"])
        iterations["samara"], objectives["samara"] = ours["iterations_median"], ours["objective"]
    for name, objective in objectives.items():
        # IPOPT relaxes bounds by 1e-8 of their size at default settings; hence relative, and 1e-6.
        if abs(objective / OBJECTIVE - 1) > 1e-6:
            sys.exit(f"{name}: objective {objective:.9f}, expected {OBJECTIVE}")
    ours = statistics.median(times["samara"])
    print(f"nominal plan, 38 nodes, cold; CPU ms, median of {ROUNDS} (samara: of means over {SOLVES_PER_ROUND})")
    print(f"{'':36}{'CPU ms':>9}{'least':>9}{'ratio':>8}{'iterations':>12}{'objective':>16}")
    for name, measured in times.items():
        median = statistics.median(measured)
        print(f"{name:36}{median:9.2f}{min(measured):9.2f}{median / ours:8.1f}{iterations[name]:12}{objectives[name]:16.9f}")
    print(f"IPOPT's time without the functions that CasADi evaluates for it: {statistics.median(times['CasADi + IPOPT']) - statistics.median(in_functions):.2f} ms")


if __name__ == "__main__":
    main()
