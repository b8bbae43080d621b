"""What was proved in ball arithmetic, and the step at which a proof failed."""

from collections.abc import Iterator, Sequence
from math import degrees, hypot
from typing import Any

from camcli.analysis.after_rest import HoldsFor
from camcli.analysis.orbits.curve_proofs import CurveRange
from camcli.analysis.orbits.orbit import PeriodicOrbit
from camcli.analysis.orbits.proofs import Proof, Proofs, Range
from camcli.analysis.orbits.starts import Starts, rounded_down
from camcli.analysis.orbits.study import Bifurcation, OrbitsResult
from camcli.errors import plural
from camcli.exact.shooting import ProofStep
from camcli.system import omega_of
from camcli.words.border_collision import LEFT

MOST_VALUES = 3  # of points without a proof that a sentence names
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


def named(proved: PeriodicOrbit | Bifurcation | Range | CurveRange) -> str:
    """What was proved, in a few words."""
    if isinstance(proved, CurveRange):
        return f"curve {proved.curve} from point {proved.first} to point {proved.last}"
    if isinstance(proved, PeriodicOrbit):
        return f"{proved.label} at {proved.rpm!r} rpm"
    if isinstance(proved, Bifurcation):
        return f"{proved.kind} of {proved.label} at {proved.value!r}"
    return f"branch of {proved.label} from {proved.low} to {proved.high}"


def range_record(part: Range | CurveRange) -> dict[str, Any]:
    """The entry of run.json for a stretch of a branch between two events, or of a curve."""
    record = {key: value for key, value in vars(part).items() if key != "evidence"}
    record["failed_step"] = None if part.failed_step is None else FAILED[part.failed_step]
    return record


def _orbit(orbit: PeriodicOrbit) -> str:
    """An orbit with its speed, and, unless it rests, whether it is stable."""
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
    short_names = [name.rpartition(".")[2] for name in names]
    return ", ".join(
        f"{name} {value:.10g}" for name, value in zip(short_names, values, strict=True)
    )


def along_curves(parts: Sequence[CurveRange], names: Sequence[str]) -> Iterator[str]:
    """What is proved of each part of the curves, a sentence each.

    The parts for which no budget was left are told in one sentence. names: of both numbers.
    """
    no_budget = [part for part in parts if part.failed_step == ProofStep.WORK_BUDGET]
    yield from (without_a_gap(part, names) for part in parts if part not in no_budget)
    if len(no_budget) == 1:
        yield without_a_gap(no_budget[0], names)
    elif no_budget:
        *others, last = [str(number) for number in dict.fromkeys(part.curve for part in no_budget)]
        which = f"curves {', '.join(others)} and {last}" if others else f"curve {last}"
        yield f"not proved: parts of {which}: {FAILED[ProofStep.WORK_BUDGET]}"


def without_a_gap(part: CurveRange, names: Sequence[str]) -> str:
    """That a part of a curve is proved from end to end, or the step that failed."""
    first, last = (place_of(values, names) for values in part.places)
    if part.failed_step is not None:
        why = FAILED[part.failed_step]
        return f"not proved: curve {part.curve} has no gap from {first} to {last}: {why}"
    return (
        f"proved: curve {part.curve} has no gap from {first} to {last}, where its bifurcation "
        f"happens at every value between ({plural(part.boxes, 'box')})"
    )


def proof_sentences(result: OrbitsResult) -> Iterator[str]:
    """What was proved, and the step at which the rest failed."""
    proofs = result.proofs
    if proofs is None:
        return
    if proofs.flank_excess:
        yield closed_flank(proofs.flank_excess)
    yield from _on_orbits_and_events(result, proofs)
    yield from _on_ellipses(result, proofs)
    yield from _on_points_of_branches(result, proofs)
    yield from _on_points_of_curves(proofs)
    plane = result.question.plane
    if plane is not None:
        yield from along_curves(proofs.curve_ranges, plane.names)
    yield from _on_ranges(result, proofs)


