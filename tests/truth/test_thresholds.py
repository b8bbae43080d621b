"""Every threshold of a warning, a refusal or a name: a case just within it, and one just beyond.

A row is a function that tells whether something is said of a number, and the two numbers. The
thresholds are written here once more, where they follow from something by the formula.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from contextlib import nullcontext
from io import BytesIO, TextIOWrapper
from math import cos, inf, nextafter, pi, sqrt
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
import pytest

import camcli
from camcli.analysis import border_collision
from camcli.analysis.basins.measures import uncertainty
from camcli.analysis.basins.window import Window
from camcli.analysis.border_collision import Side
from camcli.analysis.classify import _chatter
from camcli.analysis.contact_loss.detachment import detachment
from camcli.analysis.contact_loss.hold import hold_to
from camcli.analysis.explain.attractor import CarriedAttractor
from camcli.analysis.explain.changes import changes_between
from camcli.analysis.exponents import of_record
from camcli.analysis.integrate import Orbit
from camcli.analysis.labels import Label, label
from camcli.analysis.throw import throw
from camcli.api.machine import machine_of
from camcli.api.orbit_tables import read_branches
from camcli.errors import SceneError
from camcli.kernel.orbit_loop import IMPACT
from camcli.kernel.returns import find_return
from camcli.system import units_of
from camcli.words.detach import plainly
from camcli.words.machine import doubts, height_notes
from tests.conftest import cam_in, settings
from tests.support.strobes import strobe_of

CONFIGS = Path(__file__).parents[2] / "configs"
RPM = 30.0 / pi  # per rad/s
SLIGHTLY = 1e-9  # relative


class Threshold(NamedTuple):
    """says(x): whether it is said; it is not of `within`, it is of `beyond`."""

    name: str
    says: Callable[[Any], bool]
    within: Any
    beyond: Any


def around(
    name: str, says: Callable[[float], bool], value: float, upward: bool = True,
    by: float = SLIGHTLY,
):  # fmt: skip
    """A threshold with a number a little below and one a little above it, relative."""
    low, high = value * (1.0 - by), value * (1.0 + by)
    return Threshold(name, says, *((low, high) if upward else (high, low)))


def at(name: str, says: Callable[[float], bool], value: float, way: float):
    """A threshold that itself is within; way: inf or -inf, on which side it is said."""
    return Threshold(name, says, value, nextafter(value, way))


# -- a machine that is doubted ------------------------------------------------------------------

FOLLOWER = {"mass": 0.25, "stiffness": 40_000.0, "preload": 300.0, "restitution": 0.5}
LOBE = {  # c = base + h/2 (1 - cos phi), phi = (theta - 110 deg) 180/70
    "kind": "law", "base": 0.002, "lift": 0.010,
    "rise": {"start_deg": 110, "length_deg": 70, "law": "harmonic"},
    "fall": {"length_deg": 70, "law": "harmonic"},
}  # fmt: skip
RATE, ENDS = 180.0 / 70.0, 0.012  # d phi/d theta; highest c, m
PRESENT = 40_000.0 * ENDS + 300.0  # N at the nose
NOSE = 0.005 * RATE**2  # -c_thetatheta at the nose, m/rad2
ROUND = {"kind": "eccentric", "base": 0.0, "lift": 0.02}
SPEED = sqrt((40_000.0 * ENDS + 300.0) / (0.25 * NOSE)) * RPM  # contact is lost at the nose
ARCS = camcli.load_scene().cam.model_dump()
ARCS_TOP = ARCS["nose_center"] + ARCS["nose_radius"] - ARCS["offset"]


def made(cam: dict[str, Any] = LOBE, changes: dict[str, Any] | None = None, **follower: float):
    """A scene of a follower on a cam."""
    return camcli.load_scene({"follower": {**FOLLOWER, **follower}, "cam": cam}, changes or {})


def doubted(words: str, scene: Any) -> bool:
    return any(words in text for text in doubts(scene))


def solid(cam: dict[str, Any]) -> Callable[[float], bool]:
    words = "the spring is solid at"
    return lambda q: doubted(words, made(cam, {"spring.solid_at": q}))


def resized(cam: dict[str, Any], **keys: float) -> dict[str, Any]:
    return {**cam, **keys}


def dissipates_nothing(tmp_path, **follower: float) -> bool:
    words = " ".join(f"--set follower.{key}={value!r}" for key, value in follower.items())
    short = "--no-plot --set run.transient=0 --set run.record=1"
    return "nothing dissipates" in cam_in(tmp_path, f"simulate {short} {words}", code=0).stderr


def thrown(rpm: float, **follower: float) -> bool:
    system = machine_of(made(ROUND, preload=0.0, stiffness=0.0, **follower)).system
    return bool(height_notes(throw(system, rpm)))


def undercut(radius: float) -> bool:
    notes = camcli.simulate(made(), profile_only=True, base_radius=radius).notes
    return any("undercuts" in note for note in notes)


MACHINES = [
    at("lift of a light follower", lambda x: doubted("a lift of", made(resized(ROUND, lift=x))),
       0.1, inf),
    at("mass at a large lift",
       lambda m: doubted("a lift of", made(resized(ROUND, lift=0.2), mass=m)), 1.0, -inf),
    at("base radius", lambda r: doubted(
        "a base radius", made({**ARCS, "base_radius": r, "flank_radius": r + 0.45,
                               "nose_center": r + 0.1})), 1.0, inf),
    at("preload", lambda f: doubted("pulls the follower off", made(preload=f)), 0.0, -inf),
    around("solid below the top of a lobe", solid(LOBE), ENDS, upward=False),
    around("solid below the top of an eccentric", solid(ROUND), 0.02, upward=False),
    around("solid below the top of arcs", solid(ARCS), ARCS_TOP, upward=False),
    # v^2/(2 g) = 1000 lift with v = omega lift/2, and m v/b where a damper alone stops it
    around("height against weight", lambda rpm: thrown(rpm, gravity=9.81),
           sqrt(2.0 * 9.81 * 1000.0 * 0.02) / 0.01 * RPM),
    around("height against a damper", lambda rpm: thrown(rpm, gravity=1e-9, damping=0.1),
           1000.0 * 0.02 * 0.1 / 0.25 / 0.01 * RPM),
    # rho = r_b + c - base + c_thetatheta, least at the nose: r_b + h - NOSE
    around("undercut", undercut, NOSE - 0.010, upward=False),
    Threshold("lengths in m", lambda x: units_of(
        machine_of(made(resized(ROUND, lift=x))).system).length == "m", 0.099, 0.101),
    around("stiffness beside a preload", lambda k: doubted(
        "; is it in N/m?", made(stiffness=k)), 300.0 * 0.01 / 0.010, upward=False),
    Threshold("no stiffness", lambda k: doubted("; is it in N/m?", made(stiffness=k)), 0.0, 1e-3),
    around("mass beside a spring", lambda m: doubted("weighs more than", made(mass=m)),
           PRESENT / 9.81),
    at("a mass that is not large", lambda m: doubted(
        "weighs more than", made(mass=m, stiffness=1.0, preload=0.0)), 1.0, inf),
    around("spring heavier than what it moves", lambda m: doubted(
        "heavier than the 0.25 kg", made(changes={"spring.mass": m})), 0.25),
    at("contact width", lambda w: doubted("a contact width of", made(changes={
        "contact.width": w, "contact.base_radius": 0.017})), 0.5, inf),
    at("mass under arcs", lambda m: doubted("a lift of 153.9 mm", made(ARCS, mass=m)), 1.0, -inf),
]  # fmt: skip


@pytest.mark.parametrize("row", MACHINES, ids=[row.name for row in MACHINES])
def test_doubts(row):
    assert not row.says(row.within)
    assert row.says(row.beyond)


def test_the_mass_that_moves_is_told_with_its_third_of_the_spring():
    told = "note: moving mass: 0.25 + 0.02 kg, a third of the spring"
    assert told in doubts(made(changes={"spring.mass": 0.06}))
    held = made(changes={"spring.mass": 0.06, "spring.in_follower": True}, mass=0.27)
    assert told in doubts(held)
    assert not doubted("moving mass", made())


def test_a_speed_of_the_crank_is_doubted(tmp_path):
    rows = "".join(f"{2 * k},{10.0 * max(0.0, cos(pi * (k - 180) / 140)) ** 4:.4f}\n"
                   for k in range(110, 251))  # fmt: skip
    (tmp_path / "lift.csv").write_text(rows)
    cam = {"kind": "table", "file": "lift.csv", "header": 0, "angle_column": 1, "lift_column": 2,
           "angle": "crank", "lift": "mm", "zero_deg": 0, "direction": "same",
           "base": 0}  # fmt: skip
    (tmp_path / "scene.yaml").write_text(json.dumps({"follower": FOLLOWER, "cam": cam}))
    for asked, said in ((2000.0, True), (nextafter(2000.0, inf), False), (1000.0, False)):
        values = {"run.rpm": 1000.0, "detach.hold_to": asked}
        scene = camcli.load_scene(tmp_path / "scene.yaml", values)
        twice = "2000 rpm of the cam (4000 of the crank), twice run.rpm: was the crank meant?"
        assert doubted(twice, scene) == said
        scene.cam.__dict__["angle"] = "cam"
        assert not doubted("was the crank meant", scene)


def test_nothing_dissipates(tmp_path):
    assert dissipates_nothing(tmp_path, restitution=1.0, damping=0.0)
    assert not dissipates_nothing(tmp_path, restitution=nextafter(1.0, 0.0), damping=0.0)
    assert not dissipates_nothing(tmp_path, restitution=1.0, damping=1e-300)


# -- springs, and what is said of contact --------------------------------------------------------

SHORT = {"detach.settle": 0, "detach.impacts": 0, "detach.margin_n": 0.0}
KINDS = ("hold_stiffness", "hold_preload", "hold_both")


def speed_of(force: float) -> float:
    """The rpm at which so many N are needed at the nose: m omega^2 NOSE."""
    return sqrt(force / (0.25 * NOSE)) * RPM


def springs(rpm: float, changes: dict[str, Any] | None = None, **follower: float) -> list[Any]:
    """What holds up to a speed, in the order of KINDS."""
    machine = machine_of(made(changes=changes, **follower))
    f, solid = machine.system.follower, machine.scene.spring
    reach = f.preload / f.stiffness
    return hold_to(machine.system, rpm, 0.0, reach, solid=solid.solid_at if solid else inf)


def answers(rpm: float, hold: float | None = None) -> str:
    """All that `detach` says of a speed."""
    asked = {"detach.rpm": {"start": rpm, "stop": rpm, "num": 1}, "detach.hold_to": hold}
    found = camcli.detach(made(changes={**SHORT, **asked}))
    return " ".join([*found.verdict, *plainly(found.values)])


def lost_at_standstill(preload: float) -> bool:
    return bool(detachment(machine_of(made(preload=preload)).system).always)


def impossible(reach: float) -> bool:
    """Of a spring without preload of its own, on a lobe whose base is 2 mm below zero."""
    system = machine_of(made(resized(LOBE, base=-0.002))).system
    return hold_to(system, 2000.0, 1.0, reach)[2].status == "impossible"


SPRINGS = [
    *(around(f"absurd {kind}", lambda rpm, k=k: springs(rpm)[k].status == "absurd",
             speed_of(20.0 * PRESENT)) for k, kind in enumerate(KINDS)),
    *(around(f"more than the present {kind}", lambda rpm, k=k: springs(rpm)[k].more, SPEED)
      for k, kind in enumerate(KINDS[:2])),
    around("a preload is needed", lambda rpm: springs(rpm)[1].status == "ok",
           speed_of(40_000.0 * ENDS)),
    around("a stiffness is needed", lambda rpm: springs(rpm)[0].status == "ok", speed_of(300.0)),
    # more preload by F brings the nose F/k nearer to the height at which the spring is solid
    around("solid", lambda q: springs(SPEED * 1.1, {"spring.solid_at": q})[1].status
           == "impossible", ENDS + 0.21 * PRESENT / 40_000.0, upward=False),
    around("precompression", impossible, 0.002, upward=False),
    around("lost at standstill", lost_at_standstill, -80.0),  # k c + F0 = 0 on the base
    around("the present spring does not hold", lambda rpm: "To hold up to" in
           answers(2000.0, rpm), SPEED),
    around("not held at the speed asked for", lambda rpm: "contact is held at every" not in
           answers(rpm), SPEED, by=1e-4),
    around("lost at the speed asked for", lambda rpm: "contact is lost at every speed asked for" in
           answers(rpm), SPEED, by=1e-4),
]  # fmt: skip


@pytest.mark.parametrize("row", SPRINGS, ids=[row.name for row in SPRINGS])
def test_springs(row):
    assert not row.says(row.within)
    assert row.says(row.beyond)


def test_springs_have_room_for_the_error_of_a_measured_cam():
    """c_thetatheta at the nose may be lower by the error of either part of the turn beside it."""
    system = machine_of(made(gravity=9.81)).system
    needed = 0.25 * (400.0**2 * (NOSE + 0.003) - 9.81)
    wanted = ((needed - 300.0) / ENDS, needed - 40_000.0 * ENDS, needed / (ENDS + 0.02))
    for errors in ((0.0, 0.001, 0.003, 0.0), (0.0, 0.003, 0.001, 0.0)):
        found = hold_to(system, 400.0 * RPM, 0.0, 0.02, errors)
        values = (found[0].stiffness, found[1].preload, found[2].stiffness)
        assert values == pytest.approx(wanted, rel=1e-9)


def test_another_spring_has_half_of_the_lift_for_its_preload_where_there_is_none():
    asked = {**SHORT, "detach.hold_to": 4000.0}
    for base in (0.002, -0.004):
        scene = made(resized(LOBE, base=base), {**asked, "detach.rpm.num": 1}, preload=0.0)
        spring = camcli.detach(scene).values.holds[2]
        assert spring.preload / spring.stiffness == pytest.approx(0.005 + max(0.0, -base))


# -- files, forms and names ----------------------------------------------------------------------


@pytest.mark.parametrize("piped", [False, True], ids=["file", "stdin"])
def test_a_scene_has_so_many_bytes(tmp_path, monkeypatch, piped):
    """One that is longer is refused, and not read up to there."""
    name = "-" if piped else "scene.yaml"
    scene = (CONFIGS / "chapter.yaml").read_bytes().replace(b"rpm: 700", b"rpm: 650")
    for more, code in ((0, 0), (1, 2)):
        text = b"#" * (256_000 - 1 - len(scene) + more) + b"\n" + scene
        (tmp_path / "scene.yaml").write_bytes(text)
        if piped:
            monkeypatch.setattr("sys.stdin", TextIOWrapper(BytesIO(text)))
        done = cam_in(tmp_path, f"simulate --profile-only --no-plot -c {name}", code=code)
        assert ("found more than 256 kB, expected at most 256 kB" in done.stderr) == bool(more)
        assert ("650 rpm" in done.stdout) != bool(more)


def refused(cam: dict[str, Any], words: str) -> bool:
    """Whether a cam is refused with such words."""
    try:
        made(cam)
    except SceneError as error:
        return words in str(error)
    return False


def motions(lobe: float, width: float = 0.25) -> dict[str, Any]:
    """A cam of two motions and a dwell between that take so many degrees."""
    law = {"scca": {"b": width, "c": 0.5, "d": 0.25}}
    return {**LOBE, "rise": {**LOBE["rise"], "length_deg": lobe - 200.0, "law": law},
            "top_dwell_deg": 100.0, "fall": {**LOBE["fall"], "length_deg": 100.0}}  # fmt: skip


FORMS = [
    *(around(f"a flank circle {way:+}", lambda by, w=way: refused(
        {**ARCS, "flank_radius": 0.85 * (1.0 + w * by)}, "misses the base circle"), 1e-9, by=1e-3)
      for way in (-1, 1)),
    around("a turn", lambda lobe: refused(motions(lobe), "too much"), 360.0 + 1e-9, by=1e-12),
    *(around(f"a law {way:+}", lambda by, w=way: refused(
        motions(300.0, 0.25 + w * by), "the sum must be 1"), 1e-9, by=1e-3) for way in (-1, 1)),
]  # fmt: skip


@pytest.mark.parametrize("row", FORMS, ids=[row.name for row in FORMS])
def test_forms(row):
    assert not row.says(row.within)
    assert row.says(row.beyond)


def test_so_many_lines_are_drawn_over_a_picture(tmp_path):
    for count, taken in ((5000, True), (5001, False)):
        rows = [f"{k},{650 + k / 100},1,100,0.1" for k in range(count)]
        path = tmp_path / "branch.csv"
        path.write_text("branch,rpm,stable,theta_deg_1,q_m\n" + "\n".join(rows) + "\n")
        if taken:
            assert len(read_branches(path, "rpm")) == count
        else:
            with pytest.raises(SceneError, match="more than 5000 lines"):
                read_branches(path, "rpm")


@pytest.mark.parametrize(
    ("head", "first", "wanted"),
    [
        ("branch,rpm,stable,theta_deg_1,theta_deg_2,q_m", ["1,", "1,", "2,"], [2, 1]),
        ("rpm,stable,theta_deg_1,theta_deg_2,q_m", ["", "", ""], [3]),  # all are one
        ("rpm,stable,theta_deg,more,q_m", ["", "", ""], [3]),
    ],
)
def test_a_table_of_somebody_elses_branches_needs_four_columns(tmp_path, head, first, wanted):
    path = tmp_path / "branch.csv"
    rows = [f"{first[k]}{700 + k},{k % 2},{100 + k},{200 + k},{0.5 * k}" for k in range(3)]
    path.write_text("\n".join([head, *rows]) + "\n")
    found = read_branches(path, "rpm")
    assert [len(branch.values) for branch in found] == wanted
    assert [x for branch in found for x in branch.values] == [700.0, 701.0, 702.0]
    assert [x for branch in found for x in branch.stable] == [False, True, False]
    assert [x for branch in found for x in branch.q] == [0.0, 0.5, 1.0]
    phases = [[100.0, 101.0, 102.0], [200.0, 201.0, 202.0]][: 1 if "more" in head else 2]
    for k, wanted_phases in enumerate(phases):
        assert [x for branch in found for x in branch.phases[k]] == wanted_phases
    assert all(len(branch.phases) == len(phases) for branch in found)


@pytest.mark.parametrize(("turns", "known"), [(64, True), (65, False), (130, False)])
def test_a_label_has_at_most_64_turns(turns, known):
    """States that come back after so many turns, each with a number of impacts of its own."""
    q = [0.2 + 0.1 * (k % turns) / turns for k in range(4 * turns)]
    symbols = [float(k % turns % 7) for k in range(4 * turns)]
    strobe = strobe_of(q, [1.0] * len(q), symbols)
    assert find_return(strobe, len(q))[0] == (turns if known else 0)
    with nullcontext() if known else pytest.raises(ValueError, match="found"):
        assert len(Label.parse(f"P({turns};{':'.join(['1'] * turns)})").symbols) == turns


@pytest.mark.parametrize(
    ("impacts", "turns", "name"),
    [(15, 130, "undecided"), (16, 130, "aperiodic"), (16, 129, "undecided")],
)
def test_so_few_impacts_or_turns_do_not_make_a_motion_aperiodic(impacts, turns, name):
    """Twice the longest period that is looked for, and two turns."""
    record = SimpleNamespace(
        periods=turns, status=0, rests_throughout=False, hits=impacts, repeats=0
    )
    assert label(record) == name


def test_an_uncertainty_exponent_takes_ten_starts_at_three_errors():
    """Starts in doubt by a rule: within a share of the window from its middle line, or nowhere."""
    unit, wanted = Window((0.0, 1.0), (0.0, 1.0), 16, 16), {}

    class Counted:
        """So many starts in doubt at each error: asked in the order middle, then high and low."""

        def __init__(self, counts):
            self.counts, self.asked = counts, 0

        def settle(self, q, v):
            codes, pair = np.zeros(len(q), dtype=np.int16), (self.asked - 1) // 2
            if self.asked and self.asked % 2:
                codes[: self.counts[pair]] = 1
            self.asked += 1
            return codes, None

    for counts, known in (
        ([0, 0, 0, 0, 0, 10, 10, 10], True),
        ([0, 0, 0, 0, 0, 10, 10, 9], False),
        ([0, 0, 0, 0, 0, 0, 10, 10], False),
    ):
        assert (uncertainty(Counted(counts), unit) is not None) == known
    for first, fitted in ((250, True), (251, False)):  # of 1000: a quarter
        counts = [first, 128, 64, 32, 16, 0, 0, 0]
        wanted[fitted] = uncertainty(Counted(counts), unit, 1000).exponent
    assert wanted[False] == pytest.approx(1.0)  # 128 to 16 are halves of one another
    assert 0.9 < wanted[True] < 0.999


def test_chaos_of_a_normal_form_is_sure_by_three_errors_and_a_thousandth(monkeypatch):
    left, right = Side(1.7, 0.5), Side(-1.7, 0.5)
    for exponent, spread, kind in (
        (0.3 * (1 + 1e-9), 0.1, "chaos"), (0.3 * (1 - 1e-9), 0.1, "undecided"),
        (1e-3 * (1 + 1e-9), 1e-9, "chaos"), (1e-3 * (1 - 1e-9), 1e-9, "undecided"),
    ):  # fmt: skip
        measured = exponent, spread, (0.1, 0.1)
        monkeypatch.setattr(border_collision, "_exponent", lambda *_, found=measured: found)
        assert border_collision.attractor(left, right, 1).kind == kind


# -- what analyses take as rounding, or as another motion ----------------------------------------


def test_a_kink_below_a_nanometre_per_radian_is_rounding():
    """Up and down a ramp of 60 deg: at its top the slope drops by twice its own."""
    for slope, lost in ((1e-9 * (1 - 1e-6), False), (1e-9 * (1 + 1e-6), True)):
        lift = 0.5 * slope * pi / 3.0
        way = {"length_deg": 60, "law": "constant-velocity"}
        cam = {"kind": "law", "base": 0.0, "lift": lift, "rise": {**way, "start_deg": 90},
               "fall": way}  # fmt: skip
        always = detachment(machine_of(made(cam)).system).always
        assert bool(always) == lost


@pytest.mark.parametrize(("turns", "known"), [(79, False), (80, True)])
def test_an_exponent_takes_four_impacts_in_each_of_twenty_batches(turns, known):
    system = machine_of(camcli.load_scene()).system  # P(1;1): an impact a turn
    record = Orbit(system, 700.0, settings(300, turns)).run()
    assert len(record.kind) == turns
    assert (of_record(system, 700.0, record) is not None) == known


def test_sixteen_states_outside_the_box_have_left_it():
    carried = SimpleNamespace(box=(np.array([0.0, 0.0]), np.array([1.0, 1.0])))
    carried.outside = lambda states: CarriedAttractor.outside(carried, states)
    for count, left in ((15, False), (16, True)):
        q = np.array([0.5] * 100 + [1.5] * count)
        record = SimpleNamespace(strobe_q=q, strobe_w=np.full(len(q), 0.5))
        assert CarriedAttractor.has_left(carried, record) == left


def spread(width: float) -> SimpleNamespace:
    """A chaotic motion whose impacts are so many rad apart."""
    theta = np.linspace(1.0, 1.0 + width, 20)
    record = SimpleNamespace(kind=np.full(20, IMPACT), theta=theta, u=-theta, period=np.arange(20))
    return SimpleNamespace(label="aperiodic", chatter="none", record=record, period=0)


@pytest.mark.parametrize("narrow", [0.02, 0.4], ids=["by two degrees", "by a quarter"])
def test_chaos_of_another_size(narrow):
    """Wider by a quarter of it, and by two degrees."""
    least = max(1.25 * narrow, narrow + 2.0 * pi / 180.0)
    for wide, changed in ((least * (1 - 1e-9), False), (least * (1 + 1e-9), True)):
        assert changes_between(spread(narrow), spread(wide)) == changed


def test_eight_impacts_in_a_row_are_an_incomplete_chatter():
    """Each weaker than the one before it, after one that is not, wherever the record begins."""
    for number, kind in ((7, "none"), (8, "incomplete")):
        burst = [-2.0, *(-2.0 * 0.9**k for k in range(1, number + 1))]
        for rates in ([-1.0, *burst, -9.0], [*burst, -9.0], [-1.0, *burst], burst):
            kinds = np.full(len(rates), IMPACT)
            record = SimpleNamespace(chatter=np.zeros(1), periods=1, kind=kinds, u=np.array(rates))
            assert _chatter(record) == kind


@pytest.mark.parametrize(("stop", "warned"), [(700.0, False), (3000.0, True)])
def test_a_flight_that_is_absurdly_high_at_the_fastest_speed_of_a_range_is_told(stop, warned):
    """By its weight alone the follower rises v^2/(2 g), 1000 lifts with some 54 m/s."""
    values = {"follower.stiffness": 0.0, "follower.gravity": 9.81, "run.transient": 1,
              "run.record": 2, "sweep.rpm": {"start": 600.0, "stop": stop, "num": 2}}  # fmt: skip
    notes = camcli.sweep(camcli.load_scene(None, values)).notes
    assert any(f"at {stop:g} rpm the cam throws" in note for note in notes) == warned
