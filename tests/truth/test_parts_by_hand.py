"""What the analyses make of their parts, which are made by hand: every number is another one."""

from __future__ import annotations

from collections import Counter
from math import pi, radians
from types import SimpleNamespace as Made

import pytest

from camcli.analysis.integrate import Cost
from camcli.analysis.lobe import Face
from camcli.analysis.orbits.curve_proofs import CurveRange
from camcli.analysis.orbits.curves import CurveLine
from camcli.analysis.orbits.proofs import ProofStep
from camcli.api import basins, classify, detach, orbit_tables, orbits, simulate, sweep, tolerances
from camcli.errors import Status
from camcli.quantities import PARAMETERS
from camcli.system import CONSTANTS, Follower
from camcli.words.proofs import FAILED

RPM = 600.0
OMEGA = 2.0 * pi * RPM / 60.0
SPENT = Status.WORK_BUDGET


def cost(n):
    return Cost(n, 10 * n)


@pytest.fixture
def drawn(monkeypatch):
    """The arguments of the picture that a module has drawn, by the name of its function."""

    def of(module) -> dict:
        found: dict = {}

        def drawn_by(name, *given):
            found[name] = given
            return lambda: None

        monkeypatch.setattr(module, "drawn_by", drawn_by)
        return found

    return of


# --- tolerances


class Machines:
    """Machines of two numbers: the follower has them as its stiffness and its preload."""

    def __init__(self, axes=("follower.stiffness", "follower.preload")):
        self.axes = [Made(key=key, start=lo, stop=hi) for key, (lo, hi) in
                     zip(axes, ((80.0, 120.0), (4.5, 5.5)), strict=True)]  # fmt: skip
        nominal = Follower(1.0, 100.0, preload=5.0)
        section = Made(tolerance=[], machines=12, hold_to=300.0)
        self.machine = Made(system=Made(follower=nominal),
                            scene=Made(detach=section, cam=Made(kind="arcs")))  # fmt: skip

    def __call__(self, stiffness, preload):
        follower = Follower(1.0, stiffness, preload=preload)
        return Made(follower=follower, shape="shape"), RPM, None


@pytest.fixture
def first_losses(monkeypatch):
    """A machine is lost at 1000 preloads minus its stiffness, and 1e5 shares of its error."""
    monkeypatch.setattr(tolerances, "accel_errors", lambda shape: (0.5,))
    monkeypatch.setattr(
        tolerances,
        "replaced",
        lambda system, stiffness, preload: Made(follower=Follower(1.0, stiffness, preload=preload)),
    )

    def first_loss(system, errors, share):
        assert errors == (0.5,)
        return 1e3 * system.follower.preload - system.follower.stiffness + 1e5 * share

    monkeypatch.setattr(tolerances, "first_loss", first_loss)


def test_a_spring_is_off_by_the_factors_of_the_machine_s_own(first_losses):
    """Stiffness 1.1 and preload 0.9 times the nominal one; the share of the error is the last."""
    springs = [Made(stiffness=200.0, preload=None), Made(stiffness=300.0, preload=7.0)]
    speeds = tolerances._HoldSpeeds(Machines(), springs)
    wanted = [4500.0 - 110.0, -220.0, 6300.0 - 330.0]
    assert speeds((110.0, 4.5)) == pytest.approx(wanted)
    assert speeds((110.0, 4.5, -0.25)) == pytest.approx([rpm - 25e3 for rpm in wanted])


@pytest.mark.parametrize("measured", [False, True])
def test_the_table_of_tolerances_begins_with_its_corners(first_losses, measured):
    """The worst machine is named by how far off it is; those in between alone are likely."""
    machines = Machines()
    machines.machine.scene.cam.kind = "table" if measured else "arcs"
    holds = [Made(quantity=quantity, stiffness=stiffness, preload=7.0) for quantity, stiffness in
             (("hold_stiffness", 200.0), ("hold_preload", None))]  # fmt: skip
    made = Made(holds=holds)
    table, summary, spread = tolerances.tolerances(machines, made, tolerances.Work(1), None)
    numbers = ["follower.stiffness", "follower.preload", *(["table_error"] if measured else [])]
    columns = [*numbers, "first_detachment_rpm", "hold_stiffness_rpm"]
    assert list(table.columns) == columns
    rows = [
        [float(table[name][k]) for name in columns] for k in range(len(table["follower.preload"]))
    ]
    ends = [[80.0, 4.5], [80.0, 5.5], [120.0, 4.5], [120.0, 5.5]]
    if measured:
        ends = [[*end, share] for end in ends for share in (-1.0, 1.0)]
    corners, between = rows[: len(ends)], rows[len(ends) :]
    assert [row[: len(numbers)] for row in corners] == ends
    assert len(between) == 12
    lows, highs = ends[0], ends[-1]
    for row in between:
        inside = zip(lows, row[: len(numbers)], highs, strict=True)
        assert all(low < value < high for low, value, high in inside)
    shares = [row[2] if measured else 0.0 for row in rows]
    for row, share in zip(rows, shares, strict=True):
        own, with_spring = row[-2:]
        assert own == pytest.approx(1e3 * row[1] - row[0] + 1e5 * share)
        assert with_spring == pytest.approx(1400.0 * row[1] - 2.0 * row[0] + 1e5 * share)
    off = {"follower.stiffness": 20.0, "follower.preload": -10.0}
    if measured:
        off["table_error"] = -100.0  # percent of its bound
    assert summary["worst"] == pytest.approx(off)
    assert summary["worst_rpm"] == min(row[-2] for row in rows)
    assert (spread.worst, spread.numbers) == (summary["worst_rpm"], summary["worst"])
    assert list(spread.speeds) == [row[-2] for row in between]
    assert spread.shares == summary["shares"]


