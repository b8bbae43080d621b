"""What pictures of orbits are made of, by hand: events, lists, multipliers, places of a cover."""

from math import radians
from types import SimpleNamespace as Made

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from camcli.analysis.labels import Label
from camcli.analysis.orbits.kinds import Bracket, Kind
from camcli.plots import cover, orbits
from camcli.plots.branch_lines import (
    Event,
    Strand,
    _multiplier_at,
    _shares,
    draw_plane,
    events_of,
    paths,
    turning_real,
)
from camcli.plots.proofs import _ways, draw_attraction, proved_stretches, value_of
from camcli.quantities import MILLIMETRES


@pytest.fixture
def axes():
    return Figure().subplots()


def orbit(value, *theta_deg, label="P(1;1)", trace=0.5, det=0.06, stable=True, turns=1, at=()):
    """An orbit of impacts at these phases, at these stroboscopic positions."""
    theta = [radians(x) for x in theta_deg]
    return Made(value=value, rpm=value, theta=theta, root=None, label=label, trace=trace, det=det,
                stable=stable, turns=turns, states=[(q, 0.5) for q in at], resting=False,
                multipliers=(0.3, 0.2) if stable else (1.3, 0.2))  # fmt: skip


def event(kind, value, branch, continues=0, corner="", own=None, **more):
    """A bifurcation as a study has it."""
    own = own or orbit(value, 20.0, 410.0, at=(0.01, 0.03))
    known = {"classification": "", "status": Bracket.OK, "label": own.label, **more}
    return Made(kind=kind, value=value, branch=branch, continues=continues, corner=corner,
                orbit=own, **known)  # fmt: skip


def test_what_several_branches_share_is_one_event_with_a_mark_at_its_corner():
    """Equal are kind, corner and nine digits of the value; a mark without a corner is an impact."""
    corners = {"a": 110.0, "b": 170.0}
    found = events_of(
        [
            event(Kind.CORNER_IMPACT, 700.0000001, 3, 4, "b"),
            event(Kind.FOLD, 700.0, 2),
            event(Kind.CORNER_IMPACT, 700.0000002, 1, 5, "b"),
            event(Kind.CORNER_IMPACT, 700.0, 1, 0, "a"),
            event(Kind.CORNER_IMPACT, 700.00001, 2, 4, "b"),
            event(Kind.CORNER_IMPACT, 700.0000001, 3, 5, "b"),
            event(Kind.GRAZING, 650.0, 7, 6),
        ],
        corners,
    )
    told = [(one.number, one.words("it"), one.value, one.branches, one.leaves) for one in found]
    assert told == [
        (1, "grazing of it", 650.0, (7,), (6,)),
        (2, "corner impact of it at a", 700.0, (1,), ()),
        (3, "fold of it", 700.0, (2,), ()),
        (4, "corner impact of it at b", 700.0000001, (1, 3), (4, 5)),
        (5, "corner impact of it at b", 700.00001, (2,), (4,)),
    ]
    assert [one.phases for one in found] == [
        pytest.approx((20.0, 50.0)), (110.0,), pytest.approx((20.0, 50.0)), (170.0,), (170.0,)
    ]  # fmt: skip
    assert {one.positions for one in found} == {(0.01, 0.03)}
    assert found[3].name == "corner impact at b"


