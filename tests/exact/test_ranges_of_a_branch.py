"""How boxes are laid along a branch, from one end to the other, on a branch that is a line.

What is asked of a box is noted by stand-ins, which refuse where a test wants it.
"""

from __future__ import annotations

from dataclasses import replace
from math import inf, nextafter
from types import SimpleNamespace as Stub

import pytest
from flint import arb, arb_mat, arb_series, ctx

from camcli.analysis.border_collision import Rule
from camcli.analysis.orbits import proofs
from camcli.analysis.orbits.kinds import Bracket, Kind
from camcli.analysis.orbits.locate import Located
from camcli.analysis.orbits.proofs import End
from camcli.analysis.orbits.study import Branch
from camcli.cams.balls import UndecidedError
from camcli.exact.shooting import Box, NotProvedError, Place, ProofStep, Touch


@pytest.fixture(autouse=True)
def many_bits():
    before, ctx.prec = ctx.prec, 120
    yield
    ctx.prec = before


def box_at(p, half=0, error=0.0, lean=(0.5, -0.25)) -> Box:
    """The box of the orbits theta = 1 + (p - 700)/2, v = 2 - (p - 700)/4, or of another lean."""
    p = arb(p).mid()
    middle = [1 + lean[0] * (p - 700), 2 + lean[1] * (p - 700), p]
    errors = [arb(0, error), arb(0, error), arb(0)]
    tangent = [*map(arb, lean), arb(1)]
    return Box(middle, tangent, errors, 2, arb(half), errors, arb_mat(1, 1))


def numbers(values) -> list[float]:
    return [float(x.mid()) for x in values]


class Line:
    """The equations of the line, with two impacts; `fails` is asked of each box that is wide."""

    n = 2

    def __init__(self, fails=lambda number, half: False):
        self.fails = fails
        self.wide = []  # (guess, half)
        self.narrow = []  # parameters of joints
        self.admitted = []

    def box(self, guess, fixed, half=0):
        assert fixed == 2
        if half == 0:
            self.narrow.append(float(guess[2].mid()))
            return box_at(guess[2])
        self.wide.append((numbers(guess), float(half)))
        if self.fails(len(self.wide), float(half)):
            raise NotProvedError(ProofStep.SINGULAR)
        return box_at(guess[2], half)

    def admissible(self, hull):
        self.admitted.append(float(hull[2].mid()))


def chain(monkeypatch, line, way=16.0, around=(None, None), **more):
    """The chain from 700 on; what each box was asked for, and what the work came to."""
    noted = Stub(stable=[], labels=[], shared=[], work=[])
    monkeypatch.setattr(
        proofs,
        "_prove_stability",
        lambda made, box, stable: noted.stable.append((made, box, stable)),
    )
    monkeypatch.setattr(proofs, "_prove_shared", lambda *of: noted.shared.append(of))
    monkeypatch.setattr(proofs, "_spend", noted.work.append)
    ends = [
        End("", box_at(700.0 + place), box_at(700.0 + place + (beside if box else 0.0)), box)
        for (place, beside), box in zip(((0.0, 0.5), (way, -0.5)), around, strict=True)
    ]
    boxes, joints = proofs._chain(line, *ends, 2, "stable", noted.labels.append, **more)
    return boxes, joints, noted, ends


CENTERS = [0.5, 1.75, 3.625, 6.4375, 10.65625, 14.59375]  # widths grow by a half
CUTS = [1.0, 2.5, 4.75, 8.125, 13.1875]


@pytest.mark.parametrize("way", [16.0, -16.0])
def test_boxes_grow_along_the_way_and_meet_in_joints(monkeypatch, way):
    """From a sixteenth of the way on; each box is asked for a little more than its part."""
    line = Line()
    boxes, joints, noted, ends = chain(monkeypatch, line, way)
    side = way / 16.0
    centers = [700.0 + side * place for place in CENTERS]
    cuts = [700.0 + side * place for place in CUTS]
    widths = [b - a for a, b in zip([0.0, *CUTS], [*CUTS, 16.0], strict=True)]
    assert [half for _, half in line.wide] == pytest.approx([1.01 * w / 2.0 for w in widths])
    assert [numbers(box.middle)[2] for box in boxes] == pytest.approx(centers)
    assert [numbers(box.middle)[2] for box in joints] == pytest.approx([700.0, *cuts, 700.0 + way])
    assert (joints[0], joints[-1]) == (ends[0].exact, ends[1].beside)
    assert line.narrow == pytest.approx(cuts)
    # the guess of the first one is the end itself, of the others on the line of the box before
    guesses = [guess for guess, _ in line.wide]
    assert guesses[0] == pytest.approx([1.0, 2.0, centers[0]])
    for guess, center in zip(guesses[1:], centers[1:], strict=True):
        assert guess == pytest.approx(
            [1.0 + (center - 700.0) / 2, 2.0 - (center - 700.0) / 4, center]
        )
    assert noted.stable == [(line, box, "stable") for box in boxes]
    assert noted.labels == boxes
    assert line.admitted == pytest.approx(centers)
    assert noted.work == [2] * 6
    before = [None, *boxes[:-1]]
    assert noted.shared == list(zip(joints[:-1], boxes, before, strict=True))


