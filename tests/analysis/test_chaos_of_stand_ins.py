"""Boxes that cover one another, and the search for them, on maps that are written down here."""

from __future__ import annotations

from math import log, pi
from types import SimpleNamespace as Stub

import numpy as np
import pytest
from conftest import settings
from flint import arb, arb_mat

from camcli.analysis.chaos import covering, homoclinic
from camcli.analysis.chaos.covering import BoxFlights, CellOfBox, _beside, _Impacts, covers, proved
from camcli.analysis.chaos.homoclinic import (
    Frame,
    Impact,
    ImpactMap,
    LandedPoints,
    MapSaddle,
    _box_over,
    _covers,
    _placed,
    _room,
    candidates,
    saddle_of,
)
from camcli.analysis.chaos.section import Chaos, Lands, SectionBox
from camcli.exact.shooting import NotProvedError, ProofStep
from camcli.kernel.orbit_loop import CHATTER, IMPACT

TURN = 2.0 * pi
STRETCHES = [Stub(start=0.0, end=1.0), Stub(start=1.0, end=3.0), Stub(start=3.0, end=TURN)]
SYSTEM = Stub(cam=Stub(stretches=STRETCHES), strobe=2.0)
LANDS = Lands(1, 1, 0.0, 0.0)


def box(middle=(2.0, 0.5), axes=((0.5, 0.0), (0.0, 0.25)), stretch=1, **more) -> SectionBox:
    return SectionBox(stretch, middle, axes, LANDS, **more)


# -- impacts


@pytest.mark.parametrize(
    ("start", "events", "turns"),
    [
        (3.5, [(-1, 5.0), (-1, 1.0), (0, 3.0), (0, 1.5), (1, 2.5)], [0, 1, 1, 2, 2]),
        (2.0, [(0, 2.5), (0, 1.0), (1, 2.0), (2, 0.5)], [0, 1, 1, 3]),
        (1.0, [(-1, 1.5), (0, 2.5), (0, 0.5), (1, 1.75)], [0, 0, 1, 2]),
    ],
)
def test_the_turns_of_impacts_count_from_that_of_the_start(monkeypatch, start, events, turns):
    """A record counts its turns from the strobe at 2 rad; the cam's begin at zero."""
    monkeypatch.setattr(homoclinic, "stretch_at", lambda cam, theta: 1 + (theta > 2.0))
    system = Stub(cam="cam", strobe=2.0, restitution=lambda stretch: 0.25 * stretch)
    rows = [(IMPACT, period, theta, 0.0, -2.0) for period, theta in events]
    found = ImpactMap(system, 700.0, None)._impacts(start, Stub(events=lambda: rows))
    assert [one.turn for one in found] == turns
    for one, (_, theta) in zip(found, events, strict=True):
        stretch = 1 + (theta > 2.0)
        assert one[:3] == (theta, 0.5 * stretch, stretch)
    rested = [*rows[:2], (CHATTER, 0, 2.1, 0.0, 0.0), *rows[2:]]
    found = ImpactMap(system, 700.0, None)._impacts(start, Stub(events=lambda: rested))
    assert [one.turn for one in found] == turns[:2]


def test_chains_begin_on_the_cam_at_the_phases_of_their_starts(monkeypatch):
    """A start may be given turns away from the first one; velocities are relative to the cam's."""
    made = []
    monkeypatch.setattr(homoclinic, "lift_at", lambda cam, stretch, phase: (phase, 10.0, 0.0))
    monkeypatch.setattr(homoclinic, "stretch_at", lambda cam, phase: None)
    monkeypatch.setattr(
        homoclinic, "Orbit", lambda system, rpm, settings, start: made.append((settings, start))
    )
    monkeypatch.setattr(homoclinic, "run_all", lambda orbits, strobes: ["first", "second"])
    one = ImpactMap(SYSTEM, 700.0, settings(40, 7))
    one._impacts = lambda start, record: (start, record)
    points = np.array([[2.0 * TURN + 0.5, 1.5], [0.25, 0.75]])
    chains = one.chains(points, 3)
    assert chains == [(pytest.approx(0.5), "first"), (1.5, "second")]
    omega = 700.0 * pi / 30.0
    for (asked, start), phase, v in zip(made, (0.5, 1.5), (0.25, 0.75), strict=True):
        assert (asked.transient, asked.record) == (0, 3)
        assert (start.q, start.v) == pytest.approx((phase, (10.0 + v) * omega))
        assert start.theta == pytest.approx(phase)


