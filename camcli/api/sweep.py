"""camcli.sweep: the brute-force bifurcation diagram."""

from __future__ import annotations

from array import array
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import groupby
from typing import TYPE_CHECKING, Any, NamedTuple

from camcli.analysis.grid import rpm_grid
from camcli.analysis.labels import UNDECIDED, period_of
from camcli.analysis.speeds import FEW, Speed
from camcli.analysis.sweep import BOTH, FIXED, Sweep, status_name
from camcli.analysis.sweep import sweep as run
from camcli.analysis.sweep_map import Map, sweep_map
from camcli.analysis.throw import throw
from camcli.api.command import Command, Drawing, Size, fewer, sample
from camcli.api.machine import (
    Machine,
    Varied,
    check_explainable,
    machine_of,
    span_of,
    start_of,
)
from camcli.api.orbit_tables import (
    CODIM2,
    CURVE,
    PROVED_TO_NEXT,
    BranchColumns,
    codim2_table,
    curve_table,
    proved_parts,
    read_branches,
    read_curves,
)
from camcli.api.proof_files import proof_files
from camcli.api.result import Progress, Result, drawn_by, ticks
from camcli.api.rows import (
    CORNERS,
    IMPACTS,
    SPEEDS,
    STROBE,
    WITH_LASH,
    blocks,
    form,
    has_seat,
    seat_names,
    speed_row,
)
from camcli.errors import Fault, SceneError, Status, worst_status
from camcli.kernel.backend import stopwatch
from camcli.output.tables import SharedRows, Table
from camcli.parallel import Work
from camcli.parallel.work import BESIDE, IN_MEMORY
from camcli.piece_faults import gather, gathering, piece
from camcli.quantities import (
    EXPONENT,
    EXPONENT_ERROR,
    FIRST,
    HOLDS_FOR,
    LABEL,
    LOADS,
    PERIOD,
    SEAT,
    SECOND,
    STATUS,
    WATCHED,
    Head,
    Quantity,
)
from camcli.scene import Scene
from camcli.system import units_of
from camcli.words import plan
from camcli.words.loads import load_row, seat_row
from camcli.words.machine import height_notes
from camcli.words.statuses import status_notes, trouble
from camcli.words.sweep import atlas_words, map_notes, shown_cam, sweep_notes

if TYPE_CHECKING:
    from camcli.analysis.classify import ClassifiedMotion
    from camcli.analysis.explain.changes import CriticalEvent, Explanation
    from camcli.analysis.orbits.atlas import Atlas
    from camcli.analysis.orbits.codim2 import CodimTwo
    from camcli.analysis.orbits.curves import CurveLine, Plane
    from camcli.scene.schema import Sweep as SweepSection

MAP = Head(
    "map",
    "of two numbers: a point each",
    (
        FIRST, SECOND, LABEL, PERIOD,
        Quantity("impacts_per_turn", "1/turn", "impacts", "recorded impacts in a turn"),
        EXPONENT, *LOADS.values(), STATUS, HOLDS_FOR, WATCHED, EXPONENT_ERROR,
    ),
    {WITH_LASH: tuple(SEAT.values())},
)  # fmt: skip
AUTO = "auto"  # in the place of the name of a file of curves
AUTO_CURVES = CURVE._replace(
    name="curves",
    words="with curves auto: the bifurcations on a map",
    more={"with prove": (PROVED_TO_NEXT,)},
)
AUTO_POINTS = CODIM2._replace(words="with curves auto: the points at which two of them meet")


