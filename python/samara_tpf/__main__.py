"""``samara`` and ``python -m samara_tpf``: the program, which is this module's library."""

from __future__ import annotations

import os
import signal
import sys
import sysconfig
from pathlib import Path


def program() -> Path | None:
    """The program's script beside this interpreter, or in the folder of the user's scripts."""
    name = "samara.exe" if os.name == "nt" else "samara"
    schemes = [sysconfig.get_default_scheme(), sysconfig.get_preferred_scheme("user")]
    places = [Path(sysconfig.get_path("scripts", scheme)) / name for scheme in schemes]
    return next((place for place in places if place.is_file()), None)


def library() -> Path:
    """The file that holds what the program does; there is one where this is a wheel."""
    from . import _samara

    return Path(_samara.__file__)


def main() -> int:
    """Runs the program with the arguments of the command line; its exit code."""
    from . import _samara

    # Python's handler would only note the signal; the program's own comes in its place.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _samara.program(["samara", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
