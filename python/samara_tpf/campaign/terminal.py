"""What Dask's workers of this machine load first: Ctrl-C on the terminal reaches them, too, and is for the driver."""

import signal


def dask_setup(worker: object) -> None:
    """Lets a worker ignore Ctrl-C; the driver ends it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
