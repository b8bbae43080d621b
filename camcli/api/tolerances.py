"""Machines within the tolerances of their numbers: the speed to which each holds contact."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from random import Random
from statistics import median
from typing import Any

import numpy as np

from camcli.analysis.contact_loss.detachment import CriticalQuantity, first_loss
from camcli.analysis.contact_loss.hold import Hold, replaced
from camcli.analysis.contact_loss.spread import Spread
from camcli.analysis.contact_loss.study import ContactLoss
from camcli.api.lift_table import accel_errors
from camcli.api.machine import Machine, Varied
from camcli.api.result import Progress, ticks
from camcli.errors import Fault, SceneError
from camcli.output.tables import Table
from camcli.parallel import Codec, Work, stored
from camcli.piece_faults import PieceFault, attempt, gather
from camcli.quantities import Head, Quantity
from camcli.scene import Axis, resolved

FEWEST = 10  # machines from which shares of the variance are told
TABLE_ERROR = Quantity(
    "table_error", "", "error of the table", "share of the bound on the error of its c_thetatheta",
    "-1 to 1",
)  # fmt: skip
FIRST_LOSS = Quantity("first_detachment_rpm", "rpm", "first detachment", "speed to which it holds")
HELD = {
    spring: Quantity(f"{spring}_rpm", "rpm", "holds to", f"speed to which it holds with {words}")
    for spring, words in (
        (CriticalQuantity.HOLD_STIFFNESS, "the spring of another stiffness"),
        (CriticalQuantity.HOLD_PRELOAD, "the spring of another preload"),
        (CriticalQuantity.HOLD_BOTH, "the spring of both"),
    )
}
TOLERANCE = Head(
    "tolerance",
    "with detach.tolerance: the corners of the tolerances, then detach.machines machines in "
    "between, all equally likely",
    (Quantity("KEY", "", "number", "each number that may be off", varied=True), FIRST_LOSS),
    {"of a measured cam": (TABLE_ERROR,), "of the springs of detach.hold_to": tuple(HELD.values())},
)


@dataclass(frozen=True)
class _HoldSpeeds:
    """A function of one machine: the speeds (rpm) to which it holds, with each of some springs.

    machines: makes the machine of its numbers; springs: of the nominal machine.
    """

    machines: Varied
    springs: Sequence[Hold]

    def __call__(self, piece: Sequence[float]) -> list[float] | PieceFault:
        """The speeds of one machine, see `_speeds`, or the fault that has cost them."""
        numbers = ", ".join(f"{number:.10g}" for number in piece)
        keys = ", ".join(axis.key for axis in self.machines.axes)
        return attempt(f"the machine with {keys} = {numbers}", lambda: self._speeds(piece))

    def _speeds(self, piece: Sequence[float]) -> list[float]:
        """First losses of contact (rpm): of the machine as it is, then with each spring.

        piece: values of the axes, and at the end of a measured cam the share of its error, -1 to 1.
        A spring of the list was made for the nominal machine; a machine whose own spring is off by
        a factor gets it off by the same factor.
        """
        axes = len(self.machines.axes)
        system, _, _ = self.machines(*piece[:axes])
        share = piece[axes] if len(piece) > axes else 0.0
        errors = accel_errors(system.shape)
        nominal = self.machines.machine.system.follower
        follower = system.follower
        stiffness_off = follower.stiffness / nominal.stiffness if nominal.stiffness else 1.0
        preload_off = follower.preload / nominal.preload if nominal.preload else 1.0
        speeds = [first_loss(system, errors, share)]
        for hold in self.springs:
            stiffness = (hold.stiffness or 0.0) * stiffness_off
            preload = (hold.preload or 0.0) * preload_off
            with_spring = replaced(system, stiffness, preload)
            speeds.append(first_loss(with_spring, errors, share))
        return speeds


def tolerated(machine: Machine) -> Varied:
    """The machines within detach.tolerance; raises SceneError for a number that is not there."""
    axes = [
        _axis(machine, tolerance.key, tolerance.percent)
        for tolerance in machine.scene.detach.tolerance
    ]
    return Varied(machine, axes, "--tolerance")


def tolerances(
    machines: Varied, found: ContactLoss, work: Work, progress: Progress | None
) -> tuple[Table, dict[str, Any] | None, Spread | None]:
    """The table ``tolerance``, the chance and the worst case it shows, and what is drawn of it.

    The corners of the tolerances first, then machines in between, all equally likely; the n-th is
    always the same. A measured cam is off by a share of the bound on its error, from -1 to 1. The
    speeds of a machine that failed are empty.
    """
    section = machines.machine.scene.detach
    springs = [hold for hold in found.holds if hold.stiffness is not None]
    keys = [axis.key for axis in machines.axes]
    ranges = [(axis.start, axis.stop) for axis in machines.axes]
    if machines.machine.scene.cam.kind == "table":
        keys.append(TABLE_ERROR.column)
        ranges.append((-1.0, 1.0))

    # a piece: the numbers of one machine
    corners = list(product(*ranges))
    pieces = [*corners, *_drawn_between(ranges, section.machines)]
    speeds = _speeds_of_machines(_HoldSpeeds(machines, springs), pieces, work, progress)

    columns = [*keys, FIRST_LOSS.column, *(HELD[hold.quantity].column for hold in springs)]
    rows = [(*piece, *of_piece) for piece, of_piece in zip(pieces, speeds, strict=True)]
    table = Table.of_rows(columns, lambda: iter(rows))
    summary = _summary(speeds, len(corners), springs, section)
    if summary is None:
        return table, None, None

    middles = [0.5 * (low + high) for low, high in ranges]
    summary["worst"] = _percent_off(keys, pieces[_worst(speeds)], middles)

    # the corners are the worst cases: only the machines in between are equally likely
    likely_pieces = []
    likely_speeds = []
    for piece, of_piece in zip(pieces[len(corners) :], speeds[len(corners) :], strict=True):
        first_detachment = of_piece[0]
        if first_detachment is not None:
            likely_pieces.append(piece)
            likely_speeds.append(first_detachment)
    summary["shares"] = _shares(keys, likely_pieces, likely_speeds)
    spread = Spread(likely_speeds, summary["worst_rpm"], summary["worst"], summary["shares"])
    return table, summary, spread


def _drawn_between(ranges: Sequence[tuple[float, float]], count: int) -> list[tuple[float, ...]]:
    """So many machines, each number drawn from its range; the n-th machine is always the same."""
    generator = Random(0)
    return [
        tuple(generator.uniform(low, high) for low, high in ranges) for _machine in range(count)
    ]


def _speeds_of_machines(
    holds: _HoldSpeeds, pieces: Sequence[Sequence[float]], work: Work, progress: Progress | None
) -> list[list[float | None]]:
    """The speeds (rpm) to which each machine holds; None throughout for one that failed.

    pieces: the numbers of each machine, as `_HoldSpeeds` takes them. The faults are gathered.
    """
    how_many = 1 + len(holds.springs)
    codec = Codec(  # a file keeps a list of so many numbers; infinite: contact is never lost
        store=list,
        load=stored.items(stored.extended, how_many),
        faults=lambda row: [row] if isinstance(row, PieceFault) else [],
    )
    rows = work.collect(holds, pieces, codec, ticks(progress, "machines", len(pieces)))
    gather(row for row in rows if isinstance(row, PieceFault))
    speeds: list[list[float | None]] = []
    for row in rows:
        if isinstance(row, PieceFault):
            speeds.append([None] * how_many)
        else:
            speeds.append([float(rpm) for rpm in row])
    return speeds


def _worst(speeds: Sequence[Sequence[float | None]]) -> int:
    """The index of the machine that loses contact first; at least one is known."""
    first_losses = [(row[0], index) for index, row in enumerate(speeds) if row[0] is not None]
    _, index = min(first_losses)
    return index


def _percent_off(
    keys: Sequence[str], machine: Sequence[float], middles: Sequence[float]
) -> dict[str, float]:
    """By how many percent of its middle each number of a machine is off.

    The error of a measured cam is a share of its bound already.
    """
    percents = {}
    for key, value, middle in zip(keys, machine, middles, strict=True):
        share = value if key == TABLE_ERROR.column else value / middle - 1.0
        percents[key] = 100.0 * share
    return percents


def _shares(
    keys: Sequence[str], machines: Sequence[Sequence[float]], speeds: Sequence[float]
) -> dict[str, float]:
    """The share of the variance of the speeds that each number explains.

    The speed is fitted by a sum of straight lines, one for each number: rpm = a + sum b_k x_k, by
    least squares. The numbers are drawn independently, so that they explain b_k^2 var(x_k) each
    (squared standardised regression coefficients: A. Saltelli and others, Global Sensitivity
    Analysis: The Primer, 2008, section 1.2.5), and what the lines leave is the rest of the
    variance: the shares add up to 1 at most. Empty where the speeds do not vary, and of too few
    machines.
    """
    rpm = np.array(speeds, float)
    enough = len(rpm) >= max(FEWEST, 2 * len(keys))
    if not enough or not np.isfinite(rpm).all() or np.ptp(rpm) == 0.0:
        return {}
    rpm_off = rpm - rpm.mean()
    numbers_off = np.array(machines, float)
    numbers_off -= numbers_off.mean(axis=0)
    scatter = np.sqrt((numbers_off**2).sum(axis=0))
    standardised = numbers_off / np.where(scatter > 0.0, scatter, 1.0)
    slopes, *_ = np.linalg.lstsq(standardised, rpm_off, rcond=None)
    not_explained = rpm_off - standardised @ slopes
    explained = slopes**2
    variance = explained.sum() + (not_explained**2).sum()
    return dict(zip(keys, (explained / variance).tolist(), strict=True))


def _summary(
    rows: Sequence[Sequence[Any]], corners: int, springs: Sequence[Hold], section: Any
) -> dict[str, Any] | None:
    """Chance and worst case of the machines that are known; None where none in between is.

    rows: the speeds of each machine as `_HoldSpeeds` gives them. The first `corners` of them are
    corners of the tolerances, which count for the worst case but not for the chance.
    """
    known_between = [row for row in rows[corners:] if None not in row]
    if not known_between:
        return None
    known = [row for row in rows if None not in row]
    worst_rpm, *worst_with_springs = (min(column) for column in zip(*known, strict=True))
    first_losses, *with_springs = zip(*known_between, strict=True)
    asked_for = section.hold_to or 0.0
    of_springs = {}
    for hold, worst, speeds in zip(springs, worst_with_springs, with_springs, strict=True):
        holding = sum(rpm >= asked_for for rpm in speeds)
        of_springs[str(hold.quantity)] = {"worst_rpm": worst, "chance": holding / len(speeds)}
    return {
        "machines": section.machines,
        "worst_rpm": worst_rpm,
        "median_rpm": median(first_losses),
        "springs": of_springs,
    }


def _axis(machine: Machine, key: str, percent: float) -> Axis:
    """The range of a number of the machine that may be off by a percentage.

    Raises SceneError where the key names no number, or one that is zero.
    """
    value: Any = resolved(machine.scene)
    try:
        for name in key.split("."):
            value = value[name]
    except (LookupError, TypeError):
        value = None
        Varied(machine, [Axis(key=key, start=1.0, stop=1.0)], "--tolerance")  # names a close key
    if isinstance(value, bool) or not isinstance(value, int | float) or value == 0:
        expected = "expected a number of follower or cam that is not zero"
        if value is None:
            found = "the scene leaves it out"
            cure = f"write {key} into the scene, or leave it out here"
        else:
            found = "found a section" if isinstance(value, dict) else f"found {value!r}"
            cure = "e.g. follower.mass=5%"
        raise SceneError(Fault("--tolerance", key, found, expected, cure))
    share = abs(value) * percent / 100.0
    return Axis(key=key, start=value - share, stop=value + share, num=2)