@pytest.mark.parametrize(
    ("places", "lands"),
    [
        ([(4, 1), (4, 1)], True), ([(4, 1), (5, 1)], False), ([(4, 1), (4, 2)], False),
        ([(4, 1), None], False), ([None, None], False), ([None, (4, 1)], False),
    ],
)  # fmt: skip
def test_flights_have_an_image_where_all_land_on_one_stretch(places, lands):
    asked = []
    chains = [
        [] if place is None else [Impact(0.5 + k, 0.25 - k, *place), Impact(9.0, 9.0, 9, 9)]
        for k, place in enumerate(places)
    ]
    one = ImpactMap(SYSTEM, 700.0, None)
    one.chains = lambda points, turns: asked.append((points, turns)) or chains
    found = one.image("points")
    assert asked == [("points", 3)]
    assert (found is not None) == lands
    if lands:
        assert (found.points.tolist(), found.stretch, found.turn) == (
            [[0.5, 1.5], [0.25, -0.75]],
            4,
            1,
        )


@pytest.mark.parametrize(
    ("root", "stable", "edge"),
    [
        (Stub(count=2, x=[2.0, 0.5]), False, False), (None, False, False),
        (Stub(count=1, x=[2.0, 0.5]), True, False), (Stub(count=1, x=[2.0, 0.5]), False, True),
    ],
)  # fmt: skip
def test_an_orbit_that_is_no_saddle_of_one_impact(root, stable, edge):
    slopes = np.array([[2.0, 0.1], [0.2, 0.5]])
    impact_map = Stub(slopes=lambda *_: None if edge else slopes, system=SYSTEM)
    orbit = Stub(root=root, stable=stable, label="P(1;1)", turns=1)
    assert saddle_of(impact_map, orbit) is None


# -- chains


def a_saddle(mu=2.0, theta=1.25, turns=3) -> MapSaddle:
    directions = np.array([[1.0, 1.0], [0.5, -0.25]])
    return MapSaddle("P(1;1)", turns, Impact(theta, 0.5, 1, 0), (mu, 0.25), directions)


@pytest.mark.parametrize(("theta", "room"), [(1.25, 0.25), (2.875, 0.125), (2.0, 1.0)])
def test_the_room_of_a_saddle_is_the_way_to_the_nearer_end_of_its_stretch(theta, room):
    assert _room(SYSTEM, a_saddle(theta=theta)) == room


@pytest.mark.parametrize("mu", [3.0, -3.0])
def test_chains_are_sought_along_one_turn_of_the_multiplier_on_each_side(monkeypatch, mu):
    """Or along two on one side, where it is negative. Four hundred intervals on each; one gives a
    chain where it changes sides first, and twelve chains are kept."""
    saddle, asked, refined = a_saddle(mu), [], []

    def chains(points, turns):
        asked.append((points, turns))
        return [(len(asked), k) for k in range(401)]

    changes = {(1, 399): 2, (1, 0): 3, (1, 7): 15, (2, 5): 2, (2, 3): 4, (1, 11): 1, (1, 12): 16}
    changes |= {(1, 100 + k): 5 + k for k in range(9)}

    def changed(of, chain, other, n, room):
        assert (of, room) == (saddle, 0.25)
        assert other == (chain[0], chain[1] + 1)
        return n >= changes.get(chain, 99)  # as often as it likes from there on

    def refine(impact_map, of, low, high, n, turns):
        refined.append((low, high, n, turns))
        return len(refined)

    monkeypatch.setattr(homoclinic, "_changes", changed)
    monkeypatch.setattr(homoclinic, "_refined", refine)
    monkeypatch.setattr(
        homoclinic, "_chain_from", lambda impact_map, of, start, turns: [start] * 30
    )
    found = homoclinic.homoclinic(Stub(system=SYSTEM, chains=chains), saddle)
    span = 3.0 if mu > 0.0 else 9.0
    starts = [1e-3 * span ** (k / 400.0) for k in range(401)]
    sides = (1.0, -1.0) if mu > 0.0 else (1.0,)
    assert len(asked) == len(sides)
    for (points, turns), side in zip(asked, sides, strict=True):
        wanted = np.array([[1.25], [0.5]]) + np.array([[1.0], [0.5]]) * side * np.array(starts)
        assert points == pytest.approx(wanted, rel=1e-12)
        assert turns == (16 + 6) * 3
    first = [(11, 2), (399, 2), (0, 3), *((100 + k, 5 + k) for k in range(9)), (7, 15)]
    intervals = [(k, n, 1.0) for k, n in first]
    intervals += [(5, 2, -1.0), (3, 4, -1.0)] if mu > 0.0 else []
    for (k, n, side), (low, high, at, turns) in zip(intervals, refined, strict=True):
        assert (low, high) == pytest.approx((side * starts[k], side * starts[k + 1]))
        assert (at, turns) == (n, 66)
    by_length = sorted(enumerate(intervals, 1), key=lambda one: one[1][1])[:12]
    assert found == [[number] * (1 + n + 6) for number, (_, n, _) in by_length]


