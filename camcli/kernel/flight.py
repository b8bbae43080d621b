"""The flight after a contact or in the air, up to its landing or the end of a stretch.

The cheap cases are told apart here: resting, accumulating, falling on a dwell, short hops and
lift-off, each with what makes the landing the only one; everything else is left to `search`.

In flight q'' = -(G + W2 q) - 2 Z q', derivatives by theta, with the constants of `flow.Constants`.
"""

from math import sqrt

from camcli.kernel.arithmetic import LARGEST_TANGENT, atan_ratio
from camcli.kernel.cam_table import TURN, higher, restitution_at
from camcli.kernel.contact_search import (
    ACCUMULATED,
    CLEAR,
    EXACTLY,
    LANDED,
    LONGEST_PHASE,
    MEANING,
    MOST_REFINEMENTS,
    NEAR,
    NEARLY,
    STUCK,
    UNKNOWN,
    gap_at,
    gap_near,
    land,
    search,
)
from camcli.kernel.marks import inlined, outlined

REFUSED = 1e300
LARGEST_CHANGE = 0.25  # relative change of the acceleration that the chatter map's error covers
TAYLOR_PHASE = 0.003  # largest (W + 2 Z) s whose power 5 over 2520 is below a rounding
HALF_PERIOD = 9.8  # just below pi squared: (frequency times length)^2 of half a period

FREE, BOUNCED, RELEASED = 0, 1, 2  # how a flight begins: gap > 0, after an impact, from sticking


@inlined
def fly(cam, const, flows, i, f, begin, work):
    """Advance a flight within a stretch: (code, theta, gap, rate).

    const: `flow.Constants`; flows: the table of `flow.fill_flows`; i: the number of the stretch; f:
    the flight as it begins, a `contact_search.Flight`; begin: how it begins, FREE, BOUNCED or
    RELEASED; work: a `contact_search.Tally`, to which what is done is added.

    Codes: CLEAR (moved on, at most to the stretch's end), LANDED, NEARLY and EXACTLY (contact, see
    `contact_search`; the rate is then the relative velocity <= 0, and for the gap stands what
    theta's double leaves out), ACCUMULATED (chatter ends at theta), STUCK (rests on the cam), LOST
    (the step shrank to nothing: closer to grazing than doubles can tell).
    """
    theta = f.theta
    gap = f.gap
    rate = f.rate
    if gap <= 0.0 and begin == FREE:
        if rate < 0.0:
            return LANDED, theta, 0.0, rate
        begin = BOUNCED
    accel = f.q2 - f.c2
    jerk_bound = f.energy + cam.stretches[i].jerk_max  # on |gap'''| = |q''' - c'''| ahead
    radius = cam.stretches[i].radius
    # gap >= rate s - jerk_bound s^3/6 > 0 as far as a series reaches: no short hop to look for
    rises = begin == BOUNCED and accel >= 0.0 and 6.0 * rate > jerk_bound * radius * radius
    if not rises and ((begin != FREE and accel >= 0.0) or begin == RELEASED):
        code, after, rest, u = _leave(cam, const, i, f, work)
        if code != UNKNOWN:
            return code, after, rest, u
    elif begin == BOUNCED and rate <= 0.0:  # not thrown back, and accel < 0 presses it on the cam
        return STUCK, theta, 0.0, 0.0
    elif accel < 0.0:
        if begin == BOUNCED:
            r = restitution_at(cam, const, i)
            if 0.0 < r < 1.0:
                tau = _accumulation(cam, const, r, i, f)
                if tau >= 0.0:
                    return ACCUMULATED, theta + tau, 0.0, 0.0
        if cam.stretches[i].dwell and const.Z == 0.0:
            code, after, rest, u = _drop(cam, const, i, f, work)
            if code != CLEAR:
                return code, after, rest, u
        root = rate if gap == 0.0 else sqrt(rate * rate - 2.0 * accel * gap)
        hop = (rate + root) / -accel if rate >= 0.0 else 2.0 * gap / (root - rate)
        # The hop of a constant accel. Where accel changes by less than half within 1.5 hops the gap
        # is concave and below zero there: more than 1.2 do for that, and 1.5 leave room.
        if jerk_bound * (1.5 * hop) <= -0.5 * accel:
            return _hop(cam, const, i, f, hop, work)
    return search(cam, const, flows, i, f, work)


