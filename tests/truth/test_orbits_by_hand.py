"""What `camcli.orbits` asks its study and its proofs, and what it makes of answers made by hand."""

from __future__ import annotations

from contextlib import contextmanager
from types import SimpleNamespace as Made

import pytest

from camcli.analysis.integrate import BudgetSpentError, Cost
from camcli.analysis.orbits.codim2 import PointProof
from camcli.analysis.orbits.proofs import ProofStep
from camcli.api import orbit_tables, orbits
from camcli.cams.balls import precision
from camcli.errors import SceneError, Status
from camcli.exact.shooting import ProofStep as Step
from camcli.piece_faults import PieceFault, gather, gathering

RPM = 600.0


def fault(name):
    return PieceFault(name, "E", "place", "traceback")


def replaced(one, **more):
    return Made(**{**vars(one), **more})


@pytest.fixture
def asked(monkeypatch):
    """What the parts of `orbits` are asked, by their names; each gives an answer of its own."""
    given = {"budget": Status.OK}

    def part(name, answer=None, fails=()):
        def of(*args, **more):
            given[name] = (args, more) if more else args
            gather(map(fault, fails))
            return answer(*args, **more) if callable(answer) else answer

        monkeypatch.setattr(orbits, name, of)

    @contextmanager
    def budget_of(scene, progress):
        yield Made(status=given["budget"])

    question = Made(plane="plane", span="span", all_of=None, branches=7)
    given["question"] = question
    varied = [Made(name="restitution", key="follower.restitution"), Made(name="rpm", key="")]
    monkeypatch.setattr(orbits, "budget_of", budget_of)
    monkeypatch.setattr(orbits, "replace", replaced)
    part("with_arguments", lambda scene, name, **more: scene)
    part("machine_of", lambda scene: Made(scene=scene, system="plain", settings="settings"))
    part("varied_by", varied)
    part("question_of", question)
    part("with_families", "system")
    part("run", Made(cost=Cost(3, 4), question=question, codim2=[], proofs=None, chaos=None),
         ["the study"])  # fmt: skip
    part("_points", ["points"])
    part("_proved", lambda scene, system, found: (replaced(found, proofs="proofs"), "certificate"))
    part("_with_chaos", lambda machine, found, old: (replaced(found, chaos="chaos"), f"{old} more"))
    part("_view", "view")
    part("_simulated", Made(cost=Cost(50, 60), faults=[fault("simulated")]))
    part("_summary", {"a": 1})
    part("notes_of", [])
    part("_tables", {})
    part("_pictures", {})
    part("proof_files", {"proof.json": "writer"})
    return given


def scene(**section):
    own = {"prove": True, "all": None, "chaos": True, "simulated": 5, "checker": True}
    return Made(orbits=Made(**{**own, **section}), cam=Made(kind="arcs"))


def test_a_study_with_all_that_may_be_asked_beside_it(asked):
    given = scene()
    told = []
    result = orbits.orbits(given, lambda *of: told.append(of), at=700.0, all=(3, 2))
    (of_scene, name), more = asked["with_arguments"]
    assert (of_scene, name) == (given, "orbits")
    assert more == {"at": 700.0, "all": {"impacts": 3, "turns": 2}, "prove": False,
                    "checker": False, "chaos": False}  # fmt: skip
    system, settings, question, on_step = asked["run"]
    assert (system, settings, question) == ("system", "settings", asked["question"])
    on_step()
    assert told == [("branches", 1, 9)]
    assert asked["_points"][0] == "system"
    assert asked["_points"][2:] == ("plane", True)
    assert asked["_proved"][:2] == (given, "system")
    assert asked["_proved"][2].codim2 == ["points"]
    machine, proved, certificate = asked["_with_chaos"]
    assert (machine.system, proved.proofs, certificate) == ("plain", "proofs", "certificate")
    assert asked["_view"][1].chaos == "chaos"
    machine, of_chaos, count = asked["_simulated"]
    assert (machine.system, of_chaos.chaos, count) == ("system", "chaos", 5)
    found = result.values
    assert (found.proofs, found.chaos) == ("proofs", "chaos")
    simulated = asked["_tables"][2]
    keys = {"restitution": "follower.restitution"}
    assert asked["_tables"] == ("system", found, simulated, keys)
    assert asked["_pictures"] == ("system", found, simulated, "view")
    assert asked["_summary"] == (found, "arcs")
    assert asked["proof_files"] == ("certificate more", True)
    assert result.cost == Cost(53, 64)
    assert result.summary == {"status": "ok", "a": 1}
    assert (result.notes, result.complete) == ((), True)
    assert [one.piece for one in result.faults] == ["the study", "simulated"]


