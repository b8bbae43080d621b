"""Which of the orbits and events found are proved, in ball arithmetic (`camcli.exact.shooting`).

The data are those of the scene as doubles, exactly, but for the flank circle of a cam of arcs: its
radius is the exact sum that closes it (`cams.arcs`). Of the orbits found it is also asked whether
the same holds for every value of the parameter that rounds to theirs (`HoldsFor`). An orbit is
proved where a box holds exactly one orbit of its impacts, agrees with the numbers found, is a
motion, and has its multipliers inside or outside the unit circle; an event where its parameter is
enclosed and the test function crosses zero there. An orbit that rests is followed exactly until it
repeats (`camcli.analysis.after_rest`).

Terms of this file. A box, a hull and the unknowns z are those of `camcli.exact.shooting`: z holds
phase and outgoing rate of each impact and then the parameter, the hull is a ball for each. A range
is a part of a branch proved from end to end, by boxes that overlap. A change is an event at which
an orbit that rests, or never meets the cam, appears or ends; it has no test function, but is
enclosed in a bracket. All other events have been located (`camcli.analysis.orbits.locate`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import pairwise, product
from math import inf, nextafter, ulp
from typing import TYPE_CHECKING, Any, NamedTuple

from flint import arb, ctx

from camcli.analysis.after_rest import CYCLE, HoldsFor, cycle, of_machine
from camcli.analysis.border_collision import Rule
from camcli.analysis.integrate import BudgetSpentError, spend
from camcli.analysis.labels import CONTACT, Label
from camcli.analysis.orbits.attraction import Axes, attraction
from camcli.analysis.orbits.curves import Curve, CurvePoint, touch_near
from camcli.analysis.orbits.evidence import Evidence
from camcli.analysis.orbits.kinds import Bracket, Kind
from camcli.analysis.orbits.locate import Located
from camcli.analysis.orbits.orbit import PeriodicOrbit
from camcli.analysis.orbits.shooter import (
    PLACES,
    Root,
    Shooter,
    machine_at,
    table_of,
    with_machine,
)
from camcli.analysis.orbits.starts import Starts
from camcli.analysis.orbits.study import Bifurcation, Branch, OrbitsResult
from camcli.cams.balls import UndecidedError, below, number, precision, slope
from camcli.cams.compile import Shape
from camcli.cams.varied import can_vary
from camcli.exact.first_root import first_root
from camcli.exact.machine import BallMachine
from camcli.exact.motion import BallMotion, EndlessError
from camcli.exact.shooting import (
    Box,
    NotProvedError,
    Number,
    Place,
    ProofStep,
    Shooting,
    TestFunction,
    Touch,
    varied_machine,
)
from camcli.piece_faults import piece
from camcli.system import CONSTANTS, Follower, System

if TYPE_CHECKING:
    from camcli.analysis.orbits.curve_proofs import CurveRange

DIGITS = 60, 240  # decimal digits of the balls; the second number where the first is not enough
CHANGE_DIGITS = 150  # decimal digits, for the bracket of a change
MORE_DIGITS = {
    ProofStep.SINGULAR,
    ProofStep.GRAZES,
    ProofStep.NEUTRAL,
}  # steps that more digits may decide
SHOWN = 30  # digits of an enclosure as text
AGREES = 1e-10  # of 1 rad and the largest rate: numbers so near to the orbit are its own
PARAMETER_ROUNDING = (
    1e-13  # relative error of the parameter that the numbers of an orbit may stand for
)
AT_STROBE = 1e-12  # rad: a box so near to the strobe, which a double rounds, is on both its sides
MOST_AT_STROBE = 6  # impacts of one orbit that may lie on either side of the strobe
SAME_PHASE = 1e-6  # rad: impacts of one orbit, at an event
LEAST_ERROR = 1e-11  # relative: an event's value is trusted to it at most
INSIDE = 1e-9  # rad within a stretch of the kernel's table, to find the exact one
WIDENINGS = 16  # of the bracket of a change, each by a factor of four
CHANGE_HALVINGS = 40  # of the bracket of a change: some twelve digits more
MOST_PROVED = 64  # impacts in a period; an orbit with more is not proved
REACHES = (0.3, 0.1, 1e-2, 1e-3, 1e-4, 1e-5)  # of the way to the next point: boxes about events
MOST_BOXES = 4800  # of one range, over the number of impacts
STEEP_SLOPE = 4.0  # times the mean slope: near a fold, or where a doubled orbit is born
UNMOVED = 1e-9  # of an unknown: a change no larger is a rounding
SLOWEST = 0.2  # share of MOST_BOXES that may be spent before the first progress
OVERLAP = 1.01  # factor by which a box is wider than its part of the way, to meet the next one
WRITTEN_WIDER = 1.02  # factor by which the errors of a box are at most wider in a certificate
BOXED = 20_000  # evaluations of the gap that take as long as a box, for each of its impacts
NARROWEST_BOX = 1e-12  # of a range: a box this narrow that fails ends the proof


@dataclass(frozen=True)
class Proof:
    """What was shown of an orbit or of an event.

    step: the step of the proof that failed, None where all is proved; refuted: the contrary was
    shown; box: phase (rad) and outgoing rate (m/rad) of every impact, value: the parameter at an
    event, as text "[middle +/- radius]"; low, high: doubles below and above that value; signs: 1
    or -1 for each condition of a corner impact, none where the slope of the cam jumps;
    holds_for: the machines that the proof is about;
    axes: of the ellipses about its impacts from which all motions tend to a stable orbit, rad and
    m/rad (`attraction`); starts: how many starts at the strobe come from these; evidence: what a
    certificate says of it, None where it has no statement of this kind.
    """

    step: ProofStep | None = None
    refuted: bool = False
    box: tuple[str, ...] = ()
    value: str = ""
    low: float | None = None
    high: float | None = None
    signs: tuple[tuple[Rule, int], ...] = ()
    holds_for: HoldsFor = HoldsFor.EXACT_DATA
    axes: Axes = ()
    starts: Starts | None = None
    evidence: Evidence | None = field(default=None, compare=False, repr=False)

    @property
    def proved(self) -> bool:
        """Whether no step of the proof failed."""
        return self.step is None


@dataclass(frozen=True)
class Range:
    """A part of a branch proved from end to end: boxes that overlap, every orbit in them a motion.

    branch: the branch's number; label, stable: those of all its orbits; low, high: the parameter at
    the ends, as text; boxes: how many it took; failed_step: None where the range is proved;
    evidence: what a certificate says of it.
    """

    branch: int
    label: str
    stable: bool
    low: str
    high: str
    boxes: int = 0
    failed_step: ProofStep | None = None
    evidence: Evidence | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True)
class Proofs:
    """The proofs of a study's orbits, of each branch's points, and of its events, in its order.

    ranges: those of all branches, proved or not; curves: of each curve's points, where one number
    is enclosed and the other one is the double that it is; curve_ranges: the parts of all curves
    between their points, proved or not; flank_excess: by how many metres the
    radius of the cam's flank circle, as the proofs take it, is larger than the scene's.
    """

    orbits: list[Proof]
    points: list[list[Proof]]
    events: list[Proof]
    ranges: list[Range]
    flank_excess: float = 0.0
    curves: list[list[Proof]] = field(default_factory=list)
    curve_ranges: list[CurveRange] = field(default_factory=list)

    def without_evidence(self) -> Proofs:
        """The proof without its boxes, which take room and cannot be pickled."""
        return replace(
            self,
            orbits=[replace(one, evidence=None) for one in self.orbits],
            events=[replace(one, evidence=None) for one in self.events],
            curves=[[replace(one, evidence=None) for one in points] for points in self.curves],
            ranges=[replace(one, evidence=None) for one in self.ranges],
            curve_ranges=[replace(one, evidence=None) for one in self.curve_ranges],
        )


def prove(system: System, study: OrbitsResult) -> Proofs:
    """Prove all orbits, branches and events of a study; a proof that fails says at which step.

    The study's orbits lie at a speed, its branches and events at values of its parameter, which may
    be another constant. An exception that nobody foresaw costs its proof alone.
    """
    parameter = study.question.parameter

    def tried(what: str, proof: Callable[[], Proof]) -> Proof:
        """The proof, or where it ends in an exception, one that failed."""
        return piece(f"the proof of {what}", proof, Proof(ProofStep.FAULT))

    orbits = []
    for orbit in study.orbits:
        what = f"{orbit.label} at {orbit.rpm!r} rpm"
        orbits.append(tried(what, partial(prove_widely, system, orbit)))
    points_of_branches = []
    for branch in study.branches:
        proofs_of_points = []
        for point in branch.points:
            what = f"branch {branch.number} at {point.value!r}"
            proof = partial(_without_evidence, system, point, parameter)
            proofs_of_points.append(tried(what, proof))
        points_of_branches.append(proofs_of_points)
    events = []
    for event in study.bifurcations:
        what = f"the {event.kind} at {event.value!r}"
        events.append(tried(what, partial(prove_event, system, event, parameter)))
    ranges: list[Range] = []
    for branch in study.branches:
        name = f"the proof of branch {branch.number}"
        ranges += piece(name, partial(_ranges_of_branch, system, branch, study.bifurcations), [])
    points_of_curves = []
    for curve_number, curve in enumerate(study.curves, 1):
        proofs_of_points = []
        for on_curve in curve.points:
            what = f"curve {curve_number} at {on_curve.first!r}, {on_curve.second!r}"
            proof = partial(prove_on_curve, system, curve, on_curve)
            proofs_of_points.append(tried(what, proof))
        points_of_curves.append(proofs_of_points)
    return Proofs(
        orbits=orbits,
        points=points_of_branches,
        events=events,
        ranges=ranges,
        # only a cam of arcs has circles to close
        flank_excess=getattr(system.shape, "flank_excess", 0.0),
        curves=points_of_curves,
    )


def _ranges_of_branch(
    system: System, branch: Branch, bifurcations: Sequence[Bifurcation]
) -> list[Range]:
    """The ranges of a branch, proved or not.

    Its own events come first: one that leaves from an event of another branch begins there.
    """
    own = [event for event in bifurcations if event.branch == branch.number]
    others = [event for event in bifurcations if event.branch != branch.number]
    return list(prove_ranges(system, branch, own + others))


def _without_evidence(system: System, orbit: PeriodicOrbit, parameter: str) -> Proof:
    """The proof of a point of a branch; what it rests on is not kept, the ranges have their own."""
    return replace(prove_orbit(system, orbit, parameter), evidence=None)


def prove_widely(system: System, orbit: PeriodicOrbit) -> Proof:
    """Prove an orbit, if possible for every speed that rounds to its own.

    Of a stable one that bounces also how far it certainly attracts, for its own speed.
    """
    proof = prove_orbit(system, orbit)
    if proof.proved:
        if orbit.stable and proof.evidence is not None:
            with precision(DIGITS[0]):
                axes = attraction(proof.evidence)
            proof = replace(proof, axes=axes or ())
        wide = prove_orbit(system, orbit, half=ulp(orbit.rpm) / 2)
        if wide.proved:
            return replace(proof, holds_for=HoldsFor.LAST_DIGIT, evidence=wide.evidence)
    return proof


def prove_orbit(
    system: System, orbit: PeriodicOrbit, parameter: str = "rpm", half: float = 0.0
) -> Proof:
    """Prove an orbit at its value of the parameter, or at all values within `half` of that.

    It is tried with more digits where these may decide it. An orbit that bounces goes by its
    shooting equations, any other by the motion itself, and by that at a range of speeds only.
    """
    if orbit.root is None and parameter != "rpm":
        there = machine_at(system, table_of(system, orbit.rpm), parameter, orbit.value)
        system, _ = with_machine(system, there)
    failure = NotProvedError(ProofStep.MODEL)
    for digits in DIGITS:
        try:
            _spend(len(orbit.theta))
            with precision(digits):
                if orbit.root is not None:
                    return _bouncing(system, orbit.root, orbit.stable, half, orbit.label)
                if half and parameter != "rpm":
                    raise NotProvedError(ProofStep.MODEL)
                if orbit.free:
                    return _free(system, orbit, widely=bool(half))
                return _resting(system, orbit, widely=bool(half))
        except NotProvedError as failed:
            failure = failed
            if failed.step not in MORE_DIGITS or failed.refuted:
                break
    return Proof(failure.step, failure.refuted)


def prove_event(system: System, event: Bifurcation, parameter: str = "rpm") -> Proof:
    """Enclose the parameter of an event and prove its crossing condition.

    The event of an orbit that rests on the cam, or never meets it, has a bracket instead, with the
    orbit at one end only.
    """
    try:
        _spend(len(event.orbit.theta))
        with precision(CHANGE_DIGITS if event.located is None else DIGITS[0]):
            if event.located is not None:
                return _located(system, event, event.located)
            return _change(system, event, parameter)
    except NotProvedError as failed:
        return Proof(failed.step, failed.refuted)


def prove_on_curve(system: System, curve: Curve, point: CurvePoint) -> Proof:
    """Prove a point of a curve: enclose the number that was solved for, at the double of the other.

    A graze is looked for where the flight of this very point comes nearest to the cam.
    """
    root = point.orbit.root
    if root is None or curve.located is None:
        return Proof(ProofStep.MODEL)
    name = _name(system, root.parameter)
    located = replace(curve.located, root=root)
    if curve.kind == Kind.GRAZING and located.fading is None:
        shooter = Shooter(*with_machine(system, root.machine), name)
        angle = touch_near(shooter, root, located)[1]
        located = replace(located, phase=root.theta[located.impact] + angle)
    event = Bifurcation(
        branch=0, kind=curve.kind, value=root.value, error=0.0, status=Bracket.OK,
        orbit=point.orbit, corner=curve.corner, located=located,
    )  # fmt: skip
    return prove_event(system, event, name)


def _spend(impacts: int) -> None:
    """Count the work of a box; raises NotProvedError where there is a `Budget`, and it is spent."""
    try:
        spend(BOXED * max(1, impacts))
    except BudgetSpentError:
        raise NotProvedError(ProofStep.WORK_BUDGET) from None


def shooting_of(system: System, root: Root, most_impacts: int = MOST_PROVED) -> Shooting:
    """The exact equations that a root of the shooting equations in doubles solves.

    Each impact is given its stretch of the exact cam and its turn by those of the kernel's table.
    Raises NotProvedError where the root has more impacts than `most_impacts`, or where the
    parameter is a number of the cam over which the cam is not known in balls.
    """
    if root.count > most_impacts:
        raise NotProvedError(ProofStep.MODEL)
    changed, rpm = with_machine(system, root.machine)
    name = _name(system, root.parameter)
    if name not in PLACES and not can_vary(changed.shape, name):
        raise NotProvedError(ProofStep.CAM)
    empty = Shooting(changed.shape, changed.follower, rpm, name, (), root.turns)
    places = []
    for k, theta in enumerate(root.theta):
        stretch = changed.cam.stretches[root.stretch(k)]
        inside = min(INSIDE, 0.25 * (stretch.end - stretch.start))
        at = min(max(theta, stretch.start + inside), stretch.end - inside)
        places.append(empty.place(arb(at), root.turn(k)))
    return replace(empty, places=tuple(places))


def _name(system: System, place: int) -> str:
    """The parameter at a place of the kernel's table."""
    if system.member is not None and place >= CONSTANTS:
        return system.member.family.names[place - CONSTANTS]
    return next(name for name, k in PLACES.items() if k == place)