@outlined
def _leave(cam, const, i, f, work):
    """Leave the cam with rate >= 0 and gap_accel >= 0 (or released by a zero of the force).

    Returns what `fly` does, or UNKNOWN where it takes a `search`, which is left to `fly`. STUCK:
    nothing lifts it, neither a rate nor an acceleration nor its derivative.

    With jerk < 0 and the fourth derivative below K the gap rises once and falls once while
    K s <= |jerk|/2, so a landing predicted by the cubic within that range is the only one. From
    rest with jerk > 0, gap = accel s^2/2 + jerk s^3/6 + ... stays positive for s <= 2 jerk/K.
    """
    accel = max(f.q2 - f.c2, 0.0)
    _, t3, t4, t5, t6 = taylor(cam, const, i, f.theta, f.q2, f.q3, f.c2)
    terms = (0.5 * accel, t3, t4, t5, t6)  # the first one may be a rounding below zero
    jerk = 6.0 * t3
    snap_bound = (2.0 * const.Z + const.W) * f.energy + cam.stretches[i].snap_max  # K
    if jerk < 0.0 and (accel > 0.0 or f.rate > 0.0):
        # the positive root of rate + accel s/2 + jerk s^2/6 = 0, the cubic over s
        hop = 3.0 * (0.5 * accel + sqrt(0.25 * accel * accel - 2.0 / 3.0 * f.rate * jerk)) / -jerk
        reach = min(1.5 * hop, f.end)
        if snap_bound * 1.5 * hop <= -0.5 * jerk and taylor_holds(cam, const, i, reach):
            return _series(cam, i, f, terms, hop, reach, work)
    if f.rate <= 0.0 and jerk <= 0.0 and accel <= 0.0:
        return STUCK, f.theta, 0.0, 0.0
    if f.rate <= 0.0 and jerk > 0.0:
        s = min(f.end, NEAR, 2.0 * jerk / snap_bound if snap_bound > 0.0 else f.end)
        if (const.W + 2.0 * const.Z) * s > LONGEST_PHASE:
            s = LONGEST_PHASE / (const.W + 2.0 * const.Z)
        work.evaluations += 1
        gap, rate, _ = gap_near(cam, const, i, f, s)
        after = cam.stretches[i].end if s == f.end else f.theta + s
        return CLEAR, after, max(gap, 0.0), rate
    return UNKNOWN, f.theta, f.gap, f.rate


@inlined
def _accumulation(cam, const, r, i, f):
    """Phase until chatter accumulates, rad; -1 where the map is too inexact or passes a corner.

    f: the flight after an impact, which begins at the cam with the rate u > 0; r: the restitution.
    `chatter_map` gives the phase and its error. Before it is asked, the largest terms of its error
    alone, which cost less, may already refuse it.
    """
    # on |A'''|, A the relative acceleration in contact
    jerk_bound = const.W2 * cam.stretches[i].jerk_max + 2.0 * const.Z * cam.stretches[i].snap_max
    jerk_bound += cam.stretches[i].crackle_max
    c = f.q - f.gap
    c1 = f.w - f.rate
    force = const.G + const.W2 * c + 2.0 * const.Z * c1 + f.c2  # -A
    if not force > 0.0:
        return -1.0
    hop = 2.0 * f.rate / force
    length = hop / (1.0 - r)
    d = abs(const.D) * hop * hop
    error = jerk_bound * length * length * length / (12.0 * force) + d * d * d / 256.0
    if length > 2.0 * f.end or length * error > const.tolerance:
        return -1.0
    c3, c4, _, _ = higher(cam, i, f.theta)
    force1 = const.W2 * c1 + 2.0 * const.Z * f.c2 + c3
    force2 = const.W2 * f.c2 + 2.0 * const.Z * c3 + c4
    tau, error = chatter_map(const, r, hop, force1 / force, force2 / force, jerk_bound / force)
    if error > const.tolerance or tau + error >= f.end:
        return -1.0
    return tau


@inlined
def _hop(cam, const, i, f, hop, work):
    """A flight that is concave up to its landing: gap'' <= accel/2 < 0 over 1.5 predicted hops.

    Then gap(1.5 hop) < 0 and the root is the only one. Short hops use the gap's own Taylor series,
    so that nothing cancels however small the hop is. Returns what `fly` does.
    """
    reach = min(1.5 * hop, f.end)
    if taylor_holds(cam, const, i, reach):
        terms = taylor(cam, const, i, f.theta, f.q2, f.q3, f.c2)
        return _series(cam, i, f, terms, hop, reach, work)
    if reach == f.end:
        gap, rate, _ = gap_at(cam, const, i, f, reach, work)
        if gap > 0.0:
            return CLEAR, cam.stretches[i].end, gap, rate
    return land(cam, const, i, f, reach, hop, work)


