"""What a page of `cam explore` holds as plain data: of machines, motions and results made here."""

from __future__ import annotations

from base64 import b64decode
from math import degrees, nan, pi, radians
from types import SimpleNamespace as Made

import numpy as np
import pytest

import camcli
from camcli.analysis.labels import Label
from camcli.analysis.orbits.kinds import Kind
from camcli.analysis.simulate import FLIGHT, STICKING, Happening
from camcli.api import explore_page
from camcli.api.explore_motions import PageMotion
from camcli.api.machine import machine_of
from camcli.plots import style

RPM = 600.0  # ten turns a second
PERIOD_TWO = Label((1.0, 2.0))


def motion(**more):
    own = {
        "rpm": RPM, "label": PERIOD_TWO, "origin": "up", "q": 1.5, "v": 2.5, "turns": 3,
        "loops": False, "stable": True, "exponent": -0.25, "system": None, "place": (0.5, 0.75),
        "sets": {"follower.mass": 1.25},
    }  # fmt: skip
    return PageMotion(**{**own, **more})


def trajectory(rows):
    """Rows of a simulation: of (t in turns, contact), q and v are 10 t and -t."""
    return Made(trajectory=[(t / 10.0, 1.0, 10.0 * t, -t, 2.0, 3.0, at) for t, at in rows])


def test_rows_of_a_rest_and_of_a_chatter_that_say_nothing_are_left_out(monkeypatch):
    """A rest has its first and its last row; hops have their own in place of those in between."""
    hops = [(1.0, 1.5, [(1.2, 7.0, 8.0, 0.0), (1.2, 9.0, 10.0, 0.0)])]
    monkeypatch.setattr(explore_page, "_hops", lambda motion, happened: hops)
    rests = {0.25: STICKING, 0.5: STICKING, 0.75: STICKING, 0.875: STICKING, 1.75: STICKING,
             2.25: STICKING, 2.5: STICKING}  # fmt: skip
    times = [0.0, 0.25, 0.5, 0.75, 0.875, 1.0, 1.0, 1.25, 1.375, 1.5, 1.75, 2.0, 2.25, 2.5, 2.75]
    flown = trajectory([(t, rests.get(t, FLIGHT)) for t in times])
    t, q, v, rest = explore_page._rows(motion(), flown, ["events"], 2.5)
    assert t == pytest.approx([0.0, 0.25, 0.875, 1.0, 1.0, 1.2, 1.2, 1.5, 1.75, 2.0, 2.25, 2.5])
    inside = (t > 1.1) & (t < 1.3)
    assert q[~inside] == pytest.approx(10.0 * t[~inside])
    assert v[~inside] == pytest.approx(-t[~inside])
    assert (q[inside].tolist(), v[inside].tolist()) == ([7.0, 9.0], [8.0, 10.0])
    assert rest.tolist() == [x in rests for x in t]


def test_rows_of_one_time_stay_in_their_order(monkeypatch):
    """Before and behind an impact, also where there are many."""
    added = [(0.25 + k, 2.0 * k + n, 1.0, 0.0) for k in range(40) for n in (0, 1)]
    monkeypatch.setattr(explore_page, "_hops", lambda *given: [(50.0, 51.0, added)])
    rows = [(0.1 * k, 0.0, 1000.0 + 2 * k + n, 0.0, 0.0, 0.0, FLIGHT)
            for k in range(40) for n in (0, 1)]  # fmt: skip
    t, q, *_ = explore_page._rows(motion(turns=40), Made(trajectory=rows), [], 40.0)
    assert len(t) == 160
    assert np.all(np.diff(t) >= 0.0)
    pairs = q.reshape(-1, 2)
    assert np.all(np.diff(pairs, axis=1) == 1.0)


