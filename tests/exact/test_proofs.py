"""What is proved of orbits and events, what is refused, and that no proof is wrong.

The judge is mpmath at 40 digits: closed flights from `tests.support.oracle`, cams from their
definitions.
"""

import json
from bisect import bisect
from dataclasses import replace
from functools import cache, reduce
from itertools import pairwise
from math import pi
from random import Random

import pytest
from conftest import chapter_system
from flint import arb
from mpmath import iv, mp, mpf

import camcli
from camcli.analysis.orbits.kinds import Kind
from camcli.analysis.orbits.orbit import from_root
from camcli.analysis.orbits.proofs import (
    _keeps,
    prove_event,
    prove_orbit,
    prove_ranges,
    prove_widely,
)
from camcli.analysis.orbits.shooter import Shooter
from camcli.analysis.orbits.single_impact import single_impact_roots
from camcli.cams.balls import precision
from camcli.cams.compile import Piece
from camcli.cams.eccentric import EccentricCam
from camcli.cams.law import LawCam
from camcli.exact.shooting import ProofStep
from camcli.kernel.certify import ADMISSIBLE, Verdict
from camcli.scene import load_scene
from camcli.system import Follower, System
from tests.support import oracle, orbit_oracle
from tests.support.law_oracle import LAWS
from tests.support.orbit_oracle import CAM, CHAPTER, STABLE

pytestmark = pytest.mark.slow

mp.dps = iv.dps = 40
SYSTEM = chapter_system()


def study(prove=False, **section):
    """A result of camcli.orbits over a range of the example's speeds."""
    values = {f"orbits.{key.replace('__', '.')}": value for key, value in section.items()}
    return camcli.orbits(load_scene(None, {"orbits.starts": 0, **values}), prove=prove)


@pytest.fixture(scope="module")
def high():
    return study(prove=True, rpm__start=690.0, rpm__stop=741.0, rpm__num=21)


@pytest.fixture(scope="module")
def three_turns():
    """The branch of P(3;3:3:2) from fold to grazing."""
    speeds = {"rpm__start": 357.0, "rpm__stop": 380.0, "rpm__num": 40, "at": 358.5}
    return study(label="P(3;3:3:2)", branches=0, **speeds).values


@pytest.fixture(scope="module")
def three(three_turns):
    """Its events by kind, the last of each."""
    return {b.kind: b for b in three_turns.bifurcations}


@pytest.mark.ci
def test_a_branch_is_proved_from_its_fold_to_its_doubling(three_turns):
    """At the fold the parameter turns round: the boxes there lean along an impact's phase."""
    (branch,) = three_turns.branches
    events = {b.kind: prove_event(SYSTEM, b).value for b in three_turns.bifurcations}
    one = next(r for r in prove_ranges(SYSTEM, branch, three_turns.bifurcations) if r.stable)
    assert (one.low, one.high) == (events["fold"], events["period-doubling"])
    assert one.failed_step is None


def test_an_impact_that_fades_at_a_graze_is_enclosed():
    """A damped follower that rests at -preload/k fades on the cam's top, where both are exact."""
    changes = {
        "follower": {"mass": 1, "stiffness": 1, "damping": 0.1, "preload": 0.1, "restitution": 0.8},
        "cam": {"kind": "eccentric", "base": -2.2, "lift": 2},
        "orbits": {"rpm": {"start": 12.414085, "stop": 12.414085, "num": 1},
                   "parameter": "preload", "range": [0, 0.5], "starts": 4},
    }  # fmt: skip
    result = camcli.orbits(load_scene(changes))
    found = [b for b in result.values.bifurcations if b.label == "P(1;1)"]
    assert {b.located.fading for b in found} == {0}
    top = mpf(-2.2) + 2
    for event in found:
        value = interval(prove_event(result.system, event, "preload").value)
        assert -top in value
        assert value.delta < 1e-25
        moved_ahead = replace(event, value=event.value * (1 + 1e-9))
        assert prove_event(result.system, moved_ahead, "preload").step == ProofStep.NUMBER


