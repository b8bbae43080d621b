"""An orbit that does not exist at a speed: where does the nearest one begin?"""

from __future__ import annotations

from dataclasses import dataclass

from camcli.analysis.integrate import Settings
from camcli.analysis.orbits.arclength import Span
from camcli.analysis.orbits.branch_segment import follow
from camcli.analysis.orbits.find import find
from camcli.analysis.orbits.orbit import PeriodicOrbit, from_root
from camcli.analysis.orbits.shooter import Shooter
from camcli.analysis.orbits.sticking_orbits import follow_resting
from camcli.system import System

SPEEDS = 24  # tried, spread over the range
FEW_STARTS = 8  # motions simulated at each
AROUND = 0.2  # relative range where none is given


@dataclass(frozen=True)
class Absence:
    """A label that was not found at `rpm`.

    orbit: one with that label at the nearest speed that was tried; nearest: the speed closest to
    `rpm` that its branch reaches, and what ends it there.
    """

    rpm: float
    low: float
    high: float
    orbit: PeriodicOrbit | None = None
    nearest: tuple[float, str] | None = None


def look_around(
    system: System, settings: Settings, rpm: float, label: str, span: tuple[float, float] | None
) -> Absence:
    """Look for the label at other speeds, nearest first, and follow its branch towards `rpm`."""
    low, high = span or (rpm * (1.0 - AROUND), rpm * (1.0 + AROUND))
    speeds = [low + (high - low) * (k / (SPEEDS - 1)) for k in range(SPEEDS)]
    for speed in sorted(speeds, key=lambda x: abs(x - rpm)):
        found = find(system, speed, settings, FEW_STARTS, label, FEW_STARTS)
        if found.orbits:
            orbit = found.orbits[0]
            return Absence(rpm, low, high, orbit, _reach(system, settings, orbit, rpm, label))
    return Absence(rpm, low, high)


def _reach(system, settings, orbit: PeriodicOrbit, rpm: float, label: str) -> tuple[float, str]:
    """The speed nearest to `rpm` on the orbit's branch with this label, and what ends it."""
    shooter = Shooter(system, orbit.rpm)
    up = rpm > orbit.rpm
    width = abs(rpm - orbit.rpm)
    span = Span(min(rpm, orbit.rpm), max(rpm, orbit.rpm), width / SPEEDS)
    if orbit.root is None:
        leg = follow_resting(shooter, settings, orbit, span, up)
        points, end = leg.points, leg.end
    else:
        tangent = orbit.root.tangent
        ahead = tangent if (tangent[-1] > 0.0) == up else [-x for x in tangent]
        walked = follow(shooter, orbit.root, ahead, span)
        points, end = [from_root(system, root) for root in walked.points], walked.end
    same = [point for point in points if point.label == label]
    best = min(same, key=lambda point: abs(point.value - rpm))
    return best.value, end.replace("-", " ")
