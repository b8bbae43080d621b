"""Entry points from Python: one lane is one orbit, lanes do not know of each other."""

from camcli.kernel.backend import entry
from camcli.kernel.flight import flow, move
from camcli.kernel.orbit import run
from camcli.kernel.profile import END, ROW, START, lift, stretch_at
from camcli.kernel.sliding import contact_accel, slide


@entry
def prepare(cam, lane, turns):
    """Fill turns with `flow` over every whole stretch: crossing one then needs no series."""
    for i in range(cam.stretches):
        length = cam.rows[i * ROW + END] - cam.rows[i * ROW + START]
        turns[3 * i], turns[3 * i + 1], turns[3 * i + 2] = flow(lane, length)


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
