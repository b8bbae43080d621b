"""The kernel compiled by numba, and kept on disk for exactly these sources.

Imports numba (0.4 s with the scipy.linalg that numba looks for), so only `backend` imports this,
when it is worth it. Compiling takes some 15 s of processor time, once per machine.
"""

from __future__ import annotations

import contextlib
import pickle
import sys
from collections.abc import Callable
from contextlib import AbstractContextManager
from functools import partial
from hashlib import sha256
from pathlib import Path
from threading import Lock
from time import time
from types import FunctionType
from typing import Any
from uuid import uuid4

import llvmlite
import numba
from numba.core.caching import _Cache
from numba.core.compiler import CompileResult
from numba.core.serialize import dumps

from camcli.kernel.backend import read_intact
from camcli.kernel.marks import ENTRIES, FUNCTIONS, OUTLINED

ABANDONED = 60.0  # s: nobody writes a file for so long


class CompiledEntry:
    """A compiled entry with one signature, that of its first call.

    Any other kind of argument is a fault of the caller and raises TypeError: it would be compiled
    for seconds, and unseen.
    """

    def __init__(self, dispatcher: Any, waiting: Callable[[], AbstractContextManager]):
        self._dispatcher, self._waiting = dispatcher, waiting
        self._ready, self._lock = False, Lock()

    def __call__(self, *args: Any) -> Any:
        if not self._ready:
            self._compile(args)
        return self._dispatcher(*args)

    def _compile(self, args: tuple) -> None:
        with self._waiting(), self._lock:
            if not self._ready:
                self._dispatcher.compile(tuple(map(self._dispatcher.typeof_pyval, args)))
                self._dispatcher.disable_compile()
                self._ready = True


def compile_entries(
    folder: Path, waiting: Callable[[str], AbstractContextManager]
) -> dict[str, CompiledEntry]:
    """The entries by name, compiled at their first call; `waiting` is entered while that lasts.

    The compiled functions see copies of their modules' names, so a plain function still calls
    plain ones. Code is read from `folder` and kept there.
    """
    modules = {function.__module__ for function in FUNCTIONS}
    spaces = {name: dict(vars(sys.modules[name])) for name in modules}
    compiled, entry_functions = {}, set(ENTRIES.values())
    for function in FUNCTIONS:
        copy = FunctionType(function.__code__, spaces[function.__module__], function.__name__)
        copy.__module__, copy.__doc__ = function.__module__, function.__doc__
        # Nothing allocates, so reference counts (_nrt) would only cost: an atomic per call.
        options: dict[str, Any] = {"nogil": True, "error_model": "numpy", "_nrt": False}
        inner = function not in entry_functions  # Python does not call it: no wrapper to compile
        options |= {"no_cpython_wrapper": inner, "no_cfunc_wrapper": True}
        options["forceinline"] = function not in OUTLINED and inner
        compiled[function] = numba.njit(**options)(copy)
    for space in spaces.values():
        for name, value in space.items():
            if isinstance(value, FunctionType) and value in compiled:
                space[name] = compiled[value]
    entries = {}
    for name, function in ENTRIES.items():
        dispatcher = compiled[function]
        # What `cache=True` does, but neither in numba's folder nor by one file's time stamp.
        dispatcher._cache = _DiskCache(folder, name)
        entries[name] = CompiledEntry(dispatcher, partial(waiting, name))
    return entries


class _DiskCache(_Cache):
    """Machine code of one entry in a file of `folder`: its SHA-256, then what numba pickles.

    The file's name is that of the entry and of all that its code depends on beside the kernel's
    sources, which name the folder. What cannot be read, or is damaged, is compiled again; what
    cannot be written is not kept. A file that a killed process left half written is removed.
    """

    def __init__(self, folder: Path, entry: str):
        self._folder, self._entry = folder, entry

    @property
    def cache_path(self) -> str:
        """Where the code is kept."""
        return str(self._folder)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The code for a signature, or None."""
        target_context.refresh()
        data = read_intact(self._path(sig, target_context))
        try:
            return (
                None
                if data is None
                else CompileResult._rebuild(target_context, *pickle.loads(data))
            )
        except Exception:  # a sum says that it was written so, not that it can be used
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep the code; beside its place first, so that no other process finds half of it."""
        path = self._path(sig, data.target_context)
        content = dumps(data._reduce())
        part = path.with_suffix(f".{uuid4().hex}")
        with contextlib.suppress(OSError):
            self._folder.mkdir(parents=True, exist_ok=True)
            for other in self._folder.glob("*"):
                if other.suffix != path.suffix and time() - other.stat().st_mtime > ABANDONED:
                    other.unlink()
            try:
                part.write_bytes(sha256(content).digest() + content)
                part.replace(path)
            finally:
                part.unlink(missing_ok=True)

    def _path(self, sig: Any, target_context: Any) -> Path:
        machine = target_context.codegen().magic_tuple()
        depends = numba.__version__, llvmlite.__version__, sys.version, str(sig), machine
        name = sha256(repr(depends).encode()).hexdigest()[:16]
        return self._folder / f"{self._entry}.{name}.nbc"

    def enable(self) -> None:
        """It always is."""

    def disable(self) -> None:
        """It never is."""

    def flush(self) -> None:
        """Nothing waits."""
