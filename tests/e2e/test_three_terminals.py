"""`samara sim`, `samara autopilot` and `samara stream` in three processes do the drop of `samara drop`."""


def test_three_terminals(samara, reference):
    # In an order that nobody prescribes.
    stream = samara.stream()
    autopilot = samara.autopilot("--once")
    sim = samara.sim("--speed", 10, "--json")

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
