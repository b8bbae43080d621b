"""The kernel's entries as machine code: checked code, from the disk or made anew.

Importing numba takes longer than most runs, so it is imported to compile, and not to run: code on
disk is loaded by LLVM alone. `compiler` makes that code with parts of numba that may change with
any version of it. Where it fails, or where what it makes is not believed, numba's public functions
make the code (`public_compiler`).

Nothing is believed before `self_check` has compared a small case of the entry with plain Python,
bit for bit. Code that ended a process while it was tried is not tried again: what was on disk is
removed, and what has just been made gives way to the public way when it has ended MOST_DEATHS
processes. One may have been killed by somebody else.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext, suppress
from hashlib import sha256
from pathlib import Path
from threading import Lock
from typing import Any

from camcli.errors import Fault, SceneError
from camcli.installed import version
from camcli.interrupts import compiling
from camcli.kernel import code_cache
from camcli.kernel.code_cache import News
from camcli.kernel.machine_code import MachineCode, flatten, form_of
from camcli.kernel.marks import ENTRIES
from camcli.kernel.self_check import case_of, is_right
from camcli.piece_faults import SHORTAGES

MOST_DEATHS = 2
SLOWER = "CAMCLI_KERNEL=python runs without it, some hundred times slower"


# One entry at a time, of all threads: numba and LLVM are imported, and compile and load, by one.
_at_a_time = Lock()


class CompiledEntry:
    """An entry that is loaded or compiled at its first call; it takes what that call takes."""

    def __init__(
        self, source: CodeSource, name: str, waiting: Callable[[], AbstractContextManager]
    ):
        self._source, self._name, self._waiting = source, name, waiting
        self._call: Callable | None = None

    def __call__(self, cam: tuple, *args: Any) -> Any:
        call = self._call or self._load((cam, *args))
        return call(cam, *args)

    def _load(self, args: tuple) -> Callable:
        with self._waiting(), _at_a_time, compiling():
            if self._call is None:
                self._call = self._source.code(self._name, args)
            return self._call


def compile_entries(
    folder: Path,
    waiting: Callable[[], AbstractContextManager],
    tell: Callable[[News], None],
) -> dict[str, CompiledEntry]:
    """The entries by name, compiled at their first call; `waiting` is entered while that lasts.

    Code is read from `folder` and kept there. What cannot be read, or is damaged, is compiled
    again; what cannot be written is not kept.
    """
    source = CodeSource(folder, tell)
    return {name: CompiledEntry(source, name, waiting) for name in ENTRIES}


class CodeSource:
    """Where checked machine code comes from; `tell` is called with what a user may want to know."""

    def __init__(self, folder: Path, tell: Callable[[News], None]):
        self._folder, self._tell = folder, tell
        self._public = False  # True: the public way was taken in this process

    def code(self, name: str, args: tuple) -> Callable:
        """The entry of this name for arguments like these."""
        entry = _Entry(self._folder, name, args)
        code_cache.make_folder(self._folder)
        if os.path.lexists(self._folder) and not code_cache.is_trusted(self._folder):
            self._tell(News.NOT_OURS)
        call = self._kept(entry)
        if call is None:
            self._tell(News.COMPILING)
            with code_cache.alone(self._folder):
                call = self._kept(entry) or self._made(entry)
        return call

    def _kept(self, entry: _Entry) -> Callable | None:
        """What is on disk, if it is right; what is not is removed."""
        if not code_cache.is_trusted(self._folder):
            return None
        if self._takes_public_way():
            return self._by_numba(entry) if _is_kept_by_numba(self._numba_folder, entry) else None
        marks = code_cache.deaths(self._folder, entry.trial_of_kept)
        if marks:
            self._tell(News.KILLED)
            _discard(entry.file, *marks)
            return None
        try:
            content = code_cache.read_code(entry.file)
            if content is None:
                return None
            call = entry.tried(content, entry.trial_of_kept)
        except code_cache.DamagedCodeError:
            call = None
        if call is None:
            self._tell(News.DAMAGED)
            _discard(entry.file)
        return call

    def _made(self, entry: _Entry) -> Callable:
        """The entry compiled, checked and kept."""
        marks = code_cache.deaths(self._folder, entry.trial_of_made)
        if len(marks) < MOST_DEATHS and not self._takes_public_way():
            content = _made_by_us(entry)
            call = None if content is None else entry.tried(content, entry.trial_of_made)
            if content is not None and call is not None:
                if code_cache.is_trusted(self._folder):
                    code_cache.keep_code(entry.file, content)
                _discard(*marks)
                return call
        return self._by_numba(entry)

    @property
    def _numba_folder(self) -> Path:
        """Folder of the code that the public way keeps; it is there where that way is taken."""
        return self._folder / f"numba-{code_cache.machine_key()}"

    def _takes_public_way(self) -> bool:
        return self._public or code_cache.is_trusted(self._numba_folder)

    def _by_numba(self, entry: _Entry) -> Callable:
        """The entry by the public way, which is taken from now on."""
        import_numba()
        from camcli.kernel.public_compiler import compiled_entry

        self._tell(News.PUBLIC)
        self._public, folder = True, self._numba_folder
        marks = code_cache.deaths(self._folder, entry.trial_of_numba)
        if marks:
            self._tell(News.KILLED)
            _discard(folder, *marks)
        places = [folder, None] if _prepare_for_numba(folder) else [None]
        with code_cache.on_trial(self._folder, entry.trial_of_numba):
            for place in places:
                call = compiled_entry(entry.name, place)
                # what numba has kept may be damaged in any way; what it has just made may not
                with nullcontext() if place is None else suppress(Exception):
                    if is_right(entry.name, call):
                        return call
                _discard(folder)
        raise RuntimeError(
            f"numba {version('numba')} makes other numbers of '{entry.name}' than Python; {SLOWER}"
        )


class _Entry:
    """An entry with the kinds of its arguments, and the names under which it is kept and tried."""

    def __init__(self, folder: Path, name: str, args: tuple):
        self.name, self.args = name, args
        self.numbers: list = []
        self.kinds: list = []
        flatten(args, self.numbers, self.kinds)
        types = _types(args)
        if types != _types(case_of(name)):
            raise TypeError(f"'{name}' is called with other kinds of arguments than in its check")
        stem = f"{name}.{code_cache.machine_key()}.{sha256(types.encode()).hexdigest()[:16]}"
        self.file = folder / (stem + code_cache.CODE)
        self.trial_of_kept = f"{stem}.kept"
        self.trial_of_made = f"{stem}.made"
        self.trial_of_numba = f"{stem}.numba"

    def tried(self, content: bytes, trial: str) -> Callable | None:
        """The code, if it can be loaded and does what plain Python does."""
        symbol, _, code = content.partition(b"\n")
        with code_cache.on_trial(self.file.parent, trial), suppress(Exception):
            call = MachineCode(self.name, symbol.decode(), code, self.numbers, self.kinds)
            if is_right(self.name, call):
                return call
        return None


def import_numba() -> None:
    """Import numba, which some settings and a broken installation prevent; raises SceneError."""
    threads = os.environ.get("NUMBA_NUM_THREADS", "1").strip()
    if threads.lstrip("+-").isdecimal() and int(threads) < 1:
        found, expected = f"found '{threads}'", "expected a whole number above 0"
        raise SceneError(Fault("NUMBA_NUM_THREADS", "", found, expected, "or unset it"))
    try:
        import numba  # noqa: F401 - whether it can be imported
    except Exception as error:
        if isinstance(error, MemoryError) or any(words in str(error) for words in SHORTAGES):
            raise
        found = f"cannot be imported ({type(error).__name__}: {error})"
        cure = f"install it again; {SLOWER}"
        raise SceneError(Fault("numba", "", found, "", cure)) from error


def _made_by_us(entry: _Entry) -> bytes | None:
    """The content of a file of code, or None where this numba is not the one that we know."""
    try:
        from camcli.kernel.compiler import machine_code

        symbol, code = machine_code(ENTRIES[entry.name], entry.args)
    except (MemoryError, OSError):
        raise
    except Exception:
        return None
    return symbol.encode() + b"\n" + code


def _types(args: tuple) -> str:
    """The kinds of arguments, which decide about the machine code."""
    numbers: list = []
    kinds: list = []
    flatten(args, numbers, kinds)
    return repr(([kind.descr for kind in kinds], form_of(numbers)))


def _discard(*paths: Path) -> None:
    for path in paths:
        code_cache.discard(path)


def _is_kept_by_numba(folder: Path, entry: _Entry) -> bool:
    """Whether numba has an index of this entry in the folder; only time depends on it."""
    return any(path.is_file() for path in folder.glob(f"*/*.{entry.name}-*.nbi"))


def _prepare_for_numba(folder: Path) -> bool:
    """Make the folder safe for numba, which opens what it finds; False if nothing can be kept."""
    if not code_cache.is_trusted(folder.parent):
        return False
    code_cache.make_folder(folder)
    with suppress(OSError):
        folder.chmod(0o700)  # numba makes files that a group may write, where the user lets it
        os.utime(folder)  # when it was used last
    for path in folder.rglob("*"):
        if not code_cache.is_plain(path):
            code_cache.discard(path)
    return code_cache.is_trusted(folder) and os.access(folder, os.W_OK)
