"""Of what a certificate has a statement, and which entries that has, with parts made by hand."""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import replace
from fractions import Fraction
from types import SimpleNamespace as Stub

import pytest
from flint import arb, arb_mat, ctx

from camcli.analysis.border_collision import Rule
from camcli.analysis.orbits import certificate
from camcli.analysis.orbits.curve_proofs import CurveRange
from camcli.analysis.orbits.evidence import Evidence
from camcli.analysis.orbits.kinds import Bracket, Kind
from camcli.analysis.orbits.locate import Located
from camcli.analysis.orbits.proofs import Proof, Range
from camcli.cams.balls import UndecidedError
from camcli.exact.shooting import Box, NotProvedError, Place, ProofStep
from camcli.system import Follower


@pytest.fixture(autouse=True)
def many_bits():
    before, ctx.prec = ctx.prec, 200
    yield
    ctx.prec = before


def evidence_of(name="e", ends=(None, None)) -> Evidence:
    return Evidence(200, f"shooting of {name}", (f"box of {name}",), (), ends)


def located(kind, impact=1, side=-1):
    return Located(kind, "root", 0.0, 0.0, Bracket.OK, impact=impact, side=side)


# -- what is proved


def test_what_was_proved_has_its_claims():
    """Orbits and their attraction, events of three kinds, and ranges between such events."""
    axes = ((0.5, 0.25, -0.125, 2.0),)
    proofs_of_orbits = [
        Proof(evidence=evidence_of("a"), axes=axes), Proof(evidence=evidence_of("b")),
        Proof(ProofStep.GRAZES, evidence=evidence_of("c")), Proof(),
        Proof(axes=axes),
    ]  # fmt: skip
    orbits = [Stub(label=f"P({k})", stable=k != 1) for k in range(5)]
    kinds = [Kind.FOLD, Kind.PERIOD_DOUBLING, Kind.CORNER_IMPACT, Kind.GRAZING, Kind.FOLD]
    events = [Stub(kind=kind, orbit=Stub(label=f"E({k})")) for k, kind in enumerate(kinds)]
    signs = ((Rule.PRODUCT_AT_ONE, 1), (Rule.PRODUCT_AT_MINUS_ONE, -1))
    proofs_of_events = [
        Proof(evidence=evidence_of(str(k)), value=f"[{k} +/- 0.25]", signs=signs) for k in range(4)
    ]
    proofs_of_events.append(Proof(ProofStep.GRAZES, evidence=evidence_of("4")))
    known, graze = located(Kind.FOLD), located(Kind.GRAZING)
    ends = [(None, None), (known, None), (None, known), (graze, None), (known, graze)]
    ranges = [
        Range(7, f"R({k})", k != 1, "1.5", "[2 +/- 0.25]", evidence=evidence_of(f"r{k}", of))
        for k, of in enumerate(ends)
    ]
    ranges.append(Range(7, "R(5)", True, "1", "2", failed_step=ProofStep.BOXES))
    ranges.append(Range(7, "R(6)", True, "1", "2"))
    study = Stub(orbits=orbits, bifurcations=events)
    proofs = Stub(orbits=proofs_of_orbits, events=proofs_of_events, ranges=ranges)
    found = list(certificate._proved(study, proofs))
    orbit = [
        (orbits[k], proofs_of_orbits[k].evidence,
         {"kind": "orbit", "label": f"P({k})", "stable": k != 1})
        for k in (0, 1, 3, 4)
    ]  # fmt: skip
    texts = [["0.5", "0.25", "-0.125", "2"]]
    attracts = (orbits[0], replace(evidence_of("a"), axes=axes),
                {"kind": "attractor", "label": "P(0)", "axes": texts})  # fmt: skip
    assert [tuple(one) for one in found[:5]] == [orbit[0], attracts, *orbit[1:]]
    assert found[1].evidence.axes == axes
    for k, one in enumerate(found[5:9]):
        assert (one.of, one.evidence) == (
            events[k],
            proofs_of_events[k].evidence if k < 3 else None,
        )
        claims = dict(one.claims)
        assert Fraction(claims.pop("low")) == k - Fraction(1, 2)
        assert Fraction(claims.pop("high")) == k + Fraction(1, 2)
        assert claims == {"kind": "event", "label": f"E({k})", "signs": [1, -1]}
    of_ranges = found[9:]
    assert [one.of.label for one in of_ranges] == ["R(0)", "R(1)", "R(2)", "R(3)", "R(4)", "R(6)"]
    for k, one in enumerate(of_ranges[:5]):
        assert one.evidence is (ranges[k].evidence if k < 3 else None)
        claims = dict(one.claims)
        low, high = (list(map(Fraction, claims.pop(end))) for end in ("low", "high"))
        assert (low, high) == ([1.5, 1.5], [1.5, 2.5])
        assert claims == {"kind": "branch", "label": f"R({k})", "stable": k != 1}
    assert of_ranges[5].evidence is None