@pytest.mark.ci
def test_what_holds_for_the_data_need_not_hold_within_their_last_digit(high):
    """At the double nearest to a doubling it is certain on which side it lies, but only for it."""
    for orbit in high.values.orbits:
        assert prove_widely(SYSTEM, orbit).holds_for == "last-digit"
    event = next(b for b in high.values.bifurcations if b.kind == "period-doubling")
    proof = prove_event(SYSTEM, event)
    nearest = float(mpf(interval(proof.value).mid))
    beside = Shooter(SYSTEM, nearest).moved(event.located.root, nearest)
    orbit = from_root(SYSTEM, beside)
    either = [
        prove_widely(SYSTEM, replace(orbit, trace=-1 - orbit.det + by)) for by in (1e-9, -1e-9)
    ]
    assert [p.proved for p in either] == [
        nearest < interval(proof.value),
        nearest > interval(proof.value),
    ]
    assert {p.holds_for for p in either if p.proved} == {"exact-data"}


def orbit_of(result, label):
    return next(orbit for orbit in result.values.orbits if orbit.label == label)


def moved(orbit, by):
    """The orbit with the phase of its first impact moved."""
    x = list(orbit.root.x)
    x[0] += by
    return replace(orbit, root=replace(orbit.root, x=x))


def test_a_virtual_orbit_is_refuted(high):
    assert high.values.virtual
    for orbit in high.values.virtual:
        proof = prove_orbit(SYSTEM, orbit)
        assert proof.refuted
        assert proof.step == (
            ProofStep.PULLS if orbit.verdict is Verdict.PULLS else ProofStep.CONTACT
        )


def test_an_orbit_beyond_its_grazing_is_refuted(three):
    """P(3;3:3:2) grazes at 379.098 rpm; beyond it the cam is met between two impacts."""
    graze = three["grazing"]
    assert prove_event(SYSTEM, graze).proved
    for beside, proved in ((-1e-3, True), (1e-3, False)):
        value = graze.value + beside
        root = Shooter(SYSTEM, value).moved(graze.orbit.root, value)
        proof = prove_orbit(SYSTEM, from_root(SYSTEM, root))
        assert proof.proved == proved
        assert proved or (proof.step, proof.refuted) == (ProofStep.CONTACT, True)


def test_numbers_that_are_not_the_orbits_are_refused(high):
    orbit = orbit_of(high, "P(1;1)")
    assert prove_orbit(SYSTEM, orbit).proved
    assert prove_orbit(SYSTEM, moved(orbit, 1e-9)).step == ProofStep.NO_ORBIT
    assert prove_orbit(SYSTEM, replace(orbit, trace=2.0)).step == ProofStep.NEUTRAL
    event = high.values.bifurcations[0]
    assert prove_event(SYSTEM, event).proved
    assert prove_event(SYSTEM, replace(event, value=event.value + 1e-8)).step == ProofStep.NUMBER


def test_an_event_is_none_where_its_test_function_crosses_nothing(high):
    event = next(b for b in high.values.bifurcations if b.kind == "period-doubling")
    fold = replace(event.located, kind="fold")
    wrong = replace(event, kind="fold", located=fold)
    assert not prove_event(SYSTEM, wrong).proved


def enclosures(result, label):
    """(kind, corner, enclosure) of the events of an orbit, as intervals of mpmath."""
    proofs = zip(result.values.bifurcations, result.values.proofs.events, strict=True)
    return {(b.kind, b.corner): p for b, p in proofs if b.label == label and p.proved}


def interval(text):
    """The interval of '[middle +/- radius]'."""
    middle, _, radius = text.strip("[]").partition(" +/- ")
    return iv.mpf([mpf(middle) - mpf(radius or 0), mpf(middle) + mpf(radius or 0)])


def test_the_events_of_the_upper_range_and_the_oracle(high):
    found = enclosures(high, "P(1;1)")
    value = interval(found["period-doubling", ""].value)
    doubling = orbit_oracle.period_doubling_rpm(CAM, CHAPTER, STABLE, 1, 700, 745).rpm
    assert doubling == pytest.approx(mpf(value.mid), rel=1e-14)
    assert value.delta < 1e-20
    (corner,) = (p for key, p in enclosures(high, "P(2;1:1)").items() if key[1] == "c")
    assert interval(corner.value).mid == pytest.approx(739.3779296493, abs=5e-11)
    assert [sign for _, sign in corner.signs] == [1, -1]


