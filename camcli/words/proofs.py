"""What was proved in ball arithmetic, and the step at which a proof failed."""

from collections.abc import Iterator, Sequence
from math import degrees, hypot
from typing import Any

from camcli.analysis.after_rest import HoldsFor
from camcli.analysis.orbits.curve_proofs import CurveRange
from camcli.analysis.orbits.orbit import PeriodicOrbit
from camcli.analysis.orbits.proofs import Range
from camcli.analysis.orbits.starts import Starts, rounded_down
from camcli.analysis.orbits.study import Bifurcation, OrbitsResult
from camcli.errors import plural
from camcli.exact.shooting import ProofStep
from camcli.quantities import PARAMETERS
from camcli.system import omega_of
from camcli.words.border_collision import LEFT

MOST_VALUES = 3  # of points without a proof that are told
WHOSE = {  # machines that a proof of an orbit is about
    HoldsFor.LAST_DIGIT: " and every value that rounds to it",
    HoldsFor.EXACT_DATA: ", exactly these data",
}
NO_CERTIFICATE_OF_A_SEAT = (
    "proof.json has no statement on a lift table with lash, whose polynomials are rounded anew "
    "where they pass the seat: what is proved here was proved by camcli alone"
)
FAILED = {
    ProofStep.NO_ORBIT: "there is no orbit of these impacts where the numbers say",
    ProofStep.SINGULAR: "no box could be shown to hold exactly one orbit",
    ProofStep.ELSEWHERE: "an impact lies outside the smooth region it is said to be in",
    ProofStep.PASSES: "an impact passes an end of its part of the cam, the strobe or the angle "
    "zero there",
    ProofStep.STROBE: "an impact is so near to the strobe that the orbit, which exists, may have "
    "another label",
    ProofStep.PULLS: "an impact would have to pull",
    ProofStep.CONTACT: "the cam is met between two impacts",
    ProofStep.GRAZES: "a flight is too near to grazing to exclude a contact",
    ProofStep.NEUTRAL: "a multiplier is too near to the unit circle",
    ProofStep.CROSSING: "the crossing condition could not be shown",
    ProofStep.NUMBER: "the value lies outside the error that is claimed for it",
    ProofStep.BOXES: "more boxes would be needed than are tried",
    ProofStep.WORK_BUDGET: "the budget of work was used up",
    ProofStep.FAULT: "it failed in a way that nobody foresaw",
    ProofStep.NO_CHAIN: "no boxes were found about an unstable orbit with one impact and a chain "
    "of impacts that leaves it and comes back to it",
    ProofStep.COVERING: "a box was not shown to be mapped over another one",
    ProofStep.MODEL: "its contact, a rest or a graze, is of a kind that is not followed exactly",
    ProofStep.CAM: "the cam is not known in ball arithmetic over this number",
}


def named(one: PeriodicOrbit | Bifurcation | Range | CurveRange) -> str:
    """What was proved, in a few words."""
    if isinstance(one, CurveRange):
        return f"curve {one.curve} from point {one.first} to point {one.last}"
    if isinstance(one, PeriodicOrbit):
        return f"{one.label} at {one.rpm!r} rpm"
    if isinstance(one, Bifurcation):
        return f"{one.kind} of {one.label} at {one.value!r}"
    return f"branch of {one.label} from {one.low} to {one.high}"


def range_record(one: Range | CurveRange) -> dict[str, Any]:
    """The entry of run.json for a stretch of a branch between two events, or of a curve."""
    entries = {key: value for key, value in vars(one).items() if key != "evidence"}
    failed = None if one.failed_step is None else FAILED[one.failed_step]
    return {**entries, "failed_step": failed}


def _orbit(orbit: PeriodicOrbit) -> str:
    """An orbit with its speed; whether it is stable, where multipliers were enclosed."""
    if orbit.resting:
        state = ""
    elif orbit.stable:
        state = ", stable"
    else:
        state = ", unstable"
    return f"{orbit.label}{state}, rpm = {orbit.rpm!r}"


def _starts(starts: Starts | None, rpm: float) -> str:
    """Which starts must end at a proved attractor: their share of the window, or their area.

    The number is rounded down, so that no more is said than is proved.
    """
    if starts is None:
        return ""
    if starts.share is None:
        area = rounded_down(starts.area, 3)
        return f", so that starts at the strobe on an area of at least {area:g} m * m/s end there"
    percent = rounded_down(100.0 * starts.share, 3)
    return (
        f", so that at least {percent:g} % of the starts in the window of cam basins "
        f"at {rpm!r} rpm end there"
    )


def closed_flank(excess: float) -> str:
    """That a proof is about the cam of arcs whose circles close, by how much (m) it is another."""
    return (
        "all proofs are about the cam whose circles close: its flank circle has the radius "
        f"base_radius + flank_center, {abs(excess):.3g} m {'more' if excess > 0 else 'less'} "
        "than the flank_radius of the scene"
    )