def test_a_machine_that_failed_has_no_speed(first_losses, monkeypatch):
    """It is one fault, which names it. The lower end comes first, of a negative number too."""

    class Some(Machines):
        def __call__(self, stiffness, preload):
            if stiffness == 1.0:
                raise ArithmeticError
            return super().__call__(stiffness, preload)

    holds = tolerances._HoldSpeeds(Some(), [Made(stiffness=200.0, preload=None)])
    faults = []
    monkeypatch.setattr(tolerances, "gather", faults.extend)
    pieces = [(2.0, 5.0), (1.0, 5.0), (3.0, 5.0)]
    told = tolerances._speeds_of_machines(holds, pieces, tolerances.Work(1), None)
    assert told == [[4998.0, pytest.approx(-4.0)], [None, None], [4997.0, pytest.approx(-6.0)]]
    (fault,) = faults
    assert fault.piece == "the machine with follower.stiffness, follower.preload = 1, 5"
    values = {"follower": {"gravity": -8.0, "mass": 2.0}}
    monkeypatch.setattr(tolerances, "resolved", lambda scene: values)
    for key, ends in (("follower.gravity", (-8.4, -7.6)), ("follower.mass", (1.9, 2.1))):
        axis = tolerances._axis(Made(scene=None), key, 5.0)
        assert (axis.key, axis.start, axis.stop) == (key, *map(pytest.approx, ends))


def test_the_first_loss_of_all_is_the_worst_one():
    assert tolerances._worst([(None, 1.0), (30.0, 9.0), (20.0, 8.0), (25.0, 2.0)]) == 2


# --- sweep and classify


def explanation(status):
    return Made(cost=cost(500), status=status, events=["event"])


@pytest.mark.parametrize("status", [Status.OK, SPENT])
@pytest.mark.parametrize("trouble", [False, True])
def test_the_result_of_a_sweep_with_its_explanation(monkeypatch, drawn, status, trouble):
    """Costs of sweep, motions and explanation; the worst status; what is drawn beside."""
    found_pictures = drawn(sweep)
    for name, told in (("_summary", {"a": 1}), ("_tables", {}), ("height_notes", ["high"]),
                       ("sweep_notes", ["swept"]), ("shown_cam", "cam")):  # fmt: skip
        monkeypatch.setattr(sweep, name, lambda *given, told=told: told)
    thrown = []
    monkeypatch.setattr(sweep, "throw", lambda system, rpm: thrown.append(rpm))
    monkeypatch.setattr(sweep, "has_seat", lambda scene, keys: keys == ("rpm",))
    monkeypatch.setattr("camcli.api.explanation.corners_table", lambda explanation: {})
    monkeypatch.setattr("camcli.api.explanation.explained", lambda explanation: {"b": 2})
    zoom = [Made(start=720.0, stop=710.0), Made(start=730.0, stop=740.0)]
    section = Made(zoom=zoom, phases_deg=(1.0, 2.0), positions_m=(3.0, 4.0))
    machine = Made(scene=Made(sweep=section, cam=None), system="system", settings="settings")
    found = Made(cost=cost(1), key="rpm", bare=[Made(rpm=700.0), Made(rpm=800.0), Made(rpm=750.0)],
                 troubled=[(700.0, Status.NO_RETURN)] if trouble else [])  # fmt: skip
    motions = [Made(cost=cost(20)), Made(cost=cost(30))]
    result = sweep._result(machine, found, ["branch"], motions, explanation(status))
    assert result.cost == cost(551)
    statuses = [Status.NO_RETURN] if trouble else []
    assert result.summary == {"a": 1, "b": 2, "status": sweep.worst_status([*statuses, status])}
    assert result.complete is (status is Status.OK and not trouble)
    assert len(result.notes) == 2 + trouble + (status is SPENT)
    assert thrown == [800.0]
    assert found_pictures["sweep.draw_sweep"] == (
        found, "system", "settings", ["event"], ["branch"], [(710.0, 720.0), (730.0, 740.0)],
        {"impacts": (1.0, 2.0), "strobe": (3.0, 4.0)}, "cam",
    )  # fmt: skip
    plain = sweep._result(machine, found, [], [], None)
    assert (plain.cost, plain.complete) == (cost(1), not trouble)
    assert found_pictures["sweep.draw_sweep"][3] == ()


