"""What a plan may be asked for (`plan.peak`, `plan.motion`, ..), by CasADi and IPOPT, beside samara's own planner.

The NLPs are written from docs/plan.md, with the vehicle's dynamics of compare.py: thirteen states are not needed here, since
IPOPT takes the peak, the altitude lost and the horizon as they are - the peak and the horizon as variables, the altitude as the
collocation's own sum. Each problem is the mission of the paper with some keys of its plan replaced, given to both; the costs must
agree to 1e-6.

    benches/casadi/run demands            (from the project's folder)
    python benches/casadi/demands.py PROGRAM --write   also writes tests/data/casadi_demands.json, which a test holds
"""

import json
import math
import os
import subprocess
import sys
import tempfile

import casadi as ca
import numpy as np
from compare import MISSION, REPOSITORY, dynamics, read

WEIGHTS = [1, 1, 1, 1, 1, 1, 1, 10, 10, 10]
PROBLEMS = {
    "as the paper": {},
    "weights of the final state": {"final_cost_state": [0, 0, 0, 0, 100, 1, 100, 10, 10, 10]},
    "peak beside the cost": {"peak": {"weight": 200.0}},
    "peak beside the cost about the trim": {"peak": {"weight": 500.0}, "cost_input_reference": "trim"},
    "speed": {"motion": {"speed_m_s": 6.45}},
    "pitch and pitch rate": {"motion": {"pitch_deg": 18.0, "pitch_rate_deg_s": 12.0}},
    "velocities": {"motion": {"v_north_m_s": [-0.2, 3.98], "v_down_m_s": [2.0, 6.5]}},
    "altitude lost": {"motion": {"altitude_lost_m": 132.0}},
    "rotor acceleration": {"rotor_acceleration_rad_s2": 12.0},
    "rotor acceleration beside a limit": {"rotor_acceleration_rad_s2": 20.0, "thrust_slew_n_s": 60.0},
    # So close that more constraints are active than there is freedom left: their multipliers have no single value.
    **{f"pitch within {deg} deg": {"motion": {"pitch_deg": deg}} for deg in (2.0, 4.0, 5.0, 6.0, 7.0, 8.0)},
    **{f"pitch rate within {deg} deg/s": {"motion": {"pitch_rate_deg_s": deg}} for deg in (0.5, 1.0)},
    **{
        f"pitch within {deg} deg, to an end": {"motion": {"pitch_deg": deg}, "terminal_tolerance_m_s": 0.04}
        for deg in (6.0, 7.0, 8.0)
    },
    "pitch rate within 1.0 deg/s, to an end": {"motion": {"pitch_rate_deg_s": 1.0}, "terminal_tolerance_m_s": 0.04},
    "pitch within 8.0 deg, rate within 1.0 deg/s": {"motion": {"pitch_deg": 8.0, "pitch_rate_deg_s": 1.0}},
    # On a vehicle with known blades.
    "out of the vortex ring": {"avoid_vortex_ring": {"share": 1.0, "from_s": 6.0, "to_s": 28.0}, "vehicle": "titan_bemt"},
    "free horizon": {"free_horizon": {"least_s": 10.0, "greatest_s": 60.0, "cost_per_s": 0.5}, "terminal_tolerance_m_s": 0.05},
    "several": {
        "peak": {"weight": 200.0},
        "motion": {"pitch_deg": 22.0, "altitude_lost_m": 134.0},
        "final_cost_state": [1, 1, 1, 1, 10, 10, 10, 10, 10, 10],
        "cost_input_reference": "trim",
    },
}
RING_MIDDLE, RING_HALF, RING_EDGEWISE = -0.975, 0.525, 0.95


def angles(q):
    """Sines and the common cosine of pitch and roll, each times the square of the quaternion's length."""
    q0, q1, q2, q3 = ca.vertsplit(q)
    upright = q0**2 - q1**2 - q2**2 + q3**2
    return ca.atan2(2 * (q0 * q2 - q1 * q3), upright), ca.atan2(2 * (q0 * q1 + q2 * q3), upright)


