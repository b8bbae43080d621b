"""Certificates: what was proved, in numbers as text, so that `camcli.check` can check it by itself.

What the entries mean, and the theorems that they certify, stand in the guide (`proofs`). Numbers of
the scene are written as the decimal numbers that their doubles are, angles of a law as they were
written; boxes are rounded to DIGITS_OF_BITS of their digits and widened by what that may move them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from fractions import Fraction
from functools import partial
from itertools import pairwise
from math import ceil, hypot, log10, radians
from typing import Any, NamedTuple, Protocol

from flint import arb, arb_mat, ctx

from camcli.analysis.orbits.attraction import Axes
from camcli.analysis.orbits.codim2 import Test
from camcli.analysis.orbits.curve_proofs import CurveEvidence, CurveRange, OnCurve
from camcli.analysis.orbits.curves import Curve
from camcli.analysis.orbits.evidence import Evidence
from camcli.analysis.orbits.kinds import Kind
from camcli.analysis.orbits.locate import Located
from camcli.analysis.orbits.orbit import PeriodicOrbit
from camcli.analysis.orbits.proofs import Proof, Proofs, Range, prove_label
from camcli.analysis.orbits.study import Bifurcation, OrbitsResult
from camcli.cams.balls import UndecidedError, coarsely, derivatives, precision
from camcli.cams.decimals import decimal, exact, exactly
from camcli.cams.varied import name_in_formula
from camcli.exact.machine import BallMachine, BallStretch
from camcli.exact.shooting import Box, NotProvedError, Place, Shooting, Touch
from camcli.quantities import PARAMETERS

FORMAT = "camcli-proof-1"
CONSTANTS = "rpm", "mass", "stiffness", "damping", "gravity", "preload", "restitution"
KINDS = {Kind.PERIOD_DOUBLING, Kind.FOLD, Kind.CORNER_IMPACT}  # events that a certificate may have
TESTS = {Test.FLIP, Test.FOLD, Test.CORNER, Test.GRAZE}  # conditions of curves that it may have
DIGITS_OF_BITS = 0.25  # digits of a box per bit of the proof: five sixths of what it has
SPARE, SPARE_OF_EVENT = 10**8, 10**18  # times the last of them: errors, and half an event's box
OF_TANGENT, OF_INVERSE = 25, 16  # digits
MOST_CUTS = 4  # in half, of a box whose flights are too wide to be divided
DIGITS_OF_MEETING = 30  # of the parameter where multipliers meet
SLACK = 1.01  # factor by which an error is written larger than where it was shown
NARROW, SLACK_OF_NARROW = 1e-9, 100.0  # half of a box in which all is all but linear, and its slack
ROUNDED_UP = 1.0001  # factor that keeps the five digits of a radius from being too small
WIDER = 1.25  # times its half width: a part of a flight on which the gap is shown to be positive
DEEPEST = 40  # times that a part of a flight is halved
SHORTEST_RUN = 1 / 64  # of a passage: parts on which the gap is shown to rise, or to fall
FIRST_RUN = 2.0**-50  # of these: the first one
SHRUNK = 0.75  # factor from one try to the next of the part about a touch


def certificate(
    study: OrbitsResult,
    cam: dict[str, Any] | None,
    strobe: float,
    name_of: Callable[[PeriodicOrbit | Bifurcation | Range | CurveRange], str],
) -> dict[str, Any]:
    """The content of proof.json: the cam, and one statement for each proof that has evidence.

    cam: the numbers of its closed formula (`camcli.cams.formula`), None for a cam that no
    certificate can have. uncovered: what was proved in
    a way that a certificate has no statement for, by its name.
    """
    statements = []
    uncovered = []
    proofs = study.proofs
    assert proofs is not None
    for one in _proved(study, proofs):
        statement = None
        if one.evidence is not None and cam is not None:
            with precision(int(one.evidence.bits * log10(2))):
                ctx.prec = one.evidence.bits
                statement = _statement(one.evidence, one.said, strobe)
        if statement is None:
            uncovered.append(name_of(one.of))
        else:
            statements.append(statement)
    of_curves = certificate_of_curves(proofs.curve_ranges, study.curves, cam, strobe, name_of)
    statements += of_curves["statements"]
    uncovered += of_curves["uncovered"]
    if cam is not None:
        for branch in proofs.ranges:
            statements += _meetings(branch, strobe)
    everything = None if cam is None else _all(study, statements, strobe)
    if everything is not None:
        statements.append(everything)
    return {
        "format": FORMAT,
        "cam": cam,
        "statements": statements,
        "uncovered": uncovered,
    }


def certificate_of_curves(
    ranges: Sequence[CurveRange],
    curves: Sequence[Curve],
    cam: dict[str, Any] | None,
    strobe: float,
    name_of: Callable[[CurveRange], str],
) -> dict[str, Any]:
    """The content of proof.json on curves in two numbers, a statement for each part proved."""
    statements = []
    uncovered = []
    for part in ranges:
        if part.failed_step is not None:
            continue
        label = curves[part.curve - 1].label
        statement = None if cam is None else _curve_statement(part, label, strobe)
        if statement is None:
            uncovered.append(name_of(part))
        else:
            statements.append(statement)
    return {"format": FORMAT, "cam": cam, "statements": statements, "uncovered": uncovered}


def _all(
    study: OrbitsResult, statements: list[dict[str, Any]], strobe: float
) -> dict[str, Any] | None:
    """The statement that the orbits are all; None where one of them has no statement."""
    found, own = study.every, [one for one in statements if one["kind"] == "orbit"]
    if found is None or found.failure is not None or len(own) < len(found.orbits):
        return None
    known = {**vars(found.follower), "rpm": study.question.rpm}
    return {
        "kind": "all-orbits",
        "constants": {key: exact(known[key]) for key in CONSTANTS},
        "strobe": exact(strobe),
        "impacts": found.impacts,
        "turns": found.turns,
        "orbits": own,
        "covers": [
            {"impacts": one.impacts, "turns": one.turns, "boxes": one.letters,
             "orbits": list(one.known)}
            for one in found.covers
        ],
    }  # fmt: skip


class Proved(NamedTuple):
    """What was proved, of which orbit, event or range, and what its statement says beside boxes.

    evidence: None where a certificate has no statement of this kind, as of a graze or of an orbit
    that rests; it is then named among those that are not covered.
    """

    of: PeriodicOrbit | Bifurcation | Range
    evidence: Evidence | None
    said: dict[str, Any]


def _proved(study: OrbitsResult, proofs: Proofs) -> Iterator[Proved]:
    """All that was proved of a study, but for the single points of its branches."""
    for orbit, proof in zip(study.orbits, proofs.orbits, strict=True):
        label = {"label": str(orbit.label)}
        if proof.proved:
            said = {"kind": "orbit", **label, "stable": orbit.stable}
            yield Proved(orbit, proof.evidence, said)
        if proof.axes and proof.evidence is not None:
            said = {"kind": "attractor", **label, "axes": _texts(proof.axes)}
            yield Proved(orbit, replace(proof.evidence, axes=proof.axes), said)
    for event, proof in zip(study.bifurcations, proofs.events, strict=True):
        if proof.proved:
            kept = proof.evidence if event.kind in KINDS else None
            said = {"kind": "event", "label": str(event.orbit.label), **_claims(proof)}
            yield Proved(event, kept, said)
    for part in proofs.ranges:
        if part.failed_step is None:
            ends = part.evidence.ends if part.evidence is not None else ()
            known_ends = all(end is None or end.kind in KINDS for end in ends)
            kept = part.evidence if known_ends else None
            said = {"kind": "branch", "label": part.label, "stable": part.stable, **_range(part)}
            yield Proved(part, kept, said)


class BoxAt(Protocol):
    """What finds the box near a guess, as `Shooting.box` does."""

    def __call__(self, guess: Sequence[arb], fixed: int, half: arb | int = 0, /) -> Box: ...


def _with_flights(
    evidence: Evidence | CurveEvidence,
    box_at: BoxAt,
    flights: Callable[[list[arb]], list[dict[str, Any]]],
) -> tuple[list[dict[str, Any]], list[Box]]:
    """(the boxes of a branch or a curve as text with their flights, the joints between them).

    box_at: finds another box; flights: those of the orbits in a hull. A box whose flights cannot be
    divided is cut in two, which share a joint. Raises NotProvedError or UndecidedError where that
    does not help.
    """
    joints = [evidence.joints[0]]
    texts: list[dict[str, Any]] = []
    todo = [(box, after, 0) for box, after in zip(evidence.boxes, evidence.joints[1:], strict=True)]
    while todo:
        box, after, depth = todo.pop(0)
        roomy = _roomy(box)
        try:
            text = {**_box(roomy), "flights": flights(roomy.hull())}
        except UndecidedError:
            if depth == MOST_CUTS:
                raise
            todo[:0] = [(*half, depth + 1) for half in _halves(box_at, box, joints[-1], after)]
            continue
        joints.append(after)
        texts.append(text)
    return texts, joints


def _halves(box_at: BoxAt, box: Box, before: Box, after: Box) -> list[tuple[Box, Box]]:
    """The two halves of a box between two joints, each with the joint behind it."""
    places = [joint.hull()[box.fixed] for joint in (before, after)]
    middle = ((places[0] + places[1]) / 2).mid()
    between = box_at(box.orbit_at(middle - box.middle[box.fixed]), box.fixed)
    halves = []
    for a, b, joint in ((places[0], middle, between), (middle, places[1], after)):
        center = ((a + b) / 2).mid()
        half = (abs(b - a) / 2 * SLACK).upper()
        guess = box.orbit_at(center - box.middle[box.fixed])
        guess[box.fixed] = center
        halves.append((box_at(guess, box.fixed, half), joint))
    return halves


def _meetings(one: Range, strobe: float) -> list[dict[str, Any]]:
    """Statements of where on a proved branch both multipliers meet: there they turn complex.

    That is a zero of trace^2 - 4 det, looked for where its sign changes from joint to joint.
    """
    evidence = one.evidence
    if one.failed_step is not None or evidence is None:
        return []
    shooting = evidence.shooting

    def apart(z: Sequence[Any]) -> Any:
        """The square of the distance between the multipliers."""
        trace, det = shooting.trace_det(z)
        return trace * trace - 4 * det

    found = []
    with precision(int(evidence.bits * log10(2))):
        ctx.prec = evidence.bits
        values = [float(apart(joint.middle)) for joint in evidence.joints]
        for box, joints, ends in zip(
            evidence.boxes, pairwise(evidence.joints), pairwise(values), strict=True
        ):
            if not ends[0] * ends[1] < 0:
                continue
            first, second = (joint.middle[box.fixed] for joint in joints)
            near = first + (second - first) * (ends[0] / (ends[0] - ends[1]))
            guess = [x.mid() for x in box.orbit_at(near - box.middle[box.fixed])]
            try:
                zero, _ = shooting.zero(guess, box.fixed, apart)
            except (NotProvedError, UndecidedError):
                continue
            low, high = _range_of(zero.hull()[-1].str(DIGITS_OF_MEETING))
            said = {"kind": "event", "label": one.label, "low": low, "high": high, "signs": [],
                    "event": {"event": "multipliers-meet", "impact": 0, "side": 0}}  # fmt: skip
            statement = _statement(Evidence(evidence.bits, shooting, (zero,)), said, strobe)
            if statement is not None:
                found.append(statement)
    return found


def _claims(proof: Proof) -> dict[str, Any]:
    """The range of an event's parameter, and the signs of a corner impact."""
    low, high = _range_of(proof.value)
    signs = [sign for _, sign in proof.signs]
    return {"signs": signs, "low": low, "high": high}