@pytest.mark.parametrize("cam", [{"kind": "arcs"}, None])
@pytest.mark.parametrize("all_orbits", ["all", None])
def test_statements_come_in_order_and_what_has_none_is_named(monkeypatch, cam, all_orbits):
    bits = []

    @contextmanager
    def bits_of(evidence):
        bits.append(evidence.bits)
        yield

    made = [
        certificate.Proved(f"of {k}", Stub(bits=100 + k) if k != 1 else None, f"claims {k}")
        for k in range(4)
    ]
    study = Stub(proofs=Stub(curve_ranges="parts", ranges=["b1", "b2"]), curves="curves")
    asked = []

    def statement(evidence, claims, strobe):
        asked.append((evidence.bits, claims, strobe))
        return None if claims == "claims 2" else f"on {claims}"

    def every(of, statements, strobe):
        asked.append((of, list(statements), strobe))
        return all_orbits

    def name(one):
        return f"name {one}"

    def of_curves(*of):
        assert of == ("parts", "curves", cam, 40.0, name)
        return {"statements": ["curve"], "uncovered": ["no curve"]}

    monkeypatch.setattr(certificate, "_bits_of", bits_of)
    monkeypatch.setattr(certificate, "_proved", lambda *of: made if of[0] is study else None)
    monkeypatch.setattr(certificate, "_statement", statement)
    monkeypatch.setattr(certificate, "certificate_of_curves", of_curves)
    monkeypatch.setattr(certificate, "_meetings", lambda branch, strobe: [(branch, strobe)])
    monkeypatch.setattr(certificate, "_all_orbits", every)
    found = certificate.certificate(study, cam, 40.0, name)
    assert (found["format"], found["cam"]) == ("camcli-proof-1", cam)
    names = ["name of 1", "name of 2"] if cam else [f"name of {k}" for k in range(4)]
    assert found["uncovered"] == [*names, "no curve"]
    if cam is None:
        assert (found["statements"], asked, bits) == (["curve"], [], [])
        return
    before = ["on claims 0", "on claims 3", "curve", ("b1", 40.0), ("b2", 40.0)]
    assert found["statements"] == [*before, *([all_orbits] if all_orbits else [])]
    assert bits == [100, 102, 103]
    assert asked == [(100, "claims 0", 40.0), (102, "claims 2", 40.0), (103, "claims 3", 40.0),
                     (study, before, 40.0)]  # fmt: skip


@pytest.mark.parametrize("cam", ["cam", None])
def test_each_part_of_a_curve_that_is_proved_has_a_statement_or_a_name(monkeypatch, cam):
    """With the label of its own curve; one that is not proved is not mentioned."""
    places = ((1.0, 2.0), (3.0, 4.0))
    parts = [
        CurveRange(2, 1, 2, places), CurveRange(1, 3, 4, places, 0, ProofStep.GRAZES, "evidence"),
        CurveRange(1, 5, 6, places), CurveRange(2, 7, 8, places),
    ]  # fmt: skip
    curves = [Stub(label="first"), Stub(label="second")]
    monkeypatch.setattr(
        certificate, "_curve_statement",
        lambda part, label, strobe: None if part.first == 5 else (part.first, label, strobe),
    )  # fmt: skip
    found = certificate.certificate_of_curves(
        parts, curves, cam, 40.0, lambda part: f"part {part.first}"
    )
    assert (found["format"], found["cam"]) == ("camcli-proof-1", cam)
    if cam is None:
        assert (found["statements"], found["uncovered"]) == ([], ["part 1", "part 5", "part 7"])
    else:
        assert found["statements"] == [(1, "second", 40.0), (7, "second", 40.0)]
        assert found["uncovered"] == ["part 5"]


