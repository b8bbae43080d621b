"""What `cam detach` found, in sentences.

A burst is the impacts after one departure; complete: they end in a rest; incomplete: they do not in
the turns followed.
"""

from collections.abc import Sequence
from itertools import groupby
from math import degrees, inf
from typing import NamedTuple

from camcli.analysis.bracketing import NARROW
from camcli.analysis.contact_loss.accumulation import CornerHit
from camcli.analysis.contact_loss.bursts import LiftOff, LiftOffKind, SettledMotion
from camcli.analysis.contact_loss.detachment import (
    AlwaysLost,
    CriticalQuantity,
    CriticalSpeed,
    NoStatement,
    Reason,
    SpeedStatus,
)
from camcli.analysis.contact_loss.force import ForceCurve
from camcli.analysis.contact_loss.hold import ABSURD, Hold, HoldStatus, Obstacle
from camcli.analysis.contact_loss.study import ContactLoss
from camcli.errors import Status, plural
from camcli.quantities import MM, Units
from camcli.words.in_print import newtons, range_of
from camcli.words.speeds import range_words


def sentences(result: ContactLoss) -> list[str]:
    """Every sentence on the loss of contact."""
    return [*plainly(result), *theory(result)]


def plainly(result: ContactLoss) -> list[str]:
    """The sentences that are always shown: contact always or never lost, and springs that fail."""
    detachment = result.detachment
    rpms = [speed.rpm for speed in result.speeds]
    first = detachment.first
    sentences = [_always(place) for place in detachment.always]
    if detachment.never:
        sentences.append("contact is never lost: the contact force stays positive at every speed")
    if first is not None:
        if first.rpm > max(rpms):
            held = f"contact is held at every speed asked for, up to {max(rpms):.10g} rpm"
            sentences.append(_or_open(held, first, first.low < max(rpms)))
        elif first.rpm < min(rpms):
            beyond = " and above" if len(rpms) > 1 else ""
            lost = f"contact is lost at every speed asked for, {min(rpms):.10g} rpm{beyond}"
            sentences.append(_or_open(lost, first, first.high > min(rpms)))
    failed = [hold for hold in result.holds if hold.status is not HoldStatus.OK]
    return sentences + [f"{way(hold)}: {spring(hold)}" for hold in failed]


def theory(result: ContactLoss) -> list[str]:
    """How contact is lost in each region and chatter changes with the speed, in sentences."""
    losses = result.detachment.losses
    never_lost = [loss.region.name for loss in losses if loss.opens.rpm == inf]
    opens_at_deg = {loss.region.name: degrees(loss.opens.theta) for loss in losses}
    sentences = []
    if never_lost and result.detachment.first is not None:
        sentences.append(f"contact is never lost in {', '.join(never_lost)}, at any speed")
    for lift_off in result.lift_offs:
        region = lift_off.region
        sentences.append(
            f"at {lift_off.rpm:.10g} rpm, a little above the opening of {region}, "
            + _lift_off(lift_off, opens_at_deg[region])
        )
    for hit in result.ended:
        before, after = hit.ends or (inf, inf)  # phases of the impact, rad
        sentences.append(
            f"at {hit.rpm:.10g} rpm impact {hit.impact} of the burst from {hit.burst} vanishes "
            f"before it reaches {hit.corner}: it was at {degrees(before):.6g} deg, and the next "
            f"contact is at {degrees(after):.6g} deg"
        )
    return sentences + [
        f"at {jump.rpm:.10g} rpm the end of the burst from {jump.burst} jumps over {jump.region}"
        for jump in result.jumps
    ]


def unresolved_notes(result: ContactLoss) -> list[str]:
    """The critical speeds whose brackets are not safe."""
    notes = []
    for speed in result.critical_speeds:
        if speed.status is SpeedStatus.UNRESOLVED:
            what = f"{speed.quantity} {speed.region} near {speed.rpm:.10g} rpm"
            notes.append(f"{speed.status}: {what} has no safe bracket")
    return notes


def _or_open(clause: str, first: CriticalSpeed, is_open: bool) -> str:
    """The clause, which of a measured cam may be true of the fitted cam alone.

    first: where contact is first lost; is_open: whether its range reaches into the speeds asked
    for.
    """
    is_exact = first.high - first.low <= 4.0 * NARROW * first.rpm  # as of a cam by a law
    if not is_open or is_exact:
        return clause
    between = range_words(first.low, first.high)
    return f"on the fitted cam {clause}; the error of its table leaves that open ({between})"


def _always(place: AlwaysLost) -> str:
    """Why contact is lost at every speed, as a clause, with what would help."""
    at = f"{degrees(place.theta):.10g} deg"
    if place.reason is Reason.KINK:
        drop = f"the cam's slope drops by {place.value:.6g} m/rad at {at}"
        return f"contact is lost at every speed: {drop} and throws the follower off"
    force = f"{place.value:.6g} N"
    cure = "more preload or weight"
    if place.value == 0.0:
        force = "zero"
        cure = "a preload, weight or a spring"
    return (
        f"contact is not held even at standstill: the contact force is {force} at {at}; give "
        f"the follower {cure}"
    )


