"""Clouds of points, numbers of curves, motions and words, by hand: sizes, places, words."""

from math import inf, nan, pi, radians
from types import SimpleNamespace as Made

import numpy as np
import pytest
from matplotlib.figure import Figure

from camcli.plots import axes as drawn_axes
from camcli.plots import curve_numbers, discs, simulate, sweep
from camcli.plots import orbits as drawn_orbits
from camcli.plots.axes import number_events
from camcli.quantities import METRES, THETA
from camcli.words import all_orbits, codim2, detach, explore, orbits, verdict
from camcli.words.loads import Struck, struck
from camcli.words.simulate import force_title, record_title
from camcli.words.speeds import number_range, spacing
from camcli.words.surge import surge_words

# --- discs


def test_discs_cover_about_a_third_of_their_paper_within_their_limits():
    """The paper is as wide as the step, or as the room within 0.085 to 0.2 mm; 16 mm more high."""

    def fitting(crowd, step, room, high):
        return float(discs._fitting(crowd, step, room, high))

    assert fitting(7, 0.5, 0.1, 4.0) == pytest.approx((4.0 / pi * 0.35 * 0.5 * 20.0 / 7.0) ** 0.5)
    assert fitting(7, 0.05, 0.1, 4.0) == pytest.approx((4.0 / pi * 0.35 * 0.1 * 20.0 / 7.0) ** 0.5)
    assert fitting(7, 0.05, 3.0, 4.0) == pytest.approx((4.0 / pi * 0.35 * 0.2 * 20.0 / 7.0) ** 0.5)
    assert fitting(0, 0.01, 0.02, 4.0) == pytest.approx((4.0 / pi * 0.35 * 0.085 * 20.0) ** 0.5)


@pytest.mark.parametrize(
    ("crowd", "step", "room", "high", "none"),
    [
        (3, 0.1, 0.1, 4.0, False),
        (90, 0.1, 0.1, 4.0, True),  # they would be smaller than 0.18 mm
        (30, 0.13, 0.13, 1.0, True),  # more than 6 a mm, beside others alike
        (5, 0.13, 0.13, 1.0, False),
        (30, 0.13, 0.2, 1.0, False),  # the next one alike is further away
        (17, 0.02, 0.2, 9.0, True),  # a line of others is upon it
        (16, 0.02, 0.2, 9.0, False),
        (17, 0.03, 0.2, 9.0, False),
        (200, 0.13, 0.2, 4.0, False),  # small ones that need not meet
    ],
)
def test_when_points_are_too_many_for_discs(crowd, step, room, high, none):
    assert bool(discs.have_no_room(crowd, step, room, high)) == none


@pytest.mark.parametrize(
    ("crowd", "way", "high", "wanted"),
    [
        (1, 0.3, 50.0, 0.45), (1, 0.1, 50.0, 0.4), (1, 0.4, 50.0, 0.54),
        (200, 0.5, 50.0, 0.54), (1, 0.5, 50.0, 0.3), (1, 0.7, 50.0, 0.42), (1, 2.0, 50.0, 0.45),
    ],
)  # fmt: skip
def test_discs_meet_where_they_make_a_line_and_leave_white_where_they_do_not(
    crowd, way, high, wanted
):
    """Half a millimetre apart they meet only where there are many: more than 3 to a mm."""
    size = float(discs.diameters(crowd, 5.0, 5.0, way, high))
    assert size == pytest.approx(wanted)
    many = float(discs.diameters(100000, 0.01, 0.01, 2.0, 50.0))
    assert many == 0.18
    line = float(discs.diameters(100000, 0.01, 0.01, 0.4, 50.0))
    assert line == 0.54  # they meet however many there are


def test_the_part_of_a_panel_that_discs_reach_has_a_pixel_at_least():
    radius = np.array([2.2, 1.0])
    for at, wanted in (
        ([50.5, 70.2], (46, 75)), ([3.0, 99.0], (0, 100)), ([-50.0, -40.0], (0, 1)),
        ([150.0, 160.0], (99, 100)),
    ):  # fmt: skip
        assert discs._with_discs(np.array(at), radius, 0, 100) == wanted