def solve(mission, vehicle, rotor):
    """Cost of the mission's plan."""
    site, plan, limits, parachute = mission["site"], mission["plan"], mission["limits"], mission["parachute"]
    f = dynamics(vehicle, site)
    nodes, rotors = plan["nodes"], len(vehicle["rotors"])
    reference = plan["x_ss"]
    x_ss = np.array(reference["q_ned_from_body"] + reference["v_ned_m_s"] + reference["omega_body_rad_s"])
    x_first = np.array([1, 0, 0, 0, 0, 0, parachute["descent_m_s"] + site["gravity_m_s2"] * parachute["delay_s"], 0, 0, 0])
    hover = vehicle["mass_kg"] * site["gravity_m_s2"] / rotors
    u_ref = ca.DM([rotor["trim_n"][i] for i in range(rotors)] if plan["cost_input_reference"] == "trim" else [0] * rotors)
    x = [ca.SX.sym(f"x{k}", 10) for k in range(nodes)]
    u = [ca.SX.sym(f"u{k}", rotors) for k in range(nodes)]
    peak, horizon = ca.SX.sym("peak"), ca.SX.sym("horizon")
    free = plan.get("free_horizon")
    total = horizon if free else plan["horizon_s"]
    dt, nominal_dt = total / (nodes - 1), plan["horizon_s"] / (nodes - 1)
    rows, low, high = [], [], []

    def hold(value, least, greatest):
        value = ca.vertcat(value)
        rows.append(value)
        low.extend([least] * value.shape[0])
        high.extend([greatest] * value.shape[0])

    # Cost.
    q, r = ca.DM(plan["cost_state"]), plan["cost_input_per_n2"]
    s = ca.DM(plan.get("final_cost_state", plan["cost_state"]))
    stage = [ca.dot(q, (a - x_ss) ** 2) + r * ca.sumsqr(b - u_ref) for a, b in zip(x, u)]
    cost = ca.dot(s, (x[-1] - x_ss) ** 2)
    cost += sum(dt / 2 * (stage[k] + stage[k + 1]) for k in range(nodes - 1))
    if "peak" in plan:
        cost = (0 if plan["peak"].get("alone") else cost) + plan["peak"]["weight"] * peak
    if free:
        cost += free["cost_per_s"] * horizon

    # Dynamics, and what holds along the path.
    rates = [f(a, b) for a, b in zip(x, u)]
    middles, altitude = [], 0
    places = []
    for k in range(nodes - 1):
        middle = (x[k] + x[k + 1]) / 2 + dt / 8 * (rates[k] - rates[k + 1])
        u_c = (u[k] + u[k + 1]) / 2
        rate = f(middle, u_c)
        hold(x[k] - x[k + 1] + dt / 6 * (rates[k] + 4 * rate + rates[k + 1]), 0, 0)
        step = (u[k + 1] - u[k]) / dt
        slew = plan.get("thrust_slew_n_s")
        if slew is not None:
            hold(step, -slew, slew)
        limit = plan.get("rotor_acceleration_rad_s2")
        if limit is not None:
            hold(step**2 - 4 * limit**2 * rotor["per_speed2"] * u_c, -ca.inf, 0)
        # The altitude at the midpoint and the node, as Hermite and Simpson have it.
        before = altitude
        altitude = before + dt / 6 * (x[k][6] + 4 * middle[6] + x[k + 1][6])
        half = (before + altitude) / 2 + dt / 8 * (x[k][6] - x[k + 1][6])
        places.append(((k + 0.5) * nominal_dt, middle, u_c, half))
        places.append(((k + 1) * nominal_dt, x[k + 1], u[k + 1], altitude))
    motion, ring = plan.get("motion", {}), plan.get("avoid_vortex_ring")
    for t, a, b, lost in places:
        speed, (pitch, roll) = ca.sumsqr(a[4:7]), angles(a[:4])
        shares = []
        if "peak" in plan:
            scale = [limits["speed_m_s"], math.radians(limits["pitch_deg"]), math.radians(limits["pitch_rate_deg_s"])]
            shares.append((scale, peak))
        scale = [
            motion.get("speed_m_s"),
            math.radians(motion["pitch_deg"]) if "pitch_deg" in motion else None,
            math.radians(motion["pitch_rate_deg_s"]) if "pitch_rate_deg_s" in motion else None,
        ]
        shares.append((scale, 1))
        for (v, angle, turn), share in shares:
            if v:
                hold(speed / v**2 - share**2, -ca.inf, 0)
            for value in (pitch, roll):
                if angle:
                    hold(ca.vertcat(value / angle - share, -value / angle - share), -ca.inf, 0)
            for value in (a[7], a[8]):
                if turn:
                    hold(ca.vertcat(value / turn - share, -value / turn - share), -ca.inf, 0)
        for key, i in (("v_north_m_s", 4), ("v_east_m_s", 5), ("v_down_m_s", 6)):
            if key in motion:
                hold(a[i], *motion[key])
        if "altitude_lost_m" in motion:
            hold(lost, -ca.inf, motion["altitude_lost_m"])
        if ring and ring.get("from_s", 0) <= t <= ring.get("to_s", math.inf):
            q0, q1, q2, q3 = ca.vertsplit(a[:4])
            v_air = a[4:7] - ca.DM(site["wind_ned_m_s"])
            down = ca.vertcat(2 * (q1 * q3 + q0 * q2), 2 * (q2 * q3 - q0 * q1), q0**2 - q1**2 - q2**2 + q3**2)
            climb = -ca.dot(down, v_air)  # Rotors push along -z of the body.
            for i in range(rotors):
                v_h2 = (b[i] + 1e-3 * hover) * rotor["v_h2_per_n"]
                edge = (ca.sumsqr(v_air) - climb**2) / RING_EDGEWISE**2
                along = ((climb - RING_MIDDLE * ca.sqrt(v_h2)) / RING_HALF) ** 2
                hold(ring.get("share", 1) ** 2 * v_h2 - edge - along, -ca.inf, 0)
    tolerance = plan.get("terminal_tolerance_m_s")
    guess, least, greatest = [], [], []
    for k in range(nodes):
        t = k * nominal_dt
        guess += list(x_first + (x_ss - x_first) * min(t / 8.0, 1.0)) + [min(0.8 * hover, 36.0 * t)] * rotors
        inf = [ca.inf] * 10
        if k == 0:
            least += list(x_first) + [0] * rotors
            greatest += list(x_first) + [0] * rotors
        else:
            lo, hi = [-i for i in inf], list(inf)
            if k == nodes - 1 and tolerance:
                for i in range(3):
                    lo[4 + i], hi[4 + i] = x_ss[4 + i] - tolerance, x_ss[4 + i] + tolerance
            least += lo + [0] * rotors
            greatest += hi + [plan["thrust_max_n"]] * rotors
    variables = [part for pair in zip(x, u) for part in pair]
    if "peak" in plan:
        first = max(np.linalg.norm(x_first[4:7]) / limits["speed_m_s"], 0)
        variables, guess = [*variables, peak], [*guess, 1.0]
        least, greatest = [*least, first], [*greatest, ca.inf]
    if free:
        variables, guess = [*variables, horizon], [*guess, plan["horizon_s"]]
        least, greatest = [*least, free["least_s"]], [*greatest, free["greatest_s"]]
    nlp = {"x": ca.vertcat(*variables), "f": cost, "g": ca.vertcat(*rows)}
    options = {"tol": 1e-10, "constr_viol_tol": 1e-11, "bound_relax_factor": 0, "max_iter": 2000, "print_level": 0, "sb": "yes"}
    solver = ca.nlpsol("plan", "ipopt", nlp, {"print_time": False, "ipopt": options})
    result = solver(x0=guess, lbx=least, ubx=greatest, lbg=low, ubg=high)
    stats = solver.stats()
    out = {"success": bool(stats["success"]), "iterations": stats["iter_count"], "objective": float(result["f"])}
    if "peak" in plan:
        out["peak"] = float(result["x"][-2 if free else -1])
    if free:
        out["horizon_s"] = float(result["x"][-1])
    return out


