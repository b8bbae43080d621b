"""Certificates: what was proved, in numbers as text, so that `camcli.check` can check it by itself.

What the entries mean, and the theorems that they certify, stand in the guide (`proofs`). Numbers of
the scene are written as the decimal numbers that their doubles are, angles of a law as they were
written; boxes are rounded to DIGITS_OF_BITS of their digits and widened by what that may move them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
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
    certificate can have; strobe: deg; name_of: the name of what was proved. The entry `uncovered`
    names what was proved in a way that a certificate has no statement for.
    """
    statements = []
    uncovered = []
    proofs = study.proofs
    assert proofs is not None
    for proved in _proved(study, proofs):
        statement = None
        if proved.evidence is not None and cam is not None:
            with _bits_of(proved.evidence):
                statement = _statement(proved.evidence, proved.claims, strobe)
        if statement is None:
            uncovered.append(name_of(proved.of))
        else:
            statements.append(statement)
    of_curves = certificate_of_curves(proofs.curve_ranges, study.curves, cam, strobe, name_of)
    statements += of_curves["statements"]
    uncovered += of_curves["uncovered"]
    if cam is not None:
        for branch in proofs.ranges:
            statements += _meetings(branch, strobe)
        all_orbits = _all_orbits(study, statements, strobe)
        if all_orbits is not None:
            statements.append(all_orbits)
    return {
        "format": FORMAT,
        "cam": cam,
        "statements": statements,
        "uncovered": uncovered,
    }


@contextmanager
def _bits_of(evidence: Evidence | CurveEvidence) -> Iterator[None]:
    """Calculate with as many bits as the proof did, one thread at a time."""
    with precision(int(evidence.bits * log10(2))):
        ctx.prec = evidence.bits
        yield


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


def _all_orbits(
    study: OrbitsResult, statements: list[dict[str, Any]], strobe: float
) -> dict[str, Any] | None:
    """The statement that the orbits are all; None where one of them has no statement.

    statements: those made so far, that on each orbit among them.
    """
    every = study.every
    of_orbits = [statement for statement in statements if statement["kind"] == "orbit"]
    if every is None or every.failure is not None or len(of_orbits) < len(every.orbits):
        return None
    machine = {**vars(every.follower), "rpm": study.question.rpm}
    covers = [
        {
            "impacts": cover.impacts,
            "turns": cover.turns,
            "boxes": cover.letters,
            "orbits": list(cover.known),
        }
        for cover in every.covers
    ]
    return {
        "kind": "all-orbits",
        "constants": {key: exact(machine[key]) for key in CONSTANTS},
        "strobe": exact(strobe),
        "impacts": every.impacts,
        "turns": every.turns,
        "orbits": of_orbits,
        "covers": covers,
    }


class Proved(NamedTuple):
    """What was proved, of which orbit, event or range.

    evidence: None where a certificate has no statement of this kind, as of a graze or of an orbit
    that rests; it is then named among those that are not covered. claims: the entries of the
    statement that say what was proved, but for the boxes and the machine.
    """

    of: PeriodicOrbit | Bifurcation | Range
    evidence: Evidence | None
    claims: dict[str, Any]


def _proved(study: OrbitsResult, proofs: Proofs) -> Iterator[Proved]:
    """All that was proved of a study, but for the single points of its branches."""
    for orbit, proof in zip(study.orbits, proofs.orbits, strict=True):
        label = str(orbit.label)
        if proof.proved:
            claims = {"kind": "orbit", "label": label, "stable": orbit.stable}
            yield Proved(orbit, proof.evidence, claims)
        if proof.axes and proof.evidence is not None:
            claims = {"kind": "attractor", "label": label, "axes": _texts(proof.axes)}
            yield Proved(orbit, replace(proof.evidence, axes=proof.axes), claims)
    for event, proof in zip(study.bifurcations, proofs.events, strict=True):
        if proof.proved:
            evidence = proof.evidence if event.kind in KINDS else None
            claims = {"kind": "event", "label": str(event.orbit.label), **_claims(proof)}
            yield Proved(event, evidence, claims)
    for part in proofs.ranges:
        if part.failed_step is None:
            ends = part.evidence.ends if part.evidence is not None else ()
            known_ends = all(end is None or end.kind in KINDS for end in ends)
            evidence = part.evidence if known_ends else None
            claims = {"kind": "branch", "label": part.label, "stable": part.stable, **_range(part)}
            yield Proved(part, evidence, claims)