def test_the_boxes_of_the_shortest_loops_are_tried_first_of_these_the_largest(monkeypatch):
    monkeypatch.setattr(homoclinic, "homoclinic", lambda impact_map, of: ["a", "edge", "b"])
    monkeypatch.setattr(
        homoclinic, "frames", lambda impact_map, of, chain: None if chain == "edge" else chain * 2
    )
    tried, sizes = [], []

    def cut(of, chain, along, across):
        sizes.append((chain, along, across))
        if chain == "a":
            return range(2, 7) if along > 0.09 else None
        return range(1, 4) if along < 0.11 else range(3, 8)

    def boxes(impact_map, of, loop):
        tried.append(loop)
        return f"chaos {len(tried)}" if len(tried) in (2, 5) else None

    monkeypatch.setattr(homoclinic, "_cut", cut)
    monkeypatch.setattr(homoclinic, "_boxes", boxes)
    assert list(candidates(Stub(system=SYSTEM), a_saddle())) == ["chaos 2", "chaos 5"]
    room = 0.25  # of the saddle; reach and width together stay within it
    fit = [(0.6, 0.6), (0.5, 0.8), (0.5, 0.6)]
    fit += [(0.4, width) for width in (1.0, 1.2, 0.8, 0.6)]
    fit += [(reach, width) for reach in (0.3, 0.2, 0.1) for width in (1.0, 1.2, 0.8, 1.5, 0.6)]
    assert sizes == [
        (chain, pytest.approx(reach * room), pytest.approx(reach * width * room))
        for chain in "ab" for reach, width in fit
    ]  # fmt: skip
    wanted = [("b", *one) for one in fit if one[0] < 0.44]
    for reach in (0.6, 0.5, 0.4):
        longer = "ab" if reach > 0.44 else "a"
        wanted += [(chain, *one) for chain in longer for one in fit if one[0] == reach]
    for loop, (chain, reach, width) in zip(tried, wanted, strict=True):
        assert (loop.chain, loop.frames) == (chain, chain * 2)
        assert (loop.along, loop.across) == pytest.approx((reach * room, reach * width * room))
        assert loop.cut == cut(None, chain, loop.along, loop.across)


# -- boxes


class LinearMap:
    """An impact map that is linear about (2, 0.5), and lands on a stretch in a turn."""

    def __init__(self, slopes=((2.0, 0.5), (0.25, -0.125)), stretch=1, none=False):
        self.slopes_of, self.stretch, self.none = np.array(slopes), stretch, none
        self.system, self.rpm = SYSTEM, 700.0

    def image(self, points):
        at = np.array([[2.0], [0.5]])
        landed = at + self.slopes_of @ (points - at)
        return None if self.none else LandedPoints(landed, self.stretch, 2)


