"""Which of the orbits and events found are proved, in ball arithmetic (`camcli.exact.shooting`).

The data are those of the scene as doubles, exactly. An orbit is proved where a box holds exactly
one orbit of its impacts, agrees with the numbers found, is a motion, and has its multipliers inside
or outside the unit circle; an event where its parameter is enclosed and the test function crosses
zero there. An orbit that rests is followed exactly until it repeats (`camcli.analysis.after_rest`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import inf, nextafter, ulp
from typing import Any

from flint import arb

from camcli.analysis.after_rest import CYCLE, cycle, of_machine
from camcli.analysis.labels import CONTACT, Label
from camcli.analysis.orbits.kinds import Kind
from camcli.analysis.orbits.locate import Located
from camcli.analysis.orbits.orbit import PeriodicOrbit
from camcli.analysis.orbits.shooter import PARAMETERS, Root, with_machine
from camcli.analysis.orbits.study import Bifurcation, Branch, OrbitsResult
from camcli.exact.balls import UndecidedError, below, number, precision
from camcli.exact.first_root import first_root
from camcli.exact.machine import Machine
from camcli.exact.motion import EndlessError, Motion
from camcli.exact.shooting import Box, NotProvedError, Number, Shooting, Step, Test
from camcli.system import Follower, System

DIGITS = 60, 240  # the second ones where the first do not suffice
CHANGE_DIGITS = 150
MORE_DIGITS = {Step.SINGULAR, Step.GRAZES, Step.NEUTRAL}  # steps that more digits may decide
SHOWN = 30  # digits of an enclosure as text
AGREES = 1e-10  # of 1 rad and the largest rate: numbers so near to the orbit are its own
ROUNDING = 1e-13  # relative error of the parameter that the numbers of an orbit may stand for
LEAST_ERROR = 1e-11  # relative: an event's value is trusted to it at most
INSIDE = 1e-9  # rad within a stretch of the kernel's table, to find the exact one
WIDENINGS = 16  # by a factor of four
HALVINGS = 40  # of the bracket of a change: some twelve digits more
MOST_IMPACTS = 64  # in one period
REACHES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7)  # of a range: how far an event's own box is tried to reach
MOST_BOXES = 2400  # of one range, over the number of impacts
SLOWEST = 0.2  # of them may be spent before the first progress
OVERLAP = 1.01  # of a box with the next one
NARROWEST = 1e-8  # of a range: a box this narrow that fails ends the proof


@dataclass(frozen=True)
class Proof:
    """What was shown of an orbit or of an event.

    step: the one that failed, None where all is proved; refuted: the contrary was shown; box: phase
    (rad) and outgoing rate (m/rad) of every impact, value: the parameter, as text "[middle +/-
    radius]"; low, high: doubles about the value; signs: of the conditions of a corner impact.
    """

    step: Step | None = None
    refuted: bool = False
    box: tuple[str, ...] = ()
    value: str = ""
    low: float | None = None
    high: float | None = None
    signs: tuple[tuple[str, int], ...] = ()

    @property
    def proved(self) -> bool:
        return self.step is None


@dataclass(frozen=True)
class Range:
    """A branch proved from end to end: boxes that overlap, every orbit in them a motion.

    low, high: the ends, as text; stable: of all its orbits.
    """

    branch: int
    label: str
    stable: bool
    low: str
    high: str
    boxes: int


@dataclass(frozen=True)
class Proofs:
    """Proofs of orbits, points (by branch) and events in the order of the result, and ranges."""

    orbits: list[Proof]
    points: list[list[Proof]]
    events: list[Proof]
    ranges: list[Range]


def prove(system: System, found: OrbitsResult) -> Proofs:
    """Prove what `study.orbits` found."""
    parameter = found.question.parameter
    return Proofs(
        [prove_orbit(system, orbit, parameter) for orbit in found.orbits],
        [[prove_orbit(system, o, parameter) for o in branch.points] for branch in found.branches],
        [prove_event(system, event, parameter) for event in found.bifurcations],
        [
            proved
            for branch in found.branches
            for proved in prove_ranges(
                system, branch, [e for e in found.bifurcations if e.branch == branch.number]
            )
        ],
    )


def prove_orbit(system: System, orbit: PeriodicOrbit, parameter: str = "rpm") -> Proof:
    """Prove an orbit at its own value of the parameter."""
    if orbit.root is None and parameter != "rpm":
        follower = replace(system.follower, **{parameter: orbit.value})
        system = replace(system, follower=follower)
    failure = NotProvedError(Step.MODEL)
    for digits in DIGITS:
        try:
            with precision(digits):
                if orbit.root is not None:
                    return _bouncing(system, orbit.root, orbit.stable)
                return _free(system, orbit) if orbit.free else _resting(system, orbit)
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
        with precision(CHANGE_DIGITS if event.located is None else DIGITS[0]):
            if event.located is not None:
                return _located(system, event, event.located)
            return _change(system, event, parameter)
    except NotProvedError as failed:
        return Proof(failed.step, failed.refuted)


def shooting_of(system: System, root: Root) -> Shooting:
    """The exact equations of a root; raises NotProvedError."""
    if system.shape is None or root.count > MOST_IMPACTS:
        raise NotProvedError(Step.MODEL)
    own, rpm = with_machine(system, root.machine)
    name = next(name for name, k in PARAMETERS.items() if k == root.parameter)
    empty = Shooting(system.shape, own.follower, rpm, name, (), root.turns)
    places = []
    for k, theta in enumerate(root.theta):
        stretch = system.cam.stretches[root.whole[2 * k]]
        inside = min(INSIDE, 0.25 * (stretch.end - stretch.start))
        at = min(max(theta, stretch.start + inside), stretch.end - inside)
        places.append(empty.place(arb(at), root.whole[2 * k + 1]))
    return replace(empty, places=tuple(places))


def _bouncing(system: System, root: Root, stable: bool) -> Proof:
    shooting = shooting_of(system, root)
    box = shooting.box([arb(x) for x in root.x], 2 * root.count)
    hull = box.hull()
    rate = max(abs(v) for v in root.x[1:-1:2])
    for k, claimed in enumerate(root.x[:-1]):
        size = rate if k % 2 else 1.0
        allowed = AGREES * size + ROUNDING * abs(root.value) * abs(box.tangent[k])
        if not abs(hull[k] - claimed) < allowed:
            raise NotProvedError(Step.NO_ORBIT)
    shooting.admissible(hull)
    _prove_stability(shooting, hull, stable)
    return Proof(box=_texts(hull[:-1]))


def _prove_stability(shooting: Shooting, hull: Sequence[arb], stable: bool) -> None:
    """Both multipliers inside the unit circle (Jury's conditions), or one outside."""
    trace, det = shooting.trace_det(hull)
    inside = det < 1 and abs(trace) < 1 + det
    outside = det > 1 or trace > 1 + det or trace < -(1 + det)
    if not (inside if stable else outside):
        raise NotProvedError(Step.NEUTRAL, bool(outside if stable else inside))


def _free(system: System, orbit: PeriodicOrbit) -> Proof:
    """The balance of spring and load is above the whole cam; the flight has the multipliers."""
    if system.shape is None:
        raise NotProvedError(Step.MODEL)
    machine = Machine(system.shape, system.follower, orbit.rpm)
    try:
        if not _clears(machine, system.follower):
            raise NotProvedError(Step.CONTACT, True)
    except UndecidedError:
        raise NotProvedError(Step.GRAZES) from None
    _, b1, p = machine.flow(machine.turn)
    trace, det = 1 - machine.W2 * p + b1, (-2 * machine.Z * machine.turn).exp()
    if not (orbit.stable and det < 1 and abs(trace) < 1 + det):
        raise NotProvedError(Step.NEUTRAL)
    return Proof(box=_texts([_balance(system.follower)]))


def _balance(f: Follower) -> arb:
    """Where spring and load balance, m."""
    return -(number(f.mass) * number(f.gravity) + number(f.preload)) / number(f.stiffness)


def _clears(machine: Machine, follower: Follower) -> bool:
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
    orbit, width = event.orbit, 4 * max(event.error, ulp(event.value))

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
        raise NotProvedError(Step.CROSSING)
    for _ in range(HALVINGS):
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
        raise NotProvedError(Step.NUMBER)


def _keeps(system: System, parameter: str, orbit: PeriodicOrbit, p: arb, kind: Kind) -> bool:
    """Whether the motion at p has the orbit's turns and departures; raises UndecidedError.

    At a detachment, whether a follower at rest leaves the cam.
    """
    constants: dict[str, Any] = {**vars(system.follower), "rpm": orbit.rpm, parameter: p}
    rpm = constants.pop("rpm")
    follower = Follower(**constants)
    if system.shape is None:
        raise NotProvedError(Step.MODEL)
    machine = Machine(system.shape, follower, rpm)
    if orbit.free:
        return _clears(machine, follower)
    start = orbit.theta[0] if orbit.theta and kind != Kind.DETACHMENT else 0.0
    try:
        motion = Motion(machine, system.strobe, start)
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


def _resting(system: System, orbit: PeriodicOrbit) -> Proof:
    """Follow the motion after a rest until it repeats; its multipliers are zero."""
    if system.shape is None:
        raise NotProvedError(Step.MODEL)
    if orbit.label == CONTACT:
        try:
            Motion(Machine(system.shape, system.follower, orbit.rpm), system.strobe, 0.0)
        except EndlessError:  # the cam presses on it all along
            return Proof()
        except UndecidedError:
            raise NotProvedError(Step.GRAZES) from None
        raise NotProvedError(Step.CONTACT, True)
    found = of_machine(system, orbit.rpm, orbit.theta[0]) if orbit.theta else None
    if found is None or found.kind != CYCLE:
        raise NotProvedError(Step.MODEL)
    if Label(found.symbols) != orbit.label:
        raise NotProvedError(Step.NO_ORBIT, True)
    return Proof(box=tuple(f"{theta!r}" for _, theta in found.leaves))


def _located(system: System, event: Bifurcation, located: Located) -> Proof:
    root, fixed = located.root, 2 * located.root.count
    if event.kind == Kind.FOLD:
        fixed = max(range(fixed), key=lambda k: abs(root.tangent[k]))
    shooting = shooting_of(system, root)
    box, _ = shooting.zero([arb(x) for x in root.x], fixed, _test(shooting, located))
    hull = box.hull()
    _admit(shooting, hull, located)
    value = hull[-1]
    _agree(value, event)
    signs = _corner_signs(shooting, hull, located) if event.kind == Kind.CORNER_IMPACT else ()
    if 0 in (sign for _, sign in signs):
        raise NotProvedError(Step.CROSSING)
    return replace(_enclosed(value, _texts(hull[:-1])), signs=signs)


def _enclosed(value: arb, box: tuple[str, ...]) -> Proof:
    low, high = (float(end) for end in (value.lower(), value.upper()))
    return Proof(
        box=box, value=value.str(SHOWN), low=nextafter(low, -inf), high=nextafter(high, inf)
    )


def _admit(shooting: Shooting, hull: Sequence[arb], located: Located) -> None:
    """Show that orbits at an event, or near it, are motions but for what happens there."""
    k, touch = located.impact, None
    if located.kind == Kind.GRAZING:
        touch = k, shooting.touch(hull, k, arb(located.phase - located.root.theta[k]))[1]
    shooting.admissible(hull, (k,) if located.kind == Kind.CORNER_IMPACT else (), touch)


def _test(shooting: Shooting, located: Located) -> Test:
    """The function that is zero at an event, of the unknowns and the parameter."""
    k, kind = located.impact, located.kind
    if located.fading is not None:  # no velocity is left: the linear parts have no limit
        raise NotProvedError(Step.MODEL)

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
) -> tuple[tuple[str, int], ...]:
    """Signs of what decides between the classes, from the linear parts on both sides."""
    k, places = located.impact, list(shooting.places)
    i, turn = places[k]
    turns, places_i = divmod(i + located.side, len(shooting.stretches))
    places[k] = places_i, turn + turns
    here = shooting.trace_det(hull)
    there = replace(shooting, places=tuple(places)).trace_det(hull)
    (tau_l, delta_l), (tau_r, delta_r) = (here, there) if located.side > 0 else (there, here)
    products = {
        "(1 - tau_L + delta_L)(1 - tau_R + delta_R)": (1 - tau_l + delta_l) * (1 - tau_r + delta_r),
        "(1 + tau_L + delta_L)(1 + tau_R + delta_R)": (1 + tau_l + delta_l) * (1 + tau_r + delta_r),
    }
    return tuple((text, 1 if x > 0 else -1 if x < 0 else 0) for text, x in products.items())