# --- numbers of curves


def test_places_of_a_panel_are_counted_in_points_from_its_corner():
    axes = Figure().subplots()
    axes.set(xlim=(10.0, 20.0), ylim=(-1.0, 3.0))
    size = np.array([200.0, 100.0])
    found = curve_numbers._in_points(axes, np.array([[10.0, 3.0], [12.5, -2.0]]), size)
    assert found == pytest.approx(np.array([[0.0, 100.0], [50.0, -25.0]]))


def test_the_line_to_a_number_is_free_at_both_ends():
    lead = curve_numbers._lead((6.0, 8.0))
    assert np.hypot(*lead.T) == pytest.approx([4.0, 5.0])
    assert lead[0] == pytest.approx([2.4, 3.2])
    assert curve_numbers._lead((8.0, 0.0)).shape == (0, 2)
    assert curve_numbers._joined([lead, lead[:1]]).shape == (3, 2)
    assert curve_numbers._joined([]).shape == (0, 2)


def test_nearness_is_one_on_another_and_none_from_the_distance_wanted():
    at = np.array([[0.0, 0.0], [3.0, 4.0], [30.0, 40.0]])
    others = np.array([[3.0, 4.0], [30.0, 42.0]])
    assert curve_numbers._nearness(at, others, 10.0) == pytest.approx([0.5, 1.0, 0.8])
    assert curve_numbers._nearness(at, np.empty((0, 2)), 10.0) == pytest.approx([0.0] * 3)


def test_ink_is_what_lies_on_the_cells_about_points_until_it_is_taken_back():
    ink = curve_numbers._Ink(np.array([30.0, 20.0]))
    line = ink.cells_of(np.array([[2.0, 5.0], [12.0, 5.0]]))
    mark = ink.cells_about(np.array([[20.0, 15.0]]), 2.0)
    ink.add(line)
    ink.add(line)
    ink.add(mark)
    asked = np.array([[[7.0, 5.0], [7.0, 12.0], [20.0, 15.0], [20.0, 5.0], [-9.0, 5.0]]])
    assert ink.any_along(asked) == pytest.approx([1.0, 0.0, 1.0, 0.0, 0.0])
    ink.remove(line)
    assert ink.any_along(asked)[0] == 1.0
    ink.remove(line)
    assert ink.any_along(asked) == pytest.approx([0.0, 0.0, 1.0, 0.0, 0.0])
    both = np.concatenate([asked, asked[:, ::-1]])  # of two points of a line one is enough
    assert ink.any_along(both) == pytest.approx([0.0, 0.0, 1.0, 0.0, 0.0])


# --- speeds of a sweep


def speed(value, impacts=None, strobe=None, label="contact", known=True, status=0, exponent=None):
    columns = [None if own is None else ([0.0] * len(own), own) for own in (impacts, strobe)]
    return Made(value=value, status=status, exponent=exponent, label=label, known=known,
                impacts=columns[0], strobe=columns[1])  # fmt: skip


def test_what_is_kept_of_speeds_are_their_ends_in_their_own_order():
    one = speed(620.0, [30.0, nan, 10.0, inf], [0.3, 0.1], exponent=-0.5, status=4)
    other = speed(600.0, [], [0.2], label="aperiodic", status=3)
    last = speed(610.0, [50.0], [0.4], known=False, exponent=0.25)
    found = sweep.DrawnSpeeds.of([one, other, last])
    assert list(found.values) == [620.0, 600.0, 610.0]
    assert list(found.troubled) == [600.0, 620.0]
    assert found.kinds == ["contact", "aperiodic", "undecided after rests"]
    assert found.exponents == pytest.approx([-0.5, nan, 0.25], nan_ok=True)
    assert list(found.impacts.count) == [2, 0, 1]
    assert [list(ends) for ends in found.impacts.ends()] == [[10.0, 50.0], [30.0, 50.0]]
    assert list(found.impacts.extremes(np.array([False, True, True]))) == [50.0, 50.0]
    assert [list(ends) for ends in found.strobe.ends()] == [[0.1, 0.2, 0.4], [0.3, 0.2, 0.4]]
    assert sweep.DrawnSpeeds.of([speed(1.0, [5.0])]).strobe is None
    kinds = ["undecided", "aperiodic", "with rests", "period 2", "contact", "period 2"]
    assert sweep.in_order(kinds) == ["contact", "period 2", "with rests", "aperiodic", "undecided"]