def test_a_branch_is_stable_from_event_to_event(high):
    stable = [one for one in high.values.proofs.ranges if one.stable and one.label == "P(1;1)"]
    (one,) = stable
    assert (one.low, interval(one.high).mid) == ("690.0", pytest.approx(739.319780216, abs=1e-9))
    said = " ".join(high.summary["words"])
    assert f"P(1;1) exists and is stable for all rpm from 690.0 to {one.high}" in said
    (doubled,) = (r for r in high.values.proofs.ranges if r.stable and r.label == "P(2;1:1)")
    assert doubled.failed_step is None
    assert interval(doubled.high).mid == pytest.approx(739.3779296493, abs=5e-11)
    assert 0 < float(doubled.low) - mpf(interval(one.high).mid) < 1e-3  # beside its birth


@pytest.mark.ci
def test_a_branch_is_proved_up_to_a_corner_impact_from_either_side():
    """Its impact lies on another stretch behind the corner, and the orbit is unstable there."""
    found = study(prove=True, rpm__start=739.0, rpm__stop=741.0, rpm__num=6).values.proofs.ranges
    doubled = {one.stable: one for one in found if one.label == "P(2;1:1)"}
    assert doubled[False].low == doubled[True].high
    assert interval(doubled[False].low).mid == pytest.approx(739.3779296493, abs=5e-11)
    assert (doubled[False].high, doubled[False].failed_step) == ("741.0", None)


def test_orbits_through_rests_and_the_speeds_at_which_they_change():
    found = study(prove=True, rpm__start=110.0, rpm__stop=130.0, at=120.0, rpm__num=5)
    for orbit, proof in zip(found.values.orbits, found.values.proofs.orbits, strict=True):
        assert orbit.resting
        assert proof.proved
    (first,) = (
        p
        for b, p in zip(found.values.bifurcations, found.values.proofs.events, strict=True)
        if b.kind == "detachment"
    )
    assert oracle.first_detachment_rpm(oracle.ArcsCam(), 1.221, 1430.8) == pytest.approx(
        mpf(interval(first.value).mid), rel=1e-14
    )
    orbit = found.values.orbits[0]
    assert not prove_orbit(SYSTEM, replace(orbit, rpm=114.9)).proved
    for changed, there in (
        (orbit, True), (replace(orbit, symbols=(3.0,)), False),
        (replace(orbit, theta=(*orbit.theta, 3.0)), False),
    ):  # fmt: skip
        with precision(60):
            assert _keeps(SYSTEM, "rpm", changed, arb(119), Kind.ITINERARY) is there
    table = found.tables["bifurcations"]  # 114.97932674400 by doubles, 2e-12 beside the enclosure
    ends = table["enclosure_low"], table["rpm"], table["enclosure_high"]
    assert all(low <= rpm <= high for low, rpm, high in zip(*ends, strict=True))


def test_columns_and_boxes_of_the_command(cam, tmp_path):
    done = cam(
        "orbits --rpm 738:740 --points 3 --prove",
        "--branches 0 --no-plot -o out --set orbits.starts=0",
        code=0,
    )
    assert "proved: period-doubling of P(1;1), rpm = [739.31978021600165" in done.stdout
    head, *lines = (tmp_path / "out" / "bifurcations.csv").read_text().splitlines()
    assert head.endswith(",classification,proved,enclosure_low,enclosure_high")
    proved, low, high = lines[0].split(",")[-3:]
    assert proved == "yes"
    assert float(low) < 739.319780216001655 < float(high)
    head, *lines = (tmp_path / "out" / "branch.csv").read_text().splitlines()
    assert head.endswith(",proved")
    assert sum(line.endswith(",yes") for line in lines) >= 0.9 * len(lines)
    cam("rerun out/run.json -o again", code=0)
    assert (tmp_path / "again" / "branch.csv").read_text().splitlines()[0] == head