def test_the_lists_above_branches_name_each_event_with_all_that_is_known_of_it():
    branches = [
        Made(number=k, labels=labels, ends=ends, points=[Made(value=611.5, regions=regions)])
        for k, labels, ends, regions in (
            (1, ["P(1;1)"], ("", ""), ["flank", "nose", "flank"]),
            (2, ["P(2;2)"], ("", ""), []),
            (3, ["P(4;4)", "P(4;5)"], (Kind.LOST, ""), []),
        )
    ]
    doubled = event(Kind.PERIOD_DOUBLING, 660.25, 1, label="P(1;1)",
                    classification="super-critical", status=Bracket.UNRESOLVED)  # fmt: skip
    fold = event(Kind.FOLD, 700.0, 2, label="P(12;inf:3:4:5:6)")
    events = [
        Event(1, doubled, (1, 2), (2, 3), (50.0,), (0.0,)),
        Event(2, fold, (2,), (3, 2), (60.0,), (0.0,)),
    ]
    shades = ["#112233", "#445566", "#778899"]
    own, told = orbits.lists_of(branches, shades, events, "rpm", proved=True)
    assert [" ".join(words.split()) for _, words in own] == [
        "branch (dashed: unstable)",
        "1 P(1;1)",
        "2 P(2;2), from event 1",
        "3 P(4;4) to P(4;5), from event…",
        "proved without a gap",
    ]
    assert [look["color"] for look, _ in own[1:4]] == shades
    assert told[0] == ["", "", "event", "rpm", "branch"]
    assert [row[1:] for row in told[1:]] == [
        ["1", "period doubling of P(1;1)", "660.25", "1, 2",
         "super critical; 2, 3 leaves; unresolved"],
        ["2", "fold of P(12;∞:3:4:5…)", "700", "2", "3, 2 leaves"],
    ]  # fmt: skip
    assert [row[0]["marker"] for row in told[1:]] == ["s", "<"]
    (alone,) = orbits.lists_of(branches[:1], shades, [], "rpm")
    assert alone[1][1] == "1   P(1;1)"
    heads = orbits.lists_of(branches, shades, events, "restitution")[1][0]
    assert heads[3] == "value"
    many = orbits.lists_of(branches * 6, shades * 6, events * 9, "rpm")
    assert [rows[-1] for rows in many] == [["and 4 more, in the tables"]] * 2


def test_a_pair_turns_real_where_its_discriminant_is_zero():
    """On the cubic through its points; at a corner, where two share a value, between the two."""

    def points(values, gap):
        """Orbits whose trace^2 - 4 det is what `gap` says at their values."""
        return [Made(value=x, trace=1.0, det=0.25 * (1.0 - gap(x))) for x in values]

    def cubic(x):
        return (x - 1.7) * (1.0 + 0.5 * x + 0.25 * x * x)

    assert turning_real(points(range(6), cubic)) == pytest.approx([1.7])
    assert turning_real(points(range(5, -1, -1), cubic)) == pytest.approx([1.7])
    assert turning_real(points([1, 2, 3, 4], cubic)) == pytest.approx([1.7])

    def twice(x):
        return (x - 1.25) * (x - 4.5)

    assert turning_real(points(range(7), twice)) == pytest.approx([1.25, 4.5])
    corner = points([0.0, 1.0], lambda x: -1.0 - x) + points([1.0, 2.0], lambda x: 3.0 - x)
    assert turning_real(corner) == [1.0]
    kinked = points([0.0, 0.5, 0.5, 1.5], lambda x: -2.0) + points([3.5], lambda x: 2.0)
    assert turning_real(kinked) == pytest.approx([2.5])  # on a line
    assert turning_real(points(range(5), lambda x: 1.0 + x)) == []


def test_the_paths_of_multipliers_meet_where_they_turn_real_and_break_at_a_corner():
    before = Made(value=10.0, trace=1.0, det=0.5, stable=True, multipliers=(0.5 + 0.5j, 0.5 - 0.5j))
    after = Made(value=20.0, trace=1.6, det=0.5, stable=True,
                 multipliers=(0.8 + 0.14**0.5, 0.8 - 0.14**0.5))  # fmt: skip
    meet = (2.0 * 0.5**0.5 - 1.0) / 0.6  # where (trace/2)^2 = det
    twelfths = [part / 12.0 for part in range(1, 13)]
    assert _shares(before, after) == pytest.approx(sorted([*twelfths, meet]))
    falling = Made(trace=1.0, det=0.5), Made(trace=1.0, det=0.1)
    assert _shares(*falling) == pytest.approx(sorted([*twelfths, 0.625]))
    assert _shares(after, after) == pytest.approx(twelfths)
    upper, lower = paths([before, after])
    where = [10.0 + 10.0 * share for share in sorted([0.0, *twelfths, meet])]
    assert upper.x == lower.x == pytest.approx(where)
    traces = 1.0 + 0.06 * (np.array(where) - 10.0)
    assert np.add(upper.y, lower.y) == pytest.approx(traces)
    assert np.multiply(upper.y, lower.y) == pytest.approx(np.full(14, 0.5))
    behind = Made(value=20.0, trace=1.1, det=0.5, stable=True, multipliers=(0.55 + 0.44j,) * 2)
    last = Made(value=30.0, trace=1.0, det=0.5, stable=True, multipliers=(0.5 + 0.5j,) * 2)
    broken = paths([before, after, behind, last])
    assert [(one.x[0], one.x[-1]) for one in broken] == [(10.0, 20.0)] * 2 + [(20.0, 30.0)] * 2
    alike = Made(**{**vars(behind), "trace": 1.6 + 1e-7})  # but for rounding
    assert len(paths([before, after, alike, last])) == 2