@pytest.mark.parametrize("status", [Status.OK, SPENT])
@pytest.mark.parametrize("trouble", [False, True])
def test_the_result_of_classified_motions(monkeypatch, drawn, status, trouble):
    found_pictures = drawn(classify)
    thrown = []
    monkeypatch.setattr(classify, "throw", lambda system, rpm: thrown.append(rpm))
    monkeypatch.setattr(classify, "height_notes", lambda heights: ["high"])
    monkeypatch.setattr(classify, "corners_table", lambda explanation: {})
    noted = []
    monkeypatch.setattr(classify, "status_notes", lambda *given: noted.append(given) or ["status"])
    lost = Status.NO_RETURN if trouble else Status.OK
    motions = [Made(cost=cost(20), status=Status.OK, value=0.25, rpm=700.0),
               Made(cost=cost(30), status=lost, value=0.5, rpm=800.0),
               Made(cost=cost(3), status=Status.OK, value=0.75, rpm=750.0)]  # fmt: skip
    machine = Made(scene=None, system="system")
    result = classify._result(machine, "run.x", motions, explanation(status), {"a": 1})
    assert result.cost == cost(553)
    assert result.summary == {"a": 1, "status": classify.worst_status([lost, status])}
    assert result.complete is (status is Status.OK and not trouble)
    assert noted == [([(0.5, lost)] if trouble else [], "run.x")]
    assert thrown == [800.0]
    assert found_pictures["classify.draw_classify"] == (motions, "system", ["event"], "run.x")
    plain = classify._result(machine, "run.x", motions, None, {"a": 1})
    assert (plain.cost, plain.complete) == (cost(53), not trouble)


@pytest.mark.parametrize("falls", [False, True])
def test_the_values_of_a_sweep_with_zooms_go_on_in_its_direction(monkeypatch, falls):
    """Each value once; the progress counts those of all starts."""
    values = [700.0, 720.0, 740.0]
    zoom = [Made(start=710.0, stop=720.0, num=3), Made(start=740.0, stop=730.0, num=2)]
    section = Made(
        vary=(), zoom=zoom, also=["a", "b"], branches=None, direction="fixed", adaptive=False,
        sections=("impacts",), lyapunov=True, explain=False, curves=None, prove=False,
    )  # fmt: skip
    machine = Made(scene=Made(sweep=section), system="system", settings="settings")
    monkeypatch.setattr(sweep, "machine_of", lambda scene: machine)
    ordered = values[::-1] if falls else values
    monkeypatch.setattr(sweep, "span_of", lambda machine, section: ("rpm", list(ordered), "setup"))
    monkeypatch.setattr(sweep, "start_of", lambda scene, system, start, place: (start, place))
    asked = {}

    def run(system, compact, settings, **more):
        asked.update(more, values=compact.tolist())
        more["on_speed"]()
        return Made(faults=[])

    monkeypatch.setattr(sweep, "run", run)
    monkeypatch.setattr(sweep, "_result", lambda *given: given)
    monkeypatch.setattr(sweep, "replace", lambda result, **more: result)
    seen = []
    sweep.sweep(None, lambda *given: seen.append(given))
    wanted = sorted([700.0, 710.0, 715.0, 720.0, 730.0, 740.0], reverse=falls)
    assert asked["values"] == wanted
    assert seen == [("speeds", 1, 18)]
    assert asked["also"] == [("a", "sweep.also.0"), ("b", "sweep.also.1")]
    assert (asked["impacts"], asked["strobe"], asked["setup"]) == (True, False, "setup")