def _on_orbits_and_events(result: OrbitsResult, proofs: Proofs) -> Iterator[str]:
    """Whether each orbit and each event is proved; what several branches share is told once."""
    name = result.question.parameter
    about: list[tuple[str, Proof]] = []
    for orbit, proof in zip(result.orbits, proofs.orbits, strict=True):
        text = _orbit(orbit) + WHOSE[proof.holds_for] if proof.proved else str(orbit.label)
        about.append((text, proof))
    for event, proof in zip(result.bifurcations, proofs.events, strict=True):
        about.append((f"{event.kind} of {event.label}", proof))
    for text, proof in dict.fromkeys(about):
        if proof.step is not None:
            outcome = "refuted" if proof.refuted else "not proved"
            yield f"{outcome}: {text}: {FAILED[proof.step]}"
        elif proof.value:
            signs = ""
            for rule, sign in proof.signs:
                signs += f", {LEFT[rule]} {'>' if sign > 0 else '<'} 0"
            yield f"proved: {text}, {name} = {proof.value}{signs}"
        else:
            yield f"proved: {text}"


def _on_ellipses(result: OrbitsResult, proofs: Proofs) -> Iterator[str]:
    """About which orbits an ellipse of motions is proved to tend to them, and how large it is."""
    for orbit, proof in zip(result.orbits, proofs.orbits, strict=True):
        if not proof.axes:
            continue
        # of the ellipse about impact 1: theta = a x + b y, rate = c x + d y with x^2 + y^2 <= 1
        a, b, c, d = proof.axes[0]
        theta_deg = rounded_down(degrees(hypot(a, b)), 3)
        velocity = rounded_down(hypot(c, d) * omega_of(orbit.rpm), 3)
        yield (
            "proved: every motion with an impact in an ellipse about impact 1 of "
            f"{orbit.label}, {theta_deg:g} deg and {velocity:g} m/s to either side, tends to it"
            + _starts(proof.starts, orbit.rpm)
        )


def _on_points_of_branches(result: OrbitsResult, proofs: Proofs) -> Iterator[str]:
    """How many points of each branch are proved, and at which step others failed."""
    name = result.question.parameter
    for of_branch, branch in zip(proofs.points, result.branches, strict=True):
        proved = sum(proof.proved for proof in of_branch)
        yield f"proved: {proved} of the {plural(len(of_branch), 'point')} of branch {branch.number}"
        values_by_step: dict[ProofStep, list[str]] = {}
        for orbit, proof in zip(branch.points, of_branch, strict=True):
            if proof.step is not None:
                values_by_step.setdefault(proof.step, []).append(f"{orbit.value:.10g}")
        for step, values in values_by_step.items():
            shown_values = values[:MOST_VALUES]
            if len(values) > MOST_VALUES:
                shown_values.append("...")
            yield (
                f"not proved: {plural(len(values), 'point')} of branch {branch.number}, {name} = "
                f"{', '.join(shown_values)}: {FAILED[step]}"
            )


def _on_points_of_curves(proofs: Proofs) -> Iterator[str]:
    """How many points of each curve are proved, and at which step others failed."""
    for number, of_curve in enumerate(proofs.curves, 1):
        proved = sum(proof.proved for proof in of_curve)
        yield f"proved: {proved} of the {plural(len(of_curve), 'point')} of curve {number}"
        for step in dict.fromkeys(proof.step for proof in of_curve if proof.step is not None):
            yield f"not proved: a point of curve {number}: {FAILED[step]}"


def _on_ranges(result: OrbitsResult, proofs: Proofs) -> Iterator[str]:
    """Over which ranges a branch is proved to go on from end to end."""
    name = result.question.parameter
    for part in proofs.ranges:
        along = f"for all {name} from {part.low} to {part.high}"
        branch = f"branch {part.branch}"
        if part.failed_step is not None:
            why = FAILED[part.failed_step]
            yield f"not proved: {part.label} {along} ({branch}): {why}"
            continue
        state = "stable" if part.stable else "unstable"
        boxes = plural(part.boxes, "box")
        yield f"proved: {part.label} exists and is {state} {along} ({branch}, {boxes})"
