"""camcli.basins: which attractor each start lands on."""

from collections.abc import Iterator, Sequence
from math import degrees
from typing import Any

import numpy as np

from camcli.analysis.after_rest import CYCLE, SETTLED
from camcli.analysis.basins.refinement import leaves
from camcli.analysis.basins.study import Basins, BasinsQuestion, Study, study
from camcli.analysis.basins.window import Window
from camcli.analysis.labels import Label
from camcli.analysis.sweep import status_name
from camcli.analysis.throw import throw
from camcli.api.command import Command, Drawing, Repeated, Size, fewer, sample
from camcli.api.machine import machine_of, span_of, with_values
from camcli.api.result import Progress, Result, drawn_by
from camcli.api.rows import multiplier_columns
from camcli.errors import worst_status
from camcli.kernel.backend import stopwatch
from camcli.output.tables import Block, Table
from camcli.parallel import Work
from camcli.piece_faults import PieceFault, attempt, gather, gathering, piece
from camcli.quantities import EXPONENT, LABEL, MULTIPLIERS, RPM, VARIED, Head, Q, Quantity, V
from camcli.scene import Scene
from camcli.system import omega_of
from camcli.words import plan
from camcli.words.basins import CRITERION, basins_notes
from camcli.words.machine import height_notes

NUMBER = Quantity(
    "attractor", "", "attractor", "number of the attractor", "0 undecided, below 0 a trouble"
)
ATTRACTORS = Head(
    "attractors",
    "the attractors of each speed, and what belongs to none",
    (
        NUMBER, LABEL, Q, V, Quantity("fraction", "", "fraction", "share of the cells"),
        Quantity("standard_error", "", "standard error", "of that share"), RPM,
    ),
    {
        "with basins.exponents": (*MULTIPLIERS, EXPONENT),
        "first, where another number is varied": (VARIED._replace(column="KEY", unit=""),),
    },
)  # fmt: skip
GROWTH = tuple(one.column for one in ATTRACTORS.more["with basins.exponents"])
BASINS = Head(
    "basins",
    "a cell each, at its centre, of up to three speeds; with refinement cells are of different "
    "sizes, those cut in four have no row",
    (Q, V, NUMBER),
    {"of two or three speeds": (VARIED,)},
)
SADDLES = Head(
    "saddles",
    "with basins.saddles: the saddles on the boundaries",
    (
        VARIED, LABEL, Q, V, *MULTIPLIERS,
        Quantity("led", "", "led", "motions beside the boundary that came near to it"),
        Quantity("tried", "", "tried", "motions tried"),
    ),
)  # fmt: skip
ROWS = 1 << 16  # of a refined grid at a time


