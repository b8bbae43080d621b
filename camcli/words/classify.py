"""What `cam classify` says of the motions it found."""

from collections import Counter
from collections.abc import Iterator, Sequence
from math import inf, isfinite

from camcli.analysis.classify import ClassifiedMotion
from camcli.analysis.labels import APERIODIC, CONTACT, UNDECIDED
from camcli.analysis.sweep import status_name
from camcli.errors import Status, plural
from camcli.words.after_rest import decided_notes
from camcli.words.in_print import one_of, range_of, valued, with_error
from camcli.words.speeds import at_speed
from camcli.words.statuses import counted


def motions_title(motions: list[ClassifiedMotion], key: str, ranges: int, kind: str = "") -> str:
    """The title of the ranges in which all motions have one label; kind: of the cam."""
    of_key = "" if key == "rpm" else f" over {key}"
    title = plural(len(motions), "motion") + of_key + at_speed([key], motions[0].rpm, kind)
    return f"{title}, {plural(ranges, 'range')} of one label"


def remarks(motions: list[ClassifiedMotion], key: str = "rpm", verbose: bool = True) -> list[str]:
    """Sentences on what ball arithmetic decided, and on what is undecided.

    key: what is varied. verbose: also on exponents, rests, and how long motions were followed.
    """
    sentences = _on_exponents(motions) if verbose else []
    sentences += decided_notes((motion.holds_for for motion in motions), "motion")
    if verbose:
        unsolved = [
            motion for motion in motions if motion.orbit is None and motion.status == Status.OK
        ]
        sentences += _unsolved_notes(unsolved, key)
    undecided = [
        motion.value for motion in motions if motion.label == UNDECIDED and motion.fault is None
    ]
    if undecided:
        sentences.append(
            f"the motion at {counted(undecided, key)} is undecided: no orbit up to 64 turns could "
            "be solved and no positive exponent be shown, or doubles lose the motion between one "
            "rest and the next"
        )
    return sentences


def exponent_text(measured: Sequence[tuple[float, float]]) -> str:
    """Exponents as a cell: one with its error, or the range of several.

    measured: (exponent, its standard error) of each motion; the error of a solved orbit is zero.
    """
    if len(measured) == 1:
        value, error = measured[0]
        return with_error(value, error)
    if not measured:
        return ""
    values = [value for value, _ in measured]
    least = f"{min(values):.4g}"
    largest = f"{max(values):.4g}"
    return least if least == largest else f"{least} to {largest}"


def _on_exponents(motions: list[ClassifiedMotion]) -> list[str]:
    """Sentences: how well the sum rule holds, and what a rest does to exponents."""
    sentences = []
    known = [motion.exponents for motion in motions if motion.exponents is not None]
    defects = [
        abs(exponents.defect)
        for exponents in known
        if isfinite(exponents.largest) and isfinite(exponents.second)
    ]
    if defects:
        sentences.append(
            "both exponents of a motion add up to 2 ln r times its impacts per turn, less b T/m: "
            f"within {max(defects):.1g} in {plural(len(defects), 'motion')}"
        )
    if any(exponents.largest == -inf for exponents in known):
        sentences.append(
            "where the follower rests, both exponents are -inf: a rest wipes out every difference "
            "between two motions"
        )
    return sentences


def _unsolved_notes(unsolved: list[ClassifiedMotion], key: str) -> Iterator[str]:
    """What the records of motions without a solved orbit show of complete chatters.

    A rest forgets all, so a chaotic motion that comes to one repeats itself from there on, however
    long it takes. None in n turns bounds their rate by 3/n with a probability of 95 % (exp(-3)).
    """
    followed = [  # turns in which an aperiodic motion never rested
        motion.watched
        for motion in unsolved
        if motion.label == APERIODIC and motion.watched is not None
    ]
    if followed:
        fewest = min(followed)
        yield (
            f"a motion called aperiodic was followed for {plural(fewest, 'turn')} or more, and "
            "neither settled nor rested: what would end it is rarer than once in "
            f"{plural(max(1, fewest // 3), 'turn')} (95 %)"
        )
    for motion in unsolved:
        if motion.chatters and motion.watched is not None:
            yield (
                f"{key} = {motion.value:.10g}: the first complete chatter comes after "
                f"{plural(motion.watched, 'turn')}; after a rest the motion is always the same, "
                "and it could not be followed to the next rest"
            )
        elif motion.chatters:
            turns = motion.record.periods
            yield (
                f"{key} = {motion.value:.10g}: complete chatter in {motion.chatters} of "
                f"{plural(turns, 'turn')}, one in some {turns / motion.chatters:.3g}; after a rest "
                "the motion is always the same, and it could not be followed to the next rest"
            )


# --- beside the pictures

FORGETS = "largest exponent −∞"  # of a motion with rests
ALL_FORGET = "no largest exponent is finite, and none is drawn"
OTHERS = (APERIODIC, UNDECIDED, CONTACT)


def range_text(motions: Sequence[ClassifiedMotion], key: str, kind: str) -> str:
    """The values at which the motions are, from the first to the last; kind: of the cam."""
    values = range_of(motions[0].value, motions[-1].value)
    return valued(key, values, motions[0].rpm, kind)


def picture_title(values: int, where: str, key: str) -> str:
    """The title of the picture.

    values: how many values of the key there are, 0 where all motions are at one of them; where:
    these values, see `range_text`.
    """
    many = f"{plural(values, one_of(key))}, " if values else ""
    return f"Motions at {many}{where}"


def motions_at(one: bool, where: str) -> str:
    """What the axis counts where all motions are at one value; where: it, see `range_text`.

    one: whether there is only one motion.
    """
    return f"{'motion' if one else 'motions, numbered,'} at {where}"


def kind(motion: ClassifiedMotion) -> str:
    """In a word or two what a motion is."""
    if motion.label in OTHERS:
        return motion.label
    if motion.orbit is None:
        return UNDECIDED
    return "periodic with rests" if rests(motion) else "periodic"


def rests(motion: ClassifiedMotion) -> bool:
    """True for a solved orbit that leaves the cam and rests on it."""
    return motion.orbit is not None and motion.orbit.resting and bool(motion.orbit.theta)


def kinds_words(motions: Sequence[ClassifiedMotion]) -> str:
    """How many motions are of each kind, and of how many something is not known."""
    kinds = Counter(map(kind, motions))
    words = [f"{name} ({count})" for name, count in sorted(kinds.items())]
    troubles = Counter(
        status_name(motion.status) for motion in motions if motion.status != Status.OK
    )
    words += [f"not ok: {name} ({count})" for name, count in sorted(troubles.items())]
    unknown = sum(motion.exponents is None for motion in motions)
    if unknown:
        words.append(f"exponent not known for {unknown} of {plural(len(motions), 'motion')}")
    return "; ".join(words)
