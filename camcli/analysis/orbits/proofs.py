"""Which of the orbits and events found are proved, in ball arithmetic (`camcli.exact.shooting`).

The data are those of the scene as doubles, exactly, but for the flank circle of a cam of arcs: its
radius is the exact sum that closes it (`cams.arcs`). Of the orbits found it is also asked whether
the same holds for every value of the parameter that rounds to theirs (`HoldsFor`). An orbit is
proved where a box holds exactly one orbit of its impacts, agrees with the numbers found, is a
motion, and has its multipliers inside or outside the unit circle; an event where its parameter is
enclosed and the test function crosses zero there. An orbit that rests is followed exactly until it
repeats (`camcli.analysis.after_rest`).
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from math import inf, nextafter, ulp
from typing import Any, NamedTuple

from flint import arb

from camcli.analysis.after_rest import CYCLE, HoldsFor, cycle, of_machine
from camcli.analysis.border_collision import Rule
from camcli.analysis.integrate import BudgetSpentError, spend
from camcli.analysis.labels import CONTACT, Label
from camcli.analysis.orbits.kinds import Kind
from camcli.analysis.orbits.locate import Located
from camcli.analysis.orbits.orbit import PeriodicOrbit
from camcli.analysis.orbits.shooter import PLACES, Root, with_machine
from camcli.analysis.orbits.study import Bifurcation, Branch, OrbitsResult
from camcli.cams.balls import UndecidedError, below, number, precision, slope
from camcli.exact.first_root import first_root
from camcli.exact.machine import BallMachine
from camcli.exact.motion import BallMotion, EndlessError
from camcli.exact.shooting import Box, NotProvedError, Number, ProofStep, Shooting, Test
from camcli.piece_faults import piece
from camcli.system import Follower, System

DIGITS = 60, 240  # the second ones where the first do not suffice
CHANGE_DIGITS = 150
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
LEAST_ERROR = 1e-11  # relative: an event's value is trusted to it at most
INSIDE = 1e-9  # rad within a stretch of the kernel's table, to find the exact one
WIDENINGS = 16  # by a factor of four
CHANGE_HALVINGS = 40  # of the bracket of a change: some twelve digits more
MOST_PROVED = 64  # in one period
REACHES = (0.3, 0.1, 1e-2, 1e-3, 1e-4, 1e-5)  # of the way to the next point: boxes about events
MOST_BOXES = 2400  # of one range, over the number of impacts
STEEP_SLOPE = 4.0  # times the mean slope: near a fold, or where a doubled orbit is born
SLOWEST = 0.2  # of them may be spent before the first progress
OVERLAP = 1.01  # of a box with the next one
BOXED = 20_000  # evaluations of the gap that take as long as a box, for each of its impacts
NARROWEST_BOX = 1e-12  # of a range: a box this narrow that fails ends the proof


@dataclass(frozen=True)
class Proof:
    """What was shown of an orbit or of an event.

    step: the one that failed, None where all is proved; refuted: the contrary was shown; box: phase
    (rad) and outgoing rate (m/rad) of every impact, value: the parameter, as text "[middle +/-
    radius]"; low, high: doubles about the value; signs: of the conditions of a corner impact;
    holds_for: the machines that the proof is about.
    """

    step: ProofStep | None = None
    refuted: bool = False
    box: tuple[str, ...] = ()
    value: str = ""
    low: float | None = None
    high: float | None = None
    signs: tuple[tuple[Rule, int], ...] = ()
    holds_for: HoldsFor = HoldsFor.EXACT_DATA

    @property
    def proved(self) -> bool:
        return self.step is None


@dataclass(frozen=True)
class Range:
    """A branch proved from end to end: boxes that overlap, every orbit in them a motion.

    low, high: the ends, as text; stable: of all its orbits; failed_step: None where it is proved.
    """

    branch: int
    label: str
    stable: bool
    low: str
    high: str
    boxes: int = 0
    failed_step: ProofStep | None = None


@dataclass(frozen=True)
class Proofs:
    """Proofs of orbits, points (by branch) and events in the order of the result, and ranges.

    flank_excess: m by which the flank circle that they are about is larger than the scene's.
    """

    orbits: list[Proof]
    points: list[list[Proof]]
    events: list[Proof]
    ranges: list[Range]
    flank_excess: float = 0.0


def prove(system: System, study: OrbitsResult) -> Proofs:
    """Prove what `study.orbits` found: orbits are found at a speed, whatever is varied then."""
    parameter = study.question.parameter
    failed = Proof(ProofStep.FAULT)

    def proved(what: str, proof: Callable[[], Proof]) -> Proof:
        return piece(f"the proof of {what}", proof, failed)

    def ranges(branch: Branch) -> list[Range]:
        events = [e for e in study.bifurcations if e.branch == branch.number]
        return list(prove_ranges(system, branch, events))

    return Proofs(
        [
            proved(f"{orbit.label} at {orbit.rpm!r} rpm", partial(prove_widely, system, orbit))
            for orbit in study.orbits
        ],
        [
            [
                proved(
                    f"branch {branch.number} at {orbit.value!r}",
                    partial(prove_orbit, system, orbit, parameter),
                )
                for orbit in branch.points
            ]
            for branch in study.branches
        ],
        [
            proved(
                f"the {event.kind} at {event.value!r}",
                partial(prove_event, system, event, parameter),
            )
            for event in study.bifurcations
        ],
        [
            one
            for branch in study.branches
            for one in piece(f"the proof of branch {branch.number}", partial(ranges, branch), [])
        ],
        getattr(system.shape, "flank_excess", 0.0),  # only a cam of arcs has circles to close
    )


def prove_widely(system: System, orbit: PeriodicOrbit) -> Proof:
    """Prove an orbit, if possible for every speed that rounds to its own."""
    proof = prove_orbit(system, orbit)
    if proof.proved and prove_orbit(system, orbit, half=ulp(orbit.rpm) / 2).proved:
        return replace(proof, holds_for=HoldsFor.LAST_DIGIT)
    return proof


def prove_orbit(
    system: System, orbit: PeriodicOrbit, parameter: str = "rpm", half: float = 0.0
) -> Proof:
    """Prove an orbit at its own value of the parameter, or at all values within `half` of it."""
    if orbit.root is None and parameter != "rpm":
        follower = replace(system.follower, **{parameter: orbit.value})
        system = replace(system, follower=follower)
    failure = NotProvedError(ProofStep.MODEL)
    for digits in DIGITS:
        try:
            _spend(len(orbit.theta))
            with precision(digits):
                if orbit.root is not None:
                    return _bouncing(system, orbit.root, orbit.stable, half)
                if half and parameter != "rpm":
                    raise NotProvedError(ProofStep.MODEL)
                return (_free if orbit.free else _resting)(system, orbit, bool(half))
        except NotProvedError as failed:
            failure = failed
            if failed.step not in MORE_DIGITS or failed.refuted:
                break
    return Proof(failure.step, failure.refuted)


def prove_event(system: System, event: Bifurcation, parameter: str = "rpm") -> Proof:
    """Enclose the parameter of an event and prove its crossing condition.

    Of an orbit that rests on the cam, or never meets it: a bracket with the orbit on the one side
    only.
    """
    try:
        _spend(len(event.orbit.theta))
        with precision(CHANGE_DIGITS if event.located is None else DIGITS[0]):
            if event.located is not None:
                return _located(system, event, event.located)
            return _change(system, event, parameter)
    except NotProvedError as failed:
        return Proof(failed.step, failed.refuted)


def _spend(impacts: int) -> None:
    """Count the work of a box; raises NotProvedError where there is a `Budget`, and it is spent."""
    try:
        spend(BOXED * max(1, impacts))
    except BudgetSpentError:
        raise NotProvedError(ProofStep.WORK_BUDGET) from None


def shooting_of(system: System, root: Root) -> Shooting:
    """The exact equations of a root; raises NotProvedError."""
    if root.count > MOST_PROVED:
        raise NotProvedError(ProofStep.MODEL)
    changed, rpm = with_machine(system, root.machine)
    name = next(name for name, k in PLACES.items() if k == root.parameter)
    empty = Shooting(system.shape, changed.follower, rpm, name, (), root.turns)
    places = []
    for k, theta in enumerate(root.theta):
        stretch = system.cam.stretches[root.whole[2 * k]]
        inside = min(INSIDE, 0.25 * (stretch.end - stretch.start))
        at = min(max(theta, stretch.start + inside), stretch.end - inside)
        places.append(empty.place(arb(at), root.whole[2 * k + 1]))
    return replace(empty, places=tuple(places))


def _bouncing(system: System, root: Root, stable: bool, half: float) -> Proof:
    shooting = shooting_of(system, root)
    box = shooting.box([arb(x) for x in root.x], 2 * root.count, arb(half))
    hull = box.hull()
    rate = max(abs(v) for v in root.x[1:-1:2])
    for k, claimed in enumerate(root.x[:-1]):
        size = rate if k % 2 else 1.0
        allowed = AGREES * size + PARAMETER_ROUNDING * abs(root.value) * abs(box.tangent[k])
        if not abs(hull[k] - claimed) < allowed:
            raise NotProvedError(ProofStep.NO_ORBIT)
    shooting.admissible(hull)
    _prove_stability(shooting, box, stable)
    return Proof(box=_texts(hull[:-1]))


def _prove_stability(shooting: Shooting, box: Box, stable: bool) -> None:
    """Both multipliers inside the unit circle (Jury's conditions), or one outside.

    Where the numbers of all orbits of the box are too wide, by those of its middle and their
    derivatives along the branch.
    """
    trace, det = shooting.trace_det(box.hull())
    if not _decided(trace, det):
        slopes = shooting.trace_det(shooting.along(box.hull(), box.fixed))
        about = shooting.trace_det(box.at(arb(0)))
        trace, det = (x + slope(y) * arb(0, box.half) for x, y in zip(about, slopes, strict=True))
    if _decided(trace, det) != (1 if stable else -1):
        raise NotProvedError(ProofStep.NEUTRAL, _decided(trace, det) != 0)


def _decided(trace: arb, det: arb) -> int:
    """1: both multipliers inside the unit circle, -1: one outside, 0: it cannot be told."""
    if det < 1 and abs(trace) < 1 + det:
        return 1
    return -1 if det > 1 or trace > 1 + det or trace < -(1 + det) else 0


def _machine(system: System, rpm: float, widely: bool) -> BallMachine:
    """The machine, or all whose speed rounds to this one."""
    if widely:
        return BallMachine.within_last_digit(system.shape, system.follower, rpm)
    return BallMachine(system.shape, system.follower, rpm)


def _free(system: System, orbit: PeriodicOrbit, widely: bool) -> Proof:
    """The balance of spring and load is above the whole cam; the flight has the multipliers."""
    machine = _machine(system, orbit.rpm, widely)
    try:
        if not _clears(machine, system.follower):
            raise NotProvedError(ProofStep.CONTACT, True)
    except UndecidedError:
        raise NotProvedError(ProofStep.GRAZES) from None
    _, b1, p = machine.flow(machine.turn)
    trace, det = 1 - machine.W2 * p + b1, (-2 * machine.Z * machine.turn).exp()
    if not (orbit.stable and det < 1 and abs(trace) < 1 + det):
        raise NotProvedError(ProofStep.NEUTRAL)
    return Proof(box=_texts([_balance(system.follower)]))


def _balance(f: Follower) -> arb:
    """Where spring and load balance, m."""
    return -(number(f.mass) * number(f.gravity) + number(f.preload)) / number(f.stiffness)


def _clears(machine: BallMachine, follower: Follower) -> bool:
    """Whether the balance lies above the whole cam; raises UndecidedError."""
    q = _balance(follower)
    for stretch in machine.stretches:
        if not below(stretch.derivatives(stretch.start, 0)[0], q):
            return False

        def gap(theta: arb, lift=stretch.derivatives) -> list[arb]:
            c, c1, c2 = lift(theta, 2)
            return [q - c, -c1, -c2]

        if first_root(gap, stretch.start.lower(), stretch.end.upper()) is not None:
            return False
    return True


def _change(system: System, event: Bifurcation, parameter: str) -> Proof:
    """Halve the bracket of a change: the orbit is there at one end, and not at the other."""
    orbit = event.orbit
    width = 4 * max(event.error, ulp(event.value))

    def keeps(p: arb) -> bool | None:
        try:
            return _keeps(system, parameter, orbit, p, event.kind)
        except UndecidedError:
            return None

    for _ in range(WIDENINGS):
        low, high = (arb(event.value) + side * width for side in (-1, 1))
        there = keeps(low), keeps(high)
        if None not in there and there[0] != there[1]:
            break
        width *= 4
    else:
        raise NotProvedError(ProofStep.CROSSING)
    for _ in range(CHANGE_HALVINGS):
        middle = ((low + high) / 2).mid()
        kept = keeps(middle)
        if kept is None:
            break
        low, high = (middle, high) if kept == there[0] else (low, middle)
    _agree(low, event)
    return _enclosed(low.union(high), ())


def _agree(value: arb, event: Bifurcation) -> None:
    """Refuse a value outside the error that is claimed for it."""
    if not abs(value - event.value) < max(event.error, LEAST_ERROR * abs(event.value)):
        raise NotProvedError(ProofStep.NUMBER)


def _keeps(system: System, parameter: str, orbit: PeriodicOrbit, p: arb, kind: Kind) -> bool:
    """Whether the motion at p has the orbit's turns and departures; raises UndecidedError.

    At a detachment, whether a follower at rest leaves the cam.
    """
    constants: dict[str, Any] = {**vars(system.follower), "rpm": orbit.rpm, parameter: p}
    rpm = constants.pop("rpm")
    follower = Follower(**constants)
    machine = BallMachine(system.shape, follower, rpm)
    if orbit.free:
        return _clears(machine, follower)
    start = orbit.theta[0] if orbit.theta and kind != Kind.DETACHMENT else 0.0
    try:
        motion = BallMotion(machine, system.strobe, start)
    except EndlessError:
        return not orbit.theta
    if kind == Kind.DETACHMENT:
        return bool(orbit.theta)
    while orbit.theta and len(motion.trail.states) <= orbit.turns + 1:
        before = len(motion.trail.leaves)
        motion.step()
        if len(motion.trail.leaves) > before and (found := cycle(motion)):
            return Label(found.symbols) == orbit.label and len(found.leaves) == len(orbit.theta)
    return False


def _resting(system: System, orbit: PeriodicOrbit, widely: bool) -> Proof:
    """Follow the motion after a rest until it repeats; its multipliers are zero."""
    if orbit.label == CONTACT:
        try:
            BallMotion(_machine(system, orbit.rpm, widely), system.strobe, 0.0)
        except EndlessError:  # the cam presses on it all along
            return Proof()
        except UndecidedError:
            raise NotProvedError(ProofStep.GRAZES) from None
        raise NotProvedError(ProofStep.CONTACT, True)
    after = of_machine(system, orbit.rpm, orbit.theta[0], widely) if orbit.theta else None
    if after is None or after.kind != CYCLE:
        raise NotProvedError(ProofStep.MODEL)
    if Label(after.symbols) != orbit.label:
        raise NotProvedError(ProofStep.NO_ORBIT, True)
    return Proof(box=tuple(f"{theta!r}" for _, theta in after.leaves))


def _located(system: System, event: Bifurcation, located: Located) -> Proof:
    root = located.root
    fixed = _given(located, root)
    shooting = shooting_of(system, root)
    guess = [arb(x) for x in root.x]
    if located.fading is None:
        hull = shooting.zero(guess, fixed, _test(shooting, located))[0].hull()
        _admit(shooting, hull, located)
    else:
        guess[fixed] = arb(0)
        hull = shooting.box(guess, fixed).hull()
        shooting.admissible(hull, fading=located.fading)
        if slope(shooting.along(hull, fixed)[-1]).contains(0):  # then it fades on neither side
            raise NotProvedError(ProofStep.CROSSING)
    value = hull[-1]
    _agree(value, event)
    signs = _corner_signs(shooting, hull, located) if event.kind == Kind.CORNER_IMPACT else ()
    if 0 in (sign for _, sign in signs):
        raise NotProvedError(ProofStep.CROSSING)
    return replace(_enclosed(value, _texts(hull[:-1])), signs=signs)


def _given(located: Located, root: Root) -> int:
    """The unknown that is given about an event: the parameter, but where it turns round.

    At a fold it is the one that changes most, at a fading impact its own rate, which is zero there.
    """
    if located.fading is not None:
        return 2 * located.fading + 1
    if located.kind != Kind.FOLD:
        return 2 * root.count
    return max(range(2 * root.count), key=lambda k: abs(root.tangent[k]))


def _enclosed(value: arb, box: tuple[str, ...]) -> Proof:
    low, high = (float(end) for end in (value.lower(), value.upper()))
    return Proof(
        box=box, value=value.str(SHOWN), low=nextafter(low, -inf), high=nextafter(high, inf)
    )


def _admit(shooting: Shooting, hull: Sequence[arb], located: Located) -> None:
    """Show that orbits at an event, or near it, are motions but for what happens there."""
    k = located.impact
    touch = None
    if located.kind == Kind.GRAZING:
        _, s = shooting.touch(hull, k, arb(located.phase - located.root.theta[k]))
        touch = k, s
    at_the_corner = (k,) if located.kind == Kind.CORNER_IMPACT else ()
    shooting.admissible(hull, at_the_corner, touch)


def _test(shooting: Shooting, located: Located) -> Test:
    """The function that is zero at an event, of the unknowns and the parameter."""
    k = located.impact
    kind = located.kind
    if located.fading is not None:  # no rate is left: the linear parts have no limit
        raise NotProvedError(ProofStep.MODEL)

    def test(z: list[Number]) -> Number:
        if kind == Kind.CORNER_IMPACT:
            stretch = shooting.stretches[shooting.places[k][0]]
            return z[2 * k] - (stretch.end if located.side > 0 else stretch.start)
        if kind == Kind.GRAZING:
            s = arb(located.phase - located.root.theta[k])
            place, s = shooting.touch([x[0] for x in z], k, s)
            return shooting.gap(shooting.machine(z[-1]), z, k, place)(s)[0]
        trace, det = shooting.trace_det(z)
        return 1 + trace + det if kind == Kind.PERIOD_DOUBLING else 1 - trace + det

    return test


def _corner_signs(
    shooting: Shooting, hull: Sequence[arb], located: Located
) -> tuple[tuple[Rule, int], ...]:
    """Signs of what decides between the classes, from the linear parts on both sides."""
    k = located.impact
    places = list(shooting.places)
    stretch, turn = places[k]
    turns, beside = divmod(stretch + located.side, len(shooting.stretches))
    places[k] = beside, turn + turns  # the same impact on the stretch behind the corner
    here = shooting.trace_det(hull)
    there = replace(shooting, places=tuple(places)).trace_det(hull)
    (tau_l, delta_l), (tau_r, delta_r) = (here, there) if located.side > 0 else (there, here)
    products = {
        Rule.PRODUCT_AT_ONE: (1 - tau_l + delta_l) * (1 - tau_r + delta_r),
        Rule.PRODUCT_AT_MINUS_ONE: (1 + tau_l + delta_l) * (1 + tau_r + delta_r),
    }
    return tuple((rule, 1 if x > 0 else -1 if x < 0 else 0) for rule, x in products.items())


def prove_ranges(system: System, branch: Branch, events: Sequence[Bifurcation]) -> Iterator[Range]:
    """The branch from event to event, where every point between them lies in the same regions."""
    for points in _sections(branch, events):
        middle = points[len(points) // 2]
        of = partial(Range, branch.number, middle.label, middle.stable)
        try:
            with precision(DIGITS[0]):
                yield from _ranges(of, system, points, events)
        except NotProvedError as failed:
            low, high = repr(points[0].value), repr(points[-1].value)
            yield of(low, high, failed_step=failed.step)


def _sections(branch: Branch, events: Sequence[Bifurcation]) -> Iterator[list[PeriodicOrbit]]:
    """Pieces of three points or more between events, in the order of the parameter."""
    section = list[PeriodicOrbit]()
    for a, b in pairwise(branch.points):
        if a.root is None or b.root is None:
            continue
        section = section or [a]
        if a.root.whole == b.root.whole:
            section.append(b)
        if _event_at(b, events) or a.root.whole != b.root.whole or b is branch.points[-1]:
            up = section[-1].value > section[0].value
            if len(section) > 2 and all((q.value > p.value) == up for p, q in pairwise(section)):
                yield section if up else section[::-1]
            section = []


def _event_at(point: PeriodicOrbit, events: Sequence[Bifurcation]) -> Bifurcation | None:
    """The event that a point of a branch lies on."""
    near = LEAST_ERROR * abs(point.value)
    here = (e for e in events if e.located is not None and abs(e.value - point.value) <= near)
    return next(here, None)


class End(NamedTuple):
    """An end of a piece as text, and an orbit there or beside it in the box about an event."""

    text: str
    orbit: Sequence[arb]
    box: Box | None = None


def _ranges(
    of: Callable[..., Range],
    system: System,
    points: list[PeriodicOrbit],
    events: Sequence[Bifurcation],
) -> Iterator[Range]:
    """A piece as one range: boxes about its ends, then box after box from one to the other.

    Where the box about an event fails, the range goes to the point beside it. The boxes lean along
    the parameter; where the branch is steep, along the unknown that changes most: it is continuous,
    so that the parameter takes all values between those of the ends.
    """
    middle = points[len(points) // 2]
    roots = [p.root for p in points if p.root is not None]
    if len(roots) < len(points):
        raise NotProvedError(ProofStep.MODEL)
    shooting = shooting_of(system, roots[len(roots) // 2])
    fixed = _leaning(roots[0], roots[-1])
    ends: list[End] = []
    gaps: list[Range] = []
    for at, inner in ((points[0], points[1]), (points[-1], points[-2])):
        event = _event_at(at, events)
        if at.root is None or inner.root is None:
            raise NotProvedError(ProofStep.MODEL)
        if event is None or event.located is None:
            ends.append(_plain(shooting, at.root))
            continue
        try:
            ends.append(_about(shooting, at.root, inner.root, event.located, middle.stable))
        except NotProvedError as failed:
            ends.append(_plain(shooting, inner.root))
            low, high = sorted((at.value, inner.value))
            gaps.append(of(repr(low), repr(high), failed_step=failed.step))
    start, stop = ends
    boxes = _chain(shooting, start, stop, fixed, middle.stable)
    yield of(start.text, stop.text, boxes)
    yield from gaps


def _leaning(first: Root, last: Root) -> int:
    """The unknown along which the boxes between two roots lean: the parameter's index, or another.

    Another one only where the branch is steep at an end: the unknown that changes most changes
    STEEP_SLOPE times as fast there, by the parameter, as on the mean.
    """
    *changes, span = [abs(a - b) for a, b in zip(first.x, last.x, strict=True)]
    most = max(range(len(changes)), key=changes.__getitem__)
    for root in (first, last):
        if abs(root.tangent[most]) * span > STEEP_SLOPE * changes[most] * abs(root.tangent[-1]):
            return most
    return 2 * first.count


def _plain(shooting: Shooting, root: Root) -> End:
    """An end at a root beside which there is no event."""
    box = shooting.box([arb(x) for x in root.x], 2 * root.count)
    return End(repr(root.value), box.hull())


def _about(shooting: Shooting, root: Root, inner: Root, located: Located, stable: bool) -> End:
    """An event at one end of a piece, whose next point is `inner`, with a box around it.

    Within the box the test function changes its sign at the event only, so that all of one side has
    the stability of the piece.
    """
    fixed = _given(located, root)
    moved = replace(located, root=root)
    if root.whole != located.root.whole:  # the side behind a corner
        moved = replace(moved, side=-located.side)
    guess = [arb(x) for x in root.x]
    failure = NotProvedError(ProofStep.SINGULAR)
    for reach in REACHES:
        try:
            width = arb(reach * abs(inner.x[fixed] - root.x[fixed]))
            exact, box = shooting.zero(guess, fixed, _test(shooting, moved), width)
            _admit(shooting, box.hull(), moved)
            trace, det = shooting.trace_det(box.hull())
            if located.kind not in (Kind.PERIOD_DOUBLING, Kind.FOLD):
                _prove_stability(shooting, box, stable)
            elif not (det < 1 and (-trace if located.kind == Kind.FOLD else trace) < 1 + det):
                raise NotProvedError(
                    ProofStep.NEUTRAL
                )  # nothing but the multiplier -1, or 1, may cross
            side = 1 if inner.x[fixed] > root.x[fixed] else -1
            orbit = shooting.box(box.at((side * box.half / 2).mid()), fixed).hull()
        except NotProvedError as failed:
            failure = failed
        else:
            return End(exact.hull()[-1].str(SHOWN), orbit, box)
    raise failure


def _chain(shooting: Shooting, start: End, stop: End, fixed: int, stable: bool) -> int:
    """The number of boxes from one orbit to another, those about the ends included.

    Each box holds the same orbit as the next one where the two meet. Where a box fails, one of half
    the width is tried; a next one may be wider again.
    """
    begun = start.orbit[fixed].mid()
    end = stop.orbit[fixed].mid()
    at = begun  # so far the way is covered
    width = (end - at) / 16
    least = abs(width) * 16 * NARROWEST_BOX
    guess = [x.mid() for x in start.orbit]
    orbit = start.orbit  # the one that the last box and the next one share
    before = start.box
    tried = boxes = 0
    first = least  # width of the first box
    done = 0.0  # share of the way, in steps that grow like the distance from its beginning
    while tried < MOST_BOXES // shooting.n * max(SLOWEST, done):
        tried += 1
        whole = not abs(width) < abs(end - at)  # the last box, which overlaps the end
        half = ((end - at if whole else width) / 2).mid()
        if boxes and before is not None:
            guess = before.at(at + half - before.middle[fixed])
        guess[fixed] = (at + half).mid()
        _spend(shooting.n)
        try:
            box = shooting.box(guess, fixed, abs(OVERLAP * half))
            shooting.admissible(box.hull())
            _prove_stability(shooting, box, stable)
            if boxes and before is not None:
                orbit = shooting.box([*box.at(at - box.middle[fixed])], fixed).hull()
            if not (box.holds(orbit) and (before is None or before.holds(orbit))):
                raise NotProvedError(ProofStep.SINGULAR)
        except NotProvedError:
            width = width / 2
            if not abs(width) > least:
                raise
            continue
        if boxes == 0:
            first = 2 * abs(half)
        boxes += 1
        before = box
        width = width * 1.5
        at = (at + 2 * half).mid()
        done = float((1 + abs(at - begun) / first).log() / (1 + abs(end - begun) / first).log())
        if whole:
            if not box.holds(stop.orbit):
                raise NotProvedError(ProofStep.SINGULAR)
            return boxes + sum(1 for one in (start, stop) if one.box is not None)
    raise NotProvedError(ProofStep.BOXES)


def _texts(values: Sequence[arb]) -> tuple[str, ...]:
    return tuple(x.str(SHOWN) for x in values)