def place_of(values: Sequence[float], names: Sequence[str]) -> str:
    """Both numbers that vary: rpm 376.3732, restitution 0.7717172; names: of their columns."""
    short = [name if name in PARAMETERS else name.rpartition(".")[2] for name in names]
    return ", ".join(f"{n} {value:.10g}" for n, value in zip(short, values, strict=True))


def along_curves(parts: Sequence[CurveRange], names: Sequence[str]) -> Iterator[str]:
    """What is proved of each part of the curves; that the budget was used up is told once."""
    left_out = [part for part in parts if part.failed_step == ProofStep.WORK_BUDGET]
    yield from (without_a_gap(part, names) for part in parts if part not in left_out)
    numbers = [str(number) for number in dict.fromkeys(part.curve for part in left_out)]
    if len(left_out) == 1:
        yield without_a_gap(left_out[0], names)
    elif left_out:
        which = f"curve {numbers[0]}"
        if len(numbers) > 1:
            which = f"curves {', '.join(numbers[:-1])} and {numbers[-1]}"
        yield f"not proved: parts of {which}: {FAILED[ProofStep.WORK_BUDGET]}"


def without_a_gap(part: CurveRange, names: Sequence[str]) -> str:
    """That a part of a curve is proved from end to end, or the step that failed."""
    first, last = (place_of(values, names) for values in part.places)
    if part.failed_step is not None:
        why = FAILED[part.failed_step]
        return f"not proved: curve {part.curve} has no gap from {first} to {last}: {why}"
    return (
        f"proved: curve {part.curve} has no gap from {first} to {last}, where its bifurcation "
        f"happens at every value between ({part.boxes} boxes)"
    )


def proof_sentences(result: OrbitsResult) -> Iterator[str]:
    """What was proved, and the step at which the rest failed."""
    if result.proofs is None:
        return
    name, proofs = result.question.parameter, result.proofs
    if excess := proofs.flank_excess:
        yield closed_flank(excess)
    said = [
        (_orbit(o) + WHOSE[p.holds_for] if p.proved else str(o.label), p)
        for o, p in zip(result.orbits, proofs.orbits, strict=True)
    ]
    said += [
        (f"{b.kind} of {b.label}", p)
        for b, p in zip(result.bifurcations, proofs.events, strict=True)
    ]
    for text, p in dict.fromkeys(said):
        if p.step is None:
            signs = "".join(f", {LEFT[rule]} {'<>'[sign > 0]} 0" for rule, sign in p.signs)
            yield f"proved: {text}" + (f", {name} = {p.value}{signs}" if p.value else "")
        else:
            yield f"{'refuted' if p.refuted else 'not proved'}: {text}: {FAILED[p.step]}"
    for orbit, p in zip(result.orbits, proofs.orbits, strict=True):
        if p.axes:
            a, b, c, d = p.axes[0]
            by_theta = rounded_down(degrees(hypot(a, b)), 3)
            by_v = rounded_down(hypot(c, d) * omega_of(orbit.rpm), 3)
            yield (
                "proved: every motion with an impact in an ellipse about impact 1 of "
                f"{orbit.label}, {by_theta:g} deg and {by_v:g} m/s to either side, tends to it"
                + _starts(p.starts, orbit.rpm)
            )
    for points, branch in zip(proofs.points, result.branches, strict=True):
        done = sum(p.proved for p in points)
        yield f"proved: {done} of the {len(points)} points of branch {branch.number}"
        for step in dict.fromkeys(p.step for p in points if p.step is not None):
            values = [
                f"{orbit.value:.10g}"
                for orbit, p in zip(branch.points, points, strict=True)
                if p.step is step
            ]
            told = values if len(values) <= MOST_VALUES else [*values[:MOST_VALUES], "..."]
            yield (
                f"not proved: {plural(len(values), 'point')} of branch {branch.number}, {name} = "
                f"{', '.join(told)}: {FAILED[step]}"
            )
    for number, points in enumerate(proofs.curves, 1):
        done = sum(p.proved for p in points)
        yield f"proved: {done} of the {len(points)} points of curve {number}"
        for step in dict.fromkeys(p.step for p in points if p.step is not None):
            yield f"not proved: a point of curve {number}: {FAILED[step]}"
    plane = result.question.plane
    if plane is not None:
        yield from along_curves(proofs.curve_ranges, plane.names)
    for one in proofs.ranges:
        state = "stable" if one.stable else "unstable"
        of = f"branch {one.branch}"
        if one.failed_step is not None:
            yield (
                f"not proved: {one.label} for all {name} from {one.low} to {one.high} ({of}): "
                f"{FAILED[one.failed_step]}"
            )
            continue
        yield (
            f"proved: {one.label} exists and is {state} for all {name} from {one.low} to "
            f"{one.high} ({of}, {one.boxes} boxes)"
        )
