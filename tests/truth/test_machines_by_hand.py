"""Machines of a scene at values of its numbers, and what every analysis gives, made by hand."""

from __future__ import annotations

from contextlib import nullcontext
from io import BytesIO
from math import degrees, pi, radians
from types import SimpleNamespace as Made

import pytest

import camcli
from camcli.analysis.integrate import Cost
from camcli.api import machine, result
from camcli.api.machine import Varied, machine_of
from camcli.output.drawing_process import DrawnPicture
from camcli.scene import Axis

FOLLOWER = {"mass": 2.0, "stiffness": 300.0, "gravity": 9.81, "restitution": 0.5}
SCENE = {"follower": FOLLOWER, "cam": {"kind": "eccentric", "base": 0.0, "lift": 0.02}}


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
    monkeypatch.setattr(machine, "MOST_CAMS", 2)
    monkeypatch.setattr(machine, "_on_cams", type(machine._on_cams)())
    built = []
    build = lambda follower, cam, strobe: built.append((cam.name, strobe)) or object()  # noqa: E731
    monkeypatch.setattr(machine, "System", Made(build=build))
    cams = {name: Made(name=name, model_dump_json=lambda name=name: name) for name in "abc"}
    for name in "abacab":
        machine.on_cam(cams[name], 0.5)
    assert [name for name, _ in built] == ["a", "b", "c", "b"]
    machine.on_cam(cams["b"], -0.0)  # another strobe than 0.0
    machine.on_cam(cams["b"], 0.0)
    assert len(built) == 6


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
