"""The motion after a rest in decimals, against the multiple-precision oracle, and its limits."""

import pickle
from dataclasses import replace
from decimal import Decimal, localcontext
from inspect import getclosurevars

import pytest
from conftest import chapter_system, settings
from mpmath import mp, mpf

from camcli.analysis.integrate import Orbit
from camcli.analysis.orbits.identify import departures
from camcli.cams.decimals import pi, sincos
from camcli.cams.eccentric import EccentricCam
from camcli.cams.law import LawCam
from camcli.exact.drive import DIGITS, Drive
from camcli.exact.lifts import Lifts
from camcli.exact.motion import FORGOT, ON_EDGE, UNCLEAR, TrueMotion
from camcli.exact.scout import Found, Scout
from camcli.kernel.cam_table import stretch_at
from camcli.kernel.flow import flow
from camcli.kernel.orbit_loop import EventKind
from camcli.system import Follower, System
from tests.oracle import Arc, ArcsCam, Oracle
from tests.oracle import Follower as OracleFollower


@pytest.fixture(autouse=True)
def _digits():
    with localcontext() as context:
        context.prec = DIGITS
        yield


def exact(x: Decimal) -> mpf:
    with mp.workdps(150):
        return mpf(str(x))


def oracle_of(system: System, rpm: float) -> Oracle:
    """The oracle on the very cam of a System made of arcs, whose corners have 40 digits."""
    cam, parts = ArcsCam(), system.parts
    cam.breakpoints = [exact(part.start) for part in parts[1:]]
    cam.arcs = [_arc(part) for part in parts[1:]]
    f = system.follower
    return Oracle(
        cam, mass=f.mass, stiffness=f.stiffness, damping=f.damping, gravity=f.gravity,
        preload=f.preload, restitution=f.restitution, rpm=rpm, digits=130,
    )  # fmt: skip


def _arc(part) -> Arc:
    """A part of the cam with the constants it was made with."""
    if part.lift is None:
        return Arc(mpf(0), exact(part.level), exact(part.start), mpf(0))
    made = getclosurevars(part.lift).nonlocals
    kappa, *others = (exact(made[name]) for name in ("kappa", "rho", "zero", "offset"))
    return Arc(made["sign"] * kappa, *others)


def from_rest(system: System, rpm: float, **options) -> TrueMotion:
    """The motion from rest at theta = 0, at its departure."""
    theta = departures(Orbit(system, rpm, settings(0, 3)).run())[0][1]
    motion = TrueMotion(system, rpm, settings(**options))
    assert motion.leave(stretch_at(system.cam, theta), theta)
    return motion


def followed(motion: TrueMotion, turns: int) -> TrueMotion:
    while len(motion.trail.states) < turns and motion.step():
        pass
    return motion


def hops(motion: TrueMotion, oracle: Oracle, turns: int):
    """(place, rate) of impacts of both, a chatter's last ones left out, and the oracle's kinds."""
    events = oracle.run(turns=turns)
    mp.dps = DIGITS + 20
    omega = oracle.rpm * mp.pi / 30
    theirs = [
        (e.theta + 2 * mp.pi * e.turn, e.u_minus / omega) for e in events if e.kind == "impact"
    ]
    mine = [(exact(place), exact(u)) for place, u in motion.trail.impacts]
    pairs, k = [], 0
    for place, u in mine:
        while k < len(theirs) and theirs[k][0] < place - mpf("1e-9"):
            k += 1
        if k == len(theirs):
            break
        pairs.append(((place, u), theirs[k]))
        k += 1
    return pairs, [e for e in events if e.kind != "impact"]


