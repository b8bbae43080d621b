"""The motion after a rest in balls: every event is the oracle's, none is missed, none invented."""

import json
from fractions import Fraction
from pathlib import Path
from threading import Thread

import pytest
from flint import arb, arb_mat, ctx

from camcli.analysis.bench.machine import reference
from camcli.analysis.integrate import Orbit
from camcli.analysis.orbits.identify import departures
from camcli.cams.arcs import ArcsCam
from camcli.cams.balls import DIGITS, UndecidedError, decided, precision
from camcli.cams.eccentric import EccentricCam
from camcli.cams.law import LawCam
from camcli.exact.first_root import first_root
from camcli.exact.machine import BallMachine
from camcli.exact.motion import BallMotion, Parallelogram
from camcli.kernel.cam_table import lift_at, stretch_at
from camcli.kernel.orbit_loop import EventKind
from camcli.scene import load_scene
from camcli.system import Follower, System
from tests.conftest import settings
from tests.support.kernel_runs import GEOMETRY
from tests.support.make_flights import CHAPTER

FLIGHTS = json.loads((Path(__file__).parents[1] / "support/flights.json").read_text())
CORNER_B = 2.621124501166232  # rad
ARCS = ArcsCam(kind="arcs", **GEOMETRY)


def law_cam(rise: str, fall: str) -> LawCam:
    return LawCam(
        kind="law", base=0.1, lift=0.05, top_dwell_deg=30.0,
        rise={"start_deg": 40.0, "length_deg": 90.0, "law": rise},
        fall={"length_deg": 80.0, "law": fall},
    )  # fmt: skip


def followed(machine: BallMachine, theta: float, turns: int, strobe: float = 0.0) -> BallMotion:
    motion = BallMotion(machine, strobe, theta)
    while len(motion.trail.states) < turns:
        motion.step()
    return motion


@pytest.mark.parametrize("name", FLIGHTS)
def test_every_event_is_the_oracles(name):
    """Impacts and detachments within 1e-28; what is not listed lies in the enclosed chatters."""
    case = FLIGHTS[name]
    follower = Follower(**{**CHAPTER, **case["changes"]})
    with precision(200):
        trail = followed(BallMachine(ARCS, follower, case["rpm"]), CORNER_B, case["turns"]).trail
        theirs = [(kind, arb(phi), arb(u)) for kind, phi, u in case["events"]]
        same_events(trail, theirs, case["turns"], arb(0, "1e-25"))


@pytest.mark.parametrize(
    "name", ["chaotic", "chatter", "critical", "eccentric", "incomplete", "overdamped"]
)
def test_the_references_of_the_bench_are_proved(name):
    """All that begin at rest: every event to the 25 digits stored, and none is left out."""
    case = reference(name)
    cam = (ArcsCam if case["cam"]["kind"] == "arcs" else EccentricCam)(**case["cam"])
    with precision(100):
        machine = BallMachine(cam, Follower(**case["follower"]), case["rpm"])
        omega = arb(case["rpm"]) * arb.pi() / 30
        start = float(case["events"][0]["theta"])
        trail = followed(machine, start, case["turns"]).trail
        theirs = [
            (e["kind"], arb(e["theta"]) + e["turn"] * machine.turn, arb(e["u"]) / omega)
            for e in case["events"]
        ]
        same_events(trail, theirs, case["turns"], arb(0, "1e-22"))


@pytest.mark.parametrize("rpm", [119.712, 119.7125, 119.7126, 119.713, 119.714, 119.72])
def test_a_low_hop_across_a_corner_lands_within_eight_roundings(rpm, chapter):
    """Just past corner c a chatter ends that began before it, its hops 1e-7 to 1e-4 rad long."""
    record = Orbit(chapter, rpm, settings(0, 1, tolerance=1e-15)).run()
    ours = [theta for kind, _, theta, *_ in record.events() if kind == EventKind.IMPACT]
    with precision(60):
        motion = BallMotion(BallMachine(chapter.shape, chapter.follower, rpm), 0.0, CORNER_B)
        while len(motion.trail.leaves) < 2:
            motion.step()
        theirs = [phi for phi, _ in motion.trail.impacts if phi < motion.trail.leaves[1]]
    first = [x for x in ours if x < motion.trail.leaves[1]]
    assert len(first) >= 25
    for x, phi in zip(first, theirs, strict=False):
        assert abs(arb(x) - phi) < 8 * 2.0**-51


