"""What `cam orbits` says of orbits, branches and curves."""

from __future__ import annotations

from collections.abc import Sequence
from math import degrees
from typing import TYPE_CHECKING

from camcli.analysis.border_collision import Side
from camcli.analysis.orbits.curves import Curve
from camcli.analysis.orbits.kinds import Bracket, Kind
from camcli.analysis.orbits.study import Bifurcation, Branch, OrbitsResult
from camcli.errors import Status, is_or_are, plural
from camcli.kernel.certify import Verdict
from camcli.words.border_collision import inequality_text
from camcli.words.events import corner_line, event_words
from camcli.words.in_print import label_text, name_and_unit, number_text, pair, range_of
from camcli.words.speeds import run_speed, run_speeds, varies_speed
from camcli.words.statuses import trouble

if TYPE_CHECKING:
    from camcli.analysis.orbits.codim2 import CodimTwo

NEUTRAL = "det reaches 1 where nothing dissipates: orbits are centres or saddles, none attracts"
MOST_POINTS = 6  # of codimension two that have a sentence without --verbose
MOST_IN_A_CELL = 2  # stable ranges, or turning points, that a cell of a table has room for
MOST_RANGES = 5  # of stable orbits, or turning points, that the sentence on a branch names
SIDES = (
    "L, the left side of a corner impact, is the orbit whose impact lies before the corner; R, the "
    "right side, is the one behind it"
)
VERDICTS = {
    Verdict.ADMISSIBLE: "admissible",
    Verdict.EARLY: "virtual: penetrates the cam",
    Verdict.LATE: "virtual: an impact is missing",
    Verdict.PULLS: "virtual: an impact would have to pull",
    Verdict.DOUBTFUL: "nearer to grazing than double precision can tell",
}
CURVE_ENDS = {
    Kind.ANOTHER_CORNER: "an impact reaches a corner",
    Kind.NO_MOTION: "the orbit is no motion any more",
    Kind.SHORTER_ORBIT: "the orbit becomes one of fewer turns",
}


def end_words(end: Kind) -> str:
    """What ends a branch or a curve; most ends are known by their names."""
    return CURVE_ENDS.get(end, str(end))


def notes(result: OrbitsResult) -> list[str]:
    """What has no safe bracket, or could not be followed."""
    sentences = []
    for event in result.bifurcations:
        if event.status == Bracket.UNRESOLVED:
            what = f"{event.kind} of {event.label} near {event.value:.10g}"
            sentences.append(f"{Bracket.UNRESOLVED}: {what} has no safe bracket")
    for branch in result.branches:
        if Kind.LOST in branch.ends:
            value = _value_at_end(branch, Kind.LOST)
            beyond = f"beyond {value:.10g}, where it is unresolved"
            sentences.append(f"branch {branch.number} could not be followed {beyond}")
        if Kind.FAULT in branch.ends:
            value = _value_at_end(branch, Kind.FAULT)
            sentences += trouble(Status.FAULT, f" on branch {branch.number} beyond {value:.10g}")
    if result.every is not None:
        from camcli.words.all_orbits import all_notes  # it imports ball arithmetic

        sentences += all_notes(result, result.every)
    if result.chaos is not None and result.chaos.step is not None:
        from camcli.words.proofs import FAILED  # likewise

        sentences.append(f"it is not proved that there is chaos: {FAILED[result.chaos.step]}")
    if result.question.curve and not any(curve.points for curve in result.curves):
        sentences.append(
            f"no {result.question.curve} was located, so there is no curve to continue"
        )
    return sentences


def _value_at_end(branch: Branch, kind: Kind) -> float:
    """The value of the parameter at the end of a branch that is of this kind, the first if both."""
    first, _ = branch.ends
    end = branch.points[0] if first == kind else branch.points[-1]
    return end.value


def orbits_title(result: OrbitsResult, kind: str = "") -> str:
    """The title of the orbits found at one speed; kind: of the cam."""
    return f"Periodic orbits at {run_speed(result.question.rpm, kind)}"


def curve_title(number: int, curve: Curve) -> str:
    """The title of a bifurcation in two parameters."""
    corner = f" at {curve.corner}" if curve.corner else ""
    return f"Curve {number}: {curve.kind} of {curve.label}{corner}"