def test_solved_orbits_count_for_a_range_where_their_parameter_lies_in_it():
    branch = Made(values=[1.0, 2.0, 3.0, 4.0], q=[0.1, 0.2, 0.3, 0.4],
                  phases=[[10.0, 20.0, nan, 40.0], [50.0, 60.0, 70.0, 80.0]])  # fmt: skip
    columns = Made(low=2.0, high=3.0)
    assert list(sweep._solved([branch], "impacts", columns)) == [20.0, 60.0, 70.0]
    assert list(sweep._solved([branch, branch], "strobe", columns)) == [0.2, 0.3, 0.2, 0.3]
    assert len(sweep._solved([], "strobe", columns)) == 0


def test_positions_are_one_within_a_millionth_of_the_lift():
    def is_one(*positions):
        speeds = [speed(float(k), strobe=[q]) for k, q in enumerate(positions)]
        return sweep._is_one(sweep.DrawnSpeeds.of(speeds), Made(lift=0.05))

    assert is_one(0.01, 0.01 + 4e-8)
    assert not is_one(0.01, 0.01 + 6e-8)
    assert not is_one(0.01)
    assert not sweep._is_one(sweep.DrawnSpeeds.of([speed(1.0, [5.0])]), Made(lift=0.05))


def test_a_panel_is_shown_in_those_of_its_section_that_show_more():
    columns = Made(low=601.0, high=602.0)
    views = {
        name: Made(section=name.split()[0] if name != "enlarged" else "impacts", across=across,
                   columns=columns, limits=limits)
        for name, across, limits in (
            ("impacts", 1, (0.0, 360.0)), ("enlarged", 1, (20.0, 50.0)), ("strobe", 1, (0.0, 1.0)),
            ("strobe enlarged", 1, (0.2, 0.4)), ("impacts zoom 1", 2, (25.0, 30.0)),
            ("strobe zoom 1", 2, (0.1, 0.5)),
        )
    }  # fmt: skip

    def shown(name):
        parts = sweep._shown_in(name, views[name], views)
        return {other: (one.keywords["way"], one.keywords["span"]) for other, one in parts.items()}

    span = ("x", (601.0, 602.0))
    assert shown("impacts") == shown("strobe") == {}
    assert shown("enlarged") == {"impacts": ("y", (20.0, 50.0))}
    assert shown("strobe enlarged") == {"strobe": ("y", (0.2, 0.4))}
    assert shown("impacts zoom 1") == {"impacts": span, "enlarged": span}
    assert shown("strobe zoom 1") == {"strobe": span, "strobe enlarged": span}


# --- motions and cams


def test_lifts_at_phases_of_any_turn_are_those_of_their_stretch(monkeypatch):
    """Stretches may stand in any order, and the first begin behind the strobe."""
    asked = []
    monkeypatch.setattr(drawn_axes, "column", lambda cam, name: [4.0, 0.5, 2.0])
    monkeypatch.setattr(
        drawn_axes, "_values", lambda cam, stretch, x: asked.append((list(stretch), list(x)))
    )
    turn = 2.0 * pi
    drawn_axes.lift(None, np.array([0.6, 1.9, 2.0, 3.9, 4.0, 6.2, 0.2, turn + 0.6, 2.5 - turn]))
    ((stretch, x),) = asked
    assert stretch == [1, 1, 2, 2, 0, 0, 0, 1, 2]
    assert x == pytest.approx([0.6, 1.9, 2.0, 3.9, 4.0, 6.2, turn + 0.2, 0.6, 2.5])