@pytest.mark.parametrize("status", [None, Status.OK, SPENT])
def test_the_result_of_a_map(monkeypatch, drawn, status):
    """status: of the curves, None without them. What is in trouble has the first number."""
    found_pictures = drawn(sweep)

    def point(value, label, own):
        return Made(value=value, label=label, status=own)

    lost = Status.NO_RETURN
    speeds = [point(1.0, "P(1;1)", Status.OK), point(2.0, "P(1;1)", lost),
              point(3.0, "P(1;1)", Status.OK)]  # fmt: skip
    found = Made(cost=cost(1), speeds=speeds, faults=[], direction="up")
    asked = []
    monkeypatch.setattr(sweep, "sweep_map", lambda *given, **more: asked.append(given) or found)
    monkeypatch.setattr(sweep, "Varied", lambda *given: "machines")
    monkeypatch.setattr(sweep, "has_seat", lambda scene, keys: True)
    monkeypatch.setattr(sweep, "units_of", lambda system: "units")
    monkeypatch.setattr(sweep, "map_notes", lambda found, decide: ["map"])
    noted = []
    monkeypatch.setattr(sweep, "status_notes", lambda *given: noted.append(given) or ["status"])
    monkeypatch.setattr("camcli.api.atlas.plane_of", lambda scene, vary: "plane")
    atlas = Made(cost=cost(20), points=["point"])
    auto = Made(lines=["line"], tables={"curves": {}}, summary={"words": []}, status=status,
                atlas=atlas, certificate=None)  # fmt: skip
    monkeypatch.setattr(sweep, "_auto_curves", lambda *given: auto)
    axes = [
        Made(key="run.x", start=1.0, stop=3.0, num=3),
        Made(key="run.y", start=4.0, stop=5.0, num=2),
    ]
    section = Made(direction="up", vary=axes, curves=None if status is None else sweep.AUTO,
                   lyapunov=False, decide=False)  # fmt: skip
    scene = Made(sweep=section, cam=Made(kind="arcs"))
    machine = Made(scene=scene, system=None, settings=Made(record=4))
    result = sweep._mapped(machine, None, sweep.Work(1))
    assert asked == [(("run.x", "run.y"), [1.0, 2.0, 3.0], [4.0, 5.0], "machines")]
    assert noted == [([(2.0, lost)], "run.x")]
    assert not result.complete
    of_curves = [] if status is None else [status]
    worst = sweep.worst_status([Status.OK, lost, *of_curves])
    assert (result.summary["status"], result.summary["direction"]) == (worst, "up")
    counts = [(row["label"], row["status"], row["points"]) for row in result.summary["labels"]]
    assert counts == [("P(1;1)", "ok", 2), ("P(1;1)", lost.text, 1)]
    curves = (["line"], ["point"]) if of_curves else ([], ())
    assert result.cost == cost(21 if of_curves else 1)
    assert ("curves" in result.tables) is bool(of_curves)
    assert len(result.notes) == 2 + (status is SPENT)
    assert found_pictures["sweep_map.draw_map"] == (found, "units", *curves, True, "arcs")
    speeds[1].status = Status.OK
    whole = sweep._mapped(machine, None, sweep.Work(1))
    assert whole.complete is (status is not SPENT)


def test_the_proofs_of_a_map():
    """Of a point None: not tried. A curve that is not tried has the turns of its first orbit."""

    def curve(*turns):
        return Made(points=[Made(orbit=Made(turns=count)) for count in turns])

    points = [Made(proof=None), Made(proof=Made(step=None)), Made(proof=Made(step=ProofStep.PULLS))]
    ranges = [CurveRange(1, 2, 3, ((1.0, 2.0), (3.0, 4.0)), 5)]
    atlas = Made(points=points, ranges=ranges, not_tried=[1, 3],
                 curves=[curve(5, 6), curve(7, 8), curve(9, 10)])  # fmt: skip
    told = sweep._proofs(atlas, 0.25)
    assert told["points"] == [
        None, {"proved": True, "failed_step": None},
        {"proved": False, "failed_step": FAILED[ProofStep.PULLS]},
    ]  # fmt: skip
    assert told["not_tried"] == [{"curve": 1, "turns": 5}, {"curve": 3, "turns": 9}]
    assert [part["curve"] for part in told["curve_ranges"]] == [1]
    assert told["flank_excess_m"] == 0.25


@pytest.mark.parametrize("status", [Status.OK, SPENT])
@pytest.mark.parametrize("proved", [False, True])
def test_curves_over_a_map(monkeypatch, status, proved):
    """Lines with their proved parts; no sentence on no curve where the search did not end."""

    def line(kind):
        return CurveLine(kind, "P(1;1)", "", [1.0], [2.0])

    ranges = [CurveRange(2, 1, 3, ((1.0, 2.0), (3.0, 4.0)), 5)]
    curves = [
        Made(line=line("fold"), points=[1, 2]),
        Made(line=line("grazing"), points=[1, 2, 3, 4]),
    ]
    atlas = Made(curves=curves, ranges=ranges if proved else None, points=["p"])
    monkeypatch.setattr("camcli.api.atlas.atlas_of", lambda *given: (atlas, status))
    said = []
    monkeypatch.setattr(sweep, "atlas_words", lambda *given: said.append(given) or ["said"])
    monkeypatch.setattr(sweep, "_proofs", lambda atlas, excess: excess)
    monkeypatch.setattr(sweep, "_certificate", lambda machine, atlas: {"a": 1})
    tables = {}
    monkeypatch.setattr(
        sweep, "curve_table", lambda *given, **more: tables.update(curve=(given, more))
    )
    monkeypatch.setattr(sweep, "codim2_table", lambda *given: tables.update(codim2=given))
    plane = Made(names=("rpm", "restitution"))
    machine = Made(scene=Made(sweep=Made(vary=[], prove_turns=6)),
                   system=Made(shape=Made(flank_excess=0.25)))  # fmt: skip
    keys = ("rpm", "follower.restitution")
    found = sweep._auto_curves(machine, plane, keys, None)
    parts = [[], [True, True, False]] if proved else [[], []]
    assert [one.proved for one in found.lines] == parts
    key_of = {"rpm": "rpm", "restitution": "follower.restitution"}
    assert tables["curve"] == ((curves, plane, key_of), {"ranges": atlas.ranges})
    assert tables["codim2"] == (["p"], plane, key_of, proved)
    assert said == [(atlas, 6, 0.25)]
    assert found.summary == {"words": ["said"], **({"proofs": 0.25} if proved else {})}
    assert found.certificate == ({"a": 1} if proved else None)
    atlas.curves = []
    words = sweep._auto_curves(machine, plane, keys, None).summary["words"]
    assert words == (["said"] if status is Status.OK else [])