def test_a_box_has_few_digits_and_where_its_flights_land():
    axes = np.array([[0.123456789, -0.00987654321], [0.0333333333, 0.25]])
    found = _placed(LinearMap(), 1, np.array([1.98765432198, 0.555555555555]), axes)
    assert found.middle == (1.9876543, 0.55555556)
    assert found.axes == ((0.123457, -0.00987654), (0.0333333, 0.25))
    corners = [
        2.0 * (-0.0123457 + 0.123457 * x - 0.00987654 * y)
        + 0.5 * (0.05555556 + 0.0333333 * x + 0.25 * y)
        for x in (-1, 1) for y in (-1, 1)
    ]  # fmt: skip
    assert (found.lands.low, found.lands.high) == pytest.approx(
        (2 + min(corners), 2 + max(corners))
    )
    assert (found.stretch, found.lands.stretch, found.lands.turn) == (1, 1, 2)


@pytest.mark.parametrize(
    ("impact_map", "middle", "stretch", "is_one"),
    [
        (LinearMap(), 2.0, 1, True), (LinearMap(none=True), 2.0, 1, False),
        (LinearMap(), 2.0, 2, False),  # it lies on another stretch
        (LinearMap(), 1.25, 1, False),  # it reaches beyond an end of the stretch
        (LinearMap(), 2.75, 1, False), (LinearMap(stretch=2), 2.0, 1, False),
        (LinearMap(((5.0, 0.0), (0.0, 0.1))), 2.0, 1, False),  # it lands beyond both
        (LinearMap(((2.0, 0.0), (0.0, 0.1))), 2.3, 1, False),  # beyond one
        (LinearMap(((2.0, 0.0), (0.0, 0.1))), 1.7, 1, False),
    ],
)  # fmt: skip
def test_a_box_lies_and_lands_inside_of_one_stretch(impact_map, middle, stretch, is_one):
    axes = np.array([[0.2, 0.1], [0.0, 0.1]])
    found = _placed(impact_map, stretch, np.array([middle, 0.5]), axes)
    assert (found is not None) == is_one


@pytest.mark.parametrize(("spread", "half"), [(0.1, 0.55 * 0.1), (1e-5, 0.02 * 0.3)])
def test_a_box_about_an_impact_holds_the_image_before_it_across(monkeypatch, spread, half):
    """A tenth wider than it, but a fiftieth of its length at least; about its middle."""
    monkeypatch.setattr(homoclinic, "_placed", lambda *given: given)
    axes = np.array([[1.0, 0.5], [0.25, -1.0]])
    place = np.array([2.0, 0.5])
    along = np.array([-0.4, 0.3, 0.7])
    across = 0.05 + spread * np.array([0.0, 1.0, 0.25])
    points = place[:, None] + axes @ np.array([along, across])
    image = LandedPoints(points, 1, 2)
    of_map, stretch, middle, box_axes = _box_over("map", Impact(*place, 4, 7), axes, 0.3, image)
    assert (of_map, stretch) == ("map", 4)
    assert middle == pytest.approx(place + axes[:, 1] * (0.05 + 0.5 * spread))
    assert box_axes == pytest.approx(axes * np.array([0.3, half]))


@pytest.mark.parametrize(
    ("slopes", "stretch", "does"),
    [
        (((2.5, 0.0), (0.0, 0.5)), 1, True),
        (((-2.5, 0.0), (0.0, -0.5)), 1, True),
        (((2.5, 0.0), (0.0, 0.5)), 2, False),  # elsewhere
        (((0.95, 0.0), (0.0, 0.5)), 1, False),  # too short
        (((2.5, 0.0), (0.0, 1.05)), 1, False),  # too wide
        (((2.5, 0.0), (1.1, 0.0)), 1, False),
        (((2.5, 2.9), (0.0, 0.5)), 1, True),  # slanted: its ends stay on their sides
        (((2.5, 3.1), (0.0, 0.5)), 1, False),
        (((-2.5, 3.1), (0.0, 0.5)), 1, False),
    ],
)
def test_samples_of_a_box_are_mapped_over_itself(slopes, stretch, does):
    """The box is 0.5 by 0.25 to either side."""
    assert _covers(LinearMap(slopes, stretch), box(), box()) is does
    assert not _covers(LinearMap(slopes, stretch, none=True), box(), box())