def same_events(trail, theirs, turns, near):
    """The events (kind, phi, u) of whole turns agree; others of theirs lie in our chatters."""
    end = turns * 2 * arb.pi()
    mine = [("impact", phi, u) for phi, u in trail.impacts]
    mine += [("detachment", phi, arb(0)) for phi in trail.leaves]
    mine = sorted((row for row in mine if row[1] < end), key=lambda row: float(row[1]))
    assert all(phi.rad() < 1e-40 and u.rad() < 1e-40 for _, phi, u in mine)
    others = iter(theirs)
    skipped = []
    for kind, phi, u in mine:
        for other in others:
            if other[0] == kind and (phi + near).contains(other[1]):
                assert (u + near).contains(other[2])
                break
            skipped.append(other)
        else:
            pytest.fail(f"the oracle has no {kind} at {float(phi)}")
    skipped += others
    accumulations = [phi for kind, phi, _ in skipped if kind == "chatter"]
    inside = [c for c in trail.chatters if c < end]
    assert len(accumulations) == len(inside)
    for enclosure, phi in zip(inside, accumulations, strict=True):
        assert (enclosure + arb(0, "1e-12")).contains(phi)
        assert float(enclosure.rad()) < 1.0
    for kind, phi, _ in skipped:
        last = max((x for x, _ in trail.impacts if x < phi), key=float)
        hops = [c for c in trail.chatters if c.upper() > phi and c.lower() < phi + 1]
        assert hops, (kind, float(phi))
        assert last < phi < hops[0].upper()


@pytest.mark.parametrize(
    "shape",
    [
        ARCS,
        EccentricCam(kind="eccentric", base=0.1, lift=0.3),
        law_cam("modified-trapezoid", "cycloidal"),
        law_cam("3-4-5", "constant-velocity"),
        law_cam("modified-sine", "harmonic"),
    ],
    ids=lambda shape: shape.kind,
)
def test_cams_are_the_kernels_and_continuous(shape):
    system = System.build(Follower(1.0, 1000.0), shape)
    with precision(100):
        stretches = BallMachine(shape, system.follower, 100.0).stretches
        for one, after in zip(stretches, [*stretches[1:], stretches[0]], strict=True):
            theta = float(one.start * 0.37 + one.end * 0.63)
            c = one.derivatives(arb(theta), 2)
            table = lift_at(system.cam, stretch_at(system.cam, theta), theta)
            assert [float(x) for x in c] == pytest.approx(table, abs=1e-12, rel=1e-12)
            series = one.derivatives(arb(theta), 4)  # no kind has a closed form for as many
            for x, y in zip(one.derivatives(arb(theta), 3), series, strict=False):
                assert (x - y).contains(0)
                assert (x - y).rad() < 1e-90
            jump = one.derivatives(one.end, 0)[0] - after.derivatives(after.start, 0)[0]
            assert jump.contains(0)
            assert jump.rad() < 1e-90


@pytest.mark.parametrize("dip", [1e-3, 1e-8, 1e-14, 1e-20])
def test_near_grazes_are_told_apart(dip):
    """f = (x - 0.3)^2 +- dip before a sure zero at 1: the pair of zeros is there or it is not."""

    def touching(by):
        def f(x):
            y, rest = x - arb("0.3"), 1 - x
            value, slope = y * y + by, 2 * y
            return [value * rest, slope * rest - value, 2 * rest - 2 * slope]

        return f

    with precision(100):
        assert first_root(touching(arb(dip)), arb(0), arb(2)).contains(1)
        found = first_root(touching(-arb(dip)), arb(0), arb(2))
        assert found.overlaps(arb("0.3") - arb(dip).sqrt())
        assert found.rad() < 1e-60
        assert first_root(touching(arb(dip)), arb(0), arb("0.9")) is None
        with pytest.raises(UndecidedError):
            first_root(touching(arb(0)), arb(0), arb(2))


def test_digits_are_doubled_until_it_is_decided_and_no_further():
    asked = []

    def question(enough):
        asked.append(ctx.dps)
        if ctx.dps < enough:
            raise UndecidedError
        return "yes"

    before = ctx.dps
    assert decided(lambda: question(500)) == "yes"
    assert asked == list(DIGITS[:2])
    with pytest.raises(UndecidedError):
        decided(lambda: question(10**6))
    assert asked[2:] == list(DIGITS)
    assert ctx.dps == before


