"""Derivatives of flight and impact: what happens to a small difference between two orbits.

A difference (dq, dw) at equal theta, w = dq/dtheta, is carried by a flight of s rad by
    [[1 - W^2 P, B], [-W^2 B, B']],              determinant exp(-2 Z s),
and by an impact with relative rate u < 0 by the saltation matrix (Aizerman & Gantmakher 1958;
Leine & Nijmeijer, Dynamics and Bifurcations of Non-Smooth Mechanical Systems, chapter 7)
    [[-r, 0], [(r a- + a+)/u, -r]],              determinant r^2,
with the relative accelerations a = q'' - c_thetatheta just before and after. While the follower
rests on the cam its state is the cam's: a sticking phase, and with it a complete chatter, maps
every difference to zero.
"""

from camcli.kernel.flow import flow
from camcli.kernel.marks import inlined


@inlined
def flight_tangent(lane, s):
    """(qq, qw, wq, ww), the matrix of a flight of s rad."""
    b, b1, p = flow(lane, s)
    return 1.0 - lane.W2 * p, b, -lane.W2 * b, b1


@inlined
def relative_accel(lane, c, w, c2):
    """q'' - c_thetatheta on the cam at height c with velocity w (m/rad)."""
    return -(lane.G + lane.W2 * c) - 2.0 * lane.Z * w - c2


@inlined
def saltation(lane, lifts, u):
    """Lower left entry of the saltation matrix of an impact with relative rate u < 0.

    lifts: (c, c_theta, c_thetatheta) at the contact; at a corner the caller chooses the side.
    """
    c, c1, c2 = lifts
    before = relative_accel(lane, c, c1 + u, c2)
    after = relative_accel(lane, c, c1 - lane.r * u, c2)
    return (lane.r * before + after) / u


@inlined
def after_flight(lane, s, qq, qw, wq, ww):
    """The flight's matrix times [[qq, qw], [wq, ww]]."""
    a, b, c, d = flight_tangent(lane, s)
    return a * qq + b * wq, a * qw + b * ww, c * qq + d * wq, c * qw + d * ww


@inlined
def after_impact(lane, lifts, u, qq, qw, wq, ww):
    """The impact's saltation matrix times [[qq, qw], [wq, ww]]."""
    s = saltation(lane, lifts, u)
    r = lane.r
    return -r * qq, -r * qw, s * qq - r * wq, s * qw - r * ww
