"""A small case of every entry, run in plain Python and compiled: machine code is believed after it.

The cam is three parabolas, so it needs no solver: c_thetatheta is +BEND, -BEND and +BEND, each on a
stretch of its own. The follower lands, bounces, chatters to rest and leaves again.

A function of an entry's name returns the entry's arguments in this case, in their order.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

from camcli.kernel.bordered import tables_for
from camcli.kernel.cam_table import ORDERS, PIECE, TERMS, TURN, Cam, Stretch
from camcli.kernel.cells import Cells, Point, Progress, Rest, Room, Targets
from camcli.kernel.contact_search import Tally
from camcli.kernel.enclosed_landing import COLUMNS
from camcli.kernel.flight import BOUNCED, FREE
from camcli.kernel.flow import RPM, Constants, Flow, constants_of
from camcli.kernel.follow import Run
from camcli.kernel.forms import PLAIN, Kernel
from camcli.kernel.loads import Loads
from camcli.kernel.marks import ENTRIES
from camcli.kernel.orbit_loop import CHATTER, DETACHMENT, IMPACT, NEVER, Earlier, Log, State
from camcli.kernel.shooting import Border, correct_orbit
from camcli.kernel.variational import Growth, Pair

ARRAYS = replace(PLAIN, compiled=True)  # tables as machine code takes them, filled by Python
MACHINE = (250.0, 1.25, 200.0, 2.0, 9.81, 3.0, 0.5, 0.4)  # rpm, SI; a chatter in each turn
FAST = (400.0, *MACHINE[1:])  # with an orbit of one impact in each turn, near ORBIT
ORBIT = [2.52, 0.136]  # its phase (rad) and rate after it (m/rad), in stretch ORBIT_STRETCH
ORBIT_STRETCH = 1
BASE, BEND = 0.125, 0.125  # m, m/rad^2
STRETCHES = 3
TOLERANCE, IMPACTS = 1e-6, 1000  # of a chatter, rad; most in a turn
EVENTS = [  # kind, period, theta, u; about those of a simulation of MACHINE
    (IMPACT, 0, 0.19, -0.07),
    (IMPACT, 0, 0.58, -0.035),
    (CHATTER, 0, 0.96, 0.0),
    (DETACHMENT, 0, 1.5707963267948966, 0.0),
    (IMPACT, 0, 5.67, -0.14),
    (IMPACT, 1, 0.19, -0.07),
]


def case_of(name: str, kernel: Kernel = ARRAYS) -> tuple:
    """The arguments of an entry in its case; they are fresh, as an entry writes into them."""
    return CASES[name](kernel)


def is_right(name: str, call: Callable) -> bool:
    """Whether compiled code leaves the bits in its case that plain Python leaves.

    name: of an entry; call: its compiled form. What it returns is compared, and all that its
    arguments hold afterwards.
    """
    for_python = case_of(name, PLAIN)
    for_code = case_of(name)
    expected = [ENTRIES[name](*for_python) or 0, *_numbers(for_python)]
    left = [call(*for_code) or 0, *_numbers(for_code)]
    if len(left) != len(expected):
        return False
    # a list of floats may hold an int where an array holds a float
    kinds = [type(number) for number in left]
    expected = [kind(number) for kind, number in zip(kinds, expected, strict=True)]
    return _bits(left) == _bits(expected)


def _bits(numbers: list) -> bytes:
    """Floats and ints, 8 bytes each; NaNs and zeros of either sign are told apart."""
    letters = "".join("d" if isinstance(number, float) else "q" for number in numbers)
    return struct.pack("=" + letters, *numbers)


def _numbers(value: Any) -> Iterator[float]:
    """All numbers of an entry's arguments, in order, as Python's own.

    An argument is a number, an array or list of numbers, a row (a class of numbers), or a tuple or
    list of such.
    """
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, int | float):
        yield value
        return
    if not isinstance(value, tuple | list):  # a row
        value = [getattr(value, field) for field in type(value).__annotations__]
    for entry in value:
        yield from _numbers(entry)


def _cam(kernel: Kernel) -> Cam:
    """Three parabolas that join with their slopes, from 0 to 2 pi; the second one in two pieces."""
    quarter = TURN / 4.0
    pieces: list[float] = []
    stretches: list[Stretch] = []
    c = BASE
    slope = 0.0
    for start, width, count, accel in (
        (0.0, quarter, 1, BEND),
        (quarter, 2.0 * quarter, 2, -BEND),
        (3.0 * quarter, quarter, 1, BEND),
    ):
        first_piece = len(pieces) // PIECE
        half = 0.5 * width / count
        center = start + half
        end_c = c
        end_slope = slope
        for _ in range(count):
            middle_c = end_c + half * (end_slope + 0.5 * accel * half)
            middle_slope = end_slope + accel * half
            pieces += _parabola(center, middle_c, middle_slope, accel)
            center += 2.0 * half
            end_c = middle_c + half * (middle_slope + 0.5 * accel * half)
            end_slope = middle_slope + accel * half
        stretches.append(
            Stretch(
                start=start, end=start + width, first_piece=first_piece, piece_count=count,
                per_angle=count / width, start_c=c, start_c1=slope, start_c2=accel,
                end_c=end_c, end_c1=end_slope, end_c2=accel, slope_jump=0.0,
                accel_min=accel, accel_max=accel, jerk_max=0.0, snap_max=0.0, crackle_max=0.0,
                radius=TURN, c_min=min(c, end_c), slope_min=min(slope, end_slope), dwell=0,
                rest=0.0, seat=int(accel > 0.0 and start > 0.0),
            )
        )  # fmt: skip
        c = end_c
        slope = end_slope
    return kernel.cam(Cam(stretches, pieces, 0, BASE + BEND * quarter * quarter))


def _parabola(center: float, c: float, slope: float, accel: float) -> list[float]:
    """A row of the table of pieces (`cam_table.PIECE`) with these values at its centre."""
    derivatives = [[c, slope, 0.5 * accel], [slope, accel], [accel]]
    derivatives += [[]] * (ORDERS - len(derivatives))
    row = [center]
    for powers in derivatives:
        row += powers + [0.0] * (TERMS - len(powers))
    no_rests = [0.0, 0.0]
    return row + no_rests


def _constants() -> Constants:
    return constants_of(MACHINE, TOLERANCE, IMPACTS)


def _fill_flows(kernel: Kernel) -> tuple:
    return _cam(kernel), _constants(), kernel.room(Flow, STRETCHES**2)


def _follow_orbits(kernel: Kernel) -> tuple:
    """Three orbits in one batch: six turns of MACHINE, three of FAST with their loads, two more.

    The first one begins in flight and soon repeats its turns, the second one on the cam, as after
    an impact; the third one goes on from where the second one ends.
    """
    fast = constants_of(FAST, TOLERANCE, IMPACTS)
    constants = [_constants(), fast, fast]
    states = [State(gap=0.01, mode=FREE, period=-1), State(mode=BOUNCED, period=-2), State()]
    runs = [
        Run(log_from=-1, turns=6, strobe_first=0, strobe_rows=6, wants_loads=1),
        Run(log_from=0, turns=3, strobe_first=6, strobe_rows=3, wants_loads=1),
        Run(log_from=0, turns=2, strobe_first=9, strobe_rows=2, continues=1),
    ]
    loads = [Loads(), Loads(shut=BASE), Loads()]
    first_orbit, steps = 0, 10_000
    return (
        _cam(kernel),
        kernel.table(Constants, constants),
        kernel.room(Flow, STRETCHES**2),
        kernel.table(State, states),
        kernel.copies(Tally, Tally(), 3),
        kernel.table(Run, runs),
        kernel.copies(Earlier, Earlier(), 3),
        kernel.table(Loads, loads),
        kernel.log(64),
        kernel.strobe(11),
        first_orbit,
        steps,
    )


def _settle_cells(kernel: Kernel) -> tuple:
    """Two starts, with an attractor of each kind and a rest to end at."""
    cam = _cam(kernel)
    const = _constants()
    count = 2
    point = Point(
        gap=0.0, rate=0.0, a=1e4, b=0.0, c=1e4, shrink=0.5, attractor=0, following=0, symbol=2,
        turns=1,
    )  # fmt: skip
    targets = Targets(
        points=kernel.table(Point, [point]), boxes=kernel.numbers([0, 2], int),
        stay=kernel.numbers([9, 9], int), gap=0.0, rate=-0.1, per_gap=100.0, per_rate=5.0,
        columns=2, rows=1, rests=kernel.table(Rest, [Rest(0.0, 0.0, 0)]), watch_rests=1, near=1e-9,
    )  # fmt: skip
    columns = (kernel.zeros(count, int) for _ in range(6))  # mode to impacts
    cells = Cells(kernel.numbers([0.01, 0.2]), kernel.numbers([0.0, 0.05]), *columns)
    room = Room(
        states=kernel.room(State, 1),
        cell=kernel.room(Progress, 1),
        works=kernel.room(Tally, 1),
        log=kernel.log(0),
        strobe=kernel.strobe(1),
        earliers=kernel.table(Earlier, [Earlier(keep_in=NEVER)]),
    )
    flows = kernel.stretch_flows(cam, const)
    first_cell, budget, steps = 0, 3, 10_000
    return cam, const, flows, targets, cells, first_cell, budget, steps, room


def _stretch_events(kernel: Kernel) -> tuple:
    pairs = kernel.table(Pair, [Pair()])
    growths = kernel.table(Growth, [Growth(), Growth()])
    return _cam(kernel), _constants(), *_events(kernel), pairs, growths


def _measure_loads(kernel: Kernel) -> tuple:
    """The loads of two turns with EVENTS, from the first row of the log to its end in one call."""
    rows = len(EVENTS)
    kind, period, theta, u = _events(kernel)
    log = Log(kind, period, theta, q=kernel.zeros(rows), u=u, capacity=rows)
    loads = kernel.table(Loads, [Loads(turns=2, gap=0.01, rate=-0.07)])
    first, last = 0, rows
    return _cam(kernel), _constants(), log, first, last, rows, loads


def _events(kernel: Kernel) -> Iterator[Any]:
    """The columns of EVENTS."""
    for column in zip(*EVENTS, strict=True):
        yield kernel.numbers(list(column), type(column[0]))


def _correct_orbit(kernel: Kernel) -> tuple:
    """From the guess ORBIT."""
    n, turns = 1, 1
    tables = tables_for(n, kernel.zeros)
    guess = [*ORBIT, FAST[RPM]]
    border = Border(
        row=kernel.numbers([0.0, 0.0, 1.0]),
        origin=kernel.numbers(guess.copy()),
        right=0.0,
        scale=1e-3,
        rate=1e-3,
    )
    machine = kernel.numbers(list(FAST))
    x = kernel.numbers(guess)
    whole = kernel.numbers([ORBIT_STRETCH, 0], int)
    rates = kernel.zeros(n)
    out = kernel.zeros(3)
    return _cam(kernel), machine, RPM, n, turns, whole, x, border, rates, tables, out


def _certify_orbit(kernel: Kernel) -> tuple:
    """The orbit that `_correct_orbit` finds, corrected in plain Python."""
    case = _correct_orbit(PLAIN)
    correct_orbit(*case)  # leaves the orbit in x and rates
    _, machine, _, n, turns, whole, x, _, rates, _, _ = case
    flows = kernel.room(Flow, STRETCHES**2)
    found = kernel.zeros(2)
    works = kernel.room(Tally, 1)
    return (
        _cam(kernel),
        kernel.numbers(machine),
        n,
        turns,
        kernel.numbers(whole, int),
        kernel.numbers(x),
        kernel.numbers(rates),
        flows,
        found,
        works,
    )


def _enclose_landing(kernel: Kernel) -> tuple:
    """A flight over a join of two parabolas."""
    errors = [1e-17] * 5
    sizes = [0.5, 0.25, BEND, 0.0, 0.0]
    start = [1.0, 0.2, 1e-17, 1e-17]  # phase, rate and their radii
    room = [*MACHINE, *errors, *sizes, *start]
    return _cam(kernel), kernel.numbers(room + [0.0] * (COLUMNS - len(room)))


CASES: dict[str, Callable[[Kernel], tuple]] = {
    "fill_flows": _fill_flows,
    "follow_orbits": _follow_orbits,
    "settle_cells": _settle_cells,
    "stretch_events": _stretch_events,
    "measure_loads": _measure_loads,
    "correct_orbit": _correct_orbit,
    "certify_orbit": _certify_orbit,
    "enclose_landing": _enclose_landing,
}
