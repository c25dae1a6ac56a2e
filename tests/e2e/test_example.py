"""The example in drop.py and in docs/scripting.md: the same text, and true."""

import re
import subprocess

import drop
import pytest
from programs import REPOSITORY, SAMARA


def example(text):
    """The Python block that imports from drop.py."""
    return next(block for block in re.findall(r"```python\n(.*?)```", text, re.DOTALL) if "from drop import" in block)


@pytest.mark.parametrize("speed", ["10", "max"])
def test_the_example_flies(samara, capsys, monkeypatch, tmp_path, speed):
    code = example(drop.__doc__)
    assert code == example((REPOSITORY / "docs" / "scripting.md").read_text(encoding="utf-8"))
    # As a user has it, but for the folder, and for the instance that is free.
    monkeypatch.chdir(tmp_path)
    mission = REPOSITORY / "mission" / "titan_drop.json"
    (tmp_path / "mission").symlink_to(mission.parent)
    subprocess.run([SAMARA, "plan", mission], cwd=tmp_path, capture_output=True, check=True)
    here = f'Vehicle("udpin:127.0.0.1:{samara.ports.api}", system={samara.ports.system})'
    code, found = re.subn(r'Vehicle\("udpin:127.0.0.1:14540", system=1\)', here, code)
    assert found == 1
    sim = samara.sim("--speed", speed, "--wait-for", "companion", mission)
    samara.autopilot(mission)
    sim.says("waiting since", "for a companion")
    names = {}
    exec(compile(code, "scripting.md", "exec"), names)  # noqa: S102
    names["vehicle"].close()
    assert sim.ends() == 0, "the script has streamed to the end"
    said = capsys.readouterr().out
    steady_s, j_tpf = (float(x) for x in re.fullmatch(r"steady at (\S+) s\nJ_TPF (\S+)\n", said).groups())
    assert 40.4 < steady_s < 41.0 and 0.49 < j_tpf < 0.51