def _bouncing(system: System, root: Root, stable: bool, half: float, label: str) -> Proof:
    """Prove an orbit that bounces at every impact, or raise NotProvedError.

    A box within `half` of its parameter holds one orbit each; it agrees with the numbers found, is
    a motion, and has the stability and the label found.
    """
    shooting = shooting_of(system, root)
    parameter = 2 * root.count  # its index in z
    box = shooting.box([arb(x) for x in root.x], parameter, arb(half))
    hull = box.hull()
    largest_rate = max(abs(v) for v in root.x[1:-1:2])
    for k, claimed in enumerate(root.x[:-1]):
        is_rate = k % 2 == 1
        size = largest_rate if is_rate else 1.0
        allowed = AGREES * size + PARAMETER_ROUNDING * abs(root.value) * abs(box.tangent[k])
        if not abs(hull[k] - claimed) < allowed:
            raise NotProvedError(ProofStep.NO_ORBIT)
    shooting.admissible(hull)
    _prove_stability(shooting, box, stable)
    prove_label(shooting, box, system.strobe, label)
    return Proof(box=_texts(hull[:-1]), evidence=Evidence(ctx.prec, shooting, (box,)))


def _prove_stability(shooting: Shooting, box: Box, stable: bool) -> None:
    """Show that both multipliers lie inside the unit circle, or one outside, as `stable` says.

    These are Jury's conditions on trace and determinant. Where the balls that hold those of all
    orbits of the box are too wide, they are taken from the middle orbit and from their derivatives
    along the branch. Raises NotProvedError.
    """
    trace, det = shooting.trace_det(box.hull())
    if _certainly_stable(trace, det) is None:
        eta = arb(0, box.half)
        along_branch = shooting.trace_det(shooting.along(box.hull(), box.fixed))
        in_middle = shooting.trace_det(box.orbit_at(arb(0)))
        trace = in_middle[0] + slope(along_branch[0]) * eta
        det = in_middle[1] + slope(along_branch[1]) * eta
    certain = _certainly_stable(trace, det)
    if certain != stable:
        raise NotProvedError(ProofStep.NEUTRAL, refuted=certain is not None)


