"""The tuning problem's flights on the ideal plant in numba, timed beside samara's batch engine.

One flight is a scalar function, compiled; `prange` spreads flights over two threads. Model, control law, integration and costs are those
of `crates/core/src/sim/planar`, written as one would in the plane: v_N, v_D, theta, Q, classical Runge-Kutta, thrusts that run linearly within
a control period, J_RMS (45) and J_TPF (51) on the way. The body's coefficients are the same splines, evaluated from coefficients per
interval. Both programs fly the same gains and releases, and their costs are compared before anything is timed.
"""

import json
import math
import os
import resource
import statistics
import subprocess
import sys
import time

import numba
import numpy as np
from numba import njit, prange

REPOSITORY = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
THREADS = 2
FLIGHTS = 490  # 70 particles on 7 releases: one generation
GENERATIONS = 100
ROUNDS = 7

RELEASES = np.array([  # Table 3: v_N, v_D [m/s], pitch [deg], pitch rate [deg/s]
    [0.0, 3.67, 0.0, 0.0], [0.32, 3.67, 0.0, 18.8], [0.26, 3.64, 5.5, 15.2], [0.10, 3.65, 8.9, 5.8],
    [-0.10, 3.69, 8.9, -5.8], [-0.26, 3.70, 5.5, -15.2], [-0.32, 3.67, 0.0, -18.8],
])
HIGHEST = np.array([5.0, 0.5, 2.0, 5.0, 1.0, 3.0, 0.05])


def read(*path):
    with open(os.path.join(REPOSITORY, *path), encoding="utf-8") as file:
        return json.load(file)


def periodic_spline(knots, values):
    """Coefficients per interval (c0 + c1 d + ..) of the C2 periodic cubic."""
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
    return np.array([values[:-1], slope, (3 * secant - 2 * slope - following) / h, (slope + following - 2 * secant) / h**2]).T


def problem():
    """Vehicle, spline coefficients [interval, 12], setpoints [step, 2] and nodes [node, 5]."""
    vehicle = read("params", "vehicles", "titan.json")
    numbers = read("tests", "data", "reference_flights.json")
    aero = vehicle["body_aero"]
    alpha = np.radians(np.array(aero["alpha_deg"]))
    splines = np.hstack([periodic_spline(alpha, np.array(aero[name])) for name in ("c_drag", "c_lift", "c_pitch")])
    reference = numbers["flight_reference"]
    node_dt, table = reference["dt_s"], np.array(reference["vn_vd_dvn_dvd"])
    intervals = len(table) - 1
    steps = 81 * intervals
    dt = node_dt * intervals / steps
    setpoints = np.empty((steps, 2))
    for k in range(steps):
        i, s = k // 81, (k % 81) / 81
        r = 1 - s
        a, b = table[i], table[i + 1]
        setpoints[k] = (a[:2] * (r * r * (1 + 2 * s)) + a[2:] * (node_dt * s * r * r)
                        + b[:2] * (s * s * (3 - 2 * s)) - b[2:] * (node_dt * s * s * r))
    nodes = np.array(numbers["plan_q0_q2_vn_vd_q"])
    nodes[:, 2:4] = table[:, :2]
    body = np.array([vehicle["mass_kg"], vehicle["inertia_kg_m2"][1], vehicle["rotors"][0]["position_body_m"][0],
                     1.35, 5.4, aero["reference_area_m2"], aero["reference_span_m"], 431.97])
    return body, splines, setpoints, nodes, dt


def flights(n):
    """Gains [n, 7] and states [n, 4]: as benches/swarm/mod.rs."""
    gains, states = np.empty((n, 7)), np.empty((n, 4))
    for k in range(n):
        particle = k // 7 % 70
        for j in range(7):
            x = (particle + 1.0) * 2.0 ** (1.0 / (j + 2.0))
            gains[k, j] = HIGHEST[j] * (0.02 + 0.98 * math.modf(x)[0])
        states[k] = RELEASES[k % 7]
    states[:, 2:] = np.radians(states[:, 2:])
    return gains, states


@njit(inline="always")
def clip(x, low, high):
    return min(max(x, low), high)


