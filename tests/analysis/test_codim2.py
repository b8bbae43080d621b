"""Points of codimension two, each against the independent reference at 60 digits.

The reference solves the same two conditions by its own equations, from a guess of three digits or
so; what is compared are both parameters, to within the errors claimed, and the multipliers.
"""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest
from flint import arb
from mpmath import mp, mpf

import camcli
from camcli.analysis.orbits import codim2
from camcli.analysis.orbits.codim2 import (
    CodimTwo,
    Condition,
    Meeting,
    PointKind,
    PointProof,
    add_points,
    prove,
)
from camcli.analysis.orbits.codim2 import Test as What
from camcli.analysis.orbits.curves import Plane
from camcli.analysis.orbits.kinds import Bracket, Kind
from camcli.api import orbits as api_orbits
from camcli.cams.balls import precision
from camcli.exact.shooting import ProofStep
from camcli.piece_faults import gathering
from camcli.scene import load_scene
from camcli.words.codim2 import point_line
from tests.support.orbit_oracle import (
    CAM,
    CHAPTER,
    DIGITS,
    GRAZE,
    UNSTABLE,
    Machine,
    Sine,
    _arc,
    at_corner,
    corner_rpm,
    gap_graze_rpm,
    touching,
    two_conditions,
    with_multiplier,
)

CONFIGS = Path(__file__).parents[2] / "configs"
THRICE = {"orbits.label": "P(3;3:3:2)", "orbits.at": 358.5, "orbits.rpm.num": 81,
          "orbits.rpm.start": 350.0, "orbits.rpm.stop": 390.0, "orbits.range": [0.7, 0.9],
          "orbits.starts": 0, "orbits.branches": 0}  # fmt: skip
AT_ONE_SPEED = {"orbits.rpm": {"start": 700.0, "stop": 700.0, "num": 1}}
ONCE = {"orbits.at": 700.0, "orbits.rpm.start": 660.0, "orbits.rpm.stop": 760.0,
        "orbits.rpm.num": 81, "orbits.range": [0.3, 1.0], "orbits.starts": 0,
        "orbits.branches": 1}  # fmt: skip
OSCILLATOR = {"orbits.curve_in": "preload", "orbits.range": [-0.02, 0.02],
              "orbits.rpm.start": 28.8, "orbits.rpm.stop": 30.5, "orbits.rpm.num": 21,
              "orbits.at": 29.0, "orbits.starts": 12, "orbits.branches": 0}  # fmt: skip
EXACT = 1e-12


def points(kind, where, scene=None):
    """The points of codimension two on the curves of a kind, and the result."""
    result = camcli.orbits(load_scene(scene, overrides={"orbits.curve": kind, **where}))
    assert not result.faults
    return result.values.codim2, result


def found(points, kind, corners=()):
    """The first point of a kind at these corners."""
    return next(p for p in points if p.kind == kind and sorted(p.corners) == sorted(corners))


def solved(point, conditions, arcs, machine, name, more=()):
    """The reference near a point, started from rounded numbers."""
    root = point.orbit.root
    turns = root.whole[1::2]
    impacts = [
        (mpf(f"{theta:.4g}") + 2 * mp.pi * turn, mpf(f"{v * point.first * mp.pi / 30:.4g}"))
        for theta, turn, v in zip(root.theta, turns, root.x[1:-1:2], strict=True)
    ]
    machine = machine._replace(**{name: mpf(f"{point.second:.5g}")})
    rpm = mpf(f"{point.first:.6g}")
    return two_conditions(arcs, machine, name, impacts, root.turns, rpm, conditions, more)


def agree(point, reference):
    """Both parameters within their errors, which are small; the multipliers to rounding."""
    assert point.errors[0] < EXACT * point.first
    assert point.errors[1] < EXACT
    assert abs(point.first - reference.rpm) <= point.errors[0]
    assert abs(point.second - reference.second) <= point.errors[1]
    assert point.before < 0.0 < point.behind
    assert point.status == "ok"
    own = sorted(map(abs, point.orbit.multipliers))
    theirs = sorted(map(abs, reference.orbit.multipliers))
    assert own == pytest.approx([float(x) for x in theirs], rel=1e-7, abs=1e-12)


