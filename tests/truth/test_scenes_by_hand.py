"""What analyses take from a scene, its machine and its lift table, and rows that several share."""

from __future__ import annotations

import copy
import json
from io import BytesIO
from math import copysign, inf, isnan, nan
from types import SimpleNamespace as Made

import pytest

import camcli
from camcli.analysis.natural_speed import Basis, NaturalSpeed
from camcli.analysis.orbits.study import Kind
from camcli.api import explanation, family, lift_table, machine, proof_files, rows
from camcli.api.machine import Varied, closed, machine_of, with_arguments
from camcli.cams.arcs import ArcsCam
from camcli.errors import Fault, SceneError, Status
from camcli.scene import MORE_THAN_THE_LIFT, Axis

RPM = 600.0
CONSTANTS = {"mass": 2.0, "stiffness": 300.0, "gravity": 9.81, "restitution": 0.5}
ECCENTRIC = {"kind": "eccentric", "base": 0.0, "lift": 0.02}


def replaced(one, **more):
    return Made(**{**vars(one), **more})


# --- rows


@pytest.mark.parametrize(
    ("kind", "resting", "sides", "known"),
    [
        (Kind.FOLD, False, (None, None), "same"),
        (Kind.FOLD, True, (None, None), "left"),  # behind it there is another orbit
        (Kind.GRAZING, False, (None, None), "left"),
        (Kind.CORNER_IMPACT, False, (None, None), "left"),
        (Kind.CORNER_IMPACT, False, ("left", None), "left"),
        (Kind.CORNER_IMPACT, True, ("left", "right"), "both"),
    ],
)
def test_both_sides_of_an_event_are_told_where_they_are_known(kind, resting, sides, known):
    of_side = {"left": Made(trace=1.5, det=0.75), "right": Made(trace=-2.5, det=0.25)}
    left, right = (of_side.get(side) for side in sides)
    event = Made(branch=3, label="P(1;1)", kind=kind, error=1e-6, corner="b", value=0.5,
                 classification="class", left=left, right=right,
                 orbit=Made(trace=0.125, det=0.375, rpm=RPM, resting=resting))  # fmt: skip
    own = [0.125, 0.375]
    columns = {"same": [*own, *own], "left": [*own, None, None], "both": [1.5, 0.75, -2.5, 0.25]}
    start, end = [3, "P(1;1)", kind, RPM], ["b", *columns[known], "class"]
    assert rows.bifurcation_row(event, "rpm") == [*start, 1e-6, *end]
    assert rows.bifurcation_row(event, "mass") == [*start, 0.0, *end, 0.5, 1e-6]


@pytest.mark.parametrize("seat", [True, False])
def test_the_row_of_a_speed_has_its_columns_in_their_order(monkeypatch, seat):
    loads = list(rows.LOADS)
    monkeypatch.setattr(
        rows, "load_row", lambda loads: [f"{name} of {loads}" for name in rows.LOADS]
    )
    monkeypatch.setattr(
        rows, "seat_row", lambda loads: [f"{name} of {loads}" for name in rows.SEAT]
    )
    speed = Made(value=1.5, label="P(1;1)", impact_count=40, exponent=-0.5, exponent_error=0.25,
                 status=Status.NO_RETURN, loads="it", holds_for="last-digit",
                 watched=7)  # fmt: skip
    names = [*rows.SPEEDS.names("run.x"), *rows.seat_names(seat)]
    row = dict(zip(names, rows.speed_row(speed, seat), strict=True))
    assert [row.pop(name) for name in loads] == [f"{name} of it" for name in loads]
    assert [row.pop(name) for name in rows.seat_names(seat)] == [
        f"{name} of it" for name in rows.SEAT if seat
    ]
    assert row == {
        "run.x": 1.5, "label": "P(1;1)", "impacts": 40, "lyapunov_per_period": -0.5,
        "status": Status.NO_RETURN.text, "holds_for": "last-digit", "watched_turns": 7,
        "lyapunov_error_per_period": 0.25,
    }  # fmt: skip


def test_multipliers_are_four_numbers_without_a_minus_before_zero():
    pair = (complex(-0.0, 0.5), complex(0.25, -0.0))
    told = rows.multiplier_columns(pair)
    assert told == [0.0, 0.5, 0.25, 0.0]
    assert [copysign(1.0, part) for part in told] == [1.0] * 4