def test_hops_lie_where_the_cam_is_and_are_as_small_as_the_hardest_impact_allows():
    """On an eccentric cam c = e (1 - cos theta), strobe at 50 deg: c' at a hop is e sin(theta)."""
    e, r, omega = 0.02, 0.5, 20.0 * pi
    cam = {"kind": "eccentric", "base": 0.0, "lift": 2.0 * e}
    follower = {"mass": 1.0, "stiffness": 0.0, "gravity": 9.81, "restitution": r}
    scene = camcli.load_scene({"cam": cam, "follower": follower, "run": {"strobe_deg": 50.0}})
    system = machine_of(scene).system
    start, end = 0.03, 0.04  # s: from 0.3 to 0.4 turns after the strobe
    happened = [
        Happening(0.01, 0, 80.0, "impact", 0.0, -0.125, 0.1),
        Happening(0.02, 0, 120.0, "impact", 0.0, -100.0, 0.1),  # the hardest
        Happening(start, 0, 158.0, "impact", 0.0, -2.0, 0.1),
        Happening(end, 0, 194.0, "chatter", 0.0, 0.0, 0.0),
        Happening(0.05, 0, 230.0, "impact", 0.0, -1.0, 0.1),
        Happening(0.06, 0, 266.0, "detachment", 0.0, 0.0, 0.0),
        Happening(0.07, 0, 302.0, "chatter", 0.0, 0.0, 0.0),  # no impact comes before it
    ]
    ((begins, ends, rows),) = explore_page._hops(motion(system=system), happened)
    assert (begins, ends) == pytest.approx((0.3, 0.4))
    speeds = [1.0, 0.5, 0.25]  # 0.125 is less than 0.002 of 100
    assert len(rows) == 2 * len(speeds)
    for n, u in enumerate(speeds, 1):
        t = 0.4 - 0.1 * r**n
        theta = radians(50.0) + 2.0 * pi * t
        c, slope = e * (1.0 - np.cos(theta)), e * np.sin(theta)
        before, behind = rows[2 * n - 2 : 2 * n]
        assert before == pytest.approx((t, c, slope * omega - u, 0.0))
        assert behind == pytest.approx((t, c, slope * omega + r * u, 0.0))


def test_columns_of_all_motions_follow_each_other(monkeypatch):
    """Each motion says how many rows, events and points of them are its own."""
    monkeypatch.setattr(explore_page, "_branches", lambda part: f"branches of {part}")
    monkeypatch.setattr(explore_page, "_bifurcations", lambda part: f"events of {part}")
    for name in ("map", "basins"):
        monkeypatch.setitem(explore_page.PLANES, name, lambda part: f"plane {part}")
    cam = Made(cam=None)
    first = motion(system=cam,
                   impacts=(np.array([10.0, 20.0, 30.0]), np.array([-1.0, -2.0, -3.0])),
                   strobes=(np.array([4.0, 5.0]), np.array([6.0, 7.0])))  # fmt: skip
    second = motion(system=cam, rpm=60.0, label="aperiodic", origin="start", q=None, v=None,
                    turns=1, loops=True, stable=None, exponent=None, place=None, sets={},
                    impacts=(np.array([40.0]), np.array([-4.0])),
                    strobes=(np.array([8.0]), np.array([9.0])))  # fmt: skip
    happened = [Happening(0.1, 1, 0.0, "chatter", 0.0, -0.5, 0.0),
                Happening(0.2, 2, 0.0, "detachment", 0.0, 0.25, 0.0),
                Happening(0.31, 3, 0.0, "impact", 0.0, -0.75, 0.0)]  # fmt: skip
    flown = trajectory([(0.0, FLIGHT), (1.0, STICKING), (3.5, FLIGHT)])
    flights = [Made(trajectory=flown.trajectory, events=happened),
               Made(trajectory=[(0.5, 0, 1.0, 2.0, 0, 0, FLIGHT)], events=[])]  # fmt: skip
    parts = {"map": "M", "orbits": "O", "basins": "B"}
    told = explore_page.motion_data(Made(motions=[first, second], simulations=flights, parts=parts))
    one, two = told["motions"]
    assert one == {
        "rpm": RPM, "label": PERIOD_TWO, "symbols": (2.0, 1.0), "colour": "period2",
        "origin": "up", "q": 1.5, "v": 2.5, "turns": 3, "loops": False, "period": 2,
        "stable": True, "exponent": -0.25, "place": (0.5, 0.75), "sets": {"follower.mass": 1.25},
        "rows": 2, "events": 2, "impacts": 3, "strobes": 2,
    }  # fmt: skip
    assert two == {
        "rpm": 60.0, "label": "aperiodic", "symbols": (), "colour": "aperiodic",
        "origin": "start", "q": None, "v": None, "turns": 1, "loops": True, "period": 0,
        "stable": None, "exponent": None, "place": None, "sets": {},
        "rows": 1, "events": 0, "impacts": 1, "strobes": 1,
    }  # fmt: skip
    rows, events, points = ({key: list(column) for key, column in told[name].items()}
                            for name in ("rows", "events", "points"))  # fmt: skip
    assert rows == {"t": [0.0, 1.0, 0.5], "q": [0.0, 10.0, 1.0], "v": [0.0, -1.0, 2.0],
                    "rest": [0.0, 1.0, 0.0]}  # fmt: skip
    assert events == {"t": pytest.approx([1.0, 2.0]), "kind": [1, 2], "u": [-0.5, 0.25]}
    assert points == {"theta_deg": [10.0, 20.0, 30.0, 40.0], "u": [-1.0, -2.0, -3.0, -4.0],
                      "q": [4.0, 5.0, 8.0], "v": [6.0, 7.0, 9.0]}  # fmt: skip
    assert (told["branches"], told["bifurcations"]) == ("branches of O", "events of O")
    assert told["planes"] == ["plane B", "plane M"]
    bare = explore_page.motion_data(Made(motions=[second], simulations=flights[1:], parts={}))
    assert (bare["branches"], bare["bifurcations"], bare["planes"]) == ([], [], [])
    assert [len(column) for column in bare["events"].values()] == [0, 0, 0]