def holds(proof, reference):
    """Narrow enclosures of both parameters, with the reference in them."""
    assert proof.proved
    pairs = (proof.first, reference.rpm), (proof.second, reference.second)
    for (low, high), exact in pairs:
        assert low < exact < high
        assert high - low < 1e-14 * abs(high)


def arcs_of(point):
    """The arc of each impact, by the names of the regions that the orbit has."""
    root = point.orbit.root
    names = dict(zip(point.orbit.theta, point.orbit.regions, strict=True))
    return [
        _arc(CAM, names[theta], 2 * mp.pi * turn + mpf("0.1"))
        for theta, turn in zip(root.theta, root.whole[1::2], strict=True)
    ]


def corner(name, turn):
    """The unrolled phase of a corner."""
    return CAM.breakpoints["abcdef".index(name)] + 2 * mp.pi * turn


def turn_of(point, k):
    """The turn of impact k."""
    return point.orbit.root.whole[2 * k + 1]


@pytest.fixture(autouse=True)
def _digits():
    with mp.workdps(DIGITS):
        yield


def test_two_impacts_at_corners_at_once():
    """Of P(2;1:1): at b and at c. The curve of corner impacts at c has a kink there and goes on."""
    there, result = points("corner-impact", ONCE)
    point = found(there, "double-corner-impact", "bc")
    first, second = ((c.impact, corner(name, turn_of(point, c.impact)))
                     for c, name in zip(point.conditions, point.corners, strict=True))  # fmt: skip
    both = [at_corner(*first), at_corner(*second)]
    reference = solved(point, both, arcs_of(point), CHAPTER, "restitution")
    agree(point, reference)
    holds(prove(point), reference)
    table = result.tables["curve"]
    mine = table["curve"] == point.curves[0]
    assert not point.ends
    assert table["rpm"][mine].max() == 760.0


def test_a_period_doubling_meets_a_corner():
    there, result = points("period-doubling", ONCE)
    point = found(there, "corner-impact-period-doubling", "b")
    number, end = point.ends[0]
    assert result.summary["curves"][number - 1]["end_points"][end] == point.kind
    conditions = [with_multiplier(-1), at_corner(0, corner("b", turn_of(point, 0)))]
    agree(point, solved(point, conditions, arcs_of(point), CHAPTER, "restitution"))
    doubled, doubled_result = points("corner-impact", {**ONCE, "orbits.branches": 2})
    same = found(doubled, "corner-impact-period-doubling", "b")
    assert same.label == "P(1;1)"
    assert (same.first, same.second) == pytest.approx((point.first, point.second), rel=1e-14)
    end = found(doubled, "corner-impact-period-doubling", "c")  # of the curve of P(2;1:1)
    assert (end.label, end.second) == ("P(1;1)", 1.0)
    collapsed = []  # the same, where the curves are known to end at an orbit of fewer turns
    for curve in doubled_result.values.curves:
        ends = replace(curve, ends=(Kind.SHORTER_ORBIT, Kind.SHORTER_ORBIT))
        add_points(result.system, [ends], result.values.question.plane, collapsed)
    again = [p for p in collapsed if p.kind == end.kind]
    assert (end.first, end.second) in [(p.first, p.second) for p in again]
    lossless = found(there, "conservative")
    assert end.first == pytest.approx(lossless.first, rel=1e-13)
    assert (lossless.second, lossless.before, lossless.behind) == (1.0, 0.0, 0.0)
    assert lossless.orbit.multipliers == pytest.approx([-1.0, -1.0], abs=1e-6)
    theta = mpf(lossless.orbit.theta[0])  # one impact that loses nothing: at a corner of the dwell
    assert abs(theta - corner("c", 0)) < 1e-12
    line = point_line(lossless, ("rpm", "restitution"))
    assert "(period-doubling & determinant 1): the curve ends where nothing is lost" in line
    meets = dict(
        zip(result.tables["codim2"]["kind"], result.tables["codim2"]["meets"], strict=True)
    )
    assert meets["conservative"] == "period-doubling & determinant 1"