@njit(inline="always")
def derivative(v_n, v_d, theta, rate, front, rear, body, splines):
    mass, inertia, arm, gravity, density, area, span = body[0], body[1], body[2], body[3], body[4], body[5], body[6]
    cos, sin = math.cos(theta), math.sin(theta)
    u, w = cos * v_n - sin * v_d, sin * v_n + cos * v_d
    alpha = math.atan2(w, u)
    n = splines.shape[0]
    width = 2 * math.pi / n
    i = min(int((alpha + math.pi) / width), n - 1)
    d = alpha + math.pi - i * width
    c = splines[i]
    c_d = c[0] + d * (c[1] + d * (c[2] + d * c[3]))
    c_l = c[4] + d * (c[5] + d * (c[6] + d * c[7]))
    c_m = c[8] + d * (c[9] + d * (c[10] + d * c[11]))
    speed2 = u * u + w * w
    speed = math.sqrt(speed2)
    half = 0.5 * density * area
    f_x = half * speed * (c_l * w - c_d * u)
    f_z = -half * speed * (c_d * w + c_l * u) - 2 * (front + rear)
    moment = half * span * speed2 * c_m + 2 * arm * (front - rear)
    return (cos * f_x + sin * f_z) / mass, (cos * f_z - sin * f_x) / mass + gravity, rate, moment / inertia


