"""A branch of periodic orbits with everything that happens on it, ready to be written."""

from __future__ import annotations

from dataclasses import dataclass

from camcli.analysis.border_collision import Side
from camcli.analysis.integrate import Settings
from camcli.analysis.orbits.branch_segment import Leg
from camcli.analysis.orbits.collide import CornerImpact, collide
from camcli.analysis.orbits.crossing import Crossing
from camcli.analysis.orbits.locate import GRAZING, PERIOD_DOUBLING, Found
from camcli.analysis.orbits.orbit import PeriodicOrbit, from_root
from camcli.analysis.orbits.shooter import Shooter
from camcli.analysis.orbits.sticking_orbits import Change, RestingLeg
from camcli.cams.regions import corner_list
from camcli.kernel.cam_table import TURN

DEG = 57.29577951308232
SAME_CORNER = 1e-6  # rad


@dataclass(frozen=True)
class Bifurcation:
    """One event on a branch.

    value: of the parameter, +- error; corner: name or empty; left, right: one-sided traces and
    determinants at a corner impact; classification: the border collision's kind; words: sentences;
    orbit: at the event; agrees: prediction and simulation; continues: number of the branch that
    leaves here, 0 for none.
    """

    branch: int
    kind: str
    value: float
    error: float
    status: str
    orbit: PeriodicOrbit
    corner: str = ""
    left: Side | None = None
    right: Side | None = None
    classification: str = ""
    inequalities: tuple = ()
    words: tuple[str, ...] = ()
    agrees: bool | None = None
    continues: int = 0
    impact: int = -1  # of the root: the one at the corner, 0-based
    side: int = 0  # +1: the corner ends the region of that impact, -1: it begins it
    phase: float | None = None  # where grazing happens, rad in the turn

    @property
    def label(self) -> str:
        """Label of the orbit at the event."""
        return self.orbit.label


@dataclass(frozen=True)
class Branch:
    """Orbits in order along the branch; ends: what ends it at the first and at the last point."""

    number: int
    origin: str
    points: tuple[PeriodicOrbit, ...]
    ends: tuple[str, str]

    @property
    def labels(self) -> list[str]:
        """The labels on the way, in order, without repetition."""
        return list(dict.fromkeys(orbit.label for orbit in self.points))


class Writer:
    """Turns legs into branches and bifurcations; keeps the numbers."""

    def __init__(self, shooter: Shooter, settings: Settings):
        self.shooter, self.settings = shooter, settings
        self.system = shooter.system
        self.branches: list[Branch] = []
        self.bifurcations: list[Bifurcation] = []
        self.shoots: list[tuple[int, Found | Crossing]] = []  # (index of bifurcation, its event)
        self._collisions: dict[tuple, CornerImpact] = {}

    def bouncing(self, legs: list[Leg], origin: str) -> None:
        """A branch from one leg, or from two that begin at the same root."""
        number = len(self.branches) + 1
        roots = legs[-1].points if len(legs) == 1 else legs[0].points[:0:-1] + legs[1].points
        points = tuple(from_root(self.system, root) for root in roots)
        ends = (origin, legs[0].end) if len(legs) == 1 else (legs[0].end, legs[1].end)
        self.branches.append(Branch(number, origin, points, ends))
        for leg in legs:
            for found, crossing in leg.events:
                self._event(number, found, crossing)
                if found.kind == PERIOD_DOUBLING:
                    self.shoots.append((len(self.bifurcations) - 1, found))
                elif crossing is not None and crossing is leg.turned:
                    self.shoots.append((len(self.bifurcations) - 1, crossing))

    def _event(self, number: int, found: Found, crossing: Crossing | None) -> None:
        orbit = from_root(self.system, found.root)
        common = (number, found.kind, found.root.value, found.error, found.status, orbit)
        if crossing is None:
            grazes = found.kind == GRAZING
            words = (_graze_words(found, self.shooter.rate),) if grazes else ()
            phase = found.phase if grazes else None
            self.bifurcations.append(Bifurcation(*common, words=words, phase=phase))
            return
        impact = self._collision(crossing)
        agree = [side.agrees for side in (impact.below, impact.above)]
        words = (
            *impact.collision.words,
            f"Just below it {impact.below.words}.",
            f"Just above it {impact.above.words}.",
        )
        self.bifurcations.append(
            Bifurcation(
                *common, corner=crossing.corner, left=impact.left, right=impact.right,
                classification=impact.collision.kind,
                inequalities=impact.collision.inequalities, words=words,
                agrees=None if None in agree else all(agree), impact=found.impact, side=found.side,
            )
        )  # fmt: skip

    def _collision(self, crossing: Crossing) -> CornerImpact:
        """The study of a corner impact, made once for both branches that end in it."""
        key = (crossing.corner, crossing.left.count, f"{crossing.left.value:.11g}")
        if key not in self._collisions:
            self._collisions[key] = collide(self.shooter, crossing, self.settings)
        return self._collisions[key]

    def resting(self, down: RestingLeg, up: RestingLeg, origin: str) -> None:
        """A branch of orbits that rest on the cam."""
        number = len(self.branches) + 1
        points = (*down.points[:0:-1], *up.points)
        self.branches.append(Branch(number, origin, points, (down.end, up.end)))
        for change in (*down.changes, *up.changes):
            after = "nothing that could be solved" if change.beyond is None else change.beyond.label
            self.bifurcations.append(
                Bifurcation(
                    number, change.kind, change.value, change.error, "ok", change.orbit,
                    corner=self._corner_of(change), words=(f"beyond it a run settles on {after}.",),
                )
            )  # fmt: skip

    def _corner_of(self, change: Change) -> str:
        """The corner at which the follower leaves the cam on one side of the change only."""
        here = change.orbit.theta
        there = () if change.beyond is None else change.beyond.theta
        moved = [x for x in here if not any(abs(x - y) < SAME_CORNER for y in there)]
        moved += [y for y in there if not any(abs(x - y) < SAME_CORNER for x in here)]
        for corner in corner_list(self.system.cam):
            if any(abs(theta - corner.theta) < SAME_CORNER for theta in moved or here):
                return corner.name
        return ""


def _graze_words(found: Found, slow: float) -> str:
    place = f"{(found.phase % TURN) * DEG:.8g} deg"
    u = found.root.rates
    smallest = min(range(len(u)), key=lambda k: abs(u[k]))
    if abs(u[smallest]) < slow:
        return f"the impact at {found.root.theta[smallest] * DEG:.8g} deg fades to zero velocity."
    return f"beyond it the flight after impact {found.impact + 1} meets the cam at {place}."
