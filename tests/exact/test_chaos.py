"""Boxes of impacts that cover one another: proved, written as a certificate, and checked.

The judge of the boxes is mpmath at 30 digits (`tests.support.oracle`), which flies from points on
their edges; that of the growth is the largest root of the polynomial of the graph's two loops.
"""

import csv
import json
from copy import deepcopy
from math import exp, log
from types import SimpleNamespace

import numpy as np
import pytest
from mpmath import mp, mpf

from camcli.analysis.chaos import homoclinic
from camcli.analysis.chaos.section import Lands, SectionBox, growth_of
from tests.support.oracle import ArcsCam, Flight, Follower
from tests.support.refusals import reasons


@pytest.fixture(scope="module")
def proof(tmp_path_factory):
    """(rows of chaos.csv, run.json, proof.json) of the default machine at 745 rpm."""
    import camcli

    folder = tmp_path_factory.mktemp("chaos")
    scene = camcli.load_scene(None, {"orbits.rpm.start": 745.0, "orbits.rpm.stop": 745.0})
    camcli.orbits(scene, chaos=True).save(folder, plot=False)
    with (folder / "chaos.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    record, content = (
        json.loads((folder / name).read_text()) for name in ("run.json", "proof.json")
    )
    return rows, record, content


@pytest.mark.parametrize("loop", [2, 3, 5, 9])
def test_the_growth_is_that_of_a_fixed_point_and_a_loop(loop):
    """Closed walks of 1 and of n steps: the growth x solves x^n = x^(n - 1) + 1."""
    pairs = ((0, 0), *((k, (k + 1) % loop) for k in range(loop)))
    growth, weights = growth_of(loop, pairs)
    root = max(np.roots([1, -1, *[0] * (loop - 2), -1]).real)
    assert root - 2e-9 < growth <= root
    assert min(weights) > 0


@pytest.mark.parametrize("pairs", [((0, 1), (1, 0)), ((0, 1),), ()])
def test_one_loop_or_none_does_not_grow(pairs):
    assert growth_of(2, pairs)[0] <= 1.0


def test_a_statement_without_boxes_is_refused(checked):
    chaos = {"kind": "chaos", "parameter": "rpm", "low": "745", "high": "745", "boxes": [],
             "coverings": [], "growth": "2", "weights": [],
             "constants": {"rpm": None, "mass": "1", "stiffness": "100", "damping": "0",
                           "gravity": "0", "preload": "0", "restitution": "0.8"}}  # fmt: skip
    level = {"end": "2*pi", "center": "0", "polynomial": ["1"], "wave": [], "circle": [],
             "seat": False}  # fmt: skip
    cam = {"kind": "eccentric", "numbers": {}, "formulas": [], "stretches": [level],
           "seat_restitution": None}  # fmt: skip
    whole = {"format": "camcli-proof-1", "cam": cam, "statements": [chaos], "uncovered": []}
    code, text = checked(whole)
    assert code == 1
    assert "a box has not two numbers and four of its axes" in reasons(text)


@pytest.mark.ci
def test_chaos_at_745_rpm_is_proved_and_confirmed(proof, checked):
    rows, record, content = proof
    chaos = record["result"]["chaos"]
    assert chaos["proved"]
    assert all(row["proved"] == "yes" for row in rows)
    assert chaos["entropy_per_turn"] == pytest.approx(log(chaos["growth_per_impact"]))
    assert chaos["entropy_per_second"] == pytest.approx(chaos["entropy_per_turn"] * 745 / 60)
    assert exp(chaos["entropy_per_impact"]) > 1.3
    code, text = checked(content)
    assert code == 0, text
    assert text.startswith("confirmed: chaos for every rpm from 744.99999")


