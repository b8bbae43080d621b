"""Machines of a scene at values of its numbers, and what every analysis gives, made by hand."""

from __future__ import annotations

from contextlib import nullcontext
from io import BytesIO
from math import degrees, pi, radians
from types import SimpleNamespace as Made

import pytest

import camcli
from camcli.analysis.integrate import Cost
from camcli.api import atlas, family, machine, orbit_question, result
from camcli.api.machine import Varied, _with_widths, leaves_speeds_open, machine_of
from camcli.cams.law import LawCam
from camcli.cams.oscillator import OscillatorCam
from camcli.errors import SceneError
from camcli.output.drawing_process import DrawnPicture
from camcli.scene import Axis, load_scene
from camcli.system import Follower

CONSTANTS = {"mass": 2.0, "stiffness": 300.0, "gravity": 9.81, "restitution": 0.5}
SCENE = {"follower": CONSTANTS, "cam": {"kind": "eccentric", "base": 0.0, "lift": 0.02}}


@pytest.mark.parametrize(
    ("strobe_deg", "strobe", "theta_deg", "theta"),
    [
        (0.0, 0.0, 370.5, radians(10.5)),
        (0.0, 0.0, -20.0, radians(340.0)),
        (40.0, radians(40.0), 400.0, radians(40.0)),
        # the strobe was moved onto a corner next to it: a start there begins on the corner
        (40.0, radians(40.0) + 1e-12, 40.0, radians(40.0) + 1e-12),
        (40.0, radians(40.0) + 1e-12, 41.0, radians(41.0)),
        (40.0, radians(50.0), degrees(radians(50.0) * (1.0 + 2e-16)), radians(50.0)),
    ],
)
def test_a_start_lies_in_one_turn_and_that_of_the_strobe_on_its_very_double(
    strobe_deg, strobe, theta_deg, theta
):
    scene = Made(run=Made(strobe_deg=strobe_deg))
    start = Made(q=0.25, v=-0.5, theta_deg=theta_deg)
    found = machine.start_of(scene, Made(strobe=strobe), start, "run.start")
    assert (found.q, found.v, found.place) == (0.25, -0.5, "run.start")
    if abs(theta - strobe) < 1e-9:
        assert found.theta == strobe
    else:
        assert found.theta == pytest.approx(theta, rel=1e-12)


def test_a_machine_at_values_of_its_numbers():
    """Of the cam, of the follower and the speed, in any order; what stays is the scene's."""
    scene = camcli.load_scene({**SCENE, "run": {"rpm": 333.0}})
    axes = [
        Axis(key="cam.lift", start=0.01, stop=0.05),
        Axis(key="follower.mass", start=1.0, stop=9.0),
    ]
    varied = Varied(machine_of(scene), axes)
    for lift, mass in ((0.02, 3.0), (0.03, 3.0), (0.03, 4.0), (0.02, 4.0), (0.02, 3.0)):
        system, rpm, _ = varied(lift, mass)
        low, high = system.lift_range
        assert (system.follower.mass, rpm) == (mass, 333.0)
        assert high - low == pytest.approx(lift)
        assert system.follower.stiffness == scene.follower.stiffness
    axes = [Axis(key="rpm", start=100.0, stop=900.0), Axis(key="run.patience", start=5, stop=9)]
    varied = Varied(machine_of(scene), axes)
    for asked, patience in ((450.0, 6), (460.0, 7)):
        _, rpm, settings = varied(asked, patience)
        assert (rpm, settings.patience) == (asked, patience)


def test_cams_that_were_used_last_are_kept(monkeypatch):
    """32 of them: the one that was not asked for the longest time goes."""
    monkeypatch.setattr(machine, "_on_cams", type(machine._on_cams)())
    built = []
    build = lambda follower, cam, strobe: built.append((cam.name, strobe)) or object()  # noqa: E731
    monkeypatch.setattr(machine, "System", Made(build=build))

    def ask(number, strobe=0.5):
        machine.on_cam(Made(name=number, model_dump_json=lambda: f"cam {number}"), strobe)

    for number in (*range(32), 0, 32, 0, 1):
        ask(number)
    assert [name for name, _ in built] == [*range(33), 1]
    for strobe in (-0.0, 0.0, -0.0):  # another strobe than 0.0
        ask(1, strobe)
    assert len(built) == 36