def prove_ranges(system: System, branch: Branch, events: Sequence[Bifurcation]) -> Iterator[Range]:
    """The branch from event to event, where every point between them lies in the same regions."""
    for first, *inner, last in _sections(branch, events):
        try:
            with precision(DIGITS[0]):
                yield _range(system, branch.number, [first, *inner, last], events)
        except NotProvedError:
            continue


def _sections(branch: Branch, events: Sequence[Bifurcation]) -> Iterator[list[PeriodicOrbit]]:
    """Pieces of three points or more between events, in the order of the parameter."""
    piece = list[PeriodicOrbit]()
    for a, b in pairwise(branch.points):
        if a.root is None or b.root is None:
            continue
        piece = piece or [a]
        if a.root.whole == b.root.whole:
            piece.append(b)
        if _event_at(b, events) or a.root.whole != b.root.whole or b is branch.points[-1]:
            up = piece[-1].value > piece[0].value
            if len(piece) > 2 and all((q.value > p.value) == up for p, q in pairwise(piece)):
                yield piece if up else piece[::-1]
            piece = []


def _event_at(point: PeriodicOrbit, events: Sequence[Bifurcation]) -> Bifurcation | None:
    """The event that a point of a branch lies on."""
    near = LEAST_ERROR * abs(point.value)
    here = (e for e in events if e.located is not None and abs(e.value - point.value) <= near)
    return next(here, None)