def _certainly_stable(trace: arb, det: arb) -> bool | None:
    """Whether both multipliers are inside the unit circle; None where it cannot be told."""
    if det < 1 and abs(trace) < 1 + det:
        return True
    if det > 1 or trace > 1 + det or trace < -(1 + det):
        return False
    return None


def prove_label(shooting: Shooting, box: Box, strobe: float, label: str) -> None:
    """Show that all orbits of a box have the label; raises NotProvedError.

    The label counts the impacts of each turn after the strobe (rad). An impact that may lie on
    either side of the strobe is counted on both. The box is taken as wide as a certificate has it.
    """
    near_strobe = arb(strobe, AT_STROBE)
    wide = replace(box, error=[WRITTEN_WIDER * error for error in box.within])
    phases = wide.hull()[: 2 * shooting.n : 2]
    sides: list[tuple[bool, ...]] = []  # of each impact: whether it lies before the strobe, or both
    for theta in phases:
        if theta < near_strobe:
            sides.append((True,))
        elif theta > near_strobe:
            sides.append((False,))
        else:
            sides.append((False, True))
    if sum(len(answers) > 1 for answers in sides) > MOST_AT_STROBE:
        raise NotProvedError(ProofStep.STROBE)
    for answers in product(*sides):
        counts = [0.0] * shooting.turns
        for place, before_strobe in zip(shooting.places, answers, strict=True):
            turn = place.turn - 1 if before_strobe else place.turn
            counts[turn % shooting.turns] += 1
        if Label(counts) != label:
            raise NotProvedError(ProofStep.STROBE)


