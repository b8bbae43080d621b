"""What a certificate of contact states, and what it lists as uncovered."""

from types import SimpleNamespace as Stub

import pytest
from flint import arb

from camcli.analysis.contact_loss import certificate as module
from camcli.analysis.contact_loss.accumulation import CornerHit
from camcli.analysis.contact_loss.certificate import Hits, NoStatement, _ranges
from camcli.analysis.contact_loss.detachment import CriticalQuantity, CriticalSpeed, SpeedStatus
from camcli.analysis.contact_loss.study import _past_speeds
from camcli.exact.shooting import Place

LIFT_OFF = 2.5  # rad, of the burst that is known


def hit(n, status=SpeedStatus.OK, burst="A2"):
    return CornerHit(n, "c", 120.0 + n, 120.0, 130.0, status, burst)


def first(rpm=114.9):
    return CriticalSpeed(next(iter(CriticalQuantity)), "A2", LIFT_OFF, rpm, rpm, rpm,
                         SpeedStatus.OK)  # fmt: skip


@pytest.mark.parametrize(
    ("why", "speed", "hits", "stated", "uncovered"),
    [
        (None, first(), [hit(1), hit(2)], ["first", 1], ["hit 2"]),  # the second has no proof
        (None, None, [hit(1)], [1], []),
        (None, first(float("inf")), [hit(1)], [1], []),
        (None, first(), [hit(1, SpeedStatus.UNRESOLVED), hit(1, burst="A5"), hit(3)],
         ["first", 3], []),
        (NoStatement.INSIDE, first(), [hit(1)], ["first", 1], []),  # not for the cam's sake
        (NoStatement.NO_SPEED, None, [hit(1)], [1], []),
        (NoStatement.LASH, first(), [hit(1)], [], ["first", "hit 1"]),
        (NoStatement.FITTED, first(), [hit(1)], [], ["first", "hit 1"]),
        (NoStatement.KINKED, first(), [hit(1)], [], ["first", "hit 1"]),
    ],
)  # fmt: skip
def test_what_has_no_statement_is_uncovered(monkeypatch, why, speed, hits, stated, uncovered):
    """Corner hits count that are bracketed, of a lift-off that is known."""
    monkeypatch.setattr(module, "no_statement", lambda *asked: why)
    monkeypatch.setattr(module, "detachment_statement", lambda system, one: "first")
    monkeypatch.setattr(
        module, "corner_statement",
        lambda system, one, theta: one.impact if theta == LIFT_OFF and one.impact != 2 else None,
    )  # fmt: skip
    losses = [
        Stub(region=Stub(name=name), opens=Stub(theta=theta), fills=Stub(theta=8.0))
        for name, theta in (("A1", 9.0), ("A2", LIFT_OFF), ("A3", 7.0))
    ]

    def name_of(one):
        return "first" if isinstance(one, CriticalSpeed) else f"hit {one.impact}"

    found = module.certificate("system", Stub(first=speed, losses=losses), hits, "cam", name_of)
    assert found["statements"] == stated
    assert found["uncovered"] == uncovered
    assert (found["format"], found["cam"]) == (module.FORMAT, "cam")


@pytest.mark.parametrize(
    ("never", "first_rpm", "rpms", "count", "past"),
    [
        (True, None, [100.0, 200.0], 3, []),
        (False, 250.0, [100.0, 200.0], 3, []),
        (False, 200.0, [100.0, 200.0], 3, []),  # only the loss itself is left
        (False, 100.0, [200.0, 50.0], 3, [150.0, 200.0]),  # the loss itself is left out
        (False, 120.0, [120.0, 200.0], 5, [140.0, 160.0, 180.0, 200.0]),
        (False, 50.0, [100.0, 200.0], 3, [100.0, 150.0, 200.0]),
        (False, 50.0, [150.0], 3, [150.0]),
        (False, None, [100.0, 200.0], 3, [100.0, 150.0, 200.0]),  # lost at every speed
        (False, None, [150.0], 3, [150.0]),
    ],
)
def test_at_which_speeds_the_motion_past_the_loss_is_measured(never, first_rpm, rpms, count, past):
    lost = Stub(never=never, first=first_rpm and Stub(rpm=first_rpm))
    assert _past_speeds(lost, rpms, count) == pytest.approx(past)