def sweep(
    scene: Scene | None = None, progress: Progress | None = None, *, work: Work | None = None
) -> Result:
    """Brute-force bifurcation diagram over the speeds of ``scene.sweep.rpm``, or another number.

    Parameters
    ----------
    scene : Scene, optional
        The machine, the number of turns (``run.transient``, ``run.record``) and the section
        ``sweep``: ``rpm.start``, ``rpm.stop``, ``rpm.num``, or ``vary`` for a number of the scene
        other than the speed (``key``, ``start``, ``stop``, ``num``); ``zoom``, parts of that range
        with values of their own; ``direction`` (fixed, or up and down to carry the state),
        ``also``, further starts, ``lyapunov``, ``explain``. The default scene if left out.
    progress : callable, optional
        Called as ``progress(what, done, total)``.
    work : Work, optional
        How the speeds are computed: threads, a cluster, pieces kept on disk. All processors by
        default. It never changes a result.

    Returns
    -------
    Result
        Tables ``impacts``, ``strobe`` and ``speeds``, with ``explain`` ``corners``; of two numbers
        ``map`` alone. Their columns are in the guide (`cam guide sweep`).

        The first column bears the key of what is varied, rpm for the speed; where the state is
        carried both ways a last one, direction, says up or down; with ``also`` a last one, start,
        says from which: 0 is ``run.start``. ``sweep.sections`` and ``sweep.tables`` leave out what
        is not wanted.

    Raises
    ------
    SceneError
        If the start lies below the cam, or changes shall be explained of a sweep that carries its
        state or has one speed only.

    Examples
    --------
    >>> import camcli
    >>> speeds = {"sweep.rpm.start": 100, "sweep.rpm.stop": 120, "sweep.rpm.num": 3}
    >>> table = camcli.sweep(camcli.load_scene(None, speeds)).tables["speeds"]
    >>> table["rpm"].tolist()
    [100.0, 110.0, 120.0]
    >>> table["label"].tolist()
    ['contact', 'contact', 'P(1;inf)']

    References
    ----------
    The diagrams of the default scene: G. Osorio, M. di Bernardo and S. Santini, arXiv:0711.1008.
    """
    machine = machine_of(scene)
    scene = machine.scene
    section = machine.scene.sweep
    _refuse_what_contradicts(section)
    if len(section.vary) == 2:
        return _mapped(machine, progress, work or Work())
    key, values, setup = span_of(machine, section)
    branches = [] if section.branches is None else read_branches(section.branches, key)
    if section.zoom:
        for zoom in section.zoom:
            values += rpm_grid(zoom.start, zoom.stop, zoom.num)
        falls = values[0] > values[-1]
        values = sorted(set(values), reverse=falls)
    compact = array("d", values)
    del values  # a list takes four times as much
    count = len(compact) * (1 + len(section.also))
    work = work or Work()
    with stopwatch() as watch, gathering() as faults:
        found = run(
            machine.system,
            compact,
            machine.settings,
            key=key,
            setup=setup,
            direction=section.direction,
            also=[
                start_of(scene, machine.system, start, f"sweep.also.{k}")
                for k, start in enumerate(section.also)
            ],
            adaptive=section.adaptive,
            impacts="impacts" in section.sections,
            strobe="strobe" in section.sections,
            lyapunov=section.lyapunov,
            work=work,
            on_speed=ticks(progress, "speeds", count),
        )
        gather(found.faults)
        motions: list[ClassifiedMotion] = []
        explanation: Explanation | None = None
        if section.explain:
            motions, explanation = _explained(machine, found, progress, work)
        result = _result(machine, found, branches, motions, explanation)
    return replace(result, seconds=watch.seconds, faults=tuple(faults))


def _refuse_what_contradicts(section: SweepSection) -> None:
    """Raise SceneError where the section asks for what does not go together.

    An explanation of a carried state, curves without a map, proofs of other curves than its own.
    """
    if section.explain and section.direction != FIXED:
        found, cure = f"found {section.direction}", "leave --explain out, or set it to fixed"
        raise SceneError(Fault("--explain", "sweep.direction", found, "expected fixed", cure))
    if section.explain:
        check_explainable(section, "sweep")
    if section.curves is not None and len(section.vary) != 2:
        cure = "vary a second number: --vary KEY=LO:HI"
        fault = Fault("--curves", "sweep.vary", "found no map", "expected two numbers", cure)
        raise SceneError(fault)
    if section.prove and section.curves != AUTO:
        found = "found none" if section.curves is None else f"found {section.curves}"
        expected = f"expected {AUTO}, whose curves are proved"
        cure = "add --curves auto, or leave --prove out; cam orbits --prove proves other curves"
        raise SceneError(Fault("--prove", "sweep.curves", found, expected, cure))