@pytest.mark.parametrize(
    ("lash", "keys", "seat"),
    [(None, (), False), (None, ("rpm", "cam.lift"), False), (None, ("rpm", "cam.lash"), True),
     (0.0, (), True), (0.001, ("rpm",), True)],
)  # fmt: skip
def test_a_follower_has_a_seat_where_the_cam_has_a_lash_or_may_have_one(lash, keys, seat):
    assert rows.has_seat(Made(cam=Made(lash=lash)), keys) is seat
    assert rows.has_seat(Made(cam=Made()), keys) is ("cam.lash" in keys)


# --- families


@pytest.mark.parametrize("end", ["start", "stop"])
def test_an_end_beyond_the_limits_of_its_own_key_is_refused(monkeypatch, end):
    """Not one at which other numbers fail, or at which the lash is more than the lift."""
    axis = Axis(key="cam.lift", start=0.01, stop=0.05)

    def fault(path, expected="expected less"):
        return Fault("", path, "found 0.05", expected, "")

    def loaded(changes):
        if changes == {"cam.lift": getattr(axis, end)}:
            raise SceneError(*faults)

    asked = []
    monkeypatch.setattr(
        family, "Varied", lambda *given, **more: asked.append((given, more)) or Made(loaded=loaded)
    )
    faults = [fault("cam.base"), fault("cam.lift"), fault("cam.lift", MORE_THAN_THE_LIFT)]
    with pytest.raises(SceneError) as caught:
        family.check_ends("machine", axis)
    assert list(caught.value.faults) == faults[1:2]
    assert asked == [(("machine", [axis], "orbits.vary"), {"whole": False})]
    del faults[1]
    family.check_ends("machine", axis)


def test_the_family_of_a_scene_has_rising_ranges_and_the_values_of_the_scene(monkeypatch):
    """A cam that tells itself that there is one needs no scene; why there is none is told."""
    axes = [Axis(key="cam.lift", start=0.05, stop=0.01), Axis(key="cam.base", start=-1.0, stop=1.0)]
    own = machine_of({"follower": CONSTANTS, "cam": ECCENTRIC, "run": {"strobe_deg": 90.0}})
    made = []

    def members(*given):
        made.append(given)
        return Made(home=Made(system="home"))

    refusal = SceneError(
        Fault("", "cam", "found a", "expected b", ""), Fault("", "x", "y", "z", "")
    )
    answers = {"cam": "a cam"}

    def varied(*values):
        if values == (9.0, 9.0):
            raise refusal
        return "system", RPM, "settings"

    monkeypatch.setattr(family, "Family", members)
    monkeypatch.setattr(family, "Varied", lambda *given, **more: varied)
    monkeypatch.setattr(family, "_changed", lambda cam, changes: answers["cam"] and (cam, changes))
    monkeypatch.setattr(family, "_on", lambda machine, cam, strobe: (machine, cam, strobe))
    assert family.in_family(own, axes) == "home"
    ((names, ranges, values, build),) = made
    assert names == ("cam.lift", "cam.base")
    assert ranges == ((0.01, 0.05), (-1.0, 1.0))
    assert values == (0.02, 0.0)
    changes = {"cam.lift": 0.03, "cam.base": 0.5}
    machine_, (cam, changed), strobe = build((0.03, 0.5))
    assert (machine_, cam, changed) == (own, own.scene.cam, changes)
    assert strobe == own.system.strobe
    answers["cam"] = None
    assert build((0.03, 0.5)) == ("system", RPM)
    with pytest.raises(family.NoMachineError, match=r"^found a, expected b$"):
        build((9.0, 9.0))
    assert family.in_family(own, []) is own.system