def basins(
    scene: Scene | None = None, progress: Progress | None = None, *, work: Work | None = None
) -> Result:
    """Map a window of starts at the strobe phase onto the attractors they reach.

    Parameters
    ----------
    scene : Scene, optional
        The machine and the section ``basins``: a window of position and velocity, the number of
        cells, one speed or a range of speeds, or ``vary`` for another number (``key``, ``start``,
        ``stop``, ``num``), at the speed ``run.rpm``; the default scene if left out.
    progress : callable, optional
        Called as ``progress(what, done, total)``.
    work : Work, optional
        How the cells are computed: threads, a cluster, pieces kept on disk. It never changes a
        result.

    Returns
    -------
    Result
        Tables ``attractors``, of up to three speeds ``basins``, and with ``basins.saddles``
        ``saddles``; their columns are in the guide (`cam guide basins`).

        In ``summary`` stand the basin entropy, the boundary entropy and, with ``basins.boundary``,
        the uncertainty exponent. There are also the departures from rest whose end only ball
        arithmetic could tell; ``holds_for`` says of which machines each is true, as in
        ``classify``.

    Examples
    --------
    >>> import camcli
    >>> found = camcli.basins(camcli.load_scene(None, {"basins.cells": [8, 8]}))
    >>> found.tables["attractors"]["label"].tolist()
    ['P(1;2)', 'P(3;3:3:2)']
    >>> len(found.tables["basins"]["attractor"])
    64

    References
    ----------
    Cell mapping: C. S. Hsu, Cell-to-Cell Mapping (1987). Basin entropy: A. Daza, A. Wagemakers,
    B. Georgeot, D. Guery-Odelin and M. A. F. Sanjuan, Scientific Reports 6 (2016) 31416.
    """
    machine = machine_of(scene)
    scene = machine.scene
    section = machine.scene.basins
    system = machine.system
    window = Window(section.q, section.v, *section.cells)
    question = BasinsQuestion(window, section.budget, section.refine)
    key, values, setup = span_of(machine, section)
    total = window.count * len(values)
    done = 0

    def on_cells(cells: int) -> None:
        """Count cells that are done, of all speeds together."""
        nonlocal done
        done += cells
        if progress is not None:
            progress("cells", min(done, total), total)

    with stopwatch() as watch, gathering() as faults:
        found = study(
            system,
            values,
            machine.settings,
            question,
            setup=setup,
            boundary=section.boundary,
            exponents=section.exponents,
            saddles=section.saddles,
            work=work or Work(),
            on_cells=on_cells,
            key=key,
        )
        gather(fault for speed in found.speeds for fault in speed.faults)
        summary = piece("the summary", lambda: _summary(found, question), {})
    statuses = [code for speed in found.speeds for code in speed.troubled]
    heights = height_notes(throw(system, max((speed.rpm for speed in found.speeds), default=0.0)))
    tables = {"attractors": _attractors_table(found, key)}
    if found.grids:
        at = (key,) if len(found.grids) > 1 else ()
        columns = (*BASINS.names(), *at) if key == "rpm" else (*at, *BASINS.names())
        tables["basins"] = Table(columns, lambda: _cell_blocks(found.grids, question.refine, key))
    if section.saddles:
        tables["saddles"] = Table.of_rows(SADDLES.names(key), lambda: _saddle_rows(found))

    # The cam beside the picture is that of the first value, or the scene's where that one has none.
    first = attempt("", lambda: system if setup is None else setup(values[0])[0])
    with_cam = system if isinstance(first, PieceFault) else first
    return Result(
        command="basins",
        scene=scene,
        system=system,
        values=(found, question),
        tables=tables,
        summary={**summary, "status": worst_status(statuses)},
        pictures={"basins": drawn_by("basins.draw_basins", found, question, with_cam, key)},
        cost=found.cost,
        seconds=watch.seconds,
        notes=(*heights, *basins_notes(found, question.budget)),
        complete=not found.troubled,
        faults=tuple(faults),
    )


def _attractors_table(study: Study, key: str) -> Table:
    """By speed and number; what belongs to no attractor has a code of 0 or less.

    Another number than the speed comes first, under its key.
    With exponents asked for, multipliers of solved orbits and the largest exponent are appended.
    """
    columns = list(ATTRACTORS.names())
    if any(speed.exponents is not None for speed in study.speeds):
        columns += GROWTH
    varied = key != "rpm"
    if varied:
        columns.insert(0, key)

    def rows() -> Iterator[tuple]:
        for speed in study.speeds:
            for row in _rows(speed):
                yield (speed.value, *row) if varied else tuple(row)

    return Table.of_rows(columns, rows)


def _rows(speed: Basins):
    """The rows of attractors.csv of one speed: attractors by their number, then what is none.

    Without the value that is varied, which comes first where it is not the speed.
    """
    order = sorted(range(len(speed.attractors)), key=lambda k: speed.branches[k])
    for k in order:
        attractor = speed.attractors[k]
        q, w = attractor.states[0]
        v = w * omega_of(speed.rpm)
        fraction, error = speed.fractions[k + 1]
        named = speed.branches[k], attractor.label, float(q), float(v)
        yield (*named, fraction, error, speed.rpm, *_growth(speed, k))
    for code, (fraction, error) in speed.fractions.items():
        if code <= 0:
            name = "undecided" if code == 0 else status_name(-code)
            yield (code, name, None, None, fraction, error, speed.rpm, *_growth(speed, None))