def remarks(result: OrbitsResult, verbose: bool = True, kind: str = "") -> list[str]:
    """Every sentence on the orbits found, their branches, events and curves.

    verbose: each event with the inequalities it rests on, each branch, and every point at which
    curves meet; kind: of the cam.
    """
    sentences = _found_or_not(result, kind)
    sentences += limit_sentences(result)
    count = len(result.virtual)
    if count:
        at = run_speed(result.question.rpm, kind)
        sentences.append(
            f"{plural(count, 'further root')} at {at} {is_or_are(count)} virtual: "
            "another contact lies on their way, or an impact would have to pull (run.json)"
        )
    sentences += [
        branch_line(branch, result.bifurcations)
        for branch in result.branches
        if verbose or more_than_a_table_tells(branch, result.bifurcations)
    ]
    sentences += _on_events(result, verbose)
    if result.proofs is not None:
        from camcli.words.proofs import proof_sentences  # it imports ball arithmetic

        sentences += proof_sentences(result)
    if result.every is not None:
        from camcli.words.all_orbits import all_sentences  # likewise

        sentences += all_sentences(result, result.every)
    if result.chaos is not None:
        from camcli.words.chaos import chaos_sentences  # likewise

        sentences += chaos_sentences(result.chaos)
    if result.branches and verbose:
        sentences.append(_no_neimark_sacker(result))
    return sentences + _on_curves(result, verbose)


def _found_or_not(result: OrbitsResult, kind: str) -> list[str]:
    """Sentences on a label, or any orbit, that was not found, and on orbits that fill a dwell.

    kind: of the cam. Where all orbits were asked for, another sentence says whether there are any.
    """
    sentences = []
    absent = result.absent
    if absent is not None:
        text = f"{result.question.label} was not found at {run_speed(absent.rpm, kind)}"
        if absent.nearest is None:
            between = run_speeds(absent.low, absent.high, kind)
            many = "frequencies" if kind == "oscillator" else "speeds"
            sentences.append(f"{text}, nor at 24 {many} from {between}")
        else:
            speed, cause = absent.nearest
            nearest = f"the nearest speed at which it was found is {speed:.13g} rpm"
            if kind == "oscillator":
                nearest = f"the nearest place at which it was found is {run_speed(speed, kind)}"
            sentences.append(f"{text}; {nearest}, where it ends: {cause.replace('-', ' ')}")
    elif not result.orbits and not result.continua and result.every is None:
        sentences.append(f"no periodic orbit was found at {run_speed(result.question.rpm, kind)}")
    return sentences + [
        f"{continuum.label} exists with its impact anywhere from {degrees(continuum.start):.8g} "
        f"to {degrees(continuum.end):.8g} deg, a dwell: a continuum of orbits, of which none is "
        "isolated and none attracts (both multipliers are 1)"
        for continuum in result.continua
    ]


def _on_events(result: OrbitsResult, verbose: bool) -> list[str]:
    """A sentence for each event that has words; what several branches share is told once."""
    words_by_event: dict[str, str] = {}
    for event in in_order(result.bifurcations):
        sentences = event_words(event)
        if not sentences:
            continue
        name = f"{event.kind} of {event.label} at {event.value:.10g}"
        if event.corner_impact is not None and not verbose:
            words = corner_line(event.corner_impact)
        else:
            words = " ".join(sentences) + _rests_on(event)
        words_by_event.setdefault(name, words)
    lines = [f"{name}: {words}" for name, words in words_by_event.items()]
    if verbose and any(event.corner_impact is not None for event in result.bifurcations):
        lines.append(SIDES)
    return lines


def _no_neimark_sacker(result: OrbitsResult) -> str:
    """Why no pair of complex multipliers crosses the unit circle: their product is below 1."""
    largest = max(orbit.det for branch in result.branches for orbit in branch.points)
    if not largest < 1.0:
        return NEUTRAL
    return (
        "Neimark-Sacker bifurcations are impossible: det = r^(2 impacts) exp(-b T/m) is at "
        f"most {largest:.6g} on these branches, below 1"
    )


def _on_curves(result: OrbitsResult, verbose: bool) -> list[str]:
    """Why each bifurcation curve ends, and the points at which curves meet."""
    sentences = []
    kinds_at_ends = points_at_ends(result.curves, result.codim2)
    for number, (curve, kinds) in enumerate(zip(result.curves, kinds_at_ends, strict=True), 1):
        sentences.append(f"curve {number} ends: {'; '.join(why_it_ends(curve, kinds))}")
    if result.codim2 and result.question.plane is not None:
        from camcli.words.codim2 import point_line  # it imports ball arithmetic

        points = result.codim2 if verbose else result.codim2[:MOST_POINTS]
        sentences += [point_line(point, result.question.plane.names) for point in points]
        further = len(result.codim2) - len(points)
        if further:
            sentences.append(f"{plural(further, 'further point')} of codimension two (codim2.csv)")
    return sentences


