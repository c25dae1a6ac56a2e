"""``python -m samara_tpf``: the program ``samara`` that was installed with this module."""

from __future__ import annotations

import os
import subprocess
import sys
import sysconfig
from pathlib import Path


def program() -> Path | None:
    """The program beside this interpreter, or in the folder of the user's scripts."""
    name = "samara.exe" if os.name == "nt" else "samara"
    schemes = [sysconfig.get_default_scheme(), sysconfig.get_preferred_scheme("user")]
    places = [Path(sysconfig.get_path("scripts", scheme)) / name for scheme in schemes]
    return next((place for place in places if place.is_file()), None)


def main() -> int:
    """Runs the program with the arguments of the command line; its exit code."""
    found = program()
    if found is None:
        print("samara_tpf: the program `samara` was not installed with this module", file=sys.stderr)
        return 3
    arguments = [os.fspath(found), *sys.argv[1:]]
    if os.name == "posix":
        os.execv(found, arguments)
    return subprocess.run(arguments).returncode


if __name__ == "__main__":
    sys.exit(main())