def _range(one: Range) -> dict[str, Any]:
    """The ends of a branch: each a number from the first to the second."""
    return {"low": list(_range_of(one.low)), "high": list(_range_of(one.high))}


def _range_of(text: str) -> tuple[str, str]:
    """(low, high) of "[middle +/- radius]", or twice the number that the text of a double means."""
    if not text.startswith("["):
        return exact(float(text)), exact(float(text))
    middle, _, shown = text.strip("[]").partition(" +/- ")
    radius = 2 * Fraction(shown or 0)  # the event may lie close to an end of what is printed
    ends = (Fraction(middle) - radius, Fraction(middle) + radius)
    return decimal(ends[0]), decimal(ends[1])


def _ends_of(x: arb) -> dict[str, str]:
    """The ends of a ball, as text: twice the number itself where that is exact."""
    low, high = (exactly(x),) * 2 if x == x.mid() else _range_of(x.str(DIGITS_OF_MEETING))
    return {"low": low, "high": high}


def _statement(evidence: Evidence, said: dict[str, Any], strobe: float) -> dict[str, Any] | None:
    """A statement with its boxes; None where the flights of a box cannot be divided."""
    shooting = evidence.shooting
    about = _about(shooting, (shooting.parameter,), strobe)
    if about is None:
        return None
    (parameter,), common = about
    statement = {**said, "parameter": parameter, **common}
    try:
        if said["kind"] == "branch":
            flights = partial(_flights, shooting)
            boxes, joint_boxes = _with_flights(evidence, shooting.box, flights)
        else:
            roomy = [_roomy(box, said["kind"] == "event") for box in evidence.boxes]
            boxes = [
                {**_box(box), "flights": _flights(shooting, _hull(box, evidence.axes))}
                for box in roomy
            ]
    except (UndecidedError, NotProvedError):
        return None
    if said["kind"] == "branch":
        ends = [None if end is None else _event(end) for end in evidence.ends]
        events = [ends[0], *[None] * (len(joint_boxes) - 2), ends[1]]
        joints = [
            _box(_roomy(box, event is not None))
            for box, event in zip(joint_boxes, events, strict=True)
        ]
        return {**statement, "ends": ends, "boxes": boxes, "joints": joints}
    if said["kind"] == "event":
        if not evidence.ends:  # its event is said
            return {**statement, "box": boxes[0]}
        end = evidence.ends[0]
        assert end is not None
        return {**statement, "event": _event(end), "box": boxes[0]}
    box = evidence.boxes[0]
    low, high = (box.middle[-1] + side * box.half for side in (-1, 1))
    values = {"low": exactly(low), "high": exactly(high)}
    return {**statement, **values, "box": boxes[0]}