@inlined
def _drop(cam, const, i, f, work):
    """Landing on a dwell without damping: (code, theta, rest, rate), or (CLEAR, theta, gap, rate).

    The follower swings about its equilibrium, so with F = G + W^2 c > 0 it lands at the rate
        u = -sqrt(rate^2 + gap (2 F + W^2 gap))    after    s = (2/W) atan(W h),
        h = (rate - u)/(2 F + W^2 gap) = gap/(-u - rate);
    s = 2 h for W = 0. rest: rad, what the double of theta leaves out.

    EXACTLY: the flight began on the cam and is a small phase of the swing (LONGEST_PHASE). It lands
    as fast as it left, and nothing cancels however low it is, so that theta + rest is right in two
    doubles. NEARLY: any other landing, for `orbit_loop.landing` to sharpen. CLEAR: not on this
    stretch, or this formula does not tell; the state at the start comes back.
    """
    height = const.W2 * f.gap
    span = 2.0 * f.force - height  # 2 F + W^2 gap, as f.force is G + W^2 (c + gap)
    if not span > height:  # F > 0
        return CLEAR, f.theta, f.gap, f.rate
    work.evaluations += 1
    speed = f.rate if f.gap == 0.0 else sqrt(f.rate * f.rate + f.gap * span)  # -u
    h = (f.rate + speed) / span if f.rate >= 0.0 else f.gap / (speed - f.rate)
    x = const.W * h
    if not x <= LARGEST_TANGENT:
        return CLEAR, f.theta, f.gap, f.rate
    s = 2.0 * h * atan_ratio(x * x)
    if not s < f.end:
        return CLEAR, f.theta, f.gap, f.rate
    theta = min(f.theta + s, cam.stretches[i].end)
    rest = s - (theta - f.theta)
    if f.gap > 0.0 or const.W * s > LONGEST_PHASE:
        return NEARLY, theta, rest, -speed
    # omega0/omega is W (1 + W_rest): F is larger by twice the share below, and s goes as 1/F.
    half_change_of_force = const.W_rest * (f.force - const.G) / f.force  # relative
    return EXACTLY, theta, rest - 2.0 * s * half_change_of_force, -speed


@inlined
def _series(cam, i, f, terms, hop, reach, work):
    """Landing of a flight given by its Taylor series, known to be the only one within `reach`.

    terms: coefficients, see `taylor`; hop: a guess, rad. Newton's method kept inside a bracket.
    Returns what `fly` does: LANDED, or CLEAR where the stretch ends before.
    """
    if reach == f.end:
        work.evaluations += 1
        gap, rate = series_gap(f.gap, f.rate, terms, f.end)
        if gap > 0.0:
            return CLEAR, cam.stretches[i].end, gap, rate
    low = 0.0
    high = reach
    s = hop if hop < reach else 0.5 * reach
    for _ in range(MOST_REFINEMENTS):
        gap, rate = series_gap(f.gap, f.rate, terms, s)
        work.evaluations += 1
        if gap > 0.0:
            low = s
        else:
            high = s
        step = -gap / rate if rate < 0.0 else reach
        after = s + step
        if abs(step) <= MEANING * s:
            break
        if not low < after < high:
            after = 0.5 * (low + high)
            if after in (low, high):
                break
        s = after
    gap, rate = series_gap(f.gap, f.rate, terms, s)
    theta = min(f.theta + s, cam.stretches[i].end)
    return LANDED, theta, s - (theta - f.theta), rate


@inlined
def leap(cam, const, flows, i, gap, rate, work):
    """Skip whole stretches while the follower is above the cam's top: (stretches, gap, gap_rate).

    From the start of stretch i, at most to the strobe, with the gap and its rate there; 0 stretches
    where none, or just one, could be skipped. Where q lies above the top at both ends and q'' < 0
    between, q is concave and stays above. y = q'' has no two zeros closer than half a period of
    y'' + 2 Z y' + W^2 y = 0, so within that y < 0 at both ends is enough.
    """
    q = cam.stretches[i].start_c + gap
    if not q > cam.top:
        return 0, gap, rate
    w = cam.stretches[i].start_c1 + rate
    force = const.G + const.W2 * q
    if -force - 2.0 * const.Z * w >= 0.0:
        return 0, gap, rate
    n = len(cam.stretches)
    row = n * i  # of the table of flows: over one stretch, the next row over two, and so on
    most = cam.strobe - i if i < cam.strobe else cam.strobe - i + n
    skipped = 0
    q_end = q
    while skipped < most:
        q_after = q + (w * flows[row].b - force * flows[row].p)
        if not q_after > cam.top:
            break
        q_end = q_after
        row += 1
        skipped += 1
    if skipped < 2:
        return 0, gap, rate
    w_end = w * flows[row - 1].b1 - force * flows[row - 1].b
    j = i + skipped  # the stretch that begins there
    length = cam.stretches[j - 1].end if j <= n else TURN + cam.stretches[j - n - 1].end
    length -= cam.stretches[i].start
    if (
        -const.D * length * length > HALF_PERIOD
        or -const.G - const.W2 * q_end - 2.0 * const.Z * w_end >= 0.0
    ):
        return 0, gap, rate
    work.crossings += 1
    if j >= n:
        j -= n
    return skipped, q_end - cam.stretches[j].start_c, w_end - cam.stretches[j].start_c1