def test_a_changed_cam_is_made_anew_where_it_can_tell_that_there_is_one():
    """Closed as a scene's is; a lash has to be smaller than the lift, which the scene looks at."""
    arcs = machine_of(None).scene.cam
    base, centre = arcs.base_radius, arcs.flank_center
    cam = family._changed(arcs, {"cam.base_radius": base * 1.01})
    assert cam.base_radius == base * 1.01
    assert cam.flank_radius == pytest.approx(base * 1.01 + centre)
    assert cam.nose_radius == arcs.nose_radius
    assert family._changed(arcs, {"cam.base_radius": -1.0}) is None
    assert family._changed(arcs, {"cam.lash": 0.001}) is None
    law = camcli.load_scene("configs/valve-train.yaml").cam
    length = law.rise.length_deg - 0.5
    changed = family._changed(law, {"cam.rise.length_deg": length})
    assert (changed.rise.length_deg, changed.fall) == (length, law.fall)
    assert law.rise.length_deg == length + 0.5
    with_lash = law.model_copy(update={"lash": 0.001})
    assert family._changed(with_lash, {"cam.rise.length_deg": length}) is None


def test_a_number_that_the_cam_does_not_know_is_no_number_to_follow(monkeypatch):
    asked = []
    monkeypatch.setattr(
        family, "why_not_followed", lambda *given, **more: asked.append((given, more))
    )
    scene = camcli.load_scene({"follower": CONSTANTS, "cam": ECCENTRIC})
    family.why_not(scene, Axis(key="cam.lift", start=0.01, stop=0.05))
    family.why_not(scene, Axis(key="cam.lifft", start=0.01, stop=0.05))
    assert asked == [(("cam.lift", "eccentric", 0.02, True), {}),
                     (("cam.lifft", "eccentric", None, False), {})]  # fmt: skip


@pytest.mark.parametrize(
    ("cam", "seat"), [(Made(), False), (Made(lash=None), False), (Made(lash=0.0), True)]
)
def test_a_seat_restitution_is_followed_where_there_is_a_seat(monkeypatch, cam, seat):
    monkeypatch.setattr(family, "why_not_followed", lambda *given, **more: (given, more))
    cam.kind = "law"
    scene = Made(cam=cam, follower=Made(seat_restitution=0.25, mass=2.0))
    told = family.why_no_constant(scene, "seat_restitution")
    known = {"known": True}
    followed = (("follower.seat_restitution", "law", 0.25), known)
    assert told == (followed if seat else family.NO_SEAT)
    assert family.why_no_constant(scene, "mass") == (("follower.mass", "law", 2.0), known)


# --- machines


@pytest.mark.parametrize(
    ("changes", "more"),
    [
        ({"base_radius": 0.2}, {"flank_radius": 0.2 + 0.03}),
        ({"flank_center": 0.05}, {"flank_radius": 0.1 + 0.05}),
        ({"flank_radius": 0.25}, {"flank_center": 0.25 - 0.1}),
        ({"base_radius": 0.2, "flank_center": 0.05}, {}),
        ({"base_radius": 0.2, "flank_radius": 0.3}, {}),
        ({"base_radius": 0.2, "flank_center": 0.05, "flank_radius": 0.3}, {}),
        ({"nose_radius": 0.01}, {}),
    ],
)
def test_the_flank_of_a_cam_of_arcs_stays_closed(changes, more):
    cam = ArcsCam.model_construct(base_radius=0.1, flank_center=0.03, flank_radius=0.13)
    given = {f"cam.{name}": value for name, value in changes.items()}
    asked = dict(given)
    wanted = given | {f"cam.{name}": pytest.approx(value) for name, value in more.items()}
    assert closed(cam, asked) == wanted
    assert asked == given
    assert closed("another cam", asked) == given