@pytest.mark.parametrize(("orbits", "failure", "stated"), [
    (2, None, True), (1, None, True), (3, None, False), (2, "boxes", False), (None, None, False),
])  # fmt: skip
def test_all_orbits_are_stated_where_each_has_a_statement(orbits, failure, stated):
    follower = Follower(mass=2.0, stiffness=3.0, damping=0.5, gravity=9.5, preload=1.5,
                        restitution=0.75)  # fmt: skip
    covers = [Stub(impacts=1, turns=2, letters="1o.", known=(1,)),
              Stub(impacts=3, turns=4, letters="o", known=(0,))]  # fmt: skip
    every = orbits and Stub(
        orbits=["orbit"] * orbits, failure=failure, follower=follower, covers=covers, impacts=3,
        turns=4,
    )  # fmt: skip
    statements = [{"kind": "orbit", "n": 1}, {"kind": "branch"}, {"kind": "orbit", "n": 2},
                  {"kind": "attractor"}]  # fmt: skip
    study = Stub(every=every, question=Stub(rpm=745.0), value=0.25)
    found = certificate._all_orbits(study, statements, 40.0)
    if not stated:
        assert found is None
        return
    assert found == {
        "kind": "all-orbits",
        "constants": {"rpm": "745", "mass": "2", "stiffness": "3", "damping": "0.5",
                      "gravity": "9.5", "preload": "1.5", "restitution": "0.75"},
        "strobe": "40", "impacts": 3, "turns": 4, "orbits": [statements[0], statements[2]],
        "covers": [{"impacts": 1, "turns": 2, "boxes": "1o.", "orbits": [1]},
                   {"impacts": 3, "turns": 4, "boxes": "o", "orbits": [0]}],
    }  # fmt: skip


# -- a statement


def box_at(value, half=0.0, error=1e-30, fixed=2) -> Box:
    errors = [arb(0, error)] * 3
    return Box([arb(1), arb(2), arb(value)], [arb(0), arb(0), arb(1)], errors, fixed, arb(half),
               errors, arb_mat([[1, 2], [3, 4]]))  # fmt: skip


@pytest.mark.parametrize("kind", ["orbit", "attractor", "event", "meeting", "branch"])
@pytest.mark.parametrize("refusal", [None, UndecidedError, NotProvedError(ProofStep.GRAZES)])
def test_a_statement_has_the_entries_of_its_kind(monkeypatch, kind, refusal):
    """An orbit its range, an event what it is; the flights are of the box as it is written."""
    asked = []

    def about(*of):
        asked.append(of)
        return certificate.About(["base"], {"turns": 7})

    def divided(shooting, hull):
        if refusal is not None:
            raise refusal
        return ["flights", [float(x.rad()) for x in hull]]

    def entries(evidence):
        if refusal is not None:
            raise refusal
        return {"boxes": evidence.bits}

    monkeypatch.setattr(certificate, "_about", about)
    monkeypatch.setattr(certificate, "_flights", divided)
    monkeypatch.setattr(certificate, "_entries_of_branch", entries)
    shooting = Stub(parameter="cam.base")
    first, last = located(Kind.CORNER_IMPACT, 3, -1), located(Kind.FOLD)
    axes = ((0.25, 0.5, 1.0, 2.0),) if kind == "attractor" else ()
    ends = (first, last) if kind == "event" else ()
    evidence = Evidence(200, shooting, (box_at(700.0, 0.125), "other"), (), ends, axes)
    claims = {"kind": "event" if kind == "meeting" else kind, "label": "P(1;1)"}
    if kind == "meeting":
        claims["event"] = "multipliers-meet"
    found = certificate._statement(evidence, claims, 40.0)
    assert asked == [(shooting, ("cam.base",), 40.0)]
    if refusal is not None:
        assert found is None
        return
    assert {key: found[key] for key in ("label", "parameter", "turns")} == {
        "label": "P(1;1)", "parameter": "base", "turns": 7,
    }  # fmt: skip
    assert found["kind"] == claims["kind"]
    if kind == "branch":
        assert found["boxes"] == 200
        assert "box" not in found
        return
    event = {
        "event": {"event": "corner-impact", "impact": 3, "side": -1}, "meeting": "multipliers-meet"
    }.get(kind)  # fmt: skip
    assert found.get("event") == event
    if event is None:
        assert (Fraction(found["low"]), Fraction(found["high"])) == (699.875, 700.125)
    else:
        assert "low" not in found
    flights, rads = found["box"]["flights"]
    assert flights == "flights"
    # the box is wider than it was shown, and one about an event is longer
    is_event = kind in ("event", "meeting")
    assert (Fraction(found["box"]["half"]) > Fraction(1, 8)) is is_event
    wide = (0.25**2 + 0.5**2) ** 0.5, (1.0 + 4.0) ** 0.5
    for rad, axis in zip(rads, wide, strict=False):
        assert rad == pytest.approx(1.01 * axis if kind == "attractor" else 0.0, abs=1e-7)
        assert rad > 1.005e-30


