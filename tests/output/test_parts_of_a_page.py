"""How many turns a page of `cam explore` shows, and of which motions: from parts made by hand."""

from __future__ import annotations

from contextlib import nullcontext
from math import pi, radians
from types import SimpleNamespace as Made

import numpy as np
import pytest

from camcli.analysis.integrate import Cost, Settings, Start
from camcli.analysis.labels import Label
from camcli.api import explore, explore_page
from camcli.api.explore_motions import PageMotion, attractors, of_sweep
from camcli.piece_faults import PieceFault, gathering

CAM = Made(strobe=0, stretches=[Made(start_c=0.5, start_c1=0.25)])
MACHINE = Made(system=Made(cam=CAM))


def motion(turns=1, rpm=700.0, label="P(1;1)", origin="up"):
    return PageMotion(rpm, label, origin, 1.0, 2.0, turns, True, True, None, None)


@pytest.mark.parametrize(
    ("shown", "basins", "of_map", "turns", "of_machines"),
    [
        (3, True, False, 8, 200),  # no more, though 349 200 rows are 13 turns of 100 * 256
        (3, False, True, 6, 200),  # its machines have 200 rows a turn
        (3, True, True, 6, 50),  # none has fewer than the page
        (3, True, True, 3, 200),  # each has half of it
        (3395, True, True, 1, 200),  # no less, though there are 10 000 rows left
        (3, False, False, None, 200),
    ],
)
def test_starts_and_maps_have_the_turns_that_are_left(
    monkeypatch, shown, basins, of_map, turns, of_machines
):
    """350 000 rows in all, 100 a turn: two motions have 5 and so many turns of them already."""
    asked = {}
    scene = Made(
        explore=Made(basins=basins, map=of_map), orbits=Made(starts=7),
        sweep=Made(rpm=Made(num=10)), run=Made(transient=3, record=5),
    )  # fmt: skip
    parts = {f"sweep {way}": way for way in explore.DIRECTIONS}
    parts |= {
        "orbits": "o",
        **({"basins": "b"} if basins else {}),
        **({"map": "m"} if of_map else {}),
    }
    wanted_parts = {"map": Made(scene=Made(sweep=Made(vary="axes")))}
    monkeypatch.setattr(explore, "parts_of", lambda scene: wanted_parts)
    monkeypatch.setattr(explore, "rows_of_the_page", lambda machine: 100)
    monkeypatch.setattr(explore, "rows_of_a_map", lambda machine, axes: {"axes": of_machines}[axes])
    monkeypatch.setattr(explore, "refuse_too_many", lambda span, rows: None)
    monkeypatch.setattr(explore, "for_work", lambda turns: asked.update(work=turns))
    monkeypatch.setattr(explore, "_computed", lambda *given: parts)

    def found(machine, sweeps, most):
        asked.update(sweeps=sweeps, most=most)
        return [motion(shown)]

    monkeypatch.setattr(explore, "attractors", found)
    monkeypatch.setattr(explore, "solved_motions", lambda *given: [motion(5, origin="solved")])

    def some(name):
        def of(machine, part, turns):
            asked[name] = part, turns
            return [motion(1, origin=name)]

        return of

    monkeypatch.setattr(explore, "motions_from_starts", some("start"))
    monkeypatch.setattr(explore, "motions_of_a_map", some("map"))
    monkeypatch.setattr(explore, "motions_of_stops", lambda machine: [motion(1, origin="stop")])
    simulated = []

    def simulation(machine, motion, rows):
        simulated.append((motion.origin, rows))
        return Made(trajectory=[] if motion.origin == "solved" else [1], name=motion.origin)

    monkeypatch.setattr(explore, "_simulated", simulation)
    seen, names = [], []
    monkeypatch.setattr(explore, "piece", lambda name, call: names.append(name) or call())
    explored = explore._explored(Made(scene=scene), lambda *told: seen.append(told), None, [])
    origins = ["up", *["start"] * basins, *["map"] * of_map, "stop"]
    assert [one.origin for one in explored.motions] == origins
    assert [one.name for one in explored.simulations] == origins  # the one without rows has none
    assert asked["sweeps"] == [(way, way) for way in explore.DIRECTIONS]
    assert asked["most"] == 250
    assert asked["work"] == (3 * 10 + 7) * 8
    assert asked.get("start") == (("b", turns) if basins else None)
    assert asked.get("map") == (("m", turns) if of_map else None)
    assert {rows for _, rows in simulated} == {100}
    assert seen[-1] == ("motions", len(origins) + 1, len(origins) + 1)
    of_motions = [f"the motion P(1;1) at 700 rpm ({origin})" for origin in origins]
    of_motions.insert(1, "the motion P(1;1) at 700 rpm (solved)")
    assert names == ["the stops", *of_motions]


