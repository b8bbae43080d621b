"""Points of codimension two: where two things happen at once to a periodic orbit with impacts.

On a curve of one bifurcation (`curves`) a second test function changes its sign, or the curve ends
because the orbit reaches something else. There both conditions are solved together, by Newton's
method with both parameters free, in balls of many digits (`camcli.exact.shooting`):
    E(x, p1, p2) = 0     the shooting equations of every flight,
    f1 = 0, f2 = 0       the two conditions,
where a condition is one of
    fold               (1 - trace + det) u_1 .. u_n = 0       a multiplier is +1
    period doubling    (1 + trace + det) u_1 .. u_n = 0       a multiplier is -1
    corner impact      theta_k = the end of its stretch of the cam
    grazing            gap(s) = 0 with gap'(s) = 0, s a further unknown: a flight touches the cam
    fading             u_k = 0: grazing, seen from the orbit that has the impact
    graze at a corner  theta_k + s = the end of a stretch, beside grazing
    cusp               the derivative of the fold's function along the kernel of E_x
The product of the incoming rates u keeps the functions of the multipliers regular where one fades.
What unfolds at each kind of point, and who says so, is told in `PointKind`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import partial
from itertools import pairwise
from math import inf, nextafter, ulp
from typing import Any, NamedTuple

from flint import arb, arb_mat, arb_series, ctx

from camcli.analysis.bracketing import lowest
from camcli.analysis.integrate import BudgetSpentError, spend
from camcli.analysis.orbits.curves import Curve, CurvePoint, Plane
from camcli.analysis.orbits.kinds import Bracket, Kind
from camcli.analysis.orbits.locate import Located
from camcli.analysis.orbits.orbit import PeriodicOrbit, from_root
from camcli.analysis.orbits.proofs import BOXED, shooting_of
from camcli.analysis.orbits.shooter import Root, Shooter, machine_at, place_of, with_machine
from camcli.cams.balls import UndecidedError, precision, slope
from camcli.cams.regions import corner_list
from camcli.cams.varied import can_vary, constants_of, with_number
from camcli.exact.machine import BallMachine, Place, identity, stretches_of, varied_stretches
from camcli.exact.shooting import (
    INFLATIONS,
    ImpactSlopes,
    NotProvedError,
    ProofStep,
    Shooting,
    Touch,
)
from camcli.kernel.cam_table import TURN
from camcli.kernel.certify import Verdict
from camcli.kernel.flow import RPM
from camcli.piece_faults import piece
from camcli.system import System

DIGITS = 80  # decimal digits of the equations
DIFFERENCE = 25  # decimal digits of the width of a difference, which only steers
BEND = 20  # the same, of the difference that a cusp's condition is
MOST_STEPS = 20
LONGEST_STEP = 0.7  # rad, relative: a Newton step beyond which the guess was no good
SOLVED = 30  # decimal digits to which both conditions are solved
TURNED = 0.3  # rad, of an impact, from the place on the curve where a point is looked for
SAMPLES = 180  # of the gap in a turn of flight, between which it dips once at most
EVALUATED = 500  # evaluations of the gap that take as long as the equations of one impact
SAMPLED = 100  # likewise, as one in balls
MOST_DIPS = 3  # lowest places of flights that may have ended a curve, tried one after the other
WIDE_DIFFERENCE = 1e-6  # of the range of a number of the cam that is not known in balls
SOLVED_IN_CAM = 1e-13  # SOLVED where such a number varies, which is a double
BESIDE_IN_CAM = 1e-11  # likewise
BESIDE = 1e-14  # relative distance to either side at which the second test function is taken
SAME_POINT = 1e-9  # relative: two points so close, with the same conditions, are one
UNSOLVED = (NotProvedError, UndecidedError, ZeroDivisionError, ValueError)
CONSERVES = 1e-12  # of det - 1: nothing is lost in an impact, and nothing damps
LOSES_NOTHING = "determinant 1"  # what a curve meets at a machine that conserves


class PointKind(StrEnum):
    """A kind of point of codimension two, and what is known to unfold there.

    Kowalczyk et al. is P. Kowalczyk, M. di Bernardo, A. R. Champneys, S. J. Hogan, M. Homer,
    P. T. Piiroinen, Yu. A. Kuznetsov and A. Nordmark, Two-parameter discontinuity-induced
    bifurcations of limit cycles: classification and open problems, Int. J. Bifurcation and Chaos 16
    (2006) 601. They sort such points into type I (the discontinuity is degenerate: its normal form
    loses a term), type II (a smooth bifurcation of the orbit happens at the same time) and type III
    (two discontinuities at once).

    FOLD_GRAZING, PERIOD_DOUBLING_GRAZING: type II at a graze. The square root of the grazing map
    meets a multiplier +1 or -1 (P. Thota, X. Zhao, H. Dankowicz, Co-dimension-two grazing
    bifurcations in single-degree-of-freedom impact oscillators, J. Computational and Nonlinear
    Dynamics 1 (2006) 328). The curve of folds, or of doublings, ends on that of grazing. A fold's
    is tangent to it: near a fold the orbit, and with it the gap, changes with the square root of
    the parameter. A doubling's crosses it at an angle where the orbit has no impact there, and is
    tangent to it where it has one that fades.
    CORNER_IMPACT_FOLD, CORNER_IMPACT_PERIOD_DOUBLING: type II at a border collision. A curve of
    folds, or of doublings, ends on the curve of corner impacts, the former tangent to it: its
    orbit is virtual beyond. Corner impacts of the doubled orbit begin there, on a curve tangent to
    that of the doublings, which meets the corner impacts of the single one at an angle (A. Colombo
    and F. Dercole, Discontinuity induced bifurcations of nonhyperbolic cycles in nonsmooth systems,
    SIAM J. Applied Dynamical Systems 9 (2010) 62; D. J. W. Simpson and J. D. Meiss, Simultaneous
    border-collision and period-doubling bifurcations, Chaos 19 (2009) 033146).
    DOUBLE_CORNER_IMPACT, DOUBLE_GRAZING, CORNER_IMPACT_GRAZING: type III. The two curves cross;
    each has a kink there, for the orbit behind the other one is another map's.
    CORNER_GRAZING: type I. The flight touches the cam where c_thetatheta jumps, so that the
    coefficient of the square root is another on either side; one curve of corner impacts of the
    grazing impact begins there.
    CUSP: two folds meet and vanish (Yu. A. Kuznetsov, Elements of Applied Bifurcation Theory, 3rd
    ed. 2004, ch. 9).
    CONSERVATIVE: a curve ends at the edge of all machines, where nothing is lost in an impact
    (r = 1) or in flight. That is no meeting of two bifurcations: the determinant is 1 there for
    every orbit, not at this point alone, so that the multiplier of a fold (+1) or of a doubling
    (-1) is double. It is no 1:1 or 1:2 resonance either, at which a curve of Neimark-Sacker
    bifurcations begins (Kuznetsov, the book above, ch. 9.5): these need machines with determinants
    on both sides of 1. On the edge itself the map preserves areas, and folds and doublings of such
    maps are those of K. R. Meyer, Generic bifurcation of periodic points, Trans. American
    Mathematical Society 149 (1970) 95. An orbit of one impact is not generic there: its flight
    begins and ends with the same energy, (c' + u_plus)^2 = (c' + u_minus)^2 with u_plus = -u_minus,
    so that c' = 0 at its impact, as on a dwell or at a corner of it.

    There is no fold-flip, multipliers +1 and -1 at once (Yu. A. Kuznetsov, H. G. E. Meijer and L.
    van Veen, Int. J. Bifurcation and Chaos 14 (2004) 2253): their product, the determinant
    r^(2 n) exp(-b m T/mass), is never negative. Curves of folds and of doublings meet only where an
    impact fades: there both end, at the point where the coefficient of 1/u in the trace is zero,
    and it is told as fold-grazing and as period-doubling-grazing.
    """

    FOLD_GRAZING = "fold-grazing"
    PERIOD_DOUBLING_GRAZING = "period-doubling-grazing"
    CUSP = "cusp"
    CORNER_IMPACT_FOLD = "corner-impact-fold"
    CORNER_IMPACT_PERIOD_DOUBLING = "corner-impact-period-doubling"
    DOUBLE_CORNER_IMPACT = "double-corner-impact"
    CORNER_IMPACT_GRAZING = "corner-impact-grazing"
    DOUBLE_GRAZING = "double-grazing"
    CORNER_GRAZING = "corner-grazing"
    CONSERVATIVE = "conservative"


class Test(StrEnum):
    """A condition's test function; see the head of this file."""

    FOLD = "fold"
    FLIP = "period-doubling"
    CORNER = "corner-impact"
    GRAZE = "grazing"
    FADE = "fading"
    GRAZE_AT_CORNER = "graze-at-corner"
    CUSP = "cusp"