def _about(
    shooting: Shooting, keys: Sequence[str], strobe: float
) -> tuple[list[str], dict[str, Any]] | None:
    """(the parameters as a certificate names them, what it says of a machine and of its orbits).

    keys: of what varies. None where a certificate has no statement along one of these.
    """
    names: list[str] = []
    left_open: set[str] = set()
    for key in keys:
        named: tuple[str, set[str]] | None = (key, {key})
        if key not in PARAMETERS:
            named = name_in_formula(shooting.shape, key)
        if named is None or not named[1] <= {*CONSTANTS}:
            return None
        names.append(named[0])
        left_open |= named[1]
    known = {"rpm": shooting.rpm, **vars(shooting.follower), **dict.fromkeys(left_open)}
    return names, {
        "constants": {key: None if known[key] is None else exact(known[key]) for key in CONSTANTS},
        "turns": shooting.turns,
        "strobe": exact(strobe),
        "impacts": [{"stretch": p.stretch, "turn": p.turn} for p in shooting.places],
    }


def _curve_statement(part: CurveRange, label: str, strobe: float) -> dict[str, Any] | None:
    """The statement that a bifurcation happens along a part of a curve; None where there is none.

    label: of its orbits; strobe: deg.
    """
    evidence = part.evidence
    if evidence is None or evidence.on.condition.test not in TESTS:
        return None
    on = evidence.on
    about = _about(on.meeting.base, on.meeting.plane.names, strobe)
    if about is None:
        return None
    (first, second), common = about

    def flights(hull: list[arb]) -> list[dict[str, Any]]:
        """Those of the orbits in a hull of the curve."""
        shooting, orbits = on.flown(hull)
        if on.touched is None:
            return _flights(shooting, orbits)
        touch = Touch(on.condition.impact, hull[-1])
        return [
            divided_flight(shooting, orbits, k, touch=touch if k == touch.flight else None)
            for k in range(shooting.n)
        ]

    with precision(int(evidence.bits * log10(2))):
        ctx.prec = evidence.bits
        try:
            for box in evidence.boxes:
                prove_label(on.meeting.base, box, radians(strobe), label)
            boxes, joints = _with_flights(evidence, on.box, flights)
        except (UndecidedError, NotProvedError):
            return None
        begin, end = (
            {
                name: _ends_of(x)
                for name, x in zip(("parameter", "second"), on.values(joint.hull()), strict=True)
            }
            for joint in (joints[0], joints[-1])
        )
        return {
            "kind": "curve",
            "label": label,
            "parameter": first,
            "second": second,
            **common,
            "event": _event_of_curve(on),
            "begin": begin,
            "end": end,
            "boxes": boxes,
            "joints": [_box(_roomy(box)) for box in joints],
        }