@pytest.mark.ci
def test_the_boxes_cover_one_another_where_mpmath_flies_from_their_edges(proof):
    rows, _, _ = proof
    with mp.workdps(30):
        cam, follower = ArcsCam(flank_radius=mpf(0.4) + mpf(0.45)), Follower.make(1.221, 1430.8)
        omega = mpf(745) * mp.pi / 30
        boxes = [box_of(row) for row in rows]
        for (middle, axes), row in zip(boxes, rows, strict=True):
            for x in (-1, 0, 1):
                for y in (-1, 1):
                    theta, v = middle + axes @ np.array([x, y])
                    lands = landing(cam, follower, omega, theta, v)
                    for covered in row["covers"].split(":"):
                        other, its_axes = boxes[int(covered) - 1]
                        off = np.linalg.solve(its_axes, lands - other)
                        assert abs(off[1]) < 1
                        assert x == 0 or abs(off[0]) > 1
                        if (x, y) == (-1, -1):
                            side = np.sign(off[0])
                        assert x == 0 or np.sign(off[0]) == -x * side


def box_of(row) -> tuple[np.ndarray, np.ndarray]:
    """(middle, axes) of a row, in rad and m/s."""
    names = ("theta_deg", "u_plus_m_per_s")
    middle, along, across = (
        np.array([float(row[prefix + name]) for name in names])
        for prefix in ("", "along_", "across_")
    )
    to_rad = np.array([np.pi / 180, 1.0])
    return middle * to_rad, np.column_stack([along * to_rad, across * to_rad])


def landing(cam, follower, omega, theta, v) -> np.ndarray:
    """(phase in rad, rebound m/s) of the first contact after an impact at theta with rebound v."""
    psi = mpf(float(theta))
    c, c1, _ = cam.laws(psi)
    flight = Flight(cam, follower, omega, psi, c, omega * c1 + mpf(float(v)))
    hit = flight.first_contact(4 * mp.pi / omega, True)
    return np.array([float(mp.fmod(psi + omega * hit.t, 2 * mp.pi)), float(-mpf("0.8") * hit.g1)])


def changed(content, change):
    """The certificate with its statement changed."""
    new = deepcopy(content)
    change(new["statements"][0])
    return new


def shift(number: str, by: float) -> str:
    """A number moved."""
    return repr(float(number) + by)


def widen(one):
    one["low"], one["high"] = "744", "746"


def move(one, box, place, by):
    one["boxes"][box]["middle"][place] = shift(one["boxes"][box]["middle"][place], by)


def shrink(one, box, entry, factor):
    axes = one["boxes"][box]["axes"]
    axes[entry] = repr(float(axes[entry]) * factor)


def twice(one):
    """The first box once more, with all that it covers, and is covered by."""
    one["boxes"].append(deepcopy(one["boxes"][0]))
    one["weights"].append(one["weights"][0])
    one["coverings"] += [[0, 5], [5, 0], [5, 5], [5, 1]]


def later(one):
    """Flights of a cell that land before the phases given, some of them."""
    flight = one["boxes"][2]["flights"][3]
    low, high = float(flight["low"]), float(flight["high"])
    flight["low"] = repr(low + 0.4 * (high - low))


