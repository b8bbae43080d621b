"""Why a diagram changes, in sentences."""

from collections.abc import Sequence
from math import degrees, floor, isfinite, log10

from camcli.analysis.contact_loss.accumulation import CornerHit
from camcli.analysis.contact_loss.detachment import CriticalQuantity, CriticalSpeed
from camcli.analysis.explain.changes import (
    BASIN,
    MOST_CRISES,
    UNEXPLAINED,
    CriticalEvent,
    LabelChange,
)
from camcli.analysis.explain.crisis import Crisis, CrisisKind
from camcli.analysis.orbits.kinds import Kind
from camcli.analysis.orbits.study import Bifurcation
from camcli.errors import Status, is_or_are, shown
from camcli.words.events import event_words
from camcli.words.speeds import number_range, speed_text
from camcli.words.statuses import CAUSES


def event_sentence(event: CriticalEvent) -> str:
    """What happens at a critical speed."""
    source = event.source
    if isinstance(source, Bifurcation):
        return _bifurcation(source)
    if isinstance(source, Crisis):
        return " ".join(crisis_sentences(source))
    if isinstance(source, CornerHit):
        return f"impact {source.impact} after lift-off lands on corner {source.corner}"
    if isinstance(source, CriticalSpeed):
        if source.quantity is CriticalQuantity.FIRST_DETACHMENT:
            return f"the contact force reaches zero at {degrees(source.theta):.6g} deg"
        if source.quantity is CriticalQuantity.ACCUMULATION:
            return f"impacts accumulate exactly at corner {source.region}"
        return "the chatter ends where the next one begins: it is no longer complete"
    if source is None:
        return event.kind
    # what is left is the end of an orbit that rests on the cam
    end = f"{event.label} ends ({event.kind})"
    if source.beyond is None:
        return f"{end}, and what a run beyond it settles on is not known"
    return f"{end}, and a run beyond it settles on {source.beyond.label}"


def _bifurcation(bifurcation: Bifurcation) -> str:
    """What happens to a motion at a bifurcation, as a clause."""
    label = bifurcation.label
    what = {
        Kind.PERIOD_DOUBLING: f"a multiplier of {label} passes -1",
        Kind.FOLD: f"{label} meets an unstable orbit and both vanish",
        Kind.CORNER_IMPACT: f"an impact of {label} reaches corner {bifurcation.corner}",
        Kind.GRAZING: f"{label} ceases to be a motion",
    }.get(bifurcation.kind, bifurcation.kind)
    more = " ".join(event_words(bifurcation))
    return f"{what}: {more}" if more else what


def change_sentence(change: LabelChange, events: Sequence[CriticalEvent]) -> str:
    """Why the diagram changes; where that is not known, what was tried.

    events: all of the range.
    """
    if change.cause == BASIN and change.persists:
        return "; ".join(_coexists(label, events) for label in change.persists)
    on_crisis = [] if change.crisis is None else crisis_sentences(change.crisis)
    if change.cause == BASIN:
        lives_on = "the chaotic attractor lives on at both speeds: the start changes basins."
        return " ".join([lives_on, *on_crisis])
    if change.status != Status.OK:
        return f"{change.status.text}: {CAUSES[change.status]}"
    if change.cause == UNEXPLAINED:
        return _unexplained(change, on_crisis)
    clauses = []
    for event in change.events:
        if isinstance(event.source, (Bifurcation, CriticalSpeed, CornerHit)):  # has its own line
            clauses.append(f"{event.kind} at {event.rpm:.10g} rpm ({event.label})")
        else:
            clauses.append(event_sentence(event))
    return "; ".join(clauses)


def _unexplained(change: LabelChange, on_crisis: list[str]) -> str:
    """What was tried to explain a change; on_crisis: sentences on the search for a crisis."""
    if change.persists:
        labels = " and ".join(change.persists)
        attract = "attracts" if len(change.persists) == 1 else "attract"
        sentence = (
            f"{labels} {attract} at both speeds; whether the chaos beside lives on at both is not "
            "known"
        )
    else:
        sentence = (
            "no bifurcation of a solved branch lies between them, and no branch through both is "
            "stable"
        )
    if on_crisis:
        sentence = " ".join([f"{sentence}.", *on_crisis])
    if not change.may_search:
        sentence += f"; crises are looked for in the first {MOST_CRISES} changes only"
    return sentence