def test_the_multiplier_of_a_path_at_a_value_is_on_the_line_between_two_points():
    line = Strand(True, [10.0, 10.0, 14.0, 18.0, 12.0], [1j, 2j, 6j, 7j, 10j])
    assert _multiplier_at(line, 11.0) == pytest.approx(3j)
    assert _multiplier_at(line, 16.0) == pytest.approx(6.5j)
    assert _multiplier_at(line, 10.0) == 1j
    assert _multiplier_at(line, 18.0) == pytest.approx(7j)
    assert _multiplier_at(line, 18.5) is None
    assert _multiplier_at(line, 9.5) is None


def test_the_plane_names_its_circles_and_how_far_it_reaches(axes):
    draw_plane(axes, 7.0, [0.81234, 0.35])
    assert axes.get_xlabel() == r"Re $\mu$ (triangle: beyond ±1.5)"
    assert axes.get_ylabel() == r"Im $\mu$"
    (words,) = axes.texts
    assert words.get_text() == r"dotted: $|\mu|$ = 0.35, 0.8123"
    assert words.get_position() == pytest.approx((1.455, -1.455))
    rings = [np.hypot(*line.get_data()) for line in axes.lines if len(line.get_xdata()) > 2]
    assert [(ring.min(), ring.max()) for ring in rings] == [
        pytest.approx((0.81234, 0.81234)), pytest.approx((0.35, 0.35))
    ]  # fmt: skip


def test_positions_are_drawn_where_any_two_are_a_millionth_of_the_lift_apart():
    def scene(*positions, simulated=()):
        speeds = [Made(strobe=([0], list(x))) for x in simulated]
        return Made(
            every=lambda of: np.array([q for one in positions for q in of(one)]),
            simulated=Made(speeds=speeds) if speeds else None, system=Made(lift=0.05),
        )  # fmt: skip

    def at(*q):
        return orbit(700.0, at=q)

    assert orbits._positions_differ(scene(at(0.01), at(0.01 + 6e-8)))
    assert not orbits._positions_differ(scene(at(0.01), at(0.01 + 4e-8)))
    assert orbits._positions_differ(scene(at(0.01)))  # a single one is drawn
    assert orbits._positions_differ(scene(at(0.01), at(0.01), simulated=[(0.01, 0.01), (0.02,)]))
    assert not orbits._positions_differ(scene(at(0.01), at(0.01), simulated=[(0.01,)]))


def test_each_orbit_that_attracts_has_a_panel_of_the_ellipses_of_its_own():
    """Those without a proof have none, and one alone has no number."""
    labels = [Label((2.0,) * (k - 1) + (1.0,)) for k in (1, 2, 3)]
    first, second, third = (orbit(700.0, 10.0, label=label) for label in labels)
    axes_of = [Made(axes=("ellipse 1",)), Made(axes=()), Made(axes=("ellipse 3",))]
    study = Made(orbits=[first, second, third], proofs=Made(orbits=axes_of),
                 question=Made(parameter="rpm"))  # fmt: skip
    panels = orbits._attractions(study)
    assert list(panels) == ["attraction 1", "attraction 2"]
    drawn = [panel.draw.keywords for panel in panels.values()]
    assert [one["orbit"] for one in drawn] == [first, third]
    assert [one["ellipses"] for one in drawn] == [("ellipse 1",), ("ellipse 3",)]
    assert [one["colour"] for one in drawn] == ["#231082", "#FD3F79"]
    assert [panel.across for panel in panels.values()] == [2, 2]
    study.proofs.orbits = axes_of[:2]
    panels = orbits._attractions(study)
    assert [(name, panel.across) for name, panel in panels.items()] == [("attraction", 3)]
    study.proofs = None
    assert orbits._attractions(study) == {}