class BoxAt(Protocol):
    """What finds the box near a guess, as `Shooting.box` does."""

    def __call__(self, guess: Sequence[arb], fixed: int, half: arb | int = 0, /) -> Box: ...


def _with_flights(
    evidence: Evidence | CurveEvidence,
    box_at: BoxAt,
    flights_of: Callable[[list[arb]], list[dict[str, Any]]],
) -> tuple[list[dict[str, Any]], list[Box]]:
    """(the boxes of a branch or a curve as text with their flights, the joints between them).

    box_at: finds another box; flights_of: the flights of the orbits in a hull. A box whose flights
    cannot be divided is cut in two, which share a joint. Raises NotProvedError or UndecidedError
    where that does not help.
    """
    joints = [evidence.joints[0]]
    texts: list[dict[str, Any]] = []
    # boxes to be written, in order: each with the joint behind it, and how often it was cut
    waiting = [
        (box, after, 0) for box, after in zip(evidence.boxes, evidence.joints[1:], strict=True)
    ]
    while waiting:
        box, after, cuts = waiting.pop(0)
        roomy = _roomy(box)
        try:
            text = {**_box(roomy), "flights": flights_of(roomy.hull())}
        except UndecidedError:
            if cuts == MOST_CUTS:
                raise
            halves = _halves(box_at, box, joints[-1], after)
            waiting[:0] = [(half, behind, cuts + 1) for half, behind in halves]
            continue
        joints.append(after)
        texts.append(text)
    return texts, joints


def _halves(box_at: BoxAt, box: Box, before: Box, after: Box) -> list[tuple[Box, Box]]:
    """The two halves of a box between two joints, each with the joint behind it."""
    start = before.hull()[box.fixed]  # values of the given unknown
    end = after.hull()[box.fixed]
    middle = ((start + end) / 2).mid()
    joint = box_at(box.orbit_at(middle - box.middle[box.fixed]), box.fixed)
    halves = []
    for a, b, joint_behind in ((start, middle, joint), (middle, end, after)):
        center = ((a + b) / 2).mid()
        half_width = (abs(b - a) / 2 * SLACK).upper()
        guess = box.orbit_at(center - box.middle[box.fixed])
        guess[box.fixed] = center
        halves.append((box_at(guess, box.fixed, half_width), joint_behind))
    return halves


def _meetings(branch: Range, strobe: float) -> list[dict[str, Any]]:
    """Statements of where on a proved branch both multipliers meet: there they turn complex.

    That is a zero of trace^2 - 4 det, looked for where its sign changes from joint to joint.
    """
    evidence = branch.evidence
    if branch.failed_step is not None or evidence is None:
        return []
    shooting = evidence.shooting

    def apart(z: Sequence[Any]) -> Any:
        """The square of the distance between the multipliers."""
        trace, det = shooting.trace_det(z)
        return trace * trace - 4 * det

    statements = []
    with _bits_of(evidence):
        values = [float(apart(joint.middle)) for joint in evidence.joints]
        for box, joints, (before, behind) in zip(
            evidence.boxes, pairwise(evidence.joints), pairwise(values), strict=True
        ):
            if not before * behind < 0:
                continue
            first, second = (joint.middle[box.fixed] for joint in joints)
            near = first + (second - first) * (before / (before - behind))
            guess = [x.mid() for x in box.orbit_at(near - box.middle[box.fixed])]
            try:
                zero, _ = shooting.zero(guess, box.fixed, apart)
            except (NotProvedError, UndecidedError):
                continue
            low, high = _range_of(zero.hull()[-1].str(DIGITS_OF_MEETING))
            claims = {
                "kind": "event",
                "label": branch.label,
                "low": low,
                "high": high,
                "signs": [],
                "event": {"event": "multipliers-meet", "impact": 0, "side": 0},
            }
            statement = _statement(Evidence(evidence.bits, shooting, (zero,)), claims, strobe)
            if statement is not None:
                statements.append(statement)
    return statements


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
    middle, _, printed_radius = text.strip("[]").partition(" +/- ")
    radius = 2 * Fraction(printed_radius or 0)  # the event may lie close to an end of what is shown
    return decimal(Fraction(middle) - radius), decimal(Fraction(middle) + radius)