@pytest.mark.parametrize(
    ("rpm", "turns", "changes"),
    [
        (358.0, 90, {}),
        (358.8, 60, {}),
        (450.0, 30, {"damping": 6.0, "gravity": 9.81, "preload": 20.0, "restitution": 0.7}),
        (500.0, 12, {"damping": 120.0}),  # overdamped
    ],
)
def test_every_impact_is_the_oracles(rpm, turns, changes):
    system = chapter_system(**changes)
    motion = followed(from_rest(system, rpm), turns)
    assert motion.reason == ""
    pairs, others = hops(motion, oracle_of(system, rpm), turns)
    assert len(pairs) >= 0.9 * len(motion.trail.impacts)
    assert len(pairs) > 2 * turns if rpm < 400 else pairs
    worst = max(max(abs(p[0] - q[0]), abs(p[1] - q[1])) for p, q in pairs)
    assert worst < 1e-20
    leaves = [e for e in others if e.kind == "detachment"]
    mine = [place for place, _ in motion.trail.leaves if place < turns * motion.turn]
    assert len(mine) == len(leaves)
    for place, event in zip(mine, leaves, strict=True):
        assert abs(exact(place) - event.theta - 2 * mp.pi * event.turn) < 1e-20


def test_the_error_it_states_is_not_below_the_true_one(monkeypatch):
    """With a coarse derivative of the cam, and NOISE as large as its error, against a fine one."""
    from camcli.exact import error, lifts

    right = followed(from_rest(chapter_system(), 358.0), 25)
    cam = right.lifts
    middles = _curved(cam)
    slopes = [cam.c1(*at) for at in middles]
    monkeypatch.setattr(lifts, "STEP", Decimal("1e-3"))
    coarse = [cam.c1(*at) for at in middles]
    off = max(abs(float(x - y)) for x, y in zip(slopes, coarse, strict=True))
    assert 1e-40 < off < 1e-20
    monkeypatch.setattr(error, "NOISE", off / right.doubt.size)
    wrong = followed(from_rest(chapter_system(), 358.0), 25)
    pairs = zip(wrong.trail.states, right.trail.states, strict=False)
    away = max(abs(float(p[j] - q[j])) for p, q in pairs for j in range(2))
    assert 1e3 * off < away < 10.0 * wrong.worst * wrong.doubt.size


def _curved(cam: Lifts):
    """(stretch, middle) of the parts that are no dwells."""
    curved = (k for k, part in enumerate(cam.parts) if part.lift is not None)
    return [(k, sum(cam.edges(k)) / 2) for k in curved]


def test_digits_that_run_out_are_said():
    motion = followed(from_rest(chapter_system(), 745.0), 400)
    assert motion.reason == FORGOT
    assert motion.doubt.error > 1e-10


def test_a_neighbour_that_lands_elsewhere_makes_an_event_unclear(monkeypatch):
    motion = from_rest(chapter_system(), 358.0)
    assert motion.step()
    real = Scout._next

    def shaken(self, i, theta, rate, mode):
        found, state = real(self, i, theta, rate, mode)
        return replace(found, s=found.s * (1.0 + 1e-3 * (rate != float(motion.rate)))), state

    monkeypatch.setattr(Scout, "_next", shaken)
    assert not motion.step()
    assert motion.reason == UNCLEAR


def test_an_impact_at_an_edge_is_not_decided(monkeypatch):
    motion = from_rest(chapter_system(), 358.0)
    edge = motion.lifts.edges(2)[1]
    monkeypatch.setattr(motion, "_landing", lambda found: (Decimal(1), edge - Decimal("1e-13")))
    assert not motion._impact(Found(EventKind.IMPACT, 1.0, 2, float(edge), -1.0))
    assert motion.reason == ON_EDGE