def test_threads_do_not_share_a_precision():
    found = {}

    def follow(digits):
        with precision(digits):
            phi, _ = followed(
                BallMachine(ARCS, Follower(**CHAPTER), 358.0), CORNER_B, 5
            ).trail.impacts[-1]
            found[digits] = phi.rad() < 10.0 ** (20 - digits)

    threads = [Thread(target=follow, args=(digits,)) for digits in (60, 100, 150, 200)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == dict.fromkeys((60, 100, 150, 200), True)


def test_a_parallelogram_holds_the_image_of_all_its_points():
    with precision(30):
        jacobian = arb_mat([[arb(1, "1e-9"), arb(36.7)], [arb("-0.2"), arb(5.9, "1e-9")]])
        box = Parallelogram.around(arb("0.3", "1e-3"), arb("-2", "1e-4"))
        shift, unit = arb_mat([["1.5"], ["0.25"]]), arb_mat([[1, 0], ["0.3", "0.5"]])
        drift = arb_mat([["3e-2"], ["-2e-2"]])  # of a parameter t from -1 to 1
        corners = [
            (arb_mat([[x], [y]]), t)
            for x in ("0.299", "0.301")
            for y in ("-2.0001", "-1.9999")
            for t in (-1, 1)
        ]
        for _ in range(5):
            image = jacobian.mid() * box.middle + shift
            corners = [
                (image + jacobian.mid() * (at - box.middle) + drift * t, t) for at, t in corners
            ]
            box = box.image(image, jacobian, drift, unit)
            for at, t in corners:
                error = box.frame.inv() * (at - box.middle - box.lean * t)
                assert all(box.error[k, 0].overlaps(error[k, 0]) for k in range(2))
                assert all(x.overlaps(y) for x, y in zip(box.hull(), at.entries(), strict=True))
            assert box.error[0, 0].rad() + box.error[1, 0].rad() < 1e9
        with pytest.raises(UndecidedError):
            box.image(shift, arb_mat([[arb(0, 1)] * 2] * 2), drift, unit)


@pytest.mark.parametrize("rpm", [198.7, 203.0])
def test_all_machines_of_a_speed_hold_each_of_them(rpm):
    """Impacts of the speeds half a digit off lie in those of all speeds that round so."""
    with precision(60):
        every = BallMotion(
            BallMachine.within_last_digit(ARCS, Follower(**CHAPTER), rpm), 0.0, CORNER_B
        )
        beside = [
            BallMotion(BallMachine(ARCS, Follower(**CHAPTER), rpm, share), 0.0, CORNER_B)
            for share in (Fraction("5e-17"), Fraction("-5e-17"))
        ]
        for _ in range(40):
            every.step()
            for one in beside:
                one.step()
        for one in beside:
            for wide, sharp in zip(every.trail.impacts, one.trail.impacts, strict=True):
                assert all(a.contains(b) for a, b in zip(wide, sharp, strict=True))
        assert 1e-16 < float(every.phi.rad()) < 1e-9


@pytest.mark.parametrize("restitution", [0.3, 0.0])
@pytest.mark.parametrize("laws", [("modified-trapezoid", "cycloidal"), ("constant-velocity",) * 2])
def test_laws_and_kinks_agree_with_the_kernel_impact_by_impact(laws, restitution):
    """Strongly damped, so that no error grows: doubles are exact to their rounding."""
    shape = law_cam(*laws)
    follower = Follower(1.0, 3000.0, 10.0, 9.81, 100.0, restitution)
    agrees_with_the_kernel(System.build(follower, shape), 700.0)


def test_a_lift_table_agrees_with_the_kernel_impact_by_impact():
    scene = load_scene("configs/lift-table.yaml")
    follower = Follower(**scene.follower.model_dump())
    agrees_with_the_kernel(System.build(follower, scene.cam), 5000.0)


def agrees_with_the_kernel(system: System, rpm: float):
    tape = Orbit(system, rpm, settings(0, 5)).run()
    _, theta = departures(tape)[0]
    with precision(100):
        motion = followed(BallMachine(system.shape, system.follower, rpm), theta, 3)
        mine = [(motion.phase(phi), float(u)) for phi, u in motion.trail.impacts]
    rows = zip(tape.kind, tape.theta, tape.u, strict=True)
    hits = iter([(at, u) for kind, at, u in rows if kind == EventKind.IMPACT])
    assert len(mine) >= 3
    for impact in mine:  # the kernel's list has more: the last hops of each chatter
        assert any(pytest.approx(impact, abs=1e-8) == hit for hit in hits), impact


def blurred(slope_off: float):
    """1 - x, known to 1e-10 at a point; on an interval its slope may be off by so much."""

    def f(x):
        slope = arb(-1) if x.rad() == 0 else arb(-1, slope_off)
        return [arb(1) - x + arb(0, 1e-10), slope, arb(0)]

    return f


@pytest.mark.parametrize(
    ("off", "enclosed"), [(0.0, True), (0.5, True), (0.9, False), (1.1, False)]
)
def test_a_zero_is_enclosed_where_newtons_step_stays_in_its_room(off, enclosed):
    """Four times as wide as the value is off there; with a slope of -0.1 it would be ten times."""
    with precision(30):
        if enclosed:
            found = first_root(blurred(off), arb(0), arb(3))
            assert found.contains(1)
            assert found.rad() < 4.1e-10
        else:
            with pytest.raises(UndecidedError):
                first_root(blurred(off), arb(0), arb(3))
