"""Limits and tolerances with a name: a case just within each of them, and one just beyond.

`test_thresholds` has those of which a user is told something, `test_limits` those of counted work.
Here are those that decide what an analysis takes for the same, for settled, for rounding, for near
enough or for too far: a row asks the function that uses the limit, with all that it does not need
left out. The limits are written here once more. Numbers of which a little more or less can change
nothing but the time that is taken have no row: steps of an iteration that ends by itself, digits
and bits beyond those of a double, sizes of blocks and of what is remembered.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import islice
from math import inf, nan, pi
from types import SimpleNamespace as Stub
from typing import Any, NamedTuple

import numpy as np
import pytest
from flint import arb
from mpmath import mp, mpf

from camcli import check
from camcli.analysis import (
    after_rest,
    border_collision,
    bracketing,
    cam_profile,
    loads,
    lobe,
    motion_at_speed,
    surge,
    sweep,
)
from camcli.analysis.basins import measures, recurrence, region, saddles, study
from camcli.analysis.basins.window import Window
from camcli.analysis.chaos import section
from camcli.analysis.contact_loss import accumulation, bursts, hold
from camcli.analysis.contact_loss import certificate as contact_certificate
from camcli.analysis.contact_loss import study as contact_loss
from camcli.analysis.contact_loss.detachment import SpeedStatus
from camcli.analysis.explain import changes, tangency
from camcli.analysis.explain import saddles as crisis_saddles
from camcli.analysis.labels import Label
from camcli.analysis.orbits import (
    all_orbits,
    arclength,
    atlas,
    codim2,
    family_shooting,
    locate,
    proofs,
    search,
    single_impact,
)
from camcli.analysis.orbits import orbit as one_orbit
from camcli.analysis.orbits import study as orbits
from camcli.analysis.orbits.curves import _Tracer
from camcli.api.machine import machine_of
from camcli.cams import balls, compile, decimals, lift_fit, lift_guess
from camcli.errors import Status
from camcli.exact.shooting import NotProvedError
from camcli.kernel import (
    arithmetic,
    cam_table,
    cells,
    certify,
    enclosed_landing,
    flow,
    orbit_loop,
    returns,
    variational,
)
from camcli.kernel.certify import Verdict
from tests.conftest import chapter_system, settings
from tests.support.strobes import strobe_of
from tests.truth.test_thresholds import LOBE, NOSE, made

TURN = 2.0 * pi


class Limit(NamedTuple):
    """answers(x): what the function says of a number; of `within` and `beyond` it differs."""

    name: str
    answers: Callable[[Any], Any]
    within: Any
    beyond: Any
    said: tuple[Any, Any] = (True, False)


def near(name: str, answers: Callable[[float], Any], limit: float, by: float = 1e-3, **more: Any):
    """Of a number a little below the limit, and of one a little above it, relative."""
    return Limit(name, answers, limit * (1.0 - by), limit * (1.0 + by), **more)


def count(name: str, answers: Callable[[int], Any], limit: int, **more: Any):
    """Of the limit itself, and of one more."""
    return Limit(name, answers, limit, limit + 1, **more)


# -- basins --------------------------------------------------------------------------------------


def comes_back(new: int) -> bool:
    """Of a record whose second half of 1000 turns has so many where the first has none."""
    first = [[0.0, 0.0], [1.0, 1.0]] * 500
    second = [[0.5, 0.5]] * new + [[0.0, 0.0]] * (1000 - new)
    return recurrence.is_recurrent(np.array(first + second))


def box_of(place: float) -> int:
    """The column of the box of a place in a range from 0 to 1."""
    boxes = recurrence.Grid.over(np.array([[0.0, 0.0], [1.0, 1.0]]))
    return int((place - boxes.gap) * boxes.per_gap)


def goes_on(far: float) -> bool:
    """Whether an attractor is that of the neighbouring speed, from which it is so far."""
    branches = study.Branches(last=[Stub(label="P(1;1)")])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(study, "distance", lambda new, old: far)
        return branches._by_state([Stub(label="P(1;1)")]) == {0: 0}


class Circle(NamedTuple):
    """A region of so much radius that overlaps others of twice what is tried."""

    radius: float

    def scaled(self, factor: float) -> Circle:
        return Circle(self.radius * factor)


def parts(radius: float) -> bool:
    """Whether two regions are parted that no longer overlap at half of twice the radius."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(region, "overlap", lambda one, other: one.radius > 1.5 * radius)
        return region.parted([Circle(2.0 * radius)], Circle(2.0 * radius)) is not None


def led_to(far: float) -> bool:
    one = Stub(states=[(0.0, 0.0)])
    return saddles._nearest([one], np.array([[far, 0.0], [1.0, 1.0]]), np.ones(2)) == 0