@pytest.mark.parametrize(
    "machine",
    [
        Follower(1.2, 1430.0, 0.0, 9.81, 3.0, 0.5),
        Follower(1.2, 1430.0, 7.0, 0.0, 0.0, 0.5),
        Follower(1.0, 4.0, 4.0, 1.0, 0.0, 0.5),  # critical
        Follower(1.2, 14.0, 90.0, 9.81, 0.0, 0.5),
        Follower(1.0, 0.0, 0.0, 9.81, 0.0, 0.5),
        Follower(1.0, 0.0, 3.0, 9.81, 0.0, 0.5),
    ],
)
def test_flights_of_every_damping(machine):
    """Against the oracle's flow to 1e-60, and the kernel's to its rounding."""
    drive = Drive.of(machine, 300.0)
    lane = System(machine, chapter_system().cam).lane(300.0, 1e-9, 10)
    with mp.workdps(DIGITS):
        theirs = OracleFollower.make(*(
            getattr(machine, name)
            for name in ("mass", "stiffness", "damping", "gravity", "preload")
        ))  # fmt: skip
        omega = mpf(300) * mp.pi / 30
        for s in ("0.001", "0.7", "9.3"):
            q, w = drive.move(Decimal("0.3"), Decimal("-0.8"), Decimal(s))
            x, v = theirs.flow(mpf(s) / omega, mpf("0.3"), mpf("-0.8") * omega)
            assert abs(exact(q) - x) + abs(exact(w) - v / omega) < 1e-60
            for mine, kernel in zip(drive.flow(Decimal(s)), flow(lane, float(s)), strict=True):
                assert float(mine) == pytest.approx(kernel, rel=1e-12, abs=1e-15)


def test_derivatives_of_every_kind_of_part():
    eccentric = EccentricCam(kind="eccentric", base=0.1, lift=0.3)
    lifts = Lifts(System.build(Follower(1.0, 1000.0), eccentric.parts()))
    theta = Decimal("2.3")
    sine, cosine = sincos(theta)
    half = Decimal(eccentric.lift) / 2
    assert abs(lifts.c1(0, theta) - half * sine) < Decimal("1e-80")
    assert abs(lifts.c2(0, theta) - half * cosine) < Decimal("1e-72")


def test_more_digits_of_the_same_numbers():
    with localcontext() as context:
        context.prec = 40
        few = pi(), sincos(Decimal(2))
    assert abs(pi(DIGITS) - few[0]) < Decimal("1e-43")
    assert abs(sincos(Decimal(2))[0] - few[1][0]) < Decimal("1e-39")
    many = sincos(pi(DIGITS) / 6)[0]
    assert abs(many - Decimal("0.5")) < Decimal("1e-95")


def test_a_law_cam_agrees_with_the_kernel_impact_by_impact():
    """Strongly damped, so that no error grows: doubles are exact to their rounding."""
    cam = LawCam(
        kind="law", base=0.1, lift=0.05, top_dwell_deg=30.0,
        rise={"start_deg": 40.0, "length_deg": 90.0, "law": "modified-trapezoid"},
        fall={"length_deg": 80.0, "law": "cycloidal"},
    )  # fmt: skip
    system = System.build(Follower(1.0, 3000.0, 10.0, 9.81, 100.0, 0.3), cam.parts())
    motion = followed(from_rest(system, 700.0), 3)
    tape = Orbit(system, 700.0, settings(0, 4)).run()
    hits = [
        (theta, u) for kind, theta, u in zip(tape.kind, tape.theta, tape.u, strict=True)
        if kind == EventKind.IMPACT
    ]  # fmt: skip
    assert len(motion.trail.impacts) >= 5
    for (place, u), (theta, v) in zip(motion.trail.impacts, hits, strict=False):
        assert float(place % motion.turn) == pytest.approx(theta, abs=1e-9)
        assert float(u) == pytest.approx(v, abs=1e-9)


def test_a_system_pickles_without_its_parts_and_is_equal():
    system = chapter_system()
    assert system.parts is not None
    again = pickle.loads(pickle.dumps(system))
    assert again == system
    assert again.parts is None
    assert again.lane(358.0, 1e-9, 10) == system.lane(358.0, 1e-9, 10)
    assert "parts" not in repr(system)