def test_phases_are_of_impacts_or_of_departures(axes):
    def named(*resting):
        points = [Made(theta=[1.0], root=None, resting=rests, value=700.0) for rests in resting]
        scene = Made(branches=[], every=lambda of: np.array([1.0]), simulated=None,
                     events=[], corners={}, colours=[], proved=[], parameter="rpm",
                     lines=lambda of: [], study=Made(question=Made(span=None)))  # fmt: skip
        scene.branches = [Made(points=points, ends=("", ""), number=1)]
        scene.lines = lambda of: [[]]
        scene.colours, scene.proved = ["red"], [[]]
        axes.clear()
        orbits._draw_phases(axes, scene)
        return axes.get_ylabel()

    assert named(False, False) == r"impact phase $\theta$ (deg)"
    assert named(True, True) == r"departure phase $\theta$ (deg)"
    assert named(True, False) == r"impact or departure phase $\theta$ (deg)"


def test_words_beside_an_enlarged_corner_impact_end_in_dots_after_seventeen_lines(
    axes, monkeypatch
):
    """What the theorem says is left to the report; numbers have minus signs."""
    said = [f"Line {k} of +-{k} and -{k}" for k in range(1, 13)]
    monkeypatch.setattr(orbits, "event_words", lambda source: [*said, "The theorem is left out"])
    monkeypatch.setattr(orbits, "side_words", lambda source: ["left side", "right side"])
    source = Made(kind=Kind.CORNER_IMPACT, corner="c", label="P(1;inf)")
    here = Event(7, source, (1,), (), (50.0,), (0.0,))
    orbits._write_sides(axes, here)
    assert axes.get_title(loc="left") == "7: P(1;∞), corner impact at c"
    lines = axes.texts[0].get_text().split("\n")
    assert lines == [
        "left side",
        "right side",
        *(f"Line {k} of ±{k} and −{k}" for k in range(1, 13)),
    ]
    for more, last in ((3, "Line 15 of ±15 and −15"), (4, "…")):
        longer = [f"Line {k} of +-{k} and -{k}" for k in range(1, 13 + more)]
        monkeypatch.setattr(orbits, "event_words", lambda source, longer=longer: longer)
        axes.clear()
        orbits._write_sides(axes, here)
        lines = axes.texts[0].get_text().split("\n")
        assert (len(lines), lines[-1]) == (17, last)


def test_the_ends_of_curves_are_open_circles_unless_a_point_of_codimension_two_is_there(axes):
    """A circle for what ends a curve within the range; every fifth to eighth curve is wide."""
    ends = [("end-of-range", "lost"), ("lost", "closed"), ("lost", "end-of-range")]
    ends += [("end-of-range", "end-of-range")] * 6
    curves = [
        Made(label="P(1;1)", kind="fold", corner="", ends=own, points=[1], limits=("", ""),
             line=Made(first=[k, k + 0.5], second=[10.0 + k, 20.0 + k]))
        for k, own in enumerate(ends, 1)
    ]  # fmt: skip
    point = Made(kind=Made(), ends=[(2, 1), (3, 0)], first=2.5, second=22.0)
    ranges = [Made(curve=2, failed_step="box", first=1, last=2)]
    drawn_points = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(orbits, "mark_points", lambda axes, points: drawn_points.append(points))
        orbits._draw_curves(axes, curves, ("rpm", "restitution"), [point], ranges)
    circles = [tuple(np.ravel(one.get_data())) for one in axes.lines if one.get_marker() == "o"]
    assert circles == [(1.5, 21.0), (2.0, 12.0)]
    lines = [one for one in axes.lines if one.get_marker() == "None"]
    assert [one.get_linewidth() for one in lines] == pytest.approx([1.0] * 4 + [2.8] * 4 + [1.0])
    assert drawn_points == [[point]]
    assert "proved without a gap" not in [one.get_label() for one in axes.lines]
    assert axes.get_xlabel().startswith("speed") or "rpm" in axes.get_xlabel()
    assert "restitution" in axes.get_ylabel()


# --- the cover of all orbits with two impacts


def boxed(*sides_deg):
    return [(radians(low), radians(high)) for low, high in sides_deg]


def test_a_box_of_two_phases_is_drawn_by_the_way_from_one_to_the_other():
    assert cover._corners(boxed((10.0, 14.0), (230.0, 250.0))) == [
        pytest.approx(at) for at in ((10.0, 220.0), (14.0, 216.0), (14.0, 236.0), (10.0, 240.0))
    ]
    shape = [(0.0, 190.0), (1.0, 200.0), (2.0, 215.0), (3.0, 195.0)]
    for low, high, seen in (
        (100.0, 191.0, True), (100.0, 190.0, False), (214.0, 300.0, True), (215.0, 300.0, False)
    ):  # fmt: skip
        assert cover._overlaps(shape, low, high) == seen