def _event_of_curve(on: OnCurve) -> dict[str, Any]:
    """The event of a curve, as a certificate has it; of a graze the flight and where it touches."""
    condition, touched = on.condition, on.touched
    return {
        "event": str(condition.test),
        "impact": max(condition.impact, 0),
        "side": condition.side,
        "touch": None if touched is None else {"stretch": touched.stretch, "turn": touched.turn},
    }


def _texts(axes: Axes) -> list[list[str]]:
    """The numbers of ellipses as text."""
    return [[exact(x) for x in one] for one in axes]


def _event(located: Located) -> dict[str, Any]:
    """The kind of an event; which impact is at a corner, at the end of its stretch (1) or not."""
    at_corner = located.kind == Kind.CORNER_IMPACT
    return {
        "event": str(located.kind),
        "impact": located.impact if at_corner else 0,
        "side": located.side if at_corner else 0,
    }


# -- boxes


def _rounded(x: arb, digits: int) -> str:
    """The middle of a ball to so many digits."""
    return x.mid().str(digits, radius=False).replace("e+", "e")


def _widened(x: arb) -> str:
    """A radius, written larger than it is."""
    return (x.abs_upper() * ROUNDED_UP).mid().str(5, radius=False).replace("e+", "e")


def _roomy(box: Box, event: bool = False) -> Box:
    """The box, made wider by more than the rounding of its middle may change.

    event: the box is about an event, and is made longer too, so that one of its ends lies before
    the event and the other behind it for certain.
    """
    least = arb(10) ** -_digits()
    sizes = [1 + abs(x) for x in box.middle]
    room = [arb(0, least * SPARE * size) for size in sizes]
    slack = SLACK if box.half > NARROW else SLACK_OF_NARROW
    within = [slack * e + more for e, more in zip(box.within, room, strict=True)]
    within[box.fixed] = arb(0)
    half = box.half + least * SPARE_OF_EVENT * sizes[box.fixed] if event else box.half
    return replace(box, within=within, error=within, half=half.upper())


