"""camcli.explore: the motions over a range of speeds, on one page on which the machine moves."""

import json
from base64 import b64encode
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from importlib.resources import files
from itertools import product
from math import ceil, degrees, sqrt
from typing import Any, BinaryIO

import numpy as np

from camcli.analysis.cam_profile import profile
from camcli.analysis.contact_loss.detachment import detachment
from camcli.analysis.integrate import Cost, Start, with_turns
from camcli.analysis.labels import APERIODIC, CONTACT, UNDECIDED, Label, period_of
from camcli.analysis.orbits.same_orbit import distance_to
from camcli.analysis.simulate import STICKING, Simulation, simulate
from camcli.api.basins import basins
from camcli.api.command import Command, Drawing, Page, Part, Size
from camcli.api.lift_table import lost_between
from camcli.api.machine import (
    Machine,
    Varied,
    machine_of,
    refuse_an_oscillator,
    with_arguments,
    with_values,
)
from camcli.api.orbits import orbits
from camcli.api.result import Progress, Result, ticks
from camcli.api.sweep import sweep
from camcli.errors import Fault, SceneError, Status
from camcli.kernel.backend import for_work, stopwatch
from camcli.kernel.cam_table import TURN
from camcli.kernel.returns import CLOSE
from camcli.output.run_record import plain
from camcli.parallel import Work
from camcli.piece_faults import gather, gathering, piece
from camcli.plots import style
from camcli.plots.axes import axis_name
from camcli.plots.mechanism import Outline
from camcli.plots.sweep_map import cell_edges
from camcli.quantities import FOLLOWER, drawn
from camcli.scene import Axis, Scene
from camcli.scene.schema import RpmRange
from camcli.system import Follower, System, omega_of, turns_per_second, units_of
from camcli.words import plan
from camcli.words.events import event_words
from camcli.words.explore import BASIN_AXES, BASINS, MAP, NO_MOTION, basin_shares
from camcli.words.lift_table import smoothed_cam
from camcli.words.statuses import CAUSES, CURES

STEP = 0.4  # of the follower's fastest motion, rad, between rows: a cubic errs by STEP^4/384 of it
LAYER = 2000  # rows per turn at most for what damping ends at once: less than 1e-3 of the lift
FEWEST_ROWS = 48  # per turn
MOST_SPEEDS, MOST_ROWS = 1000, 250_000  # of a page of 8 MB; a row takes 17 bytes
LONGEST = 16  # turns of a motion that are shown
MOST_POINTS = 150_000  # of the diagram
SIDE = 16  # motions of a window of basins and of a map, along each side
MOST_TURNS, ROOM = 8, 350_000  # of each of them; rows of a whole page
PROFILE_ROWS = 720
DIRECTIONS = ("fixed", "up", "down")  # of sweeps
KINDS = ("impact", "chatter", "detachment")
# bytes of the page, for `page_bytes`
PER_MOTION, PER_ROW, PER_EVENT, PER_POINT = 250.0, 17.4, 12.0, 10.7
SOLVED = 0.25

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
    parts: Mapping[str, Result]  # see `parts_of`