def test_an_impact_of_a_range_of_speeds_lies_between_those_at_both_ends_with_room():
    """Whichever of the two speeds has the later impact; the phase counts within its turn."""
    half_turns = [Stub(start=arb(0), end=arb.pi()), Stub(start=arb.pi(), end=2 * arb.pi())]
    at_low = Hits([arb(1), arb(4) + 2 * arb.pi(), arb(2)], [arb("0.5"), arb("0.2"), arb(9)])
    at_high = Hits(
        [arb("1.5"), arb("3.5") + 2 * arb.pi(), arb(2)], [arb("0.4"), arb("0.3"), arb(9)]
    )
    for ends in ((at_low, at_high), (at_high, at_low)):
        one, two = _ranges(half_turns, *ends, 2)
        assert (one.place, two.place) == ((0, 0), (1, 1))
        for ball, (low, high) in (
            (one.phase, ("1", "1.5")), (one.rate, ("0.4", "0.5")),
            (two.phase, ("3.5", "4")), (two.rate, ("0.2", "0.3")),
        ):  # fmt: skip
            room = arb("0.999e-12")
            assert ball.contains(arb(low) - room)
            assert ball.contains(arb(high) + room)
            assert float(ball.rad()) < (float(high) - float(low)) / 2 + 1e-8
    assert float(_ranges(half_turns, at_low, at_high, 3)[2].rate.rad()) == pytest.approx(1e-12)


@pytest.mark.parametrize("last", [Place(0, 1), Place(1, 0)])
def test_a_statement_on_a_corner_is_of_the_impacts_at_both_ends_of_its_speeds(monkeypatch, last):
    """The first flight lifts off; as many turns are passed as the latest impact needs."""
    before = [
        module._ImpactRange(Place(1, 2), arb("1.5", 0.25), arb("0.5")),
        module._ImpactRange(last, arb(2, 0.125), arb("0.25")),
    ]
    corner = Place(0, 1)
    stretches = [Stub(start=arb(1), end=arb(3)), Stub(start=arb(3), end=arb(7))]
    asked = Stub(ranges=[], flights=[], impacts=[])

    def impacts(*of):
        asked.impacts.append(of)
        return ("at", float(of[3]))

    def speed(of, impacts_at, hit):
        assert (of, hit) == (stretches, made)
        return corner, arb(120)

    monkeypatch.setattr(module, "_impacts", impacts)
    monkeypatch.setattr(module, "_speed_of_hit", speed)
    monkeypatch.setattr(module, "_end", lambda rpm, side: rpm + side)
    monkeypatch.setattr(module, "_ranges", lambda *of: (asked.ranges.append(of), before)[1])
    monkeypatch.setattr(module, "Shooting", lambda **more: Stub(**more))
    monkeypatch.setattr(module, "_constants", lambda system: "constants")
    monkeypatch.setattr(
        module, "divided_flight",
        lambda shooting, hull, k, lifts: (asked.flights.append((shooting, hull, k, lifts)), k)[1],
    )  # fmt: skip
    made = Stub(impact=3)
    found = module._corner_statement(Stub(shape="shape", follower="f"), stretches, 1, made)
    assert asked.ranges == [(stretches, ("at", 119.0), ("at", 121.0), 2)]
    assert {of[2:3] + of[4:] for of in asked.impacts} == {(1, 3)}
    assert [(k, lifts) for _, _, k, lifts in asked.flights] == [(0, True), (1, False), (2, False)]
    shooting, hull = asked.flights[0][:2]
    assert (shooting.shape, shooting.follower, shooting.rpm) == ("shape", "f", None)
    assert (shooting.parameter, shooting.turns) == ("rpm", 3)
    assert shooting.places == (Place(1, 0), Place(1, 2), last, corner)
    assert [float(x.mid()) for x in hull] == [3.0, 0.0, 1.5, 0.5, 2.0, 0.25, 3.0, 0.0, 120.0]
    assert hull[-1].contains(119)
    assert hull[-1].contains(121)
    assert (found["kind"], found["constants"], found["start"]) == ("corner-hit", "constants", 1)
    assert (found["low"], found["high"], found["flights"]) == ("119", "121", [0, 1, 2])
    assert found["corner"] == {"stretch": 0, "turn": 1}
    places = [(one["stretch"], one["turn"]) for one in found["impacts"]]
    assert places == [(1, 2), tuple(last)]
    ends = [float(one[end]) for one in found["impacts"] for end in ("low", "high")]
    assert ends == pytest.approx([1.25, 1.75, 1.875, 2.125], abs=1e-8)
