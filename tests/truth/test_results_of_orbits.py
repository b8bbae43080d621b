"""Every field of branches, of curves and of a label that is not there, against mpmath's orbits."""

from __future__ import annotations

from dataclasses import fields
from functools import cache
from itertools import pairwise
from typing import Any

import pytest
from mpmath import mpf

import camcli
from camcli.analysis.orbits.curves import CurveLine
from camcli.analysis.orbits.kinds import Kind
from camcli.scene import load_scene
from tests.support import orbit_oracle
from tests.support.orbit_oracle import CAM, CHAPTER, STABLE, B

LOW, HIGH, AT = 690.0, 741.0, 705.0
FEW = {"orbits.starts": 0, "orbits.branches": 0, "orbits.label": "P(1;1)"}


def machine(restitution: float):
    return CHAPTER._replace(restitution=mpf(restitution))


@cache
def doubling(restitution: float):
    """The speed at which P(1;1) doubles its period."""
    return orbit_oracle.period_doubling_rpm(CAM, machine(restitution), STABLE, 1, 700, 745).rpm


def every_field(one: Any, wanted: dict[str, Any], where: str) -> None:
    """Each field against its value or a check of it; none may be left out."""
    assert sorted(wanted) == sorted(field.name for field in fields(one)), where
    for name, value in wanted.items():
        found = getattr(one, name)
        holds = value(found) if callable(value) else found == value
        assert holds, f"{where}.{name}: {found}"


@cache
def solved() -> Any:
    values = {"orbits.rpm": {"start": LOW, "stop": HIGH, "num": 11}, "orbits.at": AT,
              "orbits.starts": 0, "orbits.branches": 1}  # fmt: skip
    return camcli.orbits(load_scene(None, values)).values


def one_way(orbits) -> bool:
    """Whether the speed rises from orbit to orbit."""
    return all(a.value < b.value for a, b in pairwise(orbits))


def test_branches_are_followed_over_the_whole_range():
    """Both orbits of one impact, and the doubled one from where it is born."""
    through, other, doubled = solved().branches
    for number, branch in enumerate((through, other), 1):
        every_field(branch, {
            "number": number, "origin": "found",
            "points": lambda x: (x[0].value, x[-1].value) == (LOW, HIGH) and one_way(x)
            and AT in [one.value for one in x] and {str(one.label) for one in x} == {"P(1;1)"},
            "ends": (Kind.END_OF_RANGE, Kind.END_OF_RANGE),
        }, "branch")  # fmt: skip
        assert (branch.labels, branch.turning_points) == (["P(1;1)"], [])
    every_field(doubled, {
        "number": 3, "origin": Kind.PERIOD_DOUBLING,
        "points": lambda x: 0.0 < x[0].value - doubling(0.8) < 1e-4 and x[-1].value == HIGH
        and one_way(x) and {str(one.label) for one in x} == {"P(2;1:1)"},
        "ends": (Kind.PERIOD_DOUBLING, Kind.END_OF_RANGE),
    }, "doubled branch")  # fmt: skip
    assert (doubled.labels, doubled.turning_points) == (["P(2;1:1)"], [])
    stable = [[one.stable for one in branch.points] for branch in (through, other)]
    values = [one.value for one in through.points]
    assert stable[0] == [value < doubling(0.8) - 1e-9 for value in values]
    assert not any(stable[1])


def test_what_else_is_known_of_the_orbits_at_a_speed():
    found = solved()
    assert (found.value, found.question.rpm, found.question.parameter) == (AT, AT, "rpm")
    assert (found.question.branches, found.question.starts) == (1, 0)
    assert (found.absent, found.limits, found.continua, found.curves) == (None, (), [], [])
    assert [one.stable for one in found.orbits] == [True, False]
    assert found.cost.impacts > 0
    for orbit in found.virtual:  # no motions: an impact pulls, or a flight passes the cam
        assert orbit.turns <= 6
        assert len(orbit.theta) == 1
        assert orbit.rpm == AT