def test_where_a_curve_loses_nothing_all_along_its_ends_are_no_points():
    """The same end of a curve, of which all points lose nothing, and of which the others do."""
    _, result = points("period-doubling", {**ONCE, "orbits.range": [0.79, 1.0]})
    curve = result.values.curves[0]
    plane = result.values.question.plane
    end = max(curve.points, key=lambda point: point.second)
    beside = min(curve.points, key=lambda point: point.second)
    assert end.second == 1.0
    for others, kinds in ((end, []), (beside, [PointKind.CONSERVATIVE])):
        there = []
        add_points(result.system, [replace(curve, points=(others, end))], plane, there)
        assert [point.kind for point in there] == kinds


def test_a_sentence_does_not_say_that_what_unfolds_is_proved():
    """The proof is of one orbit with both conditions; the rest is theory, and is called so."""
    orbit = camcli.orbits(load_scene(None, {"orbits.starts": 0, **AT_ONE_SPEED})).values.orbits[0]
    conditions = Condition(What.FLIP), Condition(What.CORNER, 0, -1)
    point = CodimTwo(
        PointKind.CORNER_IMPACT_PERIOD_DOUBLING, 700.0, 0.8, (0.0, 0.0), -1.0, 1.0, Bracket.OK,
        orbit, conditions, ("b",), (1,),
    )  # fmt: skip
    unfolds = (
        "the curve of doublings ends on the curve of corner impacts, and corner impacts of the "
        "doubled orbit begin here"
    )
    start = (
        f"corner-impact-period-doubling of {orbit.label} at rpm 700, restitution 0.8 "
        "(period-doubling & corner-impact at b)"
    )
    names = "rpm", "restitution"
    assert point_line(point, names) == f"{start}: {unfolds}"
    proved = replace(point, proof=PointProof(None, (700.0, 700.0), (0.8, 0.8)))
    wanted = f"{start}, proved to be one orbit with both: by theory, {unfolds}"
    assert point_line(proved, names) == wanted
    refused = replace(point, proof=PointProof(ProofStep.SINGULAR))
    why = "not proved: no box could be shown to hold exactly one orbit"
    assert point_line(refused, names) == f"{start}, {why}: by theory, {unfolds}"
    over_a_lash = SimpleNamespace(in_doubles=["cam.lash"])
    on_a_seat = replace(point, solution=(over_a_lash, []))
    refused = replace(point, proof=prove(on_a_seat))
    why = "not proved: the cam is not known in ball arithmetic over this number"
    assert point_line(refused, names) == f"{start}, {why}: by theory, {unfolds}"


def test_a_proof_of_a_point_that_breaks_costs_that_proof_alone(monkeypatch):
    point = CodimTwo(
        PointKind.CONSERVATIVE, 700.25, 0.75, (0.0, 0.0), -1.0, 1.0, Bracket.OK, None, (), (), (1,)
    )

    def prove(point):
        raise ZeroDivisionError

    monkeypatch.setattr(codim2, "add_points", lambda *of, points=point: of[-1].append(points))
    monkeypatch.setattr(codim2, "prove", prove)
    with gathering() as faults:
        (found,) = api_orbits._points(None, SimpleNamespace(curves=()), None, True)
    assert found == replace(point, proof=PointProof(ProofStep.FAULT))
    assert [fault.piece for fault in faults] == ["the proof of the conservative at 700.25, 0.75"]