@pytest.mark.parametrize(
    ("basis", "rpm", "of_sweep"),
    [(Basis.FIRST_LOSS, 700.0, (630.0, 1050.0)), (Basis.NATURAL, 700.0, (350.0, 1400.0)),
     (Basis.NATURAL, 0.0, None)],
)  # fmt: skip
def test_speeds_that_are_left_open_are_those_of_the_machine(monkeypatch, basis, rpm, of_sweep):
    """A section that varies another number is filled in, but nothing is told of it."""
    monkeypatch.setattr(machine, "natural_speed", lambda system: NaturalSpeed(rpm, basis))
    monkeypatch.setattr(machine, "_lift", lambda system: (0.5, 0.25))
    axis = {"key": "follower.mass", "start": 1.0, "stop": 2.0, "num": 3}
    scene = camcli.load_scene(
        {"follower": CONSTANTS, "cam": ECCENTRIC, "classify": {"vary": [axis]},
         "basins": {"q": [0.1, 0.9]}, "orbits": {"rpm": {"start": 100.0, "stop": 200.0}}}
    )  # fmt: skip
    filled, chosen = machine.ranged(scene, "system")
    if of_sweep is None:
        assert (filled, chosen) == (scene, {})
        return
    assert (filled.sweep.rpm.start, filled.sweep.rpm.stop) == of_sweep
    assert (filled.sweep.rpm.num, filled.orbits) == (scene.sweep.rpm.num, scene.orbits)
    assert list(chosen) == ["sweep", "detach", "basins"]
    assert (chosen["sweep"].low, chosen["sweep"].high, chosen["sweep"].by.rpm) == (*of_sweep, rpm)
    assert filled.classify.rpm.start == (700.0 if basis is Basis.FIRST_LOSS else 350.0)
    window = filled.basins
    assert (window.rpm.start, window.rpm.stop) == (735.0, 735.0)
    fastest = float(f"{4.0 * 0.25 * 735.0 * 3.14159265 / 30.0:.3g}")
    assert (window.q, window.v) == ((0.1, 0.9), (-fastest, fastest))
    assert (chosen["basins"].low, chosen["basins"].high) == (735.0, 735.0)


@pytest.mark.parametrize("varied", [True, False])
def test_basins_that_vary_another_number_have_the_speed_of_the_run(varied):
    natural = NaturalSpeed(700.0, Basis.FIRST_LOSS)
    scene = Made(run=Made(rpm=888.0, model_fields_set=set()), basins=Made(vary=("x",) * varied))
    found = machine._speed_of_basins(scene, natural)
    assert (found.low, found.high, found.by) == ((888.0, 888.0, None) if varied
                                                 else (735.0, 735.0, natural))  # fmt: skip
    scene.run.model_fields_set.add("rpm")
    assert machine._speed_of_basins(scene, natural).low == 888.0


def test_a_flat_cam_has_a_window_of_a_metre():
    assert machine._lift(Made(lift_range=(0.5, 0.5))) == (0.5, 1.0)
    assert machine._lift(Made(lift_range=(0.5, 0.75))) == (0.5, 0.25)
    q, v = machine._window_of_starts(Made(lift_range=(0.5, 0.75)), 300.0).values()
    assert q == (0.5, 1.25)
    assert v == (-31.4, 31.4)  # four lifts times 10 pi rad/s


def test_arguments_that_were_not_given_leave_the_scene_as_it_is():
    """0 is given, and so is what the section checks; None and False are not."""
    scene = camcli.load_scene(None, {"orbits.prove": True, "orbits.starts": 5})
    assert with_arguments(scene, "orbits", prove=False, at=None) is scene
    changed = with_arguments(scene, "orbits", prove=False, starts=0, at=700)
    assert (changed.orbits.prove, changed.orbits.starts, changed.orbits.at) == (True, 0, 700.0)
    assert isinstance(changed.orbits.at, float)
    for wrong in ("fast", 0.0):
        with pytest.raises(SceneError, match=r"orbits\.at"):
            with_arguments(scene, "orbits", at=wrong)


def test_a_strobe_a_hair_away_is_another_one(monkeypatch):
    built = []
    monkeypatch.setattr(machine, "_on_cams", type(machine._on_cams)())
    build = lambda follower, cam, strobe: built.append(strobe) or object()  # noqa: E731
    monkeypatch.setattr(machine, "System", Made(build=build))
    cam = Made(model_dump_json=lambda: "cam")
    for strobe in (0.5, 0.5 + 1e-15, 0.5):
        machine.on_cam(cam, strobe)
    assert built == [0.5, 0.5 + 1e-15]