def _machine(system: System, rpm: float, widely: bool) -> BallMachine:
    """The machine at a speed; `widely`: all machines whose speed rounds to that double."""
    if widely:
        return BallMachine.within_last_digit(system.shape, system.follower, rpm)
    return BallMachine(system.shape, system.follower, rpm)


def _free(system: System, orbit: PeriodicOrbit, widely: bool) -> Proof:
    """Prove the orbit that never meets the cam: the follower stands at the balance of its forces.

    That balance of spring and load is shown to lie above the whole cam; the multipliers are those
    of a flight of one turn. widely: for every speed that rounds to the orbit's. Raises
    NotProvedError.
    """
    machine = _machine(system, orbit.rpm, widely)
    try:
        if not _clears(machine, system.follower):
            raise NotProvedError(ProofStep.CONTACT, refuted=True)
    except UndecidedError:
        raise NotProvedError(ProofStep.GRAZES) from None
    _, b1, p = machine.flow(machine.turn)
    # (q, w) is mapped by ((1 - W^2 P, B), (-W^2 B, B'))
    trace = 1 - machine.W2 * p + b1
    det = (-2 * machine.Z * machine.turn).exp()
    if not (orbit.stable and det < 1 and abs(trace) < 1 + det):
        raise NotProvedError(ProofStep.NEUTRAL)
    return Proof(box=_texts([_balance(system.follower)]))


def _balance(follower: Follower) -> arb:
    """The lift, m, at which the force of the spring and the load are in balance."""
    weight = number(follower.mass) * number(follower.gravity)
    return -(weight + number(follower.preload)) / number(follower.stiffness)


def _clears(machine: BallMachine, follower: Follower) -> bool:
    """Whether the balance lies above the whole cam; raises UndecidedError.

    On each stretch the balance less the lift begins above zero, and has no zero.
    """
    balance = _balance(follower)
    for stretch in machine.stretches:
        lift_at_start = stretch.derivatives(stretch.start, 0)[0]
        if not below(lift_at_start, balance):
            return False

        def gap(theta: arb, lift=stretch.derivatives) -> list[arb]:
            c, c1, c2 = lift(theta, 2)
            return [balance - c, -c1, -c2]

        if first_root(gap, stretch.start.lower(), stretch.end.upper()) is not None:
            return False
    return True


def _change(system: System, event: Bifurcation, parameter: str) -> Proof:
    """Enclose the value at which an orbit that rests, or never meets the cam, appears or ends.

    A bracket, about the event as it was found, is widened until the orbit exists at one of its ends
    only, and is halved then. Raises NotProvedError.
    """

    def exists(p: arb) -> bool | None:
        """Whether the orbit exists at p, None where that cannot be decided."""
        try:
            return _keeps(system, parameter, event.orbit, p, event.kind)
        except UndecidedError:
            return None

    width = 4 * max(event.error, ulp(event.value))
    for _ in range(WIDENINGS):
        low = arb(event.value) - width
        high = arb(event.value) + width
        exists_at_low = exists(low)
        exists_at_high = exists(high)
        if None not in (exists_at_low, exists_at_high) and exists_at_low != exists_at_high:
            break
        width *= 4
    else:
        raise NotProvedError(ProofStep.CROSSING)
    for _ in range(CHANGE_HALVINGS):
        middle = ((low + high) / 2).mid()
        exists_there = exists(middle)
        if exists_there is None:
            break
        if exists_there == exists_at_low:
            low = middle
        else:
            high = middle
    _agree(low, event)
    return _enclosed(low.union(high), ())


def _agree(value: arb, event: Bifurcation) -> None:
    """Raise NotProvedError where an enclosed value is off the event's by more than its error."""
    if not abs(value - event.value) < max(event.error, LEAST_ERROR * abs(event.value)):
        raise NotProvedError(ProofStep.NUMBER)