def _digits() -> int:
    """Digits to which the middle of a box is rounded."""
    return int(ctx.prec * DIGITS_OF_BITS)


def _box(box: Box) -> dict[str, Any]:
    """A box as text, for orbits that were shown to lie in it once it was made roomy.

    The unknown that is given (`fixed`) keeps its value where that is a double.
    """
    middle = [_rounded(x, _digits()) for x in box.middle]
    error = [_widened(e) for e in box.within]
    tangent = [_rounded(t, OF_TANGENT) for t in box.tangent]
    given = box.middle[box.fixed]
    if given == float(given):
        middle[box.fixed] = exactly(given)
    error[box.fixed], tangent[box.fixed] = "0", "1"
    return {
        "middle": middle,
        "tangent": tangent,
        "error": error,
        "fixed": box.fixed,
        "half": exactly(box.half) if box.half == float(box.half) else _widened(box.half),
        "inverse": [[_rounded(x, OF_INVERSE) for x in row] for row in _rows(box.inverse)],
    }


def _rows(matrix: arb_mat) -> list[list[arb]]:
    """The rows of a matrix."""
    columns = range(matrix.ncols())
    return [[matrix[i, j] for j in columns] for i in range(matrix.nrows())]


# -- flights


def _hull(box: Box, axes: Axes) -> list[arb]:
    """The unknowns of all motions that start in a box, or in ellipses about its impacts."""
    hull = box.hull()
    for k, (a, b, c, d) in enumerate(axes):
        hull[2 * k] += arb(0, SLACK * hypot(a, b))
        hull[2 * k + 1] += arb(0, SLACK * hypot(c, d))
    return hull


def _flights(shooting: Shooting, hull: list[arb]) -> list[dict[str, Any]]:
    """The stretches that each flight passes, cut into parts on which the gap's
    sign, or that of its slope, is shown.
    """
    return [divided_flight(shooting, hull, k) for k in range(shooting.n)]


def divided_flight(
    shooting: Shooting,
    hull: Sequence[arb],
    k: int,
    lifts: bool = False,
    touch: Touch | None = None,
) -> dict[str, Any]:
    """Flight k from all starts in a hull, shown to be clear of the cam until it lands.

    lifts: it begins without a rate, as a rest ends; touch: where the gap is zero nevertheless, and
    its slope, too. Raises UndecidedError where that cannot be shown.
    """
    return coarsely(partial(_flight, shooting, hull, k, lifts, touch))