def test_corners_are_named_where_they_first_are_up_to_four_and_a_half_turns():
    simulation = Made(corners=[radians(50.0), radians(300.0)])
    trace = Made(low=1180.0, high=1540.0)
    assert simulate._named_corners(trace, simulation) == [
        (pytest.approx(1380.0), "b"), (pytest.approx(1490.0), "a")
    ]  # fmt: skip
    trace.high = trace.low + 4.5 * 360.0
    assert len(simulate._named_corners(trace, simulation)) == 2
    trace.high += 1.0
    assert simulate._named_corners(trace, simulation) == []


@pytest.mark.parametrize(
    ("low", "high", "points", "step", "names"),
    [
        (37.5, 397.5, 130.0, 60.0, ["60", "120", "180", "240", "300", "0"]),
        (720.0, 1440.0, 200.0, 90.0, ["0", "90", "180", "270", "0", "90", "180", "270", "0"]),
        (397.5, 2197.5, 130.0, 360.0, ["2", "3", "4", "5", "6"]),
        (360.0, 3960.0, 130.0, 720.0, ["2", "4", "6", "8", "10"]),
    ],
)
def test_angles_are_within_the_turn_unless_there_are_many(low, high, points, step, names):
    """Ticks are 21 pt apart at least; turns are counted from the start of the run."""
    figure = Figure(figsize=(points / 72.0, 1.0), dpi=300)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    simulate.angle_axis(axes, Made(low=low, high=high))
    ticks = axes.get_xticks()
    assert np.diff(ticks) == pytest.approx(np.full(len(ticks) - 1, step))
    assert [text.get_text() for text in axes.get_xticklabels()] == names
    assert axes.get_xlim() == (low, high)
    assert axes.get_xlabel() == (THETA.label if step < 360.0 else "cam angle (turns)")
    whole = [tick for tick in ticks if tick % 360.0 == 0.0]
    assert [line.get_xdata()[0] for line in axes.lines] == pytest.approx(whole)


def test_events_at_one_place_stand_in_the_order_of_their_numbers():
    axes = Figure().subplots()
    axes.set_xlim(600.0, 700.0)
    number_events(axes, [(9, 650.0), (12, 640.0), (3, 650.0), (None, 650.0)], named=True)
    said = sorted((text.xyann[0], text.get_text()) for text in axes.texts)
    assert [number for _, number in said] == ["12", "3", "9"]


# --- words


def test_a_follower_of_an_eccentric_is_a_ball_unless_it_has_a_spring(monkeypatch):
    monkeypatch.setattr(explore, "is_valve", lambda scene, system: False)
    monkeypatch.setattr(explore, "crank_turns", lambda scene, system: 0.0)
    told = [
        (one.follower, one.cam, one.pull)
        for kind in ("eccentric", "law")
        for stiffness in (0.0, 5.0)
        for one in [
            explore.Machine.of(
                Made(
                    follower=Made(stiffness=stiffness, restitution=0.5, preload=0.0, gravity=9.81),
                    cam=Made(kind=kind),
                ),
                None,
            )
        ]
    ]
    assert told == [
        ("ball", "table", "its weight"), ("follower", "cam", "the spring"),
        ("follower", "cam", "its weight"), ("follower", "cam", "the spring"),
    ]  # fmt: skip


def test_an_orbit_is_drawn_in_a_cover_that_it_goes_round_several_times():
    def orbit(label, turns, *symbols):
        return Made(label=label, turns=turns, symbols=symbols)

    covers = [Made(impacts=2, turns=4), Made(impacts=2, turns=1)]
    found = Made(orbits=[orbit("P(2;1:0)", 2, 1.0, 0.0), orbit("P(1;1)", 1, 1.0),
                         orbit("P(1;2)", 1, 2.0), orbit("P(2;2:2)", 2, 2.0, 2.0),
                         orbit("P(4;2:0:0:0)", 4, 2.0)])  # fmt: skip
    assert list(all_orbits._not_drawn(found, covers)) == ["P(1;1) has 1 impact and is not drawn."]
    assert list(all_orbits._not_drawn(found, covers[:1])) == [
        "P(1;1) has 1 impact and is not drawn.",
        "P(1;2) has 2 impacts and is not drawn.",
        "P(2;2:2) has 4 impacts and is not drawn.",
    ]