def test_columns_of_branches_on_a_page():
    """By number; each impact has its own column, without its phase where it is none."""
    table = {
        "branch": np.array([3, 1, 1, 3]), "rpm": np.array([700.0, 600.0, 610.0, 710.0]),
        "label": np.array(["P(2;2:1)", "P(1;1)", "P(2;2:1)", "P(2;2:1)"]),
        "stable": np.array([1, 0, 1, 0]),
        "theta_deg_1": np.array([10.0, 20.0, 30.0, 40.0]),
        "theta_deg_2": np.array([11.0, 21.0, nan, 41.0]),
        "q_m": np.array([0.5, 0.25, 0.125, 0.75]), "v_m_per_s": np.array([5.0, 2.5, 1.25, 7.5]),
        "u_minus_m_per_s_1": np.array([-1.0, -2.0, -3.0, -4.0]),
        "u_minus_m_per_s_2": np.array([-1.5, nan, -3.5, nan]),
    }  # fmt: skip
    points = [Made(label=Label((1.0,))), Made(label=PERIOD_TWO)]
    solved = Made(tables={"branch": table}, values=Made(
        orbits=[Made(label="contact")], branches=[Made(points=points[:1]), Made(points=points[1:])],
    ))  # fmt: skip
    assert explore_page._labels_of_branches(solved) == {"contact", "P(1;1)", "P(2;2:1)"}
    first, second = explore_page._branches(solved)
    columns = [[np.asarray(x).tolist() for x in first[name]] for name in ("q", "v", "u")]
    assert columns[:2] == [[[0.25, 0.125]], [[2.5, 1.25]]]
    assert (first["rpm"], first["label"]) == ([600.0, 610.0], ["P(1;1)", "P(2;2:1)"])
    assert (first["colour"], second["colour"]) == ("period1", "period2")
    assert (first["stable"].tolist(), second["stable"].tolist()) == ([0, 1], [1, 0])
    assert second["rpm"] == [700.0, 710.0]
    nothing = pytest.approx([nan, nan], nan_ok=True)
    assert first["theta_deg"][0].tolist() == [20.0, 30.0]
    assert first["theta_deg"][1].tolist() == nothing  # a departure, and no second impact
    assert second["theta_deg"][1].tolist() == pytest.approx([11.0, nan], nan_ok=True)
    assert first["u"][1].tolist() == pytest.approx([nan, -3.5], nan_ok=True)
    assert [column.tolist() for column in second["u"][:1]] == [[-1.0, -4.0]]


@pytest.mark.parametrize("guessed", [True, False])
def test_the_cam_of_a_page_is_its_outline_and_its_lift(monkeypatch, guessed):
    """Each second point of the outline without the last one, which is the first again.

    A lift c is c / ratio higher than the smallest radius where c is least: `rise` is what is left.
    """
    scene = camcli.load_scene(
        None,
        {"run.strobe_deg": 35.0, "sweep.rpm": {"start": 700.0, "stop": 690.0, "num": 7},
         "run.rpm": 655.0, "follower.damping": 3.5},
    )  # fmt: skip
    machine = machine_of(scene)
    asked = []
    x, y = np.arange(9.0), 100.0 + np.arange(9.0)
    outline = Made(body=(x, y), ratio=2.0, radius=np.array([7.0, 5.0, 9.0]), guessed=guessed,
                   flat=not guessed)  # fmt: skip
    monkeypatch.setattr(explore_page.Outline, "of_lift", lambda *of: asked.append(of) or outline)
    turn = Made(theta=[0.5, 1.5, 2.5], c=[3.0, 1.0, 2.0], c1=[10.0, 20.0, 30.0],
                c2=[40.0, 50.0, 60.0], corners={"a": 0.75, "b": 1.25})  # fmt: skip
    monkeypatch.setattr(
        explore_page, "profile", lambda *of, **more: asked.append((of, more)) or turn
    )
    monkeypatch.setattr(explore_page, "crank_turns", lambda scene, system: (scene, system))
    told = explore_page.machine_data(machine)
    assert told["crank"] == (scene, machine.system)
    system = machine.system
    assert asked == [
        (system, scene.cam.base_radius, scene.cam),
        ((system, 655.0, 720, None), {"drawn": False}),
    ]
    shape = told["outline"]
    assert shape.pop("x").tolist() == [0.0, 2.0, 4.0, 6.0]
    assert shape.pop("y").tolist() == [100.0, 102.0, 104.0, 106.0]
    assert shape == {"ratio": 2.0, "rise": 5.0 - 1.0 / 2.0, "told": not guessed,
                     "flat": not guessed}  # fmt: skip
    cam = {name: column.tolist() for name, column in told["cam"].items()}
    assert cam == {
        "theta_deg": pytest.approx([degrees(0.5), degrees(1.5), degrees(2.5)]),
        "c": turn.c, "c1": turn.c1, "c2": turn.c2,
    }  # fmt: skip
    assert told["corners"] == {"a": degrees(0.75), "b": degrees(1.25)}
    assert (told["strobe_deg"], told["speeds"]) == (35.0, [700.0, 690.0, 7])
    assert (told["kind"], told["follower"]["damping"]) == ("arcs", 3.5)
    assert (told["units"]["damping"], told["units"]["restitution"]) == ("N s/m", "")
    assert told["follower"].keys() == told["units"].keys()
    assert told["follower"] == {key: x for key, x in scene.follower if x is not None}
    assert (told["measured"], told["valve"], told["seat"], told["lash"]) == ("", False, False, None)


