"""Basins in words: the table on stdout, and what run.json keeps."""

from __future__ import annotations

from typing import Any

from camcli.analysis.basins.mapping import Question
from camcli.analysis.basins.study import Speed, Study
from camcli.analysis.sweep import status_name
from camcli.cli.report import table
from camcli.system import omega_of

CRITERION = {
    "orbit": "a cell belongs to a periodic attractor when one whole period leads from ellipse to "
    "ellipse about its section points, with the attractor's impacts turn by turn, and the form of "
    "the ellipses shrinks by the factor given; to an aperiodic one when as many turns in a row as "
    "given lie in the boxes it visits; undecided when neither happens within the budget",
    "simple": "a cell goes to the cell that holds the image of its centre after one turn; the "
    "centre of the first cell of each cycle, and cells whose image leaves the window, are followed "
    "as orbits by the criterion of orbit mapping",
}
SHOWN = 40  # rows of the table on stdout


def show(result: Study, question: Question) -> None:
    """The table of attractors, and for one speed what else the grid says."""
    if len(result.speeds) > 1:
        _show_range(result)
        return
    (speed,) = result.speeds
    rows = []
    for k, (attractor, branch) in enumerate(zip(speed.attractors, speed.branches, strict=True)):
        q, w = attractor.states[0]
        rows.append(
            [_cut(attractor.label), str(branch), f"{q:.9g}", f"{w * omega_of(speed.rpm):.9g}"]
        )
        rows[-1].append(_share(speed.fractions[k + 1]))
    for code, share in speed.fractions.items():
        if code <= 0:
            rows.append([_name(code), str(code), "", "", _share(share)])
    title = f"{speed.rpm:.10g} rpm, {question.method} mapping"
    table(title, ["attractor", "no.", "q (m)", "v (m/s)", "fraction"], rows)
    for line in _lines(speed, question):
        print(line)


def _lines(speed: Speed, question: Question) -> list[str]:
    entropies, doubt = speed.entropies, speed.uncertainty
    median, most99, most = speed.turns
    lines = [
        f"cells {speed.cells}, computed {speed.computed} "
        f"({100.0 * speed.computed / speed.cells:.3g} %); turns per cell: median {median}, 99 % "
        f"{most99}, most {most}",
        f"basin entropy {entropies['basin_entropy']:.4g}, boundary entropy "
        f"{entropies['boundary_entropy']:.4g} ({entropies['boundary_boxes']} of "
        f"{entropies['boxes']} boxes of 5 x 5 cells)",
    ]
    if doubt is not None:
        lines.append(
            f"uncertainty exponent {doubt.exponent:.3f} +- {doubt.error:.3f}, "
            f"boundary dimension {doubt.dimension:.3f}"
        )
    return lines


def _show_range(result: Study) -> None:
    rows = []
    for speed in result.speeds:
        pairs = zip(speed.branches, speed.attractors, strict=True)
        words = [
            f"{branch}: {_cut(attractor.label)} {100.0 * speed.fractions[k + 1][0]:.3g} %"
            for k, (branch, attractor) in enumerate(pairs)
        ]
        rows.append([f"{speed.rpm:.10g}", ", ".join(words), str(speed.undecided)])
    title = f"{len(rows)} speeds"
    if len(rows) > SHOWN:
        title += f", the first {SHOWN} (all of them in attractors.csv)"
    table(title, ["rpm", "attractors and their fractions", "undecided cells"], rows[:SHOWN])


def summary(result: Study, question: Question) -> dict[str, Any]:
    """What run.json keeps beside the tables."""
    return {
        "method": question.method,
        "criterion": CRITERION[question.method],
        "budget_turns": question.budget,
        "speeds": [_record(speed, question) for speed in result.speeds],
    }


def _record(speed: Speed, question: Question) -> dict[str, Any]:
    doubt = speed.uncertainty
    return {
        "rpm": speed.rpm,
        "attractors": [_attractor(speed, k) for k in range(len(speed.attractors))],
        "cells": speed.cells,
        "computed": speed.computed,
        "computed_share": speed.computed / speed.cells,
        "undecided": speed.undecided,
        "troubled": {status_name(code): cells for code, cells in speed.troubled.items()},
        "turns_per_cell": dict(zip(("median", "percentile_99", "most"), speed.turns, strict=True)),
        **speed.entropies,
        "uncertainty": None if doubt is None else {
            "exponent": doubt.exponent,
            "standard_error": doubt.error,
            "boundary_dimension": doubt.dimension,
            "error_share_count": [list(row) for row in doubt.rows],
        },
    }  # fmt: skip


def _attractor(speed: Speed, k: int) -> dict[str, Any]:
    attractor, region = speed.attractors[k], speed.regions[k]
    fraction, error = speed.fractions[k + 1]
    found: dict[str, Any] = {
        "attractor": speed.branches[k],
        "label": attractor.label,
        "turns": attractor.turns or None,
        "states_q_m_v_m_per_s": [[q, w * omega_of(speed.rpm)] for q, w in attractor.states],
        "multipliers": [[z.real, z.imag] for z in map(complex, attractor.multipliers or ())],
        "fraction": fraction,
        "standard_error": error,
    }
    if region is None:
        return {**found, "turns_in_boxes": speed.stays[k]}
    return {
        **found,
        "ellipse_radius_over_size": region.radius,
        "form_shrinks_by": region.shrink,
        "ring_of_starts_returns": region.returns,
        "half_widths_q_m_v_m_per_s": [
            [dq, dw * omega_of(speed.rpm)] for dq, dw in region.half_widths().tolist()
        ],
    }


def undecided_words(result: Study, question: Question) -> str:
    """A note on cells that stayed undecided, '' where none did."""
    cells = sum(speed.undecided for speed in result.speeds)
    if not cells:
        return ""
    total = sum(speed.cells for speed in result.speeds)
    return (
        f"undecided: {cells} of {total} cells met no attractor within {question.budget} turns; "
        "raise basins.budget, or the motion is a long transient or has no attractor"
    )


def _share(share: tuple[float, float]) -> str:
    return f"{100.0 * share[0]:.4f} +- {100.0 * share[1]:.4f} %"


def _cut(label: str, longest: int = 30) -> str:
    return label if len(label) <= longest else label[: longest - 4] + "...)"


def _name(code: int) -> str:
    return "undecided" if code == 0 else status_name(-code)
