"""Orbits as they are told: their turns, states and constants; what is asked of them all."""

from __future__ import annotations

from dataclasses import replace
from math import exp, inf, pi
from types import SimpleNamespace as Stub

import pytest
from flint import arb, arb_mat

from camcli.analysis.integrate import BudgetSpentError, Cost
from camcli.analysis.labels import Label
from camcli.analysis.orbits import all_orbits, curve_proofs, orbit, shooter, study
from camcli.analysis.orbits.arclength import Span
from camcli.analysis.orbits.curve_proofs import CurveRange
from camcli.analysis.orbits.orbit import PeriodicOrbit
from camcli.analysis.orbits.search import OrbitsFound
from camcli.analysis.orbits.shooter import Root, Shooter
from camcli.analysis.orbits.study import Absence, Branch, OrbitsQuestion
from camcli.errors import Status
from camcli.exact.shooting import NotProvedError, ProofStep
from camcli.kernel.certify import Verdict
from camcli.kernel.flow import AS_ON_THE_CAM
from camcli.quantities import PARAMETERS
from camcli.system import CONSTANTS, Follower

TURN = 2.0 * pi
NAMES = tuple(PARAMETERS)


def root_of(impacts, value=700.0, turns=3, **more) -> Root:
    """A root from (phase, rate, stretch, turn) of each impact."""
    x = [number for theta, v, _, _ in impacts for number in (theta, v)]
    whole = tuple(number for _, _, stretch, turn in impacts for number in (stretch, turn))
    given = {
        "machine": (value, 9.0), "rates": [-2.0 * v for _, v, _, _ in impacts],
        "tangent": [1.0] * (len(x) + 1), "trace": 0.5, "step": 0.0, "steps": 2, "parameter": 0,
    }  # fmt: skip
    return Root([*x, value], whole, turns, **{**given, **more})


# -- roots


THREE = [(1.0, 0.5, 2, 0), (4.0, 0.25, 3, 0), (0.5, 0.125, 4, 2)]


def test_a_flight_goes_from_an_impact_to_the_next_one():
    """After the last one comes the first again, a period later."""
    root = root_of(THREE)
    lengths = [root.flight_length(k) for k in range(3)]
    assert lengths == pytest.approx([3.0, 2.0 * TURN - 3.5, TURN + 0.5])
    assert root_of(THREE[:1]).flight_length(0) == pytest.approx(3.0 * TURN)
    assert (root.count, root.value, root.theta) == (3, 700.0, [1.0, 4.0, 0.5])
    assert [root.stretch(k) for k in range(3)] == [2, 3, 4]
    assert [root.turn(k) for k in range(3)] == [0, 0, 2]
    assert root.landing_on(1, 7, 8).whole == (2, 0, 7, 8, 4, 2)
    assert root.landing_on(1, 7, 8).x == root.x


def test_a_determinant_is_what_impacts_and_damping_leave(monkeypatch):
    """r^2 of each impact, of the seat where it lands on one, and exp(-2 Z s) of its three turns."""
    const = Stub(Z=0.0625, r=0.5, r_seat=0.25)
    monkeypatch.setattr(
        shooter, "constants_of", lambda *of: const if of == ((700.0, 9.0), 0.0, 0) else None
    )
    for seat, factor in ((frozenset(), 0.25**3), (frozenset({3}), 0.25 * 0.0625 * 0.25),
                         (frozenset({0, 2}), 0.25**2 * 0.0625)):  # fmt: skip
        root = root_of(THREE, seat=seat)
        assert root.det == pytest.approx(factor * exp(-0.125 * 3.0 * TURN))


def table(**more):
    known = dict(zip(NAMES, (700.0, 1.0, 2.0, 0.5, 9.5, 4.0, 0.75, 0.25), strict=True))
    return tuple({**known, **more}.values())


@pytest.mark.parametrize("seat", [0.25, AS_ON_THE_CAM])
@pytest.mark.parametrize("family", [False, True])
def test_a_machine_has_the_constants_of_its_table(seat, family):
    """In a family it is the member that the values behind the constants name."""
    machine = (*table(seat_restitution=seat), *([3.0, 4.0] if family else []))
    follower = Follower(mass=9.0, stiffness=9.0)
    asked = []

    @study.dataclass(frozen=True)
    class Made:
        follower: Follower
        member: object

        def at(self, of):
            asked.append(of)
            return replace(self, member="moved")

        def with_follower(self, **changes):
            return replace(self, follower=replace(self.follower, **changes))

    found, rpm = shooter.with_machine(Made(follower, "member" if family else None), machine)
    assert rpm == 700.0
    wanted = {name: value for name, value in zip(NAMES, table(), strict=True) if name != "rpm"}
    wanted["seat_restitution"] = None if seat == AS_ON_THE_CAM else 0.25
    assert {name: getattr(found.follower, name) for name in wanted} == wanted
    assert (found.member, asked) == (("moved", [machine]) if family else (None, []))