def test_a_measured_cam_says_between_which_speeds_contact_is_lost(monkeypatch):
    first = Made(rpm=650.5)
    monkeypatch.setattr(explore_page, "lost_between", lambda system: (600.0, 700.0))
    monkeypatch.setattr(explore_page, "detachment", lambda system: Made(first=first))
    monkeypatch.setattr(explore_page, "units_of", lambda system: f"units of {system}")
    monkeypatch.setattr(explore_page, "smoothed_cam", lambda *told: told)
    machine = Made(system="system", scene=Made(cam=Made(accuracy="accuracy")))
    assert explore_page._measured(machine) == ("accuracy", "units of system", (600.0, 700.0), 650.5)
    first = None
    monkeypatch.setattr(explore_page, "detachment", lambda system: Made(first=first))
    assert explore_page._measured(machine)[-1] is None
    monkeypatch.setattr(explore_page, "lost_between", lambda system: None)
    assert explore_page._measured(machine) == ""


def test_arrays_of_a_page_are_text_of_four_bytes_or_one():
    numbers = np.array([1.5, -2.25, nan])
    ((kind, text),) = explore_page._packed(numbers).items()
    assert kind == "f4"
    assert np.frombuffer(b64decode(text), "<f4").tolist() == pytest.approx(numbers, nan_ok=True)
    for flags in (np.array([True, False, True]), np.array([1, 0, 200])):
        ((kind, text),) = explore_page._packed(flags).items()
        assert kind == "u1"
        assert list(b64decode(text)) == [int(flag) for flag in flags]


def test_no_word_of_a_scene_ends_the_data_of_a_page():
    text = explore_page.page({"source": "-c '</script><b>.yaml'"})
    assert "</script><b>" not in text
    assert "-c '\\u003c/script>\\u003cb>.yaml'" in text


def test_every_motion_of_a_map_has_a_colour_and_its_area():
    assert explore_page.MOTIONS == (
        "longer", "rests", "aperiodic", "undecided", "period1", "period2", "period3", "period4",
    )  # fmt: skip
    for name in explore_page.MOTIONS:
        colour = explore_page.COLOURS[name]
        assert explore_page.COLOURS[f"area-{name}"] == style.AREAS[colour]


def test_an_event_that_branches_share_is_on_a_page_once(monkeypatch):
    """To ten digits of its speed; the first one stays, and slow ones come first."""

    monkeypatch.setattr(explore_page, "event_words", lambda event: [f"words of {event.label}"])

    def event(rpm, q, **more):
        own = {
            "kind": Kind.FOLD, "label": "P(1;1)", "value": rpm, "error": 0.5 * q, "corner": None,
            "classification": None,
            "orbit": Made(states=[(q, 0.125)], theta=[radians(30.0), radians(90.0)], rates=[-0.25]),
        }  # fmt: skip
        return Made(**{**own, **more})

    found = [
        event(700.0, 1.0), event(700.00001, 2.0), event(700.0 + 1e-8, 3.0),
        event(700.0, 4.0, label="P(2;2:1)"), event(700.0, 5.0, kind=Kind.GRAZING),
        event(650.0, 6.0),
    ]  # fmt: skip
    events = explore_page._bifurcations(Made(values=Made(bifurcations=found)))
    assert [one["q"] for one in events] == [[6.0], [1.0], [4.0], [5.0], [2.0]]
    one = events[1]
    omega = 700.0 * pi / 30.0
    assert (one["kind"], one["label"], one["rpm"], one["rpm_error"]) == (
        Kind.FOLD, "P(1;1)", 700.0, 0.5,
    )  # fmt: skip
    assert one["v"] == pytest.approx([0.125 * omega])
    assert one["u"] == pytest.approx([-0.25 * omega])
    assert one["theta_deg"] == pytest.approx([30.0])
    assert one["words"] == ["words of P(1;1)"]
