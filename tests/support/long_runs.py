"""Runs that are killed and go on: what may be found in the folder, and that the end is the same.

Most runs are forks of the test's own process, which spares each the start of Python; those that are
killed at random moments, or have children, are processes of their own.
"""

from __future__ import annotations

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import chdir, redirect_stderr, redirect_stdout, suppress
from dataclasses import dataclass, field
from hashlib import sha256
from io import StringIO
from math import inf
from pathlib import Path
from tempfile import TemporaryFile

import camcli.cli.sweep  # noqa: F401 - once here, not in each fork
from camcli.cli.app import app
from camcli.cli.app import main as cam_main
from camcli.parallel import checkpoint
from camcli.parallel.checkpoint import Checkpoint, records
from camcli.parallel.work import Kept

SIGNALS = (signal.SIGKILL, signal.SIGINT, signal.SIGTERM)
OWN = 8  # see Case.soak
SOAK = int(os.environ.get("CAMCLI_SOAK", "0"))  # kills at random moments of the soak
TIMES = ("run.json", "figure.json", "index.html")  # files that hold times
TIMED = ("precision.csv", "stability.csv")  # and tables with a column of them


class Fork:
    """`cam` in a fork of this process; `arm` is called in it before."""

    def __init__(self, words: tuple[str, ...], cwd: Path, arm: Callable[[], None] = lambda: None):
        """Fork; the child becomes `cam WORDS` in a folder, with stderr in a file and no stdout.

        It ends with the exit code of the command: 130 where it is interrupted before the command
        has begun, 99 where something else went wrong. An interrupt waits until the child can take
        it as its own: before, it would be one of the test run, of which the child is a copy.
        """
        self.said = TemporaryFile("w+")  # noqa: SIM115 - as long as the process
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        self.pid = os.fork()
        if self.pid == 0:
            try:
                os.chdir(cwd)
                nowhere = os.open(os.devnull, os.O_RDWR)
                for k, handle in enumerate((nowhere, nowhere, self.said.fileno())):
                    os.dup2(handle, k)
                sys.stdout, sys.stderr = open(1, "w"), open(2, "w")  # noqa: SIM115
                signal.signal(signal.SIGINT, signal.default_int_handler)
                signal.pthread_sigmask(signal.SIG_SETMASK, before)
                sys.argv = ["cam", *words]
                arm()
                cam_main()
            except KeyboardInterrupt:  # before `cam` has begun
                os._exit(130)
            except SystemExit as end:
                sys.stderr.flush()
                os._exit(end.code or 0)
            finally:
                os._exit(99)
        signal.pthread_sigmask(signal.SIG_SETMASK, before)

    def poll(self) -> bool | None:
        """None while it runs, then True; the child stays to be waited for."""
        return os.waitid(os.P_PID, self.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) and True

    def send_signal(self, which: int) -> None:
        """As a terminal, or a batch system, would."""
        os.kill(self.pid, which)

    def ended(self) -> tuple[int, str]:
        """Wait for the process: (exit code, what it wrote to stderr)."""
        _, status = os.waitpid(self.pid, 0)
        self.said.seek(0)
        with self.said:
            return os.waitstatus_to_exitcode(status), self.said.read()


def cam(words: tuple[str, ...], cwd: Path, arm: Callable[[], None] = lambda: None):
    """(exit code, stderr) of `cam` in a fork."""
    return Fork(words, cwd, arm).ended()


def with_options(words: tuple[str, ...], options: tuple[str, ...]) -> tuple[str, ...]:
    """The words of a command with other values of some options, each followed by its value."""
    given = set(options[::2]) - {"--set"}  # which may be given many times
    kept = []
    for before, word in zip(("", *words), words, strict=False):
        if word not in given and before not in given:
            kept.append(word)
    return (*kept, *options)


def command(*words: str) -> list[str]:
    """`cam` in a process of its own."""
    return [sys.executable, "-m", "camcli", *words]


def begin(words: list[str], cwd: Path, **options) -> subprocess.Popen:
    """Start it as a shell does in the foreground: SIGINT is not ignored."""
    return subprocess.Popen(
        words, cwd=cwd, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler), **options,
    )  # fmt: skip


