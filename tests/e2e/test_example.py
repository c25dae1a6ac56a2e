"""The example in drop.py and in docs/scripting.md: the same text, and true."""

import re
import subprocess

import drop
from programs import MISSION, REPOSITORY, SAMARA


def example(text):
    """The Python block that imports from drop.py."""
    return next(block for block in re.findall(r"```python\n(.*?)```", text, re.DOTALL) if "from drop import" in block)


def test_the_example_flies(samara, capsys, monkeypatch, tmp_path):
    code = example(drop.__doc__)
    assert code == example((REPOSITORY / "docs" / "scripting.md").read_text(encoding="utf-8"))
    # As a user has it, but for the folder, and for the instance that is free.
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mission").symlink_to(MISSION.parent)
    subprocess.run([SAMARA, "plan", MISSION], cwd=tmp_path, capture_output=True, check=True)
    here = f'Vehicle("udpin:127.0.0.1:{samara.ports.api}", system={samara.ports.system})'
    code, found = re.subn(r'Vehicle\("udpin:127.0.0.1:14540", system=1\)', here, code)
    assert found == 1
    samara.sim("--speed", 10)
    samara.autopilot()
    names = {}
    exec(compile(code, "scripting.md", "exec"), names)  # noqa: S102
    names["vehicle"].close()
    said = capsys.readouterr().out
    steady_s, j_tpf = (float(x) for x in re.fullmatch(r"steady at (\S+) s\nJ_TPF (\S+)\n", said).groups())
    assert 40.4 < steady_s < 41.0 and 0.5 < j_tpf < 0.6
