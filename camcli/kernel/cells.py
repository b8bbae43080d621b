"""Many starts at the strobe, each followed turn by turn until it is known where it ends.

A known periodic attractor is a ring of points (gap, rate) on the section, each with an ellipse
A x^2 + B x y + C y^2 <= 1 about it and the impacts of the turn that begins there. A start belongs
to it when one whole period of it leads from ellipse to ellipse with these impacts and shrinks the
form by the factor asked for. A known aperiodic attractor is a set of boxes of the section; a start
belongs to it when it stays in them for as many turns in a row as asked for. A complete chatter
erases all memory: the few states (gap, rate) at the strobe after one are known with the outcome
they lead to, or that the motion is to be followed on; at another one a start stops.
"""

from enum import IntEnum
from typing import Any, NamedTuple

from camcli.kernel.marks import entry, inlined
from camcli.kernel.orbit_loop import OK, Plan, run


class Outcome(IntEnum):
    """Of a cell that ended at no attractor; an attractor is its index, see also `trouble`."""

    UNDECIDED = -1  # the budget of turns was used up
    FORGOTTEN = -2  # of a state after a rest: nothing is known of what it leads to
    GOES_ON = -3  # of a state after a rest: it is to be followed on
    NEW_REST = -4  # stopped after a rest with an unknown state


UNDECIDED, FORGOTTEN, GOES_ON, NEW_REST = (int(outcome) for outcome in Outcome)
ENDLESS = 1 << 62
SLICE = 50_000  # turns of one call, some tenths of a second
CHATTERED_TURN = -1  # symbol of a turn in which a chatter is completed, else its impacts
SETTLED_FORM = 1e-10  # a form below this may be rounding; it need not shrink any more


class Point(NamedTuple):
    """A point of a periodic attractor on the section, and the turn that begins there."""

    gap: float  # m
    rate: float  # m/rad
    a: float  # of the form A x^2 + B x y + C y^2
    b: float
    c: float
    shrink: float  # factor by which the form shrinks in a period
    attractor: int
    following: int  # the next point of the ring
    symbol: int  # impacts of the turn, or CHATTERED_TURN
    turns: int  # of the whole ring


class Rest(NamedTuple):
    """A known state at the strobe after a complete chatter."""

    gap: float
    rate: float
    end: int  # attractor, FORGOTTEN or GOES_ON


class Targets(NamedTuple):
    """The known attractors of one speed."""

    points: Any  # table of Point
    boxes: Any  # (rows * columns,) int: 1 + the aperiodic attractor that visits the box, or 0
    stay: Any  # (attractors,) int: turns in its boxes that decide, for aperiodic ones
    gap: float  # lowest gap of the boxes
    rate: float
    per_gap: float  # boxes per m
    per_rate: float
    columns: int  # boxes along the gap; 0: no aperiodic attractor
    rows: int  # boxes along the rate
    rests: Any  # table of Rest
    watch_rests: int  # 0: rests are of no interest
    near: float  # m and m/rad within which two rests are one


class Cells(NamedTuple):
    """Columns of a block of starts, overwritten by where they are left; (count,) each."""

    gap: Any  # m
    rate: Any  # m/rad
    mode: Any  # int
    outcome: Any  # int
    turns: Any  # int, used up
    stay: Any  # int, longest stay in boxes
    symbol: Any  # int, of the last turn
    impacts: Any  # int


class Room(NamedTuple):
    """What one cell needs while it runs."""

    states: Any  # one State
    works: Any  # one Work, of all cells
    log: Any  # Log without rows
    strobe: Any  # Strobe of one row