def test_what_has_no_formula_has_no_statement(monkeypatch):
    monkeypatch.setattr(certificate, "_about", lambda *of: None)
    evidence = Evidence(200, Stub(parameter="cam.base"), (box_at(700.0),))
    assert certificate._statement(evidence, {"kind": "orbit"}, 40.0) is None


@pytest.mark.parametrize("ends", [(None, None), ("first", None), (None, "last"), ("first", "last")])
def test_a_branch_has_longer_joints_at_its_events(monkeypatch, ends):
    events = {"first": located(Kind.CORNER_IMPACT, 2, 1), "last": located(Kind.FOLD), None: None}
    known = tuple(events[end] for end in ends)
    joints = [box_at(700.0 + k) for k in range(4)]
    monkeypatch.setattr(
        certificate, "_with_flights",
        lambda evidence, box_at, flights_of: (
            [(box_at, flights_of("hull"))], joints
        ),
    )  # fmt: skip
    monkeypatch.setattr(certificate, "_flights", lambda *of: of)
    shooting = Stub(box="finds")
    found = certificate._entries_of_branch(Evidence(200, shooting, (), (), known))
    assert found["boxes"] == [("finds", (shooting, "hull"))]
    told = {
        "first": {"event": "corner-impact", "impact": 2, "side": 1},
        "last": {"event": "fold", "impact": 0, "side": 0},
        None: None,
    }
    assert found["ends"] == [told[end] for end in ends]
    halves = [float(joint["half"]) for joint in found["joints"]]
    assert [half > 0.0 for half in halves] == [ends[0] is not None, False, False,
                                               ends[1] is not None]  # fmt: skip
    assert [float(joint["middle"][2]) for joint in found["joints"]] == [700.0, 701.0, 702.0, 703.0]


def test_a_statement_leaves_open_what_follows_from_its_numbers(monkeypatch):
    """A number of the cam may have constants of the machine follow from it."""
    follower = Follower(mass=2.0, stiffness=3.0, damping=0.5, gravity=9.5, preload=1.5,
                        restitution=0.75)  # fmt: skip
    shooting = Stub(
        rpm=745.0, follower=follower, turns=3, shape="shape", places=(Place(4, 0), Place(1, 2))
    )
    named = {"cam.base": ("base", set()), "cam.spring": ("load", {"stiffness", "preload"}),
             "cam.seat": ("seat", {"preload", "seat_restitution"}), "cam.none": None}  # fmt: skip
    monkeypatch.setattr(
        certificate, "name_in_formula", lambda shape, key: named[key] if shape == "shape" else None
    )
    every = {"rpm": "745", "mass": "2", "stiffness": "3", "damping": "0.5", "gravity": "9.5",
             "preload": "1.5", "restitution": "0.75"}  # fmt: skip
    for keys, parameters, left_open in (
        (("mass",), ["mass"], {"mass"}), (("rpm",), ["rpm"], {"rpm"}),
        (("cam.base",), ["base"], set()),
        (("cam.spring", "rpm"), ["load", "rpm"], {"stiffness", "preload", "rpm"}),
        (("restitution", "cam.spring"), ["restitution", "load"],
         {"restitution", "stiffness", "preload"}),
    ):  # fmt: skip
        about = certificate._about(shooting, keys, 40.0)
        assert about.parameters == parameters
        assert about.entries == {
            "constants": {key: None if key in left_open else text for key, text in every.items()},
            "turns": 3, "strobe": "40",
            "impacts": [{"stretch": 4, "turn": 0}, {"stretch": 1, "turn": 2}],
        }  # fmt: skip
    for keys in (("cam.none",), ("cam.seat",), ("rpm", "cam.none"), ("cam.seat", "rpm")):
        assert certificate._about(shooting, keys, 40.0) is None