OF_CURVE = {Kind.FOLD: Test.FOLD, Kind.PERIOD_DOUBLING: Test.FLIP, Kind.CORNER_IMPACT: Test.CORNER}
KIND_OF = {
    **{test: kind for kind, test in OF_CURVE.items()},
    Test.GRAZE: Kind.GRAZING,
    Test.FADE: Kind.GRAZING,
}
NAMES = {
    frozenset((Test.FOLD, Test.GRAZE)): PointKind.FOLD_GRAZING,
    frozenset((Test.FOLD, Test.FADE)): PointKind.FOLD_GRAZING,
    frozenset((Test.FLIP, Test.GRAZE)): PointKind.PERIOD_DOUBLING_GRAZING,
    frozenset((Test.FLIP, Test.FADE)): PointKind.PERIOD_DOUBLING_GRAZING,
    frozenset((Test.CORNER, Test.FOLD)): PointKind.CORNER_IMPACT_FOLD,
    frozenset((Test.CORNER, Test.FLIP)): PointKind.CORNER_IMPACT_PERIOD_DOUBLING,
    frozenset((Test.CORNER,)): PointKind.DOUBLE_CORNER_IMPACT,
    frozenset((Test.CORNER, Test.GRAZE)): PointKind.CORNER_IMPACT_GRAZING,
    frozenset((Test.CORNER, Test.FADE)): PointKind.CORNER_IMPACT_GRAZING,
    frozenset((Test.GRAZE,)): PointKind.DOUBLE_GRAZING,
    frozenset((Test.FADE,)): PointKind.DOUBLE_GRAZING,
    frozenset((Test.GRAZE, Test.FADE)): PointKind.DOUBLE_GRAZING,
    frozenset((Test.GRAZE, Test.GRAZE_AT_CORNER)): PointKind.CORNER_GRAZING,
    frozenset((Test.FOLD, Test.CUSP)): PointKind.CUSP,
}


@dataclass(frozen=True)
class Condition:
    """One thing that happens to an orbit.

    impact: the one at a corner, or that fades; of a graze the flight's. side: of a corner, +1 at
    the end of the stretch, -1 at its start. angle: rad of flight to the graze, about.
    """

    test: Test
    impact: int = -1
    side: int = 0
    angle: float = 0.0


@dataclass(frozen=True)
class PointProof:
    """What was shown of a point: ends of an enclosure of each parameter, or the step that failed.

    Exactly one orbit near the point fulfils both conditions, for the machine's numbers as they are,
    and it is a motion but for them.
    """

    step: ProofStep | None = None
    first: tuple[float, float] | None = None
    second: tuple[float, float] | None = None

    @property
    def proved(self) -> bool:
        """Whether no step of the proof failed."""
        return self.step is None