def test_a_number_of_a_family_moves_all_that_follows_from_it():
    moved = []

    def follow(values, numbers):
        moved.append((list(values), list(numbers)))
        return ("moved", *values)

    family = Stub(names=("cam.lift", "cam.base"), moved=follow)
    system = Stub(member=Stub(family=family))
    machine = (*range(CONSTANTS), 20.0, 30.0)
    assert shooter.place_of(system, "cam.base") == CONSTANTS + 1
    assert shooter.place_of(system, "stiffness") == 2
    found = shooter.machine_at(system, machine, "cam.lift", 25.0)
    values = [*range(CONSTANTS), 25.0, 30.0]
    assert found == ("moved", *values)
    assert moved == [(values, [25.0, 30.0])]
    found = shooter.machine_at(system, machine, "mass", 7.0)
    assert found == (0, 7.0, *machine[2:])
    assert len(moved) == 1


def test_a_machine_without_a_family_has_no_numbers_behind_its_constants():
    system = Stub(member=None, machine=lambda rpm: (rpm, 1.0))
    assert shooter.table_of(system, 650.0) == (650.0, 1.0)
    assert shooter.machine_at(system, (650.0, 1.0), "mass", 2.0) == (650.0, 2.0)
    of_family = Stub(member=Stub(values=(3.0, 4.0)), machine=lambda rpm: (rpm, 1.0))
    assert shooter.table_of(of_family, 650.0) == (650.0, 1.0, 3.0, 4.0)


def bare_shooter(**more) -> Shooter:
    made = Shooter.__new__(Shooter)
    made.__dict__.update(more)
    return made


def test_the_work_of_a_shooter_is_that_of_its_flights_and_of_its_motions(monkeypatch):
    tally = Stub(evaluations=70, crossings=8)
    monkeypatch.setattr(shooter, "row_of", lambda kind, row: tally if row == "row" else None)
    records = iter([Stub(cost=Cost(1, 20, 300)), Stub(cost=Cost(2, 30, 400))])
    monkeypatch.setattr(
        shooter, "Orbit",
        lambda *of: Stub(run=lambda: next(records)) if of == ("s", 1.0, "set", "start") else None,
    )  # fmt: skip
    made = bare_shooter(simulated=Cost(), _works=["row"])
    first = made.simulate("s", 1.0, "set", "start")
    assert first.cost == Cost(1, 20, 300)
    made.simulate("s", 1.0, "set", "start")
    assert made.simulated == Cost(3, 50, 700)
    assert made.cost == Cost(3, 120, 708)


@pytest.mark.parametrize("family", [False, True])
def test_a_verdict_is_on_the_cam_of_the_root_and_its_flights_are_counted_once(monkeypatch, family):
    spent, tally, asked = [], Stub(evaluations=5), []
    monkeypatch.setattr(shooter, "spend", spent.append)
    monkeypatch.setattr(shooter, "row_of", lambda kind, row: tally)

    def certify(*of):
        asked.append(of)
        tally.evaluations += 10
        return 3.0

    made = bare_shooter(
        _room=lambda n: Stub(place=[1.0, 2.5]) if n == 3 else None, _kernel_cam="own",
        family="family" if family else None, kernel=Stub(certify_orbit=certify),
        _table=lambda values, kind=float: (kind, list(values)), _flows="flows", _works=["row"],
        _spent=5,
    )  # fmt: skip
    made.system_of = lambda root: Stub(cam_for=lambda kernel: ("cam", kernel))
    root = root_of(THREE)
    for _ in range(2):
        assert made.verdict(root) == (3, 1, 2.5)
        assert isinstance(made.verdict(root)[0], int)
    assert spent == [400 * 10] * 4
    cam = ("cam", made.kernel) if family else "own"
    assert asked[0] == (
        cam, (float, [700.0, 9.0]), 3, 3, (int, list(root.whole)), (float, root.x),
        (float, root.rates), "flows", [1.0, 2.5], ["row"],
    )  # fmt: skip


