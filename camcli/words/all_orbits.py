"""What is said of all orbits up to a size: that they are all, or why that is not shown."""

from collections.abc import Iterator, Sequence
from math import degrees, pi, sqrt

from camcli.analysis.orbits.all_orbits import AllOrbits, Cover, Failure
from camcli.analysis.orbits.study import OrbitsResult
from camcli.errors import plural
from camcli.system import Follower, omega_of
from camcli.words.in_print import label_text

FAILED = {
    Failure.FLIGHTS: "the spring rests above a part of the cam, so that flights may be long",
    Failure.STOP: "the stop presses too little, so that flights may be long: the clearance would "
    "have to lie below minus the amplitude of the motion without the stop",
    Failure.CAM: "the slope of the cam jumps, or the cam has no closed formula",
    Failure.BOXES: "more or smaller boxes would be needed, or orbits are born or not isolated here",
    Failure.WORK_BUDGET: "the work budget is spent",
    Failure.LOSSLESS: "with restitution 1 nothing bounds the rates of the impacts",
    Failure.PLASTIC: "with restitution 0 no impact leaves the cam at a rate above zero",
}
REASONS = {  # why a box holds no orbit, by `exact.phase_cover.Exclusion`
    "order": "the other flight is longer",
    "flight": "no orbit has such a flight",
    "impact": "the rates of an impact do not agree",
    "newton": "a Newton step leads out of the box",
}
HOLDS_ORBIT = "the box holds one orbit, which is known"
NOT_PROVED = "one of those found is not proved itself"


def failure_words(failure: Failure) -> str:
    """Why it is not shown that the orbits are all."""
    return FAILED[failure]


def size_words(found: AllOrbits) -> str:
    """Up to which size orbits were looked for."""
    impacts = "1 impact" if found.impacts == 1 else f"1 to {found.impacts} impacts"
    turns = "1 turn" if found.turns == 1 else f"1 to {found.turns} turns"
    return f"{impacts} in {turns}"


def cover_words(cover: Cover) -> str:
    """What a cover is of, and how many boxes it has."""
    impacts = plural(cover.impacts, "impact")
    turns = plural(cover.turns, "turn")
    return f"{impacts} in {turns}: {plural(cover.boxes, 'box')}"


def cover_heading(result: OrbitsResult, found: AllOrbits) -> tuple[str, str, str]:
    """(title, caption, words below the title) of the picture of covers."""
    rpm = result.question.rpm
    title = f"All orbits with {size_words(found)} at {rpm:.10g} rpm"
    drawn = [cover for cover in found.covers if cover.drawn]
    others = sum(cover.boxes for cover in found.covers if not cover.drawn)
    caption = (
        f"boxes of the phases of two impacts; {plural(others, 'box')} of other covers not drawn. "
        f"{_range_sentence(found.follower, rpm)}"
    )
    return title, caption, " ".join(_not_drawn(found, drawn))


def _range_sentence(follower: Follower, rpm: float) -> str:
    """Which flights are drawn: the longer one of the two, and none is longer than pi/f."""
    longest = longest_flight(follower, rpm)
    most = "" if longest is None else f". No flight is longer than π/f = {longest:.1f} deg"
    return f"The first flight is the longer one: it takes half of the turns or more{most}"


def longest_flight(follower: Follower, rpm: float) -> float | None:
    """pi/f in deg of the cam, f the own frequency by the angle; None where no spring swings."""
    omega = omega_of(rpm)
    decay = follower.damping / (2.0 * follower.mass * omega)
    frequency_squared = follower.stiffness / (follower.mass * omega**2) - decay**2
    return degrees(pi / sqrt(frequency_squared)) if frequency_squared > 0.0 else None


def _not_drawn(found: AllOrbits, drawn: Sequence[Cover]) -> Iterator[str]:
    """The orbits that are in none of the covers that are drawn, and how many impacts they have."""
    for orbit in found.orbits:
        impacts = int(sum(orbit.symbols))
        # a cover has an orbit that goes round once or more often in its impacts and turns
        in_a_cover = any(cover.impacts * orbit.turns == impacts * cover.turns for cover in drawn)
        if not in_a_cover:
            has = plural(impacts, "impact")
            yield f"{label_text(orbit.label)} has {has} and is not drawn."


def why_not_all(result: OrbitsResult, found: AllOrbits) -> str:
    """Why it is not shown that the orbits are all; empty where it is."""
    if found.failure is not None:
        return FAILED[found.failure]
    proofs = result.proofs
    all_proved = proofs is not None and all(proof.proved for proof in proofs.orbits)
    return "" if all_proved else NOT_PROVED


def all_sentences(result: OrbitsResult, found: AllOrbits) -> Iterator[str]:
    """Whether the orbits that were found are all."""
    at = f"{result.question.rpm!r} rpm"
    why = why_not_all(result, found)
    if why:
        yield f"not proved: the orbits with {size_words(found)} at {at} are all found: {why}"
        return
    boxes = sum(cover.boxes for cover in found.covers)
    hold = "holds" if boxes == 1 else "hold"
    names = ", ".join(
        f"{orbit.label} {'stable' if orbit.stable else 'unstable'}" for orbit in result.orbits
    )
    yield (
        f"proved: the orbits without rest that have {size_words(found)} at {at} are these "
        f"{len(result.orbits)}: {names or 'none'} ({plural(boxes, 'box')} {hold} no other)"
    )


def all_notes(result: OrbitsResult, found: AllOrbits) -> list[str]:
    """What makes a run incomplete."""
    why = why_not_all(result, found)
    return [f"it is not proved that the orbits are all: {why}"] if why else []
