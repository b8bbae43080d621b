"""One certified step of a flight: no contact can hide in it.

Everything is in the gap q - c and its derivatives by theta. On a stretch the cam's
c_thetatheta and |c'''| are bounded; in flight y = q'' obeys y'' + 2 Z y' + W^2 y = 0, so the
energy y'^2 + W^2 y^2 never grows and for all later s
    |q'''(s)| <= E = |q'''(0)| + W |q''(0)|,     |q''''(s)| <= (2 Z + W) E,
and, q' obeying the same equation, |q''(s)| <= |q''(0)| + W |q'(0)|, which is what a stiff damper
leaves of the first. Hence gap'' stays between two computed numbers over a step s (chord of q'' at
both ends plus or minus (2 Z + W) E s^2/8, minus the range of c_thetatheta), and one of these
decides the step:
- concave (gap'' <= 0): positive at both ends means no contact, negative at the end exactly one;
- convex (gap'' >= 0): the tangents at both ends bound the gap from below; where they do not
  decide, Newton from the left never passes the first root, and a minimum is found as a minimum;
- otherwise a slope that stays negative, or a parabola below the gap decides, or the step is halved.
Contacts closer than the rounding of q - c (about 1e-16 of the lift) to a graze may fall either way.
"""

from dataclasses import dataclass
from math import sqrt
from typing import NamedTuple

from camcli.kernel.cam_table import LIFT, PIECE, SLOPE, TERMS, derivative, lift_at, piece_at
from camcli.kernel.flow import flow
from camcli.kernel.marks import inlined, outlined

CLEAR, LANDED, ACCUMULATED, STUCK, LOST = 0, 1, 2, 3, 4  # how a step ends
DIPS, UNKNOWN = 5, 6  # what `decide` says beside CLEAR and LANDED
NEARLY, EXACTLY = 7, 8  # landed, but the phase is rough; landed, and it is exact in two parts

PHASE_CAP = 1.5  # largest W s of one step, so that one series covers it
MOST_HALVINGS = 60
MOST_REFINEMENTS = 80
MEANING = 4.0 * 2.220446049250313e-16
NEAR = 0.03125  # rad, longest flight for which `gap_near` is worth its cost
LONGEST_PHASE = 0.5  # (W + 2 Z) s that its MOST_TERMS terms cover to rounding
MOST_TERMS = 14
CONVERGED = 3e-6  # a Halley step this small, in units of u/accel, leaves less than one ulp
ROUGH = 2e-4  # squares of a Halley step, in units of u/accel and u/jerk, that leaves about 1e-5


@dataclass(slots=True)
class Tally:
    """Counters of the work done."""

    evaluations: int = 0  # of the closed form
    crossings: int = 0  # of stretches, by the table of flows
    steps: int = 0  # of the orbit loop


class Flight(NamedTuple):
    """A flight as it begins at theta within a stretch; derivatives by theta, m and rad."""

    theta: float
    gap: float  # q - c >= 0
    rate: float  # d gap/dtheta
    q: float
    w: float  # q'
    force: float  # G + W^2 q
    q2: float  # q'' = -force - 2 Z w
    q3: float
    c2: float  # c_thetatheta
    energy: float  # bound on the third derivative of q from here on
    end: float  # rad to the end of the stretch


@inlined
def flight_at(cam, const, i, theta, gap, rate):
    """The flight that begins with (gap, rate) at theta of stretch i."""
    c, c1, c2 = lift_at(cam, i, theta)
    return flight_over(cam, const, i, theta, gap, rate, c, c1, c2)


@inlined
def flight_over(cam, const, i, theta, gap, rate, c, c1, c2):
    """`flight_at` where c and its derivatives at theta are known."""
    q = c + gap
    w = c1 + rate
    force = const.G + const.W2 * q
    q2 = -force - 2.0 * const.Z * w
    q3 = -2.0 * const.Z * q2 - const.W2 * w
    energy = abs(q3) + const.W * abs(q2)
    end = cam.stretches[i].end - theta
    return Flight(theta, gap, rate, q, w, force, q2, q3, c2, energy, end)