def test_impacts_off_their_stretches_are_told_with_how_far(monkeypatch):
    stretches = {
        2: Stub(start=1.0, end=2.0),
        3: Stub(start=3.0, end=3.5),
        4: Stub(start=0.75, end=5),
    }
    made = bare_shooter()
    made.system_of = lambda root: Stub(cam=Stub(stretches=stretches))
    assert made.beyond(root_of(THREE)) == [(0.5, 1, 1), (0.25, 2, -1)]
    at_ends = [(2.0, 0.5, 2, 0), (3.0, 0.5, 3, 0), (0.75, 0.5, 4, 0)]
    assert made.beyond(root_of(at_ends)) == []
    root = root_of(THREE)
    assert [made.edge(root, 1, side) for side in (1, -1)] == [3.5, 3.0]


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("family", [False, True])
def test_a_root_at_a_corner_has_its_impact_there(monkeypatch, side, family):
    root = root_of(THREE)
    edge = 3.5 if side > 0 else 3.0
    solved = []
    monkeypatch.setattr(shooter, "on_edge", lambda *of: ("on edge", *of))
    made = bare_shooter(
        family=Stub(correct=lambda *of: (solved.append(of), "solved")[1]) if family else None,
        cam=Stub(stretches={3: Stub(start=3.0, end=3.5)}),
    )
    made.edge = lambda one, k, of: edge if (one, k, of) == (root, 1, side) else None
    made.correct = lambda *of: (solved.append(of), "root")[1]
    made._as_root = lambda *of: of
    found = made.at_corner(root, 1, side)
    x = [1.0, 0.5, edge, 0.25, 0.5, 0.125, 700.0]
    if family:
        assert solved == [(x, root.whole, 3, ("on edge", 1, 3, side))]
        assert found == ("solved", root.whole, 3)
    else:
        row = [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0]
        assert solved == [(x, root.whole, 3, row, x)]
        assert found == "root"
    assert root.x[2] == 4.0


def test_a_root_is_moved_to_a_value_that_is_kept(monkeypatch):
    asked = []
    made = bare_shooter(machine=(9.0,), parameter=0)
    made.correct = lambda *of: (asked.append(of), "root")[1]
    root = root_of(THREE)
    assert made.moved(root, 650.0) == "root"
    x = [*root.x[:-1], 650.0]
    assert asked == [(x, root.whole, 3, [0.0] * 6 + [1.0], x)]


@pytest.mark.parametrize("compiled", [True, False])
@pytest.mark.parametrize("status", [Status.OK, Status.NO_RETURN])
def test_newtons_steps_are_counted_for_each_impact_also_where_they_fail(
    monkeypatch, compiled, status
):
    """A root is what the kernel leaves in the tables that it is given."""
    spent, plain, asked = [], [], []
    monkeypatch.setattr(shooter, "spend", spent.append)
    monkeypatch.setattr(shooter.backend, "count_plain_newton", plain.append)
    room = Stub(out=[9.0] * 3, rates=[-1.0, -2.0], tables=Stub(tangent=[0.5] * 5))

    def correct(*of):
        asked.append(of)
        x, out = of[6], of[-1]
        assert out[shooter.STEPS_TAKEN] == 0.0
        x[0], of[1][0] = 1.25, 650.0
        out[shooter.TRACE], out[shooter.STEP], out[shooter.STEPS_TAKEN] = 0.75, 1e-15, 4.0
        return status

    made = bare_shooter(
        family=None, machine=(700.0, 9.0), parameter=0, scale=0.5, zero_rate=0.125,
        kernel=Stub(compiled=compiled, correct_orbit=correct), seat=frozenset({3}),
        _table=lambda values, kind=float: list(values), _kernel_cam="cam",
        _room=lambda n: room if n == 2 else None,
    )  # fmt: skip
    guess = [1.0, 0.5, 4.0, 0.25, 700.0]
    found = made.correct(guess, (2, 0, 3, 1), 3, "row", "origin", 0.375)
    assert spent == [600 * 8]
    assert plain == ([] if compiled else [8])
    cam, _, parameter, n, turns, whole, _, ends, rates, tables, _ = asked[0]
    assert (cam, parameter, n, turns, whole) == ("cam", 0, 2, 3, [2, 0, 3, 1])
    assert ends == shooter.Border(list("row"), list("origin"), 0.375, 0.5, 0.125)
    assert (rates, tables) == (room.rates, room.tables)
    assert guess[0] == 1.0
    assert made.machine == (700.0, 9.0)
    if status != Status.OK:
        assert found is None
        return
    assert found == Root(
        [1.25, *guess[1:]], (2, 0, 3, 1), 3, (650.0, 9.0), 0, [-1.0, -2.0], [0.5] * 5, 0.75, 1e-15,
        4, frozenset({3}),
    )  # fmt: skip


# -- orbits


