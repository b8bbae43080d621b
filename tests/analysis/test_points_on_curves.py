"""Points of codimension two that several curves meet are one point, which names all of them."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

from camcli.analysis.orbits import codim2
from camcli.piece_faults import gathering


@dataclass(frozen=True)
class Point:
    """What of a point tells whether it is another one."""

    first: float
    second: float = 0.8
    kind: str = "fold-corner"
    corners: tuple = ("b", "c")
    curves: tuple = ()
    ends: tuple = ()


@pytest.mark.parametrize("known", [0, 1])
def test_a_point_that_is_found_again_notes_the_other_curve_and_its_end(monkeypatch, known):
    """The second curve meets the first one's point, its own twice, and breaks on the fourth.

    known: curves that were looked at before.
    """
    found = {
        1: [Point(700.0, curves=(1,), ends=((1, 0),))],
        2: [Point(700.0 * (1 + 0.5 * codim2.SAME_POINT), corners=("c", "b"), curves=(2,),
                  ends=((2, 1),)),
            Point(710.0, curves=(2,)), Point(710.0, curves=(2,), ends=((2, 0),))],
        3: [Point(700.0, kind="cusp", curves=(3,)), Point(700.0, corners=("b",), curves=(3,)),
            Point(700.0, second=0.81, curves=(3,)),
            Point(700.0 * (1 + 2.0 * codim2.SAME_POINT), curves=(3,))],
        4: [],
    }  # fmt: skip

    def on_curve(system, curve, number, plane):
        assert curve == f"curve {number}"
        yield from found[number]
        if number == 4:
            raise ZeroDivisionError

    monkeypatch.setattr(codim2, "_on_curve", on_curve)
    curves = [f"curve {number}" for number in found]
    points = found[1][:known]
    with gathering() as faults:
        codim2.add_points("system", curves, "plane", points, known)
    assert [fault.piece for fault in faults] == ["the points of codimension two on curve 4"]
    first, second, *others = points
    assert first == Point(700.0, curves=(1, 2), ends=((1, 0), (2, 1)))
    assert second == Point(710.0, curves=(2,), ends=((2, 0),))
    assert others == found[3]
