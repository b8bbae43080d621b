"""What the bench asks of the command line: cams by their section, and whole runs of `cam`."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Mapping, Sequence
from tempfile import TemporaryDirectory
from typing import Any

from camcli.analysis.bench.machine import Bench, Done
from camcli.analysis.bench.scenes import LONGEST, STOPPED
from camcli.cams.pieces import Part


def parts_of(section: Mapping[str, Any]) -> list[Part]:
    """Smooth parts of the cam of a scene's section."""
    from pydantic import TypeAdapter

    from camcli.scene import Cam

    return TypeAdapter(Cam).validate_python(dict(section)).parts()


def command(words: Sequence[str]) -> Done:
    """`cam WORDS` in a process of its own, in an empty folder."""
    with TemporaryDirectory(prefix="cam-bench-") as folder:
        try:
            done = subprocess.run(
                [sys.executable, "-m", "camcli", *words],
                cwd=folder,
                capture_output=True,
                text=True,
                check=False,
                timeout=LONGEST,
            )
        except subprocess.TimeoutExpired:
            return Done(STOPPED, "", f"stopped after {LONGEST:g} s")
    return Done(done.returncode, done.stdout, done.stderr)


def bench_of() -> Bench:
    """The bench, with real cams and a real command line."""
    return Bench(parts_of, command)