@inlined
def search(cam, const, flows, i, f, work):
    """One certified step of a flight (see the module): (code, theta, gap, gap_rate).

    i: the number of the stretch; f: the `Flight`, as it begins. CLEAR: no contact up to theta, with
    the gap and its rate there. LANDED or NEARLY: contact at theta, see `land`. LOST: the step
    shrank to nothing. work: a `Tally`.
    """
    s = f.end
    if const.W * s > PHASE_CAP:
        s = PHASE_CAP / const.W
    for _ in range(MOST_HALVINGS):
        if s == f.end and f.theta == cam.stretches[i].start:
            gap_end, rate_end, q2_end = _across(cam, const, flows, i, f, work)
        else:
            gap_end, rate_end, accel_end = gap_at(cam, const, i, f, s, work)
            c2_end = lift_at(cam, i, min(f.theta + s, cam.stretches[i].end))[2]
            q2_end = accel_end + c2_end
        low, high = accel_bounds(cam, const, i, f, s, q2_end)
        stop = cam.stretches[i].end if s == f.end else f.theta + s
        verdict = decide(f.gap, f.rate, gap_end, rate_end, low, high, s)
        if verdict == LANDED:
            first = guess(f.gap, f.rate, f.q2 - f.c2, s, gap_end, rate_end)
            return land(cam, const, i, f, s, first, work)
        if verdict == CLEAR:
            return CLEAR, stop, max(gap_end, 0.0), rate_end
        if verdict == DIPS:
            return dip(cam, const, i, f, s, stop, gap_end, rate_end, work)
        s *= 0.5 if const.Z * s < 8.0 else 0.125  # a stiff damper's layer is thin
        if f.theta + s == f.theta:
            break
    return LOST, f.theta, f.gap, f.rate


@inlined
def accel_bounds(cam, const, i, f, s, q2_end):
    """(low, high): bounds of gap'' over the first s rad of a flight, of which q2_end is q'' there.

    q'' is near the chord of its two ends, within a slack (see the module), and never beyond
    |q''(0)| + W |q'(0)|; c_thetatheta is within its bounds on the stretch, and near its first value
    where the step is short.
    """
    stretch = cam.stretches[i]
    slack = (2.0 * const.Z + const.W) * f.energy * 0.125 * s * s
    reach = abs(f.q2) + const.W * abs(f.w)
    drift = stretch.jerk_max * s
    lowest = max(min(f.q2, q2_end) - slack, -reach)
    highest = min(max(f.q2, q2_end) + slack, reach)
    low = lowest - min(stretch.accel_max, f.c2 + drift)
    high = highest - max(stretch.accel_min, f.c2 - drift)
    return low, high


@inlined
def decide(gap, rate, gap_end, rate_end, low, high, s):
    """What low <= gap'' <= high says of a gap from (gap >= 0, rate) to its end, within s rad.

    LANDED: exactly one contact; CLEAR: none; DIPS: convex, and its minimum may be below zero;
    UNKNOWN: the step is too long to tell.
    """
    falls = rate < 0.0 and (low >= 0.0 or rate + high * s < 0.0)
    if gap_end <= 0.0 and (high <= 0.0 or falls):
        return LANDED
    if high <= 0.0:  # concave and positive at the end
        return CLEAR
    if low >= 0.0:  # convex: above the tangents at both ends, which meet after `meet` rad
        if rate >= 0.0 or rate_end <= 0.0:
            return CLEAR
        meet = (gap_end - gap - rate_end * s) / (rate - rate_end)
        return CLEAR if gap + rate * meet > 0.0 else DIPS
    if gap_end > 0.0 and gap + rate * s + 0.5 * low * s * s > 0.0:  # above a parabola
        return CLEAR
    # above the chord less what a gap'' of `high` sags below it
    return CLEAR if min(gap, gap_end) > 0.125 * high * s * s else UNKNOWN


@inlined
def _across(cam, const, flows, i, f, work):
    """(gap, gap_rate, q'') at the end of stretch i of a flight from its start, by the table.

    flows: a row for each pair of stretches (`flow.fill_flows`); that of (i, 0), in the place
    len(stretches) i, has B, B' and P over the whole of stretch i.
    """
    work.crossings += 1
    row = flows[len(cam.stretches) * i]
    b, b1, p = row.b, row.b1, row.p
    q = f.q + (f.w * b - f.force * p)
    w = f.w * b1 - f.force * b
    q2 = -const.G - const.W2 * q - 2.0 * const.Z * w
    return q - cam.stretches[i].end_c, w - cam.stretches[i].end_c1, q2


@inlined
def is_near(const, s):
    """True where `gap_near` is worth its cost over s rad, and its series long enough."""
    return s <= NEAR and (const.W + 2.0 * const.Z) * s <= LONGEST_PHASE