def test_a_chain_has_the_boxes_about_the_events_at_its_ends(monkeypatch):
    """It begins and stops at the orbits beside them, and has the joints of both."""
    flat = [box_at(p, 1.0, lean=(0.0, 0.0)) for p in (700.0, 716.0)]
    line = Line()
    boxes, joints, noted, (start, stop) = chain(monkeypatch, line, around=flat)
    assert (boxes[0], boxes[-1]) == tuple(flat)
    assert joints[:2] == [start.exact, start.beside]
    assert joints[-2:] == [stop.beside, stop.exact]
    assert len(joints) == len(boxes) + 1
    assert line.wide[0][0] == pytest.approx([1.25, 1.875, 700.5 + 15.0 / 32.0])
    assert noted.shared[0] == (start.beside, boxes[1], flat[0])
    assert numbers(boxes[-2].middle)[2] + line.wide[-1][1] / 1.01 == pytest.approx(715.5)


def test_a_box_that_fails_is_tried_with_half_its_width(monkeypatch):
    """The next one may be half as wide again; tries are counted, whether they fail or not."""
    line = Line(fails=lambda number, half: number in (1, 3))
    boxes, joints, noted, _ = chain(monkeypatch, line, way=4.0, most_boxes=40)
    tried = [half / 1.01 * 2.0 for _, half in line.wide]
    assert tried[:6] == pytest.approx([0.25, 0.125, 0.1875, 0.09375, 0.140625, 0.2109375])
    assert len(boxes) == len(line.wide) - 2 == len(joints) - 1
    assert noted.work == [2] * len(line.wide)
    assert [numbers(box.middle)[2] - 700.0 for box in boxes[:3]] == pytest.approx(
        [0.0625, 0.171875, 0.2890625]
    )


@pytest.mark.parametrize(
    ("most", "failing", "tries"),
    [
        (12, 0, None),  # six boxes are enough for 1 + 16/1 in steps that grow with the distance
        (13, 0, None),
        (11, 0, 4),  # 5 log(9.125)/log(17) is less than 4
        (10, 0, 4),
        (20, 1, 2),  # a fifth of ten may be tried at first
        (21, 5, 2),
        (22, 5, 3),  # of eleven
        (30, 5, 3),
    ],
)
def test_a_chain_ends_where_too_many_boxes_are_needed(monkeypatch, most, failing, tries):
    """For two impacts half as many are allowed as for one, in step with the way that is done."""
    line = Line(fails=lambda number, half: number <= failing)
    if tries is None:
        boxes, *_ = chain(monkeypatch, line, most_boxes=most)
        assert len(boxes) == 6
        return
    with pytest.raises(NotProvedError) as refused:
        chain(monkeypatch, line, most_boxes=most)
    assert refused.value.step == ProofStep.BOXES
    assert len(line.wide) == tries


@pytest.mark.parametrize("refusing", ["box", "admissible", "stability", "label", None])
def test_each_box_of_a_branch_is_one_of_motions_with_its_label(monkeypatch, refusing):
    """Each thing that is asked of it may refuse it."""
    asked = []

    def ask(name, *of):
        asked.append((name, *of))
        if name == refusing:
            raise NotProvedError(ProofStep.GRAZES)

    def box(guess, fixed, half):
        ask("box", guess, fixed, float(half))
        return made

    made = box_at(700.0, 2.0)
    shooting = Stub(box=box, admissible=lambda hull: ask("admissible", numbers(hull)))
    monkeypatch.setattr(proofs, "_prove_stability", lambda *of: ask("stability", *of))
    for half in (arb(2), arb(-2)):
        asked.clear()
        of = shooting, "guess", 5, half, True, lambda of_box: ask("label", of_box)
        if refusing is None:
            assert proofs._box_of_branch(*of) is made
        else:
            with pytest.raises(NotProvedError):
                proofs._box_of_branch(*of)
        wanted = [
            ("box", "guess", 5, 2.02), ("admissible", [1.0, 2.0, 700.0]),
            ("stability", shooting, made, True), ("label", made),
        ]  # fmt: skip
        names = [name for name, *_ in wanted]
        count = len(names) if refusing is None else names.index(refusing) + 1
        assert sorted(asked, key=lambda one: names.index(one[0])) == wanted[:count] or (
            refusing is not None and asked[-1][0] == refusing
        )