def _ends_of(x: arb) -> dict[str, str]:
    """The ends of a ball, as text: twice the number itself where that is exact."""
    if x == x.mid():
        return {"low": exactly(x), "high": exactly(x)}
    low, high = _range_of(x.str(DIGITS_OF_MEETING))
    return {"low": low, "high": high}


def _statement(evidence: Evidence, claims: dict[str, Any], strobe: float) -> dict[str, Any] | None:
    """A statement with its machine and its boxes; None where no certificate can have it.

    That is so where the flights of a box cannot be divided, or where what varies has no formula.
    claims: its other entries, its kind among them; strobe: deg.
    """
    shooting = evidence.shooting
    about = _about(shooting, (shooting.parameter,), strobe)
    if about is None:
        return None
    statement = {**claims, "parameter": about.parameters[0], **about.entries}
    is_event = claims["kind"] == "event"
    box = evidence.boxes[0]
    if is_event and evidence.ends:  # else the event is among the claims
        event = evidence.ends[0]
        assert event is not None
        statement["event"] = _event(event)
    elif claims["kind"] in ("orbit", "attractor"):
        statement["low"] = exactly(box.middle[-1] - box.half)
        statement["high"] = exactly(box.middle[-1] + box.half)
    try:
        if claims["kind"] == "branch":
            return {**statement, **_entries_of_branch(evidence)}
        roomy = _roomy(box, is_event)
        flights = _flights(shooting, _hull(roomy, evidence.axes))
    except (UndecidedError, NotProvedError):
        return None
    return {**statement, "box": {**_box(roomy), "flights": flights}}


def _entries_of_branch(evidence: Evidence) -> dict[str, Any]:
    """The events at both ends of a branch, its boxes with their flights, and its joints.

    A joint at an event is made longer, see `_roomy`. Raises UndecidedError or NotProvedError.
    """
    flights_of = partial(_flights, evidence.shooting)
    boxes, joint_boxes = _with_flights(evidence, evidence.shooting.box, flights_of)
    ends = [None if end is None else _event(end) for end in evidence.ends]
    joints = []
    for number, box in enumerate(joint_boxes):
        at_event = (number == 0 and ends[0] is not None) or (
            number == len(joint_boxes) - 1 and ends[1] is not None
        )
        joints.append(_box(_roomy(box, at_event)))
    return {"ends": ends, "boxes": boxes, "joints": joints}


class About(NamedTuple):
    """What a statement is about: its parameters as a certificate names them, and its entries.

    entries: the machine's constants, None for those that follow from the parameters; turns, strobe
    and impacts of the orbits.
    """

    parameters: list[str]
    entries: dict[str, Any]