# --- tables of orbits


def test_the_course_of_a_branch():
    """Where it turns round, and the range over which it stays stable."""
    branch = Made(
        points=[Made(value=value) for value in (0.5, 0.75, 0.625, 0.25)],
        turning_points=[0.75, 0.625],
        stable_stretches=lambda events: [(range(1), (0.4, 0.6)), (range(2, 4), (0.2, 0.7))],
    )  # fmt: skip
    assert orbit_tables._courses(branch, ()) == [
        [0, 0.4, 0.6], [1, None, None], [1, 0.2, 0.7], [0, 0.2, 0.7]
    ]  # fmt: skip


def test_the_boxes_of_chaos():
    """Axes are columns: (along, across) of the phase, then of the rate; boxes count from one."""

    def box(stretch, n):
        axes = ((radians(n + 1.0), radians(n + 2.0)), (n + 3.0, n + 4.0))
        return Made(stretch=stretch, middle=(radians(n), n + 0.5), axes=axes,
                    lands=Made(turn=int(n) % 7), cells=(3, 5 + int(n)))  # fmt: skip

    chaos = Made(rpm=RPM, boxes=[box(4, 10.0), box(2, 20.0)], coverings=[(0, 0), (0, 1), (1, 1)],
                 proved=True)  # fmt: skip
    names = {2: "A1", 4: "A2"}
    table = orbit_tables.chaos_table(chaos, names)

    def rows():
        columns = [table[name].tolist() for name in table.columns]
        return [list(row) for row in zip(*columns, strict=True)]

    def near(value):
        return pytest.approx(value, rel=1e-12)

    wanted = [
        [k, name, *map(near, (n, (n + 0.5) * OMEGA, n + 1.0, (n + 3.0) * OMEGA, n + 2.0,
                              (n + 4.0) * OMEGA)), turn, covers, cells, "yes"]
        for k, name, n, turn, covers, cells in (
            (1, "A2", 10.0, 3, "1:2", 3 * 15), (2, "A1", 20.0, 6, "2", 3 * 25))
    ]  # fmt: skip
    assert [list(map(str, row[9:10])) + row[:9] + row[10:] for row in rows()] == [
        [row[9], *row[:9], *row[10:]] for row in wanted
    ]
    chaos.proved = False
    table = orbit_tables.chaos_table(chaos, names)
    assert table["proved"].tolist() == ["no", "no"]


def test_which_number_of_a_plane_was_solved_for():
    """The kernel's table has the speed and the follower's constants, then those of the cam."""

    def solved(names, place):
        point = Made(orbit=Made(root=Made(parameter=place)))
        return orbit_tables._solved_for(point, Made(names=names))

    names = list(PARAMETERS)
    for place, name in enumerate(names):
        assert solved((name, "cam.lift"), place) == 0
        assert solved(("cam.lift", name), place) == 1
    assert len(names) == CONSTANTS
    assert solved(("rpm", "cam.lift"), CONSTANTS) == 1
    assert solved(("cam.lift", "rpm"), CONSTANTS) == 0
    two = ("cam.lift", "cam.base_radius")
    assert [solved(two, CONSTANTS + k) for k in (0, 1)] == [0, 1]


@pytest.mark.parametrize("parameter", ["rpm", "restitution", "cam.lift"])
def test_a_value_beside_its_enclosure_is_put_into_it(parameter):
    """In the column of what varies: the speed, a key that comes first, or a constant behind."""
    keys = {"cam.lift": "cam.lift"}

    def event(value):
        orbit = Made(
            trace=0.125, det=0.375, rpm=value if parameter == "rpm" else RPM, resting=False
        )
        return Made(branch=3, label="P(1;1)", kind="fold", value=value, error=1e-9, corner="",
                    classification="", orbit=orbit, left=None, right=None)  # fmt: skip

    proofs = [Made(proved=k < 3, low=0.25, high=0.75) for k in range(4)]
    values = [0.2, 0.5, 0.8, 0.9]
    result = Made(question=Made(parameter=parameter), bifurcations=[event(x) for x in values],
                  proofs=Made(events=proofs))  # fmt: skip
    table = orbit_tables.bifurcations_table(result, keys)
    assert table[parameter].tolist() == [0.25, 0.5, 0.75, 0.9]
    assert table["proved"].tolist() == ["yes"] * 3 + ["no"]
    assert table["enclosure_low"].tolist() == [0.25] * 4
    assert table["enclosure_high"].tolist() == [0.75] * 4
    assert (table.columns[0] == "cam.lift") is (parameter == "cam.lift")
    if parameter != "rpm":
        assert table["rpm"].tolist() == [RPM] * 4
        assert table[f"{parameter}_error"].tolist() == [1e-9] * 4


