"""What `cam bench` makes of its measurements: from pieces that are measured by hand."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import cos, nan, pi
from types import SimpleNamespace as Made

import pytest

from camcli.analysis.bench import precision, stability
from camcli.analysis.integrate import Cost
from camcli.api import bench, validation
from camcli.api.bench import PartPlan, WholeStudy
from camcli.api.validation import balls, problem
from camcli.errors import Status
from camcli.piece_faults import PieceFault, gathering
from camcli.scene import load_scene


def test_a_study_is_timed_on_one_thread_and_on_all_in_turn(monkeypatch):
    """The least seconds of each; what one run has followed in balls is forgotten before another."""
    seconds = iter([4.0, 1.5, 3.0, 0.5, 6.0, 2.5])
    runs = []

    def study(scene, work):
        runs.append((scene, work.threads, len(cleared)))
        return Made(seconds=next(seconds), cost=Made(impacts=60))

    cleared = []
    monkeypatch.setattr(bench, "of_shape", Made(cache_clear=lambda: cleared.append(1)))
    monkeypatch.setattr(bench, "load_scene", lambda path, keys: (path, keys))
    monkeypatch.setattr(bench, "thread_count", lambda asked: 6)
    monkeypatch.setattr(bench, "STUDIES", {"own": WholeStudy(study, 77.0, {"a": 1})})
    row = bench._throughput("own", 3)
    assert runs == [((None, {"a": 1}), threads, n) for n, threads in enumerate([1, 6] * 3, 1)]
    assert row == bench.Throughput(
        case="own", turns=77.0, impacts=60, threads=6, seconds_one_thread=3.0, seconds=0.5,
        speedup=6.0, impacts_per_s=120.0,
    )  # fmt: skip


@pytest.mark.parametrize("name", ["sweep", "map"])
def test_the_turns_of_a_study_are_those_of_its_orbits_with_their_transients(name):
    study = bench.STUDIES[name]
    scene = load_scene(None, study.keys)
    orbits = scene.sweep.rpm.num
    if scene.sweep.vary:
        first, second = scene.sweep.vary
        orbits = first.num * second.num
    assert study.turns == orbits * (scene.run.transient + scene.run.record)


def test_costs_are_those_of_our_own_rows_and_a_missing_peer_is_no_failure(monkeypatch):
    """A note on what is not installed leaves the run complete; a line of failures does not."""
    rows = [
        precision.Measured("a", precision.CORE, "tol", 0.5, 1e-9, 40, 700, status=precision.OK),
        precision.Measured("a", precision.CORE, "tol", 0.5, 1e-9, 3, 5, status=precision.OK),
        precision.Measured("a", "rk4", "step", 0.5, 1e-9, 9000, 8000, status=precision.OK),
        precision.Measured("a", "other", "tol", status=precision.ABSENT),
    ]
    monkeypatch.setattr(bench, "_measured", lambda *_: rows)
    scene = load_scene(None, {"bench.part": "precision"})
    result = bench.bench(scene)
    assert result.cost == Cost(43, 705)
    assert (result.notes, result.complete) == ((bench.NO_HEYOKA,), True)
    rows[0] = replace(rows[0], status=precision.MISSED)
    failed = bench.bench(scene)
    assert not failed.complete
    line, note = failed.notes
    assert line.startswith("precision: a, tol: missed")
    assert note == bench.NO_HEYOKA


@pytest.mark.parametrize(("quick", "repeats"), [(True, 1), (False, 4)])
def test_the_seconds_of_a_plan_are_those_of_its_pieces(quick, repeats):
    """Half a second a case, a quarter a problem, five a study, as often as it is repeated."""
    scene = load_scene(None, {"bench.quick": quick, "bench.repeats": 4})
    plan = bench.plan(scene)
    assert plan["stability"]["seconds"] == 0.5 * plan["stability"]["runs"]
    assert plan["validation"] == {
        "runs": 17 if quick else 21,
        "seconds": 17 / 4 if quick else 21 / 4,
    }
    assert plan["scale"] == {"runs": 3, "seconds": 15.0 * repeats}
    only = bench.plan(load_scene(None, {"bench.part": "scale"}))
    assert list(only) == ["scale"]


@dataclass
class OnePlace:
    """Work that runs a piece after the other, and says where and on how many threads."""

    threads: int | None = 5
    place: str = ""
    log: list = field(default_factory=list)

    def within(self, name):
        return replace(self, place=f"{self.place}{name}/")

    def collect(self, task, pieces, codec, on_result):
        results = [task(piece) for piece in pieces]
        stored = [one if codec.faults(one) else codec.load(codec.store(one)) for one in results]
        self.log.append((self.place, self.threads, [len(codec.faults(one)) for one in results]))
        for one in results:
            on_result(one)
        return stored


@pytest.mark.parametrize("part", ["precision", "stability", "scale", "validation"])
def test_a_piece_that_raises_has_a_row_of_precision_alone(monkeypatch, part):
    """The others stay, in their order; on one thread, whatever the run has."""
    columns = bench.PARTS[part].__dataclass_fields__

    class Piece:
        scene, case, setting = "my problem", "my case", Made(method="core", setting="tol 1e-9")

        def __init__(self, n):
            self.n = n

        def __str__(self):
            return "my study"

        def row(self, status=""):
            return bench.PARTS[part](*([f"{self.n}{status}"] * len(columns)))

    def measure(piece):
        if piece.n == 1:
            raise RuntimeError("no such orbit")
        return [piece.row()] if part == "validation" else piece.row()

    pieces = [Piece(n) for n in range(3)]
    monkeypatch.setattr(bench, "_part_plan", lambda name, scene: PartPlan(pieces, measure, 1.0))
    work, told = OnePlace(), []
    with gathering() as faults:
        rows = bench._measured(part, None, lambda *given: told.append(given), work)
    assert work.log == [(f"{part}/", 1, [0, 1, 0])]
    assert told == [(part, n, 3) for n in (1, 2, 3)]
    wanted = [pieces[0].row(), pieces[2].row()]
    if part == "precision":
        wanted.insert(1, pieces[1].row(Status.FAULT.text))
    assert rows == wanted
    names = {"precision": "my case, core tol 1e-9", "validation": "my problem"}
    assert [one.piece for one in faults] == [f"{part}: {names.get(part, 'my study')}"]
    assert isinstance(faults[0], PieceFault)


def test_cells_of_a_bench_need_no_quotes():
    assert bench._cell('a, "b"\n  c') == "a; 'b' c"
    assert bench._cell(nan) is None
    assert (bench._cell(0.0), bench._cell(7)) == (0.0, 7)


def test_problems_are_counted_and_not_their_sources():
    def row(problem, quantity, status, source="same"):
        return Made(problem=problem, quantity=quantity, status=status, source=source,
                    published="1.0", ours=2.0, difference=1.0, bound=0.5)  # fmt: skip

    published = bench.published
    rows = [row("a", "x", "ok"), row("a", "y", published.MISPRINT, "other"),
            row("b", "z", published.FAILED), row("c", "w", "ok", "third"),
            row("c", "v", "ok", "fourth")]  # fmt: skip
    record, failures = bench._validation_result(rows)
    assert record == {"problems": 3, "rows": 5, "published_off": ["a: y"], "failed": ["b: z"]}
    assert len(failures) == 1


def test_quick_problems_are_those_that_follow_no_branch_for_long():
    slow = [one.scene for one in validation.PROBLEMS.values() if one not in validation.chosen(True)]
    assert slow == ["dux-orbits", "budd-dux", "shaw-holmes", "cam-follower"]
    assert validation.chosen(False) == list(validation.PROBLEMS.values())


def test_the_seconds_of_a_number_are_those_since_the_one_before(monkeypatch):
    clock = iter([10.0, 10.5, 12.0])
    monkeypatch.setattr(validation, "perf_counter", lambda: next(clock))
    monkeypatch.setattr(validation, "row_of", lambda *given: given)
    problem = Made(source="who", scene="which", claims=lambda problem: iter(["one", "two"]))
    assert validation.measure(problem) == [
        ("one", "who", "which", 0.5), ("two", "who", "which", 1.5)
    ]  # fmt: skip


# --- questions of published problems


@pytest.mark.parametrize("theta", [0.0, 0.7, 2.5])
def test_the_steady_motion_solves_its_equation(theta):
    """m x'' + c x' + k x = a cos(w t), with x'' from the derivative of x'."""
    cam = Made(mass=1.5, stiffness=9.0, follower_damping=0.75, amplitude=2.5, frequency=3.0)
    step = 1e-5
    before, (x, velocity), behind = (problem.steady(cam, theta + d) for d in (-step, 0.0, step))
    rate = cam.frequency / (2.0 * step)
    assert velocity == pytest.approx((behind[0] - before[0]) * rate, abs=1e-8)
    acceleration = (behind[1] - before[1]) * rate
    force = cam.mass * acceleration + cam.follower_damping * velocity + cam.stiffness * x
    assert force == pytest.approx(cam.amplitude * cos(theta), abs=1e-7)


def test_the_rows_that_a_problem_asks_for(monkeypatch):
    """Of branches those of a label, of events the first of a kind, a label and a corner."""
    scenes = []
    table = {"label": ["P(1;1)", "P(2;1:1)", "P(1;1)"], "q_m": [0.5, 0.25, 0.125]}
    events = {"kind": ["fold", "corner-impact", "corner-impact", "corner-impact"],
              "label": ["P(1;1)"] * 4, "corner": ["", "a", "b", "b"],
              "rpm": [1.0, 2.0, 3.0, 4.0]}  # fmt: skip
    result = Made(tables={"branch": table, "bifurcations": events})
    monkeypatch.setattr("camcli.api.orbits.orbits", lambda scene: scenes.append(scene) or result)
    assert problem.rows_of(table)[1] == {"label": "P(2;1:1)", "q_m": 0.25}
    assert [row["q_m"] for row in problem.found_orbits("one")] == [0.5, 0.25, 0.125]
    assert [row["q_m"] for row in problem.found_orbits("two", "P(1;1)")] == [0.5, 0.125]
    rows = problem.bifurcations("three")
    assert scenes == ["one", "two", "three"]
    assert problem.event(rows, "corner-impact", "P(1;1)", "b")["rpm"] == 3.0
    assert problem.event(rows, "fold", "P(1;1)")["rpm"] == 1.0
    assert [problem.one_impact_in(turns) for turns in (1, 3)] == ["P(1;1)", "P(3;1:0:0)"]
    assert problem.vary("cam.lift", 0.5, 0.75) == {
        "orbits.vary": [{"key": "cam.lift", "start": 0.5, "stop": 0.75, "num": 5}]
    }


def test_problems_are_registered_with_their_scenes():
    problems = []
    register = problem.register_in(problems, "siconos-ball", "who", quick=True)
    claims = register(lambda one: iter([one.scene]))
    (one,) = problems
    assert (one.scene, one.source, one.quick, one.claims) == ("siconos-ball", "who", True, claims)
    assert list(one.claims(one)) == ["siconos-ball"]
    assert one.loaded({"run.rpm": 7.5}).run.rpm == 7.5
    assert one.loaded().follower.restitution == 0.9
    assert not problem.Problem("x", "y", claims, False).quick


def test_a_check_is_entered_by_its_number(monkeypatch):
    monkeypatch.setattr(stability, "ROWS", {})
    check = stability.row(7, "what it is", "what it sees")(str)
    assert check is str
    (entered,) = stability.ROWS.items()
    assert entered == (7, stability.Row("7: what it is", "what it sees", str))


def test_claims_of_a_ball_count_its_impacts_from_one(monkeypatch):
    """Four roundings for each flight so far, of the time and of the speed."""
    events = {"event": ["impact", "chatter", "impact", "detachment"], "t_s": [0.5, 0.75, 2.0, 3.0],
              "u_plus_m_per_s": [4.0, 0.0, -3.0, 1.0]}  # fmt: skip
    monkeypatch.setattr(
        "camcli.api.simulate.simulate", lambda scene: Made(tables={"events": events})
    )
    found = balls.impacts(Made(loaded=lambda: "scene"))
    assert found == [(0.5, 4.0), (2.0, -3.0)]
    printed = {2: ("2.00", "2.0001"), 1: ("0.50", "0.5001")}
    for of, name, ours in ((balls.times, "time of impact", (2.0, 0.5)),
                           (balls.speeds, "velocity after impact", (-3.0, 4.0))):  # fmt: skip
        second, first = of(found, "there", printed)
        for claim, number, own in ((second, 2, ours[0]), (first, 1, ours[1])):
            assert claim.quantity.startswith(f"{name} {number}, ")
            assert (claim.place, claim.ours) == ("there", own)
            assert (claim.published, claim.independent) == printed[number]
            assert claim.error == pytest.approx(4.0 * 2.0**-52 * number * abs(own))
    assert balls._rests_from("scene") == 0.75
    assert balls._rpm_of_gamma(4.0) == pytest.approx(60.0 / pi)