def test_a_joint_is_an_orbit_of_the_boxes_on_both_sides():
    joint = box_at(701.0)
    holds = [box_at(700.0, 1.0, 1e-9), box_at(702.0, 1.0, 1e-9)]
    away = [box_at(699.5, 1.0, 1e-9), box_at(702.0, 1.0, 1e-9, lean=(0.5, -0.2))]
    proofs._prove_shared(joint, holds[0], None)
    proofs._prove_shared(joint, *holds)
    for pair in (
        (away[0], holds[1]), (holds[0], away[1]), (away[1], holds[0]), (holds[0], away[0]),
        (away[0], None),
    ):  # fmt: skip
        with pytest.raises(NotProvedError) as refused:
            proofs._prove_shared(joint, *pair)
        assert refused.value.step == ProofStep.SINGULAR


@pytest.mark.parametrize("around", [None, "around"])
def test_a_chain_is_closed_where_its_last_box_holds_the_end(around):
    stop = End("", box_at(702.0), box_at(701.0), around)
    for last, closes in ((box_at(700.0, 1.0, 1e-9), True), (box_at(699.9, 1.0, 1e-9), False)):
        boxes, joints = ["first", last], ["joint"]
        if not closes:
            with pytest.raises(NotProvedError) as refused:
                proofs._close_chain(boxes, joints, stop)
            assert refused.value.step == ProofStep.SINGULAR
            continue
        proofs._close_chain(boxes, joints, stop)
        assert boxes == ["first", last, *([around] if around else [])]
        assert joints == ["joint", stop.beside, *([stop.exact] if around else [])]


# -- ranges


def ranges(monkeypatch, events=(), refused=(), **roots):
    """The ranges of a section of five points, each end of which may be at an event or refused."""
    values = (700.0, 702.0, 704.0, 706.0, 708.0)
    points = [
        Stub(root=roots.get(f"of_{k}", f"root {k}"), value=value, label=f"P({k})", stable=k == 2)
        for k, value in enumerate(values)
    ]
    noted = Stub(labels=[], chains=[], shooting=[], about=[])

    def ends_at(root, where):
        if root in refused:
            raise NotProvedError(ProofStep.PASSES)
        return End(root, f"exact {root}", f"beside {root}", where)

    def label(made, box, strobe, of):
        noted.labels.append((made, box, strobe, of))
        if box in refused:
            raise NotProvedError(ProofStep.STROBE)

    def about(made, root, inner, event, stable):
        noted.about.append((made, root, inner, event, stable))
        return ends_at(root, f"around {root}")._replace(event=event)

    def chain(*of):
        noted.chains.append(of)
        of[5]("a box")
        return ["b"] * 3, ["j"] * 4

    monkeypatch.setattr(
        proofs, "shooting_of", lambda *of: (noted.shooting.append(of), "shooting")[1]
    )
    monkeypatch.setattr(proofs, "_plain", lambda made, root: End(root, f"exact {root}", "beside"))
    monkeypatch.setattr(proofs, "_about", about)
    monkeypatch.setattr(proofs, "prove_label", label)
    monkeypatch.setattr(proofs, "_chain", chain)
    monkeypatch.setattr(proofs, "_leaning", lambda roots: ("leaning", tuple(roots)))
    monkeypatch.setattr(proofs, "_event_at", lambda point, given: given.get(points.index(point)))
    made = list(proofs._ranges(
        lambda **more: more, Stub(strobe=0.25), points, dict(events)
    ))  # fmt: skip
    return made, noted


def test_a_section_without_events_is_one_range_from_its_first_point_to_its_last(monkeypatch):
    (whole,), noted = ranges(monkeypatch)
    assert noted.shooting == [(Stub(strobe=0.25), "root 2")]
    ((shooting, start, stop, leaning, stable, _),) = noted.chains
    assert (shooting, start.text, stop.text, stable) == ("shooting", "root 0", "root 4", True)
    assert leaning == ("leaning", tuple(f"root {k}" for k in range(5)))
    assert [box for _, box, *_ in noted.labels] == ["exact root 0", "exact root 4", "a box"]
    assert {(made, strobe, of) for made, _, strobe, of in noted.labels} == {
        ("shooting", 0.25, "P(2)")
    }
    evidence = whole.pop("evidence")
    assert whole == {"low": "root 0", "high": "root 4", "boxes": 3}
    assert (evidence.bits, evidence.shooting) == (120, "shooting")
    assert (evidence.boxes, evidence.joints) == (("b",) * 3, ("j",) * 4)
    assert evidence.ends == (None, None)


def test_an_event_at_an_end_has_a_box_about_it(monkeypatch):
    """Seen from its neighbour; one that was not located is none."""
    first, last = Stub(located="fold"), Stub(located="doubling")
    (whole,), noted = ranges(monkeypatch, {0: first, 4: last})
    assert noted.about == [
        ("shooting", "root 0", "root 1", "fold", True),
        ("shooting", "root 4", "root 3", "doubling", True),
    ]
    assert [box for _, box, *_ in noted.labels] == ["around root 0", "around root 4", "a box"]
    assert whole["evidence"].ends == ("fold", "doubling")
    (whole,), noted = ranges(monkeypatch, {0: Stub(located=None), 4: last})
    assert [root for _, root, *_ in noted.about] == ["root 4"]
    assert whole["evidence"].ends == (None, "doubling")


