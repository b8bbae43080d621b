"""Figures computed side by side, each by its own command in a process of its own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

from camcli.cli.exit_codes import DONE, INTERRUPTED, NUMERICS
from camcli.cli.figures_plan import STATE, Figure, sizes
from camcli.cli.parent_watch import PARENT
from camcli.output.run_folder import run_folder
from camcli.parallel import thread_count

KEEP = (DONE, NUMERICS)  # exit codes of a run whose artefacts are whole


@dataclass(frozen=True)
class Done:
    """One computed figure: exit code of its command, what it said, and its wall time."""

    name: str
    code: int
    notes: list[str]
    seconds: float


def compute(
    figures: Sequence[Figure],
    out: Path,
    sets: Sequence[str],
    threads: int | None,
    on_done: Callable[[Done], None],
) -> list[Done]:
    """Run the figures in this order, as many at a time as there are threads.

    A finished figure is marked as such at once; on an interrupt the running ones are ended.
    """
    count = thread_count(threads)
    share = max(1, count // max(1, len(figures)))
    crew = _Crew()

    def piece(figure: Figure) -> Done:
        folder = out / figure.name
        folder.mkdir(parents=True, exist_ok=True)
        (folder / STATE).unlink(missing_ok=True)  # until it is whole again
        done = crew.run(figure, folder, sets, share)
        if done.code in KEEP:
            _mark(figure, folder, done)
        on_done(done)
        return done

    with ThreadPoolExecutor(count) as pool:  # it waits for what runs, so that it can be ended
        futures = [pool.submit(piece, figure) for figure in figures]
        try:
            return [future.result() for future in futures]
        except BaseException:
            crew.end()
            raise


class _Crew:
    """The processes at work, so that an interrupt can end them."""

    def __init__(self) -> None:
        self.running: set[subprocess.Popen] = set()
        self.ended = False
        self.lock = threading.Lock()

    def run(self, figure: Figure, folder: Path, sets: Sequence[str], threads: int) -> Done:
        """Run one figure's command and wait for it."""
        words = [sys.executable, "-m", "camcli", *figure.words, "-c", str(figure.path)]
        words += [word for text in sets for word in ("--set", text)]
        words += ["-o", str(folder), "--quiet", "--json", "--threads", str(threads)]
        began = perf_counter()
        with self.lock:
            if self.ended:
                return Done(figure.name, INTERRUPTED, [], 0.0)
            process = subprocess.Popen(
                words,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.PIPE,
                text=True,
                env={**os.environ, PARENT: str(os.getpid())},
            )
            self.running.add(process)
        _, said = process.communicate()
        with self.lock:
            self.running.discard(process)
        return Done(figure.name, process.returncode, said.splitlines(), perf_counter() - began)

    def end(self) -> None:
        """Interrupt what runs, and start nothing more."""
        with self.lock:
            self.ended = True
            for process in self.running:
                process.terminate()


def _mark(figure: Figure, folder: Path, done: Done) -> None:
    state = {
        "title": figure.title,
        "command": figure.shown_command,
        "hashes": figure.hashes,
        "exit": done.code,
        "notes": done.notes,
        "seconds": round(done.seconds, 3),
        "files": sizes(folder),
    }
    with run_folder(folder) as store:
        store.write_text(STATE, [json.dumps(state, indent=2) + "\n"])
        store.commit()