@entry
def settle_cells(cam, const, flows, targets, cells, begin, budget, room):
    """Follow the cells of the block from `begin` on, each for at most `budget` turns.

    Returns the first that is left to do, after `SLICE` turns, or their number.
    """
    state, turns = room.states[0], 0
    for n in range(begin, len(cells.gap)):
        state.theta = cam.stretches[cam.strobe].start
        state.gap, state.gap_rate = cells.gap[n], cells.rate[n]
        state.mode, state.stretch = cells.mode[n], cam.strobe
        state.impacts, state.chattered, state.idle, state.total_impacts = 0, 0, 0, 0
        state.flown = 0
        outcome, used, stay, symbol = settle_cell(cam, const, flows, targets, budget, room)
        cells.gap[n], cells.rate[n] = state.gap, state.gap_rate
        cells.mode[n], cells.outcome[n] = state.mode, outcome
        cells.turns[n], cells.stay[n], cells.symbol[n] = used, stay, symbol
        cells.impacts[n] = state.total_impacts
        turns += used
        if turns >= SLICE:
            return n + 1
    return len(cells.gap)


@inlined
def trouble(status):
    """Outcome of a cell whose run ends with a status that is not OK."""
    return -10 - status


@inlined
def settle_cell(cam, const, flows, targets, budget, room):
    """(outcome, turns used, longest stay in boxes, symbol of the last turn) of one cell."""
    state, plan, strobe = room.states[0], Plan(0, 1, ENDLESS), room.strobe
    at = containing_point(targets, state.gap, state.gap_rate)
    first = form(targets, at, state.gap, state.gap_rate) if at >= 0 else 0.0
    passed = 0
    box_before = visited_box(targets, state.gap, state.gap_rate)
    stay, longest, symbol = 0, 0, 0
    for used in range(1, budget + 1):
        state.period = 0
        status = run(cam, const, flows, state, plan, room.log, strobe, room.works[0])
        if status != OK:
            return trouble(status), used, longest, symbol
        symbol = CHATTERED_TURN if strobe.chatter[0] else strobe.impacts[0]
        gap, rate = state.gap, state.gap_rate
        if symbol == CHATTERED_TURN and targets.watch_rests:
            end = known_rest(targets, gap, rate)
            if end != GOES_ON:
                return end, used, longest, symbol
        if at >= 0:
            to = targets.points[at].following
            size = form(targets, to, gap, rate)
            if symbol == targets.points[at].symbol and size <= 1.0:
                at = to
                passed += 1
                if passed == targets.points[at].turns:
                    if size <= targets.points[at].shrink * first or size <= SETTLED_FORM:
                        return targets.points[at].attractor, used, longest, symbol
                    first, passed = size, 0
            else:
                at = -1
        if at < 0:
            at, passed = containing_point(targets, gap, rate), 0
            first = form(targets, at, gap, rate) if at >= 0 else 0.0
        box = visited_box(targets, gap, rate)
        stay = stay + 1 if box == box_before and box > 0 else 0
        box_before = box
        longest = max(longest, stay)
        if box > 0 and stay >= targets.stay[box - 1]:
            return box - 1, used, longest, symbol
    return UNDECIDED, budget, longest, symbol


@inlined
def form(targets, j, gap, rate):
    """A x^2 + B x y + C y^2 of a state about point j; at most 1 inside its ellipse."""
    point = targets.points[j]
    x = gap - point.gap
    y = rate - point.rate
    return (point.a * x + point.b * y) * x + point.c * y * y


@inlined
def containing_point(targets, gap, rate):
    """The first point whose ellipse holds the state, or -1."""
    for j in range(len(targets.points)):
        if form(targets, j, gap, rate) <= 1.0:
            return j
    return -1


@inlined
def known_rest(targets, gap, rate):
    """Outcome of a state at the strobe after a complete chatter; NEW_REST where it is unknown."""
    for j in range(len(targets.rests)):
        rest = targets.rests[j]
        if abs(gap - rest.gap) <= targets.near and abs(rate - rest.rate) <= targets.near:
            return rest.end
    return NEW_REST


@inlined
def visited_box(targets, gap, rate):
    """1 + the aperiodic attractor whose boxes hold the state, or 0."""
    if targets.columns == 0:
        return 0
    x = (gap - targets.gap) * targets.per_gap
    y = (rate - targets.rate) * targets.per_rate
    if not (0.0 <= x < targets.columns and 0.0 <= y < targets.rows):
        return 0
    return targets.boxes[int(y) * targets.columns + int(x)]
