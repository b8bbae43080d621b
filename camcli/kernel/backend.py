"""Run the kernel in plain Python, or compile it with numba when there is work enough.

Importing numba costs about 0.4 s and compiling a few seconds; plain Python does some ten
thousand impacts a second. So every kernel function is plain Python, and `compile_kernel` replaces
the entry points in `entry_points` by compiled copies. Both give the same bits.
"""

from __future__ import annotations

import hashlib
import importlib
import os
import sys
import threading
from contextlib import contextmanager
from pathlib import Path
from types import FunctionType

MODULES = (
    "arithmetic",
    "cam_table",
    "flow",
    "chatter",
    "gap_series",
    "contact_search",
    "flight",
    "leap",
    "sticking",
    "orbit_loop",
    "variational",
    "growth",
    "bordered",
    "shooting",
    "certify",
    "cells",
    "entry_points",
)

_functions: list = []
_entries: set = set()
_outlined: set = set()
_announced: set[str] = set()
_compiled = False
skip_blas = False  # set by the command line, see `without_blas`
compile_seconds = 0.0  # spent loading numba and compiling, or reading the cache
on_compile = None  # called with a line for the user when the kernel must be compiled anew
_lock = threading.Lock()


def kernel(function):
    """Mark a function as part of the kernel; it stays plain Python until compiled."""
    _functions.append(function)
    return function


def outlined(function):
    """`kernel`, for rarely taken paths: compiled as a call instead of in line."""
    _outlined.add(function)
    return kernel(function)


def entry(function):
    """Mark a kernel function that Python calls; only these are cached on disk."""
    _entries.add(function)
    return kernel(function)


def is_compiled() -> bool:
    """True once `compile_kernel` has replaced the plain functions."""
    return _compiled


def may_compile() -> bool:
    """False where the user forces plain Python (CAMCLI_KERNEL=python or NUMBA_DISABLE_JIT=1)."""
    disabled = os.environ.get("NUMBA_DISABLE_JIT", "0").strip().lower() in ("1", "true", "yes")
    return not disabled and os.environ.get("CAMCLI_KERNEL", "auto") != "python"


def must_compile() -> bool:
    """True where the user forces the compiled kernel even for little work."""
    return may_compile() and os.environ.get("CAMCLI_KERNEL", "auto") == "compiled"


def source_hash() -> str:
    """Hash of the kernel's sources: it names the cache, since numba misses edits in callees."""
    digest = hashlib.sha256()
    for path in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()[:16]


def cache_dir() -> Path:
    """Folder of the compiled kernel: one per state of the sources."""
    home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(home) / "camcli" / f"kernel-{source_hash()}"


def is_cached(entry: str = "advance") -> bool:
    """True if an earlier process left this entry point compiled for these sources."""
    return any(cache_dir().glob(f"**/entry_points.{entry}-*.nbc"))


def announce(entry: str) -> None:
    """Say once, before the first call of a compiled entry, that it will take some seconds."""
    if entry in _announced or not _compiled:
        return
    _announced.add(entry)
    if on_compile is not None and not is_cached(entry):
        on_compile("compiling a further part of the kernel: some seconds, once ...")


def _usable_cache() -> Path | None:
    folder = cache_dir()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return None
    return folder if os.access(folder, os.W_OK) or is_cached() else None


def compile_kernel() -> None:
    """Make the entry points in `entry_points` numba dispatchers, once; all else stays plain Python.

    A cache folder that cannot be written only costs the compile time again.
    """
    global _compiled
    with _lock:
        if _compiled:
            return
        import numba

        folder = _usable_cache()
        if on_compile is not None and not is_cached():
            on_compile("compiling the kernel for this machine: some seconds, once ...")
        if folder is not None:
            numba.config.CACHE_DIR = str(folder)
        _replace_entries(numba.njit, folder is not None)
        _compiled = True


def _replace_entries(njit, cached: bool) -> None:
    """Compile copies of all kernel functions that see each other, and publish the entries.

    The copies live in namespaces of their own, so that a plain function still calls plain ones.
    """
    modules = {name: importlib.import_module(f"{__package__}.{name}") for name in MODULES}
    spaces = {module.__name__: dict(vars(module)) for module in modules.values()}
    compiled = {}
    for function in _functions:
        copy = FunctionType(function.__code__, spaces[function.__module__], function.__name__)
        copy.__module__, copy.__doc__ = function.__module__, function.__doc__
        # Nothing allocates, so reference counts (_nrt) would only cost: an atomic per call.
        compiled[function] = njit(
            nogil=True,
            error_model="numpy",
            cache=cached and function in _entries,
            forceinline=function not in _entries and function not in _outlined,
            _nrt=False,
        )(copy)
    for space in spaces.values():
        for name, value in space.items():
            if isinstance(value, FunctionType) and value in compiled:
                space[name] = compiled[value]
    for function in _entries:
        setattr(modules["entry_points"], function.__name__, compiled[function])


@contextmanager
def without_blas():
    """Keep numba from importing scipy.linalg (0.2 s) for matrix products no kernel has.

    Only where `skip_blas` is set: in another program's process numba may be wanted whole.
    """
    if not skip_blas or "scipy" in sys.modules:
        yield
        return
    sys.modules["scipy"] = None  # type: ignore[assignment]
    try:
        yield
    finally:
        del sys.modules["scipy"]


def numbers(values, kind=float):
    """A table in the form the current kernel wants: a list in plain Python, else an array.

    kind is float or int. Lists keep plain Python free of numpy scalars, which are slow.
    """
    if not _compiled:
        return values if isinstance(values, list) else [kind(value) for value in values]
    np = sys.modules.get("numpy") or importlib.import_module("numpy")
    return np.asarray(values, dtype=np.float64 if kind is float else np.int64)


def zeros(count: int, kind=float):
    """`count` zeros in the form of `numbers`."""
    if not _compiled:
        return [kind(0)] * count
    np = sys.modules.get("numpy") or importlib.import_module("numpy")
    return np.zeros(count, dtype=np.float64 if kind is float else np.int64)