CHANGES = {
    "a thinner box": lambda one: (shrink(one, 3, 1, 0.5), shrink(one, 3, 3, 0.5)),
    "a box that stands there twice": twice,
    "landings left out": later,
    "a box shifted along the cam": lambda one: move(one, 2, 0, 2e-3),
    "a box that lets go faster": lambda one: move(one, 3, 1, 3e-3),
    "a covering added": lambda one: one["coverings"].append([2, 0]),
    "a covering twice": lambda one: one["coverings"].append(one["coverings"][0]),
    "a covering left out": lambda one: one["coverings"].pop(),
    "a larger growth": lambda one: one.update(growth="1.3248"),
    "a growth beyond all doubles": lambda one: one.update(growth="1e999"),
    "no growth": lambda one: one.update(growth="1"),
    "a weight below zero": lambda one: one["weights"].__setitem__(1, "-1"),
    "no weights": lambda one: one.update(weights=["0"] * len(one["weights"])),
    "a smaller restitution": lambda one: one["constants"].update(restitution="0.79"),
    "a heavier follower": lambda one: one["constants"].update(mass="1.25"),
    "many speeds": widen,
    "the ends exchanged": lambda one: one.update(low=one["high"], high=one["low"]),
    "a wider box": lambda one: shrink(one, 1, 1, 1.3),
    "a longer box": lambda one: (shrink(one, 4, 0, 0.8), shrink(one, 4, 2, 0.8)),
    "a flat box": lambda one: one["boxes"][1].update(axes=["0.1", "0.1", "0.1", "0.1"]),
    "two boxes at one place": lambda one: one["boxes"].__setitem__(1, one["boxes"][0]),
    "a box on another stretch": lambda one: one["boxes"][3].update(stretch=2),
    "flights that land elsewhere": lambda one: one["boxes"][2]["lands"].update(stretch=2),
    "flights of two turns": lambda one: one["boxes"][2]["lands"].update(turn=2),
    "a cell without its flights": lambda one: one["boxes"][2]["flights"].pop(),
    "fewer cells": lambda one: one["boxes"][0].update(cells=[1, 1], flights=[
        one["boxes"][0]["flights"][0]]),
    "other landings": lambda one: one["boxes"][2]["flights"][3].update(low="2.0", high="2.1"),
    "no cuts": lambda one: [p.update(cuts=[]) for p in one["boxes"][2]["flights"][3]["passages"]],
}  # fmt: skip

WHY = {
    "a thinner box": "box 3 may be mapped beside box 4",
    "a box that stands there twice": "boxes 1 and 6 may overlap",
    "landings left out": "a flight may not land between the phases that are given",
    "a box shifted along the cam": "box 2 may be mapped beside box 3",
    "a box that lets go faster": "box 3 may be mapped beside box 4",
    "a covering added": "a flight lands on another box",
    "a covering twice": "its coverings are no pairs of boxes",
    "a covering left out": "the number of sequences may grow more slowly",
    "a larger growth": "the number of sequences may grow more slowly",
    "a growth beyond all doubles": "the number of sequences may grow more slowly",
    "no growth": "the number of sequences does not grow",
    "a weight below zero": "it has not its weights",
    "no weights": "it has not its weights",
    "a smaller restitution": "box 1 may be mapped beside box 2",
    "a heavier follower": "flight 1 may meet the cam on its way",
    "many speeds": "a flight may not land between the phases that are given",
    "the ends exchanged": "its range is empty",
    "a wider box": "a flight may not land between the phases that are given",
    "a longer box": "an end of box 5 may be mapped into box 1",
    "a flat box": "box 2 is flat",
    "two boxes at one place": "boxes 1 and 2 may overlap",
    "a box on another stretch": "a flight lands on another box",
    "flights that land elsewhere": "a flight lands on another box",
    "flights of two turns": "flight 1 does not pass stretch after stretch from impact to impact",
    "a cell without its flights": "not every cell of a box has its flights",
    "fewer cells": "flight 1 may meet the cam on its way",
    "other landings": "a flight may begin or land outside its stretch of the cam",
    "no cuts": "flight 1 does not rise first and fall last",
}


@pytest.mark.ci
@pytest.mark.parametrize("name", CHANGES)
def test_a_changed_certificate_is_refused(name, proof, checked):
    code, text = checked(changed(proof[2], CHANGES[name]))
    assert code == 1, text
    assert text.startswith("not confirmed: chaos ")
    assert reasons(text) == [WHY[name]]


def box(**more):
    """A box that leans: x runs along (1, 1), y along (-1, 1)."""
    axes = ((0.02, -0.01), (0.02, 0.01))
    own = {"stretch": 3, "middle": (2.0, 0.5), "axes": axes, "lands": Lands(3, 0, 1.9, 2.1)}
    return SectionBox(**{**own, **more})


