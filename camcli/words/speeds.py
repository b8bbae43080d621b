"""Speeds in words: one with its error, a range, and those that a scene leaves open."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, floor, inf, isfinite, log10
from typing import TYPE_CHECKING

from camcli.analysis.natural_speed import Basis, Chosen
from camcli.quantities import SHAFTS
from camcli.system import decimals, omega_of

if TYPE_CHECKING:
    import numpy as np

MOST_DECIMALS = 9  # of a speed in rpm
LONE_SPACING = 0.1  # rpm: a lone speed is shown with the digits that tell it from so near a one


def number_range(low: float, high: float, digits: int = 10) -> str:
    """Two numbers as a range, `198.55 to 198.60`; a single one where both read alike.

    digits: significant ones of the larger end, at most; both ends have as many decimals.
    """
    ends = [f"{low:.{digits}g}", f"{high:.{digits}g}"]
    if ends[0] == ends[1]:
        return ends[0]
    if not any("e" in end for end in ends):
        largest = max(abs(low), abs(high))
        most = max(digits - 1 - floor(log10(largest)), 0)
        values = [round(value, most) + 0.0 for value in (low, high)]
        decimals_needed = (f"{value:.{digits}g}".partition(".")[2] for value in values)
        places = max(map(len, decimals_needed))
        ends = [f"{value:.{places}f}" for value in values]
    return " to ".join(ends)


def range_words(low: float, high: float) -> str:
    """`4111 to 4378 rpm`, with the digits that its width deserves."""
    if low == inf:
        return "never"
    if high == inf:
        return f"from {low:.4g} rpm on, or never"
    if low == high:
        return f"{low:.6g} rpm"
    form = f".{decimals(high - low)}f"
    return f"{low:{form}} to {high:{form}} rpm"


def speed_text(rpm: float, error: float) -> str:
    """The speed up to the decimal place of the error's first digit, without a unit."""
    if not isfinite(error) or error <= 0.0:
        return f"{rpm:.10g}"
    places = min(max(ceil(-log10(error)), 0), MOST_DECIMALS)
    return f"{rpm:.{places}f}"


def on_the_cam(kind: str = "") -> str:
    """Where a follower rests or starts: on the cam, or an oscillator's mass at its stop.

    kind: of the cam.
    """
    return "at the stop" if kind == "oscillator" else "on the cam"


def run_speed(rpm: float, kind: str = "") -> str:
    """The speed of a run, `700 rpm`; of an oscillator the frequency of its force, as it was typed.

    kind: of the cam.
    """
    if kind == "oscillator":
        return f"frequency {omega_of(rpm):.10g} rad/s"
    return f"{rpm:.10g} rpm"


def run_speeds(low: float, high: float, kind: str = "") -> str:
    """A range of speeds of runs; of an oscillator that of its frequency. kind: of the cam."""
    if kind == "oscillator":
        return f"{number_range(omega_of(low), omega_of(high))} rad/s"
    return f"{number_range(low, high)} rpm"


def at_speed(keys: Sequence[str], rpm: float, kind: str = "") -> str:
    """` at 700 rpm`: the speed of a run in which something else is varied; else empty.

    keys: what is varied; kind: of the cam. The speed of an oscillator is its frequency.
    """
    return "" if varies_speed(keys) else f" at {run_speed(rpm, kind)}"


def varies_speed(keys: Sequence[str]) -> bool:
    """Whether the speed is among what is varied; an oscillator's is its frequency."""
    return not {"rpm", "run.rpm", "cam.frequency"}.isdisjoint(keys)


def range_heads(key: str) -> list[str]:
    """The heads of the columns in which a range begins and ends; a title names other keys."""
    return ["from (rpm)", "to (rpm)"] if key == "rpm" else ["from", "to"]


def chosen_speeds(section: str, chosen: Chosen) -> str:
    """A note on the speeds that were chosen because the scene leaves them open."""
    speeds = f"{number_range(chosen.low, chosen.high, 6)} rpm"
    natural = chosen.by
    if natural is None:
        why = "as run.rpm is"
    elif natural.basis is Basis.FIRST_LOSS:
        why = f"chosen from the first loss of contact at {natural.rpm:.5g} rpm"
    elif natural.basis is Basis.NATURAL:
        why = f"chosen from the natural frequency, {natural.rpm:.5g} per minute"
    else:
        assert natural.basis is Basis.FALL
        why = "where the cam accelerates as the follower falls"
    return f"note: {section}.rpm is not given: it is {speeds} of the cam, {why}"


def of_both_shafts(low: float, high: float) -> str:
    """`2500 to 3000 rpm of the cam, 5000 to 6000 of the crank`."""
    turns = SHAFTS["crank"]
    crank = number_range(low / turns, high / turns)
    return f"{number_range(low, high)} rpm of the cam, {crank} of the crank"


def spacing(speeds: Sequence[float] | np.ndarray) -> float:
    """The least distance between neighbouring speeds, rpm; LONE_SPACING where there are no two."""
    import numpy as np

    steps = np.diff(np.sort(np.asarray(speeds, float)))
    steps = steps[steps > 0.0]
    return float(steps.min()) if steps.size else LONE_SPACING
