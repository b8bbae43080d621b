"""camcli.sweep: the brute-force bifurcation diagram."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from itertools import groupby
from typing import TYPE_CHECKING, Any, NamedTuple

from camcli.analysis.grid import rpm_grid
from camcli.analysis.integrate import Cost
from camcli.analysis.labels import UNDECIDED, period_of
from camcli.analysis.sweep import BOTH, FIXED, Map, Speed, Sweep, status_name, sweep_map
from camcli.analysis.sweep import sweep as run
from camcli.analysis.throw import throw
from camcli.api.command import Command, Drawing, Size, fewer, sample
from camcli.api.machine import Machine, Varied, machine_of, refuse_to_explain, span_of, start_of
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
    has_seat,
    seat_names,
    speed_row,
)
from camcli.errors import Fault, SceneError, Status, worst_status
from camcli.kernel.backend import stopwatch
from camcli.output.tables import SharedRows, Table
from camcli.parallel import Work
from camcli.parallel.work import IN_MEMORY
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
    from camcli.analysis.explain.changes import Explanation
    from camcli.analysis.orbits.atlas import Atlas
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
        values += [x for part in section.zoom for x in rpm_grid(part.start, part.stop, part.num)]
        values = sorted(set(values), reverse=values[0] > values[-1])
    work = work or Work()
    with stopwatch() as watch, gathering() as faults:
        found = run(
            machine.system,
            values,
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
            on_speed=ticks(progress, "speeds", len(values) * (1 + len(section.also))),
        )
        gather(found.faults)
        motions: list[ClassifiedMotion] = []
        explanation: Explanation | None = None
        if section.explain:
            motions, explanation = _explained(machine, found, progress, work)
        result = _result(machine, found, branches, motions, explanation)
    return replace(result, seconds=watch.seconds, faults=tuple(faults))


def _refuse_what_contradicts(section: SweepSection) -> None:
    """Raise SceneError for an explanation of a carried state, and for curves without a map."""
    if section.explain and section.direction != FIXED:
        found, cure = f"found {section.direction}", "leave --explain out, or set it to fixed"
        raise SceneError(Fault("--explain", "sweep.direction", found, "expected fixed", cure))
    if section.explain:
        refuse_to_explain(section, "sweep")
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
    one, two = section.vary
    keys = (one.key, two.key)
    auto = section.curves == AUTO
    lines = [] if section.curves is None or auto else read_curves(section.curves, keys)
    plane = None
    if auto:
        from camcli.api.atlas import atlas_of, plane_of

        plane = plane_of(machine.scene, section.vary)
    with stopwatch() as watch, gathering() as faults:
        found = sweep_map(
            keys,
            rpm_grid(one.start, one.stop, one.num),
            rpm_grid(two.start, two.stop, two.num),
            Varied(machine, section.vary),
            direction=section.direction,
            lyapunov=section.lyapunov,
            decide=section.decide,
            work=work,
            on_line=ticks(progress, "lines", two.num),
        )
        gather(found.faults)
        atlas = None
        excess = getattr(machine.system.shape, "flank_excess", 0.0)  # of a cam of arcs alone
        statuses = [speed.status for speed in found.speeds]
        cut: list[str] = []
        sentences: list[str] = []
        if plane is not None:
            atlas, status = atlas_of(machine, section.vary, plane, progress)
            lines = [
                one.line._replace(proved=proved_parts(atlas.ranges or (), k, len(one.points)))
                for k, one in enumerate(atlas.curves, 1)
            ]
            cut = trouble(status)
            statuses.append(status)
            if atlas.curves or not cut:  # none found is a result only where all was looked for
                words = partial(atlas_words, atlas, section.prove_turns, excess)
                sentences = piece("the sentences", words, [])
    seat = has_seat(machine.scene, keys)
    counts = Counter((speed.label, status_name(speed.status)) for speed in found.speeds)
    troubled = [(s.value, s.status) for s in found.speeds if s.status != Status.OK]
    notes = (*map_notes(found, section.decide), *status_notes(troubled, one.key), *cut)
    rows = partial(_map_rows, found, machine.settings.record, seat)
    tables = {"map": Table.of_rows((*MAP.names(*keys), *seat_names(seat)), rows)}
    summary: dict[str, Any] = {}
    if atlas is not None:
        named = dict(zip(atlas.plane.names, keys, strict=True))
        ranges = atlas.ranges
        proved = atlas.ranges is not None
        tables["curves"] = curve_table(atlas.curves, atlas.plane, named, ranges=ranges)
        tables["codim2"] = codim2_table(atlas.points, atlas.plane, named, proved)
        summary = {"words": sentences}
    certificate = None
    if atlas is not None and atlas.ranges is not None:
        with gathering() as late:
            summary["proofs"] = piece("the summary of proofs", partial(_proofs, atlas, excess), {})
            certificate = piece("proof.json", partial(_certificate, machine, atlas), None)
        faults += late
    points = [] if atlas is None else atlas.points
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
            "labels": [{"label": a, "status": b, "points": n} for (a, b), n in counts.items()],
            **summary,
        },
        pictures={"map": drawn_by("sweep_map.draw_map", found, units, lines, points, seat, kind)},
        files=proof_files(certificate),
        cost=found.cost + (Cost() if atlas is None else atlas.cost),
        seconds=watch.seconds,
        notes=notes,
        complete=not troubled and not cut,
        faults=tuple(faults),
    )


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

    A curve that is not tried has its number and the turns of its orbits. Of a point, in the order
    of codim2.csv, None says that it was not tried.
    """
    from camcli.words.proofs import FAILED, range_record

    points: list[dict[str, Any] | None] = []
    for point in atlas.points:
        if point.proof is None:
            points.append(None)
            continue
        step = point.proof.step
        points.append({"proved": step is None, "failed_step": step and FAILED[step]})
    return {
        "curve_ranges": [range_record(one) for one in atlas.ranges or ()],
        "not_tried": [
            {"curve": number, "turns": atlas.curves[number - 1].points[0].orbit.turns}
            for number in atlas.not_tried
        ],
        "points": points,
        "flank_excess_m": flank_excess,
    }