def test_a_least_force_has_the_fourth_digit_of_the_largest():
    for forces, least, said in (
        ([1234.5, -7.456], -7.456, "−7 N"), ([12.345, 1.23456], 1.23456, "1.23 N"),
        ([0.5, -999.9], -999.94, "−999.9 N"), ([0.0], 0.0, "0 N"),
    ):  # fmt: skip
        curve = Made(rpm=600.5, force_n=forces, lowest_n=least)
        assert force_title(curve) == f"at 600.5 rpm, least {said}"


def test_a_title_of_events_says_which_of_them_are_listed():
    found = Made(rpm=700.0, label="P(2;1:2)", events=[0] * 9, repeats=2, last_period=[0] * 3)
    head = "700 rpm: P(2;1:2), 9 events recorded"
    assert record_title(found, 9) == head
    assert record_title(found, 3) == f"{head}, those of one period"
    assert record_title(found, 4) == f"{head}, the last 4"
    found.repeats = 0
    assert record_title(found, 3) == f"{head}, the last 3"


def test_neighbouring_speeds_are_as_far_apart_as_the_closest_two_that_differ():
    assert spacing([610.0, 600.0, 600.25, 605.0, 600.0]) == 0.25
    assert spacing([600.0, 605.0, 605.125, 606.0]) == 0.125
    assert spacing([600.0, 600.0]) == spacing([600.0]) == spacing([]) == 0.1
    assert number_range(-0.001, 12.5, 3) == "0.0 to 12.5"


def test_a_range_as_narrow_as_a_computation_leaves_nothing_open():
    first = Made(rpm=700.0, low=700.0 - 1e-10, high=700.0 + 1e-10)
    assert detach._or_open("it holds", first, True) == "it holds"
    first.low, first.high = 690.0, 712.0
    assert detach._or_open("it holds", first, False) == "it holds"
    assert detach._or_open("it holds", first, True) == (
        "on the fitted cam it holds; the error of its table leaves that open (690 to 712 rpm)"
    )


def test_a_lobe_is_rested_on_after_any_impact_without_a_bounce():
    """Also where later ones bounce; what happens on the seat counts for nothing."""

    def told(*rows):
        names = "event", "theta_deg", "u_minus_m_per_s", "u_plus_m_per_s"
        events = dict(zip(names, zip(*rows, strict=True), strict=True))
        system = Made(is_seat=lambda theta: theta > radians(300.0))
        return verdict._on_the_seat(Made(tables={"events": events}, system=system), "700 rpm")

    bounces = ("impact", 100.0, -0.5, 0.25)
    rests = ("impact", 110.0, -0.25, 0.0)
    seats = ("impact", 310.0, -0.75, 0.0)
    end = "the lobe hits it with up to 0.5 m/s, and it comes to its seat with up to 0.75 m/s."
    assert told(rests, bounces, seats) == (
        f"At 700 rpm the follower keeps to the lobe once that has hit it: {end}"
    )
    assert told(bounces, seats) == (
        f"At 700 rpm the follower bounces on the lobe and never rests on it: {end}"
    )
    assert "keeps to the lobe" in told(bounces, ("chatter", 120.0, nan, nan), seats)
    assert "never rests" in told(bounces, ("chatter", 320.0, nan, nan), seats)
    assert "leaves the lobe" in told(rests, bounces, ("detachment", 150.0, nan, nan), seats)


def test_landings_past_the_loss_are_faster_than_it_and_have_an_impact():
    columns = {name: np.arange(1.0, 6.0) for name in verdict._Landing._fields}
    columns["rpm"] = np.array([690.0, 700.0, 710.0, 720.0, 730.0])
    columns["max_impact_m_per_s"] = np.array([1.0, 2.0, 3.0, 0.0, 0.5])

    class Table:
        columns = (*verdict._Landing._fields, "more")

        def arrays(self, *names):
            return {name: columns[name] for name in names}

    found = verdict._landings(Made(tables={"speeds": Table()}), 700.0)
    assert list(found.rpm) == [710.0, 730.0]
    assert list(found.speeds) == [690.0, 700.0, 710.0, 720.0, 730.0]
    assert found.most("max_gap_m") == 5.0
    assert (found.hardest.rpm, found.hardest.max_impact_m_per_s) == (710.0, 3.0)


