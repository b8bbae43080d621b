"""What hostile input may cost, and what may come of it; strategies that several fuzzes share.

CAMCLI_FUZZ raises the number of examples of every fuzz; CONTRIBUTING.md has the whole command.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
import shlex
import signal
from collections.abc import Iterator, Sequence
from functools import lru_cache
from math import radians
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st

from camcli.analysis.integrate import Settings, Start
from camcli.analysis.simulate import simulate
from camcli.cams.compile import phase_of
from camcli.errors import SceneError, Status
from camcli.scene import Scene, load_scene, resolved, scene_hash
from camcli.system import Follower, System
from tests.conftest import cam_in

SECONDS = 30.0  # of processor time, for one example; most take milliseconds, a plan may take 10 s


def fuzz(examples: int) -> settings:
    """Settings of a fuzz with so many examples, or as many as CAMCLI_FUZZ asks for."""
    return settings(
        max_examples=int(os.environ.get("CAMCLI_FUZZ", examples)),
        derandomize="CAMCLI_FUZZ" not in os.environ,
        deadline=None,  # `limited` measures the processor's time instead
        database=None,
        suppress_health_check=list(HealthCheck),
    )


class TooLongError(BaseException):
    """An example that hangs; no `except Exception` may catch it."""


@contextlib.contextmanager
def limited(seconds: float = SECONDS) -> Iterator[None]:
    """Raise TooLongError where the block takes more of the processor's time."""

    def stop(*_):
        raise TooLongError

    before = signal.signal(signal.SIGVTALRM, stop)
    signal.setitimer(signal.ITIMER_VIRTUAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        signal.signal(signal.SIGVTALRM, before)


def accepted(call):
    """What `call` returns, or None where it refuses; every fault is one clear line."""
    faults = ()
    try:
        with limited():
            return call()
    except SceneError as error:
        faults = error.faults
    assert faults
    for fault in faults:
        assert str(fault).isprintable()
        assert len(str(fault)) < 2000
        assert fault.found
    return None


def command_line(words: Sequence[str]) -> tuple[int, str]:
    """(exit code, stderr) of `cam words...` in this process."""
    with limited():
        done = cam_in(Path.cwd(), *map(shlex.quote, words))
    return done.returncode, done.stderr


@contextlib.contextmanager
def plain_kernel(steps: int = 200) -> Iterator[None]:
    """The kernel in plain Python, where bad arithmetic raises, with few steps between impacts."""
    from camcli.kernel import backend
    from camcli.kernel import orbit_loop as orbit

    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("CAMCLI_KERNEL", "python")
        patch.setattr(backend, "_compiled", None)
        patch.setattr(orbit, "MOST_STEPS_BETWEEN", steps)
        yield


@lru_cache(maxsize=32)
def machine(cam, strobe_deg: float) -> System:
    """A machine on a cam: most examples share one, and it is most of the work."""
    return System.build(Follower(1, 1), cam, phase_of(strobe_deg))


def run_one_turn(scene: Scene) -> None:
    """The cam compiles and a turn is computed, with finite numbers and a status that has words."""
    run = scene.run
    changes = scene.follower.model_dump()
    system = machine(scene.cam, run.strobe_deg).with_follower(**changes)
    start = Start(run.start.q, run.start.v, radians(run.start.theta_deg))
    settings = Settings(0, 1, run.chatter_tolerance, min(run.impact_budget, 50), start)
    result = simulate(system, run.rpm, settings, 3)
    assert result.status in list(Status)
    numbers = [x for row in (*result.trajectory, *result.events) for x in row]
    assert all(math.isfinite(x) for x in numbers if isinstance(x, float))
    json.dumps(resolved(scene), allow_nan=False)
    assert len(scene_hash(scene)) == 64


def load_and_run(*arguments) -> None:
    """A scene is refused, or a turn of it is computed or refused."""
    scene = accepted(lambda: load_scene(*arguments))
    if scene is not None:
        accepted(lambda: run_one_turn(scene))


FIGURES = """
0 -0 -0.0 1 -1 0.5 2 1e-3 5e-324 -5e-324 1e-310 2.2250738585072014e-308 1e-300 1e-160 1e-30
1e-15 1e-9 1e-6 0.9999999999999999 1.0000000000000002 359.99999999999994 360 180 140
140.00000000000003 1e3 1e6 1e9 1e12 1e15 -1e15 1e16 1e300 1.7976931348623157e308 1e400 .nan .inf
-.inf 1000000000000 16384 100000 10000000
"""
NUMBERS = st.sampled_from(FIGURES.split()) | st.floats(allow_nan=False).map(repr)
ODD = st.sampled_from(
    ["", "~", "null", "true", "on", "no", "yes", "1:30", "010", "0x1F", "1_000", "1,5", "1e-3 m",
     "'1'", '"1e-3"', "[]", "{}", "[1, 2]", "[0, 0]", "[1, 0]", "{a: 1}", "[[1]]", "٣", "１", "−5",
     "1\u00a0000", "!!float 1", "!!python/object:os.system x", "&a 1", "*a", "<<: 1", "[impacts]",
     "[strobe, strobe]", "arcs", "table", "law", "eccentric", "../../etc/passwd", "/dev/zero",
     "/dev/stdin", ".", "a\x00b", '"\\e[2J"', "é", "9" * 400, "1" * 5000, "- 1", ": 1", "# 1"]
)  # fmt: skip
VALUES = st.one_of(NUMBERS, NUMBERS, ODD, st.text(max_size=12))