def test_settings_of_a_run_are_those_of_the_scene():
    run = {"transient": 3, "record": 5, "chatter_tolerance": 1e-7, "impact_budget": 777,
           "patience": 11, "start": {"q": 0.25, "v": -0.5, "theta_deg": 30.0}}  # fmt: skip
    found = machine_of({**SCENE, "run": run}).settings
    start = found.start
    for name in ("transient", "record", "chatter_tolerance", "impact_budget", "patience"):
        assert getattr(found, name) == run[name]
    assert (start.q, start.v, start.theta) == (0.25, -0.5, pytest.approx(pi / 6.0))


# --- what every analysis gives


def test_the_progress_of_the_budget_is_told_from_a_tenth_on(monkeypatch):
    given = {}

    def budgeted(budget, on_spent):
        given.update(budget=budget, on_spent=on_spent)
        return nullcontext()

    monkeypatch.setattr(result, "budgeted", budgeted)
    seen = []
    result.budget_of(Made(run=Made(work_budget=1000)), lambda *told: seen.append(told))
    for spent in (1, 100, 101, 999):
        given["on_spent"](spent, 1000)
    what = "of run.work_budget"
    assert (given["budget"], seen) == (1000, [(what, 101, 1000), (what, 999, 1000)])
    result.budget_of(Made(run=Made(work_budget=7)), None)
    given["on_spent"](7, 7)  # nobody watches


def test_each_piece_that_is_done_counts_one():
    seen = []
    tick = result.ticks(lambda *told: seen.append(told), "speeds", 3)
    tick()
    tick("anything", 2)
    assert seen == [("speeds", 1, 3), ("speeds", 2, 3)]
    tick()
    assert seen[-1] == ("speeds", 3, 3)
    result.ticks(None, "speeds", 3)()


def made(**more):
    own = {"command": "sweep", "scene": camcli.load_scene(None), "system": None, "values": None,
           "tables": {}, "summary": {}, "pictures": {}, "cost": Cost()}  # fmt: skip
    return result.Result(**{**own, **more})


class Rows:
    """Rows that two tables share, which write both at once."""

    def __init__(self, fails=False):
        self.fails, self.asked = fails, []

    def write_csv(self, tables, files):
        self.asked.append("csv")
        if self.fails:
            raise ArithmeticError
        for table, file in zip(tables, files, strict=True):
            file.write(table.name)

    def write_npz(self, tables, files):
        self.asked.append("npz")


class Folder:
    """A folder that lists its files in the order in which they are closed."""

    def __init__(self):
        self.files, self.order = {}, []

    def writing(self, name):
        folder = self

        class File(BytesIO):
            def close(self):
                folder.files[name] = self.getvalue()
                folder.order.append(name)
                super().close()

        return File()


@pytest.mark.parametrize(
    ("as_npz", "fails", "others", "names"),
    [
        (False, False, False, ["impacts", "strobe"]), (True, False, False, ["impacts", "strobe"]),
        (False, True, False, []), (False, False, True, []),
    ],
)  # fmt: skip
def test_tables_of_the_same_rows_are_written_in_one_reading(as_npz, fails, others, names):
    """The first table is closed first; where it fails, or the rows are not the same, none is."""
    rows = Rows(fails)
    second = Rows() if others else rows
    tables = {
        "impacts": Made(shared=(rows, 1), name=b"i"), "speeds": Made(shared=None, name=b"x"),
        "strobe": Made(shared=(second, 2), name=b"s"),
    }  # fmt: skip
    folder = Folder()
    assert made(tables=tables)._written_together(folder, as_npz) == names
    ending = "npz" if as_npz else "csv"
    assert rows.asked == ([] if others else [ending])
    if names:
        assert folder.order == [f"impacts.{ending}", f"strobe.{ending}"]
    if names and not as_npz:
        assert folder.files == {"impacts.csv": b"i", "strobe.csv": b"s"}
    alone = {"impacts": Made(shared=(rows, 1), name=b"i")}
    assert made(tables=alone)._written_together(folder, as_npz) == []


