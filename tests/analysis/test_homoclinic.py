"""A saddle of the example at 745 rpm, its directions, and the chains that lead back to it.

mpmath has the orbit and its multipliers; each impact of a chain is followed by the next one.
"""

from __future__ import annotations

from functools import cache
from math import pi
from types import SimpleNamespace

import numpy as np
import pytest

import camcli
from camcli.analysis.chaos.homoclinic import (
    Impact,
    ImpactMap,
    _changes,
    _cut,
    candidates,
    frames,
    homoclinic,
    saddle_of,
)
from camcli.api.machine import machine_of
from tests.support import orbit_oracle
from tests.support.orbit_oracle import CAM, CHAPTER, STABLE

RPM = 745.0
TURN = 2.0 * pi


@cache
def known():
    """(map, orbits, P(1;1) by mpmath); its unstable one has doubled its period."""
    scene = camcli.load_scene(None, {"run.rpm": RPM, "run.transient": 50, "run.record": 40})
    machine = machine_of(scene)
    values = {"orbits.at": RPM, "orbits.rpm": {"start": RPM, "stop": RPM, "num": 1},
              "orbits.starts": 0}  # fmt: skip
    orbits = camcli.orbits(camcli.load_scene(None, values)).values.orbits
    exact = orbit_oracle.solve(CAM, CHAPTER, RPM, STABLE, 1)
    return ImpactMap(machine.system, RPM, machine.settings), orbits, exact


@cache
def saddle():
    """The one of mpmath's guess, which is the orbit that was stable at lower speeds."""
    impact_map, orbits, exact = known()
    (orbit,) = [one for one in orbits if one.turns == 1
                and abs(one.theta[0] - float(exact.thetas[0])) < 1e-6]  # fmt: skip
    return saddle_of(impact_map, orbit)


def test_a_saddle_has_the_multipliers_of_its_orbit():
    _, _, exact = known()
    one = saddle()
    omega = RPM * pi / 30.0
    assert one.impact.theta == pytest.approx(float(exact.thetas[0]), abs=1e-10)
    assert one.impact.v == pytest.approx(float(exact.u_plus[0]) / omega, rel=1e-9)
    assert (one.label, one.turns, one.impact.turn) == ("P(1;1)", 1, 0)
    theirs = sorted((float(z.real) for z in exact.multipliers), key=lambda z: -abs(z))
    assert one.multipliers == pytest.approx(theirs, rel=1e-5)
    assert abs(one.multipliers[0]) > 1.0 > abs(one.multipliers[1])
    assert one.directions[0].tolist() == [1.0, 1.0]
    d = 1e-5
    impact_map = known()[0]
    for column, multiplier in zip(one.directions.T, one.multipliers, strict=True):
        ends = impact_map.image(one.at[:, None] + np.outer(column, [d, -d]))
        moved = (ends.points[:, 0] - ends.points[:, 1]) / (2.0 * d)
        assert moved == pytest.approx(multiplier * column, rel=1e-4)
        assert (ends.stretch, ends.turn) == (one.impact.stretch, 1)
    for u, s in ((0.01, -0.02), (-0.3, 0.1)):
        place = one.at + one.directions @ np.array([u, s])
        assert one.coordinates(*place) == pytest.approx([u, s])


def test_what_is_no_saddle():
    """An orbit that attracts, one of two impacts, and one that rests."""
    impact_map, orbits, _ = known()
    values = {"orbits.at": 700.0, "orbits.rpm": {"start": 700.0, "stop": 700.0, "num": 1},
              "orbits.starts": 1}  # fmt: skip
    below = camcli.orbits(camcli.load_scene(None, values)).values.orbits
    (stable,) = [one for one in below if one.stable]
    assert saddle_of(impact_map, stable) is None
    assert [saddle_of(impact_map, one) is None for one in orbits] == [
        one.root is None or one.root.count != 1 or one.stable for one in orbits
    ]


