"""``python -m samara_tpf._served``: the program, which ends when its input does, and so with whoever started it."""

from __future__ import annotations

import os
import signal
import sys
import threading

from .__main__ import main


def _end_with_input() -> None:
    while os.read(0, 1):
        pass
    os.kill(os.getpid(), signal.SIGTERM)


if __name__ == "__main__":
    threading.Thread(target=_end_with_input, daemon=True).start()
    sys.exit(main())