def why_it_ends(curve: Curve, kinds: tuple[str, str]) -> list[str]:
    """Why a curve ends on either side; kinds: of the points of codimension two there, or empty."""
    reasons = []
    for end, limit, point in zip(curve.ends, curve.limits, kinds, strict=True):
        if end == Kind.LOST:
            reasons.append(point or "it could not be followed further")
            continue
        words = f"{end_words(end)} of {limit}" if limit else end_words(end)
        reasons.append(f"{words} ({point})" if point else words)
    return reasons


def points_at_ends(curves: Sequence[Curve], points: Sequence[CodimTwo]) -> list[tuple[str, str]]:
    """The kind of the point of codimension two at the first and the last end of each curve.

    Empty where there is none.
    """
    kind_at: dict[tuple[int, int], str] = {}  # (number of the curve, 0 or 1 for its end)
    for point in points:
        for end in point.ends:
            kind_at[end] = str(point.kind)
    numbers = range(1, len(curves) + 1)
    return [(kind_at.get((number, 0), ""), kind_at.get((number, 1), "")) for number in numbers]


def limit_sentences(result: OrbitsResult) -> list[str]:
    """Where the range asked for leaves what is a machine, and why."""
    name = result.question.parameter
    return [
        f"there is no machine beyond {name} = {limit.value:.10g}, where branches end "
        f"({Kind.NO_MACHINE}): {limit.reason}"
        for limit in result.limits
    ]


def in_order(bifurcations: Sequence[Bifurcation]) -> list[Bifurcation]:
    """The events of each branch by their values, the first branch first."""
    return sorted(bifurcations, key=lambda event: (event.branch, event.value))


def branch_line(branch: Branch, bifurcations: Sequence[Bifurcation]) -> str:
    """Where the orbits of a branch are stable, and where it turns round.

    bifurcations: of the whole study.
    """
    ranges = [f"{low:.10g} to {high:.10g}" for low, high in branch.stable_ranges(bifurcations)]
    stable = "is nowhere stable"
    if ranges:
        stable = f"is stable from {_first_ones(ranges, 'in {} further ranges (run.json)')}"
    turns = [f"{value:.10g}" for value in branch.turning_points]
    turns_round = ""
    if turns:
        turns_round = f"; it turns round at {_first_ones(turns, '{} further values (run.json)')}"
    return f"branch {branch.number} {stable}{turns_round}"


def _first_ones(entries: Sequence[str], others: str) -> str:
    """The first MOST_RANGES entries; others: what stands for the rest, with {} for their number."""
    names = list(entries[:MOST_RANGES])
    if len(entries) > MOST_RANGES:
        names.append(others.format(len(entries) - MOST_RANGES))
    return ", ".join(names)


def stable_cell(branch: Branch, bifurcations: Sequence[Bifurcation]) -> str:
    """Where the orbits of a branch are stable, in a table; bifurcations: of the whole study."""
    ranges = branch.stable_ranges(bifurcations)
    return _cell([f"{low:.7g} to {high:.7g}" for low, high in ranges]) or "nowhere"


def turns_cell(branch: Branch) -> str:
    """Where a branch turns round, in a table."""
    return _cell([f"{value:.7g}" for value in branch.turning_points])


def _cell(entries: Sequence[str]) -> str:
    """Entries in one cell of a table: the first few of them where there are many."""
    first = list(entries[:MOST_IN_A_CELL])
    if len(entries) > MOST_IN_A_CELL:
        first.append("...")
    return ", ".join(first)


def more_than_a_table_tells(branch: Branch, bifurcations: Sequence[Bifurcation]) -> bool:
    """Whether a branch has more stable ranges or turning points than a table has room for."""
    ranges = branch.stable_ranges(bifurcations)
    turns = branch.turning_points
    return max(len(ranges), len(turns)) > MOST_IN_A_CELL


def _rests_on(event: Bifurcation) -> str:
    """The two inequalities that decide between the classes, with their numbers."""
    if event.corner_impact is None:
        return ""
    inequalities = []
    for inequality in event.corner_impact.collision.inequalities[:2]:
        holds = "holds" if inequality.holds else "fails"
        inequalities.append(f"{inequality_text(inequality)} {holds} ({inequality.left:.6g})")
    return f" The class rests on: {'; '.join(inequalities)}."