def _map_rows(found: Map, turns: int, seat: bool) -> Iterator[tuple]:
    """The rows of map.csv, line by line of the second number.

    turns: recorded at each point; seat: with the columns of a cam with lash.
    """
    for second, line in zip(found.second, found.lines, strict=True):
        for speed in line:
            count = speed.impact_count
            yield (
                speed.value,
                second,
                speed.label,
                period_of(speed.label) or None,
                None if count is None else count / turns,
                speed.exponent,
                *load_row(speed.loads),
                status_name(speed.status),
                speed.holds_for,
                speed.watched,
                speed.exponent_error,
                *(seat_row(speed.loads) if seat else ()),
            )


def _mapped(machine: Machine, progress: Progress | None, work: Work) -> Result:
    """The result for two numbers: the kind of motion at each point, without the records."""
    section = machine.scene.sweep
    if section.direction == BOTH:
        cure = "choose one, e.g. sweep.direction=up"
        raise SceneError(Fault("", "sweep.direction", "found both", "expected one way", cure))
    first, second = section.vary
    keys = (first.key, second.key)
    plane = None
    lines: list[CurveLine] = []  # curves over the map
    if section.curves == AUTO:
        from camcli.api.atlas import plane_of

        plane = plane_of(machine.scene, section.vary)
    elif section.curves is not None:
        lines = read_curves(section.curves, keys)
    auto: _AutoCurves | None = None
    with gathering() as faults, stopwatch() as watch:
        found = sweep_map(
            keys,
            rpm_grid(first.start, first.stop, first.num),
            rpm_grid(second.start, second.stop, second.num),
            Varied(machine, section.vary),
            direction=section.direction,
            lyapunov=section.lyapunov,
            decide=section.decide,
            work=work,
            on_line=ticks(progress, "lines", second.num),
        )
        gather(found.faults)
        if plane is not None:
            auto = _auto_curves(machine, plane, keys, progress)
            lines = auto.lines

    seat = has_seat(machine.scene, keys)
    rows = partial(_map_rows, found, machine.settings.record, seat)
    tables = {"map": Table.of_rows((*MAP.names(*keys), *seat_names(seat)), rows)}
    counts = Counter((speed.label, status_name(speed.status)) for speed in found.speeds)
    statuses = [speed.status for speed in found.speeds]
    summary_of_curves: dict[str, Any] = {}
    cost = found.cost
    points: Sequence[CodimTwo] = ()
    why_cut_short: list[str] = []  # a note where the curves are not complete
    if auto is not None:
        tables |= auto.tables
        summary_of_curves = auto.summary
        statuses.append(auto.status)
        cost += auto.atlas.cost
        points = auto.atlas.points
        why_cut_short = trouble(auto.status)
    troubled = [(speed.value, speed.status) for speed in found.speeds if speed.status != Status.OK]
    units = units_of(machine.system)
    kind = machine.scene.cam.kind
    return Result(
        command="sweep",
        scene=machine.scene,
        system=machine.system,
        values=(found, None),
        tables=tables,
        summary={
            "direction": found.direction,
            "status": worst_status(statuses),
            "labels": [
                {"label": label, "status": status, "points": count}
                for (label, status), count in counts.items()
            ],
            **summary_of_curves,
        },
        pictures={"map": drawn_by("sweep_map.draw_map", found, units, lines, points, seat, kind)},
        files=proof_files(None if auto is None else auto.certificate),
        cost=cost,
        seconds=watch.seconds,
        notes=(
            *map_notes(found, section.decide),
            *status_notes(troubled, first.key),
            *why_cut_short,
        ),
        complete=not troubled and not why_cut_short,
        faults=tuple(faults),
    )


