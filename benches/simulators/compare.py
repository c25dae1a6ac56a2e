"""CPU time of a step of 4 ms of a body in six degrees of freedom: RotorPy, JSBSim, samara, in turns in one run.

    benches/simulators/compare.py PROGRAM

PROGRAM is the example `steps`. Each is timed by the CPU time of more steps less that of few, so that what it does
before is not counted; the table has the medians of the rounds. What a step does differs: RotorPy's quadrotor has
motors of the first order, rotor drag and scipy's RK45 with error control; JSBSim's `ball` is a rigid body with drag
over the rotating Earth, its `c172p` an aeroplane with tables, engine and flight controls; samara's quadrotor has
motors, speed controllers, rotors and airframe from tables.
"""

import contextlib
import io
import pathlib
import resource
import statistics
import subprocess
import sys
import tempfile
import time

import jsbsim
import numpy
from rotorpy.vehicles.hummingbird_params import quad_params
from rotorpy.vehicles.multirotor import Multirotor

STEP_S = 0.004
ROUNDS = 7


def rotorpy():
    vehicle = Multirotor(quad_params)
    state = vehicle.initial_state
    hover = {"cmd_motor_speeds": numpy.full(4, 1000.0)}

    def step(count):
        nonlocal state
        begun = time.process_time()
        for _ in range(count):
            state = vehicle.step(state, hover, STEP_S)
        return time.process_time() - begun

    return step


def of_jsbsim(aircraft):
    simulation = jsbsim.FGFDMExec(None)
    simulation.set_debug_level(0)
    with contextlib.redirect_stdout(io.StringIO()):
        simulation.load_model(aircraft)
    simulation.set_dt(STEP_S)
    simulation["ic/h-sl-ft"] = 30000
    simulation.run_ic()

    def step(count):
        begun = time.process_time()
        for _ in range(count):
            simulation.run()
        return time.process_time() - begun

    return step


def of_samara(program, plant):
    def step(count):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([program, plant, str(count)], check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime

    return step


def main(program):
    simulators = {
        "RotorPy 3.0.0, quadrotor": (rotorpy(), 2_000),
        "JSBSim 1.3.3, ball": (of_jsbsim("ball"), 20_000),
        "JSBSim 1.3.3, c172p": (of_jsbsim("c172p"), 20_000),
        "samara, quadrotor, thrust follows at once": (of_samara(program, "ideal"), 2_000_000),
        "samara, quadrotor with motors": (of_samara(program, "actuator"), 2_000_000),
    }
    steps = {name: [] for name in simulators}
    for _ in range(ROUNDS):
        for name, (step, count) in simulators.items():
            steps[name].append((step(count + count // 10) - step(count // 10)) / count)
    medians = {name: statistics.median(times) for name, times in steps.items()}
    least = medians["samara, quadrotor with motors"]
    for name, median in medians.items():
        print(f"{name:44s} {1e6 * median:9.3f} us a step {median / least:9.2f}")


if __name__ == "__main__":
    # JSBSim's `ball` writes BallOut.csv where it is flown.
    program = str(pathlib.Path(sys.argv[1]).absolute())
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        main(program)