def test_chains_lead_from_the_saddle_back_to_it():
    impact_map, one = known()[0], saddle()
    chains = homoclinic(impact_map, one)
    assert 1 < len(chains) <= 12
    mu = abs(one.multipliers[0])
    lengths = []
    for chain in chains:
        first, *rest = chain
        u, s = one.coordinates(*first[:2])
        assert abs(s) < 1e-9
        assert 1e-3 <= u <= 1e-3 * mu**2 * (1.0 + 1e-9)  # mu < 0: both sides in two periods
        for here, there in zip(chain, rest, strict=False):
            image = impact_map.image(np.array([[here.theta], [here.v]]))
            assert image.points[:, 0] == pytest.approx([there.theta, there.v], abs=1e-7)
            assert (image.stretch, image.turn) == (there.stretch, there.turn - here.turn)
        landed = len(chain) - 6  # from there on towards the saddle
        us = [one.coordinates(*impact[:2]) for impact in chain[landed:]]
        assert abs(us[0][0]) < 1e-7
        assert abs(us[1][1]) < abs(us[0][1]) < 0.5  # along the stable direction
        lengths.append(landed)
    assert lengths == sorted(lengths)
    assert min(lengths) >= 2


def test_frames_go_along_with_a_chain():
    """The unstable direction forwards; it is the saddle's own at first, stretched by mu there."""
    impact_map, one = known()[0], saddle()
    chain = homoclinic(impact_map, one)[0]
    found = frames(impact_map, one, chain)
    assert len(found) == len(chain)
    assert found[0].axes[:, 0] == pytest.approx(one.directions[:, 0])
    assert found[0].stretch == pytest.approx(one.multipliers[0], rel=0.05)
    d = 1e-6
    for here, there, impact in zip(found, found[1:], chain, strict=False):
        ends = impact_map.image(np.array(impact[:2])[:, None] + np.outer(here.axes[:, 0], [d, -d]))
        moved = (ends.points[:, 0] - ends.points[:, 1]) / (2.0 * d)
        along, across = np.linalg.solve(there.axes, moved)
        assert along == pytest.approx(here.stretch, rel=1e-3)
        assert abs(across) < 1e-3 * abs(along)
    assert found[-1].stretch == 0.0


def test_simulated_impacts_are_those_of_a_record():
    impact_map, _, _ = known()
    theta, v = impact_map.simulated()
    assert len(theta) == len(v) > 30
    events = camcli.simulate(camcli.load_scene(None, {
        "run.rpm": RPM, "run.transient": 50, "run.record": 40})).tables["events"]  # fmt: skip
    impacts = events["event"] == "impact"
    assert np.degrees(theta) == pytest.approx(events["theta_deg"][impacts])
    omega = RPM * pi / 30.0
    assert v * omega == pytest.approx(events["u_plus_m_per_s"][impacts])


def sides(box) -> list[np.ndarray]:
    """Points on the ends x = -1 and x = 1 of a box, and along it."""
    way = np.linspace(-1.0, 1.0, 7)
    points = [np.array([np.full(7, x), way]) for x in (-1.0, 1.0)]
    points += [np.array([way, np.full(7, y)]) for y in (-1.0, 1.0)]
    return [np.array(box.middle)[:, None] + box.matrix @ one for one in points]


def test_boxes_about_a_chain_cover_one_another():
    """Each the next, the last the first, and the first itself; the saddle is in its middle."""
    impact_map, one = known()[0], saddle()
    found = next(candidates(impact_map, one))
    assert (found.rpm, found.label) == (RPM, "P(1;1)")
    count = len(found.boxes)
    assert set(found.coverings) == {(0, 0), *((k, (k + 1) % count) for k in range(count))}
    assert found.boxes[0].middle == pytest.approx(tuple(one.at), abs=1e-4)
    assert found.boxes[0].inside(one.at[:, None])[:, 0] == pytest.approx([0.0, 0.0], abs=1e-3)
    for k, box in enumerate(found.boxes):
        images = [impact_map.image(points) for points in sides(box)]
        assert {(x.stretch, x.turn) for x in images} == {(box.lands.stretch, box.lands.turn)}
        phases = np.concatenate([x.points[0] for x in images])
        assert box.lands.low <= phases.min() <= phases.max() <= box.lands.high
        for over in (j for i, j in found.coverings if i == k):
            other = found.boxes[over]
            assert other.stretch == box.lands.stretch
            left, right, *rest = (other.inside(x.points) for x in images)
            assert all((abs(x[1]) < 1.0).all() for x in (left, right, *rest))
            assert (abs(left[0]) > 1.0).all()
            assert (left[0] * right[0] < 0.0).all()
        for entry in np.ravel(box.axes).tolist():
            assert entry == float(f"{entry:.6g}")