@dataclass(frozen=True)
class _AutoCurves:
    """The curves that `--curves auto` follows over a map, and what a result has of them.

    status: whether the budget lasted; lines: to be drawn; certificate: the content of proof.json,
    None where nothing was to be proved.
    """

    atlas: Atlas
    status: Status
    lines: list[CurveLine]
    tables: dict[str, Table]
    summary: dict[str, Any]
    certificate: dict[str, Any] | None


def _auto_curves(
    machine: Machine, plane: Plane, keys: tuple[str, str], progress: Progress | None
) -> _AutoCurves:
    """Follow the curves over a map, and with sweep.prove prove them; keys: of its two numbers."""
    from camcli.api.atlas import atlas_of

    section = machine.scene.sweep
    atlas, status = atlas_of(machine, section.vary, plane, progress)
    proved = atlas.ranges is not None
    lines = []
    for number, curve in enumerate(atlas.curves, 1):
        parts = proved_parts(atlas.ranges or (), number, len(curve.points))
        lines.append(curve.line._replace(proved=parts))

    excess = getattr(machine.system.shape, "flank_excess", 0.0)  # of a cam of arcs alone
    sentences: list[str] = []
    searched_to_the_end = not trouble(status)
    if atlas.curves or searched_to_the_end:  # else that there are none says nothing
        words = partial(atlas_words, atlas, section.prove_turns, excess)
        sentences = piece("the sentences", words, [])
    summary: dict[str, Any] = {"words": sentences}
    certificate = None
    if proved:
        summary["proofs"] = piece("the summary of proofs", partial(_proofs, atlas, excess), {})
        certificate = piece("proof.json", partial(_certificate, machine, atlas), None)

    key_of = dict(zip(plane.names, keys, strict=True))
    tables = {
        "curves": curve_table(atlas.curves, plane, key_of, ranges=atlas.ranges),
        "codim2": codim2_table(atlas.points, plane, key_of, proved),
    }
    return _AutoCurves(atlas, status, lines, tables, summary, certificate)


def _certificate(machine: Machine, atlas: Atlas) -> dict[str, Any]:
    """The content of proof.json: a statement for each part of a curve that is proved."""
    from camcli.analysis.orbits.certificate import certificate_of_curves
    from camcli.cams.formula import formula_of
    from camcli.words.proofs import named

    system = machine.system
    return certificate_of_curves(
        atlas.ranges or (),
        atlas.curves,
        formula_of(system.shape, system.follower.seat_restitution),
        machine.scene.run.strobe_deg,
        named,
    )


def _proofs(atlas: Atlas, flank_excess: float) -> dict[str, Any]:
    """The entry of run.json for the proofs of a map's curves and of the points on them.

    flank_excess: by how much (m) the flank circle of the proofs is larger than the scene's. A curve
    that is not tried has its number and the turns of its orbits. Of a point, in the order of
    codim2.csv, None says that it was not tried.
    """
    from camcli.words.proofs import FAILED, range_record

    points: list[dict[str, Any] | None] = []
    for point in atlas.points:
        if point.proof is None:
            points.append(None)
        elif point.proof.step is None:  # no step has failed
            points.append({"proved": True, "failed_step": None})
        else:
            points.append({"proved": False, "failed_step": FAILED[point.proof.step]})
    not_tried = []
    for number in atlas.not_tried:
        curve = atlas.curves[number - 1]
        not_tried.append({"curve": number, "turns": curve.points[0].orbit.turns})
    return {
        "curve_ranges": [range_record(part) for part in atlas.ranges or ()],
        "not_tried": not_tried,
        "points": points,
        "flank_excess_m": flank_excess,
    }


def _explained(
    machine: Machine, found: Sweep, progress: Progress | None, work: Work
) -> tuple[list[ClassifiedMotion], Explanation]:
    """The motions from the scene's own start with their exponents, and why they change.

    They are those at the speeds of the sweep, each once, without the speeds that failed.
    """
    from camcli.analysis.classify import classify
    from camcli.api.explanation import explanation_of

    rpms = list(dict.fromkeys(speed.rpm for speed in found.bare if speed.fault is None))
    motions = classify(
        machine.system,
        machine.settings,
        rpms,
        threads=work.threads,
        on_speed=ticks(progress, "motions", len(rpms)),
    )
    gather(motion.fault for motion in motions if motion.fault is not None)
    return motions, explanation_of(machine, motions, progress)


