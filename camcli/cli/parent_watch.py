"""A child of `cam figures` ends when its parent is killed; its finished pieces stay on disk."""

from __future__ import annotations

import os
from threading import Thread
from time import sleep

PARENT = "CAMCLI_PARENT"  # environment: process whose end is ours too
INTERVAL = 0.5  # s


def end_with_parent() -> None:
    """Watch the process named in the environment, if one is."""
    parent = os.environ.pop(PARENT, "")
    if parent.isdigit():
        Thread(target=_watch, args=(int(parent),), daemon=True).start()


def _watch(parent: int) -> None:
    while os.getppid() == parent:
        sleep(INTERVAL)
    os._exit(130)