def _explained(
    machine: Machine, found: Sweep, progress: Progress | None, work: Work
) -> tuple[list[ClassifiedMotion], Explanation]:
    """The motions from the scene's own start with their exponents, and why they change."""
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
    section = machine.scene.sweep
    cost = found.cost
    cut = list[str]()
    summary = piece("the summary", lambda: _summary(found), {})
    statuses = [speed.status for speed in found.troubled]
    rows = SharedRows(partial(blocks, found))
    tables: dict[str, Table] = {
        head.name: rows.table(head.name, (*head.names(found.key), *found.way_names))
        for head in (IMPACTS, STROBE)
        if head.name in section.sections and section.tables != "none"
    }
    seat = has_seat(scene, (found.key,))
    tables["speeds"] = Table.of_rows(
        (*SPEEDS.names(found.key), *seat_names(seat), *found.way_names),
        lambda: ((*speed_row(a, seat), *b) for a, b in zip(found.bare, found.ways, strict=True)),
    )
    if explanation is not None:
        from camcli.api.explanation import corners_table, explained

        cost = sum((motion.cost for motion in motions), cost + explanation.cost)
        summary |= piece("the summary of changes", lambda: explained(explanation), {})
        cut = trouble(explanation.status)
        statuses.append(explanation.status)
        tables["corners"] = corners_table(explanation)

    events = () if explanation is None else explanation.events
    zooms = [(min(z.start, z.stop), max(z.start, z.stop)) for z in section.zoom]
    own = machine.system, machine.settings
    drawn = {"impacts": section.phases_deg, "strobe": section.positions_m}
    cam = shown_cam(found.key, scene.cam)
    draw = drawn_by("sweep.draw_sweep", found, *own, events, branches, zooms, drawn, cam)
    troubled = [(speed.value, speed.status) for speed in found.troubled]
    heights = height_notes(throw(machine.system, max((s.rpm for s in found.bare), default=0.0)))
    return Result(
        command="sweep",
        scene=scene,
        system=machine.system,
        values=(found, explanation),
        tables=tables,
        summary={**summary, "status": worst_status(statuses)},
        pictures={"sweep": draw},
        cost=cost,
        notes=(*heights, *sweep_notes(found), *status_notes(troubled, found.key), *cut),
        complete=not troubled and not cut,
    )


def _summary(found: Sweep) -> dict[str, Any]:
    """What run.json keeps: the ranges of one label, and how many labels hold for which machines."""
    return {
        "direction": found.direction,
        "undecided": sum(speed.label == UNDECIDED for speed in found.bare),
        "holds_for": Counter(filter(None, (speed.holds_for for speed in found.bare))),
        "ranges": [
            {
                "label": alike.label,
                "status": alike.status,
                "from_rpm": alike.first.value,
                "to_rpm": alike.last.value,
                "speeds": alike.speeds,
                **dict(zip(found.way_names, alike.way, strict=True)),
            }
            for alike in ranges(found)
        ],
    }


class LabelRange(NamedTuple):
    """Consecutive speeds with one label and status, computed in one way.

    way: the direction, or the number of the start, where a sweep has several; else empty.
    exponents: (largest exponent, its standard error) of each speed at which it is known.
    """

    label: str
    status: str
    way: tuple[str | int, ...]
    first: Speed
    last: Speed
    speeds: int
    exponents: tuple[tuple[float, float], ...]


def ranges(found: Sweep) -> list[LabelRange]:
    """The speeds of a sweep in ranges of one label, in the order in which they were computed."""
    groups = []
    for (label, status, way), members in groupby(
        zip(found.bare, found.ways, strict=True),
        lambda pair: (pair[0].label, status_name(pair[0].status), pair[1]),
    ):
        alike = [speed for speed, _ in members]
        groups.append(
            LabelRange(
                label=label,
                status=status,
                way=way,
                first=alike[0],
                last=alike[-1],
                speeds=len(alike),
                exponents=tuple(
                    (speed.exponent, speed.exponent_error or 0.0)
                    for speed in alike
                    if speed.exponent is not None
                ),
            )
        )
    return groups


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
    n = section.count + sum(part.num for part in section.zoom)
    n *= 1 + len(section.also)
    if section.direction == BOTH:
        n *= 2
    recorded = n * run.record * len(section.sections)
    if len(section.vary) == 2:
        n = section.vary[0].num * section.vary[1].num
        recorded = 0
    kept = 32.0 * recorded + 800.0 * n
    memory = 32.0 * recorded / max(1, n) + 1e3 * n + min(IN_MEMORY, kept)
    tables = 140.0 * n
    if section.tables != "none":
        tables += 43.0 * recorded
    what = plan.speeds_of_a_sweep(n, turns, run.record)
    return Size(
        what=what,
        pieces=n,
        orbits=n,
        turns=n * turns,
        rows=n,
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
    """n speeds, without what comes on top of them."""
    few = fewer(scene.sweep, n)
    alone: dict[str, Any] = {"explain": False, "adaptive": False, "prove": False}
    if scene.sweep.curves == AUTO:
        alone["curves"] = None
    return sample(scene, "sweep", zoom=(), also=(), **alone, **few)


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
