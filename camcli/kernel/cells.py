"""Many starts at the strobe, each followed turn by turn until it is known where it ends.

A known periodic attractor is a ring of points (gap, rate) on the section, each with an ellipse
A x^2 + B x y + C y^2 <= 1 about it and the impacts of the turn that begins there. A start belongs
to it when one whole period of it leads from ellipse to ellipse with these impacts and shrinks the
form by the factor asked for. A known aperiodic attractor is a set of boxes of the section; a start
belongs to it when it stays in them for as many turns in a row as asked for. A complete chatter
erases all memory: the few states (gap, rate) at the strobe after one are known with the outcome
they lead to, or that the motion is to be followed on; at another one a start stops.
"""

from typing import Any, NamedTuple

from camcli.kernel.cam_table import ROW, START
from camcli.kernel.marks import inlined
from camcli.kernel.orbit_loop import GAP, MODE, OK, PERIOD, RATE, STRETCH, THETA, TOTAL, Plan, run

UNDECIDED = -1  # outcome: the budget of turns was used up; below it, see `trouble`
FORGOTTEN = -2  # outcome of a state after a rest: nothing is known of what it leads to
GOES_ON = -3  # outcome of a state after a rest: it is to be followed on
NEW_REST = -4  # outcome: stopped after a rest with an unknown state
ENDLESS = 1 << 62
POINT = 6  # entries of a point in Targets.real
LINK = 4  # entries of a point in Targets.whole
CELL = 5  # entries of a cell in Cells.whole
MODE_OF, OUTCOME, TURNS, STAY, SYMBOL = 0, 1, 2, 3, 4
CHATTERED_TURN = -1  # symbol of a turn in which a chatter is completed, else its impacts
SETTLED_FORM = 1e-10  # a form below this may be rounding; it need not shrink any more


class Targets(NamedTuple):
    """The known attractors of one speed."""

    real: Any  # (points * POINT,): gap m, rate m/rad, A, B, C, factor by which the form shrinks
    whole: Any  # (points * LINK,) int: attractor, next point, symbol of the turn, turns in all
    points: int
    boxes: Any  # (rows * columns,) int: 1 + the aperiodic attractor that visits the box, or 0
    stay: Any  # (attractors,) int: turns in its boxes that decide, for aperiodic ones
    gap: float  # lowest gap of the boxes
    rate: float
    per_gap: float  # boxes per m
    per_rate: float
    columns: int  # boxes along the gap; 0: no aperiodic attractor
    rows: int  # boxes along the rate
    rest: Any  # (rests * 2,): gap m, rate m/rad at the strobe after a complete chatter
    ends: Any  # (rests,) int: attractor, FORGOTTEN or GOES_ON
    rests: int  # known states after a rest; -1: rests are of no interest
    near: Any  # (2,): m, m/rad within which two of them are one


class Cells(NamedTuple):
    """A block of starts, overwritten by where they are left."""

    real: Any  # (cells * 2,): gap m, rate m/rad
    whole: Any  # (cells * CELL,) int: mode, outcome, turns used, longest stay, last symbol
    count: int


class Room(NamedTuple):
    """What one cell needs while it runs, and the tally of all of them."""

    state: Any  # (3,)
    count: Any  # (9,) int
    log: Any  # orbit.Log without rows
    strobe: Any  # orbit.Strobe with one row
    work: Any  # (3,) int
    tally: Any  # (2,) int: impacts, turns


@inlined
def follow(cam, lane, turns, targets, cells, budget, room):
    """Follow every cell of the block for at most `budget` turns; nothing is returned."""
    for n in range(cells.count):
        o = CELL * n
        for k in range(9):
            room.count[k] = 0
        room.state[THETA] = cam.rows[cam.strobe * ROW + START]
        room.state[GAP] = cells.real[2 * n]
        room.state[RATE] = cells.real[2 * n + 1]
        room.count[MODE] = cells.whole[o + MODE_OF]
        room.count[STRETCH] = cam.strobe
        outcome, used, stay, symbol = settle_cell(cam, lane, turns, targets, budget, room)
        cells.real[2 * n] = room.state[GAP]
        cells.real[2 * n + 1] = room.state[RATE]
        cells.whole[o + MODE_OF] = room.count[MODE]
        cells.whole[o + OUTCOME] = outcome
        cells.whole[o + TURNS] = used
        cells.whole[o + STAY] = stay
        cells.whole[o + SYMBOL] = symbol
        room.tally[0] += room.count[TOTAL]
        room.tally[1] += used


