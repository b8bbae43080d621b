"""CSV text of basins: attractors, and a row per cell, written in pieces."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from camcli.analysis.basins.mapping import Basins
from camcli.analysis.basins.refine import leaves
from camcli.analysis.basins.study import Speed, Study
from camcli.analysis.sweep import status_name
from camcli.output.orbits import MULTIPLIERS
from camcli.output.tables import header, mixed_rows
from camcli.system import omega_of

ATTRACTORS = ("attractor", "label", "q_m", "v_m_per_s", "fraction", "standard_error", "rpm")
GROWTH = (*MULTIPLIERS, "lyapunov_per_period")
BASINS = ("q_m", "v_m_per_s", "attractor")
PIECE = 1 << 16  # rows


def attractors_csv(result: Study) -> Iterator[str]:
    """attractors.csv: by speed and number; what belongs to none has a code of 0 or less.

    With exponents asked for, multipliers of solved orbits and the largest exponent are appended.
    """
    asked = any(speed.exponents is not None for speed in result.speeds)
    yield header([*ATTRACTORS, *(GROWTH if asked else ())])
    for speed in result.speeds:
        yield from mixed_rows(_rows(speed))


def _rows(speed: Speed):
    order = sorted(range(len(speed.attractors)), key=lambda k: speed.branches[k])
    for k in order:
        attractor = speed.attractors[k]
        q, w = attractor.states[0]
        v = w * omega_of(speed.rpm)
        share = speed.fractions[k + 1]
        row = (speed.branches[k], attractor.label, float(q), float(v), *share, speed.rpm)
        yield (*row, *_growth(speed, k))
    for code, share in speed.fractions.items():
        if code <= 0:
            name = "undecided" if code == 0 else status_name(-code)
            yield (code, name, "", "", *share, speed.rpm, *_growth(speed, None))


def _growth(speed: Speed, k: int | None) -> list:
    """Multipliers and exponent of an attractor, empty where there are none."""
    if speed.exponents is None:
        return []
    if k is None:
        return [""] * len(GROWTH)
    pair, exponent = speed.attractors[k].multipliers, speed.exponents[k]
    numbers = [""] * 4 if pair is None else [x for z in pair for x in (z.real + 0.0, z.imag + 0.0)]
    return [*numbers, "" if exponent is None else exponent]


def basins_csv(grid: Basins, refine: int) -> Iterator[str]:
    """basins.csv: row by row in v, then q; of a refined grid the cells that were not cut."""
    yield header(BASINS)
    window = grid.window
    levels = [(1 << (refine - k)) for k in range(refine + 1)]  # cells along a side
    sizes = [window.with_cells(window.nq // side, window.nv // side) for side in levels]
    q_texts = [[repr(x) + "," for x in s.q_of(np.arange(s.nq)).tolist()] for s in sizes]
    v_texts = [[repr(x) + "," for x in s.v_of(np.arange(s.nv)).tolist()] for s in sizes]
    codes = {int(code): f"{code}\n" for code in np.unique(grid.codes)}
    if grid.level is None:
        for row, v in zip(grid.codes, v_texts[0], strict=True):
            cells = zip(q_texts[0], map(codes.__getitem__, row.tolist()), strict=True)
            yield "".join([q + v + code for q, code in cells])
        return
    found = leaves(grid.level, refine)
    for begin in range(0, len(found), PIECE):
        some = found[begin : begin + PIECE]
        rows, columns = some // window.nq, some % window.nq
        level = grid.level[rows, columns]
        shift = refine - level.astype(np.int64)
        columns_of = zip(
            level.tolist(),
            (columns >> shift).tolist(),
            (rows >> shift).tolist(),
            grid.codes[rows, columns].tolist(),
            strict=True,
        )
        yield "".join([q_texts[n][i] + v_texts[n][j] + codes[code] for n, i, j, code in columns_of])
