"""MAVProxy at work: parameters, a value set, files, armed, OFFBOARD, and its log; nothing in it sounds like trouble."""

import sys
from pathlib import Path

from drop import Vehicle, mavlink
from programs import REPOSITORY
from tlog import dump

MAVPROXY = Path(sys.executable).parent / "mavproxy.py"
GROUND = REPOSITORY / "mission" / "x500_ground.json"
MODULES = "log,wp,rally,fence,ftp,param,arm,mode,misc,cmdlong"


def start_mavproxy(samara, folder):
    """MAVProxy at the ground stations' port; it has the vehicle's parameters."""
    mavproxy = samara.other(
        "mavproxy", sys.executable, "-u", MAVPROXY, "--master", f"udpout:127.0.0.1:{samara.ports.autopilot_ground}",
        "--target-system", samara.ports.system, "--state-basedir", folder, "--default-modules", MODULES, "--aircraft", "proxy",
        HOME=str(folder),
    )
    # They come by FTP or, since there is no such file, by the list.
    mavproxy.says("Received", "parameters")
    return mavproxy


def test_mavproxy(samara, tmp_path):
    samara.sim("--speed", 2, GROUND)
    autopilot = samara.autopilot("--once", GROUND)
    autopilot.says("connected to simulator")
    mavproxy = start_mavproxy(samara, tmp_path)
    mavproxy.type("param show COM_OF_LOSS_T")
    mavproxy.says("COM_OF_LOSS_T", "1.0")
    mavproxy.type("param set COM_OF_LOSS_T 9")
    mavproxy.type("ftp list /")
    mavproxy.says("D etc")
    # Disarmed, OFFBOARD may be chosen without setpoints, as in PX4 v1.14; with a script that streams it arms.
    mavproxy.type("long DO_SET_MODE 1 6 0")
    mavproxy.says("DO_SET_MODE: ACCEPTED")
    mavproxy.type("arm throttle")
    mavproxy.says("Arming denied: no offboard signal")
    vehicle = Vehicle(f"udpin:127.0.0.1:{samara.ports.api}", samara.ports.system)
    vehicle.connect()
    vehicle.stream(vehicle.level)
    vehicle.until(vehicle.now_s + 0.5)
    mavproxy.type("long DO_SET_MODE 1 6 0")
    vehicle.wait("HEARTBEAT", vehicle.is_offboard)
    mavproxy.type("arm throttle")
    vehicle.wait("HEARTBEAT", lambda m: m.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED)
    vehicle.close()
    mavproxy.says("ARMED")
    mavproxy.ends()
    trouble = ("breach", "Traceback", "Failed", "timeout", "ERROR", "no link", "link 1 down")
    assert not [line for line in mavproxy.lines if any(word in line for word in trouble)], mavproxy.transcript()

    [tlog] = (tmp_path / "proxy").rglob("*.tlog")
    messages = dump(tlog)
    kinds = {kind for kind, _, _ in messages}
    assert {"HEARTBEAT", "ATTITUDE", "PARAM_VALUE", "COMMAND_ACK", "STATUSTEXT", "FILE_TRANSFER_PROTOCOL"} <= kinds
    assert "BAD_DATA" not in kinds