def _growth(speed: Basins, k: int | None) -> list:
    """The columns GROWTH of an attractor: its multipliers and its exponent, empty where unknown.

    k: its place in `speed.attractors`, or None for cells that belong to no attractor. The list is
    empty where exponents were not asked for.
    """
    if speed.exponents is None:
        return []
    if k is None:
        return [None] * len(GROWTH)
    pair = speed.attractors[k].multipliers
    exponent = speed.exponents[k]
    if pair is None:
        return [None] * 4 + [exponent]
    return [*multiplier_columns(pair), exponent]


def _saddle_rows(study: Study) -> Iterator[tuple]:
    """The rows of saddles.csv, by speed."""
    for speed in study.speeds:
        for saddle in speed.saddles or ():
            q, w = saddle.orbit.states[0]
            at = speed.value, saddle.orbit.label, q, w * omega_of(speed.rpm)
            yield (*at, *multiplier_columns(saddle.orbit.multipliers), saddle.led, saddle.tried)


def _cell_blocks(grids: Sequence[Basins], refine: int, key: str) -> Iterator[Block]:
    """The rows of basins.csv in blocks: speed by speed, row by row in v, then by q.

    Of a refined grid there are the cells that were not cut in four. key: what is varied; its value
    is a column where there are several grids.
    """
    for grid in grids:
        numbers = np.array([*grid.branches, *range(grid.codes.min(initial=0), 1)])
        for q, v, codes in _cells(grid, refine):
            known = numbers[np.asarray(codes, dtype=int) - 1]
            at = (grid.value,) if len(grids) > 1 else ()
            yield (q, v, known, *at) if key == "rpm" else (*at, q, v, known)