def _lift_off(lift_off: LiftOff, opens_at: float) -> str:
    """How the follower leaves the cam and comes back, as a clause.

    opens_at: the phase (deg) at which the region opens.
    """
    corner = lift_off.corner
    lands = "does not land within two turns"
    if lift_off.landing < inf:
        after = degrees(lift_off.landing) - opens_at
        lands = f"lands {after:.3g} deg after {corner or 'that phase'}"
    if lift_off.rest < inf:
        lands += f", and rests again {degrees(lift_off.rest) - opens_at:.3g} deg after it"
    released = f"the follower is released {opens_at - degrees(lift_off.release):.3g} deg before"
    return {
        LiftOffKind.FLIES_OFF: (
            f"the follower flies off at {corner}, where the force drops: it {lands}"
        ),
        LiftOffKind.CAUGHT: f"{released} {corner}, where the force fades: it {lands}",
        LiftOffKind.WITHIN: f"{released} the weakest phase: it {lands}",
        LiftOffKind.UNSEEN: "no lift-off was seen: contact is lost at no phase after a rest",
    }[lift_off.kind]


def way(hold: Hold) -> str:
    """What is done about the present spring to hold contact, such as `a stiffer spring`."""
    if hold.quantity is CriticalQuantity.HOLD_STIFFNESS:
        return f"a {'stiffer' if hold.more else 'softer'} spring with the same preload"
    if hold.quantity is CriticalQuantity.HOLD_BOTH:
        return "another spring"
    if hold.status is HoldStatus.NOT_NEEDED:
        return "the same spring without preload"
    return f"{'more' if hold.more else 'less'} preload on the same spring"


def short_way(hold: Hold) -> str:
    """What is done about the present spring in two words, for a table."""
    if hold.quantity is CriticalQuantity.HOLD_STIFFNESS:
        return "stiffer spring" if hold.more else "softer spring"
    if hold.quantity is CriticalQuantity.HOLD_BOTH:
        return "another spring"
    if hold.status is HoldStatus.NOT_NEEDED:
        return "no preload"
    return "more preload" if hold.more else "less preload"


def spring(hold: Hold) -> str:
    """The stiffness (N/m) and preload (N) of a spring that holds contact, or why none does."""
    if hold.obstacle is not None:
        return _impossible(hold, hold.obstacle)
    if hold.status is HoldStatus.NOT_NEEDED:
        what = hold.quantity.removeprefix("hold_").replace("both", "spring")
        return f"no {what} is needed"
    if hold.status is HoldStatus.ABSURD:
        return (
            f"absurd: {hold.nose_n:.4g} N at the highest lift, over {ABSURD:g} times the present "
            "spring's; is the speed of --hold-to right?"
        )
    stiffness = f"stiffness {hold.stiffness:.10g} N/m"
    preload = f"preload {hold.preload:.10g} N"
    if hold.quantity is CriticalQuantity.HOLD_PRELOAD:
        return f"{preload}, stiffness as it is"
    if hold.quantity is CriticalQuantity.HOLD_STIFFNESS:
        return f"{stiffness}, preload as it is"
    return f"{stiffness} and {preload}"


def _impossible(hold: Hold, obstacle: Obstacle) -> str:
    """Why no spring of a kind holds contact."""
    if obstacle is Obstacle.KINK:
        return "impossible: at a downward kink the cam throws the follower off at any speed"
    if obstacle is Obstacle.SOLID:
        distance = f"{(hold.missing_n or 0.0) * MM:.3g} mm before the highest lift"
        return f"impossible: the spring, compressed so far, is solid {distance}"
    what = "the spring would pull"
    if obstacle is Obstacle.LIFT:
        what = f"{hold.missing_n:.4g} N are missing"
    where = f"{what} at {degrees(hold.theta or 0.0):.5g} deg, where"
    if hold.quantity is CriticalQuantity.HOLD_STIFFNESS:
        return (
            f"impossible with stiffness alone: {where} the cam's height is 0 or less and a spring "
            "does not press; take more preload"
        )
    return f"impossible: {where} c + precompression <= 0; raise detach.precompression_m"


def bursts_text(speed: SettledMotion) -> str:
    """The bursts of a turn, such as `A2 complete, A4 incomplete`; `none` where there are none.

    Each has the region of the cam that it begins in; that has no name where the burst goes on from
    an earlier turn, so that only `complete` or `incomplete` stands there. Where the simulation
    failed the text is its status.
    """
    if speed.status != Status.OK:
        return Status(speed.status).text
    texts = []
    for burst in speed.bursts:
        state = "complete" if burst.end is not None else "incomplete"
        texts.append(f"{burst.region} {state}".strip())
    return ", ".join(dict.fromkeys(texts)) or "none"


