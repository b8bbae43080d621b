"""Rows of curve.csv, codim2.csv, attractors.csv and corners.csv of results made by hand.

Every number of a result is another one, so that none can stand in another's column.
"""

from math import pi, radians
from types import SimpleNamespace as Made

import numpy as np
import pytest

from camcli.analysis.border_collision import Side
from camcli.analysis.orbits.codim2 import PointProof
from camcli.analysis.orbits.curve_proofs import CurveRange
from camcli.analysis.orbits.curves import Plane
from camcli.analysis.orbits.kinds import Kind
from camcli.analysis.orbits.proofs import Proof, ProofStep
from camcli.analysis.orbits.study import Bifurcation
from camcli.api.basins import _attractors_table
from camcli.api.explanation import corners_table
from camcli.api.orbit_tables import codim2_table, curve_table, proved_parts
from camcli.api.rows import form
from camcli.errors import Status
from camcli.quantities import PARAMETERS

PLANE = Plane(("rpm", "restitution"), ((600.0, 800.0), (0.1, 0.9)), 20)
KEYS = {"restitution": "follower.restitution"}
SPEED, RESTITUTION = [*PARAMETERS].index("rpm"), [*PARAMETERS].index("restitution")


def rows_of(table):
    """The rows, texts and numbers as they stand in the file; None where nothing is known."""
    columns = [table[name] for name in table.columns]
    plain = [[None if x != x else x for x in column.tolist()] for column in columns]
    return [list(row) for row in zip(*plain, strict=True)]


def orbit(**more):
    own = {
        "label": "P(2;1:1)", "rpm": 700.5, "trace": 0.125, "det": 0.375, "resting": False,
        "theta": [radians(155.5), radians(160.25)], "multipliers": (complex(0.5, 0.25),
        complex(0.5, -0.25)), "root": Made(parameter=SPEED),
    }  # fmt: skip
    return Made(**{**own, **more})


def test_points_of_curves():
    """One-sided traces where there are sides; with a proof the number that was solved for."""
    names = {"left": None, "right": None}
    smooth = Made(first=700.5, second=0.75, orbit=orbit(), **names)
    sides = Made(first=701.5, second=0.5, orbit=orbit(), left=(1.5, 0.64), right=(-2.5, 0.32))
    in_restitution = Made(**{**vars(smooth), "orbit": orbit(root=Made(parameter=RESTITUTION))})
    curves = [
        Made(kind=Kind.FOLD, label="P(2;1:1)", corner="", points=[smooth]),
        Made(kind=Kind.CORNER_IMPACT, label="P(1;1)", corner="b", points=[sides, in_restitution]),
    ]
    table = curve_table(curves, PLANE, KEYS)
    assert table.columns[4:7] == ("rpm", "follower.restitution", "theta_deg")
    wanted = [
        [1, "fold", "P(2;1:1)", "", 700.5, 0.75, 0.125, 0.375, 0.125, 0.375],
        [2, "corner-impact", "P(1;1)", "b", 701.5, 0.5, 1.5, 0.64, -2.5, 0.32],
        [2, "corner-impact", "P(1;1)", "b", 700.5, 0.75, 0.125, 0.375, 0.125, 0.375],
    ]
    rows = rows_of(table)
    for row, own in zip(rows, wanted, strict=True):
        phases = row.pop(6)
        assert list(map(float, phases.split(":"))) == pytest.approx([155.5, 160.25], rel=1e-14)
        assert row == own
    proofs = Made(curves=[
        [Proof(low=700.625, high=700.75)],
        [Proof(ProofStep.PULLS), Proof(low=0.5, high=0.625)],
    ])  # fmt: skip
    table = curve_table(curves, PLANE, KEYS, proofs)
    assert table.columns[-5:] == (
        "proved", "rpm_low", "rpm_high", "follower.restitution_low", "follower.restitution_high"
    )  # fmt: skip
    proved = [[row[4], row[5], *row[-5:]] for row in rows_of(table)]
    assert proved == [
        [700.625, 0.75, "yes", 700.625, 700.75, 0.75, 0.75],  # put into its enclosure
        [701.5, 0.5, "no", None, None, None, None],
        [700.5, 0.625, "yes", 700.5, 700.5, 0.5, 0.625],
    ]


def test_a_curve_s_parts_that_are_proved_stand_at_the_point_before_them():
    """And what was not tried, or has no point behind it, is empty."""
    point = Made(first=700.5, second=0.75, orbit=orbit(), left=None, right=None)
    named = {"kind": Kind.FOLD, "label": "P(2;1:1)", "corner": ""}
    curves = [Made(**named, points=[point] * 4), Made(**named, points=[point] * 2)]
    places = (700.5, 0.75), (700.5, 0.75)
    ranges = [
        CurveRange(1, 1, 2, places, 3),
        CurveRange(1, 2, 3, places, 0, ProofStep.PASSES),
        CurveRange(1, 3, 4, places, 3),
    ]
    table = curve_table(curves, PLANE, KEYS, ranges=ranges)
    assert table.columns[-1] == "proved_to_next"
    assert [row[-1] for row in rows_of(table)] == ["yes", "no", "yes", "", "", ""]
    assert proved_parts(ranges, 1, 4) == [True, False, True]
    assert proved_parts(ranges, 2, 2) == []