def section(monkeypatch, impacts, turns, strobe=2.0):
    """States and symbols of a flight that keeps its height and its velocity, less its angle."""
    monkeypatch.setattr(orbit, "lift", lambda cam, i, theta: (10.0 * i, theta, 0.0))
    monkeypatch.setattr(orbit, "move", lambda const, q, w, s: (q, w - s))
    monkeypatch.setattr(shooter, "constants_of", lambda *of: "const")
    system = Stub(strobe=strobe, at=lambda machine: Stub(cam="cam"))
    return orbit.section_states(system, root_of(impacts, turns=turns))


def test_states_at_the_strobe_are_those_of_the_flights_that_pass_it(monkeypatch):
    """The strobe is at 2 rad; an impact at it belongs to the turn that begins there."""
    impacts = [(1.0, 0.5, 1, 0), (2.0, 0.25, 2, 1), (4.0, 0.125, 3, 1)]
    states, symbols = section(monkeypatch, impacts, 3)
    # the first one lies before the first strobe, at the end of the period
    assert symbols == [0.0, 2.0, 1.0]
    assert states == [
        (10.0, pytest.approx(1.0 + 0.5 - 1.0)), (20.0, pytest.approx(2.0 + 0.25)),
        (30.0, pytest.approx(4.0 + 0.125 - (TURN - 2.0))),
    ]  # fmt: skip
    states, symbols = section(monkeypatch, [(4.0, 0.5, 1, 0)], 2)
    assert symbols == [1.0, 0.0]
    assert states == [(10.0, pytest.approx(4.5 - (2.0 * TURN - 2.0))),
                      (10.0, pytest.approx(4.5 - (TURN - 2.0)))]  # fmt: skip
    later = [(3.0, 0.5, 1, 3), (4.0, 0.5, 1, 3), (1.0, 0.5, 1, 5)]  # a period later, and two
    assert section(monkeypatch, later, 2)[1] == [1.0, 2.0]
    at_the_end = [(0.0, 0.5, 1, 0), (TURN, 0.5, 1, 1)]  # of the period, which is its beginning
    assert section(monkeypatch, at_the_end, 2, strobe=0.0)[1] == [2.0, 0.0]


@pytest.mark.parametrize("first", [0, 1, 2])
def test_an_orbit_begins_with_the_turn_that_names_it(monkeypatch, first):
    """Everything that has an order is turned with it: states, symbols, and impacts in time."""
    states = [(0.0, 1.0), (2.0, 3.0), (4.0, 5.0)]
    symbols = [1.0, 2.0, 0.0]
    root = root_of(THREE)
    monkeypatch.setattr(orbit, "section_states", lambda *of: (states, symbols))
    monkeypatch.setattr(orbit, "_first_turn", lambda *of: first if of == (symbols, states) else 9)
    monkeypatch.setattr(orbit, "_since_strobe", lambda *of: [(0.1, 2), (0.2, 0), (0.3, 1)])
    monkeypatch.setattr(shooter, "constants_of", lambda *of: Stub(Z=0.0, r=0.5, r_seat=0.5))
    names = {2: "A2", 3: "A3", 4: "A4"}
    system = Stub(at=lambda machine: Stub(region_names=names) if machine == (700.0, 9.0) else None)
    made = orbit.from_root(system, root, Verdict.EARLY)
    order = {0: [2, 0, 1], 1: [0, 1, 2], 2: [2, 0, 1]}[first]
    assert made.theta == tuple(root.theta[k] for k in order)
    assert made.rates == tuple(root.rates[k] for k in order)
    assert made.regions == tuple(f"A{root.stretch(k)}" for k in order)
    assert made.symbols == (*symbols[first:], *symbols[:first])
    assert made.states == (*states[first:], *states[:first])
    assert (made.rpm, made.value, made.turns, made.trace) == (700.0, 700.0, 3, 0.5)
    assert (made.det, made.verdict, made.root) == (0.5**6, Verdict.EARLY, root)


@pytest.mark.parametrize("first", [0, 1, 2])
def test_an_orbit_that_rests_leaves_the_cam_in_the_order_of_its_turns(monkeypatch, first):
    states = [(0.0, 1.0), (2.0, 3.0), (4.0, 5.0)]
    symbols = [1.0, inf, 0.0]
    leaves = [(0, 1.0), (1, 2.0), (1, 3.0), (2, 0.5)]
    monkeypatch.setattr(orbit, "_first_turn", lambda *of: first)
    monkeypatch.setattr(orbit, "stretch_at", lambda cam, theta: theta)
    system = Stub(cam="cam", region_names={theta: f"A{theta}" for _, theta in leaves})
    made = orbit.resting_orbit(system, 650.0, states, symbols, leaves)
    turns = [0, 1, 2, 0, 1, 2][first : first + 3]
    theta = tuple(of for turn in turns for number, of in leaves if number == turn)
    assert made.theta == theta
    assert made.regions == tuple(f"A{of}" for of in theta)
    assert made.symbols == tuple(symbols[turn] for turn in turns)
    assert made.states == tuple(states[turn] for turn in turns)
    assert (made.rpm, made.value, made.turns, made.resting) == (650.0, 650.0, 3, True)
    assert (made.trace, made.det) == (0.0, 0.0)