def _about(shooting: Shooting, keys: Sequence[str], strobe: float) -> About | None:
    """What a statement on orbits along some numbers is about.

    keys: of what varies, a constant or a number of the cam; strobe: deg. None where a certificate
    has no statement along one of these.
    """
    parameters: list[str] = []
    left_open: set[str] = set()
    for key in keys:
        # the parameter's name in the cam's formula, and the constants that follow from it
        named: tuple[str, set[str]] | None = (key, {key})
        if key not in PARAMETERS:
            named = name_in_formula(shooting.shape, key)
        if named is None:
            return None
        name, following = named
        if not following <= set(CONSTANTS):
            return None
        parameters.append(name)
        left_open |= following
    known = {"rpm": shooting.rpm, **vars(shooting.follower), **dict.fromkeys(left_open)}
    entries = {
        "constants": {key: None if known[key] is None else exact(known[key]) for key in CONSTANTS},
        "turns": shooting.turns,
        "strobe": exact(strobe),
        "impacts": [{"stretch": p.stretch, "turn": p.turn} for p in shooting.places],
    }
    return About(parameters, entries)


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
    first, second = about.parameters

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

    def end_at(joint: Box) -> dict[str, Any]:
        """Both parameters at an end of the curve."""
        first_value, second_value = on.values(joint.hull())
        return {"parameter": _ends_of(first_value), "second": _ends_of(second_value)}

    with _bits_of(evidence):
        try:
            for box in evidence.boxes:
                prove_label(on.meeting.base, box, radians(strobe), label)
            boxes, joints = _with_flights(evidence, on.box, flights)
        except (UndecidedError, NotProvedError):
            return None
        return {
            "kind": "curve",
            "label": label,
            "parameter": first,
            "second": second,
            **about.entries,
            "event": _event_of_curve(on),
            "begin": end_at(joints[0]),
            "end": end_at(joints[-1]),
            "boxes": boxes,
            "joints": [_box(_roomy(box)) for box in joints],
        }


