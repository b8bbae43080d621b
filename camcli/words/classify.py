"""What `cam classify` says of the motions it found."""

from collections import Counter
from collections.abc import Iterator, Sequence
from math import inf, isfinite

from camcli.analysis.classify import ClassifiedMotion
from camcli.analysis.labels import APERIODIC, CONTACT, UNDECIDED
from camcli.analysis.sweep import status_name
from camcli.errors import Status, plural
from camcli.words.after_rest import decided_notes
from camcli.words.in_print import number_text, one_of, valued, with_error
from camcli.words.speeds import at_speed
from camcli.words.statuses import counted


def motions_title(motions: list[ClassifiedMotion], key: str, ranges: int, kind: str = "") -> str:
    """The title of the ranges in which all motions have one label; kind: of the cam."""
    of_key = "" if key == "rpm" else f" over {key}"
    title = plural(len(motions), "motion") + of_key + at_speed([key], motions[0].rpm, kind)
    return f"{title}, {plural(ranges, 'range')} of one label"


def remarks(motions: list[ClassifiedMotion], key: str = "rpm", verbose: bool = True) -> list[str]:
    """Sentences on what is undecided; verbose: and on exponents, rests and how long was watched."""
    sentences = _on_exponents(motions) if verbose else []
    sentences += decided_notes((m.holds_for for m in motions), "motion")
    if verbose:
        unsolved = [m for m in motions if m.orbit is None and m.status == Status.OK]
        sentences += _unsolved_notes(unsolved, key)
    undecided = [m.value for m in motions if m.label == UNDECIDED and m.fault is None]
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
        ((value, error),) = measured
        return with_error(value, error)
    ends = [f"{end(value for value, _ in measured):.4g}" for end in (min, max)] if measured else []
    return " to ".join(dict.fromkeys(ends))


def _on_exponents(motions: list[ClassifiedMotion]) -> list[str]:
    """Sentences: the sum rule, and what a rest does to exponents."""
    sentences = []
    known = [m.exponents for m in motions if m.exponents]
    defects = [abs(e.defect) for e in known if isfinite(e.largest) and isfinite(e.second)]
    if defects:
        sentences.append(
            "both exponents of a motion add up to 2 ln r times its impacts per turn, less b T/m: "
            f"within {max(defects):.1g} in {plural(len(defects), 'motion')}"
        )
    if any(e.largest == -inf for e in known):
        sentences.append(
            "where the follower rests, both exponents are -inf: a rest wipes out every difference "
            "between two motions"
        )
    return sentences


def _unsolved_notes(unsolved: list[ClassifiedMotion], key: str) -> Iterator[str]:
    """What the records of motions without an orbit show of complete chatters.

    A rest forgets all, so a chaotic motion that comes to one repeats itself from there on, however
    long it takes. None in n turns bounds their rate by 3/n with a probability of 95 % (exp(-3)).
    """
    never = [m.watched for m in unsolved if m.label == APERIODIC and m.watched is not None]
    if never:
        yield (
            f"a motion called aperiodic was followed for {min(never)} turns or more, and neither "
            "settled nor rested: what would end it is rarer than once in "
            f"{max(1, min(never) // 3)} turns (95 %)"
        )
    for m in unsolved:
        if m.chatters and m.watched is not None:
            yield (
                f"{key} = {m.value:.10g}: the first complete chatter comes after {m.watched} "
                "turns; after a rest the motion is always the same, and it could not be followed "
                "to the next rest"
            )
        elif m.chatters:
            turns = m.record.periods
            yield (
                f"{key} = {m.value:.10g}: complete chatter in {m.chatters} of {turns} turns, one "
                f"in some {turns / m.chatters:.3g}; after a rest the motion is always the same, "
                "and it could not be followed to the next rest"
            )


# --- beside the pictures

FORGETS = "−∞: the follower rests, which forgets every difference"
OTHERS = (APERIODIC, UNDECIDED, CONTACT)


def range_text(motions: Sequence[ClassifiedMotion], key: str, kind: str) -> str:
    """The values at which the motions are, from the first to the last; kind: of the cam."""
    ends = dict.fromkeys(number_text(motions[k].value) for k in (0, -1))
    return valued(key, " to ".join(ends), motions[0].rpm, kind)


def picture_title(values: int, where: str, key: str) -> str:
    """values: how many there are, 0 where all motions are at one; where: see `range_text`."""
    many = f"{values} {one_of(key)}s, " if values else ""
    return f"Motions at {many}{where}"


def motions_at(one: bool, where: str) -> str:
    """What the axis counts where all motions are at one speed."""
    return f"{'motion' if one else 'motions, numbered,'} at {where}"


def kind(motion: ClassifiedMotion) -> str:
    """In a word or two what a motion is."""
    if motion.label in OTHERS or motion.orbit is None:
        return motion.label if motion.label in OTHERS else UNDECIDED
    return "periodic with rests" if rests(motion) else "periodic"


def rests(motion: ClassifiedMotion) -> bool:
    """True for a solved orbit that leaves the cam and rests on it."""
    return motion.orbit is not None and motion.orbit.resting and bool(motion.orbit.theta)


def kinds_words(motions: Sequence[ClassifiedMotion]) -> str:
    """How many motions are of each kind, and of how many something is not known."""
    kinds = Counter(map(kind, motions))
    words = [f"{name} ({count})" for name, count in sorted(kinds.items())]
    troubles = Counter(status_name(m.status) for m in motions if m.status != Status.OK)
    words += [f"not ok: {name} ({count})" for name, count in sorted(troubles.items())]
    if unknown := sum(m.exponents is None for m in motions):
        words.append(f"exponent not known for {unknown} of {len(motions)} motions")
    return "; ".join(words)