def _keeps(system: System, parameter: str, orbit: PeriodicOrbit, p: arb, kind: Kind) -> bool:
    """Whether the machine whose parameter is p has the orbit too; raises UndecidedError.

    Its motion, followed from the orbit's first departure, must repeat with the same label and as
    many departures. At a detachment (`kind`) the question is whether a follower at rest leaves the
    cam; of a free orbit, whether the cam stays below the balance.
    """
    shape, follower, rpm = _with_parameter(system, orbit.rpm, parameter, p)
    machine = BallMachine(shape, follower, rpm)
    if orbit.free:
        return _clears(machine, follower)
    departures = orbit.theta  # of an orbit that rests, phases at which it leaves the cam, rad
    start = departures[0] if departures and kind != Kind.DETACHMENT else 0.0
    try:
        motion = BallMotion(machine, system.strobe, start)
    except EndlessError:  # it rests for good
        return not departures
    if kind == Kind.DETACHMENT:
        return bool(departures)
    while departures and len(motion.trail.states) <= orbit.turns + 1:
        before = len(motion.trail.leaves)
        motion.step()
        if len(motion.trail.leaves) == before:
            continue
        closed = cycle(motion)
        if closed:
            same_label = Label(closed.symbols) == orbit.label
            return same_label and len(closed.leaves) == len(departures)
    return False


def _with_parameter(
    system: System, rpm: float, parameter: str, p: arb
) -> tuple[Shape, Follower, Any]:
    """Cam, follower and speed (rpm) where the parameter is p; raises NotProvedError."""
    if parameter in PLACES:
        constants: dict[str, Any] = {**vars(system.follower), "rpm": rpm, parameter: p}
        rpm = constants.pop("rpm")
        return system.shape, Follower(**constants), rpm
    if not can_vary(system.shape, parameter):
        raise NotProvedError(ProofStep.CAM)
    return varied_machine(system.shape, system.follower, rpm, parameter, p)


def _resting(system: System, orbit: PeriodicOrbit, widely: bool) -> Proof:
    """Prove an orbit that rests on the cam: the motion after a rest is followed until it repeats.

    After a rest nothing is left of what came before, so that both multipliers are zero and the
    orbit is stable. widely: for every speed that rounds to the orbit's. Raises NotProvedError.
    """
    if orbit.label == CONTACT:
        try:
            BallMotion(_machine(system, orbit.rpm, widely), system.strobe, 0.0)
        except EndlessError:  # the cam presses on it all along
            return Proof()
        except UndecidedError:
            raise NotProvedError(ProofStep.GRAZES) from None
        raise NotProvedError(ProofStep.CONTACT, refuted=True)
    if not orbit.theta:
        raise NotProvedError(ProofStep.MODEL)
    # what follows the first departure: a cycle, with the symbols of its turns and its departures
    after = of_machine(system, orbit.rpm, orbit.theta[0], widely)
    if after.kind != CYCLE:
        raise NotProvedError(ProofStep.MODEL)
    if Label(after.symbols) != orbit.label:
        raise NotProvedError(ProofStep.NO_ORBIT, refuted=True)
    return Proof(box=tuple(repr(theta) for _, theta in after.leaves))


def _located(system: System, event: Bifurcation, located: Located) -> Proof:
    """Prove an event that was located on a branch of shooting, or raise NotProvedError.

    Its test function has one zero along the branch, the orbit there is a motion but for what the
    event is, and the value agrees with the one found. Where an impact fades, its rate is zero
    instead, and the parameter must change with that rate.
    """
    root = located.root
    fixed = _given(located, root)
    shooting = shooting_of(system, root)
    guess = [arb(x) for x in root.x]
    evidence = None
    if located.fading is None:
        box, _ = shooting.zero(guess, fixed, _test(shooting, located))
        hull = box.hull()
        _admit(shooting, hull, located)
        try:
            prove_label(shooting, box, system.strobe, event.orbit.label)
        except NotProvedError:  # the event is proved, but it lies where the label changes
            evidence = None
        else:
            evidence = Evidence(ctx.prec, shooting, (box,), ends=(located,))
    else:
        guess[fixed] = arb(0)
        hull = shooting.box(guess, fixed).hull()
        shooting.admissible(hull, fading=located.fading)
        by_rate = slope(shooting.along(hull, fixed)[-1])  # of the parameter
        if by_rate.contains(0):  # then it fades on neither side
            raise NotProvedError(ProofStep.CROSSING)
    value = hull[-1]
    _agree(value, event)
    signs: tuple[tuple[Rule, int], ...] = ()
    if event.kind == Kind.CORNER_IMPACT and not _at_kink(system, located):
        signs = _corner_signs(shooting, hull, located)
    if 0 in (sign for _, sign in signs):
        raise NotProvedError(ProofStep.CROSSING)
    return replace(_enclosed(value, _texts(hull[:-1])), signs=signs, evidence=evidence)


def _given(located: Located, root: Root) -> int:
    """Index in z of the unknown that is given in the boxes about an event.

    That is the parameter, but not where the branch turns round in it: at a fold it is the unknown
    that changes most along the branch, at a fading impact that impact's rate, zero there.
    """
    if located.fading is not None:
        return 2 * located.fading + 1
    if located.kind != Kind.FOLD:
        return 2 * root.count
    return max(range(2 * root.count), key=lambda k: abs(root.tangent[k]))


def _enclosed(value: arb, box: tuple[str, ...]) -> Proof:
    """A proof of an event whose parameter lies in the ball `value`; doubles round outwards.

    box: phase and rate of every impact as text.
    """
    return Proof(
        box=box,
        value=value.str(SHOWN),
        low=nextafter(float(value.lower()), -inf),
        high=nextafter(float(value.upper()), inf),
    )


