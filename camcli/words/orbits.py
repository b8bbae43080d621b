"""What `cam orbits` says of orbits, branches and curves."""

from math import degrees

from camcli.analysis.orbits.curves import Curve
from camcli.analysis.orbits.kinds import Bracket, Kind
from camcli.analysis.orbits.study import Bifurcation, OrbitsResult
from camcli.errors import Status
from camcli.kernel.certify import Verdict
from camcli.words.border_collision import inequality_text
from camcli.words.events import event_words
from camcli.words.statuses import trouble

NEUTRAL = "det reaches 1 where nothing dissipates: orbits are centres or saddles, none attracts"
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
}


def end_words(end: Kind) -> str:
    """What ends a branch or a curve; most ends are known by their names."""
    return CURVE_ENDS.get(end, str(end))


def notes(found: OrbitsResult) -> list[str]:
    """What has no safe bracket, or could not be followed."""
    said = [
        f"{Bracket.UNRESOLVED}: {b.kind} of {b.label} near {b.value:.10g} has no safe bracket"
        for b in found.bifurcations
        if b.status == Bracket.UNRESOLVED
    ]
    for branch in found.branches:
        if Kind.LOST in branch.ends:
            value = branch.points[0 if branch.ends[0] == Kind.LOST else -1].value
            beyond = f"beyond {value:.10g}: unresolved there"
            said.append(f"branch {branch.number} could not be followed {beyond}")
        if Kind.FAULT in branch.ends:
            value = branch.points[0 if branch.ends[0] == Kind.FAULT else -1].value
            said += trouble(Status.FAULT, f" on branch {branch.number} beyond {value:.10g}")
    if found.question.curve and not any(curve.points for curve in found.curves):
        said.append(f"no {found.question.curve} was located, so there is no curve to continue")
    return said


def orbits_title(result: OrbitsResult) -> str:
    """The title of the orbits found at one speed."""
    return f"Periodic orbits at {result.question.rpm:.10g} rpm"


def curve_title(number: int, curve: Curve) -> str:
    """The title of a bifurcation in two parameters."""
    corner = f" at {curve.corner}" if curve.corner else ""
    return f"Curve {number}: {curve.kind} of {curve.label}{corner}"


def remarks(result: OrbitsResult) -> list[str]:
    """Sentences: absent labels, virtual orbits, corner impacts, what is impossible."""
    said = []
    absent = result.absent
    if absent is not None:
        text = f"{result.question.label} was not found at {absent.rpm:.10g} rpm"
        if absent.nearest is None:
            between = f"{absent.low:.10g} to {absent.high:.10g} rpm"
            said.append(f"{text}, nor at 24 speeds from {between}")
        else:
            speed, cause = absent.nearest
            nearest = f"the nearest speed at which it was found is {speed:.13g} rpm"
            said.append(f"{text}; {nearest} ({cause.replace('-', ' ')})")
    elif not result.orbits and not result.continua:
        said.append(f"no periodic orbit found at {result.question.rpm:.10g} rpm")
    said += [
        f"{c.label} exists with the impact anywhere from {degrees(c.start):.8g} to "
        f"{degrees(c.end):.8g} deg, a dwell: a continuum of orbits, none isolated, none attracting "
        "(both multipliers 1)"
        for c in result.continua
    ]
    if result.virtual:
        said.append(
            f"{len(result.virtual)} further roots at {result.question.rpm:.10g} rpm are virtual: "
            "they penetrate the cam or would pull (run.json)"
        )
    events: dict[str, str] = {}  # what several branches share is told once
    for b in result.bifurcations:
        if words := event_words(b):
            event = f"{b.kind} of {b.label} at {b.value:.10g}"
            events.setdefault(event, f": {' '.join(words)}{_rests_on(b)}")
    said += [event + words for event, words in events.items()]
    if result.proofs is not None:
        from camcli.words.proofs import proof_sentences  # it imports ball arithmetic

        said += proof_sentences(result)
    if result.branches:
        largest = max(orbit.det for branch in result.branches for orbit in branch.points)
        said.append(
            "Neimark-Sacker bifurcations are impossible: det = r^(2 impacts) exp(-b T/m) is at "
            f"most {largest:.6g} on these branches, below 1"
            if largest < 1.0
            else NEUTRAL
        )
    for number, c in enumerate(result.curves, 1):
        ends = zip(c.ends, c.limits, strict=True)
        why = [f"{end_words(end)} of {name}" if name else end_words(end) for end, name in ends]
        said.append(f"curve {number} ends: {'; '.join(why)}")
    return said


def _rests_on(b: Bifurcation) -> str:
    """The two inequalities that decide between the classes, with their numbers."""
    if b.corner_impact is None:
        return ""
    told = [
        f"{inequality_text(i)} {'holds' if i.holds else 'fails'} ({i.left:.6g})"
        for i in b.corner_impact.collision.inequalities[:2]
    ]
    return f" Rests on: {'; '.join(told)}."
