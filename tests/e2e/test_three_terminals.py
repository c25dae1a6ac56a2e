"""`samara sim`, `samara autopilot` and `samara stream` in three processes do the drop of `samara drop`, each looked at."""

import pytest

from onlooker import Onlooker


def test_three_terminals(samara, reference):
    look = ("--view", "--no-open")
    # In an order that nobody prescribes.
    stream = samara.stream(*look)
    autopilot = samara.autopilot("--once", *look)
    sim = samara.sim("--speed", 10, "--json", *look)
    onlookers = [Onlooker(program).reads() for program in (sim, autopilot, stream)]

    stream.says("OFFBOARD accepted")
    stream.says("armed")
    stream.says("released at 10.")
    sim.says("rotors free")
    stream.says("plan at its end")
    assert sim.ends() == 0
    reference.agrees_with(sim.json())
    assert autopilot.ends() == 0
    assert stream.ends() == 0, "the vehicle is gone, its mission flown"
    for file in ("flight.csv", "drop.json", "drop.svg", "hil.tlog"):
        assert (sim.out / file).stat().st_size > 0
    assert (autopilot.out / "vehicle.tlog").stat().st_size > 0
    # The simulator's page has the truth, the others' what telemetry says: the same flight.
    truth, *told = (onlooker.rows() for onlooker in onlookers)
    for rows in (truth, *told):
        phases = [row["phase"] for row in rows]
        assert phases == sorted(phases) and phases[-1] == 2 and 1 in phases
    last = truth[-1]
    for rows in told:
        assert [rows[-1][v] for v in ("vn_m_s", "vd_m_s")] == pytest.approx([last[v] for v in ("vn_m_s", "vd_m_s")], abs=0.05)
    assert "thrust_1_n" in last and all("thrust_1_n" not in rows[-1] for rows in told)
    assert onlookers[0].had()[-1]["end"]["safe"]
    assert onlookers[1].had()[-1]["end"] == {"text": "the autopilot has ended"}
    assert onlookers[2].had()[-1]["end"] == {"text": "the plan was streamed to its end"}
    assert onlookers[2].state()["last setpoint"].startswith("velocity ")
    assert onlookers[0].state()["last throttles"].endswith(" %")