def test_the_boxes_along_a_loop(monkeypatch):
    """The lengths go backwards: a tenth more than what makes the next image long enough."""
    placed, over, covered = [], [], []
    monkeypatch.setattr(
        homoclinic, "_placed", lambda *given: placed.append(given) or box((1.0, 0.0))
    )
    monkeypatch.setattr(
        homoclinic, "_box_over",
        lambda *given: over.append(given)
        or (None if len(over) == fails else box((len(over), 1.0))),
    )  # fmt: skip
    monkeypatch.setattr(
        homoclinic, "_covers",
        lambda of, one, other: covered.append((one.middle[0], other.middle[0])) or fails != 9,
    )  # fmt: skip
    some_map = LinearMap()
    chain = [Impact(0.1 * k, 1.0, k, k) for k in range(5)]
    frames = [Frame(np.full((2, 2), float(k)), (-1.0) ** k * (k + 2.0)) for k in range(5)]
    loop = homoclinic.Loop(chain, frames, 0.3, 0.1, range(1, 3))
    saddle = a_saddle()
    fails = 0
    found = homoclinic._boxes(some_map, saddle, loop)
    ((of_map, stretch, at, axes),) = placed
    assert (of_map, stretch, at.tolist()) == (some_map, 1, [1.25, 0.5])
    assert axes == pytest.approx(saddle.directions * np.array([0.3, 0.1]))
    lengths = [0.3 * 1.1 / 4.0 * 1.1 / 3.0, 0.3 * 1.1 / 4.0]
    for k, (given, length) in enumerate(zip(over, lengths, strict=True), 1):
        assert given[:2] == (some_map, chain[k])
        assert given[2] is frames[k].axes
        assert given[3] == pytest.approx(length, rel=1e-12)
    assert found.coverings == ((0, 0), (0, 1), (1, 2), (2, 0))
    assert covered == [(1.0, 1.0), (1.0, 1), (1, 2), (2, 1.0)]
    assert (found.rpm, found.label, len(found.boxes)) == (700.0, "P(1;1)", 3)
    for which in (1, 2, 9):
        over.clear()
        fails = which
        assert homoclinic._boxes(some_map, saddle, loop) is None
    fails = 0
    assert homoclinic._boxes(LinearMap(none=True), saddle, loop) is None


# -- the proof


def cells_of(along=3.0, across=0.5, shear=0.0, offset=0.0, low=0.0, other=None):
    """Two cells of a box, left and right, whose x is mapped to 3 x + shear y + offset and so on."""
    other = other or box()
    axes = np.array(other.axes)
    slopes = axes @ np.array([[along, shear], [0.0, across]])
    found = []
    for middle in (-0.5, 0.5):
        place = np.array(other.middle) + axes @ np.array([along * middle + offset, low])
        reach = (arb(0, 0.5), arb(0, 1.0))
        found.append(
            CellOfBox(
                [arb(middle)],
                tuple(arb(float(x)) for x in place),
                arb_mat(slopes.tolist()),
                reach,
                {},
            )
        )
    return found


@pytest.mark.parametrize(
    ("how", "does"),
    [
        ({}, True), ({"along": -3.0}, True), ({"across": -0.5}, True),
        ({"across": 0.9985}, True), ({"across": 0.9995}, False), ({"across": -0.9995}, False),
        ({"low": 0.495}, True), ({"low": 0.505}, False), ({"low": -0.505}, False),
        ({"along": 1.002}, True), ({"along": 1.0005}, False), ({"along": -1.0005}, False),
        ({"shear": 1.99}, True), ({"shear": 2.01}, False),
        ({"offset": 1.9}, True), ({"offset": 2.1}, False), ({"offset": 10.0}, False),
    ],
)  # fmt: skip
def test_what_it_takes_that_a_box_covers_another(how, does):
    assert covers(cells_of(**how), [box()]) is does
    slanted = box((1.0, -2.0), ((0.5, 0.125), (-0.25, 0.25)))
    cells = cells_of(other=slanted, **how)
    assert covers(cells, [slanted]) is does
    assert covers(cells, [slanted, box()]) is False  # both have to be
    assert covers(cells, []) is True