@dataclass(frozen=True)
class CodimTwo:
    """A point at which two conditions hold.

    first, second: the parameters, in Plane.names' order; errors: of each, half the width between
    the places on the first condition's curve at which the second test function has the values
    `before` and `behind`; status: whether these differ in sign. orbit: there, its multipliers on
    the side of a corner that the conditions are on. conditions: what meets; corners: names of
    those that are met, in the conditions' order; curves: numbers of the curves it was found on;
    ends: (number of a curve, 0 or 1) of the first or last ends that curves have here; solution:
    the equations and their zero, where there are any; proof: where it was asked for.
    """

    kind: PointKind
    first: float
    second: float
    errors: tuple[float, float]
    before: float
    behind: float
    status: Bracket
    orbit: PeriodicOrbit
    conditions: tuple[Condition, Condition]
    corners: tuple[str, ...]
    curves: tuple[int, ...]
    ends: tuple[tuple[int, int], ...] = ()
    solution: tuple[Meeting, list[arb]] | None = None
    proof: PointProof | None = None

    def __getstate__(self) -> dict[str, Any]:
        """Pickled, a point is without its equations: they are balls and functions of them."""
        return {**vars(self), "solution": None}

    @property
    def label(self) -> str:
        return self.orbit.label

    @property
    def meets(self) -> list[str]:
        """What meets: the two conditions by name, or one and a determinant of 1."""
        first, second = (str(condition.test) for condition in self.conditions)
        return [first, LOSES_NOTHING if self.kind == PointKind.CONSERVATIVE else second]


class Grazed(NamedTuple):
    """A graze among the conditions of a point, and the stretch and turn that it touches."""

    condition: Condition
    place: Place


