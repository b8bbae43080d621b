"""camcli.basins: which attractor each start lands on."""

from collections.abc import Iterator, Sequence
from math import degrees
from typing import Any

import numpy as np

from camcli.analysis.after_rest import CYCLE, SETTLED, After
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
ROWS_A_BLOCK = 1 << 16  # of a refined grid


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
    fastest = max((speed.rpm for speed in found.speeds), default=0.0)
    heights = height_notes(throw(system, fastest))

    # The cam beside the picture is that of the first value, or the scene's where that one has none.
    drawn_system = system
    if setup is not None:
        at_first_value = attempt("", lambda: setup(values[0])[0])
        if not isinstance(at_first_value, PieceFault):
            drawn_system = at_first_value
    return Result(
        command="basins",
        scene=scene,
        system=system,
        values=(found, question),
        tables=_tables(found, question, key, section.saddles),
        summary={**summary, "status": worst_status(statuses)},
        pictures={"basins": drawn_by("basins.draw_basins", found, question, drawn_system, key)},
        cost=found.cost,
        seconds=watch.seconds,
        notes=(*heights, *basins_notes(found, question.budget)),
        complete=not found.troubled,
        faults=tuple(faults),
    )


def _tables(study: Study, question: BasinsQuestion, key: str, saddles: bool) -> dict[str, Table]:
    """The tables by name; key: what is varied; saddles: whether these were looked for."""
    tables = {"attractors": _attractors_table(study, key)}
    if study.grids:
        columns = list(BASINS.names())
        if len(study.grids) > 1:  # the value that is varied: the speed last, another number first
            columns.insert(len(columns) if key == "rpm" else 0, key)
        tables["basins"] = Table(columns, lambda: _cell_blocks(study.grids, question.refine, key))
    if saddles:
        tables["saddles"] = Table.of_rows(SADDLES.names(key), lambda: _saddle_rows(study))
    return tables


