"""The checker of certificates reads every kind of cam as it is: heights and slopes by other means.

`camcli.check` has formulas of its own. They are compared with those of `support`, which are neither
its own nor the program's, at phases in every part and close to its ends.
"""

from __future__ import annotations

from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from flint import arb, ctx
from mpmath import cos, mp, mpf, pi, sin

import camcli
from camcli import check
from camcli.cams.formula import formula_of
from tests.support.law_oracle import LAWS, OWN_LAW
from tests.support.mechanics import lift_of

RISE, TOP, FALL, START = 80.5, 20.0, 90.25, 310.0  # deg; the rise goes through zero
BASE, LIFT = -0.1, 0.05
WIDTHS = {"scca": {"b": 0.3, "c": 0.15, "d": 0.55}}
ARCS = camcli.load_scene().cam.model_dump()
ROUND = {"kind": "eccentric", "base": -0.01, "lift": 0.02}
SPRING = {"kind": "oscillator", "mass": 2.0, "stiffness": 30.0, "damping_ratio": 0.1,
          "amplitude": 1.5, "frequency": 2.8, "clearance": 0.02}  # fmt: skip


def motions(rise, fall):
    """A cam of two motions and two dwells."""
    return {"kind": "law", "base": BASE, "lift": LIFT, "top_dwell_deg": TOP,
            "rise": {"start_deg": START, "length_deg": RISE, "law": rise},
            "fall": {"length_deg": FALL, "law": fall}}  # fmt: skip


def of_motions(rise, fall):
    """Its lift and derivatives at a phase, rad."""

    def at(theta):
        since = (theta * 180 / pi - mpf(START)) % 360
        for law, begin, length, low, step in (
            (rise, 0, RISE, BASE, LIFT), (fall, RISE + TOP, FALL, mpf(BASE) + mpf(LIFT), -LIFT)
        ):  # fmt: skip
            if begin <= since < begin + length:
                beta = mpf(length) * pi / 180
                s = [law.derivative((since - begin) / length, n) for n in range(3)]
                return [low + mpf(step) * s[0], step / beta * s[1], step / beta**2 * s[2]]
        return [mpf(BASE) + mpf(LIFT) if since < RISE + TOP else mpf(BASE), 0, 0]

    return at


def of_round(theta):
    return [mpf(ROUND["base"]) + mpf(ROUND["lift"]) / 2 * (1 - cos(theta)),
            mpf(ROUND["lift"]) / 2 * sin(theta), mpf(ROUND["lift"]) / 2 * cos(theta)]  # fmt: skip


def of_spring(theta):
    """The steady motion of m x'' + b x' + k x = a cos(w t), less the clearance."""
    m, k, w = (mpf(SPRING[name]) for name in ("mass", "stiffness", "frequency"))
    b = mpf(2.0 * SPRING["damping_ratio"] * (SPRING["stiffness"] * SPRING["mass"]) ** 0.5)
    answer = mpf(SPRING["amplitude"]) / (k - m * w * w + 1j * b * w)
    turning = answer * mp.expj(theta)
    return [turning.real - mpf(SPRING["clearance"]), -turning.imag, -turning.real]


def of_polynomial(centre, terms):
    def at(theta):
        powers = [(theta - centre) ** k for k in range(len(terms))]
        slopes = [k * powers[k - 1] if k else 0 for k in range(len(terms))]
        bends = [k * (k - 1) * powers[k - 2] if k > 1 else 0 for k in range(len(terms))]
        return [sum(a * x for a, x in zip(terms, row, strict=True))
                for row in (powers, slopes, bends)]  # fmt: skip

    return at


def exactly(lift):
    return lambda theta: lift.exactly(theta)


CAMS = {
    "arcs": (ARCS, exactly(lift_of(ARCS))),
    "eccentric": (ROUND, of_round),
    "oscillator": (SPRING, of_spring),
    **{name: (motions(name, "3-4-5"), of_motions(law, LAWS["3-4-5"]))
       for name, law in LAWS.items()},
    "widths of one's own": (motions("cycloidal", WIDTHS), of_motions(LAWS["cycloidal"], OWN_LAW)),
}  # fmt: skip


def compare(stretches, wanted, close):
    """A stretch's height and two derivatives, at phases inside it, with those wanted there."""
    for one in stretches:
        for share in (1e-6, 0.2, 0.5, 0.77, 1.0 - 1e-6):
            theta = one.start + arb(share) * (one.end - one.start)
            found = one.derivatives(theta.mid(), 2)
            exact = wanted(mpf(theta.mid().str(60, radius=False)))
            for mine, other in zip(found, exact, strict=True):
                assert abs(mpf(mine.mid().str(60, radius=False)) - other) < close
                assert mine.rad() < close


@pytest.fixture(autouse=True)
def digits(monkeypatch):
    monkeypatch.setattr(ctx, "prec", 256)
    with mp.workdps(60):
        yield