def _event_of_curve(on: OnCurve) -> dict[str, Any]:
    """The event of a curve, as a certificate has it; of a graze the flight and where it touches."""
    condition = on.condition
    touched = on.touched
    touch = None
    if touched is not None:
        touch = {"stretch": touched.stretch, "turn": touched.turn}
    return {
        "event": str(condition.test),
        "impact": max(condition.impact, 0),
        "side": condition.side,
        "touch": touch,
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
    error[box.fixed] = "0"
    tangent[box.fixed] = "1"
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
    falls from where that can be shown, and is above zero between. `rise` and `fall` count the parts
    on which it rises, and falls.
    """
    passages = _passages(shooting, hull, k)
    count = len(passages)
    lifted = _lifted(passages[0]) if lifts else []
    if lifted:
        passages[0] = replace(passages[0], begin=arb(lifted[0]))
    rising = _runs([partial(_run, one.rises, one.begin, one.end) for one in passages])
    top = len(rising) - 1  # the passage on which the gap stops to rise
    from_end_to_top = passages[top:][::-1]
    falling = _runs([partial(_run, one.falls, one.end, one.begin) for one in from_end_to_top])
    bottom = count - len(falling)  # the passage on which it begins to fall
    rows: list[dict[str, Any]] = []
    for i, passage in enumerate(passages):
        up = rising[i] if i <= top else Run([], passage.begin)
        down = falling[count - 1 - i] if i >= bottom else Run([], passage.end)
        between: list[float] = []
        if top <= i <= bottom and up.reached is not None and down.reached is not None:
            touched = None
            if touch is not None:  # its phase, in the turn that this passage is in
                turns = passage.place.turn - passages[0].place.turn
                touched = hull[2 * k] + touch.angle - 2 * arb.pi() * turns
            between = _above(passage, up.reached, down.reached, touched)
        cuts = [*up.cuts, *between, *down.cuts[::-1]]
        if i == 0:
            cuts = lifted + cuts
        rows.append(
            {
                "stretch": passage.place.stretch,
                "turn": passage.place.turn,
                "cuts": [_short(x) for x in cuts],
            }
        )
    rise = len(lifted) + sum(run.parts for run in rising)
    fall = sum(run.parts for run in falling)
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
    """The end of the first part of a flight that begins without a rate: its gap is convex there.

    It is looked for halfway through the first passage, a quarter, and so on: a list of one phase,
    rad. Raises UndecidedError.
    """
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
    v = hull[2 * k + 1]
    c, c1, _ = shooting.lift(machine, shooting.places[k], theta)
    places = shooting.passed(k)
    passages = []
    for place in places:
        stretch = machine.stretches[place.stretch]
        # The phase of the impact that the flight begins with, in the turn that this passage is in.
        launch = theta - machine.turn * (place.turn - places[0].turn)
        gap = partial(_gap_enclosed, machine=machine, stretch=stretch, launch=launch, q=c, w=c1 + v)
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
    x = a.union(b).mid()
    h = WIDER * (a.union(b) - x)
    follower, follower1, _ = machine.move(q, w, x - launch, 2)
    follower2 = machine.move(q, w, x + h - launch, 2)[2]
    lift, lift1 = stretch.derivatives(x, 1)
    lift2 = 0 if stretch.lift is None else derivatives(stretch.lift, x + h, 2)[2]
    second = follower2 - lift2
    slope_at_x = follower1 - lift1
    gap = follower - lift + h * (slope_at_x + h * second / 2)
    return gap, slope_at_x + h * second, second


def _run(holds: Callable[[arb, arb], bool], begin: arb, end: arb) -> Run:
    """Cut the way from `begin` to `end` (phases, rad), as far as each part holds.

    A part is as long as it can be shown to hold by halving it; the one behind it is tried half as
    long again. It stops where a part would be shorter than SHORTEST_RUN of the way.
    """
    cuts: list[float] = []
    at = begin
    way = float((end - begin).mid())
    step = way
    least = abs(way) * SHORTEST_RUN
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


def _above(passage: Passage, low: arb, high: arb, touched: arb | None) -> list[float]:
    """Phases that cut a passage from low to high into parts on which the gap is positive.

    touched: the phase of a touch. Where that lies on the way its part is one on which the slope of
    the gap rises, as large as can be. Raises UndecidedError.
    """
    if touched is None or touched < low or touched > high:
        return _parts(passage.above, low, high)
    reach = 0.5 * float((high - low).mid())
    for _ in range(DEEPEST):
        before = arb(_near(float(touched.mid()) - reach, reach))
        behind = arb(_near(float(touched.mid()) + reach, reach))
        inside = low < before and before < touched and touched < behind and behind < high
        if inside and passage.convex(before, behind):
            return [
                *_parts(passage.above, low, before),
                float(before.mid()),
                float(behind.mid()),
                *_parts(passage.above, behind, high),
            ]
        reach *= SHRUNK
    raise UndecidedError


def _parts(holds: Callable[[arb, arb], bool], low: arb, high: arb) -> list[float]:
    """Phases that cut the way from low to high into parts each of which holds.

    Parts are halved until they do; raises UndecidedError after DEEPEST halvings.
    """
    ends: list[float] = []  # of the parts that hold, from low on
    waiting = [(low, high, 0)]  # the last one is next: (begin, end, halvings)
    while waiting:
        a, b, depth = waiting.pop()
        if holds(a, b):
            ends.append(float(b.mid()))
            continue
        if depth == DEEPEST or not float(b - a) > 0:
            raise UndecidedError
        x = arb(_near(0.5 * float(a + b), 0.5 * float(b - a)))
        waiting += [(x, b, depth + 1), (a, x, depth + 1)]
    return ends[:-1]


def _near(x: float, width: float) -> float:
    """A number with few digits, off x by at most a twentieth of a width."""
    return round(x, max(0, 1 + ceil(-log10(abs(width)))))


def _short(x: float) -> str:
    """A phase as text."""
    return f"{Decimal(repr(x)):f}"