def test_a_box_that_no_cell_reaches_the_ends_of_is_not_covered():
    middle = [cell._replace(ends=[]) for cell in cells_of()]
    assert covers(middle, [box()]) is False
    both = [cells_of()[0], cells_of(along=-3.0)[1]]
    assert covers(both, [box()]) is False  # both ends are mapped to one side


@pytest.mark.parametrize(
    ("other", "beside", "beside_it"),
    [
        (box((2.0, 0.0), ((1.0, 0.0), (0.0, 1.0))), False, False),
        (box((2.0005, 0.0), ((1.0, 0.0), (0.0, 1.0))), False, False),  # by less than the slack
        (box((2.002, 0.0), ((1.0, 0.0), (0.0, 1.0))), True, True),
        (box((0.0, -2.002), ((1.0, 0.0), (0.0, 1.0))), True, True),
        (box((1.9, 1.9), ((0.5, 0.5), (0.5, -0.5))), False, True),  # a corner beside a side
    ],
)
def test_a_box_beside_another_along_one_of_its_axes(other, beside, beside_it):
    unit = box((0.0, 0.0), ((1.0, 0.0), (0.0, 1.0)))
    assert _beside(unit, other) is beside
    assert _beside(other, unit) is beside_it


UNIT = ((1.0, 0.0), (0.0, 1.0))
CORNERS = (box((1.9, 1.9), ((0.5, 0.5), (0.5, -0.5))), box((0.0, 0.0), UNIT))


@pytest.mark.parametrize(
    ("boxes", "coverings", "step"),
    [
        (CORNERS, ((0, 0), (0, 1), (1, 0)), None), (CORNERS[::-1], ((0, 0), (0, 1), (1, 0)), None),
        ((box((0.0, 0.0), UNIT), box((1.5, 0.0), UNIT)), ((0, 0), (0, 1), (1, 0)),
         ProofStep.COVERING),  # they overlap
        ((box((0.0, 0.0), UNIT), box((1.5, 0.0), UNIT, stretch=2)), ((0, 0), (0, 1), (1, 0)), None),
        (CORNERS, ((0, 1), (1, 0)), ProofStep.COVERING),  # a cycle alone grows by nothing
    ],
)  # fmt: skip
def test_chaos_is_proved_of_boxes_apart_that_cover_others(monkeypatch, boxes, coverings, step):
    asked = []

    def divided(flights, others):
        asked.append((flights.box, list(others), flights.shape, flights.follower, flights.rpm))
        cells = [Stub(flight={"cell": len(asked)}), Stub(flight={"cell": -len(asked)})]
        return covering.DividedBox(len(asked), 5, cells)

    monkeypatch.setattr(covering, "_divided", divided)
    rpm = arb(700)
    found = proved(Chaos(700.0, "P(1;1)", boxes, coverings), "shape", "follower", rpm)
    assert found.step == step
    if asked:
        wanted = [(one, [boxes[j] for i, j in coverings if i == k]) for k, one in enumerate(boxes)]
        assert [one[:2] for one in asked] == wanted
        assert all(one[2:] == ("shape", "follower", rpm) for one in asked)
        assert [one.cells for one in found.boxes] == [(1, 5), (2, 5)]
        assert found.flights == (({"cell": 1}, {"cell": -1}), ({"cell": 2}, {"cell": -2}))
    if step is None:
        assert found.per_impact == pytest.approx(log((1.0 + 5.0**0.5) / 2.0), abs=1e-8)


@pytest.mark.parametrize(
    ("fails", "covered", "divided"),
    [
        ({}, {(1, 1)}, (1, 1)), ({(1, 1): ProofStep.GRAZES}, {(2, 1)}, (2, 1)),
        ({}, {(16, 8), (32, 16)}, (16, 8)), ({}, {(32, 16)}, (32, 16)),
        ({}, set(), ProofStep.COVERING),
        (dict.fromkeys(covering.TRIED, ProofStep.PULLS), set(), ProofStep.PULLS),
        ({(1, 1): ProofStep.GRAZES}, set(), ProofStep.COVERING),
        ({(1, 1): ProofStep.GRAZES, (32, 16): ProofStep.PULLS}, set(), ProofStep.PULLS),
    ],
)  # fmt: skip
def test_a_box_is_divided_until_it_covers(monkeypatch, fails, covered, divided):
    def cells(columns, rows):
        if (columns, rows) in fails:
            raise NotProvedError(fails[columns, rows])
        return [(columns, rows)]

    monkeypatch.setattr(covering, "covers", lambda of, others: of[0] in covered)
    if isinstance(divided, ProofStep):
        with pytest.raises(NotProvedError) as failed:
            covering._divided(Stub(cells=cells), ["others"])
        assert failed.value.step == divided
    else:
        found = covering._divided(Stub(cells=cells), ["others"])
        assert found == (*divided, [divided])