def test_parts_of_a_page_are_computed_by_their_commands(monkeypatch):
    """A part that a fault has cost is left out; faults of pieces say which part they are of."""
    asked = []

    def command(name):
        def run(scene, progress=None, **more):
            asked.append((name, scene, progress, more))
            if scene == "broken":
                raise RuntimeError("no such orbit")
            return Made(faults=[PieceFault("600 rpm", "E", "m", "t")] if scene == "some" else [])

        return run

    for name in ("sweep", "basins", "orbits"):
        monkeypatch.setattr(explore, name, command(name))
    parts = {"sweep up": ("sweep", "first"), "orbits": ("orbits", "second"),
             "basins": ("basins", "broken"), "map": ("sweep", "some")}  # fmt: skip
    with gathering() as faults:
        computed = explore._computed(parts, "progress", "work")
    assert list(computed) == ["sweep up", "orbits", "map"]
    work = {"work": "work"}
    assert asked == [
        ("sweep", "first", "progress", work), ("orbits", "second", "progress", {}),
        ("basins", "broken", "progress", work), ("sweep", "some", "progress", work),
    ]  # fmt: skip
    assert [one.piece for one in faults] == ["basins", "map: 600 rpm"]


@pytest.mark.parametrize("basins", [True, False])
def test_a_page_is_asked_for_basins_or_a_map(monkeypatch, basins):
    monkeypatch.setattr(explore, "_explored", lambda machine, *given: given)
    monkeypatch.setattr(explore, "_result", lambda *given: given)
    monkeypatch.setattr(explore, "stopwatch", lambda: nullcontext(Made(seconds=12.5)))
    asked = {"with_basins": True} if basins else {"with_map": True}
    machine, explored, seconds, faults = explore.explore(None, "progress", work="work", **asked)
    section = machine.scene.explore
    assert (section.basins, section.map, section.source) == (basins, not basins, "-c SCENE.yaml")
    assert (explored, seconds) == (("progress", "work", faults), 12.5)
    assert explored[-1] is faults  # what is gathered is what the page tells


def test_a_motion_is_simulated_from_its_strobe_for_a_turn_more_than_it_is_shown(monkeypatch):
    settings = Settings(30, 40, 1e-9, 1000, Start(9.0, 9.0, 9.0))
    monkeypatch.setattr(explore, "simulate", lambda *given, **more: (given, more))
    monkeypatch.setattr(explore, "rows_per_turn", lambda follower, rpm: {700.0: 60, 70.0: 90}[rpm])
    system = Made(strobe=0.5, follower=None)
    for rpm, rows in ((700.0, 80), (70.0, 90)):
        one = PageMotion(rpm, "P(4;1:1:1:1)", "up", 1.0, 2.0, 4, True, True, None, system)
        given, more = explore._simulated(Made(settings=settings), one, 80)
        assert (given[0], given[1], given[3], more) == (system, rpm, rows, {"follow": False})
        own = given[2]
        assert (own.transient, own.record) == (0, 5)
        assert (own.start.q, own.start.v, own.start.theta) == (1.0, 2.0, 0.5)


@pytest.mark.parametrize("whole", [True, False])
def test_the_result_of_a_page_is_that_of_its_parts(whole):
    """Costs of all parts and motions; whole where each part is, and there is a motion."""

    def part(n, complete=True, **more):
        return Made(cost=Cost(n, 2 * n), complete=complete, notes=[f"note {n}"], **more)

    parts = {"sweep up": part(10), "orbits": part(200, whole, values=Made(bifurcations=[1, 2, 3]))}
    simulations = [Made(cost=Cost(1, 2)), Made(cost=Cost(3, 6))]
    machine = Made(scene=Made(sweep=Made(rpm=Made(num=21))), system=None)
    explored = Made(motions=[motion(), motion()], simulations=simulations, parts=parts)
    result = explore._result(machine, explored, 0.5, [])
    assert result.cost == Cost(214, 428)
    assert result.summary == {"speeds": 21, "motions": 2, "bifurcations": 3}
    assert result.notes == ("sweep up: note 10", "orbits: note 200")
    assert (result.complete, result.seconds, list(result.files)) == (whole, 0.5, ["explore.html"])
    none = explore._result(machine, Made(motions=[], simulations=[], parts={}), 0.5, [])
    assert (none.complete, none.files, none.notes) == (False, {}, (explore.NO_MOTION,))
    assert none.summary["bifurcations"] == 0