class BurstRange(NamedTuple):
    """Neighbouring speeds that behave alike: their bursts in words, both ends, and how many."""

    bursts: str
    from_rpm: float
    to_rpm: float
    speeds: int


def burst_ranges(result: ContactLoss) -> list[BurstRange]:
    """The settled motions over the speeds, in ranges of the same bursts."""
    ranges = []
    for text, group in groupby(result.speeds, bursts_text):
        speeds = list(group)
        ranges.append(BurstRange(text, speeds[0].rpm, speeds[-1].rpm, len(speeds)))
    return ranges


# --- beside the pictures


BURSTS_OF_THE_LOBE = (
    "The line follows bounces that begin where the force on the lobe is lost. Crosses are where "
    "those end that the opening blow or the seat begins"
)
OTHER_ENDS = "end of the bounces of opening blow or seat"


PANELS = {  # of a report: what a sentence calls them
    "max_gap_m": "largest gap",
    "max_impact_m_per_s": "hardest impact",
    "springs": "force with other springs",
    "surge": "surge",
    "machines": "machines within their tolerances",
    "shares": "which tolerance matters",
}


def on_second_page(panels: Sequence[str], motions: bool) -> str:
    """The sentence of a report's first page on what stands on the second.

    panels: their names; motions: whether the tables of the motions past the loss of contact stand
    there, too.
    """
    contents = ["the motion past the loss of contact"] if motions else []
    contents += [PANELS[name] for name in panels]
    return f"On the second page: {', '.join(contents)}."


def second_page(title: str) -> str:
    """The title of a report's second page."""
    return f"{title} (second page)"


def picture_title(study: ContactLoss) -> str:
    """The title, with the range of speeds."""
    rpms = [speed.rpm for speed in study.speeds]
    return f"Detachment and chattering, {range_of(min(rpms), max(rpms))} rpm"


def first_loss(study: ContactLoss, measured: bool) -> str:
    """The sentence of the title; of a measured cam with what the error of its table leaves."""
    first = study.detachment.first
    if first is None:
        never = study.detachment.never
        return "contact is never lost" if never else "contact is lost at every speed"
    rpm_digits = 4 if measured else 12  # a lift table deserves no more
    theta_digits = 4 if measured else 9
    rpm = f"{first.rpm:.{rpm_digits}g}"
    theta = f"{degrees(first.theta):.{theta_digits}g}"
    text = f"contact is first lost at {rpm} rpm, {theta} deg"
    if measured:
        text += f" ({range_words(first.low, first.high)} by the error of the table)"
    if study.completion:
        text += f"; chatter stops being complete at {study.completion[0].rpm:.4f} rpm"
    return text


def force_name(curve: ForceCurve, measured: bool) -> str:
    """A contact force over the turn, by its least value."""
    digits = 4 if measured else 6
    at = f"{degrees(curve.lowest_theta):.4g} deg"
    return f"{curve.rpm:.{digits}g} rpm: least {newtons(curve.lowest_n, 4)} at {at}"


def spring_name(hold: Hold | None, curve: ForceCurve, units: Units) -> str:
    """The name of a curve of forces in a picture: the spring, and its least contact force.

    hold: the spring that holds contact, None for the present one.
    """
    least = f"least {newtons(curve.lowest_n, 4)}"
    if hold is None:
        return f"present spring: {least}"
    return f"{units.stiffnesses(hold.stiffness or 0.0, 4)}, preload {hold.preload:.4g} N: {least}"


def proof_name(proved: CriticalSpeed | CornerHit) -> str:
    """What a proof is about."""
    if isinstance(proved, CornerHit):
        return f"impact {proved.impact} on corner {proved.corner} at {proved.rpm:.10g} rpm"
    return f"the first detachment at {proved.rpm:.10g} rpm"


NO_STATEMENT = {
    NoStatement.LASH: "a certificate has no words for the seat of a cam with lash",
    NoStatement.FITTED: "the pieces fitted to a table meet only but for roundings, and where they "
    "do not the contact force of a follower at rest is not defined",
    NoStatement.KINKED: "the slope of this cam jumps, and there the contact force of a follower at "
    "rest is not defined",
    NoStatement.NO_SPEED: "there is no speed up to which contact holds and beyond which it is lost",
    NoStatement.INSIDE: "contact is first lost within a smooth part of this cam, and the statement "
    "of a certificate names an end of one as the place",
}


def proved_words(count: int, left_out: list[str], why: NoStatement | None = None) -> str:
    """How much of the loss of contact was proved.

    count: statements; left_out: the names of what was not proved; why: the first detachment has no
    statement, None where it has one.
    """
    text = f"proved: {plural(count, 'statement')}, with certificates in proof.json"
    if count == 0:
        text = "nothing was proved of the loss of contact"
        if why is not None:
            text += f": {NO_STATEMENT[why]}"
    return f"{text}; not proved: {', '.join(left_out)}" if left_out else text