def _flight(
    shooting: Shooting, hull: Sequence[arb], k: int, lifts: bool, touch: Touch | None
) -> dict[str, Any]:
    """The passages of one flight; raises UndecidedError where no part is small enough.

    Phases are those of the turn in which a passage lies. The gap rises as far as that can be shown,
    falls from where that can be shown, and is above zero between.
    """
    passages = _passages(shooting, hull, k)
    lifted = _lifted(passages[0]) if lifts else []
    if lifted:
        passages[0] = replace(passages[0], begin=arb(lifted[0]))
    rising = _runs([partial(_run, one.rises, one.begin, one.end) for one in passages])
    top = len(rising) - 1  # the passage on which the gap stops to rise
    behind = [*passages[:top:-1], passages[top]]
    falling = _runs([partial(_run, one.falls, one.end, one.begin) for one in behind])
    bottom = len(passages) - len(falling)  # the passage on which it begins to fall
    rows: list[dict[str, Any]] = []
    for i, one in enumerate(passages):
        up = rising[i] if i <= top else Run([], one.begin)
        down = falling[len(passages) - 1 - i] if i >= bottom else Run([], one.end)
        between: list[float] = []
        touched = None
        if touch is not None:  # its phase, in the turn that this passage is in
            touched = hull[2 * k] + touch.angle
            touched -= 2 * arb.pi() * (one.place.turn - passages[0].place.turn)
        if top <= i <= bottom and up.reached is not None and down.reached is not None:
            between = _above(one, up.reached, down.reached, touched)
        cuts = [*up.cuts, *between, *down.cuts[::-1]]
        place = {"stretch": one.place.stretch, "turn": one.place.turn}
        rows.append({**place, "cuts": [_short(x) for x in cuts]})
    rise, fall = (sum(run.parts for run in runs) for runs in (rising, falling))
    rows[0]["cuts"] = [_short(x) for x in lifted] + rows[0]["cuts"]
    rise += len(lifted)
    if not (rise and fall) or rising[-1].reached is None:
        raise UndecidedError
    return {"rise": rise, "fall": fall, "passages": rows}


class Run(NamedTuple):
    """A way cut into parts, from its begin: how far it goes, None for all of the way."""

    cuts: list[float]
    reached: arb | None

    @property
    def parts(self) -> int:
        """How many parts there are."""
        return len(self.cuts) + (self.reached is None)


def _lifted(first: Passage) -> list[float]:
    """The end of the first part of a flight that begins without a rate: its gap is convex there."""
    way = 0.5 * float((first.end - first.begin).mid())
    for _ in range(DEEPEST):
        x = _near(float(first.begin.mid()) + way, way)
        if first.convex(first.begin, arb(x)):
            return [x]
        way /= 2.0
    raise UndecidedError


def _runs(tried: Sequence[Callable[[], Run]]) -> list[Run]:
    """One run after the other, up to the first that does not go all of its way."""
    runs: list[Run] = []
    for run in tried:
        runs.append(run())
        if runs[-1].reached is not None:
            break
    return runs


@dataclass(frozen=True)
class Passage:
    """A flight over one stretch, between two phases of its turn (rad)."""

    place: Place
    begin: arb
    end: arb
    gap: Callable[[arb, arb], tuple[arb, arb, arb]]

    def convex(self, a: arb, b: arb) -> bool:
        """Whether the slope of the gap rises from a to b."""
        return self.gap(a, b)[2] > 0

    def rises(self, a: arb, b: arb) -> bool:
        """Whether the gap rises from a to b."""
        return self.gap(a, b)[1] > 0

    def falls(self, b: arb, a: arb) -> bool:
        """Whether the gap falls from a to b."""
        return self.gap(a, b)[1] < 0

    def above(self, a: arb, b: arb) -> bool:
        """Whether the gap is above zero from a to b."""
        return self.gap(a, b)[0] > 0


def _passages(shooting: Shooting, hull: Sequence[arb], k: int) -> list[Passage]:
    """The passages of flight k of the orbits in a hull, in the order they are flown."""
    machine = shooting.machine(hull[-1])
    theta = hull[2 * k]
    c, c1, _ = shooting.lift(machine, shooting.places[k], theta)
    places = shooting.passed(k)
    passages = []
    for place in places:
        stretch = machine.stretches[place.stretch]
        # The phase of the impact that the flight begins with, in the turn that this passage is in.
        launch = theta - machine.turn * (place.turn - places[0].turn)
        gap = partial(
            _gap_enclosed,
            machine=machine, stretch=stretch, launch=launch, q=c, w=c1 + hull[2 * k + 1],
        )  # fmt: skip
        begin = theta if place is places[0] else stretch.start
        end = launch + shooting.span(hull, k) if place is places[-1] else stretch.end
        passages.append(Passage(place, begin, end, gap))
    return passages


