"""The equations of two conditions at once: their machine, their order and their terms, by hand."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import pi
from types import SimpleNamespace as Stub

import pytest
from flint import arb, arb_mat, arb_series, ctx

from camcli.analysis.orbits import codim2
from camcli.analysis.orbits.codim2 import Condition, Meeting
from camcli.analysis.orbits.codim2 import Test as What
from camcli.cams.balls import UndecidedError
from camcli.exact.shooting import Place
from camcli.system import Follower

TURN = 2.0 * pi


@pytest.fixture(autouse=True)
def many_bits():
    before, ctx.prec = ctx.prec, 120
    yield
    ctx.prec = before


@dataclass(frozen=True)
class Equations:
    """Equations on a cam, whose stretches are lost with each change as the real ones' are."""

    shape: object = "shape"
    follower: Follower = Follower(mass=2.0, stiffness=3.0)  # noqa: RUF009
    rpm: object = 700.0
    parameter: str = "mass"

    @property
    def stretches(self):
        return vars(self).get("given", ("s",) * 3)

    def with_stretches(self, stretches):
        made = replace(self)
        vars(made)["given"] = stretches
        return made


def meeting(**more) -> Meeting:
    made = Meeting.__new__(Meeting)
    given = {
        "plane": Stub(names=("cam.lift", "rpm"), ranges=((0.5, 1.5), (600.0, 800.0))), "n": 2,
        "system": "system", "in_balls": [], "in_doubles": [], "_cams": {}, "grazes": [],
        "base": Equations(), "root": Stub(machine=("machine",)),
    }  # fmt: skip
    made.__dict__.update({**given, **more})
    return made


def test_a_meeting_is_at_the_machine_of_its_root(monkeypatch):
    """A graze touches the cam at an angle behind its impact, in the turn of that."""
    asked = []
    base = Stub(
        shape="shape", places=[Place(0, 4), Place(1, 5)],
        place=lambda phase, turn: (asked.append((float(phase), turn)), ("place", turn))[1],
    )  # fmt: skip
    monkeypatch.setattr(
        codim2, "exact_shooting", lambda *of: base if of == (system, root) else None
    )
    monkeypatch.setattr(codim2, "can_vary", lambda shape, name: name == "cam.lift")
    names = ("cam.base", "cam.lift", "cam.width")
    system = Stub(member=Stub(family=Stub(names=names)))
    root = Stub(count=2, theta=[1.0, 4.0], tangent=[1.0, 2.0, 3.0, 4.0, 9.0])
    conditions = [Condition(What.GRAZE, 1, angle=0.25), Condition(What.FOLD)]
    for plane_names, in_balls, in_doubles in (
        (("cam.lift", "rpm"), ["cam.lift"], []), (("mass", "cam.base"), [], ["cam.base"]),
        (("cam.lift", "cam.base"), ["cam.lift"], ["cam.base"]), (("mass", "rpm"), [], []),
    ):  # fmt: skip
        made = Meeting(system, Stub(names=plane_names), root, conditions)
        assert (made.in_balls, made.in_doubles, made.n) == (in_balls, in_doubles, 2)
        assert made.grazes == [(conditions[0], ("place", 5))]
        assert asked.pop() == (4.25, 5)
        assert [float(x) for x in made.branch_direction] == [1.0, 2.0, 3.0, 4.0]
        u = made.start(Stub(x=[1.5, 2.5, 3.5, 4.5, 700.0]), (0.5, 6.5))
        assert [float(x) for x in u] == [1.5, 2.5, 3.5, 4.5, 0.5, 6.5, 0.25]
    system.member = None
    assert Meeting(system, Stub(names=("mass", "rpm")), root, []).in_balls == []


def test_constants_of_a_meeting_are_those_of_its_values(monkeypatch):
    """On the cam of its numbers: as the nearest doubles, or in balls with all that follows."""
    on_cams = []

    def on_cam(of):
        on_cams.append(of)
        return Equations(shape="of doubles").with_stretches(("t",) * 3)

    plain = meeting()
    plain._on_cam = on_cam
    plain.plane = Stub(names=("stiffness", "rpm"))
    found = plain.shooting([7.0, 650.0])
    follower = Follower(mass=2.0, stiffness=7.0)
    assert found == Equations("of doubles", follower, 650.0, "mass")
    assert found.stretches == ("t",) * 3
    doubles = meeting(in_doubles=["cam.lift"])
    doubles._on_cam = on_cam
    assert doubles.shooting([arb(1.25, 1e-20), 650.0]).rpm == 650.0
    assert on_cams == [{}, {"cam.lift": 1.25}]

    made = meeting(in_balls=["cam.lift", "cam.base"])
    made.plane = Stub(names=("cam.lift", "cam.base"))
    made._on_cam = on_cam
    count = [3]
    monkeypatch.setattr(codim2, "with_number", lambda *of: of)
    monkeypatch.setattr(codim2, "varied_stretches", lambda shape: (("varied", shape),) * count[0])
    monkeypatch.setattr(codim2, "stretches_of", lambda shape: (("plain", shape),) * count[0])
    monkeypatch.setattr(codim2, "constants_of", lambda shape: {"mass": 8.0, "rpm": 640.0})
    series = arb_series([1, 1], 2)
    for values, kind in (
        ((arb(1), arb(2)), "plain"), ((series, arb(2)), "varied"), ((arb(1), series), "varied"),
    ):  # fmt: skip
        shape = (("of doubles", "cam.lift", values[0]), "cam.base", values[1])
        found = made.shooting(values)
        (of_kind, of_shape) = found.stretches[0]
        assert (of_kind, len(found.stretches)) == (kind, 3)
        assert of_shape[0][:2] == shape[0][:2]
        assert of_shape[0][2] is values[0]
        assert of_shape[2] is values[1]
        assert found.shape is of_shape
        assert (found.follower, found.rpm) == (Follower(mass=8.0, stiffness=3.0), 640.0)
    for parts in (2, 4):
        count[:] = [parts]
        with pytest.raises(UndecidedError):
            made.shooting((arb(1), arb(2)))


