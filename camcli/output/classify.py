"""CSV text of classified motions and of the corner impacts behind their changes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from camcli.analysis.classify import Motion
from camcli.analysis.orbits.locate import CORNER
from camcli.analysis.orbits.study import Bifurcation
from camcli.analysis.sweep import status_name
from camcli.output.orbits import BIFURCATIONS, bifurcation_row
from camcli.output.tables import header, mixed_rows

CLASSIFY = (
    "rpm", "label", "period", "impacts", "chatter", "stable", "lyapunov_per_period", "status",
)  # fmt: skip


def classify_csv(motions: Iterable[Motion]) -> Iterator[str]:
    """classify.csv: a row per attractor found at a speed."""
    yield header(CLASSIFY)
    for m in motions:
        stable = "" if m.stable is None else int(m.stable)
        exponent = "" if m.exponents is None else m.exponents.largest
        row = [m.rpm, m.label, m.period, m.impacts, m.chatter, stable, exponent]
        yield from mixed_rows([[*row, status_name(m.status)]])


def corners_csv(found: Iterable[Bifurcation]) -> Iterator[str]:
    """corners.csv: corner impacts of the followed branches."""
    yield header(BIFURCATIONS)
    yield from mixed_rows(bifurcation_row(b, "rpm") for b in found if b.kind == CORNER)
