"""Entry points from Python: one lane is one orbit, lanes do not know of each other."""

from camcli.kernel.backend import entry
from camcli.kernel.flight import flow
from camcli.kernel.orbit import run
from camcli.kernel.profile import END, ROW, START, TURN


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