@pytest.mark.parametrize(("resting", "theta", "symbols", "label"), [
    (True, (), (0.0,), "contact"), (True, (1.0,), (0.0,), "P(1;0)"), (True, (), (2.0,), "P(1;2)"),
    (False, (), (0.0,), "P(1;0)"),
])  # fmt: skip
def test_only_an_orbit_that_stays_on_the_cam_is_contact(resting, theta, symbols, label):
    made = PeriodicOrbit(700.0, 700.0, 1, symbols, ((0.0, 0.0),), theta, resting=resting)
    assert made.label == label
    assert made.free is (not resting and not theta)


@pytest.mark.parametrize(("height", "starts", "highest", "is_free"), [
    (2.5, (1.0, 2.0), 2.25, True), (2.5, (1.0, 2.6), 2.25, False), (2.5, (1.0, 2.0), 2.5, False),
    (2.5, (1.0, 2.0), 2.6, False), (2.5, (1.0, 2.5), 2.25, False),
])  # fmt: skip
def test_a_follower_that_never_lands_stands_at_its_balance(
    monkeypatch, height, starts, highest, is_free
):
    follower = Stub(stiffness=4.0, mass=2.0, gravity=8.0, preload=-16.0 - 4.0 * height)
    cam = Stub(stretches=[Stub(start_c=c) for c in starts])
    asked = []
    system = Stub(
        follower=follower, cam=cam,
        constants=lambda rpm, *of: asked.append(rpm) or Stub(W2=0.5, Z=0.0625),
    )  # fmt: skip
    monkeypatch.setattr(orbit, "_highest", lambda of: highest)
    monkeypatch.setattr(orbit, "flow", lambda const, s: (9.0, 0.25, 3.0) if s == TURN else None)
    made = orbit.free_orbit(system, 650.0)
    if not is_free:
        assert made is None
        return
    assert (made.states, made.symbols, made.turns) == (((2.5, 0.0),), (0.0,), 1)
    assert made.trace == 1.0 - 0.5 * 3.0 + 0.25
    assert made.det == pytest.approx(exp(-0.125 * TURN))
    assert (made.rpm, made.value) == (650.0, 650.0)
    follower.stiffness = 0.0
    assert orbit.free_orbit(system, 650.0) is None


# -- what is asked of all orbits


def asked_of(monkeypatch, question, found=None, absence=None, limits=(), spent=False):
    """The result of a study whose parts are stand-ins, and what these were asked."""
    calls = Stub(work=[], found=[], followed=[], absence=[])
    found = found or OrbitsFound(cost=Cost(1, 2, 3))

    def find(*of):
        calls.found.append(of)
        return found

    def absent(*of):
        calls.absence.append(of)
        return absence

    def follow_all(*of):
        calls.followed.append(of)
        if spent:
            raise BudgetSpentError

    made = Stub(value=0.5, cost=Cost(10, 20, 30))
    shooters = []
    monkeypatch.setattr(study, "Shooter", lambda *of: (shooters.append(of), made)[1])
    monkeypatch.setattr(study.backend, "for_work", lambda *of: calls.work.append(of))
    monkeypatch.setattr(study, "find", find)
    monkeypatch.setattr(study, "_absence", absent)
    monkeypatch.setattr(study, "_with_machines", lambda of, span: (("within", span), limits))
    monkeypatch.setattr(study, "_follow_all", follow_all)
    monkeypatch.setattr(study, "_curves", lambda *of: of)
    result = study.orbits("system", Stub(transient=30), question, "tick")
    calls.shooter = shooters[0]
    return result, calls


def of_label(label="P(1;1)", stable=True, rpm=650.0):
    return Stub(label=label, stable=stable, rpm=rpm)


LABEL = Label((1.0, 0.0))


@pytest.mark.parametrize("spent", [False, True])
@pytest.mark.parametrize(("label", "starts", "work"), [(None, 24, 25), (LABEL, 24, 65),
                                                        (LABEL, 90, 91)])  # fmt: skip