def pairs_on_a_boundary(number: int) -> int:
    """How many of so many pairs of cells on a boundary are followed."""
    window = Window((0.0, 1.0), (0.0, 1.0), number + 1, 1)
    low, high = saddles._pairs(window, np.array([[1, 2] * (number // 2 + 1)])[:, : number + 1])
    assert len(low) == len(high)
    return len(low)


def settles(form: float, shrunk: float = 2.0) -> bool:
    """Whether a cell at home on a ring of one point has settled; form: its squared distance."""
    ring = Stub(following=0, symbol=1, turns=1, shrink=0.5, attractor=7)
    cell = Stub(at=0, symbol=1, passed=0, first=form / shrunk)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(cells, "form", lambda targets, to, gap, rate: form)
        return cells.follow_ring(Stub(points=[ring]), 0.0, 0.0, cell) == 7


BASINS = [
    count("turns in new boxes", comes_back, 20),
    Limit("boxes along a range", box_of, 0.5 - 1e-9, 0.5 + 1e-9, (49, 50)),  # two spare ones first
    Limit("boxes at its end", box_of, 1.0 - 1e-9, 1.0 + 1e-9, (97, 98)),
    near("states of one branch", goes_on, 0.3),
    Limit("states compared", lambda n: len(study._thin(np.zeros(n))), 799, 800, (799, 400)),
    count("speeds with their cells",
          lambda n: len(study.Study.grids.fget(Stub(speeds=(1,) * n))) == n, 3),
    near("regions that are one", parts, 1e-11, said=(False, True)),
    near("led to a saddle", led_to, 1e-3),
    Limit("pairs followed", pairs_on_a_boundary, 24, 40, (24, 24)),
    Limit("few pairs", pairs_on_a_boundary, 23, 24, (23, 24)),
    near("a form of rounding", settles, 1e-10),
    Limit("a form that has shrunk", lambda by: settles(0.1, by), 0.5 - 1e-9, 0.5 + 1e-9),
]  # fmt: skip


def test_a_stay_that_decides_is_longer_than_twice_that_of_a_trial_which_left():
    boxes = Stub(stays=[500, 500], owner=np.array([1, 1, 2]))
    tried, ended, stay = np.array([0, 1, 2]), np.array([1, 2, 2]), np.array([99, 7, 50])
    assert recurrence.stays_of(boxes, tried, ended, stay) == [16 + 2 * 7, 16]


# -- what is a word, a cycle, a return, a rest -------------------------------------------------


def closes_on(changes: dict[str, float]) -> int:
    """Turns of the period of a record of one state, but for some."""
    gaps = {"third": 0.0, "second": 0.0, "last": 0.0, **changes}
    q = 1.0
    states = [(q, 1.0)] * 3
    for name in ("third", "second", "last"):
        q += gaps[name]
        states.append((q, 1.0))
    return after_rest.repeats(states, [1.0] * len(states), (1.0, 1.0))


def shrinks(share: float) -> bool:
    """A record of period 1 whose steps shrink by a share."""
    return closes_on({"third": 1e-9, "second": 1e-9 * share, "last": 1e-9 * share**2}) == 1


def follows(name: str, value: Any) -> Any:
    """What `border_collision._follow` says, of what it is told by stand-ins."""
    told = {"end": 1.0, "at_one": 1.0, "limits": [], name: value}

    def run(x: float, y: float, steps: int, limit: float) -> list[tuple[float, float]]:
        told["limits"].append(limit)
        return [(1.0, 0.0)]

    side = Stub(at_one=told["at_one"])
    form = Stub(left=side, right=Stub(at_one=2.0), run=run)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(border_collision, "_word", lambda *given: ("L", None))
        patch.setattr(border_collision, "_exponent", lambda *given: (0.0, 0.0, (told["end"], 0.0)))
        kind = border_collision._follow(form, (0.0, 0.0), True).kind
    return told["limits"][0] if name == "at_one" else kind


def word_of(turns: int) -> bool:
    return border_collision.repeating(("L" * (turns - 1) + "R") * 4) == "L" * (turns - 1) + "R"


def comes_round(apart: float, turns: int = 40) -> tuple[int, int]:
    """The return of a record whose last state is so far from the one before."""
    q = [1.0] * (turns - 1) + [1.0 - apart]
    return returns.find_return(strobe_of(q, [1.0] * turns, [1.0] * turns), turns)


def alike_for(turns: int) -> bool:
    """Whether a record that has been the same for so many turns counts as repeating."""
    q = [0.3 + 0.01 * k for k in range(40 - turns - 1)] + [1.0] * (turns + 1)
    return returns.find_return(strobe_of(q, [1.0] * 40, [1.0] * 40), 40)[0] == 1


MOTIONS = [
    near("the last step of a period", lambda gap: closes_on({"last": gap}) == 1, 1e-13),
    near("steps that shrink", shrinks, 0.95),
    near("steps that are close", lambda gap: closes_on(
        {"third": 10.0 * gap, "second": 3.0 * gap, "last": gap}) == 1, 1e-8),
    count("letters of a word", word_of, 64),
    near("an orbit that grows", lambda end: follows("end", end), 10.0, said=("undecided", "none")),
    Limit("infinity", lambda x: follows("at_one", x), 1.0, 0.5, (1e9, 2e9)),
    near("a sum that is rounding", lambda off: border_collision.unclear(1.0, off - 1.0), 2.0**-48,
         by=2.0**-5),
    near("states that are the same", comes_round, 1e-7, said=((1, 0), (0, 1))),
    near("states that are close", comes_round, 1e-2, said=((0, 1), (0, 0))),
    Limit("turns that are the same", alike_for, 16, 15),
]  # fmt: skip


# -- places and sizes ----------------------------------------------------------------------------


def lowest_place(dip: float) -> float:
    """The place of the least value of a function that is 1 at an end and so much lower at 0.4."""

    def f(x: float) -> float:
        return 1.0 if x == 0.0 else 1.0 - dip + (x - 0.4) ** 2

    return bracketing.lowest(f, 0.0, 1.0, 4)[1]


def jerk_jumps(jump: float) -> bool:
    """Whether the third derivative jumps where it changes so much, of 8 at most."""
    stretches = [Stub(start=0.0, end=1.0), Stub(start=1.0, end=2.0)]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(cam_profile, "column", lambda cam, name: [8.0, 3.0])
        patch.setattr(cam_profile, "derivative", lambda cam, order, i, theta: jump * i)
        found = cam_profile._jerk_jumps(Stub(cam=Stub(stretches=stretches)))
    return found == {0, 1}


class Bursts:
    """Bursts whose impact jumps by so much on either side of a goal."""

    name = "a"

    def __init__(self, jump: float):
        self.jump = jump

    def at(self, rpm: float, impacts: int = 0) -> Stub:
        off = self.jump if rpm > 150.0 else -self.jump
        return Stub(status=Status.OK, impacts=[2.0 + off], end=inf)


def change_of(jump: float, way: float) -> SpeedStatus:
    """How the change of a phase is called that jumps from one side of its goal to the other."""
    moving = Bursts(way * jump)
    (found,) = accumulation._changes(moving, lambda rpm: moving.at(rpm).impacts[0] - 2.0,
                                     [100.0, 200.0])  # fmt: skip
    return found.status


def hit_of(jump: float) -> tuple[SpeedStatus, bool]:
    (found,) = accumulation.corner_hits(Bursts(jump), Stub(name="b"), 2.0, 100.0, 200.0, 1)
    return found.status, found.ends is None


def rests_elsewhere(apart: float) -> bool:
    motion = Stub(rests=[1.0], ends=[1.0 + apart])
    return bursts.SettledMotion.other_rests.fget(motion) == []


def low_dwell(height: float) -> bool:
    """Whether a dwell counts as the base circle that is so high, of a lift of 2 m above -1 m."""
    cam = Stub(stretches=[Stub(start=0.0, end=1.0, dwell=1, start_c=-1.0 + height)])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(loads, "lift_range", lambda cam: (-1.0, 1.0))
        return loads._flat(cam) == 1.0


def rests_at_strobe(off: float, rate: bool) -> bool:
    """Whether a state off the cam by a share of its size is a rest; at 45 deg the cam moves."""
    system = chapter_system(200.0)
    c, c1 = motion_at_speed.lift_at(system.cam, system.cam.strobe, system.strobe)[:2]
    assert c1 != 0.0
    state = (c, c1 + off * (abs(c1) + abs(c))) if rate else (c * (1.0 + off), c1)
    return motion_at_speed.start_at(system, 700.0, state).q is None


def at_once(turns: int) -> int:
    """Speeds of so many turns each that one call of the compiled kernel is given."""
    task = Stub(turns=1, turns_each=turns)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(motion_at_speed.backend, "for_work", lambda turns: None)
        patch.setattr(motion_at_speed.backend, "current", lambda: Stub(compiled=True))
        return motion_at_speed.SpeedTask.at_once.fget(task)


def past(number: int) -> list[float]:
    """The speeds past a loss of contact at 100 rpm, in a range up to 250 rpm."""
    lost = Stub(never=False, first=Stub(rpm=100.0))
    return contact_loss._past_speeds(lost, [50.0, 250.0])[:number]


def differ(change: str, size: float) -> bool:
    """Whether a sweep has a speed between two added; the whole range is 1200 rpm."""
    sizes = {"loads": size if change == "loads" else 0.5}
    width = size if change == "range" else 10.0
    rows = [(0.0, 0.0, "aperiodic"), (600.0, 0.0, "aperiodic"),
            (600.0 + width, sizes["loads"] if change == "loads" else 0.0,
             "aperiodic" if change == "loads" else "P(1;1)"),
            (1200.0, 1.0, "aperiodic" if change == "loads" else "P(1;1)")]  # fmt: skip
    speeds = [Stub(value=value, label=label, status=Status.OK,
                   loads=Stub(max_gap_m=gap, max_impact_m_per_s=0.0))
              for value, gap, label in rows]  # fmt: skip
    return 600.0 + 0.5 * width not in sweep._between(speeds)


def watched(calm: int) -> list[int]:
    """Which rows of ten aperiodic ones are watched next, once so many at the low end stayed so."""
    rows = Stub(at=range(10), watched=[k < calm for k in range(10)])
    looks = [sweep.APERIODIC_LOOK] * 10
    return sorted(sweep._unwatched(rows, looks, ranked=range(10), places=range(10)))


def hollow(curvature: float) -> bool:
    """Whether the flank of a lobe on a base circle of 0.1 m is hollow that bends in by so much."""
    force = Stub(starts=[0.0], lowest=lambda f: (-curvature, 0, 1.0))
    geometry = Stub(base=0.1, force=force, kappa=None)
    return lobe._hollow(geometry, 0.01, [0.0]) is not None


PLACES = [
    Limit("a minimum as low as an end", lowest_place, 0.9e-14, 1.1e-14,
          (0.0, pytest.approx(0.4, abs=1e-8))),
    near("a jump of the third derivative", jerk_jumps, 8e-6, said=(False, True)),
    *(near(f"a phase that comes up to its goal, {way:+g}", lambda jump, w=way: change_of(jump, w),
           1e-4, said=(SpeedStatus.OK, SpeedStatus.JUMP)) for way in (1.0, -1.0)),
    near("a landing that comes up to its corner", hit_of, 1e-4,
         said=((SpeedStatus.OK, True), (SpeedStatus.JUMP, False))),
    near("rests of one chatter", rests_elsewhere, 1e-9),
    near("a dwell on the base circle", low_dwell, 2e-6),
    *(near(f"at rest on the cam, by {name}", lambda off, r=rate: rests_at_strobe(off, r), 1e-12,
           by=0.02) for name, rate in (("height", False), ("rate", True))),
    Limit("many speeds at once", at_once, 312, 313, (64, 63)),
    Limit("most speeds at once", at_once, 1, 300, (64, 64)),
    Limit("few speeds at once", at_once, 6_666, 6_667, (3, 2)),
    Limit("one speed at once", at_once, 20_000, 10**9, (1, 1)),
    Limit("speeds past the loss", past, 20, 1,
          ([pytest.approx(100.0 + 10.0 * k) for k in range(1, 16)], [pytest.approx(110.0)])),
    near("a change of a load", lambda size: differ("loads", size), 0.1),
    near("neighbours in a sweep", lambda width: differ("range", width), 1.0, by=1e-4),
    Limit("neighbours that stay aperiodic", watched, 0, 2, ([0, 1, 8, 9], [8, 9])),
    near("a straight flank", hollow, 1e-11, said=(False, True)),
    near("surge of a spring", lambda factor: surge.Harmonic(1, 1e-3, 900.0, factor).strong,
         0.12, said=(False, True)),
]  # fmt: skip


def test_golden_and_plastic_numbers_are_the_roots_of_their_equations():
    assert abs(bracketing.GOLDEN**2 + bracketing.GOLDEN - 1.0) < 2.0**-52
    assert abs(measures.PLASTIC**3 - measures.PLASTIC - 1.0) < 2.0**-50


def test_the_usual_margin_is_a_tenth_of_what_the_spring_must_give():
    """At the nose m omega^2 (-c_thetatheta) - m g, of which it gives a tenth more."""
    system = machine_of(made(LOBE, gravity=9.81)).system
    wanted = 0.1 * 0.25 * (300.0**2 * NOSE - 9.81)
    assert hold.usual_margin(system, 300.0 * 30.0 / pi) == pytest.approx(wanted, rel=1e-9)


# -- tangencies ----------------------------------------------------------------------------------


def error_of(solved: list[float], runs: float = 1.0, rpm: float = 100.0, crowding: float = 1.0):
    """The error of the earliest tangency; runs leave from `runs` behind the speed on."""
    carried = Stub(way=lambda x: x, stays=rpm - runs, leaves=rpm + runs, crowding=crowding)
    return tangency.width(carried, rpm, 0.0, solved)


def crowded(number: int, crowding: float = 1.0) -> float:
    """The distance that a fold not sampled is nearer with a probability of one in sixteen.

    (1 - (x/(1 + x))^alpha)^(n - 1) = 1/16 for n distances, the farthest of which is 0.01.
    """
    share = (1.0 - 16.0 ** (-1.0 / (number - 1))) ** (1.0 / crowding)
    return share / (1.0 - share) * 0.01


TANGENCIES = [
    Limit("runs alone", lambda runs: error_of([100.0], runs), 1.0, 0.5,
          (pytest.approx(3.0), pytest.approx(1.5))),
    Limit("one other", lambda way: error_of([100.0, 100.0 + way]), 0.01, 0.02,
          (pytest.approx(0.01), pytest.approx(0.02))),
    near("not sampled", lambda way: error_of([100.0, 100.0 + way]) > 4.0001e-5, 4e-5, by=1e-2,
         said=(False, True)),
    near("the same tangency", lambda way: error_of([100.0, 100.0 + way]) > 1.0, 1e-7,
         said=(True, False)),
    Limit("enough of them", lambda n: error_of([100.0 + 0.01 * k / (n - 1) for k in range(n)], 9.0),
          4, 5, (pytest.approx(crowded(4)), pytest.approx(crowded(5)))),
    Limit("too few", lambda n: error_of([100.0 + 0.01 * k / (n - 1) for k in range(n)], 9.0),
          3, 4, (pytest.approx(0.005), pytest.approx(crowded(4)))),
    Limit("more than count", lambda n: error_of([100.0 + 0.0025 * k for k in range(n)], 9.0),
          5, 9, (pytest.approx(crowded(5)), pytest.approx(crowded(5)))),
    Limit("of a Cantor set", lambda alpha: error_of(
        [100.0 + 0.0025 * k for k in range(5)], 9.0, crowding=alpha), 0.5, 0.8,
          (pytest.approx(crowded(5, 0.5)), pytest.approx(crowded(5, 0.8)))),
]  # fmt: skip


def fold_at(*etas: float) -> tuple[bool, int]:
    """Whether a fold is solved whose heights are these one after the other, and how many it took.

    The first ones stand for the speeds of the first step, so that the secant hardly moves it.
    """
    asked = list(etas)
    folds = Stub(carried=Stub(near=700.0, far=800.0), lowest=lambda *given: Stub(
        eta=asked.pop(0) if len(asked) > 1 else asked[0], t=0.0, xi=0.0))  # fmt: skip
    found = tangency._secants(folds, tangency.Fold(750.0, 9, 0.0, 1e-3, 0.0))
    return found is not None, len(etas) - len(asked)


def touches(xi: float) -> bool:
    """Whether a fold that lies so far along a stable manifold touches it where it is straight."""
    solved = [tangency.Fold(750.0, 9, 0.0, 1e-3, 0.0, xi)]
    folds = Stub(saddle=Stub(multipliers=(2.0, 0.1), turns=1))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tangency, "_secants", lambda *given: solved.pop() if solved else None)
        return tangency.touch(folds, tangency.Fold(750.0, 9, 0.0, 1e-3, 0.0)) is not None


FOLDS = [
    near("a fold that touches", lambda eta: fold_at(0.01, eta, eta)[0], 1e-6),
    near("a fold near the saddle", lambda eta: fold_at(0.0, eta, eta, eta)[1], 0.05, said=(3, 2)),
    near("a straight manifold", touches, 1e-5),
]  # fmt: skip


def returning(step: float) -> int:
    """How many close returns are tried of two states so far apart, over and over elsewhere."""
    states = np.array([[0.0, 0.0], [step, 0.0], [9.0, 9.0]])
    return len(crisis_saddles._closest_returns(states, 1))


def many_returns(number: int) -> int:
    """How many are tried of so many, each in a cell of its own."""
    places = [[0.25 * k + 0.001 * j, 0.0] for k in range(number) for j in (0, 1)]
    return len(crisis_saddles._closest_returns(np.array(places), 1))


def in_one_cell(place: float) -> int:
    """How many of two are tried, of which one begins at a place and one in the first cell."""
    places = [[0.001, 0.0], [0.0015, 0.0], [5.0, 5.0], [place, 0.0], [place + 0.0005, 0.0]]
    return len(crisis_saddles._closest_returns(np.array(places), 1))


RETURNS = [
    near("a close return", returning, 0.05, said=(1, 0)),
    near("an orbit at rest", returning, 1e-9, said=(0, 1)),
    Limit("returns tried", many_returns, 40, 60, (40, 40)),
    Limit("few returns", many_returns, 38, 39, (38, 39)),
    near("returns in a cell", in_one_cell, 1.0 / 64.0, said=(1, 2)),
]  # fmt: skip


# -- branches and curves -------------------------------------------------------------------------


def accepted(name: str, value: float, trace: float = 0.5) -> bool:
    """Whether a step along a branch is taken, of which one thing is so large."""
    told = {"steps": 1, "length": 0.1, "turned": 1.0, "beyond": 0.0, "change": 0.0, name: value}
    before = Stub(trace=trace)
    after = Stub(steps=told["steps"], trace=trace + told["change"])
    metric = Stub(dot=lambda a, b: told["turned"], oriented=lambda root, unit: unit)
    step = Stub(before=before, after=after, length=told["length"], metric=metric, unit=None)
    shooter = Stub(beyond=lambda root: [(told["beyond"], 0, 0)])
    return arclength._acceptable(shooter, step)


def ends_at(off: float, place: int) -> bool:
    """Whether a curve ends at values that are off its end by a share of their range."""
    values = [2.0, 30.0]
    values[place] += off * (4.0, 50.0)[place]
    one = Stub(points=[Stub(first=9.0, second=9.0), Stub(first=2.0, second=30.0)])
    return atlas._ends_at(one, values, Stub(ranges=((0.0, 4.0), (0.0, 50.0))))


def begins(turns: int = 1, known: int = 0) -> bool:
    """Whether a curve is begun at a point of so many turns in a map of so many curves."""
    point = Stub(orbit=Stub(turns=turns), curves=[], first=1.0, second=1.0, label="P(1;1)")
    old = [Stub(kind="fold", corner="", label="P(2;1:1)", points=[])] * known
    drawn = Stub(curves=list(old), plane=None)
    located = Stub(kind="graze")
    followed = Stub(points=[1, 2, 3])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(codim2, "event_at", lambda point, condition: (located, ""))
        patch.setattr(atlas, "piece", lambda name, work: followed)
        patch.setattr(atlas, "_is_of", lambda one, kind, corner: one.kind == kind)
        atlas._follow_from(lambda *values: (None, None), drawn, point, 0)
    return len(drawn.curves) == known + 1


def same_point(off: float, place: int) -> bool:
    values = [2.0, -30.0]
    values[place] *= 1.0 + off
    one, other = (Stub(first=x, second=y, kind="k", corners=("a",))
                  for x, y in ((2.0, -30.0), values))  # fmt: skip
    return codim2._same(one, other)


def closed(name: str, value: float) -> bool:
    """Whether a curve has come back; its step is 0.01 of the ranges."""
    told = {"back": 0.0, "away": 1.0, "turned": 0.0, name: value}
    first = Stub(whole=[0], theta=[1.0], far=0.0)
    away = Stub(whole=[0], theta=[2.0], far=told["away"])
    last = Stub(whole=[0], theta=[1.0 + told["turned"]], far=told["back"])
    tracer = Stub(step=0.01, _far=lambda one, other: other.far)
    return _Tracer._closes(tracer, [first, away, last])


def advances(name: str, value: float) -> bool:
    """Whether a step along a curve is taken, of 0.01, in which one thing changes so much."""
    told = {"change": 0.0, "turned": 0.0, name: value}
    last = Stub(x=[1.0, 0.5, 700.0], theta=[1.0], whole=[0])
    after = Stub(theta=[1.0 + told["turned"]], value=700.0 + 2.0 * told["change"])
    tracer = Stub(
        step=0.01, spans=[2.0, 2.0], solve=lambda *given: after,
        values=lambda root: [getattr(root, "value", 700.0)] * 2,
        _refusal=lambda *given: None, shooter=lambda *given: None,
    )  # fmt: skip
    return _Tracer._advance(tracer, [last], 0, 1.0).root is not None


def settled_by(step: float) -> bool:
    """Whether the secant method ends with a step so small, of a size of 2.

    The line through 1 + 1/step at -1 and 1 at 0 is zero at the step.
    """
    asked: list[float] = []

    def at(place: float) -> tuple[float, Stub]:
        asked.append(place)
        return {-1.0: 1.0 + 1.0 / step, 0.0: 1.0}.get(place, 0.0), Stub()

    locate.secant(at, -1.0, 1.0, 2.0)
    return len(asked) == 3


def doubled(apart: float) -> bool:
    """Whether a fold is looked into as the doubling of an orbit whose halves are so far apart."""
    asked = []
    root = Stub(count=2, turns=2, x=[1.0, 0.5, 1.0 + apart, 0.5, 700.0], value=700.0,
                whole=[0, 0, 0, 1])  # fmt: skip
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(locate, "replace", lambda root, **more: root)
        patch.setattr(locate, "doubling_near", lambda *given: asked.append(given))
        locate.parent_of(Stub(scale=1.0), Stub(root=root, reach=0.0), 0.0)
    return bool(asked)


def is_told_again(flip: float) -> bool:
    """Whether the doubling at the beginning of a branch is told again; the test is so large."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(locate, "flip_test", lambda root: root)
        patch.setattr(locate, "_root_of", lambda *given: Stub(reach=0.0))
        step = Stub(before=flip, after=-1.0, unit=[1.0])
        return bool(locate.smooth_events(None, step, False, doubling_told=True))


def agrees(off: float, error: float) -> bool:
    """Whether an enclosed value is that of an event of 2, off by so much."""
    try:
        proofs._agree(arb(2.0) + arb(off), Stub(value=2.0, error=error))
    except NotProvedError:
        return False
    return True


def leans(slope: float) -> bool:
    """Whether boxes lean along the parameter, where an impact moves so fast at one end."""
    first = Stub(count=1, x=[1.0, 0.5, 100.0], tangent=[slope, 0.0, 1.0])
    last = Stub(count=1, x=[1.1, 0.5, 102.0], tangent=[0.05, 0.0, 1.0])
    return proofs._leaning([first, last]) == 2


def still(change: float) -> bool:
    """Whether an impact that moves so little counts as one that does not move."""
    first = Stub(count=1, x=[2.0, 0.5, 100.0], tangent=[1.0, 0.0, 1e-30])
    last = Stub(count=1, x=[2.0 + change, 0.5, 102.0], tangent=[1.0, 0.0, 1e-30])
    return proofs._leaning([first, last]) == 2


def nearly_at_strobe(number: int) -> bool:
    """Whether the label of an orbit is tried that has so many impacts at the strobe."""
    inside = arb(1.0, 0.1)
    box = Stub(within=[0.0] * 2 * number, hull=lambda: [inside, arb(1.0)] * number)
    shooting = Stub(n=number, turns=1, places=[Stub(turn=0)] * number)
    steps = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(proofs, "replace", lambda box, error: box)
        patch.setattr(proofs, "product", lambda *sides: steps.append(sides) or ())
        try:
            proofs.prove_label(shooting, box, 1.0, "P(1;1)")
        except NotProvedError:
            return False
    return bool(steps)


def at_strobe(off: float) -> int:
    """On how many sides of the strobe an impact is that lies so far behind it."""
    sides = []
    box = Stub(within=[0.0, 0.0], hull=lambda: [arb(1.0) + arb(off), arb(1.0)])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(proofs, "replace", lambda box, error: box)
        patch.setattr(proofs, "product", lambda *given: sides.extend(given) or ())
        proofs.prove_label(Stub(n=1, turns=1, places=[Stub(turn=0)]), box, 1.0, "P(1;1)")
    return len(sides[0])


def checked_at_strobe(number: int) -> bool:
    """The same of a checker."""
    statement = Stub(strobe=arb(0), impacts=[Stub(turn=0)] * number, turns=1)
    try:
        check.labels(statement, [arb(0, 0.1), arb(1)] * number)
    except check.RefusedError:
        return False
    return True


def first_turn(off: float) -> int:
    """The turn at which the label of two like turns begins; the second is lower by a share."""
    return one_orbit._first_turn([1.0, 1.0], [(1.0, 1.0), (1.0 - off, 1.0)])


def kinked(jump: float) -> bool:
    """Whether the pieces of a fit have a kink where their slopes differ so much."""
    slopes = (0.0, jump)
    stretches = [Stub(seat=False, start=arb(k), end=arb(k + 1),
                      derivatives=lambda theta, order, s=slope: [arb(0), arb(s)])
                 for k, slope in enumerate(slopes)]  # fmt: skip
    orbit = Stub(at=lambda z: Stub(stretches=stretches), places=[Stub(stretch=0)],
                 cam=Stub(seat_restitution=None, kind="pieces"))  # fmt: skip
    return check.kink(orbit, 0, 1, None)


BRANCHES = [
    count("steps of the corrector", lambda steps: accepted("steps", steps), 7),
    near("tangents turned", lambda cosine: accepted("turned", cosine), 0.9, said=(False, True)),
    near("beyond a region", lambda far: accepted("beyond", far), 0.02),
    near("a change of the trace", lambda by: accepted("change", by), 0.45),
    near("a steep trace", lambda trace: accepted("change", 50.0, trace), 100.0, said=(False, True)),
    Limit("a step of no length", lambda length: accepted("length", length), 1e-300, 0.0),
    *(near(f"the end of a curve {k}", lambda off, k=k: ends_at(off, k), 1e-6) for k in (0, 1)),
    count("turns of what is followed from a point", lambda turns: begins(turns), 4),
    Limit("curves of a map", lambda known: begins(known=known), 39, 40),
    *(near(f"one point {k}", lambda off, k=k: same_point(off, k), 1e-9) for k in (0, 1)),
    near("what conserves", lambda off: codim2._CurveSearch._conserves(
        None, Stub(orbit=Stub(det=1.0 + off))), 1e-12),
    near("back", lambda far: closed("back", far), 0.01),
    near("away", lambda far: closed("away", far), 0.03, said=(False, True)),
    near("a step of the free parameter", lambda by: advances("change", by), 0.1),
    near("an impact in a step", lambda by: advances("turned", by), 0.5),
    near("a secant step", settled_by, 2e-13),
    near("halves of a doubled orbit", doubled, 0.05),
    near("a doubling told before", is_told_again, 1e-10, said=(False, True)),
    near("a value within its error", lambda off: agrees(off, 1e-6), 1e-6),
    near("a value within the least error", lambda off: agrees(off, 0.0), 2e-11),
    near("a steep end", leans, 0.2),
    near("what does not move", still, 2e-9),
    count("impacts at the strobe", nearly_at_strobe, 6),
    count("impacts at the strobe of a certificate", checked_at_strobe, 6),
    near("an impact at the strobe", at_strobe, 1e-12, by=1e-2, said=(2, 1)),
    near("states that are one in a label", first_turn, 5e-13, by=1e-2, said=(0, 1)),
    near("pieces of a fit", kinked, 1e-9, said=(False, True)),
    near("at a corner", lambda off: orbits._is_among(1.0 + off, [1.0, 3.0]), 1e-6),
    *(near(f"on a dwell, beyond {place:g}", lambda off, x=place: single_impact.Continuum(
        1, 1.0, 2.0, 0.1).holds(x + (off if x > 1.5 else -off)), 1e-9) for place in (1.0, 2.0)),
]  # fmt: skip


# -- cams ----------------------------------------------------------------------------------------


def corner_of(jump: float) -> bool:
    """Whether a jump of c_thetatheta is a corner where its largest size is 4."""
    stretches = [
        Stub(slope_jump=0.0, start_c2=1.0, end_c2=1.0, accel_min=-4.0, accel_max=1.0),
        Stub(slope_jump=0.0, start_c2=1.0 + jump, end_c2=1.0, accel_min=0.0, accel_max=1.0),
    ]
    return compile.corners(Stub(stretches=stretches)) == [1]


def tail(last: float, power: int) -> bool:
    """Whether the last term of a series does not matter; others have one of a power."""
    sizes = [1.0, 0.0, 1.0, *([0.0] * (power - 3)), last]
    return compile._tail_is_negligible(sizes, 1.0)


def too_coarse(ratio: float) -> bool:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(lift_fit, "_scatters", lambda turn: (ratio, 1.0, nan))
        return lift_fit.bends_between_rows(Stub())


def weight_in_run(rows: int) -> float:
    """The weight of a row in a run of so many equal ones."""
    lift = np.array([0.0] * rows + [1.0, 2.0, 3.0])
    return float(lift_fit._shares(lift)[0])


def strobe_at(off: float) -> float:
    """The phase at which a turn begins that is so far behind an edge of a piece at 2."""
    cuts = [Stub(low=0.0, high=2.0, part=Stub(edges=lambda: [0.0, 2.0]))]
    return compile._at_an_edge(cuts, 2.0 + off)


def has_length(radius: float) -> bool:
    """Whether it is undecided that a part lasts, whose length is a ball about zero."""
    try:
        balls.lasts(arb(1), arb(1) + arb(0, radius))
    except balls.UndecidedError:
        return False
    return True


def steady(fall: float, leaps: int = 1) -> bool:
    """Whether a column is one of angles that rises from 0 to 10 and falls by so much so often."""
    column = [0.0]
    for _ in range(leaps):
        column += [10.0, 10.0 - fall]
    return lift_guess._steady([*column, 10.0])


def is_flank(end: float) -> bool:
    """Whether lifts are a flank whose first step is so large, of 1 in all."""
    return lift_guess._flank([0.0, end, 0.3, 0.6, 0.99, 1.0])


CAMS = [
    near("angles that leap", steady, 5.0, said=(False, True)),
    count("leaps of angles", lambda leaps: steady(8.0, leaps), 20),
    near("a flank flat at its end", is_flank, 0.05),
    near("a corner", corner_of, 4e-9, said=(False, True)),
    near("the tail of a lift", lambda last: tail(last, 4), 1e-18),
    # |T_k''| is k^2 (k^2 - 1)/3 at most: 4 for T_2
    near("the tail of an acceleration", lambda last: tail(last, 40),
         4e-14 * 3.0 / (40.0**2 * (40.0**2 - 1.0))),
    near("rows too far apart", too_coarse, 1.5, said=(False, True)),
    Limit("rows of one lift", weight_in_run, 8, 9, (1.0 / 8.0, 1.0 / 8.0)),
    Limit("fewer rows of one lift", weight_in_run, 7, 8, (1.0 / 7.0, 1.0 / 8.0)),
    near("a strobe at an edge", lambda off: strobe_at(off) == 2.0, 2e-12, by=1e-2),
    near("a length that is rounding", has_length, 1e-30),
    # s^6 of a power of two: 720 * 2e-17/s^6 is the largest seventh derivative
    near("the radius of a Taylor series", compile._radius, 720.0 * 2e-17 * 64.0**6,
         said=(1.0 / 64.0, 1.0 / 128.0)),
]  # fmt: skip

# -- certificates --------------------------------------------------------------------------------


def is_read(form: Any, value: Any) -> bool:
    try:
        check.read(value, form, "here")
    except check.NoCertificateError:
        return False
    return True


def reads(form: Any, make: Callable[[int], Any] = lambda n: n) -> Callable[[int], bool]:
    """Whether a checker reads what is made of a number."""
    return lambda n: is_read(form, make(n))


WHOLE = {  # what a whole number in a certificate counts: its form, its least and its largest
    "index": (check.INDEX, 0, 1_000_000),
    "sign": (check.SIGN, -1, 1),
    "small": (check.SMALL, 1, 9),
    "turn of an impact": (check.PLACE["turn"], 0, 1000),
    "turn of a passage": (check.PASSAGE["turn"], 0, 2000),
    "turns of an orbit": (check.OF_ORBIT["turns"], 1, 1000),
    "cells": (check.SECTION["cells"][0], 1, 1000),
}


def is_beside(apart: float) -> bool:
    """Whether the machine beside one at 5, of a range of 100, is one so far away, used before."""
    used = [Stub(value=5.0 + apart)]
    family = Stub(range=100.0, _recent=used, _beside=lambda value: Stub(value=value + 1e-3))
    sides = family_shooting.FamilyShooting.sides(family, Stub(value=5.0))
    return sides.high.value == 5.0 + apart


def remembered(number: int) -> int:
    """How many machines are remembered of so many."""
    family = Stub(range=100.0, _recent=[Stub(value=6.0 + k) for k in range(number)],
                  _beside=lambda value: Stub(value=value + 1e-3))  # fmt: skip
    family_shooting.FamilyShooting.sides(family, Stub(value=5.0))
    return len(family._recent)


def has_phases(off: float) -> bool:
    root = Stub(count=2, theta=[1.0, 2.0], turn=lambda k: 0)
    phases = [2.0 + TURN, 1.0 + 2.0 * TURN + off]
    return all_orbits._has_phases(Stub(root=root, turns=1), phases, 1)


def starts_at(off: float) -> bool:
    return contact_certificate._at_start([Stub(start=arb(9.0)), Stub(start=arb(1.0))],
                                         1.0 + off) == 1  # fmt: skip


ORBITS = [
    near("a machine near enough to steer", is_beside, 2.0),
    near("machines too near", is_beside, 1e-5, said=(False, True)),
    Limit("machines remembered", remembered, 10, 11, (11, 12)),
    Limit("machines forgotten", remembered, 12, 30, (12, 12)),
    near("phases of one orbit", has_phases, 1e-7),
    near("the start of a stretch", starts_at, 1e-9),
]  # fmt: skip


def test_the_growth_of_a_covering_is_rounded_down_to_nine_digits():
    """Of two boxes of which one covers both and the other the first: the golden mean."""
    growth, weights = section.growth_of(2, ((0, 0), (0, 1), (1, 0)))
    assert growth == 1.618033988
    assert max(weights) == 10**12
    assert weights[1] == pytest.approx(1e12 / 1.6180339887498949, abs=1.0)


FORMS = [
    *(Limit(f"least {name}", reads(form), low, low - 1)
      for name, (form, low, _) in WHOLE.items()),
    *(Limit(f"largest {name}", reads(form), high, high + 1)
      for name, (form, _, high) in WHOLE.items()),
    count("digits before the point", reads(check.exact, lambda n: "-" + "7" * n), 400),
    count("digits behind the point", reads(check.exact, lambda n: "1." + "7" * n), 1200),
    count("digits of a power", reads(check.exact, lambda n: "1e-" + "0" * n), 3),
    count("letters of a formula", reads(check.formula, lambda n: "a+" + "1" * (n - 2)), 2000),
    count("letters of a name", reads(check.identifier, lambda n: "a" * n), 41),
    count("letters of a label", reads(check.text, lambda n: "P" * n), 400),
    near("a size rounded down", lambda x: check.at_least(arb(x)), 0.123,
         said=("0.122", "0.123")),
]  # fmt: skip


# -- searches ------------------------------------------------------------------------------------


def lands(off: float) -> Verdict:
    """The verdict on an orbit of one impact, which is met so far from where it should be."""
    met = certify.LANDED, 2.0 + off, 1
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(certify, "constants_of", lambda *given: None)
        patch.setattr(certify, "fill_crossings", lambda *given: None)
        patch.setattr(certify, "next_contact", lambda *given: met)
        found = certify.certify_orbit(
            None, None, 1, 1, [0, 0], [2.0, 0.5, 700.0], [-0.5], None, [0, 0.0], [None]
        )
    return Verdict(found)


def bears(radius: float) -> bool:
    """Whether a lobe that bears rollers of up to so many base radii bears all."""
    force = Stub(lowest=lambda f: (-1.1 if f.args[1] > radius else -0.9, 0, 1.0))
    geometry = Stub(base=1.0, force=force, kappa=lambda i, theta, roller: 1.0 / radius)
    return lobe._largest_roller(geometry) is None


def with_exponent(value: float) -> bool:
    return "e-" in decimals.exact(value)


def length_followed(impacts: int) -> float:
    """The range in which the branch of an orbit of so many impacts at 700 rpm is followed, rpm."""
    orbit = Stub(root=1, impacts=impacts, rpm=700.0, label="P")
    added: list[Any] = []
    diagram = Stub(holds=lambda root: False, branch_points=[])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(changes, "piece", lambda name, work, instead=None: work())
        patch.setattr(changes, "_add_branch", lambda diagram, root, span: added.append(span))
        changes._follow(diagram, [Stub(orbit=orbit, impacts=impacts, rpm=700.0)],
                        changes.Span(600.0, 800.0, 2.0), changes.Limits())  # fmt: skip
    (span,) = added
    return span.high - span.low, span.spacing


SEARCHES = [
    near("an impact met early", lambda off: lands(-off), 1e-6,
         said=(Verdict.ADMISSIBLE, Verdict.EARLY)),
    near("an impact met late", lands, 1e-6, said=(Verdict.ADMISSIBLE, Verdict.LATE)),
    near("the largest roller", bears, 1000.0, said=(False, True)),
    near("a small double", with_exponent, 1e-30),
    *(near(f"an angle that means nothing, {way:+g}",
           lambda x, w=way: arithmetic.sincos(w * x) == (0.0, 1.0), 1e15, said=(False, True))
      for way in (1.0, -1.0)),
    count("few impacts", length_followed, 4, said=((200.0, 2.0), (16.0, 0.4))),
]  # fmt: skip


@pytest.mark.parametrize("trace", [0.5, -3.0])
def test_how_near_an_event_a_step_is_searched_for_two_of_them(trace):
    """Each impact's place before either corner in rad; a doubling and a fold by the trace."""
    asked: list[tuple[float, float]] = []
    root = Stub(count=2, trace=trace, det=0.64, theta=[1.0, 2.0])
    shooter = Stub(edge=lambda root, k, side: root.theta[k] + side * (0.1 + k))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            locate,
            "beyond_both",
            lambda shooter, step, test, size: asked.append((test(root), size)),
        )
        assert locate.twice_on(shooter, Stub(before=root, after=root)) is None
    inside, by_trace = asked[:4], asked[4:]
    assert inside == [(pytest.approx(gap), 0.05) for gap in (0.1, 0.1, 1.1, 1.1)]
    size = 0.15 * (1.0 + abs(trace))
    values = [abs(1.0 + trace + 0.64), abs(1.0 - trace + 0.64)]
    assert by_trace == [(pytest.approx(value), pytest.approx(size)) for value in values]


@pytest.mark.parametrize("upward", [True, False])
@pytest.mark.parametrize(("left", "right"), [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)])
def test_a_branch_turns_back_at_a_corner_where_its_parameter_does(upward, left, right):
    roots = [Stub(tangent=[-way, 5.0, way]) for way in (left, right)]
    crossing = locate.Crossing(*roots, 0, upward, "a", False, [])
    assert crossing.turns_back == (left != right)
    assert crossing.far is roots[1 if upward else 0]


def test_radii_of_regions_are_tried_by_fifths():
    """From a quarter of the orbit's size down to 1e-8 of it, at which a circle takes their place.

    The map of a turn shrinks by a half, so that the form has to shrink by (1 + ((1 + 1/2)/2)^2)/2.
    """
    tried: list[float] = []
    one = Stub(states=[(1.0, 0.5)], symbols=(1.0,), size=2.0)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(region, "_turn_maps", lambda *given: np.array([np.diag([0.5, 0.3])]))
        patch.setattr(region, "_holds", lambda batches, wanted: tried.append(wanted.radius))
        found = region.region_of(Stub(lift=(0.0, 0.0)), one)
    assert tried == pytest.approx([0.25 * 0.8**k for k in range(len(tried))])
    assert 0.8 * tried[-1] < 1e-8 <= tried[-1]
    assert (found.radius, found.returns, found.symbols) == (1e-8, False, (1,))
    assert found.half_widths() == pytest.approx(np.full((1, 2), 2e-8))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(region, "_turn_maps", lambda *given: np.array([np.diag([0.5, 0.3])]))
        patch.setattr(region, "_holds", lambda batches, wanted: wanted.radius < 0.2)
        found = region.region_of(Stub(lift=(0.0, 0.0)), one)
    assert (found.radius, found.returns) == (pytest.approx(0.25 * 0.8**2), True)
    assert found.shrink == pytest.approx(0.5 * (1.0 + 0.75**2))
    assert found.rho == pytest.approx(0.5)


def test_ellipses_too_thin_for_a_ring_of_starts_are_not_tried():
    """Those with a squared ratio of the axes below 1e-9: a circle takes their place at once."""
    one = Stub(states=[(1.0, 0.5)], symbols=(1.0,), size=1.0)

    def is_tried(ratio: float) -> bool:
        """With the form x^2 + b x y + y^2, whose 1 - b^2/4 is the ratio."""
        form = np.array([[1.0, 2.0 * np.sqrt(1.0 - ratio), 1.0]])
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(region, "_turn_maps", lambda *given: np.array([np.diag([0.5, 0.3])]))
            patch.setattr(region, "_forms", lambda *given: form)
            patch.setattr(region, "_holds", lambda *given: True)
            return region.region_of(Stub(lift=(0.0, 0.0)), one).returns

    assert is_tried(1.02e-9)
    assert not is_tried(0.98e-9)


def test_a_label_is_looked_for_at_speeds_a_fifth_to_either_side():
    """Twenty-four of them, the nearest first; and of a range that is given, in all of it."""
    asked: list[tuple] = []

    def find(system, speed, *numbers):
        asked.append((speed, *numbers[1:]))
        return Stub(orbits=[])

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(orbits, "find", find)
        absent = orbits._look_around(None, None, 500.0, "P(2;1:1)", None)
        given = orbits._look_around(None, None, 500.0, "P(2;1:1)", (480.0, 530.0))
    assert (absent.low, absent.high, given.low, given.high) == (400.0, 600.0, 480.0, 530.0)
    assert {tuple(more) for _, *more in asked} == {(8, "P(2;1:1)", 8)}
    speeds = [speed for speed, *_ in asked]
    assert sorted(speeds[:24]) == pytest.approx(np.linspace(400.0, 600.0, 24))
    assert sorted(speeds[24:]) == pytest.approx(np.linspace(480.0, 530.0, 24))
    for some in (speeds[:24], speeds[24:]):
        away = [abs(speed - 500.0) for speed in some]
        assert away == sorted(away)


def test_so_many_motions_and_close_returns_are_tried_for_a_label(monkeypatch):
    """Beside the scene's own 64 motions; then the 200 closest returns of the scene's own and 4.

    Each motion closes 60 times, later ones more closely.
    """
    tried: list[float] = []
    recorded = iter(range(1, 100))

    def returns(record, label):
        n = next(recorded)
        return [(1.0 / n + 1e-6 * k, (n, k)) for k in range(60)]

    monkeypatch.setattr(search, "free_orbit", lambda *machine: None)
    monkeypatch.setattr(search, "_orbit_from", lambda *motion: tried.append(0.0))
    monkeypatch.setattr(search, "_close_returns", returns)
    monkeypatch.setattr(
        search, "newton_from", lambda shooter, impacts, turns: tried.append(impacts)
    )
    monkeypatch.setattr(search.Shooter, "simulate", lambda *motion: Stub(status=Status.OK))
    label = Label((2.0, 1.0))
    for starts, most in ((0, 65), (100, 101)):
        tried.clear()
        recorded = iter(range(1, 1000))
        found = search.find(chapter_system(), 500.0, settings(10, 1), starts, label)
        assert found.orbits == []
        assert tried[:most] == [0.0] * most
        last = 1 + max(starts, 4)
        closest = [(n, k) for n in range(last, 0, -1) for k in range(60)]
        assert tried[most:] == closest[:200]


LOOKED_FOR = {  # label, what is there; what is done: turns of single impacts, motions, returns
    "all": (None, "", [*range(1, 7), "8 motions"]),
    "all, by equation": (None, "single", [*range(1, 7), "8 motions"]),
    "one impact": ((1.0,), "single", [1]),
    "one impact, on a dwell": ((1.0,), "continuum", [1]),
    "one impact that is not there": ((1.0,), "", [1, "64 motions", "8 returns"]),
    "one impact in three turns": ((1.0, 0.0, 0.0), "", [3, "64 motions", "8 returns"]),
    "three impacts": ((2.0, 1.0), "", ["64 motions", "8 returns"]),
    "three impacts that attract": ((2.0, 1.0), "motion", ["64 motions"]),
    "no impact": ((0.0,), "", []),
    "chatter": ((inf,), "", ["64 motions"]),
    "chatter that attracts": ((inf,), "motion", ["64 motions"]),
}


@pytest.mark.parametrize("name", LOOKED_FOR)
@pytest.mark.parametrize("free", [False, True])
def test_where_orbits_are_looked_for(name, free, monkeypatch):
    """By equation, then among motions, then near close returns, until one of the label is found."""
    symbols, there, wanted = LOOKED_FOR[name]
    label = None if symbols is None else Label(symbols)
    orbit = Stub(label=label, admissible=True, primitive=True, stable=True, turns=1, symbols=())
    done: list = []

    def singles(result, shooter, rpm, turns):
        done.append(turns)
        result.orbits += [orbit] * (there == "single" and turns == 1)
        result.continua += ["all of a dwell"] * (there == "continuum")

    def motions(result, shooter, rpm, settings, count, of):
        done.append(f"{count} motions")
        assert of == label
        result.orbits += [orbit] * (there == "motion")

    standing = Stub(label=Label((0.0,)), admissible=True, primitive=True)
    monkeypatch.setattr(search, "free_orbit", lambda *machine: standing if free else None)
    monkeypatch.setattr(search, "_add_single_impacts", singles)
    monkeypatch.setattr(search, "_add_simulated", motions)
    monkeypatch.setattr(search, "_try_returns", lambda *asked: done.append(f"{asked[3]} returns"))
    result = search.OrbitsFound()
    search._find(result, Stub(system=None), 700.0, None, 8, label, 64)
    assert done == wanted
    assert (standing in result.orbits) == (free and symbols in (None, (0.0,)))


def test_every_point_where_two_curves_meet_is_followed_along_both(monkeypatch):
    """Also those that these curves add: after the next event, of which each edge has one here."""
    followed: list[tuple[str, int]] = []
    to_add = {"an event": ["a", "b"], "a": ["c"], "c": ["d", "e"]}
    stages: list[int] = []
    plane = Stub(names=("rpm", "restitution"), ranges=((1.0, 2.0), (3.0, 4.0)))
    drawn = Stub(plane=plane, curves=[], points=[])

    def add(at, atlas, known):
        atlas.points += to_add.pop(followed[-1][0] if followed else "an event", [])

    monkeypatch.setattr(atlas, "_events_on", lambda *asked: [Stub(orbit=Stub(turns=1))])
    monkeypatch.setattr(atlas, "_follow", lambda *asked: None)
    monkeypatch.setattr(atlas, "_add_points", add)
    monkeypatch.setattr(atlas, "_follow_from", lambda at, of, *curve: followed.append(curve))
    atlas.add_curves(None, None, drawn, 0, lambda: stages.append(len(drawn.points)))
    assert followed == [(point, condition) for point in "abcde" for condition in (0, 1)]
    assert stages == [0, 0, 0, 0, 5]


@pytest.mark.parametrize(("varied", "values"), [(0, (3.0, 5.0)), (1, (5.0, 3.0))])
def test_the_curve_of_an_event_is_followed_on_the_machine_of_its_edge(varied, values, monkeypatch):
    """The first number of the map stands first, whichever of them the edge goes along."""
    asked: list[tuple] = []

    def machine(*numbers):
        asked.append(numbers)
        return f"machine {numbers}", None

    def curve(system, *event):
        asked.append((system, *event))
        return Stub(points=[1, 2])

    monkeypatch.setattr(atlas, "curve", curve)
    drawn = Stub(curves=[], plane="plane")
    kind = next(iter(atlas.FOLLOWED))
    event = Stub(kind=kind, located="located", value=3.0, label="P(1;1)", corner="b")
    atlas._follow(machine, drawn, atlas.Edge(varied, 5.0), event)
    assert asked == [values, (f"machine {values}", "located", "plane", "P(1;1)", "b")]
    assert len(drawn.curves) == 1


def test_a_doubled_orbit_is_not_looked_for_without_a_direction(monkeypatch):
    monkeypatch.setattr(locate, "_flip_vector", lambda shooter, root: None)
    assert locate.doubled(None, Stub(root=None)) is None


@pytest.mark.parametrize("waves", [1, 5, 11, 15])
def test_the_highest_lift_is_on_the_highest_of_the_waves_of_a_stretch(waves, monkeypatch):
    """Each of them once the highest, by a millionth and less."""
    stretch = Stub(start=0.0, end=2.0 * pi)
    for highest in range(waves):
        top = (highest + 0.3) * 2.0 * pi / waves

        def lift(cam, i, x, top=top):
            return 1.0 + 0.5 * np.cos(waves * (x - top)) + 1e-6 * np.cos(x - top), 0.0, 0.0

        monkeypatch.setattr(one_orbit, "lift", lift)
        assert one_orbit._highest(Stub(stretches=[stretch])) == pytest.approx(1.500001, abs=1e-14)


@pytest.mark.parametrize(
    ("column", "is_one"),
    [([0, 1, 2, 3], True), ([0, 1, 1, 3], False), ([2, 3, 0, 1], True), ([2, 2, 0, 1], False)],
)
def test_angles_that_fall_are_those_that_rise_the_other_way_round(column, is_one):
    """A column with two equal angles, or with small steps back, is none; it may leap back."""
    for values in (column, column[::-1], [-x for x in column]):
        assert lift_guess._steady([float(x) for x in values]) is is_one


@pytest.mark.parametrize("drift", [-300.0, 0.0, 300.0])
@pytest.mark.parametrize(("near_end", "far_end"), [(700.0, 800.0), (800.0, 700.0)])
def test_a_fold_is_looked_for_where_it_drifts_to(drift, near_end, far_end):
    """Within 1e-4 about its place, from which the first step alone moves it by twice as much.

    Its height is zero at 750 + 2e-5 rpm.
    """
    asked: list[float] = []

    def lowest(rpm, n, t, half):
        there = 0.4 + drift * (rpm - 750.0)
        asked.append(rpm)
        if abs(t - there) > half:
            return Stub(eta=1.0, t=t, xi=0.0)  # another one
        return Stub(eta=0.3 * (rpm - 750.0 - 2e-5), t=there, xi=0.25)

    folds = Stub(carried=Stub(near=near_end, far=far_end), lowest=lowest)
    fold = tangency.Fold(750.0, 9, 0.4, 1e-4, 0.0, slope=drift)
    found = tangency._secants(folds, fold)
    assert found.rpm == pytest.approx(750.00002, abs=1e-9)
    assert found.t == pytest.approx(0.4 + drift * 2e-5, abs=1e-6)
    assert (found.n, found.half, found.xi) == (9, 1e-4, 0.25)
    assert found.slope == pytest.approx(drift, abs=1e-3)
    assert found.left == tangency.SECANTS - (len(asked) - 1)
    ahead = 1.0 if far_end > near_end else -1.0
    assert (asked[1] - asked[0]) * ahead == pytest.approx(7.5e-7, rel=1e-3)


@pytest.mark.parametrize("strobe", [0.0, 0.5, 2.0, 3.9, 6.2])
@pytest.mark.parametrize("first", range(4))
def test_impacts_are_in_order_since_the_strobe_whichever_of_them_an_orbit_begins_with(
    strobe, first
):
    """Of a period of three turns, in which the strobe lies anywhere."""
    impacts = [(1.0, 0), (4.0, 0), (0.7, 1), (3.9, 2)]  # phase, turn
    impacts = impacts[first:] + [(theta, turn + 3) for theta, turn in impacts[:first]]
    begin = impacts[0][1]
    root = Stub(turns=3, theta=[theta for theta, _ in impacts],
                turn=lambda k: impacts[k][1] - begin)  # fmt: skip
    found = one_orbit._since_strobe(Stub(strobe=strobe), root)
    places = [(theta + 2.0 * pi * (turn - begin) - strobe) % (6.0 * pi) for theta, turn in impacts]
    wanted = sorted(zip(places, range(4), strict=True))
    assert [k for _, k in found] == [k for _, k in wanted]
    assert [place for place, _ in found] == pytest.approx([place for place, _ in wanted])


def test_starts_of_a_cloud_reach_six_lifts_up_and_to_either_side():
    """Halton's first points are 1/2, 1/4, 3/4 in base 2 and 1/3, 2/3, 1/9 in base 3."""
    system = chapter_system()
    c = motion_at_speed.lift_at(system.cam, system.cam.strobe, system.strobe)[0]
    reach = 6.0 * (system.lift_range[1] - system.lift_range[0])
    starts = list(islice(search.cloud(system, 300.0), 3))
    heights = [start.q for start in starts]
    rates = [start.v / (10.0 * pi) for start in starts]
    assert heights == pytest.approx([c + reach * x for x in (1 / 2, 1 / 4, 3 / 4)], rel=1e-3)
    assert rates == pytest.approx([reach * x for x in (-1 / 3, 1 / 3, -7 / 9)], rel=1e-3)


# -- numbers of mathematics ----------------------------------------------------------------------


def test_numbers_of_the_arithmetic_are_those_of_mathematics():
    """Each the nearest double, or a sum of doubles that is exact to what its last one can hold."""
    a = arithmetic
    with mp.workdps(60):
        nearest = {
            a.TWO_OVER_PI: 2 / mp.pi, a.LN2: mp.log(2), a.LOG2_E: 1 / mp.log(2),
            a.TWO_TO_MINUS_32: mpf(2) ** -32, a.SPLIT: mpf(2) ** 27 + 1,
            flow.RAD_PER_S: mpf(pi / 30.0), cam_table.TURN: 2 * mp.pi,
            variational.LARGE: mpf(2) ** 64, variational.SMALL: mpf(2) ** -64,
            enclosed_landing.ULP: mpf(2) ** -53, family_shooting.EPSILON: mpf(2) ** -53,
        }  # fmt: skip
        for number, exact in nearest.items():
            assert number == float(exact)
        sums = {
            (a.PIO2_1, a.PIO2_2, a.PIO2_3): mp.pi / 2, (a.LN2_HI, a.LN2_LO): mp.log(2),
            (flow.RAD_PER_S, flow.RAD_PER_S_REST): mp.pi / 30,
            (orbit_loop.TURN_HIGH, orbit_loop.TURN_LOW): 2 * mp.pi,
        }  # fmt: skip
        for parts, exact in sums.items():
            *first, last = parts
            assert last == float(exact - sum(map(mpf, first)))
        for n in range(11):
            assert getattr(a, f"V{n}") == float(1 / mp.factorial(2 * n + 2))
        for n in range(1, 11):
            assert getattr(a, f"S{n}") == float(1 / mp.factorial(2 * n + 1))
        assert float(mp.exp(a.UNDERFLOW)) == 0.0
        assert float(mp.exp(a.UNDERFLOW + 0.1)) > 0.0  # of its last digit


EVERY = [
    *FORMS,
    *ORBITS,
    *FOLDS,
    *SEARCHES,
    *BASINS,
    *MOTIONS,
    *PLACES,
    *TANGENCIES,
    *RETURNS,
    *BRANCHES,
    *CAMS,
]


@pytest.mark.parametrize("limit", EVERY, ids=[limit.name for limit in EVERY])
def test_a_limit_is_where_it_is_said_to_be(limit):
    assert limit.answers(limit.within) == limit.said[0]
    assert limit.answers(limit.beyond) == limit.said[1]
