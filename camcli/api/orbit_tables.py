"""The tables of `cam orbits` that other commands read: how they are written, and read back."""

from __future__ import annotations

import csv
from array import array
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import chain, groupby
from math import degrees, isfinite, nan
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from camcli.api.rows import BIFURCATIONS, KIND, SIDES, bifurcation_row, multiplier_columns
from camcli.cams.files import decoded, read_bytes
from camcli.errors import Fault, SceneError, shown
from camcli.output.tables import Table
from camcli.quantities import (
    BRANCH,
    CORNER,
    FIRST,
    LABEL,
    MULTIPLIERS,
    PARAMETERS,
    PROVED,
    RPM,
    SECOND,
    STABLE,
    STATUS,
    THETA,
    U_MINUS,
    Head,
    Q,
    Quantity,
    V,
)
from camcli.system import CONSTANTS, omega_of

if TYPE_CHECKING:
    from camcli.analysis.chaos.section import Chaos
    from camcli.analysis.orbits.codim2 import CodimTwo
    from camcli.analysis.orbits.curve_proofs import CurveRange
    from camcli.analysis.orbits.curves import Curve, CurveLine, CurvePoint, Plane
    from camcli.analysis.orbits.orbit import PeriodicOrbit
    from camcli.analysis.orbits.proofs import Proof, Proofs
    from camcli.analysis.orbits.study import Bifurcation, Branch, OrbitsResult

MOST_BYTES = 200_000_000  # of a table that is drawn over the points
MOST_NUMBERS, MOST_LINES = 20_000_000, 5000  # of it
# of a file that is no table of ours
BAD_FILE = (csv.Error, ValueError, LookupError, StopIteration)


class ColumnMissingError(ValueError):
    """A table lacks a column; the text names it."""