@cache
def curve_of(kind: str, start: float, stop: float, rpm: float, low: float, high: float) -> Any:
    axes = [{"key": "rpm", "start": start, "stop": stop, "num": 5},
            {"key": "follower.restitution", "start": low, "stop": high, "num": 5}]  # fmt: skip
    values = {"orbits.vary": axes, "orbits.curve": kind, "run.rpm": rpm, **FEW,
              "orbits.stability": "stable"}  # fmt: skip
    (one,) = camcli.orbits(load_scene(None, values)).values.curves
    return one


def test_a_curve_of_doublings_is_mpmaths_from_end_to_end():
    one = curve_of("period-doubling", 735.0, 745.0, 738.0, 0.78, 0.82)
    every_field(one, {
        "kind": Kind.PERIOD_DOUBLING, "label": "P(1;1)", "corner": "", "first": "rpm",
        "second": "restitution", "points": lambda x: len(x) >= 3,
        "ends": (Kind.END_OF_RANGE, Kind.END_OF_RANGE), "limits": ("restitution", "restitution"),
        "located": lambda x: x.kind == Kind.PERIOD_DOUBLING
        and abs(x.root.value - doubling(0.8)) < 1e-9,
        "beyond": (None, None),
    }, "curve")  # fmt: skip
    assert [point.second for point in one.points][:: len(one.points) - 1] == [0.78, 0.82]
    for point in one.points:
        assert abs(point.first - doubling(point.second)) < 1e-9
        assert abs(1.0 + point.orbit.trace + point.orbit.det) < 1e-9
        assert point.orbit.det == pytest.approx(point.second**2)
        assert (point.left, point.right, point.crossing) == (None, None, None)
    first, second = ([getattr(p, name) for p in one.points] for name in ("first", "second"))
    assert one.line == CurveLine("period-doubling", "P(1;1)", "", first, second)
    assert one.line.proved == ()


def test_a_curve_ends_at_the_number_whose_range_ends_first():
    """At the speed on one side, at the restitution on the other."""
    one = curve_of("period-doubling", 739.2, 745.0, 739.25, 0.78, 0.82)
    assert sorted(one.limits) == ["restitution", "rpm"]
    ends = dict(zip(one.limits, (one.points[0], one.points[-1]), strict=True))
    assert ends["rpm"].first == 739.2
    assert ends["restitution"].second == 0.82


def test_a_curve_of_corner_impacts_has_a_map_on_either_side():
    one = curve_of("corner-impact", 668.0, 682.0, 680.0, 0.79, 0.81)
    assert (one.kind, one.corner, one.ends) == (
        Kind.CORNER_IMPACT, "b", (Kind.END_OF_RANGE, Kind.END_OF_RANGE),
    )  # fmt: skip
    for point in (one.points[0], one.points[-1]):
        exact = orbit_oracle.corner_rpm(CAM, machine(point.second), STABLE, 1, 0, B, 675)
        assert abs(point.first - exact.rpm) < 1e-8
        for own, other in ((point.left, exact.left), (point.right, exact.right)):
            assert own == pytest.approx((float(other.trace), float(other.det)), rel=1e-7)


def test_a_label_that_is_not_there_is_looked_for_beside():
    """P(2;1:1) begins where P(1;1) doubles: the speed nearest to 730 rpm that it reaches."""
    values = {"orbits.rpm": {"start": 700.0, "stop": 745.0, "num": 10}, "orbits.at": 730.0,
              **FEW, "orbits.label": "P(2;1:1)", "run.transient": 100}  # fmt: skip
    found = camcli.orbits(load_scene(None, values)).values
    tried = [700.0 + 45.0 * k / 23 for k in range(24)]
    every_field(found.absent, {
        "rpm": 730.0, "low": 700.0, "high": 745.0,
        "orbit": lambda x: x.rpm == min(rpm for rpm in tried if rpm > doubling(0.8))
        and str(x.label) == "P(2;1:1)",
        "nearest": lambda x: abs(x[0] - doubling(0.8)) < 1e-8 and x[1] == Kind.PERIOD_DOUBLING,
        "reached": None,
    }, "absence")  # fmt: skip
    assert found.orbits == [found.absent.orbit]
    assert found.question.rpm == found.value == found.absent.orbit.rpm
    (branch,) = found.branches
    assert branch.ends == (Kind.PERIOD_DOUBLING, Kind.END_OF_RANGE)