@pytest.mark.parametrize("name", CAMS)
def test_every_formula(name):
    cam, wanted = CAMS[name]
    follower = {"restitution": 0.5}
    if cam["kind"] != "oscillator":
        follower |= {"mass": 1.0, "stiffness": 1.0}
    shape = camcli.load_scene({"follower": follower, "cam": cam}).cam
    stretches = check.cam_of(formula_of(shape), "cam").stretches
    assert stretches[0].start == 0
    assert abs(stretches[-1].end - 2 * arb.pi()) < 1e-60
    assert all(a.end.overlaps(b.start) for a, b in pairwise(stretches))
    compare(stretches, wanted, 1e-13 if name == "arcs" else 1e-25)  # `lift_of` has doubles in it


def test_polynomials_about_their_centres():
    """Of a fitted table: shares of the turn, each with a centre of its own."""
    rows = [(0, 3, "0.3", ["0.1", "0.2", "-0.5"]), (3, 8, "4", ["0.25", "-1", "0.5", "0.125"])]
    cam = {"kind": "pieces", "numbers": {}, "formulas": [], "seat_restitution": None, "stretches": [
        {"end": f"pi*{b}/4", "center": x, "polynomial": c, "wave": [], "circle": [], "seat": False}
        for a, b, x, c in rows
    ]}  # fmt: skip
    stretches = check.cam_of(cam, "cam").stretches
    assert len(stretches) == 2
    for one, (first, last, centre, coefficients) in zip(stretches, rows, strict=True):
        assert abs(one.start - arb.pi() * first / 4) < 1e-60
        assert abs(one.end - arb.pi() * last / 4) < 1e-60
        compare([one], of_polynomial(mpf(centre), [mpf(a) for a in coefficients]), 1e-20)


@pytest.mark.ci
def test_a_measured_cam_is_the_one_that_the_program_moves_on():
    scene = camcli.load_scene("configs/lift-table.yaml")
    stretches = check.cam_of(formula_of(scene.cam), "cam").stretches
    profile = camcli.simulate(scene, profile_only=True).tables["profile"]
    columns = [profile[name] for name in
               ("c_m", "c_theta_m_per_rad", "c_thetatheta_m_per_rad2")]  # fmt: skip
    ends = np.array([float(one.end) for one in stretches])
    for k in range(3, len(profile["theta_deg"]) - 1, 37):
        theta = np.radians(profile["theta_deg"][k])
        if np.abs(ends - theta).min() < 1e-6:
            continue
        one = stretches[int(np.searchsorted(ends, theta))]
        found = [float(x) for x in one.derivatives(arb(theta), 2)]
        np.testing.assert_allclose(found, [c[k] for c in columns], rtol=1e-7, atol=1e-9)


@pytest.mark.parametrize("jump", [0.0, 0.99e-9, 1.01e-9, 1e-6])
@pytest.mark.parametrize("side", [1, -1], ids=["behind", "before"])
@pytest.mark.parametrize("kind", ["pieces", "law"])
def test_slopes_that_differ_by_rounding_are_no_kink_of_a_fit(kind, jump, side):
    """1e-9 m/rad of polynomials that were fitted; of a formula none at all."""
    half = arb.pi()
    rows = [(arb(0), half, arb(0)), (half, 2 * half, arb(jump))]  # begin, end, slope
    stretches = [check.Stretch(a, b, arb(0), [arb(0), s]) for a, b, s in rows]
    orbit = SimpleNamespace(
        cam=SimpleNamespace(kind=kind),
        at=lambda z: SimpleNamespace(stretches=stretches),
        places=[SimpleNamespace(stretch=0 if side > 0 else 1)],
    )
    allowed = 1e-9 if kind == "pieces" else 0.0
    assert check.kink(orbit, 0, side, None) == (jump > allowed)


@pytest.mark.parametrize("seat", [(True, True), (False, True), (True, False), (False, False)])
@pytest.mark.parametrize("own", [None, 0.3])
def test_where_a_seat_with_a_restitution_of_its_own_begins_an_orbit_has_a_kink(own, seat):
    """The cam goes on without a jump of its slope, and the impact with another loss."""
    half = arb.pi()
    ends = [(arb(0), half), (half, 2 * half)]
    stretches = [
        check.Stretch(a, b, arb(0), [arb(0), arb(0)], seat=is_seat)
        for (a, b), is_seat in zip(ends, seat, strict=True)
    ]
    orbit = SimpleNamespace(
        cam=SimpleNamespace(kind="law", seat_restitution=own),
        at=lambda z: SimpleNamespace(stretches=stretches),
        places=[SimpleNamespace(stretch=0)],
    )
    assert check.kink(orbit, 0, 1, None) == (own is not None and seat[0] != seat[1])