def test_branches_and_curves_that_are_read(tmp_path):
    """The first column of a key, by its last name or with a unit; proved parts up to the last."""
    path = tmp_path / "table.csv"
    path.write_text(
        "preload_factor,preload_n,stable,theta_deg_1,theta_deg_2,theta_degrees,q_m,branch\n"
        "9,1.5,1,10,20,8,0.1,1\n9,2.5,0,30,,8,0.2,1\n9,3.5,2,50,60,8,0.3,2\n"
    )
    first, second = orbit_tables.read_branches(path, "follower.preload_n")
    assert (first.values.tolist(), second.values.tolist()) == ([1.5, 2.5], [3.5])
    assert (first.stable, second.stable) == ([True, False], [False])
    assert (first.q.tolist(), second.q.tolist()) == ([0.1, 0.2], [0.3])
    one, two = (column.tolist() for column in first.phases)
    assert (one, two[0], two[1] != two[1]) == ([10.0, 30.0], 20.0, True)
    path.write_text("rpmx,rpm,stable,theta_deg,q_m\n9,1.5,1,10,0.1\n")
    (alone,) = orbit_tables.read_branches(path, "rpm")  # one point lies along any number
    assert alone.values.tolist() == [1.5]
    path.write_text(
        "curve,kind,rpm,restitution,proved_to_next,corner,label\n"
        "1,fold,1.5,0.5,yes,,P(1;1)\n1,fold,2.5,0.6,no,,P(1;1)\n1,fold,3.5,0.7,,,P(1;1)\n"
        "2,grazing,4.5,0.8,yes,b,P(2;1:1)\n2,grazing,5.5,0.9,,b,P(2;1:1)\n"
    )
    curves = orbit_tables.read_curves(path, ("follower.restitution", "rpm"))
    assert [(one.kind, one.label, one.corner, list(one.proved)) for one in curves] == [
        ("fold", "P(1;1)", "", [True, False]), ("grazing", "P(2;1:1)", "b", [True])
    ]  # fmt: skip
    assert [(one.first.tolist(), one.second.tolist()) for one in curves] == [
        ([0.5, 0.6, 0.7], [1.5, 2.5, 3.5]), ([0.8, 0.9], [4.5, 5.5])
    ]  # fmt: skip


# --- orbits


def test_which_pictures_of_orbits_there_are(monkeypatch, drawn):
    """Orbits in time at one speed alone; curves with the parts of them that are proved."""
    found_pictures = drawn(orbits)
    monkeypatch.setattr(orbits, "periods_of", lambda found, system: list(found))
    headings = []
    monkeypatch.setattr(
        "camcli.words.all_orbits.cover_heading",
        lambda *given: headings.append(given) or ("title", "words"),
    )
    plane = Made(names=("rpm", "restitution"))
    proofs = Made(ranges=["range"], curve_ranges=["curve range"])
    found = Made(branches=[], orbits=["orbit"], question=Made(plane=None), every=None,
                 chaos="chaos", curves=["curve"], codim2=["point"], proofs=None)  # fmt: skip
    assert list(orbits._pictures("system", found, "simulated", None)) == ["orbits"]
    assert found_pictures["orbits.draw_orbits"] == (found, "system", "simulated", ["orbit"])
    found.branches = ["branch"]
    found.question.plane = plane
    found.every = Made(covers=[Made(drawn=False), Made(drawn=True)])
    pictures = orbits._pictures("system", found, None, "view")
    assert list(pictures) == ["orbits", "chaos", "curve", "cover"]
    assert found_pictures["orbits.draw_orbits"] == (found, "system", None, [])
    assert found_pictures["chaos.draw_chaos"] == ("chaos", "view")
    curves = (["curve"], plane.names, ["point"])
    assert found_pictures["orbits.draw_curves"] == (*curves, ())
    assert found_pictures["cover.draw_cover"] == (found.every, "system", "title", "words")
    assert headings == [(found, found.every)]
    found.proofs = proofs
    found.every.covers[1].drawn = False
    assert "cover" not in orbits._pictures("system", found, None, None)
    assert found_pictures["orbits.draw_curves"] == (*curves, ["curve range"])


def test_proofs_of_curves_count_from_one_and_starts_have_the_window_of_basins(monkeypatch):
    asked = []
    monkeypatch.setattr(
        "camcli.analysis.orbits.curve_proofs.prove_curve",
        lambda *given: asked.append(given) or [given[2], -given[2]],
    )
    found = Made(question=Made(plane="plane"), curves=["a", "b"])
    assert orbits._curve_ranges("system", found) == [1, -1, 2, -2]
    assert asked == [("system", "a", 1, "plane"), ("system", "b", 2, "plane")]
    found.question.plane = None
    assert orbits._curve_ranges("system", found) == []
    monkeypatch.setattr("camcli.analysis.orbits.starts.starts", lambda *given: given)
    scene = Made(basins=Made(q=(0.1, 0.9), v=(-20.0, 40.0)))
    proof = Made(evidence="evidence", axes=["axes"])
    wanted = ("evidence", ["axes"], RPM, 0.5, (0.1, 0.9), (-20.0, 40.0))
    orbit = Made(rpm=RPM, label="P(1;1)")
    assert orbits._starts(scene, Made(strobe=0.5), orbit, proof) == wanted
    for nothing in (Made(evidence=None, axes=["axes"]), Made(evidence="evidence", axes=[])):
        assert orbits._starts(scene, Made(strobe=0.5), orbit, nothing) is None