def test_a_box_is_made_wider_by_more_than_its_rounding():
    """At 200 bits it is written to 50 digits: 1e-42 of each size and of its errors a hundredth.

    Where the box is narrow the errors are taken a hundred times as wide; one about an event is
    longer by 1e-32 of its parameter.
    """
    for half, slack in ((1e-3, 1.01), (1e-9, 100.0), (0.0, 100.0)):
        box = box_at(700.0, half, error=1e-30)
        roomy = certificate._roomy(box)
        for e, size in zip(roomy.within[:2], (2.0, 3.0), strict=True):
            assert float(e.rad()) == pytest.approx(slack * 1e-30 + 1e-42 * size, rel=1e-8, abs=0.0)
        exact = certificate._roomy(box_at(700.0, half, error=0.0))
        for e, size in zip(exact.within[:2], (2.0, 3.0), strict=True):
            assert float(e.rad()) == pytest.approx(1e-42 * size, rel=1e-6, abs=0.0)
        assert roomy.error == roomy.within
        assert [float(one.within[2].rad()) for one in (roomy, exact)] == [0.0, 0.0]
        assert roomy.half == box.half
        longer = certificate._roomy(box, event=True).half - box.half
        assert float(longer) == pytest.approx(1e-32 * 701.0, rel=1e-6, abs=0.0)


# -- the parts of a flight


def flight(monkeypatch, rises, falls, lifts=False, touch=None):
    """A flight of four passages of one radian each, whose runs are given; what was asked."""
    asked = Stub(runs=[], above=[])
    places = [Place(k, 4 if k < 2 else 5) for k in range(4)]
    passages = [
        certificate.Passage(place, arb(k), arb(k + 1), "gap") for k, place in enumerate(places)
    ]
    runs = {"rises": rises, "falls": falls}

    def run(holds, begin, end):
        kind = holds.__name__
        number = holds.__self__.place.stretch
        asked.runs.append((kind, float(begin), float(end)))
        cuts, reached = runs[kind][number]
        return certificate.Run(list(cuts), None if reached is None else arb(reached))

    def above(passage, low, high, touched):
        phase = None if touched is None else float(touched.mid())
        asked.above.append((passage.place.stretch, float(low), float(high), phase))
        return [0.5 * (float(low) + float(high))]

    monkeypatch.setattr(certificate, "_passages", lambda *of: passages)
    monkeypatch.setattr(certificate, "_run", run)
    monkeypatch.setattr(certificate, "_above", above)
    monkeypatch.setattr(certificate, "_lifted", lambda first: [0.125])
    return certificate._flight("shooting", [arb(9), arb(9), arb(0.5)], 1, lifts, touch), asked


RISES = {0: ([0.5], None), 1: ([1.25], 1.25), 2: ([], 2.0), 3: ([], 3.0)}
FALLS = {3: ([3.5], None), 2: ([2.75, 2.5], 2.5), 1: ([], 2.0), 0: ([], 1.0)}