def speed(rpm, label, recorded, first=0.0):
    """Two impacts a turn, and a state at each strobe, of so many recorded turns."""
    turns = np.repeat(np.arange(recorded), 2)
    numbers = first + np.arange(2.0 * recorded)
    q, v = 10.0 + np.arange(recorded) + first, -20.0 - np.arange(recorded) - first
    return Made(
        rpm=rpm, label=label, exponent=0.25, impacts=(turns, 100.0 + numbers, None, -numbers),
        strobe=(np.arange(recorded), q, v, None, None),
    )  # fmt: skip


def test_motions_of_a_sweep_begin_where_their_last_period_does():
    """Of 6 recorded turns: 2 of period two, all 4 that are shown of what has no period."""
    speeds = [speed(700.0, Label((1.0, 2.0)), 6), speed(710.0, "aperiodic", 6),
              speed(720.0, Label((1.0,)), 0),
              speed(730.0, Label((1.0, 2.0, 3.0, 4.0, 5.0)), 6)]  # fmt: skip
    result = Made(values=[Made(speeds=speeds)])
    two, none, five = of_sweep(MACHINE, result, "down", 4, 12)  # points: 3 a speed
    for one in (two, none, five):
        assert (one.origin, one.exponent, one.system) == ("down", 0.25, MACHINE.system)
    assert [(one.rpm, one.turns, one.loops, one.stable) for one in (two, none, five)] == [
        (700.0, 2, True, True), (710.0, 4, False, None), (730.0, 4, False, True)
    ]  # fmt: skip
    assert [(one.q, one.v) for one in (two, none, five)] == [
        (14.0, -24.0), (12.0, -22.0), (12.0, -22.0)
    ]  # fmt: skip
    angles = [one.impacts[0].tolist() for one in (two, none, five)]
    assert angles == [[109.0, 110.0, 111.0]] * 3
    assert two.impacts[1].tolist() == [-9.0, -10.0, -11.0]
    assert [one.strobes[0].tolist() for one in (two, none, five)] == [
        [14.0, 15.0], [13.0, 14.0, 15.0], [11.0, 12.0, 13.0, 14.0, 15.0]
    ]  # fmt: skip
    assert two.strobes[1].tolist() == [-24.0, -25.0]
    (many, *_) = of_sweep(MACHINE, result, "down", 4, 400)
    assert many.impacts[0].tolist() == [108.0, 109.0, 110.0, 111.0]  # of its last period alone


def test_an_attractor_that_several_sweeps_find_is_shown_once():
    """By speed; of one label and period by any of its states, without a period by the label."""
    label = Label((1.0, 2.0))
    turned = speed(700.0, label, 6, first=1.0)  # the same states, a turn later
    found = {
        "up": [speed(710.0, label, 6), speed(700.0, label, 6), speed(720.0, "aperiodic", 20)],
        "down": [turned, speed(710.0, label, 6, first=50.0),
                 speed(720.0, "aperiodic", 6, first=900.0), speed(690.0, "contact", 6),
                 speed(700.25, label, 6)],
    }  # fmt: skip
    sweeps = [(way, Made(values=[Made(speeds=speeds)])) for way, speeds in found.items()]
    motions = attractors(MACHINE, sweeps, 100)
    assert [(one.rpm, one.origin) for one in motions] == [
        (690.0, "down"), (700.0, "up"), (700.25, "down"), (710.0, "up"), (710.0, "down"),
        (720.0, "up"),
    ]  # fmt: skip
    assert motions[-1].turns == 16
    assert attractors(MACHINE, sweeps, 0)[-1].turns == 1
    assert attractors(MACHINE, sweeps, 2)[-1].turns == 2