@pytest.mark.parametrize(
    ("turns", "boxes", "wanted"),
    [
        (1, {"flight": 300.0, "order": 320.0}, (180.0, 190.0)),
        (1, {"flight": 300.0, "impact": 250.0}, (180.0, 252.0)),
        (1, {"newton": 359.5}, (180.0, 360.0)),
        (2, {"": 500.0, "impact": 400.0}, (360.0, 502.0)),
    ],
)
def test_a_cover_shows_flights_up_to_the_longest_possible_one(turns, boxes, wanted):
    """Those that only their order or their length excludes count for nothing."""
    drawn = [(boxed((10.0, 10.0), (10.0, 10.0 + long)), why) for why, long in boxes.items()]
    assert cover._range(Made(turns=turns, drawn=drawn)) == pytest.approx(wanted)


@pytest.mark.parametrize(
    ("flights", "own_turns", "turns", "wanted"),
    [
        ((140.0, 220.0), 1, 1, [(50.0, 220.0)]),
        ((220.0, 140.0), 1, 1, [(20.0, 220.0)]),
        ((140.0, 220.0), 1, 2, []),  # gone through twice it has four impacts
        ((360.0,), 1, 2, [(20.0, 360.0)]),
        ((360.0,), 1, 1, []),
        ((300.0, 420.0), 2, 2, [(50.0, 420.0)]),
        ((300.0, 420.0), 2, 3, []),
    ],
)
def test_an_orbit_stands_in_a_cover_at_its_longest_flight(flights, own_turns, turns, wanted):
    root = Made(count=len(flights), theta=[radians(20.0), radians(50.0)],
                flight_length=lambda k: radians(flights[k]))  # fmt: skip
    places = cover._places(Made(root=root, turns=own_turns), turns)
    assert [tuple(at) for at in places] == [pytest.approx(at) for at in wanted]
    assert cover._places(Made(root=None, turns=1), 1) == []


# --- proofs


def test_stretches_of_a_branch_have_the_points_at_both_ends_of_their_steps():
    steps = [True, False, False, True, True, True, False, True]
    assert list(proved_stretches(steps)) == [slice(0, 2), slice(3, 7), slice(7, 9)]
    assert list(proved_stretches([])) == []


def test_a_way_ends_where_a_branch_turns_round_and_not_at_a_corner():
    """The two sides of a corner are at one value but for rounding."""
    values = [5.0, 6.0, 6.0 + 1e-12, 7.0, 6.5, 6.5 - 1e-12, 6.0, 8.0]
    assert _ways([Made(value=x) for x in values]) == [0, 0, 0, 1, 1, 1, 2]


def test_the_end_of_a_range_is_the_middle_of_its_ball():
    assert value_of("[-612.25 +/- 3.1e-9]") == -612.25
    assert value_of("0.1") == 0.1


def test_the_panel_of_an_attraction_names_at_most_three_phases(axes):
    """Each ellipse is about its impact: phases in deg, rates times the speed of the cam."""
    ellipses = [(0.01, 0.02, 0.3, -0.4), (0.05, -0.03, 0.1, 0.2)]
    own = orbit(600.0, 30.0, 391.234, 50.5, 60.0, label="P(1;4)")
    draw_attraction(axes, own, ellipses, "#112233", "rpm")
    assert axes.get_title() == "600 rpm, impacts at 30.00, 31.23, 50.50, … deg"
    omega = 20.0 * np.pi
    for patch, (a, b, c, d) in zip(axes.patches, ellipses, strict=True):
        corners = patch.get_xy()
        assert corners[0] == pytest.approx((np.degrees(a), omega * c))
        assert corners[45] == pytest.approx((np.degrees(b), omega * d))
        assert to_hex(patch.get_edgecolor()) == "#112233"
    numbers = [(one.get_text(), tuple(one.xy)) for one in axes.texts]
    assert numbers == [
        ("1", pytest.approx((np.degrees(0.01), omega * 0.3))),
        ("2", pytest.approx((np.degrees(-0.05), -omega * 0.1))),
    ]
    axes.clear()
    draw_attraction(axes, orbit(600.0, 30.0, 31.0, 50.5), ellipses[:1], "#112233", "rpm")
    assert axes.get_title() == "600 rpm, impacts at 30.00, 31.00, 50.50 deg"
    assert not axes.texts
    draw_attraction(axes, orbit(600.0, 30.0), ellipses[:1], "#112233", "rpm")
    assert axes.get_title() == "600 rpm, impact at 30.00 deg"