def ended(process: subprocess.Popen | Fork, most: float = 600) -> tuple[int, str]:
    """(exit code, stderr); nothing may hang."""
    if isinstance(process, Fork):
        return process.ended()
    said = process.communicate(timeout=most)[1]
    return process.returncode, said


def dying(where: str, number: int, how: str) -> Callable[[], None]:
    """What makes `cam` kill itself.

    where: half (half of a piece is on disk), put (a piece is), fsync (an artefact is written beside
    its place), replace (it is about to go there), unlink (a file is about to go).
    """
    owner, name = {
        "half": (Checkpoint, "put"), "put": (Checkpoint, "put"), "unlink": (Path, "unlink"),
    }.get(where, (os, where))  # fmt: skip
    original, left = getattr(owner, name), number

    def end() -> None:
        os.kill(os.getpid(), signal.Signals[how])

    def counted(*args, **options):
        """The call, or at the last one that is wanted the end of the process."""
        nonlocal left
        left -= 1
        if left == 0 and where == "half":
            args[0]._file = _Half(args[0]._file, end)
        elif left == 0:
            end()
        return original(*args, **options)

    def arm() -> None:
        checkpoint.QUICK = -1.0  # each piece is written
        checkpoint.SYNC = inf  # else a slow machine waits for the disk before
        setattr(owner, name, counted)

    return arm


