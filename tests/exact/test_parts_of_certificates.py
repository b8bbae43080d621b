"""How a certificate is cut into parts and written: on gaps, boxes and balls in closed form."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from math import cos, pi, sin, sqrt
from types import SimpleNamespace

import pytest
from flint import arb, arb_mat, ctx

from camcli.analysis.orbits import certificate as module
from camcli.analysis.orbits import codim2
from camcli.analysis.orbits.certificate import (
    Passage,
    _above,
    _box,
    _ends_of,
    _gap_enclosed,
    _halves,
    _hull,
    _lifted,
    _near,
    _parts,
    _range_of,
    _roomy,
    _run,
    _runs,
    _with_flights,
)
from camcli.analysis.orbits.evidence import Evidence
from camcli.analysis.orbits.orbit import from_root
from camcli.analysis.orbits.proofs import Proofs, prove_orbit, prove_ranges
from camcli.analysis.orbits.shooter import Shooter
from camcli.analysis.orbits.single_impact import single_impact_roots
from camcli.analysis.orbits.study import Branch
from camcli.cams.balls import UndecidedError
from camcli.cams.eccentric import EccentricCam
from camcli.cams.formula import formula_of
from camcli.exact.machine import BallMachine, stretches_of
from camcli.exact.shooting import Box, NotProvedError, ProofStep, Touch
from camcli.system import Follower, System

DIGITS = 20  # of a middle: a quarter of the bits


@pytest.fixture(autouse=True)
def eighty_bits():
    before, ctx.prec = ctx.prec, 80
    yield
    ctx.prec = before


# -- numbers as text


@pytest.mark.parametrize(
    ("text", "low", "high"),
    [
        ("[3.5 +/- 1e-3]", "3.498", "3.502"),
        ("[-0.25 +/- 2.5e-2]", "-0.3", "-0.2"),
        ("[700.125]", "700.125", "700.125"),
        ("0.5", "0.5", "0.5"),
        ("1e2", "100", "100"),
    ],
)
def test_a_range_is_twice_as_wide_as_what_is_shown(text, low, high):
    assert tuple(map(Fraction, _range_of(text))) == (Fraction(low), Fraction(high))


def test_the_ends_of_a_ball_hold_it():
    exact = _ends_of(arb(0.375))
    assert (Fraction(exact["low"]), Fraction(exact["high"])) == (Fraction(3, 8), Fraction(3, 8))
    wide = _ends_of(arb(700, 2.0**-40))
    assert Fraction(wide["low"]) < 700 - Fraction(2) ** -40
    assert Fraction(wide["high"]) > 700 + Fraction(2) ** -40
    assert Fraction(wide["high"]) - Fraction(wide["low"]) < Fraction(2) ** -40 * 5


@pytest.mark.parametrize("width", [1.0, -0.3, 2e-3, 7e-9, 30.0, -512.0, 10.0, 0.1])
@pytest.mark.parametrize("x", [pi, -0.123456789012345, 0.0, 97.45])
def test_a_number_of_few_digits_is_near(x, width):
    found = _near(x, width)
    assert abs(found - x) <= 0.05 * abs(width) + 1e-15
    if abs(width) >= 2e-3:
        assert len(repr(abs(found)).split(".")[1]) <= 5


# -- ways that are cut in parts


def short(most: float, tried: list | None = None):
    """Holds for parts of this length or less, wherever they are."""

    def holds(a: arb, b: arb) -> bool:
        if tried is not None:
            tried.append((float(a.mid()), float(b.mid())))
        return abs(float(b.mid()) - float(a.mid())) <= most

    return holds


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(("most", "parts"), [(2.0, 1), (0.6, 2), (0.3, 4), (0.05, 26)])
def test_a_way_is_run_in_parts_that_hold(sign, most, parts):
    """From 2 on, for one rad: forwards, or backwards as where a gap falls to its landing."""
    tried = []
    found = _run(short(most, tried), arb(2), arb(2 + sign))
    assert found.reached is None
    ends = [2.0, *found.cuts, 2.0 + sign]
    lengths = [sign * (b - a) for a, b in pairwise(ends)]
    assert all(0.0 < length <= most + 1e-12 for length in lengths)
    assert found.parts == len(lengths)
    assert parts <= found.parts <= 2 * parts
    assert all(sign * (b - 2.0) <= 1.0 + 1e-12 for _, b in tried)


def test_a_run_stops_where_it_no_longer_holds():
    """A part is tried down to a 64th of the way; the first one far further down."""
    sixth = _run(lambda a, b: float(b.mid()) <= 0.6, arb(0), arb(1))
    assert 0.6 - 1 / 64 - 1e-3 <= float(sixth.reached) <= 0.6
    assert float(sixth.reached) == sixth.cuts[-1]
    assert sixth.parts == len(sixth.cuts)
    first = _run(lambda a, b: float(b.mid()) <= 1e-12, arb(0), arb(1))
    assert 0.0 < float(first.reached) <= 1e-12
    assert first.cuts
    none = _run(lambda a, b: False, arb(0), arb(1))
    assert (none.cuts, float(none.reached), none.parts) == ([], 0.0, 0)
    assert _run(lambda a, b: True, arb(1), arb(1)) == ([], None)  # no way at all
    nowhere = _run(lambda a, b: False, arb(1), arb(1))
    assert (nowhere.cuts, float(nowhere.reached)) == ([], 1.0)


def test_the_way_behind_a_part_is_tried_half_as_long_again():
    tried = []
    _run(short(0.26, tried), arb(0), arb(1))
    lengths = [b - a for a, b in tried]
    held = [k for k, length in enumerate(lengths) if length <= 0.26]
    for k in held[:-1]:
        asked = min(1.5 * lengths[k], 1.0 - tried[k][1])
        assert lengths[k + 1] == pytest.approx(asked, abs=0.05 * asked)


def test_runs_end_with_the_first_that_does_not_go_all_its_way():
    whole = lambda: _run(lambda a, b: True, arb(0), arb(1))  # noqa: E731
    part = lambda: _run(lambda a, b: float(b.mid()) <= 0.5, arb(0), arb(1))  # noqa: E731
    assert [run.reached is None for run in _runs([whole, whole, part, whole])] == [
        True, True, False,
    ]  # fmt: skip
    assert len(_runs([whole, whole])) == 2
    assert len(_runs([part])) == 1


@pytest.mark.parametrize(("most", "count"), [(1.0, 1), (0.99, 2), (0.5, 2), (0.3, 4), (0.26, 4)])
def test_parts_are_halved_until_they_hold(most, count):
    """But for the rounding of a cut, which is at most a twentieth of a half."""
    cuts = _parts(short(1.1 * most if most < 0.99 else most), arb(3), arb(4))
    ends = [3.0, *cuts, 4.0]
    assert len(ends) == count + 1
    assert ends == sorted(ends)
    assert ends == pytest.approx([3.0 + k / count for k in range(count + 1)], abs=0.06)


def test_parts_that_never_hold_are_given_up():
    tried = []
    at = sqrt(2.0) / 2.0
    assert _parts(lambda a, b: not a <= at <= b or b - a < 1e-11, arb(0), arb(1))
    with pytest.raises(UndecidedError):
        _parts(lambda a, b: tried.append((a, b)) or not a <= at <= b, arb(0), arb(1))
    narrowest = min(float(b - a) for a, b in tried)
    assert 2.0**-42 < narrowest < 2.0**-38
    with pytest.raises(UndecidedError):
        _parts(lambda a, b: False, arb(1), arb(1))


def passage(gap) -> Passage:
    return Passage(SimpleNamespace(stretch=0, turn=0), arb(0), arb(2), gap)


def touching(a: arb, b: arb):
    """Balls of g = (x - 1)^2 + (x - 1)^4, which touches zero at 1, and of its derivatives."""
    x = a.union(b) - 1
    return x**2 + x**4, 2 * x + 4 * x**3, 2 + 12 * x**2


def test_a_touch_lies_in_one_part_on_which_the_slope_rises():
    one = passage(touching)
    cuts = _above(one, arb(0.25), arb(1.75), arb(1))
    ends = [0.25, *cuts, 1.75]
    about = [k for k, (a, b) in enumerate(pairwise(ends)) if a < 1.0 < b]
    assert len(about) == 1
    for k, (a, b) in enumerate(pairwise(ends)):
        assert one.above(arb(a), arb(b)) is (k not in about)
    assert one.convex(arb(ends[about[0]]), arb(ends[about[0] + 1]))
    for low, high in ((1.25, 1.75), (0.25, 0.75)):  # it lies elsewhere
        known = _parts(one.above, arb(low), arb(high))
        assert _above(one, arb(low), arb(high), arb(1)) == known
    with pytest.raises(UndecidedError):  # no touch is told, and the gap is not above zero
        _above(one, arb(0.25), arb(1.75), None)
    bent = passage(lambda a, b: (arb(1), arb(0), 0.2 - (a.union(b) - 1) ** 2))
    low, high = _above(bent, arb(0.25), arb(1.75), arb(1))
    assert 0.75 * sqrt(0.2) - 0.05 < high - 1.0 < sqrt(0.2)
    assert 1.0 - low == pytest.approx(high - 1.0, abs=0.03)
    with pytest.raises(UndecidedError):
        _above(passage(lambda a, b: (arb(1), arb(0), arb(-1))), arb(0.25), arb(1.75), arb(1))


def test_which_sign_a_part_is_asked_for():
    for value, at in ((1, "above"), (2, "rises"), (3, "convex")):
        for sign in (1, -1):
            row = [arb(0), arb(0), arb(0)]
            row[value - 1] = arb(sign)
            one = passage(lambda a, b, row=row: tuple(row))
            assert getattr(one, at)(arb(0), arb(1)) is (sign > 0)
            assert one.falls(arb(1), arb(0)) is (value == 2 and sign < 0)
    blank = passage(lambda a, b: (arb(0), arb(0), arb(0)))
    signs = [getattr(blank, at)(arb(0), arb(1)) for at in ("above", "rises", "falls", "convex")]
    assert signs == [False] * 4


def test_a_flight_from_rest_begins_with_a_convex_part():
    one = passage(lambda a, b: (arb(0), arb(0), arb(0.3) - a.union(b)))
    assert _lifted(one) == [0.25]  # of 1, 0.5 and 0.25 the first that holds
    assert _lifted(passage(lambda a, b: (arb(0), arb(0), arb(1)))) == [1.0]
    behind = Passage(one.place, arb(0.5), arb(2), lambda a, b: (arb(0), arb(0), arb(1)))
    assert _lifted(behind) == [1.25]
    with pytest.raises(UndecidedError):
        _lifted(passage(lambda a, b: (arb(0), arb(0), arb(-1))))


# -- gaps

FOLLOWER = Follower(mass=2.0, stiffness=800.0, damping=0.0, gravity=9.81, preload=5.0)
OMEGA = 70.0


def gap_of(x: float, launch: float, q: float, w: float) -> tuple[float, float, float]:
    """In closed form: c = 0.02 + 0.01 (1 - cos x)/2 below a harmonic motion about its balance."""
    w0 = sqrt(400.0) / OMEGA
    balance = -(2.0 * 9.81 + 5.0) / 800.0
    s = x - launch
    height = balance + (q - balance) * cos(w0 * s) + w / w0 * sin(w0 * s)
    rate = -w0 * (q - balance) * sin(w0 * s) + w * cos(w0 * s)
    lift = 0.02 + 0.005 * (1.0 - cos(x))
    return (
        height - lift, rate - 0.005 * sin(x), -w0 * w0 * (height - balance) - 0.005 * cos(x),
    )  # fmt: skip


@pytest.mark.parametrize("width", [0.4, 0.05, 1e-3])
def test_a_gap_and_its_slopes_lie_in_balls_a_quarter_wider(width):
    cam = EccentricCam(kind="eccentric", base=0.02, lift=0.01)
    shape = System.build(FOLLOWER, cam, 0.0).shape
    machine = BallMachine(shape, FOLLOWER, OMEGA * 30.0 / pi)
    (stretch,) = stretches_of(shape)
    launch, q, w = 0.75, 0.03, 0.02
    a, b = 1.5, 1.5 + width
    found = _gap_enclosed(arb(a), arb(b), machine, stretch, arb(launch), arb(q), arb(w))
    backwards = _gap_enclosed(arb(b), arb(a), machine, stretch, arb(launch), arb(q), arb(w))
    for one, other in zip(found, backwards, strict=True):
        assert one.overlaps(other)
    middle = 0.5 * (a + b)
    samples = [middle + share * 0.5 * width for share in (-1.249, -1, -0.5, 0, 0.3, 1, 1.249)]
    rows = [gap_of(x, launch, q, w) for x in samples]
    room = 1e-14
    for n, ball in enumerate(found):
        values = [row[n] for row in rows]
        assert float(ball.lower()) <= min(values) + room
        assert float(ball.upper()) >= max(values) - room
        ranges = max(values) - min(values)
        assert float(ball.upper() - ball.lower()) <= 2.0 * ranges + 0.2 * width**2 + 1e-12


# -- boxes


def box(half=0.25, fixed=2, within=1e-6, middle=(0.1, 0.5, 700.0)) -> Box:
    tangent = [arb(2), arb(-1), arb(1)]
    error = [arb(0, within), arb(0, within), arb(0)]
    return Box([arb(x) for x in middle], tangent, error, fixed, arb(half), error, arb_mat(3, 3))


def test_a_written_box_holds_what_was_shown():
    """Its errors and its half width are never smaller than before, and its middle is as near."""
    third = arb(1) / 3
    one = box(middle=(third, 0.5, 700.0), within=third * 1e-6)
    for event in (False, True):
        roomy = _roomy(one, event)
        text = _box(roomy)
        off = abs(Fraction(text["middle"][0]) - Fraction(1, 3))
        error = Fraction(text["error"][0])
        assert off < Fraction(10) ** (1 - DIGITS)
        assert error > off + Fraction(1, 3) * Fraction(1, 10**6)
        assert error < Fraction(1011, 1000) * Fraction(1, 3 * 10**6)
        assert (text["middle"][2], text["error"][2], text["tangent"][2]) == ("700", "0", "1")
        assert text["tangent"][:2] == ["2", "-1"] or float(text["tangent"][0]) == 2.0
        assert text["fixed"] == 2
        half = Fraction(text["half"])
        if event:  # 1e-20 times 1e18 times 701
            assert half == pytest.approx(0.25 + 701e-2, rel=1e-3)
        else:
            assert half == Fraction(1, 4)
    small = _roomy(box(half=1e-10, within=1e-14))  # a box in which all is all but linear
    # slack 100, and 1e-20 times 1e8 times the size of the unknown
    assert float(abs(small.within[0]).upper()) == pytest.approx(100e-14 + 1.1e-12, rel=1e-3)
    assert float(abs(small.within[1]).upper()) == pytest.approx(100e-14 + 1.5e-12, rel=1e-3)
    wider = _roomy(box(half=1.01e-9, within=1e-6))
    assert float(abs(wider.within[0]).upper()) == pytest.approx(1.01e-6, rel=1e-5)
    assert wider.error == wider.within


def test_a_hull_has_the_extents_of_the_ellipses():
    hull = _hull(box(half=0.0, within=0.0), [(3e-3, 4e-3, 5e-3, 12e-3)])
    assert float(hull[0].rad()) == pytest.approx(1.01 * 5e-3, rel=1e-6)
    assert float(hull[1].rad()) == pytest.approx(1.01 * 13e-3, rel=1e-6)
    assert [float(x.mid()) for x in hull] == pytest.approx([0.1, 0.5, 700.0])
    assert float(hull[2].rad()) == 0.0


def line(guess, fixed, half=0) -> Box:
    """`Shooting.box` of the straight branch z = (0.1 + 2 p, 0.5 - p, 700 + p)."""
    p = guess[fixed] - 700
    middle = [0.1 + 2 * p, 0.5 - p, 700 + p]
    tangent = [arb(2), arb(-1), arb(1)]
    none = [arb(0)] * 3
    return Box([arb(x) for x in middle], tangent, none, fixed, arb(half), none, arb_mat(3, 3))


def test_halves_of_a_box_cover_it_and_share_a_joint():
    whole = box(half=0.25, within=0.0)
    before, after = line([0, 0, arb(699.75)], 2), line([0, 0, arb(700.25)], 2)
    (first, joint), (second, last) = _halves(line, whole, before, after)
    assert last is after
    assert float(joint.middle[2]) == pytest.approx(700.0)
    for half, low, high in ((first, 699.75, 700.0), (second, 700.0, 700.25)):
        assert float(half.middle[2]) == pytest.approx(0.5 * (low + high))
        assert float(half.half) == pytest.approx(1.01 * 0.125, rel=1e-6)
        assert float(half.middle[0]) == pytest.approx(0.1 + 2 * (0.5 * (low + high) - 700))


@pytest.mark.parametrize(("widest", "boxes"), [(0.3, 1), (0.13, 2), (0.07, 4), (0.017, 16)])
def test_a_box_is_cut_until_its_flights_are_divided(monkeypatch, widest, boxes):
    monkeypatch.setattr(module, "_roomy", lambda one: one)
    joints = tuple(line([0, 0, arb(x)], 2) for x in (699.75, 700.25, 700.75))
    of_branch = tuple(line([0, 0, arb(x)], 2, 0.25) for x in (700.0, 700.5))
    evidence = Evidence(80, SimpleNamespace(), of_branch, joints)

    def flights(hull):
        if float(hull[2].rad()) > widest:
            raise UndecidedError
        return [float(hull[2].mid())]

    texts, found = _with_flights(evidence, line, flights)
    assert len(texts) == 2 * boxes
    places = [699.75 + k / (2.0 * boxes) for k in range(2 * boxes + 1)]
    assert [float(joint.middle[2]) for joint in found] == pytest.approx(places)
    assert [text["flights"] for text in texts] == [
        [pytest.approx(0.5 * (a + b))] for a, b in pairwise(places)
    ]


@pytest.mark.parametrize(("widest", "cut"), [(0.0157, True), (0.0155, False), (0.0, False)])
def test_a_box_is_cut_four_times_in_half_and_then_given_up(monkeypatch, widest, cut):
    """The sixteenth part of 0.25, a hundredth wider, is 0.0158 wide before it is rounded."""
    monkeypatch.setattr(module, "_roomy", lambda one: one)
    joints = tuple(line([0, 0, arb(x)], 2) for x in (699.75, 700.25))
    evidence = Evidence(80, SimpleNamespace(), (line([0, 0, arb(700)], 2, 0.25),), joints)
    tried = []

    def flights(hull):
        tried.append(float(hull[2].rad()) / 1.01)
        if tried[-1] > widest:
            raise UndecidedError
        return []

    if cut:
        assert len(_with_flights(evidence, line, flights)[0]) == 16
        return
    with pytest.raises(UndecidedError):
        _with_flights(evidence, line, flights)
    assert len(tried) == 5
    assert tried[1:] == pytest.approx([0.25 / 2**k for k in range(1, 5)], rel=1e-6)


# -- statements that a certificate cannot have

REFUSALS = [UndecidedError, lambda: NotProvedError(ProofStep.GRAZES)]
ECCENTRIC = EccentricCam(kind="eccentric", base=0.25, lift=0.5)
BALANCED = System.build(Follower(1.0, 1.0, preload=-0.5, restitution=0.8), ECCENTRIC)


@pytest.fixture(scope="module")
def one_impact():
    """Orbits of one impact, and the proof of the branch through them."""
    points = []
    for rpm in (20.0, 20.5, 21.0):
        roots = single_impact_roots(Shooter(BALANCED, rpm), rpm, 1)
        points.append(next(from_root(BALANCED, root) for root in roots if root.x[1] > 0.0))
    (part,) = prove_ranges(BALANCED, Branch(1, "found", tuple(points), ("lost", "lost")), [])
    return points, part


@pytest.mark.parametrize("refusal", REFUSALS)
def test_what_has_no_flights_has_no_statement_and_is_named(monkeypatch, one_impact, refusal):
    """An orbit, how far it attracts, and a branch: each is proved, but cannot be checked."""
    points, part = one_impact
    proof = replace(prove_orbit(BALANCED, points[1]), axes=((1e-6, 0.0, 0.0, 1e-6),))
    study = SimpleNamespace(
        orbits=[points[1]], bifurcations=[], curves=[], every=None,
        proofs=Proofs([proof], [], [], [part]),
    )  # fmt: skip
    cam = formula_of(ECCENTRIC)

    def written():
        return module.certificate(study, cam, 0.0, lambda one: getattr(one, "low", "orbit"))

    whole = written()
    assert [one["kind"] for one in whole["statements"]] == ["orbit", "attractor", "branch"]
    assert whole["uncovered"] == []
    orbit, _, branch = whole["statements"]
    assert Fraction(orbit["low"]) == Fraction(orbit["high"]) == Fraction(20.5)
    assert (branch["low"], branch["high"]) == (["20", "20"], ["21", "21"])

    def refused(*_, **more):
        raise refusal()

    monkeypatch.setattr(module, "_flights", refused)
    none = written()
    assert none["statements"] == []
    assert none["uncovered"] == ["orbit", "orbit", "20.0"]


@pytest.mark.parametrize("refusal", REFUSALS)
@pytest.mark.parametrize("place", ["prove_label", "_with_flights"])
def test_a_curve_whose_label_or_flights_are_not_shown_has_no_statement(monkeypatch, place, refusal):
    """It is named in place of the statement; the label is asked of each box."""
    boxes = tuple(line([0, 0, arb(x)], 2, 0.25) for x in (700.0, 700.5))
    on = SimpleNamespace(
        condition=SimpleNamespace(test=codim2.Test.FLIP, impact=-1, side=0), touched=None, box=line,
        meeting=SimpleNamespace(base="shooting", plane=SimpleNamespace(names=("rpm", "mass"))),
        values=lambda hull: (hull[2], arb(1.5)),
    )  # fmt: skip
    part = SimpleNamespace(
        curve=1, failed_step=None, evidence=SimpleNamespace(on=on, boxes=boxes, bits=80)
    )
    about = module.About(["rpm", "mass"], {"turns": 2})
    asked = []
    monkeypatch.setattr(module, "_about", lambda *_: about)
    monkeypatch.setattr(module, "prove_label", lambda *of: asked.append(of))
    joints = [line([0, 0, arb(x)], 2) for x in (699.75, 700.75)]
    monkeypatch.setattr(module, "_with_flights", lambda *_: ([], joints))
    curves = [SimpleNamespace(label="P(2;1:1)")]

    def written():
        return module.certificate_of_curves([part], curves, {}, 90.0, lambda one: "curve 1")

    (statement,) = written()["statements"]
    assert asked == [("shooting", box, pytest.approx(pi / 2), "P(2;1:1)") for box in boxes]
    assert statement["turns"] == 2
    assert [(float(Fraction(one["parameter"]["low"])), float(Fraction(one["second"]["high"])))
            for one in (statement["begin"], statement["end"])] == [
        (699.75, 1.5), (700.75, 1.5),
    ]  # fmt: skip

    def refused(*_):
        raise refusal()

    monkeypatch.setattr(module, place, refused)
    assert written()["statements"] == []
    assert written()["uncovered"] == ["curve 1"]


@pytest.mark.parametrize("refusal", [None, *REFUSALS])
def test_where_multipliers_meet_is_stated_if_it_is_shown(monkeypatch, refusal):
    """trace = p - 699 and det = 1/4: trace^2 = 4 det at p = 698 and 700, none of it from 700.25 on.

    The zero is looked for from where the line through both joints is zero.
    """
    joints = tuple(line([0, 0, arb(x)], 2) for x in (697.75, 698.25, 699.75, 700.25, 700.75))
    boxes = tuple(line([0, 0, arb((a + b) / 2)], 2, (b - a) / 2) for a, b in (
        (697.75, 698.25), (698.25, 699.75), (699.75, 700.25), (700.25, 700.75),
    ))  # fmt: skip
    guesses = []

    def zero(guess, fixed, test):
        guesses.append(float(guess[fixed]))
        if refusal is not None and len(guesses) == 1:
            raise refusal()
        at = arb(round(guesses[-1]))
        assert test([arb(0), arb(0), at]) == 0
        return line([0, 0, at], 2), None

    shooting = SimpleNamespace(trace_det=lambda z: (z[-1] - 699, arb(0.25)), zero=zero)

    def statement(evidence, claims, strobe):
        (box,) = evidence.boxes
        assert float(box.middle[2]) == float(claims["low"]) == float(claims["high"])
        assert (evidence.bits, evidence.shooting, strobe) == (80, shooting, 30.0)
        return claims

    monkeypatch.setattr(module, "_statement", statement)
    part = SimpleNamespace(
        failed_step=None, label="P(1;1)", evidence=Evidence(80, shooting, boxes, joints)
    )
    found = module._meetings(part, 30.0)
    secant = 698.25 - 0.5 * (1 - 0.75**2) / (1.25**2 - 0.75**2)
    assert guesses == pytest.approx([secant, 1398.0 - secant])
    assert [Fraction(one["low"]) for one in found] == [698, 700][refusal is not None :]
    assert all(one["event"]["event"] == "multipliers-meet" for one in found)
    assert {one["label"] for one in found} == {"P(1;1)"}
    failed = SimpleNamespace(**{**vars(part), "failed_step": ProofStep.BOXES})
    assert module._meetings(failed, 0.0) == []
    assert module._meetings(SimpleNamespace(failed_step=None, evidence=None), 0.0) == []
    monkeypatch.setattr(module, "_statement", lambda *of: None)
    assert module._meetings(part, 30.0) == []


# -- whole flights


def bump(x: arb, start: float) -> tuple[arb, arb, arb]:
    """t^2 (1 - t^2), t = x - start - 1, and its derivatives: zero at t = -1, 0 and 1."""
    t = x - start - 1
    square = t * t
    return square * (1 - square), 2 * t - 4 * t * square, 2 - 12 * square


@pytest.mark.parametrize("first_turn", [0, 2])
def test_a_flight_that_touches_is_cut_about_the_touch(monkeypatch, first_turn):
    """From 5.5 rad on for 2 rad, through the end of a turn; it touches 1 rad after its start."""
    start, turn = 5.5, 2.0 * pi
    passages = [
        Passage(
            SimpleNamespace(stretch=3 + k, turn=first_turn + k), arb(begin), arb(end),
            lambda a, b, k=k: bump(a.union(b), start - k * turn),
        )
        for k, (begin, end) in enumerate([(start, turn), (0.0, start + 2.0 - turn)])
    ]  # fmt: skip
    monkeypatch.setattr(module, "_passages", lambda shooting, hull, k: passages)
    hull = [arb(0), arb(0), arb(start), arb(0.1), arb(700)]
    found = module._flight(None, hull, 1, False, Touch(1, arb(1)))
    rows = found["passages"]
    assert [(row["stretch"], row["turn"]) for row in rows] == [(3, first_turn), (4, first_turn + 1)]
    ends = [
        [float(one.begin), *map(float, row["cuts"]), float(one.end)]
        for one, row in zip(passages, rows, strict=True)
    ]
    parts = [(k, a, b) for k, row in enumerate(ends) for a, b in pairwise(row)]
    about = []
    for n, (k, a, b) in enumerate(parts):
        gap, slope, second = passages[k].gap(arb(a), arb(b))
        low, high = a + k * turn - start, b + k * turn - start  # rad after the start
        if n < found["rise"]:
            assert slope > 0
            assert high < 1.0 - sqrt(0.5)
        elif n >= len(parts) - found["fall"]:
            assert slope < 0
            assert low > 1.0 + sqrt(0.5)
        elif low < 1.0 < high:
            about.append(n)
            assert second > 0
        else:
            assert gap > 0
    assert len(about) == 1
    assert 1.0 - sqrt(0.5) - 0.05 < ends[0][found["rise"]] - start
    assert found["rise"] > 0 < found["fall"]
    with pytest.raises(UndecidedError):
        module._flight(None, hull, 1, False, None)
    with pytest.raises(UndecidedError):
        module._flight(None, hull, 1, False, Touch(1, arb(1.3)))
