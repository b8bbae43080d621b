"""What a worker of `--cluster local` loads first: Ctrl-C is for the command, which ends it."""

import signal


def dask_setup(worker: object) -> None:
    """Called by `distributed` in the worker's process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
