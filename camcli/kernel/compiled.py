"""The kernel's machine code: compiled once, kept on disk for exactly these sources.

Importing numba takes longer than most runs, so it is imported to compile, and not to run: code on
disk is loaded by LLVM alone, and called as numba calls its own functions from each other.
"""

from __future__ import annotations

import contextlib
import os
import struct
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from ctypes import CFUNCTYPE, addressof, byref, c_char, c_char_p, c_int32, c_int64, c_void_p
from functools import cache, partial
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from threading import Lock
from time import sleep, time
from typing import Any
from uuid import uuid4

import llvmlite.binding as llvm
from numpy import ndarray

from camcli.interrupts import compiling
from camcli.kernel.backend import read_intact
from camcli.kernel.marks import ENTRIES

ABANDONED = 60.0  # s: nobody compiles, or writes a file, for so long
LOOKS = 600  # in that time, whether the other one is done
UNUSED = 30 * 86400.0  # s, after which code goes, of whatever sources it is
# numba's own convention: where the result goes, where an exception goes, arguments
CALL = CFUNCTYPE(c_int32, c_void_p, c_void_p, c_char_p)


class CompiledEntry:
    """A compiled entry with one signature, that of its first call; it returns an int or nothing.

    Any other kind of argument is a fault of the caller and raises TypeError.
    """

    def __init__(self, folder: Path, name: str, waiting: Callable[[], AbstractContextManager]):
        self._folder, self._name, self._waiting = folder, name, waiting
        self._function: Any = None
        self._lock = Lock()
        self._last: tuple[tuple, list, list] = (), [], []  # cam, and what `_flatten` makes of it

    def __call__(self, cam: tuple, *args: Any) -> int:
        last = self._last
        if last[0] is not cam:  # it is the same for many calls
            last = cam, [], []
            _flatten(*last)
            self._last = last
        numbers, kinds = last[1].copy(), last[2].copy()
        _flatten(args, numbers, kinds)
        if self._function is None:
            self._load((cam, *args), numbers, kinds)
        if kinds != self._kinds:
            raise TypeError(f"{self._name} was compiled for other columns")
        try:
            packed = self._form.pack(*numbers)
        except struct.error as error:
            raise TypeError(f"{self._name} was compiled for other arguments ({error})") from None
        returned = c_int64()
        failed = self._function(byref(returned), None, packed)
        assert not failed  # the kernel raises nothing
        return returned.value

    def _load(self, args: tuple, numbers: list, kinds: list) -> None:
        with self._waiting(), self._lock, compiling():
            if self._function is None:
                form = "=" + "".join("d" if isinstance(x, float) else "q" for x in numbers)
                depends = *_machine(), [kind.descr for kind in kinds], form
                name = f"{self._name}.{sha256(repr(depends).encode()).hexdigest()[:16]}.nbc"
                path = self._folder / name
                code = _from_disk(path)
                if code is None:
                    with _alone(self._folder):
                        code = _from_disk(path) or _compiled(path, self._name, args)
                self._engine, address = code
                self._kinds, self._form = kinds, struct.Struct(form)
                self._function = CALL(address)


def compile_entries(
    folder: Path, waiting: Callable[[str], AbstractContextManager]
) -> dict[str, CompiledEntry]:
    """The entries by name, compiled at their first call; `waiting` is entered while that lasts.

    Code is read from `folder` and kept there. What cannot be read, or is damaged, is compiled
    again; what cannot be written is not kept.
    """
    return {name: CompiledEntry(folder, name, partial(waiting, name)) for name in ENTRIES}


def _flatten(values: tuple, numbers: list, kinds: list) -> None:
    """The numbers that numba makes of arguments, each of 8 bytes.

    A tuple is its entries; a column its owner (none: nobody counts references), size, width of an
    entry, address, shape and strides. kinds: what the columns and tables hold.
    """
    for value in values:
        if isinstance(value, tuple):
            _flatten(value, numbers, kinds)
        elif isinstance(value, ndarray):
            if not (value.flags.carray and value.ndim == 1):
                raise TypeError("the kernel takes columns that are contiguous and may be written")
            size, width = value.size, value.itemsize
            address = addressof(c_char.from_buffer(value)) if size else 0  # type: ignore[arg-type]
            numbers += (0, 0, size, width, address, size, width)
            kinds.append(value.dtype)
        else:
            numbers.append(value)


@cache
def _machine() -> tuple:
    """All that the code depends on beside the kernel's sources, which name the folder."""
    cpu = llvm.get_process_triple(), llvm.get_host_cpu_name(), llvm.get_host_cpu_features()
    settings = sorted((key, os.environ[key]) for key in os.environ if key.startswith("NUMBA_"))
    return *map(version, ("numba", "llvmlite")), sys.version, *map(str, cpu), settings


@contextlib.contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """One process compiles while others that start with it wait, where the system has locks.

    Not for ever: it may have been stopped.
    """
    handle = None
    try:
        with contextlib.suppress(ImportError, OSError):
            import fcntl

            folder.mkdir(parents=True, exist_ok=True)
            handle = os.open(folder, os.O_RDONLY)
            for _ in range(LOOKS):
                with contextlib.suppress(BlockingIOError):
                    fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
                    break
                sleep(ABANDONED / LOOKS)
        yield
    finally:
        if handle is not None:
            os.close(handle)


def _from_disk(path: Path) -> tuple[Any, int] | None:
    """(what owns the code, its address), or None."""
    content = read_intact(path)
    if content is None:
        return None
    with contextlib.suppress(OSError):
        os.utime(path)  # when it was used last
    symbol, _, code = content.partition(b"\n")
    try:
        return _linked(symbol.decode(), code)
    except Exception:  # a sum says that it was written so, not that it can be used
        return None


def _linked(symbol: str, code: bytes) -> tuple[Any, int]:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    machine = llvm.Target.from_triple(llvm.get_process_triple()).create_target_machine()
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    return engine, engine.get_function_address(symbol)


def _compiled(path: Path, name: str, args: tuple) -> tuple[Any, int]:
    """The same, compiled for these arguments and kept at the path."""
    from camcli.kernel.compiler import machine_code

    symbol, code = machine_code(ENTRIES[name], args)
    _keep(path, symbol.encode() + b"\n" + code)
    return _linked(symbol, code)


def _keep(path: Path, content: bytes) -> None:
    """Write a file with its SHA-256; beside its place first, so that nobody finds half of it.

    A file that a killed process left half written is removed, and code that nobody uses any more.
    """
    part = path.with_suffix(f".{uuid4().hex}")
    with contextlib.suppress(OSError):
        try:
            part.write_bytes(sha256(content).digest() + content)
            part.replace(path)
        finally:
            part.unlink(missing_ok=True)
    for other in path.parent.parent.glob("kernel-*/*"):
        with contextlib.suppress(OSError):
            unused = time() - other.stat().st_mtime
            if unused > (UNUSED if other.suffix == path.suffix else ABANDONED):
                other.unlink()
                other.parent.rmdir()
