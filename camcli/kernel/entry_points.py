"""Entry points from Python: one lane is one orbit, lanes do not know of each other."""

from camcli.kernel.cam_table import END, ROW, START, TURN
from camcli.kernel.cells import follow
from camcli.kernel.certify import certify
from camcli.kernel.flow import flow
from camcli.kernel.growth import stretch_log
from camcli.kernel.marks import entry
from camcli.kernel.orbit_loop import run
from camcli.kernel.shooting import correct


@entry
def prepare(cam, lane, turns):
    """Fill turns with `flow` from the start of stretch i over 1, 2, ... whole stretches.

    turns has 3 stretches^2 entries: B, B', P for i and the number of stretches - 1, in this order.
    With them neither crossing a stretch nor leaping over several needs a series.
    """
    n = cam.stretches
    for i in range(n):
        for k in range(n):
            j = i + k
            stop = cam.rows[j * ROW + END] if j < n else TURN + cam.rows[(j - n) * ROW + END]
            o = 3 * (n * i + k)
            length = stop - cam.rows[i * ROW + START]
            turns[o], turns[o + 1], turns[o + 2] = flow(lane, length)


@entry
def advance(cam, lane, turns, state, count, plan, log, strobe, work):
    """`orbit.run` for one lane; returns its status."""
    return run(cam, lane, turns, state, count, plan, log, strobe, work)


@entry
def correct_orbit(cam, machine, parameter, n, turns, whole, x, border, rates, tables, out):
    """`shooting.correct`: Newton's method for a periodic orbit of n impacts; returns a status."""
    return correct(cam, machine, parameter, n, turns, whole, x, border, rates, tables, out)


@entry
def certify_orbit(cam, machine, n, turns, whole, x, rates, table, found, work):
    """`certify.certify`: the verdict on a solved orbit."""
    return certify(cam, machine, n, turns, whole, x, rates, table, found, work)


@entry
def settle_cells(cam, lane, turns, targets, cells, budget, room):
    """`cells.follow` for a block of starts; outcomes and last states are left in `cells`."""
    follow(cam, lane, turns, targets, cells, budget, room)


@entry
def stretch_events(cam, lane, whole, real, rows, pair, growth):
    """`exponents.stretch_log`: growth of differences along logged events."""
    stretch_log(cam, lane, whole, real, rows, pair, growth)
