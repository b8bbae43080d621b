"""Entry points from Python: one lane is one orbit, lanes do not know of each other."""

from camcli.kernel.backend import entry
from camcli.kernel.flight import flow, move
from camcli.kernel.orbit import run
from camcli.kernel.profile import END, ROW, START, TURN, lift, stretch_at
from camcli.kernel.sliding import contact_accel, slide


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
def sample_flight(lane, q, w, s, q_out, w_out):
    """Closed-form states after each s[j] rad of flight from (q, w)."""
    for j in range(len(s)):
        q_out[j], w_out[j] = move(lane, q, w, s[j])


@entry
def sample_cam(cam, theta, c_out, c1_out, c2_out):
    """c, c_theta, c_thetatheta at each theta[j] in [0, 2 pi), right-sided at corners."""
    for j in range(len(theta)):
        c_out[j], c1_out[j], c2_out[j] = lift(cam, stretch_at(cam, theta[j]), theta[j])


@entry
def release_phase(cam, lane, i, theta):
    """(released, theta) of `sliding.slide`, for analyses of the contact force."""
    return slide(cam, lane, i, theta)


@entry
def force_at(cam, lane, i, theta):
    """(a, da/dtheta, size) of `sliding.contact_accel`."""
    return contact_accel(cam, lane, i, theta)