def _cells(grid: Basins, refine: int) -> Iterator[Block]:
    """The cells of a grid in blocks (q in m, v in m/s, codes).

    A code k > 0 is the k-th attractor of the grid. refine: how often cells may have been cut in
    four.
    """
    window = grid.window
    if grid.level is None:
        q = window.q_of(np.arange(window.nq))
        for v, codes in zip(window.v_of(np.arange(window.nv)).tolist(), grid.codes, strict=True):
            yield q, v, codes
        return
    sides = [1 << (refine - k) for k in range(refine + 1)]  # finest cells along a cell's side
    sizes = [window.with_cells(window.nq // side, window.nv // side) for side in sides]
    q_of = [size.q_of(np.arange(size.nq)) for size in sizes]
    v_of = [size.v_of(np.arange(size.nv)) for size in sizes]
    uncut = leaves(grid.level, refine)
    for begin in range(0, len(uncut), ROWS):
        chunk = uncut[begin : begin + ROWS]
        rows, columns = chunk // window.nq, chunk % window.nq
        level = grid.level[rows, columns]
        q_m, v_m_per_s = np.empty(len(chunk)), np.empty(len(chunk))
        for n in range(refine + 1):
            of_level = level == n
            q_m[of_level] = q_of[n][columns[of_level] >> (refine - n)]
            v_m_per_s[of_level] = v_of[n][rows[of_level] >> (refine - n)]
        yield q_m, v_m_per_s, grid.codes[rows, columns]


def _summary(result: Study, question: BasinsQuestion) -> dict[str, Any]:
    """What run.json keeps: how cells are decided, and an entry for each speed."""
    return {
        "method": "orbit",
        "criterion": CRITERION,
        "budget_turns": question.budget,
        "speeds": [_record(speed, question) for speed in result.speeds],
    }


def _record(speed: Basins, question: BasinsQuestion) -> dict[str, Any]:
    """The entry of run.json for one speed: attractors, cells, rests, entropies, saddles."""
    doubt = speed.uncertainty
    return {
        "value": speed.value,
        "rpm": speed.rpm,
        "attractors": [_attractor(speed, k) for k in range(len(speed.attractors))],
        "cells": speed.cells,
        "computed": speed.computed,
        "computed_share": speed.computed / speed.cells,
        "undecided": speed.undecided,
        "rests": [
            {"departure_deg": degrees(theta), "ends": end.kind, "holds_for": end.holds_for,
             "label": Label(end.symbols) if end.kind in (SETTLED, CYCLE) else None}
            for theta, end in speed.rests
        ],
        "troubled": {status_name(code): cells for code, cells in speed.troubled.items()},
        "turns_per_cell": dict(zip(("median", "percentile_99", "most"), speed.turns, strict=True)),
        **speed.entropies,
        "saddles": [
            {"label": s.orbit.label, "led": s.led, "tried": s.tried} for s in speed.saddles or ()
        ],
        "uncertainty": None if doubt is None else {
            "exponent": doubt.exponent,
            "standard_error": doubt.error,
            "boundary_dimension": doubt.dimension,
            "error_share_count": doubt.rows,
        },
    }  # fmt: skip


def _attractor(speed: Basins, k: int) -> dict[str, Any]:
    """The entry of run.json for an attractor, by its place in `speed.attractors`.

    Where a region about its points was proved to shrink its size is there too, else how many turns
    the motion has stayed in boxes that it had visited before.
    """
    attractor = speed.attractors[k]
    region = speed.regions[k]
    fraction, error = speed.fractions[k + 1]
    record: dict[str, Any] = {
        "attractor": speed.branches[k],
        "label": attractor.label,
        "turns": attractor.turns or None,
        "states_q_m_v_m_per_s": [[q, w * omega_of(speed.rpm)] for q, w in attractor.states],
        "multipliers": list(map(complex, attractor.multipliers or ())),
        "fraction": fraction,
        "standard_error": error,
    }
    if region is None:
        return {**record, "turns_in_boxes": speed.stays[k]}
    return {
        **record,
        "ellipse_radius_over_size": region.radius,
        "form_shrinks_by": region.shrink,
        "ring_of_starts_returns": region.returns,
        "half_widths_q_m_v_m_per_s": [
            [dq, dw * omega_of(speed.rpm)] for dq, dw in region.half_widths().tolist()
        ],
    }


# --- the command


SHOWN_SPEEDS = 3  # whose cells become a table


def _size(scene: Scene) -> Size:
    """Each cell of each speed is an orbit; a table of cells is written of a few speeds only.

    Bytes of memory and disk are measured, for each cell.
    """
    section = scene.basins
    (nq, nv), levels = section.cells, section.refine
    orbits = nq * nv * section.count
    memory = 70.0 * nq * nv
    if levels:
        memory += 14.0 * nq * nv * 4**levels + 20e6
    shown = orbits if section.count <= SHOWN_SPEEDS else 0
    what = plan.cells_of_a_window(nq, nv, levels)
    return Size(
        what=what,
        pieces=orbits,
        orbits=orbits,
        turns=0.0,
        rows=shown,
        memory=memory,
        tables=18.0 * shown,
        kept=27.0 * orbits,
    )


def _sample(scene: Scene, n: int) -> Scene:
    """The window with 8 n cells along each side at most, at one speed, not refined."""
    cells = tuple(min(8 * n, side) for side in scene.basins.cells)
    return sample(scene, "basins", refine=0, cells=cells, **fewer(scene.basins, 1))


def _repeated(scene: Scene) -> Repeated:
    """Each speed, or value, has attractors to be found, and cells; the middle stands for all."""
    count = scene.basins.count
    if count == 1:
        return Repeated(scene, times=1)
    return Repeated(with_values(scene, "basins", **fewer(scene.basins, 1)), times=count)


COMMAND = Command(
    run=basins,
    tables=(ATTRACTORS, BASINS, SADDLES),
    files=("basins.png",),
    size=_size,
    drawing=lambda scene: Drawing(file=110e3, memory=270e6, per_pixel=75.0),
    sample=_sample,
    repeated=_repeated,
    not_foreseen=plan.basins,
    keeps_pieces=lambda scene: True,
)