@pytest.mark.soak
def test_a_fold_meets_a_corner_on_either_curve():
    """Of P(3;3:3:2): the end of its curve of folds, and a place on its curve of corner impacts."""
    there, _ = points("fold", THRICE)
    point = found(there, "corner-impact-fold", "a")
    k = point.conditions[1].impact
    conditions = [with_multiplier(1), at_corner(k, corner("a", turn_of(point, k)))]
    agree(point, solved(point, conditions, arcs_of(point), CHAPTER, "restitution"))
    corners, _ = points("corner-impact", THRICE)
    same = found(corners, "corner-impact-fold", "a")
    assert same.first == pytest.approx(point.first, rel=1e-14)
    assert same.second == pytest.approx(point.second, rel=1e-14)


@pytest.mark.ci
def test_a_graze_meets_a_corner():
    there, _ = points("grazing", THRICE)
    point = found(there, "corner-impact-grazing", "a")
    graze, at = point.conditions
    phase = mpf(f"{point.orbit.root.theta[graze.impact] + graze.angle:.4g}")
    arc = _arc(CAM, "A4", mpf("0.1"))
    conditions = [
        touching(graze.impact, arc),
        at_corner(at.impact, corner("a", turn_of(point, at.impact))),
    ]
    agree(point, solved(point, conditions, arcs_of(point), CHAPTER, "restitution", [phase]))


def test_a_fold_meets_grazing_of_an_oscillator():
    """P(2;1:1) of a forced oscillator touches its stop once more, and has the multiplier 1."""
    there, result = points("grazing", OSCILLATOR, CONFIGS / "eccentric.yaml")
    point = found(there, "fold-grazing")
    graze = point.conditions[0]
    cam = result.scene.cam
    arc = Sine(cam.base, cam.lift)
    machine = Machine(mass=1, stiffness=1, restitution=0.8)
    turn = 2 * mp.pi * turn_of(point, graze.impact)
    phase = mpf(f"{point.orbit.root.theta[graze.impact] + graze.angle:.4g}") + turn
    conditions = [touching(graze.impact, arc), with_multiplier(1)]
    reference = solved(point, conditions, [arc, arc], machine, "preload", [phase])
    agree(point, reference)
    holds(prove(point), reference)


def test_a_curve_goes_to_the_very_edge_of_its_window():
    """The corner impact of P(1;1) at b: c W = (1 + r)/(1 - r) cot(pi W) c_theta, W = w0/omega."""
    _, result = points("corner-impact", ONCE)
    table = result.tables["curve"]
    mine = (table["curve"] == 1) & (table["label"] == "P(1;1)")
    edge = [(rpm, r) for rpm, r in zip(table["rpm"][mine], table["restitution"][mine], strict=True)]
    assert edge[-1][0] == 660.0
    c, c1, _ = CAM.laws(CAM.breakpoints[1])
    for rpm, r in edge:
        W = mp.sqrt(mpf(CHAPTER.stiffness) / mpf(CHAPTER.mass)) * 30 / (mpf(rpm) * mp.pi)
        share = c * W / (c1 * mp.cot(mp.pi * W))
        assert abs(r - (share - 1) / (share + 1)) < 1e-12


def test_a_curve_of_grazing_is_where_the_gap_is_zero():
    where = {**ONCE, "orbits.rpm.stop": 800.0, "orbits.range": [0.7, 0.9], "orbits.branches": 0}
    _, result = points("grazing", where)
    table = result.tables["curve"]
    assert table["label"][0] == "P(1;1)"
    for rpm, r in list(zip(table["rpm"], table["restitution"], strict=True))[::7]:
        machine = CHAPTER._replace(restitution=float(r))
        exact = gap_graze_rpm(CAM, machine, UNSTABLE, 1, 0, float(rpm), GRAZE).rpm
        assert abs(rpm - exact) < 1e-11 * rpm