def _result(
    machine: Machine,
    found: Sweep,
    branches: list[BranchColumns],
    motions: list[ClassifiedMotion],
    explanation: Explanation | None,
) -> Result:
    """The result of a sweep over one number, still without its time and its faults."""
    scene = machine.scene
    system = machine.system
    section = scene.sweep
    cost = found.cost
    summary = piece("the summary", lambda: _summary(found), {})
    troubled = found.troubled
    statuses = [status for _, status in troubled]
    tables = _tables(found, section, has_seat(scene, (found.key,)))
    events: Sequence[CriticalEvent] = ()
    why_cut_short: list[str] = []  # a note where the explanation is not complete
    if explanation is not None:
        from camcli.api.explanation import corners_table, explained

        cost = sum((motion.cost for motion in motions), cost + explanation.cost)
        summary |= piece("the summary of changes", lambda: explained(explanation), {})
        why_cut_short = trouble(explanation.status)
        statuses.append(explanation.status)
        tables["corners"] = corners_table(explanation)
        events = explanation.events

    zooms = [(min(zoom.start, zoom.stop), max(zoom.start, zoom.stop)) for zoom in section.zoom]
    limits = {"impacts": section.phases_deg, "strobe": section.positions_m}
    cam = shown_cam(found.key, scene.cam)
    picture = drawn_by(
        "sweep.draw_sweep", found, system, machine.settings, events, branches, zooms, limits, cam
    )
    fastest = max((speed.rpm for speed in found.bare), default=0.0)
    heights = height_notes(throw(system, fastest))
    return Result(
        command="sweep",
        scene=scene,
        system=system,
        values=(found, explanation),
        tables=tables,
        summary={**summary, "status": worst_status(statuses)},
        pictures={"sweep": picture},
        cost=cost,
        notes=(*heights, *sweep_notes(found), *status_notes(troubled, found.key), *why_cut_short),
        complete=not troubled and not why_cut_short,
    )


def _tables(found: Sweep, section: SweepSection, seat: bool) -> dict[str, Table]:
    """The tables of a sweep by name, but for that of an explanation.

    section: which tables the scene wants; seat: whether the follower has a seat.
    """
    tables: dict[str, Table] = {}
    rows = SharedRows(partial(blocks, found), partial(form, found))
    for head in (IMPACTS, STROBE):
        if head.name in section.sections and section.tables != "none":
            columns = (*head.names(found.key), *found.way_names)
            tables[head.name] = rows.table(head.name, columns)

    def speed_rows() -> Iterator[tuple]:
        """The rows of speeds.csv."""
        for speed, way in zip(found.bare, found.ways, strict=True):
            yield (*speed_row(speed, seat), *way)

    columns = (*SPEEDS.names(found.key), *seat_names(seat), *found.way_names)
    tables["speeds"] = Table.of_rows(columns, speed_rows)
    return tables


def _summary(found: Sweep) -> dict[str, Any]:
    """What run.json keeps: the ranges of one label, and how many labels hold for which machines."""
    return {
        "direction": found.direction,
        "undecided": sum(speed.label == UNDECIDED for speed in found.bare),
        "holds_for": Counter(speed.holds_for for speed in found.bare if speed.holds_for),
        "ranges": [
            {
                "label": label_range.label,
                "status": label_range.status,
                "from_rpm": label_range.first,
                "to_rpm": label_range.last,
                "speeds": label_range.speeds,
                **dict(zip(found.way_names, label_range.way, strict=True)),
            }
            for label_range in ranges(found)
        ],
    }