def test_each_corner_impact_of_a_point_of_codimension_two_has_its_corner():
    corner, other = codim2.Test.CORNER, next(one for one in codim2.Test if one.value == "fold")
    point = Made(corners=["c", "a"], meets=[corner, other, corner])
    assert codim2.meets_words(point) == f"{corner} at c & fold & {corner} at a"


def test_a_branch_is_named_with_the_regions_of_its_middle():
    points = [
        Made(value=600.0 + k, regions=own) for k, own in enumerate((["A1"], ["A2", "A3"], []))
    ]
    branch = Made(number=4, labels=["P(1;1)"], ends=("", ""), points=points)
    assert orbits.branch_words(branch, "rpm", None, 40) == "4   P(1;1), impacts in A2, A3"
    assert (
        orbits.branch_words(branch, "rpm", 3, 43) == "4   P(1;1), from event 3, impacts in A2, A3"
    )
    assert orbits.branch_words(branch, "rpm", 3, 42) == "4   P(1;1), from event 3"


def test_a_class_rests_on_the_first_two_inequalities(monkeypatch):
    monkeypatch.setattr(orbits, "inequality_text", lambda one: one.rule)
    rules = [Made(rule=f"rule {k}", holds=k != 2, left=0.5 - k) for k in (1, 2, 3)]
    event = Made(corner_impact=Made(collision=Made(inequalities=rules)))
    assert orbits._rests_on(event) == (
        " The class rests on: rule 1 holds (-0.5); rule 2 fails (-1.5)."
    )
    assert orbits._rests_on(Made(corner_impact=None)) == ""


def test_the_opening_blow_is_where_the_stretch_of_the_seat_ends():
    """Also where that is the end of the turn; a rounding before its beginning is on it."""

    def struck_at(theta, low, high):
        return struck(Made(has_seat=True, is_seat=lambda x: low <= x < high), theta)

    turn = 2.0 * pi
    for low, high in ((5.0, turn), (4.0, 6.0)):
        end = high % turn
        assert struck_at(end, low, high) is Struck.BLOW
        assert struck_at(end - 1e-8, low, high) is Struck.SEAT
        assert struck_at(low - 5e-10, low, high) is Struck.SEAT
        assert struck_at(low - 1e-6, low, high) is None
        assert struck_at(1.0, low, high) is None
    assert struck(Made(has_seat=False, is_seat=lambda x: True), 5.0) is None


# --- arrows, zooms, states


def test_an_arrow_stands_where_a_wide_flight_turns_back():
    """Not where one of a small flight does, nor within a rest."""
    gap = np.array([0.0, 4.0, 10.0, 9.0, 0.0, 2.0, 2.5, 2.4, 0.0, 4.0, 5.0])
    u = np.array([5.0, 2.0, 1.0, -1.0, -3.0, 2.0, 1.0, -2.0, 3.0, 2.0, 0.0])
    sticks = np.zeros(11, dtype=bool)

    def arrows():
        axes = Figure().subplots()
        simulate._draw_ways(axes, Made(gap=gap, u=u, sticks=sticks))
        return [(tuple(one.xyann), tuple(one.xy)) for one in axes.texts]

    assert arrows() == [((10.0, 1.0), (9.0, -1.0)), ((4.0, 2.0), (5.0, 0.0))]
    sticks[3] = True
    assert arrows() == [((4.0, 2.0), (5.0, 0.0))]


