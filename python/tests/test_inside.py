"""What is inside a mission: against closed forms, the program's own answers, and flights."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import samara_tpf as samara
from samara_tpf import inside


def test_a_loop_s_response_has_the_margins_that_are_said() -> None:
    loops = inside.loops("x500_drop")
    assert loops.states == ["release", "plan's peak", "target"] and len(loops) == 27
    for loop in loops.values():
        omega = np.geomspace(1e-3, np.pi / loop.period_s, 4000)
        response = loop.response(omega)
        assert abs(np.abs(1 + response).min() / loop.modulus - 1) < 2e-3, loop
        closed = np.abs(np.linalg.eigvals(loop.a + np.outer(loop.b, loop.c))).max()
        assert (closed < 1) == loop.stable, loop
        if loop.crossover_rad_s is not None:
            assert abs(abs(loop.response(loop.crossover_rad_s)) - 1) < 1e-6, loop
    assert "pitch rate" in loops._repr_html_() and loops.table["modulus"].shape == (27,)


def test_loops_of_the_vehicle_as_it_is_known_are_among_those_that_check_looks_at() -> None:
    loops = inside.loops("titan_drop")
    for found in samara.check("titan_drop").report["loops"]["each"]:
        known = [loops[found["loop"], state].modulus for state in loops.states]
        assert found["modulus"] <= min(known) + 1e-9


def test_multipliers_are_what_a_bound_costs() -> None:
    """The envelope theorem: dJ/d(bound) is the sum of its multipliers."""
    document = samara.mission("x500_drop")
    most = document["plan"]["thrust_max_n"]

    def planned(share: float) -> samara.Plan:
        document["plan"]["thrust_max_n"] = share * most
        return samara.plan(document, tolerance=1e-9)

    plan = planned(1.0)
    found = plan.multipliers
    n, rotors = plan.thrust_n.shape
    assert found["thrust_most"].shape == (n, rotors) and found["change_most"].shape == (n - 1, rotors)
    assert found["defect"].shape[0] == n - 1 and found["state_most"].shape[0] == n
    up, down = (planned(share).report["objective"] for share in (1.001, 0.999))
    slope = (up - down) / (0.002 * most)
    assert slope < 0 and abs(-found["thrust_most"].sum() / slope - 1) < 1e-4
    # A bound that is not reached costs nothing.
    slack = plan.thrust_n < 0.98 * most
    assert slack.any() and found["thrust_most"][slack].max() < 1e-4 * found["thrust_most"].max()


def test_a_rotor_alone() -> None:
    """The x500's is ``k omega^2`` with density; the lander's loses thrust in climb and is asked at once for a map."""
    omega = np.array([100.0, 200.0, 400.0])
    thrust = inside.rotor("x500_drop", omega_rad_s=omega)["thrust_n"]
    assert np.allclose(thrust / omega**2, thrust[0] / omega[0] ** 2, rtol=1e-12)
    density = samara.mission("x500_drop")["site"]["density_kg_m3"]
    half = inside.rotor("x500_drop", omega_rad_s=omega, density_kg_m3=0.5 * density)["thrust_n"]
    assert np.allclose(half, 0.5 * thrust, rtol=1e-12)
    map_n = inside.rotor("titan_drop", omega_rad_s=omega[:, np.newaxis] / 4, climb_m_s=[0.0, 5.0, 10.0])["thrust_n"]
    assert map_n.shape == (3, 3) and (np.diff(map_n, axis=1) < 0).all()


def test_the_wind_of_a_flight_is_the_one_that_it_met() -> None:
    """Rows of a flight are its steps, from the hang on."""
    flight = samara.drop("x500_drop").flight
    powered = np.flatnonzero(np.isfinite(flight["t_powered_s"]))[0]
    found = inside.wind(
        "x500_drop",
        time_s=flight["t_s"] - (flight["t_s"][powered] - flight["t_powered_s"][powered]),
        position_ned_m=flight.stacked("north_m", "east_m", "down_m"),
        velocity_ned_m_s=flight.stacked("vn_m_s", "ve_m_s", "vd_m_s"),
    )
    met = flight.stacked("wind_n_m_s", "wind_e_m_s", "wind_d_m_s")
    assert np.abs(met).max() > 0.5
    # The last row is no step.
    assert np.abs(found - met)[:-1].max() < 1e-9


def test_the_wind_without_weather_is_the_site_s() -> None:
    document = samara.mission("titan_paper")
    document["site"]["wind_ned_m_s"] = [1.0, 2.0, 0.0]
    found = inside.wind(document, time_s=np.linspace(0, 5, 11))
    assert found.shape == (11, 3) and (found == [1.0, 2.0, 0.0]).all()


def still(mission: str, seed: int | None = None, yaw_rad: float = 0.0) -> samara.Columns:
    """What the sensors of a vehicle read that stands level on Earth."""
    turned = [np.cos(yaw_rad / 2), 0.0, 0.0, np.sin(yaw_rad / 2)]
    return inside.sensors(
        mission,
        time_s=np.arange(500) * 0.004,
        q_ned_from_body=np.tile(turned, (500, 1)),
        specific_force_body_m_s2=[0.0, 0.0, -9.80665],
        seed=seed,
    )


def test_ideal_sensors_read_the_truth_and_others_their_noise() -> None:
    ideal = still("titan_paper")
    assert (ideal["az_m_s2"] == -9.80665).all() and (ideal["p_rad_s"] == 0).all() and (ideal["gps_pn_m"] == 0).all()
    noisy = still("x500_drop")
    assert noisy["az_m_s2"].std() > 0 and (noisy["az_m_s2"] == still("x500_drop")["az_m_s2"]).all()
    assert (still("x500_drop", seed=7)["az_m_s2"] != noisy["az_m_s2"]).any()
    # The field turns with the body, the other way.
    east = still("titan_paper", yaw_rad=np.pi / 2)
    assert np.allclose(east["my_gauss"], -ideal["mx_gauss"]) and np.allclose(east["mx_gauss"], ideal["my_gauss"])


BAD: dict[str, tuple[Callable[[], object], str]] = {
    "a mission of no name": (lambda: inside.loops("nowhere"), "no mission file of the name `nowhere`"),
    "gains of no name": (lambda: inside.loops("x500_drop", gains="nope"), "nope"),
    "speeds that do not broadcast": (lambda: inside.rotor(omega_rad_s=[1, 2], climb_m_s=[1, 2, 3]), r"found \(2,\), \(3,\), \(\)"),
    "a speed that is no number": (lambda: inside.rotor(omega_rad_s=float("nan")), "omega_rad_s: finite"),
    "a speed that is a word": (lambda: inside.rotor(omega_rad_s="fast"), "omega_rad_s: numbers are expected"),
    "a negative speed across": (lambda: inside.rotor(omega_rad_s=1.0, in_plane_m_s=-1.0), "in_plane_m_s: a speed"),
    "a density of nothing": (lambda: inside.rotor(omega_rad_s=1.0, density_kg_m3=0.0), "density_kg_m3"),
    "times that go back": (lambda: inside.wind(time_s=[0.0, 1.0, 0.5]), "time_s: ascending"),
    "positions of another length": (lambda: inside.wind(time_s=[0.0, 1.0], position_ned_m=np.zeros((3, 3))), "position_ned_m: shape"),
    "a flight of a negative number": (lambda: inside.wind(time_s=[0.0], number=-1), "number: a whole number"),
    "one time": (lambda: inside.sensors(time_s=[0.0]), "two times"),
    "an attitude of three": (lambda: inside.sensors(time_s=[0.0, 1.0], q_ned_from_body=np.zeros((2, 3))), "q_ned_from_body: shape"),
}


@pytest.mark.parametrize("name", BAD)
def test_what_is_refused_says_why(name: str) -> None:
    call, words = BAD[name]
    with pytest.raises((samara.MissionError, ValueError), match=words):
        call()