def impacts(theta=(2.0, 0.1), v=(0.5, 0.2)) -> _Impacts:
    middle = arb(theta[0]), arb(v[0])
    spread = arb_mat([[arb(0, theta[1])], [arb(0, v[1])]])
    return _Impacts(middle, (arb(*theta), arb(*v)), spread)


def test_flights_are_expected_to_land_within_a_fifth_more_than_their_slopes_say(monkeypatch):
    """3 x 0.1 + 1 x 0.2 to either side of 2 rad, and a digit more."""
    asked = []
    monkeypatch.setattr(covering, "flight_map", lambda flight: arb_mat([[3, -1], [7, 8]]))
    flights = Stub(_flight=lambda start, end: asked.append((start, end)))
    some = impacts()
    low, high = BoxFlights._landings(flights, some, arb(2))
    assert asked == [(some.wide, arb(2))]
    assert (low, high) == pytest.approx((1.4, 2.6), abs=6e-9)
    assert (low, high) == (round(low, 9), round(high, 9))


@pytest.mark.parametrize(
    ("how", "step"),
    [
        ({}, None),
        ({"theta": (2.95, 0.1)}, ProofStep.ELSEWHERE),
        ({"theta": (1.05, 0.1)}, ProofStep.ELSEWHERE),
        ({"low": 2.9}, ProofStep.ELSEWHERE), ({"high": TURN + 0.1}, ProofStep.ELSEWHERE),
        ({"v": (0.2, 0.3)}, ProofStep.PULLS),  # it may not bounce
        ({"v": (-0.5, 0.2)}, ProofStep.PULLS),
        ({"before": 0.44}, ProofStep.CONTACT), ({"behind": -0.44}, ProofStep.CONTACT),
        ({"before": -1.0}, ProofStep.CONTACT), ({"behind": 1.0}, ProofStep.CONTACT),
        ({"by_theta": 3.0}, ProofStep.CONTACT), ({"by_v": -2.0}, ProofStep.CONTACT),
    ],
)  # fmt: skip
def test_what_shows_that_flights_land_between_two_phases(how, step):
    """Above the cam at the first phase and below it at the second, by 0.46 m; the spread makes
    2.5 x 0.1 + 1 x 0.2 m of it."""
    given = {"theta": (2.0, 0.1), "v": (0.5, 0.2), "low": 4.0, "high": 5.0, "before": 0.46,
             "behind": -0.46, "by_theta": 2.5, "by_v": 1.0, **how}  # fmt: skip
    some = impacts(given["theta"], given["v"])

    def flight(start, end):
        if start is some.wide:
            slopes = Stub(gap_by_theta=arb(given["by_theta"]), gap_by_v=arb(given["by_v"]))
            return Stub(by_start=slopes)
        assert start is some.middle
        return Stub(gap=arb(given["before"] if end == arb(given["low"]) else given["behind"]))

    shooting = Stub(places=(Stub(stretch=1), Stub(stretch=2)), stretches=STRETCHES)
    shooting.stretches = [Stub(start=arb(one.start), end=arb(one.end)) for one in STRETCHES]
    flights = Stub(shooting=shooting, _flight=flight)
    if step is None:
        BoxFlights._show_landings(flights, some, given["low"], given["high"])
        return
    with pytest.raises(NotProvedError) as failed:
        BoxFlights._show_landings(flights, some, given["low"], given["high"])
    assert failed.value.step == step


def test_how_far_a_box_reaches():
    assert box(axes=((0.5, -0.25), (-1.0, 2.0))).reach == (0.75, 3.0)