# --- beside the pictures


NO_MULTIPLIERS = "both multipliers of every orbit are zero, and are not drawn"


def heading(study: OrbitsResult, kind: str) -> tuple[str, str]:
    """(title, line below it) of the picture of orbits; kind: of the cam."""
    question = study.question
    parameter = question.parameter
    span = question.span
    at = _speed_in_print(question.rpm, kind)
    name, _ = name_and_unit(parameter)
    if span is None:
        title = f"Periodic orbits at {at}"
    else:
        unit = name_and_unit(parameter)[1]
        ends = f"{range_of(span.low, span.high)} {unit}".rstrip()
        if parameter == "rpm":
            title = f"Periodic orbits, {ends}"
        elif varies_speed([parameter]):
            title = f"Periodic orbits, {name} {ends}"
        else:
            title = f"Periodic orbits, {name} {ends} at {at}"
    found_at = at
    if span is not None and parameter != "rpm":
        found_at = f"{name} {value_text(study.value, parameter)}"
    words = f"{plural(len(study.orbits), 'orbit')} found at {found_at}"
    if question.label is not None:
        words += f", only {label_text(question.label)} asked for"
    if question.stable is not None:
        words += f", only {'stable' if question.stable else 'unstable'} ones followed"
    if study.absent is not None and study.orbits:
        words += f", none at {_speed_in_print(study.absent.rpm, kind)}"
    return title, words


def _speed_in_print(rpm: float, kind: str) -> str:
    """The speed of a run; of an oscillator the frequency of its force. kind: of the cam."""
    return run_speed(rpm, kind) if kind == "oscillator" else value_text(rpm, "rpm")


def value_text(value: float, parameter: str) -> str:
    """A value of the parameter with its unit."""
    return f"{number_text(float(f'{value:.9g}'))} {name_and_unit(parameter)[1]}".rstrip()


def nothing_found(study: OrbitsResult, kind: str) -> str:
    """Why there is no orbit to draw; kind: of the cam."""
    absent = study.absent
    if absent is None:
        return "no periodic orbit was found"
    label = label_text(study.question.label or "orbit")
    if absent.nearest is None:
        return f"no {label} was found from {run_speeds(absent.low, absent.high, kind)}"
    speed, end = absent.nearest
    at = _speed_in_print(speed, kind)
    return f"no {label} here; the nearest is at {at}: {end.replace('-', ' ')}"


def side_words(event: Bifurcation) -> list[str]:
    """The linear parts before and after the corner that an impact reaches."""
    words = []
    if event.left is not None:
        words.append(f"impact before the corner (left): {_side(event.left)}")
    if event.right is not None:
        words.append(f"impact after the corner (right): {_side(event.right)}")
    return words


def _side(side: Side) -> str:
    """Trace, determinant and multipliers of one side."""
    trace = f"{side.trace:.6g}".replace("-", "−")
    return f"trace {trace}, determinant {side.det:.6g}, multipliers {pair(side.trace, side.det)}"


def curve_name(curve: Curve) -> str:
    """A bifurcation in two parameters: its kind, its orbit, and why it ends."""
    corner = f" at {curve.corner}" if curve.corner else ""
    name = f"{curve.kind.replace('-', ' ')}{corner} of {label_text(curve.label)}"
    ends = {end_words(end) for end in curve.ends if end != Kind.END_OF_RANGE}
    return name + (f" (ends: {'; '.join(sorted(ends))})" if ends else "")


def branch_words(branch: Branch, parameter: str, source: int | None, longest: int) -> str:
    """A branch in the list: number, orbits, the event it leaves from, where it is lost.

    source: the number of that event, None where there is none. The regions of its impacts are added
    where the words are then no longer than so many characters.
    """
    names = [label_text(label, 22) for label in branch.labels]
    words = f"{branch.number}   {names[0]}"
    if len(names) > 1:
        words += f" to {names[-1]}"
    if source is not None:
        words += f", from event {source}"
    if Kind.LOST in branch.ends:
        words += f", lost at {value_text(_value_at_end(branch, Kind.LOST), parameter)}"
    middle = branch.points[len(branch.points) // 2]
    if middle.regions and len(names) == 1:
        regions = ", ".join(dict.fromkeys(middle.regions))
        with_regions = f"{words}, impacts in {regions}"
        if len(with_regions) <= longest:
            return with_regions
    return words
