"""Chaos sought and proved at one speed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import islice
from math import log10, ulp
from typing import Any

import numpy as np
from flint import arb, ctx

from camcli.analysis.chaos.covering import BITS, proved
from camcli.analysis.chaos.homoclinic import ImpactMap, candidates, saddle_of
from camcli.analysis.chaos.section import Chaos, ChaosView, SectionBox
from camcli.analysis.chaos.statement import statement
from camcli.analysis.integrate import BudgetSpentError, Settings
from camcli.analysis.orbits.orbit import PeriodicOrbit
from camcli.cams.balls import precision
from camcli.exact.shooting import ProofStep
from camcli.system import System

SIDE = 33  # points along a side of a box that is drawn
TRIED = 60  # sets of boxes about one saddle that are given to the proof


def chaos_at(
    system: System, settings: Settings, orbits: Sequence[PeriodicOrbit], rpm: float, known: bool
) -> tuple[Chaos, dict[str, Any] | None]:
    """(chaos, its statement): about the first of the orbits at a speed where it can be proved.

    The proof is for every speed that rounds to rpm. known: whether a certificate can have the cam.
    Without a proof the step that failed last is told, and there is no statement.
    """
    last = Chaos(rpm, step=ProofStep.NO_CHAIN)
    if not known:
        return replace(last, step=ProofStep.CAM), None
    try:
        impact_map = ImpactMap(system, rpm, settings)
        saddles = [saddle_of(impact_map, orbit) for orbit in orbits]
        for saddle in saddles:
            if saddle is None:
                continue
            for boxes in islice(candidates(impact_map, saddle), TRIED):
                last, chaos_statement = _proved(system, boxes)
                if last.proved:
                    return last, chaos_statement
    except BudgetSpentError:
        last = replace(last, step=ProofStep.WORK_BUDGET)
    return last, None


def view_of(system: System, settings: Settings, chaos: Chaos) -> ChaosView:
    """What a picture of chaos shows: simulated impacts, the boxes' outlines and their images.

    An outline that does not land on one stretch stands in the place of its image.
    """
    impact_map = ImpactMap(system, chaos.rpm, settings)
    outlines = []
    images = []
    for box in chaos.boxes:
        outline = _outline(box)
        landed = impact_map.image(outline)
        outlines.append(outline)
        images.append(outline if landed is None else landed.points)
    return ChaosView(impact_map.simulated(), tuple(outlines), tuple(images))


def _outline(box: SectionBox) -> np.ndarray:
    """Points (theta, v) along the four sides of a box, shape (2, n), closed."""
    way = np.linspace(-1.0, 1.0, SIDE)
    ones = np.ones(SIDE)
    x = np.concatenate([way, ones, way[::-1], -ones])
    y = np.concatenate([-ones, way, ones, way[::-1]])
    return np.array(box.middle)[:, None] + box.matrix @ np.array([x, y])


def _proved(system: System, boxes: Chaos) -> tuple[Chaos, dict[str, Any] | None]:
    """Boxes with their proof, and the statement where they have one."""
    with precision(int(BITS * log10(2.0))):
        ctx.prec = BITS
        half_digit = arb(ulp(boxes.rpm)) / 2
        low = arb(boxes.rpm) - half_digit
        high = arb(boxes.rpm) + half_digit
        chaos = proved(boxes, system.shape, system.follower, low.union(high))
        chaos = replace(chaos, flank_excess=getattr(system.shape, "flank_excess", 0.0))
        if not chaos.proved:
            return chaos, None
        return chaos, statement(chaos, system.follower, low, high)
