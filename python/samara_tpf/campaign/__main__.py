"""``python -m samara_tpf.campaign``."""

import sys

from .driver import main

# Dask's workers on this machine import this module once more, under another name.
if __name__ == "__main__":
    sys.exit(main())