def change_line(change: LabelChange, events: Sequence[CriticalEvent], verbose: bool = True) -> str:
    """The range of a change, its cause, and where that is; verbose: and how that was found.

    events: all of the range of speeds.
    """
    speeds = f"{number_range(change.low, change.high)} rpm"
    if verbose:
        return f"{speeds}, {change.cause}: {change_sentence(change, events)}"
    events_of_change = [
        f"at {speed_text(event.rpm, event.error)} rpm, {shown(event.label)}"
        for event in change.events
    ]
    return f"{speeds}: {'; '.join([change.cause, *events_of_change])}"


def _coexists(label: str, events: Sequence[CriticalEvent]) -> str:
    """That an orbit exists on both sides, so that the basin changes; and where the orbit changes.

    events: all of the range.
    """
    own_events = [
        f"{event.kind} at {event.rpm:.10g} rpm" for event in events if event.label == label
    ]
    where = "does not change in the range"
    if own_events:
        where = f"changes at: {', '.join(own_events)}"
    return f"{label} exists and attracts at both speeds: the start changes basins; {label} {where}"


def crisis_sentences(crisis: Crisis) -> list[str]:
    """What is said of a search for a crisis: the runs, the saddles, and the fold that touches."""
    near = f"carried from {crisis.near:.10g} rpm"
    if crisis.kind is CrisisKind.NOT_CHAOTIC:
        return [f"The motion {near} is not chaotic."]
    if crisis.kind is CrisisKind.STAYS:
        return [
            f"Nothing leaves the attractor {near}: a run of {crisis.turns} turns stays in its "
            f"range at {crisis.rpm:.10g} rpm."
        ]
    stays, leaves = crisis.bracket
    sentences = [
        f"Runs of {crisis.turns} turns {near} first leave the attractor's range at "
        f"{speed_text(leaves, abs(leaves - stays))} rpm.",
        f"Saddles seen: {crisis.inside} in the attractor, {crisis.beyond} beyond it.",
    ]
    if crisis.lost:
        are = is_or_are(crisis.lost)
        sentences.append(f"{crisis.lost} of them could not be followed and {are} left out.")
    for meeting in crisis.met:
        orbit = meeting.orbit
        at = f"at {speed_text(meeting.rpm, meeting.error)} rpm"
        if meeting is crisis.met[0]:
            sentences.append(
                f"The attractor meets the stable manifold of {orbit.label} (larger multiplier "
                f"{orbit.multipliers[0].real:.4g}) {at}."
            )
        else:
            sentences.append(f"{orbit.label} would be met later, {at}.")
    sentences += [
        f"{orbit.label} leads out, but no fold was seen to touch its stable manifold."
        for orbit in crisis.unmet
    ]
    if crisis.met:
        corner = crisis.corner
        fold = f"the image of an impact at corner {corner.name}" if corner else "a smooth fold"
        sentences.append(f"What touches the manifold is {fold}.")
    return sentences


# --- beside the pictures

DIGITS = 9


def event_name(event: CriticalEvent) -> str:
    """The name of an event in a picture, such as `period doubling` or `corner impact at b`."""
    words = event.kind.replace("-", " ").replace("+", ", ")
    place = event.corner  # a corner such as b, or a region such as A2
    if not place:
        return words
    is_region = not place.islower()
    if is_region or words.endswith("corner"):
        return f"{words} {place}"
    return f"{words} at {place}"


def event_speed(event: CriticalEvent) -> str:
    """The speed of an event to DIGITS digits; fewer, with its error, where it is less certain."""
    digits_before_point = 1 + floor(log10(event.rpm)) if event.rpm > 0.0 else 1
    decimals = max(0, DIGITS - digits_before_point)
    if not isfinite(event.error) or event.error < 10.0**-decimals:
        return f"{event.rpm:.{decimals}f}"
    decimals = max(0, -floor(log10(event.error)))
    return f"{event.rpm:.{decimals}f} ± {event.error:.{decimals}f}"


def unnumbered(count: int) -> str:
    """The events that the list leaves out."""
    return f"and {count} more, drawn without a number, listed in run.json"