@inlined
def trouble(status):
    """Outcome of a cell whose run ends with a status that is not OK."""
    return -10 - status


@inlined
def settle_cell(cam, lane, turns, targets, budget, room):
    """(outcome, turns used, longest stay in boxes, symbol of the last turn) of one cell."""
    plan, log, strobe, work = Plan(0, 1, ENDLESS), room.log, room.strobe, room.work
    at = enter(targets, room.state[GAP], room.state[RATE])
    first = form(targets, at, room.state[GAP], room.state[RATE]) if at >= 0 else 0.0
    passed = 0
    home = visited(targets, room.state[GAP], room.state[RATE])
    stay, longest, symbol = 0, 0, 0
    for used in range(1, budget + 1):
        room.count[PERIOD] = 0
        status = run(cam, lane, turns, room.state, room.count, plan, log, strobe, work)
        if status != OK:
            return trouble(status), used, longest, symbol
        symbol = CHATTERED_TURN if strobe.events[1] else strobe.events[0]
        gap, rate = room.state[GAP], room.state[RATE]
        if symbol == CHATTERED_TURN and targets.rests >= 0:
            end = rested(targets, gap, rate)
            if end != GOES_ON:
                return end, used, longest, symbol
        if at >= 0:
            to = targets.whole[LINK * at + 1]
            size = form(targets, to, gap, rate)
            if symbol == targets.whole[LINK * at + 2] and size <= 1.0:
                at = to
                passed += 1
                if passed == targets.whole[LINK * at + 3]:
                    if size <= targets.real[POINT * at + 5] * first or size <= SETTLED_FORM:
                        return targets.whole[LINK * at], used, longest, symbol
                    first, passed = size, 0
            else:
                at = -1
        if at < 0:
            at, passed = enter(targets, gap, rate), 0
            first = form(targets, at, gap, rate) if at >= 0 else 0.0
        here = visited(targets, gap, rate)
        stay = stay + 1 if here == home and here > 0 else 0
        home = here
        longest = max(longest, stay)
        if here > 0 and stay >= targets.stay[here - 1]:
            return here - 1, used, longest, symbol
    return UNDECIDED, budget, longest, symbol


@inlined
def form(targets, j, gap, rate):
    """A x^2 + B x y + C y^2 of a state about point j; at most 1 inside its ellipse."""
    o = POINT * j
    x = gap - targets.real[o]
    y = rate - targets.real[o + 1]
    return (targets.real[o + 2] * x + targets.real[o + 3] * y) * x + targets.real[o + 4] * y * y


@inlined
def enter(targets, gap, rate):
    """The first point whose ellipse holds the state, or -1."""
    for j in range(targets.points):
        if form(targets, j, gap, rate) <= 1.0:
            return j
    return -1


@inlined
def rested(targets, gap, rate):
    """Outcome of a state at the strobe after a complete chatter; NEW_REST where it is unknown."""
    for j in range(targets.rests):
        x = gap - targets.rest[2 * j]
        y = rate - targets.rest[2 * j + 1]
        if abs(x) <= targets.near[0] and abs(y) <= targets.near[1]:
            return targets.ends[j]
    return NEW_REST


@inlined
def visited(targets, gap, rate):
    """1 + the aperiodic attractor whose boxes hold the state, or 0."""
    if targets.columns == 0:
        return 0
    x = (gap - targets.gap) * targets.per_gap
    y = (rate - targets.rate) * targets.per_rate
    if not (0.0 <= x < targets.columns and 0.0 <= y < targets.rows):
        return 0
    return targets.boxes[int(y) * targets.columns + int(x)]