def test_a_picture_of_another_process_tells_what_it_left_out():
    whole = made()
    drawn = DrawnPicture(content=b"png", left_out=["force"], warnings=["of a font"])
    file = BytesIO()
    with pytest.warns(UserWarning, match="of a font"):
        whole._write_drawn("detach", drawn, file)
    assert (file.getvalue(), whole.left_out) == (b"png", {"detach": ["force"]})


# --- curves over a map, and families of machines


def axis(key, start, stop, num=5):
    return Axis(key=key, start=start, stop=stop, num=num)


def test_the_plane_of_a_map_has_ranges_that_rise_of_two_values_at_least():
    scene = camcli.load_scene(SCENE)
    speeds, mass = axis("rpm", 700.0, 600.0), axis("follower.mass", 3.0, 1.0)
    plane = atlas.plane_of(scene, (mass, speeds))
    assert (plane.names, plane.ranges) == (("mass", "rpm"), ((1.0, 3.0), (600.0, 700.0)))
    atlas.plane_of(scene, (axis("follower.mass", 1.0, 3.0, 2), speeds))
    for wrong in (axis("follower.mass", 1.0, 3.0, 1), axis("follower.mass", 2.0, 2.0)):
        for axes in ((wrong, speeds), (speeds, wrong)):
            with pytest.raises(SceneError, match="one value of follower"):
                atlas.plane_of(scene, axes)


@pytest.mark.parametrize("prove", [True, False])
def test_the_atlas_asks_for_what_the_scene_says(monkeypatch, prove):
    """Branches of the section orbits, turns of the proofs of the section sweep; proofs if asked."""
    asked = {}
    monkeypatch.setattr(atlas, "_machines", lambda *given: "machines")

    def add_curves(at, settings, found, branches, on_stage):
        asked.update(curves=(at, settings, found, branches))
        found.curves += ["one", "two"]
        on_stage()

    def prove_atlas(at, found, turns, on_curve):
        asked.update(proofs=(at, found, turns))
        on_curve()

    monkeypatch.setattr(atlas, "add_curves", add_curves)
    monkeypatch.setattr(atlas, "prove_atlas", prove_atlas)
    told = []
    budget = Made(status="lasted")
    monkeypatch.setattr(atlas, "budget_of", lambda scene, progress: nullcontext(budget))
    scene = Made(sweep=Made(prove=prove, prove_turns=6), orbits=Made(branches=9))
    machine = Made(scene=scene, settings="settings")
    found, status = atlas.atlas_of(machine, (), "plane", lambda *of: told.append(of))
    assert told == [("curves", 1, atlas.STAGES), *[("proofs", 1, 2)] * prove]
    assert (found.plane, status) == ("plane", "lasted")
    assert asked["curves"] == ("machines", "settings", found, 9)
    assert asked.get("proofs") == (("machines", found, 6) if prove else None)


def test_a_range_that_is_followed_holds_the_scene_s_value_up_to_its_ends():
    scene = camcli.load_scene(SCENE)
    for start, stop in ((0.01, 0.02), (0.02, 0.03), (0.03, 0.01)):
        family.check_followed(scene, axis("cam.lift", start, stop))
    for start, stop, said in ((0.021, 0.03, "holds cam.lift"), (0.02, 0.02, "two different ends")):
        with pytest.raises(SceneError, match=said):
            family.check_followed(scene, axis("cam.lift", start, stop))


def test_an_oscillator_makes_its_follower_and_its_speed(monkeypatch):
    """One turn of the cam is a period of the force: 4 pi rad/s are 120 rpm."""
    build = lambda follower, cam, strobe: (follower, cam, strobe)  # noqa: E731
    monkeypatch.setattr(family, "System", Made(build=build))
    own = Follower(9.0, 8.0, damping=7.0, restitution=0.6)
    base = Made(system=Made(follower=own), scene=Made(run=Made(rpm=333.0)))
    cam = OscillatorCam(kind="oscillator", mass=2.0, stiffness=300.0, damping=5.0,
                        frequency=4.0 * pi, clearance=3.0)  # fmt: skip
    (follower, *others), rpm = family._on(base, cam, 0.5)
    assert (others, rpm) == ([cam, 0.5], pytest.approx(120.0))
    assert follower == Follower(2.0, 300.0, damping=5.0, restitution=0.6)
    assert family._on(base, "another cam", 0.5) == ((own, "another cam", 0.5), 333.0)