def _attractors_table(study: Study, key: str) -> Table:
    """The attractors of each speed by their numbers, then the cells that belong to none.

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
        """The rows of attractors.csv, speed by speed."""
        for speed in study.speeds:
            for row in _attractor_rows(speed):
                yield (speed.value, *row) if varied else row

    return Table.of_rows(columns, rows)


def _attractor_rows(speed: Basins) -> Iterator[tuple]:
    """The rows of attractors.csv of one speed: attractors by their number, then what is none.

    Without the value that is varied, which comes first where it is not the speed. What belongs to
    no attractor has a number of 0 (undecided) or below (minus a status of the kernel).
    """
    order = sorted(range(len(speed.attractors)), key=lambda k: speed.branches[k])
    for k in order:
        attractor = speed.attractors[k]
        q, w = attractor.states[0]  # position, m, and rate, m/rad, at the strobe
        v = w * omega_of(speed.rpm)
        fraction, error = speed.fractions[k + 1]
        state = (float(q), float(v))
        named = (speed.branches[k], attractor.label)
        yield (*named, *state, fraction, error, speed.rpm, *_growth(speed, k))
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
    multipliers = speed.attractors[k].multipliers
    exponent = speed.exponents[k]
    if multipliers is None:
        return [None] * len(MULTIPLIERS) + [exponent]
    return [*multiplier_columns(multipliers), exponent]


def _saddle_rows(study: Study) -> Iterator[tuple]:
    """The rows of saddles.csv, by speed."""
    for speed in study.speeds:
        for saddle in speed.saddles or ():
            orbit = saddle.orbit
            q, w = orbit.states[0]  # position, m, and rate, m/rad, at the strobe
            state = (q, w * omega_of(speed.rpm))
            multipliers = multiplier_columns(orbit.multipliers)
            yield speed.value, orbit.label, *state, *multipliers, saddle.led, saddle.tried


def _cell_blocks(grids: Sequence[Basins], refine: int, key: str) -> Iterator[Block]:
    """The rows of basins.csv in blocks: speed by speed, row by row in v, then by q.

    Of a refined grid there are the cells that were not cut in four. key: what is varied; its value
    is a column where there are several grids.
    """
    for grid in grids:
        # Code k > 0 of a cell is the k-th attractor of its speed, which has a number that stays
        # from speed to speed; a code of 0 or below is its own number. Indices count from the end
        # where they are negative, so code - 1 finds both.
        codes_of_none = range(grid.codes.min(initial=0), 1)
        numbers_by_code = np.array([*grid.branches, *codes_of_none])
        for q, v, codes in _cells(grid, refine):
            numbers = numbers_by_code[np.asarray(codes, dtype=int) - 1]
            if len(grids) == 1:
                yield q, v, numbers
            elif key == "rpm":
                yield q, v, numbers, grid.value
            else:
                yield grid.value, q, v, numbers


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
    q_of_level = []  # the middles of the cells of each level
    v_of_level = []
    for level in range(refine + 1):
        side = 1 << (refine - level)  # finest cells along the side of a cell of this level
        of_level = window.with_cells(window.nq // side, window.nv // side)
        q_of_level.append(of_level.q_of(np.arange(of_level.nq)))
        v_of_level.append(of_level.v_of(np.arange(of_level.nv)))
    uncut = leaves(grid.level, refine)  # flat indices of their first corners in the finest grid
    for begin in range(0, len(uncut), ROWS_A_BLOCK):
        corners = uncut[begin : begin + ROWS_A_BLOCK]
        rows = corners // window.nq
        columns = corners % window.nq
        levels = grid.level[rows, columns]
        q = np.empty(len(corners))
        v = np.empty(len(corners))
        for level in range(refine + 1):
            here = levels == level
            q[here] = q_of_level[level][columns[here] >> (refine - level)]
            v[here] = v_of_level[level][rows[here] >> (refine - level)]
        yield q, v, grid.codes[rows, columns]


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
    median, percentile_99, most = speed.turns
    uncertainty = None
    if speed.uncertainty is not None:
        uncertainty = {
            "exponent": speed.uncertainty.exponent,
            "standard_error": speed.uncertainty.error,
            "boundary_dimension": speed.uncertainty.dimension,
            "error_share_count": speed.uncertainty.rows,
        }
    return {
        "value": speed.value,
        "rpm": speed.rpm,
        "attractors": [_attractor(speed, k) for k in range(len(speed.attractors))],
        "cells": speed.cells,
        "computed": speed.computed,
        "computed_share": speed.computed / speed.cells,
        "undecided": speed.undecided,
        "rests": [_rest(theta, end) for theta, end in speed.rests],
        "troubled": {status_name(code): cells for code, cells in speed.troubled.items()},
        "turns_per_cell": {"median": median, "percentile_99": percentile_99, "most": most},
        **speed.entropies,
        "saddles": [
            {"label": saddle.orbit.label, "led": saddle.led, "tried": saddle.tried}
            for saddle in speed.saddles or ()
        ],
        "uncertainty": uncertainty,
    }


def _rest(departure: float, end: After) -> dict[str, Any]:
    """The entry of run.json for a rest after which doubles could not follow the motion.

    departure: its phase, rad; end: where the motion ends that departs there.
    """
    ends_in_orbit = end.kind in (SETTLED, CYCLE)
    return {
        "departure_deg": degrees(departure),
        "ends": end.kind,
        "holds_for": end.holds_for,
        "label": Label(end.symbols) if ends_in_orbit else None,
    }


def _attractor(speed: Basins, k: int) -> dict[str, Any]:
    """The entry of run.json for an attractor, by its place in `speed.attractors`.

    Where a region about its points was proved to shrink its size is there too, else how many turns
    the motion has stayed in boxes that it had visited before. `branches` has the number that it
    keeps from speed to speed, `fractions` stand by the code of cells, which is k + 1.
    """
    attractor = speed.attractors[k]
    region = speed.regions[k]
    omega = omega_of(speed.rpm)
    fraction, error = speed.fractions[k + 1]
    record: dict[str, Any] = {
        "attractor": speed.branches[k],
        "label": attractor.label,
        "turns": attractor.turns or None,
        "states_q_m_v_m_per_s": [[q, w * omega] for q, w in attractor.states],
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
        "half_widths_q_m_v_m_per_s": [[dq, dw * omega] for dq, dw in region.half_widths().tolist()],
    }


# --- the command


SHOWN_SPEEDS = 3  # whose cells become a table


def _size(scene: Scene) -> Size:
    """Each cell of each speed is an orbit; a table of cells is written of a few speeds only.

    Bytes of memory and disk are measured, for each cell.
    """
    section = scene.basins
    nq, nv = section.cells
    cells = nq * nv
    orbits = cells * section.count
    memory = 70.0 * cells
    if section.refine:
        memory += 14.0 * cells * 4**section.refine + 20e6
    rows = orbits if section.count <= SHOWN_SPEEDS else 0
    return Size(
        what=plan.cells_of_a_window(nq, nv, section.refine),
        pieces=orbits,
        orbits=orbits,
        turns=0.0,
        rows=rows,
        memory=memory,
        tables=18.0 * rows,
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
