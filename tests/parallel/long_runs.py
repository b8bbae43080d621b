"""Runs that are killed and go on: what may be found in the folder, and that the end is the same."""

from __future__ import annotations

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from camcli.parallel.checkpoint import records

DYING = Path(__file__).with_name("dying.py")
SIGNALS = (signal.SIGKILL, signal.SIGINT, signal.SIGTERM)
ENDED = {130, -signal.SIGKILL, -signal.SIGINT, -signal.SIGTERM}  # SIGINT, SIGTERM: while starting
SOAK = int(os.environ.get("CAMCLI_SOAK", "0"))  # kills at random moments, of all tests together
STARTUP = 1.0  # s, of the command beside its work
kills: Counter[str] = Counter()


def command(*words: str) -> list[str]:
    """`cam` in a process of its own."""
    return [sys.executable, "-m", "camcli", *words]


def dying(where: str, number: int, how: str, *words: str) -> list[str]:
    """`cam` that kills itself: see dying.py."""
    return [sys.executable, str(DYING), where, str(number), how, *words]


def begin(words: list[str], cwd: Path, **options) -> subprocess.Popen:
    """Start it as a shell does in the foreground: SIGINT is not ignored."""
    return subprocess.Popen(
        words, cwd=cwd, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler), **options,
    )  # fmt: skip


def ended(process: subprocess.Popen) -> tuple[int, str]:
    """(exit code, stderr); nothing may hang."""
    said = process.communicate(timeout=600)[1]
    return process.returncode, said


def run(words: list[str], cwd: Path) -> tuple[int, str]:
    """Run to the end."""
    return ended(begin(words, cwd))


def files(folder: Path) -> dict[str, bytes]:
    """Artefacts of a folder, figures in folders of it included."""
    paths = [path for path in sorted(folder.rglob("*")) if path.is_file()]
    return {str(p.relative_to(folder)): p.read_bytes() for p in paths if p.name[0] != "."}


def but_record(found: dict[str, bytes]) -> dict[str, bytes]:
    """Without what holds times."""
    times = ("run.json", "figure.json", "index.html")
    return {name: data for name, data in found.items() if Path(name).name not in times}


@dataclass
class Case:
    """A command, what an earlier run left in its folder, and what it must leave there."""

    cwd: Path
    words: tuple[str, ...]
    earlier: tuple[str, ...]
    seconds: float = 0.0
    old: dict[str, bytes] = field(default_factory=dict)
    new: dict[str, bytes] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Run both, each uninterrupted."""
        self.cwd.mkdir(parents=True, exist_ok=True)
        assert run(command(*self.words, *self.earlier, "-o", "old"), self.cwd)[0] == 0
        began = time.perf_counter()
        assert run(command(*self.words, "-o", "new"), self.cwd)[0] == 0
        self.seconds = time.perf_counter() - began
        self.old, self.new = files(self.cwd / "old"), files(self.cwd / "new")
        alone = json.loads(self.new["run.json"])["cost"]["seconds"]  # without compiling
        self.seconds = min(self.seconds, alone + STARTUP)
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

    def begin(self) -> subprocess.Popen:
        """Start the run."""
        return begin(command(*self.words, "-o", "out"), self.cwd)

    def die(self, where: str, number: int, how: str) -> tuple[int, str]:
        """Let the run kill itself."""
        kills[how] += 1
        return run(dying(where, number, how, *self.words, "-o", "out"), self.cwd)

    def check(self) -> int:
        """Every artefact is old or new, and whole; the number of new ones."""
        found, count = files(self.folder), 0
        assert set(found) <= set(self.old) | set(self.new)
        assert set(found) >= set(self.old) & set(self.new)
        for name, data in found.items():
            is_new = data == self.new.get(name)
            if name == "run.json" and data != self.old[name]:
                is_new = json.loads(data)["artefacts"] == json.loads(self.new[name])["artefacts"]
            assert is_new or data == self.old.get(name), name
            count += is_new and data != self.old.get(name)
        return count

    def finish(self) -> str:
        """Run to the end: all is new, nothing else is left; what it said."""
        code, said = run(command(*self.words, "-o", "out"), self.cwd)
        assert code == 0, said
        assert but_record(files(self.folder)) == but_record(self.new)
        assert not list(self.folder.glob(".*"))
        return said


def soak(case: Case, seed: int, count: int) -> int:
    """Kill it again and again at random moments, the same work going on; kills that met it."""
    rng, met = random.Random(seed), 0
    while met < count:
        how, early = rng.choice(SIGNALS), rng.random() < 0.2
        wait = rng.uniform(0.0, 0.2) if early else rng.uniform(0.25, 1.0) * case.seconds
        process = case.begin()
        time.sleep(wait)
        process.send_signal(how)
        code, said = ended(process)
        assert "internal fault" not in said
        early = "KeyboardInterrupt" in said and "camcli" not in said  # Python was still starting
        assert code == 0 or code in ENDED or early, (how, code, said)
        case.check()
        if code == 0:
            assert but_record(files(case.folder)) == but_record(case.new)
            case.reset()
        else:
            met += 1
            kills[how.name] += 1
    case.finish()
    case.reset()
    return met


def of_folder(folder: Path) -> set[int]:
    """Processes alive whose command names the folder."""
    found = set()
    for path in Path("/proc").glob("[0-9]*"):
        try:
            words = (path / "cmdline").read_bytes()
            state = (path / "stat").read_text().rpartition(")")[2].split()[0]
        except OSError:
            continue
        if str(folder).encode() in words and state != "Z":
            found.add(int(path.name))
    return found


def gone(folder: Path, seconds: float = 10.0) -> bool:
    """True as soon as no process names the folder any more."""
    until = time.monotonic() + seconds
    while of_folder(folder):
        if time.monotonic() > until:
            return False
        time.sleep(0.05)
    return True


def at_work(folder: Path, pieces: int = 2, seconds: float = 60.0) -> bool:
    """True as soon as some pieces are on disk."""
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        for path in folder.glob("*.pieces"):
            with suppress(OSError), open(path, "rb") as file:
                if sum(1 for _ in records(file)) > pieces:
                    return True
        time.sleep(0.02)
    return False