def explore(
    scene: Scene | None = None,
    progress: Progress | None = None,
    *,
    work: Work | None = None,
    with_basins: bool = False,
    with_map: bool = False,
    source: str | None = None,
) -> Result:
    """A page for a browser: the machine in motion at every speed of ``scene.sweep.rpm``.

    The motions are those of a sweep from the scene's start, those that sweeps up and down find
    beside them, and the orbits solved over the same speeds, stable and not. Each is simulated from
    its state at the strobe phase, and the page shows these simulations.

    Parameters
    ----------
    scene : Scene, optional
        The machine, the speeds ``sweep.rpm``, and what the sections ``orbits``, ``basins`` and
        ``explore`` ask for; the default scene if left out.
    progress : callable, optional
        Called as ``progress(what, done, total)``.
    work : Work, optional
        How the speeds are computed. It never changes a result.
    with_basins : bool
        ``explore.basins``: also the basins at ``basins.rpm.start``, and the motions from a grid of
        starts.
    with_map : bool
        ``explore.map``: also the map over both numbers of ``sweep.vary``, or over the speeds and
        its only one, and the motions at a grid of its points. They are rpm or constants of the
        follower.
    source : str, optional
        ``explore.source``: options that name this scene on the command line, for the commands that
        the page shows.

    Returns
    -------
    Result
        No tables: ``save`` writes ``explore.html``, which needs no other file, where there is a
        motion to show. ``values`` holds the motions and their simulations.

    Raises
    ------
    SceneError
        If the start lies below the cam, a page cannot hold the motions of so many speeds, or
        there is no map that it can hold.
    """
    scene = with_arguments(scene, "explore", basins=with_basins, map=with_map, source=source)
    refuse_an_oscillator(scene, "explore")
    machine = machine_of(scene)
    scene = machine.scene
    section, span = scene.explore, scene.sweep.rpm
    asked = parts_of(scene)
    samples = _samples_of(machine)
    _refuse_too_many(span, samples)
    of_map = _samples_of_map(machine, asked["map"].scene.sweep.vary) if section.map else samples
    with stopwatch() as watch, gathering() as faults:
        runs = len(DIRECTIONS) * span.num + scene.orbits.starts
        for_work(runs * (scene.run.transient + scene.run.record))
        calls = {"sweep": partial(sweep, work=work), "basins": partial(basins, work=work)}
        parts: dict[str, Result] = {}
        for name, (command, own) in asked.items():
            part = piece(name, partial(calls.get(command, orbits), own, progress))
            if part is not None:
                parts[name] = part
                gather(replace(one, piece=f"{name}: {one.piece}") for one in part.faults)
        sweeps = [(way, parts[f"sweep {way}"]) for way in DIRECTIONS if f"sweep {way}" in parts]
        motions = _attractors(machine, sweeps, MOST_ROWS // (samples * span.num))
        motions += _solved(machine, parts["orbits"], motions) if "orbits" in parts else []
        if not motions and not faults:
            raise SceneError(_nothing_to_show(sweeps))
        left = ROOM - samples * sum(motion.turns for motion in motions)
        turns = left // (max(samples, of_map) * SIDE * SIDE * max(1, section.basins + section.map))
        turns = max(1, min(MOST_TURNS, turns))
        motions += _starts(machine, parts["basins"], turns) if "basins" in parts else []
        motions += _points(machine, parts["map"], turns) if "map" in parts else []
        tick = ticks(progress, "motions", len(motions))
        pairs: list[tuple[PageMotion, Simulation]] = []
        for motion in motions:
            name = f"the motion {motion.label} at {motion.rpm:.10g} rpm ({motion.origin})"
            simulation = piece(name, partial(_simulated, machine, motion, samples))
            pairs += [] if simulation is None else [(motion, simulation)]
            tick()
    motions, simulations = [motion for motion, _ in pairs], [simulation for _, simulation in pairs]
    explored = Explored(motions, simulations, parts)
    write_page = partial(_write_page, machine, explored)
    costs = [*(one.cost for one in simulations), *(part.cost for part in parts.values())]

    return Result(
        command="explore",
        scene=scene,
        system=machine.system,
        values=explored,
        tables={},
        summary={
            "speeds": span.num,
            "motions": len(motions),
            "bifurcations": len(parts["orbits"].values.bifurcations) if "orbits" in parts else 0,
        },
        pictures={},
        files={"explore.html": write_page} if motions else {},
        cost=sum(costs, Cost()),
        seconds=watch.seconds,
        notes=(
            *(f"{name}: {note}" for name, part in parts.items() for note in part.notes),
            *([] if motions else [NO_MOTION]),
        ),
        complete=all(part.complete for part in parts.values()) and bool(motions),
        faults=tuple(faults),
    )


def _simulated(machine: Machine, motion: PageMotion, samples: int) -> Simulation:
    """A motion of the page; samples: rows per turn, at least."""
    start = Start(motion.q, motion.v, motion.system.strobe)
    settings = replace(with_turns(machine.settings, 0, motion.turns + 1), start=start)
    rows = max(samples, _samples(motion.system.follower, motion.rpm))
    return simulate(motion.system, motion.rpm, settings, rows, follow=False)


def _write_page(machine: Machine, explored: Explored, file: BinaryIO) -> None:
    """Write explore.html."""
    source = machine.scene.explore.source
    data = {"source": source, **_machine_data(machine), **_motion_data(explored)}
    file.write(page(data).encode())


def parts_of(scene: Scene) -> dict[str, Part]:
    """The analyses that a page is made of: the command and the scene of each, by name."""
    whole = {"vary": (), "lyapunov": True, "sections": ("impacts", "strobe"), "tables": "csv"}
    whole |= {"zoom": (), "adaptive": False, "explain": False}  # the speeds of the page alone
    parts = {
        f"sweep {way}": Part("sweep", with_values(scene, "sweep", **whole, direction=way))
        for way in DIRECTIONS
    }
    parts["orbits"] = Part("orbits", _orbits_scene(scene))
    if scene.explore.basins:  # at one speed, with cells of one size
        speed = scene.basins.rpm.model_copy(update={"stop": scene.basins.rpm.start})
        parts["basins"] = Part("basins", with_values(scene, "basins", rpm=speed, refine=0))
    if scene.explore.map:
        parts["map"] = Part("sweep", with_values(scene, "sweep", vary=_axes_of_map(scene)))
    return parts


def page_bytes(machine: Machine, sampled: Mapping[str, Result]) -> float:
    """About how long the page of a scene will be, from sweeps of a few of its speeds.

    sampled: results by the names of `parts_of`. Orbits that no sweep finds are taken to add
    SOLVED of what the sweeps find.
    """
    scene = machine.scene
    sweeps = [(way, sampled[f"sweep {way}"]) for way in DIRECTIONS]
    span, samples = scene.sweep.rpm, _samples_of(machine)
    motions = _attractors(machine, sweeps, MOST_ROWS // (samples * span.num))
    share = span.num / len(sweeps[0][1].values[0].speeds)
    shown = sum(len(one.impacts[0]) + len(one.strobes[0]) for one in motions)
    points = min(shown, MOST_POINTS * len(motions) / share)
    turns = sum(one.turns for one in motions)
    per_turn = PER_ROW * samples + PER_EVENT * 3.0
    found = PER_MOTION * len(motions) + PER_POINT * points + per_turn * turns
    beside = cells = 0.0
    if scene.explore.basins:
        cells = 4.0 / 3.0 * scene.basins.cells[0] * scene.basins.cells[1]
        beside = MOST_TURNS * float(SIDE * SIDE)
    if scene.explore.map:
        periods = [period_of(speed.label) for speed in sampled["map"].values[0].speeds]
        each = sum(p if 0 < p <= MOST_TURNS else MOST_TURNS for p in periods) / len(periods)
        one, two = (min(SIDE, axis.num) for axis in _axes_of_map(scene))
        beside += each * one * two
    bare = len(page({"source": "", **_machine_data(machine)}))
    return bare + (1.0 + SOLVED) * share * found + per_turn * beside + cells


def _samples(f: Follower, rpm: float) -> int:
    """Rows per turn, so that a cubic from row to row is the motion itself.

    Where damping is more than critical a motion ends in two steps; the first is over at once, goes
    less than lift omega / rate, and is not followed more closely than LAYER rows show.
    """
    decay, square = f.damping / (2.0 * f.mass), f.stiffness / f.mass
    rows = TURN / omega_of(rpm) / STEP
    fast = decay + sqrt(decay * decay - square) if decay * decay > square else 0.0
    return max(FEWEST_ROWS, ceil(rows * sqrt(square)), min(LAYER, ceil(rows * fast)))


def _samples_of(machine: Machine) -> int:
    """Rows per turn at the slowest speed of the page."""
    span = machine.scene.sweep.rpm
    return _samples(machine.system.follower, min(span.start, span.stop))


def _samples_of_map(machine: Machine, axes: tuple[Axis, ...]) -> int:
    """Rows per turn of the motions of a map; raises SceneError where a page cannot hold them.

    They are most at a corner: the rates rise or fall with each constant, and with the speed.
    """
    machines = Varied(machine, axes)
    ends = [(axis.start, axis.stop) for axis in axes]
    samples, place = max(
        (_samples(system.follower, rpm), place)
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


def _refuse_too_many(span: RpmRange, samples: int) -> None:
    """Raise SceneError for more speeds than a page holds."""
    most = min(MOST_SPEEDS, MOST_ROWS // samples)
    if most == 0:
        found = f"found motions of {samples} rows a turn at {min(span.start, span.stop):.10g} rpm"
        expected = f"expected at most {MOST_ROWS} on a page"
        cure = "a follower so stiff moves too fast to be shown: raise the speeds"
        raise SceneError(Fault("", "sweep.rpm", found, expected, cure))
    if span.num > most:
        found, limit = f"found {span.num} speeds", f"expected at most {most} on a page"
        raise SceneError(Fault("", "sweep.rpm.num", found, limit, "give --points"))


def _nothing_to_show(sweeps: list[tuple[str, Result]]) -> Fault:
    """Why no speed has a motion, and what to do about it."""
    statuses = [Status(speed.status) for _, result in sweeps for speed in result.values[0].speeds]
    status = max(set(statuses), key=statuses.count)
    found = f"found no motion at any speed ({CAUSES[status]})"
    return Fault("", "sweep.rpm", found, "expected one at least", CURES[status])


def _axes_of_map(scene: Scene) -> tuple[Axis, ...]:
    """Both numbers of the map; raises SceneError where a page cannot show their machines."""
    span, axes = scene.sweep.rpm, scene.sweep.vary
    if len(axes) == 1:
        axes = (Axis(key="rpm", start=span.start, stop=span.stop, num=span.num), *axes)
    found = " and ".join(axis.key for axis in axes) or "none"
    if len(axes) != 2 or not all(a.path == "run.rpm" or "follower." in a.path for a in axes):
        cure = "give --vary follower.restitution=LO:HI, or another one"
        expected = "expected the speed or constants of the follower"
        raise SceneError(Fault("--with map", "sweep.vary", f"found {found}", expected, cure))
    return axes


def _orbits_scene(scene: Scene) -> Scene:
    """The scene of the page's orbits: followed over the speeds of its sweeps."""
    span, at = scene.sweep.rpm, scene.orbits.at
    low, high = sorted((span.start, span.stop))
    rpm = scene.orbits.rpm.model_copy(update={"start": low, "stop": high})
    at = at if at is not None and low <= at <= high else None
    return with_values(scene, "orbits", rpm=rpm, at=at, parameter="rpm", range=None, curve=None)


def _attractors(machine: Machine, sweeps: list[tuple[str, Result]], turns: int) -> list[PageMotion]:
    """The motions of several sweeps by speed, each of them once.

    sweeps: (direction, result) of each. turns: shown of a motion, at most.
    """
    found: dict[float, list[PageMotion]] = {}
    for direction, result in sweeps:
        for motion in _of_sweep(machine, result, direction, max(1, min(LONGEST, turns))):
            known = found.setdefault(motion.rpm, [])
            state = (float(motion.strobes[0][0]), float(motion.strobes[1][0]))
            if not any(other.is_near(motion.label, state) for other in known):
                known.append(motion)
    return [motion for rpm in sorted(found) for motion in found[rpm]]


def _of_sweep(machine: Machine, result: Result, direction: str, most: int) -> Iterator[PageMotion]:
    """The motions of a sweep, of every speed that has recorded turns.

    direction: of the sweep, for the page. most: turns that are shown of a motion without a period.
    """
    speeds = result.values[0].speeds
    points = MOST_POINTS // len(speeds)
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
        start_q, start_v = _start(machine, speed.rpm, q[-turns], v[-turns])
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


def _start(machine: Machine, rpm: float, q: float, v: float) -> tuple[float | None, float | None]:
    """A state at the strobe as a start; (None, None) where the follower rests on the cam."""
    stretch = machine.system.cam.stretches[machine.system.cam.strobe]
    c, c_dot = stretch.start_c, stretch.start_c1 * omega_of(rpm)
    if q <= c and abs(v - c_dot) <= 1e-12 * abs(c_dot):
        return None, None
    return float(max(q, c)), float(v)


def _solved(machine: Machine, result: Result, known: list[PageMotion]) -> list[PageMotion]:
    """The orbits of the branches that no sweep has found, one per step of the sweep and branch."""
    span, solved = machine.scene.sweep.rpm, result.values
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
            q, v = _start(machine, orbit.rpm, *state)
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


def _starts(machine: Machine, result: Result, turns: int) -> Iterator[PageMotion]:
    """Motions from a grid of starts in the window of the basins, by the attractor they reach."""
    section = machine.scene.basins
    cells = dict(result.tables["basins"])
    names = _labels_of_codes(result)
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


def _points(machine: Machine, result: Result, most: int) -> Iterator[PageMotion]:
    """Motions at a grid of points of the map, from where their records end."""
    found, axes = result.values[0], result.scene.sweep.vary
    setup = Varied(machine, axes)
    for row in _some(len(found.second)):
        line = found.lines[row]
        for column in _some(len(line)):
            speed, period = line[column], period_of(line[column].label)
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


def _machine_data(machine: Machine) -> dict[str, Any]:
    """The follower, and the cam as a body and as a function of the cam angle."""
    scene, system = machine.scene, machine.system
    base = getattr(scene.cam, "base_radius", None)
    body = Outline.of(system, base, scene.cam)
    x, y = body.body
    turn = profile(system, scene.run.rpm, PROFILE_ROWS, None)
    c, c1, c2 = (np.array(values) for values in (turn.c, turn.c1, turn.c2))
    return {
        "kind": scene.cam.kind,
        "follower": scene.follower.model_dump(),
        "units": {key: drawn(constant.unit) for key, constant in FOLLOWER.items()},
        "strobe_deg": scene.run.strobe_deg,
        "corners": {name: degrees(theta) for name, theta in turn.corners.items()},
        "speeds": [scene.sweep.rpm.start, scene.sweep.rpm.stop, scene.sweep.rpm.num],
        "outline": {
            "x": x[:-1:2], "y": y[:-1:2], "ratio": body.ratio,
            "rise": float(body.radius.min() - c.min() / body.ratio),
            "told": not body.guessed, "flat": body.flat,
        },
        "cam": {
            "theta_deg": np.degrees(turn.theta), "c": c, "c1": c1, "c2": c2,
        },
        "measured": _measured(machine),
    }  # fmt: skip


def _measured(machine: Machine) -> str:
    """What the error of a measured cam leaves open; empty of a law."""
    between = lost_between(machine.system)
    if between is None:
        return ""
    cam: Any = machine.scene.cam
    accuracy, units = cam.accuracy, units_of(machine.system)
    first = detachment(machine.system).first
    return smoothed_cam(accuracy, units, between, None if first is None else first.rpm)


def _labels_of_codes(landed: Result) -> dict[int, str]:
    """The labels of the attractors of basins at one speed, by their numbers in the tables."""
    (speed,) = landed.values[0].speeds
    pairs = zip(speed.branches, speed.attractors, strict=True)
    return {number: attractor.label for number, attractor in pairs}


def _labels_of_branches(solved: Result) -> set[str]:
    """The labels of all orbits in the table of branches."""
    found = solved.values
    points = (orbit for branch in found.branches for orbit in branch.points)
    return {orbit.label for orbit in (*found.orbits, *points)}


def _symbols(label: str) -> Sequence[float]:
    """Impacts in each turn, inf for a complete chatter; none of what has no period."""
    return label.symbols if isinstance(label, Label) else ()


def colour_name(label: str) -> str:
    """The colour of the motion with a label, as the page names it (COLOURS)."""
    if not isinstance(label, Label):
        return label if label in (CONTACT, APERIODIC) else UNDECIDED
    period = period_of(label)
    return f"period{period}" if period <= len(style.PERIODS) else "longer"


def _motion_data(found: Explored) -> dict[str, Any]:
    """The motions one after the other, each with its number of rows, events and points."""
    rows, events, motions = [], [], []
    for motion, simulation in zip(found.motions, found.simulations, strict=True):
        per_second = turns_per_second(motion.rpm)
        last = motion.turns * (1.0 + 1e-12)
        seconds, _, q, v, _, _, contact = map(np.array, zip(*simulation.trajectory, strict=True))
        t = seconds * per_second  # turns
        rest = (contact == STICKING)[t <= last]
        inner = np.zeros(len(rest), bool)
        inner[1:-1] = rest[:-2] & rest[1:-1] & rest[2:]  # there the follower is where the cam is
        kept = np.flatnonzero(~inner)
        rows.append([x[kept] for x in (t, q, v, rest)])
        happened = [row for row in simulation.events if row[0] * per_second <= last]
        events += [(row[0] * per_second, KINDS.index(row[3]), row[5]) for row in happened]
        motions.append(
            {
                "rpm": motion.rpm, "label": motion.label, "symbols": _symbols(motion.label),
                "colour": colour_name(motion.label), "origin": motion.origin,
                "q": motion.q, "v": motion.v, "turns": motion.turns, "loops": motion.loops,
                "period": period_of(motion.label), "stable": motion.stable,
                "exponent": motion.exponent, "place": motion.place, "sets": motion.sets,
                "rows": len(kept), "events": len(happened),
                "impacts": len(motion.impacts[0]), "strobes": len(motion.strobes[0]),
            }
        )  # fmt: skip
    t, q, v, rest = map(np.concatenate, zip(*rows, strict=True))
    at, kind, u = zip(*events, strict=True) if events else ((), (), ())
    theta, speed, positions, velocities = map(
        np.concatenate, zip(*((*m.impacts, *m.strobes) for m in found.motions), strict=True)
    )
    return {
        "motions": motions,
        "rows": {"t": t, "q": q, "v": v, "rest": rest},
        "events": {"t": np.array(at), "kind": np.array(kind, np.uint8), "u": np.array(u)},
        "points": {
            "theta_deg": theta, "u": speed, "q": positions, "v": velocities,
        },
        "branches": _branches(found.parts["orbits"]) if "orbits" in found.parts else [],
        "bifurcations": _bifurcations(found.parts["orbits"]) if "orbits" in found.parts else [],
        "planes": [data(found.parts[name]) for name, data in PLANES.items() if name in found.parts],
    }  # fmt: skip


def _branches(solved: Result) -> list[dict[str, Any]]:
    """The branches as columns; one of impact `k` in `theta_deg[k]` and `u[k]`, NaN without it."""
    table = dict(solved.tables["branch"])
    colours = {label: colour_name(label) for label in _labels_of_branches(solved)}
    columns = {
        name: [table[column] for column in table if column.startswith(prefix)]
        for name, prefix in (("theta_deg", "theta_deg_"), ("u", "u_minus_m_per_s_"))
    }
    for theta, u in zip(columns["theta_deg"], columns["u"], strict=True):
        theta[np.isnan(u)] = np.nan  # of a departure, not of an impact
    found = []
    for number in np.unique(table["branch"]).tolist():
        own = table["branch"] == number
        found.append(
            {
                "rpm": table["rpm"][own].tolist(), "stable": table["stable"][own],
                "label": table["label"][own].tolist(),
                "colour": colours[str(table["label"][own][0])],
                "q": [table["q_m"][own]], "v": [table["v_m_per_s"][own]],
                **{name: [column[own] for column in own_] for name, own_ in columns.items()},
            }
        )  # fmt: skip
    return found


def _bifurcations(solved: Result) -> list[dict[str, Any]]:
    """The events of the branches, one that several share once."""
    found: dict[tuple, dict[str, Any]] = {}
    for b in solved.values.bifurcations:
        q, w = b.orbit.states[0]
        key = (b.kind, b.label, f"{b.value:.10g}")
        found.setdefault(key, {
            "kind": b.kind, "label": b.label, "rpm": b.value, "rpm_error": b.error,
            "corner": b.corner, "classification": b.classification, "words": event_words(b),
            "theta_deg": [degrees(theta) for theta in b.orbit.theta[: len(b.orbit.rates)]],
            "u": [u * omega_of(b.value) for u in b.orbit.rates],
            "q": [q], "v": [w * omega_of(b.value)],
        })  # fmt: skip
    return sorted(found.values(), key=lambda event: event["rpm"])


def _basins_data(landed: Result) -> dict[str, Any]:
    """The window with the attractor of every cell."""
    section, attractors = landed.scene.basins, landed.tables["attractors"]
    columns = (attractors[name].tolist() for name in ("attractor", "label", "fraction"))
    named, labels = list(zip(*columns, strict=True)), _labels_of_codes(landed)
    place = {number: k for k, (number, _, _) in enumerate(named)}  # 255: below the cam
    codes = [place.get(n, 255) for n in landed.tables["basins"]["attractor"].tolist()]
    shares = [(label, share) for n, label, share in named if n > 0]
    return {
        "of": "start", "name": BASINS, "cells": section.cells,
        "x": section.q, "y": section.v,
        "names": BASIN_AXES,
        "labels": [label for _, label, _ in named],
        "colours": [colour_name(labels.get(number, UNDECIDED)) for number, _, _ in named],
        "codes": np.array(codes, np.uint8),
        "words": basin_shares(section.rpm.start, shares),
    }  # fmt: skip


def _kind_of(label: str) -> tuple[int, str, str]:
    """What a map shows of a motion: its period, that in words, and the colour."""
    name = f"period {period_of(label)}" if isinstance(label, Label) else label
    return period_of(label), name, colour_name(label)


def _map_data(result: Result) -> dict[str, Any]:
    """The kind of motion at every point, its period and no more."""
    found = result.values[0]
    kinds = [[_kind_of(speed.label) for speed in line] for line in found.lines]
    every = sorted({kind for line in kinds for kind in line})
    codes = np.array([[every.index(kind) for kind in line] for line in kinds])
    x, y = found.first, found.second
    return {
        "of": "map", "name": MAP, "cells": [len(x), len(y)],
        "x": cell_edges(x), "y": cell_edges(y), "names": [axis_name(key) for key in found.keys],
        "labels": [name for _, name, _ in every],
        "colours": [colour for _, _, colour in every],
        "codes": codes[np.argsort(y)][:, np.argsort(x)].astype(np.uint8).ravel(),
        "words": "",
    }  # fmt: skip


PLANES = {"basins": _basins_data, "map": _map_data}

# --- one page with the data in it, which needs no other file

COLOURS = {
    "flight": style.FLIGHT, "sticking": style.STICKING, "impact": style.IMPACT,
    "chatter": style.CHATTER, "detachment": style.DETACHMENT, "trouble": style.TROUBLE,
    "cam": style.CAM, "body": style.CAM_BODY, "guide": style.GUIDE, "force": style.FORCES[2],
    **{f"period{k}": colour for k, colour in enumerate(style.PERIODS, 1)},
    "longer": style.LONGER, "aperiodic": style.APERIODIC,
}  # fmt: skip

# in this order: a file may use at once what those before it hold, and later what any file holds
SCRIPTS = ("motion", "words", "axes", "machine", "plots", "diagram", "planes", "page")


def page(data: Mapping[str, Any]) -> str:
    """The page that shows the data: plain values, and NumPy arrays of numbers or flags.

    The folder `explore_page` of `camcli.output` holds the page without the data: `page.html`, its
    style and its scripts, which become one text here.
    """
    folder = files("camcli.output") / "explore_page"

    def read(name: str) -> str:
        return (folder / name).read_text(encoding="utf-8")

    colours = " ".join(f"--{name}: {colour};" for name, colour in COLOURS.items())
    text = json.dumps(plain(data), separators=(",", ":"), allow_nan=False, default=_packed)
    filled = {
        "/*STYLE*/": read("style.css").strip().replace("/*COLOURS*/", colours),
        "/*SCRIPT*/": "\n".join(read(f"{name}.js") for name in SCRIPTS).strip(),
        "/*DATA*/": text.replace("<", "\\u003c"),  # last: it may hold any words
    }
    whole = read("page.html")
    for mark, part in filled.items():
        whole = whole.replace(mark, part)
    return whole


def _packed(array: np.ndarray) -> dict[str, str]:
    """An array as base64 of float32 or uint8."""
    kind = "f4" if array.dtype.kind == "f" else "u1"
    return {kind: b64encode(array.astype(f"<{kind}").tobytes()).decode()}


# --- the command


SHOWN_MOTIONS = 256  # of a window of starts, or of a map
LEAST_ROWS = 48  # of a turn


def _size(scene: Scene) -> Size:
    """Three sweeps whose records are all in memory, the motions of the page, and what is beside."""
    run, n = scene.run, scene.sweep.rpm.num
    turns, count, cells, points = run.transient + run.record, 3 * n, 0, 0
    shown, memory = 2.0 * n, 3.0 * n * (64.0 * run.record + 1e3)
    all_turns = float(count * turns)
    if scene.explore.basins:
        cells = scene.basins.cells[0] * scene.basins.cells[1]
        count, shown, memory = count + cells, shown + 8.0 * SHOWN_MOTIONS, memory + 70.0 * cells
    if scene.explore.map:
        axes = scene.sweep.vary
        points = axes[0].num * (axes[1].num if len(axes) == 2 else n) if axes else 0
        count, shown, memory = count + points, shown + 8.0 * SHOWN_MOTIONS, memory + 1e3 * points
        all_turns += points * turns
    rows = LEAST_ROWS * shown  # each takes 280 bytes until the page is written, 17 in it
    what = plan.parts_of_a_page(n, cells, points)
    return Size(
        what=what,
        pieces=n,
        orbits=count,
        turns=all_turns,
        rows=n,
        memory=memory + 280.0 * rows,
        tables=90e3 + 17.0 * rows,
        kept=0.0,
    )


COMMAND = Command(
    run=explore,
    files=("explore.html",),
    size=_size,
    drawing=lambda scene: Drawing(0.0, 60e6, 0.0),
    check=partial(refuse_an_oscillator, command="explore"),
    not_foreseen=plan.explore,
    page=Page(parts=parts_of, size=page_bytes),
)