class Meeting:
    """The equations of an orbit to which two things happen, in balls.

    The unknowns are those of the orbit, both parameters, and the angle of flight of each graze.
    """

    def __init__(self, system: System, plane: Plane, root: Root, conditions: Sequence[Condition]):
        """At the machine of a root, near which the conditions are to hold.

        Numbers of the cam among the plane's two are taken as balls where the cam's shape allows,
        else as doubles (`in_balls`, `in_doubles`).
        """
        self.plane = plane
        self.system = system
        self.root = root
        self.conditions = tuple(conditions)
        self.base = exact_shooting(system, root)
        self.n = root.count
        member = system.member
        followed = () if member is None else member.family.names
        numbers = [name for name in plane.names if name in followed]
        self.in_balls = [name for name in numbers if can_vary(self.base.shape, name)]
        self.in_doubles = [name for name in numbers if name not in self.in_balls]
        self._cams: dict[tuple[float, ...], Shooting] = {}
        self.grazes = []
        for condition in self.conditions:
            if condition.test == Test.GRAZE:
                phase = arb(root.theta[condition.impact] + condition.angle)
                place = self.base.place(phase, self._turn(condition.impact))
                self.grazes.append(Grazed(condition, place))
        self.branch_direction = [arb(x) for x in root.tangent[:-1]]

    def _turn(self, k: int) -> int:
        """The turn of the period that impact k is in."""
        return self.base.places[k].turn

    def start(self, root: Root, values: Sequence[float]) -> list[arb]:
        """The unknowns u at a root near the point: phases and rates, parameters, graze angles."""
        angles = [arb(graze.condition.angle) for graze in self.grazes]
        return [*map(arb, root.x[:-1]), *map(arb, values), *angles]

    def shooting(self, values: Sequence[Any]) -> Shooting:
        """The shooting equations of the machine with these values of both parameters.

        Over a number of the cam that is not known in balls the nearest double is taken. Raises
        UndecidedError where the values do not tell which parts the cam has.
        """
        numbers = dict(zip(self.plane.names, values, strict=True))
        in_doubles = {name: float(numbers.pop(name).mid()) for name in self.in_doubles}
        in_balls = {name: numbers.pop(name) for name in self.in_balls}
        at = self._with_constants(self._on_cam(in_doubles), numbers)
        if not in_balls:
            return at
        shape = at.shape
        for name, value in in_balls.items():
            shape = with_number(shape, name, value)
        varies = any(isinstance(value, arb_series) for value in in_balls.values())
        stretches = (varied_stretches if varies else stretches_of)(shape)
        if len(stretches) != len(self.base.stretches):
            raise UndecidedError
        on_cam = replace(at, shape=shape).with_stretches(stretches)
        return self._with_constants(on_cam, constants_of(shape))

    def _with_constants(self, shooting: Shooting, numbers: dict[str, Any]) -> Shooting:
        """The same equations, on the same cam, with other constants of the follower or speed."""
        constants = {**vars(shooting.follower), "rpm": shooting.rpm, **numbers}
        rpm = constants.pop("rpm")
        follower = replace(shooting.follower, **constants)
        changed = replace(shooting, follower=follower, rpm=rpm)
        return changed.with_stretches(shooting.stretches)

    def _on_cam(self, in_doubles: dict[str, float]) -> Shooting:
        """The equations on the cam whose numbers have these values, compiled once."""
        key = tuple(in_doubles.values())
        if key not in self._cams:
            machine = self.root.machine
            for name, value in in_doubles.items():
                machine = machine_at(self.system, machine, name, value)
            system, rpm = with_machine(self.system, machine)
            self._cams[key] = replace(
                self.base, shape=system.shape, follower=system.follower, rpm=rpm, parameter="rpm"
            )
        return self._cams[key]

    def equations(self, u: Sequence[arb]) -> list[arb]:
        """Zero at the point: the orbit's equations, then those of the conditions, one value each.

        The slope of the gap at a graze stands before the conditions.
        """
        n = self.n
        x = list(u[: 2 * n])
        angles = list(u[2 * n + 2 :])
        at = self.shooting(u[2 * n : 2 * n + 2])
        machine = at.machine(at.rpm)
        flights = at.flights(machine, x)
        orbit: list[arb] = []
        for k, flight in enumerate(flights):
            next_v = 2 * ((k + 1) % n) + 1
            orbit += [flight.gap, flight.r * flight.rate + x[next_v]]
        grazes = iter(zip(self.grazes, angles, strict=True))
        tests: list[arb] = []
        for condition in self.conditions:
            k = condition.impact
            match condition.test:
                case Test.CORNER:
                    tests.append(x[2 * k] - _corner_phase(at, at.places[k], condition.side))
                case Test.FADE:
                    tests.append(flights[k - 1].rate)
                case Test.GRAZE:
                    graze, angle = next(grazes)
                    gap, gap_slope, _ = at.gap(machine, x, k, graze.place)(angle)
                    orbit.append(gap_slope)
                    tests.append(gap)
                case Test.GRAZE_AT_CORNER:
                    place = self.grazes[0].place
                    turns = self._turn(k) - place.turn
                    phase = x[2 * k] + angles[0] + 2 * arb.pi() * turns
                    tests.append(phase - _corner_phase(at, place, condition.side))
                case Test.CUSP:
                    tests.append(self._bend(at, machine, x))
                case _:
                    sign = -1 if condition.test == Test.FOLD else 1
                    tests.append(_multiplier_test(at, machine, x, sign))
        return orbit + tests

    def _bend(self, at: Shooting, machine: BallMachine, x: list[arb]) -> arb:
        """The derivative of the fold's function in the direction of the kernel of E_x."""
        direction = self._kernel(at, x)
        width = arb(10) ** -BEND

        def fold(way: arb) -> arb:
            """The fold's function a little along the kernel."""
            beside = [a + way * d for a, d in zip(x, direction, strict=True)]
            return _multiplier_test(at, machine, beside, -1)

        return (fold(width) - fold(-width)).mid() / (2 * width)

    def _kernel(self, at: Shooting, x: list[arb]) -> list[arb]:
        """The direction d that the slopes E_x of the equations map to (nearly) zero: d . a = 1.

        a is the direction of the branch at the root. E_x is singular at a fold, so that a column
        and a row are added to it. The column is the kernel from the left, y E_x = 0, itself found
        from the transposed matrix with a on both sides; then the system is regular.
        """
        size = 2 * self.n
        _, slopes = at.equations([*x, at.rpm])
        rows = [[slopes[i, j].mid() for j in range(size)] for i in range(size)]
        transposed = [list(column) for column in zip(*rows, strict=True)]
        last_row = [*self.branch_direction, arb(0)]

        def kernel(matrix: list[list[arb]], column: list[arb]) -> list[arb]:
            """The solution of (matrix column; a 0) (d, s) = (0, 1), without s."""
            bordered = [[*row, b] for row, b in zip(matrix, column, strict=True)]
            right = arb_mat([[arb(0)] for _ in range(size)] + [[arb(1)]])
            solved = arb_mat([*bordered, last_row]).mid().solve(right).mid().entries()
            return solved[:size]

        return kernel(rows, kernel(transposed, self.branch_direction))

    def _width(self, j: int) -> arb:
        """The width of a difference by unknown j: wider by a number that is a double."""
        k = j - 2 * self.n
        if k in (0, 1) and self.plane.names[k] in self.in_doubles:
            low, high = self.plane.ranges[k]
            return arb(WIDE_DIFFERENCE * (high - low))
        return arb(10) ** -DIFFERENCE

    def slopes(self, u: Sequence[arb]) -> arb_mat:
        """The derivatives of the equations, by differences."""
        here = self.equations(u)
        columns = []
        for j in range(len(u)):
            width = self._width(j)
            beside = [*u[:j], u[j] + width, *u[j + 1 :]]
            there = self.equations(beside)
            columns.append([((b - a) / width).mid() for a, b in zip(here, there, strict=True)])
        return arb_mat(columns).transpose()

    def solve(self, u: Sequence[arb], second: arb | None = None) -> list[arb] | None:
        """The zero near u by Newton's method, or None where that does not find it.

        second: the value that the second condition's function, the last equation, is to have; zero
        where none is given.
        """
        at = [x.mid() for x in u]
        for _ in range(MOST_STEPS):
            spend(BOXED * self.n)
            values = self.equations(at)
            if second is not None:
                values[-1] = values[-1] - second
            step = self.slopes(at).solve(arb_mat([[v.mid()] for v in values])).mid().entries()
            relative = [
                abs(float(s)) / max(1.0, abs(float(x))) for s, x in zip(step, at, strict=True)
            ]
            size = max(relative)
            if not size < LONGEST_STEP:
                return None
            at = [(x - s).mid() for x, s in zip(at, step, strict=True)]
            if size < (SOLVED_IN_CAM if self.in_doubles else 10.0**-SOLVED):
                return at
        return None

    def enclosed(self, u: Sequence[arb]) -> list[arb]:
        """A ball for each unknown: exactly one zero of the equations lies in them.

        Krawczyk's method, as in `camcli.exact.shooting`, with the derivatives of all equations by
        series. Raises NotProvedError.
        """
        middle = [x.mid() for x in u]
        size = len(middle)
        try:
            inverse = self.derivatives(middle).mid().inv().mid()
            values = arb_mat([[v] for v in self.equations(middle)])
            off = inverse * values
            radii = [abs(x).upper() * 2 + arb(2) ** (24 - ctx.prec) for x in off.entries()]
            for _ in range(INFLATIONS):
                errors = [arb(0, radius) for radius in radii]
                hull = [x + error for x, error in zip(middle, errors, strict=True)]
                contracting = identity(size) - inverse * self.derivatives(hull)
                image = (contracting * arb_mat([[e] for e in errors]) - off).entries()
                if all(e.contains_interior(x) for e, x in zip(errors, image, strict=True)):
                    return [x + y for x, y in zip(middle, image, strict=True)]
                pairs = zip(radii, image, strict=True)
                radii = [2 * max(radius, abs(x).upper()) for radius, x in pairs]
        except (ZeroDivisionError, ValueError, UndecidedError):
            pass
        raise NotProvedError(ProofStep.SINGULAR)

    def derivatives(self, u: Sequence[arb]) -> arb_mat:
        """The derivatives of the equations by the unknowns, each by series; not of a cusp's."""
        columns = []
        for j in range(len(u)):
            series: list[Any] = [arb_series([x, int(i == j)], 2) for i, x in enumerate(u)]
            columns.append([slope(value) for value in self.equations(series)])
        return arb_mat(columns).transpose()

    def admit(self, hull: Sequence[arb]) -> None:
        """Show that the orbit is a motion but for its conditions; raises NotProvedError.

        hull: balls that hold the unknowns, in their order: phase and rate of every impact, both
        parameters, and for each graze the angle of flight at which the cam is touched.
        """
        impacts = hull[: 2 * self.n]
        parameters = hull[2 * self.n : 2 * self.n + 2]
        angles = hull[2 * self.n + 2 :]
        at_corners = []
        fading = []
        for condition in self.conditions:
            if condition.test == Test.CORNER:
                at_corners.append(condition.impact)
            elif condition.test == Test.FADE:
                fading.append(condition.impact)
        touches = []
        for graze, angle in zip(self.grazes, angles, strict=True):
            touches.append(Touch(flight=graze.condition.impact, angle=angle))
        if len(touches) > 1 or len(fading) > 1 or (touches and fading):
            raise NotProvedError(ProofStep.MODEL)
        shooting = self.shooting(parameters)
        touch = touches[0] if touches else None
        shooting.admissible(
            [*impacts, shooting.rpm], at_corners, touch, fading[0] if fading else None
        )

    def values(self, u: Sequence[arb]) -> tuple[float, float]:
        """Both parameters at the unknowns u."""
        first, second = (float(x.mid()) for x in u[2 * self.n : 2 * self.n + 2])
        return first, second

    def root_at(self, u: Sequence[arb]) -> Root:
        """The orbit at the unknowns u, in doubles."""
        n = self.n
        at = self.shooting(u[2 * n : 2 * n + 2])
        machine = self.root.machine
        for name, value in zip(self.plane.names, self.values(u), strict=True):
            machine = machine_at(self.system, machine, name, value)
        flights = at.flights(at.machine(at.rpm), list(u[: 2 * n]))
        rates = [float(flights[k - 1].rate.mid()) for k in range(n)]
        x = [float(a.mid()) for a in u[: 2 * n]]
        value = machine[self.root.parameter]
        root = replace(self.root, x=[*x, value], machine=machine, rates=rates)
        tests = {condition.test for condition in self.conditions}
        if Test.FOLD in tests:  # also in the limit of a fading impact
            return replace(root, trace=1.0 + root.det)
        if Test.FLIP in tests:
            return replace(root, trace=-1.0 - root.det)
        if Test.FADE in tests:
            return replace(root, trace=inf)
        return replace(root, trace=float(at.trace_det([*u[: 2 * n], at.rpm])[0].mid()))

    def bracketed(self, u: list[arb]) -> tuple[tuple[float, float], float, Bracket]:
        """(errors of both parameters, value of the second test function beside, verdict).

        The first condition's curve is followed to either side, as far as the unknowns change by
        BESIDE; there the second test function must have the values +-, which it does only where it
        goes through zero.
        """
        right = arb_mat([[arb(int(i == len(u) - 1))] for i in range(len(u))])
        tangent = [float(t.mid()) for t in self.slopes(u).solve(right).entries()]
        changes = [abs(t) / max(1.0, abs(float(x))) for t, x in zip(tangent, u, strict=True)]
        largest_change = max(changes)  # relative, of an unknown while the test function grows by 1
        beside = BESIDE_IN_CAM if self.in_doubles else BESIDE
        value = beside / largest_change if largest_change > 0.0 else beside
        here = self.values(u)
        errors = [2.0 * ulp(x) for x in here]
        status = Bracket.OK
        for side in (-1, 1):
            there = self.solve(u, arb(side * value))
            if there is None:
                status = Bracket.UNRESOLVED
                continue
            away = [a - b for a, b in zip(there, u, strict=True)]
            moved = [abs(float(x)) for x in away[2 * self.n : 2 * self.n + 2]]
            errors = [max(a, b) for a, b in zip(errors, moved, strict=True)]
        return (errors[0], errors[1]), value, status