@pytest.mark.parametrize(("map_of", "stretch", "covers"), [
    (lambda x, y: (1.5 * x, 0.5 * y), 3, True),
    (lambda x, y: (-1.5 * x, 0.5 * y), 3, True),  # turned round
    (lambda x, y: (1.5 * x + 0.4, 0.5 * y + 0.4), 3, True),
    (lambda x, y: (1.5 * x, 0.5 * y), 2, False),  # on another stretch
    (lambda x, y: (1.5 * x, 0.5 * y), None, False),  # on several
    (lambda x, y: (0.9 * x, 0.5 * y), 3, False),
    (lambda x, y: (1.5 * x + 0.6, 0.5 * y), 3, False),  # one end lies inside
    (lambda x, y: (1.5 * x, 0.5 * y + 0.6), 3, False),  # it sticks out above
    (lambda x, y: (1.5 * x, 0.5 * y - 0.6), 3, False),
    (lambda x, y: (1.5 * y, 0.5 * x), 3, False),  # along the wrong side
    (lambda x, y: (3.0 * x * x - 1.5, 0.5 * y), 3, False),  # both ends on one side
])  # fmt: skip
def test_a_box_covers_another_as_the_theorem_says(map_of, stretch, covers):
    """The image of one box in the coordinates of the other is given."""
    one, other = box(), box(middle=(2.5, 0.4), axes=((0.03, 0.01), (-0.03, 0.01)))
    (a, b), (c, d) = one.axes
    det = a * d - b * c

    def image(points):
        if stretch is None:
            return None
        theta, v = points[0] - one.middle[0], points[1] - one.middle[1]
        x, y = map_of((d * theta - b * v) / det, (a * v - c * theta) / det)
        (p, q), (r, s) = other.axes
        there = np.array([other.middle[0] + p * x + q * y, other.middle[1] + r * x + s * y])
        return homoclinic.LandedPoints(there, stretch, 0)

    assert homoclinic._covers(SimpleNamespace(image=image), one, other) == covers


@pytest.fixture
def without_proof(monkeypatch):
    """Chaos is not sought: the speed at which it would be is all that is looked at."""
    from camcli.analysis.chaos import study

    monkeypatch.setattr(study, "candidates", lambda *_: ())


@pytest.mark.parametrize("values", [
    {"run.rpm": 745.0}, {"orbits.at": 745.0}, {"orbits.rpm.start": 745.0, "orbits.rpm.stop": 745.0},
])  # fmt: skip
def test_chaos_is_sought_at_the_one_speed_that_a_scene_states(values, without_proof):
    import camcli

    result = camcli.orbits(camcli.load_scene(None, {"orbits.starts": 0, **values}), chaos=True)
    assert result.values.chaos.rpm == 745.0
    assert not result.values.branches


def test_a_speed_may_be_an_argument_and_an_oscillator_has_its_own(without_proof):
    """Its speed is 30 frequency/pi turns per minute."""
    import camcli

    fast = camcli.load_scene(None, {"orbits.starts": 0})
    assert camcli.orbits(fast, at=745.0, chaos=True).values.chaos.rpm == 745.0
    found = camcli.orbits(fast, at=745.0, all=(1, 1)).values
    assert (found.question.rpm, found.question.all_of) == (745.0, (1, 1))
    cam = {"kind": "oscillator", "damping": 0.1, "frequency": 2.8, "clearance": -1}
    machine = {"cam": cam, "follower": {"restitution": 0.8}}
    scene = camcli.load_scene(machine, {"orbits.starts": 0})
    own = 30 * 2.8 / np.pi
    assert camcli.orbits(scene, chaos=True).values.chaos.rpm == pytest.approx(own, rel=1e-14)
    with pytest.raises(camcli.SceneError, match="frequency of the oscillator"):
        camcli.orbits(scene, at=700.0, chaos=True)
    with pytest.raises(camcli.SceneError, match=r"two numbers \(impacts, turns\)"):
        camcli.orbits(scene, all=3)


def test_chaos_that_is_not_proved_is_incomplete(without_proof):
    """What is incomplete ends with exit code 3."""
    import camcli

    scene = camcli.load_scene(None, {"orbits.starts": 0})
    result = camcli.orbits(scene, at=745.0, chaos=True)
    assert not result.complete
    assert any("it is not proved that there is chaos: no boxes" in one for one in result.notes)
    assert not result.files