@pytest.mark.parametrize(("events", "refused", "step"), [
    ({0: Stub(located="fold"), 4: Stub(located="doubling")}, ("root 0", "root 4"),
     ProofStep.PASSES),
    ({}, ("exact root 0", "exact root 4"), ProofStep.STROBE),
])  # fmt: skip
@pytest.mark.parametrize("which", [(0,), (1,), (0, 1)])
def test_an_end_that_is_refused_is_left_to_a_range_of_its_own(
    monkeypatch, events, refused, step, which
):
    found, noted = ranges(monkeypatch, events, [refused[k] for k in which])
    ((_, start, stop, *_),) = noted.chains
    assert start.text == ("root 1" if 0 in which else "root 0")
    assert stop.text == ("root 3" if 1 in which else "root 4")
    left = ({"low": "700.0", "high": "702.0"}, {"low": "706.0", "high": "708.0"})
    assert found[1:] == [{**left[k], "failed_step": step} for k in which]
    assert (found[0]["low"], found[0]["high"]) == (start.text, stop.text)


def test_a_section_whose_points_have_no_roots_is_not_asked(monkeypatch):
    for name in ("of_0", "of_3"):
        with pytest.raises(NotProvedError) as refused:
            ranges(monkeypatch, **{name: None})
        assert refused.value.step == ProofStep.MODEL


# -- boxes about events