def test_a_study_that_is_asked_for_nothing_more(asked):
    """Motions are simulated over a range alone; a budget that is spent is a note."""
    asked["budget"] = Status.WORK_BUDGET
    asked["question"].span = asked["question"].plane = None
    result = orbits.orbits(scene(prove=False, chaos=False))
    left_out = {"_points", "_proved", "_with_chaos", "_view", "_simulated"}
    assert not left_out & asked.keys()
    assert asked["proof_files"] == (None, True)
    assert asked["_pictures"][2:] == (None, None)
    assert result.cost == Cost(3, 4)
    assert result.summary["status"] == "work-budget"
    assert len(result.notes) == 1
    assert not result.complete
    orbits.orbits(scene(prove=False, all="some", chaos=False))
    assert "_proved" in asked


def test_chaos_has_no_picture_where_its_motions_cannot_be_followed(asked, monkeypatch):
    for error, faults in (
        (BudgetSpentError(), []),
        (ValueError("odd"), ["the impacts of chaos.png"]),
    ):

        def view(machine, found, error=error):
            raise error

        monkeypatch.setattr(orbits, "_view", view)
        result = orbits.orbits(scene())
        assert asked["_pictures"][3] is None
        pieces = [one.piece for one in result.faults]
        assert pieces == ["the study", *faults, "simulated"]


@pytest.mark.parametrize("wrong", [5, (1,), (1, 2, 3), "x"])
def test_all_orbits_are_asked_for_by_two_numbers(wrong):
    assert orbits._up_to((3, 2)) == {"impacts": 3, "turns": 2}
    assert orbits._up_to(None) is None
    with pytest.raises(SceneError, match="expected two numbers"):
        orbits._up_to(wrong)


@pytest.mark.parametrize(("all_", "kept"), [(None, True), ("some", False)])
def test_the_certificate_of_the_proofs(monkeypatch, all_, kept):
    """Without a statement it is no file where all orbits were asked for; no evidence is kept."""
    proofs = Made(orbits=[Made(n=1), Made(n=2)])
    proofs.without_evidence = None
    statements = []

    def prove(system, found):
        return proofs

    def certificate(found, formula, strobe, named):
        statements.append((found, formula, strobe))
        return {"statements": found.statements}

    of = "camcli.analysis.orbits"
    monkeypatch.setattr(f"{of}.proofs.prove", prove)
    monkeypatch.setattr(f"{of}.certificate.certificate", certificate)
    monkeypatch.setattr("camcli.cams.formula.formula_of", lambda *given: given)
    monkeypatch.setattr(orbits, "_starts", lambda scene, system, orbit, proof: (orbit, proof.n))
    monkeypatch.setattr(orbits, "_curve_ranges", lambda system, found: ["a range"])

    def replace(one, **more):
        new = replaced(one, **more)
        if hasattr(one, "without_evidence"):
            new.without_evidence = lambda: ("without evidence", new)
        return new

    monkeypatch.setattr(orbits, "replace", replace)
    system = Made(shape="shape", follower=Made(seat_restitution=0.25))
    own = Made(orbits=Made(all=all_), run=Made(strobe_deg=35.0))
    found = Made(orbits=["first", "second"], statements=[])
    study, content = orbits._proved(own, system, found)
    ((certified, formula, strobe),) = statements
    assert (formula, strobe) == (("shape", 0.25), 35.0)
    assert [one.starts for one in certified.proofs.orbits] == [("first", 1), ("second", 2)]
    assert certified.proofs.curve_ranges == ["a range"]
    words, last = study.proofs
    assert (words, last) == ("without evidence", certified.proofs)
    assert content == ({"statements": []} if kept else None)
    found.statements = ["one"]
    assert orbits._proved(own, system, found)[1] == {"statements": ["one"]}


def test_points_that_are_found_when_the_budget_is_spent_stay(monkeypatch):
    """A proof that an exception has cost is one that failed in a fault."""
    of = "camcli.analysis.orbits.codim2"

    def add_points(system, curves, plane, points):
        points += [Made(kind=kind, first=1.0, second=2.0) for kind in ("cusp", "fold-flip")]
        raise BudgetSpentError

    def prove(point):
        if point.kind == "cusp":
            raise ValueError("odd")
        return "a proof"

    monkeypatch.setattr(f"{of}.add_points", add_points)
    monkeypatch.setattr(f"{of}.prove", prove)
    monkeypatch.setattr(orbits, "replace", replaced)
    found = Made(curves="curves")
    assert [hasattr(one, "proof") for one in orbits._points(None, found, None, False)] == [
        False
    ] * 2
    with gathering() as faults:
        first, second = orbits._points(None, found, None, True)
    assert (first.proof, second.proof) == (PointProof(Step.FAULT), "a proof")
    assert [one.piece for one in faults] == ["the proof of the cusp at 1.0, 2.0"]