def _range(
    system: System, number: int, points: list[PeriodicOrbit], events: Sequence[Bifurcation]
) -> Range:
    """Prove a piece: the boxes about its ends, then box after box from one to the other."""
    middle, span = points[len(points) // 2], points[-1].value - points[0].value
    if middle.root is None or points[1].root is None:
        raise NotProvedError(Step.MODEL)
    shooting, stable = shooting_of(system, middle.root), middle.stable
    ends: list[tuple[str, Box | None]] = []
    for at, inner in ((points[0], points[1]), (points[-1], points[-2])):
        event = _event_at(at, events)
        if event is None or event.located is None or at.root is None:
            ends.append((repr(at.value), None))
        elif event.kind == Kind.FOLD:  # the branch has no slope there
            ends.append((repr(inner.value), None))
        else:
            ends.append(_about(shooting, at.root, event.located, span, stable))
    (low, first), (high, last) = ends
    boxes = _chain(
        shooting, points[1].root, (arb(low).mid(), first), (arb(high).mid(), last), stable
    )
    return Range(number, middle.label, stable, low, high, boxes)


def _about(
    shooting: Shooting, root: Root, located: Located, span: float, stable: bool
) -> tuple[str, Box]:
    """An event at one end of a piece as text, and a box around it.

    Within the box the test function changes its sign at the event only, so that all of one side has
    the stability of the piece.
    """
    fixed, own = 2 * root.count, replace(located, root=root)
    if root.whole != located.root.whole:  # the side behind a corner
        own = replace(own, side=-located.side)
    guess, failure = [arb(x) for x in root.x], NotProvedError(Step.SINGULAR)
    for reach in REACHES:
        try:
            exact, box = shooting.zero(guess, fixed, _test(shooting, own), arb(reach * span))
            _admit(shooting, box.hull(), own)
            trace, det = shooting.trace_det(box.hull())
            if located.kind != Kind.PERIOD_DOUBLING:
                _prove_stability(shooting, box.hull(), stable)
            elif not (det < 1 and trace < 1 + det):  # nothing but the multiplier -1 may cross
                raise NotProvedError(Step.NEUTRAL)
        except NotProvedError as failed:
            failure = failed
        else:
            return exact.hull()[-1].str(SHOWN), box
    raise failure


def _chain(
    shooting: Shooting,
    root: Root,
    start: tuple[arb, Box | None],
    stop: tuple[arb, Box | None],
    stable: bool,
) -> int:
    """Boxes from one value to another, each with the same orbit as the next where they meet.

    A box about either end goes before or behind; the number of all is returned.
    """
    fixed, (at, before), (end, last) = 2 * root.count, start, stop
    at = at if before is None else (before.middle[fixed] + before.half).mid()
    end = end if last is None else (last.middle[fixed] - last.half / 2).mid()
    width, guess = (end - at) / 16, [arb(x) for x in root.x]
    least = width * 16 * NARROWEST
    begun, count, boxes = at, 0, 0
    while count < MOST_BOXES // root.count * max(SLOWEST, float((at - begun) / (end - begun))):
        count += 1
        whole = not width < end - at  # the last box, which overlaps the end
        half = ((end - at if whole else width) / 2).mid()
        if before is not None:
            guess = before.at(at + half - before.middle[fixed])
        guess[fixed] = (at + half).mid()
        try:
            box = shooting.box(guess, fixed, OVERLAP * half)
            shooting.admissible(box.hull())
            _prove_stability(shooting, box.hull(), stable)
            if before is not None and not _meet(shooting, before, box):
                raise NotProvedError(Step.SINGULAR)
        except NotProvedError:
            width = width / 2
            if not width > least:
                raise
            continue
        before, width, at = box, width * 1.5, (at + 2 * half).mid()
        boxes += 1
        if whole:
            if last is not None and not _meet(shooting, box, last):
                raise NotProvedError(Step.SINGULAR)
            return boxes + (start[1] is not None) + (last is not None)
    raise NotProvedError(Step.SINGULAR)


def _meet(shooting: Shooting, before: Box, after: Box) -> bool:
    """True where both boxes hold the orbit at a value of the parameter that both have."""
    fixed = before.fixed
    low, high = after.middle[fixed] - after.half, before.middle[fixed] + before.half
    at = ((low + high) / 2).mid()
    point = shooting.box([*before.at(at - before.middle[fixed])[:-1], at], fixed).hull()
    return all(
        x.contains(y)
        for box in (before, after)
        for x, y in zip(box.at(at - box.middle[fixed]), point, strict=True)
    )


def _texts(values: Sequence[arb]) -> tuple[str, ...]:
    return tuple(x.str(SHOWN) for x in values)