def test_orbits_are_found_and_then_followed(monkeypatch, spent, label, starts, work):
    """With a label as many as 64 motions may be tried; a spent budget ends the following."""
    span = Span(600.0, 800.0, 5.0)
    question = OrbitsQuestion(700.0, "mass", span, label, branches=7, starts=starts)
    found = OrbitsFound([of_label()], ["dwell"], ["virtual"], Cost(1, 2, 3))
    result, calls = asked_of(monkeypatch, question, found, limits=("limit",) * 0, spent=spent)
    assert calls.work == [(work * (30 + study.FEWEST_TURNS), 2 * study.LITTLE_WORK)]
    assert calls.found == [("system", 700.0, Stub(transient=30), starts, label)]
    assert calls.shooter == ("system", 700.0, "mass")
    ((diagram, orbits, within, most, tick),) = calls.followed
    assert (orbits, within, most, tick) == (found.orbits, ("within", span), 7, "tick")
    assert result.curves == ("system", diagram.bifurcations, question)
    assert (result.orbits, result.virtual, result.continua) == (
        found.orbits, ["virtual"], ["dwell"]
    )  # fmt: skip
    assert (result.value, result.cost, result.absent) == (0.5, Cost(11, 22, 33), None)
    assert calls.absence == []


def test_without_a_range_nothing_is_followed(monkeypatch):
    result, calls = asked_of(monkeypatch, OrbitsQuestion(700.0))
    assert (calls.followed, result.limits) == ([], ())


@pytest.mark.parametrize("stable", [True, False])
def test_orbits_that_are_stable_or_not_may_be_asked_for(monkeypatch, stable):
    """Then a label that is not found is not looked for elsewhere."""
    found = OrbitsFound([of_label(stable=True), of_label(stable=False)])
    question = OrbitsQuestion(700.0, stable=stable, label=LABEL)
    result, calls = asked_of(monkeypatch, question, found)
    assert [one.stable for one in result.orbits] == [stable]
    _, calls = asked_of(monkeypatch, question, OrbitsFound())
    assert calls.absence == []


@pytest.mark.parametrize(("label", "found", "asks"), [
    (LABEL, OrbitsFound(), True), (None, OrbitsFound(), False),
    (LABEL, OrbitsFound([of_label()]), False), (LABEL, OrbitsFound(continua=["dwell"]), False),
])  # fmt: skip
def test_a_label_that_is_not_found_is_looked_for_elsewhere(monkeypatch, label, found, asks):
    question = OrbitsQuestion(700.0, label=label)
    _, calls = asked_of(monkeypatch, question, found)
    assert calls.absence == ([("system", Stub(transient=30), question, LABEL)] if asks else [])


@pytest.mark.parametrize("parameter", ["rpm", "mass"])
@pytest.mark.parametrize("spans", [True, False])
@pytest.mark.parametrize("kind", ["reached", "elsewhere", "nowhere", "failed"])
def test_an_orbit_that_is_found_elsewhere_is_followed_in_a_range_of_speeds(
    monkeypatch, parameter, spans, kind
):
    """One that its branch leads back to was only missed."""
    span = Span(600.0, 800.0, 5.0) if spans else None
    question = OrbitsQuestion(700.0, parameter, span, LABEL)
    absence = {
        "reached": Absence(700.0, 600.0, 800.0, of_label(), (700.0, "end"), of_label(rpm=700.0)),
        "elsewhere": Absence(700.0, 600.0, 800.0, of_label(), (690.0, "end")),
        "nowhere": Absence(700.0, 600.0, 800.0),
    }.get(kind)
    result, calls = asked_of(monkeypatch, question, OrbitsFound(), absence)
    moves = kind == "elsewhere" and spans and parameter == "rpm"
    rpm = 650.0 if moves else 700.0
    assert result.question == replace(question, rpm=rpm)
    assert calls.shooter == ("system", rpm, parameter)
    assert [one.rpm for one in result.orbits] == (
        [700.0] if kind == "reached" else [650.0] if moves else []
    )
    assert result.absent is (None if kind == "reached" else absence)