def test_a_varied_machine_keeps_what_it_has_compiled(monkeypatch):
    """Up to 256 of them; the follower's system of one place is not that of another."""
    scene = camcli.load_scene({"follower": CONSTANTS, "cam": ECCENTRIC})
    own = machine_of(scene)
    axes = [Axis(key="cam.lift", start=0.01, stop=0.05),
            Axis(key="follower.mass", start=1.0, stop=9.0)]  # fmt: skip
    compiled = []

    def machine_of_lift(lift):
        compiled.append(lift)
        system = Made(with_follower=lambda **of: (lift, *of.items()))
        return Made(system=system, scene=Made(run=Made(rpm=1000.0 * lift)), settings=f"of {lift}")

    varied = Varied(own, axes, whole=False)
    monkeypatch.setattr(Varied, "loaded", lambda self, changes: changes["cam.lift"])
    monkeypatch.setattr(machine, "machine_of", machine_of_lift)
    assert varied(0.25, 3.0) == ((0.25, ("mass", 3.0)), 250.0, "of 0.25")
    assert varied(0.5, 3.0) == ((0.5, ("mass", 3.0)), 500.0, "of 0.5")
    assert varied(0.25, 3.0) == ((0.25, ("mass", 3.0)), 250.0, "of 0.25")
    assert compiled == [0.25, 0.5]
    for n in range(machine.MOST_COMPILED):
        varied(1.0 + n, 3.0)
    assert len(varied.compiled) <= machine.MOST_COMPILED
    varied(0.25, 3.0)
    assert compiled.count(0.25) == 2


@pytest.mark.parametrize("outside", ["", "/elsewhere/cam.csv"])
def test_a_changed_scene_is_read_as_a_user_had_given_it(monkeypatch, outside):
    asked = []
    monkeypatch.setattr(machine, "load_scene", lambda *given, **more: asked.append((given, more)))
    monkeypatch.setattr(machine, "resolved", lambda scene: "resolved")
    scene = Made(cam=Made(outside=outside, folder="/here"))
    varied = Varied(Made(scene=scene), [], "--tolerance")
    varied.loaded({"follower.mass": 2.0})
    options = {"follower.mass": (2.0, "--tolerance")}
    if outside:
        options["cam.allow_outside"] = (True, "--tolerance")
    assert asked == [(("resolved", (), options), {"folder": "/here"})]


# --- lift tables


def critical(rpm, **more):
    return Made(**{"rpm": rpm, "low": rpm - 1.0, "high": rpm + 1.0, "finite": True, **more})


@pytest.fixture
def measured(monkeypatch):
    """The range that a measured cam leaves; by the machine, whose name it is."""
    ranges = {"own": (600.0, 700.0)}
    monkeypatch.setattr(lift_table, "lost_between", lambda system: ranges.get(system))
    monkeypatch.setattr(lift_table, "replace", replaced)
    return ranges


def ends(speed):
    return None if isnan(speed.low) and isnan(speed.high) else (speed.low, speed.high)


def test_the_first_loss_alone_has_the_range_of_a_measured_cam(measured):
    """What else is finite has an unknown one; what never happens keeps its own."""
    never = critical(inf, finite=False, low=inf, high=inf)
    losses = [
        Made(region=Made(name="A1"), opens=critical(800.0), fills=never),
        Made(region=Made(name="A2"), opens=critical(650.0), fills=critical(900.0)),
    ]
    found = Made(first=critical(650.0, region="A2"), losses=losses)
    wide = lift_table.widened(found, "own")
    assert ends(wide.first) == (600.0, 700.0)
    assert [ends(loss.opens) for loss in wide.losses] == [None, (600.0, 700.0)]
    assert [ends(loss.fills) for loss in wide.losses] == [(inf, inf), None]
    assert [loss.opens.rpm for loss in wide.losses] == [800.0, 650.0]
    none = lift_table.widened(Made(first=None, losses=losses), "own")
    assert none.first is None
    assert [ends(loss.opens) for loss in none.losses] == [None, None]
    assert lift_table.widened(found, "of a law") is found


def test_springs_have_the_range_of_their_own_and_chatters_none(measured, monkeypatch):
    monkeypatch.setattr(
        "camcli.analysis.contact_loss.hold.replaced", lambda *given: given, raising=True
    )
    measured["own", 300.0, 0.0] = (710.0, 720.0)
    measured["own", 0.0, 5.0] = None
    monkeypatch.setattr(lift_table, "widened", lambda found, system: (found, system))
    holds = [Made(detaches=715.0, stiffness=300.0, preload=None, low=1.0, high=2.0),
             Made(detaches=None, stiffness=1.0, preload=1.0, low=3.0, high=4.0),
             Made(detaches=800.0, stiffness=None, preload=5.0, low=5.0, high=6.0)]  # fmt: skip
    study = Made(holds=holds, detachment="found", ends=[critical(1.0), critical(2.0)],
                 completion=[critical(3.0)])  # fmt: skip
    wide = lift_table.with_ranges(copy.copy(study), "own")
    assert wide.detachment == ("found", "own")
    assert [ends(hold) for hold in wide.holds] == [(710.0, 720.0), (3.0, 4.0), None]
    assert [ends(one) for one in (*wide.ends, *wide.completion)] == [None] * 3
    assert [one.rpm for one in wide.ends] == [1.0, 2.0]
    assert lift_table.with_ranges(study, "of a law") is study