@pytest.mark.parametrize(
    ("places", "cut"),
    [
        ("i o o i", (1, 3)),
        ("i i o i i", (2, 3)),
        ("i o i o i", (1, 2)),  # the first time
        ("i i i", None),  # it does not leave
        ("i o o", None),  # it does not come back
        ("o o i", None),  # it does not begin there
        ("i e i", (1, 2)),  # on another stretch
        ("i u i", (1, 2)),  # on the edge in u
        ("i s i", (1, 2)),  # on the edge in s
    ],
)
def test_a_chain_is_cut_where_it_leaves_the_saddles_box_and_comes_back(places, cut):
    """The box is 0.3 by 0.1 to either side."""
    u_and_s = {"i": (-0.2, 0.05), "o": (0.2, -0.15), "e": (0.0, 0.0), "u": (0.3, 0.0),
               "s": (0.0, -0.1)}  # fmt: skip
    chain = [Impact(*u_and_s[letter], 7 if letter == "e" else 4, k)
             for k, letter in enumerate(places.split())]  # fmt: skip
    saddle = SimpleNamespace(impact=SimpleNamespace(stretch=4), coordinates=lambda *at: at)
    found = _cut(saddle, chain, 0.3, 0.1)
    assert (found and (found.start, found.stop)) == cut


@pytest.mark.parametrize(
    ("multipliers", "is_saddle"),
    [
        ((2.0, 0.5), True), ((-2.0, 0.5), True), ((0.5, -2.0), True), ((1.001, -0.999), True),
        ((2.0, 1.5), False), ((0.9, 0.5), False), ((2.0, -1.001), False), ((0.999, 0.1), False),
    ],
)  # fmt: skip
def test_a_saddle_has_one_multiplier_on_either_side_of_the_unit_circle(multipliers, is_saddle):
    """Of a map that is linear about an impact, along axes that have a first entry of one."""
    axes = np.array([[1.0, 1.0], [0.7, -0.4]])
    slopes = axes @ np.diag(multipliers) @ np.linalg.inv(axes)
    root = SimpleNamespace(count=1, x=[2.0, 0.5, RPM])
    orbit = SimpleNamespace(root=root, turns=3, label="P(3;1:0:0)", stable=False)
    impact_map = SimpleNamespace(slopes=lambda theta, v: slopes, system=known()[0].system)
    found = saddle_of(impact_map, orbit)
    assert (found is not None) == is_saddle
    if is_saddle:
        large, small = sorted(multipliers, key=abs, reverse=True)
        assert found.multipliers == pytest.approx((large, small))
        in_order = axes if multipliers[0] == large else axes[:, ::-1]
        assert found.directions == pytest.approx(in_order)
        assert (found.label, found.turns, found.at.tolist()) == ("P(3;1:0:0)", 3, [2.0, 0.5])


@pytest.mark.parametrize(
    ("first", "second", "other", "n", "change"),
    [
        ((2, 0, 0.1), (3, 1, 0.2), (3, 1, -0.1), 1, True),
        ((2, 0, 0.1), (3, 1, 0.2), (3, 1, 0.1), 1, False),  # on one side
        ((2, 0, 0.1), (3, 1, 0.2), (3, 1, 0.0), 1, True),  # on the manifold
        ((2, 0, 0.1), (3, 1, 0.2), (4, 1, -0.1), 1, False),  # another stretch
        ((2, 0, 0.1), (3, 1, 0.2), (3, 2, -0.1), 1, False),  # another turn
        ((2, 0, 0.1), (3, 1, 0.2), (4, 2, -0.1), 0, False),  # the first ones are the same
        ((2, 0, 0.1), (3, 1, 0.2), (3, 1, -0.31), 1, False),  # one is far from the saddle
        ((2, 0, 0.1), (3, 1, 0.31), (3, 1, -0.1), 1, False),
        ((2, 0, 0.1), (3, 1, 0.2), (3, 1, -0.1), 2, False),  # the chains end before
    ],
)
def test_two_chains_on_either_side_of_the_manifold_land_alike_and_near(
    first, second, other, n, change
):
    """Stretch, turn and u of each impact; s is 0.05 or -0.1, the room 0.3."""
    saddle = SimpleNamespace(coordinates=lambda theta, v: (theta, v))

    def chain(*impacts, s):
        return [Impact(u, s, stretch, turn) for stretch, turn, u in impacts]

    one, two = chain(first, second, s=0.05), chain(first, other, s=-0.1)
    assert _changes(saddle, one, two, n, 0.3) is change
    assert _changes(saddle, two, one, n, 0.3) is change
    far = SimpleNamespace(coordinates=lambda theta, v: (theta, 3.0 * v - 0.01))  # one alone is
    assert not _changes(far, one, two, n, 0.3)
    assert not _changes(far, two, one, n, 0.3)