Keys = Mapping[str, str]  # of what is varied by a key of the scene, the key by parameter
BRANCHES = Head(
    "branch",
    "the points of each branch in its order, or the orbits found at one speed",
    (
        BRANCH, LABEL, RPM, STABLE, Quantity("region", "", "region", "regions of its impacts"),
        THETA._replace(
            words="phase of each impact, or of each departure of an orbit that rests", numbered=True
        ),
        Q._replace(words="position at the strobe"), V._replace(words="velocity at the strobe"),
        *MULTIPLIERS,
        Quantity("trace", "", "trace", "trace of the monodromy matrix"),
        Quantity("det", "", "det", "its determinant"),
        U_MINUS._replace(words="incoming velocity of each impact", numbered=True),
        Quantity(
            "turns_round", "", "turns round", "whether the branch turns round here", "0 or 1"
        ),
        Quantity(
            "stable_from", "", "stable from",
            "lower end of the range of what is varied over which the branch stays stable here",
        ),
        Quantity("stable_to", "", "stable to", "its upper end; both empty at an unstable orbit"),
    ),
    {"with prove": (PROVED,)},
)  # fmt: skip
EVENTS = BIFURCATIONS._replace(
    more={
        "with prove": (
            PROVED,
            Quantity("enclosure_low", "", "from", "lower end of an enclosure of the parameter"),
            Quantity("enclosure_high", "", "to", "its upper end"),
        )
    }
)
ENCLOSURES = tuple(
    Quantity(f"KEY_{end}", "", end, f"{words} of an enclosure of the {which} number")
    for which in ("first", "second")
    for end, words in (("low", "lower end"), ("high", "upper end"))
)
PROVED_TO_NEXT = Quantity(
    "proved_to_next", "", "to next",
    "whether the curve is proved to have no gap from this point to the next; empty at its last "
    "one, and where that was not tried",
    "yes, no",
)  # fmt: skip
CURVE = Head(
    "curve",
    "with curve: a bifurcation in two parameters",
    (
        Quantity("curve", "", "curve", "number of the curve"), KIND, LABEL, CORNER, FIRST, SECOND,
        THETA._replace(words="phases of the impacts, between colons"), *SIDES,
    ),
    {"with prove": (PROVED, *ENCLOSURES, PROVED_TO_NEXT)},
)  # fmt: skip
CODIM2 = Head(
    "codim2",
    "with curve: the points at which two bifurcations meet, or one ends as nothing is lost there",
    (
        KIND, FIRST, SECOND,
        Quantity("KEY_error", "", "error", "how far off the first number may be", varied=True),
        Quantity("KEY_error", "", "error", "how far off the second number may be", varied=True),
        LABEL, CORNER._replace(words="corners that are met, between colons"),
        Quantity("curves", "", "curves", "numbers of the curves it lies on, between colons"),
        Quantity(
            "meets", "", "meets", "the two bifurcations, or one of a conservative orbit",
            "fold & corner-impact, ...",
        ),
        THETA._replace(words="phases of the impacts, between colons"), *MULTIPLIERS,
        Quantity("test_before", "", "before", "second test function on the curve before it"),
        Quantity("test_behind", "", "behind", "the same behind it, of the other sign"),
        STATUS._replace(entries="ok, unresolved"),
    ),
    {
        "with prove": (
            PROVED._replace(
                words="whether exactly one orbit is proved to fulfil both conditions within the "
                "enclosures; what unfolds there is not"
            ),
            *ENCLOSURES,
        )
    },
)  # fmt: skip
CHAOS = Head(
    "chaos",
    "with chaos: the boxes of impacts, parallelograms in the plane of phase and outgoing rate",
    (
        Quantity("box", "", "box", "number of the box; the first one lies about the orbit"),
        Quantity("region", "", "region", "region of the cam on which its impacts lie"),
        THETA._replace(words="phase of its middle"),
        Quantity(
            "u_plus_m_per_s", "m/s", "outgoing velocity", "outgoing relative velocity of its middle"
        ),
        Quantity(
            "along_theta_deg", "deg", "along", "from its middle to the end of it along which the "
            "impact map stretches",
        ),
        Quantity("along_u_plus_m_per_s", "m/s", "along", "the same, of the outgoing velocity"),
        Quantity(
            "across_theta_deg", "deg", "across", "from its middle to the side across which the "
            "impact map contracts",
        ),
        Quantity("across_u_plus_m_per_s", "m/s", "across", "the same, of the outgoing velocity"),
        Quantity("turns", "", "turns", "turns of the cam until its flights land"),
        Quantity("covers", "", "covers", "numbers of the boxes that it covers, between colons"),
        Quantity("cells", "", "cells", "cells on which that was shown"),
        PROVED,
    ),
)  # fmt: skip


# --- written


def _columns(parameter: str, keys: Keys) -> tuple[list[str], list[str]]:
    """(first, last): the column of the parameter, in one of the two lists; the other is empty.

    It comes first, under its key, where `vary` names the parameter, else last. Both are empty for
    the speed: each of these tables has a column rpm anyway.
    """
    if parameter == "rpm":
        return [], []
    if parameter in keys:
        return [keys[parameter]], []
    return [], [PARAMETERS[parameter].column]


class BranchPoint(NamedTuple):
    """What a row of branch.csv is made of.

    branch: its number, 0 without one; orbit: at this point; course: the last three columns, what
    the branch does there, see `_courses`.
    """

    branch: int
    orbit: PeriodicOrbit
    course: list


def branch_table(result: OrbitsResult, keys: Keys) -> Table:
    """The table `branch`: a row per point; of one speed only, a row per orbit found, branch 0."""
    first, last = _columns(result.question.parameter, keys)
    points: list[BranchPoint] = []
    if result.question.span is None:
        points = [BranchPoint(0, orbit, [None, None, None]) for orbit in result.orbits]
    for branch in result.branches:
        courses = _courses(branch, result.bifurcations)
        for orbit, course in zip(branch.points, courses, strict=True):
            points.append(BranchPoint(branch.number, orbit, course))
    most_impacts = max((len(point.orbit.theta) for point in points), default=1) or 1
    columns = [*first, *BRANCHES.names(impacts=most_impacts)]
    after_det = columns.index("det") + 1
    columns[after_det:after_det] = last
    if result.proofs is None:
        proved: list[list[str]] = [[] for _ in points]
    else:
        columns.append(PROVED.column)
        orbits = result.proofs.orbits if result.question.span is None else []
        proved = [[_yes(proof)] for proof in chain(orbits, *result.proofs.points)]

    def rows() -> Iterator[list]:
        """The rows of branch.csv."""
        for point, proved_cell in zip(points, proved, strict=True):
            value = point.orbit.value
            values_first = [value] * len(first)
            values_last = [value] * len(last)
            yield _branch_row(point, most_impacts, values_first, values_last) + proved_cell

    return Table.of_rows(columns, rows)


