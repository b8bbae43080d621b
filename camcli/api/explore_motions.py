"""Which motions a page of `cam explore` shows, and how closely each of them is followed."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from math import ceil, sqrt

import numpy as np

from camcli.analysis.labels import UNDECIDED, Label, period_of
from camcli.analysis.orbits.same_orbit import distance_to
from camcli.analysis.simulate import Simulation
from camcli.api.machine import (
    Machine,
    Varied,
)
from camcli.api.result import Result
from camcli.errors import Fault, SceneError
from camcli.kernel.cam_table import TURN
from camcli.kernel.returns import CLOSE
from camcli.scene import Axis, Scene
from camcli.scene.schema import RpmRange
from camcli.system import Follower, System, omega_of

STEP = 0.4  # of the follower's fastest motion, rad, between rows: a cubic errs by STEP^4/384 of it
LAYER = 2000  # rows per turn at most for what damping ends at once: less than 1e-3 of the lift
FEWEST_ROWS = 48  # per turn
MOST_SPEEDS, MOST_ROWS = 1000, 250_000  # of a page of 8 MB; a row takes 17 bytes
MOST_TURNS_SHOWN = 16  # turns of a motion that are shown
MOST_POINTS = 150_000  # of the diagram
SIDE = 16  # motions of a window of basins and of a map, along each side
MOST_TURNS, ROOM = 8, 350_000  # of each of them; rows of a whole page

Columns = tuple[np.ndarray, np.ndarray]
NONE: Columns = (np.empty(0), np.empty(0))


@dataclass(frozen=True)
class PageMotion:
    """One motion of the page, as `cam simulate` computes it from this start.

    origin: `fixed`, `up` or `down` for a sweep, `solved` for an orbit, `start` for a start of the
    basins, `map` for a point of the map; q (m) and v (m/s): at the strobe, None where the follower
    rests on the cam; turns: how many are shown; loops: the last one ends where the first begins;
    place: in the window of basins (q, v) or in the map (both values); system: the machine.

    impacts: (theta_deg, u_minus_m_per_s) and strobes: (q_m, v_m_per_s), points of the diagram.
    """

    rpm: float
    label: str
    origin: str
    q: float | None
    v: float | None
    turns: int
    loops: bool
    stable: bool | None
    exponent: float | None
    system: System
    impacts: Columns = NONE
    strobes: Columns = NONE
    place: tuple[float, float] | None = None
    sets: Mapping[str, float] = field(default_factory=dict)  # of a map: what --set would change

    def is_near(self, label: str, state: tuple[float, float]) -> bool:
        """Whether a motion of the same speed with this label and state at the strobe is this one.

        Motions without a period are told apart by their labels alone.
        """
        if label != self.label or not period_of(label):
            return label == self.label
        return distance_to(state, list(zip(*self.strobes, strict=True))) <= CLOSE


@dataclass(frozen=True)
class Explored:
    """What the page shows: motions with their simulations, and the results they come from."""

    motions: list[PageMotion]
    simulations: list[Simulation]
    parts: Mapping[str, Result]  # see `camcli.api.explore.parts_of`


def symbols_of(label: str) -> Sequence[float]:
    """Impacts in each turn, inf for a complete chatter; none of what has no period."""
    return label.symbols if isinstance(label, Label) else ()


def rows_per_turn(f: Follower, rpm: float) -> int:
    """Rows per turn, so that a cubic from row to row is the motion itself.

    Where damping is more than critical a motion ends in two steps; the first is over at once, goes
    less than lift omega / rate, and is not followed more closely than LAYER rows show.
    """
    decay = f.damping / (2.0 * f.mass)
    square = f.stiffness / f.mass
    rows = TURN / omega_of(rpm) / STEP
    fast = decay + sqrt(decay * decay - square) if decay * decay > square else 0.0
    return max(FEWEST_ROWS, ceil(rows * sqrt(square)), min(LAYER, ceil(rows * fast)))


def rows_of_the_page(machine: Machine) -> int:
    """Rows per turn at the slowest speed of the page."""
    span = machine.scene.sweep.rpm
    return rows_per_turn(machine.system.follower, min(span.start, span.stop))


def rows_of_a_map(machine: Machine, axes: tuple[Axis, ...]) -> int:
    """Rows per turn of the motions of a map; raises SceneError where a page cannot hold them.

    They are most at a corner: the rates rise or fall with each constant, and with the speed.
    """
    machines = Varied(machine, axes)
    ends = [(axis.start, axis.stop) for axis in axes]
    samples, place = max(
        (rows_per_turn(system.follower, rpm), place)
        for place in product(*ends)
        for system, rpm, _ in [machines(*place)]
    )
    motions = min(SIDE, axes[0].num) * min(SIDE, axes[1].num)
    if samples * motions > ROOM:
        at = " and ".join(f"{axis.key} = {x:.10g}" for axis, x in zip(axes, place, strict=True))
        found = f"found motions of {samples} rows a turn, at {at}"
        expected = f"expected at most {ROOM // motions} on a page"
        cure = "a follower so stiff moves too fast to be shown: narrow the range, or leave map out"
        raise SceneError(Fault("--with map", "sweep.vary", found, expected, cure))
    return samples


def refuse_too_many(span: RpmRange, samples: int) -> None:
    """Raise SceneError for more speeds than a page holds."""
    most = min(MOST_SPEEDS, MOST_ROWS // samples)
    if most == 0:
        found = f"found motions of {samples} rows a turn at {min(span.start, span.stop):.10g} rpm"
        expected = f"expected at most {MOST_ROWS} on a page"
        cure = "a follower so stiff moves too fast to be shown: raise the speeds"
        raise SceneError(Fault("", "sweep.rpm", found, expected, cure))
    if span.num > most:
        found = f"found {span.num} speeds"
        limit = f"expected at most {most} on a page"
        raise SceneError(Fault("", "sweep.rpm.num", found, limit, "give --points"))


def axes_of_map(scene: Scene) -> tuple[Axis, ...]:
    """Both numbers of the map; raises SceneError where a page cannot show their machines."""
    span = scene.sweep.rpm
    axes = scene.sweep.vary
    if len(axes) == 1:
        axes = (Axis(key="rpm", start=span.start, stop=span.stop, num=span.num), *axes)
    found = " and ".join(axis.key for axis in axes) or "none"
    if len(axes) != 2 or not all(a.path == "run.rpm" or "follower." in a.path for a in axes):
        cure = "give --vary follower.restitution=LO:HI, or another one"
        expected = "expected the speed or constants of the follower"
        raise SceneError(Fault("--with map", "sweep.vary", f"found {found}", expected, cure))
    return axes


def attractors(machine: Machine, sweeps: list[tuple[str, Result]], turns: int) -> list[PageMotion]:
    """The motions of several sweeps by speed, each of them once.

    sweeps: (direction, result) of each. turns: shown of a motion, at most.
    """
    found: dict[float, list[PageMotion]] = {}
    for direction, result in sweeps:
        for motion in of_sweep(machine, result, direction, max(1, min(MOST_TURNS_SHOWN, turns))):
            known = found.setdefault(motion.rpm, [])
            state = (float(motion.strobes[0][0]), float(motion.strobes[1][0]))
            if not any(other.is_near(motion.label, state) for other in known):
                known.append(motion)
    return [motion for rpm in sorted(found) for motion in found[rpm]]


def of_sweep(
    machine: Machine,
    result: Result,
    direction: str,
    most: int,
    most_points: int = MOST_POINTS,
) -> Iterator[PageMotion]:
    """The motions of a sweep, of every speed that has recorded turns.

    direction: of the sweep, for the page. most: turns that are shown of a motion without a period.
    most_points: of all speeds in the diagram.
    """
    speeds = result.values[0].speeds
    points = most_points // len(speeds)
    for speed in speeds:
        turn, theta, _, u = speed.impacts
        _, q, v, *_ = speed.strobe
        recorded = len(q)
        label = speed.label
        if not recorded:
            continue
        period = period_of(label)
        turns = min(recorded, period if 0 < period <= most else most)
        kept = turn >= recorded - (period or recorded)
        start_q, start_v = start_of(machine, speed.rpm, q[-turns], v[-turns])
        yield PageMotion(
            rpm=speed.rpm,
            label=label,
            origin=direction,
            q=start_q,
            v=start_v,
            turns=turns,
            loops=turns == period,
            stable=True if period else None,
            exponent=speed.exponent,
            system=machine.system,
            impacts=(theta[kept][-points:], u[kept][-points:]),
            strobes=(q[-(period or points) :], v[-(period or points) :]),
        )


def start_of(machine: Machine, rpm: float, q: float, v: float) -> tuple[float | None, float | None]:
    """A state at the strobe as a start; (None, None) where the follower rests on the cam."""
    stretch = machine.system.cam.stretches[machine.system.cam.strobe]
    c = stretch.start_c
    c_dot = stretch.start_c1 * omega_of(rpm)
    if q <= c and abs(v - c_dot) <= 1e-12 * abs(c_dot):
        return None, None
    return float(max(q, c)), float(v)


def solved_motions(machine: Machine, result: Result, known: list[PageMotion]) -> list[PageMotion]:
    """The orbits of the branches that no sweep has found, one per step of the sweep and branch."""
    span = machine.scene.sweep.rpm
    solved = result.values
    step = abs(span.stop - span.start) / max(1, span.num - 1)
    speeds = np.array([motion.rpm for motion in known])
    found: list[PageMotion] = []
    lines = [branch.points for branch in solved.branches]
    if solved.question.span is None:
        lines = [(orbit,) for orbit in solved.orbits]
    for points in lines:
        last = None
        for orbit in points:
            if (
                last is not None
                and last.stable == orbit.stable
                and abs(orbit.rpm - last.rpm) < step
            ):
                continue
            q, w = orbit.states[0]
            state = q, w * omega_of(orbit.rpm)
            near = np.flatnonzero(np.abs(speeds - orbit.rpm) <= 0.5 * step * (1.0 + 1e-9))
            if orbit.stable and any(known[n].is_near(orbit.label, state) for n in near):
                continue
            last = orbit
            q, v = start_of(machine, orbit.rpm, *state)
            turns = period_of(orbit.label)
            strobes = np.array(state[:1]), np.array(state[1:])
            found.append(
                PageMotion(
                    rpm=orbit.rpm,
                    label=orbit.label,
                    origin="solved",
                    q=q,
                    v=v,
                    turns=turns,
                    loops=True,
                    stable=orbit.stable,
                    exponent=None,
                    system=machine.system,
                    impacts=NONE,
                    strobes=strobes,
                )
            )
    return found


def _some(count: int) -> list[int]:
    """At most SIDE of so many in a row, spread evenly, away from the ends."""
    most = min(SIDE, count)
    return [(2 * k + 1) * count // (2 * most) for k in range(most)]


def motions_from_starts(machine: Machine, result: Result, turns: int) -> Iterator[PageMotion]:
    """Motions from a grid of starts in the window of the basins, by the attractor they reach."""
    section = machine.scene.basins
    cells = dict(result.tables["basins"])
    names = labels_of_codes(result)
    wide, high = section.cells
    codes = cells["attractor"].tolist()
    for k in (row * wide + column for row in _some(high) for column in _some(wide)):
        if codes[k] == -1:
            continue  # below the cam
        start = float(cells["q_m"][k]), float(cells["v_m_per_s"][k])
        q, v = start
        yield PageMotion(
            rpm=section.rpm.start,
            label=names.get(codes[k], UNDECIDED),
            origin="start",
            q=q,
            v=v,
            turns=turns,
            loops=False,
            stable=None,
            exponent=None,
            system=machine.system,
            place=start,
        )


def motions_of_a_map(machine: Machine, result: Result, most: int) -> Iterator[PageMotion]:
    """Motions at a grid of points of the map, from where their records end."""
    found = result.values[0]
    axes = result.scene.sweep.vary
    setup = Varied(machine, axes)
    for row in _some(len(found.second)):
        line = found.lines[row]
        for column in _some(len(line)):
            speed = line[column]
            period = period_of(line[column].label)
            if speed.end is None:
                continue
            place = speed.value, found.second[row]
            system, rpm, _ = setup(*place)
            turns = period if 0 < period <= most else most
            constants = zip(axes, place, strict=True)
            yield PageMotion(
                rpm=rpm,
                label=speed.label,
                origin="map",
                q=speed.end.q,
                v=speed.end.v,
                turns=turns,
                loops=turns == period,
                stable=True if period else None,
                exponent=speed.exponent,
                system=system,
                place=place,
                sets={axis.key: x for axis, x in constants if axis.path != "run.rpm"},
            )


def labels_of_codes(landed: Result) -> dict[int, str]:
    """The labels of the attractors of basins at one speed, by their numbers in the tables."""
    (speed,) = landed.values[0].speeds
    pairs = zip(speed.branches, speed.attractors, strict=True)
    return {number: attractor.label for number, attractor in pairs}
