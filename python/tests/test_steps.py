"""Drops in steps: a vehicle, and environments of Gymnasium."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import Any

import gymnasium
import numpy as np
import pytest
import samara_tpf as samara
from gymnasium.utils.env_checker import check_env
from samara_tpf.gym import Action, DropEnv, DropVectorEnv


@pytest.mark.parametrize("mission", ["x500_drop", "titan_drop"])
def test_reference_the_same_commands_give_the_bits_of_a_drop(mission: str) -> None:
    drop = samara.drop(mission)
    flight = drop.flight
    vehicle = samara.Vehicle(mission)
    throttle = flight.stacked(*(f"throttle_{i + 1}" for i in range(vehicle.rotors)))
    for k in range(len(throttle) - 1):
        if vehicle.state.phase == "hanging" and flight["phase"][k] != "hanging":
            vehicle.release()
        assert vehicle.state.phase == flight["phase"][k]
        vehicle.step(throttle[k])
    assert vehicle.over
    stepped = vehicle.judge()
    assert stepped.sentence == drop.sentence and stepped.j_tpf == drop.j_tpf
    assert stepped.verdict["autopilot"] is None and len(stepped.trajectory) == 0
    for name, wanted in flight.items():
        # Nobody asks for a velocity.
        if not name.endswith("_sp_m_s"):
            assert np.array_equal(stepped.flight[name], wanted, equal_nan=wanted.dtype.kind == "f"), name
    state = vehicle.state
    last = flight.stacked("north_m", "east_m", "down_m", "vn_m_s", "ve_m_s", "vd_m_s", "q0", "q1", "q2", "q3")[-1]
    assert np.concatenate([state.position_ned_m, state.velocity_ned_m_s, state.q_ned_from_body]).tolist() == last.tolist()
    assert state.rotor_speed_rad_s[0] == flight["rotor_speed_1_rad_s"][-1] and vehicle.j_state == flight["j_state"][-1]
    assert (state.time_s, state.time_powered_s) == (flight["t_s"][-1], flight["t_powered_s"][-1])
    with pytest.raises(RuntimeError, match="the mission is over, after .* s: `reset`"):
        vehicle.step(throttle[0])


def test_a_vehicle_begins_anew_by_its_seed() -> None:
    def flown(vehicle: samara.Vehicle) -> list[Any]:
        vehicle.fall()
        seen: list[Any] = [vehicle.state.phase, [words for _, words in vehicle.events]]
        for _ in range(200):
            vehicle.step((0.6, 0.6, 0.6, 0.6))
            seen.append({name: reading.tolist() for name, reading in vehicle.sensors().items()})
        return [*seen, vehicle.state.velocity_ned_m_s.tolist()]

    vehicle = samara.Vehicle("x500_drop", seed=5)
    arrays = id(vehicle.state.velocity_ned_m_s)
    first = flown(vehicle)
    assert first[0] == "powered" and first[1] == ["armed", "released by command", "rotors free"]
    vehicle.reset(6)
    assert vehicle.state.time_s == 0.0 and vehicle.state.phase == "hanging" and np.isnan(vehicle.state.time_powered_s)
    assert flown(vehicle) != first
    vehicle.reset(5)
    assert flown(vehicle) == first == flown(samara.Vehicle("x500_drop", seed=5))
    assert id(vehicle.state.velocity_ned_m_s) == arrays and "powered" in repr(vehicle)


def test_closed_form_the_loads_are_what_accelerates() -> None:
    vehicle = samara.Vehicle("x500_drop")
    vehicle.fall()
    for _ in range(100):
        vehicle.step(np.array([0.7, 0.6, 0.6, 0.7]))
    w, x, y, z = vehicle.state.q_ned_from_body
    to_ned = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    loads = vehicle.loads
    mass_kg = loads["gravity_force_ned_n"][2] / 9.80665
    force = to_ned @ (loads["rotor_force_body_n"] + loads["aero_force_body_n"]) + loads["gravity_force_ned_n"]
    assert np.allclose(force / mass_kg, loads["acceleration_ned_m_s2"], atol=1e-3)
    assert loads["thrust_n"].shape == (4,) and loads["bus"][0] > 10.0
    # The fields cancel in free flight: what the accelerometer reads is what is not gravity.
    still = samara.Vehicle(samara.mission("x500_drop") | {"sensors": {}})
    still.fall()
    still.step((0.5,) * 4)
    assert np.allclose(
        still.sensors()["accelerometer_body_m_s2"],
        still.loads["rotor_force_body_n"] / mass_kg + still.loads["aero_force_body_n"] / mass_kg,
        atol=1e-3,
    )


@pytest.mark.parametrize("action", ["thrust", "rate", "velocity"])
def test_environments_pass_gymnasiums_own_check(action: Action) -> None:
    env = gymnasium.make("samara/Drop-v0", mission="x500_drop", action=action, duration_s=0.5)
    check_env(env.unwrapped, skip_render_check=True)
    many = gymnasium.make_vec("samara/Drop-v0", num_envs=3, mission="x500_drop", action=action, duration_s=0.1)
    observed, _ = many.reset(seed=1)
    assert many.observation_space.contains(observed)


@pytest.mark.parametrize("action", ["thrust", "rate", "velocity"])
def test_reference_flights_side_by_side_are_flights_alone(action: Action) -> None:
    rng = np.random.default_rng(1)
    many = DropVectorEnv(11, "x500_drop", action=action, duration_s=0.4)
    alone = [DropEnv("x500_drop", action=action, duration_s=0.4) for _ in range(11)]
    observed, _ = many.reset(seed=7)
    for k, env in enumerate(alone):
        # Episode k after a seed is its trial k.
        first = [env.reset(seed=7)[0], *(env.reset()[0] for _ in range(k))][-1]
        assert first.tolist() == observed[k].tolist()
    for step in range(100):
        actions = rng.uniform(-1.0, 1.0, many.action_space.shape).astype(np.float32)
        observed, rewards, ended, truncated, _ = many.step(actions)
        for k, env in enumerate(alone):
            one, reward, _, over, _ = env.step(actions[k])
            assert (one.tolist(), reward, over) == (observed[k].tolist(), rewards[k], truncated[k])
        assert not ended.any() and truncated.all() == (step == 99)
    # The step after the last one begins the next episodes: trials 11 to 21.
    observed, rewards, ended, truncated, _ = many.step(actions)
    assert not (rewards.any() or ended.any() or truncated.any())
    assert observed[0].tolist() == alone[10].reset()[0].tolist()


def test_reference_an_episode_begins_as_a_trial_of_assess() -> None:
    trials = samara.assess("x500_drop", trials=8, seed=9).optimal
    observed, _ = DropVectorEnv(8, "x500_drop").reset(seed=9)
    pitch = np.radians(trials["pitch_deg"])
    down = np.column_stack([-np.sin(pitch), np.zeros(8), np.cos(pitch)])
    assert np.allclose(observed[:, 6:9], down, atol=1e-6)
    assert np.allclose(np.linalg.norm(observed[:, 3:6], axis=1), np.hypot(trials["vn_m_s"], trials["vd_m_s"]), atol=1e-5)
    assert np.allclose(np.degrees(observed[:, 10]), trials["pitch_rate_deg_s"], atol=1e-4)


def test_environments_fly_beside_each_other_in_threads() -> None:
    def flown(_: int) -> list[float]:
        env = DropVectorEnv(16, "x500_drop", duration_s=0.4)
        env.reset(seed=2)
        worth: list[float] = [env.step(np.full((16, 4), 0.2))[1].tolist() for _ in range(100)][-1]
        return worth

    with ThreadPoolExecutor(4) as threads:
        results = list(threads.map(flown, range(4)))
    assert results[1:] == results[:-1]


def test_closed_form_rewards_are_the_cost_of_the_state() -> None:
    env = DropEnv("x500_drop", velocity_cost_s_m=0.3)
    env.reset(seed=1)
    for _ in range(50):
        observed, reward, _, _, _ = env.step([0.5, 0.4, 0.5, 0.4])
    limits = samara.mission("x500_drop")["limits"]
    speed = np.linalg.norm(observed[3:6]) / limits["speed_m_s"]
    pitch = np.degrees(np.arcsin(-observed[6])) / limits["pitch_deg"]
    roll = np.degrees(np.arctan2(observed[7], observed[8])) / limits["pitch_deg"]
    rates = np.abs(np.degrees(observed[9:11])) / limits["pitch_rate_deg_s"]
    j_state = max(speed, abs(pitch), abs(roll), *rates)
    assert reward == pytest.approx(-0.004 * (j_state + 0.3 * np.linalg.norm(observed[:3])), rel=1e-5)