def _branch_row(point: BranchPoint, most: int, first: list[float], last: list[float]) -> list:
    """A row of branch.csv with room for `most` impacts.

    first, last: the value of the parameter at the place of its column; the other list is empty.
    """
    orbit = point.orbit
    omega = omega_of(orbit.rpm)
    q, w = orbit.states[0]  # position, m, and rate, m/rad, at the strobe
    thetas = [degrees(theta) for theta in orbit.theta]
    velocities = [rate * omega for rate in orbit.rates]
    no_thetas = [None] * (most - len(thetas))
    no_velocities = [None] * (most - len(velocities))  # those of a rest have no impact
    return [
        *first, point.branch, orbit.label, orbit.rpm, int(orbit.stable),
        ":".join(orbit.regions), *thetas, *no_thetas, q, w * omega,
        *multiplier_columns(orbit.multipliers), orbit.trace, orbit.det,
        *last, *velocities, *no_velocities, *point.course,
    ]  # fmt: skip


def _courses(branch: Branch, bifurcations: Sequence[Bifurcation]) -> list[list]:
    """[turns round, stable from, stable to] of each point of a branch.

    Turns round is 0 or 1; stable from and to are values of the parameter, None at an unstable
    orbit. bifurcations: of the whole study.
    """
    turning_points = set(branch.turning_points)
    courses: list[list] = []
    for point in branch.points:
        turns_round = int(point.value in turning_points)
        courses.append([turns_round, None, None])
    for indices, (stable_from, stable_to) in branch.stable_stretches(bifurcations):
        for k in indices:
            courses[k][1] = stable_from
            courses[k][2] = stable_to
    return courses


def _yes(proof: Proof) -> str:
    """Whether a proof holds, as a cell."""
    return "yes" if proof.proved else "no"


def bifurcations_table(result: OrbitsResult, keys: Keys) -> Table:
    """The table `bifurcations`: the events, a row each.

    A parameter that is not rpm has its own column of values and, at the end, of errors. Where there
    are proofs, each row ends with the proof and its enclosure of the parameter.
    """
    first, last = _columns(result.question.parameter, keys)
    parameters = [*first, *last]  # the column of the parameter, unless it is rpm
    errors = [f"{name}_error" for name in parameters]
    columns = [*first, *EVENTS.names(), *last, *errors]
    rows = []
    for event in result.bifurcations:
        row = bifurcation_row(event, result.question.parameter)
        if first:  # the row ends with value and error of the parameter, but its column comes first
            *others, value, error = row
            row = [value, *others, error]
        rows.append(row)
    if result.proofs is not None:
        columns += [quantity.column for quantity in EVENTS.more["with prove"]]
        parameter = columns.index(parameters[0] if parameters else "rpm")
        for row, proof in zip(rows, result.proofs.events, strict=True):
            if proof.proved and proof.low is not None and proof.high is not None:
                # the double may lie an ulp beside the enclosure: the row gets one within it
                row[parameter] = min(max(row[parameter], proof.low), proof.high)
            row += [_yes(proof), proof.low, proof.high]
    return Table.of_rows(columns, lambda: rows)