def test_a_constant_without_a_range_has_one_about_its_value():
    """A tenth to either side, the lower end first; a restitution not beyond 1."""

    def ends(name, value, **orbits):
        own = Made(parameter="rpm", range=None, **orbits)
        scene = Made(orbits=own, follower=Made(**{name: value}), cam=Made(kind="eccentric"))
        found = orbit_question._constant(scene, name, "range", 7)
        assert (found.name, found.num, found.key) == (name, 7, "")
        return found.low, found.high

    assert ends("preload", -5.0) == pytest.approx((-5.5, -4.5))
    assert ends("mass", 2.0) == pytest.approx((1.8, 2.2))
    assert ends("restitution", 0.95) == (pytest.approx(0.855), 1.0)
    assert ends("damping", 20.0) == pytest.approx((18.0, 22.0))


def test_the_second_number_of_a_curve_has_as_many_values_as_the_first(monkeypatch):
    """`range` is its own where the first number is the speed, which has another one."""
    asked = []
    monkeypatch.setattr(orbit_question, "_constant", lambda *given: asked.append(given[1:]))
    scene = Made(orbits=Made(curve_in="mass", curve_range=None, rpm=Made(num=99)))
    for name, key in (("rpm", "range"), ("damping", "curve_range")):
        orbit_question._second_by_name(scene, Made(name=name, num=7))
        assert asked.pop() == ("mass", key, 7)
    scene.orbits.curve_range = (1.0, 2.0)
    orbit_question._second_by_name(scene, Made(name="rpm", num=7))
    assert asked.pop() == ("mass", "curve_range", 7)


@pytest.mark.parametrize(
    ("low", "high", "of_run", "asked", "speed"),
    [
        (600.0, 700.0, 650.0, {}, 650.0),
        (600.0, 700.0, 600.0, {}, 600.0),
        (600.0, 700.0, 800.0, {}, 650.0),  # the middle of the range
        (600.0, 700.0, 800.0, {"all": "all"}, 800.0),  # all orbits of one speed need no range
        (600.0, 700.0, 800.0, {"chaos": True}, 800.0),
        (600.0, 600.0, 800.0, {"all": "all"}, 600.0),
        (600.0, 700.0, 800.0, {"at": 620.0, "chaos": True}, 620.0),
    ],
)
def test_the_speed_at_which_orbits_are_looked_for(low, high, of_run, asked, speed):
    section = Made(**{"at": None, "chaos": False, "all": None, **asked})
    scene = Made(orbits=section, run=Made(rpm=of_run), cam=None)
    first = Made(name="rpm", key="", low=low, high=high)
    assert orbit_question._speed_of_orbits(scene, first) == speed
    if section.at is None:  # a number of the scene varies at the speed of the run
        first = Made(name="mass", key="follower.mass", low=low, high=high)
        assert orbit_question._speed_of_orbits(scene, first) == of_run


def test_a_constant_that_is_named_without_a_key_has_its_speed_from_the_range_of_speeds():
    section = Made(at=None, chaos=False, all=None, rpm=Made(start=700.0, stop=600.0, num=5))
    scene = Made(orbits=section, run=Made(rpm=800.0), cam=None)
    first = Made(name="mass", key="", low=1.0, high=2.0)
    assert orbit_question._speed_of_orbits(scene, first) == 650.0
    scene.run.rpm = 620.0
    assert orbit_question._speed_of_orbits(scene, first) == 620.0


def test_an_oscillator_has_the_speed_of_its_force_alone():
    cam = OscillatorCam(kind="oscillator", mass=2.0, stiffness=300.0, damping=5.0,
                        frequency=4.0 * pi, clearance=3.0)  # fmt: skip
    scene = Made(orbits=Made(at=120.0), run=Made(rpm=120.0), cam=cam)
    assert orbit_question._speed_of_orbits(scene, Made(name="rpm", key="")) == 120.0
    scene.orbits.at = 120.5
    with pytest.raises(SceneError, match="as the frequency of the oscillator says"):
        orbit_question._speed_of_orbits(scene, Made(name="rpm", key=""))
    scene.cam = None
    assert orbit_question._speed_of_orbits(scene, Made(name="rpm", key="")) == 120.5


