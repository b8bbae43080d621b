"""The kernel compiled by numba's public functions alone: any numba can, and each start is slower.

numba itself keeps the code on disk; it must be imported before the code can be used.
"""

from collections.abc import Callable
from functools import cache
from pathlib import Path
from threading import Lock

import numba
from numba.extending import register_jitable

from camcli.kernel.marks import ENTRIES, FUNCTIONS, OUTLINED

_choosing = Lock()


def compiled_entry(name: str, folder: Path | None) -> Callable:
    """The entry, which numba compiles, or reads from the folder, at its first call.

    folder: where numba keeps the code it has compiled; None: nowhere. numba takes the folder from
    its own settings when the function is made, so it is set for that moment.
    """
    _make_known()
    with _choosing:
        before = numba.config.CACHE_DIR
        try:
            if folder is not None:
                numba.config.CACHE_DIR = str(folder)
            is_kept = folder is not None
            return numba.njit(error_model="numpy", nogil=True, cache=is_kept)(ENTRIES[name])
        finally:
            numba.config.CACHE_DIR = before


@cache
def _make_known() -> None:
    """Let numba compile the kernel's functions into those that call them."""
    for function in FUNCTIONS:
        register_jitable(error_model="numpy", forceinline=function not in OUTLINED)(function)
