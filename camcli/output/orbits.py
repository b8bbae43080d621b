"""CSV text of periodic orbits: branches, bifurcations, curves in two parameters."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi

from camcli.analysis.orbits.curves import Curve
from camcli.analysis.orbits.locate import CORNER, GRAZING
from camcli.analysis.orbits.orbit import PeriodicOrbit
from camcli.analysis.orbits.study import Bifurcation, OrbitsResult
from camcli.output.tables import header, mixed_rows
from camcli.system import omega_of

DEG = 180.0 / pi
MULTIPLIERS = ("multiplier_1_re", "multiplier_1_im", "multiplier_2_re", "multiplier_2_im")
UNITS = {
    "mass": "mass_kg",
    "stiffness": "stiffness_n_per_m",
    "damping": "damping_n_s_per_m",
    "gravity": "gravity_m_per_s2",
    "preload": "preload_n",
    "restitution": "restitution",
}
BIFURCATIONS = (
    "branch", "label", "kind", "rpm", "rpm_error", "corner", "trace_left", "det_left",
    "trace_right", "det_right", "classification",
)  # fmt: skip


def branch_csv(study: OrbitsResult) -> Iterator[str]:
    """branch.csv: a row per point; of one speed only, a row per orbit found, branch 0."""
    other = study.question.parameter
    rows = [(0, orbit) for orbit in study.orbits] if study.question.span is None else []
    rows += [(branch.number, orbit) for branch in study.branches for orbit in branch.points]
    most = max((len(orbit.theta) for _, orbit in rows), default=1)
    thetas = [f"theta_deg_{k}" for k in range(1, max(most, 1) + 1)]
    columns = [
        "branch", "label", "rpm", "stable", "region", *thetas, "q_m", "v_m_per_s", *MULTIPLIERS,
        "trace", "det",
    ]  # fmt: skip
    yield header([*columns, *([UNITS[other]] if other != "rpm" else [])])
    yield from mixed_rows(_point(number, orbit, len(thetas), other) for number, orbit in rows)


def _point(number: int, orbit: PeriodicOrbit, most: int, parameter: str) -> list:
    q, w = orbit.states[0]
    thetas = [theta * DEG for theta in orbit.theta]
    return [
        number, orbit.label, orbit.rpm, int(orbit.stable), ":".join(orbit.regions),
        *thetas, *[""] * (most - len(thetas)), q, w * omega_of(orbit.rpm),
        *(part for z in orbit.multipliers for part in (z.real + 0.0, z.imag + 0.0)),
        orbit.trace, orbit.det, *([orbit.value] if parameter != "rpm" else []),
    ]  # fmt: skip


def bifurcations_csv(study: OrbitsResult) -> Iterator[str]:
    """bifurcations.csv; another parameter than rpm appends its value and error."""
    other = study.question.parameter
    more = [UNITS[other], f"{UNITS[other]}_error"] if other != "rpm" else []
    yield header([*BIFURCATIONS, *more])
    yield from mixed_rows(bifurcation_row(b, other) for b in study.bifurcations)


def bifurcation_row(b: Bifurcation, parameter: str) -> list:
    """A row of bifurcations.csv, with value and error of another parameter at the end."""
    error = b.error if parameter == "rpm" else 0.0
    row = [b.branch, b.label, b.kind, b.orbit.rpm, error, b.corner, *_sides(b)]
    return [*row, b.classification, *([b.value, b.error] if parameter != "rpm" else [])]


def _sides(b: Bifurcation) -> list:
    """One-sided traces and determinants; of a smooth event both sides are the same."""
    if b.kind == CORNER and b.left is not None and b.right is not None:
        return [b.left.trace, b.left.det, b.right.trace, b.right.det]
    own = [b.orbit.trace, b.orbit.det]
    return [*own, "", ""] if b.kind in (GRAZING, CORNER) or b.orbit.resting else [*own, *own]


def curve_csv(curves: list[Curve], second: str) -> Iterator[str]:
    """curve.csv: a bifurcation in two parameters, a row per point."""
    yield header(
        ["curve", "kind", "label", "corner", "rpm", UNITS[second], "theta_deg", "trace_left",
         "det_left", "trace_right", "det_right"]
    )  # fmt: skip
    for number, curve in enumerate(curves, 1):
        for point in curve.points:
            own = (point.orbit.trace, point.orbit.det)
            left, right = point.left or own, point.right or own
            theta = ":".join(repr(x * DEG) for x in point.orbit.theta)
            row = [number, curve.kind, curve.label, curve.corner, point.first, point.second]
            yield from mixed_rows([[*row, theta, *left, *right]])