@pytest.mark.parametrize(("values", "turns"), [
    ((1.0, 2.0, 3.0), []), ((1.0, 3.0, 2.0), [3.0]), ((3.0, 1.0, 2.0), [1.0]),
    ((1.0, 3.0, 3.0, 2.0), [3.0]), ((1.0, 3.0, 3.0, 4.0), []), ((1.0, 3.0, 2.0, 4.0), [3.0, 2.0]),
    ((1.0, 3.0, 3.0 - 1e-9, 4.0), []),  # two turns at one value are none
    ((1.0, 3.0, 3.0 - 1e-8, 4.0), [3.0, 3.0 - 1e-8]), ((1.0, 1.0), []), ((1.0,), []),
])  # fmt: skip
def test_where_a_branch_turns_round(values, turns):
    points = tuple(Stub(value=value, label="P") for value in values)
    assert Branch(1, "found", points, ("", "")).turning_points == turns


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize(("value", "holds"), [
    (700.0, True), (705.0, True), (710.0, True), (699.0, False), (711.0, False),
])  # fmt: skip
def test_a_branch_that_falls_holds_a_root_as_one_that_rises_does(monkeypatch, order, value, holds):
    points = [Stub(value=one, root=root_of(THREE, one)) for one in (700.0, 710.0)][::order]
    monkeypatch.setattr(study, "from_root", lambda system, root: root.value)
    monkeypatch.setattr(study, "same_orbit", lambda a, b: a == b == value)
    solver = Stub(system="system", moved=lambda root, at: replace(root, x=[*root.x[:-1], at]))
    diagram = study.Diagram(solver, "settings")
    diagram.branches.append(Branch(1, "found", tuple(points), ("", "")))
    assert diagram.holds(root_of(THREE, value)) is holds


def test_each_point_of_a_branch_that_rests_is_a_simulation(monkeypatch):
    """As many as there are spacings in the range, and those that bracket its changes."""
    work, followed = [], []
    monkeypatch.setattr(study.backend, "for_work", work.append)
    monkeypatch.setattr(study, "_follow_one", lambda *of: followed.append(of))
    orbits = [Stub(resting=resting, label="P") for resting in (True, False, True)]
    diagram = Stub(branches=[], branch_points=[])
    span, ticks = Span(600.0, 800.0, 5.0), []
    study._follow_all(diagram, orbits, span, 3, lambda: ticks.append(len(followed)))
    assert work == [study.RUN * 2 * (40.0 + study.BRACKETS)]
    assert followed == [(diagram, one, span) for one in orbits]
    assert ticks == [1, 2, 3]


# -- parts of a curve


def curve_of(*values):
    points = [Stub(first=first, second=second) for first, second in values]
    return Stub(points=points)


def test_parts_of_a_curve_begin_with_the_joint_that_the_last_one_ended_with(monkeypatch):
    """But behind one that failed; as many boxes are tried first as half of the last ones."""
    asked = []
    answers = [5, 1, NotProvedError(ProofStep.GRAZES), NotProvedError(ProofStep.GRAZES), 8,
               BudgetSpentError(), 3]  # fmt: skip

    def part(system, curve, plane, points, joint, fewest):
        assert (system, plane) == ("system", "plane")
        asked.append((points[0].first, points[1].first, joint, fewest))
        answer = answers[len(asked) - 1]
        if isinstance(answer, Exception):
            raise answer
        number = len(asked)
        return Stub(joints=("first", f"joint {number}"), boxes=["box"] * answer, number=number,
                    then=lambda after: None)  # fmt: skip

    monkeypatch.setattr(curve_proofs, "_part", part)
    curve = curve_of(*[(float(k), 10.0 * k) for k in range(8)])
    found = curve_proofs.prove_curve("system", curve, 7, "plane")
    assert asked == [
        (0.0, 1.0, None, 1), (1.0, 2.0, "joint 1", 2), (2.0, 3.0, "joint 2", 1),
        (3.0, 4.0, None, 1), (4.0, 5.0, None, 1), (5.0, 6.0, "joint 5", 4), (6.0, 7.0, None, 4),
    ]  # fmt: skip

    def of(first, last, boxes, step=None):
        places = tuple((float(k - 1), 10.0 * (k - 1)) for k in (first, last))
        return CurveRange(7, first, last, places, boxes, step)

    assert found == [
        of(1, 3, 6), of(3, 5, 0, ProofStep.GRAZES), of(5, 6, 8),
        of(6, 7, 0, ProofStep.WORK_BUDGET), of(7, 8, 3),
    ]  # fmt: skip