@pytest.mark.parametrize("formula", [None, "formula"])
def test_chaos_is_proved_for_a_cam_with_a_formula(monkeypatch, formula):
    asked = []

    def chaos_at(*given):
        asked.append(given)
        raise ValueError("odd")

    monkeypatch.setattr("camcli.analysis.chaos.study.chaos_at", chaos_at)
    seats = []
    monkeypatch.setattr(
        "camcli.cams.formula.formula_of", lambda shape, seat: seats.append(seat) or formula
    )
    monkeypatch.setattr(orbits, "replace", replaced)
    system = Made(shape=None, follower=Made(seat_restitution=0.25))
    machine = Made(system=system, settings="settings")
    found = Made(question=Made(rpm=RPM), orbits=["orbit"])
    with gathering():
        study, certificate = orbits._with_chaos(machine, found, None)
    assert asked == [(system, "settings", ["orbit"], RPM, formula is not None)]
    assert (seats, certificate) == ([0.25], None)
    assert (study.chaos.rpm, study.chaos.step) == (RPM, ProofStep.FAULT)


def test_starts_are_counted_in_the_digits_of_the_proof(monkeypatch):
    from flint import ctx

    from camcli.analysis.orbits.proofs import DIGITS

    monkeypatch.setattr("camcli.analysis.orbits.starts.starts", lambda *given: ctx.dps)
    with precision(DIGITS[0]):
        wanted = ctx.dps
    basins = Made(basins=Made(q=(0.1, 0.9), v=(-20.0, 40.0)))
    orbit = Made(rpm=RPM, label="P(1;1)")
    proof = Made(evidence="evidence", axes=["axes"])
    with precision(3 * DIGITS[0]):
        assert orbits._starts(basins, Made(strobe=0.5), orbit, proof) == wanted


def test_tables_of_orbits_are_those_that_were_asked_for(monkeypatch):
    """The column of simulated motions is the key of the scene, or the usual one."""

    def table(name):
        def of(*given):
            if "broken" in given:
                raise ValueError("odd")
            return (name, *given)

        return of

    for name in (
        "branch_table",
        "bifurcations_table",
        "curve_table",
        "codim2_table",
        "chaos_table",
    ):
        monkeypatch.setattr(orbits, name, table(name))
    monkeypatch.setattr(orbits, "SharedRows", lambda *given: Made(table=lambda *of: of))
    monkeypatch.setattr(orbits, "piece", lambda name, make: (name, make()))
    keys = {"cam.lift": "cam.lift"}
    system = Made(region_names="regions")
    result = Made(
        question=Made(plane=None), curves="curves", codim2="points", proofs=None, chaos=None
    )
    bare = orbits._tables(system, result, None, keys)
    assert bare == {
        "branch": ("branch.csv", ("branch_table", result, keys)),
        "bifurcations": ("bifurcations.csv", ("bifurcations_table", result, keys)),
    }
    result.question.plane, result.chaos = "plane", "chaos"
    more = orbits._tables(system, result, Made(key="restitution"), keys)
    assert list(more) == ["branch", "bifurcations", "impacts", "strobe", "curve", "codim2", "chaos"]
    assert more["curve"][1] == ("curve_table", "curves", "plane", keys, None, None)
    assert more["codim2"][1] == ("codim2_table", "points", "plane", keys, False)
    assert more["chaos"][1] == ("chaos_table", "chaos", "regions")
    assert [more[name][1][1][0] for name in ("impacts", "strobe")] == ["restitution"] * 2
    result.proofs = Made(curve_ranges=["range"])
    proved = orbits._tables(system, result, Made(key="cam.lift"), keys)
    assert proved["curve"][1] == ("curve_table", "curves", "plane", keys, result.proofs, ["range"])
    assert proved["codim2"][1][-1] is True
    assert proved["impacts"][1][1][0] == "cam.lift"
    monkeypatch.setattr(orbits, "piece", lambda name, make: None if name == "branch.csv" else 1)
    assert "branch" not in orbits._tables(system, result, None, keys)


# --- tables


def orbit(n, impacts, **more):
    own = {
        "label": f"label {n}", "rpm": RPM, "stable": n % 2 == 0, "value": 0.5 + 0.01 * n,
        "theta": [0.1 * (k + 1) for k in range(impacts)],
        "regions": [f"A{k}" for k in range(impacts)],
        "rates": [0.01 * (k + 1) for k in range(max(impacts - 1, 0))],
        "states": [(0.1 * n, 0.25)], "multipliers": (0.5, -0.25), "trace": 0.25, "det": -0.125,
    }  # fmt: skip
    return Made(**{**own, **more})