def test_the_range_of_a_measured_cam_is_that_of_both_its_fits(monkeypatch):
    """Computed once for a machine; of a law there is none."""
    asked = []
    monkeypatch.setattr(
        "camcli.analysis.contact_loss.detachment.loss_range",
        lambda *given: asked.append(given) or (600.0, 700.0),
    )
    monkeypatch.setattr("camcli.system.System", lambda *given: given)
    monkeypatch.setattr(lift_table, "is_measured", lambda system: system.measured)
    shape = Made(rougher=("rougher shape", "rougher cam"), errors=Made(bounds=(0.5, 0.25)))
    system = Made(measured=True, shape=shape, follower="follower", known={})
    for _ in range(2):
        assert lift_table.lost_between(system) == (600.0, 700.0)
    assert asked == [(system, (0.5, 0.25), ("follower", "rougher cam", "rougher shape"))]
    system.measured = False
    assert lift_table.lost_between(system) is None
    table = Made(kind="table", errors=Made(bounds=(0.5, 0.25)))
    assert lift_table.accel_errors(table) == (0.5, 0.25)
    assert lift_table.accel_errors(Made(kind="law")) == (0.0,)


@pytest.mark.parametrize(
    ("between", "told"), [((600.0, inf), [600.0, None]), (None, []), ((nan, 700.0), [None, 700.0])]
)
def test_the_record_of_a_table_has_no_speed_that_is_infinite(measured, monkeypatch, between, told):
    monkeypatch.setattr(lift_table, "asdict", lambda accuracy: {"noise_m": accuracy.noise})
    measured["own"] = between
    record = lift_table.table_record(Made(accuracy=Made(noise=1e-6, bound=0.5)), "own")
    assert record.pop("meaning")
    assert record == {"noise_m": 1e-6, "bound": 0.5, "units": "m, deg, m/rad2",
                      "first_detachment_rpm": told}  # fmt: skip


# --- explanations and proofs


def test_an_explanation_in_the_record(monkeypatch):
    of = "camcli.words.explanations"
    monkeypatch.setattr(f"{of}.event_sentence", lambda event: f"{event.kind} it is")
    monkeypatch.setattr(f"{of}.change_sentence", lambda change, events: (change.cause, events))
    event = Made(rpm=700.5, error=1e-6, kind="fold", label="P(1;1)", corner="b", status="ok",
                 classification="class")  # fmt: skip
    change = Made(low=700.0, high=701.0, before="P(1;1)", after="contact", cause="a fold")
    found = Made(status=Status.WORK_BUDGET, events=[event], changes=[change])
    assert explanation.explained(found) == {
        "status": Status.WORK_BUDGET.text,
        "events": [{**vars(event), "words": "fold it is"}],
        "changes": [{"from_rpm": 700.0, "to_rpm": 701.0, "before": "P(1;1)", "after": "contact",
                     "cause": "a fold", "words": ("a fold", [event])}],
    }  # fmt: skip


def test_a_proof_has_one_statement_a_line_behind_all_else():
    certificate = {"format": 3, "statements": [{"a": 1}, {"b": [2, 3]}], "cam": {"kind": "arcs"},
                   "uncovered": []}  # fmt: skip
    files = proof_files.proof_files(certificate)
    assert list(files) == ["proof.json"]
    file = BytesIO()
    files["proof.json"](file)
    text = file.getvalue().decode()
    assert json.loads(text, object_pairs_hook=list) == [
        ("format", 3), ("cam", [("kind", "arcs")]), ("uncovered", []),
        ("statements", [[("a", 1)], [("b", [2, 3])]]),
    ]  # fmt: skip
    assert {'{"a": 1},', '{"b": [2, 3]}'} <= set(text.splitlines())
    assert list(proof_files.proof_files(certificate, True)) == ["proof.json", "check.py"]
    assert proof_files.proof_files(None, True) == {}