def main():
    program = sys.argv[1]
    mission = read(MISSION)
    vehicle_path = os.path.join(os.path.dirname(MISSION), mission["vehicle"])
    mission["gains"] = os.path.abspath(os.path.join(os.path.dirname(MISSION), mission["gains"]))
    only = [a for a in sys.argv[2:] if not a.startswith("--")]
    found, worst = {}, 0.0
    print(f"{'':40}{'samara':>18}{'IPOPT':>18}{'apart':>10}{'iterations':>14}")
    for name, keys in PROBLEMS.items():
        if only and name not in only:
            continue
        changed = json.loads(json.dumps(mission))
        keys = dict(keys)
        flown = os.path.join(os.path.dirname(vehicle_path), keys.pop("vehicle", "titan") + ".json")
        changed["vehicle"] = os.path.abspath(flown)
        changed["plan"].update(keys)
        if "rotor_acceleration_rad_s2" in keys and "thrust_slew_n_s" not in keys:
            del changed["plan"]["thrust_slew_n_s"]
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "mission.json")
            with open(path, "w", encoding="utf-8") as file:
                json.dump(changed, file)
            given = subprocess.run([program, "plan", path, "--json", "--out", folder], capture_output=True, text=True, check=False)
            if not given.stdout:
                print(f"{name:40} {given.stderr}")
                continue
            ours = json.loads(given.stdout)
        theirs = solve(changed, read(flown), rotor_numbers(read(flown), changed, flown))
        apart = abs(ours["objective"] / theirs["objective"] - 1)
        state = "" if ours["status"] == "converged" and theirs["success"] else f"  {ours['status']}, {theirs['success']}"
        iterations = f"{ours['iterations']}/{theirs['iterations']}"
        print(f"{name:40}{ours['objective']:18.9f}{theirs['objective']:18.9f}{apart:10.1e}{iterations:>14}{state}")
        found[name] = {"vehicle": os.path.basename(flown), "plan": keys, "objective": theirs["objective"]}
        worst = max(worst, apart)
    if "--write" in sys.argv:
        with open(os.path.join(REPOSITORY, "tests", "data", "casadi_demands.json"), "w", encoding="utf-8") as file:
            json.dump(found, file, indent=1)
            file.write("\n")
    if worst > 1e-6:
        sys.exit(f"costs are {worst:.1e} apart, 1e-6 is allowed")