@pytest.mark.parametrize("most", [0, 1, 3])
def test_the_table_of_orbits_at_one_speed(most):
    """Branch 0, without a course; a column each for the phase of an impact and for its speed.

    Departures are phases without a speed. The parameter, without a key, stands behind det.
    """
    found = [orbit(1, min(most, 1)), orbit(2, most)]
    proofs = Made(orbits=[Made(proved=True), Made(proved=False)], points=[])
    result = Made(question=Made(parameter="restitution", span=None), orbits=found, branches=[],
                  bifurcations=[], proofs=proofs)  # fmt: skip
    table = orbit_tables.branch_table(result, {})
    names = list(table.columns)
    assert names[names.index("det") + 1] == "restitution"
    assert table["restitution"].tolist() == pytest.approx([0.51, 0.52])
    assert table["branch"].tolist() == [0, 0]
    assert [":".join(one.regions) for one in found] == table["region"].tolist()
    assert table["proved"].tolist() == ["yes", "no"]
    room = max(most, 1)
    thetas = [name for name in names if name.startswith("theta_deg_")]
    speeds = [name for name in names if name.startswith("u_minus_m_per_s_")]
    assert (len(thetas), len(speeds)) == (room, room)
    for n, own in enumerate(found):
        filled = [table[name].tolist()[n] for name in (*thetas, *speeds)]
        known = [value == value for value in filled]
        impacts, rates = len(own.theta), len(own.rates)
        assert known == [k < impacts for k in range(room)] + [k < rates for k in range(room)]
    course = names[names.index(speeds[-1]) + 1 : -1]
    assert len(course) == 3
    for name in course:
        assert all(value != value for value in table[name].tolist())


def test_a_point_of_a_curve_that_is_not_proved_has_no_enclosures():
    values = [1.5, 2.5]
    for proof in (Made(proved=False, low=1.0, high=2.0), Made(proved=True, low=None, high=2.0),
                  Made(proved=True, low=1.0, high=None)):  # fmt: skip
        assert orbit_tables._curve_proof_cells(proof, 0, values) == ["no"] + [None] * 4
    assert values == [1.5, 2.5]
    proved = Made(proved=True, low=3.0, high=4.0)
    assert orbit_tables._curve_proof_cells(proved, 1, values) == ["yes", 1.5, 1.5, 3.0, 4.0]
    assert values == [1.5, 3.0]


def test_proofs_stand_in_the_rows_of_branches():
    """Over a range the orbits that branches begin with have no rows; points have, in order."""
    points = [[orbit(1, 2), orbit(2, 2)], [orbit(3, 1)]]
    branches = [
        Made(number=k, points=own, turning_points=[], stable_stretches=lambda events: [])
        for k, own in enumerate(points, 4)
    ]
    proofs = Made(orbits=[Made(proved=True)], points=[[Made(proved=False), Made(proved=True)],
                                                      [Made(proved=False)]])  # fmt: skip
    result = Made(question=Made(parameter="restitution", span="span"), orbits=[orbit(9, 1)],
                  branches=branches, bifurcations=[], proofs=proofs)  # fmt: skip
    table = orbit_tables.branch_table(result, {"restitution": "follower.restitution"})
    assert table.columns[0] == "follower.restitution"
    assert table["branch"].tolist() == [4, 4, 5]
    assert table["proved"].tolist() == ["no", "yes", "no"]
    assert table["follower.restitution"].tolist() == pytest.approx([0.51, 0.52, 0.53])


def test_the_column_of_a_key_is_the_whole_key_its_last_name_or_that_with_a_unit(tmp_path):
    place = orbit_tables._place_of
    header = ["mass", "follower.mass", "preload_factor_n", "preload_n"]
    assert place("follower.mass", header[1:]) == 0
    assert place("follower.mass", header) == 0
    assert place("follower.preload", header) == 2
    with pytest.raises(orbit_tables.ColumnMissingError):
        place("follower.mas", header)
    path = tmp_path / "table.csv"
    path.write_text("rpm,stable,theta_deg,q_m\n1,1,2,3\n2,1,x,4\n")
    with pytest.raises(SceneError) as caught:
        orbit_tables.read_branches(path, "rpm")
    (fault_of_file,) = caught.value.faults
    assert fault_of_file.path == f"{path}:3"
    path.write_text("curve,kind,rpm,mass\n")
    with pytest.raises(SceneError, match="found no column follower"):
        orbit_tables.read_curves(path, ("follower.mass", "follower.stiffness"))