def exact_shooting(system: System, root: Root) -> Shooting:
    """The exact equations of a root, on the cam of its own values; the speed is the parameter."""
    there, _ = with_machine(system, root.machine)
    return shooting_of(there, replace(root, parameter=RPM))


def _corner_phase(at: Shooting, place: Place, side: int) -> Any:
    """Phase (rad, in the turn) of the end (side 1) or the start (-1) of the stretch at a place."""
    stretch = at.stretches[place.stretch]
    return stretch.end if side > 0 else stretch.start


def _multiplier_test(at: Shooting, machine: BallMachine, x: Sequence[arb], sign: int) -> arb:
    """(1 + sign trace + det) u_1 .. u_n, regular where an incoming rate u is zero.

    The monodromy matrix is the product of one matrix a flight, each of whose entries has the factor
    1/u (`Shooting.trace_det`). Here this factor is left out, so the trace comes out multiplied by
    u_1 .. u_n.
    """
    product = ImpactSlopes(arb(1), arb(0), arb(0), arb(1))
    rates = arb(1)
    det = (-2 * machine.Z * machine.turn * at.turns).exp()
    for flight in at.flights(machine, x):
        product = flight.slopes_times_rate().after(product)
        det = det * flight.r * flight.r
        rates = rates * flight.rate
    return (1 + det) * rates + sign * product.trace


# --- proved


def prove(point: CodimTwo) -> PointProof:
    """Enclose both parameters of a point, and show that its orbit is a motion."""
    if point.solution is None or any(c.test == Test.CUSP for c in point.conditions):
        return PointProof(ProofStep.MODEL)
    meeting, u = point.solution
    if meeting.in_doubles:
        return PointProof(ProofStep.CAM)
    try:
        with precision(DIGITS):
            spend(BOXED * meeting.n)
            hull = meeting.enclosed(u)
            meeting.admit(hull)
            first, second = (_outwards(x) for x in hull[2 * meeting.n : 2 * meeting.n + 2])
    except NotProvedError as failed:
        return PointProof(failed.step)
    except BudgetSpentError:
        return PointProof(ProofStep.WORK_BUDGET)
    return PointProof(None, first, second)


def _outwards(x: arb) -> tuple[float, float]:
    """Doubles below and above a ball."""
    return nextafter(float(x.lower()), -inf), nextafter(float(x.upper()), inf)