@njit(error_model="numpy")
def fly(k, x, body, splines, setpoints, nodes, dt):
    """J_RMS and J_TPF of a flight with gains k from the state x."""
    mass, inertia, arm, gravity, limit = body[0], body[1], body[2], body[3], body[7]
    tan_tilt, rate_max = math.tan(math.radians(37.5)), math.radians(220.0)
    up_max = 4 * limit / mass
    v_n, v_d, theta, rate = x[0], x[1], x[2], x[3]
    i_n, i_d, i_q = 0.0, 0.0, 0.0
    front, rear = 0.0, 0.0
    squares, peak_speed2, peak_pitch, peak_rate = 0.0, 0.0, 0.0, 0.0
    steps = setpoints.shape[0]
    for step in range(steps + 1):
        speed2 = v_n * v_n + v_d * v_d
        peak_speed2 = max(peak_speed2, speed2)
        peak_pitch = max(peak_pitch, abs(theta))
        peak_rate = max(peak_rate, abs(rate))
        if not (speed2 <= 3600.0 and abs(theta) <= 6.0):
            squares = math.inf
            break
        if step % 81 == 0:
            node = nodes[step // 81]
            squares += ((math.cos(theta / 2) - node[0]) ** 2 + (math.sin(theta / 2) - node[1]) ** 2
                        + (v_n - node[2]) ** 2 + (v_d - node[3]) ** 2 + (rate - node[4]) ** 2)
        if step == steps:
            break
        e_n, e_d = setpoints[step, 0] - v_n, setpoints[step, 1] - v_d
        a_n = k[5] * e_n + i_n
        up = gravity - (k[3] * e_d + i_d)
        up_s = clip(up, 0.0, up_max)
        m = min(up_s * tan_tilt, math.sqrt(max(up_max * up_max - up_s * up_s, 0.0)))
        a_ns = clip(a_n, -m, m)
        theta_c = 0.0 if up_s <= 1e-9 and a_ns == 0.0 else math.atan2(-a_ns, up_s)
        if not ((up > up_max and e_d < 0.0) or (up < 0.0 and e_d > 0.0)):
            i_d += k[4] * e_d * dt
        if not (a_n != a_ns and a_n * e_n > 0.0):
            i_n += k[6] * e_n * dt
        error = theta_c - theta
        error = error - 2 * math.pi if error >= math.pi else error + 2 * math.pi if error < -math.pi else error
        e_q = clip(k[2] * error, -rate_max, rate_max) - rate
        wanted = k[0] * e_q + i_q
        i_q = clip(i_q + k[1] * e_q * dt, -10.0, 10.0)
        d = clip(inertia * wanted / (4 * arm), -limit / 2, limit / 2)
        b = min(mass * up_s / 4, limit - abs(d))
        b = max(b, abs(d))
        front_1, rear_1 = clip(b + d, 0.0, limit), clip(b - d, 0.0, limit)
        front_m, rear_m = 0.5 * (front + front_1), 0.5 * (rear + rear_1)
        a1, b1, c1, d1 = derivative(v_n, v_d, theta, rate, front, rear, body, splines)
        h = dt / 2
        a2, b2, c2, d2 = derivative(v_n + h * a1, v_d + h * b1, theta + h * c1, rate + h * d1, front_m, rear_m, body, splines)
        a3, b3, c3, d3 = derivative(v_n + h * a2, v_d + h * b2, theta + h * c2, rate + h * d2, front_m, rear_m, body, splines)
        a4, b4, c4, d4 = derivative(v_n + dt * a3, v_d + dt * b3, theta + dt * c3, rate + dt * d3, front_1, rear_1, body, splines)
        v_n += dt / 6 * (a1 + 2 * (a2 + a3) + a4)
        v_d += dt / 6 * (b1 + 2 * (b2 + b3) + b4)
        theta += dt / 6 * (c1 + 2 * (c2 + c3) + c4)
        rate += dt / 6 * (d1 + 2 * (d2 + d3) + d4)
        front, rear = front_1, rear_1
    j_tpf = max(math.sqrt(peak_speed2) / 12, peak_pitch / math.radians(45), peak_rate / math.radians(90))
    rms = math.sqrt(squares / nodes.shape[0])
    return (rms if rms < math.inf else 1000.0), j_tpf


@njit(parallel=True)
def fly_all(gains, states, body, splines, setpoints, nodes, dt):
    out = np.empty((gains.shape[0], 2))
    for i in prange(gains.shape[0]):
        out[i] = fly(gains[i], states[i], body, splines, setpoints, nodes, dt)
    return out


def samara(program, kind, n, rounds):
    """Seconds of the wall per round, CPU seconds per round, costs of the first flights."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    text = subprocess.run([program, kind, str(n), str(THREADS), str(rounds)], capture_output=True, text=True, check=True).stdout
    cpu = (resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before) / rounds
    lines = [line.split() for line in text.splitlines()]
    return ([float(x[1]) for x in lines if x[0] == "seconds"], cpu,
            np.array([[float(x[1]), float(x[2])] for x in lines if x[0] == "cost"]))


def main(program):
    numba.set_num_threads(THREADS)
    body, splines, setpoints, nodes, dt = problem()
    body[7] = static_thrust()
    arguments = (body, splines, setpoints, nodes, dt)
    gains, states = flights(FLIGHTS)
    ours = samara(program, "ideal", FLIGHTS, 1)[2]
    theirs = fly_all(gains, states, *arguments)
    flown = (ours[:, 0] < 1000) & (theirs[:, 0] < 1000)
    difference = np.abs(ours - theirs)[flown]
    print(f"costs of {FLIGHTS} flights: {flown.sum()} flown by both, {np.sum(ours[:, 0] >= 1000)} and {np.sum(theirs[:, 0] >= 1000)} "
          f"diverged; difference at most {difference.max():.1e}, median {np.median(difference):.1e}")
    many = FLIGHTS * GENERATIONS // 10
    gains, states = flights(many)
    rows = []
    for _ in range(ROUNDS):
        start, cpu = time.perf_counter(), time.process_time()
        fly_all(gains, states, *arguments)
        peer = (time.perf_counter() - start, time.process_time() - cpu)
        wall, used, _ = samara(program, "ideal", many, 3)
        rows.append((peer[0], peer[1], statistics.median(wall), used))
    median = [statistics.median(column) for column in zip(*rows)]
    ratio = sorted(row[1] / row[3] for row in rows)
    print(f"{many} flights, {THREADS} threads, median of {ROUNDS}; load {os.getloadavg()[0]:.1f}")
    print("            wall s    CPU s   CPU us per flight   ns per step")
    for name, wall, used in (("numba", *median[:2]), ("samara", *median[2:])):
        print(f"{name:10s} {wall:7.3f}  {used:7.3f}   {used / many * 1e6:17.1f}   {used / many / len(setpoints) * 1e9:11.2f}")
    print(f"CPU time, numba over samara: {statistics.median(ratio):.2f} (from {ratio[0]:.2f} to {ratio[-1]:.2f})")
    wall, used, _ = samara(program, "actuator", 2000, 3)
    print(f"samara, actuator plant: {used / 2000 * 1e6:.1f} CPU us per flight, {used / 2000 / len(setpoints) * 1e9:.2f} ns per step")


def static_thrust():
    """Thrust of Titan's rotor at full speed in still air [N], from its table."""
    vehicle = read("params", "vehicles", "titan.json")
    table = vehicle["rotor"]["table"]
    path = os.path.join(REPOSITORY, "params", "vehicles", table["file"])
    rows = np.genfromtxt(path, delimiter=",", names=True)
    omega, airspeed, angle, thrust = (rows[name] for name in rows.dtype.names[:4])
    still = (airspeed == 0) & (angle == 0)
    full = vehicle["motor"]["esc_dc"]["omega_max_rad_s"]
    return float(np.interp(full, omega[still], thrust[still]))


if __name__ == "__main__":
    main(sys.argv[1])