@pytest.mark.parametrize("lifts", [False, True])
@pytest.mark.parametrize("touches", [False, True])
def test_a_flight_rises_is_above_the_cam_and_falls(monkeypatch, lifts, touches):
    """It is cut where it stops to rise and begins to fall, and between; a touch is in its turn."""
    touch = Stub(angle=arb(1.75)) if touches else None
    found, asked = flight(monkeypatch, RISES, FALLS, lifts, touch)
    first = ["0.125"] if lifts else []
    assert [(row["stretch"], row["turn"], row["cuts"]) for row in found["passages"]] == [
        (0, 4, [*first, "0.5"]), (1, 4, ["1.25", "1.625"]), (2, 5, ["2.25", "2.5", "2.75"]),
        (3, 5, ["3.5"]),
    ]  # fmt: skip
    assert (found["rise"], found["fall"]) == (3 + lifts, 4)
    begin = 0.125 if lifts else 0.0
    assert asked.runs == [("rises", begin, 1.0), ("rises", 1.0, 2.0), ("falls", 4.0, 3.0),
                          ("falls", 3.0, 2.0)]  # fmt: skip
    phases = (2.25, 2.25 - 6.283185307179586) if touches else (None, None)
    assert asked.above == [
        (1, 1.25, 2.0, phases[0] and pytest.approx(phases[0])),
        (2, 2.0, 2.5, phases[1] and pytest.approx(phases[1])),
    ]


def test_a_flight_may_fall_from_where_it_stops_to_rise(monkeypatch):
    """It is asked no further back than that passage."""
    found, asked = flight(monkeypatch, RISES, {**FALLS, 2: ([], None), 1: ([1.75], 1.75)})
    assert [of for of in asked.runs if of[0] == "falls"] == [
        ("falls", 4.0, 3.0), ("falls", 3.0, 2.0), ("falls", 2.0, 1.0)
    ]  # fmt: skip
    assert [row["cuts"] for row in found["passages"]] == [
        ["0.5"], ["1.25", "1.5", "1.75"], [], ["3.5"]
    ]  # fmt: skip
    assert asked.above == [(1, 1.25, 1.75, None)]
    assert (found["rise"], found["fall"]) == (3, 4)
    whole, asked = flight(monkeypatch, RISES, {k: ([], None) for k in range(4)})
    assert [of[1] for of in asked.runs if of[0] == "falls"] == [4.0, 3.0, 2.0]
    assert (asked.above, whole["fall"]) == ([], 3)


@pytest.mark.parametrize(("rises", "falls"), [
    ({0: ([], 0.0)}, FALLS), (RISES, {3: ([], 4.0)}),
    ({k: ([], None) for k in range(4)}, {3: ([3.5], None)}),
])  # fmt: skip
def test_a_flight_that_does_not_rise_and_fall_is_undecided(monkeypatch, rises, falls):
    with pytest.raises(UndecidedError):
        flight(monkeypatch, rises, falls)


def test_a_flight_passes_stretches_in_the_turn_that_each_is_in(monkeypatch):
    """Turns of 8 rad; it begins at 7 in turn 3, and lands 10 rad later at 1 in turn 5.

    The phase of its launch is counted in the turn of the passage, so that it goes below zero.
    """
    stretches = [Stub(start=arb(0), end=arb(6)), Stub(start=arb(6), end=arb(8))]
    machine = Stub(turn=arb(8), stretches=stretches)
    places = [Place(1, 3), Place(0, 4), Place(1, 4), Place(0, 5)]
    hull = [arb(2), arb(9), arb(7), arb(0.5), arb(700)]
    shooting = Stub(
        machine=lambda rpm: machine if rpm == 700 else None,
        places=[Place(0, 2), places[0]],
        lift=lambda *of: (arb(0.25), arb(0.125), None) if of == (machine, *at_launch) else None,
        passed=lambda k: places if k == 1 else [],
        span=lambda z, k: arb(10) if (z, k) == (hull, 1) else arb(0),
    )
    at_launch = places[0], hull[2]
    monkeypatch.setattr(certificate, "_gap_enclosed", lambda a, b, **of: (a, b, of))
    found = certificate._passages(shooting, hull, 1)
    assert [one.place for one in found] == places
    assert [(float(one.begin), float(one.end)) for one in found] == [(7, 8), (0, 6), (6, 8), (0, 1)]
    for passage, launch in zip(found, (7, -1, -1, -9), strict=True):
        low, high, of = passage.gap(1, 2)
        assert (low, high, float(of["launch"])) == (1, 2, launch)
        assert (of["machine"], of["stretch"]) == (machine, stretches[passage.place.stretch])
        assert (float(of["q"]), float(of["w"])) == (0.25, 0.625)