def root_of(x, whole, **more):
    return Stub(x=list(x), theta=list(x[:-1:2]), whole=whole, count=len(whole) // 2, **more)


@pytest.mark.parametrize(("kind", "fixed"), [
    (Kind.PERIOD_DOUBLING, 4), (Kind.FOLD, 3), (Kind.CORNER_IMPACT, 4), (Kind.GRAZING, 4),
])  # fmt: skip
@pytest.mark.parametrize("other_side", [False, True])
@pytest.mark.parametrize("inner", [9.0, -9.0])
def test_a_box_about_an_event_is_of_that_event_at_the_root(
    monkeypatch, kind, fixed, other_side, inner
):
    """At a fold the rate of the second impact is given, which changes most along the branch."""
    at_root = root_of([1.0, 2.0, 4.0, 5.0, 700.0], (0, 0, 3, 1), tangent=[1, -2, 3, -4, 9])
    at_event = root_of([1.0, 2.0, 4.0, 5.0, 700.0], (0, 0, 2 if other_side else 3, 1))
    located = Located(kind, at_event, 0.5, 0.0, Bracket.OK, impact=1, side=1, phase=4.5)
    there = list(at_root.x)
    there[fixed] += inner
    asked = Stub(tests=[], admitted=[], proved=[])
    monkeypatch.setattr(proofs, "_test", lambda made, event: (asked.tests.append(event), "test")[1])
    monkeypatch.setattr(proofs, "_admit", lambda made, hull, event: asked.admitted.append(event))
    for name in ("_prove_stability", "_prove_other_inside"):
        monkeypatch.setattr(
            proofs, name, lambda made, box, of, name=name: asked.proved.append((name, of))
        )
    zeros, narrow = [], []

    def box(guess, half):
        middle = [arb(x) for x in guess]
        tangent = [arb(k) for k in range(4)] + [arb(0.25)]
        tangent[fixed] = arb(1)
        errors = [arb(0)] * 5
        return Box(middle, tangent, errors, fixed, arb(half), errors, arb_mat(1, 1))

    def zero(guess, given, test, width):
        zeros.append((numbers(guess), given, test, float(width)))
        return box(at_root.x, 0), box(at_root.x, width)

    shooting = Stub(
        zero=zero, box=lambda guess, given: narrow.append((numbers(guess), given)) or "beside"
    )
    end = proofs._about(shooting, at_root, Stub(x=there), located, "stable")
    assert zeros == [(at_root.x, fixed, "test", pytest.approx(2.7))]
    side = -1 if other_side else 1
    event = replace(located, root=at_root, side=side)
    assert asked.tests == asked.admitted == [event]
    multiplier = kind in (Kind.PERIOD_DOUBLING, Kind.FOLD)
    assert asked.proved == [
        ("_prove_other_inside", kind) if multiplier else ("_prove_stability", "stable")
    ]
    way = 1.35 if inner > 0.0 else -1.35
    tangent = [0.0, 1.0, 2.0, 3.0, 0.25]
    tangent[fixed] = 1.0
    beside = [x + way * t for x, t in zip(at_root.x, tangent, strict=True)]
    assert narrow == [(pytest.approx(beside), fixed)]
    assert float(arb(end.text)) == 700.0
    assert (end.beside, end.event, float(end.around.half)) == ("beside", event, pytest.approx(2.7))
    assert float(end.exact.half) == 0.0


@pytest.mark.parametrize(("kind", "trace", "det", "inside"), [
    (Kind.PERIOD_DOUBLING, -1.9, 0.5, True), (Kind.PERIOD_DOUBLING, 1.4, 0.5, True),
    (Kind.PERIOD_DOUBLING, 1.6, 0.5, False), (Kind.PERIOD_DOUBLING, -1.9, 1.1, False),
    (Kind.FOLD, 1.9, 0.5, True), (Kind.FOLD, -1.4, 0.5, True), (Kind.FOLD, -1.6, 0.5, False),
    (Kind.FOLD, 1.9, 1.1, False),
])  # fmt: skip
def test_the_other_multiplier_stays_inside_about_an_event(kind, trace, det, inside):
    shooting = Stub(trace_det=lambda z: (arb(trace), arb(det)) if z == "hull" else None)
    box = Stub(hull=lambda: "hull")
    if inside:
        proofs._prove_other_inside(shooting, box, kind)
        return
    with pytest.raises(NotProvedError) as refused:
        proofs._prove_other_inside(shooting, box, kind)
    assert refused.value.step == ProofStep.NEUTRAL


# -- events


@pytest.mark.parametrize("kind", [Kind.CORNER_IMPACT, Kind.GRAZING, Kind.FOLD])
def test_an_event_is_a_motion_but_for_what_it_is(kind):
    asked = []

    def touch(hull, k, s):
        assert (hull, k, float(s)) == ("hull", 1, pytest.approx(0.5))
        return "place", "angle"

    shooting = Stub(admissible=lambda *of: asked.append(of), touch=touch)
    located = Located(kind, Stub(theta=[1.0, 4.0]), 0.0, 0.0, Bracket.OK, impact=1, phase=4.5)
    proofs._admit(shooting, "hull", located)
    corner = (1,) if kind == Kind.CORNER_IMPACT else ()
    of_touch = Touch(flight=1, angle="angle") if kind == Kind.GRAZING else None
    assert asked == [("hull", corner, of_touch)]


@pytest.mark.parametrize("in_cam", [False, True])
@pytest.mark.parametrize("side", [1, -1])
def test_a_corner_is_that_of_the_cam_at_the_parameter(in_cam, side):
    """The cam itself may change with it."""
    of_cam = [Stub(start=9.0, end=9.0), Stub(start=3.5, end=4.25)]
    moved = [Stub(start=9.0, end=9.0), Stub(start=3.0, end=4.5)]
    shooting = Stub(
        in_cam=in_cam, stretches=of_cam, places=[Place(0, 0), Place(1, 2)],
        machine=lambda p: Stub(stretches=moved) if p == 700.0 else None,
    )  # fmt: skip
    located = Located(
        Kind.CORNER_IMPACT, Stub(theta=[1.0, 4.0]), 0.0, 0.0, Bracket.OK, impact=1, side=side
    )
    stretch = (moved if in_cam else of_cam)[1]
    edge = stretch.end if side > 0 else stretch.start
    assert proofs._test(shooting, located)([1.0, 2.0, 4.0, 5.0, 700.0]) == 4.0 - edge


def test_the_function_of_an_event_is_that_of_its_kind():
    shooting = Stub(
        trace_det=lambda z: (z[0], z[1]),
        touch=lambda middles, k, s: (("place", middles, k), s + 0.25),
        machine=lambda p: ("machine", p),
        gap=lambda machine, z, k, place: lambda s: [(machine, z, k, place, float(s)), "slope"],
    )  # fmt: skip
    known = Stub(theta=[1.0, 4.0])
    for kind, value in ((Kind.PERIOD_DOUBLING, 1.75), (Kind.FOLD, 0.75)):
        event = Located(kind, known, 0.0, 0.0, Bracket.OK)
        assert proofs._test(shooting, event)([0.5, 0.25]) == value
    graze = Located(Kind.GRAZING, known, 0.0, 0.0, Bracket.OK, impact=1, phase=4.5)
    z = [(1.5, 9.0), (2.5, 9.0), (700.0, 9.0)]
    middles = [1.5, 2.5, 700.0]
    assert proofs._test(shooting, graze)(z) == (
        ("machine", z[-1]), z, 1, ("place", middles, 1), 0.75
    )  # fmt: skip
    for impact in (0, 1):
        with pytest.raises(NotProvedError) as refused:
            proofs._test(shooting, replace(graze, fading=impact))
        assert refused.value.step == ProofStep.MODEL


def test_the_value_of_an_event_lies_between_doubles_around_it():
    proof = proofs._enclosed(arb(0.75, 2.0**-80), ("a", "b"))
    assert proof.box == ("a", "b")
    assert proof.proved
    assert (proof.low, proof.high) == (nextafter(0.75, -inf), nextafter(0.75, inf))
    exact = proofs._enclosed(arb(700), ())
    assert (exact.low, exact.high) == (nextafter(700.0, -inf), nextafter(700.0, inf))
    assert arb(proof.value).contains(arb(0.75))
    assert len(proof.value) > 20


@pytest.mark.parametrize(("side", "stretch", "kink"), [
    (1, 0, True), (1, 1, False), (1, 2, False), (-1, 0, False), (-1, 1, True), (-1, 2, False),
])  # fmt: skip
def test_a_kink_is_where_the_stretch_behind_the_corner_begins_with_a_jump(side, stretch, kink):
    """Of three stretches the second one does; behind the last one comes the first."""
    cam = Stub(stretches=[Stub(slope_jump=jump) for jump in (0.0, -0.5, 0.0)])
    root = Stub(machine="machine", stretch=lambda k: (9, stretch)[k])
    system = Stub(at=lambda machine: Stub(cam=cam) if machine == "machine" else None)
    located = Located(Kind.CORNER_IMPACT, root, 0.0, 0.0, Bracket.OK, impact=1, side=side)
    assert proofs._at_kink(system, located) is kink


@pytest.mark.parametrize(("side", "stretch", "turn", "beside"), [
    (1, 0, 4, Place(1, 4)), (1, 2, 4, Place(0, 5)), (-1, 2, 4, Place(1, 4)),
    (-1, 0, 4, Place(2, 3)),
])  # fmt: skip
@pytest.mark.parametrize(("here", "there", "signs"), [
    ((0.5, 0.25), (2.0, 0.5), (-1, 1)), ((0.5, 0.25), (-2.0, 0.5), (1, -1)),
    ((3.0, 0.25), (2.0, 0.5), (1, 1)), ((0.5, 0.5), (1.5, 0.5), (0, 1)),
    ((-1.5, 0.5), (0.5, 0.25), (1, 0)), ((-3.0, 0.25), (-3.0, 3.0), (1, -1)),
])  # fmt: skip
def test_the_signs_of_a_corner_impact_are_of_both_its_sides(
    side, stretch, turn, beside, here, there, signs
):
    """(1 - trace + det) of one times that of the other, and (1 + trace + det)."""
    places = (Place(7, 7), Place(stretch, turn))

    class Sides(proofs.Shooting):
        stretches = [1, 2, 3]  # noqa: RUF012

        def trace_det(self, z):
            assert (z, self.places[0]) == ("hull", places[0])
            known = {places[1]: here, beside: there}[self.places[1]]
            return [arb(x) for x in known]

    shooting = Sides("shape", "follower", 700.0, "rpm", places, 6)
    located = Located(
        Kind.CORNER_IMPACT, Stub(theta=[1.0, 4.0]), 0.0, 0.0, Bracket.OK, impact=1, side=side
    )
    found = proofs._corner_signs(shooting, "hull", located)
    assert found == ((Rule.PRODUCT_AT_ONE, signs[0]), (Rule.PRODUCT_AT_MINUS_ONE, signs[1]))


# -- sections of a branch


def point_at(value, whole=(0, 0), theta=(1.0,), root=True, label="P(1;1)", stable=True):
    made = Stub(whole=whole, theta=list(theta), count=len(theta), machine="machine",
                stretch=lambda k: whole[2 * k])  # fmt: skip
    return Stub(value=value, root=made if root else None, label=label, stable=stable)


def sections_of(*points, events=()):
    """The values in each section."""
    branch = Stub(points=list(points))
    return [[one.value for one in part] for part in proofs._sections(branch, events)]


def event_on(point, **more):
    return Stub(value=point.value, located=Stub(root=point.root), **more)


def test_sections_are_cut_at_events_and_where_an_impact_passes_the_end_of_a_stretch():
    """Each has three points or more, rising; one that turns round, or has few, is left out."""
    points = [point_at(value) for value in (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)]
    values = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
    assert sections_of(*points) == [values]
    assert sections_of(*points[::-1]) == [values]
    for k in (2, 3):
        assert sections_of(*points, events=[event_on(points[k])]) == [
            part for part in (values[: k + 1], values[k:]) if len(part) > 2
        ]
    assert sections_of(*points, events=[event_on(points[1])]) == [values[1:]]
    for k in (0, 5):  # an event at an end of the branch cuts nothing off
        assert sections_of(*points, events=[event_on(points[k])]) == [values]
    behind = [point_at(value, whole=(1, 0)) for value in (7.0, 8.0, 9.0)]
    assert sections_of(*points, *behind) == [values, [7.0, 8.0, 9.0]]
    assert sections_of(*points[:3], *behind[:2]) == [[1.0, 2.0, 3.0]]
    assert sections_of(*points[:2], *behind) == [[7.0, 8.0, 9.0]]
    turned = [point_at(value) for value in (1.0, 3.0, 2.0, 4.0)]
    assert sections_of(*turned) == sections_of(*turned[::-1]) == []
    assert sections_of(*points[:2]) == []
    assert sections_of(*points[:3]) == [[1.0, 2.0, 3.0]]


def test_points_without_a_root_are_in_no_section():
    """Such as those of an orbit that rests, before or behind the others."""
    rests = [point_at(value, root=False) for value in (-1.0, 0.0)]
    points = [point_at(value) for value in (1.0, 2.0, 3.0)]
    assert sections_of(*rests, *points) == [[1.0, 2.0, 3.0]]
    assert sections_of(*rests) == []


def test_an_event_is_at_a_point_with_its_value_and_its_impacts():
    """The value to 1e-11 of it, every phase to 1e-6 rad; one that was not located is at none."""
    for value in (700.0, -0.01):
        point = point_at(value, theta=(1.0, 4.0))
        size = abs(value)
        for off, is_there in ((0.9e-11, True), (-0.9e-11, True), (1.1e-11, False)):
            event = event_on(point_at(value + off * size, theta=(1.0, 4.0)))
            found = proofs._event_at(point, [event])
            assert found is (event if is_there else None)
    point = point_at(700.0, theta=(1.0, 4.0))
    for theta, is_there in (
        ((1.0 + 0.9e-6, 4.0 - 0.9e-6), True), ((1.0 + 1.1e-6, 4.0), False),
        ((1.0, 4.0 - 1.1e-6), False), ((1.0, 4.0, 5.0), False), ((1.0,), False),
    ):  # fmt: skip
        other = event_on(point_at(700.0, theta=theta))
        known = event_on(point)
        assert proofs._event_at(point, [other]) is (other if is_there else None)
        assert proofs._event_at(point, [other, known]) is (other if is_there else known)
    assert proofs._event_at(point, [Stub(value=700.0, located=None)]) is None
    assert proofs._event_at(point_at(700.0, root=False), [event_on(point)]) is None


def test_points_at_either_end_of_a_stretch_are_left_out_where_an_impact_passes_it():
    """The impact of a pair that passes, at the start or the end of its own stretch, to 1e-6 rad."""
    cam = Stub(stretches=[Stub(start=0.0, end=2.0), Stub(start=2.0, end=5.0)])
    system = Stub(at=lambda machine: Stub(cam=cam) if machine == "machine" else None)
    for off, is_left in ((0.9e-6, True), (1.1e-6, False)):
        points = (
            point_at(1.0, (0, 0, 1, 0), (1.0, 2.0 + off)),  # at an end, but no neighbour passes it
            point_at(2.0, (0, 0, 1, 0), (1.9, 4.0)),
            point_at(3.0, (0, 0, 1, 0), (2.0 - off, 4.0)),
            point_at(4.0, (1, 0, 1, 0), (2.0 + off, 4.0)),
            point_at(5.0, (1, 0, 1, 0), (2.1, 4.0)),
            point_at(6.0, (1, 0, 1, 0), (2.2, 5.0 - off)),
            point_at(7.0, (1, 0, 0, 0), (2.3, off)),
        )
        found = proofs._off_the_ends(system, branch_of(points), [])
        left = {3.0, 4.0, 6.0, 7.0} if is_left else set()
        assert [point.value for point in found.points] == [
            point.value for point in points if point.value not in left
        ]


def branch_of(points):
    return Branch(7, "found", tuple(points), ("lost", "lost"))


def test_what_passes_an_end_is_named_after_the_point_before_it(monkeypatch):
    before, behind = point_at(1.0, label="P(1;1)"), point_at(2.0, label="P(1;2)", stable=False)
    monkeypatch.setattr(proofs, "_off_the_ends", lambda system, branch, events: branch)
    monkeypatch.setattr(proofs, "_sections", lambda branch, events: [])
    monkeypatch.setattr(proofs, "_passings", lambda branch, events: [(before, behind)])
    (part,) = proofs.prove_ranges("system", Stub(number=7), [])
    assert (part.label, part.stable, part.low, part.high) == ("P(1;1)", True, "1.0", "2.0")


# -- an event that was located


@pytest.mark.parametrize("at_kink", [False, True])
@pytest.mark.parametrize("kind", [Kind.CORNER_IMPACT, Kind.FOLD])
@pytest.mark.parametrize(
    "signs",
    [
        ((Rule.PRODUCT_AT_ONE, 1), (Rule.PRODUCT_AT_MINUS_ONE, -1)),
        ((Rule.PRODUCT_AT_ONE, 1), (Rule.PRODUCT_AT_MINUS_ONE, 0)),
    ],
)
@pytest.mark.parametrize("off", [0.0, 2e-9])
def test_an_event_agrees_with_what_was_found_and_has_the_signs_of_its_corner(
    monkeypatch, kind, at_kink, signs, off
):
    """The signs are asked for at a corner without a kink; each must be told."""
    root = root_of([1.0, 2.0, 700.0], (0, 0), tangent=[1.0, 2.0, 3.0])
    located = Located(kind, root, 0.0, 0.0, Bracket.OK, impact=0, side=1)
    event = Stub(kind=kind, value=700.0 + off, error=1e-9, orbit=Stub(label="P(1;1)"))
    monkeypatch.setattr(proofs, "shooting_of", lambda *of: shooting)
    monkeypatch.setattr(proofs, "_test", lambda *of: "test")
    monkeypatch.setattr(proofs, "_admit", lambda *of: None)
    monkeypatch.setattr(proofs, "prove_label", lambda *of: None)
    monkeypatch.setattr(proofs, "_at_kink", lambda *of: at_kink)
    monkeypatch.setattr(proofs, "_corner_signs", lambda *of: signs)
    shooting = Stub(zero=lambda guess, fixed, test: (box_at(700.0), "box"))
    asks = kind == Kind.CORNER_IMPACT and not at_kink
    step = None
    if off > 1e-9:  # of 7e-9, which is trusted, and of its own error
        event = Stub(**{**vars(event), "value": 700.0 + 1e-8})
        step = ProofStep.NUMBER
    elif asks and signs[1][1] == 0:
        step = ProofStep.CROSSING
    if step is not None:
        with pytest.raises(NotProvedError) as refused:
            proofs._located(Stub(strobe=0.25), event, located)
        assert refused.value.step == step
        return
    proof = proofs._located(Stub(strobe=0.25), event, located)
    assert proof.signs == (signs if asks else ())
    assert proof.low < 700.0 < proof.high
    assert [float(arb(x)) for x in proof.box] == [1.0, 2.0]
    assert proof.evidence.ends == (located,)


@pytest.mark.parametrize("slope", [0.5, 0.0])
def test_an_impact_that_fades_has_no_rate_and_the_parameter_changes_with_that(monkeypatch, slope):
    root = root_of([1.0, 2.0, 4.0, 1e-9, 700.0], (0, 0, 1, 0))
    located = Located(Kind.GRAZING, root, 0.0, 0.0, Bracket.OK, impact=1, fading=1)
    event = Stub(kind=Kind.GRAZING, value=700.0, error=1e-9)
    asked = []

    def box(guess, fixed):
        asked.append((numbers(guess), fixed))
        return Stub(hull=lambda: [arb(x) for x in (1.5, 2.5, 4.5, 0.0, 700.0)])

    def along(hull, fixed):
        assert (numbers(hull)[-1], fixed) == (700.0, 3)
        return [arb_series([9, 9], 2), arb_series([700, arb(slope, 0.25)], 2)]

    shooting = Stub(
        box=box, along=along,
        admissible=lambda hull, fading: asked.append((numbers(hull), fading)),
    )  # fmt: skip
    monkeypatch.setattr(proofs, "shooting_of", lambda *of: shooting)
    if slope == 0.0:
        with pytest.raises(NotProvedError) as refused:
            proofs._located(Stub(strobe=0.25), event, located)
        assert refused.value.step == ProofStep.CROSSING
    else:
        proof = proofs._located(Stub(strobe=0.25), event, located)
        assert [float(arb(x)) for x in proof.box] == [1.5, 2.5, 4.5, 0.0]
        assert (proof.signs, proof.evidence) == ((), None)
        assert proof.low < 700.0 < proof.high
    assert asked == [([1.0, 2.0, 4.0, 0.0, 700.0], 3), ([1.5, 2.5, 4.5, 0.0, 700.0], 1)]


@pytest.mark.parametrize("side", [1, -1])
def test_the_bracket_of_a_change_is_widened_until_both_its_ends_are_decided(monkeypatch, side):
    """On one side of 700 nothing can be decided up to 1e-7 away; four of 1e-9 are tried first."""
    tried = []

    def keeps(system, parameter, orbit, p, kind):
        assert (system, parameter, orbit, kind) == ("system", "mass", "orbit", "kind")
        off = side * float(p - 700)
        tried.append(off)
        if 0.0 <= off <= 1e-7:
            raise UndecidedError
        return off < 0.0

    monkeypatch.setattr(proofs, "_keeps", keeps)
    event = Stub(value=700.0, error=1e-9, orbit="orbit", kind="kind")
    with pytest.raises(NotProvedError) as refused:  # the ends are too far from the event then
        proofs._change("system", event, "mass")
    assert refused.value.step == ProofStep.NUMBER
    widths = [4e-9 * 4.0**k for k in range(4)]
    assert sorted(map(abs, tried[:8])) == pytest.approx(sorted([*widths, *widths]), rel=1e-3)
