"""A flight that is looked at while it flies: it is the same, byte by byte, whoever looks on and does not read."""

import pytest

from onlooker import Onlooker


def test_four_who_look_on_and_do_not_read_change_no_byte(samara, reference):
    alone = samara.drop("--speed", 100)
    assert alone.ends() == 0
    drop = samara.drop("--speed", 100, "--view", "--no-open")
    onlooker = Onlooker(drop)
    silent = [onlooker.asks() for _ in range(4)]
    onlooker.reads()
    assert drop.ends() == 0
    files = {file.name for file in alone.out.iterdir()}
    assert files == {file.name for file in drop.out.iterdir()} and len(files) > 10
    for file in files:
        assert (drop.out / file).read_bytes() == (alone.out / file).read_bytes(), file

    rows = onlooker.rows()
    phases = [row["phase"] for row in rows]
    assert phases == sorted(phases) and set(phases) == {0, 1, 2}
    # About 30 a second, and those at which something begins.
    assert len(rows) == pytest.approx(30 * reference.mission["duration_s"], rel=0.1)
    assert rows[phases.index(1)]["t_s"] == pytest.approx(10.0, abs=0.1)
    assert any("released by command" in text for text in onlooker.events())
    assert onlooker.state()["vehicle"].startswith("armed, OFFBOARD")
    end = onlooker.had()[-1]["end"]
    assert end["safe"] and "Safe" in end["words"]["verdict"] and end["drop"]["flight"]["count"] > 10_000
    for asking in silent:
        asking.close()


def test_what_is_over_at_once_is_not_shown(samara):
    drop = samara.drop("--view", "--no-open")
    assert drop.ends() == 2
    assert drop.has_said("--speed FACTOR is expected")