def test_the_section_of_orbits_has_half_a_value_beside_a_single_one(monkeypatch):
    """And the lift where that value is zero."""
    for name in ("strobe_axis", "unit_axis"):
        monkeypatch.setattr(drawn_orbits, name, lambda *_: None)
    monkeypatch.setattr(drawn_orbits, "units_of", lambda system: None)

    def ranges(*states):
        axes = Figure().subplots()
        one = Made(states=list(states), stable=True)
        drawn_orbits._draw_states(axes, [one], ["red"], Made(lift=0.04))
        return axes.get_xlim(), axes.get_ylim()

    assert ranges((0.01, -0.5)) == (pytest.approx((0.005, 0.015)), pytest.approx((-0.75, -0.25)))
    assert ranges((0.0, 0.0)) == (pytest.approx((-0.04, 0.04)), pytest.approx((-0.04, 0.04)))
    assert ranges((0.01, 3.0), (0.02, 1.0)) == (
        pytest.approx((0.0096, 0.0204)), pytest.approx((0.92, 3.08))
    )  # fmt: skip


def test_a_zoom_is_as_high_as_the_branches_near_its_corner(monkeypatch):
    """Phases beyond its reach, and those beside its range, do not count."""
    heights = []
    for name in ("draw_strands", "mark", "corner_lines", "number_branches", "number_events"):
        monkeypatch.setattr(drawn_orbits, name, lambda *_, **__: None)
    monkeypatch.setattr(
        drawn_orbits, "_draw_simulated", lambda axes, scene, what, *limits: heights.append(limits)
    )
    lines = [[Made(x=[699.0, 699.5, 700.0, 700.5, 702.0], y=[98.2, 98.5, 101.0, 104.0, 101.9])]]
    scene = Made(parameter="rpm", branches=[], proved=[], colours=["red"], events=[],
                 corners={"a": 100.0}, lines=lambda of: lines)  # fmt: skip
    event = Made(value=700.0, number=1)
    zoom = drawn_orbits.Zoom(event, 100.0, 0.75, 2.0)
    axes = Figure().subplots()
    drawn_orbits._draw_zoom(axes, zoom, scene)
    ((limits, span),) = heights
    assert limits == pytest.approx((98.25, 101.25))
    assert span == axes.get_xlim() == (699.25, 700.75)
    lines[0][0].y = [50.0] * 5
    drawn_orbits._draw_zoom(axes, zoom, scene)
    assert heights[1][0] == pytest.approx((99.9, 100.1))


def test_surge_names_the_first_harmonic_and_the_strongest():
    harmonics = ((9, 2500.0, 1.5), (7, 3214.0, 4.25), (5, 4500.0, 2.0))
    found = [Made(number=k, rpm=rpm, factor=factor) for k, rpm, factor in harmonics]
    asked = []
    surge = Made(hertz=375.0, strong_below=lambda rpm: asked.append(rpm) or found)
    (said,) = surge_words(surge, 5000.0)
    assert said.startswith(
        "The spring's own frequency is 375 Hz: harmonic 9 meets it at 2500 rpm with 1.5, harmonic "
        "7 at 3214 rpm with 4.2, over the usual "
    )
    found.sort(key=lambda one: -one.factor)
    (said,) = surge_words(surge, None)
    assert "harmonic 7 meets it at 3214 rpm with 4.2, over the usual " in said
    found.clear()
    assert " meets it; surge itself is not simulated" in surge_words(surge, None)[0]
    assert " meets it below 5000 rpm; " in surge_words(surge, 5000.0)[0]
    assert asked == [5000.0, inf, inf, 5000.0]