@inlined
def gap_at(cam, const, i, f, s, work):
    """`gap_after`, counted in work."""
    work.evaluations += 1
    return gap_after(cam, const, i, f, s)


@inlined
def gap_after(cam, const, i, f, s):
    """(gap, gap_rate, gap_accel) after s rad of the flight, within stretch i.

    From the closed form of q and c, or where s is short in relative coordinates: q - c of two large
    numbers would drown a low hop.
    """
    if is_near(const, s):
        return gap_near(cam, const, i, f, s)
    theta = f.theta + s
    if theta > cam.stretches[i].end:
        theta = cam.stretches[i].end
    c, c1, c2 = lift_at(cam, i, theta)
    b, b1, p = flow(const, s)
    q = f.q + (f.w * b - f.force * p)
    w = f.w * b1 - f.force * b
    return q - c, w - c1, -const.G - const.W2 * q - 2.0 * const.Z * w - c2


@inlined
def land(cam, const, i, f, high, first, work):
    """Root of the gap between 0 and `high` (gap <= 0) where it is the only one; first: a guess.

    (code, theta, what theta's double leaves out, u), where u < 0 is the rate of the gap there.
    Halley's iteration kept inside the bracket, with a the gap's acceleration:
        step = -gap/u (1 - bend + bend^2),    bend = -gap a/(2 u^2).
    The evaluation after the last step is spared where the step is below CONVERGED u/accel, which
    leaves an error of its cube in s; u after it takes the jerk where the bound on it says that this
    can be more than a rounding. Where `gap_near` is of no use a ROUGH step will do (NEARLY), for
    `orbit_loop.landing` goes on from it; but not so close to a graze that this would say nothing.
    """
    low = 0.0
    s = first if low < first < high else 0.5 * high
    u = 0.0
    jerk_bound = f.energy + cam.stretches[i].jerk_max
    for _ in range(MOST_REFINEMENTS):
        gap, u, a = gap_at(cam, const, i, f, s, work)
        if gap > 0.0:
            low = s
        else:
            high = s
        step = high - low
        bend = 1.0
        if u < 0.0:
            step = -gap / u
            bend = 0.5 * step * (a / u)
            if abs(bend) < 0.25:  # 1/(1 + bend) but for its cube
                step *= 1.0 - bend * (1.0 - bend)
        after = s + step
        if not low < after < high:
            if abs(step) <= MEANING * (f.theta + s):
                break
            after = 0.5 * (low + high)
            if after in (low, high):
                break
        elif (
            bend * bend <= ROUGH
            and step * step * jerk_bound <= ROUGH * -u
            and abs(a * f.q) * MEANING <= CONVERGED * u * u
            and not is_near(const, s)
        ):
            return NEARLY, min(f.theta + after, cam.stretches[i].end), 0.0, u + step * a
        elif abs(step * a) <= CONVERGED * -u and abs(step) <= CONVERGED:
            if step * step * jerk_bound > MEANING * -u:
                theta = min(f.theta + s, cam.stretches[i].end)
                _, c1, c2 = lift_at(cam, i, theta)
                c3 = derivative(cam, 3, i, theta)
                jerk = -2.0 * const.Z * (a + c2) - const.W2 * (u + c1) - c3
                u += 0.5 * step * step * jerk
            u += step * a
            s = after
            break
        s = after
    theta = min(f.theta + s, cam.stretches[i].end)
    return LANDED, theta, s - (theta - f.theta), u


@inlined
def guess(gap, rate, accel, s, gap_end, rate_end):
    """A landing within s rad, from the parabola at the start, else the tangent at the end.

    Its root is written so that nothing cancels: gap + rate hop + accel hop^2/2 = 0.
    """
    square = rate * rate - 2.0 * accel * gap
    if square > 0.0:
        root = sqrt(square)
        if accel < 0.0:
            hop = (rate + root) / -accel if rate >= 0.0 else 2.0 * gap / (root - rate)
        else:
            hop = 2.0 * gap / (root - rate) if rate < 0.0 else s
        if 0.0 < hop < s:
            return hop
    return s - gap_end / rate_end if rate_end < 0.0 else 0.5 * s