def test_the_statement_of_chaos_comes_behind_those_that_are_there(monkeypatch):
    answers = {"chaos": ("chaos", {"of": "chaos"})}
    monkeypatch.setattr("camcli.analysis.chaos.study.chaos_at", lambda *given: answers["chaos"])
    monkeypatch.setattr("camcli.cams.formula.formula_of", lambda shape, seat: "formula")
    monkeypatch.setattr(orbits, "replace", lambda found, **more: Made(**{**vars(found), **more}))
    machine = Made(system=Made(shape=None, follower=Made(seat_restitution=None)), settings=None)
    found = Made(question=Made(rpm=RPM), orbits=[])
    old = {"format": 3, "cam": "cam", "statements": ["first"], "uncovered": ["x"]}
    study, certificate = orbits._with_chaos(machine, found, old)
    assert study.chaos == "chaos"
    assert certificate == {**old, "statements": ["first", {"of": "chaos"}]}
    _, alone = orbits._with_chaos(machine, found, None)
    assert (alone["cam"], alone["statements"], alone["uncovered"]) == (
        "formula", [{"of": "chaos"}], []
    )  # fmt: skip
    answers["chaos"] = ("chaos", None)
    assert orbits._with_chaos(machine, found, old)[1] is old
    assert orbits._with_chaos(machine, found, None)[1] is None


def test_motions_are_simulated_over_what_was_followed(monkeypatch):
    """From the low end of the reach up; of another number than the speed each has its machine."""
    asked = []
    monkeypatch.setattr(orbits, "sweep", lambda *given, **more: asked.append((given, more)))
    found = Made(question=Made(rpm=RPM, parameter="rpm"), reach=(500.0, 700.0))
    machine = Made(system="system", settings="settings")
    orbits._simulated(machine, found, 3)
    assert asked.pop() == (("system", [500.0, 600.0, 700.0], "settings"), {"key": "rpm"})
    found = Made(question=Made(rpm=RPM, parameter="restitution"), reach=(0.5, 0.75))
    monkeypatch.setattr(orbits, "Shooter", lambda *given: Made(at=lambda value: (*given, value)))
    monkeypatch.setattr(
        orbits, "with_machine", lambda system, table: ((system, table), 2.0 * table[1])
    )
    orbits._simulated(machine, found, 2)
    given, more = asked.pop()
    assert given == ("system", [0.5, 0.75], "settings")
    assert more["key"] == "restitution"
    table = ("system", RPM, "restitution", 0.75)
    assert more["setup"](0.75) == (("system", table), 2.0 * RPM, "settings")


# --- detach


@pytest.mark.parametrize(
    ("report", "hold_to", "start", "stop", "wanted"),
    [
        (True, None, 500.0, 700.0, 700.0),
        (True, None, 700.0, 500.0, 700.0),  # the end of the range is its fastest speed
        (True, 650.0, 500.0, 700.0, 650.0),
        (False, None, 500.0, 700.0, None),
    ],
)
def test_a_report_shows_springs_that_hold_to_the_end_of_the_range(
    monkeypatch, report, hold_to, start, stop, wanted
):
    def with_values(scene, name, **values):
        return Made(detach=Made(**{**vars(scene.detach), **values}))

    monkeypatch.setattr(detach, "with_values", with_values)
    monkeypatch.setattr(detach, "replace", lambda machine, scene: Made(scene=scene))
    section = Made(report=report, hold_to=hold_to, rpm=Made(start=start, stop=stop))
    held = detach._held_in_report(Made(scene=Made(detach=section)))
    assert held.scene.detach.hold_to == wanted


@pytest.mark.parametrize(
    ("seat", "count", "past", "moved"),
    [(True, 1, (), True), (False, 1, (), False), (True, 2, (), False), (True, 1, (1,), False)],
)
def test_a_single_speed_on_a_seat_has_its_motion(monkeypatch, seat, count, past, moved):
    """Though contact holds there; unless it has one already past the loss of contact."""
    monkeypatch.setattr(detach, "with_ranges", lambda found, system: found)
    monkeypatch.setattr(detach, "_summary", lambda found: {"a": 1})
    monkeypatch.setattr(detach, "_working_speed", lambda scene: 650.0)
    monkeypatch.setattr(detach, "_moved_at_work", lambda machine, found, rpm: found)
    monkeypatch.setattr(detach, "_at_work", lambda machine, found, rpm: {"rpm": rpm})
    monkeypatch.setattr(detach, "seating_ranges", lambda machine, found: ["seating"][: len(past)])
    monkeypatch.setattr(detach, "_moved_as_asked", lambda machine, found, rpm: ("moved", rpm))
    machine = Made(system=Made(has_seat=seat), scene=None)
    found = Made(past=past)
    study, record = detach._completed(machine, found, [700.0, 800.0][:count])
    assert study == (("moved", 700.0) if moved else found)
    seating = {"seating": ["seating"]} if past else {}
    assert record == {"a": 1, "working": {"rpm": 650.0}, **seating}