def test_a_cam_of_doubles_is_compiled_once_from_all_its_numbers(monkeypatch):
    moves = []
    monkeypatch.setattr(
        codim2, "machine_at", lambda *of: (moves.append(of), (*of[1], of[2], of[3]))[1]
    )
    monkeypatch.setattr(
        codim2, "with_machine",
        lambda system, machine: (Stub(shape=("shape", machine), follower="follower"), 640.0),
    )  # fmt: skip
    made = meeting()
    numbers = {"cam.lift": 1.25, "cam.base": 0.5}
    found = made._on_cam(numbers)
    machine = ("machine", "cam.lift", 1.25, "cam.base", 0.5)
    assert found == Equations(("shape", machine), "follower", 640.0, "rpm")
    assert made._on_cam(dict(numbers)) is found
    assert len(moves) == 2
    assert made._on_cam({"cam.lift": 1.5, "cam.base": 0.5}) is not found


FLIGHTS = [Stub(gap=0.5, r=0.25, rate=-2.0), Stub(gap=0.75, r=0.5, rate=-3.0)]
STRETCHES = [Stub(start=0.25, end=1.5), Stub(start=3.5, end=4.25)]
U = [1.0, 5.0, 4.0, 7.0, 11.0, 13.0]
ORBIT = [0.5, -0.5 + 7.0, 0.75, -1.5 + 5.0]  # gap, and r times rate and the rate behind it


def values_of(*conditions, grazes=(), angles=()):
    """The equations at U, with impacts on stretches 0 and 1, the second one in turn 5."""
    made = meeting(conditions=conditions)
    made.base = Stub(places=[Place(0, 4), Place(1, 5)])
    made.grazes = [codim2.Grazed(condition, place) for condition, place in grazes]

    def gap(machine, x, k, place):
        assert (machine, x) == (("machine", 9.0), U[:4])
        return lambda angle: (("gap", k, place, angle), ("slope", k, place, angle), "bend")

    at = Stub(
        rpm=9.0, machine=lambda rpm: ("machine", rpm), places=[Place(0, 4), Place(1, 5)],
        stretches=STRETCHES, gap=gap,
        flights=lambda machine, x: FLIGHTS if (machine, x) == (("machine", 9.0), U[:4]) else None,
    )  # fmt: skip
    made.shooting = lambda values: at if list(values) == U[4:6] else None
    made._bend = lambda of, machine, x: ("bend", of is at, x)
    return made.equations([*U, *angles])


def test_each_condition_has_its_own_equation_behind_those_of_the_orbit(monkeypatch):
    monkeypatch.setattr(
        codim2, "_multiplier_test", lambda at, machine, x, sign: ("multiplier", x, sign)
    )
    assert values_of() == ORBIT
    for condition, value in (
        (Condition(What.CORNER, 1, 1), 4.0 - 4.25), (Condition(What.CORNER, 1, -1), 4.0 - 3.5),
        (Condition(What.CORNER, 0, 1), 1.0 - 1.5), (Condition(What.FADE, 0), -3.0),
        (Condition(What.FADE, 1), -2.0), (Condition(What.FOLD), ("multiplier", U[:4], -1)),
        (Condition(What.FLIP), ("multiplier", U[:4], 1)),
        (Condition(What.CUSP), ("bend", True, U[:4])),
    ):  # fmt: skip
        assert values_of(condition) == [*ORBIT, value]
    both = values_of(Condition(What.FADE, 1), Condition(What.CORNER, 0, -1))
    assert both == [*ORBIT, -2.0, 0.75]


@pytest.mark.parametrize("turn", [5, 6])
@pytest.mark.parametrize("side", [1, -1])
def test_a_graze_has_its_slope_among_the_equations_of_the_orbit(turn, side):
    """And at a corner its phase, in the turn in which it touches the cam."""
    graze = Condition(What.GRAZE, 1, angle=9.0)
    place = Place(0, turn)
    *orbit, slope, gap, phase = values_of(
        graze, Condition(What.GRAZE_AT_CORNER, 1, side), grazes=[(graze, place)], angles=[0.25]
    )
    assert orbit == ORBIT
    assert (slope, gap) == (("slope", 1, place, 0.25), ("gap", 1, place, 0.25))
    edge = 1.5 if side > 0 else 0.25
    assert float(phase) == pytest.approx(4.0 + 0.25 + TURN * (5 - turn) - edge)
    other = Condition(What.GRAZE, 0, angle=9.0)
    two = values_of(
        graze, other, grazes=[(graze, place), (other, "place")], angles=[0.25, 0.5]
    )  # fmt: skip
    assert two == [*ORBIT, ("slope", 1, place, 0.25), ("slope", 0, "place", 0.5),
                   ("gap", 1, place, 0.25), ("gap", 0, "place", 0.5)]  # fmt: skip


def test_a_zero_that_is_known_exactly_is_enclosed_tightly():
    """Of linear equations nothing is left but rounding."""
    made = meeting()
    made.equations = lambda u: [u[0] - 3, u[1] + 2 * u[0] - 7]
    made.derivatives = lambda u: arb_mat([[1, 0], [2, 1]])
    for guess in ([arb(3), arb(1)], [arb(3) + arb(2) ** -50, arb(1)]):
        found = made.enclosed(guess)
        assert found[0].contains(3)
        assert found[1].contains(1)
        assert all(x.rad() < arb(2) ** -110 for x in found)