def curve_table(
    curves: Sequence[Curve],
    plane: Plane,
    keys: Keys,
    proofs: Proofs | None = None,
    ranges: Sequence[CurveRange] | None = None,
) -> Table:
    """Bifurcations in two parameters, a row per point of each curve.

    A point of a smooth kind has no sides: the orbit's own trace and determinant stand for both.
    With proofs each row has its own: the number that was solved for is enclosed, the other one is
    the double that it is. With ranges, the parts of the curves that were tried to be proved, it
    ends with whether the part to the next point is.
    """
    columns_of_plane = _columns_of_plane(plane, keys)

    def rows() -> Iterator[tuple]:
        """The rows of curve.csv, curve by curve."""
        for number, curve in enumerate(curves, 1):
            parts = proved_parts(ranges or (), number, len(curve.points))
            to_next = ["yes" if part else "no" for part in parts]
            for k, point in enumerate(curve.points):
                values = [point.first, point.second]
                proof_cells: list[Any] = []
                if proofs is not None:
                    proof = proofs.curves[number - 1][k]
                    proof_cells = _curve_proof_cells(proof, _solved_for(point, plane), values)
                if ranges is not None:
                    proof_cells.append(to_next[k] if k < len(to_next) else None)
                orbit_sides = (point.orbit.trace, point.orbit.det)
                yield (
                    number,
                    curve.kind,
                    curve.label,
                    curve.corner,
                    *values,
                    ":".join(repr(degrees(theta)) for theta in point.orbit.theta),
                    *(point.left or orbit_sides),
                    *(point.right or orbit_sides),
                    *proof_cells,
                )

    columns = [*CURVE.names(*columns_of_plane)]
    if proofs is not None:
        columns += _enclosure_columns(*columns_of_plane)
    if ranges is not None:
        columns.append(PROVED_TO_NEXT.column)
    return Table.of_rows(columns, rows)


def _columns_of_plane(plane: Plane, keys: Keys) -> tuple[str, str]:
    """The columns of the two numbers of a plane: the key of the scene where `vary` names one."""
    first, second = plane.names
    return (
        keys[first] if first in keys else PARAMETERS[first].column,
        keys[second] if second in keys else PARAMETERS[second].column,
    )


def proved_parts(ranges: Sequence[CurveRange], number: int, points: int) -> list[bool]:
    """Whether a curve of so many points is proved from each to the next; empty where not tried.

    ranges: the parts of all curves that were tried to be proved, each from its first to its last
    point, counted from 1; number: of the curve.
    """
    of_curve = [part for part in ranges if part.curve == number]
    proved = [False] * (points - 1) if of_curve else []
    for part in of_curve:
        if part.failed_step is None:
            for k in range(part.first, part.last):
                proved[k - 1] = True
    return proved


def _enclosure_columns(first: str, second: str) -> list[str]:
    """The columns of a proof in two numbers, whose own columns are `first` and `second`."""
    return [PROVED.column, f"{first}_low", f"{first}_high", f"{second}_low", f"{second}_high"]


def _solved_for(point: CurvePoint, plane: Plane) -> int:
    """Which number of the plane, 0 or 1, was solved for at a point of a curve.

    Its root knows the place of that number in the kernel's table of a machine: the speed and the
    constants of the follower come first, the numbers of the cam that vary behind them.
    """
    root = point.orbit.root
    assert root is not None
    if root.parameter < CONSTANTS:
        name = list(PARAMETERS)[root.parameter]
    else:
        of_cam = [name for name in plane.names if name not in PARAMETERS]
        name = of_cam[root.parameter - CONSTANTS]
    return plane.names.index(name)


def _curve_proof_cells(proof: Proof, free: int, values: list[float]) -> list[Any]:
    """Whether a point of a curve is proved, and the ends of both enclosures.

    values: of both numbers. The one that was solved for has the index `free`: it may lie an ulp
    beside its enclosure, and is put into it, in `values`. The other one is that double exactly.
    """
    if not proof.proved or proof.low is None or proof.high is None:
        return ["no", None, None, None, None]
    enclosures = [(value, value) for value in values]
    enclosures[free] = (proof.low, proof.high)
    values[free] = min(max(values[free], proof.low), proof.high)
    first, second = enclosures
    return ["yes", *first, *second]