# --- planes of multipliers, motions of one speed


def test_the_plane_of_a_study_has_circles_of_two_sizes_and_says_what_its_numbers_are(
    axes, monkeypatch
):
    """The largest sizes that can be told apart; of real multipliers there is none."""
    pairs = [0.90, 0.87, 0.50, 0.86, 0.84, 0.3]  # |mu|; 0.87 and 0.86 are too near to 0.90
    points = [Made(value=600.0 + k, trace=0.1, det=size * size, multipliers=(size,) * 2)
              for k, size in enumerate(pairs)]  # fmt: skip
    points.append(Made(value=650.0, trace=3.0, det=0.99, multipliers=(2.6, 0.38)))
    planes = []
    monkeypatch.setattr(orbits, "draw_plane", lambda axes, *how: planes.append(how))
    monkeypatch.setattr(orbits, "number_pairs", lambda *_: numbered)
    scene = Made(branches=[Made(points=points)], lines=lambda of: [], colours=[], parameter="rpm",
                 every=lambda of: np.array([x for one in points for x in of(one)]))  # fmt: skip
    numbered = True
    orbits._draw_plane(axes, scene)
    ((largest, rings),) = planes
    assert largest == 2.6
    assert rings == pytest.approx([0.90, 0.84])
    assert axes.get_title() == "arrows: rising cam speed; numbers: rpm"
    scene.parameter = "restitution"
    orbits._draw_plane(axes, scene)
    assert axes.get_title() == "arrows: rising coefficient of restitution; numbers: its values"
    numbered = False
    orbits._draw_plane(axes, scene)
    assert axes.get_title() == "arrows: rising coefficient of restitution"


def test_at_most_two_values_are_named_at_which_a_pair_turns_real(axes, monkeypatch):
    monkeypatch.setattr(orbits, "draw_real", lambda *_: None)
    monkeypatch.setattr(orbits, "turning_real", lambda points: points)
    points = ([612.3456789], [], [640.0, 650.0])
    scene = Made(branches=[Made(points=own) for own in points], lines=lambda of: [], colours=[],
                 every=lambda of: np.array([600.0, 660.0]), events=[], parameter="mass",
                 study=Made(question=Made(span=None)))  # fmt: skip
    orbits._draw_real(axes, scene)
    assert [line.get_xdata()[0] for line in axes.lines] == [612.3456789, 640.0]
    assert axes.get_title() == "a complex pair turns real at 612.346 kg, 640 kg"
    scene.branches = scene.branches[1:2]
    orbits._draw_real(axes, scene)
    assert axes.get_title() == ""


def test_the_orbits_of_one_speed_share_the_range_of_the_longest(axes):
    def trace(turns, gap):
        return Made(low=0.0, high=360.0 * turns, angle=np.array([0.0, 180.0 * turns]), gap=gap,
                    u=np.array([3.0, -2.0, 1.0]), cam=np.array([0.01, 0.02]), units=MILLIMETRES,
                    q=np.array([0.03, 0.04]) * turns, sticks=np.array([False, False]),
                    events={})  # fmt: skip

    traces = [trace(1, np.array([0.0, 1e-5, 5e-6])), trace(3, np.array([0.0, 4e-3, 1e-3])),
              trace(2, np.array([0.0, 2e-4, 1e-4]))]  # fmt: skip
    three = [Made(stable=stable) for stable in (True, False, True)]
    shades = ["#112233", "#445566", "#778899"]
    orbits._draw_motion(axes, traces, three, shades)
    assert axes.get_xlim() == (0.0, 1080.0)
    assert list(axes.lines[0].get_xdata()) == [0.0, 540.0]
    assert [to_hex(line.get_color()) for line in axes.lines[1:4]] == shades
    assert [line.get_linestyle() for line in axes.lines[1:4]] == ["-", "--", "-"]
    traces[1].sticks = np.array([True, False])
    traces[1].during = lambda values, state: np.where(state, values, np.nan)
    orbits._draw_motion(rested := Figure().subplots(), traces, three, shades)
    (rest,) = (line for line in rested.lines if line.get_label() == "sticking")
    assert rest.get_ydata()[0] == pytest.approx(0.09)
    assert np.isnan(rest.get_ydata()[1])
    axes = Figure().subplots()
    orbits._draw_orbit(axes, traces, three, shades)
    assert axes.get_xlabel() == "relative position $q - c$ (mm)"  # all of them in one unit
    loops = [line for line in axes.lines if len(line.get_xdata()) == 4]
    assert [line.get_linestyle() for line in loops] == ["-", "--", "-"]
    assert [to_hex(line.get_color()) for line in loops] == shades
    for line, own in zip(loops, traces, strict=True):
        assert list(line.get_xdata()) == [*own.gap, own.gap[0]]
        assert list(line.get_ydata()) == [3.0, -2.0, 1.0, 3.0]


