"""Run the kernel in plain Python, or compile it with numba when there is work enough.

Importing numba costs about 0.4 s and compiling a few seconds; plain Python does some ten
thousand impacts a second. So every kernel function starts as plain Python, and `compile_kernel`
replaces all of them by numba dispatchers in place. Both give the same bits.
"""

from __future__ import annotations

import hashlib
import importlib
import os
import sys
import threading
from contextlib import contextmanager
from pathlib import Path

MODULES = ("trig", "profile", "flight", "contact", "events", "sliding", "orbit", "lanes")

_functions: list = []
_entries: set = set()
_outlined: set = set()
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


def is_cached() -> bool:
    """True if an earlier process left a compiled kernel for these sources."""
    return any(cache_dir().glob("**/*.nbc"))


def _usable_cache() -> Path | None:
    folder = cache_dir()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return None
    return folder if os.access(folder, os.W_OK) or is_cached() else None


def compile_kernel() -> None:
    """Replace every kernel function by its numba dispatcher, in all kernel modules, once.

    A cache folder that cannot be written only costs the compile time again.
    """
    global _compiled
    with _lock:
        if _compiled:
            return
        import numba

        modules = [importlib.import_module(f"{__package__}.{name}") for name in MODULES]
        folder = _usable_cache()
        if on_compile is not None and not is_cached():
            on_compile("compiling the kernel for this machine: some seconds, once ...")
        if folder is not None:
            numba.config.CACHE_DIR = str(folder)
        compiled = {}
        for function in _functions:
            cached = function in _entries and folder is not None
            # Nothing allocates, so reference counts (_nrt) would only cost: an atomic per call.
            jit = numba.njit(
                nogil=True,
                error_model="numpy",
                cache=cached,
                forceinline=function not in _entries and function not in _outlined,
                _nrt=False,
            )
            compiled[function] = jit(function)
        for module in modules:
            for name, value in list(vars(module).items()):
                if callable(value) and getattr(value, "__hash__", None) and value in compiled:
                    setattr(module, name, compiled[value])
        _compiled = True


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
        return [kind(value) for value in values]
    np = sys.modules.get("numpy") or importlib.import_module("numpy")
    return np.array(values, dtype=np.float64 if kind is float else np.int64)


def zeros(count: int, kind=float):
    """`count` zeros in the form of `numbers`."""
    if not _compiled:
        return [kind(0)] * count
    np = sys.modules.get("numpy") or importlib.import_module("numpy")
    return np.zeros(count, dtype=np.float64 if kind is float else np.int64)
