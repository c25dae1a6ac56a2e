"""What `benches/lockstep/run` reads in PX4's datagrams, which pymavlink packs here as PX4's versions send them."""

import runpy

import pytest
from pymavlink.dialects.v10 import common as v1
from pymavlink.dialects.v20 import common as v2

from programs import REPOSITORY

BENCH = runpy.run_path(str(REPOSITORY / "benches/lockstep/run"))


@pytest.mark.parametrize("dialect", [v1, v2], ids=["MAVLink 1", "MAVLink 2"])
def test_reference_the_clock_is_that_of_each_attitude(dialect):
    """With other messages between and, in MAVLink 2, payloads without the zeros at their ends."""
    link = dialect.MAVLink(None, srcSystem=8, srcComponent=1)
    messages = [
        link.attitude_encode(4096, 0.1, 0.2, 0.3, 0.0, 0.0, 0.0),
        link.heartbeat_encode(2, 12, 0, 0, 3),
        link.attitude_encode(70_000, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        link.ping_encode(1, 2, 0, 0),
    ]
    datagram = b"".join(message.pack(link) for message in messages)
    assert list(BENCH["attitude_times_s"](datagram)) == [4.096, 70.0]


def test_reference_the_model_is_the_one_that_the_build_has(tmp_path):
    """Names of the airframes in the sources of PX4 v1.12.0 and v1.14.3."""
    airframes = tmp_path / "etc/init.d-posix/airframes"
    airframes.mkdir(parents=True)
    assert BENCH["model"](tmp_path) == "iris"
    (airframes / "10016_none_iris").touch()
    assert BENCH["model"](tmp_path) == "none_iris"