# --- where on the curves


def event_at(point: CodimTwo, k: int) -> tuple[Located | None, str]:
    """(the event of a point's condition k from which its curve may be followed, its corner).

    None where there is no such curve; the corner's name is empty where the event is at none.
    """
    condition = point.conditions[k]
    root = point.orbit.root
    kind = KIND_OF.get(condition.test)
    if kind is None or root is None or point.solution is None:
        return None, ""
    names_of_corners = iter(point.corners)  # of those conditions that are corner impacts
    names = [next(names_of_corners) if c.test == Test.CORNER else "" for c in point.conditions]
    located = Located(
        kind,
        root,
        reach=0.0,
        error=max(point.errors),
        status=point.status,
        impact=condition.impact,
        side=condition.side,
    )
    if condition.test == Test.FADE:
        located = replace(located, fading=condition.impact, phase=root.theta[condition.impact])
    elif condition.test == Test.GRAZE:
        located = replace(located, phase=(root.theta[condition.impact] + condition.angle) % TURN)
    return located, names[k]


def add_points(
    system: System, curves: Sequence[Curve], plane: Plane, points: list[CodimTwo], known: int = 0
) -> None:
    """Add the points of codimension two on all curves to `points`, in the order of the curves.

    Each is added once; a point that is found again notes the other curve. known: how many of the
    curves, the first ones, have been looked at already. What is in `points` when a `Budget` is
    spent, or a fault happens, may be used.
    """
    for number, curve in enumerate(curves[known:], known + 1):
        name = f"the points of codimension two on curve {number}"
        for point in piece(name, partial(list, _on_curve(system, curve, number, plane)), []):
            same = next((k for k, other in enumerate(points) if _same(point, other)), None)
            if same is None:
                points.append(point)
                continue
            there = points[same]
            numbers = tuple(dict.fromkeys((*there.curves, number)))
            points[same] = replace(there, curves=numbers, ends=(*there.ends, *point.ends))


def _same(a: CodimTwo, b: CodimTwo) -> bool:
    """True for one point, found on two curves or twice on one."""
    pairs = (a.first, b.first), (a.second, b.second)
    close = all(abs(x - y) <= SAME_POINT * max(abs(x), abs(y)) for x, y in pairs)
    return close and a.kind == b.kind and sorted(a.corners) == sorted(b.corners)


def _on_curve(system: System, curve: Curve, number: int, plane: Plane) -> Iterator[CodimTwo]:
    """The points of one curve: at its first end, between its points, at its last end."""
    if curve.located is None or not curve.points:
        return
    search = _CurveSearch(system, curve, number, plane)
    for point in _solvable(lambda: search.at_end(0)):
        yield replace(point, ends=((number, 0),))
    for before, behind in pairwise(curve.points):
        yield from _solvable(partial(search.between, before, behind))
    for point in _solvable(lambda: search.at_end(1)):
        yield replace(point, ends=((number, 1),))


def _solvable(points: Callable[[], Iterator[CodimTwo]]) -> list[CodimTwo]:
    """The points up to the first whose solution fails, in the order in which they come."""
    solved: list[CodimTwo] = []
    with suppress(*UNSOLVED):
        solved.extend(points())
    return solved


def condition_at(system: System, curve: Curve, plane: Plane, root: Root) -> Condition:
    """The condition that holds on a curve, at one of its roots; raises NotProvedError for none."""
    return _CurveSearch(system, curve, 0, plane).own(root)


class _Sample(NamedTuple):
    """A sample of the gap at which it is lower than at both neighbours, ordered by the gap (m).

    angle: rad of flight behind the start of flight k; step: the distance of neighbours, rad.
    """

    gap: float
    flight: int
    angle: float
    step: float


