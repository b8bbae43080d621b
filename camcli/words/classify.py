"""What `cam classify` says of the motions it found."""

from collections.abc import Iterator
from math import inf, isfinite

from camcli.analysis.classify import Motion
from camcli.analysis.labels import APERIODIC, UNDECIDED
from camcli.errors import Status, plural
from camcli.words.after_rest import decided_notes
from camcli.words.speeds import at_speed
from camcli.words.statuses import counted


def motions_title(motions: list[Motion], key: str, ranges: int) -> str:
    """The title of the ranges in which all motions have one label."""
    title = plural(len(motions), "motion") + at_speed([key], motions[0].rpm)
    return f"{title}, {plural(ranges, 'range')} of one label"


def remarks(motions: list[Motion], key: str = "rpm") -> list[str]:
    """Sentences: the sum rule, sticking, what is undecided."""
    said = []
    known = [m.exponents for m in motions if m.exponents]
    defects = [abs(e.defect) for e in known if isfinite(e.largest) and isfinite(e.second)]
    if defects:
        said.append(
            "sum of the exponents minus (2 ln r) impacts per turn + b T/m: at most "
            f"{max(defects):.1g} over {len(defects)} motions"
        )
    if any(e.largest == -inf for e in known):
        said.append(
            "where the follower rests on the cam both exponents are -inf: every difference between "
            "two motions is forgotten"
        )
    said += decided_notes((m.holds_for for m in motions), "motions")
    said += _unsolved_notes([m for m in motions if m.orbit is None and m.status == Status.OK], key)
    undecided = [m.value for m in motions if m.label == UNDECIDED and m.fault is None]
    if undecided:
        said.append(
            f"undecided at {counted(undecided, key)}: no orbit up to 64 turns could be solved and "
            "no positive exponent shown, or a rest is forgotten before the next one"
        )
    return said


def _unsolved_notes(unsolved: list[Motion], key: str) -> Iterator[str]:
    """What the records of motions without an orbit show of complete chatters.

    A rest forgets all, so a chaotic motion that comes to one repeats itself from there on, however
    long it takes. None in n turns bounds their rate by 3/n with a probability of 95 % (exp(-3)).
    """
    never = [m.watched for m in unsolved if m.label == APERIODIC and m.watched is not None]
    if never:
        yield (
            f"aperiodic was shown over {min(never)} turns or more, in which the motion neither "
            "settled nor rested: what would end it is rarer than once in "
            f"{max(1, min(never) // 3)} turns (95 %)"
        )
    for m in unsolved:
        if m.chatters and m.watched is not None:
            yield (
                f"{key} = {m.value:.10g}: the first complete chatter comes after {m.watched} "
                "turns; after a rest the motion is always the same one, which could not be "
                "followed to the next rest"
            )
        elif m.chatters:
            turns = m.record.periods
            yield (
                f"{key} = {m.value:.10g}: complete chatter in {m.chatters} of {turns} turns, one "
                f"in some {turns / m.chatters:.3g}; after a rest the motion is always the same "
                "one, which could not be followed to the next rest"
            )
