"""Many starts at the strobe, each followed turn by turn until it is known where it ends.

A known periodic attractor is a ring of points (gap, rate) on the section, each with an ellipse
A x^2 + B x y + C y^2 <= 1 about it and the impacts of the turn that begins there. A start belongs
to it when one whole period of it leads from ellipse to ellipse with these impacts and shrinks the
form by the factor asked for. A known aperiodic attractor is a set of boxes of the section; a start
belongs to it when it stays in them for as many turns in a row as asked for. A complete chatter
erases all memory: the few states (gap, rate) at the strobe after one are in a table, each with the
outcome it leads to, or that the motion is to be followed on. A start that comes to one not in the
table stops there (NEW_REST).
"""

from dataclasses import dataclass
from enum import IntEnum
from typing import Any, NamedTuple

from camcli.kernel.marks import entry, inlined
from camcli.kernel.orbit_loop import OK, PAUSED, Plan, run


class Outcome(IntEnum):
    """The outcome of a cell that ended at no attractor; all others are indices of attractors.

    Numerical trouble has outcomes of its own, see `trouble`.
    """

    UNDECIDED = -1  # the budget of turns was used up
    FORGOTTEN = -2  # of a state after a rest: nothing is known of what it leads to
    GOES_ON = -3  # of a state after a rest: it is to be followed on
    NEW_REST = -4  # stopped after a rest with an unknown state


UNDECIDED, FORGOTTEN, GOES_ON, NEW_REST = (int(outcome) for outcome in Outcome)
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


@dataclass(slots=True)
class Progress:
    """How far the cell at work has come."""

    begun: int = 0  # 0: no cell is at work
    used: int = 0  # turns
    at: int = 0  # the point of a ring that it is at, or -1
    passed: int = 0  # points of the ring since it was met
    first: float = 0.0  # the form there
    box: int = 0  # see `visited_box`
    stay: int = 0  # turns in that box
    longest: int = 0  # such stay
    symbol: int = 0  # of the last turn


class Room(NamedTuple):
    """What one cell needs while it runs."""

    states: Any  # one State
    cell: Any  # one Progress
    works: Any  # one Tally, of all cells
    log: Any  # Log without rows
    strobe: Any  # Strobe of one row
    earliers: Any  # one Earlier that keeps nothing: a cell ends at an attractor, not in a cycle


@entry
def settle_cells(cam, const, flows, targets, cells, begin, budget, steps, room):
    """Follow the cells of the block from `begin` on, each for at most `budget` turns.

    Where each is left, and its `Outcome`, is written into its row of `cells`. targets: `Targets`;
    cells: `Cells`; room: `Room`. Returns the number of the cell at work when `steps` steps of the
    orbit loop were done, from which another call goes on and gives the same bits as one long call;
    or the number of cells where all are done.
    """
    state = room.states[0]
    cell = room.cell[0]
    stop = room.works[0].steps + steps
    for n in range(begin, len(cells.gap)):
        if cell.begun == 0:
            begin_cell(cam, targets, cells, n, state, cell)
        outcome = settle_cell(cam, const, flows, targets, budget, stop, room)
        if outcome == trouble(PAUSED):
            return n
        cell.begun = 0
        cells.gap[n] = state.gap
        cells.rate[n] = state.gap_rate
        cells.mode[n] = state.mode
        cells.outcome[n] = outcome
        cells.turns[n] = cell.used
        cells.stay[n] = cell.longest
        cells.symbol[n] = cell.symbol
        cells.impacts[n] = state.total_impacts
    return len(cells.gap)


@inlined
def begin_cell(cam, targets, cells, n, state, cell):
    """Put the state of cell n where the motion begins."""
    state.theta = cam.stretches[cam.strobe].start
    state.gap = cells.gap[n]
    state.gap_rate = cells.rate[n]
    state.mode = cells.mode[n]
    state.stretch = cam.strobe
    state.impacts = 0
    state.chattered = 0
    state.idle = 0
    state.total_impacts = 0
    state.flown = 0
    state.period = 0
    state.known = 0
    state.rest = 0.0
    cell.begun = 1
    cell.used = 0
    cell.stay = 0
    cell.longest = 0
    cell.symbol = 0
    cell.box = visited_box(targets, state.gap, state.gap_rate)
    meet(targets, state.gap, state.gap_rate, cell)


@inlined
def meet(targets, gap, rate, cell):
    """Look for a ring in one of whose ellipses the state is, and begin to follow it there."""
    cell.at = containing_point(targets, gap, rate)
    cell.passed = 0
    cell.first = form(targets, cell.at, gap, rate) if cell.at >= 0 else 0.0


@inlined
def trouble(status):
    """Outcome of a cell whose run ends with a status that is not OK: below all of `Outcome`."""
    return -10 - status


@inlined
def settle_cell(cam, const, flows, targets, budget, stop, room):
    """Outcome of the cell at work; `trouble(PAUSED)` where all work together is `stop` steps.

    It is followed turn by turn: to a rest whose end is known, once round a ring, or for long enough
    in the boxes of an aperiodic attractor.
    """
    state = room.states[0]
    cell = room.cell[0]
    strobe = room.strobe
    work = room.works[0]
    while cell.used < budget:
        plan = Plan(0, 1, stop - work.steps)
        status = run(cam, const, flows, state, plan, room.log, strobe, work, room.earliers[0])
        if status == PAUSED:
            return trouble(PAUSED)
        cell.used += 1
        if status != OK:
            return trouble(status)
        state.period = 0
        cell.symbol = CHATTERED_TURN if strobe.chatter[0] else strobe.impacts[0]
        if cell.symbol == CHATTERED_TURN and targets.watch_rests:
            end = known_rest(targets, state.gap, state.gap_rate)
            if end != GOES_ON:
                return end
        attractor = follow_ring(targets, state.gap, state.gap_rate, cell)
        if attractor >= 0:
            return attractor
        attractor = count_stay(targets, state.gap, state.gap_rate, cell)
        if attractor >= 0:
            return attractor
    return UNDECIDED


@inlined
def follow_ring(targets, gap, rate, cell):
    """Go on along the ring that the cell is at, to the state after one more turn.

    Returns the attractor where a whole period has led round it and shrunk the form enough, else -1.
    A cell that has left its ring, or was at none, looks for one.
    """
    if cell.at >= 0:
        to = targets.points[cell.at].following
        size = form(targets, to, gap, rate)
        if cell.symbol == targets.points[cell.at].symbol and size <= 1.0:
            cell.at = to
            cell.passed += 1
            if cell.passed == targets.points[to].turns:
                if size <= targets.points[to].shrink * cell.first or size <= SETTLED_FORM:
                    return targets.points[to].attractor
                cell.first = size
                cell.passed = 0
        else:
            cell.at = -1
    if cell.at < 0:
        meet(targets, gap, rate, cell)
    return -1


@inlined
def count_stay(targets, gap, rate, cell):
    """Count the turns in a row that the cell has spent in the boxes of one aperiodic attractor.

    Returns that attractor where they are as many as asked for, else -1.
    """
    box = visited_box(targets, gap, rate)
    cell.stay = cell.stay + 1 if box == cell.box and box > 0 else 0
    cell.box = box
    cell.longest = max(cell.longest, cell.stay)
    if box > 0 and cell.stay >= targets.stay[box - 1]:
        return box - 1
    return -1


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