def _admit(shooting: Shooting, hull: Sequence[arb], located: Located) -> None:
    """Show that the orbits at an event are motions, whatever else than the event happens there.

    hull: balls that hold the unknowns and the parameter of all of them. At a graze the gap may be
    zero at the touch, at a corner impact the phase of its impact may be the end of the stretch; all
    other conditions must hold. Raises NotProvedError where one is not shown. An impact that fades
    has no such orbits, and is refused before.
    """
    k = located.impact
    touch = None
    if located.kind == Kind.GRAZING:
        _, s = shooting.touch(hull, k, arb(located.phase - located.root.theta[k]))
        touch = Touch(flight=k, angle=s)
    at_the_corner = (k,) if located.kind == Kind.CORNER_IMPACT else ()
    shooting.admissible(hull, at_the_corner, touch)


def _test(shooting: Shooting, located: Located) -> TestFunction:
    """The function of z, the unknowns and the parameter, that is zero at an event of this kind.

    Raises NotProvedError where the event is a fading impact, which has none.
    """
    k = located.impact
    kind = located.kind
    if located.fading is not None:  # no rate is left: the linear parts have no limit
        raise NotProvedError(ProofStep.MODEL)

    def test(z: list[Number]) -> Number:
        """How far the impact is from the corner (rad), the touch from the cam (m), or a multiplier.

        The last is 1 + trace + det, zero where a multiplier is -1, or 1 - trace + det for +1.
        """
        if kind == Kind.CORNER_IMPACT:
            stretches = shooting.machine(z[-1]).stretches if shooting.in_cam else shooting.stretches
            stretch = stretches[shooting.places[k].stretch]
            return z[2 * k] - (stretch.end if located.side > 0 else stretch.start)
        if kind == Kind.GRAZING:
            s = arb(located.phase - located.root.theta[k])
            place, s = shooting.touch([x[0] for x in z], k, s)
            return shooting.gap(shooting.machine(z[-1]), z, k, place)(s)[0]
        trace, det = shooting.trace_det(z)
        return 1 + trace + det if kind == Kind.PERIOD_DOUBLING else 1 - trace + det

    return test


def _at_kink(system: System, located: Located) -> bool:
    """Whether c_theta jumps at the corner: an impact behind it has another relative rate."""
    stretches = system.at(located.root.machine).cam.stretches
    own = located.root.stretch(located.impact)
    boundary = (own + 1) % len(stretches) if located.side > 0 else own
    return stretches[boundary].slope_jump != 0.0


def _corner_signs(
    shooting: Shooting, hull: Sequence[arb], located: Located
) -> tuple[tuple[Rule, int], ...]:
    """The sign (1, -1, or 0 where undecided) of each product that a border collision's class needs.

    Each product has a factor from either side of the corner: 1 -+ tau + delta, of trace (tau) and
    determinant (delta) of the map linearised there (`camcli.analysis.border_collision`).
    """
    k = located.impact
    places = list(shooting.places)
    turns, beside = divmod(places[k].stretch + located.side, len(shooting.stretches))
    # the same impact on the stretch behind the corner:
    places[k] = Place(beside, places[k].turn + turns)
    tau, delta = shooting.trace_det(hull)
    tau_behind, delta_behind = replace(shooting, places=tuple(places)).trace_det(hull)
    products = {
        Rule.PRODUCT_AT_ONE: (1 - tau + delta) * (1 - tau_behind + delta_behind),
        Rule.PRODUCT_AT_MINUS_ONE: (1 + tau + delta) * (1 + tau_behind + delta_behind),
    }
    return tuple((rule, _sign(x)) for rule, x in products.items())


def _sign(x: arb) -> int:
    """The sign of all numbers in a ball, 0 where they have not one."""
    if x > 0:
        return 1
    return -1 if x < 0 else 0