class _Half:
    """A file of which the next write is cut in the middle."""

    def __init__(self, file, end):
        self.file, self.end = file, end

    def __getattr__(self, name):
        return getattr(self.file, name)

    def write(self, data):
        """Half of it, then the end; what is written on the way out is whole."""
        done = self.file.write(data[: len(data) // 2])
        self.write = self.file.write
        self.end()
        return done


def slow(milliseconds: int) -> Callable[[], None]:
    """A function that makes every piece take so much longer to be kept, for `arm` of `Fork`."""
    put = Kept.put

    def slowly(*args):
        time.sleep(milliseconds / 1000)
        return put(*args)

    return lambda: setattr(Kept, "put", slowly)


def files(folder: Path) -> dict[str, bytes]:
    """Artefacts of a folder, figures in folders of it included."""
    paths = [path for path in sorted(folder.rglob("*")) if path.is_file()]
    return {str(p.relative_to(folder)): untimed(p) for p in paths if p.name[0] != "."}


def untimed(path: Path) -> bytes:
    """A file's bytes, without the column `seconds` of a table that has it."""
    if path.name not in TIMED:
        return path.read_bytes()
    rows = [line.split(",") for line in path.read_text().splitlines()]
    seconds = rows[0].index("seconds")
    return repr([row[:seconds] + row[seconds + 1 :] for row in rows]).encode()


def but_record(found: dict[str, bytes]) -> dict[str, bytes]:
    """Without what holds times."""
    return {name: data for name, data in found.items() if Path(name).name not in TIMES}


@dataclass
class Case:
    """A command, what an earlier run left in its folder, and what it must leave there.

    before: commands whose files it reads; children: whether it has processes of its own.
    """

    cwd: Path
    words: tuple[str, ...]
    earlier: tuple[str, ...] | None
    before: tuple[tuple[str, ...], ...] = ()
    children: bool = False
    old: dict[str, bytes] = field(default_factory=dict)
    new: dict[str, bytes] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Run the command as before and anew, uninterrupted, to compare killed runs with."""
        for words in self.before:
            assert cam(words, self.cwd)[0] == 0
        (self.cwd / "old").mkdir()
        if self.earlier is not None:
            words = with_options(self.words, self.earlier)
            assert cam((*words, "-o", "old"), self.cwd)[0] == 0
        assert cam((*self.words, "-o", "new"), self.cwd)[0] == 0
        self.old, self.new = files(self.cwd / "old"), files(self.cwd / "new")
        assert but_record(self.old) != but_record(self.new)
        self.reset()

    @property
    def folder(self) -> Path:
        """Where the killed runs write."""
        return self.cwd / "out"

    def reset(self) -> None:
        """The earlier run's artefacts, and nothing else."""
        shutil.rmtree(self.folder, ignore_errors=True)
        shutil.copytree(self.cwd / "old", self.folder)

    def die(self, where: str, number: int, how: str) -> tuple[int, str]:
        """Let the run kill itself."""
        return cam((*self.words, "-o", "out"), self.cwd, dying(where, number, how))

    def check(self) -> int:
        """Every artefact is old or new, and whole; the number of new ones."""
        found, count = files(self.folder), 0
        assert set(found) <= set(self.old) | set(self.new)
        assert set(found) >= set(self.old) & set(self.new)
        for name, data in found.items():
            is_new, path = data == self.new.get(name), self.folder / name
            if path.name == "run.json" and data != self.old.get(name):
                listed = json.loads(data)["artefacts"]
                is_new = all(
                    sha256((path.parent / artefact).read_bytes()).hexdigest() == digest
                    for artefact, digest in listed.items()
                )
            elif path.name in TIMES:
                is_new = data != self.old.get(name)
            assert is_new or data == self.old.get(name), name
            count += is_new and data != self.old.get(name)
        return count

    def finish(self) -> str:
        """Run to the end: all is new, nothing else is left; what it said."""
        code, said = cam((*self.words, "-o", "out"), self.cwd)
        assert code == 0, said
        assert but_record(files(self.folder)) == but_record(self.new)
        assert list(self.folder.glob(".*")) == []
        return said

    def soak(self, seed: int, count: int, cold: bool = False) -> dict[str, float]:
        """Kill it so many times at random moments, the same work going on; what was seen.

        longest: s from a signal to the end; ended: runs that were at their end already when the
        signal came, and latest: the longest of them, where a lost signal would be seen. cold: the
        kernel is compiled. One in OWN is a process of its own, the others are forks of this one,
        which spares their start.
        """
        rng, met, seen = random.Random(seed), 0, {"longest": 0.0, "ended": 0, "latest": 0.0}
        env = {**os.environ, "CAMCLI_KERNEL": "compiled" if cold else "auto"}
        if cold:
            env["XDG_CACHE_HOME"] = str(self.cwd / "cache")
        words, seconds = (*self.words, "-o", "out"), {}

        def start(own: bool) -> Fork | subprocess.Popen:
            return begin(command(*words), self.cwd, env=env) if own else Fork(words, self.cwd)

        always_own = cold or self.children
        if not always_own:  # what it imports, forks have then
            with chdir(self.cwd), redirect_stdout(StringIO()), redirect_stderr(StringIO()):
                app(list(words), standalone_mode=False)
        for own in (True,) if always_own else (True, False):
            began = time.monotonic()
            assert ended(start(own))[0] == 0
            seconds[own] = time.monotonic() - began
        self.reset()
        while met < count:
            shutil.rmtree(self.cwd / "cache", ignore_errors=True)
            how, own = rng.choice(SIGNALS), always_own or rng.random() < 1.0 / OWN
            process = start(own)
            time.sleep(rng.random() * seconds[own])
            alive, began = process.poll() is None, time.monotonic()
            process.send_signal(how)
            code, said = ended(process)
            took = time.monotonic() - began
            assert not self.children or gone(str(self.cwd))
            assert "internal fault" not in said
            starting = code == -how or ("KeyboardInterrupt" in said and "camcli" not in said)
            assert code in (0, 130) or starting, (how, code, said)
            self.check()
            if code == 0:
                assert but_record(files(self.folder)) == but_record(self.new)
                self.reset()
                seen["ended"] += alive
                seen["latest"] = max(seen["latest"], took * alive)
            else:
                met += 1
                seen["longest"] = max(seen["longest"], took * (how != signal.SIGKILL))
        self.finish()
        return seen


def gone(mark: str, seconds: float = 10.0) -> bool:
    """True as soon as no process names a folder, or belongs to a group, any more."""
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        listed = subprocess.run(["ps", "-eo", "pgid,stat,args"], capture_output=True, text=True)
        rows = [line.split(None, 2) for line in listed.stdout.splitlines()[1:]]
        if not any(state[0] != "Z" and (mark in words or mark == g) for g, state, words in rows):
            return True
        time.sleep(0.1)
    return False


def at_work(folder: Path, pieces: int = 2, seconds: float = 60.0) -> bool:
    """Wait until some pieces are on disk; False where that takes too long."""
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        for path in folder.glob("*.pieces"):
            with suppress(OSError), open(path, "rb") as file:
                if sum(1 for _ in records(file)) > pieces:
                    return True
        time.sleep(0.02)
    return False
