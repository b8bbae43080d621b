"""Each branch of the prover has a case that it must refuse, beside one that it accepts.

The machine is an eccentric cam whose orbit of one impact a turn has a closed form, so that what is
wrong in each case is known beforehand: a rate that may be negative, a cam that is met just before
the landing, a test function without a zero, a determinant of the wrong number of turns.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import exp, log, pi, sqrt

import pytest
from flint import arb, arb_mat
from mpmath import mp

from camcli.analysis.orbits import proofs
from camcli.cams.balls import UndecidedError, precision
from camcli.cams.compile import Part
from camcli.exact.first_root import sharpened
from camcli.exact.machine import BallMachine, BallStretch
from camcli.exact.motion import BLOW, BallMotion, Trail
from camcli.exact.shooting import Box, NotProvedError, Place, ProofStep, Shooting
from camcli.system import Follower

FOLLOWER = Follower(mass=1.0, stiffness=1.0, restitution=0.8)
FREQUENCY = 2.0  # omega over the natural frequency
RPM = FREQUENCY * 30.0 / pi
SIZE = 1.0 / 3.0  # m, of c = -SIZE cos(theta)


@dataclass(frozen=True)
class Cam:
    """c = -SIZE cos(theta), with a bump of height s^2 (1 + s/room)^4 (1 - s/small)^4 about a phase.

    s = theta - phase.
    The bump and its slope vanish at the phase and it ends smoothly; almost all of it lies before.
    """

    phase: float = 1.0
    height: float = 0.0
    room: float = 0.1
    small: float = 0.002

    def parts(self) -> list[Part]:
        def smooth(theta):
            return -arb(SIZE) * theta.cos()

        def bumpy(theta):
            s = theta - self.phase
            fades = (1 + s / arb(self.room)) * (1 - s / arb(self.small))
            return smooth(theta) + self.height * s * s * fades * fades * fades * fades

        low, high = arb(self.phase) - self.room, arb(self.phase) + self.small
        return [
            Part(arb(0), low, smooth), Part(low, high, bumpy), Part(high, 2 * arb.pi(), smooth),
        ]  # fmt: skip


def orbit() -> tuple[float, float]:
    """(phase rad, outgoing rate m/rad) of the stable orbit of one impact a turn, b = g = 0.

    One turn of flight with W = 1/2 from (c, w) to (c, w - (1 + r) v/r), where v is the outgoing
    rate: with a = cot(W pi), c = a (1 + r)/(1 - r) c_theta/W  (Budd and Dux 1994), here a = 0, so
    c = 0 at theta = pi/2 or 3 pi/2, and v = 2 r c_theta/(1 - r) from q' = -w after half an
    oscillation: w_out = -w_in with w_out = c' + v and w_in = c' - v/r gives 2 c' = v (1/r - 1).
    """
    r = FOLLOWER.restitution
    slope = SIZE  # c_theta = SIZE sin(theta) at pi/2
    return pi / 2.0, 2.0 * slope * r / (1.0 - r)


def shooting(cam: Cam, follower: Follower = FOLLOWER) -> Shooting:
    empty = Shooting(cam, follower, RPM, "rpm", (), 1)
    return replace(empty, places=(empty.place(arb(orbit()[0]), 0),))


def guess() -> list[arb]:
    return [arb(orbit()[0]), arb(orbit()[1]), arb(RPM)]


@pytest.fixture(autouse=True)
def digits():
    with precision(60):
        yield


def test_the_orbit_of_the_closed_form_is_proved():
    equations = shooting(Cam(orbit()[0]))
    hull = equations.box(guess(), 2).hull()
    assert abs(hull[0] - orbit()[0]) < 1e-14
    assert abs(hull[1] - orbit()[1]) < 1e-14
    equations.admissible(hull)


def test_a_cam_that_is_met_just_before_the_landing_is_refused():
    """The bump meets the flight within 0.1 rad of the landing, and nothing else of it.

    At s rad before the landing the gap is u s to first order and the bump is above height s^2, so
    that it is met from s = u/height on; it adds nothing to the landing, so that all equations hold.
    """
    phase, rate = orbit()
    incoming = rate / FOLLOWER.restitution
    equations = shooting(Cam(phase, height=incoming / 0.01))
    hull = equations.box(guess(), 2).hull()
    assert abs(hull[0] - phase) < 1e-14
    with pytest.raises(NotProvedError) as refused:
        equations.admissible(hull)
    assert refused.value.step in (ProofStep.CONTACT, ProofStep.GRAZES)
    shallow = shooting(Cam(phase, height=1e-6 * incoming))  # at most 0.003 u s high
    shallow.admissible(shallow.box(guess(), 2).hull())


@dataclass(frozen=True)
class Beside(Cam):
    """c = -SIZE cos(theta), with a bump on the 0.2 rad before or behind `at`, where the impact is.

    Its height is that in its middle, and it vanishes at both ends with three derivatives.
    """

    behind: bool = True
    at: arb = arb.pi() / 2

    def parts(self) -> list[Part]:
        def smooth(theta):
            return -arb(SIZE) * theta.cos()

        low, high = (self.at + 0.2 * x for x in ((0, 1) if self.behind else (-1, 0)))

        def bumpy(theta):
            y = (theta - low) * (high - theta) / arb(0.01)
            return smooth(theta) + self.height * y * y * y * y

        return [
            Part(arb(0), low, smooth), Part(low, high, bumpy), Part(high, 2 * arb.pi(), smooth),
        ]  # fmt: skip


@pytest.mark.parametrize("behind", [True, False])
@pytest.mark.parametrize(("height", "met"), [(0.0, False), (0.1, False), (0.6, True)])
def test_an_impact_at_an_end_of_its_stretch_is_looked_at_on_the_other_side(behind, height, met):
    """The impact's own stretch has no bump. The middle of the bump is 0.1 rad from the impact.

    The flight is there some 0.27 m above the cam without a bump, or 0.33 m where it comes down.
    """
    phase, rate = orbit()
    assert 0.1 * rate == pytest.approx(0.267, abs=1e-3)
    at = shooting(Cam()).box(guess(), 2).hull()[0]  # the speed is a double: not quite pi/2
    equations = shooting(Beside(height=height, behind=behind, at=at))
    equations = replace(equations, places=(Place(0 if behind else 2, 0),))
    hull = equations.box(guess(), 2).hull()
    assert abs(hull[0] - phase) < 1e-14
    if met:
        with pytest.raises(NotProvedError) as refused:
            equations.admissible(hull, (0,))
        assert refused.value.step in (ProofStep.CONTACT, ProofStep.GRAZES)
    else:
        equations.admissible(hull, (0,))


def test_a_rate_that_may_be_zero_or_negative_is_refused():
    equations = shooting(Cam(orbit()[0]))
    hull = equations.box(guess(), 2).hull()
    for rate, refuted in ((arb(0, 1e-3), False), (arb(-1), True)):
        with pytest.raises(NotProvedError) as refused:
            equations.admissible([hull[0], rate, hull[2]])
        assert (refused.value.step, refused.value.refuted) == (ProofStep.PULLS, refuted)


def test_an_impact_outside_its_stretch_is_refused():
    equations = shooting(Cam(orbit()[0]))
    hull = equations.box(guess(), 2).hull()
    edge = equations.stretches[equations.places[0][0]].end
    others = ((), (1,))  # that another impact may lie at an end says nothing of this one
    for theta, refuted in ((edge + arb(0, 1e-3), False), (edge + 0.01, True)):
        for ends in others:
            with pytest.raises(NotProvedError) as refused:
                equations.admissible([theta, *hull[1:]], ends)
            assert (refused.value.step, refused.value.refuted) == (ProofStep.ELSEWHERE, refuted)


@dataclass(frozen=True)
class OwnEquations(Shooting):
    """Two equations in x, y and a given p, each of one unknown alone: so each can fail alone.

    constants: for x and for y, the c of x^2 + c = 0; None for x - 1 = 0, solved by Newton at once.
    """

    constants: tuple[float | None, float | None] = (None, None)

    def equations(self, z):
        values, rows = [], []
        for k, c in enumerate(self.constants):
            x = z[k]
            values.append([x - 1 if c is None else x * x + c])
            rows.append([arb(0)] * len(z))
            rows[k][k] = arb(1) if c is None else 2 * x
        return arb_mat(values), arb_mat(rows)


@pytest.mark.parametrize("without", [1.0, 1e-3, 0.0])
@pytest.mark.parametrize("place", [0, 1])
def test_one_equation_without_a_simple_zero_refuses_the_box_of_all(without, place):
    """x^2 + 1 has no real zero, x^2 a double one: nothing the other equation does mends that."""
    constants: list[float | None] = [None, None]
    constants[place] = without
    bare = (Cam(), FOLLOWER, RPM, "rpm", (), 1)
    with pytest.raises(NotProvedError) as refused:
        OwnEquations(*bare, tuple(constants)).box([arb(1.3), arb(1.3), arb(2)], 2)
    assert refused.value.step == ProofStep.SINGULAR
    constants[place] = -2.0
    hull = OwnEquations(*bare, tuple(constants)).box([arb(1.3), arb(1.3), arb(2)], 2).hull()
    assert hull[place].overlaps(arb(2).sqrt())
    assert hull[1 - place].contains(1)
    assert max(x.rad() for x in hull) < 1e-50


def test_a_zero_of_a_test_function_must_lie_in_its_reach():
    equations = shooting(Cam(orbit()[0]))
    at = RPM * 1.001

    def crosses(z):
        return z[-1] - at

    box, _ = equations.zero(guess(), 2, crosses, arb(0.01))
    assert box.hull()[2].contains(arb(at))
    with pytest.raises(NotProvedError) as refused:  # the zero is known less well than the reach
        equations.zero(guess(), 2, lambda z: crosses(z) + arb(0, 1e-6), arb(1e-7))
    assert refused.value.step == ProofStep.CROSSING
    with pytest.raises(NotProvedError):  # never zero, its slope is zero at the end of Newton's way
        equations.zero(guess(), 2, lambda z: (z[-1] - at) * (z[-1] - at) + 1, arb(0.01))


def only_box(p, half=0) -> Box:
    """The box of a branch that is its parameter alone."""
    return Box([p.mid()], [arb(1)], [arb(0)], 0, arb(half), [arb(0)], arb_mat(0, 0))


class Narrow:
    """A branch p = 0 to 1 whose boxes are proved where they are narrow, the more so near 0.

    share: of the way from 0, the widest box there; that at 0 is `least` wide.
    """

    n = 1
    rest = (arb(0), arb(0))  # trace and determinant: stable

    def __init__(self, share: float, least: float):
        self.share, self.least = share, least
        self.covered: list[float] = []  # how far it is proved, after each try

    def box(self, guess, fixed, half=0):
        if half != 0:
            before = self.covered[-1] if self.covered else 0.0
            self.covered.append(before)
            if half > (abs(guess[0]) * self.share + self.least) / 2:
                raise NotProvedError(ProofStep.SINGULAR)
            self.covered[-1] = before + 2.0 * float(half) / proofs.OVERLAP
        return only_box(guess[0], half)

    def admissible(self, hull):
        pass

    def trace_det(self, z):
        return self.rest


def test_a_range_is_given_up_where_its_boxes_are_spent_faster_than_its_way():
    """The way is measured in steps that grow like the distance from where it begins.

    The first step is as wide as the first box. Up to a fifth of all boxes may be spent at once.
    """
    points = [only_box(arb(p)) for p in (0, 1)]
    ends = [proofs.End("", point, point) for point in points]

    def tried(most: int) -> tuple[bool, Narrow]:
        branch = Narrow(0.02, 1e-6)
        try:
            proofs._chain(branch, *ends, 0, True, lambda box: None, most)
        except NotProvedError:
            return False, branch
        return True, branch

    proved, whole = tried(10**6)
    needed = len(whole.covered)
    assert proved
    assert needed > 500  # log(1 + 1e6 * 0.02)/log(1.02) boxes, and some fail
    assert tried(int(1.25 * needed))[0]
    first = next(x for x in whole.covered if x > 0.0)
    way = [log(1.0 + x / first) / log(1.0 + 1.0 / first) for x in whole.covered]
    for most in (needed // 2, int(needed / 1.3)):
        proved, branch = tried(most)
        wanted = next(k for k in range(1, needed) if k >= most * max(0.2, way[k - 1]))
        assert not proved
        assert 0.2 * most < wanted < 0.9 * most
        assert abs(len(branch.covered) - wanted) <= 1


@pytest.mark.parametrize("turns", [1, 2, 3])
def test_the_determinant_is_that_of_all_turns(turns):
    """r^2 from each impact and exp(-b T/m) from each turn, T = 60/rpm."""
    damped = replace(FOLLOWER, damping=0.07)
    places = tuple(Place(1, n) for n in range(turns))
    equations = Shooting(Cam(orbit()[0]), damped, RPM, "rpm", places, turns)
    x = [arb(value) for _ in range(turns) for value in orbit()]
    _, det = equations.trace_det([*x, arb(RPM)])
    period = 60.0 / RPM
    wanted = FOLLOWER.restitution ** (2 * turns) * exp(-damped.damping * period * turns)
    assert abs(det - wanted) < 1e-12 * wanted
    assert det.rad() < 1e-30


def test_the_slope_at_a_sharpened_zero_holds_the_true_one():
    """f = sqrt(2) - sinh(x): zero asinh(sqrt(2)), slope -sqrt(3) there, from a coarse ball."""
    root = arb(2).sqrt()

    def f(x):
        high, low = x.sinh(), x.cosh()
        return [root - high, -low, -high]

    def slopes(x):
        return [*f(x)[1:], -x.cosh()]

    for radius in (1e-3, 1e-6, 1e-9):
        about = arb(float(mp.asinh(mp.sqrt(2))), radius)
        zero, slope = sharpened(f, about, slopes(about))
        assert zero.overlaps(root.asinh())
        assert slope.overlaps(-arb(3).sqrt())
        assert zero.rad() < 1e-50
        assert slope.rad() < 1e-45
    with pytest.raises(UndecidedError):
        sharpened(f, arb(1.0, 1e-3), slopes(arb(1.0, 1e-3)))


def test_the_slope_at_a_sharpened_zero_holds_those_at_all_zeros_of_a_blurred_function():
    """f = -x - 50 x^3/3 + off, |off| <= 1e-3: at off = 0 the slope -1 - 50 x^2 has no slope."""

    def f(x):
        return [arb(0, 1e-3) - x - 50 * x * x * x / 3, -1 - 50 * x * x, -100 * x]

    coarse = arb(0, 1e-2)
    zero, slope = sharpened(f, coarse, [*f(coarse)[1:], arb(-100)])
    for off in (-1e-3, 0.0, 1e-3):
        true = mp.findroot(lambda x, off=off: off - x - 50 * x**3 / 3, 0.0)
        assert zero.contains(arb(float(true)))
        assert slope.contains(arb(float(-1 - 50 * true**2)))


def test_the_closed_form_of_the_orbit_is_a_motion():
    """Half an oscillation in a turn: from (0, w) to (0, -w), with an impact that turns it round."""
    phase, rate = orbit()
    slope, r = SIZE, FOLLOWER.restitution
    assert sqrt(FOLLOWER.stiffness / FOLLOWER.mass) / FREQUENCY == 0.5
    out = slope + rate
    back = slope - rate / r
    assert back == pytest.approx(-out)
    assert phase == pi / 2.0


def chatter(restitution: float, dip: float, rate: float = 0.01) -> tuple[BallMotion, float]:
    """A motion after an impact, and where its chatter ends by summing the hops.

    gap'' = -1 but for the fall of the first hop, where it is -dip; then hops shrink by r.
    """
    deepest = arb(dip).union(arb(1))
    cam = BallStretch(arb(0), arb(6), lambda theta: theta, arb(0),
                  lambda theta: [arb(0, 1), arb(0, 1), deepest - 1, arb(0, 1)])  # fmt: skip
    follower = Follower(mass=1.0, stiffness=0.0, gravity=1.0, restitution=restitution)
    motion = BallMotion.__new__(BallMotion)
    motion.machine, motion.trail, motion.chattered = (
        BallMachine([cam], follower, 30.0 / pi),
        Trail(),
        0,
    )
    motion.follower = follower
    motion.phi, motion.rate, motion.fall = arb(1), arb(rate), arb(1)
    motion.turn, motion.strobe, motion.place = motion.machine.turn, arb(0), Place(0, 0)
    longer = 1.0 / sqrt(dip)  # of the fall, and the rate of its landing is smaller by as much
    first, after = rate * (1.0 + longer), restitution * rate / longer
    return motion, 1.0 + first + 2.0 * after / (1.0 - restitution)


@pytest.mark.parametrize(
    ("restitution", "dip"), [(0.5, 1.0), (0.5, 0.797), (0.45, 0.8), (0.0, 0.9)]
)
def test_the_ball_of_a_chatter_holds_its_end(restitution, dip):
    """Where the pull varies by k^2 within a hop the end may come before 2 v/(1 - r)."""
    motion, end = chatter(restitution, dip)
    assert motion._accumulates()
    (ball,) = motion.trail.chatters
    assert ball.overlaps(arb(end, 1e-14))
    assert ball.rad() < 0.02
    if (restitution, dip) == (0.5, 0.797):
        assert end < 1.0 + 0.01 * 2.0 / (1.0 - restitution)


@pytest.mark.parametrize(("restitution", "dip"), [(0.8, 0.6), (1.0, 1.0), (0.3, 0.2), (0.5, -0.1)])
def test_a_chatter_whose_hops_need_not_shrink_is_refused(restitution, dip):
    """r k >= 1, no loss, a pull that varies by more than 4, one that may vanish."""
    cam = abs(dip)
    motion, _ = chatter(min(restitution, 0.9), cam)
    stretch = motion.machine.stretches[0]
    lowest = arb(dip).union(arb(1)) - 1
    changed = replace(stretch, slopes=lambda theta: [arb(0, 1), arb(0, 1), lowest, arb(0, 1)])
    motion.machine = BallMachine([changed], replace(FOLLOWER, stiffness=0.0, gravity=1.0,
                                                restitution=restitution), 30.0 / pi)  # fmt: skip
    assert not motion._accumulates()
    assert motion.trail.chatters == []


@pytest.mark.parametrize(("bump", "cut"), [(0.0, True), (0.4, True), (2.0, False)])
def test_a_hop_over_a_bump_is_not_taken_for_concave(bump, cut):
    """Pulled by 1, over a cam whose c_thetatheta falls to -bump in the middle of the hop alone."""
    motion, _ = chatter(0.5, 1.0)

    def slopes(theta):
        middle = arb(1.01, 0.003).overlaps(theta)
        return [arb(0), arb(0), arb(0).union(-bump) if middle else arb(0), arb(0)]

    (stretch,) = motion.machine.stretches
    motion.machine = BallMachine([replace(stretch, slopes=slopes)], motion.follower, 30.0 / pi)
    motion.q, motion.w, motion.order = arb(0), motion.rate, BLOW
    low, hop = motion._opening()
    assert (low == 0 and hop is not None) == cut
    if cut:
        assert hop > 2.0 * motion.rate  # the hop is over by then


@pytest.mark.parametrize("off", [0.0, 1e-3, 2e-3])
def test_the_ball_of_a_chatter_holds_the_ends_of_all_its_rates(off):
    """gap'' = -1: it ends 2 v/(1 - r) behind the impact, where v may be anything in its ball."""
    for v in (0.01 - off, 0.01 + off):
        motion, end = chatter(0.5, 1.0, v)
        motion.rate = arb(0.01, off + 1e-9)
        assert motion._accumulates()
        (ball,) = motion.trail.chatters
        assert ball.contains(arb(end))
        assert end == pytest.approx(1.0 + 4.0 * v)
        assert ball.rad() < 8.0 * off + 0.01
