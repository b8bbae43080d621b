"""Sticking: the follower rests on the cam until the contact force reaches zero.

The relative acceleration in contact, a = -(G + W^2 c + 2 Z c_theta) - c_thetatheta (per rad^2), is
minus the contact force over the mass and omega^2. Contact lasts while a < 0.
"""

from math import sqrt

from camcli.kernel.cam_table import derivative, lift_at
from camcli.kernel.marks import inlined, outlined

MOST_STEPS = 500
SKIP = 1e-8  # rad, past a phase where the contact force touches zero without lift-off
ROUNDING = 4.0 * 2.220446049250313e-16


@inlined
def contact_accel(cam, const, i, theta):
    """(a, da/dtheta, size of its terms) in contact at theta within stretch i."""
    c, c1, c2 = lift_at(cam, i, theta)
    c3 = derivative(cam, 3, i, theta)
    a = -(const.G + const.W2 * c + 2.0 * const.Z * c1) - c2
    slope = -(const.W2 * c1 + 2.0 * const.Z * c2) - c3
    size = abs(const.G) + abs(const.W2 * c) + abs(2.0 * const.Z * c1) + abs(c2)
    return a, slope, size


@outlined
def find_detachment(cam, const, i, theta):
    """(released, theta): first phase in the rest of stretch i where the contact force is lost.

    That is where a becomes positive, or is zero and rising; a force that only touches zero, or is
    zero throughout, releases nothing. False comes with the phase that was reached.
    With |a''| <= M on the stretch, a + a' s + M s^2/2 < 0 up to its first root, so no zero is
    stepped over; near the zero the steps become Newton's.
    """
    stretch = cam.stretches[i]
    end = stretch.end
    least_force = const.G + const.W2 * stretch.c_min + 2.0 * const.Z * stretch.slope_min
    if -least_force - stretch.accel_min < 0.0:  # a < 0 on all of the stretch
        return False, end
    accel = max(abs(stretch.accel_min), abs(stretch.accel_max))
    curve = const.W2 * accel + 2.0 * const.Z * stretch.jerk_max + stretch.snap_max  # M
    for _ in range(MOST_STEPS):
        a, slope, size = contact_accel(cam, const, i, theta)
        if a > ROUNDING * size or (a >= -ROUNDING * size and slope > 0.0):
            return True, theta
        if a >= -ROUNDING * size:  # the force only touches zero here
            step = max(-2.0 * slope / curve, SKIP) if curve > 0.0 else end
        else:  # to the positive root s of a + slope s + curve s^2/2 = 0
            root = sqrt(slope * slope - 2.0 * curve * a)
            if slope >= 0.0 and slope + root > 0.0:
                step = -2.0 * a / (slope + root)
            else:
                step = (root - slope) / curve if curve > 0.0 else end
        if theta + step >= end:
            return False, end
        if theta + step == theta:
            return True, theta
        theta += step
    return False, theta