def prove_ranges(system: System, branch: Branch, events: Sequence[Bifurcation]) -> Iterator[Range]:
    """Prove a branch from event to event, or as far as it goes: one range or more for each section.

    In a section all points have their impacts on the same stretches of the cam. What lies between
    two sections without an event is a range that is not proved.
    """
    branch = _off_the_ends(system, branch, events)
    for points in _sections(branch, events):
        middle = points[len(points) // 2]
        new_range = partial(Range, branch=branch.number, label=middle.label, stable=middle.stable)
        try:
            with precision(DIGITS[0]):
                yield from _ranges(new_range, system, points, events)
        except NotProvedError as failed:
            yield new_range(
                low=repr(points[0].value), high=repr(points[-1].value), failed_step=failed.step
            )
    for a, b in _passings(branch, events):
        yield Range(
            branch.number,
            a.label,
            a.stable,
            low=repr(min(a.value, b.value)),
            high=repr(max(a.value, b.value)),
            failed_step=ProofStep.PASSES,
        )


def _sections(branch: Branch, events: Sequence[Bifurcation]) -> Iterator[list[PeriodicOrbit]]:
    """The sections of a branch that can be proved: three points or more between two events.

    Their impacts lie on the same stretches and turns throughout, and the parameter rises from one
    point to the next; a section in which it turns round is left out.
    """
    section: list[PeriodicOrbit] = []
    for a, b in pairwise(branch.points):
        if a.root is None or b.root is None:
            continue
        section = section or [a]
        same_stretches = a.root.whole == b.root.whole
        if same_stretches:
            section.append(b)
        ends_here = not same_stretches or b is branch.points[-1]
        if ends_here or _event_at(b, events):
            rises = section[-1].value > section[0].value
            one_way = all((q.value > p.value) == rises for p, q in pairwise(section))
            if len(section) > 2 and one_way:
                yield section if rises else section[::-1]
            section = []


def _off_the_ends(system: System, branch: Branch, events: Sequence[Bifurcation]) -> Branch:
    """The branch without points at which an impact passes the end of a stretch, and no event is.

    A box about such a point would reach beyond the stretch.
    """

    def at_an_end(root: Root) -> bool:
        """Whether an impact is where its stretch begins or ends."""
        stretches = system.at(root.machine).cam.stretches
        for k, theta in enumerate(root.theta):
            stretch = stretches[root.stretch(k)]
            if min(theta - stretch.start, stretch.end - theta) < SAME_PHASE:
                return True
        return False

    passing = {id(point) for pair in _passings(branch, events) for point in pair}
    points = tuple(
        point
        for point in branch.points
        if not (id(point) in passing and point.root is not None and at_an_end(point.root))
    )
    return replace(branch, points=points)


def _passings(
    branch: Branch, events: Sequence[Bifurcation]
) -> Iterator[tuple[PeriodicOrbit, PeriodicOrbit]]:
    """Neighbours between which an impact passes the end of a stretch, as the angle zero.

    At a corner that is an event, which lies at one of the two; where it is none, the orbit goes on.
    """
    for a, b in pairwise(branch.points):
        if a.root is None or b.root is None or a.root.whole == b.root.whole:
            continue
        if _event_at(a, events) is None and _event_at(b, events) is None:
            yield a, b


def _event_at(point: PeriodicOrbit, events: Sequence[Bifurcation]) -> Bifurcation | None:
    """The located event at which a point of a branch lies, None where it is at none.

    Its orbit has the same impacts there; they may lie on the other side of a corner.
    """
    root = point.root
    near = LEAST_ERROR * abs(point.value)
    for event in events:
        if event.located is None or root is None or abs(event.value - point.value) > near:
            continue
        event_root = event.located.root
        if root.count != event_root.count:
            continue
        phases = zip(root.theta, event_root.theta, strict=True)
        if all(abs(a - b) < SAME_PHASE for a, b in phases):
            return event
    return None


class End(NamedTuple):
    """An end of a range, where the boxes about the orbits between both ends begin or stop.

    text: the parameter there; exact: the box of the orbit there; beside: the box of an orbit that
    the first box between the ends shares, the same where the end is no event. Where the end is an
    event, `around` is a box about it, in which `beside` lies.
    """

    text: str
    exact: Box
    beside: Box
    around: Box | None = None
    event: Located | None = None


def _ranges(
    new_range: Callable[..., Range],
    system: System,
    points: list[PeriodicOrbit],
    events: Sequence[Bifurcation],
) -> Iterator[Range]:
    """A section as one range: boxes about its ends, then box after box from one to the other.

    new_range: makes a `Range` of the branch from the rest of its fields. Where the box about an
    event fails, or an end lies at the strobe, the range goes to the point beside it, and what is
    left is a range that is not proved. The boxes lean along the parameter; where the branch is
    steep, along the unknown that changes most: it is continuous, so that the parameter takes all
    values between those of the ends. Raises NotProvedError.
    """
    middle = points[len(points) // 2]
    roots = [p.root for p in points if p.root is not None]
    if len(roots) < len(points):
        raise NotProvedError(ProofStep.MODEL)
    shooting = shooting_of(system, roots[len(roots) // 2])

    def prove_same_label(box: Box) -> None:
        """Show that the orbits of a box have the label of the range."""
        prove_label(shooting, box, system.strobe, middle.label)

    ends: list[End] = []
    not_proved: list[Range] = []
    for index, beside in ((0, 1), (-1, -2)):
        root = roots[index]
        event = _event_at(points[index], events)
        try:
            if event is None or event.located is None:
                end = _plain(shooting, root)
            else:
                end = _about(shooting, root, roots[beside], event.located, middle.stable)
            prove_same_label(end.around or end.exact)
            ends.append(end)
        except NotProvedError as failed:
            ends.append(_plain(shooting, roots[beside]))
            low, high = sorted((points[index].value, points[beside].value))
            not_proved.append(new_range(low=repr(low), high=repr(high), failed_step=failed.step))
    start, stop = ends
    boxes, joints = _chain(shooting, start, stop, _leaning(roots), middle.stable, prove_same_label)
    evidence = Evidence(ctx.prec, shooting, tuple(boxes), tuple(joints), (start.event, stop.event))
    yield new_range(low=start.text, high=stop.text, boxes=len(boxes), evidence=evidence)
    yield from not_proved


def _leaning(roots: Sequence[Root]) -> int:
    """Index in z of the unknown along which the boxes between the first and last root lean.

    It is the parameter, but where the branch is steep at an end: there the unknown that changes
    most changes, by the parameter, more than STEEP_SLOPE times as fast as on the mean. Then it is
    that unknown, unless it turns round on the way or does not move at all.
    """
    first, last = roots[0], roots[-1]
    parameter = 2 * first.count
    *changes, span = [abs(a - b) for a, b in zip(first.x, last.x, strict=True)]
    most = max(range(len(changes)), key=changes.__getitem__)
    steps = [b.x[most] - a.x[most] for a, b in pairwise(roots)]
    turns_round = min(steps) < 0.0 < max(steps)
    if turns_round or changes[most] <= UNMOVED * abs(first.x[most]):
        return parameter
    for root in (first, last):
        if abs(root.tangent[most]) * span > STEEP_SLOPE * changes[most] * abs(root.tangent[-1]):
            return most
    return parameter


def _plain(shooting: Shooting, root: Root) -> End:
    """An end at a root beside which there is no event."""
    box = shooting.box([arb(x) for x in root.x], 2 * root.count)
    return End(repr(root.value), box, box)


def _about(shooting: Shooting, root: Root, inner: Root, located: Located, stable: bool) -> End:
    """The end of a range at an event whose root is `root`, with a box about it.

    inner: the section's next point. Within the box the test function changes its sign at the event
    only, so that all of one side has the stability of the section. Smaller and smaller boxes are
    tried; raises NotProvedError where none holds.
    """
    fixed = _given(located, root)
    event = replace(located, root=root)
    if root.whole != located.root.whole:  # the side behind a corner
        event = replace(event, side=-located.side)
    guess = [arb(x) for x in root.x]
    to_inner = 1 if inner.x[fixed] > root.x[fixed] else -1  # direction of the range
    failure = NotProvedError(ProofStep.SINGULAR)
    for reach in REACHES:
        try:
            width = arb(reach * abs(inner.x[fixed] - root.x[fixed]))
            exact, box = shooting.zero(guess, fixed, _test(shooting, event), width)
            _admit(shooting, box.hull(), event)
            if located.kind in (Kind.PERIOD_DOUBLING, Kind.FOLD):
                _prove_other_inside(shooting, box, located.kind)
            else:
                _prove_stability(shooting, box, stable)
            beside = shooting.box(box.orbit_at((to_inner * box.half / 2).mid()), fixed)
        except NotProvedError as failed:
            failure = failed
        else:
            return End(exact.hull()[-1].str(SHOWN), exact, beside, box, event)
    raise failure


def _prove_other_inside(shooting: Shooting, box: Box, kind: Kind) -> None:
    """Show that in a box nothing but the multiplier -1, or +1 of a fold, crosses the unit circle.

    The multipliers' product is det < 1; 1 - trace + det > 0 keeps them from +1 at a doubling,
    1 + trace + det > 0 from -1 at a fold. Raises NotProvedError.
    """
    trace, det = shooting.trace_det(box.hull())
    signed_trace = -trace if kind == Kind.FOLD else trace
    if not (det < 1 and signed_trace < 1 + det):
        raise NotProvedError(ProofStep.NEUTRAL)


def _chain(
    shooting: Shooting,
    start: End,
    stop: End,
    fixed: int,
    stable: bool,
    prove_same_label: Callable[[Box], None],
    most_boxes: int = MOST_BOXES,
) -> tuple[list[Box], list[Box]]:
    """Lay boxes from the orbit at one end to that at the other: (boxes, joints).

    Each box has a joint before and one behind it, the box of an orbit that the next box has too.
    The boxes about the ends are the first and the last. fixed: the unknown along which they go;
    prove_same_label: shows that the orbits of a box have the label of the branch, or raises
    NotProvedError. Where a box fails, one of half the width is tried; the next may be wider again.
    Raises NotProvedError where `most_boxes`, over the number of impacts, are not enough.
    """
    begun = start.beside.hull()[fixed].mid()
    end = stop.beside.hull()[fixed].mid()
    at = begun  # so far the way is covered
    width = (end - at) / 16
    narrowest = abs(width) * 16 * NARROWEST_BOX
    boxes = [] if start.around is None else [start.around]
    joints = [start.exact] if start.around is None else [start.exact, start.beside]
    laid = tried = 0
    first_width = narrowest
    done = 0.0  # share of the way, in steps that grow like the distance from its beginning
    while tried < most_boxes // shooting.n * max(SLOWEST, done):
        tried += 1
        is_last = not abs(width) < abs(end - at)  # it overlaps the end
        half = ((end - at if is_last else width) / 2).mid()
        before = boxes[-1] if boxes else None
        if laid and before is not None:
            guess = before.orbit_at(at + half - before.middle[fixed])
        else:
            guess = [x.mid() for x in start.beside.hull()]
        guess[fixed] = (at + half).mid()
        _spend(shooting.n)
        try:
            box = _box_of_branch(shooting, guess, fixed, half, stable, prove_same_label)
            joint = shooting.box(box.orbit_at(at - box.middle[fixed]), fixed) if laid else None
            _prove_shared(joint or start.beside, box, before)
        except NotProvedError:
            width = width / 2
            if not abs(width) > narrowest:
                raise
            continue
        if joint is None:
            first_width = 2 * abs(half)
        else:
            joints.append(joint)
        laid += 1
        boxes.append(box)
        width = width * 1.5
        at = (at + 2 * half).mid()
        done = _share_done(abs(at - begun), abs(end - begun), first_width)
        if is_last:
            _close_chain(boxes, joints, stop)
            return boxes, joints
    raise NotProvedError(ProofStep.BOXES)


def _box_of_branch(
    shooting: Shooting,
    guess: list[arb],
    fixed: int,
    half: arb,
    stable: bool,
    prove_same_label: Callable[[Box], None],
) -> Box:
    """A box about a guess whose orbits are motions of one stability and label.

    half: of its part of the way, which it exceeds a little. Raises NotProvedError.
    """
    box = shooting.box(guess, fixed, abs(OVERLAP * half))
    shooting.admissible(box.hull())
    _prove_stability(shooting, box, stable)
    prove_same_label(box)
    return box


def _prove_shared(joint: Box, box: Box, before: Box | None) -> None:
    """Show that the orbit of a joint is one of a box, and of the one before it; NotProvedError."""
    orbit = joint.hull()
    if not (box.holds(orbit) and (before is None or before.holds(orbit))):
        raise NotProvedError(ProofStep.SINGULAR)


def _share_done(covered: arb, whole: arb, first_width: arb) -> float:
    """The share of boxes that are laid, if they grow like the distance from the beginning.

    Then their number goes with log(1 + distance/width of the first one).
    """
    return float((1 + covered / first_width).log() / (1 + whole / first_width).log())


def _close_chain(boxes: list[Box], joints: list[Box], stop: End) -> None:
    """Add the last joint of a chain, and the box about an event at its end with that one's joint.

    Raises NotProvedError where the last box does not hold the orbit beside the end.
    """
    if not boxes[-1].holds(stop.beside.hull()):
        raise NotProvedError(ProofStep.SINGULAR)
    joints.append(stop.beside)
    if stop.around is not None:
        boxes.append(stop.around)
        joints.append(stop.exact)


def _texts(values: Sequence[arb]) -> tuple[str, ...]:
    """Each ball as text "[middle +/- radius]"."""
    return tuple(x.str(SHOWN) for x in values)
