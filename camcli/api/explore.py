"""camcli.explore: the motions over a range of speeds, on one page on which the machine moves."""

from collections.abc import Mapping
from dataclasses import asdict, replace
from functools import partial
from typing import BinaryIO

from camcli.analysis.integrate import Cost, Start, with_turns
from camcli.analysis.labels import period_of
from camcli.analysis.simulate import Simulation, simulate
from camcli.api.basins import basins
from camcli.api.command import Command, Drawing, Page, Part, Size
from camcli.api.explore_motions import (
    MOST_POINTS,
    MOST_ROWS,
    MOST_TURNS,
    ROOM,
    SIDE,
    Explored,
    PageMotion,
    attractors,
    axes_of_map,
    motions_from_starts,
    motions_of_a_map,
    refuse_too_many,
    rows_of_a_map,
    rows_of_the_page,
    rows_per_turn,
    solved_motions,
)
from camcli.api.explore_page import machine_data, motion_data, page
from camcli.api.explore_stops import motions_of_stops, stops_of
from camcli.api.machine import (
    Machine,
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
from camcli.parallel import Work
from camcli.piece_faults import PieceFault, gather, gathering, piece
from camcli.scene import Scene
from camcli.words import plan
from camcli.words.explore import NO_MOTION
from camcli.words.statuses import CAUSES, CURES

DIRECTIONS = ("fixed", "up", "down")  # of sweeps
# bytes of the page, for `page_bytes`
PER_MOTION, PER_ROW, PER_EVENT, PER_POINT = 250.0, 17.4, 12.0, 10.7
SOLVED = 0.25


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

    Examples
    --------
    >>> import camcli
    >>> speeds = {"sweep.rpm.start": 690, "sweep.rpm.stop": 700, "sweep.rpm.num": 2}
    >>> result = camcli.explore(camcli.load_scene(None, speeds))
    >>> sorted(result.files)
    ['explore.html']
    >>> {690.0, 700.0} <= {motion.rpm for motion in result.values.motions}
    True
    """
    scene = with_arguments(scene, "explore", basins=with_basins, map=with_map, source=source)
    refuse_an_oscillator(scene, "explore")
    machine = machine_of(scene)
    with stopwatch() as watch, gathering() as faults:
        explored = _explored(machine, progress, work, faults)

    return _result(machine, explored, watch.seconds, faults)


def _explored(
    machine: Machine, progress: Progress | None, work: Work | None, faults: list[PieceFault]
) -> Explored:
    """The motions of the page, each simulated; faults: those gathered so far."""
    scene = machine.scene
    section = scene.explore
    span = scene.sweep.rpm
    asked = parts_of(scene)
    rows = rows_of_the_page(machine)
    refuse_too_many(span, rows)
    most_rows = rows
    if section.map:
        most_rows = max(rows, rows_of_a_map(machine, asked["map"].scene.sweep.vary))
    runs = len(DIRECTIONS) * span.num + scene.orbits.starts
    for_work(runs * (scene.run.transient + scene.run.record))
    parts = _computed(asked, progress, work)
    sweeps = [(way, parts[f"sweep {way}"]) for way in DIRECTIONS if f"sweep {way}" in parts]
    motions = attractors(machine, sweeps, MOST_ROWS // (rows * span.num))
    if "orbits" in parts:
        motions += solved_motions(machine, parts["orbits"], motions)
    if not motions and not faults:
        raise SceneError(_nothing_to_show(sweeps))
    left = ROOM - rows * sum(motion.turns for motion in motions)
    turns = left // (most_rows * SIDE * SIDE * max(1, section.basins + section.map))
    turns = max(1, min(MOST_TURNS, turns))
    if "basins" in parts:
        motions += motions_from_starts(machine, parts["basins"], turns)
    if "map" in parts:
        motions += motions_of_a_map(machine, parts["map"], turns)
    motions += piece("the stops", partial(motions_of_stops, machine)) or []
    tick = ticks(progress, "motions", len(motions))
    pairs: list[tuple[PageMotion, Simulation]] = []
    for motion in motions:
        name = f"the motion {motion.label} at {motion.rpm:.10g} rpm ({motion.origin})"
        simulation = piece(name, partial(_simulated, machine, motion, rows))
        if simulation is not None and simulation.trajectory:  # else it stopped before its first row
            pairs.append((motion, simulation))
        tick()
    return Explored([motion for motion, _ in pairs], [found for _, found in pairs], parts)


def _computed(
    asked: Mapping[str, Part], progress: Progress | None, work: Work | None
) -> dict[str, Result]:
    """The analyses that the page is made of, without those that a fault has cost."""
    calls = {"sweep": partial(sweep, work=work), "basins": partial(basins, work=work)}
    parts: dict[str, Result] = {}
    for name, (command, scene) in asked.items():
        part = piece(name, partial(calls.get(command, orbits), scene, progress))
        if part is not None:
            parts[name] = part
            gather(replace(one, piece=f"{name}: {one.piece}") for one in part.faults)
    return parts


def _result(
    machine: Machine, explored: Explored, seconds: float, faults: list[PieceFault]
) -> Result:
    """The result that `explore` returns."""
    motions = explored.motions
    parts = explored.parts
    costs = [*(one.cost for one in explored.simulations), *(part.cost for part in parts.values())]
    found = len(parts["orbits"].values.bifurcations) if "orbits" in parts else 0
    return Result(
        command="explore",
        scene=machine.scene,
        system=machine.system,
        values=explored,
        tables={},
        summary={
            "speeds": machine.scene.sweep.rpm.num,
            "motions": len(motions),
            "bifurcations": found,
        },
        pictures={},
        files={"explore.html": partial(_write_page, machine, explored)} if motions else {},
        cost=sum(costs, Cost()),
        seconds=seconds,
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
    rows = max(samples, rows_per_turn(motion.system.follower, motion.rpm))
    return simulate(motion.system, motion.rpm, settings, rows, follow=False)


def _write_page(machine: Machine, explored: Explored, file: BinaryIO) -> None:
    """Write explore.html."""
    source = machine.scene.explore.source
    stops = [asdict(stop) for stop in stops_of(machine, explored)]
    data = {"source": source, **machine_data(machine), **motion_data(explored), "stops": stops}
    file.write(page(data).encode())


def parts_of(scene: Scene) -> dict[str, Part]:
    """The analyses that a page is made of: the command and the scene of each, by name."""
    plain = {"zoom": (), "adaptive": False, "explain": False}  # the values of the page alone
    whole = {"vary": (), "lyapunov": True, "sections": ("impacts", "strobe"), "tables": "csv"}
    whole |= {**plain, "branches": None}
    whole |= {"curves": None, "prove": False}  # they belong over a map
    parts = {
        f"sweep {way}": Part("sweep", with_values(scene, "sweep", **whole, direction=way))
        for way in DIRECTIONS
    }
    parts["orbits"] = Part("orbits", _orbits_scene(scene))
    if scene.explore.basins:  # at one speed, with cells of one size
        speed = scene.basins.rpm.model_copy(update={"stop": scene.basins.rpm.start})
        parts["basins"] = Part("basins", with_values(scene, "basins", vary=(), rpm=speed, refine=0))
    if scene.explore.map:
        axes = axes_of_map(scene)
        parts["map"] = Part("sweep", with_values(scene, "sweep", vary=axes, **plain))
    return parts


def page_bytes(machine: Machine, sampled: Mapping[str, Result]) -> float:
    """About how long the page of a scene will be, from sweeps of a few of its speeds.

    sampled: results by the names of `parts_of`. Orbits that no sweep finds are taken to add
    SOLVED of what the sweeps find.
    """
    scene = machine.scene
    sweeps = [(way, sampled[f"sweep {way}"]) for way in DIRECTIONS]
    span = scene.sweep.rpm
    samples = rows_of_the_page(machine)
    motions = attractors(machine, sweeps, MOST_ROWS // (samples * span.num))
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
        one, two = (min(SIDE, axis.num) for axis in axes_of_map(scene))
        beside += each * one * two
    bare = len(page({"source": "", **machine_data(machine)}))
    return bare + (1.0 + SOLVED) * share * found + per_turn * beside + cells


def _nothing_to_show(sweeps: list[tuple[str, Result]]) -> Fault:
    """Why no speed has a motion, and what to do about it."""
    statuses = [Status(speed.status) for _, result in sweeps for speed in result.values[0].speeds]
    status = max(set(statuses), key=statuses.count)
    found = f"found no motion at any speed ({CAUSES[status]})"
    return Fault("", "sweep.rpm", found, "expected one at least", CURES[status])


def _orbits_scene(scene: Scene) -> Scene:
    """The scene of the page's orbits: followed over the speeds of its sweeps, and no more."""
    span = scene.sweep.rpm
    at = scene.orbits.at
    low, high = sorted((span.start, span.stop))
    rpm = scene.orbits.rpm.model_copy(update={"start": low, "stop": high})
    at = at if at is not None and low <= at <= high else None
    followed = {"vary": (), "rpm": rpm, "at": at, "parameter": "rpm", "range": None, "curve": None}
    more = {"chaos": False, "all": None, "prove": False, "checker": False, "simulated": 0}
    return with_values(scene, "orbits", **followed, **more)


# --- the command


SHOWN_MOTIONS = 256  # of a window of starts, or of a map
LEAST_ROWS = 48  # of a turn
MOTIONS_OF_A_SPEED, TURNS_OF_A_MOTION = 2.0, 8.0  # that the page shows, where it shows few

# Measured sizes, in bytes.
PER_RECORDED_TURN, PER_RECORD = 64.0, 1e3  # in memory
PER_CELL, PER_POINT_OF_MAP = 70.0, 1e3  # in memory
ROW_IN_MEMORY, ROW_ON_PAGE = 280.0, 17.0
BARE_PAGE = 90e3


def _size(scene: Scene) -> Size:
    """Sweeps whose records are all in memory, and the motions, basins and map of the page.

    Each of DIRECTIONS is a sweep. orbits and turns are what the kernel computes; shown_turns are
    those whose trajectory is on the page, which makes most of its size.
    """
    speeds = scene.sweep.rpm.num
    turns = scene.run.transient + scene.run.record
    orbits = len(DIRECTIONS) * speeds
    all_turns = float(orbits * turns)
    shown_turns = MOTIONS_OF_A_SPEED * speeds
    memory = len(DIRECTIONS) * speeds * (PER_RECORDED_TURN * scene.run.record + PER_RECORD)
    cells = 0
    if scene.explore.basins:
        cells = scene.basins.cells[0] * scene.basins.cells[1]
        orbits += cells
        shown_turns += TURNS_OF_A_MOTION * SHOWN_MOTIONS
        memory += PER_CELL * cells
    points = 0
    if scene.explore.map:
        axes = scene.sweep.vary
        if axes:
            others = axes[1].num if len(axes) == 2 else speeds
            points = axes[0].num * others
        orbits += points
        all_turns += points * turns
        shown_turns += TURNS_OF_A_MOTION * SHOWN_MOTIONS
        memory += PER_POINT_OF_MAP * points
    rows = LEAST_ROWS * shown_turns
    return Size(
        what=plan.parts_of_a_page(speeds, cells, points),
        pieces=speeds,
        orbits=orbits,
        turns=all_turns,
        rows=speeds,
        memory=memory + ROW_IN_MEMORY * rows,
        tables=BARE_PAGE + ROW_ON_PAGE * rows,
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