def test_an_orbit_that_never_leaves_the_cam_leaves_nowhere():
    one = orbit(700.0)
    one.resting = True
    _, row = orbits._orbit_rows([one], ["red"])
    assert row[4] == ""


def test_a_cover_shows_its_boxes_by_their_reasons_and_the_orbits_that_belong_to_it(axes):
    """An unstable orbit is open; orbits of one label are of one colour."""
    covers = [Made(turns=turns, drawn=drawn) for turns, drawn in ((1, [1]), (2, []), (3, [2]))]
    found = cover.draw_cover(Made(covers=covers, orbits=[]), Made(corners=[]), "T", "below")
    assert {name: panel.across for name, panel in found.panels.items()} == {
        "cover 1": 2, "cover 3": 2
    }  # fmt: skip
    alone = cover.draw_cover(Made(covers=covers[:2], orbits=[]), Made(corners=[]), "T", "below")
    assert [panel.across for panel in alone.panels.values()] == [1]

    def rooted(label, stable, start, *flights):
        root = Made(count=len(flights), theta=[radians(start), radians(start + flights[0])],
                    flight_length=lambda k: radians(flights[k]))  # fmt: skip
        return Made(label=label, stable=stable, turns=1, root=root)

    orbits_found = [rooted("P(1;2)", True, 20.0, 200.0, 160.0),
                    rooted("P(1;2)", False, 40.0, 210.0, 150.0),
                    rooted("P(1;1)", True, 60.0, 360.0)]  # fmt: skip
    boxes = [(boxed((10.0, 20.0), (200.0, 210.0)), "impact"),
             (boxed((30.0, 40.0), (240.0, 260.0)), "impact"),
             (boxed((30.0, 40.0), (100.0, 110.0)), "impact"),  # too short to be shown
             (boxed((50.0, 60.0), (255.0, 275.0)), "")]  # fmt: skip
    own = Made(turns=1, drawn=boxes, impacts=2, boxes=4)
    cover._draw(axes, own, orbits_found, {"a": 110.0})
    assert [len(one.get_paths()) for one in axes.collections] == [2, 1]
    assert [to_hex(one.get_facecolor()[0]).upper() for one in axes.collections] == [
        "#F2D9A6", "#E58FA3"
    ]  # fmt: skip
    marks = [one for one in axes.lines if one.get_marker() == "o"]
    places = [tuple(np.ravel(one.get_data())) for one in marks]
    assert places == [pytest.approx((20.0, 200.0)), pytest.approx((40.0, 210.0))]
    assert [one.get_label() for one in marks] == ["P(1;2), stable", "P(1;2), unstable"]
    assert marks[0].get_markerfacecolor() == marks[0].get_markeredgecolor()
    assert marks[1].get_markerfacecolor() == "white"
    assert marks[0].get_markeredgecolor() == marks[1].get_markeredgecolor()
    assert (axes.get_xlim(), axes.get_ylim()) == ((0.0, 360.0), pytest.approx((180.0, 232.0)))
    assert axes.get_title() == "2 impacts in 1 turn: 4 boxes"
    assert [one.get_label() for one in axes.lines if one.get_marker() == "s"] == [
        "the rates of an impact do not agree", "the box holds one orbit, which is known"
    ]  # fmt: skip