class _CurveSearch:
    """Points of codimension two on one curve."""

    def __init__(self, system: System, curve: Curve, number: int, plane: Plane):
        assert curve.located is not None
        self.system = system
        self.curve = curve
        self.number = number
        self.plane = plane
        self.located = curve.located
        self._known: dict[tuple[float, ...], Condition] = {}

    def own(self, root: Root) -> Condition:
        """The condition that holds on the curve, at one of its roots."""
        key = tuple(root.x)
        if key not in self._known:
            self._known[key] = self._condition(root)
        return self._known[key]

    def _condition(self, root: Root) -> Condition:
        """The condition that a root of the curve fulfils, worked out; `own` remembers it."""
        located = self.located
        if located.fading is not None:
            return Condition(Test.FADE, located.fading)
        if located.kind == Kind.GRAZING:
            dips = self._dips(root, [located.impact])
            if not dips:
                raise NotProvedError(ProofStep.MODEL)
            return min(dips, key=lambda dip: abs(dip[0]))[1]
        if located.kind != Kind.CORNER_IMPACT:
            return Condition(OF_CURVE[located.kind])
        k = located.impact
        stretch = self.system.cam.stretches[root.stretch(k)]
        ends = (stretch.end, 1), (stretch.start, -1)  # the impact is at one of them
        side = min(ends, key=lambda end: abs(root.theta[k] - end[0]))[1]
        return Condition(Test.CORNER, k, side)

    def _dips(self, root: Root, flights: Sequence[int]) -> list[tuple[float, Condition]]:
        """(gap m, the condition that it is zero) of each lowest place of these flights, sorted.

        The gap is sampled; the lowest of the samples are refined.
        """
        with precision(DIGITS):
            base = exact_shooting(self.system, root)
            x = [arb(a) for a in root.x[:-1]]
            machine = base.machine(arb(base.rpm))

            def gap(k: int, s: float) -> float:
                """The gap after s rad of flight k, m."""
                place = base.place(x[2 * k] + s, base.places[k].turn)
                return float(base.gap(machine, x, k, place)(arb(s))[0].mid())

            samples: list[_Sample] = []
            for k in flights:
                length = float(base.span(x, k))
                count = max(8, round(SAMPLES * length / TURN))
                spend(SAMPLED * count)
                step = length / count
                gaps = [gap(k, step * j) for j in range(1, count)]  # gaps[j] after j + 1 steps
                samples += [
                    _Sample(gaps[j], k, step * (j + 1), step)
                    for j in range(1, len(gaps) - 1)
                    if gaps[j] < gaps[j - 1] and gaps[j] <= gaps[j + 1]
                ]
            dips = []
            for sample in sorted(samples)[: MOST_DIPS + 1]:
                low = sample.angle - sample.step
                high = sample.angle + sample.step
                least, angle = lowest(partial(gap, sample.flight), low, high, 2)
                dips.append((least, Condition(Test.GRAZE, sample.flight, angle=angle)))
        return sorted(dips, key=lambda dip: dip[0])

    def values(self, root: Root) -> tuple[float, float]:
        """Both parameters of a root."""
        first, second = (root.machine[place_of(self.system, name)] for name in self.plane.names)
        return first, second

    def between(self, before: CurvePoint, behind: CurvePoint) -> Iterator[CodimTwo]:
        """The points of codimension two between two neighbours on the curve.

        There another test function changes its sign, another impact passes a corner, or the place
        of a graze does. A guess lies where the test function would be zero if it were linear.
        """
        yield from self._corner_passed(before, behind)
        for first, second in self._pairs(before, behind):
            here = self.values(first)
            there = self.values(second)
            distance = tuple(abs(a - b) for a, b in zip(here, there, strict=True))
            tests_there = self._tests(second)
            for condition, test_here in self._tests(first).items():
                test_there = tests_there.get(condition)
                if test_there is None or (test_here < 0.0) == (test_there < 0.0):
                    continue
                share = test_here / (test_here - test_there)
                guess = [a + share * (b - a) for a, b in zip(first.x, second.x, strict=True)]
                values = [a + share * (b - a) for a, b in zip(here, there, strict=True)]
                yield from self._solved(replace(second, x=guess), values, distance, condition)
            if self.own(first).test == Test.GRAZE:
                yield from self._corner_grazing(first, second, distance)

    def _corner_passed(self, before: CurvePoint, behind: CurvePoint) -> Iterator[CodimTwo]:
        """The point at which another impact passes a corner, between two points of the curve."""
        first = before.orbit.root
        second = behind.orbit.root
        if first is None or second is None or first.whole == second.whole:
            return
        one_step = tuple((high - low) / self.plane.steps for low, high in self.plane.ranges)
        for k in range(first.count):
            place_before = (first.turn(k), first.stretch(k))
            place_behind = (second.turn(k), second.stretch(k))
            if place_before == place_behind:
                continue
            side = 1 if place_behind > place_before else -1
            if self._corner(first, k, side):
                condition = Condition(Test.CORNER, k, side)
                yield from self._solved(first, self.values(first), one_step, condition)

    def _corner_grazing(
        self, first: Root, second: Root, distance: Sequence[float]
    ) -> Iterator[CodimTwo]:
        """The point at which the flight touches a corner, if it does so between two roots.

        distance: between the two roots, in each parameter.
        """
        places = []
        for root in (first, second):
            own = self.own(root)
            base = exact_shooting(self.system, root)
            theta = arb(root.theta[own.impact] + own.angle)
            places.append(base.place(theta, base.places[own.impact].turn))
        if places[0] == places[1]:
            return
        order = [(place.turn, place.stretch) for place in places]
        side = 1 if order[1] > order[0] else -1
        condition = Condition(Test.GRAZE_AT_CORNER, self.own(first).impact, side)
        yield from self._solved(first, self.values(first), distance, condition)

    def _pairs(self, before: CurvePoint, behind: CurvePoint) -> Iterator[tuple[Root, Root]]:
        """Roots of one smooth map at both points: at a corner one pair for each of its sides."""
        pairs = [(before.orbit.root, behind.orbit.root)]
        if before.crossing is not None and behind.crossing is not None:
            pairs = [
                (before.crossing.left, behind.crossing.left),
                (before.crossing.right, behind.crossing.right),
            ]
        for a, b in pairs:
            if a is not None and b is not None and a.whole == b.whole:
                yield a, b

    def _tests(self, root: Root) -> dict[Condition, float]:
        """The values at a point of the test functions whose zeros are points of codimension two.

        On a curve of folds that is the cusp's, on one of doublings none, elsewhere both of these.
        """
        own = self.own(root)
        wanted: tuple[Test, ...] = (Test.FOLD, Test.FLIP)
        if own.test == Test.FOLD:
            wanted = (Test.CUSP,)
        elif own.test == Test.FLIP:
            wanted = ()
        tests = {}
        with precision(DIGITS):
            for test in wanted:
                spend(EVALUATED * root.count)
                meeting = Meeting(self.system, self.plane, root, [Condition(test)])
                u = meeting.start(root, self.values(root))
                with suppress(ZeroDivisionError, ValueError, UndecidedError):
                    value = float(meeting.equations(u)[-1].mid())
                    tests[Condition(test)] = value
        return tests

    def at_end(self, end: int) -> Iterator[CodimTwo]:
        """What the curve meets at its first (0) or last (1) end: nothing where its range ends.

        What may have ended it is tried, the likeliest first, until a point is found.
        """
        curve = self.curve
        point = curve.points[0] if end == 0 else curve.points[-1]
        root = point.orbit.root
        if root is None:
            return
        if self._conserves(point) and not all(map(self._conserves, curve.points)):
            yield self._conservative(point, root)
            return
        if curve.ends[end] == Kind.END_OF_RANGE:
            return
        room = tuple((high - low) / self.plane.steps for low, high in self.plane.ranges)
        if curve.ends[end] == Kind.SHORTER_ORBIT:
            points = list(self._collapse(root, room))
            yield from points
            if points:
                return
        for condition in self._causes(root, curve.beyond[end]):
            points = list(self._solved(root, self.values(root), room, condition))
            yield from points
            if points:
                return
        yield from self._collapse(root, room)

    def _collapse(self, root: Root, room: Sequence[float]) -> Iterator[CodimTwo]:
        """The point at which a doubled orbit becomes the single one, where its curve ends there.

        The single orbit, made of the means of both halves, has its period doubling there, and the
        curve's own condition. room: how far away the point may be, in each parameter.
        """
        if root.count % 2 or root.turns % 2:
            return
        n = root.count // 2  # impacts of the single orbit
        first_half = root.x[: 2 * n]
        second_half = root.x[2 * n : -1]
        halves = list(zip(first_half, second_half, strict=True))
        phases = halves[::2]  # each impact's phase and rate stand one after the other
        if any(abs(first - second) > TURNED for first, second in phases):
            return
        single = replace(
            root,
            x=[*(0.5 * (first + second) for first, second in halves), root.value],
            whole=root.whole[: 2 * n],
            turns=root.turns // 2,
            rates=root.rates[:n],
            tangent=[*root.tangent[: 2 * n], root.tangent[-1]],
        )
        own = self.own(root)
        if own.test in (Test.CORNER, Test.FADE, Test.GRAZE):
            own = replace(own, impact=own.impact % n)
            yield from self._solved(single, self.values(root), room, Condition(Test.FLIP), own)

    def _conserves(self, point: CurvePoint) -> bool:
        """Whether nothing is lost, in an impact or in flight."""
        return abs(point.orbit.det - 1.0) < CONSERVES

    def _conservative(self, point: CurvePoint, root: Root) -> CodimTwo:
        """The end of a curve at a machine that loses nothing, where the others do lose."""
        own = self.own(root)
        at_corner = own.test == Test.CORNER
        return CodimTwo(
            kind=PointKind.CONSERVATIVE,
            first=point.first,
            second=point.second,
            errors=(2.0 * ulp(point.first), 2.0 * ulp(point.second)),
            before=0.0,
            behind=0.0,
            status=Bracket.OK,
            orbit=point.orbit,
            conditions=(own, own),
            corners=(self._corner(root, own.impact, own.side),) if at_corner else (),
            curves=(self.number,),
        )

    def _causes(self, root: Root, beyond: Root | None) -> Iterator[Condition]:
        """What may have ended the curve at a root, the likeliest first.

        beyond: the root behind it that was refused, which shows it; then comes all there is.
        """
        own = self.own(root)
        if beyond is not None:
            shooter = self._shooter(beyond)
            for _, k, side in sorted(shooter.beyond(beyond), reverse=True):
                if k != self.located.impact and self._corner(beyond, k, side):
                    yield Condition(Test.CORNER, k, side)
            verdict, k, phase = shooter.verdict(beyond)
            if verdict == Verdict.EARLY:
                yield Condition(Test.GRAZE, k, angle=(phase - beyond.theta[k]) % TURN)
        slowest = min(range(root.count), key=lambda k: abs(root.rates[k]))
        yield Condition(Test.FADE, slowest)
        if own.test == Test.FOLD:
            yield Condition(Test.CUSP)
        elif own.test == Test.GRAZE:
            yield Condition(Test.FOLD)
            yield Condition(Test.FLIP)
        for _, dip in self._dips(root, range(root.count))[:MOST_DIPS]:
            near = abs(dip.angle - own.angle) < TURNED
            is_own = own.test == Test.GRAZE and dip.impact == own.impact and near
            if not is_own:
                yield dip

    def _corner(self, root: Root, k: int, side: int) -> str:
        """The name of the corner at which impact k's stretch ends on this side, or empty."""
        stretches = self.system.cam.stretches
        i = root.stretch(k)
        boundary = (i + 1) % len(stretches) if side > 0 else i  # the stretch that begins there
        names = {corner.stretch: corner.name for corner in corner_list(self.system.cam)}
        return names.get(boundary, "")

    def _shooter(self, root: Root) -> Shooter:
        """A shooter for the machine of a root."""
        return Shooter(*with_machine(self.system, root.machine))

    def _solved(
        self,
        guess: Root,
        values: Sequence[float],
        room: Sequence[float],
        condition: Condition,
        own: Condition | None = None,
    ) -> Iterator[CodimTwo]:
        """The point near a guess at which the curve's own condition meets another one, if any.

        room: how far from `values` it may be in either parameter; own: None for that of the guess.
        """
        own = own or self.own(guess)
        if condition == own:
            return
        with precision(DIGITS), suppress(*UNSOLVED):
            meeting = Meeting(self.system, self.plane, guess, [own, condition])
            u = meeting.solve(meeting.start(guess, values))
            if u is not None and self._near(meeting, u, guess, values, room):
                yield self._point(meeting, u)

    def _near(
        self,
        meeting: Meeting,
        u: Sequence[arb],
        guess: Root,
        values: Sequence[float],
        room: Sequence[float],
    ) -> bool:
        """True where the solution is the one looked for, and within the plane."""
        pairs = zip(meeting.values(u), values, room, self.plane.ranges, strict=True)
        for x, y, most, (low, high) in pairs:
            if abs(x - y) > most or not low <= x <= high:
                return False
        thetas = zip(u[: 2 * meeting.n : 2], guess.theta, strict=True)
        return max(abs(float(a) - b) for a, b in thetas) < TURNED

    def _point(self, meeting: Meeting, u: list[arb]) -> CodimTwo:
        """The point at the solution u of the meeting's equations, its orbit in doubles."""
        root = meeting.root_at(u)
        first, second = meeting.values(u)
        errors, test_value, status = meeting.bracketed(u)
        own, other = meeting.conditions
        kind = NAMES[frozenset((own.test, other.test))]
        fades_at_corner = {own.test, other.test} == {Test.FADE, Test.CORNER}
        if fades_at_corner and own.impact == other.impact:
            kind = PointKind.CORNER_GRAZING
        corners = [
            self._corner(root, c.impact, c.side) for c in (own, other) if c.test == Test.CORNER
        ]
        return CodimTwo(
            kind=kind,
            first=first,
            second=second,
            errors=errors,
            before=-test_value,
            behind=test_value,
            status=status,
            orbit=from_root(self.system, root),
            conditions=(own, other),
            corners=tuple(corners),
            curves=(self.number,),
            solution=(meeting, u),
        )