def test_the_panel_of_a_motion_holds_a_lobe_that_is_clear_of_its_follower():
    """The names of corners have room above; time above the panel begins where the run did."""
    angle = np.array([400.0, 580.0, 760.0])
    still = np.array([False, False, False])
    trace = Made(
        low=400.0, high=760.0, origin=40.0, angle=angle, lobe=np.array([-1.0, 0.5, -0.5]),
        cam=np.array([0.0, 1.0, 0.0]), q=np.array([0.0, 2.0, 0.5]), sticks=still, seated=still,
        bend=np.ones(3), events={}, units=METRES, during=lambda values, state: values,
    )  # fmt: skip
    for corners, above in (([], 0.18), ([radians(90.0)], 0.18 * 2.6)):
        axes = Figure().subplots()
        simulate._draw_motion(axes, trace, Made(corners=corners, rpm=600.0))
        assert axes.get_ylim() == pytest.approx((-1.18, 2.0 + above))
        (time,) = axes.child_axes
        time._set_lims()
        assert time.get_xlim() == pytest.approx((0.1, 0.2))  # s, at ten turns a second
        labels = [line.get_label() for line in axes.lines]
        assert "lobe less lash, or seat" in labels
    trace.lobe = trace.cam
    axes = Figure().subplots()
    simulate._draw_motion(axes, trace, Made(corners=[], rpm=600.0))
    assert axes.get_ylim() == pytest.approx((-0.12, 2.12))
    assert "cam" in [line.get_label() for line in axes.lines]
    # of a cam without a lift
    for height, limits in ((3.0, (2.82, 3.18)), (-3.0, (-3.18, -2.82)), (0.0, (-1.0, 1.0))):
        trace.cam = trace.lobe = trace.q = np.full(3, height)
        axes = Figure().subplots()
        simulate._draw_motion(axes, trace, Made(corners=[], rpm=600.0))
        assert axes.get_ylim() == pytest.approx(limits)


def test_a_solved_branch_is_solid_where_it_is_stable_and_keeps_to_the_range():
    axes = Figure().subplots()
    axes.set_xlim(2.0, 5.0, auto=True)
    axes.set_ylim(0.0, 100.0, auto=True)
    branch = Made(values=[1.0, 2.0, 3.0, 4.0, 6.0], stable=[True, True, False, True, False])
    sweep._draw_branch(axes, branch, [[10.0, 20.0, 30.0, 40.0, 50.0]])
    lines = [one for one in axes.lines if one.get_label().startswith("solved")]
    assert [one.get_label() for one in lines] == ["solved, stable", "solved, unstable"]
    assert [one.get_linestyle() for one in lines] == ["-", "--"]
    for one, wanted in zip(
        lines, ([10.0, 20.0, nan, 40.0, nan], [nan, nan, 30.0, nan, 50.0]), strict=True
    ):
        assert one.get_xdata() == pytest.approx([nan, 2.0, 3.0, 4.0, nan], nan_ok=True)
        assert one.get_ydata() == pytest.approx(wanted, nan_ok=True)
    below = [one for one in axes.lines if one.get_color() == "white"]
    assert [one.get_zorder() for one in below + lines] == [4, 4, 5, 5]
    assert (axes.get_xlim(), axes.get_ylim()) == ((2.0, 5.0), (0.0, 100.0))


def test_the_course_of_an_animation_tells_a_flight_from_rests_on_cam_and_seat():
    angle = np.array([0.0, 90.0, 180.0, 270.0])
    sticks, seated = np.array([False, True, True, False]), np.array([False, False, True, False])
    trace = Made(cam=np.array([0.01, 0.02, 0.03, 0.02]), q=np.array([0.04, 0.02, 0.03, 0.05]),
                 sticks=sticks, seated=seated, units=METRES,
                 during=lambda values, state: np.where(state, values, nan))  # fmt: skip
    axes = Figure().subplots()
    simulate._draw_course(axes, trace, angle, "law")
    own = {
        line.get_label(): (line.get_ydata().tolist(), line.get_color(), line.get_linewidth())
        for line in axes.lines[1:]
    }
    assert own == {
        "in flight": (pytest.approx([0.04, nan, nan, 0.05], nan_ok=True), "#0072B2", 1.4),
        "at rest on the cam": (pytest.approx([nan, 0.02, nan, nan], nan_ok=True), "#E69F00", 3.0),
        "at rest on the seat": (pytest.approx([nan, nan, 0.03, nan], nan_ok=True), "#4D4D4D", 3.0),
    }
    assert axes.lines[0].get_ydata().tolist() == trace.cam.tolist()
    axes.clear()
    trace.sticks = trace.seated = np.zeros(4, dtype=bool)
    simulate._draw_course(axes, trace, angle, "oscillator")
    assert [line.get_label() for line in axes.lines[1:]] == ["in flight"]