def chaos_table(chaos: Chaos, names: Mapping[int, str]) -> Table:
    """The boxes of impacts, a row each; names: of the regions, by stretch of the cam."""
    omega = omega_of(chaos.rpm)

    def rows() -> Iterator[tuple]:
        """The rows of chaos.csv."""
        for number, box in enumerate(chaos.boxes):
            middle_theta, middle_rate = box.middle  # rad and m/rad, as the axes
            (along_theta, across_theta), (along_rate, across_rate) = box.axes
            covered = [str(other + 1) for one, other in chaos.coverings if one == number]
            yield (
                number + 1,
                names[box.stretch],
                degrees(middle_theta),
                middle_rate * omega,
                degrees(along_theta),
                along_rate * omega,
                degrees(across_theta),
                across_rate * omega,
                box.lands.turn,
                ":".join(covered),
                box.cells[0] * box.cells[1],
                "yes" if chaos.proved else "no",
            )

    return Table.of_rows(CHAOS.names(), rows)


def codim2_table(
    points: Sequence[CodimTwo], plane: Plane, keys: Keys, proved: bool = False
) -> Table:
    """The points of codimension two, a row each; proved: with their proofs."""

    def row(point: CodimTwo) -> tuple:
        """A row of codim2.csv."""
        orbit = point.orbit
        return (
            point.kind,
            point.first,
            point.second,
            *point.errors,
            point.label,
            ":".join(point.corners),
            ":".join(str(number) for number in point.curves),
            " & ".join(point.meets),
            ":".join(repr(degrees(theta)) for theta in orbit.theta),
            *multiplier_columns(orbit.multipliers),
            point.before,
            point.behind,
            point.status,
            *(_proof_cells(point) if proved else ()),
        )

    first, second = _columns_of_plane(plane, keys)
    columns = [*CODIM2.names(first, second, f"{first}_error", f"{second}_error")]
    if proved:
        columns += _enclosure_columns(first, second)
    return Table.of_rows(columns, lambda: map(row, points))


def _proof_cells(point: CodimTwo) -> list:
    """Whether a point is proved, and the ends of both enclosures; empty where not tried."""
    if point.proof is None:
        return [None] * 5
    if not point.proof.proved:
        return ["no", None, None, None, None]
    return ["yes", *(point.proof.first or ()), *(point.proof.second or ())]


# --- read


class BranchColumns(NamedTuple):
    """A solved branch: values, stability, phases of every impact (deg), q at the strobe (m)."""

    values: array[float]
    stable: list[bool]
    phases: list[array[float]]
    q: array[float]


def read_branches(
    path: str | PathLike, key: str, most_numbers: int = MOST_NUMBERS
) -> list[BranchColumns]:
    """The branches of a branch.csv of `orbits` along a key of a scene.

    A table of somebody else needs the key, stable (1 or 0), theta_deg or theta_deg_1, ... and q_m;
    branch tells its lines apart, without it they are one. Raises SceneError where the file is none,
    lacks a column, is in another parameter, or has more than `most_numbers` values, phases and q.
    """
    with _orbits_file("--branches", path, "branch.csv", [key], "see cam orbits") as table:
        header = table.header
        value_at = table.places[0]
        stable_at = _column(header, STABLE.column)
        q_at = _column(header, Q.column)
        branch_at = header.index(BRANCH.column) if BRANCH.column in header else None
        phases_at = [k for k, name in enumerate(header) if name.startswith(f"{THETA.column}_")]
        if not phases_at:
            phases_at = [_column(header, THETA.column)]

        def branch_of(row: list[str]) -> str:
            """The number of the branch of a row, as its text."""
            return "" if branch_at is None else row[branch_at]

        branches: list[BranchColumns] = []
        count = 0
        for _, rows in groupby(table.rows, branch_of):
            branch = BranchColumns(array("d"), [], [array("d") for _ in phases_at], array("d"))
            for row in rows:
                branch.values.append(_finite(row[value_at]))
                branch.stable.append(row[stable_at] == "1")
                branch.q.append(_finite(row[q_at]))
                for phases, place in zip(branch.phases, phases_at, strict=True):
                    phases.append(_finite(row[place]) if row[place] else nan)
                count += 1
                _refuse_many(count * (len(phases_at) + 2), len(branches), most_numbers)
            branches.append(branch)
        different_values = {value for branch in branches for value in branch.values}
        if len(different_values) == 1 < count:
            raise ValueError("solved along another parameter")
        return branches