def test_every_number_of_the_cam_is_looked_at_before_it_is_followed(monkeypatch):
    looked_at = []
    monkeypatch.setattr(
        orbit_question, "check_ends", lambda machine, axis: looked_at.append(axis.key)
    )
    monkeypatch.setattr(
        orbit_question, "in_family", lambda machine, axes: [one.key for one in axes]
    )
    numbers = [orbit_question.VariedNumber(name, 1.0, 2.0, 5, name)
               for name in ("cam.lift", "mass", "rpm", "cam.base")]  # fmt: skip
    wanted = ["cam.lift", "cam.base"]
    assert orbit_question.with_families("machine", numbers) == looked_at == wanted


@pytest.mark.parametrize(
    ("start", "stop", "of_run", "at", "refused"),
    [
        (672.0, 756.0, 100.0, None, False),  # the range that every scene has
        (672.0, 700.0, 100.0, None, True), (700.0, 756.0, 100.0, None, True),
        (672.0, 700.0, 680.0, None, False), (700.0, 700.0, 100.0, None, False),
        (672.0, 700.0, 100.0, 900.0, False),
    ],
)  # fmt: skip
def test_chaos_needs_one_speed(start, stop, of_run, at, refused):
    section = Made(vary=(), at=at, rpm=Made(start=start, stop=stop, num=3))
    scene = Made(orbits=section, run=Made(rpm=of_run))
    if not refused:
        orbit_question._check_chaos(scene, [Made(name="rpm")])
        return
    with pytest.raises(SceneError, match="found a range, expected one speed"):
        orbit_question._check_chaos(scene, [Made(name="rpm")])


@pytest.mark.parametrize(
    ("vary", "names"), [(("x",), ["rpm"]), ((), ["mass"]), ((), ["rpm", "mass"])]
)
def test_chaos_is_not_looked_for_while_a_number_varies(vary, names):
    section = Made(vary=vary, at=600.0, rpm=Made(start=600.0, stop=600.0, num=1))
    scene = Made(orbits=section, run=Made(rpm=600.0))
    orbit_question._check_chaos(Made(orbits=Made(**{**vars(section), "vary": ()}), run=scene.run),
                                [Made(name="rpm")])  # fmt: skip
    with pytest.raises(SceneError, match="found a number that varies"):
        orbit_question._check_chaos(scene, [Made(name=name) for name in names])


@pytest.mark.parametrize(
    ("given", "is_open"),
    [({}, True), ({"num": 7}, True), ({"start": 600.0}, False), ({"stop": 900.0}, False),
     ({"start": 600.0, "stop": 900.0}, False)],
)  # fmt: skip
def test_speeds_are_left_open_where_neither_end_is_given(given, is_open):
    eccentric = {"kind": "eccentric", "base": 0.1, "lift": 0.02}
    scene = load_scene({"follower": {"mass": 1.0, "stiffness": 9.0, "restitution": 0.5},
                        "cam": eccentric, "sweep": {"rpm": given}})  # fmt: skip
    assert leaves_speeds_open(scene, "sweep") is is_open


def test_of_widths_that_are_changed_together_each_stays():
    """One that is changed alone takes the others along, so that they add up to 1."""
    law = {"scca": {"b": 0.2, "c": 0.3, "d": 0.5}}
    cam = LawCam(kind="law", base=0.0, lift=0.01,
                 rise={"start_deg": 10.0, "length_deg": 90.0, "law": law},
                 fall={"length_deg": 80.0, "law": law})  # fmt: skip
    rise = "cam.rise.law.scca."
    alone = _with_widths(cam, {f"{rise}b": 0.25})
    assert sum(alone[rise + name] for name in "bcd") == pytest.approx(1.0)
    assert alone[f"{rise}b"] == 0.25
    assert not any(key.startswith("cam.fall") for key in alone)
    for changes in ({"b": 0.25, "c": 0.35}, {"b": 0.3, "c": 0.3, "d": 0.4}):
        given = {rise + name: value for name, value in changes.items()}
        assert _with_widths(cam, dict(given)) == given