class LabelRange(NamedTuple):
    """Consecutive speeds with one label and status, computed in one way.

    way: the direction, or the number of the start, where a sweep has several; else empty.
    first, last: their values of what is varied; speeds: how many they are.
    exponents: (largest exponent, its standard error) of each speed at which it is known.
    """

    label: str
    status: str
    way: tuple[str | int, ...]
    first: float
    last: float
    speeds: int
    exponents: tuple[tuple[float, float], ...]


def ranges(found: Sweep) -> list[LabelRange]:
    """The speeds of a sweep in ranges of one label, in the order in which they were computed."""

    def alike(pair: tuple[Speed, tuple[str | int, ...]]) -> tuple:
        """What neighbours of one range have in common."""
        speed, way = pair
        return speed.label, status_name(speed.status), way

    found_ranges = []
    in_order = zip(found.bare, found.ways, strict=True)
    for (label, status, way), members in groupby(in_order, alike):
        values = array("d")
        exponents = []
        for speed, _ in members:
            values.append(speed.value)
            if speed.exponent is not None:
                exponents.append((speed.exponent, speed.exponent_error or 0.0))
        found_ranges.append(
            LabelRange(
                label=label,
                status=status,
                way=way,
                first=values[0],
                last=values[-1],
                speeds=len(values),
                exponents=tuple(exponents),
            )
        )
    return found_ranges


# --- the command


def _size(scene: Scene) -> Size:
    """Each value, from each start and in each direction, is an orbit. Bytes are measured.

    Raises SceneError for what contradicts itself, and for curves that cannot be followed.
    """
    section = scene.sweep
    run = scene.run
    _refuse_what_contradicts(section)
    if section.curves == AUTO:
        from camcli.api.atlas import plane_of

        plane_of(scene, section.vary)
    turns = run.transient + run.record
    orbits = section.count + sum(zoom.num for zoom in section.zoom)
    orbits *= 1 + len(section.also)
    if section.direction == BOTH:
        orbits *= 2
    recorded = orbits * run.record * len(section.sections)  # rows of impacts and strobe, about
    rows = 100.0 * orbits + 2e3 * min(orbits, FEW)  # bytes, of speeds without sections
    beside = BESIDE * orbits
    if len(section.vary) == 2:
        first, second = section.vary
        orbits = first.num * second.num
        recorded = 0
        rows = 1e3 * orbits
        beside = 0
    kept = 32.0 * recorded + 800.0 * orbits
    memory = 32.0 * recorded / max(1, orbits) + rows + min(IN_MEMORY, kept + beside)
    tables = 140.0 * orbits
    if section.tables != "none":
        tables += 43.0 * recorded
    return Size(
        what=plan.speeds_of_a_sweep(orbits, turns, run.record),
        pieces=orbits,
        orbits=orbits,
        turns=orbits * turns,
        rows=orbits,
        memory=memory,
        tables=tables,
        kept=kept,
    )


def _drawing(scene: Scene) -> Drawing:
    """A map takes more memory for each pixel than a diagram does, but less for itself."""
    if len(scene.sweep.vary) == 2:  # map.png
        return Drawing(file=80e3, memory=130e6, per_pixel=30.0)
    return Drawing(file=700e3, memory=230e6, per_pixel=15.0)


def _sample(scene: Scene, n: int) -> Scene:
    """n speeds, without zooms, further starts, added speeds, explanation, curves and proofs."""
    left_out: dict[str, Any] = {
        "zoom": (), "also": (), "explain": False, "adaptive": False, "prove": False,
    }  # fmt: skip
    if scene.sweep.curves == AUTO:
        left_out["curves"] = None
    return sample(scene, "sweep", **left_out, **fewer(scene.sweep, n))


COMMAND = Command(
    run=sweep,
    tables=(IMPACTS, STROBE, SPEEDS, CORNERS, MAP, AUTO_CURVES, AUTO_POINTS),
    files=("impacts.npz", "strobe.npz", "sweep.png", "map.png", "proof.json"),
    size=_size,
    drawing=_drawing,
    sample=_sample,
    not_foreseen=plan.sweep,
    keeps_pieces=lambda scene: True,
    less=plan.LESS_OF_A_SWEEP,
)  # fmt: skip