@inlined
def chatter_map(const, r, hop, slope, curve, drift):
    """Phase left until impacts accumulate, after an impact at rate u > 0: (tau, error).

    In flight gap'' + 2 Z gap' + W^2 gap = A(theta), the relative acceleration in contact, so
    z = exp(Z s) gap is a ball that bounces under
        z'' = D z - |A| (1 + f1 s + f2 s^2 + ...),    z' -> -r z' at z = 0.
    Here f1 = A'/A + Z and f2 = A''/(2 A) + Z A'/A + Z^2/2 (exp(Z s) A(s) in powers of s), and
    D = Z^2 - W^2. `hop` is 2 u/|A| (rad), slope A'/A (1/rad), curve A''/A (1/rad^2), drift a bound
    on |A'''/A| ahead (1/rad^3). The phase obeys tau = s + tau', s the first hop and tau' the phase
    after it, r the restitution. Solved order by order, with L = hop/(1 - r) and d = D hop^2,
        tau = L (1 - f1 L/3 + (2 + p) f1^2 L^2/9 - (1 + p) f2 L^2/6 + d/(12 n) + d^2/(80 n')),
        n = 1 + r + r^2, n' = n + r^3 + r^4, p = r/n.
    The first term is the classical 2 r |u-|/((1 - r)|a|). With e_n the bound of f_n L^n, the
    neglected part is below
        L ((e1 + e2)(e1^2 + e2 + d/5) + 2 e3/5 + d^3/256)
    while e1 + e2 + e3 <= 1/4 and |d| <= 1/2, else the error is REFUSED: the next terms of the
    series with room for the later ones, checked against exact sums in the tests. Needs 0 < r < 1;
    the caller sees to it that tau does not jump over a corner.
    """
    length = hop / (1.0 - r)
    z = const.Z * length
    a1 = slope * length
    a2 = 0.5 * curve * length * length
    f1 = a1 + z  # f_n L^n, as the docstring names them
    f2 = a2 + z * a1 + 0.5 * z * z
    d = const.D * hop * hop
    e1 = abs(f1)
    e2 = abs(f2)
    # exp(z) <= 4/3 in the range, over the terms of third order in exp(Z s) A(s)
    e3 = drift * length * length * length / 6.0 + z * (abs(a2) + z * (0.5 * abs(a1) + z / 6.0))
    e3 *= 4.0 / 3.0
    if not (e1 + e2 + e3 <= LARGEST_CHANGE and abs(d) <= 2.0 * LARGEST_CHANGE):
        return length, REFUSED
    q = 1.0 + r + r * r
    part = r / q
    series = f1 * f1 * (2.0 + part) / 9.0 - f2 * (1.0 + part) / 6.0 - f1 / 3.0
    series += d / (12.0 * q) + d * d / (80.0 * (q + r * r * r * (1.0 + r)))
    d = abs(d)
    error = (e1 + e2) * (e1 * e1 + e2 + d / 5.0) + 0.4 * e3 + d * d * d / 256.0
    return length + length * series, length * error


@inlined
def taylor(cam, const, i, theta, q2, q3, c2):
    """Second to sixth derivative of the gap over their factorials, at theta of stretch i.

    q2, q3 are q'' and q''' in flight; the rest follow from q'''' = -2 Z q''' - W^2 q'' and so on.
    """
    c3, c4, c5, c6 = higher(cam, i, theta)
    q4 = -2.0 * const.Z * q3 - const.W2 * q2
    q5 = -2.0 * const.Z * q4 - const.W2 * q3
    q6 = -2.0 * const.Z * q5 - const.W2 * q4
    return (
        (q2 - c2) * 0.5,
        (q3 - c3) * (1.0 / 6.0),
        (q4 - c4) * (1.0 / 24.0),
        (q5 - c5) * (1.0 / 120.0),
        (q6 - c6) * (1.0 / 720.0),
    )


@inlined
def taylor_holds(cam, const, i, s):
    """True where the series of order 6 is more exact over s than q - c computed in doubles."""
    return s <= cam.stretches[i].radius and (const.W + 2.0 * const.Z) * s <= TAYLOR_PHASE


@inlined
def series_gap(gap, rate, t, s):
    """(gap, gap_rate) at s from the coefficients of `taylor`."""
    t2, t3, t4, t5, t6 = t
    value = s * (t2 + s * (t3 + s * (t4 + s * (t5 + s * t6))))
    slope = s * (2.0 * t2 + s * (3.0 * t3 + s * (4.0 * t4 + s * (5.0 * t5 + s * 6.0 * t6))))
    return gap + s * (rate + value), rate + slope