def test_a_budget_that_is_spent_is_told_once():
    def told(troubled, status):
        curve = Made(troubled=troubled, critical_speeds=(), hits=(), jumps=(), holds=(), ended=())
        return Counter("budget" in note for note in detach._notes(curve, status))

    assert told([], Status.OK) == {}
    assert told([], SPENT) == {True: 1}
    assert told([(700.0, SPENT)], SPENT).total() == 1
    assert told([(700.0, Status.NO_RETURN)], SPENT).total() == 2
    statements = [{"low": "700.25", "high": "700.75"}, {"low": "800.5", "high": "800.75"}]
    assert detach._proved_speeds({"statements": statements}) == [700.25, 800.5]
    assert detach._proved_speeds(None) == []


@pytest.mark.parametrize("roller", [None, 0.004])
def test_a_lobe_is_undercut_under_the_follower_whose_pressure_is_asked_for(monkeypatch, roller):
    asked = []
    monkeypatch.setattr(detach, "lobe_of", lambda *given: asked.append(given) or "lobe")
    monkeypatch.setattr(detach, "pressure_notes", lambda lobe, units: [lobe, units])
    monkeypatch.setattr(detach, "units_of", lambda system: f"units of {system}")
    monkeypatch.setattr(detach, "Force", lambda system: Made(starts=[0.5, 0.75]))
    contact = Made(width=0.01, follower_radius=roller, base_radius=0.02)
    machine = Made(scene=Made(contact=contact, cam=None), system=Made(as_drawn="drawn"))
    assert detach._undercut(machine) == ["lobe", "units of drawn"]
    face = Face.FLAT if roller is None else Face.ROLLER
    assert asked == [("drawn", face, 0.02, roller or 0.0, [(0, 0.5)])]
    contact.width = None
    assert detach._undercut(machine) == []


def test_forces_have_their_pressure_where_it_is_known():
    curves = [
        Made(rpm=700.0, theta=[radians(10.0), radians(20.0)], force_n=[1.5, 2.5],
             pressure_pa=[3e6, 4e6]),
        Made(rpm=800.0, theta=[radians(30.0)], force_n=[5.5], pressure_pa=[]),
    ]  # fmt: skip
    found = Made(forces=curves, past=[])
    table = detach._tables(found, False)["force"]
    columns = {name: table[name].tolist() for name in table.columns}
    pressures = columns.pop("pressure_pa")
    assert pressures[:2] == [3e6, 4e6]
    assert pressures[2] != pressures[2]
    assert columns == {
        "rpm": [700.0, 700.0, 800.0], "theta_deg": pytest.approx([10.0, 20.0, 30.0]),
        "force_n": [1.5, 2.5, 5.5],
    }  # fmt: skip


# --- basins and profiles


def test_the_tables_of_basins_are_those_that_were_asked_for():
    """The speed is the last column of the cells of several, another number the first."""
    speed = Made(exponents=None)

    def columns(grids, key, saddles=False):
        found = basins._tables(Made(speeds=[speed], grids=grids), Made(refine=0), key, saddles)
        return {name: list(table.columns) for name, table in found.items()}

    cells = ["q_m", "v_m_per_s", "attractor"]
    assert columns([], "rpm").keys() == {"attractors"}
    assert columns([1], "rpm")["basins"] == cells
    assert columns([1], "run.x")["basins"] == cells
    assert columns([1, 2], "rpm")["basins"] == [*cells, "rpm"]
    assert columns([1, 2], "run.x")["basins"] == ["run.x", *cells]
    assert columns([], "run.x", True)["saddles"][0] == "run.x"


def test_cams_side_by_side_have_the_first_base_circle_that_is_known(monkeypatch):
    """--base-radius is that of the scene's own cam; another cam keeps the one that it says."""
    monkeypatch.setattr(simulate, "machine_of", lambda scene: Made(scene=scene))

    def radii(typed, own, *others):
        scene = Made(simulate=Made(base_radius=typed, beside=[Made(base_radius=x) for x in others]))
        scene.cam = Made(base_radius=own)
        scene.model_copy = lambda update: Made(cam=update["cam"])
        return [each.base_radius for each in simulate._cams_side_by_side(Made(scene=scene))]

    assert radii(0.01, 0.02, 0.03, None) == [0.01, 0.03, 0.01]
    assert radii(None, 0.02, None, 0.03) == [0.02, 0.02, 0.03]
    assert radii(None, None, None, 0.03) == [0.03, 0.03, 0.03]
    assert radii(None, None, None) == [None, None]