@pytest.mark.soak
def test_the_function_of_a_cusp_is_the_derivative_of_the_folds_along_the_branch():
    """At a fold of P(3;3:3:2): orbits on either side of it, at given phases of the first impact."""
    scene = load_scene(None, overrides={"orbits.curve": "fold", **THRICE})
    result = camcli.orbits(scene)
    point = result.values.curves[0].points[3]
    root = point.orbit.root
    plane = Plane(("rpm", "restitution"), ((350.0, 390.0), (0.7, 0.9)), 20)
    with precision(80):
        meeting = Meeting(result.system, plane, root, [Condition(What.FOLD), Condition(What.CUSP)])
        u = meeting.start(root, (point.first, point.second))
        at = meeting.shooting(u[-2:])
        bend = float(meeting.equations(u)[-1])
        aside = float(meeting._kernel(at, u[:-2])[0])
    machine = CHAPTER._replace(restitution=point.second)
    turns = root.whole[1::2]
    impacts = [
        (mpf(theta) + 2 * mp.pi * turn, mpf(v) * point.first * mp.pi / 30)
        for theta, turn, v in zip(root.theta, turns, root.x[1:-1:2], strict=True)
    ]
    width = mpf(10) ** -8

    def fold(side):
        """(1 - trace + det) u_1 .. u_n of the orbit whose first phase is off by so many widths."""
        phase = impacts[0][0] + side * width
        there = corner_rpm(CAM, machine, impacts, root.turns, 0, phase, point.first).left
        product = mp.mpf(1)
        for u_minus in there.u_minus:
            product *= u_minus
        return (1 - there.trace + there.det) * product

    exact = (fold(1) - fold(-1)) / (2 * width)
    exact *= (mpf(30) / (mp.pi * point.first)) ** root.count  # m/s to m/rad
    assert bend == pytest.approx(float(exact) * aside, rel=1e-5)


def test_the_function_of_a_cusp_has_digits_to_spare(chapter):
    """Beside a difference of a tenth of the digits, whose error is its width squared."""
    scene = load_scene(None, overrides={"orbits.starts": 0, "orbits.branches": 0, **AT_ONE_SPEED})
    root = next(orbit.root for orbit in camcli.orbits(scene).values.orbits if orbit.root)
    plane = Plane(("rpm", "restitution"), ((690.0, 710.0), (0.7, 0.9)), 20)
    with precision(80):
        meeting = Meeting(chapter, plane, root, [Condition(What.FOLD), Condition(What.CUSP)])
        u = meeting.start(root, (700.0, 0.8))
        bend = meeting.equations(u)[-1]
        at = meeting.shooting(u[-2:])
        along = meeting._kernel(at, u[:-2])
        ends = []
        for width in (arb(10) ** -8, -(arb(10) ** -8)):
            beside = [x + width * d for x, d in zip(u[:-2], along, strict=True)]
            fold_alone = Meeting(chapter, plane, root, [Condition(What.FOLD)])
            ends.append(fold_alone.equations([*beside, *u[-2:]])[-1])
        wide = (ends[0] - ends[1]) / (2 * arb(10) ** -8)
        assert abs(bend) > 1e-3
        assert abs(bend - wide) < 1e-13 * (1 + abs(wide))


@pytest.mark.ci
@pytest.mark.parametrize(
    ("kind", "where", "name"),
    [("corner-impact", ONCE, None), ("grazing", OSCILLATOR, "eccentric.yaml")],
)  # fmt: skip
def test_points_do_not_depend_on_where_a_turn_is_begun(kind, where, name):
    """A strobe behind some impacts moves these to another turn; flights then pass 0 elsewhere."""
    scene = name and CONFIGS / name
    plain, _ = points(kind, where, scene)
    assert plain
    placed = [sorted((c.test, c.side) for c in point.conditions) for point in plain]
    for strobe_deg in (77.0, 251.0):
        there, _ = points(kind, {**where, "run.strobe_deg": strobe_deg}, scene)
        assert [(p.kind, sorted(p.corners)) for p in there] == [
            (p.kind, sorted(p.corners)) for p in plain
        ]
        for own, other in zip(there, plain, strict=True):
            assert own.first == pytest.approx(other.first, rel=1e-12)
            assert own.second == pytest.approx(other.second, rel=1e-12, abs=1e-13)
        assert [sorted((c.test, c.side) for c in p.conditions) for p in there] == placed