def rotor_numbers(vehicle, mission, vehicle_path):
    """The trim's thrusts at the target, thrust over speed squared at rest at the motor's greatest speed, v_h^2 over thrust."""
    site, blades = mission["site"], vehicle["rotor"].get("blade_element")
    table = vehicle["rotor"].get("table", blades)
    f = dynamics(vehicle, site)
    # In the plane, front and rear rotors alike: pitch and two thrusts of a state that does not change.
    unknown = ca.SX.sym("unknown", 3)
    half = unknown[0] / 2
    state = ca.vertcat(ca.cos(half), 0, ca.sin(half), 0, ca.DM(mission["target_v_ned_m_s"]), 0, 0, 0)
    front = [rotor["position_body_m"][0] > 0 for rotor in vehicle["rotors"]]
    rate = f(state, ca.vertcat(*(unknown[1] if ahead else unknown[2] for ahead in front)))
    hover = vehicle["mass_kg"] * site["gravity_m_s2"] / len(front)
    find = ca.rootfinder("trim", "newton", {"x": unknown, "g": ca.vertcat(rate[4], rate[6], rate[8])}, {"abstol": 1e-13})
    trim = np.array(find(x0=[0.0, hover, hover], p=[])["x"]).ravel()
    numbers = {
        "trim_n": [trim[1] if ahead else trim[2] for ahead in front],
        "v_h2_per_n": 1 / (2 * site["density_kg_m3"] * math.pi * table["radius_m"] ** 2),
    }
    if blades:
        return numbers
    # Trilinear in speed, airspeed and flow angle: at rest only the speed counts.
    with open(os.path.join(os.path.dirname(vehicle_path), table["file"]), encoding="utf-8") as file:
        lines = [line.strip().split(",") for line in file if line[0] not in "#" and not line[0].isalpha()]
    still = sorted({float(row[0]): float(row[3]) for row in lines if float(row[1]) == 0}.items())
    omega = vehicle["motor"]["esc_dc"]["omega_max_rad_s"]
    thrust = np.interp(omega, *zip(*still)) * site["density_kg_m3"] / table["density_kg_m3"]
    return {**numbers, "per_speed2": float(thrust) / omega**2}


if __name__ == "__main__":
    main()