def test_points_of_codimension_two():
    def point(**more):
        own = {
            "kind": "double-corner-impact", "first": 700.5, "second": 0.75,
            "errors": (1e-9, 2e-12), "label": "P(2;1:1)", "corners": ("b", "c"), "curves": (3, 7),
            "meets": ["corner-impact", "fold"], "orbit": orbit(), "before": -3e-7,
            "behind": 4e-7, "status": "ok", "proof": None,
        }  # fmt: skip
        return Made(**{**own, **more})

    wanted = [
        "double-corner-impact", 700.5, 0.75, 1e-9, 2e-12, "P(2;1:1)", "b:c", "3:7",
        "corner-impact & fold", 0.5, 0.25, 0.5, -0.25, -3e-7, 4e-7, "ok",
    ]  # fmt: skip
    table = codim2_table([point()], PLANE, KEYS)
    assert table.columns[1:5] == (
        "rpm", "follower.restitution", "rpm_error", "follower.restitution_error"
    )  # fmt: skip
    (row,) = rows_of(table)
    assert list(map(float, row.pop(9).split(":"))) == pytest.approx([155.5, 160.25], rel=1e-14)
    assert row == wanted
    proofs = [PointProof(None, (700.25, 700.75), (0.7, 0.8)), PointProof(ProofStep.SINGULAR)]
    table = codim2_table([point(proof=proof) for proof in proofs], PLANE, KEYS, proved=True)
    assert [row[-5:] for row in rows_of(table)] == [
        ["yes", 700.25, 700.75, 0.7, 0.8], ["no", None, None, None, None],
    ]  # fmt: skip
    table = codim2_table([point()], PLANE, KEYS, proved=True)
    assert rows_of(table)[0][-5:] == ["", None, None, None, None]  # it was not tried


def test_attractors_stand_by_their_number_and_then_what_is_none():
    """At 30 rpm, where a rate in m/rad is pi times as much in m/s."""
    attractors = [
        Made(label="P(1;1)", states=np.array([[0.5, 0.25]]), multipliers=None),
        Made(label="P(2;1:1)", states=np.array([[0.125, -0.5], [9.0, 9.0]]),
             multipliers=(complex(0.5, 0.25), complex(0.5, -0.25))),
    ]  # fmt: skip
    fractions = {1: (0.4, 0.01), 2: (0.3, 0.02), 0: (0.2, 0.03),
                 -int(Status.NO_RETURN): (0.1, 0.04)}  # fmt: skip
    speed = Made(rpm=30.0, value=0.875, attractors=attractors, branches=[5, 2],
                 fractions=fractions, exponents=[-1.5, -2.5])  # fmt: skip
    lost = -int(Status.NO_RETURN)
    rows = rows_of(_attractors_table(Made(speeds=[speed]), "follower.restitution"))
    nothing = [None] * 5
    assert rows == [
        [0.875, 2, "P(2;1:1)", 0.125, -0.5 * pi, 0.3, 0.02, 30.0, 0.5, 0.25, 0.5, -0.25, -2.5],
        [0.875, 5, "P(1;1)", 0.5, 0.25 * pi, 0.4, 0.01, 30.0, None, None, None, None, -1.5],
        [0.875, 0, "undecided", None, None, 0.2, 0.03, 30.0, *nothing],
        [0.875, lost, Status.NO_RETURN.text, None, None, 0.1, 0.04, 30.0, *nothing],
    ]
    speed.exponents = None
    table = _attractors_table(Made(speeds=[speed]), "rpm")
    assert table.columns[0] == "attractor"
    assert rows_of(table) == [row[1:8] for row in rows]


def test_corners_of_an_explanation():
    """Corner impacts alone, with both sides; without them where one is not known."""
    impact = Made(left=Side(1.5, 0.64), right=Side(-2.5, 0.32), agrees=True,
                  collision=Made(kind="nonsmooth-fold"))  # fmt: skip

    def event(kind, **more):
        return Bifurcation(3, kind, 700.5, 1e-6, "ok", orbit(), **more)

    found = [event(Kind.FOLD), event(Kind.CORNER_IMPACT, corner="b", corner_impact=impact),
             event(Kind.CORNER_IMPACT, corner="c")]  # fmt: skip
    table = corners_table(Made(bifurcations=found))
    known, unknown = rows_of(table)
    assert known[:10] == [3, "P(2;1:1)", "corner-impact", 700.5, 1e-6, "b", 1.5, 0.64, -2.5, 0.32]
    assert known[10] == "nonsmooth-fold"
    assert unknown[:10] == [3, "P(2;1:1)", "corner-impact", 700.5, 1e-6, "c", 0.125, 0.375,
                            None, None]  # fmt: skip
    assert rows_of(corners_table(None)) == []


def test_a_way_without_rows_makes_no_column_wider():
    """`down` has no impacts: the longest name in the column is `up`, as numpy would have it."""
    ways = [("up", 0), ("down", 0)]
    for counts, kinds in (((3, 0), ["<U2", "<i8"]), ((3, 1), ["<U4", "<i8"])):
        sweep = Made(row_counts={"impacts": counts}, ways=ways, way_names=("direction", "start"))
        found = form(sweep, "impacts")
        assert found.rows == sum(counts)
        assert found.kinds[-2:] == kinds
    sweep = Made(row_counts={"impacts": (0, 0)}, ways=ways, way_names=("direction", "start"))
    assert {*form(sweep, "impacts").kinds} == {"<f8"}