def test_a_proof_says_which_flank_circle_it_is_about(cam, tmp_path):
    """The one that closes, whatever flank_radius says: the same box, and by how much it differs."""
    boxes = []
    for radius, said in ((0.85, "5.55e-17 m more than"), (0.8500000001, "1e-10 m less than")):
        at = f"orbits --rpm 700 --prove --no-plot -o out --set cam.flank_radius={radius}"
        done = cam(at, "--label P(1;1) --set orbits.starts=0", code=0)
        about = f"flank circle has the radius base_radius + flank_center, {said} the flank_radius"
        assert about in done.stdout
        proofs = json.loads((tmp_path / "out/run.json").read_text())["result"]["proofs"]
        assert proofs["flank_excess_m"] == float(mpf(0.4) + mpf(0.45) - mpf(radius))
        boxes.append([orbit["box"] for orbit in proofs["orbits"] if orbit["proved"]])
    assert boxes[0] == boxes[1] != []
    done = cam("orbits --rpm 700 --prove --no-plot --set cam.flank_radius=0.875",
               "--set cam.base_radius=0.375 --set cam.flank_center=0.5", code=0)  # fmt: skip
    assert "proved: P(1;1)" in done.stdout
    assert "flank circle" not in done.stdout


def machine_of(rng):
    """(system, rpm, cam as mpmath sees it): all damping regimes, five kinds of cam."""
    omega, mass = 10 ** rng.uniform(0, 2), 10 ** rng.uniform(-1, 1)
    w = omega * 10 ** rng.uniform(-1.2, 0.3)
    damped = rng.choice([0.0, 0.0, rng.uniform(0, 0.3), 0.9999, 1.0, 1.5])
    follower = Follower(
        mass, mass * w * w, 2 * mass * w * damped, rng.choice([0.0, 9.81]),
        rng.choice([0.0, mass * w * w * rng.uniform(-0.5, 0.5)]), rng.uniform(0.2, 0.95),
    )  # fmt: skip
    kind = rng.choice(["arcs", "eccentric", "cycloidal", "3-4-5", "table"])
    if kind == "table":  # its base is at zero: without a load any phase of the dwell would do
        follower = replace(follower, preload=mass * w * w * rng.uniform(0.005, 0.03))
        return replace(table(), follower=follower), omega * 30 / pi, kind
    if kind == "arcs":
        shape = SYSTEM.shape
    elif kind == "eccentric":
        shape = EccentricCam(kind="eccentric", base=0.25, lift=0.5)
    else:
        law = {"law": kind, "length_deg": 90}
        rise = {**law, "start_deg": 60}
        shape = LawCam(kind="law", base=0.25, lift=0.5, rise=rise, top_dwell_deg=30, fall=law)
    return System.build(follower, shape), omega * 30 / pi, kind


@cache
def table():
    """A system with the measured lift of `configs/lift-table.yaml`."""
    shape = load_scene("configs/lift-table.yaml").cam
    return System.build(SYSTEM.follower, shape)


@cache
def polynomials():
    """(end in rad, centre, coefficients and those of the slope, highest power first)."""
    found = []
    for part in table().shape.parts():
        pieces = part.pieces or [Piece(0.0, 0.0, (float(part.level),))]
        start, end = (mpf(end.str(40, radius=False)) for end in (part.start, part.end))
        for k, piece in enumerate(pieces, 1):
            high = [mpf(x) for x in reversed(piece.coefficients)]
            slope = [x * n for n, x in zip(range(len(high) - 1, 0, -1), high, strict=False)]
            end_k = start + (end - start) * k / len(pieces)
            found.append((end_k, mpf(piece.center), high, slope or [mpf(0)]))
    return found


def horner(coefficients, x):
    return reduce(lambda total, a: total * x + a, coefficients, mpf(0))


