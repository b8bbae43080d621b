"""The kernel compiled by numba, and kept on disk for exactly these sources.

Imports numba (0.4 s with the scipy.linalg that numba looks for), so only `backend` imports this,
when it is worth it. Compiling takes some 20 s of processor time, once per machine.
"""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable
from contextlib import AbstractContextManager
from functools import partial
from pathlib import Path
from threading import Lock
from types import FunctionType
from typing import Any

import numba
from numba.core.caching import CompileResultCacheImpl, FunctionCache, _CacheLocator

from camcli.kernel.marks import ENTRIES, FUNCTIONS, OUTLINED


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
    folder: Path, stamp: str, waiting: Callable[[str], AbstractContextManager]
) -> dict[str, CompiledEntry]:
    """The entries by name, compiled at their first call; `waiting` is entered while that lasts.

    The compiled functions see copies of their modules' names, so a plain function still calls
    plain ones. Code is read from `folder` and kept there under `stamp`.
    """
    modules = {function.__module__ for function in FUNCTIONS}
    spaces = {name: dict(vars(sys.modules[name])) for name in modules}
    compiled, entry_functions = {}, set(ENTRIES.values())
    for function in FUNCTIONS:
        copy = FunctionType(function.__code__, spaces[function.__module__], function.__name__)
        copy.__module__, copy.__doc__ = function.__module__, function.__doc__
        # Nothing allocates, so reference counts (_nrt) would only cost: an atomic per call.
        options: dict[str, Any] = {"nogil": True, "error_model": "numpy", "_nrt": False}
        options["forceinline"] = function not in OUTLINED and function not in entry_functions
        compiled[function] = numba.njit(**options)(copy)
    for space in spaces.values():
        for name, value in space.items():
            if isinstance(value, FunctionType) and value in compiled:
                space[name] = compiled[value]
    entries = {}
    for name, function in ENTRIES.items():
        dispatcher = compiled[function]
        # What `cache=True` does, but neither in numba's folder nor by one file's time stamp.
        dispatcher._cache = _cache_type(folder, stamp)(dispatcher.py_func)
        entries[name] = CompiledEntry(dispatcher, partial(waiting, name))
    return entries


def _cache_type(folder: Path, stamp: str) -> type[FunctionCache]:
    """numba's cache of a function in `folder`, valid for `stamp`.

    A folder that cannot be read or written, or holds something broken, only costs the time to
    compile again.
    """

    class Locator(_CacheLocator):
        def get_cache_path(self) -> str:
            return str(folder)

        def get_source_stamp(self) -> str:
            return stamp

        def get_disambiguator(self) -> str:
            return stamp

    class Impl(CompileResultCacheImpl):
        def __init__(self, function: FunctionType):
            # Not numba's own: that one searches for a folder, beside the sources too.
            self._lineno, self._locator = function.__code__.co_firstlineno, Locator()
            python = f"py{sys.version_info[0]}{sys.version_info[1]}{sys.abiflags}"
            self._filename_base = f"{function.__name__}.{python}"

    class Cache(FunctionCache):
        _impl_class = Impl

        def load_overload(self, sig: Any, target_context: Any) -> Any:
            try:
                return super().load_overload(sig, target_context)
            except Exception:  # whatever unpickling garbage may raise
                return None

        def save_overload(self, sig: Any, data: Any) -> None:
            with contextlib.suppress(Exception):  # the index it adds to may be garbage
                super().save_overload(sig, data)
                return
            with contextlib.suppress(Exception):
                self.flush()
                super().save_overload(sig, data)

    return Cache