def test_events_of_branches_on_a_page(monkeypatch):
    """By speed, each once; the phases of impacts alone, speeds at the event's own."""
    monkeypatch.setattr(explore_page, "event_words", lambda event: f"{event.kind} it is")

    def event(kind, label, value, **more):
        own = {"rates": [0.5], "theta": [radians(155.5), radians(160.25)], "states": [(1.5, 0.25)]}
        return Made(kind=kind, label=label, value=value, error=1e-9, corner="b",
                    classification="class", orbit=Made(**{**own, **more}))  # fmt: skip

    events = [
        event("fold", "P(1;1)", 710.0), event("fold", "P(2;1:1)", 710.0),
        event("fold", "P(1;1)", 710.0 + 1e-9), event("grazing", "P(1;1)", 600.0),
    ]  # fmt: skip
    told = explore_page._bifurcations(Made(values=Made(bifurcations=events)))
    assert [(one["kind"], one["label"], one["rpm"]) for one in told] == [
        ("grazing", "P(1;1)", 600.0), ("fold", "P(1;1)", 710.0), ("fold", "P(2;1:1)", 710.0)
    ]  # fmt: skip
    omega = 20.0 * pi  # rad/s at 600 rpm
    assert told[0] == {
        "kind": "grazing", "label": "P(1;1)", "rpm": 600.0, "rpm_error": 1e-9, "corner": "b",
        "classification": "class", "words": "grazing it is", "theta_deg": [pytest.approx(155.5)],
        "u": [pytest.approx(0.5 * omega)], "q": [1.5], "v": [pytest.approx(0.25 * omega)],
    }  # fmt: skip


def test_a_map_on_a_page_rises_in_both_numbers(monkeypatch):
    """Whatever the order in which they were run: line after line of the second one."""
    monkeypatch.setattr(explore_page, "kind_of", lambda label: (len(label), label, f"c{label}"))
    monkeypatch.setattr(explore_page, "cell_edges", sorted)
    monkeypatch.setattr(explore_page, "name_and_unit", lambda key: (key, "m"))
    labels = [["b", "a", "cc"], ["a", "a", "b"]]  # at 3, 2, 1 and at 0.9, 0.5
    lines = [[Made(label=label) for label in line] for line in labels]
    study = Made(first=[3.0, 2.0, 1.0], second=[0.9, 0.5], lines=lines, keys=("rpm", "run.x"))
    told = explore_page._map_data(Made(values=[study]))
    assert (told["cells"], told["x"], told["y"]) == ([3, 2], [1.0, 2.0, 3.0], [0.5, 0.9])
    assert (told["labels"], told["colours"]) == (["a", "b", "cc"], ["ca", "cb", "ccc"])
    assert told["codes"].tolist() == [1, 0, 0, 2, 0, 1]


def test_a_window_of_starts_on_a_page_has_the_place_of_each_attractor(monkeypatch):
    """255 is below the cam; shares are those of attractors alone."""
    monkeypatch.setattr(explore_page, "colour_name", lambda label: f"c {label}")
    monkeypatch.setattr(explore_page, "basin_shares", lambda rpm, shares: (rpm, shares))
    speed = Made(branches=[7, 4], attractors=[Made(label="P(1;1)"), Made(label="contact")])
    tables = {
        "attractors": {"attractor": np.array([4, 7, 0]), "fraction": np.array([0.5, 0.25, 0.125]),
                       "label": np.array(["contact", "P(1;1)", "undecided"])},
        "basins": {"attractor": np.array([7, 4, -1, 0, 4, 7])},
    }  # fmt: skip
    section = Made(cells=(3, 2), q=(0.1, 0.9), v=(-20.0, 40.0), rpm=Made(start=700.0, stop=800.0))
    landed = Made(scene=Made(basins=section), tables=tables, values=[Made(speeds=[speed])])
    told = explore_page._basins_data(landed)
    assert told["codes"].tolist() == [1, 0, 255, 2, 0, 1]
    assert told["labels"] == ["contact", "P(1;1)", "undecided"]
    assert told["colours"] == ["c contact", "c P(1;1)", "c undecided"]
    assert told["words"] == (700.0, [("contact", 0.5), ("P(1;1)", 0.25)])
    assert (told["cells"], told["x"], told["y"]) == ((3, 2), (0.1, 0.9), (-20.0, 40.0))