def _gap_enclosed(
    a: arb, b: arb, machine: BallMachine, stretch: BallStretch, launch: arb, q: arb, w: arb
) -> tuple[arb, arb, arb]:
    """Balls that hold the gap (m), its slope and its second derivative on all phases from a to b.

    With x the middle of [a, b] and h the interval [a, b] - x, Taylor's formula with its remainder:
        gap'' in [a, b] = gap''(x + h),
        gap'(x + h)  lies in  gap'(x) + h gap''(x + h),
        gap(x + h)   lies in  gap(x) + h gap'(x) + h^2 gap''(x + h) / 2.
    h is WIDER than the interval: a checker's roundings may be larger than ours.

    launch: phase (rad) at which the follower leaves the cam, at position q (m) and velocity w
    (m/rad); stretch: of the cam, below the flight.
    """
    middle = a.union(b).mid()
    h = WIDER * (a.union(b) - middle)
    follower, follower1, _ = machine.move(q, w, middle - launch, 2)
    follower2 = machine.move(q, w, middle + h - launch, 2)[2]
    lift, lift1 = stretch.derivatives(middle, 1)
    lift2 = 0 if stretch.lift is None else derivatives(stretch.lift, middle + h, 2)[2]
    second = follower2 - lift2
    slope = follower1 - lift1
    gap = follower - lift + h * (slope + h * second / 2)
    return gap, slope + h * second, second


def _run(holds: Callable[[arb, arb], bool], begin: arb, end: arb) -> Run:
    """Cut the way from `begin` to `end`, as far as each part holds."""
    cuts: list[float] = []
    at, way = begin, float((end - begin).mid())
    step, least = way, abs(way) * SHORTEST_RUN
    while step and abs(step) >= (least if cuts else least * FIRST_RUN):
        if abs(step) >= abs(float((end - at).mid())):
            if holds(at, end):
                return Run(cuts, None)
        else:
            x = _near(float(at.mid()) + step, step)
            if holds(at, arb(x)):
                cuts.append(x)
                at = arb(x)
                step *= 3.0
        step /= 2.0
    if not way and holds(begin, end):  # an impact at the very end of a stretch
        return Run(cuts, None)
    return Run(cuts, at)


def _above(one: Passage, low: arb, high: arb, touched: arb | None) -> list[float]:
    """Phases that cut a passage from low to high into parts on which the gap is positive.

    touched: the phase of a touch. Where that lies on the way its part is one on which the slope of
    the gap rises, as large as can be.
    """
    if touched is None or touched < low or touched > high:
        return _parts(one.above, low, high)
    way = 0.5 * float((high - low).mid())
    for _ in range(DEEPEST):
        a, b = (arb(_near(float(touched.mid()) + side * way, way)) for side in (-1, 1))
        beside = low < a and a < touched and touched < b and b < high
        if beside and one.convex(a, b):
            ends = [float(x.mid()) for x in (a, b)]
            return [*_parts(one.above, low, a), *ends, *_parts(one.above, b, high)]
        way *= SHRUNK
    raise UndecidedError


def _parts(holds: Callable[[arb, arb], bool], low: arb, high: arb) -> list[float]:
    """Phases that cut the way from low to high into parts on each of which the gap is positive."""
    cuts: list[float] = []
    todo = [(low, high, 0)]
    while todo:
        a, b, depth = todo.pop()
        if holds(a, b):
            cuts.append(float(b.mid()))
            continue
        if depth == DEEPEST or not float(b - a) > 0:
            raise UndecidedError
        x = arb(_near(0.5 * float(a + b), 0.5 * float(b - a)))
        todo += [(x, b, depth + 1), (a, x, depth + 1)]
    return cuts[:-1]


def _near(x: float, width: float) -> float:
    """A number with few digits, off x by at most a twentieth of a width."""
    return round(x, max(0, 1 + ceil(-log10(abs(width)))))


def _short(x: float) -> str:
    """A phase as text."""
    return f"{Decimal(repr(x)):f}"