def read_curves(
    path: str | PathLike, keys: tuple[str, str], most_numbers: int = MOST_NUMBERS
) -> list[CurveLine]:
    """Every curve in a curve.csv of `orbits`, along two keys of a scene.

    Raises SceneError where the file is none, is in other parameters, or has more than
    `most_numbers` of these.
    """
    cure = "see cam orbits --curve, or give auto"
    with _orbits_file("--curves", path, "curve.csv", keys, cure) as table:
        from camcli.analysis.orbits.curves import CurveLine

        header = table.header
        first_at, second_at = table.places
        curve_at = _column(header, "curve")
        kind_at = _column(header, "kind")

        optional = ("label", "corner", PROVED_TO_NEXT.column)
        place_of = {name: header.index(name) for name in optional if name in header}

        def cell(row: list[str], column: str) -> str:
            """The entry of an optional column; empty where the table does not have it."""
            return row[place_of[column]] if column in place_of else ""

        def curve_of(row: list[str]) -> tuple[str, str, str, str]:
            """(number, kind, label, corner) of the curve of a row."""
            return row[curve_at], row[kind_at], cell(row, "label"), cell(row, "corner")

        curves: list[CurveLine] = []
        count = 0
        for (_, kind, label, corner), rows in groupby(table.rows, curve_of):
            first = array("d")
            second = array("d")
            proved: list[bool] = []  # from each point to the next
            for row in rows:
                first.append(_finite(row[first_at]))
                second.append(_finite(row[second_at]))
                proved.append(cell(row, PROVED_TO_NEXT.column) == "yes")
                count += 1
                _refuse_many(2 * count, len(curves), most_numbers)
            curves.append(CurveLine(kind, label, corner, first, second, proved[:-1]))
        return curves


def _finite(text: str) -> float:
    """A number of a table; raises ValueError where it is none, or not finite."""
    number = float(text)
    if not isfinite(number):
        raise ValueError(f"found {text}")
    return number


def _refuse_many(numbers: int, lines: int, most_numbers: int) -> None:
    """Raise ValueError for more numbers, in so many lines, than can be drawn over a picture."""
    if numbers > most_numbers or lines >= MOST_LINES:
        raise ValueError(f"more than {MOST_LINES} lines, or {most_numbers} numbers in them")


def _place_of(key: str, header: list[str]) -> int:
    """The number of the first column that holds a key of a scene.

    It is called as the key, as the key's last name, or as that name with a unit behind it.
    """
    name = key.rpartition(".")[2]
    for k, column in enumerate(header):
        if column in (key, name) or column.startswith(f"{name}_"):
            return k
    raise ColumnMissingError(f"found no column {key}")


def _column(header: list[str], name: str) -> int:
    """The place of a column; raises ColumnMissingError where there is none."""
    if name not in header:
        raise ColumnMissingError(f"found no column {name}")
    return header.index(name)


class OpenTable(NamedTuple):
    """A table that is being read: its header, its rows one at a time, and some of its columns.

    places: of the columns of the keys that were asked for, in their order.
    """

    header: list[str]
    rows: Iterator[list[str]]
    places: list[int]


@contextmanager
def _orbits_file(
    option: str, path: str | PathLike, what: str, keys: Sequence[str], cure: str
) -> Iterator[OpenTable]:
    """Open a table of `orbits` that was given with an option.

    what: the usual name of such a table; keys: of a scene, what varies in it. For the column of a
    key see `_place_of`. Raises SceneError where the file is no such table, or where the block finds
    that it is none: with the option, what was expected, and the cure.
    """
    expected = f"expected a {what} in {' and '.join(keys)}"
    text = decoded(read_bytes(Path(path), str(path), MOST_BYTES, expected, cure), str(path))
    rows = csv.reader(text.splitlines())
    try:
        header = next(rows)
        yield OpenTable(header, rows, [_place_of(key, header) for key in keys])
    except BAD_FILE as error:
        found = f"found no such table ({shown(str(error), 100) or 'nothing in it'})"
        if isinstance(error, ColumnMissingError):
            found = str(error)
        where = f"{path}:{rows.line_num}"
        raise SceneError(Fault(option, where, found, expected, cure)) from None
