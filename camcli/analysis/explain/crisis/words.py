"""What is said of a crisis: short sentences, speeds with the digits that their errors allow."""

from __future__ import annotations

from math import ceil, degrees, inf, isfinite, log10

from camcli.analysis.explain.crisis.approach import REACHED, Approach
from camcli.analysis.explain.crisis.meeting import Contact, Meeting
from camcli.analysis.explain.crisis.runs import Carried
from camcli.analysis.orbits.orbit import PeriodicOrbit
from camcli.cams.regions import Corner

MOST_DECIMALS = 9  # of a speed in rpm


def speed(rpm: float, error: float) -> str:
    """The speed up to the decimal place of the error's first digit, without a unit."""
    if not isfinite(error) or error <= 0.0:
        return f"{rpm:.10g}"
    return f"{rpm:.{min(max(ceil(-log10(error)), 0), MOST_DECIMALS)}f}"


def seen_in_runs(carried: Carried) -> str:
    """Where runs first leave."""
    stays, leaves = carried.bracket
    return (
        f"Runs of {carried.turns} turns carried from {carried.near:.10g} rpm first leave the "
        f"attractor's range at {speed(leaves, abs(leaves - stays))} rpm."
    )


def saddles_seen(contact: Contact) -> list[str]:
    """How many saddles were looked at."""
    said = [f"Saddles seen: {contact.inside} in the attractor, {contact.beyond} beyond it."]
    if contact.lost:
        said.append(f"{contact.lost} of them could not be followed and are left out.")
    return said


def contact_said(contact: Contact, saddle: PeriodicOrbit | None) -> list[str]:
    """The saddle met first, as it is there, the ones met later, and those that are not met."""
    first, said = contact.first, []
    if first is not None and saddle is not None:
        said.append(
            f"The attractor meets the stable manifold of {saddle.label} (larger multiplier "
            f"{saddle.multipliers[0].real:.4g}) at {_speed_of(first)} rpm."
        )
    for meeting in contact.met:
        if meeting is not first:
            label = meeting.folds.saddle.label
            said.append(f"{label} would be met later, at {_speed_of(meeting)} rpm.")
    unmet = "leads out, but no fold was seen to touch its stable manifold."
    return said + [f"{orbit.label} {unmet}" for orbit in contact.unmet]


def _speed_of(meeting: Meeting) -> str:
    return speed(meeting.tangency.rpm, meeting.tangency.error)


def fold_said(corner: Corner | None) -> str:
    """Which kind of fold touches."""
    if corner is not None:
        return f"The fold that touches is the image of an impact at corner {corner.name}."
    return "The fold that touches is smooth."


def approach_said(found: Approach, is_cause: bool) -> list[str]:
    """What impacts and flights reach before the change or near it, and whether that causes it."""
    said = _reached_before(found)
    if not found.kind:
        return said + _not_reached(found)
    if found.corner is None:
        what, place = "Flights come down towards the cam", "touch it"
    else:
        what, place = f"Impacts draw near to corner {found.corner.name}", "reach it"
    if is_cause:
        return [*said, f"{what} and {place} there for the first time, by a line through two runs."]
    might = f"{what} too and might {place} about there."
    return [*said, f"{might} That is only extrapolated; the tangency is solved."]


def _reached_before(found: Approach) -> list[str]:
    """Corners and contacts of no force that belong to the attractor before the change."""
    said = []
    names = [corner.name for corner, _, distance in found.corners if distance <= REACHED]
    if names:
        said.append(f"Impacts reach {_corners(names)} already before it.")
    if min(found.gap) <= found.low:
        said.append("Contacts of hardly any force occur already before it.")
    return said


def _not_reached(found: Approach) -> list[str]:
    """How far everything else stays away."""
    what = []
    others = [(off, corner.name) for corner, _, off in found.corners if off > REACHED]
    if others:
        off, name = min(others)
        what.append(f"no impact comes nearer than {degrees(off):.2g} deg to corner {name}")
    lowest = min(found.gap)
    if lowest == inf:
        what.append("no flight has a low gap")
    elif lowest > found.low:
        what.append(f"no gap inside a flight is lower than {1000.0 * lowest:.2g} mm")
    if not what:
        return []
    text = " and ".join(what)
    verdict = "neither causes it" if len(what) > 1 else "this does not cause it"
    return [f"{text[0].upper()}{text[1:]}: {verdict}."]


def _corners(names: list[str]) -> str:
    if len(names) == 1:
        return f"corner {names[0]}"
    return f"corners {', '.join(names[:-1])} and {names[-1]}"