@pytest.mark.parametrize(("fails", "fewest", "counts"), [
    (0, 1, [1]), (2, 1, [1, 2, 4]), (6, 1, [1, 2, 4, 8, 16, 32, 64]), (1, 5, [5, 10]),
    (7, 1, None), (4, 5, None), (3, 5, [5, 10, 20, 40]),
])  # fmt: skip
@pytest.mark.parametrize("joint", [None, "joint"])
@pytest.mark.parametrize(("second", "given"), [(0.87, 4), (0.875, 4), (0.88, 5)])
def test_a_part_of_a_curve_is_tried_with_more_and_more_boxes(
    monkeypatch, fails, fewest, counts, joint, second, given
):
    """Up to 64; both its ends are motions, and the number that changes more is given."""
    admitted, tried = [], []

    class OnCurve:
        place = 4
        meeting = Stub(admit=admitted.append)

        def __init__(self, *of):
            assert of == ("system", curve, plane, roots[0])

        def unknowns(self, *of):
            assert of[:3] == ("system", curve, plane)
            return of[4]

        def values(self, z):
            return z

        def box(self, z, at):
            assert at == given
            return Stub(hull=lambda: z, name=("box", z))

        def chain(self, start, end, at, count):
            assert at == given
            tried.append(count)
            if len(tried) <= fails:
                raise NotProvedError(ProofStep.SINGULAR)
            return ["boxes"] * count, ["shared"] * (count - 1)

    monkeypatch.setattr(curve_proofs, "OnCurve", OnCurve)
    plane = Stub(ranges=((600.0, 800.0), (0.5, 1.0)))
    roots = [Stub(whole=(1, 0), count=1), Stub(whole=(1, 0), count=1)]
    values = ((700.0, 0.75), (750.0, second))  # a quarter of the range of the first one
    points = tuple(
        Stub(orbit=Stub(root=root), first=value[0], second=value[1])
        for root, value in zip(roots, values, strict=True)
    )
    curve = Stub(located="located")
    start = joint and Stub(hull=lambda: "joint", name="joint")

    def part():
        return curve_proofs._part("system", curve, plane, points, start, fewest)

    if counts is None:
        with pytest.raises(NotProvedError):
            part()
        assert tried[-1] <= 64 < 2 * tried[-1]
    else:
        found = part()
        assert tried == counts
        assert found.boxes == ("boxes",) * counts[-1]
        first = "joint" if joint else ("box", values[0])
        names = [one if one == "shared" else one.name for one in found.joints]
        assert names == [first, *["shared"] * (counts[-1] - 1), ("box", values[1])]
    assert admitted == ["joint" if joint else values[0], values[1]]
    roots[1].whole = (2, 0)
    with pytest.raises(NotProvedError) as refused:
        part()
    assert refused.value.step == ProofStep.PASSES


@pytest.mark.parametrize("in_balls", [True, False])
def test_a_box_on_a_curve_is_counted_for_each_impact(monkeypatch, in_balls):
    spent = []
    monkeypatch.setattr(curve_proofs, "spend", spent.append)
    monkeypatch.setattr(curve_proofs, "box_of", lambda *of: of)
    on = curve_proofs.OnCurve.__new__(curve_proofs.OnCurve)
    on.meeting = Stub(n=3, in_balls=["cam.base"] if in_balls else [])
    filled = curve_proofs.FILLED if in_balls else 1
    assert on.box("guess", 5, 0.25) == (on.equations, "guess", 5, 0.25, filled)
    assert spent == [3 * curve_proofs.BOXED]


# -- the orbit near a box of phases


@pytest.mark.parametrize(("goals", "ends", "solved"), [
    ((1.05, 2.15), (9.0, 9.0), True), ((1.21, 2.0), (9.0, 9.0), False),
    ((1.0, 2.21), (9.0, 9.0), False), ((1.0, 1.79), (9.0, 9.0), False),
    ((1.05, 2.15), (9.0, 2.1), False), ((1.05, 2.15), (1.04, 9.0), False),
])  # fmt: skip
def test_an_orbit_near_a_box_is_solved_without_leaving_it_far(monkeypatch, goals, ends, solved):
    """Each phase stays within twice the half width of its box, and on its stretch at the end."""
    cells = {
        k: Stub(in_turn=arb(1.0 + k, 0.1), stretch=Stub(start=arb(0), end=arb(ends[k])))
        for k in (0, 1)
    }
    monkeypatch.setattr(all_orbits, "Cell", lambda stretches, stretch, phase: phase)

    def at(points, turns):
        assert turns == 3
        values = arb_mat([[point - goal] for point, goal in zip(points, goals, strict=True)])
        return Stub(equations=(values, arb_mat([[1, 0], [0, 1]])), rates=[arb(4), arb(5)])

    search = all_orbits._CoverSearch.__new__(all_orbits._CoverSearch)
    search.space = Stub(
        cell=lambda key: cells[key.stretch], at=at, machine=Stub(stretches="stretches")
    )
    box = (Stub(stretch=0), Stub(stretch=1))
    found = search._solved(box, 3)
    if solved:
        assert found.phases == pytest.approx(list(goals))
        assert found.rates == [4.0, 5.0]
    else:
        assert found is None
    search.space.at = lambda points, turns: None
    assert search._solved(box, 3) is None