@outlined
def dip(cam, const, i, f, end, stop, gap_end, rate_end, work):
    """A convex gap with its minimum inside the step: Newton from the left, contact or minimum.

    Every iterate is left of the first root, if there is one (the tangent lies below the gap); a
    positive slope means that the minimum was passed without contact. end: rad of the step; stop,
    gap_end, rate_end: the phase there, the gap and its rate. Returns what `search` does.
    """
    s = 0.0
    gap = f.gap
    rate = f.rate
    for _ in range(MOST_REFINEMENTS):
        if rate >= 0.0:
            return CLEAR, stop, gap_end, rate_end
        step = -gap / rate
        if s + step == s or gap <= 0.0:
            return LANDED, f.theta + s, 0.0, rate
        s += step
        if s >= end:
            return CLEAR, stop, gap_end, rate_end
        gap, rate, _ = gap_at(cam, const, i, f, s, work)
    return LANDED, f.theta + s, 0.0, rate


@outlined
def gap_near(cam, const, i, f, s):
    """(gap, gap_rate, gap_accel) after s > 0 of the flight f, s <= NEAR and within stretch i.

    Relative coordinates, so nothing cancels however low the hop is:
        gap(s) = gap + rate s + s^2 Q(s) - fall(s),
        fall = c(theta + s) - c(theta) - c_theta(theta) s.
    Within a piece of the cam, fall/s^2 is the second divided difference of its polynomial (two
    synthetic divisions and a Horner sum in one loop); over several pieces the parts add up with the
    slope gained before. The follower's part is Q = sum T_n/((n + 1)(n + 2)) with
        T_0 = q'', T_1 = q3 s, T_n = (-2 Z s T_{n-1} - W^2 s^2 T_{n-2}/(n - 1))/n,
    from q'''' = -2 Z q''' - W^2 q''; the slope has sum T_n/(n + 1), the acceleration sum T_n.
    """
    fall, slope = cam_fall(cam, i, f.theta, s)
    theta = f.theta + s
    end = cam.stretches[i].end
    c2 = lift_at(cam, i, theta if theta < end else end)[2]
    before = f.q2  # T_{n-1}
    term = f.q3 * s  # T_n
    q_fall = 0.5 * before + term * (1.0 / 6.0)
    q_slope = before + 0.5 * term
    q_accel = before + term
    spring = const.W2 * s * s
    damper = 2.0 * const.Z * s
    for n in range(2, MOST_TERMS):
        after = -(damper * term + spring * before * (1.0 / (n - 1))) * (1.0 / n)
        before = term
        term = after
        q_accel += term
        q_slope += term * (1.0 / (n + 1))
        q_fall += term * (1.0 / (n + 1)) * (1.0 / (n + 2))
    gap = f.gap + (s * (f.rate + s * q_fall) - fall)
    return gap, f.rate + (s * q_slope - slope), q_accel - c2


@outlined
def cam_fall(cam, i, theta, s):
    """(c(theta + s) - c(theta) - c_theta(theta) s, c_theta(theta + s) - c_theta(theta)).

    Added up from piece to piece: over a step within one the slope gained before counts as well. The
    phase x is counted from the centre of the piece at hand, which is the first number of its row,
    and the piece ends half a width from there.
    """
    if cam.stretches[i].dwell:
        return 0.0, 0.0
    piece = piece_at(cam, i, theta)
    last = piece_at(cam, i, theta + s)
    width = 1.0 / cam.stretches[i].per_angle
    x = theta - cam.pieces[piece]
    left = s
    fall = 0.0
    slope = 0.0
    while True:
        step = left if piece == last else min(left, max(0.5 * width - x, 0.0))
        second, first = divided_differences(cam, piece, x, step)
        fall += step * (slope + step * second)
        slope += step * first
        left -= step
        if piece == last:
            return fall, slope
        x = x + step + cam.pieces[piece] - cam.pieces[piece + PIECE]
        piece += PIECE


@outlined
def divided_differences(cam, piece, x, step):
    """Divided differences of a piece between x and y = x + step, from its centre: (second, first).

    second = (c(y) - c(x) - c_theta(x) step)/step^2, first = (c_theta(y) - c_theta(x))/step. A
    polynomial divided by (t - x) once more leaves the quotient whose value at y is wanted: each
    division, and the value, is a Horner sum, and they run side by side. `once` and `twice` are the
    coefficients after one division and after two.
    """
    y = x + step
    once = 0.0
    twice = 0.0
    second = 0.0
    for j in range(TERMS - 1, 1, -1):
        once = cam.pieces[piece + LIFT + j] + x * once
        twice = once + x * twice
        second = twice + y * second
    once = 0.0
    first = 0.0
    for j in range(TERMS - 1, 0, -1):
        once = cam.pieces[piece + SLOPE + j] + x * once
        first = once + y * first
    return second, first