def lift(kind, theta):
    """(c, c_theta) from the cam's definition."""
    theta = theta - 2 * mp.pi * mp.floor(theta / (2 * mp.pi))
    if kind == "table":
        k = bisect([end for end, *_ in polynomials()], theta)
        _, center, high, slope = polynomials()[k]
        return horner(high, theta - center), horner(slope, theta - center)
    if kind == "arcs":
        return oracle.ArcsCam().laws(theta)[:2]
    if kind == "eccentric":
        return mpf("0.25") + (1 - mp.cos(theta)) / 4, mp.sin(theta) / 4
    law, begin, length = LAWS[kind], mp.pi / 3, mp.pi / 2
    top, fall = begin + length, begin + length + mp.pi / 6
    if begin <= theta < top:
        x, side = (theta - begin) / length, 1
    elif fall <= theta < fall + length:
        x, side = 1 - (theta - fall) / length, -1
    else:
        return (mpf("0.75") if top <= theta < fall else mpf("0.25")), mpf(0)
    return mpf("0.25") + law.derivative(x, 0) / 2, side * law.derivative(x, 1) / length / 2


def contradicted(system, rpm, kind, root, proof):
    """What 40 digits say against a proof: an impact that is none, a gap that is not there."""
    f, omega = system.follower, mpf(rpm) * mp.pi / 30
    follower = oracle.Follower.make(f.mass, f.stiffness, f.damping, f.gravity, f.preload)
    # the oracle takes another of the redundant lengths of the circles as given
    rounding = mpf("1e-12" if kind == "arcs" else "1e-24")
    places = [mpf(interval(text).mid) for text in proof.box]
    thetas, rates = places[::2], places[1::2]
    ends = [theta + 2 * mp.pi * root.whole[2 * k + 1] for k, theta in enumerate(thetas)]
    for (theta, v), (end, after) in pairwise(
        zip([*ends, ends[0] + 2 * mp.pi * root.turns], [*rates, rates[0]], strict=True)
    ):
        c, c1 = lift(kind, theta)
        whole = (end - theta) / omega
        for k in range(1, 40):
            q, _ = follower.flow(whole * k / 40, c, omega * (c1 + v))
            if q <= lift(kind, theta + (end - theta) * k / 40)[0]:
                return f"below the cam after {k}/40 of a flight"
        q, w = follower.flow(whole, c, omega * (c1 + v))
        c, c1 = lift(kind, end)
        scale = 1 + abs(v) + abs(after)
        if abs(q - c) > rounding * scale:
            return f"a gap of {mp.nstr(q - c, 5)} at an impact"
        if abs(mpf(f.restitution) * (w / omega - c1) + after) > rounding * scale:
            return "an impact that does not bounce so"
    return None


def test_random_machines():
    """Proved or honestly not; a proof and the certificate of the doubles never contradict."""
    rng, seen, tables = Random(8), {"proved": 0, "refuted": 0, "open": 0}, 0
    for _ in range(60):
        system, rpm, kind = machine_of(rng)
        shooter = Shooter(system, rpm)
        for turns in (1, 2):
            for root in single_impact_roots(shooter, rpm, turns):
                orbit = from_root(system, root, shooter.verdict(root)[0])
                proof = prove_orbit(system, orbit)
                seen["proved" if proof.proved else "refuted" if proof.refuted else "open"] += 1
                if proof.proved:
                    tables += kind == "table"
                    assert shooter.verdict(root)[0] == ADMISSIBLE
                    assert contradicted(system, rpm, kind, root, proof) is None
                elif proof.refuted:
                    assert shooter.verdict(root)[0] != ADMISSIBLE
    assert seen["proved"] > 15
    assert seen["refuted"] > 30
    assert tables > 5
    assert seen["open"] < 0.1 * sum(seen.values()), seen


def test_a_branch_that_leaves_from_a_corner_of_another_is_proved_from_there():
    """The unstable P(1;2) begins where the stable one has its corner impact, at 355.1545 rpm."""
    found = study(prove=True, label="P(1;2)", rpm__start=355.0, rpm__stop=360.0, rpm__num=6,
                  at=358.5, branches=1).values.proofs.ranges  # fmt: skip
    low = {one.stable: (one.low, one.failed_step) for one in found}
    assert low[False] == low[True]
    assert interval(low[False][0]).mid == pytest.approx(355.1545237164479, abs=1e-12)
